"""Horizons that are to be torn, as grids or points: their data, and where they lie in the map."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import rising_diagonal
from geosurf.conventions.crs import crs_of
from geosurf.errors import GeosurfWarning, HorizonError
from geosurf.model import Lattice, Sheet, TriSurface
from geosurf.model.faults import in_order
from geosurf.scene.inputs import SceneInputs
from geosurf.triangulate.horizon import EXTRAPOLATED
from geosurf.triangulate.stored import is_stored, read_stored

BETWEEN = 3  # cells: scattered points may be twice as far apart, and still cover what is between

Options = Mapping[str, Any]
Lookup = Callable[[str], TriSurface]


def opened_horizon(value: Any, options: Options) -> Any:
    """Return the data of a horizon that is to be torn; a path is read, as points or as a grid."""
    if isinstance(value, str | Path):
        from geosurf.read import otherwise, read_horizon, read_points

        read = read_points if holds_points(value) else read_horizon
        value = read(value, **otherwise(options))
    return read_stored(value, "to be torn") if is_stored(value) else value


def holds_points(path: str | Path) -> bool:
    """Return whether a file holds points by its suffix, and no grid or mesh."""
    from geosurf.read import HORIZON_FORMATS, POINT_FORMATS

    return Path(path).suffix.lower() in _suffixes(POINT_FORMATS) - _suffixes(HORIZON_FORMATS)


def _suffixes(formats: Mapping[str, Any]) -> set[str]:
    """All suffixes of some formats."""
    return {suffix for *_, suffixes in formats.values() for suffix in suffixes}


def footprint(name: str, data: Any, words: Mapping[str, Any]) -> TriSurface:
    """Return a horizon that is to be torn as a grid without holes, for box and area.

    Gaps at faults, and between points, are not the end of a horizon: they get the height of the
    nearest node.
    """
    from scipy.ndimage import binary_closing, binary_fill_holes, distance_transform_edt

    from geosurf.sheets.lattice.data import picks_or_points

    picks = picks_or_points(data, name, words.get("positive"), words.get("length_unit"), None)

    # one value per cell of the grid, NaN where there are no data
    z = picks.means.reshape(picks.frame.shape)
    present = np.isfinite(z)

    # scattered points leave cells empty between them: closing joins points up to twice BETWEEN
    # cells apart
    if not picks.on_nodes:
        present = binary_closing(np.pad(present, BETWEEN), iterations=BETWEEN)
        present = present[BETWEEN:-BETWEEN, BETWEEN:-BETWEEN]
    filled = binary_fill_holes(present)

    # row and column of the nearest cell with data, for every cell
    nearest = distance_transform_edt(np.isnan(z), return_distances=False, return_indices=True)
    elevation = np.where(filled, z[tuple(nearest)], np.nan)
    frame = picks.frame
    rising = rising_diagonal(frame.easting, frame.northing)
    lattice = Lattice(frame.easting, frame.northing, elevation, rising)
    made = TriSurface(name, "horizon", lattice=lattice)
    if made.n_triangle == 0:
        low, high = np.nanmin(z), np.nanmax(z)
        raise HorizonError(
            f"horizon {name!r}: its data cover no area. Easting is {extent(frame.easting)}, "
            f"northing {extent(frame.northing)}, elevation {low:.6g} to {high:.6g} m. If these are "
            "exchanged, name the columns: columns=[x, y, z], by name or by number.",
            surfaces=[name],
        )
    made.crs = crs_of(data) if not isinstance(data, TriSurface) else data.crs
    return made


def extent(values: np.ndarray) -> str:
    """
    Return the lowest and highest of some coordinates, in words.

    Examples
    --------
    >>> extent(np.array([3.0, 1.0]))
    '1 to 3 m'
    """
    return f"{np.nanmin(values):.7g} to {np.nanmax(values):.7g} m"


def with_empty_blocks(
    horizons: Mapping[str, TriSurface], filling: Mapping[str, bool | str]
) -> dict[str, TriSurface]:
    """
    Return horizons with nodes of those that they are pinched out onto, where they have none.

    The default area follows from these: the model fills blocks in which a horizon is missing.

    Examples
    --------
    >>> import geosurf as gs
    >>> top = gs.synthetic.tilted_planes(n=9).horizons["Top"]
    >>> west = gs.triangulate_horizon(top.where(top.easting < 2000), name="West")
    >>> both = {"West": west, "Top": gs.triangulate_horizon(top, name="Top")}
    >>> with_empty_blocks(both, {"West": "Top", "Top": False})["West"].bounds[:2]
    (0.0, 4000.0)
    """
    found = dict(horizons)
    for name in in_order(filling):
        onto = filling[name]
        if isinstance(onto, bool):
            continue
        own, other = found[name].lattice, found[onto].lattice
        if own is None or other is None or own.shape != other.shape:
            continue
        z = np.where(np.isnan(own.elevation), other.elevation, own.elevation)
        lattice = Lattice(own.easting, own.northing, z, own.rising, own.reverse)
        made = TriSurface(name, "horizon", lattice=lattice)
        made.crs = found[name].crs
        found[name] = made
    return found


def grid_of_sheet(sheet: Sheet) -> TriSurface:
    """Return a torn horizon as a grid, without gaps at faults."""
    from geosurf.sheets.extend import as_lattice  # loaded by those who have sheets

    return as_lattice(sheet)


def warnings_of_extrapolation(horizon: TriSurface) -> list[GeosurfWarning]:
    """Return the warning of the nodes that `extend_horizon` gave a horizon, if it has some."""
    if EXTRAPOLATED not in horizon.vertex_data:
        return []
    from geosurf.sheets.extend import warning_of_extrapolation  # loaded by those who extend

    found = warning_of_extrapolation(horizon)
    return [] if found is None else [found]


def horizons_in_map(
    inputs: SceneInputs, of_sheet: Callable[[Sheet], TriSurface], untied: Lookup
) -> list[TriSurface]:
    """Return all horizons for box and area, those that are pinched out with the nodes that lack.

    Parameters
    ----------
    inputs : SceneInputs
    of_sheet : callable
        What stands for a torn horizon.
    untied : callable
        Horizon of a name, for all others.
    """
    found = {
        name: of_sheet(value).renamed(name) if isinstance(value, Sheet) else untied(name)
        for name, value in inputs.horizons.items()
    }
    return [*with_empty_blocks(found, inputs.filling).values()]
