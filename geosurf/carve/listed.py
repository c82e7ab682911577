"""List the triangles of some faces, numbered in the order of all triangles of the model."""

from __future__ import annotations

import numpy as np

from geosurf.carve.cells import Cells, FullCells
from geosurf.errors import GeometryError
from geosurf.kernels.lattices.strips import FIRST, LAST, ROW
from geosurf.model import Lattice
from geosurf.model.chunked import ChunkedLattice

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

    # points: corners of listed triangles, then nodes of each lattice
    first_node = [len(pieces.x)]
    corners, faces = [np.empty((0, 3), dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        rows = np.arange(cut[i], cut[i + 1])
        rows = rows[is_wanted[cells.face_of_element[rows]]]
        ids, keys, of = pieces.triangles[rows], pieces.key[rows], cells.face_of_element[rows]
        lattice = source.lattice
        first_node.append(first_node[-1])
        if strips is not None:
            assert lattice is not None  # only lattices have strips
            first = n_triangle + pieces.first_run[i]
            of_run = cells.face_of_element[first : first + len(strips.runs)]
            some = np.flatnonzero(is_wanted[of_run])
            runs = strips.runs[some]
            n = runs[:, LAST] - runs[:, FIRST] + 1
            if isinstance(lattice, ChunkedLattice) and int(n.sum()) > MOST:
                raise GeometryError(
                    f"horizon {source.name!r} crosses others so often that {int(n.sum())} of its "
                    "triangles are clipped, too many to list from its store. Take every tenth "
                    "node first: da[::10, ::10]."
                )

            # nodes that triangles use as well have the numbers of these
            more = _keys_of_runs(lattice, runs, n)
            nodes = lattice.corners_of_keys(more)
            at = np.minimum(np.searchsorted(strips.nodes, nodes), max(len(strips.nodes) - 1, 0))
            if len(strips.nodes):
                points, known = strips.points[at], strips.nodes[at] == nodes
                nodes = np.where(known, points, nodes + first_node[i])
            else:
                nodes = nodes + first_node[i]
            ids, keys = np.concatenate([ids, nodes]), np.concatenate([keys, more])
            of = np.concatenate([of, np.repeat(of_run[some], n)])
            first_node[-1] += lattice.n_node
            order = np.argsort(keys, kind="stable")  # pieces of one triangle keep their order
            ids, of = ids[order], of[order]
        corners.append(ids)
        faces.append(of)

    face = np.concatenate(faces)
    used, triangles = np.unique(np.concatenate(corners), return_inverse=True)
    x = np.empty((len(used), 3))
    ends = np.searchsorted(used, first_node)
    x[: ends[0]] = pieces.x[used[: ends[0]]]
    for i, source in enumerate(pieces.sources):
        mine = slice(ends[i], ends[i + 1])
        if ends[i] < ends[i + 1]:
            x[mine] = source.places_of_nodes(used[mine] - first_node[i]) - pieces.origin

    several = np.flatnonzero(np.isin(face, list(cells.also)))
    also = {i: cells.also[k] for i, k in zip(several.tolist(), face[several].tolist(), strict=True)}
    return FullCells(
        cells.surface_of[face], also, cells.cell_of_side[face], cells.n_cell, cells.patches,
        pieces, cells.face_of_element, triangles.reshape(-1, 3), np.arange(len(face)), x,
    )  # fmt: skip


def _keys_of_runs(lattice: Lattice, runs: np.ndarray, n: np.ndarray) -> np.ndarray:
    """Keys of the triangles of runs with so many each: see `geosurf.kernels.lattices.strips`."""
    start = np.cumsum(n) - n
    place = np.arange(int(n.sum())) + np.repeat(runs[:, FIRST] - start, n)
    half = 1 - (place & 1) if lattice.rising else place & 1
    keys: np.ndarray = (
        2 * (np.repeat(runs[:, ROW], n) * (lattice.shape[1] - 1) + (place >> 1)) + half
    )
    return keys


__all__ = ["list_faces"]
