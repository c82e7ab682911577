"""Cells of one number -> a closed shell, and the unit that it bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.carve.volume import volume_of
from geosurf.errors import InvariantError
from geosurf.model import Patches, Unit, frozen


@dataclass(frozen=True)
class Shells:
    """Closed shells of all units.

    Attributes
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
        Vertices sorted by coordinates: shells and sums do not depend on the order of surfaces.
    sides : ndarray of int64, shape (n, 2)
        Unit in front of and behind each triangle; -1 outside.
    triangles, rows : list of ndarray of int64
        Of each unit: outward triangles, rows of `x`, and their rows in `Cells.triangles`.
    volumes : list of float
        [m3].
    """

    x: np.ndarray
    sides: np.ndarray
    triangles: list[np.ndarray]
    rows: list[np.ndarray]
    volumes: list[float]

    def corner(self, u: int) -> tuple[float, float, float]:
        """Western, southern and lower bound of a unit, local."""
        west, south, bottom = self.x[self.triangles[u]].min(axis=(0, 1)).tolist()
        return west, south, bottom

    def middle(self, u: int) -> np.ndarray:
        """Middle of the bounds of a unit, local."""
        corners = self.x[self.triangles[u]]
        middle: np.ndarray = 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))
        return middle


def shells_of(patches: Patches, cells: Cells, unit_of_cell: np.ndarray) -> Shells:
    """Close the shell of each unit, given the unit of each cell (-1 outside)."""
    order = np.lexsort(patches.local.T[::-1])
    x, rank = patches.local[order], np.argsort(order)
    sides = np.where(cells.cell_of_side > 0, unit_of_cell[cells.cell_of_side], -1)
    n_unit = int(unit_of_cell.max(initial=-1)) + 1
    faces = rank[cells.triangles]
    found = [_shell(faces, sides, u) for u in range(n_unit)]
    volumes = [volume_of(x, t) for t, _ in found]
    return Shells(x, sides, [t for t, _ in found], [rows for _, rows in found], volumes)


def _shell(triangles: np.ndarray, sides: np.ndarray, u: int) -> tuple[np.ndarray, np.ndarray]:
    """Outward triangles of a unit, and their rows; what it has on both sides is left out.

    Each starts at its lowest corner, and they are sorted by corners.
    """
    front, behind = sides[:, 0] == u, sides[:, 1] == u
    rows = np.flatnonzero(front != behind)
    t = triangles[rows]
    inward = front[rows]
    t[inward] = t[inward][:, [0, 2, 1]]
    first = t.argmin(axis=1)[:, None]
    t = np.take_along_axis(t, (first + np.arange(3)) % 3, axis=1)
    order = np.lexsort((t[:, 2], t[:, 1], t[:, 0]))
    return t[order], rows[order]


def build_unit(
    patches: Patches,
    cells: Cells,
    shells: Shells,
    u: int,
    *,
    zone: str,
    zone_index: int,
    block: str,
    contact: str,
) -> Unit:
    """Return one unit with its own vertices, its volume and its area."""
    used, faces = np.unique(shells.triangles[u], return_inverse=True)
    faces = faces.reshape(-1, 3)
    local, volume = shells.x[used], shells.volumes[u]
    a, b, c = (local[faces[:, k]] for k in range(3))
    area = math.fsum(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))
    name = " ".join(word for word in (zone, "" if block == "whole" else block, contact) if word)
    if volume <= 0:
        raise InvariantError(
            f"unit {name} has a volume of {volume:g} m3; please report this with the surfaces."
        )
    return Unit(
        name=name,
        zone=zone,
        zone_index=zone_index,
        block=block,
        contact=contact,
        local=frozen(local, np.float64),
        origin=patches.origin,
        triangles=frozen(faces, np.int64),
        surface_of_triangle=frozen(cells.surface_of[shells.rows[u]], np.int64),
        surface_names=patches.names,
        volume=volume,
        area=area,
    )
