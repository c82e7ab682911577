"""Throw up to where faults meet: junctions, branches, and faults that cross near a horizon."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError, OpenUnitError
from geosurf.faults import lengthen_fault
from geosurf.sheets import tear as attempts
from geosurf.sheets.mesh import build, close
from geosurf.synthetic.torn_horizon import Fault
from tests.grids import gridded
from tests.planes import scenario_tables
from tests.sheets.junctions import KINDS, junction, misses
from tests.sheets.table import measure


@pytest.mark.parametrize("kind", KINDS)
def test_throw_is_right_up_to_a_junction(kind):
    """It was 0 there, or the junction was refused: the branch was traced on the wrong wall."""
    grid, faults, *truth = junction(kind, np.random.default_rng(2))
    sheet = gs.tear_horizon(grid, faults, name="H", trim=1.5)
    assert max(misses(sheet, *truth)) < 0.05


def test_a_link_may_go_around_the_end_of_a_branch():
    """It crosses the main fault on either side of the branch: throw was 0 at the junction."""
    grid, faults, *truth = junction("bent main fault", np.random.default_rng(13))
    sheet = gs.tear_horizon(grid, faults, name="H", trim=1.5)
    assert max(misses(sheet, *truth)) < 1e-9


def test_a_refusal_names_its_fault_and_the_place_is_drawn(tmp_path, monkeypatch):
    monkeypatch.setattr(build, "ROUNDS", 1)
    grid, faults, *_ = junction("straight main fault", np.random.default_rng(2))
    branch = faults["F3"]
    moved = branch.vertices - (3.0, 2.0, 0.0)  # it ends beside its main fault
    faults["F3"] = gs.TriSurface("F3", "fault", moved, branch.triangles)
    text = (
        "[tear]\ntrim_cells = 1.5\n[box]\n"
        "easting_m = [0, 4000]\nnorthing_m = [0, 3000]\nelevation_m = [-2000, -1400]\n"
    )
    text += scenario_tables(tmp_path, {"Top": grid}, faults)
    (tmp_path / "scenario.toml").write_text(text)
    monkeypatch.setattr(attempts, "TRIM_CHANGES", ())
    words = (
        r"could not be cut at faults 'F1', 'F3': 1 hole .*trims than 1.5 .* were tried\. Without"
    )
    with pytest.raises(gs.errors.GeometryError, match=words) as caught:
        gs.run_scenario(tmp_path / "scenario.toml", tmp_path / "out")
    assert caught.value.surfaces == ("Top", "F1", "F3")
    assert (tmp_path / "out" / "failure.png").stat().st_size > 10_000

    # the picture has the sheet, both faults and the rim, at a scale where the hole is seen
    seen, place = caught.value.close_up, caught.value.place
    assert {"Top", "F1", "F3"} <= {surface.name for surface in seen.surfaces}
    assert 0.02 < np.ptp(seen.rim, axis=(0, 1)).max() / (2.0 * seen.reach) < 0.5
    assert np.abs(seen.rim - place).max() < seen.reach
    data = np.concatenate([*seen.points.values()])
    assert len(data) > 4
    assert np.abs(data - place)[:, :2].max() <= seen.reach


# ---- A branch that cannot be torn up to its main fault says so, and a truncated one can.
@pytest.fixture(scope="module")
def acute():
    """A branch at 25 degrees that runs half a cell past its main fault, as interpreters draw it."""
    through = {"half": np.inf, "profile": "constant", "throw": 36.0}
    faults = {
        "F1": Fault(1000, 1000, strike=125.0, dip=71.0, **through),
        "F2": Fault(1000, 1000, strike=150.0, dip=76.0, branch=("F1", -1), **through),
    }
    return gs.synthetic.torn(faults, 61)


def test_a_branch_that_the_sheet_leaves_at_its_end_is_extended(acute):
    """Its tear ended early before, and 5 m of throw and more were lost."""
    with pytest.warns(gs.GeosurfWarning, match=r"'F2' at its rim.* along strike at its end by"):
        sheet = gs.tear_horizon(acute.horizons["Top"], acute.faults, name="Top", trim=2.25)
    assert {one.kind for one in sheet.report.remedies} == {"fault extended"}
    assert sheet.report.shortened == {}
    for name in acute.faults:
        found = measure(acute, sheet, name)
        assert found.throw.mean() < 1.0
        assert found.throw.max() < 3.0


def test_a_branch_that_is_torn_short_of_its_main_fault_is_told_as_a_place(acute, monkeypatch):
    monkeypatch.setattr(close, "MOST_ALONG", 0.0)  # it cannot be longer
    with pytest.warns(gs.GeosurfWarning, match=r"branch of F1, ends at"):
        sheet = gs.tear_horizon(acute.horizons["Top"], acute.faults, name="Top", trim=2.25)
    lost = measure(acute, sheet, "F2").throw.max()
    notes = [note for note in sheet.report.notes if "truncate_faults" in note]
    assert (lost > 5.0) == bool(notes) == (sheet.report.shortened.get("F2", 0) > 0)
    assert notes  # if branches that run over are torn up to their end, the note is not needed
    found = re.search(r"ends at \(E ([\d. ]+), N ([\d. ]+), .*, (\d+) m", notes[0])
    x, y, far = (float(number.replace(" ", "")) for number in found.groups())
    contact = acute.truth["cutoffs"]["F2", "-"][-1]  # on the main fault
    assert np.hypot(x - contact[0], y - contact[1]) == pytest.approx(far, abs=40.0)


def test_a_branch_that_was_truncated_is_torn_up_to_its_main_fault(acute):
    surfaces = [gs.triangulate_fault(fault, name=name) for name, fault in acute.faults.items()]
    patches = gs.rebuild_surfaces(surfaces)
    faults = gs.truncate_faults(patches, {"F2": ("F1", "footwall")}).surfaces
    sheet = gs.tear_horizon(acute.horizons["Top"], faults, name="Top", trim=2.25)
    assert sheet.report.notes == []
    assert sheet.report.shortened == {}
    for name in acute.faults:
        found = measure(acute, sheet, name)
        assert found.throw.mean() < 1.0
        assert found.throw.max() < 2.5


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
def test_a_branch_that_goes_far_past_its_main_fault_is_torn_up_to_it():
    """Data show no throw of it there: one sheet, whatever the interpreter has drawn beyond."""
    through = {"half": np.inf, "profile": "constant"}
    faults = {
        "F1": Fault(1000, 1000, strike=20.0, dip=70.0, throw=50.0, **through),
        "F2": Fault(1000, 1000, strike=95.0, dip=75.0, throw=36.0, branch=("F1", -1), **through),
    }
    world = gs.synthetic.torn(faults, 61)
    drawn = {name: gs.triangulate_fault(one, name=name) for name, one in world.faults.items()}
    drawn["F2"] = lengthen_fault(drawn["F2"], {"strike": 350.0}).surface
    sheet = gs.tear_horizon(world.horizons["Top"], drawn, name="Top", trim=2.25)
    assert "branch of F1" in sheet.cuts["F2"].ends
    (note,) = (one for one in sheet.warnings if one.kind == "fault ends at another")
    assert "'F2' goes on past 'F1'" in note.effect
    assert sheet.report.remedies == ()
    for name in faults:
        found = measure(world, sheet, name)
        assert found.throw.mean() < 1.0
        assert found.throw.max() < 5.0


def test_faults_that_cross_keep_their_throw_past_each_other():
    """A quarter of F2 lies past F1, with half of its throw."""
    faults = {
        "F1": Fault(1000, 1000, strike=10.0, dip=75.0, half=np.inf, profile="constant", throw=50.0),
        "F2": Fault(800, 1000, strike=95.0, dip=75.0, half=600.0, profile="ellipse", throw=60.0),
    }
    world = gs.synthetic.torn(faults, 61)
    sheet = gs.tear_horizon(world.horizons["Top"], world.faults, name="Top", trim=2.25)
    assert sheet.cuts["F2"].ends == ("tip", "tip")
    assert measure(world, sheet, "F2").throw.max() < 5.0


# ---- Two faults that cross closer to a horizon than their throws leave wedges without it.
LEVEL = -1680
WEST, EAST, SOUTH, NORTH, BOTTOM, TOP = BOX = (0, 3000, 0, 400, -2100, -1400)
COTANGENTS = {"F1": Fraction(3, 5), "F2": Fraction(-3, 5)}
EASTING = {"F1": 1500, "F2": 1503}  # at the stated elevation of the crossing


def fault(name, level):
    """A plane that strikes north, at EASTING at a level; F1 dips east, F2 west."""
    corners = [
        (EASTING[name] + float((level - z) * COTANGENTS[name]), y, z)
        for y, z in ((-900, -2600), (1300, -2600), (1300, -1000), (-900, -1000))
    ]
    return gs.TriSurface(name, "fault", corners, [[0, 1, 2], [0, 2, 3]])


def sheet(depth, throws, hanging_wall=0.5, cell=40.0, first=-200.0, order=("F1", "F2"), up=0):
    """A horizon at LEVEL and some metres up, thrown by faults that cross some way below LEVEL."""
    x, y = np.arange(first, 3201.0 + cell, cell), np.arange(-200.0, 601.0, 100.0)
    flat = gridded(np.full((len(y), len(x)), float(LEVEL + up)), x, y)
    faults = {name: fault(name, LEVEL - depth) for name in ("F1", "F2")}
    return gs.throw_horizon(
        flat, faults, {name: throws[name] for name in order}, name="Top", hanging_wall=hanging_wall
    )


def scene(*torn):
    names = ("Top", "Middle", "Base")
    horizons = dict(zip(names, torn, strict=False))
    return gs.Scene(horizons, {f.name: f for f in torn[0].faults}, BOX)


def areas(depth, throws, hanging_wall=0.5, ups=(0,)):
    """Areas of the section between horizons, by wedge [m2]; those that are not empty."""
    found = []
    for walls in product((1, 0), repeat=2):
        wedge = [(WEST, BOTTOM), (EAST, BOTTOM), (EAST, TOP), (WEST, TOP)]
        level = Fraction(LEVEL)
        for name, wall in zip(("F1", "F2"), walls, strict=True):
            # the hanging wall lies above its fault: a x + b z >= c
            turn = (1 if COTANGENTS[name] > 0 else -1) * (1 if wall else -1)
            c = EASTING[name] + (LEVEL - depth) * COTANGENTS[name]
            wedge = clipped(wedge, turn, turn * COTANGENTS[name], turn * c)
            level -= Fraction(throws[name]) * (Fraction(hanging_wall) - (0 if wall else 1))
        for up in ups:  # from the top down: what is above each horizon, then the remainder
            found.append(area(clipped(wedge, 0, 1, level + up)))
            wedge = clipped(wedge, 0, -1, -level - up)
        found.append(area(wedge))
    return sorted(float(one) for one in found if one)


def clipped(polygon, a, b, c):
    """The part of a convex polygon with a x + b z >= c, exactly."""
    out = []
    for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        u, v = (a * x + b * z - c for x, z in (p, q))
        out += [p] if u >= 0 else []
        if u * v < 0:
            out.append(tuple(s + Fraction(u, u - v) * (t - s) for s, t in zip(p, q, strict=True)))
    return out


def area(polygon):
    turned = polygon[1:] + polygon[:1]
    return abs(sum(a * d - b * c for (a, b), (c, d) in zip(polygon, turned, strict=True))) / 2


@pytest.mark.parametrize("depth", [-40, 20, 40, 60, 90])
@pytest.mark.parametrize(
    ("throws", "hanging_wall"),
    [({"F1": 60, "F2": 40}, 0.5), ({"F1": 40, "F2": 60}, 1.0), ({"F1": 40, "F2": 40}, 0.0)],
)
def test_wedges_without_a_horizon_are_sealed_with_their_true_volumes(depth, throws, hanging_wall):
    """Also where the crossing is above the horizon, and where it ends on one fault only."""
    order = ("F1", "F2") if depth % 40 else ("F2", "F1")
    model = scene(sheet(depth, throws, hanging_wall, order=order))
    found = sorted(unit.volume / (NORTH - SOUTH) for unit in model.units.values())
    np.testing.assert_allclose(found, areas(depth, throws, hanging_wall), rtol=1e-8)
    assert model.check().ok


def test_three_horizons_of_which_wedges_have_one_or_none():
    """Above the crossing Middle and Base are missing, below it all three are."""
    throws, ups = {"F1": 60, "F2": 40}, (80, 0, -80)
    model = scene(*(sheet(40, throws, up=up) for up in ups))
    found = sorted(unit.volume / (NORTH - SOUTH) for unit in model.units.values())
    assert len(found) == 2 + 4 + 4 + 1
    np.testing.assert_allclose(found, areas(40, throws, ups=ups), rtol=1e-8)
    assert model.check().ok


def test_a_wedge_narrower_than_the_cells_is_refused_and_finer_cells_build_it():
    """The wedge is 21 m wide where it has the horizon, and no node is there."""
    coarse = {"depth": 65, "throws": {"F1": 60, "F2": 40}}
    with pytest.raises(GeometryError, match=r"21 m wide between faults 'F\d' and 'F\d'") as error:
        sheet(**coarse, cell=100.0, first=-170.0)
    cell = float(re.search(r"on cells of ([\d.]+) m", str(error.value))[1])
    fine = scene(sheet(**coarse, cell=cell, first=-170.0))
    found = sorted(unit.volume / (NORTH - SOUTH) for unit in fine.units.values())
    np.testing.assert_allclose(found, areas(**coarse), rtol=1e-8)


def test_a_horizon_that_is_missing_where_it_should_be_is_refused():
    """A wedge of 27 m has the horizon; without its piece, corners lie on both sides."""
    torn = sheet(70, {"F1": 60, "F2": 40})
    mesh = torn.surface
    inside = [(mesh.vertex_data[f"wall of {f}"][mesh.triangles] == 1).all(axis=1) for f in EASTING]
    holed = gs.TriSurface(
        "Top", "horizon", mesh.vertices, mesh.triangles[~(inside[0] & inside[1])],
        vertex_data=mesh.vertex_data,
    )  # fmt: skip
    holed.sectors = mesh.sectors
    assert len(scene(torn).units) == 7
    with pytest.raises(OpenUnitError, match="piece between them is narrower than its cells"):
        scene(replace(torn, mesh=holed)).units  # noqa: B018
