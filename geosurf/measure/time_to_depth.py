"""Depth of a model in time, and time of a model in depth: along the vertical lines through it.

Each vertex starts from the first boundary of velocity straight above it, where both time and depth
are known from the corners of the triangle there, and goes down by the velocity of the rock between.
Where no boundary is above, it starts at the datum. The boundary may be a horizon or a fault: below
a fault the line first runs through the rock above it, so both walls have one depth at the fault.
Around all horizons, boundaries are as in the nearest place inside: what goes on there keeps its
shape. Time and depth of a boundary are linear on its triangles, in both directions: what becomes
depth comes back to the last digits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.arrangement.triangles import halved
from geosurf.conventions.axes import COORDINATES
from geosurf.errors import GeometryError, InputError
from geosurf.kernels.lattices.sets import pairs_of_equal
from geosurf.kernels.meshes.mesh import edge_keys, number_keys, weld
from geosurf.kernels.search.columns import cross_columns, shares_at, signs_of_turns
from geosurf.measure.locate import boundaries_of, locator_of
from geosurf.measure.places import well_intervals
from geosurf.measure.velocity import Velocity, deeper, later
from geosurf.model import Patches, Units
from geosurf.model.base import Noun, frozen
from geosurf.model.patches import corner_keys

THINNEST = 1.0  # ms or m: thinner zones say nothing of their interval velocity
MOST_TRIANGLES = 400_000  # of all long ones, after they are divided
MOST_LEVELS = 10_000
UPRIGHT = 1e-6  # part of the normal that points up, from rounding alone
BESIDE = 1e-3  # of the longest edge, or of the way into a triangle
FASTEST = 20_000.0  # m/s, of v0 + k z: no rock is; thin zones between averages may seem so


@dataclass(frozen=True, eq=False)
class Mesh(Noun):
    """Surfaces of a model without its box, split where they meet, with the zones beside them.

    Attributes
    ----------
    local : ndarray of float64, shape (n_vertex, 3)
    origin : ndarray of float64, shape (3,)
    triangles : ndarray of int64, shape (n_triangle, 3)
    horizon : ndarray of int64, shape (n_triangle,)
        Which horizon it is of, youngest first; -1 for faults.
    sides : ndarray of int64, shape (n_triangle, 2)
        Zone in front of and behind each triangle; -1 where the model has none.
    longest : float
        No edge is longer [m].
    """

    local: np.ndarray
    origin: np.ndarray
    triangles: np.ndarray
    horizon: np.ndarray
    sides: np.ndarray
    longest: float

    @cached_property
    def facing(self) -> np.ndarray:
        """1 where the front of a triangle is above it, -1 where its back is, 0 if upright."""
        return signs_of_turns(self.local[:, :2], self.triangles)

    @property
    def _lies(self) -> np.ndarray:
        """Which triangles are of horizons, and not upright."""
        return (self.horizon >= 0) & (self.facing != 0)

    @cached_property
    def _outline(self) -> tuple[np.ndarray, np.ndarray, Any]:
        """Convex hull of the horizons; middles of their triangles, and a tree of these."""
        from scipy.spatial import ConvexHull, cKDTree  # loaded by those who convert

        t = self.triangles[self._lies]
        middles = self.local[t, :2].mean(axis=1)
        hull = ConvexHull(self.local[np.unique(t), :2]).equations
        return hull, middles, cKDTree(middles)

    def nearest_inside(self, feet: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return feet, those around all horizons in the nearest triangle of one; and which."""
        if not self._lies.any():
            return feet, np.zeros(len(feet), dtype=bool)
        hull, middles, tree = self._outline
        away = (feet @ hull[:, :2].T + hull[:, 2]).max(axis=1)
        around = away > BESIDE * self.longest  # farther than the rim may be by rounding
        feet = feet.copy()
        feet[around] = middles[tree.query(feet[around])[1]]
        return feet, around


def mesh_of(split: Patches, patches: Patches, units: Units, zones: tuple[str, ...]) -> Mesh:
    """
    Return the surfaces of a model with the zones on both sides, and long triangles divided.

    Parameters
    ----------
    split : Patches
        The surfaces without the box: what lies beyond the box has a depth, too.
    patches, units
        The sealed model, in the same local frame.
    zones : tuple of str
        Youngest first.
    """
    sides = _zones_beside(split, patches, units, zones)
    row = np.array([k if one.role == "horizon" else -1 for k, one in enumerate(split.sources)])
    horizon = row[split.surface_of_triangle]
    longest = longest_edge(split.triangles, split.local, horizon >= 0)
    local, triangles, parent = divided(split.local, split.triangles, longest)
    return Mesh(
        frozen(local, np.float64), split.origin, frozen(triangles, np.int64), horizon[parent],
        sides[parent], longest,
    )  # fmt: skip


