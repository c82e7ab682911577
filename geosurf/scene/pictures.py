"""The pictures of a scene: what each shows, its file, and how it is drawn.

Scenarios choose from them, `Scene.render_pictures` draws them, and the report prints their
captions. An error of one picture costs no other result: it becomes a warning that names the picture
and the reason.
"""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, TypedDict

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.conventions.packages import need_plots
from geosurf.errors import GeometryError, GeosurfError, GeosurfWarning, InputError, OutputError
from geosurf.measure.section import check_line
from geosurf.model.expected import listed, path_of
from geosurf.model.protocols import MeasuredModel
from geosurf.render import render_search
from geosurf.render.backend import views_obstacle
from geosurf.render.colouring import check_colour_by, selection_of
from geosurf.render.compose import plotted
from geosurf.render.diagram import draw_throw
from geosurf.render.overlay import PictureOverlay, overlay_of
from geosurf.render.picture_style import PictureStyle, style_of
from geosurf.render.views import (
    angles_of,
    check_exaggeration,
    check_size,
    check_zoom,
    view_vectors,
    words_of,
)
from geosurf.scene.plots import (
    ScenePlots,
    cut_horizons,
    middle_lines,
    neighbours,
    warn_of_colours,
)
from geosurf.warning import warn

# ---- attempt ----------------------------------------
# One picture at a time: an error of one costs no other result.


