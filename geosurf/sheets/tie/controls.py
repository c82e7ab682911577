"""Well tops on a cut horizon: what correction each needs, and why others are not used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.kernels.lattices.sets import pairs_of_equal
from geosurf.kernels.meshes.mesh import edge_keys, join_pairs
from geosurf.kernels.search.columns import shares_at
from geosurf.measure.columns import columns_through, fault_between, nearest_first
from geosurf.model import Patches, Sheet, TriSurface
from geosurf.model.tops import Tops
from geosurf.rebuild import rebuild_surfaces, trim_sheets

# ---- cut horizon ----------------------------------------
# A horizon cut at its faults: triangles that are joined only where no fault separates them.


@dataclass(frozen=True, eq=False)
class CutHorizon:
    """One horizon between its faults.

    Attributes
    ----------
    patches : Patches
        The horizon and its faults, cut and trimmed.
    rows : ndarray of int64, shape (n,)
        Triangles of the horizon, rows of the patches.
    triangles : ndarray of int64, shape (n, 3)
        The same as corners in `x`; walls of a fault share none.
    x : ndarray of float64, shape (n_vertex, 3)
        World coordinates [m].
    walls : ndarray of int64, shape (n_wall, 2)
        Edges of the triangles that lie on a fault, rows of `x`.
    """

    patches: Patches
    rows: np.ndarray
    triangles: np.ndarray
    x: np.ndarray
    walls: np.ndarray

    @cached_property
    def cell(self) -> float:
        """Typical width of the horizon's cells [m]: two triangles of median area."""
        a, b, c = (self.x[self.triangles[:, k], :2] for k in range(3))
        (ux, uy), (vx, vy) = (b - a).T, (c - a).T
        return float(np.sqrt(np.median(np.abs(ux * vy - uy * vx))))

    @cached_property
    def by_place(self) -> tuple[np.ndarray, np.ndarray]:
        """Vertices in order of their easting and northing, and these as one key each."""
        key = place_keys(self.x)
        order = np.argsort(key, kind="stable")
        return order, key[order]


def cut_horizon(horizon: TriSurface | Sheet, faults: Sequence[TriSurface]) -> CutHorizon:
    """
    Cut a horizon at faults; a torn sheet loses what lies beyond them.

    Parameters
    ----------
    horizon : TriSurface or Sheet
    faults : sequence of TriSurface

    Returns
    -------
    CutHorizon
    """
    surface = horizon.surface if isinstance(horizon, Sheet) else horizon
    patches = trim_sheets(rebuild_surfaces([surface, *faults]))

    # surface 0 is the horizon, all others are its faults
    on_horizon = patches.surface_of_triangle == 0
    rows = np.flatnonzero(on_horizon)
    faces = patches.triangles[rows]
    walls = patches.triangles[~on_horizon]

    # on_fault (3 n,): edges of the horizon that faults have as well; exact, as both share points
    on_fault = np.isin(edge_keys(faces, len(patches.local)), edge_keys(walls, len(patches.local)))
    corner = _own_corners(faces, on_fault, len(patches.local))

    # one point for each wall: points on a fault are there twice, a tip only once
    first = np.unique(corner, return_index=True)[1]
    x = patches.vertices[faces.ravel()[first]]
    ends = np.stack([corner, corner.reshape(-1, 3)[:, [1, 2, 0]].ravel()], axis=1)
    return CutHorizon(patches, rows, corner.reshape(-1, 3), x, ends[on_fault])


def _own_corners(faces: np.ndarray, on_fault: np.ndarray, n_vertex: int) -> np.ndarray:
    """Number of the vertex at each corner (3 n,), one for each wall of a fault.

    `on_fault` marks the edges (3 n,) from each corner to the next. Corners are one vertex if a
    chain of edges that no fault runs along joins their triangles.
    """
    key = edge_keys(faces, n_vertex)

    # half-edges with the same key follow each other; pairs half, twin are the two sides of an edge
    half, twin = pairs_of_equal(key, np.flatnonzero(~on_fault))

    # both ends of a common edge: corner k of a triangle, and the one after it
    flat = faces.ravel()
    after = np.arange(len(flat)).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    starts = np.where(flat[half] == flat[twin], twin, after[twin])
    ends = np.where(flat[half] == flat[twin], after[twin], twin)
    a, b = np.concatenate([half, after[half]]), np.concatenate([starts, ends])

    # corners that are joined are one vertex
    joined = join_pairs(np.stack([a, b], axis=1), len(flat))
    return np.unique(joined, return_inverse=True)[1]


def place_keys(points: np.ndarray) -> np.ndarray:
    """Easting and northing of points as one complex number each, to find equal places."""
    return np.ascontiguousarray(points[:, :2]).view(np.complex128).ravel()


@dataclass(frozen=True, eq=False)
class Controls:
    """Tops that a horizon is tied to.

    Attributes
    ----------
    top : ndarray of int64, shape (n,)
        Row of the tops.
    triangle : ndarray of int64, shape (n,)
        Row of `CutHorizon.triangles` above or below the top.
    share : ndarray of float64, shape (n, 3)
        Shares of its corners in the elevation there.
    residual : ndarray of float64, shape (n,)
        Top minus horizon: the correction that is missing [m].
    unused : dict of int to str
        Other tops of the horizon, each with its reason.
    """

    top: np.ndarray
    triangle: np.ndarray
    share: np.ndarray
    residual: np.ndarray
    unused: dict[int, str]

    @property
    def largest(self) -> float:
        """Largest residual [m]."""
        return float(np.abs(self.residual).max(initial=0.0))


def controls_of(cut: CutHorizon, tops: Tops, rows: np.ndarray) -> Controls:
    """
    Compare tops with the horizon above or below them.

    Parameters
    ----------
    cut : CutHorizon
    tops : Tops
    rows : ndarray of int64
        Tops of this horizon.

    Returns
    -------
    Controls
    """
    columns = columns_through(cut.patches, tops.points[rows])
    names = cut.patches.names
    unused: dict[int, str] = {}
    used: list[tuple[int, int]] = []
    for k, row in enumerate(rows.tolist()):
        at = columns.at(k)
        z, surface = columns.elevation[at], columns.surface[at]
        picked = float(tops.points[row, 2])
        faults, on_horizon = np.flatnonzero(surface != 0), np.flatnonzero(surface == 0)
        fault_names = [names[i] for i in surface[faults].tolist()]
        if not len(on_horizon):
            unused[row] = "lies outside the data of the horizon"
            if fault_names:
                nearest = fault_names[int(np.abs(z[faults] - picked).argmin())]
                unused[row] = f"lies in the gap of fault {nearest!r}"
            continue
        best = int(on_horizon[nearest_first(z[on_horizon], picked)[0]])
        between = fault_between(z[faults], fault_names, picked, float(z[best]))
        if between:
            unused[row] = f"lies on the other side of fault {between!r} than the horizon there"
            continue
        used.append((row, at.start + best))
    top, crossing = np.array(used, dtype=np.int64).reshape(-1, 2).T
    triangle = np.searchsorted(cut.rows, columns.triangle[crossing])
    residual = tops.points[top, 2] - columns.elevation[crossing]
    share = shares_in(cut, triangle, tops.points[top, :2])
    return Controls(top, triangle, share, residual, unused)


def shares_in(cut: CutHorizon, triangle: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Shares (n, 3) of the corners of triangles in values at places (n, 2) inside them."""
    return shares_at(cut.x[cut.triangles[triangle]], places)
