"""Link contacts to curves: segments by pair of surfaces, joined at their end points.

Points are sorted by coordinates and curves by their points, so that the result does not
depend on the order in which surfaces, triangles or corners were given.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.arrangement.search import Contacts
from geosurf.arrangement.threads import lack_of_room, refusal
from geosurf.arrangement.tree_pairs import ULP
from geosurf.errors import InputError
from geosurf.kernels.contacts.aligned_grids import points_near_segments
from geosurf.kernels.contacts.triangle_contact import in_plane, n_corners
from geosurf.kernels.exact.predicates import inside_segments
from geosurf.kernels.lattices.sets import distinct, is_among, ranges
from geosurf.kernels.meshes.linking import link_segments
from geosurf.kernels.meshes.mesh import number_keys, weld
from geosurf.model import Curves, Patches, frozen


def pairs_of_rows(contacts: Contacts) -> np.ndarray:
    """Surface rows (lower first) of each contact, int64 (n_contact, 2)."""
    return np.stack(np.divmod(pair_keys(contacts), len(contacts.surfaces)), axis=1)


def pair_keys(contacts: Contacts) -> np.ndarray:
    """Pair of surfaces of each contact as one number, ``n_surface * lower + upper``."""
    one, two = (contacts.surface_of_face.take(contacts.rows[:, k]) for k in (0, 1))
    return len(contacts.surfaces) * np.minimum(one, two) + np.maximum(one, two)


def line_contacts(contacts: Contacts, pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Segments (rows of `contacts.x`, once a pair) and their surfaces, from contacts in a line.

    A surface's own edges and corners are not contacts with itself.
    """
    two = np.flatnonzero(n_corners(contacts.rows) == 2)
    segments, surfaces = contacts.ids[two, :2], pairs[two]
    with_itself = np.flatnonzero(surfaces[:, 0] == surfaces[:, 1])
    # A shared edge or corner of one surface: both ends are corners of both faces.
    if len(with_itself):
        ends = segments[with_itself, :, None]
        for side in range(2):
            corners = contacts.t[contacts.rows[two[with_itself], side]]
            with_itself = with_itself[(ends == corners[:, None, :]).any(axis=2).all(axis=1)]
            ends = segments[with_itself, :, None]
        others = np.ones(len(two), dtype=bool)
        others[with_itself] = False
        segments, surfaces = segments[others], surfaces[others]
    return _once(segments, surfaces, len(contacts.x))


def _once(
    segments: np.ndarray, surfaces: np.ndarray, n_point: int
) -> tuple[np.ndarray, np.ndarray]:
    """Each segment of each pair once, lower point first, sorted by surfaces and then points."""
    pairs, pair = _numbered(*_keys(surfaces))
    segments, pair = sort_segments(segments, pair)
    return segments, pairs[pair]


def _keys(surfaces: np.ndarray) -> tuple[np.ndarray, int]:
    """Pairs of surfaces as numbers, ``n_surface * lower + upper``, and `n_surface`."""
    n_surface = int(surfaces.max(initial=0)) + 1
    return surfaces[:, 0] * n_surface + surfaces[:, 1], n_surface


def _numbered(keys: np.ndarray, n_surface: int) -> tuple[np.ndarray, np.ndarray]:
    """Distinct pairs of surfaces, sorted, and the number of each pair among them."""
    found, number = number_keys(keys)
    return np.stack(np.divmod(found, n_surface), axis=1), number


def touching_points(contacts: Contacts, pairs: np.ndarray) -> np.ndarray:
    """Rows (surface, surface, point) of contacts in a single point, once each."""
    single = np.flatnonzero(n_corners(contacts.rows) == 1)
    if len(single) == 0:
        return np.empty((0, 3), dtype=np.int64)

    points, surfaces = contacts.ids[single, :1], pairs[single]
    with_itself = surfaces[:, 0] == surfaces[:, 1]
    for side in range(2):
        t = contacts.t[contacts.rows[single, side]]
        with_itself &= (points == t).any(axis=1)

    # Contacts of several faces may name the same point: once per pair of surfaces is enough.
    keys, n_surface = _keys(surfaces)
    pair, point = np.divmod(
        np.unique(keys[~with_itself] * len(contacts.x) + points[~with_itself, 0]), len(contacts.x)
    )
    return np.column_stack([*np.divmod(pair, n_surface), point])


