"""Volumes between horizons on one lattice, by an exact sum over columns: no meshes, no units."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np


def columns(surfaces, box) -> list[float]:
    """Integrals over a box of the lowest of the first k horizons, k = 1 .. n [m3].

    All horizons have the same nodes in map view and the same triangles, so that heights are
    linear over each triangle: the triangle is cut to the box, and to where each horizon is lowest.
    """
    west, east, south, north = box[:4]
    xy, triangles = surfaces[0].vertices[:, :2] - (west, south), surfaces[0].triangles
    heights = np.stack([s.vertices[:, 2] for s in surfaces], axis=1)[triangles]
    corners = xy[triangles]
    size = np.array([east - west, north - south])
    meets = (corners.max(axis=1) > 0).all(axis=1) & (corners.min(axis=1) < size).all(axis=1)
    inside = (corners.min(axis=1) >= 0).all(axis=1) & (corners.max(axis=1) <= size).all(axis=1)
    falling = (np.diff(heights, axis=2) <= 0).all(axis=(1, 2))
    plain = np.flatnonzero(inside & falling)
    a, b, c = (corners[plain, k] for k in range(3))
    area = 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    parts = [list(area * heights[plain, :, k].mean(axis=1)) for k in range(len(surfaces))]
    for i in np.flatnonzero(meets & ~(inside & falling)):
        polygon = np.hstack([corners[i], heights[i]])
        for axis in range(2):
            polygon = _cut(polygon, -polygon[:, axis])
            polygon = _cut(polygon, polygon[:, axis] - size[axis])
        for k in range(len(surfaces)):
            parts[k] += _lowest(polygon, k + 1)
    return [math.fsum(part) for part in parts]


def _cut(polygon, excess):
    """The part of a polygon where a linear function, given at its corners, is not above 0."""
    kept = []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if excess[i] <= 0:
            kept.append(polygon[i])
        if excess[i] * excess[j] < 0:
            kept.append(
                polygon[i] + excess[i] / (excess[i] - excess[j]) * (polygon[j] - polygon[i])
            )
    return np.array(kept).reshape(-1, polygon.shape[1])


def _lowest(polygon, n: int) -> list[float]:
    """Integrals of the lowest of n heights over a polygon, triangle by triangle."""
    found = []
    for k in range(n):
        part = polygon
        for other in range(n):
            if other != k and len(part):
                if other < k and (part[:, 2 + k] == part[:, 2 + other]).all():
                    part = part[:0]  # equal all over: counted with the earlier one
                else:
                    part = _cut(part, part[:, 2 + k] - part[:, 2 + other])
        found += [_prism(part[0], p, q, k) for p, q in pairwise(part)]
    return found


def _prism(o, p, q, k: int) -> float:
    """Integral of one height over a triangle."""
    area = 0.5 * abs((p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]))
    return float(area * (o[2 + k] + p[2 + k] + q[2 + k]) / 3.0)
