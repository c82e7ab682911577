"""The pictures of a scene: `Scene.plot`."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import numpy as np

from geosurf.conventions import check_word, did_you_mean
from geosurf.conventions.axes import COORDINATES, vertical_axis
from geosurf.conventions.machine import need_plots
from geosurf.errors import GeometryError, GeosurfWarning, InputError, warn_of
from geosurf.faults.distance import in_ring
from geosurf.lazy import xarray
from geosurf.measure.columns import residuals
from geosurf.measure.faces import MINUS, faces_of
from geosurf.measure.section import chains_of, rings_of
from geosurf.measure.volumetrics import fluid_of, fluids_rule
from geosurf.model import Curves, Sheet, SheetReport, TriSurface
from geosurf.model.expected import expect, flag_of, listed, number_of, outline_of
from geosurf.model.protocols import ReportedModel
from geosurf.render.allan import draw_allan
from geosurf.render.clip import Prism
from geosurf.render.colouring import check_colour_by, colour_units, selection_of
from geosurf.render.compose import check_look, draw_picture, figure_path, plotted
from geosurf.render.diagram import column_of, draw_column, draw_throw
from geosurf.render.isochores import draw_thickness
from geosurf.render.layers import Content, show_outline
from geosurf.render.map import MAX_MAP_TRIANGLE, FluidArea, MapMeasures, check_closures, draw_map
from geosurf.render.overlay import PictureOverlay, overlay_of, show_overlay
from geosurf.render.picture_style import PictureStyle, style_of
from geosurf.render.section import draw_section
from geosurf.render.sheet import check_axes
from geosurf.render.surface_layers import (
    as_modelled,
    most_of_each,
    show_curves,
    show_patches,
    show_seals,
    show_surfaces,
    show_units,
)
from geosurf.render.views import SIZE, View, check_size
from geosurf.scene.horizon_ends import lines_on
from geosurf.scene.inputs import Box, undeclared
from geosurf.scene.shown import data_of
from geosurf.scene.surfaces import opened_horizon

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes


# ---- picture contents ----------------------------------------
# What maps and sections of a scene show: surfaces, lines, well tops, thickness.


CELLS = 200  # of a thickness map, along the longer side of the box


def map_of(
    scene: ReportedModel, name: str, clip: bool
) -> tuple[TriSurface, Curves, dict[str, Any]]:
    """What a map of a horizon shows: surface, curves, and the other arguments of `draw_map`."""
    inside = outline_of(scene.box, scene.aoi)
    surface = scene.surface(name)
    options = {
        "outline": inside if flag_of(clip, "clip") else None,
        "faults": scene.fault_names,
        "tops": tops_of_scene(scene),
        "hatched": surface,
        "remedies": _remedies(scene, name, inside if clip else None),
        "virtual_walls": lines_on(scene.patches, name) if scene.virtual_walls else {},
        "measures": MapMeasures(
            fluids_on(scene, name) if scene.contacts else (), 2 if name in scene.sheets else 1
        ),
    }
    return as_modelled(scene, surface, MAX_MAP_TRIANGLE), scene.curves, options


def fluids_on(scene: ReportedModel, name: str) -> list[FluidArea]:
    """Parts of a horizon above fluid contacts, by the contact interval of the unit below them."""
    if name not in scene.horizons_inside:
        return []
    faces = faces_of(scene.patches, scene.units, name, "horizon")
    inside, below = scene.units.included(), faces.sides[:, MINUS]
    contact_of_unit = [unit.contact if unit.name in inside else "" for unit in faces.listed]
    interval = np.array([*contact_of_unit, ""], dtype=object)[below]  # -1: none
    rule, x = fluids_rule(None), (faces.x + faces.origin)[:, :2]
    areas = []
    for words in dict.fromkeys(contact_of_unit):
        rows = interval == words
        if not words or words.startswith("below ") or not rows.any():
            continue
        above, others = faces.triangles[rows], faces.triangles[~rows & (interval != "")]
        unit = next(unit for unit in faces.listed if unit.contact == words)
        rings = [x[ring] for ring in rings_of(above, faces.x)]
        lines = [x[line] for line in chains_of(_shared_edges(above, others), faces.x)]
        areas.append(FluidArea(words, fluid_of(unit, set(), rule), rings, lines))
    return areas


def _shared_edges(triangles: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Edges (n, 2) between two sets of triangles that face the same way."""
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    first, last = other.ravel(), other[:, [1, 2, 0]].ravel()
    n = int(max(triangles.max(initial=0), other.max(initial=0))) + 1
    return np.column_stack([start, end])[np.isin(start * n + end, last * n + first)]


