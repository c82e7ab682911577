"""Passes over ranges of triangles, edges and records in threads: the bytes of one thread."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.arrangement import arrange
from geosurf.carve import half_faces, measures, seams
from geosurf.errors import GeosurfError
from geosurf.rebuild import assemble, carried, edges, repair
from tests.scene.test_moved_surfaces import BOX, COARSE, fault, horizon, result
from tests.strategies import sheet

# horizons cross and lie in the wrong order here, on purpose
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
LEAST = [
    (arrange, "_RECORDS_OF_A_THREAD"),
    (assemble, "_MANY"),
    (carried, "_TRIANGLES"),
    (edges, "_TRIANGLES"),
    (repair, "_MANY"),
    (seams, "_TRIANGLES"),
    (seams, "_EDGES"),
    (seams, "_PARENTS"),
    (half_faces, "_SEAMS"),
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
