"""The triangles of a band, apart by the faults that can meet them: what is cut by itself.

Faults that are far from one another cut a sheet in places that have nothing in common. Each of
them is cut alone, several at a time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.sheets.faults.fault_distance import Blocks
from geosurf.sheets.lattice.frame import Frame

TILE = 3  # 2**3 nodes each way: what is in one tile or in neighbouring ones hangs together
LEAST = 10_000  # triangles: a smaller island is cut with the next one


def islands(
    nodes: np.ndarray, faces: np.ndarray, frame: Frame, blocks: Sequence[Blocks]
) -> list[tuple[np.ndarray, list[int]]]:
    """Rows of the triangles of each island, and its faults; each row and each fault in one.

    Parameters
    ----------
    nodes : ndarray of int64 (n_vertex,)
        Lattice node under each vertex of the band.
    faces : ndarray of int64 (n, 3)
        Triangles of the band, of neighbouring nodes.
    blocks : sequence of Blocks
        Of each fault; where they hold nothing, it meets no triangle.
    """
    # threads cost more than they save for one fault, one island, or few triangles
    count, island = _tiled(nodes, frame.shape)
    if count < 2 or len(blocks) < 2 or len(faces) < 2 * LEAST:
        return [(np.arange(len(faces)), list(range(len(blocks))))]
    # Tiles are joined by the faults that come near them, whatever lies between.
    places = frame.cells_of_node(nodes)
    joined, first = np.arange(count), []  # a fault joins all islands that it comes near
    for of in blocks:
        met = distinct(joined[island[of.of(places)[0]]])
        met = met if len(met) else joined[:1]  # one that is near none has to be somewhere
        joined[is_among(joined, met)] = met[0]
        first.append(met[0])

    # number islands in the order of their first triangle: which does not depend on the labels
    home = joined[island[faces[:, 0]]]
    number, n = _numbered(home, count)
    of_face, of_fault = number[home], number[joined[first]]
    return [
        (np.flatnonzero(of_face == k), np.flatnonzero(of_fault == k).tolist()) for k in range(n)
    ]


def _numbered(of_face: np.ndarray, count: int) -> tuple[np.ndarray, int]:
    """Numbers (count,) of islands by their first triangle, small ones with the next; how many."""
    size = np.bincount(of_face, minlength=count)
    names, first = np.unique(of_face, return_index=True)
    number = np.zeros(count, dtype=np.int64)
    held, last = 0, 0
    for name in names[np.argsort(first)].tolist():
        # the one before is large enough: start another
        if held >= LEAST:
            held, last = 0, last + 1
        number[name] = last
        held += int(size[name])
    return number, last + 1


def _tiled(nodes: np.ndarray, shape: tuple[int, int]) -> tuple[int, np.ndarray]:
    """Number of islands of tiles, and that of each node."""
    from scipy.ndimage import label

    # tiles of 2**TILE nodes; those that touch, also at a corner, are one island
    row, col = np.divmod(nodes, shape[1])
    row, col = row >> TILE, col >> TILE
    tiles = np.zeros(((shape[0] >> TILE) + 1, (shape[1] >> TILE) + 1), dtype=bool)
    tiles[row, col] = True
    island, count = label(tiles, np.ones((3, 3)))
    return int(count), island[row, col].astype(np.int64) - 1
