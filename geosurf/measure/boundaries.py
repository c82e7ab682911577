"""All triangles that bound units, in a tree of boxes: distances to them, lines through them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.kernels.lattices.triangle_list import build_list_tree, survey_list
from geosurf.kernels.location.nearest import nearest_distance, point_codes
from geosurf.kernels.search.rays import rows_in_box
from geosurf.model import Patches, Units


@dataclass(frozen=True, eq=False)
class Boundaries:
    """The boundaries of all units.

    Attributes
    ----------
    origin : ndarray of float64, shape (3,)
    x : ndarray of float64, shape (n_vertex, 3)
        Local coordinates.
    triangles : ndarray of int64, shape (n_triangle, 3)
        Those with different units, or the outside, in front and behind.
    boxes : ndarray of float64, shape (n_triangle, 6)
    tree : tuple of ndarray
    """

    origin: np.ndarray
    x: np.ndarray
    triangles: np.ndarray
    boxes: np.ndarray
    tree: tuple[np.ndarray, np.ndarray, np.ndarray]

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distance of points (n, 3), in world coordinates, to the nearest triangle [m]."""
        local = points - self.origin

        # along a Morton curve: the nearest triangle of one point is a good guess for the next
        order = np.argsort(point_codes(local, self.tree[1][-1]), kind="stable")
        found, out = np.empty(len(points)), np.empty(len(points))
        nearest_distance(self.x, self.triangles, *self.tree, local[order], found)
        out[order] = found
        return out

    def near(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Corners (n, 3, 3) of the triangles whose boxes meet a box, local."""
        box = np.concatenate([low, high])

        # asked once more with room for all, if the first array was too short
        rows = np.empty(256, dtype=np.int64)
        n = rows_in_box(*self.tree, self.boxes, box, rows)
        if n > len(rows):
            rows = np.empty(n, dtype=np.int64)
            rows_in_box(*self.tree, self.boxes, box, rows)
        corners: np.ndarray = self.x[self.triangles[np.sort(rows[:n])]]
        return corners


def boundaries_of(patches: Patches, units: Units) -> Boundaries:
    """
    Put all triangles that bound a unit into a tree.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.graben(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> found = boundaries_of(scene.patches, scene.units)
    >>> found.distance(np.array([[1000.0, 1000.0, scene.box[5] + 3.0]])).tolist()
    [3.0]
    """
    rows = np.flatnonzero(units.sides[:, 0] != units.sides[:, 1])
    x, triangles = patches.local, np.ascontiguousarray(patches.triangles[rows])
    boxes, codes, _, _ = survey_list(x, triangles)
    return Boundaries(patches.origin, x, triangles, boxes, build_list_tree(boxes, codes))
