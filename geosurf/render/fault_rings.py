"""Fault polygons on thickness maps: their rings, and where they cut a zone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from geosurf.render import furniture, palette
from geosurf.render.diagram import lines_of
from geosurf.render.styles import Dashes

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray
    from matplotlib.axes import Axes

# polygons of the first horizon, of the second
DASHES: tuple[Dashes, Dashes] = ("solid", (0, (5.0, 2.5)))


def cut_by_faults(
    x: np.ndarray, y: np.ndarray, polygons: Mapping[str, xarray.Dataset]
) -> np.ndarray:
    """Mark nodes (n, m) in a fault polygon, or between polygons of one fault at two horizons."""
    from matplotlib.path import Path as Outline
    from scipy.spatial import cKDTree

    # nodes (n * m, 2); rings by fault and horizon
    nodes = np.column_stack([x.ravel(), y.ravel()])

    # rings as dense as half a cell, so that the nearest point stands for the nearest place
    cell = float(np.hypot(np.diff(x[:2, 0]), np.diff(y[:2, 0])).item())
    cut = np.zeros(len(nodes), dtype=bool)
    rings: dict[str, list[np.ndarray]] = {}
    for found in polygons.values():
        mine: dict[str, list[np.ndarray]] = {}
        for fault, ring in _rings_of(found):
            low, high = ring.min(axis=0) - cell, ring.max(axis=0) + cell
            near = np.flatnonzero(((nodes >= low) & (nodes <= high)).all(axis=1))
            cut[near] |= Outline(ring).contains_points(nodes[near])
            mine.setdefault(fault, []).append(_dense(ring, 0.5 * cell))
        for fault, parts in mine.items():
            rings.setdefault(fault, []).append(np.concatenate(parts))

    # a node lies between the polygons at top and base if its distances to both add up to
    # about the distance between them there
    for lines in rings.values():
        trees = [cKDTree(line) for line in (lines[0], lines[-1])]
        across = trees[1].query(lines[0])[0]  # from polygon to polygon
        most = across.max() + 2.0 * cell
        far, nearest = trees[0].query(nodes, distance_upper_bound=2.0 * most)
        near = np.flatnonzero(far <= most)  # no others can be between
        both = far[near] + trees[1].query(nodes[near])[0]
        cut[near] |= both <= across[nearest[near]] + 2.0 * cell
    return cut.reshape(x.shape)


def _rings_of(rings: xarray.Dataset) -> list[tuple[str, np.ndarray]]:
    """Fault polygons, closed (n, 2), each with the name of its fault."""
    lines = lines_of(rings, ("easting", "northing"), ("fault",))
    return [(words["fault"], np.vstack([ring, ring[:1]])) for words, ring in lines]


def _dense(line: np.ndarray, step: float) -> np.ndarray:
    """Points (n, 2) along a line, at most `step` apart."""
    # points at equal distances along the line
    length = np.append(0.0, np.hypot(*np.diff(line, axis=0).T).cumsum())
    at = np.linspace(0.0, length[-1], int(length[-1] / step) + 2)
    return np.column_stack([np.interp(at, length, axis) for axis in line.T])


def draw_rings(
    sheet: furniture.Sheet,
    axes: Axes,
    rings: xarray.Dataset,
    dashes: Dashes,
    metres: float,
) -> None:
    """Fault polygons of one horizon; each fault is named once, at its longest ring."""
    width = 1.1 * sheet.layout.unit * 72.0 / furniture.DPI

    longest: dict[str, np.ndarray] = {}
    for (fault, ring), kind in zip(_rings_of(rings), rings.kind.values, strict=True):
        if kind == "line":  # there and back: dashes would fill each other's gaps
            ring = ring[: len(ring) // 2 + 1]
        axes.plot(*ring.T, color=palette.ACCENT, linewidth=width, linestyle=dashes)
        if len(ring) > len(longest.get(fault, ())):
            longest[fault] = ring
    if dashes == DASHES[0]:
        for fault, ring in longest.items():
            at = ring[len(ring) // 3] + (9.0 * metres, 0.0)
            furniture.halo_text(
                sheet, axes, at, fault, 11.5, palette.ACCENT, ha="left", fontweight="bold"
            )


__all__ = ["DASHES", "cut_by_faults", "draw_rings"]
