"""Compute volume below, area and bounds of faces."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.kernels.meshes import level_volumes
from geosurf.kernels.meshes import volumes as kernels
from geosurf.model import Lattice
from geosurf.model.pieces import Pieces

# columns of `below`: six times the volume as two numbers, twice the area in the map
BELOW, FLAT = slice(0, 2), 2
# columns of `extent`: area as two numbers, lower and upper corner; twice the area in the map of
# triangles that look up and of those that look down, two numbers each
AREA, LOWER, UPPER = slice(0, 2), slice(2, 5), slice(5, 8)
LOOKS_UP, LOOKS_DOWN = slice(8, 10), slice(10, 12)


_MANY_RUNS = 1000  # of all lattices, from which they are summed in threads
_TRIANGLES = 50_000  # of a thread, at least: half a millisecond of work


def below(pieces: Pieces, face: np.ndarray, asked: np.ndarray, level: float) -> np.ndarray:
    """
    Volume between faces and a level.

    Parameters
    ----------
    pieces : Pieces
    face : ndarray of int64, shape (n_element,)
        Face that each element (triangle, then run) belongs to; -1 for none.
    asked : ndarray of bool, shape (n_face,)
        Faces that are measured; rows of others mean nothing.
    level : float
        Local elevation [m]; best amid what is measured.

    Returns
    -------
    ndarray of float64, shape (n_face, 3)
        Six times the volume below (two numbers, to be added), twice the area in the map; both
        below 0 where fronts look down. The volume between a triangle and a level is its area in
        the map times its mean height; over a closed shell, these add up to the volume inside.
    """
    found = np.zeros((len(asked), 3))
    first = [
        partial(kernels.volume_below_triangles, pieces.x, *some, asked, level, found)
        for some in _triangles(pieces, face)
    ]
    for lattice, of, sums in _sums(pieces, face, asked, level + pieces.origin[2], first=first):
        kernels.add_runs(lattice.places, sums, of, found)
    return found


def extent(pieces: Pieces, face: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """
    Area and bounds of faces, and their areas in the map.

    Parameters
    ----------
    pieces, face, asked
        As for `below`.

    Returns
    -------
    ndarray of float64, shape (n_face, 12)
        Area (two numbers, to be added) [m2], lower and upper corner, local [m]; twice the area in
        the map of the triangles that look up, and of those that look down (two numbers each).
    """
    found = np.zeros((len(asked), 12))
    found[:, LOWER], found[:, UPPER] = np.inf, -np.inf
    map_threads(
        kernels.extent_triangles,
        [(pieces.x, *some, asked, found) for some in _triangles(pieces, face)],
    )
    for lattice, runs, of in _runs(pieces, face, asked):
        kernels.extent_runs(*lattice.coordinates, lattice.places, runs, of, pieces.origin, found)
    return found


def beside_level(
    pieces: Pieces, face: np.ndarray, asked: np.ndarray, level: float, surface: np.ndarray
) -> np.ndarray:
    """
    Volume between faces and a level, above it and below it.

    Parameters
    ----------
    pieces, face, asked
        As for `below`.
    level : float
        Local elevation [m].
    surface : ndarray of int64, shape (n_face,)
        Surface that each face is of. No triangle of others than those of `asked` is looked at.

    Returns
    -------
    ndarray of float64, shape (n_face, 4)
        Six times the volume above the level (two numbers, to be added), and below it; for fronts
        that look up, the first is positive and the second negative.
    """
    found = np.zeros((len(asked), 4))
    wanted = np.unique(surface[asked])
    ends = np.searchsorted(pieces.surface, [wanted, wanted + 1]).T.tolist()

    def add(i: int, j: int, runs: Iterable[tuple[Lattice, np.ndarray, np.ndarray]]) -> None:
        """Add triangles i to j - 1, then runs."""
        level_volumes.volume_beside_triangles(
            pieces.x, pieces.triangles[i:j], face[i:j], asked, level, found
        )
        height = level + pieces.origin[2]
        for lattice, some, of in runs:
            level_volumes.volume_beside_runs(
                *lattice.coordinates, lattice.places, some, of, height, found
            )

    # surfaces have no face in common, so that each is a task
    of_surface: dict[int, list[tuple[Lattice, np.ndarray, np.ndarray]]] = {}
    for lattice, some, of in _runs(pieces, face, asked):
        of_surface.setdefault(int(surface[of[0]]), []).append((lattice, some, of))
    rows = [(*row, of_surface.get(one, ())) for one, row in zip(wanted.tolist(), ends, strict=True)]
    map_threads(add, rows, worth=sum(j - i for i, j in ends) > _TRIANGLES)
    return found


def heights(pieces: Pieces, face: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Lowest and highest local elevation of faces, float64 (n_face, 2) [m]; as for `below`."""
    found = np.repeat([[np.inf, -np.inf]], len(asked), axis=0)
    first = [
        partial(level_volumes.heights_of_triangles, pieces.x, *some, asked, found)
        for some in _triangles(pieces, face)
    ]
    for _, of, ends in _sums(pieces, face, asked, first=first):
        level_volumes.widen_by_runs(ends, of, float(pieces.origin[2]), found)
    return found


