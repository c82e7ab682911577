"""Which surfaces meet in the points of a mesh.

Notation
    t         triangles, int64 (n, 3)
    surface   surface of each, int64 (n,)
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry


@entry("l2 l1 l -> l1 b1")
def highest_of_points(t, surface, n_point):
    """Highest surface at each point, -1 for none; and whether triangles of others meet there."""
    highest = np.full(n_point, -1, dtype=np.int64)
    several = np.zeros(n_point, dtype=np.bool_)
    for i in range(t.shape[0]):
        for c in range(3):
            known = highest[t[i, c]]
            if known >= 0 and known != surface[i]:
                several[t[i, c]] = True
            highest[t[i, c]] = max(known, surface[i])
    return highest, several


@entry("l2 l1 b1 l -> l1")
def codes_of_points(t, surface, several, n_surface):
    """``point * n_surface + surface`` for each corner at a point where several surfaces meet."""
    n = 0
    for i in range(t.shape[0]):
        for c in range(3):
            n += int(several[t[i, c]])
    codes = np.empty(n, dtype=np.int64)
    n = 0
    for i in range(t.shape[0]):
        for c in range(3):
            if several[t[i, c]]:
                codes[n] = t[i, c] * n_surface + surface[i]
                n += 1
    return codes
