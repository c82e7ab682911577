"""Draw a thickness map of a zone: colours, contours block by block, fault polygons.

Thickness jumps across faults, so each set of blocks has contours of its own. Where a fault cuts
the zone between its polygons at top and base, thickness drops to zero within a few cells. What is
thinner there than the rest of the map is blank, as a fault gap is; contours and the range of the
colours ignore it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from string import ascii_uppercase
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from geosurf.conventions import counted, palette
from geosurf.conventions.axes import vertical_label, vertical_words
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.render import artists
from geosurf.render.artists import Dashes
from geosurf.render.diagram import lines_of
from geosurf.render.furniture import (
    colours_of,
    contour_levels,
    frame_map,
    halo_text,
    map_axes,
    number_contours,
    thin_and_bold,
)
from geosurf.render.layers import Entry
from geosurf.render.sheet import Sheet

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes


# ---- fault rings ----------------------------------------
# Fault polygons on thickness maps: their rings, and where they cut a zone.


# polygons of the first horizon, of the second
DASHES: tuple[Dashes, Dashes] = ("solid", (0, (5.0, 2.5)))


def cut_by_faults(
    x: np.ndarray, y: np.ndarray, polygons: Mapping[str, xarray.Dataset]
) -> np.ndarray:
    """Mark nodes (n, m) in a fault polygon, or between polygons of one fault at two horizons."""
    # nodes (n * m, 2); rings by fault and horizon
    nodes = np.column_stack([x.ravel(), y.ravel()])

    # rings as dense as half a cell, so that the nearest point stands for the nearest place
    cell = float(np.hypot(np.diff(x[:2, 0]), np.diff(y[:2, 0])).item())
    cut = np.zeros(len(nodes), dtype=bool)
    rings: dict[str, list[np.ndarray]] = {}
    for found in polygons.values():
        rings_by_fault: dict[str, list[np.ndarray]] = {}
        for fault, ring in _rings_of(found):
            low, high = ring.min(axis=0) - cell, ring.max(axis=0) + cell
            near = np.flatnonzero(((nodes >= low) & (nodes <= high)).all(axis=1))
            cut[near] |= artists.Path(ring).contains_points(nodes[near])
            rings_by_fault.setdefault(fault, []).append(_dense(ring, 0.5 * cell))
        for fault, parts in rings_by_fault.items():
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
    sheet: Sheet, axes: Axes, rings: xarray.Dataset, dashes: Dashes, metres: float
) -> None:
    """Fault polygons of one horizon; each fault is named once, at its longest ring."""
    width = sheet.points(1.1)

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
            halo_text(sheet, axes, at, fault, 11.5, palette.ACCENT, ha="left", fontweight="bold")


N_CONTOUR = 12
CLIPPED = (1.0, 99.0)  # percentiles: extremes next to faults do not set the range of colours


def draw_thickness(
    sheet: Sheet,
    thickness: xarray.DataArray,
    *,
    polygons: Mapping[str, xarray.Dataset] | None = None,
    outline: np.ndarray | None = None,
    title: str | None = None,
) -> None:
    """Draw a thickness map of one zone, with contours that stop at faults.

    Parameters
    ----------
    sheet : Sheet
    thickness : xarray.DataArray
        Result of `Scene.thickness`: (block, northing, easting) [m]. Where blocks overlap on the map
        (reverse faults), the map shows their sum.
    polygons : mapping of str to xarray.Dataset, optional
        Results of `Scene.fault_polygons` by horizon. Polygons of the first horizon are solid,
        those of the second are dashed.
    outline : ndarray of float64, shape (n, 2), optional
        Around the model [m]: colours end there. Default: they end with their cells.
    title : str, optional
        Default: the kind of thickness and the zone.

    Raises
    ------
    InputError
        If the map has no values.
    """
    # values (block, n, m); x, y: coordinates (n, m) of the nodes [m]
    values, x, y = _checked(thickness)
    polygons = {} if polygons is None else polygons

    # thickness of all blocks together: they overlap at reverse faults
    total = np.where(np.isfinite(values).any(axis=0), np.nansum(values, axis=0), np.nan)
    total = np.round(total, 6)  # no contours of rounding errors

    # the drop to zero at faults would fill the map with contours and its range with zero
    cut = cut_by_faults(x, y, polygons)
    whole = np.where(cut, np.nan, total) if np.isfinite(total[~cut]).any() else total
    low, high = np.nanpercentile(whole, CLIPPED)
    levels = contour_levels(float(low), float(high), N_CONTOUR)
    n_beyond = int(((whole < levels[0]) | (whole > levels[-1])).sum()) if len(levels) > 1 else 0
    extent = (*_cell_ends(x), *_cell_ends(y))

    # draw: colours, contours, fault polygons, letters of blocks
    axes, metres_per_pixel = map_axes(sheet, extent)
    codes = sheet.style.codes(palette.THICKNESS)
    # the part of a zone that a fault leaves in its gap is not a thickness of the lowest class
    shown = np.where(cut & (total < levels[0]), np.nan, _to_outline(total, x, y, outline))
    coloured = _colour(axes, (x, y), shown, levels, codes)
    if outline is not None:
        ring = np.vstack([outline, outline[:1]])
        coloured.set_clip_path(artists.Path(ring, closed=True), axes.transData)
    _contour(sheet, axes, (x, y), (whole, values), levels)
    for rings, dashes in zip(polygons.values(), DASHES, strict=False):
        draw_rings(sheet, axes, rings, dashes, metres_per_pixel)
    attrs = thickness.attrs
    kind = str(attrs.get("kind", "thickness"))
    zone = ", ".join(attrs[key] for key in ("zone", "contact") if key in attrs)
    large = _large_blocks(thickness)
    regions = thickness.block.values[large].tolist() if attrs.get("by") == "region" else ()
    letters = _letter_blocks(sheet, axes, x, y, values[large], regions)
    drawn = tuple(horizon for horizon, rings in polygons.items() if len(rings.kind))
    legend = _legend(thickness, values[large], letters, drawn)
    meaning = {"isochore": "vertical thickness", "isopach": "thickness normal to bedding"}
    note = f" {kind.capitalize()}: {meaning[kind]}." if kind in meaning else ""
    if cut.any():
        note += " Blank and without contours where faults cut the zone."
    if n_beyond:
        note += " Colours leave out the lowest and the highest 1 %."
    title = f"{zone}: {kind} map" if title is None else title
    frame_map(
        sheet, legend, levels, metres_per_pixel, title, note,
        words=vertical_label("Thickness"), codes=codes, n_band=1, where=_where_level(values, cut),
    )  # fmt: skip


def _where_level(values: np.ndarray, cut: np.ndarray) -> str:
    """The part of the map that has the only thickness; the legend lists the blocks."""
    if cut.any():
        return "away from faults"
    held = values[np.isfinite(values)]
    one = f"{held.min():.4g}" == f"{held.max():.4g}"  # to the digits of the legend
    return "everywhere" if one else "all blocks together"


def _checked(thickness: xarray.DataArray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return values (block, n, m), eastings and northings (n, m)."""
    values = thickness.values
    if min(values.shape[1:], default=0) < 2 or not np.isfinite(values).any():
        raise InputError(
            f"the thickness map of {thickness.attrs.get('zone', 'a zone')!r} has no values, or "
            "fewer than two rows or columns. Use smaller cells."
        )
    x, y = (np.asarray(thickness[name].values, np.float64) for name in ("easting", "northing"))
    if x.ndim == 1:
        x, y = np.meshgrid(x, y)
    return values, x, y


