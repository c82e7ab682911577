"""Where exactly a torn sheet that was cut by its faults is open: its holes, by a minimum cut.

One hole joins the walls of all faults around it, so that the sheet seems to leak everywhere. The
sheet is taken as a network of triangles: neighbours are linked by the edge between them, unless a
fault runs along it. What flows from triangles clearly on their own side to outer ghosts has to
pass through the holes. The minimum cut (Ford & Fulkerson 1956; by Dinic's algorithm in scipy),
with the length of each edge as its capacity, is the shortest set of edges that would close all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.model import Patches
from geosurf.model.base import any_of

if TYPE_CHECKING:  # pragma: no cover - types only
    from scipy.spatial import cKDTree

WHOLE = 1000  # capacities are whole numbers: thousandths of a cell
ONE_HOLE = 3.0  # cells within which edges of the minimum cut belong to one hole
SAME_PLACE, SAME_SIZE = 1.0, 0.1  # cells, and share of its length, by which a hole may differ
BEHIND = 1.5  # cells farther than the nearest outer ghost, up to which ghosts belong to a hole


@dataclass(frozen=True, eq=False)
class Hole:
    """One place where a sheet is open.

    Attributes
    ----------
    place : ndarray (3,)
        Its middle: easting, northing, elevation [m].
    length : float
        Of the edges that would close it [m].
    ghosts : ndarray of int64
        Outer ghosts behind it, as vertices of `Torn`.
    lowest, highest : ndarray (3,)
        Of the middles of its edges [m].
    """

    place: np.ndarray
    length: float
    ghosts: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray

    def is_like(self, before: Hole, cell: float) -> bool:
        """Whether it is a hole of an earlier attempt, at about the same place and as long."""
        far = np.linalg.norm(self.place - before.place) / cell
        differs = abs(self.length - before.length) / max(self.length, cell)
        return bool(far <= SAME_PLACE and differs <= SAME_SIZE)


@dataclass(frozen=True, eq=False)
class Links:
    """Pairs of triangles of a sheet with an edge between them that no fault has.

    Attributes
    ----------
    pairs : ndarray of int64 (n, 2)
        Rows of the triangles.
    ends : ndarray of int64 (n, 2)
        Points of the edge.
    """

    pairs: np.ndarray
    ends: np.ndarray


def holes_of(
    patches: Patches,
    fault_edges: np.ndarray,
    named: np.ndarray,
    own: np.ndarray,
    outer: np.ndarray,
    cell: float,
) -> list[Hole]:
    """Holes of the sheet that is surface 0 of the patches.

    Parameters
    ----------
    patches : Patches
        Of the sheet, ghosts included, and its faults.
    fault_edges : ndarray of int64
        Edges of faults, as ``low point * n_point + high point``, increasing.
    named : ndarray of int64 (n_triangle, 3)
        Vertex of `Torn` at each corner, -1 for points that were made.
    own : ndarray of bool (n_face,)
        Triangles before the cut that are clearly on their own side of the faults.
    outer : ndarray of int64
        Outermost ghosts, as vertices of `Torn`.
    cell : float
        Size of a cell [m].
    """
    from scipy.spatial import cKDTree

    rows = np.flatnonzero(patches.surface_of_triangle == 0)
    # a ghost on a fault is at the rim of both sides, and decides nothing
    on_fault = np.zeros(len(patches.local), dtype=bool)
    on_fault[patches.triangles[patches.surface_of_triangle > 0]] = True
    corner = (named[rows] >= 0) & ~on_fault[patches.triangles[rows]]
    # a piece of a clear triangle without any of its corners may lie beyond the fault
    source = own[patches.parent_of_triangle[rows]] & any_of(corner)
    sink = any_of(corner & is_among(named[rows], outer)) & ~source
    links = _links(patches, rows, fault_edges, source)

    # an edge costs its length: the cheapest cut is the shortest closure, whatever leaks far away
    length = np.linalg.norm(
        patches.local[links.ends[:, 1]] - patches.local[links.ends[:, 0]], axis=1
    )
    through = _minimum_cut(links.pairs, length / cell, source, sink)
    # Nothing flows: the sheet is closed as far as the network tells.
    if not len(through):
        return []
    middle = patches.local[links.ends[through]].mean(axis=1)

    # outer ghosts, and where they are
    ghost, point = named[rows[sink]].ravel(), patches.triangles[rows[sink]].ravel()
    is_outer = is_among(ghost, outer) & (ghost >= 0)
    ghosts, tree = ghost[is_outer], cKDTree(patches.local[point[is_outer], :2])
    # Edges of the minimum cut that are near each other make one hole.
    return [
        _hole(middle[mine], length[through[mine]], ghosts, tree, patches.origin, cell)
        for mine in _clusters(middle[:, :2] / cell)
    ]


def _links(
    patches: Patches, rows: np.ndarray, fault_edges: np.ndarray, source: np.ndarray
) -> Links:
    """Links between some triangles over edges that no fault has; not all between sources."""
    t, n = patches.triangles[rows], len(patches.local)

    # links between sources carry nothing: only edges of other triangles count, whose ends are
    # corners of these. All half-edges of such an edge are looked at, those of sources too.
    beside = np.zeros(n, dtype=bool)
    beside[t[~source]] = True
    one, two = t.ravel(), np.roll(t, -1, axis=1).ravel()
    half = np.flatnonzero(beside[one] & beside[two])
    one, two = one[half], two[half]

    # half-edges sorted by the edge that they run along: those of one edge are next to each other
    key = np.minimum(one, two) * n + np.maximum(one, two)
    parent = patches.parent_of_triangle[rows][half // 3]
    order = np.lexsort((parent, key))
    key, parent, order = key[order], parent[order], half[order]
    first = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]])[: len(key)])
    times = np.diff(np.append(first, len(key)))
    times = np.repeat(times, times)
    same = (key[1:] == key[:-1]) & ~is_among(key[1:], fault_edges)
    # where the sheet crosses itself, each of the two goes on through the other
    same &= (times[1:] == 2) | (parent[1:] == parent[:-1])
    pair = np.flatnonzero(same)
    ends = np.stack(np.divmod(key[pair], n), axis=1)
    return Links(np.stack([order[pair], order[pair + 1]], axis=1) // 3, ends)


def _minimum_cut(
    pairs: np.ndarray, length: np.ndarray, source: np.ndarray, sink: np.ndarray
) -> np.ndarray:
    """Rows of the links that part sources from sinks, the shortest in sum."""
    from scipy.sparse import coo_array, csr_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    # all sources are one node, and all sinks another one
    n = len(source)
    node = np.where(source, n, np.where(sink, n + 1, np.arange(n)))
    a, b = node[pairs].T
    # Links inside the source or inside the sink carry nothing.
    inner = np.flatnonzero(a != b)
    a, b = a[inner], b[inner]

    # `maximum_flow` takes whole numbers only; one more, so that no edge is free to cut
    capacity = np.ceil(length[inner] * WHOLE).astype(np.int32) + 1
    both = np.concatenate([a, b]), np.concatenate([b, a])
    graph = csr_array(coo_array((np.tile(capacity, 2), both), shape=(n + 2, n + 2)))
    # scipy 1.13 takes 32 bits for the places, too
    graph.data, graph.indices, graph.indptr = (
        part.astype(np.int32) for part in (graph.data, graph.indices, graph.indptr)
    )
    flow = maximum_flow(graph, n, n + 1)
    if flow.flow_value == 0:
        return np.empty(0, dtype=np.int64)

    # what the source still reaches in the residual network is on its side of the cut
    residual = csr_array(graph - flow.flow)
    residual.data = np.maximum(residual.data, 0)
    residual.eliminate_zeros()
    reached = np.zeros(n + 2, dtype=bool)
    reached[breadth_first_order(residual, n, return_predecessors=False)] = True
    return inner[reached[a] != reached[b]]


def _clusters(uv: np.ndarray) -> list[np.ndarray]:
    """Rows of points [cells] that are joined by steps of at most `ONE_HOLE`."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    # Single linkage in the map: holes are lines along faults.
    pairs = cKDTree(uv).query_pairs(ONE_HOLE, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(uv), len(uv)))
    count, label = connected_components(links, directed=False)
    return [np.flatnonzero(label == k) for k in range(count)]


