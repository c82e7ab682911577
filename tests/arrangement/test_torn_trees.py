"""Torn sheets that know their lattice: contacts, rims and equal points are those of plain lists."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.arrangement.search import find_contacts
from geosurf.model.surfaces import torn_sheet
from geosurf.triangulate.outline import off_the_rims
from geosurf.warning import silenced

ARRAYS = ("x", "t", "surface_of_face", "key_of_face", "rows", "near", "ids", "d", "m", "w")


def sheets(holes: bool) -> tuple[list[gs.TriSurface], list[gs.TriSurface]]:
    """Two torn horizons and their faults: as they come, and as lists of triangles only."""
    world = gs.synthetic.graben(n=31)
    faults = [gs.triangulate_fault(one, name=name) for name, one in world.faults.items()]
    made = []
    for name in ("Top", "Base"):
        data = world.horizons[name].copy()
        if holes:
            data[20:23, 4:9] = np.nan
        throw = {"F1": 60.0, "F2": 35.0}
        made.append(gs.throw_horizon(data, faults, throw, name=name).surface)
    lists = [
        gs.TriSurface(one.name, one.role, one.vertices, one.triangles, vertex_data=one.vertex_data)
        for one in made
    ]
    return [*made, *faults], [*lists, *faults]


@pytest.mark.parametrize("holes", [False, True])
def test_contacts_are_those_of_lists(holes: bool) -> None:
    torn, lists = sheets(holes)
    unread = [torn_sheet(one.name, one.torn, dict(one.vertex_data)) for one in torn[:2]]
    one, two = find_contacts([*unread, *torn[2:]]), find_contacts(lists)
    assert not any("triangles" in sheet.__dict__ for sheet in unread)
    assert len(one.rows) > 100
    for name in ARRAYS:
        assert np.array_equal(getattr(one, name), getattr(two, name)), name
    for mine, other in zip(one.nodes, two.nodes, strict=True):
        assert np.array_equal(mine[0], other[0])
        assert np.array_equal(mine[1], other[1])


def test_areas_along_a_rim_are_those_of_lists() -> None:
    """Sides along the frame of the grid, inside of it, and through a fault, a little off nodes."""
    (top, *_), (plain, *_) = sheets(holes=False)
    x, y = np.unique(top.vertices[:, 0]), np.unique(top.vertices[:, 1])
    n_moved = 0
    for k in (0, 4, 11, 15):
        for off in (0.0, 1e-9, 1e-3):
            west, east, south, north = x[k] - off, x[-1], y[0] - off, y[-1 - k] + off
            outline = np.array([[west, south], [east, south], [east, north], [west, north]])
            with silenced():
                one, two = (off_the_rims(outline, [s], "model box") for s in (top, plain))
            assert np.array_equal(one, two)
            n_moved += not np.array_equal(one, outline)
    assert n_moved > 3
