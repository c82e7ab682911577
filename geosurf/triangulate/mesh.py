"""Meshes of horizons and faults: from vertices and triangles, checked, and turned."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from geosurf.conventions import place, rising_diagonal, volume_text
from geosurf.errors import SurfaceError, warn_of
from geosurf.kernels.exact.predicates import MAX_COORDINATE
from geosurf.kernels.meshes.mesh import edges, join_pairs, weld
from geosurf.model import Lattice, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.surfaces import exact_normal

# ---- degenerate ----------------------------------------
# Triangles without area, found exactly.
#
# A float filter passes what clearly has area; only what it doubts is decided in
# rational arithmetic. Nothing is ever called degenerate because it is thin.


# each component of the cross product is off by less than 4 rounding units of its terms,
# or by more where they underflow
_DOUBT = 8 * np.finfo(np.float64).eps
_UNDERFLOW = 1e-290


def find_zero_area(corners: np.ndarray) -> np.ndarray:
    """Return the rows of `corners` (n_triangle, 3, 3) whose area is exactly zero.

    Examples
    --------
    >>> flat = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    >>> find_zero_area(np.array([flat, [[0, 0, 0], [1, 1, 1], [3, 3, 3]]], dtype=float))
    array([1])
    """
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    plus, minus = u[:, [1, 2, 0]] * v[:, [2, 0, 1]], u[:, [2, 0, 1]] * v[:, [1, 2, 0]]
    doubted = np.flatnonzero(_in_doubt(plus, minus).all(axis=1))
    zero = [row for row in doubted if not any(exact_normal(corners[row]))]
    return np.array(zero, dtype=np.int64)


def map_turns(corners: np.ndarray) -> np.ndarray:
    """Return +1, 0 or -1 per triangle (n_triangle, 3, 2 or more): its turn in the map, exactly.

    Examples
    --------
    >>> map_turns(np.array([[[0.0, 0], [1, 0], [0, 1]], [[0, 0], [1, 1], [2, 2]]]))
    array([1, 0])
    """
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    plus, minus = u[:, 0] * v[:, 1], u[:, 1] * v[:, 0]
    turns = np.sign(plus - minus).astype(np.int64)
    for row in np.flatnonzero(_in_doubt(plus, minus)):
        flat = [[*corner[:2], 0.0] for corner in corners[row].tolist()]
        z = exact_normal(np.array(flat))[2]
        turns[row] = (z > 0) - (z < 0)
    return turns


def _in_doubt(plus: np.ndarray, minus: np.ndarray) -> np.ndarray:
    return np.abs(plus - minus) <= _DOUBT * (np.abs(plus) + np.abs(minus)) + _UNDERFLOW


def refuse_zero_area(
    name: str,
    vertices: np.ndarray,
    triangles: np.ndarray,
    remedy: str,
    rows: np.ndarray | None = None,
) -> None:
    """Raise a `SurfaceError` that names the first triangle without area (among `rows`), if any."""
    zero = find_zero_area(vertices[triangles if rows is None else triangles[rows]])
    zero = zero if rows is None else rows[zero]
    if len(zero):
        first = zero[0]
        raise SurfaceError(
            f"fault {name!r}: {len(zero)} of {len(triangles)} triangles have exactly zero area, "
            f"the first is triangle {first} (vertices {triangles[first].tolist()}) at "
            f"{place(vertices[triangles[first][0]])}. {remedy}"
        )


class PlainMesh(tuple[np.ndarray, np.ndarray]):
    """(vertices, triangles) in a coordinate reference system that the source declares."""

    crs: str


def is_mesh(obj: Any) -> bool:
    """Return whether something is a `TriSurface`, or stands for (vertices, triangles)."""
    return isinstance(obj, TriSurface | tuple | list)


def triangulate_mesh(
    obj: Any,
    name: str,
    role: str,
    *,
    scale: float = 1.0,
    words: tuple[str | None, str | None] = (None, None),
) -> TriSurface:
    """
    Return a surface from vertices and triangles, or one that is there already.

    Parameters
    ----------
    obj : TriSurface or (vertices, triangles)
        World coordinates (n_vertex, 3) and indices (n_triangle, 3).
    name : str
    role : {"horizon", "fault"}
    scale : float
        Metres and direction of the third coordinate: what elevations are multiplied by.
    words : (positive, length_unit)
        Arguments for the third coordinate; a `TriSurface` accepts metres, positive up, only.

    Raises
    ------
    SurfaceError
        If it is neither, or the vertices or triangles cannot be used.

    Examples
    --------
    >>> corners, faces = [[0, 0, 900.0], [9, 0, 900], [0, 9, 950]], [[0, 1, 2]]
    >>> triangulate_mesh((corners, faces), "Top", "horizon", scale=-1.0).bounds[4:]
    (-950.0, -900.0)
    """
    if isinstance(obj, TriSurface):
        if words[0] not in (None, "up") or words[1] not in (None, "m"):
            raise SurfaceError(
                f"{role} {name!r}: a TriSurface is in metres, elevation positive up. "
                "Pass (vertices, triangles) to convert."
            )
        return obj.renamed(name, role)
    if not isinstance(obj, tuple | list) or len(obj) != 2:
        raise SurfaceError(
            f"{role} {name!r}: cannot use {type(obj).__name__} of {len(obj)} as a mesh. Give "
            "(vertices, triangles): arrays (n_vertex, 3) and (n_triangle, 3)."
            + (" Fault sticks: a list of arrays (n, 3)." if role == "fault" else "")
        )
    surface = TriSurface(name, role, obj[0], obj[1])
    if scale != 1.0:
        surface = TriSurface(name, role, surface.vertices * (1.0, 1.0, scale), surface.triangles)
    return in_crs_of(surface, [obj])


def refuse_flat_triangles(surface: TriSurface) -> None:
    """Refuse a mesh with a triangle that has exactly no area."""
    remedy = "Remove these triangles and merge their vertices first."
    refuse_zero_area(surface.name, surface.vertices, surface.triangles, remedy)


# ---- horizon mesh ----------------------------------------
# Triangulated horizons: whether "above" and "below" mean something.
#
# A closed body (salt, a lens) has an inside and an outside instead: it is refused. A sheet that
# folds over itself (a recumbent fold, a flank of salt) has both sides, but what lies on its upper
# side is not everywhere above it: that is allowed, and a warning names the share.


def check_horizon_mesh(surface: TriSurface) -> None:
    """
    Refuse a horizon that is, or has in it, a closed body; warn of one that folds over itself.

    Parameters
    ----------
    surface : TriSurface
        A gridded one passes: it cannot fold.

    Raises
    ------
    SurfaceError
        For a closed body, with its volume and place; for a sheet with only one side.

    Examples
    --------
    >>> corners = [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]]
    >>> faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    >>> check_horizon_mesh(TriSurface("Salt", "horizon", corners, faces))
    Traceback (most recent call last):
    geosurf.errors.SurfaceError: horizon 'Salt' is a closed body of 122 m³ around \
