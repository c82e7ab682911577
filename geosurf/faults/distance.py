"""The closest approach of two surfaces, or of an open end to a surface.

Nothing is decided by these distances: messages report them. Floats in
coordinates around the middle of both; the result is right to a part in 10^9 of their size.
Blocks of triangles are compared by their boxes first, nearest first, until no block can be nearer.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.conventions import length_text, place
from geosurf.errors import GeosurfWarning
from geosurf.kernels.meshes.mesh import edges
from geosurf.kernels.meshes.nearest import point_codes
from geosurf.model import TriSurface
from geosurf.model.expected import outline_of

_BLOCK = 32


@dataclass(frozen=True)
class Approach:
    """The closest approach: its distance [m], and the place on either surface, (3,)."""

    distance: float
    at: np.ndarray
    there: np.ndarray


def open_edges(t: np.ndarray, n_vertex: int) -> np.ndarray:
    """Vertices (n, 2) of the edges of triangles that have one triangle only."""
    ring, _ = edges(t, n_vertex)
    half = np.flatnonzero(ring == np.arange(len(ring)))
    return np.stack([t[half // 3, half % 3], t[half // 3, (half + 1) % 3]], axis=1)


def closest_approach(x: np.ndarray, first: np.ndarray, second: np.ndarray) -> Approach:
    """Find where two surfaces over the same vertices are closest.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
    first, second : ndarray of int64, shape (n, 3)
        Triangles. Surfaces that cross are 0 apart, up to rounding.

    Returns
    -------
    Approach

    Examples
    --------
    >>> x = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 3], [1, 1, 9], [2, 1, 9.0]])
    >>> closest_approach(x, np.array([[3, 4, 5]]), np.array([[0, 1, 2]])).distance
    3.0
    """
    # two triangles are closest between an edge of one and the other triangle, or an edge passes
    # through it: edges of each against triangles of the other cover all cases
    sides = [np.unique(np.sort(_sides(t), axis=1), axis=0) for t in (first, second)]
    there = nearest_of(x[sides[0]], x[second])
    back = nearest_of(x[sides[1]], x[first])
    if back.distance < there.distance:
        return Approach(back.distance, back.there, back.at)
    return there


def _sides(t: np.ndarray) -> np.ndarray:
    return np.stack([t, np.roll(t, -1, axis=1)], axis=2).reshape(-1, 2)


def nearest_of(segments: np.ndarray, triangles: np.ndarray, limit: float = np.inf) -> Approach:
    """Find where segments (n, 2, 3) come closest to triangles (m, 3, 3); `at` is on the segments.

    Of several places as close as each other, the one with the least coordinates. What is farther
    than `limit` is not measured: then the distance is infinite.
    """
    # around the middle: UTM northings of 6 million m would cost seven digits
    middle = 0.5 * (triangles.min(axis=(0, 1)) + triangles.max(axis=(0, 1)))
    s, t = segments - middle, triangles - middle
    if limit < np.inf:
        t = t[_gaps(t.min(axis=1), t.max(axis=1), s.reshape(-1, 3)) <= limit]
        if len(t):
            s = s[_gaps(s.min(axis=1), s.max(axis=1), t.reshape(-1, 3)) <= limit]
        if len(t) == 0 or len(s) == 0:
            return Approach(np.inf, middle, middle)

    # along a space-filling curve, so that blocks of 32 in a row are compact
    s, t = s[_along_curve(s)], t[_along_curve(t)]
    s_blocks, t_blocks = (np.arange(0, len(v), _BLOCK) for v in (s, t))
    low_s, high_s = _boxes(s, s_blocks)
    low_t, high_t = _boxes(t, t_blocks)

    # lower bound of the distance of two blocks: that of their boxes, (n_s_block, n_t_block)
    gap = np.maximum(low_s[:, None] - high_t, low_t - high_s[:, None])
    bound = np.sqrt((np.maximum(gap, 0.0) ** 2).sum(axis=2))
    best: tuple[float, tuple[float, ...], tuple[float, ...]] = (
        np.inf,
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
    )

    # branch and bound, nearest boxes first: stop as soon as no box can be nearer
    for flat in np.argsort(bound, axis=None, kind="stable"):
        i, j = np.unravel_index(flat, bound.shape)
        if bound[i, j] > best[0]:
            break

        # tuples compare by distance, then by place: ties do not depend on the order of blocks
        here = s[s_blocks[i] : s_blocks[i] + _BLOCK], t[t_blocks[j] : t_blocks[j] + _BLOCK]
        best = min(best, _closest_pair(*here))
    return Approach(best[0], np.array(best[1]) + middle, np.array(best[2]) + middle)


def _gaps(low: np.ndarray, high: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance of each of some boxes to the bounds of points (n, 3)."""
    gap = np.maximum(low - points.max(axis=0), points.min(axis=0) - high)
    return np.linalg.norm(np.maximum(gap, 0.0), axis=1)


