"""Find the intersection lines of surfaces, and link them to curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geosurf.arrangement.arrange import Children, cut_contacts
from geosurf.arrangement.search import Contacts, find_contacts
from geosurf.arrangement.trees import check_surfaces
from geosurf.errors import InvariantError
from geosurf.intersect.link import (
    canonical,
    line_contacts,
    link,
    of_pairs,
    off_curves,
    pairs_of_rows,
    pairs_with_areas,
    split_overlaps,
    total_cost,
    touching_points,
)
from geosurf.kernels.contacts.triangle_contact import in_plane, n_corners
from geosurf.kernels.lattices.sets import ranges
from geosurf.kernels.meshes.mesh import edges, join_pairs, pieces
from geosurf.model import Curves, Touch, TriSurface, frozen
from geosurf.model.base import in_crs_of
from geosurf.model.expected import flag_of

# ---- overlap ----------------------------------------
# Find where surfaces coincide: areas, curves and touching points, from the exact arrangement.
#
# Both surfaces of a pair are rebuilt around their contacts, those of each with itself included:
# where one crosses itself, both are cut alike only then. What both then have is what they have in
# common: triangles (the areas), edges and points. Of these, the inside of an area is not a curve
# or touching point. A place is inside where both surfaces are one sheet and the same one: there
# is a disk around it that is all of both. So the outline of an area is a curve, and so is the
# line in which a further sheet of either surface crosses the area or ends on it, or in which
# areas branch; no edge of a mesh is, and an area without an outline has no curve.
#
# Of a surface that lies on itself, the area is what it has twice, and what it has in common with
# itself is that and its contacts in lines and points.


_LOW, _HIGH = (0, 1, 0), (1, 2, 2)  # corners of a sorted triangle at the ends of its edges


@dataclass
class Overlap:
    """What two surfaces have in common where they coincide over areas.

    Attributes
    ----------
    local : ndarray of float64, shape (n, 3)
        Points.
    segments : ndarray of int64, shape (n_segment, 2)
        Of curves; rows of `local`.
    single : ndarray of float64, shape (n_single, 3)
        Touching points.
    areas : list of Touch
    """

    local: np.ndarray
    segments: np.ndarray
    single: np.ndarray
    areas: list[Touch]


@dataclass
class _Common:
    """Distinct triangles of both surfaces (corners rising), and what both have.

    Attributes
    ----------
    corners : ndarray of int64, shape (n, 3)
    shared : ndarray of bool, shape (n,)
        Triangles that both have.
    edges, points : ndarray of int64
        Keys of edges and rows of points that both have.
    """

    corners: np.ndarray
    shared: np.ndarray
    edges: np.ndarray
    points: np.ndarray


def overlap_of(surfaces: Sequence[TriSurface], i: int, j: int, origin: np.ndarray) -> Overlap:
    """Areas, curves and touching points of surfaces i and j, in the frame of `origin`."""
    # Cut both along all their contacts, and each along those with itself: common parts are then
    # whole triangles, edges and points.
    pair = (surfaces[i], surfaces[j]) if i != j else (surfaces[i],)
    own = [(k, k) for k in range(len(pair))]
    contacts = find_contacts(pair, pairs=[*own, (0, 1)] if i != j else own, origin=origin)
    children = cut_contacts(contacts)
    n = len(children.x)
    common = _of_one(contacts, children, n) if i == j else _of_two(contacts, children, n)

    # An edge is inner where it has two triangles and both surfaces own them.
    keys = _edge_keys(common.corners, n)
    distinct, edge, count = np.unique(keys, return_inverse=True, return_counts=True)
    edge = edge.reshape(-1, 3)
    inner = (count == 2) & (np.bincount(edge[common.shared].ravel(), minlength=len(distinct)) == 2)

    # Common edges that are not inner are curves; they bound areas or cross them.
    lines = np.setdiff1d(common.edges, distinct[inner])
    segments = np.stack([lines // n, lines % n], axis=1)

    # Touching points are common points on no curve and not inside an area.
    used = np.zeros(n, dtype=bool)
    used[segments] = True
    used |= _inside(common.corners, edge, inner, n)
    single = children.x[common.points[~used[common.points]]]
    areas = _areas(children.x, origin, common.corners[common.shared], (i, j))
    return Overlap(children.x, segments, np.unique(single, axis=0), areas)


def arranged_faces(
    contacts: Contacts, children: Any, surface: int
) -> tuple[np.ndarray, np.ndarray]:
    """Faces of one surface after cutting (rows of `children.x`), and the faces they are part of."""
    uncut = np.ones(len(contacts.t), dtype=bool)
    uncut[children.cut] = False
    uncut &= contacts.surface_of_face == surface
    mine = contacts.surface_of_face[children.parent] == surface
    faces = np.concatenate([contacts.t[uncut], children.triangles[mine]])
    return faces, np.concatenate([np.flatnonzero(uncut), children.parent[mine]])


def _edge_keys(t: np.ndarray, n: int) -> np.ndarray:
    """Keys (n_triangle, 3) of the edges of triangles with rising corners."""
    return t[:, _LOW] * n + t[:, _HIGH]


def _distinct(triangles: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Distinct triangles, corners rising, and the number of each triangle among them."""
    # Sorted corners as a pair key and the third; `lexsort` brings equal triangles together.
    corners = np.sort(triangles, axis=1)
    pair = corners[:, 0] * n + corners[:, 1]
    order = np.lexsort((corners[:, 2], pair))
    corners, pair = corners[order], pair[order]
    third = corners[:, 2]

    # The first of equals is new; counting them numbers all.
    new = np.ones(len(order), dtype=bool)
    new[1:] = (pair[1:] != pair[:-1]) | (third[1:] != third[:-1])
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.cumsum(new) - 1
    return corners[new], number


