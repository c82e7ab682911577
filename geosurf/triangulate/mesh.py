"""A horizon or fault from vertices and triangles, as other programs export them."""

from __future__ import annotations

from typing import Any

import numpy as np

from geosurf.errors import SurfaceError
from geosurf.model import TriSurface
from geosurf.model.base import in_crs_of
from geosurf.triangulate.degenerate import refuse_zero_area


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
            + (f" Fault sticks: geosurf.FaultSticks({name!r}, sticks)." if role == "fault" else "")
        )
    surface = TriSurface(name, role, obj[0], obj[1])
    if scale != 1.0:
        surface = TriSurface(name, role, surface.vertices * (1.0, 1.0, scale), surface.triangles)
    return in_crs_of(surface, [obj])


def refuse_flat_triangles(surface: TriSurface) -> None:
    """Refuse a mesh with a triangle that has exactly no area."""
    remedy = "Remove these triangles and merge their vertices first."
    refuse_zero_area(surface.name, surface.vertices, surface.triangles, remedy)
