"""Zones from thickness: closed forms on planes, sums, faults, and what follows a reference."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import geosurf as gs
from benchmarks.random_networks import random_network
from geosurf.errors import GeosurfWarning, InputError
from geosurf.scenario import build_scene, read_scenario
from tests.grids import gridded
from tests.planes import scenario_tables

X = np.linspace(0.0, 2000.0, 21)
BOX = (100.0, 1900.0, 100.0, 1900.0, -2600.0, -1500.0)


def grid(z, **attrs):
    """A grid over 2 km; `z` is a number, an array, or a function of easting and northing."""
    x, y = np.meshgrid(X, X)
    values = z(x, y) if callable(z) else np.broadcast_to(np.asarray(z, dtype=float), x.shape)
    return gridded(values, X, **attrs)


TOP = grid(lambda x, y: -1900.0 + 0.1 * x - 0.05 * y)
BASE = grid(lambda x, y: -2100.0 + 0.08 * x)


def heights(scene, name):
    return scene.surface(name).lattice.elevation


def test_planes_move_by_their_thickness_and_isopachs_along_the_normal():
    zones = {
        "A": {"below": "Top", "thickness": grid(12.5 / 0.3048, units="ft")},
        "B": {"below": "A", "thickness": 8.0, "kind": "isopach", "base": "M"},
        "C": {"above": "Base", "thickness": 5.0},
    }
    scene = gs.Scene({"Top": TOP, "Base": BASE}, box=BOX, zones=zones)
    assert scene.horizon_names == ("Top", "base A", "M", "top C", "Base")
    np.testing.assert_allclose(heights(scene, "base A"), TOP - 12.5, atol=1e-9)
    np.testing.assert_allclose(heights(scene, "top C"), BASE + 5.0, atol=1e-9)
    secant = np.sqrt(1.0 + 0.1**2 + 0.05**2)
    np.testing.assert_allclose(heights(scene, "M"), TOP - 12.5 - 8.0 * secant, atol=1e-9)
    normal = scene.thickness("base A/M", 200.0, kind="isopach")
    np.testing.assert_allclose(normal, 8.0, atol=1e-6)
    area = 1800.0**2
    volumes = {unit.zone: unit.volume for unit in scene.units.values()}
    assert volumes["Top/base A"] == pytest.approx(12.5 * area, rel=1e-9)
    assert volumes["top C/Base"] == pytest.approx(5.0 * area, rel=1e-9)
    assert scene.check().ok


def test_isopachs_keep_their_slope_at_the_ragged_edge_of_a_grid():
    ragged = TOP.where((TOP.easting + TOP.northing > 450.0) & (TOP.easting != 1000.0))
    zones = {"A": {"below": "Top", "thickness": 8.0, "kind": "isopach"}}
    made = heights_of(gs.Scene({"Top": ragged}, zones=zones), "base A")
    secant = np.sqrt(1.0 + 0.1**2 + 0.05**2)
    np.testing.assert_allclose(made, ragged - 8.0 * secant, atol=1e-9)


def test_random_networks_fill_what_is_between_two_horizons_and_are_never_negative():
    rng = np.random.default_rng(4)
    for _ in range(40):
        top, room = rng.normal(-1900.0, 30.0, (21, 21)), rng.uniform(-10.0, 90.0, (21, 21))
        horizons = {"Top": grid(top), "Base": grid(top - room)}
        names = [f"Z{k}" for k in range(int(rng.integers(2, 6)))]
        zones, before = {}, "Top"
        for name in names:
            thick = np.maximum(rng.normal(10.0, 12.0, (21, 21)), 0.0) * (rng.random() < 0.9)
            zones[name] = {"below": before, "thickness": grid(thick).drop_attrs()}
            before = name
        zones[names[-1]]["base"] = "Base"
        scene = gs.Scene(horizons, box=BOX, zones=zones)
        made = [np.asarray(TOP * 0 + top), *(
            heights_of(scene, name) for name in scene.horizon_names[1:-1]
        ), np.minimum(top - room, top)]  # fmt: skip
        parts = -np.diff(made, axis=0)
        assert parts.min() >= -1e-9
        np.testing.assert_allclose(parts.sum(axis=0), np.maximum(room, 0.0), atol=1e-9)
        total = sum(np.asarray(zones[name]["thickness"]) for name in names)
        for name, part in zip(names, parts, strict=True):
            share = np.asarray(zones[name]["thickness"]) / np.where(total > 0.0, total, 1.0)
            share = np.where(total > 0.0, share, 1.0 / len(names))
            np.testing.assert_allclose(part, share * np.maximum(room, 0.0), atol=1e-9)
        found = scene.zone_corrections
        assert found.model.sum() == pytest.approx(np.maximum(room, 0.0).mean(), abs=1e-9)


@pytest.mark.parametrize(("family", "seed"), [("X", 0), ("tips", 9)])
@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
def test_zones_at_faults_are_closed_and_never_change_their_sum(family, seed):
    network = random_network(family, np.random.default_rng(seed), 0)
    top, faults, n = network.horizon, network.faults, np.arange(len(network.horizon))
    waves = np.add.outer(0.9 * np.cos(n / 7.0), 0.8 * np.sin(n / 5.0))
    zones = {"A": {"below": "Top", "thickness": top.copy(data=25.0 * np.maximum(1.0 + waves, 0.0))}}
    zones["B"] = {"below": "A", "thickness": 20.0, "base": "Base"}
    horizons = {"Top": top, "Base": (top - 60.0).assign_attrs(top.attrs)}
    scene = gs.Scene(horizons, faults, tear=True, zones=zones)
    assert scene.check().ok
    sheets = {name: scene.sheets[name] for name in horizons}
    plain = gs.Scene(sheets, {name: scene.surface(name) for name in faults}, scene.box)
    assert float(scene.volumes.sum()) == pytest.approx(float(plain.volumes.sum()), rel=1e-12)


@pytest.mark.parametrize(
    ("side", "end", "clipped", "rule"),
    [("below", "base", "Base", "base"), ("above", "top", "top A", "erosional")],
)
def test_a_zone_without_room_is_named_with_what_is_too_much(side, end, clipped, rule):
    # 180 m at x = 100, in a room of 200 m; 20 m too thick at x = 1900
    horizons = {"Top": grid(-1900.0), "Base": grid(-2100.0)}
    start, other = ("Top", "Base") if side == "below" else ("Base", "Top")
    thick = grid(lambda x, y: 180.0 + (x - 100.0) / 45.0)
    zones = {"A": {side: start, "thickness": thick}}
    scene = gs.Scene(horizons, box=BOX, zones=zones)
    with pytest.warns(GeosurfWarning, match=f"'A' is thicker than the room between '{start}' and"):
        assert scene.check().ok
    (found,) = scene.warnings
    assert f"'{other}' on 50 % of the area, by up to 20 m at (E 1900" in found.effect
    assert f"'{clipped}' is clipped" in found.effect

    # both remedies that it names
    row = {side: "A", "thickness": 10, end: other}
    assert str(row) in found.remedy
    fitted = scene.replace(zones={**zones, "B": row})
    assert f"{{'{other}': '{rule}'}}" in found.remedy
    ruled = scene.replace(column={other: rule})
    for good in (fitted, ruled):
        assert float(good.volumes.sum()) == pytest.approx(200.0 * 1800.0**2, rel=1e-9)
        assert not good.warnings


def heights_of(scene, name):
    """Data of a horizon that is made, without a model."""
    return scene._plain.untied(name).lattice.elevation


def test_zero_pinches_out_maps_below_zero_are_warned_of_and_wells_count_by_distance():
    thick = grid(lambda x, y: np.where(x > 1000.0, 0.0, 20.0) - 1.0 * (y > 1950.0))
    scene = gs.Scene({"Top": TOP}, box=BOX, zones={"P": {"below": "Top", "thickness": thick}})
    with pytest.warns(GeosurfWarning, match="below 0 at 10 of 441"):
        base = heights(scene, "base P")
    np.testing.assert_allclose(TOP - base, np.maximum(thick, 0.0), atol=1e-9)
    assert scene.check().ok
    wells = {"easting": [300.0, 1500.0], "northing": [300.0, 900.0], "thickness": [10.0, 30.0]}
    scene = gs.Scene({"Top": TOP}, box=BOX, zones={"W": {"below": "Top", "thickness": wells}})
    found = (TOP - heights(scene, "base W")).sel(easting=[300.0, 1500.0], northing=[300.0, 900.0])
    np.testing.assert_allclose(np.diag(found), [10.0, 30.0], atol=1e-6)


def test_torn_horizons_take_the_throw_of_their_reference_and_follow_it():
    world = gs.synthetic.torn("normal", n=41)
    zones = {
        "Upper": {"below": "Top", "thickness": 40.0},
        "Lower": {"below": "Upper", "thickness": 25.0, "base": "Base"},
    }
    scene = gs.Scene(world.horizons, world.faults, tear=True, zones=zones)
    assert scene.check().ok
    profiles = [scene.throw(name, "F1", direction="mean") for name in ("Top", "Base")]
    low = max(float(one.along_strike.min()) for one in profiles) + 200.0
    high = min(float(one.along_strike.max()) for one in profiles) - 200.0
    at = np.linspace(low, high, 40)
    top, base = (np.interp(at, one.along_strike, one.throw) for one in profiles)
    assert abs(top - base).max() < 0.03 * top.max()
    median = scene.thickness("base Upper/Base", 100.0).median()
    assert float(median) == pytest.approx(25.0, abs=1e-6)

    # it is a step of the graph: replaced, pickled, and replaced by data
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(scene)).volumes, scene.volumes)
    data = world.horizons["Top"]
    moved = scene.replace(horizons={"Top": data.copy(data=data + 10.0)})
    shift = moved.thickness("Top/base Upper", 200.0).median()
    assert float(shift) == pytest.approx(40.0, abs=1e-6)
    fewer = scene.replace(zones={"Upper": {"below": "Top", "thickness": 5.0}})
    assert fewer.horizon_names == ("Top", "base Upper")
    assert scene.replace(zones=None).horizon_names == ("Top",)


def test_zones_that_are_fitted_beside_a_dipping_fault_have_the_throw_of_both():
    """Between the cut-offs of Top and Base, data of one wall are fitted to those of the other."""
    world = gs.synthetic.faulted_reservoir(n=81)
    zones = {
        "Upper": {"below": "Top", "thickness": 30.0},
        "Lower": {"below": "Upper", "thickness": 50.0, "base": "Base"},
    }
    horizons = {name: world.horizons[name] for name in ("Top", "Base")}
    scene = gs.Scene(horizons, world.faults, tear=True, zones=zones)
    for fault in world.faults:
        most = [float(abs(scene.throw(name, fault).throw).max()) for name in scene.horizon_names]
        assert max(most) - min(most) < 0.05 * max(most)
    assert not scene.warnings
    thick = scene.replace(zones={"Upper": {"below": "Top", "thickness": 260.0}})
    with pytest.warns(GeosurfWarning, match="'Upper' is thicker than the room"):
        assert len(thick.units.included()) == 2


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
@pytest.mark.parametrize("kind", ["gentle", "thrust"])
def test_below_a_thick_zone_throw_is_that_of_the_true_horizon(kind):
    # the fault is 5 to 8 cells further on there: data of one wall lie in the other
    thickness = 120.0
    world = gs.synthetic.torn(kind, n=61)
    truth = gs.synthetic.torn(kind, n=61, level=-thickness).truth["cutoffs"]
    zones = {"Upper": {"below": "Top", "thickness": thickness}}
    points = {"Top": world.truth["points"]}
    scene = gs.Scene(points, world.faults, tear=True, positive="up", zones=zones)
    cut = scene.sheets["base Upper"].cuts["F1"]
    true = (truth["F1", "-"] - truth["F1", "+"])[:, 2]
    along = np.argsort(truth["F1", "-"][:, 1])
    expected = np.interp(cut.stations[:, 1], truth["F1", "-"][along, 1], true[along])
    assert np.nanmean(np.abs(cut.throw - expected)) < 0.1 * np.abs(true).max()


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
def test_a_wrong_pick_of_the_reference_is_the_only_wrong_one_below_it():
    world = gs.synthetic.torn("normal", n=61)
    points = world.truth["points"].copy()
    wrong = int(np.hypot(points[:, 0] - 950.0, points[:, 1] - 800.0).argmin())
    points[wrong, 2] += 55.0
    zones = {"Upper": {"below": "Top", "thickness": 120.0}}
    scene = gs.Scene({"Top": points}, world.faults, tear=True, positive="up", zones=zones)
    rows = {h: [one["row"] for one in scene.sheets[h].report.left_out] for h in scene.sheets}
    assert rows == {"Top": [wrong], "base Upper": [wrong]}


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
def test_another_throw_than_that_of_the_reference_is_warned_of():
    world = gs.synthetic.torn("thrust", n=41)
    zones = {"Upper": {"below": "Top", "thickness": 30.0}}
    scene = gs.Scene(world.horizons, world.faults, tear=True, zones=zones)
    (found,) = [one for one in scene.warnings if one.kind == "throw of zone"]
    assert "'base Upper' has a throw of" in str(found)
    assert "'Top', which it is made of, has" in str(found)


def test_ties_and_ensembles_count_for_made_horizons():
    zones = {"A": {"below": "Top", "thickness": 30.0, "base": "M"}}
    tops = {"well": ["W"], "horizon": ["M"], "easting": [1000.0], "northing": [1000.0]}
    tops["elevation"] = [-1850.0 - 30.0 + 5.0]
    scene = gs.Scene({"Top": TOP}, box=BOX, zones=zones, tops=tops, tie={"range": 300})
    assert float(scene.misfit().misfit[0]) == pytest.approx(0.0, abs=1e-9)
    plain = gs.Scene({"Top": TOP}, box=BOX, zones=zones)
    shift = gs.ensemble.DepthShift("Top", gs.ensemble.Normal(0.0, 10.0))
    found = gs.run_ensemble(plain, 3, uncertain=[shift], progress=False).data
    zone = [str(one).startswith("Top/M") for one in found.unit.values]
    np.testing.assert_allclose(found.bulk.values[:, zone].sum(axis=1), 30.0 * 1800.0**2, rtol=1e-9)


def test_a_scenario_has_the_same_zones(tmp_path):
    gs.write(grid(20.0), tmp_path / "sand.nc")
    path = tmp_path / "scenario.toml"
    files = scenario_tables(tmp_path, {"Top": TOP, "Base": BASE})
    path.write_text(
        files + '[zones.Upper]\nbelow = "Top"\nthickness = "sand.nc"\nbase = "Middle"\n'
        '[zones.Lower]\nbelow = "Upper"\nthickness = 30\nbase = "Base"\n'
        '[grid]\nlayers = {"Top/Middle" = 2, "Middle/Base" = 3}\n'
    )  # fmt: skip
    scene = build_scene(read_scenario(path))
    assert scene.horizon_names == ("Top", "Middle", "Base")
    np.testing.assert_allclose(heights(scene, "Middle"), TOP - 0.4 * (TOP - BASE), atol=1e-9)
    path.write_text(path.read_text().replace('below = "Top"', 'below = "Tip"'))
    with pytest.raises(InputError, match="Did you mean 'Top'"):
        read_scenario(path)


@pytest.mark.parametrize(
    ("zones", "words"),
    [
        ({"A": 5.0}, "without a thickness"),
        ({"A": {"below": "Nope", "thickness": 5.0}}, "neither a horizon with data nor a zone"),
        ({"A": {"below": "B", "thickness": 5}, "B": {"below": "A", "thickness": 5}}, "counts from"),
        ({"A": {"below": "Top", "above": "Base", "thickness": 5.0}}, "takes 'below'"),
        ({"A": {"below": "Top", "thickness": 5.0, "kind": "true"}}, "expected one of"),
        ({k: {"below": "Top", "thickness": 5} for k in "AB"}, "two zones"),
        ({"A": {"below": "Top", "thickness": -5.0}}, "0 or more"),
        ({"A": {"below": "Top", "thickness": {"well": ["W"]}}}, "a table of wells"),
    ],
)  # fmt: skip
def test_wrong_zones_are_refused(zones, words):
    with pytest.raises(InputError, match=words):
        gs.Scene({"Top": TOP, "Base": BASE}, box=BOX, zones=zones).units  # noqa: B018
