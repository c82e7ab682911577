"""Where rims and lines meet the model box, and leave it."""

from __future__ import annotations

import numpy as np

from geosurf.faults.rim import Rim


def rim_in_box(rim: Rim, x: np.ndarray, side: str, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether one side of a fault lies in a box, in part at least; it may be but a point."""
    line = x[rim.arcs[side]]
    return bool(segments_meet_box(line if len(line) > 1 else line[[0, 0]], low, high).any())


def segments_meet_box(line: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Whether each step of a line (n, 3) meets a closed box, bool (n - 1,).

    Clipped against the slabs of the box; rounding is on the side of meeting.
    """
    first, last = clip_steps(line, low, high)
    return first <= last + 1e-12


def clip_steps(line: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, ...]:
    """Where each step of a line (n, 3) enters and leaves a box, 0 to 1; in order if it meets it."""
    # slabs (Kay & Kajiya 1986): parameters where each axis enters and leaves, (n - 1, 3)
    a, step = line[:-1], np.diff(line, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        s, e = (low - a) / step, (high - a) / step
    inside = (a >= low) & (a <= high)

    # no motion along an axis: inside its slab for the whole step, or never
    still = step == 0
    enter = np.where(still, np.where(inside, 0.0, np.inf), np.minimum(s, e))
    leave = np.where(still, np.where(inside, 1.0, -np.inf), np.maximum(s, e))
    return np.maximum(enter.max(axis=1), 0.0), np.minimum(leave.min(axis=1), 1.0)


def exits(start: np.ndarray, way: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Distance along rays (n, 3) to where they leave a box; NaN for those that miss it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        # as above for rays: the far end is unbounded
        s, e = (low - start) / way, (high - start) / way
    inside = (start >= low) & (start <= high)
    still = way == 0
    enter = np.where(still, np.where(inside, 0.0, np.inf), np.minimum(s, e)).max(axis=1)
    leave = np.where(still, np.where(inside, np.inf, -np.inf), np.maximum(s, e)).min(axis=1)
    return np.where((leave > 0) & (enter <= leave), leave, np.nan)
