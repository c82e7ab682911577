"""Trim torn sheets at their faults after the rebuild.

A sheet that was torn reaches past its fault with vertices without data
(``vertex_data["ghost"]``); the outermost of them (``"outer"``) lie beyond the fault. The rebuild
cuts the sheet there, exactly. Patches of a sheet are joined again where only walls and other
horizons cut it; a part that holds an outer vertex lies beyond a fault and is dropped, so that the
sheet ends on the fault and shares its vertices. So is a part on the wrong side of a fault, if the
sheet states the walls of its vertices (`wall_sides`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.errors import GeosurfWarning
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.meshes.mesh import join_pairs, kept_triangles, number_keys
from geosurf.kernels.meshes.parts import balance_at_fault, join_past_others
from geosurf.kernels.sheets.torn_links import classify_parts, sides_of_edges
from geosurf.model import Patches, TriSurface, frozen
from geosurf.model.expected import expect
from geosurf.model.pieces import Pieces, Strips
from geosurf.model.torn_lattice import TornLattice

# ---- listed ----------------------------------------
# Patches as their listed triangles: all but the runs of gridded surfaces that no curve touches.


@dataclass(frozen=True, eq=False)
class SheetFaces:
    """The triangles of a torn sheet that have parts in patches.

    Attributes
    ----------
    parent : ndarray of int64, shape (n,)
        Of each listed triangle of the sheet, as row of `faces`.
    faces : ndarray of int64, shape (n_face, 3)
        As rows of `places`.
    places : ndarray of float64, shape (n_vertex, 3)
        World coordinates.
    vertex : ndarray of int64, shape (n_vertex,)
        Vertices of the sheet, rising.
    """

    parent: np.ndarray
    faces: np.ndarray
    places: np.ndarray
    vertex: np.ndarray


@dataclass(frozen=True, eq=False)
class Listed:
    """Triangles of patches, surface by surface; names of arrays are those of `Patches`.

    Attributes
    ----------
    sources : sequence of TriSurface
    origin : ndarray of float64, shape (3,)
    local : ndarray of float64, shape (n_vertex, 3)
    triangles : ndarray of int64, shape (n_triangle, 3)
    surface_of_triangle, parent_of_triangle, patch_of_triangle : ndarray of int64
    curve_edges : ndarray of int64, shape (n_edge, 2)
    n_patch : int
    """

    sources: Sequence[TriSurface]
    origin: np.ndarray
    local: np.ndarray
    triangles: np.ndarray
    surface_of_triangle: np.ndarray
    parent_of_triangle: np.ndarray
    patch_of_triangle: np.ndarray
    curve_edges: np.ndarray
    n_patch: int

    @classmethod
    def all_of(cls, patches: Patches) -> Listed:
        """Every triangle of some patches."""
        return cls(
            patches.sources, patches.origin, patches.local, patches.triangles,
            patches.surface_of_triangle, patches.parent_of_triangle, patches.patch_of_triangle,
            patches.curve_edges, patches.n_patch,
        )  # fmt: skip

    @classmethod
    def without_runs(cls, patches: Patches) -> Listed:
        """The triangles that are listed already; parents in a grid are keys, not rows.

        Of torn sheets they are rows.
        """
        pieces = patches.pieces
        parent = pieces.key.copy()
        cut = np.searchsorted(pieces.surface, np.arange(len(patches.sources) + 1))
        for i, source in enumerate(patches.sources):
            if isinstance(source.lattice, TornLattice):
                mine = slice(cut[i], cut[i + 1])
                parent[mine] = source.rows_of_keys(parent[mine])
        return cls(
            patches.sources, patches.origin, pieces.x, pieces.triangles, pieces.surface,
            parent, pieces.patch[: len(pieces.triangles)], patches.curve_edges, patches.n_patch,
        )  # fmt: skip

    @cached_property
    def _first(self) -> list[int]:
        return np.searchsorted(self.surface_of_triangle, np.arange(len(self.sources) + 1)).tolist()

    def rows(self, surface: int) -> slice:
        """The triangles of a surface: they follow each other."""
        return slice(self._first[surface], self._first[surface + 1])

    def sheet(self, surface: int) -> SheetFaces:
        """The triangles of a torn sheet that have parts here, without a list of all."""
        known = self._sheets.get(surface)
        if known is not None:
            return known
        source, parent = self.sources[surface], self.parent_of_triangle[self.rows(surface)]
        used, row = number_keys(parent)
        if source.lattice is None:
            corners = source.corners_of_keys(used)
        else:  # parents are rows
            nodes = source.lattice.corners_of_keys(source.lattice.keys_of_rows(used))
            corners = source.lattice.vertex_of_node.ravel()[nodes]
        vertex, number = number_keys(corners.ravel())
        node = vertex
        if isinstance(source.lattice, TornLattice):
            node = source.lattice.node_of_vertex[vertex]
        faces = SheetFaces(
            row, number.reshape(-1, 3), source.places_of_nodes(node), vertex,
        )  # fmt: skip
        self._sheets[surface] = faces
        return faces

    @cached_property
    def _sheets(self) -> dict[int, SheetFaces]:
        return {}

    @cached_property
    def is_fault(self) -> np.ndarray:
        """Whether each surface is a fault, bool (n_surface,)."""
        return np.array([source.role == "fault" for source in self.sources], dtype=bool)

    @cached_property
    def on_fault(self) -> np.ndarray:
        """Vertices on any fault: there a sheet may end, bool (n_vertex,)."""
        at_fault = np.zeros(len(self.local), dtype=bool)
        for i in np.flatnonzero(self.is_fault).tolist():
            at_fault[self.triangles[self.rows(i)]] = True
        return at_fault

    @cached_property
    def at_curves(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Half-edges on curves: number of the curve edge, triangle; and whether a fault is there.

        The third is by curve edge.
        """
        edge, triangle = sides_of_edges(self.triangles, self.curve_edges, len(self.local))
        fault = np.zeros(len(self.curve_edges), dtype=bool)
        fault[edge[self.is_fault[self.surface_of_triangle[triangle]]]] = True
        return edge, triangle, fault


