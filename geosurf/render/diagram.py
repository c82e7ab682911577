"""Draw the axes of Allan diagrams and sections, and read the lines of their datasets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from geosurf.render import furniture, palette
from geosurf.render.furniture import fitting, tick_texts, ticks

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.path import Path as Outline

Line = tuple[dict[str, str], np.ndarray]  # attributes, and points (n, 2) [m]

WINDS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
RELIEF = 0.6  # height over width that reads well
AROUND = 0.3  # margin above and below, as a fraction of the height of the lines


def lines_of(lines: xarray.Dataset, axes: tuple[str, str], words: Sequence[str]) -> list[Line]:
    """
    Return the attributes and the points (n, 2) of each line of a dataset.

    Parameters
    ----------
    lines : xarray.Dataset
        Points of all lines, one line after the other; ``count`` is the number of points of each.
    axes : (str, str)
        Coordinates that are drawn to the right and upwards.
    words : sequence of str
        Names of the attributes.
    """
    # points (n_point, 2) of all lines in one array; counts say where each ends
    points = np.stack([lines[name].values for name in axes], axis=1)
    count = lines["count"].values
    attributes = zip(*(lines[name].values for name in words), strict=True)
    return [
        (dict(zip(words, map(str, row), strict=True)), points[end - n : end])
        for row, end, n in zip(attributes, np.cumsum(count), count, strict=True)
    ]


def outline_of(rings: Sequence[np.ndarray]) -> Outline:
    """Return one matplotlib path around rings (n, 2); rings of opposite direction are holes."""
    from matplotlib.path import Path as Outline

    # matplotlib fills by winding: a ring that runs the other way is a hole
    closed = (Outline(np.vstack([ring, ring[:1]]), closed=True) for ring in rings)
    return Outline.make_compound_path(*closed)


def range_shown(points: np.ndarray, levels: Sequence[np.ndarray]) -> tuple[float, ...]:
    """
    Return the range of a diagram: left, right, bottom, top, with a margin around its lines.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 2)
        Distance and elevation of all points [m].
    levels : sequence of ndarray of float64
        Elevations of the lines that must be visible [m]; if empty, all points are shown.

    Examples
    --------
    >>> points = np.array([[0.0, -3000.0], [900.0, -1000.0]])
    >>> range_shown(points, [np.array([-2000.0, -2100.0])])
    (0.0, 900.0, -2130.0, -1970.0)
    """
    (left, low), (right, high) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    if not levels:
        return left, right, low, high

    # a margin above and below, but never beyond what there is to show
    every = np.concatenate(levels)
    bottom, top = float(every.min()), float(every.max())
    room = AROUND * max(top - bottom, 0.02 * (right - left))
    return left, right, max(low, bottom - room), min(high, top + room)


def draw_ends(sheet: furniture.Sheet, axes: Axes, azimuth: float) -> None:
    """Write the compass directions at both ends of a section or a fault, by its azimuth."""
    # eighths of a turn, clockwise from north
    turn = round(azimuth / 45.0) % 8
    points = 14.0 * sheet.layout.unit * 72.0 / furniture.DPI
    for x, wind in ((0.0, WINDS[(turn + 4) % 8]), (1.0, WINDS[turn])):
        axes.annotate(
            wind, (x, 1.0), (0.0, 12.0 * sheet.layout.unit), xycoords="axes fraction",
            textcoords="offset pixels", ha="center", va="bottom", weight="bold",
            family=furniture.FONT, fontsize=points, color=palette.INK,
        )  # fmt: skip


def diagram_axes(
    sheet: furniture.Sheet,
    shown: tuple[float, ...],
    along: str,
    room: float,
    upwards: str = "Elevation [m]",
) -> tuple[Axes, float]:
    """Return axes in metres with a margin on both sides [design pixels], and the exaggeration."""
    layout, unit = sheet.layout, sheet.layout.unit

    # where the diagram goes on the sheet [pixels]
    left, right, bottom, top = shown
    wide, high = max(right - left, 1.0), max(top - bottom, 1.0)

    # names of cut-offs stand in the margins on both sides
    margin = room * unit
    across = layout.view_size[0] - 2.0 * margin
    # not taller than reads well, but never below true scale if the picture is high enough
    up = min(layout.view_size[1], max(RELIEF * across, across * high / wide))

    # pixels per metre, upwards over along
    exaggeration = (up / high) / (across / wide)
    low = layout.bottom + (layout.view_size[1] - up) / 2.0
    place = ((layout.left + margin) / layout.width, low / layout.height, across / layout.width)

    # matplotlib wants the rectangle as fractions of the picture
    axes = sheet.frame((*place, up / layout.height))
    if isinstance(sheet, furniture.UserSheet):
        across, up = sheet.room
        exaggeration = (up / high) / (across / wide)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)

    # round tick values, kilometres along and metres up
    points_high = 12.0 * unit * 72.0 / furniture.DPI
    for axis, name, first, span, per, pixels in (
        (axes.xaxis, along, left, wide, 1000.0, across),
        (axes.yaxis, upwards, bottom, high, 1.0, up),
    ):
        values = ticks(first, first + span, fitting(pixels, unit))
        axis.set_ticks(values, tick_texts(values, per))
        axis.set_label_text(
            name, fontsize=points_high * 1.08, color=palette.INK, family=furniture.FONT
        )
    axes.tick_params(labelsize=points_high, colors=palette.INK, width=0.8, color=palette.FAINT)

    # the axis of elevations stands outside the margin for names
    axes.spines["left"].set_position(("outward", margin * 72.0 / furniture.DPI))
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for label in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        label.set_fontfamily(furniture.FONT)
    for spine in axes.spines.values():
        spine.set_color(palette.FRAME)
    return axes, exaggeration


def highest_in_view(line: np.ndarray, bottom: float, top: float) -> np.ndarray | None:
    """The highest point of a line (n, 2) between two levels; None if there is none."""
    p, q = line[:-1], line[1:]

    # where the line leaves the picture at the top; else its highest point in view
    across = np.flatnonzero((p[:, 1] > top) != (q[:, 1] > top))
    if len(across):
        p, q = p[across[0]], q[across[0]]
        at_top: np.ndarray = p + (top - p[1]) / (q[1] - p[1]) * (q - p)
        return at_top
    seen = line[(line[:, 1] >= bottom) & (line[:, 1] <= top)]
    return seen[np.argmax(seen[:, 1])] if len(seen) else None
