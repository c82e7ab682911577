"""What to tell of units as thin as rounding: surfaces that meet but for the last digits."""

from __future__ import annotations

from geosurf.errors import GeosurfWarning
from geosurf.model import Units


def warnings_of_thin_units(units: Units) -> tuple[GeosurfWarning, ...]:
    """
    Return the warning that units are as thin as rounding, if there are any.

    Parameters
    ----------
    units : Units

    Returns
    -------
    tuple of GeosurfWarning
        One at most, with the place of the largest of them.
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
        f"{what} as thin as the rounding of coordinates ({largest.volume:.1e} m3): {surfaces} "
        "meet there but for the last digits.",
        "Leave such units out (units.report['thin'] lists them), or round the coordinates of these "
        "surfaces and of the box: np.round(x * 1024) / 1024.",
        largest.place,
    )
    return (warning,)
