"""Tables of inputs: the files, their sizes and hashes."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.model.expected import expect, path_of
from geosurf.model.protocols import ReportedModel
from geosurf.report.page import NOTHING, Table, number

DIGITS = 16  # of a hash: enough to tell files apart
HOW = "give {name: path of a file}"


@dataclass(frozen=True)
class InputFile:
    """A file that a model was made of: its path as printed, and its bytes.

    Attributes
    ----------
    name, path : str
    size : int or None
        [bytes]; None where the file is no longer there.
    digest : str
        SHA-256, hexadecimal.
    """

    name: str
    path: str
    size: int | None
    digest: str


def input_files(
    scene: ReportedModel,
    inputs: Mapping[str, Any] | None,
    relative_to: str | os.PathLike[str] | None,
) -> tuple[InputFile, ...]:
    """Return the files of a model, hashed.

    Parameters
    ----------
    scene : Scene
    inputs : mapping of str to path-like, optional
        Default: the inputs of the scene that are paths.
    relative_to : path-like, optional
        Folder that printed paths start from. Default: the current folder.

    Returns
    -------
    tuple of InputFile
    """
    return described_files(scene.input_files if inputs is None else inputs, relative_to)


def described_files(
    inputs: Mapping[str, Any], relative_to: str | os.PathLike[str] | None
) -> tuple[InputFile, ...]:
    """Return files by name, hashed; see `input_files`.

    Examples
    --------
    >>> described_files({"Top": "missing.gri"}, None)[0].size is None
    True
    """
    expect(inputs, Mapping, "inputs takes a mapping", HOW)
    start = Path.cwd() if relative_to is None else path_of(relative_to, "relative_to")
    files = {str(name): path_of(path, f"input {name!r}") for name, path in inputs.items()}
    return tuple(_described(name, path, start) for name, path in files.items())


def _described(name: str, path: Path, start: Path) -> InputFile:
    """One file: what cannot be read any more is listed without size and hash."""
    try:
        shown = Path(os.path.relpath(path, start)).as_posix()
    except ValueError:  # another drive: there is no way from one to the other
        shown = path.name
    try:
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        return InputFile(name, shown, path.stat().st_size, digest)
    except OSError:
        return InputFile(name, shown, None, "")


def file_table(files: Iterable[InputFile], crs: str) -> Table:
    """Return the files: name, path, size, hash and coordinate reference system.

    Examples
    --------
    >>> file_table([InputFile("Top", "top.gri", 12, "ab" * 32)], "").rows
    (('Top', 'top.gri', 'abababababababab', '–', '12'),)
    """
    rows = tuple(
        (
            file.name,
            file.path,
            file.digest[:DIGITS] or "not found",
            crs or NOTHING,
            NOTHING if file.size is None else number(file.size),
        )
        for file in files
    )
    head = ("Input", "File", f"SHA-256, first {DIGITS} digits", "CRS", "Size [bytes]")
    return Table(head, rows, n_label=4)