# ---- wall sides ----------------------------------------
# On which side of a fault a part of a torn sheet lies, and on which it belongs.
#
# A sheet that was moved by throw states the wall of each vertex (``vertex_data["wall of F1"]``: 1
# in the hanging wall, the front of the fault; -1 in the footwall). Where two faults cross close
# to a horizon, the piece of one wedge may lie in another one. It is cut there like any other, and
# may reach the next fault without an outer vertex.


WALL = "wall of "  # before the name of the fault


def on_wrong_side(mesh: Listed, surface: int, part_of: np.ndarray) -> np.ndarray:
    """
    Return which parts of a sheet lie on the other side of a fault than their vertices belong to.

    Parameters
    ----------
    mesh : Listed
    surface : int
        Row of its sources. Without walls of vertices no part is on a wrong side.
    part_of : ndarray of int64, shape (n_patch,)
        Part of each patch of the sheet; as many as there are patches, at most.

    Returns
    -------
    ndarray of bool, shape (n_patch,)
    """
    source, (edge, triangle, _) = mesh.sources[surface], mesh.at_curves
    wrong = np.zeros(len(part_of), dtype=bool)
    faults = [k for k, other in enumerate(mesh.sources)
              if other.role == "fault" and WALL + other.name in source.vertex_data]  # fmt: skip
    if not faults:
        return wrong
    frame = frame_of(mesh.local)
    part = part_of[mesh.patch_of_triangle]
    sheet, parent = mesh.sheet(surface), np.zeros(len(part), dtype=np.int64)
    parent[mesh.rows(surface)] = sheet.parent
    for k in faults:
        # a part has to be on its own side of each fault; slivers may be turned over by rounding,
        # so that the longer part of its edges decides
        wall = source.vertex_data[WALL + mesh.sources[k].name][sheet.vertex].astype(np.int64)
        balance = balance_at_fault(
            mesh.local, mesh.triangles, mesh.curve_edges, edge, triangle, mesh.surface_of_triangle,
            part, parent, wall, sheet.faces, surface, k, len(part_of), *frame,
        )  # fmt: skip
        wrong |= balance < 0.0
    return wrong


