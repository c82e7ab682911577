"""Well tops of a scene: read, checked, and compared with the names of its horizons."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted, did_you_mean, length_text
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model import Sheet, TriSurface
from geosurf.model.tops import TieReport, TieSettings, Tops, tops_of
from geosurf.scene.memory import Memory
from geosurf.warning import collected, warn


def opened_tops(tops: Any, options: dict[str, str | None]) -> Tops | None:
    """Return well tops, read from a file if they are a path; None if there are none."""
    if tops is None:
        return None
    if isinstance(tops, str | Path):
        from geosurf.read import otherwise, read_tops

        tops = read_tops(tops, **otherwise(options))
    return tops_of(tops)


def warnings_of_names(tops: Tops, horizons: tuple[str, ...]) -> list[GeosurfWarning]:
    """Return a warning for each horizon of the tops that a scene does not have."""
    found = []
    for name in dict.fromkeys(tops.horizons):
        if name not in horizons:
            wells = ", ".join(dict.fromkeys(tops.wells[k] for k in tops.of(name)))
            effect = (
                f"{counted(len(tops.of(name)), 'well top')} of {name!r} (wells {wells}) cannot be "
                f"used: the scene has the horizons {', '.join(horizons)}."
                f"{did_you_mean(name, horizons)}"
            )
            remedy = "Rename the horizon in the tops, or leave these tops out."
            found.append(GeosurfWarning("tops", name, effect, remedy))
    return found


def tied_surface(
    name: str,
    plain: TriSurface,
    sheet: Sheet | None,
    faults: Sequence[TriSurface],
    tops: Tops,
    settings: TieSettings,
) -> tuple[TriSurface, TieReport]:
    """
    Return a horizon that meets its well tops, and what was done.

    Parameters
    ----------
    name : str
    plain : TriSurface
        The horizon as it is without tops.
    sheet : Sheet or None
        The same, if it was torn before: it is compared, and cannot be corrected any more.
    faults : sequence of TriSurface
        As the model has them.
    tops : Tops
    settings : TieSettings

    Raises
    ------
    InputError
        If a sheet that was torn before does not meet its tops.
    """
    from geosurf.sheets.tie import tie_horizon

    # data can be corrected before they are torn; a finished sheet can only be compared
    if sheet is None:
        tied = tie_horizon(name, plain, lambda data: data, faults, tops, settings)
        return tied.data, tied.report
    # a tolerance that is always met: nothing is corrected
    compared = TieSettings(settings.range, np.inf)
    with collected() as found:
        report = tie_horizon(name, plain, lambda _: sheet, faults, tops, compared).report
    for warning in found:
        if warning not in sheet.warnings:  # a tie before has issued those
            warn(warning)
    if report.before > settings.tolerance:
        raise InputError(
            f"horizon {name!r} is a sheet that was torn before, so that tops cannot be tied: it "
            f"misses them by up to {length_text(report.before)}. Give the data of the horizon in "
            "place of the sheet, or leave tie= out; scene.misfit() lists all tops."
        )
    return plain, report


def remembered_tie(
    memory: Memory,
    name: str,
    plain: TriSurface,
    sheet: Sheet | None,
    faults: Sequence[TriSurface],
    tops: Tops,
    settings: TieSettings,
) -> tuple[TriSurface, TieReport]:
    """Return what `tied_surface` returns, from memory if it is there.

    Parameters
    ----------
    memory : Memory
    name, plain, sheet, faults, tops, settings
        As for `tied_surface`.
    """
    content = (tops.wells, tops.horizons, tops.points.tobytes(), settings)
    key = ("tied", name, *map(memory.key_of, (plain, *faults)), content)
    found: tuple[TriSurface, TieReport] = memory.get_or_compute(
        "tie", name, key,
        lambda: tied_surface(name, plain, sheet, faults, tops, settings),
        lambda result: str(result[1]), again=False,
    )  # fmt: skip

    # later stages find the tied surface by what it was made of
    memory.made_of(found[0], key)
    return found
