"""Fourth differences, for data that are met exactly: walls keep the change of their curvature.

A sheet with small third differences goes on with the curvature that it has at the last data. Throw
that dies away across the fault, too, changes its curvature over the nodes without data. With fourth
differences a sheet goes on with that change (order four in Wahba 1990, Spline Models for
Observational Data, ch. 2.4). Noise grows with each order, so this is for data without.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LINE = (1.0, -4.0, 6.0, -4.0, 1.0)
# binomials of the mixed ones: three steps one way and one the other, and two each way; the roots
# are those of how often each comes among all fourth derivatives
RAMP = tuple(2.0 * np.array([1.0, -3.0, 3.0, -1.0, -1.0, 3.0, -3.0, 1.0]))
SADDLE = tuple(np.sqrt(6.0) * np.array([1.0, -2.0, 1.0, -2.0, 4.0, -2.0, 1.0, -2.0, 1.0]))


@dataclass(frozen=True, eq=False)
class FourthDifferences:
    """All fourth differences on a graph: those with all nodes there and no cut link inside.

    Attributes
    ----------
    blocks : list of (ndarray of int64 (n, k), ndarray (k,))
        Nodes of the differences of one kind, and their weights.
    """

    blocks: list[tuple[np.ndarray, np.ndarray]]

    def gradient(self, heights: np.ndarray) -> np.ndarray:
        """Derivatives (n, k) of half the energy by heights (n, k)."""
        out = np.zeros_like(heights)
        for nodes, weights in self.blocks:
            left = sum(w * heights[at] for at, w in zip(nodes.T, weights, strict=True))
            for at, w in zip(nodes.T, weights, strict=True):
                for k in range(heights.shape[1]):
                    out[:, k] += np.bincount(at, w * left[:, k], len(heights))
        return out

    def of_unknown(self, number: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows over unknowns: row k has columns column[start[k] : start[k + 1]] and weights.

        `number` (n_node,) of each unknown, -1 for known nodes, which have no column.
        """
        counts, columns, weights = [], [], []
        for nodes, weight in self.blocks:
            at = number[nodes]
            some = at >= 0
            counts.append(some.sum(axis=1))
            columns.append(at[some])
            weights.append(np.broadcast_to(weight, at.shape)[some])
        start = np.concatenate([[0], np.cumsum(np.concatenate(counts))])
        return start, np.concatenate(columns), np.concatenate(weights)


def fourth_differences(
    to_east: np.ndarray, to_north: np.ndarray, square: np.ndarray, stretch: np.ndarray
) -> FourthDifferences:
    """All fourth differences of a graph.

    Parameters
    ----------
    to_east, to_north, square : ndarray (n,)
        As in `geosurf.sheets.lattice.solve.Graph`.
    stretch : ndarray (2,)
        Of its cells along columns and rows.
    """
    wx, wy = (1.0 / stretch).tolist()
    start = np.arange(len(to_east))
    found = []

    # straight ones, both ways
    east, north = (_steps(start, to, 4) for to in (to_east, to_north))
    for line, w in ((east, wx), (north, wy)):
        found.append((_whole(line), w**4 * np.array(LINE)))

    # mixed ones lie on whole blocks: `across` leads over the block north-east of a node
    one, two = _hop(to_north, east[1]), _hop(to_east, north[1])
    across = np.where(square & (one == two), one, -1)
    for line, w in ((east, wx**3 * wy), (north, wx * wy**3)):
        other = north if line is east else east
        beyond = [other[1], *(_hop(across, at) for at in line[:3])]
        found.append((_whole([*line[:4], *beyond]), w * np.array(RAMP)))
    upper = [north[1], across, _hop(across, east[1])]
    top = [north[2], _hop(across, north[1]), _hop(across, across)]
    saddle = _whole([*east[:3], *upper, *top])
    found.append((saddle, (wx * wy) ** 2 * np.array(SADDLE)))
    return FourthDifferences(found)


def _steps(start: np.ndarray, to: np.ndarray, n: int) -> list[np.ndarray]:
    """Nodes after 0 to n steps along links, -1 where there is none."""
    found = [start]
    for _ in range(n):
        found.append(_hop(to, found[-1]))
    return found


def _hop(to: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """The node that each leads to, -1 from none."""
    return np.where(nodes >= 0, to[nodes], -1)


def _whole(nodes: Sequence[np.ndarray]) -> np.ndarray:
    """Nodes (n, k) of the differences that exist."""
    every = np.stack(nodes, axis=1)
    return every[(every >= 0).all(axis=1)]
