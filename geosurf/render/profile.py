"""Draw the throw of horizons along a fault: one line for each horizon."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from geosurf.errors import InputError
from geosurf.model.expected import expect
from geosurf.render import furniture, palette
from geosurf.render.diagram import diagram_axes, draw_ends, range_shown
from geosurf.render.layers import Entry
from geosurf.render.picture_style import readable

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

DARKER = 0.75  # than the zones of a column: thin lines on white
ROOM = 10.0  # margin on both sides [design pixels]
_NEEDED = ("throw", "along_strike", "pair")


def draw_throw(
    sheet: furniture.Sheet,
    throws: Mapping[str, xarray.Dataset],
    *,
    horizons: Sequence[str] = (),
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
    title : str, optional
        Default: the name of the fault.

    Raises
    ------
    InputError
        If there is no throw to draw, or `throws` are not results of `Scene.throw`.
    """
    how = "pass {horizon: scene.throw(horizon, fault)}"
    expect(throws, Mapping, "throws must be a mapping", how)
    for name, found in throws.items():
        if any(not hasattr(found, word) for word in _NEEDED):
            raise InputError(f"throws[{name!r}] is a {type(found).__name__} without throw; {how}.")

    # one line for each stretch of the fault on which both walls have a cut-off
    lines = {name: _stretches(found) for name, found in throws.items()}
    points = [line for parts in lines.values() for line in parts]
    if not points:
        raise InputError("no horizon has throw along this fault, so there is nothing to draw.")
    # no throw is in the picture, which is two metres high at least
    start = points[0][0, 0]
    throw = np.concatenate([line[:, 1] for line in points])
    # a little room, or the frame would cut the line at the largest throw in half
    room = 0.03 * np.ptp([*throw, 0.0])
    low, high = min(-1.0, throw.min() - room), max(1.0, throw.max() + room)
    every = np.concatenate([*points, [(start, low), (start, high)]])
    axes, _ = diagram_axes(
        sheet, range_shown(every, [every[:, 1]]), "Distance along strike [km]", ROOM, "Throw [m]"
    )

    # no throw, and the profiles in the colours of the horizons
    width = 2.0 * sheet.layout.unit * 72.0 / furniture.DPI
    axes.axhline(0.0, color=palette.FRAME, linewidth=0.5 * width, zorder=1)
    order = list(horizons) or list(throws)
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
        if parts:
            low, high = (f(float(f(line[:, 1])) for line in parts) for f in (min, max))
            span = f"{round(low)} to {round(high)} m".replace("-", "\N{MINUS SIGN}")
            legend.append(Entry(name, colour, span, "line"))
    furniture.draw_legend(sheet, tuple(legend), 640.0)
    attrs = next(iter(throws.values())).attrs
    fault = attrs.get("fault", "fault")
    if "dip_azimuth" in attrs:  # the strike is 90 degrees to the left of it
        draw_ends(sheet, axes, float(attrs["dip_azimuth"]) - 90.0)
    words = "Throw: vertical offset of both cut-offs; negative where the hanging wall is higher."
    furniture.draw_words(sheet, f"{fault}: throw" if title is None else title, words)


def _stretches(throw: xarray.Dataset) -> list[np.ndarray]:
    """Distance along strike and throw (n, 2) of each pair of cut-offs, in order [m]."""
    found = []
    for pair in np.unique(throw.pair.values).tolist():
        mine = (throw.pair.values == pair) & np.isfinite(throw.throw.values)
        line = np.column_stack([throw.along_strike.values[mine], throw.throw.values[mine]])
        if len(line):
            found.append(line[np.argsort(line[:, 0], kind="stable")])
    return found
