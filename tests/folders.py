"""What is in a folder."""

from __future__ import annotations

from pathlib import Path


def bytes_in(folder: Path) -> dict[str, bytes]:
    """All files, hidden ones too, by their paths in it."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
