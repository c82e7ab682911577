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

from geosurf.kernels.lattices.run_checks import find_blocks
from geosurf.kernels.meshes.mesh import number_keys, renumbered
from geosurf.model import Lattice, TriSurface, Units
from geosurf.model.pieces import Pieces, Strips, by_unit
from geosurf.model.protocols import DrawnModel
from geosurf.render.views import SIZE

# ---- thin surfaces ----------------------------------------
# Surfaces with few enough triangles to draw: as many as the pixels of a picture can show.


# triangles of all surfaces of a picture, and of one, whatever its size
MAX_TRIANGLE = 1_000_000
MOST, LEAST = 400_000, 60_000
PIXELS = 10  # of a picture for each triangle of a surface: a cell of a grid is two or three wide


def thinned(surface: TriSurface, max_triangle: int = MOST) -> TriSurface:
    """Return a surface with few enough triangles to draw.

    Of a gridded surface with more than `max_triangle` triangles, rows and columns are left out at
    even distances. A surface without a lattice is returned unchanged.

    Parameters
    ----------
    surface : TriSurface
    max_triangle : int

    Returns
    -------
    TriSurface
    """
    lattice = surface.lattice
    if lattice is None:
        return surface
    n_row, n_col = lattice.shape

    # two triangles for each cell: half of the rows and columns leaves a quarter of them
    share = math.sqrt(max_triangle / (2.0 * max(n_row - 1, 1) * max(n_col - 1, 1)))
    if share >= 1.0:
        return surface
    rows, columns = _spread(n_row, share), _spread(n_col, share)
    some = np.ix_(rows, columns)
    if lattice.easting.ndim == 1:
        easting, northing = lattice.easting[columns], lattice.northing[rows]
    else:
        easting, northing = lattice.easting[some], lattice.northing[some]
    elevation = lattice.elevation[some]
    coarse = Lattice(easting, northing, elevation, lattice.rising, lattice.reverse)
    return TriSurface(surface.name, surface.role, lattice=coarse)


