"""How far off distrusted data are is seen where sheets reach them, and believed in wedges."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.passes import rebuild, solver_of
from geosurf.sheets.heights.state import BIN, Smear, Trims, distances, smear_of
from geosurf.sheets.lattice import picks
from geosurf.sheets.lattice.data import picks_of
from geosurf.sheets.lattice.picks import Noise
from geosurf.sheets.lattice.solve import lattice_graph, on_the_way, steps_to_known
from geosurf.sheets.mesh.finish import fault_surfaces
from tests.sheets.table import measure

SMALL = st.floats(0.0, 20.0)


@pytest.mark.parametrize("kind", ["Y", "acute X"])
def test_the_smear_of_a_grid_ends_where_its_window_does(kind):
    """A square window of one node reaches no datum farther than the diagonal of a cell."""
    world = gs.synthetic.torn(kind, 81)
    picks = picks_of(world.horizons["Top"], "Top")
    meshes = [mesh_in_frame(fault, picks.frame) for fault in fault_surfaces(world.faults)]
    spread = rebuild(
        solver_of(picks, meshes, Trims((2.0,) * len(meshes)), noise=0.0)
    ).evidence.smear.spread
    end = int(np.ceil(np.sqrt(2.0) / BIN))
    assert (spread[end:] < 0.1).all()
    assert (spread[: end - 1] > 0.3).all()


@given(st.lists(SMALL, min_size=1, max_size=12), st.floats(0.0, 5.0), st.floats(0.0, 5.0))
def test_nearer_data_and_noisier_ones_are_never_held_to_harder(spread, noise, signal):
    smear = Smear(np.sort(spread)[::-1])
    far = np.linspace(0.0, len(spread) * BIN + 1.0, 50)
    weight = smear.weight(far, Noise(0.0, None, signal))
    assert ((weight >= 0.0) & (weight <= 1.0)).all()
    assert (np.diff(weight) >= 0.0).all()
    most = 0.01
    noisy = smear.weight(far, Noise(noise, most, signal))
    assert (noisy <= most).all()
    assert (noisy >= np.minimum(weight, most)).all()  # what is noise is no smear
    assert (Smear(smear.spread + 1.0).weight(far, Noise(0.0, None, signal)) <= weight).all()


@given(st.lists(st.tuples(st.integers(0, 11), SMALL), max_size=60))
def test_spread_is_read_from_enough_data_and_never_smaller_nearer(found):
    far = np.array([0.25 * k for k, _ in found])
    misfit = np.array([m for _, m in found])
    smear = smear_of(far, misfit)
    enough = np.bincount([k for k, _ in found], minlength=1).max() >= 8
    assert (smear is None) == (not enough)
    if smear is not None:
        assert (np.diff(smear.spread) <= 0.0).all()
        assert smear.spread.max() <= misfit.max() / 1.645


def test_a_pick_is_as_far_as_its_nearest_fault():
    class Beside:
        def __init__(self, rows, far):
            self.rows, self.far = np.array(rows), np.array(far)

    rows, far = distances([Beside([4, 1], [2.0, 0.5]), Beside([1, 7], [0.25, 3.0])])
    assert rows.tolist() == [1, 4, 7]
    assert far.tolist() == [0.25, 2.0, 3.0]
    assert len(distances([])[0]) == 0


@given(
    st.lists(st.integers(0, 15), min_size=63, max_size=63),
    st.sets(st.integers(0, 62), max_size=62),
    st.integers(1, 5),
)
def test_what_is_on_the_way_starts_where_it_is_far_and_ends_at_data(cut, known, far_from_data):
    """Against searches from each node that is far from data, with links cut at random."""
    bits = np.where(np.array(cut) < 4, cut, 0)  # no link to the east 1, to the north 2
    graph = lattice_graph(np.arange(63), (7, 9), bits)
    steps = steps_to_known(graph, np.array([-1 if k in known else 0 for k in range(63)]))
    there = set()
    for node in np.flatnonzero(steps > far_from_data).tolist():
        away = steps_to_known(graph, np.where(np.arange(63) == node, -1, 0))
        there |= {node, *np.flatnonzero((away + steps == steps[node]) & (steps > 0)).tolist()}
    assert on_the_way(graph, steps, far_from_data).tolist() == sorted(there)


def test_a_wedge_hears_the_good_data_on_its_way(monkeypatch):
    """Four steps from trusted data, one that was right held nothing; a step more, and it did."""
    monkeypatch.setattr(picks, "FAINT", 0.0)  # third differences, as for data with noise
    world = gs.synthetic.torn("acute X", 81)
    worst = []
    for trim in (1.9, 2.0, 2.1):
        sheet = gs.tear_horizon(world.horizons["Top"], world.faults, name="Top", trim=trim)
        worst.append(max(measure(world, sheet, name).throw.max() for name in world.faults))
    assert max(worst) < 1.25 * min(worst)


@pytest.mark.parametrize("trim", [1.5, 2.0, 2.5])
@pytest.mark.parametrize("kind", ["acute Y", "acute X"])
def test_acute_wedges_are_met_whatever_the_trim(kind, trim):
    """The wider the trim, the fewer data are trusted in a wedge: those seen to be right help."""
    world = gs.synthetic.torn(kind, 81)
    sheet = gs.tear_horizon(world.horizons["Top"], world.faults, name="Top", trim=trim)
    for name in world.faults:
        found = measure(world, sheet, name)
        assert found.throw.mean() < 0.5
        assert found.throw.max() < 3.5
        assert found.variation == pytest.approx((1.0, 1.0), abs=0.03)
