"""Check that units fill the box without gaps or overlaps.

Closed shells with the volume of the box could still have a gap as large as an overlap. Therefore
the triangles of shells are looked up among those of the patches. Each one that is not a wall must
have one unit on each side. Then the number of units at a point is the same everywhere inside the
walls, and it is one because volumes add up to the box.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.carve.certificate.elements import Elements
from geosurf.conventions import place
from geosurf.kernels.meshes.mesh import weld
from geosurf.kernels.meshes.shells import number_triangles
from geosurf.model import Check, Patches, Unit, Units


@dataclass(frozen=True)
class Matched:
    """The triangles of all shells, looked up among those of the patches.

    Attributes
    ----------
    unit, surface : ndarray of int64, shape (n,)
        Unit that each triangle of a shell bounds, and the surface that it names.
    key : ndarray of int64, shape (n,)
        Equal for triangles with the same corners, of shells and of patches.
    row : ndarray of int64, shape (n,)
        The triangle of the patches with these corners on that surface; -1 if there is none.
    behind : ndarray of bool, shape (n,)
        Whether the unit lies behind it.
    turn : ndarray of bool, shape (n,)
        Which way the corners go round: two shells on both sides of a triangle differ.
    of_patches : ndarray of int64, shape (n_triangle,)
        Key of each triangle of the patches, and `turn_of_patches` which way its corners go round.
    n_key : int
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


def numbered(patches: Patches, units: Units) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of the patches and of all shells, and one number per distinct position."""
    x = np.concatenate([patches.local, *(unit.local for unit in units.values())])
    return x, weld(x)[0]


def matched(patches: Patches, units: Units, number: np.ndarray) -> Matched:
    """
    Look up the triangles of shells among those of the patches.

    Parameters
    ----------
    patches : Patches
    units : Units
    number : ndarray of int64
        See `numbered`.
    """
    parts = list(units.values())
    first = len(patches.local) + np.cumsum([0, *(len(part.local) for part in parts)])
    shells = [part.triangles + start for part, start in zip(parts, first.tolist(), strict=False)]
    t = number[np.concatenate([patches.triangles, *shells])]
    key, turn, n_key, _ = number_triangles(t, len(t))
    unit = np.repeat(np.arange(len(parts)), [len(part.triangles) for part in parts])
    surface = np.concatenate([np.empty(0, np.int64), *map(_surfaces, parts)])
    n = patches.n_triangle
    row = rows_on(patches.surface_of_triangle, key[:n], surface, key[n:], n_key)
    behind = turn[n:] == turn[:n][row]
    return Matched(unit, surface, key[n:], row, behind, turn[n:], key[:n], turn[:n], n_key)


def rows_on(
    surface: np.ndarray, key: np.ndarray, wanted: np.ndarray, key_of: np.ndarray, n_key: int
) -> np.ndarray:
    """Row with the wanted key and surface among rows with `key` and `surface`; -1 if none has."""
    # nearly all keys have one row
    row = np.full(n_key, -1)
    row[key[::-1]] = np.arange(len(key))[::-1]
    found = row[key_of]
    found[(found >= 0) & (surface[found] != wanted)] = -1

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
        found[several] = np.where((code[at] == asked) & (wanted[several] >= 0), rows[at], -1)
    return found


def _surfaces(unit: Unit) -> np.ndarray:
    """Surface of each triangle of a shell; -1 if the array has another length."""
    n = len(unit.triangles)
    return unit.surface_of_triangle if len(unit.surface_of_triangle) == n else np.full(n, -1)


def partition(patches: Patches | Elements, units: Units, found: Matched) -> Check:
    """Each triangle of a shell is a triangle of its surface, with one unit on each side."""
    times = np.bincount(2 * found.key + found.turn, minlength=2 * found.n_key).reshape(-1, 2)
    alone = times.sum(axis=1) == 1
    is_wall = np.isin(patches.surface_of_triangle, rows_of(patches, "wall"))
    alone[found.of_patches[is_wall]] = False
    foreign = found.row < 0
    twice = times[found.key, found.turn.astype(np.int64)] > 1
    gap = alone[found.key]
    n = len(found.key)
    if isinstance(patches, Elements):
        n = int(patches.n_triangle[found.row[~foreign]].sum())
    detail = f"{n} triangles of units; each triangle inside has one unit on each side"
    for bad, what in (
        (foreign, "is not a triangle of its surface"),
        (twice, "has two units on one side"),
        (gap, "has a unit on one side only and is not a wall"),
    ):
        if bad.any():
            if isinstance(patches, Elements):
                detail = f"{int(bad.sum())} elements: the first {what}"
                break
            i = int(np.flatnonzero(bad)[0])
            unit = list(units.values())[found.unit[i]]
            j = i - int(np.searchsorted(found.unit, found.unit[i]))
            where = place(unit.vertices[unit.triangles[j]].mean(axis=0))
            detail = f"{int(bad.sum())} triangles: the first, of {unit.name} at {where}, {what}"
            break
    n_bad = int((foreign | twice | gap).sum())
    return Check("units fill the box without overlap", n_bad == 0, float(n_bad), detail)


def rows_of(patches: Patches | Elements, role: str) -> list[int]:
    """Surfaces of one role."""
    return [i for i, source in enumerate(patches.sources) if source.role == role]
