"""Where a torn sheet can meet itself: where triangles lie over one another in the map.

A torn sheet is a graph over a lattice, in several copies beside its faults. What two of its
triangles share above an edge or a corner of the map only are edges and corners of the mesh. Of
the others those are passed over that have no ghost: they are a graph, of which none meet.

Where a surface says which node of the lattice each vertex lies over (``vertex_data["node"]``),
triangles over the same three nodes are the candidates, and the order of their heights there tells
which of them cross. Drogon: 1 to 8 pairs of triangles in place of 14 000.
"""

from __future__ import annotations

import numpy as np

from geosurf.contact import tree
from geosurf.kernels.gather import number_below
from geosurf.kernels.predicates import frame_of
from geosurf.kernels.torn import over_one_another
from geosurf.model import TriSurface
from geosurf.model.base import all_of, any_of

GHOST, NODE = "ghost", "node"


def is_torn(surface: TriSurface) -> bool:
    """Whether a surface is a sheet that was carried on past its faults."""
    return GHOST in surface.vertex_data


def pairs_with_itself(surface: TriSurface, whole: tree.Tree, origin: np.ndarray):
    """Pairs of triangles of a torn sheet that may meet, and what the search cost.

    Returns
    -------
    pairs, cost
        As `tree.candidate_pairs` with ``same=True``.
    """
    if NODE in surface.vertex_data:
        rows = _crossing_over_nodes(surface, float(origin[2]))
        return rows, {"nodes": 0, "pairs": len(rows)}
    rows, cost = tree.pairs_of_some(surface, whole, _with_ghosts(surface))
    return rows[over_itself(surface, rows, origin)], cost


def over_itself(surface: TriSurface, pairs: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Which pairs of triangles of a torn sheet, one of them with a ghost, lie over one another."""
    mask: np.ndarray = any_of(_with_ghosts(surface)[pairs])
    some = np.flatnonzero(mask)
    triangles, number = number_below(pairs[some].reshape(-1), surface.n_triangle)
    corners = surface.triangles[triangles]
    nodes, corner = number_below(corners.reshape(-1), surface.n_vertex)
    x = surface.vertices[nodes] - origin
    if len(some):
        of = corner.reshape(-1, 3), number.reshape(-1, 2)
        mask[some] = over_one_another(x, *of, *frame_of(x))
    return mask


def _crossing_over_nodes(surface: TriSurface, level: float) -> np.ndarray:
    """Pairs (n, 2) of triangles over three nodes in common that cross or touch."""
    node, t = surface.vertex_data[NODE], surface.triangles
    ghosts = any_of(surface.vertex_data[GHOST][t])
    under = np.zeros(int(node.max(initial=-1)) + 1, dtype=bool)
    under[node[t[ghosts]]] = True
    rows = np.flatnonzero(all_of(under[node][t]))
    corners = node[t[rows]]
    turn = np.argsort(corners, axis=1)
    corners = np.take_along_axis(corners, turn, axis=1)
    order = np.lexsort(corners.T)
    rows, corners, turn = rows[order], corners[order], turn[order]
    # as in the frame of the search: two heights that are rounded to one are one there
    vertex = np.take_along_axis(t[rows], turn, axis=1)
    z = surface.vertices[vertex, 2] - level
    found = [np.empty((0, 2), dtype=np.int64)]
    for step in range(1, len(rows)):
        same = np.flatnonzero(all_of(corners[step:] == corners[:-step]))
        if len(same) == 0:
            break
        above, below = z[same + step] > z[same], z[same + step] < z[same]
        met = any_of(above) & any_of(below)
        met |= any_of(~above & ~below & (vertex[same + step] != vertex[same]))
        one, two = rows[same[met]], rows[same[met] + step]
        found.append(np.stack([np.minimum(one, two), np.maximum(one, two)], axis=1))
    pairs = np.concatenate(found)
    return pairs[any_of(ghosts[pairs])]


def _with_ghosts(surface: TriSurface) -> np.ndarray:
    """Which triangles have a ghost."""
    return any_of(surface.vertex_data[GHOST][surface.triangles])