(E 2.25, N 2.25, elevation 2.25 m), so nothing is above or below it. Pass it as a \
fault, faults={'Salt': ...}; its inside becomes a block.
    """
    if surface.lattice is not None or surface.n_triangle == 0:
        return

    # Relative to a corner, so that products of large coordinates do not lose digits.
    low = surface.vertices.min(axis=0)
    corners = (surface.vertices - low)[surface.triangles]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])  # in the map, with its sign
    if (area >= 0).all() or (area <= 0).all():
        return  # a closed body, or a fold, has triangles of both kinds

    turned, sheet, neighbour = sheets_that_agree(surface)
    sign = np.where(turned, -1.0, 1.0)
    n_sheet = int(sheet.max()) + 1

    # A sheet without a rim is closed.
    rims = np.bincount(sheet, (neighbour < 0).any(axis=1), n_sheet)
    for k in np.flatnonzero(rims == 0):
        body = sheet == k
        # Signed volume by the divergence theorem: tetrahedra with the origin.
        volume = np.linalg.det(corners[body]) / 6.0
        take = "" if n_sheet == 1 else "Remove it from the horizon. "
        at = place(corners[body].reshape(-1, 3)[_distinct(surface, body)].mean(axis=0) + low)
        raise SurfaceError(
            f"horizon {surface.name!r} {'is' if n_sheet == 1 else 'holds'} a closed body of "
            f"{volume_text(abs(float((sign[body] * volume).sum())))} around {at}, so nothing "
            f"is above or below it. {take}Pass it as a fault, faults={{{surface.name!r}: "
            "...}; its inside becomes a block."
        )
    _warn_of_folds(surface, area * sign, sheet, corners + low)


def _distinct(surface: TriSurface, mine: np.ndarray) -> np.ndarray:
    """One corner, of those of some triangles, for each of their vertices."""
    return np.unique(surface.triangles[mine].ravel(), return_index=True)[1]


def _warn_of_folds(
    surface: TriSurface, area: np.ndarray, sheet: np.ndarray, corners: np.ndarray
) -> None:
    """Warn of the parts of each sheet that look the other way than most of it."""
    # Each sheet faces the way that most of its area does; the rest folds over.
    up = np.bincount(sheet, area) >= 0
    area = np.where(up[sheet], area, -area)
    over = area < 0
    if not over.any():
        return

    share = float(-area[over].sum() / np.abs(area).sum())
    largest = int(np.argmin(area))
    warn_of(
        "fold",
        surface.name,
        f"Horizon {surface.name!r} folds over itself on {100 * share:.2g} % of its map "
        "area. There, the zone above the horizon lies below it.",
        "If it should not fold, simplify it there, or convert it to a grid.",
        corners[largest].mean(axis=0),
    )


# ---- orient ----------------------------------------
# Normals of faults: consistent over each sheet, and into the hanging wall.
#
# The hanging wall lies above a dipping fault, so the mean normal points up. A
# vertical fault has none; its normal points east, or north if it strikes
# east-west, so that "F1+" names the same block on every run.


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
    return in_crs_of(made, [surface])


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
