"""The sealed model as GOCAD keeps it: parts of surfaces (TFACE), cut open along lines.

A part is a connected piece of one surface with one unit in front of it and one behind it. A line
is where other faces meet a part, or where it ends. Vertices on lines are doubled, so that each part
has vertices of its own and all lines are on its border; a reader joins them by their coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.model import Units


@dataclass(frozen=True, eq=False)
class Parts:
    """Parts of the surfaces of a model, in the order of surfaces.

    Attributes
    ----------
    vertices : ndarray of float64, shape (n_vertex, 3)
        World coordinates [m], part by part.
    triangles : ndarray of int64, shape (n_triangle, 3)
        Rows of `vertices`, part by part.
    first_vertex, first_triangle : ndarray of int64, shape (n_part + 1,)
    surface : ndarray of int64, shape (n_part,)
        Row of the surface among the sources of the model.
    sides : ndarray of int64, shape (n_part, 2)
        Unit in front of and behind each; -1 is outside. Equal where a fault ends inside a unit.
    borders : ndarray of int64, shape (n, 2)
        A vertex where a line begins, and the next vertex of that line.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    first_vertex: np.ndarray
    first_triangle: np.ndarray
    surface: np.ndarray
    sides: np.ndarray
    borders: np.ndarray


def parts_of(units: Units) -> Parts:
    """
    Divide the boundaries of all units, and faults that end inside units, into parts.

    Parameters
    ----------
    units : Units

    Raises
    ------
    InputError
        If the units were made without patches.
    """
    pieces, sides = units.piece_sides
    full = pieces.expanded
    runs = np.repeat(np.arange(len(pieces.sources)), np.diff(pieces.first_run))
    surface = np.concatenate([pieces.surface, runs])

    # a horizon with one unit on both sides is no boundary: the column has taken it away there
    is_fault = np.array([source.role == "fault" for source in pieces.sources], dtype=bool)
    inside = (sides[:, 0] >= 0) & (sides[:, 1] >= 0)
    chosen = (sides[:, 0] != sides[:, 1]) | (inside & is_fault[surface])

    # elements of one patch with the same units on both sides are connected
    labels = np.column_stack([surface, sides, pieces.patch])
    found, of_chosen = np.unique(labels[chosen], axis=0, return_inverse=True)
    label_of_element = np.full(len(labels), -1)
    label_of_element[chosen] = of_chosen.ravel()

    label = label_of_element[full.element]
    rows = np.flatnonzero(label >= 0)
    faces, label = full.triangles[rows], label[rows]

    # patches that a line parts are one part where nothing else meets that line
    _, group = np.unique(found[:, :3], axis=0, return_inverse=True)
    partner = _partners(faces, group.ravel()[label], len(full.local))
    part_of_label = _joined_labels(label, partner, len(found))
    part = part_of_label[label]
    first = np.unique(part_of_label, return_index=True)[1]

    return _in_order(
        full.local, pieces.origin, faces, part, partner, found[first, 0], found[first, 1:3]
    )


