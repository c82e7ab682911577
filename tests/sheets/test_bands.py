"""What is asked of bands of nodes, lines and picks, against slow and obvious ways."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf import TriSurface
from geosurf.kernels.lattices.decimate import third_differences
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.sheets import link_lines, node_bands
from geosurf.kernels.sheets.fault_trace import block_bounds
from geosurf.kernels.sheets.link_lines import distance_at_elevation
from geosurf.sheets.faults.fault_distance import (
    NearTrace,
    blocks_between,
    mesh_blocks,
    side_at_own_height,
)
from geosurf.sheets.faults.traces import FaultMesh, Trace, mesh_in_frame, trace_lines
from geosurf.sheets.heights.grid_solver import WorkingGrid
from geosurf.sheets.lattice.picks import Frame, Picks
from geosurf.sheets.report.describe import _misfit, profile, undirected_chains


def frame_of(n_row: int, n_col: int) -> Frame:
    axes = np.arange(n_col, dtype=float), np.arange(n_row, dtype=float)
    return Frame((n_row, n_col), np.zeros(2), np.eye(2), *axes)


@st.composite
def bands(draw):
    """Shape of a lattice, and some of its nodes, increasing."""
    n_row, n_col = draw(st.integers(1, 7)), draw(st.integers(1, 7))
    some = draw(st.sets(st.integers(0, n_row * n_col - 1)))
    return n_row, n_col, np.array(sorted(some), dtype=np.int64)


@given(bands(), st.integers(0, 3))
def test_nodes_around_a_band_are_those_within_some_rows_and_columns(band, reach):
    n_row, n_col, some = band
    near = {
        (r + i) * n_col + c + j
        for r, c in (divmod(node, n_col) for node in some.tolist())
        for i in range(-reach, reach + 1)
        for j in range(-reach, reach + 1)
        if 0 <= r + i < n_row and 0 <= c + j < n_col
    }
    assert node_bands.dilate_nodes(some, n_row, n_col, reach).tolist() == sorted(near)


@given(bands(), st.data())
def test_links_of_a_band_are_those_of_the_lattice_that_are_uncut(band, data):
    _, n_col, some = band
    cut = data.draw(st.lists(st.integers(0, 15), min_size=len(some), max_size=len(some)))
    row = {node: k for k, node in enumerate(some.tolist())}
    east, north = node_bands.links_between(some, np.array(cut, dtype=np.int64), n_col)
    for k, node in enumerate(some.tolist()):
        beside = row.get(node + 1, -1) if (node + 1) % n_col else -1
        assert east[k] == (-1 if cut[k] & 1 else beside)
        assert north[k] == (-1 if cut[k] & 2 else row.get(node + n_col, -1))


@given(st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), max_size=14))
def test_lines_have_every_edge_once_and_stop_only_where_they_must(pairs):
    every = sorted({(min(e), max(e)) for e in pairs if e[0] != e[1]})
    edges = np.array(every, dtype=np.int64).reshape(-1, 2)
    found = undirected_chains(edges)
    steps = [sorted(step) for line in found for step in pairwise(line)]
    assert sorted(map(tuple, steps)) == list(map(tuple, edges.tolist()))
    degree = np.bincount(edges.ravel(), minlength=7)
    for line in found:
        assert (degree[line[1:-1]] == 2).all()
        assert line[0] == line[-1] or (degree[line[[0, -1]]] != 2).all()


@given(st.permutations(range(6)), st.integers(0, 6))
def test_directed_lines_follow_their_links(onward, kept):
    tail, head = np.arange(6)[:kept], np.array(onward)[:kept]
    points, starts = link_lines.directed_lines(tail, head, 6)
    found = np.split(points, starts[1:-1]) if len(starts) > 1 else []
    links = [link for line in found for link in pairwise(line)]
    assert sorted(links) == sorted(zip(tail, head, strict=True))
    for line in found:
        assert line[0] == line[-1] or line[0] not in head[:kept]


small = st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=2, max_size=80)


@given(small, small)
def test_crossings_of_lines_are_those_of_whole_numbers(one, two):
    def pieces(line):
        points = np.array(line, dtype=float)
        return np.hstack([points[:-1], points[1:]])

    def exactly(p, q, r, s):
        d, e = (q[0] - p[0], q[1] - p[1]), (s[0] - r[0], s[1] - r[1])
        det = d[0] * e[1] - d[1] * e[0]
        if det == 0:
            return None
        x, y = r[0] - p[0], r[1] - p[1]
        return Fraction(x * e[1] - y * e[0], det), Fraction(x * d[1] - y * d[0], det)

    wanted = []
    for i in range(len(one) - 1):
        for j in range(len(two) - 1):
            met = exactly(one[i], one[i + 1], two[j], two[j + 1])
            if met and 0 <= met[0] < 1 and 0 <= met[1] < 1:
                wanted.append((float(i + met[0]), float(j + met[1])))
    found = link_lines.line_crossings(pieces(one), pieces(two))
    assert found == pytest.approx(np.array(wanted).reshape(-1, 2), abs=1e-12)


@given(st.lists(st.tuples(st.integers(0, 40), st.integers(0, 40)), min_size=2, max_size=30))
def test_distances_from_a_trace_are_those_from_all_of_its_pieces(corners):
    line = np.zeros((len(corners), 6))
    line[:, :2] = np.array(corners) + 0.25
    reach = 6.0
    near = NearTrace(frame_of(41, 41), Trace(0, line, 0.0, len(line) - 1.0), reach)
    row, col = np.divmod(np.arange(41 * 41), 41)
    best = np.full(41 * 41, np.inf)
    for a, b in zip(line[:-1, :2], line[1:, :2], strict=True):
        t = b - a
        x = np.stack([col, row], axis=1) - a
        f = np.clip(x @ t / max(float(t @ t), 1e-30), 0.0, 1.0)
        best = np.minimum(best, np.hypot(*(x - f[:, None] * t).T))
    # some are asked for, some more are found, and the rest: each is measured once
    some = np.array([-1, 40 * 41 + 3, 7, 7, 811, 0])
    rows = near.look_up(some)
    assert (rows >= 0).tolist() == [n >= 0 and bool(best[n] < reach) for n in some.tolist()]
    assert near.node[rows[rows >= 0]].tolist() == some[rows >= 0].tolist()
    assert near.nodes_within(2.47).tolist() == np.flatnonzero(best < 2.47).tolist()
    assert near.nodes_within(9.0).tolist() == np.flatnonzero(best < reach).tolist()
    assert near.look_up(some).tolist() == rows.tolist()
    assert sorted(near.node[1:].tolist()) == np.flatnonzero(best < reach).tolist()
    rows = near.within(reach)
    assert near.distance[rows] == pytest.approx(best[near.node[rows]], abs=1e-12)
    place = near.place[rows]
    at = np.stack([np.interp(place, np.arange(len(line)), c) for c in line.T[:2]], axis=1)
    there = np.stack([near.node[rows] % 41, near.node[rows] // 41], axis=1)
    assert np.hypot(*(at - there).T) == pytest.approx(near.distance[rows], abs=1e-9)


def test_throw_is_read_where_the_nearest_lines_are_met():
    x = np.linspace(0.0, 100.0, 201)
    walls = {
        "+": [np.stack([x, 0 * x + 3.0, 0.1 * x], 1), np.stack([x, 0 * x + 9.0, x], 1)],
        "-": [np.stack([x[::-1], 0 * x - 1.0, 0.1 * x[::-1] + 5.0], 1)],
    }
    stations = np.stack([np.linspace(5.0, 95.0, 40), np.zeros(40)], axis=1)
    down = np.tile([0.0, 1.0], (40, 1))
    throw, heave = profile(stations, down, walls, 12.0)
    assert throw == pytest.approx(np.full(40, 5.0))
    assert heave == pytest.approx(np.full(40, 4.0))
    assert np.isnan(profile(stations, down, walls, 2.0)[0]).all()


@given(
    st.lists(
        st.tuples(st.integers(0, 11), st.integers(0, 9), st.booleans()), min_size=1, max_size=30
    )
)
def test_means_without_some_picks_are_means_of_the_others(rows):
    node, z, out = (np.array([r[k] for r in rows]) for k in range(3))
    picks = Picks("Top", frame_of(3, 4), node.astype(np.int64), z.astype(float))
    canvas = WorkingGrid(picks)
    canvas.without(~out.astype(bool))  # and what was drawn before is taken back
    drawn = np.array([0, 3, 7])
    canvas.mark(drawn)
    canvas.values[drawn] = 99.5
    lost, heights = canvas.without(out.astype(bool)), canvas.values
    for n in range(12):
        kept = [v for m, v, gone in rows if m == n and not gone]
        assert np.isnan(heights[n]) if not kept else heights[n] == pytest.approx(np.mean(kept))
    assert lost.tolist() == sorted({m for m, _, _ in rows if np.isnan(heights[m])})
    some = np.array([1, 4, 5, 11])
    assert picks.of_nodes(some).tolist() == [k for k, m in enumerate(node) if m in some]


@given(st.lists(st.integers(1, 50), max_size=12), st.integers(0, 40))
def test_misfits_that_are_only_counted_are_zeros(values, met):
    every = np.concatenate([np.zeros(met), values])
    found = _misfit(np.array(values, dtype=float), met)
    if len(every) == 0:
        assert found == {}
        return
    assert found["mean"] == pytest.approx(every.mean())
    assert found["median"] == pytest.approx(np.median(every))
    assert found["p95"] == pytest.approx(np.percentile(every, 95))
    assert found["max"] == every.max()


@pytest.mark.parametrize(("n_row", "n_col"), [(2, 2), (8, 9), (17, 40)])
def test_bounds_of_blocks_are_those_of_their_nodes(n_row, n_col):
    grid = np.random.default_rng(4).integers(0, 99, (n_row, n_col)).astype(float)
    grid[grid < 30] = np.nan
    grid[:8, :8] = np.nan
    low, high, levels = block_bounds(grid)
    for level, (first, tall, wide) in enumerate(levels.tolist()):
        size = 8 << level
        for i in range(tall):
            for j in range(wide):
                part = grid[i * size : (i + 1) * size, j * size : (j + 1) * size]
                part = part[np.isfinite(part)]
                at = first + i * wide + j
                assert low[at] == part.min(initial=np.inf)
                assert high[at] == part.max(initial=-np.inf)
    assert tall == wide == 1


def plane_fault(s: np.ndarray) -> TriSurface:
    """A plane through (20, 20), dipping 60 degrees, with columns at some places along strike."""
    z = np.array([30.0, -30.0])[:, None]
    x = 20.0 + 0.8 * s[None, :] - z / 3.0
    y = 20.0 + 0.6 * s[None, :] + 0 * z
    points = np.stack([x, y, z + 0 * x], axis=-1).reshape(-1, 3)
    a = np.arange(len(s) - 1)
    b, c, d = a + 1, a + len(s) + 1, a + len(s)
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return TriSurface("F1", "fault", points, faces)


COLUMNS = {
    "two columns": np.array([-15.0, 15.0]),
    "even": np.linspace(-15.0, 15.0, 61),
    "one wide": np.concatenate([np.linspace(-15.0, -5.0, 41), [15.0]]),
    "steps": np.array([-15.0, -14.9, -14.0, -7.0, 0.0, 0.01, 15.0]),
}


@pytest.mark.parametrize("s", COLUMNS.values(), ids=COLUMNS)
def test_a_trace_is_one_line_on_fault_and_drape_however_wide_triangles_are(s):
    frame = frame_of(41, 41)
    x, y = np.meshgrid(np.arange(41.0), np.arange(41.0))
    drape = 3.0 * np.sin(x / 5.0) * np.cos(y / 7.0)
    mesh = mesh_in_frame(plane_fault(s), frame)
    (line,) = trace_lines(mesh, drape, np.ones(2))
    along = 0.8 * (line[:, 0] - 20.0 + line[:, 2] / 3.0) + 0.6 * (line[:, 1] - 20.0)
    assert np.abs(along[[0, -1]]) == pytest.approx([15.0, 15.0])
    across = 0.6 * (line[:, 0] - 20.0 + line[:, 2] / 3.0) - 0.8 * (line[:, 1] - 20.0)
    assert across == pytest.approx(np.zeros(len(line)), abs=1e-9)
    height = 3.0 * np.sin(line[:, 0] / 5.0) * np.cos(line[:, 1] / 7.0)
    assert np.abs(line[:, 2] - height).max() < 0.05  # the drape is linear between its nodes
    assert np.hypot(*np.diff(line[:, :2], axis=0).T).max() < 0.75
    ahead, normal = np.diff(line[:, :2], axis=0), line[1:, 3:5]
    assert (ahead[:, 0] * normal[:, 1] - ahead[:, 1] * normal[:, 0] > 0).all()


def test_a_trace_passes_where_the_drape_is_and_nowhere_else():
    frame = frame_of(41, 41)
    drape = np.zeros((41, 41))
    drape[:, 18:23] = np.nan
    mesh = mesh_in_frame(plane_fault(COLUMNS["even"]), frame)
    found = trace_lines(mesh, drape, np.ones(2))
    assert len(found) == 2
    for line in found:
        assert ((line[:, 0] <= 17.0) | (line[:, 0] >= 23.0)).all()
    assert trace_lines(mesh, drape + 100.0, np.ones(2)) == []
    assert trace_lines(mesh, np.full((41, 41), np.nan), np.ones(2)) == []


@given(st.lists(st.lists(st.integers(-5, 5), max_size=9), max_size=3), st.sets(st.integers(-5, 5)))
def test_sets_of_numbers(parts, some):
    arrays = [np.array(part, dtype=np.int64) for part in parts]
    every = [number for part in parts for number in part]
    if arrays:
        assert distinct(*arrays).tolist() == sorted(set(every))
    numbers = np.array(every, dtype=np.int64)
    found = is_among(numbers, np.array(sorted(some), dtype=np.int64))
    assert found.tolist() == [number in some for number in every]


HEIGHT = st.one_of(st.integers(-9, 9).map(float), st.just(np.nan))


@given(st.integers(1, 9), st.integers(1, 9), st.integers(1, 2), st.integers(1, 3), st.data())
def test_third_differences_never_reach_across_a_hole(n_row, n_col, step, every, data):
    cells = data.draw(st.lists(HEIGHT, min_size=n_row * n_col, max_size=n_row * n_col))
    grid = np.array(cells).reshape(n_row, n_col)
    wanted = []
    for line in (*grid[::every], *grid.T[:: every + 1]):
        for k in range(len(line) - 3 * step):
            run = line[k : k + 3 * step + 1]
            if np.isfinite(run).all():
                a, b, c, d = run[::step]
                wanted.append(abs(d - 3 * c + 3 * b - a))
    found = third_differences(grid, step, every, every + 1)
    assert sorted(found.tolist()) == sorted(wanted)  # row by row, along columns too


def bent_fault() -> FaultMesh:
    """A fault that turns and leans, 60 m tall, with rows of vertices every 15 m."""
    s, up = np.meshgrid(np.linspace(0.0, 40.0, 9), np.linspace(-30.0, 30.0, 5))
    x, y = 20.0 + 0.6 * up + 3.0 * np.sin(s / 5.0), s
    vertices = np.stack([x, y, up], axis=2).reshape(-1, 3)
    a = (np.arange(4)[:, None] * 9 + np.arange(8)).ravel()
    corners = [np.stack([a, a + 1, a + 10], 1), np.stack([a, a + 10, a + 9], 1)]
    return mesh_in_frame(
        TriSurface("F", "fault", vertices, np.concatenate(corners)), frame_of(9, 9)
    )


@pytest.mark.parametrize("levels", [(-7.0, 3.5), (-15.0, 0.0), (4.0, 4.0), (-99.0, 99.0)])
def test_what_lies_between_two_levels_is_all_that_picks_there_can_be_near(levels):
    """Levels of rows of vertices too, where a slice runs along edges."""
    rng, mesh, (low, high) = np.random.default_rng(6), bent_fault(), levels
    points = rng.uniform([-10, -5, max(low, -35)], [50, 45, min(high, 35)], (500, 3))
    points[:50, 2], points[50:100, 2] = max(low, -30.0), min(high, 30.0)
    whole = side_at_own_height(mesh, mesh_blocks(mesh, 4.0), points, 4.0)
    part, blocks = blocks_between(mesh, 4.0, low, high)
    assert (levels == (-99.0, 99.0)) == (len(part.triangles) == len(mesh.triangles))
    found = side_at_own_height(part, blocks, points, 4.0)
    assert np.array_equal(found[0], whole[0])
    assert np.array_equal(found[1], whole[1])
    assert (whole[1] != 0).sum() > 20


def test_distance_at_own_height_is_that_of_all_triangles():
    """What boxes leave out is never the nearest."""
    rng, mesh = np.random.default_rng(5), bent_fault()
    points = rng.uniform([-10, -5, -35], [50, 45, 35], (300, 3))
    far, side = side_at_own_height(mesh, mesh_blocks(mesh, 4.0), points, 4.0)
    one, every = np.zeros(300, dtype=np.int64), np.arange(len(mesh.triangles))
    plain = mesh.points[mesh.triangles].reshape(-1, 9)
    nowhere = np.tile([-np.inf, -np.inf, np.inf, np.inf], (len(every), 1))
    starts = np.array([0, len(every)])
    whole = distance_at_elevation(
        points, one, plain, nowhere, mesh.normals[:, :2], starts, every, 4.0
    )
    assert (far < 4.0).sum() > 20
    assert np.array_equal(far, whole[0])
    assert np.array_equal(side, whole[1])
