"""Which unit is where: against shells and rational rays, on lattices where contacts are common."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import GeometryError, InputError
from geosurf.measure import sample_units
from geosurf.measure.locate import locator_of
from tests.strategies import BOX, UTM, faulted_worlds, sheet

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

TINY = [Fraction(1, 2**200), Fraction(1, 2**400), Fraction(1, 2**600)]


def unit_by_rays(units, points):
    """Row of the unit of each point (n, 3), local: rational rays through every shell.

    The point is really moved by what the rule says: down (or up from the floor), then towards the
    middle to the east or west, then to the north or south, each infinitely less than before.
    """
    w, e, s, n, bottom, _ = units.box
    origin = next(iter(units.values())).origin
    middle = 0.5 * (w + e) - origin[0], 0.5 * (s + n) - origin[1]
    shells = [u.local[u.triangles] for u in units.values()]
    found = []
    for point in points:
        east, north = (1 if point[k] <= middle[k] else -1 for k in (0, 1))
        up = 1 if point[2] == bottom - origin[2] else -1
        p = [
            Fraction(float(c)) + way * move
            for c, way, move in zip(point, (east, north, up), np.roll(TINY, -1), strict=True)
        ]
        inside = [k for k, shell in enumerate(shells) if passed(shell, point, p) % 2]
        assert len(inside) <= 1  # units do not overlap
        found.append(inside[0] if inside else -1)
    return found


def passed(shell, near, p):
    """How many triangles of a shell are straight above a point."""
    # boxes that the ray cannot meet, with a metre to spare, need no fractions
    low, high = shell[:, :, :2].min(axis=1) - 1.0, shell[:, :, :2].max(axis=1) + 1.0
    maybe = ((low <= near[:2]) & (high >= near[:2])).all(axis=1)
    maybe &= shell[:, :, 2].max(axis=1) >= near[2] - 1.0
    return sum(above([[Fraction(float(c)) for c in v] for v in face], p) for face in shell[maybe])


def above(face, p):
    """Whether a triangle is straight above a point, which is on no edge and in no plane."""
    a, b, c = face
    turns = [
        (v[0] - u[0]) * (p[1] - u[1]) - (v[1] - u[1]) * (p[0] - u[0])
        for u, v in ((a, b), (b, c), (c, a))
    ]
    if not (all(t > 0 for t in turns) or all(t < 0 for t in turns)):
        return False
    z = (a[2] * turns[1] + b[2] * turns[2] + c[2] * turns[0]) / sum(turns)
    return z > p[2]


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
    assert locator_of(units).find(world).tolist() == unit_by_rays(units, world - origin)


@settings(max_examples=25, deadline=None)
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
        of = {"easting": (("row", "col"), x + shift[0]), "northing": (("row", "col"), y + shift[1])}
        if turn == (1, 0):
            of = {"easting": x[0] + shift[0], "northing": y[:, 0] + shift[1]}
        dims = ("row", "col") if turn != (1, 0) else ("northing", "easting")
        horizons[f"H{k}"] = xr.DataArray(
            z + shift[2], of, dims, attrs={"positive": "up", "units": "m"}
        )
    faults = {}
    if draw(st.booleans()):
        at, lean = draw(st.integers(1, 3)), draw(st.integers(-1, 1))
        ends = [(at - lean, -1, -5), (at - lean, 5, -5), (at + lean, 5, 9), (at + lean, -1, 9)]
        faults["F1"] = sheet("F1", np.array(ends) + shift, (2, 2))
    contacts = {"OWC": shift[2] - 0.5} if draw(st.booleans()) else {}
    box = tuple((np.reshape(BOX, (3, 2)) + np.array(shift)[:, None]).ravel())
    return gs.Scene(horizons, faults, box, contacts=contacts)


@settings(max_examples=30, deadline=None)
@given(gridded_worlds(), st.integers(0, 2**32))
def test_grids_agree_with_rays(scene, seed):
    try:
        units = scene.units
    except GeometryError:
        return
    assert_exact(units, seed)


@pytest.fixture(scope="module")
def scene():
    world = gs.synthetic.graben(n=21)
    return gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2100.0})


def test_counts_of_cells_converge_to_volumes(scene):
    found = scene.sample(cell=(40, 40, 4), codes=True)
    counts = np.bincount(found.unit.values.ravel(), minlength=len(scene.units))
    w, e, s, n, low, high = scene.box
    volumes = counts * (e - w) * (n - s) * (high - low) / found.unit.size
    assert (found.unit >= 0).all()
    assert np.abs(volumes - scene.volumes.values).max() < 2e-3 * scene.units.box_volume
    assert volumes.sum() == pytest.approx(scene.units.box_volume, rel=1e-12)


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
    level = xr.DataArray(
        np.full((5, 4), z[2]), {"northing": y, "easting": x}, ("northing", "easting")
    )
    assert (scene.sample(level).unit.values == grid.unit.values[2]).all()
    inner = slice(1, 5)  # the floor and the top move by rounding of feet
    of = scene.sample(deep).unit.values.reshape(6, 5, 4)
    assert (of[inner] == grid.unit.values[inner]).all()
    assert scene.sample(points[0]).unit.shape == ()
    assert scene.sample(points.reshape(6, 20, 3)).unit.dims == ("point_0", "point_1")


def test_a_horizon_belongs_to_the_zone_below(scene):
    """At the nodes of a horizon, to the last bit: no tolerance moves a point off it."""
    top = scene.surface("Top")
    inside = (np.abs(top.vertices[:, :2] - top.vertices[:, :2].mean(axis=0)) < 500).all(axis=1)
    at = top.vertices[inside]
    up = np.stack([*at.T[:2], np.nextafter(at[:, 2], np.inf)], axis=1)
    assert set(scene.sample(at).zone.values) == {"Top/Middle"}
    assert set(scene.sample(up).zone.values) == {"above Top"}


def test_nothing_and_outside(scene):
    assert scene.sample(np.empty((0, 3))).unit.shape == (0,)
    far = scene.sample([[1e9, 0.0, 0.0], [-1e9, 1e7, -1e12]])
    assert far.unit.values.tolist() == ["", ""]
    assert scene.sample([1e9, 0, 0], codes=True).zone.item() == -1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "sample takes either places or cell="),
        ({"where": [[1.0, 2.0]]}, "the last size must be 3"),
        ({"where": "here"}, "places are not numbers"),
        ({"where": [[1.0, 2.0, np.nan]]}, "place 0 has a coordinate that is not finite"),
        ({"where": {"easting": [1], "northing": [2]}}, "the table has no column 'elevation'"),
        ({"cell": (0, 1, 1)}, "give three sizes above 0"),
        ({"cell": (1e-3, 1e-3, 1e-3)}, "Give larger ones"),
        ({"where": xr.Dataset(coords={"x": [1]})}, "no 'easting' and no 'northing'"),
        ({"where": [1, 2, 3], "codes": "yes"}, "codes is 'yes'"),
    ],
)
def test_refusals_say_what_to_type(scene, arguments, words):
    with pytest.raises(InputError, match=words):
        scene.sample(**arguments)


def test_units_without_patches_are_refused(scene):
    units = gs.Units(scene.units.values(), scene.box)
    with pytest.raises(InputError, match="no patches"):
        sample_units(units, [1, 2, 3])
