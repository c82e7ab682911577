"""Compare the walls of a fault: which layers face each other, and what has slipped past a point.

What has slipped past a point of a fault is the rock between the two layers that face each other
there. Each wall has its own copy of that rock: from the point to where the layer of the other wall
lies on this one. Walls are compared at one distance along the mean strike, as in the Allan diagram.

Within one polygon of the diagram a layer of the other wall lies at the same share of its zone. So
all breaks of the ratio are borders of polygons. Inside, along a line down the fault, shale and
throw are linear in elevation; along the strike they are ratios of such functions. Triangles of the
polygons are divided until the ratio is linear on each to `PRECISION`; where zones are parallel,
that is the case at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.kernels.lattices.sets import is_among, pairs_of_equal
from geosurf.kernels.meshes.mesh import edge_keys
from geosurf.measure.faces import MINUS, PLUS, POINTS, Faces

PRECISION = 1e-3  # of the ratio, halfway along the edges of triangles
DIVISIONS = 6  # at most: where layers pinch out the ratio jumps
SAME = 1e-3  # a cut-off that turns back along strike by less has not turned [m]


Line = tuple[np.ndarray, np.ndarray]  # distance along strike, rising, and elevation


class Walls:
    """Cut-offs on both walls of a fault, and what has slipped past its points.

    Cut-offs are told apart by the blocks that the zones between two horizons have: on both sides of
    another fault that crosses, a horizon lies at two elevations. Over- and underburden take the
    lines of the block that is next to them along strike.

    Parameters
    ----------
    faces : Faces
    horizons : ndarray of int64
        Keys of the edges of all horizons, see `edges_of`.
    vshale : sequence of float
        By zone, youngest first.
    shale : float
        Zones with this Vshale, or more, are source beds of smear.
    """

    def __init__(
        self, faces: Faces, horizons: np.ndarray, vshale: Sequence[float], shale: float
    ) -> None:
        self.faces, self.vshale, self.n_horizon = faces, np.array(vshale), len(vshale) - 1
        self.blocks = list(dict.fromkeys(unit.block for unit in faces.listed))
        self.block = np.array([self.blocks.index(unit.block) for unit in faces.listed])
        is_bed = np.append(self.vshale >= shale, False)
        ends = np.flatnonzero(np.diff(is_bed, prepend=False)).reshape(-1, 2)
        self.beds = [(a, b - 1) for a, b in ends.tolist()]
        self.reach: dict[tuple[int, int], tuple[float, float]] = {}  # of blocks along strike
        self.lines = [self._lines(side, horizons) for side in (PLUS, MINUS)]

    def _lines(self, side: int, horizons: np.ndarray) -> dict[int, list[Line | None]]:
        """Cut-offs on one wall, by block and horizon."""
        faces = self.faces
        rows = np.flatnonzero(faces.sides[:, side] >= 0)
        key = edge_keys(faces.triangles[rows], len(faces.x))
        one, two = pairs_of_equal(key, np.arange(len(key)))
        units = faces.sides[rows, side][np.stack([one, two], axis=1) // 3]
        ends = np.stack(np.divmod(key[one], len(faces.x)), axis=1)
        a, b = faces.point[ends].T
        cut = (np.diff(faces.zones[units], axis=1).ravel() != 0) & is_among(
            a * POINTS + b, horizons
        )
        ends, zones, blocks = (
            ends[cut],
            np.sort(faces.zones[units[cut]], axis=1),
            self.block[units[cut]],
        )

        # blocks of zones between two horizons; without any, all
        there = faces.sides[rows, side]
        inner = (faces.zones[there] > 0) & (faces.zones[there] < self.n_horizon)
        owners = np.unique(self.block[there[inner]] if inner.any() else self.block[there]).tolist()
        s = faces.along(faces.x[ends].reshape(-1, 3)).reshape(-1, 2)
        owned = {block: (blocks == block).any(axis=1) for block in owners}
        for block, beside in owned.items():
            if beside.any():
                self.reach[side, block] = float(s[beside].min()), float(s[beside].max())

        # cut-offs between over- and underburden are of the blocks next to them
        alone = ~np.any([*owned.values(), np.zeros(len(ends), dtype=bool)], axis=0)
        next_to = self.owners(side, np.full(len(ends), -1), s.mean(axis=1))
        lines = {}
        for block, beside in owned.items():
            if (side, block) in self.reach:
                rows = np.flatnonzero(beside | (alone & (next_to == block)))
                lines[block] = [
                    self._line(ends[rows], s[rows], (zones[rows, 0] <= k) & (zones[rows, 1] > k))
                    for k in range(self.n_horizon)
                ]
        return lines

    def owners(self, side: int, blocks: np.ndarray, s: np.ndarray) -> np.ndarray:
        """Blocks whose lines count on a wall: the same, or those next to it along strike."""
        owning, least = np.full(len(s), -1), np.full(len(s), np.inf)
        for (on, block), (low, high) in self.reach.items():
            if on == side:
                beyond = np.where(
                    blocks == block, -1.0, np.maximum(np.maximum(low - s, s - high), 0.0)
                )
                owning, least = np.where(beyond < least, block, owning), np.minimum(beyond, least)
        return owning

    def _line(self, ends: np.ndarray, s: np.ndarray, chosen: np.ndarray) -> Line | None:
        """The line between what lies above a horizon and below it; None where there is none.

        NaN from where it turns back along strike to where it is over that: several layers face
        each other there.
        """
        if not chosen.any():
            return None
        ends, s = ends[chosen], s[chosen]
        along, first, at = np.unique(s, return_index=True, return_inverse=True)
        z = self.faces.x[ends.ravel()[first], 2]
        if np.abs(np.diff(s, axis=1)).sum() > np.ptp(s) + SAME:
            at = np.sort(at.reshape(s.shape), axis=1)
            times = np.cumsum(np.bincount(at[:, 0], minlength=len(z))
                              - np.bincount(at[:, 1], minlength=len(z)))  # fmt: skip
            several = np.flatnonzero(times > 1)
            z[[several, several + 1]] = np.nan
        return along, z

    @cached_property
    def slopes(self) -> list[float]:
        """Mean slope of each horizon along strike, of all its lines on this fault."""
        by_horizon = []
        for level in range(self.n_horizon):
            lines = [of[level] for wall in self.lines for of in wall.values()]
            known = [np.array(of)[:, np.isfinite(of[1])] for of in lines if of is not None]
            parts = [line - line.mean(axis=1)[:, None] for line in known if line.size]
            below = sum(float(s @ s) for s, _ in parts)
            by_horizon.append(sum(float(s @ z) for s, z in parts) / below if below > 0.0 else 0.0)
        return by_horizon

    def levels(self, side: int, block: int, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Elevation of each horizon on a wall (n, n_horizon), NaN for none; which are assumed."""
        z = np.full((len(s), self.n_horizon), np.nan)
        assumed = np.zeros(z.shape, dtype=bool)
        for k, line in enumerate(self.lines[side][block]):
            if line is not None:
                beyond = s - np.clip(s, line[0][0], line[0][-1])
                z[:, k] = np.interp(s, *line) + self.slopes[k] * beyond
                assumed[:, k] = abs(beyond) > SAME

        # lines that were continued may cross: zones do not become negative
        held = np.where(np.isnan(z), np.inf, z)
        return np.where(np.isnan(z), np.nan, np.minimum.accumulate(held, axis=1)), assumed

    def slipped(self, points: np.ndarray, zones: np.ndarray, blocks: np.ndarray) -> Slipped:
        """
        Return what has slipped past points of the fault.

        Parameters
        ----------
        points : ndarray of float64, shape (n, 3)
            Local [m].
        zones, blocks : ndarray of int64, shape (n, 2)
            Zone index, and row of `Walls.blocks`, on side + and on side -.
        """
        n, s, z = len(points), self.faces.along(points), points[:, 2]
        sgr, throw = np.full((n, 2), np.nan), np.full((n, 2), np.nan)
        slips = Slipped(sgr, throw, np.full(n, np.nan), np.zeros(n, dtype=bool))
        both = [self.owners(side, blocks[:, side], s) for side in (PLUS, MINUS)]
        key = np.where(np.minimum(*both) < 0, -1, both[0] * len(self.blocks) + both[1])
        for pair in np.unique(key[key >= 0]).tolist():
            plus, minus = divmod(pair, len(self.blocks))
            rows = np.flatnonzero(key == pair)
            walls = [self.levels(PLUS, plus, s[rows]), self.levels(MINUS, minus, s[rows])]
            self._compare(slips, rows, z[rows], zones[rows], walls)
        return slips

    def at_corners(self, corners: np.ndarray, sides: np.ndarray) -> Slipped:
        """The same at corners of triangles (n, 3, 3) with their units (n, 2)."""
        zones, blocks = (np.repeat(of[sides], 3, axis=0) for of in (self.faces.zones, self.block))
        return self.slipped(corners.reshape(-1, 3), zones, blocks)

    def divided(
        self, corners: np.ndarray, sides: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, Slipped, np.ndarray]:
        """
        Divide triangles until the ratio is linear on each.

        Returns
        -------
        corners : ndarray of float64, shape (m, 3, 3)
        row : ndarray of int64, shape (m,)
            Of the triangle that each is a part of, rising.
        values : Slipped
            At the corners.
        linear : ndarray of bool, shape (m,)
            Where the ratio is linear to `PRECISION`.
        """
        row = np.arange(len(corners))
        done: list[tuple[np.ndarray, ...]] = []
        for division in range(DIVISIONS + 1):
            middle = 0.5 * (corners + np.roll(corners, -1, axis=1))
            at = self.ratio(corners, sides[row])
            off = np.abs(self.ratio(middle, sides[row]) - 0.5 * (at + np.roll(at, -1, axis=1)))
            off = np.nan_to_num(off).max(axis=1, initial=0.0)
            split = (off > PRECISION) & (division < DIVISIONS)
            done.append((corners[~split], row[~split], off[~split] <= PRECISION))
            if not split.any():
                break
            (a, b, c), (d, e, f) = (np.moveaxis(of[split], 1, 0) for of in (corners, middle))
            parts = [(a, d, f), (d, b, e), (f, e, c), (d, e, f)]
            corners = np.concatenate([np.stack(part, axis=1) for part in parts])
            row = np.tile(row[split], 4)
        corners, row, linear = (np.concatenate([part[k] for part in done]) for k in range(3))
        order = np.argsort(row, kind="stable")
        corners, row = corners[order], row[order]
        return corners, row, self.at_corners(corners, sides[row]), linear[order]

    def ratio(self, corners: np.ndarray, sides: np.ndarray) -> np.ndarray:
        """Shale gouge ratio at corners of triangles, float64 (n, 3)."""
        return self.at_corners(corners, sides).ratio.reshape(-1, 3)

    def _compare(
        self, slipped: Slipped, rows: np.ndarray, z: np.ndarray, zones: np.ndarray, walls: list[Any]
    ) -> None:
        """Fill in rows of what was found: each wall against the other."""
        ends = np.full((len(rows), 1), np.inf)
        tops = [np.concatenate([ends, level], axis=1) for level, _ in walls]
        bases = [np.concatenate([level, -ends], axis=1) for level, _ in walls]
        first, last = zones.min(axis=1), zones.max(axis=1)
        number, at = np.arange(self.n_horizon + 1), np.arange(len(rows))
        within = (number >= first[:, None]) & (number <= last[:, None])
        for side in (PLUS, MINUS):
            top, base, other = tops[side], bases[side], zones[:, 1 - side]
            there = tops[1 - side][at, other], bases[1 - side][at, other]
            far = _same_layer(z, *there, top[at, other], base[at, other])

            # the outermost two zones end at the point and at its partner
            upper = np.where(number <= first[:, None], np.inf, top)
            lower = np.where(number >= last[:, None], -np.inf, base)
            low, high = np.minimum(z, far)[:, None], np.maximum(z, far)[:, None]
            part = np.maximum(np.minimum(high, upper) - np.maximum(low, lower), 0.0)
            part = np.where(within, part, 0.0)
            total = part.sum(axis=1)
            shale = np.where(part > 0.0, part * self.vshale, 0.0).sum(axis=1)
            alike = 0.5 * self.vshale[zones].sum(axis=1)  # where nothing has slipped
            with np.errstate(invalid="ignore", divide="ignore"):
                slipped.sgr[rows, side] = np.where(total > 0.0, shale / total, alike)
            slipped.sgr[rows[np.isnan(total)], side] = np.nan
            slipped.throw[rows, side] = (z - far) if side == PLUS else (far - z)
        slipped.csp[rows] = self._smear(z, zones, tops, bases)
        slipped.assumed[rows] = (walls[0][1] | walls[1][1]).any(axis=1)

    def _smear(
        self, z: np.ndarray, zones: np.ndarray, tops: list[Any], bases: list[Any]
    ) -> np.ndarray:
        """Clay smear potential: of each bed that slipped past, that of its nearer half."""
        total = np.zeros(len(z))
        first, last = zones.min(axis=1), zones.max(axis=1)
        for a, b in self.beds:
            passed = (first < a) & (last > b)
            best = np.zeros(len(z))
            for top, base in zip(tops, bases, strict=True):
                distance = np.maximum(base[:, b] - z, z - top[:, a])
                with np.errstate(divide="ignore", invalid="ignore"):
                    size = (top[:, a] - base[:, b]) ** 2 / np.maximum(distance, 0.0)
                best = np.fmax(best, np.where(passed, size, 0.0))
            against = ((zones >= a) & (zones <= b)).any(axis=1)
            total += np.where(against, np.inf, best)
        return total


