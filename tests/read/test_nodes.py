"""Grids as files have them, without xarray, against the DataArrays of the same files."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from geosurf import read_horizon, triangulate_horizon
from geosurf.read import read_nodes

HEAD = "-996 3 10 -20\n500 530 0 40\n4 {} 500 0\n0 0 0 0 0 0 0\n"
VALUES = "1600 1610 1620 1630\n1605 9999900.0 1625 1635\n1611 1612 1613 1614\n"
CODE = """
import sys
from geosurf.read import read_nodes
from geosurf.triangulate import triangulate_horizon
print(triangulate_horizon(read_nodes(sys.argv[1], positive="down")).n_triangle)
print(*sys.modules)
"""


@pytest.fixture(params=["0", "30", "90"])
def path(request, tmp_path) -> Path:
    file = tmp_path / "top.irap"
    file.write_text(HEAD.format(request.param) + VALUES)
    return file


def test_nodes_are_those_of_the_array(path):
    nodes, array = read_nodes(path, positive="down"), read_horizon(path, positive="down")
    assert (nodes.dims, nodes.shape, nodes.name) == (array.dims, array.shape, array.name)
    assert nodes.attrs == array.attrs
    for key in ("easting", "northing"):
        assert nodes.coords[key].dims == array.coords[key].dims
        np.testing.assert_array_equal(nodes.coords[key].values, array.coords[key].values)
    one, two = triangulate_horizon(nodes), triangulate_horizon(array)
    assert one.vertices.tobytes() == two.vertices.tobytes()
    assert one.triangles.tobytes() == two.triangles.tobytes()


def test_small_grids_need_no_xarray(path):
    said = subprocess.run(
        [sys.executable, "-c", CODE, path],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"}, check=True, capture_output=True, text=True,
    ).stdout.split()  # fmt: skip
    assert int(said[0]) > 5
    assert "geosurf.triangulate.horizon" in said
    assert not {"xarray", "pandas"} & set(said)
