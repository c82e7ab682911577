"""Where a torn sheet that was cut by its faults would end anywhere but on them.

Curves separate the triangles that stay from those that are dropped: only triangles at curves count.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.model import Patches
from geosurf.model.base import all_of, any_of
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles

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
    of = patches.surface_of_triangle[rows]
    found = []
    for surface in range(len(patches.sources)):
        mine = rows[of == surface]
        one, two, key = edges_of(patches, mine)
        both = np.flatnonzero(on_curve[one] & on_curve[two])
        both = both[np.argsort(key[both], kind="stable")]
        found.append((key[both], mine[both // 3]))
    return found


def free_edges(patches: Patches, sides: Sides) -> Rim:
    """Ends of edges of one triangle of the sheet only, and that triangle, in order of edges."""
    # the sheet is surface 0, its triangles come first
    n = int(np.searchsorted(patches.surface_of_triangle, 1))
    ring = patches.pieces.ring[: 3 * n]  # of all surfaces: alone there is alone here
    alone = np.flatnonzero(ring == np.arange(3 * n))
    row, corner = np.divmod(alone, 3)
    one, two = patches.triangles[row, corner], patches.triangles[row, (corner + 1) % 3]
    key = np.minimum(one, two) * len(patches.local) + np.maximum(one, two)
    keys, of = sides[0]  # at a curve other surfaces may be there, too
    # Keys are sorted: an edge is single if both its neighbours differ.
    new = np.ones(len(keys) + 1, dtype=bool)
    new[1:-1] = keys[1:] != keys[:-1]
    single = new[:-1] & new[1:]
    key, first = np.unique(np.concatenate([key, keys[single]]), return_index=True)
    one, two = np.divmod(key, len(patches.local))
    return one, two, np.concatenate([row, of[single]])[first]


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
    found = open_edges(t, mine, rim, keep, len(patches.local), torn, triangles)
    met = _faults_at(patches, {point for points in found.values() for point in points})
    return [(*e, frozenset().union(*(met[p] for p in points))) for e, points in found.items()]


def open_edges(
    t: np.ndarray,
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
    one, two, _ = _with_marked(rim, made)
    starts = distinct(one, two)
    starts = starts[name[starts] >= 0]
    made[starts] = True
    one, two, row = _with_marked(rim, made)

    # neighbours of each point along free edges, and whether their triangle stays
    onward: dict[int, list[tuple[int, bool]]] = {}
    for a, b, kept in zip(one.tolist(), two.tolist(), keep[row].tolist(), strict=True):
        onward.setdefault(a, []).append((b, kept))
        onward.setdefault(b, []).append((a, kept))

    # walk from each old vertex over new points to the next old one: one outer edge, in pieces
    found: dict[Pair, set[int]] = {}
    for a in starts.tolist():
        for step, kept in onward[a]:
            before, here, any_kept = a, step, kept
            passed = []

            # a point where the rim branches ends the walk: no single outer edge goes on there
            while name[here] < 0:
                ahead = [(v, k) for v, k in onward[here] if v != before]
                if len(ahead) != 1:
                    break
                passed.append(here)
                before, (here, kept) = here, ahead[0]
                any_kept |= kept
            if name[here] >= 0 and any_kept:
                edge = min(int(name[a]), int(name[here])), max(int(name[a]), int(name[here]))
                found.setdefault(edge, set()).update(passed)
    # At the rim of the data a sheet may end anywhere.
    inner = _inner([edge for edge in sorted(found) if edge[1] >= torn.n_node], torn, triangles)
    return {edge: found[edge] for edge in inner}


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
    found: dict[int, set[int]] = {vertex: set() for vertex in vertices}
    # Surface 0 is the sheet, so faults are counted from 1.
    fault = patches.surface_of_triangle[rows] - 1
    for corner, number in zip(patches.triangles[rows].tolist(), fault.tolist(), strict=True):
        for vertex in corner:
            if vertex in found:
                found[vertex].add(number)
    return found


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
