"""Intersect two triangles, with all degenerate cases."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from geosurf.arrangement.search import name_points
from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.arrangement.trees import Tree, tree_of_list
from geosurf.conventions import real_numbers
from geosurf.errors import SurfaceError
from geosurf.kernels.contacts.triangle_contact import (
    CROSSING,
    FIRST_CODE,
    N_COLUMN,
    N_CORNER,
    meet_pairs,
    pack_contacts,
)
from geosurf.kernels.exact.predicates import (
    MAX_COORDINATE,
    MAX_SCALE,
    VALID_SIZES,
    flat_triangles,
    frame_of,
    orient3d_rows,
)
from geosurf.kernels.meshes.mesh import renumbered, weld
from geosurf.kernels.search.separation import planes_of_surfaces, undecided_pairs
from geosurf.kernels.search.tree import triangle_boxes
from geosurf.model import TriangleContact, TriangleSteps, frozen
from geosurf.model.expected import flag_of

_FEATURES = ("vertex 0", "vertex 1", "vertex 2", "edge 0", "edge 1", "edge 2", "face")
_KINDS = ("disjoint", "point", "segment")


def intersect_triangles(P: Any, Q: Any, *, steps: bool = False) -> TriangleContact:
    """
    Determine how two triangles meet, and where.

    Every case has its answer: apart, touching in a point, along an edge or a part of one, crossing,
    one in the plane of the other, overlapping in it. All decisions are exact signs; only
    the coordinates of constructed points are rounded, correctly.

    Parameters
    ----------
    P, Q : array_like of float, shape (3, 3)
        Corners: easting, northing, elevation [m].
    steps : bool, optional
        Also give the textbook's way to the answer, as `TriangleContact.steps`: heights over the
        other's plane, cut points on the common line, and their intervals. The answer does not
        follow from them.

    Returns
    -------
    TriangleContact
        `kind` is ``"disjoint"``, ``"point"``, ``"segment"`` or ``"area"``; `points` has 0, 1, 2 or
        3 to 6 rows; `features` names for each point the lowest-dimensional feature of P and of
        Q that holds it. Edge ``i`` joins corner ``i`` to the next.

    Raises
    ------
    SurfaceError
        If a triangle has another shape, is not finite, or has no area.

    Notes
    -----
    The textbook's way (Möller 1997) assumes that no corner lies in the other plane. Here each zero
    sign is a case: see ``geosurf.kernels.contacts.triangle_contact``.

    Examples
    --------
    >>> flat = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]
    >>> steep = [[1, 1, -1], [1, 1, 1], [9, 9, 1]]
    >>> contact = intersect_triangles(flat, steep)
    >>> contact.kind, contact.points.tolist(), contact.features
    ('segment', [[1.0, 1.0, 0.0], [2.0, 2.0, 0.0]], (('face', 'edge 0'), ('edge 1', 'face')))

    On the way there: the line in which both planes meet passes a corner and three edges.

    >>> steps = intersect_triangles(flat, steep, steps=True).steps
    >>> steps.heights.tolist(), steps.sides.tolist()
    ([[0.0, -64.0, 64.0], [-16.0, 16.0, 16.0]], [[0, -1, 1], [-1, 1, 1]])
    >>> steps.cut_points[0].tolist(), steps.intervals.round(2).tolist()
    ([[0.0, 0.0, 0.0], [2.0, 2.0, 0.0]], [[-2.83, 0.0], [-7.07, -1.41]])
    """
    steps = flag_of(steps, "steps")
    corners = np.concatenate([_checked("P", P), _checked("Q", Q)])
    number, count = weld(corners)
    x = np.empty((count, 3))
    x[number] = corners
    t = number.reshape(2, 3)

    m, w = frame_of(x, 2)
    for row in flat_triangles(x, t, m, w):
        raise SurfaceError(
            f"triangle {'PQ'[row]} has no area: its corners "
            f"{corners[3 * row : 3 * row + 3].tolist()} lie on one line. Give three that do not."
        )

    # The exact contact of the pair (0, 1): its corners come as codes of features of P and Q.
    rows = np.zeros((2, N_COLUMN), dtype=np.int64)
    n, _ = meet_pairs(x, t, np.array([[0, 1]]), m, w, 0.0, rows, np.empty(0, dtype=np.int64))
    sides = np.empty(6, dtype=np.int64)
    orient3d_rows(
        x, np.array([[*t[1 - k], corner] for k in (0, 1) for corner in t[k]]), m, w, sides
    )
    coplanar = not sides.any()
    walked = steps_of(corners.reshape(2, 3, 3), sides.reshape(2, 3)) if steps else None
    if n == 0:
        nowhere = frozen(np.empty((0, 3)), np.float64)
        return TriangleContact("disjoint", nowhere, coplanar, (), False, walked)

    # Each code has the feature of P above and the feature of Q in its lower three bits.
    points = _points(x, t, m, w, rows[:1])
    codes = rows[0, FIRST_CODE : FIRST_CODE + rows[0, N_CORNER]] & 63
    order = _around(points) if len(codes) > 2 else np.lexsort(points.T[::-1])
    features = tuple((_FEATURES[code >> 3], _FEATURES[code & 7]) for code in codes[order])
    kind = "area" if len(codes) > 2 else _KINDS[len(codes)]
    crossing = bool(rows[0, CROSSING])
    places = frozen(points[order], np.float64)
    return TriangleContact(kind, places, coplanar, features, crossing, walked)


def _checked(letter: str, triangle: Any) -> np.ndarray:
    """Float64 (3, 3), finite, or a SurfaceError."""
    try:
        corners = real_numbers(triangle)
    except (TypeError, ValueError) as error:
        raise SurfaceError(f"triangle {letter} is not made of numbers: {error}.") from error

    if corners.shape != (3, 3):
        raise SurfaceError(
            f"triangle {letter} has shape {corners.shape}, expected (3, 3): three corners with "
            "easting, northing, elevation."
        )
    if not (np.abs(corners) <= MAX_COORDINATE).all():
        raise SurfaceError(
            f"triangle {letter} has a coordinate that is not finite or beyond "
            f"{MAX_COORDINATE:g} m: {corners.tolist()}. Leave out nodes that are undefined."
        )

    # Coordinates are scaled to whole numbers; -0.0 becomes 0.0 at the end.
    digits = corners * 2.0**MAX_SCALE
    if (digits != np.floor(digits)).any():
        raise SurfaceError(
            f"triangle {letter} has a coordinate too close to 0: {corners.tolist()}; {VALID_SIZES}."
        )
    return corners + 0.0


def steps_of(corners: np.ndarray, sides: np.ndarray) -> TriangleSteps:
    """The textbook's steps of two triangles (2, 3, 3), from the exact `sides` of their corners."""
    first, second, third = corners.transpose(1, 0, 2)
    normals = np.cross(second - first, third - first)
    heights = np.einsum("kij,kj->ki", corners - first[::-1, None], normals[::-1])
    one_sided = (np.abs(sides.sum(axis=1)) == 3).tolist()
    rejected = "PQ"[one_sided.index(True)] if any(one_sided) else None

    # A triangle meets the common line in corners that lie on it, and in edges that cross it.
    cuts: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
    on_line = sides.any() and rejected is None
    for k, a in ((k, a) for k in (0, 1) for a in (0, 1, 2) if on_line):
        b = (a + 1) % 3
        if sides[k, a] == 0:
            cuts[k].append(corners[k, a])
        elif sides[k, a] * sides[k, b] < 0:
            part = heights[k, a] / (heights[k, a] - heights[k, b])
            cuts[k].append(corners[k, a] + part * (corners[k, b] - corners[k, a]))
    points = np.reshape(cuts[0], (-1, 3)), np.reshape(cuts[1], (-1, 3))
    if not on_line:
        return TriangleSteps(normals, heights, sides, rejected, None, points, None, None)

    # Places along the line, from the first cut point of P.
    along = np.cross(*normals)
    along /= np.linalg.norm(along)
    places = [(one - points[0][0]) @ along for one in points]
    intervals = np.array([[one.min(), one.max()] for one in places])
    low, high = float(intervals[:, 0].max()), float(intervals[:, 1].min())
    overlap = (low, high) if low <= high else None
    return TriangleSteps(normals, heights, sides, None, along, points, intervals, overlap)


