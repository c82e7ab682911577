"""The exact cut of a torn sheet by its faults, near the faults: cut-offs, and leaks if there are
any.

Only triangles near the tears take part, all others are met by no fault; islands that no fault
joins are cut side by side. A leak is an outer edge of the ghosts, cut by a fault, of which a part
stays in the sheet, or through which real parts far from the fault and ghosts are one; or a copy
inside which a fault ends, so that they are one round it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from geosurf.arrangement.search import find_contacts
from geosurf.arrangement.threads import map_threads
from geosurf.conventions import frame_origin
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.model import Patches, TriSurface
from geosurf.model.base import all_of, any_of
from geosurf.rebuild import patches_from
from geosurf.rebuild.ghosts import kept_parts
from geosurf.rebuild.wall_sides import WALL
from geosurf.sheets.faults.fault_distance import Blocks
from geosurf.sheets.lattice.drape import around
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.mesh.holes import Hole, holes_at, holes_of
from geosurf.sheets.mesh.islands import islands
from geosurf.sheets.mesh.leaks import (
    Leak,
    ends_in_copies,
    false_rims,
    free_edges,
    leaks_of,
    sides_at_curves,
)
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles, outer_ghosts, renumbered

IsOwn = Callable[[np.ndarray], np.ndarray]  # nodes clearly on their own side of all faults


@dataclass(eq=False)
class Band:
    """The part of a torn sheet that faults can meet.

    Attributes
    ----------
    surface : TriSurface
        With ``vertex_data["ghost"]``.
    vertex : ndarray of int64 (n_vertex,)
        Vertex in the numbering of `Torn`.
    outer : ndarray of int64
        Outermost ghosts, in the numbering of `Torn`.
    is_copy : ndarray of bool (n_triangle,)
        Copies; the others are triangles of the lattice.
    """

    surface: TriSurface
    vertex: np.ndarray
    outer: np.ndarray
    is_copy: np.ndarray

    def only(self, rows: np.ndarray) -> Band:
        """Some triangles of it."""
        surface = self.surface
        # Only vertices in use, in their order.
        used, faces = renumbered(surface.triangles.take(rows, axis=0), surface.n_vertex)
        part = TriSurface(
            surface.name,
            surface.role,
            surface.vertices.take(used, axis=0),
            faces,
            vertex_data={key: values.take(used) for key, values in surface.vertex_data.items()},
        )
        return Band(part, self.vertex.take(used), self.outer, self.is_copy[rows])


@dataclass(eq=False)
class Part:
    """What the exact cut gave of one island.

    Attributes
    ----------
    faults : list of int
        Numbers of the faults that can meet it.
    patches : Patches
        Of its triangles and these faults, ghosts included.
    corners : ndarray of int64 (n, 3)
        Corners of its triangles, as vertices of `Torn`.
    keep : ndarray of bool (n_triangle,)
        See `kept_parts`.
    curve_sides : list of (ndarray, ndarray)
        By surface, see `sides_at_curves`.
    leaks, dead_ends, holes
        As of `Cut`.
    """

    faults: list[int]
    patches: Patches
    corners: np.ndarray
    keep: np.ndarray
    curve_sides: list[tuple[np.ndarray, np.ndarray]]
    leaks: list[Leak]
    dead_ends: list[tuple[int, int]]
    holes: list[Hole]


@dataclass(eq=False)
class Cut:
    """What the exact cut gave.

    Attributes
    ----------
    parts : list of Part
        One for each island.
    leaks : list of (int, int, frozenset of int)
        Outer edges, as vertices of `Torn`, that the sheet would end on inside the data, and the
        faults that cut them.
    dead_ends : list of (int, int)
        Copies, by two vertices, inside which a fault ends.
    holes : list of Hole
        The places that leaks and dead ends come from.
    """

    parts: list[Part]
    leaks: list[Leak]
    dead_ends: list[tuple[int, int]]
    holes: list[Hole]

    def part_of(self, fault: int) -> Part:
        """The part in which a fault is."""
        return next(part for part in self.parts if fault in part.faults)


def band_of(
    torn: Torn,
    triangles: Triangles,
    frame: Frame,
    heights: np.ndarray,
    ghosts: np.ndarray,
    reach: int,
    walls: Mapping[str, np.ndarray] | None = None,
) -> Band:
    """Copies, and the triangles within `reach` cells of them; of an untorn sheet, of its first.

    `walls` are those of nodes at faults, by name: see `geosurf.rebuild.wall_sides`.
    """
    nodes = torn.node_of_ghost
    outer = outer_ghosts(torn, triangles)
    # An untorn sheet has no ghosts: its first triangle stands for it.
    near = around(nodes if len(nodes) else triangles.first() // 2, frame.shape, reach)

    # whole triangles of the lattice first, then the copies: `is_copy` follows from this order
    t, corners = triangles.of_cells(near)
    whole = np.flatnonzero(~is_among(t, torn.divided))
    faces = np.concatenate([corners.take(whole, axis=0), torn.corners])

    # `used` is increasing: nodes before ghosts
    used, faces = renumbered(faces, torn.n_node + len(ghosts))
    real = used < torn.n_node
    z = np.concatenate([heights[used[real]], ghosts[used[~real] - torn.n_node]])
    nodes = torn.node_of(used)
    surface = TriSurface(
        "sheet",
        "horizon",
        np.column_stack([frame.node_places(nodes), z]),
        faces,
        vertex_data={
            "ghost": ~real,
            "outer": is_among(used, outer),
            "node": nodes,
            **walls_of_vertices(walls, torn, used),
        },
    )
    is_copy = np.arange(len(faces)) >= len(whole)
    return Band(surface, used, outer, is_copy)


def walls_of_vertices(
    walls: Mapping[str, np.ndarray] | None, torn: Torn, vertices: np.ndarray
) -> dict[str, np.ndarray]:
    """Walls of nodes, ghosts with that of their anchor, as data of some vertices of `torn`."""
    anchors = torn.anchored(vertices)
    return {WALL + fault: of_node[anchors] for fault, of_node in (walls or {}).items()}


def cut_band(
    band: Band,
    torn: Torn,
    triangles: Triangles,
    faults: Sequence[TriSurface],
    frame: Frame,
    blocks: Sequence[Blocks],
    is_own: IsOwn,
) -> Cut:
    """Cut a band by its faults, exactly, and look for leaks.

    `blocks` of each fault hold something wherever it can meet the band. `is_own` gives which nodes
    are clearly on their own side of all faults, at their own height.
    """
    # points are rounded once, in the frame of all: the same for any islands
    origin = frame_origin(band.surface.extent, *(fault.extent for fault in faults))
    found = islands(band.surface.vertex_data["node"], band.surface.triangles, frame, blocks)
    parts = map_threads(
        partial(
            _cut_part,
            torn=torn,
            triangles=triangles,
            frame=frame,
            origin=origin,
            is_own=is_own,
        ),
        [
            (band if len(found) == 1 else band.only(rows), mine, [faults[k] for k in mine])
            for rows, mine in found
        ],
    )
    # Sorted by vertices, so that threads do not change the order.
    leaks = sorted((leak for part in parts for leak in part.leaks), key=lambda leak: leak[:2])
    dead_ends = [pair for part in parts for pair in part.dead_ends]
    return Cut(parts, leaks, dead_ends, [hole for part in parts for hole in part.holes])


def _cut_part(
    band: Band,
    numbers: list[int],
    faults: Sequence[TriSurface],
    *,
    torn: Torn,
    triangles: Triangles,
    frame: Frame,
    origin: np.ndarray,
    is_own: IsOwn,
) -> Part:
    """Cut one island by its faults."""
    # The same exact arrangement as for a whole model, on a few thousand triangles.
    patches = patches_from(find_contacts([band.surface, *faults], origin=origin))

    # a part that is dropped though it has triangles clearly on their own side leaks somewhere:
    # it counts as open, so that the edge through which it runs into ghosts is found
    keep, corner, part = kept_parts(patches)
    open_part = keep | _dropped_with_own(band, patches, keep, part, corner, is_own)
    corner = np.where(corner >= 0, band.vertex[corner], -1)

    # leaks: outer edges that are cut and stay in part; dead ends: copies in which a fault ends
    sides = sides_at_curves(patches)
    rim = free_edges(patches, sides)
    leaks = [
        (a, b, frozenset(numbers[k] for k in met))
        for a, b, met in leaks_of(patches, rim, open_part, corner, torn, triangles)
    ]
    dead_ends = _named(band, false_rims(patches, keep, sides))
    # A part that was counted as open without being kept may run through a copy.
    if not keep[open_part].all():
        dead_ends += _named(band, ends_in_copies(patches, rim, open_part, sides))
    corners = band.vertex[band.surface.triangles]

    # the minimum cut is looked for only where something is open: most islands are closed
    holes: list[Hole] = []
    if leaks or dead_ends:
        edges = distinct(*(keys for keys, _ in sides[1:]))
        is_source = _clear_triangles(band, is_own)
        holes = holes_of(patches, edges, corner, is_source, band.outer, frame.cell)
        if not holes:  # an outer edge comes back through the fault between its ends
            pairs = [*(leak[:2] for leak in leaks), *dead_ends]
            holes = holes_at(pairs, _places(band), torn.n_node, frame.cell)
    return Part(numbers, patches, corners, keep, sides, leaks, dead_ends, holes)


def _places(band: Band) -> Callable[[np.ndarray], np.ndarray]:
    """Makes the function that gives the places (n, 3) of vertices of `Torn` in a band."""
    return lambda vertex: band.surface.vertices[np.searchsorted(band.vertex, vertex)]


def _clear_triangles(band: Band, is_own: IsOwn) -> np.ndarray:
    """Triangles of the lattice in a band, bool (n,), with corners clearly on their own side.

    At a tip a copy may have real corners only, and yet reach beyond the fault.
    """
    faces = band.surface.triangles
    whole = np.flatnonzero(~band.is_copy)
    # Each node is asked once; sides cost a search in the fault.
    nodes = distinct(faces[whole])
    clear = np.zeros(band.surface.n_vertex, dtype=bool)
    clear[nodes] = is_own(band.vertex[nodes])
    out = np.zeros(len(faces), dtype=bool)
    out[whole] = all_of(clear[faces[whole]])
    return out


def _dropped_with_own(
    band: Band,
    patches: Patches,
    keep: np.ndarray,
    part: np.ndarray,
    corner: np.ndarray,
    is_own: IsOwn,
) -> np.ndarray:
    """Triangles of parts that are dropped though they have real triangles far from the faults.

    Such a part runs into ghosts somewhere. `corner` (n_triangle, 3) is -1 at points that were made.
    """
    # dropped triangles of the sheet, as the lattice triangles that they were cut from: a tip is a
    # corner of copies on both of its sides, and one of them may have real corners only
    rows = np.flatnonzero((patches.surface_of_triangle == 0) & ~keep)
    rows = rows[~band.is_copy[patches.parent_of_triangle[rows]]]
    corners = band.surface.triangles[patches.parent_of_triangle[rows]]
    nodes = distinct(corners)
    own = is_own(band.vertex[nodes])
    rows = rows[all_of(own[np.searchsorted(nodes, corners)])] if len(rows) else rows

    # a piece without any corner of its triangle may lie beyond the fault
    on_fault = np.zeros(len(patches.local), dtype=bool)
    on_fault[patches.triangles[patches.surface_of_triangle > 0]] = True
    rows = rows[any_of((corner[rows] >= 0) & ~on_fault[patches.triangles[rows]])]

    # one row more: part -1 stands for triangles of the faults
    found = np.zeros(part.max(initial=-1) + 2, dtype=bool)
    found[part[rows]] = True
    return found[part]


def _named(band: Band, faces: np.ndarray) -> list[tuple[int, int]]:
    """Triangles of a band, by two of their corners, as vertices of `Torn`."""
    # Lowest and highest vertex name a copy well enough for messages and repairs.
    corners = np.sort(band.vertex[band.surface.triangles[faces]], axis=1)
    return [(int(a), int(b)) for a, b in np.unique(corners[:, [0, 2]], axis=0)]
