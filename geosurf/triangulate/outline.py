"""The area of interest: a closed ring on the map, checked and triangulated exactly."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from geosurf.conventions import area_text, length_text, place, real_numbers
from geosurf.conventions.checks import lines_of_foreign, straight_runs
from geosurf.errors import InputError, InvariantError, warn_of
from geosurf.kernels.exact.predicates import frame_of, orient2d_rows
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.meshes.mesh import edges
from geosurf.model import TriSurface
from geosurf.model.base import any_of
from geosurf.model.expected import SIDES, box_of_sides
from geosurf.model.torn_lattice import TornLattice


def check_outline(outline: Any) -> np.ndarray:
    """
    Return the corners of an area of interest, counter-clockwise, each once.

    Parameters
    ----------
    outline : array_like of float, shape (n, 2) or (n, 3)
        Easting and northing [m] around the area, either way; a third column is not read. The
        first corner may be repeated at the end. Or one polygon of xtgeo, shapely or geopandas.

    Returns
    -------
    ndarray of float64, shape (n, 2)
        Starts at the corner farthest west, of these farthest south.

    Raises
    ------
    InputError
        If there are fewer than three corners or several rings, a value is not finite, the
        ring crosses or touches itself (with the place), or has no area.

    Examples
    --------
    >>> check_outline([[0, 9], [9, 9], [9, 0], [0, 0], [0, 9]]).tolist()
    [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]]
    """
    ring = _as_ring(outline)

    # repeated corners, the closing one among them, have no side between them
    again = (ring == np.roll(ring, 1, axis=0)).all(axis=1)
    ring = ring[~again] if len(ring) > 1 else ring
    if len(ring) < 3:
        raise InputError(
            f"aoi: the ring has {len(ring)} different corners, expected at least 3. Give the "
            "corners of the area, in order."
        )

    _refuse_self_contact(ring)
    # Counter-clockwise, from the westernmost (then southernmost) corner: one form for each ring.
    if signed_area(ring) < 0:
        ring = ring[::-1]
    first = int(np.lexsort(ring.T[::-1])[0])
    return np.roll(ring, -first, axis=0)


def signed_area(ring: np.ndarray) -> float:
    """Area inside a ring (n, 2) [m2], rounded once; negative if clockwise."""
    # The shoelace formula in fractions.
    x, y = ([Fraction(value) for value in column] for column in ring.T.tolist())
    return float(sum(x[i - 1] * y[i] - x[i] * y[i - 1] for i in range(len(ring))) / 2)


def _as_ring(outline: Any) -> np.ndarray:
    how = "Give one array (n, 2) of easting and northing [m] around the area."
    if isinstance(outline, list | tuple) and len(outline) and np.ndim(outline[0]) == 2:
        if len(outline) > 1:
            raise InputError(
                f"aoi: found {len(outline)} rings, but only one ring without holes is "
                f"supported. {how}"
            )
        outline = outline[0]
    try:
        lines = lines_of_foreign(outline, on_map=True)
    except ValueError as error:
        raise InputError(f"aoi: {error}. {how}") from error
    if lines is not None:
        return _as_ring(lines)
    try:
        ring = real_numbers(outline)
    except (TypeError, ValueError) as error:
        raise InputError(f"aoi: {type(outline).__name__} does not hold numbers. {how}") from error

    if ring.ndim != 2 or ring.shape[1] not in (2, 3):
        raise InputError(f"aoi: found shape {ring.shape}. {how}")

    bad = np.flatnonzero(~np.isfinite(ring[:, :2]).all(axis=1))
    if len(bad):
        raise InputError(f"aoi: corner {bad[0]} (counted from 0) is not finite. {how}")
    return ring[:, :2] + 0.0


def _refuse_self_contact(ring: np.ndarray) -> None:
    """Raise an error at the first place where sides that are not neighbours meet, exact."""
    # Sides i from a[i] to b[i]; boxes exclude most pairs before exact arithmetic.
    n = len(ring)
    a, b = ring, np.roll(ring, -1, axis=0)
    low, high = np.minimum(a, b), np.maximum(a, b)
    for i in range(n):
        near = (low[i + 1 :] <= high[i]).all(axis=1) & (high[i + 1 :] >= low[i]).all(axis=1)
        for j in (np.flatnonzero(near) + i + 1).tolist():
            neighbours = (j - i) in (1, n - 1)
            met = _meet(a[i], b[i], a[j], b[j], neighbours)
            if met is not None:
                raise InputError(
                    f"aoi: the ring meets itself at {place(met)}, where side {i} and side {j} "
                    f"(counted from 0) {'fold back' if neighbours else 'cross or touch'}. "
                    "Correct the ring there."
                )


def _meet(
    p: Sequence[float], q: Sequence[float], r: Sequence[float], s: Sequence[float], neighbours: bool
) -> tuple[float, float] | None:
    """A common point of two segments, except the corner that neighbours share."""
    # Floats are fractions, so the turns below are exact.
    (px, py), (qx, qy), (rx, ry), (sx, sy) = (
        (Fraction(float(x)), Fraction(float(y))) for x, y in (p, q, r, s)
    )
    ends = {(px, py), (qx, qy)} & {(rx, ry), (sx, sy)} if neighbours else set()

    def turn(
        ax: Fraction, ay: Fraction, bx: Fraction, by: Fraction, cx: Fraction, cy: Fraction
    ) -> Fraction:
        """Twice the area of a, b, c; positive if they turn left."""
        return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)

    # A proper crossing: both ends of either segment lie on different sides of the other.
    turn_p, turn_q = turn(rx, ry, sx, sy, px, py), turn(rx, ry, sx, sy, qx, qy)
    if turn_p * turn_q < 0:
        turn_r, turn_s = turn(px, py, qx, qy, rx, ry), turn(px, py, qx, qy, sx, sy)
        if turn_r * turn_s < 0:
            t = turn_p / (turn_p - turn_q)
            return float(px + t * (qx - px)), float(py + t * (qy - py))

    # Otherwise they meet only if an end of one lies on the other.
    for x, y, ax, ay, bx, by in (
        (px, py, rx, ry, sx, sy), (qx, qy, rx, ry, sx, sy),
        (rx, ry, px, py, qx, qy), (sx, sy, px, py, qx, qy),
    ):  # fmt: skip
        on = turn(ax, ay, bx, by, x, y) == 0
        within = min(ax, bx) <= x <= max(ax, bx) and min(ay, by) <= y <= max(ay, by)
        if on and within and (x, y) not in ends:
            return float(x), float(y)
    return None


def triangulate_ring(ring: np.ndarray) -> np.ndarray:
    """
    Triangulate the inside of a ring by cutting ears (Meisters 1975), decided exactly.

    Parameters
    ----------
    ring : ndarray of float64, shape (n, 2)
        As `check_outline` returns it.

    Returns
    -------
    ndarray of int64, shape (n - 2, 3)
        Rows of `ring`, counter-clockwise.

    Examples
    --------
    >>> triangulate_ring(np.array([[0.0, 0], [9, 0], [9, 9], [0, 9]])).tolist()
    [[3, 0, 1], [1, 2, 3]]
    """
    # The kernel takes three coordinates; only two of them count.
    corners = np.zeros((len(ring), 3))
    corners[:, :2] = ring
    m, w = frame_of(corners)

    def turns(rows: Any) -> np.ndarray:
        """Exact sign of the turn at each row of three corners."""
        rows = np.array(rows, dtype=np.int64).reshape(-1, 3)
        out = np.zeros(len(rows), dtype=np.int64)
        orient2d_rows(corners, rows, m, w, out)
        return out

    # An ear turns left and holds no other corner. Each simple ring has two of them.
    left = list(range(len(ring)))
    faces = []
    while len(left) > 3:
        for k in range(len(left)):
            ear = (left[k - 1], left[k], left[(k + 1) % len(left)])
            if turns(ear)[0] > 0 and not _holds_any(ear, left, ring, turns):
                faces.append(ear)
                del left[k]
                break
        else:
            raise InvariantError(
                "the area of interest could not be triangulated. Please report this with its "
                "outline."
            )
    faces.append((left[0], left[1], left[2]))
    return np.array(faces, dtype=np.int64)


def _holds_any(
    ear: tuple[int, int, int],
    left: Sequence[int],
    ring: np.ndarray,
    turns: Callable[..., np.ndarray],
) -> bool:
    """Whether any other corner lies in the closed triangle."""
    # Corners in the box of the ear are tested exactly: on or left of all three sides.
    others = np.array([i for i in left if i not in ear], dtype=np.int64)
    corners = ring[list(ear)]
    near = (ring[others] >= corners.min(axis=0)).all(axis=1)
    near &= (ring[others] <= corners.max(axis=0)).all(axis=1)
    others = others[near]
    inside = np.ones(len(others), dtype=bool)
    for k in range(3):
        a, b = ear[k], ear[(k + 1) % 3]
        rows = np.stack([np.full(len(others), a), np.full(len(others), b), others], axis=1)
        inside &= turns(rows) >= 0
    return bool(inside.any())


# ---- walls ----------------------------------------
# The walls of the model: the six sides of a box, or a fence around an area of interest.


# corner i of the box is east, north, top where bit 0, 1, 2 of i is set; each row is
# one side, seen from outside counter-clockwise
_CORNERS = {
    "west": (0, 4, 6, 2),
    "east": (1, 3, 7, 5),
    "south": (0, 1, 5, 4),
    "north": (2, 6, 7, 3),
    "bottom": (0, 2, 3, 1),
    "top": (4, 5, 7, 6),
}


def build_walls(box: Sequence[float], aoi: Any = None) -> list[TriSurface]:
    """Return the walls of the model as surfaces: the six sides of a box, or a fence.

    Parameters
    ----------
    box : (west, east, south, north, bottom, top)
        World coordinates [m], elevation positive up.
    aoi : array_like of float, shape (n, 2), optional
        Area of interest: easting and northing around a polygon inside the box, which
        need not be convex. The model is then what lies inside it, from bottom to top of the box.

    Returns
    -------
    list of TriSurface
        Role "wall", normals out of the model: ``west``, ``east``, ``south``, ``north``,
        ``bottom`` and ``top``, in this order, two triangles each; or ``aoi`` (two vertical
        triangles for each side of the polygon), ``bottom`` and ``top``.

    Raises
    ------
    InputError
        If the box does not have six finite numbers, or is not in order; if the polygon crosses
        itself, has holes, or leaves the box.

    Examples
    --------
    >>> walls = build_walls((0, 4000, 0, 3000, -2500, -1500))
    >>> [wall.name for wall in walls]
    ['west', 'east', 'south', 'north', 'bottom', 'top']
    >>> walls[0].bounds
    (0.0, 0.0, 0.0, 3000.0, -2500.0, -1500.0)
    >>> corner = [(0, 0), (4000, 0), (4000, 1000), (1000, 1000), (1000, 3000), (0, 3000)]
    >>> [wall.n_triangle for wall in build_walls((0, 4000, 0, 3000, -2500, -1500), corner)]
    [12, 4, 4]
    """
    limits = box_of_sides(box).reshape(3, 2)
    if aoi is not None:
        return _fence(check_outline(aoi), limits)

    # corner i: bit 0 of i is east, bit 1 north, bit 2 top
    corners = np.array([[limits[axis, (i >> axis) & 1] for axis in range(3)] for i in range(8)])
    halves = [[0, 1, 2], [0, 2, 3]]
    return [
        TriSurface(side, "wall", corners[list(_CORNERS[side])], np.array(halves)) for side in SIDES
    ]


def _fence(ring: np.ndarray, limits: np.ndarray) -> list[TriSurface]:
    """Upright walls along a ring, and the caps between them."""
    # Each corner has to lie inside the box; `out` is the outward direction on the axis.
    for axis, sides in enumerate((("west", "east"), ("south", "north"))):
        for corner in ring:
            for side, limit, out in zip(sides, limits[axis], (-1.0, 1.0), strict=True):
                if out * (corner[axis] - limit) > 0:
                    raise InputError(
                        f"aoi: corner {place(corner)} lies beyond the {side} of the box "
                        f"({limit:.1f} m). Enlarge the box, or leave it out."
                    )

    # The ring is counter-clockwise, so these quads face outwards.
    n = len(ring)
    low, high = (np.column_stack([ring, np.full(n, z)]) for z in limits[2])
    here, there = np.arange(n), (np.arange(n) + 1) % n
    strips = [np.stack([here, there, there + n], 1), np.stack([here, there + n, here + n], 1)]

    faces = triangulate_ring(ring)
    return [
        TriSurface("aoi", "wall", np.concatenate([low, high]), np.concatenate(strips)),
        TriSurface("bottom", "wall", low, faces[:, ::-1]),
        TriSurface("top", "wall", high, faces),
    ]


# ---- rims ----------------------------------------
# Sides of a model that run along the rim of a horizon, to within rounding.
#
# The corners of a rotated grid are the natural area of interest. Its rim nodes lie on the sides of
# that area on paper; in float64 they are off by a nanometre, some of them inside. There the
# horizon is open, exactly. Which points are open is decided by exact signs, as always; the area is
# what is changed, by an amount that a warning states: its sides there are moved inward.


# ---- inward ----------------------------------------
# Polygons with fewer corners and a stated distance inside: they only shrink.
#
# An ear is a corner that points outward, with its two neighbours; if no other corner lies in that
# triangle, cutting it off leaves a polygon inside of the former one. Smallest ears go first
# (Visvalingam & Whyatt 1993, who also cut corners that point inward).


def with_fewer_corners(ring: np.ndarray, each: float, total: float) -> np.ndarray:
    """
    Return a polygon inside another one, with some of its corners.

    Parameters
    ----------
    ring : ndarray of int64, shape (n, 2)
        Whole numbers, counter-clockwise; it does not meet itself.
    each, total : float
        The largest area of an ear, and of all ears, that may be cut off.

    Returns
    -------
    ndarray of int64, shape (m, 2)

    Examples
    --------
    >>> stairs = np.array([[0, 0], [9, 0], [9, 8], [2, 8], [2, 7], [1, 7], [1, 6], [0, 6]])
    >>> with_fewer_corners(stairs, each=0.5, total=2.0).tolist()
    [[0, 0], [9, 0], [9, 8], [2, 8], [2, 7], [1, 6], [0, 6]]
    """
    n = len(ring)
    columns = np.ascontiguousarray(ring.T)

    # a linked ring: before and after of each corner that is still alive
    before, after = (np.arange(n) - 1) % n, (np.arange(n) + 1) % n
    alive, x, y = np.ones(n, dtype=bool), ring[:, 0], ring[:, 1]
    left, budget = n, 2.0 * total

    def doubled(k: int) -> int:
        """Twice the area of the ear at a corner; below 0 where it points inward."""
        i, j = before[k], after[k]
        return int((x[k] - x[i]) * (y[j] - y[i]) - (y[k] - y[i]) * (x[j] - x[i]))

    heap = [(ear, k) for k in range(n) if 0 <= (ear := doubled(k)) <= 2.0 * each]
    heapq.heapify(heap)
    while heap and left > 3:
        ear, k = heapq.heappop(heap)

        # entries of the heap go stale when a neighbour is cut: the current ear has another entry
        if not alive[k] or ear != doubled(k) or ear > budget:
            continue
        i, j = int(before[k]), int(after[k])
        if ear > 0 and _holds_corner(columns, alive, (i, k, j)):
            continue

        # the two neighbours get new ears, which may be cut in turn
        alive[k], after[i], before[j] = False, j, i
        left, budget = left - 1, budget - ear
        for one in (i, j):
            if 0 <= (ear := doubled(one)) <= 2.0 * each:
                heapq.heappush(heap, (ear, one))
    return ring[alive]


def _holds_corner(ring: np.ndarray, alive: np.ndarray, ear: tuple[int, int, int]) -> bool:
    """Whether any other corner of a ring (2, n) lies in a closed triangle, counter-clockwise."""
    corners = ring[:, ear]
    (west, south), (east, north) = corners.min(axis=1), corners.max(axis=1)

    # one coordinate after the other: pairs in rows take five times as long
    x, y = ring
    near = (x >= west) & (x <= east) & (y >= south) & (y <= north) & alive
    near[list(ear)] = False
    others = np.flatnonzero(near)
    if not len(others):
        return False
    inside = np.ones(len(others), dtype=bool)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        # whole numbers of cells: exact without further care
        (i, j), (u, v) = corners[:, a], corners[:, b] - corners[:, a]
        inside &= u * (y[others] - j) - v * (x[others] - i) >= 0
    return bool(inside.any())


def moved_inward(outline: np.ndarray, inward: np.ndarray) -> np.ndarray:
    """Corners (n, 2) of an area whose sides have moved inward by some lengths (n,) [m]."""
    # corner: where the two moved sides meet, unless they are parallel
    sides = np.roll(outline, -1, axis=0) - outline
    sides /= np.hypot(*sides.T)[:, None]
    normals = np.column_stack([-sides[:, 1], sides[:, 0]])
    corners = []
    for corner, n1, n2, d1, d2 in zip(
        outline, np.roll(normals, 1, axis=0), normals, np.roll(inward, 1), inward, strict=True
    ):
        if abs(n1[0] * n2[1] - n1[1] * n2[0]) > 1e-3:
            corners.append(corner + np.linalg.solve(np.stack([n1, n2]), [d1, d2]))
        else:  # the sides run on into each other
            corners.append(corner + max(d1, d2) * n2)
    return np.array(corners)


def lies_inside(outline: np.ndarray, rim: np.ndarray) -> bool:
    """
    Return whether an area is inside of a horizon, and its outline meets no rim; exact.

    Parameters
    ----------
    outline : ndarray of float64, shape (n, 2)
        Counter-clockwise.
    rim : ndarray of float64, shape (m, 2, 2)
        Segments with the horizon on their left.

    Examples
    --------
    >>> square = np.array([[0.0, 0], [4, 0], [4, 4], [0, 4]])
    >>> rim = np.stack([square, np.roll(square, -1, axis=0)], axis=1)
    >>> lies_inside(0.5 * square + 1, rim), lies_inside(square, rim), lies_inside(square + 9, rim)
    (True, False, False)
    """
    m, n = len(rim), len(outline)
    points = np.concatenate([rim.reshape(-1, 2), outline])
    here, there = 2 * m + np.arange(n), 2 * m + (np.arange(n) + 1) % n
    low, high = rim.min(axis=1), rim.max(axis=1)

    # pairs of a rim segment (a, b) and a side (p, q) whose boxes meet
    pairs = []
    for p, q in zip(here, there, strict=True):
        near = (high >= np.minimum(points[p], points[q])).all(axis=1)
        near &= (low <= np.maximum(points[p], points[q])).all(axis=1)
        of = np.flatnonzero(near)
        pairs.append(np.stack([2 * of, 2 * of + 1, 0 * of + p, 0 * of + q], axis=1))
    a, b, p, q = np.concatenate(pairs).T

    # two segments meet unless one lies strictly on one side of the other; touching counts as
    # meeting
    apart = _turn_signs(points, p, q, a) * _turn_signs(points, p, q, b) > 0
    apart |= _turn_signs(points, a, b, p) * _turn_signs(points, a, b, q) > 0
    if not apart.all():
        return False

    # the rim around one corner: upward on its right, downward on its left
    across = np.flatnonzero((low[:, 1] <= outline[0, 1]) & (outline[0, 1] < high[:, 1]))
    a, b = 2 * across, 2 * across + 1
    upward = points[a, 1] < points[b, 1]
    on_left = (
        _turn_signs(points, np.where(upward, a, b), np.where(upward, b, a), 0 * a + here[0]) > 0
    )
    return int(np.where(upward, 1, -1)[on_left].sum()) >= 1


def _turn_signs(points: np.ndarray, p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
    """On which side of the lines from p to q the points r lie, exactly: +1 is left."""
    x = np.zeros((len(points), 3))
    x[:, :2] = points
    m, w = frame_of(x)
    out = np.empty(len(p), dtype=np.int64)
    orient2d_rows(x, np.stack([p, q, r], axis=1).astype(np.int64), m, w, out)
    return out


# Parts of the size of the area: a rim nearer to a side than NEAR runs along it (8 mm in 1 km, as
# with corners of two decimals), and a side is moved by at least LEAST.
NEAR, LEAST = 2.0**-17, 2.0**-34
# Slivers between a rim and a side can be too thin for float64. Their vertices then move by up to
# ROUNDED (the first step of `rebuild.repair`), which puts a rim on the other side of an oblique
# one; on a side along an axis it comes to lie.
ROUNDED = 2.0**-28  # [m]
FURTHER = 4.0  # times as far inside as the farthest of these rim nodes, or as they may move


def off_the_rims(outline: np.ndarray, horizons: Sequence[TriSurface], what: str) -> np.ndarray:
    """
    Return an area whose sides do not run along a rim, and warn if that is not the one given.

    Parameters
    ----------
    outline : ndarray of float64, shape (n, 2)
        Corners, counter-clockwise [m].
    horizons : sequence of TriSurface
    what : str
        What the area is, for the warning: ``"area of interest"`` or ``"model box"``.

    Returns
    -------
    ndarray of float64, shape (n, 2)
        The same array if rims are exactly on its sides, or away from them.

    Examples
    --------
    >>> corners = [[0.1, 0, 5], [9.8, 0.1, 5], [9.9, 10, 5], [0, 10, 5]]
    >>> top = TriSurface("Top", "horizon", corners, [[0, 1, 2], [0, 2, 3]])
    >>> area = np.array([[2.0, 2.0], [4.0, 2.0], [4.0, 4.0]])
    >>> off_the_rims(area, [top], "area of interest") is area
    True
    """
    size = float(np.ptp(outline, axis=0).max())
    along = np.zeros(len(outline), dtype=bool)
    named: dict[str, float] = {}
    for horizon in horizons:
        beside, depth = _rim_beside(outline, horizon, NEAR * size)
        along |= beside
        if depth > 0:
            named[horizon.name] = depth

    if not named:
        return outline

    # far enough that rounding of the moved corners, or of the rim, leaves no rim node inside
    inward = max(FURTHER * max(*named.values(), ROUNDED), LEAST * size)

    area = check_outline(moved_inward(outline, np.where(along, inward, 0.0)))
    lost = signed_area(outline) - signed_area(area)
    names = " and ".join(repr(name) for name in named)

    warn_of(
        "rim",
        next(iter(named)),
        f"The {what} runs along the rim of horizon {names}, which is up to "
        f"{length_text(max(named.values()), 2)} off its sides. geosurf moved them inward "
        f"by {length_text(inward, 2)}, which leaves out {area_text(lost)}.",
        "To choose the area yourself, pass one that ends farther inside the horizon.",
        (*_middle_of_side(outline, int(along.argmax())), float(horizons[0].bounds[4])),
    )
    return area


def _rim_beside(outline: np.ndarray, horizon: TriSurface, near: float) -> tuple[np.ndarray, float]:
    """Which sides a rim runs along, and how far off the farthest of the nodes that count is [m].

    That is 0 if all are exactly on their sides, or stay outside.
    """
    along_rim, depth = np.zeros(len(outline), dtype=bool), 0.0
    rim = _rim(horizon, outline, near)
    for sides in straight_runs(outline, near):
        # One node touches a straight run of sides; two or more run along it.
        beside = [_beside_side(outline, k, rim, near) for k in sides]
        if len(np.unique(np.concatenate([rows for rows, _ in beside]))) > 1:
            along_rim[sides] = True
            depth = max(depth, *(deep for _, deep in beside))
    return along_rim, depth


def _beside_side(
    outline: np.ndarray, k: int, rim: np.ndarray, near: float
) -> tuple[np.ndarray, float]:
    """Rows of the rim nodes beside side k, and how far off it the farthest that counts is [m]."""
    a, b = outline[k], outline[(k + 1) % len(outline)]
    # Distance of rim nodes from the side, positive inside, and position along it [m].
    along = (b - a) / np.hypot(*(b - a))
    from_a = rim - a
    inside = along[0] * from_a[:, 1] - along[1] * from_a[:, 0]
    s = from_a @ along
    rows = np.flatnonzero(
        (np.abs(inside) <= near) & (s >= -near) & (s <= np.hypot(*(b - a)) + near)
    )
    # Nodes that are exactly inside count, and those that may move across an oblique side.
    points = np.concatenate([[a, b], rim[rows]])
    ends = np.zeros(len(rows), dtype=np.int64)
    signs = _turn_signs(points, ends, ends + 1, np.arange(2, len(points)))
    counts = (signs > 0) | ((signs < 0) & (inside[rows] > -ROUNDED) & (a != b).all())
    if not counts.any():
        return rows, 0.0
    return rows, max(float(np.abs(inside[rows[counts]]).max()), np.finfo(float).tiny)


def _rim(horizon: TriSurface, outline: np.ndarray, near: float) -> np.ndarray:
    """Nodes on the rim of a horizon, in the map (n, 2): at least those near a side."""
    lattice = horizon.lattice
    if lattice is None and horizon.torn is not None and horizon.torn.nodes_are_all_there:
        return _torn_rim(horizon.torn, _lines(outline), 2.0 * near)
    if lattice is None:
        # All triangles around a vertex near a side have it: their edges there are complete.
        x, y, _ = horizon.vertices.T
        close = np.zeros(len(x), dtype=bool)
        for a, b, c in _lines(outline):
            close |= np.abs(a * x + b * y + c) <= 2.0 * near
        triangles = horizon.triangles[any_of(close[horizon.triangles])]
        return horizon.vertices[_free_ends(triangles, distinct(triangles), close), :2]
    if lattice.whole and lattice.easting.ndim == 1:
        return _frame(lattice.easting, lattice.northing)

    # A node is on the rim unless all eight neighbours exist.
    n_row, n_col = lattice.shape
    there = np.pad(lattice.present, 1)
    inner = np.ones((n_row, n_col), dtype=bool)
    for i in (0, 1, 2):
        for j in (0, 1, 2):
            inner &= there[i : i + n_row, j : j + n_col]
    return lattice.map_places(np.flatnonzero(lattice.present & ~inner))


def _torn_rim(torn: TornLattice, lines: np.ndarray, near: float) -> np.ndarray:
    """Nodes and ghosts on the rim of a torn sheet near some lines, in the map (n, 2)."""
    close, beyond = _close_nodes(torn, lines, near)
    if not (close.any() or beyond.any()):
        return np.empty((0, 2))

    # all triangles around a vertex near a line: their edges there are complete
    cells = np.flatnonzero(close[:-1, :-1] | close[:-1, 1:] | close[1:, :-1] | close[1:, 1:])
    keys = np.repeat(2 * cells, 2)
    keys[1::2] += 1
    keys = keys[~is_among(keys, torn.gone)]
    is_close = np.concatenate([close.ravel(), beyond])
    copies = torn.copies[any_of(is_close[torn.copies])]
    triangles = np.concatenate([torn.corners_of_keys(keys), copies])
    ends = _free_ends(triangles, distinct(triangles), is_close)
    return torn.places_of_nodes(ends)[:, :2]


def _close_nodes(
    torn: TornLattice, lines: np.ndarray, near: float
) -> tuple[np.ndarray, np.ndarray]:
    """Which nodes (n_row, n_col) and ghosts (n_ghost,) of a torn sheet are near some lines."""
    beyond = np.zeros(len(torn.ghosts), dtype=bool)
    for a, b, c in lines:
        beyond |= np.abs(torn.ghosts[:, 0] * a + torn.ghosts[:, 1] * b + c) <= near
    if torn.easting.ndim == 2:
        x, y = torn.horizontal()
        close = np.zeros(torn.shape, dtype=bool)
        for a, b, c in lines:
            close |= np.abs(a * x + (b * y + c)) <= near
        return close, beyond

    # a line along an axis is near whole rows or columns
    x, y = torn.easting, torn.northing
    rows, columns = np.zeros(len(y), dtype=bool), np.zeros(len(x), dtype=bool)
    for _, b, c in lines[lines[:, 0] == 0]:
        rows |= np.abs(b * y + c) <= near
    for a, _, c in lines[lines[:, 1] == 0]:
        columns |= np.abs(a * x + c) <= near
    close = rows[:, None] | columns
    for a, b, c in lines[(lines[:, 0] != 0) & (lines[:, 1] != 0)]:
        close |= np.abs(a * x + (b * y[:, None] + c)) <= near
    return close, beyond


def _free_ends(triangles: np.ndarray, used: np.ndarray, close: np.ndarray) -> np.ndarray:
    """Vertices, rising, that are `close` and ends of edges of one triangle only."""
    mine = np.searchsorted(used, triangles)
    ring, _ = edges(mine, len(used))
    row, corner = np.divmod(np.flatnonzero(ring == np.arange(len(ring))), 3)
    ends = distinct(triangles[row, corner], triangles[row, (corner + 1) % 3])
    return ends[close[ends]]


def _lines(outline: np.ndarray) -> np.ndarray:
    """The lines through the sides of an outline: a x + b y + c is the distance (n, 3)."""
    along = np.roll(outline, -1, axis=0) - outline
    along /= np.hypot(*along.T)[:, None]
    return np.column_stack(
        [-along[:, 1], along[:, 0], along[:, 1] * outline[:, 0] - along[:, 0] * outline[:, 1]]
    )


def _frame(easting: np.ndarray, northing: np.ndarray) -> np.ndarray:
    """Nodes around a grid without holes, from its axes (n, 2)."""
    along = [np.column_stack([easting, np.full(len(easting), y)]) for y in northing[[0, -1]]]
    up = [np.column_stack([np.full(len(northing), x), northing]) for x in easting[[0, -1]]]
    return np.concatenate([*along, *up])


def _middle_of_side(outline: np.ndarray, k: int) -> tuple[float, float]:
    x, y = (0.5 * (outline[k] + outline[(k + 1) % len(outline)])).tolist()
    return x, y
