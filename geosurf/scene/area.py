"""Where a model is: its box, its area of interest, the origin of its local frame; its regions."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.carve.regions import propose_regions
from geosurf.conventions import area_text, counted, frame_origin, place, shift_is_exact
from geosurf.errors import GeosurfWarning, issue, warn
from geosurf.faults.distance import in_ring
from geosurf.measure.regions import overlap, region_map, regions_by_name
from geosurf.model import Patches, TriSurface, Units
from geosurf.model.expected import box_of_sides, outline_of
from geosurf.model.regions import KnownRegions, Regions, label_regions
from geosurf.scene.inputs import Box
from geosurf.scene.memory import Memory
from geosurf.scene.surfaces import opened_outline
from geosurf.triangulate import build_walls
from geosurf.triangulate.footprint import Footprint, are_unrotated, footprints_of, propose_box
from geosurf.triangulate.outline import off_the_rims
from geosurf.triangulate.shared_area import SharedArea, shared_area

ENOUGH = 0.99  # of what all horizons cover: a default area with less is worth a warning
MUCH = 0.9  # of one horizon: the same


def default_area(horizons: Sequence[TriSurface], memory: Memory) -> SharedArea | None:
    """Return the outline that horizons share; None if that is where unrotated grids overlap.

    Parameters
    ----------
    horizons : sequence of TriSurface
        Torn ones as lattices: gaps at their faults are not holes.
    memory : Memory
        Gets the step, and warnings of what the area leaves out.
    """
    # their overlap is a rectangle: the box alone says it
    if are_unrotated(horizons):
        with memory.collecting():
            for warning in warnings_of_overlap(horizons):
                warn(warning)
        return None

    def found() -> SharedArea:
        # outlines and holes of the data, one per horizon
        footprints = footprints_of(horizons)
        area = shared_area(footprints)
        data = [  # that an extrapolated part is left out is worth no warning
            footprint
            for footprint, horizon in zip(footprints, horizons, strict=True)
            if "extrapolated" not in horizon.vertex_data
        ]
        for warning in warnings_of_area(area, data):
            warn(warning)
        return area

    # the outline depends on the horizons only, by identity: scenes that share them share it
    key = ("area", *(memory.key_of(horizon) for horizon in horizons))
    result: SharedArea = memory.get_or_compute(
        "area", "all horizons", key, found, area_in_words, again=False
    )
    return result


def area_in_words(area: SharedArea) -> str:
    """Return the size of a default area, and what part of the horizons it is."""
    share = percent(area.share)
    corners = counted(len(area.outline), "corner")
    return f"{area_text(area.area)}, {share} of what all horizons cover, {corners}"


def percent(share: float) -> str:
    """Return a share as text: 100 % only if it is all to within a thousandth.

    Examples
    --------
    >>> percent(0.99996), percent(0.9962), percent(0.181)
    ('100 %', '99.6 %', '18 %')
    """
    digits = 1 if 0.99 <= share < 0.9995 else 0
    return f"{100 * share:.{digits}f} %"


def warnings_of_area(area: SharedArea, horizons: Sequence[Footprint]) -> list[GeosurfWarning]:
    """Return warnings of what a default area leaves out: other pieces, and much of a horizon."""
    warnings = []
    how = "Pass aoi= with the outline of your model to choose another area."

    # separate pieces: sizes and places of those that are left out, the largest by name
    if area.pieces:
        (size, (x, y)), *more = area.pieces
        rest = ""
        if more:
            total = area_text(sum(other for other, _ in more))
            rest = f", and {counted(len(more), 'smaller piece')} of {total} in total"
            if len(more) == 1:
                rest = f", and a smaller one of {total}"
        words = (
            f"All horizons cover {counted(len(area.pieces) + 1, 'separate piece')}. The default "
            f"area is the largest ({area_text(area.area)}); it leaves out {area_text(size)} around "
            f"{place((x, y))}{rest}."
        )
        warnings.append(GeosurfWarning("area", "aoi", words, how))
    elif area.share < ENOUGH:
        words = f"The default area covers {percent(area.share)} of what all horizons cover."
        warnings.append(GeosurfWarning("area", "aoi", words, how))

    # a horizon that loses more than a tenth to others, not to pieces, is named with its loss
    shared = area.area + sum(size for size, _ in area.pieces)
    warnings += [
        _left_out(one.name, area.area, one.area) for one in horizons if shared < MUCH * one.area
    ]
    return warnings


def warnings_of_overlap(horizons: Sequence[TriSurface]) -> list[GeosurfWarning]:
    """Return warnings of what the rectangle in which unrotated grids overlap leaves out of them."""
    # west, east, south, north of each
    sides = np.array([horizon.bounds[:4] for horizon in horizons])
    low, high = sides[:, ::2], sides[:, 1::2]
    size = np.maximum(high.min(axis=0) - low.max(axis=0), 0.0).prod()
    areas = (high - low).prod(axis=1)
    return [
        _left_out(horizon.name, float(size), area)
        for horizon, area in zip(horizons, areas.tolist(), strict=True)
        if 0.0 < size < MUCH * area  # without an overlap there is no box, which is an error
    ]


def _left_out(name: str, size: float, whole: float) -> GeosurfWarning:
    """The warning that an area of some size [m2] leaves out much of a horizon."""
    words = (
        f"The default area covers {percent(size / whole)} of horizon {name!r} ({area_text(size)} "
        f"of {area_text(whole)}), because other horizons end there."
    )
    remedy = (
        "Continue those with gs.extend_horizon(horizon, distance=...), or pass aoi= or box= to "
        "choose another area."
    )
    return GeosurfWarning("area", name, words, remedy)


def rectangle_in_words(sides: Box, horizons: Sequence[TriSurface]) -> str:
    """Return how much of the horizons an axis-parallel rectangle covers."""
    west, east, south, north = sides[:4]
    smallest = min(one.area for one in footprints_of(horizons))
    share = percent((east - west) * (north - south) / smallest)
    return f"the largest axis-parallel rectangle that all horizons cover, {share} of the smallest"


def box_around(
    given: Box | None,
    area: np.ndarray | None,
    horizons: Callable[[], list[TriSurface]],
    in_map: Callable[[], list[TriSurface]],
    memory: Memory,
) -> Box:
    """Return the given box, or the default one, as wide as an area in it.

    Parameters
    ----------
    given : (west, east, south, north, bottom, top) or None
    area : ndarray of float64, shape (n, 2), or None
        Corners of the area of the model.
    horizons : callable
        () -> all horizons; asked only for the default box.
    in_map : callable
        () -> all horizons as they lie in the map: torn ones as grids.
    memory : Memory
        Gets the step.
    """
    # a given box is not touched, only tested
    if given is not None:
        if area is None:
            box_of_sides(given)  # raises where no walls can stand
        else:
            build_walls(given, area)
        west, east, south, north, bottom, top = (float(value) for value in given)
    else:
        grids = in_map()
        west, east, south, north, bottom, top = box = propose_box(horizons(), area, grids)
        words = "around the area"
        if area is None:
            axis_parallel = are_unrotated(grids)
            words = "where all horizons are" if axis_parallel else rectangle_in_words(box, grids)
        memory.note("box", "all horizons", "ran", f"default: {words}")

    # the area is what the walls follow: the box is as wide as it is
    if area is not None:
        (west, south), (east, north) = area.min(axis=0).tolist(), area.max(axis=0).tolist()
    return west, east, south, north, bottom, top


def box_off_rims(box: Box, horizons: Iterable[TriSurface], memory: Memory) -> Box:
    """Return a box of which no side runs along the rim of a horizon except for rounding."""
    moved = outline_off_rims(outline_of(box), horizons, "model box", memory)
    (west, south), _, (east, north), _ = moved.tolist()
    return west, east, south, north, *box[4:]


def outline_off_rims(
    outline: np.ndarray, horizons: Iterable[TriSurface], what: str, memory: Memory
) -> np.ndarray:
    """Return an outline of which no side runs along the rim of a horizon except for rounding."""
    with memory.collecting():
        return off_the_rims(outline, list(horizons), what)


def boxes_meet(p: Sequence[float], q: Sequence[float]) -> bool:
    """Return whether two boxes, (west, east, south, north, bottom, top), have a point in common."""
    return all(p[2 * k] <= q[2 * k + 1] and q[2 * k] <= p[2 * k + 1] for k in range(3))


def shared_origin(box: Box | None, surfaces: Sequence[TriSurface]) -> np.ndarray:
    """Return the origin of the local frame: the box's where shifts by it are exact."""
    if box is not None:
        west, east, south, north, bottom, top = box
        origin = frame_origin(np.array([[west, south, bottom], [east, north, top]]))
        if all(_shift_is_exact(surface, origin) for surface in surfaces):
            return origin
    return frame_origin(*(surface.extent for surface in surfaces))


