"""Whether a horizon is the same at a fault that became longer elsewhere.

A tear reads its faults where they are near the horizon: distances of data at their own height,
traces, tips and branches. So a horizon is torn again only where a longer fault comes within `NEAR`
cells of it.

That nothing farther away matters is an assumption, measured and not proven. On three fields every
sheet that changed had a new triangle within 3.4 cells, so 12 cells are 3.5 times what was needed.
If it were wrong, one horizon would keep heights of the shorter fault: where the rule has to bite,
they differ by up to 0.1 m in the synthetic world of the tests. The sheet still ends on the longer
fault, and the certificate still holds. See decision 48.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from geosurf.model import Lattice, Sheet, TriSurface
from geosurf.sheets.faults.fault_distance import blocks_between, side_at_own_height
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.lattice.frame import frame_of_lattice

NEAR = 12.0  # cells; an assumption, see above


def is_unchanged(
    sheet: Sheet, before: Mapping[str, TriSurface], after: Mapping[str, TriSurface]
) -> bool:
    """Whether a sheet that ends on some faults is that of longer ones, too.

    Parameters
    ----------
    sheet : Sheet
    before, after : mapping of str to TriSurface
        Faults that it was torn at, and the same or longer ones.
    """
    # nodes, and ghosts beyond them
    points = sheet.surface.vertices
    return all(_is_far(sheet.lattice, points, fault, after[name]) for name, fault in before.items())


def as_near(
    horizon: TriSurface, versions: Mapping[str, Sequence[TriSurface]]
) -> dict[str, TriSurface]:
    """Return faults as short as a horizon can take them before it is torn.

    Parameters
    ----------
    horizon : TriSurface
        Without tears. One without a lattice takes all faults as long as they are.
    versions : mapping of str to sequence of TriSurface
        Each fault as it became longer.
    """
    if horizon.lattice is None:
        return {name: known[-1] for name, known in versions.items()}
    lattice, points = horizon.lattice, horizon.vertices
    return {
        name: next(one for one in known if _is_far(lattice, points, one, known[-1]))
        for name, known in versions.items()
    }


def _is_far(lattice: Lattice, points: np.ndarray, fault: TriSurface, longer: TriSurface) -> bool:
    """Whether a fault became longer only where no point (n, 3) is near, or not at all."""
    if fault is longer:
        return True

    # an extension leaves what was given as it is, and adds to it
    n, m = fault.n_vertex, fault.n_triangle
    if not np.array_equal(fault.vertices, longer.vertices[:n]):
        return False
    if not np.array_equal(fault.triangles, longer.triangles[:m]):
        return False
    if longer.n_triangle == m:
        return True

    # at their own height, as data are compared with a fault
    frame, _ = frame_of_lattice(lattice, f"horizon at {fault.name!r}")
    mesh = mesh_in_frame(longer, frame)
    mesh = replace(mesh, triangles=mesh.triangles[m:], normals=mesh.normals[m:])
    uv = frame.to_lattice(points[:, :2]) * frame.stretch
    z = points[:, 2]
    added, blocks = blocks_between(mesh, NEAR, float(z.min()), float(z.max()))
    if blocks is None:
        return True
    _, side = side_at_own_height(added, blocks, np.column_stack([uv, z]), NEAR)
    return not side.any()
