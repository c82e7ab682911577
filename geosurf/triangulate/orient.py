"""Normals of faults: consistent over each sheet, and into the hanging wall.

The hanging wall lies above a dipping fault, so the mean normal points up. A
vertical fault has none; its normal points east, or north if it strikes
east-west, so that "F1+" names the same block on every run.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from geosurf.conventions import place, rising_diagonal
from geosurf.errors import SurfaceError
from geosurf.model import Lattice, TriSurface


def fault_diagonal(lattice: Lattice) -> bool:
    """Return the diagonal of a fault: the one that climbs towards the east end of strike.

    Like the rule for horizons, but in the vertical plane along strike, which a
    vertical fault has and the map does not show. A flat fault takes the rule
    for horizons.

    Parameters
    ----------
    lattice : Lattice
        With `reverse`; its own diagonal does not matter.

    Returns
    -------
    bool
        As `Lattice.rising`.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 50.0, 100.0], [0.0, 50.0])
    >>> fault_diagonal(Lattice(x, y, -y, True, False))
    False
    """
    # with either diagonal, so that it is the same from whatever corner the grid is read
    falling, rising = (lattice.turned_as(way, lattice.reverse).normals[0] for way in (False, True))
    east, north, up = (falling + rising).tolist()
    largest = max(abs(east), abs(north))
    if largest <= 1e-6 * abs(up):
        return rising_diagonal(lattice.easting, lattice.northing)
    x, y = -north / largest, east / largest  # along strike; squares of tiny ones underflow
    lead = x if abs(x) > 1e-6 else y

    # strike points east, or north where it has no easting: one direction whatever the grid's
    size = math.copysign(math.hypot(x, y), lead)
    along = (lattice.easting - np.nanmin(lattice.easting)) * (x / size)
    along += (lattice.northing - np.nanmin(lattice.northing)) * (y / size)
    return rising_diagonal(along, lattice.elevation)


# A component of the unit normal below this counts as zero: a dip of 89.9999 degrees.
# A convention about names, not about geometry: no curve or volume depends on it.
_VERTICAL = 1e-6
_KEPT = "_oriented"


def orient_fault(surface: TriSurface) -> TriSurface:
    """Return a fault whose normals point into the hanging wall.

    Triangles that share an edge are first made to agree, sheet by sheet; a
    sheet ends at edges with more than two triangles. Then each sheet is turned
    so that its mean normal, weighted by area, points up; that of a vertical
    sheet (to a part in a million) east, or north if it strikes east-west.

    Parameters
    ----------
    surface : TriSurface
        Vertices at the same place count as one, whatever their numbers.

    Returns
    -------
    TriSurface
        The same surface if nothing had to turn. Vertices, their order and the
        order of triangles stay.

    Raises
    ------
    SurfaceError
        If a sheet has only one side, like a Moebius strip.

    Examples
    --------
    >>> down = TriSurface("F1", "fault", [[0, 0, 0], [9, 0, -9], [0, 9, 0]], [[0, 2, 1]])
    >>> orient_fault(down).triangles
    array([[0, 1, 2]])
    """
    # remembered on the surface: each horizon that a fault tears asks again
    if _KEPT not in surface.__dict__:
        surface = _oriented(surface)
        surface.__dict__[_KEPT] = True
    return surface


def _oriented(surface: TriSurface) -> TriSurface:
    """The same, without memory."""
    if surface.n_triangle == 0:
        return surface
    if surface.lattice is not None:
        refuse_far(surface.name, surface.lattice.survey.box)
        return _orient_lattice(surface, surface.lattice)
    refuse_far(surface.name, np.array(surface.bounds))

    # First all triangles of a sheet agree, then whole sheets are turned.
    turned, sheet, _ = sheets_that_agree(surface)
    corners = surface.vertices[surface.triangles]
    normal = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal[turned] *= -1.0

    # Sums of area vectors [m2] for each sheet, and of their sizes.
    means = _sum_by(sheet, np.column_stack([normal, np.linalg.norm(normal, axis=1)]))
    wrong = np.array([_points_into_footwall(mean[:3], mean[3]) for mean in means])
    turned ^= wrong[sheet]

    if not turned.any():
        return surface
    triangles = np.where(turned[:, None], surface.triangles[:, [0, 2, 1]], surface.triangles)
    return _turned(surface, vertices=surface.vertices, triangles=triangles)


def refuse_far(name: str, values: np.ndarray) -> None:
    """Refuse a fault with coordinates that no exact geometry takes, before products overflow.

    Examples
    --------
    >>> refuse_far("F1", np.array([0.0, -1e300]))
    Traceback (most recent call last):
    geosurf.errors.SurfaceError: fault 'F1' has a coordinate of 1e+300 m, but coordinates are \
