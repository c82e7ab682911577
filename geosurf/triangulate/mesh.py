"""A horizon or fault from vertices and triangles, as other programs export them."""

from __future__ import annotations

import math
from os import PathLike
from typing import Any

import numpy as np

from geosurf.conventions import HORIZON_DIMS, metres_per_unit, place, rising_diagonal
from geosurf.errors import HorizonError, InputError, SurfaceError
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


# ---- horizon checks ----------------------------------------
# Refuse arrays without a grid of a horizon: by shape, axes, values, and folded cells.


_Corner = tuple[slice, slice]


def check_array(da: Any, what: str) -> None:
    """Refuse what is not a two-dimensional array of numbers."""
    # of the class: to ask an array itself for its values would read them
    values = hasattr(type(da), "values") or hasattr(da, "values")
    if not (values and all(hasattr(da, key) for key in ("dims", "coords", "attrs"))):
        if isinstance(da, str | PathLike):
            raise HorizonError(
                f"{what}: found the path {str(da)!r}, expected the content of the file. Read "
                "it with geosurf.read_horizon(path)."
            )
        raise HorizonError(
            f"{what}: found {type(da).__name__}, expected an xarray.DataArray over {HORIZON_DIMS}. "
            "Make one with xr.DataArray(z, dims=('northing', 'easting'), coords={'northing': y, "
            "'easting': x}, attrs={'units': 'm', 'positive': 'up'}). Scene(..., tear=True) grids "
            "scattered points (n, 3), with and without faults."
        )

    # Scattered points and Datasets look like arrays, but need another step first.
    if not hasattr(da, "dtype") and tuple(getattr(da, "sizes", ())) == ("point",):
        raise HorizonError(
            f"{what}: found scattered points, expected a grid. Scene(..., tear=True) grids them, "
            "and tear_horizon(points, faults); without faults pass faults={}."
        )
    if not hasattr(da, "dtype"):
        raise HorizonError(
            f"{what}: found a {type(da).__name__} with variables {list(da)}, expected one "
            "array. Select it with ds['name']."
        )

    if da.dtype.kind not in "fiu":
        raise HorizonError(
            f"{what}: values have dtype {da.dtype}, expected numbers. "
            "Convert them with da.astype(float)."
        )
    if len(da.dims) != 2:
        raise HorizonError(
            f"{what}: dims are {tuple(da.dims)}, expected two: {HORIZON_DIMS}. "
            "Drop others with da.isel(...) or da.squeeze()."
        )

    if min(da.shape) < 2:
        raise HorizonError(
            f"{what}: the grid has {da.shape[0]} x {da.shape[1]} nodes, expected 2 x 2 or "
            "more. Read a larger part of the grid."
        )


def coordinates_of(da: Any, what: str) -> tuple[np.ndarray, np.ndarray]:
    """Return easting and northing [m], both 1-D or both 2-D."""
    easting, northing = labels_of(da, what)
    return in_metres(easting, f"easting of {what}"), in_metres(northing, f"northing of {what}")


def labels_of(da: Any, what: str) -> tuple[Any, Any]:
    """Return the coordinates of a grid, both 1-D or both over its dimensions; they are not read."""
    # of xarray the arrays alone: labels cost more than what they label
    coords = getattr(da.coords, "variables", da.coords)
    missing = [key for key in ("easting", "northing") if key not in coords]
    flat = not missing and coords["easting"].ndim == coords["northing"].ndim == 2
    if not flat and tuple(da.dims) != HORIZON_DIMS:
        raise HorizonError(
            f"{what}: dims are {tuple(da.dims)}, expected {HORIZON_DIMS}. Rename them with "
            "da.rename(...), add coordinates called x and y or with a CF standard_name, or 2-D "
            "coordinates easting and northing if the grid is rotated."
        )
    if missing:
        raise HorizonError(
            f"{what}: coordinates {missing} are missing; the array has {list(da.coords)}. Add "
            f"them in metres with da.assign_coords({missing[0]}=...)."
        )

    easting, northing = (
        coords[key].transpose(*da.dims) if flat else coords[key] for key in ("easting", "northing")
    )
    return easting, northing


def in_metres(coord: Any, what: str, error: type[InputError] = HorizonError) -> np.ndarray:
    """Values of one coordinate in metres, not copied where they are."""
    if coord.dtype.kind not in "fiu":
        raise error(
            f"{what}: values have dtype {coord.dtype}, expected metres. Convert them to float."
        )

    length_unit = coord.attrs.get("units")
    try:
        factor = 1.0 if length_unit is None else metres_per_unit(length_unit, what)
    except InputError as reason:
        raise error(str(reason)) from reason
    values = np.asarray(coord.values, dtype=np.float64)
    return values if factor == 1.0 else values * factor


