"""Regions and the reservoir: which units they are, what answers show; nothing gets lost."""

from __future__ import annotations

import itertools
import math
import pickle

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import InputError, ScenarioError
from geosurf.report import report_scene
from geosurf.report.tables import volume_table
from geosurf.scenario.validate import find_mistakes, read_scenario
from tests.grids import gridded
from tests.messages import refused
from tests.planes import scenario_tables

SIZE, N_ZONE = 1000.0, 3
BOX = (0.0, SIZE, 0.0, SIZE, -500.0, 0.0)
CONTACT = {"OWC": -260.0}


def horizon(level, dice, n=6):
    x = np.linspace(-10.0, SIZE + 10.0, n)
    return gridded(level + 12.0 * dice.random((n, n)), x)


def wall(name, start, end, low, high, lean=0.0):
    """A plane fault along a line in the map, from one elevation to another."""
    (ax, ay), (bx, by) = start, end
    corners = [(ax, ay, low), (bx, by, low), (bx + lean, by, high), (ax + lean, ay, high)]
    return gs.TriSurface(name, "fault", corners, [[0, 1, 2], [0, 2, 3]])


def random_world(seed):
    """Horizons, and faults of which some end above, below, or inside the model."""
    dice = np.random.default_rng([seed, 11])
    horizons = {f"H{k}": horizon(-100.0 - 90.0 * k, dice) for k in range(N_ZONE + 1)}
    faults = {}
    for k in range(int(dice.integers(1, 4))):
        low, high = sorted(dice.choice([-510.0, -330.0, -240.0, -150.0, 10.0], 2, replace=False))
        turn, shift = dice.uniform(0.0, math.pi), dice.uniform(0.25, 0.75, 2) * SIZE
        along = np.array([math.cos(turn), math.sin(turn)]) * 2.0 * SIZE
        end = shift + along * (0.0 if dice.random() < 0.2 else 1.0) + 1.0
        lean = float(dice.uniform(-60.0, 60.0))
        faults[f"F{k + 1}"] = wall(f"F{k + 1}", shift - along, end, low, high, lean)
    if dice.random() < 0.5:  # a corner of less than 1/1000, in some zones
        a = 15.0 + 20.0 * dice.random()
        low = float(dice.choice([-510.0, -240.0]))
        faults["C"] = wall("C", (-5.0, a + 5.0), (a + 5.0, -5.0), low, 10.0)
    return horizons, faults


def slow_regions(scene):
    """Regions by a matching that lists every triangle and asks for the best pair each time."""
    units, patches = list(scene.units.values()), scene.patches
    inner = {f"{a}/{b}" for a, b in itertools.pairwise(scene.horizon_names)}
    blocks = list(dict.fromkeys((u.zone, u.block) for u in units if u.zone in inner))
    shared: dict[bool, dict] = {True: {}, False: {}}
    a, b, c = np.moveaxis(patches.local[patches.triangles], 1, 0)
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    for area, row, (front, back) in zip(
        areas.tolist(), patches.surface_of_triangle, scene.units.sides, strict=True
    ):
        pair = tuple(sorted(
            blocks.index((units[u].zone, units[u].block))
            for u in (front, back) if u >= 0 and units[u].zone in inner
        ))  # fmt: skip
        if len(pair) == 2 and pair[0] != pair[1]:
            is_horizon = patches.sources[row].role == "horizon"
            shared[is_horizon].setdefault(pair, []).append(area)
    volume = [math.fsum(u.volume for u in units if (u.zone, u.block) == b) for b in blocks]

    def between(one, two, *kinds):
        parts = [
            area for kind in kinds for (p, q), areas in shared[kind].items() for area in areas
            if (p in one and q in two) or (p in two and q in one)
        ]  # fmt: skip
        return float(f"{math.fsum(parts):.9g}")

    regions, tried = [{k} for k in range(len(blocks))], set()
    while True:
        best = max(
            (p for p in shared[True] if p not in tried), default=None,
            key=lambda p: (between({p[0]}, {p[1]}, True), -p[0], -p[1]),
        )  # fmt: skip
        if best is None:
            break
        tried.add(best)
        one, two = (next(r for r in regions if k in r) for k in best)
        plain = {(z, b.split(" #")[0]) for z, b in (blocks[k] for k in one | two)}
        if one is not two and len({z for z, _ in plain}) == len(plain):
            regions = [r for r in regions if r not in (one, two)] + [one | two]

    def size(region):
        return math.fsum(volume[k] for k in region)

    for kinds in ((True,), (True, False)):
        while True:  # what touches large ones goes to them, then what touches those
            small = [r for r in regions if size(r) < 1e-3 * math.fsum(volume)]
            large = [r for r in regions if r not in small]
            moves = []
            for region in small:
                to = max(large, key=lambda r, of=region: (between(of, r, *kinds), -min(r)))
                if between(region, to, *kinds) > 0.0:
                    moves.append((region, to))
            if not moves:
                break
            for region, to in moves:
                regions.remove(region)
                to |= region
    return {frozenset(blocks[k] for k in region) for region in regions}


