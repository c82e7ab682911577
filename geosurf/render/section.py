"""Draw a vertical section: zones, faults, horizons and fluid contacts along a line on the map."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import area_texts, check_word, grouped, number_text, palette
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.model import CornerPointGrid
from geosurf.model.expected import expect
from geosurf.render import artists
from geosurf.render.allan import HALO
from geosurf.render.colouring import zone_colours
from geosurf.render.compose import figure_path, save_figure
from geosurf.render.diagram import (
    diagram_axes,
    draw_ends,
    highest_in_view,
    in_words,
    lines_of,
    outline_of,
    range_shown,
)
from geosurf.render.furniture import draw_legend, draw_words, rim_of_words
from geosurf.render.layers import Entry, shortened_apart
from geosurf.render.overlay import (
    PictureOverlay,
    draw_on_section,
    draw_wells_on_section,
    overlay_of,
    tops_on_section,
)
from geosurf.render.picture_style import FONT, PictureStyle, readable
from geosurf.render.sheet import Sheet, sheet_for
from geosurf.render.views import check_size

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# ---- grid section ----------------------------------------
# Draw a row or a column of cells of a corner-point grid, as a vertical section.


ROOM = 24.0  # margin at both ends [design pixels]
BY = ("zone", "block")


def render_grid_section(
    grid: CornerPointGrid,
    path: str | os.PathLike[str],
    *,
    row: int | None = None,
    column: int | None = None,
    colour_by: str = "zone",
    size: tuple[int, int] = (1280, 800),
    title: str | None = None,
    style: PictureStyle | None = None,
) -> Path:
    """Draw the active cells of one row or column of a grid.

    Parameters
    ----------
    grid : CornerPointGrid
    path : path-like
        A ``.png``, ``.svg`` or ``.pdf`` file; its folder is created.
    row, column : int, optional
        J of a row or I of a column, from 1. Default: the middle row.
    colour_by : {"zone", "block"}
    size : (int, int)
        Width and height in pixels.
    title : str, optional
        Default: the number of the row or column.
    style : PictureStyle, optional
        Theme, font, colours by name, colour map.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For a row or column that the grid does not have, or both.
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes()
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> grid = gs.build_grid(scene, cell=200, layers={"Top/Base": 4})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     gs.render_grid_section(grid, f"{folder}/row.png", row=8, size=(400, 250)).name
    'row.png'
    """
    path = figure_path(path)
    expect(grid, CornerPointGrid, "render_grid_section takes a grid", "pass gs.build_grid(scene)")
    check_word(colour_by, BY, f"colour_by is {colour_by!r}, expected one of {BY}.")
    axis, number = _where(grid, row, column)
    cells, shown = _cells(grid, axis, number - 1)
    if not shown.any():
        raise InputError(f"{'JI'[axis]} {number} has no active cell. Choose another one.")
    names, values, order = grid.block_names, grid.block, grid.block_names
    if colour_by == "zone":
        names, values, order = grid.zone_names, grid.zone, grid.zones_of_model
    sheet = sheet_for(None, check_size(size), style)
    colours = [sheet.style.colour(name, palette.stratum(order.index(name))) for name in names]
    kinds = values[:, number - 1] if axis == 0 else values[:, :, number - 1]
    title = f"Cells at {'JI'[axis]} = {number}, by {colour_by}" if title is None else title
    return save_figure(_figure(sheet, cells[shown], kinds[shown], names, colours, title), path)


def _where(grid: CornerPointGrid, row: Any, column: Any) -> tuple[int, int]:
    """Axis (0: a row, 1: a column) and its number, from 1."""
    if row is not None and column is not None:
        raise InputError("row and column are both given. Give one of them.")
    axis = 0 if column is None else 1
    most = grid.shape[1 + axis]
    number = (most + 1) // 2 if row is None and column is None else (row, column)[axis]
    if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= most:
        raise InputError(
            f"{('row', 'column')[axis]} is {number!r}. Give a whole number from 1 to {most}."
        )
    return axis, number


def _cells(grid: CornerPointGrid, axis: int, at: int) -> tuple[np.ndarray, np.ndarray]:
    """Rings of distance and elevation [m] (nz, n, 4, 2), and which of them are active."""
    corners = np.stack([grid.corners_of_layer(k) for k in range(grid.shape[0])])
    cut = corners[:, at] if axis == 0 else corners[:, :, at]

    # (nz, n, top or base, first or second side, xyz), in the middle of the row or column
    middle = cut.mean(axis=3 + axis) if axis == 0 else cut.mean(axis=4)
    first, last = grid.coord[0, 0, :2], grid.coord[-1, 0, :2] if axis else grid.coord[0, -1, :2]
    along = (last - first) / np.hypot(*(last - first))
    flat = np.stack([(middle[..., :2] - first) @ along, middle[..., 2]], axis=-1)
    ring = np.stack([flat[:, :, 0, 0], flat[:, :, 0, 1], flat[:, :, 1, 1], flat[:, :, 1, 0]], 2)
    active = grid.actnum[:, at] if axis == 0 else grid.actnum[:, :, at]
    return ring, active


def _figure(
    sheet: Sheet,
    rings: np.ndarray,
    kinds: np.ndarray,
    names: tuple[str, ...],
    colours: list[palette.RGB],
    title: str,
) -> Figure:
    """Cells (n, 4, 2) in the colours of their kinds, with a legend."""
    points = rings.reshape(-1, 2)
    axes, exaggeration = diagram_axes(
        sheet, range_shown(points, [points[:, 1]]), "Distance along the section [km]", ROOM
    )
    axes.add_collection(
        artists.PolyCollection(
            list(rings),
            facecolors=np.array(colours)[kinds],
            edgecolors=palette.INK,
            linewidths=0.25,
        )
    )
    legend = tuple(Entry(names[k], colours[k]) for k in np.unique(kinds).tolist())
    draw_legend(sheet, legend, 640.0)
    draw_words(sheet, title, in_words(exaggeration))
    return sheet.figure


Part = tuple[dict[str, str], np.ndarray, float]  # attributes, points (n, 2) [m], area [m2]
Areas = dict[tuple[str, str], float]  # of zone and contact interval [m2]
Colours = dict[tuple[str, str], palette.RGB]

ROUNDING = 1e-12  # fraction of the area of a section: smaller parts have no thickness
# margin for the compass directions at both ends [design pixels]


def draw_section(
    sheet: Sheet,
    section: xarray.Dataset,
    *,
    title: str | None = None,
    units: Mapping[str, tuple[str, palette.RGB]] | None = None,
    tops: Any = None,
    overlay: PictureOverlay | None = None,
) -> None:
    """Draw a vertical section through a model.

    Parameters
    ----------
    sheet : Sheet
    section : xarray.Dataset
        Result of `Scene.section`.
    title : str, optional
        Default: the coordinates of both ends.
    units : mapping of str to (str, colour), optional
        Label and colour of each unit in other pictures. Default: one colour for each zone, with
        shades for contact intervals.
    tops : xarray.Dataset, optional
        Result of `Scene.misfit`: wells with tops within 2 % of the length of the section are drawn.
    overlay : PictureOverlay, optional
        Wells, polygons and data points that are drawn with the model.
    """
    overlay = overlay_of(overlay)

    # each part: attributes, points (n, 2) of distance and elevation [m], area [m2]
    parts = lines_of(section, ("along_section", "elevation"), ("kind", "label", "zone", "contact"))
    lines = [(*part, float(area)) for part, area in zip(parts, section.area.values, strict=True)]
    zones = list(section.attrs["zones"])
    inside = section.attrs["reservoir"]
    names, colour_of_zone = zone_colours(zones, inside, sheet.style)
    known: Colours = {}
    for part, _, _ in lines:
        zone, part["zone"] = part["zone"], names.get(part["zone"], part["zone"])
        if part["kind"] == "unit" and part["label"] in (units or {}) and zone in inside:
            label, colour = (units or {})[part["label"]]
            part["contact"] = label.removeprefix(zone).strip()
            known[zone, part["contact"]] = colour
    areas = _areas(lines, list(colour_of_zone))
    if known:  # contact intervals by region, as the units of the model come
        rank = {label: k for k, (label, _) in enumerate((units or {}).values())}
        order = list(colour_of_zone)
        areas = dict(
            sorted(
                areas.items(),
                key=lambda one: (order.index(one[0][0]), rank.get(" ".join(one[0]).strip(), 0)),
            )
        )

    # the range follows horizons and contacts; faults reach farther
    levels = [line[:, 1] for words, line, _ in lines if words["kind"] in ("horizon", "contact")]
    shown = range_shown(np.concatenate([line for _, line, _ in lines]), levels)
    # from the start of the line to its end, wherever the model is
    route = np.array(section.attrs["line"], dtype=np.float64).reshape(-1, 2)
    shown = (0.0, float(section.attrs["length"]), *shown[2:])
    axes, exaggeration = diagram_axes(sheet, shown, "Distance along the section [km]", ROOM)
    colours = _colours(areas, colour_of_zone) | known
    _fill(axes, lines, colours)
    faults = {
        name: sheet.style.colour(name, palette.fault(i))
        for i, name in enumerate(section.attrs["faults"])
    }
    _draw_lines(sheet, axes, lines, faults)

    # wells, compass directions at both ends, legend, caption
    wells = []
    if tops is not None:
        # a zone is called "Top/Base" by its horizons, the lowest "below Base": a top has the colour
        # of the zone that begins at it
        below = {
            zone.removeprefix("below ").partition("/")[0]: colour_of_zone[name]
            for zone, name in names.items()
        }
        wells = draw_wells_on_section(sheet, axes, *tops_on_section(tops, route), below)
    if overlay:
        wells += draw_on_section(sheet, axes, overlay, route)
    corners = route[[0, -1]]
    (x0, y0), (x1, y1) = corners.tolist()
    draw_ends(sheet, axes, math.degrees(math.atan2(x1 - x0, y1 - y0)))
    legend = (*_legend(lines, areas, colours, faults), *wells)
    draw_legend(sheet, legend, 640.0)
    words = f"Areas: whole section. {in_words(exaggeration)}"
    if any(line["kind"] == "contact" for line, _, _ in lines):
        words = f"Fluid contacts: blue. {words}"
    draw_words(sheet, _title(corners) if title is None else title, words)


def _title(corners: np.ndarray) -> str:
    first, last = (f"E {number_text(x)} N {number_text(y)}" for x, y in corners.tolist())
    return f"Section from {first} to {last}"


def _areas(lines: list[Part], zones: list[str]) -> Areas:
    """Area [m2] of each zone and contact interval, from the top down.

    A zone without thickness along the section has an area that is only rounding error, of either
    sign. It gets no colour and no legend entry.
    """
    areas: Areas = {}

    # mean elevation of each part orders contact intervals within a zone
    rings: dict[tuple[str, str], list[np.ndarray]] = {}
    for words, line, area in lines:
        if words["kind"] == "unit":
            key = words["zone"], words["contact"]
            areas[key] = areas.get(key, 0.0) + area
            rings.setdefault(key, []).append(line[:, 1])

    # the order of the legend: zones of the column, contact intervals from the top down
    least = ROUNDING * sum(map(abs, areas.values()))
    heights = {key: float(np.concatenate(parts).mean()) for key, parts in rings.items()}
    order = sorted(areas, key=lambda key: (zones.index(key[0]), -heights[key]))
    return {key: areas[key] for key in order if areas[key] > least}


def _colours(areas: Areas, zones: dict[str, palette.RGB]) -> Colours:
    """Colours of zones from the column; contact intervals are shades of them."""
    shades = {}
    for zone, colour in zones.items():
        parts = [key for key in areas if key[0] == zone]
        for i, key in enumerate(parts):
            shades[key] = palette.shade(colour, i, len(parts))
    return shades


def _fill(axes: Axes, lines: list[Part], colours: Colours) -> None:
    """Fill the units."""
    # all rings of a unit in one outline, or its holes would be filled
    rings = grouped(
        ((words["label"], words["zone"], words["contact"]), line)
        for words, line, _ in lines
        if words["kind"] == "unit"
    )
    for (_, zone, part), parts in rings.items():
        colour = colours.get((zone, part))
        if colour is None:  # of no thickness
            continue
        # the edge closes the seam between neighbours
        outline = outline_of(parts)
        patch = artists.PathPatch(outline, facecolor=colour, edgecolor=colour, linewidth=0.4)

        # not `add_patch`: it looks for the extremes of each segment of the outline as of a curve
        axes.add_artist(patch)
        axes.update_datalim(outline.vertices)


def _draw_lines(
    sheet: Sheet, axes: Axes, lines: list[Part], faults: dict[str, palette.RGB]
) -> None:
    """Draw horizons, contacts, and faults in their colours with their names at the top."""
    width = sheet.points(1.6)
    bottom, top = axes.get_ylim()
    named: dict[str, np.ndarray] = {}
    for words, line, _ in lines:
        kind, name = words["kind"], words["label"]
        if kind == "horizon":
            axes.plot(*line.T, color=palette.INK, linewidth=width, zorder=3)
        elif kind == "contact":
            axes.plot(*line.T, color=palette.PAPER, linewidth=HALO * width, zorder=2)
            axes.plot(*line.T, color=palette.CONTACT, linewidth=width, zorder=2)
        elif kind == "virtual":
            axes.plot(*line.T, color=palette.INK, linewidth=width, linestyle="--", zorder=3)
        elif kind == "fault":
            # a white line below parts the fault from zones of a similar colour
            axes.plot(*line.T, color=palette.PAPER, linewidth=3.2 * width, zorder=4)
            axes.plot(*line.T, color=faults[name], linewidth=2.0 * width, zorder=5)

            # a fault may have several lines: the name goes to the highest of them in view
            highest = highest_in_view(line, bottom, top)
            if highest is not None and highest[1] > named.get(name, (0.0, -math.inf))[1]:
                named[name] = highest

    _name_faults(sheet, axes, named, faults)


def _name_faults(
    sheet: Sheet, axes: Axes, named: dict[str, np.ndarray], faults: dict[str, palette.RGB]
) -> None:
    """Name each fault once, at its highest point in the picture; no name lies over another."""
    unit, labels = sheet.layout.unit, shortened_apart(named, 12)
    for name, place in named.items():
        x, y = axes.transData.transform(place)
        wide, high = sheet.text_size(labels[name], 12.0)

        # above the fault, else to its right or left; the legend has those without room
        for shift in (0.0, 0.5 * wide, -0.5 * wide):
            left, bottom = x + shift - 0.5 * wide, y + 9.0 * unit
            if not sheet.names.take((left, bottom, left + wide, bottom + high)):
                continue
            axes.annotate(
                labels[name], (place[0], place[1]), (shift, 9.0 * unit), annotation_clip=False,
                textcoords="offset pixels", ha="center", va="bottom", family=FONT,
                fontsize=sheet.points(12.0), zorder=6,
                color=readable(faults[name], palette.PAPER),
                path_effects=rim_of_words(sheet), parse_math=False,
            )  # fmt: skip
            break


def _legend(
    lines: list[Part], areas: Areas, colours: Colours, faults: dict[str, palette.RGB]
) -> tuple[Entry, ...]:
    """Zones from the top down, with their areas; then faults and contacts."""
    legend = [
        Entry(zone, colours[zone, part], ", ".join(filter(None, [part, area])))
        for (zone, part), area in zip(areas, area_texts(areas.values()), strict=True)
    ]
    for kind in ("fault", "virtual", "contact"):
        names = dict.fromkeys(words["label"] for words, _, _ in lines if words["kind"] == kind)
        if kind == "fault":
            shown = [name for name in faults if name in names]
            legend += [Entry(name, faults[name], "fault", "line") for name in shown]
        elif names and kind == "virtual":
            legend += [Entry(name, palette.INK, "virtual wall", "dashes") for name in names]
        elif names:
            legend.append(Entry("Fluid contacts", palette.CONTACT, ", ".join(names), "line"))
    return tuple(legend)
