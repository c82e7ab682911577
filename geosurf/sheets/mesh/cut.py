"""The exact cut of a torn sheet by its faults, near the faults: cut-offs, and leaks if there are
any.

Only triangles near the tears take part, all others are met by no fault; islands that no fault
joins are cut side by side. A leak is an outer edge of the ghosts, cut by a fault, of which a part
stays in the sheet, or through which real parts far from the fault and ghosts are one; or a copy
inside which a fault ends, so that they are one round it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow
from scipy.spatial import cKDTree

from geosurf.arrangement.search import find_contacts
from geosurf.conventions import frame_origin
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.model import Patches, TriSurface
from geosurf.model.base import all_of, any_of
from geosurf.rebuild import patches_from
from geosurf.rebuild.ghosts import WALL, kept_parts
from geosurf.sheets.heights.missing import parts_of
from geosurf.sheets.lattice.picks import Frame
from geosurf.sheets.lattice.solve import around
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles, outer_ghosts, renumbered

if TYPE_CHECKING:  # pragma: no cover - types only
    from scipy.spatial import cKDTree


# ---- holes ----------------------------------------
# Where exactly a torn sheet that was cut by its faults is open: its holes, by a minimum cut.
#
# One hole joins the walls of all faults around it, so that the sheet seems to leak everywhere. The
# sheet is taken as a network of triangles: neighbours are linked by the edge between them, unless a
# fault runs along it. What flows from triangles clearly on their own side to outer ghosts has to
# pass through the holes. The minimum cut (Ford & Fulkerson 1956; by Dinic's algorithm in scipy),
# with the length of each edge as its capacity, is the shortest set of edges that would close all.


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
    edges : ndarray (n, 2, 3)
        That would close it: its rim [m].
    """

    place: np.ndarray
    length: float
    ghosts: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray
    edges: np.ndarray

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
    clear: np.ndarray,
    outer: np.ndarray,
    cell: float,
) -> tuple[list[Hole], np.ndarray]:
    """Holes of the sheet that is surface 0 of the patches, and its triangles in front of them.

    Parameters
    ----------
    patches : Patches
        Of the sheet, ghosts included, and its faults.
    fault_edges : ndarray of int64
        Edges of faults, as ``low point * n_point + high point``, increasing.
    named : ndarray of int64 (n_triangle, 3)
        Vertex of `Torn` at each corner, -1 for points that were made.
    clear : ndarray of bool (n_face,)
        Triangles before the cut that are clearly on their own side of the faults.
    outer : ndarray of int64
        Outermost ghosts, as vertices of `Torn`.
    cell : float
        Size of a cell [m].
    """
    rows = np.flatnonzero(patches.surface_of_triangle == 0)
    # a ghost on a fault is at the rim of both sides, and decides nothing
    on_fault = np.zeros(len(patches.local), dtype=bool)
    on_fault[patches.triangles[patches.surface_of_triangle > 0]] = True
    corner = (named[rows] >= 0) & ~on_fault[patches.triangles[rows]]
    # a piece of a clear triangle without any of its corners may lie beyond the fault
    source = clear[patches.parent_of_triangle[rows]] & any_of(corner)
    sink = any_of(corner & is_among(named[rows], outer)) & ~source
    links = _links(patches, rows, fault_edges, source)

    # an edge costs its length: the cheapest cut is the shortest closure, whatever leaks far away
    edges = patches.local[links.ends]
    length = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    through, reached = _minimum_cut(links.pairs, length / cell, source, sink)
    # Nothing flows: the sheet is closed as far as the network tells.
    if not len(through):
        return [], rows[reached]
    edges, length = edges[through], length[through]
    middle = edges.mean(axis=1)

    # outer ghosts, and where they are
    ghost, point = named[rows[sink]].ravel(), patches.triangles[rows[sink]].ravel()
    is_outer = is_among(ghost, outer) & (ghost >= 0)
    ghosts, tree = ghost[is_outer], cKDTree(patches.local[point[is_outer], :2])
    # Edges of the minimum cut that are near each other make one hole.
    holes = [
        _hole(edges[cluster], length[cluster], ghosts, tree, patches.origin, cell)
        for cluster in _clusters(middle[:, :2] / cell)
    ]
    return holes, rows[reached]


