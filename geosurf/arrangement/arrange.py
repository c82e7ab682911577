"""Cut the faces in contact: exact constrained triangulations of their points and segments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.arrangement.search import Contacts, table_size
from geosurf.conventions import place
from geosurf.errors import InvariantError
from geosurf.kernels.cutting.cached_predicates import face_workspace
from geosurf.kernels.cutting.cut_faces import BROKEN, cut_faces
from geosurf.kernels.cutting.record_groups import group_records
from geosurf.kernels.exact.constructed_points import FULL
from geosurf.kernels.exact.exact_signs import COLLISIONS, LIMBS, N_POINT, UNINDEXED

_MOST_CROSSINGS = 1 << 14  # room for points that may be made; it grows where that is too little


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

    n, n_old = len(contacts.x), len(contacts.d)

    # k segments of one face cross in k * k / 4 points at most if they are of two sheets
    sizes = np.diff(offsets)
    extra = 64 + min(int((sizes * sizes // 4).sum()), _MOST_CROSSINGS + len(records) // 4)
    while True:
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
        n_local = 2 * int(sizes.max(initial=0)) + extra + 16

        # The workspace is for the largest face; each point adds two children at most.
        w = face_workspace(int(m[LIMBS]), n_local)
        children = np.empty((6 * len(records) + 4 * extra + 64, 3), dtype=np.int64)
        parents = np.empty(len(children), dtype=np.int64)

        count, doubtful = cut_faces(
            x, contacts.t, contacts.e, d, m, w, names, places, records, offsets, n_local,
            children, parents,
        )  # fmt: skip
        if count != FULL:
            break
        extra *= 4
    if count <= BROKEN:
        raise _broken(contacts, cut[BROKEN - count])

    # Only rows in use; the vertices come first, then the named points.
    n_point = int(m[N_POINT])
    return Children(
        x[: contacts.n_vertex + n_point], d[:n_point], children[:count], parents[:count], cut,
        doubtful, int(m[COLLISIONS]), m,
    )  # fmt: skip


def _broken(contacts: Contacts, face: int) -> InvariantError:
    """A point outside of its own face."""
    surface = contacts.surfaces[contacts.surface_of_face[face]]
    where = place(contacts.x[contacts.t[face, 0]] + contacts.origin)
    return InvariantError(
        f"triangle {contacts.row_of(face)} of surface {surface.name!r} at {where} could "
        "not be split along its curves; please report this with the surfaces."
    )
