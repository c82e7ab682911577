"""Two faults that cross closer to a horizon than their throws leave wedges without it.

Everything is planes that strike north, so that the truth is areas of a section: four wedges, each
with the horizon at its own level, or without it.
"""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import GeometryError, OpenUnitError

LEVEL = -1680
WEST, EAST, SOUTH, NORTH, BOTTOM, TOP = BOX = (0, 3000, 0, 400, -2100, -1400)
COTANGENTS = {"F1": Fraction(3, 5), "F2": Fraction(-3, 5)}
EASTING = {"F1": 1500, "F2": 1503}  # at the stated elevation of the crossing


def fault(name, level):
    """A plane that strikes north, at EASTING at a level; F1 dips east, F2 west."""
    corners = [
        (EASTING[name] + float((level - z) * COTANGENTS[name]), y, z)
        for y, z in ((-900, -2600), (1300, -2600), (1300, -1000), (-900, -1000))
    ]
    return gs.TriSurface(name, "fault", corners, [[0, 1, 2], [0, 2, 3]])


def sheet(depth, throws, hanging_wall=0.5, cell=40.0, first=-200.0, order=("F1", "F2"), up=0):
    """A horizon at LEVEL and some metres up, thrown by faults that cross some way below LEVEL."""
    x, y = np.arange(first, 3201.0 + cell, cell), np.arange(-200.0, 601.0, 100.0)
    flat = xr.DataArray(
        np.full((len(y), len(x)), float(LEVEL + up)),
        {"northing": y, "easting": x}, ("northing", "easting"),
        attrs={"positive": "up", "units": "m"},
    )  # fmt: skip
    faults = {name: fault(name, LEVEL - depth) for name in ("F1", "F2")}
    return gs.throw_horizon(
        flat, faults, {name: throws[name] for name in order}, name="Top", hanging_wall=hanging_wall
    )


def scene(*torn):
    names = ("Top", "Middle", "Base")
    horizons = dict(zip(names, torn, strict=False))
    return gs.Scene(horizons, {f.name: f for f in torn[0].faults}, BOX)


def areas(depth, throws, hanging_wall=0.5, ups=(0,)):
    """Areas of the section between horizons, by wedge [m2]; those that are not empty."""
    found = []
    for walls in product((1, 0), repeat=2):
        wedge = [(WEST, BOTTOM), (EAST, BOTTOM), (EAST, TOP), (WEST, TOP)]
        level = Fraction(LEVEL)
        for name, wall in zip(("F1", "F2"), walls, strict=True):
            # the hanging wall lies above its fault: a x + b z >= c
            turn = (1 if COTANGENTS[name] > 0 else -1) * (1 if wall else -1)
            c = EASTING[name] + (LEVEL - depth) * COTANGENTS[name]
            wedge = clipped(wedge, turn, turn * COTANGENTS[name], turn * c)
            level -= Fraction(throws[name]) * (Fraction(hanging_wall) - (0 if wall else 1))
        for up in ups:  # from the top down: what is above each horizon, then the remainder
            found.append(area(clipped(wedge, 0, 1, level + up)))
            wedge = clipped(wedge, 0, -1, -level - up)
        found.append(area(wedge))
    return sorted(float(one) for one in found if one)


def clipped(polygon, a, b, c):
    """The part of a convex polygon with a x + b z >= c, exactly."""
    out = []
    for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        u, v = (a * x + b * z - c for x, z in (p, q))
        out += [p] if u >= 0 else []
        if u * v < 0:
            out.append(tuple(s + Fraction(u, u - v) * (t - s) for s, t in zip(p, q, strict=True)))
    return out


def area(polygon):
    turned = polygon[1:] + polygon[:1]
    return abs(sum(a * d - b * c for (a, b), (c, d) in zip(polygon, turned, strict=True))) / 2


@pytest.mark.parametrize("depth", [-40, 20, 40, 60, 90])
@pytest.mark.parametrize(
    ("throws", "hanging_wall"),
    [({"F1": 60, "F2": 40}, 0.5), ({"F1": 40, "F2": 60}, 1.0), ({"F1": 40, "F2": 40}, 0.0)],
)
def test_wedges_without_a_horizon_are_sealed_with_their_true_volumes(depth, throws, hanging_wall):
    """Also where the crossing is above the horizon, and where it ends on one fault only."""
    order = ("F1", "F2") if depth % 40 else ("F2", "F1")
    model = scene(sheet(depth, throws, hanging_wall, order=order))
    found = sorted(unit.volume / (NORTH - SOUTH) for unit in model.units.values())
    np.testing.assert_allclose(found, areas(depth, throws, hanging_wall), rtol=1e-8)
    assert model.check().ok


def test_three_horizons_of_which_wedges_have_one_or_none():
    """Above the crossing Middle and Base are missing, below it all three are."""
    throws, ups = {"F1": 60, "F2": 40}, (80, 0, -80)
    model = scene(*(sheet(40, throws, up=up) for up in ups))
    found = sorted(unit.volume / (NORTH - SOUTH) for unit in model.units.values())
    assert len(found) == 2 + 4 + 4 + 1
    np.testing.assert_allclose(found, areas(40, throws, ups=ups), rtol=1e-8)
    assert model.check().ok


def test_a_wedge_narrower_than_the_cells_is_refused_and_finer_cells_build_it():
    """The wedge is 21 m wide where it has the horizon, and no node is there."""
    coarse = {"depth": 65, "throws": {"F1": 60, "F2": 40}}
    with pytest.raises(GeometryError, match=r"21 m wide between faults 'F\d' and 'F\d'") as error:
        sheet(**coarse, cell=100.0, first=-170.0)
    cell = float(re.search(r"on cells of ([\d.]+) m", str(error.value))[1])
    fine = scene(sheet(**coarse, cell=cell, first=-170.0))
    found = sorted(unit.volume / (NORTH - SOUTH) for unit in fine.units.values())
    np.testing.assert_allclose(found, areas(**coarse), rtol=1e-8)


def test_a_horizon_that_is_missing_where_it_should_be_is_refused():
    """A wedge of 27 m has the horizon; without its piece, corners lie on both sides."""
    torn = sheet(70, {"F1": 60, "F2": 40})
    mesh = torn.surface
    inside = [(mesh.vertex_data[f"wall of {f}"][mesh.triangles] == 1).all(axis=1) for f in EASTING]
    holed = gs.TriSurface(
        "Top", "horizon", mesh.vertices, mesh.triangles[~(inside[0] & inside[1])],
        vertex_data=mesh.vertex_data,
    )  # fmt: skip
    holed.sectors = mesh.sectors
    assert len(scene(torn).units) == 7
    with pytest.raises(OpenUnitError, match="piece between them is narrower than its cells"):
        scene(replace(torn, mesh=holed)).units  # noqa: B018
