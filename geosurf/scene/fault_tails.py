"""Tails of faults: what lies beyond the fault that a fault crosses before it dies.

A fault and its virtual wall are cut where other faults cross them. A piece that separates nothing
is a tail, if another piece of the same fault separates, and the tail reaches the fault that its end
is to be joined to: the fault ends there already. A virtual wall on a tail divides nothing, so that
it can go without a change to any compartment.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from geosurf.carve.cells import OUTSIDE, Cells, find_cells
from geosurf.conventions import area_text, place
from geosurf.errors import GeometryError, GeosurfWarning
from geosurf.faults.virtual.edges import areas_of, edge_keys, edges_of, pieces_between, rows_of
from geosurf.faults.virtual.walls import Wall
from geosurf.model import Patches
from geosurf.model.compartments import ENDS, virtual_name


def edges_above_and_below(patches: Patches, wall: Wall) -> np.ndarray:
    """Edges of the vertical parts of a virtual wall."""
    upright = [k for k, part in enumerate(wall.parts) if part.side not in ENDS]
    at = rows_of(patches, virtual_name(wall.fault))
    of_strip = wall.strip_of_triangle[patches.parent_of_triangle[at]]
    return edge_keys(patches, at[np.isin(of_strip, upright)]).ravel()


def on_tails(
    patches: Patches, cells: Cells, wall: Wall, around: np.ndarray, walls: Sequence[Wall]
) -> np.ndarray:
    """
    Return which triangles of a virtual wall lie on tails of its fault.

    Parameters
    ----------
    patches : Patches
    cells : Cells
        Of the patches.
    wall : Wall
    around : ndarray of int64, shape (n,)
        Triangles of the wall that have the same cell on their two sides.
    walls : sequence of Wall
        Of all faults: vertical parts of other ones end a tail, as their faults do.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    fault = rows_of(patches, wall.fault)
    beside = cells.beside(fault)[1]
    inside = (beside != OUTSIDE).any(axis=1)
    divides = inside & (beside[:, 0] != beside[:, 1])
    if not divides.any():
        return np.zeros(len(around), dtype=bool)

    # the fault and its wall as one sheet, cut where others cross it
    rows = np.concatenate([fault[inside & ~divides], around])
    keys = edge_keys(patches, rows)
    faults = [one.name for one in patches.sources if one.role == "fault"]
    others = edges_of(patches, [name for name in faults if name != wall.fault])
    upright = [edges_above_and_below(patches, one) for one in walls if one is not wall]
    piece = pieces_between(keys, np.unique(np.concatenate([others, *upright])))

    # the fault itself, not its wall, reaches what each end of a tail is to be joined to
    strip = np.full(len(rows), -1)
    strip[len(rows) - len(around) :] = wall.strip_of_triangle[patches.parent_of_triangle[around]]
    is_tail = np.zeros(len(rows), dtype=bool)
    for one in np.unique(piece):
        mine = piece == one
        ends = [wall.parts[k] for k in np.unique(strip[mine & (strip >= 0)])]
        targets = {part.target for part in ends if part.side in ENDS}
        is_tail |= mine & all(
            np.isin(keys[mine & (strip < 0)], edges_of(patches, [name, virtual_name(name)])).any()
            for name in targets
        )
    return is_tail[len(rows) - len(around) :]


def warnings_of_tails(
    patches: Patches, compartments: Mapping[str, Mapping[str, str]]
) -> tuple[GeosurfWarning, ...]:
    """
    Return a warning for each fault of compartments of which a part divides nothing.

    Parameters
    ----------
    patches : Patches
        With the virtual walls as they end.
    compartments : mapping of str to mapping of str to str

    Returns
    -------
    tuple of GeosurfWarning

    Raises
    ------
    GeometryError
        If no part of a fault divides anything.
    """
    cells, found = find_cells(patches), []
    for name in (one for one in compartments if compartments[one]):
        rows = rows_of(patches, name)
        beside = cells.beside(rows)[1]
        inside = (beside != OUTSIDE).any(axis=1)
        around = rows[inside & (beside[:, 0] == beside[:, 1])]
        if not len(around):
            continue
        areas = areas_of(patches, around)
        corners = patches.local[patches.triangles[around[int(areas.argmax())]]]
        at = corners.mean(axis=0) + patches.origin
        how = f"compartments={{{name!r}: {{'start': 'boundary', 'end': 'boundary'}}}}"
        if len(around) == inside.sum():
            raise GeometryError(
                f"fault {name!r} divides nothing: there is a way around it near {place(at)}. "
                f"Continue it to the boundary: {how}; or leave it out of compartments.",
                place=at,
                surfaces=(name,),
            )
        found.append(
            GeosurfWarning(
                "virtual wall",
                name,
                f"{area_text(math.fsum(areas))} of fault {name!r} near {place(at)} divides "
                "nothing: the fault dies there beyond a fault that it crosses.",
                f"If it separates regions there, continue it: {how}; in a scenario, "
                f'{name} = "boundary" in [compartments].',
                tuple(at.tolist()),
            )
        )
    return tuple(found)


__all__ = ["edges_above_and_below", "on_tails", "warnings_of_tails"]
