"""A corner-point grid: what a flow simulator takes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.conventions import volume_text
from geosurf.conventions.machine import need
from geosurf.lazy import xarray
from geosurf.model.base import Noun, frozen

GAUSS = 0.5 * (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0))  # of a unit interval, 2 points
AXES = ("I", "J", "K")


@dataclass(frozen=True, eq=False)
class GridFaces:
    """Faces between cells that lie on faults.

    Attributes
    ----------
    fault : ndarray of int64, shape (n,)
        Row of `CornerPointGrid.fault_names`.
    axis : ndarray of int64, shape (n,)
        0: the face towards the next I, 1: the next J, 2: the next K (a fault cuts the column).
    column : ndarray of int64, shape (n, 2)
        I and J of the cells, from 0.
    layers : ndarray of int64, shape (n, 2)
        First layer, and one past the last.
    """

    fault: np.ndarray
    axis: np.ndarray
    column: np.ndarray
    layers: np.ndarray

    def __len__(self) -> int:
        return len(self.fault)

    def among(self, n: int) -> GridFaces:
        """Return the faces on the first faults."""
        rows = self.fault < n
        return GridFaces(self.fault[rows], self.axis[rows], self.column[rows], self.layers[rows])


@dataclass(frozen=True, eq=False)
class CornerPointGrid(Noun):
    """Cells between straight pillars, for flow simulators.

    I grows along the first axis of the lattice, J 90 degrees to its left, K downwards.

    Parameters
    ----------
    coord : ndarray of float64, shape (ny + 1, nx + 1, 6)
        Each pillar: easting, northing and elevation of its top and of its base [m].
    levels : ndarray of float64, shape (nz + 1, ny, nx, 2, 2)
        Elevation of the layer boundaries at the corners of each column [m], from the top down; the
        last two axes are the corner along J and along I.
    actnum : ndarray of bool, shape (nz, ny, nx)
        False: the cell is pinched out, or outside the model.
    zone, block, unit : ndarray of int64, shape (nz, ny, nx)
        Rows of `zone_names`, `block_names` and `unit_names`; -1 in cells that are not active. Units
        are counted without their fluid contacts: one zone in one block.
    zone_names, block_names, fault_names : tuple of str
    unit_names : tuple of (str, str)
        Zone and block.
    unit_regions : tuple of str
        The region that each unit is in; '' for none.
    faces : GridFaces
        Faces of cells that lie on faults.
    exact : ndarray of float64, shape (n_unit,)
        Volume of each unit in the sealed model [m3].
    stair_steps : dict of str to (int, int)
        Per fault: pillars that step, and all pillars next to it.
    zones_of_model : tuple of str
        All zones of the model, youngest first: zones have the same colours in all pictures.

    See Also
    --------
    geosurf.build_grid : makes it.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes()
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> grid = gs.build_grid(scene, cell=(500, 500), layers={"Top/Base": 3})
    >>> grid.zcorn.shape, grid.coord.shape
    ((6, 12, 16), (7, 9, 6))
    >>> grid.unit_names, grid.region_names
    ((('Top/Base', 'F1+'), ('Top/Base', 'F1-')), ('B', 'A'))
    """

    coord: np.ndarray
    levels: np.ndarray
    actnum: np.ndarray
    zone: np.ndarray
    block: np.ndarray
    unit: np.ndarray
    zone_names: tuple[str, ...]
    block_names: tuple[str, ...]
    unit_names: tuple[tuple[str, str], ...]
    unit_regions: tuple[str, ...]
    fault_names: tuple[str, ...]
    faces: GridFaces
    exact: np.ndarray
    stair_steps: dict[str, tuple[int, int]]
    zones_of_model: tuple[str, ...]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of layers, of rows (J) and of columns (I)."""
        nz, ny, nx = self.actnum.shape
        return nz, ny, nx

    @property
    def region_names(self) -> tuple[str, ...]:
        """Names of the regions, parts of the field that run through all zones."""
        return tuple(name for name in dict.fromkeys(self.unit_regions) if name)

    @cached_property
    def region(self) -> np.ndarray:
        """Rows of `region_names`, -1 in cells without a region, int64 (nz, ny, nx)."""
        names = self.region_names
        rows = [names.index(name) if name else -1 for name in self.unit_regions]
        return frozen(np.array([*rows, -1])[self.unit], np.int64)

    @property
    def properties(self) -> tuple[tuple[str, list[str], np.ndarray], ...]:
        """What cells belong to: keyword, names, and rows of these, as decks have them."""
        units = [", ".join(one) for one in self.unit_names]
        return (
            ("ZONE", list(self.zone_names), self.zone),
            ("BLOCK", list(self.block_names), self.block),
            ("REGION", list(self.region_names), self.region),
            ("FIPNUM", units, self.unit),
        )

    @cached_property
    def zcorn(self) -> np.ndarray:
        """Elevation of all corners [m], float64 (2 nz, 2 ny, 2 nx), as Eclipse orders them."""
        nz, ny, nx = self.shape

        # top and base of each layer: layers have no gaps between them
        both = np.stack([self.levels[:-1], self.levels[1:]], axis=1)
        return frozen(both.transpose(0, 1, 2, 4, 3, 5).reshape(2 * nz, 2 * ny, 2 * nx), np.float64)

    def corners_of_layer(self, k: int) -> np.ndarray:
        """Corners of one layer [m], (ny, nx, 2, 2, 2, 3): top or base, along J, along I, x y z."""
        z = np.stack([self.levels[k], self.levels[k + 1]], axis=2)
        top, base = self._pillar_ends
        t = (top[..., 2] - z.transpose(2, 0, 1, 3, 4)) / (top[..., 2] - base[..., 2])
        xyz = top + t[..., None] * (base - top)
        xyz[..., 2] = z.transpose(2, 0, 1, 3, 4)
        return np.moveaxis(xyz, 0, 2)

    @cached_property
    def _pillar_ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Top and base of the pillars at the corners of each column, (ny, nx, 2, 2, 3)."""
        return tuple(
            np.stack(
                [
                    np.stack([end[:-1, :-1], end[:-1, 1:]], axis=2),
                    np.stack([end[1:, :-1], end[1:, 1:]], axis=2),
                ],
                axis=2,
            )
            for end in (self.coord[..., :3], self.coord[..., 3:])
        )  # type: ignore[return-value]

    @cached_property
    def volumes(self) -> np.ndarray:
        """Volume of each cell [m3], float64 (nz, ny, nx).

        Of the trilinear cell through its eight corners. Its Jacobian is of degree two along each
        axis, so that two Gauss points along each integrate it exactly.
        """
        return frozen(self._jacobians[0], np.float64)

    @cached_property
    def inside_out(self) -> np.ndarray:
        """Whether an active cell is inside out, bool (nz, ny, nx).

        Its base lies above its top at a pillar, or its Jacobian is negative at a Gauss point or at
        a corner.
        """
        bad = self._jacobians[1] < 0.0
        bad |= (np.diff(self.levels, axis=0) > 0.0).any(axis=(-1, -2))
        return frozen(bad & self.actnum, np.bool_)

    @cached_property
    def _jacobians(self) -> tuple[np.ndarray, np.ndarray]:
        """Volume, and the least Jacobian at Gauss points and corners, each (nz, ny, nx)."""
        total, least = np.empty(self.actnum.shape), np.empty(self.actnum.shape)
        for k in range(self.shape[0]):
            x = self.corners_of_layer(k)
            x = x - x[:, :, :1, :1, :1].mean(axis=(0, 1))  # small numbers: less rounding
            a, b, c = (np.moveaxis(x, axis, 0) for axis in (4, 3, 2))

            # an edge direction is linear along the two other axes: values at their Gauss points
            edges = [a[1] - a[0], b[1] - b[0], c[0] - c[1]]
            value, at_corners = (
                np.stack(
                    [
                        _triple(i[:, :, n, m], j[:, :, n, q], up[:, :, m, q])
                        for n, m, q in np.ndindex(2, 2, 2)
                    ]
                )
                for i, j, up in ([_at_gauss(_at_gauss(e, 2), 3) for e in edges], edges)
            )
            total[k], least[k] = value.sum(axis=0) / 8.0, np.minimum(value, at_corners).min(axis=0)
        return total, least

    @property
    def columns_of_units(self) -> np.ndarray:
        """Size of each unit [columns of its zone], float64 (n_unit,)."""
        zone = np.array([self.zone_names.index(name) for name, _ in self.unit_names])
        of_zone = np.bincount(zone, self.exact, minlength=len(self.zone_names))[zone]
        found: np.ndarray = self.exact / of_zone * self.actnum.any(axis=0).sum()
        return found

    @cached_property
    def table(self) -> xarray.Dataset:
        """Volume of each unit in the grid and in the sealed model, over ``unit``."""
        unit, n, attrs = self.unit[self.actnum], len(self.unit_names), {"units": "m3"}
        sums = np.bincount(unit, self.volumes[self.actnum], minlength=n)
        words = {
            "zone": [zone for zone, _ in self.unit_names],
            "block": [block for _, block in self.unit_names],
            "region": list(self.unit_regions),
        }
        return xarray.Dataset(
            {
                "cells": ("unit", np.bincount(unit, minlength=n)),
                "volume": ("unit", sums, attrs | {"long_name": "volume of active cells"}),
                "exact": ("unit", self.exact, attrs | {"long_name": "volume of the units"}),
            },
            {key: ("unit", np.array(of, dtype=object)) for key, of in words.items()},
        )

    def to_xtgeo(self) -> Any:
        """Return the grid as `xtgeo.Grid`, with the properties ZONE, BLOCK, REGION and FIPNUM.

        Raises
        ------
        DependencyError
            If xtgeo is not installed.
        """
        need("to_xtgeo needs", "xtgeo")
        import xtgeo

        nz, ny, nx = self.shape

        # xtgeo has one place for each node, and there the cells south-west, south-east, north-west
        # and north-east of it; at the rim those that are missing repeat the others
        z = np.pad(-self.levels, ((0, 0), (1, 1), (1, 1), (0, 0), (0, 0)), mode="edge")
        around = (
            z[:, :-1, :-1, 1, 1],
            z[:, :-1, 1:, 1, 0],
            z[:, 1:, :-1, 0, 1],
            z[:, 1:, 1:, 0, 0],
        )
        zcorn = np.stack(around, axis=-1).transpose(2, 1, 0, 3).copy()
        for at, use in (((0,), (0, 2)), ((nx,), (1, 3))):
            for missing, other in zip(use, ((1, 3) if at == (0,) else (0, 2)), strict=True):
                zcorn[at[0], :, :, missing] = zcorn[at[0], :, :, other]
        for j, pairs in ((0, ((0, 2), (1, 3))), (ny, ((2, 0), (3, 1)))):
            for missing, other in pairs:
                zcorn[:, j, :, missing] = zcorn[:, j, :, other]
        coord = self.coord.transpose(1, 0, 2).copy()
        coord[..., [2, 5]] *= -1.0
        properties = []
        for name, names, values in self.properties:
            codes = {k + 1: one for k, one in enumerate(names)}
            cells = (values + 1).transpose(2, 1, 0).astype(np.int32)
            properties.append(
                xtgeo.GridProperty(
                    ncol=nx, nrow=ny, nlay=nz, name=name, discrete=True, codes={0: "none", **codes},
                    values=cells,
                )
            )  # fmt: skip
        grid = xtgeo.Grid(
            coordsv=coord,
            zcornsv=zcorn.astype(np.float32),
            actnumsv=self.actnum.transpose(2, 1, 0).astype(np.int32),
        )
        grid.props = properties
        return grid

    def __repr__(self) -> str:
        nz, ny, nx = self.shape
        return (
            f"<CornerPointGrid: {nx} x {ny} x {nz} cells, {int(self.actnum.sum())} active, "
            f"{volume_text(float(self.volumes[self.actnum].sum()))}>"
        )


def _at_gauss(values: np.ndarray, axis: int) -> np.ndarray:
    """Values at both Gauss points of an axis, of those at its two ends."""
    first, last = (np.take(values, [end], axis) for end in (0, 1))
    return np.concatenate([(1.0 - g) * first + g * last for g in GAUSS], axis)


def _triple(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Triple product of vectors (..., 3)."""
    product: np.ndarray = (
        (a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]) * c[..., 0]
        + (a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]) * c[..., 1]
        + (a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]) * c[..., 2]
    )
    return product