def _of_one(contacts: Contacts, children: Children, n: int) -> _Common:
    """What a surface has in common with itself."""
    faces, parents = arranged_faces(contacts, children, 0)
    corners, number = _distinct(faces, n)
    # A piece that occurs twice is where the surface lies on itself.
    shared = np.bincount(number) > 1

    # Its lines are contacts in lines and the edges of such areas.
    ends = np.sort(_pieces_of_lines(contacts, children, faces, parents), axis=1)
    lines = np.union1d(ends[:, 0] * n + ends[:, 1], _edge_keys(corners[shared], n))
    single = touching_points(contacts, pairs_of_rows(contacts))[:, 2]
    return _Common(corners, shared, lines, np.union1d(single, corners[shared]))


def _of_two(contacts: Contacts, children: Children, n: int) -> _Common:
    """What two surfaces have in common."""
    # Numbers of pieces are comparable, since both surfaces are in one list.
    corners_one, faces_one = arranged_faces(contacts, children, 0)
    corners_two, faces_two = arranged_faces(contacts, children, 1)
    corners, number = _distinct(np.concatenate([corners_one, corners_two]), n)
    piece_one, piece_two = np.split(number, [len(corners_one)])

    shared = np.zeros(len(corners), dtype=bool)
    shared[np.intersect1d(piece_one, piece_two)] = True
    _assert_shared(contacts, (faces_one, piece_one), (faces_two, piece_two))

    # Edges and points that occur in both.
    both = [corners[np.unique(piece)] for piece in (piece_one, piece_two)]
    lines = np.intersect1d(_edge_keys(both[0], n), _edge_keys(both[1], n))
    return _Common(corners, shared, lines, np.intersect1d(both[0], both[1]))


