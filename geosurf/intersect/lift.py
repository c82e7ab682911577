"""Lift plain curves of two surfaces onto the cubic surfaces through their lattices.

The plain curve gives ends, closure and neighbourhood; Newton's method moves its points, and
resampling brings chords within the tolerance. How far cubics can be trusted is estimated from
the data (`doubt_along`); where they cannot, the plain curve stays and a `CurveIssue` reports it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.intersect.sides import Side
from geosurf.intersect.strand import Line, Strand
from geosurf.kernels.smooth.error_estimate import errors_along
from geosurf.kernels.smooth.lift import (
    ASTRAY,
    HOLE,
    LIFTED,
    OUTSIDE,
    drop_reversals,
    lift_points,
)
from geosurf.kernels.smooth.resample import SAFETY, resample_runs

REASONS = {ASTRAY: "tangency", HOLE: "hole", OUTSIDE: "rim"}
NOISE, DROPPED, OVERLAP = 10, 11, 12


def lift_strand(
    strand: Strand, sides: tuple[Side, Side], tolerance: float
) -> tuple[list[Line], np.ndarray]:
    """Curves of the smooth sides in place of plain ones, and parameters of the lifted points."""
    one, two = sides
    n = len(strand.start)

    # `p`: lifted points; `w`: their parameters; `doubts`, `tangents`: figures for the error
    # estimate.
    w, p = strand.w.copy(), strand.start.copy()
    tangents, doubts = np.zeros((n, 4)), np.zeros((n, 6))
    arrays = (one.x, one.y, one.z, two.x, two.y, two.z, two.c)
    status = lift_points(*arrays, strand.tri, strand.hold, strand.start, w, p, tangents, doubts)

    # A point that leaves its cell by more than two others has converged to another curve.
    smooth = [0, 1, 2, 3] if two.smooth else [0, 1]
    wandered = (np.abs(w - strand.w)[:, smooth] > 2).any(axis=1)
    status[(status == LIFTED) & wandered] = ASTRAY

    # Points beyond the rim are left out, unless the curve would lose its end.
    status[(status == OUTSIDE) & (strand.must == 0)] = DROPPED
    status[strand.hold < 0] = OVERLAP

    error = np.zeros(n)
    spans = list(pairwise(strand.offsets.tolist()))
    loops = [(a, b - 1) for a, b in spans if (strand.start[a] == strand.start[b - 1]).all()]
    for a, b in loops:  # one point, twice
        p[b] = p[a]
        if two.smooth:
            w[b] = w[a]

    # The estimate of one point uses its neighbours, so curves are treated one by one.
    for a, b in spans:
        error[a:b] = doubt_along(doubts[a:b], tangents[a:b, 3], status[a:b], tolerance)

    drop_reversals(strand.start, p, tangents, strand.must, strand.offsets, status, DROPPED)
    for a, b in loops:
        status[b] = status[a] = max(status[a], status[b])

    # where the plain curve stays, it is as far away as the lifted one would have moved
    stays = status == NOISE
    error[stays] += np.linalg.norm(p - strand.start, axis=1)[stays]
    return _lines(strand, sides, arrays, p, w, status, error, tolerance), w


def doubt_along(
    doubts: np.ndarray, sine: np.ndarray, status: np.ndarray, tolerance: float
) -> np.ndarray:
    """Estimated distance [m] of the cubics' curve from the true one
    (`geosurf.kernels.smooth.error_estimate`).

    Marks noise in `status`: more than half the tolerance.
    """
    lifted = np.flatnonzero(status == LIFTED)
    total = np.zeros(len(status))
    rows = np.column_stack([doubts[lifted], sine[lifted]])
    total[lifted], rough = errors_along(rows)
    status[lifted[rough > 0.5 * tolerance]] = NOISE
    return total


def _lines(
    strand: Strand,
    sides: Sequence[Side],
    arrays: tuple[Any, ...],
    p: np.ndarray,
    w: np.ndarray,
    status: np.ndarray,
    error: np.ndarray,
    tolerance: float,
) -> list[Line]:
    """Resample all lifted runs in one go, and put the curves together."""
    # Cut all curves to runs of lifted rows and the plain rows between them.
    runs, places_of_curve, parts_of_curve = [], [], []
    for a, b in zip(strand.offsets[:-1], strand.offsets[1:], strict=True):
        closed = bool((strand.start[a] == strand.start[b - 1]).all())
        parts, places = _parts(strand, sides[1].smooth, status, a, b, closed)
        parts_of_curve.append(parts)
        places_of_curve.append(places)
        runs += [rows for kind, rows in parts if kind == "run"]

    # Resample each run to what the tolerance leaves after the error of the cubics themselves.
    rows, spans, tri = _rows_of_runs(runs, sides[1], strand, p, w)
    worst = np.array([error[run].max() for run in runs])
    target = np.maximum(tolerance - worst, 0.25 * tolerance) / SAFETY
    out, offsets = resample_runs(*arrays, rows, spans, tri, target)

    # Put the parts of each curve together again: columns 0-2 are the point, 7 the chord's error.
    lines, k = [], 0
    for parts, places in zip(parts_of_curve, places_of_curve, strict=True):
        pieces, bound = [], 0.0
        found: list[tuple[str, np.ndarray, float]] = []
        for kind, rows_of_part in parts:
            # Plain rows stay as they are and have no bound.
            if kind == "plain":
                piece = np.zeros((len(rows_of_part), 9))
                piece[:, :3] = strand.start[rows_of_part]
                piece[:, 3:7] = np.nan
            else:
                piece = out[offsets[k] : offsets[k + 1]]
                bound = max(bound, _bound_of_run(piece, worst[k], tolerance, found))
                k += 1
            pieces.append(piece)
        # A curve is only as good as its worst part.
        for reason, where in places:
            size = float(error[where].max()) if reason == "noise" else np.inf
            found.append((reason, strand.start[where], size))
            bound = max(bound, size)
        lines.append(_joined(pieces, bound, _worst_interpolation(found)))
    return lines


def _worst_interpolation(
    found: list[tuple[str, np.ndarray, float]],
) -> list[tuple[str, np.ndarray, float]]:
    """Places with only the worst of the runs whose interpolation is not good enough."""
    errors = [error if reason == "interpolation" else -1.0 for reason, _, error in found]
    worst = int(np.argmax(errors)) if errors else 0
    return [f for k, f in enumerate(found) if f[0] != "interpolation" or k == worst]


def _bound_of_run(
    piece: np.ndarray, doubt: float, tolerance: float, found: list[tuple[str, np.ndarray, float]]
) -> float:
    """Bound of a lifted run; says where the interpolation or a chord is no better."""
    if doubt > tolerance:
        found.append(("interpolation", piece[:, :3], float(doubt)))
    lost = np.flatnonzero(piece[:, 7] < 0)
    for row in lost:
        found.append(("tangency", piece[row - 1 : row + 1, :3], np.inf))
    return np.inf if len(lost) else float(piece[:, 7].max() + doubt)


def _parts(
    strand: Strand, smooth: bool, status: np.ndarray, a: int, b: int, closed: bool
) -> tuple[list[tuple[str, np.ndarray]], list[tuple[str, np.ndarray]]]:
    """Runs of lifted rows and plain rows between them, in order; places (reason, rows)."""
    rows = np.arange(a, b)
    rows = rows[status[a:b] != DROPPED]
    lifted = status[rows] == LIFTED
    parts, places = [], []
    # Groups of consecutive rows that are all lifted or all plain.
    for group in np.split(np.arange(len(rows)), np.flatnonzero(np.diff(lifted)) + 1):
        members = rows[group]
        if not lifted[group[0]]:
            parts.append(("plain", members))
            for kind in np.unique(status[members]):
                reason = {NOISE: "noise", OVERLAP: "overlap"}.get(kind) or REASONS[kind]
                places.append((reason, members[status[members] == kind]))
            continue

        # A run on triangles ends at each edge, as its parameters do; one on lattices does not.
        cuts = strand.must[members] == 1 if not smooth else np.zeros(len(members), dtype=bool)
        cuts[[0, -1]] = True
        if closed and cuts.sum() < 4 and len(members) > 3:  # so that it keeps its shape
            cuts[[len(members) // 3, 2 * len(members) // 3]] = True
        at = np.flatnonzero(cuts)
        if len(members) == 1:
            parts.append(("run", members[[0, 0]]))
        parts += [("run", members[i : j + 1]) for i, j in pairwise(at)]
    return parts, places


def _rows_of_runs(
    runs: list[np.ndarray], two: Side, strand: Strand, p: np.ndarray, w: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows (n, 7) of all runs, their spans, and the triangle of each."""
    if not runs:
        return np.zeros((0, 7)), np.zeros((0, 2), dtype=np.int64), np.zeros(0, dtype=np.int64)

    # The members of all runs in one list; `spans` holds the first and last row of each (inclusive).
    members = np.concatenate(runs)
    sizes = np.array([len(run) for run in runs])
    stop = np.cumsum(sizes)
    spans = np.stack([stop - sizes, stop - 1], axis=1)
    tri = strand.tri[members[stop - sizes]]
    rows = np.hstack([p[members], w[members]])

    if not two.smooth:  # the end of a run belongs to the next triangle, too
        a, b, c = (two.c[tri, k] for k in range(3))
        u, v, d = b - a, c - a, p[members[stop - 1]] - a
        uu, uv, vv = ((q * r).sum(axis=1) for q, r in ((u, u), (u, v), (v, v)))
        du, dv = (d * u).sum(axis=1), (d * v).sum(axis=1)
        size = uu * vv - uv * uv
        rows[stop - 1, 5] = (du * vv - dv * uv) / size
        rows[stop - 1, 6] = (dv * uu - du * uv) / size
    return rows, spans, tri


def _joined(
    pieces: list[np.ndarray], bound: float, places: list[tuple[str, np.ndarray, float]]
) -> Line:
    """One line from its parts; where two runs share a point, it is kept once."""
    rows = np.concatenate(pieces)
    keep = np.append(True, (np.diff(rows[:, :3], axis=0) != 0).any(axis=1))
    rows = rows[keep]
    closed = len(rows) > 2 and bool((rows[0, :3] == rows[-1, :3]).all())
    return Line(rows[:, :3], closed, bound, places)
