"""Fluid contacts split units, in the blocks that they are given for, and nothing gets lost."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf import FluidContact, Scene, TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.errors import GeometryError, InputError, OpenUnitError
from geosurf.measure import orientation
from geosurf.report.tables import left_out_table
from geosurf.scenario.execute import contacts_left_out
from geosurf.triangulate import build_contacts
from tests import laws
from tests.grids import gridded
from tests.messages import refused
from tests.strategies import BOX, faulted_worlds, grid, level, sheet, upright


def tilted(name, west, east):
    """Elevation `west` at x = 0 and `east` at x = 4, beyond the box on all sides."""
    slope = (east - west) / 4.0
    z = [west - slope, east + slope]
    return grid(name, [z, z], spacing=6.0, corner=(-1.0, -1.0))


ZONES = ["above Top", "Top/Base", "below Base"]
UPRIGHT = upright("F1", 1)
TOP, BASE = tilted("Top", 3, 5), level("Base", 1)


def scene_of(contacts, faults=(UPRIGHT,), horizons=(TOP, BASE), **options):
    given = ({s.name: s for s in some} for some in (horizons, faults))
    scene = Scene(*given, BOX, contacts=contacts, **options)
    laws.assert_volumes_add_up(scene.units, BOX)
    return scene


def volumes(scene, zone="Top/Base"):
    return {
        (unit.block, unit.contact): unit.volume
        for unit in scene.units.values()
        if unit.zone == zone
    }


def test_the_block_with_more_sides_counts():
    across = sheet("F2", [(-1, 2, -5), (5, 2, -5), (5, 2, 9), (-1, 2, 9)])
    contacts = {"OWC": {"F1+": 2.0, "F2+ F1+": 1.5, "elsewhere": 1.25}}
    found = volumes(scene_of(contacts, (UPRIGHT, across)))
    below = {block: v for (block, contact), v in found.items() if contact == "below OWC"}
    assert below == pytest.approx(
        {"F1+ F2+": 6 * 0.5, "F1+ F2-": 6 * 1.0, "F1- F2+": 2 * 0.25, "F1- F2-": 2 * 0.25}
    )


def test_a_contact_may_be_a_grid_and_may_tilt():
    """A tilted contact, as a surface and as an array; and one that lies in a horizon."""
    surface = tilted("whatever", 2, 3)
    found = volumes(scene_of({"OWC": surface}, ()))
    assert found["whole", "below OWC"] == pytest.approx(4 * 4 * 1.5, rel=1e-12)
    array = gridded(surface.vertices[:, 2].reshape(2, 2), [-1.0, 5.0])
    assert volumes(scene_of({"OWC": {"F1-": array}})) == pytest.approx(
        volumes(scene_of({"OWC": {"F1-": surface}}))
    )
    assert volumes(scene_of({"OWC": 1.0}, ())) == {("whole", "above OWC"): pytest.approx(48.0)}


def test_a_grid_of_one_block_need_not_reach_the_others():
    def part(west):
        corners = [[west, -1, 2], [5, -1, 2], [5, 5, 2], [west, 5, 2]]
        return TriSurface("level", "surface", corners, [[0, 1, 2], [0, 2, 3]])

    for west in (1, 0.5):
        found = volumes(scene_of({"OWC": {"F1+": part(west)}}))
        assert found["F1+", "below OWC"] == pytest.approx(12.0, rel=1e-12)
        assert found["F1-", ""] == pytest.approx(9.0, rel=1e-12)
    with pytest.raises(
        OpenUnitError, match=r"leak around contact 'OWC': 4 m .* fill the contact"
    ) as e:
        scene_of({"OWC": part(0.5)})
    assert e.value.place == pytest.approx((0.5, 2.0, 2.0))
    words = r"cannot determine whether .* above or below contact 'OWC'"
    refused(OpenUnitError, words, lambda: scene_of({"OWC": part(1)}))


@settings(max_examples=10)
@given(faulted_worlds(), st.integers(-3, 6), st.integers(-3, 6))
def test_parts_add_up_to_the_units_of_small_worlds(surfaces, one, two):
    """Whole levels hit corners, edges and level pieces of horizons."""
    levels = dict(zip(("GOC", "OWC"), sorted({one, two}, reverse=True), strict=False))
    whole = carve_units(rebuild_surfaces(surfaces))
    for unit, parts in parts_of(whole, surfaces, levels):
        bounds = [9, *levels.values(), -9]
        spans = [(low, high) for high, low in pairwise(bounds) if crosses(unit, low, high)]
        assert len(parts) == len(spans)
        for part, (low, high) in zip(parts, spans, strict=True):
            z = part.local[:, 2]
            assert low <= z.min()
            assert z.max() <= high


def parts_of(whole, surfaces, levels):
    """Each unit of a world and its parts, from the top down, where fluid contacts cut it."""
    extra, contacts = build_contacts(levels, BOX)
    patches = rebuild_surfaces([*surfaces, *extra])
    every = {unit.zone: 0 for unit in whole.values()}
    units = carve_units(patches, contacts=contacts, reservoir=[*every])
    assert certify(patches, units).ok
    for unit in whole.values():
        parts = [u for u in units.values() if (u.zone, u.block) == (unit.zone, unit.block)]
        assert sum(u.volume for u in parts) == pytest.approx(unit.volume, rel=1e-12)
        yield unit, parts


def crosses(unit, low, high):
    """Whether some of a unit lies between two levels."""
    z = unit.local[:, 2]
    return z.min() < high and low < z.max()


def test_blocks_that_fit_equally_well_are_refused():
    across = sheet("F2", [(-1, 2, -5), (5, 2, -5), (5, 2, 9), (-1, 2, 9)])
    with pytest.raises(InputError, match=r"for the blocks 'F1\+' and 'F2\+', and block 'F1\+ F2\+' "
                       r"belongs to both\. Add an entry for block"):  # fmt: skip
        scene_of({"OWC": {"F1+": 2.0, "F2+": 1.5}}, (UPRIGHT, across))


def test_contacts_out_of_order_are_refused_with_a_place():
    with pytest.raises(GeometryError, match=r"'GOC' lies below 'OWC' at \(E .* top down") as e:
        scene_of({"GOC": 1.5, "OWC": 2.5})
    assert 1.5 < e.value.place[2] < 2.5
    assert e.value.surfaces == ("GOC", "OWC")


def test_surfaces_may_be_called_as_walls_are():
    """A horizon 'top' and a contact 'bottom' are not the walls of these names, in any order."""
    extra, contacts = build_contacts({"bottom": 2.0}, BOX)
    top = TOP.renamed("top")
    walls = build_walls(BOX)
    one = carve_units(rebuild_surfaces([top, BASE, *extra, *walls]), contacts=contacts)
    patches = rebuild_surfaces([*walls, top, BASE, *extra])
    two = carve_units(patches, contacts=contacts)
    assert {u.name: u.volume for u in one.values()} == {u.name: u.volume for u in two.values()}
    assert orientation(patches, two, "top").total_area == pytest.approx(16.0 * np.hypot(1, 0.5))


# ------------------------------------------------------------ blocks by sides of faults


def test_a_run_says_what_a_contact_leaves_out():
    scene = scene_of({"OWC": {"F1+": 2.0}, "FWL": 1.5}, reservoir=ZONES)
    (note,) = contacts_left_out(scene)
    assert note.startswith(
        "fluid contact 'OWC' does not split above Top F1-, Top/Base F1-, below Base F1-: "
        "it is not given for their blocks. If this is not intended, add"
    )
    table = left_out_table(scene.units)
    assert table.rows == (("OWC", "above Top F1-, Top/Base F1-, below Base F1-"),)
    assert contacts_left_out(scene_of({"OWC": 2.0})) == []


@settings(max_examples=12)
@given(faulted_worlds())
def test_each_contact_reaches_a_unit_or_says_that_it_does_not(surfaces):
    """On every side of every fault: units are split by a contact, below it, above it, or listed."""
    whole = carve_units(rebuild_surfaces(surfaces))
    sides = sorted({side for unit in whole.values() for side in unit.fault_sides})
    for side in sides[:2]:
        extra, contacts = build_contacts({"OWC": {side: 0.5}}, BOX)
        patches, every = rebuild_surfaces([*surfaces, *extra]), {u.zone: 0 for u in whole.values()}
        units = carve_units(patches, contacts=contacts, reservoir=[*every])
        left = units.report["without_contact"].get("OWC", ())
        for unit in units.values():
            named = unit.name.removesuffix(unit.contact).strip()
            assert (side in unit.fault_sides) == (unit.contact != "") == (named not in left)
        assert set(left) == {name for name, unit in whole.items() if side not in unit.fault_sides}
    for unit in whole.values():
        assert unit.block == "whole" or set(sides_in(unit.block)) <= set(unit.fault_sides)
        opposite = {side[:-1] + "+-"["-+".index(side[-1])] for side in unit.fault_sides}
        assert not opposite & set(unit.fault_sides)


def sides_in(block):
    return [word for word in block.split() if not word.startswith("#")]


@given(faulted_worlds())
def test_sides_are_where_no_way_leads_around(surfaces):
    """Against a search by hand: from each unit through all but one fault, to the sides it meets."""
    patches = rebuild_surfaces(surfaces)
    units = carve_units(patches)
    beside = units.sides
    names = list(units)
    for i, source in enumerate(patches.sources):
        if source.role != "fault":
            continue
        on_fault = same_places(patches, i)
        links = {tuple(sorted(pair)) for pair in beside[~on_fault].tolist()}
        for u, name in enumerate(names):
            region, todo = {u}, [u]
            while todo:
                one = todo.pop()
                for pair in links:
                    if one in pair and -1 not in pair:
                        other = pair[0] if pair[1] == one else pair[1]
                        if other not in region:
                            region.add(other)
                            todo.append(other)
            met = {"+-"[k] for a in beside[patches.surface_of_triangle == i] for k in range(2)
                   if a[k] in region}  # fmt: skip
            if len(met) == 1:
                assert source.name + met.pop() in units[name].fault_sides


def same_places(patches, surface):
    """Triangles of a surface, and those of others that coincide with one of them."""
    t = np.sort(patches.triangles, axis=1)
    mine = {tuple(row) for row in t[patches.surface_of_triangle == surface].tolist()}
    return np.array([tuple(row) in mine for row in t.tolist()])


# ---- Fluid contacts limited to zones: they split these, leave others whole, and nothing gets
THREE = (TOP, level("Middle", 2), BASE)


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
    scene = scene_of(contacts, horizons=THREE)
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
    assert {u.contact for u in scene_of(swapped, horizons=THREE).units.values()} == {
        "", "above GOC", "below GOC", "above OWC", "below OWC"
    }  # fmt: skip


def test_a_grid_need_not_reach_zones_that_are_not_named():
    """A grid that ends inside a zone leaks where it counts, and nowhere else."""
    part = tilted("level", 2, 3)
    low = part.vertices.copy()
    low[:, 0] = np.where(low[:, 0] > 0, 2.0, low[:, 0])  # ends at x = 2, at z = 3.25: in Top/Middle
    short = type(part)("level", "surface", low, part.triangles)
    whole = scene_of({"OWC": FluidContact(short, zones="below Base")}, horizons=THREE)
    assert split(whole) == {("below Base", "F1+"), ("below Base", "F1-")}
    with pytest.raises(OpenUnitError, match="leak around contact 'OWC in Top/Middle'"):
        scene_of({"OWC": FluidContact(short, zones="Top/Middle")}, horizons=THREE)


MIDDLE = "Middle/Base"


@pytest.mark.parametrize(
    ("contacts", "words"),
    [
        ({"OWC": {"F9+": 2.0}}, r"no unit lies on 'F9\+'\. .* mean 'F1\+'\?"),
        ({"OWC": "-2"}, r"contact 'OWC' is the text '-2'\. Give a number without quotes: -2\."),
        ({"OWC": 1705.0}, r"elevation 1705 m, outside the model box \(-4 to 8 m\)\. Elev"),
        ({"OWC": -4.5}, r"depths are negative\. Write 4\.5, or enlarge the box\."),
        ({"OWC": FluidContact(1.5, zones="Midle/Base")},
         r"unknown zone 'Midle/Base'. Zones are \['above Top', .* mean 'Middle/Base'\?"),
        ({"OWC": [FluidContact(1.5, zones=MIDDLE), FluidContact(1.25, block="F1+")]},
         r"block 'whole' of Middle/Base and for block .*, and .* belongs to both"),
        ({"OWC": [FluidContact(1.5, zones=[MIDDLE]), FluidContact(1.2, zones=[MIDDLE])]},
         "contact 'OWC in Middle/Base' is given twice. Leave one of them out"),
        ({"OWC": {"F1+": FluidContact(1.5, block="F1-")}},
         r"two blocks: 'F1\+' as its key and 'F1-' in the FluidContact"),
        ({"OWC": FluidContact(99.0, zones="Top/Middle")}, "elevation 99 m, outside the model box"),
        ({"OWC": {"F1+": 2.0, "F1-": 1.5}, "Top": 2.0},
         "'Top' is the name of a horizon and of a contact; rename"),
    ],
)  # fmt: skip
def test_refusals(contacts, words):
    refused(InputError, words, lambda: scene_of(contacts, horizons=THREE).units)


def test_a_block_that_has_nothing_of_a_zone_is_refused():
    """F1 ends just above Base, so that the zones above have no sides of it."""
    short = upright("F1", 1, z=(-5, 1.5))
    given = {"OWC": FluidContact(0.0, zones="Top/Middle", block="F1+")}
    words = r"block 'F1\+' has no unit in Top/Middle. Leave the zones"
    refused(InputError, words, scene_of, given, (short,), THREE)


@settings(max_examples=8)
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