def _shift_is_exact(surface: TriSurface, origin: np.ndarray) -> bool:
    """Whether a surface can be moved to an origin (whose elevation is 0); a grid has short axes."""
    if not origin.any():
        return True
    lattice = surface.lattice
    axes = surface.vertices.T[:2] if lattice is None else (lattice.easting, lattice.northing)
    return all(shift_is_exact(axis, shift) for axis, shift in zip(axes, origin[:2], strict=True))


SAMPLE = 20_000  # triangles, or parts of triangles, of which each counts by its middle


def share_inside(surface: TriSurface, box: Box, outline: np.ndarray | None) -> float:
    """
    Return the share of a surface that is inside a model, to within about a percent.

    Parameters
    ----------
    surface : TriSurface
        Of a horizon the area in the map counts, whatever its elevation; of a fault its own area.
    box : (west, east, south, north, bottom, top)
        [m]
    outline : ndarray of float64, shape (n, 2), or None
        Corners of the area of the model [m]; None if it is the box.

    Examples
    --------
    >>> corners = [[0, 0, -90], [0, 40, -90], [0, 40, 0], [0, 0, 0]]
    >>> fault = TriSurface("F1", "fault", corners, [[0, 1, 2], [0, 2, 3]])
    >>> round(share_inside(fault, (-5, 5, 0, 30, -90, 0), None), 2)
    0.75
    """
    # sampled: a share in per cent goes into a table, and decides nothing
    middles, areas = parts_of(surface)
    n_axis = 2 if surface.role == "horizon" else 3
    inside = np.ones(len(middles), dtype=bool)
    for axis in range(n_axis):
        inside &= (middles[:, axis] >= box[2 * axis]) & (middles[:, axis] <= box[2 * axis + 1])
    if outline is not None:
        inside[inside] = in_ring(middles[inside], outline)
    total = float(areas.sum())
    return float(areas[inside].sum()) / total if total > 0 else 0.0


