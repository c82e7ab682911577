"""A scene -> a corner-point grid for flow simulators, and multipliers of its faces on faults."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from geosurf.conventions import check_name, is_number, is_word, volume_text
from geosurf.conventions.axes import need_depth
from geosurf.conventions.running import running
from geosurf.errors import GeosurfWarning, InputError, warn
from geosurf.grid.build import (
    assemble,
    checked,
    columns_of,
    lattice_over,
    model_of,
    pillars_along_faults,
)
from geosurf.grid.follow import FEW, balanced
from geosurf.grid.pillars import Pillars, layers_of, vertical_pillars
from geosurf.kernels.lattices.sets import ranges
from geosurf.measure.faces import MINUS, PLUS
from geosurf.measure.seal import vshale_of, walls_of
from geosurf.measure.walls import Slipped, Walls
from geosurf.model.base import in_crs_of
from geosurf.model.column import ELSEWHERE
from geosurf.model.expected import expect, number_of
from geosurf.model.grids import AXES, CornerPointGrid
from geosurf.model.protocols import ReportedModel, missing_members

__all__ = ["build_grid", "fault_multipliers"]


@running("grid")
def build_grid(
    scene: ReportedModel,
    cell: Any = (100.0, 100.0),
    layers: int | Mapping[str, Any] = 10,
    *,
    angle: float | None = None,
    min_dip: float | None = 15.0,
    min_thickness: float = 0.01,
    include: str = "reservoir",
) -> CornerPointGrid:
    """
    Build a corner-point grid of a model: a simulation grid.

    Parameters
    ----------
    scene : Scene
    cell : (dx, dy) or float
        Size of the cells along I and J, about: whole numbers of cells fill the area [m].
    layers : int or mapping
        Number of proportional layers of each zone that `include` names; or the zones of the grid,
        each with a number of layers, or with layers of one thickness:
        ``{"Top/Middle": 10, "Middle/Base": {"thickness": 2.5, "parallel": "top"}}``. These are
        parallel to the ``"top"`` or ``"base"`` of the zone, and pinch out at the other.
    angle : float, optional
        Direction of I, degrees counter-clockwise from east. Default: along the sides of the
        smallest rectangle around the area.
    min_dip : float or None
        Pillars follow faults that dip at least this [degrees]; None: all pillars are vertical.
        Elsewhere faults are stair-steps, and a warning names them.
    min_thickness : float
        Cells with a mean thickness up to this are not active [m].
    include : {"reservoir", "all"}
        Zones of the grid, unless `layers` names them: from the first to the last zone of the
        reservoir, or all, with over- and underburden.

    Returns
    -------
    CornerPointGrid
        ``grid.table`` compares its volumes with those of the units. ``gs.write(grid,
        "model.grdecl")`` writes it.

    Raises
    ------
    InputError
        For an unknown zone, or sizes and layers that are not understood.

    Notes
    -----
    A pillar node has one depth for each side of the faults that meet there. Each column is sampled
    on its own side only.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes()
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> grid = gs.build_grid(scene, cell=(200, 200), layers={"Top/Base": 4})
    >>> grid.shape, int(grid.inside_out.sum())
    ((4, 15, 20), 0)
    """
    for needed in missing_members(scene, ReportedModel):
        raise InputError(
            f"build_grid takes a Scene, not {type(scene).__name__}: it has no {needed!r}."
        )
    need_depth(scene.units.time, "simulation grids")
    if min_dip is not None and not (is_number(min_dip) and 0 < min_dip < 90):
        raise InputError(f"min_dip is {min_dip!r}. Give degrees between 0 and 90, or None.")
    if not (is_number(min_thickness) and min_thickness >= 0):
        raise InputError(f"min_thickness is {min_thickness!r}. Give metres, 0 or more.")

    # arguments are checked against the zones before anything is sampled
    named = {unit.zone_index: unit.zone for unit in scene.units.values()}
    zones = [named[k] for k in sorted(named)]
    part = {unit.zone for unit in scene.units.included(include).values()}
    inside = [k for k, zone in enumerate(zones) if zone in part]
    covered = zones[inside[0] : inside[-1] + 1] if inside else []
    chosen = layers_of(layers, zones, covered)
    lattice = lattice_over(scene.units.box, scene.aoi, cell, angle)
    model = model_of(scene, lattice, list(chosen))

    def gridded(pillars: Pillars, thicker: np.ndarray | float = 1.0) -> CornerPointGrid:
        columns = columns_of(model, pillars)
        return assemble(columns, pillars, chosen, float(min_thickness), steps, zones, thicker)

    steps: dict[str, tuple[int, int]] = {}
    if min_dip is None:
        grid = gridded(vertical_pillars(lattice.shape))
    else:
        pillars, follows, steps = pillars_along_faults(model, float(min_dip))
        grid = balanced(gridded, pillars, follows, lattice.cell)
    checked(grid)
    for name, (step, n) in steps.items():
        if step:
            warn(warning_of_steps(name, step, n, lattice.cell))
    for volumes in warnings_of_volumes(grid):
        warn(volumes)
    return in_crs_of(grid, [scene.units])


def warning_of_steps(fault: str, step: int, n: int, cell: Any) -> GeosurfWarning:
    """Return the warning of a fault that pillars do not follow everywhere."""
    return GeosurfWarning(
        "stair-step",
        fault,
        f"Fault {fault!r} is a stair-step at {step} of the {n} pillars next to it, which do not "
        f"follow it: blocks end up to half a cell ({0.5 * float(max(cell)):.0f} m) from it.",
        "Choose smaller cells, or a smaller min_dip= where it dips too gently.",
    )


PROMISED = 1e-3  # of the volume of a unit
LISTED = 3


def warnings_of_volumes(grid: CornerPointGrid) -> list[GeosurfWarning]:
    """Return the warning of units whose volume the grid misses, with the worst; none if all fit."""
    volume = grid.table.volume.values
    off = volume / grid.exact - 1.0
    large = grid.columns_of_units > FEW
    wrong = np.flatnonzero(large & (np.abs(off) > PROMISED))
    if not len(wrong):
        return []
    rows = [
        f"{grid.unit_names[k][0]!r} in {grid.unit_regions[k] or grid.unit_names[k][1]!r} has "
        f"{volume_text(volume[k])} instead of {volume_text(grid.exact[k])} ({100 * off[k]:+.2f} %)"
        for k in wrong[np.argsort(-np.abs(off[wrong]), kind="stable")][:LISTED].tolist()
    ]
    more = len(wrong) - len(rows)
    return [
        GeosurfWarning(
            "grid volume",
            grid.unit_names[wrong[0]][0],
            f"{len(wrong)} of {int(large.sum())} zones in blocks of more than {FEW:.0f} columns "
            f"miss their volume by more than {100 * PROMISED:g} %: {'; '.join(rows)}"
            f"{f'; and {more} more' if more else ''}.",
            "Choose smaller cells. grid.table lists all volumes.",
        )
    ]


# ---- multipliers ----------------------------------------
# Transmissibility multipliers of the faces of a grid on faults (Manzocchi et al. 1999).
#
# Two cells that face each other across a fault have a part of their faces in common, between the
# same two pillars. At Gauss points across that part the fault rock is known: its shale gouge ratio
# and its throw, from the cut-offs of the sealed model. Multipliers of parts are averaged so that
# the face, or the fault, lets the same flow pass at one difference of pressure.


ACROSS = 0.5 + 0.5 * np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])  # Gauss points of a face
WEIGHTS = np.array([5.0, 8.0, 5.0]) / 18.0
LEAST_THROW = 1e-3  # below it, throw counts as this in the logarithm [m]
AT_ONCE = 4_000_000  # pairs of layers that are compared at once
BY = ("face", "fault")


def manzocchi(sgr: np.ndarray, throw: np.ndarray) -> np.ndarray:
    """
    Return the permeability of fault rock [mD]: log10 k = -4 SGR - 0.25 log10(throw) (1 - SGR)^5.

    Parameters
    ----------
    sgr : ndarray of float64
        Shale gouge ratio, a fraction.
    throw : ndarray of float64
        [m], above 0.

    Examples
    --------
    >>> manzocchi(np.array([0.0, 0.5]), np.array([16.0, 1.0])).round(6).tolist()
    [0.5, 0.01]
    """
    return np.asarray(10.0 ** (-4.0 * sgr - 0.25 * np.log10(throw) * (1.0 - sgr) ** 5))


def fault_multipliers(
    scene: Any,
    grid: CornerPointGrid,
    *,
    vshale: Any,
    permeability: Any,
    throw_per_thickness: float = 66.0,
    fault_permeability: Callable[[np.ndarray, np.ndarray], np.ndarray] = manzocchi,
    by: str = "face",
) -> xr.Dataset:
    """
    Return transmissibility multipliers of the faces of a grid that lie on faults.

    Parameters
    ----------
    scene : Scene
        From which the grid was built.
    grid : CornerPointGrid
    vshale : number or mapping
        Shale of the zones, as for `Scene.seal`.
    permeability : number, mapping or array
        Of the cells, across faults [mD]: one number, numbers by zone of the grid, or an array
        (n_layer, n_row, n_column).
    throw_per_thickness : float
        Throw over thickness of the fault rock: 66 is the mean of data, 170 their median.
    fault_permeability : callable
        Gives the permeability of fault rock [mD] for arrays of shale gouge ratio and throw [m].
    by : {"face", "fault"}
        What ``gs.write(multipliers, "model.inc")`` writes: MULTX, MULTY and MULTZ of the faces, or
        MULTFLT of the faults of ``model.grdecl``. A deck takes one of both: they multiply.

    Returns
    -------
    xarray.Dataset
        Over ``face``: ``fault``, ``axis``, ``i``, ``j``, ``k`` (from 1; the face is the one towards
        the next I, J or K), ``multiplier``, ``sgr`` and ``throw``, mean over the face. Over
        ``fault_name``: ``fault_multiplier``, which also counts on faces between layers and those
        that nothing faces, where ``sgr`` is NaN.

    Raises
    ------
    InputError
        For an unknown zone, or numbers that are not above 0.

    Notes
    -----
    For cells of lengths L1 and L2 and permeabilities k1 and k2, fault rock of permeability kf and
    thickness t multiplies by 1 / (1 + t (2/kf - 1/k1 - 1/k2) / (L1/k1 + L2/k2)).

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes()
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> grid = gs.build_grid(scene, cell=(200, 200), layers={"Top/Base": 4})
    >>> faces = gs.fault_multipliers(scene, grid, vshale=0.3, permeability=100.0)
    >>> bool(((faces.multiplier > 0.99) & (faces.multiplier < 1.01)).all())  # no throw
    True
    """
    for needed in missing_members(scene, ReportedModel):
        raise InputError(f"fault_multipliers takes a Scene; {needed!r} is missing.")
    expect(grid, CornerPointGrid, "fault_multipliers takes a grid", "pass gs.build_grid(scene)")
    if not is_word(by, BY) or not callable(fault_permeability):
        raise InputError("by is 'face' or 'fault', and fault_permeability a function.")
    if not number_of(throw_per_thickness, "throw_per_thickness") > 0.0:
        raise InputError(f"throw_per_thickness is {throw_per_thickness!r}. Give more than 0.")

    def law(sgr: np.ndarray, throw: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Thickness [m] and permeability [mD] of fault rock."""
        return throw / throw_per_thickness, np.asarray(fault_permeability(sgr, throw))

    k = permeability_of(permeability, grid).ravel()
    zones = vshale_of(scene, vshale)
    fault, axis, cell = _faces(grid)
    tables: list[np.ndarray] = []
    for row in np.unique(fault).tolist():
        walls = walls_of(scene.patches, scene.units, grid.fault_names[row], zones, np.inf)
        for along in (0, 1):
            faces = np.flatnonzero((fault == row) & (axis == along))
            if len(faces):
                part, rock = _parts(grid, along, cell[faces], walls, list(zones))
                flow, value = _flows(grid, along, k, part, rock, law)
                of_face = faces[np.searchsorted(cell[faces], part.cell)]
                columns = value, rock.ratio, rock.mean_throw
                tables.append(np.nan_to_num(np.stack([of_face, flow, *columns])))
    row, flow, *values = np.concatenate([np.empty((5, 0)), *tables], axis=1)
    row = row.astype(np.int64)
    multiplier, sgr, throw = (_mean(row, of, flow, len(cell)) for of in values)
    mean_of_fault = _mean(fault[row], values[0], flow, len(grid.fault_names))
    multiplier = np.where(np.isnan(multiplier), mean_of_fault[fault], multiplier)
    kk, jj, ii = np.unravel_index(cell, grid.actnum.shape)
    words = np.array(grid.fault_names, dtype=object)
    data: dict[str, Any] = {
        "fault": ("face", words[fault], {"long_name": "fault that the face lies on"}),
        "axis": ("face", np.array(AXES, dtype=object)[axis], {"long_name": "next cell along"}),
    }
    for name, index in (("i", ii), ("j", jj), ("k", kk)):
        data[name] = ("face", index + 1, {"long_name": f"{name.upper()} of the cell, from 1"})
    for name, values_of_faces, unit, meaning in (
        ("multiplier", multiplier, "1", "transmissibility multiplier"),
        ("sgr", sgr, "1", "shale gouge ratio"),
        ("throw", throw, "m", "throw, above 0 where the hanging wall is down"),
    ):
        data[name] = "face", values_of_faces, {"units": unit, "long_name": meaning}
    attrs = {"units": "1", "long_name": "multiplier of all faces of a fault: the same flow"}
    data["fault_multiplier"] = ("fault_name", mean_of_fault, attrs)
    shape = {"nz": grid.shape[0], "ny": grid.shape[1], "nx": grid.shape[2]}
    return xr.Dataset(data, {"fault_name": words}, {"by": by, **shape})


