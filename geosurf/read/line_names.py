"""Names of the faults that one file of lines holds, for functions that read them one by one."""

from __future__ import annotations

from pathlib import Path

from geosurf.errors import FormatError
from geosurf.read.features import features
from geosurf.read.polylines import read_charisma

# formats whose files may hold the sticks of several faults
NAMED_LINES = ("charisma", "geojson", "shapefile")


def fault_names(path: Path, key: str) -> list[str]:
    r"""
    Return the names of the faults in a file of lines, "" for lines without a name.

    Parameters
    ----------
    path : pathlib.Path
    key : {"charisma", "geojson", "shapefile"}

    Raises
    ------
    FormatError
        If the file is damaged, or holds points or areas.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "faults.dat"
    >>> rows = "INLINE- 1 2 0 0 5 F1 1\nINLINE- 1 2 0 0 9 F1 1\nINLINE- 1 2 5 0 5 F2 1\n"
    >>> _ = file.write_text(rows)
    >>> fault_names(file, "charisma")
    ['F1', 'F2']
    """
    if key == "charisma":
        return list(dict.fromkeys(read_charisma(path).names or []))
    found = features(path).checked()
    names = [one.name for one in found.only(("line",), "read_fault")]
    if not names:
        raise FormatError(f"{path}: the file has no lines. Export it again.")
    return list(dict.fromkeys(names))
