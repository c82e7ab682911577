"""Fault seal: closed forms on planes, laws, and the closures and multipliers that rest on it."""

from __future__ import annotations

import re
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import InputError
from geosurf.synthetic.planar import _KINDS, _LEVELS
from tests.measure.test_closures import BOX, X, Y, thrown, upright
from tests.messages import refused

pytestmark = pytest.mark.filterwarnings("ignore:.*beside the reservoir rests on cut-offs")
VSHALE = {"above Top": 0.9, "Top/Middle": 0.1, "Middle/Base": 0.5, "below Base": 0.3}
MARKS = np.array([z for _, z in _LEVELS])  # horizons before faulting, at the middle of the box
VALUES = np.array([*VSHALE.values()])


@cache
def scene_of(kind: str, tilt: float = 1.5) -> gs.Scene:
    """Planes that plane faults move."""
    world = gs.synthetic.faulted(kind, n=9, tilt=tilt)
    faults, throw = world.faults, world.truth["throw"]
    horizons = {
        name: gs.throw_horizon(one, faults, throw, name=name)
        for name, one in world.horizons.items()
    }
    return gs.Scene(horizons, faults, world.box)


def layers_at(kind: str, tilt: float, fault: str, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Layer on both walls, as its elevation at the middle of the box before faulting."""
    slope = np.tan(np.radians(tilt)) * np.array([0.8, 0.6])
    found = []
    for side in "+-":
        shift = np.zeros_like(points)
        for key, (place, dip, azimuth, *_) in _KINDS[kind].items():
            # both walls of a fault lie on the same side of the other one
            d, a = np.radians([dip, azimuth])
            normal = np.array([np.sin(d) * np.sin(a), np.sin(d) * np.cos(a), np.cos(d)])
            hanging = (points.mean(axis=1) - np.array(place)) @ normal > 0.0
            hanging = np.full(len(points), side == "+") if key == fault else hanging
            shift += hanging[:, None, None] * _KINDS[kind][key].movement
        x = points - shift
        found.append(x[..., 2] - (x[..., :2] - [1000.0, 800.0]) @ slope)
    return found[0], found[1]


def shale_below(h: np.ndarray) -> np.ndarray:
    """Integral of shale from far below up to layers h: exact, piece by piece."""
    bounds = np.array([1e4, *MARKS, -1e4])
    parts = [np.clip(h, low, high) - low for high, low in pairwise(bounds)]
    return sum(v * part for v, part in zip(VALUES, parts, strict=True))


@pytest.mark.parametrize(
    ("kind", "tilt"), [("normal", 0.0), ("normal", 1.5), ("reverse", 2.0), ("vertical", 1.0),
                       ("graben", 1.5), ("X", 1.5)],
)  # fmt: skip
def test_planes_have_the_ratio_of_the_rock_between_the_layers_that_meet(kind, tilt):
    scene = scene_of(kind, tilt)
    for fault in scene.fault_names:
        found = scene.seal(fault, vshale=VSHALE, shale=0.4)
        points = np.stack([found[key].values for key in ("easting", "northing", "elevation")], -1)
        plus, minus = layers_at(kind, tilt, fault, points)
        expected = (shale_below(plus) - shale_below(minus)) / (plus - minus)
        for key in ("sgr", "sgr_plus", "sgr_minus"):
            np.testing.assert_allclose(found[key].values, expected, rtol=0, atol=1e-9)
        assert float(found.unknown_area.sum()) == 0.0
        assert found.attrs["coarse_area"] == 0.0

        # throw in the vertical is that of layers; one bed, Middle/Base, has a thickness of 100 m
        throw = _KINDS[kind][fault][3]
        if kind not in ("graben", "X"):
            np.testing.assert_allclose(found.throw.values, throw, atol=1e-9)
        across = scene.throw("Top", fault, direction="mean").throw
        assert float(abs(found.throw).max()) == pytest.approx(float(abs(across).max()), abs=1e-6)
        np.testing.assert_allclose(found.class_area.sum("sgr_class"), found.area, rtol=1e-12)
        np.testing.assert_array_equal(found.area, scene.juxtaposition(fault, "all").area)


def test_smear_is_that_of_the_nearer_end():
    world = {"above A": 0.1, "A/B": 0.1, "B/C": 0.8, "C/D": 0.1, "below D": 0.1}
    tops = zip("ABCD", (-1900.0, -1950.0, -1960.0, -2000.0), strict=True)
    fault, levels = upright(), {name: np.full((len(Y), len(X)), z) for name, z in tops}
    scene = gs.Scene(
        thrown(levels, 60.0, fault), {"F1": fault}, (0.0, 2000.0, -600.0, 600.0, -2200.0, -1700.0)
    )
    found = scene.seal("F1", vshale=world)
    z, csp = found.elevation.values, found.csp.values
    beside = (found.unit_minus[found.triangle_pair] == "C/D F1-").values
    beside &= (found.unit_plus[found.triangle_pair] == "A/B F1+").values
    below, above = -1960.0 - z[beside], z[beside] - (-1950.0 - 60.0)
    with np.errstate(divide="ignore"):
        np.testing.assert_allclose(csp[beside], 100.0 / np.minimum(below, above), rtol=1e-9)
    against = (found.zone_plus[found.triangle_pair] == "B/C").values
    assert against.any()
    assert np.isinf(csp[against]).all()
    assert (found.min_csp[found.zone_plus == "above A"].isin([0.0, np.inf])).all()


def test_areas_by_class_are_those_of_the_closed_form():
    scene, classes = scene_of("normal", 0.0), (0.15, 0.35, 0.55)
    found = scene.seal("F1", vshale=VSHALE, classes=classes)
    length, throw = 1600.0 / np.cos(np.radians(15.0)), _KINDS["normal"]["F1"][3]

    # level layers: the ratio depends on elevation alone, straight between cut-offs of both walls
    knots = np.sort([*MARKS, *(MARKS - throw), -2400.0, -1600.0])
    ratio = (shale_below(knots + throw) - shale_below(knots)) / throw
    share = np.zeros((len(knots) - 1, len(classes) + 1))
    for row, (a, b) in enumerate(pairwise(ratio)):
        at = (
            np.clip((np.array(classes) - a) / (b - a), 0, 1)
            if a != b
            else np.heaviside(classes - a, 0)
        )
        at = (
            np.sort([0.0, *(at if b >= a else 1.0 - at), 1.0])
            if a != b
            else np.array([0, *at, 1.0])
        )
        share[row] = np.diff(at)
    areas = np.diff(knots)[:, None] * share * length / np.sin(np.radians(60.0))
    np.testing.assert_allclose(
        found.class_area.sum("pair"), areas.sum(axis=0), rtol=1e-9, atol=1e-6
    )


def test_capacity_follows_the_calibration():
    found = scene_of("normal", 0.0).seal("F1", vshale=VSHALE, density_contrast=250.0, seabed=1000.0)
    depth = 1000.0 - found.elevation
    c = np.where(depth < 3000.0, 0.5, 0.25)  # Bretan et al. (2003)
    bar = 10.0 ** (found.sgr * 100.0 / 27.0 - c)
    np.testing.assert_allclose(found.threshold_pressure, bar, rtol=1e-12)
    np.testing.assert_allclose(found.column_height, bar * 1e5 / (250.0 * 9.80665), rtol=1e-12)
    kinds = dict(zip(found.unit_plus.values, found.juxtaposition.values, strict=True))
    assert kinds["Middle/Base F1+"] == "non-reservoir on non-reservoir"  # shale is no reservoir


def test_wells_give_the_mean_of_their_curve_in_each_zone():
    scene = scene_of("normal", 0.0)
    z = np.arange(-1800.0, -2201.0, -2.5)
    table = {"well": ["W"] * len(z), "md": 25.0 - z, "easting": np.full(len(z), 300.0)}
    table |= {"northing": np.full(len(z), 800.0), "elevation": z, "vshale": (-1800.0 - z) / 400.0}
    found = scene.seal("F1", vshale={"wells": table, "below Base": 0.7}).attrs["vshale"]
    means = {zone: float(value) for zone, value in re.findall(r"([^,:]+): ([\d.]+)", found)}
    middle = [-1865.0, -1960.0, -2040.0]
    expected = [(-1800.0 - z) / 400.0 for z in middle]
    assert [*means.values()] == pytest.approx([*expected, 0.7], rel=1e-5)


def test_a_closure_leaks_where_the_ratio_falls_below_the_limit():
    top = -1900.0 - 0.3 * abs(Y[:, None]) - 0.2 * abs(X - 950.0)  # -1910 at the fault
    fault, levels = upright(), {"Top": top, "Middle": top - 60.0, "Base": top - 120.0}
    scene = gs.Scene(thrown(levels, 40.0, fault), {"F1": fault}, BOX)
    given = {"above Top": 0.9, "Top/Middle": 0.5, "Middle/Base": 0.05, "below Base": 0.9}
    spill = lambda rule: scene.closures("Top", faults={"F1": rule}, vshale=given)  # noqa: E731
    found = spill({"sgr": 0.2})
    assert found.spill_kind[0] == "fault"

    # Middle/Base faces Top/Middle: from 0.5 at 60 m below the crest to 0.05 at 100 m
    leak = -1910.0 - 60.0 - 40.0 * (0.5 - 0.2) / (0.5 - 0.05)
    assert float(found.level[0]) == pytest.approx(leak, abs=0.09)  # 0.001 of the ratio
    assert float(found.leak_elevation[0]) == pytest.approx(leak, abs=0.09)
    for limit, word in ((0.0, "sealing"), (1.0, "juxtaposition")):
        one, other = spill({"sgr": limit}), spill(word)
        np.testing.assert_allclose(one.level, other.level, atol=1e-9)
        np.testing.assert_allclose(one.volume, other.volume, rtol=1e-9)
    levels = [float(spill({"sgr": limit}).level[0]) for limit in (0.0, 0.06, 0.1, 0.2, 0.4)]
    assert levels == sorted(levels)
    refused(InputError, "needs vshale", scene.closures, faults={"F1": {"sgr": 0.2}})
    refused(InputError, "is not a rule", scene.closures, faults={"F1": {"sgr": 20}}, vshale=given)


def test_multipliers_are_those_of_the_formula_and_decks_hold_them(tmp_path: Path):
    fault, flat = upright(1000.0), np.zeros((len(Y), len(X)))
    torn = thrown({"T": flat - 1950.0, "B": flat - 2050.0}, 33.0, fault)
    scene = gs.Scene(torn, {"F1": fault}, (0.0, 2000.0, -600.0, 600.0, -2200.0, -1800.0))
    model = gs.build_grid(scene, cell=100, layers=5)
    given = {"vshale": 0.25, "permeability": {"T/B": 100.0}}
    found = gs.fault_multipliers(scene, model, **given)
    rock = 10.0 ** (-4.0 * 0.25 - 0.25 * np.log10(33.0) * 0.75**5)
    expected = 1.0 / (1.0 + 33.0 / 66.0 * (2.0 / rock - 0.02) / (100.0 / 100.0 + 100.0 / 100.0))
    facing = np.isfinite(found.sgr.values)
    np.testing.assert_allclose(found.sgr.values[facing], 0.25, rtol=1e-9)
    np.testing.assert_allclose(found.multiplier, expected, rtol=1e-9)
    assert set(found.k.values[facing]) == {2, 3, 4, 5}  # the highest layer faces the overburden
    np.testing.assert_allclose(found.fault_multiplier, expected, rtol=1e-9)

    # a reader of its own: what the deck says of each face, and of the fault
    gs.write(found, tmp_path / "face.inc")
    text = re.sub(r"--.*", "", (tmp_path / "face.inc").read_text()).split()
    assert text[0] == "MULTX"
    words = [word.rpartition("*") for word in text[1:-1]]
    values = np.concatenate([np.full(int(n or 1), float(value)) for n, _, value in words])
    cells = np.reshape(values, model.shape)
    at = (found.k.values - 1, found.j.values - 1, found.i.values - 1)
    np.testing.assert_allclose(cells[at], expected, rtol=1e-5)
    assert (cells != 1.0).sum() == found.sizes["face"]
    gs.write(gs.fault_multipliers(scene, model, by="fault", **given), tmp_path / "fault.inc")
    line = re.search(r"MULTFLT\n 'F1' (\S+) /\n/", (tmp_path / "fault.inc").read_text())
    assert line is not None
    assert float(line[1]) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"vshale": {"Top/Midle": 0.2}}, "Zones are"),
        ({"vshale": {"Top/Middle": 20}}, "fraction from 0 to 1"),
        ({"vshale": {"Top/Middle": 0.2}}, "no value for zone"),
        ({"vshale": 0.2, "classes": (0.4, 0.2)}, "rising fractions"),
        ({"vshale": 0.2, "density_contrast": 0.0}, "kg/m3"),
        ({"vshale": {"wells": {"well": ["W"]}}}, "no column 'md'"),
    ],
)
def test_wrong_inputs_are_refused(given, words):
    refused(InputError, words, lambda: scene_of("normal").seal("F1", **given))
