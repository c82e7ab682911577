"""Nodes of a horizon that jump away from all others and back: forgotten marks of absent values.

Programs mark absent nodes with -999, -999.25, 1e30 and the like. Left in a grid they become spikes
that cut through the model. No relief jumps by far more than all its other steps and comes back
within a few nodes, so the steps of a grid alone find them:

    jump     a step between neighbours that is five times any step below it, and steeper than 45°
    island   nodes that jumps alone join to the others, all of them up or all of them down

An island that holds one usual mark is refused. One that is nowhere wider than two nodes is warned
of, as a spike. Sharp faults pass: a fault block is wider, and has jumps up and down or none around
it. Faults that gridding has smeared pass: steps of all sizes lie between.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NoReturn

import numpy as np

from geosurf.conventions import counted, place
from geosurf.conventions.axes import vertical_words
from geosurf.conventions.checks import HUGE, NO_DATA, UNITS_OF_MARKS
from geosurf.errors import HorizonError, warn_of
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.model import TriSurface

# usual marks of absent values, and the units in which they may have been read as lengths
MARKS = (*NO_DATA, 0.0)
_FAR = 5.0  # times all other steps, or more
_CLEAR = 100.0  # [m] from a mark to the next value, at least, where values alone are compared
_FEW = 0.1  # of all nodes: more outliers than these are data, not spikes
_ENOUGH = 8  # other steps, to know what is usual


def check_spikes(surface: TriSurface) -> None:
    """
    Refuse a horizon with marks of absent values among its elevations; warn of other spikes.

    Parameters
    ----------
    surface : TriSurface
        In metres, elevation positive up.

    Raises
    ------
    HorizonError
        With the mark, how many nodes have it, one place, and what to type.

    Examples
    --------
    >>> from geosurf.model import Lattice
    >>> axis, heights = np.arange(6) * 50.0, np.full((6, 6), -2000.0)
    >>> heights[2, 3] = -999.25
    >>> check_spikes(TriSurface("Top", "horizon", lattice=Lattice(axis, axis, heights)))
    Traceback (most recent call last):
    geosurf.errors.HorizonError: horizon 'Top': 1 node has the value -999.25, a usual no-data \
value, as at (E 150, N 100, elevation -999.25 m); the others lie \
between -2000 and -2000 m. Remove them: grid.where(abs(abs(grid) - 999.25) > 0.01).
    """
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused elsewhere
        _check(surface)


def check_marks(name: str, points: np.ndarray) -> None:
    """
    Refuse points of a horizon if marks of absent values lie far from all other elevations.

    Parameters
    ----------
    name : str
    points : ndarray of float64, shape (n, 3)
        Easting, northing, elevation [m].

    Raises
    ------
    HorizonError
        With the mark, how many points have it, one place, and what to type.

    Examples
    --------
    >>> check_marks("Top", np.array([[0, 0, -2000.0], [50, 0, -2010.0], [50, 50, -999.25]]))
    Traceback (most recent call last):
    geosurf.errors.HorizonError: horizon 'Top': 1 point has the value -999.25, a usual no-data \
