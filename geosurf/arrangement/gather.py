"""Gather the faces that may meet, numbered, welded, in the local frame; and decide how they meet.

Candidates come as keys of triangles. Only they are looked up, so that what follows costs what
they cost; a lattice is never made a list of triangles for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.arrangement.candidates import Candidates
from geosurf.arrangement.threads import PAIR, in_ranges, lack_of_room, map_threads, refusal
from geosurf.arrangement.tree_pairs import ULP
from geosurf.kernels.contacts.triangle_contact import N_COLUMN, meet_pairs, pack_contacts, settled
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.mesh import number_keys, weld
from geosurf.model import TriSurface

_PAIRS_IN_THREADS = 15_000  # candidates of a scene: 2 ms of work
_PAIRS_OF_A_THREAD = 7_000  # 0.7 ms of exact signs; a thread costs a tenth of one
_AT_ONCE = 1 << 15  # pairs: room for their contacts, 3 MB, is used again and again

# where the candidates of two surfaces begin among all, the column of this surface, and they
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
        used, new_number = np.flatnonzero(in_use), np.cumsum(in_use) - 1
        nodes = []
        for surface_nodes, ids in self.nodes:
            rows_in_use = np.flatnonzero(in_use.take(ids))
            kept_ids = new_number.take(ids.take(rows_in_use))
            nodes.append((surface_nodes.take(rows_in_use), kept_ids))
        surface, key = self.surface.take(faces), self.key.take(faces)
        # `take` is many times as fast as an index in brackets where rows are short
        return Faces(self.x.take(used, axis=0), new_number[t], surface, key, nodes)


def gather(
    surfaces: Sequence[TriSurface], candidates: Sequence[Candidates], origin: np.ndarray
) -> tuple[Faces, np.ndarray]:
    """Faces in candidate pairs, and the pairs: rows of two faces."""
    n_pair = sum(len(pair.rows) for pair in candidates)
    if lack_of_room(n_pair * PAIR) is not None:
        raise refusal(n_pair, [surface.name for surface in surfaces])

    # Surfaces share no key and no node, so a thread takes whole surfaces, three times: faces in
    # use, then nodes of these, each numbered from 0 in its surface; then numbers in all.
    columns: list[list[_Column]] = [[] for _ in surfaces]
    start = 0
    for pair in candidates:
        columns[pair.i].append((start, 0, pair.rows))
        columns[pair.j].append((start, 1, pair.rows))
        start += len(pair.rows)
    worth = n_pair > _PAIRS_IN_THREADS
    numbered = map_threads(_number_faces, [(entries,) for entries in columns], worth)

    cut = np.cumsum([0] + [len(key) for key, _ in numbered])
    t = np.empty((cut[-1], 3), dtype=np.int64)
    corners = [t[i:j] for i, j in pairwise(cut)]
    nodes = map_threads(
        _number_nodes,
        [(surface, numbered[i][0], corners[i]) for i, surface in enumerate(surfaces)],
        worth,
    )

    first = np.cumsum([0] + [len(entries) for entries in nodes])
    places = np.empty((first[-1], 3))
    pairs = np.empty((n_pair, 2), dtype=np.int64)
    tasks = [
        (surface, nodes[i], origin, places[first[i] : first[i + 1]], corners[i], int(first[i]),
         columns[i], numbered[i][1], int(cut[i]), pairs)
        for i, surface in enumerate(surfaces)
    ]  # fmt: skip
    map_threads(_write_surface, tasks, worth)
    del tasks  # views of places, which become shorter

    # Nodes in one place become one vertex, so that contacts there have one name.
    key = np.concatenate([keys for keys, _ in numbered])
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


def _write_surface(
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
        distinct = np.empty((count, 3))
        distinct[number] = places  # of 0.0 and -0.0, which are equal, the last one remains
        return distinct, number
    return places, number


def settle(
    faces: Faces, pairs: np.ndarray, candidates: Sequence[Candidates]
) -> tuple[np.ndarray, float]:
    """How each candidate pair meets, and by how much coordinates could move by rounding [m]."""
    # One unit in the last place of the largest coordinate: closer pairs are listed as near.
    slip = ULP * float(np.abs(faces.x).max(initial=0.0))
    codes = np.empty(len(pairs), dtype=np.int64)
    is_new = np.ones(len(pairs), dtype=bool)
    start = 0
    for pair in candidates:
        stop = start + len(pair.rows)
        if pair.known is not None and pair.known.slip == slip:
            codes[start:stop], is_new[start:stop] = pair.known.codes, False
        start = stop

    waiting = np.flatnonzero(is_new)
    if len(waiting):
        frame = frame_of(faces.x, len(faces.t))
        ranges = in_ranges(len(waiting), _PAIRS_OF_A_THREAD)
        map_threads(_settle, [(faces, pairs, waiting[i:j], frame, slip, codes) for i, j in ranges])
    return codes, slip


def _settle(
    faces: Faces,
    pairs: np.ndarray,
    waiting: np.ndarray,
    frame: tuple[np.ndarray, np.ndarray],
    slip: float,
    codes: np.ndarray,
) -> None:
    """Write how some candidate pairs meet, see `settled`."""
    x, t, (m, w) = faces.x, faces.t, (counts.copy() for counts in frame)
    size = min(len(waiting), _AT_ONCE)
    rows, near = np.empty((size + 1, N_COLUMN), dtype=np.int64), np.empty(1024 + size // 16, int)
    for first in range(0, len(waiting), _AT_ONCE):
        part = waiting[first : first + _AT_ONCE]
        pairs_of_part = pairs.take(part, axis=0)
        # Room for near pairs is guessed; a second call has room for all.
        n, n_near = meet_pairs(x, t, pairs_of_part, m, w, slip, rows, near)
        if n_near > len(near):
            near = np.empty(n_near, dtype=np.int64)
            n, n_near = meet_pairs(x, t, pairs_of_part, m, w, slip, rows, near)
        codes[part] = settled(pairs_of_part, pack_contacts(rows[:n]), near[:n_near])
