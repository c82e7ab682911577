"""Signatures of kernels, and the check of arguments in front of every call.

Machine code takes addresses and checks no types. So an argument either has the type of its letters,
or is cast to it, or is refused here, for all runners alike.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

# ---- plain runner ----------------------------------------
# Kernels as plain Python: slow, every index checked, every line open to a debugger.


class PlainRunner:
    """Runs kernels as they are written.

    An array that a kernel only reads is handed over read-only, so that numpy itself proves
    the stars of its signature.

    Parameters
    ----------
    reason : str
        Why, for people.
    """

    compiles = False

    def __init__(self, reason: str) -> None:
        self._reason = reason

    def scalar(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the helper as it is."""
        return function

    def caller(
        self, name: str, function: Callable[..., Any], signature: Signature
    ) -> Callable[..., Any]:
        """Return the kernel, with arrays that are only read protected."""

        def run(*arguments: Any) -> Any:
            return function(
                *(
                    # Writing an argument without a star raises in numpy.
                    _protected(value) if place not in signature.written else value
                    for place, value in enumerate(arguments)
                )
            )

        return run

    def describe(self) -> str:
        """Return one sentence for people."""
        return f"kernels run as plain Python, slowly, since {self._reason}."

    def obstacle(self) -> str:
        """Return nothing: nothing is compiled, so nothing has to be saved."""
        return ""


