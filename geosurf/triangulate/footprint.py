"""Where a horizon is in the map: its rim, as segments that have the horizon on their left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geosurf.errors import InputError
from geosurf.kernels.meshes.mesh import weld
from geosurf.model import Lattice, TriSurface

_SAMPLE = 4000  # nodes that a lattice is fitted to
_AT_ONCE = 1 << 22  # nodes whose links are looked at together
REGULAR = 1e-2  # cells: a lattice whose nodes are farther from even steps has no frame


@dataclass(frozen=True, eq=False)
class Axes:
    """A regular lattice in the map: its corner and steps [m], right-handed.

    Attributes
    ----------
    corner : ndarray, shape (2,)
    steps : ndarray, shape (2, 2)
        One column and one row on.
    """

    corner: np.ndarray
    steps: np.ndarray

    @property
    def cell(self) -> float:
        """The shorter step [m]."""
        return float(np.hypot(*self.steps.T).min())

    def to_lattice(self, xy: np.ndarray) -> np.ndarray:
        """Column and row (..., 2) of places (..., 2)."""
        return (xy - self.corner) @ np.linalg.inv(self.steps)

    def to_world(self, uv: np.ndarray) -> np.ndarray:
        """Places (..., 2) [m] of columns and rows (..., 2)."""
        return self.corner + uv @ self.steps


@dataclass(frozen=True, eq=False)
class Footprint:
    """
    Where a horizon is in the map.

    Attributes
    ----------
    name : str
        Of the horizon.
    rim : ndarray of float64, shape (n, 2, 2)
        Segments between nodes, from and to [m]; the horizon is on their left.
    axes : Axes or None
        Of a regular lattice; None for meshes and curvilinear grids.
    lines : (ndarray, ndarray) or None
        Eastings and northings of the nodes of an unrotated grid.
    torn : bool
        Whether gaps inside may be those of faults: of meshes, this is unknown.
    """

    name: str
    rim: np.ndarray
    axes: Axes | None
    lines: tuple[np.ndarray, np.ndarray] | None
    torn: bool

    @property
    def area(self) -> float:
        """Area in the map [m2]."""
        a, b = (self.rim[:, k] - self.rim[0, 0] for k in (0, 1))
        return 0.5 * float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())

    @property
    def bounds(self) -> np.ndarray:
        """South-west and north-east corner (2, 2) [m]."""
        return np.stack([self.rim.min(axis=(0, 1)), self.rim.max(axis=(0, 1))])


def footprint_of(horizon: TriSurface) -> Footprint:
    """Return where a horizon is in the map.

    Examples
    --------
    >>> top = TriSurface("Top", "horizon", lattice=Lattice([0, 1, 2], [0, 1], np.zeros((2, 3))))
    >>> found = footprint_of(top)
    >>> len(found.rim), found.area
    (6, 2.0)
    """
    lattice = horizon.lattice
    if lattice is None:
        return Footprint(horizon.name, _rim_of_mesh(horizon), None, None, torn=True)
    rim, axes, lines = _rim_of_lattice(lattice), _axes_of(lattice), _lines_of(lattice)
    return Footprint(horizon.name, rim, axes, lines, torn=False)


def footprints_of(horizons: Sequence[TriSurface]) -> list[Footprint]:
    """Return where some horizons are in the map; those of one survey have one rim."""
    footprints: list[Footprint] = []
    wholes: dict[tuple[int, int], Footprint] = {}  # by the arrays of coordinates that they share
    for horizon in horizons:
        lattice = horizon.lattice
        if lattice is None or not lattice.whole:
            footprints.append(footprint_of(horizon))
            continue
        shared = id(lattice.easting), id(lattice.northing)
        if shared not in wholes:
            wholes[shared] = footprint_of(horizon)
        footprints.append(replace(wholes[shared], name=horizon.name))
    return footprints


def _lines_of(lattice: Lattice) -> tuple[np.ndarray, np.ndarray] | None:
    """Eastings and northings of the nodes of an unrotated grid; None if it is rotated."""
    easting, northing = lattice.easting, lattice.northing
    if easting.ndim == 1:
        return easting, northing
    if easting[-1, 0] != easting[0, 0] or northing[0, -1] != northing[0, 0]:
        return None  # corners tell nearly all grids
    if (easting == easting[:1]).all() and (northing == northing[:, :1]).all():
        return easting[0], northing[:, 0]
    return None


def _rim_of_mesh(horizon: TriSurface) -> np.ndarray:
    """Edges of triangles, each turned to run around it, less those that cancel each other."""
    # meshes in parts, and triangles with corners of their own, repeat vertices: one per place
    spot, n_place = weld(horizon.vertices)
    xy, t = np.empty((n_place, 2)), spot[horizon.triangles]
    xy[spot] = horizon.vertices[:, :2]
    a, b, c = (xy[t[:, k]] for k in range(3))
    (u, v), (p, q) = (b - a).T, (c - a).T

    # triangles of a mesh may be turned either way: in the map all run anticlockwise here
    turn = u * q - v * p
    faces = np.where((turn < 0)[:, None], t[:, ::-1], t)[turn != 0]
    ends = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    pairs, number = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)

    # left (n,): how often an edge runs from its lower to its higher vertex, less the other way;
    # inner edges cancel, folds count as often as they are covered
    forward = np.where(ends[:, 0] < ends[:, 1], 1, -1)
    left = np.zeros(len(pairs), dtype=np.int64)
    np.add.at(left, number.ravel(), forward)
    pairs = np.where((left < 0)[:, None], pairs[:, ::-1], pairs)
    return xy[np.repeat(pairs, np.abs(left), axis=0)]


def _rim_of_lattice(lattice: Lattice) -> np.ndarray:
    """Links between nodes, and diagonals, with a triangle on one side only."""
    n_row, n_col = lattice.shape
    step = max(_AT_ONCE // n_col, 1)  # rows
    windows = [_links_in(lattice, low, min(low + step, n_row)) for low in range(0, n_row, step)]
    links = np.concatenate([np.concatenate(parts) for parts in zip(*windows, strict=True)])
    links = links if lattice.right_handed else links[:, ::-1]
    return lattice.map_places(links)


def _links_in(lattice: Lattice, low: int, high: int) -> list[np.ndarray]:
    """Links (n, 2) of the rim that begin in rows `low` to `high` - 1, one array for each kind."""
    n_row, n_col = lattice.shape
    n = np.zeros((high - low + 2, n_col + 2), dtype=bool)  # one node more on each side
    start, stop = max(low - 1, 0), min(high + 1, n_row)
    n[start - low + 1 : stop - low + 1, 1:-1] = lattice.present[start:stop]
    node = np.arange(low, high + 1)[:, None] * n_col + np.arange(n_col + 1)

    # first and second triangle of each cell: from the row and the column before the window on
    a, b, c, d = n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]
    first, second = (a & b & c, a & c & d) if lattice.rising else (a & b & d, b & c & d)

    # along rows: the second triangle of a cell has its upper side, the first its lower one
    below, above = second[:-1, 1:], first[1:, 1:]
    links = [_directed(above & ~below, node[:-1, :-1], node[:-1, 1:]),
             _directed(below & ~above, node[:-1, 1:], node[:-1, :-1])]  # fmt: skip

    # which triangle of a cell touches its east and its west side depends on the diagonal
    first, second = first[1:], second[1:]
    on_right, on_left = (first, second) if lattice.rising else (second, first)
    before, behind = on_right[:, :-1], on_left[:, 1:]
    links += [_directed(before & ~behind, node[:-1, :-1], node[1:, :-1]),
              _directed(behind & ~before, node[1:, :-1], node[:-1, :-1])]  # fmt: skip

    # diagonals
    first, second = first[:, 1:], second[:, 1:]
    ends = node[:-1, :-1], node[1:, 1:]
    on_left, on_right = second, first
    if not lattice.rising:
        ends, on_left, on_right = (node[:-1, 1:], node[1:, :-1]), first, second
    links += [_directed(on_left & ~on_right, *ends),
              _directed(on_right & ~on_left, *ends[::-1])]  # fmt: skip
    return links


def _directed(where: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Links (n, 2) from node to node, where there are some."""
    return np.stack([start[where], end[where]], axis=1)


