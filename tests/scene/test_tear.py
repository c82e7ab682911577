"""`Scene(tear=...)`: one step, horizons torn one after another, faults that pass others."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from benchmarks.random_networks import random_network
from geosurf.errors import GeometryError
from geosurf.faults import lengthen_fault
from geosurf.faults.rules import Rule
from geosurf.faults.truncate import past_mains
from geosurf.scene.tearing import same
from geosurf.sheets.faults.tips import is_unchanged
from geosurf.sheets.mesh import tear_ends
from tests import laws
from tests.planes import between

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


# ---- Horizons that are torn one after another: all end on the same faults, none is torn in va


@pytest.fixture(scope="module")
def whole(world):
    """The fault of the world, far above and below its horizon."""
    (fault,) = (gs.triangulate_fault(one, name=name) for name, one in world.faults.items())
    return fault


@pytest.fixture(scope="module")
def fault(world, whole):
    """It is long enough for the horizon, but not for one 40 m above or below."""
    z = np.concatenate([line[:, 2] for line in world.truth["cutoffs"].values()])
    return between(whole, z.min() - 20.0, z.max() + 20.0)


def lowered(horizon, by):
    lower = horizon - by
    lower.attrs = horizon.attrs
    return lower


@pytest.mark.parametrize("side", ["up", "down"])
def test_a_fault_that_is_longer_far_away_gives_the_same_sheet(world, whole, side):
    """The law that spares a tear."""
    top = world.horizons["Top"]
    fault = between(whole, float(top.min()) - 5.0, float(top.max()) + 5.0)
    sheet = gs.tear_horizon(top, [fault], name="Top", trim=2)
    longer = lengthen_fault(fault, {side: 300.0}).surface
    assert is_unchanged(sheet, {"F1": fault}, {"F1": longer})
    again = gs.tear_horizon(top, [longer], name="Top", trim=2)
    np.testing.assert_array_equal(sheet.surface.vertices, again.surface.vertices)
    np.testing.assert_array_equal(sheet.surface.triangles, again.surface.triangles)

    # a fault that is longer next to the sheet, along strike, or another one
    short = between(fault, fault.bounds[4] + 30.0, fault.bounds[5] - 30.0)
    near = lengthen_fault(short, {side: 60.0}).surface
    assert not is_unchanged(sheet, {"F1": short}, {"F1": near})
    along = lengthen_fault(fault, {"strike": 50.0}).surface
    assert not is_unchanged(sheet, {"F1": fault}, {"F1": along})
    assert not is_unchanged(sheet, {"F1": fault}, {"F1": short})


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
def test_what_another_horizon_needs_far_away_tears_nothing(world, fault):
    """The highest horizon moves down, and then needs the fault no longer than it is."""
    top = world.horizons["Top"]
    horizons = {"Top": lowered(top, -40.0), "Middle": top, "Base": lowered(top, 10.0)}
    scene = gs.Scene(horizons, {"F1": fault}, BOX, tear=2)
    other = {"Top": lowered(top, -10.0)}
    moved = scene.replace(horizons=other)
    before, end = (one.sheets["Top"].faults[0] for one in (scene, moved))
    assert same(end, fault)
    assert not same(end, before)
    tears = {step.subject: step.outcome for step in moved.steps if step.stage == "tear"}
    assert tears == {"Top": "ran", "Middle": "from memory", "Base": "from memory"}

    # nothing depends on what came before
    fresh = gs.Scene(horizons | other, {"F1": fault}, BOX, tear=2)
    assert fresh.volumes.values.tobytes() == moved.volumes.values.tobytes()
    for name, sheet in fresh.sheets.items():
        np.testing.assert_array_equal(sheet.surface.vertices, moved.sheets[name].surface.vertices)
        assert same(sheet.faults[0], end)


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
@pytest.mark.parametrize("can_grow", [True, False])
def test_what_two_horizons_need_far_from_each_other_adds_up(world, fault, monkeypatch, can_grow):
    """Each is torn at the fault as given; where the second cannot add to the first, it is again."""
    top = world.horizons["Top"]
    horizons = {"Top": lowered(top, -40.0), "Base": lowered(top, 40.0)}
    scene = gs.Scene(horizons, {"F1": fault}, BOX, tear=2)

    def refuse(*_):
        raise GeometryError("it folds over")

    if not can_grow:
        monkeypatch.setattr(tear_ends, "extended", refuse)
    one, two = (sheet.faults[0] for sheet in scene.sheets.values())
    assert same(one, two)
    low, high = one.bounds[4:]
    assert low < fault.bounds[4]
    assert high > fault.bounds[5]


# ---- Faults that tears take past the faults that they end at are cut there, on paper
# F1: the plane x + z = 8; F2: the plane y = 4, where x + z >= 8, above z = 3
MAIN = gs.TriSurface(
    "F1", "fault", [(-1, -1, 9), (9, -1, -1), (9, 9, -1), (-1, 9, 9)], [[0, 1, 2], [0, 2, 3]]
)
CORNERS = [(5, 4, 3), (7.5, 4, 3), (7.5, 4, 6), (2, 4, 6)]


def part(*more, triangles=()):
    """F2 with further corners and triangles."""
    return gs.TriSurface("F2", "fault", [*CORNERS, *more], [[0, 1, 2], [0, 2, 3], *triangles])


def side_above():
    """The side of F1 on which x + z > 8."""
    a, b, c = MAIN.vertices[MAIN.triangles[0]]
    return "+" if np.cross(b - a, c - a)[2] > 0 else "-"


@pytest.mark.parametrize(
    ("fault", "area"),
    [
        # down to z = 2 below x = 5 to 7.5: of that strip, (5, 3), (6, 2), (5, 2) is beyond F1
        (part((5, 4, 2), (7.5, 4, 2), triangles=[[4, 5, 1], [4, 1, 0]]), 0.5),
        # up to z = 7 above x = 2 to 7.5: nowhere beyond F1
        (part((7.5, 4, 7), (2, 4, 7), triangles=[[3, 2, 4], [3, 4, 5]]), 0.0),
    ],
)
def test_what_tears_add_beyond_the_main_fault_is_cut_off(fault, area):
    patches = gs.rebuild_surfaces([MAIN, fault])
    keep = side_above()
    kept, cut, told = past_mains(patches, {Rule("F2", "F1", keep): "how"})
    assert [one.dropped_area for one in cut] == ([pytest.approx(area, rel=1e-12)] if area else [])
    assert kept.all() == (area == 0.0)
    assert not told

    # on the other side of F1 it is the rest that counts
    other = "-" if keep == "+" else "+"
    whole = 0.5 * (2.5 + 5.5) * 3.0 + (2.5 if area else 5.5)
    _, (cut,), _ = past_mains(patches, {Rule("F2", "F1", other): "how"})
    assert cut.dropped_area == pytest.approx(whole - area, rel=1e-12)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_what_a_horizon_ends_on_beyond_the_main_fault_stays(side):
    """A level of z = 2.5 that ends on F2, or passes through it."""
    fault = part((5, 4, 2), (7.5, 4, 2), triangles=[[4, 5, 1], [4, 1, 0]])
    corners = [(5, 4, 2.5), (5.5, 4, 2.5), (5.5, 4 + side, 2.5), (5, 4 + side, 2.5)]
    level = gs.TriSurface("Top", "horizon", corners, [[0, 1, 2], [0, 2, 3]])
    rules = {Rule("F2", "F1", side_above()): "lengthen"}
    kept, cut, (told,) = past_mains(gs.rebuild_surfaces([MAIN, fault, level]), rules)
    assert kept.all()
    assert not cut
    assert (told.kind, told.subject) == ("fault passes another", "F2")
    assert "0.5 m² of 'F2' stay" in str(told)
    corners = [(5, 3, 2.5), (5.5, 3, 2.5), (5.5, 5, 2.5), (5, 5, 2.5)]
    level = gs.TriSurface("Top", "horizon", corners, [[0, 1, 2], [0, 2, 3]])
    kept, (cut,), told = past_mains(gs.rebuild_surfaces([MAIN, fault, level]), rules)
    assert cut.dropped_area == pytest.approx(0.5, rel=1e-12)
    assert not told


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"tear": {"horizons": ["Tip"]}}, "tear names 'Tip', which is not a horizon of the scene"),
        ({"tear": True, "throws": {"F1": 9.0}}, "horizon 'Top' is torn twice: by tear, and by"),
        ({"throws": {"F7": 9.0}}, "throws names 'F7', which is not a fault of the scene"),
        ({"throws": {"F1": {"throw": 9.0, "drag": 1.0}}}, "has 'throw', 'drag'; give throw"),
        ({"throws": 9.0}, "throws is a float; give a mapping"),
        ({"throws": {"F1": 9.0}, "tolerance": 1.0}, "throws and tolerance=1 exclude each other"),
    ],
)  # fmt: skip
def test_tears_that_contradict_are_refused(world, words, message):
    with pytest.raises(gs.errors.InputError, match=message):
        gs.Scene(world.horizons, world.faults, **words)


def test_settings_of_what_is_gone_wait_until_it_comes_back(world):
    words = {"trim": {"F1": 2.0}, "horizons": ["Top"]}
    scene, top = gs.Scene(world.horizons, world.faults, tear=words), world.horizons["Top"]
    without = scene.replace(faults={"F1": None}, horizons={"Base": top.copy(data=top - 90.0)})
    again = without.replace(faults=world.faults, horizons={"Base": None})
    assert (scene.sheets["Top"].report.trim, list(without.sheets)) == (2.0, ["Top"])
    assert again.sheets["Top"].surface.vertices.tobytes() == (
        scene.sheets["Top"].surface.vertices.tobytes()
    )
    thrown = scene.replace(tear=None, throws={"F1": {"throw": 9.0, "horizons": ["Top"]}})
    assert not thrown.replace(faults={"F1": None}).sheets


def picked_short(network, rng):
    """Sticks of the faults of a network, from a little above the horizon to a little below it.

    Some end before the cut-offs.
    """
    x, y = (network.horizon[name].values for name in network.horizon.dims[::-1])
    found = {}
    for name, fault in network.faults.items():
        rows = np.stack([fault[k].values for k in ("easting", "northing", "elevation")], axis=-1)
        sticks = []
        for top, base in zip(rows[0, ::5], rows[-1, ::5], strict=True):
            middle = 0.5 * (top + base)
            near = np.hypot(x - middle[0], y[:, None] - middle[1]) < 400.0
            z = network.horizon.values[near] if near.any() else network.horizon.values
            ends = z.max() + rng.uniform(-15, 25), z.min() - rng.uniform(-15, 25)
            sticks.append([top + (base - top) * (top[2] - e) / (top[2] - base[2]) for e in ends])
        found[name] = gs.FaultSticks(name, sticks)
    return found


@pytest.mark.filterwarnings("ignore::geosurf.GeosurfWarning")
@pytest.mark.parametrize(("family", "seed"), [("lambda", 1), ("X", 2), ("relay", 3)])
def test_law_it_does_not_matter_whether_faults_were_extended_before(family, seed):
    rng = np.random.default_rng(seed)
    network = random_network(family, rng, smear=1)
    faults = picked_short(network, rng)
    sides = dict.fromkeys(faults, ("up", "down"))
    far = {name: {"up": 200.0, "down": 150.0} for name in faults}
    plain, *others = (
        gs.Scene({"H": network.horizon}, faults, tear=True, **words).sheets["H"]
        for words in ({}, {"extend": sides}, {"lengthen": far})
    )
    assert any(one.kind == "fault extended" for one in plain.report.remedies)
    for other in others:
        np.testing.assert_allclose(other.lattice.elevation, plain.lattice.elevation, atol=1e-6)
        for name, cut in plain.cuts.items():
            assert other.cuts[name].ends == cut.ends
            np.testing.assert_allclose(other.cuts[name].throw, cut.throw, atol=1e-6)
