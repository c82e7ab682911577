"""A grid adds up to the units, none of its cells is inside out, and planes are exact."""

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import InputError
from geosurf.grid.follow import Below
from geosurf.grid.pillars import limited
from tests.grids import gridded
from tests.messages import refused

SIZE = 4000.0
BOX = (0, SIZE, 0, SIZE, -2200, -1800)


def plane(z0: float, east: float = 0.0, north: float = 0.0):
    x = np.linspace(0.0, SIZE, 41)
    return gridded(z0 + east * x[None, :] + north * x[:, None], x)


def fault(at: float, dip: float = 90.0):
    """A fault along strike 0 that dips east, through an easting at elevation -2000."""
    run = 500.0 / np.tan(np.radians(dip)) if dip < 90 else 0.0
    x = [[at - run, -10, -1500], [at - run, SIZE + 10, -1500]]
    x += [[at + run, -10, -2500], [at + run, SIZE + 10, -2500]]
    return gs.TriSurface("F1", "fault", x, [[0, 2, 1], [1, 2, 3]])


def faulted(at: float, dip: float = 90.0, throw: float = 40.0):
    """Two flat horizons, 60 m apart, that a fault throws down to the east."""
    horizons = {}
    for name, z in (("Top", -1970.0), ("Base", -2030.0)):
        surface = fault(at, dip)
        horizons[name] = gs.throw_horizon(plane(z), [surface], {"F1": throw}, name=name).surface
    return gs.Scene(horizons, {"F1": fault(at, dip)}, (100, 3900, 100, 3900, -2200, -1800))


def test_flat_layers_without_a_fault_are_exact():
    scene = gs.Scene({"Top": plane(-1970, 0.01), "Base": plane(-2030, -0.01, 0.005)}, box=BOX)
    grid = gs.build_grid(scene, cell=(130, 70), layers={"Top/Base": 7})
    table = grid.table
    np.testing.assert_allclose(table.volume, table.exact, rtol=1e-9)
    x = grid.corners_of_layer(0)[:, :, 0]
    np.testing.assert_allclose(x[..., 2], -1970 + 0.01 * x[..., 0], atol=1e-8)
    assert grid.actnum.all()
    assert not grid.inside_out.any()
    assert len(grid.faces) == 0


def test_volumes_of_zones_follow_the_units(planes):
    grid = gs.build_grid(planes, cell=(100, 100), layers={"Top/Base": 3, "below Base": 2})
    table = grid.table.groupby("zone").sum()
    np.testing.assert_allclose(table.volume, table.exact, rtol=1e-3)
    assert not grid.inside_out.any()
    total = sum(u.volume for u in planes.units.values() if u.zone != "above Top")
    assert float(grid.table.exact.sum()) == pytest.approx(total, rel=1e-12)


def test_layers_fill_each_column_without_gaps(planes):
    grid = gs.build_grid(planes, cell=200, layers=4)
    z = grid.zcorn
    np.testing.assert_array_equal(z[1:-1:2], z[2::2])
    assert (np.diff(z, axis=0) <= 0).all()
    assert z.shape == (8, 2 * grid.shape[1], 2 * grid.shape[2])


def test_a_vertical_fault_between_columns_is_exact():
    scene = faulted(2000.0)
    grid = gs.build_grid(scene, cell=100, layers={"Top/Base": 3, "below Base": 1})
    assert len(grid.unit_names) >= 3
    np.testing.assert_allclose(grid.table.volume, grid.table.exact, rtol=1e-9)

    # nodes are split there by the throw, and nowhere else
    top = grid.levels[0]
    jump = np.abs(top[:, :-1, :, 1] - top[:, 1:, :, 0])
    np.testing.assert_allclose(jump[:, 18], 40.0, atol=1e-6)
    np.testing.assert_allclose(np.delete(jump, 18, axis=1), 0.0, atol=1e-6)
    assert set(grid.faces.column[:, 0].tolist()) == {18}
    assert len(grid.faces) == grid.shape[1]


