"""What people hand over by mistake: numbers that are none, arrays that change later."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import InputError
from geosurf.render.views import check_exaggeration
from geosurf.synthetic import tilted_planes

NO_NUMBERS = ["25", [25.0], np.nan, np.inf, True, -1.0]
CALLS = {
    "voxel_size": lambda s, v: gs.intersect_surfaces(s, voxel_size=v),
    "reach": lambda s, v: gs.propose_network(
        gs.rebuild_surfaces([x for x in s if x.role == "fault"]), reach=v
    ),
    "exaggeration": lambda s, v: check_exaggeration(v, (0.0, 9.0, 0.0, 9.0, 0.0, 1.0)),
}


@pytest.fixture(scope="module")
def surfaces():
    world = tilted_planes()
    return list(gs.Scene(world.horizons, world.faults, world.box).surfaces)


@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_number_is_refused_by_name(name, value, surfaces):
    with pytest.raises(InputError, match=rf"^{name} is "):
        CALLS[name](surfaces, value)


def test_a_surface_does_not_change_with_the_arrays_it_was_made_of():
    vertices = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
    triangles = np.array([[0, 1, 2]])
    one = gs.TriSurface("A", "surface", vertices, triangles)
    before = one.vertices.tobytes(), one.triangles.tobytes()
    vertices[:], triangles[:] = 9.0, 0
    assert (one.vertices.tobytes(), one.triangles.tobytes()) == before


def test_arrays_that_nobody_can_write_to_are_not_copied():
    triangles = np.array([[0, 1, 2]])
    triangles.flags.writeable = False
    vertices = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
    assert np.shares_memory(gs.TriSurface("A", "surface", vertices, triangles).triangles, triangles)
