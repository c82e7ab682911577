"""Kernels compiled here by numba, and kept. How numba compiles them is chosen in `_helpers`.

numba's own disk cache keeps stale code when a function in *another* file changes
(numba issue 1833), so the stamp of a cached kernel is a hash over its own file and
all kernel files that it imports, directly or not.
"""

from __future__ import annotations

import hashlib
import itertools
import os
import re
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core.bytecode import FunctionIdentity
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

from geosurf.errors import DependencyError
from geosurf.kernels._folder import cache_folder
from geosurf.kernels._gate import Signature
from geosurf.kernels._helpers import Helper, entry_dispatcher
from geosurf.kernels._plain import written_in_source

_HERE = Path(__file__).resolve().parent
_TYPES = {"d": numba.float64, "l": numba.int64, "b": numba.boolean}
_told: list[str] = []


# ---- types --------------------------------------------------------------------------------


def types_of(letters: tuple[str, ...]) -> tuple[Any, ...]:
    """Return the types of numba for some letters; arrays are C-contiguous."""
    return tuple(
        _TYPES[word[0]] if len(word) == 1 else numba.types.Array(_TYPES[word[0]], int(word[1]), "C")
        for word in letters
    )


def check_results(name: str, found: Any, signature: Signature) -> None:
    """Refuse a kernel that returns something else than its signature says."""
    parts = tuple(found.types) if isinstance(found, numba.types.BaseTuple) else (found,)
    if found == numba.types.none:
        parts = ()
    if tuple(map(_letters, parts)) != signature.results:
        promised = " ".join(signature.results) or "."
        raise TypeError(f"{name} promises '-> {promised}', but numba finds that it returns {found}")


def _letters(kind: Any) -> str:
    dtype, n_dim = (kind.dtype, kind.ndim) if isinstance(kind, numba.types.Array) else (kind, "")
    letter = next((letter for letter, known in _TYPES.items() if known == dtype), "?")
    return f"{letter}{n_dim}"


# ---- the cache ---------------------------------------------------------------------------


def kernel_folder() -> Path:
    """Folder for compiled kernels."""
    return cache_folder(f"numba-{numba.__version__}")


@cache
def closure(path: Path) -> frozenset[Path]:
    """Kernel files that a kernel file needs, itself and the options included."""
    found = {path, _HERE / "_numba.py", _HERE / "_helpers.py"}
    text = path.read_text(encoding="utf-8")
    for other in re.findall(r"^from geosurf\.kernels\.(\w+) import", text, flags=re.MULTILINE):
        if not other.startswith("_") and _HERE / f"{other}.py" != path:
            found |= closure(_HERE / f"{other}.py")
    return frozenset(found)


@cache
def _stamp(path: Path) -> str:
    """Hash over a kernel file and everything that it imports."""
    digest = hashlib.sha256()
    for part in sorted(closure(path)):
        digest.update(part.read_bytes())
    return digest.hexdigest()


class _Locator(_CacheLocator):
    """Puts cached kernels into our folder, stamped with the import closure."""

    def __init__(self, py_func: Any, py_file: str) -> None:
        self._file = Path(py_file)
        self._line = py_func.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        return str(kernel_folder())

    def get_source_stamp(self) -> str:
        return _stamp(self._file)

    def get_disambiguator(self) -> str:
        # with the stamp, so that two checkouts or versions do not overwrite each other's code
        return f"{self._file.stem}{self._line}-{_stamp(self._file)[:12]}"

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> _Locator:
        return cls(py_func, py_file)


