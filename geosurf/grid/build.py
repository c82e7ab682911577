"""From a model to a corner-point grid, step by step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt, uniform_filter

from geosurf.conventions import CONVERSION_ERRORS, is_number
from geosurf.errors import InputError, InvariantError
from geosurf.faults.distance import in_ring
from geosurf.grid import pillars as at_corners
from geosurf.grid.follow import Below, faults_between, follow_faults, own_side
from geosurf.grid.pillars import Layers, Pillars, vertical_pillars
from geosurf.kernels.search.columns import cross_columns
from geosurf.model.column import virtual_name
from geosurf.model.expected import outline_of
from geosurf.model.grids import CornerPointGrid, GridFaces
from geosurf.model.protocols import ReportedModel

SMOOTH = 5  # columns over which the middle of the grid is averaged


@dataclass(frozen=True, eq=False)
class Model:
    """A model in coordinates of the lattice.

    Attributes
    ----------
    lattice : ArealLattice
    shells : list of Shell
        Units of the zones of the grid, before pillars are made vertical.
    faults : dict of str to (ndarray, ndarray)
        Vertices and triangles, those of virtual walls last.
    fault_names : tuple of str
        Without virtual walls, through which all flows.
    outline : ndarray of float64, shape (n, 2)
        Of the area.
    units : list of (str, str)
    exact : ndarray of float64
        Volume of each unit [m3].
    regions : list of str
        The region that each unit is in.
    zones : list of int
        From the top down.
    """

    lattice: ArealLattice
    shells: list[Shell]
    faults: dict[str, tuple[np.ndarray, np.ndarray]]
    fault_names: tuple[str, ...]
    outline: np.ndarray
    units: list[tuple[str, str]]
    exact: np.ndarray
    regions: list[str]
    zones: list[int]

    @cached_property
    def inside(self) -> np.ndarray:
        """Whether the middle of each column is in the area, (ny, nx)."""
        ny, nx = self.lattice.shape
        i, j = np.meshgrid(np.arange(nx) + 0.5, np.arange(ny) + 0.5)
        return in_ring(np.stack([i, j], axis=-1), self.outline)

    def holds(self, pillars: Pillars, feet: np.ndarray) -> np.ndarray:
        """Whether lines parallel to pillars stay in the area."""
        low, high = pillars.ends(feet)
        return in_ring(low, self.outline) & in_ring(high, self.outline)

    @cached_property
    def fine_faults(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Faults with triangles no longer than a cell, so that they bend with the pillars."""
        return [refined(*one, self.lattice.shape) for one in self.faults.values()]

    @property
    def middle(self) -> np.ndarray:
        """Middle of the lattice."""
        ny, nx = self.lattice.shape
        return np.array([0.5 * nx, 0.5 * ny])


def model_of(scene: ReportedModel, lattice: ArealLattice, zones: list[str]) -> Model:
    """Bring units and faults of a scene into coordinates of a lattice."""
    origin = np.array([*lattice.corner, 0.0])

    def to_lattice(local: np.ndarray, its_origin: np.ndarray) -> np.ndarray:
        x = local + (its_origin - origin)
        return np.concatenate([lattice.to_lattice(x[:, :2]), x[:, 2:]], axis=1)

    # one unit for each zone and block: contacts do not split cells
    in_zones = [unit for unit in scene.units.values() if unit.zone in zones]
    if not in_zones:
        raise InputError(f"no unit of the model is in the zones {zones}. Print scene.units.")
    units = list(dict.fromkeys((unit.zone, unit.block) for unit in in_zones))
    index = {name: k for k, name in enumerate(zones)}
    shells = [
        Shell(
            index[unit.zone],
            units.index((unit.zone, unit.block)),
            to_lattice(unit.local, unit.origin),
            unit.triangles,
        )
        for unit in in_zones
    ]
    exact = [math.fsum(u.volume for u in in_zones if (u.zone, u.block) == key) for key in units]
    ring = outline_of(scene.units.box, scene.aoi)
    faults = {}
    known = in_zones[0].surface_names
    walls = [name for name in map(virtual_name, scene.fault_names) if name in known]
    for name in (*scene.fault_names, *walls):
        surface = scene.surface(name)
        if not surface.n_triangle:  # a wall of which nothing is left
            continue
        faults[name] = (to_lattice(surface.vertices, np.zeros(3)), surface.triangles)
    names = tuple(name for name in scene.fault_names if name in faults)
    outline = lattice.to_lattice(ring - lattice.corner)
    regions = {(unit.zone, unit.block): unit.region for unit in in_zones}
    return Model(
        lattice, shells, faults, names, outline, units, np.array(exact),
        [regions[key] for key in units], list(range(len(zones))),
    )  # fmt: skip


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
        return self.model.inside & self.by_column[1].any(axis=(-1, -2))

    @cached_property
    def filled(self) -> np.ndarray:
        """Samples without gaps; columns that are not used have those of the nearest one."""
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
    shells = [Shell(s.zone, s.unit, pillars.straighten(s.x), s.triangles) for s in model.shells]
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
    rows = zip(model.fault_names, counts.tolist(), strict=False)
    return pillars, follows, {name: (step, n) for name, (step, n) in rows if n}


