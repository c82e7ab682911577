"""What was written, what the format could not hold, and how bytes become files: all or nothing."""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path, PurePath, PurePosixPath
from typing import Any

from geosurf.conventions.crs import crs_of, epsg_of, label, proj_system
from geosurf.conventions.machine import install_line, is_installed
from geosurf.errors import OutputError
from geosurf.files import (
    N_RANDOM,
    PREFIX,
    Lock,
    Names,
    finish,
    make_stage,
    refused_writing,
    replace_files,
    sync_folder,
    sync_tree,
    write_whole,
)
from geosurf.model.base import Noun
from geosurf.stopping import in_the_end

# ---- losses ----------------------------------------


SMALLEST = 1e-6  # smaller differences than this [m] are not listed

# what a format may lose -> what it means
LOSSES = {
    "precision": "coordinates or values were rounded",
    "crs": "the coordinate reference system is not in the file",
    "direction": "the file does not state whether z is elevation or depth",
    "unit": "the file does not state the unit of z",
    "name": "names are not in the file, or not all of them",
    "undefined": "nodes without value are not in the file",
    "grid": "rows and columns of a grid are not in the file, or not as they were",
    "data": "numbers or words of vertices, lines or cells are not in the file",
    "topology": "which corners are the same vertex is not in the file",
    "other": "see the sentence",
}


@dataclass(frozen=True)
class Loss:
    """
    Something that a format could not hold.

    Attributes
    ----------
    what : str
        A key of `geosurf.write.written.LOSSES`: ``"precision"``, ``"crs"``, ``"direction"`` ...
    sentence : str
        What was lost, and what to do about it.
    metres : float or None
        Largest difference [m] of a coordinate or value, where rounding is the loss.
    """

    what: str
    sentence: str
    metres: float | None = None

    def __str__(self) -> str:
        return self.sentence


# files by path relative to the folder of their index, what is lost, and a pattern of their names
FileSet = tuple[dict[PurePath, bytes], list[Loss], re.Pattern[str] | None]


class Written(list[Path]):
    """Paths of the files written, and what the format could not hold.

    Attributes
    ----------
    lost : tuple of Loss
        One for each thing that the files do not hold, or that their reader needs to know.
    notes : tuple of str
        The sentences of the same.
    largest_difference : float
        Of coordinates and values [m]; 0 where all differences are below 1e-6 m.

    Examples
    --------
    >>> Written([Path("top.gri")], [Loss("precision", "Values were rounded by up to 0.1 m.", 0.1)])
    top.gri
      precision: Values were rounded by up to 0.1 m.
    """

    def __init__(self, paths: Iterable[Path], lost: Iterable[Loss | str] = ()) -> None:
        super().__init__(paths)
        self.lost = tuple(loss if isinstance(loss, Loss) else Loss("other", loss) for loss in lost)

    @property
    def notes(self) -> tuple[str, ...]:
        """One sentence for each loss."""
        return tuple(loss.sentence for loss in self.lost)

    @property
    def largest_difference(self) -> float:
        """Largest difference of coordinates and values [m]."""
        return max((loss.metres for loss in self.lost if loss.metres is not None), default=0.0)

    def to_dict(self) -> dict[str, Any]:
        """Return the same in words and numbers that JSON holds."""
        return {"files": [str(path) for path in self], "lost": list(map(asdict, self.lost))}

    def __repr__(self) -> str:
        files = [str(path) for path in self]
        if len(files) > 2:
            files = [f"{files[0]} and {len(files) - 1} more files"]
        return "\n".join([*files, *(f"  {loss.what}: {loss.sentence}" for loss in self.lost)])


def name_lost(name: str, written: str) -> list[Loss]:
    """Return a loss for a name that a format writes in another way, or nothing.

    Examples
    --------
    >>> name_lost("a{1}", "a(1)"), name_lost("F1", "F1")
    ([Loss(what='name', sentence="The name 'a{1}' is written as 'a(1)'.", metres=None)], [])
    """
    words = f"The name {name!r} is written as {written!r}."
    return [] if name == written else [Loss("name", words)]


def precision_lost(metres: float, what: str) -> list[Loss]:
    """Return a loss for a rounding, or nothing for one that nobody can measure.

    Examples
    --------
    >>> precision_lost(0.25, "Nodes were moved"), precision_lost(1e-9, "Nodes were moved")
    ([Loss(what='precision', sentence='Nodes were moved by up to 0.25 m.', metres=0.25)], [])
    """
    if not metres > SMALLEST:
        return []
    return [Loss("precision", f"{what} by up to {metres:.3g} m.", float(metres))]


# ---- prj ----------------------------------------
# The file ``.prj`` of ESRI: the coordinate reference system of a file that has no place for it.


