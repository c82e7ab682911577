"""An interactive view: a page that notebooks show in a frame, and browsers as it is."""

from __future__ import annotations

import os
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from geosurf.errors import InputError
from geosurf.model.expected import number_of, path_of
from geosurf.write.written import commit

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


def checked_max_triangle(max_triangle: Any) -> int:
    """Return a number of triangles, or raise an InputError."""
    most = number_of(max_triangle, "max_triangle", "give a number above 0")
    if most <= 0.0:
        raise InputError(f"max_triangle is {max_triangle!r}; give a number above 0.")
    return int(max(1.0, most))
