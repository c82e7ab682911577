"""Find self-contacts of surfaces with vertices of hundreds of triangles: fans and books.

The boxes of all triangles around a vertex meet there, so n of them are n * n / 2 candidates,
although those of a plain fan meet in the vertex and in common edges only. Two that have the vertex
in common meet elsewhere only if they do so in some direction as seen from it; so their pairs are
searched in boxes of directions (`geosurf.kernels.search.vertex_fans`), and so are those with all
triangles nearby. Two that share an edge meet elsewhere only if they leave it at the same angle.
Pairs that meet in what they share are left out by this: they are not contacts, and nothing is cut
there. But each triangle at a vertex is paired with another one there, so that all of them are
known where it is asked what is around that vertex.
"""

from __future__ import annotations

import numpy as np

from geosurf.arrangement import tree
from geosurf.kernels.lattices.triangle_list import survey_list
from geosurf.kernels.meshes.mesh import weld
from geosurf.kernels.search.rays import rows_in_box
from geosurf.kernels.search.vertex_fans import (
    ROOM,
    box_tree,
    direction_boxes,
    overlapping_directions,
)
from geosurf.model import TriSurface

MANY = 256  # triangles at a vertex, from which it is searched apart, and at an edge of it
_ULP = 2.0**-52
_NO_PAIRS = np.empty((0, 2), dtype=np.int64)
_NO_CORNERS = np.empty((0, 3), dtype=np.int64)


def hubs_of(surface: TriSurface) -> tuple[np.ndarray, np.ndarray]:
    """Corners of a list of triangles by places that differ, and the places that many have, those of
    most first. A lattice has none: its triangles would have no area there.
    """
    if surface.lattice is not None:
        return _NO_CORNERS, _NO_CORNERS[:, 0]

    number, count = weld(surface.vertices)
    corners = number[surface.triangles]

    # Largest hubs first: a triangle at two hubs is searched with the larger one.
    degree = np.bincount(corners.ravel(), minlength=count)
    hubs = np.flatnonzero(degree > MANY)
    return corners, hubs[np.argsort(-degree[hubs], kind="stable")]