def _boxes(shapes: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    low, high = shapes.min(axis=1), shapes.max(axis=1)
    return np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)


def _along_curve(shapes: np.ndarray) -> np.ndarray:
    """Order that keeps near shapes together: the Morton order of their middles."""
    centre = shapes.mean(axis=1)
    box = np.concatenate([centre.min(axis=0), centre.max(axis=0)])
    return np.argsort(point_codes(centre, box), kind="stable")


def _closest_pair(
    s: np.ndarray, t: np.ndarray
) -> tuple[float, tuple[float, ...], tuple[float, ...]]:
    """(distance, point on a segment, point on a triangle) of all pairs of two blocks."""
    n, m = len(s), len(t)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))

    # the closest points are at an end of the segment, where it passes through the plane, or on it
    # and an edge of the triangle
    normal = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])[j]
    places = [s[i, 0]]
    if (s[:, 0] != s[:, 1]).any():  # no points
        places += [s[i, 1], _on_planes(s[i], t[j], normal)]
    found = [_of_ends(place, t[j], normal) for place in places]
    found += [_of_lines(s[i], t[j][:, [k, (k + 1) % 3]]) for k in range(3)]
    on_s, on_t = (np.concatenate([f[k] for f in found]) for k in range(2))
    distance = np.linalg.norm(on_s - on_t, axis=1)
    near = np.flatnonzero(distance == distance.min())
    row = near[np.lexsort(on_s[near].T[::-1])[0]]
    return float(distance[row]), tuple(on_s[row].tolist()), tuple(on_t[row].tolist())


def _on_planes(s: np.ndarray, t: np.ndarray, n: np.ndarray) -> np.ndarray:
    """Where segments come closest to the planes of triangles: in them, or at an end."""
    a = t[:, 0]
    start, end = s.swapaxes(0, 1)
    one, two = (((place - a) * n).sum(axis=1) for place in (start, end))
    apart = one - two
    share = np.clip(np.where(apart == 0, 0.0, one / np.where(apart == 0, 1.0, apart)), 0.0, 1.0)
    return start + share[:, None] * (end - start)