def trim_sheets(patches: Patches) -> Patches:
    """
    Drop the parts of torn sheets that lie beyond their faults.

    Parameters
    ----------
    patches : Patches
        From `rebuild_surfaces`, with all faults that tear the sheets.

    Returns
    -------
    Patches
        The same without those triangles; ``report["dropped_area"]`` has their area by surface
        [m2]. Without torn sheets the patches come back unchanged.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> corners = [[0, 0, 0], [9, 0, 0], [0, 9, 0]]
    >>> beyond = [False, True, False]
    >>> marks = {"ghost": beyond, "outer": beyond}
    >>> sheet = TriSurface("Top", "horizon", corners, [[0, 1, 2]], vertex_data=marks)
    >>> fault = TriSurface("F1", "fault", [[3, -9, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> trim_sheets(rebuild_surfaces([sheet, fault])).surface("Top").bounds
    (0.0, 3.0, 0.0, 9.0, 0.0, 0.0)
    """
    expect(patches, Patches, "trim_sheets takes Patches", "pass the result of rebuild_surfaces")
    sheets = [source for source in patches.sources if "ghost" in source.vertex_data]
    if not sheets:
        return patches

    # of other grids all triangles are looked at
    lattices = [sheet.lattice for sheet in sheets]
    if not all(lattice is None or isinstance(lattice, TornLattice) for lattice in lattices):
        return drop_triangles(patches, kept_parts(patches)[0])
    mesh = Listed.without_runs(patches)
    has_runs = np.zeros(mesh.n_patch, dtype=bool)
    has_runs[patches.pieces.patch[len(mesh.triangles) :]] = True
    keep = np.ones(mesh.n_patch, dtype=bool)
    for i, joined, stays in _parts_of_sheets(mesh, None, has_runs):
        mine = mesh.patch_of_triangle[mesh.rows(i)]
        keep[mine] = stays[joined[mine]]
    return drop_patches(patches, mesh, keep)


def kept_parts(patches: Patches) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which triangles stay; corners that are corners of their parents; and parts of torn sheets.

    The second is (n_triangle, 3): the vertex of the source, or -1 for a point that was made.
    The third numbers what only faults part, -1 for other surfaces.
    """
    mesh = Listed.all_of(patches)
    keep = np.ones(patches.n_triangle, dtype=bool)
    corner = np.full((patches.n_triangle, 3), -1)
    part = np.full(patches.n_triangle, -1)
    for i, joined, stays in _parts_of_sheets(mesh, corner):
        rows = mesh.rows(i)
        part[rows] = joined[mesh.patch_of_triangle[rows]]
        keep[rows] = stays[part[rows]]
    return keep, corner, part


def _parts_of_sheets(
    mesh: Listed, corner: np.ndarray | None, has_runs: np.ndarray | None = None
) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Of each torn sheet its row, the part of each patch, and which parts stay.

    Writes `corner` (n_triangle, 3), if it is given: the vertex of the sheet at each corner.
    Patches that have runs, if these are given, hold data: no ghost is in a run.
    """
    parts = []
    for i, source in enumerate(mesh.sources):
        ghost = source.vertex_data.get("ghost")
        if ghost is None:
            continue

        # Parts between faults; a part is dropped if it lies beyond one or has no data.
        rows = mesh.rows(i)
        joined = join_past_others(
            *mesh.at_curves, mesh.surface_of_triangle, mesh.patch_of_triangle,
            mesh.parent_of_triangle, i, mesh.n_patch,
        )  # fmt: skip
        named = np.empty((0, 3), dtype=np.int64) if corner is None else corner[rows]
        sheet = mesh.sheet(i)
        held, beyond = classify_parts(
            mesh.local, mesh.triangles[rows], sheet.parent, sheet.faces, sheet.places,
            mesh.origin, mesh.on_fault, ghost[sheet.vertex],
            source.vertex_data["outer"][sheet.vertex], mesh.patch_of_triangle[rows], joined,
            named,
        )  # fmt: skip
        if corner is not None:
            named[:] = np.where(named >= 0, sheet.vertex[named], -1)
        if has_runs is not None:
            held[joined[has_runs]] = True
        wrong = on_wrong_side(mesh, i, joined)
        parts.append((i, joined, held & ~beyond & ~wrong))
    return parts


# ---- patches without some of their triangles: vertices, curves and patches numbered again ----


