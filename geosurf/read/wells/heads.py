"""Where wells begin: the place at measured depth 0, by the name of each well."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geosurf.conventions import metres_per_unit, real_numbers
from geosurf.errors import FormatError, InputError
from geosurf.read._common import number
from geosurf.read._tops_layout import layout_of, plain_name, unit_in_name
from geosurf.read.wells.names import USUAL

Heads = dict[str, tuple[float, float, float]]
DATUM = ("kb", "rkb", "rt", "datum", "elevation", "z", "kbelevation", "rtelevation")
HOW = "Give {'W-1': (easting, northing, elevation)} in metres, or a table with Well, X, Y and KB."


def heads_of(heads: Any, decimal: str) -> Heads:
    """
    Return easting, northing and elevation [m] of wells at measured depth 0.

    Parameters
    ----------
    heads : mapping, path-like or None
        A mapping, or a table with the columns ``Well``, ``X``, ``Y`` and ``KB`` (elevation of the
        drill floor above sea level).
    decimal : {".", ","}

    Raises
    ------
    InputError, FormatError
        If it is neither, or a value is not a number.

    Examples
    --------
    >>> heads_of({"W-1": (500, 900, 25)}, ".")
    {'W-1': (500.0, 900.0, 25.0)}
    """
    if heads is None:
        return {}
    if isinstance(heads, Mapping):
        return {_name(name): _place(name, place) for name, place in heads.items()}
    if not hasattr(heads, "__fspath__") and not isinstance(heads, str):
        raise InputError(f"heads is a {type(heads).__name__}, not places of wells. {HOW}")
    path = Path(heads)
    layout = layout_of(path, decimal)
    words = [plain_name(word) for word in layout.header or ()]
    at = []
    for what, known in (
        ("well", USUAL["well"]), ("x", USUAL["x"]), ("y", USUAL["y"]), ("KB", DATUM)
    ):  # fmt: skip
        found = [k for k, word in enumerate(words) if word in known]
        if len(found) != 1:
            raise FormatError(
                f"{path}: found {len(found)} columns for {what} in "
                f"{', '.join(layout.header or ()) or 'no header'}, expected one of "
                f"{', '.join(known)}. {HOW}"
            )
        at.append(found[0])
    units = [unit_in_name(layout.header[k]) if layout.header else None for k in at]
    scale = [metres_per_unit(unit or "m", f"{path.name}: heads of wells") for unit in units]
    result: Heads = {}
    for line, row in layout.rows:
        x, y, z = (number(row[k].replace(decimal, "."), path, line, "x, y or KB") for k in at[1:])
        if row[at[0]] in result:
            raise FormatError(f"{path}, line {line}: well {row[at[0]]!r} is there twice. Keep one.")
        result[row[at[0]]] = (x * scale[1], y * scale[2], z * scale[3])
    return result


def holds_heads(head: bytes) -> bool:
    """
    Return whether a table begins as one of well heads: names, places, and the drill floor.

    Examples
    --------
    >>> holds_heads(b"Well,X,Y,KB"), holds_heads(b"Well,X,Y,Z")
    (True, False)
    """
    first = head.decode("utf-8", "replace").lstrip().split("\n", 1)[0]
    words = [plain_name(word) for word in re.split(r"[,;\t]" if "," in first else r"[;\t]", first)]
    known = (USUAL["well"], USUAL["x"], USUAL["y"], DATUM[:4])
    return len(words) >= 4 and all(any(word in names for word in words) for names in known)


def _name(name: Any) -> str:
    if not isinstance(name, str) or not name:
        raise InputError(f"heads has the name {name!r}, expected the name of a well. {HOW}")
    return name


def _place(name: str, place: Any) -> tuple[float, float, float]:
    try:
        x, y, z = real_numbers(place).tolist()
    except (TypeError, ValueError) as error:
        raise InputError(f"heads[{name!r}] is {place!r}, not three numbers. {HOW}") from error
    if not all(abs(value) < float("inf") for value in (x, y, z)):
        raise InputError(f"heads[{name!r}] is {place!r}, which is not finite. {HOW}")
    return float(x), float(y), float(z)


__all__ = ["heads_of", "holds_heads"]
