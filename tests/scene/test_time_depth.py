"""Scenes in time become scenes in depth: closed forms, both directions, and what is refused."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text

import geosurf as gs
from geosurf.errors import InputError
from tests import strategies
from tests.grids import gridded
from tests.messages import refused
from tests.sheets import junctions

X = np.linspace(0.0, 4000.0, 81)
Y = np.linspace(0.0, 2000.0, 41)
DIP, DROP, SLOPE, X0 = np.radians(60.0), 80.0, 0.05, 1800.0
BOX = (100.0, 3900.0, 100.0, 1900.0, -2600.0, -1500.0)
LINEAR = {"v0": 1700.0, "k": 0.65}


def fault_at(z: Any, dip: float = DIP) -> Any:
    """Easting of a fault that dips east and strikes north."""
    return X0 - (z + 2000.0) / np.tan(dip)


def plane(level: float, dip: float = DIP, slope: float = SLOPE) -> np.ndarray:
    """Elevation at the nodes of a plane, lower by DROP in the hanging wall, in the east."""
    z = level + slope * (X - 2000.0)
    return np.broadcast_to(np.where(fault_at(z, dip) > X, z, z - DROP), (len(Y), len(X)))


def fault(dip: float = DIP) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of the fault, in steps that need not be divided."""
    z, y = np.arange(-2700.0, -1350.0, 50.0), np.arange(-50.0, 2100.0, 50.0)
    x, y, z = np.broadcast_arrays(fault_at(z[:, None], dip), y, z[:, None])
    return np.stack([x, y, z], axis=2).reshape(-1, 3), strategies.grid("F1", z).triangles


def times(z: np.ndarray, velocity: Any) -> np.ndarray:
    """Minus two-way milliseconds, by the closed forms of a constant and of v0 + k z."""
    if isinstance(velocity, dict):
        return -2000.0 * np.log1p(velocity["k"] * -z / velocity["v0"]) / velocity["k"]
    return 2000.0 * z / velocity


def grid(values: np.ndarray, **attrs: str) -> xr.DataArray:
    return gridded(values, X, Y).drop_attrs().assign_attrs(attrs)


def in_time(law: Any, levels: dict[str, float], **words: Any) -> gs.Scene:
    """A scene of planes that were turned into time by a closed form."""
    x, triangles = fault()
    x = np.column_stack([x[:, :2], times(x[:, 2], law)])
    horizons = {
        name: grid(-times(plane(z), law), units="ms", positive="down") for name, z in levels.items()
    }
    words = {"tear": True, "box": BOX, "velocity": law, "time": "two-way"} | words
    return gs.Scene(horizons, {"F1": (x, triangles)}, **words)


CONSTANT_AND_LINEAR = pytest.mark.parametrize(
    "velocity", [3000.0, LINEAR], ids=["constant", "v0 + k z"]
)


@CONSTANT_AND_LINEAR
def test_planes_that_a_fault_cuts_have_depths_and_volumes_of_closed_forms(velocity: Any) -> None:
    levels = {"Top": -2000.0, "Base": -2150.0}
    horizons = {
        name: grid(times(z + SLOPE * (X - 2000.0) + 0.0 * Y[:, None], velocity), units="ms")
        for name, z in levels.items()
    }
    x, triangles = fault()
    x = np.column_stack([x[:, :2], times(x[:, 2], velocity)])
    words = {"positive": "up", "time": "two-way", "velocity": velocity}
    scene = gs.Scene(horizons, {"F1": (x, triangles)}, BOX, **words)
    assert all(line.startswith("pass") for line in str(scene.check()).splitlines())
    for name, z in levels.items():
        found = scene.surface(name).vertices
        np.testing.assert_allclose(found[:, 2], z + SLOPE * (found[:, 0] - 2000.0), rtol=1e-12)

    # a section is a quadrangle on each side of the fault
    t = np.tan(DIP)
    wall = [(X0 * t - 2000.0 - z + 2000.0 * SLOPE) / (t + SLOPE) for z in levels.values()]
    west, east, south, north = BOX[:4]
    for block, side in (("F1-", west), ("F1+", east)):
        across = 150.0 * abs(0.5 * sum(wall) - side)
        assert scene.units[f"Top/Base {block}"].volume == pytest.approx(
            across * (north - south), rel=1e-9
        )


