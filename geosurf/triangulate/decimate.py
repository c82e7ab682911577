"""A horizon of every k-th node, with a proven bound of what that changes.

What is measured, to rounding, is the difference of both surfaces over rows and columns
(`geosurf.kernels.lattices.decimate`). Axes with even steps have the same difference over the map.
Where a node is not where even steps put it, by up to a part ``e`` of a coarse cell, the coarse
surface is read at a place that is off by at most this. It is linear along rows and columns of a
cell, so it is off by at most ``e`` times its largest step. That is added to the difference.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.model import Lattice, TriSurface
from geosurf.model.chunked import ChunkedLattice
from geosurf.triangulate.decimate_bands import differences_in_bands

STRIDES = (10, 8, 5, 4, 3, 2)
ENOUGH = 10_000  # nodes that stay, at least: fewer make a model no cheaper
_ROUNDING = 128 * 2.0**-52  # of a sum over the nodes of a coarse cell, in elevations
_GOLDEN = 0.6180339887498949  # multiples of it, without whole parts, are spread evenly


@dataclass(frozen=True)
class Differences:
    """How far a lattice of some rows and columns is from all nodes.

    Attributes
    ----------
    elevation : ndarray of float64, shape (n_row, n_col)
        Of the nodes that are kept [m].
    largest : ndarray of float64, shape (n_row - 1, n_col - 1)
        Largest vertical difference in each coarse cell, or more [m].
    volume : ndarray of float64, shape (n_row - 1, n_col - 1)
        Volume between both surfaces in each coarse cell, or more [m3].
    """

    elevation: np.ndarray
    largest: np.ndarray
    volume: np.ndarray


def can_be_decimated(surface: TriSurface) -> bool:
    """Whether nodes can be left out of a horizon: a whole grid with axes, and all of its nodes."""
    lattice = surface.lattice
    return (
        lattice is not None
        and lattice.has_rising_axes
        and lattice.rising
        and lattice.whole
        and not surface.sectors
        and surface.torn is None
        and "vertical_error" not in surface.vertex_data
    )


def strides_of(shape: tuple[int, int]) -> list[int]:
    """Return every how many nodes of a grid may be kept, the largest first.

    Examples
    --------
    >>> strides_of((1001, 1001)), strides_of((300, 301)), strides_of((150, 150))
    ([10, 8, 5, 4, 3, 2], [3, 2], [])
    """
    return [k for k in STRIDES if shape[0] * shape[1] >= ENOUGH * k * k]


def kept_nodes(n: int, stride: int) -> np.ndarray:
    """Return every k-th of n rows or columns, with both ends; steps are k or less, and even.

    Examples
    --------
    >>> kept_nodes(11, 5).tolist(), kept_nodes(12, 5).tolist()
    ([0, 5, 10], [0, 3, 7, 11])
    """
    n_step = -(-(n - 1) // stride)
    found: np.ndarray = np.arange(n_step + 1) * (n - 1) // n_step
    return found


def measure_differences(
    lattice: Lattice, rows: np.ndarray, cols: np.ndarray, limit: float, first: float = 0.5
) -> Differences | float:
    """
    Return how far the lattice of some rows and columns is from all nodes.

    Parameters
    ----------
    lattice : Lattice
        Whole, with axes that rise.
    rows, cols : ndarray of int64
        That are kept, with both ends.
    limit : float
        [m]. What is farther off ends the search.
    first : float
        Where it begins, from 0 (south) to below 1 (north). A grid in its store is read from south.

    Returns
    -------
    Differences or float
        Where the limit is exceeded, from 0 to below 1, if it is.

    Examples
    --------
    >>> axis = np.arange(5.0)
    >>> bowl = Lattice(axis, axis, axis[:, None] ** 2 + axis**2)
    >>> every = np.array([0, 2, 4])
    >>> measure_differences(bowl, every, every, limit=10.0).largest.round(9).tolist()
    [[2.0, 2.0], [2.0, 2.0]]
    >>> measure_differences(bowl, every, every, limit=1.0)
    0.75
    """
    n = len(rows) - 1
    if isinstance(lattice, ChunkedLattice):
        few, largest, sums, failed = differences_in_bands(lattice, rows, cols, limit)
    else:
        from geosurf.kernels.lattices.decimate import differences_of_rows_and_columns

        # blocks far apart one after the other: what is rough somewhere shows soon
        order = np.argsort(np.arange(n) * _GOLDEN % 1.0, kind="stable")
        order = np.roll(order, -int(np.flatnonzero(order == int(first * n))[0]))
        few, largest, sums, failed = differences_of_rows_and_columns(
            lattice.elevation, rows, cols, order, limit
        )
    if failed >= 0:
        return (failed + 0.5) / n

    # uneven steps and rounding
    parts = [_uneven(lattice.northing, rows), _uneven(lattice.easting, cols)]
    steps = [float(np.abs(np.diff(few, axis=axis)).max()) for axis in (0, 1)]
    size = float(np.abs(lattice.survey.box[2::3]).max())
    slack = parts[0] * steps[0] + parts[1] * steps[1] + _ROUNDING * size
    largest += slack
    if largest.max() > limit:
        return (int(largest.max(axis=1).argmax()) + 0.5) / n

    # nodes stand for the mean area around them, cells that are no squares for their largest part
    high, wide = np.diff(lattice.northing[rows])[:, None], np.diff(lattice.easting[cols])
    most = np.maximum.reduceat(np.diff(lattice.northing), rows[:-1])[:, None]
    most = most * np.maximum.reduceat(np.diff(lattice.easting), cols[:-1])
    square = np.diff(rows)[:, None] == np.diff(cols)
    volume = np.where(square, most * sums + high * wide * slack, high * wide * largest)
    return Differences(few, largest, volume)


def _uneven(axis: np.ndarray, kept: np.ndarray) -> float:
    """How far nodes are from even steps between those that are kept, as a part of a coarse cell."""
    even = np.interp(np.arange(len(axis)), kept, axis[kept])
    cell = np.repeat(np.diff(axis[kept]), np.diff(kept))
    rounding = 8 * 2.0**-52 * float(np.abs(axis[[0, -1]]).max()) / float(cell.min())
    return float((np.abs(axis - even)[:-1] / cell).max()) + rounding


def decimate_horizon(
    surface: TriSurface, rows: np.ndarray, cols: np.ndarray, differences: Differences
) -> TriSurface:
    """
    Return a horizon of some rows and columns of its lattice.

    Parameters
    ----------
    surface : TriSurface
        For which `can_be_decimated` holds.
    rows, cols : ndarray of int64
        That are kept, with both ends.
    differences : Differences
        For these.

    Returns
    -------
    TriSurface
        With its lattice. ``vertex_data["vertical_error"]`` [m] is the largest difference from all
        nodes in the cells around each node; ``vertex_data["volume_error"]`` [m3] has a quarter of
        the volume between both surfaces in each of these cells.
    """
    whole = surface.lattice
    assert whole is not None
    axes = whole.easting[cols], whole.northing[rows]
    lattice = Lattice(*axes, differences.elevation, whole.rising, whole.reverse)

    # each node is a corner of up to four cells
    shape = len(rows) + 1, len(cols) + 1
    largest, volume = np.zeros(shape), np.zeros(shape)
    largest[1:-1, 1:-1], volume[1:-1, 1:-1] = differences.largest, 0.25 * differences.volume
    quarters = [(slice(i, i + len(rows)), slice(j, j + len(cols))) for i in (0, 1) for j in (0, 1)]
    data = {
        key: values.reshape(*whole.shape, *values.shape[1:])[np.ix_(rows, cols)].reshape(
            len(rows) * len(cols), *values.shape[1:]
        )
        for key, values in surface.vertex_data.items()
    }
    data["vertical_error"] = np.max([largest[part] for part in quarters], axis=0).ravel()
    data["volume_error"] = np.sum([volume[part] for part in quarters], axis=0).ravel()
    made = TriSurface(surface.name, surface.role, lattice=lattice, vertex_data=data)
    made.crs = surface.crs
    return made


__all__ = [
    "Differences",
    "can_be_decimated",
    "decimate_horizon",
    "kept_nodes",
    "measure_differences",
    "strides_of",
]