def _zones_beside(
    split: Patches, patches: Patches, units: Units, zones: tuple[str, ...]
) -> np.ndarray:
    """Zone in front of and behind each triangle (n_triangle, 2), as the sealed model has it."""
    # triangles of one surface with the same vertices: all that the sides of the box do not cut
    number, n_place = weld(np.concatenate([split.local, patches.local]))
    n, shifted = split.n_triangle, patches.triangles + len(split.local)
    keys = corner_keys(number[np.concatenate([split.triangles, shifted])], n_place)
    surface = np.concatenate([split.surface_of_triangle, patches.surface_of_triangle])
    keys = number_keys(keys)[1] * len(patches.sources) + surface
    here, there = pairs_of_equal(keys, np.arange(len(keys)))
    # a surface that lies on itself has others with the same vertices
    of_both = (here < n) & (there >= n)
    here, there = here[of_both], there[of_both]
    zone = np.array([*(zones.index(unit.zone) for unit in units.values()), -1])
    sides = zone[units.sides[there - n]]
    beside = np.full((n, 2), -1)
    inside = (sides >= 0).all(axis=1)
    beside[here[inside]] = sides[inside]

    # from there outwards, to neighbours across edges that no other surface has
    keys = edge_keys(split.triangles, len(split.local))
    _, edge, count = np.unique(keys, return_inverse=True, return_counts=True)
    a, b = (half // 3 for half in pairs_of_equal(edge, np.flatnonzero(count[edge] == 2)))
    same = split.surface_of_triangle[a] == split.surface_of_triangle[b]
    a, b = np.concatenate([a[same], b[same]]), np.concatenate([b[same], a[same]])
    while True:
        outward = (beside[a, 0] >= 0) & (beside[b, 0] < 0)
        if not outward.any():
            return beside
        beside[b[outward]] = beside[a[outward]]
        a, b = a[~outward], b[~outward]


def longest_edge(t: np.ndarray, x: np.ndarray, on_horizon: np.ndarray) -> float:
    """Return how long edges may be [m]: velocity bends what lies between their ends."""
    # twice the step of horizons, but not so short that there are too many
    corners = x[t]
    edges = np.linalg.norm((corners - np.roll(corners, 1, axis=1))[:, :, :2], axis=2)
    step = float(np.median(edges[on_horizon])) if on_horizon.any() else 0.0
    a, b, c = corners.swapaxes(0, 1)
    area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    return max(2.0 * step, (4.0 * area / MOST_TRIANGLES) ** 0.5)


def divided(
    x: np.ndarray, t: np.ndarray, longest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices, triangles, and the triangle that each is part of; no edge is too long.

    Both surfaces at a curve get the same points on it.
    """
    parent = np.arange(len(t))
    while True:
        corners = x[t]
        square = ((corners - np.roll(corners, -1, axis=1)) ** 2).sum(axis=2)
        if not (square > longest**2).any():
            return x, t, parent
        x, t, source = halved(x, t, square > longest**2)
        parent = parent[source]


def beside_upright(x: np.ndarray, t: np.ndarray, longest: float) -> np.ndarray:
    """Return vertices, those of upright triangles a little beside them, all on one side.

    Their vertical lines run in the surface: rounding would choose a wall for each.
    """
    a, b, c = x[t].swapaxes(0, 1)
    normal = np.zeros_like(x)
    np.add.at(normal, t, np.cross(b - a, c - a)[:, None])
    length = np.linalg.norm(normal, axis=1)
    upright = np.flatnonzero(np.abs(normal[:, 2]) < UPRIGHT * length)
    beside = x.copy()
    beside[upright, :2] += BESIDE * longest * normal[upright, :2] / length[upright, None]
    return beside


@dataclass(frozen=True, eq=False)
class Starts(Noun):
    """Where vertical lines through points start from.

    Attributes
    ----------
    corners : ndarray of int64, shape (n, 3)
        Vertices of the triangle above; -1: the line starts at the datum.
    weights : ndarray of float64, shape (n, 3)
    zone : ndarray of int64, shape (n,)
        The zone between.
    pinned : ndarray of int64, shape (n,)
        The zone above a vertex of a horizon to which the average velocity is given; else -1.
    anchor : ndarray of int64, shape (n,)
        For all others in such a zone: the nearest vertex of that horizon. It has the interval
        velocity.
    """

    corners: np.ndarray
    weights: np.ndarray
    zone: np.ndarray
    pinned: np.ndarray
    anchor: np.ndarray

    def of(self, values: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Values of vertices at the starts of some lines; 0 at the datum."""
        corners = self.corners[rows]
        found: np.ndarray = (self.weights[rows] * values[corners]).sum(axis=1)
        return np.where(corners[:, 0] < 0, 0.0, found)


@dataclass(frozen=True, eq=False)
class Crossings(Noun):
    """Where vertical lines through points cross boundaries of velocity, from the top down.

    Attributes
    ----------
    foot : ndarray of int64, shape (n,)
        Row of the point, rising.
    corners, weights : ndarray (n, 3)
        Vertices of the triangle, and how much each counts.
    below : ndarray of int64, shape (n,)
        The zone below the boundary.
    up : ndarray of float64, shape (n,)
        Where, as the mesh was given.
    horizon : ndarray of int64, shape (n,)
        As of the mesh.
    """

    foot: np.ndarray
    corners: np.ndarray
    weights: np.ndarray
    below: np.ndarray
    up: np.ndarray
    horizon: np.ndarray

    def some(self, rows: np.ndarray) -> Crossings:
        """Some of them."""
        arrays = (self.foot, self.corners, self.weights, self.below, self.up, self.horizon)
        return Crossings(*(array[rows] for array in arrays))


def crossings_of(mesh: Mesh, groups: tuple[int, ...], feet: np.ndarray) -> Crossings:
    """
    Return where vertical lines cross boundaries of velocity.

    Around all horizons, boundaries are as at the nearest place inside, but for faults.

    Parameters
    ----------
    mesh : Mesh
    groups : tuple of int
        Of each zone: zones of one group have the same velocity.
    feet : ndarray of float64, shape (n, 2)
        Local coordinates, as of the mesh.
    """
    group = np.array([*groups, -1])
    front_up = mesh.facing > 0
    above = np.where(front_up, mesh.sides[:, 0], mesh.sides[:, 1])
    below = np.where(front_up, mesh.sides[:, 1], mesh.sides[:, 0])
    is_boundary = (group[above] != group[below]) & (above >= 0) & (below >= 0)
    rows = np.flatnonzero(is_boundary & (mesh.facing != 0))
    t = mesh.triangles[rows]
    feet, outside = mesh.nearest_inside(np.ascontiguousarray(feet))
    crossings = cross_columns(mesh.local, t, feet)
    is_horizon = mesh.horizon[rows] >= 0
    counts = ~outside[crossings.foot] | is_horizon[crossings.triangle]
    order = np.lexsort((crossings.triangle, -crossings.elevation, crossings.foot))
    order = order[counts[order]]
    foot, triangle = crossings.foot[order], crossings.triangle[order]
    weights = shares_at(mesh.local[t[triangle]], feet[foot])
    rows = rows[triangle]
    up = crossings.elevation[order]
    return Crossings(foot, t[triangle], weights, below[rows], up, mesh.horizon[rows])


def starts_of(mesh: Mesh, groups: tuple[int, ...], averages: tuple[int, ...]) -> Starts:
    """Return where lines through the vertices of a mesh start: the first boundary above each.

    `averages` are zones that have the average velocity to the horizon below them.
    """
    n, x = len(mesh.local), mesh.local
    # at an upright fault, horizons start in the column of their own side
    beside = beside_upright(x, mesh.triangles[mesh.horizon < 0], mesh.longest)
    inside = np.full_like(x, np.nan)
    t = mesh.triangles[mesh.horizon >= 0]
    inside[t] = x[t].mean(axis=1)[:, None]
    at_upright = (beside != x).any(axis=1) & np.isfinite(inside[:, 0])
    beside[at_upright] = x[at_upright] + BESIDE * (inside - x)[at_upright]
    above = crossings_of(mesh, groups, beside[:, :2])
    # triangles of the vertex itself are not above it
    counts = (above.up > mesh.local[above.foot, 2]) & (above.corners != above.foot[:, None]).all(
        axis=1
    )
    above = above.some(np.flatnonzero(counts))
    last = above.some(np.flatnonzero(np.diff(above.foot, append=n)))  # the lowest one
    corners, weights = np.full((n, 3), -1), np.zeros((n, 3))
    zone = np.zeros(n, dtype=np.int64)
    corners[last.foot], weights[last.foot], zone[last.foot] = last.corners, last.weights, last.below
    pinned, anchor = np.full(n, -1), np.full(n, -1)
    made = Starts(corners, weights, zone, pinned, anchor)
    for k in averages[::-1]:  # where horizons meet, the upper one counts
        pinned[mesh.triangles[mesh.horizon == k]] = k
    # where a reverse fault repeats a horizon, the average is that of the upper part
    repeated = (above.horizon >= 0) & (above.horizon == pinned[above.foot])
    pinned[above.foot[repeated]] = -1
    thick = mesh.local[:, 2] + THINNEST < made.of(mesh.local[:, 2], np.arange(n))
    # below a fault lines run through rock of its other side: no interval velocity of this one
    thick[above.foot[above.horizon < 0]] = False
    for k in averages:
        from scipy.spatial import cKDTree  # loaded by those who give averages

        known = np.flatnonzero((pinned == k) & (zone == k) & thick)
        others = np.flatnonzero((pinned < 0) & (zone == k))
        if len(known):
            tree = cKDTree(mesh.local[known, :2])
            anchor[others] = known[tree.query(mesh.local[others, :2])[1]]
    return made


@dataclass(frozen=True, eq=False)
class TimeDepth(Noun):
    """A model in time and in depth: the same triangles, each vertex with both.

    Attributes
    ----------
    mesh : Mesh
        As it was given, in time or in depth.
    velocity : Velocity
    in_time : bool
        Whether it was given in time.
    second : float
        Seconds on the way down for each millisecond.
    seconds, depth : ndarray of float64, shape (n_vertex,)
        On the way down, and below the datum [m].
    """

    mesh: Mesh
    velocity: Velocity
    in_time: bool
    second: float
    seconds: np.ndarray
    depth: np.ndarray

    @property
    def up(self) -> np.ndarray:
        """The other of both, positive up: elevation [m], or minus milliseconds."""
        if self.in_time:
            return self.velocity.datum - self.depth
        return -self.seconds / self.second

    def convert(
        self, points: np.ndarray, to_depth: bool, crossings: Crossings | None = None
    ) -> np.ndarray:
        """
        Return points in depth that are given in time, or the other way round.

        Between two boundaries, the way that velocity gives is stretched to end at the lower one:
        each direction is the inverse of the other.

        Parameters
        ----------
        points : ndarray of float64, shape (n, 3)
            World coordinates: easting, northing, and elevation [m] or minus milliseconds.
        to_depth : bool
            Whether they are given in time.
        crossings : Crossings, optional
            Of the lines through these points: no velocity changes them.
        """
        mesh, velocity, n = self.mesh, self.velocity, len(points)
        if crossings is None:
            places = points[:, :2] - mesh.origin[:2]
            crossings = crossings_of(mesh, velocity.groups, places)
        seconds, depth, zones = self._along(crossings, n)
        given = -points[:, 2] * self.second if to_depth else velocity.datum - points[:, 2]

        # the last boundary that is not below each point, and the next one
        known = seconds if to_depth else depth
        at = (known <= given[:, None]).sum(axis=1) - 1
        at = np.maximum(at, 0)
        rows = np.arange(n)
        s, d, zone = seconds[rows, at], depth[rows, at], zones[rows, at]
        s_end, d_end = seconds[rows, at + 1], depth[rows, at + 1]
        converted = points.copy()
        for number, law in enumerate(velocity.laws):
            in_zone = np.flatnonzero(zone == number)
            if not len(in_zone):
                continue
            v0, k, ends = law.v0.at(points[in_zone, :2]), law.k, np.isfinite(s_end[in_zone])
            start, below = d[in_zone], np.where(ends, s_end[in_zone], s[in_zone])
            full = deeper(v0, k, start, below - s[in_zone]) - start
            with np.errstate(all="ignore"):
                stretch = np.where(ends & (full > 0), (d_end[in_zone] - start) / full, 1.0)
                if to_depth:
                    thickness = deeper(v0, k, start, given[in_zone] - s[in_zone]) - start
                    converted[in_zone, 2] = velocity.datum - (start + stretch * thickness)
                else:
                    thickness = np.where(stretch > 0, (given[in_zone] - start) / stretch, 0.0)
                    converted[in_zone, 2] = (
                        -(s[in_zone] + later(v0, k, start, start + thickness)) / self.second
                    )
        return converted

    def _along(self, crossings: Crossings, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Seconds, depth and zone below, at all boundaries of lines (n, most), from the top down.

        The datum leads; infinite values follow the last boundary. What lies above a boundary that
        comes before it is as low as that.
        """
        place = np.arange(len(crossings.foot)) - np.searchsorted(crossings.foot, crossings.foot) + 1
        most = int(place.max(initial=0)) + 2
        seconds, depth = (np.full((n, most), np.inf) for _ in range(2))
        zone = np.zeros((n, most), dtype=np.int64)
        for values, out in ((self.seconds, seconds), (self.depth, depth)):
            out[crossings.foot, place] = (crossings.weights * values[crossings.corners]).sum(axis=1)
            # the datum is above all: also above what is higher than it
            out[:, 0] = np.minimum(out[:, 1], 0.0)
            np.maximum.accumulate(out, axis=1, out=out)
        zone[crossings.foot, place] = crossings.below
        return seconds, depth, zone


def shadowed(
    mesh: Mesh, groups: tuple[int, ...], points: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return points below a fault, where their column runs through rock of its other side.

    Only if a boundary of velocity is there, or is the fault: elsewhere it makes no difference.

    Parameters
    ----------
    mesh : Mesh
    groups : tuple of int
        Of each zone: zones of one group have the same velocity.
    points : ndarray of float64, shape (n, 3)
        Local.

    Returns
    -------
    rows : ndarray of int64, shape (k,)
    corners, weights : ndarray (k, 3)
        Of the triangle of the fault straight above: its vertices, and how much each counts.
    """
    none = np.empty(0, np.int64), np.empty((0, 3), np.int64), np.empty((0, 3))
    t = mesh.triangles[(mesh.horizon < 0) & (mesh.facing != 0)]
    if len(set(groups)) < 2 or not len(t):
        return none
    feet = np.ascontiguousarray(points[:, :2])
    crossings = cross_columns(mesh.local, t, feet, mesh.local[t.ravel(), :2].mean(axis=0))
    away = crossings.elevation - points[crossings.foot, 2]
    highest = np.full(len(points), -np.inf)
    boundaries = crossings_of(mesh, groups, feet)
    np.maximum.at(highest, boundaries.foot, boundaries.up)
    is_other = highest[crossings.foot] >= crossings.elevation
    near = np.flatnonzero((away > 0.0) & is_other)
    near = near[np.lexsort((crossings.triangle[near], away[near], crossings.foot[near]))]
    rows, first = np.unique(crossings.foot[near], return_index=True)
    corners = t[crossings.triangle[near[first]]]
    return rows, corners, shares_at(mesh.local[corners], feet[rows])


def velocities_at_wells(
    patches: Patches,
    units: Units,
    zones: tuple[str, ...],
    shots: Mapping[str, np.ndarray],
    second: float,
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """
    Return interval velocities at wells, by zone: places in the map (n, 2), and values (n,) [m/s].

    Parameters
    ----------
    patches, units
        The model in time.
    zones : tuple of str
    shots : mapping of str to ndarray of float64, shape (n, 4)
        As from `checkshots_of`, from time zero down.
    second : float
        Seconds on the way down for each millisecond.
    """
    found_at: dict[str, list[tuple[float, float, float]]] = {}
    locator, boundaries = locator_of(units), boundaries_of(patches, units)
    for rows in shots.values():
        path = np.column_stack([rows[:, :2], -rows[:, 3]])
        intervals = well_intervals(units, path, rows[:, 2], locator, boundaries)
        names = intervals.zone.values.tolist()
        md, up = intervals.md.values, intervals.elevation.values
        inside = [k for k, name in enumerate(names) if name]
        for zone in dict.fromkeys(names[k] for k in inside):
            in_zone = np.array([k for k in inside if names[k] == zone])
            if zone == zones[0]:  # the model begins below the datum
                in_zone = np.arange(in_zone[-1] + 1)
            thickness, time = np.ptp(md[in_zone], axis=1).sum(), np.ptp(up[in_zone], axis=1).sum()
            if time >= THINNEST:
                x, y = (float(intervals[axis].values[in_zone].mean()) for axis in COORDINATES[:2])
                found_at.setdefault(zone, []).append((x, y, thickness / (time * second)))
    return {k: (np.array(v)[:, :2], np.array(v)[:, 2]) for k, v in found_at.items()}


def levels_of(starts: Starts) -> list[np.ndarray]:
    """
    Return vertices in the order in which they can be converted: each after those that it needs.

    Raises
    ------
    GeometryError
        If parts of the model lie above each other in a ring.
    """
    n = len(starts.zone)
    level = np.zeros(n + 1, dtype=np.int64)
    level[n] = -1  # the datum: row -1
    of_anchor = np.where(starts.anchor[:, None] < 0, -1, starts.corners[starts.anchor])
    needs = np.concatenate([starts.corners, of_anchor, starts.anchor[:, None]], axis=1)
    for _ in range(MOST_LEVELS):
        next_level = level[needs].max(axis=1) + 1
        if (next_level == level[:n]).all():
            order = np.argsort(next_level, kind="stable")
            return np.split(order, np.flatnonzero(np.diff(next_level[order])) + 1)
        level[:n] = next_level
    raise GeometryError(
        "parts of the model lie above each other in a ring, so that no vertical line can be "
        "followed from the top down. Leave the faults out that overlap there."
    )


def convert_mesh(
    mesh: Mesh, starts: Starts, levels: list[np.ndarray], velocity: Velocity, in_time: bool,
    second: float,
) -> TimeDepth:  # fmt: skip
    """Return a mesh in time and in depth.

    Parameters
    ----------
    mesh, starts, levels, velocity
    in_time : bool
        Whether the mesh is in time; else it is in depth.
    second : float
        Seconds on the way down for each millisecond.

    Raises
    ------
    InputError
        If a velocity is not above 0 somewhere in the model.
    """
    n = len(mesh.local)
    places = mesh.local[:, :2] + mesh.origin[:2]
    given = mesh.local[:, 2] + mesh.origin[2]
    seconds, depth = (np.zeros(n + 1) for _ in range(2))  # the last one: the datum
    known, other = (seconds, depth) if in_time else (depth, seconds)
    known[:n] = -given * second if in_time else velocity.datum - given
    v0 = np.ones(n)
    ruling = np.where(starts.pinned < 0, starts.zone, starts.pinned)
    for number, law in enumerate(velocity.laws):
        mine = ruling == number
        v0[mine] = law.v0.at(places[mine])
    k = np.array([law.k for law in velocity.laws])[ruling]
    for rows in levels:
        d, s = starts.of(depth, rows), starts.of(seconds, rows)
        anchored = np.flatnonzero(starts.anchor[rows] >= 0)
        nearest = starts.anchor[rows[anchored]]
        way = depth[nearest] - starts.of(depth, nearest)
        v0[rows[anchored]] = way / (seconds[nearest] - starts.of(seconds, nearest))
        pinned = starts.pinned[rows] >= 0
        d, s = np.where(pinned, 0.0, d), np.where(pinned, 0.0, s)
        if in_time:
            depth[rows] = deeper(v0[rows], k[rows], d, seconds[rows] - s)
        else:
            seconds[rows] = s + later(v0[rows], k[rows], d, depth[rows])
        speeds = v0[rows] + k[rows] * np.stack([d, depth[rows]])
        is_rock = (speeds > 0.0) & ((speeds < FASTEST) | (k[rows] == 0.0))
        wrong = ~is_rock | ~np.isfinite(other[rows])
        if wrong.any():
            end, at = np.unravel_index(int(np.argmax(wrong)), wrong.shape)
            worst = rows[at]
            raise InputError(
                f"the velocity of {velocity.zones[starts.zone[worst]]!r} is {speeds[end, at]:.4g} "
                f"m/s near (E {places[worst, 0]:.0f}, N {places[worst, 1]:.0f}). Velocities are "
                f"above 0, and v0 + k z below {FASTEST:g}, in the whole zone, also between "
                "averages: give other ones there."
            )
    return TimeDepth(mesh, velocity, in_time, second, seconds[:n], depth[:n])