def _axes_of(lattice: Lattice) -> Axes | None:
    """The frame of a lattice with even steps, turned right-handed; None if it has none."""
    n_col = lattice.shape[1]
    n = lattice.n_present
    known = np.linspace(0, n - 1, min(n, _SAMPLE)).astype(np.int64)
    known = known if lattice.whole else np.flatnonzero(lattice.present)[known]
    row, col = np.divmod(known, n_col)
    xy = lattice.map_places(known)

    # fitted from the mean: millions of metres would cost digits of steps of a few
    middle = xy.mean(axis=0)
    design = np.column_stack([np.ones(len(row)), col, row])
    fitted, *_ = np.linalg.lstsq(design, xy - middle, rcond=None)
    axes = Axes(fitted[0] + middle, fitted[1:])

    # nearly parallel steps, or nodes off even steps: no lattice to count cells in
    if abs(np.linalg.det(axes.steps)) < 0.1 * np.prod(np.hypot(*axes.steps.T)):
        return None
    if np.abs(axes.to_lattice(xy) - np.stack([col, row], axis=1)).max() > REGULAR:
        return None
    if np.linalg.det(axes.steps) < 0:
        axes = Axes(axes.corner, axes.steps * [[1.0], [-1.0]])
    return axes


# ---- box ----------------------------------------
# The default model box: around the default area, or the largest axis-parallel rectangle in it.


