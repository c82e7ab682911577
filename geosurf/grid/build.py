"""From a model to a corner-point grid, step by step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from geosurf.errors import InputError, InvariantError
from geosurf.grid import corners as at_corners
from geosurf.grid.barriers import Below, faults_between, own_side
from geosurf.grid.cells import PER_COLUMN, faces_of, lengths_in, regions_of_cells
from geosurf.grid.follow import follow_faults
from geosurf.grid.lattice import ArealLattice, inside_outline
from geosurf.grid.layers import Layers
from geosurf.grid.lines import Pieces, Shell, pieces_along
from geosurf.grid.pillars import Pillars, vertical_pillars
from geosurf.grid.refine import refined
from geosurf.model import TriSurface, Units
from geosurf.model.grids import CornerPointGrid

SMOOTH = 5  # columns over which the middle of the grid is averaged


class GriddedModel(Protocol):
    """What `build_grid` asks of a scene."""

    @property
    def units(self) -> Units:
        """Closed units."""

    @property
    def box(self) -> tuple[float, float, float, float, float, float]:
        """West, east, south, north, bottom, top [m]."""

    @property
    def aoi(self) -> np.ndarray | None:
        """Corners of the area of interest (n, 2) [m]; None if it is the box."""

    @property
    def fault_names(self) -> tuple[str, ...]:
        """Names of the faults."""

    @property
    def horizon_names(self) -> tuple[str, ...]:
        """Names of the horizons, youngest first."""

    def surface(self, name: str) -> TriSurface:
        """Return one surface by name."""


@dataclass(frozen=True, eq=False)
class Model:
    """A model in coordinates of the lattice.

    Attributes
    ----------
    lattice : ArealLattice
    shells : list of Shell
        Units of the zones of the grid, before pillars are made vertical.
    faults : dict of str to (ndarray, ndarray)
        Vertices and triangles.
    outline : ndarray of float64, shape (n, 2)
        Of the area.
    regions : list of (str, str)
    exact : ndarray of float64
        Volume of each region [m3].
    zones : list of int
        From the top down.
    """

    lattice: ArealLattice
    shells: list[Shell]
    faults: dict[str, tuple[np.ndarray, np.ndarray]]
    outline: np.ndarray
    regions: list[tuple[str, str]]
    exact: np.ndarray
    zones: list[int]

    @cached_property
    def inside(self) -> np.ndarray:
        """Whether the middle of each column is in the area, (ny, nx)."""
        ny, nx = self.lattice.shape
        i, j = np.meshgrid(np.arange(nx) + 0.5, np.arange(ny) + 0.5)
        return inside_outline(np.stack([i, j], axis=-1), self.outline)

    def holds(self, pillars: Pillars, feet: np.ndarray) -> np.ndarray:
        """Whether lines parallel to pillars stay in the area."""
        low, high = pillars.ends(feet)
        return inside_outline(low, self.outline) & inside_outline(high, self.outline)

    @cached_property
    def fine_faults(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Faults with triangles no longer than a cell, so that they bend with the pillars."""
        return [refined(*one, self.lattice.shape) for one in self.faults.values()]

    @property
    def middle(self) -> np.ndarray:
        """Middle of the lattice."""
        ny, nx = self.lattice.shape
        return np.array([0.5 * nx, 0.5 * ny])


