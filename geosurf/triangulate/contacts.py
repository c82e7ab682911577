"""Fluid contacts: levels and grids that split units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions import is_number
from geosurf.errors import InputError
from geosurf.model import FluidContact, TriSurface
from geosurf.model.column import ELSEWHERE
from geosurf.model.expected import box_of_sides
from geosurf.triangulate.horizon import triangulate_horizon

_HOW = (
    "Give an elevation [m], a gridded horizon, a surface, a FluidContact, {block: one of these}, "
    "or a list of FluidContacts."
)


def build_contacts(
    contacts: Mapping[str, Any], box: Sequence[float]
) -> tuple[list[TriSurface], list[FluidContact]]:
    """
    Return the surfaces of fluid contacts, and in which zones and blocks they count.

    Parameters
    ----------
    contacts : mapping of str to contact
        From the top down: ``{"GOC": -1650.0, "OWC": -1705.0}``. A contact is an elevation
        [m, positive up], a gridded horizon (`xarray.DataArray`), a `TriSurface`, or a mapping of
        block to one of these: ``{"F1+": -1705.0, "F1- F2+": -1720.0, "elsewhere": -1690.0}``.
        A block is given by sides of faults that units lie on (``Unit.fault_sides``); of several
        that fit, the one with most sides in the name of the unit's block counts, then most sides.
        Units that no entry fits are not split, and are listed in
        ``units.report["without_contact"]``.
        A `FluidContact`, or a list of them, also names the zones where it applies:
        ``[FluidContact(-1705.0, zones="Top/Middle"), FluidContact(-1720.0, zones="Middle/Base")]``.
    box : (west, east, south, north, bottom, top)
        Of the model [m].

    Returns
    -------
    surfaces : list of TriSurface
        Role ``"contact"``.
    contacts : list of FluidContact
        One for each surface, with its name.

    Raises
    ------
    InputError
        If a contact has another type, an elevation is not inside the box, or one block and its
        zones are given twice.

    Examples
    --------
    >>> surfaces, found = build_contacts({"OWC": {"F1+": -1705.0}}, (0, 9, 0, 9, -1800, -1600))
    >>> surfaces[0], found[0].block
    (<TriSurface 'OWC in F1+' (contact): 4 vertices, 2 triangles>, 'F1+')
    """
    if not isinstance(contacts, Mapping):
        raise InputError(
            "`contacts` must be a mapping such as {'OWC': -1705.0}, not "
            f"{type(contacts).__name__}."
        )

    surfaces: list[TriSurface] = []
    found: list[FluidContact] = []
    box = box_of_sides(box).tolist()

    # A contact has one entry for the whole field, or one for each block; each becomes a surface.
    for name, value in contacts.items():
        entries = _entries(str(name), value)
        if not entries:
            raise InputError(f"fluid contact {name!r} has an empty mapping of blocks. {_HOW}")
        for entry in entries:
            if entry.name not in ("", str(name)):
                raise InputError(
                    f"fluid contact {name!r} holds a FluidContact with another name, "
                    f"{entry.name!r}. Use one name for both."
                )

            # the same contact may count in several zones or blocks, but once in each
            one = replace(entry, name=str(name))
            if any(one.surface == surface.name for surface in surfaces):
                raise InputError(
                    f"fluid contact {one.surface!r} is given twice. Leave one of them out, or "
                    "give each its own zones or block."
                )
            surfaces.append(_surface(one.surface, one.at, box))
            found.append(one)
    return surfaces, found


def _entries(name: str, value: Any) -> list[FluidContact]:
    """What is given for one contact, each with its zones and block."""
    if isinstance(value, FluidContact):
        return [value]
    if isinstance(value, list | tuple):
        odd = [one for one in value if not isinstance(one, FluidContact)]
        if odd:
            raise InputError(f"fluid contact {name!r} is a list that holds {odd[0]!r}. {_HOW}")
        return list(value)
    if not isinstance(value, Mapping) or hasattr(value, "data_vars"):
        return [FluidContact(value)]
    # A mapping that is not a Dataset: one value per block.
    return [one for key, part in value.items() for one in _of_block(name, str(key), part)]


def _of_block(name: str, key: str, value: Any) -> list[FluidContact]:
    """What is given for one block of a contact."""
    # The key says which block; a FluidContact may repeat it, but not contradict it.
    block = "" if key == ELSEWHERE else key
    parts = list(value) if isinstance(value, list | tuple) else [value]
    entries = [one if isinstance(one, FluidContact) else FluidContact(one) for one in parts]
    for one in entries:
        if one.block not in ("", block):
            raise InputError(
                f"fluid contact {name!r} has two blocks: {key!r} as its key and {one.block!r} "
                "in the FluidContact. Keep one of them."
            )
    return [replace(one, block=block) for one in entries]


def _surface(name: str, value: Any, box: Sequence[float]) -> TriSurface:
    # A surface, a grid, or else a level.
    if isinstance(value, TriSurface):
        return value.renamed(name, "contact")
    if hasattr(value, "dims"):
        return triangulate_horizon(value, name=name).renamed(name, "contact")
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise InputError(f"fluid contact {name!r} cannot be a {type(value).__name__}. {_HOW}")
    if not is_number(value):
        raise InputError(f"the elevation of fluid contact {name!r} is {value}. Give a number [m].")

    # A level inside the box: a rectangle of two triangles, counter-clockwise seen from above.
    west, east, south, north, bottom, top = box
    if not bottom < value < top:
        raise InputError(
            f"fluid contact {name!r} is at elevation {float(value):g} m, outside the model box "
            f"({bottom:g} to {top:g} m). Elevation is positive up, so depths are negative. "
            "Correct the elevation, or enlarge the box."
        )
    level = float(value)
    corners = [
        [west, south, level],
        [east, south, level],
        [east, north, level],
        [west, north, level],
    ]
    return TriSurface(name, "contact", corners, [[0, 1, 2], [0, 2, 3]])
