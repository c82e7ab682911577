"""Compartments, and parts at level contacts: volumes add up, by slow ways; or an error."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError, GeosurfError, InputError
from tests.scene.conftest import ran
from tests.strategies import sheet

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.GeosurfWarning")

BOX = (0.0, 16.0, 0.0, 16.0, -12.0, 0.0)
FLAT = [[-1, -1], [17, -1], [17, 17], [-1, 17]]


def level(z: float) -> tuple[list, list]:
    return [[x, y, z] for x, y in FLAT], [[0, 1, 2], [0, 2, 3]]


HORIZONS = {"Top": level(-4.0), "Base": level(-8.0)}


def fault(start, end, dip=0.0, top=1.0, base=-13.0) -> tuple[list, list]:
    """A plane of two triangles between two places on the map, moved by `dip` at its base."""
    (a, b), (c, d) = start, end
    along = np.array([c - a, d - b], dtype=float)
    across = dip * np.array([along[1], -along[0]]) / np.linalg.norm(along)
    low = [(a + across[0], b + across[1], base), (c + across[0], d + across[1], base)]
    return [(a, b, top), (c, d, top), low[1], low[0]], [[0, 1, 2], [0, 2, 3]]


def scene(faults, compartments=None) -> gs.Scene:
    return gs.Scene(HORIZONS, faults, BOX, compartments=compartments)


def assert_divided(plain: gs.Scene, walled: gs.Scene) -> None:
    """Compartments add up to the blocks without them, zone by zone, and the certificate holds."""
    assert walled.check().ok, walled.check()
    total: Counter = Counter()
    for unit in walled.units.values():
        total[unit.zone, unit.compartment_of] += unit.volume
    blocks = {(unit.zone, unit.block): unit.volume for unit in plain.units.values()}
    assert total.keys() == blocks.keys()
    for key, volume in blocks.items():
        assert total[key] == pytest.approx(volume, rel=1e-12)


def test_a_fault_that_dies_divides_the_field_along_the_shortest_join() -> None:
    """A wall of a vertical plane: distances and volumes follow by hand."""
    faults = {"F1": fault((6, 5), (6, 10))}
    walled = scene(faults, True)
    assert_divided(scene(faults), walled)
    joins = {wall.side: wall for wall in walled.virtual_walls}
    assert {side: (one.target, one.length) for side, one in joins.items()} == {
        "start": ("boundary", 5.0),
        "end": ("boundary", 6.0),
    }
    assert joins["end"].area == pytest.approx(6.0 * 12.0)

    # straight to the south, and to the west or north, which are equally near: 6 m
    zone = {unit.block: unit.volume for unit in walled.units.values() if unit.zone == "Top/Base"}
    assert sorted(zone) == ["F1+", "F1-"]
    assert min(zone.values()) in (pytest.approx(4.0 * 6 * 10), pytest.approx(4.0 * 6 * 16))
    assert set(walled.units.table["compartment_of"].values) == {"whole"}
    assert "compartment_of" not in scene(faults).units.table.coords


def test_the_shortest_joins_are_ones_that_separate() -> None:
    """F1 and F2 close a ring that one more join leads away from: it needs a second one."""
    faults = {"F1": fault((9, 4), (9, 12)), "F2": fault((6, 8), (6, 11))}
    faults["F3"] = fault((13, -1), (13, 17))
    walled = scene(faults, True)
    assert_divided(scene(faults), walled)
    joins = {(wall.fault, wall.side): wall.length for wall in walled.virtual_walls}
    assert (joins["F1", "start"], joins["F1", "end"]) == (4.0, 4.0)  # sqrt(10) m were nearest


def test_a_fault_that_overhangs_its_lower_rim_is_continued_down() -> None:
    """The vertical line below V would run through the triangle Q, D, P."""
    at = {
        "U0": (12, 3, -2), "U1": (12, 9, -2), "U2": (12, 14, -2), "Q": (8, 5, -6), "P": (8, 11, -6),
        "C": (4, 3, -10), "D": (4, 6, -10), "V": (5, 7, -8.5), "E": (4, 11, -10), "F": (4, 14, -10),
    }  # fmt: skip
    rows = ("U0CQ", "U0QU1", "QPU1", "CDQ", "QDP", "PDV", "PVE", "PEF", "PFU2", "U1PU2")
    names = list(at)
    triangles = [[names.index(one) for one in re.findall(r"[A-Z]\d?", row)] for row in rows]
    faults = {"F1": (list(at.values()), triangles)}
    walled = scene(faults, True)
    assert_divided(scene(faults), walled)
    assert len(walled.regions) == 2


@pytest.mark.parametrize("seed", range(4))
def test_faults_that_share_a_stick_bound_blocks_however_far_they_are_lengthened(seed) -> None:
    """Beyond the shared stick both go on along one line, but for rounding: nothing leaks there."""
    rng = np.random.default_rng(seed)

    def stick(x, y, dx, dy):
        """A line down, with noise, so that no end of its continuation is a whole number."""
        easting, northing, high, low = np.array([x, y, -3.0, -9.0]) + rng.uniform(-0.3, 0.3, 4)
        return [[easting, northing, high], [easting + dx, northing + dy, low]]

    main = [stick(5, northing, 2, 0) for northing in (2, 8, 14)]
    branch = [main[1], stick(9, 8, 0.5, 1), stick(12, 8, 0.5, 1)]
    faults = {
        name: gs.triangulate_fault(gs.FaultSticks(name, sticks))
        for name, sticks in (("F1", main), ("F2", branch))
    }
    plain, both = {"up": 0.7, "down": 1.9}, {"up": 0.4, "down": 0.9}
    for lengthen in (None, {"F1": plain}, {"F2": plain}, {"F1": plain, "F2": both}):
        walled = gs.Scene(HORIZONS, faults, BOX, lengthen=lengthen, compartments=True)
        assert walled.check().ok
        assert (len(walled.regions), len(walled.units)) == (3, 9)


def test_a_contact_may_be_of_one_compartment() -> None:
    faults = {"F1": fault((6, 5), (6, 10))}
    walled = scene(faults, True).replace(contacts={"OWC": {"F1+": -6.0}})
    inside = {side: [u for u in walled.units.on(side) if u.zone in walled.reservoir]
              for side in ("F1+", "F1-")}  # fmt: skip
    assert {unit.contact for unit in inside["F1+"]} == {"above OWC", "below OWC"}
    assert {unit.contact for unit in inside["F1-"]} == {""}


@pytest.mark.parametrize(
    ("compartments", "error", "words"),
    [
        ({"F9": True}, InputError, "'F9', which is not a fault"),
        ({"F1": "F9"}, InputError, "joins 'F1' to 'F9'"),
        ({"F1": "F2"}, InputError, "dies inside the model at both ends"),
        ({"F1": {"end": "boundary"}}, GeometryError, "its start stays open"),
        ({"F1": {"start": "boundary", "end": "F2"}}, GeometryError, "'F2'.*dies inside the model"),
        ({"F1": {"start": "boundary", "end": "F3"}}, GeometryError, "lies 'F2'"),
    ],
)
def test_what_cannot_be_divided_is_an_error(compartments, error, words) -> None:
    faults = {
        "F1": fault((3, 4), (3, 12)),
        "F2": fault((8, 2), (8, 14)),
        "F3": fault((13, -1), (13, 17)),
    }
    with pytest.raises(error, match=words):
        _ = scene(faults, compartments).units
    with pytest.raises(InputError, match="the scene has no faults"):
        scene({}, ["F9"])


def random_faults(seed: int) -> dict:
    """Two or three faults on whole numbers: parallel, crossing, meeting, dying above or below."""
    rng = np.random.default_rng(seed)
    found = {}
    for k in range(int(rng.integers(2, 4))):
        while True:
            a, c = rng.integers(2, 15, (2, 2))
            if np.abs(a - c).sum() > 3:
                break
        top, base = (1.0, -13.0) if rng.random() < 0.6 else (-5.0, -9.0)
        dip = float(rng.integers(-2, 3))
        found[f"F{k + 1}"] = fault(a.tolist(), c.tolist(), dip, top, base)
    return found


@pytest.mark.parametrize("seed", range(12))
def test_lattice_worlds_are_divided_exactly_or_refused(seed: int) -> None:
    faults = random_faults(seed)
    walled = scene(faults, True)
    if seed == 5:
        with pytest.raises(GeometryError, match=r"fault 'F[123]'.*near \(E") as caught:
            _ = walled.units
        assert caught.value.place is not None
        assert "virtual" in {shown.role for shown in caught.value.close_up.surfaces}
        return
    assert_divided(scene(faults), walled)


# ---- Volumes of parts at level contacts: those of the arrangement with the contacts among sur

FIELD = (0.0, 6.0, 0.0, 6.0, -4.0, 8.0)


def horizon(rng, base, rising):
    """A lattice with whole heights, so that contacts often touch corners, edges and planes."""
    x = np.arange(-1.0, 8.0)
    z = base + rng.integers(0, 3, size=(len(x), len(x))).astype(float)
    return gs.TriSurface("H", "horizon", lattice=gs.Lattice(x, x, z, rising=rising))


def world(seed):
    """Two rough horizons that may touch, one or two faults, and one to three contacts."""
    rng = np.random.default_rng([44, seed])
    horizons = {
        "Top": horizon(rng, 3.0, bool(seed % 2)),
        "Base": horizon(rng, rng.integers(0, 3), bool(seed % 3)),
    }
    x = 0.5 * rng.integers(3, 9)
    dips = [(x, -1, -5), (x, 7, -5), (x + 1.5, 7, 9), (x + 1.5, -1, 9)]
    across = [(-1, 3, -5), (7, 3, -5), (7, 3, 9), (-1, 3, 9)]
    faults = {"F1": sheet("F1", dips), "F2": sheet("F2", across)}
    if seed % 3 == 0:
        del faults["F2"]

    upper, lower = sorted((rng.integers(0, 24, size=2) / 4.0).tolist(), reverse=True)
    contacts = [
        {"OWC": lower},
        {"GOC": upper, "OWC": lower},
        {"OWC": {"F1+": upper, "elsewhere": lower}},
        {
            "OWC": [
                gs.FluidContact(upper, zones="Top/Base"),
                gs.FluidContact(lower, zones="below Base"),
            ]
        },
    ][seed % 4]
    every = ["above Top", "Top/Base", "below Base"]  # contacts meet walls of the box as well
    return {"horizons": horizons, "faults": faults, "box": FIELD, "contacts": contacts,
            "reservoir": every}  # fmt: skip


def found(make):
    """A result, or the words of the refusal."""
    try:
        return make()
    except GeosurfError as error:
        return type(error), str(error)


@pytest.mark.parametrize("first", [0, 6])
def test_they_are_those_of_the_arrangement(first):
    n_fast = 0
    for seed in range(first, first + 6):
        given = world(seed)
        scene = gs.Scene(**given)
        one, two = found(lambda s=scene: s.volumes), found(lambda s=scene: s.units.volumes)
        if isinstance(one, tuple) or isinstance(two, tuple):
            assert one == two, seed
            continue
        assert one.coords.equals(two.coords), seed
        assert one.attrs == two.attrs
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-12 * 432)
        assert one.sum().item() == pytest.approx(432.0, rel=1e-14)
        n_fast += scene._graph.units_at_levels is not None

        # to the byte from whatever scene of the family
        before = gs.Scene(**given | {"contacts": {"OWC": 2.125}})
        _ = before.volumes
        again = before.replace(contacts=given["contacts"])
        assert again.volumes.identical(one), seed
        assert again.volumes.values.tobytes() == one.values.tobytes()
    assert n_fast >= 1


def test_a_moved_contact_repeats_nothing_else():
    scene = gs.Scene(**world(1) | {"contacts": {"OWC": 2.125}})
    _ = scene.volumes
    moved = scene.replace(contacts={"OWC": 2.375})
    assert moved.volumes.sum().item() == pytest.approx(432.0)
    assert ran(moved) == ["OWC"]


def test_a_contact_on_a_flat_top_is_left_to_the_arrangement():
    """Whether there is anything above it is decided by exact signs."""
    x = np.arange(-1.0, 8.0)
    flat = gs.TriSurface("T", "horizon", lattice=gs.Lattice(x, x, np.full((9, 9), 2.0)))
    for level, n_unit in ((2.0, 2), (1.0, 3)):
        contact = {"OWC": gs.FluidContact(level, zones="below Top")}
        scene = gs.Scene({"Top": flat}, {}, FIELD, contacts=contact)
        assert len(scene.volumes) == n_unit
        assert (scene._graph.units_at_levels is None) == (level == 2.0)
        np.testing.assert_allclose(scene.volumes, scene.units.volumes, rtol=1e-15)
