"""Where a torn sheet meets itself: both ways of asking against clipping in rational arithmetic."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf import TriSurface, intersect_surfaces, rebuild_surfaces
from geosurf.arrangement.candidates import pairs_with_itself
from geosurf.arrangement.search import find_contacts
from geosurf.arrangement.tree_pairs import ULP, needed, pairs_of_one_map
from geosurf.arrangement.trees import tree_of
from geosurf.errors import silenced
from geosurf.model import Lattice
from geosurf.model.surfaces import torn_sheet
from geosurf.triangulate.outline import off_the_rims
from tests import laws, oracles
from tests.strategies import as_list

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


# ---- Grids with straight axes: what floats exclude does not meet.
@st.composite
def pairs_of_grids(draw):
    """An upright grid and any other one, small whole numbers, some nodes absent."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    n_row, n_col, m, k = rng.integers(2, 12, 4)
    z = rng.integers(-2, 3, (n_row, n_col)) * 1.0
    z[rng.random(z.shape) < draw(st.sampled_from([0.0, 0.2]))] = np.nan
    axes = [np.cumsum(rng.integers(1, 4, n)) * 1.0 for n in (n_col, n_row)]
    top = Lattice(*axes, z, bool(rng.integers(2)))
    u, v = np.meshgrid(np.arange(k) * 1.0, np.arange(m) * 1.0)
    scale = draw(st.sampled_from([1.0, 0.37]))
    x = scale * (u + rng.integers(0, 3, (m, k))) + rng.integers(0, 4)
    y = scale * (rng.integers(0, 6, (m, k)) if draw(st.booleans()) else 2 * v)
    h = scale * rng.integers(-3, 4, (m, k))
    h[rng.random(h.shape) < 0.1] = np.nan
    x, y = 1.0 * x, 1.0 * y
    if draw(st.booleans()):  # whole cells without a place, though with a height
        i, j = rng.integers(0, (m, k))
        draw(st.sampled_from([x, y]))[i : i + 3, j : j + 4] = np.nan
    wall = Lattice(x, y, h * 1.0, bool(rng.integers(2)), bool(rng.integers(2)))
    a = TriSurface("A", "horizon", lattice=top)
    b = TriSurface("B", "fault", lattice=wall)
    a.checked = b.checked = True  # as they are: triangles without area are not asked for here
    return (b, a) if draw(st.booleans()) else (a, b)


def usable(surfaces):
    """Whether all triangles have an area, and there are some."""
    for surface in surfaces:
        x = surface.vertices[surface.triangles]
        normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
        if not len(x) or not normal.any(axis=1).all():
            return False
    return True


def contacts_by_key(found):
    """Triangles of all contacts, and all that is known of each."""
    keys = found.key_of_face[found.rows[:, :2]]
    return {(*key, how) for key, how in zip(keys.tolist(), found.rows[:, 2].tolist(), strict=True)}


def assert_as_by_voxels(surfaces):
    """Contacts by cells and by voxels are the same; how many there are."""
    by_axes = find_contacts(surfaces)
    by_voxels = find_contacts(surfaces, method="voxels")
    assert contacts_by_key(by_axes) == contacts_by_key(by_voxels)
    np.testing.assert_array_equal(by_axes.x[by_axes.n_vertex :], by_voxels.x[by_voxels.n_vertex :])
    return len(by_axes.rows)


@given(pairs_of_grids())
def test_contacts_are_those_of_voxels(surfaces):
    if usable(surfaces):
        assert_as_by_voxels(surfaces)


@pytest.mark.parametrize("cells", [(3, 2), (9, 6), (40, 30)])
@pytest.mark.parametrize("offset", [0.0, 6.5e6])
def test_rough_grids_of_all_sizes_of_cells(rng, cells, offset):
    """Edges inside, through one edge, past corners: heights exclude no pair that meets."""
    axis = offset + np.linspace(0.0, 30.0, 25)
    top = Lattice(axis, axis + rng.uniform(0, 0.3, 25), rng.normal(0, 0.6, (25, 25)))
    v, u = np.meshgrid(np.linspace(-3, 3, cells[1] + 1), np.linspace(1, 29, cells[0] + 1))
    bent = rng.normal(0, 3.0 / cells[0], (3, *u.shape))
    wall = Lattice(offset + 15 + v + bent[0], offset + u + bent[1], 1.5 * v + bent[2], True, False)
    surfaces = [TriSurface("A", "horizon", lattice=top), TriSurface("B", "fault", lattice=wall)]
    assert assert_as_by_voxels(surfaces) > 25


