"""Compute throw, heave and dip separation along a fault from two cut-off lines of a horizon."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray

from geosurf.conventions import checked_points, place
from geosurf.errors import GeometryError, InputError
from geosurf.measure.columns import Columns, columns_through, fault_between, nearest_first
from geosurf.measure.faces import check_model
from geosurf.model import Patches, Sheet, Units
from geosurf.model.expected import expect, listed, number_of
from geosurf.model.tops import Tops, tops_of

SAME = 1e-3  # vertices of a line that are nearer than this are read as one [m]
_THROW_COLUMNS = {
    "throw": ("m", "vertical separation, above 0 where the hanging wall is down (normal)"),
    "heave": ("m", "horizontal separation down dip, above 0 for a gap in the map"),
    "dip_separation": ("m", "separation down the dip, with the sign of the throw"),
    "apparent_dip": ("degree", "dip of the line between both cut-offs, nan where they are one"),
    "hanging_wall_elevation": ("m", "elevation of the hanging-wall cut-off"),
    "footwall_elevation": ("m", "elevation of the footwall cut-off"),
    "easting": ("m", "easting of the middle between both cut-offs"),
    "northing": ("m", "northing of the middle between both cut-offs"),
}


_AUDIT = {
    "model": "median throw of the model, above 0 where the hanging wall is down",
    "data": "median throw that the data on both sides show",
    "spread": "median spread of that",
    "off": "model minus data where they differ most for their spread; nan where they agree",
    "easting": "easting of that place",
    "northing": "northing of that place",
}


def throw_audit(sheets: Mapping[str, Any]) -> xarray.Dataset:
    """
    Throw of torn horizons beside what the data on both sides of each fault show.

    Parameters
    ----------
    sheets : mapping of str to Sheet
        Torn horizons by name; those that throw moved have no data beside their faults.

    Returns
    -------
    xarray.Dataset
        Over ``horizon`` and ``fault``: ``model``, ``data``, ``spread``, ``off`` and where [m];
        the numbers of ``stations`` with a throw, of those where data show it (``shown``), and of
        those where both differ by more than the spread (``differs``). Medians are over ``shown``.

    Raises
    ------
    InputError
        If no horizon is torn from its data.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=61, smear=2)
    >>> found = throw_audit({"Top": gs.tear_horizon(world.horizons["Top"], world.faults)})
    >>> row = found.sel(horizon="Top", fault="F1")
    >>> bool(abs(row.model - row.data) < row.spread), int(row.differs)
    (True, 0)
    """
    how = "pass scene.sheets"
    expect(sheets, Mapping, "throw_audit takes sheets by name", how)
    for sheet in sheets.values():
        expect(sheet, Sheet, "throw_audit takes sheets by name", how)
    reports = {name: sheet.report for name, sheet in sheets.items()}
    audits = {name: report.throw for name, report in reports.items() if hasattr(report, "trims")}
    if not audits:
        raise InputError(
            "no horizon is torn from data. The audit compares throw with data, so tear horizons "
            "first: Scene(..., tear=True), or geosurf.tear_horizon."
        )
    faults = list(dict.fromkeys(fault for audit in audits.values() for fault in audit))
    shape = (len(audits), len(faults))
    metres = {name: np.full(shape, np.nan) for name in _AUDIT}
    counts = {name: np.zeros(shape, dtype=np.int64) for name in ("stations", "shown", "differs")}
    for at in np.ndindex(*shape):
        audit = list(audits.values())[at[0]].get(faults[at[1]])
        if audit is None:
            continue
        there, differs = np.isfinite(audit.sheet), audit.differs
        shown = there & np.isfinite(audit.data)
        for name, mask in (("stations", there), ("shown", shown), ("differs", differs)):
            counts[name][at] = mask.sum()
        if shown.any():
            for name, along in (("model", "sheet"), ("data", "data"), ("spread", "spread")):
                metres[name][at] = np.median(getattr(audit, along)[shown])
        if audit.worst is not None:
            metres["off"][at] = audit.sheet[audit.worst] - audit.data[audit.worst]
            metres["easting"][at], metres["northing"][at] = audit.stations[audit.worst, :2]
    over = ("horizon", "fault")
    variables: dict[str, Any] = {
        name: (over, values, {"units": "m", "long_name": _AUDIT[name]})
        for name, values in metres.items()
    }
    variables |= {name: (over, values) for name, values in counts.items()}
    return xarray.Dataset(variables, {"horizon": list(audits), "fault": faults})


def separation(
    hanging_wall: Sequence[Any],
    footwall: Sequence[Any],
    dip_azimuth: float,
    *,
    start: float | None = None,
    level: Callable[[np.ndarray], np.ndarray] | None = None,
) -> xarray.Dataset:
    """
    Profile of throw, heave and dip separation between cut-off lines.

    Parameters
    ----------
    hanging_wall, footwall : sequence of array_like, each (n, 3)
        Cut-off lines on both walls [m]: easting, northing, elevation, in order along the fault.
    dip_azimuth : float
        Dip direction of the fault, clockwise from north [degrees]; strike is 90 less (right-hand
        rule). One direction for the whole fault: on a curved one, separations are those across
        its mean strike, unless `level` says more.
    start : float, optional
        Coordinate along the strike that counts as 0 [m]; default: where the first line starts.
    level : callable, optional
        Gives for points (n, 3) the places (n, 2) at which the lines down the dip through them come
        to one level: what is on one such line is compared. Default: what is on one plane across
        the strike.

    Returns
    -------
    xarray.Dataset
        Over ``point``, with coordinate ``along_strike``: throw, heave, dip separation, at every
        vertex of either line where there is a line on each wall; ``pair`` numbers the pairs of
        lines. Both walls are read on the same plane across strike, or the same line down the dip,
        between vertices linearly; on planes the profile is exact at its points. Vertices of a line
        within a millimetre of the one before, as exact cuts make them, are read as one.

    Raises
    ------
    InputError
        If a line is not ``(n >= 2, 3)`` finite numbers.
    GeometryError
        If a line turns back along the strike, so that it has two places in one section.

    Examples
    --------
    >>> down = [[110.0, 0.0, -50.0], [110.0, 90.0, -50.0]]
    >>> up = [[100.0, 0.0, -30.0], [100.0, 90.0, -30.0]]
    >>> found = separation([down], [up], dip_azimuth=90.0)
    >>> found.throw.values.tolist(), found.heave.values.round(9).tolist()
    ([20.0, 20.0], [10.0, 10.0])
    """
    azimuth = math.radians(number_of(dip_azimuth, "dip_azimuth", "give degrees from north"))
    if start is not None:
        start = number_of(start, "start", "give metres along the strike")
    how = "give a list of arrays (n, 3)"
    hanging_wall = listed(hanging_wall, "separation takes cut-off lines", how)
    footwall = listed(footwall, "separation takes cut-off lines", how)

    # unit vectors in the map; rows of `axes` are the coordinates in which lines are compared
    down = np.array([math.sin(azimuth), math.cos(azimuth)])
    strike = np.array([-down[1], down[0]])
    axes = np.stack([strike, down])
    hanging = [_section("hanging wall", line, axes, level) for line in hanging_wall]
    foot = [_section("footwall", line, axes, level) for line in footwall]
    for lines in (hanging, foot):
        lines.sort(key=lambda line: tuple(line[0]))  # pairs follow each other along the strike
    parts: list[np.ndarray] = []
    pairs: list[np.ndarray] = []
    at: list[np.ndarray] = []

    # all pairs of lines that share a stretch of the fault: a line that is interrupted on one wall
    # by another fault still meets the whole line on the other
    for h in hanging:
        for f in foot:
            low, high = max(h[0, 0], f[0, 0]), min(h[-1, 0], f[-1, 0])
            if low > high or (low == high and len(hanging) + len(foot) > 2):
                continue  # lines of different stretches, or that only follow each other

            # every vertex of either line: between them both are straight, so linear reading is
            # exact
            s = np.unique(np.concatenate([h[:, 0], f[:, 0], [low, high]]))
            s = s[(s >= low) & (s <= high)]
            pairs.append(np.full(len(s), len(pairs)))
            at.append(s)
            parts.append(_profile(s, h, f, axes))
    table = np.concatenate([*parts, np.empty((0, len(_THROW_COLUMNS)))])
    s = np.concatenate([*at, np.empty(0)])

    # the earliest line of both walls is 0, whether or not it has a partner
    first = min((line[0, 0] for line in (*hanging, *foot)), default=0.0)
    data: dict[str, Any] = {
        name: ("point", table[:, k], {"units": units, "long_name": words})
        for k, (name, (units, words)) in enumerate(_THROW_COLUMNS.items())
    }
    number = np.concatenate([*pairs, np.empty(0)]).astype(np.int64)
    data["pair"] = ("point", number, {"long_name": "pair of lines that each point belongs to"})
    words = {"units": "m", "long_name": "distance along the mean strike"}
    coords = {"along_strike": ("point", s - (first if start is None else start), words)}
    attrs = {"dip_azimuth": float(dip_azimuth), "dip_azimuth_units": "degree"}
    return xarray.Dataset(data, coords=coords, attrs=attrs)


def _section(
    wall: str, line: Any, axes: np.ndarray, level: Callable[[np.ndarray], np.ndarray] | None
) -> np.ndarray:
    """Columns of a cut-off line, in the direction of strike: along strike where it is compared,
    down dip, elevation, and along strike where it is.
    """
    how = "Give easting, northing, elevation [m]."
    points = checked_points(line, f"a cut-off line of the {wall}", how, least=2)

    # first drop doubled vertices: they would turn back along the strike by rounding alone
    points = _thinned(points)
    along, across = axes @ points[:, :2].T
    at = along if level is None else level(points) @ axes[0]
    section = np.column_stack([at, across, points[:, 2], along])

    # all lines run with the strike, so that np.interp gets rising abscissae
    if section[-1, 0] < section[0, 0]:
        section, points = section[::-1], points[::-1]
    back = np.flatnonzero(np.diff(section[:, 0]) <= 0)
    if len(back):
        where = points[back[0] + 1]
        raise GeometryError(
            f"the cut-off line of the {wall} turns back along the strike at {place(where)}, "
            "so throw has two values there. Split the line there, or pass the strike of "
            "that part.",
            place=where,
        )
    return section


def _thinned(points: np.ndarray) -> np.ndarray:
    """A line without vertices that lie on the one before; its ends stay."""
    # rounding decides nothing where a step is surely long
    sure = (np.abs(np.diff(points, axis=0)).max(axis=1) > 2.0 * SAME).tolist()
    kept = [0]
    for i in range(1, len(points)):
        next_to = kept[-1] == i - 1 and sure[i - 1]
        if next_to or np.linalg.norm(points[i] - points[kept[-1]]) > SAME:
            kept.append(i)
    if len(kept) > 1:
        kept[-1] = len(points) - 1
    return points[kept]


def _profile(s: np.ndarray, h: np.ndarray, f: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Columns of the profile at places along the strike."""
    # both walls at the same s: down-dip position d, elevation z, and the true place along strike,
    # which differs from s where lines down the dip are followed
    (dh, zh, sh), (df, zf, sf) = (
        [np.interp(s, line[:, 0], line[:, k]) for k in (1, 2, 3)] for line in (h, f)
    )

    # positive where the hanging wall is lower; heave takes the sign of the opening (the hanging
    # wall lies down dip) and the length of the whole horizontal step
    throw, heave = zf - zh, np.copysign(np.hypot(dh - df, sh - sf), dh - df)
    size = np.hypot(throw, heave)
    dip = np.degrees(np.arctan2(np.abs(throw), np.abs(heave)))
    middle = (0.5 * (sh + sf))[:, None] * axes[0] + (0.5 * (dh + df))[:, None] * axes[1]
    return np.column_stack(
        [
            throw, heave, np.where(throw < 0, -size, size), np.where(size > 0, dip, np.nan),
            zh, zf, middle,
        ]
    )  # fmt: skip


