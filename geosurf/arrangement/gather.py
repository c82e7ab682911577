"""Gather the faces that may meet: numbered, welded, in the local frame.

Candidates come as keys of triangles. Only they are looked up, so that what follows costs what
they cost; a lattice is never made a list of triangles for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.arrangement import tree
from geosurf.arrangement.aligned import needed, of_one_map, pairs_of_one_map
from geosurf.arrangement.broad import candidate_pairs
from geosurf.arrangement.chunked import is_chunked, pairs_by_tiles
from geosurf.arrangement.hubs import hubs_of, pairs_around_hubs
from geosurf.arrangement.known_pairs import Known
from geosurf.arrangement.lattice_maps import pairs_over_lattice
from geosurf.arrangement.memory_limit import PAIR, TooManyPairs, lack_of_room, refusal
from geosurf.arrangement.threads import map_threads
from geosurf.arrangement.torn import is_torn, over_itself, pairs_with_itself
from geosurf.arrangement.torn_trees import candidate_pairs as candidate_pairs_of
from geosurf.arrangement.torn_trees import separated_by_tops, tree_for
from geosurf.arrangement.upright import are_alike, settled_pairs
from geosurf.kernels.contacts.axis_grids import NEEDS_EXACT
from geosurf.kernels.contacts.merging import may_coincide
from geosurf.kernels.contacts.used_faces import number_faces, select_faces, select_nodes
from geosurf.kernels.meshes.mesh import weld
from geosurf.kernels.meshes.numbering import number_in_place
from geosurf.model import TriSurface

_FEW = 4  # pairs of surfaces; to ask a few one by one costs no more than asking tops
_PAIRS_IN_THREADS = 50_000  # candidates of a scene: 5 ms of work

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
        number, n = number_faces(rows, near, len(self.t))
        t = np.empty((n, 3), dtype=np.int64)
        surface, key = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
        of_vertex, used = select_faces(
            self.t, self.surface, self.key, number, len(self.x), t, surface, key
        )
        nodes = [select_nodes(*own, of_vertex) for own in self.nodes]
        # `take` is many times as fast as an index in brackets where rows are short
        return Faces(self.x.take(used, axis=0), t, surface, key, nodes)


def find_candidates(
    surfaces: Sequence[TriSurface],
    pairs: Sequence[tuple[int, int]],
    voxels: bool,
    voxel_size: float | None,
    origin: np.ndarray,
    known: Mapping[tuple[int, int], Known] | None = None,
) -> tuple[
    list[tuple[int, int, np.ndarray]], dict[tuple[int, int], dict[str, int]], dict[str, int]
]:
    """Candidate pairs of keys for each pair of surfaces, and what they cost, each and in all.

    Rows of two keys, and of codes where these are known: see `geosurf.arrangement.upright`. What
    `known` has is not searched.
    """
    found = []
    known = known or {}
    costs = {}
    cost = {"voxels": 0, "nodes": 0, "candidate_faces": 0, "pairs_tested": 0}

    # a graph has one elevation for each place in the map: it cannot meet itself
    wanted = [(i, j) for i, j in pairs if i != j or not _is_graph(surfaces[i])]
    if voxels:
        boxes = [tree.boxes_of(s) for s in surfaces]
    else:
        trees = [tree_for(s) for s in surfaces]
        asked = [pair for pair in wanted if pair not in known]
        near = {*known, *near_surfaces(surfaces, asked)}
        cost["nodes"] += len(wanted) - len(near)
        wanted = [pair for pair in wanted if pair in near]

    def search(i: int, j: int) -> tuple[np.ndarray, dict[str, int]]:
        """Candidates of one pair of surfaces, and what finding them cost."""
        # A torn sheet or a fan has its own search: neighbours by the thousand are near one another.
        if i == j and not is_torn(surfaces[i]):
            around = hubs_of(surfaces[i])
            if len(around[1]):
                return pairs_around_hubs(surfaces[i], *around)

        if i == j and not voxels and is_torn(surfaces[i]):
            return pairs_with_itself(surfaces[i], origin)
        one_map = i != j and of_one_map(surfaces[i], surfaces[j])
        if not voxels:
            if i == j:
                return tree.candidate_pairs(*[tree.tree_of(surfaces[i])] * 2, same=True)
            both: Any = (surfaces[i], surfaces[j]), (trees[i], trees[j])
            if not (is_chunked(surfaces[i]) or is_chunked(surfaces[j])):
                return _pairs_of_two(one_map, origin, both[1], *both)
            # next to a hole, pairs of cells count that may be in different tiles
            one_map = one_map and all(one.lattice.whole for one in both[0] if one.lattice)
            return pairs_by_tiles(
                both[0], both[1], one_map, partial(_pairs_of_two, one_map, origin, both[1])
            )

        # both surfaces have one where they share a map
        lattices: Any = surfaces[i].lattice, surfaces[j].lattice
        rows, spent = candidate_pairs(boxes[i], boxes[j], size=voxel_size, same=i == j)
        keys = [_keys_of_rows(surfaces[s], rows[:, k]) for k, s in enumerate((i, j))]
        rows = np.stack(keys, axis=1)
        if i == j and is_torn(surfaces[i]):
            rows = rows[over_itself(surfaces[i], rows, origin)]
        return (rows[needed(lattices[0], lattices[1], rows[:, :2])] if one_map else rows), spent

    def searched(i: int, j: int) -> tuple[np.ndarray, dict[str, int]]:
        """`search`, with the names of the surfaces where there is no room for their pairs."""
        try:
            return search(i, j)
        except TooManyPairs as error:
            raise refusal(error.n, [surfaces[i].name, surfaces[j].name]) from error

    # Results come in the order of the pairs, whatever thread found them first.
    asked = [pair for pair in wanted if pair not in known]
    searches = dict(zip(asked, map_threads(searched, asked), strict=True))
    for i, j in wanted:
        one = known.get((i, j))
        rows, spent = searches[i, j] if one is None else (one.rows, one.spent)
        costs[i, j] = spent
        for key, value in spent.items():
            cost["pairs_tested" if key == "pairs" else key] += value
        found.append((i, j, rows))
    return found, costs, cost


def _pairs_of_two(
    one_map: bool,
    origin: np.ndarray,
    wholes: tuple[Any, Any],
    surfaces: tuple[TriSurface, TriSurface],
    trees: tuple[Any, Any],
) -> tuple[np.ndarray, dict[str, int]]:
    """Candidates of two surfaces, or of windows of them; `wholes` are the trees of whole ones."""
    if one_map:
        lattices: Any = surfaces[0].lattice, surfaces[1].lattice
        return pairs_of_one_map(lattices, trees, wholes)
    torn = pairs_over_lattice(surfaces, origin)
    if torn is not None:
        return torn
    if are_alike(surfaces, trees):
        return settled_pairs(surfaces, trees, origin)
    return candidate_pairs_of(*trees)


def near_surfaces(
    surfaces: Sequence[TriSurface], pairs: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Those of some pairs of surfaces whose trees meet, by their boxes and their tops.

    Tops are not asked where two grids share a map: those count as near.
    """
    # Boxes around whole surfaces first, since they cost least.
    trees: list[Any] = [tree_for(s) for s in surfaces]
    apart = tree.apart(trees).tolist()
    near = [(i, j) for i, j in pairs if i == j or not apart[i][j]]
    asked = [(i, j) for i, j in near if i != j and not of_one_map(surfaces[i], surfaces[j])]
    if len(asked) <= _FEW:
        return near

    # Then the upper levels of the trees, for all pairs in one call.
    by_crowns = separated_by_tops(trees, np.array(asked)).tolist()
    far = {pair for pair, is_far in zip(asked, by_crowns, strict=True) if is_far}
    return [pair for pair in near if pair not in far]


