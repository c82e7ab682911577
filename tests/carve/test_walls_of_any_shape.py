"""Closed shells of any shape as the walls of a model: slanting, turned, re-entrant, several."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.carve.outside import NO_HIT, Rays
from geosurf.errors import OpenUnitError
from tests import oracles

SIDES = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5],
         [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]]  # fmt: skip
HEXAHEDRON = [[0, 0, 0], [10, 0, -1], [10, 10, -2], [0, 10, -1], [0, 0, 10], [10, 0, 11],
              [10, 10, 12], [0, 10, 11]]  # fmt: skip
BOX = [[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0], [0, 0, 9], [9, 0, 9], [9, 9, 9], [0, 9, 9]]
# three edges of length 3 that are square to each other, on whole numbers
TURN = np.array([[2, 2, -1], [-1, 2, 2], [2, -1, 2]], dtype=float)
TETRAHEDRON = (
    [[0, 0, 0], [9, 1, 2], [1, 9, 3], [2, 3, 10]],
    [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
)


def corner():
    """An L over a step, leaning: re-entrant from above and from the side."""
    ring = np.array([(0, 0), (8, 0), (8, 3), (4, 4), (3, 8), (0, 8)], dtype=float)
    n = len(ring)
    low = np.column_stack([ring, 0.25 * ring[:, 0]])
    high = np.column_stack([np.add(ring, (5, 0)), 8 - 0.25 * ring[:, 1]])
    fan = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [t[::-1] for t in fan] + [tuple(n + k for k in t) for t in fan]
    for k in range(n):
        a, b = k, (k + 1) % n
        faces += [(a, b, b + n), (a, b + n, a + n)]
    return np.concatenate([low, high]), np.array(faces)


SHAPES = {
    "slanting": [(HEXAHEDRON, SIDES)],
    "tetrahedron": [TETRAHEDRON],
    "turned box": [(np.array(BOX) @ TURN / 3, SIDES)],
    "leaning L": [corner()],
    "two beside each other": [(HEXAHEDRON, SIDES), (np.add(HEXAHEDRON, [20, 3, 1]), SIDES)],
    "two with a face in common": [(BOX, SIDES), (np.add(BOX, [9, 0, 0]), SIDES)],
    "two with an edge in common": [(BOX, SIDES), (np.add(BOX, [9, 9, 0]), SIDES)],
    "one in another": [(HEXAHEDRON, SIDES), (np.array(BOX) * 0.5 + [2, 2, 2], SIDES)],
    "three nested": [
        (HEXAHEDRON, SIDES),
        (np.array(BOX) * 0.5 + [2, 2, 2], SIDES),
        (np.array(TETRAHEDRON[0]) * 0.25 + [3, 3, 3], TETRAHEDRON[1]),
    ],
    "one in a box": [(BOX, SIDES), (np.array(HEXAHEDRON) * 0.25 + [2, 2, 2], SIDES)],
}
NESTED = ("one in another", "three nested", "one in a box")


def shells(shape, rng, one_surface=False):
    """The walls, with triangles turned at random, and the exact volume inside."""
    walls, volumes = [], []
    for k, (points, faces) in enumerate(SHAPES[shape]):
        faces = np.array(faces)
        volumes.append(float(abs(oracles.volume(np.array(points, dtype=float), faces))))
        back = rng.random(len(faces)) < 0.5
        faces[back] = faces[back][:, ::-1]
        walls.append(TriSurface(f"hull {k}", "wall", np.array(points, dtype=float), faces))
    if one_surface:
        points = np.concatenate([w.vertices for w in walls])
        first = np.cumsum([0] + [w.n_vertex for w in walls])
        faces = np.concatenate([w.triangles + n for w, n in zip(walls, first, strict=False)])
        walls = [TriSurface("hull", "wall", points, faces)]
    return walls, volumes[0] if shape in NESTED else sum(volumes)


def level(name, z):
    corners = [[-9, -9, z], [40, -9, z], [40, 40, z], [-9, 40, z]]
    return TriSurface(name, "horizon", np.array(corners, dtype=float), [[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize("one_surface", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
def test_units_fill_shells_of_any_shape(shape, one_surface, rng):
    walls, volume = shells(shape, rng, one_surface)
    low, high = (np.concatenate([w.vertices for w in walls])[:, 2].min(), 3.25)
    horizons = [level("Top", high), level("Base", 0.5 * (low + high))]
    for surfaces in ([*horizons, *walls], [*walls[::-1], *horizons]):
        patches = rebuild_surfaces(surfaces)
        units = carve_units(patches)
        assert units.volume == pytest.approx(volume, rel=1e-12)
        assert units.box_volume == pytest.approx(volume, rel=1e-12)
        assert {u.zone for u in units.values()} == {"above Top", "Top/Base", "below Base"}
        assert certify(patches, units).ok
        inside = patches.triangles[(units.sides >= 0).any(axis=1)]
        assert units.report["cells"] == oracles.n_cell(inside)


@pytest.mark.parametrize("shape", [s for s in SHAPES if s not in NESTED])
def test_shells_with_a_hole_are_refused_at_the_hole(shape, rng):
    walls, _ = shells(shape, rng)
    first = walls[0]
    for row in (0, first.n_triangle - 1):
        faces = np.delete(first.triangles, row, axis=0)
        holed = TriSurface(first.name, "wall", first.vertices, faces)
        with pytest.raises(OpenUnitError, match="walls of the model are open") as caught:
            carve_units(rebuild_surfaces([level("Top", 3.25), holed, *walls[1:]]))
        low, high = holed.vertices.min(axis=0), holed.vertices.max(axis=0)
        assert (low <= caught.value.place).all()
        assert (caught.value.place <= high).all()


# ---- Pieces that touch nothing else are in the cell around them.
WALLS = (0, 10, 0, 10, -10, 0)
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


@pytest.mark.parametrize("seed", range(4))
def test_law_units_of_floating_pieces_have_the_volumes_between_them(seed):
    """Tetrahedra and triangles in cells of their own, some with others inside."""
    rng = np.random.default_rng(seed)
    vertices, faces, volumes = [], [], [1000.0]
    for cell in np.ndindex(3, 3, 3):
        if rng.random() < 0.4:
            continue
        at = np.array(cell) * 3.0 + [1.5, 1.5, -8.5]
        shift = 0.25 if rng.random() < 0.5 else rng.random(3) / 8
        around = 0  # the unit that holds the next one
        for size in (1.6, 0.4, 0.1)[: rng.integers(1, 4)]:
            closed = rng.random() < 0.6
            faces.append((FACES if closed else FACES[:1]) + 4 * len(vertices))
            vertices.append((CORNERS - 0.22) * size * rng.choice([-1, 1]) + at + shift)
            if closed:
                volumes.append(size**3 / 6)
                volumes[around] -= volumes[-1]
                around = len(volumes) - 1
    fault = TriSurface("S", "fault", np.concatenate(vertices), np.concatenate(faces))
    patches = rebuild_surfaces([fault, *build_walls(WALLS)])
    units = carve_units(patches)
    assert sorted(u.volume for u in units.values()) == pytest.approx(sorted(volumes), rel=1e-9)
    assert certify(patches, units).ok


def test_rays_tell_heights_apart_that_differ_in_the_last_digit():
    """Two level triangles at one height but for the last digit, above a third."""
    high = np.nextafter(1.0, 2.0)
    corners = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0.0]])
    x = np.concatenate([corners + np.array([0, 0, z]) for z in (0, 1, high)])
    found = Rays(x, np.arange(9).reshape(3, 3)).shoot(np.arange(3), np.arange(3))
    assert found.tolist() == [[0, 3], [2, 5], [4, NO_HIT]]
