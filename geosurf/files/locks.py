"""A claim on a folder or file, held by one writer at a time.

The claim is a lock of the operating system on a small hidden file. The system gives it back when
its process ends, however that ends; so who gets the claim knows that all others are gone, and that
what they left behind can be removed.
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path

if sys.platform == "win32":  # pragma: no cover - another system
    import msvcrt
else:
    import fcntl

_FLAGS = (
    os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)
)  # no link is followed
_HELD = (BlockingIOError, PermissionError)


class Lock:
    """An exclusive claim, named by a hidden file that is there as long as somebody has it.

    Parameters
    ----------
    path : pathlib.Path

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / ".geosurf-lock"
    >>> one, two = Lock(path), Lock(path)
    >>> one.take(), two.take()
    (True, False)
    >>> one.release()
    >>> two.take(), two.release(), path.exists()
    (True, None, False)
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._handle: int | None = None
        self.works = True  # some network disks have no locks: then everybody gets the claim

    def take(self, *, wait: bool = False) -> bool:
        """Get the claim, after whoever has it if asked to wait; False if somebody else has it.

        Raises
        ------
        OSError
            If the file cannot be made.
        """
        while True:
            handle = os.open(self._path, _FLAGS, 0o666)
            try:
                got = self._claim(handle, wait)
            except KeyboardInterrupt:
                os.close(handle)
                raise

            # A file that was removed while we waited is not a claim: try the one that took its
            # place.
            if got and (not self.works or _is_at(handle, self._path)):
                self._handle = handle
                return True
            os.close(handle)  # held, or removed by the one who had it: then there is a new one
            if not got:
                return False

    @property
    def taken(self) -> bool:
        """Whether it was taken, and not given back since."""
        return self._handle is not None

    def release(self) -> None:
        """Give it back; without effect if it was not taken."""
        if self._handle is None:
            return
        if sys.platform != "win32":
            self._remove()  # while we have it, so that nobody else's file is removed
        os.close(self._handle)
        if sys.platform == "win32":  # pragma: no cover - there an open file cannot be removed
            self._remove()
        self._handle = None

    def _remove(self) -> None:
        if self._handle is not None and (
            sys.platform == "win32" or _is_at(self._handle, self._path)
        ):
            with suppress(OSError):
                self._path.unlink()

    def _claim(self, handle: int, wait: bool) -> bool:
        try:
            if sys.platform == "win32":  # pragma: no cover - another system
                msvcrt.locking(handle, msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
            else:
                # given back by the system when the process ends, however it ends
                fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except _HELD:
            return False
        except OSError:
            self.works = False
        return True


def _is_at(handle: int, path: Path) -> bool:
    """Whether an open file is still the one at a path."""
    try:
        return os.path.samestat(os.fstat(handle), path.lstat())
    except OSError:
        return False
