"""The horizon filled across its faults without any tear, and which absent nodes may be filled."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.sheets.node_bands import dilate_nodes
from geosurf.sheets.lattice.solve import Graph, grounded, lattice_graph, smoothest


def around(nodes: np.ndarray, shape: tuple[int, int], steps: int) -> np.ndarray:
    """Nodes within some steps, rows and columns, of given ones; increasing."""
    return dilate_nodes(distinct(nodes), *shape, steps)


def narrow_gaps(present: np.ndarray, width: float) -> np.ndarray:
    """Absent nodes in gaps and holes up to `width` cells across, bool like `present` (2-D)."""
    if present.all():
        return np.zeros_like(present)
    from scipy.ndimage import distance_transform_edt

    # a closing with a disk: absent nodes into which no disk of that width fits between data
    r = int(np.ceil(0.5 * width)) + 1
    reached = distance_transform_edt(~np.pad(present, r)) <= 0.5 * width
    # nodes outside the lattice count as reached, so that a gap may run out of it
    inner = np.zeros_like(reached)
    inner[r:-r, r:-r] = True
    closed = distance_transform_edt(reached | ~inner) > 0.5 * width
    return closed[r:-r, r:-r] & ~present


def draped(
    heights: np.ndarray, fill: np.ndarray, shape: tuple[int, int], stretch: np.ndarray
) -> np.ndarray:
    """Heights (n,) of the nodes of `fill` on a membrane through the others; NaN where none is."""
    # first differences reach one node: a rim of one holds the fill
    band = around(fill, shape, 1)
    graph = lattice_graph(band, shape)
    unknown = np.full(len(band), -1)
    at = np.searchsorted(band, fill)
    unknown[at] = np.arange(len(fill))
    value = heights[band]

    # nodes that no link ties to a height stay NaN
    graph = without_absent(graph, np.isfinite(value) | (unknown >= 0))
    tied = grounded(graph, unknown)
    keep = np.full(len(band), -1)
    keep[at[tied]] = np.arange(tied.sum())
    graph = without_absent(graph, np.isfinite(value) & (unknown < 0) | (keep >= 0))

    # only first differences count: a membrane, which never overshoots
    value = np.where(np.isfinite(value), value, 0.0)
    out = np.full(len(fill), np.nan)
    out[tied] = smoothest(graph, keep, value, stretch, bend=0.0, third=0.0)
    return out


def without_absent(graph: Graph, present: np.ndarray) -> Graph:
    """The graph without nodes that do not exist."""
    # a link needs both of its nodes
    east, north = (
        np.where(present & (to >= 0) & present[to], to, -1) for to in (graph.east, graph.north)
    )
    return Graph(east, north, graph.square & present, graph.cell)
