"""Map areas of the upper side of a unit."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def upper_area(points: np.ndarray, triangles: np.ndarray) -> float:
    """
    Return the map area of the triangles that face upwards [m2].

    Examples
    --------
    >>> points = np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 1]])
    >>> upper_area(points, np.array([[0, 1, 2], [0, 2, 1]]))
    3.0
    """
    # twice the signed map area of each triangle: up-facing ones alone give the upper side
    a, b, c = (points[triangles[:, k], :2] for k in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    up = ux * vy - uy * vx
    return 0.5 * math.fsum(up[up > 0.0].tolist())


def rows_of_contacts(names: Sequence[str], contacts: Sequence[str]) -> list[int]:
    """
    Return which surfaces are fluid contacts; those of blocks are named ``OWC in F1+``.

    Examples
    --------
    >>> rows_of_contacts(["Top", "OWC", "OWC in F1+"], ["OWC"])
    [1, 2]
    """
    inside = tuple(f"{contact} in " for contact in contacts)
    return [i for i, name in enumerate(names) if name in contacts or name.startswith(inside)]