def model_of(scene: GriddedModel, lattice: ArealLattice, zones: list[str]) -> Model:
    """Bring units and faults of a scene into coordinates of a lattice."""
    origin = np.array([*lattice.corner, 0.0])

    def to_lattice(local: np.ndarray, its_origin: np.ndarray) -> np.ndarray:
        x = local + (its_origin - origin)
        return np.concatenate([lattice.to_lattice(x[:, :2]), x[:, 2:]], axis=1)

    # one region for each zone and block: contacts do not split cells
    mine = [unit for unit in scene.units.values() if unit.zone in zones]
    if not mine:
        raise InputError(f"no unit of the model is in the zones {zones}. Print scene.units.")
    regions = list(dict.fromkeys((unit.zone, unit.block) for unit in mine))
    index = {name: k for k, name in enumerate(zones)}
    shells = [
        Shell(
            index[unit.zone],
            regions.index((unit.zone, unit.block)),
            to_lattice(unit.local, unit.origin),
            unit.triangles,
        )
        for unit in mine
    ]
    exact = [math.fsum(u.volume for u in mine if (u.zone, u.block) == one) for one in regions]
    w, e, s, n = scene.units.box[:4]
    ring = np.array([[w, s], [e, s], [e, n], [w, n]]) if scene.aoi is None else scene.aoi
    faults = {}
    for name in scene.fault_names:
        one = scene.surface(name)
        faults[name] = (to_lattice(one.vertices, np.zeros(3)), one.triangles)
    outline = lattice.to_lattice(ring - lattice.corner)
    return Model(
        lattice, shells, faults, outline, regions, np.array(exact), list(range(len(zones)))
    )


@dataclass(frozen=True, eq=False)
class Columns:
    """A model as its columns between pillars see it.

    Attributes
    ----------
    model : Model
    pillars : Pillars
    pieces : Pieces
        Of `PER_COLUMN` lines for each column.
    thick : ndarray of float64, shape (n_line, n_zone)
    top : ndarray of float64, shape (n_line,)
    faults : list of (ndarray, ndarray)
    shells : list of Shell
        In coordinates in which pillars are vertical.
    """

    model: Model
    pillars: Pillars
    pieces: Pieces
    thick: np.ndarray
    top: np.ndarray
    faults: list[tuple[np.ndarray, np.ndarray]]
    shells: list[Shell]

    @cached_property
    def by_column(self) -> tuple[np.ndarray, np.ndarray]:
        """Samples (ny, nx, 2, 2, 1 + n_zone) at Gauss points: top, thicknesses; which are valid."""
        ny, nx = self.model.lattice.shape
        gauss = np.concatenate([self.top[:, None], self.thick], axis=1)
        gauss = gauss.reshape(ny, nx, PER_COLUMN, -1)[:, :, :4]
        samples = gauss.reshape(ny, nx, 2, 2, gauss.shape[-1])
        return samples, np.isfinite(samples[..., 0])

    @cached_property
    def used(self) -> np.ndarray:
        """Columns in the area that meet a zone of the grid, (ny, nx)."""
        found: np.ndarray = self.model.inside & self.by_column[1].any(axis=(-1, -2))
        return found

    @cached_property
    def filled(self) -> np.ndarray:
        """Samples without gaps; columns that are not used have those of the nearest one."""
        from scipy.ndimage import distance_transform_edt

        samples = at_corners.filled(*self.by_column)
        if not self.used.any():
            raise InputError("no column of the grid meets a zone. Choose smaller cells.")
        j, i = distance_transform_edt(~self.used, return_distances=False, return_indices=True)
        return samples[j, i]

    @cached_property
    def middles(self) -> np.ndarray:
        """Elevation of the middle of each zone in each column, (n_zone, ny, nx)."""
        mean = self.filled.mean(axis=(2, 3))
        depth = np.cumsum(mean[..., 1:], axis=-1) - 0.5 * mean[..., 1:]
        return np.moveaxis(mean[..., :1] - depth, -1, 0)


