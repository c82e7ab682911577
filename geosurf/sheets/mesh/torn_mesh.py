"""Lattice and cut links -> a mesh that is torn there: the virtual node construction.

Each triangle with cut edges falls into fragments: corners joined by uncut edges. One copy of the
triangle is made per fragment; its own corners are real, the others ghosts. Two copies are glued
over a common edge if an end of it is real in both. So the sheet of each wall reaches past the
fault by one ring of ghosts, tips close on shared nodes with nothing to weld, and where faults
meet each sector has ghosts of its own (Molino, Bao & Fedkiw 2004, ACM Trans. Graph. 23, 385-392).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.meshes.parts import glue_copies
from geosurf.kernels.sheets.torn_links import divided_triangles, triangles_beside
from geosurf.model.base import all_of
from geosurf.sheets.faults.cut_edges import EAST, FALLING, NORTH, RISING, Cuts


@dataclass(eq=False)
class Torn:
    """Copies of torn triangles. Vertices below n_node are nodes of the lattice, others ghosts.

    Attributes
    ----------
    triangle : ndarray of int64 (n_copy,)
        The lattice triangle of each copy: 2 * lower left node, plus 1 for its second one.
    corners : ndarray of int64 (n_copy, 3)
        Vertices, in the order of the lattice triangle's corners.
    anchor : ndarray of int64 (n_ghost,)
        A real node on whose sheet the ghost is.
    node_of_ghost : ndarray of int64 (n_ghost,)
    n_node : int
    divided : ndarray of int64
        Lattice triangles that copies stand for; further rings lie over whole ones.
    """

    triangle: np.ndarray
    corners: np.ndarray
    anchor: np.ndarray
    node_of_ghost: np.ndarray
    n_node: int
    divided: np.ndarray

    def node_of(self, vertex: np.ndarray) -> np.ndarray:
        """Lattice node under each vertex."""
        ghost = vertex >= self.n_node
        # Real vertices are their own nodes.
        out = vertex.copy()
        out[ghost] = self.node_of_ghost[vertex[ghost] - self.n_node]
        return out

    def anchored(self, vertex: np.ndarray) -> np.ndarray:
        """Real nodes for vertices: themselves, or the anchors of ghosts."""
        ghost = vertex >= self.n_node
        out = vertex.copy()
        out[ghost] = self.anchor[vertex[ghost] - self.n_node]
        return out


class Triangles:
    """Triangles of the lattice by number: corners, edges and what lies across them."""

    def __init__(self, shape: tuple[int, int], rising: bool, present: np.ndarray) -> None:
        self.n_row, self.n_col = shape
        self.rising, self.present = rising, present

    def corners(self, t: np.ndarray) -> np.ndarray:
        """Nodes (n, 3) of triangles."""
        # triangles 2 a and 2 a + 1 share the cell whose lower left node is a
        a = t // 2

        # corners of the cell a, b, c, d: anticlockwise, a at its lower left
        b, d, c = a + 1, a + self.n_col, a + self.n_col + 1
        half = (t % 2).astype(bool)[:, None]
        if self.rising:
            pair = np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)
        else:
            pair = np.stack([a, b, d], axis=1), np.stack([b, c, d], axis=1)
        return np.where(half, pair[1], pair[0])

    def exists(self, t: np.ndarray) -> np.ndarray:
        """Whether triangles lie in the lattice and have their three nodes."""
        a = t // 2
        row, col = np.divmod(a, self.n_col)
        inside = (t >= 0) & (row < self.n_row - 1) & (col < self.n_col - 1)
        out = inside.copy()
        out[inside] = all_of(self.present[self.corners(t[inside])])
        return out

    def of_cells(self, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangles (n,) of some cells, increasing, that exist, and their nodes (n, 3)."""
        row, col = np.divmod(cells, self.n_col)
        cells = cells[(row < self.n_row - 1) & (col < self.n_col - 1)]
        t = np.stack([2 * cells, 2 * cells + 1], axis=1).ravel()
        corners = self.corners(t)
        there = np.flatnonzero(all_of(self.present[corners]))
        if len(there) == len(t):
            return t, corners
        return t.take(there), corners.take(there, axis=0)

    def first(self) -> np.ndarray:
        """The first triangle that exists, (1,); (0,) where there is none."""
        t = np.arange(2 * self.n_row * self.n_col)
        return t[self.exists(t)][:1]

    def beside(self, node: np.ndarray, kind: np.ndarray) -> np.ndarray:
        """The two triangles (n, 2) of links named as in `Cuts`; they need not exist."""
        # an east link has a triangle of the cell below it, a north link one of the cell west of it;
        # a diagonal lies between the two triangles of its own cell
        row, col = np.divmod(node, self.n_col)
        below, west = 2 * (node - self.n_col), 2 * (node - 1)
        here = 2 * node
        east = np.stack([here, below + 1], axis=1)
        left, right = (1, 0) if self.rising else (0, 1)  # the triangle at that side of a cell
        north = np.stack([here + left, west + right], axis=1)
        diagonal = np.stack([here, here + 1], axis=1)

        # the first row has no cell below, the first column none to the west
        east[row == 0, 1] = -1
        north[col == 0, 1] = -1
        return np.select(
            [(kind == EAST)[:, None], (kind == NORTH)[:, None]], [east, north], diagonal
        )

    def links(self, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Node and kind (n, 3) of the links from each corner to the next."""
        # the step in node numbers names the kind: 1, n_col, n_col + 1, and n_col - 1 for falling
        # ones, which `Cuts` names by the lower left node of their cell, one west of the lower end
        other = np.roll(corners, -1, axis=1)
        low, high = np.minimum(corners, other), np.maximum(corners, other)
        step = high - low
        kind = np.select(
            [step == 1, step == self.n_col, step == self.n_col + 1], [EAST, NORTH, RISING], FALLING
        )
        return np.where(kind == FALLING, low - 1, low), kind


def renumbered(vertices: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Distinct vertices out of 0 .. n - 1, rising, and the row of each; sorts nothing."""
    mark = np.zeros(n, dtype=bool)
    mark[vertices] = True
    used = np.flatnonzero(mark)
    row = np.empty(n, dtype=np.int32)  # as little memory as can be: each page of it costs
    row[used] = np.arange(len(used), dtype=np.int32)
    return used, row[vertices].astype(np.int64)


def tear(cuts: Cuts, triangles: Triangles) -> Torn:
    """Copies of all triangles that cut links divide."""
    # lattice triangles with two cut edges or more: one copy for each fragment
    diagonal = RISING if triangles.rising else FALLING
    mine = cuts.take(np.flatnonzero((cuts.kind < 2) | (cuts.kind == diagonal)))
    cut = distinct(mine.node * 4 + mine.kind)
    lattice = triangles.rising, triangles.present, triangles.n_row, triangles.n_col
    near = distinct(triangles_beside(cut, *lattice))
    triangle, corners, real, across, exists = divided_triangles(near, cut, *lattice)

    # number the ghosts: corners of copies that are glued are one
    n_node, divided = len(triangles.present), distinct(triangle)
    vertex, anchor, node_of_ghost = glue_copies(triangle, corners, real, across, exists, n_node)
    # a tear within one triangle parts nothing: glued to all around it, its copies are one again
    distinct_copies = np.sort(np.unique(vertex, axis=0, return_index=True)[1])
    triangle, vertex = triangle[distinct_copies], vertex[distinct_copies]
    return Torn(triangle, vertex, anchor, node_of_ghost, n_node, divided)


def outer_edges(torn: Torn, triangles: Triangles) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Copy, edge and lattice triangle beyond of all edges with a ghost that end inside the data."""
    tail, head = torn.corners.ravel(), np.roll(torn.corners, -1, axis=1).ravel()

    # an outer edge belongs to one copy, and ends on a ghost
    half = np.flatnonzero((tail >= torn.n_node) | (head >= torn.n_node))
    tail, head = tail[half], head[half]
    key = np.minimum(tail, head) * (torn.n_node + len(torn.anchor)) + np.maximum(tail, head)
    order = np.argsort(key)
    key = key[order]
    new = np.ones(len(key) + 1, dtype=bool)
    new[1:-1] = key[1:] != key[:-1]
    alone = np.sort(half[order[new[:-1] & new[1:]]])
    copy, k = np.divmod(alone, 3)

    # the lattice triangle on the other side: outside the data nothing is missing
    node, kind = triangles.links(torn.node_of(torn.corners[copy].ravel()).reshape(-1, 3))
    row = np.arange(len(copy))
    both = triangles.beside(node[row, k], kind[row, k])
    beyond = np.where(both[:, 0] == torn.triangle[copy], both[:, 1], both[:, 0])
    there = triangles.exists(beyond)
    return copy[there], k[there], beyond[there]


def outer_ghosts(torn: Torn, triangles: Triangles) -> np.ndarray:
    """Ghosts on outer edges, which must lie beyond the faults."""
    copy, k, _ = outer_edges(torn, triangles)
    ends = np.stack([torn.corners[copy, k], torn.corners[copy, (k + 1) % 3]])
    return distinct(ends[ends >= torn.n_node])
