"""A scene computes what is asked for, once, and says so."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from geosurf import (
    FaultSticks,
    Lattice,
    Scene,
    TriSurface,
    intersect_surfaces,
    read_fault,
    synthetic,
)
from geosurf.errors import GeometryError, GeosurfWarning, InputError
from geosurf.scene import memory
from geosurf.scene.memory import fingerprint
from tests import laws
from tests.strategies import BOX, grid, sheet


def upright(x, name="F1", **options):
    return sheet(name, [(x, -1, -5), (x, 5, -5), (x, 5, 9), (x, -1, 9)], **options)


def level(z, name="Top"):
    return grid(name, np.full((4, 4), float(z)), spacing=2.0, corner=(-1.0, -1.0))


@pytest.fixture
def scene():
    """Two horizons, two faults; F2 ends above Base and stays off Top."""
    low = sheet("F2", [(-1, 2, -5), (5, 2, -5), (5, 2, 2), (-1, 2, 2)])
    return Scene({"Top": level(3), "Base": level(1)}, {"F1": upright(1), "F2": low}, BOX)


def ran(scene, stage=None, outcome="ran"):
    return [s.subject for s in scene.steps if s.outcome == outcome and stage in (None, s.stage)]


def test_nothing_runs_before_it_is_asked_for(scene):
    assert scene.steps == ()
    assert scene.explain() == ""


def test_one_cutoff_runs_one_pair_and_reads_two_surfaces(scene):
    (line,) = scene.cutoffs("Top", "F1")
    assert line.shape[1] == 3
    assert set(line[:, 0]) == {1.0}
    assert ran(scene, "triangulate") == ["Top", "F1"]
    assert ran(scene, "curves") == ["Top x F1"]
    assert len(scene.steps) == 3


def test_curves_of_a_surface_with_itself():
    """A roll of four faces that passes through its own first one; `curves` has it if asked to."""
    corners = [(0, -1, 2), (0, 5, 2), (3, -1, 2), (3, 5, 2), (3, -1, 6), (3, 5, 6), (1, -1, 6),
               (1, 5, 6), (1, -1, 0), (1, 5, 0)]  # fmt: skip
    faces = [f for i in range(0, 8, 2) for f in ((i, i + 2, i + 3), (i, i + 3, i + 1))]
    roll = TriSurface("F1", "fault", corners, faces)
    plain = Scene({"Top": level(3)}, {"F1": roll}, BOX)
    mine = plain.curves_between("F1", "F1")
    assert mine.names == ("F1",)
    assert mine.length == 6.0
    assert set(map(tuple, mine.points[:, [0, 2]].tolist())) == {(1.0, 2.0)}
    assert plain.curves_between("F1", "F1") is mine
    assert plain.curves_between("Top", "Top").n_curve == 0
    assert (plain.curves.surfaces_of_curve[:, 0] != plain.curves.surfaces_of_curve[:, 1]).all()
    whole = Scene({"Top": level(3)}, {"F1": roll}, BOX, self_intersections=True)
    once = intersect_surfaces(whole.surfaces, self_intersections=True)
    assert whole.curves.points.tobytes() == once.points.tobytes()
    assert whole.curves.surfaces_of_curve.tolist() == once.surfaces_of_curve.tolist()
    assert [1, 1] in whole.curves.surfaces_of_curve.tolist()


def test_files_that_are_not_asked_for_are_not_read(tmp_path):
    missing = tmp_path / "missing.ts"
    scene = Scene({"Top": level(3), "Base": missing}, {"F1": upright(1)}, BOX)
    assert len(scene.cutoffs("Top", "F1")) == 1
    with pytest.raises(InputError, match=r"missing\.ts"):
        scene.surface("Base")


def test_the_second_time_comes_from_memory(scene):
    first = scene.curves_between("Top", "F1")
    assert scene.curves_between("Top", "F1") is first
    assert [s.outcome for s in scene.steps if s.stage == "curves"] == ["ran", "from memory"]
    assert scene.curves is scene.curves
    assert scene.units is scene.units
    assert ran(scene, "rebuild") == ["4 surfaces and the box"]
    assert ran(scene, "carve") == ["the box"]


def test_skipped_pairs_are_told(scene):
    assert scene.cutoffs("Top", "F2") == []
    (step,) = [s for s in scene.steps if s.outcome == "skipped"]
    assert (step.stage, step.subject, step.detail) == ("curves", "Top x F2", "boxes do not meet")
    assert scene.curves.n_curve == 4
    assert ran(scene, "curves", "skipped") == ["Top x F2", "Top x Base", "Top x F2"]
    assert "Top x F2" in scene.explain()


def test_replace_recomputes_the_pairs_of_what_changed(scene):
    before = scene.curves
    other = scene.replace(faults={"F1": upright(2)})
    assert other.steps == ()
    after = other.curves
    assert ran(other, "triangulate") == ["F1"]
    assert sorted(ran(other, "curves")) == ["Base x F1", "F1 x F2", "Top x F1"]
    assert ran(other, "curves", "from memory") == ["Base x F2"]
    assert {*after.between("Top", "F1")[0][:, 0]} == {2.0}
    np.testing.assert_array_equal(after.between("Base", "F2")[0], before.between("Base", "F2")[0])
    # the first scene is what it was
    assert scene.curves is before
    assert {*scene.cutoffs("Top", "F1")[0][:, 0]} == {1.0}


def test_an_equal_input_changes_nothing(scene):
    first = scene.units
    twin = scene.replace(faults={"F1": upright(1)})
    assert twin.units is first
    assert ran(twin, "rebuild") == ran(twin, "carve") == []


@pytest.mark.parametrize("kind", ["units of an axis", "sticks", "vertices", "stick of a vertex"])
def test_inputs_that_differ_in_little_are_not_one(kind):
    """Each of these was once taken for an input that a scene had seen before."""
    quad = np.array([(1.0, -1, 9), (1, -1, -5), (1, 5, 9), (1, 5, -5)])
    faces = [(0, 1, 2), (1, 3, 2)]
    if kind == "units of an axis":
        one = xr.DataArray(
            np.zeros((2, 2)), dims=("northing", "easting"),
            coords={"northing": [0.0, 9.0], "easting": [0.0, 9.0]},
        )  # fmt: skip
        two = one.assign_coords(easting=one.easting.assign_attrs(units="ft"))
    elif kind == "sticks":
        line = np.vstack([quad[:2], quad[:1] + 3.0, quad[2:]])
        one, two = (FaultSticks("F1", (line[:n], line[n:])) for n in (2, 3))
    elif kind == "vertices":
        one, two = (quad, faces), (quad + 1.0, faces)
    else:
        sticks = [{"stick": [0, 0, 1, 1]}, {"stick": [0, 1, 2, 3]}]
        one, two = (TriSurface("F1", "fault", quad, faces, vertex_data=d) for d in sticks)
    assert fingerprint(one) != fingerprint(two)


def test_arrays_are_told_by_what_is_in_them(scene):
    """By their identity, an array that is gone could be taken for the one in its place."""

    def fault(x):
        return np.array([(x, -1.0, -5), (x, 5, -5), (x, 5, 9)]), [[0, 1, 2]]

    twin = scene.replace(faults={"F1": fault(2.0)})
    assert set(twin.cutoffs("Top", "F1")[0][:, 0]) == {2.0}
    again = twin.replace(faults={"F1": fault(2.0)})
    assert set(again.cutoffs("Top", "F1")[0][:, 0]) == {2.0}
    assert ran(again, "curves") == []


def test_inputs_are_read_once(scene, monkeypatch):
    """However many pairs ask: hashes of surfaces took longer than the pairs themselves."""
    taken = []
    plain = memory.fingerprint
    monkeypatch.setattr(memory, "fingerprint", lambda *a: taken.append(a) or plain(*a))
    scene.curves, scene.units  # noqa: B018
    assert len(taken) == 4


def test_a_box_said_aloud_is_the_default_one():
    """Another local frame is another result: the certificate compares bytes."""
    x = np.arange(2000.0, 3001.0, 250.0)
    top = xr.DataArray(
        np.full((5, 5), -100.3), dims=("northing", "easting"),
        coords={"northing": x, "easting": x}, attrs={"units": "m", "positive": "up"},
    )  # fmt: skip
    corners = [(500, 500, -300), (500, 3500, -300), (3000, 3500, 300), (3000, 500, 300)]
    scene = Scene({"Top": top}, {"F1": (corners, [[0, 1, 2], [0, 2, 3]])})
    with pytest.warns(
        GeosurfWarning, match=r"'F1' lies close to the model box, but not in it, and is left"
    ):
        assert len(scene.units) == 2
    assert scene.replace(box=scene.box).check().ok


def test_a_removed_fault_takes_its_rules_along(scene):
    """Of its own; that another fault is to end at it cannot be forgotten in silence."""
    ruled = scene.replace(extend={"F1": "up"}, truncations={"F2": ("F1", "+")})
    assert ruled.replace(faults={"F2": None}).extend == {"F1": ("up",)}
    assert ruled.replace(faults={"F2": None}).truncations == {}
    with pytest.raises(InputError, match="truncations name 'F1', which is not a fault"):
        ruled.replace(faults={"F1": None})


def test_replace_says_what_it_cannot_do(scene):
    with pytest.raises(InputError, match=r"faults has no 'F11' to remove; .* mean 'F1'\?"):
        scene.replace(faults={"F11": None})
    with pytest.raises(InputError, match="horizons is a list; give a mapping"):
        scene.replace(horizons=[level(3)])


def test_a_gridded_contact_follows_the_words_of_the_scene(scene):
    """As horizons do: depths in feet, where the array itself does not say."""
    x = np.array([-1.0, 5.0])
    owc = xr.DataArray(
        np.full((2, 2), -2.0 / 0.3048), dims=("northing", "easting"),
        coords={"northing": x, "easting": x},
    )  # fmt: skip
    split = scene.replace(contacts={"OWC": {"F1+": owc}}, positive="down", length_unit="ft")
    assert "Top/Base F1+ below OWC" in split.units
    above = split.units["Top/Base F1+ above OWC"].vertices[:, 2]
    assert above.min() == pytest.approx(2.0, abs=1e-12)
    with pytest.raises(InputError, match=r"horizon 'OWC': are the values depth or elevation\?"):
        scene.replace(contacts={"OWC": owc}).units  # noqa: B018


def test_words_of_a_scene_are_not_said_twice(tmp_path):
    """Sticks from a file of depths in feet once were turned and scaled by the reader and again."""
    file = tmp_path / "F1.pol"
    file.write_text("1 0 10\n1 0 20\n999 999 999\n1 9 10\n1 9 20\n999 999 999\n")
    words = {"positive": "down", "length_unit": "ft"}
    for fault in (file, str(file), read_fault(file, **words)):
        bounds = Scene({}, {"F1": fault}, BOX, **words).surface("F1").bounds
        assert bounds == pytest.approx((1, 1, 0, 9, -6.096, -3.048), abs=1e-12)


@pytest.mark.parametrize("said", [{"units": "m"}, {"units": "m", "positive": "up"}])
def test_a_gridded_fault_that_says_its_units_keeps_them(said):
    dims = ("down_dip", "along_strike")
    fault = xr.Dataset({
        "easting": (dims, [[1.0, 1.0], [2.0, 2.0]]),
        "northing": (dims, [[0.0, 9.0], [0.0, 9.0]]),
        "elevation": (dims, [[8.0, 8.0], [-8.0, -8.0]], said),
    })  # fmt: skip
    scene = Scene({}, {"F1": fault}, BOX, positive="down", length_unit="ft")
    assert scene.surface("F1").bounds == (1.0, 2.0, 0.0, 9.0, -8.0, 8.0)
    plain = fault.assign(elevation=fault.elevation.drop_attrs())
    for whole in ({}, {"units": "m"}):  # which once kept the word of the scene away
        feet = (
            Scene({}, {"F1": plain.assign_attrs(whole)}, BOX, length_unit="ft").surface("F1").bounds
        )
        assert feet[4:] == pytest.approx((-2.4384, 2.4384), abs=1e-12)


def test_replace_adds_and_removes(scene):
    assert scene.replace(faults={"F2": None}).fault_names == ("F1",)
    assert scene.replace(horizons={"Deep": level(-1)}).horizon_names == ("Top", "Base", "Deep")
    smaller = scene.replace(box=(0, 2, 0, 4, -4, 8))
    assert smaller.units.box_volume == 96.0
    assert scene.units.box_volume == 192.0
    with pytest.raises(InputError, match=r"a scene has no input 'fault'.*Did you mean 'faults'\?"):
        scene.replace(fault={})


def test_curves_are_those_of_all_surfaces_at_once(scene):
    together = intersect_surfaces(scene.surfaces)
    laws.assert_same_curves(scene.curves, together)
    assert scene.curves.local.tobytes() == together.local.tobytes()
    assert scene.curves.names == ("Top", "Base", "F1", "F2")


def test_units_and_certificate(scene):
    laws.assert_volumes_add_up(scene.units, BOX)
    assert scene.volumes.sum().item() == pytest.approx(192.0, rel=1e-12)
    certificate = scene.check()
    assert certificate.ok, str(certificate)
    assert certificate.checks[-1].name == "two runs give the same bytes"
    # F2 splits what lies below Base, and dies in the zone above
    assert len(scene.units) == 2 + 2 + 4


def test_order_of_faults_and_voxel_size_change_no_volume(scene):
    faults = {name: scene.surface(name) for name in ("F2", "F1")}
    other = Scene({"Top": level(3), "Base": level(1)}, faults, BOX, voxel_size=0.7)
    volumes = sorted(unit.volume for unit in scene.units.values())
    np.testing.assert_allclose(sorted(u.volume for u in other.units.values()), volumes, rtol=1e-14)


def test_the_default_box_is_where_all_horizons_are():
    world = synthetic.tilted_planes(n=5)
    top, base = world.horizons["Top"], world.horizons["Base"].isel(easting=slice(1, None))
    scene = Scene({"Top": top, "Base": base}, world.faults)
    west, east, south, north, bottom, high = scene.box
    assert (west, east, south, north) == (1000.0, 4000.0, 0.0, 3000.0)
    assert bottom < float(base.min()) < float(top.max()) < high
    assert "default: where all horizons are" in scene.explain()
    laws.assert_volumes_add_up(scene.units, scene.box)
    assert {u.zone for u in scene.units.values()} == {"above Top", "Top/Base", "below Base"}


def test_a_hole_that_shrinks_the_default_box_is_told():
    holed = np.full((21, 21), 3.0)
    holed[5:8, 9:12] = np.nan
    axis = np.arange(21.0)
    scene = Scene({"Top": TriSurface("Top", "horizon", lattice=Lattice(axis, axis, holed))})
    with pytest.warns(GeosurfWarning, match="The default box covers 60 % of where all horizons"):
        west, east, south, north, _, _ = scene.box
    share = (east - west) * (north - south) / 400
    (step,) = [s for s in scene.steps if s.stage == "box"]
    assert f"the largest rectangle that all horizons cover, {100 * share:.0f} %" in step.detail
    assert len(scene.units) == 2


@pytest.mark.parametrize(("box", "words"), [
    ((0, 4, 0, 4, -8, -2), r"Top' \(easting -1 to 5, .* elevation 3 to 3\) does not .* are negat"),
    ((0, 4, 0, 4, 5, 8), r"elevation 3 to 3\) does not reach .*0 to 4, 5 to 8\)\. Enlarge the box"),
    ((9, 12, 0, 4, 0, 8), r"model box \(9 to 12, 0 to 4, 0 to 8\)\. Enlarge the box"),
])  # fmt: skip
def test_a_box_beside_a_horizon_says_where_both_are(box, words):
    with pytest.raises(GeometryError, match=words):
        Scene({"Top": level(3)}, box=box).units  # noqa: B018


def test_a_mesh_has_no_default_box():
    with pytest.raises(InputError, match=r"horizon 'Top' is a mesh.*give box="):
        _ = Scene({"Top": level(3)}).box


def test_gridded_inputs():
    world = synthetic.tilted_planes(n=5)
    scene = Scene(world.horizons, world.faults, world.box)
    assert [s.role for s in scene.surfaces] == ["horizon", "horizon", "fault"]
    assert len(scene.units) == 6
    assert scene.search("Top", "F1").faces_a.size > 0


def test_refusals():
    with pytest.raises(InputError, match="at least one horizon or fault; give horizons="):
        Scene({})
    with pytest.raises(InputError, match="horizons is a list; give a mapping"):
        Scene([level(3)])
    with pytest.raises(InputError, match="'Top' is the name of a horizon and of a fault; rename"):
        Scene({"Top": level(3)}, {"Top": upright(1)})
    with pytest.raises(InputError, match=r"no surface is called 'Tpo'.*Did you mean 'Top'\?"):
        Scene({"Top": level(3)}).surface("Tpo")
    with pytest.raises(InputError, match=r"west \(4\) is not less than east \(0\)"):
        _ = Scene({"Top": level(3)}, box=(4, 0, 0, 4, -4, 8)).units


def test_a_scene_outlives_what_is_done_to_its_inputs():
    """Grids are lent to surfaces, not to scenes: boxes would be stale, and volumes mixed."""
    worlds = [synthetic.tilted_planes() for _ in range(2)]
    scenes = [Scene(world.horizons, world.faults, world.box) for world in worlds]
    for name in (*worlds[0].horizons, *worlds[0].faults):
        scenes[0].surface(name)
    for da in worlds[0].horizons.values():
        da.values[...] += 77.0
    for ds in worlds[0].faults.values():
        ds["easting"].values[...] -= 99.0
    first, second = ({name: unit.volume for name, unit in s.units.items()} for s in scenes)
    assert first == second


def test_a_frame_that_would_round_inputs_is_not_taken():
    """The box lies beyond 2048 m, but 1000.1 - 2048 has more digits than a double."""
    axis = np.arange(900.1, 3200.0, 200.0)
    top = TriSurface("Top", "horizon", lattice=Lattice(axis, axis, np.zeros((12, 12))))
    box = (2100.0, 2900.0, 2100.0, 2900.0, -300.0, 300.0)
    patches = Scene({"Top": top}, box=box).patches
    assert patches.origin.tolist() == [0.0, 0.0, 0.0]
    assert set(map(tuple, top.vertices.tolist())) <= set(map(tuple, patches.vertices.tolist()))
    even = TriSurface("Top", "horizon", lattice=Lattice(*[np.floor(axis)] * 2, np.zeros((12, 12))))
    assert Scene({"Top": even}, box=box).patches.origin.tolist() == [2048.0, 2048.0, 0.0]


def test_a_fault_has_its_front_in_the_hanging_wall_however_it_is_wound():
    dipping = sheet("F1", [(1, -1, 8), (1, 5, 8), (3, 5, -4), (3, -1, -4)])
    turned = TriSurface("F1", "fault", dipping.vertices, dipping.triangles[:, ::-1])
    for fault in (dipping, turned):
        volumes = {u.block: u.volume for u in Scene({}, {"F1": fault}, BOX).units.values()}
        assert volumes == {"F1+": 96.0, "F1-": 96.0}
        units = Scene({"Top": level(5)}, {"F1": fault}, BOX).units
        assert units["above Top F1+"].volume > units["above Top F1-"].volume


def test_an_answer_is_never_that_of_another_question():
    """Nothing is told by its identity, which a later object may have; nor by words run together."""
    scene = Scene({"Top": level(3), "Base": level(1)}, {}, BOX)

    class Grid:
        """Has coordinates as a map needs them, and is no xarray object."""

        def __init__(self, *east: float) -> None:
            self.coords = {
                name: xr.DataArray(np.array(at), dims=name)
                for name, at in (("northing", [1.0, 2.0]), ("easting", east))
            }

    def eastings(grid: Grid) -> list[float]:
        return scene.thickness("Top/Base", grid).easting.values.tolist()

    for k in range(20):  # each is gone before the next is made
        assert eastings(Grid(1.0 + k / 8, 3.75)) == [1.0 + k / 8, 3.75]
    grid = Grid(1.0, 2.0)
    assert eastings(grid) == [1.0, 2.0]
    grid.coords["easting"][:] = [2.5, 3.5]
    assert eastings(grid) == [2.5, 3.5]


def test_names_with_a_cross_in_them_are_not_run_together():
    faults = {"x C": upright(1), "C": upright(2)}
    scene = Scene({"A": level(3), "A x": level(1)}, faults, BOX)
    one, other = scene.throw("A", "x C"), scene.throw("A x", "C")
    assert (one.horizon, one.fault) == ("A", "x C")
    assert (other.horizon, other.fault) == ("A x", "C")


def test_a_path_and_what_its_file_holds_are_told_apart(tmp_path):
    one, other = tmp_path / "a", tmp_path / "ab"
    one.write_bytes(b"bc")
    other.write_bytes(b"c")
    assert fingerprint(one) != fingerprint(other)


def test_results_do_not_depend_on_identities(scene):
    """A scene made anew finds nothing, one with equal inputs everything, whatever was dropped."""
    units = scene.units
    twin = scene.replace(faults={"F1": upright(2)})
    assert twin.units is not units
    del twin
    again = scene.replace(faults={"F1": upright(1)})
    assert again.units is units
    assert ran(again, "carve", "from memory") == ["the box"]
