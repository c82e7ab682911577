"""Which unit is here, for many places: ``python -m benchmarks.places``.

The five horizons of 401 x 401 nodes with three faults of `benchmarks.results`: random points and a
regular grid, on one thread, next to pyvista's selection of enclosed points, unit by unit, with a
smaller number of points. ``--exact 100000`` instead compares points on vertices, edges and faces,
and random ones, with rational rays through every shell.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable

os.environ.setdefault("GEOSURF_THREADS", "1")

import numpy as np

import geosurf as gs
from benchmarks.results import MODELS, inputs_of
from tests.measure.rays import Shells, holds, unit_by_rays, whole

N_POINT, N_PEER, REPEAT = 10_000_000, 120_000, 3


def seconds(run: Callable[[], object]) -> float:
    """Median processor time of some calls, on one thread."""
    found = []
    for _ in range(REPEAT):
        start = time.process_time()
        run()
        found.append(time.process_time() - start)
    return float(np.median(found))


def on_boundaries(scene: gs.Scene, n: int) -> dict[str, np.ndarray]:
    """Local points of four kinds: vertices, middles of edges, on faces, anywhere."""
    rng = np.random.default_rng(3)
    units = list(scene.units.values())
    w, e, s, n_, low, high = scene.box
    places = np.array([w, s, low]) + rng.random((n - 3 * (n // 4), 3)) * [e - w, n_ - s, high - low]

    # every triangle of every unit is as likely as any other
    weights = np.array([len(unit.triangles) for unit in units], dtype=float)
    of = rng.choice(len(units), size=n // 4, p=weights / weights.sum())
    faces = np.stack(
        [u.local[u.triangles[rng.integers(len(u.triangles))]] for u in map(units.__getitem__, of)]
    )
    a, b, c = faces.transpose(1, 0, 2)
    return {
        "vertices": a,
        "middles of edges": 0.5 * (a + b),
        "on faces": 0.25 * (a + b) + 0.5 * c,
        "anywhere": places - units[0].origin,
    }


def is_on_boundary(points: np.ndarray, shells: Shells) -> np.ndarray:
    """Whether each point (n, 3), local, lies exactly on a triangle of a shell."""
    found = []
    for point in points:
        p = [whole(c) for c in point]
        found.append(any(holds(face, p) for _, face in shells.near(point)[1]))
    return np.array(found)


def compare_exactly(scene: gs.Scene, n: int) -> None:
    """Print how many points of each kind rational rays place into another unit."""
    origin, shells = next(iter(scene.units.values())).origin, Shells(scene.units)
    print("| points | number | exactly on a boundary | wrong |\n|---|---|---|---|")
    for kind, local in on_boundaries(scene, n).items():
        # a world coordinate is rounded: what is asked for is this place
        world = local + origin
        local = world - origin
        expected = np.array(unit_by_rays(scene.units, local, shells))
        found = scene.sample(world, codes=True).unit.values
        wrong = int((found != expected).sum())
        on = int(is_on_boundary(local, shells).sum())
        print(f"| {kind} | {len(local)} | {on} | {wrong} |", flush=True)


def by_pyvista(scene: gs.Scene, points: np.ndarray) -> np.ndarray:
    """Row of the unit of each point by pyvista; -1 where none claims it."""
    import pyvista as pv

    found, cloud = np.full(len(points), -1), pv.PolyData(points)
    for k, unit in enumerate(scene.units.values()):
        inside = cloud.select_interior_points(
            unit.to_pyvista(), method="cell_locator", check_surface=False
        )
        found[inside["selected_points"]] = k
    return found


def main() -> None:
    """Print one row for each way to ask, or the comparison with rational rays."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.places", description=__doc__)
    parser.add_argument("--exact", type=int, default=0, metavar="N", help="compare N points")
    given = parser.parse_args()
    scene = gs.Scene(*inputs_of(*MODELS["five horizons"]))
    if given.exact:
        compare_exactly(scene, given.exact)
        return
    w, e, s, n, low, high = scene.box
    size = np.array([e - w, n - s, high - low])
    points = np.array([w, s, low]) + np.random.default_rng(1).random((N_POINT, 3)) * size
    cell = (size / [400, 400, 62.5]).tolist()
    scene.sample(points[:10])

    print("| what | places | time [s] | per place [ns] |\n|---|---|---|---|")
    rows = {
        "random points, codes": (N_POINT, lambda: scene.sample(points, codes=True)),
        "random points, names": (N_POINT, lambda: scene.sample(points)),
        "regular grid, codes": (
            scene.sample(cell=cell, codes=True).unit.size,
            lambda: scene.sample(cell=cell, codes=True),
        ),
        "random points, distances": (
            N_POINT // 100,
            lambda: scene.sample(points[: N_POINT // 100], codes=True, distance=True),
        ),
    }
    for name, (count, run) in rows.items():
        taken = seconds(run)
        print(f"| {name} | {count} | {taken:.3g} | {1e9 * taken / count:.0f} |", flush=True)

    few = points[:N_PEER]
    start = time.process_time()
    peer = by_pyvista(scene, few)
    taken = time.process_time() - start
    ours = scene.sample(few, codes=True).unit.values
    print(f"| pyvista, unit by unit | {N_PEER} | {taken:.3g} | {1e9 * taken / N_PEER:.0f} |")
    print(f"\npyvista and geosurf differ at {int((peer != ours).sum())} of {N_PEER} points.")


if __name__ == "__main__":
    main()