def _cell_ends(axis: np.ndarray) -> tuple[float, float]:
    """Range of coordinates (n, m), with half a cell around it."""
    low, high = float(axis.min()), float(axis.max())
    steps = [np.abs(np.diff(axis, axis=k)).max() for k in (0, 1)]

    # nodes are middles of coloured cells: the map reaches half a cell beyond them
    half = 0.5 * float(max(steps))
    return low - half, high + half


def _colour(
    axes: Axes,
    place: tuple[np.ndarray, np.ndarray],
    total: np.ndarray,
    levels: np.ndarray,
    codes: tuple[str, ...],
) -> artists.QuadMesh:
    """One colour for each contour interval, cell by cell."""
    # a single level needs an interval of its own
    colours = colours_of(codes)
    if len(levels) < 2:
        levels = np.array([levels[0] - 0.5, levels[0] + 0.5])
    norm = artists.BoundaryNorm(levels, colours.N)
    shown = np.ma.masked_invalid(total)
    return axes.pcolormesh(
        *place, shown, cmap=colours, norm=norm, shading="nearest", rasterized=True
    )


def _to_outline(
    total: np.ndarray, x: np.ndarray, y: np.ndarray, outline: np.ndarray | None
) -> np.ndarray:
    """Thickness (n, m) with that of the nearest cell in those whose middle is just outside."""
    if outline is None:
        return total
    inside = artists.Path(outline).contains_points(np.column_stack([x.ravel(), y.ravel()]))
    outside = ~inside.reshape(x.shape)
    far, (row, column) = distance_transform_edt(np.isnan(total), return_indices=True)
    return np.where(outside & (far < 1.5), total[row, column], total)


