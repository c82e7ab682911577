"""TetGen (Si 2015), the optional extra ``tet``: the one place that imports it.

Switches: ``nobisect`` leaves the faces of the model as they are; TetGen splits those few that it
cannot recover otherwise. ``epsilon`` is as small as doubles allow, and vertices are not merged: the
model is exact, and a tolerance would close its thin units. ``steinerleft=-1``: without it TetGen
stops in silence after 100 000 new points.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np

from geosurf.errors import DependencyError, GeometryError, InvariantError
from geosurf.tetrahedra.boundary import Boundary

EPSILON = 1e-14
LICENCE = (
    "TetGen is licensed under the AGPL 3, or commercially by its author: check that your use is "
    "allowed"
)


def require_extra() -> None:
    """Raise an error that names the extra and its licence, if tetgen is missing."""
    if find_spec("tetgen") is None:
        raise DependencyError(
            "mesh_units needs tetgen, which is not installed. Install the extra: "
            f'pip install "geosurf[tet]". {LICENCE}.'
        )


def fill(
    boundary: Boundary, max_volume: float | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """
    Fill the boundary with tetrahedra.

    Parameters
    ----------
    boundary : Boundary
    max_volume : float or None
        Of a tetrahedron [m3]; None adds only points that a mesh cannot do without.

    Returns
    -------
    x : ndarray of float64, shape (n, 3)
        Those of the boundary first, unchanged.
    tetrahedra : ndarray of int64, shape (n_tetrahedron, 4)
        Seen from the fourth corner, the first three run counterclockwise.
    parts : ndarray of int64, shape (n_part, 3)
        Faces of the mesh on faces of the model.
    parents : ndarray of int64, shape (n_part,)
        Face of the model that each is, or is a part of.

    Raises
    ------
    GeometryError
        If TetGen refuses the model.
    """
    import tetgen

    options: dict[str, Any] = {"quality": False}
    if max_volume is not None:
        options = {"quality": True, "fixedvolume": True, "maxvolume": max_volume}
    try:
        run = tetgen.TetGen(
            np.array(boundary.x),
            boundary.faces.astype(np.int32),
            np.arange(1, len(boundary.faces) + 1, dtype=np.int32),
        )
        run.tetrahedralize(
            facesout=True,
            nobisect=True,
            nomergefacet=True,
            nomergevertex=True,
            epsilon=EPSILON,
            steinerleft=-1,
            **options,
        )
    except (RuntimeError, ValueError, MemoryError) as error:
        raise GeometryError(
            f"TetGen cannot fill the model of {len(boundary.faces)} faces: {error} "
            "Check the model with scene.check(), or move its surfaces slightly."
        ) from error

    # copies: TetGen frees its arrays
    x, cells = np.array(run.node, dtype=np.float64), np.array(run.elem, dtype=np.int64)
    if not len(cells) or not np.array_equal(x[: len(boundary.x)], boundary.x):
        raise InvariantError("TetGen moved vertices of the model; please report this with it.")

    # 0 marks faces inside of units
    marks = np.array(run.triface_markers, dtype=np.int64)
    on = np.flatnonzero(marks > 0)
    return x, cells, np.array(run.trifaces, dtype=np.int64)[on], marks[on] - 1