value, as at (E 50, N 50, elevation -999.25 m); the others lie \
between -2010 and -2000 m. Remove them from the file, or in Python: \
points[abs(abs(elevation) - 999.25) > 0.01].
    """
    z = points[:, 2]
    for value in _extreme_marks(z.min(initial=np.inf), z.max(initial=-np.inf)):
        if _is_far_from_all(z, value):
            _refuse(name, "point", z, z == value, lambda k: tuple(points[k].tolist()))


def _extreme_marks(low: float, high: float) -> list[float]:
    """Which of the least and the largest elevation are usual marks."""
    return [value for value in sorted({low, high}) if mark_of(value) is not None]


def _check(surface: TriSurface) -> None:
    z = _elevations(surface)
    ends = _extreme_marks(*surface.bounds[4:])

    # Even the steepest step is below 45 degrees, and no extreme value is a usual mark.
    spacing = _spacing(surface)
    if not ends and _steepest(surface) <= spacing:
        return

    # Marks that are far from all other values need no neighbours to be recognised.
    for value in ends:
        if _is_far_from_all(z, value):
            _refuse_nodes(surface, z, z == value)

    # Then islands beyond ever smaller jumps.
    first, second, size = _edges(surface, _steps(surface))
    for limit in _limits(np.abs(size), spacing):
        if _look_at_islands(surface, z, first, second, size, limit):
            return


def mark_of(value: float) -> float | None:
    """Return the usual mark that an elevation is, in some unit, or None.

    Examples
    --------
    >>> mark_of(999.0), mark_of(-999.25 * 0.3048), mark_of(-2000.0)
    (999.0, 999.25, None)
    >>> mark_of(-1.70141e38)
    1.70141e+38
    """
    if HUGE <= abs(value) < np.inf:
        return abs(value)
    for unit in UNITS_OF_MARKS:
        for mark in MARKS:
            if abs(abs(value) - mark * unit) <= 1e-6 * mark * unit:
                return mark
    return None


# ---- values alone ----------------------------------------------------------------------


def _is_far_from_all(z: np.ndarray, value: float) -> bool:
    """Whether a mark is farther from all other values than these are from each other."""
    # farther than the range of all others, and than _CLEAR: nearer, -999 may be an elevation
    rest = z[np.isfinite(z) & (z != value)]
    if not len(rest):
        return False
    low, high = float(rest.min()), float(rest.max())
    gap = low - value if value < low else value - high
    return gap > max(high - low, _CLEAR)


def _refuse_nodes(surface: TriSurface, z: np.ndarray, wrong: np.ndarray) -> None:
    _refuse(surface.name, "node", z, wrong, lambda node: _place(surface, node))


def _refuse(
    name: str,
    kind: str,
    z: np.ndarray,
    wrong: np.ndarray,
    place_of: Callable[[int], tuple[float, ...]],
) -> NoReturn:
    """Refuse nodes (or points) of a horizon that hold a mark."""
    first = int(np.flatnonzero(wrong)[0])
    value, at = float(z[first]), place_of(first)
    mark = mark_of(value) or 0.0
    rest = z[np.isfinite(z) & ~wrong]
    n = int(wrong.sum())
    given = "grid" if kind == "node" else "elevation"

    # the remedy has to leave out what the file holds, in whatever unit that was read
    away = f"abs(abs({given}) - {mark:.10g}) > 0.01" if mark else f"{given} != 0"
    units = ""
    if mark > 1e9:
        away = f"abs({given}) < {0.9 * mark:.3g}"
    said = f"{np.copysign(mark, value):.10g}" if mark else "0"
    if mark and abs(abs(value) - mark) > 1e-6 * mark:
        said += f" ({value:.10g} m)"
        units = f", with the {given} in the units of its file"
    remedy = f"Remove them: grid.where({away})"
    if kind == "point":
        remedy = f"Remove them from the file, or in Python: points[{away}]"
    raise HorizonError(
        f"horizon {name!r}: {counted(n, kind)} {'has' if n == 1 else 'have'} the value {said}, "
        f"a usual no-data value, as at {place(at)}; the others lie between {rest.min():.6g} "
        f"and {rest.max():.6g} {vertical_words()[1]}. {remedy}{units}.",
        place=at,
        surfaces=[name],
    )


# ---- steps -----------------------------------------------------------------------------


def _elevations(surface: TriSurface) -> np.ndarray:
    """Elevation of each node (n,), absent ones too."""
    lattice = surface.lattice
    return surface.vertices[:, 2] if lattice is None else lattice.elevation.reshape(-1)


def _spacing(surface: TriSurface) -> float:
    """A usual distance between neighbours in the map [m]."""
    lattice = surface.lattice
    if lattice is None:
        # Edges of triangles: each inner edge twice, which does not matter for a median.
        x, y = surface.vertices[:, 0], surface.vertices[:, 1]
        flat = np.hypot(_along_edges(surface, x), _along_edges(surface, y))
        return float(np.median(flat)) if len(flat) else 0.0

    # The median over at most 64 rows or columns is usual enough.
    spacing = []
    for axis in (0, 1):
        gaps = []
        for part, own_axis in ((lattice.northing, 0), (lattice.easting, 1)):
            if part.ndim == 2:
                few = (
                    part[:: max(len(part) // 64, 1)]
                    if axis
                    else part[:, :: max(part.shape[1] // 64, 1)]
                )
                gaps.append(np.diff(few, axis=axis).reshape(-1))
            elif own_axis == axis:
                gaps.append(np.diff(part))
        gaps = [g for g in gaps if g.size]
        if gaps:
            spacing.append(
                float(np.nanmedian(np.hypot(*gaps) if len(gaps) == 2 else np.abs(gaps[0])))
            )
    return max(spacing, default=0.0)


def _along_edges(surface: TriSurface, values: np.ndarray) -> np.ndarray:
    """Differences of values of vertices along the edges of triangles, side by side (3 n,)."""
    t = surface.triangles
    return np.concatenate([values[t[:, (k + 1) % 3]] - values[t[:, k]] for k in range(3)])


def _steepest(surface: TriSurface) -> float:
    """The largest step in elevation between neighbours [m]; absent nodes have none."""
    sizes = (np.abs(step, out=step) for step in _steps(surface))
    return max(float(np.fmax.reduce(size, axis=None, initial=0.0)) for size in sizes)


def _steps(surface: TriSurface) -> list[np.ndarray]:
    """Steps in elevation between neighbours [m]."""
    if surface.lattice is None:
        return [_along_edges(surface, surface.vertices[:, 2])]
    return [np.diff(surface.lattice.elevation, axis=axis) for axis in (0, 1)]


def _edges(
    surface: TriSurface, steps: list[np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Neighbours, first and second node, and the step from the one to the other."""
    if surface.lattice is None:
        # The order of pairs is that of `_steps`.
        t = surface.triangles
        first, second = t.T.reshape(-1), t[:, [1, 2, 0]].T.reshape(-1)
    else:
        node = np.arange(surface.lattice.elevation.size).reshape(surface.lattice.shape)
        first = np.concatenate([node[:-1].reshape(-1), node[:, :-1].reshape(-1)])
        second = np.concatenate([node[1:].reshape(-1), node[:, 1:].reshape(-1)])

    size = np.concatenate([step.reshape(-1) for step in steps])
    real = np.isfinite(size)
    return first[real], second[real], size[real]