limited to 1.15292e+18 m. If this is a no-data value, set those nodes to NaN.
    """
    from geosurf.kernels.exact.predicates import MAX_COORDINATE

    # of a box or of sticks, a few numbers; one that is not a number may look large here
    if max(map(abs, values.ravel().tolist()), default=0.0) <= MAX_COORDINATE:
        return
    large = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))  # of nothing: infinite
    if large > MAX_COORDINATE:
        raise SurfaceError(
            f"fault {name!r} has a coordinate of {large:g} m, but coordinates are limited to "
            f"{MAX_COORDINATE:g} m. If this is a no-data value, set those nodes to NaN."
        )


def _orient_lattice(surface: TriSurface, lattice: Lattice) -> TriSurface:
    """Point the normals of a grid, which agree already, into the hanging wall."""
    normal, area, _ = lattice.normals
    wrong = _points_into_footwall(-normal if lattice.turned else normal, area)
    if not wrong and lattice.reverse is not None:
        return surface
    oriented = lattice.turned_as(lattice.rising, lattice.turned ^ wrong)
    return _turned(surface, lattice=oriented)


def _turned(surface: TriSurface, **parts: Any) -> TriSurface:
    """The same surface from other triangles of its vertices."""
    made = TriSurface(surface.name, surface.role, **parts, vertex_data=surface.vertex_data)
    made.crs = surface.crs
    return made


def _points_into_footwall(normal: np.ndarray, area: float) -> bool:
    """Whether a normal, summed over an area, points down; for vertical faults west, else south.

    A closed surface has none of these; it stays as its first triangle has it.
    """
    # The first component that is clearly not zero decides: up, then east, then north.
    x, y, z = normal.tolist()
    return next((c < 0 for c in (z, x, y) if abs(c) > _VERTICAL * area), False)


def _sum_by(group: np.ndarray, rows: np.ndarray) -> np.ndarray:
    out = np.zeros((int(group.max()) + 1, rows.shape[1]))
    np.add.at(out, group, rows)
    return out


def sheets_that_agree(surface: TriSurface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which triangles turn to agree with the first of their sheet; sheets; neighbours or -1."""
    from geosurf.kernels.meshes.mesh import join_pairs

    n_triangle = surface.n_triangle
    neighbour, clash, ends = _across_edges(surface)
    turned = np.zeros(n_triangle, dtype=bool)
    if not clash.any():  # nothing turns, as in most files; sheets by their first triangle
        first, side = np.nonzero(neighbour >= 0)
        pairs = np.stack([first, neighbour[first, side]], axis=1)
        return turned, np.unique(join_pairs(pairs, n_triangle), return_inverse=True)[1], neighbour

    sheet = np.full(n_triangle, -1, dtype=np.int64)
    n_sheet = 0
    # Breadth-first over shared edges; the first triangle of each sheet sets the direction.
    for seed in range(n_triangle):
        if sheet[seed] >= 0:
            continue
        sheet[seed] = n_sheet
        front = np.array([seed])
        while len(front):
            # XOR: a neighbour turns if this one does, unless their directions clash along the edge.
            there, agree = neighbour[front], turned[front, None] ^ clash[front]
            new = (there >= 0) & (sheet[there] < 0)
            reached, first = np.unique(there[new], return_index=True)
            sheet[reached], turned[reached] = n_sheet, agree[new][first]
            front = reached
        n_sheet += 1

    # A cycle that comes back turned has no two sides.
    torn = (neighbour >= 0) & (turned[:, None] ^ clash ^ turned[neighbour])
    if torn.any():
        t, k = np.argwhere(torn)[0]
        middle = surface.vertices[ends[t, k]].mean(axis=0)
        raise SurfaceError(
            f"surface {surface.name!r} has only one side (a Moebius strip): its triangles cannot "
            f"agree across the edge at {place(middle)}. Cut it open there, or remove triangles."
        )
    return turned, sheet, neighbour


def _across_edges(surface: TriSurface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For each edge of each triangle: the triangle beyond, whether they clash, the edge.

    ``-1`` on rims, and where more than two triangles share the edge.
    """
    from geosurf.kernels.meshes.mesh import edges, weld

    # Edges are compared by place, as meshes in parts repeat their vertices.
    spot, n_place = weld(surface.vertices)
    corners = surface.triangles
    ends = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
    start = spot[ends[:, :, 0]].ravel()

    # The two half-edges of an inner edge form a ring of two. They run in opposite directions if
    # their triangles agree.
    ring, _ = edges(spot[corners], n_place)
    half = np.arange(len(ring))
    paired = (ring != half) & (ring[ring] == half)
    neighbour = np.where(paired, ring // 3, -1)
    clash = paired & (start == start[ring])
    return neighbour.reshape(-1, 3), clash.reshape(-1, 3), ends
