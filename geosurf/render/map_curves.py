"""Intersection lines on the map of a horizon, each named once at its longest line."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions import length_text
from geosurf.errors import InputError
from geosurf.model import Curves, TriSurface
from geosurf.model.expected import expect
from geosurf.render import furniture, palette
from geosurf.render.clip import Prism
from geosurf.render.layers import Entry
from geosurf.render.names import shortened_apart
from geosurf.render.palette import RGB

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes


def draw_curves(
    sheet: furniture.Sheet,
    axes: Axes,
    surface: TriSurface,
    curves: Curves,
    within: Prism | None,
    faults: list[str],
) -> list[Entry]:
    """Draw the intersection lines of a surface as bold lines.

    Lines of named faults have the colours of the faults, other lines are dark grey. If no faults
    are named, each surface has a colour.
    """
    from matplotlib.collections import LineCollection

    name = surface.name
    expect(curves, Curves, "curves must be Curves", "pass scene.curves")
    if name not in curves.names:
        raise InputError(
            f"the curves have no surface {name!r}. Their surfaces are {list(curves.names)}."
        )
    # colours: as faults in other pictures, or one for each other surface
    row = curves.names.index(name)
    met = (
        curves.names[k] for pair in curves.surfaces_of_curve.tolist() if row in pair for k in pair
    )
    order = faults or list(dict.fromkeys(other for other in met if other != name))
    colours = {
        other: sheet.style.colour(
            other, palette.fault(order.index(other)) if other in order else palette.INK
        )
        for other in curves.names
    }

    # length by other surface [m]; its lines; the longest one, and a place a third along it
    others: dict[int, float] = {}
    lines: dict[int, list[np.ndarray]] = {}
    longest: dict[int, tuple[float, np.ndarray]] = {}
    width = 2.6 * sheet.layout.unit * 72.0 / furniture.DPI
    for i, pair in enumerate(curves.surfaces_of_curve.tolist()):
        if row not in pair:
            continue

        # segments (n, 2, 3), clipped to the area that is shown
        line = curves.points[curves.curves[i]]
        ends = np.stack([line[:-1], line[1:]], axis=1)
        if within is not None:
            ends = within.segments(line, np.arange(len(line) - 1)[:, None] + np.arange(2))
        if not len(ends):
            continue
        other = pair[0] if pair[1] == row else pair[1]
        length = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())
        others[other] = others.get(other, 0.0) + length
        lines.setdefault(other, []).append(ends[:, :, :2])
        if length > (longest[other][0] if other in longest else 0.0):
            longest[other] = (length, ends[len(ends) // 3, 0, :2])

    # one object for each surface: 500 of them, one for each line, took two thirds of a map
    for other, parts in lines.items():
        colour = colours[curves.names[other]]
        shown = LineCollection(list(np.concatenate(parts)), colors=[colour], linewidths=width)
        shown.set_capstyle("round")
        axes.add_collection(shown, autolim=False)
    _name_lines(sheet, axes, {curves.names[other]: one for other, one in longest.items()}, colours)

    # faults first: where the legend has no room, horizons are the ones that are only counted
    met_here = sorted(others, key=lambda other: curves.names[other] not in faults)
    return [
        Entry(name, colours[name], f"intersection, {length_text(length)}", "line")
        for name, length in ((curves.names[k], others[k]) for k in met_here)
    ]


def _name_lines(
    sheet: furniture.Sheet,
    axes: Axes,
    longest: dict[str, tuple[float, np.ndarray]],
    colours: dict[str, RGB],
) -> None:
    """Write the name of each other surface next to its longest line.

    It goes 9 design pixels to the right, or to the left where it would leave the map; the longest
    lines first, and no name over another: the legend has them all.
    """
    unit = sheet.layout.unit
    labels = shortened_apart(longest)
    for other, (_, at) in sorted(longest.items(), key=lambda item: -item[1][0]):
        label = labels[other]
        x, y = axes.transData.transform(at)
        x += 9.0 * unit
        wide, high = sheet.text_size(label, 11.5, "bold")
        if x + wide > axes.bbox.x1:
            x -= 18.0 * unit + wide
        if not sheet.names.take((x, y - 0.7 * high, x + wide, y + 0.7 * high)):
            continue
        at = axes.transData.inverted().transform((x, y))
        colour = palette.shade(colours[other], 1, 2)
        furniture.halo_text(sheet, axes, at, label, 11.5, colour, ha="left", fontweight="bold")
