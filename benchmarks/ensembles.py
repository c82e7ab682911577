"""How long ensembles take: ``python -m benchmarks.ensembles throw|field|network [--n 20]``.

throw: one horizon pair of 201 x 201 nodes, one fault; its throw and an error of both horizons that
is correlated in the map are uncertain. field: the horizons and faults of Drogon, picked as points
and sticks; depth errors of all horizons and a contact are uncertain, and all horizons are torn
again in each realisation. network: the same with the proposed fault network, in which one fault
ends at another. Times are of this process and its workers, and include the base case.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import time
import warnings
from functools import partial
from typing import Any

import geosurf as gs
from geosurf.ensemble import ContactLevel, DepthError, Normal, Throw, Uniform, VelocityFactor
from geosurf.kernels.compile.jit import RUNNER

Case = tuple[gs.Scene, list[Any]]


def throw() -> Case:
    """Two horizons and one fault of the graben."""
    world = gs.synthetic.graben(n=201)
    horizons = {name: world.horizons[name] for name in ("Top", "Base")}
    scene = gs.Scene(horizons, {"F1": world.faults["F1"]}, world.box)
    error = DepthError(("Top", "Base"), sd=8.0, range=1200.0)
    return scene, [error, Throw("F1", Normal(60.0, 10.0))]


def field(apply: bool = False) -> Case:
    """Drogon from its points and sticks; with the fault network that is proposed, if applied."""
    from benchmarks.folders import drogon_folder
    from benchmarks.torn_fields import FIELDS

    horizons, faults, _ = FIELDS["Drogon points"](drogon_folder())
    names = tuple(horizons)
    scene = gs.Scene(horizons, faults, tear=True, contacts={"OWC": -1680.0})
    if apply:
        scene = scene.propose_fault_network().apply(scene)
    errors = [DepthError(name, sd=8.0, range=2000.0) for name in names]
    return scene, [*errors, ContactLevel("OWC", elevation=Uniform(-1690.0, -1670.0))]


def velocity() -> Case:
    """Drogon from its points and sticks, in time; velocities of its zones vary."""
    scene, _ = field()
    laws = {"elsewhere": {"v0": 1900.0, "k": 0.6}}
    scene = scene.replace(contacts=None, velocity=laws).in_time("two-way").replace(velocity=laws)
    return scene, [VelocityFactor("elsewhere", Normal(1.0, 0.03))]


CASES = {
    "throw": throw, "field": field, "network": partial(field, apply=True), "velocity": velocity,
}  # fmt: skip


def main() -> None:
    """Print time and user time of one ensemble."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", choices=tuple(CASES))
    parser.add_argument("--n", type=int, default=20)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--processes", action=argparse.BooleanOptionalAction)
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    # Workers find bytecode, as users' do: without it each compiles 450 files, half a second. The
    # first run of changed sources writes it.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    scene, uncertain = CASES[asked.case]()
    start = time.perf_counter()
    result = gs.run_ensemble(
        scene, asked.n, uncertain=uncertain, workers=asked.workers, processes=asked.processes
    ).data
    seconds = time.perf_counter() - start
    user = sum(resource.getrusage(who).ru_utime
               for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))  # fmt: skip
    failed, searched = int((result.status == 2).sum()), int((result.searched > 0).sum())
    cores, load = len(os.sched_getaffinity(0)), os.getloadavg()[0]
    kernels = "compiled by numba" if RUNNER.compiles else "frozen"
    sys.stdout.write(
        f"{asked.case}: {asked.n} realisations, {failed} failed, {searched} with a search, "
        f"{seconds:.1f} s, user {user:.1f} s, {cores} cores, load {load:.1f}, kernels {kernels}\n"
    )
    for reason in sorted(set(result.reason.values.tolist()) - {""}):
        sys.stdout.write(f"  {reason}\n")


if __name__ == "__main__":
    main()