@pytest.fixture(scope="module")
def worlds():
    return {seed: gs.Scene(*random_world(seed), BOX, contacts=CONTACT) for seed in range(24)}


def test_proposals_are_those_of_a_slow_matching_and_nothing_is_lost(worlds):
    n_region = n_remnant = 0
    for seed, scene in worlds.items():
        found = scene.regions
        assert {frozenset(one.blocks) for one in found.values()} == slow_regions(scene), seed
        assert [*found] == [chr(ord("A") + k) for k in range(len(found))]
        sizes = [one.volume for one in found.values()]
        assert sizes == pytest.approx(sorted(sizes, reverse=True), rel=1e-9)
        n_region += len(found)
        n_remnant += sum(len(one.remnants) for one in found.values())

        # sums by any labels are sums of the units
        total = math.fsum(u.volume for u in scene.units.included().values())
        for by in ("region", ("region", "zone"), ("zone", "contact", "region")):
            assert float(scene.table(by=by).volume.sum()) == pytest.approx(total, rel=1e-12)
        table = scene.table(by=("zone", "region", "contact")).volume
        for unit in scene.units.included().values():
            same = [
                u.volume for u in scene.units.values()
                if (u.zone, u.region, u.contact) == (unit.zone, unit.region, unit.contact)
            ]  # fmt: skip
            at = table.sel(zone=unit.zone, region=unit.region, contact=unit.contact)
            assert float(at) == pytest.approx(math.fsum(same), rel=1e-12)
    assert n_region > 40
    assert n_remnant > 12


def test_the_order_of_faults_does_not_matter(worlds):
    for seed in range(0, 24, 6):
        horizons, faults = random_world(seed)
        again = gs.Scene(horizons, dict(reversed(faults.items())), BOX, contacts=CONTACT)
        assert dict(again.regions) == pytest.approx(dict(worlds[seed].regions)), seed


def halves(middle, **more):
    """Two zones in two halves of a box, and a fault between that the upper zone alone ends at."""
    dice = np.random.default_rng(1)
    horizons = {name: horizon(z, dice) for name, z in (("T", -100.0), ("M", -200), ("B", -300))}
    fault = wall("F", (middle, -10.0), (middle, SIZE + 10.0), -510.0, 10.0)
    return gs.Scene(horizons, {"F": fault}, BOX, **more)