def drop_triangles(patches: Patches, keep: np.ndarray) -> Patches:
    """
    Return patches without some triangles, with vertices, curves and patches numbered again.

    Parameters
    ----------
    patches : Patches
    keep : ndarray of bool, shape (n_triangle,)

    Returns
    -------
    Patches
        ``report["dropped_area"]`` has the area of what is gone by surface [m2], with what was gone
        before.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [8, 0, 0], [0, 8, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[4, -9, -9], [4, 9, -9], [4, 4, 9]], [[0, 1, 2]])
    >>> patches = rebuild_surfaces([flat, wall])
    >>> keep = (patches.local[patches.triangles][:, :, 2] <= 0).all(axis=1)
    >>> drop_triangles(patches, keep).surface("F1").bounds[4:]
    (-9.0, 0.0)
    """
    mesh = Listed.all_of(patches)
    joined, curve = _without(mesh, keep)
    label = joined[patches.patch_of_triangle[keep]]

    # Patches are numbered by their first triangle.
    _, at, patch = np.unique(label, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(at))

    used = np.zeros(len(patches.local), dtype=bool)
    used[patches.triangles[keep]] = True
    number = np.cumsum(used) - 1
    return patches.changed(
        local=frozen(patches.local[used], np.float64),
        triangles=frozen(number[patches.triangles[keep]], np.int64),
        surface_of_triangle=frozen(patches.surface_of_triangle[keep], np.int64),
        parent_of_triangle=frozen(patches.parent_of_triangle[keep], np.int64),
        patch_of_triangle=frozen(rank[patch], np.int64),
        curve_edges=frozen(number[curve], np.int64),
        report=_with_area(patches.report, _areas(mesh, np.flatnonzero(~keep))),
    )


def drop_patches(patches: Patches, mesh: Listed, keep: np.ndarray) -> Patches:
    """
    Return patches without some of them, as `drop_triangles` does, without a list of all triangles.

    Other runs of grids stay runs, and rings of half-edges stay without those that are dropped.

    Parameters
    ----------
    patches : Patches
    mesh : Listed
        Its listed triangles.
    keep : ndarray of bool, shape (n_patch,)
    """
    pieces = patches.pieces
    if patches.report.get("rounding_collisions"):
        # triangles that rounding has made equal are not known as such
        return drop_triangles(patches, keep[patches.patch_of_triangle])
    stays = keep[mesh.patch_of_triangle]
    joined, curve = _without(mesh, stays)

    # patches are numbered by their first triangle: a joined one by the lowest that it is made of
    kept = np.flatnonzero(keep)
    first = np.full(int(joined.max(initial=-1)) + 1, mesh.n_patch)
    np.minimum.at(first, joined[kept], kept)
    rank = np.argsort(np.argsort(first, kind="stable"), kind="stable")
    patch_of = rank[joined]

    triangles, surface, key, patch, ring, link, number = kept_triangles(
        stays, mesh.triangles, pieces.surface, pieces.key, mesh.patch_of_triangle, patch_of,
        pieces.ring, pieces.link, len(mesh.local),
    )  # fmt: skip

    # runs of what is dropped go; what is behind the others' edges gets their new numbers
    patch_of_run = pieces.patch[len(mesh.triangles) :]
    run_stays = keep[patch_of_run]
    strips = [
        None if one is None else _numbered(one.without(~run_stays[first:last]), number)
        for one, (first, last) in zip(pieces.strips, pairwise(pieces.first_run), strict=True)
    ]
    number_of_run = np.concatenate([[0], np.cumsum(run_stays)])
    behind = np.flatnonzero(link >= 0)
    link[behind] = number_of_run[link[behind]]
    made = replace(
        pieces,
        x=mesh.local.take(np.flatnonzero(number >= 0), axis=0),
        triangles=triangles,
        surface=surface,
        key=key,
        twin=_twins_among(pieces.twin, stays),
        ring=ring,
        link=link,
        strips=strips,
        first_run=number_of_run[pieces.first_run],
        patch=np.concatenate([patch, patch_of[patch_of_run[run_stays]]]),
    )
    areas = _areas(mesh, np.flatnonzero(~stays))
    for i, more in _areas_of_runs(pieces, ~run_stays).items():
        areas[i] = np.concatenate([areas.get(i, more[:0]), more])
    return Patches.of_pieces(made, number[curve], _with_area(patches.report, areas))


def _twins_among(twin: np.ndarray, stays: np.ndarray) -> np.ndarray:
    """The first triangle with the same corners among those that stay, bool (n_triangle,)."""
    if not len(twin):
        return twin
    rows = np.flatnonzero(stays)
    first = np.full(len(twin), len(twin))
    np.minimum.at(first, twin[rows], np.arange(len(rows)))
    return first[twin[rows]]


def _numbered(strips: Strips, number: np.ndarray) -> Strips:
    """Strips with the new numbers of points; a node whose triangles are gone has none."""
    points = number.take(strips.points)
    stays = np.flatnonzero(points >= 0)
    return replace(strips, nodes=strips.nodes.take(stays), points=points.take(stays))


