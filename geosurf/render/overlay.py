"""Wells, polygons and data points on maps, sections and views: those of users, and well tops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import cycle, pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import checked_points, counted, grouped, length_text, palette
from geosurf.conventions.axes import COORDINATES, points_in
from geosurf.conventions.checks import lines_of_foreign, points_of_foreign
from geosurf.errors import InputError
from geosurf.model.expected import expect
from geosurf.render.diagram import highest_in_view
from geosurf.render.furniture import halo_text
from geosurf.render.layers import NAME_SIZE, Content, Entry, Layer, shortened_apart
from geosurf.render.sheet import Sheet

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes

    from geosurf.render.views import Camera


NEAR = 0.02  # of the length of a section: what is farther off is not drawn
WELL, POLYGON = palette.rgb("#1b1b1b"), palette.rgb("#5b2a86")
POINTS = palette.rgb("#b3005e"), palette.FAINT, palette.rgb("#1f6f8b")  # by group, in turn
AWAY = 8.0  # of a name from its point [design pixels]
DOT = 5.0  # diameter of data points [pixels]
RADIUS = 5.5  # of the circle of a top [design pixels]
SHOWN = 0.05  # m: a misfit below this is not written


# ---- what users add ----------------------------------------


def show_overlay(overlay: PictureOverlay, top: float) -> Content:
    """Return the overlay of a view; polygons without elevation lie at the top of the model."""
    layers, names = [], []
    for name, parts in overlay.wells.items():
        layers += [_line(part, WELL, 3.0) for part in parts]
        east, north, up = parts[0][0].tolist()
        names.append((name, (east, north, up)))
    for parts in overlay.polygons.values():
        for part in parts:
            high = part if part.shape[1] == 3 else np.column_stack([part, np.full(len(part), top)])
            layers.append(_line(_closed(high), POLYGON, 2.2))
    for colour, parts in zip(cycle(POINTS), overlay.points.values(), strict=False):
        layers += [Layer(part, colour=colour, width=DOT, dots=True) for part in parts]
    return Content(tuple(layers), _legend(overlay), tuple(names))


def _line(points: np.ndarray, colour: palette.RGB, width: float) -> Layer:
    return Layer(points, lines=(np.arange(len(points)),), colour=colour, width=width)


def _closed(ring: np.ndarray) -> np.ndarray:
    return np.vstack([ring, ring[:1]])


def _legend(overlay: PictureOverlay, near: str = "") -> tuple[Entry, ...]:
    """Entries of a picture with all of an overlay, and their numbers; or with what is near."""
    entries = []
    if overlay.wells:
        words = "wells" if near else counted(len(overlay.wells), "well")
        entries.append(Entry(words, WELL, near, "line"))
    for name in overlay.polygons:
        entries.append(Entry(name, POLYGON, "polygons", "line"))
    for colour, (name, parts) in zip(cycle(POINTS), overlay.points.items(), strict=False):
        count = counted(sum(map(len, parts)), "data point")
        entries.append(Entry(name, colour, near or count, "circle"))
    return tuple(entries)


def draw_names(
    sheet: Sheet, camera: Camera, names: Sequence[tuple[str, tuple[float, float, float]]]
) -> None:
    """Write names next to points of a view; one that finds no room is left out."""
    low = np.array([sheet.layout.left, sheet.layout.bottom], dtype=np.float64)
    labels = shortened_apart(name for name, _ in names)
    for name, point in names:
        at = camera.to_pixels(np.array(point)) + low
        if (at >= low).all() and (at <= low + sheet.layout.view_size).all():
            name_place(sheet, sheet.axes, at, labels[name], NAME_SIZE)


def draw_on_map(sheet: Sheet, axes: Axes, overlay: PictureOverlay) -> list[Entry]:
    """Draw the overlay in world coordinates; return the entries of the legend."""
    for parts in overlay.polygons.values():
        for part in parts:
            _plot(sheet, axes, _closed(part)[:, :2], POLYGON)
    for colour, parts in zip(cycle(POINTS), overlay.points.values(), strict=False):
        for part in parts:
            _dots(sheet, axes, part[:, :2], colour)
    for parts in overlay.wells.values():
        for part in parts:
            _plot(sheet, axes, part[:, :2], WELL)
    _mark(sheet, axes, {name: parts[0][0, :2] for name, parts in overlay.wells.items()})
    for words, parts in overlay.labels.items():
        for x, y in np.concatenate(parts)[:, :2].tolist():
            at = _free_spot(sheet, axes, (x, y), words)
            halo_text(sheet, axes, at, words, 15.0, fontweight="bold", zorder=7.0)
    return list(_legend(overlay))


def _free_spot(sheet: Sheet, axes: Axes, at: tuple[float, float], words: str) -> np.ndarray:
    """The nearest place for a label at which it covers no other name; as given if there is none."""
    (x, y), (wide, high) = axes.transData.transform(at), sheet.text_size(words, 15.0, "bold")
    for far in (0.0, 1.0, 2.0, 3.0):
        for right, up in ((0, 0), (0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, -1)):
            u, v = x + far * right * wide, y + far * up * 1.5 * high
            box = (u - 0.5 * wide, v - 0.5 * high, u + 0.5 * wide, v + 0.5 * high)
            if sheet.names.take(box):
                return axes.transData.inverted().transform((u, v))
    return np.array(at)


def draw_on_section(
    sheet: Sheet, axes: Axes, overlay: PictureOverlay, line: np.ndarray
) -> list[Entry]:
    """Draw what is near a section, projected to it; return the entries of the legend.

    Polygons are drawn where they cross the section, as short bars at their elevation.
    """
    near = _near(line)
    for colour, parts in zip(cycle(POINTS), overlay.points.values(), strict=False):
        for part in parts:
            flat, far = _projected(part, line)
            _dots(sheet, axes, flat[far <= near], colour)
    heads: dict[str, np.ndarray] = {}
    bottom, top = sorted(axes.get_ylim())
    for name, parts in overlay.wells.items():
        for part in parts:
            flat, far = _projected(part, line)
            # stretches of the well that are near
            for rows in np.split(np.arange(len(part)), np.flatnonzero(np.diff(far <= near)) + 1):
                if far[rows[0]] > near:
                    continue
                _plot(sheet, axes, flat[rows], WELL)
                head = highest_in_view(flat[rows], bottom, top)
                if head is not None:
                    heads.setdefault(name, head)
    for parts in overlay.polygons.values():
        for part in parts:
            for along, up in _crossings(_closed(part), line):
                # an upright bar, at the top of the section without an elevation
                axes.plot(
                    [along], [top if up is None else up], marker="|", color=POLYGON, zorder=6.0,
                    markersize=14.0 * sheet.layout.unit, markeredgewidth=2.0 * sheet.layout.unit,
                    clip_on=up is not None,
                )  # fmt: skip
    _mark(sheet, axes, heads)
    return list(_legend(overlay, f"within {length_text(near)}"))


def _near(line: np.ndarray) -> float:
    """How far from a section things may be that are drawn on it [m]."""
    return NEAR * float(np.hypot(*np.diff(line, axis=0).T).sum())


def _projected(points: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance along a line and elevation (n, 2) of points, and how far off each is [m]."""
    ends = np.diff(line, axis=0)
    lengths = np.hypot(*ends.T)
    starts = np.concatenate([[0.0], np.cumsum(lengths)])[:-1]

    # (n_point, n_leg): the nearest place of each leg
    to = points[:, None, :2] - line[:-1]
    share = np.clip((to * ends).sum(axis=2) / lengths**2, 0.0, 1.0)
    far = np.linalg.norm(to - share[..., None] * ends, axis=2)
    leg = far.argmin(axis=1)
    rows = np.arange(len(points))
    along = starts[leg] + share[rows, leg] * lengths[leg]
    return np.column_stack([along, points[:, 2]]), far[rows, leg]


