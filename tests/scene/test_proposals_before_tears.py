"""Proposals for faults are those for the faults as given: tears change none, and none is torn."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import InputError
from geosurf.scene import tearing as passed_faults
from tests.planes import between

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")


@pytest.fixture(scope="module")
def field():
    """Two horizons 80 m apart; F1 is too short for both, and F2 stops short of F1."""
    world = gs.synthetic.torn("normal", n=61)
    top, (fault,) = world.horizons["Top"], world.faults.values()
    whole = gs.triangulate_fault(fault, name="F1")
    z = np.concatenate([line[:, 2] for line in world.truth["cutoffs"].values()])
    horizons = {}
    for name, by in (("Top", 40.0), ("Base", -40.0)):
        horizons[name] = top + by
        horizons[name].attrs = top.attrs
    f1 = between(whole, z.min() - 20.0, z.max() + 20.0)
    a, b, c = f1.vertices[:3]
    normal = np.cross(b - a, c - a)

    # upright, across the strike of F1, from 30 m beside its middle
    middle, across = f1.vertices.mean(axis=0), normal[:2] / np.hypot(*normal[:2])
    near, far = (middle[:2] + across * distance for distance in (30.0, 600.0))
    low, high = z.min() - 10.0, z.max() + 10.0
    corners = [(*near, low), (*far, low), (*far, high), (*near, high)]
    f2 = gs.TriSurface("F2", "fault", corners, [[0, 1, 2], [0, 2, 3]])
    return horizons, {"F1": f1, "F2": f2}


def torn(scene):
    """How many horizons a scene has torn."""
    return sum(step.stage == "tear" and step.outcome == "ran" for step in scene.steps)


def test_tears_change_no_proposal_and_trials_tear_nothing(field):
    horizons, faults = field
    plain = gs.Scene(horizons, faults)
    scene = gs.Scene(horizons, faults, tear=2)
    network = plain.propose_fault_network()
    assert any(row.changes for row in network.rows)
    assert scene.propose_fault_network() == network
    expected, trial = network.trial(plain), network.trial(scene)
    assert trial.decisions == expected.decisions
    assert trial.accepted
    assert torn(scene) == torn(trial.scene) == 0

    # also once horizons are torn, which makes F1 longer
    assert scene.whole_surface("F1").n_vertex > scene.prepared_fault("F1").n_vertex
    count = torn(scene)
    assert scene.propose_fault_network() == network
    assert network.trial(scene).decisions == trial.decisions
    assert torn(scene) == count > 0
    np.testing.assert_array_equal(scene.prepared_fault("F1").vertices, faults["F1"].vertices)
    with pytest.raises(InputError, match="no fault is called 'Top'"):
        scene.prepared_fault("Top")


def test_a_scene_with_longer_faults_looks_for_passed_ones_and_states_its_rules(field, monkeypatch):
    """What no rule cuts; `test_tear.py` has the areas."""
    horizons, faults = field
    rule = {"F2": ("F1", "footwall", True)}
    untorn, scene = (gs.Scene(horizons, faults, tear=trim, truncations=rule) for trim in (None, 2))
    monkeypatch.setattr(passed_faults, "_area_beyond", lambda *_: 5.0)
    kinds = [(one.kind, one.subject) for one in (scene.sheets, scene.warnings)[1]]
    assert kinds.count(("fault passes another", "F2")) == 1
    assert scene.fault_actions == untorn.fault_actions
    assert scene.truncations == rule
    assert str(scene.fault_actions[-1]).endswith(" in its footwall kept")
