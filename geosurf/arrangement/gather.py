"""Gather the faces that may meet: numbered, welded, in the local frame.

Candidates come as keys of triangles. Only they are looked up, so that what follows costs what
they cost; a lattice is never made a list of triangles for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.arrangement.threads import PAIR, in_ranges, lack_of_room, map_threads, refusal
from geosurf.kernels.contacts.naming import (
    close_up_points,
    find_suspects,
    merge_suspects,
    name_corners,
    place_points,
)
from geosurf.kernels.exact.constructed_points import FULL
from geosurf.kernels.exact.exact_signs import EXACT_ORIENT2D, N_NAME, N_POINT, N_VERTEX
from geosurf.kernels.meshes.mesh import number_keys, weld
from geosurf.model import TriSurface

# ---- named ----------------------------------------
# Name the points of contacts, place them, and merge those that have several names.
#
# Names are numbered in the order of contacts, in one thread. All that follows is by ranges of
# points, or by parts of those that may be equal, in threads, with the results of one.


# least work of a thread: a millisecond each
_POINTS, _SUSPECTS, _CONTACTS = 20_000, 4_000, 100_000


def name_contacts(
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
    ranges = in_ranges(n, _POINTS)
    frames = [(m.copy(), w.copy()) for _ in ranges]
    map_threads(
        place_points, [(x, t, e, d, *own, i, j) for own, (i, j) in zip(frames, ranges, strict=True)]
    )
    _count(m, [own for own, _ in frames])

    # Corners alone: no point shares a bit with another point or with a corner.
    suspects, n_corner = find_suspects(x, t, m, rows)
    if len(suspects) == n_corner:
        return n
    same = m[N_VERTEX] + np.arange(n)
    parts = range(len(in_ranges(len(suspects), _SUSPECTS)))
    frames = [(m.copy(), w.copy()) for _ in parts]
    merged = map_threads(
        merge_suspects, [(x, t, e, d, *frames[k], suspects, k, len(parts), same) for k in parts]
    )
    _count(m, [own for own, _ in frames])
    if not any(merged):
        return n
    close_up_points(x, d, m, same)
    merged_ids = np.flatnonzero(ids.reshape(-1) >= m[N_VERTEX])
    flat = ids.reshape(-1)
    flat[merged_ids] = same[flat[merged_ids] - m[N_VERTEX]]
    return int(m[N_POINT])


def _count(m: np.ndarray, frames: list[np.ndarray]) -> None:
    """Add what threads have counted, each from the same counts on."""
    counts = slice(EXACT_ORIENT2D, N_NAME)
    m[counts] += sum(own[counts] - m[counts] for own in frames)


_PAIRS_IN_THREADS = 15_000  # candidates of a scene: 2 ms of work

# where the rows of a pair of surfaces begin in the table of all, a column of theirs, and they
_Column = tuple[int, int, np.ndarray]


@dataclass
class Faces:
    """Faces of some surfaces, with welded vertices.

    Attributes
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
        Local coordinates that differ from each other.
    t : ndarray of int64, shape (n_face, 3)
    surface, key : ndarray of int64, shape (n_face,)
        Where each face comes from; sorted by surface, then key.
    nodes : list of (ndarray, ndarray)
        For each surface its nodes in use, rising, and the rows of `x` where they are.
    """

    x: np.ndarray
    t: np.ndarray
    surface: np.ndarray
    key: np.ndarray
    nodes: list[tuple[np.ndarray, np.ndarray]]

    def in_contact(self, rows: np.ndarray, near: np.ndarray) -> Faces:
        """Return the faces of some contacts and near pairs, which get their numbers."""
        wanted = np.zeros(len(self.t), dtype=bool)
        wanted[rows[:, :2]] = True
        wanted[near] = True
        faces, number = np.flatnonzero(wanted), np.cumsum(wanted) - 1
        rows[:, :2], near[:] = number[rows[:, :2]], number[near]

        # vertices keep their order, too
        t = self.t.take(faces, axis=0)
        in_use = np.zeros(len(self.x), dtype=bool)
        in_use[t] = True
        used, of_vertex = np.flatnonzero(in_use), np.cumsum(in_use) - 1
        nodes = []
        for own, ids in self.nodes:
            some = np.flatnonzero(in_use.take(ids))
            nodes.append((own.take(some), of_vertex.take(ids.take(some))))
        surface, key = self.surface.take(faces), self.key.take(faces)
        # `take` is many times as fast as an index in brackets where rows are short
        return Faces(self.x.take(used, axis=0), of_vertex[t], surface, key, nodes)


def gather(
    surfaces: Sequence[TriSurface], found: Sequence[tuple[int, int, np.ndarray]], origin: np.ndarray
) -> tuple[Faces, np.ndarray]:
    """Faces in candidate pairs, and the pairs: rows of two faces."""
    n_pair = sum(len(rows) for _, _, rows in found)
    if lack_of_room(n_pair * PAIR) is not None:
        raise refusal(n_pair, [surface.name for surface in surfaces])

    # Surfaces share no key and no node, so a thread takes whole surfaces, three times: faces in
    # use, then nodes of these, each numbered from 0 in its surface; then numbers in all.
    columns: list[list[_Column]] = [[] for _ in surfaces]
    start = 0
    for i, j, rows in found:
        columns[i].append((start, 0, rows))
        columns[j].append((start, 1, rows))
        start += len(rows)
    of = range(len(surfaces))
    worth = n_pair > _PAIRS_IN_THREADS
    numbered = map_threads(_number_faces, [(columns[i],) for i in of], worth)

    cut = np.cumsum([0] + [len(key) for key, _ in numbered])
    t = np.empty((cut[-1], 3), dtype=np.int64)
    corners = [t[i:j] for i, j in pairwise(cut)]
    nodes = map_threads(
        _number_nodes, [(surfaces[i], numbered[i][0], corners[i]) for i in of], worth
    )

    first = np.cumsum([0] + [len(own) for own in nodes])
    places = np.empty((first[-1], 3))
    pairs = np.empty((n_pair, 2), dtype=np.int64)
    rows_of = [
        (surfaces[i], nodes[i], origin, places[first[i] : first[i + 1]], corners[i], int(first[i]),
         columns[i], numbered[i][1], int(cut[i]), pairs)
        for i in of
    ]  # fmt: skip
    map_threads(_write_own, rows_of, worth)
    del rows_of  # views of places, which become shorter

    # Nodes in one place become one vertex, so that contacts there have one name.
    key = np.concatenate([own for own, _ in numbered])
    surface = np.repeat(np.arange(len(surfaces)), np.diff(cut))
    x, row = _welded(places, t)
    ids = np.split(row, first[1:-1])
    return Faces(x, t, surface, key, list(zip(nodes, ids, strict=True))), pairs


def _number_faces(columns: Sequence[_Column]) -> tuple[np.ndarray, np.ndarray]:
    """Keys of the faces of a surface that are in use, and the number of each entry among them."""
    entries = [rows[:, column] for _, column, rows in columns]
    number = np.concatenate(entries) if entries else np.empty(0, dtype=np.int64)
    return number_keys(number)


def _number_nodes(surface: TriSurface, key: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Nodes of some faces of a surface; `corners` get their numbers."""
    if len(key) == 0:
        return np.empty(0, dtype=np.int64)
    nodes, number = number_keys(surface.corners_of_keys(key).ravel())
    corners[:] = number.reshape(-1, 3)
    return nodes


def _write_own(
    surface: TriSurface,
    nodes: np.ndarray,
    origin: np.ndarray,
    places: np.ndarray,
    corners: np.ndarray,
    first_node: int,
    columns: Sequence[_Column],
    number: np.ndarray,
    first_face: int,
    pairs: np.ndarray,
) -> None:
    """Write the places of nodes of a surface, and its numbers among all, to corners and pairs."""
    if len(nodes):
        places[:] = surface.places_of_nodes(nodes)
    for axis in range(3):  # column by column: along rows of three numpy takes five times as long
        places[:, axis] -= origin[axis]
    corners += first_node
    number += first_face
    done = 0
    for start, column, rows in columns:
        stop = start + len(rows)
        pairs[start:stop, column] = number[done : done + len(rows)]
        done += len(rows)


def _welded(places: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places that differ, and the row of each place among them; corners become such rows."""
    number, count = weld(places)
    if count < len(places):
        corners[:] = number[corners]
        own, places = places, np.empty((count, 3))
        places[number] = own  # of 0.0 and -0.0, which are equal, the last one remains
    return places, number
