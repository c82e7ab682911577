"""Which unit is where: against shells and rational rays, on lattices where contacts are common."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import GeometryError, InputError
from geosurf.measure.locate import locator_of
from tests.grids import gridded
from tests.measure.rays import unit_by_rays
from tests.messages import refused
from tests.strategies import BOX, UTM, faulted_worlds, sheet

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")


def corners_and_middles(units, rng, n):
    """Local points that lie on vertices, edges and faces more often than not."""
    origin = next(iter(units.values())).origin
    low, high = np.reshape(units.box, (3, 2)).T - origin
    halves = low + 0.5 * rng.integers(-1, (2 * (high - low)).astype(int) + 2, (n, 3))
    vertices = np.concatenate([u.local for u in units.values()])
    picked = vertices[rng.integers(len(vertices), size=n)]
    return np.concatenate([halves, picked, 0.5 * (picked + picked[::-1])])


def assert_exact(units, seed):
    """Compare with rays through shells, at points of which most lie on something."""
    origin = next(iter(units.values())).origin
    world = corners_and_middles(units, np.random.default_rng(seed), 10) + origin
    locator = locator_of(units)
    assert locator.find(world).tolist() == unit_by_rays(units, world - origin)

    # all points of a line at once: levels on surfaces, floor and top, too
    levels = np.unique(np.concatenate([world[:, 2], np.arange(-5, 9.5) + origin[2]]))
    of_lines = locator.find_on_lines(world[:, :2], levels)
    each = np.concatenate([np.broadcast_to(p, (len(levels), 2)) for p in world[:, :2]])
    points = np.column_stack([each, np.tile(levels, len(world))])
    assert (of_lines.ravel() == locator.find(points)).all()


@settings(max_examples=10)
@given(faulted_worlds(), st.integers(0, 2**32))
def test_triangles_agree_with_rays(surfaces, seed):
    try:
        units = gs.carve_units(gs.rebuild_surfaces(surfaces))
    except GeometryError:
        return
    assert_exact(units, seed)


@st.composite
def gridded_worlds(draw):
    """Grids on whole numbers, rotated by 3-4-5 or not, perhaps a fault, a contact, UTM."""
    shift = draw(st.sampled_from([(0.0, 0.0, 0.0), UTM]))
    turn = draw(st.sampled_from([(1, 0), (0, 1), (-1, 0), (4, 3), (3, -4)]))
    row, col = np.mgrid[-6:7, -6:7] * (1.0 if turn[0] * turn[1] == 0 else 0.5)
    x, y = 2.0 + turn[0] * col - turn[1] * row, 2.0 + turn[1] * col + turn[0] * row
    horizons = {}
    for k in range(draw(st.integers(1, 3))):
        some = draw(st.lists(st.integers(0, 2), min_size=13, max_size=13))
        z = np.array(some)[(np.arange(13)[:, None] * 5 + np.arange(13) * 3) % 13] - 2.0 * k
        axes = (x[0], y[:, 0]) if turn == (1, 0) else (x, y)
        horizons[f"H{k}"] = gridded(z + shift[2], axes[0] + shift[0], axes[1] + shift[1])
    faults = {}
    if draw(st.booleans()):
        at, lean = draw(st.integers(1, 3)), draw(st.integers(-1, 1))
        ends = [(at - lean, -1, -5), (at - lean, 5, -5), (at + lean, 5, 9), (at + lean, -1, 9)]
        faults["F1"] = sheet("F1", np.array(ends) + shift, (2, 2))
    contacts = {"OWC": shift[2] - 0.5} if draw(st.booleans()) else {}
    box = tuple((np.reshape(BOX, (3, 2)) + np.array(shift)[:, None]).ravel())
    return gs.Scene(horizons, faults, box, contacts=contacts)


@settings(max_examples=10)
@given(gridded_worlds(), st.integers(0, 2**32))
def test_grids_agree_with_rays(scene, seed):
    try:
        units = scene.units
    except GeometryError:
        return
    assert_exact(units, seed)


@pytest.fixture(scope="module")
def scene(graben):
    return graben.replace(contacts={"OWC": -2100.0})


def test_names_are_those_of_units(scene):
    w, e, s, n, low, high = scene.box
    rng = np.random.default_rng(4)
    points = np.array([w, s, low]) + rng.random((500, 3)) * np.array([e - w, n - s, high - low])
    found = scene.sample(points)
    for k, name in enumerate(found.unit.values):
        unit = scene.units[name]
        assert (unit.zone, unit.block, unit.contact) == tuple(
            found[label].values[k] for label in ("zone", "block", "contact")
        )
    codes = scene.sample(points, codes=True)
    for label in found.data_vars:
        names = np.array(codes[label].attrs["names"], dtype=object)
        assert (names[codes[label].values] == found[label].values).all()


def test_one_question_in_many_words(scene):
    """Arrays, tables, datasets, maps and grids give the same answers; depths and feet too."""
    w, e, s, n, low, high = scene.box
    x, y, z = np.linspace(w, e, 4), np.linspace(s, n, 5), np.linspace(low, high, 6)
    k, i, j = (part.ravel() for part in np.mgrid[:6, :5, :4])
    points = np.stack([x[j], y[i], z[k]], axis=1)
    names = scene.sample(points).unit.values
    table = dict(zip(("easting", "northing", "elevation"), points.T, strict=True))
    axes = {"elevation": z, "northing": y, "easting": x}
    feet = {"positive": "down", "units": "ft"}
    deep = xr.Dataset({"elevation": ("point", -points[:, 2] / 0.3048, feet)}).assign_coords(
        easting=("point", points[:, 0]), northing=("point", points[:, 1])
    )
    assert (scene.sample(table).unit.values == names).all()
    grid = scene.sample(xr.Dataset(coords=axes))
    assert grid.unit.dims == ("elevation", "northing", "easting")
    assert (grid.unit.values.ravel() == names).all()
    level = gridded(np.full((5, 4), z[2]), x, y).drop_attrs()
    assert (scene.sample(level).unit.values == grid.unit.values[2]).all()
    inner = slice(1, 5)  # the floor and the top move by rounding of feet
    of = scene.sample(deep).unit.values.reshape(6, 5, 4)
    assert (of[inner] == grid.unit.values[inner]).all()
    assert scene.sample(points[0]).unit.shape == ()
    assert scene.sample(points.reshape(6, 20, 3)).unit.dims == ("point_0", "point_1")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "sample takes either places or cell="),
        ({"where": [[1.0, 2.0]]}, "the last size must be 3"),
        ({"where": [[1.0, 2.0, np.nan]]}, "place 0 has a coordinate that is not finite"),
        ({"cell": (0, 1, 1)}, "give three sizes above 0"),
        ({"where": xr.Dataset(coords={"x": [1]})}, "no 'easting' and no 'northing'"),
    ],
)
def test_refusals_say_what_to_type(scene, arguments, words):
    refused(InputError, words, scene.sample, **arguments)


def test_distances_are_those_to_all_triangles(scene):
    """Against every triangle of every shell, by hand; outside the model, too."""
    w, e, s, n, low, high = scene.box
    rng = np.random.default_rng(5)
    size = np.array([e - w, n - s, high - low])
    points = np.array([w, s, low]) + (1.4 * rng.random((60, 3)) - 0.2) * size
    found = scene.sample(points, distance=True).distance.values
    corners = np.concatenate([u.vertices[u.triangles] for u in scene.units.values()])
    assert np.abs(found - [to_triangles(corners, p) for p in points]).max() < 1e-8


def to_triangles(corners, p):
    """Distance of a point to the nearest triangle (n, 3, 3): interior, edges and corners."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    gram = np.stack([(u * u).sum(1), (u * v).sum(1), (v * v).sum(1)])
    right = np.stack([((p - a) * u).sum(1), ((p - a) * v).sum(1)])
    det = gram[0] * gram[2] - gram[1] ** 2
    s, t = (gram[2] * right[0] - gram[1] * right[1]), (gram[0] * right[1] - gram[1] * right[0])
    s, t = s / det, t / det
    inside = (s >= 0) & (t >= 0) & (s + t <= 1)
    foot = a + s[:, None] * u + t[:, None] * v
    best = np.linalg.norm(foot - p, axis=1)[inside].min(initial=np.inf)
    for i, k in ((0, 1), (1, 2), (2, 0)):
        one, way = corners[:, i], corners[:, k] - corners[:, i]
        at = np.clip(((p - one) * way).sum(1) / (way**2).sum(1), 0, 1)
        best = min(best, np.linalg.norm(one + at[:, None] * way - p, axis=1).min())
    return best


