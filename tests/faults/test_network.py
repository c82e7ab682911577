"""Faults in a scene: blocks with volumes from paper, proposals that hold, memory by fault."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import (
    FaultNetwork,
    Scene,
    TriSurface,
    build_walls,
    propose_network,
    rebuild_surfaces,
    truncate_faults,
)
from geosurf.errors import GeometryError, GeosurfWarning, InputError
from geosurf.model import Extension, NetworkRow, Truncation
from tests import laws
from tests.faults.worlds import (
    BOX,
    across,
    antithetic,
    dipping,
    triangles_of,
    turned,
    upright,
    volumes,
)
from tests.grids import gridded
from tests.strategies import grid, sheet


def scene(*faults, **options):
    return Scene({}, {f.name: f for f in faults}, BOX, **options)


def ran(of, stage):
    return [s.subject for s in of.steps if s.outcome == "ran" and s.stage == stage]


# Inside the box, none reaches a wall or another fault: extended, they are `dipping`, `antithetic`,
# `upright(6)` and `across(4)`.
SMALL = {
    "F1": sheet("F1", [(3, 3, 5), (5, 3, 3), (5, 5, 3), (3, 5, 5)]),
    "F2": sheet("F2", [(6, 3, 6), (7, 3, 7), (7, 5, 7), (6, 5, 6)]),
    "F3": sheet("F3", [(7, 4, 5), (7.5, 4, 5), (7.5, 4, 6), (7, 4, 6)]),
}
EVERY = ("strike", "up", "down")


@pytest.mark.parametrize(
    ("faults", "truncations", "expected"),
    [
        ((dipping(), antithetic()), None, [128] * 4),  # X
        ((dipping(), antithetic()), {"F2": ("F1", "hanging wall")}, [128, 128, 256]),  # Y
        ((dipping(), antithetic()), {"F1": ("F2", "footwall")}, [128, 128, 256]),
        ((dipping(), upright(6)), {"F2": ("F1", "footwall")}, [16, 240, 256]),  # lambda
        ((dipping(), upright(6)), {"F2": ("F1", "hanging wall")}, [112, 144, 256]),
        ((dipping(n=(3, 3)), upright(6, n=(2, 5))), {"F2": ("F1", "-")}, [16, 240, 256]),
        (
            (dipping(), antithetic(), across(4)),
            {"F2": ("F1", "+"), "F3": (("F1", "+"), ("F2", "hanging wall"))},
            [64, 64, 128, 256],
        ),
    ],
)
def test_truncated_faults_divide_the_box_as_worked_out_on_paper(faults, truncations, expected):
    made = scene(*faults, truncations=truncations)
    np.testing.assert_allclose(volumes(made.units), expected, rtol=1e-12)
    laws.assert_volumes_add_up(made.units, BOX)
    assert made.check().ok


@pytest.mark.parametrize("turn", [False, True])
def test_extended_and_truncated_faults_divide_the_box_from_inside(turn):
    small = [turned(f) if turn else f for f in SMALL.values()]
    assert len(scene(*small).units) == 1  # as given they divide nothing
    made = scene(
        *small,
        extend=True,
        truncations={
            "F2": ("F1", "hanging wall"),
            "F3": (("F1", "hanging wall"), ("F2", "footwall")),
        },
    )
    np.testing.assert_allclose(volumes(made.units), [64, 64, 128, 256], rtol=1e-12)


@pytest.mark.parametrize(
    ("faults", "rules"),
    [
        ((dipping(), antithetic()), {"F2": ("F1", "hanging wall")}),
        ((dipping(n=(3, 3)), upright(6, n=(2, 5))), {"F2": ("F1", "-")}),
        (
            (dipping(), antithetic(), across(4)),
            {"F2": ("F1", "+"), "F3": (("F1", "+"), ("F2", "hanging wall"))},
        ),
    ],
)
@pytest.mark.parametrize("aoi", [None, [(0.3, 0.1), (7.6, 0.4), (7.9, 7.5), (0.7, 7.8)]])
def test_truncated_faults_have_no_cuts_along_the_box(faults, rules, aoi):
    """So nothing of the box is in them, and the model is that of faults cut by its walls."""
    made = scene(*faults, truncations=rules, aoi=aoi)
    walls = build_walls(BOX, aoi)
    with_walls, without = rebuild_surfaces([*faults, *walls]), rebuild_surfaces(faults)
    cut = truncate_faults(with_walls, rules)
    assert cut.cut_by_walls
    mine = truncate_faults(with_walls, rules, whole=without)
    assert not mine.cut_by_walls
    places = set(map(tuple, without.vertices.tolist()))
    for name, surface in mine.surfaces.items():
        assert triangles_of(surface) == triangles_of(made.surface(name))
        assert set(map(tuple, surface.vertices.tolist())) <= places
        assert surface.n_triangle < cut.surfaces[name].n_triangle
        given = next(f for f in faults if f.name == name)
        assert mine.parents[name].max() < given.n_triangle
    assert made.patches.report["moved_vertices"] == 0
    if aoi is None:  # cut by oblique walls, and once more by the same, they cannot be held
        again = Scene({}, cut.surfaces, BOX)
        np.testing.assert_allclose(volumes(made.units), volumes(again.units), rtol=1e-12)
    for one, two in zip(cut.truncations, mine.truncations, strict=True):
        assert one.kept_area + one.dropped_area == pytest.approx(two.kept_area + two.dropped_area)


@pytest.mark.filterwarnings("ignore:Fault 'F2' lies 1 m east of the area of interest")
@pytest.mark.parametrize(("west", "east", "expected"), [(5, 8, [36, 36, 120]), (0, 3, [36, 156])])
def test_faults_that_meet_outside_of_the_area_are_those_of_the_whole_model(west, east, expected):
    """They meet at x = 4; F2 is x = z beyond it, and no fault on the other side."""
    ring = [(west, 0), (east, 0), (east, 8), (west, 8)]
    rule = {"F2": ("F1", "hanging wall")}
    made = scene(dipping(), antithetic(), truncations=rule, aoi=ring)
    np.testing.assert_allclose(volumes(made.units), expected, rtol=1e-12)
    with pytest.raises(GeometryError, match=r"'F2' ends .* short of 'F1'"):  # without the whole
        truncate_faults(rebuild_surfaces([dipping(), antithetic(), *build_walls(BOX, ring)]), rule)


@pytest.mark.filterwarnings("ignore:The area of interest runs along the rim of horizon 'Top'")
def test_an_area_along_the_rim_of_a_rotated_grid_may_have_truncated_faults():
    """Its sides are moved inward, by some micrometres, before faults end at each other in it."""
    row, column = np.mgrid[:9, :9]
    places = (column + 1j * row) * np.exp(1j * np.pi / 6.0)
    levels = {"Top": np.full((9, 9), 6.0), "Base": np.full((9, 9), 2.0)}
    horizons = {name: gridded(z, places.real, places.imag) for name, z in levels.items()}
    corners = places[[0, 0, 8, 8], [0, 8, 8, 0]]
    aoi, faults = np.stack([corners.real, corners.imag], axis=1).round(5), [dipping(), antithetic()]
    free = Scene(horizons, {f.name: f for f in faults}, aoi=aoi)
    made = free.replace(truncations={"F2": ("F1", "hanging wall")})
    assert made.box == free.box
    np.testing.assert_allclose(volumes(made.units), volumes(free.units), rtol=1e-9)


def test_where_a_fault_has_to_end_at_the_box_all_have_its_cuts():
    """F1 stands in one arm of the area; what F2 is in the other meets nothing there, and stays."""
    ring = [(0, 0), (8, 0), (8, 8), (5, 8), (5, 3), (3, 3), (3, 8), (0, 8)]
    made = scene(upright(2, "F1"), across(5, "F2"), truncations={"F2": ("F1", "left")}, aoi=ring)
    (cut,) = made.fault_actions
    assert cut.apart_area == pytest.approx(3 * 8)
    assert "; cut at the model box, where one of them has to end" in made.explain()
    np.testing.assert_allclose(volumes(made.units), [48, 72, 80, 232], rtol=1e-12)


def test_a_change_of_one_fault_leaves_the_others_alone():
    other = sheet("F4", [(1, 6, 1), (2, 6, 1), (2, 6, 2), (1, 6, 2)])
    rules = {"F2": ("F1", "hanging wall")}
    faults = {**SMALL, "F4": other}
    made = Scene({}, faults, BOX, extend={"F1": EVERY, "F2": EVERY}, truncations=rules)
    assert made.surface("F4") is not None
    assert ran(made, "truncate") == ran(made, "extend") == []
    first = made.surface("F1"), made.surface("F2")
    assert ran(made, "extend") == ["F1", "F2"]
    assert ran(made, "truncate") == ["F1, F2"]
    later = made.replace(faults={"F3": upright(7, "F3"), "F4": None})
    assert (later.surface("F1"), later.surface("F2")) == first
    assert later.surface("F3").n_triangle == 2
    assert ran(later, "truncate") == ran(later, "extend") == []
    moved = made.replace(faults={"F2": sheet("F2", [(6, 3, 5), (7, 3, 6), (7, 5, 6), (6, 5, 5)])})
    moved.surface("F1")
    assert ran(moved, "extend") == ["F2"]
    assert ran(moved, "truncate") == ["F1, F2"]
    assert "F2 at F1: " in moved.explain()
    deeper = made.replace(box=(0, 8, 0, 8, -4, 8))
    deeper.surface("F2")
    assert ran(deeper, "extend") == ["F1", "F2"]


# ---- proposals -------------------------------------------------------------------------


def test_every_contact_near_miss_and_end_is_listed():
    stub = sheet("F2", [(3, -1, 3), (9, -1, 9), (9, 9, 9), (3, 9, 3)])  # a sixth beyond F1
    short = sheet("F3", [(5.5, 4, 3), (7, 4, 3), (7, 4, 4), (5.5, 4, 4)])
    network = scene(dipping(), stub, short).propose_fault_network(reach=1.0)
    contact, *others = network.rows
    assert (contact.kind, contact.fault, contact.other) == ("contact", "F2", "F1")
    assert (contact.proposal, contact.keep) == ("truncate", "hanging wall")
    assert contact.length == pytest.approx(10.0)
    assert contact.place[0] + contact.place[2] == pytest.approx(8.0)
    assert "16.7 % of F2" in contact.reason
    assert "90 degrees apart" in contact.reason
    miss = next(row for row in others if row.kind == "near miss" and row.other == "F1")
    assert (miss.fault, miss.side, miss.keep) == ("F3", "end", "hanging wall")
    assert miss.distance == pytest.approx(0.5 / np.sqrt(2), abs=1e-9)
    assert miss.proposal == "extend then truncate"
    ends = [row for row in others if row.kind == "dangling end"]
    assert {row.fault for row in ends} == {"F3"}
    assert str(network).splitlines()[0].split()[:2] == ["row", "kind"]
    assert len(str(network).splitlines()) == len(network.rows) + 1


def test_proposals_can_be_applied_and_leave_nothing_to_truncate():
    stub = sheet("F2", [(3, -1, 3), (9, -1, 9), (9, 9, 9), (3, 9, 3)])
    before = scene(dipping(), stub)
    after = before.propose_fault_network().apply(before)
    np.testing.assert_allclose(volumes(after.units), [128, 128, 256], rtol=1e-12)
    (row,) = after.propose_fault_network().rows
    assert (row.proposal, row.reason) == ("leave", "F2 ends at F1 already; 90 degrees apart")
    assert len(before.propose_fault_network().without(0).rows) == 0
    with pytest.raises(InputError, match=r"no row 7; rows are 0 to 0"):
        before.propose_fault_network().without(7)


def ends_of(network):
    return {(r.fault, r.side): r.distance for r in network.rows if r.kind == "dangling end"}


def test_rules_that_stand_are_kept_when_proposals_are_applied():
    row = NetworkRow("contact", "F2", "F1", "", 1.0, 0.0, (0, 0, 0), "truncate", "footwall", "")
    end = NetworkRow("dangling end", "F1", "", "up", 0.0, 1.0, (0, 0, 0), "extend", "", "")
    given = scene(*SMALL.values(), extend={"F1": "down"}, truncations={"F2": ("F1", "+", True)})
    trial = FaultNetwork((row, end)).trial(given)
    assert trial.scene.truncations == {"F2": (("F1", "+", True),)}
    assert trial.scene.extend["F1"] == ("up", "down")
    (dropped,) = trial.dropped
    assert dropped.row == row
    assert dropped.reason == "the scene has a truncation of 'F2' at 'F1' already"


def test_proposals_never_go_round_in_a_circle():
    """Three faults of a whirl, each with a stub beyond the next."""
    faults = [
        sheet(f"F{k}", [(*a, -1), (*b, -1), (*b, 9), (*a, 9)])
        for k, (a, b) in enumerate(
            [((1.8, 2), (8.4, 2)), ((6.1, 1.8), (2.8, 8.4)), ((4.1, 6.2), (0.8, -0.4))], start=1
        )
    ]
    network = scene(*faults).propose_fault_network()
    (left,) = [
        row for row in network.rows if row.proposal == "leave" and "by rows above" in row.reason
    ]
    assert [fault for fault, _ in ends_of(network)] == [left.fault]  # its stub is not dropped
    assert len(network.truncations) == 2
    trial = network.trial(scene(*faults))
    assert [d.row.fault for d in trial.accepted] == [row.fault for row in network.rows[:2]]
    (dropped,) = trial.dropped  # once the others are cut, the third is to end at one of them
    assert "form a circle" in dropped.reason


def piece(rng, name, size, n=4):
    """A wavy piece of a fault: strike near one of two directions, dip 35 to 145 degrees."""
    strike = np.radians(rng.choice([20.0, 75.0]) + rng.normal(0, 12))
    dip = np.radians(rng.uniform(35, 145))
    along = np.array([np.sin(strike), np.cos(strike), 0.0])
    down = np.array([np.cos(strike) * np.cos(dip), -np.sin(strike) * np.cos(dip), -np.sin(dip)])
    middle = np.array([rng.uniform(0, 10_000), rng.uniform(0, 10_000), rng.uniform(-2500, -500)])
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    half = size * rng.uniform(0.5, 1.5)
    x = middle + half * u[..., None] * along + rng.uniform(500, 2200) * v[..., None] * down
    x = x + rng.normal(0, 0.01 * half) * np.sin(2.0 * u[..., None]) * np.cross(along, down)
    return TriSurface(name, "fault", x.reshape(-1, 3), grid(name, u).triangles)


def network_of(n_piece, seed):
    """A scene with some pieces, so many that each meets or nearly meets a few others."""
    rng = np.random.default_rng(seed)
    # half the length of pieces: 1.4 mean distances
    size = 1.4 * 10_000 / np.sqrt(n_piece)
    faults = {f"F{k:02d}": piece(rng, f"F{k:02d}", size) for k in range(n_piece)}
    return Scene({}, faults, (0.0, 10_000.0, 0.0, 10_000.0, -3000.0, 0.0))


def assert_all_decided(scene, trial):
    """No proposal is left; the scene has all that was accepted; its faults can be built."""
    decided = [one.row.subject for one in trial.decisions]
    assert len(decided) == len(set(decided))
    assert all(one.reason for one in trial.decisions)
    left = trial.scene.propose_fault_network().rows
    assert {row.subject for row in left if row.changes} <= set(decided)
    for one in trial.decisions:
        row, rules = one.row, trial.scene.truncations.get(one.row.fault, ())
        if row.proposal == "extend":
            assert (row.side in trial.scene.extend.get(row.fault, ())) == one.accepted
        else:
            rule = (row.other, row.keep, row.proposal != "truncate")
            assert (rule in rules) == one.accepted
    for name in scene.fault_names:
        assert trial.scene.surface(name).n_triangle > 0


def test_every_proposal_for_a_random_network_is_accepted_or_dropped_with_a_reason():
    given = network_of(9, seed=2)
    trial = given.propose_fault_network().trial(given)
    assert trial.accepted
    assert_all_decided(given, trial)
    table = str(trial).splitlines()
    assert len(table) == len(trial.decisions) + 2
    assert table[-1] == (f"{len(trial.accepted)} proposals accepted, {len(trial.dropped)} dropped")


def test_a_proposal_that_cannot_be_applied_is_dropped_and_the_others_stand():
    """F3 is to be extended to F1, past its end: it goes on around it."""
    short = sheet("F1", [(3, -1, 9), (3, 4.5, 9), (3, 4.5, -1), (3, -1, -1)])
    other = sheet("F3", [(4, 4, -1), (9, 4, -1), (9, 4, 9), (4, 4, 9)])
    stub = sheet("F2", [(6, -1, -1), (6, 9, -1), (6, 9, 9), (6, -1, 9)])
    around = NetworkRow(
        "near miss", "F1", "F3", "end", 0.0, 0.5, (3, 4.5, 4), "extend then truncate", "left", "!"
    )
    cut = NetworkRow("contact", "F3", "F2", "", 8.0, 0, (6, 4, 4), "truncate", "right", "a stub")
    given = scene(short, other, stub)
    network = FaultNetwork((around, cut))
    with pytest.warns(GeosurfWarning, match=r"1 of \d proposals .* dropped: F1 \(end\) at F3\."):
        after = network.apply(given)
    assert after.truncations["F3"][0] == ("F2", "right", False)
    assert "F1" not in after.truncations


def test_proposals_that_a_person_takes_out_do_not_come_back():
    stub = sheet("F2", [(3, -1, 3), (9, -1, 9), (9, 9, 9), (3, 9, 3)])
    given = scene(dipping(), stub)
    network = given.propose_fault_network()
    assert network.without(0).declined == network.rows
    trial = network.without(0).trial(given)
    assert trial.decisions == ()
    assert str(trial) == "no proposal that changes a fault"
    with pytest.raises(InputError, match=r"names fault 'F1', which the scene does not have"):
        network.apply(scene(stub))


def test_what_cannot_be_extended_is_not_proposed_for_it():
    """Faults in pieces, and those whose ends are unknown: a closed one has none."""
    one, two = (sheet("F3", [(5.5, y, 3), (7, y, 3), (7, y, 4), (5.5, y, 4)]) for y in (3.0, 5.0))
    both = TriSurface(
        "F3", "fault", np.concatenate([one.vertices, two.vertices]),
        np.concatenate([one.triangles, two.triangles + one.n_vertex]),
    )  # fmt: skip
    rows = scene(dipping(), both).propose_fault_network(reach=1.0).rows
    (miss,) = (row for row in rows if row.kind == "near miss")
    assert miss.proposal == "leave"
    assert "F3 is in 2 pieces, of which none can be extended" in miss.reason
    corners = [(2, 2, 2), (4, 2, 2), (2, 4, 2), (2, 2, 4)]
    closed = TriSurface("F4", "fault", corners, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    rows = propose_network(rebuild_surfaces([closed]), BOX).rows
    assert [(row.fault, row.proposal) for row in rows] == [("F4", "leave")]
    assert "its ends are unknown: fault 'F4' is closed" in rows[0].reason


# ---- fields that nobody here made ------------------------------------------------------


@pytest.fixture(scope="module")
def drogon(drogon_sticks):
    return Scene({}, drogon_sticks, (459e3, 466.5e3, 5929.5e3, 5938.5e3, -2000.0, -1450.0))


def test_drogon_proposals_are_those_of_the_field(drogon):
    network = drogon.propose_fault_network()
    met = {(row.fault, row.other): row for row in network.rows if row.other}
    assert set(met) == {("F6", "F2"), ("F2", "F1")}
    assert met["F6", "F2"].proposal == "leave"  # its end sticks are sticks of F2
    assert "ends at F2 already" in met["F6", "F2"].reason
    gap = met["F2", "F1"]
    assert (gap.kind, gap.side, gap.proposal) == ("near miss", "start", "extend then truncate")
    assert 0 < gap.distance < 1


@pytest.mark.filterwarnings("ignore:Fault 'F5' ends 11.1 m before the west side")
def test_drogon_network_seals_once_it_is_extended_and_truncated(drogon):
    """F6 is a lens in the hanging wall of F2, and F2 a branch in the footwall of F1."""
    box = (460e3, 466e3, 5930.5e3, 5937.5e3, -1800.0, -1560.0)
    extended = drogon.replace(box=box, extend=dict.fromkeys(("F1", "F2", "F6"), EVERY))
    made = extended.replace(truncations={"F2": ("F1", "footwall"), "F6": ("F2", "hanging wall")})
    assert len(made.units) == 3
    laws.assert_volumes_add_up(made.units, box)
    assert made.check().ok
    assert {type(a) for a in made.fault_actions} == {Extension, Truncation}
    rows = made.propose_fault_network().rows
    assert {(r.fault, r.other, r.proposal) for r in rows if r.kind == "contact"} == {
        ("F2", "F1", "leave"),
        ("F6", "F2", "leave"),
    }


def test_scec_near_misses_are_as_far_as_an_independent_search_says(shared):
    import geosurf as gs

    folder = shared / "data" / "scec_cfm7"
    wanted = ("Javon_Canyon", "Red_Mountain_fault_S", "Oak_Ridge")
    faults = {}
    for path in sorted(folder.glob("*.ts")):
        for word in wanted:
            if word in path.stem:
                faults[word] = gs.read_fault(path)
    network = Scene({}, faults, (2e5, 4e5, 37e5, 39e5, -2e4, 500.0)).propose_fault_network()
    misses = [row for row in network.rows if row.kind == "near miss"]
    assert ("Javon_Canyon", "Red_Mountain_fault_S") in {(r.fault, r.other) for r in misses}
    from scipy.spatial import cKDTree

    for row in misses:
        main = faults[row.other]
        corners = main.vertices[main.triangles]
        u, v = (k.ravel() / 20 for k in np.meshgrid(np.arange(21), np.arange(21)))
        u, v = u[u + v <= 1], v[u + v <= 1]
        a, b, c = corners[:, 0, None], corners[:, 1, None], corners[:, 2, None]
        samples = a + u[None, :, None] * (b - a) + v[None, :, None] * (c - a)
        step = np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).max() / 20
        near, _ = cKDTree(samples.reshape(-1, 3)).query(row.place)
        assert row.distance - 1e-6 <= near <= row.distance + step


def test_drogon_network_of_a_default_box_can_be_applied(drogon):
    """F2 is 0.2 m short of F1 outside this box, and 559 m inside."""
    near = drogon.replace(box=(460377.0, 464304.0, 5928633.0, 5935403.0, -2117.0, -1446.0))
    network = near.propose_fault_network()
    assert not any((row.fault, row.other) == ("F2", "F1") for row in network.rows)
    trial = network.trial(near)
    assert_all_decided(near, trial)
    assert not trial.dropped
