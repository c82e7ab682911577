"""Split surfaces at the cost of what is cut: cut parts as triangles, the rest as runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geosurf.kernels.lattices.sets import ranges
from geosurf.model.base import Noun, frozen
from geosurf.model.lattice import Lattice
from geosurf.model.surfaces import TriSurface

FREE, PAIRED = -1, -2


def corners_of(source: TriSurface | Lattice, keys: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return local corners (n, 3, 3) of triangles by key."""
    places: np.ndarray = source.places_of_nodes(source.corners_of_keys(keys).ravel()) - origin
    return places.reshape(-1, 3, 3)


@dataclass(frozen=True, eq=False)
class Strips(Noun):
    """The triangles of a lattice that no curve touches; see `geosurf.kernels.lattices.strips`.

    Attributes
    ----------
    places, absent, runs, start : ndarray of int64
        As the kernels have them.
    joined : ndarray of int64, shape (n, 2)
        Runs of neighbouring rows that share an edge.
    nodes, points : ndarray of int64, shape (n,)
        Nodes of the lattice, rising, that are points of the triangles, and which.
    """

    places: np.ndarray
    absent: np.ndarray
    runs: np.ndarray
    start: np.ndarray
    joined: np.ndarray
    nodes: np.ndarray
    points: np.ndarray

    def keys_of(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Keys of the triangles of some runs, and the run of each, int64 (n,)."""
        from geosurf.kernels.lattices.strips import FIRST, LAST, ROW
        from geosurf.kernels.search.tree import N_COL, RISING

        runs = self.runs[rows]
        run, place = ranges(runs[:, FIRST], runs[:, LAST] - runs[:, FIRST] + 1)
        if self.places[RISING]:  # halves of a cell come in the other order along a strip
            place ^= 1
        return runs[run, ROW] * 2 * (int(self.places[N_COL]) - 1) + place, rows[run]

    def labels(self, low: int, high: int) -> np.ndarray:
        """The run that lists each triangle of rows of cells, first and last (one more), int64
        (row, column, half); -1 for none.
        """
        from geosurf.kernels.lattices.strips import FIRST, LAST, ROW
        from geosurf.kernels.search.tree import N_COL, RISING

        first, last = self.start[low], self.start[high]
        runs, width = self.runs[first:last], 2 * (int(self.places[N_COL]) - 1)
        ends = (runs[:, ROW, None] - low) * width + runs[:, [FIRST, LAST]] + [0, 1]
        lengths = np.diff(ends.ravel(), prepend=0, append=(high - low) * width)
        run = np.full(2 * len(runs) + 1, -1)  # what is between runs, and runs
        run[1::2] = np.arange(first, last)
        label = np.repeat(run, lengths).reshape(high - low, width // 2, 2)

        # along a row, the halves of a cell come in the other order where diagonals rise
        return np.ascontiguousarray(label[:, :, ::-1]) if self.places[RISING] else label

    def without(self, gone: np.ndarray) -> Strips:
        """The same without some runs, bool (n_run,), which hang together with no other one."""
        stays = ~gone
        if stays.all():
            return self
        number = np.cumsum(stays) - 1
        joined = self.joined[stays[self.joined[:, 0]]]
        start = np.concatenate([[0], np.cumsum(stays)])[self.start]
        return replace(self, runs=self.runs[stays], start=start, joined=number[joined])


@dataclass(frozen=True, eq=False)
class Pieces(Noun):
    """All parts of some surfaces: triangles first, then runs; each is an element.

    Attributes
    ----------
    x : ndarray of float64, shape (n_point, 3)
        Local coordinates of the triangles' corners.
    triangles : ndarray of int64, shape (n_triangle, 3)
        Triangles that a curve touches or that belong to no lattice, surface by surface.
    surface, key : ndarray of int64, shape (n_triangle,)
        Row of the surface, and key of the triangle in it that each is a part of.
    twin : ndarray of int64, shape (n_triangle,) or (0,)
        The first triangle with the same corners: itself, but where surfaces coincide. Empty if
        none do.
    ring : ndarray of int64, shape (3 * n_triangle,)
        Next half-edge around the same edge.
    link : ndarray of int64, shape (3 * n_triangle,)
        For a half-edge that is alone: the run behind it, or FREE; else PAIRED.
    strips : list of Strips or None
        For each surface.
    first_run : ndarray of int64, shape (n_surface + 1,)
        Runs are numbered over all surfaces.
    patch : ndarray of int64, shape (n_triangle + n_run,)
    """

    sources: Sequence[TriSurface]
    origin: np.ndarray
    x: np.ndarray
    triangles: np.ndarray
    surface: np.ndarray
    key: np.ndarray
    twin: np.ndarray
    ring: np.ndarray
    link: np.ndarray
    strips: list[Strips | None]
    first_run: np.ndarray
    patch: np.ndarray

    @cached_property
    def n_patch(self) -> int:
        """Number of patches."""
        # labels are consecutive, so the highest one tells their number
        return int(self.patch.max(initial=-1)) + 1

    @property
    def coinciding(self) -> tuple[np.ndarray, np.ndarray]:
        """Triangles with the corners of an earlier one, rising, and the first of these; int64."""
        others = np.flatnonzero(self.twin != np.arange(len(self.twin)))
        return others, self.twin[others]

    def listed(self, i: int) -> Listed:
        """Return the triangles of surface `i`: no other surface is listed."""
        from geosurf.kernels.lattices.lattice_corners import (
            number_nodes,
            write_labels,
            write_triangles,
        )

        # as in `Expanded`, with this surface alone
        cut = np.searchsorted(self.surface, [i, i + 1])
        rows, strips = np.arange(*cut), self.strips[i]
        corners, nodes = self.triangles[cut[0] : cut[1]], np.empty(0, dtype=np.int64)
        if strips is None:
            return Listed(self, i, corners, rows, nodes)
        lattice = self.sources[i].lattice
        assert lattice is not None  # only lattices have strips
        n_core = len(self.x)
        ids, _ = number_nodes(strips.places, strips.runs, strips.nodes, strips.points, n_core)
        nodes = np.flatnonzero(ids >= n_core)

        # each array is written once, in the order of cells
        layout, keys = (strips.places, strips.runs, strips.start), self.key[cut[0] : cut[1]]
        n = len(rows) + int((strips.runs[:, 2] - strips.runs[:, 1] + 1).sum())
        triangles, element = np.empty((n, 3), dtype=np.int64), np.empty(n, dtype=np.int64)
        write_triangles(*layout, keys, corners, ids, triangles)
        first_run = len(self.triangles) + int(self.first_run[i])
        write_labels(*layout, keys, rows, first_run, np.empty(n, dtype=np.int64), element)
        return Listed(self, i, triangles, element, nodes)

    @cached_property
    def expanded(self) -> Expanded:
        """Everything as plain arrays."""
        # a twin of the same arrays: two that name each other would outlive their last user
        return Expanded(replace(self))


@dataclass(frozen=True, eq=False)
class Listed(Noun):
    """The triangles of one surface, in the order of all triangles of the model.

    Attributes
    ----------
    pieces : Pieces
    row : int
        Of the surface.
    triangles : ndarray of int64, shape (n, 3)
        Points: rows of `Pieces.x`, and beyond these the nodes of `nodes`.
    element : ndarray of int64, shape (n,)
        The piece that each belongs to.
    nodes : ndarray of int64
        Nodes of the lattice that are points of runs alone, rising.
    """

    pieces: Pieces
    row: int
    triangles: np.ndarray
    element: np.ndarray
    nodes: np.ndarray

    def local(self, points: np.ndarray) -> np.ndarray:
        """Local coordinates (n, 3) of points, which rise."""
        pieces, n_core = self.pieces, len(self.pieces.x)
        n = int(np.searchsorted(points, n_core))
        places = np.empty((len(points), 3))
        places[:n] = pieces.x[points[:n]]
        if n < len(points):
            nodes = self.nodes[points[n:] - n_core]
            places[n:] = pieces.sources[self.row].places_of_nodes(nodes) - pieces.origin
        return places


@dataclass(frozen=True, eq=False)
class Expanded(Noun):
    """Pieces as plain arrays: one row for each triangle, surface by surface, row by row.

    Points of the triangles come first, then nodes of the lattices. Each array is made when it
    is first used.
    """

    pieces: Pieces

    @cached_property
    def _rows(self) -> tuple[np.ndarray, np.ndarray]:
        """First triangle of each surface in `triangles` of the pieces, and in these arrays."""
        pieces = self.pieces

        # `surface` is sorted, so the rows of each surface are a slice
        cut = np.searchsorted(pieces.surface, np.arange(len(pieces.sources) + 1))
        counts = np.diff(cut)

        # runs (row, first, last) add last - first + 1 triangles each
        for i, strips in enumerate(pieces.strips):
            if strips is not None:
                counts[i] += int((strips.runs[:, 2] - strips.runs[:, 1] + 1).sum())
        return cut, np.concatenate([[0], np.cumsum(counts)])

    @property
    def n_triangle(self) -> int:
        """Number of triangles."""
        return int(self._rows[1][-1])

    @cached_property
    def _points(self) -> tuple[list[np.ndarray | None], list[int]]:
        """Point of each node of each lattice, and the number of points up to each surface."""
        from geosurf.kernels.lattices.lattice_corners import number_nodes

        # for each lattice the point of each node, -1 where unused; points of triangles are numbered
        # already
        ids: list[np.ndarray | None] = []
        counts = [len(self.pieces.x)]

        # numbers follow each other over surfaces: those of triangles, then nodes of the first
        # lattice, ...
        for strips in self.pieces.strips:
            ids.append(None)
            n = counts[-1]
            if strips is not None:
                of = (strips.places, strips.runs, strips.nodes, strips.points)
                ids[-1], n = number_nodes(*of, n)
            counts.append(n)
        return ids, counts

    @cached_property
    def local(self) -> np.ndarray:
        """Local coordinates of all points, float64 (n_vertex, 3)."""
        # filled in place, surface by surface: one allocation, no copies to join
        ids, counts = self._points
        local = np.empty((counts[-1], 3))
        local[: counts[0]] = self.pieces.x
        for id_of_node, first, source in zip(ids, counts, self.pieces.sources, strict=False):
            if id_of_node is not None:
                assert source.lattice is not None
                nodes = np.flatnonzero(id_of_node >= first)  # older points are there already
                places = source.lattice.places_of_nodes(nodes)
                local[id_of_node[nodes]] = places - self.pieces.origin
        return frozen(local, np.float64)

    @cached_property
    def triangles(self) -> np.ndarray:
        """Corners of all triangles, rows of `local`, int64 (n_triangle, 3)."""
        from geosurf.kernels.lattices.lattice_corners import write_triangles

        # runs and cut triangles are merged in the order of cells, so rows run as if nothing had
        # been left out
        pieces, (cut, rows) = self.pieces, self._rows
        triangles = np.empty((rows[-1], 3), dtype=np.int64)
        for i, (id_of_node, strips) in enumerate(zip(self._points[0], pieces.strips, strict=True)):
            listed_rows, out = slice(cut[i], cut[i + 1]), triangles[rows[i] : rows[i + 1]]
            if strips is None:
                out[:] = pieces.triangles[listed_rows]
            else:
                layout = (strips.places, strips.runs, strips.start)
                write_triangles(
                    *layout, pieces.key[listed_rows], pieces.triangles[listed_rows], id_of_node, out
                )
        return frozen(triangles, np.int64)

    @cached_property
    def _labels(self) -> tuple[np.ndarray, np.ndarray]:
        """Key and element of each triangle."""
        from geosurf.kernels.lattices.lattice_corners import write_labels

        pieces, (cut, rows) = self.pieces, self._rows
        keys, elements = (np.empty(rows[-1], dtype=np.int64) for _ in range(2))
        for i, strips in enumerate(pieces.strips):
            # `own` is the element of a cut triangle (its row); runs come after all triangles
            core_rows, out = slice(cut[i], cut[i + 1]), slice(rows[i], rows[i + 1])
            listed_rows = np.arange(cut[i], cut[i + 1])
            if strips is None:
                keys[out], elements[out] = pieces.key[core_rows], listed_rows
            else:
                layout = (strips.places, strips.runs, strips.start)
                first_run = len(pieces.triangles) + int(pieces.first_run[i])
                write_labels(
                    *layout, pieces.key[core_rows], listed_rows, first_run, keys[out], elements[out]
                )
        return keys, elements

    @cached_property
    def surface(self) -> np.ndarray:
        """Row of the surface of each triangle, int64 (n_triangle,)."""
        counts = np.diff(self._rows[1])
        return frozen(np.repeat(np.arange(len(counts)), counts), np.int64)

    @cached_property
    def parent(self) -> np.ndarray:
        """Row of the input triangle that each is a part of, int64 (n_triangle,)."""
        # keys of lattice surfaces become rows of their triangles; others are rows already
        keys, rows = self._labels[0], self._rows[1]
        of = zip(self.pieces.sources, rows[:-1], rows[1:], strict=True)
        parts = [source.rows_of_keys(keys[first:last]) for source, first, last in of]
        return frozen(np.concatenate(parts), np.int64)

    @cached_property
    def element(self) -> np.ndarray:
        """The piece (triangle, or run behind those) that each belongs to, int64 (n_triangle,)."""
        return frozen(self._labels[1], np.int64)


def same_turn(triangles: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Whether triangles (n, 3) go round as others (n, 3) with the same three corners do.

    Examples
    --------
    >>> same_turn(np.array([[4, 5, 6], [4, 5, 6]]), np.array([[6, 4, 5], [5, 4, 6]])).tolist()
    [True, False]
    """
    rising = [
        np.sum([t[:, k] < t[:, (k + 1) % 3] for k in range(3)], axis=0) == 2
        for t in (triangles, others)
    ]
    alike: np.ndarray = rising[0] == rising[1]
    return alike


def sides_seen(pieces: Pieces, sides: np.ndarray) -> np.ndarray:
    """Return the units on both sides of each piece, for triangles that coincide with others, too.

    Parameters
    ----------
    pieces : Pieces
    sides : ndarray of int64, shape (n_piece, 2)
        As ``Units.piece_sides`` has them: -1 for all but the first of coinciding triangles.
    """
    others, first = pieces.coinciding
    hidden = (sides[others] < 0).all(axis=1)
    others, first = others[hidden], first[hidden]
    if not len(others):
        return sides

    # each sees what the first one sees, turned as it is turned
    alike = same_turn(pieces.triangles[others], pieces.triangles[first])
    out = sides.copy()
    out[others] = np.where(alike[:, None], sides[first], sides[first, ::-1])
    return out


def by_unit(sides: np.ndarray, n_unit: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows that units have on one side only, unit by unit and rising, and the first of each unit.

    Examples
    --------
    >>> by_unit(np.array([[0, 1], [1, 1], [-1, 0]]), 2)
    (array([0, 2, 0]), array([0, 2, 3]))
    """
    # a face with one unit on both sides bounds nothing
    alone = np.flatnonzero(sides[:, 0] != sides[:, 1])
    unit, rows = sides[alone].ravel(), np.repeat(alone, 2)
    unit, rows = unit[unit >= 0], rows[unit >= 0]
    if n_unit < 2**16:  # numpy sorts 16 bits by digits: 0.11 s for 3e6, not 0.30
        unit = unit.astype(np.uint16)

    # stable: rows of a unit keep their rising order
    order = np.argsort(unit, kind="stable")
    first = np.searchsorted(unit[order], np.arange(n_unit + 1))
    return rows[order], first
