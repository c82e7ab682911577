"""Objects of a RESQML package that have points: which there are, and what each holds.

``Grid2dRepresentation``, ``TriangulatedSetRepresentation``, ``PointSetRepresentation``,
``PolylineRepresentation``, ``PolylineSetRepresentation``. What they represent (a horizon, a fault)
is that of their interpretation.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from geosurf.conventions import metres_per_unit
from geosurf.errors import FormatError, SurfaceError
from geosurf.model import TriSurface
from geosurf.model.base import with_crs
from geosurf.read._common import Request, noted
from geosurf.read.resqml import Package, every, find, kind, places_along, values_of, word_of

# ---- places ----------------------------------------
# From points of a RESQML representation to easting, northing and elevation in metres.
#
# Points are in a local system: an offset and a turn in the map, an offset of z, units, and
# whether z is depth (Energistics RESQML 2.0.1, LocalDepth3dCrs). The turn is clockwise from
# north.


SPELLINGS = {"ft[US]": "ftus", "ft[US survey]": "ftus"}
# order of the two axes in the map -> which of them is easting, and the signs of easting, northing
AXES = {
    "easting northing": (0, 1.0, 1.0),
    "northing easting": (1, 1.0, 1.0),
    "westing southing": (0, -1.0, -1.0),
    "southing westing": (1, -1.0, -1.0),
    "northing westing": (1, -1.0, 1.0),
    "westing northing": (0, -1.0, 1.0),
}
RADIANS = {"rad": 1.0, "dega": math.pi / 180.0, "degree": math.pi / 180.0}
DEPTH = 8  # grids that take their nodes from another one
COPIES = 4  # of the coordinates of a grid that are there at a time


def world(package: Package, geometry: Element, points: np.ndarray, request: Request) -> np.ndarray:
    """
    Return points (..., 3) as easting, northing, elevation [m].

    Parameters
    ----------
    package : Package
    geometry : Element
        The ``PointGeometry`` that names the local system.
    points : ndarray of float64, shape (..., 3)
    request : Request
        `positive`, `length_unit`: What a caller states: it has to agree with the file.

    Raises
    ------
    FormatError
        If the local system is in time, or incomplete.
    InputError
        If `positive` or `length_unit` contradicts the file.
    """
    system = package.referred(geometry, "LocalCrs")
    if kind(system) != "LocalDepth3dCrs":
        raise FormatError(
            f"{package.path}: points are in a {kind(system).removeprefix('obj_')}, expected a "
            "LocalDepth3dCrs: geosurf reads surfaces in depth, not in time. Convert them to depth."
        )
    what = f"{package.path.name}: z"
    down = package.text(system, "ZIncreasingDownward").lower() in ("true", "1")
    unit = _unit(package, system, "VerticalUom")
    positive = "down" if down else "up"
    level = request.scale(what, positive=positive, unit=unit, default=None)
    z = level * (points[..., 2] + package.number(system, "ZOffset")) + 0.0
    x, y = _in_the_map(package, system, points)
    return np.stack([x, y, z], axis=-1)


def _in_the_map(
    package: Package, system: Element, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Easting and northing [m]."""
    order = package.text(system, "ProjectedAxisOrder").lower()
    angle = package.need(system, "ArealRotation")
    turn = package.number(system, "ArealRotation") * RADIANS.get(str(angle.get("uom")), math.nan)
    if order not in AXES or not math.isfinite(turn) or (turn and order != "easting northing"):
        raise package.damaged(
            f"the local system has the axes {order!r} and a rotation in {angle.get('uom')!r}, "
            "which geosurf does not read together"
        )
    a, b = points[..., 0], points[..., 1]
    if turn:
        c, s = math.cos(turn), math.sin(turn)
        a, b = c * a + s * b, c * b - s * a
    ends = a + package.number(system, "XOffset"), b + package.number(system, "YOffset")
    scale = metres_per_unit(_unit(package, system, "ProjectedUom"), package.path.name)
    east, *signs = AXES[order]
    return signs[0] * scale * ends[east], signs[1] * scale * ends[1 - east]


