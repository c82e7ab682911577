"""Torn sheets over one lattice: no pair that meets is missed, by rational arithmetic."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import geosurf as gs
from geosurf import TriSurface
from geosurf.arrangement.lattice_maps import lattice_map, pairs_over_lattice, without_ghosts
from geosurf.arrangement.tree import candidate_pairs, tree_of
from tests import oracles
from tests.arrangement.test_torn import ORIGIN, surface_of, torn_sheets

MARKS = ("ghost", "outer", "node")


def moved(vertices: np.ndarray, which: list[int]) -> np.ndarray:
    """Some vertices a little off their places in the map, as repairs leave them."""
    found = vertices.copy()
    for k in which:
        found[k % len(found), :2] += (2.0**-6, -(2.0**-5))
    return found


@settings(max_examples=30, deadline=None)
@given(torn_sheets(), torn_sheets(), st.lists(st.integers(0, 99), max_size=2), st.integers(-3, 3))
def test_all_pairs_of_two_sheets_that_meet_are_candidates(one, two, which, shift):
    (x, t, marks), (y, u, others) = one, two
    x, y = moved(x, which), y + np.array([0.0, 0.0, shift])
    sheets = surface_of(x, t, marks, *MARKS), surface_of(y, u, others, *MARKS)
    found = pairs_over_lattice(sheets, ORIGIN)
    assert found is not None
    pairs = set(map(tuple, found[0].tolist()))
    near = set(map(tuple, candidate_pairs(*map(tree_of, sheets))[0].tolist()))
    assert pairs <= near  # of all others boxes are apart
    assert not any(len(oracles.meet_triangles(x[t[i]], y[u[j]])) for i, j in near - pairs)


@settings(max_examples=20, deadline=None)
@given(torn_sheets(), st.lists(st.integers(0, 99), max_size=2))
def test_triangles_without_ghosts_meet_in_their_own_corners_only(sheet, which):
    x, t, marks = sheet
    x = moved(x, which)
    some = np.flatnonzero(without_ghosts(surface_of(x, t, marks, *MARKS)))
    for i, j in combinations(some.tolist(), 2):
        if set(t[i]) == set(t[j]):
            continue  # the same triangle twice
        shared = {tuple(x[k]) for k in set(t[i]) & set(t[j])}
        corners = {tuple(map(float, corner)) for corner in oracles.meet_triangles(x[t[i]], x[t[j]])}
        assert corners <= shared


def test_a_sheet_names_the_nodes_of_its_lattice_and_its_ghosts():
    world = gs.synthetic.torn("normal", n=31)
    sheet = gs.tear_horizon(world.horizons["Top"], world.faults, trim=2.0)
    surface = sheet.surface
    over = lattice_map(surface)
    assert (over.n_col, over.rising) == (sheet.lattice.shape[1], sheet.lattice.rising)
    ghost = surface.vertex_data["ghost"]
    assert without_ghosts(surface).sum() == (~ghost[surface.triangles]).all(axis=1).sum()

    # nodes that are no lattice's are not believed
    far = surface.vertices.copy()
    far[surface.n_vertex // 2, 0] += 0.2 * sheet.report.cell
    assert lattice_map(TriSurface("Top", "horizon", far, surface.triangles,
                                  vertex_data=surface.vertex_data)) is None  # fmt: skip
    turned = {**surface.vertex_data, "node": surface.vertex_data["node"][::-1]}
    wrong = TriSurface("Top", "horizon", surface.vertices, surface.triangles, vertex_data=turned)
    assert lattice_map(wrong) is None
    assert not without_ghosts(wrong).any()


def test_torn_lattices_have_the_candidates_of_their_lists():
    """Without a list of triangles, and with nodes that both sheets have at different places."""
    world = gs.synthetic.torn("normal", n=31)
    top = gs.tear_horizon(world.horizons["Top"], world.faults, trim=2.0)
    holed = world.horizons["Top"] - 20.0
    holed[3:5, 20:24] = np.nan
    low = gs.tear_horizon(holed, world.faults, trim=2.0, name="Low")
    east = np.broadcast_to(top.lattice.easting, top.lattice.shape).copy()
    north = np.broadcast_to(top.lattice.northing[:, None], top.lattice.shape).copy()
    east[12, 7] += 2.0**-6
    moved = replace(top, name="Moved", lattice=gs.model.Lattice(east, north,
                    top.lattice.elevation - 3.0, top.lattice.rising))  # fmt: skip
    for pair in ((top, low), (top, moved), (moved, low)):
        sheets = tuple(sheet.surface for sheet in pair)
        assert all(surface.torn is not None for surface in sheets)
        found, _ = pairs_over_lattice(sheets, ORIGIN)
        listed, _ = pairs_over_lattice(tuple(map(as_list, sheets)), ORIGIN)
        assert len(listed) > 0
        assert set(map(tuple, found.tolist())) == set(map(tuple, listed.tolist()))


def as_list(surface: TriSurface) -> TriSurface:
    """The same without its lattice."""
    marks = dict(surface.vertex_data)
    return TriSurface(surface.name, "horizon", surface.vertices, surface.triangles,
                      vertex_data=marks)  # fmt: skip
