"""What notebooks show of a scene: a card of its inputs, and an interactive view of its units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from geosurf.conventions import counted
from geosurf.conventions.card import Card
from geosurf.errors import InputError
from geosurf.model import Sheet, Units
from geosurf.model.compartments import ENDS
from geosurf.model.expected import number_of
from geosurf.rebuild import rebuild_surfaces, trim_sheets
from geosurf.scene.interactive_view import InteractiveView

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.scene.memory import Memory

MOST_WARNINGS = 5


class ShownScene:
    """How a `Scene` shows itself."""

    def show(self: Any, what: str = "units", max_triangle: int = 120_000) -> InteractiveView:
        """
        Return an interactive view: notebooks draw it, ``save("view.html")`` writes it.

        Parameters
        ----------
        what : {"units", "surfaces"}
            The sealed units, or horizons and faults as they are read, extended and torn.
        max_triangle : int
            As for `view_3d`, which makes the content.

        Returns
        -------
        InteractiveView

        Raises
        ------
        InputError
            For another word, or if `max_triangle` is not a number above 0.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes(n=5)
        >>> gs.Scene(world.horizons, world.faults, world.box).show()  # doctest: +ELLIPSIS
        <InteractiveView of '6 units', ... MB: save('view.html') writes it>
        """
        from geosurf.report.viewer import viewer_html

        # the view first: it refuses other words
        view = self.view_3d(max_triangle, what=what)
        title = ", ".join((*self.horizon_names, *self.fault_names))
        if what == "units":
            title = counted(len(self.units), "unit")
        return InteractiveView(title, viewer_html(view, title))

    def _repr_html_(self: Any) -> str:
        """Return inputs, what is computed already, and warnings; nothing is computed for it."""
        memory: Memory = self._plain.memory
        ran = [step for step in memory.steps if step.outcome == "ran"]
        stages = dict.fromkeys(step.stage for step in ran)
        rows = [
            ("horizons", ", ".join(self.horizon_names)),
            ("faults", ", ".join(self.fault_names) or "none"),
            *self._walls_in_words(),
            ("computed", ", ".join(stages) or "nothing yet: ask for curves, units or volumes"),
        ]
        if ran:
            rows.append(("time", f"{sum(step.seconds for step in ran):.2f} s"))
        notes = [str(warning) for warning in memory.warnings[:MOST_WARNINGS]]
        left = len(memory.warnings) - MOST_WARNINGS
        notes += [f"and {counted(left, 'warning')} more: scene.warnings"] if left > 0 else []
        return Card("Scene", rows, notes=notes).html()

    def _graph_so_far(self: Any) -> Any:
        """The results; with horizons as they were given, if they are not torn yet."""
        return vars(self).get("_graph", self._plain)

    def _walls_in_words(self: Any) -> list[tuple[str, str]]:
        """The row of virtual walls: what they continue, and their joins once they are known."""
        graph = self._graph_so_far()
        wanted = [name for name, ends in graph.inputs.compartments.items() if ends]
        if not wanted:
            return []
        if "_patches_and_ends" not in vars(graph):  # nothing is computed for a card
            return [("virtual walls", f"of {', '.join(wanted)}")]
        along = [str(one) for one in self.virtual_walls if one.side in ENDS]
        return [("virtual walls", "; ".join(along) or "none")]


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


def checked_max_triangle(max_triangle: Any) -> int:
    """Return a number of triangles, or raise an InputError."""
    most = number_of(max_triangle, "max_triangle", "give a number above 0")
    if most <= 0.0:
        raise InputError(f"max_triangle is {max_triangle!r}; give a number above 0.")
    return int(max(1.0, most))


def _drawable(thing: Any) -> Any:
    """What stands for a thing: units for a scene, and a sheet that ends on its faults."""
    if isinstance(thing, ShownScene):
        units: Units = cast(Any, thing).units
        return units
    if isinstance(thing, Sheet):
        # walls of a sheet continue beyond its faults; what lies beyond is no data
        return trim_sheets(rebuild_surfaces([thing.surface, *thing.faults]))
    return thing


def _title_of(thing: Any, drawn: Any) -> str:
    if isinstance(drawn, Units):
        return counted(len(drawn), "unit")
    return str(getattr(thing, "name", type(thing).__name__))
