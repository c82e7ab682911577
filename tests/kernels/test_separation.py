"""Pairs that are surely apart, against exact contacts: never one that meets elsewhere."""

from __future__ import annotations

import itertools
import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.arrangement.triangles import are_graphs, crossing_pairs, group_of
from geosurf.errors import SurfaceError
from geosurf.kernels.contacts.triangle_contact import FIRST_CODE, N_COLUMN, N_CORNER, meet_pairs
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.lattices.survey import TILE
from geosurf.kernels.meshes.mesh import edges
from geosurf.kernels.search.tree import BLOCK
from geosurf.model import Lattice, TriSurface
from geosurf.triangulate import triangulate_fault
from geosurf.triangulate.mesh import fault_diagonal, find_zero_area, orient_fault
from tests import oracles

POINT = st.tuples(*[st.integers(0, 3)] * 3)


@st.composite
def meshes(draw):
    """Triangles with an area on few places of a small lattice, so that they meet in all ways."""
    points = np.array(draw(st.lists(POINT, min_size=4, max_size=9, unique=True)), dtype=float)
    every = list(itertools.combinations(range(len(points)), 3))
    rows = draw(st.lists(st.sampled_from(every), min_size=2, max_size=8))
    t = np.array([draw(st.permutations(row)) for row in rows], dtype=np.int64)
    a, b, c = (points[t[:, k]] for k in range(3))
    return points, t[np.cross(b - a, c - a).any(axis=1)]


def exact_pairs(x, t, n_first):
    """Pairs that meet elsewhere than in common corners and edges, each contact taken exactly."""
    pairs = np.array(
        [
            (i, j)
            for i, j in itertools.combinations(range(len(t)), 2)
            if i < n_first and set(t[i].tolist()) != set(t[j].tolist())
        ],
        dtype=np.int64,
    ).reshape(-1, 2)
    m, w = frame_of(x, len(t))
    rows = np.empty((len(pairs) + 1, N_COLUMN), dtype=np.int64)
    n, _ = meet_pairs(x, t, pairs, m, w, 0.0, rows, np.empty(0, dtype=np.int64))
    found = set()
    for row in rows[:n].tolist():
        codes = row[FIRST_CODE : FIRST_CODE + row[N_CORNER]]
        if any((code >> 3) > 2 or (code & 7) > 2 for code in codes):
            found.add((row[0], row[1]))
    return found


@given(meshes(), st.sampled_from([1.0, 1e-3, 1e9]), st.booleans(), st.integers(0, 3))
def test_crossing_pairs_are_those_of_all_pairs(mesh, scale, jitter, n_other):
    x, t = mesh
    x = x * scale
    if jitter:  # no longer in planes, and no differences without rounding
        x = x * (1.0 + 1e-3 * np.sin(np.arange(x.size).reshape(x.shape))) + scale / 3.0
    n_first = max(len(t) - n_other, 0)
    if n_first == 0:
        return
    found = crossing_pairs(x, t[:n_first], t[n_first:])
    assert {tuple(pair) for pair in found.tolist()} == exact_pairs(x, t, n_first)
    order = [tuple(pair) for pair in found.tolist()]
    assert order == sorted(set(order))


def graphs_among(x, t, surface):
    """Surfaces that are surely graphs, none of which meets itself; whether each meets itself."""
    groups = [group_of(x, t, np.flatnonzero(surface == i)) for i in (0, 1)]
    found = are_graphs(x, t, surface, edges(t, len(x))[0], groups)
    every = exact_pairs(x, t, len(t))
    crossing = [any(surface[i] == surface[j] == k for i, j in every) for k in (0, 1)]
    assert not np.any(np.logical_and(found, crossing))
    return found, crossing


@given(meshes(), st.lists(st.integers(0, 1), min_size=8, max_size=8), st.booleans())
def test_graphs_do_not_meet_themselves(mesh, surface, upward):
    x, t = mesh
    if upward:  # turned alike on the map, where they are not vertical
        a, b, c = (x[t[:, k], :2] for k in range(3))
        down = np.linalg.det(np.stack([b - a, c - a], axis=1)) < 0.0
        t[down] = t[down][:, ::-1]
    graphs_among(x, t, np.array(surface[: len(t)], dtype=np.int64))


