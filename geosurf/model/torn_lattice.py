"""A lattice some triangles of which are gone, with others in their place: that of a torn sheet.

Triangles of the lattice have the keys of a `Lattice`. Those at faults follow them, with keys from
`TornLattice.n_key` on, and ghosts follow the nodes. So what no fault touches stays in runs.
"""

from __future__ import annotations

from dataclasses import fields
from functools import cached_property

import numpy as np

from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.model.base import frozen
from geosurf.model.lattice import OF_NODES, Lattice


class TornLattice(Lattice):
    """
    The nodes of a torn sheet, its ghosts, and the triangles at its faults. Made by `of`.

    Attributes
    ----------
    gone : ndarray of int64, shape (n_gone,)
        Keys of the triangles that faults divide, rising; all of them have their nodes.
    copies : ndarray of int64, shape (n_copy, 3)
        Triangles that stand for them: nodes, row by row, then ghosts.
    ghosts : ndarray of float64, shape (n_ghost, 3)
        World coordinates [m].

    Examples
    --------
    >>> flat = Lattice(np.arange(3.0), np.arange(2.0), np.zeros((2, 3)))
    >>> torn = TornLattice.of(flat, np.array([0]), np.array([[0, 1, 6]]), np.array([[1.0, 1, 5]]))
    >>> torn.n_triangle, torn.keys.tolist(), torn.rows_of_keys(np.array([3, 4])).tolist()
    (4, [1, 2, 3, 4], [2, 3])
    >>> torn.corners_of_keys(np.array([1, 4])).tolist()
    [[0, 4, 3], [0, 1, 6]]
    """

    gone: np.ndarray
    copies: np.ndarray
    ghosts: np.ndarray

    @classmethod
    def of(
        cls, lattice: Lattice, gone: np.ndarray, copies: np.ndarray, ghosts: np.ndarray
    ) -> TornLattice:
        """Return the same nodes, torn; what is known of the nodes is shared."""
        # what does not depend on whether all nodes have triangles
        shared = {*OF_NODES, *(array.name for array in fields(lattice))}
        shared -= {"whole", "extent", "vertex_of_node"}
        made = object.__new__(cls)
        made.__dict__.update({key: lattice.__dict__[key] for key in shared & {*lattice.__dict__}})
        lists = {"gone": gone, "copies": copies, "ghosts": ghosts}
        made.__dict__.update({key: frozen(array, array.dtype) for key, array in lists.items()})
        return made

    @cached_property
    def n_key(self) -> int:
        """Number above all keys of the lattice itself: the key of the first copy."""
        n_row, n_col = self.shape
        return 2 * max(n_row - 1, 0) * max(n_col - 1, 0)

    @property
    def whole(self) -> bool:
        """Return False: keys do not follow each other."""
        return False

    @property
    def map_height(self) -> float:
        """0: copies lie over each other in the map."""
        return 0.0

    @property
    def node_height(self) -> float:
        """A lower bound of the heights in the map of triangles without ghosts [m]; 0: may fold."""
        return self._height_in_map()

    @property
    def has_rising_axes(self) -> bool:
        """False: ghosts are in no column."""
        return False

    @property
    def n_triangle(self) -> int:
        """Number of triangles."""
        return self.survey.n_triangles[self.rising] - len(self.gone) + len(self.copies)

    @property
    def n_present(self) -> int:
        """Number of nodes that exist, and of ghosts."""
        n_node = self.n_node if self.nodes_are_all_there else int(self.present.sum())
        return n_node + len(self.ghosts)

    def corners_in_use(self) -> np.ndarray | None:
        """Corners around the nodes and ghosts in use, float64 (n, 3); None if not known.

        Nodes of triangles that are gone mostly belong to copies; all others have triangles.
        """
        if not self.nodes_are_all_there or min(self.shape) < 2:
            return None
        in_copies = np.zeros(self.n_node + len(self.ghosts), dtype=bool)
        in_copies[self.copies] = True
        if not in_copies[super().corners_of_keys(self.gone)].all():
            return None
        return np.concatenate([self.corners_of_box(), self.ghosts[in_copies[self.n_node :]]])

    @property
    def nodes_are_all_there(self) -> bool:
        """Whether all nodes of the lattice exist."""
        return bool(all(self.survey.numbers))

    @property
    def nodes_lie_apart(self) -> bool:
        """Whether nodes of the lattice differ in the map, so that none of its triangles is flat."""
        return self.node_height > 0.0

    @cached_property
    def node_of_ghost(self) -> np.ndarray | None:
        """The node that each ghost lies over, to the last digit, int64 (n_ghost,); else None."""
        found = nodes_at(self, self.ghosts[:, :2])
        return None if found is None else frozen(found, np.int64)

    @cached_property
    def rows_beside_copies(self) -> np.ndarray:
        """Rows of the triangles that have a node below a copy, and of all copies, rising."""
        n_row, n_col = self.shape
        below = np.zeros(self.n_node + len(self.ghosts), dtype=bool)
        below[self.copies] = True
        if self.node_of_ghost is not None:
            below[self.node_of_ghost[below[self.n_node :]]] = True
        grid = below[: self.n_node].reshape(n_row, n_col)
        cells = grid[:-1, :-1] | grid[:-1, 1:] | grid[1:, :-1] | grid[1:, 1:]
        if self.nodes_are_all_there:
            keys = np.repeat(2 * np.flatnonzero(cells), 2)
            keys[1::2] += 1
            rows = self.rows_of_keys(keys[~is_among(keys, self.gone)])
        else:
            there = np.repeat(cells.ravel(), 2)
            there[self.gone] = False
            rows = np.flatnonzero(there[self.keys[: self.n_whole]])
        copies = self.n_whole + np.arange(len(self.copies))
        return frozen(np.concatenate([rows, copies]), np.int64)

    @cached_property
    def extent(self) -> np.ndarray:
        """South-west and north-east corner around all nodes and ghosts [m], float64 (2, 2)."""
        corners = np.concatenate([self.survey.box.reshape(2, 3)[:, :2], self.ghosts[:, :2]])
        return frozen([corners.min(axis=0), corners.max(axis=0)], np.float64)

    @property
    def keys_of_copies(self) -> np.ndarray:
        """Keys of the copies, rising, int64 (n_copy,)."""
        return self.n_key + np.arange(len(self.copies))

    @cached_property
    def keys(self) -> np.ndarray:
        """Keys of all triangles, rising, int64 (n_triangle,)."""
        there = np.ones(self.n_key, dtype=bool)
        if not all(self.survey.numbers):  # some nodes are absent
            corners = super().corners_of_keys(np.arange(self.n_key))
            there = self.present.ravel()[corners].all(axis=1)
        there[self.gone] = False
        return frozen(np.concatenate([np.flatnonzero(there), self.keys_of_copies]), np.int64)

    @property
    def n_whole(self) -> int:
        """Number of triangles that are those of the lattice: their rows come first."""
        return self.n_triangle - len(self.copies)

    def rows_of_keys(self, keys: np.ndarray) -> np.ndarray:
        """Rows of `build_triangles` for keys of triangles that exist."""
        # where all nodes exist, only those that are gone are missing among the keys
        if self.nodes_are_all_there:
            return keys - np.searchsorted(self.gone, keys)
        return super().rows_of_keys(keys)

    def keys_of_rows(self, rows: np.ndarray) -> np.ndarray:
        """Keys of triangles for rows of `build_triangles`."""
        if self.nodes_are_all_there:
            before = self.gone - np.arange(len(self.gone))  # rows that those would have
            return rows + np.searchsorted(before, rows, side="right")
        return super().keys_of_rows(rows)

    def corners_of_keys(self, keys: np.ndarray) -> np.ndarray:
        """Nodes and ghosts of triangles by key, int64 (n, 3)."""
        is_copy = keys >= self.n_key
        if not is_copy.any():
            return super().corners_of_keys(keys)
        corners = np.empty((len(keys), 3), dtype=np.int64)
        corners[~is_copy] = super().corners_of_keys(keys[~is_copy])
        corners[is_copy] = self.copies[keys[is_copy] - self.n_key]
        return corners

    def places_of_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """World coordinates (n, 3) of nodes, row by row, and of ghosts behind them."""
        is_ghost = nodes >= self.n_node
        if not is_ghost.any():
            return super().places_of_nodes(nodes)
        places = np.empty((*nodes.shape, 3))
        places[~is_ghost] = super().places_of_nodes(nodes[~is_ghost])
        places[is_ghost] = self.ghosts[nodes[is_ghost] - self.n_node]
        return places

    @cached_property
    def node_of_vertex(self) -> np.ndarray:
        """Node or ghost that each vertex is, rising, int64 (n_present,)."""
        if self.nodes_are_all_there:
            return frozen(np.arange(self.n_node + len(self.ghosts)), np.int64)
        ghosts = self.n_node + np.arange(len(self.ghosts))
        return frozen(np.concatenate([np.flatnonzero(self.present), ghosts]), np.int64)

    @cached_property
    def vertex_of_node(self) -> np.ndarray:
        """Vertex of each node, row by row, then of each ghost; -1 where absent."""
        if self.nodes_are_all_there:
            return self.node_of_vertex
        found = np.full(self.n_node + len(self.ghosts), -1, dtype=np.int64)
        found[self.node_of_vertex] = np.arange(len(self.node_of_vertex))
        return frozen(found, np.int64)

    def build_vertices(self) -> np.ndarray:
        """World coordinates (n_vertex, 3) of the nodes that exist, then of the ghosts."""
        own = super().places_of_nodes(self.node_of_vertex[: self.n_present - len(self.ghosts)])
        # + 0.0 turns -0.0 into 0.0, so that equal coordinates have equal bytes
        return np.concatenate([own, self.ghosts]) + 0.0

    def build_triangles(self) -> np.ndarray:
        """Triangles (n_triangle, 3): rows of vertices, in the order of keys."""
        # copies follow the lattice's own
        own = super().corners_of_keys(self.keys[: len(self.keys) - len(self.copies)])
        found = np.concatenate([own, self.copies])
        return found if self.nodes_are_all_there else self.vertex_of_node[found]

    def heights_of_vertices(self) -> np.ndarray:
        """Elevation of each vertex, float64 (n_vertex,)."""
        z = self.elevation.ravel()
        own = z if self.nodes_are_all_there else z[self.present.ravel()]
        return np.concatenate([own, self.ghosts[:, 2]])

    @cached_property
    def gaps(self) -> np.ndarray:
        """Places of the lattice without a triangle, in the form of ``kernels.lattices.strips``."""
        n_row, n_col = self.shape
        absent = self.gone
        if not self.nodes_are_all_there:
            there = np.zeros(self.n_key, dtype=bool)
            there[self.keys[: len(self.keys) - len(self.copies)]] = True
            absent = np.flatnonzero(~there)

        # along a strip, the halves of a cell come in the other order where diagonals rise
        places = np.sort(absent ^ 1) if self.rising else absent
        row, column = np.divmod(places, max(2 * (n_col - 1), 1))
        new = np.ones(len(places) + 1, dtype=bool)
        new[1:-1] = (np.diff(places) > 1) | (column[1:] == 0)
        ends = np.stack([column[new[:-1]], column[new[1:]]], axis=1)
        start = n_row + 2 * np.searchsorted(row[new[:-1]], np.arange(n_row))
        return frozen(np.concatenate([start, ends.ravel()]), np.int64)

    @cached_property
    def beside_gaps(self) -> np.ndarray:
        """Keys of the triangles that share an edge with one that is gone, rising, int64 (n,)."""
        from geosurf.kernels.lattices.strips import keys_across

        # edge by edge: a turned lattice has the same three in another order
        none, edge = np.empty(0, dtype=np.int64), np.tile(np.arange(3), len(self.gone))
        over = keys_across(self.places, none, False, np.repeat(self.gone, 3), edge)
        keys = distinct(over)
        keys = keys[(keys >= 0) & ~is_among(keys, self.gone)]  # below 0: outside
        if not all(self.survey.numbers):
            corners = super().corners_of_keys(keys)
            keys = keys[self.present.ravel()[corners].all(axis=1)]
        return frozen(keys, np.int64)