def _crossings(ring: np.ndarray, line: np.ndarray) -> list[tuple[float, float | None]]:
    """Distance along a line at which a ring crosses it, and the elevation there, if it has one."""
    crossings, start = [], 0.0
    for p, q in pairwise(line):
        length = float(np.hypot(*(q - p)))
        a, step = ring[:-1], np.diff(ring, axis=0)
        normal = np.array([-(q - p)[1], (q - p)[0]])
        off = (a[:, :2] - p) @ normal
        change = step[:, :2] @ normal
        for k in np.flatnonzero((off > 0.0) != (off + change > 0.0)):
            place = a[k] - step[k] * off[k] / change[k]
            share = float((place[:2] - p) @ (q - p)) / length**2
            if 0.0 <= share <= 1.0:
                up = float(place[2]) if len(place) == 3 else None
                crossings.append((start + share * length, up))
        start += length
    return crossings


def _plot(sheet: Sheet, axes: Axes, points: np.ndarray, colour: palette.RGB) -> None:
    """A line with a white rim, without changing the limits of the axes."""
    limits = axes.axis()
    for wide, ink in ((3.4, palette.PAPER), (1.8, colour)):
        axes.plot(*points.T, color=ink, linewidth=sheet.points(wide), zorder=5.0)
    axes.axis(limits)


