"""What is looked at once, or only near a hole, gives what looking at everything would give."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from geosurf.sheets.faults import cut_edges
from geosurf.sheets.faults.fault_distance import mesh_blocks, side_at_own_height, side_over
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.mesh.cut import _links


def squares(n):
    """A lattice of n x n squares, two triangles each."""
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    lower, upper = (a, a + 1, a + n + 2), (a, a + n + 2, a + n + 1)
    return np.concatenate([np.stack(lower, axis=1), np.stack(upper, axis=1)])


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9, 1.0])
def test_links_between_sources_alone_are_left_out(share):
    rng = np.random.default_rng(7)
    t = rng.permutation(squares(9))
    patches = SimpleNamespace(
        triangles=t, local=np.zeros((100, 3)), parent_of_triangle=rng.integers(0, 40, len(t))
    )
    fault_edges = np.sort(t[:30].min(axis=1) * 100 + t[:30].max(axis=1))
    rows, source = np.arange(len(t)), rng.random(len(t)) < share

    # as when nothing is a source: all links
    every = _links(patches, rows, fault_edges, np.zeros(len(t), dtype=bool))
    some = _links(patches, rows, fault_edges, source)
    needed = ~source[every.pairs].all(axis=1)
    kept = ~source[some.pairs].all(axis=1)
    np.testing.assert_array_equal(some.pairs[kept], every.pairs[needed])
    np.testing.assert_array_equal(some.ends[kept], every.ends[needed])
    assert len(every.pairs) > 150
    assert len(some.pairs) < len(every.pairs) or share < 0.9


def test_sides_over_one_place_are_those_of_single_points():
    rng = np.random.default_rng(5)
    uv = np.stack(np.meshgrid(np.arange(8.0), np.arange(8.0)), axis=-1).reshape(-1, 2)
    points = np.column_stack([uv[:, 0], 0.4 * uv[:, 1] + 0.3 * np.sin(uv[:, 0]), 50.0 * uv[:, 1]])
    t = squares(7)
    a, b, c = (points[t[:, k]] for k in range(3))
    mesh = FaultMesh("F1", points, t, np.cross(b - a, c - a), 50.0)
    seen = set()
    for at in rng.uniform(-1, 8, (40, 2)):
        z = rng.uniform(-20, 380, 9)
        points = np.column_stack([np.tile(at, (len(z), 1)), z])
        single = side_at_own_height(mesh, mesh_blocks(mesh, 2.5), points, 2.5)[1]
        np.testing.assert_array_equal(side_over(mesh, at, 2.5)(z), single)
        seen |= set(single.tolist())
    assert seen == {-1.0, 0.0, 1.0}


def test_four_halvings_at_once_end_where_one_after_the_other_do():
    rng = np.random.default_rng(3)
    n_call = 0
    for _ in range(50):
        height, other = rng.uniform(-2000.0, 2000.0, 2)
        change = height + rng.uniform(0.0, 1.0) * (other - height)

        def own(z, change=change, up=other > height):
            nonlocal n_call
            n_call += 1
            return ((z >= change) == up).tolist()

        found = cut_edges._between(own, height, other, 0.01)
        good, bad = other, height
        for _ in range(60):
            middle = 0.5 * (good + bad)
            good, bad = (middle, bad) if own(np.array([middle]))[0] else (good, middle)
            n_call -= 1
        assert found == good + float(np.clip(other - good, -0.02, 0.02))
    assert n_call <= 50 * 16
