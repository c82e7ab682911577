"""The pictures of a scene: what each shows, its file, and how it is drawn.

Scenarios choose from them, `Scene.render_pictures` draws them, and the report prints their
captions. An error of one picture costs no other result: it becomes a warning that names the picture
and the reason.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

from geosurf.conventions.machine import need_plots
from geosurf.conventions.text import check_word
from geosurf.errors import GeometryError, GeosurfError, InputError, warn_of
from geosurf.files import refused_writing
from geosurf.measure.section import check_line
from geosurf.model.expected import listed, path_of
from geosurf.model.protocols import ReportedModel
from geosurf.render.backend import views_obstacle
from geosurf.render.colouring import check_colour_by, selection_of
from geosurf.render.compose import draw_picture, show_search
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
from geosurf.scene.plots import ScenePlots, cut_horizons, middle_lines, neighbours, warn_of_colours

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
_SEEN = "Horizons, faults and their intersection lines, seen from"


@dataclass(frozen=True)
class Picture:
    """One picture, not yet drawn: what it shows, its file, how it is drawn, what leaves it out."""

    caption: str
    file: str
    draw: Callable[..., object]
    without: str
    needs_opengl: bool = False


@dataclass(frozen=True)
class PictureChoice:
    """
    Which pictures of a scene are drawn, and what they look like.

    Attributes
    ----------
    views : sequence of str
        Directions from which horizons, faults and curves are seen.
    exploded, maps, thickness, allan, throw : bool
        An exploded view of the units; a map of each horizon; a thickness map of each zone
        between two horizons; an Allan diagram of each fault; the throw of horizons along each.
    sections : sequence of array_like of float, each (n, 2), optional
        A vertical section along each line in the map (easting, northing) [m]. Default: two, from
        west to east and from south to north, through the middle of the model, as far as it goes.
    search : (str, str), optional
        Two surfaces, for a picture of the voxel search.
    exaggeration, size, clip, style
        As for `ScenePlots.view`.
    camera, zoom : (float, float) and float, optional
        A further view: azimuth and height of the viewer [degrees], and its scale.
    overlay : PictureOverlay, optional
        Wells, polygons and data points on views, maps and sections.
    only, include, colour_by
        Units of the exploded view, and what they are coloured by; as for `ScenePlots.view`.
    """

    views: Sequence[str] = ("southwest",)
    exploded: bool = True
    maps: bool = True
    thickness: bool = True
    allan: bool = True
    throw: bool = True
    sections: Sequence[Any] | None = None
    search: tuple[str, str] | None = None
    exaggeration: float | None = None
    size: tuple[int, int] = (1280, 800)
    clip: bool = True
    camera: tuple[float, float] | None = None
    zoom: float = 1.0
    only: Sequence[str] | None = None
    include: str = "reservoir"
    colour_by: Any = "unit"
    style: PictureStyle | None = None
    overlay: PictureOverlay | None = None

    def check(self, box: Sequence[float]) -> None:
        """Refuse a slip in any word or number: the last one must not cost minutes of drawing."""
        check_size(self.size)
        check_exaggeration(self.exaggeration, tuple(box))
        for view in self.directions:
            view_vectors(view)
        if self.camera is not None:
            angles_of(self.camera)
        check_zoom(self.zoom)
        check_colour_by(self.colour_by)
        selection_of(self.only, self.include)
        overlay_of(self.overlay)
        style_of(self.style)

    @property
    def directions(self) -> Sequence[str]:
        """The views as a list."""
        views = self.views
        return (views,) if isinstance(views, str) else listed(views, "views are words", _VIEWS)


def pictures_of(scene: ReportedModel, choice: PictureChoice) -> list[Picture]:
    """
    Return the pictures of a scene, not yet drawn.

    Parameters
    ----------
    scene : Scene
    choice : PictureChoice

    Raises
    ------
    InputError
        For an invalid view, size, exaggeration, line, colouring or style.
    """
    choice.check(scene.box)
    warn_of_colours(scene, style_of(choice.style))
    plot, horizons, faults = ScenePlots(scene), scene.horizon_names, scene.fault_names
    flat: dict[str, Any] = {"size": choice.size, "style": choice.style}
    look = {**flat, "exaggeration": choice.exaggeration}
    over: dict[str, Any] = {"overlay": choice.overlay}
    clip: dict[str, Any] = {"clip": choice.clip}

    def row(names: Sequence[str], name: str, kind: str, words: str = "") -> str:
        """A file: the row keeps the order of names, and apart those that differ in signs only."""
        slug = re.sub(r"[^A-Za-z0-9+-]+", "_", words or name).strip("_")
        return f"{kind}_{list(names).index(name):02d}_{slug}.png"

    # views in three dimensions; then maps and diagrams, which need no graphics driver
    pictures = [
        Picture(
            f"{_SEEN} the {view}.", f"view_{view}.png",
            partial(plot.view, view, **clip, **over, **look), "views = []", True,
        )
        for view in choice.directions
    ]  # fmt: skip
    if choice.camera is not None:
        words: dict[str, Any] = {"zoom": choice.zoom, **clip, **over, **look}
        draw: Callable[..., object] = partial(plot.view, choice.camera, **words)
        caption = f"{_SEEN} {words_of(choice.camera)}."
        pictures.append(Picture(caption, "view_camera.png", draw, "camera", True))
    if choice.exploded:
        words = {"only": choice.only, "include": choice.include, "colour_by": choice.colour_by}
        draw = partial(plot.view, show=["units"], exploded=0.3, **words, **look)
        caption = "Exploded view of the units: zones up and down, blocks sideways."
        pictures.append(Picture(caption, "units_exploded.png", draw, "exploded = false", True))
    for name in horizons if choice.maps else ():
        caption = f"{name}: elevation and intersection lines with other surfaces."
        draw = partial(plot.map, name, **clip, **over, **flat)
        pictures.append(Picture(caption, row(horizons, name, "map"), draw, "maps = false"))
    for top, base in neighbours(scene) if choice.thickness else ():
        zone = f"{top}/{base}"
        caption = (
            f"{zone}: vertical thickness (isochore) by block, with fault polygons of both horizons."
        )
        file = row(horizons, top, "isochore", zone)
        pictures.append(
            Picture(caption, file, partial(plot.thickness, zone, **flat), "thickness = false")
        )
    inside = scene.faults_inside if choice.allan or choice.throw else ()
    for name in inside if choice.allan else ():
        caption = (
            f"{name}: Allan diagram. Fill: zone of the footwall. Stripes: zone of the hanging wall "
            "where it differs."
        )
        draw = partial(plot.allan, name, **flat)
        pictures.append(Picture(caption, row(faults, name, "allan"), draw, "allan = false"))
    for name in inside if choice.throw else ():
        if cut_horizons(scene, name):
            caption, draw = (
                f"{name}: throw of horizons along strike.",
                partial(plot.throw, name, **flat),
            )
            pictures.append(Picture(caption, row(faults, name, "throw"), draw, "throw = false"))

    # sections that the caller named, else two through the middle
    lines = middle_lines(scene.box, scene.aoi)
    if choice.sections is not None:
        given = listed(choice.sections, "sections takes lines", _LINES)
        lines = [check_line(line) for line in given]
    for k, line in enumerate(lines):
        # ends only: a line with corners would make the caption longer than the picture
        first, last = (f"E {x:.0f} N {y:.0f}" for x, y in (line[0], line[-1]))
        caption = (
            f"Vertical section from {first} to {last}: zones, horizons, faults and fluid contacts."
        )
        draw = partial(plot.section, line, **over, **flat)
        pictures.append(Picture(caption, f"section_{k:02d}.png", draw, "sections_m = []"))
    if choice.search is not None:
        draw = partial(_draw_search, scene, *choice.search, **look)
        names = " and ".join(choice.search)
        caption = f"Search for the intersection of {names}: few candidate triangles remain."
        pictures.append(Picture(caption, "search.png", draw, "search", True))
    return pictures


def _draw_search(scene: ReportedModel, first: str, second: str, path: Path, **look: Any) -> None:
    """Write the picture of a search, if there is anything to show."""
    search = scene.search(first, second)
    if search is None:
        raise GeometryError("the boxes of its surfaces do not meet.", surfaces=(first, second))
    shown = show_search(scene.surface(first), scene.surface(second), search, scene.curves)
    title = "Voxel search for intersection lines"
    draw_picture(shown, path, title=title, view="southwest", **look)


def render_pictures(
    scene: ReportedModel,
    folder: str | os.PathLike[str],
    on_file: Callable[[str], object] | None,
    choice: Mapping[str, Any],
) -> dict[str, Path]:
    """Choose and draw pictures; see `Scene.render_pictures`."""
    need_plots()
    known = [one.name for one in fields(PictureChoice)]
    for key in choice:
        check_word(
            key, known, f"pictures have no option {key!r}; the options are {', '.join(known)}."
        )
    if on_file is not None and not callable(on_file):
        raise InputError(f"on_file is {on_file!r}; give a function of one text, such as print.")
    return draw_pictures(pictures_of(scene, PictureChoice(**choice)), folder, on_file)


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
    remedy = "Choose a folder that you may write to."
    with refused_writing(f"{folder}: pictures", folder, remedy):
        folder.mkdir(parents=True, exist_ok=True)

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
            picture.draw(path=path)
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
    warn_of("picture", subject, effect, remedy)
