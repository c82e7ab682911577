"""Draw wells on maps and sections: a circle at each top, with the name of the well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import counted, length_text
from geosurf.errors import InputError
from geosurf.render import furniture, palette
from geosurf.render.layers import Entry

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes

RADIUS = 5.5  # of a circle [design pixels]
SHOWN = 0.05  # m: a misfit below this is not written
NEAR = 0.02  # of the length of a section: wells farther off are not drawn
_NEEDED = ("well", "horizon", "easting", "northing", "picked", "misfit")


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
    return [
        WellTop(well, name, place[:2], off)
        for well, name, place, off in _rows(misfit)
        if name == horizon
    ]


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
    # starts: distance along the section at which each leg begins
    ends = np.diff(line, axis=0)
    lengths = np.hypot(*ends.T)
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    near = NEAR * float(starts[-1])
    found = []
    for well, name, place, off in _rows(misfit):
        # the nearest point of each leg
        share = ((place[:2] - line[:-1]) * ends).sum(axis=1) / lengths**2
        share = np.clip(share, 0.0, 1.0)
        far = np.hypot(*(line[:-1] + share[:, None] * ends - place[:2]).T)
        leg = int(far.argmin())
        if far[leg] <= near:
            along = float(starts[leg] + share[leg] * lengths[leg])
            found.append(WellTop(well, name, np.array([along, place[2]]), off))
    return found, near


def draw_wells_on_map(sheet: furniture.Sheet, axes: Axes, tops: Sequence[WellTop]) -> list[Entry]:
    """Draw tops at their places; return the entry of the legend."""
    shown = [top for top in tops if _inside(axes, top.place)]

    # boxes of all circles first, in pixels: a name may hide neither circles nor other names
    room = (RADIUS + 2.0) * sheet.layout.unit
    taken = sheet.names.taken
    taken += [_box(axes, top.place, (room, room, room)) for top in shown]
    for top in shown:
        place = top.place
        _circle(sheet, axes, place, palette.PAPER)
        words = top.well
        if np.isfinite(top.misfit) and abs(top.misfit) >= SHOWN:
            words += f" {top.misfit:+.1f}".replace("-", "\N{MINUS SIGN}")
        _name(sheet, axes, place, words, taken)
    if not shown:
        return []

    # the legend states the largest misfit, unless it is below what is written
    off = np.array([top.misfit for top in shown])
    known = off[np.isfinite(off)]
    detail = f"misfit up to {length_text(np.abs(known).max())}" if len(known) else "no misfit"
    if len(known) and np.abs(known).max() < SHOWN:
        detail = f"misfit below {length_text(SHOWN)}"
    return [Entry(counted(len(shown), "well top"), palette.INK, detail, "circle")]


def draw_wells_on_section(
    sheet: furniture.Sheet,
    axes: Axes,
    tops: Sequence[WellTop],
    near: float,
    colours: dict[str, palette.RGB],
) -> list[Entry]:
    """Draw each well through its tops, named above; return the entry of the legend."""
    # tops by well, those in view only, from the top down: the line of a well joins them
    wells: dict[str, list[WellTop]] = {}
    bottom, above = sorted(axes.get_ylim())
    for top in tops:
        if bottom <= top.place[1] <= above:
            wells.setdefault(top.well, []).append(top)
    unit = sheet.layout.unit
    for mine in wells.values():
        mine.sort(key=lambda top: -top.place[1])

    # no name crosses the line of another well
    heads = [np.array([mine[0].place[0], above]) for mine in wells.values()]
    taken = sheet.names.taken
    taken += [_box(axes, head, (2.0 * unit, 60.0 * unit, 0.0)) for head in heads]
    for well, mine in wells.items():
        head = np.array([mine[0].place[0], above])
        path = np.array([head, *(top.place for top in mine)])

        # a white line below parts the well from zones and cut-offs
        for width, colour in ((3.0, palette.PAPER), (1.3, palette.INK)):
            axes.plot(*path.T, color=colour, linewidth=width * unit * 72.0 / furniture.DPI)
        for top in mine:
            _circle(sheet, axes, top.place, colours.get(top.horizon, palette.PAPER))
        _name(sheet, axes, head, well, taken, below=True)
    if not wells:
        return []
    return [Entry(counted(len(wells), "well"), palette.INK, _within(near), "circle")]


def _within(near: float) -> str:
    return f"within {length_text(near)} of the section"


def _rows(misfit: Any) -> list[tuple[str, str, np.ndarray, float]]:
    """Well, horizon, place (3,) and misfit of each top, or an InputError."""
    if any(not hasattr(misfit, name) for name in _NEEDED):
        raise InputError(
            f"tops of a picture are the result of Scene.misfit, not {type(misfit).__name__}. Pass "
            "scene.misfit(tops)."
        )
    columns = (misfit[name].values.tolist() for name in _NEEDED)
    return [
        (str(well), str(horizon), np.array([east, north, up]), float(off))
        for well, horizon, east, north, up, off in zip(*columns, strict=True)
    ]


def _box(axes: Axes, place: np.ndarray, room: tuple[float, float, float]) -> np.ndarray:
    """Left, bottom, right, top around a place [pixels], so far to both sides, down and up."""
    x, y = axes.transData.transform(place)
    wide, down, up = room
    return np.array([x - wide, y - down, x + wide, y + up])


def _inside(axes: Axes, place: np.ndarray) -> bool:
    """Whether a place is inside the axes."""
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    return bool(west <= place[0] <= east and south <= place[1] <= north)


def _circle(sheet: furniture.Sheet, axes: Axes, place: np.ndarray, fill: palette.RGB) -> None:
    """A filled circle with a dark rim and a white one around it."""
    per = sheet.layout.unit * 72.0 / furniture.DPI
    for radius, face, edge in ((RADIUS + 1.5, palette.PAPER, palette.PAPER),
                               (RADIUS, fill, palette.INK)):  # fmt: skip
        axes.plot(
            [place[0]], [place[1]], marker="o", markersize=2.0 * radius * per,
            markerfacecolor=face, markeredgecolor=edge, markeredgewidth=1.6 * per,
            linestyle="none", zorder=6.0, clip_on=False,
        )  # fmt: skip


def _name(
    sheet: furniture.Sheet,
    axes: Axes,
    place: np.ndarray,
    words: str,
    taken: list[np.ndarray],
    *,
    below: bool = False,
) -> None:
    """Write a name next to a place, unless another one is there: right, left, above or below."""
    unit = sheet.layout.unit
    at = axes.transData.transform(place)
    wide, high = 7.2 * len(words) * unit, 15.0 * unit
    away = (RADIUS + 5.0) * unit

    # places to try, the best first: offset in pixels, and how the text is aligned there
    sides: list[tuple[tuple[float, float], str]] = [
        ((away, 0.0), "left"),
        ((-away, 0.0), "right"),
        ((0.0, away + 0.5 * high), "center"),
        ((0.0, -away - 0.5 * high), "center"),
    ]
    if below:  # names hang from the upper end of a section
        drops = (-0.7 * high, -1.7 * high, -2.7 * high)
        sides = [((dx, drop), side) for drop in drops for (dx, _), side in sides[:2]]
    low, up = axes.transAxes.transform([(0.0, 0.0), (1.0, 1.0)])
    for (dx, dy), side in sides:
        x, y = at[0] + dx, at[1] + dy

        # the box of the name on this side; the first free one inside the axes is taken, or none
        left = x - {"left": 0.0, "right": wide, "center": 0.5 * wide}[side]
        box = np.array([left, y - 0.5 * high, left + wide, y + 0.5 * high])
        free = all(
            box[2] < one[0] or box[0] > one[2] or box[3] < one[1] or box[1] > one[3]
            for one in taken
        )
        if free and box[0] >= low[0] and box[2] <= up[0]:
            taken.append(box)
            spot = axes.transData.inverted().transform((x, y))
            furniture.halo_text(
                sheet, axes, spot, words, 11.5, ha=side, fontweight="bold", zorder=7.0
            )
            return
