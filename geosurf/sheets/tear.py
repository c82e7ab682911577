"""Horizon data and faults -> a sheet that is torn at the faults: `tear_horizon`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions import is_number, rising_diagonal
from geosurf.errors import GeometryError, InputError
from geosurf.model import Sheet, TriSurface
from geosurf.model.expected import flag_of
from geosurf.sheets.faults.traces import FaultMesh, mesh_in_frame
from geosurf.sheets.heights.heights import FIRST_TRIM, Heights, Rebuild, Settings
from geosurf.sheets.heights.missing import continued, missing_blocks, refuse_missing
from geosurf.sheets.heights.scattered import Scattered, picks_or_points, rebuild_of
from geosurf.sheets.lattice.data import Picks
from geosurf.sheets.lattice.noise import weight_of
from geosurf.sheets.mesh.build import Builder, carry_on_by, ghosts_by_picks
from geosurf.sheets.mesh.finish import (
    crs_among,
    fault_surfaces,
    faults_in_words,
    refuse_leaks,
    refuse_lost_cutoffs,
    sheet_of,
)
from geosurf.sheets.mesh.overlap_points import ghosts_by_points
from geosurf.sheets.report.describe import fault_cuts, make_report
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
    Tear a horizon at its faults, as it was picked.

    Data near a fault are distrusted: gridding smears a horizon over its faults. Each
    wall is rebuilt from data of its own side only, carried on to the fault, and cut by it.

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
        Data nearer to a fault than this are distrusted, measured at their own height [cells of
        the grid]. At least one and a half times the half width of the smear.
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
        If data and faults say different coordinate reference systems.
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
    surfaces = fault_surfaces(faults)
    picks = picks_or_points(data, name, positive, length_unit, spacing)
    crs = crs_among(picks.name, data, surfaces)
    meshes = [mesh_in_frame(surface, picks.frame) for surface in surfaces]
    rebuild, settings, state = _rebuilt(picks, meshes, trim, noise, fill)
    missing = missing_blocks(picks, state, meshes)
    if missing and fill:
        picks, notes = continued(picks, missing)
        rebuild, settings, state = _rebuilt(picks, meshes, trim, noise, fill)
        state.carried = [*notes, *state.carried]
        missing = missing_blocks(picks, state, meshes)
    refuse_missing(picks, missing)
    names = [surface.name for surface in surfaces]
    _refuse_empty_blocks(picks, state, names)
    rising = rising_diagonal(picks.frame.easting, picks.frame.northing)
    weight = settings.noise_weight
    known = (
        ghosts_by_points(picks, weight)
        if isinstance(picks, Scattered)
        else ghosts_by_picks(picks, weight, rebuild.canvas.changing)
    )
    carry_on = carry_on_by(picks.frame, weight, known)
    builder = Builder(picks, state, surfaces, rising, carry_on, rebuild.torn_between)
    built = builder.run()
    state = builder.state
    refuse_leaks(picks, state, built, surfaces, float(trim))
    cuts = fault_cuts(picks.frame, state, built, surfaces)
    refuse_lost_cutoffs(picks, state, built, cuts)
    used = settings.noise if settings.noise_weight is not None else None
    report = make_report(
        picks, state, built, cuts, builder.triangles, float(trim), used, rebuild.nearby
    )
    for warning in report.warnings:
        warn(warning)
    return replace(sheet_of(picks, state, built, surfaces, rising, cuts, report), crs=crs)


def _rebuilt(
    picks: Picks, meshes: list[FaultMesh], trim: float, noise: float | None, fill: bool
) -> tuple[Rebuild, Settings, Heights]:
    """Heights of all nodes, and what made them."""
    settings = Settings(float(trim), max(FIRST_TRIM, float(trim)), carry=fill)
    rebuild = rebuild_of(picks, meshes, settings)
    sigma, signal = rebuild.noise()
    settings.noise = sigma if noise is None else float(noise)
    settings.noise_weight = weight_of(settings.noise, signal, picks.frame.cell)
    return rebuild, settings, rebuild.run()


def _refuse_empty_blocks(picks: Picks, state: Heights, names: Sequence[str]) -> None:
    """Say where a block between faults has no data of its own."""
    if len(state.stray) == 0:
        return
    at = picks.frame.node_places(state.stray[:1])[0]
    beside = sorted(
        {
            names[trace.fault]
            for trace, near in zip(state.network.traces, state.near, strict=True)
            if (near.look_up(state.stray) >= 0).any()
        }
    )
    level = float(np.median(picks.z))  # the block has no height of its own
    raise GeometryError(
        f"horizon {picks.name!r}: a block next to {faults_in_words(beside)} has no data. It has "
        f"{len(state.stray)} nodes, the first at (easting {at[0]:.3f}, northing {at[1]:.3f}). Give "
        "a smaller trim, add data there, or set fill_empty_blocks=True to fill it from its "
        "neighbour.",
        place=(*at, level),
        surfaces=(picks.name, *beside),
    )
