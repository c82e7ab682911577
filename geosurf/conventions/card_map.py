"""A small map for the card of an object, as SVG: an outline, and named lines in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from geosurf.conventions.colours import fault

SIZE, MARGIN = 220.0, 8.0  # of the longer side [pixels]


def small_map(outline: np.ndarray, lines: Mapping[str, Sequence[np.ndarray]]) -> str:
    """
    Return a map as SVG, north up; names show when the mouse is over their lines.

    Parameters
    ----------
    outline : ndarray of float64, shape (n, 2)
        Easting and northing of the corners of the area [m].
    lines : mapping of str to sequence of ndarray of float64, each (n, 2)
        By name, in the colours of faults.

    Returns
    -------
    str

    Examples
    --------
    >>> square = np.array([[0.0, 0], [100, 0], [100, 50], [0, 50]])
    >>> text = small_map(square, {"<F1>": [np.array([[10.0, 10], [90, 40]])]})
    >>> "<title>&lt;F1&gt;</title>" in text, 'viewBox="0 0 236 126"' in text
    (True, True)
    """
    every = np.concatenate([outline, *(part for parts in lines.values() for part in parts)])
    low, high = every.min(axis=0), every.max(axis=0)
    scale = SIZE / max(float((high - low).max()), np.finfo(float).tiny)

    def path(points: np.ndarray) -> str:
        """Pixels from the upper left, to a tenth."""
        x = (points[:, 0] - low[0]) * scale + MARGIN
        y = (high[1] - points[:, 1]) * scale + MARGIN
        return "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True))

    width, height = (f"{side:.0f}" for side in (high - low) * scale + 2.0 * MARGIN)
    marks = [f'<path d="{path(outline)}Z" fill="none" stroke="currentColor" opacity=".5"/>']
    for number, (name, parts) in enumerate(lines.items()):
        colour = "".join(f"{round(255 * part):02x}" for part in fault(number))
        drawn = " ".join(path(part) for part in parts if len(part) > 1)
        marks.append(
            f'<path d="{drawn}" fill="none" stroke="#{colour}" stroke-width="2.5">'
            f"<title>{escape(name)}</title></path>"
        )
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" '
        f'aria-label="map, north up">{"".join(marks)}</svg>'
    )


__all__ = ["small_map"]
