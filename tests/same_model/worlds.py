"""A field that is irregular on purpose: what small, even worlds let pass, it shows.

More than 200 nodes a side (tests take every second or fourth where sizes do not count), on uneven
axes (even ones of unequal steps where horizons are torn); a fault that runs east and ends inside;
two faults two cells apart; a hole in the data; a wedge that leaves slivers; horizons smeared over
the faults, so that a tear needs ghosts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import xarray as xr

import geosurf as gs

Answers = dict[str, Any]
N_EAST, N_NORTH = 231, 209
ATTRS = {"units": "m", "positive": "up"}
WESTERN, SOUTHERN = 1000.0, 2000.0


def uneven(first: float, n: int, steps: tuple[float, ...]) -> np.ndarray:
    """An axis whose steps differ from node to node, all of them whole numbers."""
    return first + np.concatenate([[0.0], np.cumsum(np.resize(steps, n - 1))])


EAST = uneven(WESTERN, N_EAST, (16.0, 20.0, 24.0, 12.0, 28.0))
NORTH = uneven(SOUTHERN, N_NORTH, (20.0, 12.0, 32.0, 24.0))
MIDDLE_EAST, MIDDLE_NORTH = EAST[N_EAST // 2], NORTH[N_NORTH // 2]


def plane_fault(name: str, corners: list[tuple[float, float, float]]) -> gs.TriSurface:
    """A flat four-cornered fault."""
    return gs.TriSurface(name, "fault", np.array(corners), np.array([[0, 1, 2], [0, 2, 3]]))


def faults() -> dict[str, gs.TriSurface]:
    """E runs east and ends inside on both sides; W and V run north, two cells apart, and leave."""
    south, north, low, high = NORTH[0] - 300.0, NORTH[-1] + 300.0, -2900.0, -1300.0
    west, east = EAST[100] + 3.0, EAST[190] + 3.0
    y = MIDDLE_NORTH
    found = {
        "E": [(west, y + 250.0, low), (east, y + 250.0, low), (east, y - 250.0, high),
              (west, y - 250.0, high)],
    }  # fmt: skip
    for name, x in (("W", EAST[60] + 5.0), ("V", EAST[60] + 45.0)):
        found[name] = [(x + 350.0, south, low), (x + 350.0, north, low),
                       (x - 350.0, north, high), (x - 350.0, south, high)]  # fmt: skip
    return {name: plane_fault(name, corners) for name, corners in found.items()}


def elevation(x: np.ndarray, y: np.ndarray, base: float, dip: float, wave: float) -> np.ndarray:
    """A tilted, folded horizon with a throw of 60 m at W, smeared over some nodes."""
    x, y = np.meshgrid(x - MIDDLE_EAST, y - MIDDLE_NORTH)
    bent = base + dip * x + wave * np.sin(x / 700.0) * np.cos(y / 900.0)
    at_fault = EAST[60] + 5.0 - 350.0 * (base + 2100.0) / 800.0 - MIDDLE_EAST  # where W is there
    step = 60.0 / (1.0 + np.exp((x - at_fault) / 25.0))
    return np.round((bent + step) * 64.0) / 64.0


SHAPES = {
    "Top": (-1900.0, 0.02, 25.0),
    "Middle": (-2000.0, 0.075, 15.0),
    "Base": (-2150.0, 0.02, 10.0),
}
EVEN_EAST = np.linspace(EAST[0], EAST[0] + 20.0 * (N_EAST - 1), N_EAST)
EVEN_NORTH = np.linspace(NORTH[0], NORTH[0] + 24.0 * (N_NORTH - 1), N_NORTH)


@cache
def _made(*, even: bool) -> dict[str, xr.DataArray]:
    x, y = (EVEN_EAST, EVEN_NORTH) if even else (EAST, NORTH)
    coords = {"northing": y, "easting": x}
    return {
        name: xr.DataArray(elevation(x, y, *shape), coords, ("northing", "easting"), attrs=ATTRS)
        for name, shape in SHAPES.items()
    }


def uneven_horizons() -> dict[str, xr.DataArray]:
    """Three horizons, youngest first, on uneven axes; Middle wedges out against Top in the east."""
    return {name: data.copy(deep=True) for name, data in _made(even=False).items()}


def picked_horizons() -> dict[str, xr.DataArray]:
    """The same on even axes of unequal steps, for tears; Middle has a hole at W and V."""
    found = {name: data.copy(deep=True) for name, data in _made(even=True).items()}
    found["Middle"][150:153, 58:62] = np.nan
    return found


BOX = (EAST[3], EAST[-4], NORTH[3], NORTH[-4], -2500.0, -1600.0)


def plain(result: Any) -> Any:
    """A result as what can be compared: bytes of arrays, and attributes."""
    if isinstance(result, xr.Dataset | xr.DataArray):
        parts = {**getattr(result, "data_vars", {"": result}), **result.coords}
        parts.pop("region", None)  # names of a scene before go on
        return str(result.attrs), {
            str(name): (one.dims, str(one.attrs), plain(one.values)) for name, one in parts.items()
        }
    if isinstance(result, np.ndarray):
        numbers = result.dtype.kind in "fiub"
        return result.shape, result.tobytes() if numbers else result.tolist()
    return result


def bytes_of(scene: gs.Scene, measures: Mapping[str, Callable[[], Any]] | None = None) -> Answers:
    """All that a model says: units with their arrays, curves, volumes, warnings, measures."""
    found: Answers = {}
    try:
        found = {"box": scene.box, "column": scene.column, **_units(scene)}
    except gs.errors.GeosurfError as error:
        return {"error": (type(error).__name__, str(error))}
    for name, measure in (measures or {}).items():
        try:
            found[name] = plain(measure())
        except gs.errors.GeosurfError as error:
            found[name] = type(error).__name__, str(error)
    return found


def _units(scene: gs.Scene) -> Answers:
    found: Answers = {}
    for name, unit in scene.units.items():
        found[f"unit {name}"] = (
            unit.volume, unit.area, unit.zone, unit.block, unit.contact,
            (unit.local + 0.0).tobytes(), unit.triangles.tobytes(),
        )  # fmt: skip
    curves = scene.curves
    found["curves"] = [
        (tuple(np.array(curves.names)[pair]), curves.points[chain].tobytes())
        for pair, chain in zip(curves.surfaces_of_curve, curves.curves, strict=True)
    ]
    parts = {tuple(sorted(region.blocks)) for region in scene.regions.values()}
    return found | {
        "regions": sorted(parts),
        "volumes": plain(scene.volumes),
        "table": plain(scene.units.table),
        "report": str(scene.units.report),
        "warnings": sorted(map(str, scene.warnings)),
        "fault actions": str(scene.fault_actions),
        "misfit": plain(scene.misfit()) if scene.tops is not None else None,
    }


def difference(one: Answers, two: Answers) -> str:
    """The names of what differs, or nothing."""
    return ", ".join(name for name in {**one, **two} if one.get(name) != two.get(name))
