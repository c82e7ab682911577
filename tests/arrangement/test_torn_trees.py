"""Torn sheets that know their lattice: contacts, rims and equal points are those of plain lists."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.arrangement.search import find_contacts
from geosurf.model.surfaces import torn_sheet
from geosurf.rebuild.assemble import first_of_equals
from geosurf.triangulate.rims import off_the_rims
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


def test_lists_are_made_when_they_are_read() -> None:
    """In the order of the lattice, then the copies; counting needs none."""
    (top, *_), _ = sheets(holes=True)
    fresh = torn_sheet("Top", top.torn, dict(top.vertex_data))
    assert (fresh.n_vertex, fresh.n_triangle) == (top.n_vertex, top.n_triangle)
    rows = np.array([0, 700, top.n_triangle - 1])
    corners = fresh.corners_of_keys(rows)
    places = fresh.places_of_nodes(corners)
    assert not {"vertices", "triangles"} & {*fresh.__dict__}
    assert np.array_equal(corners, top.triangles[rows])
    assert np.array_equal(places, top.vertices[corners])


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


def test_ghosts_at_the_place_of_a_node_are_found() -> None:
    (top, *_), _ = sheets(holes=False)
    torn = top.torn
    assert first_of_equals(top) is None
    ghosts = torn.ghosts.copy()
    ghosts[7, 2] = torn.elevation.ravel()[torn.node_of_ghost[7]]
    meets = type(torn).of(torn, torn.gone, torn.copies, ghosts)
    found = first_of_equals(torn_sheet("Top", meets, {}))
    assert found is not None
    assert found[torn.n_node + 7] == torn.node_of_ghost[7]


@pytest.mark.parametrize("holes", [False, True])
def test_rows_and_keys_of_a_torn_lattice_are_those_of_its_list(holes: bool) -> None:
    torn = sheets(holes)[0][0].torn
    rows = np.arange(torn.n_triangle)
    assert torn.nodes_are_all_there != holes
    assert np.array_equal(torn.keys_of_rows(rows), torn.keys)
    assert np.array_equal(torn.rows_of_keys(torn.keys), rows)
