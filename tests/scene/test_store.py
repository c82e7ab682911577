"""What scenes share stays within its bounds, and no result depends on what was dropped."""

from __future__ import annotations

import gc
import random

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import InputError
from geosurf.scene.memory import CHOICE, Store, budget_of_family, buffers_of
from tests import laws

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
        what = rng.random()
        if what < 0.4:
            store.get(rng.randrange(60))
        else:
            some = rng.sample(arrays, rng.randrange(4))
            store.put(rng.randrange(60), [some, {"x": some[:1]}], ())
        assert store._bytes == true_bytes(store) <= store.budget
    assert store.n_dropped


def test_bytes_are_counted_once_the_process_has_had_as_many(monkeypatch):
    """Below the budget nothing is counted; from there on all results are, and the first go."""
    store, most = Store(budget=24 * KB), 0.0
    monkeypatch.setattr("geosurf.scene.memory.most_memory_so_far", lambda: most)
    for k in range(6):
        store.put(k, np.zeros(KB), ())
    assert (store.n_stored, store._bytes, store.bytes_dropped) == (6, 0, 0)
    most = 24.0 * KB
    store.put(6, np.zeros(KB), ())
    assert store._bytes == true_bytes(store) <= store.budget
    assert (store.n_stored, store.n_dropped, store.bytes_dropped) == (2, 5, 5 * 8 * KB)


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
    with pytest.raises(
        InputError, match=rf"^{CHOICE} is '.*', which is not a size\. Give bytes, or"
    ):
        gs.Scene(world.horizons, world.faults, world.box)


def seen(scene):
    """All that can be compared of a scene."""
    volumes = {name: unit.volume for name, unit in scene.units.items()}
    return (
        volumes,
        laws.curve_bytes(scene.curves),
        scene.thickness("Top/Middle", 500.0).values.tobytes(),
    )


@pytest.mark.parametrize("budget", ["0", "50 kB", "1 MB", "4 GB"])
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
        scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2150.0})
        for step in range(n):
            top = (world.horizons["Top"] + 0.5 * step).assign_attrs(world.horizons["Top"].attrs)
            scene = scene.replace(horizons={"Top": top})
            _ = scene.units, scene.curves, scene.thickness("Top/Middle", 500.0), scene.warnings

    chain(5)  # the same work before: what is loaded on the way leaves rings behind
    gc.collect()
    gc.disable()
    gc.set_debug(gc.DEBUG_SAVEALL)
    try:
        chain(5)
        gc.collect()
        ours = [type(one) for one in gc.garbage if _is_ours(one)]
        assert not ours
    finally:
        gc.set_debug(0)
        gc.garbage.clear()
        gc.enable()


def _is_ours(one):
    """Whether geosurf has made an object, or it holds numbers; loaders of kernels leave rings."""
    return isinstance(one, np.ndarray) or type(one).__module__.startswith("geosurf")
