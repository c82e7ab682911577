"""What a model shows about a torn sheet that was not cut alone: whether it ends on its faults.

`throw_horizon` and `tear_horizon` cut each sheet with its faults to see that. A realisation leaves
this to its model, which makes the same cuts: `trim_sheets` hands them to ``TriSurface.proof``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.model import Patches
from geosurf.model.pieces import FREE
from geosurf.rebuild.listed import Listed

Rim = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class SheetInModel:
    """The listed triangles of one sheet in a split model, before it is trimmed.

    Attributes
    ----------
    triangles : ndarray (n, 3)
        As points 0 .. n_point - 1.
    parent : ndarray (n,)
        Row of the triangle of the sheet that each is a part of.
    corner : ndarray (n, 3)
        Vertices of the sheet at the corners, -1 for points that were made.
    stays : ndarray of bool (n,)
        Whether it is left by the trimming.
    dropped : ndarray of int64
        Rows of further triangles of the sheet that the trimming drops: no curve touches these.
    rim : tuple
        Ends of edges of one triangle only, each (n_edge,), and that triangle.
    on_fault : ndarray of bool (n_point,)
    at_faults : dict of str to ndarray
        By fault, triangles with an edge on it.
    has_false_rim : bool
        Whether a triangle stays next to dropped ones with no fault between.
    """

    triangles: np.ndarray
    parent: np.ndarray
    corner: np.ndarray
    stays: np.ndarray
    dropped: np.ndarray
    rim: Rim
    on_fault: np.ndarray
    at_faults: dict[str, np.ndarray]
    has_false_rim: bool


def sheet_in_model(
    patches: Patches,
    mesh: Listed,
    of: int,
    corner: np.ndarray,
    stays: np.ndarray,
    dropped: np.ndarray,
) -> SheetInModel:
    """One sheet, `of`, in patches whose listed triangles are `mesh`; see `SheetInModel`."""
    rows, (edge, triangle, is_fault) = mesh.rows(of), mesh.at_curves
    surface = mesh.surface_of_triangle[triangle]
    mine = np.flatnonzero(surface == of)
    edge_of_mine, row = edge[mine], triangle[mine] - rows.start
    n_side = np.bincount(edge_of_mine, minlength=len(mesh.curve_edges))

    at_faults = {}
    for k in np.flatnonzero(mesh.is_fault).tolist():
        there = np.zeros(len(mesh.curve_edges), dtype=bool)
        there[edge[surface == k]] = True
        at_faults[mesh.sources[k].name] = row[there[edge_of_mine]]
    single = n_side[edge_of_mine] == 1

    # where a sheet crosses itself, a part that goes may leave a rim of one that stays
    n_left = np.bincount(edge_of_mine, stays[row], minlength=len(mesh.curve_edges))
    is_false = (n_side > 1) & (n_left > 0) & (n_left != 2) & ~is_fault
    return SheetInModel(
        mesh.triangles[rows], mesh.parent_of_triangle[rows], corner, stays, dropped,
        _rim(patches, mesh, rows, edge_of_mine[single], row[single]),
        mesh.on_fault, at_faults, bool(is_false.any()),
    )  # fmt: skip


def _rim(
    patches: Patches, mesh: Listed, rows: slice, single: np.ndarray, of_single: np.ndarray
) -> Rim:
    """Edges with one triangle of the sheet: those that are alone, and those of curves, `single`."""
    pieces, halves = patches.pieces, slice(3 * rows.start, 3 * rows.stop)
    is_alone = pieces.ring[halves] == np.arange(halves.start, halves.stop)
    alone = np.flatnonzero(is_alone & (pieces.link[halves] == FREE))
    row, k = np.divmod(alone, 3)
    t = mesh.triangles[rows]
    one, two = t[row, k], t[row, (k + 1) % 3]
    ends = mesh.curve_edges[single]
    low = np.concatenate([np.minimum(one, two), ends.min(axis=1)])
    high = np.concatenate([np.maximum(one, two), ends.max(axis=1)])
    key, first = np.unique(low * len(mesh.local) + high, return_index=True)
    low, high = np.divmod(key, len(mesh.local))
    return low, high, np.concatenate([row, of_single])[first]


__all__ = ["SheetInModel", "sheet_in_model"]
