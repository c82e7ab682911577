"""Shells of units as a certificate reads them: edges, sizes, and the triangles that they share."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geosurf.carve.measures import doubtful_volume, exact_volume
from geosurf.carve.outside import box_of
from geosurf.kernels.lattices.sets import first_rows
from geosurf.kernels.meshes.checks import AREA, COUNT, PRODUCTS, VOLUME
from geosurf.kernels.meshes.mesh import first_seen, number_keys, weld
from geosurf.model import Patches, Unit, Units
from geosurf.model.patches import corner_keys
from geosurf.model.pieces import by_unit

# ---- edges ----------------------------------------
# Edges and vertices of the shells of all units, from the units on both sides of each triangle.
#
# A triangle bounds the unit behind it as it is, and the unit in front of it turned over. A shell is
# closed if it runs through each edge as often one way as the other.


VERTICES, EXCESS, OPEN = 0, 1, 2


def count_edges(
    t: np.ndarray, ring: np.ndarray, sides: np.ndarray, n_vertex: int, n_shared: int, n_unit: int
) -> tuple[np.ndarray, int]:
    """
    Count vertices below `n_shared`, and edges with one of these.

    Parameters
    ----------
    t : ndarray of int64, shape (n, 3)
        Triangles: rows of `n_vertex` vertices.
    ring : ndarray of int64, shape (3 * n,)
        Next half-edge around the same edge.
    sides : ndarray of int64, shape (n, 2)
        Units in front of and behind each triangle; -1 outside.

    Returns
    -------
    counts : ndarray of int64, shape (n_unit, 3)
        Of each unit: vertices; what edges have less than two triangles, or more (below 0); and open
        edges.
    n : int
        Vertices of shells.
    """
    # both units of each corner, from 1 on, as one number; 0 where the triangle bounds nothing
    wide = n_unit + 1
    code = np.where(sides[:, 0] != sides[:, 1], (sides + 1) @ [wide, 1], 0)
    unit_code, corner = np.repeat(code, 3), t.ravel()
    counts = np.zeros((wide, 3), dtype=np.int64)

    # nearly all vertices have one pair of units around them
    around = np.zeros(n_vertex, dtype=np.int64)
    bounding = np.flatnonzero(unit_code > 0)
    around[corner[bounding]] = unit_code[bounding]
    mixed = np.zeros(n_vertex, dtype=bool)
    mixed[corner[bounding[unit_code[bounding] != around[corner[bounding]]]]] = True
    alone = around[:n_shared][~mixed[:n_shared]]
    rows = bounding[mixed[corner[bounding]] & (corner[bounding] < n_shared)]
    pairs = corner[rows] * wide + np.stack(np.divmod(unit_code[rows], wide))
    for unit in (*np.divmod(alone, wide), first_seen(pairs.ravel())[0] % wide):
        counts[:, VERTICES] += np.bincount(unit, minlength=wide)

    # nearly all edges have two triangles with the same units, which run through them both ways
    end = t[:, [1, 2, 0]].ravel()
    up = corner < end
    plain = (unit_code == unit_code[ring]) & (up != up[ring]) & (ring[ring] == np.arange(len(ring)))
    rows = bounding[~plain[bounding]]
    low, high = np.minimum(corner[rows], end[rows]), np.maximum(corner[rows], end[rows])
    rows, edge = rows[low < n_shared], (low * n_vertex + high)[low < n_shared]
    both = number_keys(edge)[1] * wide + np.stack(np.divmod(unit_code[rows], wide))
    pair, at = number_keys(both.ravel())
    way = np.where(up[rows], 1, -1)
    balance = np.bincount(at, np.concatenate([-way, way]))
    counts[:, OPEN] += np.bincount(pair % wide, np.abs(balance), wide).astype(np.int64)
    counts[:, EXCESS] += np.bincount(pair % wide, 2 - np.bincount(at), wide).astype(int)
    return counts[1:], int(np.count_nonzero(around[:n_shared]))


def count_borders(borders: np.ndarray, sides: np.ndarray, counts: np.ndarray) -> None:
    """Add to the open edges of units those (n, 3) that two runs share, given as their rows in
    `sides`, -1 for none, and the number of edges.
    """
    # sides of a run that bounds nothing are those of none, which come last
    beside = np.append(np.where(sides[:, :1] == sides[:, 1:], -1, sides), [[-1, -1]], axis=0)
    units = beside[borders[:, :2]].reshape(-1, 4)
    row, at = np.nonzero(units >= 0)
    pair, of = np.unique(row * len(counts) + units[row, at], return_inverse=True)
    balance = np.bincount(of, np.array([-1, 1, 1, -1])[at])
    row, unit = np.divmod(pair, len(counts))
    n_open = np.bincount(unit, np.abs(balance) * borders[row, 2], len(counts))
    counts[:, OPEN] += n_open.astype(np.int64)


# ---- sizes ----------------------------------------


EPS = 2.0**-53


@dataclass(frozen=True)
class Size:
    """Volume [m3] and area [m2] of a shell, by how much rounding may have changed the area, and
    the number of its triangles.
    """

    volume: float
    area: float
    slack: float
    n_triangle: int


def surely_exact(patches: Patches) -> float:
    """Volumes up to this one are exact sums, in `carve_units` as well as here."""
    return 0.5 * doubtful_volume(box_of(patches))


def sizes_of(
    patches: Patches,
    units: Units,
    sums: np.ndarray,
    sides: np.ndarray,
    corners_of: Callable[[int], np.ndarray],
) -> dict[str, Size]:
    """
    Sizes of shells; volumes that are small compared with the box are exact.

    Parameters
    ----------
    sums : ndarray of float64, shape (n, N_SUM)
        Of some groups of triangles, see `geosurf.kernels.meshes.checks`.
    sides : ndarray of int64, shape (n, 2)
        Units in front of and behind each group.
    corners_of : callable
        Corners (n, 3, 3) of the triangles of a unit.
    """
    row, first = by_unit(sides, len(units))
    small, sizes = surely_exact(patches), {}
    for k, name in enumerate(units):
        faces = row[first[k] : first[k + 1]]
        sign = np.where(sides[faces, 1] == k, 1.0, -1.0)
        volume = math.fsum((sign[:, None] * sums[faces, VOLUME]).ravel().tolist()) / 6.0
        area = 0.5 * math.fsum(sums[faces, AREA].ravel().tolist())

        # sums of prisms are good to a part of the whole box; volumes near that error are exact
        if volume <= small:
            x = corners_of(k).reshape(-1, 3)
            volume = exact_volume(x, np.arange(len(x)).reshape(-1, 3))
        products, n = sums[faces, PRODUCTS].sum(), int(sums[faces, COUNT].sum())
        sizes[name] = Size(volume, area, 16 * EPS * float(products), n)
    return sizes


# ---- shells among the triangles of the patches ----------------------------------------


@dataclass(frozen=True)
class Matched:
    """The elements of all shells, looked up among those of the patches.

    Attributes
    ----------
    unit, surface : ndarray of int64, shape (n,)
        Unit that each element of a shell bounds, and the surface that it names.
    key : ndarray of int64, shape (n,)
        Equal for triangles with the same corners, of shells and of patches.
    row : ndarray of int64, shape (n,)
        The element of the patches with these corners on that surface; -1 if there is none.
    behind : ndarray of bool, shape (n,)
        Whether the unit lies behind it.
    turn : ndarray of bool, shape (n,)
        Which way the corners go round: two shells on both sides of a triangle differ.
    of_patches : ndarray of int64, shape (n_element,)
        Key of each element of the patches, and `turn_of_patches` which way its corners go round.
    n_key : int
    size : ndarray of int64, shape (n,)
        Number of triangles of each element of a shell.
    middle_of : callable
        The middle of the first triangle of an element of a shell, world coordinates [m].
    """

    unit: np.ndarray
    surface: np.ndarray
    key: np.ndarray
    row: np.ndarray
    behind: np.ndarray
    turn: np.ndarray
    of_patches: np.ndarray
    turn_of_patches: np.ndarray
    n_key: int
    size: np.ndarray
    middle_of: Callable[[int], np.ndarray]


def number_corners(t: np.ndarray, n_vertex: int) -> tuple[np.ndarray, np.ndarray, int]:
    """A number for the three corners of each triangle, in the order in which they come; whether
    corners go round in rising order; how many numbers there are.
    """
    # two of three steps rise where an even permutation sorts the corners
    a, b, c = t.T
    rising = (a < b).astype(np.int8) + (b < c) + (c < a) == 2
    found, number = first_seen(corner_keys(t, n_vertex))
    return number, rising, len(found)


def weld_lists(patches: Patches, units: Units) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of the patches and of all shells, and one number per distinct position."""
    x = np.concatenate([patches.local, *(unit.local for unit in units.values())])
    return x, weld(x)[0]


