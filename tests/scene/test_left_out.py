"""The default box and area, and what the model leaves out or leaks at: named with its share."""

from __future__ import annotations

import ast
import re

import numpy as np
import pytest

import geosurf as gs
from geosurf import Lattice, Scene, TriSurface, synthetic, tear_horizon
from geosurf.errors import GeometryError, GeosurfWarning, InputError, OpenUnitError, SurfaceError
from geosurf.triangulate.mesh import check_horizon_mesh
from tests import laws
from tests.grids import gridded
from tests.grids import turned as places_of
from tests.messages import refused
from tests.scene.conftest import level
from tests.strategies import sheet


def test_the_default_box_is_where_all_horizons_are():
    world = synthetic.tilted_planes(n=5)
    top, base = world.horizons["Top"], world.horizons["Base"].isel(easting=slice(1, None))
    scene = Scene({"Top": top, "Base": base}, world.faults)
    with pytest.warns(GeosurfWarning, match=r"covers 75 % of horizon 'Top' \(9 km² of 12 km²\)"):
        west, east, south, north, bottom, high = scene.box
    assert (west, east, south, north) == (1000.0, 4000.0, 0.0, 3000.0)
    assert bottom < float(base.min()) < float(top.max()) < high
    assert "default: where all horizons are" in scene.explain()
    laws.assert_volumes_add_up(scene.units, scene.box)
    assert {u.zone for u in scene.units.values()} == {"above Top", "Top/Base", "below Base"}
    assert [warning.subject for warning in scene.warnings] == ["Top"]
    assert scene.replace(box=scene.box).warnings == ()


def test_a_hole_is_refused_by_name_and_the_remedies_work():
    holed = np.full((21, 21), 3.0)
    holed[5:8, 9:12] = np.nan
    axis = np.arange(21.0)
    horizons = {"Top": TriSurface("Top", "horizon", lattice=Lattice(axis, axis, holed))}
    words = r"has 1 hole: in 'Top' at \(E 9.9\d+, N 5.9\d+\) \(15 m²\)\. Fill them"
    refused(InputError, words, lambda: Scene(horizons).box)
    scene = Scene(horizons, aoi="rectangle")
    west, east, south, north, _, _ = scene.box
    share = (east - west) * (north - south) / (400 - 15)
    (step,) = [s for s in scene.steps if s.stage == "box"]
    assert (
        f"largest axis-parallel rectangle that all horizons cover, {100 * share:.0f} %"
        in step.detail
    )
    assert len(scene.units) == 2


@pytest.mark.parametrize(("box", "words"), [
    ((0, 4, 0, 4, -8, -2), r"Top' \(easting -1 to 5, .* elevation 3 to 3\) does not .* are depths"),
    ((0, 4, 0, 4, 5, 8), r"elevation 3 to 3\) does not reach .*0 to 4, 5 to 8\)\. Enlarge the box"),
    ((9, 12, 0, 4, 0, 8), r"model box \(9 to 12, 0 to 4, 0 to 8\)\. Enlarge the box"),
])  # fmt: skip
def test_a_box_apart_from_a_horizon_names_both_extents(box, words):
    error = refused(GeometryError, words, lambda: Scene({"Top": level(3)}, box=box).units)
    assert error.surfaces == ("Top",)


def test_the_default_area_of_a_mesh_is_inside_its_rim():
    corners = [(0, 0, 3), (9, 1, 3), (8, 7, 3), (4, 2, 3), (1, 8, 3)]  # not convex
    mesh = TriSurface("Top", "horizon", corners, [[0, 1, 3], [1, 2, 3], [0, 3, 4]])
    scene = Scene({"Top": mesh})
    assert len(scene.units) == 2
    assert scene.check().ok
    assert 5 <= len(scene.aoi) <= 20
    assert scene.units.footprint == pytest.approx(36.5, rel=0.01)
    soup = np.array(corners)[mesh.triangles].reshape(9, 3), np.arange(9).reshape(3, 3)
    assert Scene({"Top": soup}).units.footprint == scene.units.footprint
    again = corners, [*mesh.triangles, mesh.triangles[1]]
    twice = Scene({"Top": again}, box=(5, 7, 2, 5, 0, 6))
    refused(SurfaceError, "'Top' has 1 triangle twice, one of them near", lambda: twice.units)
    with pytest.raises(InputError, match="'Top' is a mesh, and aoi='rectangle' is for grids only"):
        _ = Scene({"Top": mesh}, aoi="rectangle").box
    with pytest.raises(InputError, match="proposes a box, and box= is given as well"):
        Scene({"Top": mesh}, box=(0, 1, 0, 1, 0, 4), aoi="rectangle")


@pytest.fixture(scope="module")
def torn():
    """A horizon torn by a fault that cuts right through, and this fault."""
    world = synthetic.torn("through", 41)
    top = tear_horizon(world.truth["points"], world.faults, name="Top", positive="up")
    return {"Top": top}, {fault.name: fault for fault in top.faults}


