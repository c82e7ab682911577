"""Many segments of one face in one point: inside it, on its edge, in its corner."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import TriSurface, rebuild_surfaces
from tests import laws
from tests.rebuild.test_patches import assert_true
from tests.strategies import shuffled

FACE = TriSurface("Face", "horizon", [[0, 0, 0], [48, 0, 0], [0, 48, 0]], [[0, 1, 2]])
WAYS = [(3, 0), (2, 1), (1, 2), (0, 3), (-1, 2), (-2, 1), (3, 1), (-3, 2)]


def ending(at) -> TriSurface:
    """Sheets that hang together in the upright edge through a point."""
    x, y = at
    rim = [[x + 2 * u, y + 2 * v, 0] for u, v in WAYS] + [
        [x - 2 * u, y - 2 * v, 0] for u, v in WAYS
    ]
    fan = [[0, 1, 2 + i] for i in range(len(rim))]
    return TriSurface("Fan", "fault", [[x, y, -1], [x, y, 1], *rim], fan)


def passing(at) -> list[TriSurface]:
    """Sheets that pass through the upright line of a point."""
    x, y = at
    return [
        TriSurface(
            f"F{i}", "fault",
            [[x - 2 * u, y - 2 * v, -1], [x + 2 * u, y + 2 * v, -1], [x, y, 1]], [[0, 1, 2]],
        )
        for i, (u, v) in enumerate(WAYS)
    ]  # fmt: skip


def parts_of_edges(patches, name) -> set:
    piece = patches.surface(name)
    t = piece.triangles
    edges = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    return {frozenset(map(tuple, piece.vertices[edge].tolist())) for edge in edges}


@pytest.mark.parametrize("at", [(12, 12), (24, 0), (0, 0), (24, 24)])
def test_segments_that_end_in_one_point(at):
    patches = assert_true([FACE, ending(at)], exact=at == (0, 0))
    hub = (*map(float, at), 0.0)
    edges = parts_of_edges(patches, "Face")
    for x, y, _ in ending(at).vertices[2:]:
        if x >= 0 and y >= 0 and x + y <= 48:
            assert frozenset((hub, (x, y, 0.0))) in edges


@pytest.mark.parametrize("at", [(12, 12), (24, 0), (0, 0)])
def test_segments_that_pass_through_one_point(at):
    surfaces = [FACE, *passing(at)]
    patches = assert_true(surfaces, exact=at == (12, 12))
    hub = (*map(float, at), 0.0)
    edges = parts_of_edges(patches, "Face")
    for u, v in WAYS:
        for way in (1, -1):
            x, y = at[0] + way * u, at[1] + way * v
            if x >= 0 and y >= 0:
                assert frozenset((hub, (float(x), float(y), 0.0))) in edges
    rng = np.random.default_rng(5)
    again = rebuild_surfaces([shuffled(s, rng) for s in surfaces[::-1]])
    laws.assert_same_patches(patches, again)
    assert (patches.surface("Face").vertices == hub).all(axis=1).sum() == 1
    assert len(np.unique(patches.local, axis=0)) == len(patches.local)
