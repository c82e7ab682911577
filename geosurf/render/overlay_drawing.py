"""Overlays drawn into views, on maps and on sections: lines, dots, names and legends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions import counted, length_text
from geosurf.render import furniture, palette
from geosurf.render.diagram import highest_in_view
from geosurf.render.layers import Content, Entry, Layer
from geosurf.render.names import NAME_SIZE, Room, shortened_apart
from geosurf.render.overlay import PictureOverlay

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes

    from geosurf.render.views import Camera

NEAR = 0.02  # of the length of a section: what is farther off is not drawn
WELL, POLYGON, POINT = palette.rgb("#1b1b1b"), palette.rgb("#5b2a86"), palette.rgb("#b3005e")
AWAY = 7.0  # of a name from its point [design pixels]
DOT = 5.0  # diameter of data points [pixels]


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
    for parts in overlay.points.values():
        layers += [Layer(part, colour=POINT, width=DOT, dots=True) for part in parts]
    return Content(tuple(layers), _legend(overlay), tuple(names))


def _line(points: np.ndarray, colour: palette.RGB, width: float) -> Layer:
    return Layer(points, lines=(np.arange(len(points)),), colour=colour, width=width)


def _closed(ring: np.ndarray) -> np.ndarray:
    return np.vstack([ring, ring[:1]])


def _legend(overlay: PictureOverlay, detail: str = "") -> tuple[Entry, ...]:
    entries = []
    if overlay.wells:
        entries.append(Entry(counted(len(overlay.wells), "well"), WELL, detail, "line"))
    for name in overlay.polygons:
        entries.append(Entry(name, POLYGON, "polygons", "line"))
    for name, parts in overlay.points.items():
        count = counted(sum(map(len, parts)), "data point")
        entries.append(Entry(name, POINT, f"{count}{', ' if detail else ''}{detail}", "circle"))
    return tuple(entries)


def draw_names(
    sheet: furniture.Sheet, camera: Camera, names: Sequence[tuple[str, tuple[float, float, float]]]
) -> None:
    """Write names next to points of a view; one that finds no room is left out."""
    if not names:
        return
    unit, layout = sheet.layout.unit, sheet.layout
    origin = np.array([layout.left, layout.bottom], dtype=np.float64)
    places = camera.to_pixels(np.array([place for _, place in names])) + origin
    labels = shortened_apart(name for name, _ in names)
    room = Room()
    for (name, _), (x, y) in zip(names, places.tolist(), strict=True):
        inside = 0.0 <= x - origin[0] <= layout.view_size[0]
        if not (inside and 0.0 <= y - origin[1] <= layout.view_size[1]):
            continue
        wide, high = sheet.text_size(labels[name], NAME_SIZE, "bold")
        away = AWAY * unit
        for left, bottom in (
            (x + away, y - 0.5 * high), (x - 0.5 * wide, y + away),
            (x - away - wide, y - 0.5 * high), (x - 0.5 * wide, y - away - high),
        ):  # fmt: skip
            if room.take((left, bottom, left + wide, bottom + high)):
                sheet.text(
                    (left, bottom + 0.5 * high), labels[name], NAME_SIZE, palette.INK,
                    weight="bold", path_effects=furniture.rim_of_words(unit),
                )  # fmt: skip
                break


def draw_on_map(sheet: furniture.Sheet, axes: Axes, overlay: PictureOverlay) -> list[Entry]:
    """Draw the overlay in world coordinates; return the entries of the legend."""
    for parts in overlay.polygons.values():
        for part in parts:
            _plot(sheet, axes, _closed(part)[:, :2], POLYGON, 1.8)
    for parts in overlay.points.values():
        for part in parts:
            _dots(sheet, axes, part[:, :2])
    heads = {}
    for name, parts in overlay.wells.items():
        for part in parts:
            _plot(sheet, axes, part[:, :2], WELL, 1.8)
        heads[name] = parts[0][0, :2]
    _mark(sheet, axes, heads)
    return list(_legend(overlay))


def draw_on_section(
    sheet: furniture.Sheet, axes: Axes, overlay: PictureOverlay, line: np.ndarray
) -> list[Entry]:
    """Draw what is near a section, projected to it; return the entries of the legend.

    Polygons are drawn where they cross the section, as short bars at their elevation.
    """
    near = NEAR * float(np.hypot(*np.diff(line, axis=0).T).sum())
    for parts in overlay.points.values():
        for part in parts:
            flat, far = _projected(part, line)
            _dots(sheet, axes, flat[far <= near])
    heads: dict[str, np.ndarray] = {}
    bottom, top = sorted(axes.get_ylim())
    for name, parts in overlay.wells.items():
        for part in parts:
            flat, far = _projected(part, line)
            # stretches of the well that are near
            for rows in np.split(np.arange(len(part)), np.flatnonzero(np.diff(far <= near)) + 1):
                if far[rows[0]] > near:
                    continue
                _plot(sheet, axes, flat[rows], WELL, 1.8)
                head = highest_in_view(flat[rows], bottom, top)
                if head is not None:
                    heads.setdefault(name, head)
    for parts in overlay.polygons.values():
        for part in parts:
            for along, up in _crossings(_closed(part), line):
                _bar(sheet, axes, along, up)
    _mark(sheet, axes, heads)
    return list(_legend(overlay, f"within {length_text(near)}"))


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
    found, start = [], 0.0
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
                found.append((start + share * length, up))
        start += length
    return found


def _bar(sheet: furniture.Sheet, axes: Axes, along: float, up: float | None) -> None:
    """A short upright bar, at the top of the section without an elevation."""
    y = sorted(axes.get_ylim())[1] if up is None else up
    axes.plot(
        [along], [y], marker="|", markersize=14.0 * sheet.layout.unit, color=POLYGON,
        markeredgewidth=2.0 * sheet.layout.unit, clip_on=up is not None, zorder=6.0,
    )  # fmt: skip


def _plot(
    sheet: furniture.Sheet, axes: Axes, points: np.ndarray, colour: palette.RGB, width: float
) -> None:
    """A line with a white rim, without changing the limits of the axes."""
    limits = axes.axis()
    for wide, ink in ((width + 1.6, palette.PAPER), (width, colour)):
        points_wide = wide * sheet.layout.unit * 72.0 / furniture.DPI
        axes.plot(*points.T, color=ink, linewidth=points_wide, zorder=5.0)
    axes.axis(limits)


def _dots(sheet: furniture.Sheet, axes: Axes, points: np.ndarray) -> None:
    limits = axes.axis()
    size = DOT * sheet.layout.unit * 72.0 / furniture.DPI
    axes.plot(
        *points.T, linestyle="none", marker="o", markersize=size, color=POINT, zorder=5.5,
        markeredgecolor=palette.PAPER, markeredgewidth=0.1 * size,
    )  # fmt: skip
    axes.axis(limits)


def _mark(sheet: furniture.Sheet, axes: Axes, heads: Mapping[str, np.ndarray]) -> None:
    """Mark the heads of wells and write their names, none over another."""
    unit, labels, room = sheet.layout.unit, shortened_apart(heads), sheet.names
    inverse = axes.transData.inverted()
    low, high = axes.transAxes.transform([(0.0, 0.0), (1.0, 1.0)])
    for name, place in heads.items():
        x, y = axes.transData.transform(place)
        if not (low[0] <= x <= high[0] and low[1] <= y <= high[1]):
            continue
        size = 8.0 * unit * 72.0 / furniture.DPI
        axes.plot(
            *place, marker="o", markersize=size, color=palette.PAPER, markeredgecolor=WELL,
            markeredgewidth=0.2 * size, zorder=6.0,
        )  # fmt: skip
        wide, tall = sheet.text_size(labels[name], NAME_SIZE, "bold")
        away = 8.0 * unit
        for left, bottom in (
            (x + away, y - 0.5 * tall), (x - away - wide, y - 0.5 * tall),
            (x + away, y - away - tall), (x - away - wide, y - away - tall),
            (x - 0.5 * wide, y + away), (x - 0.5 * wide, y - away - tall),
        ):  # fmt: skip
            inside = low[0] <= left and left + wide <= high[0] and bottom + tall <= high[1]
            if inside and room.take((left, bottom, left + wide, bottom + tall)):
                spot = inverse.transform((left, bottom + 0.5 * tall))
                furniture.halo_text(
                    sheet, axes, spot, labels[name], NAME_SIZE, ha="left", fontweight="bold",
                    zorder=7.0,
                )  # fmt: skip
                break