@dataclass(frozen=True, eq=False)
class Slipped:
    """What has slipped past points.

    Attributes
    ----------
    sgr, throw : ndarray of float64, shape (n, 2)
        By the rock of either wall; NaN where a horizon between is not known. Throw is above 0
        where the hanging wall is down [m].
    csp : ndarray of float64, shape (n,)
        [m]; infinite where a source bed is one of both walls.
    assumed : ndarray of bool, shape (n,)
        Whether a cut-off was continued beyond its end.
    """

    sgr: np.ndarray
    throw: np.ndarray
    csp: np.ndarray
    assumed: np.ndarray

    @property
    def ratio(self) -> np.ndarray:
        """Mean of both walls, or that of one if the other is not known."""
        return mean_of_walls(self.sgr)

    @property
    def mean_throw(self) -> np.ndarray:
        """The same of throw."""
        return mean_of_walls(self.throw)


def mean_of_walls(both: np.ndarray) -> np.ndarray:
    """Mean of the values (n, 2) of two walls, or the value that is known."""
    known = np.isfinite(both)
    found: np.ndarray = np.where(known, both, 0.0).sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return found / known.sum(axis=1)


def _same_layer(
    z: np.ndarray, top: np.ndarray, base: np.ndarray, its_top: np.ndarray, its_base: np.ndarray
) -> np.ndarray:
    """Elevations on one wall of the layers that lie at elevations z of a zone on the other.

    A layer keeps its share of the zone. A zone with one known end keeps its distance from that.
    """
    thick = top - base
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(thick > 0.0, np.clip((top - z) / thick, 0.0, 1.0), 0.5)
        by_share = its_top - share * (its_top - its_base)
        below, above = its_top - (top - z), its_base + (z - base)
    level = np.where(np.isfinite(its_top) & np.isfinite(top), below, above)
    both = np.isfinite(thick) & np.isfinite(its_top - its_base)
    level = np.where(both, by_share, level)
    return np.where(np.isfinite(level), level, np.nan)
