"""The checks of a certificate from all triangles, with what is wrong and where."""

from __future__ import annotations

import itertools
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from geosurf.arrangement.crossing import crossing_pairs
from geosurf.carve.certificate.checks import (
    CROSSES,
    EPS,
    SHARED,
    Size,
    areas_agree,
    beside_parents,
    crosses_not,
    graphs_of,
    shared_in_words,
    surely_exact,
)
from geosurf.carve.certificate.lines import Half, lines_of, lines_of_units
from geosurf.carve.certificate.partition import matched, numbered
from geosurf.carve.volume import exact_volume
from geosurf.conventions import place
from geosurf.kernels.meshes.parent_checks import copies_of_parents
from geosurf.kernels.meshes.shells import count_open_edges, sums_of_triangles
from geosurf.model import Check, Patches, Units

if TYPE_CHECKING:
    from concurrent.futures import Executor


def checks_by_triangles(
    patches: Patches, units: Units | None = None, spare: Executor | None = None
) -> list[Check]:
    """Check all triangles of shells and of the mesh; threads of `spare` take a part of it."""
    # both halves use these arrays: they are listed once, before threads start
    _ = patches.local, patches.triangles, patches.surface_of_triangle, patches.parent_of_triangle
    halves: list[Half] = [partial(_checks_of_mesh, patches)]
    if units is not None:
        halves.insert(0, partial(_checks_of_units, patches, units))
    return lines_of(halves, spare) or []


def _checks_of_units(patches: Patches, units: Units) -> list[Check]:
    """Checks that read shells, not the cells that carving used."""
    x, number = numbered(patches, units)
    found = matched(patches, units, number)
    anew = _sizes(patches, units)
    edges = {name: open_edges(unit.triangles) for name, unit in units.items()}
    shared = _shared_vertices(patches, units, x, number)

    parts = None
    if units.unmerged is not None:
        parts = matched(patches, units.unmerged, numbered(patches, units.unmerged)[1])
    return lines_of_units(patches, patches, units, edges, anew, shared, found, parts)


def _checks_of_mesh(patches: Patches) -> list[Check]:
    """Checks of the rebuilt mesh; copies of input triangles are set apart once for three."""
    new = _new_triangles(patches)
    return [
        _nothing_crosses(patches, new[0]),
        *beside_parents(patches.local, [(patches.triangles[new[0]], new[1])], patches.origin),
        _areas(patches),
    ]


def open_edges(triangles: np.ndarray) -> tuple[int, int]:
    """Count open edges (more triangles on one side than on the other), and the Euler number."""
    # vertices - edges + triangles: 2 for a ball, 2 - 2 k for a body with k handles
    n_open, n_edge, n_vertex = count_open_edges(triangles, int(triangles.max(initial=0)) + 1)
    return n_open, n_vertex - n_edge + len(triangles)


def _sizes(patches: Patches, units: Units) -> dict[str, Size]:
    """Sizes of shells; volumes that are small compared with the box are exact."""
    small, found = surely_exact(patches), {}
    for name, unit in units.items():
        volume, area, products, _ = sums_of_triangles(unit.local, unit.triangles)

        # sums of pyramids are good to a part of the whole box; volumes near that error are exact
        if volume <= small:
            volume = exact_volume(unit.local, unit.triangles)
        found[name] = Size(volume, area, 16 * EPS * products)
    return found


def _shared_vertices(patches: Patches, units: Units, x: np.ndarray, number: np.ndarray) -> Check:
    """Each corner of a shell is a vertex of the patches, bit for bit."""
    parts = [unit.local for unit in units.values()]
    n_local = len(patches.local)

    # lowest row of each number: that of a vertex of the patches, if one is there
    first = np.empty(int(number.max(initial=-1)) + 1, dtype=np.int64)
    first[number[::-1]] = np.arange(len(x))[::-1]

    # compared as integers: 0.0 and -0.0 are equal numbers, but not the same bytes
    same = x.view(np.int64)[n_local:] == x.view(np.int64)[first[number[n_local:]]]
    known = (first[number[n_local:]] < n_local) & same.all(axis=1)
    ends = np.cumsum([0] + [len(part) for part in parts])
    of = zip(units, itertools.pairwise(ends.tolist()), strict=True)
    foreign = [name for name, (start, stop) in of if not known[start:stop].all()]
    n = np.count_nonzero(np.bincount(number[n_local:]))
    detail = shared_in_words(n)
    if foreign:
        detail = f"corners of {', '.join(foreign[:8])} are not vertices of the surfaces"
    return Check(SHARED, not foreign, float(len(foreign)), detail)


def _nothing_crosses(patches: Patches, new: np.ndarray) -> Check:
    """Triangles meet only in shared corners and edges: an exact test of all pairs.

    Two triangles of one grid need no test if none of its cells folds over on the map: all its
    triangles lie side by side there.
    """
    triangles = patches.triangles

    # the test of other pairs takes a third of the time of a test of all
    bad = crossing_pairs(patches.local, triangles, graph=graphs_of(patches, new))
    if len(bad) == 0:
        return crosses_not(len(triangles))
    one, two = (patches.names[patches.surface_of_triangle[i]] for i in bad[0])
    where = place(patches.vertices[triangles[bad[0, 0], 0]])
    detail = f"{len(bad)} pairs of triangles cross, the first of {one!r} and {two!r} at {where}"
    if one == two:
        detail += "; the surface crosses itself: rebuild with self_intersections=True"
    return Check(CROSSES, False, float(len(bad)), detail)


def _new_triangles(patches: Patches) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the triangles that are not copies of their input triangle, and its corners (n, 3, 3).

    Copies need no check: they have the same bits.
    """
    rows, corners = [np.empty(0, dtype=np.int64)], [np.empty((0, 3, 3))]
    for i, source in enumerate(patches.sources):
        mine = np.flatnonzero(patches.surface_of_triangle == i)
        parent = patches.parent_of_triangle[mine]

        # copies have the corners of their parent, perhaps from another corner on
        of = source.vertices[source.triangles[parent]] - patches.origin
        copied = copies_of_parents(patches.local, patches.triangles[mine], of.reshape(-1, 9))
        rows.append(mine[~copied])
        corners.append(of[~copied])
    return np.concatenate(rows), np.concatenate(corners)


def _areas(patches: Patches) -> Check:
    """The parts of each surface have its area, within the rounding error of their corners."""
    found = []
    for i, source in enumerate(patches.sources):
        mine = patches.surface_of_triangle == i
        _, area, _, rim = sums_of_triangles(patches.local, patches.triangles[mine])
        before = sums_of_triangles(source.vertices - patches.origin, source.triangles)[1]
        found.append((area, before, rim))
    return areas_agree(patches, found, float(np.abs(patches.local).max(initial=0.0)))
