"""On which side of a fault a part of a torn sheet lies, and on which it belongs.

A sheet that was moved by throw states the wall of each vertex (``vertex_data["wall of F1"]``: 1 in
the hanging wall, the front of the fault; -1 in the footwall). Where two faults cross close to a
horizon, the piece of one wedge may lie in another one. It is cut there like any other, and may
reach the next fault without an outer vertex.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.sheet_parts import balance_at_fault
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
    found = np.zeros(len(part_of), dtype=bool)
    faults = [k for k, other in enumerate(mesh.sources)
              if other.role == "fault" and WALL + other.name in source.vertex_data]  # fmt: skip
    if not faults:
        return found
    frame = frame_of(mesh.local)
    part = part_of[mesh.patch_of_triangle]
    sheet, parent = mesh.sheet(surface), np.zeros(len(part), dtype=np.int64)
    parent[mesh.rows(surface)] = sheet.parent
    for k in faults:
        # a part has to be on its own side of each fault; slivers may be turned over by rounding,
        # so that the longer part of its edges decides
        wall = source.vertex_data[WALL + mesh.sources[k].name][sheet.vertex].astype(np.int64)
        balance = balance_at_fault(
            mesh.local, mesh.triangles, mesh.curve_edges, edge, triangle, mesh.surface_of_triangle,
            part, parent, wall, sheet.faces, surface, k, len(part_of), *frame,
        )  # fmt: skip
        found |= balance < 0.0
    return found
