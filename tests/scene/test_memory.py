"""What scenes of one family remember and share: as made afresh, and within its budget."""

from __future__ import annotations

import gc
import random
from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf import FaultSticks, Lattice, Scene, TriSurface
from geosurf.errors import InputError
from geosurf.scene.memory import CHOICE, Store, budget_of_family, buffers_of, fingerprint
from tests import laws
from tests.grids import gridded
from tests.messages import refused
from tests.scene.conftest import level, upright
from tests.strategies import BOX

AXIS = np.array([-1.0, 1.0, 3.0, 5.0])
STEPS = np.array([[1.0, 2, 0, 1], [2, 1, 1, 0], [0, 1, 2, 2], [1, 0, 2, 1]])


def array(values=STEPS, **attrs):
    return gridded(np.array(values), AXIS).drop_attrs().assign_attrs(attrs)


def lattice(rising=True, reverse=False, step=0.0):
    return TriSurface("Top", "horizon", lattice=Lattice(AXIS, AXIS, STEPS + step, rising, reverse))


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
    """Heights, curves, maps and volumes of a scene."""
    volumes = {name: unit.volume for name, unit in scene.units.items()}
    zones = [zone for zone in scene.reservoir if "/" in zone]
    maps = [scene.thickness(zone, 500.0).values.tobytes() for zone in zones]
    return scene.surface("Top").vertices.tobytes(), laws.curve_bytes(scene.curves), *maps, volumes


def test_areas_with_the_same_bounds():
    """The box around them is one; half of it is in either area."""
    areas = [(0, 0), (4, 0), (0, 4)], [(4, 0), (4, 4), (0, 4)], None
    family = Scene({"Top": array()}, {"F1": upright(1.5)}, BOX, positive="up", length_unit="m")
    found = [seen(family.replace(aoi=aoi)) for aoi in areas]
    for aoi, one in zip(areas, found, strict=True):
        again = Scene(
            {"Top": array()}, {"F1": upright(1.5)}, BOX, aoi=aoi, positive="up", length_unit="m"
        )
        assert one == seen(again)
    halves = [sum(volumes.values()) for *_, volumes in found]
    assert halves == pytest.approx([96.0, 96.0, 192.0])
    assert found[0][2] != found[1][2]


def test_a_file_that_was_written_anew_is_read_anew(tmp_path):
    """By the scenes made after that; the others stand for what they found."""
    path = tmp_path / "Top.nc"
    words = {"positive": "up", "units": "m"}
    gs.write(array(**words), path)
    first = Scene({"Top": path}, {"F1": upright(1.5)}, BOX)
    before = seen(first)
    gs.write(array(STEPS + 1.0, **words), path)
    after = seen(first.replace(horizons={"Top": path}))
    assert after == seen(Scene({"Top": array(STEPS + 1.0, **words)}, {"F1": upright(1.5)}, BOX))
    assert seen(first) == before != after


# ---- Which inputs count as the same, and which do not: of some, one was once taken for the other.
SQUARE, ROW = np.zeros((2, 2)), np.zeros((1, 4))
QUAD = np.array([(1.0, -1, 9), (1, -1, -5), (1, 5, 9), (1, 5, -5)])
FACES = [(0, 1, 2), (1, 3, 2)]
LINE = np.vstack([QUAD[:2], QUAD[:1] + 3.0, QUAD[2:]])
MAP = gridded(SQUARE, [0.0, 9.0])


def linear(rate):
    """A throw of a class whose code geosurf does not know: cells of notebooks define it again."""

    @dataclass
    class Linear:
        rate: float

        def __call__(self, along):
            return self.rate * along

    return Linear(rate)


