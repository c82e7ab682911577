"""`run_ensemble`: many realisations of a model, measured, stored, and continued after a kill."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted, is_whole
from geosurf.conventions.axes import need_depth
from geosurf.conventions.running import count_of, running
from geosurf.ensemble.change import check_seed
from geosurf.ensemble.models import OWN_NUMBERS, BuiltModel, SceneModel, uncertainty_of
from geosurf.ensemble.on_dask import (
    Workers,
    check_workers,
    give_plan,
    require_extra,
    run_on_dask,
    workers_for,
)
from geosurf.ensemble.plan import Plan, uncertainties
from geosurf.ensemble.record import Record, Rock
from geosurf.ensemble.results import Ensemble, open_ensemble
from geosurf.ensemble.store import EnsembleStore, is_finished
from geosurf.ensemble.uncertain import VelocityFactor
from geosurf.errors import GeometryError, InputError, warn_of
from geosurf.model.expected import flag_of, path_of
from geosurf.scenario import build_scene, read_scenario
from geosurf.scenario.keys import Scenario
from geosurf.scenario.output_keys import EnsembleSettings
from geosurf.scene import Scene
from geosurf.scene.given import in_depth
from geosurf.scene.result_cache import ResultCache
from geosurf.stopping import temporary_folder


def run_ensemble(
    model: Any,
    n: int | None = None,
    *,
    uncertain: Any = (),
    seed: int | None = None,
    store: str | os.PathLike[str] | None = None,
    cache_dir: str | os.PathLike[str] | None = None,
    volumetrics: Any = None,
    maps: Any = None,
    client: Any = None,
    workers: int | None = None,
    processes: bool | None = None,
    progress: bool | Callable[[str], object] = True,
) -> Ensemble:
    """
    Build many realisations of a model, and return the volumes of all units in each.

    Realisation k depends on the seed and on k only: it is the same on any number of workers, and in
    a longer ensemble. One that cannot be built is recorded with the reason.

    Parameters
    ----------
    model : Scene, path of a scenario, or callable
        A scenario has its uncertainties in ``[ensemble]``. A callable takes a
        `numpy.random.Generator` and returns a Scene; worker processes need it to be picklable.
    n : int, optional
        Number of realisations. Default: that of the scenario, or 100.
    uncertain : sequence of uncertainties
        `DepthShift`, `DepthError`, `ContactLevel`, `Throw`, `FaultShift` and `FaultDip` of
        ``geosurf.ensemble``, for a Scene.
    seed : int, optional
        Default: that of the scenario, or 0.
    store : path-like, optional
        A folder for the results (Zarr). Call again with the same inputs to continue after a kill,
        or with a larger `n` for more realisations. Default: results are in memory only.
    cache_dir : path-like, optional
        The folder of `run_scenario`, for a scenario: the base case takes its torn horizons from
        there, or stores them there.
    volumetrics : mapping, optional
        The arguments of `Scene.volumetrics`, for net rock, pores and fluids in place of each
        realisation; a number may be a distribution. A scenario has them in ``[volumetrics]``.
    maps : bool, float or xarray object, optional
        Also map thickness, mean and standard deviation, and the probability of each zone: the width
        of a cell [m], a grid, or True for 100 cells along the longer side.
    client : distributed.Client, optional
        A Dask cluster that runs the realisations.
    workers : int, optional
        Realisations at once, without a client. Default: the cores that the process may use.
    processes : bool, optional
        Whether workers are processes instead of threads. Default: what is expected to end earlier,
        by the time of the first ones; threads for a callable.
    progress : bool or callable
        True shows how many realisations are there, and the time left, on terminals and in
        notebooks (see `show_progress`); a callable gets a line for each instead.

    Returns
    -------
    Ensemble
        Quantiles, tornado, tables and charts. Its ``data`` have ``bulk`` (realisation, unit): gross
        rock volume [m3], NaN where a realisation failed and 0 where a unit does not exist; with
        `volumetrics` also ``net``, ``pore``, ``hydrocarbon_pore``, ``stoiip`` and ``giip``;
        ``base_bulk`` ... of the base case, in which each parameter has its median; ``drawn``
        (realisation, parameter); ``status`` (1: done, 2: failed) and ``reason``; ``torn`` and
        ``searched``: how many horizons were torn, and how many of these could not be cut as in
        the base case. Regions have the names of those of the base case with the largest overlap.
        With maps ``thickness_mean``, ``thickness_sd`` and ``probability`` (layer, northing,
        easting).

    Raises
    ------
    DependencyError
        If zarr is not installed: ``pip install "geosurf[ensemble]"``.
    InputError
        If an argument cannot be used, or the base case cannot be built.
    GeometryError
        If the base case, or each of the first 20 realisations, cannot be built.
    OutputError
        If the store cannot be written: what is finished stays.
    WorkerError
        If a worker is lost for good: what is finished stays.

    Warns
    -----
    GeosurfWarning
        If some realisations failed: kind ``"ensemble"``.

    Notes
    -----
    A box that is not given is that of the base case, higher and deeper by what the parameters may
    move horizons. See docs/guides/ensembles.md.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> shift = gs.ensemble.DepthShift("Top", gs.ensemble.Normal(0.0, 10.0))
    >>> ensemble = gs.run_ensemble(scene, 8, uncertain=[shift])
    >>> dict(ensemble.sums("region").sizes), ensemble.n_built
    ({'realisation': 8, 'region': 2}, 8)
    """
    require_extra()

    # Arguments are checked before the first model is built.
    workers = check_workers(workers)
    processes = None if processes is None else flag_of(processes, "processes")
    plan, n = planned(model, n, uncertain, seed, maps, cache_dir, volumetrics)
    # a second call for results that are there: a torn field's base case takes seconds; what a
    # store of maps holds is known after it, since the base case gives their grid
    if store is not None and plan.grid is None and is_finished(store, plan.identity, n):
        result = open_ensemble(store)
        _warn_of_failed(result)
        return result
    with workers_for(plan, n, client, workers, processes) as pool, temporary_folder() as scratch:
        # The base case also fixes the area for all realisations.
        base = plan.start()
        give_plan(plan, pool, processes)
        # Without a store results pass through a temporary one: one way for both.
        path = Path(scratch) / "ensemble.zarr" if store is None else path_of(store, "store")
        target = EnsembleStore(path, plan, base, n, stays=store is not None)
        # The store is closed whatever happens, so that another call can continue.
        try:
            _run(target, client, workers, processes, progress, pool)
        finally:
            target.close()
        result = open_ensemble(path)
    _warn_of_failed(result)
    return result


def planned(
    model: Any,
    n: int | None,
    uncertain: Any,
    seed: int | None,
    maps: Any,
    cache_dir: str | os.PathLike[str] | None = None,
    volumetrics: Any = None,
) -> tuple[Plan, int]:
    """Return the plan of an ensemble and its number of realisations, all arguments checked."""
    cache = None if cache_dir is None else ResultCache(cache_dir)
    # A path is a scenario, which has its uncertainties along.
    if isinstance(model, str | os.PathLike | Scenario):
        if volumetrics is not None:
            raise InputError("a scenario has its own table [volumetrics]. Leave out volumetrics=.")
        scenario = model if isinstance(model, Scenario) else read_scenario(model)
        return _of_scenario(scenario, cache, n, uncertain, seed, maps)
    if cache is not None:
        raise InputError(
            "cache_dir= is for the path of a scenario: a Scene has its horizons already. Leave it "
            "out."
        )
    count = _checked_number(100 if n is None else n)
    chosen = check_seed(0 if seed is None else seed)
    listed = uncertainties(uncertain)
    # False means no maps, as None does; True asks for the default grid.
    grid = None if maps is False else maps
    rock = Rock.of(volumetrics, model.crs if isinstance(model, Scene) else None)
    if isinstance(model, Scene):
        need_depth(model.time, "volumes of an ensemble")
        if not listed and not rock.uncertain:
            raise InputError(
                "nothing is uncertain, so that all realisations would be the same. Give uncertain="
                "[geosurf.ensemble.DepthShift(...), ...]."
            )
        return Plan(SceneModel(model), listed, chosen, grid, rock), count
    if callable(model):
        if listed:
            raise InputError(OWN_NUMBERS)
        return Plan(BuiltModel(model, chosen), listed, chosen, grid, rock), count
    raise InputError(
        f"run_ensemble takes a Scene, the path of a scenario or a function, not "
        f"{type(model).__name__}."
    )


def _of_scenario(
    scenario: Scenario,
    cache: ResultCache | None,
    n: int | None,
    uncertain: Any,
    seed: int | None,
    maps: Any,
) -> tuple[Plan, int]:
    """Return the plan of a scenario; arguments count before its table ``[ensemble]``."""
    given, fluids = scenario.ensemble or EnsembleSettings(), scenario.volumetrics
    scene = build_scene(scenario, cache=cache)
    rock = Rock.of(None if fluids is None else vars(fluids), scene.crs)
    # Two places for uncertainties would leave open which of them count.
    if len(uncertainties(uncertain)):
        raise InputError(f"{scenario.path} has its own [[uncertain]] tables. Leave out uncertain=.")
    if not scenario.uncertain and not rock.uncertain:
        raise InputError(
            f"{scenario.path}: nothing is uncertain. Add a table [[uncertain]] for each "
            "input that is, for example these four lines:\n\n"
            '[[uncertain]]\nkind = "depth error"\nsd_m = 10.0\nrange_m = 1500.0'
        )
    listed = tuple(uncertainty_of(entry) for entry in scenario.uncertain)
    if scenario.time is not None and not any(isinstance(one, VelocityFactor) for one in listed):
        scene = in_depth(scene)
    count = _checked_number(given.n if n is None else n)
    grid = given.map_cell_m if maps is None else None if maps is False else maps
    chosen = check_seed(given.seed if seed is None else seed)
    return Plan(SceneModel(scene), listed, chosen, grid, rock), count


def _checked_number(n: Any) -> int:
    """The number of realisations."""
    if not (is_whole(n) and n > 0):
        raise InputError(f"n is {n!r}; give the number of realisations, a whole number above 0.")
    return int(n)


def _run(
    target: EnsembleStore,
    client: Any,
    workers: int,
    processes: bool | None,
    progress: bool | Callable[[str], object],
    pool: Workers,
) -> None:
    """Run what is missing, and store each realisation when it is finished."""
    # What the store has is not run again.
    missing = target.missing()
    begun, n_done, n_failed = time.monotonic(), target.n - len(missing), 0

    def finished(record: Record) -> None:
        """Store one realisation; stop if all of the first ones fail."""
        nonlocal n_done, n_failed
        target.add(record)
        n_done, n_failed = n_done + 1, n_failed + bool(record.reason)
        left = target.n - n_done
        more = f", {n_failed} failed" if n_failed else ""
        if left:
            each = (time.monotonic() - begun) / (len(missing) - left)
            more += f", {duration(each * left)} left"
        count_of("realisations", n_done, target.n, more)
        if callable(progress):
            progress(f"{n_done} of {counted(target.n, 'realisation')}{more}")
        _refuse_if_all_fail(target)

    # Also before the first: a store that is continued may have failed completely.
    _refuse_if_all_fail(target)
    with running("realisations") if progress is True else nullcontext():
        run_on_dask(
            target.plan, missing, finished, client=client, workers=workers, processes=processes,
            pool=pool,
        )  # fmt: skip
    target.finish()


def _refuse_if_all_fail(target: EnsembleStore) -> None:
    """Stop if no realisation of the first batch could be built."""
    # After one batch: later ones would fail like it, and each costs time.
    if target.next_batch >= 1 and (target.status[: target.rows(0).stop] == 2).all():
        reasons = target.group["reason"][: target.rows(0).stop].tolist()
        raise GeometryError(
            f"none of the first {len(reasons)} realisations can be built. The first one: "
            f"{reasons[0]} Give narrower distributions, or see "
            f"geosurf.ensemble.realise(model, 0, uncertain=...)."
        )


def realise(
    model: Any, realisation: int | None, *, uncertain: Any = (), seed: int | None = None
) -> Scene:
    """
    Return the scene of one realisation, as `run_ensemble` builds it: to look at it.

    Parameters
    ----------
    model, uncertain, seed
        As for `run_ensemble`.
    realisation : int or None
        Its number; None: the base case, in which each parameter has its median.

    Returns
    -------
    Scene

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> shift = gs.ensemble.DepthShift("Top", gs.ensemble.Normal(0.0, 10.0))
    >>> one = gs.ensemble.realise(scene, 3, uncertain=[shift])
    >>> round(float(one.surface("Top").bounds[4] - scene.surface("Top").bounds[4]), 2)
    -1.36
    """
    if realisation is not None and not (is_whole(realisation) and realisation >= 0):
        raise InputError(f"realisation is {realisation!r}; give its number, 0 or above, or None.")
    plan, base, _ = _begun(model, None, uncertain, seed)
    return base if realisation is None else plan.scene(realisation)


def realisations(
    model: Any, n: int | None = None, *, uncertain: Any = (), seed: int | None = None
) -> Iterator[Scene]:
    """
    Yield the scenes of the first realisations, one by one: to measure in each what you like.

    Parameters
    ----------
    model, n, uncertain, seed
        As for `run_ensemble`.

    Yields
    ------
    Scene
        As from `realise`; the base case is built once for all.

    Raises
    ------
    GeosurfError
        If a realisation cannot be built; here, or when it is measured.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> shift = gs.ensemble.DepthShift("Top", gs.ensemble.Normal(0.0, 10.0))
    >>> scenes = gs.ensemble.realisations(scene, 3, uncertain=[shift])
    >>> [round(float(one.volumes.sum()) / 1e6, 1) for one in scenes]
    [1270.7, 1043.0, 1095.8]
    """
    plan, _, count = _begun(model, n, uncertain, seed)
    yield from map(plan.scene, range(count))


def _begun(model: Any, n: int | None, uncertain: Any, seed: int | None) -> tuple[Plan, Scene, int]:
    """The plan of an ensemble, its base case, and how many realisations it has."""
    plan, count = planned(model, n, uncertain, seed, None)
    # As in an ensemble: the area of the base case, with the reach of all uncertainties.
    base = plan.base_case()
    plan.model.started(base)
    return plan, base, count


def _warn_of_failed(ensemble: Ensemble) -> None:
    """Warn of realisations that failed, with the reason that is most frequent."""
    result = ensemble.data
    failed = np.flatnonzero(result.status.values == 2)
    if not len(failed):
        return
    reasons = result.reason.values[failed].tolist()
    # The most frequent reason, and the first realisation that had it.
    most = max(dict.fromkeys(reasons), key=reasons.count)
    first = int(failed[reasons.index(most)])
    total = result.sizes["realisation"]
    warn_of(
        "ensemble",
        "realisations",
        f"{len(failed)} of {total} realisations could not be built; quantiles are of the other "
        f"{total - len(failed)}. {reasons.count(most)} failed like realisation {first}: {most}",
        f"See geosurf.ensemble.realise(model, {first}, ...) and ensemble.data.reason.",
    )


def duration(seconds: float) -> str:
    """Return a duration as people read it.

    Examples
    --------
    >>> duration(4.4), duration(250), duration(7300)
    ('4 s', '4 min 10 s', '2 h 1 min')
    """
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"
