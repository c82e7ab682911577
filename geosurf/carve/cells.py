"""Patches -> cells: which sides of which triangles see the same piece of space.

Cells come from topology: sides of triangles are united across edges, in exact radial order
where more than two meet. A free edge unites the two sides of its own triangle, so a fault that
dies inside a cell does not split it. What no curve touches of a gridded surface is runs of
triangles, each of which has two sides as one triangle has. Pieces that touch nothing else (a
fault that floats, an inner shell) are put into the cell that holds them (`floating`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.carve.floating import place_floating
from geosurf.carve.measures import FLAT, measure
from geosurf.carve.outside import outside_of_fence, walls_are_a_box
from geosurf.conventions import place
from geosurf.errors import GeometryError, InvariantError, OpenUnitError
from geosurf.kernels.gather import number_keys
from geosurf.kernels.mesh import connected
from geosurf.kernels.predicates import frame_of
from geosurf.kernels.radial import join_run_sides, join_sides
from geosurf.kernels.strips import RIM, lowest_keys
from geosurf.model import Patches
from geosurf.model.pieces import Pieces

OUTSIDE = 0


@dataclass(frozen=True)
class Cells:
    """Cells of the space inside the model box, and what separates them.

    Attributes
    ----------
    surface_of : ndarray of int64, shape (n,)
        Surface of each face: a triangle inside the box, or a run of them.
    also : dict of int to list of int
        Further surfaces that own a face, where surfaces coincide.
    cell_of_side : ndarray of int64, shape (n, 2)
        Cell in front of and behind each face; 0 is the space outside.
    n_cell : int
        Cells are numbered 1 to n_cell.
    patches : Patches
    pieces : Pieces
    element : ndarray of int64, shape (n,)
        Which element of the pieces each face is.
    """

    surface_of: np.ndarray
    also: dict[int, list[int]]
    cell_of_side: np.ndarray
    n_cell: int
    patches: Patches
    pieces: Pieces
    element: np.ndarray

    @cached_property
    def measures(self) -> np.ndarray:
        """Of each face, float64 (n, 10): see `geosurf.carve.measures`."""
        return measure(self.pieces, self.element, box_of(self.patches).mean(axis=0))

    @property
    def flat(self) -> np.ndarray:
        """Area of each face in the map, below 0 where its front looks down [m2]."""
        return self.measures[:, FLAT]

    @cached_property
    def in_full(self) -> FullCells:
        """The same with a face for every triangle."""
        full = self.pieces.expanded
        face_of = np.full(len(self.pieces.patch), -1, dtype=np.int64)
        face_of[self.element] = np.arange(len(self.element))
        face = face_of[full.element]
        row = np.flatnonzero(face >= 0)
        face = face[row]
        place = np.empty(len(self.element), dtype=np.int64)
        place[face[::-1]] = np.arange(len(face))[::-1]
        also = {int(place[one]): listed for one, listed in self.also.items()}
        return FullCells(
            self.surface_of[face], also, self.cell_of_side[face], self.n_cell, self.patches,
            self.pieces, self.element, full.triangles[row], row, full.local,
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
    def flat(self) -> np.ndarray:  # type: ignore[override]
        """Area of each face in the map, below 0 where its front looks down [m2]."""
        a, b, c = (self.x[self.triangles[:, k]] for k in range(3))
        return 0.5 * np.cross(b - a, c - a)[:, 2]

    @property
    def in_full(self) -> FullCells:  # type: ignore[override]
        """These cells."""
        return self


def box_of(patches: Patches) -> np.ndarray:
    """Lower and upper corner of the model box, local, from the walls among the surfaces."""
    walls = [s for s in patches.sources if s.role == "wall"]
    if not walls:
        raise GeometryError(
            "there are no walls among the surfaces, so that no unit can close. Add the six "
            "sides of the model box: surfaces + build_walls(box)."
        )
    corners = np.concatenate([wall.vertices for wall in walls]) - patches.origin
    return np.stack([corners.min(axis=0), corners.max(axis=0)])


def find_cells(patches: Patches) -> Cells:
    """Find the cells inside the model box.

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
    pieces = patches.pieces
    kept = _inside(pieces, bounds)
    piece, fixed = _connected(pieces, kept)
    if not np.isin(piece[kept], fixed).all() and any(s is not None for s in pieces.strips):
        # something floats: the ray that places it asks triangles
        pieces = patches.changed().pieces
        kept = _inside(pieces, bounds)
        piece, fixed = _connected(pieces, kept)
    shell, parents = _shells(patches, pieces, kept)
    n_core = len(pieces.triangles)
    if not np.isin(piece[kept], fixed).all():
        inside = np.flatnonzero(kept)
        both = (2 * inside[:, None] + np.arange(2)).ravel()
        shell[both] = place_floating(
            pieces.x, pieces.triangles[inside], piece[inside], fixed, shell[both]
        )
    element = np.flatnonzero(kept)
    core = element[element < n_core]
    sides = shell.reshape(-1, 2)[element]
    surface = surface_of_elements(pieces)[element]
    also = _also(pieces, core, kept)
    of, corners = parents[core], pieces.x[pieces.triangles[core]]
    is_wall = _owned_by_walls(patches, surface, also)
    if walls_are_a_box(patches, bounds):
        rows = np.flatnonzero(is_wall)
        outside = _outside(patches, rows, surface, also, sides.ravel(), of, corners)
    else:
        outside = outside_of_fence(patches, bounds, is_wall, sides.ravel(), of, corners)
    sides[np.isin(sides, outside)] = outside[0]
    numbers, cell = np.unique(sides, return_inverse=True)
    first = int(np.searchsorted(numbers, outside[0]))
    cell = np.where(cell == first, OUTSIDE, np.where(cell < first, cell + 1, cell))
    return Cells(surface, also, cell.reshape(-1, 2), len(numbers) - 1, patches, pieces, element)


