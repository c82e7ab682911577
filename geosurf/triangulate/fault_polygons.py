"""Fault polygons -> a fault surface: through both cut-off lines of each horizon, and beyond.

A fault polygon surrounds the gap that a fault leaves in the map of a horizon. Its two sides are
the cut-off lines in the footwall and in the hanging wall, which meet at the tips. Both lie on
the fault: so sections across strike have two points of the fault for each horizon.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from geosurf.conventions import checked_points, is_number, place
from geosurf.errors import InputError, SurfaceError
from geosurf.model import TriSurface
from geosurf.model.base import frozen
from geosurf.model.expected import name_of
from geosurf.model.surfaces import CUTOFF, are_among
from geosurf.triangulate.horizon import triangulate_horizon
from geosurf.triangulate.sticks import triangulate_sticks

_TIP = 0.1  # lines nearer than this share of their largest distance are one: they have no dip
_BACK = 0.1  # of its length: how far a line may run back along strike, as digitised corners do
_WINDOW = 0.15  # of the length of the fault: dips beyond the lines are averaged so far both ways
_MOST = 200  # sections


@dataclass(frozen=True)
class _Lines:
    """Both cut-off lines of one polygon, over the distance along strike."""

    along: tuple[np.ndarray, np.ndarray]
    points: tuple[np.ndarray, np.ndarray]

    def at(self, stations: np.ndarray) -> np.ndarray:
        """Points (n, 2, 3) of both lines; NaN beyond the tips."""
        pair = [
            np.stack([np.interp(stations, s, x[:, k]) for k in range(3)], axis=1)
            for s, x in zip(self.along, self.points, strict=True)
        ]
        both = np.stack(pair, axis=1)
        out = (stations < self.along[0][0]) | (stations > self.along[0][-1])
        both[out] = np.nan
        return both


def fault_from_polygons(
    polygons: Mapping[str, Any],
    *,
    name: str,
    lengthen: float | None = None,
    dip: float | None = None,
) -> TriSurface:
    """Build a fault surface from its polygons on one horizon or several.

    Parameters
    ----------
    polygons : mapping of str to array_like of float, shape (n, 3)
        By horizon: easting, northing and elevation [m] around the gap of the fault, closed or not,
        as `read_polygons` reads them.
    name : str
        Of the fault.
    lengthen : float, optional
        Distance [m] by which the fault goes on above and below its lines, along its dip there.
        Default: the largest distance between the two lines of a polygon.
    dip : float, optional
        Dip of the fault [degrees], where the lines do not show it: gridding smears a horizon over
        its faults, so that a gap looks wide and the fault flat. The fault then passes midway
        between the lines, and falls across the strike towards the lower one; above 90 towards the
        upper one. `propose_dip` finds it in horizons.

    Returns
    -------
    TriSurface
        Role "fault". It ends along strike at the outermost tips. Sections across strike, up to 200,
        meet the lines; between them the surface is straight. Where the two lines of a polygon are
        nearer to each other than a tenth of their largest distance, as at tips, it passes midway.
        Without `dip`, ``vertex_data`` marks both lines: where a horizon of that name is torn, its
        walls end there.

    Raises
    ------
    SurfaceError
        If a polygon has fewer than four points or no elevations, runs back along strike, or has no
        extent down the dip.

    Examples
    --------
    A fault that dips 45 degrees east, with 30 m of throw in its middle:

    >>> top = [[0, 0, -1500], [-15, 500, -1485], [0, 1000, -1500], [15, 500, -1515]]
    >>> fault = fault_from_polygons({"Top": top}, name="F1", lengthen=100)
    >>> corners = fault.vertices
    >>> bool(abs(corners[:, 0] + corners[:, 2] + 1500).max() < 1e-9)
    True
    """
    name = name_of(name, "fault")
    if not isinstance(polygons, Mapping) or not polygons:
        raise SurfaceError(
            f"fault {name!r}: polygons are {type(polygons).__name__}, expected one for each "
            "horizon. Give {'Top': polygon}."
        )
    if dip is not None and not (is_number(dip) and 0 < dip < 180):
        raise SurfaceError(f"fault {name!r}: dip is {dip!r}; give degrees above 0 and below 180.")
    what = {str(key): f"fault {name!r}: the polygon of {str(key)!r}" for key in polygons}
    rings = {str(key): _ring(value, what[str(key)]) for key, value in polygons.items()}

    # one strike for all polygons of the fault, so that their sections agree
    strike = _strike(np.concatenate(list(rings.values())))
    lines = [_lines(ring, strike, what[key]) for key, ring in rings.items()]

    # sections across strike, from tip to tip
    first = min(line.along[0][0] for line in lines)
    last = max(line.along[0][-1] for line in lines)
    steps = np.concatenate([np.diff(s) for line in lines for s in line.along])
    count = int(np.clip((last - first) / max(float(np.median(steps)), 1e-9), 4, _MOST))
    stations = np.linspace(first, last, count + 1)
    pairs = np.stack([line.at(stations) for line in lines], axis=1)

    # two lines that all but meet have no dip of their own
    apart = np.linalg.norm(pairs[:, :, 1] - pairs[:, :, 0], axis=2)
    widest = float(np.nanmax(apart))
    if not widest > 0 and dip is None:
        raise SurfaceError(
            f"fault {name!r}: the two sides of each polygon coincide, so that the fault has no "
            "dip. Give polygons with a heave, or fault sticks."
        )

    # closed (n_station, n_horizon): there the middle stands for both points
    closed = (apart < _TIP * widest) | (dip is not None)
    middle = pairs.mean(axis=2)
    reach = widest if lengthen is None else lengthen
    if not (is_number(reach) and 0 <= reach < np.inf):
        raise SurfaceError(f"fault {name!r}: lengthen is {lengthen!r}; give a distance in metres.")

    rows = [
        _section(pair, shut, mid) for pair, shut, mid in zip(pairs, closed, middle, strict=True)
    ]
    if dip is None:
        upward, downward = (_dips(rows, stations, side, name) for side in (0, 1))
    else:
        way = np.radians(dip)
        down = np.append(np.cos(way) * _downward(pairs, strike), -np.sin(way))
        upward, downward = -np.tile(down, (len(rows), 1)), np.tile(down, (len(rows), 1))
    sticks = [
        np.vstack([points[0] + reach * up, points, points[-1] + reach * down])
        for points, up, down in zip(rows, upward, downward, strict=True)
        if reach > 0 or len(points) > 1  # without a continuation tips are points, not sticks
    ]
    made = triangulate_sticks(sticks, name=name)
    for k, key in enumerate(rings):
        numbers = np.zeros(made.n_vertex, dtype=np.int8)
        for line in (0, 1):
            numbers[are_among(made.vertices, pairs[~closed[:, k], k, line])] = line + 1
        made.vertex_data[CUTOFF + key] = frozen(numbers, np.int8)
    return made


def _ring(polygon: Any, what: str) -> np.ndarray:
    """One polygon (n, 3) without its repeated first point; `what` messages call it."""
    how = "Give easting, northing, z. Add the elevation of the horizon as a third column."
    ring = checked_points(polygon, what, how, error=SurfaceError)
    ring = ring[np.r_[True, (np.diff(ring, axis=0) != 0).any(axis=1)]]
    if len(ring) > 1 and (ring[0] == ring[-1]).all():
        ring = ring[:-1]
    if len(ring) < 4:
        raise SurfaceError(f"{what} has {len(ring)} points, but two lines need four or more.")
    return ring


def _strike(points: np.ndarray) -> np.ndarray:
    """Unit vector (2,) along which points extend most in the map."""
    xy = points[:, :2] - points[:, :2].mean(axis=0)
    way: np.ndarray = np.linalg.svd(xy, full_matrices=False)[2][0]
    return way if (way[1], way[0]) > (0.0, 0.0) else -way


def _lines(ring: np.ndarray, strike: np.ndarray, what: str) -> _Lines:
    """The two lines of a ring, from tip to tip: the ends of the fault along strike."""
    s = ring[:, :2] @ strike

    # the ends along strike part the ring into two lines, both read from the first end
    a, b, n = int(s.argmin()), int(s.argmax()), len(ring)
    there = np.arange(a, a + (b - a) % n + 1) % n
    back = np.arange(b, b + (a - b) % n + 1)[::-1] % n
    along, points = [], []
    for rows in (there, back):
        line, high = s[rows], np.maximum.accumulate(s[rows])
        if (high - line).max() > _BACK * (s[b] - s[a]):
            at = ring[rows[int((high - line).argmax())]]
            raise SurfaceError(
                f"{what} runs back along strike at {place(at)}. Split it there, or give fault "
                "sticks."
            )

        # points that run back a little, as digitised corners do, are left out: s has to rise
        ahead = np.r_[True, line[1:] > high[:-1]]
        along.append(line[ahead])
        points.append(ring[rows[ahead]])
    return _Lines((along[0], along[1]), (points[0], points[1]))


def _section(pair: np.ndarray, closed: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Points (n, 3) of one section from the top down: of open pairs both, else the middle."""
    points = []
    for two, shut, one in zip(pair, closed, middle, strict=True):
        if np.isfinite(one).all():
            points += [one] if shut else list(two)
    found = np.array(points)
    return found[np.lexsort((*found[:, :2].T, -found[:, 2]))]


