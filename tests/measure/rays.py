"""Which unit is at a point, slow and obvious: exact rays through every shell.

A point is really moved by what the rule of `sample` says, infinitely little: no ray meets an edge,
and no moved point lies in a plane.
"""

from __future__ import annotations

import numpy as np

ONE = 2**700  # coordinates are whole numbers of this fraction of a metre
TINY = [2**500, 2**300, 2**100]
SPARE = 1.0  # metres around a triangle in which it is tested, too
CLEAR = 1e-3  # [m], and [m2] for areas: doubles decide what is off by more
MOST_BINS = 512  # along each side


def unit_by_rays(units, points, shells=None):
    """Row of the unit of each point (n, 3), local; -1 outside.

    Points are moved down (or up from the floor), then towards the middle to the east or west, then
    to the north or south, each infinitely less than before.
    """
    w, e, s, n, bottom, _ = units.box
    origin = next(iter(units.values())).origin
    middle = 0.5 * (w + e) - origin[0], 0.5 * (s + n) - origin[1]
    shells = shells or Shells(units)
    found = []
    for point in points:
        east, north = (1 if point[k] <= middle[k] else -1 for k in (0, 1))
        up = 1 if point[2] == bottom - origin[2] else -1
        p = [
            whole(c) + way * move
            for c, way, move in zip(point, (east, north, up), np.roll(TINY, -1), strict=True)
        ]
        clear, doubtful = shells.near(point)
        passed = np.bincount(clear, minlength=len(units))
        for unit, face in doubtful:
            passed[unit] += above(face, p)
        inside = np.flatnonzero(passed % 2).tolist()
        assert len(inside) <= 1  # units do not overlap
        found.append(inside[0] if inside else -1)
    return found


class Shells:
    """The triangles of all units, by places on the map."""

    def __init__(self, units):
        self.corners = np.concatenate([u.local[u.triangles] for u in units.values()])
        self.unit = np.repeat(range(len(units)), [len(u.triangles) for u in units.values()])
        low, high = self.corners.min(axis=1)[:, :2] - SPARE, self.corners.max(axis=1) + SPARE
        self.box = np.concatenate([low, high], axis=1)
        self.n = min(MOST_BINS, 1 + int(np.sqrt(len(self.corners))))
        self.low = low.min(axis=0)
        self.size = np.maximum((high[:, :2].max(axis=0) - self.low) / self.n, 1e-9)

        # every triangle in all bins that its box meets
        first, last = self.bin(low), self.bin(high[:, :2])
        wide, deep = (last - first + 1).T
        row = np.repeat(np.arange(len(first)), wide * deep)
        at = np.arange(len(row)) - np.repeat(np.cumsum(wide * deep) - wide * deep, wide * deep)
        key = (first[row, 0] + at // deep[row]) * self.n + first[row, 1] + at % deep[row]
        order = np.argsort(key, kind="stable")
        self.rows, self.start = row[order], np.searchsorted(key[order], np.arange(self.n**2 + 1))

    def bin(self, places):
        """Bins of places on the map (n, 2)."""
        return np.clip(np.floor((places - self.low) / self.size), 0, self.n - 1).astype(int)

    def near(self, point):
        """Units of triangles that are above a point; unit and triangle of those in doubt.

        Doubles leave out what is off by a millimetre or more: they err by less than a thousandth of
        that.
        """
        i, j = self.bin(point[None, :2])[0]
        rows = self.rows[slice(*self.start[i * self.n + j : i * self.n + j + 2])]
        box = self.box[rows]
        rows = rows[(box[:, :2] <= point[:2]).all(axis=1) & (box[:, 2:] >= point).all(axis=1)]
        corners = self.corners[rows]
        edge = np.roll(corners, -1, axis=1) - corners
        off = point - corners
        turns = edge[..., 0] * off[..., 1] - edge[..., 1] * off[..., 0]
        left, right = turns.max(axis=1), turns.min(axis=1)
        beside = (left > CLEAR) & (right < -CLEAR)
        over = ((right > CLEAR) | (left < -CLEAR)) & (off[..., 2].max(axis=1) < -CLEAR)
        under = off[..., 2].min(axis=1) > CLEAR
        doubtful = [
            (int(self.unit[row]), [[whole(c) for c in v] for v in self.corners[row].tolist()])
            for row in rows[~(beside | over | under)]
        ]
        return self.unit[rows[over]], doubtful


def whole(c):
    """A double as a whole number: exact, but for numbers below 1e-190."""
    above, below = float(c).as_integer_ratio()
    assert ONE % below == 0
    return above * (ONE // below)


def turns_of(face, p):
    """Twice the areas on the map of p with the three edges of a triangle."""
    a, b, c = face
    return [
        (v[0] - u[0]) * (p[1] - u[1]) - (v[1] - u[1]) * (p[0] - u[0])
        for u, v in ((a, b), (b, c), (c, a))
    ]


def above(face, p):
    """Whether a triangle is straight above a point, which is on no edge and in no plane."""
    a, b, c = face
    turns = turns_of(face, p)
    if not (all(t > 0 for t in turns) or all(t < 0 for t in turns)):
        return False
    height = a[2] * turns[1] + b[2] * turns[2] + c[2] * turns[0] - p[2] * sum(turns)
    return height * sum(turns) > 0


def holds(face, p):
    """Whether a point lies on a triangle, its edges and corners among it."""
    a, b, c = face
    u, v, w = ([q[k] - a[k] for k in range(3)] for q in (b, c, p))
    normal = [u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2] for k in range(3)]
    if sum(n * d for n, d in zip(normal, w, strict=True)) != 0:
        return False

    # in the plane of two axes along which the triangle has an area
    k = max(range(3), key=lambda k: abs(normal[k]))
    flat = [[q[k - 2], q[k - 1]] for q in (*face, p)]
    turns = turns_of(flat[:3], flat[3])
    return all(t >= 0 for t in turns) or all(t <= 0 for t in turns)
