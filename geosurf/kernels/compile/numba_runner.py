"""Kernels compiled here by numba, and cached.

The options of numba are chosen in `helpers`, which is part of the hash of each kernel; nothing in
this file changes machine code. How files are stored is chosen in `file_cache`.

numba's own disk cache keeps stale code when a function in *another* file changes (numba issue
1833). So a cached kernel is named by a hash over its own file and all kernel files that it imports,
directly or not. numba also unpickles its files without verification; so this cache is our own, one
file for each kernel.
"""

from __future__ import annotations

import hashlib
import pickle
import re
import sys
from collections.abc import Callable
from functools import cache
from multiprocessing import parent_process
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from geosurf.errors import DependencyError
from geosurf.kernels.compile.file_cache import CHOICE, Store
from geosurf.kernels.compile.gate import MACHINERY, Signature, file_of
from geosurf.kernels.compile.helpers import Helper, entry_dispatcher, names_of_its_own

_HELPERS = Path(__file__).with_name("helpers.py")
_TYPES = {"d": numba.float64, "l": numba.int64, "b": numba.boolean}
# choices of numba's, in its environment or files, that change the code of a kernel
_CHOICES = ("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK", "DEBUGINFO_DEFAULT")
# what unpickling and linking raise when a cached kernel is intact but does not fit this process
_UNFIT = (
    *(pickle.UnpicklingError, EOFError, AttributeError, ImportError, IndexError, KeyError),
    *(TypeError, ValueError, RuntimeError),
)
_announced: list[str] = []


# ---- types --------------------------------------------------------------------------------


def types_of(letters: tuple[str, ...]) -> tuple[Any, ...]:
    """Return the types of numba for some letters; arrays are C-contiguous."""
    return tuple(
        _TYPES[word[0]] if len(word) == 1 else numba.types.Array(_TYPES[word[0]], int(word[1]), "C")
        for word in letters
    )


def check_results(name: str, returned: Any, signature: Signature) -> None:
    """Refuse a kernel that returns something else than its signature says."""
    # One result is a type, several are a tuple of types, and none is the type `none`.
    parts = tuple(returned.types) if isinstance(returned, numba.types.BaseTuple) else (returned,)
    if returned == numba.types.none:
        parts = ()
    if tuple(map(_letters, parts)) != signature.results:
        promised = " ".join(signature.results) or "."
        raise TypeError(
            f"{name} promises '-> {promised}', but numba finds that it returns {returned}"
        )


def _letters(kind: Any) -> str:
    dtype, n_dim = (kind.dtype, kind.ndim) if isinstance(kind, numba.types.Array) else (kind, "")
    letter = next((letter for letter, known in _TYPES.items() if known == dtype), "?")
    return f"{letter}{n_dim}"


# ---- the cache ---------------------------------------------------------------------------


def kernel_folder() -> Path:
    """Folder for compiled kernels."""
    return Store("kernels").folder


@cache
def closure(path: Path) -> frozenset[Path]:
    """Kernel files that a kernel file needs, itself and the choices for numba included."""
    # The options of numba in `helpers` are a part of each kernel.
    needed = {path, _HELPERS}
    text = path.read_text(encoding="utf-8")
    # Read from the text, so that nothing is imported; import statements of kernels have this form.
    for other in re.findall(r"^from (geosurf\.kernels\.[\w.]+) import", text, flags=re.MULTILINE):
        if other.split(".")[2] != MACHINERY and file_of(other) != path:
            needed |= closure(file_of(other))
    return frozenset(needed)


@cache
def _stamp(path: Path) -> str:
    """Hash over a kernel file and everything that it imports."""
    digest = hashlib.sha256()
    # In order, so that the hash is the same in every process.
    for part in sorted(closure(path)):
        digest.update(part.read_bytes())
    return digest.hexdigest()


@cache
def _made_with() -> str:
    """What else decides the machine code of a kernel, or how it is pickled."""
    # The layout of arrays may change with minor versions of numpy.
    numpy = ".".join(np.__version__.split(".")[:2])
    python = f"{sys.implementation.cache_tag}{getattr(sys, 'abiflags', '')}"
    # Variables of the environment that change machine code belong to the name as well.
    choices = [f"{name}={getattr(numba.config, name, None)}" for name in _CHOICES]
    return " ".join([python, numpy, numba.__version__, llvmlite.__version__, *choices])


