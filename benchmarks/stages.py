"""How the stages that a report runs grow: ``python -m benchmarks.stages``.

Models of four series: more nodes, horizons, faults, or units. Each model is built in a process of
its own; seconds are processor time, after the same steps on a small model have loaded all kernels.
The exponent b of ``a n^b`` is that from the second-largest size to the largest one.

==========  =====================================================================
nodes       3 horizons of n x n nodes, 2 faults; n^2 counts
horizons    n horizons of 201 x 201 nodes, 2 faults
faults      3 horizons of 201 x 201 nodes, n faults that do not meet each other
units       n horizons of 101 x 101 nodes, n faults; the number of units counts
==========  =====================================================================
"""

from __future__ import annotations

import argparse
import gc
import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import geosurf as gs
from benchmarks.results import inputs_of
from geosurf.model import Certificate

SERIES = {
    "nodes": [(3, n, 2) for n in (401, 801, 1601)],
    "horizons": [(n, 201, 2) for n in (10, 20, 40)],
    "faults": [(3, 201, n) for n in (10, 20, 40)],
    "units": [(n, 101, n) for n in (5, 10, 20)],
}
LIMIT = 1.1
SMALL = 0.02  # s: below it an exponent is noise


def sizes(series: str, units: list[int]) -> list[float]:
    """What counts along a series: nodes, horizons, faults or units of each of its models."""
    column = {"nodes": 1, "horizons": 0, "faults": 2}
    if series == "units":
        return [float(n) for n in units]
    power = 2 if series == "nodes" else 1
    return [float(model[column[series]]) ** power for model in SERIES[series]]


def stages(scene: gs.Scene, folder: Path) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Name and call of each stage, in the order of a report."""
    horizons, faults = list(scene.horizon_names), list(scene.fault_names)
    zones = [f"{above}/{below}" for above, below in pairwise(horizons)]
    yield "curves", lambda: scene.curves
    yield "patches", lambda: scene.patches
    yield "units", lambda: scene.units
    yield "volumes", lambda: scene.volumes
    yield "table", lambda: scene.units.table
    proof: dict[str, Certificate] = {}
    yield "certificate", lambda: proof.setdefault("found", scene.check())
    yield "cut-offs", lambda: [scene.cutoffs(h, f) for h in horizons for f in faults]
    yield "fault polygons", lambda: [scene.fault_polygons(h) for h in horizons]
    yield "thickness", lambda: [scene.thickness(zone) for zone in zones]
    yield "juxtaposition", lambda: [scene.juxtaposition(f, "all") for f in faults]
    yield "pictures", lambda: scene.render_pictures(folder)

    def page() -> Path:  # with the certificate of the run, as `geosurf run` writes it
        return gs.report_scene(scene, folder / "page", {}, certificate=proof["found"])

    yield "page", page


def measure(model: tuple[int, int, int]) -> dict[str, float]:
    """Processor seconds of each stage of one model, in this process, and its number of units."""
    found: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        for inputs in ((2, 41, 1), model):
            # of libraries that pictures have loaded Python looks at all objects now and then, which
            # takes 0.15 s in whatever stage it happens
            gc.collect()
            gc.freeze()
            scene = gs.Scene(*inputs_of(*inputs))
            for name, run in stages(scene, Path(folder)):
                start = time.process_time()
                run()
                found[name] = time.process_time() - start
    return found | {"n units": float(len(scene.units))}


def in_child(model: tuple[int, int, int]) -> dict[str, float]:
    """What `measure` finds in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.stages", "--one", json.dumps(model)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def exponent(n: list[float], seconds: list[float]) -> float:
    """Power by which seconds grew from the second-largest size to the largest."""
    if seconds[-2] < SMALL:
        return math.nan
    return math.log(seconds[-1] / seconds[-2]) / math.log(n[-1] / n[-2])


def print_table(series: str) -> None:
    """Print seconds of all stages along one series, and how they grow."""
    runs = [in_child(model) for model in SERIES[series]]
    units = [int(run.pop("n units")) for run in runs]
    n = sizes(series, units)
    heads = [f"{x:g}" for x in n]
    sys.stdout.write(f"\n| {series} | {' | '.join(heads)} | exponent |\n")
    sys.stdout.write("|---" * (len(n) + 2) + "|\n")
    for stage in runs[0]:
        seconds = [run[stage] for run in runs]
        power = exponent(n, seconds)
        shown = "too short" if math.isnan(power) else f"{power:.2f}"
        mark = " **above**" if power > LIMIT else ""
        cells = " | ".join(f"{s:.3f}" for s in seconds)
        sys.stdout.write(f"| {stage} | {cells} | {shown}{mark} |\n")
    sys.stdout.write(f"\nUnits: {', '.join(map(str, units))}.\n")
    sys.stdout.flush()


def main() -> None:
    """Parse the options, and measure."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.stages")
    parser.add_argument("series", nargs="*", help=f"some of {[*SERIES]}; default: all")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        n_horizon, n_node, n_fault = json.loads(options.one)
        sys.stdout.write(json.dumps(measure((n_horizon, n_node, n_fault))) + "\n")
        return
    for series in options.series or SERIES:
        print_table(series)


if __name__ == "__main__":
    main()
