"""What a scene warns of: kept with results, issued once, listed whatever was asked for first."""

from __future__ import annotations

import copy
import pickle
import warnings

import pytest

import geosurf as gs
from geosurf.cli.console import printed_warnings
from geosurf.scene.memory import Memory
from geosurf.warning import warn

NOTE = gs.GeosurfWarning("spike", "Top", "One node stands out by 900 m.", "Remove it.", (1, 2, 3))
OTHER = gs.GeosurfWarning("area", "box", "The box covers 18 % of the field.", "Give aoi=.")


def told(memory, *notes, key="key"):
    """A step that warns."""
    return memory.get_or_compute("stage", "Top", key, lambda: list(map(warn, notes)), str)


def test_a_step_keeps_its_warnings_and_issues_each_once():
    memory = Memory()
    with warnings.catch_warnings(record=True, action="always") as issued:
        told(memory, NOTE, NOTE, OTHER)
        told(memory, NOTE, OTHER)
        told(memory, OTHER, key="another")
    assert [one.message for one in issued] == [NOTE, OTHER] == memory.warnings
    assert issued[0].filename == __file__  # the line of who asked, not one inside geosurf


def test_results_that_are_shared_carry_their_warnings():
    first, stranger = Memory(), Memory()
    twin = first.twin()
    with pytest.warns(gs.GeosurfWarning):
        told(first, NOTE)
    told(twin, NOTE)  # from memory, and not issued again
    assert twin.warnings == [NOTE]
    assert stranger.warnings == []


def test_a_step_within_a_step_warns_for_both():
    memory = Memory()
    twin = memory.twin()
    with pytest.warns(gs.GeosurfWarning) as issued:
        memory.get_or_compute("outer", "", "outer", lambda: told(memory, NOTE), str)
    assert len(issued) == 1
    twin.get_or_compute("outer", "", "outer", lambda: None, str)
    assert twin.warnings == [NOTE]


def test_a_step_that_fails_has_warned():
    memory = Memory()

    def fail():
        """Warn, then fail."""
        warn(NOTE)
        raise ZeroDivisionError

    with pytest.warns(gs.GeosurfWarning), pytest.raises(ZeroDivisionError):
        memory.get_or_compute("stage", "Top", "key", fail, str)
    assert memory.warnings == [NOTE]


def test_as_errors_they_stop_a_step_once():
    memory = Memory()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(gs.GeosurfWarning, match="stands out"):
            told(memory, NOTE)
        assert told(memory, NOTE) == [None]


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))]
)
def test_copies_keep_them_and_do_not_issue_them_again(again):
    memory = Memory()
    with pytest.warns(gs.GeosurfWarning):
        memory.warn(NOTE)
    other = again(memory)
    assert other.warnings == [NOTE]
    other.warn(NOTE)


def test_the_command_line_prints_each_once(capsys):
    with printed_warnings():
        for note in (NOTE, OTHER, NOTE):
            warnings.warn(note, stacklevel=1)
    assert capsys.readouterr().err.splitlines() == [
        f"geosurf: warning: {note}" for note in (NOTE, OTHER)
    ]


# ---- docs/warnings.md ----------------------------------------------------------------------
