"""Steps along the links of a lattice graph, against rounds of asking all neighbours."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import geosurf as gs
from geosurf.kernels.sheets.smooth_surface import steps_from
from geosurf.sheets.lattice import solve

N = 5


@st.composite
def graphs(draw):
    """Neighbours of the nodes of a lattice, some links of which are cut; and some nodes."""
    node = np.arange(N * N).reshape(N, N)
    east, north = np.full((N, N), -1), np.full((N, N), -1)
    east[:, :-1], north[:-1] = node[:, 1:], node[1:]
    cut = np.array(draw(st.lists(st.booleans(), min_size=2 * N * N, max_size=2 * N * N)))
    east[cut[: N * N].reshape(N, N)] = -1
    north[cut[N * N :].reshape(N, N)] = -1
    some = np.array(draw(st.lists(st.integers(0, 5), min_size=N * N, max_size=N * N))) == 0
    return east.ravel(), north.ravel(), some


def rounds(east, north, start, longest):
    """Steps of all nodes, the slow way."""
    steps = np.where(start, 0, longest)
    for _ in range(N * N):
        for to in (east, north):
            for a, b in enumerate(to):
                if b >= 0:
                    steps[a], steps[b] = min(steps[a], steps[b] + 1), min(steps[b], steps[a] + 1)
    return steps


@settings(max_examples=50, deadline=None)
@given(graphs(), st.sampled_from([2, 4, N * N + 1]))
def test_steps_are_those_of_asking_in_rounds(graph, longest):
    east, north, start = graph
    assert (steps_from(east, north, start, longest) == rounds(east, north, start, longest)).all()


def test_no_node_of_a_sheet_that_is_asked_for_is_the_neighbour_of_two(monkeypatch):
    """In one direction: else one of the two would be forgotten, and steps counted wrongly."""
    asked = []

    def watched(east, north, start, longest):
        for to in (east, north):
            assert np.bincount(to[to >= 0]).max(initial=0) <= 1
        found = steps_from(east, north, start, longest)
        asked.append((found < longest).sum())
        return found

    monkeypatch.setattr(solve, "steps_from", watched)
    world = gs.synthetic.torn("normal", n=31)
    gs.tear_horizon(world.horizons["Top"], world.faults)
    n_grid = len(asked)
    gs.tear_horizon(
        world.truth["scattered"](900), world.faults, name="Top", trim=0.5, positive="up"
    )
    assert 0 < n_grid < len(asked)
    assert sum(asked) > 100