def _contour(
    sheet: Sheet,
    axes: Axes,
    place: tuple[np.ndarray, np.ndarray],
    heights: tuple[np.ndarray, np.ndarray],
    levels: np.ndarray,
) -> None:
    """Contour lines inside each region with the same set of blocks; every fifth is bold."""
    if len(levels) < 2:
        return
    total, values = heights

    # nodes with the same set of blocks make one region: contours stop at its border
    held = np.isfinite(values)

    # sets (n_byte, n_node): one bit for each block that has a value at the node
    sets = np.packbits(held, axis=0).reshape(-1, total.size)
    _, region = np.unique(sets, axis=1, return_inverse=True)
    region = region.reshape(total.shape)
    for r in np.unique(region[np.isfinite(total)]).tolist():
        in_region = np.where(region == r, total, np.nan)

        # levels outside a region's range would make matplotlib warn of contours without lines
        low, high = np.nanmin(in_region), np.nanmax(in_region)
        for chosen, width in thin_and_bold(levels):
            inside = chosen[(chosen > low) & (chosen < high)]
            if len(inside):
                lines = axes.contour(
                    *place, np.ma.masked_invalid(in_region), levels=inside,
                    colors=[palette.INK], linewidths=width * sheet.layout.unit,
                )  # fmt: skip
                if width > 0.5:
                    number_contours(sheet, axes, lines, vertical_label("Thickness"))


def _letter_blocks(
    sheet: Sheet,
    axes: Axes,
    x: np.ndarray,
    y: np.ndarray,
    values: np.ndarray,
    regions: Sequence[str] = (),
) -> list[str]:
    """Write the name of each region or a letter on each block, far from other blocks."""
    letters = []
    for i, block in enumerate(np.isfinite(values)):
        letter = ascii_uppercase[i] if i < len(ascii_uppercase) else str(i)
        if regions:
            letter = regions[i]
        letters.append(letter)
        if block.any() and len(values) > 1:
            # where only this block is; the node farthest from the border of that
            alone = block & (np.isfinite(values).sum(axis=0) == 1)
            inside = distance_transform_edt(np.pad(alone if alone.any() else block, 1))[1:-1, 1:-1]
            at = np.unravel_index(np.argmax(inside), inside.shape)
            halo_text(sheet, axes, (x[at], y[at]), letter, 14.0, weight="bold")
    return letters


def _legend(
    thickness: xarray.DataArray, values: np.ndarray, letters: list[str], horizons: tuple[str, ...]
) -> tuple[Entry, ...]:
    """Entries for the fault polygons, and mean and largest thickness of each block."""
    legend = []
    for k, horizon in enumerate(horizons[:2]):
        look = ("line", "dashes")[k]
        legend.append(Entry("Fault polygons", palette.ACCENT, f"at {horizon}", look))
    large, unit = _large_blocks(thickness), vertical_words("Thickness")[1]
    rows = zip(map(str, thickness.block.values[large]), letters, values, strict=True)
    for name, letter, block in sorted(rows, key=lambda row: (row[1], row[0])):
        words = "no values"
        if np.isfinite(block).any():
            words = f"mean {np.nanmean(block):.4g} {unit}, max {np.nanmax(block):.4g} {unit}"

        # a single block needs no letter on the map
        label = f"{letter}: {name}" if len(values) > 1 and letter != name else name
        if thickness.attrs.get("by") == "region":
            label = f"Region {name}"
        legend.append(Entry(label, detail=words, kind="heading"))
    small = len(large) - int(large.sum())
    if small:
        legend.append(Entry(counted(small, "sliver"), detail="too small to count", kind="heading"))
    return tuple(legend)


def _large_blocks(thickness: xarray.DataArray) -> np.ndarray:
    """Which blocks are more than slivers, bool (n_block,)."""
    if "sliver" not in thickness.coords:
        return np.ones(len(thickness), dtype=bool)
    made: np.ndarray = ~thickness.sliver.values.astype(bool)
    return made
