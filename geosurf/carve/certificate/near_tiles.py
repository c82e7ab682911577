"""Triangles in runs that are near other surfaces, of grids that stay in their store.

Tiles whose blocks meet another surface are read, each once for all others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from geosurf.arrangement.aligned import of_one_map, pairs_of_one_map
from geosurf.arrangement.chunked import Hull, Window, blocks_of, hull_of, tiles_near
from geosurf.arrangement.tree import NO_NUMBERS, Tree, tree_of
from geosurf.carve.certificate.lattice_runs import LatticeRuns
from geosurf.kernels.lattices.unlisted_triangles import mark_near, unlisted_boxes
from geosurf.model import Lattice, TriSurface
from geosurf.model.chunked import ChunkedLattice

_SLIP = 1e-3  # [m] around boxes; far more than rounding moves listed triangles by
_NONE = np.empty(0, dtype=bool)


class _Tile:
    """A part of a lattice in memory, with its triangles in runs that are not listed."""

    def __init__(self, of: LatticeRuns, at: Window, origin: np.ndarray) -> None:
        assert isinstance(of.lattice, ChunkedLattice)
        self.of, self.at, self.origin = of, at, origin
        self.lattice = of.lattice.window(*at)
        self.free = of.unlisted(*at)
        self.hit = np.zeros(len(self.free), dtype=bool)
        self.tree = tree_of_free(self.lattice, origin, self.free)

    def mark(self, other: Tree, free: np.ndarray, hit: np.ndarray) -> None:
        """Mark triangles that are near another surface, and those of the other one."""
        tree = self.tree
        mark_near(
            *tree.coordinates, tree.places, tree.nodes, tree.levels, self.free, self.hit,
            *other.arguments(), free, hit,
        )  # fmt: skip

    def in_runs(self, keys: np.ndarray) -> np.ndarray:
        """Whether triangles of this part are in runs."""
        return self.of.run_of(self._keys_of_whole(keys)) >= 0

    def found(self) -> tuple[np.ndarray, np.ndarray]:
        """Keys of marked triangles in the whole lattice, and their local corners (n, 3, 3)."""
        keys = np.flatnonzero(self.hit & self.free)
        nodes = self.lattice.corners_of_keys(keys).ravel()
        corners = (self.lattice.places_of_nodes(nodes) - self.origin).reshape(-1, 3, 3)
        return self._keys_of_whole(keys), corners

    def _keys_of_whole(self, keys: np.ndarray) -> np.ndarray:
        (first, _), (left, right) = self.at
        row, col = np.divmod(keys >> 1, right - left - 1)
        cells = (row + first) * (self.of.lattice.shape[1] - 1) + col + left
        whole: np.ndarray = 2 * cells + (keys & 1)
        return whole


class NearTiles:
    """What `find` compares.

    Parameters
    ----------
    rows : sequence of LatticeRuns or TriSurface
        Lattices, then surfaces of which triangles are listed.
    trees : sequence of Tree
        Of each row, local. Of a grid that stays in its store it is a box.
    free, hit : sequence of ndarray of bool
        Triangles of lattices in memory that are not listed, and marks of those that are found.
    sources : sequence of TriSurface
    origin : ndarray, shape (3,)
    """

    def __init__(
        self,
        rows: Sequence[LatticeRuns | TriSurface],
        trees: Sequence[Tree],
        free: Sequence[np.ndarray],
        hit: Sequence[np.ndarray],
        sources: Sequence[TriSurface],
        origin: np.ndarray,
    ) -> None:
        self.rows, self.trees, self.free, self.hit = rows, trees, free, hit
        self.sources, self.origin = sources, origin

    def find(self, pairs: list[tuple[int, int]]) -> Iterator[tuple[int, np.ndarray]]:
        """Yield lattices in a store and corners (n, 3, 3) of their triangles that are near others.

        `pairs` of rows are those whose boxes meet; those without such a lattice are left out.
        """
        others: dict[int, list[int]] = {}
        for i, j in pairs:
            if self._stored(i):
                others.setdefault(i, []).append(j)
            elif self._stored(j):
                others.setdefault(j, []).append(i)
        keys: dict[int, list[np.ndarray]] = {}
        corners: dict[int, list[np.ndarray]] = {}
        for i, some in others.items():
            for tile, met in self._tiles(i, some):
                for row, part in self._compared(i, tile, met):
                    found = part.found()
                    keys.setdefault(row, []).append(found[0])
                    corners.setdefault(row, []).append(found[1])
        for one in self.rows:
            if isinstance(one, LatticeRuns) and one.stays_in_store:
                _chunked(one).forget_chunks()
        for i, parts in keys.items():
            _, first = np.unique(np.concatenate(parts), return_index=True)
            yield i, np.concatenate(corners[i])[first]

    def _stored(self, i: int) -> bool:
        row = self.rows[i]
        return isinstance(row, LatticeRuns) and row.stays_in_store

    def _runs(self, i: int) -> LatticeRuns:
        row = self.rows[i]
        assert isinstance(row, LatticeRuns)
        return row

    def _source(self, i: int) -> TriSurface:
        row = self.rows[i]
        return self.sources[row.surface] if isinstance(row, LatticeRuns) else row

    def _tiles(
        self, i: int, others: list[int]
    ) -> Iterator[tuple[tuple[tuple[int, int], Window], list[int]]]:
        """Tiles of a lattice that others meet, each with the window around that, and these."""
        found: dict[tuple[int, int], list[tuple[int, Window]]] = {}
        for j in others:
            for tile, at in tiles_near(_chunked(self._runs(i)), self._hull(j)):
                found.setdefault(tile, []).append((j, at))
        for tile, met in sorted(found.items()):
            spans = np.array([at for _, at in met])
            low, high = spans[:, :, 0].min(axis=0).tolist(), spans[:, :, 1].max(axis=0).tolist()
            yield (tile, ((low[0], high[0]), (low[1], high[1]))), [j for j, _ in met]

    def _hull(self, j: int) -> Hull:
        """What holds another surface, in world coordinates."""
        source, row = self._source(j), self.rows[j]
        if isinstance(row, LatticeRuns) or source.lattice is None:
            # parts of a list lie on it
            return hull_of(source, tree_of(source)).widened(_SLIP)
        nodes, levels = self.trees[j].top()
        start, n_row, n_col = levels[0, :3].tolist()
        boxes = nodes[start : start + n_row * n_col] + np.concatenate([self.origin, self.origin])
        return Hull(boxes).widened(_SLIP)

    def _compared(
        self, i: int, tile: tuple[tuple[int, int], Window], others: list[int]
    ) -> Iterator[tuple[int, _Tile]]:
        """Compare a tile with others; it and parts of others that stay in a store, with marks."""
        one = _Tile(self._runs(i), tile[1], self.origin)
        for j in others:
            if not self._stored(j):
                listed = not isinstance(self.rows[j], LatticeRuns)
                both = (_NONE, _NONE) if listed else (self.free[j], self.hit[j])
                one.mark(self.trees[j], *both)
            elif of_one_map(self._source(i), self._source(j)):
                two = _Tile(self._runs(j), tile[1], self.origin)
                self._mark_of_one_map((one, two), (self.trees[i], self.trees[j]))
                yield j, two
            else:
                near = Hull(blocks_of(_chunked(self._runs(i)), *tile[0]))
                for _, at in tiles_near(_chunked(self._runs(j)), near):
                    two = _Tile(self._runs(j), at, self.origin)
                    one.mark(two.tree, two.free, two.hit)
                    yield j, two
        yield i, one

    def _mark_of_one_map(self, both: tuple[_Tile, _Tile], wholes: tuple[Tree, Tree]) -> None:
        """Mark triangles in runs of two lattices with the same nodes in the map."""
        one, two = both
        trees = tuple(tree_of_lattice(of.lattice, self.origin) for of in both)
        pairs, _ = pairs_of_one_map((one.lattice, two.lattice), (trees[0], trees[1]), wholes)
        pairs = pairs[one.in_runs(pairs[:, 0]) & two.in_runs(pairs[:, 1])]
        one.hit[pairs[:, 0]] = two.hit[pairs[:, 1]] = True


def _chunked(one: LatticeRuns) -> ChunkedLattice:
    assert isinstance(one.lattice, ChunkedLattice)
    return one.lattice


def tree_of_free(lattice: Lattice, origin: np.ndarray, free: np.ndarray) -> Tree:
    """The boxes around some triangles of a lattice in the local frame."""
    x, y, z = (part - origin[k] for k, part in enumerate(lattice.coordinates))
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    given = (x, y, z), lattice.places, *none
    return Tree(*given, *unlisted_boxes(x, y, z, lattice.places, free))


def tree_of_lattice(lattice: Lattice, origin: np.ndarray) -> Tree:
    """The boxes of a lattice in the local frame: rounding keeps the order of numbers."""
    coordinates = NO_NUMBERS
    if not isinstance(lattice, ChunkedLattice):
        x, y, z = (part - origin[k] for k, part in enumerate(lattice.coordinates))
        coordinates = x, y, z
    survey = lattice.survey
    nodes = survey.nodes - np.concatenate([origin, origin])
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    return Tree(coordinates, lattice.places, *none, nodes, survey.levels)


__all__ = ["NearTiles", "tree_of_free", "tree_of_lattice"]
