"""Surfaces as the search takes them: with trees of boxes, and checked, once for each surface.

A lattice is never made a list: the leaves of its tree are blocks of cells. Trees hold world
coordinates, so that they serve every frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.conventions import place
from geosurf.errors import InputError, SurfaceError
from geosurf.kernels.exact.predicates import MAX_BITS, MAX_COORDINATE, flat_triangles, frame_of
from geosurf.kernels.lattices.lattice_corners import LARGEST, SMALLEST, build_list_tree, survey_list
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.search.tree import N_COL, N_PLACE, N_ROW
from geosurf.model import Lattice, TriSurface
from geosurf.model.expected import listed
from geosurf.model.torn_lattice import TornLattice

# ---- trees ----------------------------------------


_NO_TRIANGLES = np.empty((0, 3), dtype=np.int64)
_NO_ORDER = np.empty(0, dtype=np.int64)
_TREE = "_tree"  # where a surface keeps its tree


@dataclass(frozen=True)
class Tree:
    """Boxes over a surface, and where its coordinates are; see `geosurf.kernels.search.tree`.

    Attributes
    ----------
    coordinates, places, triangles, order, nodes, levels : ndarray
        As kernels take them.
    doubted : ndarray of int64, or None
        Rows of triangles that may be flat; None: not known.
    smallest, largest : float
        Sizes of numbers: the smallest that is not 0, 0 if it is not known; and the largest.
    """

    coordinates: tuple[np.ndarray, np.ndarray, np.ndarray]
    places: np.ndarray
    triangles: np.ndarray
    order: np.ndarray
    nodes: np.ndarray
    levels: np.ndarray
    doubted: np.ndarray | None = None
    smallest: float = 0.0
    largest: float = np.inf

    @property
    def bounds(self) -> np.ndarray:
        """Box around all that the tree holds: lower, then upper corner."""
        return self.nodes[-1]

    def arguments(self) -> tuple:
        """The tree as kernels take it."""
        return (
            *self.coordinates, self.places, self.triangles, self.order, self.nodes, self.levels
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class TornTree:
    """Trees over a torn sheet: of its lattice, and of the triangles at its faults.

    Rows of the sheet are found by two searches. Triangles of the lattice that are gone are left
    out again, and no list of all triangles is sorted.

    Attributes
    ----------
    torn : TornLattice
    lattice, copies : Tree
        Over all triangles of the lattice, also those that are gone; over those at faults.
    """

    torn: TornLattice
    lattice: Tree
    copies: Tree

    @property
    def nodes(self) -> np.ndarray:
        """Boxes of the lattice: none where it is empty."""
        return self.lattice.nodes

    @cached_property
    def bounds(self) -> np.ndarray:
        """Box around all that the trees hold: lower, then upper corner."""
        boxes = np.array([tree.bounds for tree in (self.lattice, self.copies) if len(tree.nodes)])
        return np.concatenate([boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)])

    @property
    def doubted(self) -> np.ndarray:
        """Rows of triangles that may be flat: at faults only."""
        assert self.copies.doubted is not None  # as of any list
        return self.rows_of_copies(self.copies.doubted)[0]

    @property
    def smallest(self) -> float:
        """Smallest size of a number, not 0, at faults."""
        return self.copies.smallest

    @property
    def largest(self) -> float:
        """Largest size of a number."""
        # no numbers have no largest one
        at_faults = self.copies.largest if len(self.torn.copies) else 0.0
        return max(self.lattice.largest, at_faults)

    def rows_of_lattice(self, keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the sheet's triangles for keys of the lattice, and which of them exist."""
        torn = self.torn
        if torn.nodes_are_all_there:
            return torn.rows_of_keys(keys), ~is_among(keys, torn.gone)
        rows = np.searchsorted(torn.keys[: torn.n_whole], keys)
        exists = rows < torn.n_whole
        exists[exists] = torn.keys[rows[exists]] == keys[exists]
        return rows, exists

    def rows_of_copies(self, keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same for keys of triangles at faults."""
        return keys + self.torn.n_whole, np.ones(len(keys), dtype=bool)


AnyTree = Tree | TornTree


def tree_of(surface: TriSurface) -> AnyTree:
    """The tree of a surface; of a torn sheet over a map, of its parts. Remembered on it."""
    kept: AnyTree | None = surface.__dict__.get(_TREE)
    if kept is None:
        if surface.lattice is not None:
            kept = _tree_of_lattice(surface.lattice)
        elif surface.torn is None or not surface.torn.nodes_lie_apart:
            kept = tree_of_list(surface.vertices, surface.triangles)
        else:
            kept = _tree_of_torn(surface.torn)
        surface.__dict__[_TREE] = kept
    return kept


def tree_of_list(vertices: np.ndarray, triangles: np.ndarray) -> Tree:
    """A tree over listed triangles, in the frame of their vertices."""
    boxes, codes, doubted, sizes = survey_list(vertices, triangles)
    order, nodes, levels = build_list_tree(boxes, codes)

    # The list is one row of nodes in the layout of a lattice: x, y, z are interleaved, with stride
    # 3.
    places = np.zeros(N_PLACE, dtype=np.int64)
    places[:9] = (0, 0, 3, 1, 0, 3, 2, 0, 3)
    places[[N_ROW, N_COL]] = 1, len(vertices)
    flat = vertices.reshape(-1)
    return Tree(
        (flat, flat, flat), places, triangles, order, nodes, levels,
        doubted, float(sizes[SMALLEST]), float(sizes[LARGEST]),
    )  # fmt: skip


def _tree_of_lattice(lattice: Lattice) -> Tree:
    """The tree over a lattice, which its survey has made."""
    survey = lattice.survey
    return Tree(
        lattice.coordinates, lattice.places, _NO_TRIANGLES, _NO_ORDER, survey.nodes, survey.levels,
        largest=float(np.abs(survey.box).max()),
    )  # fmt: skip


def _tree_of_torn(torn: TornLattice) -> TornTree:
    """The trees of a torn sheet; its triangles at faults are a list of their own."""
    nodes = distinct(torn.copies)
    copies = tree_of_list(torn.places_of_nodes(nodes), np.searchsorted(nodes, torn.copies))
    return TornTree(torn, _tree_of_lattice(torn), copies)


# ---- checks ----------------------------------------
# What exact geometry has no answer for is refused before the search.


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
            _check_triangles(surface)
            surface.checked = True
    return surfaces


def _check_triangles(surface: TriSurface) -> None:
    """Refuse what exact geometry has no answer for."""
    if surface.n_triangle == 0:
        raise SurfaceError(f"surface {surface.name!r} has no triangles; leave it out.")
    tree = tree_of(surface)
    if tree.largest > MAX_COORDINATE:
        raise SurfaceError(
            f"surface {surface.name!r} has a coordinate of {tree.largest:g} m; the limit is "
            f"{MAX_COORDINATE:g} m. Replace undefined values by NaN."
        )

    # No triangle of a lattice over the map stands upright, so that none is flat; whether digits
    # suffice is seen where they are used.
    if surface.lattice is not None and surface.lattice.is_graph:
        return

    # No triangle is nearly flat, and the digits of all numbers fit: nothing is left to decide.
    doubted = tree.doubted
    if doubted is not None and len(doubted) == 0 and tree.largest < tree.smallest * _FEW_DIGITS:
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
