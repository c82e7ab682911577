"""Triangles that cut links divide, steps that no link parts, and boxes by blocks: by definition."""

from itertools import product

import numpy as np
import pytest

from geosurf.kernels.sheets.node_bands import boxes_in_blocks
from geosurf.kernels.sheets.torn_links import divided_triangles, triangles_beside, uncut_steps

N_ROW, N_COL = 5, 6


def triangles_of(rising, present):
    """Nodes of each triangle that exists, by number."""
    found = {}
    for row, col in product(range(N_ROW - 1), range(N_COL - 1)):
        a = row * N_COL + col
        b, c, d = a + 1, a + N_COL + 1, a + N_COL
        halves = ((a, b, c), (a, c, d)) if rising else ((a, b, d), (b, c, d))
        for half, corners in enumerate(halves):
            if all(present[node] for node in corners):
                found[2 * a + half] = corners
    return found


def name_of(one, two):
    """The link between two nodes as one number."""
    (y, x), (v, u) = sorted((divmod(one, N_COL), divmod(two, N_COL)))
    kind = {(0, 1): 0, (1, 0): 1, (1, 1): 2, (1, -1): 3}[v - y, u - x]
    return 4 * (y * N_COL + x - (kind == 3)) + kind


@pytest.mark.parametrize("rising", [True, False])
def test_a_copy_for_each_fragment_of_a_divided_triangle(rising):
    seen = set()
    for seed in range(30):
        rng = np.random.default_rng(seed)
        present = rng.random(N_ROW * N_COL) < 0.95
        triangles = triangles_of(rising, present)
        edges = {t: [(c[k], c[(k + 1) % 3]) for k in range(3)] for t, c in triangles.items()}
        names = sorted({name_of(*edge) for some in edges.values() for edge in some})
        cut = np.array([name for name in names if rng.random() < 0.4], dtype=np.int64)
        links = set(cut.tolist())
        beside = {t for t, some in edges.items() if links & {name_of(*edge) for edge in some}}
        lattice = rising, present, N_ROW, N_COL
        near = triangles_beside(cut, *lattice)
        assert set(near.tolist()) == beside

        expected = []
        for t in sorted(beside):
            whole = [edge for edge in edges[t] if name_of(*edge) not in links]
            if len(whole) > 1:
                continue
            parts = {frozenset([node]) for node in triangles[t]}
            for edge in whole:
                parts = {part for part in parts if not part & {*edge}} | {frozenset(edge)}
            seen.add(len(parts))
            real = sorted([node in part for node in triangles[t]] for part in parts)
            over = [
                next((s for s, some in edges.items() if s != t and {*edge} <= {*sum(some, ())}), -1)
                for edge in edges[t]
            ]
            expected += [(t, [*triangles[t]], own, over) for own in real]
        found = divided_triangles(np.unique(near), cut, *lattice)
        triangle, corners, real, across, exists = (one.tolist() for one in found)
        over = [
            [t if there else -1 for t, there in zip(*both, strict=True)]
            for both in zip(across, exists, strict=True)
        ]
        assert list(zip(triangle, corners, real, over, strict=True)) == expected
    assert seen == {2, 3}


def test_steps_between_walls_that_no_link_parts():
    rng = np.random.default_rng(0)
    walls = (rng.random((2, N_ROW * N_COL)) < 0.5).astype(float)
    links = np.flatnonzero(rng.random(4 * N_ROW * N_COL) < 0.4)
    node, kind = np.divmod(rng.permutation(links), 4)
    for side, found in enumerate(uncut_steps(walls, node, kind, N_ROW, N_COL)):
        step = (1, N_COL)[side]
        expected = [
            [a, a + step]
            for a in range(N_ROW * N_COL)
            if (a % N_COL < N_COL - 1, a < (N_ROW - 1) * N_COL)[side]
            and (walls[:, a] != walls[:, a + step]).any()
            and 4 * a + side not in links
        ]
        assert found.tolist() == expected
        assert expected


def test_boxes_are_listed_by_the_blocks_that_they_reach():
    rng = np.random.default_rng(1)
    low = rng.uniform(-20.0, 30.0, (40, 2))
    high = low + rng.uniform(0.0, 9.0, (40, 2))
    corner, shape, items, starts = boxes_in_blocks(low, high, 1.5, 4.0)
    assert len(starts) == shape.prod() + 1
    for y, x in product(range(shape[1]), range(shape[0])):
        first = 4.0 * (corner + np.array([x, y]))
        last = first + 4.0
        near = ((low - 1.5 < last) & (high + 1.5 >= first)).all(axis=1)
        at = y * shape[0] + x
        assert items[starts[at] : starts[at + 1]].tolist() == np.flatnonzero(near).tolist()
    for bad in (np.nan, np.inf):
        with pytest.raises(ValueError, match="no size"):
            boxes_in_blocks(low, np.where(high == high[3], bad, high), 1.5, 4.0)
    with pytest.raises(ValueError, match="no boxes"):
        boxes_in_blocks(low[:0], high[:0], 1.5, 4.0)