class Attempt:
    """Catches the error of one picture, whatever it is, so that all other results stay.

    Only exceptions that mean to end the program pass through.

    Examples
    --------
    >>> with Attempt() as tried:
    ...     1 / 0
    >>> tried.reason
    'ZeroDivisionError: division by zero. This is a fault of geosurf: please report it'
    """

    error: BaseException | None = None

    def __enter__(self) -> Attempt:
        """Begin."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> bool:
        """Keep the error."""
        # an Exception is swallowed and kept for `reason`; KeyboardInterrupt and SystemExit are
        # none, and pass
        self.error = error
        return isinstance(error, Exception)

    @property
    def reason(self) -> str:
        """What went wrong, as a part of a sentence; '' if nothing did."""
        # errors on purpose have a sentence for the user; anything else is a defect of geosurf
        if isinstance(self.error, GeosurfError | Warning):
            return str(self.error).rstrip(".")
        if isinstance(self.error, MemoryError):
            return "there is not enough memory for it"
        if self.error is None:
            return ""
        name = type(self.error).__name__
        return f"{name}: {self.error}. This is a fault of geosurf: please report it"


_LINES = "give a list of lines, each points (n, 2)"
_VIEWS = "give a list, as in views=['southwest']"


@dataclass(frozen=True)
class Picture:
    """One picture, not yet drawn: what it shows, its file, how it is drawn, what leaves it out."""

    caption: str
    file: str
    draw: Callable[[Path], object]
    without: str
    needs_opengl: bool = True


class Style(TypedDict):
    """What all views in three dimensions share."""

    size: tuple[int, int]
    exaggeration: float | None
    style: PictureStyle


class FlatStyle(TypedDict):
    """What all maps and diagrams share."""

    size: tuple[int, int]
    style: PictureStyle


def pictures_of(
    scene: MeasuredModel,
    *,
    views: Sequence[str] = ("southwest",),
    exploded: bool = True,
    maps: bool = True,
    thickness: bool = True,
    allan: bool = True,
    throw: bool = True,
    sections: Sequence[Any] | None = None,
    search: tuple[str, str] | None = None,
    exaggeration: float | None = None,
    size: tuple[int, int] = (1280, 800),
    clip: bool = True,
    camera: tuple[float, float] | None = None,
    zoom: float = 1.0,
    only: Sequence[str] | None = None,
    colour_by: Any = "unit",
    style: PictureStyle | None = None,
    overlay: PictureOverlay | None = None,
) -> list[Picture]:
    """
    Return the pictures of a scene, not yet drawn.

    Parameters
    ----------
    scene : Scene
    views : sequence of str
        Directions from which horizons, faults and curves are seen.
    exploded, maps, thickness, allan, throw : bool
        An exploded view of the units; a map of each horizon; a thickness map of each zone
        between two horizons; an Allan diagram of each fault; the throw of horizons along each.
    sections : sequence of array_like of float, each (n, 2), optional
        A vertical section along each line in the map (easting, northing) [m]. Default: two, from
        west to east and from south to north, through the middle of the box.
    search : (str, str), optional
        Two surfaces, for a picture of the voxel search.
    exaggeration, size, clip, style
        As for `ScenePlots.view`.
    camera, zoom : (float, float) and float, optional
        A further view: azimuth and height of the viewer [degrees], and its scale.
    overlay : PictureOverlay, optional
        Wells, polygons and data points on views, maps and sections.
    only, colour_by
        Units of the exploded view, and what they are coloured by; as for `ScenePlots.units`.

    Returns
    -------
    list of Picture

    Raises
    ------
    InputError
        For an invalid view, size, exaggeration, line, colouring or style.
    """
    # all words and numbers first: a slip in the last option must not cost minutes of drawing
    size, box = check_size(size), scene.box
    check_exaggeration(exaggeration, box)
    views = (views,) if isinstance(views, str) else listed(views, "views are words", _VIEWS)
    for view in views:
        view_vectors(view)

    if camera is not None:
        angles_of(camera)
    look = Style(size=size, exaggeration=exaggeration, style=style_of(style))
    check_zoom(zoom)
    check_colour_by(colour_by)
    selection_of(only)

    warn_of_colours(scene, look["style"])

    # views in three dimensions; then maps and diagrams, which need no graphics driver
    over = overlay_of(overlay)
    found = [_view(scene, view, clip, look, over) for view in views]
    if camera is not None:
        found.append(_camera(scene, camera, zoom, clip, look, over))
    if exploded:
        found.append(
            Picture(
                "Exploded view of the units: zones up and down, blocks sideways.",
                "units_exploded.png",
                lambda path: ScenePlots(scene).units(
                    path=path, only=only, colour_by=colour_by, **look
                ),
                "exploded = false",
            )
        )
    if maps:
        found += [_map(scene, name, look, clip, over) for name in scene.horizon_names]
    if thickness:
        found += [_thickness(scene, pair, look) for pair in neighbours(scene)]
    if allan:
        found += [_allan(scene, name, look) for name in scene.faults_inside]
    if throw:
        cut = {name: cut_horizons(scene, name) for name in scene.faults_inside}
        found += [_throw(scene, name, them, look) for name, them in cut.items() if them]

    # sections that the caller named, else two through the middle
    lines = middle_lines(box)
    if sections is not None:
        lines = [check_line(line) for line in listed(sections, "sections takes lines", _LINES)]
    found += [_section(scene, line, i, look, over) for i, line in enumerate(lines)]
    if search is not None:
        found.append(_search(scene, *search, look))
    return found


def _slug(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9+-]+", "_", name).strip("_")


def _flat(look: Style) -> FlatStyle:
    """What maps and diagrams share."""
    return FlatStyle(size=look["size"], style=look["style"])


def _camera(
    scene: MeasuredModel,
    camera: tuple[float, float],
    zoom: float,
    clip: bool,
    look: Style,
    overlay: PictureOverlay,
) -> Picture:
    return Picture(
        f"Horizons, faults and their intersection lines, seen from {words_of(camera)}.",
        "view_camera.png",
        lambda path: ScenePlots(scene).view(
            camera, path=path, zoom=zoom, clip=clip, overlay=overlay, **look
        ),
        "camera",
    )


def _view(
    scene: MeasuredModel, view: str, clip: bool, style: Style, overlay: PictureOverlay
) -> Picture:
    return Picture(
        f"Horizons, faults and their intersection lines, seen from the {view}.",
        f"view_{view}.png",
        lambda path: ScenePlots(scene).view(view, path=path, clip=clip, overlay=overlay, **style),
        "views = []",
    )


def _map(
    scene: MeasuredModel, name: str, look: Style, clip: bool, overlay: PictureOverlay
) -> Picture:
    # the row keeps files in stratigraphic order and apart where names differ in signs only
    row = scene.horizon_names.index(name)
    return Picture(
        f"{name}: elevation and intersection lines with other surfaces.",
        f"map_{row:02d}_{_slug(name)}.png",
        lambda path: ScenePlots(scene).map(
            name, path=path, clip=clip, overlay=overlay, **_flat(look)
        ),
        "maps = false",
        needs_opengl=False,
    )


def _thickness(scene: MeasuredModel, pair: tuple[str, str], look: Style) -> Picture:
    zone = "/".join(pair)
    row = scene.horizon_names.index(pair[0])
    return Picture(
        f"{zone}: vertical thickness (isochore) by block, with fault polygons of both horizons.",
        f"isochore_{row:02d}_{_slug(zone)}.png",
        lambda path: ScenePlots(scene).thickness(zone, path=path, **_flat(look)),
        "thickness = false",
        needs_opengl=False,
    )


def _allan(scene: MeasuredModel, name: str, look: Style) -> Picture:
    row = scene.fault_names.index(name)
    return Picture(
        f"{name}: Allan diagram. Fill: zone of the footwall. Stripes: zone of the hanging wall "
        "where it differs.",
        f"allan_{row:02d}_{_slug(name)}.png",
        lambda path: ScenePlots(scene).allan(name, path=path, **_flat(look)),
        "allan = false",
        needs_opengl=False,
    )


def _throw(scene: MeasuredModel, name: str, horizons: Sequence[str], look: Style) -> Picture:
    row = scene.fault_names.index(name)
    file = f"throw_{row:02d}_{_slug(name)}.png"

    def draw(path: Path) -> None:
        """Measure and draw it; horizons without a single throw are named."""
        throws, missing = {}, []
        for horizon in horizons:
            try:
                found = scene.throw(horizon, name)
            except GeometryError as error:
                missing.append(f"{horizon!r}: {str(error).partition('. ')[0]}")
                continue
            if np.isfinite(found.throw).any():
                throws[horizon] = found
        plotted(draw_throw, throws, path=path, horizons=scene.horizon_names, **_flat(look))
        if missing:
            _warn(file, f"{file!r} does not show {'; '.join(missing)}.", "throw = false")

    return Picture(
        f"{name}: throw of horizons along strike.",
        file,
        draw,
        "throw = false",
        needs_opengl=False,
    )


def _section(
    scene: MeasuredModel, line: np.ndarray, row: int, look: Style, overlay: PictureOverlay
) -> Picture:
    # ends only: a line with corners would make the caption longer than the picture
    (x0, y0), (x1, y1) = line[0], line[-1]
    return Picture(
        f"Vertical section from E {x0:.0f} N {y0:.0f} to E {x1:.0f} N {y1:.0f}: zones, horizons, "
        "faults and fluid contacts.",
        f"section_{row:02d}.png",
        lambda path: ScenePlots(scene).section(line, path=path, overlay=overlay, **_flat(look)),
        "sections_m = []",
        needs_opengl=False,
    )


def _search(scene: MeasuredModel, first: str, second: str, style: Style) -> Picture:
    def draw(path: Path) -> None:
        """Write the picture, if there is anything to show."""
        found = scene.search(first, second)
        if found is None:
            raise GeometryError("the boxes of its surfaces do not meet.", surfaces=(first, second))
        a, b = scene.surface(first), scene.surface(second)
        render_search(a, b, found, scene.curves, path, **style)

    return Picture(
        f"Search for the intersection of {first} and {second}: few candidate triangles remain.",
        "search.png",
        draw,
        "search",
    )


def render_pictures(
    scene: MeasuredModel,
    folder: str | os.PathLike[str],
    on_file: Callable[[str], object] | None,
    choice: Mapping[str, Any],
) -> dict[str, Path]:
    """Choose and draw pictures; see `Scene.render_pictures`."""
    need_plots()
    # options are the parameters of `pictures_of`: one list, which cannot get out of step
    known = [word for word in inspect.signature(pictures_of).parameters if word != "scene"]
    for key in choice:
        if key not in known:
            raise InputError(
                f"pictures have no option {key!r}; the options are {', '.join(known)}."
                f"{did_you_mean(key, known)}"
            )
    if on_file is not None and not callable(on_file):
        raise InputError(f"on_file is {on_file!r}; give a function of one text, such as print.")
    return draw_pictures(pictures_of(scene, **choice), folder, on_file)


def draw_pictures(
    pictures: Sequence[Picture],
    folder: str | os.PathLike[str],
    on_file: Callable[[str], object] | None = None,
) -> dict[str, Path]:
    """
    Draw pictures into the folder ``pictures`` of a folder; warn of each that cannot be drawn.

    Parameters
    ----------
    pictures : sequence of Picture
    folder : path-like
    on_file : callable, optional
        Is called with the name of each file, when it is there.

    Returns
    -------
    dict of str to pathlib.Path
        Captions and files.

    Raises
    ------
    OutputError
        If the folder cannot be created.
    """
    folder = path_of(folder, "the folder of pictures") / "pictures"
    _create(folder)

    # without a driver one warning stands for all views, and maps are still drawn
    if any(picture.needs_opengl for picture in pictures):
        reason = views_obstacle()
        if reason:
            _warn("3-D views", f"Only maps and diagrams were drawn: {reason}")
            pictures = [picture for picture in pictures if not picture.needs_opengl]
    drawn = {}
    for picture in pictures:
        path = folder / picture.file

        # an error of one picture, even one of geosurf, costs no other
        with Attempt() as tried:
            picture.draw(path)
        if tried.reason:
            effect = f"Picture '{picture.file}' was not drawn: {tried.reason}."
            _warn(picture.file, effect, picture.without)
            continue
        if on_file is not None:
            on_file(f"pictures/{picture.file}")
        drawn[picture.caption] = path
    return drawn


def _warn(subject: str, effect: str, without: str = "") -> None:
    """Warn of a missing picture, with the reason and the option that omits it."""
    remedy = "All other results are complete."
    if without:
        how = f"Set {without}" if "=" in without else f"Leave out {without}"
        table = "[pictures]" if without == "camera" else "[output]"
        remedy += f" {how} in {table} to run without it."
    warn(GeosurfWarning("picture", subject, effect, remedy))


def _create(folder: Path) -> None:
    """Create the folder of pictures, or raise an error before anything is drawn."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"{folder}: pictures cannot be written there ({error.strerror}). "
            "Choose a folder that you may write to."
        ) from error
