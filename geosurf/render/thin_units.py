"""Shells of units with few enough triangles to draw, made from runs of grids.

Where one unit lies on each side of a block of cells, two triangles stand for all of the block.
Blocks of very large grids are divided along curves, or these would have most of the triangles.
Triangles along curves and of surfaces without a grid stay as they are, so that units keep their
outlines. Along the border of such blocks the shell has gaps, which are smaller than a pixel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.kernels.meshes.numbering import renumbered
from geosurf.model import Lattice, Units
from geosurf.model.chunked import ChunkedLattice
from geosurf.model.pieces import Pieces, Strips, by_unit

MAX_UNIT_TRIANGLE = 400_000  # of all shells: one for each four pixels of a picture
ROW, FIRST, LAST = 0, 1, 2  # columns of runs
_ONE_SIZE = 8  # cells along the side of a block, up to which all blocks have one size
_AT_ONCE = 1 << 22  # cells whose units are in memory


@dataclass(frozen=True, eq=False)
class Shell:
    """The shell of a unit as it is drawn.

    Attributes
    ----------
    points : ndarray of float64, shape (n_point, 3)
        World coordinates [m].
    triangles : ndarray of int64, shape (n_triangle, 3)
        Outward normals.
    surface : ndarray of int64, shape (n_triangle,)
        Surface of each.
    """

    points: np.ndarray
    triangles: np.ndarray
    surface: np.ndarray


@dataclass(frozen=True, eq=False)
class UnitMesh:
    """Triangles between units, each listed once for the units on both of its sides.

    Attributes
    ----------
    points : ndarray of float64, shape (n_point, 3)
        World coordinates [m]; surfaces that meet share their points.
    triangles : ndarray of int64, shape (n_triangle, 3)
    sides : ndarray of int64, shape (n_triangle, 2)
        Unit in front and behind, two different ones; -1 outside.
    surface : ndarray of int64, shape (n_triangle,)
        Surface of each.
    n_unit : int
    """

    points: np.ndarray
    triangles: np.ndarray
    sides: np.ndarray
    surface: np.ndarray
    n_unit: int

    @property
    def n_drawn(self) -> int:
        """Number of triangles of all shells."""
        return int((self.sides >= 0).sum())

    @property
    def shells(self) -> list[Shell]:
        """The shell of each unit, turned outward."""
        rows, first = by_unit(self.sides, self.n_unit)
        found = []
        for u, (low, high) in enumerate(pairwise(first.tolist())):
            mine = rows[low:high]
            t = self.triangles[mine]
            inward = self.sides[mine, 0] == u
            t[inward] = t[inward][:, [0, 2, 1]]
            used, t = renumbered(t)
            found.append(Shell(self.points[used], t, self.surface[mine]))
        return found


def shells_to_draw(units: Units, max_triangle: int = MAX_UNIT_TRIANGLE) -> list[Shell]:
    """
    Return the shell of each unit, with about `max_triangle` triangles in all, or as it is.

    Parameters
    ----------
    units : Units
    max_triangle : int
    """
    if not units.has_pieces:  # units that were not carved have their triangles only
        return whole_shells(units)
    pieces, sides = units.piece_sides
    stride = _stride(pieces, sides, max_triangle)
    if stride == 1 and not any(isinstance(s.lattice, ChunkedLattice) for s in pieces.sources):
        return whole_shells(units)
    return thinned_mesh(pieces, sides, len(units), stride).shells


def mesh_to_draw(units: Units, max_triangle: int = MAX_UNIT_TRIANGLE) -> UnitMesh:
    """
    Return the triangles between units, with about `max_triangle` of all shells, or all of them.

    Parameters
    ----------
    units : Units
    max_triangle : int
    """
    if not units.has_pieces:
        return _welded(whole_shells(units))
    pieces, sides = units.piece_sides
    return thinned_mesh(pieces, sides, len(units), _stride(pieces, sides, max_triangle))


def whole_shells(units: Units) -> list[Shell]:
    """Return the shells of units with all of their triangles."""
    return [Shell(u.vertices, u.triangles, u.surface_of_triangle) for u in units.values()]


def _welded(shells: list[Shell]) -> UnitMesh:
    """Shells whose points are one where they have equal coordinates."""
    points, row = np.unique(
        np.concatenate([np.empty((0, 3)), *(shell.points for shell in shells)]),
        axis=0, return_inverse=True,
    )  # fmt: skip
    first = np.cumsum([0, *(len(shell.points) for shell in shells)])
    parts = [row.ravel()[shell.triangles + k] for shell, k in zip(shells, first, strict=False)]
    unit = np.repeat(np.arange(len(shells)), [len(part) for part in parts])
    surfaces = [shell.surface for shell in shells]
    return UnitMesh(
        points,
        np.concatenate([np.empty((0, 3), dtype=np.int64), *parts]),
        np.column_stack([np.full(len(unit), -1), unit]),
        np.concatenate([np.empty(0, dtype=np.int64), *surfaces]),
        len(shells),
    )


def _stride(pieces: Pieces, sides: np.ndarray, max_triangle: int) -> int:
    """Rows and columns of a block, 1 where nothing is to be thinned."""
    bounds = (sides[:, 0] != sides[:, 1])[len(pieces.triangles) :]
    n = 0
    for first, strips in zip(pieces.first_run, pieces.strips, strict=False):
        if strips is not None:
            runs = strips.runs
            length = runs[:, LAST] - runs[:, FIRST] + 1
            n += 2 * int(length[bounds[first : first + len(runs)]].sum())
    if n <= max_triangle:
        return 1
    return math.ceil(math.sqrt(n / max_triangle))


def thinned_mesh(pieces: Pieces, sides: np.ndarray, n_unit: int, stride: int) -> UnitMesh:
    """
    Return the triangles between units, from blocks of `stride` x `stride` cells.

    Parameters
    ----------
    pieces, sides
        As ``Units.piece_sides``.
    n_unit : int
    stride : int
        1 lists all triangles.
    """
    n_core = len(pieces.triangles)
    points = [pieces.x + pieces.origin]
    listed = _between(sides[:n_core])
    triangles, beside = [pieces.triangles[listed]], [sides[:n_core][listed]]
    surface = [pieces.surface[listed]]
    n_point = len(pieces.x)
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        if strips is None or not len(strips.runs):
            continue
        assert source.lattice is not None
        first = n_core + int(pieces.first_run[i])
        nodes, of_runs = _blocks(source.lattice, strips, sides[first:], stride)

        # nodes that cut triangles have, too, keep their points: normals pass from one to the other
        used, place_of = renumbered(nodes)
        at = np.minimum(np.searchsorted(strips.nodes, used), max(len(strips.nodes) - 1, 0))
        known = strips.nodes[at] == used if len(strips.nodes) else np.zeros(len(used), dtype=bool)
        number = n_point + np.cumsum(~known) - 1
        number[known] = strips.points[at[known]]
        points.append(source.places_of_nodes(used[~known]))
        n_point += len(points[-1])
        triangles.append(number[place_of])
        beside.append(of_runs)
        surface.append(np.full(len(nodes), i))
    x, t, sides, of = (np.concatenate(part) for part in (points, triangles, beside, surface))
    return UnitMesh(x, t, sides, of, n_unit)


def _between(sides: np.ndarray) -> np.ndarray:
    """Rows with different units on both sides."""
    return np.flatnonzero(sides[:, 0] != sides[:, 1])


def _blocks(
    lattice: Lattice, strips: Strips, sides: np.ndarray, stride: int
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) of the triangles of blocks and of cells outside of them; sides of each."""
    n_row, n_col = lattice.shape[0] - 1, lattice.shape[1] - 1
    runs = strips.runs
    pairs, kind = np.unique(sides[: len(runs)], axis=0, return_inverse=True)
    counts = pairs[:, 0] != pairs[:, 1]
    kind = np.where(counts[kind.ravel()], kind.ravel() + 1, 0).astype(np.int32)

    # some rows of blocks at a time; nothing is read for that
    sizes = _sizes(stride)
    step = sizes[0] * max(_AT_ONCE // (n_col * sizes[0]), 1)
    whole: dict[int, list[np.ndarray]] = {size: [] for size in sizes}
    fine = []
    for low in range(0, n_row, step):
        high = min(low + step, n_row)
        some = slice(strips.start[low], strips.start[high])
        kinds = _kinds(runs[some], kind[some], (low, high), n_col)
        for size in sizes:
            row, col, of = _taken(kinds, size)
            whole[size].append(np.stack([low + row * size, col * size, of]))
        row, place = np.nonzero(kinds)
        fine.append(np.stack([low + row, place, kinds[row, place]]))

    # both triangles of the first cell of each block, its far nodes moved to those of the block
    nodes, of_nodes = [], []
    for size in sizes:
        first_row, first_col, of = np.concatenate(whole[size], axis=1)
        cell = first_row * n_col + first_col
        corner = lattice.corners_of_keys(np.concatenate([2 * cell, 2 * cell + 1]))
        at_row, at_col = np.divmod(corner, n_col + 1)
        low_row, low_col = (np.tile(first, 2)[:, None] for first in (first_row, first_col))
        at_row = low_row + (at_row - low_row) * size
        at_col = low_col + (at_col - low_col) * size
        nodes.append(at_row * (n_col + 1) + at_col)
        of_nodes.append(np.tile(of, 2))

    # places come in the other order where diagonals rise
    row, place, of = np.concatenate(fine, axis=1)
    half = 1 - place % 2 if lattice.rising else place % 2
    nodes.append(lattice.corners_of_keys(2 * (row * n_col + place // 2) + half))
    of_nodes.append(of)
    return np.concatenate(nodes), pairs[np.concatenate(of_nodes) - 1]


def _sizes(stride: int) -> list[int]:
    """Cells along the sides of blocks: of large ones, halves and quarters beside curves, too.

    Examples
    --------
    >>> _sizes(5), _sizes(50)
    ([5], [64, 32, 16, 8, 4, 2])
    """
    if stride <= _ONE_SIZE:
        return [stride]
    return [2**k for k in range(math.ceil(math.log2(stride)), 0, -1)]


def _kinds(runs: np.ndarray, kind: np.ndarray, rows: tuple[int, int], n_col: int) -> np.ndarray:
    """Kind of each place of some rows of cells (first, last + 1), 0 for those without a run."""
    # steps at the ends of runs, summed
    flat = np.zeros(2 * (rows[1] - rows[0]) * n_col + 1, dtype=np.int32)
    start = (runs[:, ROW] - rows[0]) * 2 * n_col
    flat[start + runs[:, FIRST]] += kind
    flat[start + runs[:, LAST] + 1] -= kind
    np.cumsum(flat, out=flat)
    return flat[:-1].reshape(rows[1] - rows[0], 2 * n_col)


def _taken(kinds: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row, column and kind of blocks of one kind, which is then 0 there; rims stay as they are."""
    n, m = kinds.shape[0] // size, kinds.shape[1] // (2 * size)
    inner = kinds[: n * size, : 2 * m * size]
    blocks = inner.reshape(n, size, m, 2 * size)
    of_block = blocks[:, 0, :, 0].copy()
    same = (blocks == of_block[:, None, :, None]).all(axis=(1, 3)) & (of_block > 0)
    inner[same.repeat(size, 0).repeat(2 * size, 1)] = 0
    row, col = np.nonzero(same)
    return row, col, of_block[same]