def _links(
    patches: Patches, rows: np.ndarray, fault_edges: np.ndarray, source: np.ndarray
) -> Links:
    """Links between some triangles over edges that no fault has; not all between sources."""
    t, n = patches.triangles[rows], len(patches.local)

    # links between sources carry nothing: only edges of other triangles count, whose ends are
    # corners of these. All half-edges of such an edge are looked at, those of sources too.
    beside = np.zeros(n, dtype=bool)
    beside[t[~source]] = True
    tail, head = t.ravel(), np.roll(t, -1, axis=1).ravel()
    half = np.flatnonzero(beside[tail] & beside[head])
    tail, head = tail[half], head[half]

    # half-edges sorted by the edge that they run along: those of one edge are next to each other
    key = np.minimum(tail, head) * n + np.maximum(tail, head)
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
) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the links that part sources from sinks, the shortest in sum; rows before them."""
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
    # what the source still reaches in the residual network is on its side of the cut
    residual = csr_array(graph - flow.flow)
    residual.data = np.maximum(residual.data, 0)
    residual.eliminate_zeros()
    reached = np.zeros(n + 2, dtype=bool)
    reached[breadth_first_order(residual, n, return_predecessors=False)] = True
    return inner[reached[a] != reached[b]], np.flatnonzero(reached[node])


def _clusters(uv: np.ndarray) -> list[np.ndarray]:
    """Rows of points [cells] that are joined by steps of at most `ONE_HOLE`."""
    # Single linkage in the map: holes are lines along faults.
    pairs = cKDTree(uv).query_pairs(ONE_HOLE, output_type="ndarray")
    label = join_pairs(pairs, len(uv))
    return [np.flatnonzero(label == k) for k in distinct(label)]


def _hole(
    edges: np.ndarray,
    length: np.ndarray,
    ghosts: np.ndarray,
    tree: cKDTree,
    origin: np.ndarray,
    cell: float,
) -> Hole:
    """One hole from its edges (n, 2, 3) and their lengths, with the outer ghosts behind it.

    `tree` has the places of the outer ghosts in the map. The nearest one is behind the hole, and
    those a little farther.
    """
    middle = edges.mean(axis=1)
    reach = float(tree.query(middle[:, :2])[0].min()) + BEHIND * cell
    near = sorted({k for ks in tree.query_ball_point(middle[:, :2], reach) for k in ks})
    # Long edges count more: the middle of the hole, not of its edges.
    place = np.average(middle, axis=0, weights=length) + origin
    low, high = (middle + origin)[[middle[:, 2].argmin(), middle[:, 2].argmax()]]
    return Hole(place, float(length.sum()), distinct(ghosts[near]), low, high, edges + origin)


def holes_at(
    pairs: np.ndarray, places: Callable[[np.ndarray], np.ndarray], n_node: int, cell: float
) -> list[Hole]:
    """Holes at edges (n, 2) between vertices of `Torn`, whose `places` (n, 3) [m] are looked up."""
    # Each pair is an edge of its own.
    at = places(pairs.ravel()).reshape(-1, 2, 3)
    middle, length = at.mean(axis=1), np.linalg.norm(at[:, 1] - at[:, 0], axis=1)
    return [
        Hole(
            middle[cluster].mean(axis=0),
            float(length[cluster].sum()),
            _ghosts(pairs[cluster], n_node),
            middle[cluster][middle[cluster, 2].argmin()],
            middle[cluster][middle[cluster, 2].argmax()],
            at[cluster],
        )
        for cluster in _clusters(middle[:, :2] / cell)
    ]


def _ghosts(vertices: np.ndarray, n_node: int) -> np.ndarray:
    """The ghosts among some vertices of `Torn`, increasing."""
    return distinct(vertices[vertices >= n_node])


IsOwn = Callable[[np.ndarray], np.ndarray]  # nodes clearly on their own side of all faults


@dataclass(eq=False)
class Band:
    """The part of a torn sheet that faults can meet.

    Attributes
    ----------
    surface : TriSurface
        With ``vertex_data["ghost"]``.
    vertex : ndarray of int64 (n_vertex,)
        Vertex in the numbering of `Torn`.
    outer : ndarray of int64
        Outermost ghosts, in the numbering of `Torn`.
    is_copy : ndarray of bool (n_triangle,)
        Copies; the others are triangles of the lattice.
    """

    surface: TriSurface
    vertex: np.ndarray
    outer: np.ndarray
    is_copy: np.ndarray


@dataclass(eq=False)
class Cut:
    """What the exact cut gave.

    Attributes
    ----------
    patches : Patches
        Of the band and all faults, ghosts included.
    corners : ndarray of int64 (n, 3)
        Corners of the triangles of the band, as vertices of `Torn`.
    keep : ndarray of bool (n_triangle,)
        See `kept_parts`.
    curve_sides : list of (ndarray, ndarray)
        By surface, see `sides_at_curves`.
    leaks : list of (int, int, frozenset of int)
        Outer edges, as vertices of `Torn`, that the sheet would end on inside the data, and the
        faults that cut them.
    dead_ends : list of (int, int)
        Copies, by two vertices, inside which a fault ends.
    holes : list of Hole
        The places that leaks and dead ends come from.
    inside : ndarray of int64
        Triangles of an open sheet in front of its holes.
    """

    patches: Patches
    corners: np.ndarray
    keep: np.ndarray
    curve_sides: list[tuple[np.ndarray, np.ndarray]]
    leaks: list[Leak]
    dead_ends: list[tuple[int, int]]
    holes: list[Hole]
    inside: np.ndarray


def band_of(
    torn: Torn,
    triangles: Triangles,
    frame: Frame,
    heights: np.ndarray,
    ghosts: np.ndarray,
    reach: int,
    walls: Mapping[str, np.ndarray] | None = None,
) -> Band:
    """Copies, and the triangles within `reach` cells of them; of an untorn sheet, of its first.

    `walls` are those of nodes at faults, by name: see `geosurf.rebuild.ghosts`.
    """
    nodes = torn.node_of_ghost
    outer = outer_ghosts(torn, triangles)
    # An untorn sheet has no ghosts: its first triangle stands for it.
    near = around(nodes if len(nodes) else triangles.first() // 2, frame.shape, reach)

    # whole triangles of the lattice first, then the copies: `is_copy` follows from this order
    t, corners = triangles.of_cells(near)
    whole = np.flatnonzero(~is_among(t, torn.divided))
    faces = np.concatenate([corners.take(whole, axis=0), torn.corners])

    # `used` is increasing: nodes before ghosts
    used, faces = renumbered(faces, torn.n_node + len(ghosts))
    real = used < torn.n_node
    z = np.concatenate([heights[used[real]], ghosts[used[~real] - torn.n_node]])
    nodes = torn.node_of(used)
    surface = TriSurface(
        "sheet",
        "horizon",
        np.column_stack([frame.node_places(nodes), z]),
        faces,
        vertex_data={
            "ghost": ~real,
            "outer": is_among(used, outer),
            "node": nodes,
            **walls_of_vertices(walls, torn, used),
        },
    )
    is_copy = np.arange(len(faces)) >= len(whole)
    return Band(surface, used, outer, is_copy)


def walls_of_vertices(
    walls: Mapping[str, np.ndarray] | None, torn: Torn, vertices: np.ndarray
) -> dict[str, np.ndarray]:
    """Walls of nodes, ghosts with that of their anchor, as data of some vertices of `torn`."""
    anchors = torn.anchored(vertices)
    return {WALL + fault: of_node[anchors] for fault, of_node in (walls or {}).items()}


def cut_band(
    band: Band,
    torn: Torn,
    triangles: Triangles,
    faults: Sequence[TriSurface],
    frame: Frame,
    is_own: IsOwn,
) -> Cut:
    """Cut a band by its faults, exactly, and look for leaks.

    `is_own` gives which nodes are clearly on their own side of all faults, at their own height.
    """
    # The same exact arrangement as for a whole model, on a few thousand triangles.
    origin = frame_origin(band.surface.extent, *(fault.extent for fault in faults))
    patches = patches_from(find_contacts([band.surface, *faults], origin=origin))

    # a part that is dropped though it has triangles clearly on their own side leaks somewhere:
    # it counts as open, so that the edge through which it runs into ghosts is found
    keep, corner, part = kept_parts(patches)
    open_part = keep | _dropped_with_own(band, patches, keep, part, corner, is_own)
    corner = np.where(corner >= 0, band.vertex[corner], -1)

    # leaks: outer edges that are cut and stay in part; dead ends: copies in which a fault ends
    sides = sides_at_curves(patches)
    rim = free_edges(patches, sides)
    leaks = leaks_of(patches, rim, open_part, corner, torn, triangles)
    dead_ends = _named(band, false_rims(patches, keep, sides))
    # A part that was counted as open without being kept may run through a copy.
    if not keep[open_part].all():
        dead_ends += _named(band, ends_in_copies(patches, rim, open_part, sides))
    corners = band.vertex[band.surface.triangles]

    # the minimum cut is looked for only where something is open: most sheets are closed
    holes: list[Hole] = []
    inside = np.empty(0, dtype=np.int64)
    if leaks or dead_ends:
        edges = distinct(*(keys for keys, _ in sides[1:]))
        is_source = _clear_triangles(band, is_own)
        holes, inside = holes_of(patches, edges, corner, is_source, band.outer, frame.cell)
        # an outer edge comes back through the fault between its ends, where no hole is found
        pairs = np.array([*(leak[:2] for leak in leaks), *dead_ends])
        pairs = pairs[~_near_holes(band, pairs[:, 0], holes)]
        if len(pairs):
            holes += holes_at(pairs, _places(band), torn.n_node, frame.cell)
    leaks.sort(key=lambda leak: leak[:2])
    return Cut(patches, corners, keep, sides, leaks, dead_ends, holes, inside)


def _near_holes(band: Band, vertices: np.ndarray, holes: Sequence[Hole]) -> np.ndarray:
    """Which vertices, numbers of `Torn`, are on an island of the band that has a hole."""
    island = parts_of(band.surface)
    ghosts = np.concatenate([np.empty(0, dtype=np.int64), *(hole.ghosts for hole in holes)])
    return is_among(
        island[np.searchsorted(band.vertex, vertices)],
        distinct(island[np.searchsorted(band.vertex, ghosts)]),
    )


def _places(band: Band) -> Callable[[np.ndarray], np.ndarray]:
    """Makes the function that gives the places (n, 3) of vertices of `Torn` in a band."""
    return lambda vertex: band.surface.vertices[np.searchsorted(band.vertex, vertex)]


def _clear_triangles(band: Band, is_own: IsOwn) -> np.ndarray:
    """Triangles of the lattice in a band, bool (n,), with corners clearly on their own side.

    At a tip a copy may have real corners only, and yet reach beyond the fault.
    """
    faces = band.surface.triangles
    whole = np.flatnonzero(~band.is_copy)
    # Each node is asked once; sides cost a search in the fault.
    nodes = distinct(faces[whole])
    clear = np.zeros(band.surface.n_vertex, dtype=bool)
    clear[nodes] = is_own(band.vertex[nodes])
    out = np.zeros(len(faces), dtype=bool)
    out[whole] = all_of(clear[faces[whole]])
    return out


def _dropped_with_own(
    band: Band,
    patches: Patches,
    keep: np.ndarray,
    part: np.ndarray,
    corner: np.ndarray,
    is_own: IsOwn,
) -> np.ndarray:
    """Triangles of parts that are dropped though they have real triangles far from the faults.

    Such a part runs into ghosts somewhere. `corner` (n_triangle, 3) is -1 at points that were made.
    """
    # dropped triangles of the sheet, as the lattice triangles that they were cut from: a tip is a
    # corner of copies on both of its sides, and one of them may have real corners only
    rows = np.flatnonzero((patches.surface_of_triangle == 0) & ~keep)
    rows = rows[~band.is_copy[patches.parent_of_triangle[rows]]]
    corners = band.surface.triangles[patches.parent_of_triangle[rows]]
    nodes = distinct(corners)
    own = is_own(band.vertex[nodes])
    rows = rows[all_of(own[np.searchsorted(nodes, corners)])] if len(rows) else rows

    # a piece without any corner of its triangle may lie beyond the fault
    on_fault = np.zeros(len(patches.local), dtype=bool)
    on_fault[patches.triangles[patches.surface_of_triangle > 0]] = True
    rows = rows[any_of((corner[rows] >= 0) & ~on_fault[patches.triangles[rows]])]

    # one row more: part -1 stands for triangles of the faults
    found = np.zeros(part.max(initial=-1) + 2, dtype=bool)
    found[part[rows]] = True
    return found[part]


def _named(band: Band, faces: np.ndarray) -> list[tuple[int, int]]:
    """Triangles of a band, by two of their corners, as vertices of `Torn`."""
    # Lowest and highest vertex name a copy well enough for messages and repairs.
    corners = np.sort(band.vertex[band.surface.triangles[faces]], axis=1)
    return [(int(a), int(b)) for a, b in np.unique(corners[:, [0, 2]], axis=0)]


Leak = tuple[int, int, frozenset[int]]
Pair = tuple[int, int]
Sides = list[tuple[np.ndarray, np.ndarray]]
Rim = tuple[np.ndarray, np.ndarray, np.ndarray]


def edges_of(patches: Patches, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ends of the edges of some triangles, and a number for each edge, whichever way it runs."""
    t = patches.triangles[rows]
    one, two = t.ravel(), np.roll(t, -1, axis=1).ravel()
    return one, two, np.minimum(one, two) * len(patches.local) + np.maximum(one, two)


