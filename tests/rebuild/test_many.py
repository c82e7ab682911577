"""Some of the worlds of `many`, and those in which it found something."""

from __future__ import annotations

import re

import numpy as np
import pytest

from geosurf import build_walls, carve_units, rebuild_surfaces
from geosurf.errors import GeometryError, OpenUnitError, RoundingError
from geosurf.model import Units
from tests import oracles
from tests.messages import refused
from tests.rebuild import many, spaces
from tests.rebuild.worlds import boxed_world
from tests.strategies import BOX, sheet

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
    assert [many.check(seed) for seed in (39, 103, 343)] == ["open"] * 3
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