@pytest.mark.parametrize("words", [{"extend": ["F1"]}, {"truncations": {"F1": ("X", "+")}}])
def test_the_default_area_of_torn_horizons_does_not_ask_for_the_faults_that_leave_it(torn, words):
    """Each would ask for the other: the fault ends at the box, the horizon at the fault."""
    sheets, faults = torn
    wall = [[0, 400, -2100], [1000, 400, -2100], [1000, 400, -1500], [0, 400, -1500]]
    scene = Scene(sheets, {**faults, "X": (wall, [[0, 1, 2], [0, 2, 3]])}, **words)
    assert scene.box[:4] == pytest.approx((0, 1000, 0, 1000))
    assert scene.aoi is None
    assert scene.surface("F1").n_triangle
    if "truncations" in words:
        refused(InputError, r"another surface here.* tear .* scene.surface", lambda: scene.units)
    else:  # it leaves the box already
        assert scene.check().ok


def test_the_default_area_of_torn_horizons_is_closed(torn):
    scene = Scene(*torn)
    assert scene.check().ok
    assert scene.units.footprint == 1e6


# ---- What the model leaves out: most of a rotated field, faults beside it, bodies that are no
BOX = (0.0, 5000.0, 0.0, 4000.0, -2600.0, -1800.0)


def turned(degrees, n=(31, 61), cell=50.0):
    """A grid turned by an angle."""
    east, north, i, _ = places_of(degrees, n[::-1], cell)
    return gridded(-1700 + 0.02 * i, east, north)


@pytest.mark.parametrize("degrees", [3, 20, 45, 77, 140, 250])
def test_the_default_area_of_a_turned_grid_is_all_of_it(degrees):
    scene = gs.Scene({"T": turned(degrees)})
    assert len(scene.units) == 2
    assert scene.check().ok
    assert scene.warnings == ()
    assert len(scene.aoi) == 4
    assert 0.9995 < scene.units.footprint / (1500.0 * 3000.0) < 1.0
    height = scene.box[5] - scene.box[4]
    assert float(scene.volumes.sum()) == pytest.approx(scene.units.footprint * height)


# ---- faults beside the model -----------------------------------------------------------------


