"""Patches -> cells: which sides of which triangles see the same piece of space.

Cells come from topology: sides of triangles are united across edges, in exact radial order
where more than two meet. A free edge unites the two sides of its own triangle, so a fault that
dies inside a cell does not split it. Pieces that touch nothing else (a fault that
floats, an inner shell) are put into the cell that holds them by a ray with exact hits.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from geosurf.carve.outside import outside_of_fence, walls_are_a_box
from geosurf.conventions import place
from geosurf.errors import GeometryError, InvariantError, OpenUnitError
from geosurf.kernels.mesh import edges, pieces
from geosurf.kernels.predicates import frame_of
from geosurf.kernels.radial import join_sides
from geosurf.model import Patches

OUTSIDE = 0


@dataclass
class Cells:
    """Cells of the space inside the model box.

    Attributes
    ----------
    triangles : ndarray of int64, shape (n, 3)
        Distinct triangles inside the box, rows of `Patches.local`.
    row : ndarray of int64, shape (n,)
        Their rows in `Patches.triangles`.
    owners : list of tuple of int
        Surfaces that each triangle belongs to: more than one where surfaces coincide.
    cell_of_side : ndarray of int64, shape (n, 2)
        Cell in front of and behind each triangle; 0 is the space outside.
    n_cell : int
        Cells are numbered 1 to n_cell.
    """

    triangles: np.ndarray
    row: np.ndarray
    surface_of: np.ndarray
    also: dict[int, list[int]]
    ring: np.ndarray
    cell_of_side: np.ndarray
    n_cell: int


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
    lower, upper = box_of(patches)
    x = patches.local
    beyond = ((x < lower) | (x > upper)).any(axis=1)
    rows = np.flatnonzero(~beyond[patches.triangles].any(axis=1))
    rows, also = _distinct(patches, rows)
    t = patches.triangles[rows]
    surface = patches.surface_of_triangle[rows]
    ring, _ = edges(t, len(x))
    sides = np.arange(2 * len(t))
    parent, px = _parents(patches, rows)
    m, w = frame_of(px)
    bad = join_sides(
        x, t, ring, np.ones(len(t), dtype=np.int64), parent, px,
        np.arange(len(px)).reshape(-1, 3), m, w, sides,
    )  # fmt: skip
    if bad >= 0:
        where = place(x[t[bad // 3, bad % 3]] + patches.origin)
        raise InvariantError(
            f"two triangles of surface {patches.names[surface[bad // 3]]!r} and another lie in one "
            f"half-plane at {where}; please report this with the surfaces."
        )
    shell = _roots(sides)
    shell = _place_floating(x, t, ring, surface, patches, shell)
    of = px[3 * parent[:, None] + np.arange(3)]
    bounds = np.stack([lower, upper])
    if walls_are_a_box(patches, bounds):
        outside = _outside(patches, surface, shell, of, x[t])
    else:
        is_wall = _owned_by_walls(patches, surface, also)
        outside = outside_of_fence(patches, bounds, is_wall, shell, of, x[t])
    shell[np.isin(shell, outside)] = outside[0]
    numbers, cell = np.unique(shell, return_inverse=True)
    first = int(np.searchsorted(numbers, outside[0]))
    cell = np.where(cell == first, OUTSIDE, np.where(cell < first, cell + 1, cell))
    return Cells(t, rows, surface, also, ring, cell.reshape(-1, 2), len(numbers) - 1)


def _owned_by_walls(patches: Patches, surface: np.ndarray, also: dict[int, list[int]]):
    """Whether a wall is among the owners of each triangle."""
    wall = np.array([source.role == "wall" for source in patches.sources])
    is_wall = wall[surface]
    is_wall[[i for i, listed in also.items() if wall[listed].any()]] = True
    return is_wall


def _outside(patches: Patches, surface, shell, parents, corners) -> np.ndarray:
    """Shells on the outer side of the walls, or an error if they are on the inner side, too."""
    lower, upper = box_of(patches)
    walls = [i for i, s in enumerate(patches.sources) if s.role == "wall"]
    rows = np.flatnonzero(np.isin(surface, walls))
    a, b, c = (parents[rows, k] - 0.5 * (lower + upper) for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0
    outside = np.unique(shell[2 * rows + inward])
    leaks = rows[np.isin(shell[2 * rows + ~inward], outside)]
    if len(leaks):
        name = patches.names[surface[leaks[0]]]
        where = place(corners[leaks[0]].mean(axis=0) + patches.origin)
        raise OpenUnitError(
            f"the model box is open: wall {name!r} has the outside on both of its sides at "
            f"{where}. Give all six sides without holes, as build_walls(box) makes them."
        )
    return outside


def _distinct(patches: Patches, rows: np.ndarray):
    """Rows with one triangle for each set of corners, and what other surfaces list it."""
    corners = np.sort(patches.triangles[rows], axis=1)
    keys = corners[:, 0] * len(patches.local) + corners[:, 1]
    order = np.lexsort((rows, corners[:, 2], keys))
    same = np.zeros(len(rows), dtype=bool)
    same[1:] = (corners[order][1:] == corners[order][:-1]).all(axis=1)
    also: dict[int, list[int]] = {}
    kept = -1
    surface = patches.surface_of_triangle
    for position in np.flatnonzero(same):
        kept = position - 1
        while same[kept]:
            kept -= 1
        also.setdefault(int(rows[order[kept]]), []).append(int(surface[rows[order[position]]]))
    keep = np.sort(rows[order[~same]])
    position = {int(row): i for i, row in enumerate(keep)} if also else {}
    return keep, {position[row]: listed for row, listed in also.items()}


def _parents(patches: Patches, rows: np.ndarray):
    """For each triangle its input triangle, and the corners of those, three rows each."""
    surface, of = patches.surface_of_triangle[rows], patches.parent_of_triangle[rows]
    start = np.cumsum([0] + [s.n_triangle for s in patches.sources])
    used, number = np.unique(start[surface] + of, return_inverse=True)
    which = np.searchsorted(start, used, side="right") - 1
    px = np.empty((len(used), 3, 3))
    for i, source in enumerate(patches.sources):
        mine = which == i
        px[mine] = source.vertices[source.triangles[used[mine] - start[i]]] - patches.origin
    return number, px.reshape(-1, 3)


def _roots(sides: np.ndarray) -> np.ndarray:
    """The root of each element of a union-find forest, by pointer jumping."""
    while True:
        onward = sides[sides]
        if np.array_equal(onward, sides):
            return sides
        sides = onward


def _place_floating(x, t, ring, surface, patches, shell):
    """Unite the outer shell of each floating piece with the cell that holds it."""
    piece, count = pieces(t, ring)
    walls = [i for i, s in enumerate(patches.sources) if s.role == "wall"]
    fixed = np.unique(piece[np.isin(surface, walls)])
    sides = np.arange(shell.max() + 1)
    sides = shell.copy()
    for p in range(count):
        if p in fixed:
            continue
        mine = np.flatnonzero(piece == p)
        one, two = _shot(x, t, mine, piece)
        a, b = sides[one], sides[two]
        sides[sides == a] = b
    return sides


def _shot(x, t, mine, piece):
    """Sides (outer, holding) met by a ray from outside through a floating piece and onwards.

    The ray runs along the axis on which the piece's first triangle is widest. It aims at
    rational points inside that triangle until it misses all edges; hits are exact. The points
    lie on a conic, since any edge can be in the way of two of them only.
    """
    a, b, c = x[t[mine[0]]]
    axis = int(np.argmax(np.abs(np.cross(b - a, c - a))))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    low, high = x[t].min(axis=1), x[t].max(axis=1)
    for step in range(1, 200):
        ratio = Fraction(step + 30, 40)
        total = 1 + ratio + ratio * ratio
        weights = (1 / total, ratio / total, ratio * ratio / total)
        aim = [
            sum(f * Fraction(p[k]) for f, p in zip(weights, (a, b, c), strict=True)) for k in (u, v)
        ]
        near = (low[:, u] <= float(aim[0]) + 1e-6) & (high[:, u] >= float(aim[0]) - 1e-6)
        near &= (low[:, v] <= float(aim[1]) + 1e-6) & (high[:, v] >= float(aim[1]) - 1e-6)
        hits = [_hit(x[t[i]], axis, u, v, aim) for i in np.flatnonzero(near)]
        if None in hits:
            continue  # the ray grazes an edge: aim elsewhere
        met = [(h[0], i, h[1]) for i, h in zip(np.flatnonzero(near), hits, strict=True) if h]
        members = set(mine.tolist())
        top = max((hit for hit in met if hit[1] in members), key=lambda hit: hit[0])
        above = [hit for hit in met if hit[1] not in members and hit[0] > top[0]]
        if not above:
            break
        first = min(above, key=lambda hit: hit[0])
        # the side towards +axis is the front where the normal points there
        return 2 * top[1] + (0 if top[2] > 0 else 1), 2 * first[1] + (1 if first[2] > 0 else 0)
    raise InvariantError(
        "a floating piece of surface lies in no cell; please report this with the surfaces."
    )


def _hit(corners, axis, u, v, aim):
    """(height, sign of the normal along the axis), () for a miss, None on an edge."""
    p = [[Fraction(float(c[k])) for k in (u, v, axis)] for c in corners]
    areas = []
    for i in range(3):
        q, r = p[i], p[(i + 1) % 3]
        areas.append((q[0] - aim[0]) * (r[1] - aim[1]) - (q[1] - aim[1]) * (r[0] - aim[0]))
    if all(area > 0 for area in areas) or all(area < 0 for area in areas):
        total = sum(areas)
        height = sum(areas[(i + 1) % 3] * p[i][2] for i in range(3)) / total
        return height, 1 if total > 0 else -1
    if any(area > 0 for area in areas) and any(area < 0 for area in areas):
        return ()
    return None
