"""Realisations of horizons as picked, whose sheets only the model cuts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import geosurf as gs
from benchmarks.random_networks import random_network
from benchmarks.torn_networks import FAMILIES, TRIMS
from geosurf.ensemble.plan import Plan
from geosurf.ensemble.run import planned
from geosurf.rebuild.closed_sheets import SheetInModel
from geosurf.sheets.mesh import window
from geosurf.sheets.mesh.proof import NotShown
from geosurf.sheets.mesh.repairs import NO_REPAIRS
from geosurf.sheets.tear import tear_from
from geosurf.synthetic.torn_faults import Fault

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
ARRAYS = ("divided", "copies", "ghosts", "outer")


@pytest.fixture(autouse=True)
def windows_of_small_sheets(monkeypatch: pytest.MonkeyPatch) -> None:
    """Look at windows where a small sheet would be cut as a whole."""
    monkeypatch.setattr(window, "FEWEST", 0)
    monkeypatch.setattr(window, "MOST", 1.0)


def realisation(number: int) -> tuple[gs.Sheet, object]:
    """The sheet of a random network, and its data a few metres off."""
    rng = np.random.default_rng([1, number])
    trim, smear = TRIMS[int(rng.integers(len(TRIMS)))]
    world = random_network(FAMILIES[number % len(FAMILIES)], rng, smear)
    base = gs.tear_horizon(world.horizon, world.faults, name="Top", trim=trim)
    x, y = np.meshgrid(*(np.linspace(0.0, 6.0, n) for n in world.horizon.shape[::-1]))
    return base, world.horizon + 5.0 * np.sin(x) * np.cos(y)


def in_model(sheet: gs.Sheet) -> bool:
    """Whether a model shows that a sheet is closed."""
    (west, south), (east, north) = sheet.surface.extent
    z = sheet.lattice.elevation
    box = (west, east, south, north, float(np.nanmin(z)) - 300.0, float(np.nanmax(z)) + 300.0)
    try:
        faults = {fault.name: fault for fault in sheet.faults}
        assert gs.Scene({"Top": sheet}, faults, box).patches.n_triangle
    except NotShown:
        return False
    return bool(sheet.surface.proof.done)


@pytest.mark.parametrize("number", [2, 4])  # an X, and two parallel faults
def test_what_a_model_shows_to_be_closed_is_the_sheet_that_is_cut_alone(
    number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what is left open is not shown, though nobody has looked for holes."""
    base, data = realisation(number)
    assert base.plan is not None
    tears = base.plan, data, base.faults
    cut, uncut = tear_from(*tears, name="Top"), tear_from(*tears, name="Top", uncut=True)
    assert (cut.prove, uncut.prove is None) == (None, False)
    assert in_model(uncut)
    assert all(np.array_equal(getattr(cut, key), getattr(uncut, key)) for key in ARRAYS)
    assert np.array_equal(cut.lattice.elevation, uncut.lattice.elevation)
    assert cut.warnings == uncut.warnings

    # a plan without the remedies that this one has, and windows that show nothing
    monkeypatch.setattr(window.Window, "has", lambda self, nodes: np.zeros(len(nodes), dtype=bool))
    monkeypatch.setattr("geosurf.sheets.mesh.planned.repairs_of", lambda *_: NO_REPAIRS)
    first = tear_from(*tears, name="Top", uncut=True)
    monkeypatch.undo()
    assert first.prove is not None
    assert not in_model(first)


def test_triangles_between_the_walls_of_a_gentle_fault_may_go_unless_they_are_rock() -> None:
    """Those that no curve touches, too."""
    world = gs.synthetic.torn({"F1": Fault(900.0, 1000.0, dip=25.0, throw=80.0)}, n=81)
    base = gs.tear_horizon(world.horizons["Top"], world.faults)
    sheet = tear_from(base.plan, world.horizons["Top"], base.faults, uncut=True)
    seen: list[SheetInModel] = []
    with pytest.raises(AttributeError):  # this proof is never done
        in_model(replace(sheet, prove=lambda lattice: seen.append))
    (found,) = seen
    assert len(found.dropped) > 10
    assert sheet.prove is not None
    proof = sheet.prove(sheet.surface.torn or sheet.surface.lattice)
    proof(found)
    assert proof.done

    # the same where they are clearly on their own side
    listed = replace(found, stays=np.ones_like(found.stays))
    assert not proof._drops_own(replace(listed, dropped=found.dropped[:0]))
    proof.built = replace(proof.built, is_own=lambda nodes: np.ones(len(nodes), dtype=bool))
    assert not proof._drops_own(replace(listed, dropped=found.dropped[:0]))
    assert proof._drops_own(listed)


def plan_of() -> Plan:
    """An ensemble of a horizon that is torn as picked, started."""
    world = gs.synthetic.torn("normal", n=61)
    scene = gs.Scene({"Top": world.horizons["Top"]}, world.faults, tear=True)
    plan, _ = planned(scene, 3, [gs.ensemble.DepthError("Top", sd=4.0, range=900.0)], None, None)
    plan.start()
    return plan


def test_realisations_are_those_whose_sheets_are_cut_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """To the last digit, and each that is built again states why."""
    plan = plan_of()
    records = [plan.run(k) for k in range(3)]
    assert [(one.recut, one.n_torn, one.reason) for one in records] == [("", 1, "")] * 3

    def refuse(*_: object) -> None:
        """Show nothing."""
        raise NotShown("a test asks for it")

    monkeypatch.setattr("geosurf.sheets.mesh.proof.Proof.__call__", refuse)
    others = [plan.run(k) for k in range(3)]
    assert [one.recut for one in others] == ["a test asks for it"] * 3
    assert [repr(one) for one in records] == [repr(replace(one, recut="")) for one in others]