def _hole(
    middle: np.ndarray,
    length: np.ndarray,
    ghosts: np.ndarray,
    tree: cKDTree,
    origin: np.ndarray,
    cell: float,
) -> Hole:
    """One hole from the middles and lengths of its edges, with the outer ghosts behind it.

    `tree` has the places of the outer ghosts in the map. The nearest one is behind the hole, and
    those a little farther.
    """
    reach = float(tree.query(middle[:, :2])[0].min()) + BEHIND * cell
    near = sorted({k for ks in tree.query_ball_point(middle[:, :2], reach) for k in ks})
    # Long edges count more: the middle of the hole, not of its edges.
    place = np.average(middle, axis=0, weights=length) + origin
    return Hole(place, float(length.sum()), distinct(ghosts[near]), *(_ends(middle) + origin))


def holes_at(
    pairs: Sequence[tuple[int, int]],
    places: Callable[[np.ndarray], np.ndarray],
    n_node: int,
    cell: float,
) -> list[Hole]:
    """Holes at edges between vertices of `Torn`, whose `places` (n, 3) [m] are looked up."""
    # Each pair is an edge of its own.
    ends = np.array(pairs)
    at = places(ends.ravel()).reshape(-1, 2, 3)
    middle, length = at.mean(axis=1), np.linalg.norm(at[:, 1] - at[:, 0], axis=1)
    return [
        Hole(
            middle[mine].mean(axis=0),
            float(length[mine].sum()),
            _ghosts(ends[mine], n_node),
            *_ends(middle[mine]),
        )
        for mine in _clusters(middle[:, :2] / cell)
    ]


def _ends(points: np.ndarray) -> np.ndarray:
    """The lowest and the highest of some points (n, 3)."""
    found: np.ndarray = points[[points[:, 2].argmin(), points[:, 2].argmax()]]
    return found


def _ghosts(vertices: np.ndarray, n_node: int) -> np.ndarray:
    """The ghosts among some vertices of `Torn`, increasing."""
    return distinct(vertices[vertices >= n_node])
