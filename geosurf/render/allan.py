"""Draw the Allan diagram of a fault: the zones juxtaposed across it.

The diagram follows Allan (1989), AAPG Bulletin 73, 803-811. It shows the fault plane over distance
along strike and elevation. Solid lines are cut-offs of the footwall, dashed lines those of the
hanging wall. The fill is the colour of the footwall zone; stripes have the colour of the
hanging-wall zone where it differs. Fluid contacts are blue, solid or dashed like the cut-offs.
The parts of the fault far above and below these lines are not shown.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions import area_texts, grouped, palette
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.render import artists
from geosurf.render.artists import AreaStyle, LineStyle
from geosurf.render.colouring import seal_bar, shade_of, zone_colours
from geosurf.render.diagram import (
    Line,
    diagram_axes,
    draw_ends,
    in_words,
    lines_of,
    outline_of,
    range_shown,
    west_or_south_left,
)
from geosurf.render.furniture import (
    colours_of,
    draw_colour_bar,
    draw_legend,
    draw_symbol,
    draw_words,
)
from geosurf.render.layers import DETAIL_ROOM, Bar, Entry, shortened_apart
from geosurf.render.overlay import name_place
from geosurf.render.picture_style import FONT
from geosurf.render.sheet import STRIPE_WIDTH, STRIPES, Sheet

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes

LINES = {"cut-off": palette.INK, "contact": palette.CONTACT}  # kinds drawn as lines
ROOM = 96.0  # margin for names of cut-offs on both sides [design pixels]
FACING = "reservoir on reservoir"  # polygons in full colour
N_BAND = 4  # of the colour bar, between two of its values
HALO = 1.9  # width of the white rim of a contact over the width of its line


def draw_allan(
    sheet: Sheet,
    diagram: xarray.Dataset,
    table: xarray.Dataset,
    *,
    zones: Sequence[str] = (),
    reservoir: Sequence[str] | None = None,
    title: str | None = None,
    leaks: Sequence[tuple[str, float, float]] = (),
    seal: xarray.Dataset | None = None,
) -> None:
    """Draw the Allan diagram of a fault, with the area of each pair of juxtaposed zones.

    Parameters
    ----------
    sheet : Sheet
    diagram : xarray.Dataset
        Result of `Scene.allan`.
    table : xarray.Dataset
        Result of `Scene.juxtaposition` for the same fault: areas for the legend.
    zones : sequence of str
        Zones from the youngest to the oldest, which take the colours of the column in this order.
        Default: the order of the table.
    reservoir : sequence of str, optional
        Zones of the reservoir: the others have one colour above it and below it. Default: all.
    title : str, optional
        Default: the name of the fault and its strike.
    leaks : sequence of (str, float, float)
        Leak points: closure, distance along strike and elevation [m].
    seal : xarray.Dataset, optional
        Result of `Scene.seal` for the same fault: the fill is the shale gouge ratio.

    Raises
    ------
    InputError
        If diagram and seal are of different faults, or if the diagram is empty.
    """
    _check(diagram, seal)

    # colours follow the column; zones that the caller did not list come after it
    seen = dict.fromkeys(map(str, (*table.zone_minus.values, *table.zone_plus.values)))
    order = [*zones, *(zone for zone in seen if zone not in zones)]
    names, colours = zone_colours(order, order if reservoir is None else reservoir, sheet.style)
    pairs = _areas_of_pairs(table, names)

    # each line: attributes, and points (n, 2) of distance along strike and elevation [m]
    lines = lines_of(diagram, ("along_strike", "elevation"), ("kind", "side", "label", "zone"))

    # the range follows cut-offs and contacts: the fault far above and below is not shown
    levels = [line[:, 1] for words, line in lines if words["kind"] in LINES]
    points = np.concatenate([line for _, line in lines])
    shown = range_shown(points, levels)
    axes, exaggeration = diagram_axes(sheet, shown, "Distance along strike [km]", ROOM)
    if seal is None:
        _fill(axes, lines, names, colours)
    else:
        bar = _fill_by_ratio(sheet, axes, seal, lines)
    strike = float(diagram.attrs["strike"])
    draw_ends(sheet, axes, west_or_south_left(axes, strike))
    _draw_cutoffs(sheet, axes, lines)
    if seal is None:
        legend = _legend(pairs, colours, {name for zone, name in names.items() if name != zone})
    else:
        legend = _legend_of_classes(seal, bar)
    for closure, *at in leaks:
        draw_symbol(sheet, axes, at, "leak", palette.ACCENT)
        name_place(sheet, axes, np.array(at), closure)
    if leaks:
        legend = (
            Entry("Leak point", palette.ACCENT, "of the closure named there", "leak"),
            *legend,
        )
    draw_legend(sheet, legend, 640.0)

    # caption, title, file
    blue = " Fluid contacts: blue." if (diagram.kind == "contact").any() else ""
    areas = " Areas: whole fault." if any("²" in entry.detail for entry in legend) else ""
    if seal is not None:
        areas += f" Pale: not {FACING}."
    words = (
        "Cut-offs: footwall solid, named on the right; hanging wall dashed, named on the left."
        f"{blue}{areas} {in_words(exaggeration)}"
    )
    what = "Allan diagram" if seal is None else "shale gouge ratio"
    words_above = f"{diagram.attrs['fault']}: {what}, strike {strike:03.0f}°"
    draw_words(sheet, words_above if title is None else title, words)


def _check(diagram: xarray.Dataset, seal: xarray.Dataset | None) -> None:
    fault = diagram.attrs["fault"]
    if seal is not None and not hasattr(seal, "sgr"):
        raise InputError(
            f"seal is a {type(seal).__name__}; give the result of scene.seal({fault!r}, vshale=...)"
            "."
        )

    # ratios of another fault would be drawn in this diagram
    if seal is not None and seal.attrs["fault"] != fault:
        raise InputError(
            f"the diagram is of fault {fault!r}, seal= of fault {seal.attrs['fault']!r}. Give "
            f"scene.seal({fault!r}, vshale=...)."
        )
    if not (diagram.kind == "juxtaposition").any():
        raise InputError(
            f"fault {fault!r} has units on one side only, so it has no Allan diagram. "
            "Enlarge the box, or skip this fault."
        )


def _areas_of_pairs(table: xarray.Dataset, names: dict[str, str]) -> dict[tuple[str, str], float]:
    """Area [m2] of each pair of zones by their names in the picture: footwall first."""
    columns = (table.zone_minus.values, table.zone_plus.values, table.area.values.tolist())
    rows = zip(*columns, strict=True)
    areas = grouped(((names[str(minus)], names[str(plus)]), area) for minus, plus, area in rows)
    return {pair: sum(of) for pair, of in areas.items()}


def _fill(
    axes: Axes, lines: list[Line], names: dict[str, str], colours: dict[str, palette.RGB]
) -> None:
    """Fill juxtaposed areas: footwall in full colour, hanging wall as stripes."""
    # rings of one pair of zones together: a hole needs the ring around it
    rings: dict[str, tuple[str, list[np.ndarray]]] = {}
    for words, line in lines:
        if words["kind"] == "juxtaposition":
            rings.setdefault(words["label"], (words["zone"], []))[1].append(line)

    # labels are "hanging-wall zone | footwall zone"; all rings of a pair make one outline
    for pair, parts in rings.values():
        plus, minus = (names[zone] for zone in pair.split(" | "))
        outline = outline_of(parts)
        # the edge closes the seam between neighbours
        look: AreaStyle = {"facecolor": colours[minus], "edgecolor": colours[minus]}
        axes.add_artist(artists.PathPatch(outline, linewidth=0.4, **look))
        if plus != minus:
            look = {"facecolor": "none", "edgecolor": colours[plus], "hatch": STRIPES}
            stripes = artists.PathPatch(outline, linewidth=0.0, **look)
            stripes.set_hatch_linewidth(STRIPE_WIDTH)
            axes.add_artist(stripes)


def _fill_by_ratio(sheet: Sheet, axes: Axes, seal: xarray.Dataset, lines: list[Line]) -> Bar:
    """Fill the fault by its shale gouge ratio, pale where no reservoir faces reservoir."""
    bar = seal_bar([seal], sheet.style)
    s, z, sgr = (seal[key].values.ravel() for key in ("along_strike", "elevation", "sgr"))
    triangles = np.arange(len(s)).reshape(-1, 3)
    axes.tripcolor(
        s, z, np.nan_to_num(sgr), triangles=triangles, mask=np.isnan(sgr[triangles]).any(axis=1),
        cmap=colours_of(bar.codes), vmin=bar.levels[0], vmax=bar.levels[-1], shading="gouraud",
        rasterized=True,
    )  # fmt: skip
    rings = zip(
        seal.unit_plus.values, seal.unit_minus.values, seal.juxtaposition.values, strict=True
    )
    pale = {f"{plus} | {minus}" for plus, minus, kind in rings if kind != FACING}
    for words, line in lines:
        if words["kind"] == "juxtaposition" and words["label"] in pale:
            cover = artists.PathPatch(
                outline_of([line]), linewidth=0.0, facecolor=palette.PAPER, alpha=0.6
            )
            axes.add_artist(cover)
    draw_colour_bar(sheet, np.array(bar.levels), bar.words, bar.codes, N_BAND, (60.0, 220.0))
    return bar


def _legend_of_classes(seal: xarray.Dataset, bar: Bar) -> tuple[Entry, ...]:
    """Classes of the ratio, with their areas where reservoir faces reservoir."""
    facing = seal.juxtaposition.values == FACING
    areas = seal.class_area.values[facing].sum(axis=0)
    bounds = zip(seal.sgr_lower.values, seal.sgr_upper.values, strict=True)
    entries = [Entry("SGR", detail=FACING, kind="heading")]
    for (low, high), area in zip(bounds, area_texts(areas), strict=True):
        colour = shade_of(bar, 0.5 * (low + high))
        entries.append(Entry(f"{low:g} to {high:g}", colour, area))
    return tuple(entries)


def _draw_cutoffs(sheet: Sheet, axes: Axes, lines: list[Line]) -> None:
    """Draw cut-offs and contacts of both walls, with their names at the ends."""
    unit = sheet.layout.unit
    width = sheet.points(1.9)
    ends: dict[str, dict[tuple[str, str], float]] = {"+": {}, "-": {}}

    # a cut-off in several pieces is named at its outermost end only
    (left, right) = axes.get_xlim()
    reach: dict[tuple[str, str, str], float] = {}
    for words, line in lines:
        kind, side, name = words["kind"], words["side"], words["label"]
        if kind not in LINES:
            continue
        look: LineStyle = {"linestyle": (0, (4.0, 1.8))} if side == "+" else {}
        over = 2 if kind == "contact" else 3  # cut-offs are drawn over the halo of a contact
        if kind == "contact":
            axes.plot(*line.T, color=palette.PAPER, linewidth=HALO * width, zorder=over)
        axes.plot(*line.T, color=LINES[kind], linewidth=width, zorder=over, **look)

        # names go where the line ends: hanging wall on the left, footwall on the right
        to_left = -line[:, 0] if right > left else line[:, 0]
        outwards = to_left if side == "+" else -to_left
        end = int(np.argmax(outwards))
        outward, z = float(outwards[end]), line[end, 1]
        if outward > reach.get((side, kind, name), -np.inf):
            reach[side, kind, name], ends[side][kind, name] = outward, float(z)

    # names that would overlap are moved apart by a line of text
    height = np.diff(axes.get_ylim()).item() / axes.get_window_extent().height  # metres per pixel
    for side, x, offset, ha in (("+", left, -8.0, "right"), ("-", right, 8.0, "left")):
        names = sorted(ends[side], key=ends[side].__getitem__)
        levels = _spread([ends[side][name] for name in names], 14.0 * unit * height)
        labels = shortened_apart((name for _, name in names), 12)
        for (kind, name), z in zip(names, levels, strict=True):
            axes.annotate(
                labels[name], (x, z), (offset * unit, 0), annotation_clip=False,
                textcoords="offset pixels", ha=ha, va="center", family=FONT,
                fontsize=sheet.points(11.0), color=LINES[kind], parse_math=False,
            )  # fmt: skip


def _spread(levels: list[float], step: float) -> list[float]:
    """Levels, lowest first, moved as little as possible to have `step` between them.

    Examples
    --------
    >>> _spread([0.0, 0.5, 9.0], 2.0)
    [-0.75, 1.25, 9.0]
    """
    groups: list[tuple[float, int]] = []  # middle, number
    for level in levels:
        # neighbours that are too close merge into a group around their common mean
        # (pooled adjacent violators: the least squared shift)
        groups.append((level, 1))
        while len(groups) > 1:
            (a, m), (b, n) = groups[-2:]
            if b - a >= step * (m + n) / 2.0:
                break
            groups[-2:] = [((a * m + b * n) / (m + n), m + n)]
    return [a + step * (i - (n - 1) / 2.0) for a, n in groups for i in range(n)]


def _legend(
    pairs: dict[tuple[str, str], float], colours: dict[str, palette.RGB], outside: set[str]
) -> tuple[Entry, ...]:
    """Pairs of zones: those of the reservoir and different ones first, the largest area first."""
    # False sorts before True; what is outside on both walls is no pair of the reservoir
    order = sorted(
        (item for item in pairs.items() if not outside >= set(item[0])),
        key=lambda item: (bool(outside & set(item[0])), item[0][0] == item[0][1], -item[1]),
    )
    areas = area_texts(area for _, area in order)

    # a zone against itself has no stripes in the diagram, and none in the legend
    others = ["itself" if plus == minus else plus for (minus, plus), _ in order]
    details = [f"against {other}, {area}" for other, area in zip(others, areas, strict=True)]
    if max(map(len, details), default=0) > DETAIL_ROOM:  # names matter more than areas
        labels = shortened_apart(others, DETAIL_ROOM - len("against "))
        details = [f"against {labels[other]}" for other in others]
    return tuple(
        Entry(minus, colours[minus], detail, stripes=None if plus == minus else colours[plus])
        for ((minus, plus), _), detail in zip(order, details, strict=True)
    )
