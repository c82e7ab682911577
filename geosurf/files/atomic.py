"""Write bytes to a file completely, or leave the old file: all writers use this module.

Data go to a new file next to the destination, under a random name that cannot be planted (it is
created exclusively and never through a link); they are forced to the disk, and the new
file takes the place of the old one in a single step. A kill or a power cut at any moment leaves
the old file or the new one.
"""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

PREFIX, SUFFIX = ".geosurf-", ".part"
N_RANDOM = 16  # hexadecimal digits of a random name
ABANDONED = 24 * 3600.0  # [s]; a single file is written in less
_NEW = (
    os.O_WRONLY
    | os.O_CREAT
    | os.O_EXCL
    | getattr(os, "O_NOFOLLOW", 0)
    | getattr(os, "O_CLOEXEC", 0)
    | getattr(os, "O_BINARY", 0)
)


def write_whole(path: str | os.PathLike[str], data: bytes, mode: int = 0o666) -> None:
    """Replace a file by new content in one step.

    Parameters
    ----------
    path : path-like
        A link there is replaced, not followed.
    data : bytes
    mode : int
        Permissions of the new file; the umask takes its part away.

    Raises
    ------
    OSError
        Then the file is what it was, and nothing else is left behind.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> target = pathlib.Path(tempfile.mkdtemp()) / "volumes.csv"
    >>> write_whole(target, b"unit,volume")
    >>> target.read_bytes(), len(list(target.parent.iterdir()))
    (b'unit,volume', 1)
    """
    part = write_beside(Path(path).parent, data, mode)
    try:
        # one step for all readers: they see the old file or the new one
        part.replace(path)
    finally:
        remove(part)  # without effect if it has moved
    sync_folder(part.parent)


def write_beside(folder: Path, data: bytes, mode: int = 0o666) -> Path:
    """Write a new file of random name into a folder, force it to the disk, return its path."""
    part = folder / random_name()
    handle = os.open(part, _NEW, mode)
    try:
        try:
            # A system call may write less than it was given.
            rest = memoryview(data)
            while rest:
                rest = rest[os.write(handle, rest) :]
            os.fsync(handle)
        finally:
            os.close(handle)
    except (OSError, KeyboardInterrupt):
        remove(part)
        raise
    return part


def random_name() -> str:
    """Return a name that nobody can know before."""
    return f"{PREFIX}{random_digits()}{SUFFIX}"


def random_digits() -> str:
    """Return hexadecimal digits that nobody can know before."""
    return os.urandom(N_RANDOM // 2).hex()


def sync_folder(folder: Path) -> None:
    """Force the names in a folder to the disk, where the system can (Windows cannot)."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def remove(*paths: Path) -> None:
    """Remove files as far as possible; links themselves, never what they point to."""
    for path in paths:
        with suppress(OSError):
            path.unlink()


def remove_abandoned(folder: Path) -> None:
    """Remove files that writers left when they were killed, a day ago or longer."""
    for path in _parts(folder):
        with suppress(OSError):
            # regular files only, and only old ones: a younger one may be in use
            found = path.lstat()
            if stat.S_ISREG(found.st_mode) and time.time() - found.st_mtime > ABANDONED:
                path.unlink()


def _parts(folder: Path) -> Iterator[Path]:
    with suppress(OSError):
        for path in folder.iterdir():
            digits = path.name.removeprefix(PREFIX).removesuffix(SUFFIX)
            if path.name == f"{PREFIX}{digits}{SUFFIX}" and len(digits) == N_RANDOM:
                yield path