def check_axis(key: str, axis: np.ndarray, what: str) -> None:
    """Refuse a 1-D coordinate that is not finite, or neither increases nor decreases."""
    bad = np.flatnonzero(~np.isfinite(axis))
    if len(bad):
        raise HorizonError(
            f"{what}: {key}[{bad[0]}] is {axis[bad[0]]}. Coordinates of nodes must be finite; "
            f"drop the row or column with da.isel({key}=...)."
        )

    # Strictly increasing or strictly decreasing, by the direction of the ends.
    way = 1.0 if axis[-1] >= axis[0] else -1.0
    bad = np.flatnonzero(way * np.diff(axis) <= 0)
    if len(bad):
        i = int(bad[0])
        verb = "decreases" if way > 0 else "increases"
        remedy = f"Sort it with da.sortby({key!r})."
        if axis[i + 1] == axis[i]:
            verb, remedy = "repeats", f"Keep one with da.drop_duplicates({key!r})."
        raise HorizonError(
            f"{what}: {key} {verb} at index {i + 1}: {axis[i]:g} is followed by "
            f"{axis[i + 1]:g}, expected values that only increase, or only decrease. {remedy}"
        )


def check_values(lattice: Lattice, what: str) -> None:
    """Refuse infinite nodes, nodes without a place, and grids without a single node."""
    if lattice.whole:
        return

    (x, y), elevation = lattice.horizontal(), lattice.elevation

    # NaN is absence; an infinite value is a mistake in the data
    infinite = np.isinf(elevation) | np.isinf(x) | np.isinf(y)
    if infinite.any():
        i, j = map(int, np.argwhere(infinite)[0])
        raise HorizonError(
            f"{what}: {int(infinite.sum())} nodes are infinite, the first is node ({i}, {j}) "
            f"at {place((x[i, j], y[i, j], elevation[i, j]))}. Set missing nodes to NaN: "
            "da.where(np.isfinite(da))."
        )

    present = np.isfinite(elevation)
    if not present.any():
        raise HorizonError(
            f"{what}: all {elevation.size} nodes are NaN. Check the no-data value of the file."
        )

    lost = present & ~(np.isfinite(x) & np.isfinite(y))
    if lost.any():
        i, j = map(int, np.argwhere(lost)[0])
        raise HorizonError(
            f"{what}: {int(lost.sum())} nodes have a value but no position, the first is node "
            f"({i}, {j}), easting {x[i, j]}, northing {y[i, j]}. Give the position, or set the "
            "value to NaN."
        )


def check_cells(lattice: Lattice, what: str) -> None:
    """Refuse a grid without triangles, and a curvilinear one that folds over itself."""
    if lattice.n_triangle == 0:
        n = lattice.present
        n_node = int(n.sum())
        raise HorizonError(
            f"{what}: no triangle has its three nodes: only {n_node} of {n.size} nodes are "
            "present, and they are scattered. Grid them first, or check the NaN mask."
        )
    # axes were found to rise strictly; only curvilinear grids can fold
    if (
        lattice.easting.ndim == 1
        or lattice.is_graph
        or _clearly_unfolded(lattice, _half_cells(lattice))
    ):
        return

    # floats could not decide: exact signs of all triangles
    corners = lattice.build_vertices()[lattice.build_triangles()]
    turns = map_turns(corners)
    bad = np.flatnonzero(turns <= 0)
    if len(bad):
        kind = "turned over" if turns[bad[0]] < 0 else "without area in the map"
        raise HorizonError(
            f"{what}: the grid is folded: {len(bad)} of {len(turns)} triangles are {kind}, the "
            f"first at {place(corners[bad[0]].mean(axis=0))}. Check the 2-D coordinates there, "
            "or set those nodes to NaN."
        )


def _half_cells(lattice: Lattice) -> tuple[tuple[_Corner, _Corner, _Corner], ...]:
    """Corners of the two triangles of all cells, as slices of the nodes."""
    low, high = slice(None, -1), slice(1, None)
    a, b, c, d = (low, low), (low, high), (high, high), (high, low)
    return ((a, b, c), (a, c, d)) if lattice.rising else ((a, b, d), (b, c, d))


def _clearly_unfolded(
    lattice: Lattice, halves: tuple[tuple[_Corner, _Corner, _Corner], ...]
) -> bool:
    """Whether floats alone show that all triangles turn one way; no triangle is built."""
    # Both halves of all cells at once: the cross product of two sides, with a bound on its
    # rounding.
    x, y, n = lattice.easting, lattice.northing, lattice.present
    sign = 1.0 if lattice.right_handed else -1.0
    for a, b, c in halves:
        plus = (x[b] - x[a]) * (y[c] - y[a])
        minus = (y[b] - y[a]) * (x[c] - x[a])
        clear = sign * (plus - minus) > 1e-12 * (np.abs(plus) + np.abs(minus))
        if not clear[n[a] & n[b] & n[c]].all():
            return False
    return True


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