DIFFERENT = PAIRS | {
    "classes of one name": (linear(1.0), linear(1.0)),
    "numbers that follow each other": ([1.0, 23.0], [1.02, 3.0]),
    "shapes": (SQUARE, ROW),
    "types": (ROW, ROW.view(np.int64)),
    "masks": [np.ma.array(ROW, mask=limit < ROW) for limit in (-1, 1)],
    "a mask and none": (np.ma.array(ROW, mask=ROW > 1), ROW),
    "turns": (lattice(), lattice(reverse=True)),
    "units of an axis": (MAP, MAP.assign_coords(easting=MAP.easting.assign_attrs(units="ft"))),
    "sticks": [FaultSticks("F1", (LINE[:n], LINE[n:])) for n in (2, 3)],
    "vertices": ((QUAD, FACES), (QUAD + 1.0, FACES)),
    "stick of a vertex": [TriSurface("F1", "fault", QUAD, FACES, vertex_data={"stick": of})
                          for of in ([0, 0, 1, 1], [0, 1, 2, 3])],
}  # fmt: skip


@pytest.mark.parametrize("kind", DIFFERENT)
def test_inputs_that_differ_in_little_are_not_one(kind):
    one, two = DIFFERENT[kind]
    assert fingerprint(one) != fingerprint(two)
    assert fingerprint(lattice()) == fingerprint(lattice())


def test_an_answer_is_never_that_of_another_question():
    """Nothing is told by its identity, which a later object may have; nor by words run together."""
    scene = Scene({"Top": level(3), "Base": level(1)}, {}, BOX)

    class Grid:
        """Has coordinates as a map needs them, and is no xarray object."""

        def __init__(self, *east: float) -> None:
            self.coords = {
                name: xr.DataArray(np.array(at), dims=name)
                for name, at in (("northing", [1.0, 2.0]), ("easting", east))
            }

    def eastings(grid: Grid) -> list[float]:
        return scene.thickness("Top/Base", grid).easting.values.tolist()

    for k in range(20):  # each is gone before the next is made
        assert eastings(Grid(1.0 + k / 8, 3.75)) == [1.0 + k / 8, 3.75]
    grid = Grid(1.0, 2.0)
    assert eastings(grid) == [1.0, 2.0]
    grid.coords["easting"][:] = [2.5, 3.5]
    assert eastings(grid) == [2.5, 3.5]


# ---- What scenes share stays within its bounds, and no result depends on what was dropped.
KB = 1024


def true_bytes(store):
    """All that is kept, counted slowly: each array once, and an overhead for each result."""
    roots = {}
    for entry in store._entries.values():
        roots |= buffers_of(entry.result)
    return sum(roots.values()) + KB * store.n_stored


@pytest.mark.parametrize("seed", range(6))
def test_bytes_are_counted_once_and_stay_below_the_budget(seed):
    """Results share arrays at random."""
    rng = random.Random(seed)
    arrays = [np.zeros(rng.randrange(1, 400)) for _ in range(12)]
    store = Store(budget=24 * KB)
    for _ in range(300):
        if rng.random() < 0.4:
            store.get(rng.randrange(60))
        else:
            some = rng.sample(arrays, rng.randrange(4))
            store.put(rng.randrange(60), [some, {"x": some[:1]}], ())
        assert true_bytes(store) <= store.budget
        assert store.bytes_stored() == true_bytes(store)
    assert store.n_dropped


@pytest.mark.parametrize(
    ("said", "size"),
    [("0", 0), ("1000", 1000), ("2 GiB", 2 << 30), ("1.5GB", 1_500_000_000), (" 3 kib ", 3072)],
)
def test_budgets_can_be_chosen(said, size, monkeypatch):
    monkeypatch.setenv(CHOICE, said)
    assert budget_of_family() == size


@pytest.mark.parametrize(
    "said", ["", "much", "-1", "1 XB", "1e9", "nan", "٣ GB", "9" * 5000, "1;2"]
)
def test_what_is_no_budget_is_one_sentence(said, monkeypatch):
    monkeypatch.setenv(CHOICE, said)
    world = gs.synthetic.tilted_planes(n=5)
    words = rf"^{CHOICE} is '.*', which is not a size\. Give bytes, or"
    refused(InputError, words, gs.Scene, world.horizons, world.faults, world.box)