class TestWells:
    def test_add_up_and_meet(self, scene):
        """Intervals follow each other, lengths add up, and the middle of each is in its unit."""
        w, e, s, n, low, high = scene.box
        rng = np.random.default_rng(8)
        path = np.array([w, s, low]) + rng.random((6, 3)) * np.array([e - w, n - s, high - low])
        length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
        found = scene.well_intervals(path, md=length)
        md = found.md.values
        assert (md[1:, 0] == md[:-1, 1]).all()
        assert md[-1, 1] == pytest.approx(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        assert (found.unit.values[1:] != found.unit.values[:-1]).all()

        # measured depth is not known where a path begins below sea level, and else is its length
        assert path[0, 2] < 0
        unknown = scene.well_intervals(path)
        assert np.isnan(unknown.md).all()
        assert unknown.drop_vars("md").identical(found.drop_vars("md"))
        drilled = scene.well_intervals([(*path[0, :2], 25.0), *path])
        assert drilled.md.values.max() == pytest.approx(length[-1] + 25.0 - path[0, 2])

        # by brute force: the unit at many places along the path
        at = np.linspace(0.0, md[-1, 1], 4001)[1:-1]
        along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
        points = np.stack([np.interp(at, along, path[:, k]) for k in range(3)], axis=1)
        which = np.searchsorted(md[:, 1], at)
        off = np.abs(at[:, None] - md.ravel()).min(axis=1) > 1e-6
        same = scene.sample(points).unit.values == found.unit.values[which]
        assert same[off].all()

    def test_a_well_straight_down_a_fault(self, scene):
        """Inside of an upright fault, the well is on the side of the middle, all the way."""
        world = gs.Scene(
            {"Top": gridded(np.zeros((3, 3)), [0.0, 5, 10])},
            {"F1": sheet("F1", [(3, -1, -9), (3, 11, -9), (3, 11, 9), (3, -1, 9)])},
            (0, 10, 0, 10, -5, 5),
        )  # fmt: skip
        found = world.well_intervals([(3.0, 4.0, 5.0), (3.0, 4.0, -5.0)])
        assert found.zone.values.tolist() == ["above Top", "below Top"]
        assert len(set(found.block.values)) == 1
        assert found.elevation.values.tolist() == [[5.0, 0.0], [0.0, -5.0]]

    def test_many_are_one_table(self, scene, tmp_path):
        """A mapping, a table and one call for each well agree; csv has one row per interval."""
        w, e, s, n, low, high = scene.box
        rng = np.random.default_rng(3)
        size = np.array([e - w, n - s, high - low])
        wells = {name: np.array([w, s, low]) + rng.random((3, 3)) * size for name in ("B", "A")}
        for path in wells.values():
            path[0, 2] = 5.0
        found = scene.well_intervals(wells)
        for name, path in wells.items():
            one = scene.well_intervals(path)
            same = found.isel(interval=np.flatnonzero(found.well.values == name))
            assert same.drop_vars("well").identical(one)

        # rows of two wells that alternate belong to their wells
        table = {"well": ["B", "A"] * 3}
        for k, key in enumerate(("easting", "northing", "elevation")):
            table[key] = np.stack([wells["B"][:, k], wells["A"][:, k]], axis=1).ravel()
        for form in (table, pd.DataFrame(table), pd.DataFrame(table).to_xarray()):
            assert scene.well_intervals(form).identical(found)
        gs.write(found, tmp_path / "wells.csv")
        rows = pd.read_csv(tmp_path / "wells.csv", dtype=str)
        assert rows.well.tolist() == found.well.values.tolist()
        assert rows.md_exit_m.map(float).tolist() == found.md.sel(end="exit").values.tolist()

    @pytest.mark.parametrize(
        ("path", "md", "words"),
        [
            ({}, None, "wells have no names"),
            ({"W": [[0, 0, 0]]}, None, "well 'W': the path of a well needs"),
            (
                {"well": ["W", None], "easting": [0, 0], "northing": [0, 0], "elevation": [0, 1]},
                None,
                "row 2 has none",
            ),
            ([[0, 0, 0]], None, "at least two different points"),
            ([[0, 0, 0], [0, 0, 1]], [1, 0], "md does not rise from point 0 to 1"),
        ],
    )
    def test_refusals(self, scene, path, md, words):
        refused(InputError, words, scene.well_intervals, path, md=md)