def test_names_survive_a_chain_of_replace():
    scene = halves(450.0)
    west, east = (50.0, 500.0, -150.0), (950.0, 500.0, -150.0)
    assert scene.sample([west, east]).region.values.tolist() == ["B", "A"]
    for middle in (520.0, 560.0, 640.0):  # the west is the larger one from here on
        scene = scene.replace(faults={"F": halves(middle).surface("F")})
        assert scene.sample([west, east]).region.values.tolist() == ["B", "A"]
    assert list(scene.regions) == ["B", "A"]
    assert list(halves(640.0).regions) == ["A", "B"]
    assert halves(640.0).sample([west]).region.item() == "A"

    # a fault more: the larger part keeps the name, the other has a new one, and it comes back
    cross = wall("G", (-10.0, 300.0), (SIZE + 10.0, 300.0), -510.0, 10.0)
    more = scene.replace(faults={"G": cross}, contacts=CONTACT)
    assert set(more.volumes.region.values) == {"A", "B", "C", "D"}
    assert more.sample([(50.0, 900.0, -150.0)]).region.item() == "B"
    back = more.replace(faults={"G": None}, horizons={"M": None})
    assert back.sample([west, east]).region.values.tolist() == ["B", "A"]
    assert pickle.loads(pickle.dumps(back)).sample([west]).region.item() == "B"

    # user's names go on as well, and new ones leave the others their letters
    spot = 50.0, 900.0
    named = more.replace(regions={"North": spot})
    assert named.sample([(50.0, 900.0, -150.0)]).region.item() == "North"
    assert {"A", "C", "D"} < set(named.regions)
    moved = named.replace(faults={"F": halves(600.0).surface("F")})
    assert moved.sample([(50.0, 900.0, -150.0)]).region.item() == "North"

    # one block is left: one of the four names stays, and a name of a user does not go silently
    one = named.replace(faults={"F": None, "G": None}, regions={"NW": spot, "SE": (950.0, 50.0)})
    refused(InputError, "name one region", lambda: one.regions)
    both = more.replace(regions={"NW": spot, "SE": (950.0, 50.0)})
    assert {"NW", "SE"} < set(both.regions)
    one = both.replace(faults={"F": None, "G": None})
    with pytest.warns(gs.GeosurfWarning, match="Region '(NW|SE)' is gone"):
        assert len(one.regions) == 1
    assert "region" in {warning.kind for warning in one.warnings}


def test_a_region_below_another_keeps_its_name():
    """Seen from above it is nowhere, and its blocks have other names where a wedge is gone."""
    horizons, faults = random_world(1077)
    scene, top = gs.Scene(horizons, faults, BOX, contacts=CONTACT), horizons["H1"]
    names = set(scene.regions)
    assert len(names) == 2
    for shift in (-1.8, 1.3, -0.6, 1.9, -1.2, 0.4):
        scene = scene.replace(horizons={"H1": top.copy(data=top + shift)})
        assert set(scene.regions) == names


def test_names_of_users(tmp_path):
    scene = halves(450.0)
    # all of the western region, and less than half of the eastern one
    left = [[-9, -9], [-9, 1009], [600, 1009], [600, -9]]
    lines = [f"{x} {y} 0.0\n" for x, y in (*left, left[0])]
    (tmp_path / "left.pol").write_text("".join(lines) + "999.0 999.0 999.0\n")
    for name in ((100.0, 50.0), ("F-",), left, np.array(left), tmp_path / "left.pol"):
        found = scene.replace(regions={"West": name, "East": (900.0, 1.0)})
        assert found.regions["West"].blocks == (("T/M", "F-"), ("M/B", "F-")), name
        assert list(found.regions) == ["East", "West"]
    whole = [[-9, -9], [1009, -9], [1009, 1009], [-9, 1009]]
    both = scene.replace(regions={"All": whole})
    assert list(both.regions) == ["All"]
    assert len(both.regions["All"].blocks) == 4
    assert both.table(by="region").volume.item() == pytest.approx(both.volumes.sum().item())

    twice = scene.replace(regions={"W": (9.0, 9.0), "X": (9.0, 500.0)})
    refused(InputError, "name one region.*names split nothing", lambda: twice.volumes)
    # what was measured before has the new names
    ntg = horizon(0.5, np.random.default_rng(2)) * 0.0 + 0.5
    fluids = {"fluids": "oil", "net_to_gross": ntg.drop_attrs()}
    for one, names in ((scene, {"A", "B"}), (scene.replace(regions={"W": ("F-",)}), {"A", "W"})):
        assert len(one.units) == 8
        assert set(one.volumetrics(**fluids).region.values) == names
    refused(InputError, "by is 'fluid'", scene.table, by="fluid")


