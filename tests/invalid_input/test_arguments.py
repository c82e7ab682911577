"""What people hand over by mistake: numbers that are none, arrays that change later."""

from __future__ import annotations

import numpy as np

import geosurf as gs


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