@CONSTANT_AND_LINEAR
def test_torn_planes_have_the_throw_and_the_volumes_of_the_scene_in_depth(velocity: Any) -> None:
    levels = {"Top": -2000.0, "Base": -2150.0}
    scene = in_time(velocity, levels)
    horizons = {name: grid(plane(z), units="m", positive="up") for name, z in levels.items()}
    depth = gs.Scene(horizons, {"F1": fault()}, BOX, tear=True)
    assert all(line.startswith("pass") for line in str(scene.check()).splitlines())
    xr.testing.assert_allclose(scene.volumes, depth.volumes, rtol=1e-9)
    found, expected = scene.throw("Top", "F1").throw, depth.throw("Top", "F1").throw
    assert found.attrs["units"] == "m"
    assert float(found.max()) == pytest.approx(float(expected.max()), abs=1e-9)
    assert float(found.min()) == pytest.approx(float(expected.min()), abs=1e-9)


def test_each_wall_of_a_vertical_fault_has_the_velocities_of_its_own_side() -> None:
    x, triangles = fault(np.pi / 2.0)
    levels = {"Top": -2000.0, "Base": -2200.0}
    horizons = {name: grid(plane(z, np.pi / 2.0, 0.0), units="ms") for name, z in levels.items()}
    velocity = {"above Top": 2000.0, "Top/Base": 4000.0, "below Base": 3000.0}
    words = {"positive": "up", "time": "two-way", "velocity": velocity, "tear": True}
    scene = gs.Scene(horizons, {"F1": (x, triangles)}, **words)
    for side, top in (("-", -2000.0), ("+", -2000.0 - DROP)):
        for name, below in (("Top", 0.0), ("Base", 400.0)):
            z = np.concatenate(scene.cutoffs(name, "F1", side))[:, 2]
            np.testing.assert_allclose(z, top - below, rtol=0, atol=1e-6)
    assert scene.throw("Base", "F1").throw.values == pytest.approx(DROP)


def test_upright_faults_that_leave_the_horizons_come_back_from_time() -> None:
    top, faults, *_ = junctions.junction("bent main fault", np.random.default_rng(2))
    velocity = {"above Top": 2000.0, "elsewhere": 2600.0}
    scene = gs.Scene({"Top": top}, faults, tear=True, velocity=velocity)
    again = scene.in_time("two-way").replace(velocity=velocity)
    assert again.check().ok
    for name in ("Top", *faults):
        assert again.surface(name).bounds == pytest.approx(scene.surface(name).bounds, abs=1e-6)


@pytest.mark.parametrize("base", [-2120.0, -2300.0, -2500.0])
def test_where_a_fault_puts_fast_beside_slow_each_wall_has_its_own_column(base: float) -> None:
    velocity = {"above Top": 2200.0, "Top/Base": 3000.0, "below Base": 3500.0}
    words = {"velocity": velocity, "box": (*BOX[:4], -3600.0, -1500.0)}
    scene = in_time(2000.0, {"Top": -2000.0, "Base": base}, **words)
    for side, drop in (("-", 0.0), ("+", DROP)):
        x, _, z = np.concatenate(scene.cutoffs("Base", "F1", side)).T
        top = -2000.0 - drop + SLOPE * (x - 2000.0)
        np.testing.assert_allclose(z, 1.1 * top + 1.5 * (base + 2000.0), rtol=0, atol=0.2)


def test_below_a_dipping_fault_lines_run_through_the_rock_above_it() -> None:
    velocity = {"above Top": 2000.0, "Top/Base": 4000.0, "below Base": 3000.0}
    x, triangles = fault()
    flat = {"Top": plane(-2000.0, slope=0.0), "Base": plane(-2300.0, slope=0.0)}
    horizons = {name: grid(one, units="ms", positive="up") for name, one in flat.items()}
    words = {"velocity": velocity, "time": "two-way", "tear": True}
    scene = gs.Scene(horizons, {"F1": (x, triangles)}, **words)

    # a node of the footwall's Base, and one above it in the same column: 2000 m/s down to the Top
    # of the hanging wall, at -2080 ms, then 4000 m/s, also beyond the fault at -2086.6 ms
    for t in (-2300.0, -2200.0):
        depth = scene.to_depth([[1850.0, 1000.0, t]])[0, 2]
        assert depth == pytest.approx(-2080.0 + 2.0 * (t + 2080.0), abs=1e-6)
    # beside it, in the footwall alone
    assert scene.to_depth([[1000.0, 1000.0, -2250.0]])[0, 2] == pytest.approx(-2500.0, abs=1e-9)
    places = np.column_stack([np.random.default_rng(1).uniform(*box, 500) for box in
                              ((100, 3900), (100, 1900), (-2600, -1500))])  # fmt: skip
    np.testing.assert_allclose(scene.to_time(scene.to_depth(places)), places, rtol=0, atol=1e-6)
    # in the gap of a horizon, above the fault
    alone = scene.replace(horizons={"Base": None}, velocity={"above Top": 2e3, "below Top": 4e3})
    assert alone.to_depth([[1830.0, 1000.0, -2040.0]])[0, 2] == pytest.approx(-2040.0, abs=1e-9)


