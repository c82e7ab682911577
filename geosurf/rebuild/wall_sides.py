"""On which side of a fault a part of a torn sheet lies, and on which it belongs.

A sheet that was moved by throw states the wall of each vertex (``vertex_data["wall of F1"]``: 1 in
the hanging wall, the front of the fault; -1 in the footwall). Where two faults cross close to a
horizon, the piece of one wedge may lie in another one. It is cut there like any other, and may
reach the next fault without an outer vertex.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.exact.predicates import frame_of, orient3d_rows
from geosurf.rebuild.listed import Listed

WALL = "wall of "  # before the name of the fault


def on_wrong_side(mesh: Listed, surface: int, part_of: np.ndarray) -> np.ndarray:
    """
    Return which parts of a sheet lie on the other side of a fault than their vertices belong to.

    Parameters
    ----------
    mesh : Listed
    surface : int
        Row of its sources. Without walls of vertices no part is on a wrong side.
    part_of : ndarray of int64, shape (n_patch,)
        Part of each patch of the sheet; as many as there are patches, at most.

    Returns
    -------
    ndarray of bool, shape (n_patch,)
    """
    source, (edge, triangle, _) = mesh.sources[surface], mesh.at_curves
    of, n_part = mesh.surface_of_triangle[triangle], len(part_of)
    x, t = mesh.local, mesh.triangles
    found = np.zeros(n_part, dtype=bool)
    faults = [k for k, other in enumerate(mesh.sources)
              if other.role == "fault" and WALL + other.name in source.vertex_data]  # fmt: skip
    if not faults:
        return found
    frame = frame_of(x)
    for k in faults:
        wall = source.vertex_data[WALL + mesh.sources[k].name]

        # pairs of a triangle of the sheet and one of the fault at the same edge
        mine, theirs = np.flatnonzero(of == surface), np.flatnonzero(of == k)
        one, two = _with_same_key(edge[mine], edge[theirs])
        a, b = triangle[mine[one]], triangle[theirs[two]]

        # a triangle of one wall only: around a tip the two are one
        belongs = wall[source.triangles[mesh.parent_of_triangle[a]]]
        known = (belongs == belongs[:, :1]).all(axis=1)
        a, b, belongs = a[known], b[known], belongs[known, 0]

        # the corner that is not on the edge, seen from the fault: in front of it or behind
        ends = mesh.curve_edges[edge[mine[one]][known]]
        corner = t[a][(t[a][:, :, None] != ends[:, None, :]).all(axis=2)]
        lies = np.empty(len(a), dtype=np.int64)
        orient3d_rows(x, np.column_stack([t[b], corner]), *frame, lies)
        length = np.linalg.norm(x[ends[:, 1]] - x[ends[:, 0]], axis=1)

        # a part has to be on its own side of each fault; slivers may be turned over by rounding,
        # so that the longer part of its edges decides
        balance = np.bincount(part_of[mesh.patch_of_triangle[a]], length * lies * belongs, n_part)
        found |= balance < 0.0
    return found


def _with_same_key(one: np.ndarray, two: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All pairs (row of `one`, row of `two`) with equal keys."""
    order = np.argsort(two, kind="stable")
    first = np.searchsorted(two[order], one, side="left")
    last = np.searchsorted(two[order], one, side="right")
    row = np.repeat(np.arange(len(one)), last - first)
    at = np.arange(len(row)) - np.repeat(np.cumsum(last - first) - (last - first), last - first)
    return row, order[np.repeat(first, last - first) + at]
