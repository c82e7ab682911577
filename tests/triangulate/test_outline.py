"""An area of interest: walls along a polygon, exact, and refused where it meets itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf import Scene, build_walls, carve_units, rebuild_surfaces
from geosurf.errors import InputError, OpenUnitError
from geosurf.triangulate.outline import check_outline, signed_area, triangulate_ring
from tests import laws
from tests.grids import ring_area
from tests.strategies import BOX, grid, sheet

ELL = [(0, 0), (4, 0), (4, 1), (2, 1), (2, 4), (0, 4)]


def level(name, z):
    return grid(name, np.full((4, 4), float(z)), spacing=2.0, corner=(-1.0, -1.0))


def carve(surfaces, aoi, box=BOX):
    return laws.carved(surfaces, aoi, box)


# --------------------------------------------------------------------------- volumes


def test_a_concave_area_parts_blocks_that_only_touch_outside():
    """A U around a notch: the fault cuts both legs, beyond which nothing joins their tops."""
    ring = [(0, 0), (4, 0), (4, 4), (3, 4), (3, 1), (1, 1), (1, 4), (0, 4)]
    fault = sheet("F1", [(-1, 2, -5), (5, 2, -5), (5, 2, 9), (-1, 2, 9)])
    units = carve([level("Top", 2), fault], ring)
    found = {u.block: u.volume for u in units.values() if u.zone_index == 0}
    # the normal of F1 points south; of the two legs to the north the western one comes first
    assert found == pytest.approx({"F1+": 6 * 6.0, "F1-": 12.0, "F1- #2": 12.0})
    assert units["above Top", "F1-"].local[:, 0].max() == 1.0


@st.composite
def stars(draw):
    """Simple polygons with corners on whole numbers or anywhere, seen from the middle."""
    n = draw(st.integers(3, 9))
    radius = draw(st.lists(st.floats(0.4, 1.9), min_size=n, max_size=n))
    shift = draw(st.floats(0, 1))
    angle = 2 * np.pi * (np.arange(n) + shift) / n
    ring = 2 + np.array(radius)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return ring if draw(st.booleans()) else np.round(ring * 8) / 8


@given(stars())
def test_units_fill_any_polygon(ring):
    z = np.arange(16).reshape(4, 4) % 5 * 1.0
    units = carve([grid("Top", z, spacing=2.0, corner=(-1.0, -1.0)), level("Base", -1)], ring)
    assert units.volume == pytest.approx(12 * abs(ring_area(ring)), rel=1e-12)
    assert units["below Base"].volume == pytest.approx(3 * abs(ring_area(ring)), rel=1e-12)


def test_a_scene_with_an_area():
    slope = grid("Top", [[0, 6], [0, 6]], spacing=6.0, corner=(-1.0, -1.0))
    scene = Scene({"Top": slope}, aoi=ELL)
    assert scene.box[:4] == (0.0, 4.0, 0.0, 4.0)
    assert scene.box[4] < 0.0 < 6.0 < scene.box[5]
    assert scene.units.footprint == 10.0
    inside = Scene({"Top": slope}, box=(-1, 5, -1, 5, -2, 8), aoi=ELL)
    assert inside.box == (0.0, 4.0, 0.0, 4.0, -2.0, 8.0)
    assert inside.units["below Top"].volume == pytest.approx(14 + 10 * 3, rel=1e-12)
    assert "area" in scene.explain()
    assert inside.replace(aoi=None).units.box_volume == 360.0


def test_open_fences_are_refused():
    for k in (1, 2):
        walls = [w for i, w in enumerate(build_walls(BOX, ELL)) if i != k]
        with pytest.raises(OpenUnitError, match=r"walls of the model are open.*build_walls\(box, "):
            carve_units(rebuild_surfaces([level("Top", 3), *walls]))


# ------------------------------------------------------------------- the ring itself
@given(stars(), st.integers(0, 8), st.booleans())
def test_where_a_ring_starts_and_how_it_turns_changes_nothing(ring, start, back):
    other = np.roll(ring, start, axis=0)
    other = other[::-1] if back else other
    np.testing.assert_array_equal(check_outline(other), check_outline(ring))
    closed = np.concatenate([other, other[:1]])
    np.testing.assert_array_equal(check_outline(closed), check_outline(ring))
    checked = check_outline(ring)
    faces = triangulate_ring(checked)
    assert faces.shape == (len(ring) - 2, 3)
    areas = [signed_area(checked[face]) for face in faces]
    assert min(areas) > 0
    assert math.fsum(areas) == pytest.approx(abs(ring_area(ring)), rel=1e-12)


@pytest.mark.parametrize(
    ("aoi", "words"),
    [
        (
            [(0, 0), (4, 4), (4, 0), (0, 4)],
            r"at \(E 2, N 2\), where side 0 and side 2 .* cross or touch",
        ),
        ([(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)], r"N 0\), where side 0 and side 2"),
        ([(0, 0), (4, 0), (2, 2), (4, 4), (0, 4), (2, 2)], r"E 2, N 2"),
        ([(0, 0), (4, 0), (2, 0), (2, 2)], r"side 0 and side 1 .* fold back"),
        ([(0, 0), (1, 1), (2, 2)], r"fold back"),
        (
            [(0, 0), (9, 0), (0, 4)],
            r"corner \(E 9, N 0\) lies beyond the east of the box \(4",
        ),
    ],
)  # fmt: skip
def test_refusals(aoi, words):
    with pytest.raises(InputError, match=words):
        Scene({"Top": level("Top", 3)}, box=BOX, aoi=aoi).units  # noqa: B018