def sides_at_curves(patches: Patches) -> Sides:
    """By surface: numbers of edges between points of curves, rising, and the triangle of each."""
    # an edge of a curve has both its ends on curves: few triangles are left to look at
    on_curve = np.zeros(len(patches.local), dtype=bool)
    on_curve[patches.curve_edges] = True
    a, b, c = on_curve[patches.triangles].T
    rows = np.flatnonzero((a & b) | (a & c) | (b & c))
    surface_of_row = patches.surface_of_triangle[rows]
    sides = []
    for surface in range(len(patches.sources)):
        faces = rows[surface_of_row == surface]
        tail, head, key = edges_of(patches, faces)
        both = np.flatnonzero(on_curve[tail] & on_curve[head])
        both = both[np.argsort(key[both], kind="stable")]
        sides.append((key[both], faces[both // 3]))
    return sides


def free_edges(patches: Patches, sides: Sides) -> Rim:
    """Ends of edges of one triangle of the sheet only, and that triangle, in order of edges."""
    # the sheet is surface 0, its triangles come first
    n = int(np.searchsorted(patches.surface_of_triangle, 1))
    ring = patches.pieces.ring[: 3 * n]  # of all surfaces: alone there is alone here
    alone = np.flatnonzero(ring == np.arange(3 * n))
    row, corner = np.divmod(alone, 3)
    tail, head = patches.triangles[row, corner], patches.triangles[row, (corner + 1) % 3]
    key = np.minimum(tail, head) * len(patches.local) + np.maximum(tail, head)
    keys, triangle = sides[0]  # at a curve other surfaces may be there, too
    # Keys are sorted: an edge is single if both its neighbours differ.
    new = np.ones(len(keys) + 1, dtype=bool)
    new[1:-1] = keys[1:] != keys[:-1]
    single = new[:-1] & new[1:]
    key, first = np.unique(np.concatenate([key, keys[single]]), return_index=True)
    tail, head = np.divmod(key, len(patches.local))
    return tail, head, np.concatenate([row, triangle[single]])[first]


def leaks_of(
    patches: Patches,
    rim: Rim,
    keep: np.ndarray,
    corner: np.ndarray,
    torn: Torn,
    triangles: Triangles,
) -> list[Leak]:
    """Outer edges with a ghost end, cut by a fault, of which a part is in `keep`."""
    rows = np.flatnonzero(patches.surface_of_triangle == 0)
    t, mine = patches.triangles[rows], corner[rows]
    parent = patches.parent_of_triangle[rows]
    found = open_edges(t, parent, mine, rim, keep, len(patches.local), torn, triangles)
    met = _faults_at(patches, {point for points in found.values() for point in points})
    return [(*e, frozenset().union(*(met[p] for p in points))) for e, points in found.items()]


def open_edges(
    t: np.ndarray,
    parent: np.ndarray,
    corner: np.ndarray,
    rim: Rim,
    keep: np.ndarray,
    n_point: int,
    torn: Torn,
    triangles: Triangles,
) -> dict[Pair, set[int]]:
    """Outer edges with a ghost end that are cut, of which a part is in `keep`, and points on them.

    Parameters
    ----------
    t : ndarray (n, 3)
        Triangles of the cut sheet, as points 0 .. n_point - 1.
    parent : ndarray of int64 (n,)
        The triangle that each was cut from.
    corner : ndarray (n, 3)
        Vertices of `torn` at their corners, -1 for points that the cut made.
    rim : tuple
        See `free_edges`.
    keep : ndarray of bool (n,)
    """
    # name (n_point,): the vertex of the sheet before the cut, -1 for points that the cut made
    name = np.full(n_point, -1)
    name[t[corner >= 0]] = corner[corner >= 0]
    # free edges with a point that was made, then all of those that go on from their ends
    made = np.zeros(n_point, dtype=bool)
    made[t] = name[t] < 0
    tail, head, _ = _with_marked(rim, made)
    starts = distinct(tail, head)
    starts = starts[name[starts] >= 0]
    made[starts] = True
    tail, head, row = _with_marked(rim, made)

    # neighbours of each point along free edges, the triangle that these are of before the cut, and
    # whether that part of it stays
    onward: dict[int, list[tuple[int, int, bool]]] = {}
    for a, b, of, kept in np.stack([tail, head, parent[row], keep[row]], axis=1).tolist():
        onward.setdefault(a, []).append((b, of, bool(kept)))
        onward.setdefault(b, []).append((a, of, bool(kept)))

    # walk from each old vertex over new points to the next old one: one outer edge, in pieces
    points_by_edge: dict[Pair, set[int]] = {}
    for a in starts.tolist():
        for step, of, kept in onward[a]:
            before, here, any_kept = a, step, kept
            passed = []

            # two outer edges may cross in a point: each goes on in its own triangle. A point where
            # that has several ways ends the walk
            while name[here] < 0:
                ahead = [(v, k) for v, source, k in onward[here] if v != before and source == of]
                if len(ahead) != 1:
                    break
                passed.append(here)
                before, (here, kept) = here, ahead[0]
                any_kept |= kept
            if name[here] >= 0 and any_kept:
                edge = min(int(name[a]), int(name[here])), max(int(name[a]), int(name[here]))
                points_by_edge.setdefault(edge, set()).update(passed)
    # At the rim of the data a sheet may end anywhere.
    with_ghost = [edge for edge in sorted(points_by_edge) if edge[1] >= torn.n_node]
    inner = _inner(with_ghost, torn, triangles)
    return {edge: points_by_edge[edge] for edge in inner}


def _with_marked(rim: Rim, marked: np.ndarray) -> Rim:
    """Free edges with a marked end."""
    one, two, row = rim
    some = marked[one] | marked[two]
    return one[some], two[some], row[some]


def _faults_at(patches: Patches, vertices: set[int]) -> dict[int, set[int]]:
    """Numbers of the faults that have some vertices, for each of them."""
    mine = np.zeros(len(patches.local), dtype=bool)
    mine[list(vertices)] = True
    rows = np.flatnonzero(any_of(mine[patches.triangles]) & (patches.surface_of_triangle > 0))
    faults_by_vertex: dict[int, set[int]] = {vertex: set() for vertex in vertices}
    # Surface 0 is the sheet, so faults are counted from 1.
    fault = patches.surface_of_triangle[rows] - 1
    for corner, number in zip(patches.triangles[rows].tolist(), fault.tolist(), strict=True):
        for vertex in corner:
            if vertex in faults_by_vertex:
                faults_by_vertex[vertex].add(number)
    return faults_by_vertex


def ends_in_copies(patches: Patches, rim: Rim, among: np.ndarray, sides: Sides) -> np.ndarray:
    """Parents of triangles of torn copies in which a curve with a fault ends."""
    keys, row = sides[0]
    keys = distinct(keys[among[row]])
    on_fault = is_among(keys, distinct(*(k for k, _ in sides[1:])))

    # a point with one edge on a fault: there the curve ends
    degree = np.bincount(
        np.concatenate(np.divmod(keys[on_fault], len(patches.local))), minlength=len(patches.local)
    )
    ends = degree == 1
    one, two, _ = _with_marked(rim, ends)
    ends[one] = ends[two] = False  # where it leaves the sheet
    # Triangles in which a curve ends; of these only the copies, which have a ghost.
    rows = np.flatnonzero((patches.surface_of_triangle == 0) & among)
    faces = patches.parent_of_triangle[rows[any_of(ends[patches.triangles[rows]])]]
    source = patches.sources[0]
    return faces[any_of(source.vertex_data["ghost"][source.triangles[faces]])]


def false_rims(patches: Patches, keep: np.ndarray, sides: Sides) -> np.ndarray:
    """Parents of triangles that stay next to dropped ones with no fault between."""
    keys, row = sides[0]

    # triangles at each edge before and after; one that goes leaves a rim, if no fault is there
    every, inverse, before = np.unique(keys, return_inverse=True, return_counts=True)
    after = np.bincount(inverse, keep[row], len(every))
    false = (before > 1) & (after > 0) & (after != 2)
    false &= ~is_among(every, distinct(*(k for k, _ in sides[1:])))
    return distinct(patches.parent_of_triangle[row[keep[row] & false[inverse]]])


def _inner(edges: Sequence[Pair], torn: Torn, triangles: Triangles) -> list[Pair]:
    """The edges with triangles of the horizon on both sides of their link."""
    if not edges:
        return []
    # Edges as triangles with one corner twice, so that `links` names them.
    nodes = torn.node_of(np.array(edges)[:, [0, 1, 1]].ravel()).reshape(-1, 3)
    node, kind = triangles.links(nodes)
    inner = np.flatnonzero(all_of(triangles.exists(triangles.beside(node[:, 0], kind[:, 0]))))
    return [edges[k] for k in inner.tolist()]
