"""Fluid contacts: levels and grids that split units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geosurf.errors import InputError
from geosurf.model import FluidContact, TriSurface
from geosurf.triangulate.horizon import triangulate_horizon

ELSEWHERE = "elsewhere"
_HOW = "Give an elevation [m], a gridded horizon, a surface, or {block: one of these}."


def build_contacts(
    contacts: Mapping[str, Any], box: Sequence[float]
) -> tuple[list[TriSurface], list[FluidContact]]:
    """
    Return the surfaces of fluid contacts, and in which blocks they count.

    Parameters
    ----------
    contacts : mapping of str to contact
        From the top down: ``{"GOC": -1650.0, "OWC": -1705.0}``. A contact is an elevation
        [m, positive up], a gridded horizon (`xarray.DataArray`), a `TriSurface`, or a mapping of
        block to one of these: ``{"F1+": -1705.0, "F1- F2+": -1720.0, "elsewhere": -1690.0}``.
        A block is given by sides of faults that units lie on (`Unit.lies_on`); of several that
        fit, the one with most sides in the name of the unit's block counts, then most sides. Units
        that no entry fits are not split, and are listed in ``units.report["without_contact"]``.
    box : (west, east, south, north, bottom, top)
        Of the model [m].

    Returns
    -------
    surfaces : list of TriSurface
        Role ``"contact"``.
    contacts : list of FluidContact

    Raises
    ------
    InputError
        If a contact is none of these, or an elevation is not inside the box.

    Examples
    --------
    >>> surfaces, found = build_contacts({"OWC": {"F1+": -1705.0}}, (0, 9, 0, 9, -1800, -1600))
    >>> surfaces[0], found[0].block
    (<TriSurface 'OWC in F1+' (contact): 4 vertices, 2 triangles>, 'F1+')
    """
    if not isinstance(contacts, Mapping):
        raise InputError(
            f"contacts is a {type(contacts).__name__}; give a mapping {{name: contact}}, as in "
            '{"OWC": -1705.0}.'
        )
    surfaces, found = [], []
    for name, value in contacts.items():
        entries = value if _is_plain_mapping(value) else {ELSEWHERE: value}
        if not entries:
            raise InputError(f"fluid contact {name!r} is given for no block. {_HOW}")
        for block, one in entries.items():
            everywhere = block == ELSEWHERE
            title = str(name) if everywhere else f"{name} in {block}"
            surfaces.append(_surface(title, one, box))
            found.append(FluidContact(str(name), title, "" if everywhere else str(block)))
    return surfaces, found


def _is_plain_mapping(value: Any) -> bool:
    return isinstance(value, Mapping) and not hasattr(value, "data_vars")


def _surface(name: str, value: Any, box: Sequence[float]) -> TriSurface:
    if isinstance(value, TriSurface):
        return value.renamed(name, "contact")
    if hasattr(value, "dims"):
        return triangulate_horizon(value, name=name).renamed(name, "contact")
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise InputError(f"fluid contact {name!r} is a {type(value).__name__}. {_HOW}")
    west, east, south, north, bottom, top = (float(side) for side in box)
    if not bottom < value < top:
        raise InputError(
            f"fluid contact {name!r} is at elevation {float(value):g} m, outside the model box "
            f"({bottom:g} to {top:g} m). Elevation is positive up: depths are negative; or enlarge "
            "the box."
        )
    level = float(value)
    corners = [
        [west, south, level],
        [east, south, level],
        [east, north, level],
        [west, north, level],
    ]
    return TriSurface(name, "contact", corners, [[0, 1, 2], [0, 2, 3]])
