"""Find the pairs of triangles that may meet, as keys, for each pair of surfaces."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.arrangement.threads import TooManyPairs, map_threads, refusal
from geosurf.arrangement.tree_pairs import ROOM, apart, candidate_pairs, needed, pairs_of_two
from geosurf.arrangement.trees import AnyTree, tree_of, tree_of_list
from geosurf.arrangement.voxels import pairs_by_voxels
from geosurf.kernels.search.tree import triangle_boxes
from geosurf.kernels.sheets.torn_links import are_over_nodes, edges_over_ghosts
from geosurf.model import TriSurface
from geosurf.model.base import any_of

# ---- known pairs ----------------------------------------
# Contacts of two surfaces, stored for the next search of the same two.
#
# A search decides each candidate pair of triangles alone: how two triangles meet depends on their
# coordinates and the origin. So what one search found of two surfaces holds for every other
# search of both, whatever other surfaces there are. Which contacts rounding could change is
# judged by the largest coordinate of all candidates; with another one, the pairs are decided
# again.


MOST = 1 << 20  # candidates of two surfaces; more are searched again


@dataclass(frozen=True)
class Known:
    """The candidates of two surfaces, and how they meet.

    Attributes
    ----------
    rows : ndarray of int64, shape (n, 2)
        Keys of both surfaces.
    cost : dict of str to int
        Of the search.
    slip : float
        By how much coordinates could move by rounding [m].
    codes : ndarray of int64, shape (n,)
        How each pair meets: see `geosurf.kernels.contacts.triangle_contact.settled`.
    """

    rows: np.ndarray
    cost: dict[str, int]
    slip: float
    codes: np.ndarray


@dataclass(frozen=True)
class Candidates:
    """Pairs of triangles of two surfaces that may meet.

    Attributes
    ----------
    i, j : int
        The surfaces.
    rows : ndarray of int64, shape (n, 2)
        Keys of both.
    cost : dict of str to int
        Of their search.
    known : Known or None
        What an earlier search has stored: these rows, and how they met.
    """

    i: int
    j: int
    rows: np.ndarray
    cost: dict[str, int]
    known: Known | None = None


@dataclass(frozen=True)
class KnownPairs:
    """Where pairs are stored, by the rows of their surfaces.

    Attributes
    ----------
    get : callable
        Key -> what was stored, or None.
    put : callable
        Key and what is to be stored -> None.
    keys : list of hashable
        One of each surface, which stands for its triangles.
    """

    get: Callable[[Hashable], Any]
    put: Callable[[Hashable, Any], None]
    keys: list[Hashable]

    def among(
        self, pairs: Sequence[tuple[int, int]], *options: Hashable
    ) -> dict[tuple[int, int], Known]:
        """What is known of some pairs of surfaces: those that have been searched."""
        stored = {(i, j): self.get(self._key(i, j, options)) for i, j in pairs}
        return {pair: known for pair, known in stored.items() if known is not None}

    def add(
        self, candidates: Sequence[Candidates], codes: np.ndarray, slip: float, *options: Hashable
    ) -> None:
        """Store how candidates meet, in their order, unless it is known or too much."""
        start = 0
        for pair in candidates:
            stop = start + len(pair.rows)
            is_new = pair.known is None or pair.known.slip != slip
            if is_new and len(pair.rows) <= MOST:
                known = Known(pair.rows, pair.cost, slip, codes[start:stop].copy())
                self.put(self._key(pair.i, pair.j, options), known)
            start = stop

    def _key(self, i: int, j: int, options: tuple[Hashable, ...]) -> Hashable:
        """Under which two surfaces are stored."""
        return ("pair", self.keys[i], self.keys[j], *options)


# ---- candidates ----------------------------------------


def find_candidates(
    surfaces: Sequence[TriSurface],
    pairs: Sequence[tuple[int, int]],
    voxels: bool,
    voxel_size: float | None,
    origin: np.ndarray,
    known: Mapping[tuple[int, int], Known],
) -> tuple[list[Candidates], dict[str, int]]:
    """Candidates of each pair of surfaces whose boxes meet, and what all of them cost.

    What `known` has is not searched.
    """
    # a graph has one elevation for each place in the map: it cannot meet itself
    wanted = [(i, j) for i, j in pairs if i != j or not _is_graph(surfaces[i])]
    total = {"voxels": 0, "nodes": 0, "candidate_faces": 0, "pairs_tested": 0}
    if voxels:
        boxes = [triangle_boxes(surface.vertices, surface.triangles) for surface in surfaces]
    else:
        trees = [tree_of(surface) for surface in surfaces]
        far = apart(trees)
        near = [(i, j) for i, j in wanted if (i, j) in known or i == j or not far[i, j]]
        total["nodes"] += len(wanted) - len(near)
        wanted = near

    def candidates_of(i: int, j: int) -> Candidates:
        """What is known of two surfaces, or what a search finds."""
        stored = known.get((i, j))
        if stored is not None:
            return Candidates(i, j, stored.rows, stored.cost, stored)
        try:
            if voxels:
                return Candidates(
                    i, j, *_pairs_by_voxels(surfaces, boxes, voxel_size, origin, i, j)
                )
            return Candidates(i, j, *_pairs_by_trees(surfaces, trees, origin, i, j))
        except TooManyPairs as error:
            raise refusal(error.n, [surfaces[i].name, surfaces[j].name]) from error

    # Results come in the order of the pairs, whatever thread has them first.
    candidates = map_threads(candidates_of, wanted)
    for one in candidates:
        for key, value in one.cost.items():
            total["pairs_tested" if key == "pairs" else key] += value
    return candidates, total


def _pairs_by_trees(
    surfaces: Sequence[TriSurface], trees: Sequence[AnyTree], origin: np.ndarray, i: int, j: int
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of keys of two surfaces, or of one with itself, and what they cost."""
    if i != j:
        lattices = surfaces[i].lattice, surfaces[j].lattice
        return pairs_of_two(lattices, (trees[i], trees[j]), origin)
    # a torn sheet has its own search: neighbours by the thousand are near one another
    if is_torn(surfaces[i]):
        return pairs_with_itself(surfaces[i], origin)
    return candidate_pairs(trees[i], trees[i], same=True)