def _dots(sheet: Sheet, axes: Axes, points: np.ndarray, colour: palette.RGB) -> None:
    limits, size = axes.axis(), sheet.points(DOT)
    axes.plot(
        *points.T, linestyle="none", marker="o", markersize=size, color=colour, zorder=5.5,
        markeredgecolor=palette.PAPER, markeredgewidth=0.1 * size,
    )  # fmt: skip
    axes.axis(limits)


def _mark(sheet: Sheet, axes: Axes, heads: Mapping[str, np.ndarray]) -> None:
    """Mark the heads of wells and write their names, none over another."""
    labels, size = shortened_apart(heads), sheet.points(8.0)
    for name, place in heads.items():
        if _is_inside(axes, place):
            axes.plot(
                *place, marker="o", markersize=size, color=palette.PAPER, markeredgecolor=WELL,
                markeredgewidth=0.2 * size, zorder=6.0,
            )  # fmt: skip
            name_place(sheet, axes, place, labels[name], NAME_SIZE)


def _is_inside(axes: Axes, place: np.ndarray) -> bool:
    """Whether a place is inside the axes."""
    (west, east), (south, north) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
    return bool(west <= place[0] <= east and south <= place[1] <= north)


# ---- well tops ----------------------------------------
# A circle at each top of `Scene.misfit`, with the name of the well.


@dataclass(frozen=True, eq=False)
class WellTop:
    """One top on a picture.

    Attributes
    ----------
    well, horizon : str
    place : ndarray of float64, shape (2,)
        Where it is drawn, in the coordinates of the axes [m].
    misfit : float
        Model minus top [m]; NaN without a value.
    """

    well: str
    horizon: str
    place: np.ndarray
    misfit: float


def tops_on_map(misfit: Any, horizon: str) -> list[WellTop]:
    """Return the tops of one horizon of the result of `Scene.misfit`, in world coordinates."""
    rows, places = _rows(misfit)
    tops = (WellTop(*row[:2], at[:2], row[2]) for row, at in zip(rows, places, strict=True))
    return [top for top in tops if top.horizon == horizon]


def tops_on_section(misfit: Any, line: np.ndarray) -> tuple[list[WellTop], float]:
    """
    Return tops near a section, by distance along it and elevation, and how near they are.

    Parameters
    ----------
    misfit : xarray.Dataset
        Result of `Scene.misfit`.
    line : ndarray of float64, shape (n, 2)
        Corners of the section [m].

    Returns
    -------
    (list of WellTop, float)
        Tops, and the distance within which they are [m].
    """
    rows, places = _rows(misfit)
    near, (flat, far) = _near(line), _projected(places, line)
    found = zip(rows, flat, far, strict=True)
    return [WellTop(*row[:2], at, row[2]) for row, at, off in found if off <= near], near


def _rows(misfit: Any) -> tuple[list[tuple[str, str, float]], np.ndarray]:
    """Well, horizon and misfit of each top, and the places (n, 3)."""
    columns = ("well", "horizon", "easting", "northing", "picked", "misfit")
    wells, horizons, *places, off = (misfit[name].values for name in columns)
    rows = zip(map(str, wells), map(str, horizons), map(float, off), strict=True)
    return list(rows), np.column_stack(places).astype(np.float64)


def draw_wells_on_map(sheet: Sheet, axes: Axes, tops: Sequence[WellTop]) -> list[Entry]:
    """Draw tops at their places; return the entry of the legend."""
    shown = [top for top in tops if _is_inside(axes, top.place)]
    if not shown:
        return []

    # room for all circles first: a name may hide neither circles nor other names
    room = (RADIUS + 2.0) * sheet.layout.unit
    for top in shown:
        x, y = axes.transData.transform(top.place)
        sheet.names.taken.append(np.array([x - room, y - room, x + room, y + room]))
    for top in shown:
        _circle(sheet, axes, top.place, palette.PAPER)
        words = top.well
        if np.isfinite(top.misfit) and abs(top.misfit) >= SHOWN:
            words += f" {top.misfit:+.1f}".replace("-", "\N{MINUS SIGN}")
        name_place(sheet, axes, top.place, words)

    # the legend states the largest misfit, unless it is below what is written
    known = [abs(top.misfit) for top in shown if np.isfinite(top.misfit)]
    detail = f"misfit up to {length_text(max(known))}" if known else "no misfit"
    if known and max(known) < SHOWN:
        detail = f"misfit below {length_text(SHOWN)}"
    return [Entry(counted(len(shown), "well top"), palette.INK, detail, "circle")]


