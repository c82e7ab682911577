"""From data to a certified model: ``python -m benchmarks.certified "Drogon points" [--n 3]``.

Horizons and faults are read before; then horizons are torn, units and volumes made, and all
promises checked. Each round has a scene of its own; kernels are compiled in the first one.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import warnings

import numpy as np

import geosurf as gs
from benchmarks.folders import drogon_folder
from benchmarks.torn_fields import FIELDS

STEPS = ("sheets", "units and volumes", "certificate", "from data to certificate")


def round_of(name: str) -> np.ndarray:
    """Seconds (2, 4) of one round: by the clock and of the processor, by step and in sum."""
    horizons, faults, _ = FIELDS[name](drogon_folder())
    times = [(time.perf_counter(), time.process_time())]
    scene = gs.Scene(horizons, faults, tear=True)
    for step in (lambda: scene.sheets, lambda: scene.volumes, scene.check):
        step()
        times.append((time.perf_counter(), time.process_time()))
    spent = np.diff(np.array(times), axis=0).T
    return np.column_stack([spent, spent.sum(axis=1)])


def main() -> None:
    """Print medians of some rounds, without the first one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("field", choices=tuple(FIELDS))
    parser.add_argument("--n", type=int, default=3, help="rounds that count")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    rounds = [round_of(asked.field) for _ in range(asked.n + 1)][1:]
    wall, processor = np.median(rounds, axis=0)
    cores, load = len(os.sched_getaffinity(0)), os.getloadavg()[0]
    sys.stdout.write(f"{asked.field}: medians of {asked.n}, {cores} cores, load {load:.1f}\n")
    for step, one, other in zip(STEPS, wall, processor, strict=True):
        sys.stdout.write(f"  {step}: {one:.2f} s, processor {other:.2f} s\n")


if __name__ == "__main__":
    main()
