"""A lattice -> fewer triangles, within a vertical tolerance that is measured everywhere."""

from __future__ import annotations

import numpy as np

from geosurf.errors import HorizonError
from geosurf.kernels.lattices.coarsen import collect_triangles, largest_errors, mark_splits
from geosurf.model import Lattice, TriSurface

_LARGEST = 256  # cells along the largest triangles
_EVEN = 1e-6  # of a cell: how far a node may be from where even steps put it


def coarsen_lattice(name: str, lattice: Lattice, tolerance: float) -> TriSurface:
    """Triangles of a horizon that stay within a vertical tolerance of the plain ones.

    Parameters
    ----------
    name : str
    lattice : Lattice
        With even steps, rotated or not. Its holes and rims are kept.
    tolerance : float
        [m], above 0.

    Returns
    -------
    TriSurface
        Without lattice. ``vertex_data["vertical_error"]`` [m] is the largest vertical distance
        from the plain surface in the triangles around each vertex, ``vertex_data["volume_error"]``
        [m3] each vertex's share of a bound: no volume below or above any part of the surface
        differs by more than its sum from that of the plain surface.

    Raises
    ------
    HorizonError
        If nodes are not at even steps.
    """
    # The grid is halved as in a restricted quadtree: right triangles whose longest edge is split.
    _check_even(name, lattice)
    (flip_row, flip_col), z, whole, rising = _from_anchor(lattice)
    # Squares of a power of two cells cover the grid; `size` counts its nodes.
    square = 1
    while square < max(whole.shape) and square < _LARGEST:
        square *= 2
    size = [-(-n // square) * square + 1 for n in whole.shape]

    # Mark where a triangle needs a split, from the finest level up, then collect the others.
    split = np.zeros(size, dtype=bool)
    mark_splits(z, whole, rising, square, tolerance, split)
    rows = collect_triangles(whole, square, split)

    # Rows (i, j) of three corners, then the cell if a triangle is half of one. Cells with both
    # halves take the plain diagonal of the lattice below.
    halves = np.bincount(rows[rows[:, 6] >= 0, 6], minlength=whole.size)
    kept = rows[(rows[:, 6] < 0) | (halves[rows[:, 6]] < 2)]

    errors = largest_errors(z, rising, kept[:, :6])
    n_row, n_col = z.shape
    nodes = np.stack([_node(kept[:, 2 * k : 2 * k + 2], n_col) for k in range(3)], axis=1)
    plain = _plain_of(np.flatnonzero(halves == 2), z, rising)
    nodes = np.concatenate([nodes, plain])
    # Plain triangles have no error.
    errors = np.concatenate([errors, np.zeros((len(plain), 2))])

    # Back from the anchor to the rows and columns of the lattice.
    i, j = np.divmod(nodes, n_col)
    i, j = (n_row - 1 - i if flip_row else i), (n_col - 1 - j if flip_col else j)
    return _surface(name, lattice, i, j, errors)


def volume_error(surface: TriSurface, sides: tuple[float, float, float, float]) -> float:
    """Bound on what fewer triangles do to volumes inside a rectangle [m3].

    Parameters
    ----------
    surface : TriSurface
        Of `coarsen_lattice`; 0 for any other.
    sides : (west, east, south, north)
        [m]

    Returns
    -------
    float
        All shares of the vertices of triangles whose bounds meet the rectangle.
    """
    shares = surface.vertex_data.get("volume_error")
    if shares is None:
        return 0.0

    # Only triangles that reach the rectangle count, each of their corners once.
    west, east, south, north = sides
    corners = surface.vertices[surface.triangles, :2]
    low, high = corners.min(axis=1), corners.max(axis=1)
    inside = (low <= (east, north)).all(axis=1) & (high >= (west, south)).all(axis=1)
    return float(shares[np.unique(surface.triangles[inside])].sum())


def _check_even(name: str, lattice: Lattice) -> None:
    """Refuse uneven steps: they would bend the triangles in the map."""
    for key, axis in (("easting", lattice.easting), ("northing", lattice.northing)):
        if axis.ndim == 1:
            bends = [np.abs(np.diff(axis, 2))]
            step = np.abs(np.diff(axis)).max()
        else:
            here = np.where(lattice.present, axis, np.nan)
            bends = [np.abs(np.diff(here, 2, axis=k)) for k in (0, 1)]
            bends.append(np.abs(np.diff(np.diff(here, axis=0), axis=1)))
            x, y = lattice.horizontal()
            step = max(np.nanmax(np.hypot(np.diff(x, axis=k), np.diff(y, axis=k))) for k in (0, 1))
        size = np.abs(axis[np.isfinite(axis)]).max(initial=0.0)
        # Rounding of large coordinates is not unevenness.
        for bend in bends:
            worst = np.nanmax(bend, initial=0.0)
            if worst > _EVEN * step + 8 * np.finfo(float).eps * size:
                at = np.unravel_index(np.nanargmax(bend), bend.shape)
                raise HorizonError(
                    f"horizon {name!r}: {key} has uneven steps near node "
                    f"{tuple(map(int, at))}, by {worst:g} m, but a tolerance needs even steps. "
                    "Leave tolerance= out, or interpolate to a regular grid first."
                )


def _from_anchor(lattice: Lattice) -> tuple[tuple[bool, bool], np.ndarray, np.ndarray, bool]:
    """Elevation from the westernmost (then southernmost) corner on, kinds of cells, diagonal.

    So the triangles do not depend on the direction in which rows and columns run.
    """
    # The westernmost corner becomes node (0, 0), whatever way the lattice runs.
    x, y = lattice.horizontal()
    corners = [(i, j) for i in (0, -1) for j in (0, -1)]
    ends = [(x[c], y[c], *c) for c in corners if np.isfinite(x[c] + y[c])]
    i, j = min(ends)[2:] if ends else (0, 0)

    step = (slice(None, None, -1 if i else 1), slice(None, None, -1 if j else 1))
    # Turning one axis exchanges the diagonals.
    there = lattice.present[step].astype(np.int64)
    rising = lattice.rising ^ bool(i) ^ bool(j)

    # 1: four nodes, 2: three nodes that make a triangle, 0: nothing.
    count = there[:-1, :-1] + there[:-1, 1:] + there[1:, :-1] + there[1:, 1:]
    first, second = (there[:-1, :-1], there[1:, 1:]) if rising else (there[:-1, 1:], there[1:, :-1])
    whole = np.where(count == 4, 1, np.where((count == 3) & (first & second == 1), 2, 0))
    # a cell with nodes but no triangle keeps its neighbours whole at their sides, too
    whole = np.where((count > 0) & (whole == 0), 2, whole)
    return (bool(i), bool(j)), np.ascontiguousarray(lattice.elevation[step]), whole, rising


def _node(corner: np.ndarray, n_col: int) -> np.ndarray:
    return corner[:, 0] * n_col + corner[:, 1]


def _plain_of(cells: np.ndarray, z: np.ndarray, rising: bool) -> np.ndarray:
    """The plain triangles of some cells, where their nodes exist."""
    n_col = z.shape[1]

    a = cells // (n_col - 1) * n_col + cells % (n_col - 1)
    b, d, c = a + 1, a + n_col, a + n_col + 1
    halves = ((a, b, c), (a, c, d)) if rising else ((a, b, d), (b, c, d))
    faces = np.concatenate([np.stack(half, axis=1) for half in halves])
    return faces[np.isfinite(z.ravel()[faces]).all(axis=1)]


def _surface(
    name: str, lattice: Lattice, i: np.ndarray, j: np.ndarray, errors: np.ndarray
) -> TriSurface:
    """A surface from nodes (n, 3) of triangles, turned as the lattice turns, in order of nodes."""
    # Twice the signed area in cells: positive is counter-clockwise in rows and columns.
    turn = (j[:, 1] - j[:, 0]) * (i[:, 2] - i[:, 0]) - (i[:, 1] - i[:, 0]) * (j[:, 2] - j[:, 0])
    nodes = i * lattice.shape[1] + j
    over = (turn > 0) == lattice.turned
    nodes[over] = nodes[over][:, ::-1]

    # Each triangle begins with its lowest node, and rows are sorted: one order for any input.
    first = nodes.argmin(axis=1)
    nodes = np.take_along_axis(nodes, (first[:, None] + np.arange(3)) % 3, axis=1)
    order = np.lexsort(nodes.T[::-1])
    nodes, errors = nodes[order], errors[order]

    used, triangles = np.unique(nodes, return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    x, y = lattice.horizontal()
    vertices = np.stack([q.ravel()[used] for q in (x, y, lattice.elevation)], axis=1)

    # Each vertex takes the largest vertical error [m] of its triangles, and a third of their volume
    # errors [m3]. `steps / cells` is the map area of one cell [m2].
    vertical, volume = np.zeros(len(used)), np.zeros(len(used))
    p, q, r = (vertices[nodes_of] for nodes_of in triangles.T)
    steps = np.abs((q - p)[:, 0] * (r - p)[:, 1] - (q - p)[:, 1] * (r - p)[:, 0])
    cells = np.abs(turn[order])
    for corner in range(3):
        np.maximum.at(vertical, triangles[:, corner], errors[:, 0])
        np.add.at(volume, triangles[:, corner], errors[:, 1] * steps / cells / 3)
    data = {"vertical_error": vertical, "volume_error": volume}
    return TriSurface(name, "horizon", vertices, triangles, vertex_data=data)
