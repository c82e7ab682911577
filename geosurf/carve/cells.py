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

from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.carve import measures
from geosurf.carve.outside import NO_HIT, Rays, box_of, outside_of_walls, rise_of, walls_among
from geosurf.conventions import counted, place
from geosurf.errors import InvariantError, SurfaceError
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.lattices.strips import RIM, lowest_keys
from geosurf.kernels.meshes.mesh import join_pairs, number_keys, weld
from geosurf.kernels.meshes.parts import mark_around, open_edges, parts_of
from geosurf.kernels.meshes.seams import DONE, NEEDS_EXACT, join_seams, sort_seams
from geosurf.model import Patches, TriSurface
from geosurf.model.pieces import Pieces, corners_of, same_turn

# ---- seams ----------------------------------------
# Edges at which parts of surfaces end, and the order of the triangles around them, in threads.
#
# Results are the same for any number of threads: each has a range of edges.


# least work of a thread, a millisecond each, which is ten times what a thread costs
_TRIANGLES, _EDGES, _PARENTS = 20_000, 5_000, 20_000


def edges_at(
    triangles: np.ndarray, ring: np.ndarray, link: np.ndarray, part: np.ndarray
) -> np.ndarray:
    """Find all edges that are not inside a part.

    Parameters
    ----------
    triangles, ring, link : ndarray of int64
        As `Pieces` has them.
    part : ndarray of int64, shape (n_element,)
        Part of each triangle and run, or -1.

    Returns
    -------
    ndarray of int64, shape (n_edge,)
        First half-edge of each.
    """
    of = triangles, ring, link, part
    rows = in_ranges(len(ring), 3 * _TRIANGLES)
    return np.concatenate(map_threads(open_edges, [(*of, *row) for row in rows]))


