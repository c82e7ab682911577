"""Mark on a map where the tear of a horizon needed a remedy: `SheetReport.remedies`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from geosurf.conventions import counted
from geosurf.errors import GeosurfWarning
from geosurf.render import furniture, palette
from geosurf.render.layers import Entry

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes

RADIUS = 6.0  # of a mark [design pixels]


def draw_remedies(
    sheet: furniture.Sheet,
    axes: Axes,
    remedies: Sequence[GeosurfWarning],
) -> list[Entry]:
    """Mark the place of each remedy on the map; return the entry of the legend.

    Parameters
    ----------
    sheet : furniture.Sheet
    axes : Axes
        Of the map.
    remedies : sequence of GeosurfWarning
        Those without a place are left out.
    """
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    per = sheet.layout.unit * 72.0 / furniture.DPI
    shown: list[str] = []
    for remedy in remedies:
        if remedy.place is None:
            continue
        x, y = remedy.place[:2]

        # marks outside the map would stand in its margin, next to nothing
        if not (west <= x <= east and south <= y <= north):
            continue
        axes.plot(
            [x], [y], marker="o", markersize=2.0 * RADIUS * per, markerfacecolor="none",
            markeredgecolor=palette.ACCENT, markeredgewidth=2.4 * per, linestyle="none", zorder=6.5,
        )  # fmt: skip
        shown.append(remedy.kind)
    if not shown:
        return []

    # the legend counts each kind of remedy
    kinds = ", ".join(f"{kind}: {n}" for kind, n in sorted(Counter(shown).items()))
    words = f"{counted(len(shown), 'place')} of remedies"
    return [Entry(words, palette.ACCENT, kinds, "circle")]


__all__ = ["draw_remedies"]
