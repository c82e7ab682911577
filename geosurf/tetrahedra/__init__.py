"""Fill sealed units with tetrahedra: one conforming mesh with the unit of each.

The process of TetGen runs `tetgen_process.py`.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from geosurf.arrangement.triangles import halved
from geosurf.conventions import counted, place
from geosurf.conventions.machine import missing_sentence
from geosurf.conventions.running import running
from geosurf.errors import DependencyError, GeometryError, InputError, InvariantError
from geosurf.kernels.exact.predicates import frame_of, orient3d_rows
from geosurf.kernels.meshes.mesh import edge_keys, join_pairs
from geosurf.model import TetMesh, Units
from geosurf.model.base import in_crs_of
from geosurf.model.expected import expect, number_of
from geosurf.stopping import temporary_folder

# ---- boundary ----------------------------------------
# Faces between units, each once, with the units on its two sides.


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
    boundary = Boundary(
        full.local[used],
        pieces.origin,
        place_of.reshape(-1, 3),
        beside[rows],
        full.surface[rows],
        tuple(source.name for source in pieces.sources),
    )
    _refuse_equal_corners(boundary)
    return boundary


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
    normal, whole_normal = (_normals(x, t) for t in (parts, whole))
    turned = np.einsum("ij,ij->i", normal, whole_normal) < 0.0
    parts = np.where(turned[:, None], parts[:, [0, 2, 1]], parts)
    faces = np.where(alone[:, None], whole, parts)

    # parts of one face have its area
    area, asked = (np.sqrt(np.square(n).sum(axis=1)) for n in (normal, whole_normal))
    covered = np.bincount(parents, area / asked, len(boundary.faces))
    split = np.flatnonzero(count != 1)
    if (np.abs(covered[split] - 1.0) > 1e-6).any():
        raise InvariantError("a face of the model is not in the mesh; please report this with it.")
    return replace(
        boundary, x=x, faces=faces, sides=boundary.sides[parents], surface=boundary.surface[parents]
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

    meshed, exact = mesh.volumes.values, units.volumes.values
    allowed = ALLOWED * exact + np.bincount(mesh.region, rounding, len(exact))
    if (wrong := np.flatnonzero(np.abs(meshed - exact) > allowed)).size:
        k = int(wrong[0])
        raise InvariantError(
            f"tetrahedra of unit {mesh.unit_names[k]!r} have {meshed[k]:.17g} m3, the unit has "
            f"{exact[k]:.17g} m3; please report this with the model."
        )


def _rounding(mesh: TetMesh) -> np.ndarray:
    """Bound of the rounding error in the volume of each tetrahedron [m3]."""
    a, b, c, d = (mesh.local[mesh.tetrahedra[:, k]] for k in range(4))
    lengths = [np.sqrt(np.square(corner - a).sum(axis=1)) for corner in (b, c, d)]
    # 9 products of 3 factors, each rounded a few times
    made: np.ndarray = 8.0 * np.finfo(np.float64).eps * lengths[0] * lengths[1] * lengths[2]
    return made


def refined(boundary: Boundary, size: float = math.inf) -> Boundary:
    """
    Flip edges of flat parts, and halve all edges longer than a size, until none is left.

    An edge is halved for all faces around it, so that the boundary of each unit stays closed. The
    middle is rounded to float64. Inside flat parts only edges are halved whose middles are half a
    size apart from other points; then edges are flipped until they are Delaunay. A few there stay
    longer, by less than half. Shapes change by rounding only.

    Parameters
    ----------
    boundary : Boundary
    size : float
        [m]; by default no edge is halved, and edges of flat parts are flipped only.
    """
    x, faces = boundary.x, boundary.faces
    parent = np.arange(len(faces))
    key = np.column_stack([boundary.surface, boundary.sides])
    kind = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    parts = flat_parts(x, faces, kind, size if math.isfinite(size) else 0.0)
    faces = flipped(x, faces, parts)
    while True:
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        square = np.square(x[edges[:, 0]] - x[edges[:, 1]]).sum(axis=1)
        long = square > size**2
        key = edges[:, 0] * len(x) + edges[:, 1]
        long[long] = np.isin(key[long], _chosen(x, faces, parts, key, square, size))
        if not long.any():
            break

        x, faces, source = halved(x, faces, long.reshape(-1, 3))
        parent, parts = parent[source], replace(parts, of_face=parts.of_face[source])
        faces = flipped(x, faces, parts)
    return replace(
        boundary, x=x, faces=faces, sides=boundary.sides[parent], surface=boundary.surface[parent]
    )


def _chosen(
    x: np.ndarray, faces: np.ndarray, parts: FlatParts, key: np.ndarray, square: np.ndarray,
    size: float,
) -> np.ndarray:  # fmt: skip
    """Keys of the long edges to halve: all, but inside flat parts only those that are apart."""
    one, other, i, _ = pairs_of(faces, len(x))
    inside = (parts.of_face[one] >= 0) & (parts.of_face[one] == parts.of_face[other])
    edge = 3 * one[inside] + i[inside]
    within = key[edge]
    rest = np.setdiff1d(key[square > size**2], within)

    edge = edge[square[edge] > size**2]
    if len(rest) or not len(edge):
        return rest  # the borders of flat parts first
    a, b = key[edge] // len(x), key[edge] % len(x)
    middles = 0.5 * (x[a] + x[b])
    used = np.unique(faces[parts.of_face >= 0])
    made: np.ndarray = key[edge[spaced(middles, square[edge], x[used], 0.5 * size)]]
    return made


ROUNDING = 64.0 * np.finfo(np.float64).eps  # of the largest coordinate: places of vertices
BEND = 1e-6  # neighbours bend no more than this [1 - cosine], before their corners are compared
STRICT = 1e-9  # an edge is flipped if the angles opposite to it exceed 180 degrees by this


@dataclass(frozen=True, eq=False)
class FlatParts:
    """Flat parts of faces.

    Attributes
    ----------
    of_face : ndarray of int64, shape (n_face,)
        Number of the part; -1 where faces are not flat.
    centre : ndarray of float64, shape (n_part, 3)
    axes : ndarray of float64, shape (n_part, 2, 3)
        Orthogonal, in the plane.
    """

    of_face: np.ndarray
    centre: np.ndarray
    axes: np.ndarray

    def in_plane(self, part: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Coordinates (n, 2) of places (n, 3) in the planes of parts (n,)."""
        made: np.ndarray = np.einsum("nij,nj->ni", self.axes[part], x - self.centre[part])
        return made