def _limits(size: np.ndarray, spacing: float) -> list[float]:
    """Steps below which all are far smaller than the next larger one, the largest first."""
    # Only steps above a fifth of the spacing are sorted: `below` stands for all smaller ones.
    small = size <= spacing / _FAR
    below = float(size[small].max(initial=0.0))

    order = np.append(np.sort(size[~small])[::-1], below)
    found = np.flatnonzero((order[:-1] > _FAR * order[1:]) & (order[:-1] > spacing))
    return [float(order[k + 1]) for k in found.tolist() if len(size) - 1 - k >= _ENOUGH]


def _look_at_islands(
    surface: TriSurface,
    z: np.ndarray,
    first: np.ndarray,
    second: np.ndarray,
    size: np.ndarray,
    limit: float,
) -> bool:
    """Refuse marks and warn of spikes among the islands beyond a limit; return if there are any."""
    # Neighbours with a jump between them.
    jump = np.abs(size) > limit
    a, b, step = first[jump], second[jump], size[jump]
    at_jump = np.zeros(len(z), dtype=bool)
    at_jump[a] = at_jump[b] = True
    marks = [value for value in np.unique(z[at_jump]).tolist() if mark_of(value)]  # not 0 m

    # Parts are connected without jumps; an island is a part that is only above or only below its
    # surroundings.
    here, there = at_jump[first], at_jump[second]
    if not marks:  # what is nowhere wider than two nodes has jumps at all of them
        # only nodes at jumps can be in such an island: the rest of the grid need not be labelled
        joined = ~jump & here & there
    else:
        joined = ~jump
    part = join_pairs(np.stack([first[joined], second[joined]], axis=1), len(z))
    n_part = len(z)

    apart = part[a] != part[b]
    a, b, step = a[apart], b[apart], step[apart]
    # Steps up and down from each part to the others.
    ups = np.bincount(part[a], step < 0, n_part) + np.bincount(part[b], step > 0, n_part)
    downs = np.bincount(part[a], step > 0, n_part) + np.bincount(part[b], step < 0, n_part)
    island = (ups == 0) != (downs == 0)  # all its jumps go one way

    nodes = np.bincount(part, minlength=n_part)
    if nodes.max() > 0.5 * len(z):
        island[int(np.argmax(nodes))] = False  # the horizon itself

    # Islands that hold nothing but the mark are refused.
    for value in marks:
        marked = island[part] & (z == value)
        alone = marked & (np.bincount(part, z != value, n_part)[part] == 0)
        if alone.any():
            _refuse_nodes(surface, z, alone)

    # Without a mark, an island is a spike only if all its nodes are next to a jump.
    wide = np.zeros(n_part, dtype=bool)
    wide[part[~at_jump]] = True

    # a node next to one without a jump, and not separated from it, belongs to something wider
    for one, other in ((first, second), (second, first)):
        wide[part[one[~jump & at_jump[one] & ~at_jump[other]]]] = True

    spikes = (island & ~wide)[part]
    if not spikes.any() or spikes.sum() > _FEW * np.isfinite(z).sum():
        return False
    _warn(surface, spikes, part, a, b, step, limit)
    return True


def _warn(
    surface: TriSurface,
    spikes: np.ndarray,
    part: np.ndarray,
    a: np.ndarray,
    b: np.ndarray,
    step: np.ndarray,
    limit: float,
) -> None:
    """Warn of all spikes at once, naming the highest."""
    # The highest step at any spike, and the node of the spike at it.
    ours = spikes[a] | spikes[b]
    k = int(np.argmax(np.where(ours, np.abs(step), 0.0)))
    node = int(a[k] if spikes[a[k]] else b[k])

    height, n = abs(float(step[k])), int(spikes.sum())
    at = _place(surface, node)
    usual = f"{height / limit:.0f} times all other steps" if limit > 0 else "and nowhere else"

    # The remedy cuts out the bounding rectangle of that spike.
    same = np.flatnonzero(part == part[node])
    spots = np.array([_place(surface, int(one)) for one in same])
    middle, half = 0.5 * (spots.min(0) + spots.max(0)), 0.5 * np.ptp(spots, axis=0)
    east, north = (f"abs(grid.{w} - {middle[i]:.10g}) > {half[i] + 0.01:.6g}" for i, w in
                   enumerate(("easting", "northing")))  # fmt: skip
    warn_of(
        "spike",
        surface.name,
        f"Horizon {surface.name!r} jumps by {height:.6g} {vertical_words()[1]} at {place(at)} and "
        f"back, {usual}; {counted(n, 'node')} {'stands' if n == 1 else 'stand'} out in this way.",
        f"If that is not real, remove it: grid.where(({east}) | ({north})).",
        at,
    )


def _place(surface: TriSurface, node: int) -> tuple[float, float, float]:
    """Where a node is."""
    x, y, z = surface.places_of_nodes(np.array([node]))[0].tolist()
    return x, y, z
