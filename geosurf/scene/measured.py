"""Measures of a scene that ask for more than its units: fluids in place, throw down the dip."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf import measure
from geosurf.conventions.crs import refuse_other_crs
from geosurf.errors import GeometryError, InputError
from geosurf.measure.volumetrics import ARGUMENTS, Factor, factors_of
from geosurf.model import Lattice
from geosurf.model.protocols import MeasuredModel
from geosurf.read import otherwise, read_horizon
from geosurf.triangulate.horizon import horizon_over

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

RATIOS = ("1", "", "m", "fraction", "v/v", "m3/m3", "rm3/sm3", "Rm3/Sm3")  # "m": of our readers


def factors_of_rock(values: Sequence[Any], crs: str | None) -> list[Factor]:
    """Return the first four arguments of `Scene.volumetrics`, checked, with maps as grids."""
    given = dict(zip(ARGUMENTS, values, strict=True))
    return factors_of(given, lambda value, name: opened_map(value, name, crs))


def opened_map(value: Any, name: str, crs: str | None) -> Lattice:
    """
    Return the grid of a map of a property, given or read as a horizon is.

    Parameters
    ----------
    value : xarray.DataArray or path
        Fractions or other ratios, in place of elevations.
    name : str
        Of the argument, for messages.
    crs : str or None
        Of the scene.

    Raises
    ------
    InputError
        For other things, values with a unit, or another reference system.
    """
    if isinstance(value, str | Path):
        value = read_horizon(value, **otherwise({"positive": "up", "length_unit": "m"}))
    stated = str(getattr(value, "attrs", {}).get("units", "1"))
    if stated not in RATIOS:
        raise InputError(
            f"the map of {name} is in {stated!r}; it must be a ratio. Divide percent by 100, and "
            "set attrs['units'] = '1'."
        )
    found = horizon_over(value, (), name=name, positive="up", length_unit="m", noun="map of")
    if found.lattice is None:
        raise InputError(f"the map of {name} is a mesh. Give a grid over easting and northing.")
    if crs is not None and found.crs is not None:
        refuse_other_crs(f"map of {name}", found.crs, {"scene": crs})
    return found.lattice


def throw_along(scene: MeasuredModel, horizon: str, fault: str, direction: str) -> xarray.Dataset:
    """Compare the cut-offs of both walls across the mean strike, then down the local dip."""
    from geosurf.sheets.faults.fault_profile import cell_of, to_level

    # distance along strike counts from the end of the fault, in world coordinates
    faces = measure.faces_of(scene.patches, scene.units, fault, "fault")
    hanging, foot = (scene.cutoffs(horizon, fault, side) for side in ("+", "-"))
    azimuth = math.degrees(math.atan2(*faces.strike[1].tolist())) % 360.0
    start = -float(faces.along(-faces.origin[None])[0])

    # first across the mean strike; its elevations say at which level walls are compared
    found = measure.separation(hanging, foot, azimuth, start=start)
    if direction == "local" and found.sizes["point"]:
        # cut-offs are compared at their mean elevation, down lines of steepest dip
        sources = {source.name: source for source in scene.patches.sources}
        cell = cell_of(scene.sheets.get(horizon, sources[horizon]))
        walls = found.hanging_wall_elevation, found.footwall_elevation
        mean, largest = 0.5 * sum(float(wall.mean()) for wall in walls), abs(found.throw).max()
        try:
            level = to_level(sources[fault], float(largest), cell, mean, hanging, foot)
        except GeometryError as error:
            error.add_note("With direction='mean' throw is read across the mean strike.")
            raise
        if level is not None:  # None where the fault is straight
            found = measure.separation(hanging, foot, azimuth, start=start, level=level)
    return found.assign_attrs(horizon=horizon, fault=fault, direction=direction)
