"""Draw the axes of Allan diagrams and sections, and read the lines of their datasets."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions import palette
from geosurf.conventions.axes import vertical_label, vertical_words
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.render import artists
from geosurf.render.colouring import zone_colours
from geosurf.render.furniture import draw_legend, draw_words, label_axes, rim_of_words
from geosurf.render.layers import Entry
from geosurf.render.picture_style import FONT, apply_theme, readable
from geosurf.render.sheet import DPI, Sheet, UserSheet

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes


# ---- column ----------------------------------------
# Draw the stratigraphic column of a model: zones, the horizons between them, and their rules.


LEAST = 0.35  # height of a thin zone, in mean heights: its name has to fit
WAVES = 12  # of the line of an unconformity


def draw_column(
    sheet: Sheet,
    zones: Mapping[str, float],
    rules: Mapping[str, str],
    *,
    reservoir: Sequence[str] | None = None,
    title: str | None = None,
) -> None:
    """Draw the column.

    Parameters
    ----------
    sheet : Sheet
    zones : mapping of str to float
        Mean thickness of each zone [m], youngest first.
    rules : mapping of str to str
        ``"conformable"``, ``"erosional"``, ``"base"`` or ``"discontinuous"`` by horizon, youngest
        first.
    reservoir : sequence of str, optional
        Zones of the reservoir: the others are grey, and have no thickness. Default: all.
    title : str, optional
    """
    title = "Stratigraphic column" if title is None else title
    layout, unit = sheet.layout, sheet.layout.unit
    axes = sheet.frame((0.12, 0.06, 0.5, 0.84))
    points = 10.5  # readable at any size of the picture

    # heights follow thickness by its square root: thin zones stay visible
    high = np.sqrt(np.maximum(list(zones.values()), 0.0))
    high = np.maximum(high, LEAST * high.mean()) if len(high) else high
    tops = np.concatenate([[0.0], -np.cumsum(high)])
    inside = list(zones) if reservoir is None else reservoir
    names, colours = zone_colours(list(zones), inside, sheet.style)
    for k, (zone, thick) in enumerate(zones.items()):
        colour, words = colours[names[zone]], f"{zone}\n{thick:.0f} m" if zone in inside else zone
        axes.fill_between([0.0, 1.0], tops[k + 1], tops[k], color=colour, linewidth=0)
        middle = 0.5 * (tops[k] + tops[k + 1])
        axes.text(
            0.5, middle, words, ha="center", va="center", fontsize=points,
            family=FONT, color=palette.INK, parse_math=False,
            path_effects=rim_of_words(sheet),
        )  # fmt: skip

    # a horizon lies on top of the zone that is named after it: "Top/Base" or "below Base"
    for k, zone in enumerate(zones):
        name = zone.removeprefix("below ").partition("/")[0]
        if k and name in rules:
            _draw_horizon(axes, tops[k], name, rules[name], points)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(float(tops[-1]), 0.0)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_color(palette.FRAME)
    if isinstance(sheet, UserSheet):
        axes.set_title(title, loc="left", parse_math=False)
    else:
        sheet.text((28 * unit, layout.height - 34 * unit), title, 13.5 / unit, weight="bold")
        words = "Heights: square root of the mean thickness. Wavy lines are unconformities."
        sheet.text((28 * unit, 24 * unit), words, 10.0 / unit, palette.FAINT)
        apply_theme(sheet.figure, sheet.axes, sheet.style)


def _draw_horizon(axes: Axes, level: float, name: str, rule: str, points: float) -> None:
    """The line of a horizon, wavy if it cuts others, with its name and rule on the right."""
    x = np.linspace(0.0, 1.0, 40 * WAVES + 1)
    wave = 0.0 if rule in ("conformable", "yielding") else 0.006 * abs(axes.dataLim.height)
    y = level + wave * np.sin(2.0 * np.pi * WAVES * x)
    axes.plot(x, y, color=palette.INK, linewidth=points / 8.0, clip_on=False)
    label = name if rule == "conformable" else f"{name} ({rule})"
    axes.annotate(
        label, (1.0, level), (6.0, 0.0), textcoords="offset points", ha="left", va="center",
        fontsize=points, family=FONT, color=palette.INK, annotation_clip=False,
        parse_math=False,
    )  # fmt: skip


def column_of(units: Sequence[tuple[str, float, float]], zones: Sequence[str]) -> dict[str, float]:
    """Return the mean thickness of zones [m], from zone, volume and map area of each unit."""
    volume, area = dict.fromkeys(zones, 0.0), dict.fromkeys(zones, 0.0)
    for zone, v, a in units:
        volume[zone] += v
        area[zone] += a
    return {zone: volume[zone] / area[zone] if area[zone] > 0.0 else 0.0 for zone in zones}


# ---- profile ----------------------------------------
# Draw the throw of horizons along a fault: one line for each horizon.


DARKER = 0.75  # than the zones of a column: thin lines on white
ROOM = 10.0  # margin on both sides [design pixels]


def draw_throw(
    sheet: Sheet,
    throws: Mapping[str, xarray.Dataset],
    *,
    horizons: Sequence[str] = (),
    shown: Mapping[str, np.ndarray | None] | None = None,
    absent: Mapping[str, str] | None = None,
    title: str | None = None,
) -> None:
    """Draw the throw of horizons along a fault.

    Parameters
    ----------
    sheet : Sheet
    throws : mapping of str to xarray.Dataset
        Results of `Scene.throw` for one fault, by horizon.
    horizons : sequence of str
        All horizons, youngest first, for the same colours as in other pictures.
    shown : mapping of str to ndarray (n, 3), optional
        What data show, by horizon: distance along the strike, throw and its spread [m].
    absent : mapping of str to str, optional
        Horizons without a line, and why: the legend lists them.
    title : str, optional
        Default: the name of the fault.

    Raises
    ------
    InputError
        If there is no throw to draw.
    """
    # one line for each stretch of the fault on which both walls have a cut-off
    lines = {name: _stretches(found) for name, found in throws.items()}
    points = [line for parts in lines.values() for line in parts]
    bands = {
        name: band
        for name, band in (shown or {}).items()
        if band is not None and np.isfinite(band[:, 1]).any()
    }
    if not points:
        raise InputError("no horizon has throw along this fault, so there is nothing to draw.")
    # no throw is in the picture, which is two metres high at least
    start = points[0][0, 0]
    throw = np.concatenate([a[:, 1] for a in (*points, *bands.values())])
    throw = throw[np.isfinite(throw)]
    # a little room, or the frame would cut the line at the largest throw in half
    room = 0.03 * np.ptp([*throw, 0.0])
    low, high = min(-1.0, throw.min() - room), max(1.0, throw.max() + room)
    every = np.concatenate([*points, [(start, low), (start, high)]])
    axes, _ = diagram_axes(
        sheet,
        range_shown(every, [every[:, 1]]),
        "Distance along strike [km]",
        ROOM,
        vertical_label("Throw"),
    )

    # no throw, and the profiles in the colours of the horizons
    width = sheet.points(2.0)
    axes.axhline(0.0, color=palette.FRAME, linewidth=0.5 * width, zorder=1)
    order = list(horizons) or list(throws)
    unit = vertical_words("Throw")[1]
    legend = []
    for row, (name, parts) in enumerate(lines.items()):
        red, green, blue = palette.stratum(order.index(name) if name in order else len(order))
        # thin lines of light zones would not be seen on white; on a dark background they are
        darker = 1.0 if sheet.style.dark else DARKER
        colour = sheet.style.colour(name, (darker * red, darker * green, darker * blue))
        if sheet.style.dark:
            colour = readable(colour)
        for line in parts:
            # the last line is the thinnest: those below are seen where throws are the same
            wide = 1.0 + 1.6 * (len(lines) - 1 - row) / max(len(lines) - 1, 1)
            axes.plot(*line.T, color=colour, linewidth=wide * width, zorder=2)
        if name in bands:
            along, data, spread = bands[name].T
            axes.fill_between(along, data - spread, data + spread, color=colour, alpha=0.15, lw=0)
            axes.plot(along, data, ":", color=colour, linewidth=width, zorder=3)
        if parts:
            low, high = (f(float(f(line[:, 1])) for line in parts) for f in (min, max))
            span = f"{round(low)} to {round(high)} {unit}".replace("-", "\N{MINUS SIGN}")
            legend.append(Entry(name, colour, span, "line"))
    legend += [Entry(name, detail=why, kind="heading") for name, why in (absent or {}).items()]
    draw_legend(sheet, tuple(legend), 640.0)
    attrs = next(iter(throws.values())).attrs
    fault = attrs.get("fault", "fault")
    if "dip_azimuth" in attrs:  # the strike is 90 degrees to the left of it
        draw_ends(sheet, axes, west_or_south_left(axes, float(attrs["dip_azimuth"]) - 90.0))
    words = "Throw: vertical offset of both cut-offs; negative where the hanging wall is higher."
    if bands:
        words += " Dotted: what the data on both sides show, with its spread."
    draw_words(sheet, f"{fault}: throw" if title is None else title, words)


def _stretches(throw: xarray.Dataset) -> list[np.ndarray]:
    """Distance along strike and throw (n, 2) of each pair of cut-offs, in order [m]."""
    stretches = []
    for pair in np.unique(throw.pair.values).tolist():
        mine = (throw.pair.values == pair) & np.isfinite(throw.throw.values)
        line = np.column_stack([throw.along_strike.values[mine], throw.throw.values[mine]])
        if len(line):
            stretches.append(line[np.argsort(line[:, 0], kind="stable")])
    return stretches


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


def outline_of(rings: Sequence[np.ndarray]) -> artists.Path:
    """Return one matplotlib path around rings (n, 2); rings of opposite direction are holes."""
    # matplotlib fills by winding: a ring that runs the other way is a hole
    closed = (artists.Path(np.vstack([ring, ring[:1]]), closed=True) for ring in rings)
    return artists.Path.make_compound_path(*closed)


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


def west_or_south_left(axes: Axes, azimuth: float) -> float:
    """Turn a diagram so that west, or else south, is on its left; return its azimuth now."""
    # by the names of eight winds: to the north and the north-west it runs from south
    if (azimuth + 22.5) % 360.0 < 180.0:
        return azimuth
    axes.invert_xaxis()
    return azimuth + 180.0


def draw_ends(sheet: Sheet, axes: Axes, azimuth: float) -> None:
    """Write the compass directions at both ends of a section or a fault, by its azimuth."""
    # eighths of a turn, clockwise from north
    turn = round(azimuth / 45.0) % 8
    points = sheet.points(14.0)
    for x, wind in ((0.0, WINDS[(turn + 4) % 8]), (1.0, WINDS[turn])):
        axes.annotate(
            wind, (x, 1.0), (0.0, 12.0 * sheet.layout.unit), xycoords="axes fraction",
            textcoords="offset pixels", ha="center", va="bottom", weight="bold",
            family=FONT, fontsize=points, color=palette.INK,
        )  # fmt: skip


def in_words(exaggeration: float) -> str:
    """Return the scale of a diagram as a sentence of its caption."""
    unit = vertical_words()[1]
    if unit == "ms":
        return f"1 ms is as high as {exaggeration:.3g} m are wide."
    return f"Vertical exaggeration {exaggeration:.3g}×."


def diagram_axes(
    sheet: Sheet, shown: tuple[float, ...], along: str, room: float, upwards: str = ""
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

    # pixels per metre, upwards over along: a round number, unless the picture is too low for it
    exaggeration = (up / high) / (across / wide)
    if exaggeration > 1.0:
        exaggeration = round_down(exaggeration)
        up = exaggeration * high * across / wide
    low = layout.bottom + (layout.view_size[1] - up) / 2.0
    place = ((layout.left + margin) / layout.width, low / layout.height, across / layout.width)

    # matplotlib wants the rectangle as fractions of the picture
    axes = sheet.frame((*place, up / layout.height))
    if isinstance(sheet, UserSheet):
        across, up = sheet.room
        exaggeration = (up / high) / (across / wide)
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)

    # kilometres along and metres up
    rows = [(axes.xaxis, along, left, left + wide, 1000.0, across),
            (axes.yaxis, upwards or vertical_label(), bottom, bottom + high, 1.0, up)]  # fmt: skip
    label_axes(sheet, axes, rows)

    # the axis of elevations stands outside the margin for names
    axes.spines["left"].set_position(("outward", margin * 72.0 / DPI))
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    return axes, exaggeration


def round_down(value: float) -> float:
    """Return the largest round number that is not above a value: 1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10.

    Examples
    --------
    >>> round_down(8.6), round_down(18.0), round_down(37.2)
    (8.0, 15.0, 30.0)
    """
    power = 10.0 ** math.floor(math.log10(value))
    steps = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return float(max(step * power for step in steps if step * power <= value * (1 + 1e-9)))


def highest_in_view(line: np.ndarray, bottom: float, top: float) -> np.ndarray | None:
    """The highest point of a line (n, 2) between two levels; None if there is none."""
    p, q = line[:-1], line[1:]

    # where the line leaves the picture at the top; else its highest point in view
    across = np.flatnonzero((p[:, 1] > top) != (q[:, 1] > top))
    if len(across):
        p, q = p[across[0]], q[across[0]]
        made: np.ndarray | None = p + (top - p[1]) / (q[1] - p[1]) * (q - p)
        return made
    seen = line[(line[:, 1] >= bottom) & (line[:, 1] <= top)]
    return seen[np.argmax(seen[:, 1])] if len(seen) else None
