"""Pillars: where each is at an elevation, and the way from the world into their coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ROUNDS = 40
CLOSE = 1e-9  # of a cell: rounds end here
CORNERS = ((0, 0), (0, 1), (1, 0), (1, 1))
TURNS = ((0, 1, 2), (1, 3, 0), (2, 0, 3), (3, 2, 1))  # a corner, the next one, the last one


@dataclass(frozen=True, eq=False)
class Pillars:
    """Straight pillars in coordinates of the lattice: cells along I and J, elevation in metres.

    Attributes
    ----------
    shift : ndarray of float64, shape (ny + 1, nx + 1, 2)
        From the node of the lattice, at `level` [cells].
    slope : ndarray of float64, shape (ny + 1, nx + 1, 2)
        Change per metre upwards [cells / m].
    level : ndarray of float64, shape (ny + 1, nx + 1)
        Elevation of the middle of the grid [m].
    reach : ndarray of float64, shape (ny + 1, nx + 1)
        Height above and below `level` over which pillars must not cross [m].
    """

    shift: np.ndarray
    slope: np.ndarray
    level: np.ndarray
    reach: np.ndarray

    @property
    def vertical(self) -> bool:
        """Whether all pillars are vertical, on the nodes of the lattice."""
        return not (self.shift.any() or self.slope.any())

    def at(self, z: float) -> np.ndarray:
        """Places of all pillars at an elevation, (ny + 1, nx + 1, 2)."""
        ny, nx = self.level.shape
        node = np.stack(np.meshgrid(np.arange(nx), np.arange(ny)), axis=-1)
        return node + self.shift + self.slope * (z - self.level)[..., None]

    def places(self, node: tuple[np.ndarray, np.ndarray], z: np.ndarray) -> np.ndarray:
        """Places of the pillars of nodes, rows J and I (n,), each at an elevation, (n, 2)."""
        j, i = node
        rise = (z - self.level[node])[..., None]
        return np.stack([i, j], axis=-1) + self.shift[node] + self.slope[node] * rise

    def least_areas(self) -> tuple[np.ndarray, np.ndarray]:
        """Smallest area at each corner of each cell, and its elevation, each (4, ny, nx).

        Of the parallelogram of the two sides at a corner, in cells, within reach: not positive
        where a cell is not convex. Corners are in the order of `CORNERS`. Along straight pillars an
        area is a quadratic function of elevation.
        """
        ny, nx = self.level.shape[0] - 1, self.level.shape[1] - 1
        j, i = np.meshgrid(np.arange(ny), np.arange(nx), indexing="ij")
        nodes = [(j + m, i + k) for m, k in CORNERS]
        low = np.min([(self.level - self.reach)[node] for node in nodes], axis=0)
        high = np.max([(self.level + self.reach)[node] for node in nodes], axis=0)

        def areas(z: np.ndarray) -> np.ndarray:
            x = [self.places(node, z) for node in nodes]
            return np.stack([_turn(x, corner) for corner in TURNS])

        # a parabola through three values: its least value on the way
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        a, b, c = (areas(z) for z in (low, middle, high))
        curve, rise = a + c - 2.0 * b, c - a
        with np.errstate(invalid="ignore", divide="ignore"):
            at = -0.5 * rise / curve
            bottom = np.where((curve > 0) & (np.abs(at) < 1), b - rise * rise / (8 * curve), np.inf)
        values = np.stack([a, b, c, bottom])
        heights = np.stack([np.broadcast_to(one, a.shape) for one in (low, middle, high)])
        lowest = np.where(np.isfinite(bottom), at, 0.0)
        heights = np.concatenate([heights, (middle + half * lowest)[None]])
        first = values.argmin(axis=0)[None]
        return (
            np.take_along_axis(values, first, axis=0)[0],
            np.take_along_axis(heights, first, axis=0)[0],
        )

    def straighten(self, x: np.ndarray) -> np.ndarray:
        """Coordinates (n, 3) in which pillars are vertical, at whole numbers.

        Between pillars, places are bilinear at each elevation; the inverse is found by Newton's
        method. Beyond reach of `level` pillars count as vertical: no cell of the grid is there.
        """
        if self.vertical:
            return x
        out = x.copy()
        rows = np.arange(len(x))
        for _ in range(ROUNDS):
            off, (a, b, c, d) = self._offset(out[rows], x[rows, 2])
            gap = out[rows, :2] + off - x[rows, :2]
            det = a * d - b * c
            det = np.where(np.abs(det) > 0.05, det, 1.0)
            step = np.stack([d * gap[:, 0] - b * gap[:, 1], a * gap[:, 1] - c * gap[:, 0]], 1)
            out[rows, :2] -= np.clip(step / det[:, None], -0.5, 0.5)
            rows = rows[np.abs(gap).max(axis=1, initial=0.0) > CLOSE]
            if not len(rows):
                break
        return out

    def ends(self, feet: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where lines parallel to pillars (n, 2) are at both ends of the reach, each (n, 2)."""
        node = tuple(np.round(feet[:, ::-1]).astype(np.int64).T)
        low, high = (self.level + sign * self.reach for sign in (-1.0, 1.0))
        return feet + self._offset(feet, low[node])[0], feet + self._offset(feet, high[node])[0]

    def _offset(self, at: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
        """Offset at places (n, 2), and the Jacobian of place plus offset."""
        ny, nx = self.level.shape[0] - 1, self.level.shape[1] - 1
        u, v = np.clip(at[:, 0], 0.0, nx), np.clip(at[:, 1], 0.0, ny)
        i, j = np.minimum(u.astype(np.int64), nx - 1), np.minimum(v.astype(np.int64), ny - 1)
        a, b = (u - i)[:, None], (v - j)[:, None]
        corners = []
        for m, k in CORNERS:
            at_node = (j + m, i + k)
            most = 2.5 * self.reach[at_node]
            dz = np.clip(z - self.level[at_node], -most, most)
            corners.append(self.shift[at_node] + self.slope[at_node] * dz[:, None])
        p, q, r, s = corners
        off = (1 - a) * ((1 - b) * p + b * r) + a * ((1 - b) * q + b * s)
        du, dv = (1 - b) * (q - p) + b * (s - r), (1 - a) * (r - p) + a * (s - q)

        # beyond the rim the offset of the rim goes on
        du *= ((at[:, 0] > 0) & (at[:, 0] < nx))[:, None]
        dv *= ((at[:, 1] > 0) & (at[:, 1] < ny))[:, None]
        return off, (1.0 + du[:, 0], dv[:, 0], du[:, 1], 1.0 + dv[:, 1])


def _turn(x: list[np.ndarray], corner: tuple[int, int, int]) -> np.ndarray:
    """Area of the parallelogram at a corner, of its next and last corner counter-clockwise."""
    at, ahead, back = (x[k] for k in corner)
    u, v = ahead - at, back - at
    found: np.ndarray = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return found


def vertical_pillars(shape: tuple[int, int]) -> Pillars:
    """Return pillars on the nodes of a lattice of rows and columns."""
    zero = np.zeros((shape[0] + 1, shape[1] + 1, 2))
    return Pillars(zero, zero, zero[..., 0], zero[..., 0])
