"""Compare well tops with the horizons of a model: a misfit for each horizon and well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.measure.faces import check_model
from geosurf.measure.well_columns import Columns, columns_through, fault_between, nearest_first
from geosurf.model import Patches, Units
from geosurf.model.tops import Tops, tops_of

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

FOUND, SEVERAL = "found", "several"
GAP, ABSENT, OUTSIDE, UNKNOWN = "fault gap", "absent", "outside", "unknown horizon"
STATUSES = {
    FOUND: "the horizon is above, below or at the top",
    SEVERAL: "a fault repeats the horizon there: the value nearest to the top is listed",
    GAP: "a normal fault leaves a gap there",
    ABSENT: "the horizon does not exist there, or another horizon removes it",
    OUTSIDE: "the top is outside the model, in map view",
    UNKNOWN: "the model has no horizon of that name",
}
_COLUMNS = {
    "picked": ("m", "elevation of the top"),
    "model": ("m", "elevation of the horizon in the model"),
    "misfit": ("m", "model minus picked: positive where the model is too high"),
}


@dataclass
class _Row:
    """One top, compared."""

    status: str
    model: float = np.nan
    block: str = ""
    fault: str = ""
    values: int = 0


def well_misfit(patches: Patches, units: Units, tops: Any) -> xarray.Dataset:
    """
    Compare well tops with the horizons of a model.

    Parameters
    ----------
    patches, units : Patches, Units
    tops : xarray.Dataset or table
        Of `read_tops`: ``well``, ``horizon``, ``easting``, ``northing``, ``elevation``.

    Returns
    -------
    xarray.Dataset
        Over ``top``, in the order of the tops: ``well``, ``horizon``, ``easting``, ``northing``,
        ``picked``, ``model`` (exact on the triangles of the model) and ``misfit`` [m], which is
        model minus picked; NaN without a value. ``block``: where the top lies; a top on a fault
        counts as on its upper side. ``status``: ``"found"``, ``"several"`` (a reverse fault repeats
        the horizon; the value nearest to the top is used, ``n_values`` counts them),
        ``"fault gap"``, ``"absent"``, ``"outside"``, ``"unknown horizon"``. ``fault``: the fault of
        the gap, or the fault between top and horizon, which lie on different sides of it.

    Raises
    ------
    InputError
        If the tops lack a column.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> east, north, up = scene.surface("Top").vertices[40]
    >>> tops = dict(well=["W"], horizon=["Top"], easting=[east], northing=[north])
    >>> found = well_misfit(scene.patches, scene.units, tops | {"elevation": [up - 7.0]})
    >>> found.misfit.values.round(9).tolist(), found.status.values.tolist()
    ([7.0], ['found'])
    """
    check_model(patches, units)
    checked = tops_of(tops)
    inside = np.flatnonzero((units.sides >= 0).any(axis=1))
    columns = columns_through(patches, checked.points, inside)
    zones = [unit.zone_index for unit in units.values()] or [0]

    # (n_crossing, 2) units above and below what each vertical line meets, -1 outside
    sides = units.sides[columns.triangle]

    # a horizon counts as present where it separates zones: a triangle with one zone on both sides
    # was clipped away or lies in a hole of the column
    borders = (sides >= 0).all(axis=1) & (
        np.array(zones)[sides[:, 0]] != np.array(zones)[sides[:, 1]]
    )
    roles = np.array([source.role for source in patches.sources])
    is_fault = roles[columns.surface] == "fault"
    rows = [
        _compared(patches, units, checked, k, columns, borders, is_fault)
        for k in range(len(checked))
    ]
    return _dataset(checked, rows)


def _compared(
    patches: Patches,
    units: Units,
    tops: Tops,
    k: int,
    columns: Columns,
    borders: np.ndarray,
    is_fault: np.ndarray,
) -> _Row:
    """One top: the horizon above or below it, and what lies between."""
    at = columns.at(k)
    z, surface = columns.elevation[at], columns.surface[at]
    names = [source.name for source in patches.sources if source.role == "horizon"]
    picked = float(tops.points[k, 2])
    block = _block_at(units, columns, at, picked)
    if tops.horizons[k] not in names:
        return _Row(UNKNOWN, block=block)
    if not len(z):
        return _Row(OUTSIDE)

    # faults that the vertical line meets, from the bottom up, as the crossings are sorted
    faults = np.flatnonzero(is_fault[at])
    of_fault = [patches.names[i] for i in surface[faults]]
    horizon = [
        i for i, source in enumerate(patches.sources)
        if source.role == "horizon" and source.name == tops.horizons[k]
    ]  # fmt: skip
    mine = np.isin(surface, horizon)
    values = z[mine & borders[at]]

    # one value or several: compare with the nearest and name a fault that lies between, since then
    # top and horizon are in different blocks
    if len(values):
        model = float(values[nearest_first(values, picked)[0]])
        between = fault_between(z[faults], of_fault, picked, model)
        status = FOUND if len(values) == 1 else SEVERAL
        return _Row(status, model, block, between, len(values))

    # the horizon is there but borders nothing, or no fault could have left a gap
    if mine.any() or not len(faults):
        return _Row(ABSENT, block=block)
    nearest = of_fault[int(np.abs(z[faults] - picked).argmin())]
    return _Row(GAP, block=block, fault=nearest)


def _block_at(units: Units, columns: Columns, at: slice, picked: float) -> str:
    """Block of the unit that holds a top: the unit below the first triangle above it."""
    # strictly above: a top on a surface belongs to the unit on its upper side
    above = np.flatnonzero(columns.elevation[at] > picked)
    if not len(above):
        return ""
    first = at.start + int(above[0])
    side = units.sides[columns.triangle[first]]

    # a triangle that faces up has its front on top, so the unit below is that behind it
    below = int(side[1] if columns.way[first] > 0 else side[0])
    return list(units.values())[below].block if below >= 0 else ""


def _dataset(tops: Tops, rows: Sequence[_Row]) -> xarray.Dataset:
    """The table of all tops."""
    import xarray as xr

    model = np.array([row.model for row in rows])
    picked = tops.points[:, 2].copy() if len(tops) else np.empty(0)
    numbers = {"picked": picked, "model": model, "misfit": model - picked}
    words = {
        "well": (list(tops.wells), "well"),
        "horizon": (list(tops.horizons), "horizon"),
        "block": ([row.block for row in rows], "block of the model that holds the top"),
        "status": ([row.status for row in rows], "how the top compares with the horizon"),
        "fault": ([row.fault for row in rows], "fault of the gap, or between top and horizon"),
    }
    metre = {"units": "m"}
    data: dict[str, Any] = {
        key: ("top", np.array(values, dtype=object), {"long_name": name})
        for key, (values, name) in words.items()
    }
    for k, key in enumerate(("easting", "northing")):
        data[key] = ("top", tops.points[:, k].copy(), metre)
    for key, values in numbers.items():
        units_of, name = _COLUMNS[key]
        data[key] = ("top", values, {"units": units_of, "long_name": name})
    data["n_values"] = ("top", np.array([row.values for row in rows], dtype=np.int64))
    attrs = {"definition": "misfit is model minus picked", "statuses": dict(STATUSES)}
    return xr.Dataset(data, attrs=attrs)