def permeability_of(given: Any, grid: CornerPointGrid) -> np.ndarray:
    """Return the permeability of each cell [mD], float64 (nz, ny, nx), or an error."""
    how = f"Give mD: a number, numbers by zone, or an array {grid.actnum.shape}."
    if isinstance(given, Mapping):
        for name in given:
            known = (*grid.zone_names, ELSEWHERE)
            check_name(name, known, f"permeability has an entry for {name!r}. Zones are")
        other = given.get(ELSEWHERE, np.nan)
        given = np.array([*(given.get(zone, other) for zone in grid.zone_names), 1.0])[grid.zone]
    try:
        permeability = np.broadcast_to(np.asarray(given, dtype=np.float64), grid.actnum.shape)
    except (TypeError, ValueError) as error:
        raise InputError(f"permeability cannot be used: {error}. {how}") from error
    if not ((permeability > 0.0) & np.isfinite(permeability))[grid.actnum].all():
        raise InputError(f"permeability is not above 0 in all active cells. {how}")
    return permeability


class Parts(NamedTuple):
    """What two cells have in common across a fault, near one point each.

    Both cells, int64 (n,); the area [m2] and the place (n, 3) [m].
    """

    cell: np.ndarray
    other: np.ndarray
    area: np.ndarray
    place: np.ndarray


