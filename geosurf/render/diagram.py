"""Diagrams of lines: Allan diagrams and sections have elevation upwards, maps have northing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.render import furniture, palette

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

RELIEF = 0.6  # height over width that reads well
AROUND = 0.3  # of the height of what matters, shown above and below it


def lines_of(
    lines: xarray.Dataset, axes: tuple[str, str], words: Sequence[str]
) -> list[tuple[dict[str, str], np.ndarray]]:
    """
    Return some words of each line of a dataset, and its points, ndarray (n, 2).

    Parameters
    ----------
    lines : xarray.Dataset
        Points of one line after the other, ``count`` of each.
    axes : (str, str)
        Which values of a point are drawn to the right, and which upwards.
    words : sequence of str
        Values of lines.
    """
    points = np.stack([lines[name].values for name in axes], axis=1)
    count = lines["count"].values
    told = zip(*(lines[name].values for name in words), strict=True)
    return [
        (dict(zip(words, map(str, row), strict=True)), points[end - n : end])
        for row, end, n in zip(told, np.cumsum(count), count, strict=True)
    ]


def outline_of(rings: Sequence[np.ndarray]) -> Any:
    """Return one path of matplotlib around rings (n, 2); holes, which run the other way round, stay
    empty.
    """
    from matplotlib.path import Path as Outline

    closed = (Outline(np.vstack([ring, ring[:1]]), closed=True) for ring in rings)
    return Outline.make_compound_path(*closed)


def range_shown(points: np.ndarray, levels: Sequence[np.ndarray]) -> tuple[float, ...]:
    """
    Return what a diagram shows: left, right, bottom, top of what matters, and a part around it.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 2)
        Distance and elevation of all that there is [m].
    levels : sequence of ndarray of float64
        Elevations of the lines that matter [m]; without any, all is shown.

    Examples
    --------
    >>> points = np.array([[0.0, -3000.0], [900.0, -1000.0]])
    >>> range_shown(points, [np.array([-2000.0, -2100.0])])
    (0.0, 900.0, -2130.0, -1970.0)
    """
    (left, low), (right, high) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    if not levels:
        return left, right, low, high
    every = np.concatenate(levels)
    bottom, top = float(every.min()), float(every.max())
    room = AROUND * max(top - bottom, 0.02 * (right - left))
    return left, right, max(low, bottom - room), min(high, top + room)


def diagram_axes(
    sheet: furniture.Sheet, shown: tuple[float, ...], along: str, room: float
) -> tuple[Any, float]:
    """Axes in metres with some room on both sides [design pixels]; and the exaggeration."""
    layout, unit = sheet.layout, sheet.layout.unit
    left, right, bottom, top = shown
    wide, high = max(right - left, 1.0), max(top - bottom, 1.0)
    margin = room * unit
    across = layout.view_size[0] - 2.0 * margin
    # not taller than reads well, never squeezed below true scale where there is room
    up = min(layout.view_size[1], max(RELIEF * across, across * high / wide))
    exaggeration = (up / high) / (across / wide)
    low = layout.bottom + (layout.view_size[1] - up) / 2.0
    place = ((layout.left + margin) / layout.width, low / layout.height, across / layout.width)
    axes = sheet.figure.add_axes((*place, up / layout.height))
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    points_high = 12.0 * unit * 72.0 / furniture.DPI
    for axis, name, first, span, per, pixels in (
        (axes.xaxis, along, left, wide, 1000.0, across),
        (axes.yaxis, "Elevation [m]", bottom, high, 1.0, up),
    ):
        values = furniture.ticks(first, first + span, furniture.fitting(sheet, pixels))
        axis.set_ticks(values, furniture.tick_texts(values, per))
        look = {"fontsize": points_high * 1.08, "color": palette.INK, "family": furniture.FONT}
        axis.set_label_text(name, **look)
    axes.tick_params(labelsize=points_high, colors=palette.INK, width=0.8, color=palette.FAINT)
    axes.spines["left"].set_position(("outward", margin * 72.0 / furniture.DPI))
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for label in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        label.set_family(furniture.FONT)
    for spine in axes.spines.values():
        spine.set_color(palette.FRAME)
    return axes, exaggeration
