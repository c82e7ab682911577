"""How much fewer nodes of a horizon change volumes: with signs, where nothing else comes near.

Between a horizon of fewer nodes and all its nodes lies a thin body. Where no other surface meets
it, one unit is above it and one below, all over a part whose cells are joined by their sides. There
what is above and what is below cancels: such a part moves the difference of both volumes from the
one unit to the other, whichever these are. In cells that another surface comes near, or a wall of
the box, any of the body may go to any unit, so all of it counts.

Several horizons change one after the other. Each is near another one if their bodies are: these
hold both the surfaces with fewer nodes and those with all.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from geosurf.kernels.lattices.near_cells import near_cells
from geosurf.model import Lattice, TriSurface
from geosurf.triangulate.decimate import IN_VERTEX_DATA

_NO_PLANES = np.empty((0, 4))
_UP_AND_DOWN = np.array([0, 0, -1, 0, 0, 1])  # of the corners of a box


def bound_of_change(
    surface: TriSurface, others: Iterable[TriSurface], sides: tuple[float, float, float, float]
) -> float:
    """
    Return by how much the volume of any units may differ from that with all nodes of a horizon.

    Parameters
    ----------
    surface : TriSurface
        Of `geosurf.triangulate.decimate`.
    others : iterable of TriSurface
        All that bounds units besides: horizons, faults, fluid contacts, walls of the model.
    sides : (west, east, south, north)
        Of the model [m].

    Returns
    -------
    float
        [m3].

    Examples
    --------
    Waves go up as far as they go down, so volumes change by little:

    >>> import geosurf as gs
    >>> top = gs.triangulate_horizon(gs.synthetic.waves(n=601).horizons["Top"], name="Top")
    >>> from geosurf.triangulate.decimate import Frame, decimate_horizon, measure_differences
    >>> nodes = Frame.of(top.lattice, 5)
    >>> few = decimate_horizon(top, nodes, measure_differences(top.lattice, nodes, 1.0))
    >>> sides = few.bounds[:4]
    >>> bool(bound_of_change(few, [], sides) < 0.2 * few.vertex_data["volume_error"].sum())
    True
    """
    lattice = surface.lattice
    if lattice is None or not _has_signs(surface):
        return float(surface.vertex_data["volume_error"].sum())
    largest, *of_cells = (surface.vertex_data[key] for key in IN_VERTEX_DATA)
    shape = lattice.shape
    between, change, doubt = (values.reshape(shape)[:-1, :-1] for values in of_cells)

    (west, east), (south, north) = map(_extremes, lattice.horizontal())
    inside = (east >= sides[0]) & (west <= sides[1]) & (north >= sides[2]) & (south <= sides[3])
    alone = inside & ~_cells_near(lattice, _body(lattice, largest), others)

    from scipy.ndimage import label  # not every model is asked for its bound

    part, n_part = label(alone)
    moved = np.bincount(part[alone], change[alone], n_part + 1)
    return float(np.abs(moved).sum() + doubt[alone].sum() + between[inside & ~alone].sum())


def _has_signs(surface: TriSurface) -> bool:
    """Whether a surface is a lattice of fewer nodes, whose cells have changes with signs."""
    lattice = surface.lattice
    return (
        lattice is not None
        and all(key in surface.vertex_data for key in IN_VERTEX_DATA)
        and surface.torn is None
        and not surface.sectors
    )


def _extremes(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest value at the four corners of each cell."""
    corners = values[:-1, :-1], values[:-1, 1:], values[1:, :-1], values[1:, 1:]
    return np.minimum.reduce(corners), np.maximum.reduce(corners)


def _body(lattice: Lattice, largest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest elevation of a lattice with fewer nodes, and of all nodes, in each cell.

    `largest` has at each node the largest difference of the cells around it.
    """
    low, high = _extremes(lattice.elevation)
    off = largest.reshape(lattice.shape)
    reach = np.minimum.reduce([off[:-1, :-1], off[:-1, 1:], off[1:, :-1], off[1:, 1:]])
    return low - reach, high + reach


def _cells_near(
    lattice: Lattice, body: tuple[np.ndarray, np.ndarray], others: Iterable[TriSurface]
) -> np.ndarray:
    """Which cells of a lattice are near another surface: boxes meet, and planes do not part them.

    Coordinates are relative to the first node, so that rounding stays below that of the search.
    """
    low, high = body
    x, y = lattice.horizontal()
    corner = np.array([x[0, 0], y[0, 0], 0.0])
    (west, east), (south, north) = _extremes(x - corner[0]), _extremes(y - corner[1])
    boxes = np.stack([west, south, low, east, north, high], axis=-1).reshape(-1, 6)

    near = np.zeros(low.shape, dtype=bool)
    for other in others:
        if other.lattice is not None and _has_signs(other) and lattice.shares_map(other.lattice):
            below, above = _body(other.lattice, other.vertex_data[IN_VERTEX_DATA[0]])
            near |= (low <= above) & (below <= high)
            continue
        items, planes = _items_of(other, corner)
        near |= near_cells(boxes, *low.shape, items, planes)
    return near


def _items_of(surface: TriSurface, corner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (n, 6) around the parts of a surface, and the planes (n, 4) of its triangles, if any.

    Boxes of a lattice of fewer nodes hold all of them.
    """
    lattice, shift = surface.lattice, np.tile(corner, 2)
    if lattice is not None and surface.torn is None and not surface.sectors:
        survey = lattice.survey
        leaves = survey.nodes[: int(survey.levels[0, 1] * survey.levels[0, 2])] - shift
        off = surface.vertex_data.get(IN_VERTEX_DATA[0], np.zeros(1)).max(initial=0.0)
        return leaves + off * _UP_AND_DOWN, _NO_PLANES
    a, b, c = ((surface.vertices - corner)[surface.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, size, out=np.zeros_like(normals), where=size > 0)
    planes = np.column_stack([normals, (normals * a).sum(axis=1)])
    return np.hstack([np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)]), planes