def _without(mesh: Listed, keep: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A label of each patch, the same where they become one; and the edges that stay curves."""
    # What is left at each curve edge, the surfaces in order.
    edge, triangle, _ = mesh.at_curves
    edge, triangle = edge[keep[triangle]], triangle[keep[triangle]]
    order = np.lexsort((mesh.surface_of_triangle[triangle], edge))
    edge, triangle = edge[order], triangle[order]

    first = np.flatnonzero(np.diff(edge, prepend=-1))
    numbers, times = edge[first], np.diff(first, append=len(edge))
    surface = mesh.surface_of_triangle[triangle]
    last = first + times - 1
    plain = (times <= 2) & (surface[first] == surface[last])
    # patches on both sides of an edge that has ceased to be a curve become one
    inner = plain & (times == 2)

    links = mesh.patch_of_triangle[np.column_stack([triangle[at[inner]] for at in (first, last)])]
    return join_pairs(links, mesh.n_patch), mesh.curve_edges[numbers[~plain]]


def _with_area(report: Mapping[str, Any], areas: Mapping[int, np.ndarray]) -> dict[str, Any]:
    """A report with the areas that were dropped before and now, by surface [m2].

    `areas` has those of the triangles that are dropped now.
    """
    before: Mapping[int, float] = report.get("dropped_area", {})
    now = {i: math.fsum(of) for i, of in areas.items()}  # does not depend on the order
    added = {i: before.get(i, 0.0) + now.get(i, 0.0) for i in sorted({*before, *now})}
    return {**report, "dropped_area": added}


def _areas(mesh: Listed, rows: np.ndarray) -> dict[int, np.ndarray]:
    """Areas of some triangles, by surface [m2]."""
    area = _area(mesh.local[mesh.triangles[rows]])
    surface = mesh.surface_of_triangle[rows]
    return {i: area[surface == i] for i in distinct(surface).tolist()}


def _areas_of_runs(pieces: Pieces, gone: np.ndarray) -> dict[int, np.ndarray]:
    """Areas of the triangles of some runs, bool (n_run,), by surface [m2]."""
    areas = {}
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        runs = np.flatnonzero(gone[pieces.first_run[i] : pieces.first_run[i + 1]])
        if strips is None or not len(runs):
            continue
        assert source.lattice is not None  # only lattices have strips
        nodes = source.lattice.corners_of_keys(strips.keys_of(runs)[0])
        places = source.places_of_nodes(nodes.ravel()) - pieces.origin
        areas[i] = _area(places.reshape(-1, 3, 3))
    return areas


def _area(corners: np.ndarray) -> np.ndarray:
    """Areas (n,) of triangles with some corners (n, 3, 3) [m2]."""
    # half the norm of the cross product of two sides
    a, b, c = corners.transpose(1, 0, 2)
    (ux, uy, uz), (vx, vy, vz) = (b - a).T, (c - a).T
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return 0.5 * np.sqrt(x * x + y * y + z * z)


# ---- moves ----------------------------------------
# Warn of input vertices that a repair moved.


_REPORTED = 1e-6  # metres: smaller moves are below any measurement; most repairs move by 2 nm


def warnings_of_moves(given: Sequence[TriSurface], patches: Patches) -> tuple[GeosurfWarning, ...]:
    """
    Return a warning if a repair moved input vertices, because rounding would break triangles.

    Parameters
    ----------
    given : sequence of TriSurface
        Input surfaces of the rebuild.
    patches : Patches

    Returns
    -------
    tuple of GeosurfWarning
        At most one, for moves of more than 1 micrometre, with the place of the largest move.
        ``patches.report`` has all moves.
    """
    if patches.report["largest_move"] <= _REPORTED:
        return ()

    names, far, place = [], 0.0, None
    for old, new in zip(given, patches.sources, strict=True):
        before = old.vertices
        steps = np.linalg.norm(new.vertices - before, axis=1)
        if not steps.any():
            continue
        names.append(old.name)
        row = int(steps.argmax())
        if steps[row] > far:
            far, place = float(steps[row]), before[row]

    n = patches.report["moved_vertices"]
    count = "1 vertex" if n == 1 else f"{n} vertices"
    listed = ", ".join(repr(name) for name in names[:4]) + (" and others" if len(names) > 4 else "")
    warning = GeosurfWarning(
        "moved",
        names[0],
        f"{count} of {listed} moved by up to {far:.1e} m: surfaces almost touch there, "
        "and float64 cannot represent the exact result.",
        "To avoid this, round the coordinates of these surfaces and of the box: "
        "np.round(x * 1024) / 1024.",
        place,
    )
    return (warning,)
