"""Differences of the energy (Briggs 1974): nodes, weights and links of each kind, on one lattice.

`geosurf.kernels.sheets.smooth_surface` has them compiled, for nodes whose links are not cut. This
table is for those that reach across a trace (`geosurf.sheets.heights.relief`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

Node = tuple[int, int]  # column, row: offsets from the first node of a difference
Link = tuple[int, int, int]  # column, row, kind
# nodes, weights, links that it crosses, derivatives along columns and rows, order
Difference = tuple[tuple[Node, ...], tuple[float, ...], tuple[Link, ...], tuple[int, int], int]

# all links of a cell with its diagonals, and those of the cell east of it
CELL = ((0, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 0, 2), (0, 0, 3))
NEXT = tuple((j + 1, i, kind) for j, i, kind in CELL)


def _turned(
    nodes: Sequence[Node], links: Sequence[Link]
) -> tuple[tuple[Node, ...], tuple[Link, ...]]:
    """A difference the other way: rows for columns."""
    # east and north links change places; diagonals stay what they are
    turn = (1, 0, 2, 3)
    return tuple((j, i) for i, j in nodes), tuple((j, i, turn[k]) for i, j, k in links)


def _differences() -> list[Difference]:
    """Nodes, weights, links, powers of both ways, order: all second and third differences."""
    found: list[Difference] = []
    # along columns, then along rows
    for order, weights in ((2, (1.0, -2.0, 1.0)), (3, (-1.0, 3.0, -3.0, 1.0))):
        nodes = tuple((k, 0) for k in range(order + 1))
        links = tuple((k, 0, 0) for k in range(order))
        found.append((nodes, weights, links, (order, 0), order))
        nodes, links = _turned(nodes, links)
        found.append((nodes, weights, links, (0, order), order))

    # the twist, twice in the energy of a plate: once for each order of the derivatives
    block = ((0, 0), (1, 0), (0, 1), (1, 1))
    twist = tuple(np.sqrt(2.0) * np.array([1.0, -1.0, -1.0, 1.0]))
    found.append((block, twist, CELL, (1, 1), 2))

    # mixed third differences, which come three times
    nodes = tuple((k, i) for i in range(2) for k in range(3))
    ramp = tuple(np.sqrt(3.0) * np.array([1.0, -2.0, 1.0, -1.0, 2.0, -1.0]))
    found.append((nodes, ramp, CELL + NEXT, (2, 1), 3))
    nodes, links = _turned(nodes, CELL + NEXT)
    found.append((nodes, ramp, links, (1, 2), 3))
    return found


DIFFERENCES = _differences()
