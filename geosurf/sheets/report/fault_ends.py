"""Throw that data show where a fault ends inside a horizon, and that its sheet does not have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeosurfWarning
from geosurf.model import TriSurface
from geosurf.sheets.faults.traces import Trace, sample
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.report.remedies import end_at, how_to_lengthen

CHORD = 4.0  # cells of the trace by which it is continued straight
SAMPLES = 5  # on each side, a cell apart
SMEAR = 1.5  # trims for each cell of smear, at least: see docs/validation/torn_sheets.md
SPARE = 0.5  # cells beyond trim and half the heave, where they begin
FARTHEST = 64.0  # cells that the continuation is followed
STATIONS = 3  # side by side, of which the median counts
SHARE = 0.15  # of the largest throw: less at a tip is not reported
CLEARLY = 3.0  # times what parallel lines have
ALIKE = 0.25  # of the throw by which profiles across the line may differ where it goes on


@dataclass(frozen=True, eq=False)
class Ahead:
    """The horizon across the continuation of a trace.

    Attributes
    ----------
    tip, along, left : ndarray (2,)
        Where the trace ends, and unit vectors [cells].
    first : float
        Cells from the line at which samples begin.
    """

    tip: np.ndarray
    along: np.ndarray
    left: np.ndarray
    first: float

    def jumps(
        self, grid: np.ndarray, stretch: np.ndarray, first: float, n: int, aside: float = 0.0
    ) -> np.ndarray:
        """Right wall above left one [m], each cell ahead; NaN where data or another fault end.

        Each is drawn straight through `n` places, a cell apart, the nearest `first` cells away.
        """
        # the straight line through samples at `away`, at 0
        away = first + np.arange(n)
        weight = np.linalg.pinv(np.column_stack([np.ones(n), away]))[0]
        heights = self.heights(grid, stretch, away, np.arange(SPARE, FARTHEST), aside)
        return (heights[0] - heights[1]) @ weight

    def heights(
        self, grid: np.ndarray, stretch: np.ndarray, away: np.ndarray, x: np.ndarray, aside: float
    ) -> np.ndarray:
        """Heights (2, n_x, n_away) right and left of the line, `x` cells past the tip."""
        line = self.tip + aside * self.left + x[:, None] * self.along
        at = line[None, :, None] + np.array([-1, 1])[:, None, None, None] * (
            away[:, None] * self.left
        )
        return sample(grid, at.reshape(-1, 2) / stretch).reshape(at.shape[:3])

    def goes_on(self, grid: np.ndarray, stretch: np.ndarray, at: int, throw: float) -> bool:
        """Whether data `grid` look alike past the tip and before it, all across the line."""
        away = np.arange(1.0, self.first + SAMPLES)
        both = []
        for x in (at + np.arange(-1.0, STATIONS - 1), -2.0 - np.arange(STATIONS)):
            heights = self.heights(grid, stretch, away, x, 0.0)
            known = np.isfinite(heights).all(axis=(0, 2))
            if not known.any():
                return False
            both.append(np.median(heights[:, known], axis=1))
        off = both[0] - both[1]
        return bool(np.abs(off - off.mean()).max() < ALIKE * abs(throw))


def throw_at_tips(
    picks: Picks, state: Heights, faults: Sequence[TriSurface], trim: float
) -> list[GeosurfWarning]:
    """A warning for each free end of a fault at which the data still show throw."""
    warnings = []
    for number, trace in enumerate(state.network.traces):
        tips = [end for end in (0, 1) if trace.ends[end] == "tip"]
        if not (tips and len(state.walls[number].place)):
            continue
        grid = _without_others(picks, state, number, trim)
        every = (_at_tip(picks, state, number, k, trim, faults[trace.fault], grid) for k in tips)
        warnings += [warning for warning in every if warning is not None]
    return warnings


def _at_tip(
    picks: Picks,
    state: Heights,
    number: int,
    end: int,
    trim: float,
    fault: TriSurface,
    grid: np.ndarray,
) -> GeosurfWarning | None:
    """A warning if the data, `grid` of `_without_others`, show throw at one end of a trace."""
    name, trace = fault.name, state.network.traces[number]
    walls, frame = state.walls[number], picks.frame

    # height difference across the continuation of the trace [m], one per cell ahead
    place_of = (trace.start, trace.stop)[end]
    ahead = _ahead(trace, end, trim, walls.heave(np.array([place_of]))[0])
    read = partial(ahead.jumps, grid, frame.stretch)
    jumps = read(ahead.first, SAMPLES)
    # some cells past the tip, where throw that dies there is gone; or as far as data reach
    usual = int(np.ceil(ahead.first))
    at = min(usual, max(int(np.append(np.isnan(jumps), True).argmax()) - STATIONS + 1, 1))
    window = slice(at - 1, at - 1 + STATIONS)

    # throw at a tip has the sign that it has on the fault itself
    near = walls.throw[np.argsort(np.abs(walls.place - place_of))[:SAMPLES]]
    sign = float(np.sign(np.median(near)))
    least = SHARE * float(np.abs(walls.throw).max())

    # estimates have to agree: from near and farther off the line, at the tip and, where data reach
    # that far, beyond it; at most tips those from afar show that there is nothing
    closest = ahead.first - SPARE - trim + max(trim / SMEAR, 1.0)
    farther = slice(window.stop, window.stop + STATIONS)
    windows = [part for part in (window, farther) if np.isfinite(jumps[part]).any()]
    throws = [_median(jumps[part]) for part in windows] or [np.nan]
    if all(sign * throw > least for throw in throws):
        # smear hides throw from near the line, but it does so on the fault as well
        nearer = read(closest, 2)
        close = [_median(nearer[part]) for part in windows]
        if at < usual or not all(sign * throw > least for throw in close):
            close = [] if ahead.goes_on(grid, frame.stretch, at, throws[0]) else [np.nan]
        throws += close
    if not all(sign * throw > least for throw in throws):
        return None

    # the same on parallel lines to both sides, where no fault is: what relief alone shows
    beside = 2.0 * (ahead.first + SAMPLES)
    relief = [read(ahead.first, SAMPLES, side)[window] for side in (-beside, beside)]
    seen = np.nan_to_num([_median(np.abs(one)) for one in relief]).max()
    if not all(sign * throw > CLEARLY * seen for throw in throws):
        return None
    throw = throws[0]

    # the throw ends where it falls below the limit, or where the data end
    gone = np.flatnonzero(~(np.abs(jumps) > max(SHARE * abs(throw), CLEARLY * seen)))
    last = int(gone[gone >= at][0]) if (gone >= at).any() else len(jumps)
    known = last < len(jumps) and bool(np.isfinite(jumps[last]))

    # the tip and that end in world coordinates [m]
    level = float(trace.at(place_of)[2])
    cells = np.stack([ahead.tip, ahead.tip + last * ahead.along])
    xy = frame.from_cells(cells)
    first = float(jumps[np.isfinite(jumps)][0])
    far = f"{last * frame.cell:.0f} m" if known else f"at least {last * frame.cell:.0f} m"
    side = end_at(fault, np.array([*xy[0], level]))
    how = (
        "tear with gs.extend_fault(fault, box, sides='strike').surface"
        if side is None
        else how_to_lengthen(name, {side: last * frame.cell})
    )
    return GeosurfWarning(
        "throw at tip",
        name,
        f"Fault {name!r} ends inside horizon {picks.name!r} at {place((*xy[0], level))}, where the "
        f"data show a throw of {first:.3g} m. The sheet has no throw beyond that point; in the "
        f"data it continues for {far}.",
        f"Continue fault {name!r} to about (E {xy[1, 0]:.0f}, N {xy[1, 1]:.0f}): {how}.",
        (*xy[0], level),
    )


def _median(values: np.ndarray) -> float:
    """Median of the values that are known; NaN without any."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else np.nan


