"""Rock that throw moves: particles one by one come to the bits that rounds of all come to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError
from geosurf.sheets.faults.fault_profile import section_of
from geosurf.sheets.faults.slip import slips_of
from geosurf.sheets.lattice.data import picks_of
from geosurf.sheets.throw import displacement
from geosurf.sheets.throw.displacement import (
    SPARE,
    Branches,
    InWalls,
    moved_places,
    movement_of,
    sheet_heights,
)

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


def in_rounds(slips):
    """The same throws as functions, which have no kernel of their own."""

    def amount(value):
        return lambda s, z, xy: np.full(len(s), value)

    return [replace(slip, amount=amount(slip.amount.value)) for slip in slips]


def both(movement, parts, xy):
    slower = in_rounds(movement.slips)
    cell = movement.frame.cell
    other = parts if isinstance(parts, np.ndarray) else replace(parts, slips=slower)
    return (
        sheet_heights(movement.before, movement.slips, xy, parts, cell),
        sheet_heights(movement.before, slower, xy, other, cell),
    )


@pytest.mark.parametrize("reach", [None, 700.0])
@pytest.mark.parametrize("branches", BRANCHES)
def test_particles_one_by_one_come_to_the_same_bits(branches, reach):
    movement = moved(reach, (55.0, -30.0))
    xy = np.random.default_rng(4).uniform(-300.0, 4300.0, (600, 2))
    one, other = both(movement, movement.gradual_parts(0.3, branches), xy)
    assert [part.tobytes() for part in one] == [part.tobytes() for part in other]
    walls = np.random.default_rng(5).integers(0, 2, (2, len(xy))).astype(float)
    one, other = both(movement, movement.parts(branches, walls), xy)
    assert [part.tobytes() for part in one] == [part.tobytes() for part in other]
    assert len(np.unique(one[0] - movement.before.at(xy))) > 300  # it has moved


def test_lines_that_turn_take_part():
    movement = moved(None, (55.0, -30.0))
    assert movement.slips[0].lines is not None


def test_beds_that_fold_are_refused_at_the_same_place(monkeypatch):
    monkeypatch.setattr(displacement, "ROUNDS", 3)
    movement = moved(500.0, (400.0, 300.0))
    parts = movement.gradual_parts(0.5, BRANCHES[0])
    found = []
    for slips in (movement.slips, in_rounds(movement.slips)):
        with pytest.raises(GeometryError, match="throw changes so quickly") as error:
            sheet_heights(movement.before, slips, movement.xy, replace(parts, slips=slips), 100.0)
        found.append(str(error.value))
    assert found[0] == found[1]


@pytest.mark.parametrize("reach", [None, 700.0])
@pytest.mark.parametrize("branches", BRANCHES)
def test_the_drape_shows_where_particles_in_their_walls_come_from(branches, reach):
    movement = moved(reach, (55.0, -30.0))
    xy, cell = movement.xy, movement.frame.cell
    known = InWalls.unknown(2, len(xy))
    parts = movement.gradual_parts(0.3, branches)
    one = sheet_heights(movement.before, movement.slips, xy, parts, cell, known)
    other = sheet_heights(movement.before, movement.slips, xy, parts, cell)

    # far from the faults a particle stops one round earlier, with what its walls give
    apart = np.min([np.abs(slip.section.distance(xy, other[0])) for slip in movement.slips], axis=0)
    early = (one[0] != other[0]) | (one[1] != other[1]).any(axis=1)
    assert early.any()
    assert apart[early].min() > SPARE * cell
    assert one[0][early].tobytes() == known.elevation[early].tobytes()
    np.testing.assert_allclose(one[0], other[0], rtol=0.0, atol=1e-7)

    # most are in one wall of each fault, of all four kinds; near the faults none is
    rows = np.flatnonzero(~np.isnan(known.walls).any(axis=0))
    assert 0.3 * len(xy) < len(rows) < len(xy)
    assert len(np.unique(known.walls[:, rows], axis=1).T) >= 3
    given = movement.parts(branches, known.walls[:, rows])
    z, was = sheet_heights(movement.before, movement.slips, xy[rows], given, cell)
    assert z.tobytes() == known.elevation[rows].tobytes()
    assert was.tobytes() == known.was[rows].tobytes()
    now = moved_places(movement.slips, xy[rows], movement.before.at(xy[rows]), given)
    assert now.tobytes() == known.moved[rows].tobytes()
