"""Find curves of smooth surfaces that their triangles miss, and trace or report them."""

from __future__ import annotations

from typing import Any

import numpy as np

from geosurf.intersect.lift import NOISE, doubt_along
from geosurf.intersect.sides import Candidates, Side
from geosurf.intersect.strand import Line
from geosurf.kernels.smooth.coverage import NEAR_SEED, SEED, TOO_CLOSE, check_pairs, keys_of
from geosurf.kernels.smooth.lift import LIFTED, lift_points
from geosurf.kernels.smooth.resample import SAFETY
from geosurf.kernels.smooth.trace import CLOSED, LOST, distances_to_segments, trace_curve

Found = tuple[str, np.ndarray, float]  # reason, points, error


def pair_keys(sides: tuple[Side, Side], w: np.ndarray, tri: np.ndarray) -> np.ndarray:
    """Numbers of the pairs of cells in which parameters lie."""
    return keys_of(sides[0].z, sides[1].z, w, tri)


def find_lost(
    sides: tuple[Side, Side],
    near: Candidates,
    lines: list[Line],
    keys: np.ndarray,
    tolerance: float,
) -> tuple[list[Line], list[Found]]:
    """Curves that none of the lines is, and places where there may be one.

    Parameters
    ----------
    sides : (Side, Side)
    near : Candidates
        All pairs of patches that may touch.
    lines : list of Line
        The curves that are known.
    keys : ndarray of int64
        Pairs of cells that they run through (`pair_keys`).
    tolerance : float
        [m]

    Returns
    -------
    lines, places
    """
    # Patches with undefined nodes in their stencil have no cubic to check.
    one, two = sides
    whole = (near.whole[0][near.pairs[:, 0]] == 1) & (near.whole[1][near.pairs[:, 1]] == 1)
    arrays = (one.x, one.y, one.z, two.x, two.y, two.z, two.c)

    # Rows (kind, triangle, 4 parameters, x, y, z): pairs that may hold a curve of their own.
    rows = check_pairs(
        *arrays, near.pairs[whole], *near.cells, *near.nets, *near.cones, np.unique(keys)
    )
    if len(rows) == 0:
        return [], []

    # Seeds next to a known curve belong to it; what is not decided needs more distance.
    reach = near.size
    ends = _segments(lines)
    away = distances_to_segments(rows[:, 6:9], *ends)
    seeds = rows[np.isin(rows[:, 0], (SEED, NEAR_SEED)) & (away > 4 * tolerance)]
    unclear = rows[~np.isin(rows[:, 0], (SEED, NEAR_SEED)) & (away > reach / 8)]

    found, noisy = _trace_all(arrays, two, seeds, 0.25 * reach, tolerance)
    places: list[Found] = []
    if noisy:
        points, errors = zip(*noisy, strict=True)
        places.append(("noise", np.concatenate(points), max(errors)))

    # New curves explain what lies next to them, too.
    if len(unclear) and found:
        unclear = unclear[distances_to_segments(unclear[:, 6:9], *_segments(found)) > reach / 8]

    # What remains is reported: bounds that cannot tell, or surfaces (nearly) tangent.
    for reason, kind in (("touching", False), ("tangency", True)):
        points = unclear[(unclear[:, 0] == TOO_CLOSE) == kind, 6:9]
        if len(points):
            places.append((reason, points, np.inf if kind else reach / 32))
    return found, places


def _segments(lines: list[Line]) -> tuple[np.ndarray, np.ndarray]:
    """Both ends of all segments."""
    none = [np.empty((0, 3))]
    return (
        np.concatenate(none + [line.points[:-1] for line in lines]),
        np.concatenate(none + [line.points[1:] for line in lines]),
    )


