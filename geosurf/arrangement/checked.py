"""Check surfaces before the search: what exact geometry has no answer for is refused."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from geosurf.arrangement.torn_trees import look_at_torn
from geosurf.arrangement.tree import look_at_list
from geosurf.conventions import is_number, place
from geosurf.errors import InputError, SurfaceError
from geosurf.kernels.exact.predicates import (
    MAX_BITS,
    MAX_COORDINATE,
    flat_triangles,
    frame_of,
)
from geosurf.model import TriSurface
from geosurf.model.expected import listed

# a number has 53 digits from its first one on: all numbers together need fewer than MAX_BITS
_FEW_DIGITS = 2.0 ** (MAX_BITS - 60)


def check_surfaces(surfaces: Sequence[TriSurface], least: int = 1) -> tuple[TriSurface, ...]:
    """Return the surfaces as a tuple, or raise an error that names the wrong one."""
    surfaces = tuple(listed(surfaces, "surfaces are expected", "give a list of TriSurface"))
    if len(surfaces) < least:
        raise InputError(f"{len(surfaces)} surfaces were passed; at least {least} are needed.")
    for i, surface in enumerate(surfaces):
        if not isinstance(surface, TriSurface):
            raise InputError(
                f"surface {i} is a {type(surface).__name__}, not a TriSurface. Convert it with "
                "triangulate_horizon or triangulate_fault."
            )
        # Checked once for each surface; surfaces are immutable.
        if not surface.checked:
            if surface.n_triangle == 0:
                raise SurfaceError(f"surface {surface.name!r} has no triangles; leave it out.")
            _check_triangles(surface)
            surface.checked = True
    return surfaces


def _check_triangles(surface: TriSurface) -> None:
    """Refuse what exact geometry has no answer for."""
    lattice = surface.lattice
    doubted, small = None, 0.0
    if lattice is not None:
        large = float(np.abs(lattice.survey.box).max())
    else:
        doubted, small, large = look_at_torn(surface) or look_at_list(surface)
    if large > MAX_COORDINATE:
        raise SurfaceError(
            f"surface {surface.name!r} has a coordinate of {large:g} m; the limit is "
            f"{MAX_COORDINATE:g} m. Replace undefined values by NaN."
        )

    # A lattice over the map has no vertical triangles and needs no exact test.
    if lattice is not None and lattice.is_graph:
        return  # no triangle stands upright; whether digits suffice is seen where it is used

    # No triangle is nearly flat, and the digits of all numbers fit: nothing is left to decide.
    if doubted is not None and len(doubted) == 0 and large < small * _FEW_DIGITS:
        return
    _refuse_flat(surface, doubted)


def _refuse_flat(surface: TriSurface, doubted: np.ndarray | None) -> None:
    """Refuse triangles without area among some rows (None: all), decided exactly."""
    x, t = surface.vertices, surface.triangles
    try:
        m, w = frame_of(x)
    except SurfaceError as error:
        raise SurfaceError(f"surface {surface.name!r}: {error}") from error
    if doubted is None:
        flat = flat_triangles(x, t, m, w)
    else:
        flat = doubted[flat_triangles(x, t[doubted], m, w)]

    if len(flat):
        where = place(x[t[flat[0], 0]])
        raise SurfaceError(
            f"surface {surface.name!r}: {len(flat)} of {surface.n_triangle} triangles have no "
            f"area, the first is triangle {flat[0]} at {where}. Remove them from the surface."
        )


def check_voxel_size(voxel_size: Any) -> None:
    """Refuse an edge of the search voxels that is not a length."""
    if voxel_size is not None and not (is_number(voxel_size) and voxel_size > 0):
        raise InputError(f"voxel_size is {voxel_size!r}; give a length in metres above 0.")
