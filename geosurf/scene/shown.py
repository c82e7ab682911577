"""An interactive view of anything with a place in space: `geosurf.show`."""

from __future__ import annotations

from typing import Any

from geosurf.conventions import counted
from geosurf.model import Sheet, Units
from geosurf.rebuild import rebuild_surfaces, trim_sheets
from geosurf.scene.interactive_view import InteractiveView, checked_max_triangle
from geosurf.scene.scene import Scene


def show(*things: Any, max_triangle: int = 120_000) -> InteractiveView:
    """
    Return an interactive view of anything with a place in space, and of several things together.

    Parameters
    ----------
    *things : TriSurface, Sheet, Curves, Patches, FaultSticks, FaultNetwork, Unit, Units, TetMesh \
        or Scene
        A sheet brings the faults that tear it, a fault network its faults, a scene its units.
    max_triangle : int
        About how many triangles all units have, or each gridded surface; blocks of grid cells are
        merged to get there. Curves are shown as they are.

    Returns
    -------
    InteractiveView
        Notebooks draw it; ``save("view.html")`` writes it.

    Raises
    ------
    InputError
        If there is nothing to show, or something without a place in space, or `max_triangle` is
        not a number above 0.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=5)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> gs.show(scene.surface("Top"), scene.curves)  # doctest: +ELLIPSIS
    <InteractiveView of 'Top, Curves', ... MB: save('view.html') writes it>
    """
    from geosurf.render.interactive import view_of
    from geosurf.report.viewer import viewer_html

    most = checked_max_triangle(max_triangle)
    given = [_drawable(thing) for thing in things]
    view = view_of(given, most)
    title = ", ".join(map(_title_of, things, given))
    return InteractiveView(title, viewer_html(view, title))


def _drawable(thing: Any) -> Any:
    """What stands for a thing: units for a scene, and a sheet that ends on its faults."""
    if isinstance(thing, Scene):
        return thing.units
    if isinstance(thing, Sheet):
        # walls of a sheet continue beyond its faults; what lies beyond is no data
        return trim_sheets(rebuild_surfaces([thing.surface, *thing.faults]))
    return thing


def _title_of(thing: Any, drawn: Any) -> str:
    if isinstance(drawn, Units):
        return counted(len(drawn), "unit")
    return str(getattr(thing, "name", type(thing).__name__))
