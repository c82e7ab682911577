"""Slivers: which units they are, what they become part of, and that nothing is lost."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf import Scene, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.errors import InputError
from geosurf.measure import juxtaposition_table
from geosurf.model import Units
from geosurf.report.tables import merged_table, remnant_table, volume_table
from geosurf.triangulate import build_contacts
from tests import laws
from tests.strategies import BOX, faulted_worlds, grid, level, shuffled, upright

MERGED = "merged slivers are parts of their neighbours"


def carve(surfaces, **options):
    return carve_units(rebuild_surfaces([*surfaces, *build_walls(BOX)]), **options)


def by_hand(units, small):
    """Neighbours by shared area, from triangles of shells alone; a slow way to the same homes."""
    corners = {
        name: {tuple(sorted(map(tuple, unit.local[t].tolist()))) for t in unit.triangles}
        for name, unit in units.items()
    }

    def area(one, two):
        return math.fsum(
            0.5 * float(np.linalg.norm(np.cross(np.subtract(b, a), np.subtract(c, a))))
            for a, b, c in corners[one] & corners[two]
        )

    parts = {name: {name} for name in units if name not in small}
    left = set(small)
    while left:
        moves = {}
        for name in left:
            shared = defaultdict(float)
            for home, of in parts.items():
                shared[home] = sum(area(name, one) for one in of)
            most = max(shared.values(), default=0.0)
            if most > 0.0:
                near = [home for home in units if shared[home] > most * (1 - 1e-10)]
                moves[name] = near[0]
        if not moves:
            break
        for name, home in moves.items():
            parts[home].add(name)
        left -= set(moves)
    return {frozenset(part) for part in parts.values()} | {frozenset([name]) for name in left}


# ---------------------------------------------------------------- laws
@settings(max_examples=12)
@given(faulted_worlds(), st.integers(1, 40), st.booleans())
def test_merging_keeps_volumes_and_is_certified(surfaces, volume, contact):
    contacts = []
    if contact:
        levels, contacts = build_contacts({"OWC": 1.0}, BOX)
        surfaces = [*surfaces, *levels]
    patches = rebuild_surfaces(surfaces)
    plain = carve_units(patches, None, contacts, volume)
    assert {s.name for s in plain.slivers} == {n for n, u in plain.items() if u.volume < volume}
    if len(plain.slivers) == len(plain):
        with pytest.raises(InputError, match=r"so none can take the others. The largest, '"):
            carve_units(patches, None, contacts, {"min_volume": volume, "merge": True})
        return

    units = carve_units(patches, None, contacts, {"min_volume": volume, "merge": True})
    assert units.volume == pytest.approx(plain.volume, rel=1e-15)
    laws.assert_volumes_add_up(units, BOX)
    assert certify(patches, units).ok
    assert len(units.merged) == len(plain) - len(units)
    assert units.slivers == ()
    assert {one.name for one in units.merged} == {one.name for one in plain.slivers}

    # the same parts as found by hand
    into = defaultdict(list)
    for one in units.merged:
        into[one.into].append(one.volume)
    whole = sorted(round(u.volume - math.fsum(into[n]), 6) for n, u in units.items())
    small = {one.name for one in plain.slivers}
    assert whole == sorted(round(u.volume, 6) for n, u in plain.items() if n not in small)
    parts = by_hand(plain, small)
    totals = sorted(round(math.fsum(plain[n].volume for n in part), 6) for part in parts)
    assert totals == sorted(round(u.volume, 6) for u in units.values())


@pytest.mark.parametrize("rule", [None, {"min_volume": 6.0, "merge": True}])
@settings(max_examples=6)
@given(faulted_worlds(), st.integers(0, 2**32 - 1))
def test_the_order_of_surfaces_does_not_matter(rule, surfaces, seed):
    rng = np.random.default_rng(seed)
    horizons = [s for s in surfaces if s.role == "horizon"]
    others = [s for s in surfaces if s.role != "horizon"]
    mixed = [shuffled(s, rng, reflect=False) for s in horizons]
    mixed += [others[i] for i in rng.permutation(len(others))]
    one, two = (carve_units(rebuild_surfaces(some), slivers=rule) for some in (surfaces, mixed))
    assert list(one) == list(two)
    assert [(m.name, m.into, m.volume) for m in one.merged] == [
        (m.name, m.into, m.volume) for m in two.merged
    ]
    for unit, other in zip(one.values(), two.values(), strict=True):
        assert (unit.volume, unit.fault_sides, set(unit.bounded_by)) == (
            other.volume, other.fault_sides, set(other.bounded_by),
        )  # fmt: skip
        assert unit.triangles.tobytes() == other.triangles.tobytes()


# ---------------------------------------------------------------- a world with known slivers
# Top is level at 4 and Base at 1; F1 cuts off a wedge of 0.25 m at the eastern wall, from bottom to
# top, in all three zones
TOP, BASE = level("Top", 4), level("Base", 1)
CORNER = upright("F1", 3.75)


def wedge(**options):
    return Scene({"Top": TOP, "Base": BASE}, {"F1": CORNER}, BOX, **options)


def test_a_block_of_slivers_goes_across_its_fault_and_its_names_go_with_it():
    plain = wedge(slivers=5.0).units
    small = {"above Top F1+": 4.0, "Top/Base F1+": 3.0}
    assert {s.name: s.volume for s in plain.slivers} == small
    scene = wedge(slivers={"min_volume": 6.0, "merge": True})
    units = scene.units
    assert {name: unit.volume for name, unit in units.items()} == {
        "above Top": 64.0, "Top/Base": 48.0, "below Base": 80.0,
    }  # fmt: skip
    assert units.volume == plain.volume == 192.0
    assert [(m.name, m.into, m.across, m.area) for m in units.merged][:2] == [
        ("below Base F1+", "below Base", ("F1",), 20.0),
        ("above Top F1+", "above Top", ("F1",), 16.0),
    ]
    assert all(unit.fault_sides == () and unit.block == "whole" for unit in units.values())
    assert scene.check().ok

    # volumes alone are those of the units, where a contact makes one more sliver, too
    wet = scene.replace(contacts={"OWC": 1.25})
    assert wet.volumes.identical(wet.units.included().volumes)

    # the fault is still a surface, with one unit on both of its sides
    assert set(scene.juxtaposition("F1", "all").kind.values) == {"within one unit"}
    walls = [scene.cutoffs("Top", "F1", side) for side in ("+", "-")]
    assert np.array_equal(*map(np.concatenate, walls))  # its cut-offs stay, where zones meet there
    assert set(juxtaposition_table(scene.patches, plain, "F1").kind.values) != {"within one unit"}


def test_a_sliver_of_another_zone_makes_a_horizon_an_inner_face():
    """Base touches Top along most of the box; the zone between is a wedge at one wall."""
    z = [[4.0, 4.0, 4.0, 4.0, 4.0, 3.5, 3.5]] * 7
    base = grid("Base", z, spacing=1.0, corner=(-1.0, -1.0))
    plain = Scene({"Top": TOP, "Base": base}, {}, BOX)
    (name,) = (n for n, u in plain.units.items() if u.zone == "Top/Base")
    volume = plain.units[name].volume
    assert plain.units.slivers == ()  # it is the whole of its zone
    units = plain.replace(slivers={"min_volume": 2 * volume, "merge": True}).units
    assert list(units) == ["above Top", "below Base"]
    (one,) = units.merged
    assert one.name == "Top/Base"
    assert math.fsum(u.volume for u in units.values()) == pytest.approx(192.0, rel=1e-15)
    taken = units[one.into]
    assert taken.volume == pytest.approx(plain.units[one.into].volume + volume, rel=1e-15)
    assert certify(plain.patches, units).ok


# ---------------------------------------------------------------- tables and the certificate
def test_tables_list_slivers_apart_and_totals_include_them():
    units = wedge(slivers=5.0).units
    words = "2 of them are slivers (below 5 m³), 7 m³ in all: above Top F1+ (4 m³)"
    assert units.slivers_in_words.startswith(words)
    assert "1 of them is a sliver (below 5 m³), 3 m³ in all: Top/Base F1+ (3 m³)" in str(units)
    assert str(units).splitlines()[1].split() == ["Top/Base", "A", "F1-", "45", "m³"]
    table = units.table
    assert table.sliver.dtype == bool
    assert int(table.sliver.sum()) == 2
    assert float(table.volume.sum()) == 192.0
    assert volume_table(units, "all").head == ("Zone", "A", "B", "no region", "all regions")
    assert len(remnant_table(units.slivers).rows) == 2
    merged = wedge(slivers={"min_volume": 5.0, "merge": True}).units
    assert "2 slivers merged into neighbours, 7 m³ in all" in merged.merged_in_words
    head = ("Zone", "A", "no region", "all regions")
    assert volume_table(merged, "all").head == head
    assert merged_table(merged.merged).rows[0][:3] == ("above Top F1+", "above Top", "F1")
    assert str(merged.merged[0]) == (
        "above Top F1+ (4 m³) is part of above Top, across 16 m² of F1"
    )


def test_the_default_is_a_share_of_the_zone():
    """A wedge of 1 cm at the wall is a sliver in every zone, whatever the zones hold."""
    scene = Scene({"Top": TOP, "Base": BASE}, {"F1": upright("F1", 3.9998)}, BOX)
    assert {s.name for s in scene.units.slivers} == {
        "above Top F1+", "Top/Base F1+", "below Base F1+",
    }  # fmt: skip
    assert scene.warnings == ()
    assert scene.replace(slivers=0).units.slivers == ()
    units = scene.replace(slivers="merge").units
    assert [unit.block for unit in units.values()] == ["whole"] * 3
    assert scene.replace(slivers="merge").check().ok


@pytest.mark.parametrize("damage", ["into", "name", "volume", "other"])
def test_the_certificate_finds_what_is_wrong_with_a_merge(damage):
    scene = wedge(slivers={"min_volume": 6.0, "merge": True})
    units = scene.units
    first, *more = units.merged
    parts = list(units.values())
    if damage == "into":
        first = replace(first, into="above Top")  # was: below Base
    elif damage == "name":
        first = replace(first, name="below Base F1-")
    elif damage == "volume":
        parts[0] = replace(parts[0], volume=parts[0].volume * (1 + 1e-6))
    else:
        more = more[1:]
    wrong = Units(
        parts, units.box, units.report, sides=lambda: units.sides, slivers=units.sliver_settings,
        merged=(first, *more), unmerged=units.unmerged,
    )  # fmt: skip
    failed = {check.name for check in certify(scene.patches, wrong).checks if not check.passed}
    assert MERGED in failed or damage == "other"
    passed = {check.name: check for check in certify(scene.patches, units).checks}
    assert "below Base F1+ (5 m³) into below Base" in passed[MERGED].detail


# ---------------------------------------------------------------- invalid input