def pairs_around_hubs(
    surface: TriSurface, corners: np.ndarray, hubs: np.ndarray
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles of one surface that may meet, and what the search cost.

    Parameters
    ----------
    surface : TriSurface
    corners, hubs : ndarray of int64
        As `hubs_of` returns them.

    Returns
    -------
    pairs, cost
        As `tree.candidate_pairs` with ``same=True``, without those that meet only in a vertex or an
        edge of many triangles, which they share.
    """
    whole = tree.tree_of(surface)
    boxes = survey_list(surface.vertices, surface.triangles)[0]
    slip = 4 * _ULP * float(np.abs(whole.bounds).max())

    # each triangle is of the first of its hubs, in the order in which they are searched
    rank = np.full(int(corners.max()) + 1, len(hubs))
    rank[hubs] = np.arange(len(hubs))
    of_hub = rank[corners].min(axis=1)
    by_hub = np.argsort(of_hub, kind="stable")
    first = np.searchsorted(of_hub[by_hub], np.arange(len(hubs) + 1))

    # Triangles at no hub are searched with a tree of their own.
    others = by_hub[first[-1] :]
    found = [_NO_PAIRS]
    cost = {"nodes": 0, "pairs": 0}
    if len(others):
        part = tree.tree_of_rows(surface, others)
        pairs, cost = tree.candidate_pairs(part, part, same=True)
        found.append(others[pairs])

    # Then the triangles at each hub, with one another and with those near them. Triangles of
    # earlier hubs have been compared with these before.
    for k, hub in enumerate(hubs.tolist()):
        mine = by_hub[first[k] : first[k + 1]]
        if len(mine):
            near = _rows_near(whole, boxes, mine)
            found += _seen_from(surface, corners, hub, mine, near[of_hub[near] > k], boxes, slip)

    pairs = np.sort(np.concatenate(found), axis=1)
    n = surface.n_triangle
    keys = np.unique(pairs[:, 0] * n + pairs[:, 1])
    pairs = np.stack(np.divmod(keys, n), axis=1)
    return pairs, {**cost, "pairs": len(pairs)}


def _rows_near(whole: tree.Tree, boxes: np.ndarray, mine: np.ndarray) -> np.ndarray:
    """Triangles whose boxes meet the box around some of them."""
    box = np.concatenate([boxes[mine, :3].min(axis=0), boxes[mine, 3:].max(axis=0)])
    rows = np.empty(2 * len(mine) + 64, dtype=np.int64)
    # One call counts, a second one fills if there was too little room.
    n = rows_in_box(whole.order, whole.nodes, whole.levels, boxes, box, rows)
    if n > len(rows):
        rows = np.empty(n, dtype=np.int64)
        rows_in_box(whole.order, whole.nodes, whole.levels, boxes, box, rows)
    return np.sort(rows[:n])


def _seen_from(
    surface: TriSurface,
    corners: np.ndarray,
    hub: int,
    mine: np.ndarray,
    near: np.ndarray,
    boxes: np.ndarray,
    slip: float,
) -> list[np.ndarray]:
    """Pairs of triangles at a hub, and of those with others nearby, that may meet."""
    x, t = surface.vertices, surface.triangles
    rows = np.concatenate([mine, near])
    at_hub = corners[mine[0]] == hub
    eye = x[t[mine[0]][at_hub][0]]
    # Boxes of the directions in which triangles are seen from the hub: only overlapping ones can
    # meet other than in the hub.
    seen = direction_boxes(x, t[rows], eye, slip)
    label = np.zeros(len(rows), dtype=np.int64)

    # Triangles at one long edge share a direction; they are labelled to be compared by angle.
    label[: len(mine)], books = _books(corners[mine], hub)
    middle = np.clip(0.5 * (seen[:, :3] + seen[:, 3:]), -1.0, 1.0)
    each = np.repeat(np.arange(len(rows)), 3).reshape(-1, 3)

    order = np.lexsort((survey_list(middle, each)[1], label))
    given = (seen, boxes[rows], label, order, *box_tree(seen, order, label))
    pairs, _ = tree.all_pairs(lambda room: (overlapping_directions(*given, room), 0))

    # Each triangle at the hub has at least one pair there, so that all of them are known.
    found = [rows[pairs], np.stack([mine[:-1], mine[1:]], axis=1)]
    for number, end in books:
        at_edge = mine[label[: len(mine)] == number]
        found.append(at_edge[_opened_alike(x, t[at_edge], corners[at_edge], (hub, end), slip)])
    return found


def _books(corners: np.ndarray, hub: int) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Labels of triangles at a hub that share an edge with many, above 0 (-1: with few); for each
    label the other end of the edge.
    """
    rims = corners[corners != hub].reshape(-1, 2)
    ends, number, count = np.unique(rims, return_inverse=True, return_counts=True)
    number = number.reshape(-1, 2)

    # Of the two edges of a triangle at the hub, the one with more triangles.
    most = count[number].argmax(axis=1)[:, None]
    number = np.take_along_axis(number, most, axis=1)[:, 0]

    large = count[number] > MANY
    used = np.unique(number[large])
    label = np.where(large, 1 + number, -1)
    return label, list(zip((1 + used).tolist(), ends[used].tolist(), strict=True))


def _opened_alike(
    x: np.ndarray, t: np.ndarray, corners: np.ndarray, edge: tuple[int, int], slip: float
) -> np.ndarray:
    """Pairs (rows of `t`) of triangles at an edge that may leave it at the same angle."""
    start, end = (x[t[0][corners[0] == one][0]] for one in edge)
    free = (corners != edge[0]) & (corners != edge[1])
    length = np.linalg.norm(end - start)
    along = (end - start) / length

    # The direction of each free corner across the edge, and its angle around the edge.
    out = x[t[free]] - start
    size = np.linalg.norm(out, axis=1)
    out = out - (out @ along)[:, None] * along
    # A second axis across the edge: the coordinate axis that is least along it.
    one = np.eye(3)[np.abs(along).argmin()]
    one = one - (one @ along) * along
    angle = np.arctan2(out @ np.cross(along, one / np.linalg.norm(one)), out @ one)

    # the edge may be off by slip, too, which turns what is far from it
    with np.errstate(divide="ignore", invalid="ignore"):
        room = (8 * slip + 1e-12 * size) * (1 + size / length) / np.linalg.norm(out, axis=1)
    room = np.where(np.isfinite(room), np.minimum(room + ROOM, 4.0), 4.0)

    # Intervals of angles, sorted by their lower ends: those that begin before one ends may meet it.
    low = np.concatenate([angle - room, angle - room + 2 * np.pi])  # once more around
    high = np.concatenate([angle + room, angle + room + 2 * np.pi])
    order = np.argsort(low, kind="stable")
    first = np.arange(len(low)) + 1
    count = np.searchsorted(low[order], high[order], side="right") - first

    # All pairs of such intervals, as rows of triangles; `% len(t)` takes off the second turn.
    one = np.repeat(order, count)
    two = order[np.arange(count.sum()) - np.repeat(np.cumsum(count) - count - first, count)]
    pairs = np.sort(np.stack([one, two], axis=1) % len(t), axis=1)
    found: np.ndarray = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    return found
