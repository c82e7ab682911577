"""Files that geosurf keeps for itself: checked before they are used, and never needed.

A kept file can be damaged (power cut, full disk), be somebody else's, or be planted. Kernels are
pickles, and who can write a pickle runs code in the process that loads it. A file is used only if

- other users can neither write nor own it, its folder and the folders above, up to the cache's;
- it is a plain file of a bearable size, no link, no pipe, no device;
- it begins with the SHA-256 of its own name and content.

Everything else is a miss, as if it were not there: what it held is made again. The first trouble
of a process is reported by a `GeosurfWarning` that names folder and remedy; the rest would say the
same.

How files are kept is not part of what marks a kernel as fresh: changes here recompile nothing.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
from contextlib import suppress
from pathlib import Path

from geosurf.errors import GeosurfWarning
from geosurf.files.atomic import remove, remove_abandoned, write_beside, write_whole
from geosurf.kernels.compile.cache_folder import CHOICE, cache_folder, cache_root
from geosurf.warning import issue

MARK = b"geosurf keeps 1\n"
LARGEST = 64 * 2**20  # [bytes]; the largest kernel has one or two millions
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
_READ = (
    os.O_RDONLY
    | getattr(os, "O_NOFOLLOW", 0)
    | getattr(os, "O_NONBLOCK", 0)  # a pipe without a writer must not hang
    | getattr(os, "O_CLOEXEC", 0)
    | getattr(os, "O_BINARY", 0)
)
_reported: list[GeosurfWarning] = []


class Store:
    """A folder of kept files.

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
        try:
            self.root, self.folder = cache_root(), cache_folder(part)
        except OSError as error:
            self.root = self.folder = Path("~/.cache/geosurf")
            self._no_folder = _reason(error)
        self._cleaned = False

    # ---- reading and writing -------------------------------------------------------------

    def load(self, name: str) -> bytes | None:
        """Return what was kept under a name, or None: not there, damaged, or not to be trusted."""
        if self._no_folder or self._is_distrusted():
            return None
        wrong = "its checksum is wrong"
        try:
            found = _content(name, _read(self.folder / name))
        except (FileNotFoundError, NotADirectoryError):
            return None
        except OSError as error:
            if not _is_folder(self.folder):
                return None  # told when something is to be kept there
            found, wrong = None, _reason(error)
        if found is None:
            self.report_damage(name, wrong)
        return found

    def save(self, name: str, payload: bytes) -> bool:
        """Keep something under a name, whole or not at all; return whether it is kept."""
        if self._is_distrusted():
            return False
        try:
            self._make_folder()
            write_whole(self.folder / name, _sealed(name, payload), 0o600)
        except OSError as error:
            self._report_unwritable(_reason(error))
            return False
        if not self._cleaned:
            self._cleaned = True
            remove_abandoned(self.folder)
        return True

    def obstacle(self) -> str:
        """Say why nothing can be kept, as doctor and warmup do; nothing if all is well.

        A small file is written and removed, since permissions tell less than an attempt.
        """
        found = self.distrust()
        if not found:
            try:
                self._make_folder()
                remove(write_beside(self.folder, b"geosurf", 0o600))
            except OSError as error:
                found = _reason(error)
        return found

    def _make_folder(self) -> None:
        if self._no_folder:
            raise FileNotFoundError(errno.ENOENT, self._no_folder)
        missing = [self.folder]
        while not missing[-1].exists():
            missing.append(missing[-1].parent)
        for folder in reversed(missing[:-1]):
            with suppress(FileExistsError):  # another process was faster
                folder.mkdir(mode=0o700)

    # ---- trust ---------------------------------------------------------------------------

    def distrust(self) -> str:
        """Say why files in this folder are not used; nothing if only this user can write them."""
        if not hasattr(os, "getuid"):
            return ""  # Windows closes the profile of a user by lists that are not looked at here
        for folder in {self.folder, self.root}:
            with suppress(OSError):
                found = folder.stat()
                if not stat.S_ISDIR(found.st_mode):
                    return f"{folder} is not a folder"
                why = _not_ours(found)
                if why:
                    return f"{folder} {why}"
        return ""

    def _is_distrusted(self) -> bool:
        why = self.distrust()
        if why:
            _report(
                self.folder,
                f"Compiled kernels are neither read nor kept in {self.folder}, since {why}; "
                "each process compiles them again, a minute or more.",
                f"Delete that folder, or set {CHOICE} to a folder that only you can write.",
            )
        return bool(why)

    # ---- reports -------------------------------------------------------------------------

    def report_damage(self, name: str, why: str) -> None:
        """Warn of a kept file that cannot be used."""
        _report(
            self.folder,
            f"{self.folder / name} cannot be used ({why}); what it held is made again.",
            f"Nothing has to be done. If it happens again, delete the folder {self.folder}.",
        )

    def _report_unwritable(self, why: str) -> None:
        _report(
            self.folder,
            f"Compiled kernels cannot be kept in {self.folder} ({why}); each process compiles "
            "them again, a minute or more.",
            f"Set {CHOICE} to a folder that can be written and has 50 MB of room.",
        )


def _report(folder: Path, effect: str, remedy: str) -> None:
    """Issue one warning for all trouble of a process."""
    if not _reported:
        _reported.append(GeosurfWarning("kernel cache", str(folder), effect, remedy))
        issue(_reported[0])


# ---- the file ----------------------------------------------------------------------------


def _sealed(name: str, payload: bytes) -> bytes:
    return MARK + _digest(name, payload) + b"\n" + payload


def _content(name: str, data: bytes) -> bytes | None:
    """The payload of a file; None if it is not what was kept under this name."""
    start = len(MARK) + 65
    payload = data[start:]
    return payload if data[:start] == MARK + _digest(name, payload) + b"\n" else None


def _digest(name: str, payload: bytes) -> bytes:
    digest = hashlib.sha256(name.encode() + b"\0")
    digest.update(payload)
    return digest.hexdigest().encode()


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:  # such as a name that is too long
        return False


def _read(path: Path) -> bytes:
    """The bytes of a plain file of ours; OSError for anything else."""
    handle = os.open(path, _READ)
    with os.fdopen(handle, "rb") as file:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, "it is not a plain file")
        why = _not_ours(found) if hasattr(os, "getuid") else ""
        if why:
            raise PermissionError(errno.EPERM, f"it {why}")
        if found.st_size > LARGEST:
            raise OSError(errno.EFBIG, f"it has more than {LARGEST >> 20} MB")
        return file.read(LARGEST)


def _not_ours(found: os.stat_result) -> str:
    """Why others could have written something; root could do so anyway."""
    if found.st_uid not in (os.geteuid(), 0):
        return f"belongs to another user ({found.st_uid})"
    if found.st_mode & _OTHERS_WRITE:
        return f"can be written by others (mode {stat.S_IMODE(found.st_mode):03o})"
    return ""


def _reason(error: OSError) -> str:
    return error.strerror or type(error).__name__
