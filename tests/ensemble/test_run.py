"""An ensemble is the same on any workers, survives kills and full disks, and loses no failure."""

from __future__ import annotations

import errno
import os
import pickle
import signal
import subprocess
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import geosurf as gs
from geosurf.conventions import machine
from geosurf.ensemble import DepthError, DepthShift, on_dask
from geosurf.ensemble import store as store_room
from geosurf.ensemble.models import content_of
from geosurf.ensemble.on_dask import check_workers
from geosurf.ensemble.plan import Plan
from geosurf.ensemble.run import planned
from geosurf.ensemble.store import EnsembleStore
from geosurf.errors import DependencyError, GeometryError, InputError, OutputError, WorkerError
from geosurf.scene.graph import Graph
from geosurf.sheets import tear
from tests.ensemble.worlds import UNCERTAIN, N, bytes_of, fault, layer_cake, plane, run, scene
from tests.messages import refused

BATCH = 2  # more than one batch in N
POINTS = (70, 130, 186, 10_000)  # writes that fail


@pytest.fixture(scope="module", autouse=True)
def small_batches():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(store_room, "BATCH", BATCH)
        yield


@pytest.fixture(scope="module")
def made():
    """A plan that has started, its base case, and all of its realisations."""
    plan, n = planned(scene(), N, UNCERTAIN, None, 500.0)
    return plan, plan.start(), [plan.run(k) for k in range(n)]


def fill(store, made, order=None):
    """Write what is missing of a store from realisations that are made already."""
    plan, base, records = made
    target = EnsembleStore(store, plan, base, N)
    try:
        missing = target.missing()
        for k in missing if order is None else order:
            target.add(records[k])
        target.finish()
    finally:
        target.close()
    return missing


@pytest.fixture(scope="module")
def truth(tmp_path_factory, made):
    """The bytes of the store, realisation after realisation."""
    store = tmp_path_factory.mktemp("truth") / "e.zarr"
    fill(store, made)
    return bytes_of(store)


# ---- the same bytes ----------------------------------------------------------------------


def test_threads_give_the_same_bytes(tmp_path, truth):
    lines = []
    run(store=tmp_path / "e.zarr", workers=3, progress=lines.append)
    assert bytes_of(tmp_path / "e.zarr") == truth
    assert lines[-1] == f"{N} of {N} realisations"
    assert any(line.endswith(" left") for line in lines)


def test_worker_processes_give_the_same_bytes(tmp_path, truth):
    run(store=tmp_path / "e.zarr", workers=1, processes=True)
    assert bytes_of(tmp_path / "e.zarr") == truth


@pytest.mark.parametrize("sent", [True, False])
def test_workers_of_long_ensembles_start_with_the_base_case_and_end_with_the_call(
    tmp_path, truth, monkeypatch, sent
):
    started, start = [], on_dask._start
    monkeypatch.setattr(on_dask, "_start", lambda: started.append(start()) or started[-1])
    monkeypatch.setattr(on_dask, "_PROCESSES_FROM", N)
    plan_start, before = Plan.start, []

    def long(plan):
        before.append(len(started))
        return plan_start(plan)

    def unsent(plan):
        raise TypeError("cannot be sent")

    monkeypatch.setattr(Plan, "start", long)
    if not sent:  # threads do not need it
        monkeypatch.setattr(on_dask, "dumps", unsent)
        monkeypatch.setattr(on_dask, "_CODE_OF_WORKER", "input()")  # the process has nothing to do
    run(store=tmp_path / "e.zarr", workers=2)
    assert bytes_of(tmp_path / "e.zarr") == truth
    assert (before, len(started)) == ([1], 1)  # this process is the second worker
    assert all(process.poll() is not None for process in started)
    with pytest.warns(gs.GeosurfWarning):  # a function may have effects: it stays in threads
        gs.run_ensemble(sometimes, N, workers=2)
    assert len(started) == 1


def test_another_process_builds_once_what_does_not_change(monkeypatch):
    """A plan begins there without results: moved contacts cut the model of the first one."""
    plan, n = planned(scene(), 3, UNCERTAIN[2:], None, None)
    plan.start()
    built, rebuilt = [], Graph._rebuilt
    monkeypatch.setattr(Graph, "_rebuilt", lambda *given: built.append(1) or rebuilt(*given))
    here = [plan.run(k).amounts for k in range(n)]
    assert not built
    there = pickle.loads(on_dask.dumps(plan))
    assert [there.run(k).amounts for k in range(n)] == here
    assert len(built) == 1


