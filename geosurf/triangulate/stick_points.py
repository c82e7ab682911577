"""Fault sticks as files have them: points out of order, sticks twice, and single sticks."""

from __future__ import annotations

from typing import Any

import numpy as np

from geosurf.conventions import counted, is_number, place
from geosurf.errors import GeosurfWarning, SurfaceError
from geosurf.warning import warn

# file order is given up if another order is shorter by this factor: at 1.25, points 0 2 1 3 of a
# line are sorted (5 steps against 3), and a pick that slips back by a tenth of the stick is not
_SHORTER = 1.25


def sorted_along(line: np.ndarray) -> np.ndarray:
    """Points (n, 3) of one stick in order along it; in file order if that goes straight enough.

    A stick that only falls, or only climbs, is in order. Of others, three orders are compared: by
    the principal axis, and from each end on to the nearest point that is left, which follows bends.
    """
    climb = np.diff(line[:, 2])
    if len(line) < 3 or (climb >= 0).all() or (climb <= 0).all():
        return line
    middle = line - line.mean(axis=0)
    axis = np.linalg.svd(middle, full_matrices=False)[2][0]
    along = np.argsort(middle @ axis, kind="stable")
    orders = [along, _nearest_next(line, int(along[0])), _nearest_next(line, int(along[-1]))]
    lengths = [_length(line[order]) for order in orders]
    k = int(np.argmin(lengths))
    return line[orders[k]] if _length(line) > _SHORTER * lengths[k] else line


def _nearest_next(line: np.ndarray, start: int) -> np.ndarray:
    """From one point always on to the nearest that is left."""
    left = np.ones(len(line), dtype=bool)
    order = [start]
    for _ in range(len(line) - 1):
        left[order[-1]] = False
        off = np.linalg.norm(line - line[order[-1]], axis=1)
        order.append(int(np.where(left, off, np.inf).argmin()))
    return np.array(order)


def _length(line: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def warn_of_order(moved: list[tuple[int, np.ndarray]], name: str) -> None:
    """Warn of sticks whose points were sorted: (number, line) each."""
    if moved:
        i, line = moved[0]
        warn(
            GeosurfWarning(
                "sticks",
                name,
                f"Fault {name!r}: the points of {counted(len(moved), 'stick')} run back and forth "
                f"and are sorted along the stick; the first is stick {i} at {place(line[0])}.",
                "If a stick really turns back, split it there.",
                line[0],
            )
        )


def without_twins(lines: list[np.ndarray], name: str) -> list[np.ndarray]:
    """Sticks without those that are there already, of which a warning is issued."""
    seen: dict[bytes, int] = {}
    twins = []
    for i, line in enumerate(lines):
        first = seen.setdefault(line.tobytes(), i)
        if first != i:
            twins.append((first, i))
    if twins:
        first, i = twins[0]
        where = f"from {place(lines[i][0])} to {place(lines[i][-1])}"
        warn(
            GeosurfWarning(
                "sticks",
                name,
                f"Fault {name!r}: {counted(len(twins), 'stick')} of {len(lines)} came twice and "
                f"{'are' if len(twins) > 1 else 'is'} used once; sticks {first} and {i} are the "
                f"same, {where}.",
                "Remove the copies from the file.",
                lines[i][0],
            )
        )
    return [lines[i] for i in seen.values()]


def plane_of_stick(line: np.ndarray, strike: Any, length: Any, name: str) -> list[np.ndarray]:
    """A single stick, and its copies half a length along strike to both sides."""
    for word, value in (("strike", strike), ("length", length)):
        if not is_number(value) or (word == "length" and not 0 < value < np.inf):
            raise SurfaceError(
                f"fault {name!r}: {word} is {value!r}. A single stick needs strike, an azimuth in "
                "degrees clockwise from north, and length, in metres: strike=30, length=2000."
            )
    azimuth = np.radians(float(strike))
    half = 0.5 * float(length) * np.array([np.sin(azimuth), np.cos(azimuth), 0.0])
    return [line - half, line, line + half]