def _remedies(
    scene: ReportedModel, name: str, outline: np.ndarray | None
) -> tuple[GeosurfWarning, ...]:
    """What closed the tear of a horizon where its faults alone did not, inside an outline."""
    sheet = scene.sheets.get(name)
    report = None if sheet is None else sheet.report
    remedies = report.remedies if isinstance(report, SheetReport) else ()
    if outline is None:
        return remedies
    return tuple(one for one in remedies if one.place and in_ring(np.array(one.place), outline))


def tops_of_scene(scene: ReportedModel) -> Any:
    """The misfits of the well tops, if the scene has some."""
    return None if scene.tops is None else scene.misfit()


def thickness_of(
    scene: ReportedModel, zone: str, grid: Any, contact: str | None
) -> tuple[xarray.DataArray, dict[str, xarray.Dataset]]:
    """Thickness map of a zone, and the fault polygons of the horizons above and below."""
    if grid is None:
        # CELLS along the longer side, whatever the size of the field: pictures have that many
        # pixels to show
        west, east, south, north = scene.box[:4]
        grid = max(east - west, north - south) / CELLS
    thickness = scene.thickness(zone, grid, contact=contact)
    of_block = {unit.block: unit.region for unit in scene.units.values() if unit.zone == zone}
    thickness = _by_region(thickness, of_block)
    names = [name for name in zone.split("/") if name in scene.horizon_names]
    return thickness, {name: scene.fault_polygons(name) for name in names}


def _by_region(thickness: xarray.DataArray, of_block: Mapping[str, str]) -> xarray.DataArray:
    """Thickness by region instead of block; as it is where a block has none."""
    names = [of_block.get(str(block), "") for block in thickness.block.values]
    if not all(names):
        return thickness
    regions = list(dict.fromkeys(names))
    parts = [thickness.values[[name == region for name in names]] for region in regions]
    values = [np.where(np.isfinite(p).any(axis=0), np.nansum(p, axis=0), np.nan) for p in parts]
    slivers = thickness.sliver.values if "sliver" in thickness.coords else np.zeros(len(names))
    small = [
        all(s for s, name in zip(slivers, names, strict=True) if name == region)
        for region in regions
    ]
    coords = {key: one for key, one in thickness.coords.items() if "block" not in one.dims}
    coords |= {"block": ("block", regions), "sliver": ("block", small)}
    attrs = {**thickness.attrs, "by": "region"}
    return xarray.DataArray(np.stack(values), coords, thickness.dims, attrs=attrs)


def neighbours(scene: ReportedModel) -> list[tuple[str, str]]:
    """Pairs of horizons with a zone of the reservoir between them, youngest first."""
    # only zones that have units: the column or the box may have removed one, and its neighbours
    # then name the zone
    zones = {unit.zone for unit in scene.units.included().values()}
    names = scene.horizon_names
    pairs = [(a, b) for i, a in enumerate(names) for b in names[i + 1 :]]
    return [(a, b) for a, b in pairs if f"{a}/{b}" in zones]


def cut_horizons(scene: ReportedModel, fault: str) -> list[str]:
    """Names of the horizons that a fault cuts, youngest first."""
    return [name for name in scene.horizons_inside if scene.cutoffs(name, fault)]


