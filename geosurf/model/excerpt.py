"""A part of a model as plain triangles, in the order of the whole: what is near some places.

Of grids only the cells near the places are listed. Points and triangles keep the order that
`Patches` and the shells of units give them: whoever works on the part gets the bytes that the whole
gives.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from geosurf.kernels.lattices.sets import distinct, ranges
from geosurf.model.base import in_crs_of
from geosurf.model.lattice import Lattice
from geosurf.model.patches import Patches
from geosurf.model.pieces import Pieces
from geosurf.model.surfaces import TriSurface
from geosurf.model.units import Unit, Units

# ---- close-ups ----------------------------------------


@dataclass(frozen=True, eq=False)
class CloseUp:
    """
    What a picture of an error shows, where its scene does not have that yet.

    Attributes
    ----------
    surfaces : tuple of TriSurface
        As they were when it failed.
    reach : float or None
        Half width of the picture [m]; None: a share of the extent of all surfaces.
    rim : ndarray of float64 (n, 2, 3)
        Edges that would close the hole [m].
    points : mapping of str to ndarray of float64 (m, 3)
        Data near the place, by what became of them [m].
    """

    surfaces: tuple[TriSurface, ...]
    reach: float | None = None
    rim: np.ndarray = field(default_factory=lambda: np.empty((0, 2, 3)))
    points: Mapping[str, np.ndarray] = field(default_factory=dict)


# ---- regions ----------------------------------------
# Places in the map near which a model is listed: boxes, a line.


_SLACK = 1e-9  # of the size of coordinates: far more than rounding


@dataclass(frozen=True, eq=False)
class Line:
    """
    A straight line without ends, from a through b.

    Examples
    --------
    >>> grid = Lattice(np.arange(4.0), np.arange(3.0), np.zeros((3, 4)))
    >>> Line(np.array([0.5, 0.0]), np.array([0.5, 9.0])).cells(grid).tolist()
    [0, 3]
    """

    a: np.ndarray
    b: np.ndarray

    def cells(self, lattice: Lattice) -> np.ndarray:
        """All cells that the line meets, and some next to it."""
        if lattice.easting.ndim == 2:
            return lattice.cells_where(self.meets)
        x, y = lattice.easting, lattice.northing
        rows = np.stack([np.minimum(y[:-1], y[1:]), np.maximum(y[:-1], y[1:])])
        west, east = self._span(*rows)
        turn = x[0] > x[-1]
        axis = -x if turn else x
        west, east = (-east, -west) if turn else (west, east)
        first = np.maximum(np.searchsorted(axis, west, side="left") - 1, 0)
        last = np.minimum(np.searchsorted(axis, east, side="right") - 1, len(x) - 2)
        row, column = ranges(first, np.maximum(last - first + 1, 0))
        found: np.ndarray = row * (len(x) - 1) + column
        return found

    def meets(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Which boxes the line may meet."""
        west, east = self._span(low[:, 1], high[:, 1])
        mask: np.ndarray = (low[:, 0] <= east) & (high[:, 0] >= west)
        return mask

    def _span(self, south: np.ndarray, north: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """From west to east, where the line is between two northings; inside out if it is not."""
        (ax, ay), (dx, dy) = self.a, self.b - self.a
        slack = _SLACK * float(np.abs([self.a, self.b]).max() + 1.0)
        if dy == 0:
            there = (south - slack <= ay) & (north + slack >= ay)
            return np.where(there, -np.inf, np.inf), np.where(there, np.inf, -np.inf)
        one, two = ((y - ay) * (dx / dy) for y in (south - slack, north + slack))
        more = slack + _SLACK * np.maximum(np.abs(one), np.abs(two))
        return ax + np.minimum(one, two) - more, ax + np.maximum(one, two) + more


@dataclass(frozen=True, eq=False)
class Boxes:
    """
    Boxes in the map.

    Attributes
    ----------
    low, high : ndarray of float64, shape (n, 2)
        South-west and north-east corners [m]; may be infinite.
    """

    low: np.ndarray
    high: np.ndarray

    def cells(self, lattice: Lattice) -> np.ndarray:
        """All cells that meet a box."""
        if lattice.easting.ndim == 2:
            return lattice.cells_where(self.meets)
        in_boxes = [np.empty(0, dtype=np.int64)]
        for low, high in zip(self.low, self.high, strict=True):
            (cols, rows) = (
                _between(axis, low[k], high[k])
                for k, axis in enumerate((lattice.easting, lattice.northing))
            )
            in_boxes.append((rows[:, None] * (lattice.shape[1] - 1) + cols).reshape(-1))
        return distinct(*in_boxes)

    def meets(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Which boxes meet one of these."""
        mask = np.zeros(len(low), dtype=bool)
        for south_west, north_east in zip(self.low, self.high, strict=True):
            mask |= ((low <= north_east) & (high >= south_west)).all(axis=1)
        return mask


def _between(axis: np.ndarray, low: float, high: float) -> np.ndarray:
    """Cells along an axis that meet an interval."""
    ends = np.minimum(axis[:-1], axis[1:]), np.maximum(axis[:-1], axis[1:])
    return np.flatnonzero((ends[0] <= high) & (ends[1] >= low))


Chosen = tuple[np.ndarray, np.ndarray, np.ndarray]
_NONE = np.empty(0, dtype=np.int64)


class Region(Protocol):
    """Places in the map, in world coordinates."""

    def cells(self, lattice: Lattice) -> np.ndarray:
        """Return all cells of a grid that may be near, rising, int64 (n,); some more do no harm."""

    def meets(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return which boxes (n, 2), (n, 2) in the map may be near, bool (n,)."""


@dataclass(frozen=True, eq=False)
class Excerpt:
    """
    Some triangles of some pieces.

    Attributes
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
        Local coordinates of the points in use, in the order of `Patches.local`.
    triangles : ndarray of int64, shape (n, 3)
        In the order of `Patches.triangles`.
    surface, element : ndarray of int64, shape (n,)
        Surface of each, and the element of the pieces that it is of.
    """

    x: np.ndarray
    triangles: np.ndarray
    surface: np.ndarray
    element: np.ndarray


def list_triangles(pieces: Pieces, chosen: Sequence[Chosen]) -> Excerpt:
    """
    List some triangles of the pieces of a model.

    Parameters
    ----------
    pieces : Pieces
    chosen : sequence of (ndarray, ndarray, ndarray)
        For each surface: rows of `Pieces.triangles`; keys of triangles in runs of its grid; the
        run that each of these is in, counted over all surfaces.
    """
    n_triangle = len(pieces.triangles)
    first_node = [len(pieces.x)]
    corners, surfaces, elements = [], [], []
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        rows, more, runs = chosen[i]
        ids, keys, element_of = pieces.triangles[rows], pieces.key[rows], rows
        first_node.append(first_node[-1])
        if strips is not None:
            assert source.lattice is not None  # only lattices have strips

            # nodes that triangles use as well have the numbers of these
            nodes = source.lattice.corners_of_keys(more)
            at = np.minimum(np.searchsorted(strips.nodes, nodes), max(len(strips.nodes) - 1, 0))
            if len(strips.nodes):
                points, known = strips.points[at], strips.nodes[at] == nodes
                nodes = np.where(known, points, nodes + first_node[i])
            else:
                nodes = nodes + first_node[i]
            ids, keys = np.concatenate([ids, nodes]), np.concatenate([keys, more])
            element_of = np.concatenate([element_of, n_triangle + runs])
            first_node[-1] += source.lattice.n_node
            order = np.argsort(keys, kind="stable")  # pieces of one triangle keep their order
            ids, element_of = ids[order], element_of[order]
        corners.append(ids)
        elements.append(element_of)
        surfaces.append(np.full(len(element_of), i))

    used, triangles = np.unique(np.concatenate(corners), return_inverse=True)
    x = np.empty((len(used), 3))
    ends = np.searchsorted(used, first_node)
    x[: ends[0]] = pieces.x[used[: ends[0]]]
    for i, source in enumerate(pieces.sources):
        of_surface = slice(ends[i], ends[i + 1])
        if ends[i] < ends[i + 1]:
            x[of_surface] = source.places_of_nodes(used[of_surface] - first_node[i]) - pieces.origin
    return Excerpt(x, triangles.reshape(-1, 3), np.concatenate(surfaces), np.concatenate(elements))


def list_near(pieces: Pieces, region: Region) -> Excerpt:
    """List all triangles of the pieces of a model that may be near a region, and some others."""
    return list_triangles(pieces, near_of(pieces, region))


def near_of(pieces: Pieces, region: Region) -> list[Chosen]:
    """Return which triangles of each surface may be near a region, as `list_triangles` takes it."""
    # of triangles that are listed already by their boxes in the map
    corners = pieces.x[pieces.triangles][:, :, :2] + pieces.origin[:2]
    near = region.meets(corners.min(axis=1), corners.max(axis=1))
    cut = np.searchsorted(pieces.surface, np.arange(len(pieces.sources) + 1))
    chosen = []
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        rows = cut[i] + np.flatnonzero(near[cut[i] : cut[i + 1]])
        keys, runs = _NONE, _NONE
        if strips is not None:
            assert source.lattice is not None  # only lattices have strips
            cells = region.cells(source.lattice)
            keys, runs = in_runs(pieces, i, np.stack([2 * cells, 2 * cells + 1], 1).reshape(-1))
        chosen.append((rows, keys, runs))
    return chosen


def in_runs(pieces: Pieces, i: int, keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return those of some keys of a surface that are in runs, and the run of each, in all."""
    from geosurf.kernels.lattices.strips import runs_of_keys

    strips = pieces.strips[i]
    assert strips is not None
    runs = runs_of_keys(strips.places, strips.runs, strips.start, keys)
    return keys[runs >= 0], runs[runs >= 0] + pieces.first_run[i]


def model_near(units: Units, region: Region) -> tuple[Patches, Units]:
    """
    Return the part of a model near a region, as patches and units that have no other triangles.

    Parameters
    ----------
    units : Units
    region : Region

    Returns
    -------
    patches : Patches
        Each surface with its triangles near the region; they have no parents and no curves.
    units : Units
        All units in their order, with the same names and volumes; each with its triangles near the
        region, in their order.
    """
    pieces, sides = units.piece_sides
    listed = list_near(pieces, region)
    beside = units.sides_seen[listed.element]
    unknown = np.zeros(len(listed.triangles), dtype=np.int64)
    patches = Patches(
        pieces.sources, listed.x, pieces.origin, listed.triangles, listed.surface, unknown, unknown,
        np.empty((0, 2)),
    )  # fmt: skip

    # of triangles with the same corners the first one alone bounds units
    unit_sides = sides[listed.element]
    unit_sides = np.where((unit_sides[:, :1] == unit_sides[:, 1:]), -1, unit_sides)
    x, triangles = _by_coordinates(listed.x, listed.triangles)
    parts = []
    for u, unit in enumerate(units.values()):
        rows = np.flatnonzero((unit_sides == u).any(axis=1))
        parts.append(
            _part(unit, x, triangles[rows], unit_sides[rows, 0] == u, listed.surface[rows])
        )
    w, e, south, n, bottom, top = units.box
    excerpt = Units(
        parts, (w, e, south, n, bottom, top), units.report, units.footprint, lambda: beside,
        units.box_volume, units.sliver_settings, units.merged, units.unmerged,
        reservoir=units.reservoir,
    )  # fmt: skip
    return patches, in_crs_of(excerpt, [units])


def _by_coordinates(x: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points by x, then y, then z, and triangles as rows of them."""
    order = np.lexsort(x.T[::-1])
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return x[order], rank[triangles]


def outward_shell(
    triangles: np.ndarray, inward: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Turn triangles (n, 3) outward and sort them, so that nothing is left of the order of surfaces.

    Parameters
    ----------
    triangles : ndarray of int64, shape (n, 3)
        Rows of points that are sorted by coordinates.
    inward : ndarray of bool, shape (n,)
        Which of them look inward.

    Returns
    -------
    used : ndarray of int64
        Points in use, rising.
    faces : ndarray of int64, shape (n, 3)
        Rows of these; each starts at its lowest corner, and they are sorted by corners.
    order : ndarray of int64, shape (n,)
        Which triangle each of them was.
    """
    from geosurf.kernels.meshes.mesh import renumbered

    # two corners swapped, they look outward
    t = triangles
    t[inward] = t[inward][:, [0, 2, 1]]
    first = t.argmin(axis=1)[:, None]
    t = np.take_along_axis(t, (first + np.arange(3)) % 3, axis=1)
    used, faces = renumbered(t)
    order = np.lexsort((faces[:, 2], faces[:, 0] * len(used) + faces[:, 1]))
    return used, faces[order], order


def _part(
    unit: Unit, x: np.ndarray, triangles: np.ndarray, inward: np.ndarray, surface: np.ndarray
) -> Unit:
    """A unit with some of its triangles; its area is not known."""
    used, faces, order = outward_shell(triangles, inward)
    return Unit(
        unit.name, unit.zone, unit.zone_index, unit.block, x[used], unit.origin, faces,
        surface[order], unit.surface_names, unit.volume, float("nan"), unit.contact, unit.beneath,
        (), unit.compartment_of,
    )  # fmt: skip
