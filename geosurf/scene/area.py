"""Where a model is: its box, its area of interest, and the origin of its local frame."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from geosurf.conventions import frame_origin, shift_is_exact
from geosurf.model import TriSurface
from geosurf.scene.inputs import Box
from geosurf.scene.memory import Memory
from geosurf.triangulate import build_walls
from geosurf.triangulate.box import propose_box
from geosurf.triangulate.cover import warning_of_area
from geosurf.triangulate.rims import off_the_rims


def box_around(
    given: Box | None,
    area: np.ndarray | None,
    horizons: Callable[[], list[TriSurface]],
    memory: Memory,
) -> Box:
    """Return the given box, or the default one, as wide as an area in it.

    Parameters
    ----------
    given : (west, east, south, north, bottom, top) or None
    area : ndarray of float64, shape (n, 2), or None
        Corners of the area of interest.
    horizons : callable
        () -> all horizons; asked only for the default box.
    memory : Memory
        Gets the step, and a warning if the default box leaves much of the horizons out.
    """
    if given is not None:
        build_walls(given, area)  # raises where no walls can stand
        west, east, south, north, bottom, top = (float(value) for value in given)
    else:
        surfaces = horizons()
        west, east, south, north, bottom, top = box = propose_box(surfaces, area)
        words = box_in_words(box, surfaces, area)
        memory.note("box", "all horizons", "ran", f"default: {words}")
        if area is None:
            memory.warn(*filter(None, [warning_of_area(surfaces, box)]))
    if area is not None:
        (west, south), (east, north) = area.min(axis=0).tolist(), area.max(axis=0).tolist()
    return west, east, south, north, bottom, top


def box_off_rims(box: Box, horizons: Iterable[TriSurface], memory: Memory) -> Box:
    """Return a box of which no side runs along the rim of a horizon except for rounding."""
    west, east, south, north, *heights = box

    # corners counter-clockwise from the south-west
    ring = np.array([(west, south), (east, south), (east, north), (west, north)])
    moved = outline_off_rims(ring, horizons, "model box", memory)
    (west, south), _, (east, north), _ = moved.tolist()
    return west, east, south, north, *heights


def outline_off_rims(
    outline: np.ndarray, horizons: Iterable[TriSurface], what: str, memory: Memory
) -> np.ndarray:
    """Return an outline of which no side runs along the rim of a horizon except for rounding."""
    with memory.collecting():
        return off_the_rims(outline, list(horizons), what)


def box_in_words(
    sides: Sequence[float], horizons: Sequence[TriSurface], aoi: np.ndarray | None
) -> str:
    """Return where a default box lies, and how much it leaves out because of holes and rims."""
    if aoi is not None:
        return "where the area of interest is"

    # share of the rectangle where the bounds of all horizons overlap
    bounds = np.array([horizon.bounds for horizon in horizons])
    span = bounds[:, 1:4:2].min(axis=0) - bounds[:, 0:4:2].max(axis=0)
    west, east, south, north = sides[:4]
    share = (east - west) * (north - south) / float(span.prod())
    if share > 0.99:
        return "where all horizons are"
    return (
        f"the largest rectangle that all horizons cover, {100 * share:.0f} % of where they "
        "overlap; the remainder has holes or slanting rims"
    )


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


__all__ = ["box_around", "box_in_words", "box_off_rims", "boxes_meet", "outline_off_rims"]
