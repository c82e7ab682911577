"""Find self-contacts of torn sheets: where triangles overlap on the map.

A torn sheet is a graph over a lattice, in several copies next to its faults. Two of its triangles
that are neighbours in the map have nothing but corners and edges of the mesh in common,
and those without a ghost are a graph, of which none meet. What is left to be asked lies over
one another, or has edges over one edge of the map.

Where a surface states which node of the lattice each vertex lies over (``vertex_data["node"]``),
the order of heights there shows which edges cross. Drogon: 10 to 40 pairs of triangles in place
of 14 000.
"""

from __future__ import annotations

import numpy as np

from geosurf.arrangement import tree
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.numbering import number_below
from geosurf.kernels.sheets.sheet_corners import are_over_nodes, edges_over_ghosts, overlap_in_map
from geosurf.model import TriSurface
from geosurf.model.base import any_of

GHOST, NODE = "ghost", "node"


def is_torn(surface: TriSurface) -> bool:
    """Whether a surface is a sheet that was continued beyond its faults."""
    return GHOST in surface.vertex_data


def pairs_with_itself(surface: TriSurface, origin: np.ndarray) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles of a torn sheet that may meet, and what the search cost.

    Returns
    -------
    pairs, cost
        As `tree.candidate_pairs` with ``same=True``.
    """
    if NODE in surface.vertex_data and _are_over_nodes(surface):
        rows = _crossing_over_nodes(surface, float(origin[2]))
        return rows, {"nodes": 0, "pairs": len(rows)}
    whole = tree.tree_of(surface)
    rows, cost = tree.pairs_of_some(surface, whole, _with_ghosts(surface))
    return rows[over_itself(surface, rows, origin)], cost


def _are_over_nodes(surface: TriSurface) -> bool:
    """Whether all vertices over one node are at one place in the map: repairs may move some."""
    if surface.torn is not None and surface.torn.node_of_ghost is not None:
        return True  # ghosts are where their nodes are
    node = surface.vertex_data[NODE]
    return bool(are_over_nodes(node, surface.vertices, int(node.max(initial=-1)) + 1))


def over_itself(surface: TriSurface, pairs: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Which pairs of triangles of a torn sheet, one of them with a ghost, lie over one another."""
    mask: np.ndarray = any_of(_with_ghosts(surface)[pairs])
    some = np.flatnonzero(mask)
    # Only vertices of these triangles are put into the exact frame.
    triangles, number = number_below(pairs[some].reshape(-1), surface.n_triangle)
    corners = surface.triangles[triangles]
    nodes, corner = number_below(corners.reshape(-1), surface.n_vertex)

    x = surface.vertices[nodes] - origin
    if len(some):
        of = corner.reshape(-1, 3), number.reshape(-1, 2)
        mask[some] = overlap_in_map(x, *of, *frame_of(x))
    return mask


def _crossing_over_nodes(surface: TriSurface, level: float) -> np.ndarray:
    """Pairs (n, 2) of triangles with edges over two nodes in common that cross or touch there.

    Triangles over three nodes in common that cross have such edges. So have those on both sides
    of the edge: one of them may be where the other sheet ends.
    """
    node, ghost = surface.vertex_data[NODE], surface.vertex_data[GHOST]
    n = int(node.max(initial=-1)) + 1
    if surface.torn is None:
        z = surface.vertices[:, 2]
        rows, one, two = edges_over_ghosts(surface.triangles, node, ghost, n)
    else:  # ghosts are of triangles at faults: only those next to these are looked at
        z, some = surface.torn.heights_of_vertices(), surface.torn.rows_beside_copies
        rows, one, two = edges_over_ghosts(surface.corners_of_keys(some), node, ghost, n)
        rows = some[rows]

    # Half-edges over the same two nodes follow one another in `order`.
    key = node[one] * n + node[two]
    order = np.argsort(key, kind="stable")
    key, rows, one, two = key[order], rows[order], one[order], two[order]

    # as in the frame of the search: two heights that are rounded to one are one there
    z = z - level

    # Compare each half-edge with the next ones over the same nodes, one step further each time.
    found = [np.empty((0, 2), dtype=np.int64)]
    for step in range(1, len(key)):
        a = np.flatnonzero(key[step:] == key[:-step])
        if len(a) == 0:
            break
        b = a + step
        # They cross where one is higher at the first node and lower at the second, and touch where
        # heights are equal in different vertices.
        first, second = np.sign(z[one[b]] - z[one[a]]), np.sign(z[two[b]] - z[two[a]])
        met = first * second < 0
        met |= ((first == 0) & (one[a] != one[b])) | ((second == 0) & (two[a] != two[b]))
        met = np.flatnonzero(met)
        if len(met):
            pairs = np.stack([rows[a[met]], rows[b[met]]], axis=1)
            found.append(np.sort(pairs, axis=1))

    pairs = np.concatenate(found)
    if not len(pairs):
        return pairs
    pairs = np.unique(pairs, axis=0)
    corners = surface.corners_of_keys(pairs.ravel())
    return pairs[any_of(ghost[corners].reshape(-1, 6))]


def _with_ghosts(surface: TriSurface) -> np.ndarray:
    """Which triangles have a ghost."""
    return any_of(surface.vertex_data[GHOST][surface.triangles])
