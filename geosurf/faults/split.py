"""A fault mesh of several pieces -> one fault for each piece."""

from __future__ import annotations

import math

import numpy as np

from geosurf.faults.rim import normals_of
from geosurf.kernels.meshes.mesh import edges, pieces, weld
from geosurf.model import TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.expected import expect


def split_fault(surface: TriSurface) -> dict[str, TriSurface]:
    """Return each connected piece of a fault as a fault of its own.

    Pieces are connected over common edges; vertices at one place count as one. A fault in several
    pieces divides what each piece crosses, but it cannot be extended or lengthened as a whole.

    Parameters
    ----------
    surface : TriSurface

    Returns
    -------
    dict of str to TriSurface
        ``F1 (1)``, ``F1 (2)`` ... from the largest area to the smallest, as `Scene` takes faults.
        Vertices and triangles stay as they are, in their order. A fault in one piece comes back
        under its own name.

    Raises
    ------
    InputError
        For anything that is not a TriSurface.

    Examples
    --------
    >>> corners = [[0, 0, 0], [0, 9, 0], [0, 9, 5], [0, 20, 0], [0, 24, 0], [0, 24, 5]]
    >>> parts = split_fault(TriSurface("F1", "fault", corners, [[3, 4, 5], [0, 1, 2]]))
    >>> {name: part.bounds[2:4] for name, part in parts.items()}
    {'F1 (1)': (0.0, 9.0), 'F1 (2)': (20.0, 24.0)}
    """
    expect(surface, TriSurface, "split_fault takes a TriSurface", "read_fault(path) gives one")
    x, t = surface.vertices, surface.triangles
    number, n_place = weld(x)
    at = number[t]
    piece, n_piece = pieces(at, edges(at, n_place)[0])
    if n_piece < 2:
        return {surface.name: surface}

    # the largest first; of equal ones that with the lowest coordinates
    area = np.linalg.norm(normals_of(x[t]), axis=1)
    rows = [np.flatnonzero(piece == p) for p in range(n_piece)]
    low = [tuple(x[t[mine]].min(axis=(0, 1))) for mine in rows]
    order = sorted(range(n_piece), key=lambda p: (-math.fsum(area[rows[p]]), low[p]))
    names = [f"{surface.name} ({k})" for k in range(1, n_piece + 1)]
    return {name: _part(surface, name, rows[p]) for name, p in zip(names, order, strict=True)}


def _part(surface: TriSurface, name: str, rows: np.ndarray) -> TriSurface:
    """Some triangles of a surface, with their vertices in the order as given."""
    used, t = np.unique(surface.triangles[rows], return_inverse=True)
    data = {key: values[used] for key, values in surface.vertex_data.items()}
    vertices = surface.vertices[used]
    part = TriSurface(name, surface.role, vertices, t.reshape(-1, 3), vertex_data=data)
    return in_crs_of(part, [surface])
