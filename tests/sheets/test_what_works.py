"""Remedies of a refusal: faults to leave out, each set of them tried."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

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


@pytest.mark.parametrize("name", NAMES)
def test_what_is_named_was_tried(name, monkeypatch):
    """Any single fault that keeps a sheet open is found, whichever is open at first."""
    words, tried = remedy(
        [0, 1, 2, 3], lambda names: set(names) if name in names else (), monkeypatch
    )
    without = [one for one in NAMES if f"'{one}'" not in words]
    assert without == tried[-1] or (not without and name == "F4")
