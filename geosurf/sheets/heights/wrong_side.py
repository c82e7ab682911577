"""Picks on the wrong side of a fault: they contradict their own wall and fit the other one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from scipy.spatial import cKDTree

from geosurf.arrangement.threads import map_threads
from geosurf.conventions import counted, place
from geosurf.errors import GeosurfWarning
from geosurf.model import Sheet
from geosurf.model.sheets import SheetReport
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.heights.state import near_picks
from geosurf.sheets.lattice.data import Scattered
from geosurf.sheets.lattice.picks import Picks

# cells from a fault between which a pick may be found to be wrong: noise moves nearer ones across
REACH = (1.0, 12.0)
AROUND = 24  # nearest picks of a wall that a plane is drawn through
FEWEST = 8  # of them on the same side of all faults: with fewer nothing is said
ALIKE = 0.25  # share of the neighbours that contradict alike: no mistake of a pick, but smear
CLEARLY = 8.0  # times what planes miss nearby, half of the neighbours by less
OF_MOST = 0.3  # share of the throw of the fault below which a pick does no harm
SAMPLE = 200  # picks that throw is estimated at
TURNS = 8  # of reweighting, which makes a plane of least squares one of least distances
MOST_NAMED = 5
MOST_AT_ONCE = 20_000  # picks with neighbours in memory
Kind = TypeVar("Kind", bound=Picks)


def without_wrong_picks(
    picks: Kind, meshes: Sequence[FaultMesh], like: Sequence[Sheet]
) -> tuple[Kind, list[dict[str, Any]]]:
    """Picks without those on the wrong side of a fault, and these: see `SheetReport.left_out`.

    Data that have moved from those of other sheets, `like`, are wrong where these are.
    """
    xy = picks.frame.to_world(picks.columns(np.arange(len(picks.z))))
    points = np.column_stack([xy, picks.z])
    reports = [sheet.report for sheet in like if isinstance(sheet.report, SheetReport)]
    known = [one.left_out for one in reports if one.n_data + len(one.left_out) == len(points)]
    if known:
        wrong = {one["row"]: one for left_out in known for one in left_out}
    else:
        wrong = _wrong_picks(picks, points, meshes)
    if not wrong:
        return picks, []
    keep = np.setdiff1d(np.arange(len(points)), list(wrong))
    fewer = {"given_node": picks.node[keep], "z": picks.z[keep]}
    if isinstance(picks, Scattered):
        fewer["uv"] = picks.uv[keep]
    places = {row: tuple(points[row].tolist()) for row in wrong}
    return replace(picks, **fewer), [wrong[row] | {"place": places[row]} for row in sorted(wrong)]


def _wrong_picks(
    picks: Picks, points: np.ndarray, meshes: Sequence[FaultMesh]
) -> dict[int, dict[str, Any]]:
    """Picks on the wrong side of a fault, by row."""
    levels = float(picks.z.min()), float(picks.z.max())
    sides = np.zeros((len(points), len(meshes)), dtype=np.int8)
    far = np.full(sides.shape, np.inf)
    for k, mesh in enumerate(meshes):
        near = near_picks(picks, mesh, 2.0 * REACH[1], levels)
        sides[near.rows, k], far[near.rows, k] = near.side, near.far
    away = far.min(axis=1, initial=np.inf)
    looked = (away > REACH[0])[:, None] & (far <= REACH[1])
    tasks = [
        (points, sides, k, rows, away * picks.frame.cell)
        for k in range(len(meshes))
        for side in (-1, 1)
        if len(rows := np.flatnonzero(looked[:, k] & (sides[:, k] == side))) >= FEWEST
    ]
    return {
        int(row): {"row": int(row), "fault": meshes[task[2]].name, "off": off}
        for task, found in zip(tasks, map_threads(_wrong, tasks), strict=True)
        for row, off in zip(*found, strict=True)
    }


def _wrong(
    points: np.ndarray, sides: np.ndarray, fault: int, rows: np.ndarray, away: np.ndarray
) -> tuple[np.ndarray, list[float]]:
    """Which of some picks on one side of a fault are wrong, and by how much [m].

    `away`: distance of all from the nearest fault [m].
    """
    none: tuple[np.ndarray, list[float]] = np.empty(0, dtype=np.int64), []
    side = sides[rows[:1], fault]
    misfit = _misfit(points, sides, fault, rows, side)
    if misfit is None:
        return none

    # far from the plane of its neighbours, which miss theirs by little, and few of them like it
    off, around = misfit
    all_off = np.full(len(points), np.nan)
    all_off[rows] = off
    near = np.where(around >= 0, all_off[around], np.nan)
    near[np.isnan(near).all(axis=1)] = np.inf
    least = CLEARLY * np.nanmedian(np.abs(near), axis=1)
    alike = (near * np.sign(off)[:, None] > 0.5 * np.abs(off)[:, None]).sum(axis=1)
    is_odd = (np.abs(off) > least) & (away[rows] > least)
    odd = np.flatnonzero(is_odd & (alike < ALIKE * (around >= 0).sum(axis=1)))
    sample = rows[:: max(len(rows) // SAMPLE, 1)]
    other = _misfit(points, sides, fault, np.concatenate([rows[odd], sample]), -side)
    if other is None or not len(odd):
        return none

    # closer to the other wall; and throw over the whole fault: where it dies mistakes do no harm
    good_off = np.abs(all_off[sample] - other[0][len(odd) :])
    off, beyond = off[odd], other[0][: len(odd)]
    wrong = (np.abs(off) > np.abs(beyond)) & (np.abs(off - beyond) > least[odd])
    wrong &= np.abs(off) > OF_MOST * np.nanquantile(good_off, 0.9)
    return rows[odd[wrong]], off[wrong].tolist()


def _misfit(
    points: np.ndarray, sides: np.ndarray, fault: int, rows: np.ndarray, side: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """How far picks are above the plane of their neighbours on a side [m], and which these are.

    Neighbours (n, k) are -1 where they lie beyond another fault, misfits NaN where few are left.
    """
    members = np.flatnonzero(sides[:, fault] == side)
    if len(members) <= FEWEST or not len(rows):
        return None
    tree, n = cKDTree(points[members, :2]), min(AROUND + 1, len(members))
    parts = []
    for chunk in np.array_split(rows, len(rows) // MOST_AT_ONCE + 1):
        around = members[tree.query(points[chunk, :2], k=n)[1]]
        # a side of 0 is far from that fault, which separates nothing there
        apart = sides[chunk, None] * sides[around] < 0
        apart[..., fault] = False
        use = ~apart.any(axis=2) & (around != chunk[:, None])
        off = np.where(
            use.sum(axis=1) < FEWEST, np.nan, _above(points[around] - points[chunk, None], use)
        )
        parts.append((off, np.where(use, around, -1)))
    off, around = (np.concatenate(part) for part in zip(*parts, strict=True))
    return off, around


def _above(shift: np.ndarray, use: np.ndarray) -> np.ndarray:
    """How far picks are above the plane of least distances from neighbours (n, k, 3) in use [m]."""
    design = np.concatenate([np.ones((*shift.shape[:2], 1)), shift[..., :2]], axis=2)
    scale = np.abs(design).max(axis=(0, 1))
    design /= np.where(scale > 0.0, scale, 1.0)
    weight, slight = use.astype(float), 1e-12 * np.eye(3)  # for neighbours on one line
    for _ in range(TURNS):
        moments = np.swapaxes(design * weight[..., None], 1, 2)
        plane = np.linalg.solve(moments @ design + slight, moments @ shift[..., 2:])
        left = np.abs(shift[..., 2] - (design @ plane)[..., 0])
        weight = use / np.maximum(left, 1e-3 * left.max(axis=1, keepdims=True) + 1e-9)
    return -plane[:, 0, 0]


def warning_of(horizon: str, wrong: Sequence[dict[str, Any]]) -> GeosurfWarning:
    """A warning of picks that are left out."""
    named = [f"{place(one['place'])}, {one['off']:+.3g} m at {one['fault']!r}" for one in wrong]
    more = f"; and {len(wrong) - MOST_NAMED} more" if len(wrong) > MOST_NAMED else ""
    most = max(abs(one["off"]) for one in wrong)
    return GeosurfWarning(
        "wrong side",
        horizon,
        f"{counted(len(wrong), 'pick')} of horizon {horizon!r} fit the other wall of a fault and "
        f"contradict the neighbours on their own side: {'; '.join(named[:MOST_NAMED])}{more}. "
        f"They are left out, as throw beside them would be wrong by {most:.3g} m or more.",
        "Correct them in the data. gs.tear_horizon(..., keep_outliers=True), or keep_outliers = "
        "true in [tear], keeps them.",
        wrong[0]["place"],
    )
