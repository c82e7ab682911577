"""Tie a horizon to its well tops: correct its data, tear or cut it again, compare.

The data are the form in which a horizon is corrected: vertices of a surface, or a dataset of
points. Each round makes the horizon of them, and measures what its tops still need (`controls`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from geosurf.conventions import length_text, place
from geosurf.conventions.axes import COORDINATES, points_in
from geosurf.conventions.checks import are_points
from geosurf.conventions.crs import crs_of
from geosurf.errors import GeometryError, GeosurfWarning, InputError, collected, warn
from geosurf.measure.columns import columns_through
from geosurf.model import Sheet, SheetReport, TriSurface, frozen
from geosurf.model.tops import TieReport, TieSettings, Tops, doubtful_top
from geosurf.sheets.lattice.data import points_of
from geosurf.sheets.tie.controls import (
    Controls,
    CutHorizon,
    controls_of,
    cut_horizon,
    place_keys,
    shares_in,
)
from geosurf.sheets.tie.correction import correction
from geosurf.triangulate import triangulate_horizon
from geosurf.triangulate.spikes import check_spikes

ROUNDS = 8  # corrections before an error names the top that is not met
MOST_NAMED = 6  # tops in one warning
Make = Callable[[Any], TriSurface | Sheet]  # makes the horizon of its data


@dataclass(frozen=True, eq=False)
class Tied:
    """A horizon that meets its tops.

    Attributes
    ----------
    data : TriSurface or xarray.Dataset
        The corrected data.
    made : TriSurface or Sheet
        The horizon that was made of them.
    report : TieReport
    """

    data: Any
    made: TriSurface | Sheet
    report: TieReport


def tie_horizon(
    name: str,
    data: Any,
    make: Make,
    faults: Sequence[TriSurface],
    tops: Tops,
    settings: TieSettings,
) -> Tied:
    """
    Correct the data of a horizon so that it meets its well tops.

    Parameters
    ----------
    name : str
        Of the horizon.
    data : TriSurface or xarray.Dataset
        A grid, a mesh, or points, as `data_to_tie` returns them.
    make : callable
        Makes the horizon from data: tears it, or hands a surface back as it is.
    faults : sequence of TriSurface
        A top acts on its own side of each.
    tops : Tops
    settings : TieSettings

    Returns
    -------
    Tied

    Raises
    ------
    InputError
        If the range is too small for the cells of the horizon, or a top has another sign or unit.
    GeometryError
        If two tops contradict each other, or a top is not met within the tolerance.

    Warns
    -----
    GeosurfWarning
        Of tops that are not used, each with its reason; and of the effect, if the range is the
        default.

    Examples
    --------
    >>> import numpy as np
    >>> corners = [[0, 0, -9], [900, 0, -9], [0, 900, -9], [900, 900, -9]]
    >>> flat = TriSurface("Top", "horizon", corners, [[0, 1, 2], [1, 3, 2]])
    >>> tops = Tops(("W",), ("Top",), np.array([[0.0, 0.0, -5.0]]))
    >>> tied = tie_horizon("Top", flat, lambda data: data, [], tops, TieSettings(5000.0))
    >>> round(float(tied.made.vertices[0, 2]), 9)
    -5.0
    """
    # always from the data as given, plus the sum of all changes: rounding does not accumulate
    rows = tops.of(name)
    points = points_of_data(data)
    total = np.zeros(len(points))
    made, warnings = _make_quietly(make, data)
    cut = cut_horizon(made, faults)
    controls = first = controls_of(cut, tops, rows)
    rounds = 0
    at_tops = tops.points[controls.top, 2] - controls.residual
    if (doubt := doubtful_top(tops, controls.top, at_tops)) is not None:
        raise InputError(str(doubt))

    # torn again after each correction: heights near faults are solved for, so that one
    # correction of the data does not meet tops there
    while controls.largest > settings.tolerance:
        if rounds == ROUNDS:
            _refuse_misfit(controls, tops, settings)
        change = correction(cut, controls, tops, settings, check=rounds == 0)
        total += _at_data(cut, change, points, tops.points[controls.top], settings.range)
        made, warnings = _make_quietly(make, corrected_data(data, total))
        cut = cut_horizon(made, faults)
        controls = controls_of(cut, tops, rows)
        rounds += 1
    report = _report(name, settings, tops, first, controls, total, rounds)
    tie_warnings = _warnings_of_tie(report, tops, controls)
    for warning in (*warnings, *tie_warnings):
        warn(warning)

    # the sheet's own report says that it was tied, and what was left out
    if isinstance(made, Sheet) and isinstance(made.report, SheetReport):
        notes = [*made.report.notes, f"tied to well tops: {report}"]
        in_report = (*made.report.warnings, *tie_warnings)
        made = replace(made, report=replace(made.report, notes=notes, warnings=in_report))
    return Tied(corrected_data(data, total) if rounds else data, made, report)


def tied_sheet(
    name: str,
    data: Any,
    make: Callable[[Any], Sheet],
    faults: Sequence[TriSurface],
    tops: Tops | None,
    settings: TieSettings | None,
) -> Sheet:
    """
    Tear a horizon, tied to its well tops if there are some and a tie is requested.

    Parameters
    ----------
    name : str
        Of the horizon.
    data : xarray.DataArray, xarray.Dataset, pandas.DataFrame, array_like (n, 3) or TriSurface
        As for `tear_horizon`.
    make : callable
        Tears the horizon.
    faults : sequence of TriSurface
    tops : Tops or None
    settings : TieSettings or None

    Returns
    -------
    Sheet
        Its report has the notes and warnings of the tie.
    """
    if tops is None or settings is None or not len(tops.of(name)):
        return make(data)
    made = tie_horizon(name, data_to_tie(data, name), make, faults, tops, settings).made
    assert isinstance(made, Sheet)
    return made


def _make_quietly(make: Make, data: Any) -> tuple[TriSurface | Sheet, list[GeosurfWarning]]:
    """The horizon, and the warnings of making it, which count if no other round follows."""
    with collected() as warnings:
        made = make(data)
    return made, warnings


def _at_data(
    cut: CutHorizon, change: np.ndarray, points: np.ndarray, wells: np.ndarray, reach: float
) -> np.ndarray:
    """
    Change of elevation at data: that of the sheet which is nearest above or below.

    Data at the place of a vertex take its change; others that of the triangle they are above or
    below. Data in the gap of a fault, which lie on no sheet, stay.
    """
    at_data = np.zeros(len(points))

    # data out of reach of all wells do not change: they are not looked at
    near = np.zeros(len(points), dtype=bool)
    for well in wells:
        near |= np.hypot(*(points[:, :2] - well[:2]).T) < reach
    rows = np.flatnonzero(near)

    # vertices at the very place of a datum, by searching its place among theirs; two of them on a
    # fault, and the one nearest in elevation is on the datum's own wall
    order, keys = cut.by_place
    key = place_keys(points[rows])
    first, last = (np.searchsorted(keys, key, side) for side in ("left", "right"))
    distance = np.full(len(rows), np.inf)
    for step in range(int((last - first).max(initial=0))):
        there = np.flatnonzero(first + step < last)
        vertex = order[first[there] + step]
        apart = np.abs(cut.x[vertex, 2] - points[rows[there], 2])
        nearer = apart < distance[there]
        distance[there[nearer]] = apart[nearer]
        at_data[rows[there[nearer]]] = change[vertex[nearer]]

    between = rows[first == last]
    if len(between):
        on_sheet, change_there = _between_vertices(cut, change, points[between])
        at_data[between[on_sheet]] = change_there
    return at_data


def _between_vertices(
    cut: CutHorizon, change: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The points that lie above or below a triangle, and the change of the nearest one there."""
    columns = columns_through(cut.patches, points, cut.rows)
    apart = np.abs(columns.elevation - points[columns.foot, 2])
    order = np.lexsort((apart, columns.foot))
    foot, nearest = np.unique(columns.foot[order], return_index=True)
    triangle = np.searchsorted(cut.rows, columns.triangle[order[nearest]])
    share = shares_in(cut, triangle, points[foot, :2])
    return foot, (change[cut.triangles[triangle]] * share).sum(axis=1)


