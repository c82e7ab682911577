"""What the checks of a certificate read: the elements of a model, and triangles where curves are.

An element is a triangle, or a run of lattice triangles that no curve touches. `Elements.of` makes
each triangle an element; `geosurf.carve.certificate_facts` leaves runs as they are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.carve.outside import box_of, rise_of
from geosurf.conventions import place
from geosurf.kernels.lattices.sets import distinct, first_rows, ranges
from geosurf.kernels.meshes.mesh import weld
from geosurf.kernels.meshes.shells import number_triangles
from geosurf.kernels.search.tree import faces_in_box, triangle_boxes
from geosurf.model import Check, Patches, TriSurface, Unit, Units

# ---- partition ----------------------------------------
# Check that units fill the box without gaps or overlaps.
#
# Closed shells with the volume of the box could still have a gap as large as an overlap. Therefore
# the triangles of shells are looked up among those of the patches. Each one that is not a wall must
# have one unit on each side. Then the number of units at a point is the same everywhere inside the
# walls, and it is one because volumes add up to the box.


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
    found = first_rows(key, n_key)[key_of]
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


N_SUM = 14  # columns of `sums_of_runs`
_FEW = 256  # rays, up to which the boxes of listed triangles are compared with each of them
_SLIP = 1e-3  # [m] around a ray's first triangle; far more than rounding moves its aim by


@dataclass(frozen=True, eq=False)
class Elements:
    """The elements of a model.

    Attributes
    ----------
    sources : sequence of TriSurface
    origin : ndarray, shape (3,)
    surface_of_triangle : ndarray of int64, shape (n,)
        Surface of each element.
    n_triangle : ndarray of int32, shape (n,)
        Number of triangles of each element.
    rise : ndarray of float64, shape (n_surface,)
        Twice the area of each surface in the map, of what is within the bounds of the walls; below
        0 where normals look down [m2].
    within : ndarray of bool, shape (n,)
        Whether all corners are within the bounds of the walls.
    local : ndarray of float64, shape (n_vertex, 3)
    triangles : ndarray of int64, shape (n_listed, 3)
        Triangles that are listed: all that have a corner in common with other elements than the
        runs next to them.
    element : ndarray of int64, shape (n_listed,)
        The element that each is a part of.
    joined : ndarray of int64, shape (n, 2)
        Runs with a common edge that no other triangle has.
    near : callable, optional
        (runs, boxes (n, 6), wanted) -> corners (n, 3, 3) and elements of one triangle of each of
        these runs, the same each time, then of those of wanted runs near the boxes.
    """

    sources: Sequence[TriSurface]
    origin: np.ndarray
    surface_of_triangle: np.ndarray
    n_triangle: np.ndarray
    rise: np.ndarray
    within: np.ndarray
    local: np.ndarray
    triangles: np.ndarray
    element: np.ndarray
    joined: np.ndarray
    near: Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]] | None = (
        None
    )

    @classmethod
    def of(cls, patches: Patches | Elements) -> Elements:
        """Each triangle as an element."""
        if isinstance(patches, Elements):
            return patches
        x, t = patches.local, patches.triangles
        n = len(t)
        lower, upper = box_of(patches)
        inside = ((x >= lower) & (x <= upper)).all(axis=1)[t].all(axis=1)
        of = patches.surface_of_triangle
        rise = np.bincount(of[inside], rise_of(x[t[inside]]), minlength=len(patches.sources))
        return cls(
            patches.sources, patches.origin, of,
            np.ones(n, dtype=np.int32), rise, inside, x, t, np.arange(n),
            np.empty((0, 2), dtype=np.int64),
        )  # fmt: skip

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the surfaces."""
        return tuple(source.name for source in self.sources)

    def triangles_near(
        self, starts: np.ndarray, wanted: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Triangles of wanted elements that rays along axes from some elements may meet.

        Parameters
        ----------
        starts : ndarray of int64
            Elements that rays start from.
        wanted : ndarray of bool, shape (n,)

        Returns
        -------
        x, triangles, element : ndarray
        first : ndarray of int64
            A triangle of each start.
        """
        if self.near is None:
            listed = np.flatnonzero(wanted[self.element])
            of = self.element[listed]
            return self.local, self.triangles[listed], of, first_rows(of, len(wanted))[starts]

        # one triangle of each start, from which its ray runs along the axis on which it is widest
        is_start = np.zeros(len(wanted), dtype=bool)
        is_start[starts] = True
        listed = np.flatnonzero(is_start[self.element])
        runs = self.near(starts, np.zeros((0, 6)), wanted)
        origin = np.concatenate([self.local[self.triangles[listed]], runs[0]])
        of = np.concatenate([self.element[listed], runs[1]])
        some = origin[first_rows(of, len(wanted))[starts]]
        low, high = some.min(axis=1) - _SLIP, some.max(axis=1) + _SLIP

        boxes = np.concatenate([low, high], axis=1)
        a, b, c = (some[:, k] for k in range(3))
        ray, axes = np.arange(len(some)), np.abs(np.cross(b - a, c - a)).argmax(axis=1)
        boxes[ray, axes], boxes[ray, 3 + axes] = -np.inf, np.inf

        # what is listed is far from most rays; many rays are compared with all of it
        if len(boxes) <= _FEW:
            listed = distinct(*(faces_in_box(self._boxes, box) for box in boxes))
            listed = listed[wanted[self.element[listed]]]
        else:
            listed = np.flatnonzero(wanted[self.element])
        runs = self.near(starts, boxes, wanted)
        x = np.concatenate([self.local[self.triangles[listed]], runs[0]]).reshape(-1, 3)
        of = np.concatenate([self.element[listed], runs[1]])
        first = first_rows(of, len(wanted))[starts]
        return x, np.arange(len(x)).reshape(-1, 3), of, first

    @cached_property
    def _boxes(self) -> np.ndarray:
        """Boxes of the listed triangles, float64 (n_listed, 6)."""
        boxes: np.ndarray = triangle_boxes(self.local, self.triangles)
        return boxes


def keys_of_runs(a: np.ndarray, runs: np.ndarray) -> np.ndarray:
    """Keys of all triangles of some runs."""
    of, place = ranges(runs[:, 1], runs[:, 2] - runs[:, 1] + 1)
    rising, n_col = a[11] == 1, a[10]
    half = 1 - place % 2 if rising else place % 2
    return 2 * (runs[of, 0] * (n_col - 1) + place // 2) + half
