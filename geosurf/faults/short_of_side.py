"""Faults whose rim runs along a side of the model, a little inside of it: units go around them.

Meshes of other packages end within the last cell of their grid. Such a fault does not divide units.
It is not an error, since a fault may end inside of a model.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from geosurf.conventions import length_text, place
from geosurf.errors import GeosurfWarning
from geosurf.faults.distance import open_edges
from geosurf.model import TriSurface

# A rim is next to a side within so many of its own edges, and within this part of the side. A fault
# that dies inside of the model ends farther away, or across the side.
EDGES, PART = 2.0, 0.05
LONGER = 4.0  # times as long along the side as it may be away from it
ROUNDING = 1e-9  # part of the coordinates, below which a rim lies on the side
SIDES = ("south", "east", "north", "west")


def warning_of_rim(
    surface: TriSurface, box: Sequence[float], aoi: np.ndarray | None = None
) -> GeosurfWarning | None:
    """
    Return the warning of a fault that ends just inside of a side of the model, or None.

    Parameters
    ----------
    surface : TriSurface
    box : (west, east, south, north, bottom, top)
        [m]
    aoi : ndarray of float64, shape (n, 2), optional
        Area of interest, if there is one.

    Examples
    --------
    >>> wall = [[10, 500, -900], [990, 500, -900], [990, 500, 0], [10, 500, 0]]
    >>> fault = TriSurface("F1", "fault", wall, [[0, 1, 2], [0, 2, 3]])
    >>> print(warning_of_rim(fault, (0, 1000, 0, 1000, -800, -100)))
    Fault 'F1' ends 10 m before the east side of the model box (and 1 more), for example at \
(E 990, N 500, elevation -800 m). Units go around it there and are not divided. Continue it, as in \
gs.extend_fault(fault, box, sides='strike').surface, or take box=(11, 989, 0, 1000, -800, -100).
    """
    west, east, south, north, low, high = box
    corners = np.array([(west, south), (east, south), (east, north), (west, north)], dtype=float)
    ring = corners if aoi is None else np.asarray(aoi, dtype=np.float64)
    x = surface.vertices
    rim = open_edges(surface.triangles, len(x))
    if not len(rim):
        return None

    # rim edges between top and bottom of the model, cut off there
    step = float(np.median(np.linalg.norm(x[rim[:, 1]] - x[rim[:, 0]], axis=1)))
    heights = x[rim][:, :, 2]
    rim = rim[(heights.max(axis=1) > low) & (heights.min(axis=1) < high)]
    edges = _clipped(x[rim], low, high)
    inside = _in_ring(edges.reshape(-1, 3), ring).reshape(-1, 2)

    found = []
    for k, (a, b) in enumerate(zip(ring, np.roll(ring, -1, axis=0), strict=True)):
        length = float(np.hypot(*(b - a)))
        if length == 0.0:
            continue
        along = (b - a) / length
        off = np.abs((edges[:, :, :2] - a) @ [-along[1], along[0]])

        # edges next to one that goes deeper belong to a rim that crosses the side
        deep = (inside & (off > min(EDGES * step, PART * length))).any(axis=1)
        close = inside.any(axis=1) & ~np.isin(rim, rim[deep]).any(axis=1)
        off = np.where(inside, off, 0.0)
        if not close.any() or off[close].max() <= ROUNDING * np.abs(ring).max():
            continue  # a rim on the side itself is closed

        # how far these edges go along the side: in the map, or down the dip
        steps = np.diff(edges[close], axis=1)[:, 0]
        spread = float(np.hypot(steps[:, :2] @ along, steps[:, 2]).sum())
        gap = float(off[close].max())
        if spread > LONGER * gap:
            name = f"{SIDES[k]} side" if aoi is None else f"side {k} (counted from 0)"
            spot = edges[close][np.unravel_index(np.argmax(off[close]), off[close].shape)]
            found.append((gap, spot, name, k))
    if not found:
        return None
    gap, spot, side, _ = max(found, key=lambda one: one[0])
    where = "model box" if aoi is None else "area of interest"
    more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
    return GeosurfWarning(
        "rim",
        surface.name,
        f"Fault {surface.name!r} ends {length_text(gap)} before the {side} of the {where}{more}, "
        f"for example at {place(spot)}. Units go around it there and are not divided.",
        "Continue it, as in gs.extend_fault(fault, box, sides='strike').surface, or take "
        f"{_smaller(box, found) if aoi is None else 'an aoi that ends inside of the fault'}.",
        spot,
    )


def _smaller(box: Sequence[float], found: Sequence[tuple[float, np.ndarray, str, int]]) -> str:
    """A box whose sides lie beyond the gaps, with two digits of them."""
    sides = list(box)
    for gap, _, _, k in found:
        digit = 10.0 ** (math.floor(math.log10(gap)) - 1)
        moved = (math.floor(gap / digit) + 1) * digit
        # south, east, north, west
        place, sign = ((2, 1), (1, -1), (3, -1), (0, 1))[k]
        sides[place] = float(f"{box[place] + sign * moved:.10g}")
    # sides that stay keep all digits: horizons may end exactly there
    words = (repr(float(value)).removesuffix(".0") for value in sides)
    return f"box=({', '.join(words)})"


def warnings_of_rims(
    faults: Iterable[TriSurface], box: Sequence[float], aoi: np.ndarray | None
) -> list[GeosurfWarning]:
    """Return the warnings of all faults that are meshes and end just inside of a side."""
    found = (warning_of_rim(one, box, aoi) for one in faults if one.lattice is None)
    return [one for one in found if one is not None]


def _clipped(edges: np.ndarray, low: float, high: float) -> np.ndarray:
    """Edges (n, 2, 3) between two elevations: what is beyond is cut off."""
    a, b = edges[:, 0], edges[:, 1]
    rise = b[:, 2] - a[:, 2]
    safe = np.where(rise == 0.0, 1.0, rise)
    parts = []
    for start in (a, b):
        t = np.where(rise == 0.0, 0.0, (np.clip(start[:, 2], low, high) - start[:, 2]) / safe)
        parts.append(start + t[:, None] * (b - a))
    return np.stack(parts, axis=1)


def _in_ring(points: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Whether points (n, 3) lie inside of a ring in the map; for a message, so rounding is fine."""
    found = np.zeros(len(points), dtype=bool)
    x, y = points[:, 0], points[:, 1]
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        crosses = (a[1] > y) != (b[1] > y)
        rise = b[1] - a[1] if b[1] != a[1] else 1.0
        found ^= crosses & (x < (b[0] - a[0]) * (y - a[1]) / rise + a[0])
    return found
