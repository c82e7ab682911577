"""Triangulated horizons are taken wherever triangulated faults are: arrays, surfaces and files."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import HorizonError, InputError, SurfaceError

WORLD = gs.synthetic.tilted_planes(n=5)


@pytest.fixture(scope="module")
def top() -> gs.TriSurface:
    grid = gs.triangulate_horizon(WORLD.horizons["Top"])
    return gs.TriSurface("Top", "horizon", grid.vertices, grid.triangles)


@pytest.fixture(scope="module")
def truth(top) -> np.ndarray:
    return gs.Scene({"Top": top}, WORLD.faults, WORLD.box).volumes.values


@pytest.mark.parametrize("kind", [tuple, list])
def test_vertices_and_triangles_build_the_same_model(top, truth, kind):
    mesh = kind((np.asarray(top.vertices), np.asarray(top.triangles)))
    scene = gs.Scene({"Top": mesh}, WORLD.faults, WORLD.box)
    assert scene.surface("Top").role == "horizon"
    np.testing.assert_array_equal(scene.volumes.values, truth)


@pytest.mark.parametrize("suffix", [".ts", ".vtp", ".vtu", ".obj", ".ply", ".stl"])
def test_files_of_meshes_build_the_same_model(top, truth, suffix, tmp_path):
    path = gs.write(top, tmp_path / f"Top{suffix}")[0]
    found = gs.read_horizon(path, name="Top")
    assert (found.role, found.name, found.n_triangle) == ("horizon", "Top", top.n_triangle)
    volumes = gs.Scene({"Top": path}, WORLD.faults, WORLD.box).volumes.values
    np.testing.assert_allclose(volumes, truth, rtol=1e-6)


def test_depths_in_feet_are_turned(top, truth):
    down = np.asarray(top.vertices) * (1.0, 1.0, -1.0 / 0.3048)
    words = {"positive": "down", "length_unit": "ft"}
    scene = gs.Scene({"Top": (down, top.triangles)}, WORLD.faults, WORLD.box, **words)
    np.testing.assert_allclose(scene.volumes.values, truth, rtol=1e-9)


@pytest.mark.parametrize(
    ("mesh", "error", "words"),
    [
        ([], SurfaceError, r"cannot use list of 0 as a mesh. Give \(vertices, triangles\)"),
        ((np.zeros((3, 3)), [[0, 1, 2]]), SurfaceError, "area"),
        (([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]]), SurfaceError, "3"),
        (("abc", [[0, 1, 2]]), InputError, "vertices"),
    ],
    ids=["empty", "flat", "no such vertex", "words"],
)
def test_meshes_that_cannot_be_used_are_refused(mesh, error, words):
    with pytest.raises(error, match=words):
        _ = gs.Scene({"Top": mesh}, {}, WORLD.box).surfaces


def test_a_mesh_is_not_simplified_and_says_so(top):
    with pytest.raises(HorizonError, match=r"simplifies grids only, not meshes"):
        gs.triangulate_horizon(top, tolerance=1.0)
    with pytest.raises(SurfaceError, match="positive up"):
        gs.triangulate_horizon(top, positive="down")
