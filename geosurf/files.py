"""Write bytes to a file completely, or leave the old file: all writers use this module.

Data go to a new file next to the destination, under a random name that cannot be planted (it is
created exclusively and never through a link); they are forced to the disk, and the new
file takes the place of the old one in a single step. A kill or a power cut at any moment leaves
the old file or the new one.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import shutil
import stat
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from geosurf.errors import OutputError
from geosurf.stopping import undone

# ---- sealed ----------------------------------------
# Files that carry a checksum of their own name and content, and are read only if no other user
# could have written them.


SEAL = b"geosurf keeps 1\n"
# Group and others must not be able to write what is read back.
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
# O_NOFOLLOW: a link could lead to a file of another user.
_SAFE = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
_READ = os.O_RDONLY | _SAFE | getattr(os, "O_NONBLOCK", 0)  # a pipe without a writer must not hang


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
    return SEAL + _digest(name, payload) + b"\n" + payload


def unsealed(name: str, data: bytes) -> bytes | None:
    """Return the payload of a file; None if it is not what was saved under this name."""
    # 64 hexadecimal digits and a line break follow the mark.
    start = len(SEAL) + 65
    payload = data[start:]
    return payload if data[:start] == SEAL + _digest(name, payload) + b"\n" else None


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
        state = os.fstat(handle)
        if not stat.S_ISREG(state.st_mode):
            raise OSError(errno.EINVAL, "it is not a plain file")
        why = why_not_ours(state) if hasattr(os, "getuid") else ""
        if why:
            raise PermissionError(errno.EPERM, f"it {why}")
        if state.st_size > largest:
            raise OSError(errno.EFBIG, f"it has more than {largest >> 20} MB")
        # Never more than was allowed, even if the file is growing.
        return file.read(largest)


def why_not_ours(state: os.stat_result) -> str:
    """Return why other users could have written something; root always could."""
    # Files of root are accepted: root could do anything in any case.
    if state.st_uid not in (os.geteuid(), 0):
        return f"belongs to another user ({state.st_uid})"
    if state.st_mode & _OTHERS_WRITE:
        return f"can be written by others (mode {stat.S_IMODE(state.st_mode):03o})"
    return ""


PREFIX, SUFFIX = ".geosurf-", ".part"
N_RANDOM = 16  # hexadecimal digits of a random name
ABANDONED = 24 * 3600.0  # [s]; a single file is written in less
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | _SAFE


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


def write_into_folder(path: Path, data: bytes, what: str) -> Path:
    """
    Write a file whose folder is created if it is missing.

    Parameters
    ----------
    path : pathlib.Path
    data : bytes
    what : str
        What it is, for the message: ``"the report"``.

    Returns
    -------
    pathlib.Path

    Raises
    ------
    OutputError
        If the folder or the file cannot be written.
    """
    remedy = "Choose a folder that you can write to."
    with refused_writing(f"{path}: {what}", path.parent, remedy):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, data)
    return path


@contextmanager
def refused_writing(what: str, folder: Path, remedy: str) -> Iterator[None]:
    """
    Say why something cannot be written into a folder, and what to do.

    Parameters
    ----------
    what : str
        Beginning of the sentence: ``"out/report.html: the report"``.
    folder : pathlib.Path
    remedy : str

    Raises
    ------
    OutputError
        For each OSError of the ``with`` block.
    """
    try:
        yield
    except OSError as error:
        file = next((one for one in (folder, *folder.parents) if one.is_file()), None)
        reason = error.strerror or type(error).__name__
        reason = reason if file is None else f"{file} is a file, not a folder"
        raise OutputError(f"{what} cannot be written ({reason}). {remedy}") from error


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


# ---- folders ----------------------------------------
# Many files to a folder: after a kill at any moment there are the old ones or the new ones.
#
# New files are made in a hidden folder, the stage, and forced to the disk. Then one step decides:
# the stage is renamed to a journal. From then on the new files count. Old files are removed before
# new ones move in, so that there is no mixture at any time; after a kill, the next writer finds the
# journal and goes on (`finish`).
#
# Nothing is removed or written through a link, and no name leaves the folder, whatever a journal
# holds.


# ---- locks ----------------------------------------
# A claim on a folder or file, held by one writer at a time.
#
# The claim is a lock of the operating system on a small hidden file. The system gives it back
# when its process ends, however that ends; so who gets the claim knows that all others are gone,
# and that what they left behind can be removed.


if sys.platform == "win32":  # pragma: no cover - another system
    import msvcrt
else:
    import fcntl

_FLAGS = os.O_RDWR | os.O_CREAT | _SAFE
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


MARK = "UNFINISHED.txt"  # of a stage: moves in first, and goes when all is in place
_LIST = ".geosurf-files"  # in a journal: names of the old and the new files


@dataclass(frozen=True)
class Names:
    """Which files of a folder are ours.

    Parameters
    ----------
    patterns : tuple of re.Pattern
        Of names relative to the folder, with slashes.
    folders : tuple of str
        The folders in it that these patterns name.
    """

    patterns: tuple[re.Pattern[str], ...]
    folders: tuple[str, ...]

    def __contains__(self, path: PurePosixPath) -> bool:
        """Whether a relative name is one of ours; never one that leaves the folder."""
        # no absolute name, no way up, at most one folder deep: whatever a journal claims
        inside = not path.is_absolute() and ".." not in path.parts and len(path.parts) <= 2
        return inside and any(p.fullmatch(path.as_posix()) for p in self.patterns)

    def found_in(self, folder: Path) -> Iterator[PurePosixPath]:
        """Give our files in a folder, links among them, but nothing behind linked folders."""
        for place in (folder, *(folder / name for name in self.folders)):
            if place != folder and (place.is_symlink() or not place.is_dir()):
                continue
            for path in place.iterdir():
                name = PurePosixPath(path.relative_to(folder).as_posix())
                if name in self and (path.is_symlink() or path.is_file()):
                    yield name


# ---- a journal ---------------------------------------------------------------------------


def make_stage(stage: Path) -> None:
    """Make an empty folder; what a killed writer left there goes, and never through a link."""
    if stage.is_dir() and not stage.is_symlink():
        shutil.rmtree(stage)
    stage.unlink(missing_ok=True)
    stage.mkdir()


def replace_files(
    folder: Path, stage: Path, old: Iterable[PurePosixPath], names: Names, journal: str
) -> None:
    """Let the files of a stage take the place of old ones, by way of a journal.

    Parameters
    ----------
    folder, stage : pathlib.Path
        The stage lies in the folder.
    old : iterable of pathlib.PurePosixPath
        Files in the folder that go away, relative to it.
    names : Names
        Those that may be written and removed.
    journal : str
        Name of the journal in the folder.

    Raises
    ------
    OSError
        Before the journal is there: nothing has changed. After that: `finish` goes on.
    """
    listed = {
        "old": [path.as_posix() for path in old if path.name != MARK],
        "new": [path.as_posix() for path in files_in(stage) if path.name != MARK],
    }

    # Find obstacles before anything changes.
    for name in listed["new"]:
        _require_place(_inside(folder, PurePosixPath(name)))

    # The rename decides: from then on a killed run is finished by the next one.
    (stage / _LIST).write_text(json.dumps(listed), encoding="utf-8")
    sync_tree(stage)
    stage.rename(folder / journal)
    sync_folder(folder)

    with undone(lambda: finish(folder, names, journal)):
        try:
            finish(folder, names, journal)
        except KeyboardInterrupt:
            finish(folder, names, journal)
            raise


def finish(folder: Path, names: Names, journal: str) -> bool:
    """Carry out the rest of a journal; return False if there is no journal.

    Raises
    ------
    OSError
    """
    source = folder / journal
    if source.is_symlink() or not source.is_dir():
        return False

    # From here, each step can be repeated, so that a second kill does no harm.
    new, old = _read_list(source / _LIST, names)
    if (source / MARK).is_file():
        (source / MARK).replace(folder / MARK)
        sync_folder(folder)

    # Old files go first, except those that a new one replaces in one step.
    for name in old:
        if name not in new or (source / name).is_file():
            _inside(folder, name).unlink(missing_ok=True)

    moved: set[Path] = {folder}
    for name in new:
        if (source / name).is_file():
            target = _inside(folder, name)
            target.parent.mkdir(exist_ok=True)
            (source / name).replace(target)
            moved.add(target.parent)

    for name in old:
        with suppress(OSError):
            if name.parent != PurePosixPath():
                (folder / name.parent).rmdir()  # if it is empty

    # Names reach the disk before the journal goes; without it nothing is repeated.
    for place in moved:
        sync_folder(place)

    with suppress(FileNotFoundError):
        (folder / MARK).unlink()
    shutil.rmtree(source)
    return True


def files_in(stage: Path) -> list[PurePosixPath]:
    """Files of a stage relative to it; those at the top, which refer to others, come last."""
    found = [path.relative_to(stage) for path in stage.rglob("*") if path.is_file()]
    return sorted((PurePosixPath(path.as_posix()) for path in found), key=_order)


def _order(path: PurePosixPath) -> tuple[int, str]:
    return -len(path.parts), path.as_posix()


def _read_list(path: Path, names: Names) -> tuple[list[PurePosixPath], list[PurePosixPath]]:
    """New and old names of a journal; nothing where it was not written to its end."""
    try:
        # no list: the run was killed while it removed the journal, and all files are in place
        found = json.loads(path.read_text(encoding="utf-8"))
        new, old = ([PurePosixPath(name) for name in found[key]] for key in ("new", "old"))
    except FileNotFoundError:
        return [], []
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise OSError(errno.EINVAL, f"{path} is not a list of files") from error

    # A journal from elsewhere must not remove or write other files.
    for name in (*new, *old):
        if name not in names:
            raise OSError(errno.EINVAL, f"{path} names {name}, which geosurf does not write")
    return new, old


def _inside(folder: Path, name: PurePosixPath) -> Path:
    """A file in a folder; its own folder must not be a link."""
    target = folder / name
    if target.parent != folder and target.parent.is_symlink():
        raise OSError(errno.ELOOP, f"{target.parent} is a link")
    return target


def _require_place(target: Path) -> None:
    """Raise an error while nothing has changed, where a file cannot go to its place."""
    if target.is_dir() and not target.is_symlink():
        raise IsADirectoryError(errno.EISDIR, f"{target.name} is a folder and should be a file")
    if os.path.lexists(target.parent):
        if not target.parent.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, f"{target.parent.name} should be a folder")
        if not os.access(target.parent, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, f"the folder {target.parent.name} is read-only")


def sync_tree(folder: Path) -> None:
    """Force all files and names below a folder to the disk."""
    for path in folder.rglob("*"):
        if path.is_dir():
            sync_folder(path)
        elif path.is_file():
            handle = os.open(path, os.O_RDWR | getattr(os, "O_CLOEXEC", 0))
            try:
                os.fsync(handle)
            finally:
                os.close(handle)
    sync_folder(folder)