def _dips(rows: list[np.ndarray], stations: np.ndarray, side: int, name: str) -> np.ndarray:
    """Unit vectors (n, 3) in which sections go on: up for side 0, down for side 1; averaged."""
    ends = np.array(
        [
            (row[0] - row[1] if side == 0 else row[-1] - row[-2]) if len(row) > 1 else np.zeros(3)
            for row in rows
        ]
    )
    window = _WINDOW * (stations[-1] - stations[0])
    out = np.empty_like(ends)
    known = stations[ends.any(axis=1)]
    if len(known) == 0:
        raise SurfaceError(f"fault {name!r} has no dip: its polygons have no heave. Give sticks.")
    for i, here in enumerate(stations):
        # at tips as far as the nearest section with a dip, and a window more
        far = float(np.abs(known - here).min()) + window
        weight = np.maximum(1.0 - np.abs(stations - here) / far, 0.0)
        # long pairs count by length: short ones show the dip less well
        out[i] = weight @ ends
    length = np.linalg.norm(out, axis=1, keepdims=True)
    return out / np.maximum(length, np.finfo(float).tiny)


def _downward(pairs: np.ndarray, strike: np.ndarray) -> np.ndarray:
    """Unit vector (2,) across strike, from the higher lines to the lower ones."""
    across = np.array([strike[1], -strike[0]])
    step = pairs[:, :, 1] - pairs[:, :, 0]
    falls = -np.sign(np.nansum((step[:, :, :2] @ across) * step[:, :, 2]))
    return across * (falls or 1.0)