def matched_lists(patches: Patches, units: Units, number: np.ndarray) -> Matched:
    """Look up the triangles that shells list among those of the patches; `number` as of
    `weld_lists`.
    """
    parts = list(units.values())
    first = len(patches.local) + np.cumsum([0, *(len(part.local) for part in parts)])
    shells = [part.triangles + start for part, start in zip(parts, first.tolist(), strict=False)]
    t = number[np.concatenate([patches.triangles, *shells])]
    key, turn, n_key = number_corners(t, len(number))
    unit = np.repeat(np.arange(len(parts)), [len(part.triangles) for part in parts])
    surface = np.concatenate([np.empty(0, np.int64), *map(_surfaces, parts)])
    n = patches.n_triangle
    row = rows_on(patches.surface_of_triangle, key[:n], surface, key[n:], n_key)
    behind = turn[n:] == turn[:n][row]
    size = np.ones(len(unit), dtype=np.int64)

    def middle_of(i: int) -> np.ndarray:
        """The middle of a triangle of a shell."""
        part = parts[unit[i]]
        corners = part.vertices[part.triangles[i - int(np.searchsorted(unit, unit[i]))]]
        return np.mean(corners, axis=0)

    return Matched(
        unit, surface, key[n:], row, behind, turn[n:], key[:n], turn[:n], n_key, size, middle_of
    )


