"""Which unit is here, for many places: ``python -m benchmarks.places``.

The five horizons of 401 x 401 nodes with three faults of `benchmarks.results`: random points and a
regular grid, on one thread, next to pyvista's selection of enclosed points, unit by unit, with a
smaller number of points.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable

os.environ.setdefault("GEOSURF_THREADS", "1")

import numpy as np

import geosurf as gs
from benchmarks.results import MODELS, inputs_of

N_POINT, N_PEER, REPEAT = 10_000_000, 120_000, 3


def seconds(run: Callable[[], object]) -> float:
    """Median wall time of some calls."""
    found = []
    for _ in range(REPEAT):
        start = time.perf_counter()
        run()
        found.append(time.perf_counter() - start)
    return float(np.median(found))


def by_pyvista(scene: gs.Scene, points: np.ndarray) -> np.ndarray:
    """Row of the unit of each point by pyvista; -1 where none claims it."""
    import pyvista as pv

    found, cloud = np.full(len(points), -1), pv.PolyData(points)
    for k, unit in enumerate(scene.units.values()):
        inside = cloud.select_enclosed_points(unit.to_pyvista(), check_surface=False)
        found[inside["SelectedPoints"].astype(bool)] = k
    return found


def main() -> None:
    """Print one row for each way to ask."""
    scene = gs.Scene(*inputs_of(*MODELS["five horizons"]))
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
    start = time.perf_counter()
    peer = by_pyvista(scene, few)
    taken = time.perf_counter() - start
    ours = scene.sample(few, codes=True).unit.values
    print(f"| pyvista, unit by unit | {N_PEER} | {taken:.3g} | {1e9 * taken / N_PEER:.0f} |")
    print(f"\npyvista and geosurf differ at {int((peer != ours).sum())} of {N_PEER} points.")


if __name__ == "__main__":
    main()
