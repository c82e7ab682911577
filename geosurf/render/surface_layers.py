"""Choose how surfaces, patches and intersection lines are shown, clipped to the model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Unpack

import numpy as np

from geosurf.conventions import counted, grouped, is_number, length_text, palette, volume_text
from geosurf.conventions.axes import points_in
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import rim_edges
from geosurf.kernels.meshes.mesh import edges, ends_of, number_keys, renumbered
from geosurf.lazy import xarray
from geosurf.model import Curves, Lattice, Patches, TriSurface, Units
from geosurf.model.pieces import Pieces, Strips, by_unit
from geosurf.model.protocols import ReportedModel
from geosurf.render.clip import Prism, clipped_lines
from geosurf.render.colouring import (
    Selection,
    colour_units,
    elevation_bar,
    seal_bar,
    shade_of,
    shades_of,
)
from geosurf.render.layers import Content, Entry, Layer, LayerStyle, segment_layer, triangle_layer
from geosurf.render.picture_style import PLAIN, PictureStyle
from geosurf.render.views import SIZE

# ---- unit layers ----------------------------------------
# Choose how units are shown: colours, edges, legend, and the shifts of an exploded view.


EVERYTHING = Selection()
CREASE = math.cos(math.radians(50.0))  # edges between triangles of a larger angle are drawn


def show_units(
    units: Units,
    explode: float = 0.0,
    *,
    only: Selection = EVERYTHING,
    colour_by: Any = "unit",
    style: PictureStyle = PLAIN,
) -> Content:
    """Return the shells of units, one colour per zone and one shade per block; slivers are grey.

    Parameters
    ----------
    units : Units
    explode : float
        Gap between units, as a fraction of the size of the model box. Zones move up and
        down, blocks move sideways from the centre.
    only : Selection
        Units that are shown, by their own name or that of their zone or block; or the reservoir.
    colour_by, style
        As for `geosurf.render.colouring.colour_units`.
    """
    parts = only.of_units(units)
    shown = [unit for unit, yes in zip(units.values(), parts, strict=True) if yes]
    colouring = colour_units(units, shown, colour_by, style)
    content = Content((), colouring.legend, bar=colouring.bar)
    drawn = zip(units.values(), shells_to_draw(units), explosion(units, explode), strict=True)
    for yes, (unit, shell_of_unit, shift) in zip(parts, drawn, strict=True):
        if not yes:
            continue
        colour = colouring.colours.get(unit.name, palette.FAINT)
        points = shell_of_unit.points
        apart = by_surface(shell_of_unit)
        shell = Layer(
            apart.points, apart.triangles, colour=colour, sharp=True,
            shades=colouring.shades(apart.points),
        )  # fmt: skip
        lines = outline(shell_of_unit)
        rims = Layer(points, lines=lines, colour=palette.INK, width=0.9)
        content += Content((shell, rims)).moved(shift)
    slivers = [unit for unit in units.slivers if unit.name in {one.name for one in shown}]
    if slivers:
        total = volume_text(math.fsum(one.volume for one in slivers))
        entry = Entry(counted(len(slivers), "sliver"), palette.FAINT, f"{total} in all")
        content += Content((), (entry,))
    return content


def explosion(units: Units, explode: float) -> list[np.ndarray]:
    """Return the shift (3,) [m] of each unit in an exploded view.

    Zones move up and down in steps of `explode` times the height of the model box; the middle
    zone stays. Units of one block move together, away from the centre of the model, by
    `explode` times the distance from there to the centre of the block.
    """
    if not (is_number(explode) and explode >= 0):
        raise InputError(
            f"exploded is {explode!r}, expected a fraction of the size of the box. "
            "Set a number of 0 or more, as in exploded=0.3."
        )
    west, east, south, north, bottom, top = units.box

    # centre of the model on the map; of each block, from the bounds of its units
    middle = np.array([west + east, south + north]) / 2.0
    zones = sorted({unit.zone_index for unit in units.values()})
    centres = grouped((unit.region or unit.block, unit.middle[:2]) for unit in units.values())
    shifts = []
    for unit in units.values():
        # blocks sideways, away from the centre; zones up and down, the middle one stays
        aside = explode * (np.mean(centres[unit.region or unit.block], axis=0) - middle)
        step = (len(zones) - 1) / 2.0 - zones.index(unit.zone_index)
        shifts.append(np.array([*aside, explode * (top - bottom) * step]))
    return shifts


def by_surface(shell: Shell) -> Shell:
    """Return a shell whose surfaces share no points, so that each is shaded by itself.

    A horizon may end at the rim of the model in thin triangles that are nearly vertical. They would
    pass their shade on to the wall next to them.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, -1]])
    >>> roof = Shell(corners, np.array([[0, 1, 2], [0, 3, 1]]), np.array([0, 1]))
    >>> by_surface(roof).triangles.tolist()
    [[0, 2, 4], [1, 5, 3]]
    """
    n = int(shell.surface.max(initial=0)) + 1
    of_corner = shell.triangles * n + shell.surface[:, None]
    keys, number = number_keys(of_corner.ravel())
    return replace(shell, points=shell.points[keys // n], triangles=number.reshape(-1, 3))


def outline(shell: Shell, creases: bool = True) -> np.ndarray:
    """Return the edges (n_edge, 2) of a shell between two surfaces, and at sharp creases."""
    faces = shell.triangles
    p = shell.points[faces]

    # unit normals of triangles; of one without area, zero
    normals = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    size = np.linalg.norm(normals, axis=1)
    normals /= np.where(size > 0.0, size, 1.0)[:, None]

    # each half-edge with the next one of its edge
    ring, _ = edges(faces, len(shell.points))
    half = np.flatnonzero(ring > np.arange(len(ring)))
    left, right = half // 3, ring[half] // 3

    # an edge is drawn between two surfaces, or where the shell turns by a crease
    turns = shell.surface[left] != shell.surface[right]
    flat = size[left] * size[right] == 0.0
    sharp = creases & ~flat & ((normals[left] * normals[right]).sum(axis=1) < CREASE)
    ends = ends_of(faces, half[turns | sharp])
    return ends[np.lexsort((ends[:, 1], ends[:, 0]))]


# ---- thin units ----------------------------------------
# Shells of units with few enough triangles to draw, made from runs of grids.
#
# Where one unit lies on each side of a block of cells, two triangles stand for all of the block.
# Blocks of very large grids are divided along curves, or these would have most of the triangles.
# Triangles along curves and of surfaces without a grid stay as they are, so that units keep their
# outlines. Along the border of such blocks the shell has gaps, which are smaller than a pixel.


# ---- thin surfaces ----------------------------------------
# Surfaces with few enough triangles to draw: as many as the pixels of a picture can show.


# triangles of all surfaces of a picture, and of one, whatever its size
MAX_TRIANGLE = 1_000_000
MOST, LEAST = 400_000, 60_000
PIXELS = 10  # of a picture for each triangle of a surface: a cell of a grid is two or three wide


def thinned(surface: TriSurface, max_triangle: int = MOST) -> TriSurface:
    """Return a surface with few enough triangles to draw.

    Of a gridded surface with more than `max_triangle` triangles, rows and columns are left out at
    even distances. A surface without a lattice is returned unchanged.

    Parameters
    ----------
    surface : TriSurface
    max_triangle : int

    Returns
    -------
    TriSurface
    """
    lattice = surface.lattice
    if lattice is None:
        return surface
    n_row, n_col = lattice.shape

    # two triangles for each cell: half of the rows and columns leaves a quarter of them
    share = math.sqrt(max_triangle / (2.0 * max(n_row - 1, 1) * max(n_col - 1, 1)))
    if share >= 1.0:
        return surface
    rows, columns = _spread(n_row, share), _spread(n_col, share)
    kept = np.ix_(rows, columns)
    if lattice.easting.ndim == 1:
        easting, northing = lattice.easting[columns], lattice.northing[rows]
    else:
        easting, northing = lattice.easting[kept], lattice.northing[kept]
    elevation = lattice.elevation[kept]
    coarse = Lattice(easting, northing, elevation, lattice.rising, lattice.reverse)
    return TriSurface(surface.name, surface.role, lattice=coarse)


def most_of_each(n: int, size: tuple[int, int] = SIZE, zoom: float = 1.0) -> int:
    """How many triangles each of n surfaces may have, about: as many as pixels can show.

    Parameters
    ----------
    n : int
    size : (int, int)
        Width and height of the picture in pixels.
    zoom : float
        2 shows the middle at twice the scale.

    Examples
    --------
    >>> most_of_each(2), most_of_each(12), most_of_each(2, (3840, 2160))
    (102400, 83333, 400000)
    """
    resolved = int(size[0] * size[1] * zoom**2) // PIXELS
    return min(MOST, max(LEAST, min(resolved, MAX_TRIANGLE // max(n, 1))))


def _spread(n: int, share: float) -> np.ndarray:
    """Some of n rows at even distances; the first and the last one stay, and so the border.

    Examples
    --------
    >>> _spread(10, 0.7).tolist()
    [0, 2, 3, 4, 6, 8, 9]
    """
    n_cell = max(int((n - 1) * min(share, 1.0)), min(n - 1, 1))
    return np.round(np.linspace(0.0, n - 1.0, n_cell + 1)).astype(np.int64)


MAX_UNIT_TRIANGLE = 400_000  # of all shells: one for each four pixels of a picture
FIRST, LAST = 1, 2  # columns of runs


@dataclass(frozen=True, eq=False)
class Shell:
    """The shell of a unit as it is drawn.

    Attributes
    ----------
    points : ndarray of float64, shape (n_point, 3)
        World coordinates [m].
    triangles : ndarray of int64, shape (n_triangle, 3)
        Outward normals.
    surface : ndarray of int64, shape (n_triangle,)
        Surface of each.
    """

    points: np.ndarray
    triangles: np.ndarray
    surface: np.ndarray


@dataclass(frozen=True, eq=False)
class UnitMesh:
    """Triangles between units, each listed once for the units on both of its sides.

    Attributes
    ----------
    points : ndarray of float64, shape (n_point, 3)
        World coordinates [m]; surfaces that meet share their points.
    triangles : ndarray of int64, shape (n_triangle, 3)
    sides : ndarray of int64, shape (n_triangle, 2)
        Unit in front and behind, two different ones; -1 outside.
    surface : ndarray of int64, shape (n_triangle,)
        Surface of each.
    n_unit : int
    """

    points: np.ndarray
    triangles: np.ndarray
    sides: np.ndarray
    surface: np.ndarray
    n_unit: int

    @property
    def n_drawn(self) -> int:
        """Number of triangles of all shells."""
        return int(np.count_nonzero(self.sides >= 0))

    @property
    def shells(self) -> list[Shell]:
        """The shell of each unit, turned outward."""
        rows, first = by_unit(self.sides, self.n_unit)
        outward = []
        for u, (low, high) in enumerate(pairwise(first.tolist())):
            faces = rows[low:high]
            t = self.triangles[faces]
            inward = self.sides[faces, 0] == u
            t[inward] = t[inward][:, [0, 2, 1]]
            used, t = renumbered(t)
            outward.append(Shell(self.points[used], t, self.surface[faces]))
        return outward


def shells_to_draw(units: Units, max_triangle: int = MAX_UNIT_TRIANGLE) -> list[Shell]:
    """
    Return the shell of each unit, with about `max_triangle` triangles in all, or as it is.

    Parameters
    ----------
    units : Units
    max_triangle : int
    """
    if not units.has_pieces:  # units that were not carved have their triangles only
        return whole_shells(units)
    pieces, sides = units.piece_sides
    stride = _stride(pieces, sides, max_triangle)
    if stride == 1:
        return whole_shells(units)
    return thinned_mesh(pieces, sides, len(units), stride).shells


def mesh_to_draw(units: Units, max_triangle: int = MAX_UNIT_TRIANGLE) -> UnitMesh:
    """
    Return the triangles between units, with about `max_triangle` of all shells, or all of them.

    Parameters
    ----------
    units : Units
    max_triangle : int
    """
    if not units.has_pieces:
        return _welded(whole_shells(units))
    pieces, sides = units.piece_sides
    return thinned_mesh(pieces, sides, len(units), _stride(pieces, sides, max_triangle))


def whole_shells(units: Units) -> list[Shell]:
    """Return the shells of units with all of their triangles."""
    return [Shell(u.vertices, u.triangles, u.surface_of_triangle) for u in units.values()]


def _welded(shells: list[Shell]) -> UnitMesh:
    """Shells whose points are one where they have equal coordinates."""
    points, row = np.unique(
        np.concatenate([np.empty((0, 3)), *(shell.points for shell in shells)]),
        axis=0, return_inverse=True,
    )  # fmt: skip
    first = np.cumsum([0, *(len(shell.points) for shell in shells)])
    parts = [row.ravel()[shell.triangles + k] for shell, k in zip(shells, first, strict=False)]
    unit = np.repeat(np.arange(len(shells)), [len(part) for part in parts])
    surfaces = [shell.surface for shell in shells]
    return UnitMesh(
        points,
        np.concatenate([np.empty((0, 3), dtype=np.int64), *parts]),
        np.column_stack([np.full(len(unit), -1), unit]),
        np.concatenate([np.empty(0, dtype=np.int64), *surfaces]),
        len(shells),
    )


def _stride(pieces: Pieces, sides: np.ndarray, max_triangle: int) -> int:
    """Rows and columns of a block, 1 where nothing is to be thinned."""
    bounds = (sides[:, 0] != sides[:, 1])[len(pieces.triangles) :]
    n = 0
    for first, strips in zip(pieces.first_run, pieces.strips, strict=False):
        if strips is not None:
            runs = strips.runs
            length = runs[:, LAST] - runs[:, FIRST] + 1
            n += 2 * int(length[bounds[first : first + len(runs)]].sum())
    if n <= max_triangle:
        return 1
    return math.ceil(math.sqrt(n / max_triangle))


def thinned_mesh(pieces: Pieces, sides: np.ndarray, n_unit: int, stride: int) -> UnitMesh:
    """
    Return the triangles between units, from blocks of `stride` x `stride` cells.

    Parameters
    ----------
    pieces, sides
        As ``Units.piece_sides``.
    n_unit : int
    stride : int
        1 lists all triangles.
    """
    n_core = len(pieces.triangles)
    points = [pieces.x + pieces.origin]
    listed = np.flatnonzero(sides[:n_core, 0] != sides[:n_core, 1])
    triangles, beside = [pieces.triangles[listed]], [sides[:n_core][listed]]
    surface = [pieces.surface[listed]]
    n_point = len(pieces.x)
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        if strips is None or not len(strips.runs):
            continue
        assert source.lattice is not None
        first = n_core + int(pieces.first_run[i])
        nodes, block_sides = _blocks(source.lattice, strips, sides[first:], stride)

        # nodes that cut triangles have, too, keep their points: normals pass from one to the other
        used, place_of = renumbered(nodes)
        at = np.minimum(np.searchsorted(strips.nodes, used), max(len(strips.nodes) - 1, 0))
        known = strips.nodes[at] == used if len(strips.nodes) else np.zeros(len(used), dtype=bool)
        number = n_point + np.cumsum(~known) - 1
        number[known] = strips.points[at[known]]
        points.append(source.places_of_nodes(used[~known]))
        n_point += len(points[-1])
        triangles.append(number[place_of])
        beside.append(block_sides)
        surface.append(np.full(len(nodes), i))
    x, t, sides, of = (_joined(part) for part in (points, triangles, beside, surface))
    return UnitMesh(x, t, sides, of, n_unit)


def as_modelled(scene: ReportedModel, surface: TriSurface, max_triangle: int) -> TriSurface:
    """
    Return the modelled part of a surface: a torn horizon ends on its faults, not beyond them.

    Parameters
    ----------
    scene : Scene
    surface : TriSurface
    max_triangle : int
        Of a torn horizon, about; others are returned as they are.

    Returns
    -------
    TriSurface
        Of a large torn horizon blocks of cells, and all of its triangles along faults: listing all
        of 25 million cells took 4 minutes and 10 GB for a map.
    """
    if "ghost" not in surface.vertex_data:
        return surface
    patches = scene.patches
    pieces, row = patches.pieces, patches.names.index(surface.name)

    # its triangles as the sides of one unit, which is behind them
    sides = np.full((int(pieces.first_run[-1]) + len(pieces.triangles), 2), -1)
    runs = len(pieces.triangles) + pieces.first_run
    sides[runs[row] : runs[row + 1], 1] = 0
    sides[: len(pieces.triangles), 1][pieces.surface == row] = 0
    stride = _stride(pieces, sides, 2 * max_triangle)
    if stride == 1:
        return patches.surface(row)
    (shell,) = thinned_mesh(pieces, sides, 1, stride).shells
    return TriSurface(surface.name, surface.role, shell.points, shell.triangles)


def _joined(parts: list[np.ndarray]) -> np.ndarray:
    """All parts in one array; the list is empty afterwards, so that the next one has its memory."""
    found = np.concatenate(parts)
    parts.clear()
    return found


def _blocks(
    lattice: Lattice, strips: Strips, sides: np.ndarray, stride: int
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 3) of the triangles of blocks and of cells outside of them; sides of each."""
    n_row, n_col = lattice.shape[0] - 1, lattice.shape[1] - 1
    runs = strips.runs
    sides = sides[: len(runs)]
    width = int(sides.max(initial=-1)) + 2
    codes, kind = number_keys((sides[:, 0] + 1) * width + sides[:, 1] + 1)
    pairs = np.stack(np.divmod(codes, width), axis=1) - 1
    counts = pairs[:, 0] != pairs[:, 1]
    kind = np.append(np.where(counts[kind], kind + 1, 0), 0)  # the last: no run

    # bands of rows: labels of all triangles would take more memory than the grid
    sizes, nodes, labels = _sizes(stride), [], []
    rows = sizes[0] * max(BAND // (n_col * sizes[0]), 1)
    for top in range(0, n_row, rows):
        left = kind[strips.labels(top, min(top + rows, n_row))]
        whole = [np.where(left[:, :, 0] == left[:, :, 1], left[:, :, 0], 0)]
        while len(whole) < sizes[0].bit_length():
            n_tall, n_wide = (n // 2 for n in whole[-1].shape)
            four = whole[-1][: 2 * n_tall, : 2 * n_wide].reshape(n_tall, 2, n_wide, 2)
            alike = (four == four[:, :1, :, :1]).all(axis=(1, 3))
            whole.append(np.where(alike, four[:, 0, :, 0], 0))
        for size in sizes:
            # blocks of one kind: the far nodes of their first cell are moved to those of the block
            low = whole[size.bit_length() - 1]
            n_tall, n_wide = low.shape
            low = np.where(left[::size, ::size, 0][:n_tall, :n_wide] > 0, low, 0)
            inside = np.repeat(np.repeat(low > 0, size, axis=0), size, axis=1)
            left[: n_tall * size, : n_wide * size][inside] = 0
            row, col = np.nonzero(low)
            cell = (top + row * size) * n_col + col * size
            corner = lattice.corners_of_keys(np.concatenate([2 * cell, 2 * cell + 1]))
            far = [corner // (n_col + 1), corner % (n_col + 1)]
            for at, first in zip(far, np.divmod(np.tile(cell, 2), n_col), strict=True):
                at += (at - first[:, None]) * (size - 1)
            nodes.append(far[0] * (n_col + 1) + far[1])
            labels.append(np.tile(low[row, col], 2))
        row, col, half = np.nonzero(left)
        nodes.append(lattice.corners_of_keys(2 * ((top + row) * n_col + col) + half))
        labels.append(left[row, col, half])
    return np.concatenate(nodes), pairs[np.concatenate(labels) - 1]


def _sizes(stride: int) -> list[int]:
    """Cells along the sides of blocks: of large ones, halves and quarters beside curves, too.

    With one size, blocks that a curve passes leave all their cells: more, the larger blocks are.

    Examples
    --------
    >>> _sizes(5), _sizes(50)
    ([8, 4, 2], [64, 32, 16, 8, 4, 2])
    """
    if stride == 1:
        return [1]
    return [2**k for k in range(math.ceil(math.log2(stride)), 0, -1)]


BAND = 1 << 20  # cells whose labels are in memory
MAX_RIMMED = 200_000

OTHER_ROLES = ("fault", "wall", "virtual")


def show_surfaces(
    surfaces: Iterable[TriSurface],
    within: Prism | None = None,
    *,
    only: Selection = EVERYTHING,
    by_elevation: bool = False,
    style: PictureStyle = PLAIN,
    size: tuple[int, int] = SIZE,
    zoom: float = 1.0,
) -> Content:
    """Return horizons in the colours of the column and faults semi-transparent.

    Horizons take colours in the given order, youngest first. With `within`, only the part inside
    the model is shown. `only` selects surfaces by name, `by_elevation` colours horizons by z. Grids
    are thinned to what a picture of some size and zoom can show.
    """
    layers: list[Layer] = []
    legend: list[Entry] = []
    coloured: list[int] = []
    n_horizon = n_fault = 0
    every = list(surfaces)
    most = most_of_each(len(every), size, zoom)
    for surface in every:
        # faults and horizons count their colours apart, so that a fault more changes no horizon
        colour, opacity = palette.WALL, 0.25
        if surface.role == "fault":
            colour, opacity = palette.fault(n_fault), 0.55
            n_fault += 1
        elif surface.role not in ("wall", "virtual"):
            colour, opacity = palette.stratum(n_horizon), 1.0
            n_horizon += 1

        if not only.holds(surface.name):
            continue
        colour = style.colour(surface.name, colour)

        # triangles and rim inside the model; a surface outside of it stays in the legend
        light = thinned(surface, most)
        shown = _surface_layers(light, within, colour, opacity)
        if by_elevation and surface.role not in OTHER_ROLES:
            coloured += range(len(layers), len(layers) + len(shown))
        layers += shown
        detail = surface.role
        if light.n_triangle and not shown:
            detail += ", outside the model"
        legend.append(Entry(surface.name, colour, detail, opacity=opacity))
    content = Content(tuple(layers), tuple(legend))
    return _by_elevation(content, coloured, style) if coloured else content


def _by_elevation(content: Content, rows: list[int], style: PictureStyle) -> Content:
    """Colour the triangles of some layers by their elevation, with a colour bar."""
    # horizons have the same colour at the same elevation, so their names leave the legend
    surfaces = [content.layers[row] for row in rows if content.layers[row].triangles is not None]
    z = np.concatenate([layer.points[:, 2] for layer in surfaces])
    bar = elevation_bar(float(z.min()), float(z.max()), style)
    layers = tuple(
        replace(layer, shades=shades_of(bar, layer.points[:, 2]))
        if any(layer is one for one in surfaces)
        else layer
        for layer in content.layers
    )
    others = tuple(entry for entry in content.legend if entry.detail.startswith(OTHER_ROLES))
    return replace(content, layers=layers, legend=others, bar=bar)


def _surface_layers(
    surface: TriSurface, within: Prism | None, colour: palette.RGB, opacity: float
) -> list[Layer]:
    """Triangles and rim of the visible part of a surface."""
    # the rim is that of the whole surface: edges where it is clipped are walls'
    points, triangles = surface.vertices, surface.triangles
    walls = np.empty((0, 2), dtype=np.int64)
    edges = rim_edges(triangles) if len(triangles) <= MAX_RIMMED else walls
    ends = points[edges]
    if within is not None and len(triangles):
        ends, _ = within.segments(points, edges)
        points, triangles, walls = within.triangles(points, triangles)
    if not len(triangles):
        return []
    layers = [triangle_layer(points, triangles, colour=colour, opacity=opacity)]
    ends = np.concatenate([ends, points[walls]])
    if len(ends) > 0 and len(triangles) <= MAX_RIMMED:
        # without its rim, a fault seen edge-on would be invisible
        ink = palette.shade(colour, 1, 2)
        layers.append(segment_layer(ends, colour=ink, width=1.2))
    return layers


def show_seals(seals: Sequence[xarray.Dataset], style: PictureStyle) -> Content:
    """Return faults in the colours of their shale gouge ratio; grey where it is not known."""
    bar, layers, legend = seal_bar(seals, style), [], []
    for seal in seals:
        sgr = seal.sgr.values.ravel()
        shades = np.where(np.isnan(sgr)[:, None], palette.WALL, shades_of(bar, np.nan_to_num(sgr)))
        triangles = np.arange(len(sgr)).reshape(-1, 3)
        layers.append(Layer(points_in(seal), triangles, shades=shades))

        # the legend has the mean where reservoir faces reservoir
        facing = seal.area.where(seal.juxtaposition == "reservoir on reservoir", 0.0)
        mean = float((seal.mean_sgr * facing).sum() / facing.sum()) if facing.any() else math.nan
        words = "no reservoir on reservoir" if math.isnan(mean) else f"mean SGR {mean:.2f}"
        colour = palette.WALL if math.isnan(mean) else shade_of(bar, mean)
        legend.append(Entry(seal.attrs["fault"], colour, words))
    return Content(tuple(layers), tuple(legend), bar=bar)


def show_patches(
    patches: Patches,
    within: Prism | None = None,
    *,
    only: Selection = EVERYTHING,
    style: PictureStyle = PLAIN,
) -> Content:
    """Return the patches of all surfaces in alternating shades, and their intersection lines.

    With `within`, only the parts inside the model.
    """
    content = Content()

    # colours as in `show_surfaces`: one surface looks the same in all pictures
    n_horizon = n_fault = 0
    for i, source in enumerate(patches.sources):
        fault = source.role == "fault"
        virtual = source.role == "virtual"
        colour = palette.fault(n_fault) if fault else palette.stratum(n_horizon)
        colour = palette.WALL if virtual else colour
        n_fault, n_horizon = n_fault + fault, n_horizon + (not fault and not virtual)
        opacity = 0.25 if virtual or source.role == "wall" else 0.55 if fault else 1.0

        if not only.holds(source.name):
            continue
        colour = style.colour(source.name, colour)

        # one layer for each patch of the surface, in shades of its colour
        on_surface = patches.surface_of_triangle == i
        rows = np.unique(patches.patch_of_triangle[on_surface])
        layers = []
        for k, row in enumerate(rows):
            points = patches.vertices
            triangles = patches.triangles[on_surface & (patches.patch_of_triangle == row)]
            if within is not None:
                points, triangles, _ = within.triangles(points, triangles)
            if len(triangles):
                tint = palette.shade(colour, k, len(rows))
                layers.append(triangle_layer(points, triangles, colour=tint, opacity=opacity))
        entry = Entry(source.name, colour, counted(len(layers), "patch"), opacity=opacity)
        content += Content(tuple(layers), (entry,))

    # edges along curves, over all surfaces
    edges = patches.curve_edges
    if len(edges):
        ends = patches.vertices[edges]
        if within is not None:
            ends, _ = within.segments(patches.vertices, edges)
        content += Content((segment_layer(ends, colour=palette.CURVE, width=2.0),))
    return content


def show_curves(
    curves: Curves,
    colour: palette.RGB = palette.CURVE,
    width: float = 2.8,
    between: set[str] | None = None,
    within: Prism | None = None,
) -> Content:
    """Return intersection lines as bold lines, with their number and length in the legend.

    With `between`, only lines of the two named surfaces; with `within`, only the parts inside
    the model.
    """
    # pairs of names; without an order, as in `between`
    names = [{curves.names[i] for i in pair} for pair in curves.surfaces_of_curve.tolist()]
    rows = [i for i, pair in enumerate(names) if between is None or pair == between]
    if not rows:
        return Content()
    layer, lengths = _curve_layer(curves, rows, within, colour=colour, width=width)
    if not len(lengths):
        return Content()
    detail = f"{counted(len(lengths), 'line')}, {length_text(float(np.sum(lengths)))}"
    return Content((layer,), (Entry("Intersection lines", colour, detail, "line"),))


def _curve_layer(
    curves: Curves, rows: list[int], within: Prism | None, **look: Unpack[LayerStyle]
) -> tuple[Layer, np.ndarray]:
    """The layer of some curves, and the length of each that is shown [m]."""
    if within is None or within.holds(curves.points):
        lines = tuple(curves.curves[i] for i in rows)
        return Layer(curves.points, lines=lines, **look), curves.length_of_curve[rows]

    # clipped curves fall into segments: lengths are those that are shown
    shown = [
        ends
        for ends in clipped_lines(curves.points, [curves.curves[i] for i in rows], within)
        if len(ends)
    ]
    lengths = [float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()) for ends in shown]
    parts = np.concatenate([np.empty((0, 2, 3)), *shown])
    return segment_layer(parts, **look), np.array(lengths)
