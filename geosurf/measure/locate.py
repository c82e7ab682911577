"""Which unit is at a point: the surfaces of a model, made ready for vertical lines.

What no curve touches of a grid stays a grid: a point finds its cell by its coordinates. Lines that
pass other triangles are searched. The kernels in `kernels.meshes.lattice_units` explain why
sums over both are enough, and decide every sign exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.kernels.lattices.lattice_corners import build_list_tree, survey_list
from geosurf.kernels.meshes import lattice_units
from geosurf.kernels.meshes.lattice_units import OFF, digits_of, find_keys, frame_with
from geosurf.kernels.meshes.mesh import number_keys
from geosurf.kernels.meshes.nearest import nearest_distance, point_codes
from geosurf.kernels.search.columns import met_by_columns, signs_of_turns
from geosurf.kernels.search.tree import rows_near
from geosurf.model import Lattice, Patches, Units
from geosurf.model.pieces import Pieces, Strips, corners_of
from geosurf.model.torn_lattice import TornLattice

# ---- boundaries ----------------------------------------
# All triangles that bound units, in a tree of boxes: distances to them, lines through them.


@dataclass(frozen=True, eq=False)
class Boundaries:
    """The boundaries of all units.

    Attributes
    ----------
    origin : ndarray of float64, shape (3,)
    x : ndarray of float64, shape (n_vertex, 3)
        Local coordinates.
    triangles : ndarray of int64, shape (n_triangle, 3)
        Those with different units, or the outside, in front and behind.
    boxes : ndarray of float64, shape (n_triangle, 6)
    tree : tuple of ndarray
    """

    origin: np.ndarray
    x: np.ndarray
    triangles: np.ndarray
    boxes: np.ndarray
    tree: tuple[np.ndarray, np.ndarray, np.ndarray]

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distance of points (n, 3), in world coordinates, to the nearest triangle [m]."""
        local = points - self.origin

        # along a Morton curve: the nearest triangle of one point is a good guess for the next
        order = np.argsort(point_codes(local, self.tree[1][-1]), kind="stable")
        found, out = np.empty(len(points)), np.empty(len(points))
        nearest_distance(self.x, self.triangles, *self.tree, local[order], found)
        out[order] = found
        return out

    def near(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Corners (n, 3, 3) of the triangles whose boxes meet a box, local."""
        rows = rows_near(self.tree, self.boxes, np.concatenate([low, high]))
        return self.x[self.triangles[rows]]


def boundaries_of(patches: Patches, units: Units) -> Boundaries:
    """
    Put all triangles that bound a unit into a tree.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.graben(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> found = boundaries_of(scene.patches, scene.units)
    >>> found.distance(np.array([[1000.0, 1000.0, scene.box[5] + 3.0]])).tolist()
    [3.0]
    """
    rows = np.flatnonzero(units.sides[:, 0] != units.sides[:, 1])
    x, triangles = patches.local, np.ascontiguousarray(patches.triangles[rows])
    boxes, codes, _, _ = survey_list(x, triangles)
    return Boundaries(patches.origin, x, triangles, boxes, build_list_tree(boxes, codes))


# ---- grid cells ----------------------------------------
# Find the triangles of grids that vertical lines pass, by coordinates: nothing is searched.


MOST_DEVIATION = 0.25  # of a cell, of nodes from a grid of equal cells: a guess is one cell off
ROW, FIRST, LAST = 0, 1, 2  # columns of runs


def keys_at(
    lattice: Lattice, origin: np.ndarray, feet: np.ndarray, middle: np.ndarray
) -> np.ndarray | None:
    """
    Return the key of the triangle of a grid that each vertical line passes; of those with nodes.

    Parameters
    ----------
    lattice : Lattice
    origin : ndarray of float64, shape (3,)
    feet : ndarray of float64, shape (n, 2)
        Local [m].
    middle : ndarray of float64, shape (2,)
        Feet on the rim of a triangle count as if they were a little nearer to this.

    Returns
    -------
    ndarray of int64, shape (n,), or None
        -1 outside of the grid. None for a grid that may fold on the map, or whose cells are far
        from equal. Triangles of a torn grid that are gone have their keys, too; its copies do not
        count.

    Examples
    --------
    >>> lattice = Lattice(np.array([0.0, 5.0, 10.0]), np.array([0.0, 5.0]), np.zeros((2, 3)))
    >>> keys_at(lattice, np.zeros(3), np.array([[9.0, 1.0], [11.0, 1.0]]), np.ones(2)).tolist()
    [2, -1]
    """
    torn = isinstance(lattice, TornLattice) and lattice.nodes_lie_apart
    guess = _guess(lattice, origin) if torn else cell_guess(lattice, origin)
    if guess is None:
        return None
    x, y = lattice.easting.ravel() - origin[0], lattice.northing.ravel() - origin[1]
    m, w = frame_with(digits_of(x, y), digits_of(feet))
    keys = np.full(len(feet), OFF, dtype=np.int64)
    turn, rule = 1 if lattice.right_handed else -1, np.append(middle, 0.0)
    find_keys(x, y, lattice.places, guess, turn, np.ascontiguousarray(feet), rule, m, w, keys)
    return keys


def runs_of_keys(lattice: Lattice, strips: Strips, keys: np.ndarray) -> np.ndarray:
    """Run of each triangle by key (n,), -1 where a curve touches it or a node is absent."""
    n_col = 2 * (lattice.shape[1] - 1)
    row, place = np.divmod(keys, n_col)
    if lattice.rising:  # halves of a cell come in the other order along a strip
        place ^= 1
    runs = strips.runs
    if not len(runs):
        return np.full(len(keys), -1)

    # runs come row by row and from west to east: the last one that starts at or before a place
    at = np.searchsorted(runs[:, ROW] * n_col + runs[:, FIRST], row * n_col + place, "right") - 1
    held = (keys >= 0) & (at >= 0) & (runs[at, ROW] == row) & (runs[at, LAST] >= place)
    return np.where(held, at, -1)


def cell_guess(lattice: Lattice, origin: np.ndarray) -> np.ndarray | None:
    """How easting and northing lead to rows and columns: empty for axes along those of the map.

    None if the grid may fold on the map, or its cells are too far from equal for a guess.
    """
    return _guess(lattice, origin) if lattice.is_graph else None


def _guess(lattice: Lattice, origin: np.ndarray) -> np.ndarray | None:
    """`cell_guess` of nodes that do not fold."""
    if lattice.easting.ndim == 1:
        return np.empty(0)
    x, y = lattice.easting - origin[0], lattice.northing - origin[1]
    if min(lattice.shape) < 2 or not (np.isfinite(x).all() and np.isfinite(y).all()):
        return None

    # mean steps along rows and columns, from corner to corner
    n_row, n_col = lattice.shape
    first = np.array([x[0, 0], y[0, 0]])
    along = np.array([[x[-1, 0], x[0, -1]], [y[-1, 0], y[0, -1]]]) - first[:, None]
    back = np.linalg.inv(along / [n_row - 1, n_col - 1])
    row, col = (back[k, 0] * (x - first[0]) + back[k, 1] * (y - first[1]) for k in (0, 1))
    off = max(
        float(np.abs(row - np.arange(n_row)[:, None]).max()),
        float(np.abs(col - np.arange(n_col)).max()),
    )
    if off > MOST_DEVIATION:
        return None
    start = -back @ first
    return np.array([start[0], *back[0], start[1], *back[1]])


AT_ONCE = 1 << 17  # points that are looked up together, by one thread
TILES = 64  # along each side of the model, in whose order points are looked up


@dataclass(frozen=True, eq=False)
class Lines:
    """Vertical lines and the points on them, local.

    Attributes
    ----------
    feet : ndarray of float64, shape (n, 2)
    levels : ndarray of float64
        Elevations of the points, rising along each line.
    each : int
        Number of points of each line; 0 if all lines have the same levels.
    """

    feet: np.ndarray
    levels: np.ndarray
    each: int

    @property
    def arrays(self) -> tuple[np.ndarray, np.ndarray, int]:
        """As the kernels take them."""
        return self.feet, self.levels, self.each

    @cached_property
    def digits(self) -> tuple[int, int]:
        """Binary digits of all coordinates."""
        return digits_of(self.feet, self.levels)


@dataclass(frozen=True, eq=False)
class Grids:
    """Surfaces that share one map, as `lattice_units` takes them."""

    x: np.ndarray
    y: np.ndarray
    places: np.ndarray
    z: np.ndarray
    column: np.ndarray
    steps: np.ndarray
    guess: np.ndarray
    turn: int
    digits: tuple[int, int]

    def add(self, lines: Lines, rule: np.ndarray, unit: np.ndarray) -> None:
        """Add the steps of all surfaces to the highest point below each, line by line."""
        m, w = frame_with(self.digits, lines.digits)
        of = (self.x, self.y, self.places, self.z, self.column, self.steps, self.guess, self.turn)
        lattice_units.add_lattice_units(*of, *lines.arrays, rule, m, w, unit)


@dataclass(frozen=True, eq=False)
class Listed:
    """Triangles that are searched one by one; none is upright."""

    corners: np.ndarray
    facing: np.ndarray
    step: np.ndarray
    digits: tuple[int, int]

    def add(self, lines: Lines, rule: np.ndarray, unit: np.ndarray) -> None:
        """Add the steps of all triangles to the highest point below each, line by line."""
        m, w = frame_with(self.digits, lines.digits)
        x, rows = self.corners.reshape(-1, 3), np.arange(3 * len(self.corners)).reshape(-1, 3)
        pairs = met_by_columns(x, rows, self.facing, lines.feet, rule[:2])
        of = self.corners.reshape(-1, 9), self.facing, self.step
        lattice_units.add_triangle_units(*of, *pairs, *lines.arrays, rule, m, w, unit)


@dataclass(frozen=True, eq=False)
class Locator:
    """A model, ready to find the unit at a point.

    Attributes
    ----------
    origin : ndarray of float64, shape (3,)
    rule : ndarray of float64, shape (3,)
        Easting and northing of the middle of the model, elevation of its floor, local.
    groups : tuple of Grids
    listed : Listed
    box : ndarray of float64, shape (2, 3)
        Lowest and highest coordinates of the model, local.
    """

    origin: np.ndarray
    rule: np.ndarray
    groups: tuple[Grids, ...]
    listed: Listed
    box: np.ndarray

    def find(self, points: np.ndarray) -> np.ndarray:
        """
        Return the unit at each point.

        Parameters
        ----------
        points : ndarray of float64, shape (n, 3)
            World coordinates [m].

        Returns
        -------
        ndarray of int64, shape (n,)
            Row of the unit; -1 outside the model.
        """
        # into the local frame as nodes of surfaces go: a point at a node stays at it
        local = points - self.origin

        # tile by tile, row by row: neighbours share cells
        place = ((local[:, k] - self.box[0, k]) / np.ptp(self.box[:, k]) for k in (0, 1))
        with np.errstate(invalid="ignore"):  # what is not a number is refused later
            col, row = (np.clip(TILES * of, 0, TILES - 1).astype(np.int16) for of in place)
        order = np.argsort(row * TILES + col, kind="stable")  # numpy sorts 16 bits by digits
        local = local.take(order, axis=0)
        found = np.empty(len(local), dtype=np.int64)
        found[order] = self._units(Lines(local[:, :2].copy(), local[:, 2].copy(), 1), len(local))
        return found

    def find_on_lines(self, feet: np.ndarray, levels: np.ndarray) -> np.ndarray:
        """
        Return the unit at each level of each vertical line: a line passes each surface once.

        Parameters
        ----------
        feet : ndarray of float64, shape (n_line, 2)
            World coordinates [m].
        levels : ndarray of float64, shape (n_level,)
            Elevations, rising [m].

        Returns
        -------
        ndarray of int64, shape (n_line, n_level)
            Row of the unit; -1 outside the model.
        """
        return self._on_lines(Lines(feet - self.origin[:2], levels - self.origin[2], 0))

    def _on_lines(self, lines: Lines) -> np.ndarray:
        """Units of local lines that have the same levels."""
        n_line, n_level = len(lines.feet), len(lines.levels)
        return self._units(lines, n_line * n_level).reshape(n_line, n_level)

    def _units(self, lines: Lines, n_point: int) -> np.ndarray:
        """Units of all points, line by line."""
        unit = np.zeros(n_point, dtype=np.int64)
        if n_point:
            for group in self.groups:
                group.add(lines, self.rule, unit)
            self.listed.add(lines, self.rule, unit)

            # the outside is at the top of a line; each lower point adds what is between
            steps = unit.reshape(len(lines.feet), -1)[:, ::-1]
            unit = np.cumsum(steps, axis=1)[:, ::-1].ravel() - 1
        return unit


def locator_of(units: Units) -> Locator:
    """
    Make the surfaces of a model ready for vertical lines.

    Parameters
    ----------
    units : Units

    Returns
    -------
    Locator

    Raises
    ------
    InputError
        If the units were made without patches.
    """
    pieces, sides = units.piece_sides
    low, high = np.reshape(units.box, (3, 2)).T - pieces.origin
    rule = np.array([*(0.5 * (low + high))[:2], low[2]])
    box = np.stack([low, high])

    # runs of grids stay grids where no two points of the grid share a place on the map
    maps: list[list[tuple[Lattice, np.ndarray]]] = []
    lists = [_cut_triangles(pieces, sides)]
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        if strips is None or source.lattice is None:
            continue
        first = len(pieces.triangles) + int(pieces.first_run[i])
        run_sides = sides[first : first + len(strips.runs)]
        if cell_guess(source.lattice, pieces.origin) is None:
            lists.append(_run_triangles(source.lattice, strips, run_sides, pieces.origin))
        else:
            # a front that looks up has the unit behind it below: it does where triangles turn as
            # columns, rows and up do
            front_up = source.lattice.right_handed != source.lattice.turned
            step = (run_sides[:, 1] - run_sides[:, 0]) * (1 if front_up else -1)
            _put(maps, source.lattice, _spread(source.lattice, strips, step))

    groups = tuple(_grids(of, pieces.origin) for of in maps)
    corners, step = (np.concatenate(parts) for parts in zip(*lists, strict=True))
    return Locator(pieces.origin, rule, groups, _listed(corners, step), box)


def _cut_triangles(pieces: Pieces, sides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 3, 3) of all triangles that part two units, and the unit behind minus in front.

    Triangles that coincide with an earlier one have no units here: that one stands for them.
    """
    of = sides[: len(pieces.triangles)]
    rows = np.flatnonzero(of[:, 0] != of[:, 1])
    return pieces.x[pieces.triangles[rows]], of[rows, 1] - of[rows, 0]


def _run_triangles(
    lattice: Lattice, strips: Strips, sides: np.ndarray, origin: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The same for the runs of a grid that folds on the map, such as a vertical fault."""
    step = _spread(lattice, strips, sides[:, 1] - sides[:, 0])
    keys = np.flatnonzero(step)
    return corners_of(lattice, keys, origin), step[keys]


def _spread(lattice: Lattice, strips: Strips, values: np.ndarray) -> np.ndarray:
    """The value of each run at all of its triangles, by key; 0 where a curve touches them."""
    return np.append(values, 0)[strips.labels(0, lattice.shape[0] - 1).ravel()]


def _put(maps: list[list[tuple[Lattice, np.ndarray]]], lattice: Lattice, step: np.ndarray) -> None:
    """Put a grid to those that share its map and its diagonals."""
    for group in maps:
        one = group[0][0]
        if one.rising == lattice.rising and one.shares_map(lattice):
            group.append((lattice, step))
            return
    maps.append([(lattice, step)])


def _grids(group: list[tuple[Lattice, np.ndarray]], origin: np.ndarray) -> Grids:
    """All grids of one map."""
    lattice = group[0][0]
    guess = cell_guess(lattice, origin)
    assert guess is not None
    x, y, _ = lattice.coordinates

    # columns of steps: numbered one surface at a time, so that keys stay small
    column = np.zeros(len(group[0][1]), dtype=np.int64)
    for _, step in group:
        low, span = int(step.min(initial=0)), int(np.ptp(step)) + 1 if len(step) else 1
        _, column = number_keys(column * span + (step - low))
    steps = np.zeros((int(column.max(initial=-1)) + 2, len(group)), dtype=np.int64)
    for k, (_, step) in enumerate(group):
        steps[column + 1, k] = step

    # row 0 is that of cells where no surface is whole
    empty = np.append(True, ~steps[1:].any(axis=1))
    column = np.where(empty[column + 1], 0, column + 1)
    z = np.stack([one.elevation.ravel() - origin[2] for one, _ in group], axis=1)
    turn = 1 if lattice.right_handed else -1
    x, y = x - origin[0], y - origin[1]
    digits = digits_of(x, y, z[np.isfinite(z)])
    return Grids(x, y, lattice.places, z, column, steps, guess, turn, digits)


def _listed(corners: np.ndarray, step: np.ndarray) -> Listed:
    """Triangles (n, 3, 3) without those that are upright: these have no shadow."""
    rows = np.arange(3 * len(corners), dtype=np.int64).reshape(-1, 3)
    facing = signs_of_turns(corners.reshape(-1, 3)[:, :2], rows)
    sloping = np.flatnonzero(facing)
    # a front that looks up has the unit behind it below
    corners, facing = corners[sloping], facing[sloping]
    return Listed(corners, facing, step[sloping] * facing, digits_of(corners))
