"""Draw a scene, surfaces or units in three dimensions."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from geosurf.conventions import did_you_mean, is_word
from geosurf.errors import InputError
from geosurf.model import Curves, TriSurface, Units
from geosurf.model.expected import expect, flag_of, listed, number_of
from geosurf.model.protocols import DrawnModel
from geosurf.render.clip import Prism
from geosurf.render.colouring import check_colour_by, selection_of
from geosurf.render.compose import check_look, draw_picture
from geosurf.render.layers import Content, show_outline
from geosurf.render.overlay import PictureOverlay, overlay_of
from geosurf.render.overlay_drawing import show_overlay
from geosurf.render.picture_style import COLOUR_BY, PictureStyle, style_of
from geosurf.render.surface_layers import show_curves, show_patches, show_surfaces
from geosurf.render.thin_units import as_modelled, most_of_each
from geosurf.render.unit_layers import show_units
from geosurf.render.views import SIZE, View

# what a scene can show, and the roles of surfaces that each word stands for
ROLES_SHOWN = {"horizons": "horizon", "faults": "fault", "walls": "wall", "surfaces": "surface"}
SHOWABLE = (*ROLES_SHOWN, "curves", "patches", "units")
BUILT = {"walls", "surfaces", "patches", "units"}  # what has names that only a model knows
_SHOW = f"give a list of any of {', '.join(SHOWABLE)}"


def render_scene(
    scene: DrawnModel,
    path: str | os.PathLike[str],
    *,
    view: View = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    zoom: float = 1.0,
    show: Sequence[str] = ("horizons", "faults", "curves"),
    only: Sequence[str] | None = None,
    colour_by: Any = None,
    exploded: float = 0.0,
    clip: bool = True,
    title: str | None = None,
    overlay: PictureOverlay | None = None,
    style: PictureStyle | None = None,
) -> Path:
    """Draw a scene; only the results that are shown are computed.

    Parameters
    ----------
    scene : Scene
        Or any object with ``box``, ``aoi`` and with those of ``surfaces``, ``curves``, ``patches``
        and ``units`` that are shown: see ``geosurf.model.protocols.DrawnModel``.
    path : path-like
        A ``.png`` file; its folder is created.
    view : str or (float, float)
        Position of the viewer: ``"southwest"``, ``"southeast"``, ``"northwest"``, ``"northeast"``,
        ``"south"``, ``"north"``, ``"east"``, ``"west"`` or ``"top"``; or its azimuth, clockwise
        from north, and its height above the horizontal [degrees], as in ``(225, 30)``. The
        projection is parallel, so the scale bar is valid everywhere.
    size : (int, int)
        Width and height in pixels.
    exaggeration : float, optional
        Vertical exaggeration. Default: a round number that suits the shape of the model. It is
        printed below the picture.
    zoom : float
        2 shows the middle of the model at twice the scale.
    show : sequence of str
        Any of ``"horizons"``, ``"faults"``, ``"walls"``, ``"surfaces"``, ``"curves"``,
        ``"patches"``, ``"units"``.
    only : sequence of str, optional
        Names of the surfaces and units that are drawn; units also by zone or block. Default: all.
    colour_by : str, mapping of str to float, or array_like of float, optional
        Colours of units: ``"unit"``, ``"zone"``, ``"block"``, ``"contact"``, or numbers, one per
        unit or by name, with a colour bar. ``"z"`` colours units and horizons by elevation.
    exploded : float
        Gap between units, as a fraction of the size of the model box.
    clip : bool
        Whether surfaces and curves are clipped to the model box and the area of interest.
    title : str, optional
        Default: what is shown.
    overlay : PictureOverlay, optional
        Wells, polygons and data points that are drawn with the model.
    style : PictureStyle, optional
        Theme, font, colours by name, colour map.

    Returns
    -------
    Path
        The picture.

    Raises
    ------
    InputError
        If the view, a word in `show` or a name in `only` is unknown, or the picture is empty.
    OutputError
        If the file cannot be written.
    DependencyError
        If no graphics driver can draw. The message lists the packages to install.

    Examples
    --------
    >>> import tempfile
    >>> from types import SimpleNamespace
    >>> ramp = TriSurface("F1", "fault", [[0, 0, 0], [900, 0, 0], [0, 900, 500]], [[0, 1, 2]])
    >>> scene = SimpleNamespace(surfaces=(ramp,), box=(0, 900, 0, 900, -100, 600), aoi=None)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     render_scene(scene, f"{folder}/view.png", show=["faults"], size=(400, 250)).name
    'view.png'
    """
    check_look(view, size, zoom, title, path)
    style, overlay = style_of(style), overlay_of(overlay)
    selection = selection_of(only)
    clip = flag_of(clip, "clip")
    exploded = number_of(exploded, "exploded", "give a fraction of the size of the box, 0 or above")
    show = (show,) if isinstance(show, str) else listed(show, "show must be a list of words", _SHOW)
    for word in show:
        if not is_word(word, SHOWABLE):
            raise InputError(
                f"unknown word in show: {word!r}. Use any of {', '.join(SHOWABLE)}."
                f"{did_you_mean(word, SHOWABLE)}"
            )
    by = "unit" if colour_by is None else colour_by
    _check_colour_by(by, show)
    if selection.names is not None and not BUILT & set(show):
        selection.check(_names_of(scene, show))
    _check_scene(scene, show)

    # only what is shown is asked of the scene, so that nothing else is computed
    roles = {ROLES_SHOWN[word] for word in show if word in ROLES_SHOWN}
    if selection.names is not None and BUILT & set(show):
        selection.check(_names_of(scene, show))
    content, box = Content(), scene.box
    outline = scene.aoi if clip else None
    within = Prism(box, outline) if clip else None
    if roles:
        # torn horizons end on their faults: what lies beyond is not part of the model
        some = [s for s in scene.surfaces if s.role in roles]
        most = most_of_each(len(some), size, zoom)
        shown = (as_modelled(scene, s, most) for s in some)
        by_elevation = isinstance(by, str) and by == "z"
        content += show_surfaces(
            shown, within, only=selection, by_elevation=by_elevation, style=style, size=size,
            zoom=zoom,
        )  # fmt: skip
    if "patches" in show:
        content += show_patches(scene.patches, within, only=selection, style=style)
    if "units" in show:
        content += show_units(scene.units, exploded, only=selection, colour_by=by, style=style)
    if "curves" in show:
        content += show_curves(scene.curves, within=within)

    # an exploded model has no common outline or axes any more
    if outline is not None and not exploded:
        content += show_outline(outline, box[4])
    if overlay:
        content += show_overlay(overlay, box[5])
    return draw_picture(
        content,
        path,
        title=_title(show, colour_by) if title is None else title,
        view=view,
        size=size,
        exaggeration=exaggeration,
        zoom=zoom,
        style=style,
        box=None if exploded else box,
        axes=not exploded,
        relief_of=box,
    )


def _names_of(scene: DrawnModel, show: Sequence[str]) -> list[str]:
    """Names that `only` may have: of surfaces and, where they are shown, of units."""
    names = [*getattr(scene, "horizon_names", ()), *getattr(scene, "fault_names", ())]
    if not names or {"walls", "surfaces", "patches"} & set(show):
        names += [surface.name for surface in scene.surfaces]
    if "units" in show:
        for unit in scene.units.values():
            names += [unit.name, unit.zone, unit.block]
    return [name for name in names if name]


def _check_colour_by(colour_by: Any, show: Sequence[str]) -> None:
    """Refuse a colouring that nothing in the picture has."""
    by, _ = check_colour_by(colour_by)
    fits = ("unit", "z") if not isinstance(by, str) or "units" not in show else COLOUR_BY
    if "units" not in show and not (isinstance(by, str) and by in fits):
        raise InputError(
            f"colour_by is {colour_by!r}, which colours units, but show has no units. Add 'units' "
            "to show."
        )


def _check_scene(scene: object, show: Sequence[str]) -> None:
    """Raise an error if the scene lacks something that is to be shown."""
    for wanted in ("box", "aoi", *("surfaces" if word in ROLES_SHOWN else word for word in show)):
        if not hasattr(scene, wanted) or isinstance(scene, Mapping):
            raise InputError(
                f"render_scene takes a Scene; {type(scene).__name__} has no attribute {wanted!r}. "
                "Make a scene with geosurf.Scene(horizons, faults, box)."
            )


def _title(show: Sequence[str], colour_by: Any = None) -> str:
    """Return the title: a list of what the picture shows, and what it is coloured by."""
    # in the order of `SHOWABLE`, however the caller listed them
    words = ["intersection lines" if w == "curves" else w for w in SHOWABLE if w in show]
    if not words:
        return "Scene"
    head, last = ", ".join(words[:-1]), words[-1]
    title = (f"{head} and {last}" if head else last).capitalize()
    if colour_by is None:
        return title
    _, kind = check_colour_by(colour_by)
    return f"{title}, by {'elevation' if kind == 'z' else kind}"


def render_surfaces(
    surfaces: Iterable[TriSurface],
    curves: Curves | None = None,
    *,
    path: str | os.PathLike[str],
    view: View = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    zoom: float = 1.0,
    colour_by: str = "surface",
    title: str = "Surfaces",
    style: PictureStyle | None = None,
) -> Path:
    """Draw surfaces and, optionally, their intersection lines.

    Parameters
    ----------
    surfaces : iterable of TriSurface
        Horizons from the youngest to the oldest; they take the colours of the column in this order.
    curves : Curves, optional
    path : path-like
        A ``.png`` file; its folder is created.
    view, size, exaggeration, zoom, style
        As in `render_scene`.
    colour_by : {"surface", "z"}
        Horizons in colours of their own, or by elevation with a colour bar.
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
    check_look(view, size, zoom, title, path)
    style = style_of(style)
    if not is_word(colour_by, ("surface", "z")):
        raise InputError(f"colour_by is {colour_by!r}, expected 'surface' or 'z'.")
    content = show_surfaces(
        surfaces, by_elevation=colour_by == "z", style=style, size=size, zoom=zoom
    )
    if curves is not None:
        content += show_curves(curves)
    return draw_picture(
        content, path, title=title, view=view, size=size, exaggeration=exaggeration, zoom=zoom,
        style=style,
    )  # fmt: skip