def draw_wells_on_section(
    sheet: Sheet, axes: Axes, tops: Sequence[WellTop], near: float, colours: dict[str, palette.RGB]
) -> list[Entry]:
    """Draw each well through its tops, named above; return the entry of the legend."""
    # tops by well, those in view only, from the top down: the line of a well joins them
    bottom, above = sorted(axes.get_ylim())
    shown = [top for top in tops if bottom <= top.place[1] <= above]
    wells = grouped((top.well, top) for top in sorted(shown, key=lambda top: -top.place[1]))
    if not wells:
        return []

    # no name crosses the line of another well
    unit = sheet.layout.unit
    heads = {well: np.array([well_tops[0].place[0], above]) for well, well_tops in wells.items()}
    for head in heads.values():
        x, y = axes.transData.transform(head)
        sheet.names.taken.append(np.array([x - 2.0 * unit, y - 60.0 * unit, x + 2.0 * unit, y]))
    for well, well_tops in wells.items():
        # a white line below parts the well from zones and cut-offs
        path = np.array([heads[well], *(top.place for top in well_tops)])
        for width, colour in ((3.0, palette.PAPER), (1.3, palette.INK)):
            axes.plot(*path.T, color=colour, linewidth=sheet.points(width))
        for top in well_tops:
            _circle(sheet, axes, top.place, colours.get(top.horizon, palette.PAPER))
        name_place(sheet, axes, heads[well], well, hanging=True)
    near_words = f"within {length_text(near)} of the section"
    return [Entry(counted(len(wells), "well"), palette.INK, near_words, "circle")]


def _circle(sheet: Sheet, axes: Axes, place: np.ndarray, fill: palette.RGB) -> None:
    """A filled circle with a dark rim and a white one around it."""
    white = (RADIUS + 1.5, palette.PAPER, palette.PAPER)
    for radius, face, edge in (white, (RADIUS, fill, palette.INK)):
        axes.plot(
            [place[0]], [place[1]], marker="o", markersize=sheet.points(2.0 * radius),
            markerfacecolor=face, markeredgecolor=edge, markeredgewidth=sheet.points(1.6),
            linestyle="none", zorder=6.0, clip_on=False,
        )  # fmt: skip


def name_place(
    sheet: Sheet,
    axes: Axes,
    place: np.ndarray,
    words: str,
    size: float = 11.5,
    *,
    hanging: bool = False,
) -> None:
    """Write a name next to a place of the axes, where no other name is; else it is left out."""
    x, y = axes.transData.transform(place)
    wide, high = sheet.text_size(words, size, "bold")
    away = (RADIUS + AWAY - 3.0) * sheet.layout.unit

    # lower left corners to try, the best first; names hang from the upper end of a section
    sides = (x + away, x - away - wide)
    corners = [(left, y - drop * high) for drop in (1.5, 2.6, 3.7) for left in sides]
    if not hanging:
        levels = (y - 0.5 * high, y - away - high)
        middle = x - 0.5 * wide
        above_and_below = [(middle, y + away), (middle, y - away - high)]
        corners = [*((left, levels[0]) for left in sides), *above_and_below]
        corners += [(left, levels[1]) for left in sides]
    at = sheet.names.place(corners, wide, high, axes.transAxes.transform([(0.0, 0.0), (1.0, 1.0)]))
    if at is not None:
        spot = axes.transData.inverted().transform((at[0], at[1] + 0.5 * high))
        halo_text(sheet, axes, spot, words, size, ha="left", fontweight="bold", zorder=7.0)


# ---- nouns ----------------------------------------


Parts = dict[str, tuple[np.ndarray, ...]]