def _points(
    x: np.ndarray, t: np.ndarray, m: np.ndarray, w: np.ndarray, rows: np.ndarray
) -> np.ndarray:
    """Coordinates of the points of one contact."""
    # Room for the six corners and twelve constructed points; the ids name those of the contact.
    space = np.concatenate([x, np.empty((12, 3))])
    e, d = np.zeros((12, 3), dtype=np.int64), np.zeros((12, 4), dtype=np.int64)
    ids = np.empty((1, 6), dtype=np.int64)
    name_points(space, t, e, d, m, w, pack_contacts(rows), ids)
    return space[ids[0, : rows[0, N_CORNER]]]


def _around(points: np.ndarray) -> np.ndarray:
    """Order of the corners of a convex polygon around its middle, from the lowest corner."""
    # The two main axes of the points span their plane; angles around the mean give the order.
    middle = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(middle)
    order = np.argsort(np.arctan2(middle @ axes[1], middle @ axes[0]))

    # The lexicographically lowest corner comes first, so that the result does not depend on the
    # SVD.
    start = int(np.lexsort(points[order].T[::-1])[0])
    return np.roll(order, -start)


# ---- crossing ----------------------------------------
# Test exactly that triangles of a rounded mesh meet only in shared corners and edges.
#
# A few products show that nearly all pairs of neighbours are apart by a plane
# (`geosurf.kernels.search.separation`). Exact signs decide the rest.