def test_tables_samples_wells_closures_and_files_have_it(worlds, tmp_path):
    scene = worlds[3]
    for unit in scene.units.values():
        assert (unit.region == "") == (unit.zone not in scene.reservoir)
        assert unit.region == "" or (unit.zone, unit.block) in scene.regions[unit.region].blocks
    levels = scene.replace(contacts={"OWC": -265.0})
    at_levels = dict(zip(levels.volumes.unit.values, levels.volumes.region.values, strict=True))
    assert at_levels == {u.name: u.region for u in levels.units.included().values()}

    well = scene.well_intervals([[300, 400, 0], [700, 600, -500]])
    for found in (scene.sample(cell=(90.0, 90.0, 30.0)), well):
        names = (found[key].values.ravel() for key in ("unit", "region"))
        for unit, region in zip(*names, strict=True):
            assert region == (scene.units[unit].region if unit else "")
    for name, place in scene.region_labels("H1").items():
        assert scene.sample(place - [0.0, 0.0, 1e-6]).region.item() == name
    words = scene.plot.map("H1", regions=True, size=(640, 400)).axes[1].texts
    assert {*scene.regions} & {one.get_text() for one in words}
    gs.write(scene.units, tmp_path / "units.csv")
    head, *rows = (tmp_path / "units.csv").read_text().splitlines()
    column = head.split(",").index("region")
    assert [row.split(",")[column] for row in rows] == [u.region for u in scene.units.values()]
    closed = scene.replace(contacts=None).closures(min_height=0.1)
    places = zip(closed.zone.values, closed.block.values, closed.region.values, strict=True)
    assert closed.sizes["closure"]
    assert all((z, b) in scene.regions[r].blocks for z, b, r in places)
    assert volume_table(scene.units).head == ("Zone", *scene.regions, "all regions")


def test_scenarios_name_them(tmp_path):
    world = gs.synthetic.tilted_planes(n=5)
    tables = scenario_tables(tmp_path, world.horizons, world.faults)
    path = tmp_path / "scenario.toml"
    for value, words in (('["F2+"]', "unknown side"), ('"no.pol"', "not there"), ("5", "Give {")):
        path.write_text(f"{tables}[regions]\nHigh = {value}\n")
        (mistake,) = find_mistakes(path)
        assert words in mistake.sentence
    path.write_text(f'{tables}[regions]\nHigh = ["F1-"]\n')
    scene = gs.run_scenario(path, tmp_path / "out", pictures=False)
    assert set(scene.regions) == {"High", "A"} or set(scene.regions) == {"High", "B"}
    assert ",High," in (tmp_path / "out" / "volumes.csv").read_text()


# ---- The reservoir: which zones answers show, which contacts cut, and that nothing gets lost.
INNER = ("Top/Middle", "Middle/Base")
LEVEL = -2150.0


@pytest.fixture(scope="module")
def scene(graben):
    return graben.replace(contacts={"OWC": LEVEL})


def by_block(table, zones):
    """Volume of each zone and block, all contact intervals together."""
    found: dict[tuple[str, str], list[float]] = {}
    rows = zip(*(table[key].values.tolist() for key in ("zone", "block", "volume")), strict=True)
    for zone, block, volume in rows:
        if zone in zones:
            found.setdefault((zone, block), []).append(volume)
    return {key: math.fsum(parts) for key, parts in found.items()}


