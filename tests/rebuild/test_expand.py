"""Patches of lattices in full, against putting them together piece by piece."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings

from geosurf import rebuild_surfaces, synthetic, triangulate_fault, triangulate_horizon
from tests.kernels.test_strips import run_of_keys
from tests.rebuild.test_pieces import gridded_scenes


def expanded_slowly(pieces) -> dict[str, np.ndarray]:
    """Points of the triangles come first, then nodes of the lattices; triangles by key."""
    local, n = [pieces.x], len(pieces.x)
    rows = []
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        mine = np.flatnonzero(pieces.surface == i)
        t = [(pieces.key[k], 0, pieces.triangles[k], k) for k in mine.tolist()]
        if strips is not None:
            run = run_of_keys(strips.places, strips.runs)
            keys = np.flatnonzero(run >= 0)
            corners = source.corners_of_keys(keys)
            number = dict(zip(strips.nodes.tolist(), strips.points.tolist(), strict=True))
            new = [node for node in np.unique(corners).tolist() if node not in number]
            number |= {node: n + k for k, node in enumerate(new)}
            n += len(new)
            local.append(source.places_of_nodes(np.array(new, dtype=int)) - pieces.origin)
            first = len(pieces.triangles) + pieces.first_run[i]
            for key, nodes in zip(keys.tolist(), corners.tolist(), strict=True):
                t.append((key, 1, [number[node] for node in nodes], first + run[key]))
        t.sort(key=lambda row: row[:2])
        parents = source.rows_of_keys(np.array([row[0] for row in t], dtype=int))
        rows += [(i, parent, *row[2:]) for parent, row in zip(parents.tolist(), t, strict=True)]
    return {
        "local": np.concatenate(local),
        "triangles": np.array([row[2] for row in rows]),
        "surface": np.array([row[0] for row in rows]),
        "parent": np.array([row[1] for row in rows]),
        "element": np.array([row[3] for row in rows]),
    }


@settings(max_examples=100, deadline=None)
@given(gridded_scenes())
def test_law_arrays_are_those_put_together_piece_by_piece(surfaces):
    patches = rebuild_surfaces(surfaces)
    pieces, n_triangle = patches.pieces, patches.n_triangle
    assert "triangles" not in patches.__dict__  # counting lists none
    assert n_triangle == len(pieces.expanded.triangles)
    for name, slow in expanded_slowly(pieces).items():
        fast = getattr(pieces.expanded, name)
        assert not fast.flags.writeable
        assert fast.dtype == slow.dtype
        np.testing.assert_array_equal(fast, slow)


def test_corners_alone_make_no_labels():
    world = synthetic.hills(20, n_fault=9)
    surfaces = [triangulate_horizon(da, name=name) for name, da in world.horizons.items()]
    surfaces += [triangulate_fault(ds, name=name) for name, ds in world.faults.items()]
    patches = rebuild_surfaces(surfaces)
    assert patches.triangles.max() == len(patches.vertices) - 1
    assert "_labels" not in patches.pieces.expanded.__dict__
