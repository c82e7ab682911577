"""Horizons in the wrong order: an older one that lies above a younger one nearly everywhere."""

from __future__ import annotations

from collections.abc import Iterator

from geosurf.errors import GeosurfWarning
from geosurf.model import Units
from geosurf.model.column import CONFORMABLE

_MOST = 0.5  # of the map: where horizons merely cross somewhere, the report lists it


def warnings_of_order(units: Units) -> Iterator[GeosurfWarning]:
    """
    Yield a warning for each pair of conformable horizons of which the older one is mostly above.

    Rules of the column declare that one removes the other, so those are left alone.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=5)
    >>> turned_over = dict(reversed(world.horizons.items()))
    >>> surfaces = [gs.triangulate_horizon(h, name=n) for n, h in turned_over.items()]
    >>> patches = gs.rebuild_surfaces([*surfaces, *gs.build_walls(world.box)])
    >>> (found,) = warnings_of_order(gs.carve_units(patches))
    >>> found.kind, found.subject, found.effect[:47]
    ('order', 'Top', "Horizon 'Top' lies above 'Base', which is given")
    """
    for clip in units.report.get("clipped", ()):
        share = min(clip.area / units.footprint, 1.0)
        if clip.rule != CONFORMABLE or share < _MOST:
            continue
        where = "everywhere" if share > 0.995 else f"on {100 * share:.0f} % of the area"
        yield GeosurfWarning(
            "order",
            clip.horizon,
            f"Horizon {clip.horizon!r} lies above {clip.by!r}, which is given as the younger one, "
            f"{where}: {clip.volume:.3g} m3 between them are clipped.",
            "Give horizons youngest first. If these are depths, give positive='down'. If "
            f"{clip.by!r} erodes {clip.horizon!r}, give column={{{clip.by!r}: 'erosional'}}.",
            clip.place,
        )
