"""A sheet cut island by island is the sheet cut as one."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from benchmarks.geology import torn_sources
from geosurf.sheets.mesh import cut
from geosurf.sheets.mesh import cut as islands


@pytest.fixture
def told(monkeypatch):
    """Function that makes islands of some least size, and the list of those that were cut."""
    found: list[list[list[int]]] = []

    def of_at_least(least: int) -> list[list[list[int]]]:
        monkeypatch.setattr(islands, "LEAST", least)
        monkeypatch.setattr(cut, "islands", told_islands)
        return found

    def told_islands(*given):
        parts = islands.islands(*given)
        rows = np.concatenate([rows for rows, _ in parts])
        assert np.array_equal(np.sort(rows), np.arange(len(given[1])))
        found.append([faults for _, faults in parts])
        return parts

    return of_at_least


def _all_of(sheet) -> list[np.ndarray]:
    arrays = [sheet.copies, sheet.ghosts, sheet.outer, sheet.lattice.elevation]
    for of in sheet.cuts.values():
        arrays += [of.throw, of.heave, *(line for lines in of.cutoffs.values() for line in lines)]
    return arrays


def test_islands_change_nothing(told):
    sources = torn_sources(245)
    faults = {name: fault for role, name, fault in sources if role == "fault"}
    one = gs.triangulate_fault(faults["F1"], name="one")
    for name, away in {"deep": [0.0, 0.0, -9000.0], "far": [90000.0, 0.0, 0.0]}.items():
        faults[name] = gs.TriSurface(name, "fault", one.vertices + away, one.triangles)
    data = next(grid for role, _, grid in sources if role == "horizon")
    cuts = told(1)
    apart = gs.tear_horizon(data, faults)
    assert 1 < len(cuts[-1]) < len(faults)  # some are near one another
    assert sorted(k for part in cuts[-1] for k in part) == list(range(len(faults)))
    assert len(apart.cuts["deep"].along) == len(apart.cuts["far"].along) == 0  # met nowhere
    told(10**9)
    whole = gs.tear_horizon(data, faults)
    assert len(cuts[-1]) == 1
    for one, two in zip(_all_of(apart), _all_of(whole), strict=True):
        assert one.tobytes() == two.tobytes()
