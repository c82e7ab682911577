"""Bytes to files, all or nothing.

Everything is made in memory first, then written beside its destination under
another name, then moved into place: a failed write leaves what was there before.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from geosurf.errors import OutputError


class Written(list[Path]):
    """Paths of the files written, and what the format could not hold.

    Attributes
    ----------
    notes : tuple of str
        One sentence per loss or convention that the file itself does not state:
        rounding to float32, names left out, elevation or depth.

    Examples
    --------
    >>> Written([Path("top.gri")], ["Values were rounded to float32."]).notes
    ('Values were rounded to float32.',)
    """

    def __init__(self, paths: Iterable[Path], notes: Iterable[str] = ()) -> None:
        super().__init__(paths)
        self.notes = tuple(notes)


def commit(files: Mapping[Path, bytes]) -> list[Path]:
    """Write all files, or none and say why.

    Parameters
    ----------
    files : mapping of pathlib.Path to bytes
        In the order in which they move into place: what refers to others comes last.

    Returns
    -------
    list of pathlib.Path

    Raises
    ------
    OutputError
        If a folder or file cannot be written.
    """
    staged: dict[Path, Path] = {}
    made: list[Path] = []
    try:
        for path, data in files.items():
            if not path.parent.exists() and path.parent.parent.is_dir() and len(files) > 1:
                path.parent.mkdir()
                made.append(path.parent)
            part = path.with_name(f".{path.name}.{os.getpid()}.part")
            staged[path] = part
            part.write_bytes(data)
        for path, part in staged.items():
            part.replace(path)
    except OSError as error:
        for part in staged.values():
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)
        for folder in made:
            with contextlib.suppress(OSError):
                folder.rmdir()
        reason = error.strerror or type(error).__name__
        raise OutputError(
            f"{path}: cannot be written ({reason}). Check that the folder exists, that you may "
            "write there and that the disk has room."
        ) from error
    return list(files)
