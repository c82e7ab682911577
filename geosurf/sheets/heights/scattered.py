"""Points that sit on no lattice: the unknowns do, and each point is a row of the equations.

A point says what the sheet is between the four nodes of its cell, by bilinear interpolation, if
no link of the cell is cut: then all four are on one wall. The sheet is the one with the smallest
third differences that meets all points as well as their noise lets it, after Briggs (1974),
Geophysics 39, 39-48; it is solved for on the whole lattice, since no node is known. Shapes of
tips are taken out of it as `geosurf.sheets.heights.tip_residual` does on grids.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import is_number, place
from geosurf.errors import HorizonError, InputError
from geosurf.kernels.sheets.column_products import products_of_columns, sums_of_columns
from geosurf.kernels.sheets.smooth_surface import normal_equations
from geosurf.sheets.faults.cut_edges import Cuts
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.tips import Tips, tips_of
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.heights.heights import FILL, FIRST_TRIM, Heights, Rebuild, Settings
from geosurf.sheets.heights.relief import common_relief
from geosurf.sheets.heights.tip_residual import (
    Bent,
    groups_of,
    likely_shares,
    paying_shares,
    shapes_of,
)
from geosurf.sheets.heights.tip_solve import Solved, losing, shared_unless
from geosurf.sheets.lattice.data import Picks, are_points, find_lattice, picks_of, points_of
from geosurf.sheets.lattice.drape import narrow_gaps, without_absent
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.noise import signal_of, weight_of
from geosurf.sheets.lattice.solve import (
    BEND,
    Common,
    Graph,
    grounded,
    lattice_graph,
    steps_to_known,
    weights_of,
)

FEWEST = 30  # points
LEAN = 1e-3  # width of the points, in their length, below which they are on one line
MOST = 1_000_000  # nodes
NEIGHBOURS = 24  # points to which a piece of parabola is fitted, to see their noise
EXACT = 1.0  # weight of points without noise: bilinear cells cannot meet them better
# SuperLU in the order of a symmetric matrix: pivots off the diagonal would fill it seven times over
CHOLESKY = {
    "permc_spec": "MMD_AT_PLUS_A",
    "diag_pivot_thresh": 0.0,
    "options": {"SymmetricMode": True},
}
SMOOTH = 5e-3  # weight by which points are smoothed to see the surface below their noise


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
        j, i = (
            np.clip(np.floor(c).astype(np.int64), 0, n - 2)
            for c, n in zip(self.uv.T, (n_col, n_row), strict=True)
        )
        x, y = self.uv[:, 0] - j, self.uv[:, 1] - i
        a = i * n_col + j
        nodes = np.stack([a, a + 1, a + n_col, a + n_col + 1], axis=1)
        return nodes, np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=1)


def picks_or_points(
    data: Any,
    name: str | None,
    positive: str | None,
    length_unit: str | None,
    spacing: float | None,
) -> Picks:
    """Picks on a lattice, or scattered points: those that are on none, or if a spacing is given."""
    if spacing is not None and not (is_number(spacing) and spacing > 0):
        raise InputError(f"spacing is {spacing!r}, expected metres above 0.")
    if not are_points(data):
        if spacing is not None:
            raise InputError(
                f"spacing is {spacing:g} m, but the data are a grid, which has its own. "
                "Leave it out."
            )
        return picks_of(data, name, positive, length_unit)
    title, points = points_of(data, name, positive, length_unit)
    if spacing is None:
        found = find_lattice(points[:, :2], f"horizon {title!r}")
        if found is not None:
            return Picks(title, *found, points[:, 2])
        refuse_what_is_no_surface(points, f"horizon {title!r}")
    return scattered(title, points, spacing or proposed_spacing(points))


def scattered(name: str, points: np.ndarray, spacing: float) -> Scattered:
    """Points (n, 3) and a lattice over them, along easting and northing, `spacing` metres wide."""
    what = f"horizon {name!r}"
    refuse_what_is_no_surface(points, what)
    low = np.floor(points[:, :2].min(axis=0) / spacing) * spacing
    last = np.ceil((points[:, :2].max(axis=0) - low) / spacing).astype(np.int64)
    n_col, n_row = (max(int(n), 3) + 1 for n in last)
    if n_col * n_row > MOST:
        raise HorizonError(
            f"{what}: a lattice of {spacing:g} m would have {n_row} x {n_col} nodes; at most "
            f"{MOST} are solved for. Give a larger spacing, such as {proposed_spacing(points):.3g}."
        )
    easting, northing = (low[k] + spacing * np.arange(n) for k, n in ((0, n_col), (1, n_row)))
    frame = Frame((n_row, n_col), low, spacing * np.eye(2), easting, northing)
    uv = (points[:, :2] - low) / spacing
    near = np.rint(uv).astype(np.int64)
    j, i = np.clip(near, 0, [n_col - 1, n_row - 1]).T
    return Scattered(name, frame, i * n_col + j, points[:, 2], uv)


def refuse_what_is_no_surface(points: np.ndarray, what: str) -> None:
    """Say that points are too few, or all on one line."""
    if len(points) < FEWEST:
        raise HorizonError(
            f"{what}: {len(points)} scattered points are too few for a surface, {FEWEST} is the "
            "least. Give more points."
        )
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

    xy = np.unique(points[:, :2], axis=0)
    far = cKDTree(xy).query(xy, k=min(7, len(xy)))[0][:, -1]
    # a circle with six others in it besides its middle has the area of six cells
    return float(np.median(far) * np.sqrt(np.pi / 6.0))


class ScatteredRebuild(Rebuild):
    """The passes of `Rebuild` over points that sit on no lattice."""

    picks: Scattered

    def __init__(self, picks: Scattered, meshes, settings) -> None:
        self.corners, self.share = picks.corners()
        super().__init__(picks, meshes, settings)
        used = np.zeros(picks.n_node, dtype=bool)
        used[self.corners] = True
        grid = used.reshape(self.shape)
        self.present = (grid | narrow_gaps(grid, FILL)).ravel()
        self.fillable = np.empty(0, dtype=np.int64)
        if self.settings.first_trim <= FIRST_TRIM:
            self.settings.first_trim = self.settings.trim

    def noise(self) -> tuple[float, float]:
        """Noise of the points, and typical third difference of the surface per cell [m]."""
        doubted = np.zeros(len(self.picks.z), dtype=bool)
        for near in self.nearby:
            doubted[near.rows] = True
        noise = _noise_of_points(self.picks, ~doubted)
        if weight_of(noise, 0.0, self.picks.frame.cell) is None:
            return noise, 0.0
        self.settings.noise_weight = SMOOTH  # what is left of the surface then is no noise
        grid = np.where(self._touched(~doubted), self._drape(doubted, BEND), np.nan)
        return noise, signal_of(grid.reshape(self.shape))

    def _touched(self, used: np.ndarray) -> np.ndarray:
        touched = np.zeros(self.picks.n_node, dtype=bool)
        touched[self.corners[used]] = True
        return touched

    def _drape(self, doubted: np.ndarray, bend: float = 1.0) -> np.ndarray:
        """Heights (n_node,) of the surface through trusted points, not torn anywhere."""
        graph, nodes = self._graph(None)
        rows = ~doubted & (nodes[self.corners] >= 0).all(axis=1)
        found, _ = self._solved(graph, nodes, np.flatnonzero(rows), bend)
        out = np.full(self.picks.n_node, np.nan)
        out[nodes >= 0] = found
        return out

    def _network(self, doubted: np.ndarray) -> Network:
        drape = self._drape(doubted)
        filled = np.flatnonzero(~self._touched(~doubted))
        return Network(self.meshes, drape.reshape(self.shape), self.picks.frame, filled)

    def _graph(self, bits: np.ndarray | None) -> tuple[Graph, np.ndarray]:
        """Graph of all nodes that there are, and the row (n_node,) of each in it."""
        nodes = np.flatnonzero(self.present)
        slot = np.full(len(self.present), -1)
        slot[nodes] = np.arange(len(nodes))
        graph = lattice_graph(nodes, self.shape, bits)
        return without_absent(graph, np.ones(len(nodes), dtype=bool)), slot

    def _solve(self, doubted, sure, network, near, cuts: Cuts, beyond, carried=()) -> Heights:
        graph, slot = self._graph(cuts.bits(self.picks.n_node))
        rows = np.flatnonzero(~doubted & self._whole(cuts))
        touched = np.zeros(len(graph.east), dtype=bool)
        touched[slot[self.corners[rows]]] = True
        far = ~touched
        tied = touched.copy()
        tied[far] = grounded(graph, np.where(far, np.cumsum(far) - 1, -1))
        nodes = np.flatnonzero(self.present)
        stray = nodes[~tied]
        if len(stray):
            bridge = self._bridge(stray, cuts, near, network)
            if bridge is not None:
                cuts, note = bridge
                found = (*carried, note)
                return self._solve(doubted, sure, network, near, cuts, beyond, found)
        values = np.full(self.picks.n_node, np.nan)
        keep = np.where(tied, np.cumsum(tied) - 1, -1)
        used = _rows_of(graph, tied, keep)
        slot[nodes] = keep
        values[nodes[tied]], bent = self._shared(used, slot, rows, network, near, cuts)
        steps = steps_to_known(graph, np.where(far, 0, -1))[far]
        hidden = np.ones(len(doubted), dtype=bool)
        hidden[rows] = False
        return Heights(
            values, network, cuts, near, [], nodes[far], ~hidden, hidden, beyond, stray,
            steps.astype(np.float64), list(carried), bent=bent,
        )  # fmt: skip

    def _whole(self, cuts: Cuts) -> np.ndarray:
        """Points whose cell no cut link divides, bool (n,)."""
        bits = cuts.bits(self.picks.n_node)
        a, b, d = self.corners[:, 0], self.corners[:, 1], self.corners[:, 2]
        return (bits[a] == 0) & (bits[b] & 2 == 0) & (bits[d] & 1 == 0)

    def _shared(self, graph: Graph, slot, rows, network, near, cuts: Cuts) -> Solved:
        """Heights of all nodes, under noise with what walls have in common."""
        if self.throws is None:
            return self._solved(graph, slot, rows)
        tips = tips_of(network.traces, near, cuts)

        def solve(common: Common | None) -> Solved:
            """Heights of all nodes."""
            return self._solved(graph, slot, rows, tips=tips, common=common)

        if self.settings.noise_weight is None:
            return solve(None)
        nodes, at, share = np.flatnonzero(slot >= 0), slot[self.corners[rows]], self.share[rows]
        scale, z = self.settings.scale, self.picks.z[rows]
        weights = weights_of(self.stretch, BEND, scale=scale)

        def common_of() -> Common | None:
            """What walls have in common that are not apart."""
            return common_relief(nodes, cuts, network, near, self.shape, weights, self.apart)

        def against(found: np.ndarray, alone: np.ndarray) -> set[int]:
            """Traces beside which points are missed by too much."""
            missed, before = (((h[at] * share).sum(axis=1) - z) ** 2 for h in (found, alone))
            beside = self.picks.node[rows]
            return losing(near, beside, (missed - before) / self.settings.noise**2, scale)

        return shared_unless(against, solve, common_of, self.apart, self.apart_known)

    def _solved(
        self,
        graph: Graph,
        slot,
        rows,
        bend: float = BEND,
        tips: Sequence[Tips] = (),
        common: Common | None = None,
    ) -> Solved:
        """Heights of all nodes of a graph, smooth but at tips, and near the points of `rows`."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        n = len(graph.east)
        weights = weights_of(self.stretch, bend, scale=self.settings.scale)
        energy = energy_of(graph, np.arange(n), weights)
        more = 0
        if common is not None:
            more = common.n_coefficient
            energy.resize((n + more, n + more))
            energy = csc_array(energy + common.matrix.T @ common.matrix)
        weight = self.settings.noise_weight or EXACT
        each = np.repeat(np.arange(len(rows)), 4), slot[self.corners[rows]].ravel()
        points = csc_array((self.share[rows].ravel(), each), shape=(len(rows), n + more))
        level = float(self.picks.z[rows].mean())
        z = self.picks.z[rows] - level
        whole = csc_array(energy + weight * (points.T @ points))
        factor = splu(whole, **CHOLESKY)
        found: np.ndarray = factor.solve(weight * (points.T @ z))
        if self.throws is None or not tips:
            return found[:n] + level, None
        frame, nodes = self.picks.frame, np.flatnonzero(slot >= 0)
        shapes = shapes_of(tips, frame, nodes)
        shapes = np.concatenate([shapes, np.zeros((more, shapes.shape[1]))])
        drawn = energy @ shapes
        moved = factor.solve(drawn)
        likely, doubt = likely_shares(tips, self.throws), self.settings.doubt
        cost = found * (energy @ found) + weight * (points.T @ (z - points @ found) ** 2)
        groups = groups_of(tips, frame, nodes)
        units = [doubt or cost[around].mean() for _, around in groups]
        own = products_of_columns(shapes, drawn) - products_of_columns(drawn, moved)
        wanted = products_of_columns(drawn, found[:, None])[:, 0]
        towards = [tip.throw_towards() for tip in tips]
        columns = [some for some, _ in groups]
        share = paying_shares(own, wanted, columns, likely, doubt, units, towards)
        found = found + sums_of_columns(moved, share)
        return found[:n] + level, Bent(list(tips), share) if share.any() else None


