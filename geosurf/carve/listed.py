"""List the triangles of some faces, numbered in the order of all triangles of the model."""

from __future__ import annotations

import numpy as np

from geosurf.carve.cells import Cells, FullCells
from geosurf.model.excerpt import list_triangles

_NONE = np.empty(0, dtype=np.int64)


def list_faces(cells: Cells, wanted: np.ndarray) -> FullCells:
    """
    Return cells with a face for every triangle of some faces.

    Parameters
    ----------
    cells : Cells
    wanted : ndarray of bool, shape (n_face,)

    Returns
    -------
    FullCells
        In the order of `Cells.in_full`. Points are numbered in its order, those in use alone, and
        triangles by their place among these.
    """
    pieces = cells.pieces
    is_wanted, n_triangle = np.append(wanted, False), len(pieces.triangles)  # the last: no face
    cut = np.searchsorted(pieces.surface, np.arange(len(pieces.sources) + 1))

    chosen = []
    for i, strips in enumerate(pieces.strips):
        rows = np.arange(cut[i], cut[i + 1])
        rows = rows[is_wanted[cells.face_of_element[rows]]]
        keys, of_run = _NONE, _NONE
        if strips is not None:
            first = int(pieces.first_run[i])
            all_runs = slice(n_triangle + first, n_triangle + first + len(strips.runs))
            some = np.flatnonzero(is_wanted[cells.face_of_element[all_runs]])
            keys, of_run = strips.keys_of(some)
            of_run = of_run + first
        chosen.append((rows, keys, of_run))

    listed = list_triangles(pieces, chosen)
    face = cells.face_of_element[listed.element]
    several = np.flatnonzero(np.isin(face, list(cells.also)))
    also = {i: cells.also[k] for i, k in zip(several.tolist(), face[several].tolist(), strict=True)}
    return FullCells(
        cells.surface_of[face], also, cells.cell_of_side[face], cells.n_cell, cells.patches,
        pieces, cells.face_of_element, listed.triangles, np.arange(len(face)), listed.x,
    )  # fmt: skip
