"""Cut the faces in contact: exact constrained triangulations of their points and segments."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise

import numpy as np

from geosurf.arrangement.search import Contacts
from geosurf.arrangement.threads import map_threads, n_threads, shortened
from geosurf.conventions import place
from geosurf.errors import InvariantError
from geosurf.kernels.cutting.cached_predicates import face_workspace
from geosurf.kernels.cutting.cut_faces import BROKEN, adopt_points, cut_faces, group_records
from geosurf.kernels.exact.constructed_points import FULL
from geosurf.kernels.exact.exact_signs import COLLISIONS, LIMBS, N_POINT, UNINDEXED

_MOST_CROSSINGS = 1 << 14  # room for points that may be made; it grows where that is too little
_RECORDS_OF_A_THREAD = 15_000  # 3 to 5 ms of work
_ALONE, _ONE_OF_SEVERAL = 2, 3  # work for a record that is the only one of its face, and for others
_NOTHING = np.empty(0, dtype=np.int64)


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
    """

    x: np.ndarray
    d: np.ndarray
    triangles: np.ndarray
    parent: np.ndarray
    cut: np.ndarray
    doubtful: np.ndarray
    collisions: int
    m: np.ndarray


def cut_contacts(contacts: Contacts) -> Children:
    """Triangulate all faces that have records.

    Raises
    ------
    InvariantError
        If a point does not lie in its own face: a broken promise of ours.
    """
    records = contacts.records
    n_face = len(contacts.t)
    sizes = np.bincount(records[:, 0], minlength=n_face) if len(records) else np.zeros(n_face, int)

    # k segments of one face cross in k * k / 4 points at most if they are of two sheets
    extra = 64 + min(int((sizes * sizes >> 2).sum()), _MOST_CROSSINGS + len(records) // 4)
    least = _RECORDS_OF_A_THREAD + len(contacts.x) // 16
    ends = list(pairwise(_divided(sizes, min(n_threads(), max(len(records) // least, 1)))))
    growth = 1
    while True:
        # large arrays are made here: a thread has a heap of its own, which begins empty
        parts, x, d = _rooms(contacts, [sizes[i:j] for i, j in ends], growth, growth * extra)
        rows = [(contacts, records, *row, one) for row, one in zip(ends, parts, strict=True)]
        map_threads(_cut_part, rows)
        if all(part.count != FULL for part in parts) and _joined(contacts, parts):
            break
        growth *= 4
    for part in parts:
        if part.count <= BROKEN:
            raise _broken(contacts, part.cut[BROKEN - part.count])

    # Only rows in use; the vertices come first, then the named points.
    first = parts[0]
    n_point, counts = int(first.m[N_POINT]), np.cumsum([0, *(part.count for part in parts)])
    doubtful = [part.doubtful + start for part, start in zip(parts, counts, strict=False)]
    triangles, parents = _closed_up(parts)
    return Children(
        shortened(x, contacts.n_vertex + n_point), shortened(d, n_point), triangles, parents,
        _one([part.cut for part in parts]), _one(doubtful), int(first.m[COLLISIONS]), first.m,
    )  # fmt: skip


@dataclass
class _Part:
    """Arrays of one call of `cut_faces`, see there; then its results, and the faces it has cut.

    All parts have the points of the contacts in common, and each has rows of its own for points
    that it makes, from the definition `first` on.
    """

    x: np.ndarray
    d: np.ndarray
    first: int
    m: np.ndarray
    w: np.ndarray
    names: np.ndarray
    places: np.ndarray
    n_local: int
    children: np.ndarray
    parents: np.ndarray
    count: int = 0
    doubtful: np.ndarray = field(default_factory=partial(np.empty, 0, np.int64))
    cut: np.ndarray = field(default_factory=partial(np.empty, 0, np.int64))


def _divided(sizes: np.ndarray, n_part: int) -> list[int]:
    """Where parts of about the same work begin, and the end, of faces with so many records."""
    if n_part == 1:
        return [0, len(sizes)]
    # a face with one segment needs no triangulation
    work = np.cumsum(np.where(sizes == 1, _ALONE, _ONE_OF_SEVERAL * sizes))
    inner = [int(np.searchsorted(work, work[-1] * k / n_part)) for k in range(1, n_part)]
    return [0, *inner, len(sizes)]


def _rooms(
    contacts: Contacts, sizes: list[np.ndarray], growth: int, extra: int
) -> tuple[list[_Part], np.ndarray, np.ndarray]:
    """Room to cut parts of the faces, with so many records each, and so many points for each part
    where segments cross; and the points and definitions of all parts.
    """
    # children of all parts lie in one array, to be closed up
    n, n_old, parts = len(contacts.x), len(contacts.d), []
    ends = np.cumsum([0, *(6 * int(size.sum()) + 4 * extra + 64 for size in sizes)]).tolist()
    children, parents = np.empty((ends[-1], 3), dtype=np.int64), np.empty(ends[-1], dtype=np.int64)

    # Points of old rows stay; room for crossings follows them and grows by four where it is too
    # little.
    x = np.empty((n + len(sizes) * extra, 3))
    d = np.empty((n_old + len(sizes) * extra, 4), dtype=np.int64)
    x[:n], d[:n_old] = contacts.x, contacts.d
    for k, (size, (begin, end)) in enumerate(zip(sizes, pairwise(ends), strict=True)):
        m = contacts.m.copy()
        m[N_POINT] = first = n_old + k * extra
        # Hash tables of the crossings, by name (the features that make them) and by place.
        names = np.empty((_table_size(extra), 5), dtype=np.int64)
        places = np.empty(_table_size(n + extra + 1) // 2, dtype=np.int64)  # two slots in each
        m[UNINDEXED] = n

        # The workspace is for the largest face; each point adds two children at most.
        most = min(extra, growth * (_MOST_CROSSINGS + 64))
        n_local = 2 * int(size.max(initial=0)) + most + 16
        w = face_workspace(int(m[LIMBS]), n_local)
        room = children[begin:end], parents[begin:end]
        own = x[: n + (k + 1) * extra]
        parts.append(_Part(own, d, first, m, w, names, places, n_local, *room))
    return parts, x, d


def _closed_up(parts: list[_Part]) -> list[np.ndarray]:
    """Children and their parents of all parts, without the room between these."""
    columns = []
    for name in ("children", "parents"):
        rows = [getattr(part, name)[: part.count] for part in parts]
        whole, end = rows[0].base, 0
        assert whole is not None
        for part_rows in rows:
            if end:
                whole[end : end + len(part_rows)] = part_rows
            end += len(part_rows)
        columns.append((whole, end))
    for part in parts:  # they look into what is shortened
        part.x = part.d = part.children = part.parents = _NOTHING
    return [shortened(whole, end) for whole, end in columns]


def _cut_part(contacts: Contacts, records: np.ndarray, low: int, high: int, part: _Part) -> None:
    """Cut faces `low` to `high` - 1."""
    records, offsets = group_records(records, low, high, len(contacts.x))
    part.cut = records[offsets[:-1], 0]
    part.count, part.doubtful = cut_faces(
        part.x, contacts.t, contacts.e, part.d, part.m, part.w, part.names, part.places,
        records, offsets, part.n_local, part.children, part.parents,
    )  # fmt: skip


def _joined(contacts: Contacts, parts: list[_Part]) -> bool:
    """Give points that parts have made the numbers of one call for all faces; False: no room."""
    first, n = parts[0], len(contacts.x)
    for part in parts[1:]:
        made = part.d[part.first : int(part.m[N_POINT])]
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
        corners[new] = ids.take(corners.take(new) - contacts.n_vertex - part.first)
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


def _table_size(n: int) -> int:
    """A power of two above twice the number of entries."""
    return 1 << max(4, int(2 * n + 2).bit_length())
