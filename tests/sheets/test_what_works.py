"""Remedies of a refusal: faults to leave out, each set of them tried."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from geosurf.errors import GeometryError
from geosurf.sheets import tear as attempts
from geosurf.sheets.heights.state import Trims

NAMES = ("F1", "F2", "F3", "F4")


def remedy(bad, open_at, monkeypatch):
    """The remedy where `open_at(names)` are the faults at which a sheet of some stays open."""
    faults = [SimpleNamespace(name=name) for name in NAMES]
    closed = SimpleNamespace(given_trims=Trims((2.0,) * 4))
    monkeypatch.setattr(attempts, "_throw_at", lambda closed, gone: 12.0)
    monkeypatch.setattr(attempts, "close_at_any_cost", lambda closed: closed)
    monkeypatch.setattr(attempts.Torn, "of", staticmethod(lambda closed: closed.owner))
    tried = []

    def torn(some, trims, given, most):
        names = [fault.name for fault in some]
        assert len(trims.of_fault) == len(names)
        assert given == trims
        tried.append(names)
        built = SimpleNamespace(is_hopeless=False)
        sheet = SimpleNamespace(bad={names.index(name) for name in open_at(names)})
        sheet.closed = SimpleNamespace(built=built, owner=sheet, n_cut=1)
        return sheet

    return attempts._what_works(bad, faults, closed, attempts.Search(torn)), tried


def test_one_fault_is_enough(monkeypatch):
    words, _ = remedy(
        [0, 2], lambda names: {"F1"} & set(names) if "F3" in names else (), monkeypatch
    )
    assert words == (
        "Without fault 'F1' the horizon closes, and bends there over 12 m of throw: leave it out."
    )


def test_others_stay_open_without_the_open_ones(monkeypatch):
    """F2 stays open without F1, and F4 without both; the last sheet is closed."""

    def open_at(names):
        return {name for name in ("F1", "F2", "F4") if name in names[:2]}

    words, tried = remedy([0], open_at, monkeypatch)
    assert "Without faults 'F1', 'F2', 'F4' the horizon closes" in words
    assert "leave them out" in words
    assert tried[-1] == ["F3"]


def test_a_horizon_that_no_set_of_faults_tears_is_closed_without_any(monkeypatch):
    def open_at(names):
        raise GeometryError("no data")

    words, tried = remedy([1], open_at, monkeypatch)
    assert "'F1', 'F2', 'F3', 'F4'" in words
    assert tried == [["F1", "F3", "F4"]]


@pytest.mark.parametrize("name", NAMES)
def test_what_is_named_was_tried(name, monkeypatch):
    """Any single fault that keeps a sheet open is found, whichever is open at first."""
    words, tried = remedy(
        [0, 1, 2, 3], lambda names: set(names) if name in names else (), monkeypatch
    )
    without = [one for one in NAMES if f"'{one}'" not in words]
    assert without == tried[-1] or (not without and name == "F4")


@pytest.mark.parametrize(("n_cut", "forced"), [(1, 6), (16, 2), (200, 1)])
def test_cuts_for_a_sheet_that_stays_open_are_limited(n_cut, forced, monkeypatch):
    """With the trims as given a sheet is closed at a loss whatever it takes, then up to a limit."""
    built = SimpleNamespace(is_hopeless=False, cut=SimpleNamespace(holes=[]))
    open_sheet = SimpleNamespace(bad={0}, loss=float("inf"))
    open_sheet.closed = SimpleNamespace(built=built, n_cut=n_cut)
    tried = []
    monkeypatch.setattr(attempts, "close_at_any_cost", tried.append)
    monkeypatch.setattr(attempts.Torn, "of", staticmethod(lambda closed: open_sheet))
    monkeypatch.setattr(attempts, "_torn", lambda *args, **options: open_sheet)
    monkeypatch.setattr(attempts, "_first", lambda search, *rest: search.torn(*rest[:2]))
    monkeypatch.setattr(attempts, "_other_trims", lambda *args: [Trims((2.0,))] * 5)
    monkeypatch.setattr(attempts, "trims_of", lambda *args: None)
    monkeypatch.setattr(attempts, "shows_smear", lambda *args: False)
    refused = []
    monkeypatch.setattr(attempts, "_refuse", lambda *args: refused.append(args[0]))
    attempts.torn_sheet(SimpleNamespace(picks=None, cutoffs={}), [], Trims((2.0,)))
    assert len(tried) == forced
    assert refused == [open_sheet]
