"""Polylines as segments between distinct points.

Notation
    x        points (n, 3), polyline after polyline
    stops    end of each polyline in `x`
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry
from geosurf.kernels.meshes.mesh import weld_rows


@entry("d2 l1 l2 -> d2 l1 l2 l2")
def weld_lines(x, stops, owners):
    """Distinct points, and rows of them instead of `x`; segments, the smaller row first, and the
    owners of each segment: `owners` (n_polyline, 2).
    """
    number, count = weld_rows(x)
    once, n_line = np.empty((count, 3)), stops.shape[0]
    n = max(x.shape[0] - n_line, 0)
    segments, owned = np.empty((n, 2), dtype=np.int64), np.empty((n, 2), dtype=np.int64)
    at, first = 0, 0
    for line in range(n_line):
        # `first` is the first point of this polyline, `stops[line]` that of the next one.
        for k in range(first, stops[line]):
            one = number[k]
            for axis in range(3):
                once[one, axis] = x[k, axis]
            # The first point of a polyline ends no segment.
            if k > first:
                before = number[k - 1]
                segments[at, 0], segments[at, 1] = min(one, before), max(one, before)
                owned[at, 0], owned[at, 1] = owners[line, 0], owners[line, 1]
                at += 1
        first = stops[line]
    return once, number, segments, owned