def _of_ends(p: np.ndarray, t: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and their feet in the insides of triangles; corners where the foot is outside.

    Feet on edges are found by `_of_lines`.
    """
    a, b, c = t[:, 0], t[:, 1], t[:, 2]
    size = np.maximum((n * n).sum(axis=1), np.finfo(float).tiny)
    foot = p - (((p - a) * n).sum(axis=1) / size)[:, None] * n
    inside = (n * n).sum(axis=1) > 0  # rounding may leave a triangle no area
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(v - u, foot - u) * n).sum(axis=1) >= 0
    return p, np.where(inside[:, None], foot, a)


def _of_lines(s: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Closest points of segments s and r, both (n, 2, 3) (Ericson, Real-Time Collision, 5.1.9)."""
    (p, to), (o, onward) = s.swapaxes(0, 1), r.swapaxes(0, 1)
    d, e, w = to - p, onward - o, p - o
    a, b, c = (d * d).sum(axis=1), (d * e).sum(axis=1), (e * e).sum(axis=1)
    f, g = (d * w).sum(axis=1), (e * w).sum(axis=1)
    tiny = np.finfo(float).tiny
    det = a * c - b * b
    k = np.clip(np.where(det > 1e-12 * a * c, (b * g - c * f) / np.maximum(det, tiny), 0.0), 0, 1)
    q = (b * k + g) / np.maximum(c, tiny)
    back = np.clip(q, 0.0, 1.0)
    k = np.where(q == back, k, np.clip((b * back - f) / np.maximum(a, tiny), 0.0, 1.0))
    return p + k[:, None] * d, o + back[:, None] * e


# ---- short of side ----------------------------------------
# Faults whose rim runs along a side of the model, a little inside of it: units go around them.
#
# Meshes of other packages end within the last cell of their grid. Such a fault does not divide
# units. It is not an error, since a fault may end inside of a model.


# A rim is next to a side within so many of its own edges, and within this part of the side. A fault
# that dies inside of the model ends farther away, or across the side.
EDGES, PART = 2.0, 0.05
LONGER = 4.0  # times as long along the side as it may be away from it
ROUNDING = 1e-9  # part of the coordinates, below which a rim lies on the side
SIDES = ("south", "east", "north", "west")


def warning_of_rim(
    surface: TriSurface, box: Sequence[float], aoi: np.ndarray | None = None
) -> GeosurfWarning | None:
    """
    Return the warning of a fault that ends just inside of a side of the model, or None.

    Parameters
    ----------
    surface : TriSurface
    box : (west, east, south, north, bottom, top)
        [m]
    aoi : ndarray of float64, shape (n, 2), optional
        Area of interest, if there is one.

    Examples
    --------
    >>> wall = [[10, 500, -900], [990, 500, -900], [990, 500, 0], [10, 500, 0]]
    >>> fault = TriSurface("F1", "fault", wall, [[0, 1, 2], [0, 2, 3]])
    >>> print(warning_of_rim(fault, (0, 1000, 0, 1000, -800, -100)))
    Fault 'F1' ends 10 m before the east side of the model box (and 1 more), for example at \
(E 990, N 500, elevation -800 m). Units go around it there and are not divided. Continue it, as in \
gs.extend_fault(fault, box, sides='strike').surface, or take box=(11, 989, 0, 1000, -800, -100).
    """
    low, high = box[4:]
    ring, x = outline_of(box, aoi), surface.vertices
    rim = open_edges(surface.triangles, len(x))
    if not len(rim):
        return None

    # rim edges between top and bottom of the model, cut off there
    step = float(np.median(np.linalg.norm(x[rim[:, 1]] - x[rim[:, 0]], axis=1)))
    heights = x[rim][:, :, 2]
    rim = rim[(heights.max(axis=1) > low) & (heights.min(axis=1) < high)]
    edges = _clipped(x[rim], low, high)
    inside = in_ring(edges, ring)

    gaps = []
    for k, (a, b) in enumerate(zip(ring, np.roll(ring, -1, axis=0), strict=True)):
        length = float(np.hypot(*(b - a)))
        if length == 0.0:
            continue
        along = (b - a) / length
        off = np.abs((edges[:, :, :2] - a) @ [-along[1], along[0]])

        # edges next to one that goes deeper belong to a rim that crosses the side
        deep = (inside & (off > min(EDGES * step, PART * length))).any(axis=1)
        close = inside.any(axis=1) & ~np.isin(rim, rim[deep]).any(axis=1)
        off = np.where(inside, off, 0.0)
        if not close.any() or off[close].max() <= ROUNDING * np.abs(ring).max():
            continue  # a rim on the side itself is closed

        # how far these edges go along the side: in the map, or down the dip
        steps = np.diff(edges[close], axis=1)[:, 0]
        spread = float(np.hypot(steps[:, :2] @ along, steps[:, 2]).sum())
        gap = float(off[close].max())
        if spread > LONGER * gap:
            name = f"{SIDES[k]} side" if aoi is None else f"side {k} (counted from 0)"
            spot = edges[close][np.unravel_index(np.argmax(off[close]), off[close].shape)]
            gaps.append((gap, spot, name, k))
    if not gaps:
        return None
    gap, spot, side, _ = max(gaps, key=lambda one: one[0])
    where = "model box" if aoi is None else "area of interest"
    more = f" (and {len(gaps) - 1} more)" if len(gaps) > 1 else ""
    return GeosurfWarning(
        "rim",
        surface.name,
        f"Fault {surface.name!r} ends {length_text(gap)} before the {side} of the {where}{more}, "
        f"for example at {place(spot)}. Units go around it there and are not divided.",
        "Continue it, as in gs.extend_fault(fault, box, sides='strike').surface, or take "
        f"{_smaller(box, gaps) if aoi is None else 'an aoi that ends inside of the fault'}.",
        spot,
    )


def _smaller(box: Sequence[float], gaps: Sequence[tuple[float, np.ndarray, str, int]]) -> str:
    """A box whose sides lie beyond the gaps, with two digits of them."""
    sides = list(box)
    for gap, _, _, k in gaps:
        digit = 10.0 ** (math.floor(math.log10(gap)) - 1)
        moved = (math.floor(gap / digit) + 1) * digit
        # south, east, north, west
        place, sign = ((2, 1), (1, -1), (3, -1), (0, 1))[k]
        sides[place] = float(f"{box[place] + sign * moved:.10g}")
    # sides that stay keep all digits: horizons may end exactly there
    words = (repr(float(value)).removesuffix(".0") for value in sides)
    return f"box=({', '.join(words)})"


def warnings_of_rims(
    faults: Iterable[TriSurface], box: Sequence[float], aoi: np.ndarray | None
) -> list[GeosurfWarning]:
    """Return the warnings of all faults that are meshes and end just inside of a side."""
    found = (warning_of_rim(one, box, aoi) for one in faults if one.lattice is None)
    return [one for one in found if one is not None]


def _clipped(edges: np.ndarray, low: float, high: float) -> np.ndarray:
    """Edges (n, 2, 3) between two elevations: what is beyond is cut off."""
    a, b = edges[:, 0], edges[:, 1]
    rise = b[:, 2] - a[:, 2]
    safe = np.where(rise == 0.0, 1.0, rise)
    parts = []
    for start in (a, b):
        t = np.where(rise == 0.0, 0.0, (np.clip(start[:, 2], low, high) - start[:, 2]) / safe)
        parts.append(start + t[:, None] * (b - a))
    return np.stack(parts, axis=1)


def in_ring(points: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Whether points (..., 2 or more) lie inside of a ring in the map, but for rounding."""
    x, y = points[..., 0], points[..., 1]
    inside = np.zeros(x.shape, dtype=bool)
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        crosses = (a[1] > y) != (b[1] > y)
        rise = b[1] - a[1] if b[1] != a[1] else 1.0
        inside ^= crosses & (x < (b[0] - a[0]) * (y - a[1]) / rise + a[0])
    return inside


# ---- outside ----------------------------------------
# Faults that do not reach the model: which, how far away, and what to type to include them.


_SAMPLE = 4096  # places that are looked at
_ROOM = 0.05  # of the box, beyond the middle of a fault that it is to hold
_SIDES = (("west", "east"), ("south", "north"), ("below", "above"))


def lies_beside(surface: TriSurface, box: Sequence[float]) -> bool:
    """Return whether the bounds of a surface and a box have nothing in common."""
    bounds = surface.bounds
    return any(bounds[2 * k] > box[2 * k + 1] or bounds[2 * k + 1] < box[2 * k] for k in range(3))


def warning_of_fault(
    surface: TriSurface, box: Sequence[float], aoi: np.ndarray | None = None
) -> GeosurfWarning:
    """
    Return the warning of a fault that does not reach the model.

    Parameters
    ----------
    surface : TriSurface
    box : (west, east, south, north, bottom, top)
        [m]
    aoi : ndarray of float64, shape (n, 2), optional
        Area of interest, if there is one.

    Examples
    --------
    >>> wall = [[5500, 0, -90], [5500, 900, -90], [5500, 900, 0]]
    >>> fault = TriSurface("F2", "fault", wall, [[0, 1, 2]])
    >>> print(warning_of_fault(fault, (0, 5000, 0, 900, -90, 0)))
    Fault 'F2' lies 500 m east of the model box and is left out: it divides nothing. If it belongs \
to the model, enlarge the box to it, box=(0, 5750, 0, 900, -90, 0), if all horizons reach that far.
    """
    where = "model box" if aoi is None else "area of interest"
    bounds, wider, words = surface.bounds, list(box), []
    for k in range(3):
        # positive on the side where the fault's bounds end before the box begins
        below, above = box[2 * k] - bounds[2 * k + 1], bounds[2 * k] - box[2 * k + 1]
        if max(below, above) > 0:
            side = int(above > 0)
            words.append(f"{_metres(max(below, above))} {_SIDES[k][side]}")
            middle = 0.5 * (bounds[2 * k] + bounds[2 * k + 1])
            room = _ROOM * (box[2 * k + 1] - box[2 * k])
            wider[2 * k + side] = middle + room if side else middle - room

    # the distance is from samples: it goes into a sentence, not into the model
    points = _spots(surface)
    if words:
        of = "" if words[-1].endswith(_SIDES[2]) else " of"
        effect = f"{' and '.join(words)}{of} the {where}"
        low, high = np.array(box[0::2], dtype=float), np.array(box[1::2], dtype=float)
        off = np.maximum(points - high, 0.0) + np.maximum(low - points, 0.0)
        place = points[np.argmin((off**2).sum(axis=1))]
    else:
        # the bounds overlap, but the fault does not meet the outline in the map
        distance, place = _beside(points, outline_of(box, aoi))
        effect = f"about {_metres(distance)} away from the {where}"
        if aoi is None:  # above or below a part of it, as a dipping fault may
            effect = f"close to the {where}, but not in it,"
    remedy = f"enlarge {'box' if aoi is None else 'aoi'}= to it, if all horizons reach that far."
    if words and aoi is None:
        # whole metres, with decimals only for boxes narrower than 100 m: `box=` should be short to
        # type
        digits = max(0, 2 - math.floor(math.log10(max(box[1] - box[0], box[3] - box[2]))))
        sides = ", ".join(f"{round(value, digits):.12g}" for value in wider)
        remedy = f"enlarge the box to it, box=({sides}), if all horizons reach that far."
    remedy = f"If it belongs to the model, {remedy}"
    if words and words[-1].endswith(_SIDES[2]):
        check = "Check whether its z is depth or elevation (positive=), and its unit."
        remedy = check if aoi is not None and len(words) == 1 else f"{check} {remedy}"
    return GeosurfWarning(
        "outside",
        surface.name,
        f"Fault {surface.name!r} lies {effect} and is left out: it divides nothing.",
        remedy,
        place,
    )


def _spots(surface: TriSurface) -> np.ndarray:
    """Points all over a surface: of large triangles many, of many triangles some."""
    # a lattice of barycentric weights on each triangle, or one triangle in many: about 4096 places
    # in either case
    n = max(int((_SAMPLE / max(surface.n_triangle, 1)) ** 0.5), 1)
    weights = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
    triangles = surface.triangles[:: max(surface.n_triangle // _SAMPLE, 1)]
    spots: np.ndarray = weights @ surface.vertices[triangles]
    return spots.reshape(-1, 3)


def _metres(length: float) -> str:
    return f"{length:.0f} m" if length >= 100 else f"{length:.3g} m"


def _beside(points: np.ndarray, ring: np.ndarray) -> tuple[float, np.ndarray]:
    """Least distance in the map of points to a ring, and the point that has it."""
    best, spot = math.inf, points[0]
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        edge = b - a

        # foot of the perpendicular, clipped to the edge; 1e-300 spares doubled corners a division
        # by 0
        t = np.clip((points[:, :2] - a) @ edge / max(float(edge @ edge), 1e-300), 0.0, 1.0)
        gaps = np.hypot(*(a + t[:, None] * edge - points[:, :2]).T)
        k = int(np.argmin(gaps))
        if gaps[k] < best:
            best, spot = float(gaps[k]), points[k]
    return best, spot