def _pairs_by_voxels(
    surfaces: Sequence[TriSurface],
    boxes: Sequence[np.ndarray],
    voxel_size: float | None,
    origin: np.ndarray,
    i: int,
    j: int,
) -> tuple[np.ndarray, dict[str, int]]:
    """The same, with voxels."""
    rows, cost = pairs_by_voxels(boxes[i], boxes[j], size=voxel_size, same=i == j)
    keys = [_keys_of_rows(surfaces[s], rows[:, k]) for k, s in enumerate((i, j))]
    pairs = np.stack(keys, axis=1)
    first, second = surfaces[i].lattice, surfaces[j].lattice
    if i == j and is_torn(surfaces[i]):  # as `pairs_with_itself`
        has_ghost = _with_ghosts(surfaces[i])
        pairs = pairs[has_ghost[pairs[:, 0]] | has_ghost[pairs[:, 1]]]
    if i != j and first is not None and second is not None and first.shares_map(second):
        pairs = pairs[needed(first, second, pairs)]
    return pairs, cost


def _is_graph(surface: TriSurface) -> bool:
    return surface.lattice is not None and surface.lattice.is_graph


def _keys_of_rows(surface: TriSurface, rows: np.ndarray) -> np.ndarray:
    return rows if surface.lattice is None else surface.lattice.keys_of_rows(rows)


# ---- torn sheets ----------------------------------------
# Where a torn sheet may meet itself.
#
# A torn sheet is a graph over a lattice, in several copies next to its faults. Triangles without a
# ghost are a graph, of which none meet. Where a surface states which node of the lattice each
# vertex lies over (``vertex_data["node"]``), the order of heights there shows which edges cross.
# Drogon: 10 to 40 pairs of triangles in place of 14 000.


_NEIGHBOURS = 48  # of a triangle in its own surface, seldom more
GHOST, NODE = "ghost", "node"


def is_torn(surface: TriSurface) -> bool:
    """Whether a surface is a sheet that was continued beyond its faults."""
    return GHOST in surface.vertex_data


