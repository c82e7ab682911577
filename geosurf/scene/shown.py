"""What notebooks show: a card of a scene, interactive views (`geosurf.show`), data of a sheet."""

from __future__ import annotations

import os
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted
from geosurf.conventions.card import Card
from geosurf.errors import InputError
from geosurf.model import Sheet, Units
from geosurf.model.column import ENDS
from geosurf.model.expected import number_of, path_of
from geosurf.rebuild import rebuild_surfaces, trim_sheets
from geosurf.write.written import commit

# ---- card ----------------------------------------
# What notebooks show of a scene: a card of its inputs, what was computed, and warnings.


MOST_WARNINGS = 5


def card_of(scene: Any) -> str:
    """Return inputs, what is computed already, and warnings; nothing is computed for it."""
    memory = scene._given.memory
    ran = [step for step in memory.steps if step.outcome == "ran"]
    stages = dict.fromkeys(step.stage for step in ran)
    rows = [
        ("horizons", ", ".join(scene.horizon_names)),
        ("faults", ", ".join(scene.fault_names) or "none"),
        *_walls_in_words(scene),
        ("computed", ", ".join(stages) or "nothing yet: ask for curves, units or volumes"),
    ]
    if ran:
        rows.append(("time", f"{sum(step.seconds for step in ran):.2f} s"))
    notes = [str(warning) for warning in memory.warnings[:MOST_WARNINGS]]
    left = len(memory.warnings) - MOST_WARNINGS
    notes += [f"and {counted(left, 'warning')} more: scene.warnings"] if left > 0 else []
    return Card("Scene", rows, notes=notes).html()


def _walls_in_words(scene: Any) -> list[tuple[str, str]]:
    """The row of virtual walls: what they continue, and their joins once they are known."""
    # with horizons as they were given, if they are not torn yet
    graph = vars(scene).get("_graph", scene._given)
    wanted = [name for name, ends in graph.inputs.compartments.items() if ends]
    if not wanted:
        return []
    if "_patches_and_ends" not in vars(graph):
        return [("virtual walls", f"of {', '.join(wanted)}")]
    along = [str(one) for one in scene.virtual_walls if one.side in ENDS]
    return [("virtual walls", "; ".join(along) or "none")]


# ---- interactive view ----------------------------------------
# An interactive view: a page that notebooks show in a frame, and browsers as it is.


# ---- shown ----------------------------------------
# An interactive view of anything with a place in space: `geosurf.show`.


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
    from geosurf.report.page import viewer_html

    most = number_of(max_triangle, "max_triangle", "give a number above 0")
    if most <= 0.0:
        raise InputError(f"max_triangle is {max_triangle!r}; give a number above 0.")
    given = [_drawable(thing) for thing in things]
    view = view_of(given, int(max(1.0, most)))
    title = ", ".join(map(_title_of, things, given))
    return InteractiveView(title, viewer_html(view, title))


def _drawable(thing: Any) -> Any:
    """What stands for a thing: units for a scene, and a sheet that ends on its faults."""
    if hasattr(thing, "view_3d"):  # a scene
        return thing.units
    if isinstance(thing, Sheet):
        # walls of a sheet continue beyond its faults; what lies beyond is no data
        return trim_sheets(rebuild_surfaces([thing.surface, *thing.faults]))
    return thing


def _title_of(thing: Any, drawn: Any) -> str:
    if isinstance(drawn, Units):
        return counted(len(drawn), "unit")
    return str(getattr(thing, "name", type(thing).__name__))


# ---- data of a sheet ----------------------------------------


IGNORED, USED = "data that were ignored", "data in use"


def data_of(sheet: Any, data: Any, name: str, options: dict[str, Any]) -> dict[str, np.ndarray]:
    """
    Return the places (n, 3) of the data of a sheet, those that its tear ignored apart.

    Parameters
    ----------
    sheet : Sheet
        From `tear_horizon`.
    data
        What it was made of, in any form.
    name : str
    options : dict
        ``positive`` and ``length_unit`` of data that do not state them.

    Raises
    ------
    InputError
        If the horizon is not torn, or its data are not known.
    """
    if not isinstance(sheet, Sheet) or sheet.plan is None:
        raise InputError(
            f"horizon {name!r} was not torn by geosurf, so no data were ignored next to faults. "
            "Build the scene with tear=True."
        )
    if data is None or isinstance(data, Sheet):
        raise InputError(
            f"the scene has the sheet of horizon {name!r}, and not the data that it was made of. "
            "Pass them: data=gs.read_horizon(path), or data=gs.read_points(path)."
        )
    from geosurf.sheets.lattice.data import read_data  # loaded by those who tear

    words = {key: options.get(key) for key in ("positive", "length_unit")}
    picks = read_data(data, name, words["positive"], words["length_unit"]).picks
    places, ignored = picks.places(np.arange(len(picks.z))), sheet.plan.use.ignored
    if len(ignored) != len(places):  # wrong picks were left out, or the data are others
        return {USED: places}
    return {USED: places[~ignored], IGNORED: places[ignored]}


# ---- interactive view ----------------------------------------
# An interactive view: a page that notebooks show in a frame, and browsers as it is.


HEIGHT = 560  # in a notebook [pixels]


@dataclass(frozen=True, repr=False)
class InteractiveView:
    """
    An interactive view in a page of its own, which needs no network.

    Attributes
    ----------
    title : str
    page : str
        The page: HTML with its script and data inside.
    """

    title: str
    page: str

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the page, and return its path; any browser opens it.

        Parameters
        ----------
        path : path-like
            Ends with ``.html``.

        Returns
        -------
        pathlib.Path

        Raises
        ------
        InputError
            If the path does not end with ``.html``.
        OutputError
            If the file cannot be written.
        """
        path = path_of(path, "an interactive view")
        if path.suffix.lower() not in (".html", ".htm"):
            raise InputError(f"{path}: an interactive view is an HTML page. Use the suffix .html.")
        return commit(path, self.page.encode("utf-8"))[0]

    def __repr__(self) -> str:
        size = len(self.page) / 1e6
        return f"<InteractiveView of {self.title!r}, {size:.1f} MB: save('view.html') writes it>"

    def _repr_html_(self) -> str:
        """Return the page in a frame: its script cannot reach the notebook."""
        return (
            '<iframe sandbox="allow-scripts allow-downloads" allowfullscreen width="100%" '
            f'height="{HEIGHT}" style="border:0" title="{escape(self.title)}" '
            f'srcdoc="{escape(self.page)}"></iframe>'
        )
