"""The data of a horizon as places and elevations that realisations move up and down."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from scipy.spatial import Delaunay

from geosurf.conventions.checks import are_points
from geosurf.errors import InputError
from geosurf.model import Lattice, Sheet, TriSurface
from geosurf.sheets.lattice.data import points_of
from geosurf.triangulate import triangulate_horizon


@dataclass(frozen=True, eq=False)
class HorizonData:
    """
    Nodes of a grid, vertices of a mesh, or points.

    Attributes
    ----------
    name : str
    surface : TriSurface or None
        The grid or mesh; None for points.
    points : ndarray of float64, shape (n, 3)
        World coordinates [m]; of a grid all nodes, NaN where one is absent.

    Examples
    --------
    >>> from geosurf.synthetic import tilted_planes
    >>> data = HorizonData.of("Top", tilted_planes(n=5).horizons["Top"])
    >>> data.points.shape, data.moved(np.ones(25)).bounds[4] - data.surface.bounds[4]
    ((25, 3), 1.0)
    """

    name: str
    surface: TriSurface | None
    points: np.ndarray

    @classmethod
    def of(cls, name: str, value: Any, words: dict[str, Any] | None = None) -> HorizonData:
        """Return the data of a horizon as a scene has it; a sheet is refused."""
        words = words or {}
        # A sheet ends on its faults exactly; moved data would no longer.
        if isinstance(value, Sheet):
            raise InputError(
                f"horizon {name!r} is a sheet, torn at its faults already: errors would move it "
                "off them. Give its data with Scene(tear=True), or the horizon before faulting "
                "with Throw(...)."
            )
        # Points have no surface before they are gridded.
        if not isinstance(value, TriSurface) and are_points(value):
            positive, unit = words.get("positive"), words.get("length_unit")
            return cls(name, None, points_of(value, name, positive, unit)[1])
        if not isinstance(value, TriSurface):
            value = triangulate_horizon(value, name=name, **words)
        # A mesh moves vertex by vertex.
        if value.lattice is None:
            return cls(name, value, value.vertices)
        x, y = value.lattice.horizontal()
        columns = [np.ravel(part) for part in (x, y, value.lattice.elevation)]
        return cls(name, value, np.stack(columns, axis=1))

    def moved(self, up: np.ndarray) -> Any:
        """Return the horizon with each node moved up [m], as a scene takes it."""
        # The same kind of object comes back, so that the scene treats it as before.
        if self.surface is None:
            return self._points_at(self.points[:, 2] + up)
        lattice = self.surface.lattice
        elevation = self.points[:, 2] + up
        if lattice is None:
            vertices = np.column_stack([self.points[:, :2], elevation])
            made = TriSurface(self.name, "horizon", vertices, self.surface.triangles)
        else:
            # The axes are shared; only elevations are new.
            made = TriSurface(self.name, "horizon", lattice=Lattice(
                lattice.easting, lattice.northing, elevation.reshape(lattice.shape),
                lattice.rising, lattice.reverse,
            ))  # fmt: skip
        made.crs = self.surface.crs
        return made

    def _points_at(self, elevation: np.ndarray) -> Any:
        """The points at other elevations, as `read_points` returns them."""
        # Elevations in metres, whatever the file had: they were converted when it was read.
        metre = {"units": "m"}
        columns = {
            "easting": ("point", self.points[:, 0].copy(), metre),
            "northing": ("point", self.points[:, 1].copy(), metre),
            "elevation": ("point", elevation, metre | {"positive": "up"}),
        }
        return xr.Dataset(columns)

    @cached_property
    def there(self) -> np.ndarray:
        """Rows of the points that exist."""
        return np.flatnonzero(np.isfinite(self.points).all(axis=1))

    def shares_at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return which points determine the elevation at some places in the map, and by which shares.

        Parameters
        ----------
        places : ndarray of float64, shape (n, 2)

        Returns
        -------
        (ndarray of int64 (n, 3), ndarray of float64 (n, 3))
            Corners of the triangle there. Shares are NaN outside of the horizon. Of points, the
            triangle of the Delaunay triangulation.
        """
        # Points have no triangles of their own: those of Delaunay stand for them.
        if self.surface is None:
            at = self.points[self.there, :2]
            # Around their mean: coordinates of millions cost the triangulation its digits.
            corners = self.there[Delaunay(at - at.mean(axis=0)).simplices]
        elif self.surface.lattice is None:
            corners = self.surface.triangles
        else:
            # Triangles refer to vertices; absent nodes have none.
            rows = np.flatnonzero(self.surface.lattice.present.ravel())
            corners = rows[self.surface.triangles]
        return _shares(self.points[:, :2], corners, places)


def _shares(
    at: np.ndarray, corners: np.ndarray, places: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Corners and barycentric shares of the triangle in which each place lies, the first found."""
    boxes = at[corners]
    low, high = boxes.min(axis=1), boxes.max(axis=1)
    found = np.zeros((len(places), 3), dtype=np.int64)
    shares = np.full((len(places), 3), np.nan)
    # Wells are few, so each is looked up by itself.
    for k, place in enumerate(places):
        # Triangles whose rectangle has the place.
        near = np.flatnonzero(((low <= place) & (place <= high)).all(axis=1))
        if not len(near):
            continue
        a, b, c = (boxes[near, i] - place for i in range(3))
        # Areas opposite to each corner, as shares of the whole.
        part = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            part = part / part.sum(axis=1, keepdims=True)
        # On an edge two triangles hold the place: the one where it lies deepest.
        best = int(np.nan_to_num(part.min(axis=1), nan=-1.0).argmax())
        # A little outside counts as on the edge.
        if part[best].min() >= -1e-9:
            found[k], shares[k] = corners[near[best]], part[best]
    return found, shares


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