def strip(turns, rise, n_ring=4, n=16):
    """A strip of several rings of triangles that goes round some turns, and rises meanwhile."""
    angle = np.linspace(0.0, 2.0 * np.pi * turns, n)
    radius = np.arange(1.0, n_ring + 1.0)
    x = [radius * np.cos(angle[:, None]), radius * np.sin(angle[:, None])]
    z = np.broadcast_to(rise * angle[:, None], x[0].shape)
    node = np.arange(n * n_ring).reshape(n, n_ring)
    a, b, c, d = node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]
    t = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])
    return np.stack([*x, z], axis=-1).reshape(-1, 3), t.reshape(-1, 3)


@pytest.mark.parametrize("rise", [0.0, 1e-9, 1.0])
@pytest.mark.parametrize(("turns", "overlaps"), [(0.9, False), (1.1, True), (1.9, True)])
@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_strip_that_goes_round_more_than_once(turns, overlaps, rise, way, axis):
    """As many triangles lie over a place as its rim goes round it."""
    x, t = strip(turns, rise)
    found = graphs_among(np.roll(x, axis, axis=1), t[:, ::way], np.zeros(len(t), np.int64))
    assert found == ([not overlaps, True], [overlaps and not rise, False])


def test_a_rim_that_another_surface_shares():
    """Walls of another surface stand on all of its rim."""
    x, t = strip(1.9, 0.0)
    x = np.concatenate([x, x + np.array([0.0, 0.0, 1.0])])
    halves = {(a, b) for row in t.tolist() for a, b in zip(row, [*row[1:], row[0]], strict=True)}
    walls = np.array([(b, a, a + len(x) // 2) for a, b in halves if (b, a) not in halves])
    surface = np.repeat([0, 1], [len(t), len(walls)])
    found, crossing = graphs_among(x, np.concatenate([t, walls]), surface)
    assert not found[0]
    assert crossing[0]


@pytest.mark.parametrize("east", [0.0, 0.25])
def test_two_lids_on_one_outline_have_no_rim(east):
    """All turn the same way on the map, and none is at a rim; they cross if tops are side by side.

    Edges of the outline have two triangles that run through them the same way.
    """
    outline = [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
    x = np.array([*outline, (0, 0, 1), (east, 0, 1.0 - 4.0 * (east == 0.0))], dtype=float)
    t = np.array([(i, (i + 1) % 4, top) for top in (4, 5) for i in range(4)])
    assert graphs_among(x, t, np.zeros(8, np.int64)) == ([False, True], [east > 0.0, False])


def test_what_is_vertical_is_no_graph_over_the_map():
    """Two triangles of a vertical plane that overlap, turned to both sides."""
    x = np.array([[0.0, 0, 0], [0, 4, 0], [0, 0, 4], [0, 1, 1], [0, 1, 5], [0, 5, 1]])
    t = np.arange(6).reshape(2, 3)
    assert graphs_among(x, t, np.zeros(2, np.int64)) == ([False, True], [True, False])


@pytest.mark.parametrize(("east", "fits"), [(2.2, True), (4.2, False)])
def test_a_node_that_is_beyond_its_neighbours(east, fits):
    """Its triangles turn over and meet others; none of them is at the rim."""
    x, y = np.meshgrid(np.arange(7.0), np.arange(7.0))
    x[3, 2] = east
    node = np.arange(49).reshape(7, 7)
    a, b, c, d = node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]
    t = np.concatenate([np.stack(k, axis=-1).reshape(-1, 3) for k in ((a, b, c), (a, c, d))])
    x = np.stack([x.ravel(), y.ravel(), np.zeros(49)], axis=1)
    assert graphs_among(x, t, np.zeros(len(t), np.int64)) == ([fits, True], [not fits, False])


TURN = np.linalg.qr(np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 10]]))[0]


