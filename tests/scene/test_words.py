"""Words of the field, and depths in place of elevations, lead to what was meant."""

import pytest

import geosurf as gs
from geosurf.errors import InputError


@pytest.fixture(scope="module")
def scene():
    world = gs.synthetic.tilted_planes(n=5)
    return gs.Scene(world.horizons, world.faults, world.box)


@pytest.mark.parametrize(
    ("word", "rule"),
    [("unconformity", "erosional"), ("Erosion", "erosional"), ("onlap", "base"), ("bse", "base")],
)
def test_field_words_lead_to_the_rule(scene, word, rule):
    with pytest.raises(InputError, match=f"Did you mean '{rule}'"):
        scene.replace(column={"Base": word})


def test_depths_in_place_of_elevations_are_warned_of(scene):
    with pytest.warns(gs.GeosurfWarning, match="All points lie above the model") as caught:
        scene.replace().sample([[1000.0, 1500.0, 2100.0]])
    assert caught[0].filename == __file__
    assert [note.kind for note in scene.warnings] == []
