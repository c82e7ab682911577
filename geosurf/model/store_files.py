"""The files behind a grid that stays in its store, and whether they are those that were opened."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.errors import HorizonError


@dataclass(frozen=True)
class StoreFiles:
    """Files behind a grid.

    Attributes
    ----------
    paths : tuple of Path
        Files, and folders with all that is below them.
    state : str
        A hash of their names, sizes and times when the grid was opened.
    """

    paths: tuple[Path, ...]
    state: str

    @classmethod
    def of(cls, paths: Iterable[Path]) -> StoreFiles:
        """Look at files as they are now.

        Raises
        ------
        OSError
            If one of them is gone.
        """
        paths = tuple(paths)
        return cls(paths, _state_of(paths))

    def expect_unchanged(self, name: str) -> None:
        """Refuse files that have changed since: bounds of chunks, and results, are of the others.

        Raises
        ------
        HorizonError
            With the name of the horizon.
        """
        try:
            same = _state_of(self.paths) == self.state
        except OSError:
            same = False
        if not same:
            raise HorizonError(
                f"horizon {name!r}: its files in {self.paths[0]} have changed since they were "
                "opened. Results would mix old and new elevations. Open the store again and make "
                "a new scene.",
                surfaces=[name],
            )


def _state_of(paths: tuple[Path, ...]) -> str:
    digest = hashlib.sha256()
    for path in paths:
        _add(digest, path)
    return digest.hexdigest()


def _add(digest: Any, source: Path) -> None:
    """Add names, sizes and times of a file, or of all files in a folder."""
    folders = [source]
    if source.is_file():
        status = source.stat()
        digest.update(f"{source.name} {status.st_size} {status.st_mtime_ns}".encode())
        return
    while folders:
        with os.scandir(folders.pop()) as entries:
            for entry in sorted(entries, key=lambda one: one.name):
                if entry.is_dir(follow_symlinks=False):
                    folders.append(Path(entry.path))
                else:
                    status = entry.stat()
                    name = Path(entry.path).relative_to(source).as_posix()
                    digest.update(f"{name} {status.st_size} {status.st_mtime_ns}\n".encode())


__all__ = ["StoreFiles"]
