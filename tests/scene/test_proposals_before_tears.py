"""Proposals for faults are those for the faults as given: tears change none, and none is torn."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import InputError
from geosurf.faults.rules import Rule
from geosurf.faults.truncate import past_mains
from tests.planes import between

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")


@pytest.fixture(scope="module")
def field():
    """Two horizons 80 m apart; F1 is too short for both, and F2 stops short of F1."""
    world = gs.synthetic.torn("normal", n=41)
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


def test_a_fault_that_a_tear_makes_longer_is_cut_by_its_rule_again():
    world = gs.synthetic.torn("normal", n=61)
    top, (fault,) = world.horizons["Top"], world.faults.values()
    z = np.concatenate([line[:, 2] for line in world.truth["cutoffs"].values()])
    f1 = between(gs.triangulate_fault(fault, name="F1"), z.min() - 150.0, z.max() + 150.0)
    # upright, in the footwall of F1, from 30 m beside its middle; 5 m above the horizon at most
    a, b, c = f1.vertices[:3]
    across = np.cross(b - a, c - a)[:2]
    across /= np.hypot(*across)
    near, far = (f1.vertices[:, :2].mean(axis=0) + across * distance for distance in (30.0, 400.0))
    at = [float(top.sel(easting=x, northing=y, method="nearest")) for x, y in (near, far)]
    low, high = min(at) - 60.0, max(at) + 5.0
    corners = [(*near, low), (*far, low), (*far, high), (*near, high)]
    f2 = gs.TriSurface("F2", "fault", corners, [[0, 1, 2], [0, 2, 3]])

    rules = {"F2": ("F1", "footwall", True)}
    scene = gs.Scene({"Top": top}, {"F1": f1, "F2": f2}, tear=2, truncations=rules)
    untorn = scene.replace(tear=None)
    *before, again = scene.fault_actions
    assert tuple(before) == untorn.fault_actions
    assert scene.truncations == rules
    assert (again.fault, again.main, again.keep) == ("F2", "F1", "footwall")
    assert again.dropped_area > 100.0
    (told,) = (one for one in scene.warnings if one.kind == "fault extended")
    assert (told.subject, "'start'" in str(told)) == ("F2", False)

    # nothing of it is beyond F1, and the model is closed
    kept, cut, _ = past_mains(scene.patches, {Rule("F2", "F1", "footwall"): ""})
    assert kept.all()
    assert not cut
    corners = scene.surface("F2").vertices[scene.surface("F2").triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(normals, axis=1).sum()
    assert area == pytest.approx(again.kept_area, rel=1e-9)
    assert scene.certificate.ok