# ---- the dip that horizons show -----------------------------------------------

_SECTIONS = 60  # along a polygon
_ALONG = 10.0  # spacings of the data: along so much of it, horizons have to show the dip
_MARGIN = 10.0  # spacings of the data, on both sides of a polygon: its smear, and rock beyond it
_STEEP = 0.5  # of the steepest slope: what counts as the smear of a fault
_SHARE = 0.5  # of the throw of the polygon that a horizon has to show


def propose_dip(polygon: Any, horizons: Iterable[Any] | Mapping[str, Any]) -> float:
    """
    Find the dip of a fault from where horizons are steep: by how far that moves with depth.

    Parameters
    ----------
    polygon : array_like of float, shape (n, 3)
        Easting, northing and elevation [m] around the gap of the fault on one horizon.
    horizons : iterable or mapping of horizon
        Two or more gridded horizons that the fault cuts, or their points (n, 3); none of them torn.

    Returns
    -------
    float
        [degrees], as `fault_from_polygons` takes it; NaN where horizons do not show it: they climb
        by less than half of what the polygon does, lie nearer to each other than their nodes, or
        are steep along less than ten spacings of these.

    Raises
    ------
    SurfaceError
        If the polygon is not one.
    InputError
        If a horizon is not one.

    Notes
    -----
    In each section across strike, the middle of what is steeper than half of the steepest slope is
    where the fault cuts that horizon. The median of 60 sections counts. Sections differ: on the
    Reek field, half of them are within 21 to 48 degrees.

    Examples
    --------
    Two horizons that a fault of 60 degrees moves by 40 m, smeared over 100 m:

    >>> import numpy as np
    >>> import xarray as xr
    >>> import geosurf as gs
    >>> east, north = np.meshgrid(np.arange(0.0, 1000, 20), np.arange(0.0, 1000, 20))
    >>> def horizon(z):
    ...     share = np.clip((east - 500 - (-1500 - z) / np.tan(np.pi / 3)) / 100 + 0.5, 0, 1)
    ...     coords = {"northing": north[:, 0], "easting": east[0]}
    ...     attrs = {"units": "m", "positive": "up"}
    ...     return xr.DataArray(z - 40 * share, coords, ("northing", "easting"), attrs=attrs)
    >>> gap = [[450, 200, -1500], [450, 800, -1500], [550, 800, -1540], [550, 200, -1540]]
    >>> dip = gs.propose_dip(gap, [horizon(-1500.0), horizon(-1600.0)])
    >>> abs(dip - 60) < 2
    True
    """
    dips = dips_in_horizons(polygon, horizons)
    return float(np.median(dips)) if len(dips) else float("nan")


