"""Find all contacts of surfaces: candidate pairs, exact signs, named points.

`find_contacts` is what `intersect`, `rebuild` and the certificate all depend on. Only faces that
are candidates somewhere are copied (welded, in the local frame), and only those in contact
are kept; all that comes later costs what they cost.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geosurf.arrangement.candidates import (
    Known,
    KnownPairs,
    candidate_pairs,
    find_candidates,
    fit_voxels,
)
from geosurf.arrangement.gather import Faces, gather, name_contacts
from geosurf.arrangement.threads import (
    CONTACT,
    IN_PLANE,
    in_ranges,
    lack_of_room,
    map_threads,
    refusal,
    shortened,
)
from geosurf.arrangement.torn_trees import look_at_torn
from geosurf.arrangement.tree import look_at_list
from geosurf.conventions import check_word, frame_origin, is_number, place
from geosurf.errors import InputError, InvariantError, SurfaceError
from geosurf.kernels.contacts.naming import write_records
from geosurf.kernels.contacts.triangle_contact import (
    N_COLUMN,
    in_plane,
    meet_pairs,
    n_corners,
    of_settled,
    pack_contacts,
    settled,
)
from geosurf.kernels.exact.constructed_points import FULL
from geosurf.kernels.exact.exact_signs import N_EDGE_PLANE, SCALE
from geosurf.kernels.exact.predicates import (
    MAX_BITS,
    MAX_COORDINATE,
    MAX_SCALE,
    VALID_SIZES,
    flat_triangles,
    frame_of,
)
from geosurf.kernels.search.tree import fill_voxels, triangle_boxes
from geosurf.model import TriSurface, VoxelSearch
from geosurf.model.expected import flag_of, listed

# ---- checked ----------------------------------------
# Check surfaces before the search: what exact geometry has no answer for is refused.


# a number has 53 digits from its first one on: all numbers together need fewer than MAX_BITS
_FEW_DIGITS = 2.0 ** (MAX_BITS - 60)


def check_surfaces(surfaces: Sequence[TriSurface], least: int = 1) -> tuple[TriSurface, ...]:
    """Return the surfaces as a tuple, or raise an error that names the wrong one."""
    surfaces = tuple(listed(surfaces, "surfaces are expected", "give a list of TriSurface"))
    if len(surfaces) < least:
        raise InputError(f"{len(surfaces)} surfaces were passed; at least {least} are needed.")
    for i, surface in enumerate(surfaces):
        if not isinstance(surface, TriSurface):
            raise InputError(
                f"surface {i} is a {type(surface).__name__}, not a TriSurface. Convert it with "
                "triangulate_horizon or triangulate_fault."
            )
        # Checked once for each surface; surfaces are immutable.
        if not surface.checked:
            if surface.n_triangle == 0:
                raise SurfaceError(f"surface {surface.name!r} has no triangles; leave it out.")
            _check_triangles(surface)
            surface.checked = True
    return surfaces


def _check_triangles(surface: TriSurface) -> None:
    """Refuse what exact geometry has no answer for."""
    lattice = surface.lattice
    doubted, small = None, 0.0
    if lattice is not None:
        large = float(np.abs(lattice.survey.box).max())
    else:
        doubted, small, large = look_at_torn(surface) or look_at_list(surface)
    if large > MAX_COORDINATE:
        raise SurfaceError(
            f"surface {surface.name!r} has a coordinate of {large:g} m; the limit is "
            f"{MAX_COORDINATE:g} m. Replace undefined values by NaN."
        )

    # A lattice over the map has no vertical triangles and needs no exact test.
    if lattice is not None and lattice.is_graph:
        return  # no triangle stands upright; whether digits suffice is seen where it is used

    # No triangle is nearly flat, and the digits of all numbers fit: nothing is left to decide.
    if doubted is not None and len(doubted) == 0 and large < small * _FEW_DIGITS:
        return
    _refuse_flat(surface, doubted)


def _refuse_flat(surface: TriSurface, doubted: np.ndarray | None) -> None:
    """Refuse triangles without area among some rows (None: all), decided exactly."""
    x, t = surface.vertices, surface.triangles
    try:
        m, w = frame_of(x)
    except SurfaceError as error:
        raise SurfaceError(f"surface {surface.name!r}: {error}") from error
    if doubted is None:
        flat = flat_triangles(x, t, m, w)
    else:
        flat = doubted[flat_triangles(x, t[doubted], m, w)]

    if len(flat):
        where = place(x[t[flat[0], 0]])
        raise SurfaceError(
            f"surface {surface.name!r}: {len(flat)} of {surface.n_triangle} triangles have no "
            f"area, the first is triangle {flat[0]} at {where}. Remove them from the surface."
        )


def check_voxel_size(voxel_size: Any) -> None:
    """Refuse an edge of the search voxels that is not a length."""
    if voxel_size is not None and not (is_number(voxel_size) and voxel_size > 0):
        raise InputError(f"voxel_size is {voxel_size!r}; give a length in metres above 0.")


METHODS = ("auto", "tree", "voxels")
ULP = 2.0**-52
_MANY = 1 << 20  # pairs; many more than the usual scene has
_AT_ONCE = 1 << 15  # pairs: room for their contacts, 3 MB, is used again and again
_PAIRS_OF_A_THREAD = 7_000  # 0.7 ms of work; a thread costs a tenth of one
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
        origin = frame_origin(*(s.extent for s in surfaces))

    if pairs is None:
        pairs = pairs_of(surfaces, self_intersections)

    # Candidates by boxes, then their faces with common vertices, then exact signs and names.
    voxels = method == "voxels" or (method == "auto" and voxel_size is not None)
    how = (voxels, voxel_size, origin.tobytes())
    before = {} if known is None else {(i, j): known.of(i, j, *how) for i, j in pairs}
    held = {pair: one for pair, one in before.items() if one is not None}
    found, costs, cost = find_candidates(surfaces, pairs, voxels, voxel_size, origin, held)
    faces, candidates = gather(surfaces, found, origin)
    cost["candidate_faces"] = len(faces.t)

    codes, slip = _settle(faces, candidates, found, held)
    start = 0
    for i, j, rows in found:
        part = codes[start : start + len(rows)]
        was = held.get((i, j))
        if known is not None and (was is None or was.slip != slip):
            known.add(i, j, Known(rows, costs[i, j], slip, part.copy()), *how)
        start += len(rows)
    contacts = _name(surfaces, origin, faces, candidates, codes, slip)
    contacts.cost = {**cost, "pairs_meeting": len(contacts.rows)}
    contacts.options = {
        "method": method, "voxel_size": voxel_size, "pairs": pairs, "origin": origin
    }  # fmt: skip
    return contacts


def pairs_of(surfaces: Sequence[TriSurface], self_intersections: bool) -> list[tuple[int, int]]:
    """All pairs of surfaces, and each with itself where that is requested or it is torn."""
    n = len(surfaces)
    # a torn sheet is carried on past its faults, where its own walls may cross
    own = [self_intersections or "ghost" in s.vertex_data for s in surfaces]
    return [(i, j) for i in range(n) for j in range(i, n) if i < j or own[i]]


def table_size(n: int) -> int:
    """A power of two above twice the number of entries."""
    return 1 << max(4, int(2 * n + 2).bit_length())


def _settle(
    faces: Faces,
    pairs: np.ndarray,
    found: Sequence[tuple[int, int, np.ndarray]],
    held: Mapping[tuple[int, int], Known],
) -> tuple[np.ndarray, float]:
    """How each candidate pair meets, and by how much coordinates could move by rounding [m]."""
    # One unit in the last place of the largest coordinate: closer pairs are listed as near.
    slip = ULP * float(np.abs(faces.x).max(initial=0.0))
    codes = np.empty(len(pairs), dtype=np.int64)
    is_new = np.ones(len(pairs), dtype=bool)
    start = 0
    for i, j, rows in found:
        one, part = held.get((i, j)), slice(start, start + len(rows))
        if one is not None and one.slip == slip:
            codes[part], is_new[part] = one.codes, False
        start += len(rows)

    waiting = np.flatnonzero(is_new)
    if len(waiting):
        scale = frame_of(faces.x, len(faces.t))
        ranges = in_ranges(len(waiting), _PAIRS_OF_A_THREAD)
        map_threads(_meet, [(faces, pairs, waiting[i:j], scale, slip, codes) for i, j in ranges])
    return codes, slip


def _meet(
    faces: Faces,
    pairs: np.ndarray,
    waiting: np.ndarray,
    frame: tuple[np.ndarray, np.ndarray],
    slip: float,
    codes: np.ndarray,
) -> None:
    """Write how some candidate pairs meet, see `settled`."""
    x, t, (m, w) = faces.x, faces.t, (one.copy() for one in frame)
    size = min(len(waiting), _AT_ONCE)
    rows, near = np.empty((size + 1, N_COLUMN), dtype=np.int64), np.empty(1024 + size // 16, int)
    for first in range(0, len(waiting), _AT_ONCE):
        part = waiting[first : first + _AT_ONCE]
        some = pairs.take(part, axis=0)
        # Room for near pairs is guessed; a second call has room for all.
        n, n_near = meet_pairs(x, t, some, m, w, slip, rows, near)
        if n_near > len(near):
            near = np.empty(n_near, dtype=np.int64)
            n, n_near = meet_pairs(x, t, some, m, w, slip, rows, near)
        codes[part] = settled(some, pack_contacts(rows[:n]), near[:n_near])


def _name(
    surfaces: tuple[TriSurface, ...],
    origin: np.ndarray,
    faces: Faces,
    pairs: np.ndarray,
    codes: np.ndarray,
    slip: float,
) -> Contacts:
    """Names, for the faces in contact (and near) only."""
    # By faces, not as the search came across them: numbers are the same for any search.
    rows, near = (one[np.lexsort((one[:, 1], one[:, 0]))] for one in of_settled(pairs, codes))
    # Faces that meet nothing are dropped: what follows costs what curves need.
    if len(rows) < len(pairs):
        faces = faces.in_contact(rows, near)

    # Stop before memory is exhausted. Contacts in a plane need most.
    x, t = faces.x, faces.t
    corners, flat = n_corners(rows), in_plane(rows)
    n_corner, n_coplanar = int(corners.sum()), int(np.count_nonzero(flat))
    n_area = int(np.count_nonzero(corners[flat] >= 3)) if len(rows) > _MANY else 0
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
    n_point = name_contacts(space, t, e, d, m, w, rows, ids)
    _refuse_full(n_point)
    space, d = shortened(space, len(x) + n_point), shortened(d, n_point)
    # without coplanar faces, records need no more planes and are made when they are asked for
    records = _records(space, t, e, m, w, rows, ids, n_coplanar) if n_coplanar else None
    return Contacts(
        surfaces, origin, space, len(x), t, faces.surface, faces.key, faces.nodes, rows, near, ids,
        e[: int(m[N_EDGE_PLANE])], d, m, w, slip, records,
    )  # fmt: skip


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


def search_voxels(
    first: TriSurface, second: TriSurface, voxel_size: float | None = None
) -> VoxelSearch | None:
    """What the voxels find for two surfaces, for the picture that explains the search.

    Parameters
    ----------
    first, second : TriSurface
    voxel_size : float, optional
        Edge of the voxels [m]; fitted to the data if left out.

    Returns
    -------
    VoxelSearch or None
        None where the boxes of the surfaces do not meet.
    """
    surfaces = check_surfaces((first, second))

    # The same steps as in the search, but the filled voxels are handed out as well.
    origin = frame_origin(*(s.extent for s in surfaces))
    boxes = [triangle_boxes(s.vertices - origin, s.triangles) for s in surfaces]
    grid = fit_voxels(boxes[0], boxes[1], voxel_size)
    if grid is None:
        return None
    pairs, _ = candidate_pairs(boxes[0], boxes[1], size=voxel_size)

    held = []
    for rows, box in ((grid.rows_a, boxes[0]), (grid.rows_b, boxes[1])):
        offsets, _ = fill_voxels(box, rows, grid.bounds, grid.size, grid.shape)
        held.append(np.diff(offsets) > 0)
    occupied = np.stack(np.unravel_index(np.flatnonzero(held[0] & held[1]), grid.shape), axis=1)
    return VoxelSearch(
        lower=grid.bounds[:3] + origin,
        upper=grid.bounds[3:] + origin,
        n_cell=grid.shape,
        size=grid.size,
        occupied=occupied,
        faces_a=np.unique(pairs[:, 0]),
        faces_b=np.unique(pairs[:, 1]),
    )
