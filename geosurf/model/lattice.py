"""Gridded surfaces: nodes in rows and columns, triangles by rule.

Kernels are imported where they are called: a reader has no use for them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.conventions import real_numbers
from geosurf.conventions.axes import COORDINATES
from geosurf.errors import InputError, SurfaceError
from geosurf.model.base import Noun, frozen

# ---- survey ----------------------------------------
# The survey of a lattice: bounds and checks from one pass over its nodes.


# ---- map frame ----------------------------------------
# Steps of a grid with 2-D coordinates in the map, and how far nodes are from even ones.


EVEN = 1e-6  # of a step: how far nodes of a map may be off equal steps


@dataclass(frozen=True)
class MapFrame:
    """
    What one pass over eastings and northings proves of a grid.

    Attributes
    ----------
    height : float
        No triangle is lower in the map [m], and none folds over another; 0: nothing is proven.
    column, row : (float, float)
        Mean steps to the next column and to the next row [m].
    off : float
        No node is farther from the first one and mean steps [m]; infinite where nothing is proven.

    Examples
    --------
    >>> MapFrame(10.0, (40.0, 30.0), (-30.0, 40.0), 1e-9).least_step
    (49.999999998, 49.999999998)
    """

    height: float
    column: tuple[float, float]
    row: tuple[float, float]
    off: float

    @classmethod
    def of(cls, found: np.ndarray) -> MapFrame:
        """Make one of what `geosurf.kernels.contacts.aligned_grids.map_frame` returns."""
        height, ux, uy, vx, vy, off = found.tolist()
        return cls(height, (ux, uy), (vx, vy), off)

    @property
    def determinant(self) -> float:
        """Of both steps, columns first [m2]."""
        return self.column[0] * self.row[1] - self.column[1] * self.row[0]

    @property
    def least_step(self) -> tuple[float, float]:
        """No step along columns, and along rows, is shorter [m]; below 0: nothing is proven."""
        return math.hypot(*self.column) - 2.0 * self.off, math.hypot(*self.row) - 2.0 * self.off

    def columns_and_rows(self, what: str) -> np.ndarray:
        """Columns and rows of each metre to the east and to the north (2, 2); steps are even."""
        if not self.off <= EVEN * min(self.least_step):
            raise InputError(
                f"the map of {what} is over a curvilinear grid, which cannot be used. Give a "
                "regular grid, which may be rotated."
            )
        return np.asarray(np.linalg.inv(np.array([self.column, self.row])))


# sums over cells, where they were not requested
@dataclass(frozen=True, eq=False)
class Survey:
    """Boxes of blocks of cells, and holes: see `geosurf.kernels.lattices.survey`.

    Attributes
    ----------
    nodes : ndarray of float64, shape (n_node, 6)
        Lower, then upper corner around each block of nodes [m], row by row, and around all that is
        below each node of the pyramid above them; an absent number is ignored.
    levels : ndarray of int64, shape (n_level, 3)
        First node, rows and columns of each level: see `geosurf.kernels.search.tree`.
    n_triangles : tuple of int
        Triangles with three nodes, if diagonals fall and if they rise.
    numbers : tuple of bool
        Whether all eastings, northings and elevations are numbers, not NaN.
    minus_zero : bool
        Whether a coordinate is -0.0, whose bits differ from those of 0.0.
    axes_rise : bool
        Whether easting and northing are axes that rise strictly, with finite ends.
    """

    nodes: np.ndarray
    levels: np.ndarray
    n_triangles: tuple[int, int]
    numbers: tuple[bool, bool, bool]
    minus_zero: bool
    axes_rise: bool

    @classmethod
    def of(
        cls, coordinates: tuple[np.ndarray, np.ndarray, np.ndarray], places: np.ndarray
    ) -> Survey:
        """Pass over all nodes of a lattice once.

        `coordinates` and `places` are those of `geosurf.model.Lattice`.
        """
        from geosurf.kernels.lattices import survey

        nodes, levels, marks = survey.survey_lattice(*coordinates, places)
        counts = marks.tolist()
        return cls(
            nodes=frozen(nodes, np.float64),  # views: kernels take what is below as it is
            levels=frozen(levels, np.int64),
            n_triangles=(counts[survey.N_FALLING], counts[survey.N_RISING]),
            numbers=tuple(count == 0 for count in counts[survey.NOT_A_NUMBER :][:3]),
            minus_zero=bool(counts[survey.MINUS_ZERO]),
            axes_rise=bool(counts[survey.AXES_RISE]),
        )

    @property
    def finite_map(self) -> bool:
        """Whether all eastings and northings are finite, and no coordinate is -0.0."""
        return all(self.numbers[:2]) and self.finite and not self.minus_zero

    def over_same_map(self, elevation: np.ndarray, shape: tuple[int, int]) -> Survey:
        """Return the survey of other elevations, flat, of nodes with the same finite places.

        One pass over elevations alone: boxes in the map are those of this survey.
        """
        n_row, n_col = shape
        layout = np.array([0, 0, 0, 0, 0, 0, 0, n_col, 1, n_row, n_col, 0, 0, 1], dtype=np.int64)
        zero = np.zeros(1)
        survey = Survey.of((zero, zero, elevation), layout)
        nodes = survey.nodes.copy()
        nodes[:, :2], nodes[:, 3:5] = self.nodes[:, :2], self.nodes[:, 3:5]
        return replace(survey, nodes=frozen(nodes, np.float64))

    @property
    def box(self) -> np.ndarray:
        """Lower and upper corner around all nodes [m], float64 (6,); inf and -inf around none."""
        around: np.ndarray = self.nodes[-1]
        return around

    @property
    def relief(self) -> float:
        """The largest difference in elevation inside of a block [m]: no step is higher."""
        # an empty block has its lower bound above its upper one
        leaves = self.nodes[: int(self.levels[0, 1] * self.levels[0, 2])]
        return float((leaves[:, 5] - leaves[:, 2]).max(initial=0.0))

    @cached_property
    def finite(self) -> bool:
        """Whether no coordinate is infinite."""
        # The box of all nodes shows infinite coordinates without another pass.
        box = self.box.tolist()
        return bool(min(box[:3]) > -math.inf and max(box[3:]) < math.inf)


# what eastings and northings alone tell, where they are 2-D
OF_MAP = ("easting", "northing", "map_blocks", "map_frame", "right_handed")
# what does not ask how cells are split and turned
OF_NODES = ("easting", "northing", "elevation", "coordinates", "survey", "whole", "extent",
             "present", "vertex_of_node",
             "map_blocks", "map_frame", "right_handed")  # fmt: skip


@dataclass(frozen=True, eq=False)
class Lattice(Noun):
    """Nodes of a gridded surface, before anyone asks for triangles.

    Attributes
    ----------
    easting, northing : ndarray of float64
        World coordinates [m]: 1-D ``(n_col,)`` and ``(n_row,)`` for an unrotated
        grid, or both 2-D ``(n_row, n_col)`` for rotated and curvilinear ones.
    elevation : ndarray of float64, shape (n_row, n_col)
        [m], positive up; NaN where there is no node.
    rising : bool
        Which diagonal splits each cell: True joins node ``(i, j)`` to
        ``(i + 1, j + 1)``, False ``(i, j + 1)`` to ``(i + 1, j)``.
        `geosurf.conventions.rising_diagonal` is the rule for horizons.
    reverse : bool or None
        How triangles turn. None (horizons): so that normals point up. False:
        from columns to rows; True: from rows to columns (faults, which may be
        vertical, so that the map does not determine it).

    Raises
    ------
    SurfaceError
        If arrays are not numeric, empty, or their shapes do not fit together.
    """

    easting: np.ndarray
    northing: np.ndarray
    elevation: np.ndarray
    rising: bool = True
    reverse: bool | None = None

    def __post_init__(self) -> None:
        # read-only: survey, keys and trees below are computed once and must stay true
        for key in COORDINATES:
            object.__setattr__(self, key, _read_only(_numbers(key, getattr(self, key))))
        shape, shapes = self.elevation.shape, (self.easting.shape, self.northing.shape)
        if len(shape) != 2 or shapes not in ((shape[1:], shape[:1]), (shape, shape)):
            raise SurfaceError(
                f"a lattice has easting of shape {shapes[0]}, northing {shapes[1]} and elevation "
                f"{shape}; expected (n_col,), (n_row,) and (n_row, n_col), or all (n_row, n_col)."
            )
        if 0 in shape:
            raise SurfaceError(
                f"a lattice has {shape[0]} x {shape[1]} nodes, but needs at least one. Leave "
                "it out."
            )

    def __repr__(self) -> str:
        n_row, n_col = self.shape
        return f"<Lattice: {n_row} x {n_col} nodes>"

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and columns of nodes."""
        n_row, n_col = self.elevation.shape
        return n_row, n_col

    @cached_property
    def coordinates(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Easting, northing, elevation as kernels take them: flat, not repeated."""
        # a broadcast array (a constant easting per column) enters once, whatever its shape
        x, y, z = (
            _once(part).reshape(-1) for part in (self.easting, self.northing, self.elevation)
        )
        return x, y, z

    @cached_property
    def places(self) -> np.ndarray:
        """Where what is in `coordinates`, for kernels: see ``geosurf.kernels.search.tree``."""
        return self._places(self.rising, self.turned)

    def _places(self, rising: bool, turned: bool) -> np.ndarray:
        """`places` for a diagonal and a sense, which nodes do not depend on."""
        # offset and steps along rows and columns of easting, then of northing: 1-D axes step along
        # one of the two
        flat = (0, 0, 1, 0, 1, 0)
        if self.easting.ndim == 2:
            flat = *_steps(self.easting), *_steps(self.northing)

        # then the shape, the diagonal, the turn, and 1 for `IS_LATTICE`
        rest = *self.shape, rising, turned, 1
        return frozen(np.array([*flat, *_steps(self.elevation), *rest], dtype=np.int64), np.int64)

    @cached_property
    def survey(self) -> Survey:
        """The survey of all nodes."""
        return Survey.of(self.coordinates, self.places)

    def turned_as(self, rising: bool, reverse: bool | None) -> Lattice:
        """Return the lattice with another diagonal and sense; what is known of nodes is shared."""
        # Nothing changes: the same object keeps all that was computed.
        if rising == self.rising and reverse is self.reverse:
            return self

        # shares arrays and what was computed of nodes; keys, normals and tree depend on the
        # diagonal and are made anew
        twin = object.__new__(type(self))
        mine = self.__dict__
        twin.__dict__.update({key: mine[key] for key in OF_NODES if key in mine})
        twin.__dict__.update(rising=rising, reverse=reverse)
        return twin

    @property
    def normals(self) -> tuple[np.ndarray, float, np.ndarray]:
        """Sum of all normals (length: area, not turned), of areas, and keys that may be flat."""
        from geosurf.kernels.lattices.lattice_corners import lattice_normals

        sums, keys = lattice_normals(*self.coordinates, self.places)
        return sums[:3], float(sums[3]), keys

    @property
    def n_node(self) -> int:
        """Number of nodes, absent ones too."""
        return self.elevation.size

    @cached_property
    def whole(self) -> bool:
        """Whether all nodes exist."""
        # No hole and nothing infinite: keys are consecutive then, and no mask is needed.
        return all(self.survey.numbers) and self.survey.finite

    @property
    def n_triangle(self) -> int:
        """Number of triangles: those with three nodes."""
        return self.survey.n_triangles[self.rising]

    @cached_property
    def map_height(self) -> float:
        """A lower bound of the heights of triangles in the map [m]; 0 if the map may fold.

        Axes that rise or fall strictly never fold; rows and columns in two dimensions do not where
        each step stays near the mean one (``geosurf.kernels.contacts.aligned_grids``).
        """
        return self._height_in_map()

    def _height_in_map(self) -> float:
        """`map_height` of the nodes alone, whatever triangles there are."""
        # axes: no fold if both rise or fall strictly; a triangle with legs a and b has the height a
        # b / hypot(a, b) over its diagonal, at least min(a, b) / sqrt(2)
        if self.easting.ndim == 1:
            steps = np.concatenate([np.diff(self.easting), np.diff(self.northing)])
            n = len(self.easting) - 1
            if not all((part > 0).all() or (part < 0).all() for part in (steps[:n], steps[n:])):
                return 0.0
            return 0.7 * float(np.abs(steps).min(initial=np.inf))
        return self.map_frame.height

    @cached_property
    def map_frame(self) -> MapFrame:
        """Steps in the map, and what is proven of them; easting and northing are 2-D."""
        from geosurf.kernels.contacts.aligned_grids import map_frame

        # no layout that asks for the sense of triangles: it follows from these steps
        return MapFrame.of(map_frame(*self.coordinates[:2], self._places(False, False)))

    def has_map(self, easting: np.ndarray, northing: np.ndarray) -> bool:
        """Whether 2-D coordinates are those of this lattice, to the last bit."""
        both = (self.easting, easting), (self.northing, northing)
        if any(one.shape != other.shape or other.dtype != one.dtype for one, other in both):
            return False
        # corners differ for nearly all pairs of grids; comparing all takes a pass over memory
        if any(a is not b and (a[::a.shape[0] - 1 or 1, ::a.shape[1] - 1 or 1]
                               != b[::b.shape[0] - 1 or 1, ::b.shape[1] - 1 or 1]).any()
               for a, b in both):  # fmt: skip
            return False
        bits = ((a, np.ascontiguousarray(b)) for a, b in both if a is not b)
        return all(np.array_equal(a.view(np.int64), b.view(np.int64)) for a, b in bits)

    def with_elevation(self, elevation: np.ndarray) -> Lattice:
        """Return a lattice over the same map: easting and northing are 2-D, and held once."""
        made = Lattice(self.easting, self.northing, elevation, self.rising, self.reverse)
        # the same arrays, not views of them: who compares maps sees it at once
        made.__dict__.update({key: self.__dict__[key] for key in OF_MAP if key in self.__dict__})
        survey, z = self.survey, made.coordinates[2]
        if survey.finite_map:
            made.__dict__["survey"] = survey.over_same_map(z, made.shape)
        return made

    @property
    def is_graph(self) -> bool:
        """Whether no two points are known to share a place in the map."""
        return self.map_height > 0.0

    def shares_map(self, other: Lattice) -> bool:
        """Whether two graphs have the same nodes in the map, one by one."""
        if self.shape != other.shape:
            return False
        both = (self.easting, other.easting), (self.northing, other.northing)

        # the first numbers differ for nearly all pairs of grids; comparing all takes a pass over
        # memory
        if not all(a is b or a.flat[0] == b.flat[0] for a, b in both):  # most differ at once
            return False
        if not (self.is_graph and other.is_graph):
            return False
        return all(a is b or np.array_equal(a, b) for a, b in both)

    @property
    def has_rising_axes(self) -> bool:
        """Whether easting and northing are axes of their own, and rise."""
        return self.easting.ndim == 1 and self.survey.axes_rise

    @cached_property
    def map_blocks(self) -> MapBlocks:
        """Boxes in the map around blocks of cells; easting and northing are 2-D."""
        return MapBlocks(self.easting, self.northing)

    def cells_where(self, meets: Meets) -> np.ndarray:
        """All cells whose boxes in the map (low (n, 2), high (n, 2)) meet something; 2-D."""
        return self.map_blocks.cells_where(meets)

    @cached_property
    def extent(self) -> np.ndarray:
        """South-west and north-east corner around all nodes [m], float64 (2, 2)."""
        # an empty box (no node) has its lower bounds above its upper ones: NaN instead
        west, south, _, east, north, _ = self.survey.box.tolist()
        west, east = (west, east) if west <= east else (math.nan, math.nan)
        south, north = (south, north) if south <= north else (math.nan, math.nan)
        return frozen([[west, south], [east, north]], np.float64)

    def corners_of_box(self) -> np.ndarray:
        """Lower and upper corner around all nodes [m], float64 (2, 3); all nodes exist."""
        return self.survey.box.reshape(2, 3)

    def corners_in_use(self) -> np.ndarray | None:
        """Corners around the nodes that triangles use, float64 (2, 3); None if not known."""
        return self.corners_of_box() if self.whole else None

    @property
    def n_present(self) -> int:
        """Number of nodes that exist."""
        return self.n_node if self.whole else int(self.present.sum())

    @cached_property
    def keys(self) -> np.ndarray:
        """Keys ``2 * cell + half`` of the triangles that exist, in order, int64 (n_triangle,)."""
        # candidates are two halves of each cell; those with an absent node are dropped
        n_row, n_col = self.shape
        every = np.arange(2 * max(n_row - 1, 0) * max(n_col - 1, 0))
        corners = self.corners_of_keys(every)
        return frozen(every[self.present.ravel()[corners].all(axis=1)], np.int64)

    def corners_of_keys(self, keys: np.ndarray) -> np.ndarray:
        """Nodes (row by row, absent ones counted) of triangles by key, int64 (n, 3).

        ``key = 2 * cell + half``, cells and halves in the order of `build_triangles`.
        """
        from geosurf.kernels.lattices.lattice_corners import lattice_corners

        corners: np.ndarray = lattice_corners(self.places, keys)
        return corners

    def places_of_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """World coordinates (n, 3) of nodes, row by row."""
        from geosurf.kernels.lattices.lattice_corners import lattice_nodes

        places: np.ndarray = lattice_nodes(*self.coordinates, self.places, nodes)
        return places

    def rows_of_keys(self, keys: np.ndarray) -> np.ndarray:
        """Rows of `build_triangles` for keys of triangles that exist."""
        # all nodes present: keys and rows are the same, and no array is made
        return keys if self.whole else np.searchsorted(self.keys, keys)

    def keys_of_rows(self, rows: np.ndarray) -> np.ndarray:
        """Keys of triangles for rows of `build_triangles`."""
        return rows if self.whole else self.keys[rows]

    @cached_property
    def present(self) -> np.ndarray:
        """Mask (n_row, n_col) of the nodes that exist."""
        easting, northing = self.horizontal()
        mask: np.ndarray = (
            np.isfinite(self.elevation) & np.isfinite(easting) & np.isfinite(northing)
        )
        mask.flags.writeable = False
        return mask

    @cached_property
    def gaps(self) -> np.ndarray:
        """Triangles that do not exist, in the form of `geosurf.kernels.lattices.strips`."""
        from geosurf.kernels.lattices.strips import gaps_of_holes

        if self.whole:
            return frozen(np.empty(0), np.int64)
        # intervals of absent nodes: row, first and last column; beginnings and ends take turns
        edge = np.diff(np.pad(~self.present, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        row, column = np.nonzero(edge)
        holes = np.stack([row[::2], column[::2], column[1::2] - 1], axis=1).astype(np.int64)
        start = np.searchsorted(holes[:, 0], np.arange(self.shape[0] + 1))
        return frozen(gaps_of_holes(*self.shape, self.rising, start, holes), np.int64)

    @cached_property
    def vertex_of_node(self) -> np.ndarray:
        """Vertex number of each node, int64 (n_row, n_col); -1 where absent."""
        # rank among present nodes, row by row
        number = np.cumsum(self.present.ravel()) - 1
        return frozen(np.where(self.present, number.reshape(self.shape), -1), np.int64)

    def horizontal(self) -> tuple[np.ndarray, np.ndarray]:
        """Easting and northing of all nodes, each (n_row, n_col)."""
        if self.easting.ndim == 2:
            return self.easting, self.northing
        easting, northing = np.broadcast_arrays(self.easting[None, :], self.northing[:, None])
        return easting, northing

    def map_places(self, nodes: np.ndarray) -> np.ndarray:
        """Easting and northing (n, 2) of nodes, row by row."""
        row, col = np.divmod(nodes, self.shape[1])
        easting, northing = self.horizontal()
        return np.stack([easting[row, col], northing[row, col]], axis=-1)

    def build_vertices(self) -> np.ndarray:
        """World coordinates (n_vertex, 3) of the nodes that exist, row by row."""
        if self.whole:
            return self.places_of_nodes(np.arange(self.n_node))
        easting, northing = self.horizontal()
        keep = self.present
        return np.stack([easting[keep], northing[keep], self.elevation[keep]], axis=1)

    def build_triangles(self) -> np.ndarray:
        """Triangles (n_triangle, 3), cell by cell; normals point up, or down with ``reverse``.

        A triangle exists only where its three nodes do.
        """
        if self.whole:
            n_row, n_col = self.shape
            keys = np.arange(2 * max(n_row - 1, 0) * max(n_col - 1, 0))
            return self.corners_of_keys(keys)

        # nodes are turned into vertices: absent nodes do not count
        rows: np.ndarray = self.vertex_of_node.ravel()[self.corners_of_keys(self.keys)]
        return rows

    @property
    def turned(self) -> bool:
        """Whether triangles turn from rows to columns."""
        return not self.right_handed if self.reverse is None else self.reverse

    @cached_property
    def right_handed(self) -> bool:
        """Whether columns, rows and up make a right-handed system."""
        if min(self.shape) < 2:
            return True
        x, y = self.easting, self.northing

        # the sign of the product of both steps; outer nodes, so that it holds for axes with equal
        # neighbours
        if x.ndim == 1:
            n, m = len(x) - 1, len(y) - 1
            return bool((x.item(n) > x.item(0)) == (y.item(m) > y.item(0)))

        # all cells turn as the mean steps do, where each step is proven to be near these
        if self.map_frame.height > 0.0:
            return self.map_frame.determinant > 0.0

        # majority of the cells' orientations: single folded cells do not turn the lattice
        with np.errstate(invalid="ignore", over="ignore"):  # infinite ones are refused later
            cell = (x[:-1, 1:] - x[:-1, :-1]) * (y[1:, :-1] - y[:-1, :-1]) - (
                y[:-1, 1:] - y[:-1, :-1]
            ) * (x[1:, :-1] - x[:-1, :-1])
        return bool(np.nansum(np.sign(cell)) >= 0)


def _read_only(array: np.ndarray) -> np.ndarray:
    """A read-only view in one piece; one whose rows or columns are all alike is not expanded."""
    # np.broadcast_to views keep their zero stride, so that a plane of 10^8 nodes takes no memory
    if array.ndim == 2 and _zero_steps(array):
        view = array.view()
        view.flags.writeable = False
        return view
    return frozen(array, np.float64)


def _zero_steps(array: np.ndarray) -> tuple[int, ...]:
    """Axes that step over no memory, being broadcast."""
    if all(array.strides):
        return ()
    return tuple(k for k in (0, 1) if array.strides[k] == 0 and array.shape[k] > 1)


def _once(array: np.ndarray) -> np.ndarray:
    """An array without what is broadcast."""
    # axis 0 or 1 of stride 0 with more than one row: only its first row or column is kept
    repeated = _zero_steps(array) if array.ndim == 2 else ()
    if not repeated:
        return array
    rows = slice(0, 1) if 0 in repeated else slice(None)
    return np.ascontiguousarray(array[rows, : 1 if 1 in repeated else None])


def _steps(array: np.ndarray) -> tuple[int, int, int]:
    """Offset and steps along rows and columns, in `_once` of a two-dimensional array."""
    repeated = _zero_steps(array)
    n_col = 1 if 1 in repeated else array.shape[1]
    return 0, 0 if 0 in repeated else n_col, 0 if 1 in repeated else 1


def _numbers(key: str, values: Any) -> Any:
    """Values as float64, masked ones not-a-number, or a SurfaceError."""
    try:
        return real_numbers(values)
    except (TypeError, ValueError) as error:
        raise SurfaceError(
            f"{key} of a lattice is not numeric ({error}). Give an array of metres."
        ) from error


_SIDE = 16  # cells along a side of a block
Meets = Callable[[np.ndarray, np.ndarray], np.ndarray]


class MapBlocks:
    """
    Boxes around blocks of cells.

    Parameters
    ----------
    easting, northing : ndarray of float64, shape (n_row, n_col)
        Of the nodes [m]; NaN where there is none.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(40.0), np.arange(30.0))
    >>> blocks = MapBlocks(x + y, y - x)
    >>> blocks.cells_where(lambda low, high: low[:, 0] < 2).tolist()
    [0, 1, 39]
    """

    def __init__(self, easting: np.ndarray, northing: np.ndarray) -> None:
        self._map = easting, northing
        low, high = (
            np.stack([_blocks_of(of, extreme) for of in self._map], axis=-1)
            for extreme in (np.fmin, np.fmax)
        )
        self._shape = low.shape[:2]
        self._boxes = low.reshape(-1, 2), high.reshape(-1, 2)

    def cells_where(self, meets: Meets) -> np.ndarray:
        """Return all cells whose boxes in the map (low (n, 2), high (n, 2)) meet something."""
        n_row, n_col = (n - 1 for n in self._map[0].shape)
        row, col = np.divmod(np.flatnonzero(meets(*self._boxes)), self._shape[1])
        inside = np.arange(_SIDE)
        rows, cols = np.broadcast_arrays(
            (_SIDE * row[:, None] + inside)[:, :, None], (_SIDE * col[:, None] + inside)[:, None]
        )
        some = (rows < n_row) & (cols < n_col)
        rows, cols = rows[some], cols[some]

        # the four nodes of each cell of these blocks
        corners = [
            np.stack([of[rows + i, cols + j] for of in self._map], axis=-1)
            for i, j in ((0, 0), (0, 1), (1, 0), (1, 1))
        ]
        near = meets(np.fmin.reduce(corners), np.fmax.reduce(corners))
        found: np.ndarray = np.sort(rows[near] * n_col + cols[near])
        return found


def _blocks_of(values: np.ndarray, extreme: np.ufunc) -> np.ndarray:
    """Lowest or highest value (n_row_block, n_col_block) of the nodes of each block."""
    for axis in (0, 1):
        starts = np.arange(0, max(values.shape[axis] - 1, 1), _SIDE)
        extremes = extreme.reduceat(values, starts, axis=axis)

        # the last nodes of a block are the first ones of the next
        ends = np.take(values, np.minimum(starts + _SIDE, values.shape[axis] - 1), axis=axis)
        values = extreme(extremes, ends)
    return values