def middle_lines(box: Sequence[float], aoi: np.ndarray | None) -> list[np.ndarray]:
    """Lines through the middle of a model, from west to east and from south to north."""
    west, east, south, north = box[:4]
    middle = np.array([0.5 * (west + east), 0.5 * (south + north)])
    a = outline_of(box, aoi)
    b, lines = np.roll(a, -1, axis=0), []
    for k in (0, 1):
        # they start and end where they leave the area for good
        low, high = a[:, 1 - k] - middle[1 - k], b[:, 1 - k] - middle[1 - k]
        cut = (low < 0) != (high < 0)
        share = low[cut] / (low[cut] - high[cut])
        along = a[cut, k] + share * (b[cut, k] - a[cut, k])
        line = np.stack([middle, middle])
        line[:, k] = along.min(), along.max()
        lines.append(line)
    return lines


def warn_of_colours(scene: ReportedModel, style: PictureStyle) -> None:
    """Warn of colours for names that the model does not have."""
    if not style.colours:
        return
    known = {*scene.horizon_names, *scene.fault_names}
    for unit in scene.units.values():
        known |= {unit.name, unit.zone, unit.block, unit.region, unit.contact}
    for name in style.colours:
        if name not in known:
            guess = did_you_mean(name, known)
            effect = f"Nothing in the model is called {name!r}: its colour is not used."
            warn_of("picture", "colours", effect, f"Correct the name.{guess}")


# what a scene can show, and the roles of surfaces that each word stands for
ROLES_SHOWN = {"horizons": "horizon", "faults": "fault", "walls": "wall", "surfaces": "surface"}
SHOWABLE = (*ROLES_SHOWN, "curves", "patches", "units")
_GAP = "give a fraction of the size of the box, 0 or above"
FACING = "Legend of faults: mean where reservoir faces reservoir."
_SEAL = "pass scene.seal('F1', vshale=...), or a list of these"
_SHOW = f"give a list of any of {', '.join(SHOWABLE)}"


class FlatLook(TypedDict, total=False):
    """What all maps and diagrams take.

    Attributes
    ----------
    ax : matplotlib.axes.Axes
        Where to draw, in metres. Default: a new figure.
    path : path-like
        A ``.png``, ``.svg`` or ``.pdf`` file to write.
    size : (int, int)
        Of a new figure [pixels].
    title : str
        Default: what is drawn.
    style : PictureStyle
        Theme, font, colours by name, colour map. The theme is for a new figure.
    """

    ax: Axes | None
    path: str | os.PathLike[str] | None
    size: tuple[int, int]
    title: str | None
    style: PictureStyle | None


class ViewLook(TypedDict, total=False):
    """What views in three dimensions take.

    Attributes
    ----------
    path : path-like
        A ``.png`` file to write.
    size : (int, int)
        Width and height in pixels.
    exaggeration : float
        Vertical exaggeration. Default: a round number that suits the shape of the model. It is
        printed below the picture.
    zoom : float
        2 shows the middle of the model at twice the scale.
    only : sequence of str
        Names of the surfaces and units that are drawn; units also by zone, region
        or block. Default: all surfaces, and the units of the reservoir.
    include : {"reservoir", "all"}
        ``"all"``: also the units of over- and underburden.
    colour_by : str, mapping of str to float, or array_like of float
        Colours of units: ``"unit"``, ``"zone"``, ``"region"``, ``"block"``, ``"contact"``, or
        numbers, one per unit or by name, with a colour bar. ``"z"`` colours units and horizons by
        elevation.
    title : str
        Default: what is shown.
    style : PictureStyle
        Theme, font, colours by name, colour map.
    """

    path: str | os.PathLike[str] | None
    size: tuple[int, int]
    exaggeration: float | None
    zoom: float
    only: Sequence[str] | None
    include: str
    colour_by: Any
    title: str | None
    style: PictureStyle | None


def _flat(
    ax: Any = None, path: Any = None, size: Any = SIZE, title: Any = None, style: Any = None
) -> dict[str, Any]:
    """Return the look of a map or diagram, or raise an error before anything is computed."""
    need_plots()
    if ax is not None:
        check_axes(ax)
    if path is not None:
        figure_path(path)
    if title is not None:
        expect(title, str, "title must be text", "leave it out for the default title")
    return {"ax": ax, "path": path, "size": check_size(size), "title": title,
            "style": style_of(style)}  # fmt: skip


