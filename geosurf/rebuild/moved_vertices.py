"""Move vertices of surfaces to multiples of a step; a grid stays a grid where that is possible.

What is a list of triangles is searched, stored and certified triangle by triangle. 30 horizons of
301 x 301 nodes, of which 100 nodes move by 3e-9 m, took twice the time when their grids were lost.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from geosurf.conventions import place
from geosurf.errors import HorizonError
from geosurf.model import Lattice, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.chunked import ChunkedLattice
from geosurf.model.chunked_moves import with_moved_nodes
from geosurf.model.moved_nodes import cells_around
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

    `rows` are rising: of vertices, or nodes of a grid that stays in its store. `held` has
    coordinates of each axis that stay. What lies on them stays on them, and what is closer than a
    step comes to lie on them: the box of the user does not move.
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
    made.sectors, made.proof = surface.sectors, surface.proof
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
    if isinstance(lattice, ChunkedLattice):
        return lattice.places_of_nodes(rows)
    if type(lattice) is not Lattice or "vertices" in surface.__dict__:
        return surface.vertices[rows]
    return lattice.places_of_nodes(_nodes(lattice, rows))


def _as_grid(surface: TriSurface, rows: np.ndarray, there: np.ndarray) -> TriSurface | None:
    """The grid with moved nodes; None if some nodes are in one place, or a triangle shuts."""
    lattice = surface.lattice
    if isinstance(lattice, ChunkedLattice):
        stored = with_moved_nodes(lattice, rows, there)
        if stored is None or _shuts(stored, rows):
            raise _stays(surface, there[0])
        return _with_lattice(surface, stored)
    if type(lattice) is not Lattice or first_of_equals(surface) is not None:
        return None
    nodes = _nodes(lattice, rows)
    grid = _in_memory(lattice, nodes, there)
    return None if _shuts(grid, nodes) else _with_lattice(surface, grid)


def _as_torn(
    surface: TriSurface, torn: TornLattice, rows: np.ndarray, there: np.ndarray
) -> TriSurface | None:
    """The torn sheet with moved nodes and ghosts; None as for a grid."""
    if first_of_equals(surface) is not None:
        return None
    nodes = torn.node_of_vertex[rows]
    is_ghost = nodes >= torn.n_node
    grid = _in_memory(torn, nodes[~is_ghost], there[~is_ghost])
    if _shuts(grid, nodes[~is_ghost]):
        return None
    ghosts = torn.ghosts.copy()
    ghosts[nodes[is_ghost] - torn.n_node] = there[is_ghost]
    moved = TornLattice.of(grid, torn.gone, torn.copies, ghosts)
    return torn_sheet(surface.name, moved, surface.vertex_data, surface.role)


def _with_lattice(surface: TriSurface, lattice: Lattice) -> TriSurface:
    marks = dict(surface.vertex_data)
    return TriSurface(surface.name, surface.role, lattice=lattice, vertex_data=marks or None)


def _in_memory(lattice: Lattice, nodes: np.ndarray, there: np.ndarray) -> Lattice:
    """A grid in memory with moved nodes; each has coordinates of its own."""
    x, y, z = (np.array(part) for part in (*lattice.horizontal(), lattice.elevation))
    for values, new in zip((x, y, z), there.T, strict=True):
        values.flat[nodes] = new
    return Lattice(x, y, z, rising=lattice.rising, reverse=lattice.turned)


def _shuts(lattice: Lattice, nodes: np.ndarray) -> bool:
    """Whether a triangle at some nodes has two corners in one place."""
    cells = cells_around(nodes, lattice.shape)
    corners = lattice.corners_of_keys(np.concatenate([2 * cells, 2 * cells + 1]))
    near = corners[np.isin(corners, nodes).any(axis=1)]
    places = lattice.places_of_nodes(near.ravel()).reshape(-1, 3, 3)  # absent nodes equal none
    return bool((places == np.roll(places, 1, axis=1)).all(axis=2).any())


def _stays(surface: TriSurface, at: np.ndarray) -> HorizonError:
    """The error for a horizon in its store that a repair cannot keep as a grid."""
    return HorizonError(
        f"horizon {surface.name!r} almost touches another surface at {place(at)}, and its nodes "
        "are so close there that a repair would fold it. geosurf repairs that in memory only. Load "
        "it with da.load(), or select fewer nodes, as in da[::2, ::2].",
        place=at,
        surfaces=[surface.name],
    )


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
