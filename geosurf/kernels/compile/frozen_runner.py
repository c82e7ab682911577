"""Kernels frozen into a library when a wheel was built: loaded by ctypes, without numba.

The library speaks numba's calling convention, which is plain C::

    int32 kernel(results *, exception **, arguments ...)

An array is passed as seven words or more: owner, parent, number of elements, bytes per element,
address, shape, strides. No owner means that Python owns it; a returned array without an owner is (a
part of) an argument. Status 0: results are filled in; -2: there are none;
above 0: an exception, pickled. `call_wrappers` makes these words from one block.

ctypes releases the GIL. It checks nothing: that is the task of the gate.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import pickle
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.errors import InvariantError
from geosurf.kernels.compile.gate import DTYPES, MACHINERY, Signature, kernel_files
from geosurf.kernels.compile.platforms import PLATFORMS, platform_name, wrapper

MANIFEST = "manifest.json"
_PACKED = {"d": "d", "l": "q", "b": "q"}
_DONE, _NOTHING = 0, -2


class Unfit(Exception):
    """The library is missing, or made for other sources or another machine; the text says why."""


def stamp_of(folder: Path) -> str:
    """Hash over all sources in a folder of kernels and its rooms.

    Parameters
    ----------
    folder : pathlib.Path

    Returns
    -------
    str
    """
    # Files are told apart by name and size, so that moving text between files changes the stamp.
    digest = hashlib.sha256()
    machinery = folder / MACHINERY
    # The machinery decides the machine code and how it is called, so it counts.
    machine_files = [
        *folder.glob("**/__init__.py"),
        *machinery.glob("*.py"),
        *machinery.glob("*.c"),
    ]
    # In order of names: no file system lists them in another order.
    for path in sorted({*kernel_files(folder), *machine_files}, key=Path.as_posix):
        digest.update(f"{path.name}\0{path.stat().st_size}\0".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def symbol(level: str, name: str) -> str:
    """Return the name of a kernel in the library."""
    return f"{level}__{name}".replace("-", "_").replace(".", "__")


class Library:
    """A frozen library that fits.

    Parameters
    ----------
    folder : pathlib.Path
        Where library and manifest lie.
    stamp : str
        Of the sources that are to be run.

    Raises
    ------
    Unfit
    """

    def __init__(self, folder: Path, stamp: str) -> None:
        # From cheap to costly, and each reason in words: `geosurf doctor` shows it.
        try:
            self.manifest: dict[str, Any] = json.loads((folder / MANIFEST).read_bytes())
        except FileNotFoundError:
            raise Unfit("this installation has no frozen library") from None
        except (OSError, ValueError) as error:
            raise Unfit(f"the manifest of the frozen library cannot be read ({error})") from error
        if self.manifest["platform"] != platform_name():
            raise Unfit(f"the frozen library is for {self.manifest['platform']}")
        if self.manifest["stamp"] != stamp:
            raise Unfit("the frozen library was made from other sources")
        path = folder / PLATFORMS[platform_name()].format.library
        try:
            # loading a truncated library kills the process, so it is verified before
            found = hashlib.sha256(path.read_bytes()).hexdigest()
            if found != self.manifest["sha256"]:
                raise Unfit("the frozen library and its manifest do not belong together")
            # A whole path, so that no system looks for it in other folders.
            self._library = ctypes.CDLL(str(path.absolute()))
        except OSError as error:
            raise Unfit(f"the frozen library cannot be loaded ({error})") from error
        if not hasattr(ctypes, "pythonapi"):
            raise Unfit("the frozen library needs CPython")
        # What is inside a capsule of Python; the lock is held, as it is not for the library.
        self.inside = ctypes.pythonapi.PyCapsule_GetPointer
        self.inside.argtypes = [ctypes.py_object, ctypes.c_char_p]
        self.inside.restype = ctypes.c_void_p
        # The library asks the CPU itself, since Python has no portable way to.
        self.level = self._best_level()
        # Memory of results is given back by the library alone: no code of Python runs for that.
        use = self._library.geosurf_use
        use.argtypes, use.restype = [ctypes.c_void_p], None
        use(ctypes.cast(self.inside, ctypes.c_void_p))
        self._release = ctypes.cast(self._library.geosurf_release, ctypes.c_void_p)
        self._capsule = ctypes.pythonapi.PyCapsule_New
        self._capsule.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        self._capsule.restype = ctypes.py_object

    def _best_level(self) -> str:
        here = self._library.geosurf_level()
        known = PLATFORMS[self.manifest["platform"]].levels
        # Levels are listed with the most demanding one last.
        fit = [level for level in self.manifest["levels"] if known[level] <= here]
        if not fit:
            raise Unfit(f"the frozen library needs a CPU of level {self.manifest['levels'][0]}")
        return str(fit[-1])

    def address(self, name: str) -> int:
        """Return the address of a kernel."""
        # One symbol for each level and kernel.
        found = ctypes.cast(self._function(symbol(self.level, name), name), ctypes.c_void_p)
        return found.value or 0

    def caller(self, letters: tuple[str, ...]) -> Any:
        """Return the function that calls kernels with some arguments, see `call_wrappers`."""
        name = wrapper(letters)
        function = self._function(name, name)
        words = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p]
        function.argtypes, function.restype = words, ctypes.c_int32
        return function

    def _function(self, symbol: str, name: str) -> Any:
        try:
            return self._library[symbol]
        except AttributeError:
            raise InvariantError(
                f"kernel {name} is not in the frozen library; please report it. "
                "GEOSURF_JIT=1 runs without the library."
            ) from None

    def owner(self, block: int) -> Any:
        """Return what keeps memory that a kernel has allocated, and gives it back at its end."""
        return self._capsule(block, None, self._release)


class FrozenRunner:
    """Runs the machine code of a library.

    Parameters
    ----------
    library : Library
    """

    compiles = False

    def __init__(self, library: Library) -> None:
        self._library = library

    def scalar(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the helper as it is; frozen kernels have their own copy."""
        return function

    def caller(
        self, name: str, function: Callable[..., Any], signature: Signature
    ) -> Callable[..., Any]:
        """Return the frozen kernel."""
        return FrozenKernel(name, signature, self._library)

    def describe(self) -> str:
        """Return one sentence for people."""
        made = self._library.manifest["made_with"]
        return (
            f"kernels are frozen: machine code for {self._library.level} that came with this "
            f"installation, with numba {made['numba']}."
        )

    def obstacle(self) -> str:
        """Return an empty text: nothing is compiled, so nothing has to be saved."""
        return ""


