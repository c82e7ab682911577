"""The one place where numba options are chosen.

``@scalar``
    A helper that other kernels call. Never called from Python, never cached.
``@entry("d2 l2 l -> l")``
    A kernel that Python calls. The text gives one letter and the number of
    dimensions for each argument (``d`` float64, ``l`` int64, ``b`` bool; no
    digit for a number), so that exactly one machine-code version exists and can
    be compiled ahead of time. The gate in front of it casts and checks.

``fastmath`` stays off everywhere: exact arithmetic dies of it. ``boundscheck`` is
off when compiled; run with NUMBA_DISABLE_JIT=1 to have Python check every index.

numba's own disk cache keeps stale code when a function in *another* file changes
(numba issue 1833), so the stamp of a cached kernel is a hash over its own file and
all kernel files that it imports, directly or not.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

_HERE = Path(__file__).resolve().parent
_DTYPES = {"d": np.dtype(np.float64), "l": np.dtype(np.int64), "b": np.dtype(np.bool_)}
_NUMBERS = {"d": float, "l": int, "b": bool}
_told: list[str] = []


def cache_folder() -> Path:
    """Folder for compiled kernels: GEOSURF_CACHE_DIR, or the user's cache."""
    chosen = os.environ.get("GEOSURF_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "geosurf" / f"numba-{numba.__version__}"


@cache
def _closure(name: str) -> frozenset[str]:
    """Kernel files that a kernel file needs, itself included."""
    text = (_HERE / f"{name}.py").read_text(encoding="utf-8")
    found = {name}
    for other in re.findall(r"^from geosurf\.kernels\.(\w+) import", text, flags=re.MULTILINE):
        if other != name:
            found |= _closure(other)
    return frozenset(found)


@cache
def _stamp(name: str) -> str:
    """Hash over a kernel file and everything that it imports."""
    digest = hashlib.sha256()
    for part in sorted(_closure(name)):
        digest.update((_HERE / f"{part}.py").read_bytes())
    return digest.hexdigest()


class _Locator(_CacheLocator):
    """Puts cached kernels into our folder, stamped with the import closure."""

    def __init__(self, py_func: Any, py_file: str) -> None:
        self._name = Path(py_file).stem
        self._line = py_func.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        return str(cache_folder())

    def get_source_stamp(self) -> str:
        return _stamp(self._name)

    def get_disambiguator(self) -> str:
        return f"{self._name}{self._line}"

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> _Locator:
        return cls(py_func, py_file)


class _Impl(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 - numba's own name for a class attribute


class _Cache(FunctionCache):
    _impl_class = _Impl


def scalar(function: Callable[..., Any]) -> Callable[..., Any]:
    """A helper for other kernels; LLVM decides what is inlined.

    numba would compile one version for each constant that a caller passes (180 functions
    instead of 130 for one scene); a constant is passed as a plain number instead.
    """
    helper = numba.njit(nogil=True, error_model="numpy")(function)
    if not config.DISABLE_JIT:
        template = helper.get_call_template

        def plain(args: Any, kws: Any) -> Any:
            kinds = {name: numba.types.unliteral(kind) for name, kind in dict(kws).items()}
            return template(tuple(numba.types.unliteral(kind) for kind in args), kinds)

        helper.get_call_template = plain
    return helper


def entry(signature: str) -> Callable[[Callable[..., Any]], Entry]:
    """A kernel that Python calls, with its arguments declared."""
    arguments, _, _ = signature.partition("->")

    def wrap(function: Callable[..., Any]) -> Entry:
        return Entry(function, arguments.split())

    return wrap


class Entry:
    """A compiled kernel behind a gate that casts and checks its arguments."""

    def __init__(self, function: Callable[..., Any], letters: list[str]) -> None:
        self.__name__ = function.__name__
        self.__doc__ = function.__doc__
        self.letters = letters
        self.python = function
        self._compiled = numba.njit(nogil=True, error_model="numpy")(function)
        self._ready = bool(config.DISABLE_JIT)
        if not self._ready:
            self._attach_cache(function)

    def _attach_cache(self, function: Callable[..., Any]) -> None:
        try:
            cache_folder().mkdir(parents=True, exist_ok=True, mode=0o700)
            self._compiled._cache = _Cache(function)
            self._compiled._can_compile = True
        except OSError:
            pass  # no folder can be written: kernels compile anew in each process

    def _announce(self) -> None:
        """Say once that kernels are being compiled, since it takes a while."""
        self._ready = True
        cached = getattr(self._compiled, "_cache", None)
        index = getattr(getattr(cached, "_cache_file", None), "_index_path", None)
        if _told or (index is not None and Path(index).exists()):
            return
        _told.append(self.__name__)
        if sys.stderr is not None and sys.stderr.isatty():
            sys.stderr.write("geosurf: compiling kernels, about two minutes, once per version\n")

    def __call__(self, *arguments: Any) -> Any:
        if len(arguments) != len(self.letters):
            raise TypeError(f"{self.__name__} takes {len(self.letters)} arguments")
        if not self._ready:
            self._announce()
        passed = [_cast(self.__name__, a, k) for a, k in zip(arguments, self.letters, strict=True)]
        return self._compiled(*passed)


class _Window:
    """Memory of a read-only array, seen as writeable, so that one type serves all."""

    def __init__(self, array: np.ndarray) -> None:
        self.base = array
        self.__array_interface__ = dict(array.__array_interface__)
        self.__array_interface__["data"] = (array.__array_interface__["data"][0], False)


def _cast(kernel: str, value: Any, letter: str) -> Any:
    """Bring one argument to its declared type; copies only what has another dtype or order."""
    if len(letter) == 1:
        return _NUMBERS[letter](value)
    array = np.ascontiguousarray(value, dtype=_DTYPES[letter[0]])
    if array.ndim != int(letter[1]):
        raise TypeError(f"{kernel}: an array has {array.ndim} dimensions, expected {letter[1]}")
    if not array.flags.writeable and array.size:
        array = np.asarray(_Window(array))
    elif not array.flags.writeable:
        array = array.copy()
    return array