# ---- misfit ----------------------------------------
# Compare well tops with the horizons of a model: a misfit for each horizon and well.


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
    zones = np.array([unit.zone_index for unit in units.values()] or [0])

    # (n_crossing, 2) units above and below what each vertical line meets, -1 outside
    sides = units.sides[columns.triangle]

    # a horizon counts as present where it separates zones: a triangle with one zone on both sides
    # was clipped away or lies in a hole of the column
    borders = (sides >= 0).all(axis=1) & (zones[sides[:, 0]] != zones[sides[:, 1]])
    rows = [_compared(patches, units, checked, k, columns, borders) for k in range(len(checked))]
    return _dataset(checked, rows)


def _compared(
    patches: Patches, units: Units, tops: Tops, k: int, columns: Columns, borders: np.ndarray
) -> _Row:
    """One top: the horizon above or below it, and what lies between."""
    at = columns.at(k)
    z, surface = columns.elevation[at], columns.surface[at]
    horizons = {s.name: i for i, s in enumerate(patches.sources) if s.role == "horizon"}
    picked = float(tops.points[k, 2])
    block = _block_at(units, columns, at, picked)
    if tops.horizons[k] not in horizons:
        return _Row(UNKNOWN, block=block)
    if not len(z):
        return _Row(OUTSIDE)

    # faults that the vertical line meets, from the bottom up, as the crossings are sorted
    faults = [j for j, i in enumerate(surface) if patches.sources[i].role == "fault"]
    fault_names = [patches.names[i] for i in surface[faults]]
    on_horizon = surface == horizons[tops.horizons[k]]
    values = z[on_horizon & borders[at]]

    # one value or several: compare with the nearest and name a fault that lies between, since then
    # top and horizon are in different blocks
    if len(values):
        model = float(values[nearest_first(values, picked)[0]])
        between = fault_between(z[faults], fault_names, picked, model)
        status = FOUND if len(values) == 1 else SEVERAL
        return _Row(status, model, block, between, len(values))

    # the horizon is there but borders nothing, or no fault could have left a gap
    if on_horizon.any() or not len(faults):
        return _Row(ABSENT, block=block)
    nearest = fault_names[int(np.abs(z[faults] - picked).argmin())]
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
    return xarray.Dataset(data, attrs=attrs)
