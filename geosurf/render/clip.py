"""Clip surfaces and lines to the model, for pictures.

The model is a prism: the area of interest on the map, between two levels. It is split into convex
prisms, and triangles are clipped by their sides one after the other (Sutherland & Hodgman 1974).
The result is rounded and used only for pictures, never for topology.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from geosurf.conventions.checks import straight_runs
from geosurf.kernels.lattices.sets import ranges
from geosurf.kernels.meshes.mesh import renumbered
from geosurf.model.expected import outline_of

# ---- outline cells ----------------------------------------
# Which triangles and lines are certainly inside or outside of an outline, by cells of a raster.
#
# Outlines of rotated grids are not convex. Clipped part by part, each part would ask for the side
# of every point. Cells of a raster that no side of the outline is near are inside or outside as a
# whole, and nearly all triangles lie in such cells. Sums over the raster answer for many cells at
# once.


_CELLS = 256  # along the longer side of the outline
_PER_CELL = 4  # points along a side in the length of a cell, so that it skips no cell by much
OUTSIDE, NEAR, INSIDE = 0, 1, 2


class OutlineCells:
    """
    A raster over an outline.

    Parameters
    ----------
    outline : ndarray of float64, shape (n, 2)
        Corners in order; it does not meet itself.

    Examples
    --------
    >>> cells = OutlineCells(np.array([[0.0, 0], [9, 0], [9, 9], [5, 1], [0, 9]]))
    >>> points = np.array([[1.0, 1], [1.1, 1], [1, 1.1], [5, 5], [5.1, 5], [5, 5.1], [0, 0]])
    >>> cells.sort(points, np.array([[0, 1, 2], [3, 4, 5], [0, 1, 6]])).tolist()
    [2, 0, 1]
    """

    def __init__(self, outline: np.ndarray) -> None:
        low, size = outline.min(axis=0), np.ptp(outline, axis=0)
        self._step = float(size.max()) / _CELLS
        # cells around the outline stand for all that is beyond
        self._low = low - 4.0 * self._step
        self._shape = tuple((np.ceil(size / self._step) + 8).astype(int).tolist())
        codes = self._coded(outline)
        self._sums = {
            code: np.pad(np.cumsum(np.cumsum(codes == code, axis=0), axis=1), ((1, 0), (1, 0)))
            for code in (OUTSIDE, INSIDE)
        }

    def sort(self, points: np.ndarray, elements: np.ndarray) -> np.ndarray:
        """
        Return OUTSIDE, INSIDE, or NEAR where it is not certain, for each triangle or segment.

        Parameters
        ----------
        points : ndarray of float64, shape (n, 2 or 3)
        elements : ndarray of int64, shape (m, 3 or 2)
        """
        # beyond the raster its last cells count, which are outside
        at = (points[:, :2] - self._low) / self._step
        cell = np.clip(at, 0, np.array(self._shape) - 1).astype(np.int32)
        corners = [cell[column] for column in elements.T]
        (i, j), (k, m) = np.minimum.reduce(corners).T, np.maximum.reduce(corners).T + 1
        n_cell = (k - i) * (m - j)
        codes = np.full(len(elements), NEAR)
        for code, sums in self._sums.items():
            number = sums[k, m] - sums[i, m] - sums[k, j] + sums[i, j]
            codes[number == n_cell] = code
        return codes

    def _coded(self, outline: np.ndarray) -> np.ndarray:
        """The code of each cell."""
        start, step = outline, np.roll(outline, -1, axis=0) - outline
        n = np.ceil(_PER_CELL * np.abs(step).max(axis=1) / self._step).astype(int) + 1
        of, part = ranges(0, n)
        share = (part / n[of])[:, None]
        i, j = ((start[of] + share * step[of] - self._low) / self._step).astype(int).T

        # the cells around each point, too: between two points a side passes no others
        codes = np.where(self._middles_inside(outline), INSIDE, OUTSIDE)
        for row in (-1, 0, 1):
            for col in (-1, 0, 1):
                codes[i + row, j + col] = NEAR
        return codes

    def _middles_inside(self, outline: np.ndarray) -> np.ndarray:
        """Whether the middle of each cell is inside: sides to the left of it, even or odd."""
        n_x, n_y = self._shape
        y = self._low[1] + (np.arange(n_y) + 0.5) * self._step
        (x1, y1), (x2, y2) = outline.T, np.roll(outline, -1, axis=0).T
        row, side = np.nonzero((y1 <= y[:, None]) != (y2 <= y[:, None]))
        at = x1[side] + (y[row] - y1[side]) / (y2[side] - y1[side]) * (x2[side] - x1[side])
        first = np.ceil((at - self._low[0]) / self._step - 0.5).astype(int)
        steps = np.zeros((n_x + 1, n_y), dtype=np.int64)
        np.add.at(steps, (np.clip(first, 0, n_x), row), 1)
        made: np.ndarray = np.cumsum(steps[:-1], axis=0) % 2 == 1
        return made


MANY = 32  # corners of an outline from which straight runs of sides are joined
AT_ONCE = 32  # half-spaces that one number has bits for
STRAIGHT = 1e-7  # of its size: far below a pixel


class Prism:
    """The region of space of a model: an area of interest between two levels.

    Parameters
    ----------
    box : (west, east, south, north, bottom, top)
        [m].
    outline : ndarray of float64, shape (n, 2), optional
        Area of interest, counter-clockwise, within the box; default: all of it.

    Examples
    --------
    >>> points = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
    >>> x, t, cut = Prism((0, 2, 0, 9, -1, 1)).triangles(points, np.array([[0, 1, 2]]))
    >>> len(t), float(x[:, 0].max()), x[cut][:, :, 0].tolist()
    (2, 2.0, [[2.0, 2.0]])
    """

    def __init__(
        self, box: Sequence[float] | np.ndarray, outline: np.ndarray | None = None
    ) -> None:
        self.box = tuple(float(value) for value in box)
        self.outline = outline_of(self.box, outline)
        # exported outlines have many short sides on one line: each would cut every triangle
        if len(self.outline) > MANY:
            near = STRAIGHT * float(np.ptp(self.outline, axis=0).max())
            self.outline = self.outline[[run[0] for run in straight_runs(self.outline, near)]]

    @cached_property
    def parts(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Convex parts: half-spaces (n, 4), and whether each is a wall of the model."""
        bottom, top = self.box[4:]
        levels = np.array([[0.0, 0.0, 1.0, -bottom], [0.0, 0.0, -1.0, top]])
        convex = []
        for ring, outer in convex_parts(self.outline):
            # a half-space per side: a point is inside where inward . point + offset >= 0
            step = np.roll(ring, -1, axis=0) - ring
            inward = np.stack([-step[:, 1], step[:, 0], np.zeros(len(ring))], axis=1)
            offset = -(inward[:, :2] * ring).sum(axis=1)
            sides = np.concatenate([np.column_stack([inward, offset]), levels])

            # diagonals between convex parts are no walls: edges along them are not drawn
            convex.append((sides, np.append(outer, [True, True])))
        return convex

    def holds(self, points: np.ndarray) -> bool:
        """Whether all points (n, 3) are certainly inside; only tested for convex areas."""
        if len(self.parts) > 1:
            return False
        return all((_distances(points, side[None]) >= 0).all() for side in self.parts[0][0])

    def triangles(
        self, points: np.ndarray, triangles: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return points, triangles and edges along walls of the part inside the prism."""
        if self.holds(points):
            return points, triangles, np.empty((0, 2), dtype=np.int64)

        # triangles inside all sides stay as they are; of the others, those are cut that no side
        # has outside
        whole, near_cells = self._settled_by_cells(points, triangles)
        whole, triangles = triangles[whole], triangles[near_cells]
        kept, near, pieces, flags = [whole], [], [], []
        used, number = np.unique(triangles, return_inverse=True)
        mesh = points[used], number.reshape(-1, 3)
        for sides, outer in self.parts:
            inside, met = _sorted_out(*mesh, sides)
            kept.append(triangles[inside])
            near.append(triangles[met])

            # corners (n, 3, 3); flags (n, 3): whether the edge after each runs along a wall
            piece, flag = points[near[-1]], np.zeros((len(near[-1]), 3), dtype=bool)
            for side, wall in zip(sides, outer, strict=True):
                piece, flag = _cut_triangles(piece, flag, side, bool(wall))
            pieces.append(piece)
            flags.append(flag)
        corners, flag = np.concatenate(pieces), np.concatenate(flags)

        # equal corners of neighbours become one point again, that of a whole triangle where there
        # is one: rims stay outlines
        old = np.unique(np.concatenate(near))
        both = np.concatenate([points[old], corners.reshape(-1, 3)])
        x, number = np.unique(both, axis=0, return_inverse=True)
        number = number.ravel()
        vertex_of = len(points) + np.arange(len(x))
        vertex_of[number[: len(old)]] = old
        cut = vertex_of[number[len(old) :]].reshape(-1, 3)

        # edges along walls; triangles and edges that rounding made to points are dropped
        edges = np.stack([cut, np.roll(cut, -1, axis=1)], axis=-1)[flag]
        edges = edges[edges[:, 0] != edges[:, 1]]
        cut = cut[(cut != np.roll(cut, -1, axis=1)).all(axis=1)]
        corners_kept = np.concatenate([*kept, cut])

        # points in use, in their old order
        used, rows = renumbered(np.concatenate([corners_kept.ravel(), edges.ravel()]))
        first = int(np.searchsorted(used, len(points)))
        x = np.concatenate([points[used[:first]], x[used[first:] - len(points)]])
        corners_kept, edges = (
            rows[: corners_kept.size].reshape(-1, 3),
            rows[corners_kept.size :].reshape(-1, 2),
        )
        return x, corners_kept, np.unique(np.sort(edges, axis=1), axis=0)

    @cached_property
    def _cells(self) -> OutlineCells:
        return OutlineCells(self.outline)

    def _settled_by_cells(
        self, points: np.ndarray, elements: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Rows of elements that are certainly inside, and that may be cut; others are outside.

        Each part of an area that is not convex takes a pass over all triangles: 16 parts of a real
        field took 5 s of 25 for all pictures.
        """
        if len(self.parts) == 1:
            every = np.arange(len(elements))
            return every[:0], every
        bottom, top = self.box[4:]
        level = ((points[:, 2] >= bottom).astype(np.int8) + (points[:, 2] > top))[elements]
        code = self._cells.sort(points, elements)
        low, high = level.min(axis=1), level.max(axis=1)
        inside = (code == INSIDE) & (low == 1) & (high == 1)
        outside = (code == OUTSIDE) | (high == 0) | (low == 2)
        return np.flatnonzero(inside), np.flatnonzero(~inside & ~outside)

    def segments(self, points: np.ndarray, segments: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the parts (m, 2, 3) of segments (n, 2) inside the prism, and rows of these (m,).

        A segment that passes two convex parts is drawn in two pieces.
        """
        ends: np.ndarray = points[segments]
        if self.holds(points):
            return ends, np.arange(len(segments))
        whole, near = self._settled_by_cells(points, segments)
        pieces, rows = [ends[whole]], [whole]
        low, high = ends[near].min(axis=1), ends[near].max(axis=1)
        for sides, _ in self.parts:
            row = near[_may_meet(low, high, sides)]
            piece = ends[row]
            for side in sides:
                piece, stays = _cut_segments(piece, side)
                row = row[stays]
            pieces.append(piece)
            rows.append(row)
        row = np.concatenate(rows)
        order = np.argsort(row, kind="stable")
        return np.concatenate(pieces)[order], row[order]


def clipped_lines(
    points: np.ndarray, lines: Sequence[np.ndarray], within: Prism | None
) -> list[np.ndarray]:
    """Return the segments (n, 2, 3) of each line, given by rows of points, inside a prism."""
    if not lines:
        return []
    # all at once: one by one, a thousand lines of a real field took half of a picture
    segments = np.concatenate([np.stack([of[:-1], of[1:]], axis=1) for of in lines])
    stops = np.cumsum([len(line) - 1 for line in lines])
    if within is None:
        return np.split(points[segments], stops[:-1])
    ends, rows = within.segments(points, segments)
    return np.split(ends, np.searchsorted(rows, stops[:-1]))


def convex_parts(ring: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """
    Split a simple polygon into convex ones.

    Parameters
    ----------
    ring : ndarray of float64, shape (n, 2)
        Counter-clockwise.

    Returns
    -------
    list of (ndarray of float64 (m, 2), ndarray of bool (m,))
        Corners of each part, counter-clockwise, and whether the side after each corner is one of
        the polygon's. The polygon itself if it is convex, triangles (ears) if it is not.

    Examples
    --------
    >>> arrow = np.array([[0.0, 0], [4, 0], [4, 4], [3, 1]])
    >>> [part.tolist() for part, _ in convex_parts(arrow)]
    [[[3.0, 1.0], [0.0, 0.0], [4.0, 0.0]], [[3.0, 1.0], [4.0, 0.0], [4.0, 4.0]]]
    """
    n = len(ring)
    if (_turn(np.roll(ring, 1, axis=0), ring, np.roll(ring, -1, axis=0)) >= 0).all():
        return [(ring, np.ones(n, dtype=bool))]

    # ear clipping: cut off one convex corner after the other
    # left: rows of corners that are not cut off yet
    left, parts = list(range(n)), []
    while len(left) > 2:
        k = _ear(ring[left])
        three = [left[k - 1], left[k], left[(k + 1) % len(left)]]
        if _turn(*ring[three]) > 0:
            # a side of the polygon joins neighbours; others are diagonals inside
            outer = [(b - a) % n == 1 for a, b in zip(three, np.roll(three, -1), strict=True)]
            parts.append((ring[three], np.array(outer)))
        del left[k]
    return parts


def _ear(ring: np.ndarray) -> int:
    """A corner that can be cut off: no other corner is in its triangle; else the flattest."""
    before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)

    # only where the polygon turns left, and with no other corner in the triangle
    turn = _turn(before, ring, after)
    for k in np.flatnonzero(turn > 0).tolist():
        a, b, c = before[k], ring[k], after[k]
        inside = (_turn(a, b, ring) >= 0) & (_turn(b, c, ring) >= 0) & (_turn(c, a, ring) >= 0)
        corners = (ring == a).all(axis=1) | (ring == b).all(axis=1) | (ring == c).all(axis=1)
        if not (inside & ~corners).any():
            return k
    return int(np.argmin(np.abs(turn)))


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Twice the area of triangles on the map, above 0 if counter-clockwise."""
    u, v = b - a, c - a
    made: np.ndarray = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return made


def _distances(points: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """How far inside points (..., 3) are, in units of each side (n, 4): (..., n)."""
    made: np.ndarray = points @ sides[:, :3].T + sides[:, 3]
    return made


def _may_meet(low: np.ndarray, high: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Whether boxes (n, 3) reach inside all half-spaces, bool (n,)."""
    out = np.ones(len(low), dtype=bool)
    for side in sides:
        # the corner of a box that is farthest inside decides
        farthest = np.where(side[:3] > 0, high, low)
        out &= farthest @ side[:3] + side[3] >= 0
    return out


def _sorted_out(
    points: np.ndarray, triangles: np.ndarray, sides: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Rows of triangles inside all half-spaces, and of those that some may cut."""
    inside = np.ones(len(triangles), dtype=bool)
    met = np.ones(len(triangles), dtype=bool)
    for half_spaces in np.array_split(sides, len(sides) // AT_ONCE + 1):
        # one bit for each side that has the point outside
        bits = 1 << np.arange(len(half_spaces))
        a, b, c = ((_distances(points, half_spaces) < 0) @ bits)[triangles].T
        inside &= (a | b | c) == 0
        met &= (a & b & c) == 0
    return np.flatnonzero(inside), np.flatnonzero(met & ~inside)


def _cut_triangles(
    corners: np.ndarray, flag: np.ndarray, side: np.ndarray, wall: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Clip triangles (n, 3, 3) to a half-space; flags (n, 3) mark edges along walls."""
    # three corners inside: whole; one or two: cut into one triangle or two
    d = corners @ side[:3] + side[3]
    inside = d >= 0
    count = inside.sum(axis=1)
    whole = count == 3
    pieces, flags = [corners[whole]], [flag[whole]]
    for n in (1, 2):  # turned so that the corner that is alone comes first
        rows = np.flatnonzero(count == n)
        alone = np.argmax(inside[rows] == (n == 1), axis=1)
        order = (alone[:, None] + np.arange(3)) % 3
        p, e, f = (np.take_along_axis(v[rows], order, 1) for v in (d, d, flag))
        a, b, c = np.moveaxis(np.take_along_axis(corners[rows], order[..., None], 1), 1, 0)

        # where both edges at the lone corner leave the half-space
        ab, ca = (_between(a, q, p[:, 0], e[:, k], n == 1) for q, k in ((b, 1), (c, 2)))
        cut, none = np.full(len(rows), wall), np.zeros(len(rows), dtype=bool)
        if n == 1:
            pieces.append(np.stack([a, ab, ca], 1))
            flags.append(np.stack([f[:, 0], cut, f[:, 2]], 1))
        else:
            pieces += [np.stack([ab, b, c], 1), np.stack([ab, c, ca], 1)]
            flags += [np.stack([f[:, 0], f[:, 1], none], 1), np.stack([none, f[:, 2], cut], 1)]
    return np.concatenate(pieces), np.concatenate(flags)


def _between(
    alone: np.ndarray, other: np.ndarray, d_alone: np.ndarray, d_other: np.ndarray, first: bool
) -> np.ndarray:
    """Where edges leave a half-space, always reckoned from inside: both neighbours agree."""
    p, q, dp, dq = (alone, other, d_alone, d_other) if first else (other, alone, d_other, d_alone)
    made: np.ndarray = p + (q - p) * (dp / (dp - dq))[:, None]
    return made


def _cut_segments(ends: np.ndarray, side: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Segments (n, 2, 3) inside a half-space, and which of all (m,) have a part there."""
    d = ends @ side[:3] + side[3]
    inside = d >= 0
    stays = inside.any(axis=1)
    out: np.ndarray = ends[stays].copy()
    d, inside = d[stays], inside[stays]
    for k in (0, 1):
        # one end outside: it moves to the side, reckoned from the end inside
        rows = np.flatnonzero(~inside[:, k])
        p, q = out[rows, 1 - k], out[rows, k]
        part = d[rows, 1 - k] / (d[rows, 1 - k] - d[rows, k])
        out[rows, k] = p + (q - p) * part[:, None]
    return out, stays
