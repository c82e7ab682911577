"""Kernels that only tests call: signs, points and an order row by row, for oracles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from geosurf.kernels.compile.jit import RUNNER, entry
from geosurf.kernels.cutting.face_signs import (
    AXIS,
    N_STATE,
    FacePoints,
    add_local,
    exact_circle,
    filtered_circle,
    in_circle,
    turn,
)
from geosurf.kernels.exact.constructed_points import point_dd
from geosurf.kernels.exact.exact_signs import Frame


def compiled(signature: str) -> Callable[..., Any]:
    """Compile a function as an entry where kernels are compiled here, else leave it as it is."""
    return entry(signature) if RUNNER.compiles else lambda function: function


@compiled("d2 l2 l2 l1 l2 d2 -> .")
def point_dd_rows(x, t, e, m, d, out):
    """out[i]: whether point d[i] is known, its coordinates, their low parts and their bounds."""
    for i in range(d.shape[0]):
        known, p, r, s = point_dd(x, t, e, m, d[i, 0], d[i, 1], d[i, 2], d[i, 3])
        out[i, 0] = 1.0 if known else 0.0
        for k in range(3):
            out[i, 1 + k], out[i, 4 + k], out[i, 7 + k] = p[k], r[k], s[k]


@compiled("d2 l2 l2 l2 l1 l1 l1 l l2 l2 -> .")
def sign_rows(x, t, e, d, m, w, ids, axis, rows, out):
    """Turn of ids[rows[i, :3]]; side of the circle of these on which the fourth is, and whether
    `in_circle` puts it inside, both 0 where they do not turn left.

    The points lie in one plane that is not parallel to the axis.
    """
    q = np.empty((ids.shape[0], 8), dtype=np.int32)
    f = np.empty((ids.shape[0], 5), dtype=np.float64)
    s = np.zeros(N_STATE, dtype=np.int64)
    s[AXIS] = axis
    frame, points = Frame(x, t, e, d, m, w), FacePoints(q, f, s)
    for i in range(ids.shape[0]):
        add_local(frame, points, ids[i], 0)
    for i in range(rows.shape[0]):
        a, b, c, o = rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3]
        out[i, 0] = turn(frame, points, a, b, c)
        out[i, 1] = out[i, 2] = 0
        if out[i, 0] > 0:
            out[i, 1] = filtered_circle(f, a, b, c, o)
            if out[i, 1] == 0:
                out[i, 1] = exact_circle(frame, points, a, b, c, o)
            if in_circle(frame, points, a, b, c, o):
                out[i, 2] = 1