def prj_of(crs: str) -> tuple[bytes | None, list[Loss]]:
    """
    Return the content of a ``.prj``, or why there is none.

    Parameters
    ----------
    crs : str

    Returns
    -------
    content : bytes or None
        A description in WKT, in the words of ESRI where pyproj is installed.
    lost : list of Loss

    Examples
    --------
    >>> prj_of('PROJCS["ED50 / UTM zone 31N"]')
    (b'PROJCS["ED50 / UTM zone 31N"]', [])
    """
    if "[" in crs:
        return " ".join(crs.split()).encode("utf-8"), []
    reason = "it is not an EPSG code"
    if epsg_of(crs) is not None and not is_installed("pyproj"):
        reason = f"pyproj is not installed: {install_line('pyproj')}"
    elif epsg_of(crs) is not None:
        with suppress(RuntimeError):  # pyproj raises it where ESRI has no words for a system
            if system := proj_system(f"EPSG:{epsg_of(crs)}"):
                return system.to_wkt("WKT1_ESRI").encode("utf-8"), []
        reason = "pyproj does not know it, or ESRI has no words for it"
    return None, [
        Loss(
            "crs",
            f"The coordinate reference system (CRS), {label(crs)}, is not in the file, and no "
            f".prj was written: {reason}.",
        )
    ]


def declared_crs(obj: Any) -> str | None:
    """Return the reference system that an object declares."""
    if isinstance(obj, Noun):
        return obj.crs
    return None if isinstance(obj, list | tuple) else crs_of(obj)


def own_name(obj: Any) -> str | None:
    """Return what an object calls itself: its name, or its ``long_name`` attribute."""
    name = getattr(obj, "name", None)
    if name is None:
        name = getattr(obj, "attrs", {}).get("long_name")
    return None if name is None else str(name)


# ---- files ----------------------------------------
# Bytes to files, all or nothing.
#
# Everything is made in memory first and then takes the place of what was there (`geosurf.files`):
# a failed or killed write leaves the old file or the new one.


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
    key = _key_of(index)
    lock, stage = Lock(folder / f"{PREFIX}lock-{key}"), folder / f"{PREFIX}new-{key}"
    journal = f"{PREFIX}commit-{key}"
    with _refused(index), in_the_end(lambda: _leave(lock, stage)):
        # in turn: claim, finish what a killed writer left, stage all files, then replace
        lock.take(wait=True)
        if parts.is_symlink():
            raise OSError(errno.ELOOP, f"{parts.name} next to it is a link")
        finish(folder, names, journal)
        _fill_stage(stage, files)
        replace_files(folder, stage, _named_by(index, names), names, journal)
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
    key = _key_of(folder)
    lock = Lock(folder.parent / f"{PREFIX}lock-{key}")
    stage, aside = (folder.parent.resolve() / f"{PREFIX}{word}-{key}" for word in ("new", "old"))
    with _refused(folder), in_the_end(lambda: _leave(lock, stage)):
        lock.take(wait=True)
        # where a writer was killed between two renames, its old folder comes back first
        if aside.is_dir() and not aside.is_symlink() and not os.path.lexists(folder):
            aside.rename(folder)
        _refuse_stranger(folder, is_ours)
        _fill_stage(stage, files)
        sync_tree(stage)
        _swap_in(folder, stage, aside)
        sync_folder(folder.parent)
    return [folder]


def _key_of(path: Path) -> str:
    """Characters that are the same for all writers of a path: in names of lock and stage."""
    return hashlib.sha256(path.name.encode(errors="surrogateescape")).hexdigest()[:N_RANDOM]


def _fill_stage(stage: Path, files: Mapping[Any, bytes]) -> None:
    """Make a stage with some files."""
    make_stage(stage)
    for name, data in files.items():
        (stage / name).parent.mkdir(parents=True, exist_ok=True)
        (stage / name).write_bytes(data)


def _leave(lock: Lock, stage: Path) -> None:
    """Remove the stage of a writer that has the lock, and give this back."""
    if lock.taken:
        shutil.rmtree(stage, ignore_errors=True)
    lock.release()


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
    """Let a stage become the folder; the old one goes."""
    if not os.path.lexists(folder):
        stage.rename(folder)
        return
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
    parts = [name for name in names.found_in(index.parent) if f'/{name.name}"' in text]
    return [PurePosixPath(index.name), *sorted(parts)]


def _refused(path: Path) -> AbstractContextManager[None]:
    """Say why something cannot be written, and what a user can check."""
    remedy = "Check that the folder exists, that you may write there and that the disk has room."
    return refused_writing(f"{path}:", path.parent, remedy)
