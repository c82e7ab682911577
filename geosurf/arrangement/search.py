"""Find all contacts of surfaces: candidate pairs, exact signs, named points.

`find_contacts` is what `intersect`, `rebuild` and the certificate all depend on. Surfaces pass one
room after the other: `trees` checks them, `candidates` lists the pairs of triangles that may meet,
`gather` copies their faces (welded, in the local frame) and decides how they meet, and here the
points get names. Only faces in contact are kept: all that comes later costs what they cost.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geosurf.arrangement.candidates import KnownPairs, find_candidates, is_torn
from geosurf.arrangement.gather import Faces, gather, settle
from geosurf.arrangement.threads import (
    CONTACT,
    IN_PLANE,
    in_ranges,
    lack_of_room,
    map_threads,
    refusal,
    shortened,
)
from geosurf.arrangement.trees import check_surfaces
from geosurf.arrangement.voxels import check_voxel_size
from geosurf.conventions import check_word, frame_origin, place
from geosurf.errors import InvariantError, SurfaceError
from geosurf.kernels.contacts.naming import (
    close_up_points,
    find_suspects,
    merge_suspects,
    name_corners,
    place_points,
    write_records,
)
from geosurf.kernels.contacts.triangle_contact import in_plane, n_corners, of_settled
from geosurf.kernels.exact.constructed_points import FULL
from geosurf.kernels.exact.exact_signs import (
    EXACT_ORIENT2D,
    N_EDGE_PLANE,
    N_NAME,
    N_POINT,
    N_VERTEX,
    SCALE,
)
from geosurf.kernels.exact.predicates import MAX_SCALE, VALID_SIZES, frame_of
from geosurf.model import TriSurface
from geosurf.model.expected import flag_of

METHODS = ("auto", "tree", "voxels")
_MANY_PAIRS = 1 << 20  # many more than the usual scene has
_POINTS_OF_A_THREAD, _SUSPECTS_OF_A_THREAD = 20_000, 4_000  # a millisecond of work each
_CONTACTS_OF_A_THREAD = 25_000  # 2 ms of work


@dataclass
class Contacts:
    """All contacts of some surfaces, and what is needed to decide more about them.

    Attributes
    ----------
    surfaces : tuple of TriSurface
    origin : ndarray, shape (3,)
        Of the local frame [m].
    x : ndarray of float64, shape (n, 3)
        Local coordinates: welded vertices of the faces, then constructed points.
    n_vertex : int
    t : ndarray of int64, shape (n_face, 3)
        Faces in contact or near one, as rows of `x`, surface by surface.
    surface_of_face, key_of_face : ndarray of int64, shape (n_face,)
        Where each face comes from; keys are rows of triangles, or `Lattice.corners_of_keys`.
    nodes : list of (ndarray, ndarray)
        For each surface its nodes in use, rising, and the rows of `x` where they are.
    rows : ndarray of int64, shape (n_contact, 3)
        Contacts by faces, see `geosurf.kernels.contacts.triangle_contact`.
    near : ndarray of int64, shape (n_near, 2)
        Pairs of faces whose signs hold, but could change if coordinates moved by a unit in the
        last place: what has to be looked at again once points are rounded. Of pairs whose contact
        no rounding can change, since they are apart by their boxes or by more than that next to a
        plane, or edges pass a face by more than that, one search lists some that another one
        does not; nothing else depends on it.
    ids : ndarray of int64, shape (n_contact, 2 or 6)
        Points of each contact, rows of `x`; six where some faces are coplanar.
    e, d, m, w : ndarray of int64
        Edge planes, definitions of points, and the frame: see `geosurf.kernels.exact.exact_signs`.
    slip : float
        By how much rounding may move a coordinate [m], of all faces that were candidates.
    filed : ndarray of int64, shape (n_record, 4), or None
        `records`, once they are made.
    cost : dict of str to int
        Of the search, by what was done.
    options : dict
        Of the search.
    """

    surfaces: tuple[TriSurface, ...]
    origin: np.ndarray
    x: np.ndarray
    n_vertex: int
    t: np.ndarray
    surface_of_face: np.ndarray
    key_of_face: np.ndarray
    nodes: list[tuple[np.ndarray, np.ndarray]]
    rows: np.ndarray
    near: np.ndarray
    ids: np.ndarray
    e: np.ndarray
    d: np.ndarray
    m: np.ndarray
    w: np.ndarray
    slip: float
    filed: np.ndarray | None = None
    cost: dict[str, int] = field(default_factory=dict)
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def records(self) -> np.ndarray:
        """What cuts which face, int64 (n_record, 4): see `geosurf.kernels.contacts.naming`.

        Curves do without, so it is made on first use.
        """
        if self.filed is None:
            self.filed = _records(
                self.x, self.t, self.e, self.m, self.w, self.rows, self.ids, n_coplanar=0
            )  # of contacts of which none is in a plane
        return self.filed

    def row_of(self, face: int) -> int:
        """Row of a face among the triangles of its surface."""
        surface = self.surfaces[self.surface_of_face[face]]
        return int(surface.rows_of_keys(self.key_of_face[face : face + 1])[0])


def find_contacts(
    surfaces: Sequence[TriSurface],
    *,
    method: str = "auto",
    voxel_size: float | None = None,
    self_intersections: bool = False,
    pairs: Sequence[tuple[int, int]] | None = None,
    origin: np.ndarray | None = None,
    known: KnownPairs | None = None,
) -> Contacts:
    """Find every pair of triangles that meet, with named points.

    Parameters
    ----------
    surfaces : sequence of TriSurface
    method : {"auto", "tree", "voxels"}
        How candidates are searched. Changes the cost, never the result.
    voxel_size : float, optional
        Edge of the search voxels [m]; fitted to the data if left out.
    self_intersections : bool
        Whether each surface is also searched for contacts with itself; torn sheets always are.
    pairs : sequence of (int, int), optional
        Only these pairs of surfaces (rows); default: all.
    origin : ndarray, shape (3,), optional
        Of the local frame [m]; default: from these surfaces. Points are rounded in that
        frame, so results to be combined take the same.
    known : KnownPairs, optional
        What earlier searches found of two surfaces: taken from there, and added to it.

    Returns
    -------
    Contacts

    Raises
    ------
    InputError
        For an unknown method, or if pairs of triangles are more than memory holds.
    """
    check_word(method, METHODS, f"method is {method!r}, expected one of {METHODS}.")
    check_voxel_size(voxel_size)
    self_intersections = flag_of(self_intersections, "self_intersections")
    surfaces = check_surfaces(surfaces)

    # The local frame: floats near 0 have more digits to spare.
    if origin is None:
        origin = frame_origin(*(surface.extent for surface in surfaces))
    if pairs is None:
        pairs = pairs_of(surfaces, self_intersections)
    voxels = method == "voxels" or (method == "auto" and voxel_size is not None)
    search = (voxels, voxel_size, origin.tobytes())
    stored = {} if known is None else known.among(pairs, *search)

    # Candidates by boxes, then their faces with common vertices, then exact signs and names.
    candidates, cost = find_candidates(surfaces, pairs, voxels, voxel_size, origin, stored)
    faces, face_pairs = gather(surfaces, candidates, origin)
    codes, slip = settle(faces, face_pairs, candidates)
    if known is not None:
        known.add(candidates, codes, slip, *search)
    contacts = _name_contacts(surfaces, origin, faces, face_pairs, codes, slip)
    contacts.cost = {**cost, "candidate_faces": len(faces.t), "pairs_meeting": len(contacts.rows)}
    contacts.options = {
        "method": method, "voxel_size": voxel_size, "pairs": pairs, "origin": origin
    }  # fmt: skip
    return contacts


def pairs_of(surfaces: Sequence[TriSurface], self_intersections: bool) -> list[tuple[int, int]]:
    """All pairs of surfaces, and each with itself where that is requested or it is torn."""
    n = len(surfaces)
    # a torn sheet is carried on past its faults, where its own walls may cross
    with_itself = [self_intersections or is_torn(surface) for surface in surfaces]
    return [(i, j) for i in range(n) for j in range(i, n) if i < j or with_itself[i]]


# ---- names ----------------------------------------
# Equal names are one point, whatever it is constructed from. They are numbered in the order of
# contacts, in one thread. All that follows is by ranges of points, or by parts of those that may be
# equal, in threads, with the results of one.


def _name_contacts(
    surfaces: tuple[TriSurface, ...],
    origin: np.ndarray,
    faces: Faces,
    pairs: np.ndarray,
    codes: np.ndarray,
    slip: float,
) -> Contacts:
    """The contacts of pairs of faces, with names for the faces in contact (and near) only."""
    # By faces, not as the search came across them: numbers are the same for any search.
    rows, near = (
        found[np.lexsort((found[:, 1], found[:, 0]))] for found in of_settled(pairs, codes)
    )
    # Faces that meet nothing are dropped: what follows costs what curves need.
    if len(rows) < len(pairs):
        faces = faces.in_contact(rows, near)

    # Stop before memory is exhausted. Contacts in a plane need most.
    x, t = faces.x, faces.t
    corners, flat = n_corners(rows), in_plane(rows)
    n_corner, n_coplanar = int(corners.sum()), int(np.count_nonzero(flat))
    n_area = int(np.count_nonzero(corners[flat] >= 3)) if len(rows) > _MANY_PAIRS else 0
    size = CONTACT + (IN_PLANE - CONTACT) * n_area // max(len(rows), 1)
    if lack_of_room(len(rows) * size) is not None:
        names = [surface.name for surface in surfaces]
        raise refusal(len(rows), names, size, "pairs of triangles that meet")

    m, w = frame_of(x, len(t))
    # Points are named with whole numbers, which have a largest scale.
    if m[SCALE] > MAX_SCALE:
        _refuse_tiny(surfaces, origin, faces)

    space = np.empty((len(x) + n_corner, 3))  # if each were a point of its own
    space[: len(x)] = x
    # Edge planes of coplanar faces: three edges of either face, so six per contact.
    e = np.zeros((6 * n_coplanar, 3), dtype=np.int64)
    d = np.empty((n_corner, 4), dtype=np.int64)
    ids = np.full((len(rows), 6 if n_coplanar else 2), -1, dtype=np.int64)

    # Names are found and points constructed in one pass; equal names are one point.
    n_point = name_points(space, t, e, d, m, w, rows, ids)
    _refuse_full(n_point)
    space, d = shortened(space, len(x) + n_point), shortened(d, n_point)
    # without coplanar faces, records need no more planes and are made when they are asked for
    records = _records(space, t, e, m, w, rows, ids, n_coplanar) if n_coplanar else None
    return Contacts(
        surfaces, origin, space, len(x), t, faces.surface, faces.key, faces.nodes, rows, near, ids,
        e[: int(m[N_EDGE_PLANE])], d, m, w, slip, records,
    )  # fmt: skip


def name_points(
    x: np.ndarray,
    t: np.ndarray,
    e: np.ndarray,
    d: np.ndarray,
    m: np.ndarray,
    w: np.ndarray,
    rows: np.ndarray,
    ids: np.ndarray,
) -> int:
    """
    Write the ids of all points of contact to rows of `ids`.

    Letters are those of `geosurf.kernels.contacts.naming`.

    Parameters
    ----------
    x, d : ndarray
        With room for one point per corner behind the vertices.
    t, e, m, w, rows, ids : ndarray

    Returns
    -------
    int
        The number of points, or FULL.
    """
    n = int(name_corners(x, t, e, d, m, w, rows, ids))
    if n in (FULL, 0):
        return n
    parts = in_ranges(n, _POINTS_OF_A_THREAD)
    _in_threads(place_points, (x, t, e, d), m, w, parts)

    # Corners alone: no point shares a bit with another point or with a corner.
    suspects, n_corner = find_suspects(x, t, m, rows)
    if len(suspects) == n_corner:
        return n
    same = m[N_VERTEX] + np.arange(n)
    n_part = len(in_ranges(len(suspects), _SUSPECTS_OF_A_THREAD))
    shares = [(suspects, k, n_part, same) for k in range(n_part)]
    if not any(_in_threads(merge_suspects, (x, t, e, d), m, w, shares)):
        return n
    close_up_points(x, d, m, same)
    flat = ids.reshape(-1)
    points = np.flatnonzero(flat >= m[N_VERTEX])
    flat[points] = same[flat[points] - m[N_VERTEX]]
    return int(m[N_POINT])


def _in_threads(
    work: Callable[..., Any],
    arrays: tuple[np.ndarray, ...],
    m: np.ndarray,
    w: np.ndarray,
    parts: Sequence[tuple],
) -> list[Any]:
    """Work on parts in threads, each with a frame of its own; add up what these have counted."""
    frames = [(m.copy(), w.copy()) for _ in parts]
    results = map_threads(
        work, [(*arrays, *frame, *part) for frame, part in zip(frames, parts, strict=True)]
    )
    counts = slice(EXACT_ORIENT2D, N_NAME)
    m[counts] += sum(counted[counts] - m[counts] for counted, _ in frames)
    return results


def _refuse_tiny(surfaces: Sequence[TriSurface], origin: np.ndarray, faces: Faces) -> None:
    """Say which surface has a coordinate with digits beyond those that points are made from."""
    # A coordinate that is not a multiple of the smallest unit has digits beyond.
    digits = faces.x * 2.0**MAX_SCALE
    vertex = np.flatnonzero((digits != np.floor(digits)).any(axis=1))[0]

    face = np.flatnonzero((faces.t == vertex).any(axis=1))[0]
    surface = surfaces[faces.surface[face]]
    where = faces.x[vertex] + origin
    value = faces.x[vertex, (digits[vertex] != np.floor(digits[vertex])).argmax()]
    raise SurfaceError(
        f"surface {surface.name!r} has a coordinate of {value:g} m at {place(where)}; "
        f"{VALID_SIZES}."
    )


def _records(
    x: np.ndarray,
    t: np.ndarray,
    e: np.ndarray,
    m: np.ndarray,
    w: np.ndarray,
    rows: np.ndarray,
    ids: np.ndarray,
    n_coplanar: int,
) -> np.ndarray:
    """What cuts which face; edge planes that are new are added to `e`."""
    # Two faces of each contact, and up to 18 more for edges of coplanar faces.
    records = np.empty((2 * len(rows) + 18 * n_coplanar, 4), dtype=np.int64)
    if n_coplanar:  # planes that are found later have later numbers
        n = write_records(x, t, e, m, w, rows, ids, records)
        _refuse_full(n)
        return shortened(records, n)

    # No contact needs planes, so any may come first: a range for each thread, with room of its own.
    ranges = in_ranges(len(rows), _CONTACTS_OF_A_THREAD)
    counts = map_threads(
        write_records,
        [(x, t, e, m.copy(), w, rows[i:j], ids[i:j], records[2 * i : 2 * j]) for i, j in ranges],
    )
    end = 0
    for (i, _), n in zip(ranges, counts, strict=True):
        if end < 2 * i:
            records[end : end + n] = records[2 * i : 2 * i + n]
        end += n
    return shortened(records, end)


def _refuse_full(n: int) -> None:
    if n == FULL:
        raise InvariantError("the tables of named points are too small; please report this.")
