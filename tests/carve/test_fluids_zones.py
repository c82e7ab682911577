"""Fluid contacts limited to zones: they split these, leave others whole, and nothing gets lost."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf import FluidContact, Scene, carve_units, rebuild_surfaces
from geosurf.errors import InputError, OpenUnitError
from tests import laws
from tests.carve.test_fluids import (
    BASE,
    BOX,
    TOP,
    UPRIGHT,
    crosses,
    level,
    parts_of,
    tilted,
    volumes,
)
from tests.strategies import faulted_worlds, sheet

MIDDLE = level("Middle", 2)


def scene_of(contacts, faults=(UPRIGHT,)):
    horizons = {"Top": TOP, "Middle": MIDDLE, "Base": BASE}
    scene = Scene(horizons, {f.name: f for f in faults}, BOX, contacts=contacts)
    laws.assert_volumes_add_up(scene.units, BOX)
    return scene


def split(scene):
    """Zones and blocks that a contact splits."""
    return {(u.zone, u.block) for u in scene.units.values() if u.contact}


def test_each_zone_has_its_own_level_and_each_block_in_it():
    contacts = {
        "OWC": [
            FluidContact(2.5, zones=["Top/Middle"]),
            FluidContact(1.25, zones=["Middle/Base"]),
            FluidContact(1.75, zones=["Middle/Base"], block="F1+"),
        ]
    }
    scene = scene_of(contacts)
    assert volumes(scene, "Top/Middle")["F1+", "below OWC"] == pytest.approx(12 * 0.5)
    assert volumes(scene, "Top/Middle")["F1-", "below OWC"] == pytest.approx(4 * 0.5)
    assert volumes(scene, "Middle/Base")["F1+", "below OWC"] == pytest.approx(12 * 0.75)
    assert volumes(scene, "Middle/Base")["F1-", "below OWC"] == pytest.approx(4 * 0.25)
    names = {s.name for s in scene.patches.sources if s.role == "contact"}
    assert names == {"OWC in Top/Middle", "OWC in Middle/Base", "OWC in F1+ of Middle/Base"}
    # deeper in one zone than the other contact in the other: out of order nowhere
    swapped = {
        "GOC": FluidContact(1.25, zones="Middle/Base"),
        "OWC": FluidContact(2.5, zones="Top/Middle"),
    }
    assert {u.contact for u in scene_of(swapped).units.values()} == {
        "", "above GOC", "below GOC", "above OWC", "below OWC"
    }  # fmt: skip


def test_a_grid_need_not_reach_zones_that_are_not_named():
    """A grid that ends inside a zone leaks where it counts, and nowhere else."""
    part = tilted("level", 2, 3)
    low = part.vertices.copy()
    low[:, 0] = np.where(low[:, 0] > 0, 2.0, low[:, 0])  # ends at x = 2, at z = 3.25: in Top/Middle
    short = type(part)("level", "surface", low, part.triangles)
    whole = scene_of({"OWC": FluidContact(short, zones="below Base")})
    assert split(whole) == {("below Base", "F1+"), ("below Base", "F1-")}
    with pytest.raises(OpenUnitError, match="leak around contact 'OWC in Top/Middle'"):
        scene_of({"OWC": FluidContact(short, zones="Top/Middle")})


@pytest.mark.parametrize(
    ("contacts", "words"),
    [
        (
            {"OWC": FluidContact(1.5, zones="Midle/Base")},
            r"unknown zone 'Midle/Base'. Zones are \['above Top', .* mean 'Middle/Base'\?",
        ),
        (
            {"OWC": [FluidContact(1.5, zones="Middle/Base"), FluidContact(1.25, block="F1+")]},
            r"block 'whole' of Middle/Base and for block .*, and .* belongs to both",
        ),
        (
            {
                "OWC": [
                    FluidContact(1.5, zones=["Middle/Base"]),
                    FluidContact(1.2, zones=["Middle/Base"]),
                ]
            },
            "contact 'OWC in Middle/Base' is given twice. Leave one of them out",
        ),
        ({"OWC": [1.5]}, r"contact 'OWC' is a list that holds 1\.5\. Give an elevation"),
        (
            {"OWC": {"F1+": FluidContact(1.5, block="F1-")}},
            r"two blocks: 'F1\+' as its key and 'F1-' in the FluidContact",
        ),
        ({"OWC": FluidContact("none.gri")}, r"none\.gri"),
        (
            {"OWC": FluidContact(99.0, zones="Top/Middle")},
            "at elevation 99 m, outside the model box",
        ),
    ],
)
def test_refusals(contacts, words):
    with pytest.raises(InputError, match=words):
        scene_of(contacts).units  # noqa: B018


def test_a_block_that_has_nothing_of_a_zone_is_refused():
    """F1 ends just above Base, so that the zones above have no sides of it."""
    short = sheet("F1", [(1, -1, -5), (1, 5, -5), (1, 5, 1.5), (1, -1, 1.5)])
    with pytest.raises(
        InputError, match=r"block 'F1\+' has no unit in Top/Middle. Leave the zones"
    ):
        scene_of({"OWC": FluidContact(0.0, zones="Top/Middle", block="F1+")}, (short,))


@settings(max_examples=12)
@given(faulted_worlds(), st.integers(-3, 6), st.integers(0, 2))
def test_parts_add_up_in_named_zones_and_others_stay(surfaces, z, k):
    """Whole levels hit corners, edges and level pieces of horizons."""
    names = [s.name for s in surfaces if s.role == "horizon"]
    zones = [f"above {names[0]}", *(f"{a}/{b}" for a, b in pairwise(names)), f"below {names[-1]}"]
    named = zones[k % len(zones)]
    whole = carve_units(rebuild_surfaces(surfaces))
    if not any(unit.zone == named for unit in whole.values()):
        return
    for unit, parts in parts_of(whole, surfaces, {"OWC": FluidContact(float(z), zones=named)}):
        cut = unit.zone == named and crosses(unit, -9, z) and crosses(unit, z, 9)
        assert len(parts) == 1 + cut
        assert all(bool(u.contact) == (unit.zone == named) for u in parts)
