"""Find the pairs of triangles that may meet, as keys, for each pair of surfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geosurf.arrangement import tree
from geosurf.arrangement.broad import candidate_pairs
from geosurf.arrangement.known_pairs import Known
from geosurf.arrangement.lattice_pairs import (
    needed,
    of_one_map,
    pairs_of_grids,
    pairs_of_one_map,
)
from geosurf.arrangement.memory_limit import TooManyPairs, refusal
from geosurf.arrangement.threads import map_threads
from geosurf.arrangement.torn import is_torn, over_itself, pairs_with_itself
from geosurf.arrangement.torn_trees import candidate_pairs as candidate_pairs_of
from geosurf.arrangement.torn_trees import tree_for
from geosurf.model import TriSurface


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

    Rows of two keys, and of codes where these are known: see `settled_pairs`. What `known` has is
    not searched.
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
        # a torn sheet has its own search: neighbours by the thousand are near one another
        if i == j and not voxels and is_torn(surfaces[i]):
            return pairs_with_itself(surfaces[i], origin)
        one_map = i != j and of_one_map(surfaces[i], surfaces[j])
        if not voxels:
            if i == j:
                return tree.candidate_pairs(*[tree.tree_of(surfaces[i])] * 2, same=True)
            both: Any = (surfaces[i], surfaces[j]), (trees[i], trees[j])
            return _pairs_of_two(one_map, origin, *both)

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
    surfaces: tuple[TriSurface, TriSurface],
    trees: tuple[Any, Any],
) -> tuple[np.ndarray, dict[str, int]]:
    """Candidates of two surfaces."""
    if one_map:
        lattices: Any = surfaces[0].lattice, surfaces[1].lattice
        return pairs_of_one_map(lattices, trees)
    settled = pairs_of_grids(surfaces, trees, origin)
    return candidate_pairs_of(*trees) if settled is None else settled


def near_surfaces(
    surfaces: Sequence[TriSurface], pairs: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Those of some pairs of surfaces whose boxes meet."""
    trees: list[Any] = [tree_for(s) for s in surfaces]
    apart = tree.apart(trees).tolist()
    return [(i, j) for i, j in pairs if i == j or not apart[i][j]]


def meeting_surfaces(
    surfaces: Sequence[TriSurface], pairs: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Those of `near_surfaces`, without small surfaces of which no two triangles are near.

    To search them here costs a fifth of a search by `find_contacts` that finds nothing.
    """
    trees = [tree_for(s) for s in surfaces]

    def meet(i: int, j: int) -> bool:
        """Whether two surfaces are large, or two of their triangles are near."""
        if i == j or not (trees[i].is_small and trees[j].is_small):
            return True
        return len(candidate_pairs_of(trees[i], trees[j])[0]) > 0

    return [(i, j) for i, j in near_surfaces(surfaces, pairs) if meet(i, j)]


def _is_graph(surface: TriSurface) -> bool:
    return surface.lattice is not None and surface.lattice.is_graph


def _keys_of_rows(surface: TriSurface, rows: np.ndarray) -> np.ndarray:
    return rows if surface.lattice is None else surface.lattice.keys_of_rows(rows)