def energy_of(graph: Graph, unknown: np.ndarray, weights: np.ndarray):
    """Sparse matrix (n_unknown, n_unknown) of the energy; `unknown` as for `smoothest`."""
    from scipy.sparse import csc_array

    matrix, column = normal_equations(
        graph.east, graph.north, graph.square, graph.cell, unknown, weights
    )
    kept = column >= 0
    where = np.repeat(np.arange(len(column)), kept.sum(axis=1)), column[kept]
    return csc_array((matrix[kept], where), shape=(len(column), len(column)))


def _rows_of(graph: Graph, keep: np.ndarray, number: np.ndarray) -> Graph:
    """The part of a graph whose nodes are kept; `number` is their new one, -1 elsewhere."""
    east, north = (np.where(to >= 0, number[to], -1)[keep] for to in (graph.east, graph.north))
    return Graph(east, north, graph.square[keep], graph.cell[keep])


def _noise_of_points(picks: Scattered, used: np.ndarray) -> float:
    """Standard deviation of noise [m]: what parabolas through neighbours leave over."""
    from scipy.spatial import cKDTree

    rows = np.flatnonzero(used)
    if len(rows) < NEIGHBOURS:
        return 0.0
    some = rows[:: max(len(rows) // 2000, 1)]
    near = rows[cKDTree(picks.uv[rows]).query(picks.uv[some], k=NEIGHBOURS)[1]]
    x, y = np.moveaxis(picks.uv[near] - picks.uv[some][:, None], -1, 0)
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    z = picks.z[near] - picks.z[some][:, None]
    basis = np.linalg.qr(terms)[0]
    left = z - (basis @ (np.swapaxes(basis, 1, 2) @ z[..., None]))[..., 0]
    return float(np.sqrt(np.median((left**2).sum(axis=1)) / (NEIGHBOURS - 6)))


def rebuild_of(picks: Picks, meshes: list[FaultMesh], settings: Settings) -> Rebuild:
    """The passes that fit the data."""
    kind = ScatteredRebuild if isinstance(picks, Scattered) else Rebuild
    return kind(picks, meshes, settings)
