"""Cut the faces in contact: exact constrained triangulations of their points and segments."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.arrangement.search import Contacts, table_size
from geosurf.arrangement.threads import map_threads, n_threads
from geosurf.conventions import place
from geosurf.errors import InvariantError
from geosurf.kernels.cutting.cached_predicates import face_workspace
from geosurf.kernels.cutting.cut_faces import BROKEN, adopt_points, cut_faces
from geosurf.kernels.cutting.record_groups import group_records
from geosurf.kernels.exact.constructed_points import FULL
from geosurf.kernels.exact.exact_signs import COLLISIONS, LIMBS, N_POINT, UNINDEXED

_MOST_CROSSINGS = 1 << 14  # room for points that may be made; it grows where that is too little
_RECORDS_OF_A_THREAD = 50_000  # 10 ms of work; each thread copies all points
_OF_A_RECORD = 8  # times the work of a face that has only one, each


@dataclass
class Children:
    """What cut faces became.

    Attributes
    ----------
    x : ndarray of float64, shape (n, 3)
        Local coordinates of all points: those of the contacts first.
    d : ndarray of int64, shape (n_constructed, 4)
        Definitions of the constructed points.
    triangles : ndarray of int64, shape (n_child, 3)
        Rows of `x`, oriented as their parents.
    parent : ndarray of int64, shape (n_child,)
        Face of the contacts (row of `Contacts.t`).
    cut : ndarray of int64, shape (n_cut,)
        The faces that were cut.
    doubtful : ndarray of int64, shape (n_doubtful,)
        Rows of `triangles` that doubles do not show to face as their parents once rounded.
    collisions : int
        Distinct points that rounding put in one place.
    n_thin : int
        Triangles that rounding could bring across others; -1 if that is not known.
    largest : float
        Largest local coordinate of the faces that were cut [m], where `n_thin` is known.
    """

    x: np.ndarray
    d: np.ndarray
    triangles: np.ndarray
    parent: np.ndarray
    cut: np.ndarray
    doubtful: np.ndarray
    collisions: int
    m: np.ndarray
    n_thin: int = -1
    largest: float = 0.0


def cut_contacts(contacts: Contacts, records: np.ndarray | None = None) -> Children:
    """Triangulate all faces that have records, or those in `records`.

    Raises
    ------
    InvariantError
        If a point does not lie in its own face: a broken promise of ours.
    """
    records = contacts.records if records is None else records
    records, offsets = group_records(records, len(contacts.t), len(contacts.x))
    cut = records[offsets[:-1], 0] if len(records) else np.empty(0, dtype=np.int64)

    # k segments of one face cross in k * k / 4 points at most if they are of two sheets
    sizes = np.diff(offsets)
    extra = 64 + min(int((sizes * sizes // 4).sum()), _MOST_CROSSINGS + len(records) // 4)
    n_part = min(n_threads(), max(len(records) // _RECORDS_OF_A_THREAD, 1))
    ends = _divided(sizes, n_part)
    while True:
        rows = [
            (contacts, records[offsets[i] : offsets[j]], offsets[i : j + 1] - offsets[i], extra)
            for i, j in pairwise(ends)
        ]
        parts = map_threads(_cut_part, rows)
        if all(part.count != FULL for part in parts) and _joined(contacts, parts):
            break
        extra *= 4
    for part, start in zip(parts, ends, strict=False):
        if part.count <= BROKEN:
            raise _broken(contacts, cut[start + BROKEN - part.count])

    # Only rows in use; the vertices come first, then the named points.
    first = parts[0]
    n_point, counts = int(first.m[N_POINT]), np.cumsum([0, *(part.count for part in parts)])
    doubtful = [part.doubtful + start for part, start in zip(parts, counts, strict=False)]
    triangles, parents = (
        [array[: part.count] for part, array in zip(parts, arrays, strict=True)]
        for arrays in ([part.children for part in parts], [part.parents for part in parts])
    )
    return Children(
        first.x[: contacts.n_vertex + n_point], first.d[:n_point], _one(triangles), _one(parents),
        cut, _one(doubtful), int(first.m[COLLISIONS]), first.m,
    )  # fmt: skip


@dataclass
class _Part:
    """Arrays of one call of `cut_faces`, see there; and its results."""

    x: np.ndarray
    d: np.ndarray
    m: np.ndarray
    w: np.ndarray
    names: np.ndarray
    places: np.ndarray
    children: np.ndarray
    parents: np.ndarray
    count: int
    doubtful: np.ndarray


def _divided(sizes: np.ndarray, n_part: int) -> list[int]:
    """Where parts of about the same work begin, and the end, of faces with so many records."""
    # a face with one segment needs no triangulation
    work = np.cumsum(np.where(sizes == 1, 1, _OF_A_RECORD * sizes))
    inner = [int(np.searchsorted(work, work[-1] * k / n_part)) for k in range(1, n_part)]
    return [0, *inner, len(sizes)]


def _cut_part(contacts: Contacts, records: np.ndarray, offsets: np.ndarray, extra: int) -> _Part:
    """Cut some faces, with room for so many points where their segments cross."""
    n, n_old = len(contacts.x), len(contacts.d)

    # Points of old rows stay; room for crossings follows them and grows by four where it is too
    # little.
    x = np.empty((n + extra, 3))
    x[:n] = contacts.x
    d = np.empty((n_old + extra, 4), dtype=np.int64)
    d[:n_old] = contacts.d
    m = contacts.m.copy()
    # Hash tables of the crossings, by name (the features that make them) and by place.
    names = np.empty((table_size(extra), 5), dtype=np.int64)
    places = np.empty(table_size(n + extra + 1), dtype=np.int64)
    m[UNINDEXED] = n

    # The workspace is for the largest face; each point adds two children at most.
    n_local = 2 * int(np.diff(offsets).max(initial=0)) + extra + 16
    w = face_workspace(int(m[LIMBS]), n_local)
    children = np.empty((6 * len(records) + 4 * extra + 64, 3), dtype=np.int64)
    parents = np.empty(len(children), dtype=np.int64)

    count, doubtful = cut_faces(
        x, contacts.t, contacts.e, d, m, w, names, places, records, offsets, n_local,
        children, parents,
    )  # fmt: skip
    return _Part(x, d, m, w, names, places, children, parents, count, doubtful)


def _joined(contacts: Contacts, parts: list[_Part]) -> bool:
    """Give points that parts have made the numbers of one call for all faces; False: no room."""
    first, n, n_old = parts[0], len(contacts.x), len(contacts.d)
    for part in parts[1:]:
        made = part.d[n_old : int(part.m[N_POINT])]
        if len(made) == 0 or part.count <= BROKEN:
            continue
        ids = adopt_points(
            first.x, contacts.t, contacts.e, first.d, first.m, first.w, first.names, first.places,
            made,
        )  # fmt: skip
        if ids[0] == FULL:
            return False
        corners = part.children[: part.count].reshape(-1)
        new = np.flatnonzero(corners >= n)
        corners[new] = ids.take(corners.take(new) - n)
    return True


def _one(arrays: list[np.ndarray]) -> np.ndarray:
    """Arrays one after the other; a single one as it is."""
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


def _broken(contacts: Contacts, face: int) -> InvariantError:
    """A point outside of its own face."""
    surface = contacts.surfaces[contacts.surface_of_face[face]]
    where = place(contacts.x[contacts.t[face, 0]] + contacts.origin)
    return InvariantError(
        f"triangle {contacts.row_of(face)} of surface {surface.name!r} at {where} could "
        "not be split along its curves; please report this with the surfaces."
    )
