"""A number for each lattice node that was asked for, in square tiles of nodes.

Node = row * n_col + column. A sorted list costs a binary search for each node: 0.2 us, a fifth of
the tear of a large field. A tile costs a division.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

SIDE = 16  # nodes along a tile
NOT_ASKED = -2  # in place of the number of a node that was never put
NO_NODE = -1


@scalar
def _place(node, n_col):
    """Number of the tile of a node in the lattice of tiles, and of the node in its tile."""
    row = node // n_col
    col = node - row * n_col
    tiles = (n_col + SIDE - 1) // SIDE
    return row // SIDE * tiles + col // SIDE, row % SIDE * SIDE + col % SIDE


@entry("l1 l l1 l1 -> l1 l")
def numbers_of_nodes(nodes, n_col, tile_of, numbers):
    """Numbers of nodes, -1 for nodes below 0, -2 for nodes that were not put; how many are -2.

    Tile t of the lattice has the numbers from ``tile_of[t] * SIDE * SIDE`` on, -1: none yet.
    """
    found = np.empty(nodes.shape[0], dtype=np.int64)
    n_new = 0
    for k in range(nodes.shape[0]):
        if nodes[k] < 0:
            found[k] = NO_NODE
            continue
        tile, inside = _place(nodes[k], n_col)
        first = tile_of[tile]
        found[k] = NOT_ASKED if first < 0 else numbers[first * SIDE * SIDE + inside]
        n_new += found[k] == NOT_ASKED
    return found, n_new


@entry("l1 l l1* l -> l")
def open_tiles(nodes, n_col, tile_of, n_tile):
    """Number the tiles of nodes that have none in `tile_of`, from `n_tile` on; how many now."""
    for k in range(nodes.shape[0]):
        tile, _ = _place(nodes[k], n_col)
        if tile_of[tile] < 0:
            tile_of[tile] = n_tile
            n_tile += 1
    return n_tile


@entry("l1 l1 l l1 l1* -> .")
def put_numbers(nodes, values, n_col, tile_of, numbers):
    """Write the numbers of nodes into their tiles."""
    for k in range(nodes.shape[0]):
        tile, inside = _place(nodes[k], n_col)
        numbers[tile_of[tile] * SIDE * SIDE + inside] = values[k]
