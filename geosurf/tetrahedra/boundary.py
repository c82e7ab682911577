"""Faces between units, each once, with the units on its two sides."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError, InvariantError
from geosurf.model import Units


@dataclass(frozen=True, eq=False)
class Boundary:
    """The shared boundary of all units.

    Attributes
    ----------
    x : ndarray of float64, shape (n, 3)
        Local coordinates; each point is a corner of a face.
    origin : ndarray of float64, shape (3,)
    faces : ndarray of int64, shape (n_face, 3)
    sides : ndarray of int64, shape (n_face, 2)
        Unit in front of and behind each; -1 outside.
    surface : ndarray of int64, shape (n_face,)
        Row of `surface_names`.
    surface_names : tuple of str
    """

    x: np.ndarray
    origin: np.ndarray
    faces: np.ndarray
    sides: np.ndarray
    surface: np.ndarray
    surface_names: tuple[str, ...]


def boundary_of(units: Units) -> Boundary:
    """
    List the faces between units.

    Parts of surfaces with one unit on both sides, such as a fault that ends inside a unit, are left
    out. Where surfaces coincide, the first one stands for all.
    """
    pieces, of_piece = units.piece_sides
    full = pieces.expanded
    beside = of_piece[full.element]
    rows = np.flatnonzero(beside[:, 0] != beside[:, 1])

    used, place_of = np.unique(full.triangles[rows], return_inverse=True)
    found = Boundary(
        full.local[used],
        pieces.origin,
        place_of.reshape(-1, 3),
        beside[rows],
        full.surface[rows],
        tuple(source.name for source in pieces.sources),
    )
    _refuse_equal_corners(found)
    return found


def with_parts(
    boundary: Boundary, x: np.ndarray, parts: np.ndarray, parents: np.ndarray
) -> Boundary:
    """
    Replace faces by their parts, turned as they are turned.

    Parameters
    ----------
    boundary : Boundary
    x : ndarray of float64, shape (n, 3)
        Points of the boundary, and others after them.
    parts : ndarray of int64, shape (n_part, 3)
    parents : ndarray of int64, shape (n_part,)
        Face that each is, or is a part of.

    Raises
    ------
    InvariantError
        If the parts of a face do not cover it.
    """
    order = np.argsort(parents, kind="stable")
    parts, parents = parts[order], parents[order]
    count = np.bincount(parents, minlength=len(boundary.faces))

    # a face that is its own part keeps its corners; others are turned by their normals
    whole = boundary.faces[parents]
    alone = count[parents] == 1
    normal, of_whole = (_normals(x, t) for t in (parts, whole))
    turned = np.einsum("ij,ij->i", normal, of_whole) < 0.0
    parts = np.where(turned[:, None], parts[:, [0, 2, 1]], parts)
    found = np.where(alone[:, None], whole, parts)

    # parts of one face have its area
    area, asked = (np.sqrt(np.square(n).sum(axis=1)) for n in (normal, of_whole))
    covered = np.bincount(parents, area / asked, len(boundary.faces))
    split = np.flatnonzero(count != 1)
    if (np.abs(covered[split] - 1.0) > 1e-6).any():
        raise InvariantError("a face of the model is not in the mesh; please report this with it.")
    return replace(
        boundary, x=x, faces=found, sides=boundary.sides[parents], surface=boundary.surface[parents]
    )


def _normals(x: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Normals of faces, twice as long as their areas."""
    a, b, c = (x[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def _refuse_equal_corners(boundary: Boundary) -> None:
    """Raise an error if two corners of faces have one place: no mesh tells them apart."""
    order = np.lexsort(boundary.x.T)
    x = boundary.x[order]
    same = np.flatnonzero((x[1:] == x[:-1]).all(axis=1))
    if not len(same):
        return

    where = x[same[0]] + boundary.origin
    corners = order[[same[0], same[0] + 1]]
    of = boundary.surface[np.isin(boundary.faces, corners).any(axis=1)]
    names = sorted({boundary.surface_names[i] for i in of.tolist()})
    raise GeometryError(
        f"tetrahedra cannot be made: rounding moved two vertices of {', '.join(names)} to one "
        f"place at {place(where)}. Move one of the surfaces slightly.",
        place=where,
        surfaces=names,
    )
