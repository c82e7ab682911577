"""Contacts of a scene that differs in a few surfaces from an earlier one: only these are searched.

Pairs of surfaces that both scenes have meet as before. Their contacts are taken from the earlier
arrangement, those of all other pairs are searched, and both are merged, with the numbers that a
search of all pairs gives. Where numbers could be others, all pairs are merged as usual.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from geosurf.arrangement.earlier import Carried, Earlier, Unchanged, common_rows, with_crossings
from geosurf.arrangement.known_pairs import KnownPairs
from geosurf.arrangement.room import shortened
from geosurf.arrangement.search import Contacts, find_contacts, pairs_of
from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.kernels.compile.memory_pages import retain_more
from geosurf.kernels.contacts.merged_contacts import (
    filter_of,
    kept_contacts,
    mark_changed,
    mark_corners,
    may_coincide_with,
    merge_contacts,
    merge_faces,
    merge_nodes,
    move_faces,
    move_vertices,
)
from geosurf.kernels.contacts.packed_contact import sorted_by_faces
from geosurf.kernels.exact.exact_signs import COLLISIONS, N_EDGE_PLANE, N_POINT, SCALE
from geosurf.kernels.exact.predicates import MAX_SCALE, frame_of
from geosurf.kernels.meshes.mesh import weld
from geosurf.model import TriSurface

_MANY = 20_000  # earlier contacts, from which two threads merge them
_POINTS = 20_000  # of a thread, at least
_BYTES = 500  # of each triangle of pieces: two thirds of them are freed before a scene is complete
LEAST = 0.5  # share of the earlier contacts that has to stay: fewer are searched in less time


def find_changed_contacts(
    surfaces: Sequence[TriSurface],
    known: KnownPairs | None,
    *,
    origin: np.ndarray,
    voxel_size: float | None,
    self_intersections: bool,
) -> Contacts:
    """
    Find all contacts of some surfaces; what an earlier arrangement has of them is not searched.

    Parameters
    ----------
    surfaces, origin, voxel_size, self_intersections
        As for `find_contacts`, whose result this is, to the byte, apart from the cost.
    known : KnownPairs, or None
        Of the same surfaces. Without it all pairs are searched.

    Returns
    -------
    Contacts
        With ``carried`` if they come from an earlier arrangement.
    """
    options: dict[str, Any] = {
        "origin": origin, "voxel_size": voxel_size, "self_intersections": self_intersections,
        "known": known,
    }  # fmt: skip
    earlier: Earlier | None = None if known is None else known.arrangement()[0]
    if known is not None and earlier is not None and voxel_size is None:
        place = common_rows(earlier, known.keys, origin)
        found = None if place is None else _merged(earlier, place, surfaces, options)
        if found is not None:
            # changed scenes come and go: what one has left is what the next one needs
            retain_more(_BYTES * len(earlier.kept.face))
            return found
    return find_contacts(surfaces, **options)


def _merged(
    old: Earlier, place: np.ndarray, surfaces: Sequence[TriSurface], options: dict[str, Any]
) -> Contacts | None:
    """Contacts from an earlier arrangement and a search of the other pairs; None if not possible.

    `place` has the new row of each earlier surface, or -1.
    """
    surface0 = place[old.surface_of_face]
    kept, used = kept_contacts(old.rows, old.near, surface0 >= 0)
    if kept.sum() <= LEAST * len(old.rows):
        return None
    common = np.zeros(len(surfaces), dtype=bool)
    common[place[place >= 0]] = True

    # pairs of common surfaces are the same in both
    pairs = pairs_of(surfaces, options["self_intersections"])
    both = [tuple(pair) for pair in place[np.array(old.pairs).reshape(-1, 2)].tolist()]
    stay = [pair for pair in pairs if common[pair[0]] and common[pair[1]]]
    if sorted(pair for pair in both if min(pair) >= 0) != stay:
        return None
    asked = [pair for pair in pairs if not (common[pair[0]] and common[pair[1]])]
    if not asked:
        return None
    for pair in stay:  # stored contacts of these pairs are in use: later scenes may need them
        options["known"].of(*pair, False, None, options["origin"].tobytes())
    given = {key: value for key, value in options.items() if key != "self_intersections"}
    new = find_contacts(surfaces, pairs=asked, **given)

    # equal points, and pairs that rounding could change, are judged in the whole arrangement
    flat = new.ids.shape[1] != 2
    if flat or new.slip != old.slip or new.m[COLLISIONS] or old.collisions:
        return None
    return _numbered(old, place, kept, used, new, common, pairs)


def _numbered(
    old: Earlier,
    place: np.ndarray,
    kept: np.ndarray,
    used: np.ndarray,
    new: Contacts,
    common: np.ndarray,
    pairs: list[tuple[int, int]],
) -> Contacts | None:
    """Both in one numbering; None if it could differ from that of a search of all pairs."""
    # faces by surface and key
    surface0 = place[old.surface_of_face]
    face0, face1, n_face = merge_faces(
        surface0, old.key_of_face, used, new.surface_of_face, new.key_of_face
    )

    # vertices by surface and node
    mark = np.zeros(len(old.x), dtype=bool)
    mark_corners(old.t, used, mark)
    point0 = np.full(len(old.x), -1, dtype=np.int64)
    point1 = np.full(len(new.x), -1, dtype=np.int64)
    of, *listed = _listed(old.nodes)
    of_surface, node, vertex, n_vertex = merge_nodes(
        place[of], *listed, *_listed(new.nodes), mark, ~common, point0, point1
    )
    numbers = point0[point0 >= 0]
    if n_vertex < 0 or (np.diff(numbers) <= 0).any():  # children depend on the order of vertices
        return None
    cut = np.searchsorted(of_surface, np.arange(1, len(common)))
    nodes = list(zip(np.split(node, cut), np.split(vertex, cut), strict=True))
    t = np.empty((n_face, 3), dtype=np.int64)
    surface, key = np.empty(n_face, dtype=np.int64), np.empty(n_face, dtype=np.int64)

    # contacts by faces, points as they come; the rows of both are written side by side
    n = len(old.d) + len(new.d)
    x, d = np.empty((n_vertex + n, 3)), np.empty((n, 4), dtype=np.int64)
    changed = np.zeros(n_face, dtype=bool)
    merged = (
        old.rows, old.ids, kept, face0, point0, old.d, old.n_vertex, old.x,
        new.rows, new.ids, face1, point1, new.d, new.n_vertex, new.x, n_vertex, x, d,
    )  # fmt: skip

    def move() -> None:
        """Write the faces and vertices, which do not depend on the points that are numbered."""
        vertex0, vertex1 = point0[: old.n_vertex], point1[: new.n_vertex]
        move_faces(old.t, surface0, old.key_of_face, face0, vertex0, t, surface, key)
        move_faces(new.t, new.surface_of_face, new.key_of_face, face1, vertex1, t, surface, key)
        move_vertices(old.x, vertex0, old.n_vertex, x)
        move_vertices(new.x, vertex1, new.n_vertex, x)
        # faces that gain a contact, or lose one, are cut again
        mark_changed(old.rows, kept, face0, new.rows, face1, changed)

    worth = len(old.rows) > _MANY
    (rows, ids, n_point), _ = map_threads(
        lambda task: task(), [(partial(merge_contacts, *merged),), (move,)], worth
    )
    if n_point < 0:
        return None
    x, d = shortened(x, n_vertex + n_point), shortened(d, n_point)

    def frame() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Near pairs, and the frame of the vertices."""
        near = old.near[(face0[old.near] >= 0).all(axis=1)]
        near = np.concatenate([face0[near], face1[new.near]])
        return sorted_by_faces(near, n_face), *frame_of(x[:n_vertex], n_face)

    coinciding, (near, m, w) = _beside_new_points(x, point0, point1, frame, worth)
    if coinciding or m[SCALE] > MAX_SCALE:
        return None
    m[N_POINT], m[N_EDGE_PLANE] = n_point, 0

    found = Contacts(
        new.surfaces, new.origin, x, n_vertex, t, surface, key, nodes, rows,
        near, ids, new.e, d, m, w, new.slip,
        cost={**new.cost, "pairs_meeting": len(rows)}, options={**new.options, "pairs": pairs},
    )  # fmt: skip

    found.carried = Carried(old, with_crossings(old, Unchanged(place, face0, point0, changed)))
    return found


def _beside_new_points(
    x: np.ndarray, point0: np.ndarray, point1: np.ndarray, task: Callable[[], Any], worth: bool
) -> tuple[bool, Any]:
    """Whether a new point and another one are in one place, and what a task beside that returns.

    They may be one point, or two that rounding puts there.
    """
    is_new = np.zeros(len(x), dtype=bool)
    is_new[point1] = True
    is_new[point0[point0 >= 0]] = False
    filled, size = filter_of(x, is_new)
    tasks: list[Callable[[], Any]] = [
        partial(may_coincide_with, x, is_new, filled, size, *row)
        for row in in_ranges(len(x), _POINTS)
    ]
    asked = [(one,) for one in (*tasks, task)]
    *of_points, found = map_threads(lambda one: one(), asked, worth)
    some = x.take(np.concatenate(of_points), axis=0)
    return weld(some)[1] < len(some), found


def _listed(nodes: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, ...]:
    """Surface, node and vertex of each node of all surfaces."""
    of = np.repeat(np.arange(len(nodes)), [len(some) for some, _ in nodes])
    return of, *(np.concatenate([one[k] for one in nodes]) for k in range(2))
