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
from geosurf.sheets.faults.fault_distance import (
    Blocks,
    blocks_between,
    side_at_own_height,
    window,
)
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
    if all(fault is after[name] for name, fault in before.items()):
        return True
    points = _Vertices(sheet)
    return all(_is_far(points, fault, after[name]) for name, fault in before.items())


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
    points = _Nodes(horizon.lattice, horizon.name)
    return {
        name: next(one for one in known if _is_far(points, one, known[-1]))
        for name, known in versions.items()
    }


class _Nodes:
    """Nodes of a lattice; only those in some blocks are listed."""

    def __init__(self, lattice: Lattice, name: str) -> None:
        self.frame, z = frame_of_lattice(lattice, f"horizon {name!r}")
        self._z = z.ravel()
        self.low, self.high = float(np.nanmin(z)), float(np.nanmax(z))

    def near(self, blocks: Blocks) -> np.ndarray:
        """Columns and rows [cells], and elevations, of all that can be near (n, 3)."""
        nodes = window(self.frame, blocks)
        nodes = nodes[np.isfinite(self._z[nodes])]
        return np.column_stack([self.frame.cells_of_node(nodes), self._z[nodes]])


class _Vertices:
    """Nodes of a sheet, and ghosts beyond them."""

    def __init__(self, sheet: Sheet) -> None:
        self.frame, _ = frame_of_lattice(sheet.lattice, f"horizon {sheet.name!r}")
        points = sheet.surface.vertices
        uv = self.frame.to_lattice(points[:, :2]) * self.frame.stretch
        self._places = np.column_stack([uv, points[:, 2]])
        self.low, self.high = float(points[:, 2].min()), float(points[:, 2].max())

    def near(self, blocks: Blocks) -> np.ndarray:
        """Columns and rows [cells], and elevations, of all (n, 3)."""
        return self._places


def _is_far(points: _Nodes | _Vertices, fault: TriSurface, longer: TriSurface) -> bool:
    """Whether a fault became longer only where no point is near, or not at all."""
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
    mesh = mesh_in_frame(longer, points.frame)
    mesh = replace(mesh, triangles=mesh.triangles[m:], normals=mesh.normals[m:])
    added, blocks = blocks_between(mesh, NEAR, points.low, points.high)
    if blocks is None:
        return True
    _, side = side_at_own_height(added, blocks, points.near(blocks), NEAR)
    return not side.any()
