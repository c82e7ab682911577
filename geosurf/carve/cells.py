"""Find the cells of space between surfaces, and the faces that separate them.

Cells come from topology: sides of parts of surfaces are united across edges, in exact radial order
where more than two triangles meet (`sides`). A free edge unites the two sides of its own part, so a
fault that dies inside a cell does not split it. Pieces that touch nothing else (a fault that
floats, an inner shell) are put into the cell that holds them (`floating`).

All that one surface has between the same two cells is one face: a model of a million triangles has
some hundred faces, and all that follows (zones, blocks, volumes) is decided by those.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.carve import measures
from geosurf.carve.half_faces import Parts, find_parts, joined_sides
from geosurf.carve.outside import (
    box_of,
    outside_of_box,
    outside_of_shells,
    owned_by_walls,
    walls_are_a_box,
)
from geosurf.carve.rays import NO_HIT, Rays
from geosurf.carve.seams import Parents
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.meshes.numbering import number_keys
from geosurf.model import Patches
from geosurf.model.pieces import Pieces, same_turn

# surfaces that own a part, and how each is turned: 1 as the part's triangles are, -1 against them
Owners = tuple[tuple[int, int], ...]
OUTSIDE = 0


@dataclass(frozen=True)
class Cells:
    """Cells of the space inside the model box, and what separates them.

    Attributes
    ----------
    surface_of : ndarray of int64, shape (n,)
        Surface of each face.
    also : dict of int to tuple of (int, int)
        Further surfaces that own a face, where surfaces coincide, and how each is turned there:
        1 if its front is that of the face, -1 if it is the back. A surface that is folded onto
        itself may be among its own.
    cell_of_side : ndarray of int64, shape (n, 2)
        Cell in front of and behind each face; 0 is the space outside.
    n_cell : int
        Cells are numbered 1 to n_cell.
    patches : Patches
    pieces : Pieces
    face_of_element : ndarray of int64, shape (n_element,)
        Face that each element of the pieces (triangle, then run) is a part of; -1 for what is
        outside of the box, and for all but the first of the triangles with the same corners.
    """

    surface_of: np.ndarray
    also: dict[int, tuple[tuple[int, int], ...]]
    cell_of_side: np.ndarray
    n_cell: int
    patches: Patches
    pieces: Pieces
    face_of_element: np.ndarray

    @cached_property
    def own(self) -> dict[int, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Faces of each surface as far as they have been found: see `geosurf.carve.zones`."""
        return {}

    @cached_property
    def below(self) -> np.ndarray:
        """Volume below each face, float64 (n, 3): see `geosurf.carve.measures`."""
        return measures.below(self.pieces, self.face_of_element, self._all, self.level)

    @cached_property
    def level(self) -> float:
        """Local elevation that `below` refers to [m]: that of the middle of the box."""
        return float(box_of(self.patches)[:, 2].mean())

    @cached_property
    def n_triangles(self) -> np.ndarray:
        """Number of triangles of each face, int64 (n,)."""
        lengths = [np.ones(len(self.pieces.triangles), dtype=np.int64)]
        lengths += [one.runs[:, 2] - one.runs[:, 1] + 1 for one in self.pieces.strips if one]
        of = self.face_of_element
        n = np.concatenate(lengths)[of >= 0]
        found = np.bincount(of[of >= 0], weights=n, minlength=len(self.surface_of))
        return found.astype(np.int64)

    @cached_property
    def heights(self) -> np.ndarray:
        """Lowest and highest local elevation of each face, float64 (n, 2) [m]."""
        return measures.heights(self.pieces, self.face_of_element, self._all)

    def beside_level(self, wanted: np.ndarray, level: float) -> np.ndarray:
        """Volume of some faces (bool) above a level and below it: see `carve.measures`."""
        found = measures.beside_level(
            self.pieces, self.face_of_element, wanted, level, self.surface_of
        )
        found[~wanted] = np.nan
        return found

    @property
    def _all(self) -> np.ndarray:
        """All faces, as `measures` takes them."""
        return np.ones(len(self.surface_of), dtype=bool)

    @cached_property
    def extent(self) -> np.ndarray:
        """Area, bounds and map areas of each face, float64 (n, 12): see `carve.measures`."""
        return measures.extent(self.pieces, self.face_of_element, self._all)

    def extent_of(self, faces: np.ndarray) -> np.ndarray:
        """Rows of `extent` for some faces: only these are measured if none has been before."""
        if "extent" not in self.__dict__:
            wanted = np.zeros(len(self.surface_of), dtype=bool)
            wanted[faces] = True
            found: np.ndarray = measures.extent(self.pieces, self.face_of_element, wanted)[faces]
            return found
        return self.extent[faces]

    @property
    def flat(self) -> np.ndarray:
        """Twice the area of each face in the map, below 0 where its front looks down [m2]."""
        return self.below[:, measures.FLAT]

    def beside(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Face of some triangles, rows of `Patches.triangles`, or -1; cells on both sides (n, 2).

        What lies on a wall has one cell; what lies outside has none.
        """
        element = self.pieces.expanded.element[rows]

        # of triangles with the same corners only the first has a face
        twin = self.pieces.twin
        listed = element < len(twin)
        element[listed] = twin[element[listed]]
        face = self.face_of_element[element]
        return face, np.where(face[:, None] < 0, OUTSIDE, self.cell_of_side[face])

    @cached_property
    def in_full(self) -> FullCells:
        """The same with a face for every triangle."""
        full = self.pieces.expanded

        # every triangle takes over the face of the element that it was a part of
        face = self.face_of_element[full.element]
        row = np.flatnonzero(face >= 0)
        face = face[row]

        # faces that several surfaces own, as many times as they have triangles
        several = np.flatnonzero(np.isin(face, list(self.also)))
        also = {
            i: self.also[k] for i, k in zip(several.tolist(), face[several].tolist(), strict=True)
        }
        return FullCells(
            self.surface_of[face], also, self.cell_of_side[face], self.n_cell, self.patches,
            self.pieces, self.face_of_element, full.triangles[row], row, full.local,
        )  # fmt: skip


@dataclass(frozen=True)
class FullCells(Cells):
    """Cells with a face for every triangle.

    Attributes
    ----------
    triangles : ndarray of int64, shape (n, 3)
        Rows of `x`.
    row : ndarray of int64, shape (n,)
        Rows of `Patches.triangles`.
    x : ndarray of float64, shape (n_vertex, 3)
        Local coordinates.
    """

    triangles: np.ndarray
    row: np.ndarray
    x: np.ndarray

    @cached_property
    def flat(self) -> np.ndarray:
        """Twice the area of each triangle in the map, below 0 where its front looks down [m2]."""
        a, b, c = (self.x[self.triangles[:, k]] for k in range(3))
        return np.cross(b - a, c - a)[:, 2]

    @property
    def in_full(self) -> FullCells:
        """These cells."""
        return self


def find_cells(patches: Patches) -> Cells:
    """Find the cells inside the model box.

    Parameters
    ----------
    patches : Patches

    Raises
    ------
    GeometryError
        If there are no walls.
    OpenUnitError
        If the walls leave the box open.
    InvariantError
        If two different triangles lie in one half-plane of an edge.
    """
    bounds = box_of(patches)
    in_box = walls_are_a_box(patches, bounds)
    pieces, parts, sides, parents, owners, owner = _seen(patches, bounds)
    is_wall = owned_by_walls(patches, owners)[owner]

    # which sides of parts look out of the model: read off the faces of a plain box, found by
    # rays and shells for other walls
    if in_box:
        # all that a wall owns are triangles, and parts with triangles come first
        with_triangle = parts.first[: np.searchsorted(parts.first, len(pieces.triangles))]
        outside = outside_of_box(
            patches, is_wall, owners, owner, sides, parents[with_triangle],
            pieces.x[pieces.triangles[with_triangle]],
        )  # fmt: skip
    else:
        element = np.flatnonzero(parts.of_element >= 0)
        core = element[: np.searchsorted(element, len(pieces.triangles))]
        part = parts.of_element[element]
        outside = outside_of_shells(
            patches, is_wall[part], sides[part], pieces.x, pieces.triangles[core]
        )

    # sides that see each other are one cell; parts with the same owners and cells are one face
    cell, n_cell = _numbered(sides, outside)
    keys = (owner * (n_cell + 1) + cell[:, 0]) * (n_cell + 1) + cell[:, 1]
    found, face = number_keys(keys)
    found, behind = np.divmod(found, n_cell + 1)
    found, front = np.divmod(found, n_cell + 1)
    face_of_element = np.append(face, -1)[parts.of_element]

    # the first owner names the face, the others are listed with how they are turned on it
    first = np.array([of[0][0] for of in owners], dtype=np.int64)
    also = {i: owners[k][1:] for i, k in enumerate(found.tolist()) if len(owners[k]) > 1}
    between = np.stack([front, behind], axis=1)
    return Cells(first[found], also, between, n_cell, patches, pieces, face_of_element)


def _seen(
    patches: Patches, bounds: np.ndarray
) -> tuple[Pieces, Parts, np.ndarray, Parents, list[Owners], np.ndarray]:
    """Pieces, their parts, what these see (n_part, 2), input triangles; sets of surfaces, and the
    one that owns each part.
    """
    pieces = patches.pieces
    while True:
        parts = find_parts(pieces, bounds)
        sides, piece, parents = joined_sides(patches, pieces, parts)
        owners, owner = _owners(pieces, parts)
        fixed = _outermost(pieces, parts, piece, owned_by_walls(patches, owners)[owner])
        floats = not np.isin(piece, fixed).all()
        if not _asks_triangles(pieces, floats):
            break
        pieces = patches.changed().pieces

    # pieces that touch nothing: a ray from each finds the cell that it floats in
    if floats:
        element = np.flatnonzero(parts.of_element >= 0)
        part = parts.of_element[element]
        found = place_floating(
            pieces.x, pieces.triangles[element], piece[part], fixed, sides[part].ravel()
        )
        sides = found.reshape(-1, 2)[np.searchsorted(element, parts.first)]
    return pieces, parts, sides, parents, owners, owner


def _outermost(pieces: Pieces, parts: Parts, piece: np.ndarray, is_wall: np.ndarray) -> np.ndarray:
    """The piece of walls that no other one can be around, as their array (1,)."""
    found = distinct(piece[is_wall])
    if len(found) > 1:  # walls of several shells: the one that reaches highest
        # of the walls' triangles the highest decides: no shell around it can be lower
        part = parts.of_element[: len(pieces.triangles)]
        rows = np.flatnonzero(part >= 0)
        rows = rows[is_wall[part[rows]]]
        top = pieces.x[pieces.triangles[rows], 2].max(axis=1)
        found = piece[part[rows[top.argmax()]]][None]
    return found


def _asks_triangles(pieces: Pieces, floats: bool) -> bool:
    """Whether there are runs where triangles are needed: for rays at what floats, in walls."""
    return any(
        strips is not None and (floats or source.role == "wall")
        for source, strips in zip(pieces.sources, pieces.strips, strict=True)
    )


def _owners(pieces: Pieces, parts: Parts) -> tuple[list[Owners], np.ndarray]:
    """Sets of surfaces with how they are turned, the first of each being that of the triangles,
    and the set that owns each part.

    Where surfaces coincide, each triangle is a part: all edges have more than two triangles.
    """
    owners: list[Owners] = [((i, 1),) for i in range(len(pieces.sources))]
    owner = parts.surface.copy()
    # triangles with the same corners as an earlier one, which stands for them all
    others, first = pieces.coinciding
    at = parts.of_element[first]
    others, first, at = others[at >= 0], first[at >= 0], at[at >= 0]
    alike = same_turn(pieces.triangles[others], pieces.triangles[first])
    turned = zip(pieces.surface[others].tolist(), np.where(alike, 1, -1).tolist(), strict=True)

    # add their surfaces to the owners of that one, each once and as it is turned
    listed: dict[int, Owners] = {}
    for i, one in zip(at.tolist(), turned, strict=True):
        of = listed.get(i, owners[owner[i]])
        listed[i] = of if one in of else (*of, one)
    number = {of: k for k, of in enumerate(owners)}
    for i, of in listed.items():
        owner[i] = number.setdefault(of, len(number))
    return list(number), owner


def _numbered(sides: np.ndarray, outside: np.ndarray) -> tuple[np.ndarray, int]:
    """Cells by their lowest side, from 1; what is outside has 0. And how many cells."""
    # each cell is known by its lowest side: counting those gives the numbers in one pass
    mark = np.zeros(2 * len(sides), dtype=bool)
    mark[sides] = True
    mark[outside] = False
    number = np.cumsum(mark)
    number[~mark] = OUTSIDE
    return number[sides], int(mark.sum())


# ---- locate pieces of surfaces that touch nothing else: a ray finds the cell around each piece ---
#
# A ray that meets nothing more has left the model: its piece lies beyond the walls, as a fault in
# a corner of the bounds that the area of interest does not reach. It is put into the space
# outside.


def place_floating(
    x: np.ndarray, t: np.ndarray, piece: np.ndarray, fixed: np.ndarray, shell: np.ndarray
) -> np.ndarray:
    """Unite the outer shell of each floating piece with the cell, or the outside, that holds it.

    Parameters
    ----------
    x, t : ndarray
        Points and triangles.
    piece : ndarray of int64, shape (n_triangle,)
        Connected piece of each triangle.
    fixed : ndarray of int64
        Pieces that do not float: those of the walls, one at least.
    shell : ndarray of int64, shape (2 * n_triangle,)
        Shell of each side of each triangle.

    Returns
    -------
    ndarray of int64, shape (2 * n_triangle,)

    Raises
    ------
    InvariantError
        If no ray passes through a piece, which has no area then.

    Notes
    -----
    One ray for each piece, and one more for each group of pieces that see each other only: all
    others are placed by what holds those that they see.

    Examples
    --------
    A tetrahedron as the wall, a triangle in it and one next to it, below nothing:

    >>> x = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9], [1, 1, 1], [2, 1, 1], [1, 2, 1],
    ...               [8, 8, 1], [9, 8, 1], [8, 9, 1]], dtype=float)
    >>> t = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [4, 5, 6], [7, 8, 9]])
    >>> outer, inner = 0, 1  # shells of the wall: normals point out
    >>> shell = np.array([outer, inner] * 4 + [8, 8, 10, 10])
    >>> piece = np.array([0, 0, 0, 0, 4, 5])
    >>> place_floating(x, t, piece, np.array([0]), shell)[8:].tolist()
    [1, 1, 0, 0]
    """
    floating, first = np.unique(piece, return_index=True)
    in_walls = np.isin(floating, fixed)
    wall, floating, first = first[in_walls][:1], floating[~in_walls], first[~in_walls]
    if len(floating) == 0:
        return shell.copy()

    # one ray from each piece: the side where it leaves the piece, and the side that it meets next
    rays = Rays(x, t)
    outer, holding = rays.shoot(first, piece).T
    label = shell[outer]
    # the label of each label once they are united, and whether others than outer sides have it
    parent = np.arange(int(shell.max()) + 1)
    of_others = np.zeros(len(parent), dtype=bool)
    of_others[shell[_others(piece, shell, floating, label)]] = True
    start, outside = label, -1
    while True:
        beyond = holding == NO_HIT
        if beyond.any() and outside < 0:
            # the topmost side of the walls sees the outside as well
            outside = int(shell[rays.shoot(wall, np.where(np.isin(piece, fixed), -1, piece))[0, 0]])
        held = np.where(beyond, outside, shell[holding])
        for one, holder in zip(start.tolist(), held.tolist(), strict=True):
            one, holder = _root(parent, one), _root(parent, holder)
            if one != holder:
                parent[one] = holder
                of_others[holder] |= of_others[one]
        root = _roots(parent)
        # pieces that float side by side may see each other only: ask beyond all of them
        # pieces whose shells only see each other are one group; the next rays start from its
        # members and pass through all of it
        alone, member = np.unique(root[label], return_index=True)
        member = member[~of_others[alone]]
        if len(member) == 0:
            return root[shell]
        group = piece.copy()
        at = np.minimum(np.searchsorted(floating, piece), len(floating) - 1)
        floats = floating[at] == piece
        group[floats] = 1 + piece.max() + root[label[at[floats]]]
        start, holding = label[member], rays.shoot(first[member], group)[:, 1]


def _others(
    piece: np.ndarray, shell: np.ndarray, floating: np.ndarray, label: np.ndarray
) -> np.ndarray:
    """Sides that are not outer sides of floating pieces."""
    at = np.minimum(np.searchsorted(floating, piece), len(floating) - 1)
    floats = floating[at] == piece
    outer = np.repeat(floats, 2) & (shell == np.repeat(label[at], 2))
    others: np.ndarray = np.flatnonzero(~outer)
    return others


def _root(parent: np.ndarray, one: int) -> int:
    """Where a label leads, halving the way."""
    while parent[one] != one:
        # path halving: later walks are short
        parent[one] = parent[parent[one]]
        one = int(parent[one])
    return one


def _roots(parent: np.ndarray) -> np.ndarray:
    """Where each label leads."""
    while True:
        # pointer jumping, all rows at once, until each points to its root
        onward = parent[parent]
        if np.array_equal(onward, parent):
            return onward
        parent = onward
