"""Link contacts to curves: segments by pair of surfaces, joined at their end points.

Points are sorted by coordinates and curves by their points, so that the result does not
depend on the order in which surfaces, triangles or corners were given.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise

import numpy as np

from geosurf.arrangement.search import Contacts
from geosurf.kernels.contacts.packed_contact import in_plane, n_corners
from geosurf.kernels.meshes.chains import link_segments
from geosurf.kernels.meshes.linking import overlap_free, pairs_of_surfaces
from geosurf.kernels.meshes.mesh import weld
from geosurf.kernels.meshes.numbering import number_below


def pairs_of_rows(contacts: Contacts) -> np.ndarray:
    """Surface rows (lower first) of each contact, int64 (n_contact, 2)."""
    return np.stack(np.divmod(pair_keys(contacts), len(contacts.surfaces)), axis=1)


def pair_keys(contacts: Contacts) -> np.ndarray:
    """Pair of surfaces of each contact as one number, ``n_surface * lower + upper``."""
    n_surface = len(contacts.surfaces)
    keys: np.ndarray = pairs_of_surfaces(contacts.surface_of_face, contacts.rows, n_surface)
    return keys


def are_plain(contacts: Contacts) -> bool:
    """Whether contacts are segments of two surfaces each that cannot overlap.

    So nothing has to be split, and no segment is there twice: see `geosurf.kernels.meshes.linking`.
    """
    graphs = np.array([s.lattice is not None and s.lattice.is_graph for s in contacts.surfaces])
    of_face = contacts.surface_of_face
    return overlap_free(contacts.x, of_face, graphs, contacts.rows, contacts.ids) == 1


def line_contacts(contacts: Contacts, pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Segments (rows of `contacts.x`, once a pair) and their surfaces, from contacts in a line.

    A surface's own edges and corners are not contacts with itself.
    """
    two = np.flatnonzero(n_corners(contacts.rows) == 2)
    segments, surfaces = contacts.ids[two, :2], pairs[two]
    own = np.flatnonzero(surfaces[:, 0] == surfaces[:, 1])
    # A shared edge or corner of one surface: both ends are corners of both faces.
    if len(own):
        ends = segments[own, :, None]
        for side in range(2):
            corners = contacts.t[contacts.rows[two[own], side]]
            own = own[(ends == corners[:, None, :]).any(axis=2).all(axis=1)]
            ends = segments[own, :, None]
        others = np.ones(len(two), dtype=bool)
        others[own] = False
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
    found, number = number_below(keys, n_surface**2)
    return np.stack(np.divmod(found, n_surface), axis=1), number


def touching_points(contacts: Contacts, pairs: np.ndarray) -> np.ndarray:
    """Rows (surface, surface, point) of contacts in a single point, once each."""
    one = np.flatnonzero(n_corners(contacts.rows) == 1)
    if len(one) == 0:
        return np.empty((0, 3), dtype=np.int64)

    points, surfaces = contacts.ids[one, :1], pairs[one]
    own = surfaces[:, 0] == surfaces[:, 1]
    for side in range(2):
        t = contacts.t[contacts.rows[one, side]]
        own &= (points == t).any(axis=1)

    # Contacts of several faces may name the same point: once per pair of surfaces is enough.
    keys, n_surface = _keys(surfaces)
    pair, point = np.divmod(
        np.unique(keys[~own] * len(contacts.x) + points[~own, 0]), len(contacts.x)
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
    # Compared by place, since a curve may have another row for the same point.
    places = x[touching[:, 2]] + 0.0  # -0.0 is 0.0
    number, count = weld(np.concatenate([places, points]))
    pairs, _ = _keys(np.concatenate([touching[:, :2], surfaces]))

    # One key for pair and place; ends of the segments of the same pair drop out.
    mine = pairs[: len(touching)] * count + number[: len(touching)]
    ends = number[len(touching) :][segments]
    mine, first = np.unique(mine, return_index=True)
    of_segment = pairs[len(touching) :, None]
    first = first[~np.isin(mine, (of_segment * count + ends).ravel())]

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
    mask: np.ndarray = np.isin(keys[: len(surfaces)], keys[len(surfaces) :])
    return mask


def canonical(
    local: np.ndarray, segments: np.ndarray, surfaces: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points in use, sorted by coordinates; segments and surfaces renumbered and sorted."""
    return canonical_by_keys(local, segments, *_keys(surfaces))


def canonical_by_keys(
    local: np.ndarray, segments: np.ndarray, keys: np.ndarray, n_surface: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`canonical` for pairs of surfaces as numbers, see `pair_keys`."""
    pairs, pair = _numbered(keys, n_surface)
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
    points = np.unique(segments)
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