def _report(
    name: str,
    settings: TieSettings,
    tops: Tops,
    first: Controls,
    last: Controls,
    total: np.ndarray,
    rounds: int,
) -> TieReport:
    """What the tie did, in numbers."""
    return TieReport(
        horizon=name,
        settings=settings,
        wells=tuple(tops.wells[k] for k in last.top.tolist()),
        unused=tuple(f"{tops.words(k)} {why}" for k, why in last.unused.items()),
        before=first.largest,
        after=last.largest,
        largest=float(np.abs(total).max(initial=0.0)),
        moved=float((total != 0.0).mean()) if len(total) else 0.0,
        rounds=rounds,
    )


def _warnings_of_tie(report: TieReport, tops: Tops, controls: Controls) -> list[GeosurfWarning]:
    """Warn of tops that are not used, and of the effect of a range that nobody gave."""
    n_unused, name = len(report.unused), report.horizon
    warnings = []
    if n_unused:
        more = f" and {n_unused - MOST_NAMED} more" if n_unused > MOST_NAMED else ""
        effect = (
            f"The tie does not use {n_unused} of {n_unused + len(report.wells)} well tops of "
            f"horizon {name!r}: {'; '.join(report.unused[:MOST_NAMED])}{more}."
        )
        place_of_first = tops.points[next(iter(controls.unused))]
        remedy = "Correct these tops or the faults next to them, or leave these tops out."
        warnings.append(GeosurfWarning("tops", name, effect, remedy, place_of_first))
    if report.settings.assumed and report.rounds:
        effect = (
            f"The tie moved {100 * report.moved:.0f} % of the data of horizon {name!r}, by up to "
            f"{length_text(report.largest)}: those within {length_text(report.settings.range)} of "
            "a well, the default range."
        )
        remedy = 'Set the range [m], as in tie={"range": 500}; in a scenario, range_m in [tops].'
        warnings.append(GeosurfWarning("tie", name, effect, remedy))
    return warnings