@pytest.mark.filterwarnings("default")
def test_a_cluster_gives_the_same_bytes(tmp_path, truth):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            2, processes=False, threads_per_worker=1, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        run(store=tmp_path / "e.zarr", client=client)
    assert bytes_of(tmp_path / "e.zarr") == truth


def test_records_in_any_order_give_the_same_bytes(tmp_path, truth, made):
    fill(tmp_path / "e.zarr", made, np.random.default_rng(0).permutation(N).tolist())
    assert bytes_of(tmp_path / "e.zarr") == truth


def test_a_longer_ensemble_continues_a_shorter_one(tmp_path, truth):
    first = run(n=3, store=tmp_path / "e.zarr")
    second = run(store=tmp_path / "e.zarr")
    assert bytes_of(tmp_path / "e.zarr") == truth
    np.testing.assert_array_equal(second.bulk.sel(unit=first.unit)[:3], first.bulk)
    again = run(store=tmp_path / "e.zarr", progress=lambda line: pytest.fail(line))
    assert again.identical(second)
    with pytest.raises(InputError, match=f"holds {N} realisations, more than n=3"):
        run(n=3, store=tmp_path / "e.zarr")


def test_a_finished_ensemble_is_opened_without_a_model(tmp_path, monkeypatch):
    first = run(n=3, maps=None, store=tmp_path / "e.zarr")
    before = bytes_of(tmp_path / "e.zarr")
    monkeypatch.setattr(Plan, "start", lambda _: pytest.fail("the base case is not needed"))
    assert run(n=3, maps=None, store=tmp_path / "e.zarr").identical(first)
    assert bytes_of(tmp_path / "e.zarr") == before
    with pytest.raises(pytest.fail.Exception):  # more of them need it
        run(n=4, maps=None, store=tmp_path / "e.zarr")
    with pytest.raises(pytest.fail.Exception):  # other ones, too: the store is refused then
        run(n=3, seed=1, maps=None, store=tmp_path / "e.zarr")


def test_a_store_of_other_inputs_is_refused_and_stays(tmp_path):
    run(n=3, maps=None, store=tmp_path / "e.zarr")
    before, dented = bytes_of(tmp_path / "e.zarr"), plane(-1000.0)
    dented[3, 3] += 0.5
    for change in (
        {"horizons": {"Top": dented}}, {"contacts": {"OWC": -1050.5}}, {"faults": {"F1": fault()}},
        {"box": (0, 2000, 0, 1500, -1300, -790)},
    ):  # fmt: skip
        other = scene().replace(**change)
        with pytest.raises(InputError, match="an ensemble of other inputs"):
            gs.run_ensemble(other, 3, uncertain=UNCERTAIN, store=tmp_path / "e.zarr")
        assert bytes_of(tmp_path / "e.zarr") == before
    with pytest.raises(InputError, match="an ensemble of other inputs"):
        run(n=3, maps=None, seed=5, store=tmp_path / "e.zarr")


# ---- kills, full disks, lost workers -----------------------------------------------------


def test_a_killed_ensemble_continues_to_the_same_bytes(tmp_path, truth):
    """A batch is whole then, and a realisation of the next one is a file."""
    store, root = tmp_path / "e.zarr", Path(__file__).resolve().parents[2]
    code = f"""
    import os, signal
    from geosurf.ensemble import store
    from tests.ensemble.worlds import run
    def killed(line):
        if line.startswith("3 "):
            os.kill(os.getpid(), signal.SIGKILL)
    store.BATCH = {BATCH}
    run(store={str(store)!r}, workers=1, progress=killed)
    """
    command = [sys.executable, "-c", textwrap.dedent(code)]
    assert subprocess.run(command, cwd=root, check=False).returncode == -signal.SIGKILL
    assert len([*(store / store_room.RECORDS).iterdir()]) == 1
    lines = []
    run(store=store, progress=lines.append)
    assert lines[0].startswith("4 ")  # the others did not run again
    assert bytes_of(store) == truth