def _ahead(trace: Trace, end: int, trim: float, heave: float) -> Ahead:
    """The continuation of a trace past one of its ends."""
    forward, stop = -1.0 if end == 0 else 1.0, trace.inside[end]
    tip, back = trace.at_length([stop, stop - forward * CHORD])[:, :2]

    # the direction of the last cells; the first data aside are beyond trim and half the heave
    along = (tip - back) / max(float(np.hypot(*(tip - back))), 1e-9)
    left = forward * np.array([-along[1], along[0]])
    return Ahead(tip, along, left, trim + SPARE + max(0.5 * float(heave), 0.0))


def _without_others(picks: Picks, state: Heights, number: int, trim: float) -> np.ndarray:
    """Heights (n_row, n_col), NaN beside all other traces: a line must not be drawn across them.

    Data as they are where nodes have some: the sheet ends its throw at the tip.
    """
    grid = state.values.copy()
    if picks.on_nodes:
        grid = np.where(np.isfinite(picks.means), picks.means, grid)
    for other, (trace, near) in enumerate(zip(state.network.traces, state.near, strict=True)):
        if other != number:
            # heights next to another fault belong to its walls
            rows = near.within(trim + 1.0)
            rows = rows[(near.place[rows] >= trace.start) & (near.place[rows] <= trace.stop)]
            grid[near.node[rows]] = np.nan
    return grid.reshape(picks.frame.shape)
