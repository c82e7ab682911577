"""Bytes to files, all or nothing.

Everything is made in memory first and then takes the place of what was there
(`geosurf.files.atomic`, `geosurf.files.folders`): a failed or killed write leaves the old file or
the new one.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePath, PurePosixPath

from geosurf.errors import OutputError
from geosurf.files.atomic import N_RANDOM, PREFIX, sync_folder, write_whole
from geosurf.files.folders import (
    Lock,
    Names,
    exchange,
    finish,
    make_stage,
    replace_files,
    sync_tree,
)
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


def commit_folder(
    folder: Path, files: Mapping[PurePosixPath, bytes], is_ours: Callable[[Path], bool]
) -> list[Path]:
    """Write a folder that is one thing, such as a store: the old one or the new one is there.

    Parameters
    ----------
    folder : pathlib.Path
        New, empty, or one that may be replaced.
    files : mapping of pathlib.PurePosixPath to bytes
        By path relative to the folder.
    is_ours : callable
        Whether a folder that is there may be replaced.

    Returns
    -------
    list of pathlib.Path
        The folder.

    Raises
    ------
    OutputError
        If something else is there, or it cannot be written. Then nothing has changed.
    """
    mine = hashlib.sha256(folder.name.encode(errors="surrogateescape")).hexdigest()[:N_RANDOM]
    lock = Lock(folder.parent / f"{PREFIX}lock-{mine}")
    stage, aside = (folder.parent.resolve() / f"{PREFIX}{word}-{mine}" for word in ("new", "old"))
    with _refused(folder):
        try:
            lock.take(wait=True)
            # a writer was killed between two renames: its old folder comes back first
            if aside.is_dir() and not aside.is_symlink() and not os.path.lexists(folder):
                aside.rename(folder)
            _refuse_stranger(folder, is_ours)
            make_stage(stage)
            for name, data in files.items():
                (stage / name).parent.mkdir(parents=True, exist_ok=True)
                (stage / name).write_bytes(data)
            sync_tree(stage)
            _swap_in(folder, stage, aside)
            sync_folder(folder.parent)
        finally:
            if lock.taken:
                shutil.rmtree(stage, ignore_errors=True)
            lock.release()
    return [folder]


def _refuse_stranger(folder: Path, is_ours: Callable[[Path], bool]) -> None:
    """Refuse to replace what may not be replaced."""
    if not os.path.lexists(folder):
        return
    plain = folder.is_dir() and not folder.is_symlink()
    if not plain or (any(folder.iterdir()) and not is_ours(folder)):
        raise OutputError(
            f"{folder} exists and is not, or not only, what geosurf wrote there, so it is not "
            "replaced. Give another path, or remove it."
        )


def _swap_in(folder: Path, stage: Path, aside: Path) -> None:
    """Let a stage become the folder, in one step where the system can; the old one goes."""
    if not os.path.lexists(folder):
        stage.rename(folder)
        return
    if exchange(stage, folder.parent.resolve() / folder.name):
        return  # the stage is the old folder now
    # there is no folder between two renames: nobody reads a mixture
    shutil.rmtree(aside, ignore_errors=True)
    folder.rename(aside)
    try:
        stage.rename(folder)
    except (OSError, KeyboardInterrupt):
        aside.rename(folder)
        raise
    shutil.rmtree(aside, ignore_errors=True)


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