@pytest.mark.parametrize("column", [{}, {"Top": "erosional"}, {"Middle": "base"}])
def test_it_is_what_lies_between_two_horizons_and_a_contact_cuts_nothing_else(graben, column):
    plain = graben.replace(column=column)
    scene = plain.replace(contacts={"OWC": LEVEL, "FWL": LEVEL - 20.0})
    assert scene.reservoir == plain.reservoir == INNER
    assert scene.volumes.sum().item() == pytest.approx(plain.volumes.sum().item(), rel=1e-12)

    # outside nothing changes, but for the last digit; inside, the parts of a contact are the zone
    table, before = scene.table("all"), plain.table("all")
    outer = ("above Top", "below Base")
    assert by_block(table, outer) == pytest.approx(by_block(before, outer), rel=1e-14)
    assert by_block(table, INNER) == pytest.approx(by_block(before, INNER), rel=1e-12)
    assert {u.zone for u in scene.units.values() if u.contact} == set(INNER)
    assert {u.zone for u in scene.units.values() if not u.contact} == set(outer)
    w, e, s, n, low, high = scene.box
    whole = (e - w) * (n - s) * (high - low)
    assert math.fsum(table.volume.values.tolist()) == pytest.approx(whole, rel=1e-12)
    assert scene.check().ok

    # one answer, whoever computes it: levels that pass over units, or the arrangement
    assert scene.volumes.unit.values.tolist() == [*scene.units.included()]
    np.testing.assert_allclose(scene.volumes, scene.units.included().volumes, rtol=1e-12)


def test_chosen_zones_and_named_zones(graben):
    scene = graben.replace(reservoir=["Middle/Base"], contacts={"OWC": LEVEL})
    assert set(scene.volumes.zone.values) == {"Middle/Base"}
    assert {u.zone for u in scene.units.values() if u.contact} == {"Middle/Base"}

    # zones of a contact stay as they are named, in the reservoir or not
    entries = [gs.FluidContact(LEVEL, zones="Top/Middle"), gs.FluidContact(LEVEL - 5.0)]
    mixed = scene.replace(contacts={"OWC": entries})
    assert {u.zone for u in mixed.units.values() if u.contact} == set(INNER)
    assert mixed.check().ok

    # it travels, and the default follows the horizons
    assert pickle.loads(pickle.dumps(scene)).reservoir == ("Middle/Base",)
    assert scene.replace(faults={"F2": None}).reservoir == ("Middle/Base",)
    assert graben.replace(horizons={"Middle": None}).reservoir == ("Top/Base",)
    few = graben.replace(horizons={"Middle": None, "Base": None})
    assert few.reservoir == ("above Top", "below Top")
    assert few.volumes.sum().item() == pytest.approx(few.units.volume, rel=1e-15)


def test_tables_show_it_and_say_what_they_leave_out(scene, tmp_path):
    units = scene.units
    assert scene.table().unit.values.tolist() == scene.volumes.unit.values.tolist()
    assert "reservoir" not in scene.table().coords
    everything = scene.table(include="all")
    assert everything.unit.values.tolist() == list(units)
    inside = everything.reservoir.values
    assert set(everything.zone.values[inside]) == set(INNER)
    refused(InputError, "include is 'every'", scene.table, "every")

    rest = math.fsum(everything.volume.values[~inside].tolist())
    note = f"Not shown: 6 units outside the reservoir, {rest / 1e6:.0f} million m³. "
    assert note in str(units).replace("12 600", "12600")
    assert "above Top" not in str(units)
    assert "above Top" not in units._repr_html_()
    assert [row[0] for row in volume_table(units).rows] == [
        f"{zone}, {part} OWC" for zone in INNER for part in ("above", "below")
    ]
    assert volume_table(units, "all").foot[0] == "all zones"
    for include, n_zone in (("reservoir", 0), ("all", 1)):
        page = report_scene(scene, tmp_path, {}, include=include).read_text(encoding="utf-8")
        section = page.partition('id="volumes"')[2].partition("</table>")[0]
        assert section.count(">above Top<") == n_zone
        assert ("Not shown: 6 units" in page) is (include == "reservoir")


