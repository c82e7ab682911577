"""Length units that geosurf accepts, and their size in metres."""

from __future__ import annotations

from geosurf.errors import InputError

# metres per unit, for every spelling that is accepted in files and attributes
METRES_PER_UNIT = {
    "m": 1.0,
    "metre": 1.0,
    "metres": 1.0,
    "meter": 1.0,
    "meters": 1.0,
    "km": 1000.0,
    "ft": 0.3048,
    "foot": 0.3048,
    "feet": 0.3048,
    # By its definition of 1893: 1200/3937 m, longer than a foot by two parts in a million.
    "us_survey_foot": 1200.0 / 3937.0,
    "ftus": 1200.0 / 3937.0,
}


def metres_per_unit(length_unit: str | None, what: str) -> float:
    """Return the factor from a length unit to metres.

    Parameters
    ----------
    length_unit : str or None
        Its name, as in CF attributes: ``"m"``, ``"ft"``, ``"km"`` ...
    what : str
        Name of the object that carries the unit, for the message: ``"horizon 'Top'"``.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the unit is missing or unknown.

    Examples
    --------
    >>> metres_per_unit("ft", "horizon 'Top'")
    0.3048
    """
    if length_unit is None:
        raise InputError(
            f"{what}: the length unit is missing. Set attrs['units'] = 'm' or length_unit='m'."
        )
    # Case and spaces do not matter; anything but text is refused like an unknown word.
    factor = (
        METRES_PER_UNIT.get(length_unit.strip().lower()) if isinstance(length_unit, str) else None
    )
    if factor is None:
        known = ", ".join(sorted(METRES_PER_UNIT))
        raise InputError(
            f"{what}: unknown length unit {length_unit!r}. "
            f"Set attrs['units'] or length_unit= to one of {known}."
        )
    return factor