def _unit(package: Package, system: Element, name: str) -> str:
    word = package.text(system, name)
    return SPELLINGS.get(word, word)


def crs_of(package: Package, geometry: Element) -> str | None:
    """Return the projected reference system of points; None without one, or if it is in feet."""
    system = package.referred(geometry, "LocalCrs")
    if metres_per_unit(_unit(package, system, "ProjectedUom"), package.path.name) != 1.0:
        noted("crs", "in another unit than metres: not that of the points that were converted")
        return None
    code = find(system, "ProjectedCrs", "EpsgCode")
    if code is not None:
        return f"EPSG:{package.count(code)}"
    word = word_of(system, "ProjectedCrs", "Unknown")
    return None if word.lower() in ("", "unknown") else word


def points_of(
    package: Package, node: Element, shape: tuple[int, ...], depth: int = 0
) -> np.ndarray:
    """
    Return the points (*shape, 3) that an element ``Points`` describes, in the local system.

    Parameters
    ----------
    package : Package
    node : Element
    shape : tuple of int
        Rows and columns of a grid; the number of points elsewhere.
    depth : int
        How many grids took their nodes from another one so far.

    Raises
    ------
    FormatError
        If the kind of points is another one, or points are missing.
    """
    what = kind(node)
    if what == "Point3dHdf5Array":
        return _shaped(package, package.dataset(package.need(node, "Coordinates")), (*shape, 3))
    if what == "Point3dLatticeArray" and len(shape) == len(every(node, "Offset")) == 2:
        origin = _vector(package, package.need(node, "Origin"))
        rows, columns = (
            _axis(package, *one) for one in zip(every(node, "Offset"), shape, strict=True)
        )
        return origin + rows[:, None] + columns
    if what == "Point3dZValueArray":
        places = points_of(package, package.need(node, "SupportingGeometry"), shape, depth)
        z = values_of(package, package.need(node, "ZValues"))
        return np.concatenate([places[..., :2], _shaped(package, z, shape)[..., None]], axis=-1)
    if what == "Point3dFromRepresentationLatticeArray" and len(shape) == 2:
        return _from_another(package, node, shape, depth)
    raise FormatError(
        f"{package.path}: geosurf does not read points of the kind {what}. Export the surface with "
        "the coordinates of its points."
    )


def _axis(package: Package, node: Element, n: int) -> np.ndarray:
    """Vectors (n, 3) from the first place of an axis."""
    way = _vector(package, package.need(node, "Offset"))
    return places_along(package, package.need(node, "Spacing"), n)[:, None] * way


def _vector(package: Package, node: Element) -> np.ndarray:
    return np.array([package.number(node, f"Coordinate{k}") for k in (1, 2, 3)])


def _from_another(
    package: Package, node: Element, shape: tuple[int, ...], depth: int
) -> np.ndarray:
    """Nodes that another grid of the package has: all of them, or a lattice among them."""
    other = package.referred(node, "SupportingRepresentation")
    if kind(other) != "Grid2dRepresentation" or depth > DEPTH:
        raise package.damaged(f"a grid takes its nodes from a {kind(other)}, or from itself")
    nodes, _ = grid_points(package, other, depth + 1)
    lattice = package.need(node, "NodeIndicesOnSupportingRepresentation")
    offsets = every(lattice, "Offset")
    if len(offsets) != 2:
        raise package.damaged(f"nodes on another grid have {len(offsets)} axes, expected 2")
    first = package.count(lattice, "StartValue")
    row, column = (
        places_along(package, one, n).astype(np.int64)
        for one, n in zip(offsets, shape, strict=True)
    )
    index = first + row[:, None] + column
    if len(np.unique(index)) < index.size:
        # resqpy counts steps along each axis; the format, through all nodes, where none repeats
        start = np.divmod(first, nodes.shape[1])
        index = (start[0] + row)[:, None] * nodes.shape[1] + start[1] + column
    flat = nodes.reshape(-1, 3)
    if index.size and not 0 <= index.min() <= index.max() < len(flat):
        raise package.damaged(f"a grid names a node that another grid of {len(flat)} has not")
    return flat[index]


