"""Well tops that have measured depths only: their places lie on the paths of the wells."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.errors import FormatError, InputError
from geosurf.read._common import agreed_scale
from geosurf.read._tops_layout import Layout, unit_in_name

Paths = dict[str, tuple[np.ndarray, np.ndarray]]


def paths_with_depths(wells: Any) -> Paths:
    """
    Return measured depths (n,) and places (n, 3) of each well, or name what is missing.

    Parameters
    ----------
    wells : xarray.Dataset
        As `read_wells` returns it.

    Raises
    ------
    InputError
    """
    names = ("well", "md", "easting", "northing", "elevation")
    lacking = [name for name in names if name not in getattr(wells, "data_vars", ())]
    if lacking:
        raise InputError(
            f"wells= has no {', '.join(lacking)}. Pass what gs.read_wells returns for paths with "
            "measured depths."
        )
    label = wells["well"].values
    columns = {name: np.asarray(wells[name].values, dtype=np.float64) for name in names[1:]}
    found: Paths = {}
    for name in dict.fromkeys(label.tolist()):
        at = (label == name) & ~np.isnan(columns["md"])
        md = columns["md"][at]
        if len(md) < 2 or not (np.diff(md) > 0).all():
            raise InputError(
                f"wells=: the measured depths of well {name!r} do not rise from point to point. "
                "Read its path with measured depths."
            )
        places = np.column_stack([columns[axis][at] for axis in names[2:]])
        found[str(name)] = (md, places)
    return found


def metres_of_depths(path: Path, layout: Layout, place: int, length_unit: str | None) -> float:
    """Metres in a unit of the column of measured depths."""
    own = unit_in_name(layout.header[place]) if layout.header else None
    unit = own or layout.length_unit
    return agreed_scale(unit, length_unit, "m", f"{path.name}: measured depths")


def place_along(path: Path, line: int, well: str, md: float, paths: Paths) -> np.ndarray | None:
    """
    Return easting, northing and elevation at a measured depth; None beyond the path.

    Raises
    ------
    FormatError
        If the well has no path.
    """
    if well not in paths:
        raise FormatError(
            f"{path}, line {line}: well {well!r} has no path in wells=.{did_you_mean(well, paths)} "
            f"Wells with paths are {', '.join(list(paths)[:12])}."
        )
    depths, places = paths[well]
    if not depths[0] <= md <= depths[-1]:
        return None
    return np.array([np.interp(md, depths, axis) for axis in places.T])


__all__ = ["metres_of_depths", "paths_with_depths", "place_along"]
