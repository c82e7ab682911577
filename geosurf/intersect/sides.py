"""Describe both surfaces of a smooth pair: lattices as cubics, other surfaces as triangles.

What may touch is found on pyramids over the lattices, without a triangle list; only cells that the
bounds cannot exclude become triangles, for the exact engine.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.arrangement.checked import check_surfaces
from geosurf.errors import SurfaceError
from geosurf.kernels.smooth.control_nets import nets_of
from geosurf.kernels.smooth.coverage import cones_of
from geosurf.kernels.smooth.curve_walk import find_and_walk
from geosurf.kernels.smooth.near_blocks import boxes_of_cubics, near_blocks, shift_near
from geosurf.kernels.smooth.patch_pyramid import BLOCK, lattice_pyramid
from geosurf.model import Lattice, TriSurface

_MANY = 1000  # blocks, from which it pays to look for those that are near
# By what part of the range of its nodes a cubic may leave it: half of what the absolute values of
# the weights of 4 points add up to, less one, in both directions. The sum is 1.25, and 1.632 at the
# rim, where stencils are shifted.
_BEYOND = 0.5 * (1.25 * 1.25 - 1.0)
_BEYOND_AT_RIM = 0.5 * (1.632 * 1.632 - 1.0)
LEAST = 8  # nodes per side from which on cubics can be compared with higher orders
_NONE = np.zeros((1, 1))
_NO_TRIANGLES = np.zeros((1, 3, 3))
_NO_BENDS = np.zeros((1, 4))
_NO_PLANES = np.empty((0, 4))
_NO_LEVELS = np.empty((0, 3), dtype=np.int64)


@dataclass(eq=False)
class Side:
    """One surface of a pair, in the local frame.

    Attributes
    ----------
    surface : TriSurface
    x, y, z : ndarray of float64, shape (n_row, n_col)
        Nodes, x with one row and y with one column where the lattice is axis-parallel; (1, 1) zeros
        for triangles.
    c : ndarray of float64, shape (n_triangle, 3, 3)
        Triangles; one of zeros for a lattice.
    boxes : ndarray of float64, shape (n_box, 6)
        Around blocks of cells of all levels, the finest first; or around each triangle.
    shape : ndarray of int64, shape (n_level, 3)
        First box, rows and columns of each level; none for triangles.
    bends : ndarray of float64, shape (n_block, 4)
        How far the finest blocks bend, as in `geosurf.kernels.smooth.patch_pyramid`; zeros for
        triangles.
    """

    surface: TriSurface
    origin: np.ndarray
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    c: np.ndarray
    boxes: np.ndarray
    shape: np.ndarray
    bends: np.ndarray

    @property
    def smooth(self) -> bool:
        """Whether this side is a lattice."""
        return len(self.z) > 1

    @property
    def blocks(self) -> np.ndarray:
        """Boxes of the finest blocks, or of triangles."""
        return self.boxes[: len(self.bends)] if self.smooth else self.boxes

    @cached_property
    def planes(self) -> np.ndarray:
        """Planes (n, 4) of triangles; none of the blocks of a lattice."""
        if self.smooth:
            return _NO_PLANES
        a, b, c = self.c.swapaxes(0, 1)
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return np.column_stack([normals, (normals * a).sum(axis=1)])


@dataclass(eq=False)
class Candidates:
    """Patches that may touch.

    Attributes
    ----------
    sides : (Side, Side)
    cells : (ndarray, ndarray)
        Cells (or triangles) of the first and of the second side, int64.
    patches : (ndarray, ndarray)
        What is known of each, as in `geosurf.kernels.smooth.patch_pairs`.
    whole : (ndarray, ndarray)
        1 where a patch is a cubic or a triangle, 0 where nodes of its stencil are absent.
    pairs : ndarray of int64, shape (n_pair, 2)
        Rows of the patches of both sides that are not apart.
    size : float
        Largest diagonal of the cells of the first side that have both its ends [m].
    walked : tuple of ndarray or None
        What walks found (`geosurf.kernels.smooth.curve_walk`), where they were requested and help.
    """

    sides: tuple[Side, Side]
    cells: tuple[np.ndarray, np.ndarray]
    patches: tuple[np.ndarray, np.ndarray]
    whole: tuple[np.ndarray, np.ndarray]
    pairs: np.ndarray
    size: float
    walked: tuple[np.ndarray, ...] | None = None

    @cached_property
    def nets(self) -> tuple[np.ndarray, np.ndarray]:
        """Bernstein nets of the patches of both sides, (n, 4, 4, 3)."""
        one, two = (
            nets_of(side.x, side.y, side.z, side.c, cells)
            for side, cells in zip(self.sides, self.cells, strict=True)
        )
        return one, two

    @cached_property
    def cones(self) -> tuple[np.ndarray, np.ndarray]:
        """Cones of normals of the patches of both sides; NaN for those in no pair."""
        out = []
        for nets, rows in zip(self.nets, self.pairs.T, strict=True):
            used = np.unique(rows)
            cones = np.full((len(nets), 4), np.nan)
            cones[used] = cones_of(nets[used])
            out.append(cones)
        return out[0], out[1]


def has_cubics(surface: TriSurface) -> bool:
    """Whether a surface has a lattice that is large enough for cubics and their check."""
    return surface.lattice is not None and min(surface.lattice.shape) >= LEAST


def lattice_of(surface: TriSurface) -> Lattice | None:
    """Return the lattice of a surface that has cubics, or None."""
    return surface.lattice if has_cubics(surface) else None


def nodes_of(lattice: Lattice | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates of nodes (world) as tables, straight axes as one row and one column.

    Of none: single zeros.
    """
    if lattice is None:
        return _NONE, _NONE, _NONE
    x, y = lattice.easting, lattice.northing
    if x.ndim == 1:
        x, y = x[None, :], y[:, None]
    return x, y, lattice.elevation