def test_a_scene_in_time_measures_milliseconds_and_refuses_volumes() -> None:
    scene = in_time(3000.0, {"Top": -2000.0, "Base": -2150.0}).in_time()
    assert scene.time == "two-way"
    throw, thickness = scene.throw("Top", "F1"), scene.thickness("Top/Base", 500.0)
    assert throw.throw.attrs["units"] == thickness.attrs["units"] == "ms"
    assert throw.heave.attrs["units"] == "m"
    assert float(thickness.max()) == pytest.approx(100.0)
    figure = scene.plot.section([(200.0, 1000.0), (3800.0, 1000.0)])
    assert "Two-way time [ms]" in [axes.get_ylabel() for axes in figure.axes]
    plot = scene.plot
    pictures = figure, plot.throw("F1"), plot.thickness("Top/Base", grid=200.0), plot.map("Top")
    shown = "\n".join(text.get_text() for one in pictures for text in one.findobj(Text))
    for words in ("1 ms is as high as", r"\d to \d+ ms", "max 100 ms", r"contour interval \d+ ms"):
        assert re.search(words, shown), (words, shown)
    assert "exaggeration" not in shown
    assert "Dotted: what the data" in shown
    assert any(axes.collections for axes in pictures[1].axes)  # a band of what they show
    shift = [gs.ensemble.DepthShift("Top", 5.0)]
    for asked in (
        lambda: scene.volumes, scene.table, scene.volumetrics, scene.closures,
        lambda: scene.horizon_grid("Top"), lambda: gs.run_ensemble(scene, 2, uncertain=shift),
        lambda: gs.build_grid(scene), lambda: gs.report_scene(scene, "never"),
    ):  # fmt: skip
        refused(InputError, r"Give velocities: scene.replace\(", asked)
    assert scene.units.table.volume.attrs["units"] == "m2 ms"
    (unit, *_) = scene.units.included().values()
    for noun in (scene.units, unit):
        for shown in (str(noun), repr(noun), noun._repr_html_()):
            assert "m²·ms" in shown
            assert "m³" not in shown
    with pytest.raises(InputError, match="moves horizons by metres"):
        gs.run_ensemble(in_time(3000.0, {"Top": -2000.0}), 2, uncertain=shift)


def test_what_tears_warn_of_in_time_is_listed_once_as_milliseconds() -> None:
    world = gs.synthetic.torn("Y", n=41, noise=2.0)
    horizons = {name: one.assign_attrs(units="ms") for name, one in world.horizons.items()}
    faults = {name: gs.triangulate_fault(one, name=name) for name, one in world.faults.items()}
    with pytest.warns(gs.GeosurfWarning, match="^In time .vertical numbers are ms, not m.: Hori"):
        found = gs.Scene(horizons, faults, time="two-way", tear=0.5).warnings
    assert found
    assert all(one.effect.startswith("In time") for one in found), found


def test_depth_becomes_time_and_comes_back() -> None:
    velocity = {"above Top": 2000.0, "Top/Base": LINEAR, "below Base": 3500.0}
    horizons = {name: grid(plane(z), units="m", positive="up")
                for name, z in (("Top", -2000.0), ("Base", -2150.0))}  # fmt: skip
    given = gs.Scene(horizons, {"F1": fault()}, BOX, tear=True, velocity=velocity)
    time = given.in_time("one-way")
    assert sorted(time.units) == sorted(given.units)
    assert time.surface("Top").bounds[4:] == pytest.approx(
        [0.5 * z for z in given.surface("Top").bounds[4:]], rel=1e-3
    )
    back = time.replace(velocity=velocity, box=BOX)
    assert back.time is None
    assert sorted(back.units) == sorted(given.units)
    for name in ("Top", "Base"):
        difference = back.sheets[name].lattice.elevation - given.sheets[name].lattice.elevation
        assert np.median(np.abs(difference)) < 1e-6


