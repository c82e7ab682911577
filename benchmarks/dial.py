"""What a tolerance costs next to the plain curve of the same grids: ``python -m benchmarks.dial``.

Waves and a listric fault (`gs.synthetic.waves`), n x n nodes each, and noisy hills with a listric
fault and with one of two triangles, from two ``xarray`` grids to the curve. Each round runs all
routes in turn; a cell has the least processor time of all rounds [ms], and its ratio to that of the
plain route.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator

import geosurf as gs
from benchmarks.scenes import make_setting

TOLERANCES = (1.0, 0.1, 0.01)
NODES = (141, 283, 566, 1131, 2237)
SIZES = (2e4, 1.28e6, 5e6)  # triangles of noisy hills


def least(routes: list[Callable[[], object]], rounds: int) -> list[float]:
    """Least processor time of each route over some rounds [ms]."""
    found = [float("inf")] * len(routes)
    for _ in range(rounds):
        for k, route in enumerate(routes):
            start = time.process_time()
            route()
            found[k] = min(found[k], 1000.0 * (time.process_time() - start))
    return found


def row(name: str, surfaces: Callable[[], list[gs.TriSurface]], rounds: int) -> str:
    """One row of the table."""
    n_triangle = sum(surface.n_triangle for surface in surfaces())

    def curve(tolerance: float) -> object:
        return gs.intersect_surfaces(surfaces(), tolerance=tolerance)

    times = least([lambda t=t: curve(t) for t in (0.0, *TOLERANCES)], rounds)
    cells = " | ".join(f"{t:.1f} ({t / times[0]:.2f})" for t in times[1:])
    return f"| {name} | {n_triangle:.3g} | {times[0]:.1f} | {cells} |"


def scenes() -> Iterator[tuple[str, Callable[[], list[gs.TriSurface]]]]:
    """Name and surfaces of each row; surfaces are made anew in each call."""
    for n in NODES:
        world = gs.synthetic.waves(n)
        (top,), (wall,) = world.horizons.values(), world.faults.values()
        yield (
            f"waves, {n} nodes per side",
            lambda top=top, wall=wall: [
                gs.triangulate_horizon(top, name="Top"),
                gs.triangulate_fault(wall, name="F1"),
            ],
        )
    for name, what in (("S1", "noisy hills, listric fault"), ("S2", "noisy hills, two triangles")):
        for size in SIZES:
            yield what, make_setting(name, size).surfaces


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    asked = parser.parse_args()
    head = " | ".join(f"{t:g} m" for t in TOLERANCES)
    sys.stdout.write(f"| grids | triangles | plain | {head} |\n")
    sys.stdout.write("|---|---|---|" + "---|" * len(TOLERANCES) + "\n")
    for name, surfaces in scenes():
        sys.stdout.write(row(name, surfaces, asked.rounds) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