@pytest.mark.filterwarnings("ignore:.*miss their volume")  # of vertical pillars
@pytest.mark.parametrize(("at", "dip"), [(1967.0, 60.0), (2030.0, 35.0), (2041.0, 90.0)])
def test_pillars_follow_a_straight_fault(at, dip):
    scene = faulted(at, dip)
    grid = gs.build_grid(scene, cell=100, layers={"Top/Base": 3})
    np.testing.assert_allclose(grid.table.volume, grid.table.exact, rtol=1e-3)
    stepped = gs.build_grid(scene, cell=100, layers={"Top/Base": 3}, min_dip=None)
    worst = [float(abs(g.table.volume / g.table.exact - 1).max()) for g in (grid, stepped)]
    assert worst[0] < 0.5 * worst[1]
    assert grid.stair_steps == {"F1": (0, grid.shape[1] + 1)}

    # the pillars that follow lie on the fault, all along
    run = at + (-2000.0 - grid.coord[..., [2, 5]]) / np.tan(np.radians(dip))
    off = np.abs(grid.coord[..., [0, 3]] - run).max(axis=-1)
    np.testing.assert_allclose(off.min(axis=1), 0.0, atol=1e-6)


def folds(grid):
    """Smallest turn of a corner of a column, as a share of the area of a cell."""
    lowest = np.inf
    ends = grid.levels.max(axis=(0, 3, 4)), grid.levels.min(axis=(0, 3, 4))
    for share in (0.0, 0.4, 1.0):
        z = (1 - share) * ends[0] + share * ends[1]
        corners = []
        for m, k in ((0, 0), (0, 1), (1, 1), (1, 0)):
            ny, nx = z.shape
            one = grid.coord[m : ny + m, k : nx + k]
            t = (one[..., 2] - z) / (one[..., 2] - one[..., 5])
            corners.append(one[..., :2] + t[..., None] * (one[..., 3:5] - one[..., :2]))
        x = np.stack(corners, axis=2)
        ahead, back = np.roll(x, -1, axis=2) - x, np.roll(x, 1, axis=2) - x
        turn = ahead[..., 0] * back[..., 1] - ahead[..., 1] * back[..., 0]
        lowest = min(lowest, float(turn.min() / np.median(turn)))
    return lowest


def pairs_without_a_face(grid):
    """Active neighbours in different blocks, with no face between them."""
    nz, ny, nx = grid.shape
    apart = np.zeros((3, nz, ny, nx), dtype=bool)
    faces = grid.faces
    for axis, (i, j), (k, end) in zip(faces.axis, faces.column, faces.layers, strict=True):
        apart[axis, k:end, j, i] = True
    found = 0
    for axis, along in ((0, 2), (1, 1), (2, 0)):
        a, b = (np.take(grid.block, np.arange(n, grid.block.shape[along] - 1 + n), along)
                for n in (0, 1))  # fmt: skip
        face = np.take(apart[axis], np.arange(grid.block.shape[along] - 1), along)
        found += int(((a != b) & (a >= 0) & (b >= 0) & ~face).sum())
    return found


@pytest.mark.parametrize(("dip", "angle", "cell"), [(35.0, 40.0, 130), (60.0, 20.0, 100)])
def test_blocks_across_the_lattice_have_the_volumes_of_the_model(dip, angle, cell):
    """The fault and the outline of the model run obliquely through the columns."""
    scene = faulted(2040.0, dip)
    layers = {"Top/Base": 3, "below Base": 1}
    grid = gs.build_grid(scene, cell=cell, layers=layers, angle=angle)
    np.testing.assert_allclose(grid.table.volume, grid.table.exact, rtol=1e-3)
    assert grid.stair_steps["F1"][0] == 0
    assert not grid.inside_out.any()
    assert folds(grid) > 0.02


@pytest.mark.filterwarnings("ignore:.*miss their volume")  # of vertical pillars
@pytest.mark.parametrize("min_dip", [15.0, None])
def test_a_face_on_a_fault_is_between_cells_of_different_blocks(min_dip):
    """With vertical pillars the fault cuts columns: faces are between layers, too."""
    scene = faulted(2040.0, 35.0)
    layers = {"Top/Base": 6, "below Base": 3}
    grid = gs.build_grid(scene, cell=130, layers=layers, angle=40, min_dip=min_dip)
    assert pairs_without_a_face(grid) == 0
    assert len(grid.faces) > 0
    if min_dip is None:
        assert (grid.faces.axis == 2).sum() > 10

    # each face has active columns on both sides, in the grid
    nz, ny, nx = grid.shape
    i, j = grid.faces.column.T
    axis, layers = grid.faces.axis, grid.faces.layers
    assert (i + (axis == 0) < nx).all()
    assert (j + (axis == 1) < ny).all()
    assert (layers[:, 1] <= nz - (axis == 2)).all()
    assert (layers[:, 0] < layers[:, 1]).all()
    live = grid.actnum.any(axis=0)
    assert live[j, i].all()
    assert live[j + (axis == 1), i + (axis == 0)].all()


