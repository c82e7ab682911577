"""Count crossings that the shortlist misses: ``python -m tests.rebuild.crossings [worlds]``.

Worlds that are degenerate up to rounding are cut, and their points rounded. Which pieces cross then
is asked of the shortlist (`geosurf.rebuild.repair`) and of an exact test of all pairs: both must
name the same faces. What is left after the repair is tested as a whole mesh, all pairs again: none
may cross. Refusals are counted. Ends with 1 if anything is missed.
"""

from __future__ import annotations

import sys

import numpy as np

from benchmarks.stress.catalogue import random_turn, turned
from geosurf import Lattice, TriSurface, rebuild_surfaces
from geosurf.arrangement.triangles import crossing_pairs
from geosurf.errors import RoundingError, SurfaceError
from tests.counting import count
from tests.rebuild.test_soundness import degenerate, found_and_there, hinged, through_one_point
from tests.strategies import soup


def _triangle(rng, p, n, tip: bool):
    """A triangle with a place p inside, or on an edge and not beyond it."""
    if tip:
        return [p + n[0], p - n[0] * rng.uniform(0.4, 1), p + n[1]]
    return [p + n[0], p + n[1], p - n[0] * rng.uniform(0.4, 1) - n[1] * rng.uniform(0.4, 1)]


def grazing(seed):
    """An edge that pierces a face at a flat angle, and faces that cut it close to that place."""
    rng = np.random.default_rng([5, seed])
    turn = random_turn(rng) if seed % 2 else np.eye(3)
    at = rng.normal(size=3) * 10.0 ** rng.integers(-1, 3)
    flat, near = 10.0 ** -rng.uniform(4, 13), 10.0 ** -rng.uniform(0, 14)
    angle = rng.uniform(0.1, 3.0) if seed % 3 else 10.0 ** -rng.uniform(0, 6)
    off = rng.uniform(-1, 1) * flat if seed % 5 else 0.0
    tip = rng.uniform(0.5, 3, 2) * [np.cos(angle), np.sin(angle)]
    out = [
        [[-9, -7, 0], [11, -6, 0], [1, 9, 0]],
        [[-3, 0, off - 3 * flat], [4, 0, off + 4 * flat], [rng.uniform(-2, 2), *tip]],
    ]
    for k in range(1 + (seed % 4 == 0)):
        p = np.array([near * rng.choice([-1, 1]), 10.0 ** -rng.uniform(0, 14) if k else 0.0, 0.0])
        out.append(_triangle(rng, p, rng.normal(size=(2, 3)) * 3, tip=False))
    return [soup(f"s{i}", [face]) for i, face in enumerate(turned(np.array(out), turn) + at)]


def bundle(seed):
    """Faces and edges through nearly one point, at angles of all sizes."""
    rng = np.random.default_rng([6, seed])
    turn, at = random_turn(rng), rng.normal(size=3) * 10.0 ** rng.integers(-1, 4)
    out = [[[-9, -7, 0], [11, -6, 0], [1, 9, 0]]]
    for _ in range(int(rng.integers(2, 6))):
        p = rng.normal(size=3) * 10.0 ** -rng.uniform(0, 16)
        p[2] *= 10.0 ** -rng.integers(0, 8)
        n = rng.normal(size=(2, 3)) * 3
        n[:, 2] *= 10.0 ** -rng.integers(0, 9)
        out.append(_triangle(rng, p, n, tip=rng.random() < 0.5))
    return [soup(f"s{i}", [face]) for i, face in enumerate(turned(np.array(out), turn) + at)]


def lattices(seed):
    """Two grids that differ by a hair or by units in the last place, and faults through nodes."""
    rng = np.random.default_rng([9, seed])
    n = int(rng.integers(3, 6))
    shift = np.round(rng.random(3), int(rng.integers(1, 4))) + rng.choice([0.0, 1000.0])
    x, y = np.meshgrid(np.arange(n) * 1.0, np.arange(n) * 1.0)
    z = rng.integers(0, 3, (n, n)) / float(rng.choice([1, 3, 7, 10]))
    hair = 10.0 ** -rng.uniform(8, 16)
    tilt = hair * (rng.uniform(-1, 1) * x + rng.uniform(-1, 1) * y) + rng.choice([0, hair])
    steps = rng.choice([-1, 0, 1], z.shape) * np.spacing(1.0 + shift[2])
    other = rng.integers(0, 3, (n, n)) / float(rng.choice([1, 3, 7, 10]))
    second = (z + steps, z + rng.normal(size=z.shape) * hair, z + tilt, other)[rng.integers(4)]
    sheets = [("A", "horizon", x, y, z), ("B", "horizon", x, y, second)]
    for k in range(int(rng.integers(1, 4))):
        ends, lean = rng.integers(0, 2 * n, 2) / 2.0, rng.integers(-2, 3) / rng.choice([1.0, 2, 3])
        t, down = np.meshgrid(np.linspace(-1, n, int(rng.integers(2, 4))), np.linspace(-2, 4, 2))
        across = ends[0] + (ends[1] - ends[0]) * (t + 1) / (n + 1) + lean * down
        one, two = (across, t) if rng.random() < 0.5 else (t, across)
        sheets.append((f"F{k}", "fault", one, two, down))
    out = []
    for name, role, *places in sheets:
        easting, northing, elevation = (p + s for p, s in zip(places, shift, strict=True))
        lattice = Lattice(easting, northing, elevation, bool(rng.integers(2)), False)
        surface = TriSurface(name, role, lattice=lattice)
        if rng.random() < 0.4:
            surface = TriSurface(name, role, surface.vertices, surface.triangles)
        out.append(surface)
    return out


FAMILIES = {
    "grazing": grazing,
    "bundle": bundle,
    "lattices": lattices,
    "degenerate": degenerate,
    "through one point": through_one_point,
    "hinged": hinged,
}


def check(family: str, seed: int) -> list[str]:
    """What became of a world: of "turned", "crossing", "missed", "refused", "left"."""
    surfaces, out = FAMILIES[family](seed), []
    answer = found_and_there(surfaces)
    if answer is None:
        out.append("turned")
    elif answer[1]:
        out.append("crossing")
    if answer and answer[0] != answer[1]:
        out.append("missed")
    try:
        patches = rebuild_surfaces(surfaces, self_intersections=True)
    except RoundingError:
        return [*out, "refused"]
    rows = np.unique(np.sort(patches.triangles, axis=1), axis=0)
    return [*out, "left"] if len(crossing_pairs(patches.local, rows)) else out


def verdict(seed: int) -> str | tuple[str, str]:
    """What became of a world of one family after another."""
    number, row = divmod(seed, len(FAMILIES))
    family = list(FAMILIES)[row]
    try:
        words = " ".join(check(family, number)) or "apart"
    except SurfaceError:  # a triangle without area
        return "flat"
    is_wrong = "missed" in words or "left" in words
    return ("wrong", f"{family} {number}: {words}") if is_wrong else words


if __name__ == "__main__":
    sys.exit(count(verdict, cases=60_000))
