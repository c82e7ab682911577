"""Faults that do not reach the model: which, how far away, and what to type to include them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from geosurf.errors import GeosurfWarning
from geosurf.model import TriSurface

_SAMPLE = 4096  # places that are looked at
_ROOM = 0.05  # of the box, beyond the middle of a fault that it is to hold
_SIDES = (("west", "east"), ("south", "north"), ("below", "above"))


def lies_beside(surface: TriSurface, box: Sequence[float]) -> bool:
    """Return whether the bounds of a surface and a box have nothing in common."""
    bounds = surface.bounds
    return any(bounds[2 * k] > box[2 * k + 1] or bounds[2 * k + 1] < box[2 * k] for k in range(3))


def warning_of_fault(
    surface: TriSurface, box: Sequence[float], aoi: np.ndarray | None = None
) -> GeosurfWarning:
    """
    Return the warning of a fault that does not reach the model.

    Parameters
    ----------
    surface : TriSurface
    box : (west, east, south, north, bottom, top)
        [m]
    aoi : ndarray of float64, shape (n, 2), optional
        Area of interest, if there is one.

    Examples
    --------
    >>> wall = [[5500, 0, -90], [5500, 900, -90], [5500, 900, 0]]
    >>> fault = TriSurface("F2", "fault", wall, [[0, 1, 2]])
    >>> print(warning_of_fault(fault, (0, 5000, 0, 900, -90, 0)))
    Fault 'F2' lies 500 m east of the model box and is left out: it divides nothing. If it belongs \
to the model, enlarge the box to it, box=(0, 5750, 0, 900, -90, 0), if all horizons reach that far.
    """
    where = "model box" if aoi is None else "area of interest"
    bounds, wider, words = surface.bounds, list(box), []
    for k in range(3):
        # positive on the side where the fault's bounds end before the box begins
        below, above = box[2 * k] - bounds[2 * k + 1], bounds[2 * k] - box[2 * k + 1]
        if max(below, above) > 0:
            side = int(above > 0)
            words.append(f"{_metres(max(below, above))} {_SIDES[k][side]}")
            middle = 0.5 * (bounds[2 * k] + bounds[2 * k + 1])
            room = _ROOM * (box[2 * k + 1] - box[2 * k])
            wider[2 * k + side] = middle + room if side else middle - room

    # the distance is from samples: it goes into a sentence, not into the model
    points = _spots(surface)
    if words:
        of = "" if words[-1].endswith(_SIDES[2]) else " of"
        effect = f"{' and '.join(words)}{of} the {where}"
        low, high = np.array(box[0::2], dtype=float), np.array(box[1::2], dtype=float)
        off = np.maximum(points - high, 0.0) + np.maximum(low - points, 0.0)
        place = points[np.argmin((off**2).sum(axis=1))]
    else:
        # the bounds overlap, but the fault does not meet the outline in the map
        w, e, s, n = box[:4]
        ring = np.array([(w, s), (e, s), (e, n), (w, n)], dtype=float) if aoi is None else aoi
        distance, place = _beside(points, ring)
        effect = f"about {_metres(distance)} away from the {where}"
        if aoi is None:  # above or below a part of it, as a dipping fault may
            effect = f"close to the {where}, but not in it,"
    remedy = f"enlarge {'box' if aoi is None else 'aoi'}= to it, if all horizons reach that far."
    if words and aoi is None:
        # whole metres, with decimals only for boxes narrower than 100 m: `box=` should be short to
        # type
        digits = max(0, 2 - math.floor(math.log10(max(box[1] - box[0], box[3] - box[2]))))
        sides = ", ".join(f"{round(value, digits):.12g}" for value in wider)
        remedy = f"enlarge the box to it, box=({sides}), if all horizons reach that far."
    return GeosurfWarning(
        "outside",
        surface.name,
        f"Fault {surface.name!r} lies {effect} and is left out: it divides nothing.",
        f"If it belongs to the model, {remedy}",
        place,
    )


def _spots(surface: TriSurface) -> np.ndarray:
    """Points all over a surface: of large triangles many, of many triangles some."""
    # a lattice of barycentric weights on each triangle, or one triangle in many: about 4096 places
    # in either case
    n = max(int((_SAMPLE / max(surface.n_triangle, 1)) ** 0.5), 1)
    weights = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
    triangles = surface.triangles[:: max(surface.n_triangle // _SAMPLE, 1)]
    spots: np.ndarray = weights @ surface.vertices[triangles]
    return spots.reshape(-1, 3)


def _metres(length: float) -> str:
    return f"{length:.0f} m" if length >= 100 else f"{length:.3g} m"


def _beside(points: np.ndarray, ring: np.ndarray) -> tuple[float, np.ndarray]:
    """Least distance in the map of points to a ring, and the point that has it."""
    best, spot = math.inf, points[0]
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        edge = b - a

        # foot of the perpendicular, clipped to the edge; 1e-300 spares doubled corners a division
        # by 0
        t = np.clip((points[:, :2] - a) @ edge / max(float(edge @ edge), 1e-300), 0.0, 1.0)
        gaps = np.hypot(*(a + t[:, None] * edge - points[:, :2]).T)
        k = int(np.argmin(gaps))
        if gaps[k] < best:
            best, spot = float(gaps[k]), points[k]
    return best, spot
