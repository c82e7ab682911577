"""Where a torn sheet meets itself: both ways of asking against clipping in rational arithmetic."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import geosurf as gs
from geosurf import TriSurface, rebuild_surfaces
from geosurf.arrangement.candidates import over_itself, pairs_with_itself
from geosurf.arrangement.search import find_contacts
from geosurf.kernels.sheets.torn_links import are_over_nodes, edges_over_ghosts
from geosurf.model.surfaces import torn_sheet
from geosurf.triangulate.outline import off_the_rims
from geosurf.warning import silenced
from tests import oracles

N = 3
ORIGIN = np.zeros(3)


def corners_of(n: int) -> np.ndarray:
    """Nodes of the triangles of a lattice of n x n nodes."""
    low = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    return np.concatenate([low[:, None] + (0, 1, n), low[:, None] + (1, n + 1, n)])


@st.composite
def torn_sheets(draw):
    """A lattice, and copies of some of its triangles that share some corners with it."""
    whole = corners_of(N)
    z = draw(st.lists(st.integers(0, 3), min_size=N * N, max_size=N * N))
    node, triangles, ghost = list(range(N * N)), [], [False] * N * N
    for t in range(len(whole)):
        for copy in range(draw(st.sampled_from([1, 1, 2, 3]))):
            row = []
            for k in range(3):
                if copy == 0 or draw(st.booleans()):
                    row.append(int(whole[t, k]))
                    continue
                row.append(len(node))
                node.append(int(whole[t, k]))
                z.append(draw(st.integers(0, 3)))
                ghost.append(True)
            triangles.append(row)
    y, x = np.divmod(np.array(node), N)
    vertices = np.column_stack([x, y, z]).astype(float)
    marks = {"ghost": np.array(ghost), "outer": np.array(ghost), "node": np.array(node)}
    return vertices, np.array(triangles), marks


def surface_of(vertices, triangles, marks, *names) -> TriSurface:
    """A sheet with some of its marks."""
    kept = {name: marks[name] for name in names}
    return TriSurface("Top", "horizon", vertices, triangles, vertex_data=kept)


def crossing(vertices, triangles, marks) -> set[tuple[int, int]]:
    """Pairs with a ghost that have more in common than corners of both and what is between."""
    found = set()
    for i, j in combinations(range(len(triangles)), 2):
        if not marks["ghost"][triangles[[i, j]]].any():
            continue
        P, Q = vertices[triangles[i]], vertices[triangles[j]]
        both = set(map(tuple, P.tolist())) & set(map(tuple, Q.tolist()))
        corners = {tuple(map(float, corner)) for corner in oracles.meet_triangles(P, Q)}
        if not corners <= both:
            found.add((i, j))
    return found


def places_of(patches):
    """Triangles with their parents, and curves, by coordinates: points may be numbered apart."""
    corners = np.round(patches.vertices[patches.triangles], 9).tolist()
    parents = zip(patches.surface_of_triangle, patches.parent_of_triangle, strict=True)
    curves = np.round(patches.vertices[patches.curve_edges], 9).tolist()
    return (
        sorted((*of, sorted(place)) for of, place in zip(parents, corners, strict=True)),
        sorted(sorted(ends) for ends in curves),
    )


@settings(max_examples=40)
@given(torn_sheets())
def test_all_crossings_of_a_sheet_with_itself_are_found(sheet):
    expected = crossing(*sheet)
    plain, noded = surface_of(*sheet, "ghost"), surface_of(*sheet, "ghost", "node")
    for surface in (plain, noded):
        rows, _ = pairs_with_itself(surface, ORIGIN)
        found = {tuple(pair) for pair in rows.tolist()}
        assert len(found) == len(rows)
        assert expected <= found
        assert all(a < b for a, b in found)
    assert over_itself(plain, rows, ORIGIN).all()


@settings(max_examples=20)
@given(torn_sheets(), st.integers(0, 2))
def test_a_sheet_is_split_alike_however_it_is_asked(sheet, slope):
    x = np.array([[-1.0, 0.3, -9], [3, 0.7 + slope, -9], [1, 1.9, 9]])
    fault = TriSurface("F1", "fault", x, [[0, 1, 2]])
    ways = [
        rebuild_surfaces([surface_of(*sheet, "ghost", "node"), fault]),
        rebuild_surfaces([surface_of(*sheet, "ghost"), fault]),
        rebuild_surfaces([surface_of(*sheet, "ghost", "node"), fault], method="voxels"),
    ]
    first, *others = (places_of(way) for way in ways)
    assert all(first == other for other in others)


@given(st.integers(0, 2**32 - 1))
def test_edges_over_nodes_below_ghosts(seed):
    rng = np.random.default_rng(seed)
    n, n_node = 9, 6
    node, ghost = rng.integers(0, n_node, n), rng.random(n) < 0.2
    t = np.array([rng.permutation(n)[:3] for _ in range(12)])
    under = {int(node[v]) for row in t if ghost[row].any() for v in row}
    expected = []
    for i, row in enumerate(t.tolist()):
        for a, b in zip(row, row[1:] + row[:1], strict=True):
            if node[a] in under and node[b] in under:
                expected.append((i, b, a) if node[a] > node[b] else (i, a, b))
    found = edges_over_ghosts(t, node, ghost, n_node)
    assert list(zip(*(part.tolist() for part in found), strict=True)) == expected

    # one place for each node, until one vertex moves
    vertices = rng.normal(size=(n_node, 3))[node]
    vertices[:, 2] = rng.normal(size=n)
    assert are_over_nodes(node, vertices, n_node).all()
    vertices[0, 1] += 1.0
    alone = (node == node[0]).sum() == 1
    assert bool(are_over_nodes(node, vertices, n_node)[0]) == alone


# ---- Torn sheets that know their lattice: contacts, rims and equal points are those of plain
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
