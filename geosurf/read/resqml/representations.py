"""Objects of a RESQML package that have points: which there are, and what each holds.

``Grid2dRepresentation``, ``TriangulatedSetRepresentation``, ``PointSetRepresentation``,
``PolylineRepresentation``, ``PolylineSetRepresentation``. What they represent (a horizon, a fault)
is that of their interpretation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from geosurf.errors import FormatError, SurfaceError
from geosurf.model import TriSurface
from geosurf.read._noted import noted
from geosurf.read.resqml.arrays import values_of
from geosurf.read.resqml.package import Package, every, find, kind
from geosurf.read.resqml.places import crs_of, grid_points, points_of, world

GRID, MESH = "Grid2dRepresentation", "TriangulatedSetRepresentation"
POINTS = "PointSetRepresentation"
LINES = ("PolylineRepresentation", "PolylineSetRepresentation")
KINDS = (GRID, MESH, POINTS, *LINES)
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


@dataclass(frozen=True)
class Words:
    """What a caller states about z."""

    positive: str | None
    length_unit: str | None


def representations(package: Package) -> list[Representation]:
    """Return the objects of a package that geosurf reads, in the order of the file."""
    found = []
    for uuid, node in package.objects.items():
        if kind(node) in KINDS:
            title = find(node, "Citation", "Title")
            words = ("" if title is None else title.text or "").strip() or uuid
            found.append((words, uuid, node))
    names = [words for words, _, _ in found]
    return [
        Representation(
            words if names.count(words) == 1 else f"{words} {uuid}", kind(node), _role(node), node
        )
        for words, uuid, node in found
    ]


def holds_units(package: Package) -> bool:
    """Return whether a package has a sealed model."""
    return any(kind(node) == FRAMEWORK for node in package.objects.values())


def _role(node: Element) -> str:
    """What the interpretation of a representation is."""
    stated = find(node, "RepresentedInterpretation", "ContentType")
    word = ("" if stated is None else stated.text or "").rpartition("obj_")[2]
    return ROLES.get(word.strip(), "")


def grid_of(package: Package, one: Representation, words: Words) -> tuple[np.ndarray, str | None]:
    """Nodes (n_row, n_column, 3) in metres, and their reference system."""
    points, geometry = grid_points(package, one.node)
    if np.isinf(points).any() or not np.isfinite(points[..., :2]).all():
        raise package.damaged(f"{one.title!r} has nodes without a place")
    return _placed(package, geometry, points, words)


def _placed(
    package: Package, geometry: Element, points: np.ndarray, words: Words
) -> tuple[np.ndarray, str | None]:
    crs = crs_of(package, geometry)
    if crs is not None:
        noted("crs", crs)
    return world(package, geometry, points, words.positive, words.length_unit), crs


def patches_of(
    package: Package,
    node: Element,
    name: str,
    words: Words,
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
        placed, crs = _placed(package, geometry, points, words)
        parts.append(placed)
        systems[crs] = None
    if len(systems) != 1:
        raise package.damaged(f"a {kind(node)} has {len(systems)} coordinate reference systems")
    return np.concatenate(parts), next(iter(systems))


def mesh_of(package: Package, one: Representation, words: Words, role: Any) -> TriSurface:
    """Triangles of all patches."""
    patches = every(one.node, "TrianglePatch")

    def nodes_in(patch: Element) -> int:
        return package.count(patch, "NodeCount")

    points, crs = patches_of(package, one.node, "TrianglePatch", words, nodes_in)
    triangles, start = [], 0
    for patch in patches:
        listed = values_of(package, package.need(patch, "Triangles"))
        if listed.dtype.kind not in "iu" or listed.size != 3 * package.count(patch, "Count"):
            raise package.damaged(f"{one.title!r} does not have the triangles that it announces")
        corners = listed.reshape(-1, 3).astype(np.int64)
        triangles.append(
            corners + _shift(package, one, corners, start, nodes_in(patch), len(points))
        )
        start += nodes_in(patch)
    try:
        surface = TriSurface(one.title, role, points, np.concatenate(triangles))
    except (SurfaceError, ValueError) as error:
        raise FormatError(f"{package.path}: {error}") from error
    surface.crs = crs
    return surface


def _shift(
    package: Package, one: Representation, corners: np.ndarray, start: int, own: int, n: int
) -> int:
    """
    What to add to the corners of a patch: nodes are counted through all patches, or in each.

    Programs differ in that. Where both readings are possible the file is refused.
    """
    low, high = (int(corners.min()), int(corners.max())) if corners.size else (start, start)
    through, each = start <= low and high < start + own, low >= 0 and high < own
    if start and through and each:
        raise package.damaged(
            f"{one.title!r} has several patches, and their triangles fit nodes counted in each "
            "patch as well as through all of them"
        )
    if through or not each:
        if not 0 <= low <= high < n:
            raise package.damaged(f"{one.title!r} has a triangle with a corner {high} of {n} nodes")
        return 0
    return start


def lines_of(
    package: Package, one: Representation, words: Words
) -> tuple[list[np.ndarray], str | None]:
    """Lines (n, 3) of a polyline or a set of them; closed ones repeat their first point."""
    if one.kind == LINES[0]:
        points, crs = patches_of(package, one.node, "NodePatch", words)
        closed = package.text(one.node, "IsClosed").lower() in ("true", "1")
        return [_ring(points, closed)], crs
    lines: list[np.ndarray] = []
    crs = None
    counts = [_counts(package, patch) for patch in every(one.node, "LinePatch")]
    sizes = iter([int(count.sum()) for count in counts])
    points, crs = patches_of(package, one.node, "LinePatch", words, lambda _: next(sizes))
    at = 0
    for patch, count in zip(every(one.node, "LinePatch"), counts, strict=True):
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


def places_of(package: Package, one: Representation, words: Words) -> np.ndarray:
    """All points of any object."""
    if one.kind == GRID:
        return grid_of(package, one, words)[0]
    if one.kind == MESH:
        return mesh_of(package, one, words, "surface").vertices
    if one.kind == POINTS:
        return patches_of(package, one.node, "NodePatch", words)[0]
    return np.concatenate(lines_of(package, one, words)[0])


__all__ = [
    "FRAMEWORK",
    "GRID",
    "KINDS",
    "LINES",
    "MESH",
    "POINTS",
    "Representation",
    "Words",
    "grid_of",
    "holds_units",
    "lines_of",
    "mesh_of",
    "patches_of",
    "places_of",
    "representations",
]
