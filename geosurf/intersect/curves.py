"""Find the intersection lines of surfaces, and link them to curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geosurf.arrangement.checked import check_surfaces
from geosurf.arrangement.search import Contacts, find_contacts
from geosurf.intersect.collinear import split_overlaps
from geosurf.intersect.link import (
    are_plain,
    canonical,
    canonical_by_keys,
    line_contacts,
    link,
    of_pairs,
    off_curves,
    pair_keys,
    pairs_of_rows,
    pairs_with_areas,
    total_cost,
    touching_points,
)
from geosurf.model import Curves, Touch, TriSurface, frozen
from geosurf.model.base import in_crs_of
from geosurf.model.expected import flag_of


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
    # Two graphs over the map cannot overlap and need no splitting: most scenes take this way.
    if are_plain(contacts):
        keys = pair_keys(contacts), len(names)
        sorted_all = canonical_by_keys(contacts.x, contacts.ids[:, :2], *keys)
        return _linked(names, contacts.origin, *sorted_all, [], contacts.cost)

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
        from geosurf.intersect.overlap import overlap_of  # with all of cutting, which few need

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


def merge_curves(
    names: tuple[str, ...],
    origin: np.ndarray,
    parts: Sequence[tuple[tuple[int, int], Curves]],
) -> Curves:
    """Put the curves of single pairs of surfaces together.

    Parameters
    ----------
    names : tuple of str
        Of all surfaces.
    origin : ndarray, shape (3,)
        Of the common frame [m].
    parts : sequence of ((int, int), Curves)
        Rows of `names` (lower first), and the curves of those two surfaces.

    Returns
    -------
    Curves
        As if all pairs had been intersected at once.
    """
    touches = [replace(touch, surfaces=pair) for pair, part in parts for touch in part.contacts]
    cost = total_cost(part.cost for _, part in parts)
    # Parts have origins of their own; all move to the common frame.
    local, segments, surfaces = (
        [np.empty((0, 3))],
        [np.empty((0, 2), int)],
        [np.empty((0, 2), int)],
    )
    n = 0
    for pair, part in parts:
        local.append(part.local + (part.origin - origin))
        segments.append(part.segments + n)
        surfaces.append(np.tile(pair, (len(part.segments), 1)))
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
    found: dict[tuple[int, int], list[Touch]] = {}
    pairs, places = off_curves(contacts.x, touching, points, segments, surfaces)

    # Touching points outside overlaps, then those of pairs that overlap somewhere.
    rows = list(zip(map(tuple, pairs.tolist()), places, strict=True))
    rows += [(pair, at) for pair, some in single.items() for at in np.unique(some, axis=0)]
    for pair, at in rows:
        found.setdefault(pair, []).append(Touch("point", pair, at[None] + contacts.origin))
    return [touch for pair in sorted(found) for touch in found[pair]]