TOP = {"Top": grid(plane(-2000.0), units="ms", positive="up")}


@pytest.mark.parametrize(
    ("horizons", "words", "says"),
    [
        (TOP, {}, r'is in time \(ms\).*time="two-way"'),
        (TOP, {"time": "twt"}, 'Write time="two-way"'),
        ({"Top": grid(plane(-2000.0), units="m")}, {"time": "two-way"}, "the scene is in time"),
        (TOP, {"time": "two-way", "velocity": {"Top": 2000.0}}, "has nothing for"),
        (
            TOP,
            {"time": "two-way", "velocity": {"Topp": 1.0}},
            "neither a horizon nor a zone between",
        ),
        (TOP, {"time": "two-way", "velocity": {"elsewhere": -5.0}}, "above 0"),
        (TOP, {"time": "two-way", "velocity": {"elsewhere": 2.5}}, "Multiply km/s by 1000"),
        (TOP, {"time": "two-way", "velocity": {"v0": 1800.0}}, "v0 .* and k"),
        (TOP, {"time": "two-way", "tolerance": 1.0}, "in metres"),
        (TOP, {"time": "two-way", "contacts": {"OWC": -2100.0}}, "contacts need depth"),
        ({"Top": fault()}, {"time": "two-way", "length_unit": "s"}, "minus milliseconds"),
    ],
)
def test_what_cannot_be_meant_is_refused(
    horizons: dict[str, Any], words: dict[str, Any], says: str
) -> None:
    with pytest.raises(InputError, match=says):
        _ = gs.Scene(horizons, **words).units


def test_average_velocities_to_horizons_are_met_and_zones_follow() -> None:
    slow = grid(2400.0 + 0.05 * np.add.outer(Y, X), units="m/s")
    velocity = {"Top": slow, "Base": 2600.0, "below Base": 3500.0}
    scene = in_time(2000.0, {"Top": -2000.0, "Base": -2300.0}, velocity=velocity, box=None)
    time = scene.in_time()
    for name, average in (("Top", None), ("Base", 2600.0)):
        found = time.sheets[name].surface.vertices
        found = found[(np.abs(found[:, 0] - 1800.0) > 300.0)]
        here = 2400.0 + 0.05 * (found[:, 0] + found[:, 1]) if average is None else average
        np.testing.assert_allclose(
            scene.to_depth(found)[:, 2], found[:, 2] * here / 2000.0, rtol=0, atol=1e-6
        )
    # half the way in time is half the way in depth, between both horizons
    top, base = np.array([[800.0, 1000.0, -2060.0], [800.0, 1000.0, -2360.0]])
    middle = scene.to_depth([top, 0.5 * (top + base), base])[:, 2]
    assert middle[1] == pytest.approx(0.5 * (middle[0] + middle[2]), abs=1e-6)
    assert sorted(scene.units) == sorted(time.units)
    with pytest.raises(InputError, match="also between averages"):
        _ = scene.replace(velocity=velocity | {"Base": 1000.0}).units


