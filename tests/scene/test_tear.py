"""`Scene(tear=...)`: from data to a model in one step."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from tests import laws

BOX = (100.0, 1400.0, 100.0, 1400.0, -2000.0, -1600.0)


@pytest.fixture(scope="module")
def world():
    return gs.synthetic.torn("normal", n=61)


def test_it_is_the_sheet_of_tear_horizon(world):
    scene = gs.Scene(world.horizons, world.faults, tear=2)
    faults = {name: gs.triangulate_fault(one, name=name) for name, one in world.faults.items()}
    sheet = gs.tear_horizon(world.horizons["Top"], faults, name="Top", trim=2)
    np.testing.assert_array_equal(scene.sheets["Top"].surface.vertices, sheet.surface.vertices)
    laws.assert_volumes_add_up(scene.units, scene.box)
    assert scene.coverage["Top"] > 0.99


def test_grids_points_and_files_are_taken_alike(world, tmp_path):
    grid, points = world.horizons["Top"], world.truth["points"]
    gs.write(grid, tmp_path / "top.nc")
    rows = "\n".join(" ".join(f"{v:.4f}" for v in row) for row in points)
    (tmp_path / "top.poi").write_text(rows + "\n999.0 999.0 999.0\n")
    volumes = []
    for top in (grid, tmp_path / "top.nc", points, tmp_path / "top.poi"):
        scene = gs.Scene({"Top": top}, world.faults, BOX, tear=True, positive="up")
        assert set(scene.sheets) == {"Top"}
        volumes.append(float(scene.volumes.sum()))
    assert volumes == pytest.approx([volumes[0]] * 4, rel=1e-9)


def test_a_scene_with_a_longer_fault_has_all_horizons_at_it(world):
    """The lower horizon leaves the fault, the upper one does not: both end on the longer one."""
    (given,) = (gs.triangulate_fault(one, name=name) for name, one in world.faults.items())
    top = world.horizons["Top"]
    lower = top - 60.0
    lower.attrs = top.attrs
    deepest = min(line[:, 2].min() for line in world.truth["cutoffs"].values()) - 60.0
    points = given.vertices.copy()
    normal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2]
    dip = np.cross(normal, [-normal[1], normal[0], 0.0])
    points += np.maximum(deepest + 8.0 - points[:, 2], 0.0)[:, None] * dip / dip[2]
    short = gs.TriSurface("F1", "fault", points, given.triangles)
    scene = gs.Scene({"Top": top, "Base": lower}, {"F1": short}, tear=3.5)
    with pytest.warns(gs.GeosurfWarning, match=r"'F1' ends before the cut-offs"):
        sheets = scene.sheets
    one, two = (sheet.faults[0].vertices for sheet in sheets.values())
    np.testing.assert_array_equal(one, two)
    assert scene.surface("F1").bounds[4] < short.bounds[4]
    assert len(scene.units) >= 3
    (longer,) = (w for w in scene.warnings if w.kind == "fault extended")  # not one more by sheet
    assert sheets["Base"].report.warnings[0].place == longer.place


def test_a_scene_without_faults_is_as_it_was(world):
    scene = gs.Scene(world.horizons, tear=True)
    assert scene.sheets == {}
    assert len(scene.units) == 2
