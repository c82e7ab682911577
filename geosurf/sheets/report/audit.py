"""The throw that data on both sides of a fault show, without the sheet: `audit_throw`.

Around each station of a fault, heights of either side are fitted by trends over the data beyond the
trim and continued to the fault. The throw is the difference of both sides. Straight and curved
trends over short and long distances differ where the data do not say how a horizon goes on: that,
and the scatter of the data, is the spread.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from geosurf.arrangement.threads import map_threads
from geosurf.conventions import place
from geosurf.errors import GeosurfWarning
from geosurf.model import FaultCut
from geosurf.model.sheets import ThrowAudit
from geosurf.sheets.faults.fault_distance import NearTrace
from geosurf.sheets.faults.traces import Trace
from geosurf.sheets.heights.state import NearPicks, Trims, near_picks, two_nearest
from geosurf.sheets.mesh.close import Closed

BESIDE = 2  # stations before and after one whose data count for it
# cells beyond the trim over which trends are fitted, and their degrees; the first is the estimate
TRENDS = ((7, 2), (10, 2), (6, 1))
LONGEST = 10  # cells beyond the trim that any trend takes
FEWEST = (8, 16)  # places with data that trends of degree 1 and 2 need on each side
ERRORS = 3.0  # standard errors in the spread
CLEAR = 1.0  # cells beyond the trim of another fault, from which on its smear is not met


@dataclass(frozen=True, eq=False)
class Strip:
    """Data beside a trace by wall, station and cell of distance from the fault beyond the trim.

    Attributes
    ----------
    z, far, along : ndarray (2, n_station, LONGEST)
        Means of elevation [m], distance from the fault and from the station along it [cells]; the
        hanging wall first. NaN where there are none, or another fault is nearer.
    """

    z: np.ndarray
    far: np.ndarray
    along: np.ndarray

    def around(self) -> Strip:
        """The data of BESIDE stations on either side as well, (2, n_station, LONGEST, 5)."""
        n = 2 * BESIDE + 1
        ends = ((0, 0), (BESIDE, BESIDE), (0, 0))
        z, far, along = (
            sliding_window_view(np.pad(a, ends, constant_values=np.nan), n, axis=1)
            for a in (self.z, self.far, self.along)
        )
        return Strip(z, far, along + np.arange(-BESIDE, BESIDE + 1))

    def walls(self, length: int, degree: int) -> tuple[np.ndarray, np.ndarray]:
        """Heights (2, n_station) at which trends meet the fault, and their variances [m]."""
        z, far, along = (
            a[:, :, :length].reshape(*a.shape[:2], -1) for a in (self.z, self.far, self.along)
        )
        there = np.isfinite(z)
        powers = [np.ones_like(far), far, along, far * far][: 2 + degree]
        terms = np.where(there[..., None], np.stack(powers, axis=-1), 0.0)
        z = np.where(there, z, 0.0)

        # normal equations, scaled; those of too few places, or all in one line, have no solution
        normal = np.einsum("...kp,...kq->...pq", terms, terms)
        size = np.sqrt(np.einsum("...pp->...p", normal))
        size = np.where(size == 0.0, 1.0, size)
        normal = normal / size[..., :, None] / size[..., None, :]
        solvable = there.sum(-1) >= FEWEST[degree - 1]
        solvable &= np.linalg.cond(np.where(solvable[..., None, None], normal, 1.0)) < 1e8
        inverse = np.linalg.inv(np.where(solvable[..., None, None], normal, np.eye(2 + degree)))
        inverse = inverse / size[..., :, None] / size[..., None, :]

        shares = np.einsum("...pq,...kq,...k->...p", inverse, terms, z)
        left = z - np.einsum("...kp,...p->...k", terms, shares)
        free = np.maximum(there.sum(-1) - terms.shape[-1], 1)
        variance = (left**2).sum(-1) / free * inverse[..., 0, 0]
        return np.where(solvable, shares[..., 0], np.nan), np.where(solvable, variance, np.nan)


def audit_throw(
    closed: Closed, cuts: Mapping[str, FaultCut], measured: Trims
) -> dict[str, ThrowAudit]:
    """The throw of a sheet and what its data show, by fault, at the stations of its cut-offs."""
    picks, state = closed.picks, closed.built.state
    solver = closed.rebuilt.solver
    trims = [max(pair) for pair in zip(closed.trims.of_fault, measured.of_fault, strict=True)]
    levels = (float(picks.z.min()), float(picks.z.max()))
    near = map_threads(
        near_picks,
        [
            (picks, mesh, trim + LONGEST, levels)
            for mesh, trim in zip(solver.inputs.meshes, trims, strict=True)
        ],
    )
    nearest, _, beyond = two_nearest(near, len(picks.z), trims)

    audits = {}
    for fault, cut in enumerate(cuts.values()):
        traces = [trace for trace in state.network.traces if trace.fault == fault]
        rows = near[fault].rows
        other_distance = np.where(nearest[rows] == fault, beyond[1, rows], beyond[0, rows])
        parts = []
        for trace in traces:
            data = _shown(_strip(closed, trace, near[fault], trims[fault], other_distance < CLEAR))
            first, last = trace.inside
            if "tip" in trace.ends and last - first < 2.0 * (trims[fault] + LONGEST):
                data[:] = np.nan  # displacement dies within half a length: trends reach past it
            parts.append(data)
        data, spread = np.concatenate(parts, axis=1) if parts else np.empty((2, 0))
        audits[cut.fault] = ThrowAudit(
            cut.stations, cut.along, cut.throw, data, spread, trims[fault]
        )
    return audits


def _strip(
    closed: Closed, trace: Trace, near: NearPicks, trim: float, near_other: np.ndarray
) -> Strip:
    """Data beside one trace; picks that another fault is near to end the rows that they are in."""
    picks = closed.picks
    stations = trace.stations
    n, step = len(stations), stations[1] - stations[0]

    # station, wall and cell of each pick; the distance is at its own height, so that it is 0 where
    # its wall ends
    beside = NearTrace(picks.frame, trace, trim + 2.0 * LONGEST)
    row = beside.look_up(picks.nodes_of(near.rows))
    along = (trace.length_at(beside.place[row]) - stations[0]) / step
    cell = np.floor(near.far - trim)
    in_strip = (row >= 0) & (cell >= 0) & (cell < LONGEST) & (along > -0.5) & (along < n - 0.5)
    if closed.trims.use is not None:  # smear that another horizon has shown
        in_strip &= ~closed.trims.use.ignored[near.rows]
    station = np.rint(along[in_strip]).astype(np.int64)
    wall = (near.side[in_strip] < 0).astype(np.int64)
    shape = (2, n, LONGEST)
    key = np.ravel_multi_index((wall, station, cell[in_strip].astype(np.int64)), shape)

    count = np.bincount(key, minlength=2 * n * LONGEST).reshape(shape)
    blocked = np.bincount(key, near_other[in_strip], minlength=count.size).reshape(shape) > 0
    count = np.where(np.logical_or.accumulate(blocked, axis=2), 0, count)
    with np.errstate(invalid="ignore", divide="ignore"):
        means = [
            np.where(
                count, np.bincount(key, a, minlength=count.size).reshape(shape) / count, np.nan
            )
            for a in (picks.z[near.rows[in_strip]], near.far[in_strip], along[in_strip] - station)
        ]
    return Strip(*means)


def _shown(strip: Strip) -> np.ndarray:
    """Throw that data show, and its spread (2, n_station) [m]; NaN where they do not."""
    around = strip.around()
    throws, errors = [], []
    for length, degree in TRENDS:
        heights, variances = around.walls(length, degree)
        throws.append(heights[1] - heights[0])
        errors.append(variances.sum(axis=0))
    best, *others = throws
    off = np.hypot.reduce([0.5 * (best - other) for other in others])
    return np.stack([best, np.hypot(off, ERRORS * np.sqrt(errors[1]))])


def warnings_of_throw(
    name: str,
    audits: Mapping[str, ThrowAudit],
    used: Sequence[float],
    tips: Sequence[GeosurfWarning],
    polygons: Collection[str] = (),
) -> list[GeosurfWarning]:
    """A warning for each fault at which a sheet has another throw than its data show.

    Throw dies towards the tips of a fault that is too short: `tips` name these and what to do.
    Sheets meet the `polygons` of some faults, whatever the data show.
    """
    too_short = {tip.subject for tip in tips}
    warnings = []
    for (fault, audit), trim in zip(audits.items(), used, strict=True):
        worst = audit.worst
        if worst is None or (fault in too_short and audit.trim <= trim):
            continue
        has, shows = (float(throw[worst]) for throw in (audit.sheet, audit.data))
        how = (
            f"Tear with a trim of {audit.trim:g} cells for {fault!r}; it is {trim:g} now"
            if audit.trim > trim
            else f"Look at scene.plot.throw({fault!r}), and give points of both walls there"
        )
        if fault in polygons:
            how = f"The sheet meets the polygon of {fault!r}: correct that, or give sticks instead"
        n, n_shown = int(audit.differs.sum()), int(np.isfinite(audit.data).sum())
        sign = ", of the other sign," if has * shows < 0.0 else ""
        warnings.append(
            GeosurfWarning(
                "throw not as data",
                fault,
                f"Fault {fault!r} has a throw of {has:.3g} m at horizon {name!r} near "
                f"{place(audit.stations[worst])}. Data beyond {audit.trim:g} cells on both sides "
                f"show {shows:.3g} m{sign} with a spread of {audit.spread[worst]:.2g} m. They "
                f"differ at {n} of {n_shown} stations.",
                f"{how}. report.throw[{fault!r}] has both along the fault.",
                tuple(audit.stations[worst].tolist()),
            )
        )
    return warnings
