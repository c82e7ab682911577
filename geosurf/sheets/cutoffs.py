"""Cut-off lines of both walls after the exact cut, and throw and heave along the fault.

A cut-off line is where the sheet ends on the fault: edges of one kept triangle of the sheet that a
fault shares. Throw and heave are measured between the two lines in the dip direction of the fault
at each station of its trace: throw is positive where the hanging wall is down, heave where
there is a gap.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.lines import undirected_lines
from geosurf.sheets.cut import Cut
from geosurf.sheets.heights import Heights
from geosurf.sheets.mesh import Torn
from geosurf.sheets.traces import split_lines

LONGEST = 12.0  # cells from a station within which a cut-off is looked for


def fault_edges(cut: Cut, surface: int) -> tuple[np.ndarray, np.ndarray]:
    """Edges (n, 2) of kept sheet triangles that a fault shares, and their triangles (n,)."""
    t, n = cut.patches.triangles, len(cut.patches.local)
    of = cut.patches.surface_of_triangle

    def keyed(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """One number for each edge, whichever way it runs, and its triangle."""
        a, b = t[rows], np.roll(t[rows], -1, axis=1)
        return (np.minimum(a, b) * n + np.maximum(a, b)).ravel(), np.repeat(rows, 3)

    keys, triangle = keyed(np.flatnonzero((of == 0) & cut.keep))
    there, _ = keyed(np.flatnonzero(of == surface))
    shared = np.isin(keys, there)
    keys, triangle = keys[shared], triangle[shared]
    return np.stack(np.divmod(keys, n), axis=1), triangle


def cutoff_lines(
    cut: Cut, state: Heights, torn: Torn, fault: int, corners: np.ndarray
) -> dict[str, list[np.ndarray]]:
    """Cut-off lines (n, 3) of a fault by wall, world coordinates; "+" is the hanging wall.

    `corners` are those of the band's triangles, as vertices of `Torn`.
    """
    edges, triangle = fault_edges(cut, 1 + fault)
    parent = corners[cut.patches.parent_of_triangle[triangle]]
    real = torn.anchored(parent)
    # all corners of a parent are on sheets of one side, but where a tear has healed
    side = np.zeros(real.shape)
    nearest = np.full(real.shape, np.inf)
    for number, trace in enumerate(state.network.traces):
        if trace.fault != fault:
            continue
        near = state.near[number]
        at = near.look_up(real.ravel()).reshape(real.shape)
        close = (at >= 0) & (near.distance[at] < nearest)
        side = np.where(close, near.side[at] if len(near.side) else 0.0, side)
        nearest = np.where(close, near.distance[at] if len(near.side) else np.inf, nearest)
    found: dict[str, list[np.ndarray]] = {}
    key = edges[:, 0] * len(cut.patches.local) + edges[:, 1]
    _, inverse, times = np.unique(key, return_inverse=True, return_counts=True)
    both = times[inverse] > 1  # the sheet is whole there: both walls share the line
    total = side.sum(axis=1)
    for wall, sign in (("+", 1), ("-", -1)):
        mine = np.unique(edges[both | (np.sign(total) == sign)], axis=0)
        found[wall] = [cut.patches.vertices[line] for line in undirected_chains(mine)]
    return found


def undirected_chains(edges: np.ndarray) -> list[np.ndarray]:
    """Edges (n, 2) in any direction, each once -> lines, longest runs between ends and branches."""
    if len(edges) == 0:
        return []
    points, ends = np.unique(edges, return_inverse=True)
    ends = ends.reshape(-1, 2)
    here = np.concatenate([ends[:, 0], ends[:, 1]])
    beside = np.concatenate([ends[:, 1], ends[:, 0]])
    order = np.lexsort((beside, here))
    link = np.tile(np.arange(len(ends)), 2)[order]
    first = np.searchsorted(here[order], np.arange(len(points) + 1))
    ends_first = np.concatenate([np.flatnonzero(np.diff(first) != 2), np.arange(len(points))])
    return [
        points[line]
        for line in split_lines(undirected_lines(first, beside[order], link, ends_first))
    ]


def profile(
    stations: np.ndarray, direction: np.ndarray, walls: dict[str, list[np.ndarray]], reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Throw and heave (n,) [m] at stations (n, 2), along their dip directions; NaN where none."""
    at = {wall: _met(stations, direction, lines, reach) for wall, lines in walls.items()}
    (t_plus, z_plus), (t_minus, z_minus) = at["+"], at["-"]
    return z_minus - z_plus, t_plus - t_minus


def _met(stations, direction, lines, reach) -> tuple[np.ndarray, np.ndarray]:
    """Distance along the direction and elevation where the nearest line is met."""
    n = len(stations)
    where, height = np.full(n, np.nan), np.full(n, np.nan)
    pieces = [np.hstack([line[:-1], line[1:]]) for line in lines if len(line) > 1]
    if not pieces or n == 0:
        return where, height
    pieces = np.concatenate(pieces)
    row, piece = _pairs_within(stations, pieces, reach)
    d = direction[row]
    a, b = (pieces[piece, k : k + 2] - stations[row] for k in (0, 3))
    left_a = d[:, 0] * a[:, 1] - d[:, 1] * a[:, 0]
    left_b = d[:, 0] * b[:, 1] - d[:, 1] * b[:, 0]
    crosses = (left_a >= 0) != (left_b >= 0)
    row, piece, d, a, b = row[crosses], piece[crosses], d[crosses], a[crosses], b[crosses]
    f = left_a[crosses] / (left_a - left_b)[crosses]
    t = ((a + f[:, None] * (b - a)) * d).sum(axis=1)
    order = np.lexsort((piece, np.abs(t), row))
    order = order[np.abs(t[order]) <= reach]
    met, first = np.unique(row[order], return_index=True)
    best = order[first]
    where[met] = t[best]
    low, high = pieces[piece[best], 2], pieces[piece[best], 5]
    height[met] = low + f[best] * (high - low)
    return where, height


def _pairs_within(stations, pieces, reach) -> tuple[np.ndarray, np.ndarray]:
    """Stations and pieces that a line of length `reach` from the station may meet."""
    from scipy.spatial import cKDTree

    half = 0.5 * (pieces[:, 3:5] - pieces[:, :2])
    widest = float(np.hypot(*half.T).max())
    near = cKDTree(pieces[:, :2] + half).query_ball_point(stations, reach + widest)
    number = np.array([len(some) for some in near])
    return np.repeat(np.arange(len(near)), number), np.concatenate(near).astype(np.int64)
