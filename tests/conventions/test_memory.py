"""Freed memory goes back to the system, and facts of certificates go with their last user."""

from __future__ import annotations

import gc
import sys
import weakref
from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf.carve.certificate.facts import Facts
from geosurf.conventions.machine import give_back_memory


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
