"""The unit of each tetrahedron, from the faces of the model alone; and whether a mesh conforms.

A face of the model lies between two tetrahedra, or on one where the model ends. The order of its
corners determines which of them is in front. Each other tetrahedron hangs together with one of
these over faces inside its unit. Only whole numbers are compared.
"""

from __future__ import annotations

import numpy as np

from geosurf.errors import InvariantError
from geosurf.kernels.meshes.mesh import join_pairs

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
