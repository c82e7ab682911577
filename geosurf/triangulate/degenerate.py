"""Triangles without area, found exactly.

A float filter passes what clearly has area; only what it doubts is decided in
rational arithmetic. Nothing is ever called degenerate because it is thin.
"""

from __future__ import annotations

import numpy as np

from geosurf.conventions import place
from geosurf.errors import SurfaceError
from geosurf.model.exact import exact_normal

# each component of the cross product is off by less than 4 rounding units of its terms,
# or by more where they underflow
_DOUBT = 8 * np.finfo(np.float64).eps
_UNDERFLOW = 1e-290


def find_zero_area(corners: np.ndarray) -> np.ndarray:
    """Return the rows of `corners` (n_triangle, 3, 3) whose area is exactly zero.

    Examples
    --------
    >>> flat = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    >>> find_zero_area(np.array([flat, [[0, 0, 0], [1, 1, 1], [3, 3, 3]]], dtype=float))
    array([1])
    """
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    plus, minus = u[:, [1, 2, 0]] * v[:, [2, 0, 1]], u[:, [2, 0, 1]] * v[:, [1, 2, 0]]
    doubted = np.flatnonzero(_in_doubt(plus, minus).all(axis=1))
    zero = [row for row in doubted if not any(exact_normal(corners[row]))]
    return np.array(zero, dtype=np.int64)


def map_turns(corners: np.ndarray) -> np.ndarray:
    """Return +1, 0 or -1 per triangle (n_triangle, 3, 2 or more): its turn in the map, exactly.

    Examples
    --------
    >>> map_turns(np.array([[[0.0, 0], [1, 0], [0, 1]], [[0, 0], [1, 1], [2, 2]]]))
    array([1, 0])
    """
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    plus, minus = u[:, 0] * v[:, 1], u[:, 1] * v[:, 0]
    turns = np.sign(plus - minus).astype(np.int64)
    for row in np.flatnonzero(_in_doubt(plus, minus)):
        flat = [[*corner[:2], 0.0] for corner in corners[row].tolist()]
        z = exact_normal(np.array(flat))[2]
        turns[row] = (z > 0) - (z < 0)
    return turns


def _in_doubt(plus: np.ndarray, minus: np.ndarray) -> np.ndarray:
    return np.abs(plus - minus) <= _DOUBT * (np.abs(plus) + np.abs(minus)) + _UNDERFLOW


def refuse_zero_area(
    name: str,
    vertices: np.ndarray,
    triangles: np.ndarray,
    remedy: str,
    rows: np.ndarray | None = None,
) -> None:
    """Raise a `SurfaceError` that names the first triangle without area (among `rows`), if any."""
    zero = find_zero_area(vertices[triangles if rows is None else triangles[rows]])
    zero = zero if rows is None else rows[zero]
    if len(zero):
        first = zero[0]
        raise SurfaceError(
            f"fault {name!r}: {len(zero)} of {len(triangles)} triangles have exactly zero area, "
            f"the first is triangle {first} (vertices {triangles[first].tolist()}) at "
            f"{place(vertices[triangles[first][0]])}. {remedy}"
        )
