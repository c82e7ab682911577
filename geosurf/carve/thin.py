"""Warn of units thinner than the rounding error: surfaces that almost coincide."""

from __future__ import annotations

from geosurf.errors import GeosurfWarning
from geosurf.model import Units


def warnings_of_thin_units(units: Units) -> tuple[GeosurfWarning, ...]:
    """
    Return a warning if units are thinner than the rounding error of coordinates.

    Parameters
    ----------
    units : Units

    Returns
    -------
    tuple of GeosurfWarning
        At most one, with the place of the largest thin unit.
    """
    thin = units.report.get("thin", ())
    if not thin:
        return ()
    largest = max(thin, key=lambda unit: unit.volume)
    surfaces = ", ".join(repr(name) for name in units[largest.name].bounded_by)
    what = f"Unit {largest.name!r} is"
    if len(thin) > 1:
        what = f"{len(thin)} units, of which {largest.name!r} is the largest, are"
    warning = GeosurfWarning(
        "thin unit",
        largest.name,
        f"{what} thinner than the rounding error of coordinates ({largest.volume:.1e} "
        f"m³): {surfaces} almost coincide there.",
        "Ignore such units (units.report['thin'] lists them), or round the coordinates "
        "of these surfaces and of the box: np.round(x * 1024) / 1024.",
        largest.place,
    )
    return (warning,)
