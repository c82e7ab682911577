"""Files that carry a checksum of their own name and content, and are read only if no other user
could have written them.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat

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
