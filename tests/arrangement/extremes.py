"""Coordinates of all sizes: ``python -m tests.arrangement.extremes 2000``.

Soups whose coordinates are tiny, huge, or both, from the least numbers that there are to the
largest, axis by axis, corner by corner or digit by digit. What geosurf takes is judged as
`make stress` judges it; what it does not take is refused by a SurfaceError that states the
sizes that can be used. Run it with NUMBA_BOUNDSCHECK=1 (and a GEOSURF_CACHE_DIR of its own), too:
no index may leave its array. Ends with 1 if an answer is wrong or an error is another one.
"""

from __future__ import annotations

import sys

import numpy as np

from benchmarks.stress.case import Case
from benchmarks.stress.rational import flat
from benchmarks.stress.shapes import soup
from benchmarks.stress.stress import run_case
from tests.counting import count

SIZES = (
    "exact arithmetic takes 0 and sizes from",
    "the limit is 1.15292e+18 m",
    "or beyond 1.15292e+18 m",
)
KINDS = ("scaled", "stretched", "mixed", "nearly zero", "denormal", "huge", "all sizes")


def triangles(rng, kind: str, n: int) -> np.ndarray:
    """Corners (n, 3, 3), not all with an area."""
    lattice = rng.integers(-2, 3, (n, 3, 3)).astype(float)
    if kind == "scaled":
        return lattice * 2.0 ** rng.integers(-290, 58)
    if kind == "stretched":  # a plane or a line but for one part in 10**70
        return lattice * 2.0 ** rng.integers(-120, 58, 3)
    if kind == "mixed":
        return lattice * 2.0 ** rng.choice([-200, -40, 0, 40], (n, 3, 3))
    if kind == "nearly zero":
        return np.where(
            lattice == 0, rng.normal(size=lattice.shape) * 10.0 ** -rng.integers(16, 70), lattice
        )
    if kind == "denormal":
        return lattice * 10.0 ** -rng.uniform(290, 322, (n, 3, 3))
    if kind == "huge":
        return lattice * 10.0 ** rng.uniform(0, 300)
    return (
        rng.normal(size=lattice.shape) * 10.0 ** rng.uniform(-320, 17, (n, 3, 3)) * (lattice != 0)
    )


def case_of(seed: int) -> Case | None:
    """Two surfaces; None if none of their triangles has an area."""
    rng = np.random.default_rng([83, seed])
    kind = KINDS[seed % len(KINDS)]
    found = []
    for name in "AB":
        corners = np.array(
            [t for t in triangles(rng, kind, int(rng.integers(1, 5))) if not flat(t)]
        )
        if len(corners) == 0:
            return None
        found.append(soup(name, corners))
    return Case(kind, seed, 0, tuple(found), self_intersections=True)


def check(seed: int) -> str:
    """What became of a case, in a word."""
    case = case_of(seed)
    if case is None:
        return "without area"
    outcome = run_case(case)
    refusals = [w for w in outcome.wrong if "SurfaceError" in w]
    others = [w for w in outcome.wrong if w not in refusals]
    assert not others, others[0]
    for words in refusals:
        assert any(part in words for part in SIZES), words
    if refusals:
        return "refused for its size"
    return "refused for rounding" if outcome.refused else "right"


if __name__ == "__main__":
    sys.exit(count(check, cases=2_000))
