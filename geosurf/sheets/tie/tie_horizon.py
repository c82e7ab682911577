"""Tie a horizon to its well tops: correct its data, tear or cut it again, compare."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geosurf.conventions import length_text, place
from geosurf.errors import GeometryError, GeosurfWarning
from geosurf.measure.well_columns import columns_through
from geosurf.model import Sheet, SheetReport, TriSurface
from geosurf.model.tie import TieReport, TieSettings
from geosurf.model.tops import Tops
from geosurf.sheets.tie.controls import Controls, controls_of, shares_in
from geosurf.sheets.tie.correction import correction
from geosurf.sheets.tie.cut_horizon import CutHorizon, cut_horizon, place_keys
from geosurf.sheets.tie.horizon_data import corrected_data, data_to_tie, points_of_data
from geosurf.warning import collected, warn

ROUNDS = 8  # corrections before an error names the top that is not met
MOST_NAMED = 6  # tops in one warning
Make = Callable[[Any], TriSurface | Sheet]


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
        If the range is too small for the cells of the horizon.
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
    made, found = _made(make, data)
    cut = cut_horizon(made, faults)
    controls = first = controls_of(cut, tops, rows)
    rounds = 0

    # torn again after each correction: heights near faults are solved for, so that one
    # correction of the data does not meet tops there
    while controls.largest > settings.tolerance:
        if rounds == ROUNDS:
            _refuse_misfit(controls, tops, settings)
        change = correction(cut, controls, tops, settings, check=rounds == 0)
        total += _at_data(cut, change, points, tops.points[controls.top], settings.range)
        made, found = _made(make, corrected_data(data, total))
        cut = cut_horizon(made, faults)
        controls = controls_of(cut, tops, rows)
        rounds += 1
    report = _report(name, settings, tops, first, controls, total, rounds)
    notes = _warnings(report, tops, controls)
    for warning in (*found, *notes):
        warn(warning)

    # the sheet's own report says that it was tied, and what was left out
    if isinstance(made, Sheet) and isinstance(made.report, SheetReport):
        words = [*made.report.notes, f"tied to well tops: {report}"]
        more = (*made.report.warnings, *notes)
        made = replace(made, report=replace(made.report, notes=words, warnings=more))
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


def _made(make: Make, data: Any) -> tuple[TriSurface | Sheet, list[GeosurfWarning]]:
    """The horizon, and warnings of making it, which count if it is the last one."""
    with collected() as found:
        made = make(data)
    return made, found


def _at_data(
    cut: CutHorizon, change: np.ndarray, points: np.ndarray, wells: np.ndarray, reach: float
) -> np.ndarray:
    """
    Change of elevation at data: that of the sheet which is nearest above or below.

    Data at the place of a vertex take its change; others that of the triangle they are above or
    below. Data in the gap of a fault, which lie on no sheet, stay.
    """
    found = np.zeros(len(points))

    # data out of reach of all wells do not change: they are not looked at
    near = np.zeros(len(points), dtype=bool)
    for well in wells:
        near |= np.hypot(*(points[:, :2] - well[:2]).T) < reach
    rows = np.flatnonzero(near)

    # vertices at the very place of a datum, by searching its place among theirs; two of them on a
    # fault, and the one nearest in elevation is on the datum's own wall
    order, keys = cut.by_place
    mine = place_keys(points[rows])
    first, last = (np.searchsorted(keys, mine, side) for side in ("left", "right"))
    best = np.full(len(rows), np.inf)
    for step in range(int((last - first).max(initial=0))):
        there = np.flatnonzero(first + step < last)
        vertex = order[first[there] + step]
        off = np.abs(cut.x[vertex, 2] - points[rows[there], 2])
        nearer = off < best[there]
        best[there[nearer]] = off[nearer]
        found[rows[there[nearer]]] = change[vertex[nearer]]
    return _between_vertices(cut, change, points, rows[first == last], found)


def _between_vertices(
    cut: CutHorizon, change: np.ndarray, points: np.ndarray, rows: np.ndarray, found: np.ndarray
) -> np.ndarray:
    """The same for data between vertices."""
    if not len(rows):
        return found
    columns = columns_through(cut.patches, points[rows], cut.rows)

    # of several triangles above and below a datum, the nearest one
    off = np.abs(columns.elevation - points[rows[columns.foot], 2])
    order = np.lexsort((off, columns.foot))
    foot, once = np.unique(columns.foot[order], return_index=True)
    triangle = np.searchsorted(cut.rows, columns.triangle[order[once]])
    share = shares_in(cut, triangle, points[rows[foot], :2])
    found[rows[foot]] = (change[cut.triangles[triangle]] * share).sum(axis=1)
    return found


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


def _warnings(report: TieReport, tops: Tops, controls: Controls) -> list[GeosurfWarning]:
    """Tops that are not used, and the effect of a range that nobody gave."""
    n, name = len(report.unused), report.horizon
    found = []
    if n:
        more = f" and {n - MOST_NAMED} more" if n > MOST_NAMED else ""
        effect = (
            f"The tie does not use {n} of {n + len(report.wells)} well tops of horizon {name!r}: "
            f"{'; '.join(report.unused[:MOST_NAMED])}{more}."
        )
        at = tops.points[next(iter(controls.unused))]
        remedy = "Correct these tops or the faults next to them, or leave these tops out."
        found.append(GeosurfWarning("tops", name, effect, remedy, at))
    if report.settings.assumed and report.rounds:
        effect = (
            f"The tie moved {100 * report.moved:.0f} % of the data of horizon {name!r}, by up to "
            f"{length_text(report.largest)}: those within {length_text(report.settings.range)} of "
            "a well, the default range."
        )
        remedy = 'Set the range [m], as in tie={"range": 500}; in a scenario, range_m in [tops].'
        found.append(GeosurfWarning("tie", name, effect, remedy))
    return found


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


__all__ = ["Tied", "tie_horizon", "tied_sheet"]
