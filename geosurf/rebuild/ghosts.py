"""Trim torn sheets at their faults after the rebuild.

A sheet that was torn reaches past its fault with vertices without data
(``vertex_data["ghost"]``); the outermost of them (``"outer"``) lie beyond the fault. The rebuild
cuts the sheet there, exactly. Patches of a sheet are joined again where only walls and other
horizons cut it; a part that holds an outer vertex lies beyond a fault and is dropped, so that the
sheet ends on the fault and shares its vertices. So is a part on the wrong side of a fault, if the
sheet states the walls of its vertices (`wall_sides`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from geosurf.kernels.sheets.sheet_corners import named_corners
from geosurf.kernels.sheets.sheet_trim import classify_parts, sides_of_edges
from geosurf.model import Patches, frozen
from geosurf.model.expected import expect
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
    if not any("ghost" in source.vertex_data for source in patches.sources):
        return patches
    keep, _, _ = kept_parts(patches)
    return drop_triangles(patches, keep)


def kept_parts(patches: Patches) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which triangles stay; corners that are corners of their parents; and parts of torn sheets.

    The second is (n_triangle, 3): the vertex of the source, or -1 for a point that was made.
    The third numbers what only faults part, -1 for other surfaces.
    """
    keep = np.ones(patches.n_triangle, dtype=bool)
    corner = np.full((patches.n_triangle, 3), -1)
    part = np.full(patches.n_triangle, -1)
    ends, of, fault = _at_curves(patches)

    # Points on any fault: there a sheet may end.
    on_fault = np.zeros(len(patches.local), dtype=bool)
    roles = np.array([source.role == "fault" for source in patches.sources])
    on_fault[patches.triangles[roles[patches.surface_of_triangle]]] = True
    for i, source in enumerate(patches.sources):
        ghost = source.vertex_data.get("ghost")
        if ghost is None:
            continue

        outer = source.vertex_data["outer"]
        rows = np.flatnonzero(patches.surface_of_triangle == i)
        faces = source.triangles[patches.parent_of_triangle[rows]]
        # Corners that are corners of the parent, by place.
        mine = named_corners(
            patches.local, patches.triangles, rows, faces, source.vertices, patches.origin
        )

        corner[rows] = mine
        patch = patches.patch_of_triangle
        joined = _joined(patches, i, ends, of, fault)
        # Parts between faults; a part is dropped if it lies beyond one or has no data.
        label = part[rows] = joined[patch[rows]]
        held, beyond = classify_parts(
            patches.triangles, rows, mine, faces, on_fault, ghost, outer, label, len(joined)
        )
        wrong = on_wrong_side(patches, i, ends, of, part, len(joined))
        keep[rows] = (held & ~beyond & ~wrong)[label]
    return keep, corner, part


def _at_curves(patches: Patches) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Half-edges on curves: number of the curve edge, triangle; and whether a fault is there."""
    edge_of, triangle_of = sides_of_edges(
        patches.triangles, patches.curve_edges, len(patches.local)
    )

    roles = np.array([s.role == "fault" for s in patches.sources])
    fault = np.zeros(len(patches.curve_edges), dtype=bool)
    fault[edge_of[roles[patches.surface_of_triangle[triangle_of]]]] = True
    return edge_of, triangle_of, fault


def _joined(
    patches: Patches, surface: int, edge: np.ndarray, triangle: np.ndarray, fault: np.ndarray
) -> np.ndarray:
    """A label for each patch: the same where only walls and horizons part patches of a surface."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    # Half-edges of this surface on curves of walls and horizons, sorted by edge.
    mine = (patches.surface_of_triangle[triangle] == surface) & ~fault[edge]
    edge, triangle = edge[mine], triangle[mine]
    order = np.argsort(edge, kind="stable")
    edge, triangle = edge[order], triangle[order]

    # Edges with two sides join the two patches.
    _, first, times = np.unique(edge, return_index=True, return_counts=True)
    pairs = first[times == 2]

    # where a sheet crosses itself past a fault, each of the two goes on through the other
    crossed = np.repeat(times > 2, times)
    parent = patches.parent_of_triangle[triangle[crossed]]
    rank = np.lexsort((parent, edge[crossed]))
    same = (np.diff(edge[crossed][rank]) == 0) & (np.diff(parent[rank]) == 0)
    through = np.flatnonzero(crossed)[rank]

    # Connected patches of this graph have one label.
    one = np.concatenate([triangle[pairs], triangle[through[:-1][same]]])
    two = np.concatenate([triangle[pairs + 1], triangle[through[1:][same]]])
    a, b = patches.patch_of_triangle[one], patches.patch_of_triangle[two]
    links = coo_array((np.ones(len(a)), (a, b)), shape=(patches.n_patch, patches.n_patch))
    return connected_components(links, directed=False)[1]