_MARGIN = 0.25  # of the relief, above and below


def propose_box(
    horizons: Sequence[TriSurface],
    outline: np.ndarray | None = None,
    in_map: Sequence[TriSurface] | None = None,
) -> Box:
    """
    Return the model box around an outline, or around the largest rectangle inside all horizons.

    For unrotated grids without holes that is where their edges overlap, exactly. For rotated
    or holed grids it is the largest axis-parallel rectangle among sampled places that all horizons
    cover, one sample inside; carving still checks that nothing leaks.

    Parameters
    ----------
    horizons : sequence of TriSurface
        At least one.
    outline : ndarray of float64, shape (n, 2), optional
        Corners of the area of the model. Without it each horizon needs a lattice.
    in_map : sequence of TriSurface, optional
        Horizons as they lie in the map, without gaps at faults; default: `horizons`.

    Returns
    -------
    (west, east, south, north, bottom, top)
        [m]. A quarter of the relief is added above and below.

    Raises
    ------
    InputError
        If there are no horizons, one has no lattice, or they have no area in common.

    Examples
    --------
    >>> z = np.zeros((3, 4))
    >>> flat = Lattice(np.arange(4.0), np.arange(3.0), z)
    >>> propose_box([TriSurface("Top", "horizon", lattice=flat)])
    (0.0, 3.0, 0.0, 2.0, -1.0, 1.0)
    """
    if not horizons:
        raise InputError(
            "geosurf needs horizons to propose a box. Give box=(west, east, south, north, "
            "bottom, top)."
        )

    # Bounds are west, east, south, north, bottom, top [m].
    bounds = np.array([horizon.bounds for horizon in horizons])
    bottom, top = bounds[:, 4].min(), bounds[:, 5].max()

    # horizons have to end on walls, never on the top or the bottom of the box
    margin = max(_MARGIN * (top - bottom), 1.0)

    if outline is not None:
        (west, south), (east, north) = outline.min(axis=0), outline.max(axis=0)
    else:
        west, east, south, north = _rectangle(in_map or horizons)
    box = (west, east, south, north, bottom - margin, top + margin)
    w, e, s, n, b, t = (float(value) for value in box)
    return w, e, s, n, b, t


def are_unrotated(horizons: Sequence[TriSurface]) -> bool:
    """Return whether all horizons are unrotated grids without holes."""
    lattices = [horizon.lattice for horizon in horizons]
    return all(
        lattice is not None and lattice.easting.ndim == 1 and lattice.whole for lattice in lattices
    )


def _rectangle(horizons: Sequence[TriSurface]) -> tuple[float, float, float, float]:
    """West, east, south, north of the largest axis-parallel rectangle that all horizons cover."""
    for horizon in horizons:
        if horizon.lattice is None:
            raise InputError(
                f"horizon {horizon.name!r} is a mesh, and aoi='rectangle' is for grids only. "
                "Leave aoi out, or give box=(west, east, south, north, bottom, top)."
            )

    bounds = np.array([horizon.bounds for horizon in horizons])

    # The common box of all bounds; rotated or holed grids cover only a part of it.
    low, high = bounds[:, 0::2].max(axis=0), bounds[:, 1::2].min(axis=0)
    if (low[:2] >= high[:2]).any():
        raise InputError(
            "the horizons have no area in common, so geosurf cannot propose a box. Give "
            "box=(west, east, south, north, bottom, top)."
        )

    if are_unrotated(horizons):
        return low[0], high[0], low[1], high[1]
    lattices = [horizon.lattice for horizon in horizons if horizon.lattice is not None]
    return _largest_rectangle(lattices, low, high)