@given(st.integers(0, 2**32), st.sampled_from([1.0, 1e3, 1e6]))
def test_nodes_within_an_ulp_of_planes_and_edges(seed, offset):
    """Whole numbers moved by the last place or not: floats say nothing that is not so."""
    rng = np.random.default_rng(seed)
    axes = [offset + np.arange(5.0), offset + np.arange(4.0)]
    top = Lattice(*axes, rng.integers(-1, 2, (4, 5)) * 1.0)
    v, u = np.meshgrid(np.arange(-1.0, 2.0), np.arange(4.0))
    places = np.stack([offset + 2 + v, offset + u, rng.integers(-2, 3, u.shape) * 1.0])
    last = 2.0**-52 * (offset + 8.0)
    moved = places + rng.choice([-last, last], places.shape)
    wall = Lattice(*np.where(rng.random(places.shape) < 0.4, moved, places), True, False)
    surfaces = [TriSurface("A", "horizon", lattice=top), TriSurface("B", "fault", lattice=wall)]
    if usable(surfaces):
        assert_as_by_voxels(surfaces)


# ---- Lattices with one map: what is left out never meets, results are the voxels' to the byte.
TURN = np.array([[3.0, -4.0], [4.0, 3.0]]) / 5.0


def horizon(name, z, *, rising=True, turned=False, corner=(0.0, 0.0)):
    """A horizon over unit cells, or over cells turned by about 53 degrees."""
    z = np.asarray(z, dtype=float)
    y, x = (np.arange(n, dtype=float) for n in z.shape)
    x, y = x + corner[0], y + corner[1]
    if turned:
        x, y = np.einsum("ij,jkl->ikl", TURN, np.stack(np.meshgrid(x, y)))
    return TriSurface(name, "horizon", lattice=Lattice(x, y, z, rising=rising))


@st.composite
def of_one_map_horizons(draw, n_row=4, n_col=4, n=2):
    """Horizons with whole heights, holes and either diagonal over one map."""
    turned = draw(st.booleans())
    made = []
    for name in "ABC"[:n]:
        z = np.array(
            draw(st.lists(st.integers(0, 2), min_size=n_row * n_col, max_size=n_row * n_col))
        )
        z = z.astype(float)
        z[draw(st.lists(st.integers(1, n_row * n_col - 1), max_size=2))] = np.nan
        surface = horizon(name, z.reshape(n_row, n_col), rising=draw(st.booleans()), turned=turned)
        if surface.n_triangle:
            made.append(surface)
    return made


def listed(one, two):
    """Pairs as listed for one map."""
    pairs, _ = pairs_of_one_map((one.lattice, two.lattice), (tree_of(one), tree_of(two)))
    found = {tuple(row) for row in pairs.tolist()}
    assert len(found) == len(pairs)
    return found


def assert_one_result(surfaces):
    """Curves and patches by trees and by voxels are the same bytes, and lists have the same curves.

    Lattices leave out the same pairs by either method; lists leave out none, so that they tell
    whether what was left out was needed.
    """
    meshes = [as_list(s) for s in surfaces]
    one, two = (intersect_surfaces(surfaces, method=m) for m in ("tree", "voxels"))
    lists = intersect_surfaces(meshes, method="voxels")
    for other in (two, lists):
        assert laws.curve_bytes(one) == laws.curve_bytes(other)
    one, two = (rebuild_surfaces(surfaces, method=m) for m in ("tree", "voxels"))
    laws.assert_same_bytes(one, two)
    lists = rebuild_surfaces(meshes, method="voxels")
    if one.report["moved_vertices"] == lists.report["moved_vertices"] == 0:
        assert laws.pieces_by_name(one) == laws.pieces_by_name(lists)


@given(of_one_map_horizons())
def test_results_are_the_voxels_to_the_byte(surfaces):
    assert_one_result(surfaces)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("holes", [0, 40])
def test_blocks_and_their_rims(rng, turned, holes):
    """More than one block of cells; holes on both sides of the seams between blocks."""
    made = []
    for name in "AB":
        z = rng.integers(0, 30, (21, 19)).astype(float)
        z[rng.integers(0, 21, holes), rng.integers(0, 19, holes)] = np.nan
        made.append(horizon(name, z, turned=turned))
    assert_one_result(made)


@given(of_one_map_horizons())
def test_the_list_has_all_that_meet_and_no_more_than_is_needed(surfaces):
    if len(surfaces) == 2:
        one, two = surfaces
        contacts = find_contacts(surfaces, method="voxels")
        meeting = contacts.key_of_face[contacts.rows[:, :2]]
        found = listed(one, two)
        assert {tuple(row) for row in meeting.tolist()} <= found
        assert needed(one.lattice, two.lattice, np.array(sorted(found)).reshape(-1, 2)).all()


@given(of_one_map_horizons())
def test_near_pairs_above_one_triangle_are_kept(surfaces):
    """What rounding could make meet stays a candidate, however little apart it is."""
    if len(surfaces) < 2:
        return
    one, two = surfaces
    z = two.lattice.elevation
    largest = max(np.abs(s.extent).max() for s in surfaces)
    lifted = TriSurface(
        "B", "horizon",
        lattice=Lattice(
            two.lattice.easting, two.lattice.northing, z + ULP * largest, rising=two.lattice.rising
        ),
    )  # fmt: skip
    by_voxels = find_contacts((one, lifted), method="voxels")
    near = by_voxels.key_of_face[by_voxels.near]
    assert {tuple(row) for row in near.tolist()} <= listed(one, lifted)