def nodes_at(lattice: Lattice, places: np.ndarray) -> np.ndarray | None:
    """
    Return the nodes of a regular lattice at some places.

    Parameters
    ----------
    lattice : Lattice
    places : ndarray of float64, shape (n, 2)
        Easting and northing [m].

    Returns
    -------
    ndarray of int64, shape (n,), or None
        Row by row. None if some place is at no node, to the last digit.

    Examples
    --------
    >>> lattice = Lattice(np.array([0.0, 5.0, 10.0]), np.array([0.0, 5.0]), np.zeros((2, 3)))
    >>> nodes_at(lattice, np.array([[10.0, 0.0], [0.0, 5.0]])).tolist()
    [2, 3]
    """
    east, north = lattice.horizontal()
    n_row, n_col = lattice.shape
    if min(n_row, n_col) < 2:
        return None

    # column and row from the steps between corners of the lattice, then exact comparison
    origin = np.array([east[0, 0], north[0, 0]])
    along = np.array([east[0, -1], north[0, -1]]) - origin
    up = np.array([east[-1, 0], north[-1, 0]]) - origin
    steps = np.stack([along / (n_col - 1), up / (n_row - 1)], axis=1)
    if not np.isfinite(steps).all() or np.linalg.det(steps) == 0.0:
        return None
    at = np.rint(np.linalg.solve(steps, (places - origin).T)).astype(np.int64)
    col, row = np.clip(at[0], 0, n_col - 1), np.clip(at[1], 0, n_row - 1)
    if not (np.array_equal(east[row, col], places[:, 0])
            and np.array_equal(north[row, col], places[:, 1])):  # fmt: skip
        return None
    found: np.ndarray = row * n_col + col
    return found
