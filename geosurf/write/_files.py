"""Bytes to files, all or nothing.

Everything is made in memory first and then takes the place of what was there
(`geosurf.files.atomic`, `geosurf.files.folders`): a failed or killed write leaves the old file or
the new one.
"""

from __future__ import annotations

import errno
import hashlib
import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePath, PurePosixPath

from geosurf.errors import OutputError
from geosurf.files.atomic import N_RANDOM, PREFIX, write_whole
from geosurf.files.folders import Names, finish, make_stage, replace_files
from geosurf.files.locks import Lock
from geosurf.write.written import Loss

# files by path relative to the folder of their index, what is lost, and a pattern of their names
FileSet = tuple[dict[PurePath, bytes], list[Loss], re.Pattern[str] | None]


def commit(path: Path, data: bytes) -> list[Path]:
    """Write a file, or leave the old file and raise an error.

    Raises
    ------
    OutputError
        If the folder or file cannot be written.
    """
    with _refused(path):
        write_whole(path, data)
    return [path]


def commit_set(
    index: Path, files: Mapping[PurePath, bytes], ours: re.Pattern[str] | None = None
) -> list[Path]:
    """Write an index and the files in the folder next to it that it names: all of them or none.

    Files that an earlier index names and the new one does not are removed. While the files are
    exchanged there is no index, so that nobody reads a mixture; a write that is killed then is
    finished by the next one.

    Parameters
    ----------
    index : pathlib.Path
    files : mapping of pathlib.PurePath to bytes
        By path relative to the folder of the index, which is among them.
    ours : re.Pattern, optional
        Names that this writer makes; default: those of a ``.vtm`` and its folder.

    Returns
    -------
    list of pathlib.Path

    Raises
    ------
    OutputError
        If the folder or a file cannot be written.
    """
    folder, parts = index.parent, index.with_suffix("")

    # names that this writer makes: nothing else in the folder is ever replaced or removed
    part = re.escape(parts.name) + r"/\d{3,}_[A-Za-z0-9+_-]+\.vtp"
    names = Names((re.compile(re.escape(index.name)), re.compile(part)), (parts.name,))
    names = names if ours is None else Names((ours,), ())

    # lock, stage and journal belong to this index: two indexes in one folder do not wait
    mine = hashlib.sha256(index.name.encode(errors="surrogateescape")).hexdigest()[:N_RANDOM]
    lock, stage = Lock(folder / f"{PREFIX}lock-{mine}"), folder / f"{PREFIX}new-{mine}"
    with _refused(index):
        try:
            # in turn: claim, finish what a killed writer left, stage all files, then replace
            lock.take(wait=True)
            if parts.is_symlink():
                raise OSError(errno.ELOOP, f"{parts.name} next to it is a link")
            finish(folder, names, f"{PREFIX}commit-{mine}")
            make_stage(stage)
            for name, data in files.items():
                (stage / name).parent.mkdir(parents=True, exist_ok=True)
                (stage / name).write_bytes(data)
            replace_files(folder, stage, _named_by(index, names), names, f"{PREFIX}commit-{mine}")
        finally:
            if lock.taken:
                shutil.rmtree(stage, ignore_errors=True)
            lock.release()
    return [folder / name for name in files]


def _named_by(index: Path, names: Names) -> list[PurePosixPath]:
    """An index that is there, first, and the files next to it that it names."""
    try:
        text = index.read_text(encoding="utf-8", errors="replace")
    except FileNotFoundError:
        return []

    # only parts that the old index names: others may belong to somebody
    found = [name for name in names.found_in(index.parent) if f'/{name.name}"' in text]
    return [PurePosixPath(index.name), *sorted(found)]


@contextmanager
def _refused(path: Path) -> Iterator[None]:
    """Say why something cannot be written."""
    try:
        yield
    except OSError as error:
        # the system's own words, and what a user can check
        reason = error.strerror or type(error).__name__
        raise OutputError(
            f"{path}: cannot be written ({reason}). Check that the folder exists, that you may "
            "write there and that the disk has room."
        ) from error
