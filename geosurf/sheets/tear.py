"""Horizon data and faults -> a sheet that is torn at the faults: `tear_horizon`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions import is_number, rising_diagonal
from geosurf.errors import InputError
from geosurf.model import Sheet, TriSurface
from geosurf.model.expected import flag_of
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.empty_blocks import refuse_empty_blocks
from geosurf.sheets.heights.missing import continued, missing_blocks, refuse_missing
from geosurf.sheets.heights.passes import Rebuilt, rebuild, solver_of
from geosurf.sheets.heights.point_solver import PointSolver
from geosurf.sheets.lattice.data import picks_or_points
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.scattered import Scattered
from geosurf.sheets.mesh.build import Built, build
from geosurf.sheets.mesh.carry_on import carry_on_by, ghosts_by_picks
from geosurf.sheets.mesh.finish import (
    crs_among,
    fault_surfaces,
    refuse_leaks,
    refuse_lost_cutoffs,
    sheet_of,
)
from geosurf.sheets.mesh.overlap_points import ghosts_by_points
from geosurf.sheets.report.describe import fault_cuts, make_report
from geosurf.triangulate import triangulate_horizon
from geosurf.triangulate.horizon import EXTRAPOLATED
from geosurf.warning import warn

__all__ = ["tear_horizon"]


def tear_horizon(
    data: Any,
    faults: Mapping[str, Any] | Sequence[TriSurface],
    *,
    name: str | None = None,
    trim: float = 2.0,
    noise: float | None = None,
    spacing: float | None = None,
    fill_empty_blocks: bool = False,
    positive: str | None = None,
    length_unit: str | None = None,
) -> Sheet:
    """
    Tear a horizon at its faults, so that throw and juxtaposition there can be trusted.

    Gridding smears a horizon across its faults, so data near a fault are ignored. Each wall is
    rebuilt from data of its own side only, extended to the fault, and cut by it.

    Parameters
    ----------
    data : xarray.DataArray, xarray.Dataset, pandas.DataFrame or array_like (n, 3)
        A grid as for `triangulate_horizon`, or points: easting, northing, elevation. Points on a
        regular lattice, rotated or not, may share a node, one for each wall; others are scattered.
    faults : mapping of str to fault, or sequence of TriSurface
        Anything that `triangulate_fault` takes. They tear the horizon exactly as far as they reach.
    name : str, optional
        Default: the name of the data.
    trim : float
        Ignore data closer to a fault than this, measured at their own height [cells of the grid].
        Use at least one and a half times the half width of the smear.
    noise : float, optional
        Standard deviation of the data's noise [m]; 0 to meet them exactly. Default: estimated.
    spacing : float, optional
        Width of the lattice on which scattered points are solved for [m]. Default: points on a
        lattice keep theirs, scattered ones get one cell for each point.
    fill_empty_blocks : bool
        Fill a block between faults that has no data from its neighbour across the fault with the
        smaller throw there; the report lists it. Default: an error names the block.
    positive : {"up", "down"}, optional
        Whether values are elevation or depth. Default: ``attrs["positive"]`` of a grid, or of the
        elevations of a Dataset of points; arrays and tables without it need the argument.
    length_unit : str, optional
        As for `triangulate_horizon`; points are in metres by default.

    Returns
    -------
    Sheet
        With cut-offs, throw and heave for each fault, and a report that should be read.

    Raises
    ------
    HorizonError
        If the data cannot be used.
    InputError
        If data and faults have different coordinate reference systems.
    GeometryError
        If a block has no data, or its sheet does not end on the faults. Names the place.

    Warns
    -----
    GeosurfWarning
        If the data still show throw where a fault ends: kind ``"throw at tip"``. `Sheet.warnings`
        has the same.

    See Also
    --------
    rebuild_surfaces : takes the sheet's surface; `Scene` takes the sheet itself.

    Notes
    -----
    The surface minimises its third differences (`geosurf.kernels.sheets.smooth_surface`), is torn
    by virtual nodes (Molino, Bao & Fedkiw 2004), and cut exactly. See docs/guides/tearing.md.

    Examples
    --------
    >>> import numpy as np, geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=41)
    >>> sheet = gs.tear_horizon(world.horizons["Top"], world.faults)
    >>> bool(55 < np.nanmax(sheet.cuts["F1"].throw) < 57)
    True
    >>> sheet.report.tips, sheet.report.declared_tips
    (2, 2)
    """
    if not (is_number(trim) and trim > 0):
        raise InputError(f"trim is {trim!r}, expected cells above 0; 2 is a good start.")
    if noise is not None and not (is_number(noise) and noise >= 0):
        raise InputError(f"noise is {noise!r}, expected metres, 0 or more.")
    fill = flag_of(fill_empty_blocks, "fill_empty_blocks")

    # read horizon and faults
    surfaces = fault_surfaces(faults)
    picks = picks_or_points(data, name, positive, length_unit, spacing)
    crs = crs_among(picks.name, data, surfaces)

    # heights of all nodes, then a torn mesh that the faults close
    picks, rebuilt, filled = _rebuilt_blocks(picks, surfaces, float(trim), noise, fill)
    refuse_empty_blocks(picks, rebuilt.state, [surface.name for surface in surfaces])
    built = _built(picks, rebuilt, surfaces)
    refuse_leaks(picks, built, surfaces, float(trim))

    # cut-offs and report
    cuts = fault_cuts(picks.frame, built, surfaces)
    refuse_lost_cutoffs(picks, built, cuts)
    solver = rebuilt.solver
    used = solver.noise.deviation if solver.noise.weight is not None else None
    report = make_report(picks, built, cuts, float(trim), used, solver.inputs.nearby, filled)
    for warning in report.warnings:
        warn(warning)
    sheet = sheet_of(picks, built, surfaces, cuts, report)
    return replace(sheet, crs=crs, extrapolated=_extrapolated(data, sheet.lattice.shape))


def _extrapolated(data: Any, shape: tuple[int, int]) -> np.ndarray | None:
    """Nodes that `extend_horizon` gave a grid, bool (n_row, n_col); None for other data."""
    if not hasattr(data, "coords") or EXTRAPOLATED not in data.coords:
        return None
    surface = triangulate_horizon(data)
    mark, lattice = surface.vertex_data.get(EXTRAPOLATED), surface.lattice
    if mark is None or lattice is None or lattice.shape != shape or not lattice.right_handed:
        return None
    found = np.zeros(shape, dtype=bool)
    found[lattice.present] = mark
    return found


def _rebuilt_blocks(
    picks: Picks,
    surfaces: Sequence[TriSurface],
    trim: float,
    noise: float | None,
    fill_empty_blocks: bool,
) -> tuple[Picks, Rebuilt, list[dict]]:
    """Heights of all nodes, once more where blocks at a fault without data were filled.

    Returns the picks with those blocks, the heights, and notes of the blocks.
    """
    meshes = [mesh_in_frame(surface, picks.frame) for surface in surfaces]
    rebuilt = rebuild(solver_of(picks, meshes, trim, noise, fill_empty_blocks))
    missing = missing_blocks(picks, rebuilt.state, meshes)
    filled: list[dict] = []
    if missing and fill_empty_blocks:
        picks, filled = continued(picks, missing)
        rebuilt = rebuild(solver_of(picks, meshes, trim, noise, fill_empty_blocks))
        missing = missing_blocks(picks, rebuilt.state, meshes)
    refuse_missing(picks, missing)
    return picks, rebuilt, filled


def _built(picks: Picks, rebuilt: Rebuilt, surfaces: Sequence[TriSurface]) -> Built:
    """The torn mesh, with ghosts on the sheets of their walls."""
    rising = rising_diagonal(picks.frame.easting, picks.frame.northing)
    solver, weight = rebuilt.solver, rebuilt.solver.noise.weight
    if isinstance(picks, Scattered):
        known = ghosts_by_points(picks, weight)
    else:
        assert not isinstance(solver, PointSolver)
        known = ghosts_by_picks(picks, weight, solver.grid.mark)
    carry_on = carry_on_by(picks.frame, weight, known)
    return build(picks, rebuilt.state, surfaces, rising, carry_on, rebuilt.torn_between)
