"""Where vertical lines enter and leave units: grids by coordinates, all else by triangles.

A line passes one triangle of a grid, which its coordinates name, so that no triangle of a run is
listed. Triangles that curves touch, and those of surfaces without a grid, are searched.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import distinct
from geosurf.measure.columns import cross_columns, elevations
from geosurf.measure.grid_cells import keys_at, runs_of_keys
from geosurf.model import Unit, Units
from geosurf.model.pieces import Pieces

AT_ONCE = 1 << 18  # lines whose triangles of grids are in memory


@dataclass(frozen=True, eq=False)
class Passages:
    """Where vertical lines enter and leave one unit.

    Attributes
    ----------
    foot : ndarray of int64, shape (n,)
        Row of the feet.
    way : ndarray of int64, shape (n,)
        +1 where the line, upwards, leaves the unit; -1 where it enters.
    elevation : ndarray of float64, shape (n,)
        Local [m].
    corners : ndarray of float64, shape (n, 3, 3)
        Of the triangle there, outward; local.
    surface : ndarray of int64, shape (n,)
        Row of the surface.
    """

    foot: np.ndarray
    way: np.ndarray
    elevation: np.ndarray
    corners: np.ndarray
    surface: np.ndarray


@dataclass(frozen=True, eq=False)
class _Met:
    """Triangles that lines pass, as their surfaces have them, and the units on both sides."""

    foot: np.ndarray
    way: np.ndarray
    corners: np.ndarray
    surface: np.ndarray
    sides: np.ndarray


def passages(
    units: Units, rows: Sequence[int], feet: np.ndarray, middle: np.ndarray
) -> Iterator[tuple[np.ndarray | slice, list[Passages]]]:
    """
    Find where vertical lines enter and leave some units, some lines at a time.

    Parameters
    ----------
    units : Units
    rows : sequence of int
        Of the units.
    feet : ndarray of float64, shape (n_foot, 2)
        Easting and northing [m].
    middle : ndarray of float64, shape (2,)
        Feet on the rim of a triangle count as if they were a little nearer to this.

    Yields
    ------
    rows : slice
        Of some feet; each foot is among one of these.
    found : list of Passages
        One for each unit; feet are counted among these rows.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> units = gs.Scene(world.horizons, world.faults, world.box).units
    >>> west, east, south, north = world.box[:4]
    >>> middle = np.array([0.5 * (west + east), 0.5 * (south + north)])
    >>> ((_, found),) = passages(units, [0, 1], middle[None], middle)
    >>> sorted(len(one.foot) for one in found)
    [0, 2]
    """
    listed = list(units.values())
    try:
        pieces, sides = units.piece_sides
    except InputError:  # units that were not carved have their triangles only
        yield slice(None), [_of_shell(listed[u], feet, middle) for u in rows]
        return
    elements = [units.elements_of(u) for u in rows]
    wanted = distinct(*elements)
    local, middle = feet - pieces.origin[:2], middle - pieces.origin[:2]

    # triangles near curves are few, and searched for all lines at once; grids are not
    near = _on_triangles(pieces, sides, wanted, local, middle)
    number = np.full(len(feet), -1)
    for low in range(0, max(len(feet), 1), AT_ONCE):
        some = slice(low, low + AT_ONCE)
        number[some] = np.arange(len(feet[some]))
        of = _among(near, number)
        number[some] = -1
        met = _joined([of, *_on_grids(pieces, sides, wanted, local[some], middle)])
        yield some, [_of_unit(met, u, local[some]) for u in rows]


def _among(met: _Met, number: np.ndarray) -> _Met:
    """What lines from the feet with a number pass, by that number; others have -1."""
    rows = np.flatnonzero(number[met.foot] >= 0)
    found = _Met(*(getattr(met, one.name)[rows] for one in fields(_Met)))
    return replace(found, foot=number[found.foot])


def _of_shell(unit: Unit, feet: np.ndarray, middle: np.ndarray) -> Passages:
    """Passages of the listed triangles of a unit."""
    local = feet - unit.origin[:2]
    found = cross_columns(unit.local, unit.triangles, local, middle - unit.origin[:2])
    corners = unit.local[unit.triangles[found.triangle]]
    surface = unit.surface_of_triangle[found.triangle]
    return Passages(found.foot, found.way, found.elevation, corners, surface)


def _on_triangles(
    pieces: Pieces, sides: np.ndarray, wanted: np.ndarray, feet: np.ndarray, middle: np.ndarray
) -> _Met:
    """Lines through triangles that no run has."""
    rows = wanted[: np.searchsorted(wanted, len(pieces.triangles))]
    used, triangles = np.unique(pieces.triangles[rows], return_inverse=True)
    x, triangles = pieces.x[used], triangles.reshape(-1, 3)
    found = cross_columns(x, triangles, feet, middle)
    at = found.triangle
    corners, row = x[triangles[at]], rows[at]
    return _Met(found.foot, found.way, corners, pieces.surface[row], sides[row])


def _on_grids(
    pieces: Pieces, sides: np.ndarray, wanted: np.ndarray, feet: np.ndarray, middle: np.ndarray
) -> list[_Met]:
    """Lines through runs, one surface after the other."""
    n_core, found = len(pieces.triangles), []
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        lattice = source.lattice
        first = n_core + int(pieces.first_run[i])
        low, high = np.searchsorted(wanted, [first, n_core + int(pieces.first_run[i + 1])])
        if low == high or strips is None or lattice is None:
            continue
        runs = wanted[low:high] - first
        keys = keys_at(lattice, pieces.origin, feet, middle)
        if keys is None:  # a grid that folds on the map: its triangles are searched
            of = strips.keys_of(runs)
            found.append(_on_some(pieces, sides, i, *of, feet, middle))
            continue

        # runs that bound none of the units are left out
        run = runs_of_keys(lattice, strips, keys)
        is_wanted = np.zeros(len(strips.runs) + 1, dtype=bool)
        is_wanted[runs] = True
        foot = np.flatnonzero(is_wanted[run])
        nodes = lattice.corners_of_keys(keys[foot])
        corners = (lattice.places_of_nodes(nodes.ravel()) - pieces.origin).reshape(-1, 3, 3)
        way = np.full(len(foot), 1 if lattice.right_handed != lattice.turned else -1)
        found.append(_Met(foot, way, corners, np.full(len(foot), i), sides[first + run[foot]]))
    return found


def _on_some(
    pieces: Pieces,
    sides: np.ndarray,
    i: int,
    keys: np.ndarray,
    run: np.ndarray,
    feet: np.ndarray,
    middle: np.ndarray,
) -> _Met:
    """Lines through some triangles of a grid by key, and the run of each."""
    source = pieces.sources[i]
    used, triangles = np.unique(source.corners_of_keys(keys), return_inverse=True)
    x, triangles = source.places_of_nodes(used) - pieces.origin, triangles.reshape(-1, 3)
    found = cross_columns(x, triangles, feet, middle)
    at = found.triangle
    of = sides[len(pieces.triangles) + pieces.first_run[i] + run[at]]
    return _Met(found.foot, found.way, x[triangles[at]], np.full(len(at), i), of)


def _joined(parts: list[_Met]) -> _Met:
    """All parts as one."""
    return _Met(
        *(np.concatenate([getattr(part, one.name) for part in parts]) for one in fields(_Met))
    )


def _of_unit(met: _Met, u: int, feet: np.ndarray) -> Passages:
    """Passages of one unit: triangles turned outward, each from its lowest corner on."""
    rows = np.flatnonzero((met.sides == u).any(axis=1))
    front = met.sides[rows, 0] == u
    corners, foot = met.corners[rows], met.foot[rows]
    corners[front] = corners[front][:, [0, 2, 1]]
    corners = _from_lowest(corners)

    # the order of triangles of the shell where a sum has more than two terms: the same last digit
    order = np.argsort(foot, kind="stable")
    many = np.flatnonzero(np.bincount(foot)[foot[order]] > 2) if len(foot) else order
    keys = corners[order[many]].reshape(-1, 9)[:, ::-1].T
    order[many] = order[many][np.lexsort([*keys, foot[order[many]]])]
    rows, front, corners, foot = rows[order], front[order], corners[order], foot[order]
    way = np.where(front, -met.way[rows], met.way[rows])
    return Passages(foot, way, elevations(corners, feet[foot]), corners, met.surface[rows])


def _from_lowest(corners: np.ndarray) -> np.ndarray:
    """Triangles (n, 3, 3) from their westernmost corner on; then southern, then lower ones."""

    def before(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Whether corners a come before corners b."""
        found = a[:, 2] < b[:, 2]
        for k in (1, 0):
            found = (a[:, k] < b[:, k]) | ((a[:, k] == b[:, k]) & found)
        return found

    n = np.arange(len(corners))
    first = np.where(before(corners[:, 1], corners[:, 0]), 1, 0)
    first = np.where(before(corners[:, 2], corners[n, first]), 2, first)
    turned: np.ndarray = corners[n[:, None], (first[:, None] + np.arange(3)) % 3]
    return turned


__all__ = ["Passages", "passages"]