def dips_in_horizons(polygon: Any, horizons: Iterable[Any] | Mapping[str, Any]) -> np.ndarray:
    """The dips [degrees] in sections of a polygon that show one; none where they are too few."""
    pairs, down = _sections(polygon)
    given: Iterable[Any] = horizons.values() if isinstance(horizons, Mapping) else horizons
    how = "Give easting, northing, z, or gridded horizons."
    clouds = [
        checked_points(horizon, "a horizon", how, error=InputError)
        if isinstance(horizon, np.ndarray)
        else triangulate_horizon(horizon, name="horizon").vertices
        for horizon in given
    ]
    for cloud in clouds:
        if not np.ptp(cloud[:, :2], axis=0).all():
            raise InputError(f"a horizon has no extent on the map: {place(cloud[0])}. {how}")
    if len(clouds) < 2:
        return np.empty(0)
    steepest = [_steepest(cloud, pairs, down) for cloud in clouds]
    centres = np.array([centre for centre, _ in steepest])  # (n, n_section, 2)

    # how far across strike for each metre of depth, in sections where all horizons show the fault
    # and lie as far apart as their data
    spacing = max(step for _, step in steepest)
    known = np.isfinite(centres[..., 0]).all(axis=0) & (np.ptp(centres[..., 1], axis=0) >= spacing)
    length = np.linalg.norm(pairs[-1, 0, :2] - pairs[0, 0, :2])
    if length * known.sum() < _ALONG * spacing * _SECTIONS:
        return np.empty(0)
    away, up = np.moveaxis(centres[:, known] - centres[:, known].mean(axis=0), 2, 0)
    return np.degrees(np.arctan2((up**2).sum(axis=0), -(away * up).sum(axis=0)))


def _sections(polygon: Any) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2, 3) of both lines of a polygon, and which way across strike is down the dip."""
    ring = _ring(polygon, "the fault polygon")
    strike = _strike(ring)
    lines = _lines(ring, strike, "the fault polygon")
    first, last = max(s[0] for s in lines.along), min(s[-1] for s in lines.along)
    pairs = lines.at(np.linspace(first, last, _SECTIONS + 2)[1:-1])
    return pairs, _downward(pairs[:, None], strike)


def dip_of_polygon(polygon: np.ndarray) -> float:
    """Median dip [degrees] between the two lines of a polygon (n, 3)."""
    pairs, _ = _sections(polygon)
    step = pairs[:, 1] - pairs[:, 0]
    across = np.linalg.norm(step[:, :2], axis=1)
    return float(np.degrees(np.median(np.arctan2(np.abs(step[:, 2]), across))))


def _steepest(cloud: np.ndarray, pairs: np.ndarray, down: np.ndarray) -> tuple[np.ndarray, float]:
    """Where a horizon is steepest, in sections through pairs of points (n, 2, 3); its spacing.

    Distance from the middle, and elevation: (n, 2), NaN where it climbs less than the pairs do.
    """
    step, middle = pairs[:, 1] - pairs[:, 0], pairs.mean(axis=1)[:, :2]
    tree, n = cKDTree(cloud[:, :2]), min(4, len(cloud))
    spacing = float(np.median(tree.query(middle, k=[min(3, n)])[0]))
    reach = float(np.linalg.norm(step[:, :2], axis=1).max()) + _MARGIN * spacing
    offsets = np.arange(-reach, reach + spacing / 4, spacing / 2)
    away, near = tree.query(
        (middle[:, None] + offsets[:, None] * down).reshape(-1, 2), k=range(1, n + 1)
    )
    weight = 1.0 / np.maximum(away, 1e-3 * spacing) ** 2
    weight /= weight.sum(axis=1, keepdims=True)
    z = (weight * cloud[near, 2]).sum(axis=1).reshape(len(middle), -1)

    # slopes less those of the rock beyond the smear; a reverse fault rises down its dip
    fall = np.gradient(z, offsets, axis=1)
    beyond = np.abs(offsets) > 0.75 * reach
    fall = np.where(beyond, 0.0, fall - fall[:, beyond].mean(axis=1, keepdims=True))
    fall *= np.sign(fall.sum())
    drop = fall.sum(axis=1) * (spacing / 2)
    fall[fall < _STEEP * fall.max(axis=1, keepdims=True)] = 0.0
    total = fall.sum(axis=1)
    centre = fall @ offsets / np.where(total > 0, total, np.nan)
    level = np.array([np.interp(at, offsets, row) for at, row in zip(centre, z, strict=True)])
    centre[drop < _SHARE * np.median(np.abs(step[:, 2]))] = np.nan
    return np.column_stack([centre, level]), spacing