def _largest_rectangle(
    lattices: Sequence[Lattice], low: np.ndarray, high: np.ndarray
) -> tuple[float, float, float, float]:
    """Largest rectangle of sampled places that all lattices cover, one sample inside."""
    # Sample cells of equal size; centres of samples.
    step = float((high[:2] - low[:2]).max()) / SAMPLES
    x = np.arange(low[0] + 0.5 * step, high[0], step)
    y = np.arange(low[1] + 0.5 * step, high[1], step)
    covered = np.ones((len(y), len(x)), dtype=bool)

    for lattice in lattices:
        covered &= covers(lattice, *np.meshgrid(x, y))
    area, left, right, first, last = largest_of(covered)
    if area == 0 or right - left < 3 or last - first < 3:
        raise InputError(
            "the horizons have no rectangle in common that is large enough for a model. "
            "Give box=(west, east, south, north, bottom, top)."
        )
    # One sample further inside on each side, since samples are covered at their centres only.
    return x[left + 1], x[right - 1], y[first + 1], y[last - 1]


SAMPLES = 192  # along the longer side, for rotated and holed grids
Box = tuple[float, float, float, float, float, float]


def largest_of(covered: np.ndarray) -> tuple[int, int, int, int, int]:
    """Area, first and last column, first and last row of the largest rectangle that is covered."""
    # `heights`: covered samples from each row downwards in the order of rows, one per column.
    best = (0, 0, 0, 0, 0)
    heights = np.zeros(covered.shape[1], dtype=np.int64)
    for row in range(len(covered)):
        heights = np.where(covered[row], heights + 1, 0)
        best = max(best, _best_in_histogram(heights, row))
    return best


def _best_in_histogram(heights: np.ndarray, row: int) -> tuple[int, int, int, int, int]:
    """(area, left, right, first row, last row) of the largest rectangle that ends in a row."""
    # The stack holds (start, height) of rectangles that are still open, heights rising; a lower
    # column closes all that are taller. The last height, 0, closes all.
    best = (0, 0, 0, 0, 0)
    stack: list[tuple[int, int]] = []
    for i, height in enumerate([*heights.tolist(), 0]):
        start = i
        while stack and stack[-1][1] >= height:
            start, tall = stack.pop()
            best = max(best, (tall * (i - start), start, i - 1, row - tall + 1, row))
        stack.append((start, height))
    return best


def covers(lattice: Lattice, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Whether places lie in a cell with four nodes, for lattices with even steps."""
    # Two steps span the lattice: along rows and along columns [m].
    n_row, n_col = lattice.shape
    corners = np.array([0, n_col - 1, (n_row - 1) * n_col, n_row * n_col - 1])
    first, east, north, opposite = lattice.map_places(corners)
    along, up = (east - first) / (n_col - 1), (north - first) / (n_row - 1)
    # Four corners of a parallelogram; otherwise steps cannot be even.
    far = first + along * (n_col - 1) + up * (n_row - 1)
    size = np.hypot(*along) + np.hypot(*up)
    if np.hypot(*(far - opposite)) > 1e-3 * size:
        raise InputError(
            "a horizon is a curvilinear grid, for which geosurf cannot propose a box. Give "
            "box=(west, east, south, north, bottom, top)."
        )

    # Invert the two steps: row and column of the cell below each place.
    det = along[0] * up[1] - along[1] * up[0]
    dx, dy = x - first[0], y - first[1]
    j = np.floor((dx * up[1] - dy * up[0]) / det).astype(np.int64)
    i = np.floor((along[0] * dy - along[1] * dx) / det).astype(np.int64)

    inside = (i >= 0) & (i < n_row - 1) & (j >= 0) & (j < n_col - 1)
    i, j = np.where(inside, i, 0), np.where(inside, j, 0)

    # All four nodes of the cell have to exist.
    node = i * n_col + j
    four = np.ones(inside.shape, dtype=bool)
    if not lattice.whole:
        for corner in (node, node + n_col, node + 1, node + n_col + 1):
            four &= lattice.present.ravel()[corner]
    return inside & four
