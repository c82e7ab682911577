"""The exact cut of a torn sheet by its faults, near the faults: cut-offs, and leaks if there are
any.

Only triangles near the tears take part, all others are met by no fault. A leak is an outer edge
of the ghosts, cut by a fault, of which a part stays in the sheet, or through which real parts far
from the fault and ghosts are one; or a copy inside which a fault ends, so that they are one round
it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.model import Patches, TriSurface
from geosurf.rebuild import rebuild_surfaces
from geosurf.rebuild.ghosts import kept_parts
from geosurf.sheets.drape import around
from geosurf.sheets.frame import Frame
from geosurf.sheets.mesh import Torn, Triangles, outer_ghosts


@dataclass(eq=False)
class Band:
    """The part of a torn sheet that faults can meet.

    Attributes
    ----------
    surface : TriSurface
        With ``vertex_data["ghost"]``.
    vertex : ndarray of int64 (n_vertex,)
        Vertex in the numbering of `Torn`.
    own : ndarray of bool (n_vertex,)
        Nodes that are clearly on their own side of all faults, at their own height.
    outer : ndarray of int64
        Outermost ghosts, in the numbering of `Torn`.
    """

    surface: TriSurface
    vertex: np.ndarray
    own: np.ndarray
    outer: np.ndarray


@dataclass(eq=False)
class Cut:
    """What the exact cut gave.

    Attributes
    ----------
    patches : Patches
        Of the band and all faults, ghosts included.
    keep : ndarray of bool (n_triangle,)
    corner : ndarray of int64 (n_triangle, 3)
        See `kept_parts`.
    leaks : list of (int, int, frozenset of int)
        Outer edges, as vertices of `Torn`, that the sheet would end on inside the data, and the
        faults that cut them.
    dead_ends : list of (int, int)
        Copies, by two vertices, inside which a fault ends.
    """

    patches: Patches
    keep: np.ndarray
    corner: np.ndarray
    leaks: list[tuple[int, int, frozenset[int]]]
    dead_ends: list[tuple[int, int]]


def band_of(
    torn: Torn,
    triangles: Triangles,
    frame: Frame,
    heights: np.ndarray,
    ghosts: np.ndarray,
    reach: int,
    is_own: Callable[[np.ndarray], np.ndarray],
) -> Band:
    """Copies, and the triangles within `reach` cells of them."""
    nodes = np.unique(torn.node_of_ghost)
    outer = outer_ghosts(torn, triangles)
    near = around(nodes, frame.shape, reach)
    t = np.concatenate([2 * near, 2 * near + 1])
    t = t[triangles.exists(t)]
    t = np.setdiff1d(t, torn.divided)
    faces = np.concatenate([triangles.corners(t), torn.corners])
    used, faces = np.unique(faces, return_inverse=True)
    every = np.concatenate([heights, ghosts])
    places = frame.node_places(torn.node_of(used))
    surface = TriSurface(
        "sheet",
        "horizon",
        np.column_stack([places, every[used]]),
        faces.reshape(-1, 3),
        vertex_data={"ghost": used >= torn.n_node, "outer": np.isin(used, outer)},
    )
    own = np.zeros(len(used), dtype=bool)
    real = used < torn.n_node
    own[real] = is_own(used[real])
    return Band(surface, used, own, outer)


def cut_band(band: Band, torn: Torn, triangles: Triangles, faults: Sequence[TriSurface]) -> Cut:
    """Cut a band by its faults, exactly, and look for leaks."""
    patches = rebuild_surfaces([band.surface, *faults])
    keep, corner, part = kept_parts(patches)
    rows = np.flatnonzero(patches.surface_of_triangle == 0)
    parent = band.surface.triangles[patches.parent_of_triangle[rows]]
    # a tip is a corner of copies on both of its sides, so only whole triangles tell
    whole = band.own[parent].all(axis=1) & ~band.surface.vertex_data["ghost"][parent].any(axis=1)
    own = np.zeros(part.max(initial=-1) + 2, dtype=bool)
    own[part[rows[whole]]] = True
    open_part = keep | own[part]  # a real part that is dropped runs into ghosts somewhere
    corner = np.where(corner >= 0, band.vertex[corner], -1)
    leaks = _leaks(patches, open_part, corner, torn, triangles)
    dead_ends = _false_rims(patches, band, keep)
    if not keep[own[part]].all():
        dead_ends += _ends_in_copies(patches, band, open_part)
    return Cut(patches, keep, corner, leaks, dead_ends)


def _leaks(patches, keep, corner, torn: Torn, triangles: Triangles):
    """Outer edges with a ghost end, cut by a fault, of which a part is in `keep`."""
    rows = np.flatnonzero(patches.surface_of_triangle == 0)
    t = patches.triangles[rows]
    n = len(patches.local)
    one, two = t.ravel(), np.roll(t, -1, axis=1).ravel()
    key = np.minimum(one, two) * n + np.maximum(one, two)
    order = np.argsort(key, kind="stable")
    _, first, times = np.unique(key[order], return_index=True, return_counts=True)
    free = order[first[times == 1]]
    name = np.full(n, -1)
    mine = corner[rows]
    name[t[mine >= 0]] = mine[mine >= 0]
    stays = keep[rows[free // 3]]
    onward: dict[int, list[tuple[int, bool]]] = {}
    for a, b, kept in zip(one[free].tolist(), two[free].tolist(), stays.tolist(), strict=True):
        onward.setdefault(a, []).append((b, kept))
        onward.setdefault(b, []).append((a, kept))
    made = (name[one[free]] < 0) | (name[two[free]] < 0)
    starts = {a for a in [*one[free[made]].tolist(), *two[free[made]].tolist()] if name[a] >= 0}
    found: dict[tuple[int, int], set[int]] = {}
    for a in starts:
        for step, kept in onward[a]:
            before, here, any_kept = a, step, kept
            passed = []
            while name[here] < 0:
                ahead = [(v, k) for v, k in onward[here] if v != before]
                if len(ahead) != 1:
                    break
                passed.append(here)
                before, (here, kept) = here, ahead[0]
                any_kept |= kept
            if name[here] >= 0 and any_kept:
                edge = min(int(name[a]), int(name[here])), max(int(name[a]), int(name[here]))
                found.setdefault(edge, set()).update(passed)
    inner = [edge for edge in sorted(found) if _is_inner(edge, torn, triangles)]
    return [(*edge, _faults_at(patches, found[edge])) for edge in inner]


def _faults_at(patches: Patches, vertices: set[int]) -> frozenset[int]:
    """Numbers of the faults that have one of these vertices."""
    rows = np.flatnonzero(np.isin(patches.triangles, list(vertices)).any(axis=1))
    found = np.unique(patches.surface_of_triangle[rows])
    return frozenset((found[found > 0] - 1).tolist())


def _ends_in_copies(patches, band: Band, among) -> list[tuple[int, int]]:
    """Copies in which a curve with a fault ends, by two of their corners."""
    of, n = patches.surface_of_triangle, len(patches.local)

    def keyed(rows: np.ndarray) -> np.ndarray:
        """Keys of the edges of some triangles, three for each."""
        """One number for each edge of some triangles, whichever way it runs."""
        a, b = patches.triangles[rows], np.roll(patches.triangles[rows], -1, axis=1)
        return (np.minimum(a, b) * n + np.maximum(a, b)).ravel()

    rows = np.flatnonzero((of == 0) & among)
    shared = np.intersect1d(keyed(rows), keyed(np.flatnonzero(of > 0)))
    degree = np.bincount(np.concatenate(np.divmod(shared, n)), minlength=n)
    edge, times = np.unique(keyed(np.flatnonzero(of == 0)), return_counts=True)
    degree[np.concatenate(np.divmod(edge[times == 1], n))] = 0  # where it leaves the sheet
    ends = rows[(degree[patches.triangles[rows]] == 1).any(axis=1)]
    faces = band.surface.triangles[patches.parent_of_triangle[ends]]
    copies = faces[band.surface.vertex_data["ghost"][faces].any(axis=1)]
    pairs = np.unique(np.sort(band.vertex[copies], axis=1)[:, [0, 2]], axis=0)
    return [(int(a), int(b)) for a, b in pairs]


def _false_rims(patches, band: Band, keep) -> list[tuple[int, int]]:
    """Triangles that stay beside dropped ones with no fault between, by two of their corners."""
    of, n = patches.surface_of_triangle, len(patches.local)

    def keyed(rows: np.ndarray) -> np.ndarray:
        """Keys of the edges of some triangles, three for each."""
        a, b = patches.triangles[rows], np.roll(patches.triangles[rows], -1, axis=1)
        return (np.minimum(a, b) * n + np.maximum(a, b)).ravel()

    rows = np.flatnonzero(of == 0)
    every, before = np.unique(keyed(rows), return_counts=True)
    kept = rows[keep[rows]]
    edges = keyed(kept)
    name, inverse, after = np.unique(edges, return_inverse=True, return_counts=True)
    inner = before[np.searchsorted(every, name)] > 1
    false = inner & (after != 2) & ~np.isin(name, keyed(np.flatnonzero(of > 0)))
    faces = np.unique(patches.parent_of_triangle[kept[np.flatnonzero(false[inverse]) // 3]])
    corners = np.sort(band.vertex[band.surface.triangles[faces]], axis=1)
    return [(int(a), int(b)) for a, b in np.unique(corners[:, [0, 2]], axis=0)]


def _is_inner(edge: tuple[int, int], torn: Torn, triangles: Triangles) -> bool:
    """Whether an edge has a ghost end, and the horizon has triangles on both sides of its link."""
    if max(edge) < torn.n_node:
        return False
    nodes = torn.node_of(np.array([edge[0], edge[1], edge[1]])).reshape(1, 3)
    node, kind = triangles.links(nodes)
    return bool(triangles.exists(triangles.beside(node[:, 0], kind[:, 0])[0]).all())
