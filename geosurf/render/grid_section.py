"""Draw a row or a column of cells of a corner-point grid, as a vertical section."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import is_word
from geosurf.errors import InputError
from geosurf.model import CornerPointGrid
from geosurf.model.expected import expect
from geosurf.render import furniture, palette
from geosurf.render.compose import figure_path, save_figure
from geosurf.render.diagram import diagram_axes, range_shown
from geosurf.render.layers import Entry
from geosurf.render.picture_style import PictureStyle
from geosurf.render.views import check_size

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.figure import Figure

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
    if not is_word(colour_by, BY):
        raise InputError(f"colour_by is {colour_by!r}, expected one of {BY}.")
    axis, number = _where(grid, row, column)
    cells, shown = _cells(grid, axis, number - 1)
    if not shown.any():
        raise InputError(f"{'JI'[axis]} {number} has no active cell. Choose another one.")
    names, values, order = grid.block_names, grid.block, grid.block_names
    if colour_by == "zone":
        names, values, order = grid.zone_names, grid.zone, grid.zones_of_model
    sheet = furniture.sheet_for(None, check_size(size), style)
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
    sheet: furniture.Sheet,
    rings: np.ndarray,
    kinds: np.ndarray,
    names: tuple[str, ...],
    colours: list[palette.RGB],
    title: str,
) -> Figure:
    """Cells (n, 4, 2) in the colours of their kinds, with a legend."""
    from matplotlib.collections import PolyCollection

    points = rings.reshape(-1, 2)
    axes, exaggeration = diagram_axes(
        sheet, range_shown(points, [points[:, 1]]), "Distance along the section [km]", ROOM
    )
    axes.add_collection(
        PolyCollection(
            list(rings),
            facecolors=np.array(colours)[kinds],
            edgecolors=palette.INK,
            linewidths=0.25,
        )
    )
    legend = tuple(Entry(names[k], colours[k]) for k in np.unique(kinds).tolist())
    furniture.draw_legend(sheet, legend, 640.0)
    furniture.draw_words(sheet, title, f"Vertical exaggeration {exaggeration:.2g}×.")
    return sheet.figure