class FrozenKernel:
    """One kernel of the library; arguments have passed the gate."""

    def __init__(self, name: str, signature: Signature, library: Library) -> None:
        self._name = name
        self._library = library
        self._letters = signature.arguments
        self._results = signature.results
        # Hundreds of kernels are imported, a few dozen are called: bound at the first call.
        self._call: Any = None

    def _bind(self) -> None:
        # Built once per kernel: how arguments are packed, and where results are.
        self._kernel = self._library.address(self._name)
        self._arrays = [k for k, letters in enumerate(self._letters) if len(letters) > 1]
        self._pack = struct.Struct("".join(_PACKED[letters[0]] if len(letters) == 1 else "P"
                                           for letters in self._letters)).pack  # fmt: skip
        sizes = [1 if len(letters) == 1 else 5 + 2 * int(letters[1]) for letters in self._results]
        self._starts = [sum(sizes[:i]) for i in range(len(sizes))]
        self._frame = ctypes.c_int64 * sum(sizes)
        self._unpack = struct.Struct("".join(
            "d" if letters == "d" else "q" * size
            for letters, size in zip(self._results, sizes, strict=True)
        )).unpack  # fmt: skip
        self._call = self._library.caller(self._letters)

    def __call__(self, *arguments: Any) -> Any:
        if self._call is None:
            self._bind()
        # An array goes as the address of what numpy states about it, which lives as long as its
        # capsule; Python keeps the memory itself alive during the call.
        words, capsules, inside = list(arguments), [], self._library.inside
        for k in self._arrays:
            capsule = arguments[k].__array_struct__
            capsules.append(capsule)
            words[k] = inside(capsule, None)
        frame, failure = self._frame(), ctypes.c_void_p()
        block = self._pack(*words)
        status = self._call(self._kernel, frame, ctypes.byref(failure), block)
        # Exceptions of a kernel are constants of the library, pickled when it was made.
        if status > 0:
            raise _exception(failure, self._name)
        if status not in (_DONE, _NOTHING):
            raise InvariantError(
                f"kernel {self._name} ended with status {status}; please report it."
            )
        # Arrays come back as words, numbers as they are.
        values = self._unpack(frame)
        results = [
            self._array(values[start:], letters, arguments) if len(letters) > 1 else values[start]
            for start, letters in zip(self._starts, self._results, strict=True)
        ]
        return tuple(results) if len(results) > 1 else (results[0] if results else None)

    def _array(
        self, words: tuple[int, ...], letters: str, arguments: tuple[Any, ...]
    ) -> np.ndarray:
        """An array that came back: a new one, or (a part of) one that went in."""
        n_dim = int(letters[1])
        _, _, address = words[2:5]
        shape, strides = words[5 : 5 + n_dim], words[5 + n_dim : 5 + 2 * n_dim]
        dtype = DTYPES[letters[0]]
        # An owner: the kernel has allocated this memory, and numpy has to give it back.
        if words[0]:
            return np.asarray(_Memory(self._library.owner(words[0]), {
                "version": 3,
                "data": (address, False),
                "typestr": dtype.str,
                "shape": shape,
                "strides": strides,
            }))  # fmt: skip
        # No owner: the result is a part of an argument, found by its address.
        for array in arguments:
            if isinstance(array, np.ndarray):
                start = array.__array_interface__["data"][0]
                if start <= address <= start + array.nbytes and array.dtype == dtype:
                    return np.ndarray(shape, dtype, array.view(), address - start, strides)
        raise InvariantError(f"kernel {self._name} returned foreign memory; please report it.")


class _Memory:
    """Memory that a kernel has allocated; it goes with the last array on it."""

    __slots__ = ("__array_interface__", "owner")

    def __init__(self, owner: Any, interface: dict[str, Any]) -> None:
        # numpy reads the interface and keeps this object alive with the array.
        self.owner, self.__array_interface__ = owner, interface


class _Exception(ctypes.Structure):
    """What numba hands out when a kernel raises."""

    _fields_ = (
        ("pickled", ctypes.c_void_p),
        ("size", ctypes.c_int32),
        ("hash", ctypes.c_void_p),
        ("unwrap", ctypes.c_void_p),
        ("dynamic", ctypes.c_int32),
    )


def _exception(failure: ctypes.c_void_p, name: str) -> BaseException:
    """The exception that a kernel has raised; its text is part of the library."""
    info = _Exception.from_address(failure.value or 0)
    # The pickle is part of a library whose checksum was verified.
    kind, arguments, place = pickle.loads(ctypes.string_at(info.pickled, info.size))
    error: BaseException = kind(*(arguments or ()))
    where = f" ({place[1]}, line {place[2]})" if place else ""
    error.add_note(f"raised by the compiled kernel {name}{where}")
    return error
