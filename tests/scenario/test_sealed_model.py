"""A sealed model made elsewhere as a scenario: its units, beside the regions of its file."""

from __future__ import annotations

import re

import numpy as np

import geosurf as gs
from geosurf.read.model3d import read_regions
from geosurf.scenario import read_scenario, run
from geosurf.scenario.build import point_inside, units_of_bodies

OUTPUT = """
[output]
views = []
formats = ["csv"]
"""

# a box of 2 x 2 x 2, halved by a level horizon; the walls are in two parts each
LEVELS = (0.0, 1.0, 2.0)


def write_model(path, *, kind="intraformational", regions=True, wall=2.0):
    """A Model3d of one horizon and six walls, with its two regions."""
    faces, names = [], []

    def add(name, kind_, corners):
        faces.append((name, kind_, corners))
        names.append(name)
        return len(faces)

    def side(name, fixed, value, low, high):
        a, b = [k for k in range(3) if k != fixed]
        corners = []
        for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
            p = [0.0, 0.0, 0.0]
            p[fixed], p[a], p[b] = value, (low[a], high[a])[u], (low[b], high[b])[v]
            corners.append(p)
        return add(name, "boundary" if name != "H" else kind, corners)

    parts = {"below": [], "above": []}
    horizon = side("H", 2, 1.0, (0, 0, 0), (2, 2, 2))
    for layer, (low, high) in {"below": LEVELS[:2], "above": LEVELS[1:]}.items():
        bounds = (0, 0, low), (2, 2, high)
        for k, name in ((0, "west"), (1, "south")):
            parts[layer].append((side(name, k, 0.0, *bounds), 1 if k == 1 else -1))
        for k, name in ((0, "east"), (1, "north")):
            parts[layer].append((side(name, k, wall, *bounds), -1 if k == 1 else 1))
    parts["below"] += [(side("bottom", 2, 0.0, (0, 0, 0), (2, 2, 2)), -1), (horizon, 1)]
    parts["above"] += [(side("top", 2, 2.0, (0, 0, 0), (2, 2, 2)), 1), (horizon, -1)]
    order = list(dict.fromkeys(names))
    ranked = sorted(range(len(faces)), key=lambda i: order.index(names[i]))
    number = {old + 1: new + 1 for new, old in enumerate(ranked)}
    lines = ["GOCAD Model3d 1", *(f"TSURF {name}" for name in order)]
    for new, old in enumerate(ranked):
        lines.append(f"TFACE {new + 1} {faces[old][1]} {faces[old][0]}")
    for layer, listed in parts.items() if regions else ():
        signed = " ".join(f"{'+' if way > 0 else '-'}{number[i]}" for i, way in listed)
        lines += [f"REGION 9 {layer}  ", f"  {signed} 0"]
    lines.append("END")
    vertex = 0
    for name in order:
        lines += ["GOCAD TSurf 1", "HEADER {", f"name:{name}", "}"]
        for old in ranked:
            if names[old] == name:
                lines.append("TFACE")
                for x, y, z in faces[old][2]:
                    vertex += 1
                    lines.append(f"VRTX {vertex} {x} {y} {z}")
                a, b, c, d = range(vertex - 3, vertex + 1)
                lines += [f"TRGL {a} {b} {c}", f"TRGL {a} {c} {d}"]
        lines.append("END")
    path.write_text("\n".join(lines) + "\n")
    return path


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


def test_bodies_are_identified_by_a_point_inside():
    world = gs.synthetic.graben(n=5)
    units = gs.Scene(world.horizons, world.faults, world.box).units
    bodies = {name: unit.vertices[unit.triangles] for name, unit in units.items()}
    turned = {name: corners[::-1, ::-1] for name, corners in bodies.items()}
    assert units_of_bodies(bodies, units) == {name: name for name in units}
    assert units_of_bodies(turned, units) == {name: name for name in units}
    _, east, *others = world.box
    odd = {
        "beside the model": body(east + 1, east + 9, *others),
        "a lid alone": body(*world.box)[-2:],
        "nothing": np.empty((0, 3, 3)),
    }
    assert units_of_bodies(odd, units) == dict.fromkeys(odd, "")


def test_a_body_around_another_is_another_unit():
    """The longest way inside: not the middle of the outer one, where the inner one is."""
    shell = np.concatenate([body(0, 9, 0, 9, 0, 9), body(2, 7, 2, 7, 1, 7)])
    assert point_inside(shell)[2] == 8.0
    assert point_inside(body(2, 7, 2, 7, 1, 7))[2] == 4.0
