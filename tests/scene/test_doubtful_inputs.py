"""Doubtful inputs: marks of absent values, spikes, wrong order, a fault given twice."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import HorizonError, silenced
from geosurf.model import Lattice, TriSurface
from geosurf.triangulate.spikes import check_spikes
from tests.grids import gridded
from tests.scene.conftest import level, upright
from tests.strategies import BOX

CELL = 50.0


def relief(n=40, m=30):
    return -2000 + 30 * np.sin(np.arange(n) / 9)[:, None] + 20 * np.cos(np.arange(m) / 7)[None]


def horizon(z, turn=0.0):
    """A gridded horizon, turned by an angle."""
    x, y = np.arange(z.shape[1]) * CELL, np.arange(z.shape[0]) * CELL
    if turn:
        x, y = np.meshgrid(x, y)
        x, y = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
    return TriSurface("Top", "horizon", lattice=Lattice(x, y, z))


def mesh(z):
    """The same as a mesh, with its nodes shuffled."""
    grid = horizon(z)
    order = np.random.default_rng(0).permutation(len(grid.vertices))
    back = np.argsort(order)
    return TriSurface("Top", "horizon", grid.vertices[order], back[grid.triangles])


WHERE = {
    "a node": np.s_[20, 20],
    "a corner": np.s_[0, 0],
    "along a rim": np.s_[0, 3:9],
    "a column": np.s_[:, 20],
    "a row": np.s_[20, :],
    "a block": np.s_[10:20, 10:20],
    "half": np.s_[20:, :],
    "nearly all": np.s_[5:, :],
}
SHAPES = {"grid": horizon, "turned": lambda z: horizon(z, 0.5), "mesh": mesh}


@pytest.mark.parametrize("where", WHERE)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("mark", [-999.0, -999.25, 9999.0, -9999.0, 1e30, float(np.float32(1e30))])
def test_marks_are_refused_wherever_they_are(where, shape, mark):
    z = relief()
    z[WHERE[where]] = mark
    n = np.count_nonzero(z == mark)
    with pytest.raises(HorizonError, match=rf"'Top': {n} nodes? ha.* no-data value.*grid\.where"):
        check_spikes(SHAPES[shape](z))


@pytest.mark.parametrize("where", ["a node", "a corner", "along a rim", "a column"])
@pytest.mark.parametrize("shape", SHAPES)
def test_spikes_are_warned_of(where, shape):
    z = relief()
    z[WHERE[where]] += 700.0
    n = np.count_nonzero(z > -1800)
    with pytest.warns(
        gs.GeosurfWarning, match=rf"jumps by 7\d\d.* and back, .*; {n} nodes? stan"
    ) as issued:
        check_spikes(SHAPES[shape](z))
    (found,) = [one.message for one in issued]
    assert found.kind == "spike"
    assert found.place[2] > -1800


COLUMN, ROW = np.arange(30)[None], np.arange(40)[:, None]
NOISE = np.random.default_rng(3)
RELIEFS = {
    "fault": -400.0 * (COLUMN >= 15),
    "horst": 400.0 * (abs(ROW - 14.5) < 5) * (abs(COLUMN - 14.5) < 5),
    "narrow horst": 400.0 * (abs(COLUMN - 15) < 2),
    "stairs": -400.0 * (COLUMN // 6),
    "smeared fault": -400.0 * np.clip((COLUMN - 14) / 3, 0, 1),
    "rough": NOISE.normal(0, 80, (40, 30)),
    "rough, with tails": NOISE.standard_t(3, (40, 30)) * 30,
}


@pytest.mark.parametrize("kind", RELIEFS)
def test_relief_passes(kind):
    for make in SHAPES.values():
        check_spikes(make(relief() + RELIEFS[kind]))


def test_a_scene_refuses_and_warns():
    world = gs.synthetic.graben(n=21)
    top = world.horizons["Top"]
    bad = gs.Scene(
        {**world.horizons, "Top": top.where(top.easting != 2000, -999)}, world.faults, world.box
    )
    with pytest.raises(HorizonError, match="-999"):
        _ = bad.warnings
    odd = top.where((top.easting != 2000) | (top.northing != 2000), -1400.5)
    scene = gs.Scene({**world.horizons, "Top": odd}, world.faults, world.box)
    with pytest.warns(gs.GeosurfWarning, match="'Top' jumps by"):
        (found,) = scene.warnings
    assert (found.kind, found.subject) == ("spike", "Top")
    assert scene.replace(box=(0, 5000, 0, 3000, -2600, -1300)).warnings == (found,)


# ---- Horizons in the wrong order are named, with their share of the area and the volume.
FIELD = (0.0, 900.0, 0.0, 900.0, -3000.0, -1000.0)


def plane(level, slope=0.0):
    axis = np.arange(0.0, 901.0, 100.0)
    return gridded(level + slope * (axis[None] + 0.0 * axis[:, None]), axis)


@pytest.mark.filterwarnings("ignore:Horizon 'H2'")
@pytest.mark.parametrize("n", [2, 3])
def test_horizons_turned_over_are_named_pair_by_pair(n):
    horizons = {f"H{k}": plane(-2000.0 + 100 * k) for k in range(n)}
    scene = gs.Scene(horizons, {}, FIELD)
    expected = r"'H1' lies above the younger horizon 'H0' everywhere: 81 million m³"
    with pytest.warns(gs.GeosurfWarning, match=expected):
        _ = scene.units
    assert {w.kind for w in scene.warnings} == {"order"}
    assert scene.replace(horizons=horizons).warnings == ()  # nothing is built yet
    right = gs.Scene(dict(reversed(horizons.items())), {}, FIELD)
    assert len(right.units) == n + 1
    assert right.warnings == ()
    ruled = scene.replace(column={"H0": "erosional", "H1": "erosional"})
    assert len(ruled.units) == 2
    assert ruled.warnings == ()


def test_a_horizon_that_is_given_twice_is_named_by_its_empty_zone():
    scene = gs.Scene({"A": plane(-1800.0), "B": plane(-1800.0), "C": plane(-2000.0)}, {}, FIELD)
    with pytest.warns(gs.GeosurfWarning, match="Zone 'A/B' has no rock: its horizons coincide"):
        assert list(scene.units.included()) == ["B/C"]
    (found,) = scene.warnings
    assert (found.kind, found.subject) == ("order", "A/B")


@pytest.mark.parametrize(
    ("below", "words"), [(0.0, "everywhere"), (36.0, "on 8[0-2] %"), (85.0, "on 5[34] %")]
)
def test_the_share_is_that_of_the_area(below, words):
    """One dips by a fifth, and crosses the other where it has risen so far."""
    scene = gs.Scene({"A": plane(-2000.0), "B": plane(-2000.0 - below, slope=0.2)}, {}, FIELD)
    with pytest.warns(gs.GeosurfWarning, match=rf"'B' lies above .* 'A' {words}") as issued:
        _ = scene.units
    assert len(issued) == 1


def test_horizons_that_merely_cross_are_listed_only():
    scene = gs.Scene({"A": plane(-2000.0), "B": plane(-2600.0, slope=1.0)}, {}, FIELD)
    assert len(scene.units.report["clipped"]) == 1
    assert scene.warnings == ()


# ---- A fault given twice is warned of, whatever the order of its triangles; others are not.
def scene_with(second):
    one = upright(2.0, "F1")
    return gs.Scene({"Top": level(0.5)}, {"F1": one, "F2": second(one)}, BOX)


def again(fault, shift=0.0):
    order = np.random.default_rng(1).permutation(fault.n_triangle)
    x = fault.vertices[::-1] + np.array([shift, 0, 0])
    faces = (len(x) - 1 - fault.triangles)[order][:, [1, 2, 0]]
    return gs.TriSurface("F2", "fault", x, faces)


def test_the_same_triangles_in_another_order_are_warned_of():
    scene = scene_with(again)
    with pytest.warns(gs.GeosurfWarning, match="'F1' and 'F2' have the same triangles"):
        len(scene.units)
    assert [one.kind for one in scene.warnings] == ["same fault"]


def test_a_fault_a_little_beside_is_another():
    scene = scene_with(lambda one: again(one, np.spacing(2.0)))
    assert not [one for one in scene.warnings if one.kind == "same fault"]


# ---- Feet taken for metres, and depths for elevations, are warned of; deep horizons, or those
# with much relief, are not.
def dome_at(level, height, unit=1.0, shape=np.cos):
    x = np.linspace(-1.5, 1.5, 41)
    return horizon((level + height * shape(x) * shape(1.2 * x[:, None])) / unit)


@pytest.mark.parametrize(
    ("top", "base", "warned"),
    [
        (dome_at(-1500.0, 60.0), dome_at(-1600.0, 70.0, 0.3048), [("feet", "B")]),
        (dome_at(-1500.0, 60.0), dome_at(-1600.0, 70.0), []),
        (dome_at(-1500.0, 60.0), dome_at(-5000.0, 200.0, shape=np.sin), []),  # with another shape
        (dome_at(-1500.0, 60.0), dome_at(-1600.0, 200.0), []),  # much relief: growth over a dome
        (dome_at(1500.0, -60.0), dome_at(-1600.0, 70.0), [("sign", "A")]),
        (dome_at(1500.0, 60.0), dome_at(-1600.0, 70.0), []),  # on both sides of the sea level
    ],
)
def test_feet_taken_for_metres_and_depths_for_elevations_are_warned_of(top, base, warned):
    scene = gs.Scene({"A": top, "B": base}, {})
    with silenced():
        len(scene.units)
    found = [(one.kind, one.subject) for one in scene.warnings if one.kind in ("feet", "sign")]
    assert found == warned