class KernelCache(_Cache):
    """The cache of one kernel, called by numba; any failure is a cache miss.

    Parameters
    ----------
    function : callable
    store : Store
    """

    def __init__(self, function: Callable[..., Any], store: Store) -> None:
        self._function = function
        self._store = store
        self._enabled = True

    @property
    def cache_path(self) -> str:
        """The folder."""
        return str(self._store.folder)

    def enable(self) -> None:
        """Load and save."""
        self._enabled = True

    def disable(self) -> None:
        """Neither load nor save."""
        self._enabled = False

    def flush(self) -> None:
        """Nothing is held back."""

    def name(self, types: Any, codegen: Any) -> str:
        """Name of the file for some types of arguments on this machine."""
        code = self._function.__code__
        file = Path(code.co_filename)
        # The line of the function is a part of its debug information.
        what = [_made_with(), _stamp(file), str(code.co_firstlineno), str(types)]
        what += map(str, codegen.magic_tuple())
        digest = hashlib.sha256("\0".join(what).encode()).hexdigest()
        return f"{file.stem}.{self._function.__name__}-{digest[:40]}.nbc"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return a kernel from the cache; None and names of its own if it is not there."""
        target_context.refresh()
        if self._enabled:
            name = self.name(sig, target_context.codegen())
            # Verified by its checksum before anything is unpickled.
            cached = self._store.load(name)
            if cached is not None:
                try:
                    return CompileResult._rebuild(target_context, *pickle.loads(cached))
                except _UNFIT as error:
                    if not _has_moved(error):
                        self._store.report_damage(name, f"{type(error).__name__}: {error}")
        # A miss: numba compiles next.
        _announce(self._function.__name__)
        names_of_its_own()
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a kernel, if it can be saved."""
        # Code with pointers of this process, or with loops that run as Python, fits no other one.
        fit = not data.library.has_dynamic_globals and all(part.can_cache for part in data.lifted)
        if self._enabled and fit:
            self._store.save(self.name(sig, data.codegen), dumps(data._reduce()))


def _has_moved(error: Exception) -> bool:
    """Whether a kernel was cached when its file, with the same content, was in another folder."""
    moved = isinstance(error, ModuleNotFoundError) and error.name is not None
    return moved and str(error.name).startswith("geosurf.kernels.")


def _announce(kernel: str) -> None:
    """Announce once that kernels are being compiled, since it takes a while."""
    # Workers do not repeat what their parent has said.
    if not _announced and sys.stderr is not None and parent_process() is None:
        sys.stderr.write(
            "geosurf: compiling kernels, up to a minute, once per version (`geosurf warmup` "
            "compiles all of them on all cores)\n"
        )
        sys.stderr.flush()
    _announced.append(kernel)


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
        # Its decorators would then return plain functions without types.
        if numba.config.DISABLE_JIT:
            raise DependencyError(
                "A configuration file of numba disables compilation. Remove that setting, or set "
                "NUMBA_DISABLE_JIT=1 in the environment to run kernels as plain Python."
            )
        self._reason = reason
        self._store = Store("kernels")

    def scalar(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the helper for compiled kernels."""
        return Helper(function)

    def caller(
        self, name: str, function: Callable[..., Any], signature: Signature
    ) -> Callable[..., Any]:
        """Return the kernel; nothing is compiled yet."""
        return JitKernel(function, signature, self._store)

    def describe(self) -> str:
        """Return one sentence for people."""
        how = f"kernels are compiled here by numba {numba.__version__}, since {self._reason}"
        obstacle = self.obstacle()
        return f"{how}. {obstacle}" if obstacle else f"{how}; cached in {self._store.folder}."

    def obstacle(self) -> str:
        """Return why each process compiles the kernels again, and the remedy; mostly empty."""
        why = self._store.obstacle()
        return why and (
            f"They cannot be saved in {self._store.folder} ({why}), so each process compiles them "
            f"again. Set {CHOICE} to a folder that only you can write."
        )


class JitKernel:
    """A kernel that numba compiles at its first call, or loads."""

    def __init__(self, function: Callable[..., Any], signature: Signature, store: Store) -> None:
        self._signature = signature
        self._compiled = entry_dispatcher(function)
        # Our cache in place of numba's, which checks less.
        self._compiled._cache = KernelCache(function, store)

    def __call__(self, *arguments: Any) -> Any:
        return self._compiled(*map(_writeable, arguments))

    def compile(self) -> tuple[Any, bool]:
        """Compile or load the kernel now.

        Returns
        -------
        results : numba.types.Type
        loaded : bool
            Whether it was found in the cache.
        """
        types = types_of(self._signature.arguments)
        self._compiled.compile(types)
        results = self._compiled.overloads[types].signature.return_type
        return results, bool(self._compiled.stats.cache_hits)


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
    # Mostly a view that was made read-only: its owner has the same memory and may be passed.
    owner = value.base
    if type(owner) is np.ndarray and owner.flags.carray and _is_all_of(value, owner):
        return owner if owner.shape == value.shape else owner.reshape(value.shape)
    return np.asarray(_Window(value)) if value.size else value.copy()


def _is_all_of(part: np.ndarray, whole: np.ndarray) -> bool:
    """Whether a C-contiguous part of a C-contiguous array is all of it.

    This test is five times as fast as making a window.
    """
    return part.size == whole.size and part.dtype == whole.dtype