def test_pictures_show_it(scene):
    """The exploded view, the section, and the interactive view, in which the others are hidden."""
    from geosurf.render.colouring import Selection
    from geosurf.render.surface_layers import show_units

    def names(**choice):
        return {one.label for one in show_units(scene.units, only=Selection(**choice)).legend}

    shown = names()
    assert not any(name.startswith(("above Top", "below Base")) for name in shown)
    assert any(name.startswith("above Top") for name in names(include="all"))
    assert len(names(names=("above Top",))) == 3  # a zone that is asked for by name
    assert names(names=("F1-",)) == {name for name in shown if "F1-" in name or name in INNER}
    hidden = {body.name for body in scene.view_3d().bodies if not body.shown}
    assert hidden == set(scene.units) - set(scene.units.included())

    line = [(200.0, 2000.0), (4800.0, 2000.0)]
    words = [text.get_text() for text in scene.plot.section(line).axes[0].texts]
    for zone in ("above the reservoir", "below the reservoir"):
        assert words.count(zone) == 1
    assert not any(word.startswith(("above Top", "below Base")) for word in words)


def test_scenarios_have_it(tmp_path):
    tables = scenario_tables(tmp_path, gs.synthetic.tilted_planes(n=5).horizons)
    path = tmp_path / "scenario.toml"
    path.write_text(f'title = "A"\nreservoir = ["Top/Bsae"]\n{tables}[output]\ninclude = "al"\n')
    mistakes = [(one.line, one.sentence) for one in find_mistakes(path)]
    assert [line for line, _ in mistakes] == [2, 10]
    assert "Did you mean 'Top/Base'?" in mistakes[0][1]
    path.write_text(f'reservoir = ["below Base"]\n{tables}')
    assert gs.run_scenario(path, tmp_path / "out", pictures=False).reservoir == ("below Base",)
    assert (tmp_path / "out" / "volumes.csv").read_text().count("\n") == 2
    path.write_text(f"reservoir = []\n{tables}")
    refused(ScenarioError, "give a list of zones", read_scenario, path)


def test_juxtaposition_shows_it(scene):
    every = scene.juxtaposition("F1", "all")
    assert every.area.sum().item() == pytest.approx(every.attrs["area"], rel=1e-12)
    shown = scene.juxtaposition("F1").to_dataframe()
    sides = every.to_dataframe()[["zone_plus", "zone_minus"]].isin(INNER)
    assert len(shown) == sides.any(axis=1).sum() < every.sizes["pair"]
    assert shown[["zone_plus", "zone_minus"]].isin(INNER).any(axis=1).all()


@pytest.mark.parametrize("suffix", [".ml", ".epc"])
def test_a_sealed_model_keeps_it_and_the_regions(scene, tmp_path, suffix):
    if suffix == ".epc":
        pytest.importorskip("h5py")
    chosen = scene.replace(reservoir=[INNER[0]])
    back = gs.read_units(gs.write(chosen.units, tmp_path / f"model{suffix}")[0])
    assert back.reservoir == (INNER[0],)
    assert len(back.included()) == len(chosen.units.included()) < len(back)
    assert [u.region for u in back.values()] == [u.region for u in chosen.units.values()]


def test_ensembles_answer_for_it(scene):
    from geosurf.ensemble import ContactLevel, Uniform
    from geosurf.ensemble.results import quantile_text

    level = ContactLevel("OWC", shift=Uniform(-9.0, 9.0))
    result = gs.run_ensemble(scene, 10, uncertain=[level], progress=False)
    assert tuple(result.sums("zone").zone.values) == INNER
    everything = result.sums("zone", include="all")
    assert tuple(everything.zone.values) == ("above Top", *INNER, "below Base")
    for name in everything.zone.values:  # no contact moves any zone as a whole
        np.testing.assert_allclose(everything.sel(zone=name), everything.sel(zone=name)[0], 1e-12)
    base = result.quantiles("unit").base.sum().item()
    assert base == pytest.approx(scene.volumes.sum().item(), rel=1e-12)
    every = result.quantiles("unit", include="all")
    assert every.sizes["unit"] == result.data.sizes["unit"]
    assert "Not shown: 6 units outside the reservoir, 12 600 million m³" in quantile_text(result)
    assert "Not shown" not in quantile_text(result, "all")
