"""The six sides of the model box."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.errors import InputError
from geosurf.model import TriSurface

_SIDES = ("west", "east", "south", "north", "bottom", "top")
_BOX = "(west, east, south, north, bottom, top)"

# corner i of the box is east, north, top where bit 0, 1, 2 of i is set; each row is
# one side, seen from outside counter-clockwise
_CORNERS = {
    "west": (0, 4, 6, 2),
    "east": (1, 3, 7, 5),
    "south": (0, 1, 5, 4),
    "north": (2, 6, 7, 3),
    "bottom": (0, 2, 3, 1),
    "top": (4, 5, 7, 6),
}


def build_walls(box: Sequence[float]) -> list[TriSurface]:
    """Return the six sides of the model box as surfaces.

    Parameters
    ----------
    box : (west, east, south, north, bottom, top)
        World coordinates [m], elevation positive up.

    Returns
    -------
    list of TriSurface
        Role "wall", named ``west``, ``east``, ``south``, ``north``, ``bottom``
        and ``top``, in this order; two triangles each, normals out of the box.

    Raises
    ------
    InputError
        If the box does not have six finite numbers, or is not in order.

    Examples
    --------
    >>> walls = build_walls((0, 4000, 0, 3000, -2500, -1500))
    >>> [wall.name for wall in walls]
    ['west', 'east', 'south', 'north', 'bottom', 'top']
    >>> walls[0].bounds
    (0.0, 0.0, 0.0, 3000.0, -2500.0, -1500.0)
    """
    limits = _checked_box(box).reshape(3, 2)
    corners = np.array([[limits[axis, (i >> axis) & 1] for axis in range(3)] for i in range(8)])
    halves = [[0, 1, 2], [0, 2, 3]]
    return [
        TriSurface(side, "wall", corners[list(_CORNERS[side])], np.array(halves)) for side in _SIDES
    ]


def _checked_box(box: Sequence[float]) -> np.ndarray:
    """Float64 (6,), finite and in order, or an InputError."""
    try:
        limits = np.asarray(box, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"box: {box!r} is not six numbers. Give {_BOX} in metres.") from error
    if limits.shape != (6,):
        raise InputError(
            f"box: found shape {limits.shape}, expected six numbers. Give {_BOX} in metres."
        )
    for side, value in zip(_SIDES, limits.tolist(), strict=True):
        if not np.isfinite(value):
            raise InputError(f"box: {side} is {value}. Give six finite numbers {_BOX} in metres.")
    for low, high in ((0, 1), (2, 3), (4, 5)):
        if not limits[low] < limits[high]:
            hint = " Elevation is positive up: depths are negative." if low == 4 else ""
            raise InputError(
                f"box: {_SIDES[low]} ({limits[low]:g}) is not less than {_SIDES[high]} "
                f"({limits[high]:g}). The order is {_BOX}.{hint}"
            )
    return limits
