"""Triangulated horizons: whether "above" and "below" mean something.

A closed body (salt, a lens) has an inside and an outside instead: it is refused. A sheet that
folds over itself (a recumbent fold, a flank of salt) has both sides, but what lies on its upper
side is not everywhere above it: that is allowed, and a warning names the share.
"""

from __future__ import annotations

import numpy as np

from geosurf.conventions import place, volume_text
from geosurf.errors import GeosurfWarning, SurfaceError
from geosurf.model import TriSurface
from geosurf.triangulate.orient import sheets_that_agree
from geosurf.warning import warn


def check_horizon_mesh(surface: TriSurface) -> None:
    """
    Refuse a horizon that is, or has in it, a closed body; warn of one that folds over itself.

    Parameters
    ----------
    surface : TriSurface
        A gridded one passes: it cannot fold.

    Raises
    ------
    SurfaceError
        For a closed body, with its volume and place; for a sheet with only one side.

    Examples
    --------
    >>> corners = [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]]
    >>> faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    >>> check_horizon_mesh(TriSurface("Salt", "horizon", corners, faces))
    Traceback (most recent call last):
    geosurf.errors.SurfaceError: horizon 'Salt' is a closed body of 122 m³ around \
(E 2.25, N 2.25, elevation 2.25 m), so nothing is above or below it. Pass it as a \
fault, faults={'Salt': ...}; its inside becomes a block.
    """
    if surface.lattice is not None or surface.n_triangle == 0:
        return

    # Relative to a corner, so that products of large coordinates do not lose digits.
    low = surface.vertices.min(axis=0)
    corners = (surface.vertices - low)[surface.triangles]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])  # in the map, with its sign
    if (area >= 0).all() or (area <= 0).all():
        return  # a closed body, or a fold, has triangles of both kinds

    turned, sheet, neighbour = sheets_that_agree(surface)
    sign = np.where(turned, -1.0, 1.0)
    n_sheet = int(sheet.max()) + 1

    # A sheet without a rim is closed.
    rims = np.bincount(sheet, (neighbour < 0).any(axis=1), n_sheet)
    for k in np.flatnonzero(rims == 0):
        mine = sheet == k
        # Signed volume by the divergence theorem: tetrahedra with the origin.
        volume = np.linalg.det(corners[mine]) / 6.0
        take = "" if n_sheet == 1 else "Remove it from the horizon. "
        at = place(corners[mine].reshape(-1, 3)[_distinct(surface, mine)].mean(axis=0) + low)
        raise SurfaceError(
            f"horizon {surface.name!r} {'is' if n_sheet == 1 else 'holds'} a closed body of "
            f"{volume_text(abs(float((sign[mine] * volume).sum())))} around {at}, so nothing "
            f"is above or below it. {take}Pass it as a fault, faults={{{surface.name!r}: "
            "...}; its inside becomes a block."
        )
    _warn_of_folds(surface, area * sign, sheet, corners + low)


def _distinct(surface: TriSurface, mine: np.ndarray) -> np.ndarray:
    """One corner, of those of some triangles, for each of their vertices."""
    return np.unique(surface.triangles[mine].ravel(), return_index=True)[1]


def _warn_of_folds(
    surface: TriSurface, area: np.ndarray, sheet: np.ndarray, corners: np.ndarray
) -> None:
    """Warn of the parts of each sheet that look the other way than most of it."""
    # Each sheet faces the way that most of its area does; the rest folds over.
    up = np.bincount(sheet, area) >= 0
    area = np.where(up[sheet], area, -area)
    over = area < 0
    if not over.any():
        return

    share = float(-area[over].sum() / np.abs(area).sum())
    largest = int(np.argmin(area))
    warn(
        GeosurfWarning(
            "fold",
            surface.name,
            f"Horizon {surface.name!r} folds over itself on {100 * share:.2g} % of its map "
            "area. There, the zone above the horizon lies below it.",
            "If it should not fold, simplify it there, or convert it to a grid.",
            corners[largest].mean(axis=0),
        )
    )
