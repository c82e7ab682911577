"""What a tolerance costs next to the plain curve of the same grids: ``python -m benchmarks.dial``.

Waves and a listric fault (`gs.synthetic.waves`), n x n nodes each, from two ``xarray`` grids to the
curve. Each round runs all routes in turn; a cell has the least processor time of all rounds [ms],
and its ratio to that of the plain route.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable

import geosurf as gs

TOLERANCES = (1.0, 0.1, 0.01)
NODES = (141, 283, 566, 1131, 2237)


def least(routes: list[Callable[[], object]], rounds: int) -> list[float]:
    """Least processor time of each route over some rounds [ms]."""
    found = [float("inf")] * len(routes)
    for _ in range(rounds):
        for k, route in enumerate(routes):
            start = time.process_time()
            route()
            found[k] = min(found[k], 1000.0 * (time.process_time() - start))
    return found


def rows(n: int, rounds: int) -> str:
    """One row of the table."""
    world = gs.synthetic.waves(n)
    (top,), (wall,) = world.horizons.values(), world.faults.values()

    def curve(tolerance: float) -> object:
        pair = gs.triangulate_horizon(top, name="Top"), gs.triangulate_fault(wall, name="F1")
        return gs.intersect_surfaces(pair, tolerance=tolerance)

    times = least([lambda t=t: curve(t) for t in (0.0, *TOLERANCES)], rounds)
    cells = " | ".join(f"{t:.1f} ({t / times[0]:.2f})" for t in times[1:])
    return f"| {n} | {4 * (n - 1) ** 2:.3g} | {times[0]:.1f} | {cells} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    asked = parser.parse_args()
    head = " | ".join(f"{t:g} m" for t in TOLERANCES)
    sys.stdout.write(f"| nodes per side | triangles | plain | {head} |\n")
    sys.stdout.write("|---|---|---|" + "---|" * len(TOLERANCES) + "\n")
    for n in NODES:
        sys.stdout.write(rows(n, asked.rounds) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