def test_what_none_of_the_last_scenes_has_used_goes():
    """A loop over `replace` kept all results, up to a quarter of the memory."""
    world = gs.synthetic.tilted_planes(n=5)
    scene = first = gs.Scene(world.horizons, world.faults, world.box)
    volume, stored = float(first.volumes.sum()), []
    for step in range(36):
        moved = world.horizons["Top"] + 0.001 * (step + 1)
        scene = scene.replace(horizons={"Top": moved.assign_attrs(world.horizons["Top"].attrs)})
        assert len(scene.units)
        stored.append(scene._graph.memory.store.n_stored)
    assert max(stored) == max(stored[:20]) > 0
    back = scene.replace(horizons={"Top": world.horizons["Top"]})
    assert float(back.volumes.sum()) == volume == float(first.volumes.sum())


@pytest.mark.parametrize("budget", ["0", "1 MB"])
def test_no_result_depends_on_the_budget(budget, monkeypatch):
    world = gs.synthetic.graben(n=9)
    moved = {"Top": world.horizons["Top"] + 1.0}
    moved["Top"].attrs = world.horizons["Top"].attrs
    fresh = [
        seen(gs.Scene(h, world.faults, world.box)) for h in (world.horizons, world.horizons | moved)
    ]
    monkeypatch.setenv(CHOICE, budget)
    first = gs.Scene(world.horizons, world.faults, world.box)
    second = first.replace(horizons=moved)
    assert [seen(first), seen(second)] == fresh
    assert seen(second.replace(horizons={"Top": world.horizons["Top"]})) == fresh[0]
    assert seen(first) == fresh[0]
    store = first._graph.memory.store
    assert store.bytes_stored() <= store.budget


def test_a_living_scene_reads_its_inputs_once_whatever_is_dropped(monkeypatch):
    monkeypatch.setenv(CHOICE, "0")
    world = gs.synthetic.graben(n=9)
    scene = gs.Scene(world.horizons, world.faults, world.box)
    _ = scene.units, scene.curves, scene.check(), scene.throw("Top", "F1")
    ran = [(step.stage, step.subject) for step in scene.steps if step.outcome == "ran"]
    assert len([one for one in ran if one[0] in ("triangulate", "rebuild", "carve")]) == 5 + 1 + 1
    assert scene._graph.memory.store.n_stored == 0
    assert "dropped: " in scene.explain()


def test_nothing_waits_for_the_garbage_collector():
    """A ring of references would keep the arrays of scenes that are gone."""
    world = gs.synthetic.graben(n=9)

    def chain(n):
        """Some scenes, each gone when the next is there."""
        words = {"contacts": {"OWC": -2150.0}, "extend": ["F1"]}
        scene = gs.Scene(world.horizons, world.faults, world.box, **words)
        for step in range(n):
            top = (world.horizons["Top"] + 0.5 * step).assign_attrs(world.horizons["Top"].attrs)
            scene = scene.replace(horizons={"Top": top})
            _ = scene.units, scene.curves, scene.thickness("Top/Middle", 500.0), scene.warnings
            _ = scene.fault_actions, scene.throw("Top", "F1"), scene.propose_fault_network()

    chain(3)  # the same work before: what is loaded on the way leaves rings behind
    gc.collect()
    gc.disable()
    gc.set_debug(gc.DEBUG_SAVEALL)
    try:
        chain(3)
        gc.collect()
        assert not [type(one) for one in gc.garbage if _is_ours(one)]
    finally:
        gc.set_debug(0)
        gc.garbage.clear()
        gc.enable()


def _is_ours(one):
    """Whether geosurf has made an object, or it holds numbers; loaders of kernels leave rings."""
    return isinstance(one, np.ndarray) or type(one).__module__.startswith("geosurf")
