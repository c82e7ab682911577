"""Draw the stratigraphic column of a model: zones, the horizons between them, and their rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from geosurf.render import furniture, palette
from geosurf.render.picture_style import apply_theme

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes

LEAST = 0.35  # height of a thin zone, in mean heights: its name has to fit
WAVES = 12  # of the line of an unconformity


def draw_column(
    sheet: furniture.Sheet,
    zones: Mapping[str, float],
    rules: Mapping[str, str],
    *,
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
    for k, (zone, thick) in enumerate(zones.items()):
        colour = sheet.style.colour(zone, palette.stratum(k))
        axes.fill_between([0.0, 1.0], tops[k + 1], tops[k], color=colour, linewidth=0)
        middle = 0.5 * (tops[k] + tops[k + 1])
        axes.text(
            0.5, middle, f"{zone}\n{thick:.0f} m", ha="center", va="center", fontsize=points,
            family=furniture.FONT, color=palette.INK, parse_math=False,
            path_effects=furniture.rim_of_words(unit),
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
    if isinstance(sheet, furniture.UserSheet):
        axes.set_title(title, loc="left", parse_math=False)
    else:
        sheet.text((28 * unit, layout.height - 34 * unit), title, 13.5 / unit, weight="bold")
        words = "Heights: square root of the mean thickness. Wavy lines are unconformities."
        sheet.text((28 * unit, 24 * unit), words, 10.0 / unit, palette.FAINT)
        apply_theme(sheet.figure, sheet.axes, sheet.style)


def _draw_horizon(axes: Axes, level: float, name: str, rule: str, points: float) -> None:
    """The line of a horizon, wavy if it cuts others, with its name and rule on the right."""
    x = np.linspace(0.0, 1.0, 40 * WAVES + 1)
    wave = 0.0 if rule == "conformable" else 0.006 * abs(axes.dataLim.height)
    y = level + wave * np.sin(2.0 * np.pi * WAVES * x)
    axes.plot(x, y, color=palette.INK, linewidth=points / 8.0, clip_on=False)
    label = name if rule == "conformable" else f"{name} ({rule})"
    axes.annotate(
        label, (1.0, level), (6.0, 0.0), textcoords="offset points", ha="left", va="center",
        fontsize=points, family=furniture.FONT, color=palette.INK, annotation_clip=False,
        parse_math=False,
    )  # fmt: skip


def column_of(units: Sequence[tuple[str, float, float]], zones: Sequence[str]) -> dict[str, float]:
    """Return the mean thickness of zones [m], from zone, volume and map area of each unit."""
    volume, area = dict.fromkeys(zones, 0.0), dict.fromkeys(zones, 0.0)
    for zone, v, a in units:
        volume[zone] += v
        area[zone] += a
    return {zone: volume[zone] / area[zone] if area[zone] > 0.0 else 0.0 for zone in zones}