def _assert_shared(
    contacts: Contacts, first: tuple[np.ndarray, np.ndarray], second: tuple[np.ndarray, np.ndarray]
) -> None:
    """A contact over an area has triangles that both have, or a promise of ours is broken."""
    # Faces of different surfaces that share a plane and at least three corners.
    rows = contacts.rows
    area = in_plane(rows) & (n_corners(rows) >= 3)
    area &= contacts.surface_of_face[rows[:, 0]] != contacts.surface_of_face[rows[:, 1]]
    n = len(contacts.t)
    if not np.isin(rows[area, 0] * n + rows[area, 1], _sharing(*first, *second, n)).all():
        one, two = (surface.name for surface in contacts.surfaces)
        raise InvariantError(
            f"an overlap of {one!r} and {two!r} is not the same triangles in both; please "
            "report this with the surfaces."
        )


def _sharing(
    faces: np.ndarray, pieces: np.ndarray, others: np.ndarray, other_pieces: np.ndarray, n: int
) -> np.ndarray:
    """Keys of faces of two surfaces that have a piece in common.

    A surface folded onto itself has one piece in several faces.
    """
    # The rows of each piece among the others: an interval of `order`.
    order = np.argsort(other_pieces, kind="stable")
    first = np.searchsorted(other_pieces[order], pieces)
    count = np.searchsorted(other_pieces[order], pieces, side="right") - first

    # Repeat each face once for each row of its interval.
    of, at = ranges(first, count)
    return faces[of] * n + others[order[at]]


def _pieces_of_lines(
    contacts: Contacts, children: Children, faces: np.ndarray, parents: np.ndarray
) -> np.ndarray:
    """Where a surface meets itself in a line: the edges of its pieces along it, rows (n, 2)."""
    lines, surfaces = line_contacts(contacts, pairs_of_rows(contacts))
    arranged = replace(contacts, x=children.x, d=children.d, m=children.m)

    # All corners of the pieces are possible stops, known in the face that they are part of.
    points = np.unique(faces)
    stops = np.column_stack([np.zeros((len(points), 2), dtype=np.int64), points])
    in_faces = np.stack([np.repeat(parents, 3), faces.ravel()], axis=1)
    return split_overlaps(arranged, lines, surfaces, stops, in_faces)[0]


