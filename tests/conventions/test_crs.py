"""Units of reference systems: metres, or refused; never taken for metres because nobody knows."""

from __future__ import annotations

import gc
import sys
import weakref
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf.carve.certificate_facts import Facts
from geosurf.conventions import checks, shift_is_exact
from geosurf.conventions.crs import METRIC
from geosurf.conventions.machine import give_back_memory
from geosurf.errors import InputError


@pytest.mark.parametrize("crs", ["EPSG:2276", "EPSG:32664", "urn:ogc:def:crs:EPSG::2278"])
@pytest.mark.parametrize("there", [False, True])
def test_a_code_in_feet_is_refused_with_and_without_pyproj(monkeypatch, crs, there):
    if there:
        pytest.importorskip("pyproj", reason="pyproj is not installed (extra crs)")
    else:
        monkeypatch.setitem(sys.modules, "pyproj", None)
    gs.conventions.crs._metres.cache_clear()
    world = gs.synthetic.tilted_planes(n=5)
    world.horizons["Top"].attrs["crs"] = crs
    with pytest.raises(InputError, match=r"may be in feet\. Install it: pip|are in feet"):
        gs.Scene(world.horizons, world.faults, world.box).units  # noqa: B018
    gs.conventions.crs._metres.cache_clear()


def test_codes_that_need_no_pyproj_are_in_metres():
    CRS = pytest.importorskip("pyproj", reason="pyproj is not installed (extra crs)").CRS
    from pyproj.exceptions import CRSError

    known = 0
    for code in range(1024, 32768):
        if METRIC.fullmatch(str(code)):
            try:
                axes = CRS.from_epsg(code).axis_info
            except CRSError:
                continue
            assert all(axis.unit_conversion_factor == 1.0 for axis in axes), code
            known += 1
    assert known > 500


@pytest.mark.parametrize(("unit", "metres"), [("metre", 1.0), ("US survey foot", 0.3048006096)])
@pytest.mark.parametrize("words", ["VERT_CS", "VERTCRS"])
def test_the_vertical_part_of_a_system_is_in_metres_or_refused(unit, metres, words):
    height = f'{words}["NAVD88 height",UNIT["{unit}",{metres}]]'
    world = gs.synthetic.tilted_planes(n=5)
    flat = 'PROJCS["A",UNIT["metre",1]]'
    for one in world.horizons.values():
        one.attrs["crs"] = f'COMPD_CS["B",{flat},{height}]'
    scene = gs.Scene(world.horizons, world.faults, world.box)
    if metres == 1.0:
        assert len(scene.units)
        return
    with pytest.raises(InputError, match=r"vertical part of .* is in units of 0\.304801 m"):
        scene.units  # noqa: B018


# ---- Which shifts of coordinates lose nothing.
@pytest.mark.parametrize("shape", [(7,), (7, 5), (0,), (3, 0)])
@pytest.mark.parametrize("at_once", [1, 4, 1000])
def test_a_shift_is_exact_if_that_of_every_coordinate_is(shape, at_once, rng, monkeypatch):
    """Coordinates are looked at some at a time; the answer is that of rational numbers."""
    monkeypatch.setattr(checks, "_AT_ONCE", at_once)
    values, shift = 456_000.0 + rng.integers(0, 9000, shape) / 8.0, 455_680.0
    if values.size:
        values.flat[-1] = np.nan
    assert shift_is_exact(values, shift)
    for k in range(values.size - 1):
        odd = values.copy()
        odd.flat[k] = 1e-9
        assert Fraction(odd.flat[k]) - Fraction(shift) != Fraction(odd.flat[k] - shift)
        assert not shift_is_exact(odd, shift)


# ---- Freed memory goes back to the system, and facts of certificates go with their last user.
def _resident() -> int:
    """Bytes of memory that this process has."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


@pytest.mark.skipif(sys.platform != "linux", reason="the system tells its memory elsewhere")
def test_freed_memory_goes_back():
    # every second array is freed: a heap with gaps
    held = [np.ones(1 << 13) for _ in range(2000)]
    del held[::2]
    before = _resident()
    give_back_memory()
    assert before - _resident() > 30 << 20
    assert len(held) == 1000


def test_facts_go_with_their_last_user():
    """They are as large as the model, and the second run of a certificate comes after them."""
    world = gs.synthetic.tilted_planes()
    facts = Facts.of(gs.Scene(world.horizons, world.faults, world.box).patches)
    gone = weakref.ref(facts)
    gc.disable()
    try:
        del facts
        assert gone() is None
    finally:
        gc.enable()
