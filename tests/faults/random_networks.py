"""Random fault networks: every proposal of every round ends accepted or dropped, without exception.

python -m tests.faults.random_networks 78 --seed 3      # one network of 78 pieces
python -m tests.faults.random_networks 12 --many 20     # twenty of a dozen pieces each
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter

import numpy as np

from geosurf import Scene, TriSurface, read_fault

BOX = (0.0, 10_000.0, 0.0, 10_000.0, -3000.0, 0.0)
SPREAD = 1.4  # half the length of pieces, in their mean distance


def piece(rng, name, size, n=4):
    """A wavy piece of a fault: strike near one of two directions, dip 35 to 145 degrees."""
    strike = np.radians(rng.choice([20.0, 75.0]) + rng.normal(0, 12))
    dip = np.radians(rng.uniform(35, 145))
    along = np.array([np.sin(strike), np.cos(strike), 0.0])
    down = np.array([np.cos(strike) * np.cos(dip), -np.sin(strike) * np.cos(dip), -np.sin(dip)])
    middle = np.array([rng.uniform(0, 10_000), rng.uniform(0, 10_000), rng.uniform(-2500, -500)])
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    half = size * rng.uniform(0.5, 1.5)
    x = middle + half * u[..., None] * along + rng.uniform(500, 2200) * v[..., None] * down
    x = x + rng.normal(0, 0.01 * half) * np.sin(2.0 * u[..., None]) * np.cross(along, down)
    node = np.arange(n * n).reshape(n, n)
    a, b, c, d = (
        part.ravel() for part in (node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1])
    )
    t = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return TriSurface(name, "fault", x.reshape(-1, 3), t)


def network_of(n_piece, seed):
    """A scene with some pieces, so many that each meets or nearly meets a few others."""
    rng = np.random.default_rng(seed)
    size = SPREAD * 10_000 / np.sqrt(n_piece)
    faults = {f"F{k:02d}": piece(rng, f"F{k:02d}", size) for k in range(n_piece)}
    return Scene({}, faults, BOX)


def network_of_files(paths):
    """A scene with the faults of some files, in the upper 15 km of their bounds."""
    faults = {name.rsplit("/", 1)[-1]: read_fault(name) for name in paths}
    bounds = np.array([fault.bounds for fault in faults.values()])
    low, high = bounds[:, ::2].min(axis=0), bounds[:, 1::2].max(axis=0)
    return Scene({}, faults, (low[0], high[0], low[1], high[1], -15_000.0, 500.0))


def assert_all_decided(scene, trial):
    """No proposal is left; the scene has all that was accepted; its faults can be built."""
    decided = [one.row.subject for one in trial.decisions]
    assert len(decided) == len(set(decided))
    assert all(one.reason for one in trial.decisions)
    left = trial.scene.propose_fault_network().rows
    assert {row.subject for row in left if row.changes} <= set(decided)
    for one in trial.decisions:
        row, rules = one.row, trial.scene.truncations.get(one.row.fault, ())
        if row.proposal == "extend":
            assert (row.side in trial.scene.extend.get(row.fault, ())) == one.accepted
        else:
            rule = (row.other, row.keep, row.proposal != "truncate")
            assert (rule in rules) == one.accepted
    for name in scene.fault_names:
        assert trial.scene.surface(name).n_triangle > 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pieces", type=int)
    parser.add_argument("--many", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--files", nargs="*")
    wanted = parser.parse_args()
    for seed in range(wanted.seed, wanted.seed + wanted.many):
        files, start = wanted.files, time.perf_counter()
        scene = network_of_files(files) if files else network_of(wanted.pieces, seed)
        network = scene.propose_fault_network()
        trial = network.trial(scene)
        seconds = time.perf_counter() - start
        assert_all_decided(scene, trial)
        rounds = Counter((one.round, one.accepted) for one in trial.decisions)
        first = sum(row.changes for row in network.rows)
        sys.stdout.write(
            f"seed {seed}: {len(scene.fault_names)} faults, {len(network.rows)} rows, {first} "
            f"proposals at first, {len(trial.accepted)} accepted, {len(trial.dropped)} dropped in "
            f"{max((r for r, _ in rounds), default=0)} rounds, {seconds:.1f} s\n"
        )
        sys.stdout.flush()


if __name__ == "__main__":
    main()
