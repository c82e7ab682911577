"""Trim torn sheets at their faults after the rebuild.

A sheet that was torn reaches past its fault with vertices without data
(``vertex_data["ghost"]``); the outermost of them (``"outer"``) lie beyond the fault. The rebuild
cuts the sheet there, exactly. Patches of a sheet are joined again where only walls and other
horizons cut it; a part that holds an outer vertex lies beyond a fault and is dropped, so that the
sheet ends on the fault and shares its vertices. So is a part on the wrong side of a fault, if the
sheet states the walls of its vertices (`wall_sides`).
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.meshes.sheet_parts import join_past_others
from geosurf.kernels.sheets.sheet_trim import classify_parts
from geosurf.model import Patches
from geosurf.model.expected import expect
from geosurf.model.torn_lattice import TornLattice
from geosurf.rebuild.dropped import drop_patches, drop_triangles
from geosurf.rebuild.listed import Listed
from geosurf.rebuild.wall_sides import on_wrong_side


def trim_sheets(patches: Patches) -> Patches:
    """
    Drop the parts of torn sheets that lie beyond their faults.

    Parameters
    ----------
    patches : Patches
        From `rebuild_surfaces`, with all faults that tear the sheets.

    Returns
    -------
    Patches
        The same without those triangles; ``report["dropped_area"]`` has their area by surface
        [m2]. Without torn sheets the patches come back unchanged.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> corners = [[0, 0, 0], [9, 0, 0], [0, 9, 0]]
    >>> beyond = [False, True, False]
    >>> marks = {"ghost": beyond, "outer": beyond}
    >>> sheet = TriSurface("Top", "horizon", corners, [[0, 1, 2]], vertex_data=marks)
    >>> fault = TriSurface("F1", "fault", [[3, -9, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> trim_sheets(rebuild_surfaces([sheet, fault])).surface("Top").bounds
    (0.0, 3.0, 0.0, 9.0, 0.0, 0.0)
    """
    expect(patches, Patches, "trim_sheets takes Patches", "pass the result of rebuild_surfaces")
    sheets = [one for one in patches.sources if "ghost" in one.vertex_data]
    if not sheets:
        return patches

    # of other grids all triangles are looked at
    lattices = [sheet.lattice for sheet in sheets]
    if not all(one is None or isinstance(one, TornLattice) for one in lattices):
        return drop_triangles(patches, kept_parts(patches)[0])
    mesh = Listed.without_runs(patches)
    has_runs = np.zeros(mesh.n_patch, dtype=bool)
    has_runs[patches.pieces.patch[len(mesh.triangles) :]] = True
    keep = np.ones(mesh.n_patch, dtype=bool)
    for i, joined, stays in _parts_of_sheets(mesh, None, has_runs):
        mine = mesh.patch_of_triangle[mesh.rows(i)]
        keep[mine] = stays[joined[mine]]
    return drop_patches(patches, mesh, keep)


def kept_parts(patches: Patches) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which triangles stay; corners that are corners of their parents; and parts of torn sheets.

    The second is (n_triangle, 3): the vertex of the source, or -1 for a point that was made.
    The third numbers what only faults part, -1 for other surfaces.
    """
    mesh = Listed.all_of(patches)
    keep = np.ones(patches.n_triangle, dtype=bool)
    corner = np.full((patches.n_triangle, 3), -1)
    part = np.full(patches.n_triangle, -1)
    for i, joined, stays in _parts_of_sheets(mesh, corner):
        rows = mesh.rows(i)
        part[rows] = joined[mesh.patch_of_triangle[rows]]
        keep[rows] = stays[part[rows]]
    return keep, corner, part


def _parts_of_sheets(
    mesh: Listed, corner: np.ndarray | None, has_runs: np.ndarray | None = None
) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Of each torn sheet its row, the part of each patch, and which parts stay.

    Writes `corner` (n_triangle, 3), if it is given: the vertex of the sheet at each corner.
    Patches that have runs, if these are given, hold data: no ghost is in a run.
    """
    found = []
    for i, source in enumerate(mesh.sources):
        ghost = source.vertex_data.get("ghost")
        if ghost is None:
            continue

        # Parts between faults; a part is dropped if it lies beyond one or has no data.
        rows = mesh.rows(i)
        joined = join_past_others(
            *mesh.at_curves, mesh.surface_of_triangle, mesh.patch_of_triangle,
            mesh.parent_of_triangle, i, mesh.n_patch,
        )  # fmt: skip
        named = np.empty((0, 3), dtype=np.int64) if corner is None else corner[rows]
        sheet = mesh.sheet(i)
        held, beyond = classify_parts(
            mesh.local, mesh.triangles[rows], sheet.parent, sheet.faces, sheet.places,
            mesh.origin, mesh.on_fault, ghost[sheet.vertex],
            source.vertex_data["outer"][sheet.vertex], mesh.patch_of_triangle[rows], joined,
            len(joined), named,
        )  # fmt: skip
        if corner is not None:
            named[:] = np.where(named >= 0, sheet.vertex[named], -1)
        if has_runs is not None:
            held[joined[has_runs]] = True
        wrong = on_wrong_side(mesh, i, joined)
        found.append((i, joined, held & ~beyond & ~wrong))
    return found
