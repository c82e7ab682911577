"""A sealed model made elsewhere as a scenario: its units, beside the regions of its file."""

from __future__ import annotations

import re

import numpy as np

import geosurf as gs
from geosurf.read.model3d import read_regions
from geosurf.scenario import read_scenario, run
from geosurf.scenario.build import point_inside, units_of_bodies
from tests.strategies import grid

OUTPUT = """
[output]
views = []
formats = ["csv"]
"""


def write_model(path):
    """A box of 2 x 2 x 2, halved by a level horizon, as others write it: the lower region first."""
    level = grid("H", np.ones((2, 2)), spacing=4.0, corner=(-1.0, -1.0))
    gs.write(gs.Scene({"H": level}, {}, (0, 2, 0, 2, 0, 2)).units, path)
    text = re.sub(r"(?m)^\*geosurf\*.*\n", "", path.read_text())
    regions = r"(?s)(REGION \d+) above_H(.*?)(REGION \d+) below_H(.*?)(END\n)"
    path.write_text(re.sub(regions, r"\3 below\4\1 above\2\5", text, count=1))


def scenario(folder, more=""):
    path = folder / "scenario.toml"
    path.write_text(f'[model]\nfile = "model.ml"\n{more}{OUTPUT}')
    return path


def test_a_small_model_has_its_units_and_the_report_its_regions(tmp_path):
    write_model(tmp_path / "model.ml")
    assert read_regions(tmp_path / "model.ml") == {"below": 4.0, "above": 4.0}
    outcome = run(read_scenario(scenario(tmp_path)), tmp_path / "out", pictures=False)
    assert outcome.certificate.ok
    assert outcome.scene.box == (0.0, 2.0, 0.0, 2.0, 0.0, 2.0)
    assert {u.name: u.volume for u in outcome.scene.units.values()} == {"above H": 4, "below H": 4}
    page = (tmp_path / "out" / "report" / "index.html").read_text(encoding="utf-8")
    assert "Regions of the input file and the units" in page
    section = page.partition("Regions of the input file")[2].partition("Pictures")[0]
    assert section.count(">0.0e+00<") == 2
    # both volumes are 4: only the place tells them apart
    for region, unit in (("above", "above H"), ("below", "below H")):
        assert re.search(rf"<td[^>]*>{region}</td>\s*<td[^>]*>{unit}</td>", section)


def body(*bounds):
    """Corners of the triangles around a box, in one piece."""
    return np.concatenate([w.vertices[w.triangles] for w in gs.build_walls(bounds)])


def test_bodies_are_identified_by_a_point_inside(graben):
    units = graben.units
    bodies = {name: unit.vertices[unit.triangles] for name, unit in units.items()}
    turned = {name: corners[::-1, ::-1] for name, corners in bodies.items()}
    assert units_of_bodies(bodies, units) == {name: name for name in units}
    assert units_of_bodies(turned, units) == {name: name for name in units}
    _, east, *others = graben.box
    odd = {
        "beside the model": body(east + 1, east + 9, *others),
        "a lid alone": body(*graben.box)[-2:],
        "nothing": np.empty((0, 3, 3)),
    }
    assert units_of_bodies(odd, units) == dict.fromkeys(odd, "")


def test_a_body_around_another_is_another_unit():
    """The longest way inside: not the middle of the outer one, where the inner one is."""
    shell = np.concatenate([body(0, 9, 0, 9, 0, 9), body(2, 7, 2, 7, 1, 7)])
    assert point_inside(shell)[2] == 8.0
    assert point_inside(body(2, 7, 2, 7, 1, 7))[2] == 4.0
