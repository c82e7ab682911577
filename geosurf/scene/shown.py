"""What notebooks show of a scene: a card of its inputs, and an interactive view of its units."""

from __future__ import annotations

import os
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf.conventions import counted
from geosurf.conventions.card import Card
from geosurf.errors import InputError
from geosurf.model.expected import path_of

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.scene.memory import Memory

HEIGHT = 560  # of the view in a notebook [pixels]
MOST_WARNINGS = 5


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
        from geosurf.write._files import commit

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
        >>> gs.Scene(world.horizons, world.faults, world.box).show()
        <InteractiveView of '6 units', 0.0 MB: save('view.html') writes it>
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
        memory: Memory = self._graph.memory
        ran = [step for step in memory.steps if step.outcome == "ran"]
        stages = dict.fromkeys(step.stage for step in ran)
        rows = [
            ("horizons", ", ".join(self.horizon_names)),
            ("faults", ", ".join(self.fault_names) or "none"),
            ("computed", ", ".join(stages) or "nothing yet: ask for curves, units or volumes"),
        ]
        if ran:
            rows.append(("time", f"{sum(step.seconds for step in ran):.2f} s"))
        notes = [str(warning) for warning in memory.warnings[:MOST_WARNINGS]]
        left = len(memory.warnings) - MOST_WARNINGS
        notes += [f"and {counted(left, 'warning')} more: scene.warnings"] if left > 0 else []
        return Card("Scene", rows, notes=notes).html()


__all__ = ["InteractiveView", "ShownScene"]