def grid_points(package: Package, grid: Element, depth: int = 0) -> tuple[np.ndarray, Element]:
    """Return the nodes (n_row, n_column, 3) of a grid in its local system, and its geometry."""
    patch = package.need(grid, "Grid2dPatch")
    shape = tuple(package.count(patch, f"{word}AxisCount") for word in ("Slowest", "Fastest"))
    package.refuse_large(24 * COPIES * math.prod(shape), f"a grid of {shape[0]} x {shape[1]} nodes")
    geometry = package.need(patch, "Geometry")
    noted("nodes", f"{shape[1]} columns x {shape[0]} rows")
    return points_of(package, package.need(geometry, "Points"), shape, depth), geometry


def _shaped(package: Package, values: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Values as float64 in a shape, flat or not in the file."""
    if values.size != math.prod(shape):
        found, expected = (" x ".join(map(str, one)) for one in (values.shape, shape))
        raise package.damaged(f"an array has {found} values, expected {expected}")
    return values.reshape(shape).astype(np.float64)


GRID, MESH = "Grid2dRepresentation", "TriangulatedSetRepresentation"
POINTS = "PointSetRepresentation"
LINES = ("PolylineRepresentation", "PolylineSetRepresentation")
KINDS = (GRID, MESH, POINTS, *LINES)
TITLE = ("Citation", "Title")
FRAMEWORK = "SealedVolumeFrameworkRepresentation"
ROLES = {"HorizonInterpretation": "horizon", "FaultInterpretation": "fault"}


@dataclass(frozen=True, eq=False)
class Representation:
    """An object with points.

    Attributes
    ----------
    title : str
        Its name; with the identifier behind it where others have the same one.
    kind : str
        As in the file: ``"Grid2dRepresentation"``.
    role : str
        ``"horizon"``, ``"fault"``, or ``""`` where the file does not state it.
    node : Element
    """

    title: str
    kind: str
    role: str
    node: Element


def representations(package: Package) -> list[Representation]:
    """Return the objects of a package that geosurf reads, in the order of the file."""
    entries = []
    for uuid, node in package.objects.items():
        if kind(node) in KINDS:
            entries.append((word_of(node, *TITLE) or uuid, uuid, node))
    names = [words for words, _, _ in entries]
    return [
        Representation(
            words if names.count(words) == 1 else f"{words} {uuid}", kind(node), _role(node), node
        )
        for words, uuid, node in entries
    ]


def holds_units(package: Package) -> bool:
    """Return whether a package has a sealed model."""
    return any(kind(node) == FRAMEWORK for node in package.objects.values())


def _role(node: Element) -> str:
    """What the interpretation of a representation is."""
    stated = word_of(node, "RepresentedInterpretation", "ContentType")
    return ROLES.get(stated.rpartition("obj_")[2], "")


def grid_of(
    package: Package, grid: Representation, request: Request
) -> tuple[np.ndarray, str | None]:
    """Nodes (n_row, n_column, 3) in metres, and their reference system."""
    points, geometry = grid_points(package, grid.node)
    if np.isinf(points).any() or not np.isfinite(points[..., :2]).all():
        raise package.damaged(f"{grid.title!r} has nodes without a place")
    return _placed(package, geometry, points, request)


def _placed(
    package: Package, geometry: Element, points: np.ndarray, request: Request
) -> tuple[np.ndarray, str | None]:
    crs = crs_of(package, geometry)
    if crs is not None:
        noted("crs", crs)
    return world(package, geometry, points, request), crs


def patches_of(
    package: Package,
    node: Element,
    name: str,
    request: Request,
    counted: Callable[..., int] | None = None,
) -> tuple[np.ndarray, str | None]:
    """Points (n, 3) of all patches of an object, in metres."""
    parts: list[np.ndarray] = []
    systems: dict[str | None, None] = {}
    for patch in every(node, name):
        n = package.count(patch, "Count") if counted is None else counted(patch)
        geometry = package.need(patch, "Geometry")
        points = points_of(package, package.need(geometry, "Points"), (n,))
        if not np.isfinite(points).all():
            raise package.damaged(f"a point of a {kind(node)} is not finite")
        placed, crs = _placed(package, geometry, points, request)
        parts.append(placed)
        systems[crs] = None
    if len(systems) != 1:
        raise package.damaged(f"a {kind(node)} has {len(systems)} coordinate reference systems")
    return np.concatenate(parts), next(iter(systems))


def mesh_of(package: Package, mesh: Representation, request: Request, role: Any) -> TriSurface:
    """Triangles of all patches."""
    patches = every(mesh.node, "TrianglePatch")

    def nodes_in(patch: Element) -> int:
        return package.count(patch, "NodeCount")

    points, crs = patches_of(package, mesh.node, "TrianglePatch", request, nodes_in)
    triangles, start = [], 0
    for patch in patches:
        listed = values_of(package, package.need(patch, "Triangles"))
        if listed.dtype.kind not in "iu" or listed.size != 3 * package.count(patch, "Count"):
            raise package.damaged(f"{mesh.title!r} does not have the triangles that it announces")
        corners = listed.reshape(-1, 3).astype(np.int64)
        triangles.append(
            corners + _shift(package, mesh, corners, start, nodes_in(patch), len(points))
        )
        start += nodes_in(patch)
    try:
        return with_crs(TriSurface(mesh.title, role, points, np.concatenate(triangles)), crs)
    except (SurfaceError, ValueError) as error:
        raise FormatError(f"{package.path}: {error}") from error


def _shift(
    package: Package, mesh: Representation, corners: np.ndarray, start: int, n_own: int, n: int
) -> int:
    """
    What to add to the corners of a patch: nodes are counted through all patches, or in each.

    Programs differ in that. Where both readings are possible the file is refused.
    """
    low, high = (int(corners.min()), int(corners.max())) if corners.size else (start, start)
    through, each = start <= low and high < start + n_own, low >= 0 and high < n_own
    if start and through and each:
        raise package.damaged(
            f"{mesh.title!r} has several patches, and their triangles fit nodes counted in each "
            "patch as well as through all of them"
        )
    if through or not each:
        if not 0 <= low <= high < n:
            raise package.damaged(
                f"{mesh.title!r} has a triangle with a corner {high} of {n} nodes"
            )
        return 0
    return start


def lines_of(
    package: Package, line_set: Representation, request: Request
) -> tuple[list[np.ndarray], str | None]:
    """Lines (n, 3) of a polyline or a set of them; closed ones repeat their first point."""
    if line_set.kind == LINES[0]:
        points, crs = patches_of(package, line_set.node, "NodePatch", request)
        closed = package.text(line_set.node, "IsClosed").lower() in ("true", "1")
        return [_ring(points, closed)], crs
    lines: list[np.ndarray] = []
    crs = None
    counts = [_counts(package, patch) for patch in every(line_set.node, "LinePatch")]
    sizes = iter([int(count.sum()) for count in counts])
    points, crs = patches_of(package, line_set.node, "LinePatch", request, lambda _: next(sizes))
    at = 0
    for patch, count in zip(every(line_set.node, "LinePatch"), counts, strict=True):
        rings = np.broadcast_to(
            values_of(package, package.need(patch, "ClosedPolylines")).ravel() != 0, count.shape
        )
        for n, ring in zip(count.tolist(), rings.tolist(), strict=True):
            lines.append(_ring(points[at : at + n], ring))
            at += n
    return lines, crs


def _counts(package: Package, patch: Element) -> np.ndarray:
    """Number of points of each line of a patch."""
    count = values_of(package, package.need(patch, "NodeCountPerPolyline")).ravel().astype(np.int64)
    if (count < 1).any():
        raise package.damaged("a line has no points")
    return count


def _ring(points: np.ndarray, closed: bool) -> np.ndarray:
    return np.concatenate([points, points[:1]]) if closed else points


def places_of(package: Package, item: Representation, request: Request) -> np.ndarray:
    """All points of any object."""
    if item.kind == GRID:
        return grid_of(package, item, request)[0]
    if item.kind == MESH:
        return mesh_of(package, item, request, "surface").vertices
    if item.kind == POINTS:
        return patches_of(package, item.node, "NodePatch", request)[0]
    return np.concatenate(lines_of(package, item, request)[0])
