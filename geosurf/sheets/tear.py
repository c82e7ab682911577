"""Horizon data and faults -> a sheet that is torn at the faults: `tear_horizon`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean, is_number
from geosurf.conventions.running import running
from geosurf.errors import InputError
from geosurf.model import Sheet, TriSurface
from geosurf.model.expected import flag_of
from geosurf.model.needed_faults import NeededFaults
from geosurf.model.tear_plan import TearPlan
from geosurf.sheets.attempts import torn_as_planned, torn_sheet
from geosurf.sheets.heights.stand_in import StandIn
from geosurf.sheets.lattice.data import has_fewer_nodes, picks_or_points
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.lattice.scattered import Scattered
from geosurf.sheets.mesh.close import Filling, with_needed
from geosurf.sheets.mesh.finish import crs_among, fault_surfaces, sheet_of
from geosurf.sheets.mesh.pinch_out import pinched_out
from geosurf.sheets.mesh.planned import fits, plan_of
from geosurf.sheets.report.describe import make_report
from geosurf.sheets.report.propose_trim import trims_of
from geosurf.triangulate import triangulate_horizon
from geosurf.triangulate.horizon import EXTRAPOLATED
from geosurf.triangulate.neighbours import own_form
from geosurf.warning import warn

__all__ = ["tear_from", "tear_horizon"]


@running("tear horizon")
def tear_horizon(
    data: Any,
    faults: Mapping[str, Any] | Sequence[TriSurface],
    *,
    name: str | None = None,
    trim: float | str | Mapping[str, float] = "auto",
    noise: float | None = None,
    spacing: float | None = None,
    fill_empty_blocks: bool | Sheet = False,
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
    trim : "auto", float or mapping of str to float
        Ignore data closer to a fault than this, measured at their own height [cells of the grid].
        ``"auto"`` estimates it for each fault from data that are held out (`propose_trim`), 1.5 to
        8 cells; it is 2 cells where the data do not show it. A mapping sets it by fault, and the
        others are estimated.
    noise : float, optional
        Standard deviation of the data's noise [m]; 0 to meet them exactly. Default: estimated.
    spacing : float, optional
        Width of the lattice on which scattered points are solved for [m]. Default: points on a
        lattice keep theirs, scattered ones get one cell for each point.
    fill_empty_blocks : bool or Sheet
        True fills a block between faults that has no data from its neighbour across the fault with
        the smaller throw there; the report lists it. A sheet on the same grid, torn at the same
        faults: the horizon is pinched out there, and coincides with this one. Default: an error
        names the block.
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
    The surface minimises its third differences (``geosurf.kernels.sheets.smooth_surface``), is torn
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
    return tear_from(
        None, data, faults, name=name, trim=trim, noise=noise, spacing=spacing,
        fill_empty_blocks=fill_empty_blocks, positive=positive, length_unit=length_unit,
    )  # fmt: skip


def tear_from(
    plan: TearPlan | None,
    data: Any,
    faults: Mapping[str, Any] | Sequence[TriSurface],
    *,
    name: str | None = None,
    trim: float | str | Mapping[str, float] = "auto",
    noise: float | None = None,
    spacing: float | None = None,
    fill_empty_blocks: bool | Sheet = False,
    positive: str | None = None,
    length_unit: str | None = None,
    asking: bool = False,
    needed: NeededFaults | None = None,
) -> Sheet:
    """
    Tear a horizon first with what closed a sheet of slightly other data.

    Trims and remedies of the plan are used as they are. If they do not close the sheet, or not
    without losing more throw, it is torn as `tear_horizon` does: see docs/decisions/0068.

    Parameters
    ----------
    plan : TearPlan or None
        `Sheet.plan` of a sheet on the same lattice, at faults of the same names.
    data, faults, name, trim, noise, spacing, fill_empty_blocks, positive, length_unit
        As for `tear_horizon`.
    asking : bool, optional
        Whether to stop where a fault would be extended.
    needed : NeededFaults, optional
        What this horizon needed when it asked. Faults are as long now; its trims stay.

    Returns
    -------
    Sheet
        ``plan.searched`` is False where the plan closed it.

    Raises
    ------
    GeosurfError
        As `tear_horizon`.
    TooShort
        If `asking`, where a fault would be extended.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=41)
    >>> base = gs.tear_horizon(world.horizons["Top"], world.faults)
    >>> sheet = tear_from(base.plan, world.horizons["Top"] + 3.0, world.faults)
    >>> sheet.plan.searched, len(sheet.report.remedies)
    (False, 0)
    """
    if noise is not None and not (is_number(noise) and noise >= 0):
        raise InputError(f"noise is {noise!r}, expected metres, 0 or more.")
    if not isinstance(fill_empty_blocks, Sheet):
        flag_of(fill_empty_blocks, "fill_empty_blocks")

    # read horizon and faults
    surfaces = fault_surfaces(faults)
    _check_trim(trim, surfaces)
    data = own_form(data, name or "horizon", "horizon", positive)
    picks = picks_or_points(data, name, positive, length_unit, spacing)
    crs = crs_among(picks.name, data, surfaces)

    # heights of all nodes, a torn mesh that the faults close, cut-offs and report
    filling = _filling(fill_empty_blocks, picks)
    torn = None if plan is None else torn_as_planned(picks, surfaces, plan, noise, filling)
    searched = torn is None
    if torn is None:
        trims = trims_of(trim if needed is None else needed.trims, picks, surfaces)
        # data that were ignored are as little trusted now
        if plan is not None and fits(plan, picks, surfaces):
            trims = replace(trims, use=plan.use)
        torn = torn_sheet(picks, surfaces, trims, noise, filling, asking)
    closed, cuts = with_needed(torn.closed, needed), torn.cuts
    sheet = sheet_of(closed.picks, closed.built, closed.faults, cuts, make_report(closed, cuts))
    sheet = replace(
        sheet, crs=crs, extrapolated=_extrapolated(data, sheet.lattice.shape),
        plan=plan_of(closed, torn.loss, searched), fewer_nodes=has_fewer_nodes(data),
    )  # fmt: skip
    if filling.other is not None and len(closed.pinched):
        present = np.isfinite(picks.means)
        sheet = pinched_out(sheet, closed.pinched, present, filling.other)
    for warning in sheet.warnings:
        warn(warning)
    return sheet


def _filling(fill: bool | Sheet, picks: Picks | Scattered) -> Filling:
    """What becomes of blocks without data."""
    if not isinstance(fill, Sheet):
        return Filling(carry=fill)
    if isinstance(picks, Scattered):
        raise InputError(
            f"horizon {picks.name!r} is given as scattered points, and only grids can be pinched "
            "out. Set fill_empty_blocks=True to continue it, or grid it first."
        )
    return Filling(other=StandIn.of(fill, picks))


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


def _check_trim(trim: Any, faults: Sequence[TriSurface]) -> None:
    """Refuse a trim that is neither "auto" nor a number of cells, for all faults or by fault."""
    if isinstance(trim, Mapping) and trim:
        names = [fault.name for fault in faults]
        for name, value in trim.items():
            if name not in names:
                raise InputError(
                    f"trim names {name!r}, which is not a fault.{did_you_mean(str(name), names)} "
                    f"The faults are {', '.join(map(repr, names))}."
                )
            _check_trim(value, faults)
    elif not (isinstance(trim, str) and trim == "auto") and not (is_number(trim) and trim > 0):
        raise InputError(f'trim is {trim!r}, expected "auto", cells above 0, or {{fault: cells}}.')