def drop_triangles(patches: Patches, keep: np.ndarray) -> Patches:
    """
    Return patches without some triangles, with vertices, curves and patches numbered again.

    Parameters
    ----------
    patches : Patches
    keep : ndarray of bool, shape (n_triangle,)

    Returns
    -------
    Patches
        ``report["dropped_area"]`` has the area of what is gone by surface [m2], with what was gone
        before.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [8, 0, 0], [0, 8, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[4, -9, -9], [4, 9, -9], [4, 4, 9]], [[0, 1, 2]])
    >>> patches = rebuild_surfaces([flat, wall])
    >>> keep = (patches.local[patches.triangles][:, :, 2] <= 0).all(axis=1)
    >>> drop_triangles(patches, keep).surface("F1").bounds[4:]
    (-9.0, 0.0)
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    # What is left at each curve edge, the surfaces in order.
    edge, triangle, _ = _at_curves(patches)
    edge, triangle = edge[keep[triangle]], triangle[keep[triangle]]
    order = np.lexsort((patches.surface_of_triangle[triangle], edge))
    edge, triangle = edge[order], triangle[order]

    numbers, first, times = np.unique(edge, return_index=True, return_counts=True)
    surface = patches.surface_of_triangle[triangle]
    last = first + times - 1
    plain = (times <= 2) & (surface[first] == surface[last])
    # patches on both sides of an edge that has ceased to be a curve become one
    inner = plain & (times == 2)

    a, b = (patches.patch_of_triangle[triangle[at[inner]]] for at in (first, last))
    links = coo_array((np.ones(len(a)), (a, b)), shape=(patches.n_patch, patches.n_patch))
    label = connected_components(links, directed=False)[1][patches.patch_of_triangle[keep]]

    # Patches are numbered by their first triangle.
    _, at, patch = np.unique(label, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(at))

    used = np.zeros(len(patches.local), dtype=bool)
    used[patches.triangles[keep]] = True
    number = np.cumsum(used) - 1

    curve = number[patches.curve_edges[numbers[~plain]]]
    return patches.changed(
        local=frozen(patches.local[used], np.float64),
        triangles=frozen(number[patches.triangles[keep]], np.int64),
        surface_of_triangle=frozen(patches.surface_of_triangle[keep], np.int64),
        parent_of_triangle=frozen(patches.parent_of_triangle[keep], np.int64),
        patch_of_triangle=frozen(rank[patch], np.int64),
        curve_edges=frozen(curve, np.int64),
        report={**patches.report, "dropped_area": _added(patches.report, _dropped(patches, ~keep))},
    )


def _added(report: Mapping[str, Any], dropped: dict[int, float]) -> dict[int, float]:
    """Areas that were dropped before and now, by surface [m2]."""
    before: Mapping[int, float] = report.get("dropped_area", {})
    both = {*before, *dropped}
    return {i: before.get(i, 0.0) + dropped.get(i, 0.0) for i in sorted(both)}


def _dropped(patches: Patches, rows: np.ndarray) -> dict[int, float]:
    """Area of the dropped triangles of each surface [m2]."""
    # Half the norm of the cross product of two sides [m2]; `fsum` does not depend on the order.
    a, b, c = (patches.local[patches.triangles[rows, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    surface = patches.surface_of_triangle[rows]
    return {int(i): math.fsum(area[surface == i]) for i in np.unique(surface)}
