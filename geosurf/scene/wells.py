"""Well tops of a scene: read, checked, and compared with the names of its horizons."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from geosurf.conventions import counted, did_you_mean
from geosurf.errors import GeosurfWarning
from geosurf.model.tops import Tops, tops_of


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
                f"{counted(len(tops.of(name)), 'well top')} of {name!r} (wells {wells}) are not "
                f"used: the scene has the horizons {', '.join(horizons)}."
                f"{did_you_mean(name, horizons)}"
            )
            remedy = "Rename the horizon in the tops, or leave these tops out."
            found.append(GeosurfWarning("tops", name, effect, remedy))
    return found


__all__ = ["opened_tops", "warnings_of_names"]
