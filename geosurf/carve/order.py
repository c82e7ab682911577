"""Warn of horizons in the wrong order: an older one above a younger one nearly everywhere."""

from __future__ import annotations

from collections.abc import Iterator

from geosurf.carve.clipped import Clips
from geosurf.conventions import volume_text
from geosurf.errors import GeosurfWarning
from geosurf.model import Units
from geosurf.model.column import CONFORMABLE

_MOST = 0.5  # fraction of the map; smaller crossings are only listed in the report


def warnings_of_order(units: Units) -> Iterator[GeosurfWarning]:
    """
    Yield a warning for each pair of conformable horizons with the older one mostly above.

    Pairs with a rule of the column are skipped: the rule states which horizon removes the other.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=5)
    >>> turned_over = dict(reversed(world.horizons.items()))
    >>> surfaces = [gs.triangulate_horizon(h, name=n) for n, h in turned_over.items()]
    >>> patches = gs.rebuild_surfaces([*surfaces, *gs.build_walls(world.box)])
    >>> (found,) = warnings_of_order(gs.carve_units(patches))
    >>> found.kind, found.subject, found.effect[:37]
    ('order', 'Top', "Horizon 'Top' lies above the younger ")
    """
    clips = units.report.get("clipped", ())
    # areas of faces decide whether it is worth to measure what is clipped, with room for rounding
    if isinstance(clips, Clips):
        least = 0.99 * _MOST * units.footprint
        if max(clips.areas(CONFORMABLE), default=0.0) < least:
            return
    for clip in clips:
        share = min(clip.area / units.footprint, 1.0)
        if clip.rule != CONFORMABLE or share < _MOST:
            continue
        where = "everywhere" if share > 0.995 else f"on {100 * share:.0f} % of the area"
        yield GeosurfWarning(
            "order",
            clip.horizon,
            f"Horizon {clip.horizon!r} lies above the younger horizon {clip.by!r} {where}: "
            f"{volume_text(clip.volume)} between them is clipped.",
            "List horizons from the youngest to the oldest. If the values are depths, pass "
            f"positive='down'. If {clip.by!r} erodes {clip.horizon!r}, pass "
            f"column={{{clip.by!r}: 'erosional'}}.",
            clip.place,
        )
