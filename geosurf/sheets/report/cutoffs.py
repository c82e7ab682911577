"""Cut-off lines of both walls after the exact cut, and throw and heave along the fault.

A cut-off line is where the sheet ends on the fault: edges of one remaining triangle of the sheet
that a fault shares. Throw and heave are measured between the two lines in the dip direction of
the fault at each station of its trace: throw is positive where the hanging wall is down, heave
where there is a gap.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.sheets.link_lines import CHUNK, first_hits, undirected_lines
from geosurf.sheets.faults.traces import split_lines
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.mesh.cut import Cut
from geosurf.sheets.mesh.torn_mesh import Torn

LONGEST = 12.0  # cells from a station within which a cut-off is looked for, and
BESIDE = 2.0  # cells more than the widest wall is from its trace


def longest(state: Heights) -> float:
    """Cells from a station within which its cut-offs are."""
    widest = [np.abs([walls.left, walls.right]).max(initial=0.0) for walls in state.walls]
    return max(LONGEST, max(widest, default=0.0) + BESIDE)


def fault_edges(cut: Cut, fault: int) -> tuple[np.ndarray, np.ndarray]:
    """Edges (n, 2) of remaining sheet triangles that a fault shares, and their triangles (n,)."""
    # curve_sides[0] has the sheet, the others its faults; a key is two vertices of an edge
    keys, triangle = cut.curve_sides[0]
    mine = cut.keep[triangle]
    keys, triangle = keys[mine], triangle[mine]
    shared = is_among(keys, cut.curve_sides[1 + fault][0])
    keys, triangle = keys[shared], triangle[shared]
    return np.stack(np.divmod(keys, len(cut.patches.local)), axis=1), triangle


def cutoff_lines(cut: Cut, state: Heights, torn: Torn, fault: int) -> dict[str, list[np.ndarray]]:
    """Cut-off lines (n, 3) of a fault by wall, world coordinates; "+" is the hanging wall."""
    patches = cut.patches
    edges, triangle = fault_edges(cut, fault)

    # real (n_edge, 3): nodes on the wall of each edge's triangle, ghosts replaced by anchors
    parent = cut.corners[patches.parent_of_triangle[triangle]]
    real = torn.anchored(parent)
    # all corners of a parent are on sheets of one side, but where a tear has healed
    side = state.sides_of(fault, real)

    # an edge of both walls is found twice
    found: dict[str, list[np.ndarray]] = {}
    key = edges[:, 0] * len(patches.local) + edges[:, 1]
    _, inverse, times = np.unique(key, return_inverse=True, return_counts=True)
    both = times[inverse] > 1  # the sheet is whole there: both walls share the line
    total = side.sum(axis=1)
    for wall, sign in (("+", 1), ("-", -1)):
        # the majority of the three corners names the wall
        mine = distinct(key[both | (np.sign(total) == sign)])
        mine = np.stack(np.divmod(mine, len(patches.local)), axis=1)
        found[wall] = [patches.vertices[line] for line in undirected_chains(mine)]
    return found


def undirected_chains(edges: np.ndarray) -> list[np.ndarray]:
    """Edges (n, 2) in any direction, each once -> lines, longest runs between ends and branches."""
    if len(edges) == 0:
        return []

    # neighbours of each point, in rows from first[k] to first[k + 1]
    points, ends = np.unique(edges, return_inverse=True)
    ends = ends.reshape(-1, 2)
    here = np.concatenate([ends[:, 0], ends[:, 1]])
    beside = np.concatenate([ends[:, 1], ends[:, 0]])
    order = np.lexsort((beside, here))
    link = np.tile(np.arange(len(ends)), 2)[order]
    first = np.searchsorted(here[order], np.arange(len(points) + 1))

    # lines start at ends and branches; rings, which have neither, start anywhere
    ends_first = np.concatenate([np.flatnonzero(np.diff(first) != 2), np.arange(len(points))])
    return [
        points[line]
        for line in split_lines(undirected_lines(first, beside[order], link, ends_first))
    ]


def profile(
    stations: np.ndarray, direction: np.ndarray, walls: dict[str, list[np.ndarray]], reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Throw and heave (n,) [m] at stations (n, 2), along their dip directions; NaN where none."""
    # t: distance from the station along the dip direction; z: elevation, both of each wall
    at = {wall: met(stations, direction, lines, reach) for wall, lines in walls.items()}
    (t_plus, z_plus), (t_minus, z_minus) = at["+"], at["-"]
    return z_minus - z_plus, t_plus - t_minus


def met(
    stations: np.ndarray, direction: np.ndarray, lines: Sequence[np.ndarray], reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Distance along the direction and third coordinate (n,) where the nearest line is met."""
    n = len(stations)

    # pieces (n, 6): first and second end of each
    each = [np.hstack([line[:-1], line[1:]]) for line in lines if len(line) > 1]
    if not each or n == 0:
        return np.full(n, np.nan), np.full(n, np.nan)
    pieces = np.concatenate(each)

    # boxes in the map of runs of CHUNK pieces: most of them cannot be met
    first = np.arange(0, len(pieces), CHUNK)
    low = np.minimum.reduceat(np.minimum(pieces[:, :2], pieces[:, 3:5]), first)
    high = np.maximum.reduceat(np.maximum(pieces[:, :2], pieces[:, 3:5]), first)
    return first_hits(stations, direction, pieces, np.hstack([low, high]), reach)