_EACH = 10_000  # triangles that a thread searches, at least


def crossing_pairs(
    x: np.ndarray, triangles: np.ndarray, others: np.ndarray | None = None
) -> np.ndarray:
    """
    Find pairs of triangles that meet elsewhere than in common corners and edges.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
        Coordinates, taken at face value.
    triangles : ndarray of int64, shape (n, 3)
        Compared with each other, except those with the same corners. None without area.
    others : ndarray of int64, shape (k, 3), optional
        Compared with `triangles`, but not with each other.

    Returns
    -------
    ndarray of int64, shape (n_pair, 2)
        Rows of `triangles` followed by `others`, the lower one first, in order.

    Examples
    --------
    >>> x = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [1, 1, -1], [1, 1, 1], [2, 1, 1.0]])
    >>> crossing_pairs(x, np.array([[0, 1, 2], [3, 4, 5]])).tolist()
    [[0, 1]]
    """
    n, t = len(triangles), triangles
    if others is not None:
        t = np.concatenate([triangles, others])
    one, two = (group_of(x, t, rows) for rows in np.split(np.arange(len(t)), [n]))
    return crossing_between(x, t, [(one, one), (one, two)])


class Group(NamedTuple):
    """Some triangles of a list: a tree over them, their rows and boxes in the order of the tree."""

    tree: Tree
    rows: np.ndarray
    boxes: np.ndarray


def group_of(x: np.ndarray, triangles: np.ndarray, rows: np.ndarray) -> Group:
    """The triangles in some rows."""
    part = triangles.take(rows, axis=0)
    tree = tree_of_list(x, part)
    boxes = triangle_boxes(x, part.take(tree.order, axis=0))
    return Group(tree, rows.take(tree.order), boxes)


def crossing_between(
    x: np.ndarray, triangles: np.ndarray, groups: list[tuple[Group, Group]]
) -> np.ndarray:
    """Pairs of triangles as of `crossing_pairs`, one of each of two groups, or both of one."""

    def of_range(small: Group, large: Group, first: int, last: int) -> np.ndarray:
        """Pairs of a range that are not seen to be apart at once: as many as there is room for,
        again if there were more.
        """
        undecided = np.empty((1024 + (last - first) // 4, 2), dtype=np.int64)
        trees = small.boxes, small.rows, small.tree.nodes, large.boxes, large.rows, large.tree.nodes
        given = x, triangles, *trees, large.tree.levels, small is large, first, last
        n = undecided_pairs(*given, undecided)
        if n > len(undecided):
            undecided = np.empty((n, 2), dtype=np.int64)
            undecided_pairs(*given, undecided)
        return undecided[:n]

    tasks = []
    for pair in groups:
        small, large = sorted(pair, key=lambda group: len(group.rows))
        if len(small.rows):
            tasks += [(small, large, *part) for part in in_ranges(len(small.rows), _EACH)]
    pairs = np.concatenate([np.empty((0, 2), dtype=np.int64), *map_threads(of_range, tasks)])
    pairs = pairs[np.lexsort(pairs.T[::-1])]

    m, w = frame_of(x, len(triangles))
    rows = np.empty((len(pairs) + 1, N_COLUMN), dtype=np.int64)
    n, _ = meet_pairs(x, triangles, pairs, m, w, 0.0, rows, np.empty(0, dtype=np.int64))
    rows = rows[:n]

    # Rows with a corner that is not a corner of both triangles: they meet elsewhere, too.
    used = np.arange(6)[None, :] < rows[:, N_CORNER, None]
    codes = rows[:, FIRST_CODE:]
    shared = ((codes >> 3) < 3) & ((codes & 7) < 3)
    return rows[(used & ~shared).any(axis=1), :2]


def are_graphs(
    x: np.ndarray, triangles: np.ndarray, surface: np.ndarray, ring: np.ndarray, groups: list[Group]
) -> list[bool]:
    """
    Whether each surface is surely a graph over a coordinate plane.

    Its triangles then meet in common corners and edges only: see
    `geosurf.kernels.search.separation`.

    Parameters
    ----------
    x, triangles : ndarray
        As of `crossing_pairs`.
    surface : ndarray of int64, shape (n,)
        Surface of each triangle.
    ring : ndarray of int64, shape (3 * n,)
        Next half-edge around the same edge.
    groups : list of Group
        The triangles of each surface.
    """
    m, w = frame_of(x)
    plane, rim = planes_of_surfaces(x, triangles, surface, ring, len(groups), m, w)

    def is_graph(rows: np.ndarray, k: int) -> bool:
        """Whether no triangle at the rim of a surface meets another one, seen on plane k."""
        if k < 0:
            return False
        used, corners = renumbered(triangles.take(rows, axis=0))
        flat = np.zeros((len(used), 3))
        flat[:, 0], flat[:, 1] = x[used, k], x[used, (k + 1) % 3]
        at_rim = rim[rows]
        return not len(crossing_pairs(flat, corners[at_rim], corners[~at_rim]))

    rows = (group.rows for group in groups)
    return map_threads(is_graph, list(zip(rows, plane.tolist(), strict=True)))


# ---- halved edges ----------------------------------------
# Triangles whose long edges are halved: all triangles at an edge get the same middle.


# parts of a face by its halved edges, rows of (a, b, c, middle of ab, of bc, of ca); turned
# so that the halved edges come first, and with two of them the shorter diagonal is chosen
ONE = np.array([[3, 1, 2], [3, 2, 0]])
TWO = np.array([[[3, 1, 4], [0, 3, 4], [0, 4, 2]], [[3, 1, 4], [0, 3, 2], [3, 4, 2]]])
THREE = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])


