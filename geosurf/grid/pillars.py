"""Pillars: where each is at an elevation, and the way from the world into their coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ROUNDS = 40
CLOSE = 1e-9  # of a cell: rounds end here


@dataclass(frozen=True, eq=False)
class Pillars:
    """Straight pillars in coordinates of the lattice: cells along I and J, elevation in metres.

    Attributes
    ----------
    shift : ndarray of float64, shape (ny + 1, nx + 1, 2)
        From the node of the lattice, at `level` [cells].
    slope : ndarray of float64, shape (ny + 1, nx + 1, 2)
        Change per metre upwards [cells / m].
    level : float
        Elevation [m].
    """

    shift: np.ndarray
    slope: np.ndarray
    level: float

    @property
    def vertical(self) -> bool:
        """Whether all pillars are vertical, on the nodes of the lattice."""
        return not (self.shift.any() or self.slope.any())

    def at(self, z: float) -> np.ndarray:
        """Places of all pillars at an elevation, (ny + 1, nx + 1, 2)."""
        ny, nx = self.shift.shape[:2]
        node = np.stack(np.meshgrid(np.arange(nx), np.arange(ny)), axis=-1)
        return node + self.shift + self.slope * (z - self.level)

    def straighten(self, x: np.ndarray) -> np.ndarray:
        """Coordinates (n, 3) in which pillars are vertical, at whole numbers.

        Between pillars, places are bilinear at each elevation; the inverse is found by Newton's
        method. Outside the lattice and far from moved pillars nothing changes.
        """
        if self.vertical:
            return x
        out = x.copy()
        rows = np.arange(len(x))
        for _ in range(ROUNDS):
            off, jacobian = self._offset(out[rows], x[rows, 2])
            gap = out[rows, :2] + off - x[rows, :2]
            a, b, c, d = jacobian
            det = a * d - b * c
            det = np.where(np.abs(det) > 0.05, det, 1.0)
            step = np.stack([d * gap[:, 0] - b * gap[:, 1], a * gap[:, 1] - c * gap[:, 0]], 1)
            step /= det[:, None]
            out[rows, :2] -= np.clip(step, -0.5, 0.5)
            rows = rows[np.abs(gap).max(axis=1) > CLOSE]
            if not len(rows):
                break
        return out

    def _offset(self, at: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
        """Offset at places (n, 2), and the Jacobian of place plus offset."""
        ny, nx = np.array(self.shift.shape[:2]) - 1
        u, v = np.clip(at[:, 0], 0.0, nx), np.clip(at[:, 1], 0.0, ny)
        i, j = np.minimum(u.astype(np.int64), nx - 1), np.minimum(v.astype(np.int64), ny - 1)
        a, b, dz = (u - i)[:, None], (v - j)[:, None], (z - self.level)[:, None]
        p, q, r, s = (
            self.shift[j + m, i + k] + self.slope[j + m, i + k] * dz
            for m, k in ((0, 0), (0, 1), (1, 0), (1, 1))
        )
        off = (1 - a) * ((1 - b) * p + b * r) + a * ((1 - b) * q + b * s)
        du, dv = (1 - b) * (q - p) + b * (s - r), (1 - a) * (r - p) + a * (s - q)

        # beyond the rim the offset of the rim goes on
        du *= ((at[:, 0] > 0) & (at[:, 0] < nx))[:, None]
        dv *= ((at[:, 1] > 0) & (at[:, 1] < ny))[:, None]
        return off, (1.0 + du[:, 0], dv[:, 0], du[:, 1], 1.0 + dv[:, 1])


def vertical_pillars(shape: tuple[int, int], level: float) -> Pillars:
    """Return pillars on the nodes of a lattice of rows and columns."""
    zero = np.zeros((shape[0] + 1, shape[1] + 1, 2))
    return Pillars(zero, zero, level)


__all__ = ["Pillars", "vertical_pillars"]
