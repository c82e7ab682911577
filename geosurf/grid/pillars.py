"""Pillars, what lies at their corners, and the layers between them.

Each column is sampled along four lines inside it, at the Gauss points: what lies across a fault at
its edge does not count. Columns that no fault parts share the mean of their corners. Thicknesses
are averaged and limited, not clipped, so that their sum over all columns stays that of the samples.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import check_name, is_number
from geosurf.errors import InputError
from geosurf.model.grids import GAUSS

ROUNDS = 40
CLOSE = 1e-9  # of a cell: rounds end here
CORNERS = ((0, 0), (0, 1), (1, 0), (1, 1))
TURNS = ((0, 1, 2), (1, 3, 0), (2, 0, 3), (3, 2, 1))  # a corner, the next one, the last one


@dataclass(frozen=True, eq=False)
class Pillars:
    """Straight pillars in coordinates of the lattice: cells along I and J, elevation in metres.

    Attributes
    ----------
    shift : ndarray of float64, shape (ny + 1, nx + 1, 2)
        From the node of the lattice, at `level` [cells].
    slope : ndarray of float64, shape (ny + 1, nx + 1, 2)
        Change per metre upwards [cells / m].
    level : ndarray of float64, shape (ny + 1, nx + 1)
        Elevation of the middle of the grid [m].
    reach : ndarray of float64, shape (ny + 1, nx + 1)
        Height above and below `level` over which pillars must not cross [m].
    """

    shift: np.ndarray
    slope: np.ndarray
    level: np.ndarray
    reach: np.ndarray

    @property
    def vertical(self) -> bool:
        """Whether all pillars are vertical, on the nodes of the lattice."""
        return not (self.shift.any() or self.slope.any())

    def at(self, z: float) -> np.ndarray:
        """Places of all pillars at an elevation, (ny + 1, nx + 1, 2)."""
        ny, nx = self.level.shape
        node = np.stack(np.meshgrid(np.arange(nx), np.arange(ny)), axis=-1)
        return node + self.shift + self.slope * (z - self.level)[..., None]

    def places(self, node: tuple[np.ndarray, np.ndarray], z: np.ndarray) -> np.ndarray:
        """Places of the pillars of nodes, rows J and I (n,), each at an elevation, (n, 2)."""
        j, i = node
        rise = (z - self.level[node])[..., None]
        return np.stack([i, j], axis=-1) + self.shift[node] + self.slope[node] * rise

    def least_areas(self) -> tuple[np.ndarray, np.ndarray]:
        """Smallest area at each corner of each cell, and its elevation, each (4, ny, nx).

        Of the parallelogram of the two sides at a corner, in cells, within reach: not positive
        where a cell is not convex. Corners are in the order of `CORNERS`. Along straight pillars an
        area is a quadratic function of elevation.
        """
        ny, nx = self.level.shape[0] - 1, self.level.shape[1] - 1
        j, i = np.meshgrid(np.arange(ny), np.arange(nx), indexing="ij")
        nodes = [(j + m, i + k) for m, k in CORNERS]
        low = np.min([(self.level - self.reach)[node] for node in nodes], axis=0)
        high = np.max([(self.level + self.reach)[node] for node in nodes], axis=0)

        def areas(z: np.ndarray) -> np.ndarray:
            x = [self.places(node, z) for node in nodes]
            return np.stack([_turn(x, corner) for corner in TURNS])

        # a parabola through three values: its least value on the way
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        a, b, c = (areas(z) for z in (low, middle, high))
        curve, rise = a + c - 2.0 * b, c - a
        with np.errstate(invalid="ignore", divide="ignore"):
            at = -0.5 * rise / curve
            bottom = np.where((curve > 0) & (np.abs(at) < 1), b - rise * rise / (8 * curve), np.inf)
        values = np.stack([a, b, c, bottom])
        heights = np.stack([np.broadcast_to(one, a.shape) for one in (low, middle, high)])
        lowest = np.where(np.isfinite(bottom), at, 0.0)
        heights = np.concatenate([heights, (middle + half * lowest)[None]])
        first = values.argmin(axis=0)[None]
        return (
            np.take_along_axis(values, first, axis=0)[0],
            np.take_along_axis(heights, first, axis=0)[0],
        )

    def straighten(self, x: np.ndarray) -> np.ndarray:
        """Coordinates (n, 3) in which pillars are vertical, at whole numbers.

        Between pillars, places are bilinear at each elevation; the inverse is found by Newton's
        method. Beyond reach of `level` pillars count as vertical: no cell of the grid is there.
        """
        if self.vertical:
            return x
        out = x.copy()
        rows = np.arange(len(x))
        for _ in range(ROUNDS):
            off, (a, b, c, d) = self._offset(out[rows], x[rows, 2])
            gap = out[rows, :2] + off - x[rows, :2]
            det = a * d - b * c
            det = np.where(np.abs(det) > 0.05, det, 1.0)
            step = np.stack([d * gap[:, 0] - b * gap[:, 1], a * gap[:, 1] - c * gap[:, 0]], 1)
            out[rows, :2] -= np.clip(step / det[:, None], -0.5, 0.5)
            rows = rows[np.abs(gap).max(axis=1, initial=0.0) > CLOSE]
            if not len(rows):
                break
        return out

    def ends(self, feet: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where lines parallel to pillars (n, 2) are at both ends of the reach, each (n, 2)."""
        node = tuple(np.round(feet[:, ::-1]).astype(np.int64).T)
        low, high = (self.level + sign * self.reach for sign in (-1.0, 1.0))
        return feet + self._offset(feet, low[node])[0], feet + self._offset(feet, high[node])[0]

    def _offset(self, at: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
        """Offset at places (n, 2), and the Jacobian of place plus offset."""
        ny, nx = self.level.shape[0] - 1, self.level.shape[1] - 1
        u, v = np.clip(at[:, 0], 0.0, nx), np.clip(at[:, 1], 0.0, ny)
        i, j = np.minimum(u.astype(np.int64), nx - 1), np.minimum(v.astype(np.int64), ny - 1)
        a, b = (u - i)[:, None], (v - j)[:, None]
        corners = []
        for m, k in CORNERS:
            at_node = (j + m, i + k)
            most = 2.5 * self.reach[at_node]
            dz = np.clip(z - self.level[at_node], -most, most)
            corners.append(self.shift[at_node] + self.slope[at_node] * dz[:, None])
        p, q, r, s = corners
        off = (1 - a) * ((1 - b) * p + b * r) + a * ((1 - b) * q + b * s)
        du, dv = (1 - b) * (q - p) + b * (s - r), (1 - a) * (r - p) + a * (s - q)

        # beyond the rim the offset of the rim goes on
        du *= ((at[:, 0] > 0) & (at[:, 0] < nx))[:, None]
        dv *= ((at[:, 1] > 0) & (at[:, 1] < ny))[:, None]
        return off, (1.0 + du[:, 0], dv[:, 0], du[:, 1], 1.0 + dv[:, 1])


def _turn(x: list[np.ndarray], corner: tuple[int, int, int]) -> np.ndarray:
    """Area of the parallelogram at a corner, of its next and last corner counter-clockwise."""
    at, ahead, back = (x[k] for k in corner)
    u, v = ahead - at, back - at
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def vertical_pillars(shape: tuple[int, int]) -> Pillars:
    """Return pillars on the nodes of a lattice of rows and columns."""
    zero = np.zeros((shape[0] + 1, shape[1] + 1, 2))
    return Pillars(zero, zero, zero[..., 0], zero[..., 0])


# from the values at two Gauss points of a unit interval to its ends, linearly
_TO_ENDS = np.array([[1.0 + np.sqrt(3.0), 1.0 - np.sqrt(3.0)]] * 2) / 2.0
_TO_ENDS[1] = _TO_ENDS[1, ::-1]


def gauss_feet(shape: tuple[int, int]) -> np.ndarray:
    """Places of the Gauss points of all columns, in lattice coordinates, (ny, nx, 2, 2, 2)."""
    j, i = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    feet = np.empty((*shape, 2, 2, 2))
    feet[..., 0] = (i[..., None] + GAUSS)[:, :, None, :]
    feet[..., 1] = (j[..., None] + GAUSS)[:, :, :, None]
    return feet


def to_corners(samples: np.ndarray) -> np.ndarray:
    """Values at the corners of columns, of values at their Gauss points, (..., 2, 2)."""
    return np.einsum("aj,bi,...ji->...ab", _TO_ENDS, _TO_ENDS, samples)


def limited(corners: np.ndarray) -> np.ndarray:
    """Thicknesses (..., 2, 2) with smaller differences where one is negative, and the same mean."""
    mean = corners.mean(axis=(-1, -2), keepdims=True)
    low = corners.min(axis=(-1, -2), keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(low < 0.0, mean / (mean - low), 1.0)
    # rounding may leave -1e-16: a thickness is never negative
    return np.maximum(mean + share * (corners - mean), 0.0)


def filled(samples: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Samples (..., 2, 2, n) of which those that are not valid take the mean of the others."""
    count = valid.sum(axis=(-1, -2))[..., None, None, None]
    total = np.where(valid[..., None], samples, 0.0).sum(axis=(-2, -3), keepdims=True)
    mean = total / np.maximum(count, 1)
    return np.where(valid[..., None], samples, mean)


def groups_at_nodes(apart_i: np.ndarray, apart_j: np.ndarray, used: np.ndarray) -> np.ndarray:
    """
    Group the four columns around each node by the faults between them.

    Parameters
    ----------
    apart_i : ndarray of bool, shape (ny, nx - 1)
        Whether a fault parts a column from the next along I.
    apart_j : ndarray of bool, shape (ny - 1, nx)
        The same along J.
    used : ndarray of bool, shape (ny, nx)
        Columns inside the model.

    Returns
    -------
    ndarray of int64, shape (ny + 1, nx + 1, 4)
        Group of the columns south-west, south-east, north-west and north-east of each node: the
        smallest number of a column in it; 4 for columns that are not used.
    """
    ny, nx = used.shape
    room = np.zeros((ny + 2, nx + 2), dtype=bool)
    room[1:-1, 1:-1] = used
    here = np.stack([room[:-1, :-1], room[:-1, 1:], room[1:, :-1], room[1:, 1:]], axis=-1)

    # the ring around a node: south, north (along I), west, east (along J)
    along_i = np.ones((ny + 2, nx + 1), dtype=bool)
    along_i[1:-1, 1:-1] = apart_i
    along_j = np.ones((ny + 1, nx + 2), dtype=bool)
    along_j[1:-1, 1:-1] = apart_j
    links = (
        (0, 1, along_i[:-1]), (2, 3, along_i[1:]), (0, 2, along_j[:, :-1]), (1, 3, along_j[:, 1:])
    )  # fmt: skip

    # the smallest number spreads: three rounds reach every column of a ring of four
    group = np.where(here, np.arange(4), 4)
    for _ in range(3):
        for a, b, apart in links:
            joined = ~apart & here[..., a] & here[..., b]
            both = np.minimum(group[..., a], group[..., b])
            group[..., a] = np.where(joined, both, group[..., a])
            group[..., b] = np.where(joined, both, group[..., b])
    return group


def joined(corners: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Corners (ny, nx, 2, 2, n) of which those of one group at a node share their mean."""
    ny, nx, _, _, n = corners.shape
    total, count = np.zeros((ny + 1, nx + 1, 5, n)), np.zeros((ny + 1, nx + 1, 5))
    j, i = np.meshgrid(np.arange(ny), np.arange(nx), indexing="ij")

    # the column north-east of a node (3) has its own corner (0, 0) there
    places = [(j + a, i + b, 3 - 2 * a - b, a, b) for a, b in CORNERS]
    for jj, ii, column, a, b in places:
        np.add.at(total, (jj, ii, group[jj, ii, column]), corners[:, :, a, b])
        np.add.at(count, (jj, ii, group[jj, ii, column]), 1.0)
    mean = total / np.maximum(count, 1.0)[..., None]
    out = np.empty_like(corners)
    for jj, ii, column, a, b in places:
        out[:, :, a, b] = mean[jj, ii, group[jj, ii, column]]
    return out


MOST_LAYERS = 10_000
PARALLEL = ("top", "base")
_EXAMPLE = (
    'Give a number of layers, layers={"Top/Base": 10}, or a thickness, '
    'layers={"Top/Base": {"thickness": 5, "parallel": "top"}}.'
)


@dataclass(frozen=True)
class Layers:
    """How a zone is divided.

    Attributes
    ----------
    count : int or None
        Proportional layers; None for layers of one thickness.
    thickness : float
        [m]
    parallel : {"", "top", "base"}
    """

    count: int | None
    thickness: float = 0.0
    parallel: str = ""

    def boundaries(self, thickness: np.ndarray) -> np.ndarray:
        """Depth of the boundaries below the top of the zone [m], (n_layer + 1, ...)."""
        if self.count is not None:
            share = np.linspace(0.0, 1.0, self.count + 1)
            return share.reshape(-1, *[1] * thickness.ndim) * thickness

        # as many layers as the thickest place needs; they pinch out elsewhere
        largest = float(thickness.max(initial=0.0))
        n = max(1, int(np.ceil(largest / self.thickness - 1e-9)))
        if n > MOST_LAYERS:
            raise InputError(
                f"layers of {self.thickness:g} m in a zone of up to {largest:.1f} m are {n} "
                f"layers; the limit is {MOST_LAYERS}. Choose a larger thickness."
            )
        depth = self.thickness * np.arange(n + 1.0).reshape(-1, *[1] * thickness.ndim)
        depth[-1] = np.inf
        from_top = np.minimum(depth, thickness)
        return from_top if self.parallel == "top" else thickness - from_top[::-1]


def layers_of(layers: Any, zones: Sequence[str], between: Sequence[str]) -> dict[str, Layers]:
    """
    Return the layers of each zone of a grid, from the top down.

    Parameters
    ----------
    layers : int or mapping
        As users give it; see `build_grid`.
    zones : sequence of str
        All zones of the model, from the top down.
    between : sequence of str
        Those to which one number for all refers.

    Returns
    -------
    dict of str to Layers

    Raises
    ------
    InputError
        For unknown zones, zones between which one is left out, or layers that are not understood.
    """
    if not isinstance(layers, Mapping):
        if not between:
            raise InputError(f"the model has no zone of the reservoir. {_EXAMPLE}")
        layers = dict.fromkeys(between, layers)
    for name in layers:
        check_name(name, zones, f"layers has no zone {name!r} to divide. Zones are")
    rows = sorted(zones.index(name) for name in layers)
    if not rows:
        raise InputError(f"layers is empty. {_EXAMPLE}")
    missing = [zones[k] for k in range(rows[0], rows[-1]) if k not in rows]
    if missing:
        raise InputError(
            f'layers leaves out {missing[0]!r}, between zones that it has. Add "{missing[0]}": 1.'
        )
    return {zones[k]: _one(zones[k], layers[zones[k]]) for k in rows}


def _one(zone: str, given: Any) -> Layers:
    """Layers of one zone."""
    if is_number(given) and float(given) == int(given) and 1 <= given <= MOST_LAYERS:
        return Layers(int(given))
    if isinstance(given, Mapping) and set(given) == {"thickness", "parallel"}:
        size, way = given["thickness"], given["parallel"]
        if is_number(size) and np.isfinite(size) and size > 0 and way in PARALLEL:
            return Layers(None, float(size), way)
    raise InputError(f"layers of zone {zone!r} are {given!r}. {_EXAMPLE}")
