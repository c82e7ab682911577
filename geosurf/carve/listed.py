"""List the triangles of some faces, numbered in the order of all triangles of the model."""

from __future__ import annotations

import numpy as np

from geosurf.carve.cells import Cells, FullCells
from geosurf.errors import GeometryError
from geosurf.kernels.lattices.strips import FIRST, LAST
from geosurf.model.chunked import ChunkedLattice
from geosurf.model.excerpt import list_triangles

_NONE = np.empty(0, dtype=np.int64)
MOST = 1 << 26  # triangles of grids that stay in their store, 6 GB


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

    Raises
    ------
    GeometryError
        If grids that stay in their store would be listed, and memory might not hold them.
    """
    pieces = cells.pieces
    is_wanted, n_triangle = np.append(wanted, False), len(pieces.triangles)  # the last: no face
    cut = np.searchsorted(pieces.surface, np.arange(len(pieces.sources) + 1))

    chosen = []
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        rows = np.arange(cut[i], cut[i + 1])
        rows = rows[is_wanted[cells.face_of_element[rows]]]
        keys, of_run = _NONE, _NONE
        if strips is not None:
            lattice = source.lattice
            assert lattice is not None  # only lattices have strips
            first = int(pieces.first_run[i])
            all_runs = slice(n_triangle + first, n_triangle + first + len(strips.runs))
            some = np.flatnonzero(is_wanted[cells.face_of_element[all_runs]])
            runs = strips.runs[some]
            n = int((runs[:, LAST] - runs[:, FIRST] + 1).sum())
            if isinstance(lattice, ChunkedLattice) and n > MOST:
                raise GeometryError(
                    f"horizon {source.name!r} crosses others so often that {n} of its "
                    "triangles are clipped, too many to list from its store. Take every tenth "
                    "node first: da[::10, ::10]."
                )
            keys, of_run = strips.keys_of(some)
            of_run = of_run + first
        chosen.append((rows, keys, of_run))

    listed = list_triangles(pieces, chosen)
    face = cells.face_of_element[listed.element]
    several = np.flatnonzero(np.isin(face, list(cells.also)))
    also = {i: cells.also[k] for i, k in zip(several.tolist(), face[several].tolist(), strict=True)}
    return FullCells(
        cells.surface_of[face], also, cells.cell_of_side[face], cells.n_cell, cells.patches,
        pieces, cells.face_of_element, cells.sums, listed.triangles, np.arange(len(face)), listed.x,
    )  # fmt: skip


__all__ = ["list_faces"]
