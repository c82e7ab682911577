"""A horizon moved by its faults: the height of each sheet anywhere, as if its wall had no end.

The sheet of a wall at a place is found from the particle that has come there: its place before is
the fixed point of "the place less the movement". Faults act from the oldest to the youngest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.sheets.frame import Frame
from geosurf.sheets.slip import Slip

ROUNDS = 200  # steps to the fixed point; each halves the rest at least, unless beds fold
CLOSE = 1e-10  # cells: how near the particle has to come

Walls = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Before:
    """The horizon before it was faulted, linear on its triangles, and on past its rim."""

    def __init__(self, name: str, values: np.ndarray, frame: Frame, rising: bool) -> None:
        self.name, self.frame = name, frame
        self.values, self.rising = values, rising
        self.to_columns = np.linalg.inv(frame.step)
        self.holes = bool(np.isnan(values).any())
        self.filled = _filled(values) if self.holes else values

    def at(self, xy: np.ndarray, filled: bool = False) -> np.ndarray:
        """Elevation (n,) at places (n, 2) from the corner; NaN in holes unless `filled`."""
        grid = self.filled if filled else self.values
        n_row, n_col = grid.shape
        x, y = (xy @ self.to_columns).T
        j = np.clip(np.floor(x), 0, n_col - 2).astype(np.int64)
        i = np.clip(np.floor(y), 0, n_row - 2).astype(np.int64)
        f, g = x - j, y - i
        a, b, d, c = grid[i, j], grid[i, j + 1], grid[i + 1, j], grid[i + 1, j + 1]
        if self.rising:  # a joins c
            first = a + f * (b - a) + g * (c - b)
            second = a + f * (c - d) + g * (d - a)
            return np.where(f >= g, first, second)
        first = a + f * (b - a) + g * (d - a)
        second = c + (1.0 - f) * (d - c) + (1.0 - g) * (b - c)
        return np.where(f + g <= 1.0, first, second)

    def outside(self, xy: np.ndarray) -> np.ndarray:
        """Distance (n,) by which places lie outside of the lattice [cells]."""
        uv = xy @ self.to_columns
        last = np.array(self.values.shape[::-1]) - 1.0
        out: np.ndarray = np.maximum(np.maximum(-uv, uv - last), 0.0).max(axis=1)
        return out


def _filled(values: np.ndarray) -> np.ndarray:
    """Holes take the nearest value, so that a particle may be sought across them."""
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(
        np.isnan(values), return_distances=False, return_indices=True
    )
    out: np.ndarray = values[tuple(nearest)]
    return out


def sheet_heights(
    before: Before, slips: Sequence[Slip], xy: np.ndarray, walls: np.ndarray | Walls, cell: float
) -> tuple[np.ndarray, np.ndarray]:
    """
    Elevations of the moved horizon at places, and where its particles were.

    Parameters
    ----------
    before : Before
    slips : sequence of Slip
        Youngest first.
    xy : ndarray (n, 2)
        From the corner of the frame [m].
    walls : ndarray (n_slip, n) or callable
        See `Slip.move`; or a function of places and elevations.
    cell : float
        [m]

    Returns
    -------
    elevation : ndarray (n,)
        NaN where the particle is in a hole of the horizon.
    was : ndarray (n, 2)

    Raises
    ------
    GeometryError
        If the movement changes so quickly that beds would fold over: names the place.
    """
    was, z = xy.copy(), before.at(xy, filled=True)
    todo = np.arange(len(xy))
    close = CLOSE * cell + 4.0 * np.finfo(np.float64).eps * np.abs(xy).max(initial=0.0)
    for _ in range(ROUNDS):
        there = walls(xy[todo], z[todo]) if callable(walls) else walls[:, todo]
        old = z[todo]
        now, z[todo] = was[todo], before.at(was[todo], filled=True)
        height = z[todo]
        for slip, wall in zip(reversed(slips), reversed(list(there)), strict=True):
            now, height = slip.move(now, height, wall)
        miss = xy[todo] - now
        z[todo] = height
        far = np.abs(miss).max(axis=1)
        if callable(walls):
            far = np.maximum(far, np.abs(height - old))
        left = far > close
        was[todo] += np.where(left[:, None], miss, 0.0)
        todo = todo[left]
        if len(todo) == 0:
            break
    if len(todo):
        where = np.append(xy[todo[0]] + before.frame.corner, z[todo[0]])
        raise GeometryError(
            f"horizon {before.name!r}: throw changes so quickly at {place(where)} that beds would "
            "fold over each other. Let it change over a longer distance, or lower it.",
            place=where,
        )
    if before.holes:
        z[np.isnan(before.at(was))] = np.nan
    return z, was