def corners_of(
    columns: Columns, between: tuple[np.ndarray, np.ndarray], thicker: np.ndarray | float
) -> np.ndarray:
    """Top and thicknesses at the corners of all columns, (ny, nx, 2, 2, 1 + n_zone)."""
    samples = columns.filled.copy()
    same = own_side(columns.faults, columns.middles.mean(axis=0), columns.used)
    samples[..., :1] = at_corners.filled(samples[..., :1], same)
    corners = at_corners.to_corners(np.moveaxis(samples, -1, 2))
    corners[:, :, 1:] = at_corners.limited(corners[:, :, 1:])
    corners[:, :, 1:] *= thicker
    corners = np.moveaxis(corners, 2, -1)

    # columns that no fault parts at any level share their corners
    apart_i, apart_j = (np.asarray(one.any(axis=(0, 1))) for one in between)
    group = at_corners.groups_at_nodes(apart_i, apart_j, columns.used)
    corners = at_corners.joined(corners, group)
    return _on_horizons(columns, corners, apart_i, apart_j)


def _on_horizons(
    columns: Columns, corners: np.ndarray, apart_i: np.ndarray, apart_j: np.ndarray
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
        corners[j + 1 - a, i + 1 - b, a, b] = values
    return corners


def assemble(
    columns: Columns,
    pillars: Pillars,
    layers: dict[str, Layers],
    min_thickness: float,
    stair_steps: dict[str, tuple[int, int]],
    zones_of_model: Sequence[str],
    thicker: np.ndarray | float = 1.0,
) -> CornerPointGrid:
    """Make the cells of a grid; beside faults and outlines, zones are so much thicker."""
    model = columns.model
    between = faults_between(columns.faults, columns.middles, columns.used)
    corners = corners_of(columns, between, thicker)
    ny, nx = columns.used.shape

    # boundaries of layers, zone by zone from the top down
    levels, shares, first = [corners[..., 0][None]], [], [0]
    for k, of_zone in enumerate(layers.values()):
        depth = of_zone.boundaries(corners[..., 1 + k])
        mean = depth.mean(axis=(-1, -2)).reshape(len(depth), -1)
        total = np.where(mean[-1] > 0.0, mean[-1], 1.0)
        shares.append(0.5 * (mean[1:] + mean[:-1]) / total)
        levels.append(np.minimum(levels[-1][-1] - depth[1:], levels[-1][-1]))
        first.append(first[-1] + len(depth) - 1)
    stack = np.minimum.accumulate(np.concatenate(levels), axis=0)

    # what each cell is
    unit, height = (
        of_cells.reshape(-1, ny, nx)
        for of_cells in units_of_cells(columns.pieces, columns.thick, model.zones, shares)
    )
    thick = -np.diff(stack, axis=0).mean(axis=(-1, -2))
    actnum = columns.used & (unit >= 0) & (thick > min_thickness)
    unit = np.where(actnum, unit, -1)
    names = list(layers)
    blocks = list(dict.fromkeys(block for _, block in model.units))
    block_of = np.array([blocks.index(block) for _, block in model.units] + [-1])
    zone = np.repeat(np.arange(len(names)), np.diff(first))
    faces = faces_of(
        between, [Below(*fault, columns.used) for fault in columns.faults], columns.middles, height,
        zone, block_of[unit],
    )  # fmt: skip
    return CornerPointGrid(
        coord=_coord(model.lattice, pillars, stack),
        levels=stack, actnum=actnum, zone=np.where(actnum, zone[:, None, None], -1),
        block=block_of[unit],
        unit=unit, zone_names=tuple(names), block_names=tuple(blocks),
        unit_names=tuple(model.units), unit_regions=tuple(model.regions),
        fault_names=model.fault_names,
        faces=faces.among(len(model.fault_names)), exact=model.exact,
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
            f"{len(bad)} cells of the grid are inside out, the first at I {i + 1}, J {j + 1}, K "
            f"{k + 1}. Report it with the surfaces. Until then take vertical pillars, min_dip=None."
        )
    return grid


PER_COLUMN = 5  # lines: four at Gauss points, one through the middle


def lengths_in(pieces: Pieces, n_line: int, zones: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Length of each line in each zone (n_line, n_zone), and the highest point of each line."""
    thick = np.zeros((n_line, len(zones)))
    for k, zone in enumerate(zones):
        rows = pieces.zone == zone
        thick[:, k] = np.bincount(pieces.line[rows], pieces.length[rows], minlength=n_line)
    top = np.full(n_line, -np.inf)
    np.maximum.at(top, pieces.line, pieces.top)
    return thick, top


def units_of_cells(
    pieces: Pieces, thick: np.ndarray, zones: list[int], depths: list[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the unit of each cell: that of the same share of its zone on the line through it.

    Parameters
    ----------
    pieces : Pieces
        Of `PER_COLUMN` lines for each column, the middle one last.
    thick : ndarray of float64, shape (n_column * PER_COLUMN, n_zone)
        Lengths of the lines in the zones.
    zones : list of int
    depths : list of ndarray, each (n_layer, n_column)
        Depth of the middle of the cells of each zone, as a share of the zone.

    Returns
    -------
    (ndarray of int64, ndarray of float64), each (n_layer of all zones, n_column)
        Region, -1 where no line through the column meets the zone; and its elevation on the middle
        line, NaN where that does not meet the zone: all cells of the zone are in one unit there.
    """
    out, heights = [], []
    for k, zone in enumerate(zones):
        # the middle line where it meets the zone, else that which meets most of it
        line_thickness = thick[:, k].reshape(-1, PER_COLUMN)
        best = np.where(line_thickness[:, -1] > 0.0, PER_COLUMN - 1, line_thickness.argmax(axis=1))
        column = np.arange(len(line_thickness))
        line, meets = column * PER_COLUMN + best, line_thickness[column, best] > 0.0

        # pieces of the zone from the top down, each up to a share of the whole length
        rows = np.flatnonzero(pieces.zone == zone)
        if not len(rows):
            out.append(np.full(depths[k].shape, -1))
            heights.append(np.full(depths[k].shape, np.nan))
            continue
        on_line, length = pieces.line[rows], pieces.length[rows]
        first = np.flatnonzero(np.diff(on_line, prepend=-1))
        end = np.cumsum(length)
        start = np.repeat(end[first] - length[first], np.diff(np.append(first, len(on_line))))
        total = np.bincount(on_line, length, minlength=len(thick))[on_line]
        share = np.minimum((end - start) / total, 1.0)
        share[np.append(first[1:], len(on_line)) - 1] = 1.0
        central = best == PER_COLUMN - 1
        depth = np.where(central, np.clip(depths[k], 0.0, 1.0 - 1e-9), 0.5)
        at = np.minimum(np.searchsorted(on_line + share, line + depth, "left"), len(rows) - 1)
        out.append(np.where(meets, pieces.unit[rows[at]], -1))
        below_top = depth * total[at] - (end - start - length)[at]
        z = pieces.top[rows[at]] - np.clip(below_top, 0.0, length[at])
        heights.append(np.where(meets & central, z, np.nan))
    return np.concatenate(out), np.concatenate(heights)


def faces_of(
    between: tuple[np.ndarray, np.ndarray],
    faults: Sequence[Below],
    middles: np.ndarray,
    height: np.ndarray,
    zone: np.ndarray,
    block: np.ndarray,
) -> GridFaces:
    """
    Return the faces on faults, with layers in a row joined.

    Parameters
    ----------
    between : (ndarray of bool, ndarray of bool)
        As `faults_between` returns them, one level for each zone.
    faults : sequence of Below
    middles : ndarray of float64, shape (n_zone, ny, nx)
        Elevation of the middle of each zone in each column, as for `between` [m].
    height : ndarray of float64, shape (nz, ny, nx)
        Elevation of the middle of each cell [m]; NaN: as the middle of its zone.
    zone : ndarray of int64, shape (nz,)
        Row of `middles` of each layer.
    block : ndarray of int64, shape (nz, ny, nx)
        -1 in cells that are not active.

    Returns
    -------
    GridFaces
    """
    height = np.where(np.isnan(height), middles[zone], height)
    live = np.asarray((block >= 0).any(axis=0))
    sides = (live[:, :-1] & live[:, 1:], live[:-1] & live[1:], live)
    parted: list[list[np.ndarray]] = [[], [], []]
    for fault, below in enumerate(faults):
        # a fault may cut a column: cells above it and below it have other neighbours than the
        # middle of their zone, and a face between them
        here = below(height)
        turned = here ^ below(middles)[zone]
        apart_i = between[0][fault][zone] ^ turned[:, :, :-1] ^ turned[:, :, 1:]
        apart_j = between[1][fault][zone] ^ turned[:, :-1] ^ turned[:, 1:]
        for axis, apart in enumerate((apart_i, apart_j, here[:-1] ^ here[1:])):
            parted[axis].append(apart & sides[axis])
    if faults:
        _at_blocks(parted, block)
    none = np.empty((0, 2), np.int64)
    parts = [(none[:, 0], none[:, 0], none, none)]
    for axis, of_fault in enumerate(parted):
        for fault, apart in enumerate(of_fault):
            step = np.diff(np.moveaxis(apart, 0, -1).astype(np.int8), axis=-1, prepend=0, append=0)
            j, i, start = np.nonzero(step == 1)
            layers = np.stack([start, np.nonzero(step == -1)[-1]], 1)
            parts.append((*np.full((2, len(j)), [[fault], [axis]]), np.stack([i, j], 1), layers))
    of, axis_of, column, layers = (np.concatenate(part) for part in zip(*parts, strict=True))
    order = np.lexsort((layers[:, 0], column[:, 0], column[:, 1], axis_of, of))
    return GridFaces(of[order], axis_of[order], column[order], layers[order])


def _at_blocks(parted: list[list[np.ndarray]], block: np.ndarray) -> None:
    """Add faces between blocks that rays missed by rounding of tilted pillars, in place.

    They belong to the fault that most other faces between the same two blocks are on.
    """
    n_block = int(block.max(initial=0)) + 1
    ends = [
        (block[..., :-1], block[..., 1:]), (block[:, :-1], block[:, 1:]), (block[:-1], block[1:])
    ]  # fmt: skip
    pairs = [np.minimum(a, b) * n_block + np.maximum(a, b) for a, b in ends]
    other = [(a != b) & (np.minimum(a, b) >= 0) for a, b in ends]
    count = np.zeros((len(parted[0]), n_block * n_block), dtype=np.int64)
    for parted_by_fault, pair, differ in zip(parted, pairs, other, strict=True):
        for fault, apart in enumerate(parted_by_fault):
            count[fault] += np.bincount(pair[apart & differ], minlength=n_block * n_block)
    owner = np.where(count.any(axis=0), count.argmax(axis=0), -1)
    for parted_by_fault, pair, differ in zip(parted, pairs, other, strict=True):
        missed = differ & ~np.any(parted_by_fault, axis=0)
        for fault, apart in enumerate(parted_by_fault):
            apart |= missed & (owner[np.where(missed, pair, 0)] == fault)


@dataclass(frozen=True, eq=False)
class Shell:
    """The closed boundary of a unit, in coordinates of the lattice.

    Attributes
    ----------
    zone, unit : int
    x : ndarray of float64, shape (n_vertex, 3)
        Along I and J in cells, elevation [m].
    triangles : ndarray of int64, shape (n_triangle, 3)
    """

    zone: int
    unit: int
    x: np.ndarray
    triangles: np.ndarray


@dataclass(frozen=True, eq=False)
class Pieces:
    """The length of each line in each unit that it meets, sorted by line, then from the top down.

    Attributes
    ----------
    line, zone, unit : ndarray of int64, shape (n,)
    length, top : ndarray of float64, shape (n,)
        Length, and elevation of the highest point [m].
    """

    line: np.ndarray
    zone: np.ndarray
    unit: np.ndarray
    length: np.ndarray
    top: np.ndarray


def pieces_along(shells: Sequence[Shell], feet: np.ndarray, middle: np.ndarray) -> Pieces:
    """
    Find how long lines are inside units.

    Parameters
    ----------
    shells : sequence of Shell
    feet : ndarray of float64, shape (n, 2)
        In coordinates of the lattice.
    middle : ndarray of float64, shape (2,)
        Feet on a rim count as if they were a little nearer to this.

    Returns
    -------
    Pieces
    """
    nothing = np.empty(0)
    parts: list[tuple[np.ndarray, int, int, np.ndarray, np.ndarray]] = [
        (np.empty(0, np.int64), 0, 0, nothing, nothing)
    ]
    for shell in shells:
        crossings = cross_columns(shell.x, shell.triangles, feet, middle)
        if not len(crossings.foot):
            continue

        # a line leaves through the top (+) and enters through the base (-); heights count from the
        # level of the unit, so that little is lost in the sum
        level = float(np.round(shell.x[:, 2].mean()))
        n = len(feet)
        length = np.bincount(
            crossings.foot, crossings.way * (crossings.elevation - level), minlength=n
        )
        top = np.full(n, -np.inf)
        np.maximum.at(top, crossings.foot, crossings.elevation)
        rows = np.flatnonzero(length > 0.0)
        parts.append((rows, shell.zone, shell.unit, length[rows], top[rows]))
    line, length, top = (np.concatenate([part[k] for part in parts]) for k in (0, 3, 4))
    zone, unit = (np.repeat([p[k] for p in parts], [len(p[0]) for p in parts]) for k in (1, 2))
    order = np.lexsort((-top, zone, line))
    return Pieces(line[order], zone[order], unit[order], length[order], top[order])


MOST_COLUMNS = 4_000_000


@dataclass(frozen=True, eq=False)
class ArealLattice:
    """Equal rectangles on the map.

    Attributes
    ----------
    corner : ndarray of float64, shape (2,)
        Easting and northing of the first corner [m].
    axes : ndarray of float64, shape (2, 2)
        Unit vectors along I and J, as rows.
    cell : ndarray of float64, shape (2,)
        Size of a cell along I and J [m].
    shape : (int, int)
        Number of rows (J) and columns (I).
    """

    corner: np.ndarray
    axes: np.ndarray
    cell: np.ndarray
    shape: tuple[int, int]

    def to_lattice(self, xy: np.ndarray) -> np.ndarray:
        """Coordinates in cells along I and J, of places relative to the corner (n, 2)."""
        # an unrotated lattice only scales: coordinates that are equal stay equal
        turned = xy if (self.axes == np.eye(2)).all() else xy @ self.axes.T
        return turned / self.cell

    def to_world(self, uv: np.ndarray) -> np.ndarray:
        """Easting and northing [m] of coordinates in cells (..., 2)."""
        return self.corner + (uv * self.cell) @ self.axes


def lattice_over(
    box: tuple[float, ...], aoi: np.ndarray | None, cell: Any, angle: Any
) -> ArealLattice:
    """
    Return the lattice that fills the area of a model with cells of about a size.

    Parameters
    ----------
    box : (west, east, south, north, ...)
        [m]
    aoi : ndarray of float64, shape (n, 2), or None
    cell : (dx, dy) or float
        [m]
    angle : float or None
        Direction of I, degrees counter-clockwise from east. Default: along the sides of the
        smallest rectangle around the area.

    Returns
    -------
    ArealLattice

    Raises
    ------
    InputError
        For a size or an angle that is not a number, or too many columns.
    """
    size = _size(cell)
    outline = outline_of(box, aoi)
    if angle is None:
        axes = np.eye(2) if aoi is None else _best_axes(outline)
    elif is_number(angle) and np.isfinite(float(angle)):
        c, s = np.cos(np.radians(float(angle))), np.sin(np.radians(float(angle)))
        axes = np.array([[c, s], [-s, c]]) if angle else np.eye(2)
    else:
        raise InputError(f"angle is {angle!r}. Give degrees counter-clockwise from east.")

    # whole numbers of cells that fill the rectangle: each is about as large as asked
    along = (outline - outline[0]) @ axes.T
    low, span = along.min(axis=0), np.ptp(along, axis=0)
    count = np.maximum(np.round(span / size), 1)
    if count.prod() > MOST_COLUMNS:
        raise InputError(
            f"cells of {size[0]:g} x {size[1]:g} m give {count.prod():.3g} columns; the limit is "
            f"{MOST_COLUMNS:g}. Choose larger cells."
        )
    nx, ny = count.astype(np.int64).tolist()
    return ArealLattice(outline[0] + low @ axes, axes, span / count, (ny, nx))


def _size(cell: Any) -> np.ndarray:
    """Size of a cell along I and J [m]."""
    both = (cell, cell) if is_number(cell) else cell
    try:
        dx, dy = both
    except (TypeError, ValueError, *CONVERSION_ERRORS):
        dx = dy = None
    if not all(is_number(d) and np.isfinite(d) and d > 0 for d in (dx, dy)):
        raise InputError(f"cell is {cell!r}. Give the size of a cell in metres: cell=(100, 100).")
    return np.array([float(dx), float(dy)])


def _best_axes(outline: np.ndarray) -> np.ndarray:
    """Axes of the smallest rectangle around an outline, nearest to east and north."""
    step = np.roll(outline, -1, axis=0) - outline
    step = step[np.hypot(*step.T) > 0]
    step = step / np.hypot(*step.T)[:, None]
    best, smallest = np.eye(2), np.inf
    for x, y in step:
        # a side of the hull is a side of the smallest rectangle (Freeman & Shapira 1975)
        axes = np.array([[x, y], [-y, x]])
        area = float(np.ptp(outline @ axes.T, axis=0).prod())
        if area < smallest * (1.0 - 1e-12):
            best, smallest = axes, area

    # quarter turns: I within 45 degrees of east
    while not (best[0, 0] > abs(best[0, 1]) or best[0, 0] == best[0, 1] > 0):
        best = np.array([-best[1], best[0]])
    return best


LONGEST = 1.5  # cells, on the map
MOST = 400_000


def refined(
    x: np.ndarray, triangles: np.ndarray, shape: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """
    Divide triangles into four until they are about as small as cells.

    Parameters
    ----------
    x : ndarray of float64, shape (n, 3)
        In lattice coordinates.
    triangles : ndarray of int64, shape (m, 3)
    shape : (int, int)
        Rows and columns of the lattice: what lies outside of it stays as it is.

    Returns
    -------
    (ndarray, ndarray)
        Vertices and triangles. Neighbours are divided at the same places, or one of them is not:
        rays between columns do not need a closed surface.
    """
    corners, done = x[triangles], []
    limit = np.array(shape[::-1])
    while len(corners):
        flat = corners[..., :2]
        size = np.ptp(flat, axis=1).max(axis=1)
        near = (flat.max(axis=1) > -1).all(axis=1) & (flat.min(axis=1) < limit + 1).all(axis=1)
        split = (size > LONGEST) & near
        if 4 * int(split.sum()) > MOST:
            split[:] = False
        done.append(corners[~split])
        a, b, c = corners[split].transpose(1, 0, 2)
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        corners = np.concatenate([np.stack(part, axis=1) for part in parts])
    found = np.concatenate(done).reshape(-1, 3)
    return found, np.arange(len(found)).reshape(-1, 3)