def _inside(corners: np.ndarray, edge: np.ndarray, inner: np.ndarray, n: int) -> np.ndarray:
    # A point with an edge that is not inner lies on a curve.
    """Whether each point is inside of an area, bool (n,).

    All edges at it are, and the triangles around it are one ring, not several that touch there.
    """
    inside = np.zeros(n, dtype=bool)
    inside[corners] = True
    inside[corners[:, _LOW][~inner[edge]]] = False
    inside[corners[:, _HIGH][~inner[edge]]] = False

    # Inner edges have two sides each; consecutive rows of `order` are such a pair.
    half = np.flatnonzero(inner[edge].ravel())
    order = half[np.argsort(edge.ravel()[half], kind="stable")].reshape(-1, 2)

    # Join the corners of both triangles at either end of the edge. One class of corners per point
    # is one ring; two are fans that touch in the point.
    ends = [3 * (order // 3) + np.array(side)[order % 3] for side in (_LOW, _HIGH)]
    ring = join_pairs(np.concatenate(ends), corners.size)
    first = np.flatnonzero(ring == np.arange(corners.size))
    inside &= np.bincount(corners.ravel()[first], minlength=n) == 1
    return inside


def _areas(
    local: np.ndarray, origin: np.ndarray, shared: np.ndarray, pair: tuple[int, int]
) -> list[Touch]:
    """One `Touch` for each connected overlap area, largest first."""
    # Triangles joined by edges form one area.
    ring, _ = edges(shared, len(local))
    piece, count = pieces(shared, ring)
    a, b, c = (local[shared[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    touches = []
    # Its outline: edges of one triangle only.
    for p in range(count):
        rows = np.flatnonzero(piece == p)
        keys, times = np.unique(_edge_keys(shared[rows], len(local)), return_counts=True)
        rim = keys[times == 1] if (times == 1).any() else keys  # closed: all that it has
        points = local[np.unique(np.concatenate([rim // len(local), rim % len(local)]))] + origin
        points = points[np.lexsort(points.T[::-1])]
        touches.append(Touch("area", pair, points, float(area[rows].sum())))
    return sorted(touches, key=lambda touch: (-touch.area, touch.points[0].tolist()))


def intersect_surfaces(
    surfaces: Sequence[TriSurface],
    *,
    method: str = "auto",
    voxel_size: float | None = None,
    self_intersections: bool = False,
) -> Curves:
    """
    Find the curves along which surfaces meet.

    Every pair of surfaces is compared. Where two triangles share more than a point, the
    shared segment becomes part of a curve; isolated touching points and areas over which
    surfaces coincide are reported apart. All decisions are exact signs, and points are known by
    the features that make them, so the curves depend neither on the order of surfaces, triangles
    and corners nor on the search. The curves of two surfaces are the same whatever other surfaces
    there are: where three meet in a point, their curves pass through it, and only
    `rebuild_surfaces` puts a vertex there, one for all of them. Inside an area where two surfaces
    coincide there is no curve, unless a further sheet of one of them crosses the area, ends on it
    or touches it.

    Parameters
    ----------
    surfaces : sequence of TriSurface
        At least two (one with `self_intersections`). Vertices in metres.
    method : {"auto", "tree", "voxels"}
        How candidate triangles are searched: trees of boxes, kept on the surfaces, or equal
        voxels in a global box. Changes the cost, never the result. ``"auto"`` takes trees, and
        voxels where `voxel_size` is given.
    voxel_size : float, optional
        Edge of the search voxels [m]. Default: fitted to the faces that can meet.
    self_intersections : bool
        Whether to look for curves of each surface with itself, too. Edges and corners that
        neighbouring triangles share are not contacts.

    Returns
    -------
    Curves
        Curve ``i`` joins the surfaces ``surfaces_of_curve[i]``. `Curves.cost` has the numbers
        of voxels or tree nodes, candidate faces, pairs of triangles tested and pairs meeting.

    Raises
    ------
    InputError
        For fewer surfaces than needed, or an unknown method.
    SurfaceError
        If a surface is empty or has triangles without area.

    See Also
    --------
    rebuild_surfaces : make the surfaces share vertices along these curves.

    Notes
    -----
    Search: trees over Morton-ordered triangles with a test of planes against boxes, or a global
    box cut to where two surfaces can meet and equal voxels in it, after Lo & Wang
    (2004, Eng. Comput. 20). Contacts: signs of orientation after Guigue & Devillers
    (2003), unlike them with every zero sign named as a contact of its own.

    Examples
    --------
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[3, -1, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> curves = intersect_surfaces([flat, wall])
    >>> curves.n_curve, curves.names, bool(curves.closed[0])
    (1, ('Top', 'F1'), False)
    """
    self_intersections = flag_of(self_intersections, "self_intersections")
    surfaces = check_surfaces(surfaces, 1 if self_intersections else 2)
    contacts = find_contacts(
        surfaces, method=method, voxel_size=voxel_size, self_intersections=self_intersections
    )
    return in_crs_of(curves_of(contacts), surfaces)


def curves_of(contacts: Contacts) -> Curves:
    """Link contacts to curves.

    Parameters
    ----------
    contacts : Contacts
        As found by `geosurf.arrangement.find_contacts`.

    Returns
    -------
    Curves
    """
    names = tuple(s.name for s in contacts.surfaces)
    pairs = pairs_of_rows(contacts)
    segments, surfaces = line_contacts(contacts, pairs)
    touching = touching_points(contacts, pairs)
    coinciding = pairs_with_areas(contacts, pairs)

    # Pairs that coincide over an area are taken from their arrangement below, all others from here.
    plain = ~of_pairs(surfaces, coinciding)
    touching = touching[~of_pairs(touching[:, :2], coinciding)]
    segments, surfaces = split_overlaps(contacts, segments[plain], surfaces[plain], touching)

    # Each pair brings points of its own; `n` shifts its segments to rows of the common list.
    local, lines, owners, n = [contacts.x], [segments], [surfaces], len(contacts.x)
    touches, single = [], {}
    for i, j in coinciding.tolist():
        overlap = overlap_of(contacts.surfaces, i, j, contacts.origin)
        lines.append(overlap.segments + n)
        owners.append(np.tile([i, j], (len(overlap.segments), 1)))
        single[i, j] = overlap.single
        touches += overlap.areas
        local.append(overlap.local)
        n += len(overlap.local)

    # Points in equal places become one, and the order no longer depends on the input.
    points, segments, surfaces = canonical(*map(np.concatenate, (local, lines, owners)))
    touches += _isolated(contacts, touching, points, segments, surfaces, single)
    return _linked(names, contacts.origin, points, segments, surfaces, touches, contacts.cost)


def merge_curves(names: tuple[str, ...], origin: np.ndarray, parts: Sequence[Curves]) -> Curves:
    """Put curves of different pairs of surfaces together.

    Parameters
    ----------
    names : tuple of str
        Of all surfaces.
    origin : ndarray, shape (3,)
        Of the common frame [m].
    parts : sequence of Curves
        Each of some of these surfaces, in the same order.

    Returns
    -------
    Curves
        As if all pairs had been intersected at once.
    """
    touches = []
    cost = total_cost(part.cost for part in parts)
    # Parts have origins of their own; all move to the common frame.
    local, segments, surfaces = (
        [np.empty((0, 3))],
        [np.empty((0, 2), int)],
        [np.empty((0, 2), int)],
    )
    n = 0
    for part in parts:
        rows = np.array([names.index(name) for name in part.names])
        for touch in part.contacts:
            i, j = rows[list(touch.surfaces)].tolist()
            touches.append(replace(touch, surfaces=(i, j)))
        local.append(part.local + (part.origin - origin))
        segments.append(part.segments + n)
        surfaces.append(rows[part.surfaces_of_segment])
        n += len(part.local)

    points, joined, owners = canonical(*map(np.concatenate, (local, segments, surfaces)))
    return _linked(names, origin, points, joined, owners, touches, cost)


def _linked(
    names: tuple[str, ...],
    origin: np.ndarray,
    points: np.ndarray,
    segments: np.ndarray,
    surfaces: np.ndarray,
    touches: Sequence[Touch],
    cost: dict[str, int],
) -> Curves:
    """Link canonical segments and freeze the result."""
    curves, surfaces_of_curve, closed = link(segments, surfaces, len(points))
    return Curves(
        names=names,
        local=frozen(points, np.float64),
        origin=frozen(origin, np.float64),
        segments=frozen(segments, np.int64),
        surfaces_of_segment=frozen(surfaces, np.int64),
        curves=tuple(frozen(curve, np.int64) for curve in curves),
        surfaces_of_curve=frozen(surfaces_of_curve, np.int64),
        closed=frozen(closed, np.bool_),
        contacts=tuple(touches),
        cost=dict(cost),
    )


def _isolated(
    contacts: Contacts,
    touching: np.ndarray,
    points: np.ndarray,
    segments: np.ndarray,
    surfaces: np.ndarray,
    single: dict[tuple[int, int], np.ndarray],
) -> list[Touch]:
    """Touching points that lie on no curve of their pair of surfaces.

    `single` has those of pairs that coincide over areas, `touching` those of the others.
    """
    touches: dict[tuple[int, int], list[Touch]] = {}
    pairs, places = off_curves(contacts.x, touching, points, segments, surfaces)

    # Touching points outside overlaps, then those of pairs that overlap somewhere.
    rows = list(zip(map(tuple, pairs.tolist()), places, strict=True))
    rows += [(pair, at) for pair, some in single.items() for at in np.unique(some, axis=0)]
    for pair, at in rows:
        touches.setdefault(pair, []).append(Touch("point", pair, at[None] + contacts.origin))
    return [touch for pair in sorted(touches) for touch in touches[pair]]