def meeting_surfaces(
    surfaces: Sequence[TriSurface], pairs: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Those of `near_surfaces`, without small surfaces of which no two triangles are near.

    To search them here costs a fifth of a search by `find_contacts` that finds nothing.
    """
    trees = [tree_for(s) for s in surfaces]

    def meet(i: int, j: int) -> bool:
        if i == j or not (trees[i].is_small and trees[j].is_small):
            return True
        return len(candidate_pairs_of(trees[i], trees[j])[0]) > 0

    return [(i, j) for i, j in near_surfaces(surfaces, pairs) if meet(i, j)]


def _is_graph(surface: TriSurface) -> bool:
    return surface.lattice is not None and surface.lattice.is_graph


def _keys_of_rows(surface: TriSurface, rows: np.ndarray) -> np.ndarray:
    return rows if surface.lattice is None else surface.lattice.keys_of_rows(rows)


def gather(
    surfaces: Sequence[TriSurface], found: Sequence[tuple[int, int, np.ndarray]], origin: np.ndarray
) -> tuple[Faces, np.ndarray]:
    """Faces in candidate pairs, and the pairs: rows of two faces, and codes or OPEN."""
    n_pair = sum(len(rows) for _, _, rows in found)
    if lack_of_room(n_pair * PAIR) is not None:
        raise refusal(n_pair, [surface.name for surface in surfaces])

    # Surfaces share no key and no node, so a thread takes whole surfaces, three times: faces in use,
    # then nodes of these, each numbered from 0 in its surface; then numbers in all.
    columns: list[list[_Column]] = [[] for _ in surfaces]
    start = 0
    for i, j, rows in found:
        columns[i].append((start, 0, rows))
        columns[j].append((start, 1, rows))
        start += len(rows)
    of = range(len(surfaces))
    worth = n_pair > _PAIRS_IN_THREADS
    numbered = map_threads(_number_faces, [(surfaces[i], columns[i]) for i in of], worth)

    cut = np.cumsum([0] + [len(key) for key, _ in numbered])
    t = np.empty((cut[-1], 3), dtype=np.int64)
    corners = [t[i:j] for i, j in pairwise(cut)]
    nodes = map_threads(
        _number_nodes, [(surfaces[i], numbered[i][0], corners[i]) for i in of], worth
    )

    first = np.cumsum([0] + [len(own) for own in nodes])
    places = np.empty((first[-1], 3))
    pairs = np.empty((n_pair, 3), dtype=np.int64)
    rows_of = [
        (surfaces[i], nodes[i], origin, places[first[i] : first[i + 1]], corners[i], int(first[i]),
         columns[i], numbered[i][1], int(cut[i]), pairs)
        for i in of
    ]  # fmt: skip
    map_threads(_write_own, rows_of, worth)

    # Nodes in one place become one vertex, so that contacts there have one name.
    key = np.concatenate([own for own, _ in numbered])
    surface = np.repeat(np.arange(len(surfaces)), np.diff(cut))
    x, t, point = _welded(places, t)
    ids = np.split(point, first[1:-1])
    return Faces(x, t, surface, key, list(zip(nodes, ids, strict=True))), pairs


def _number_faces(
    surface: TriSurface, columns: Sequence[_Column]
) -> tuple[np.ndarray, np.ndarray]:
    """Keys of the faces of a surface that are in use, and the number of each entry among them."""
    entries = [rows[:, column] for _, column, rows in columns]
    number = np.concatenate(entries) if entries else np.empty(0, dtype=np.int64)
    return number_in_place(number[:, np.newaxis], 1, _key_limits(surface)[0]), number


def _number_nodes(surface: TriSurface, key: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Nodes of some faces of a surface; `corners` get their numbers."""
    if len(key) == 0:
        return np.empty(0, dtype=np.int64)
    corners[:] = surface.corners_of_keys(key)
    return number_in_place(corners, 3, _key_limits(surface)[1])


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
        if column == 0:  # the third is the code of the contact, where the search knows it
            pairs[start:stop, 2] = rows[:, 2] if rows.shape[1] > 2 else NEEDS_EXACT


def _welded(places: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places that differ, the corners as rows of them, and the row of each place."""
    # A sort of all places costs more than a look at those that may be equal, which are few.
    some = may_coincide(places)
    own = places.take(some, axis=0)
    number, count = weld(own)
    if count == len(some):
        return places, corners, np.arange(len(places))

    # The first place of several stays.
    first = np.empty(count, dtype=np.int64)
    first[number[::-1]] = some[::-1]
    of = first[number]
    stays = np.ones(len(places), dtype=bool)
    stays[some[of != some]] = False
    point = np.cumsum(stays) - 1
    point[some] = point[of]
    x = places.take(np.flatnonzero(stays), axis=0)
    x[point[some]] = own  # of 0.0 and -0.0, which are one place, that of the last
    return x, point.take(corners), point


def _key_limits(surface: TriSurface) -> tuple[int, int]:
    """Numbers above all keys of triangles, and above all nodes."""
    if surface.lattice is None:
        return surface.n_triangle, surface.n_vertex
    # Two triangles per node: keys of lattices count cells that would begin at the last node, too.
    n_row, n_col = surface.lattice.shape
    return 2 * n_row * n_col, n_row * n_col
