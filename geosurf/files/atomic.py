"""Write bytes to a file completely, or leave the old file: all writers use this module.

Data go to a new file next to the destination, under a random name that cannot be planted (it is
created exclusively and never through a link); they are forced to the disk, and the new
file takes the place of the old one in a single step. A kill or a power cut at any moment leaves
the old file or the new one.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from geosurf.stopping import undone

# ---- sealed ----------------------------------------
# Files that carry a checksum of their own name and content, and are read only if no other user
# could have written them.


MARK = b"geosurf keeps 1\n"
# Group and others must not be able to write what is read back.
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
# O_NOFOLLOW: a link could lead to a file of another user.
_READ = (
    os.O_RDONLY
    | getattr(os, "O_NOFOLLOW", 0)
    | getattr(os, "O_NONBLOCK", 0)  # a pipe without a writer must not hang
    | getattr(os, "O_CLOEXEC", 0)
    | getattr(os, "O_BINARY", 0)
)


def sealed(name: str, payload: bytes) -> bytes:
    """Return the content of a file: mark, checksum of name and payload, payload.

    Examples
    --------
    >>> unsealed("primes", sealed("primes", b"2 3 5"))
    b'2 3 5'
    >>> unsealed("squares", sealed("primes", b"2 3 5")) is None
    True
    """
    # The name is part of the checksum: a file that is renamed serves no other purpose.
    return MARK + _digest(name, payload) + b"\n" + payload


def unsealed(name: str, data: bytes) -> bytes | None:
    """Return the payload of a file; None if it is not what was saved under this name."""
    # 64 hexadecimal digits and a line break follow the mark.
    start = len(MARK) + 65
    payload = data[start:]
    return payload if data[:start] == MARK + _digest(name, payload) + b"\n" else None


def _digest(name: str, payload: bytes) -> bytes:
    digest = hashlib.sha256(name.encode() + b"\0")
    digest.update(payload)
    return digest.hexdigest().encode()


def read_own(path: str | os.PathLike[str], largest: int) -> bytes:
    """Return the bytes of a regular file that only this user can write; OSError for others."""
    handle = os.open(path, _READ)
    # Everything is asked of the open file: between a test of its name and reading, the file behind
    # the name could change.
    with os.fdopen(handle, "rb") as file:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, "it is not a plain file")
        why = why_not_ours(found) if hasattr(os, "getuid") else ""
        if why:
            raise PermissionError(errno.EPERM, f"it {why}")
        if found.st_size > largest:
            raise OSError(errno.EFBIG, f"it has more than {largest >> 20} MB")
        # Never more than was allowed, even if the file is growing.
        return file.read(largest)


def why_not_ours(found: os.stat_result) -> str:
    """Return why other users could have written something; root always could."""
    # Files of root are accepted: root could do anything in any case.
    if found.st_uid not in (os.geteuid(), 0):
        return f"belongs to another user ({found.st_uid})"
    if found.st_mode & _OTHERS_WRITE:
        return f"can be written by others (mode {stat.S_IMODE(found.st_mode):03o})"
    return ""


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
        with undone(lambda: remove(part)):
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
