"""Draw a scene, surfaces or units in three dimensions."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean, is_number, is_word, number_text, real_numbers
from geosurf.errors import InputError
from geosurf.model import Curves, TriSurface, Units, VoxelSearch
from geosurf.model.expected import expect, flag_of, listed, number_of
from geosurf.model.protocols import DrawnModel
from geosurf.render import palette
from geosurf.render.clip import Prism
from geosurf.render.colouring import check_colour_by, selection_of
from geosurf.render.compose import check_look, draw_picture
from geosurf.render.layers import (
    BOX_EDGES,
    Content,
    Entry,
    Layer,
    show_box,
    show_outline,
    triangle_layer,
)
from geosurf.render.overlay import PictureOverlay, overlay_of
from geosurf.render.overlay_drawing import show_overlay
from geosurf.render.picture_style import COLOUR_BY, PictureStyle, style_of
from geosurf.render.surface_layers import show_curves, show_patches, show_surfaces
from geosurf.render.thin_units import as_modelled, most_of_each
from geosurf.render.unit_layers import show_units
from geosurf.render.views import SIZE, View, view_vectors

# ---- place ----------------------------------------
# Draw a close-up of a place: the surfaces around it, clipped to a small box, and a marker.


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


# ---- search ----------------------------------------
# Draw how the voxel search finds an intersection line: common box, voxels, candidate triangles.


PALE = 0.32
FAULT_OPACITY = 0.7
MAX_VOXEL_SHOWN = 4000


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
    title: str = "Voxel search for intersection lines",
    style: PictureStyle | None = None,
) -> Path:
    """Draw how the voxel search finds an intersection line: few triangles remain to be tested.

    Parameters
    ----------
    surface_a, surface_b : TriSurface
        Surfaces of the search, drawn semi-transparent; their candidate triangles are solid.
    search : VoxelSearch
    curves : Curves or None
        The intersection lines, drawn in red.
    path : path-like
        A ``.png`` file; its folder is created.
    view, size, exaggeration, title, style
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
    content = show_search(surface_a, surface_b, search)
    if curves is not None:
        content += show_curves(curves, palette.ACCENT, 3.6, {surface_a.name, surface_b.name})
    return draw_picture(
        content, path, title=title, view=view, size=size, exaggeration=exaggeration, style=style
    )


def show_search(first: TriSurface, second: TriSurface, search: VoxelSearch) -> Content:
    """Return both surfaces semi-transparent and their candidate triangles in full colour.

    Parameters
    ----------
    first, second : TriSurface
    search : VoxelSearch

    Raises
    ------
    InputError
        If the search refers to triangles that the surfaces do not have.
    """
    expect(search, VoxelSearch, "render_search takes a VoxelSearch", "pass scene.search(a, b)")
    content = Content()
    pairs = ((first, search.faces_a, 0), (second, search.faces_b, 2))
    for surface, faces, place in pairs:
        faces = _checked_faces(surface, faces)
        colour = palette.stratum(place) if surface.role != "fault" else palette.fault(0)
        content += _glass_and_candidates(surface, faces, colour)
    return content + _show_voxels(search)


def _checked_faces(surface: TriSurface, faces: np.ndarray) -> np.ndarray:
    expect(surface, TriSurface, "render_search takes surfaces", "pass those of the search")
    faces = np.asarray(faces, dtype=np.int64)
    bad = faces[(faces < 0) | (faces >= surface.n_triangle)]
    if len(bad):
        raise InputError(
            f"the search refers to triangle {bad[0]} of surface {surface.name!r}, which has only "
            f"{surface.n_triangle} triangles. Pass the surfaces of the search in the same order."
        )
    return faces


def _glass_and_candidates(surface: TriSurface, faces: np.ndarray, colour: palette.RGB) -> Content:
    # all triangles pale; candidates on top, with their edges
    others = np.delete(surface.triangles, faces, axis=0)
    solid = surface.triangles[faces]
    glass = triangle_layer(surface.vertices, others, colour=colour, opacity=PALE)
    chosen = triangle_layer(
        surface.vertices,
        solid,
        colour=palette.shade(colour, 1, 2),
        opacity=FAULT_OPACITY if surface.role == "fault" else 1.0,
        sharp=True,
    )

    # each edge once, however many candidates share it
    sides = np.unique(np.sort(solid[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    rims = Layer(surface.vertices, lines=sides, colour=palette.INK, width=0.5)
    legend = (
        Entry(surface.name, colour, f"{number_text(surface.n_triangle)} triangles", opacity=PALE),
        Entry("Candidate triangles", chosen.colour, f"{number_text(len(faces))} of {surface.name}"),
    )
    layers = (*([glass] if len(others) else []), *([chosen, rims] if len(faces) else []))
    return Content(layers, legend)


def _show_voxels(search: VoxelSearch) -> Content:
    bounds = tuple(float(x) for pair in zip(search.lower, search.upper, strict=True) for x in pair)
    content = show_box(bounds, colour=palette.INK, width=1.4)

    # voxels that hold triangles of both surfaces, of all those in the common box
    n_cell, occupied = int(np.prod(search.n_cell)), len(search.occupied)
    if occupied:
        points, lines = voxel_edges(search)
        content += Content((Layer(points, lines=lines, colour=palette.VOXEL, width=0.8),))
    detail = f"{number_text(occupied)} of {number_text(n_cell)} with both"
    legend = (
        Entry("Common box", palette.INK, "overlap of both bounds", "line"),
        Entry("Voxels", palette.VOXEL, detail, "line"),
    )
    return content + Content(legend=legend)


def voxel_edges(search: VoxelSearch) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) and distinct edges (n_edge, 2) of the occupied voxels.

    Only the first 4000 voxels are drawn: more could not be distinguished.
    """
    # cells (n, 3) -> their eight corners, each once; the twelve edges of each, each once
    cells = np.asarray(search.occupied, dtype=np.int64).reshape(-1, 3)[:MAX_VOXEL_SHOWN]
    corners = np.array(list(itertools.product((0, 1), repeat=3)))
    nodes, number = np.unique(
        (cells[:, None, :] + corners).reshape(-1, 3), axis=0, return_inverse=True
    )

    # number (n, 8): row of each corner of each voxel
    number = number.reshape(-1, 8)
    edges = np.unique(np.sort(number[:, BOX_EDGES].reshape(-1, 2), axis=1), axis=0)
    return np.asarray(search.lower) + nodes * float(search.size), edges


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
