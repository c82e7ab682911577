"""Many layers: what a step costs for each of them does not grow with their number."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.results import inputs_of
from geosurf import Scene
from geosurf.carve import measures, zones


def test_values_spread_as_from_neighbour_to_neighbour():
    rng = np.random.default_rng(5)
    both = 0
    for _ in range(400):
        # cell 0 is the outside, which no link has
        n = int(rng.integers(2, 14))
        links = rng.integers(1, n + 1, (int(rng.integers(0, 25)), 2))
        links = links[links[:, 0] != links[:, 1]]
        values = rng.choice([0, 0, 0, 0, 1, -1], n + 1)
        values[0] = 0
        at_once, by_rounds = values.copy(), values.copy()
        zones._spread(at_once, links)
        zones._spread_by_rounds(by_rounds, links)
        assert np.array_equal(at_once, by_rounds)
        both += len(np.unique(by_rounds[values == 0])) == 3
    assert both > 50  # groups that meet both values occur


def test_a_stack_of_layers_takes_no_rounds(monkeypatch):
    monkeypatch.setattr(zones, "_spread_by_rounds", None)
    k = np.arange(1, 1000)
    values = np.zeros(1001, dtype=np.int64)
    values[400], values[401] = 1, -1
    zones._spread(values, np.stack([k, k + 1], axis=1)[k != 400])
    assert (values[1:401] == 1).all()
    assert (values[401:] == -1).all()


@pytest.fixture(scope="module")
def inputs():
    """Forty horizons, and two faults that end inside the lowest unit."""
    return inputs_of(40, 21, 2)


def test_only_faces_of_slits_are_measured_for_their_area(inputs, monkeypatch):
    asked, extent = [], measures.extent

    def recorded(pieces, face, some):
        asked.append((some.sum(), len(some)))
        return extent(pieces, face, some)

    monkeypatch.setattr(measures, "extent", recorded)
    units = Scene(*inputs).units
    assert [*units.report["slits"]] == ["F0", "F1"]
    [(few, every)] = asked
    assert few < 10 < every