def halved(
    x: np.ndarray, faces: np.ndarray, chosen: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Halve some edges of triangles.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
    faces : ndarray of int64, shape (n, 3)
    chosen : ndarray of bool, shape (n, 3)
        Edges to halve, the first from corner 0 to corner 1; alike for all triangles at an edge.

    Returns
    -------
    x : ndarray of float64
        With the middles behind.
    faces, source : ndarray of int64
        The parts, and which triangle each is of, rising.

    Examples
    --------
    >>> first = np.array([[True, False, False]])
    >>> x, faces, source = halved(np.eye(3), np.array([[0, 1, 2]]), first)
    >>> faces.tolist(), source.tolist()
    ([[3, 1, 2], [3, 2, 0]], [0, 0])
    """
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    long = chosen.ravel()
    keys, number = np.unique(edges[long, 0] * len(x) + edges[long, 1], return_inverse=True)
    middle = np.full(len(edges), -1)
    middle[long] = len(x) + number
    x = np.concatenate([x, 0.5 * (x[keys // len(x)] + x[keys % len(x)])])
    return x, *_split(x, faces, middle.reshape(-1, 3))


def _split(x: np.ndarray, faces: np.ndarray, middle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split faces at the middles of their edges; -1 where an edge stays."""
    count = (middle >= 0).sum(axis=1)
    # turned: the first edge is the halved one, or the edge before the whole one
    whole = (middle < 0).argmax(axis=1)
    turn = np.where(count == 1, (middle >= 0).argmax(axis=1), np.where(count == 2, whole + 1, 0))
    columns = (turn[:, None] + np.arange(3)) % 3
    rows = np.concatenate(
        [np.take_along_axis(faces, columns, 1), np.take_along_axis(middle, columns, 1)], axis=1
    )

    # of two diagonals the shorter one: from the first corner, or to the last
    two = np.flatnonzero(count == 2)
    length = [np.square(x[rows[two, i]] - x[rows[two, j]]).sum(axis=1) for i, j in ((0, 4), (3, 2))]
    other = length[0] > length[1]
    parts = [
        (np.flatnonzero(count == 0), np.array([[0, 1, 2]])),
        (np.flatnonzero(count == 1), ONE),
        (two[~other], TWO[0]),
        (two[other], TWO[1]),
        (np.flatnonzero(count == 3), THREE),
    ]
    made = np.concatenate([rows[of][:, part].reshape(-1, 3) for of, part in parts])
    source = np.concatenate([np.repeat(of, len(part)) for of, part in parts])
    order = np.argsort(source, kind="stable")
    return made[order], source[order]