def _refuse_misfit(controls: Controls, tops: Tops, settings: TieSettings) -> None:
    """Name the top that a tie does not meet."""
    worst = int(np.abs(controls.residual).argmax())
    row = int(controls.top[worst])
    at = tops.points[row]
    raise GeometryError(
        f"the tie does not meet the top {tops.words(row)} at {place(at)}: after {ROUNDS} "
        f"corrections the misfit is {-controls.residual[worst]:.3g} m, and the tolerance is "
        f"{settings.tolerance:g} m. The range of {length_text(settings.range)} may be too small "
        f'next to a fault. Give tie={{"range": {2 * settings.range:g}}}, or leave this top out.',
        place=at,
        surfaces=(tops.horizons[row],),
    )


def data_to_tie(
    data: Any, name: str, positive: str | None = None, length_unit: str | None = None
) -> Any:
    """
    Return the data of a horizon as a surface or as a dataset of points, in metres, positive up.

    Parameters
    ----------
    data : xarray.DataArray, xarray.Dataset, pandas.DataFrame, array_like (n, 3) or TriSurface
        As for `tear_horizon`.
    name : str
    positive, length_unit : str, optional

    Returns
    -------
    TriSurface or xarray.Dataset
    """
    if isinstance(data, TriSurface):
        return data
    if not are_points(data):
        surface = triangulate_horizon(data, name=name, positive=positive, length_unit=length_unit)
        check_spikes(surface)
        return surface
    _, points = points_of(data, name, positive, length_unit)
    attrs = {"units": "m", "positive": "up"}
    crs = crs_of(data)
    return xr.Dataset(
        {
            key: ("point", points[:, k].copy(), attrs if key == "elevation" else {"units": "m"})
            for k, key in enumerate(COORDINATES)
        },
        attrs={"name": name} if crs is None else {"name": name, "crs": crs},
    )


def points_of_data(data: Any) -> np.ndarray:
    """World coordinates (n, 3) of the data: vertices of a surface, or the points of a dataset."""
    if isinstance(data, TriSurface):
        return data.vertices
    return points_in(data)


def corrected_data(data: Any, change: np.ndarray) -> Any:
    """
    Return the data with changed elevations, in the form they had.

    Parameters
    ----------
    data : TriSurface or xarray.Dataset
        A grid or mesh, or points over one dimension: easting, northing, elevation [m], positive up.
    change : ndarray of float64, shape (n,)
        Added to the elevations of `points_of_data` [m].

    Returns
    -------
    TriSurface or xarray.Dataset
    """
    if not isinstance(data, TriSurface):
        elevation = data["elevation"]
        changed = elevation.copy(data=elevation.values + change.reshape(elevation.shape))
        return data.assign(elevation=changed)
    if data.lattice is None:
        vertices = data.vertices.copy()
        vertices[:, 2] += change
        corrected = TriSurface(data.name, data.role, vertices, data.triangles)
    else:
        grid = data.lattice
        z = grid.elevation.copy()
        present = np.isfinite(z)
        z[present] += change[grid.vertex_of_node[present]]
        lattice = replace(grid, elevation=frozen(z, np.float64))
        corrected = TriSurface(data.name, data.role, lattice=lattice)
    corrected.crs = data.crs
    return corrected
