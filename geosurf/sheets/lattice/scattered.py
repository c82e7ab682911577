"""Scattered points and a lattice over them: the unknowns sit on the lattice, the data do not.

A point gives the height of the surface between the four nodes of its cell, by bilinear
interpolation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.conventions import place
from geosurf.errors import HorizonError
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.picks import Picks

FEWEST = 30  # points
LEAN = 1e-3  # width of the points, in their length, below which they are on one line
MOST = 1_000_000  # nodes
NEIGHBOURS = 24  # points to which a piece of parabola is fitted, to estimate their noise


@dataclass(frozen=True, eq=False)
class Scattered(Picks):
    """Points on no lattice.

    Attributes
    ----------
    uv : ndarray (n, 2)
        Column and row of each point; `node` is the nearest one.
    """

    uv: np.ndarray

    several = None  # every point is one of its own
    one_each = False
    on_nodes = False

    def columns(self, rows: np.ndarray) -> np.ndarray:
        """Column and row (n, 2) of some points."""
        return self.uv[rows]

    def missed(self, values: np.ndarray, used: np.ndarray) -> np.ndarray:
        """Points in use, bool (n_point,): all of them, by a little at least."""
        return np.flatnonzero(used)

    def misfit(self, values: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Distance [m] of some points from the sheet in their cells; NaN where one is absent."""
        nodes, share = self.corners()
        return np.abs((values[nodes[rows]] * share[rows]).sum(axis=1) - self.z[rows])

    def corners_of(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The four nodes (n, 4) of the cells of some points, and their shares (n, 4) in it."""
        nodes, share = self.corners()
        return nodes[rows], share[rows]

    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        """The four nodes (n, 4) of each point's cell, and their shares (n, 4) in it."""
        n_row, n_col = self.frame.shape

        # the last row and column belong to the cells before them
        j, i = (
            np.clip(np.floor(c).astype(np.int64), 0, n - 2)
            for c, n in zip(self.uv.T, (n_col, n_row), strict=True)
        )
        x, y = self.uv[:, 0] - j, self.uv[:, 1] - i
        a = i * n_col + j
        nodes = np.stack([a, a + 1, a + n_col, a + n_col + 1], axis=1)
        return nodes, np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=1)


def scattered(name: str, points: np.ndarray, spacing: float) -> Scattered:
    """Points (n, 3) and a lattice over them, along easting and northing, `spacing` metres wide."""
    what = f"horizon {name!r}"
    refuse_too_few(points, what)

    # multiples of the spacing: the same lattice whatever points are added inside
    low = np.floor(points[:, :2].min(axis=0) / spacing) * spacing
    last = np.ceil((points[:, :2].max(axis=0) - low) / spacing).astype(np.int64)
    n_col, n_row = (max(int(n), 3) + 1 for n in last)
    if n_col * n_row > MOST:
        raise HorizonError(
            f"{what}: a lattice of {spacing:g} m would have {n_row} x {n_col} nodes; at most "
            f"{MOST} are solved for. Give a larger spacing, such as {proposed_spacing(points):.3g}."
        )
    easting, northing = (low[k] + spacing * np.arange(n) for k, n in ((0, n_col), (1, n_row)))

    # uv (n, 2): column and row of each point, between nodes
    frame = Frame((n_row, n_col), low, spacing * np.eye(2), easting, northing)
    uv = (points[:, :2] - low) / spacing

    # the nearest node stands for a point where only its neighbourhood matters
    near = np.rint(uv).astype(np.int64)
    j, i = np.clip(near, 0, [n_col - 1, n_row - 1]).T
    return Scattered(name, frame, i * n_col + j, points[:, 2], uv)


def refuse_too_few(points: np.ndarray, what: str) -> None:
    """Raise an error if points are too few for a surface, or all on one line."""
    if len(points) < FEWEST:
        raise HorizonError(
            f"{what}: {len(points)} scattered points are too few for a surface, {FEWEST} is the "
            "least. Give more points."
        )

    # singular values: length and width of the cloud in the map
    middle = points[:, :2].mean(axis=0)
    length = np.linalg.svd(points[:, :2] - middle, compute_uv=False)
    if length[1] < LEAN * length[0]:
        ends = points[[points[:, k].argmin() for k in (0, 1)]]
        raise HorizonError(
            f"{what}: all {len(points)} points are on one line, through {place(ends[0])}. Give "
            "points on both sides of it."
        )


def proposed_spacing(points: np.ndarray) -> float:
    """Spacing [m] of a lattice with one cell for each point, where there are points."""
    from scipy.spatial import cKDTree

    # the sixth neighbour: median over all points, so that clusters and gaps do not count
    xy = np.unique(points[:, :2], axis=0)
    far = cKDTree(xy).query(xy, k=min(7, len(xy)))[0][:, -1]
    # a circle with six others in it besides its middle has the area of six cells
    return float(np.median(far) * np.sqrt(np.pi / 6.0))


def noise_of_points(picks: Scattered, used: np.ndarray) -> float:
    """Standard deviation of noise [m]: what parabolas through neighbours leave over."""
    from scipy.spatial import cKDTree

    rows = np.flatnonzero(used)
    if len(rows) < NEIGHBOURS:
        return 0.0

    # parabolas through 24 neighbours of 2000 points at most; heights relative to the point
    some = rows[:: max(len(rows) // 2000, 1)]
    near = rows[cKDTree(picks.uv[rows]).query(picks.uv[some], k=NEIGHBOURS)[1]]
    x, y = np.moveaxis(picks.uv[near] - picks.uv[some][:, None], -1, 0)
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    z = picks.z[near] - picks.z[some][:, None]

    # what the parabola leaves over, with 24 - 6 degrees of freedom
    basis = np.linalg.qr(terms)[0]
    left = z - (basis @ (np.swapaxes(basis, 1, 2) @ z[..., None]))[..., 0]
    return float(np.sqrt(np.median((left**2).sum(axis=1)) / (NEIGHBOURS - 6)))