def test_a_write_that_fails_costs_nothing(tmp_path, truth, made, monkeypatch):
    """The disk is full at one write after another: records, batches, maps."""
    from zarr.storage import LocalStore

    left, plain, whole = [0], LocalStore.set, store_room.write_whole

    def full():
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    async def set_(self, key, value):
        full()
        await plain(self, key, value)

    def write(path, data):
        full()
        whole(path, data)

    n_failed = 0
    for point in POINTS:
        store, left[0] = tmp_path / f"{point}.zarr", point
        with monkeypatch.context() as patch:
            patch.setattr(LocalStore, "set", set_)
            patch.setattr(store_room, "write_whole", write)
            try:
                fill(store, made)
            except OutputError as error:
                assert "No space left on device" in str(error)  # noqa: PT017 - many points
                assert "it continues" in str(error)  # noqa: PT017
                n_failed += 1
            else:
                break
        fill(store, made)
        assert bytes_of(store) == truth
    assert n_failed == len(POINTS) - 1  # beyond the last point nothing fails


def test_a_damaged_record_is_run_again(tmp_path, truth, made):
    plan, base, records = made
    target = EnsembleStore(tmp_path / "e.zarr", plan, base, N)
    target.missing()
    for k in (2, 3):
        target.add(records[k])
    target.close()
    file = tmp_path / "e.zarr" / store_room.RECORDS / "000000002.npz"
    file.write_bytes(file.read_bytes()[:-9])
    assert fill(tmp_path / "e.zarr", made) == [k for k in range(N) if k != 3]
    assert bytes_of(tmp_path / "e.zarr") == truth


class Deadly:
    """Builds one scene, and then ends its process."""

    def __init__(self, pid):
        self.pid = pid

    def __call__(self, stream):
        if os.getpid() != self.pid:
            os.kill(os.getpid(), signal.SIGKILL)
        return layer_cake()

    __module__, __qualname__ = __name__, "deadly"


def test_a_lost_worker_is_one_clear_message(tmp_path):
    with pytest.raises(WorkerError, match=r"was lost .killed, or out of memory.*it continues"):
        gs.run_ensemble(Deadly(os.getpid()), 2, workers=1, processes=True)


# ---- failures ----------------------------------------------------------------------------


def sometimes(stream):
    """A function that builds scenes, and cannot in a third of the cases."""
    number = stream.random()
    if number < 0.3:
        raise GeometryError(f"drew {number:.3f}, which cannot be built.")
    if number < 0.4:
        raise ValueError("a mistake of the function")
    shift = DepthShift("Top", 100.0 * number)
    return gs.ensemble.realise(layer_cake(), 0, uncertain=[shift])


def test_failed_realisations_are_recorded_with_their_reason():
    with pytest.warns(gs.GeosurfWarning, match=r"of 24 realisations could not be built") as found:
        ensemble = gs.run_ensemble(sometimes, 24)
    result = ensemble.data
    failed = result.status.values == 2
    assert 4 < failed.sum() < 20
    assert found[0].message.kind == "ensemble"
    reasons = result.reason.values
    assert ((reasons != "") == failed).all()
    assert {word.split()[0] for word in reasons[failed]} == {"drew", "ValueError:"}
    assert np.isnan(result.bulk.values[failed]).all()
    assert np.isfinite(result.bulk.values[~failed]).all()
    found = ensemble.quantiles(by="zone")
    assert (found.attrs["n"], found.attrs["failed"]) == ((~failed).sum(), failed.sum())


def test_an_ensemble_that_always_fails_stops_early():
    calls = []

    def never(stream):
        calls.append(1)
        if len(calls) > 1:  # the base case
            raise GeometryError("it folds.")
        return layer_cake()

    with pytest.raises(GeometryError, match=rf"none of the first {BATCH} .* can be built.*folds"):
        gs.run_ensemble(never, 500, workers=1)
    assert len(calls) < 30
    with pytest.raises(GeometryError, match="it folds"):  # the base case
        gs.run_ensemble(never, 5)


# ---- arguments ---------------------------------------------------------------------------


def test_other_models_are_refused():
    refused(InputError, "run_ensemble takes a Scene, the path of a scenario or", gs.run_ensemble, 5)
    with pytest.raises(InputError, match=r"Leave out uncertain="):
        gs.run_ensemble(sometimes, 2, uncertain=[DepthShift("Top", 1.0)])
    with pytest.raises(InputError, match=r"returned int. Return a geosurf.Scene"):
        gs.run_ensemble(lambda stream: 5, 2)
    assert check_workers(None) >= 1


def test_a_store_of_something_else_is_left_alone(tmp_path):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "letter.txt").write_text("dear")
    with pytest.raises(InputError, match=r"exists and is not an ensemble. Give the path of a new"):
        run(n=1, store=tmp_path / "other")
    refused(InputError, "is not an ensemble", lambda: gs.ensemble.open_ensemble(tmp_path / "other"))