@dataclass(frozen=True)
class _View:
    """The look of a view, checked before anything is computed."""

    view: View
    path: Any = None
    size: tuple[int, int] = SIZE
    exaggeration: float | None = None
    zoom: float = 1.0
    only: Any = None
    include: str = "reservoir"
    colour_by: Any = None
    title: str | None = None
    style: Any = None

    def __post_init__(self) -> None:
        check_look(self.view, self.size, self.zoom, self.title, self.path)
        only = selection_of(self.only, self.include)
        self.__dict__.update(style=style_of(self.style), only=only)

    @property
    def by(self) -> Any:
        """What units are coloured by."""
        return "unit" if self.colour_by is None else self.colour_by

    def draw(self, content: Content, title: str, gap: float, box: Box, note: str = "") -> Any:
        """Draw content; an exploded model has no common outline or axes any more."""
        whole = gap == 0.0
        return draw_picture(
            content, self.path, title=title if self.title is None else self.title, note=note,
            view=self.view, size=self.size, exaggeration=self.exaggeration, zoom=self.zoom,
            style=self.style, box=box if whole else None, axes=whole, relief_of=box,
        )  # fmt: skip


def _with_axis(cls: type) -> type:
    """Let every picture of a class show elevation, depth or time, as its style or scene has it."""

    def drawn(method: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(method)
        def run(self: ScenePlots, *args: Any, **words: Any) -> Any:
            style = words.get("style")
            wanted = style.vertical if isinstance(style, PictureStyle) else None
            given = "depth" if self._scene._inputs.positive == "down" else "elevation"
            with vertical_axis(self._scene.time or wanted or given):
                return method(self, *args, **words)

        return run

    for name, method in list(vars(cls).items()):
        if not name.startswith("_"):
            setattr(cls, name, drawn(method))
    return cls


@_with_axis
class ScenePlots:
    """The pictures of a scene: figures of matplotlib, which notebooks show, or files.

    Each computes only what it shows, and returns the figure, or the path of the file if there is
    one. Maps and diagrams can be drawn into axes. `FlatLook` and `ViewLook` list what they take.

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
        clip: bool = True,
        closures: Any = False,
        regions: bool = False,
        overlay: PictureOverlay | None = None,
        **look: Unpack[FlatLook],
    ) -> Any:
        """Draw the map of a horizon.

        Parameters
        ----------
        horizon : str
        clip : bool
            Whether the map ends at the model.
        closures : bool or result of `Scene.closures`
            Whether closures are drawn, with crests, spill points and leaks; True: with faults that
            all hold.
        regions : bool
            Whether the names of regions are written on the map.
        overlay : PictureOverlay, optional
            Wells, polygons and data points that are drawn with the model.
        **look
            ``ax``, ``path``, ``size``, ``title``, ``style``: see `FlatLook`.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path

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
        overlay, checked = overlay_of(overlay), _flat(**look)
        surface, curves, options = map_of(self._scene, horizon, clip)
        if closures is not False:
            found = self._scene.closures(horizon) if closures is True else closures
            options["measures"] = replace(options["measures"], closures=found)
        if flag_of(regions, "regions"):
            labels = {**self._scene.region_labels(horizon), **overlay.labels}
            overlay = replace(overlay, labels=labels)
        return plotted(draw_map, surface, curves, overlay=overlay, **options, **checked)

    def thickness(
        self, zone: str, grid: Any = None, *, contact: str | None = None, **look: Unpack[FlatLook]
    ) -> Any:
        """Draw the thickness map of a zone, with the fault polygons of its horizons.

        Parameters
        ----------
        zone : str
        grid : None, float or xarray object
            As for `Scene.thickness`. Default: 200 cells along the longer side of the box.
        contact : str, optional
            One interval between fluid contacts, ``"above OWC"``; default: all together.
        **look
            ``ax``, ``path``, ``size``, ``title``, ``style``: see `FlatLook`.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path

        Raises
        ------
        InputError
            For an unknown zone or contact interval, or axes that are not axes.
        """
        checked = _flat(**look)
        thickness, polygons = thickness_of(self._scene, zone, grid, contact)
        outline = outline_of(self._scene.box, self._scene.aoi)
        return plotted(draw_thickness, thickness, polygons=polygons, outline=outline, **checked)

    def section(
        self, line: Any, *, overlay: PictureOverlay | None = None, **look: Unpack[FlatLook]
    ) -> Any:
        """Draw a vertical section along a line in the map.

        Parameters
        ----------
        line : array_like of float, shape (n, 2)
            As for `Scene.section` [m].
        overlay : PictureOverlay, optional
            Wells, polygons and data points that are drawn with the model.
        **look
            ``ax``, ``path``, ``size``, ``title``, ``style``: see `FlatLook`.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path

        Raises
        ------
        InputError
            For a line of fewer than two points, or axes that are not axes.
        """
        overlay, checked = overlay_of(overlay), _flat(**look)
        section, tops = self._scene.section(line), tops_of_scene(self._scene)
        units = self._scene.units
        rank = {name: k for k, name in enumerate(units.regions)}
        shown = sorted(units.values(), key=lambda unit: rank.get(unit.region, -1))
        colours = colour_units(units, shown, "unit", checked["style"]).colours
        words = {name: (units.labels[name], colour) for name, colour in colours.items()}
        return plotted(draw_section, section, units=words, tops=tops, overlay=overlay, **checked)

    def allan(
        self, fault: str, *, closures: Any = False, seal: Any = None, **look: Unpack[FlatLook]
    ) -> Any:
        """Draw the Allan diagram of a fault, with the area of each pair of juxtaposed zones.

        Parameters
        ----------
        fault : str
        closures : bool or result of `Scene.closures`
            Whether leak points of closures are drawn; True: those by juxtaposition.
        seal : result of `Scene.seal`, optional
            The fill is the shale gouge ratio in place of the zones.
        **look
            ``ax``, ``path``, ``size``, ``title``, ``style``: see `FlatLook`.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path

        Raises
        ------
        InputError
            For an unknown fault, one with units on one side only, or axes that are not axes.
        """
        checked, scene = _flat(**look), self._scene
        zones = list(dict.fromkeys(unit.zone for unit in scene.units.values()))
        words = {"zones": zones, "reservoir": scene.units.reservoir}
        diagram, table = scene.allan(fault), scene.juxtaposition(fault, "all")
        leaks = []
        if closures is not False:
            found = scene.closures(faults="juxtaposition") if closures is True else closures
            leaks = _leaks_on(scene, fault, found)
        return plotted(draw_allan, diagram, table, **words, leaks=leaks, seal=seal, **checked)

    def throw(self, fault: str, **look: Unpack[FlatLook]) -> Any:
        """Draw the throw of all horizons along a fault, and what the data beside it show.

        Of torn horizons, dotted lines with a band are what the data on both sides show. The legend
        names horizons without a line, and why; where throw cannot be measured, a `GeosurfWarning`
        states the place.

        Parameters
        ----------
        fault : str
        **look
            ``ax``, ``path``, ``size``, ``title``, ``style``: see `FlatLook`.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path

        Raises
        ------
        InputError
            For an unknown fault, one that no horizon meets, or axes that are not axes.
        """
        checked, scene = _flat(**look), self._scene
        names, throws, missing, absent = scene.horizon_names, {}, [], {}
        for name in names:
            if not scene.cutoffs(name, fault):
                absent[name] = "not cut by this fault"
                continue
            try:
                profile = scene.throw(name, fault)
            except GeometryError as error:
                missing.append(f"{name!r}: {str(error).partition('. ')[0]}")
                absent[name] = "not measured, see warnings"
                continue
            if np.isfinite(profile.throw).any():
                throws[name] = profile
            else:
                absent[name] = "cut-offs of one wall only"
        if missing:
            effect = f"The picture of the throw of {fault!r} does not show {'; '.join(missing)}."
            remedy = "All other results are complete. Set throw = false in [output] to run without."
            warn_of("picture", fault, effect, remedy)
        shown = {
            name: _shown_along(scene, name, fault, profile) for name, profile in throws.items()
        }
        words = {"horizons": names, "shown": shown, "absent": absent}
        return plotted(draw_throw, throws, **words, **checked)

    def picks(
        self, fault: str, horizon: str | None = None, *, at: float = 0.5, data: Any = None,
        **look: Unpack[FlatLook],
    ) -> Any:  # fmt: skip
        """Draw a section across a fault, with the data beside it: in use, and ignored.

        Parameters
        ----------
        fault : str
        horizon : str, optional
            Whose data are drawn. Default: the youngest one that is torn there.
        at : float
            Where along the fault, from 0 at its start to 1 at its end.
        data : horizon data, optional
            What the horizon was torn from. Default: what the scene was given.
        **look
            ``ax``, ``path``, ``size``, ``title``, ``style``: see `FlatLook`.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path

        Raises
        ------
        InputError
            If the horizon is not torn at the fault, or its data are not known.
        """
        checked, scene = _flat(**look), self._scene
        torn = [name for name, sheet in scene.sheets.items() if len(_stations(sheet, fault)) > 1]
        horizon = next(iter(torn), "") if horizon is None else horizon
        if horizon not in torn:
            words = f"horizon {horizon!r} is not" if horizon else "no horizon is"
            raise InputError(
                f"{words} torn at fault {fault!r}. Torn there: {', '.join(torn) or 'none'}."
            )
        if not 0.0 <= number_of(at, "at", "give a share of the fault, from 0 to 1") <= 1.0:
            raise InputError(f"at is {at!r}. Give a share of the fault, from 0 to 1.")
        sheet = scene.sheets[horizon]
        points = _data_of(scene, horizon, data)

        # across strike, four times as far on both sides as data are ignored
        stations = _stations(sheet, fault)
        row = round(at * (len(stations) - 1))
        before, after = stations[max(row - 2, 0)], stations[min(row + 2, len(stations) - 1)]
        east, north = (after - before) / np.hypot(*(after - before))
        reach = 4.0 * max(sheet.report.trims[fault], 3.0) * sheet.report.cell
        ends = stations[row] + reach * np.array([[-1.0], [1.0]]) * np.array([north, -east])
        line = ends[np.lexsort((ends[:, 1], ends[:, 0]))]
        if checked["title"] is None:
            checked["title"] = f"{fault}, {at:.0%} along: data of {horizon}, and its sheet"
        return self.section(line, overlay=PictureOverlay(points=points), **checked)

    def residuals(self, horizon: str, *, data: Any = None, **look: Unpack[FlatLook]) -> Any:
        """Draw how far data lie above or below a torn horizon, on its map.

        Parameters
        ----------
        horizon : str
        data : horizon data, optional
            What the horizon was torn from. Default: what the scene was given.
        **look
            ``ax``, ``path``, ``size``, ``title``, ``style``: see `FlatLook`.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path

        Raises
        ------
        InputError
            If the horizon is not torn, or its data are not known.
        """
        checked, scene = _flat(**look), self._scene
        points = np.concatenate([*_data_of(scene, horizon, data).values()])
        surface, curves, options = map_of(scene, horizon, True)
        off = residuals(scene.sheets[horizon].surface, points)
        columns = np.column_stack([points[:, :2], off])
        options["measures"] = replace(options["measures"], fluids=(), residuals=columns)
        if checked["title"] is None:
            checked["title"] = f"{horizon}: data against the sheet"
        return plotted(draw_map, surface, curves, **options, **checked)

    def column(self, **look: Unpack[FlatLook]) -> Any:
        """Draw the stratigraphic column: zones with their mean thickness, horizons and their rules.

        Parameters
        ----------
        **look
            ``ax``, ``path``, ``size``, ``title``, ``style``: see `FlatLook`.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path

        Raises
        ------
        InputError
            For axes that are not axes.
        """
        checked, scene = _flat(**{"size": (700, 800), **look}), self._scene
        # a fluid contact does not divide the thickness of its zone
        units = [(unit.zone, unit.volume, unit.zone_map_area) for unit in scene.units.values()]
        zones = column_of(units, list(dict.fromkeys(zone for zone, _, _ in units)))
        words = {"reservoir": scene.units.reservoir}
        return plotted(draw_column, zones, dict(scene.column), **words, **checked)

    def view(
        self,
        view: View = "southwest",
        *,
        show: Sequence[str] = ("horizons", "faults", "curves"),
        exploded: float = 0.0,
        clip: bool = True,
        overlay: PictureOverlay | None = None,
        seal: Any = (),
        **look: Unpack[ViewLook],
    ) -> Any:
        """Draw horizons, faults, curves or units in three dimensions.

        Parameters
        ----------
        view : str or (float, float)
            Position of the viewer: ``"southwest"``, ``"southeast"``, ``"northwest"``,
            ``"northeast"``, ``"south"``, ``"north"``, ``"east"``, ``"west"`` or ``"top"``; or its
            azimuth, clockwise from north, and its height above the horizontal [degrees], as in
            ``(225, 30)``. The projection is parallel, so the scale bar is valid everywhere.
        show : sequence of str
            Any of ``"horizons"``, ``"faults"``, ``"walls"``, ``"surfaces"``, ``"curves"``,
            ``"patches"``, ``"units"``.
        exploded : float
            Gap between units, as a fraction of the size of the model box: zones move up and down,
            blocks sideways.
        clip : bool
            Whether surfaces and curves are clipped to the model box and the area of interest.
        overlay : PictureOverlay, optional
            Wells, polygons and data points that are drawn with the model.
        seal : result of `Scene.seal`, or list of these
            These faults have the colours of their shale gouge ratio.
        **look
            ``path``, ``size``, ``exaggeration``, ``zoom``, ``only``, ``include``, ``colour_by``,
            ``title``, ``style``: see `ViewLook`.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path

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
        given, overlay, scene = _View(view, **look), overlay_of(overlay), self._scene
        clip, only, style = flag_of(clip, "clip"), given.only, given.style
        gap = number_of(exploded, "exploded", _GAP)
        words = [show] if isinstance(show, str) else listed(show, "show is a list of words", _SHOW)
        seals = [seal] if hasattr(seal, "attrs") else listed(seal, "seal is a list", _SEAL)
        if not all(hasattr(result, "sgr") for result in seals):
            raise InputError(f"seal takes results of scene.seal; {_SEAL}.")
        for word in words:
            check_word(
                word, SHOWABLE, f"unknown word in show: {word!r}. Use any of {', '.join(SHOWABLE)}."
            )
        by = given.by
        _check_colour_by(by, words)
        # only what is shown is asked of the scene, so that nothing else is computed
        roles = {ROLES_SHOWN[word] for word in words if word in ROLES_SHOWN}
        if only.names is not None:
            only.check(_names_of(scene, words))
        content, box, note = Content(), scene.box, ""
        outline = scene.aoi if clip else None
        within = Prism(box, outline) if clip else None
        if roles:
            # torn horizons end on their faults: what lies beyond is not part of the model
            sealed = [result.attrs["fault"] for result in seals]
            shown = [s for s in scene.surfaces if s.role in roles and s.name not in sealed]
            most = most_of_each(len(shown), given.size, given.zoom)
            content += show_surfaces(
                (as_modelled(scene, surface, most) for surface in shown), within, only=only,
                by_elevation=isinstance(by, str) and by == "z", style=style, size=given.size,
                zoom=given.zoom,
            )  # fmt: skip
        if seals:
            content += show_seals(seals, style)
        if "patches" in words:
            content += show_patches(scene.patches, within, only=only, style=style)
        if "units" in words:
            content += show_units(scene.units, gap, only=only, colour_by=by, style=style)
            note = f"{'' if gap == 0.0 else 'Exploded view. '}{only.left_out(scene.units)}".strip()
        if "curves" in words:
            content += show_curves(scene.curves, within=within)
        if outline is not None and not gap:
            content += show_outline(outline, box[4])
        if overlay:
            content += show_overlay(overlay, box[5])
        title = _title(words, by)
        if seals:
            title, note = f"{title}, shale gouge ratio of faults", FACING
        return given.draw(content, title, gap, box, note)


def _shown_along(
    scene: ReportedModel, name: str, fault: str, throw: xarray.Dataset
) -> np.ndarray | None:
    """Distance along the strike, throw that data show, and its spread (n, 3); None without."""
    sheet = scene.sheets.get(name)
    if sheet is None or not isinstance(sheet.report, SheetReport):
        return None
    audit = sheet.report.throw[fault]
    azimuth = np.radians(float(throw.attrs["dip_azimuth"]) - 90.0)
    strike = np.array([np.sin(azimuth), np.cos(azimuth)])
    first = np.array([throw.easting[0], throw.northing[0]]) @ strike - float(throw.along_strike[0])
    along = audit.stations[:, :2] @ strike - first
    return np.column_stack([along, audit.data, audit.spread])


def _stations(sheet: Sheet, fault: str) -> np.ndarray:
    """Places (n, 2) along the trace of a fault on a sheet; none where it does not tear it."""
    cut = sheet.cuts.get(fault)
    return np.empty((0, 2)) if cut is None else cut.stations[:, :2]


def _data_of(scene: Any, horizon: str, data: Any) -> dict[str, np.ndarray]:
    """Data of a horizon: as given here, or to the scene."""
    inputs = scene._plain.inputs  # in depth, also where they were given in time
    if data is None:
        data = opened_horizon(inputs.horizons.get(horizon), inputs.options)
    words = {} if data is None else undeclared(data, inputs.options)
    return data_of(scene.sheets.get(horizon), data, horizon, {**words})


def _leaks_on(scene: ReportedModel, fault: str, closures: Any) -> list[tuple[str, float, float]]:
    """Closure, distance along strike and elevation of the leaks on a fault."""
    check_closures(closures)
    faces = faces_of(scene.patches, scene.units, fault, "fault")
    rows = np.flatnonzero(closures.leak_fault.values == fault)
    places = np.column_stack([closures[f"leak_{key}"].values for key in COORDINATES])[rows]
    along = faces.along(places - faces.origin).tolist()
    names = closures.leak_closure.values[rows].tolist()
    return list(zip(names, along, places[:, 2].tolist(), strict=True))


def _names_of(scene: ReportedModel, show: Sequence[str]) -> list[str]:
    """Names that `only` may have: of surfaces and, where they are shown, of units."""
    names = [*scene.horizon_names, *scene.fault_names]
    if {"walls", "surfaces", "patches"} & set(show):
        names += [surface.name for surface in scene.surfaces]
    if "units" in show:
        for unit in scene.units.values():
            names += [unit.name, unit.zone, unit.block, unit.region]
    return [name for name in names if name]


def _check_colour_by(colour_by: Any, show: Sequence[str]) -> None:
    """Refuse a colouring that nothing in the picture has."""
    by, _ = check_colour_by(colour_by)
    if "units" not in show and not (isinstance(by, str) and by in ("unit", "z")):
        raise InputError(
            f"colour_by is {colour_by!r}, which colours units, but show has no units. Add 'units' "
            "to show."
        )


def _title(show: Sequence[str], colour_by: Any) -> str:
    """Return the title: a list of what the picture shows, and what it is coloured by."""
    # in the order of `SHOWABLE`, however the caller listed them
    words = ["intersection lines" if w == "curves" else w for w in SHOWABLE if w in show]
    if not words:
        return "Scene"
    head, last = ", ".join(words[:-1]), words[-1]
    title = (f"{head} and {last}" if head else last).capitalize()
    _, kind = check_colour_by(colour_by)
    # the unit stands at the colour bar, with its power of ten
    by = "elevation" if kind == "z" else kind.partition(" [")[0]
    return title if kind == "unit" else f"{title}, by {by}"