def test_a_constant_average_is_the_interval_velocity(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(f"{__name__}.DROP", -DROP)  # a reverse fault, which repeats Top
    average, interval = (
        in_time(2000.0, {"Top": -2000.0}, velocity={name: 2100.0, "elsewhere": LINEAR}, box=None)
        for name in ("Top", "above Top")
    )
    found = average.in_time().sheets["Top"].surface.vertices
    np.testing.assert_allclose(average.to_depth(found), interval.to_depth(found), atol=1e-6)


def test_velocities_vary_in_an_ensemble_and_stay_in_its_box() -> None:
    levels = {"Top": -2000.0, "Base": -2150.0}
    scene = in_time(3000.0, levels, velocity={"above Top": 3000.0, "elsewhere": 3100.0}, box=None)
    by = gs.ensemble.VelocityFactor("elsewhere", gs.ensemble.Discrete([1.0, 1.1], [1, 1]))
    rock = {"net_to_gross": gs.ensemble.Uniform(0.5, 0.9)}
    found = gs.run_ensemble(scene, 3, uncertain=[by], seed=4, workers=1, volumetrics=rock)
    base = gs.ensemble.realise(scene, None, uncertain=[by], seed=4)
    for row in range(3):
        factor = found.data.drawn.sel(parameter="velocity elsewhere").values[row]
        velocity = {"above Top": 3000.0, "elsewhere": 3100.0 * factor}
        one = scene.replace(velocity=velocity, box=base.box, aoi=base.aoi)
        some = found.data.zone == "Top/Base"
        volume = found.data.bulk.sel(realisation=row, unit=some.values).sum().item()
        assert volume == pytest.approx(one.volumes.sum().item(), rel=1e-9)


def test_checkshots_of_wells_give_velocities_and_state_their_misfit() -> None:
    levels = {"Top": -2000.0, "Base": -2120.0}

    def shots(bend: float) -> dict[str, list[Any]]:
        """Wells at both sides of the fault: 2200 and 2230 m/s to Top, then 3000 and 3040 m/s."""
        rows: list[tuple[Any, ...]] = []
        for well, x, top, above, below in (
            ("W-1", 600.0, 2070.0, 2200.0, 3000.0), ("W-2", 3400.0, 2010.0, 2230.0, 3040.0),
        ):  # fmt: skip
            for t in (500.0, 1000.0, 1500.0, top, top + 50.0, top + 110.0):
                way = above * min(t, top) / 2000.0 + below * max(t - top, 0.0) / 2000.0
                rows.append((well, x, 1000.0, way + bend * np.sin(np.pi * t / top), t))
        names = ("well", "easting", "northing", "depth", "time")
        return {name: [row[k] for row in rows] for k, name in enumerate(names)}

    velocity = {"wells": shots(0.0), "below Base": 3500.0}
    scene = in_time(2000.0, levels, velocity=velocity, box=None)
    well = shots(0.0)
    places = np.column_stack([well["easting"], well["northing"], -np.array(well["time"])])
    np.testing.assert_allclose(
        scene.to_depth(places)[:, 2], -np.array(well["depth"]), rtol=0, atol=1e-6
    )
    bent = scene.replace(velocity=velocity | {"wells": shots(7.0)})
    with pytest.warns(gs.errors.GeosurfWarning, match="misses these by up to 7 m"):
        _ = bent.units
    assert scene.warnings == ()
    wrong = well | {"time": [1.0] * 12}
    with pytest.raises(InputError, match="rise together"):
        _ = scene.replace(velocity=velocity | {"wells": wrong}).units


def test_tops_give_velocities_which_horizons_meet() -> None:
    """Depths of tops over times of horizons; equal to the same numbers as checkshots."""
    levels = {"Top": -2000.0, "Base": -2120.0}
    tops = {
        "well": ["A", "A", "B", "B", "C"], "horizon": ["Top", "Base", "Top", "Base", "Top"],
        "easting": [600.0, 600.0, 3400.0, 3400.0, 9e4], "northing": [1000.0] * 5,
        "elevation": [-2310.0, -2500.0, -2190.0, -2350.0, -2000.0],
    }  # fmt: skip
    more = {"velocity": {"wells": "tops", "below Base": 3500.0}, "box": None}
    scene = in_time(2000.0, levels, tops=tops, **more)
    with pytest.warns(gs.errors.GeosurfWarning, match="1 well top without a velocity: 'Top'"):
        off = scene.misfit().misfit.values
    np.testing.assert_allclose(off, [0.0] * 4 + [np.nan], atol=1e-6)

    # the same as checkshots, whose times are those of the horizons there
    first = {key: value[:4] for key, value in tops.items()}
    names = ("easting", "northing", "elevation")
    at_tops = np.column_stack([first[name] for name in names])
    depth, time = -at_tops[:, 2], -scene.to_time(at_tops)[:, 2]
    shots = {key: first[key] for key in ("well", *names[:2])} | {"depth": depth, "time": time}
    other = scene.replace(velocity={"wells": shots, "below Base": 3500.0}, tops=None)
    np.testing.assert_allclose(other.volumes.values, scene.volumes.values, rtol=1e-9)

    # other tops, other velocities: nothing of the first ones is kept
    lower = {**first, "elevation": [up - 30.0 for up in first["elevation"]]}
    changed = scene.replace(tops=lower)
    np.testing.assert_allclose(changed.misfit().misfit.values, np.zeros(4), atol=1e-6)
    signs = {**first, "elevation": [-up for up in first["elevation"]]}
    for tops, says in (
        (signs, "positive up"),
        ({k: v[::2] for k, v in signs.items()}, "time zero is"),
    ):
        with pytest.raises(InputError, match=says):
            _ = scene.replace(tops=tops).units
    with pytest.raises(InputError, match='"wells" = "tops" needs well tops'):
        _ = scene.replace(tops=None).units


def test_tops_and_contacts_in_time_become_depth_and_ties_meet_tops() -> None:
    levels = {"Top": -2000.0, "Base": -2150.0}
    velocity = {"above Top": 2200.0, "Top/Base": 3000.0, "below Base": 3500.0}
    tops = {
        "well": ["A", "A", "B"], "horizon": ["Top", "Base", "Base"],
        "easting": [900.0, 900.0, 3000.0], "northing": [1000.0, 1000.0, 800.0],
        "elevation": [-2270.0, -2500.0, -2540.0],
    }  # fmt: skip
    words = {"velocity": velocity, "box": None}
    tied = in_time(2000.0, levels, tops=tops, tie={"range": 800.0, "tolerance": 1e-6}, **words)
    assert np.abs(tied.misfit().misfit).max() < 1e-6
    times_of = {**tops, "elevation": [-2055.0, -2205.0, -2180.0]}  # where these horizons are
    given = xr.Dataset({key: ("top", value) for key, value in times_of.items()})
    given.elevation.attrs["units"] = "ms"
    flat = grid(np.full((len(Y), len(X)), 2100.0), units="ms", positive="down")
    scene = in_time(2000.0, levels, tops=given, contacts={"OWC": flat}, **words)
    assert np.abs(scene.misfit().misfit).max() < 1e-6
    places = np.column_stack([X[5:20], np.full(15, 500.0), np.full(15, -2100.0)])
    here = scene.to_depth(places)[:, 2]
    owc = scene.patches.surface("OWC").vertices
    for place, z in zip(places, here, strict=True):
        at = np.abs(owc[:, :2] - place[:2]).sum(axis=1).argmin()
        assert owc[at, 2] == pytest.approx(z, abs=1e-6)


@pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
def test_a_smeared_field_has_the_throw_that_it_has_without_a_detour_through_time() -> None:
    """What lies in the shadow of F2 says nothing of its smear: trims are those of the time."""
    world = gs.synthetic.faulted_reservoir(n=41)
    horizons = {name: world.horizons[name] for name in ("Top", "Base")}
    velocity = {"above Top": LINEAR, "Top/Base": 2900.0, "below Base": 3200.0}
    field = gs.Scene(horizons, world.faults, tear=True, velocity=velocity)
    time = field.in_time("two-way").replace(velocity=velocity)

    picked = {}
    for name, grid in horizons.items():
        x, y = np.meshgrid(grid.easting, grid.northing)
        places = np.stack([x, y, grid.values], axis=-1).reshape(-1, 3)
        attrs = {"units": "ms", "positive": "down"}
        data = -time.to_time(places)[:, 2].reshape(grid.shape)
        picked[name] = grid.copy(data=data).assign_attrs(attrs)
    faults = {name: field.in_time("two-way").surface(name) for name in world.faults}
    back = gs.Scene(picked, faults, tear=True, time="two-way", velocity=velocity)
    with pytest.warns(gs.GeosurfWarning, match="Outside of the horizons: 1 place of 1"):
        time.to_time([[9999.0, 0.0, -2000.0]])
    refused(InputError, r"time 9 ms\) lies above", time.to_depth, [[2000.0, 2000.0, 9.0]])
    in_time = [scene.in_time("two-way").throw("Base", "F2").throw for scene in (field, back)]
    assert abs(float(in_time[0].max() - in_time[1].max())) < 1.0
    for name in horizons:
        for fault in world.faults:
            throws = [scene.throw(name, fault).throw for scene in (field, back)]
            assert abs(float(abs(throws[0]).max() - abs(throws[1]).max())) < 1.0
