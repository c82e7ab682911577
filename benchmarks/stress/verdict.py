"""What judges share: verdicts, what triangles have in common exactly, distances."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from benchmarks.stress import rational as exact
from geosurf.model import TriSurface

BOUND = 1.0  # ulp between a constructed coordinate and the exact one; correct rounding gives 0.5
TINY = 1e-300  # instead of a division by zero
NEAR = 4.0  # ulp between a point and what it lies on, as far as floats can show


@dataclass
class Verdict:
    """What a judge found.

    Attributes
    ----------
    wrong : list of str
        One sentence for each violation; empty for a right result.
    error, error_ulp : float
        Largest difference of a coordinate from the exact one [m], and in ulp.
    """

    wrong: list[str] = field(default_factory=list)
    error: float = 0.0
    error_ulp: float = 0.0

    def check(self, holds: bool, sentence: str) -> None:
        """Note a sentence where something does not hold."""
        if not holds:
            self.wrong.append(sentence)

    def measure(self, point: np.ndarray, corner: exact.Point, ulp: float, what: str) -> None:
        """Note the error of a coordinate, and whether it is beyond the bound."""
        error = exact.error_of(point, corner)
        self.error = max(self.error, error)
        self.error_ulp = max(self.error_ulp, error / ulp)
        self.check(error <= BOUND * ulp, f"{what}: {error / ulp:.3g} ulp from the exact point")

    def add(self, other: Verdict) -> None:
        """Take another verdict on the same case in."""
        self.wrong += other.wrong
        self.error = max(self.error, other.error)
        self.error_ulp = max(self.error_ulp, other.error_ulp)


@dataclass(frozen=True)
class Meeting:
    """What triangle f of surface i and triangle g of surface j have in common, exactly.

    `joined` marks neighbours in one surface. They share their own corners and edges only, which
    is not a contact.
    """

    i: int
    f: int
    j: int
    g: int
    corners: tuple[exact.Point, ...]
    joined: bool


def ulp_of(*coordinates: np.ndarray) -> float:
    """Spacing of float64 at the largest coordinate."""
    return float(np.spacing(max(np.abs(c).max(initial=0.0) for c in coordinates)))


def meetings(
    surfaces: Sequence[TriSurface], origin: np.ndarray, most: int, itself: bool
) -> tuple[list[Meeting], bool]:
    """
    Find what pairs of triangles have in common, in fractions.

    Parameters
    ----------
    surfaces : sequence of TriSurface
    origin : ndarray, shape (3,)
        Of the local frame [m].
    most : int
        Pairs with overlapping boxes that are looked at, spread evenly over all.
    itself : bool
        Whether triangles of one surface are compared, too.

    Returns
    -------
    meetings : list of Meeting
        In local coordinates.
    complete : bool
        Whether all pairs were looked at.
    """
    # local coordinates, as the kernels see them
    corners = [s.vertices[s.triangles] - origin for s in surfaces]
    pairs = [
        (i, int(f), j, int(g))
        for i, j in itertools.combinations_with_replacement(range(len(surfaces)), 2)
        if i < j or itself
        for f, g in _boxes_meet(corners[i], corners[j])
        if i < j or f < g
    ]
    chosen = pairs
    # A sample at equal distances; the caller learns that it is not complete.
    if len(pairs) > most:
        chosen = [pairs[k] for k in np.linspace(0, len(pairs) - 1, most).astype(int)]

    # Neighbours in one surface meet in their common corners only; `joined` marks them.
    found = []
    for i, f, j, g in chosen:
        P, Q = exact.rational(corners[i][f]), exact.rational(corners[j][g])
        common = exact.meet(P, Q)
        if common:
            joined = i == j and len(common) < 3 and set(common) <= set(P) & set(Q)
            found.append(Meeting(i, f, j, g, tuple(common), joined))
    return found, len(chosen) == len(pairs)


def _boxes_meet(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Rows of triangles (n, 3, 3) and (m, 3, 3) whose boxes have a point in common."""
    # all pairs at once: cases have few triangles, so the obvious way is fast enough
    low, high = first.min(axis=1)[:, None], first.max(axis=1)[:, None]
    return np.argwhere(((low <= second.max(axis=1)) & (second.min(axis=1) <= high)).all(axis=2))


def nearest(points: np.ndarray, corner: exact.Point) -> int:
    """Row of the float point (n, 3) nearest to an exact one."""
    return int(np.abs(points - np.array(exact.rounded(corner))).max(axis=1).argmin())


def area_vectors(corners: np.ndarray) -> np.ndarray:
    """Twice the area vectors of triangles (n, 3, 3)."""
    a, b, c = corners.swapaxes(0, 1)
    return np.cross(b - a, c - a)


def judge_distance(
    what: str, points: np.ndarray, triangles: np.ndarray, ulp: float, verdict: Verdict
) -> None:
    """Points (n, 3) lie on triangles (n, 3, 3), each on its own: floats first, then fractions."""
    # floats first, fractions for those that look too far: rounding of the quick check fails no case
    for k in np.flatnonzero(~(distances(points, triangles) <= NEAR * ulp)):
        point, triangle = exact.rational(points[k : k + 1])[0], exact.rational(triangles[k])
        far = exact.distance(point, triangle)
        verdict.check(far <= NEAR * ulp, f"{what} is {far / ulp:.3g} ulp off its triangle")


def distances(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Distances of points (n, 3) from triangles (n, 3, 3), each from its own, in floats."""
    normal = area_vectors(triangles)
    size = np.linalg.norm(normal, axis=1)
    height = np.abs(((points - triangles[:, 0]) * normal).sum(axis=1)) / np.maximum(size, TINY)
    inside = np.ones(len(points), dtype=bool)
    edge = np.full(len(points), np.inf)

    # an edge of all triangles at once, shape (n, 3)
    for p, q in zip(
        triangles.swapaxes(0, 1), np.roll(triangles, -1, axis=1).swapaxes(0, 1), strict=True
    ):
        along, to = q - p, points - p
        inside &= (np.cross(along, to) * normal).sum(axis=1) >= 0
        size = np.maximum((along * along).sum(axis=1), TINY)
        t = np.clip((to * along).sum(axis=1) / size, 0, 1)
        edge = np.minimum(edge, np.linalg.norm(to - t[:, None] * along, axis=1))
    return np.where(inside, height, edge)


def from_segment(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances of points (n, 3) from the segment between a and b."""
    along, to = b - a, points - a
    size = float(along @ along)
    t = np.clip(to @ along / size, 0, 1) if size else np.zeros(len(points))
    return np.linalg.norm(to - t[:, None] * along, axis=1)