def _surfaces(unit: Unit) -> np.ndarray:
    """Surface of each triangle of a shell; -1 if the array has another length."""
    n = len(unit.triangles)
    return unit.surface_of_triangle if len(unit.surface_of_triangle) == n else np.full(n, -1)


def rows_on(
    surface: np.ndarray, key: np.ndarray, wanted: np.ndarray, key_of: np.ndarray, n_key: int
) -> np.ndarray:
    """Row with the wanted key and surface among rows with `key` and `surface`; -1 if none has."""
    # nearly all keys have one row
    row_of = first_rows(key, n_key)[key_of]
    row_of[(row_of >= 0) & (surface[row_of] != wanted)] = -1

    # where surfaces coincide, keys have several: look these up by key and surface
    times = np.bincount(key, minlength=n_key)
    several = np.flatnonzero(times[key_of] > 1)
    if len(several):
        rows = np.flatnonzero(times[key] > 1)
        n_surface = 1 + max(int(surface.max()), int(wanted.max()))
        code = key[rows] * n_surface + surface[rows]
        order = np.argsort(code, kind="stable")
        code, rows = code[order], rows[order]
        asked = key_of[several] * n_surface + wanted[several]
        at = np.minimum(np.searchsorted(code, asked), len(code) - 1)
        row_of[several] = np.where((code[at] == asked) & (wanted[several] >= 0), rows[at], -1)
    return row_of
