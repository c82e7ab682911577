"""Where the exact result cannot be held, or the box is open: a sentence, a place, the surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.conventions import place
from geosurf.errors import OpenUnitError, RoundingError
from geosurf.rebuild import repair
from tests.strategies import BOX, grid, sheet


@pytest.mark.parametrize("turned", [False, True])
def test_round_inputs_that_no_step_moves_are_shifted(turned):
    """Two faults cross half way up a wall, on its diagonal but for the rounding of its corners."""
    box, ring = (0, 8, 0, 8, 0, 8), [(0.3, 0.1), (7.7, 0.4), (7.9, 7.7), (0.6, 7.8)]
    one = sheet("F1", [(-1, -1, 9), (9, -1, -1), (9, 9, -1), (-1, 9, 9)])
    two = sheet("F2", [(-1, -1, -1), (9, -1, 9), (9, 9, 9), (-1, 9, -1)])
    walls = build_walls(box, ring)
    faults = [two, one] if turned else [one, two]
    patches = rebuild_surfaces([*faults, *walls])
    assert patches.report["moved_vertices"] > 0
    assert 0 < patches.report["largest_move"] <= np.sqrt(3) * 1.5 * repair.SHIFT
    units = carve_units(patches)
    assert all(check.passed for check in certify(patches, units).checks)
    x, y = np.array(ring).T
    area = 0.5 * np.abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert sum(unit.volume for unit in units.values()) == pytest.approx(8 * area, rel=1e-12)
    volumes = [units[f"box {block}"].volume for block in ("F1+ F2+", "F1- F2-")]
    assert volumes == pytest.approx([2 * area] * 2, rel=0.2)
    for name, fault in (("F1", one), ("F2", two)):  # as far as it says, whatever the order
        used = next(s for s in patches.sources if s.name == name)
        far = np.linalg.norm(used.vertices - fault.vertices, axis=1)
        assert far.max() <= patches.report["largest_move"]


def test_a_result_that_cannot_be_held_is_refused_with_its_place(monkeypatch):
    """Steps too fine to help: the fault through horizon nodes at rounded thirds stays as it is."""
    monkeypatch.setattr(repair, "STEPS", (2.0**-60,))
    monkeypatch.setattr(repair, "SHIFT", 2.0**-60)
    top = grid("Top", np.random.default_rng(3).integers(0, 4, (6, 6)))
    wall = sheet("F1", [(1, -1, -1), (3, 9, -1), (3, 9, 5), (1, -1, 5)], (3, 3))
    words = r"float64 cannot represent .*, the first of surface '\w+' at \(E .*Move one of"
    with pytest.raises(RoundingError, match=words) as caught:
        rebuild_surfaces([top, wall])
    assert set(caught.value.surfaces) == {"Top", "F1"}
    assert caught.value.surfaces[0] in str(caught.value)
    assert place(caught.value.place) in str(caught.value)
    corners = np.concatenate([top.vertices, wall.vertices])
    assert (corners == caught.value.place).all(axis=1).any()


def test_a_box_without_a_side_is_open_at_a_place():
    box = np.reshape(BOX, (3, 2))
    walls = build_walls(BOX)
    middle = box.mean(axis=1)
    top = TriSurface(
        "Top", "horizon",
        [(x, y, middle[2]) for x in (box[0] + [-1, 1]) for y in (box[1] + [-1, 1])],
        [(0, 2, 1), (1, 2, 3)],
    )  # fmt: skip
    with pytest.raises(OpenUnitError, match=r"model are open: wall '.*' has .* at \(E") as caught:
        carve_units(rebuild_surfaces([top, *walls[1:]]))
    (name,) = caught.value.surfaces
    assert name in {wall.name for wall in walls[1:]}
    place = np.array(caught.value.place)
    assert ((box[:, 0] <= place) & (place <= box[:, 1])).all()
    assert np.isin(place, box).any()  # on a side