def render_units(
    units: Units,
    path: str | os.PathLike[str],
    *,
    explode: float = 0.3,
    view: View = "southwest",
    size: tuple[int, int] = SIZE,
    exaggeration: float | None = None,
    zoom: float = 1.0,
    only: Sequence[str] | None = None,
    colour_by: Any = "unit",
    title: str | None = None,
    style: PictureStyle | None = None,
) -> Path:
    """Draw the units of a model in an exploded view: zones up and down, blocks sideways.

    Parameters
    ----------
    units : Units
        Each zone has a colour, each block a shade of it; the legend lists the volumes.
    path : path-like
        A ``.png`` file; its folder is created.
    explode : float
        Gap between units, as a fraction of the size of the model box; 0 for no gap.
    view, size, exaggeration, zoom, only, colour_by, style
        As in `render_scene`.
    title : str, optional
        Default: what units are coloured by.

    Returns
    -------
    Path

    Raises
    ------
    InputError, OutputError, DependencyError
        As `render_scene`.
    """
    expect(units, Units, "render_units takes Units", "pass scene.units")
    check_look(view, size, zoom, title, path)
    style, selection = style_of(style), selection_of(only)
    explode = number_of(explode, "explode", "give a fraction of the size of the box, 0 or above")
    by, words = check_colour_by(colour_by)
    selection.check(n for unit in units.values() for n in (unit.name, unit.zone, unit.block) if n)
    words = "zone and block" if isinstance(by, str) and by == "unit" else words
    note = "" if explode == 0.0 else "Exploded view."
    return draw_picture(
        show_units(units, explode, only=selection, colour_by=colour_by, style=style),
        path,
        title=f"Units by {'elevation' if words == 'z' else words}" if title is None else title,
        note=note,
        view=view,
        size=size,
        exaggeration=exaggeration,
        zoom=zoom,
        style=style,
        box=units.box if explode == 0.0 else None,
        axes=explode == 0.0,
        relief_of=units.box,
    )
