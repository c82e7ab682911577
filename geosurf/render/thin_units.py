"""Shells of units with few enough triangles to draw, made from runs of grids.

Where one unit lies on each side of a block of cells, two triangles stand for all of the block.
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
from geosurf.model.pieces import Pieces, Strips, by_unit

MAX_UNIT_TRIANGLE = 400_000  # of all shells: one for each four pixels of a picture
ROW, FIRST, LAST = 0, 1, 2  # columns of runs


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
    if stride == 1:
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
    return UnitMesh(*map(np.concatenate, (points, triangles, beside, surface)), n_unit)


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

    # kind of each place of the strips, 0 for those without a run: steps at the ends of runs, summed
    flat = np.zeros(2 * n_row * n_col + 1, dtype=np.int32)
    flat[runs[:, ROW] * 2 * n_col + runs[:, FIRST]] += kind
    flat[runs[:, ROW] * 2 * n_col + runs[:, LAST] + 1] -= kind
    np.cumsum(flat, out=flat)
    kinds = flat[:-1].reshape(n_row, 2 * n_col)

    # blocks of one kind; cells at the far rims and in other blocks stay
    n, m = n_row // stride, n_col // stride
    blocks = kinds[: n * stride, : 2 * m * stride].reshape(n, stride, m, 2 * stride)
    of_block = blocks[:, 0, :, 0].copy()
    same = (blocks == of_block[:, None, :, None]).all(axis=(1, 3)) & (of_block > 0)
    row, col = np.nonzero(same)
    kinds[: n * stride, : 2 * m * stride][same.repeat(stride, 0).repeat(2 * stride, 1)] = 0
    fine_row, place = np.nonzero(kinds)

    # both triangles of the first cell of each block, its far nodes moved to those of the block
    cell = (row * stride) * n_col + col * stride
    corner = lattice.corners_of_keys(np.concatenate([2 * cell, 2 * cell + 1]))
    at_row, at_col = np.divmod(corner, n_col + 1)
    low_row, low_col = (np.tile(first * stride, 2)[:, None] for first in (row, col))
    at_row = low_row + (at_row - low_row) * stride
    at_col = low_col + (at_col - low_col) * stride
    coarse = at_row * (n_col + 1) + at_col

    # places come in the other order where diagonals rise
    half = 1 - place % 2 if lattice.rising else place % 2
    fine = lattice.corners_of_keys(2 * (fine_row * n_col + place // 2) + half)
    of = np.concatenate([np.tile(of_block[same], 2), kinds[fine_row, place]]) - 1
    return np.concatenate([coarse, fine]), pairs[of]
