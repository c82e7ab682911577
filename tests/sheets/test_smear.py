"""How far off distrusted data are is seen where sheets reach them, and believed in wedges."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.heights.passes import rebuild, solver_of
from geosurf.sheets.heights.state import BIN, Trims
from geosurf.sheets.lattice import picks
from geosurf.sheets.lattice.data import picks_of
from geosurf.sheets.mesh.finish import fault_surfaces
from tests.sheets.table import measure


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
