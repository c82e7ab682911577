"""Fluid contacts split units, in the blocks that they are given for, and nothing gets lost."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf import Scene, TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.carve.fluids import parse_sides
from geosurf.errors import GeometryError, InputError, OpenUnitError
from geosurf.measure import orientation
from geosurf.report.tables import left_out_table
from geosurf.scenario.execute import contacts_left_out
from geosurf.triangulate import build_contacts
from tests import laws
from tests.strategies import BOX, faulted_worlds, grid, sheet


def level(name, z):
    return grid(name, np.full((2, 2), float(z)), spacing=6.0, corner=(-1.0, -1.0))


def tilted(name, west, east):
    """Elevation `west` at x = 0 and `east` at x = 4, beyond the box on all sides."""
    slope = (east - west) / 4.0
    z = [west - slope, east + slope]
    return grid(name, [z, z], spacing=6.0, corner=(-1.0, -1.0))


ZONES = ["above Top", "Top/Base", "below Base"]
UPRIGHT = sheet("F1", [(1, -1, -5), (1, 5, -5), (1, 5, 9), (1, -1, 9)])
TOP, BASE = tilted("Top", 3, 5), level("Base", 1)


def scene_of(contacts, faults=(UPRIGHT,), **options):
    scene = Scene(
        {"Top": TOP, "Base": BASE}, {f.name: f for f in faults}, BOX, contacts=contacts, **options
    )
    laws.assert_volumes_add_up(scene.units, BOX)
    return scene


def volumes(scene, zone="Top/Base"):
    return {
        (unit.block, unit.contact): unit.volume
        for unit in scene.units.values()
        if unit.zone == zone
    }


def test_each_block_has_its_own_level():
    scene = scene_of({"OWC": {"F1+": 2.0, "F1-": 1.5}})
    # Top is 3 + x / 2 high; the fault stands at x = 1
    assert volumes(scene) == pytest.approx(
        {
            ("F1+", "above OWC"): 4 * (3 * 1.0 + 15 / 4), ("F1+", "below OWC"): 12.0,
            ("F1-", "above OWC"): 4 * (1.5 + 0.25), ("F1-", "below OWC"): 2.0,
        },
        rel=1e-12,
    )  # fmt: skip
    unit = scene.units["Top/Base", "F1+", "above OWC"]
    assert unit.name == "Top/Base F1+ above OWC"
    assert "OWC in F1+" in unit.bounded_by
    assert "OWC in F1-" not in unit.bounded_by  # the level of the other block leaves no trace
    certificate = scene.check()
    assert certificate.ok, str(certificate)


def test_above_between_and_below_from_the_top_down():
    scene = scene_of({"GOC": 3.5, "OWC": {"F1-": 1.25, "elsewhere": 2.0}})
    plain = scene_of({})
    units = [u for u in scene.units.values() if u.zone == "Top/Base" and u.block == "F1+"]
    assert [u.contact for u in units] == ["above GOC", "GOC/OWC", "below OWC"]
    for block in ("F1+", "F1-"):
        parts = [v for (b, _), v in volumes(scene).items() if b == block]
        assert sum(parts) == pytest.approx(volumes(plain)[block, ""], rel=1e-12)
    found = volumes(scene)
    assert found["F1-", "below OWC"] == pytest.approx(4 * 0.25, rel=1e-12)
    # the top is above the gas-oil contact from x = 1 on
    assert ("F1-", "above GOC") not in found
    assert found["F1+", "above GOC"] == pytest.approx(4 * (3 * -0.5 + 15 / 4), rel=1e-12)


def test_the_table_has_contacts_only_where_they_are_given():
    assert "contact" not in scene_of({}).units.table.coords
    volume = scene_of({"OWC": 2.0}).volumes
    assert set(volume["contact"].values.tolist()) == {"above OWC", "below OWC"}
    assert volume.attrs["units"] == "m3"
    oil = volume[(volume["contact"] == "above OWC") & (volume["zone"] == "Top/Base")]
    assert oil.sum().item() == pytest.approx(4 * (4 * 1.0 + 4.0), rel=1e-12)


def test_a_block_without_a_contact_is_not_split():
    found = volumes(scene_of({"OWC": {"F1-": 2.0}}))
    assert set(found) == {("F1+", ""), ("F1-", "above OWC"), ("F1-", "below OWC")}


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
    import xarray as xr

    array = xr.DataArray(
        surface.vertices[:, 2].reshape(2, 2), dims=("northing", "easting"),
        coords={"northing": [-1.0, 5.0], "easting": [-1.0, 5.0]},
        attrs={"units": "m", "positive": "up"},
    )  # fmt: skip
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
    with pytest.raises(
        OpenUnitError, match=r"cannot determine whether .* above or below contact 'OWC'"
    ):
        scene_of({"OWC": part(1)})


@settings(max_examples=15)
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
    certificate = certify(patches, units)
    assert certificate.ok, str(certificate)
    for unit in whole.values():
        parts = [u for u in units.values() if (u.zone, u.block) == (unit.zone, unit.block)]
        assert sum(u.volume for u in parts) == pytest.approx(unit.volume, rel=1e-12)
        yield unit, parts


def crosses(unit, low, high):
    """Whether some of a unit lies between two levels."""
    z = unit.local[:, 2]
    return z.min() < high and low < z.max()


def test_names_of_blocks_are_taken_apart():
    names = ["F1", "F1 west", "Main fault"]
    assert parse_sides("F1 west+ F1-", names) == {"F1 west+", "F1-"}
    assert parse_sides("", names) == frozenset()
    for wrong in ("F1", "F2+", "F1+F1-", "whole"):
        assert parse_sides(wrong, names) is None


@pytest.mark.parametrize(
    ("contacts", "words"),
    [
        ([], None),
        ([-1.0], r"`contacts` must be a mapping such as \{'OWC': "),
        ({"OWC": {"F9+": 2.0}}, r"no unit lies on 'F9\+'\. .* mean 'F1\+'\?"),
        ({"OWC": {}}, r"contact 'OWC' has an empty mapping of blocks\. Give an elevation"),
        ({"OWC": "deep.gri"}, r"deep\.gri"),
        ({"OWC": "-2"}, r"contact 'OWC' is the text '-2'\. Give a number without quotes: -2\."),
        ({"OWC": True}, r"contact 'OWC' cannot be a bool\. Give an elevation \[m\]"),
        ({"OWC": 1705.0}, r"elevation 1705 m, outside the model box \(-4 to 8 m\)\. Elev"),
        ({"OWC": -4.5}, r"depths are negative\. Write 4\.5, or enlarge the box\."),
    ],
)  # fmt: skip
def test_refusals(contacts, words):
    if words is None:
        assert len(scene_of({}).units) == 6
        return
    with pytest.raises(InputError, match=words):
        scene_of(contacts).units  # noqa: B018


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


def test_a_contact_with_the_name_of_a_horizon_is_refused():
    """Once the horizon was taken for the contact, and units were split at it in silence."""
    with pytest.raises(InputError, match="'Top' is the name of a horizon and of a contact; rename"):
        scene_of({"Top": 2.0})
    extra, contacts = build_contacts({"Top": 2.0}, BOX)
    patches = rebuild_surfaces([TOP, BASE, *extra, *build_walls(BOX)])
    with pytest.raises(InputError, match="'Top' is the name of a horizon and of a contact; rename"):
        carve_units(patches, contacts=contacts)


def test_a_contact_without_its_surface_is_refused():
    _, contacts = build_contacts({"OWC": 2.0}, BOX)
    patches = rebuild_surfaces([TOP, BASE, *build_walls(BOX)])
    with pytest.raises(
        InputError, match=r"'OWC': the patches have no contact surface 'OWC'; .* \[\]"
    ):
        carve_units(patches, contacts=contacts)


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


def test_walls_are_not_contacts():
    """Carving without contacts does not see the surface, except as one that parts nothing."""
    extra, contacts = build_contacts({"OWC": 2.0}, BOX)
    patches = rebuild_surfaces([TOP, BASE, *extra, *build_walls(BOX)])
    assert len(carve_units(patches)) == 3
    assert len(carve_units(patches, contacts=contacts)) == 4


def test_blocks_between_faults_that_cross_below_a_horizon():
    """An X pair: the lower wedge holds no piece of Top, and all around it lies below."""
    one = sheet("F1", [(-2, -1, -4), (-2, 5, -4), (8, 5, 6), (8, -1, 6)])  # z = x - 2
    two = sheet("F2", [(6, -1, -4), (6, 5, -4), (-4, 5, 6), (-4, -1, 6)])  # z = 2 - x
    scene = Scene({"Top": level("Top", 1)}, {"F1": one, "F2": two}, (0, 4, 0, 4, -3, 7))
    laws.assert_volumes_add_up(scene.units, scene.box)
    below = {u.block: u.volume for u in scene.units.values() if u.zone == "below Top"}
    assert sorted(below.values()) == pytest.approx([4.0, 14.0, 14.0, 32.0])
    # where it may be above as well as below, nothing is guessed: Top ends at the faults
    left = TriSurface("Top", "horizon", [[-1, -1, 1], [1, -1, 1], [1, 5, 1], [-1, 5, 1]], [[0, 1, 2], [0, 2, 3]])  # fmt: skip  # noqa: E501
    words = r"cannot determine whether \(E .* lies above or below horizon 'Top': the horizon"
    with pytest.raises(OpenUnitError, match=words) as caught:
        scene.replace(horizons={"Top": left}).units  # noqa: B018
    assert caught.value.surfaces == ("Top",)


# ------------------------------------------------------------ blocks by sides of faults
def test_a_block_is_one_in_zones_that_its_fault_has_left():
    """F1 dips out of the box below Base: there the block has no name, and is F1+ all the same."""
    one = sheet(
        "F1", [(-2, -1, 8), (-2, 5, 8), (4, 5, 2), (4, -1, 2)]
    )  # x + z = 6, to x = 4, z = 2
    plain = scene_of({}, (one,))
    names = {u.name: u.fault_sides for u in plain.units.values()}
    assert names["below Base"] == ("F1-",)  # wholly below the fault
    scene = scene_of({"OWC": {"F1-": 0.5}}, (one,), reservoir=ZONES)
    assert {u.contact for u in scene.units.values() if u.zone == "below Base"} == {
        "above OWC", "below OWC"
    }  # fmt: skip
    assert set(scene.units.report["without_contact"]) == {"OWC"}
    left = scene.units.report["without_contact"]["OWC"]
    assert left == tuple(n for n, on in names.items() if on == ("F1+",))


def two_uprights():
    """F1 at x = 1 and F2 at x = 3: three blocks, of which the last does not touch F1."""
    return UPRIGHT, sheet("F2", [(3, -1, -5), (3, 5, -5), (3, 5, 9), (3, -1, 9)])


def test_what_lies_beyond_another_fault_is_on_the_same_side():
    scene = scene_of({"OWC": {"F1+": 2.0}}, two_uprights())
    found = volumes(scene)
    assert found["F2+", "below OWC"] == pytest.approx(4.0, rel=1e-12)  # no way but through F1
    assert found["F1+ F2-", "below OWC"] == pytest.approx(8.0, rel=1e-12)
    assert found["F1-", ""] == pytest.approx(9.0, rel=1e-12)
    assert scene.units.report["without_contact"] == {"OWC": ("Top/Base F1-",)}
    every = scene.replace(reservoir=ZONES).units.report["without_contact"]
    assert every == {"OWC": ("above Top F1-", "Top/Base F1-", "below Base F1-")}
    assert [u.block for u in scene.units.on("F1+") if u.zone == "Top/Base"] == [
        "F1+ F2-", "F1+ F2-", "F2+", "F2+"
    ]  # fmt: skip
    with pytest.raises(InputError, match=r"no unit is on 'F3\+'\. The sides of faults are \["):
        scene.units.on("F3+")


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


def test_sides_that_bound_a_block_count_more_than_those_far_away():
    found = volumes(scene_of({"OWC": {"F1+": 2.0, "F2+": 1.5}}, two_uprights()))
    assert found["F2+", "below OWC"] == pytest.approx(2.0, rel=1e-12)
    assert found["F1+ F2-", "below OWC"] == pytest.approx(8.0, rel=1e-12)
    both = volumes(scene_of({"OWC": {"F1+": 2.0, "F1+ F2+": 1.25}}, two_uprights()))
    assert both["F2+", "below OWC"] == pytest.approx(1.0, rel=1e-12)


def test_around_a_fault_that_dies_there_is_no_side():
    """F1 ends upwards inside the upper zone: only below it has sides, and nothing is guessed."""
    short = sheet("F1", [(1, -1, -5), (1, 5, -5), (1, 5, 2), (1, -1, 2)])
    with pytest.raises(InputError, match=r"'F1\+' has no unit in Top/Base\. Name the zones of"):
        scene_of({"OWC": {"F1+": -1.0}}, (short,))
    scene = scene_of({"OWC": {"F1+": -1.0}}, (short,), reservoir=ZONES)
    names = {u.name: u.fault_sides for u in scene.units.values()}
    assert names["Top/Base"] == names["above Top"] == ()
    assert names["below Base F1+ above OWC"] == ("F1+",)
    assert scene.units.report["without_contact"] == {
        "OWC": ("above Top", "Top/Base", "below Base F1-")
    }


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


@settings(max_examples=15)
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
