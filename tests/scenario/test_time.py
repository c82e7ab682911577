"""Scenarios in time: read, turned into depth, and varied."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs

TOML = """
positive = "down"
length_unit = "ms"
time = "two-way"
{velocity}
[tear]

[[horizons]]
name = "Top"
file = "top.poi"

[[faults]]
name = "F1"
file = "F1.ts"

[[contacts]]
name = "OWC"
elevation_m = -1700.0

[[uncertain]]
kind = "velocity factor"
of = ["above Top"]
normal = [1.0, 0.01]
"""
VELOCITY = '[velocity]\n"above Top" = 1950.0\nelsewhere = {v0 = 1500.0, k = 0.4}'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    world, folder = gs.synthetic.torn("normal", n=41), tmp_path_factory.mktemp("time")
    rows = (f"{x} {y} {-z}" for x, y, z in world.truth["points"])
    (folder / "top.poi").write_text("\n".join(rows) + "\n999.0 999.0 999.0\n")
    fault = gs.triangulate_fault(world.faults["F1"], name="F1")
    lines = ["GOCAD TSurf 1", "HEADER {", "name:F1", "}", "TFACE"]
    lines += [f"VRTX {k} {x} {y} {-z}" for k, (x, y, z) in enumerate(fault.vertices, 1)]
    lines += ["TRGL {} {} {}".format(*t) for t in fault.triangles + 1]
    (folder / "F1.ts").write_text("\n".join([*lines, "END", ""]))
    return folder


def test_a_scenario_in_time_is_the_scene_in_depth_and_its_ensemble(folder):
    (folder / "s.toml").write_text(TOML.format(velocity=VELOCITY))
    scene = gs.run_scenario(folder / "s.toml", folder / "out")
    points = gs.read_points(folder / "top.poi", positive="down", length_unit="m")
    fault = gs.read_fault(folder / "F1.ts", positive="down", length_unit="m")
    found = points.elevation.values
    given = gs.Scene(
        {"Top": np.column_stack([points.easting, points.northing, found])},
        {"F1": (fault.vertices, fault.triangles)},
        time="two-way", positive="up", length_unit="ms", tear=True,
        velocity={"above Top": 1950.0, "elsewhere": {"v0": 1500.0, "k": 0.4}},
    )  # fmt: skip
    assert scene.surface("Top").bounds[4:] == pytest.approx(given.surface("Top").bounds[4:])
    assert set(scene.units) >= {"above Top above OWC"} or scene.contacts
    ensemble = gs.run_ensemble(folder / "s.toml", 2, workers=1)
    assert len(set(ensemble.data.drawn.values.ravel().tolist())) == 2


def test_time_and_velocity_belong_together(folder):
    (folder / "no.toml").write_text(TOML.format(velocity=""))
    with pytest.raises(gs.errors.ScenarioError, match="belong together"):
        gs.run_scenario(folder / "no.toml", folder / "out")


def test_tops_of_a_scenario_give_its_velocities(folder):
    rows = ["well,horizon,easting,northing,elevation"]
    rows += [f"W{x},Top,{x},500,{z}" for x, z in ((150, -1700.0), (850, -1790.0))]
    (folder / "tops.csv").write_text("\n".join([*rows, ""]))
    velocity = '[tops]\nfile = "tops.csv"\npositive = "up"\nlength_unit = "m"\n'
    velocity += '[velocity]\nwells = "tops"\nelsewhere = 2500.0'
    (folder / "t.toml").write_text(TOML.partition("[[uncertain]]")[0].format(velocity=velocity))
    scene = gs.run_scenario(folder / "t.toml", folder / "out_t")
    np.testing.assert_allclose(scene.misfit().misfit.values, np.zeros(2), atol=1e-6)
