"""The reservoir: which zones answers show, which contacts cut, and that nothing gets lost."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import InputError, ScenarioError
from geosurf.report import report_scene
from geosurf.report.tables import volume_table
from geosurf.scenario.validate import find_mistakes, read_scenario

INNER = ("Top/Middle", "Middle/Base")
LEVEL = -2150.0


@pytest.fixture(scope="module")
def plain():
    world = gs.synthetic.graben(n=9)
    return gs.Scene(world.horizons, world.faults, world.box)


@pytest.fixture(scope="module")
def scene(plain):
    return plain.replace(contacts={"OWC": LEVEL})


def by_block(table, zones):
    """Volume of each zone and block, all contact intervals together."""
    found: dict[tuple[str, str], list[float]] = {}
    rows = zip(*(table[key].values.tolist() for key in ("zone", "block", "volume")), strict=True)
    for zone, block, volume in rows:
        if zone in zones:
            found.setdefault((zone, block), []).append(volume)
    return {key: math.fsum(parts) for key, parts in found.items()}


@pytest.mark.parametrize("column", [{}, {"Top": "erosional"}, {"Middle": "base"}])
def test_it_is_what_lies_between_two_horizons_and_a_contact_cuts_nothing_else(plain, column):
    plain = plain.replace(column=column)
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


def test_chosen_zones_and_named_zones(plain):
    scene = plain.replace(reservoir=["Middle/Base"], contacts={"OWC": LEVEL})
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
    assert plain.replace(horizons={"Middle": None}).reservoir == ("Top/Base",)
    few = plain.replace(horizons={"Middle": None, "Base": None})
    assert few.reservoir == ("above Top", "below Top")
    assert few.volumes.sum().item() == pytest.approx(few.units.volume, rel=1e-15)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (["Top/Midle"], r"unknown zone 'Top/Midle'.* Did you mean 'Top/Middle'\?"),
        ([], r"reservoir is \[\]; give a list of zones, as in reservoir=\['Top/Middle'\]"),
        ("Top/Middle", "reservoir is 'Top/Middle'; give a list"),
        (7, "reservoir takes zones, not int"),
        ([None], "unknown zone None"),
    ],
)
def test_refusals(plain, value, words):
    with pytest.raises(InputError, match=words):
        plain.replace(reservoir=value)


def test_tables_show_it_and_say_what_they_leave_out(scene, tmp_path):
    units = scene.units
    assert scene.table().unit.values.tolist() == scene.volumes.unit.values.tolist()
    assert "reservoir" not in scene.table().coords
    everything = scene.table(include="all")
    assert everything.unit.values.tolist() == list(units)
    inside = everything.reservoir.values
    assert set(everything.zone.values[inside]) == set(INNER)
    with pytest.raises(InputError, match="include is 'every'"):
        scene.table("every")

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
    world = gs.synthetic.tilted_planes(n=5)
    for name, horizon in world.horizons.items():
        gs.write(horizon, tmp_path / f"{name}.nc")
    tables = "".join(f'[[horizons]]\nname = "{n}"\nfile = "{n}.nc"\n' for n in world.horizons)
    path = tmp_path / "scenario.toml"
    path.write_text(f'title = "A"\nreservoir = ["Top/Bsae"]\n{tables}[output]\ninclude = "al"\n')
    mistakes = [(one.line, one.sentence) for one in find_mistakes(path)]
    assert [line for line, _ in mistakes] == [2, 10]
    assert "Did you mean 'Top/Base'?" in mistakes[0][1]
    path.write_text(f'reservoir = ["below Base"]\n{tables}')
    assert gs.run_scenario(path, tmp_path / "out", pictures=False).reservoir == ("below Base",)
    assert (tmp_path / "out" / "volumes.csv").read_text().count("\n") == 2
    path.write_text(f"reservoir = []\n{tables}")
    with pytest.raises(ScenarioError, match="give a list of zones"):
        read_scenario(path)


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
    path = gs.write(chosen.units, tmp_path / f"model{suffix}")[0]
    back = gs.read_units(path)
    assert back.reservoir == (INNER[0],)
    assert len(back.included()) == len(chosen.units.included()) < len(back)
    assert [u.region for u in back.values()] == [u.region for u in chosen.units.values()]


def test_ensembles_answer_for_it(scene):
    from geosurf.ensemble import ContactLevel, Uniform
    from geosurf.ensemble.results import quantile_text

    level = ContactLevel("OWC", shift=Uniform(-9.0, 9.0))
    result = gs.run_ensemble(scene, 10, uncertain=[level], progress=False)
    zones = result.sums("zone")
    assert tuple(zones.zone.values) == INNER
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