def most_of_each(n: int, size: tuple[int, int] = SIZE, zoom: float = 1.0) -> int:
    """How many triangles each of n surfaces may have, about: as many as pixels can show.

    Parameters
    ----------
    n : int
    size : (int, int)
        Width and height of the picture in pixels.
    zoom : float
        2 shows the middle at twice the scale.

    Examples
    --------
    >>> most_of_each(2), most_of_each(12), most_of_each(2, (3840, 2160))
    (102400, 83333, 400000)
    """
    resolved = int(size[0] * size[1] * zoom**2) // PIXELS
    return min(MOST, max(LEAST, min(resolved, MAX_TRIANGLE // max(n, 1))))


def _spread(n: int, share: float) -> np.ndarray:
    """Some of n rows at even distances; the first and the last one stay, and so the border.

    Examples
    --------
    >>> _spread(10, 0.7).tolist()
    [0, 2, 3, 4, 6, 8, 9]
    """
    n_cell = max(int((n - 1) * min(share, 1.0)), min(n - 1, 1))
    rows: np.ndarray = np.round(np.linspace(0.0, n - 1.0, n_cell + 1)).astype(np.int64)
    return rows


MAX_UNIT_TRIANGLE = 400_000  # of all shells: one for each four pixels of a picture
FIRST, LAST = 1, 2  # columns of runs


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
        return int(np.count_nonzero(self.sides >= 0))

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
    x, t, sides, of = (_joined(part) for part in (points, triangles, beside, surface))
    return UnitMesh(x, t, sides, of, n_unit)


def as_modelled(scene: DrawnModel, surface: TriSurface, max_triangle: int) -> TriSurface:
    """
    Return the modelled part of a surface: a torn horizon ends on its faults, not beyond them.

    Parameters
    ----------
    scene : Scene
    surface : TriSurface
    max_triangle : int
        Of a torn horizon, about; others are returned as they are.

    Returns
    -------
    TriSurface
        Of a large torn horizon blocks of cells, and all of its triangles along faults: listing all
        of 25 million cells took 4 minutes and 10 GB for a map.
    """
    if "ghost" not in surface.vertex_data:
        return surface
    patches = scene.patches
    pieces, row = patches.pieces, patches.names.index(surface.name)

    # its triangles as the sides of one unit, which is behind them
    sides = np.full((int(pieces.first_run[-1]) + len(pieces.triangles), 2), -1)
    runs = len(pieces.triangles) + pieces.first_run
    sides[runs[row] : runs[row + 1], 1] = 0
    sides[: len(pieces.triangles), 1][pieces.surface == row] = 0
    stride = _stride(pieces, sides, 2 * max_triangle)
    if stride == 1:
        return patches.surface(row)
    (shell,) = thinned_mesh(pieces, sides, 1, stride).shells
    return TriSurface(surface.name, surface.role, shell.points, shell.triangles)


def _joined(parts: list[np.ndarray]) -> np.ndarray:
    """All parts in one array; the list is empty afterwards, so that the next one has its memory."""
    found = np.concatenate(parts)
    parts.clear()
    return found


def _between(sides: np.ndarray) -> np.ndarray:
    """Rows with different units on both sides."""
    return np.flatnonzero(sides[:, 0] != sides[:, 1])


def _blocks(
    lattice: Lattice, strips: Strips, sides: np.ndarray, stride: int
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) of the triangles of blocks and of cells outside of them; sides of each."""
    n_row, n_col = lattice.shape[0] - 1, lattice.shape[1] - 1
    runs = strips.runs
    sides = sides[: len(runs)]
    width = int(sides.max(initial=-1)) + 2
    codes, kind = number_keys((sides[:, 0] + 1) * width + sides[:, 1] + 1)
    pairs = np.stack(np.divmod(codes, width), axis=1) - 1
    counts = pairs[:, 0] != pairs[:, 1]
    sizes = np.array(_sizes(stride))
    given = runs, strips.start, np.where(counts[kind], kind + 1, 0), sizes, n_row, n_col
    n_block, n_fine = find_blocks(*given, *2 * [np.empty((0, 4), dtype=np.int64)])
    blocks, fine = np.empty((n_block, 4), dtype=np.int64), np.empty((n_fine, 3), dtype=np.int64)
    find_blocks(*given, blocks, fine)

    # both triangles of the first cell of each block, its far nodes moved to those of the block
    nodes, of_nodes = [], []
    for k, size in enumerate(sizes.tolist()):
        first_row, first_col, of = blocks[blocks[:, 0] == k, 1:].T
        cell = first_row * n_col + first_col
        corner = lattice.corners_of_keys(np.concatenate([2 * cell, 2 * cell + 1]))
        at_row, at_col = np.divmod(corner, n_col + 1)
        low_row, low_col = (np.tile(first, 2)[:, None] for first in (first_row, first_col))
        at_row = low_row + (at_row - low_row) * size
        at_col = low_col + (at_col - low_col) * size
        nodes.append(at_row * (n_col + 1) + at_col)
        of_nodes.append(np.tile(of, 2))

    # places come in the other order where diagonals rise
    row, place, of = fine.T
    half = 1 - place % 2 if lattice.rising else place % 2
    nodes.append(lattice.corners_of_keys(2 * (row * n_col + place // 2) + half))
    of_nodes.append(of)
    return np.concatenate(nodes), pairs[np.concatenate(of_nodes) - 1]


def _sizes(stride: int) -> list[int]:
    """Cells along the sides of blocks: of large ones, halves and quarters beside curves, too.

    With one size, blocks that a curve passes leave all their cells: more, the larger blocks are.

    Examples
    --------
    >>> _sizes(5), _sizes(50)
    ([8, 4, 2], [64, 32, 16, 8, 4, 2])
    """
    if stride == 1:
        return [1]
    return [2**k for k in range(math.ceil(math.log2(stride)), 0, -1)]