@pytest.mark.parametrize("shift", [0.0, 7e3, 7e6])
def test_what_was_in_one_plane_before_rounding_is_not_sure(shift):
    """Triangles over a lattice that was turned: many thousands miss or meet by an ulp."""
    lattice = np.array(list(itertools.product(range(3), repeat=3)), dtype=float)
    every = np.array(list(itertools.combinations(range(27), 3)))
    a, b, c = (lattice[every[:, k]] for k in range(3))
    every = every[np.cross(b - a, c - a).any(axis=1)]
    t = every[np.random.default_rng(5).choice(len(every), 130, replace=False)]
    x = lattice @ TURN + shift
    found = {tuple(pair) for pair in crossing_pairs(x, t).tolist()}
    expected = exact_pairs(x, t, len(t))
    assert len(expected) > 1000
    assert found == expected


@given(meshes())
def test_against_clipping(mesh):
    """Without the engine's contacts: what two triangles have in common, in rational numbers."""
    x, t = mesh
    t = t[:4]
    if len(t) == 0:
        return
    found = {tuple(pair) for pair in crossing_pairs(x, t).tolist()}
    for i, j in itertools.combinations(range(len(t)), 2):
        shared = set(t[i].tolist()) & set(t[j].tolist())
        if len(shared) == 3:
            continue
        met = oracles.meet_triangles(oracles.rational(x[t[i]]), oracles.rational(x[t[j]]))
        clean = set(met) <= set(oracles.rational(x[sorted(shared)]))
        assert ((i, j) in found) != clean


