"""How cost grows where many things meet in one place: ``python -m benchmarks.growth [family ...]``.

Each family is measured at three or more sizes over two decades, each in a process of its own: the
size, pairs of triangles tested, what comes out, seconds of computing, the most memory [MB] beyond
what the loaded package takes, and the power of the size by which seconds grew since the row before.
The tables are those of docs/validation/growth.md. Without a family, all of them are measured, which
takes about half an hour on a quiet machine; ``--quick`` leaves out the largest size of each.
"""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
import time

import numpy as np

import geosurf as gs
from geosurf.errors import GeosurfError

LIMIT = 900  # seconds of a size


def grid(name, n, height=30.0, role="horizon"):
    """A hilly list of 2 (n - 1)**2 triangles."""
    x = np.linspace(0, 1000, n)
    x, y = np.meshgrid(x, x)
    z = height * np.sin(x / 100) * np.cos(y / 130)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = (q.ravel() for q in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    faces = np.concatenate([np.c_[a, b, c], np.c_[a, c, d]])
    return gs.TriSurface(name, role, np.c_[x.ravel(), y.ravel(), z.ravel()], faces)


def planes_through_a_line(n):
    """Surfaces of two triangles, upright, all through one axis."""
    up, surfaces = np.array([0, 0, 20.0]), []
    for k in range(n):
        along = 40 * np.array([np.cos(np.pi * k / n), np.sin(np.pi * k / n), 0])
        corners = np.array([-along - up, along - up, along + up, up - along])
        surfaces.append(gs.TriSurface(f"F{k}", "fault", corners, [[0, 1, 2], [0, 2, 3]]))
    return surfaces


def planes_through_a_point(n):
    """Surfaces of one triangle around one point, exactly, in general directions."""
    rng, surfaces = np.random.default_rng(2), []
    for k in range(n):
        a, b = rng.integers(-40, 41, (2, 3)) * 2.0
        while not np.cross(a, b).any():
            a, b = rng.integers(-40, 41, (2, 3)) * 2.0
        corners = np.array([a, b, -(a + b)])
        surfaces.append(gs.TriSurface(f"F{k}", "fault", corners, [[0, 1, 2]]))
    return surfaces


def seam(n):
    """One surface of triangles that straddle a line but for the last digit."""
    rng = np.random.default_rng(1)
    line, start, corners = np.array([0.6, 0.8, 0.1]), np.array([0.1, 0.2, 0.3]), []
    for _ in range(n):
        side = rng.normal(size=3)
        side -= side @ line / (line @ line) * line
        side /= np.linalg.norm(side)
        a, b = start - 2 * line + rng.random() * line, start + 2 * line
        corners += [a - side * rng.random(), b - side * rng.random()]
        corners.append(start + side * rng.random() + line * rng.normal())
    return [gs.TriSurface("A", "fault", np.array(corners), np.arange(3 * n).reshape(-1, 3))]


def fan(n, waves=7, name="A", tilt=0.0):
    """A cone of n triangles about one vertex."""
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    rim = np.c_[np.cos(turn) * 10, np.sin(turn) * 10, np.sin(waves * turn) + tilt * np.cos(turn)]
    vertices, k = np.vstack([[0, 0, 0.25], rim]), np.arange(n)
    return gs.TriSurface(name, "fault", vertices, np.c_[0 * k, 1 + k, 1 + (k + 1) % n])


def islands(n):
    """A horizon in about n squares that touch nothing."""
    n = 2 * math.isqrt(n) + 1
    x = np.linspace(-1, 11, n)
    x, y = np.meshgrid(x, x)
    i = np.arange(n * n).reshape(n, n)[:-1:2, :-1:2].ravel()
    triangles = np.concatenate([np.c_[i, i + 1, i + n + 1], np.c_[i, i + n + 1, i + n]])
    z = -5 + 0.5 * np.sin(x) * np.cos(y)
    return gs.TriSurface("H", "horizon", np.c_[x.ravel(), y.ravel(), z.ravel()], triangles)


def bodies(n, name="Salt"):
    """A fault that is n closed tetrahedra, which touch nothing."""
    side = math.ceil(n ** (1 / 3))
    k = np.arange(n)
    at = np.stack([k % side, k // side % side, k // side**2], axis=1) * 10.0 / side
    at = at * 0.98 - [0, 0, 10] + [0.05, 0.05, 0.05]
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 6.0 / side
    vertices = (at[:, None] + corner).reshape(-1, 3)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    return gs.TriSurface(name, "fault", vertices, (faces + 4 * k[:, None, None]).reshape(-1, 3))


def chords(n):
    """A horizon of two triangles, and n slivers that cut it along one line, each over a part."""
    rng = np.random.default_rng(4)
    start = rng.integers(-4000, 4000, n) / 16.0
    end = start + rng.integers(1, 400, n) / 16.0
    a, b = rng.integers(1, 1000, (2, n)) / 8.0
    corners = np.stack([np.c_[start, -a, -b], np.c_[end, -a, -b], np.c_[end, a, b]], axis=1)
    flat = np.array([[-900, -900, 0], [900, -900, 0], [900, 900, 0], [-900, 900, 0.0]])
    return [
        gs.TriSurface("Top", "horizon", flat, [[0, 1, 2], [0, 2, 3]]),
        gs.TriSurface("F", "fault", corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3)),
    ]


def loops(n):
    """A level plane through n closed bodies: n closed curves."""
    flat = np.array([[-1, -1, 0], [12, -1, 0], [12, 12, 0], [-1, 12, 0.0]])
    side = math.isqrt(n)
    k = np.arange(side * side)
    at = np.stack([k % side, k // side, 0 * k - 0.3], axis=1) * [10.0 / side, 10.0 / side, 1]
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * [6.0 / side, 6.0 / side, 1]
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    body = (at[:, None] + corner).reshape(-1, 3)
    faces = (faces + 4 * k[:, None, None]).reshape(-1, 3)
    return [
        gs.TriSurface("Top", "horizon", flat, [[0, 1, 2], [0, 2, 3]]),
        gs.TriSurface("F", "fault", body, faces),
    ]


# ------------------------------------------------------------------ what is measured
def _curves(surfaces, itself=False):
    def run():
        curves = gs.intersect_surfaces(surfaces, self_intersections=itself)
        return len(curves.segments), curves.cost

    return run


def _rebuild(surfaces, itself=False):
    return lambda: len(gs.rebuild_surfaces(surfaces, self_intersections=itself).triangles)


def _carve(surface):
    patches = gs.rebuild_surfaces([surface, *gs.build_walls((0, 10, 0, 10, -10, 0))])

    def run():
        try:
            units = gs.carve_units(patches)
        except GeosurfError as error:
            return f"{type(error).__name__}"
        return f"{len(units)} units"

    return run


def _shells(n):
    run = _carve(bodies(n))

    def shells():
        return run()

    return shells


HUNDRED_FOLD = (1_000, 10_000, 100_000)
FAMILIES = {
    "planes": ((30, 100, 300), lambda n: _curves(planes_through_a_line(n))),
    "planes-rebuilt": ((30, 100, 300), lambda n: _rebuild(planes_through_a_line(n))),
    "point": ((30, 100, 300), lambda n: _curves(planes_through_a_point(n))),
    "seam": ((10, 30, 100, 200), lambda n: _curves(seam(n), True)),
    "fans": ((300, 3_000, 30_000), lambda n: _curves([fan(n), fan(n, 11, "B", 1.0)])),
    "identical": ((72, 224, 708), lambda n: _curves([grid("A", n), grid("B", n)])),
    "identical-rebuilt": ((72, 224, 708), lambda n: _rebuild([grid("A", n), grid("B", n)])),
    "sheets": ((3, 10, 30), lambda n: _curves([grid(f"S{k}", 21) for k in range(n)])),
    "sheets-rebuilt": ((10, 30, 100), lambda n: _rebuild([grid(f"S{k}", 21) for k in range(n)])),
    "islands": (HUNDRED_FOLD, lambda n: _carve(islands(n))),
    "bodies": ((100, 1_000, 10_000), _shells),
    "chords": ((1_000, 3_000, 10_000), lambda n: _curves(chords(n))),
    "loops": (HUNDRED_FOLD, lambda n: _curves(loops(n))),
}  # fmt: skip


def measure(family: str, n: int) -> dict:
    """One size, in this process."""
    make = FAMILIES[family][1]
    make(FAMILIES[family][0][0])()  # loads kernels
    run = make(n)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    try:
        out = run()
    except GeosurfError as error:
        out = f"refused: {error}"
    seconds = time.process_time() - start
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    out, cost = out if isinstance(out, tuple) else (out, {})
    return {"out": out, "seconds": seconds, "MB": most / 1024, "pairs": cost.get("pairs_tested")}


def table(family: str, quick: bool) -> list[str]:
    """Rows of all sizes, each from a child process."""
    sizes = FAMILIES[family][0][: -1 if quick else None]
    rows, before = [], None
    for n in sizes:
        command = [sys.executable, "-m", "benchmarks.growth", "--one", family, str(n)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
        except subprocess.TimeoutExpired:
            rows.append(f"| {n} | | more than {LIMIT} s | | | |")
            continue
        if done.returncode:
            rows.append(f"| {n} | ended with {done.returncode} | | | | |")
            continue
        row = json.loads(done.stdout)
        power = ""
        if before and min(row["seconds"], before[1]) > 0.02:
            power = f"{math.log(row['seconds'] / before[1]) / math.log(n / before[0]):.2f}"
        before = n, row["seconds"]
        pairs = "" if row["pairs"] is None else row["pairs"]
        rows.append(
            f"| {n} | {pairs} | {row['out']} | {row['seconds']:.2f} | {row['MB']:.0f} | {power} |"
        )
    return rows


def main(arguments: list[str]) -> int:
    """Print a table for each family; 1 if a size did not end."""
    if arguments[:1] == ["--one"]:
        sys.stdout.write(json.dumps(measure(arguments[1], int(arguments[2]))))
        return 0
    quick = "--quick" in arguments
    wanted = [a for a in arguments if not a.startswith("-")] or list(FAMILIES)
    unknown = [a for a in wanted if a not in FAMILIES]
    if unknown:
        sys.stdout.write(f"unknown: {unknown}; there are {', '.join(FAMILIES)}\n")
        return 2
    bad = 0
    for family in wanted:
        sys.stdout.write(
            f"\n### {family}\n\n| n | pairs tested | output | seconds | MB | power |\n"
        )
        sys.stdout.write("|---|---|---|---|---|---|\n")
        for row in table(family, quick):
            sys.stdout.write(row + "\n")
            sys.stdout.flush()
            bad += "ended with" in row or "more than" in row
    sys.stdout.write(f"\n{len(wanted)} families, {bad} sizes that did not end\n")
    return 1 if bad else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
