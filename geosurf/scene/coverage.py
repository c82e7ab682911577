"""How much of each input is inside the model: horizons in the map, faults on their surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.model import TriSurface
from geosurf.scene.inputs import Box

SAMPLE = 20_000  # triangles, or parts of triangles, of which each counts by its middle


def share_inside(surface: TriSurface, box: Box, outline: np.ndarray | None) -> float:
    """
    Return the share of a surface that is inside a model, to within about a percent.

    Parameters
    ----------
    surface : TriSurface
        Of a horizon the area in the map counts, whatever its elevation; of a fault its own area.
    box : (west, east, south, north, bottom, top)
        [m]
    outline : ndarray of float64, shape (n, 2), or None
        Corners of the area of the model [m]; None if it is the box.

    Examples
    --------
    >>> corners = [[0, 0, -90], [0, 40, -90], [0, 40, 0], [0, 0, 0]]
    >>> fault = TriSurface("F1", "fault", corners, [[0, 1, 2], [0, 2, 3]])
    >>> round(share_inside(fault, (-5, 5, 0, 30, -90, 0), None), 2)
    0.75
    """
    # sampled: a share in per cent goes into a table, and decides nothing
    middles, areas = _parts(surface)
    n_axis = 2 if surface.role == "horizon" else 3
    inside = np.ones(len(middles), dtype=bool)
    for axis in range(n_axis):
        inside &= (middles[:, axis] >= box[2 * axis]) & (middles[:, axis] <= box[2 * axis + 1])
    if outline is not None:
        inside[inside] = _in_ring(middles[inside], outline)
    total = float(areas.sum())
    return float(areas[inside].sum()) / total if total > 0 else 0.0


def _parts(surface: TriSurface) -> tuple[np.ndarray, np.ndarray]:
    """Middles (n, 3) and areas (n,) of parts of a surface: of large triangles many."""
    corners = _triangles(surface)

    # few large triangles are cut into n x n parts each, so that about SAMPLE parts count in all
    n = max(int(np.sqrt(SAMPLE / max(len(corners), 1))), 1)

    # parts that stand upright and those that stand on their tip, by the weights of their corners
    first = np.array([(i, j, n - 1 - i - j) for i in range(n) for j in range(n - i)])
    second = np.array([(i, j, n - 2 - i - j) for i in range(n - 1) for j in range(n - 1 - i)])
    weights = np.concatenate([first + 1.0 / 3.0, second.reshape(-1, 3) + 2.0 / 3.0]) / n
    middles = (weights @ corners).reshape(-1, 3)

    # relative areas are enough, and all parts of a triangle have the same
    a, b, c = corners.swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    flat = (
        np.abs(normals[:, 2])
        if surface.role == "horizon"
        else np.hypot(np.hypot(normals[:, 0], normals[:, 1]), normals[:, 2])
    )
    return middles, np.repeat(flat, len(weights))


def _triangles(surface: TriSurface) -> np.ndarray:
    """Corners (n, 3, 3) of all triangles, or of some spread evenly where there are many."""
    # at even distances, so that all of a large grid is seen
    rows = np.linspace(0, surface.n_triangle - 1, min(surface.n_triangle, SAMPLE)).astype(np.int64)
    keys = rows if surface.lattice is None else surface.lattice.keys_of_rows(rows)
    return surface.places_of_nodes(surface.corners_of_keys(keys).ravel()).reshape(-1, 3, 3)


def _in_ring(places: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """Whether places (n, 2 or 3) are inside an outline, bool (n,)."""
    inside = np.zeros(len(places), dtype=bool)
    x, y = places[:, 0], places[:, 1]
    for (ax, ay), (bx, by) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if ay != by:
            # half-open in y, so that a corner counts for one of its two sides
            crossed = (ay <= y) != (by <= y)
            inside ^= crossed & (x < ax + (y - ay) * (bx - ax) / (by - ay))
    return inside


def coverage_in_words(shares: Sequence[tuple[str, float]]) -> str:
    """Return names with the shares of them that are inside.

    Examples
    --------
    >>> coverage_in_words([("Top", 1.0), ("F1", 0.874), ("F2", 0.0)])
    'Top 100 %, F1 87 %, F2 0 %'
    """
    return ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares)


__all__ = ["coverage_in_words", "share_inside"]