def test_a_fault_that_is_folded_below_a_point_is_passed_twice_and_parts_nothing():
    """Its two limbs lie 10 and 20 m below: from above both, as many crossings as none."""
    limbs = [[[-9, -9, z], [9, -9, z], [0, 9, z]] for z in (-10.0, -20.0)]
    inside = np.array([[True, False], [False, True]])
    below = Below(np.reshape(limbs, (-1, 3)), np.arange(6).reshape(2, 3), inside)
    levels = np.broadcast_to(np.array([0.0, -15.0, -30.0])[:, None, None], (3, 2, 2))
    assert below(levels)[:, 0, 0].tolist() == [False, True, False]


def test_gentle_faults_are_stair_steps_and_a_warning_names_them():
    with (
        pytest.warns(gs.GeosurfWarning, match="1 of 2 zones .* 'B' has 411 .* of 413") as missed,
        pytest.warns(gs.GeosurfWarning, match="'F1' is a stair-step at 39 of the 39") as found,
    ):
        grid = gs.build_grid(faulted(2030.0, 35.0), cell=100, layers={"Top/Base": 2}, min_dip=45)
    for said, kind in ((found, "stair-step"), (missed, "grid volume")):
        mine = [one for one in said if one.message.kind == kind]
        assert [one.filename for one in mine] == [__file__]  # the line of the user
    assert not grid.inside_out.any()
    coord = grid.coord
    np.testing.assert_array_equal(coord[..., :2], coord[..., 3:5])


@pytest.mark.parametrize("parallel", ["top", "base"])
def test_layers_of_one_thickness_pinch_out_at_the_other_side(parallel):
    scene = gs.Scene({"Top": plane(-1970), "Base": plane(-2030, 0.01)}, box=BOX)
    layers = {"Top/Base": {"thickness": 5.0, "parallel": parallel}}
    grid = gs.build_grid(scene, cell=(200, 400), layers=layers)
    assert grid.shape[0] == 12
    thick = -np.diff(grid.levels, axis=0)
    ends = thick[0] if parallel == "top" else thick[-1]
    np.testing.assert_allclose(ends, 5.0)
    assert not grid.actnum.all()
    np.testing.assert_allclose(grid.volumes[~grid.actnum], 0.0, atol=1e-6)
    np.testing.assert_allclose(grid.table.volume, grid.table.exact, rtol=1e-9)


def test_limited_thickness_is_not_negative_and_has_the_same_mean():
    corners = np.random.default_rng(1).normal(1.0, 2.0, (500, 2, 2))
    corners = corners[corners.mean(axis=(1, 2)) >= 0]
    found = limited(corners)
    assert (found >= 0).all()
    np.testing.assert_allclose(found.mean(axis=(1, 2)), corners.mean(axis=(1, 2)), atol=1e-12)


def test_grdecl_has_all_corners_and_the_same_bytes_twice(planes, tmp_path):
    grid = gs.build_grid(planes, cell=400, layers=2)
    path = tmp_path / "model.grdecl"
    gs.write(grid, path)
    gs.write(gs.build_grid(planes, cell=400, layers=2), tmp_path / "again.grdecl")
    text = path.read_text()
    assert text.replace("model", "again") == (tmp_path / "again.grdecl").read_text()
    words = text.split("ZCORN\n")[1].split("/")[0].split()
    np.testing.assert_allclose(-np.array(words, float), grid.zcorn.ravel(), atol=6e-4)
    assert text.count("'F1'") == len(grid.faces) > 0
    inc = gs.write(grid, tmp_path / "model.inc")[0].read_text()
    found = []
    for word in inc.split("FIPNUM\n")[1].split("/")[0].split():
        n, _, value = word.rpartition("*")
        found += [int(value)] * int(n or 1)
    np.testing.assert_array_equal(found, grid.unit.ravel() + 1)
    assert "-- REGION 1: B\n-- REGION 2: A\nREGION\n" in inc