def _trace_all(
    arrays: tuple[Any, ...], two: Side, seeds: np.ndarray, step: float, tolerance: float
) -> tuple[list[Line], list[tuple[np.ndarray, float]]]:
    """Trace from one seed after the other; seeds on a traced curve are done."""
    beside = _beside(two)

    found: list[Line] = []
    noisy: list[tuple[np.ndarray, float]] = []
    while len(seeds):
        line = _trace(arrays, beside, seeds[0], step, tolerance)
        # Data noise gives an error in place of a line.
        if isinstance(line, float):
            noisy.append((seeds[:1, 6:9], line))
            seeds = seeds[1:]
            continue

        # Other seeds of the same curve are done; the seed itself is, whatever its distance.
        found.append(line)
        away = distances_to_segments(seeds[:, 6:9], *_segments([line]))
        away[0] = 0.0
        seeds = seeds[away > 4 * tolerance]
    return found, noisy


def _trace(
    arrays: tuple[Any, ...], beside: np.ndarray, seed: np.ndarray, step: float, tolerance: float
) -> Line | float:
    """The curve through a seed; where the data are noise, only the error that they make."""
    tri = int(seed[1])

    # A row starts with the place and its four parameters; errors of chords leave room for cubics.
    start = np.concatenate([seed[6:9], seed[2:6]])
    target = 0.75 * tolerance / SAFETY
    rows, ending = trace_curve(*arrays, beside, start, tri, 1.0, step, target)
    endings = [ending]
    # An open curve is traced both ways; the half traced backwards is turned, without the seed.
    if ending != CLOSED:
        back, ending = trace_curve(*arrays, beside, start, tri, -1.0, step, target)
        endings.append(ending)
        rows = np.concatenate([back[:0:-1], rows])

    if len(rows) < 2:
        return Line(start[None, :3], False, np.inf, [("tangency", start[None, :3], np.inf)])
    status, doubt = _doubts(arrays, rows, tolerance)
    if (status == NOISE).any():
        return float(doubt.max())

    # An unlimited bound wherever a part was not followed or not lifted.
    bound = float(rows[:, 7].max() + doubt.max()) if (status == LIFTED).all() else np.inf
    places: list[Found] = []
    if LOST in endings or np.isinf(bound):
        bound = np.inf
        places.append(("tangency", rows[[0, -1], :3], np.inf))
    elif doubt.max() > tolerance:
        places.append(("interpolation", rows[:, :3], float(doubt.max())))
    closed = endings[0] == CLOSED
    return Line(rows[:, :3], closed, bound, places)


def _doubts(
    arrays: tuple[Any, ...], rows: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """How far cubics can be trusted along traced rows."""
    n = len(rows)
    p, tangents, doubts = np.empty((n, 3)), np.zeros((n, 4)), np.zeros((n, 6))
    status = lift_points(
        *arrays, rows[:, 8].astype(np.int64), np.zeros(n, dtype=np.int64), rows[:, :3],
        rows[:, 3:7].copy(), p, tangents, doubts,
    )  # fmt: skip
    return status, doubt_along(doubts, tangents[:, 3], status, tolerance)


def _beside(side: Side) -> np.ndarray:
    """The triangle across each side (corners 0-1, 1-2, 2-0) of each triangle; -1: none."""
    if side.smooth:
        return np.full((1, 3), -1, dtype=np.int64)
    t = side.surface.triangles

    # Each side of each triangle as a sorted pair of corners; equal pairs are one edge.
    ends = np.sort(np.stack([t, np.roll(t, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    _, edge, times = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    edge = edge.ravel()

    # Rows of sides by edge: the two sides of an inner edge follow each other.
    order = np.argsort(edge, kind="stable")
    beside = np.full(len(edge), -1, dtype=np.int64)
    first = np.cumsum(times) - times

    # Only edges of exactly two triangles have one across; the row over 3 is the triangle.
    two = first[times == 2]
    beside[order[two]] = order[two + 1] // 3
    beside[order[two + 1]] = order[two] // 3
    return beside.reshape(-1, 3)