def wall(name, x, low=-3000.0, high=-1000.0):
    corners = [(x, -500, low), (x, 4500, low), (x, 4500, high), (x, -500, high)]
    return gs.TriSurface(name, "fault", np.array(corners, dtype=float), [[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize(
    ("fault", "where"),
    [
        (wall("Out", 5500), r"500 m east of the model box"),
        (wall("Out", -20), r"20 m west of"),
        (wall("Out", 2500, -1500, -1000), r"300 m above the model box"),
        (wall("Out", 2500, -4000, -2700), r"100 m below the model box"),
    ],
)
def test_a_fault_beside_the_box_is_named(fault, where):
    top = gs.synthetic.graben(n=21).horizons["Top"]
    scene = gs.Scene({"Top": top}, {"In": wall("In", 2500), "Out": fault}, BOX)
    with pytest.warns(GeosurfWarning, match=rf"Fault 'Out' lies {where}") as issued:
        (found,) = scene.warnings
    assert len(issued) == 1
    assert (found.kind, found.subject) == ("outside", "Out")
    assert ("depth or elevation" in found.remedy) == ("above" in where or "below" in where)
    assert len(scene.units) == 4
    assert scene.warnings == (found,)
    box = eval(re.search(r"box=(\([^)]*\))", found.remedy)[1])
    assert gs.Scene({}, {"Out": fault}, box).warnings == ()


# ---- bodies and folds ---------------------------------------------------------------------------


def ball(n=8, radius=100.0, centre=(0.0, 0.0, -500.0)):
    """A closed body, wound outward."""
    polar, turn = np.linspace(0, np.pi, n)[1:-1], np.linspace(0, 2 * np.pi, 2 * n, endpoint=False)
    ring = [[np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)] for t in polar for p in turn]
    m, last, faces = 2 * n, 1 + len(ring), []
    pairs = [(j, (j + 1) % m) for j in range(m)]
    faces += [[0, 1 + j, 1 + k] for j, k in pairs]
    for i in range(n - 3):
        for a, b in ((1 + i * m + j, 1 + i * m + k) for j, k in pairs):
            faces += [[a, a + m, b], [b, a + m, b + m]]
    faces += [[last, last - m + k, last - m + j] for j, k in pairs]
    return radius * np.array([[0, 0, 1], *ring, [0, 0, -1]]) + centre, np.array(faces)


def variants():
    """A ball as programs hand it out."""
    vertices, faces = ball()
    rng = np.random.default_rng(0)
    yield "as it is", vertices, faces
    yield "shuffled", vertices, faces[rng.permutation(len(faces))]
    wound = rng.random(len(faces)) < 0.5
    yield "wound at random", vertices, np.where(wound[:, None], faces[:, ::-1], faces)
    yield "not welded", vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)
    beside = np.array([(-400.0, -400, -100), (400, -400, -100), (400, 400, -100)])
    n = len(vertices)
    yield "beside a sheet", np.vstack([vertices, beside]), np.vstack([faces, [n, n + 1, n + 2]])


@pytest.mark.parametrize("variant", list(variants()), ids=lambda variant: variant[0])
def test_a_closed_body_is_refused_as_a_horizon(variant):
    _, vertices, faces = variant
    salt = gs.TriSurface("Salt", "horizon", vertices, faces)
    box = (-400, 400, -400, 400, -1000, 0)
    with pytest.raises(SurfaceError, match=r"'Salt' \w+ a closed body of 3\.\d+ million m³ around"):
        _ = gs.Scene({"Salt": salt}, {}, box).units
    if variant[0] == "as it is":  # what the message proposes
        made = gs.Scene({}, {"Salt": salt}, box)
        assert made.check().ok
        assert sorted(made.units) == ["Salt+", "Salt-"] or len(made.units) == 2


@pytest.mark.parametrize("flip", [False, True])
def test_a_sheet_that_does_not_fold_is_silent_however_it_is_wound(flip):
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(5.0), np.arange(5.0)))
    cells = np.array([[k, k + 1, k + 6, k + 5] for k in range(19) if k % 5 < 4])
    faces = np.vstack([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    if flip:
        faces[::3] = faces[::3, ::-1]
    check_horizon_mesh(gs.TriSurface("T", "horizon", np.column_stack([x, y, x * y]), faces))


def test_the_share_of_a_fault_inside_counts_heights(scene):
    _, _, south, north, bottom, top = scene.box
    _, _, y_low, y_high, z_low, z_high = scene.surface("F1").bounds
    share = (north - south) * (top - bottom) / ((y_high - y_low) * (z_high - z_low))
    assert share < (north - south) / (y_high - y_low)
    assert scene.coverage["F1"] == pytest.approx(share, abs=0.02)


# ---- Surfaces of other packages whose rims stop short: each is named, with the place and the
BOX_OPEN_RIMS = (0, 1000, 0, 1000, -2500, -500)


def flat(z, west=-50, east=1050):
    """A level horizon."""
    corners = [(west, -50, z), (east, -50, z), (east, 1050, z), (west, 1050, z)]
    return sheet("H", corners, (8, 8), role="horizon")


def halves(z, gap):
    """A horizon that stops before a fault at x = 500, on both sides."""
    one, two = flat(z, east=500 - gap), flat(z - 100, west=500 + gap)
    faces = np.concatenate([one.triangles, two.triangles + one.n_vertex])
    return np.concatenate([one.vertices, two.vertices]), faces


def fault_to(north):
    """A vertical fault at x = 500."""
    corners = [(500, -60, -3000), (500, north, -3000), (500, north, 0), (500, -60, 0)]
    return {"F1": sheet("F1", corners, (8, 8))}


HORIZONS = {"Top": flat(-1000), "Base": flat(-1500)}


@pytest.mark.parametrize(
    ("horizon", "place", "gap"),
    [
        (halves(-1000, 5), r"\(E 495, ", "ends 5 m before fault 'F1' there"),
        (flat(-1000, west=30), r"\(E 30, ", "ends 30 m before the west side of the model"),
    ],
)
def test_a_horizon_that_stops_short_is_named_with_its_gap(horizon, place, gap):
    scene = gs.Scene({**HORIZONS, "Top": horizon}, fault_to(1060), BOX_OPEN_RIMS)
    refused(OpenUnitError, rf"leak around horizon 'Top': .*{place}.*It {gap}", lambda: scene.units)


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
@pytest.mark.parametrize("gap", [0.5, 12])
def test_a_fault_that_stops_short_of_a_side_is_named_with_its_gap(gap):
    scene = gs.Scene(HORIZONS, fault_to(1000 - gap), BOX_OPEN_RIMS)
    (found,) = (one for one in scene.warnings if one.kind == "rim")
    assert found.subject == "F1"
    assert f"ends {gap:g} m before the north side of the model box" in found.effect
    assert np.allclose(found.place[:2], (500, 1000 - gap))
    assert [unit for unit in scene.units if "F1" in unit] == []  # units go around it
    # the remedy that it prints
    whole = gs.extend_fault(scene.surface("F1"), BOX_OPEN_RIMS, sides="strike").surface
    again = scene.replace(faults={"F1": whole})
    assert not again.warnings
    box = ast.literal_eval(found.remedy.split("box=")[-1].removesuffix("."))
    assert 1000 - gap * 1.2 < box[3] < 1000 - gap
    assert len(scene.replace(box=box).units) == len(again.units)
    assert len(again.units) == 2 * len(scene.units)
