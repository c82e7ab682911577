"""What the checks of a certificate read: the elements of a model, and triangles where curves are.

An element is a triangle, or a run of lattice triangles that no curve touches. `Elements.of` makes
each triangle an element; `geosurf.carve.certificate.facts` leaves runs as they are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.carve.outside import box_of
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.search.voxels import faces_in_box, triangle_boxes
from geosurf.model import Patches, TriSurface

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
        rise = np.bincount(of[inside], rise_of(x, t[inside]), minlength=len(patches.sources))
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
            return self.local, self.triangles[listed], of, _first_of(of, len(wanted))[starts]

        # one triangle of each start, from which its ray runs along the axis on which it is widest
        is_start = np.zeros(len(wanted), dtype=bool)
        is_start[starts] = True
        listed = np.flatnonzero(is_start[self.element])
        runs = self.near(starts, np.zeros((0, 6)), wanted)
        origin = np.concatenate([self.local[self.triangles[listed]], runs[0]])
        of = np.concatenate([self.element[listed], runs[1]])
        some = origin[_first_of(of, len(wanted))[starts]]
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
        first = _first_of(of, len(wanted))[starts]
        return x, np.arange(len(x)).reshape(-1, 3), of, first

    @cached_property
    def _boxes(self) -> np.ndarray:
        """Boxes of the listed triangles, float64 (n_listed, 6)."""
        boxes: np.ndarray = triangle_boxes(self.local, self.triangles)
        return boxes


def _first_of(of: np.ndarray, n: int) -> np.ndarray:
    """The first row of each of n elements among some rows; -1 where there is none."""
    first = np.full(n, -1)
    first[of[::-1]] = np.arange(len(of))[::-1]
    return first


def rise_of(x: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Twice the area of triangles in the map, below 0 where they look down."""
    a, b, c = (x[t[:, k]] for k in range(3))
    rise: np.ndarray = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return rise


def keys_of_runs(a: np.ndarray, runs: np.ndarray) -> np.ndarray:
    """Keys of all triangles of some runs."""
    n = runs[:, 2] - runs[:, 1] + 1
    place = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n - runs[:, 1], n)
    rising, n_col = a[11] == 1, a[10]
    half = 1 - place % 2 if rising else place % 2
    return 2 * (np.repeat(runs[:, 0], n) * (n_col - 1) + place // 2) + half