def parts_of(surface: TriSurface) -> tuple[np.ndarray, np.ndarray]:
    """Middles (n, 3) and areas (n,) of parts of a surface: of large triangles many."""
    corners = _triangles(surface)

    # few large triangles are cut into n x n parts each, so that about SAMPLE parts count in all
    n = max(int(np.sqrt(SAMPLE / max(len(corners), 1))), 1)

    # parts that stand upright and those that stand on their tip, by the weights of their corners
    first = np.array([(i, j, n - 1 - i - j) for i in range(n) for j in range(n - i)])
    second = np.array([(i, j, n - 2 - i - j) for i in range(n - 1) for j in range(n - 1 - i)])
    weights = np.concatenate([first + 1.0 / 3.0, second.reshape(-1, 3) + 2.0 / 3.0]) / n
    middles = (weights @ corners).reshape(-1, 3)

    # relative areas are enough, and all parts of a triangle have the same
    a, b, c = corners.swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    flat = (
        np.abs(normals[:, 2])
        if surface.role == "horizon"
        else np.hypot(np.hypot(normals[:, 0], normals[:, 1]), normals[:, 2])
    )
    return middles, np.repeat(flat, len(weights))


def _triangles(surface: TriSurface) -> np.ndarray:
    """Corners (n, 3, 3) of all triangles, or of some spread evenly where there are many."""
    # at even distances, so that all of a large grid is seen
    rows = np.linspace(0, surface.n_triangle - 1, min(surface.n_triangle, SAMPLE)).astype(np.int64)
    keys = rows if surface.lattice is None else surface.lattice.keys_of_rows(rows)
    return surface.places_of_nodes(surface.corners_of_keys(keys).ravel()).reshape(-1, 3, 3)


