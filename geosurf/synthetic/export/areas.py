"""Polygons in the map: what is inside, how far away it is, and a rule to integrate over it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np


def inside(polygon: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Whether places are inside a polygon (n, 2), by the parity of crossings to the east."""
    found = np.zeros(np.broadcast(x, y).shape, dtype=bool)
    for (x0, y0), (x1, y1) in _edges(polygon):
        # even-odd rule; level edges are never crossed by a level ray
        if y0 != y1:
            crossing = x0 + (y - y0) * (x1 - x0) / (y1 - y0)
            found ^= ((y0 <= y) != (y1 <= y)) & (x < crossing)
    return found


def distance_from(polygon: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Distance of places from a polygon [its unit], 0 inside."""
    found = np.full(np.broadcast(x, y).shape, np.inf)
    for (x0, y0), (x1, y1) in _edges(polygon):
        dx, dy = x1 - x0, y1 - y0

        # foot on the edge, as a share of it
        part = np.clip(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
        found = np.minimum(found, np.hypot(x - x0 - part * dx, y - y0 - part * dy))
    return np.where(inside(polygon, x, y), 0.0, found)


def quadrature(polygon: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places x, y inside a polygon and their weights (areas): midpoints, along rows cut exactly.

    Rows begin and end at the corners of the polygon, so that the rule is of second order.
    """
    # strips between corners: within one, no edge of the polygon begins or ends
    levels = np.unique(polygon[:, 1])
    places = []
    for low, high in pairwise(levels.tolist()):
        rows = max(int(np.ceil((high - low) / step)), 1)
        for y in low + (high - low) * (np.arange(rows) + 0.5) / rows:
            places += _row(polygon, float(y), (high - low) / rows, step)
    if not places:
        return np.empty(0), np.empty(0), np.empty(0)
    x, y, weight = np.concatenate(places, axis=1)
    return x, y, weight


def _row(polygon: np.ndarray, y: float, height: float, step: float) -> list[np.ndarray]:
    """Places and weights (3, n) of one row, for each part of it that is inside."""
    crossings = sorted(
        x0 + (y - y0) * (x1 - x0) / (y1 - y0)
        for (x0, y0), (x1, y1) in _edges(polygon)
        if (y0 <= y) != (y1 <= y)
    )
    parts = []

    # inside is between the first and the second crossing, the third and the fourth ...
    for west, east in zip(crossings[::2], crossings[1::2], strict=True):
        n = max(int(np.ceil((east - west) / step)), 1)
        x = west + (east - west) * (np.arange(n) + 0.5) / n
        parts.append(np.stack([x, np.full(n, y), np.full(n, height * (east - west) / n)]))
    return parts


def _edges(polygon: np.ndarray) -> list[tuple[list[float], list[float]]]:
    closed = polygon[:, :2].tolist()
    return list(pairwise([*closed, closed[0]]))
