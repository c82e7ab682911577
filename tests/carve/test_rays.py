"""Rays by floats where they are sure: as by fractions, and never all against all."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import TriSurface, build_walls, rebuild_surfaces
from geosurf.carve import outside
from geosurf.carve.cells import find_cells
from geosurf.carve.outside import NO_HIT, Rays

WALLS = (0, 10, 0, 10, -10, 0)
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def pieces(seed):
    """Tetrahedra and triangles in cells of their own, some with others inside, and walls."""
    rng = np.random.default_rng(seed)
    vertices, faces = [], []
    for cell in np.ndindex(3, 3, 3):
        if rng.random() < 0.4:
            continue
        at = np.array(cell) * 3.0 + [1, 1, -9]
        shift = 0.25 if rng.random() < 0.5 else rng.random(3) / 8
        for size in (2.0, 0.5, 0.125)[: rng.integers(1, 4)]:
            some = FACES if rng.random() < 0.6 else FACES[:1]
            faces.append(some + 4 * len(vertices))
            vertices.append((CORNERS - 0.22) * size * rng.choice([-1, 1]) + at + shift)
    return [
        TriSurface("S", "fault", np.concatenate(vertices), np.concatenate(faces)),
        *build_walls(WALLS),
    ]


def all_unsure(*given):
    """Floats that are never sure."""
    given[-1][:] = -2


@pytest.mark.parametrize("seed", range(4))
def test_cells_are_those_of_fractions(seed, monkeypatch):
    patches = rebuild_surfaces(pieces(seed))
    by_floats = find_cells(patches)
    monkeypatch.setattr(outside, "cast_rays", all_unsure)
    by_fractions = find_cells(patches)
    assert by_floats.n_cell == by_fractions.n_cell > 1
    np.testing.assert_array_equal(by_floats.cell_of_side, by_fractions.cell_of_side)


def test_floats_leave_to_fractions_what_they_cannot_tell(monkeypatch):
    """Two level triangles at one height but for the last digit, above a third."""
    high = np.nextafter(1.0, 2.0)
    corners = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0.0]])
    x = np.concatenate([corners + np.array([0, 0, z]) for z in (0, 1, high)])
    asked, exactly = [], Rays._exactly
    monkeypatch.setattr(
        Rays, "_exactly", lambda self, *given: asked.append(given[0]) or exactly(self, *given)
    )
    found = Rays(x, np.arange(9).reshape(3, 3)).shoot(np.arange(3), np.arange(3))
    assert found.tolist() == [[0, 3], [2, 5], [4, NO_HIT]]
    assert asked == [0, 1, 2]


def test_what_is_not_seen_holds_nothing():
    corners = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0.0]])
    x = np.concatenate([corners + np.array([0, 0, z]) for z in range(3)])
    shots = Rays(x, np.arange(9).reshape(3, 3)), np.array([0]), np.arange(3)
    assert shots[0].shoot(*shots[1:]).tolist() == [[0, 3]]
    hidden = np.array([False, False, True])
    assert shots[0].shoot(*shots[1:], hidden).tolist() == [[0, 5]]
