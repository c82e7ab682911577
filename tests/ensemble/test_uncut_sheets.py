"""Realisations whose sheets only the model cuts: as those whose sheets are cut alone first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.ensemble import models
from geosurf.ensemble.plan import Plan
from geosurf.ensemble.run import planned
from geosurf.errors import GeosurfError
from geosurf.sheets.mesh.proof import NotShown, Proof, is_proven
from geosurf.sheets.throw import best_attempt
from geosurf.sheets.throw.throw_horizon import throw_horizon_uncut
from geosurf.warning import silenced

BOX = (50.3, 940.0, 60.1, 930.0, -1600.0, -500.0)
# worlds that can be built, five of them only after some attempts
SEEDS = (100, 102, 105, 106, 107, 108, 109, 110, 113, 116, 117, 119, 122, 126, 128, 129)
MESH = ("divided", "copies", "ghosts", "outer")


def any_fault(rng: np.random.Generator, name: str) -> tuple[gs.TriSurface, object]:
    """A fault through the horizon or with tips in it, rough or plane, and its throw."""
    half = float(rng.choice([250.0, 400.0, 900.0]))
    strike, dip, rough = rng.uniform(0, 6.28), rng.uniform(0.6, 1.5), rng.choice([0.0, 2.0, 8.0])
    centre, depth = rng.uniform(300.0, 700.0, 2), float(rng.choice([60.0, 150.0, 300.0]))
    s, d = np.meshgrid(np.linspace(-half, half, 12), np.linspace(-depth, depth, 6), indexing="ij")
    along, across = np.array([np.sin(strike), np.cos(strike)]), [np.cos(strike), -np.sin(strike)]
    xy = centre + s[..., None] * along - (d / np.tan(dip))[..., None] * across
    points = np.dstack([xy + rough * rng.normal(size=xy.shape), d - 1000.0])
    q = (np.arange(11)[:, None] * 6 + np.arange(5)).ravel()
    faces = np.concatenate([np.stack([q, q + 6, q + 1], 1), np.stack([q + 1, q + 6, q + 7], 1)])
    most = rng.uniform(-60.0, 60.0)
    dying = np.array([[0, 0], [half * 0.5, most * 0.5], [half, most], [2 * half, 0.0]])
    fault = gs.TriSurface(name, "fault", points.reshape(-1, 3), faces)
    return fault, most if half == 900.0 else dying


def any_world(seed: int) -> tuple[xr.DataArray, list[gs.TriSurface], dict[str, object]]:
    """A horizon, one or two faults, and their throws."""
    rng = np.random.default_rng(seed)
    at = np.linspace(0, 1000, 23)
    x, y = np.meshgrid(at, at)
    z = -1000 + 20 * np.sin(x / 200 + rng.uniform(0, 6)) + 20 * np.cos(y / 170)
    z += rng.normal(size=z.shape) * rng.choice([0, 0.5, 3])
    coords = {"northing": at, "easting": at}
    data = xr.DataArray(z, coords, attrs={"units": "m", "positive": "up"}, name="Top")
    made = [any_fault(rng, f"F{k}") for k in range(rng.integers(1, 3))]
    return data, [fault for fault, _ in made], {fault.name: throw for fault, throw in made}


def in_model(sheet: gs.Sheet, faults: list[gs.TriSurface]) -> bool:
    """Whether a model shows that a sheet is closed."""
    corners = [[x, y, -1500.0] for x, y in ((0, 0), (1000, 0), (1000, 1000), (0, 1000))]
    base = gs.TriSurface("Base", "horizon", corners, [[0, 1, 2], [0, 2, 3]])
    scene = gs.Scene({"Top": sheet, "Base": base}, {one.name: one for one in faults}, BOX)
    try:
        with silenced():
            assert scene.patches.n_triangle
    except (GeosurfError, NotShown):
        return False
    return is_proven([sheet])


def test_what_a_model_shows_to_be_closed_is_the_sheet_of_throw_horizon(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And what needs attempts to close it is shown of none."""
    attempts: list[tuple[int, bool]] = []
    build = best_attempt.build

    def counted(*given: object, **words: object) -> object:
        """A mesh, and how many cuts it took."""
        built = build(*given, **words)
        attempts.append((built.n_cut, built.is_open))
        return built

    monkeypatch.setattr(best_attempt, "build", counted)
    n_shown = n_closed = n_later = 0
    for seed in SEEDS:
        data, faults, throw = any_world(seed)
        attempts.clear()
        sheet = gs.throw_horizon(data, faults, throw, name="Top")
        first = attempts[:1] == [(1, False)]
        assert sheet.report.attempts == sum(n_cut for n_cut, _ in attempts)
        uncut = throw_horizon_uncut(data, faults, throw, name="Top")
        shown = uncut.prove is not None and in_model(uncut, faults)
        assert first or not shown
        n_shown, n_closed, n_later = n_shown + shown, n_closed + first, n_later + (not first)
        if shown:
            assert all(np.array_equal(getattr(sheet, k), getattr(uncut, k)) for k in MESH)
            assert np.array_equal(sheet.lattice.elevation, uncut.lattice.elevation)
    # the law says something about both kinds, and most closed sheets are shown to be so
    assert n_later == 5
    assert n_shown > 0.8 * n_closed


