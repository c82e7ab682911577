"""Marks of absent values are refused, other spikes warned of, and relief is neither."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import HorizonError
from geosurf.kernels.lattices.lattice_corners import steepest_step
from geosurf.model import Lattice, TriSurface
from geosurf.triangulate.spikes import MARKS, check_spikes, mark_of

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


@pytest.mark.parametrize("unit", [1.0, 0.3048, 1200 / 3937])
def test_marks_are_known_in_other_units_and_as_depths(unit):
    for mark in MARKS:
        assert mark_of(mark * unit) == mark_of(-mark * unit) == mark
    assert mark_of(-2000.0) is None


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


def fault(z):
    z[:, 15:] -= 400


def horst(z):
    z[10:20, 10:20] += 400


def narrow_horst(z):
    z[:, 14:17] += 400


def stairs(z):
    z -= 400 * (np.arange(30) // 6)[None]


def smeared(z):
    z -= 400 * np.clip((np.arange(30) - 14) / 3, 0, 1)[None]


def rough(z):
    z += np.random.default_rng(3).normal(0, 80, z.shape)


def rough_tails(z):
    z += np.random.default_rng(3).standard_t(3, z.shape) * 30


@pytest.mark.parametrize(
    "change", [fault, horst, narrow_horst, stairs, smeared, rough, rough_tails]
)
def test_relief_passes(change):
    z = relief()
    change(z)
    for make in SHAPES.values():
        check_spikes(make(z))


@pytest.mark.parametrize("kind", ["graben", "waves", "tilted_planes"])
def test_worlds_pass(kind):
    for n in (5, 9, 33):
        world = getattr(gs.synthetic, kind)(n=n)
        for name, grid in world.horizons.items():
            check_spikes(gs.triangulate_horizon(grid, name=name))


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
    twin = scene.replace(box=(0, 5000, 0, 3000, -2600, -1300))
    assert twin.warnings == (found,)


@pytest.mark.parametrize("seed", range(30))
def test_the_steepest_step_is_that_of_all_differences(seed):
    rng = np.random.default_rng(seed)
    z = rng.integers(-9, 9, rng.integers(1, 6, 2)) * 1.5
    z[rng.random(z.shape) < 0.2] = np.nan
    if seed % 3 == 0:
        z = np.broadcast_to(z[:1], z.shape)
    lattice = Lattice(np.arange(z.shape[1]), np.arange(z.shape[0]), z)
    every = [np.abs(np.diff(z, axis=axis)).ravel() for axis in (0, 1)]
    expected = np.nanmax(np.append(np.concatenate(every), 0.0))
    assert steepest_step(lattice.coordinates[2], lattice.places) == expected
    assert lattice.survey.relief >= expected
