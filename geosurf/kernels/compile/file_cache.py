"""Cached files of geosurf: verified before they are used, and never required.

A cached file can be damaged (power cut, full disk), belong to another user, or be planted. Kernels
are pickles, and whoever can write a pickle can run code in the process that loads it. A file is
used only if

- no other user can write or own it, its folder, or the cache folder above;
- it is a regular file of acceptable size: no link, pipe or device;
- it begins with the SHA-256 of its own name and content.

Anything else is a cache miss: the content is computed again. The first problem of a process is
reported by a `GeosurfWarning` that names folder and remedy.

How files are stored does not affect the freshness of a kernel: changes here recompile nothing.
"""

from __future__ import annotations

import errno
import os
import stat
from contextlib import suppress
from pathlib import Path

from geosurf.errors import GeosurfWarning, issue
from geosurf.files import (
    read_own,
    remove,
    remove_abandoned,
    sealed,
    unsealed,
    why_not_ours,
    write_beside,
    write_whole,
)

# ---- cache folder ----------------------------------------
# The folder for compiled kernels and for the analysis of their sources.


CHOICE = "GEOSURF_CACHE_DIR"


def cache_root() -> Path:
    """
    Return GEOSURF_CACHE_DIR, or geosurf's folder in the user's cache.

    Raises
    ------
    OSError
        Where a user has neither a cache nor a home.
    """
    # What the user chose goes first, also for read-only homes and shared machines.
    chosen = os.environ.get(CHOICE)
    if chosen:
        return Path(chosen).absolute()
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if base.is_absolute():  # a relative one is to be ignored, by the rules of XDG
        return base / "geosurf"
    try:
        # A process without an account, as in some containers, has no home.
        home = Path.home()
    except RuntimeError as error:
        raise FileNotFoundError(errno.ENOENT, str(error)) from error
    # A relative home would spread caches over working folders.
    if not home.is_absolute():
        raise FileNotFoundError(errno.ENOENT, f"the home folder {home} is relative")
    return home / ".cache" / "geosurf"


def cache_folder(part: str = "") -> Path:
    """
    Return GEOSURF_CACHE_DIR, or a part of geosurf's folder in the user's cache.

    Raises
    ------
    OSError
        Where a user has neither a cache nor a home.
    """
    # A folder that was chosen is used as it is; the default one has a part for each purpose.
    return cache_root() if os.environ.get(CHOICE) else cache_root() / part


LARGEST = 64 * 2**20  # [bytes]; the largest kernel has one or two millions
_reported: list[GeosurfWarning] = []


class Store:
    """A folder of cached files.

    Parameters
    ----------
    part : str
        Folder in geosurf's cache; GEOSURF_CACHE_DIR has no parts.

    Examples
    --------
    >>> import os, tempfile
    >>> os.environ["GEOSURF_CACHE_DIR"] = tempfile.mkdtemp()
    >>> store = Store("examples")
    >>> store.save("primes-1", b"2 3 5")
    True
    >>> store.load("primes-1"), store.load("primes-2")
    (b'2 3 5', None)
    >>> del os.environ["GEOSURF_CACHE_DIR"]
    """

    def __init__(self, part: str = "") -> None:
        self._no_folder = ""
        # No problem with a folder may prevent the import of geosurf: it is reported on first use.
        try:
            self.root, self.folder = cache_root(), cache_folder(part)
        except OSError as error:
            self.root = self.folder = Path("~/.cache/geosurf")
            self._no_folder = _reason(error)
        self._cleaned = False

    # ---- reading and writing -------------------------------------------------------------

    def load(self, name: str) -> bytes | None:
        """Return the file cached under a name; None if it is missing, damaged or not trusted."""
        if self._no_folder or self._is_distrusted():
            return None
        wrong = "its checksum is wrong"
        try:
            content = unsealed(name, read_own(self.folder / name, LARGEST))
        # Missing is the normal case of a first run, and no reason to warn.
        except (FileNotFoundError, NotADirectoryError):
            return None
        except OSError as error:
            if not _is_folder(self.folder):
                return None  # reported when something is to be saved there
            content, wrong = None, _reason(error)
        if content is None:
            self.report_damage(name, wrong)
        return content

    def save(self, name: str, payload: bytes) -> bool:
        """Save something under a name, completely or not at all; return whether it is saved."""
        if self._is_distrusted():
            return False
        try:
            self._make_folder()
            # Written aside and renamed, so that no process sees half a file.
            write_whole(self.folder / name, sealed(name, payload), 0o600)
        except OSError as error:
            self._report_unwritable(_reason(error))
            return False
        # Once per process: remove what interrupted writers left behind.
        if not self._cleaned:
            self._cleaned = True
            remove_abandoned(self.folder)
        return True

    def obstacle(self) -> str:
        """Return why nothing can be saved, for doctor and warmup; empty if all is well.

        A small file is written and removed, since permissions say less than an attempt.
        """
        reason = self.distrust()
        if not reason:
            try:
                self._make_folder()
                remove(write_beside(self.folder, b"geosurf", 0o600))
            except OSError as error:
                reason = _reason(error)
        return reason

    def _make_folder(self) -> None:
        if self._no_folder:
            raise FileNotFoundError(errno.ENOENT, self._no_folder)
        # Folders from the outermost missing one inwards, each closed to other users.
        missing = [self.folder]
        while not missing[-1].exists():
            missing.append(missing[-1].parent)
        for folder in reversed(missing[:-1]):
            with suppress(FileExistsError):  # another process was faster
                folder.mkdir(mode=0o700)

    # ---- trust ---------------------------------------------------------------------------

    def distrust(self) -> str:
        """Return why files in this folder are not used; empty if only this user can write them."""
        if not hasattr(os, "getuid"):
            return ""  # Windows protects user profiles by access lists
        # Whoever can write the folder above could exchange this one.
        for folder in {self.folder, self.root}:
            # A folder that is not there yet is made by this user.
            with suppress(OSError):
                state = folder.stat()
                if not stat.S_ISDIR(state.st_mode):
                    return f"{folder} is not a folder"
                why = why_not_ours(state)
                if why:
                    return f"{folder} {why}"
        return ""

    def _is_distrusted(self) -> bool:
        why = self.distrust()
        if why:
            _report(
                self.folder,
                f"The kernel cache {self.folder} is not used, since {why}; "
                "each process compiles the kernels again, a minute or more.",
                f"Delete that folder, or set {CHOICE} to a folder that only you can write.",
            )
        return bool(why)

    # ---- reports -------------------------------------------------------------------------

    def report_damage(self, name: str, why: str) -> None:
        """Warn of a cached file that cannot be used."""
        _report(
            self.folder,
            f"The cached file {self.folder / name} cannot be used ({why}); it is made again.",
            f"No action is needed. If it happens again, delete the folder {self.folder}.",
        )

    def _report_unwritable(self, why: str) -> None:
        _report(
            self.folder,
            f"Compiled kernels cannot be saved in {self.folder} ({why}); each process compiles "
            "them again, a minute or more.",
            f"Set {CHOICE} to a writable folder with 50 MB of free space.",
        )


def _report(folder: Path, effect: str, remedy: str) -> None:
    """Issue one warning for all problems of a process."""
    # One problem shows at every kernel; the first warning names the remedy for all.
    if not _reported:
        _reported.append(GeosurfWarning("kernel cache", str(folder), effect, remedy))
        issue(_reported[0])


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:  # such as a name that is too long
        return False


def _reason(error: OSError) -> str:
    return error.strerror or type(error).__name__