def _partners(faces: np.ndarray, group: np.ndarray, n_point: int) -> np.ndarray:
    """Other half-edge of each edge inside a part, -1 on lines, int64 (3 * n_face,).

    Half-edge ``3 * t + k`` leads from corner k of face t to its next corner.
    """
    n = faces.size
    tail, head = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    key = np.minimum(tail, head) * n_point + np.maximum(tail, head)
    bits = n.bit_length()
    if n_point**2 < 2 ** (63 - bits):
        # key and half-edge in one number: sorting numbers is faster than sorting places
        key <<= bits
        key |= np.arange(n)
        key.sort()
        order = key & ((1 << bits) - 1)
        key >>= bits
    else:
        order = np.argsort(key, kind="stable")
        key = key[order]

    # edges with exactly two half-edges, of one group and of opposite directions
    new = np.concatenate([[True], key[1:] != key[:-1], [True]])
    at = np.flatnonzero(new[:-2] & ~new[1:-1] & new[2:])
    a, b = order[at], order[at + 1]
    alike = (group[a // 3] == group[b // 3]) & (tail[a] == head[b])
    a, b = a[alike], b[alike]
    partner = np.full(n, -1)
    partner[a], partner[b] = b, a
    return partner


def _joined_labels(label: np.ndarray, partner: np.ndarray, n_label: int) -> np.ndarray:
    """Part of each label: labels that share an edge inside a part are one."""
    here = np.flatnonzero(partner >= 0)
    pairs = np.column_stack([label[here // 3], label[partner[here] // 3]])
    return _components(pairs[pairs[:, 0] < pairs[:, 1]], n_label)


def _components(pairs: np.ndarray, n: int) -> np.ndarray:
    """Number of the connected component of each node, counted in the order of first nodes."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs), dtype=bool), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    found = connected_components(graph, directed=False)[1]
    _, first, number = np.unique(found, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[number.ravel()]


def _in_order(
    local: np.ndarray,
    origin: np.ndarray,
    faces: np.ndarray,
    part: np.ndarray,
    partner: np.ndarray,
    surface: np.ndarray,
    sides: np.ndarray,
) -> Parts:
    """Number vertices and triangles part by part."""
    ids, point_of_id = _cut_open(faces, part, partner, len(local))

    # after the cut each vertex belongs to one part
    part_of_id = np.full(len(point_of_id), -1)
    part_of_id[ids.ravel()] = np.repeat(part, 3)
    used = np.flatnonzero(part_of_id >= 0)
    used = used[_stable_order(part_of_id[used], len(surface))]
    number = np.empty(len(point_of_id), dtype=np.int64)
    number[used] = np.arange(len(used))

    by_part = _stable_order(part, len(surface))
    return Parts(
        local[point_of_id[used]] + origin,
        number[ids[by_part]],
        np.searchsorted(part_of_id[used], np.arange(len(surface) + 1)),
        np.searchsorted(part[by_part], np.arange(len(surface) + 1)),
        surface,
        sides,
        number[_borders(faces, part, partner, ids)],
    )


def _stable_order(values: np.ndarray, n: int) -> np.ndarray:
    """Return the order of whole numbers below n, equal ones as they stand."""
    # numpy sorts 16 bits by digits
    small = values.astype(np.uint16) if n < 2**16 else values
    return np.argsort(small, kind="stable")


def _cut_open(
    faces: np.ndarray, part: np.ndarray, partner: np.ndarray, n_point: int
) -> tuple[np.ndarray, np.ndarray]:
    """Give each fan of faces around a point on a line a vertex of its own.

    Returns
    -------
    (ndarray of int64, shape (n_face, 3), ndarray of int64, shape (n_id,))
        Vertices of the faces, and the point where each vertex lies.
    """
    tail, head = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    on_line = np.zeros(n_point, dtype=bool)
    alone = partner < 0
    on_line[tail[alone]] = on_line[head[alone]] = True

    # parts that touch in a point only
    owner = np.empty(n_point, dtype=np.int64)
    corner_part = np.repeat(part, 3)
    owner[tail] = corner_part
    on_line[tail[owner[tail] != corner_part]] = True

    # corners of one fan follow each other over edges inside the part
    corners = np.flatnonzero(on_line[tail])
    row = np.full(faces.size, -1)
    row[corners] = np.arange(len(corners))
    halves = corners[partner[corners] >= 0]
    other = partner[halves]
    ends = np.column_stack([row[halves], row[_next(other)]])
    fan = _components(ends, len(corners))

    ids, points = tail.copy(), np.arange(n_point)
    ids[corners] = n_point + fan
    of_fan = np.empty(int(fan.max(initial=-1)) + 1, dtype=np.int64)
    of_fan[fan] = tail[corners]
    return ids.reshape(-1, 3), np.concatenate([points, of_fan])


def _next(half: np.ndarray) -> np.ndarray:
    """Next half-edge of the same face."""
    return np.where(half % 3 == 2, half - 2, half + 1)


def _borders(
    faces: np.ndarray, part: np.ndarray, partner: np.ndarray, ids: np.ndarray
) -> np.ndarray:
    """Vertex where a line begins, and the next one, against the direction of the faces."""
    alone = np.flatnonzero(partner < 0)
    tail, head = faces.ravel()[alone], faces[:, [1, 2, 0]].ravel()[alone]
    begins = np.isin(head, _line_ends(tail, head, part[alone // 3]))
    half = alone[begins]
    return np.column_stack([ids.ravel()[_next(half)], ids.ravel()[half]])


def _line_ends(tail: np.ndarray, head: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Points where lines end: where other parts meet, and three points of closed lines."""
    low_high = np.column_stack([np.minimum(tail, head), np.maximum(tail, head)])
    edges, of_half = np.unique(low_high, axis=0, return_inverse=True)
    kind = _kinds(of_half.ravel(), part, len(edges))

    # a point goes on where exactly two edges with the same parts meet
    points, at = np.unique(edges, return_inverse=True)
    at = at.reshape(-1, 2)
    count = np.bincount(at.ravel(), minlength=len(points))
    low, high = np.full(len(points), len(edges)), np.full(len(points), -1)
    np.minimum.at(low, at.ravel(), np.repeat(kind, 2))
    np.maximum.at(high, at.ravel(), np.repeat(kind, 2))
    ends = (count != 2) | (low != high)

    ends[_on_loops(at, ends)] = True
    found: np.ndarray = points[ends]
    return found


def _on_loops(at: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Three points of each line that is closed, or that ends where it begins.

    With them each line has two ends; OpenGeode takes others for lines inside a surface.
    """
    # points that go on are connected along their line
    inner = ~ends[at]
    line = _components(at[inner.all(axis=1)], len(ends))
    leaving = at[inner.sum(axis=1) == 1]
    of_end = np.where(ends[leaving[:, 0]], leaving[:, 0], leaving[:, 1])
    of_line = line[np.where(ends[leaving[:, 0]], leaving[:, 1], leaving[:, 0])]
    low, high = np.full(len(ends), len(ends)), np.full(len(ends), -1)
    np.minimum.at(low, of_line, of_end)
    np.maximum.at(high, of_line, of_end)

    # no end at all, or one for both
    members = np.flatnonzero(~ends)
    members = members[np.argsort(line[members], kind="stable")]
    members = members[low[line[members]] >= high[line[members]]]
    _, first, count = np.unique(line[members], return_index=True, return_counts=True)
    found: np.ndarray = members[np.concatenate([first, first + count // 2, first + count - 1])]
    return found


def _kinds(edge: np.ndarray, part: np.ndarray, n_edge: int) -> np.ndarray:
    """A number for each edge, the same for edges where the same parts meet."""
    order = np.lexsort((part, edge))
    edge, part = edge[order], part[order]
    first = np.searchsorted(edge, np.arange(n_edge))
    place = np.arange(len(edge)) - first[edge]
    table = np.full((n_edge, int(place.max(initial=0)) + 1), -1)
    table[edge, place] = part
    kind: np.ndarray = np.unique(table, axis=0, return_inverse=True)[1]
    return kind.ravel()
