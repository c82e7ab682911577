"""Pictures, drawn off-screen: anything -> PNG.

==================  ====================================================
render_scene        what a scene holds, asking only for what is shown
render_surfaces     horizons, faults and the curves where they meet
render_units        zone x block units, drawn apart, with their volumes
render_map          one horizon in map view, with contours and curves
render_thickness    a thickness map of one zone, with fault polygons
render_allan        what lies across a fault from what
render_section      a vertical section: zones, faults, contacts
render_search       how the voxel search finds a curve
render_place        a close-up of one place, as errors name it
doctor              what geosurf stands on here, and whether it can draw
==================  ====================================================

pyvista and VTK are imported when the first picture is drawn. Coordinates are
shifted to the middle of the model in float64 before VTK sees them, so that its
float32 never shows. The same picture drawn twice has the same bytes.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean, is_word
from geosurf.errors import InputError
from geosurf.model import Curves, TriSurface, Units, VoxelSearch
from geosurf.model.expected import expect, flag_of, listed, number_of
from geosurf.render.allan import render_allan
from geosurf.render.backend import doctor
from geosurf.render.clip import Prism, as_modelled
from geosurf.render.compose import draw_picture, png_path, save_png
from geosurf.render.isochores import render_thickness
from geosurf.render.layers import (
    Content,
    show_curves,
    show_outline,
    show_patches,
    show_surfaces,
    show_units,
)
from geosurf.render.section import render_section
from geosurf.render.views import VIEWS, check_size, view_vectors

__all__ = [
    "VIEWS",
    "doctor",
    "render_allan",
    "render_map",
    "render_place",
    "render_scene",
    "render_search",
    "render_section",
    "render_surfaces",
    "render_thickness",
    "render_units",
]

SIZE = (1280, 800)
# what a scene can show, and the roles of surfaces that each word stands for
ROLES_SHOWN = {"horizons": "horizon", "faults": "fault", "walls": "wall", "surfaces": "surface"}
SHOWABLE = (*ROLES_SHOWN, "curves", "patches", "units")
_SHOW = f"give a list of any of {', '.join(SHOWABLE)}"


def render_scene(
    scene: Any,
    path: str | os.PathLike[str],
    *,
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    show: Sequence[str] = ("horizons", "faults", "curves"),
    exploded: float = 0.0,
    clip: bool = True,
) -> Path:
    """Draw a scene, and compute no more of it than is shown.

    Parameters
    ----------
    scene : Scene
        Or anything that has those of ``surfaces``, ``curves``, ``patches`` and ``units``
        that are shown, and ``box``.
    path : path-like
        A ``.png`` file; its folder is created.
    view : str
        Where the eye is: ``"southwest"``, ``"southeast"``, ``"northwest"``, ``"northeast"``,
        ``"south"``, ``"north"``, ``"east"``, ``"west"`` or ``"top"``.
    size : (int, int)
        Width and height in pixels.
    exaggeration : float, optional
        Vertical exaggeration; default: a round number that reads well. It is
        printed below the picture.
    show : sequence of str
        Any of ``"horizons"``, ``"faults"``, ``"walls"``, ``"surfaces"``, ``"curves"``,
        ``"patches"``, ``"units"``.
    exploded : float
        How far units are drawn apart, as a part of the size of the model box.
    clip : bool
        Whether surfaces and curves are shown only where the model is, in its box and
        area of interest.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        If there is no such view, nothing of that name to show, or nothing to draw.
    OutputError
        If the file cannot be written.
    DependencyError
        If nothing here can draw; says which package brings it.

    Examples
    --------
    >>> import tempfile
    >>> from types import SimpleNamespace
    >>> ramp = TriSurface("F1", "fault", [[0, 0, 0], [900, 0, 0], [0, 900, 500]], [[0, 1, 2]])
    >>> scene = SimpleNamespace(surfaces=(ramp,), box=(0, 900, 0, 900, -100, 600))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     render_scene(scene, f"{folder}/view.png", show=["faults"], size=(400, 250)).name
    'view.png'
    """
    view_vectors(view)
    check_size(size)
    png_path(path)
    clip = flag_of(clip, "clip")
    exploded = number_of(exploded, "exploded", "give a part of the size of the box, 0 or above")
    show = (show,) if isinstance(show, str) else listed(show, "show takes words", _SHOW)
    for word in show:
        if not is_word(word, SHOWABLE):
            raise InputError(
                f"a scene cannot show {word!r}; show any of {', '.join(SHOWABLE)}."
                f"{did_you_mean(word, SHOWABLE)}"
            )
    _refuse_what_is_no_scene(scene, show)
    roles = {ROLES_SHOWN[word] for word in show if word in ROLES_SHOWN}
    content, box = Content(), getattr(scene, "box", None)
    outline = getattr(scene, "aoi", None) if clip and box is not None else None
    within = Prism(box, outline) if clip and box is not None else None
    if roles:
        shown = (as_modelled(scene, s) for s in scene.surfaces if s.role in roles)
        content += show_surfaces(shown, within)
    if "patches" in show:
        content += show_patches(scene.patches, within)
    if "units" in show:
        content += show_units(scene.units, exploded)
    if "curves" in show:
        content += show_curves(scene.curves, within=within)
    if outline is not None and not exploded:
        content += show_outline(outline, box[4])
    return draw_picture(
        content,
        path,
        title=_title(show),
        view=view,
        size=size,
        exaggeration=exaggeration,
        box=None if exploded else box,
        axes=not exploded,
        relief_of=box,
    )


def _refuse_what_is_no_scene(scene: Any, show: Sequence[str]) -> None:
    """A scene has what is to be shown; the surfaces of others are drawn by `render_surfaces`."""
    for word in show:
        wanted = "surfaces" if word in ROLES_SHOWN else word
        if not hasattr(scene, wanted) or isinstance(scene, Mapping):
            raise InputError(
                f"render_scene takes a Scene, not {type(scene).__name__}, which has no {wanted}; "
                "make one with geosurf.Scene(horizons, faults, box)."
            )


def _title(show: Sequence[str]) -> str:
    words = [word for word in SHOWABLE if word in show]
    if not words:
        return "Scene"
    head, last = ", ".join(words[:-1]), words[-1]
    return (f"{head} and {last}" if head else last).capitalize()


def render_surfaces(
    surfaces: Iterable[TriSurface],
    curves: Curves | None = None,
    *,
    path: str | os.PathLike[str],
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    title: str = "Surfaces",
) -> Path:
    """Draw surfaces and, if given, the curves where they meet.

    Parameters
    ----------
    surfaces : iterable of TriSurface
        Horizons youngest first: they take the colours of the column in that order.
    curves : Curves, optional
    path : path-like
        A ``.png`` file; its folder is created.
    view, size, exaggeration
        As in `render_scene`.
    title : str

    Returns
    -------
    Path

    Raises
    ------
    InputError, OutputError, DependencyError
        As `render_scene`.

    Examples
    --------
    >>> import tempfile
    >>> ramp = TriSurface("F1", "fault", [[0, 0, 0], [900, 0, 0], [0, 900, 500]], [[0, 1, 2]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     render_surfaces([ramp], path=f"{folder}/ramp.png", size=(400, 250)).name
    'ramp.png'
    """
    content = show_surfaces(surfaces)
    if curves is not None:
        content += show_curves(curves)
    return draw_picture(content, path, title=title, view=view, size=size, exaggeration=exaggeration)


def render_units(
    units: Units,
    path: str | os.PathLike[str],
    *,
    explode: float = 0.3,
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    title: str = "Units: zone by zone, block by block",
) -> Path:
    """Draw the units of a model apart: zones up and down, blocks sideways.

    Parameters
    ----------
    units : Units
        One colour per zone, one shade of it per block; the legend gives the volumes.
    path : path-like
        A ``.png`` file; its folder is created.
    explode : float
        How far apart, as a part of the size of the model box; 0 draws the model whole.
    view, size, exaggeration
        As in `render_scene`.
    title : str

    Returns
    -------
    Path

    Raises
    ------
    InputError, OutputError, DependencyError
        As `render_scene`.
    """
    expect(units, Units, "render_units takes Units", "scene.units and carve_units are some")
    explode = number_of(explode, "explode", "give a part of the size of the box, 0 or above")
    note = "" if explode == 0.0 else "Units are drawn apart."
    return draw_picture(
        show_units(units, explode),
        path,
        title=title,
        note=note,
        view=view,
        size=size,
        exaggeration=exaggeration,
        box=units.box if explode == 0.0 else None,
        axes=explode == 0.0,
        relief_of=units.box,
    )


def render_map(
    surface: TriSurface,
    curves: Curves | None = None,
    *,
    path: str | os.PathLike[str],
    size: tuple[int, int] = SIZE,
    title: str | None = None,
    outline: np.ndarray | None = None,
    faults: Sequence[str] = (),
) -> Path:
    """Draw a horizon in map view: elevation in colour, contour lines, its curves in bold.

    Parameters
    ----------
    surface : TriSurface
    curves : Curves, optional
        Those that lie on the surface are drawn, one colour per other surface.
    path : path-like
        A ``.png`` file; its folder is created.
    size : (int, int)
        Width and height in pixels.
    title : str, optional
        Default: the name of the surface.
    outline : ndarray of float64, shape (n, 2), optional
        Easting and northing around the area that is shown, counter-clockwise [m]; default: all.
    faults : sequence of str
        Names of all faults: their curves have the colours that faults have in other pictures.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the surface is empty or vertical, or the curves do not know it.
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> dip = TriSurface("Top", "horizon", [[0, 0, -9], [900, 0, -50], [0, 900, -80]], [[0, 1, 2]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     render_map(dip, path=f"{folder}/map.png", size=(400, 250)).name
    'map.png'
    """
    from geosurf.render.map import draw_map

    expect(surface, TriSurface, "render_map takes a TriSurface", "scene.surface(name) is one")
    title = f"{surface.name}: elevation" if title is None else title
    faults = listed(faults, "faults are names of faults", "give a list, as scene.fault_names")
    return save_png(draw_map(surface, curves, check_size(size), title, outline, faults), path)


def render_search(
    surface_a: TriSurface,
    surface_b: TriSurface,
    search: VoxelSearch,
    curves: Curves | None,
    path: str | os.PathLike[str],
    *,
    view: str = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    title: str = "Voxel search: global box, voxels, candidate faces, curve",
) -> Path:
    """Draw how voxels find a curve: they leave few faces to compare.

    Parameters
    ----------
    surface_a, surface_b : TriSurface
        The surfaces searched, drawn as glass; their candidate faces are solid.
    search : VoxelSearch
    curves : Curves or None
        What was found, in red.
    path : path-like
        A ``.png`` file; its folder is created.
    view, size, exaggeration, title
        As in `render_surfaces`.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the search does not belong to these surfaces.
    OutputError, DependencyError
        As `render_scene`.
    """
    from geosurf.render.palette import ACCENT
    from geosurf.render.search import show_search

    content = show_search(surface_a, surface_b, search)
    if curves is not None:
        content += show_curves(curves, ACCENT, 3.6, {surface_a.name, surface_b.name})
    return draw_picture(content, path, title=title, view=view, size=size, exaggeration=exaggeration)


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
    """Draw a close-up of one place: the surfaces around it, and a mark.

    Errors of the geometry know theirs: `GeometryError.place`.

    Parameters
    ----------
    surfaces : iterable of TriSurface
    place : (easting, northing, elevation)
        World coordinates [m].
    path : path-like
        A ``.png`` file; its folder is created.
    reach : float, optional
        How far the picture goes to each side [m]; default: a twelfth of all surfaces.
    view, size, exaggeration
        As in `render_scene`.
    title : str

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the place or the reach is none.
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
    from geosurf.render.place import show_place

    view_vectors(view)
    content, box = show_place(surfaces, place, reach)
    return draw_picture(
        content, path, title=title, view=view, size=size, exaggeration=exaggeration, box=box
    )