def _faces(grid: CornerPointGrid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fault, axis and cell of all faces on faults, one by one, in this order."""
    faces, (_, ny, nx) = grid.faces, grid.shape
    row, k = ranges(faces.layers[:, 0], np.diff(faces.layers, axis=1).ravel())
    i, j = faces.column[row].T
    columns = np.stack([faces.fault[row], faces.axis[row], (k * ny + j) * nx + i], axis=1)
    fault, axis, cell = np.unique(columns, axis=0).T
    return fault, axis, cell


def _between_columns(grid: CornerPointGrid, axis: int, cells: np.ndarray) -> Iterator[Parts]:
    """Parts of faces between neighbouring columns, some columns at a time."""
    nz, ny, nx = grid.shape
    layer, column = np.divmod(cells, ny * nx)
    columns, row = np.unique(column, return_inverse=True)
    step = max(AT_ONCE // (nz * nz), 1)
    for first in range(0, len(columns), step):
        these = columns[first : first + step]
        on = np.zeros((len(these), nz), dtype=bool)
        mine = (row >= first) & (row < first + step)
        on[row[mine] - first, layer[mine]] = True
        j, i = np.divmod(these, nx)
        j2, i2 = (j, i + 1) if axis == 0 else (j + 1, i)
        # corners on the two pillars that both columns have in common: (column, level, pillar)
        levels = grid.levels if axis == 0 else grid.levels.swapaxes(3, 4)
        near, far = levels[:, j, i, :, 1], levels[:, j2, i2, :, 0]
        on &= grid.actnum[:, j, i].T
        active = grid.actnum[:, j2, i2].T
        pillars = [grid.coord[j2, i2], grid.coord[j + 1, i + 1]]
        for share, weight in zip(ACROSS, WEIGHTS, strict=True):
            one, two = ((1.0 - share) * of[..., 0] + share * of[..., 1] for of in (near, far))
            high = np.minimum(one[:, :-1, None], two[:, None, :-1])
            low = np.maximum(one[:, 1:, None], two[:, None, 1:])
            c, k, k2 = np.nonzero((high > low) & on[:, :, None] & active[:, None, :])
            size, z = (high - low)[c, k, k2], 0.5 * (high + low)[c, k, k2]
            p, q = (_on_pillars(pillar[c], z) for pillar in pillars)
            place = np.column_stack([p + share * (q - p), z])
            area = weight * size * np.hypot(*(q - p).T)
            cell, other = (k * ny + j[c]) * nx + i[c], (k2 * ny + j2[c]) * nx + i2[c]
            yield Parts(cell, other, area, place)


def _on_pillars(pillar: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Easting and northing (n, 2) of pillars (n, 6) at elevations."""
    share = (pillar[:, 2] - z) / (pillar[:, 2] - pillar[:, 5])
    return pillar[:, :2] + share[:, None] * (pillar[:, 3:5] - pillar[:, :2])


def _parts(
    grid: CornerPointGrid, axis: int, cells: np.ndarray, walls: Walls, zones: list[str]
) -> tuple[Parts, Slipped]:
    """Parts of the faces of cells on one fault, and what has slipped past them."""
    part = Parts(*map(np.concatenate, zip(*_between_columns(grid, axis, cells), strict=True)))
    zone_number = np.array([zones.index(zone) for zone in grid.zone_names])
    blocks = [walls.blocks.index(name) if name in walls.blocks else -1 for name in grid.block_names]
    both = np.stack([part.cell, part.other], axis=1)
    zone, block = zone_number[grid.zone.ravel()[both]], np.array(blocks)[grid.block.ravel()[both]]

    # which cell lies on side +: their blocks say so, or else the side that the fault dips to
    plus, minus = (
        np.isin(block, [block_name for on, block_name in walls.reach if on == side])
        for side in (PLUS, MINUS)
    )
    as_is, turned = plus[:, 0] & minus[:, 1], plus[:, 1] & minus[:, 0]
    ends = grid.coord[0, 0], grid.coord[0, -1] if axis == 0 else grid.coord[-1, 0]
    down_dip = (ends[1] - ends[0])[:2] @ walls.faces.strike[1] > 0.0
    turn = np.where(as_is == turned, down_dip, turned)[:, None]
    zone, block = (np.where(turn, pair[:, ::-1], pair) for pair in (zone, block))
    return part, walls.slipped(part.place - walls.faces.origin, zone, block)


def _flows(
    grid: CornerPointGrid, axis: int, k: np.ndarray, part: Parts, rock: Slipped, law: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Transmissibility of parts without the fault, but for a constant, and their multipliers."""
    middle = 0.5 * (grid.coord[..., :2] + grid.coord[..., 3:5])
    step = np.diff(middle, axis=1 - axis)
    ends = (step[:-1], step[1:]) if axis == 0 else (step[:, :-1], step[:, 1:])
    length = np.hypot(*np.moveaxis(0.5 * (ends[0] + ends[1]), -1, 0)).ravel()
    (l1, k1), (l2, k2) = ((length[c % length.size], k[c]) for c in (part.cell, part.other))
    throw = np.maximum(np.abs(rock.mean_throw), LEAST_THROW)
    thick, kf = law(rock.ratio, throw)
    resistance = l1 / k1 + l2 / k2
    more = thick * (2.0 / kf - 1.0 / k1 - 1.0 / k2)
    known = np.isfinite(rock.ratio)
    value = np.where(known, 1.0 / (1.0 + more / resistance), 0.0)
    return np.where(known, part.area / resistance, 0.0), value


def _mean(row: np.ndarray, values: np.ndarray, weight: np.ndarray, n: int) -> np.ndarray:
    """Weighted mean of the values of each row; NaN for none."""
    total = np.bincount(row, weight, minlength=n)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.bincount(row, weight * values, minlength=n) / total)
