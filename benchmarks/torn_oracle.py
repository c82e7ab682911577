"""What trusted data can show at all: ``python -m benchmarks.torn_oracle 49:F5 63:F1``.

A slow and obvious estimator next to the sheet's own, at the place of a fault with the largest
error. Each wall is kriged (universal kriging with a linear drift; Cressie 1993, Statistics for
Spatial Data, ch. 3.4) from exactly the data that the sheet trusts, as far as a straight line from
the place meets no true cut-off. The length of the Gaussian covariance is the likeliest one. If
likely and less likely lengths disagree by more than the error, the data do not show the truth.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

import geosurf as gs
from benchmarks.random_networks import CELL, Network, random_network
from benchmarks.torn_networks import FAMILIES, TRIMS
from tests.sheets.table import measure

LENGTHS = (6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 26.0, 34.0)  # of the covariance [cells]
REACH = 14.0  # cells from which data are taken
MOST = 250  # data
NUGGET = 1e-9  # of the variance, so that the matrix stays positive


def main(argv: Sequence[str] | None = None) -> int:
    """Print a table of both estimators for places "network:fault"."""
    words = sys.argv[1:] if argv is None else argv
    titles = ("network", "fault", "wall", "datum [cells]", "sheet [%]", "oracle [%]", "lengths [%]")
    lines = [f"| {' | '.join(titles)} |", "|" + "---|" * len(titles)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the sheets
        for word in words:
            number, name = word.split(":")
            lines += _rows(int(number), name)
    sys.stdout.write("\n".join(lines) + "\n")
    return 0


def _rows(number: int, name: str) -> Iterator[str]:
    """A row for each wall, at the place with the largest error of throw."""
    rng = np.random.default_rng([1, number])
    family = FAMILIES[number % len(FAMILIES)]
    trim, smear = TRIMS[int(rng.integers(len(TRIMS)))]
    world = random_network(family, rng, smear)
    sheet = gs.tear_horizon(world.horizon, world.faults, name="Top", trim=trim)
    found = measure(world, sheet, name)
    s = found.places[int(np.nanargmax(found.throw))]
    data = _trusted(world, trim)
    for wall, sign in (("+", 1.0), ("-", -1.0)):
        true = _at(world, name, world.truth["cutoffs"][name, wall], s)
        own = _nearest_on(sheet.cuts[name].cutoffs[wall], true)
        seen = data[_visible(world, name, true, sign, data)]
        by_length = [_kriged(seen, true[:2], length) for length in LENGTHS]
        oracle = max(by_length, key=lambda one: one[1])[0]
        per_cent = 100.0 / found.largest
        others = [round((z - true[2]) * per_cent, 1) for z, _ in by_length]
        far = np.hypot(*(seen[:, :2] - true[:2]).T).min() / CELL
        yield (
            f"| {number}, {family}, trim {trim:g} | {name} | {wall} | {far:.1f} "
            f"| {(own - true[2]) * per_cent:.1f} | {(oracle - true[2]) * per_cent:.1f} "
            f"| {min(others)} to {max(others)} |"
        )


def _trusted(world: Network, trim: float) -> np.ndarray:
    """Data (n, 3) farther from all faults than a trim, at their own height."""
    grid = world.horizon
    x, y = (a.ravel() for a in np.meshgrid(grid.easting.values, grid.northing.values))
    z = grid.values.ravel()
    keep = np.ones(len(z), dtype=bool)
    for fault in world.truth["faults"].values():
        half = min(fault.half, 2.0 * max(world.box))
        s, r = fault.along_across(x, y)
        line = np.linspace(-half, half, int(2.0 * half / 5.0) + 1)
        for rows in np.array_split(np.arange(len(z)), len(z) // 200 + 1):
            away = fault.across(line[None], z[rows, None]) - r[rows, None]
            keep[rows] &= np.hypot(away, line[None] - s[rows, None]).min(axis=1) >= trim * CELL
    return np.stack([x, y, z], axis=1)[keep]


def _at(world: Network, name: str, line: np.ndarray, s: float) -> np.ndarray:
    """The point of a true cut-off at a place along strike."""
    along = world.truth["faults"][name].along_across(line[:, 0], line[:, 1])[0]
    found: np.ndarray = line[np.abs(along - s).argmin()]
    return found


def _nearest_on(lines: Sequence[np.ndarray], point: np.ndarray) -> float:
    """Elevation of the nearest place of found cut-offs."""
    best, z = np.inf, np.nan
    for line in lines:
        for a, b in pairwise(line):
            t = (b - a)[:2]
            f = float(np.clip((point[:2] - a[:2]) @ t / max(t @ t, 1e-30), 0.0, 1.0))
            far = float(np.hypot(*(point[:2] - a[:2] - f * t)))
            if far < best:
                best, z = far, a[2] + f * (b[2] - a[2])
    return float(z)


def _visible(
    world: Network, name: str, point: np.ndarray, sign: float, data: np.ndarray
) -> np.ndarray:
    """Data within reach that straight lines from a wall, one metre off its fault, lead to."""
    a = np.radians(world.truth["faults"][name].strike)
    start = point[:2] + sign * np.array([np.cos(a), -np.sin(a)])
    away = data[:, :2] - start
    rows = np.flatnonzero(np.hypot(*away.T) < REACH * CELL)
    way, clear = away[rows], np.ones(len(rows), dtype=bool)
    for line in world.truth["cutoffs"].values():
        one, two = line[:-1, :2] - start, line[1:, :2] - start
        near = np.hypot(*one.T) < 1.5 * REACH * CELL
        one, two = one[near], two[near]
        apart = _cross(way[:, None], one[None]) * _cross(way[:, None], two[None]) < 0
        t = two - one
        across = _cross(t, -one)[None] * _cross(t[None], way[:, None] - one[None]) < 0
        clear &= ~(apart & across).any(axis=1)
    rows = rows[clear]
    return rows[np.argsort(np.hypot(*away[rows].T), kind="stable")[:MOST]]


def _cross(a: np.ndarray, b: np.ndarray) -> Any:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _kriged(data: np.ndarray, at: np.ndarray, length: float) -> tuple[float, float]:
    """Height at a place from data (n, 3), and the restricted log likelihood of the length."""
    place = (data[:, :2] - at) / CELL
    drift = np.column_stack([np.ones(len(place)), place])
    square = ((place[:, None] - place[None]) ** 2).sum(axis=2)
    matrix = np.exp(-0.5 * square / length**2) + NUGGET * np.eye(len(place))
    factor = np.linalg.cholesky(matrix)
    f, z, k = (
        np.linalg.solve(factor, column)
        for column in (drift, data[:, 2], np.exp(-0.5 * (place**2).sum(axis=1) / length**2))
    )
    share = np.linalg.lstsq(f, z, rcond=None)[0]
    left = z - f @ share
    free = len(z) - drift.shape[1]
    likely = -0.5 * free * np.log(left @ left / free) - np.log(np.diag(factor)).sum()
    likely -= 0.5 * np.linalg.slogdet(f.T @ f)[1]
    return float(share[0] + k @ left), float(likely)


if __name__ == "__main__":
    sys.exit(main())
