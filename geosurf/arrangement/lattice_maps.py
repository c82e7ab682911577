"""Torn sheets over one lattice: a few heights show which of their triangles cannot meet.

All triangles of a torn sheet, the copies next to its faults too, lie over triangles of its lattice
(``vertex_data["node"]``). Two of them over different ones share at most a corner or an edge of the
map, so that the heights at its nodes decide: where one sheet is higher at all three nodes of a
triangle, nothing over it meets, neither inside nor on its rim.

The places of nodes are checked, not believed. In columns and rows of a fitted lattice, each lies
within `OFF` of its own node. So the map of triangles from the lattice to the places is the identity
and a part whose gradient is below 1, and different triangles do not overlap.

A sheet that is a `TornLattice` has its nodes by number, and nothing has to be fitted or listed:
its lattice does not fold, and its ghosts lie over nodes to the last digit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.arrangement import tree
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.model import TriSurface
from geosurf.model.base import all_of, any_of
from geosurf.model.torn_lattice import TornLattice

GHOST, NODE = "ghost", "node"
OFF = 0.1  # columns and rows: 0.35 would do, see above
FITTED = 4000  # vertices that the lattice is fitted to
_KEPT = "_lattice_map"
_HEIGHTS = "_heights_over_nodes"


@dataclass(frozen=True, eq=False)
class LatticeMap:
    """What a torn sheet lies over.

    Attributes
    ----------
    n_col : int
        Of the lattice.
    rising : bool
        Whether its diagonals rise to the north-east.
    places : ndarray (n, 2)
        Easting and northing of its nodes; NaN without vertex, inf where vertices differ.
    low, high : ndarray (n,)
        Elevation of the lowest and the highest vertex over each node; inf and -inf without.
    height : float
        In the map, of the flattest triangle at least [m].
    """

    n_col: int
    rising: bool
    places: np.ndarray
    low: np.ndarray
    high: np.ndarray
    height: float


def lattice_map(surface: TriSurface) -> LatticeMap | None:
    """What a torn sheet lies over, remembered on it; None if its vertices do not show it."""
    if _KEPT not in surface.__dict__:
        surface.__dict__[_KEPT] = _found(surface) if NODE in surface.vertex_data else None
    found: LatticeMap | None = surface.__dict__[_KEPT]
    return found


def _found(surface: TriSurface) -> LatticeMap | None:
    node, xy = surface.vertex_data[NODE], surface.vertices[:, :2]
    if not len(node) or node.min() < 0 or not surface.n_triangle:
        return None

    # where vertices over one node are at several places, some were moved: inf is no node's place
    places = np.full((int(node.max()) + 1, 2), np.nan)
    places[node] = xy
    places[node[~all_of(places[node] == xy)]] = np.inf
    corners = np.sort(node[surface.triangles], axis=1)
    least, most = corners[:, 0], corners[:, 2]
    widest = int((most - least).max())
    # the last corner is a row on, and with rising diagonals one column more
    for n_col, rising in ((widest - 1, True), (widest, False)):
        if n_col > 1 and _are_cells(corners, n_col, rising):
            height = _height(node, xy, n_col)
            if height > 0.0:
                low, high = np.full(len(places), np.inf), np.full(len(places), -np.inf)
                np.minimum.at(low, node, surface.vertices[:, 2])
                np.maximum.at(high, node, surface.vertices[:, 2])
                return LatticeMap(n_col, rising, places, low, high, height)
    return None


def _are_cells(corners: np.ndarray, n_col: int, rising: bool) -> bool:
    """Whether triangles, nodes (n, 3) in order, are those of cells of a lattice."""
    a, b, c = corners.T
    # the first of two triangles of a cell has its two lower nodes, the second its two upper ones
    first = (b == a + 1) & (c == a + n_col + rising)
    second = (c == b + 1) & (b == a + n_col - (not rising))
    # no cell lies between two rows: its lower left node is in a column but the last
    left = np.where(first | rising, a, a - 1) % n_col
    return bool(((first | second) & (left < n_col - 1)).all())


def _height(node: np.ndarray, xy: np.ndarray, n_col: int) -> float:
    """Height in the map of any triangle at least [m]; 0 where nodes are off their places."""
    row, col = np.divmod(node, n_col)
    ideal = np.column_stack([np.ones(len(node)), col, row])
    some = np.linspace(0, len(node) - 1, min(len(node), FITTED)).astype(np.int64)
    origin = xy[0]
    fit, _, rank, _ = np.linalg.lstsq(ideal[some], xy[some] - origin, rcond=None)
    if rank < 3:
        return 0.0
    step = fit[1:]
    if abs(np.linalg.det(step)) == 0.0:
        return 0.0
    off = np.linalg.solve(step.T, (xy - origin - fit[0]).T).T - ideal[:, 1:]
    if not np.abs(off).max() <= OFF:
        return 0.0
    # a triangle of the lattice is 0.7 high, and corners are off by OFF in both ways each
    return float(np.linalg.svd(step, compute_uv=False)[-1]) * (0.7 - 4.0 * OFF)


def without_ghosts(surface: TriSurface) -> np.ndarray:
    """Triangles (n,), bool, that lie side by side on the map: one over each of its lattice's.

    None of them where that is not seen.
    """
    none = np.zeros(surface.n_triangle, dtype=bool)
    if lattice_map(surface) is None:
        return none
    ghost, node = surface.vertex_data[GHOST], surface.vertex_data[NODE]
    if np.bincount(node[~ghost], minlength=1).max() > 1:  # nodes with two vertices
        return none
    return ~any_of(ghost[surface.triangles])


def pairs_over_lattice(
    surfaces: tuple[TriSurface, TriSurface], origin: np.ndarray
) -> tuple[np.ndarray, dict[str, int]] | None:
    """Pairs of triangles of two sheets that may meet, and what the search cost.

    None if both do not lie over one lattice.
    """
    if not all(NODE in surface.vertex_data for surface in surfaces):
        return None
    torn = _pairs_over_nodes(surfaces, origin)
    if torn is not None:
        return torn
    one, two = (lattice_map(surface) for surface in surfaces)
    if one is None or two is None or (one.n_col, one.rising) != (two.n_col, two.rising):
        return None
    n = min(len(one.places), len(two.places))
    # around nodes at two places triangles overlap as they like, but all of these have such a node
    there, here = one.places[:n], two.places[:n]
    known = (there == here) | np.isnan(there) | np.isnan(here)
    moved = ~all_of(known & ~np.isinf(there) & ~np.isinf(here))

    # rounded as in the search: two heights that are one there touch
    low = [over.low[:n] - origin[2] for over in (one, two)]
    high = [over.high[:n] - origin[2] for over in (one, two)]
    above, below = (low[0] > high[1]) & ~moved, (high[0] < low[1]) & ~moved
    rows = [_may_meet(surface, above, below) for surface in surfaces]
    if not (len(rows[0]) and len(rows[1])):
        return np.empty((0, 2), dtype=np.int64), {"nodes": 0, "pairs": 0}
    trees = [tree.tree_of_rows(*part) for part in zip(surfaces, rows, strict=True)]
    pairs, cost = tree.candidate_pairs(*trees)
    return np.stack([rows[k][pairs[:, k]] for k in (0, 1)], axis=1), cost


def _may_meet(surface: TriSurface, above: np.ndarray, below: np.ndarray) -> np.ndarray:
    """Rows of triangles over whose nodes not always the same sheet is the higher one.

    Nodes from `len(above)` on have one sheet only.
    """
    node = surface.vertex_data[NODE]
    n = len(above)
    known = node < n
    at = np.where(known, node, 0)
    corners = surface.triangles
    # over a node of one sheet only nothing meets
    higher, lower = (np.where(known, side[at], True) for side in (above, below))
    return np.flatnonzero(~all_of(higher[corners]) & ~all_of(lower[corners]))


# ---- torn lattices -------------------------------------------------------------------------


def _pairs_over_nodes(
    surfaces: tuple[TriSurface, TriSurface], origin: np.ndarray
) -> tuple[np.ndarray, dict[str, int]] | None:
    """`pairs_over_lattice` of two torn lattices with the same nodes in the map; None of others."""
    one, two = (surface.torn for surface in surfaces)
    if one is None or two is None or not _are_alike(one, two):
        return None
    heights = [_heights_over_nodes(surface) for surface in surfaces]
    low, high = ([of[k] - origin[2] for of in heights] for k in (0, 1))
    # bit 0: the first sheet is above the second one over a node; bit 1: it is below
    sides = (low[0] > high[1]).astype(np.uint8) | ((high[0] < low[1]).astype(np.uint8) << 1)
    # around nodes at two places triangles overlap as they like, but all of these have such a node
    sides[_at_two_places(one, two)] = 0
    parts = [_rows_that_may_meet(of, sides) for of in (one, two)]
    if not all(len(rows) for rows, _, _ in parts):
        return np.empty((0, 2), dtype=np.int64), {"nodes": 0, "pairs": 0}
    pairs, cost = tree.candidate_pairs(*(tree.tree_of_list(x, t) for _, x, t in parts))
    return np.stack([parts[k][0][pairs[:, k]] for k in (0, 1)], axis=1), cost


def _are_alike(one: TornLattice, two: TornLattice) -> bool:
    """Whether two torn lattices have equal cells, maps that do not fold, and ghosts on nodes."""
    if (one.shape, one.rising) != (two.shape, two.rising):
        return False
    return all(of.node_of_ghost is not None and of.nodes_lie_apart for of in (one, two))


def _at_two_places(one: TornLattice, two: TornLattice) -> np.ndarray:
    """Nodes (n,), bool, that two lattices have at different places in the map."""
    if one.easting is two.easting and one.northing is two.northing:
        return np.zeros(one.n_node, dtype=bool)
    (x, y), (u, v) = one.horizontal(), two.horizontal()
    found: np.ndarray = ((x != u) | (y != v)).ravel()
    return found


def _heights_over_nodes(surface: TriSurface) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest elevation of a torn lattice over each node (n,), remembered on it.

    Over absent nodes inf and -inf.
    """
    if _HEIGHTS not in surface.__dict__:
        torn = surface.torn
        assert torn is not None  # the caller has asked
        below = torn.node_of_ghost
        assert below is not None  # as well
        z = torn.elevation.ravel()
        low, high = np.where(np.isnan(z), np.inf, z), np.where(np.isnan(z), -np.inf, z)
        np.minimum.at(low, below, torn.ghosts[:, 2])
        np.maximum.at(high, below, torn.ghosts[:, 2])
        surface.__dict__[_HEIGHTS] = low, high
    found: tuple[np.ndarray, np.ndarray] = surface.__dict__[_HEIGHTS]
    return found