def off_curves(
    x: np.ndarray,
    touching: np.ndarray,
    points: np.ndarray,
    segments: np.ndarray,
    surfaces: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Touching points that lie on no curve of their pair of surfaces.

    Parameters
    ----------
    x : ndarray of float64, shape (n, 3)
    touching : ndarray of int64, shape (n_touching, 3)
        Surfaces and point (row of `x`).
    points, segments, surfaces : ndarray
        Of all curves, see `canonical`.

    Returns
    -------
    pairs : ndarray of int64, shape (n_found, 2)
        Surfaces, sorted; those of one pair by their places.
    places : ndarray of float64, shape (n_found, 3)
    """
    if len(touching) == 0:
        return touching[:, :2], x[:0]

    # Compared by place, since a curve may have another row for the same point.
    places = x[touching[:, 2]] + 0.0  # -0.0 is 0.0
    number, count = weld(np.concatenate([places, points]))
    pairs, _ = _keys(np.concatenate([touching[:, :2], surfaces]))

    # One key for pair and place; ends of the segments of the same pair drop out.
    keys = pairs[: len(touching)] * count + number[: len(touching)]
    ends = number[len(touching) :][segments]
    keys, first = np.unique(keys, return_index=True)
    of_segment = pairs[len(touching) :, None]
    first = first[~np.isin(keys, (of_segment * count + ends).ravel())]

    # By pair, then easting, northing, elevation.
    order = np.lexsort((*places[first].T[::-1], pairs[first]))
    return touching[first[order], :2], places[first[order]]


def pairs_with_areas(contacts: Contacts, pairs: np.ndarray) -> np.ndarray:
    """Pairs of surfaces that coincide somewhere over an area."""
    area = in_plane(contacts.rows) & (n_corners(contacts.rows) >= 3)
    if not area.any():
        return pairs[:0]
    keys, n_surface = _keys(pairs[area])
    return np.stack(np.divmod(np.unique(keys), n_surface), axis=1)


def of_pairs(surfaces: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Which rows of surfaces (n, 2) are one of some pairs, bool (n,)."""
    if len(pairs) == 0:
        return np.zeros(len(surfaces), dtype=bool)
    keys, _ = _keys(np.concatenate([surfaces, pairs]))
    return np.isin(keys[: len(surfaces)], keys[len(surfaces) :])


def canonical(
    local: np.ndarray, segments: np.ndarray, surfaces: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points in use, sorted by coordinates; segments and surfaces renumbered and sorted."""
    pairs, pair = _numbered(*_keys(surfaces))
    places, segments, pair = sort_places_and_segments(local, segments, pair)
    return places, segments, pairs[pair]


def sort_segments(segments: np.ndarray, pair: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each segment of each pair once, lower point first, by pair, then points; and its pair."""
    rows = np.column_stack([pair, np.sort(segments, axis=1)])
    rows = rows[np.lexsort(rows.T[::-1])]
    rows = rows[np.append(True, (rows[1:] != rows[:-1]).any(axis=1))[: len(rows)]]
    return np.ascontiguousarray(rows[:, 1:]), rows[:, 0]


def sort_places_and_segments(
    x: np.ndarray, segments: np.ndarray, pair: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distinct positions of the points of segments, by coordinates; `sort_segments` of these."""
    used = np.zeros(len(x), dtype=bool)
    used[segments] = True
    points = np.flatnonzero(used)
    points = points[np.lexsort(x[points].T[::-1])]
    places = x[points]
    is_new = np.append(True, (places[1:] != places[:-1]).any(axis=1))[: len(places)]
    rank = np.empty(len(x), dtype=np.int64)
    rank[points] = np.cumsum(is_new) - 1
    return places[is_new], *sort_segments(rank[segments], pair)


def link(
    segments: np.ndarray, surfaces: np.ndarray, n_point: int
) -> tuple[tuple[np.ndarray, ...], np.ndarray, np.ndarray]:
    """Curves (rows of points), their surfaces, and which are closed.

    `segments` and `surfaces` come sorted by surfaces, as `canonical` leaves them.
    """
    if len(segments) == 0:
        empty = np.empty((0, 2), dtype=np.int64)
        return (), empty, np.empty(0, dtype=bool)

    # Where the pair of surfaces changes, the next group of segments begins.
    new = (surfaces[1:, 0] != surfaces[:-1, 0]) | (surfaces[1:, 1] != surfaces[:-1, 1])
    first = np.concatenate([[0], np.flatnonzero(new) + 1, [len(segments)]])
    points, offsets, pair = link_segments(segments, first, n_point)

    curves = tuple(points[a:b] for a, b in pairwise(offsets.tolist()))
    closed = points[offsets[:-1]] == points[offsets[1:] - 1]
    return curves, surfaces[first[pair]], closed


def total_cost(costs: Iterable[Mapping[str, int]]) -> dict[str, int]:
    """Sums of the counts of several searches, see `Contacts.cost`."""
    total: dict[str, int] = {}
    for cost in costs:
        for key, value in cost.items():
            total[key] = total.get(key, 0) + value
    return total


# ---- shared ----------------------------------------
# Read the curves of two rebuilt surfaces from their common edges.


def shared_curves(patches: Patches, first: str, second: str) -> Curves:
    """
    Read the curves of two surfaces off their rebuilt meshes.

    A torn sheet ends on its faults: its curves with them are where it ends, not where the mesh
    that was continued beyond them would cross.

    Parameters
    ----------
    patches : Patches
        Without what lies beyond the faults (`trim_sheets`).
    first, second : str
        Names of two surfaces that differ.

    Returns
    -------
    Curves
        Without touching points and overlap areas.

    Raises
    ------
    InputError
        If both are one.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[3, -9, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> shared_curves(rebuild_surfaces([flat, wall]), "Top", "F1").length
    6.0
    """
    if first == second:
        raise InputError(
            f"horizon {first!r} is torn, so it has no intersection lines with itself. Name "
            "a fault or another horizon."
        )

    # edges of the mesh that both surfaces own
    edges_of_first, edges_of_second = (
        patches.curve_edges_by_surface[patches.names.index(name)] for name in (first, second)
    )
    edges = patches.curve_edges[np.intersect1d(edges_of_first, edges_of_second, assume_unique=True)]
    segments = np.unique(np.sort(edges, axis=1), axis=0)
    # ends of these edges are points of the pieces: no node of a lattice is listed
    points, segments, pairs = canonical(
        patches.pieces.x, segments, np.tile([0, 1], (len(segments), 1))
    )
    curves, surfaces_of_curve, closed = link(segments, pairs, len(points))
    return Curves(
        names=(first, second),
        local=frozen(points, np.float64),
        origin=patches.origin,
        segments=frozen(segments, np.int64),
        surfaces_of_segment=frozen(pairs, np.int64),
        curves=tuple(frozen(curve, np.int64) for curve in curves),
        surfaces_of_curve=frozen(surfaces_of_curve, np.int64),
        closed=frozen(closed, np.bool_),
    )


# ---- collinear ----------------------------------------
# Split overlapping collinear segments, so that each part of a line occurs once.
#
# Neighbours in a mesh share whole edges, and their segments share whole ends. A mesh with corners
# in the middle of edges, or one that crosses itself in a line of the other surface, makes a curve
# twice: by segments that begin and end at different points of it. Each is split where another one
# of its pair of surfaces begins or ends, or touches; equal pieces are one then. Nearness is asked
# of floats with room to spare, what lies on a segment is decided exactly.
#
# A point of four faces A, B, C, D that ends the segment of C and D lies in the segment of A and B
# only if A meets D, and C meets B, in that point, too. So a segment is compared with the points
# that are known in its own two faces. A point that is found inside a segment is known in both
# faces from then on, and looked up in their other segments: in that way it reaches all segments
# that hold it. Hundreds of triangles that straddle one line up to the last digit have all their
# points near all their segments; compared are those with a face in common.


_REACH = 64 * ULP  # of the largest coordinate; rounding moves points by less than two
_LEAST = 1e-300  # so that nothing divides by 0 where all is at 0
_PAIR = 150  # bytes of a point beside a segment, through all steps
_NONE = np.empty(0, dtype=np.int64)


def split_overlaps(
    contacts: Contacts,
    segments: np.ndarray,
    surfaces: np.ndarray,
    touching: np.ndarray,
    in_faces: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Split segments at the points of their pair of surfaces that lie inside them.

    Parameters
    ----------
    contacts : Contacts
    segments : ndarray of int64, shape (n, 2)
        Rows of `Contacts.x`, once a pair, lower first: of contacts in a line.
    surfaces : ndarray of int64, shape (n, 2)
        Rows of the surfaces, sorted.
    touching : ndarray of int64, shape (n_touching, 3)
        Surfaces and point of contacts in a single point.
    in_faces : ndarray of int64, shape (n, 2), optional
        Faces, and points that lie in them, beyond the corners of contacts.

    Returns
    -------
    segments, surfaces : ndarray of int64
        Pieces may occur more than once.
    """
    if len(segments) == 0 or len(segments) + len(touching) < 2:
        return segments, surfaces

    groups = _groups(contacts, segments, surfaces, touching, in_faces)

    # Rows (segment, point): each point lies strictly inside its segment, decided exactly.
    hits = _inside(contacts, segments, groups)
    if len(hits) == 0:
        return segments, surfaces

    # Segments without a hit stay as they are.
    whole = np.ones(len(segments), dtype=bool)
    whole[hits[:, 0]] = False

    # A cut segment is listed with its two ends and its hits: one row of (segment, point) each.
    cut = np.flatnonzero(~whole)
    segment = np.concatenate([cut, cut, hits[:, 0]])
    on = np.concatenate([segments[cut, 0], segments[cut, 1], hits[:, 1]])

    # each coordinate rises or falls along a line, rounded ones as well: none alone tells the order
    way = np.sign(contacts.x[segments[segment, 1]] - contacts.x[segments[segment, 0]])
    order = np.lexsort((*(way * contacts.x[on]).T, segment))
    segment, on = segment[order], on[order]

    # Consecutive points of the same segment bound one piece of it.
    piece = np.flatnonzero(segment[1:] == segment[:-1])
    return (
        np.concatenate([segments[whole], np.stack([on[piece], on[piece + 1]], axis=1)]),
        np.concatenate([surfaces[whole], surfaces[segment[piece]]]),
    )


@dataclass
class _Groups:
    """Segments and points by the face of a pair of surfaces that they lie in.

    Attributes
    ----------
    n : int
        Groups are numbered from 0.
    lines : ndarray of int64, shape (n_line, 2)
        Group and row of a segment, sorted.
    points : ndarray of int64, shape (n_known, 2)
        Group and point (row of `Contacts.x`), sorted.
    faces : ndarray of int64, shape (n_segment, 2)
        Two faces that meet in each segment.
    """

    n: int
    lines: np.ndarray
    points: np.ndarray
    faces: np.ndarray


def _groups(
    contacts: Contacts,
    segments: np.ndarray,
    surfaces: np.ndarray,
    touching: np.ndarray,
    in_faces: np.ndarray | None,
) -> _Groups:
    """What lies in which face, by the contacts that the segments are of."""
    # A group is one face of one pair of surfaces: a face that meets two surfaces is in two groups.
    rows, n_surface, n_face = contacts.rows, len(contacts.surfaces), len(contacts.t)
    n, n_segment = len(contacts.x), len(segments)
    pair = pair_keys(contacts)
    pair_of_segment = surfaces[:, 0] * n_surface + surfaces[:, 1]
    two, segment = _of_segments(contacts, pair, segments, pair_of_segment)
    groups, group = number_keys((pair[two, None] * n_face + rows[two, :2]).ravel())

    # One key per (group, segment); each segment lies in two faces, so it has two groups.
    lines = _without(group * n_segment + np.repeat(segment, 2), _NONE)
    faces = np.empty((n_segment, 2), dtype=np.int64)
    faces[segment] = rows[two, :2]

    # points where segments of the pair begin, end or are touched, in each face that has some
    stops = np.concatenate([
        np.repeat(pair_of_segment, 2) * n + segments.ravel(),
        (touching[:, 0] * n_surface + touching[:, 1]) * n + touching[:, 2],
    ])  # fmt: skip

    # Candidates are the corners of contacts, by the two faces of each contact (-1: no such corner).
    mine = np.flatnonzero(is_among(pair, distinct(pair_of_segment)))
    corner = [(pair[mine], rows[mine, side], ids)
              for side in range(2) for ids in contacts.ids[mine].T]  # fmt: skip
    # Points known to lie inside a face come from an arrangement: both surfaces of the pair are one.
    if in_faces is not None:
        face, point = in_faces.T
        corner.append((contacts.surface_of_face[face] * (n_surface + 1), face, point))

    # A point counts only in groups that hold a segment, and only if it is a stop of its own pair.
    contact_pair, face, point = map(np.concatenate, zip(*corner, strict=True))
    key = contact_pair * n_face + face
    at = np.minimum(np.searchsorted(groups, key), len(groups) - 1)
    known = (groups[at] == key) & (point >= 0)
    known[known] = is_among(contact_pair[known] * n + point[known], distinct(stops))
    points = _without(at[known] * n + point[known], _NONE)

    # Keys are decoded to rows (group, segment) and (group, point).
    sorted_lines = np.stack(np.divmod(lines, n_segment), axis=1)
    return _Groups(len(groups), sorted_lines, np.stack(np.divmod(points, n), axis=1), faces)


def _of_segments(
    contacts: Contacts, pair: np.ndarray, segments: np.ndarray, pair_of_segment: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Contacts in a line (rows) that are among some segments, and the segment of each."""
    two = np.flatnonzero(n_corners(contacts.rows) == 2)

    # Points are numbered by pairs of ends, so that one integer key names a segment of a pair.
    ends = np.concatenate([segments, np.sort(contacts.ids[two, :2], axis=1)])
    _, number = number_keys(ends[:, 0] * len(contacts.x) + ends[:, 1])
    most = int(number.max()) + 1
    keys = pair_of_segment * most + number[: len(segments)]

    # Look up each contact among the segments; `segment` is a guess until the keys are compared.
    order = np.argsort(keys)
    asked = pair[two] * most + number[len(segments) :]
    segment = order[np.minimum(np.searchsorted(keys[order], asked), len(keys) - 1)]
    there = keys[segment] == asked
    return two[there], segment[there]


def _inside(contacts: Contacts, segments: np.ndarray, groups: _Groups) -> np.ndarray:
    """Rows (segment, point) of points that lie in a segment and are no end of it."""
    # Offsets of the segments of each group; `groups.lines` is sorted by group.
    n, n_segment = len(contacts.x), len(segments)
    first_line = np.searchsorted(groups.lines[:, 0], np.arange(groups.n + 1))

    # where a group has one segment only, what is found in that is of no use to another one
    several = groups.lines[np.diff(first_line)[groups.lines[:, 0]] > 1]
    by_segment = several[np.argsort(several[:, 1], kind="stable")]
    first_group = np.searchsorted(by_segment[:, 1], np.arange(n_segment + 1))

    # `known`, `new`, `tested`: sorted keys of (group, point) and (segment, point). A key is tested
    # only once, so the loop ends.
    known = groups.points[:, 0] * n + groups.points[:, 1]
    new, tested, all_hits = known, _NONE, [_NONE]
    while len(new):
        # Only the new points of each group are compared with its segments.
        group, point = np.divmod(new, n)
        first_point = np.searchsorted(group, np.arange(groups.n + 1))
        near = _near(contacts, segments, groups.lines[:, 1], first_line, point, first_point)
        near = _without(near[:, 0] * n + near[:, 1], tested)
        tested = np.concatenate([tested, near])
        hits = near[_lie_inside(contacts, segments, groups, *np.divmod(near, n))]
        all_hits.append(hits)

        # A hit makes the point known in every group of its segment, which may lead to further hits.
        segment, point = np.divmod(hits, n)
        count = first_group[segment + 1] - first_group[segment]
        of, row = ranges(first_group[segment], count)
        new = _without(by_segment[row, 0] * n + point[of], known)
        known = np.concatenate([known, new])
    return np.stack(np.divmod(np.concatenate(all_hits), n), axis=1)


def _without(keys: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Distinct keys, sorted, that are not among others (distinct): by sorts, numpy's fastest."""
    # The first of equal keys stays; the slice serves the empty array.
    keys = np.sort(keys)
    keys = keys[np.append(True, keys[1:] != keys[:-1])[: len(keys)]]
    if len(others) == 0 or len(keys) == 0:
        return keys
    others = np.sort(others)
    at = np.minimum(np.searchsorted(others, keys), len(others) - 1)
    return keys[others[at] != keys]


def _lie_inside(
    contacts: Contacts,
    segments: np.ndarray,
    groups: _Groups,
    segment: np.ndarray,
    point: np.ndarray,
) -> np.ndarray:
    """Whether points lie in segments and are no ends of them, exactly."""
    # Rows (point, end, end, face, face): the kernel takes the line as the meet of the two planes.
    rows = np.column_stack([point, segments[segment], groups.faces[segment]])
    out = np.empty(len(rows), dtype=np.int64)
    if len(rows):
        m = contacts.m.copy()
        inside_segments(contacts.x, contacts.t, contacts.e, contacts.d, m, contacts.w, rows, out)
    return out == 1


def _near(
    contacts: Contacts,
    segments: np.ndarray,
    lines: np.ndarray,
    first_line: np.ndarray,
    points: np.ndarray,
    first_point: np.ndarray,
) -> np.ndarray:
    """Rows (segment, point) of points next to a segment of their group that are none of its ends.

    `lines` are rows of `segments`.
    """
    x = contacts.x

    # Float distances only preselect; the reach exceeds what rounding can move a point.
    reach = _REACH * float(np.abs(x[segments]).max(initial=0.0)) + _LEAST
    pairs = np.empty((len(points) + 64, 2), dtype=np.int64)
    given = (x, segments[lines], first_line, points, first_point, reach)

    # The kernel counts all pairs and writes those that fit: one more call with room for all.
    n = points_near_segments(*given, pairs)
    if n > len(pairs):
        if lack_of_room(n * _PAIR) is not None:
            names = [surface.name for surface in contacts.surfaces]
            raise refusal(n, names, _PAIR, "pairs of points and segments that lie along one line")
        pairs = np.empty((n, 2), dtype=np.int64)
        points_near_segments(*given, pairs)
    pairs = pairs[:n]

    # The kernel numbers segments as listed by group; callers number them as in `segments`.
    pairs[:, 0] = lines[pairs[:, 0]]
    return pairs