def _protected(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        # A view, so that the caller's array stays writeable.
        value = value.view()
        value.flags.writeable = False
    return value


DTYPES = {"d": np.dtype(np.float64), "l": np.dtype(np.int64), "b": np.dtype(np.bool_)}
_LIMIT = 2**63


def _whole(value: Any) -> int:
    # Refuses floats, which would lose their fractions silently.
    number = operator.index(value)
    # ctypes would cut the upper bits off.
    if not -_LIMIT <= number < _LIMIT:
        raise OverflowError(f"{number} does not fit into 64 bits")
    return number


NUMBERS: dict[str, Callable[[Any], Any]] = {"d": float, "l": _whole, "b": bool}


@dataclass(frozen=True)
class Signature:
    """Letters of arguments and results: ``d2`` is a table of float64, ``l`` an int64.

    An argument with a star, ``d2*``, is written by the kernel. Kernels as plain Python get all
    other arrays read-only, so that numpy refuses a star that is missing.

    Examples
    --------
    >>> Signature.parse("d2 l1* b -> l1 d")
    Signature(arguments=('d2', 'l1', 'b'), results=('l1', 'd'), written=(1,))
    >>> Signature.parse("d2 -> .").results
    ()
    """

    arguments: tuple[str, ...]
    results: tuple[str, ...]
    written: tuple[int, ...] = ()

    @classmethod
    def parse(cls, text: str) -> Signature:
        """Read ``"d2 l -> l1 l"``; nothing or a dot stands for no result."""
        left, arrow, right = text.partition("->")
        arguments, results = tuple(left.split()), tuple(right.split())
        # A dot states that there are no results; forgetting the arrow is an error.
        if results == (".",):
            results = ()
        fit = arrow and all(re.fullmatch(r"[dlb]([1-9]\*?)?", one) for one in arguments)
        if not fit or not all(re.fullmatch("[dl]|[dlb][1-9]", letters) for letters in results):
            raise ValueError(f"{text!r}: expected letters like 'd2 l b -> l1 l', or '-> .'")
        written = tuple(k for k, letters in enumerate(arguments) if letters.endswith("*"))
        return cls(tuple(letters.rstrip("*") for letters in arguments), results, written)


class Gate:
    """Casts what can be cast without loss of meaning, and refuses the rest.

    Parameters
    ----------
    kernel : str
        Name for messages.
    signature : Signature
        An array that is written cannot be cast, since the caller would never see the result.

    Examples
    --------
    >>> gate = Gate("shift", Signature.parse("d1* l -> ."))
    >>> gate([np.zeros(3), np.int32(2)])
    [array([0., 0., 0.]), 2]
    >>> gate([[0.0, 1.0], 2])
    Traceback (most recent call last):
    TypeError: shift: argument 0 is written; expected an aligned C array d1 as it is, found a list
    """

    def __init__(self, kernel: str, signature: Signature) -> None:
        self._kernel, self._written = kernel, signature.written

        # Parsed once per kernel: calls only compare.
        self._kinds = [
            (None, 0, NUMBERS[letters])
            if len(letters) == 1
            else (DTYPES[letters[0]], int(letters[1]), None)
            for letters in signature.arguments
        ]

    def __call__(self, arguments: Iterable[Any]) -> list[Any]:
        passed = list(arguments)
        if len(passed) != len(self._kinds):
            raise TypeError(
                f"{self._kernel} takes {len(self._kinds)} arguments, {len(passed)} were given"
            )
        for place, (dtype, n_dim, number) in enumerate(self._kinds):
            value = passed[place]
            if number is not None:
                passed[place] = number(value)
            # Four quick tests; nearly every array passes them and goes on as it is.
            elif not (
                type(value) is np.ndarray
                and value.dtype == dtype
                and value.ndim == n_dim
                and value.flags.carray
            ):
                passed[place] = self._fit(place, value, dtype, n_dim)
        return passed

    def _fit(self, place: int, value: Any, dtype: np.dtype, n_dim: int) -> np.ndarray:
        """Bring an array to its letters; the result is fit but may be read-only."""
        array = np.asarray(value)
        if array.ndim != n_dim:
            raise TypeError(
                f"{self._kernel}: argument {place} has {array.ndim} dimensions, expected {n_dim}"
            )
        # A copy of an argument that is written would be written in vain.
        if place in self._written:
            self._as_it_is(place, value, array, dtype)
            return array
        if array.dtype == dtype and array.flags.c_contiguous and array.flags.aligned:
            return array  # read-only, and only read
        # An empty array has whatever type numpy gave it, and no value to lose.
        if array.size and not np.can_cast(array.dtype, dtype, "same_kind"):
            raise TypeError(f"{self._kernel}: argument {place} is {array.dtype}, expected {dtype}")
        return np.require(array, dtype, ["C_CONTIGUOUS", "ALIGNED"])

    def _as_it_is(self, place: int, value: Any, array: np.ndarray, dtype: np.dtype) -> None:
        flags = array.flags
        if isinstance(value, np.ndarray) and array.dtype == dtype and flags.carray:
            return
        given = f"a {type(value).__name__}"
        if isinstance(value, np.ndarray):
            given = f"{array.dtype}, strides {array.strides}"
            if not flags.writeable:
                given = f"a read-only array, {given}"
        letters = f"{dtype.char}{array.ndim}".replace("?", "b")
        raise TypeError(
            f"{self._kernel}: argument {place} is written; "
            f"expected an aligned C array {letters} as it is, found {given}"
        )


# ---- sources ----------------------------------------
# The source files of the kernels: those of a folder and its rooms, except `compile`.


ROOT = Path(__file__).resolve().parents[1]
MACHINERY = "compile"


def kernel_files(folder: Path) -> list[Path]:
    """
    Return the kernel files of a folder and its rooms, in order; no two have one name.

    Parameters
    ----------
    folder : pathlib.Path

    Returns
    -------
    list of pathlib.Path

    Examples
    --------
    >>> [path.name for path in kernel_files(ROOT) if path.parent.name == "search"][:2]
    ['columns.py', 'separation.py']
    """
    # A flat folder, as in tests, or rooms.
    paths = [*folder.glob("*.py"), *folder.glob("*/*.py")]
    return sorted(
        path
        for path in paths
        if not path.name.startswith("_") and MACHINERY != path.parent.relative_to(folder).name
    )


def module_of(file: Path) -> str:
    """Return the name of the module in a kernel file of geosurf."""
    return ".".join(["geosurf.kernels", *file.relative_to(ROOT).with_suffix("").parts])


def file_of(module: str) -> Path:
    """Return the kernel file of a module of geosurf."""
    return ROOT.joinpath(*module.split(".")[2:]).with_suffix(".py")