@dataclass
class Drawn:
    """A distribution of the user."""

    middle: float

    def quantile(self, share):
        return self.middle + share


def test_distributions_count_by_what_they_draw():
    """By kind and numbers: of two equal ones, made in two processes, a store is continued."""
    kinds = [stats.norm, stats.uniform]
    made = [kind(loc=0.0, scale=scale) for kind in kinds for scale in (1.0, 2.0) for _ in range(2)]
    known = [content_of(DepthShift("Top", distribution)) for distribution in made]
    assert known[::2] == known[1::2]
    assert len(set(known)) == 4
    # of a class of the user by its name and fields
    given = [content_of(DepthShift("Top", Drawn(middle))) for middle in (1.0, 1.0, 2.0)]
    assert given[0] == given[1] != given[2]


def test_two_writers_exclude_each_other(tmp_path, made):
    plan, base, _ = made
    target = EnsembleStore(tmp_path / "e.zarr", plan, base, 3)
    with pytest.raises(InputError, match="another process writes to this ensemble"):
        EnsembleStore(tmp_path / "e.zarr", plan, base, 3)
    target.close()


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setattr(machine, "find_spec", lambda name: None if name == "zarr" else 1)
    refused(DependencyError, r'need zarr.*pip install "geosurf\[ensemble\]"', run, n=1)


# ---- maps, progress, records -------------------------------------------------------------


def test_maps_are_those_of_the_volumes(tmp_path, made):
    fill(tmp_path / "e.zarr", made)
    result = gs.ensemble.open_ensemble(tmp_path / "e.zarr").data
    cell = 500.0 * 500.0
    zone = result.bulk.isel(unit=np.flatnonzero(result.zone == "Top/Base")).sum("unit")
    mean = result.thickness_mean.sel(layer="Top/Base").sum() * cell
    assert float(mean) == pytest.approx(float(zone.mean()), rel=2e-3)

    # everywhere alike: the contact decides where the lower part is present
    part = result.probability.sel(layer="Top/Base below OWC")
    assert 0.0 < float(part.min()) <= float(part.max()) < 1.0
    assert (result.probability.sel(layer="Top/Base") == 1.0).all()
    spread = result.thickness_sd.sel(layer="Top/Base").mean()
    assert float(spread) == pytest.approx(np.hypot(10.0, 5.0), rel=0.35)


def test_a_realisation_with_throw_is_the_scene_that_its_numbers_make():
    world = gs.synthetic.graben(n=21)
    horizons = {name: world.horizons[name] for name in ("Top", "Base")}
    faults = {"F1": world.faults["F1"]}
    scene = gs.Scene(horizons, faults, world.box)
    throw = gs.ensemble.Throw("F1", gs.ensemble.Normal(60.0, 10.0))
    result = gs.run_ensemble(scene, 3, uncertain=[throw], workers=1, progress=False).data
    for k, by in enumerate(result.drawn.values[:, 0].tolist()):
        sheets = {
            name: gs.throw_horizon(data, faults, {"F1": by}, name=name)
            for name, data in horizons.items()
        }
        fresh = gs.Scene(sheets, faults, world.box).volumes
        known = dict(zip(result.unit.values.tolist(), result.bulk.values[k].tolist(), strict=True))
        assert {name: known[name] for name in fresh.unit.values.tolist()} == dict(
            zip(fresh.unit.values.tolist(), fresh.values.tolist(), strict=True)
        )


def test_the_base_case_of_a_torn_field_is_searched_once(monkeypatch):
    # a fault that leaves the box is another one in a taller box: sheets of the first do not serve
    world = gs.synthetic.torn("normal", n=31)
    short = {"F1": world.faults["F1"].isel(down_dip=slice(1, None))}
    scene = gs.Scene(world.horizons, short, tear=True, extend={"F1": ("up",)})
    plan, _ = planned(scene, 4, [DepthError("Top", sd=5.0, range=900.0)], None, None)
    torn, real = [], tear.tear_from
    monkeypatch.setattr(
        tear, "tear_from", lambda *args, **words: torn.append(args) or real(*args, **words)
    )
    plan.start()
    assert [args[0] is None for args in torn] == [True, False]  # then as planned

    # the frame is the one that the torn scene has, taller by the reach
    *sides, bottom, top = scene.box
    reach = plan.prepared[0].reach
    base = plan.scene(None)
    assert base.box == (*sides, bottom - reach, top + reach)
    assert np.array_equal(base.aoi, scene.aoi) if scene.aoi is not None else base.aoi is None
