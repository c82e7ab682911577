"""Points and cells of a mesh file -> a surface in metres, elevation up; for every mesh format."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import first_given
from geosurf.errors import FormatError, SurfaceError
from geosurf.model import TriSurface
from geosurf.read._common import agreed_scale, agreed_sign


def surface_from_mesh(
    path: Path,
    name: str,
    points: np.ndarray,
    triangles: np.ndarray,
    vertex_data: dict[str, Any],
    positive: str | None,
    length_unit: str | None,
) -> TriSurface:
    """Turn what a mesh file holds into a surface in metres, elevation up."""
    what = f"{path}: surface {name!r}"

    # mesh formats state neither direction nor unit: elevation in metres, unless the caller does
    sign = agreed_sign(None, first_given(positive, "up"), what)
    scale = agreed_scale(None, length_unit, "m", what)
    if len(triangles) == 0:
        raise FormatError(
            f"{path}: the file has no triangles. Export the surface as a triangle mesh."
        )
    try:
        world = points * [1.0, 1.0, scale * sign]
        return TriSurface(name, "fault", world, triangles, vertex_data=vertex_data)
    except (SurfaceError, ValueError) as error:
        raise FormatError(f"{path}: {error}") from error


def split_quads(quads: np.ndarray) -> np.ndarray:
    """Triangles (2 n, 3) of quads (n, 4), each split from its first corner."""
    return np.asarray(quads)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