def pairs_with_itself(surface: TriSurface, origin: np.ndarray) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles of a torn sheet that may meet, and what the search cost.

    Returns
    -------
    pairs, cost
        As `candidate_pairs` with ``same=True``, for one triangle with a ghost at least.
    """
    if NODE in surface.vertex_data and _are_over_nodes(surface):
        pairs = _crossing_over_nodes(surface, float(origin[2]))
        return pairs, {"nodes": 0, "pairs": len(pairs)}
    has_ghost = _with_ghosts(surface)
    marked = np.flatnonzero(has_ghost)
    if len(marked) == 0:
        return np.empty((0, 2), dtype=np.int64), {"nodes": 0, "pairs": 0}
    part = tree_of_list(surface.vertices, surface.triangles[marked])
    room = max(ROOM, _NEIGHBOURS * len(marked))
    pairs, cost = candidate_pairs(part, tree_of(surface), room=room)

    # Rows of the part become rows of the sheet; a pair of two marked triangles is found twice.
    first, second = marked[pairs[:, 0]], pairs[:, 1]
    once = (first < second) | ((first > second) & ~has_ghost[second])
    first, second = first[once], second[once]
    pairs = np.stack([np.minimum(first, second), np.maximum(first, second)], axis=1)
    return pairs, {**cost, "pairs": len(pairs)}


def _are_over_nodes(surface: TriSurface) -> bool:
    """Whether all vertices over one node are at one place in the map: repairs may move some."""
    if surface.torn is not None and surface.torn.node_of_ghost is not None:
        return True  # ghosts are where their nodes are
    node = surface.vertex_data[NODE]
    return bool(are_over_nodes(node, surface.vertices, int(node.max(initial=-1)) + 1))


def _crossing_over_nodes(surface: TriSurface, level: float) -> np.ndarray:
    """Pairs (n, 2) of triangles with edges over two nodes in common that cross or touch there.

    Triangles over three nodes in common that cross have such edges. So have those on both sides
    of the edge: one of them may be where the other sheet ends.
    """
    node, ghost = surface.vertex_data[NODE], surface.vertex_data[GHOST]
    n_node = int(node.max(initial=-1)) + 1
    if surface.torn is None:
        z = surface.vertices[:, 2]
        rows, lower, upper = edges_over_ghosts(surface.triangles, node, ghost, n_node)
    else:  # ghosts are of triangles at faults: only those next to these are looked at
        z, beside = surface.torn.heights_of_vertices(), surface.torn.rows_beside_copies
        corners = surface.corners_of_keys(beside)
        rows, lower, upper = edges_over_ghosts(corners, node, ghost, n_node)
        rows = beside[rows]

    # Half-edges over the same two nodes, the one with the lower number first, follow one another.
    key = node[lower] * n_node + node[upper]
    order = np.argsort(key, kind="stable")
    key, rows, lower, upper = key[order], rows[order], lower[order], upper[order]

    # as in the frame of the search: two heights that are rounded to one are one there
    z = z - level

    # Compare each half-edge with the next ones over the same nodes, one step further each time.
    crossing = [np.empty((0, 2), dtype=np.int64)]
    for step in range(1, len(key)):
        a = np.flatnonzero(key[step:] == key[:-step])
        if len(a) == 0:
            break
        b = a + step
        # They cross where one is higher at the first node and lower at the second, and touch where
        # heights are equal in different vertices.
        at_lower, at_upper = (np.sign(z[v[b]] - z[v[a]]) for v in (lower, upper))
        meet = at_lower * at_upper < 0
        meet |= (at_lower == 0) & (lower[a] != lower[b])
        meet |= (at_upper == 0) & (upper[a] != upper[b])
        crossing.append(np.sort(np.stack([rows[a[meet]], rows[b[meet]]], axis=1), axis=1))

    pairs = np.concatenate(crossing)
    if not len(pairs):
        return pairs
    pairs = np.unique(pairs, axis=0)
    corners = surface.corners_of_keys(pairs.ravel())
    return pairs[any_of(ghost[corners].reshape(-1, 6))]


def _with_ghosts(surface: TriSurface) -> np.ndarray:
    """Which triangles have a ghost."""
    return any_of(surface.vertex_data[GHOST][surface.triangles])
