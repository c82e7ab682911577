"""Passes over ranges of triangles, edges and records in threads: the bytes of one thread."""

from __future__ import annotations

import sys
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

import geosurf as gs
from geosurf.arrangement import arrange, gather, search
from geosurf.arrangement.threads import map_threads
from geosurf.carve import cells, measures
from geosurf.errors import GeosurfError
from geosurf.rebuild import assemble, repair
from tests.scene.test_moved_surfaces import BOX, COARSE, fault, horizon, result
from tests.strategies import sheet

# horizons cross and lie in the wrong order here, on purpose
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
LEAST = [
    (arrange, "_RECORDS_OF_A_THREAD"),
    (gather, "_PAIRS_IN_THREADS"),
    (gather, "_POINTS"),
    (gather, "_SUSPECTS"),
    (gather, "_CONTACTS"),
    (search, "_PAIRS_OF_A_THREAD"),
    (search, "_CONTACTS_OF_A_THREAD"),
    (assemble, "_MANY"),
    (repair, "_MANY"),
    (cells, "_TRIANGLES"),
    (cells, "_EDGES"),
    (cells, "_PARENTS"),
    (cells, "_SEAMS"),
    (measures, "_TRIANGLES"),
    (measures, "_MANY_RUNS"),
]


def results(seed, step):
    """Bytes of a scene, and of scenes in which a fault, then a horizon has moved."""
    rng = np.random.default_rng([98, seed])
    horizons = {name: horizon(rng, z, step) for name, z in (("Top", 4), ("Mid", 2), ("Base", 0))}
    faults = {"F1": sheet("F1", [(1.5, -1, -5), (1.5, 5, -5), (1.5, 5, 9), (1.5, -1, 9)])}
    faults["F2"] = fault(rng, step)
    scene = gs.Scene(horizons, faults, BOX)
    found = [result(scene)]
    for change in (
        {"faults": {"F2": fault(rng, step)}},
        {"horizons": {"Mid": horizon(rng, 2, step)}},
    ):
        scene = scene.replace(**change)
        found.append(result(scene))
        try:
            found.append([[unit.volume, unit.area] for unit in scene.units.values()])
        except GeosurfError:
            found.append([])
    return found


@pytest.mark.parametrize("step", [COARSE, 0.0])
@pytest.mark.parametrize("seed", range(3))
def test_any_number_of_threads_gives_the_bytes_of_one(seed, step, monkeypatch):
    monkeypatch.setenv("GEOSURF_THREADS", "1")
    alone = results(seed, step)
    assert any(isinstance(one, tuple) and isinstance(one[0], bytes) for one in alone)
    for where, name in LEAST:
        monkeypatch.setattr(where, name, 1)
    for n in ("2", "3", "8"):
        monkeypatch.setenv("GEOSURF_THREADS", n)
        assert results(seed, step) == alone


def arrays_of(task):
    """Arrays that a task is given, also by what it is to call."""
    for one in task:
        if isinstance(one, partial):
            yield from arrays_of(one.args)
        elif isinstance(one, tuple):
            yield from arrays_of(one)
        elif isinstance(one, np.ndarray) and one.flags.c_contiguous and one.size:
            yield one


def written_by(work, task):
    """What a task returns, and addresses of the numbers that it changes."""
    arrays = list(arrays_of(task))
    before = [one.tobytes() for one in arrays]
    found, addresses = work(*task), set()
    for one, old in zip(arrays, before, strict=True):
        differ = np.frombuffer(one.tobytes(), np.uint8) != np.frombuffer(old, np.uint8)
        first = one.__array_interface__["data"][0]
        addresses |= {first + at - at % one.itemsize for at in np.flatnonzero(differ).tolist()}
    return found, addresses


def one_by_one(work, rows, worth=True):
    """`map_threads`, backwards; no two tasks may change one number."""
    found, changed = [], set()
    for row in list(rows)[::-1]:
        result, own = written_by(work, row)
        assert not own & changed, f"two tasks of {work} write one number"
        changed |= own
        found.append(result)
    return found[::-1]


@pytest.mark.parametrize("step", [COARSE, 0.0])
def test_no_two_ranges_write_one_number(step, monkeypatch):
    """Also where a race would be too rare to be seen, and in whatever order tasks are done."""
    monkeypatch.setenv("GEOSURF_THREADS", "1")
    alone = results(0, step)
    for where, name in LEAST:
        monkeypatch.setattr(where, name, 1)
    monkeypatch.setenv("GEOSURF_THREADS", "3")
    users = [
        module
        for name, module in list(sys.modules.items())
        if name.startswith("geosurf.") and getattr(module, "map_threads", None) is map_threads
    ]
    for module in users:
        monkeypatch.setattr(module, "map_threads", one_by_one)
    assert results(0, step) == alone


@pytest.mark.parametrize("n_thread", ["1", "2", "3", "8"])
@pytest.mark.parametrize("n_edge", [1, 2, 7, 30])
def test_every_seam_joins(n_thread, n_edge, monkeypatch):
    """Each edge of a chain of parts is all that joins the parts on both sides of it."""
    monkeypatch.setenv("GEOSURF_THREADS", n_thread)
    monkeypatch.setattr(cells, "_SEAMS", 1)
    n = n_edge + 1
    pieces = SimpleNamespace(triangles=np.zeros((n, 3), int), strips=[])
    parts = cells.Parts(np.arange(n), np.arange(n), np.zeros(n, int))

    # parts k and k + 1 meet at edge k, both with their fronts up
    start, ends = 2 * np.arange(n_edge + 1), np.arange(n_edge)
    around = np.stack([2 * ends, 2 * ends + 3], axis=1).ravel()
    seen, piece = cells._joined(pieces, parts, start, around)
    assert piece.tolist() == [0] * n
    assert (seen == seen[0]).all()
    assert seen[0, 0] != seen[0, 1]
