"""A long chain of `Scene.replace`: ``python -m benchmarks.replace_memory 1000 [seed]``.

Each step moves a horizon or the box and asks for units, curves and a measure. Resident memory is
printed ten times; it should stay level after the first tenth. Linux only.
"""

from __future__ import annotations

import os
import random
import sys
from pathlib import Path

import geosurf as gs


def resident() -> float:
    """Resident memory of this process [MB]."""
    pages = Path("/proc/self/statm").read_text().split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE") / 1e6


def changed(world: gs.synthetic.World, step: int, rng: random.Random) -> dict:
    """One change of the inputs, never the same twice."""
    if step % 4 == 3:
        west, east, south, north, bottom, top = world.box
        return {"box": (west, east - rng.uniform(0, 500), south, north, bottom, top)}
    name = rng.choice(list(world.horizons))
    grid = world.horizons[name]
    return {"horizons": {name: (grid + rng.uniform(-5, 5)).assign_attrs(grid.attrs)}}


def main(n: int = 1000, seed: int = 0) -> int:
    """Run the chain, and return 1 if memory grows."""
    rng, world = random.Random(seed), gs.synthetic.graben(n=41)
    scene = gs.Scene(world.horizons, world.faults, world.box)
    seen = []
    for step in range(n):
        scene = scene.replace(**changed(world, step, rng))
        _ = scene.units, scene.curves, scene.thickness("Top/Middle", 250.0)
        if (step + 1) % max(n // 10, 1) == 0:
            seen.append(resident())
            store = scene._graph.memory.store
            print(  # noqa: T201
                f"{step + 1:6d} steps: {seen[-1]:7.1f} MB resident; shared results "
                f"{store.bytes_stored() / 1e6:6.1f} MB, "
                f"dropped {store.bytes_dropped / 1e6:8.1f} MB",
                flush=True,
            )
    growth = (seen[-1] - seen[0]) / max(n - n // 10, 1)  # [MB] a step
    print(  # noqa: T201
        f"{n} replace calls, seed {seed}: {1000 * growth:.1f} kB more a step after the first tenth."
    )
    return int(growth > 0.02)


if __name__ == "__main__":
    raise SystemExit(main(*map(int, sys.argv[1:3])))