@dataclass(frozen=True, eq=False)
class PictureOverlay:
    """What is drawn on top of a model.

    Parameters
    ----------
    wells : mapping of str to array_like of float, shape (n, 3)
        Path of each well, from the top down [m]; also results of `read_points`. Or a table with
        a column ``well``, as `read_wells` returns it.
    polygons : mapping of str to array_like of float, shape (n, 2) or (n, 3)
        Closed lines, or a list of them, by name, such as results of `read_polygons` and
        `Scene.fault_polygons` [m], or lines and polygons of geopandas and shapely. One whose elevations are all 0 has no elevation.
    points : mapping of str to array_like of float, shape (n, 3)
        Data points by name, such as results of `read_points` [m].
    labels : mapping of str to array_like of float, shape (n, 2) or (n, 3)
        Words that maps have at places, such as results of `Scene.region_labels` [m].

    Raises
    ------
    InputError
        For coordinates of another shape, or values that are not finite.

    Examples
    --------
    >>> PictureOverlay(wells={"W1": [[0, 0, 0], [0, 50, -900]]}).wells["W1"][0].shape
    (2, 3)
    >>> PictureOverlay(points={"picks": [1, 2, 3]})
    Traceback (most recent call last):
    geosurf.errors.InputError: points['picks'] has shape (3,), expected (n, 3). Give easting, northing, elevation [m].
    """  # noqa: E501 - a message

    wells: Mapping[str, Any] = field(default_factory=dict)
    polygons: Mapping[str, Any] = field(default_factory=dict)
    points: Mapping[str, Any] = field(default_factory=dict)
    labels: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        # a table of many wells, as `read_wells` returns it
        object.__setattr__(self, "wells", _wells_of_table(self.wells))
        # all coordinates as tuples of arrays, so that pictures need not look at them
        kinds = ("wells", (3,)), ("polygons", (2, 3)), ("points", (3,)), ("labels", (2, 3))
        for what, widths in kinds:
            object.__setattr__(self, what, _checked(what, getattr(self, what), widths))

    def __bool__(self) -> bool:
        return bool(self.wells or self.polygons or self.points or self.labels)


def overlay_of(overlay: Any) -> PictureOverlay:
    """Return the overlay, or an empty one for None.

    Raises
    ------
    InputError
        For anything else.
    """
    if overlay is None:
        return NOTHING
    how = "pass gs.PictureOverlay(wells={'W1': points})"
    expect(overlay, PictureOverlay, "overlay must be a PictureOverlay", how)
    made: PictureOverlay = overlay
    return made


def _wells_of_table(table: Any) -> Any:
    """Paths by the names of the wells of a table; anything else as it is."""
    is_table = hasattr(table, "data_vars") or hasattr(table, "columns")
    if not (is_table and all(name in table for name in (*COORDINATES, "well"))):
        return table
    names = [str(name) for name in np.asarray(table["well"]).tolist()]
    points = points_in(table).astype(np.float64)
    column = np.array(names, dtype=object)
    return {name: points[column == name] for name in dict.fromkeys(names)}


def _checked(what: str, given: Any, widths: tuple[int, ...]) -> Parts:
    """Coordinates by name, each a tuple of arrays (n, 2) or (n, 3)."""
    if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given):
        raise InputError(
            f"{what} is a {type(given).__name__}, expected a mapping of names to coordinates."
        )
    return {name: _parts(f"{what}[{name!r}]", value, widths) for name, value in given.items()}


def _parts(what: str, value: Any, widths: tuple[int, ...]) -> tuple[np.ndarray, ...]:
    """The arrays of one entry: a dataset with columns, one array, or a list of arrays."""
    how = f"Give {', '.join(COORDINATES[: widths[-1]])} [m]."
    if all(hasattr(value, name) for name in COORDINATES):
        columns = [np.asarray(getattr(value, name), dtype=np.float64) for name in COORDINATES]
        whole = np.stack(columns, axis=1)
        ends = np.cumsum(value["count"].values)[:-1] if hasattr(value, "line_of_point") else ()
        return tuple(np.split(whole, ends))
    try:
        foreign = (points_of_foreign if widths == (3,) else lines_of_foreign)(value)
    except ValueError as error:
        raise InputError(f"{what}: {error}. {how}") from error
    if foreign is not None:
        value = foreign
    listed = value if isinstance(value, list | tuple) else [value]
    single = isinstance(value, np.ndarray) or np.ndim(listed[0] if listed else 0) < 2
    parts = []
    for one in [value] if single else listed:
        points = checked_points(one, what, how, widths=widths, least=1)
        # files of outlines have 0 where they have no elevation
        flat = widths[0] == 2 and points.shape[1] == 3 and not points[:, 2].any()
        parts.append(points[:, :2] if flat else points)
    return tuple(parts)


NOTHING = PictureOverlay()  # at the end: it is checked by the functions above
