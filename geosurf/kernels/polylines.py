"""Polylines as segments.

Notation
    number   rows of points, int64, polyline after polyline
    stops    where each polyline ends in `number`
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry


@entry("l1 l1 l2 -> l2 l2")
def segments_of(number, stops, owners):
    """Segments, the smaller row first, and the owners of each: `owners` (n_polyline, 2)."""
    n_line = stops.shape[0]
    n = max(number.shape[0] - n_line, 0)
    segments, owned = np.empty((n, 2), dtype=np.int64), np.empty((n, 2), dtype=np.int64)
    at, first = 0, 0
    for line in range(n_line):
        for k in range(first + 1, stops[line]):
            one, two = number[k - 1], number[k]
            segments[at, 0], segments[at, 1] = min(one, two), max(one, two)
            owned[at, 0], owned[at, 1] = owners[line, 0], owners[line, 1]
            at += 1
        first = stops[line]
    return segments, owned
