"""Allan diagram of a fault: what lies across it from what, seen along its strike.

After Allan (1989), AAPG Bulletin 73, 803-811: the fault is drawn over distance along strike and
elevation, with the cut-offs of its footwall as full lines and those of its hanging wall dashed.
An area has the colour of the zone in the footwall; stripes in the colour of the zone in the
hanging wall say that it is another one. Fluid contacts are blue lines in the same two styles,
each wall with its own. What lies far above and below all these lines faces itself, and is not
shown.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geosurf.errors import InputError
from geosurf.model.expected import listed, name_of
from geosurf.render import furniture, palette
from geosurf.render.compose import png_path, save_png
from geosurf.render.diagram import diagram_axes, lines_of, outline_of, range_shown
from geosurf.render.layers import Entry
from geosurf.render.views import check_size

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

LINES = {"cut-off": palette.INK, "contact": palette.CONTACT}  # kinds that are drawn as lines
ROOM = 96.0  # for names of cut-offs at both sides [design pixels]
HALO = 1.9  # width of the paper around a contact over its own, so that it is seen on any zone


def render_allan(
    diagram: xarray.Dataset,
    table: xarray.Dataset,
    path: str | os.PathLike[str],
    *,
    zones: Sequence[str] = (),
    size: tuple[int, int] = (1280, 800),
    title: str | None = None,
) -> Path:
    """Draw the Allan diagram of a fault, with the areas of zones that face each other.

    Parameters
    ----------
    diagram : xarray.Dataset
        What `Scene.allan` gives.
    table : xarray.Dataset
        What `Scene.juxtaposition` gives for the same fault: areas for the legend.
    path : path-like
        A ``.png`` file; its folder is created.
    zones : sequence of str
        Youngest first: zones take the colours of the column in that order, as in
        `render_units`. Default: as they come.
    size : (int, int)
        Width and height in pixels.
    title : str, optional
        Default: the name of the fault and its strike.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If diagram and table are of different faults, or there is nothing to draw.
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> import geosurf as gs
    >>> world = gs.synthetic.graben(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     shown = scene.allan("F1"), scene.juxtaposition("F1")
    ...     render_allan(*shown, f"{folder}/allan.png", size=(400, 250)).name
    'allan.png'
    """
    path = png_path(path)
    _check(diagram, table)
    how = "give a list of names, as Scene.juxtaposition has them"
    zones = [name_of(zone, "zone") for zone in listed(zones, "zones are names of zones", how)]
    pairs = _areas_of_pairs(table)
    seen = dict.fromkeys(zone for pair in pairs for zone in pair)
    order = [*zones, *(zone for zone in seen if zone not in zones)]
    colours = {zone: palette.stratum(i) for i, zone in enumerate(order)}
    lines = lines_of(diagram, ("along_strike", "elevation"), ("kind", "side", "label", "zone"))
    sheet = furniture.Sheet(furniture.lay_out(check_size(size)))
    levels = [line[:, 1] for words, line in lines if words["kind"] in LINES]
    points = np.concatenate([line for _, line in lines])
    shown = range_shown(points, levels)
    axes, exaggeration = diagram_axes(sheet, shown, "Distance along strike [km]", ROOM)
    _fill(axes, lines, colours)
    _draw_cutoffs(sheet, axes, lines)
    furniture.draw_legend(sheet, _legend(pairs, colours), 640.0)
    blue = " Fluid contacts are blue." if (diagram.kind == "contact").any() else ""
    words = (
        "Footwall cut-offs and their names at the right: full lines; hanging wall, at the left: "
        f"dashed.{blue} Areas are of the whole fault. Vertical exaggeration {exaggeration:.2g}×."
    )
    strike = float(diagram.attrs["strike"])
    words_above = f"{diagram.attrs['fault']}: Allan diagram, strike {strike:03.0f}°"
    furniture.draw_words(sheet, words_above if title is None else title, words)
    return save_png(sheet.png(), path)


def _check(diagram: xarray.Dataset, table: xarray.Dataset) -> None:
    for given, maker, names in (
        (diagram, "Scene.allan", ("kind", "along_strike", "elevation", "count")),
        (table, "Scene.juxtaposition", ("zone_minus", "zone_plus", "area")),
    ):
        if not hasattr(given, "attrs") or any(not hasattr(given, name) for name in names):
            raise InputError(
                f"render_allan takes what {maker} gives, not {type(given).__name__} without "
                f"{', '.join(names)}."
            )
    one, two = diagram.attrs.get("fault"), table.attrs.get("fault")
    if one != two:
        raise InputError(
            f"the diagram is of fault {one!r} and the table of {two!r}; hand over "
            "Scene.allan and Scene.juxtaposition of one fault."
        )
    if not (diagram.kind == "juxtaposition").any():
        raise InputError(
            f"nothing lies across fault {one!r}: it has the model on one side only. "
            "Enlarge the box, or leave its diagram out."
        )


def _areas_of_pairs(table: xarray.Dataset) -> dict[tuple[str, str], float]:
    """Area [m2] of each pair of zones: footwall first."""
    pairs: dict[tuple[str, str], float] = {}
    columns = (table.zone_minus.values, table.zone_plus.values, table.area.values)
    for minus, plus, area in zip(*columns, strict=True):
        key = (str(minus), str(plus))
        pairs[key] = pairs.get(key, 0.0) + float(area)
    return pairs


def _fill(axes, lines, colours: dict[str, palette.RGB]) -> None:
    """Areas of contact: footwall in full colour, hanging wall as stripes."""
    from matplotlib.patches import PathPatch

    rings: dict[str, tuple[str, list[np.ndarray]]] = {}
    for words, line in lines:
        if words["kind"] == "juxtaposition":
            rings.setdefault(words["label"], (words["zone"], []))[1].append(line)
    for pair, parts in rings.values():
        plus, minus = pair.split(" | ")
        outline = outline_of(parts)
        # the edge closes the seam between neighbours
        look = {"facecolor": colours[minus], "edgecolor": colours[minus], "linewidth": 0.4}
        axes.add_patch(PathPatch(outline, **look))
        if plus != minus:
            look = {"hatch": furniture.STRIPES, "edgecolor": colours[plus], "linewidth": 0.0}
            stripes = axes.add_patch(PathPatch(outline, facecolor="none", **look))
            stripes.set_hatch_linewidth(furniture.STRIPE_WIDTH)


def _draw_cutoffs(sheet, axes, lines) -> None:
    """Cut-offs and contacts of both walls, and their names at their ends."""
    unit = sheet.layout.unit
    width = 1.9 * unit * 72.0 / furniture.DPI
    ends: dict[str, dict[tuple[str, str], float]] = {"+": {}, "-": {}}
    reach: dict[tuple[str, str, str], float] = {}
    for words, line in lines:
        kind, side, name = words["kind"], words["side"], words["label"]
        if kind not in LINES:
            continue
        look = {"linestyle": (0, (4.0, 1.8))} if side == "+" else {}
        over = 2 if kind == "contact" else 3  # cut-offs run on over the halo of a contact
        if kind == "contact":
            axes.plot(*line.T, color=palette.PAPER, linewidth=HALO * width, zorder=over)
        axes.plot(*line.T, color=LINES[kind], linewidth=width, zorder=over, **look)
        s, z = line[np.argmin(line[:, 0]) if side == "+" else np.argmax(line[:, 0])]
        outward = -s if side == "+" else s
        if outward > reach.get((side, kind, name), -np.inf):
            reach[side, kind, name], ends[side][kind, name] = outward, float(z)
    height = np.diff(axes.get_ylim()).item() / axes.get_window_extent().height  # metres per pixel
    (left, right) = axes.get_xlim()
    for side, x, offset, ha in (("+", left, -8.0, "right"), ("-", right, 8.0, "left")):
        names = sorted(ends[side], key=ends[side].__getitem__)
        levels = _spread([ends[side][name] for name in names], 14.0 * unit * height)
        for (kind, name), z in zip(names, levels, strict=True):
            axes.annotate(
                furniture.shortened(name, 12), (x, z), (offset * unit, 0), annotation_clip=False,
                textcoords="offset pixels", ha=ha, va="center", family=furniture.FONT,
                fontsize=11.0 * unit * 72.0 / furniture.DPI, color=LINES[kind], parse_math=False,
            )  # fmt: skip


def _spread(levels: list[float], step: float) -> list[float]:
    """Levels, lowest first, moved up and down as little as leaves `step` between them.

    Examples
    --------
    >>> _spread([0.0, 0.5, 9.0], 2.0)
    [-0.75, 1.25, 9.0]
    """
    groups: list[tuple[float, int]] = []  # middle, number
    for level in levels:
        groups.append((level, 1))
        while len(groups) > 1:
            (a, m), (b, n) = groups[-2:]
            if b - a >= step * (m + n) / 2.0:
                break
            groups[-2:] = [((a * m + b * n) / (m + n), m + n)]
    return [a + step * (i - (n - 1) / 2.0) for a, n in groups for i in range(n)]


def _legend(pairs: dict[tuple[str, str], float], colours) -> tuple[Entry, ...]:
    """Pairs of zones, the largest contact between different ones first."""
    legend = []
    order = sorted(pairs.items(), key=lambda item: (item[0][0] == item[0][1], -item[1]))
    for (minus, plus), area in order:
        other = furniture.shortened(plus, 15) if plus != minus else "itself"
        detail = f"against {other}, {area_text(area)}"
        stripes = None if plus == minus else colours[plus]
        legend.append(Entry(minus, colours[minus], detail, stripes=stripes))
    return tuple(legend)


def area_text(square_metres: float) -> str:
    """Return an area as people write it.

    Examples
    --------
    >>> area_text(1_234_000.0), area_text(5300.0)
    ('1.23 km²', '5,300 m²')
    """
    if square_metres >= 1e4:
        return f"{square_metres / 1e6:.3g} km²"
    return f"{square_metres:,.0f} m²"