def coverage_in_words(shares: Sequence[tuple[str, float]]) -> str:
    """Return names with the shares of them that are inside.

    Examples
    --------
    >>> coverage_in_words([("Top", 1.0), ("F1", 0.874), ("F2", 0.0)])
    'Top 100 %, F1 87 %, F2 0 %'
    """
    return ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares)


# ---- regions ----------------------------------------
# The regions of a scene: proposed, named, or as the scene that it was made from has them.


class NamedRegions:
    """Regions of some units, found when they are first requested.

    Parameters
    ----------
    patches, units : Patches, Units
    given : mapping of str to object
        As `Scene` takes them, checked.
    known : KnownRegions or None
        Regions of the scene that this one was made from.
    """

    def __init__(
        self, patches: Patches, units: Units, given: Mapping[str, Any], known: KnownRegions | None
    ) -> None:
        self.patches, self.units, self.given, self.known = patches, units, given, known
        self.warnings: list[GeosurfWarning] = []

    @cached_property
    def found(self) -> Regions:
        """The regions."""
        proposals, known = propose_regions(self.units), self.known
        shared = None
        if known is not None and not known.has_same_blocks(proposals):
            assert known.places is not None
            box, before = known.places()
            there = region_map(self.units, proposals, box)
            shared = overlap(before, there, (len(known.labels), len(proposals)))
        labels = label_regions(proposals, known, shared, tuple(self.given))

        # names of a scene before keep to their regions; others are looked for, and polygons, which
        # may hold more or less than before
        kept = {name for name, _ in known.labels} if known else set()
        given = {name: _opened(value) for name, value in self.given.items()}
        new = {n: one for n, one in given.items() if n not in kept or isinstance(one, np.ndarray)}
        labels = [(letter if name in new else name, letter) for name, letter in labels]
        if new:
            for k, name in regions_by_name(self.patches, self.units, proposals, new).items():
                labels[k] = name, labels[k][1]
        regions = Regions(proposals, labels)
        for name in self.given:
            if name not in regions:
                self.warnings.append(_lost(name))
                issue(self.warnings[-1])
        self.known = None  # the model before is no longer needed
        return regions

    @property
    def found_already(self) -> bool:
        """Whether anybody has requested the regions, and there are some."""
        return bool(self.__dict__.get("found"))

    def known_as(self, model: Hashable) -> KnownRegions:
        """What scenes made from this one take names from."""
        labels, proposals = zip(*self.found.proposals, strict=True)
        blocks = tuple(tuple(proposal.blocks) for proposal in proposals)
        return KnownRegions(labels, blocks, model, self.places)

    def places(self) -> tuple[tuple[float, ...], np.ndarray]:
        """The box, and the row of the region at places all over its map."""
        return self.units.box, self._map

    @cached_property
    def _map(self) -> np.ndarray:
        proposals = [proposal for _, proposal in self.found.proposals]
        return region_map(self.units, proposals, self.units.box)


def _opened(value: Any) -> Any:
    """A place or sides of faults as they are; a polygon as an array of corners."""
    is_plain = isinstance(value, tuple) and isinstance(value[0], str | float)
    return value if is_plain else np.asarray(opened_outline(value), dtype=np.float64)


def _lost(name: str) -> GeosurfWarning:
    return GeosurfWarning(
        "region", name,
        f"Region {name!r} is gone: none of the blocks that it had is a region of its own any more.",
        f"Name a place in it again: scene.replace(regions={{{name!r}: (easting, northing)}}).",
    )  # fmt: skip
