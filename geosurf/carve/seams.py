"""Edges at which parts of surfaces end, and the order of the triangles around them, in threads.

Results are the same for any number of threads: each has a range of edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.conventions import place
from geosurf.errors import InvariantError
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.parts import mark_around, open_edges
from geosurf.kernels.meshes.seams import DONE, NEEDS_EXACT, sort_seams
from geosurf.model import Patches, TriSurface
from geosurf.model.pieces import Pieces

# least work of a thread, a millisecond each, which is ten times what a thread costs
_TRIANGLES, _EDGES, _PARENTS = 20_000, 5_000, 20_000


@dataclass(frozen=True, eq=False)
class Parents:
    """Input triangles that triangles around open edges, and the first of parts, are parts of.

    Attributes
    ----------
    of_triangle : ndarray of int64, shape (n_triangle,)
        -1 for other triangles.
    corners : ndarray of float64, shape (n_parent, 3, 3)
        Local coordinates.
    """

    of_triangle: np.ndarray
    corners: np.ndarray

    def __getitem__(self, triangles: np.ndarray) -> np.ndarray:
        """Corners (n, 3, 3) of the input triangles of some triangles."""
        found: np.ndarray = self.corners[self.of_triangle[triangles]]
        return found


def edges_at(
    triangles: np.ndarray,
    ring: np.ndarray,
    link: np.ndarray,
    part: np.ndarray,
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
    patches: Patches,
    pieces: Pieces,
    part: np.ndarray,
    also: np.ndarray,
    open_at: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, Parents]:
    """
    Put the triangles around some edges in order.

    Parameters
    ----------
    patches : Patches
    pieces : Pieces
    part : ndarray of int64
        As for `edges_at`.
    also : ndarray of int64
        More triangles of which the input triangles are wanted.
    open_at : ndarray of int64, shape (n_edge,)
        A half-edge of each edge.

    Returns
    -------
    start : ndarray of int64, shape (n_edge + 1,)
        First place of each edge in `seams`, and the end.
    seams : ndarray of int64
        See `geosurf.kernels.meshes.seams`.
    parents : Parents

    Raises
    ------
    InvariantError
        If two different triangles lie in one half-plane of an edge.
    """
    edges = [open_at[i:j] for i, j in in_ranges(len(open_at), _EDGES)]
    wanted = np.zeros(len(pieces.triangles), dtype=bool)
    wanted[also] = True
    counts = map_threads(mark_around, [(pieces.ring, some, wanted) for some in edges])
    parents = parents_of(pieces, wanted)
    px = parents.corners.reshape(-1, 3)
    pt = np.arange(len(px)).reshape(-1, 3)

    def sort(some: np.ndarray, n_around: int) -> tuple[int, np.ndarray, np.ndarray]:
        """What `sort_seams` finds of some edges, and what it writes."""
        start, seams = np.empty(len(some) + 1, dtype=np.int64), np.empty(n_around, dtype=np.int64)
        # floats decide nearly always; the exact frame is made when they first cannot
        m = w = np.empty(0, dtype=np.int64)
        while True:
            found = sort_seams(
                pieces.x, pieces.triangles, pieces.ring, some, part,
                parents.of_triangle, px, pt, m, w, start, seams,
            )  # fmt: skip
            if found != NEEDS_EXACT:
                return found, start, seams
            m, w = frame_of(px)

    found = map_threads(sort, list(zip(edges, counts, strict=True)))
    for done, _, _ in found:
        if done != DONE:
            name = patches.names[pieces.surface[done // 3]]
            corner = pieces.triangles[done // 3, done % 3]
            where = place(pieces.x[corner] + patches.origin)
            raise InvariantError(
                f"two triangles of surface {name!r} and another lie in one half-plane at {where}; "
                "please report this with the surfaces."
            )

    # one after the other
    ends = np.cumsum([0, *(start[-1] for _, start, _ in found)])
    starts = [start[:-1] + end for (_, start, _), end in zip(found, ends, strict=False)]
    seams = np.concatenate([seams[: start[-1]] for _, start, seams in found])
    return np.concatenate([*starts, ends[-1:]]), seams, parents


def parents_of(pieces: Pieces, wanted: np.ndarray) -> Parents:
    """Find the input triangles of the triangles that are wanted: a few around curves."""
    surface, key = pieces.surface, pieces.key

    # triangles of one input triangle follow each other
    rows = np.flatnonzero(wanted)
    is_new = np.ones(len(rows), dtype=bool)
    is_new[1:] = (key[rows[1:]] != key[rows[:-1]]) | (surface[rows[1:]] != surface[rows[:-1]])
    first, number = rows[is_new], np.full(len(key), -1, dtype=np.int64)
    number[rows] = np.cumsum(is_new) - 1
    corners = np.empty((3 * len(first), 3))
    cut = np.searchsorted(surface[first], np.arange(len(pieces.sources) + 1))

    def write(source: TriSurface, low: int, high: int) -> None:
        """Write the corners of the triangles of one surface."""
        nodes = source.corners_of_keys(key[first[low:high]]).ravel()
        places = source.places_of_nodes(nodes)
        np.subtract(places, pieces.origin, out=corners[3 * low : 3 * high])

    parts = list(zip(pieces.sources, cut[:-1].tolist(), cut[1:].tolist(), strict=True))
    map_threads(write, parts, worth=len(first) > _PARENTS)
    return Parents(number, corners.reshape(-1, 3, 3))
