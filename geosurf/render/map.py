"""Draw a map of a horizon: elevation in colour, contours, intersection lines, scale, north."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import counted, length_text, palette
from geosurf.conventions.axes import vertical_label, vertical_words
from geosurf.conventions.palette import RGB
from geosurf.errors import GeosurfWarning, InputError
from geosurf.lazy import xarray
from geosurf.model import Curves, TriSurface
from geosurf.model.column import fault_of
from geosurf.render import artists
from geosurf.render.artists import LineStyle
from geosurf.render.clip import Prism, clipped_lines
from geosurf.render.diagram import outline_of
from geosurf.render.furniture import (
    colours_of,
    contour_levels,
    draw_symbol,
    frame_map,
    halo_text,
    map_axes,
    number_contours,
    thin_and_bold,
)
from geosurf.render.layers import Entry, shortened_apart
from geosurf.render.overlay import (
    PictureOverlay,
    draw_on_map,
    draw_wells_on_map,
    name_place,
    overlay_of,
    tops_on_map,
)
from geosurf.render.sheet import Sheet
from geosurf.render.surface_layers import thinned

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes


# ---- map curves ----------------------------------------
# Intersection lines on the map of a horizon, each named once at its longest line.


def draw_curves(
    sheet: Sheet,
    axes: Axes,
    surface: TriSurface,
    curves: Curves,
    within: Prism | None,
    faults: list[str],
    n_wall: int = 1,
) -> list[Entry]:
    """Draw the intersection lines of a surface as bold lines.

    Lines of named faults have the colours of the faults, other lines are dark grey. If no faults
    are named, each surface has a colour. Each fault has a line on `n_wall` walls of the horizon.
    """
    name = surface.name
    # colours: as faults in other pictures, or one for each other surface
    row = curves.names.index(name)
    met = (
        curves.names[k] for pair in curves.surfaces_of_curve.tolist() if row in pair for k in pair
    )
    order = faults or list(dict.fromkeys(other for other in met if other != name))
    colours = {
        other: sheet.style.colour(
            other, palette.fault(order.index(other)) if other in order else palette.INK
        )
        for other in curves.names
    }

    # length by other surface [m]; its lines; the longest one, and a place a third along it
    others: dict[int, float] = {}
    lines: dict[int, list[np.ndarray]] = {}
    longest: dict[int, tuple[float, np.ndarray]] = {}
    width = sheet.points(2.6)
    pairs = curves.surfaces_of_curve.tolist()
    rows = [i for i, pair in enumerate(pairs) if row in pair]
    shown_ends = clipped_lines(curves.points, [curves.curves[i] for i in rows], within)
    for i, ends in zip(rows, shown_ends, strict=True):
        if not len(ends):
            continue
        pair = pairs[i]
        other = pair[0] if pair[1] == row else pair[1]
        length = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())
        others[other] = others.get(other, 0.0) + length
        lines.setdefault(other, []).append(ends[:, :, :2])
        if length > (longest[other][0] if other in longest else 0.0):
            longest[other] = (length, ends[len(ends) // 3, 0, :2])

    # one object for each surface: 500 of them, one for each line, took two thirds of a map
    for other, parts in lines.items():
        colour = colours[curves.names[other]]
        shown = artists.LineCollection(
            list(np.concatenate(parts)), colors=[colour], linewidths=width
        )
        shown.set_capstyle("round")
        axes.add_collection(shown, autolim=False)
    _name_lines(sheet, axes, {curves.names[other]: one for other, one in longest.items()}, colours)

    # faults first: where the legend has no room, horizons are the ones that are only counted
    met_here = sorted(others, key=lambda other: curves.names[other] not in faults)
    legend = []
    for name, length in ((curves.names[k], others[k]) for k in met_here):
        words = f"intersection, {length_text(length)}"
        if name in faults:
            words = f"fault, cuts it over {length_text(length / n_wall)}"
        legend.append(Entry(name, colours[name], words, "line"))
    return legend


def _name_lines(
    sheet: Sheet, axes: Axes, longest: dict[str, tuple[float, np.ndarray]], colours: dict[str, RGB]
) -> None:
    """Write the name of each other surface next to its longest line.

    It goes 9 design pixels to the right, or to the left where it would leave the map; the longest
    lines first, and no name over another: the legend has them all.
    """
    unit = sheet.layout.unit
    labels = shortened_apart(longest)
    for other, (_, at) in sorted(longest.items(), key=lambda item: -item[1][0]):
        label = labels[other]
        x, y = axes.transData.transform(at)
        x += 9.0 * unit
        wide, high = sheet.text_size(label, 11.5, "bold")
        if x + wide > axes.bbox.x1:
            x -= 18.0 * unit + wide
        if not sheet.names.take((x, y - 0.7 * high, x + wide, y + 0.7 * high)):
            continue
        at = axes.transData.inverted().transform((x, y))
        colour = palette.shade(colours[other], 1, 2)
        halo_text(sheet, axes, at, label, 11.5, colour, ha="left", fontweight="bold")


# ---- fluids ----------------------------------------
# Parts of a horizon above fluid contacts: filled, with the contact as a line.


FILLED = 0.45  # opacity of a fill: the elevation below is still seen


@dataclass(frozen=True, eq=False)
class FluidArea:
    """The part of a horizon whose rock below it is in one contact interval.

    Attributes
    ----------
    interval : str
        Such as ``"above OWC"``.
    fluid : {"oil", "gas", ""}
    rings : sequence of ndarray of float64, each (n, 2)
        Around it, and the other way round around holes [m].
    lines : sequence of ndarray of float64, each (n, 2)
        Where the contact below it meets the horizon [m].
    """

    interval: str
    fluid: str
    rings: Sequence[np.ndarray]
    lines: Sequence[np.ndarray]


def draw_fluids(sheet: Sheet, axes: Axes, fluids: Sequence[FluidArea]) -> list[Entry]:
    """Fill the parts of a horizon above fluid contacts; return the entries of the legend."""
    legend, width = [], sheet.points(2.0)
    for area in fluids:
        colour = palette.FLUIDS[area.fluid]
        patch = artists.PathPatch(
            outline_of(area.rings), facecolor=colour, alpha=FILLED, linewidth=0.0, zorder=1.5
        )
        axes.add_artist(patch)
        for line in area.lines:
            axes.plot(*line.T, color=palette.PAPER, linewidth=1.9 * width, zorder=2.6)
            axes.plot(*line.T, color=palette.CONTACT, linewidth=width, zorder=2.7)
        detail = f"{area.fluid} in the zone below" if area.fluid else "in the zone below"
        legend.append(Entry(area.interval, colour, detail, opacity=FILLED))
    return legend


# ---- residuals ----------------------------------------
# Data as dots, by how far they lie above or below a torn horizon.


BOUNDS = (0.1, 1.0, 5.0, 20.0)  # of classes [m]


def draw_residuals(sheet: Sheet, axes: Axes, residuals: np.ndarray) -> list[Entry]:
    """Draw data (n, 3): place, and metres above the horizon; return the entries of the legend."""
    off = residuals[:, 2]
    known = np.nan_to_num(off)
    number = np.where(np.isnan(off), -99, np.digitize(np.abs(known), BOUNDS) * np.sign(known))
    legend = []
    for words, rows, colour, size in _classes(off, number):
        if rows.any() and size > 0.0:
            axes.plot(
                *residuals[rows, :2].T, linestyle="none", marker="o", markersize=sheet.points(size),
                color=colour, markeredgewidth=0.0, zorder=2.9, rasterized=True,
            )  # fmt: skip
        if rows.any():
            legend.append(Entry(words, colour, counted(int(rows.sum()), "point"), "circle"))
    return legend


def _classes(off: np.ndarray, number: np.ndarray) -> Iterator[tuple[str, np.ndarray, RGB, float]]:
    """Name, rows, colour and size of each class of residuals, the largest drawn last."""
    yield "in a gap", np.isnan(off), palette.FAINT, 2.0
    unit = vertical_words()[1]
    yield f"within {BOUNDS[0]:g} {unit}, not drawn", number == 0, palette.PAPER, 0.0
    for k in range(1, len(BOUNDS) + 1):
        upper = f" to {BOUNDS[k]:g}" if k < len(BOUNDS) else ""
        lower = f"{BOUNDS[k - 1]:g}" if upper else f"more than {BOUNDS[k - 1]:g}"
        for sign, word, (low, high) in ((1, "above", ABOVE), (-1, "below", BELOW)):
            share = (k - 1) / (len(BOUNDS) - 1)
            red, green, blue = (a + share * (b - a) for a, b in zip(low, high, strict=True))
            words = f"{lower}{upper} {unit} {word}"
            yield words, number == sign * k, (red, green, blue), 2.0 + 0.6 * k


ABOVE = palette.rgb("#f6b0a0"), palette.rgb("#a50026")
BELOW = palette.rgb("#a6c8ec"), palette.rgb("#123b8c")


# ---- virtual lines ----------------------------------------
# Draw on a map where virtual walls meet the horizon: dashed, in the colours of their faults.


def draw_virtual_walls(
    sheet: Sheet, axes: Axes, virtual: Mapping[str, Sequence[np.ndarray]], faults: Sequence[str]
) -> list[Entry]:
    """Draw virtual walls on the map; return the entry of the legend.

    Parameters
    ----------
    sheet : Sheet
    axes : Axes
        Of the map.
    virtual : mapping of str to sequence of ndarray of float64, each (n, 3)
        Lines of each virtual wall on the horizon [m].
    faults : sequence of str
        Names of all faults, for their colours.
    """
    width = sheet.points(1.8)
    shown = []
    for name, lines in virtual.items():
        fault = fault_of(name)
        colour = palette.fault(faults.index(fault)) if fault in faults else palette.INK
        for line in lines:
            # a white line below: dashes are seen on all colours of the elevation
            x, y = line[:, :2].T
            axes.plot(x, y, color=palette.PAPER, linewidth=1.8 * width, zorder=2.4)
            axes.plot(x, y, color=colour, linewidth=width, dashes=(4.0, 1.6), zorder=2.5)
        if len(lines):
            shown.append(fault)
    if not shown:
        return []
    words = counted(len(shown), "virtual wall")
    return [Entry(words.capitalize(), palette.INK, "of " + ", ".join(shown), "dashes")]


# ---- remedies ----------------------------------------
# Mark on a map where the tear of a horizon needed a remedy: `SheetReport.remedies`.


RADIUS = 6.0  # of a mark [design pixels]


def draw_remedies(sheet: Sheet, axes: Axes, remedies: Sequence[GeosurfWarning]) -> list[Entry]:
    """Mark the place of each remedy on the map; return the entry of the legend.

    Parameters
    ----------
    sheet : Sheet
    axes : Axes
        Of the map.
    remedies : sequence of GeosurfWarning
        Those without a place are left out.
    """
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    shown: list[str] = []
    for remedy in remedies:
        if remedy.place is None:
            continue
        x, y = remedy.place[:2]

        # marks outside the map would stand in its margin, next to nothing
        if not (west <= x <= east and south <= y <= north):
            continue
        axes.plot(
            [x], [y], marker="o", markersize=sheet.points(2.0 * RADIUS), markerfacecolor="none",
            markeredgecolor=palette.ACCENT, markeredgewidth=sheet.points(2.4),
            linestyle="none", zorder=6.5,
        )  # fmt: skip
        shown.append(remedy.kind)
    if not shown:
        return []

    # the legend counts each kind of remedy
    kinds = ", ".join(f"{kind}: {n}" for kind, n in sorted(Counter(shown).items()))
    words = f"{counted(len(shown), 'place')} of remedies"
    return [Entry(words, palette.ACCENT, kinds, "circle")]


# ---- closures ----------------------------------------
# Outlines of closures, their crests, spill points and leaks, and the ways of what spills.


def draw_closures(sheet: Sheet, axes: Axes, closures: xarray.Dataset, horizon: str) -> list[Entry]:
    """Draw the closures of a horizon, from `Scene.closures`; return the entries of the legend.

    Of those that consist of others the outermost are drawn, dashed.
    """
    check_closures(closures)
    table = closures.drop_dims(["leak", "line", "point"]).to_dataframe()
    table["joint"] = table.index.isin(table.part_of)
    table = table[(table.horizon == horizon) & ~(table.joint & (table.part_of != ""))]
    colour, width = palette.CLOSURE, sheet.points(2.2)
    lines = np.split(
        np.column_stack([closures.easting, closures.northing]),
        np.cumsum(closures["count"].values)[:-1],
    )
    labels = zip(lines, closures.line_kind.values, closures.line_closure.values, strict=True)
    for xy, kind, name in (line for line in labels if line[2] in table.index):
        look: LineStyle = {"linestyle": (0, (1.0, 1.5))} if kind == "path" else {}
        if kind == "outline":
            look = {"linestyle": (0, (4.0, 1.6))} if table.joint[name] else {}
            xy = np.concatenate([xy, xy[:1]])
        axes.plot(*xy.T, color=palette.PAPER, linewidth=1.9 * width, zorder=3.0, alpha=0.8)
        axes.plot(*xy.T, color=colour, linewidth=width, zorder=3.1, **look)

    # the highest crest takes its number first
    leaks = np.flatnonzero(np.isin(closures.leak_closure.values, table.index))
    single = table[~table.joint]
    places = [("spill", at) for at in zip(table.spill_easting, table.spill_northing, strict=True)]
    places += [
        ("crest", at) for at in zip(single.crest_easting, single.crest_northing, strict=True)
    ]
    places += [
        ("leak", (closures.leak_easting[k], closures.leak_northing[k])) for k in leaks.tolist()
    ]
    for kind, at in places:
        draw_symbol(sheet, axes, at, kind, palette.ACCENT if kind == "leak" else colour)
    for name, x, y in zip(single.index, single.crest_easting, single.crest_northing, strict=True):
        name_place(sheet, axes, np.array([x, y]), name[len(horizon) + 1 :])
    how = f"faults: {closures.attrs['faults']}, from {closures.attrs['min_height']:g} m"
    legend = [
        Entry(counted(len(single), "closure").capitalize(), colour, how, "line"),
        Entry("Joint closure", colour, "of several that meet", "dashes"),
        Entry("Crest", colour, "with the number of the closure", "crest"),
        Entry("Spill point", colour, "dots: up to the next closure", "spill"),
        Entry("Leak point", palette.ACCENT, "at a fault", "leak"),
    ]
    shown = {"line", *(kind for kind, _ in places), *(["dashes"] if table.joint.any() else [])}
    return [entry for entry in legend if entry.kind in shown]


def check_closures(closures: Any) -> None:
    """Refuse what is not the result of `Scene.closures`."""
    if not hasattr(closures, "attrs") or "min_height" not in closures.attrs:
        raise InputError(
            f"closures is {type(closures).__name__}; give True or the result of scene.closures()."
        )


MAX_MAP_TRIANGLE = 250_000
N_BAND = 3  # bands of colour per contour interval


@dataclass(frozen=True, eq=False)
class MapMeasures:
    """What is measured of a horizon and drawn on its map.

    Attributes
    ----------
    fluids : sequence of FluidArea
        Parts above fluid contacts.
    n_wall : int
        Walls on which each fault has a line: 2 where the horizon is torn.
    closures : xarray.Dataset or None
        Result of `Scene.closures`.
    residuals : ndarray of float64, shape (n, 3), or None
        Easting and northing of data, and how far they lie above the horizon [m]; NaN: in a gap.
    """

    fluids: Sequence[FluidArea] = ()
    n_wall: int = 1
    closures: xarray.Dataset | None = None
    residuals: np.ndarray | None = None


def draw_map(
    sheet: Sheet,
    surface: TriSurface,
    curves: Curves | None = None,
    *,
    title: str | None = None,
    outline: np.ndarray | None = None,
    faults: Sequence[str] = (),
    tops: Any = None,
    hatched: TriSurface | None = None,
    remedies: Sequence[GeosurfWarning] = (),
    virtual_walls: Mapping[str, Sequence[np.ndarray]] = MappingProxyType({}),
    measures: MapMeasures | None = None,
    overlay: PictureOverlay | None = None,
) -> None:
    """Draw a map of a horizon: elevation in colour, contours, intersection lines in bold.

    Parameters
    ----------
    sheet : Sheet
    surface : TriSurface
    curves : Curves, optional
        Lines on the surface are drawn, with one colour per other surface.
    title : str, optional
        Default: the name of the surface.
    outline : ndarray of float64, shape (n, 2), optional
        Outline of the area that is shown: easting and northing, counter-clockwise [m].
        Default: the whole surface.
    faults : sequence of str
        Names of all faults, for the same colours as in other pictures.
    tops : xarray.Dataset, optional
        Result of `Scene.misfit`: well tops of this horizon are drawn, with name and misfit [m].
    hatched : TriSurface, optional
        The horizon with all its nodes: what `extend_horizon` continued is hatched.
    remedies : sequence of GeosurfWarning
        Places that are marked, such as ``sheet.report.remedies``: there the tear needed help.
    virtual_walls : mapping of str to sequence of ndarray of float64, each (n, 2) or (n, 3)
        Lines of virtual walls on the horizon, by their names [m]: they are dashed.
    measures : MapMeasures, optional
        Fluids, closures and residuals that are drawn.
    overlay : PictureOverlay, optional
        Wells, polygons and data points that are drawn with the model.

    Raises
    ------
    InputError
        If the surface is empty or vertical or has no triangles inside the outline.
    """
    title = f"{surface.name}: {vertical_words()[0].lower()}" if title is None else title
    overlay = overlay_of(overlay)
    wells = [] if tops is None else tops_on_map(tops, surface.name)

    # no more triangles than the map can show
    light, within = thinned(surface, MAX_MAP_TRIANGLE), None
    if not light.n_triangle:
        raise InputError(
            f"surface {surface.name!r} has no triangles. Pass a surface with triangles."
        )
    if outline is not None:
        # a prism around the outline, high enough for all of the surface
        (w, s), (e, n) = np.min(outline, axis=0), np.max(outline, axis=0)
        within = Prism((w, e, s, n, light.bounds[4] - 1.0, light.bounds[5] + 1.0), outline)
        x, t, _ = within.triangles(light.vertices, light.triangles)
        if not len(t):
            raise InputError(
                f"surface {surface.name!r} lies outside the outline of the map. "
                "Leave the outline out, or check its coordinates."
            )
        light = TriSurface(surface.name, surface.role, x, t)
    west, east, south, north, bottom, top = light.bounds
    if not (east > west and north > south):
        raise InputError(
            f"surface {surface.name!r} is vertical, so its map is only a line. "
            "Draw it with scene.plot.view('south') or from another side."
        )
    # axes, colours and contours
    axes, metres_per_pixel = map_axes(sheet, (west, east, south, north))
    levels = contour_levels(bottom, top)
    if len(levels) > 1:
        _draw_elevation(sheet, axes, light, levels)
    note = ""
    if hatched is not None and _hatch(axes, hatched, outline):
        note = " Hatched: extrapolated, without data."

    # intersection lines, and what stands beside the map
    measures = MapMeasures() if measures is None else measures
    fluid_entries = draw_fluids(sheet, axes, measures.fluids)
    legend = []
    if curves is not None:
        legend = draw_curves(sheet, axes, light, curves, within, list(faults), measures.n_wall)
    legend = [*draw_virtual_walls(sheet, axes, virtual_walls, list(faults)), *legend]
    if measures.closures is not None:
        legend = [*draw_closures(sheet, axes, measures.closures, surface.name), *legend]
    legend = [*fluid_entries, *legend]
    if measures.residuals is not None:
        legend = [*draw_residuals(sheet, axes, measures.residuals), *legend]
    legend += draw_wells_on_map(sheet, axes, wells)
    legend += draw_on_map(sheet, axes, overlay)
    legend = [*draw_remedies(sheet, axes, remedies), *legend]
    frame_map(
        sheet, legend, levels, metres_per_pixel, title, note, words=vertical_label(),
        codes=sheet.style.codes(palette.ELEVATION), n_band=N_BAND,
    )  # fmt: skip


def _hatch(axes: Axes, surface: TriSurface, outline: np.ndarray | None) -> bool:
    """Hatch the triangles with an extrapolated vertex; return whether there are some."""
    mark = surface.vertex_data.get("extrapolated")
    if mark is None or not mark.any():
        return False
    x, y = surface.vertices[:, :2].T

    # any vertex without data: a triangle is as certain as its least certain corner
    triangles = surface.triangles[mark[surface.triangles].any(axis=1)]

    # hatches follow the contour of the mark; the area itself has no colour
    drawn = axes.tricontourf(
        artists.Triangulation(x, y, triangles), mark.astype(float), levels=[0.01, 1.5],
        colors="none", hatches=["////"],
    )  # fmt: skip

    # the edge colour is that of the hatching; the contour line itself is not drawn
    drawn.set_edgecolor(palette.INK)
    drawn.set_linewidth(0.0)
    if outline is not None:
        drawn.set_clip_path(artists.Polygon(np.asarray(outline), transform=axes.transData))
    return True


def _draw_elevation(sheet: Sheet, axes: Axes, surface: TriSurface, levels: np.ndarray) -> None:
    """Bands of colour with contour lines; every fifth line is bold."""
    x, y, z = surface.vertices.T
    mesh = artists.Triangulation(x, y, surface.triangles)
    bands = np.linspace(levels[0], levels[-1], (len(levels) - 1) * N_BAND + 1)
    colours = colours_of(sheet.style.codes(palette.ELEVATION))
    axes.tricontourf(mesh, z, levels=bands, cmap=colours, antialiased=False)

    for chosen, width in thin_and_bold(levels):
        if len(chosen):
            lines = axes.tricontour(
                mesh, z, levels=chosen, alpha=0.75,
                colors=[palette.INK], linewidths=width * sheet.layout.unit, linestyles="solid",
            )  # fmt: skip
            if width > 0.5:
                number_contours(sheet, axes, lines, vertical_label())
