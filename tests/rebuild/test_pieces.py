"""A lattice kept as runs is split as its list of triangles is."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf import TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.conventions import place
from geosurf.errors import GeometryError, OpenUnitError, RoundingError
from geosurf.model import Lattice, Units
from geosurf.rebuild import drop_triangles, repair, trim_sheets
from geosurf.rebuild.ghosts import kept_parts
from tests import laws, oracles
from tests.grids import ring_area
from tests.messages import refused
from tests.rebuild import many, spaces
from tests.rebuild.worlds import boxed_world
from tests.strategies import BOX, as_list, grid, sheet


@st.composite
def gridded_scenes(draw):
    """Horizons as lattices of small integers with holes, and a fault as a curtain lattice."""
    surfaces = []
    for name in ("Top", "Base")[: draw(st.integers(1, 2))]:
        n_row, n_col = draw(st.integers(2, 6)), draw(st.integers(2, 6))
        n = n_row * n_col
        z = np.array(draw(st.lists(st.integers(0, 7), min_size=n, max_size=n)), dtype=float)
        z[z < draw(st.sampled_from([0, 1]))] = np.nan
        step = draw(st.sampled_from([1.0, 2.0]))
        lattice = Lattice(
            step * np.arange(n_col), step * np.arange(n_row), z.reshape(n_row, n_col),
            draw(st.booleans()),
        )  # fmt: skip
        if lattice.n_triangle:
            surfaces.append(TriSurface(name, "horizon", lattice=lattice))
    x = np.array(draw(st.lists(st.integers(0, 6), min_size=3, max_size=3)), dtype=float)
    dip = draw(st.sampled_from([0.0, 1.0, 2.0]))
    easting = np.stack([x, x + dip])
    northing = np.tile([-1.0, 3.0, 11.0], (2, 1))
    elevation = np.array([[9.0, 9, 9], [-2.0, -2, -2]])
    fault = Lattice(easting, northing, elevation, draw(st.booleans()), draw(st.booleans()))
    return [*surfaces, TriSurface("F1", "fault", lattice=fault)]


@given(gridded_scenes(), st.integers(0, 2**32 - 1))
def test_sheets_are_trimmed_without_listing_runs(surfaces, seed):
    rng = np.random.default_rng(seed)
    sheets = []
    for one in map(as_list, surfaces[:-1]):
        outer = rng.random(one.n_vertex) < 0.2
        marks = {"ghost": outer | (rng.random(one.n_vertex) < 0.3), "outer": outer}
        sheets.append(
            TriSurface(one.name, one.role, one.vertices, one.triangles, vertex_data=marks)
        )
    patches = rebuild_surfaces([*sheets, surfaces[-1]])
    trimmed = trim_sheets(patches)
    plain = drop_triangles(patches, kept_parts(patches)[0])
    laws.assert_same_bytes(trimmed, plain)
    assert trimmed.report == plain.report
    assert trimmed.n_patch == plain.n_patch

    # rings are those of the mesh as a whole, as far as it is listed
    pieces = trimmed.pieces
    rows = np.flatnonzero(trimmed.pieces.expanded.element < len(pieces.triangles))
    if len(rows) == trimmed.n_triangle:
        np.testing.assert_array_equal(pieces.ring, plain.pieces.ring)
        np.testing.assert_array_equal(pieces.link, plain.pieces.link)


# ---- Where the exact result cannot be held, or the box is open: a sentence, a place, the surfaces.
@pytest.mark.parametrize("turned", [False, True])
def test_round_inputs_that_no_step_moves_are_shifted(turned):
    """Two faults cross half way up a wall, on its diagonal but for the rounding of its corners."""
    box, ring = (0, 8, 0, 8, 0, 8), [(0.3, 0.1), (7.7, 0.4), (7.9, 7.7), (0.6, 7.8)]
    one = sheet("F1", [(-1, -1, 9), (9, -1, -1), (9, 9, -1), (-1, 9, 9)])
    two = sheet("F2", [(-1, -1, -1), (9, -1, 9), (9, 9, 9), (-1, 9, -1)])
    walls = build_walls(box, ring)
    faults = [two, one] if turned else [one, two]
    patches = rebuild_surfaces([*faults, *walls])
    assert patches.report["moved_vertices"] > 0
    assert 0 < patches.report["largest_move"] <= np.sqrt(3) * 1.5 * repair.SHIFT
    units = carve_units(patches)
    assert all(check.passed for check in certify(patches, units).checks)
    area = ring_area(ring)
    assert sum(unit.volume for unit in units.values()) == pytest.approx(8 * area, rel=1e-12)
    volumes = [units[f"box {block}"].volume for block in ("F1+ F2+", "F1- F2-")]
    assert volumes == pytest.approx([2 * area] * 2, rel=0.2)
    for name, fault in (("F1", one), ("F2", two)):  # as far as it says, whatever the order
        used = next(s for s in patches.sources if s.name == name)
        far = np.linalg.norm(used.vertices - fault.vertices, axis=1)
        assert far.max() <= patches.report["largest_move"]


def test_a_result_that_cannot_be_held_is_refused_with_its_place(monkeypatch):
    """Steps too fine to help: the fault through horizon nodes at rounded thirds stays as it is."""
    monkeypatch.setattr(repair, "STEPS", (2.0**-60,))
    monkeypatch.setattr(repair, "SHIFT", 2.0**-60)
    top = grid("Top", np.random.default_rng(3).integers(0, 4, (6, 6)))
    wall = sheet("F1", [(1, -1, -1), (3, 9, -1), (3, 9, 5), (1, -1, 5)], (3, 3))
    words = r"float64 cannot represent .*, the first of surface '\w+' at \(E .*Move one of"
    error = refused(RoundingError, words, rebuild_surfaces, [top, wall])
    assert set(error.surfaces) == {"Top", "F1"}
    assert error.surfaces[0] in str(error)
    assert place(error.place) in str(error)
    corners = np.concatenate([top.vertices, wall.vertices])
    assert (corners == error.place).all(axis=1).any()


# ---- Some of the worlds of `many`, and those in which it found something.
FOUND = {
    519: "a repair moved more neighbours of a list than of its lattice",
    8272: "vertices were numbered by which pairs the search called near",
    621127: "a repair moved what touches in a point, of lists only",
    8972: "patches of a surface on itself and another depended on their order",
    910103: "a fault on a wall that hangs in a unit, too, was told to bound it",
}


@pytest.mark.parametrize("seed", range(24))
def test_small_worlds(seed):
    assert many.check(seed) in many.ENDS


@pytest.mark.parametrize("seed", FOUND)
def test_worlds_in_which_something_was_found(seed):
    assert many.check(seed) in ("rebuilt", "carved"), FOUND[seed]


def test_worlds_that_leak():
    """Of H1 and of H2; a horizon may end in the box only where it is taken away."""
    assert [many.check(seed) for seed in (39, 343)] == ["open"] * 2
    assert many.check(901) == "empty"


def test_a_horizon_with_a_hole_over_the_box_is_beyond_it():
    """Its bounds are around the box; and one that touches a corner of it."""
    assert [many.check(seed) for seed in (38311, 35543)] == ["beyond"] * 2


# ------------------------------------------------------------ oracles can tell, too
def nested():
    """A box in a box, which touch nowhere, and a fault that dangles in the inner one."""
    outer, inner = build_walls((0, 9, 0, 9, 0, 9)), build_walls((2, 6, 2, 6, 2, 6))
    inner = [s.renamed(f"{s.name} of F", "fault") for s in inner]
    patches = rebuild_surfaces([sheet("F1", [(4, 3, 3), (4, 5, 3), (4, 5, 5), (4, 3, 5)]),
                                *inner, *outer])  # fmt: skip
    return patches, np.array([patches.names[i] for i in patches.surface_of_triangle])


def test_parts_of_space_in_each_other():
    patches, names = nested()
    parts = spaces.beside(patches.local, patches.triangles)
    shell = np.char.endswith(names, " of F")
    assert (parts[names == "F1"] == parts[names == "F1"][0, 0]).all()
    within = parts[names == "F1"][0, 0]
    (between,) = set(parts[shell].ravel().tolist()) - {within}
    assert set(parts[~shell & (names != "F1")].ravel().tolist()) == {0, between}
    assert len({0, within, between}) == oracles.n_cell(patches.triangles) + 1 == 3
    turned = spaces.beside(patches.local, patches.triangles[:, ::-1])
    assert (turned[:, ::-1] == parts).all()


def test_units_exchanged_in_a_part_of_space_are_seen():
    surfaces = [*boxed_world(23), *build_walls(BOX)]
    patches = rebuild_surfaces(surfaces, self_intersections=True)
    units = carve_units(patches)
    many.assert_cells(patches, units)
    rows = many.inner(patches)
    sides = units.sides.copy()
    inside = rows[(sides[rows] >= 0).all(axis=1)]
    assert len(inside) > 1
    sides[inside[0], 0] = (sides[inside[0], 0] + 1) % len(units)
    wrong = Units(units.values(), units.box, report=units.report, sides=lambda: sides)
    refused(AssertionError, "is in two units", many.assert_cells, patches, wrong)


def test_refusals_without_a_reason_are_broken_promises(monkeypatch):
    patches = rebuild_surfaces([*boxed_world(23), *build_walls(BOX)], self_intersections=True)
    with pytest.raises(AssertionError, match="does not leak"):
        many.assert_open(patches, OpenUnitError("100 m of its rim", surfaces=("H1",)))
    with pytest.raises(AssertionError, match="nothing around is"):
        many.assert_open(patches, OpenUnitError("cannot determine whether", surfaces=("H1",)))
    beyond = GeometryError("does not reach the model box", surfaces=("H1",))
    refused(AssertionError, "H1 is in the box", many.assert_beyond, patches, beyond)
    monkeypatch.setattr(many, "rebuild_surfaces", refuse)
    for seed in (0, 7):
        refused(AssertionError, "refused: cannot be held", many.check, seed)


def test_leaks_of_another_length_or_place_are_broken_promises():
    patches = rebuild_surfaces([*boxed_world(103), *build_walls(BOX)], self_intersections=True)
    with pytest.raises(OpenUnitError) as caught:
        carve_units(patches)
    error, words = caught.value, str(caught.value)
    many.assert_open(patches, error)
    about = {"place": error.place, "surfaces": error.surfaces}
    told = re.search(r"([0-9.]+) m of its rim", words).group(1)
    more = words.replace(f"{told} m", f"{1.01 * float(told)} m")
    with pytest.raises(AssertionError):
        many.assert_open(patches, OpenUnitError(more, **about))
    about["place"] = np.add(error.place, (0.0, 0.0, 0.01))
    with pytest.raises(AssertionError, match="is not on the rim"):
        many.assert_open(patches, OpenUnitError(words, **about))


def refuse(*surfaces, **options):
    raise RoundingError("cannot be held")
