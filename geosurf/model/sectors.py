"""Where a moved horizon would be on given sides of two faults, also where it is cut away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Sector:
    """One of the four wedges between two faults, and the horizon in it as if it had no end.

    Where faults cross closer to a horizon than their throws, a wedge has no piece of the horizon.
    Whether it lies above or below follows from where the horizon would be.

    Attributes
    ----------
    faults : (str, str)
        Names of the faults.
    front : (bool, bool)
        Whether the wedge is on the front of each fault, its hanging wall.
    corner : ndarray of float64, shape (2,)
        Easting and northing of the first node [m].
    step : ndarray of float64, shape (2, 2)
        One column and one row on [m].
    elevation : ndarray of float64, shape (n_row, n_col)
        Of the horizon [m]; NaN where it is not known, such as next to further faults.
    rising : bool
        Which diagonal splits each cell, as in `Lattice`.
    """

    faults: tuple[str, str]
    front: tuple[bool, bool]
    corner: np.ndarray
    step: np.ndarray
    elevation: np.ndarray
    rising: bool

    def at(self, places: np.ndarray) -> np.ndarray:
        """Return the elevation at places in the map.

        Parameters
        ----------
        places : ndarray of float64, shape (n, 2)
            Easting and northing [m].

        Returns
        -------
        ndarray of float64, shape (n,)
            [m]; NaN where it is not known. Beyond the lattice its outermost triangles go on.
        """
        from geosurf.kernels.sheets.moved_rock import heights_on_triangles

        x, y = ((places - self.corner) @ np.linalg.inv(self.step)).T.copy()
        found = np.empty(len(places))
        heights_on_triangles(np.ascontiguousarray(self.elevation), self.rising, x, y, found)
        return found
