"""Fault polygons -> a fault surface: through both cut-off lines of each horizon, and beyond.

A fault polygon surrounds the gap that a fault leaves in the map of a horizon. Its two sides are the
cut-off lines in the footwall and in the hanging wall, which meet at the tips. Both lie on the
fault: so sections across strike have two points of the fault for each horizon.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import is_number, place, real_numbers
from geosurf.errors import SurfaceError
from geosurf.model import TriSurface
from geosurf.model.expected import name_of
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
    polygons: Mapping[str, Any], *, name: str, lengthen: float | None = None
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

    Returns
    -------
    TriSurface
        Role "fault". It ends along strike at the outermost tips. Sections across strike, up to 200,
        meet the lines; between them the surface is straight. Where the two lines of a polygon are
        nearer to each other than a tenth of their largest distance, as at tips, it passes midway.

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
    rings = {str(key): _ring(value, str(key), name) for key, value in polygons.items()}

    # one strike for all polygons of the fault, so that their sections agree
    strike = _strike(np.concatenate(list(rings.values())))
    lines = [_lines(ring, strike, key, name) for key, ring in rings.items()]

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
    if not widest > 0:
        raise SurfaceError(
            f"fault {name!r}: the two sides of each polygon coincide, so that the fault has no "
            "dip. Give polygons with a heave, or fault sticks."
        )

    # closed (n_station, n_horizon): there the middle stands for both points
    closed = apart < _TIP * widest
    middle = pairs.mean(axis=2)
    reach = widest if lengthen is None else lengthen
    if not (is_number(reach) and 0 <= reach < np.inf):
        raise SurfaceError(f"fault {name!r}: lengthen is {lengthen!r}; give a distance in metres.")

    rows = [
        _section(pair, shut, mid) for pair, shut, mid in zip(pairs, closed, middle, strict=True)
    ]
    upward, downward = (_dips(rows, stations, side, name) for side in (0, 1))
    sticks = [
        np.vstack([points[0] + reach * up, points, points[-1] + reach * down])
        for points, up, down in zip(rows, upward, downward, strict=True)
        if reach > 0 or len(points) > 1  # without a continuation tips are points, not sticks
    ]
    return triangulate_sticks(sticks, name=name)


def _ring(polygon: Any, horizon: str, name: str) -> np.ndarray:
    """One polygon (n, 3) without its repeated first point."""
    what = f"fault {name!r}: the polygon of {horizon!r}"
    try:
        ring = real_numbers(polygon)
    except (TypeError, ValueError) as error:
        raise SurfaceError(
            f"{what} is not numbers ({error}). Give easting, northing, z."
        ) from error
    if ring.ndim != 2 or ring.shape[1] != 3:
        raise SurfaceError(
            f"{what} has shape {ring.shape}, expected (n, 3). Add the elevation of the horizon "
            "at its points as a third column."
        )
    if not np.isfinite(ring).all():
        raise SurfaceError(f"{what} has points that are not finite. Leave them out.")
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


def _lines(ring: np.ndarray, strike: np.ndarray, horizon: str, name: str) -> _Lines:
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
                f"fault {name!r}: the polygon of {horizon!r} runs back along strike at "
                f"{place(at)}. Split it there, or give fault sticks."
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