def _triangles(pieces: Pieces, face: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """All triangles and the face of each; kernels pass over those that belong to none.

    In ranges of whole surfaces, which have no face in common: threads add up one range each.
    """
    surface = pieces.surface
    ends = [0]
    for _, end in in_ranges(len(surface), _TRIANGLES):
        if end > ends[-1]:
            ends.append(int(np.searchsorted(surface, surface[end - 1], side="right")))
    return [(pieces.triangles[i:j], face[i:j]) for i, j in pairwise(ends)]


def _sums(
    pieces: Pieces,
    face: np.ndarray,
    asked: np.ndarray,
    level: float | None = None,
    *,
    first: Sequence[Callable[[], Any]],
) -> Iterator[tuple[Lattice, np.ndarray, np.ndarray]]:
    """For each lattice the faces that its runs belong to, and what `_of_runs` finds of them.

    The tasks `first` are done before, or in other threads.
    """
    parts = list(_runs(pieces, face, asked))
    worth = bool(pieces.first_run[-1] > _MANY_RUNS)
    tasks = [*first, *(partial(_of_runs, one, runs, level) for one, runs, _ in parts)]
    found = map_threads(lambda task: task(), [(task,) for task in tasks], worth=worth)
    for (lattice, _, of), sums in zip(parts, found[len(first) :], strict=True):
        yield lattice, of, sums


def _of_runs(lattice: Lattice, runs: np.ndarray, level: float | None = None) -> np.ndarray:
    """Volume below each run and its map area (n_run, 3), without a level its heights (n_run, 2).

    A moved fault changes a few runs of each row: what the last model had of them is known.
    """
    held = lattice.__dict__.setdefault("_known_runs", {})  # with the lattice, as its tree is
    kind = "heights" if level is None else "volumes"
    before, runs0, known = held.get(
        kind, (level, runs[:0], np.empty((0, 2 if level is None else 3)))
    )
    if before != level:
        runs0, known = runs0[:0], known[:0]
    given = lattice.coordinates, lattice.places, runs
    if level is None:
        found = level_volumes.heights_of_runs(given[0][2], *given[1:], runs0, known)
    else:
        found = kernels.volume_below_runs(*given[0], *given[1:], level, runs0, known)
    if len(runs) >= len(runs0):  # else a change: the next one may be of the same scene as this
        held[kind] = level, runs, found
    return found


def _runs(
    pieces: Pieces, face: np.ndarray, asked: np.ndarray
) -> Iterator[tuple[Lattice, np.ndarray, np.ndarray]]:
    """For each lattice the runs that belong to a face that is asked for, and which."""
    of_run = face[len(pieces.triangles) :]
    is_asked = np.append(asked, False)[of_run]  # the last: no face
    for i, strips in enumerate(pieces.strips):
        if strips is not None:
            own = slice(pieces.first_run[i], pieces.first_run[i + 1])
            of, rows = of_run[own], np.flatnonzero(is_asked[own])
            if not len(rows):
                continue
            lattice = pieces.sources[i].lattice
            assert lattice is not None  # only lattices have strips
            yield lattice, strips.runs[rows], of[rows]
