"""What scenes of one family remember: whatever input differs, each is the scene made afresh."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf import Lattice, Scene, TriSurface
from geosurf.scene.memory import Memory, fingerprint
from tests import laws
from tests.strategies import BOX, sheet

AXIS = np.array([-1.0, 1.0, 3.0, 5.0])
STEPS = np.array([[1.0, 2, 0, 1], [2, 1, 1, 0], [0, 1, 2, 2], [1, 0, 2, 1]])


def array(values=STEPS, **attrs):
    return xr.DataArray(
        np.array(values), dims=("northing", "easting"), coords={"northing": AXIS, "easting": AXIS},
        attrs=attrs,
    )  # fmt: skip


def lattice(rising=True, reverse=False, step=0.0):
    return TriSurface("Top", "horizon", lattice=Lattice(AXIS, AXIS, STEPS + step, rising, reverse))


def wall():
    return sheet("F1", [(1.5, -1, -5), (1.5, 5, -5), (1.5, 5, 9), (1.5, -1, 9)])


# two horizons that differ in one thing only, which is what their names are
PAIRS = {
    "heights": (array(), array(STEPS + 1.0)),
    "unit of the heights": (array(units="m"), array(units="ft")),
    "what is up": (array(positive="up"), array(positive="down")),
    "an axis": (array(), array().assign_coords(easting=AXIS + 0.5)),
    "heights of a lattice": (lattice(), lattice(step=0.5)),
    "diagonals of a lattice": (lattice(), lattice(rising=False)),
}  # fmt: skip


def seen(scene):
    """Heights, curves and volumes of a scene."""
    volumes = {name: unit.volume for name, unit in scene.units.items()}
    return scene.surface("Top").vertices.tobytes(), laws.curve_bytes(scene.curves), volumes


@pytest.mark.parametrize("kind", PAIRS)
def test_horizons_that_differ_in_one_thing(kind):
    one, two = PAIRS[kind]
    words = {"positive": None if kind == "what is up" else "up", "length_unit": "m"}
    words["length_unit"] = None if kind == "unit of the heights" else "m"
    family = Scene({"Top": one}, {"F1": wall()}, BOX, **words)
    found = [seen(family.replace(horizons={"Top": top})) for top in (one, two, one)]
    assert found[1] == seen(Scene({"Top": two}, {"F1": wall()}, BOX, **words))
    assert found[0] == found[2] != found[1]


def test_areas_with_the_same_bounds():
    """The box around them is one; half of it is in either area."""
    areas = [(0, 0), (4, 0), (0, 4)], [(4, 0), (4, 4), (0, 4)], None
    family = Scene({"Top": array()}, {"F1": wall()}, BOX, positive="up", length_unit="m")
    found = [seen(family.replace(aoi=aoi)) for aoi in areas]
    for aoi, one in zip(areas, found, strict=True):
        again = Scene(
            {"Top": array()}, {"F1": wall()}, BOX, aoi=aoi, positive="up", length_unit="m"
        )
        assert one == seen(again)
    halves = [sum(volumes.values()) for *_, volumes in found]
    assert halves == pytest.approx([96.0, 96.0, 192.0])
    assert found[0][2] != found[1][2]


def test_boxes_with_frames_of_their_own():
    """Points are rounded in the frame of the box; curves of another one are not handed on."""
    axis = np.arange(900.0, 3200.0, 200.0) + 0.125
    heights = np.sin(axis / 300.0)[:, None] * np.cos(axis / 200.0) * 70.0
    top = TriSurface("Top", "horizon", lattice=Lattice(axis, axis, heights))
    corners = [(2011, 0, -500), (2011, 4000, -500), (2407, 4000, 500), (2407, 0, 500)]
    fault = sheet("F1", corners)
    boxes = (1000.0, 2900.0, 1000.0, 2900.0, -300, 300), (2100.0, 2900.0, 2100.0, 2900.0, -300, 300)
    family = Scene({"Top": top}, {"F1": fault}, boxes[0])
    curves = [family.replace(box=box).curves for box in boxes]
    assert [c.origin.tolist() for c in curves] == [[0.0, 0, 0], [2048.0, 2048, 0]]
    for box, found in zip(boxes, curves, strict=True):
        fresh = Scene({"Top": top}, {"F1": fault}, box).curves
        assert laws.curve_bytes(found) == laws.curve_bytes(fresh)
    assert (curves[0].points != curves[1].points).any()


def test_a_file_that_was_written_anew_is_read_anew(tmp_path):
    """By the scenes made after that; the others stand for what they found."""
    path = tmp_path / "Top.nc"
    words = {"positive": "up", "units": "m"}
    gs.write(array(**words), path)
    first = Scene({"Top": path}, {"F1": wall()}, BOX)
    before = seen(first)
    gs.write(array(STEPS + 1.0, **words), path)
    after = seen(first.replace(horizons={"Top": path}))
    assert after == seen(Scene({"Top": array(STEPS + 1.0, **words)}, {"F1": wall()}, BOX))
    assert seen(first) == before != after


def test_what_counts_by_its_identity_is_held():
    """Another thing may get the number of one that is gone, and be taken for it."""

    class Stranger:
        """Nothing that a fingerprint knows."""

    memory, one = Memory(), Stranger()
    memory.hold([one])
    alive = weakref.ref(one)
    del one
    gc.collect()
    assert alive() is not None
    memory.store.held.clear()
    gc.collect()
    assert alive() is None
    keys = [memory.key_of(lattice(step=float(k))) for k in range(40)]  # each dies at once, or not
    assert len(set(keys)) == 40


def test_fingerprints_of_large_arrays_know_every_number():
    """Arrays from 1 MB on are shortened: lanes of 2048 numbers, and what is left over."""
    rng = np.random.default_rng(0)
    plain = rng.normal(0.0, 1.0, 8192 * 17 + 5)
    known = {fingerprint(plain)}

    def is_new(changed):
        known.add(fingerprint(changed))
        return len(known)

    # one number, first, last, left over; two of one lane, by the same difference; signs of all
    cases = [[0], [8192 * 17 - 1], [8192 * 17 + 4], [77, 77 + 2048], [77, 77 + 5 * 2048]]
    for size, where in enumerate([*cases, *rng.integers(0, len(plain), (40, 1)).tolist()], 2):
        changed = plain.copy()
        changed[where] = -changed[where]
        assert is_new(changed) == size
    n = len(known)
    others = [-plain, -np.abs(plain), plain + 1.0, plain[::-1], np.roll(plain, 2048), plain[:-1]]
    for k, other in enumerate([*others, plain.view(np.int64), plain.reshape(1, -1)], n + 1):
        assert is_new(other) == k
    assert is_new(plain.copy()) == len(known)

    # zeros swallow nothing
    assert fingerprint(np.zeros(2**17)) != fingerprint(np.zeros(2**17 + 1))
    flat = np.zeros(2**18)
    flat[[5, 5 + 2048]] = np.nan
    assert fingerprint(flat) != fingerprint(np.zeros(2**18))


def test_fingerprints_know_shapes_masks_and_turns():
    square, row = np.zeros((2, 2)), np.zeros((1, 4))
    assert fingerprint(square) != fingerprint(row) != fingerprint(row.view(np.int64))
    masks = [np.ma.array(row, mask=row > limit) for limit in (-1, 1)]
    assert fingerprint(masks[0]) != fingerprint(masks[1]) != fingerprint(row)
    assert fingerprint(lattice()) != fingerprint(lattice(reverse=True))
    assert fingerprint(lattice()) == fingerprint(lattice())
