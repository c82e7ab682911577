"""What is right about curves: they lie on both surfaces, and cover all that triangles share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.stress import rational as exact
from benchmarks.stress.verdict import (
    NEAR,
    Meeting,
    Verdict,
    distances,
    from_segment,
    judge_distance,
    nearest,
    ulp_of,
)
from geosurf.model import Curves, TriSurface


def judge_curves(
    surfaces: Sequence[TriSurface], curves: Curves, met: Sequence[Meeting], complete: bool
) -> Verdict:
    """
    Judge curves: they lie on both surfaces, and what triangles share is on them.

    Parameters
    ----------
    surfaces : sequence of TriSurface
    curves : Curves
    met : sequence of Meeting
        In the frame of ``curves.origin``.
    complete : bool
        Whether `met` has all pairs; if so, a pair that does not meet must have no curve.

    Returns
    -------
    Verdict
    """
    verdict = Verdict()

    # in the frame of the curves, as the kernels saw them; errors count in ulp of the largest
    # coordinate
    corners = [s.vertices[s.triangles] - curves.origin for s in surfaces]
    ulp = ulp_of(*corners)
    pairs = {tuple(p) for p in curves.surfaces_of_segment.tolist()} | {(m.i, m.j) for m in met}
    # Pairs with curves, contacts or exact meetings.
    for i, j in sorted(pairs | {t.surfaces for t in curves.contacts}):
        # neighbours that only share their own corners and edges have no contact to report
        mine = [m for m in met if (m.i, m.j) == (i, j) and not m.joined]
        rows = (curves.surfaces_of_segment == (i, j)).all(axis=1)
        ends = curves.local[curves.segments[rows]]
        what = f"{curves.names[i]} and {curves.names[j]}"
        # Ends and middles of all segments lie on both surfaces.
        for points in (ends[:, 0], ends[:, 1], ends.mean(axis=1)):
            for k in (i, j):
                _judge_on_surface(what, points, corners[k], ulp, verdict)

        # only with all pairs looked at can the judge know that surfaces do not meet
        touches = [t for t in curves.contacts if t.surfaces == (i, j)]
        verdict.check(
            bool(mine) or not complete or not (len(ends) or touches),
            f"{what} have a gap, but are reported to meet",
        )

        areas = any(len(m.corners) > 2 for m in mine)
        if areas and not any(t.kind == "area" for t in touches):
            verdict.check(False, f"{what} overlap, but no area is reported")
        # Inside an area there are no curves, except where triangles cross.
        if areas:
            _judge_through_areas(what, mine, (corners[i], corners[j]), ends, ulp, verdict)
        if not areas and not any(t.kind == "area" for t in touches):
            single = np.array([t.points[0] for t in touches]).reshape(-1, 3)
            for k in (i, j):
                _judge_on_surface(
                    what,
                    single,
                    surfaces[k].vertices[surfaces[k].triangles],
                    ulp_of(single),
                    verdict,
                )
            _judge_shared(what, mine, ends, single - curves.origin, (ulp, ulp_of(single)), verdict)
    return verdict


def _judge_on_surface(
    what: str, points: np.ndarray, corners: np.ndarray, ulp: float, verdict: Verdict
) -> None:
    # Each point against each triangle: stress cases are small.
    """Points (n, 3) lie on the nearest of triangles (m, 3, 3)."""
    # (point, triangle): the closest triangle of each point, then its distance in fractions if in
    # doubt
    n, m = len(points), len(corners)
    far = distances(np.repeat(points, m, axis=0), np.tile(corners, (n, 1, 1))).reshape(n, m)
    if n:
        closest = corners[far.argmin(axis=1)]
        judge_distance(f"{what}: a point of the curve", points, closest, ulp, verdict)


def _judge_shared(what: str, met: Any, ends: Any, single: Any, ulps: Any, verdict: Verdict) -> None:
    """Shared segments are covered by curves, shared points are on them or touching points.

    Touching points are kept in world coordinates, so their ulp is another one: ``ulps[1]``.
    """
    ulp, of_world = ulps
    on_curve = ends.reshape(-1, 3)
    for m in met:
        name = f"{what}, triangles {m.f} and {m.g}"

        # a single common point may be a touching point instead of a curve's
        if len(m.corners) == 1 and _among(single, m.corners[0], of_world):
            continue
        if len(ends) == 0:
            verdict.check(False, f"{name} meet, but nothing is reported")
            continue
        for corner in m.corners:
            verdict.measure(on_curve[nearest(on_curve, corner)], corner, ulp, name)

        # two corners: a segment, every part of which must be on a curve
        if len(m.corners) == 2:
            a, b = (np.array(exact.rounded(corner)) for corner in m.corners)
            _judge_covered(name, ends, a, b, ulp, verdict)


def _judge_through_areas(
    what: str,
    met: Any,
    corners: tuple[np.ndarray, np.ndarray],
    ends: Any,
    ulp: float,
    verdict: Verdict,
) -> None:
    """Where triangles pass through each other there is a curve, even inside of an area."""
    for m in met:
        if len(m.corners) != 2:
            continue
        P, Q = exact.rational(corners[0][m.f]), exact.rational(corners[1][m.g])
        if exact.straddles(P, Q) and exact.straddles(Q, P):
            a, b = (np.array(exact.rounded(corner)) for corner in m.corners)
            name = f"{what}, triangles {m.f} and {m.g}, which cross"
            _judge_covered(name, ends, a, b, ulp, verdict)


def _among(points: np.ndarray, corner: exact.Point, ulp: float) -> bool:
    return len(points) > 0 and exact.error_of(points[nearest(points, corner)], corner) <= ulp


def _judge_covered(name: str, ends: Any, a: Any, b: Any, ulp: float, verdict: Verdict) -> None:
    """Segments of curves (n, 2, 3) that lie on the segment from a to b add up to it."""
    on = np.ones(len(ends), dtype=bool)
    for k in range(2):
        on &= from_segment(ends[:, k], a, b) <= NEAR * ulp
    covered = np.linalg.norm(ends[on, 1] - ends[on, 0], axis=1).sum()

    # The covered length may lack rounding at both ends of each segment.
    lack = np.linalg.norm(b - a) - covered
    slack = NEAR * ulp * (2 + on.sum())
    verdict.check(lack <= slack, f"{name}: {lack:.3g} m of the line are missing in the curves")