def sides_of(one: TriSurface, two: TriSurface, origin: np.ndarray) -> tuple[Side, Side]:
    """Both sides of a pair; of large lattices only the blocks that may meet the other side.

    Second differences of all nodes took two thirds of the time of two grids of 2237 x 2237. Local
    cubics leave the extremes of their nodes by a known part, so boxes of nodes exclude most blocks.
    """
    assert one.lattice is not None
    finest, levels = cubic_boxes(one, origin)
    if len(finest) < _MANY:
        return side_of(one, origin), side_of(two, origin)
    if not has_cubics(two):
        mesh = side_of(two, origin)
        near = near_blocks(finest, levels, mesh.boxes, _NO_LEVELS, mesh.planes)
        return side_of(one, origin, near[0]), mesh
    items = cubic_boxes(two, origin)
    near = near_blocks(finest, levels, *items, _NO_PLANES)
    return side_of(one, origin, near[0]), side_of(two, origin, near[1])


def cubic_boxes(surface: TriSurface, origin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (n, 6) around the cubics of the finest blocks of a lattice, and its levels."""
    assert surface.lattice is not None
    survey = surface.lattice.survey
    n_row, n_col = survey.levels[0, 1:].tolist()
    boxes = boxes_of_cubics(survey.nodes, n_row, n_col, origin, _BEYOND, _BEYOND_AT_RIM)
    return boxes, survey.levels


def side_of(surface: TriSurface, origin: np.ndarray, near: np.ndarray | None = None) -> Side:
    """A surface as one side of a pair, in the frame of an origin; of `near` blocks if given."""
    if not has_cubics(surface):
        (surface,) = check_surfaces((surface,))
        c = np.ascontiguousarray((surface.vertices - origin)[surface.triangles])
        boxes = np.hstack([c.min(axis=1), c.max(axis=1)])
        return Side(surface, origin, _NONE, _NONE, _NONE, c, boxes, _NO_LEVELS, _NO_BENDS)
    lattice = surface.lattice
    assert lattice is not None

    if lattice.n_triangle == 0 or not lattice.survey.finite:
        raise SurfaceError(f"surface {surface.name!r} has no triangles; leave it out.")

    # Straight axes stay single rows and columns: the kernels broadcast them.
    x, y = lattice.easting, lattice.northing
    if x.ndim == 1:
        x, y = x[None, :], y[:, None]

    blocks = lattice.survey.levels[0, 1:]
    if near is None:
        near = np.ones(int(np.prod(blocks)), dtype=bool)
    x, y, z = (
        _shifted(q, off, near.reshape(blocks))
        for q, off in zip((x, y, lattice.elevation), origin.tolist(), strict=True)
    )
    pyramid = lattice_pyramid(x, y, z, lattice.whole, near)
    return Side(surface, origin, x, y, z, _NO_TRIANGLES, *pyramid)


def _shifted(values: np.ndarray, origin: float, near: np.ndarray) -> np.ndarray:
    """Coordinates less an origin; those of nodes more than a block away from near ones are 0."""
    if origin == 0.0:
        return values
    if 1 in values.shape or near.all():
        return values - origin
    out = np.zeros(values.shape)  # memory that nothing touches costs nothing

    # All stencils of a cell, of up to eight nodes, lie in its block or in those around it.
    shift_near(values, origin, near, BLOCK, out)
    return out


def find_candidates(one: Side, two: Side, tolerance: float = 0.0) -> Candidates:
    """Patches of two sides (the first a lattice) that the bounds of cubics do not exclude.

    With a tolerance [m], curves are walked at once where both are whole.
    """
    found = find_and_walk(
        one.x, one.y, one.z, two.x, two.y, two.z, two.c,
        one.boxes, one.shape, one.bends, two.blocks, two.planes, two.bends, tolerance,
    )  # fmt: skip
    pairs, size = found[6:8]
    walked = found[9:] if len(found[10]) else None
    return Candidates((one, two), found[0:2], found[2:4], found[4:6], pairs, size, walked)


@dataclass(eq=False)
class Piece:
    """The triangles of some cells.

    Attributes
    ----------
    surface : TriSurface
    cell_of_triangle : ndarray of int64, shape (n_triangle,)
    node_of_vertex : ndarray of int64, shape (n_vertex,)
        Row * n_col + column; unused for triangles.
    """

    surface: TriSurface
    cell_of_triangle: np.ndarray
    node_of_vertex: np.ndarray


def piece_of(side: Side, cells: np.ndarray) -> Piece | None:
    """Return the plain triangles of some cells as a surface, with the same coordinates; None: no
    triangle.
    """
    surface = side.surface
    if not side.smooth:
        used, corners = np.unique(surface.triangles[cells], return_inverse=True)
        part = TriSurface(
            surface.name, surface.role, surface.vertices[used], corners.reshape(-1, 3)
        )
        return Piece(part, cells, used)

    lattice, n_col = surface.lattice, side.z.shape[1]
    assert lattice is not None

    # Four nodes around each cell: a, b, c, d; `rising` lattices have the diagonal a-c, others b-d.
    a = cells // (n_col - 1) * n_col + cells % (n_col - 1)
    b, d, c = a + 1, a + n_col, a + n_col + 1
    halves = ((a, b, c), (a, c, d)) if lattice.rising else ((a, b, d), (b, c, d))
    faces = np.stack([np.stack(half, axis=-1) for half in halves], axis=1).reshape(-1, 3)
    cell = np.repeat(cells, 2)

    # Only nodes of these cells, renumbered from 0.
    used, corners = np.unique(faces, return_inverse=True)
    corners = corners.reshape(-1, 3)
    i, j = np.divmod(used, n_col)
    upright = lattice.easting.ndim == 1
    vertices = np.stack(
        [
            lattice.easting[j] if upright else lattice.easting[i, j],
            lattice.northing[i] if upright else lattice.northing[i, j],
            lattice.elevation[i, j],
        ],
        axis=1,
    )

    # Triangles with an undefined node are dropped; the rest is renumbered once more.
    present = np.isfinite(vertices).all(axis=1)
    keep = present[corners].all(axis=1)
    if not keep.any():
        return None
    number = np.cumsum(present) - 1
    corners = number[corners[keep]]

    # A lattice with turned axes has its triangles the other way around.
    corners = corners[:, [0, 2, 1]] if lattice.turned else corners
    part = TriSurface(surface.name, surface.role, vertices[present], corners)
    return Piece(part, cell[keep], used[present])