def surface_of_elements(pieces: Pieces) -> np.ndarray:
    """Surface of each triangle and run."""
    of_run = np.repeat(np.arange(len(pieces.sources)), np.diff(pieces.first_run))
    return np.concatenate([pieces.surface, of_run])


def _inside(pieces: Pieces, bounds: np.ndarray) -> np.ndarray:
    """Whether each element is in the box, and the first of those with the same corners.

    The walls cut at the sides of the box: a run lies on one side of each, as any of its triangles.
    """
    beyond = ((pieces.x < bounds[0]) | (pieces.x > bounds[1])).any(axis=1)
    kept = [~beyond[pieces.triangles].any(axis=1) & (pieces.twin == np.arange(len(pieces.twin)))]
    for source, strips in zip(pieces.sources, pieces.strips, strict=True):
        if strips is not None:
            keys = lowest_keys(strips.places, strips.runs)
            corners = source.places_of_nodes(source.corners_of_keys(keys).ravel()) - pieces.origin
            out = ((corners < bounds[0]) | (corners > bounds[1])).any(axis=1)
            kept.append(~out.reshape(-1, 3).any(axis=1))
    return np.concatenate(kept)


def _connected(pieces: Pieces, kept: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Connected piece of each element inside, and the pieces that hold a wall."""
    n_core = len(pieces.triangles)
    linked = np.flatnonzero(pieces.link >= 0)
    pairs = [np.stack([linked // 3, n_core + pieces.link[linked]], axis=1)]
    for i, strips in enumerate(pieces.strips):
        if strips is not None:
            pairs.append(strips.joined + n_core + pieces.first_run[i])
    piece = connected(pieces.ring, kept, np.concatenate(pairs))
    walls = [i for i, source in enumerate(pieces.sources) if source.role == "wall"]
    # where a wall coincides with another surface, the first of them stands for both
    first = np.concatenate([pieces.twin, np.arange(n_core, len(kept))])
    rows = first[np.isin(surface_of_elements(pieces), walls)]
    return piece, np.unique(piece[rows[kept[rows]]])


def _shells(patches: Patches, pieces: Pieces, kept: np.ndarray):
    """Shell of each side of each element, and the corners of the parents of the triangles."""
    n_core = len(pieces.triangles)
    sides = np.arange(2 * len(kept))
    parent, px = _parents(pieces)
    m, w = frame_of(px)
    of = np.arange(len(px)).reshape(-1, 3)
    bad = join_sides(
        pieces.x, pieces.triangles, pieces.ring, pieces.link, kept, parent, px, of, m, w, sides
    )
    if bad >= 0:
        name = patches.names[pieces.surface[bad // 3]]
        where = place(pieces.x[pieces.triangles[bad // 3, bad % 3]] + patches.origin)
        raise InvariantError(
            f"two triangles of surface {name!r} and another lie in one half-plane at {where}; "
            "please report this with the surfaces."
        )
    joined = [np.empty((0, 2), dtype=np.int64)]
    rims = [np.empty(0, dtype=np.int64)]
    for i, strips in enumerate(pieces.strips):
        if strips is not None:
            joined.append(strips.joined + pieces.first_run[i])
            rims.append(strips.runs[:, RIM])
    join_run_sides(np.concatenate(joined), np.concatenate(rims), kept, sides)
    return _roots(sides), px[of[parent]] if n_core else np.empty((0, 3, 3))


def _parents(pieces: Pieces) -> tuple[np.ndarray, np.ndarray]:
    """For each triangle its input triangle, and the corners of those, three rows each."""
    limit = 1 + int(pieces.key.max(initial=0))
    used, number = number_keys(pieces.surface * limit + pieces.key)
    surface, key = np.divmod(used, limit)
    px = np.empty((len(used), 3, 3))
    for i, source in enumerate(pieces.sources):
        mine = surface == i
        corners = source.corners_of_keys(key[mine])
        px[mine] = source.places_of_nodes(corners.ravel()).reshape(-1, 3, 3) - pieces.origin
    return number, px.reshape(-1, 3)


def _also(pieces: Pieces, core: np.ndarray, kept: np.ndarray) -> dict[int, list[int]]:
    """Further surfaces of each face that has twins."""
    others = np.flatnonzero(pieces.twin != np.arange(len(pieces.twin)))
    also: dict[int, list[int]] = {}
    for other in others[kept[pieces.twin[others]]].tolist():
        face = int(np.searchsorted(core, pieces.twin[other]))
        also.setdefault(face, []).append(int(pieces.surface[other]))
    return also


def _owned_by_walls(patches: Patches, surface: np.ndarray, also: dict[int, list[int]]):
    """Whether a wall is among the owners of each face."""
    wall = np.array([source.role == "wall" for source in patches.sources])
    is_wall = wall[surface]
    is_wall[[i for i, listed in also.items() if wall[listed].any()]] = True
    return is_wall


def _outside(patches: Patches, rows, surface, also, shell, parents, corners) -> np.ndarray:
    """Shells on the outer side of the walls, or an error if they are on the inner side, too."""
    lower, upper = box_of(patches)
    a, b, c = (parents[rows, k] - 0.5 * (lower + upper) for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0
    outside = np.unique(shell[2 * rows + inward])
    leaks = rows[np.isin(shell[2 * rows + ~inward], outside)]
    if len(leaks):
        owners = (surface[leaks[0]], *also.get(int(leaks[0]), ()))
        name = next(patches.names[i] for i in owners if patches.sources[i].role == "wall")
        where = corners[leaks[0]].mean(axis=0) + patches.origin
        raise OpenUnitError(
            f"the model box is open: wall {name!r} has the outside on both of its sides at "
            f"{place(where)}. Give all six sides without holes, as build_walls(box) makes them.",
            place=where, surfaces=(name,),
        )  # fmt: skip
    return outside


def _roots(sides: np.ndarray) -> np.ndarray:
    """The root of each element of a union-find forest, by pointer jumping."""
    while True:
        onward = sides[sides]
        if np.array_equal(onward, sides):
            return sides
        sides = onward
