"""Join sides of triangles that face the same cell across an edge.

An element is a triangle, or a run of triangles that no curve touches. A part is what hangs together
over edges inside of one surface, facing one way, so that all of it sees the same: part p sees
2 p in front of it, where normals point, and 2 p + 1 behind.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.carve.seams import Parents, edges_at, sorted_seams
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.lattices.strips import RIM, lowest_keys
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.kernels.meshes.parts import parts_of
from geosurf.kernels.meshes.seams import join_seams
from geosurf.model import Patches
from geosurf.model.pieces import Pieces

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
        nodes = source.corners_of_keys(keys).ravel()
        corners.append((source.places_of_nodes(nodes) - pieces.origin).reshape(-1, 3, 3))
    return np.concatenate(corners)


def joined_sides(
    patches: Patches, pieces: Pieces, parts: Parts
) -> tuple[np.ndarray, np.ndarray, Parents]:
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
    Parents

    Raises
    ------
    InvariantError
        If two different triangles lie in one half-plane of an edge.
    """
    open_at = edges_at(pieces.triangles, pieces.ring, pieces.link, parts.of_element)
    first = parts.first[: np.searchsorted(parts.first, len(pieces.triangles))]
    start, seams, parents = sorted_seams(patches, pieces, parts.of_element, first, open_at)
    return *_joined(pieces, parts, start, seams), parents


def _joined(
    pieces: Pieces, parts: Parts, start: np.ndarray, seams: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What is seen from the front and the back of each part, and its connected piece."""
    # parts are few: each range of edges joins all of them for itself
    n, rows = len(parts.first), in_ranges(len(start) - 1, _SEAMS)
    forests = [(np.arange(2 * n), np.arange(n)) for _ in rows]
    of = parts.of_element
    map_threads(
        join_seams,
        [(start[i : j + 1], seams, of, *own) for (i, j), own in zip(rows, forests, strict=True)],
    )

    # the rim of a surface inside the model: front and back see each other around it
    torn = _with_rims(pieces, parts)
    sides = [np.stack([2 * torn + 1, 2 * torn], axis=1)]
    sides += [np.stack([np.arange(2 * n), own], axis=1) for own, _ in forests]
    piece = [np.stack([np.arange(n), own], axis=1) for _, own in forests]
    seen = join_pairs(np.concatenate(sides), 2 * n)
    return seen.reshape(-1, 2), join_pairs(np.concatenate(piece), n)


def _with_rims(pieces: Pieces, parts: Parts) -> np.ndarray:
    """Parts with a run on the rim of a surface, around which front and back see the same."""
    rims = [strips.runs[:, RIM] for strips in pieces.strips if strips is not None]
    if not rims:
        return np.empty(0, dtype=np.int64)
    of_run = parts.of_element[len(pieces.triangles) :][np.concatenate(rims) == 1]
    return distinct(of_run[of_run >= 0])