# ---- One look at all nodes of a lattice, against looking at them one by one.
@st.composite
def grids(draw) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes with small whole coordinates, some absent, up to two blocks each way."""
    shape = draw(st.tuples(st.integers(1, 11), st.integers(1, 11)))
    seed = draw(st.integers(0, 2**32 - 1))
    holes, far = draw(st.sampled_from([0.0, 0.0, 0.1, 0.6])), draw(st.sampled_from([0, 5_000_000]))
    rng = np.random.default_rng(seed)
    i, j = np.mgrid[: shape[0], : shape[1]]
    noise = rng.integers(0, draw(st.sampled_from([1, 2, 5])), (3, *shape))
    x, y, z = np.stack([3.0 * j, 2.0 * i, -4.0 * i]) + noise
    for part in (x, y, z):
        part[rng.random(shape) < holes / 3] = np.nan
    return x + far, y + far, z


def triangles_of(lattice: Lattice) -> np.ndarray:
    """Corners (n, 3, 3) of all triangles, cell by cell, by the words of `Lattice`."""
    nodes = np.stack([*lattice.horizontal(), lattice.elevation], axis=-1)
    found = []
    for i, j in product(range(lattice.shape[0] - 1), range(lattice.shape[1] - 1)):
        a, b, c, d = nodes[i, j], nodes[i, j + 1], nodes[i + 1, j + 1], nodes[i + 1, j]
        halves = [(a, b, c), (a, c, d)] if lattice.rising else [(a, b, d), (b, c, d)]
        found += [half for half in halves if np.isfinite(half).all()]
    return np.array(found).reshape(-1, 3, 3)


def rises_by_the_rule(x: np.ndarray, y: np.ndarray) -> bool:
    """The diagonal rule of `rising_diagonal`, cell by cell, with one rounding of each sum."""
    cells = []
    for i, j in product(range(x.shape[0] - 1), range(x.shape[1] - 1)):
        a, b, c, d = ((x[k], y[k]) for k in ((i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)))
        if np.isfinite([a, b, c, d]).all():
            middle = (a[0] + c[0]) + (b[0] + d[0]), (a[1] + c[1]) + (b[1] + d[1])
            cells.append((middle, (c[0] - a[0], c[1] - a[1]), (d[0] - b[0], d[1] - b[1])))
    for some in (cells, sorted(cells)[:1]):  # all of them, then the westernmost
        size = math.fsum(v * v for _, *both in some for way in both for v in way)
        for k in (0, 1):  # to the north-east, then to the north
            gain = math.fsum(sign * way[k] * way[1] for _, *both in some
                             for sign, way in zip((1, -1), both, strict=True))  # fmt: skip
            if abs(gain) > 1e-6 * size:
                return gain > 0
    return True


def slow_diagonal(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> bool:
    """The diagonal rule for faults, word for word."""
    normal = np.zeros(3)
    for rising in (True, False):
        corners = triangles_of(Lattice(x, y, z, rising, False))
        normal += 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(
            axis=0
        )
    strike = np.array([-normal[1], normal[0]])
    if np.abs(strike).max() <= 1e-6 * np.linalg.norm(normal):
        return rises_by_the_rule(x, y)
    lead = strike[0] if abs(strike[0]) > 1e-6 * np.abs(strike).max() else strike[1]
    strike /= np.sign(lead) * np.linalg.norm(strike)
    return rises_by_the_rule((x - np.nanmin(x)) * strike[0] + (y - np.nanmin(y)) * strike[1], z)


def check_boxes(lattice: Lattice) -> None:
    """Boxes of blocks of nodes, each with its rim, and the box of all."""
    nodes = np.stack([*lattice.horizontal(), lattice.elevation])
    survey = lattice.survey
    n_row, n_col = (max(-(-(n - 1) // BLOCK), 1) for n in lattice.shape)
    assert survey.levels[0].tolist() == [0, n_row, n_col]
    boxes = survey.nodes[: n_row * n_col]
    for (i, j), box in zip(product(range(n_row), range(n_col)), boxes, strict=True):
        rows, cols = (slice(k * BLOCK, k * BLOCK + BLOCK + 1) for k in (i, j))
        part = nodes[:, rows, cols].reshape(3, -1)
        low = np.where(np.isnan(part), np.inf, part).min(axis=1)
        high = np.where(np.isnan(part), -np.inf, part).max(axis=1)
        np.testing.assert_array_equal(box, [*low, *high])
    np.testing.assert_array_equal(survey.box[:3], boxes[:, :3].min(axis=0))
    np.testing.assert_array_equal(survey.box[3:], boxes[:, 3:].max(axis=0))
    assert survey.numbers == tuple((~np.isnan(part).any()).item() for part in nodes)


@given(grids())
def test_law_a_survey_tells_what_nodes_tell_one_by_one(parts):
    lattices = [Lattice(*parts, rising, False) for rising in (False, True)]
    check_boxes(lattices[0])
    for lattice in lattices:
        corners = triangles_of(lattice)
        assert lattice.n_triangle == len(corners) == len(lattice.build_triangles())
        normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal, area, doubted = lattice.normals
        np.testing.assert_array_equal(normal, normals.sum(axis=0))  # whole numbers: no rounding
        np.testing.assert_allclose(area, np.linalg.norm(normals, axis=1).sum(), rtol=1e-12)
        flat = find_zero_area(corners)
        assert set(flat.tolist()) <= set(lattice.rows_of_keys(doubted).tolist())
    assert lattices[0].whole == np.isfinite(np.stack(parts)).all()


@given(grids())
def test_law_the_diagonal_is_that_of_the_rule(parts):
    lattice = Lattice(*parts, False, False)
    if lattice.n_triangle:
        assert fault_diagonal(lattice) == slow_diagonal(*parts)


def wide(holes: float = 0.0, seed: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """More columns than a tile has, and rows that do not fill the last block."""
    rng = np.random.default_rng(seed)
    i, j = np.mgrid[: 2 * BLOCK + 4, : TILE + BLOCK + 3].astype(float)
    x, y, z = rng.integers(0, 4, (3, *i.shape)) + np.stack([5.0 * j, 3.0 * i, 7.0 * i])
    z[rng.random(z.shape) < holes] = np.nan
    return x, y, z


@pytest.mark.parametrize("holes", [0.0, 0.001, 0.3])
def test_more_than_one_tile(holes):
    lattices = [Lattice(*wide(holes), rising, False) for rising in (False, True)]
    check_boxes(lattices[0])
    for lattice in lattices:
        assert lattice.n_triangle == len(triangles_of(lattice))


@pytest.mark.parametrize("spot", [(0, 0), (5, 17), (2 * BLOCK + 3, TILE + BLOCK + 2)])
def test_one_flat_triangle_among_thousands_is_not_passed(spot):
    x, y, z = wide()
    i, j = spot
    other = (i - 1 if i else 1), j
    x[spot], y[spot], z[spot] = (part[other] for part in (x, y, z))
    with pytest.raises(SurfaceError, match="exactly zero area"):
        triangulate_fault(TriSurface("F1", "fault", lattice=Lattice(x, y, z, True, False)))


@pytest.mark.parametrize("value", [np.inf, -np.inf])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_infinite_nodes_are_seen_and_make_no_triangle(value, axis):
    parts = wide()
    before = Lattice(*parts, True, False).n_triangle
    parts[axis][7, 9] = value
    lattice = Lattice(*parts, True, False)
    assert not lattice.survey.finite
    assert not lattice.whole
    assert lattice.survey.numbers == (True, True, True)
    assert lattice.n_triangle == before - 6


@given(grids(), st.sampled_from(["rows", "columns", "axes"]))
def test_law_what_is_broadcast_is_not_expanded_and_nothing_else_changes(parts, how):
    x, y, z = parts
    if how == "axes":
        x, y = np.nan_to_num(x[0]), np.nan_to_num(y[:, 0])
        given_x, given_y = np.broadcast_arrays(x[None, :], y[:, None])
        kept = Lattice(x, y, z, True, False)
    else:
        x = np.broadcast_to(x[:1] if how == "rows" else x[:, :1], z.shape)
        given_x, given_y = x, y
        kept = Lattice(x, y, z, True, False)
    lattice = Lattice(given_x, given_y, z, True, False)
    plain = Lattice(given_x.copy(), given_y.copy(), z.copy(), True, False)
    assert sum(part.size for part in lattice.coordinates) <= x.size + y.size + z.size
    if z.size > 1:
        assert np.shares_memory(lattice.easting, given_x)
    for other in (lattice, kept):
        np.testing.assert_array_equal(other.survey.nodes, plain.survey.nodes)
        np.testing.assert_array_equal(other.normals[0], plain.normals[0])
        np.testing.assert_array_equal(other.build_vertices(), plain.build_vertices())
        np.testing.assert_array_equal(other.build_triangles(), plain.build_triangles())


@pytest.mark.parametrize("lean", [0.0, 1e-9, -1e-9, 1e-5, -1e-5, 0.1, -0.1])
@pytest.mark.parametrize("long", [1.0, 1e4])
@pytest.mark.parametrize("holes", [False, True])
def test_law_a_grid_faces_where_its_list_of_triangles_does(lean, long, holes):
    """Long cells in an almost vertical fault: bounds of its area are too far apart to tell."""
    i, j = np.mgrid[:4, :4].astype(float)
    x, y, z = -lean * i + 0.0, long * j, -1.0 * i
    if holes:
        z[0, 0] = z[3, 1] = np.nan
    for reverse in (False, True):
        lattice = Lattice(x, y, z, True, reverse)
        of_grid = orient_fault(TriSurface("F1", "fault", lattice=lattice))
        listed = TriSurface("F1", "fault", lattice.build_vertices(), lattice.build_triangles())
        of_list = orient_fault(listed)
        assert sides(of_grid) == sides(of_list)


def sides(surface: TriSurface) -> set:
    """Triangles as sets of directed edges."""
    edges = np.stack([surface.triangles, np.roll(surface.triangles, -1, axis=1)], axis=2)
    return {frozenset(map(tuple, three)) for three in edges.tolist()}


steps = st.lists(
    st.sampled_from([1.0, 2.0, 2.0, 0.0, -1.0, np.nan, np.inf]), min_size=1, max_size=9
)


@given(steps, steps)
def test_law_axes_rise_where_each_step_does(one, two):
    easting, northing = (np.cumsum(np.array([5.0, *part[1:]])) for part in (one, two))
    lattice = Lattice(easting, northing, np.zeros((len(two), len(one))))
    rises = all((x[1:] > x[:-1]).all() and np.isfinite(x).all() for x in (easting, northing))
    assert lattice.has_rising_axes == lattice.survey.axes_rise == rises
    spread = Lattice(*np.meshgrid(easting, northing), lattice.elevation)
    assert not spread.has_rising_axes
    assert not spread.survey.axes_rise