def plan_of(n: int, uncertain: list[object], names: tuple[str, ...] = ("Top",)) -> Plan:
    """An ensemble of the graben, started."""
    world = gs.synthetic.graben(n=n)
    horizons = {name: world.horizons[name] for name in names}
    scene = gs.Scene(horizons, {"F1": world.faults["F1"]}, world.box)
    plan, _ = planned(scene, 3, uncertain, None, None)
    plan.start()
    return plan


def test_realisations_are_the_same_where_the_model_shows_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each is built again then, with sheets that are cut alone, and states why."""
    plan = plan_of(31, [gs.ensemble.Throw("F1", gs.ensemble.Normal(50.0, 20.0))])
    records = [plan.run(k) for k in range(3)]
    assert [one.recut for one in records] == [""] * 3

    def refuse(*_: object) -> None:
        """Show nothing."""
        raise NotShown("a test asks for it")

    monkeypatch.setattr(Proof, "__call__", refuse)
    others = [plan.run(k) for k in range(3)]
    assert [one.recut for one in others] == ["a test asks for it"] * 3
    assert [repr(one) for one in records] == [repr(replace(one, recut="")) for one in others]
    assert all(not one.reason for one in records)

    # a model whose sheets were moved does not ask
    monkeypatch.setattr(Proof, "__call__", lambda *_: None)
    assert plan.run(0).recut == "repairs have moved vertices of the sheets"


@pytest.mark.parametrize("where", ["proof", "sheet"])
def test_a_defect_of_uncut_sheets_is_not_hidden(
    monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    """It fails the realisation, which is not built in another way."""
    plan = plan_of(21, [gs.ensemble.Throw("F1", gs.ensemble.Normal(50.0, 20.0))])

    def broken(*_: object, **__: object) -> None:
        """Fail as a mistake in the code does."""
        raise IndexError("a mistake")

    if where == "proof":
        monkeypatch.setattr(Proof, "_loses_a_wall", broken)
    else:
        monkeypatch.setattr(models, "throw_horizon_uncut", broken)
    assert plan.run(0).reason == "IndexError: a mistake"


def test_horizons_that_need_attempts_are_cut_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """As the base case shows: in every process, so that records do not depend on workers."""
    plan = plan_of(21, [gs.ensemble.Throw("F1", gs.ensemble.Normal(50.0, 9.0))], ("Top", "Base"))
    assert plan.model.closed_at_once == {"Top", "Base"}
    plan.model.closed_at_once = frozenset({"Base"})
    made: list[str] = []
    uncut = models.throw_horizon_uncut

    def counted(*given: object, name: str, **words: object) -> object:
        """A sheet that nobody has cut, and its name."""
        made.append(name)
        return uncut(*given, name=name, **words)

    monkeypatch.setattr(models, "throw_horizon_uncut", counted)
    record = plan.run(0)
    assert (made, record.reason, record.recut) == (["Base"], "", "")
    plan.model.closed_at_once = frozenset()
    assert plan.run(0).volumes == record.volumes
    assert made == ["Base"]


def test_a_horizon_that_stays_keeps_the_sheet_of_the_base_case() -> None:
    """Nothing is torn again where neither the horizon nor a throw has moved."""
    error = gs.ensemble.DepthShift("Top", gs.ensemble.Normal(0.0, 5.0))
    plan = plan_of(21, [error, gs.ensemble.Throw("F1", 60.0)], ("Top", "Base"))
    base, one = plan.scene(None), plan.scene(1)
    assert one.sheets["Base"] is base.sheets["Base"]
    assert one.sheets["Top"] is not base.sheets["Top"]
