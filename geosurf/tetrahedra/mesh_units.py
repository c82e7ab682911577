"""Mesh units: the steps from a sealed model to tetrahedra."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from geosurf.conventions.running import running
from geosurf.errors import InputError, InvariantError
from geosurf.kernels.exact.predicates import frame_of, orient3d_rows
from geosurf.model import TetMesh, Units
from geosurf.model.base import in_crs_of
from geosurf.model.expected import expect, number_of
from geosurf.tetrahedra.boundary import boundary_of, with_parts
from geosurf.tetrahedra.refine import refined
from geosurf.tetrahedra.regions import regions_of
from geosurf.tetrahedra.run_tetgen import fill, require_extra

REGULAR = 1.0 / (6.0 * math.sqrt(2.0))  # volume of the regular tetrahedron with edges of 1 m
MOST = 100_000_000  # tetrahedra: 30 GB
ALLOWED = 1e-12  # of a unit


@running("tetrahedra")
def mesh_units(units: Units, size: float | None = None) -> TetMesh:
    """
    Fill all units with tetrahedra: one conforming mesh, with the unit of each.

    Parameters
    ----------
    units : Units
        As from `carve_units` or ``Scene.units``.
    size : float, optional
        Target length of edges [m]: longer edges of faces are halved, TetGen aims at the volume of
        the regular tetrahedron with such edges, and improves shapes. A few tetrahedra next to faces
        stay larger. By default only points that the mesh needs are added.

    Returns
    -------
    TetMesh
        Its `faces` are the triangles of the model, and with `size` parts of them. Flat parts, such
        as walls and level contacts, are triangulated again: shapes of units change by the rounding
        of their corners only. TetGen splits a few faces that it cannot recover otherwise.

    Raises
    ------
    DependencyError
        If tetgen is not installed: ``pip install "geosurf[tet]"``. TetGen is licensed under the
        AGPL 3, or commercially by its author.
    InputError
        If `size` is not a positive length, or asks for more than 100 million tetrahedra; if the
        units have no patches.
    GeometryError
        If rounding moved two vertices to one place, or TetGen refuses the model or does not end:
        after 5 minutes and 5 ms for each face and each tetrahedron of the asked size.
    InvariantError
        If the mesh is not one of the units.

    Notes
    -----
    Constrained Delaunay tetrahedra (Si, TetGen, ACM TOMS 41, 2015) of the faces between units, each
    of which goes in once. The result is checked each time: every face inside belongs to two
    tetrahedra, every face of the model is a face of the mesh, no tetrahedron is inside out, and the
    volume of each unit is the exact one to 1e-12 of it and the rounding of its corners.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=5)
    >>> units = gs.Scene(world.horizons, world.faults, world.box).units
    >>> mesh = mesh_units(units, size=500.0)  # doctest: +SKIP
    >>> bool(abs(mesh.volumes - units.volumes).max() < 0.01)  # doctest: +SKIP
    True
    """
    expect(units, Units, "mesh_units takes Units", "pass scene.units")
    if not len(units):
        raise InputError("the model has no units to mesh. Pass scene.units of a model with some.")
    largest = None if size is None else _largest(size, units)
    require_extra()

    boundary = refined(boundary_of(units), math.inf if size is None else float(size))
    expected = units.volume / largest if largest else 0.0
    x, tetrahedra, parts, parents = fill(boundary, largest, expected)
    boundary = with_parts(boundary, x, parts, parents)
    region = regions_of(tetrahedra, boundary.faces, boundary.sides, len(x))
    mesh = TetMesh(
        x,
        boundary.origin,
        tetrahedra,
        region,
        tuple(units),
        boundary.faces,
        boundary.surface,
        boundary.sides,
        boundary.surface_names,
    )
    _check_volumes(mesh, units)
    return in_crs_of(mesh, [units])


def _largest(size: Any, units: Units) -> float:
    """Largest volume of a tetrahedron [m3], if a model of such ones is not too large."""
    size = number_of(size, "size", "give a length in metres")
    if size <= 0.0:
        raise InputError(f"size is {size:g} m; give a length above 0 in metres.")
    largest = float(REGULAR * size**3)
    count = units.volume / largest if largest > 0.0 else math.inf
    if count > MOST:
        least = (units.volume / (REGULAR * MOST)) ** (1.0 / 3.0)
        raise InputError(
            f"size={size:g} asks for {count:.2g} tetrahedra, more than {MOST:.0e}. "
            f"Give size={math.ceil(least)} or more."
        )
    return largest


def _check_volumes(mesh: TetMesh, units: Units) -> None:
    """Raise an error if a tetrahedron is inside out or a unit has another volume."""
    rounding = _rounding(mesh)

    # signs that doubles do not decide are computed in integers
    doubtful = mesh.tetrahedra[mesh.cell_volumes <= rounding]
    if len(doubtful):
        signs = np.empty(len(doubtful), dtype=np.int64)
        orient3d_rows(mesh.local, doubtful, *frame_of(mesh.local), signs)
        if (signs <= 0).any():
            raise InvariantError("a tetrahedron is inside out; please report this with the model.")

    found, exact = mesh.volumes.values, units.volumes.values
    allowed = ALLOWED * exact + np.bincount(mesh.region, rounding, len(exact))
    if (wrong := np.flatnonzero(np.abs(found - exact) > allowed)).size:
        k = int(wrong[0])
        raise InvariantError(
            f"tetrahedra of unit {mesh.unit_names[k]!r} have {found[k]:.17g} m3, the unit has "
            f"{exact[k]:.17g} m3; please report this with the model."
        )


def _rounding(mesh: TetMesh) -> np.ndarray:
    """Bound of the rounding error in the volume of each tetrahedron [m3]."""
    a, b, c, d = (mesh.local[mesh.tetrahedra[:, k]] for k in range(4))
    lengths = [np.sqrt(np.square(corner - a).sum(axis=1)) for corner in (b, c, d)]
    # 9 products of 3 factors, each rounded a few times
    found: np.ndarray = 8.0 * np.finfo(np.float64).eps * lengths[0] * lengths[1] * lengths[2]
    return found