def _rows_that_may_meet(
    torn: TornLattice, sides: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows of triangles over whose nodes not always the same sheet is the higher one, by `sides`.

    With their places (n, 3), and their corners among these.
    """
    grid = sides.reshape(torn.shape)
    south, north = (grid[:-1, :-1], grid[:-1, 1:]), (grid[1:, :-1], grid[1:, 1:])
    across = south[0] & north[1] if torn.rising else south[1] & north[0]
    both = (south[1], north[0]) if torn.rising else (south[0], north[1])
    halves = np.stack([across & corner for corner in both], axis=2)
    keys = np.flatnonzero(halves.ravel() == 0)
    keys = keys[~is_among(keys, torn.gone)]
    corners = torn.corners_of_keys(keys)
    if not torn.nodes_are_all_there:
        there = all_of(torn.present.ravel()[corners])
        keys, corners = keys[there], corners[there]

    # over the nodes of the lattice, then of ghosts
    every = np.concatenate([sides, sides[torn.node_of_ghost]])
    a, b, c = every[torn.copies].T
    copies = np.flatnonzero((a & b & c) == 0)
    corners = np.concatenate([corners, torn.copies[copies]])
    nodes = distinct(corners)
    rows = np.concatenate([torn.rows_of_keys(keys), torn.n_whole + copies])
    return rows, torn.places_of_nodes(nodes), np.searchsorted(nodes, corners)