def columns_of(model: Model, pillars: Pillars) -> Columns:
    """Sample a model along five lines for each column between pillars."""
    shells = [Shell(s.zone, s.region, pillars.straighten(s.x), s.triangles) for s in model.shells]
    ny, nx = model.lattice.shape
    feet = np.empty((ny, nx, PER_COLUMN, 2))
    feet[:, :, :4] = at_corners.gauss_feet((ny, nx)).reshape(ny, nx, 4, 2)
    feet[:, :, 4] = np.stack(np.meshgrid(np.arange(nx) + 0.5, np.arange(ny) + 0.5), axis=-1)
    pieces = pieces_along(shells, feet.reshape(-1, 2), model.middle)
    thick, top = lengths_in(pieces, ny * nx * PER_COLUMN, model.zones)

    # a line that leaves the area meets its wall, not the horizons
    out = ~model.holds(pillars, feet.reshape(-1, 2))
    thick[out], top[out] = 0.0, -np.inf
    faults = [(pillars.straighten(x), t) for x, t in model.fine_faults]
    return Columns(model, pillars, pieces, thick, top, faults, shells)


def around_nodes(values: np.ndarray) -> list[np.ndarray]:
    """Values (ny, nx) of the four columns around each node, each (ny + 1, nx + 1)."""
    wide = np.pad(values, 1, mode="edge")
    return [wide[:-1, :-1], wide[1:, :-1], wide[:-1, 1:], wide[1:, 1:]]


def pillars_along_faults(
    model: Model, min_dip: float
) -> tuple[Pillars, np.ndarray, dict[str, tuple[int, int]]]:
    """Return pillars along faults, which of them follow one, and by fault how many step."""
    from scipy.ndimage import uniform_filter

    ny, nx = model.lattice.shape
    columns = columns_of(model, vertical_pillars((ny, nx)))
    mean = columns.filled.mean(axis=(2, 3))
    total = mean[..., 1:].sum(axis=-1)
    top, base = mean[..., 0], mean[..., 0] - total

    # smooth over several columns: where it jumps by the throw, a fault lies between two pairs
    middle = uniform_filter(0.5 * (top + base), SMOOTH, mode="nearest")
    faults = list(model.faults.values())
    between = faults_between(faults, middle[None], columns.used)

    # at a node the mean of the columns around it
    level = np.mean(around_nodes(middle), axis=0)
    above = np.max(around_nodes(top), axis=0) - level
    reach = np.maximum(above, level - np.min(around_nodes(base), axis=0)) + 1.0
    cell = model.lattice.cell
    pillars, follows, counts = follow_faults(faults, between, level, reach, cell, min_dip)
    rows = zip(model.faults, counts.tolist(), strict=True)
    return pillars, follows, {name: (step, n) for name, (step, n) in rows if n}


