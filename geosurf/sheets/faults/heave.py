"""Where the cut-offs of both walls of a fault lie: how wide the gap, or the overlap, along a trace.

They are read off the heights of each side at the links that the trace cuts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from geosurf.sheets.faults.cut_edges import RISING, Cuts
from geosurf.sheets.faults.fault_distance import NearTrace
from geosurf.sheets.faults.traces import Trace
from geosurf.sheets.lattice.frame import Frame


@dataclass(eq=False)
class Walls:
    """Along one trace: how far each wall's cut-off lies from it, into its own side [cells].

    `place` (vertex numbers); `left` and `right`, positive where the horizon has a gap on that
    side, negative where it overlaps the trace; `throw` [m], left side down positive.
    """

    place: np.ndarray
    left: np.ndarray
    right: np.ndarray
    throw: np.ndarray

    def gap(self, place: np.ndarray, side: np.ndarray) -> np.ndarray:
        """Signed gap at places on one side or the other."""
        if len(self.place) == 0:
            return np.zeros(len(place))
        left = np.interp(place, self.place, self.left)
        return np.where(side > 0, left, np.interp(place, self.place, self.right))

    def heave(self, place: np.ndarray) -> np.ndarray:
        """Gap of both sides together: negative where the horizon overlaps."""
        return self.gap(place, np.ones(len(place))) + self.gap(place, -np.ones(len(place)))


def walls_of(
    heights: np.ndarray, every: Cuts, traces: Sequence[Trace], frame: Frame
) -> list[Walls]:
    """Where the two walls' cut-offs lie, from the heights of each side at the cut links."""
    shape, stretch, cell = frame.shape, frame.stretch, frame.cell
    bits = every.bits(len(heights))
    found = []
    for number, trace in enumerate(traces):
        rows = np.flatnonzero((every.trace == number) & (every.kind < RISING))
        cuts = every.take(rows[np.argsort(every.place[rows], kind="stable")])
        vertex = np.arange(len(trace.line))

        # at each cut link: place [cells], height of the trace [m], normal of the fault
        x, y, middle, nx, ny, nz = (np.interp(cuts.place, vertex, c) for c in trace.line.T)
        at = np.stack([x, y], axis=1) / stretch

        # height of both sheets where the trace cuts each link [m]
        left, right = (_at_cut(heights, bits, cuts, at, shape, side) for side in (1, -1))

        # a running median of 15 links: single links next to a contact or a tip do not count
        known = np.isfinite(left) & np.isfinite(right)
        left, right = _median(left[known], 15), _median(right[known], 15)

        # distance across strike = height above the trace times the slope [cells per m]
        slope = (nz / np.maximum(np.hypot(nx, ny), 1e-9) / cell)[known]
        left_gap, right_gap = (middle[known] - left) * slope, (right - middle[known]) * slope
        found.append(Walls(cuts.place[known], left_gap, right_gap, right - left))
    return found


def _at_cut(
    heights: np.ndarray,
    bits: np.ndarray,
    cuts: Cuts,
    at: np.ndarray,
    shape: tuple[int, int],
    side: int,
) -> np.ndarray:
    """Height of one side's sheet where a trace cuts each link, extrapolated along the link."""
    n_col = shape[1]
    first, second = cuts.ends(n_col)

    # here: the end of the link on the asked side, there: its other end, across the fault
    here = np.where(cuts.left == side, first, second)
    there = np.where(cuts.left == side, second, first)

    # extrapolate along the link, unless it is cut behind, too
    behind = 2 * here - there
    row, col = np.divmod(here, n_col)
    row2, col2 = np.divmod(np.clip(behind, 0, len(heights) - 1), n_col)

    # behind is one link further on the same row or column; at the border it may not be a node
    whole = (behind >= 0) & (behind < len(heights)) & (abs(row2 - row) + abs(col2 - col) == 1)
    behind = np.where(whole, behind, here)
    whole &= bits[np.minimum(here, behind)] & (1 << cuts.kind) == 0
    away = np.hypot(*(at - np.stack([col, row], axis=1)).T)
    return np.where(whole, heights[here] + away * (heights[here] - heights[behind]), np.nan)


def _median(values: np.ndarray, width: int) -> np.ndarray:
    """Running median; beyond the ends the last value goes on, so that throw may die there."""
    n = len(values)
    if n == 0:
        return values
    half = min(width // 2, (n - 1) // 2)
    windows = sliding_window_view(np.pad(values, half, mode="edge"), 2 * half + 1)
    found: np.ndarray = np.partition(windows, half, axis=1)[:, half]
    return found


def throw_beside(heights: np.ndarray, near: NearTrace, block: np.ndarray) -> float:
    """Size of a fault's throw next to some nodes, from the data on its two sides [m]."""
    at = near.look_up(block)

    # 20 vertices more to both sides, and data within six cells: enough for a median
    places = near.place[at[at >= 0]]
    if len(places) == 0:
        return np.inf
    low, high = places.min() - 20.0, places.max() + 20.0
    beside = near.within(6.0)
    beside = beside[(near.place[beside] >= low) & (near.place[beside] <= high)]
    beside = beside[np.isfinite(heights[near.node[beside]])]
    sides = [heights[near.node[beside[near.side[beside] == side]]] for side in (1.0, -1.0)]
    if not len(sides[0]) or not len(sides[1]):
        return np.inf
    return float(abs(np.median(sides[0]) - np.median(sides[1])))
