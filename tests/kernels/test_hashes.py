"""Hashes spread what models are full of: a table of grid nodes must not be one long chain."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from geosurf.kernels.exact.constructed_points import LPI, TPI, hash_of_name, hash_of_row
from geosurf.kernels.meshes.mesh import weld

PLACES = {
    "map": [(float(i), float(j), 0.0) for i in range(64) for j in range(64)],
    "cube": [
        (float(i), float(j), float(k)) for i in range(12) for j in range(12) for k in range(12)
    ],
    "metres": [(25.0 * i, 12.5 * j, -1600.0) for i in range(64) for j in range(64)],
    "line": [(1.0 * i, 2.0 * i, 0.5 * i) for i in range(4096)],
    "centred": [(i - 31.5, j - 31.5, -3.0) for i in range(64) for j in range(64)],
    "shrunk": [(i * 2.0**-70, j * 2.0**60, 0.0) for i in range(64) for j in range(64)],
}
NAMES = {
    "edges through planes": [(LPI, a, a + 1, c) for a in range(64) for c in range(64)],
    "separate triangles": [(LPI, 3 * a, 3 * a + 1, c) for a in range(64) for c in range(64)],
    "planes in a face": [(TPI, 7, a, b) for a, b in itertools.combinations(range(91), 2)],
}


def chain(hashes) -> float:
    """Mean number of entries that are passed by until one is found, a quarter of a table full."""
    count = np.bincount(np.array(hashes) & 0x3FFF, minlength=0x4000)
    passed = waiting = 0
    for here in np.tile(count, 2).tolist():  # twice around: chains may cross the end
        waiting = max(0, waiting + here - 1)
        passed += waiting
    return passed / 2 / len(hashes)


@pytest.mark.parametrize("kind", PLACES)
def test_places(kind):
    x = np.array(PLACES[kind])
    assert chain([hash_of_row(x, i) for i in range(len(x))]) < 0.5
    assert hash_of_row(x, 0) == hash_of_row(np.where(x == 0.0, -0.0, x), 0)


@pytest.mark.parametrize("kind", NAMES)
def test_names(kind):
    assert chain([hash_of_name(*name) for name in NAMES[kind]]) < 0.5


@pytest.mark.parametrize("kind", PLACES)
def test_welding_finds_what_is_equal(kind):
    x = np.array(PLACES[kind])
    number, count = weld(np.concatenate([x, -x[::-1], x + 0.0]))
    distinct = {tuple(row) for row in np.concatenate([x, -x + 0.0]).tolist()}
    assert count == len(distinct)
    assert number[: len(x)].tolist() == list(range(len(x))) == number[-len(x) :].tolist()