def corners_of(columns: Columns, between: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Top and thicknesses at the corners of all columns, (ny, nx, 2, 2, 1 + n_zone)."""
    samples = columns.filled.copy()
    same = own_side(columns.faults, columns.middles.mean(axis=0), columns.used)
    samples[..., :1] = at_corners.filled(samples[..., :1], same)
    found = at_corners.to_corners(np.moveaxis(samples, -1, 2))
    found[:, :, 1:] = at_corners.limited(found[:, :, 1:])
    found = np.moveaxis(found, 2, -1)

    # columns that no fault parts at any level share their corners
    apart_i, apart_j = (np.asarray(one.any(axis=(0, 1))) for one in between)
    group = at_corners.groups_at_nodes(apart_i, apart_j, columns.used)
    found = at_corners.joined(found, group)
    return _on_horizons(columns, found, apart_i, apart_j)


def _on_horizons(
    columns: Columns, found: np.ndarray, apart_i: np.ndarray, apart_j: np.ndarray
) -> np.ndarray:
    """Put nodes that no fault is near exactly on the horizons: their own line decides."""
    used = columns.used
    whole = used[:-1, :-1] & used[:-1, 1:] & used[1:, :-1] & used[1:, 1:]
    whole &= ~(apart_i[:-1] | apart_i[1:] | apart_j[:, :-1] | apart_j[:, 1:])
    j, i = np.nonzero(whole)
    feet = np.stack([i + 1.0, j + 1.0], axis=1)
    pieces = pieces_along(columns.shells, feet, columns.model.middle)
    thick, top = lengths_in(pieces, len(feet), columns.model.zones)
    good = np.isfinite(top) & columns.model.holds(columns.pillars, feet)
    j, i = j[good], i[good]
    values = np.concatenate([top[good, None], thick[good]], axis=1)
    for a, b in at_corners.CORNERS:
        found[j + 1 - a, i + 1 - b, a, b] = values
    return found


def assemble(
    columns: Columns,
    pillars: Pillars,
    layers: dict[str, Layers],
    min_thickness: float,
    stair_steps: dict[str, tuple[int, int]],
    zones_of_model: Sequence[str],
) -> CornerPointGrid:
    """Make the cells of a grid."""
    model = columns.model
    between = faults_between(columns.faults, columns.middles, columns.used)
    found = corners_of(columns, between)
    ny, nx = columns.used.shape

    # boundaries of layers, zone by zone from the top down
    levels, shares, first = [found[..., 0][None]], [], [0]
    for k, one in enumerate(layers.values()):
        depth = one.boundaries(found[..., 1 + k])
        mean = depth.mean(axis=(-1, -2)).reshape(len(depth), -1)
        total = np.where(mean[-1] > 0.0, mean[-1], 1.0)
        shares.append(0.5 * (mean[1:] + mean[:-1]) / total)
        levels.append(np.minimum(levels[-1][-1] - depth[1:], levels[-1][-1]))
        first.append(first[-1] + len(depth) - 1)
    stack = np.minimum.accumulate(np.concatenate(levels), axis=0)

    # what each cell is
    region, height = (
        of_cells.reshape(-1, ny, nx)
        for of_cells in regions_of_cells(columns.pieces, columns.thick, model.zones, shares)
    )
    thick = -np.diff(stack, axis=0).mean(axis=(-1, -2))
    actnum = columns.used & (region >= 0) & (thick > min_thickness)
    region = np.where(actnum, region, -1)
    names = list(layers)
    blocks = list(dict.fromkeys(block for _, block in model.regions))
    block_of = np.array([blocks.index(block) for _, block in model.regions] + [-1])
    zone = np.repeat(np.arange(len(names)), np.diff(first))
    faces = faces_of(
        between, [Below(*one, columns.used) for one in columns.faults], columns.middles, height,
        zone, block_of[region],
    )  # fmt: skip
    return CornerPointGrid(
        coord=_coord(model.lattice, pillars, stack),
        levels=stack, actnum=actnum, zone=np.where(actnum, zone[:, None, None], -1),
        block=block_of[region],
        region=region, zone_names=tuple(names), block_names=tuple(blocks),
        region_names=tuple(model.regions), fault_names=tuple(model.faults),
        faces=faces, exact=model.exact,
        stair_steps=stair_steps, zones_of_model=tuple(zones_of_model),
    )  # fmt: skip


def _coord(lattice: ArealLattice, pillars: Pillars, stack: np.ndarray) -> np.ndarray:
    """Ends of all pillars, a little above and below the grid."""
    high, low = float(np.ceil(stack.max() + 1.0)), float(np.floor(stack.min() - 1.0))
    ends = []
    for z in (high, low):
        xy = lattice.to_world(pillars.at(z))
        ends.append(np.concatenate([xy, np.full((*xy.shape[:2], 1), z)], axis=-1))
    return np.concatenate(ends, axis=-1)


def checked(grid: CornerPointGrid) -> CornerPointGrid:
    """Return a grid none of whose cells is inside out, or raise `InvariantError`."""
    bad = np.argwhere(grid.inside_out)
    if len(bad):
        k, j, i = bad[0].tolist()
        raise InvariantError(
            f"{len(bad)} cells of the grid are inside out, the first at I {i + 1}, J {j + 1}, "
            f"K {k + 1}. "
            "Report it with the surfaces. Until then take vertical pillars, min_dip=None."
        )
    return grid
