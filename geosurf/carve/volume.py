"""Volume inside a closed shell, by the divergence theorem."""

from __future__ import annotations

import math

import numpy as np


def volume_of(local: np.ndarray, triangles: np.ndarray) -> float:
    """Volume inside a closed shell [m3], by compensated sums around its middle."""
    corners = local[triangles]
    corners = corners - 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    return math.fsum(np.einsum("ij,ij->i", a, np.cross(b, c))) / 6.0