def sorted_seams(
    patches: Patches, pieces: Pieces, part: np.ndarray, open_at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Put the triangles around some edges in order.

    Parameters
    ----------
    patches : Patches
    pieces : Pieces
    part : ndarray of int64
        As for `edges_at`.
    open_at : ndarray of int64, shape (n_edge,)
        A half-edge of each edge.

    Returns
    -------
    start : ndarray of int64, shape (n_edge + 1,)
        First place of each edge in `seams`, and the end.
    seams : ndarray of int64
        See `geosurf.kernels.meshes.seams`.

    Raises
    ------
    SurfaceError
        If a surface has triangles twice.
    InvariantError
        If two different triangles lie in one half-plane of an edge.
    """
    edges = [open_at[i:j] for i, j in in_ranges(len(open_at), _EDGES)]
    wanted = np.zeros(len(pieces.triangles), dtype=bool)
    counts = map_threads(
        mark_around, [(pieces.ring, part_of_edges, wanted) for part_of_edges in edges]
    )
    parent, px = parents_of(pieces, wanted)
    pt = np.arange(len(px)).reshape(-1, 3)

    def sort(part_of_edges: np.ndarray, n_around: int) -> tuple[int, np.ndarray, np.ndarray]:
        """What `sort_seams` finds of some edges, and what it writes."""
        start, seams = (
            np.empty(len(part_of_edges) + 1, dtype=np.int64),
            np.empty(n_around, dtype=np.int64),
        )
        # floats decide nearly always; the exact frame is made when they first cannot
        m = w = np.empty(0, dtype=np.int64)
        while True:
            sorted_parts = sort_seams(
                pieces.x, pieces.triangles, pieces.ring, part_of_edges, part,
                parent, px, pt, m, w, start, seams,
            )  # fmt: skip
            if sorted_parts != NEEDS_EXACT:
                return sorted_parts, start, seams
            m, w = frame_of(px)

    sorted_parts = map_threads(sort, list(zip(edges, counts, strict=True)))
    for done, _, _ in sorted_parts:
        if done != DONE:
            name = patches.names[pieces.surface[done // 3]]
            corner = pieces.triangles[done // 3, done % 3]
            where = place(pieces.x[corner] + patches.origin)
            source = patches.sources[pieces.surface[done // 3]]
            t = np.sort(weld(source.vertices)[0][source.triangles], axis=1)
            if (n_again := len(t) - len(np.unique(t, axis=0))) > 0:
                raise SurfaceError(
                    f"surface {name!r} has {counted(n_again, 'triangle')} twice, one of them near "
                    f"{where}. Leave one of each two out.",
                    surfaces=[name],
                )
            raise InvariantError(
                f"two triangles of surface {name!r} and another lie in one half-plane at {where}; "
                "please report this with the surfaces."
            )

    # one after the other
    ends = np.cumsum([0, *(start[-1] for _, start, _ in sorted_parts)])
    starts = [start[:-1] + end for (_, start, _), end in zip(sorted_parts, ends, strict=False)]
    seams = np.concatenate([seams[: start[-1]] for _, start, seams in sorted_parts])
    return np.concatenate([*starts, ends[-1:]]), seams


def parents_of(pieces: Pieces, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the input triangles of the triangles that are wanted: a few around curves.

    The number of that of each triangle, -1 for others, and local corners (3 n, 3), one triangle
    after the other.
    """
    surface, key = pieces.surface, pieces.key

    # triangles of one input triangle follow each other
    rows = np.flatnonzero(wanted)
    is_new = np.ones(len(rows), dtype=bool)
    is_new[1:] = (key[rows[1:]] != key[rows[:-1]]) | (surface[rows[1:]] != surface[rows[:-1]])
    first, number = rows[is_new], np.full(len(key), -1, dtype=np.int64)
    number[rows] = np.cumsum(is_new) - 1
    corners = np.empty((len(first), 3, 3))
    cut = np.searchsorted(surface[first], np.arange(len(pieces.sources) + 1))

    def write(source: TriSurface, low: int, high: int) -> None:
        """Write the corners of the triangles of one surface."""
        corners[low:high] = corners_of(source, key[first[low:high]], pieces.origin)

    parts = list(zip(pieces.sources, cut[:-1].tolist(), cut[1:].tolist(), strict=True))
    map_threads(write, parts, worth=len(first) > _PARENTS)
    return number, corners.reshape(-1, 3)


# ---- half faces ----------------------------------------
# Join sides of triangles that face the same cell across an edge.
#
# An element is a triangle, or a run of triangles that no curve touches. A part is what hangs
# together over edges inside of one surface, facing one way, so that all of it sees the same: part
# p sees 2 p in front of it, where normals point, and 2 p + 1 behind.


_SEAMS = 20_000  # edges of a thread, at least


@dataclass(frozen=True, eq=False)
class Parts:
    """Parts inside the model box.

    Attributes
    ----------
    of_element : ndarray of int64, shape (n_element,)
        Part of each triangle and run; -1 outside of the box, and for all but the first of the
        triangles with the same corners.
    first : ndarray of int64, shape (n_part,)
        First element of each; rising, so that parts with triangles come before those without.
    surface : ndarray of int64, shape (n_part,)
        Surface that each is of.
    """

    of_element: np.ndarray
    first: np.ndarray
    surface: np.ndarray


def find_parts(pieces: Pieces, bounds: np.ndarray) -> Parts:
    """Find the parts inside bounds (2, 3), local.

    The walls cut at the sides of the box: a run lies on one side of each, as any of its triangles.
    """
    part, first = parts_of(
        pieces.x, pieces.triangles, pieces.surface, pieces.ring, pieces.link, pieces.twin,
        int(pieces.first_run[-1]), _pairs(pieces), bounds,
    )  # fmt: skip

    # one corner triple for each part decides: walls cut all surfaces at the box
    surface = _surface_of(pieces, first)
    low, high = bounds
    corners = _corners(pieces, first, surface)
    inside = ((corners >= low) & (corners <= high)).all(axis=(1, 2))

    # rank among the parts inside, -1 for the others; the last entry serves part -1
    number = np.append(np.where(inside, np.cumsum(inside) - 1, -1), -1)
    return Parts(number[part], first[inside], surface[inside])


def _pairs(pieces: Pieces) -> np.ndarray:
    """Runs that share an edge, as elements."""
    n_core = len(pieces.triangles)
    pairs = [np.empty((0, 2), dtype=np.int64)]
    for first, strips in zip(pieces.first_run, pieces.strips, strict=False):
        if strips is not None:
            pairs.append(strips.joined + (n_core + first))
    return np.concatenate(pairs)


def _surface_of(pieces: Pieces, elements: np.ndarray) -> np.ndarray:
    """Surface of some elements, which rise."""
    n_core = len(pieces.triangles)
    n = np.searchsorted(elements, n_core)

    # `first_run` rises, so that searchsorted finds the surface of a run
    of_run = np.searchsorted(pieces.first_run, elements[n:] - n_core, side="right") - 1
    return np.concatenate([pieces.surface[elements[:n]], of_run])


def _corners(pieces: Pieces, elements: np.ndarray, surface: np.ndarray) -> np.ndarray:
    """Corners (n, 3, 3) of a triangle of each of some elements, which rise; local."""
    n_core = len(pieces.triangles)
    n = np.searchsorted(elements, n_core)
    corners = [pieces.x[pieces.triangles[elements[:n]]]]
    for i in distinct(surface[n:]).tolist():
        source, strips = pieces.sources[i], pieces.strips[i]

        # runs within their own surface
        rows = elements[n:][surface[n:] == i] - n_core - pieces.first_run[i]
        keys = lowest_keys(strips.places, strips.runs[rows])
        corners.append(corners_of(source, keys, pieces.origin))
    return np.concatenate(corners)


def joined_sides(patches: Patches, pieces: Pieces, parts: Parts) -> tuple[np.ndarray, np.ndarray]:
    """
    Join the sides of parts around every edge.

    Parameters
    ----------
    patches : Patches
    pieces : Pieces
    parts : Parts

    Returns
    -------
    ndarray of int64, shape (n_part, 2)
        What is seen from the front and the back of each: one side for all those that see the same.
    ndarray of int64, shape (n_part,)
        Connected piece of each: its lowest part.

    Raises
    ------
    SurfaceError
        If a surface has triangles twice.
    InvariantError
        If two different triangles lie in one half-plane of an edge.
    """
    open_at = edges_at(pieces.triangles, pieces.ring, pieces.link, parts.of_element)
    return _joined(pieces, parts, *sorted_seams(patches, pieces, parts.of_element, open_at))


def _joined(
    pieces: Pieces, parts: Parts, start: np.ndarray, seams: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What is seen from the front and the back of each part, and its connected piece."""
    # parts are few: each range of edges joins all of them for itself
    n, rows = len(parts.first), in_ranges(len(start) - 1, _SEAMS)
    forests = [(np.arange(2 * n), np.arange(n)) for _ in rows]
    part_of = parts.of_element
    map_threads(
        join_seams,
        [
            (start[i : j + 1], seams, part_of, *forest)
            for (i, j), forest in zip(rows, forests, strict=True)
        ],
    )

    # the rim of a surface inside the model: front and back see each other around it
    torn = _with_rims(pieces, parts)
    sides = [np.stack([2 * torn + 1, 2 * torn], axis=1)]
    sides += [np.stack([np.arange(2 * n), forest], axis=1) for forest, _ in forests]
    piece = [np.stack([np.arange(n), forest], axis=1) for _, forest in forests]
    seen = join_pairs(np.concatenate(sides), 2 * n)
    return seen.reshape(-1, 2), join_pairs(np.concatenate(piece), n)


def _with_rims(pieces: Pieces, parts: Parts) -> np.ndarray:
    """Parts with a run on the rim of a surface, around which front and back see the same."""
    rims = [strips.runs[:, RIM] for strips in pieces.strips if strips is not None]
    if not rims:
        return np.empty(0, dtype=np.int64)
    of_run = parts.of_element[len(pieces.triangles) :][np.concatenate(rims) == 1]
    return distinct(of_run[of_run >= 0])


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
    def sums(self) -> np.ndarray:
        """Volume, area and bounds of faces, float64 (n, N_SUM): see `carve.measures`."""
        wanted = np.ones(len(self.surface_of), dtype=bool)
        return measures.sums(self.pieces, self.face_of_element, wanted, self.level)

    @cached_property
    def level(self) -> float:
        """Local elevation that `sums` refer to [m]: that of the middle of the box."""
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
        return self.sums[:, [measures.LOWER.stop - 1, measures.UPPER.stop - 1]]

    def beside_level(self, wanted: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
        """Six times the volume of some faces (bool) above and below a level, in two numbers."""
        found = measures.sums(self.pieces, self.face_of_element, wanted, level)
        return found[:, measures.ABOVE], found[:, measures.BELOW]

    @property
    def flat(self) -> np.ndarray:
        """Twice the area of each face in the map, below 0 where its front looks down [m2]."""
        return self.sums[:, measures.FLAT]

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
        return self.with_triangles(face[row], full.triangles[row], row, full.local)

    def with_triangles(
        self, face: np.ndarray, triangles: np.ndarray, row: np.ndarray, x: np.ndarray
    ) -> FullCells:
        """The same with a face for each of some triangles, given the face that each is of."""
        # faces that several surfaces own, as many times as they have triangles
        several = np.flatnonzero(np.isin(face, list(self.also)))
        also = {i: self.also[face[i]] for i in several.tolist()}
        return FullCells(
            self.surface_of[face], also, self.cell_of_side[face], self.n_cell, self.patches,
            self.pieces, self.face_of_element, triangles, row, x,
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
        return rise_of(self.x[self.triangles])

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
    SurfaceError
        If a surface has triangles twice.
    InvariantError
        If two different triangles lie in one half-plane of an edge.
    """
    pieces, parts, sides, owners, owner = _seen(patches, box_of(patches))

    # which sides of parts look out of the model
    element = np.flatnonzero(parts.of_element >= 0)
    core = element[: np.searchsorted(element, len(pieces.triangles))]
    part = parts.of_element[element]
    wall_of = walls_among(patches, owners)[owner[part]]
    outside = outside_of_walls(patches, wall_of, sides[part], pieces.x, pieces.triangles[core])

    # sides that see each other are one cell; parts with the same owners and cells are one face
    cell, n_cell = _numbered(sides, outside)
    keys = (owner * (n_cell + 1) + cell[:, 0]) * (n_cell + 1) + cell[:, 1]
    key, face = number_keys(keys)
    key, behind = np.divmod(key, n_cell + 1)
    key, front = np.divmod(key, n_cell + 1)
    face_of_element = np.append(face, -1)[parts.of_element]

    # the first owner names the face, the others are listed with how they are turned on it
    first = np.array([of[0][0] for of in owners], dtype=np.int64)
    also = {i: owners[k][1:] for i, k in enumerate(key.tolist()) if len(owners[k]) > 1}
    between = np.stack([front, behind], axis=1)
    return Cells(first[key], also, between, n_cell, patches, pieces, face_of_element)


def _seen(
    patches: Patches, bounds: np.ndarray
) -> tuple[Pieces, Parts, np.ndarray, list[Owners], np.ndarray]:
    """Pieces, their parts, what these see (n_part, 2); sets of surfaces, and the one that owns
    each part.
    """
    pieces = patches.pieces
    while True:
        parts = find_parts(pieces, bounds)
        sides, piece = joined_sides(patches, pieces, parts)
        owners, owner = _owners(pieces, parts)
        fixed = _outermost(pieces, parts, piece, walls_among(patches, owners)[owner] >= 0)
        floats = not np.isin(piece, fixed).all()
        if not _asks_triangles(pieces, floats):
            break
        pieces = patches.changed().pieces

    # pieces that touch nothing: a ray from each finds the cell that it floats in
    if floats:
        element = np.flatnonzero(parts.of_element >= 0)
        part = parts.of_element[element]
        placed = place_floating(
            pieces.x, pieces.triangles[element], piece[part], fixed, sides[part].ravel()
        )
        sides = placed.reshape(-1, 2)[np.searchsorted(element, parts.first)]
    return pieces, parts, sides, owners, owner


def _outermost(pieces: Pieces, parts: Parts, piece: np.ndarray, is_wall: np.ndarray) -> np.ndarray:
    """The piece of walls that no other one can be around, as their array (1,)."""
    outermost = distinct(piece[is_wall])
    if len(outermost) > 1:  # walls of several shells: the one that reaches highest
        # of the walls' triangles the highest decides: no shell around it can be lower
        part = parts.of_element[: len(pieces.triangles)]
        rows = np.flatnonzero(part >= 0)
        rows = rows[is_wall[part[rows]]]
        top = pieces.x[pieces.triangles[rows], 2].max(axis=1)
        outermost = piece[part[rows[top.argmax()]]][None]
    return outermost


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
    for i, owner_of_copy in zip(at.tolist(), turned, strict=True):
        owning = listed.get(i, owners[owner[i]])
        listed[i] = owning if owner_of_copy in owning else (*owning, owner_of_copy)
    number = {owning: k for k, owning in enumerate(owners)}
    for i, owning in listed.items():
        owner[i] = number.setdefault(owning, len(number))
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
    at = np.minimum(np.searchsorted(floating, piece), len(floating) - 1)
    floats = floating[at] == piece
    # labels of all sides but the outer ones of floating pieces
    other_shells = shell[~(np.repeat(floats, 2) & (shell == np.repeat(label[at], 2)))]
    start, outside, united = label, -1, np.empty((0, 2), dtype=np.int64)
    while True:
        beyond = holding == NO_HIT
        if beyond.any() and outside < 0:
            # the topmost side of the walls sees the outside as well
            outside = int(shell[rays.shoot(wall, np.where(np.isin(piece, fixed), -1, piece))[0, 0]])
        held = np.where(beyond, outside, shell[holding])
        united = np.concatenate([united, np.stack([start, held], axis=1)])
        root = join_pairs(united, int(shell.max()) + 1)
        # pieces that float side by side may see each other only: ask beyond all of them
        # pieces whose shells only see each other are one group; the next rays start from its
        # members and pass through all of it
        alone, member = np.unique(root[label], return_index=True)
        member = member[~np.isin(alone, root[other_shells])]
        if len(member) == 0:
            return root[shell]
        group = piece.copy()
        group[floats] = 1 + piece.max() + root[label[at[floats]]]
        start, holding = label[member], rays.shoot(first[member], group)[:, 1]
