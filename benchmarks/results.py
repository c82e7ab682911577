"""What results cost next to the model they are of: ``python -m benchmarks.results``.

A user asks for volumes, tables and the certificate, not for the model. Each model is built in a
process of its own, so that its peak memory is its own; times are of this process, after the same
steps on a small model have loaded all kernels. Then single inputs are changed, and the volumes of
the changed model are compared with those of a model built anew.

==============  ================================================================
block           2 horizons of 401 x 401 nodes, 1 fault
five horizons   5 of 401 x 401, 3 faults
ten horizons    10 of 1001 x 1001, 10 faults
thirty          30 of 301 x 301, 40 faults
torn horizons   3 of 1001 x 1001, torn at 2 faults; tears do not count
changes         10 of 401 x 401, 5 faults: one input changes
many units      30 of 301 x 301, 20 faults that cross 20 others; only if named
==============  ================================================================

Ratios are of wall times, then of processor times, which count both threads. On a machine that
others use, read the latter.

``--cores`` compares one thread with two: wall times of each model, in processes in turn. It says
nothing on a machine that others use.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import geosurf as gs
from geosurf.synthetic.world import make_fault, make_horizon

MODELS = {
    "block": (2, 401, 1),
    "five horizons": (5, 401, 3),
    "ten horizons": (10, 1001, 10),
    "thirty": (30, 301, 40),
    "torn horizons": (3, 1001, 2),
    "many units": (30, 301, 20, 20),
}
TORN = "torn horizons"
CHANGES = "changes"
DEFAULT = [*[name for name in MODELS if name != "many units"], CHANGES]
ROUNDS = 5  # of changes in one process
SIDE, SHIFT = 10_000.0, (0.0, 0.0, 0.0)
Inputs = tuple[dict[str, Any], dict[str, Any], tuple[float, ...]]


def inputs_of(n_horizon: int, n_node: int, n_fault: int, n_across: int = 0) -> Inputs:
    """Bent horizons 100 m apart, faults that cross them from south to north, and a box.

    `n_across` more faults run from west to east.
    """
    box = (100.0, SIDE - 100.0, 100.0, SIDE - 100.0, -1300.0 - 100.0 * n_horizon, -700.0)
    whole = (0.0, SIDE, 0.0, SIDE, *box[4:])

    def level(k: int) -> Callable[[Any, Any], Any]:
        """Elevation of a horizon."""
        return lambda x, y: (
            -1000.0 - 100.0 * k + 0.02 * x
            + 20.0 * np.sin(x / 1700.0 + 0.3 * k) * np.cos(y / 1300.0 + 0.1 * k)
        )  # fmt: skip

    horizons = {
        f"H{k:02d}": make_horizon(f"H{k:02d}", whole, n_node, level(k), SHIFT)
        for k in range(n_horizon)
    }
    faults = {}
    z, y = np.meshgrid(np.linspace(-5200.0, -300.0, 21), np.linspace(-200.0, SIDE + 200.0, 41))
    for i in range(n_fault):
        x = (i + 1) * SIDE / (n_fault + 1) + 60.0 * np.sin(y / 1500.0 + i)
        x = x + (z + 1500.0) / math.tan(math.radians(70.0))
        faults[f"F{i}"] = make_fault(f"F{i}", x, y, z, SHIFT)
    for i in range(n_across):
        x = (i + 1) * SIDE / (n_across + 1) + 60.0 * np.sin(y / 1300.0 + i)
        x = x + (z + 1500.0) / math.tan(math.radians(80.0))
        faults[f"G{i}"] = make_fault(f"G{i}", y, x, z, SHIFT)
    return horizons, faults, box


def clock(run: Callable[[], Any]) -> dict[str, float]:
    """Wall and processor seconds of a call."""
    wall, cpu = time.perf_counter(), time.process_time()
    run()
    return {"wall": time.perf_counter() - wall, "cpu": time.process_time() - cpu}


def peak() -> float:
    """Most memory that this process has had [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def measure(name: str) -> dict[str, Any]:
    """Times of one model, in this process."""
    small = gs.Scene(*inputs_of(2, 41, 1))
    _ = small.volumes, small.units.table
    small.check()

    if name == TORN:
        small = gs.Scene(*inputs_of(2, 41, 1), tear=True)
        small.check()

    horizons, faults, box = inputs_of(*MODELS[name])
    scene = gs.Scene(horizons, faults, box, tear=name == TORN)
    _ = [scene.surface(one) for one in scene.horizon_names] if name == TORN else ()
    found: dict[str, Any] = {"model": clock(lambda: scene.units)}
    found["volumes"] = clock(lambda: scene.volumes)
    found["memory"] = peak()
    found["table"] = clock(lambda: scene.units.table)
    found["certificate"] = clock(lambda: scene.check())
    found["memory, certificate"] = peak()
    found["units"] = len(scene.units)
    return found


def measure_changes() -> dict[str, Any]:
    """Times of models that differ in one input from one that is known."""
    horizons, faults, box = inputs_of(10, 401, 5)
    given = {"contacts": {"OWC": -1500.0}}
    scene = gs.Scene(horizons, faults, box, **given)
    moved = gs.TriSurface("F2", "fault", *_shifted(scene.surface("F2"), 50.0))

    deeper = horizons["H05"] - 3.0
    deeper.attrs = dict(horizons["H05"].attrs)
    changes = {
        "a moved contact": {"contacts": {"OWC": -1510.0}},
        "another column": {"column": {"H03": "erosional"}},
        "a moved fault": {"faults": {"F2": moved}},
        "a moved horizon": {"horizons": {"H05": deeper}},
    }

    # each change from the same scene; the first round loads kernels
    rounds = []
    for _ in range(ROUNDS + 1):
        scene = gs.Scene(horizons, faults, box, **given)
        found: dict[str, Any] = {"all of it": clock(lambda: scene.volumes)}  # noqa: B023 - at once
        for what, change in changes.items():
            other = scene.replace(**change)
            found[what] = clock(lambda: other.volumes)  # noqa: B023 - called at once

        # then curves of one pair of surfaces, of which one has moved
        for what, pair in (("fault", ("H03", "F2")), ("horizon", ("H05", "F1"))):
            other = scene.replace(**changes[f"a moved {what}"])
            found[f"one pair of a moved {what}"] = clock(
                lambda: other.curves_between(*pair)  # noqa: B023 - called at once
            )
        rounds.append(found)
    return {
        what: {
            kind: float(np.median([found[what][kind] for found in rounds[1:]]))
            for kind in ("wall", "cpu")
        }
        for what in rounds[0]
    }


def _shifted(fault: gs.TriSurface, east: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a fault, moved east [m]."""
    return fault.vertices + np.array([east, 0.0, 0.0]), fault.triangles


def in_child(name: str, n_thread: int | None = None) -> dict[str, Any]:
    """What `measure` finds in a process of its own, with the usual number of threads or another."""
    command = [sys.executable, "-m", "benchmarks.results", "--one", name]
    threads = {} if n_thread is None else {"GEOSURF_THREADS": str(n_thread)}
    env = {**os.environ, **threads}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=env)
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def print_tables(names: list[str], repeat: int) -> None:
    """Print one row per model: medians of the wall times, ratios, and the largest memory."""
    print(
        "| model | units | model [s] | volumes [s] | model and volumes / model | table [s] | "
        "certificate [s] | certificate / model | processor: model [s] | certificate / model | "
        "peak memory [MB] | with certificate |"
    )
    print("|---" * 12 + "|")
    for name in (one for one in names if one != CHANGES):
        runs = [in_child(name) for _ in range(repeat)]
        of, cpu = (
            {
                key: float(np.median([run[key][kind] for run in runs]))
                for key in ("model", "volumes", "table", "certificate")
            }
            for kind in ("wall", "cpu")
        )
        whole = (of["model"] + of["volumes"]) / of["model"]
        print(
            f"| {name} | {runs[0]['units']} | {of['model']:.3f} | {of['volumes']:.3f} | "
            f"{whole:.2f} | {of['table']:.3f} | {of['certificate']:.2f} | "
            f"{of['certificate'] / of['model']:.1f} | {cpu['model']:.3f} | "
            f"{cpu['certificate'] / cpu['model']:.1f} | {max(r['memory'] for r in runs):.0f} | "
            f"{max(r['memory, certificate'] for r in runs):.0f} |", flush=True,
        )  # fmt: skip
    if CHANGES in names:
        runs = [in_child(CHANGES) for _ in range(repeat)]
        print(
            "\n| change, ten horizons of 401 x 401, five faults | time [s] | of all | "
            "processor [s] | of all |"
        )
        print("|---|---|---|---|---|")
        for what in runs[0]:
            shares = []
            for kind in ("wall", "cpu"):
                seconds, whole = (
                    float(np.median([run[one][kind] for run in runs]))
                    for one in (what, "all of it")
                )
                shares.append((seconds, 100.0 * seconds / whole))
            (wall, share), (cpu_time, of_processor) = shares
            print(
                f"| {what} | {wall:.4f} | {share:.1f} % | {cpu_time:.4f} | {of_processor:.1f} % |"
            )


def print_cores(names: list[str], repeat: int) -> None:
    """Print one row per model: medians of the wall times in one thread and in two."""
    print(
        "| model | units | model, one thread [s] | two [s] | times as fast | "
        "certificate, one thread [s] | two [s] | times as fast | memory, one thread [MB] | two |"
    )
    print("|---" * 10 + "|")
    for name in (one for one in names if one != CHANGES):
        runs = [(in_child(name, 1), in_child(name, 2)) for _ in range(repeat)]
        cells = []
        for key in ("model", "certificate"):
            one, two = (float(np.median([run[k][key]["wall"] for run in runs])) for k in (0, 1))
            cells += [f"{one:.3f}", f"{two:.3f}", f"{one / two:.2f}"]
        cells += [f"{max(run[k]['memory, certificate'] for run in runs):.0f}" for k in (0, 1)]
        print(f"| {name} | {runs[0][0]['units']} | {' | '.join(cells)} |", flush=True)


def main() -> None:
    """Parse the options, and measure."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.results")
    parser.add_argument(
        "models", nargs="*", help=f"some of {[*MODELS, CHANGES]}; default: {DEFAULT}"
    )
    parser.add_argument("--repeat", type=int, default=3, help="runs of each model (default: 3)")
    parser.add_argument("--cores", action="store_true", help="compare one thread with two")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        found = measure_changes() if options.one == CHANGES else measure(options.one)
        print(json.dumps(found))
        return
    table = print_cores if options.cores else print_tables
    table(options.models or DEFAULT, options.repeat)


if __name__ == "__main__":
    main()
