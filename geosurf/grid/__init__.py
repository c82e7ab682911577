"""A scene -> a corner-point grid for flow simulators, and multipliers of its faces on faults."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from geosurf.conventions import is_number, volume_text
from geosurf.conventions.running import running
from geosurf.errors import GeosurfWarning, InputError
from geosurf.grid.build import (
    GriddedModel,
    assemble,
    checked,
    columns_of,
    lattice_over,
    model_of,
    pillars_along_faults,
)
from geosurf.grid.follow import FEW, balanced
from geosurf.grid.multipliers import fault_multipliers
from geosurf.grid.pillars import Pillars, layers_of, vertical_pillars
from geosurf.model.base import in_crs_of
from geosurf.model.grids import CornerPointGrid
from geosurf.model.protocols import missing_members
from geosurf.warning import warn

__all__ = ["build_grid", "fault_multipliers"]


@running("grid")
def build_grid(
    scene: GriddedModel,
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
    for needed in missing_members(scene, GriddedModel):
        raise InputError(
            f"build_grid takes a Scene, not {type(scene).__name__}: it has no {needed!r}."
        )
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
