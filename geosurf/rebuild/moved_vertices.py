"""Move vertices of surfaces to multiples of a step; a grid stays a grid where that is possible.

What is a list of triangles is searched, stored and certified triangle by triangle. 30 horizons of
301 x 301 nodes, of which 100 nodes move by 3e-9 m, took twice the time when their grids were lost.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from geosurf.model import Lattice, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.surfaces import torn_sheet
from geosurf.model.torn_lattice import TornLattice
from geosurf.rebuild.equal_vertices import first_of_equals


def rounded(places: np.ndarray, step: float) -> np.ndarray:
    """Multiples of a step (of world coordinates)."""
    out: np.ndarray = np.rint(places / step) * step + 0.0
    return out


def shifted(places: np.ndarray, step: float, draw: int) -> np.ndarray:
    """Multiples of a step, up to one step off on each axis: equal places move alike.

    One draw may move two ends of a line so that it goes through the same place as before.
    """
    # A hash of the bits of all three coordinates; equal places have equal bits.
    bits = np.ascontiguousarray(places + 0.0).view(np.uint64)
    mixed = bits * np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
    mixed ^= mixed >> np.uint64(29)
    one = mixed.sum(axis=1, dtype=np.uint64) * np.uint64(0xBF58476D1CE4E5B9)

    # Bits of the hash decide between -1, 0 and 1 step on each axis.
    thirds = [(one >> np.uint64(k)) % np.uint64(3) for k in (17 - 3 * draw, 31 - draw, 45 + draw)]
    return rounded(places, step) + step * (np.stack(thirds, axis=1).astype(np.float64) - 1.0)


def moved_surface(
    surface: TriSurface,
    rows: np.ndarray,
    move: Callable[..., np.ndarray],
    step: float,
    held: Sequence[np.ndarray],
) -> TriSurface:
    """The surface with some vertices moved to multiples of a step, as `move` does.

    `rows` of vertices are rising. `held` has coordinates of each axis that stay. What lies on them
    stays on them, and what is closer than a step comes to lie on them: the box of the user does not
    move.
    """
    if not len(rows):
        return surface
    before = places_of(surface, rows)
    there = move(before, step)
    for axis, values in enumerate(held):
        if len(values):
            nearest = _nearest(values, before[:, axis])
            near = np.abs(nearest - before[:, axis]) <= step
            there[:, axis] = np.where(near, nearest, there[:, axis])
    torn = surface.torn
    made = _as_grid(surface, rows, there) if torn is None else _as_torn(surface, torn, rows, there)
    if made is None:
        made = _as_list(surface, rows, there)
    made.sectors = surface.sectors
    return in_crs_of(made, [surface])


def _nearest(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The nearest of some rising values to each place."""
    above = np.minimum(np.searchsorted(values, places), len(values) - 1)
    low, high = values[np.maximum(above - 1, 0)], values[above]
    nearest: np.ndarray = np.where(np.abs(places - low) < np.abs(high - places), low, high)
    return nearest


def _nodes(lattice: Lattice, rows: np.ndarray) -> np.ndarray:
    """Nodes of some vertices, row by row, absent ones counted."""
    return rows if lattice.whole else np.flatnonzero(lattice.present.ravel())[rows]


def places_of(surface: TriSurface, rows: np.ndarray) -> np.ndarray:
    """World coordinates (n, 3) of some vertices, given as for `moved_surface`."""
    lattice = surface.lattice
    if type(lattice) is not Lattice or "vertices" in surface.__dict__:
        return surface.vertices[rows]
    return lattice.places_of_nodes(_nodes(lattice, rows))


def _as_grid(surface: TriSurface, rows: np.ndarray, there: np.ndarray) -> TriSurface | None:
    """The grid with moved nodes; None if some nodes are in one place, or a triangle shuts."""
    lattice = surface.lattice
    if type(lattice) is not Lattice or first_of_equals(surface) is not None:
        return None
    nodes = _nodes(lattice, rows)
    grid = _with_nodes(lattice, nodes, there)
    if _shuts(grid, nodes):
        return None
    marks = dict(surface.vertex_data)
    return TriSurface(surface.name, surface.role, lattice=grid, vertex_data=marks or None)


def _as_torn(
    surface: TriSurface, torn: TornLattice, rows: np.ndarray, there: np.ndarray
) -> TriSurface | None:
    """The torn sheet with moved nodes and ghosts; None as for a grid."""
    if first_of_equals(surface) is not None:
        return None
    nodes = torn.node_of_vertex[rows]
    is_ghost = nodes >= torn.n_node
    grid = _with_nodes(torn, nodes[~is_ghost], there[~is_ghost])
    if _shuts(grid, nodes[~is_ghost]):
        return None
    ghosts = torn.ghosts.copy()
    ghosts[nodes[is_ghost] - torn.n_node] = there[is_ghost]
    moved = TornLattice.of(grid, torn.gone, torn.copies, ghosts)
    return torn_sheet(surface.name, moved, surface.vertex_data, surface.role)


def _with_nodes(lattice: Lattice, nodes: np.ndarray, there: np.ndarray) -> Lattice:
    """A grid with moved nodes; each has coordinates of its own."""
    x, y, z = (np.array(part) for part in (*lattice.horizontal(), lattice.elevation))
    for values, new in zip((x, y, z), there.T, strict=True):
        values.flat[nodes] = new
    return Lattice(x, y, z, rising=lattice.rising, reverse=lattice.turned)


def _shuts(lattice: Lattice, nodes: np.ndarray) -> bool:
    """Whether a triangle at some nodes has two corners in one place."""
    cells = _cells_around(nodes, lattice.shape)
    corners = lattice.corners_of_keys(np.concatenate([2 * cells, 2 * cells + 1]))
    near = corners[np.isin(corners, nodes).any(axis=1)]
    places = lattice.places_of_nodes(near.ravel()).reshape(-1, 3, 3)  # absent nodes equal none
    return bool((places == np.roll(places, 1, axis=1)).all(axis=2).any())


def _cells_around(nodes: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """
    Return all cells of a grid that have one of some nodes as a corner, rising.

    Examples
    --------
    >>> _cells_around(np.array([0, 5]), (3, 3)).tolist()
    [0, 1, 3]
    """
    n_row, n_col = shape
    row, col = np.divmod(nodes, n_col)
    found = []
    for i in (-1, 0):
        for j in (-1, 0):
            r, c = row + i, col + j
            some = (r >= 0) & (c >= 0) & (r < n_row - 1) & (c < n_col - 1)
            found.append(r[some] * (n_col - 1) + c[some])
    return np.unique(np.concatenate(found))


def _as_list(surface: TriSurface, rows: np.ndarray, there: np.ndarray) -> TriSurface:
    """The triangles of a surface, with moved vertices."""
    vertices = surface.vertices.copy()
    vertices[rows] = there
    marks, triangles = dict(surface.vertex_data), _triangles(surface)
    if not marks:  # torn sheets know their triangles by row
        triangles = _without_shut(vertices, triangles)
    return TriSurface(surface.name, surface.role, vertices, triangles, vertex_data=marks)


def _without_shut(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Triangles but for those with two corners in one place, whose neighbours then meet there."""
    # Each corner against the next one.
    corners = vertices[triangles]
    shut = (corners == np.roll(corners, 1, axis=1)).all(axis=2).any(axis=1)
    return triangles if shut.all() else triangles[~shut]


def _triangles(surface: TriSurface) -> np.ndarray:
    """Triangles over the first of equal vertices, so that equals stay together."""
    first = first_of_equals(surface)
    return surface.triangles if first is None else first[surface.triangles]
