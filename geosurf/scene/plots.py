"""The pictures of a scene: `Scene.plot`."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from geosurf.conventions import did_you_mean, is_word
from geosurf.conventions.packages import need_plots
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model import Curves, SheetReport, TriSurface
from geosurf.model.expected import expect, flag_of, listed, number_of
from geosurf.model.protocols import DrawnModel, MeasuredModel
from geosurf.render.allan import draw_allan
from geosurf.render.clip import Prism
from geosurf.render.colouring import check_colour_by, selection_of
from geosurf.render.compose import check_look, draw_picture, figure_path, plotted
from geosurf.render.diagram import column_of, draw_column, draw_throw
from geosurf.render.isochores import draw_thickness
from geosurf.render.layers import Content, show_outline
from geosurf.render.map import MAX_MAP_TRIANGLE, draw_map
from geosurf.render.overlay import PictureOverlay, overlay_of, show_overlay
from geosurf.render.picture_style import COLOUR_BY, PictureStyle, style_of
from geosurf.render.section import draw_section
from geosurf.render.sheet import check_axes
from geosurf.render.surface_layers import (
    as_modelled,
    most_of_each,
    show_curves,
    show_patches,
    show_surfaces,
    show_units,
)
from geosurf.render.views import SIZE, View, check_size
from geosurf.scene.horizon_ends import lines_on
from geosurf.warning import warn

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray
    from matplotlib.axes import Axes


# ---- picture contents ----------------------------------------
# What maps and sections of a scene show: surfaces, lines, well tops, thickness.


CELLS = 200  # of a thickness map, along the longer side of the box


def map_of(
    scene: MeasuredModel, name: str, clip: bool
) -> tuple[TriSurface, Curves, dict[str, Any]]:
    """What a map of a horizon shows: surface, curves, and the other arguments of `draw_map`."""
    west, east, south, north = scene.box[:4]

    # the outline that clips: the area of interest, or the box in the map
    ring = np.array([(west, south), (east, south), (east, north), (west, north)])
    inside = ring if scene.aoi is None else scene.aoi
    surface = scene.surface(name)
    options = {
        "outline": inside if flag_of(clip, "clip") else None,
        "faults": scene.fault_names,
        "tops": tops_of_scene(scene),
        "hatched": surface,
        "remedies": _remedies(scene, name),
        "virtual_walls": lines_on(scene.patches, name) if scene.virtual_walls else {},
    }
    return as_modelled(scene, surface, MAX_MAP_TRIANGLE), scene.curves, options


def _remedies(scene: MeasuredModel, name: str) -> tuple[GeosurfWarning, ...]:
    """What closed the tear of a horizon where its faults alone did not."""
    sheet = scene.sheets.get(name)
    report = None if sheet is None else sheet.report
    return report.remedies if isinstance(report, SheetReport) else ()


def tops_of_scene(scene: MeasuredModel) -> Any:
    """The misfits of the well tops, if the scene has some."""
    return None if scene.tops is None else scene.misfit()


def thickness_of(
    scene: MeasuredModel, zone: str, grid: Any
) -> tuple[xarray.DataArray, dict[str, xarray.Dataset]]:
    """Thickness map of a zone, and the fault polygons of the horizons above and below."""
    if grid is None:
        # CELLS along the longer side, whatever the size of the field: pictures have that many
        # pixels to show
        west, east, south, north = scene.box[:4]
        grid = max(east - west, north - south) / CELLS
    thickness = scene.thickness(zone, grid)
    names = [name for name in zone.split("/") if name in scene.horizon_names]
    return thickness, {name: scene.fault_polygons(name) for name in names}


def neighbours(scene: MeasuredModel) -> list[tuple[str, str]]:
    """Pairs of horizons with a zone between them, youngest first."""
    # only zones that have units: the column or the box may have removed one, and its neighbours
    # then name the zone
    zones = {unit.zone for unit in scene.units.values()}
    names = scene.horizon_names
    pairs = [(a, b) for i, a in enumerate(names) for b in names[i + 1 :]]
    return [(a, b) for a, b in pairs if f"{a}/{b}" in zones]


def cut_horizons(scene: MeasuredModel, fault: str) -> list[str]:
    """Names of the horizons that a fault cuts, youngest first."""
    return [name for name in scene.horizons_inside if scene.cutoffs(name, fault)]


def middle_lines(box: Sequence[float]) -> list[np.ndarray]:
    """Lines through the middle of a box, from west to east and from south to north."""
    west, east, south, north = box[:4]
    x, y = 0.5 * (west + east), 0.5 * (south + north)
    return [np.array([(west, y), (east, y)]), np.array([(x, south), (x, north)])]


def warn_of_colours(scene: MeasuredModel, style: PictureStyle) -> None:
    """Warn of colours for names that the model does not have."""
    if not style.colours:
        return
    known = {*scene.horizon_names, *scene.fault_names}
    for unit in scene.units.values():
        known |= {unit.name, unit.zone, unit.block, unit.contact}
    for name in style.colours:
        if name not in known:
            guess = did_you_mean(name, known)
            effect = f"No surface, zone, block or unit is called {name!r}: its colour is not used."
            warn(GeosurfWarning("picture", "colours", effect, f"Correct the name.{guess}"))


# what a scene can show, and the roles of surfaces that each word stands for
ROLES_SHOWN = {"horizons": "horizon", "faults": "fault", "walls": "wall", "surfaces": "surface"}
SHOWABLE = (*ROLES_SHOWN, "curves", "patches", "units")
BUILT = {"walls", "surfaces", "patches", "units"}  # what has names that only a model knows
_SHOW = f"give a list of any of {', '.join(SHOWABLE)}"


class Look(TypedDict):
    """What all maps and diagrams share, checked."""

    ax: Axes | None
    path: str | os.PathLike[str] | None
    size: tuple[int, int]
    title: str | None
    style: PictureStyle


def look_of(ax: Any, path: Any, size: Any, title: Any, style: Any) -> Look:
    """Return what all maps and diagrams share, or raise an error before anything is computed."""
    need_plots()
    if ax is not None:
        check_axes(ax)
    if path is not None:
        figure_path(path)
    if title is not None:
        expect(title, str, "title must be text", "leave it out for the default title")
    return Look(ax=ax, path=path, size=check_size(size), title=title, style=style_of(style))


class ScenePlots:
    """The pictures of a scene: figures of matplotlib, which notebooks show, or files.

    Each computes only what it shows. Maps and diagrams can be drawn into axes.

    Parameters
    ----------
    scene : Scene
        Or any object with the members of a scene that a picture asks for.
    """

    def __init__(self, scene: Any) -> None:
        self._scene = scene

    def map(
        self,
        horizon: str,
        *,
        ax: Axes | None = None,
        path: str | os.PathLike[str] | None = None,
        clip: bool = True,
        size: tuple[int, int] = SIZE,
        title: str | None = None,
        overlay: PictureOverlay | None = None,
        style: PictureStyle | None = None,
    ) -> Any:
        """Draw the map of a horizon.

        Parameters
        ----------
        horizon : str
        ax : matplotlib.axes.Axes, optional
            Where to draw, in world coordinates [m]. Default: a new figure.
        path : path-like, optional
            A ``.png``, ``.svg`` or ``.pdf`` file to write.
        clip : bool
            Whether the map ends at the model.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        overlay : PictureOverlay, optional
            Wells, polygons and data points that are drawn with the model.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
            The path of the file, if there is one.

        Raises
        ------
        InputError
            For an unknown horizon, or axes that are not axes.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.graben(n=9)
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> figure = scene.plot.map("Top", size=(640, 400))
        >>> figure.axes[1].get_xlabel()
        'Easting [km]'
        """
        overlay = overlay_of(overlay)
        look = look_of(ax, path, size, title, style)
        surface, curves, options = map_of(self._scene, horizon, clip)
        return plotted(draw_map, surface, curves, overlay=overlay, **options, **look)

    def thickness(
        self,
        zone: str,
        *,
        ax: Axes | None = None,
        path: str | os.PathLike[str] | None = None,
        grid: Any = None,
        size: tuple[int, int] = SIZE,
        title: str | None = None,
        style: PictureStyle | None = None,
    ) -> Any:
        """Draw the thickness map of a zone, with the fault polygons of its horizons.

        Parameters
        ----------
        zone : str
        ax : matplotlib.axes.Axes, optional
            Where to draw, in world coordinates [m]. Default: a new figure.
        path : path-like, optional
            A ``.png``, ``.svg`` or ``.pdf`` file to write.
        grid : None, float or xarray object
            As for `Scene.thickness`. Default: 200 cells along the longer side of the box.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
            The path of the file, if there is one.

        Raises
        ------
        InputError
            For an unknown zone, or axes that are not axes.
        """
        look = look_of(ax, path, size, title, style)
        thickness, polygons = thickness_of(self._scene, zone, grid)
        return plotted(draw_thickness, thickness, polygons=polygons, **look)

    def section(
        self,
        line: Any,
        *,
        ax: Axes | None = None,
        path: str | os.PathLike[str] | None = None,
        size: tuple[int, int] = SIZE,
        title: str | None = None,
        overlay: PictureOverlay | None = None,
        style: PictureStyle | None = None,
    ) -> Any:
        """Draw a vertical section along a line in the map.

        Parameters
        ----------
        line : array_like of float, shape (n, 2)
            As for `Scene.section` [m].
        ax : matplotlib.axes.Axes, optional
            Where to draw: distance along the section and elevation [m]. Default: a new figure.
        path : path-like, optional
            A ``.png``, ``.svg`` or ``.pdf`` file to write.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        overlay : PictureOverlay, optional
            Wells, polygons and data points that are drawn with the model.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
            The path of the file, if there is one.

        Raises
        ------
        InputError
            For a line of fewer than two points, or axes that are not axes.
        """
        overlay = overlay_of(overlay)
        look = look_of(ax, path, size, title, style)
        section, tops = self._scene.section(line), tops_of_scene(self._scene)
        return plotted(draw_section, section, tops=tops, overlay=overlay, **look)

    def allan(
        self,
        fault: str,
        *,
        ax: Axes | None = None,
        path: str | os.PathLike[str] | None = None,
        size: tuple[int, int] = SIZE,
        title: str | None = None,
        style: PictureStyle | None = None,
    ) -> Any:
        """Draw the Allan diagram of a fault, with the area of each pair of juxtaposed zones.

        Parameters
        ----------
        fault : str
        ax : matplotlib.axes.Axes, optional
            Where to draw: distance along strike and elevation [m]. Default: a new figure.
        path : path-like, optional
            A ``.png``, ``.svg`` or ``.pdf`` file to write.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
            The path of the file, if there is one.

        Raises
        ------
        InputError
            For an unknown fault, one with units on one side only, or axes that are not axes.
        """
        look, scene = look_of(ax, path, size, title, style), self._scene
        zones = list(dict.fromkeys(unit.zone for unit in scene.units.values()))
        diagram, table = scene.allan(fault), scene.juxtaposition(fault)
        return plotted(draw_allan, diagram, table, zones=zones, **look)

    def throw(
        self,
        fault: str,
        *,
        ax: Axes | None = None,
        path: str | os.PathLike[str] | None = None,
        size: tuple[int, int] = SIZE,
        title: str | None = None,
        style: PictureStyle | None = None,
    ) -> Any:
        """Draw the throw of all horizons along a fault.

        Parameters
        ----------
        fault : str
        ax : matplotlib.axes.Axes, optional
            Where to draw: distance along strike and throw [m]. Default: a new figure.
        path : path-like, optional
            A ``.png``, ``.svg`` or ``.pdf`` file to write.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
            The path of the file, if there is one.

        Raises
        ------
        InputError
            For an unknown fault, one that no horizon meets, or axes that are not axes.
        """
        look, scene = look_of(ax, path, size, title, style), self._scene
        names = scene.horizon_names
        throws = {name: scene.throw(name, fault) for name in names if scene.cutoffs(name, fault)}
        throws = {name: found for name, found in throws.items() if np.isfinite(found.throw).any()}
        return plotted(draw_throw, throws, horizons=names, **look)

    def column(
        self,
        *,
        ax: Axes | None = None,
        path: str | os.PathLike[str] | None = None,
        size: tuple[int, int] = (700, 800),
        title: str | None = None,
        style: PictureStyle | None = None,
    ) -> Any:
        """Draw the stratigraphic column: zones with their mean thickness, horizons and their rules.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw. Default: a new figure.
        path : path-like, optional
            A ``.png``, ``.svg`` or ``.pdf`` file to write.
        size : (int, int)
            Of a new figure [pixels].
        title : str, optional
            Default: what is drawn.
        style : PictureStyle, optional
            Theme, font, colours by name, colour map. The theme is for a new figure.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
            The path of the file, if there is one.

        Raises
        ------
        InputError
            For axes that are not axes.
        """
        look, scene = look_of(ax, path, size, title, style), self._scene
        # a fluid contact does not divide the thickness of its zone
        units = [(unit.zone, unit.volume, unit.zone_map_area) for unit in scene.units.values()]
        zones = column_of(units, list(dict.fromkeys(zone for zone, _, _ in units)))
        return plotted(draw_column, zones, dict(scene.column), **look)

    def view(
        self,
        view: View = "southwest",
        *,
        path: str | os.PathLike[str] | None = None,
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
    ) -> Any:
        """Draw horizons, faults, curves or units in three dimensions.

        Parameters
        ----------
        view : str or (float, float)
            Position of the viewer: ``"southwest"``, ``"southeast"``, ``"northwest"``,
            ``"northeast"``, ``"south"``, ``"north"``, ``"east"``, ``"west"`` or ``"top"``; or its
            azimuth, clockwise from north, and its height above the horizontal [degrees], as in
            ``(225, 30)``. The projection is parallel, so the scale bar is valid everywhere.
        path : path-like, optional
            A ``.png`` file to write.
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
            Names of the surfaces and units that are drawn; units also by zone or block. Default:
            all.
        colour_by : str, mapping of str to float, or array_like of float, optional
            Colours of units: ``"unit"``, ``"zone"``, ``"block"``, ``"contact"``, or numbers, one
            per unit or by name, with a colour bar. ``"z"`` colours units and horizons by elevation.
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
        matplotlib.figure.Figure or pathlib.Path
            The path of the file, if there is one.

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
        >>> import geosurf as gs
        >>> world = gs.synthetic.tilted_planes()
        >>> scene = gs.Scene(world.horizons, world.faults, world.box)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     scene.plot.view(path=f"{folder}/view.png", show=["faults"], size=(400, 250)).name
        'view.png'
        """
        check_look(view, size, zoom, title, path)
        style, overlay = style_of(style), overlay_of(overlay)
        selection = selection_of(only)
        clip = flag_of(clip, "clip")
        exploded = number_of(
            exploded, "exploded", "give a fraction of the size of the box, 0 or above"
        )
        show = (
            (show,)
            if isinstance(show, str)
            else listed(show, "show must be a list of words", _SHOW)
        )
        for word in show:
            if not is_word(word, SHOWABLE):
                raise InputError(
                    f"unknown word in show: {word!r}. Use any of {', '.join(SHOWABLE)}."
                    f"{did_you_mean(word, SHOWABLE)}"
                )
        by = "unit" if colour_by is None else colour_by
        _check_colour_by(by, show)
        if selection.names is not None and not BUILT & set(show):
            selection.check(_names_of(self._scene, show))
        _check_scene(self._scene, show)

        # only what is shown is asked of the scene, so that nothing else is computed
        roles = {ROLES_SHOWN[word] for word in show if word in ROLES_SHOWN}
        if selection.names is not None and BUILT & set(show):
            selection.check(_names_of(self._scene, show))
        content, box = Content(), self._scene.box
        outline = self._scene.aoi if clip else None
        within = Prism(box, outline) if clip else None
        if roles:
            # torn horizons end on their faults: what lies beyond is not part of the model
            some = [s for s in self._scene.surfaces if s.role in roles]
            most = most_of_each(len(some), size, zoom)
            shown = (as_modelled(self._scene, s, most) for s in some)
            by_elevation = isinstance(by, str) and by == "z"
            content += show_surfaces(
                shown, within, only=selection, by_elevation=by_elevation, style=style, size=size,
                zoom=zoom,
            )  # fmt: skip
        if "patches" in show:
            content += show_patches(self._scene.patches, within, only=selection, style=style)
        if "units" in show:
            content += show_units(
                self._scene.units, exploded, only=selection, colour_by=by, style=style
            )
        if "curves" in show:
            content += show_curves(self._scene.curves, within=within)

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

    def units(
        self,
        *,
        path: str | os.PathLike[str] | None = None,
        explode: float = 0.3,
        view: View = "southwest",
        size: tuple[int, int] = SIZE,
        exaggeration: float | None = None,
        zoom: float = 1.0,
        only: Sequence[str] | None = None,
        colour_by: Any = "unit",
        title: str | None = None,
        style: PictureStyle | None = None,
    ) -> Any:
        """Draw the units in an exploded view: zones up and down, blocks sideways.

        Each zone has a colour, each block a shade of it; the legend lists the volumes.

        Parameters
        ----------
        path : path-like, optional
            A ``.png`` file to write.
        explode : float
            Gap between units, as a fraction of the size of the model box; 0 for no gap.
        view, size, exaggeration, zoom, only, colour_by, style
            As in `view`.
        title : str, optional
            Default: what units are coloured by.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
            The path of the file, if there is one.

        Raises
        ------
        InputError, OutputError, DependencyError
            As `view`.
        """
        check_look(view, size, zoom, title, path)
        style, selection = style_of(style), selection_of(only)
        explode = number_of(
            explode, "explode", "give a fraction of the size of the box, 0 or above"
        )
        by, words = check_colour_by(colour_by)
        units = self._scene.units
        selection.check(
            n for unit in units.values() for n in (unit.name, unit.zone, unit.block) if n
        )
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
                f"a view shows a Scene; {type(scene).__name__} has no attribute {wanted!r}. "
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
