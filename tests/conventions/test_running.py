"""The line that shows what is running: after a while, where somebody watches, then gone."""

from __future__ import annotations

import os
import sys
import time

import pytest

import geosurf as gs
from geosurf.conventions import running as module
from geosurf.conventions.running import count_of, running, silence


def until(condition):
    """Wait for another thread; a loaded machine may take its time."""
    end = time.monotonic() + 20.0
    while not condition() and time.monotonic() < end:
        time.sleep(0.005)
    assert condition()


@pytest.fixture
def lines(monkeypatch):
    """What is shown, within milliseconds."""
    shown: list[str] = []
    monkeypatch.setattr(module, "_board", module._Board())
    monkeypatch.setattr(module, "_sink", lambda: shown.append)
    for name, seconds in (("AFTER", 0.03), ("EVERY", 0.01), ("GRACE", 0.01)):
        monkeypatch.setattr(module, name, seconds)
    return shown


def test_the_outermost_and_the_innermost_step_are_named_and_the_line_goes(lines):
    count_of("tear Top", 2, 4)
    with running("report"):
        until(lambda: any(line.startswith("report, 0 s") for line in lines))
        with running("scene"), running("tear Top"):
            until(lambda: any("report, tear Top (2 of 4)" in line for line in lines))
    assert lines[-1] == ""
    assert not any("scene" in line for line in lines)
    until(lambda: module._board.watcher is None)


@pytest.mark.parametrize("how", ["silence", "show_progress", "environment"])
def test_it_is_silent_on_request(how, lines, monkeypatch):
    if how == "environment":
        monkeypatch.setenv("GEOSURF_PROGRESS", "off")
    if how == "show_progress":
        gs.show_progress(False)
        gs.show_progress(False)
    try:
        with silence() if how == "silence" else running("outside"), running("inside"):
            assert module._board.watcher is None
    finally:
        gs.show_progress()
    monkeypatch.delenv("GEOSURF_PROGRESS", raising=False)
    with running("again"):
        until(lambda: lines)


def test_nobody_watches_a_pipe_and_somebody_a_terminal(monkeypatch):
    assert module._sink() is None
    master, slave = os.openpty()
    with os.fdopen(slave, "w") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        show = module._sink()
        show("tear Top, 2 s ...")
        show("")
        expected = b"\r\x1b[Ktear Top, 2 s ...\r\r\x1b[K\r"
        found = b""
        while len(found) < len(expected):  # one read may end between two lines
            found += os.read(master, 99)
        assert found == expected
    os.close(master)


def test_a_scene_announces_its_steps_unless_its_caller_does(lines, monkeypatch):
    world, seen = gs.synthetic.tilted_planes(n=5), []
    steps = []
    monkeypatch.setattr(module._board, "push", lambda words, show: steps.append(words))
    monkeypatch.setattr(module._board, "pop", lambda words: None)
    assert gs.Scene(world.horizons, world.faults, world.box).units
    assert any("units" in step or "carve" in step for step in steps)
    steps.clear()
    assert gs.Scene(
        world.horizons, world.faults, world.box, on_start=lambda *s: seen.append(s)
    ).units
    assert seen
    assert steps == []
