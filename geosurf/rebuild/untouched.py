"""The triangles of listed surfaces that nothing meets: they stay where the surface has them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.arrangement.search import Contacts
from geosurf.model.torn_lattice import TornLattice
from geosurf.rebuild.equal_vertices import first_of_equals

_NO_KEYS = np.empty(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Others:
    """The triangles of a list that nothing meets, where the list has them.

    Attributes
    ----------
    triangles, taken, number, keys : ndarray
        As `merge_by_face` takes them.
    places : ndarray of float64, shape (n, 3)
        Their points that have no number yet, in the frame of the contacts.
    n : int
        How many these triangles are.
    """

    triangles: np.ndarray
    taken: np.ndarray
    number: np.ndarray
    keys: np.ndarray
    places: np.ndarray
    n: int


NO_OTHERS = Others(
    np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=bool), _NO_KEYS, _NO_KEYS,
    np.empty((0, 3)), 0,
)  # fmt: skip


def beside_gaps(contacts: Contacts, i: int, touched: np.ndarray, met: np.ndarray, n: int) -> Others:
    """The triangles of a torn lattice that are listed although nothing meets them.

    Those at faults, which are in no run, and those next to gaps, so that all of these share edges.
    """
    source, lattice = contacts.surfaces[i], contacts.surfaces[i].lattice
    assert isinstance(lattice, TornLattice)
    copies = lattice.n_key + np.arange(len(lattice.copies))
    keys = np.concatenate([lattice.beside_gaps, copies])
    triangles = lattice.corners_of_keys(keys)

    mine = np.flatnonzero(touched & (contacts.surface_of_face == i))
    taken = np.isin(keys, contacts.key_of_face[mine], assume_unique=True)
    nodes, ids = contacts.nodes[i]
    id_of_node = np.full(len(lattice.vertex_of_node), -1, dtype=np.int64)
    id_of_node[nodes[met[ids]]] = ids[met[ids]]
    new, count = _number_points(triangles, taken, id_of_node, n)
    places = source.places_of_nodes(new) - contacts.origin
    return Others(triangles, taken, id_of_node, keys, places, count)


def untouched(contacts: Contacts, i: int, touched: np.ndarray, met: np.ndarray, n: int) -> Others:
    """The triangles of a list that nothing meets; their new points are numbered from `n` on."""
    source = contacts.surfaces[i]
    nodes, ids = contacts.nodes[i]
    nodes, ids = nodes[met[ids]], ids[met[ids]]

    taken = np.zeros(source.n_triangle, dtype=bool)
    low, high = np.searchsorted(contacts.surface_of_face, [i, i + 1])
    mine = low + np.flatnonzero(touched[low:high])
    taken[source.rows_of_keys(contacts.key_of_face[mine])] = True

    # Vertices that contacts use have ids; the others get new ones, from `n` on.
    triangles, vertices = source.triangles, nodes
    if source.lattice is not None:
        vertices = source.lattice.vertex_of_node.ravel()[nodes]
    first = first_of_equals(source)
    if first is not None:
        triangles, vertices = first[triangles], first[vertices]

    id_of_vertex = np.full(source.n_vertex, -1, dtype=np.int64)
    id_of_vertex[vertices] = ids
    new, count = _number_points(triangles, taken, id_of_vertex, n)
    keys = _NO_KEYS
    if source.lattice is not None:
        keys = source.lattice.keys_of_rows(np.arange(len(triangles)))
    places = source.vertices.take(new, axis=0) - contacts.origin
    return Others(triangles, taken, id_of_vertex, keys, places, count)


def _number_points(
    t: np.ndarray, taken: np.ndarray, number: np.ndarray, first: int
) -> tuple[np.ndarray, int]:
    """Number the points of the triangles that are not taken, and count these triangles.

    `number` has the number of each point, or -1: these points get numbers from `first` on, in
    their order, and come back. They are written to `number`, too.
    """
    rows = np.flatnonzero(~taken)
    new = np.zeros(len(number), dtype=bool)
    new[t[rows]] = True
    points = np.flatnonzero(new & (number < 0))
    number[points] = first + np.arange(len(points))
    return points, len(rows)