class _Impl(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 - numba's own name for a class attribute


class _Cache(FunctionCache):
    _impl_class = _Impl

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return a kernel from the cache; None, and names of its own to come, if it is not there.

        numba names each function by a count that begins at 1 in every process, and links kernels
        that it finds in a cache by these names. Two that were compiled in two processes may then
        call each other's parts: a kernel that sorted in place was linked to the `argsort` of
        another, which crashed. So each kernel counts from a place that is its own.
        """
        found = super().load_overload(sig, target_context)
        if found is None:
            FunctionIdentity._unique_ids = itertools.count(int.from_bytes(os.urandom(7), "big"))
        return found


# ---- the runner --------------------------------------------------------------------------


class JitRunner:
    """Compiles a kernel when it is first called, or finds it in the cache.

    Parameters
    ----------
    reason : str
        Why kernels are compiled here, for people.

    Raises
    ------
    DependencyError
        If a file of numba's switches compilation off: half a choice would be a mixture.
    """

    compiles = True

    def __init__(self, reason: str) -> None:
        if numba.config.DISABLE_JIT:
            raise DependencyError(
                "numba is told not to compile, but not by NUMBA_DISABLE_JIT in the environment. "
                "Set it there to run kernels as plain Python, or take it out of numba's files."
            )
        self._reason = reason

    def scalar(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the helper for compiled kernels."""
        return Helper(function)

    def caller(
        self, name: str, function: Callable[..., Any], signature: Signature
    ) -> Callable[..., Any]:
        """Return the kernel; nothing is compiled yet."""
        return JitKernel(function, signature)

    def written(self, name: str, function: Callable[..., Any]) -> tuple[int, ...]:
        """Return the places of the arguments that an entry writes."""
        return written_in_source(name, function)

    def describe(self) -> str:
        """Return one sentence for people."""
        return (
            f"kernels are compiled here by numba {numba.__version__}, since {self._reason}; "
            f"kept in {cache_folder()}."
        )


class JitKernel:
    """A kernel that numba compiles at its first call, or loads."""

    def __init__(self, function: Callable[..., Any], signature: Signature) -> None:
        self._signature = signature
        self._compiled = entry_dispatcher(function)
        self._ready = False
        try:
            kernel_folder().mkdir(parents=True, exist_ok=True, mode=0o700)
            self._compiled._cache = _Cache(function)
        except OSError:
            pass  # no folder can be written: kernels compile anew in each process

    def __call__(self, *arguments: Any) -> Any:
        if not self._ready:
            self._announce()
        return self._compiled(*map(_writeable, arguments))

    def is_cached(self) -> bool:
        """Return whether machine code of these very sources is on disk."""
        file = getattr(self._compiled._cache, "_cache_file", None)
        return file is not None and bool(file._load_index())

    def compile(self) -> tuple[Any, bool]:
        """Compile or load the kernel now.

        Returns
        -------
        results : numba.types.Type
        loaded : bool
            Whether it was found in the cache.
        """
        self._ready = True
        types = types_of(self._signature.arguments)
        self._compiled.compile(types)
        results = self._compiled.overloads[types].signature.return_type
        return results, bool(self._compiled.stats.cache_hits)

    def _announce(self) -> None:
        """Say once that kernels are being compiled, since it takes a while."""
        self._ready = True
        if _told or self.is_cached():
            return
        _told.append(self._compiled.__name__)
        if sys.stderr is not None and sys.stderr.isatty():
            sys.stderr.write("geosurf: compiling kernels, two to three minutes, once per version\n")


class _Window:
    """Memory of a read-only array, seen as writeable, so that one type serves all.

    The gate has made sure that the kernel only reads it.
    """

    def __init__(self, array: np.ndarray) -> None:
        self.base = array
        interface = array.__array_interface__  # made anew each time it is asked for
        interface["data"] = (interface["data"][0], False)
        self.__array_interface__ = interface


def _writeable(value: Any) -> Any:
    """The same memory as an array that a kernel takes; most read-only arrays are all of another."""
    if type(value) is not np.ndarray or value.flags.writeable:
        return value
    owner = value.base
    if type(owner) is np.ndarray and owner.flags.carray and _is_all_of(value, owner):
        return owner if owner.shape == value.shape else owner.reshape(value.shape)
    return np.asarray(_Window(value)) if value.size else value.copy()


def _is_all_of(part: np.ndarray, whole: np.ndarray) -> bool:
    """Whether a C-contiguous part of a C-contiguous array is all of it: five times as fast to say
    as a window is to make.
    """
    return part.size == whole.size and part.dtype == whole.dtype