def test_cells_are_in_the_regions_of_their_units(planes):
    named = planes.replace(regions={"West": ("F1-",)})
    grid = gs.build_grid(named, cell=400, layers=2)
    assert set(grid.region_names) == {"West", "B"}
    for row, (zone, block) in enumerate(grid.unit_names):
        assert grid.unit_regions[row] == named.regions.of(zone, block)
    sums = grid.table.volume.groupby(grid.table.region).sum()
    for k, name in enumerate(grid.region_names):
        mine = grid.region == k
        assert grid.volumes[mine].sum() == pytest.approx(float(sums.sel(region=name)), rel=1e-12)
    assert ((grid.region < 0) == ~grid.actnum).all()


def test_a_grid_covers_the_reservoir_or_all():
    levels = {"A": -1900.0, "B": -1950.0, "C": -2000.0, "D": -2050.0}
    horizons = {name: plane(z) for name, z in levels.items()}
    scene = gs.Scene(horizons, box=BOX, reservoir=["B/C"])
    zones = ("above A", "A/B", "B/C", "C/D", "below D")
    assert gs.build_grid(scene, cell=1000, layers=1).zone_names == ("B/C",)
    whole = gs.build_grid(scene, cell=1000, layers=1, include="all")
    assert whole.zone_names == zones
    assert {name for name, _ in whole.unit_names} == set(zones)
    refused(InputError, "include is 'every'", gs.build_grid, scene, cell=1000, include="every")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"cell": (0, 10)}, "size of a cell"),
        ({"cell": 1e-3}, "larger cells"),
        ({"layers": {"Top/Bse": 3}}, "Top/Base"),
        ({"layers": {"above Top": 1, "below Base": 1}}, "leaves out 'Top/Base'"),
        ({"layers": {"Top/Base": {"thickness": 1e-9, "parallel": "top"}}}, "limit"),
        ({"angle": "north"}, "degrees"),
        ({"min_thickness": -1}, "min_thickness"),
        ({"min_dip": 95}, "min_dip"),
    ],
)
def test_arguments_that_cannot_be_used_are_refused(planes, change, words):
    refused(gs.errors.InputError, words, gs.build_grid, planes, **change)


def test_virtual_walls_bound_volumes_and_are_no_faults_of_the_deck():
    x = [[1500, -10, -1500], [2300, 2000, -1500], [1500, -10, -2500], [2300, 2000, -2500]]
    wall = gs.TriSurface("F1", "fault", x, [[0, 2, 1], [1, 2, 3]])
    horizons = {"Top": plane(-1970, 0.01), "Middle": plane(-1990), "Base": plane(-2030, -0.01)}
    box = (100, 3900, 100, 3900, -2200, -1800)
    scene = gs.Scene(horizons, {"F1": wall}, box, compartments={"F1": "boundary"})
    grid = gs.build_grid(scene, cell=110, layers=2)
    assert len(grid.block_names) == 2
    np.testing.assert_allclose(grid.table.volume, grid.table.exact, rtol=1e-3)
    assert grid.fault_names == ("F1",)
    assert len(grid.faces) > 0

    # north of the fault only its wall parts both blocks
    assert grid.faces.column[:, 1].max() < 0.6 * grid.shape[1]


@pytest.mark.parametrize(("seed", "cell"), [(941066, 30.0), (941016, 15.0), (941072, 30.0)])
def test_blocks_in_star_shaped_areas_have_the_volumes_of_the_model(seed, cell):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 14))
    angle, radius = np.sort(rng.uniform(0, 2 * np.pi, n)), rng.uniform(60, 390, n)
    ring = 500 + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    x = [[333, -50, -1200], [483, -50, -2600], [700, 1100, -1200], [850, 1100, -2600]]
    wall = gs.TriSurface("F1", "fault", x, [[0, 1, 2], [1, 3, 2]])
    horizons = {"Top": plane(-1700, -0.1), "Base": plane(-1900, -0.1)}
    scene = gs.Scene(horizons, {"F1": wall}, (100, 900, 100, 900, -2500, -1300), aoi=ring)
    grid = gs.build_grid(scene, cell=cell, layers=3)
    large = grid.columns_of_units > 10
    off = (grid.table.volume / grid.table.exact - 1).values[large]
    assert np.abs(off).max(initial=0.0) < 1e-3
