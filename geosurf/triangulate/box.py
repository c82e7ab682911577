"""The default model box: around the default area, or the largest axis-parallel rectangle in it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.errors import InputError
from geosurf.model import Lattice, TriSurface
from geosurf.triangulate.cover import SAMPLES, Box, covers, largest_of

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
