"""A fault seen along its strike: how far across it is, for a distance along and an elevation.

A wall that moves along its fault goes down by its throw, along strike as the line down its dip
does (`dip_lines`), and across strike as the fault does between the two places. So a fault is read
as a function r(s, z). It may be vertical or overturned, listric or curved, but must not turn back
on itself.

Legend
    s      distance along the mean strike, from the fault's first end by the right-hand rule [m]
    r      distance across strike, in the mean dip direction [m]
    z      elevation [m]
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.kernels.lattices.sets import distinct, rim_edges
from geosurf.kernels.sheets.fault_trace import values_on_triangles
from geosurf.kernels.sheets.moved_rock import across_fault, distances_from_fault, values_in_table
from geosurf.model import Sheet, TriSurface, frozen
from geosurf.model.surfaces import Content
from geosurf.sheets.faults.fault_distance import Blocks

MOST = (513, 257)  # nodes of the table along strike and down, at most
PAIRS = 2_000_000  # candidates that are looked at at once
ARRAYS = ("axes", "z", "table", "ends", "turned")
KEPT = 32  # sections that are remembered, of 1 MB at most
INSIDE = -1e-9  # barycentric: a point this far outside a triangle is on its edge


@dataclass(frozen=True, eq=False)
class Section:
    """A fault as a table of r over s and z, bilinear between its nodes.

    Attributes
    ----------
    name : str
    axes : ndarray (2, 2)
        Horizontal unit vectors along the mean strike and in the mean dip direction.
    first : float
        Where s is 0, along the first axis.
    length : float
        Largest s.
    z : ndarray (2,)
        Lowest and highest elevation of the fault.
    table : ndarray (n_s, n_z)
    slope : float
        Mean change of r with z, by which the fault goes on above and below.
    ends : ndarray (n, 2)
        First and last s of the fault at levels from the lowest to the highest.
    turned : ndarray (n, 3, 2)
        Corners over s and z of triangles that turn back, which the table leaves out.
    """

    name: str
    axes: np.ndarray
    first: float
    length: float
    z: np.ndarray
    table: np.ndarray
    slope: float
    ends: np.ndarray
    turned: np.ndarray

    def extent(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where the fault starts and ends along strike at elevations (n,)."""
        level = np.linspace(self.z[0], self.z[1], len(self.ends))
        return np.interp(z, level, self.ends[:, 0]), np.interp(z, level, self.ends[:, 1])

    def of(self, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Along (n,) and across strike (n,) of places (n, 2)."""
        s, r = self.axes @ xy.T
        return s - self.first, r

    def places(self, s: np.ndarray, r: np.ndarray) -> np.ndarray:
        """Places (n, 2) from along and across strike."""
        return np.stack([s + self.first, r], axis=-1) @ self.axes

    def across(self, s: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Where the fault is across strike: straight on past its ends, at its mean dip beyond."""
        out = np.empty(len(s))
        at = np.ascontiguousarray(s), np.ascontiguousarray(z)
        across_fault(self.table, self.shape, *at, out)
        return out

    def distance(self, xy: np.ndarray, z: np.ndarray) -> np.ndarray:
        """How far (n,) places (n, 2) are from the fault at their elevations, across strike."""
        out = np.empty(len(z))
        at = np.ascontiguousarray(xy), np.ascontiguousarray(z)
        distances_from_fault(self.axes, self.table, self.shape, *at, out)
        return out

    @cached_property
    def shape(self) -> np.ndarray:
        """What `geosurf.kernels.sheets.moved_rock` calls a fault."""
        return np.array([*self.z.tolist(), self.length, self.slope, self.first])


def bilinear(table: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Values (n,) of a table at rows u and columns v, which may be broken and lie within it.

    Examples
    --------
    >>> bilinear(np.array([[0.0, 1.0], [2.0, 5.0]]), np.array([0.5, 1.0]), np.array([0.5, 0.0]))
    array([2., 2.])
    """
    out = np.empty(len(u))
    at = np.ascontiguousarray(u), np.ascontiguousarray(v)
    values_in_table(table, *at, out)
    return out


def section_of(
    fault: TriSurface,
    corner: np.ndarray,
    step: float,
    levels: tuple[float, float] | None = (-np.inf, np.inf),
) -> Section:
    """
    Read a fault along its strike.

    Parameters
    ----------
    fault : TriSurface
        Normals into its hanging wall.
    corner : ndarray (2,)
        Easting and northing that places are counted from [m].
    step : float
        Distance between nodes of the table along strike [m], if there are not too many.
    levels : (float, float) or None
        Elevations between which walls move [m]. Triangles above and below them that turn back are
        left out; so are level ones, which have no place in a section. None leaves out all that
        turn back: whoever asks for that has to look at `turned`.

    Returns
    -------
    Section

    Raises
    ------
    GeometryError
        If the fault has no strike, or turns back between the levels, so that it has two places in
        one section.
    """
    content, place_of = Content(fault), tuple(corner)
    seen = _seen_along_strike(content, place_of)
    section, back, z = _section(content, place_of, seen.n_node(step)), seen.turned, seen.elevations
    if levels is not None:
        back = back[(z[back].min(1) <= levels[1]) & (z[back].max(1) >= levels[0])]
        if len(back):
            where = fault.vertices[fault.triangles[back[0]]].mean(axis=0)
            raise GeometryError(
                f"fault {fault.name!r} turns back against its mean dip direction at "
                f"{place(where)}, so a wall cannot move along it. Give the part beyond as a "
                "separate fault.",
                place=where,
                surfaces=(fault.name,),
            )
    return section


@dataclass(frozen=True, eq=False)
class _AlongStrike:
    """A fault as it is seen along its strike, before it is read as a table.

    Attributes
    ----------
    axes : ndarray (2, 2)
        As of the section.
    slope : float
    s, r : ndarray (n_vertex,)
        Of its vertices; s is not yet counted from the first end.
    first, length : float
        Least s and range of s, on triangles that do not turn back.
    z : ndarray (2,)
        The same of elevations.
    triangles : ndarray (n, 3)
        Those that do not turn back.
    bends : bool
        Whether these differ in direction: a plane is linear in z.
    turned : ndarray (n,)
        Triangles that turn back.
    elevations : ndarray (n_triangle, 3)
    """

    axes: np.ndarray
    slope: float
    s: np.ndarray
    r: np.ndarray
    first: float
    length: float
    z: np.ndarray
    triangles: np.ndarray
    bends: bool
    turned: np.ndarray
    elevations: np.ndarray

    def n_node(self, step: float) -> int:
        """Nodes of a table along strike, as fine as requested."""
        return int(np.clip(np.ceil(self.length / step), 2, MOST[0] - 1)) + 1


@lru_cache(maxsize=KEPT)
def _seen_along_strike(content: Content, corner: tuple[float, float]) -> _AlongStrike:
    """See a fault along its strike."""
    fault = content.surface
    points = fault.vertices - np.append(corner, 0.0)
    corners = points[fault.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    # normals weighted by area: their mean gives dip direction and strike, by the right-hand rule
    mean = normals.sum(axis=0)
    across = float(np.hypot(*mean[:2]))
    if across <= 1e-9 * float(np.abs(normals).sum()):
        raise GeometryError(
            f"fault {fault.name!r} is horizontal on average, so it has no strike. Throw needs a "
            "fault that dips.",
            surfaces=(fault.name,),
        )
    dip = mean[:2] / across

    # ahead > 0: r is a function of s and z on the triangle; level ones have no place at all
    ahead = normals[:, :2] @ dip
    elevations = points[fault.triangles, 2]
    level = (normals[:, :2] == 0.0).all(axis=1)
    turned = np.flatnonzero((ahead <= 0) & ~level)

    axes = np.array([[-dip[1], dip[0]], dip])
    triangles, normals = fault.triangles[ahead > 0], normals[ahead > 0]
    used = distinct(triangles)
    s, r = axes @ points[:, :2].T
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return _AlongStrike(
        axes, float(-mean[2] / across), s, r, float(s[used].min()), float(np.ptp(s[used])),
        np.array([points[used, 2].min(), points[used, 2].max()]), triangles,
        bool(np.ptp(unit, axis=0).max() > 1e-12), turned, elevations,
    )  # fmt: skip


@lru_cache(maxsize=KEPT)
def _section(content: Content, corner: tuple[float, float], n_s: int) -> Section:
    """The section of a fault, with some nodes along strike.

    The next horizon, and the next realisation of an ensemble, have the same faults. Their cells are
    equal but for rounding, and the number of nodes is what the table depends on.
    """
    fault, seen = content.surface, _seen_along_strike(content, corner)

    # r as a table over s and z, on the triangles that do not turn back; two levels do for a plane
    n_z = MOST[1] if seen.bends else 2
    at_s, at_z = np.meshgrid(
        np.linspace(0.0, seen.length, n_s), np.linspace(seen.z[0], seen.z[1], n_z), indexing="ij"
    )
    plane = np.column_stack([seen.s - seen.first, fault.vertices[:, 2]])
    at = np.column_stack([at_s.ravel(), at_z.ravel()])
    table = _read(plane, seen.r, seen.triangles, at, seen.slope).reshape(n_s, n_z)
    ends = _ends(plane, seen.triangles, seen.z)
    section = Section(
        fault.name, seen.axes, seen.first, seen.length, seen.z, table, seen.slope, ends,
        plane[fault.triangles[seen.turned]],
    )  # fmt: skip
    for array in (*(getattr(section, key) for key in ARRAYS), seen.turned, seen.elevations):
        array.flags.writeable = False
    return section


def overlapping(triangle: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Which triangles (n, 3, 2) share a place with one (3, 2), rounding aside; numbers (m,).

    Two convex figures are apart if some line along an edge of one of them parts them; the sides of
    their boxes are asked first, and decide for those without area.

    Examples
    --------
    >>> one = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]])
    >>> overlapping(one, np.stack([one + 1.0, one + 1.9, one + 2.1, one + 5.0]))
    array([0, 1])
    """
    # separating axes: the sides of the boxes, then lines along each of the six edges
    low, high = triangle.min(axis=0), triangle.max(axis=0)
    near = ((others.min(axis=1) <= high) & (others.max(axis=1) >= low)).all(axis=1)
    rows = np.flatnonzero(near)
    theirs = others[rows]
    ours = np.broadcast_to(triangle, theirs.shape)
    apart = np.zeros(len(rows), dtype=bool)
    for edges in (np.roll(ours, -1, axis=1) - ours, np.roll(theirs, -1, axis=1) - theirs):
        for k in range(3):
            normal = np.stack([-edges[:, k, 1], edges[:, k, 0]], axis=1)[:, :, None]
            a, b = (ours @ normal)[:, :, 0], (theirs @ normal)[:, :, 0]
            apart |= (a.max(1) < b.min(1)) | (b.max(1) < a.min(1))
    return rows[~apart]


def _ends(plane: np.ndarray, triangles: np.ndarray, z: np.ndarray) -> np.ndarray:
    """First and last s (n, 2) of a mesh at levels from the lowest to the highest."""
    a, b = plane[rim_edges(triangles)].transpose(1, 0, 2)
    low, high = np.minimum(a[:, 1], b[:, 1]), np.maximum(a[:, 1], b[:, 1])
    out = np.empty((MOST[1], 2))
    for i, level in enumerate(np.linspace(z[0], z[1], MOST[1])):
        # where rim edges cross this level; both ends of those that lie in it
        met = np.flatnonzero((low <= level) & (level <= high))
        rise = b[met, 1] - a[met, 1]
        f = np.where(rise == 0, 0.0, (level - a[met, 1]) / np.where(rise == 0, 1.0, rise))
        s = a[met, 0] + f * (b[met, 0] - a[met, 0])
        s = np.concatenate([s, b[met[rise == 0], 0]])
        out[i] = (s.min(), s.max()) if len(s) else out[i - 1]  # between parts that were left out
    return out


def _read(
    plane: np.ndarray, r: np.ndarray, triangles: np.ndarray, points: np.ndarray, slope: float
) -> np.ndarray:
    """Values at points (n, 2) of the plane: on the mesh, else from its nearest place."""
    values = _on_mesh(plane, r, triangles, points)
    outside = np.flatnonzero(np.isnan(values))
    if len(outside):
        # beyond the mesh: on from the nearest place of its rim, by the mean dip; in parts, as pairs
        # of all points and all rim edges would not fit into memory
        rim = rim_edges(triangles)
        for rows in np.array_split(outside, len(outside) * len(rim) // PAIRS + 1):
            at, value = _nearest(plane, r, rim, points[rows])
            values[rows] = value + slope * (points[rows, 1] - at[:, 1])
    return values


def _on_mesh(
    plane: np.ndarray, r: np.ndarray, triangles: np.ndarray, points: np.ndarray
) -> np.ndarray:
    """Linear interpolation in the triangle that holds each point; NaN outside."""
    # scaled so that a mean triangle is 4 wide, and a block (8) holds a few
    corners = plane[triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    scale = 4.0 / np.maximum((high - low).mean(axis=0), 1e-300)
    blocks = Blocks(low * scale, high * scale, 1e-6)
    rows, block = blocks.of(points * scale)
    out = np.full(len(points), np.nan)
    values_on_triangles(
        plane, r, triangles, blocks.starts, blocks.items, points, rows, block, INSIDE, out
    )
    return out


def _nearest(
    plane: np.ndarray, r: np.ndarray, rim: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Nearest place (n, 2) on the rim of a mesh to each point, and the value there."""
    (ax, ay), (bx, by), (x, y) = plane[rim[:, 0]].T, plane[rim[:, 1]].T, points.T[..., None]
    tx, ty = bx - ax, by - ay

    # place on each rim edge that is nearest to each point (n_point, n_edge), then the best
    along = (x - ax) * tx + (y - ay) * ty
    f = np.clip(along / np.maximum(tx * tx + ty * ty, 1e-300), 0.0, 1.0)
    k = ((x - (ax + f * tx)) ** 2 + (y - (ay + f * ty)) ** 2).argmin(axis=1)
    f = f[np.arange(len(points)), k]
    start, end = r[rim[k]].T
    return np.stack([ax[k] + f * tx[k], ay[k] + f * ty[k]], axis=1), start * (1.0 - f) + end * f


# ---- dip lines ----------------------------------------
# Lines down the dip of a fault: which way a wall moves along it where its strike turns.
#
# On a plane they run across its strike. On a fault that is curved in the map they turn with it: the
# steepest way down at a place is across the strike there.
#
# Legend
#     s, r, z    as in `fault_profile`: along the mean strike, across it, elevation [m]
#     q          ds/dz along a line. With slopes r_s and r_z of the fault, the way down is at right
#                angles to its strike line (1, r_s) in the map and stays on the fault, so that
#                q = -r_s r_z / (1 + r_s**2)


MOST_STRETCH = 0.5  # of rock along strike by its movement, between neighbouring lines
STRAIGHT = 1e-12  # q below this is rounding: a fault that does not turn
STEPS = 2  # of Runge and Kutta's fourth order, for one movement
SPARE = 2.0  # cells beyond a horizon, or the throw, up to which a fault is looked at
FAR_STEPS = 8  # and from a cut-off to the level at which lines are compared


@dataclass(frozen=True, eq=False)
class DipLines:
    """Slopes q of the lines, bilinear between nodes over s and z, constant beyond.

    Attributes
    ----------
    table : ndarray (n_s, n_z)
    length : float
        Largest s [m].
    z : ndarray (2,)
        Lowest and highest elevation [m].
    """

    table: np.ndarray
    length: float
    z: np.ndarray

    def slope(self, s: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Slope q (n,) at places; no line turns above or below the fault."""
        n_s, n_z = self.table.shape
        low, high = self.z
        u = np.clip(s / self.length, 0.0, 1.0) * (n_s - 1)
        v = (np.clip(z, low, high) - low) / (high - low) * (n_z - 1)
        return np.where((z < low) | (z > high), 0.0, bilinear(self.table, u, v))

    def moved(self, s: np.ndarray, z: np.ndarray, to: np.ndarray, steps: int = STEPS) -> np.ndarray:
        """Where the lines through places (s, z) are along strike at elevations `to`."""
        return self.way(s, z, to, steps)[-1]

    def way(self, s: np.ndarray, z: np.ndarray, to: np.ndarray, steps: int) -> list[np.ndarray]:
        """Where they are along strike after each step, from where they start."""
        step = (to - z) / steps
        places = [s]

        # Runge and Kutta's fourth order: slopes at the start, twice in the middle, and at the end
        for k in range(steps):
            at = z + k * step
            slope_1 = self.slope(s, at)
            slope_2 = self.slope(s + 0.5 * step * slope_1, at + 0.5 * step)
            slope_3 = self.slope(s + 0.5 * step * slope_2, at + 0.5 * step)
            slope_4 = self.slope(s + step * slope_3, at + step)
            s = s + step / 6.0 * (slope_1 + 2.0 * slope_2 + 2.0 * slope_3 + slope_4)
            places.append(s)
        return places


def dip_lines(
    section: Section, throw: float, cell: float, levels: tuple[float, float] | None = None
) -> DipLines | None:
    """
    Lines down the dip of a fault, or None where they all run across its mean strike.

    Parameters
    ----------
    section : Section
    throw : float
        The largest by size [m].
    cell : float
        Strike and dip are means over this far to both sides [m]; over twice as far, and so on,
        where rock would else be stretched along strike by more than a half, as at a crease.
    levels : (float, float), optional
        Elevations between which stretching counts [m]; default: everywhere.

    Returns
    -------
    DipLines or None
    """
    n_s, n_z = section.table.shape
    spacing = section.length / (n_s - 1)
    # stretching counts between these levels of the table; others may be as uneven as they are
    rows = slice(None)
    if levels is not None:
        node = np.linspace(section.z[0], section.z[1], n_z)
        low, high = np.searchsorted(node, levels[0], "right"), np.searchsorted(node, levels[1])
        rows = slice(max(min(low, n_z) - 1, 0), high + 1)

    # wider means until neighbouring lines stretch rock by MOST_STRETCH at most
    reach = cell
    while True:
        table = _slopes(section, reach)
        steps = np.diff(table[:, rows], axis=0)
        stretch = np.abs(steps).max() / spacing * throw
        if stretch <= MOST_STRETCH or reach >= section.length:
            break
        reach *= 2.0
    if np.abs(table).max() <= STRAIGHT:
        return None
    return DipLines(table, section.length, section.z)


def cell_of(horizon: TriSurface | Sheet) -> float:
    """Mean step of the grid of a horizon, or mean size of its triangles in the map [m].

    Examples
    --------
    >>> cell_of(TriSurface("Top", "horizon", [[0, 0, 0], [50, 0, 0], [0, 50, 9]], [[0, 1, 2]]))
    50.0
    """
    grid = horizon.lattice
    if grid is None:
        assert isinstance(horizon, TriSurface)  # a sheet has a lattice
        a, b, c = horizon.vertices[horizon.triangles.T][:, :, :2]
        area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        return float(np.sqrt(area.mean()))
    x, y = grid.easting, grid.northing
    if x.ndim == 1:
        return 0.5 * float(np.ptp(x) / (len(x) - 1) + np.ptp(y) / (len(y) - 1))
    if grid.is_graph:  # each step is near the mean one: corners show it, in a store as in memory
        n_row, n_col = grid.shape
        corners = grid.map_places(np.array([0, n_col - 1, (n_row - 1) * n_col]))
        along, up = np.hypot(*(corners[1:] - corners[0]).T).tolist()
        return 0.5 * (along / (n_col - 1) + up / (n_row - 1))
    steps = [np.nanmean(np.hypot(np.diff(x, axis=k), np.diff(y, axis=k))) for k in (0, 1)]
    return 0.5 * float(steps[0] + steps[1])


def beyond(levels: tuple[float, float], cell: float, throw: float = 0.0) -> tuple[float, float]:
    """Levels between which a fault is looked at: those given, and its throw beyond them."""
    spare = max(SPARE * cell, throw)
    return levels[0] - spare, levels[1] + spare


def to_level(
    fault: TriSurface,
    throw: float,
    cell: float,
    level: float,
    hanging_wall: Sequence[np.ndarray],
    footwall: Sequence[np.ndarray],
) -> Callable[[np.ndarray], np.ndarray] | None:
    """
    How lines down the dip of a fault lead from its cut-offs to one level.

    Parts of the fault that turn back are left out, unless these lines pass through them on their
    way from one wall to the other: so a fault may turn back above and below its cut-offs, as where
    its dip lines were continued. Lines are then smoothed for the levels of the cut-offs alone.
    Beyond both cut-offs, lines lead both walls to the same place, whatever the fault does there.

    Parameters
    ----------
    fault : TriSurface
        Normals into its hanging wall.
    throw, cell : float
        See `dip_lines` [m].
    level : float
        Elevation [m].
    hanging_wall, footwall : sequence of ndarray, each (n, 3)
        Cut-off lines [m], in order along the fault.

    Returns
    -------
    callable or None
        Takes points (n, 3) of cut-offs and gives the places (n, 2) at which their lines are at that
        level, easting and northing; None where all lines run across the mean strike.

    Raises
    ------
    GeometryError
        If the fault has no strike, or turns back between its cut-offs.
    """
    corner = np.floor(fault.vertices[:, :2].min(axis=0))
    section = section_of(fault, corner, 0.5 * cell, None)

    # where the fault turns back somewhere, only the levels of the cut-offs have to be smooth
    z = np.concatenate([*(line[:, 2] for line in (*hanging_wall, *footwall)), [level]])
    levels = (float(z.min()), float(z.max())) if len(section.turned) else None
    lines = dip_lines(section, throw, cell, levels)
    if len(section.turned):
        _check_between(section, lines, corner, level, (hanging_wall, footwall))
    if lines is None:
        return None

    def found(points: np.ndarray) -> np.ndarray:
        """Places (n, 2) of points (n, 3)."""
        s, _ = section.of(points[:, :2] - corner)
        there = np.full(len(points), level)
        s = lines.moved(s, points[:, 2], there, FAR_STEPS)
        return section.places(s, section.across(s, there)) + corner

    return found


def _check_between(
    section: Section,
    lines: DipLines | None,
    corner: np.ndarray,
    level: float,
    walls: tuple[Sequence[np.ndarray], Sequence[np.ndarray]],
) -> None:
    """Refuse a fault that turns back between its cut-offs, on a line down its dip.

    Looked at is all that these lines cover over s and z, as triangles between neighbouring ones,
    so that nothing is missed between two lines.
    """

    def leads(s: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Lines (steps + 1, n, 2) from s at one elevation to another."""
        way = [s] * (FAR_STEPS + 1) if lines is None else lines.way(s, start, end, FAR_STEPS)
        return np.stack([np.array(way), np.linspace(start, end, FAR_STEPS + 1)], axis=2)

    def profile(line: np.ndarray) -> np.ndarray:
        """Columns s at the level and elevation of a cut-off line, in the direction of strike."""
        s, _ = section.of(line[:, :2] - corner)
        s = leads(s, line[:, 2], np.full(len(s), level))[-1, :, 0]
        return np.column_stack([s, line[:, 2]])[np.argsort(s, kind="stable")]

    hanging, foot = ([profile(line) for line in wall] for wall in walls)
    met, length, first = 0.0, 0.0, None
    for h, f in product(hanging, foot):
        # compared where both walls have a cut-off, at the union of their points
        low, high = max(h[0, 0], f[0, 0]), min(h[-1, 0], f[-1, 0])
        if low >= high:
            continue
        s = np.unique(np.concatenate([h[:, 0], f[:, 0]]).clip(low, high))
        z_h, z_f = (np.interp(s, *line.T) for line in (h, f))
        top = leads(s, np.full(len(s), level), z_f)[-1, :, 0]

        # net (steps + 1, n, 2): lines from the footwall's to the hanging wall's cut-off; its cells,
        # halved, are all that lines between the cut-offs cover
        net = leads(top, z_f, z_h)
        a, b, c, d = net[:-1, :-1], net[:-1, 1:], net[1:, 1:], net[1:, :-1]
        covered = np.stack([np.stack([a, b, c], 2), np.stack([a, c, d], 2)]).reshape(-1, 3, 2)
        hit = np.zeros(len(covered), dtype=bool)

        # boxes first: most triangles that turn back are far away
        reaches = (section.turned.max(axis=1) >= covered.min(axis=(0, 1))).all(axis=1)
        reaches &= (section.turned.min(axis=1) <= covered.max(axis=(0, 1))).all(axis=1)
        for triangle in section.turned[reaches]:
            hit[overlapping(triangle, covered)] = True
        length += high - low
        met += float(np.diff(s)[hit.reshape(-1, len(s) - 1).any(axis=0)].sum())
        if first is None and hit.any():
            first = covered[hit.argmax()].mean(axis=0, keepdims=True)
    if first is None:
        return
    at = section.places(first[:, 0], section.across(*first.T)) + corner
    where = np.append(at, first[0, 1])
    raise GeometryError(
        f"fault {section.name!r} turns back against its mean dip direction between its cut-offs, "
        f"on {100.0 * met / length:.2g} % of their length, for one at {place(where)}, so that "
        "throw has two values there. Give the part beyond as a fault of its own.",
        place=where,
        surfaces=(section.name,),
    )


@lru_cache(maxsize=KEPT)  # all horizons ask the same of a fault
def _slopes(section: Section, reach: float) -> np.ndarray:
    """Slopes q at the nodes of a section's table, of strike and dip as means over some reach.

    At each level only what lies between the ends of the fault counts, and it goes on beyond as it
    is there; a level on which it is hardly longer than a node has no strike of its own.
    """
    r = section.table
    n_s, n_z = r.shape
    spacing = section.length / (n_s - 1)
    ends = np.stack(section.extent(np.linspace(section.z[0], section.z[1], n_z)), axis=1)
    at = np.arange(n_s) * spacing
    steep = np.gradient(r, float(np.ptp(section.z)) / (n_z - 1), axis=1)
    slopes = np.zeros_like(r)
    for j, (first, last) in enumerate(ends):
        if last - first <= 2.0 * spacing:
            continue
        s = np.clip(at, first, last)

        # means over the reach: differences of r along strike, and of the integral of its dip
        low, high = np.maximum(s - reach, first), np.minimum(s + reach, last)
        r_s = (np.interp(high, at, r[:, j]) - np.interp(low, at, r[:, j])) / (high - low)
        area = np.append(0.0, np.cumsum(0.5 * spacing * (steep[1:, j] + steep[:-1, j])))
        r_z = (np.interp(high, at, area) - np.interp(low, at, area)) / (high - low)
        slopes[:, j] = -r_s * r_z / (1.0 + r_s**2)
    return frozen(slopes, np.float64)