def flat_parts(x: np.ndarray, faces: np.ndarray, kind: np.ndarray, size: float) -> FlatParts:
    """
    Find parts whose corners lie on one plane, to the rounding of coordinates.

    Parameters
    ----------
    x : ndarray of float64, shape (n, 3)
    faces : ndarray of int64, shape (n_face, 3)
    kind : ndarray of int64, shape (n_face,)
        Faces of different kinds are not joined.
    size : float
        Parts without an edge longer than this are left out [m].

    Returns
    -------
    FlatParts
    """
    corners = x[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.sqrt(np.square(normal).sum(axis=1))
    normal /= np.where(area > 0.0, area, 1.0)[:, None]
    face, other, _, _ = pairs_of(faces, len(x))
    level = np.einsum("ij,ij->i", normal[face], normal[other]) > 1.0 - BEND
    joined = level & (kind[face] == kind[other])
    label = join_pairs(np.stack([face[joined], other[joined]], axis=1), len(faces))

    # only parts of several faces with a long edge
    longest = np.square(corners - np.roll(corners, 1, axis=1)).sum(axis=2).max(axis=1)
    count = np.bincount(label)
    asked = np.unique(label[longest > size**2])
    order = np.argsort(label, kind="stable")
    end = np.cumsum(count)
    part_of_face, centres, axes = np.full(len(faces), -1), [np.zeros(3)], [np.zeros((2, 3))]
    allowed = ROUNDING * np.abs(x).max(initial=0.0)
    for part in asked[count[asked] > 1].tolist():
        rows = order[end[part] - count[part] : end[part]]
        places = x[np.unique(faces[rows])]
        centre = places.mean(axis=0)
        turned = np.linalg.svd(places - centre, full_matrices=False)[2]
        if np.abs((places - centre) @ turned[2]).max() <= allowed:
            part_of_face[rows] = len(centres)
            centres.append(centre)
            axes.append(turned[:2])
    return FlatParts(part_of_face, np.array(centres), np.array(axes))


def pairs_of(
    faces: np.ndarray, n_vertex: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return both faces of each edge that exactly two faces share, and its place in each (0..2)."""
    key = edge_keys(faces, n_vertex)
    order = np.argsort(key, kind="stable")
    new = np.diff(key[order], prepend=-1, append=-1) != 0
    start = np.flatnonzero(new[:-1])
    start = start[np.diff(start, append=len(order)) == 2]
    one, other = order[start], order[start + 1]
    return one // 3, other // 3, one % 3, other % 3


def _held_edges(faces: np.ndarray, parts: FlatParts, n_vertex: int) -> np.ndarray:
    """Edges inside flat parts that belong to other faces, too: a thin unit ends there. They stay.

    Nearly always there are none. Flips make no others, since faces of a model meet at edges only.
    """
    flat = parts.of_face >= 0
    face, other, i, _ = pairs_of(faces[flat], n_vertex)
    of = parts.of_face[flat]
    edges = edge_keys(faces[flat], n_vertex).reshape(-1, 3)
    inner = edges[face, i][of[face] == of[other]]
    return np.intersect1d(inner, edge_keys(faces[~flat], n_vertex))


def _keys(edges: np.ndarray, n_vertex: int) -> np.ndarray:
    """Number of each edge (n, 2)."""
    low, high = np.sort(edges, axis=1).T
    made: np.ndarray = low * n_vertex + high
    return made


def flipped(x: np.ndarray, faces: np.ndarray, parts: FlatParts) -> np.ndarray:
    """
    Flip edges inside flat parts until they are Delaunay.

    Parameters
    ----------
    x : ndarray of float64, shape (n, 3)
    faces : ndarray of int64, shape (n_face, 3)
    parts : FlatParts

    Returns
    -------
    ndarray of int64, shape (n_face, 3)
        Turned as before. The row of a face stays in its part.
    """
    rows = np.flatnonzero(parts.of_face >= 0)
    out = faces.copy()

    held = _held_edges(faces, parts, len(x))
    while len(rows):
        face, other, i, j = pairs_of(out[rows], len(x))
        face, other = rows[face], rows[other]
        inside = parts.of_face[face] == parts.of_face[other]
        if len(held):
            ends = np.stack([out[face, i], out[face, (i + 1) % 3]], axis=1)
            inside &= ~np.isin(_keys(ends, len(x)), held)
        face, other, i, j = face[inside], other[inside], i[inside], j[inside]
        a, b, c = (out[face, (i + k) % 3] for k in range(3))
        d = out[other, (j + 2) % 3]
        p, q, r, s = (parts.in_plane(parts.of_face[face], x[v]) for v in (a, b, c, d))
        side = np.sign(_cross(q - p, r - p))

        # both new faces are turned as the old ones, and the angles at c and d exceed 180 degrees
        good = (side * _sine(s - p, r - p) > STRICT) & (side * _sine(q - s, r - s) > STRICT)
        sines = side * _sine(p - r, q - r), side * _sine(q - s, p - s)
        cosines = _cosine(p - r, q - r), _cosine(q - s, p - s)
        excess = -(sines[0] * cosines[1] + sines[1] * cosines[0])
        good &= (excess > STRICT) & (out[face, i] == out[other, (j + 1) % 3])
        at = np.flatnonzero(good)
        if not len(at):
            break

        # each face takes part in one flip: that with the largest excess, of equal ones the first
        at = at[np.argsort(-excess[at], kind="stable")]
        rank = np.full(len(out), len(at))
        np.minimum.at(rank, face[at], np.arange(len(at)))
        np.minimum.at(rank, other[at], np.arange(len(at)))
        own = np.arange(len(at))
        at = at[(rank[face[at]] == own) & (rank[other[at]] == own)]
        out[face[at]] = np.stack([a[at], d[at], c[at]], axis=1)
        out[other[at]] = np.stack([d[at], b[at], c[at]], axis=1)
    return out


def spaced(
    middles: np.ndarray, lengths: np.ndarray, others: np.ndarray, least: float
) -> np.ndarray:
    """
    Choose places that are apart from each other and from other places, longest edges first.

    Parameters
    ----------
    middles : ndarray of float64, shape (n, 3)
    lengths : ndarray of float64, shape (n,)
    others : ndarray of float64, shape (m, 3)
    least : float
        Distance [m].

    Returns
    -------
    ndarray of int64
        Rows of `middles`; not all that could be chosen, but at least one if any could.
    """
    free = cKDTree(others).query(middles, distance_upper_bound=least)[0] >= least
    rows = np.flatnonzero(free)
    rows = rows[np.argsort(-lengths[rows], kind="stable")]
    if not len(rows):
        return rows

    # the first of each cube, then those without a better one nearby
    cube = np.floor(middles[rows] / least).astype(np.int64)
    rows = rows[np.sort(np.unique(cube, axis=0, return_index=True)[1])]
    close = cKDTree(middles[rows]).query_pairs(least, output_type="ndarray")
    worse = np.zeros(len(rows), dtype=bool)
    worse[close.max(axis=1, initial=0)] = len(close) > 0
    return rows[~worse]


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross products of vectors of a plane."""
    made: np.ndarray = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return made


def _sine(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Sines of the angles from a to b; 0 where one has no length."""
    made: np.ndarray = _cross(a, b) / _lengths(a, b)
    return made


def _cosine(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cosines of the angles from a to b; 0 where one has no length."""
    made: np.ndarray = (a * b).sum(axis=1) / _lengths(a, b)
    return made


def _lengths(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products of the lengths of vectors; 1 where one has none."""
    found = np.hypot(*a.T) * np.hypot(*b.T)
    return np.where(found > 0.0, found, 1.0)


# outward faces of a positive tetrahedron, each opposite to the corner of the same number
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])


def regions_of(
    tetrahedra: np.ndarray, faces: np.ndarray, sides: np.ndarray, n_vertex: int
) -> np.ndarray:
    """
    Find the unit of each tetrahedron.

    Parameters
    ----------
    tetrahedra : ndarray of int64, shape (n, 4)
        Positive.
    faces : ndarray of int64, shape (n_face, 3)
        Faces between units.
    sides : ndarray of int64, shape (n_face, 2)
        Unit in front of and behind each; -1 outside.
    n_vertex : int

    Returns
    -------
    ndarray of int64, shape (n,)

    Raises
    ------
    InvariantError
        If a face of the model is missing, a face inside belongs to one tetrahedron, or a
        tetrahedron would be in two units.

    Examples
    --------
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    >>> regions_of(np.array([[0, 1, 2, 3]]), faces, np.array([[-1, 5]] * 4), 4)
    array([5])
    """
    n = len(tetrahedra)
    all_faces = np.concatenate([tetrahedra[:, FACES].reshape(-1, 3), faces])
    low, odd = _sorted_corners(all_faces)

    # equal faces follow each other, those of tetrahedra first: lexsort is stable
    order = np.lexsort((low[:, 2], low[:, 0] * n_vertex + low[:, 1]))
    same = (low[order[1:]] == low[order[:-1]]).all(axis=1)
    start = np.flatnonzero(np.concatenate([[True], ~same]))
    is_model = order >= 4 * n
    n_tets = np.add.reduceat((~is_model).astype(np.int64), start)
    n_model = np.add.reduceat(is_model.astype(np.int64), start)

    # inside: two tetrahedra and no face of the model
    inside = start[n_model == 0]
    _require((n_tets[n_model == 0] == 2).all(), "a face inside the model is not shared")
    pairs = np.stack([order[inside] // 4, order[inside + 1] // 4], axis=1)

    # boundary: the face of the model comes last, after its one or two tetrahedra
    _require((n_model <= 1).all(), "a face of the model occurs twice")
    first, count = start[n_model == 1], n_tets[n_model == 1]
    face = order[first + count] - 4 * n
    outer = (sides[face] == -1).any(axis=1)
    _require((count == np.where(outer, 1, 2)).all(), "a face of the model is not in the mesh")

    unit = np.full(n, -1)
    root = join_pairs(pairs, n)
    for k in range(2):
        has = count > k
        row = order[first[has] + k]
        # the face of a tetrahedron looks outward: one that runs the same way is in front of it
        behind = odd[row] == odd[4 * n + face[has]]
        seen = np.where(behind, sides[face[has], 1], sides[face[has], 0])
        for _ in range(2):  # written, then read: whoever wrote something else shows
            conflict = (unit[root[row // 4]] >= 0) & (unit[root[row // 4]] != seen)
            _require(not conflict.any(), "a tetrahedron is in two units")
            unit[root[row // 4]] = seen
    found: np.ndarray = unit[root]
    _require((found >= 0).all(), "a tetrahedron is in no unit")
    return found


def _sorted_corners(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of each face, rising, and whether an odd permutation sorts them."""
    a, b, c = faces.T
    odd = (a > b) ^ (b > c) ^ (a > c)
    return np.sort(faces, axis=1), odd


def _require(holds: object, what: str) -> None:
    """Raise an error if a property of a mesh does not hold."""
    if not holds:
        raise InvariantError(f"{what}; please report this with the model.")


EPSILON = 1e-14
# TetGen takes two edges at a corner for one if their angle is below 0.1 degrees, and calls them
# self-intersections. Needles that the cut of surfaces leaves are narrower. In every other order it
# tells them apart; in the first it does not, since it then loses a face of a few other models.
STRAIGHT = 180.0  # degrees
RATIO = 4.0  # radius of the sphere around a tetrahedron over its shortest edge
PATIENCE = 300.0, 0.005  # [s], and for each face and each tetrahedron of the asked size
SHORT = 20.0, 0.0003  # the same of all orders but the last: six times what models at hand take
N_ORDER = 4
PROCESS = Path(__file__).with_name("tetgen_process.py")
LICENCE = (
    "TetGen is licensed under the AGPL 3, or commercially by its author: check that your use is "
    "allowed"
)


def require_extra() -> None:
    """Raise an error that names the extra and its licence, if tetgen is missing."""
    if sentence := missing_sentence("mesh_units needs", "tetgen"):
        raise DependencyError(f"{sentence}. {LICENCE}.")


def fill(
    boundary: Boundary, max_volume: float | None, expected: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """
    Fill the boundary with tetrahedra.

    Parameters
    ----------
    boundary : Boundary
    max_volume : float or None
        Of a tetrahedron [m3]; None adds only points that a mesh cannot do without.
    expected : float
        Number of tetrahedra of that volume.

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
        If TetGen refuses the model, or does not end.
    """
    options: dict[str, Any] = {"quality": False}
    if max_volume is not None:
        options = {
            "quality": True, "fixedvolume": True, "maxvolume": max_volume, "minratio": RATIO
        }  # fmt: skip
    options |= {
        "facesout": True, "nobisect": True, "nomergefacet": True, "nomergevertex": True,
        "epsilon": EPSILON, "steinerleft": -1,
    }  # fmt: skip
    mesh, order = _first_that_ends(boundary, options, len(boundary.faces) + expected)

    # vertices of the model in their own order again, new ones after them
    n = len(order)
    place = np.arange(len(mesh["node"]))
    place[:n] = order
    x = np.empty_like(mesh["node"])
    x[place] = mesh["node"]
    cells = place[mesh["elem"].astype(np.int64)]
    if not len(cells) or not np.array_equal(x[:n], boundary.x):
        raise InvariantError("TetGen moved vertices of the model; please report this with it.")

    # 0 marks faces inside of units
    marks = mesh["markers"].astype(np.int64)
    on = np.flatnonzero(marks > 0)
    return x, cells, place[mesh["trifaces"].astype(np.int64)[on]], marks[on] - 1


def _first_that_ends(
    boundary: Boundary, options: dict[str, Any], size: float
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """What TetGen makes of the first order of the vertices that it ends on, and that order."""
    refusal: GeometryError | None = None
    for k in range(N_ORDER):
        order = np.lexsort(boundary.x.T[::-1])  # by easting, then northing, then elevation
        if k:
            order = np.random.default_rng(k).permutation(order)
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        base, each = SHORT if k < N_ORDER - 1 else PATIENCE
        try:
            given = replace(boundary, x=boundary.x[order], faces=rank[boundary.faces])
            angle = {"collinear_ang_tol": STRAIGHT} if k % 2 else {}
            return _run(given, options | angle, base + each * size), order
        except GeometryError as error:
            refusal = error
    assert refusal is not None
    raise refusal


def _run(boundary: Boundary, options: dict[str, Any], patience: float) -> dict[str, np.ndarray]:
    """Run TetGen in a temporary folder, and return its arrays."""
    what = f"TetGen cannot fill the model of {len(boundary.faces)} faces"
    remedy = "Check the model with scene.check(), or move its surfaces slightly."
    with temporary_folder() as folder:
        np.savez(
            Path(folder, "boundary.npz"),
            x=boundary.x,
            faces=boundary.faces.astype(np.int32),
            options=json.dumps(options),
        )
        # the process finds what this one finds, but for the folder of its own file
        code = "import runpy, sys; runpy.run_path(sys.argv[1], run_name='__main__')"
        try:
            done = subprocess.run(
                [sys.executable, "-c", code, str(PROCESS)],
                cwd=folder,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=patience,
                check=False,
            )
        except subprocess.TimeoutExpired:
            other = (
                "Give a larger size, or none" if options["quality"]
                else "Give a size, about twice the distance of the nodes of the horizons"
            )  # fmt: skip
            raise GeometryError(
                f"{what}: it did not end within {patience / 60:.0f} minutes, nor before in other "
                f"orders of the vertices. {other}; or build the model from coarser surfaces."
            ) from None
        except OSError as error:
            raise DependencyError(f"TetGen cannot be started in a process: {error}.") from error

        refused, made = Path(folder, "error.txt"), Path(folder, "mesh.npz")
        if refused.exists():
            reason = refused.read_text(encoding="utf-8").strip().rstrip(".")
            skipped = Path(folder, "_skipped.face")
            if not skipped.exists():
                raise GeometryError(f"{what}: {reason}. {remedy}")

            # after a header, rows of number, corners and mark, which is the row of a face and one
            rows = np.loadtxt(skipped, skiprows=1, ndmin=2)[:, -1].astype(np.int64) - 1
            where = boundary.x[boundary.faces[rows[0]]].mean(axis=0) + boundary.origin
            names = [boundary.surface_names[k] for k in np.unique(boundary.surface[rows]).tolist()]
            raise GeometryError(
                f"{what}: {reason}. It leaves out {counted(len(rows), 'face')} of "
                f"{', '.join(names)}, the first at {place(where)}. {remedy}",
                place=where,
                surfaces=names,
            )
        if done.returncode or not made.exists():
            last = (done.stderr.strip().splitlines() or ["it ended without a message"])[-1]
            raise GeometryError(f"{what}: its process ended ({done.returncode}): {last}. {remedy}")
        with np.load(made) as arrays:
            return {name: arrays[name] for name in arrays.files}
