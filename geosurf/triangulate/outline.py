"""The area of interest: a closed ring on the map, checked and triangulated exactly."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from geosurf.conventions import place, real_numbers
from geosurf.conventions.foreign import lines_of_foreign
from geosurf.errors import InputError, InvariantError
from geosurf.kernels.exact.predicates import frame_of, orient2d_rows
from geosurf.model import TriSurface
from geosurf.model.expected import SIDES, box_of_sides


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
    one, two = turn(rx, ry, sx, sy, px, py), turn(rx, ry, sx, sy, qx, qy)
    if one * two < 0:
        three, four = turn(px, py, qx, qy, rx, ry), turn(px, py, qx, qy, sx, sy)
        if three * four < 0:
            t = one / (one - two)
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
