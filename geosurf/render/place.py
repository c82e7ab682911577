"""Draw a close-up of a place: the surfaces around it, clipped to a small box, and a marker."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from geosurf.conventions import is_number, number_text, real_numbers
from geosurf.errors import InputError
from geosurf.model import TriSurface
from geosurf.model.expected import expect, listed
from geosurf.render import palette
from geosurf.render.clip import Prism
from geosurf.render.compose import draw_picture
from geosurf.render.layers import Content, Entry, Layer
from geosurf.render.surface_layers import show_surfaces
from geosurf.render.views import SIZE, view_vectors

REACH = 1 / 12  # of the larger side of all surfaces
FLATTEST = 0.25  # height of the box over its width, where surfaces are flat


def render_place(
    surfaces: Iterable[TriSurface],
    place: Sequence[float],
    path: str | os.PathLike[str],
    *,
    reach: float | None = None,
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    title: str = "Close-up",
) -> Path:
    """Draw a close-up of one place: the surfaces around it, and a marker.

    Errors of the geometry have a place: `GeometryError.place`.

    Parameters
    ----------
    surfaces : iterable of TriSurface
    place : (easting, northing, elevation)
        World coordinates [m].
    path : path-like
        A ``.png`` file; its folder is created.
    reach : float, optional
        Half the width of the close-up [m]; default: a twelfth of the extent of all surfaces.
    view, size, exaggeration
        As in `render_scene`.
    title : str

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If `place` is not a point or `reach` is not positive.
    OutputError, DependencyError
        As `render_scene`.

    Examples
    --------
    >>> import tempfile
    >>> ramp = TriSurface("F1", "fault", [[0, 0, 0], [900, 0, 0], [0, 900, 500]], [[0, 1, 2]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     render_place([ramp], (300, 300, 166), f"{folder}/place.png", size=(400, 250)).name
    'place.png'
    """
    view_vectors(view)
    content, box = show_place(surfaces, place, reach)
    return draw_picture(
        content, path, title=title, view=view, size=size, exaggeration=exaggeration, box=box
    )


def show_place(
    surfaces: Iterable[TriSurface], place: Sequence[float], reach: float | None
) -> tuple[Content, tuple[float, ...]]:
    """
    Return the surfaces around a place, and the box they are clipped to.

    Parameters
    ----------
    surfaces : iterable of TriSurface
        Surfaces outside the close-up are left out.
    place : (easting, northing, elevation)
        World coordinates [m].
    reach : float or None
        Half the width of the close-up [m]; default: a twelfth of the extent of all surfaces.

    Returns
    -------
    content : Content
    box : (west, east, south, north, bottom, top)
        [m]

    Raises
    ------
    InputError
        If `place` is not a point or `reach` is not positive.
    """
    x, y, z = _checked(place, reach)
    how = "pass a list of TriSurface, as in scene.surfaces"
    given = listed(surfaces, "render_place takes surfaces", how)
    for surface in given:
        expect(surface, TriSurface, "render_place takes surfaces", how)
    surfaces = [surface for surface in given if surface.n_triangle]
    if reach is None:
        # a twelfth of the largest extent of all surfaces
        bounds = np.array([surface.bounds for surface in surfaces] or [(x, x, y, y, z, z)])
        sides = bounds[:, 1:4:2].max(axis=0) - bounds[:, 0:4:2].min(axis=0)
        reach = max(float(sides.max()) * REACH, 1.0)

    # only what lies in the cube around the place, clipped to it
    low = np.array([x - reach, y - reach, z - reach])
    high = np.array([x + reach, y + reach, z + reach])
    cube, near = Prism(np.column_stack([low, high]).ravel()), []
    for surface in surfaces:
        vertices, triangles, _ = cube.triangles(surface.vertices, surface.triangles)
        if len(triangles):
            near.append(TriSurface(surface.name, surface.role, vertices, triangles))
    if near:
        # the box shrinks to the surfaces, but a flat place keeps some height
        bottom = min(min(cut.bounds[4] for cut in near), z - FLATTEST * reach)
        top = max(max(cut.bounds[5] for cut in near), z + FLATTEST * reach)
        low[2], high[2] = bottom, top

    # three lines and a legend entry show the place itself
    mark = _mark(np.array([x, y, z]), low, high)
    label = f"E {number_text(x)} N {number_text(y)}, {number_text(z)} m".replace(
        "-", "\N{MINUS SIGN}"
    )
    content = show_surfaces(near) + Content(
        (mark,), (Entry("Location", palette.ACCENT, label, "line"),)
    )
    (w, s, b), (e, n, t) = low.tolist(), high.tolist()
    return content, (w, e, s, n, b, t)


def _checked(place: Sequence[float], reach: float | None) -> tuple[float, float, float]:
    try:
        values = real_numbers(place)
    except (TypeError, ValueError):
        values = np.empty(0)

    # text, wrong lengths and NaN are refused alike, before anything is drawn
    if values.shape != (3,) or not np.isfinite(values).all():
        raise InputError(
            f"place is {place!r}, expected three finite numbers: easting, northing, elevation [m]."
        )
    if reach is not None and not (is_number(reach) and reach > 0):
        raise InputError(
            f"reach is {reach!r}, expected a length above 0 m. Leave it out for the default."
        )
    x, y, z = values.tolist()
    return x, y, z


def _mark(place: np.ndarray, low: np.ndarray, high: np.ndarray) -> Layer:
    """Three lines through a place, each a third of the length of the box."""
    # arms along the three axes, rows 0 to 2 their lower ends, rows 3 to 5 the upper ones
    arm = np.diag((high - low) / 6.0)
    points = np.concatenate([place - arm, place + arm])
    lines = np.array([[0, 3], [1, 4], [2, 5]])
    return Layer(points, lines=lines, colour=palette.ACCENT, width=4.0)
