"""Rock that throw moves: it comes to where it was looked for, or beds fold over."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError
from geosurf.sheets.faults.fault_profile import section_of
from geosurf.sheets.faults.slip import slips_of
from geosurf.sheets.lattice.data import picks_of
from geosurf.sheets.throw import displacement
from geosurf.sheets.throw.displacement import Branches, movement_of, sheet_heights

BRANCHES = [
    Branches(({}, {}), (True, True)),
    Branches(({}, {0: 1.0}), (True, True)),
    Branches(({1: 0.0}, {}), (True, False)),
]


def curved_fault():
    """A fault that dips east and turns along strike, so that its dip lines turn, too."""
    y, z = np.meshgrid(np.linspace(-500.0, 4500.0, 26), np.linspace(-3000.0, -1000.0, 9))
    x = 1200.0 + 250.0 * np.sin(y / 900.0) - 0.6 * (z + 2000.0)
    points = np.column_stack([part.ravel() for part in (x, y, z)])
    row, col = np.divmod(np.arange(8 * 25), 25)
    a = row * 26 + col
    cells = np.stack([a, a + 1, a + 27, a, a + 27, a + 26], axis=1).reshape(-1, 3)
    surface = gs.TriSurface("C", "fault", points, cells)
    return gs.triangulate_fault(surface, name="C")


def moved(reach, throws):
    """A horizon with a curved fault and a plane one, moved by some throws."""
    world = gs.synthetic.graben(n=31)
    picks = picks_of(world.horizons["Top"], "Top", None, None)
    faults = [curved_fault(), gs.triangulate_fault(world.faults["F2"], name="F2")]
    corner, cell = picks.frame.corner, picks.frame.cell
    sections = {fault.name: section_of(fault, corner, 0.5 * cell, None) for fault in faults}
    given = dict(zip(sections, throws, strict=True))
    slips = slips_of(given, sections, corner, reach, {"C": 0.7})
    low, high = float(picks.z.min()), float(picks.z.max())
    sizes = [slip.extremes(low, high) for slip in slips]
    return movement_of(picks, faults, slips, [True, True], sizes)


@pytest.mark.parametrize("reach", [None, 700.0])
@pytest.mark.parametrize("branches", BRANCHES)
def test_law_rock_moves_to_the_place_that_it_was_found_for(branches, reach):
    movement = moved(reach, (55.0, -30.0))
    assert movement.slips[0].lines is not None  # dip lines turn
    before, cell = movement.before, movement.frame.cell
    xy = np.random.default_rng(4).uniform(-300.0, 4300.0, (600, 2))
    gradual = movement.gradual_parts(0.3, branches)
    walls = np.random.default_rng(5).integers(0, 2, (2, len(xy))).astype(float)
    for parts in (gradual, movement.parts(branches, walls)):
        z, was = sheet_heights(before, movement.slips, xy, parts, cell)
        now, height = was, before.at(was)
        share = parts if isinstance(parts, np.ndarray) else parts(xy, z)
        for slip, part in zip(movement.slips[::-1], share[::-1], strict=True):
            now, height = slip.move(now, height, part)
        np.testing.assert_allclose(now, xy, rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(height, z, rtol=0.0, atol=1e-6)
        assert len(np.unique(z - before.at(xy))) > 200  # it has moved


def test_beds_that_fold_are_refused(monkeypatch):
    monkeypatch.setattr(displacement, "ROUNDS", 3)
    movement = moved(500.0, (400.0, 300.0))
    parts = movement.gradual_parts(0.5, BRANCHES[0])
    with pytest.raises(GeometryError, match="throw changes so quickly"):
        sheet_heights(movement.before, movement.slips, movement.xy, parts, 100.0)
