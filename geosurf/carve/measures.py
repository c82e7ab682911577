"""Compute volume below, area and bounds of faces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.conventions import grouped
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
    parts = list(_runs(pieces, face, asked))
    height = level + pieces.origin[2]

    def of_triangles(*some: np.ndarray) -> None:
        """Add triangles that share no face with others."""
        kernels.volume_below_triangles(pieces.x, *some, asked, level, found)

    def of_runs(lattice: Lattice, runs: np.ndarray, _: np.ndarray) -> np.ndarray:
        """Volume below each run and its map area (n_run, 3)."""
        return kernels.volume_below_runs(*lattice.coordinates, lattice.places, runs, height)

    tasks: list[tuple[Callable[[], Any]]]
    tasks = [(partial(of_triangles, *some),) for some in _triangles(pieces, face)]
    tasks += [(partial(of_runs, *part),) for part in parts]
    worth = bool(pieces.first_run[-1] > _MANY_RUNS)
    sums = map_threads(lambda task: task(), tasks, worth=worth)[len(tasks) - len(parts) :]
    for (lattice, _, of), one in zip(parts, sums, strict=True):
        kernels.add_runs(lattice.places, one, of, found)
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
        kernels.volume_beside_triangles(
            pieces.x, pieces.triangles[i:j], face[i:j], asked, level, found
        )
        height = level + pieces.origin[2]
        for lattice, some, of in runs:
            kernels.volume_beside_runs(
                *lattice.coordinates, lattice.places, some, of, height, found
            )

    # surfaces have no face in common, so that each is a task
    of_surface = grouped((int(surface[run[2][0]]), run) for run in _runs(pieces, face, asked))
    rows = [(*row, of_surface.get(one, ())) for one, row in zip(wanted.tolist(), ends, strict=True)]
    map_threads(add, rows, worth=sum(j - i for i, j in ends) > _TRIANGLES)
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


# ---- volume ----------------------------------------
# Compute the volume inside a closed shell by the divergence theorem, exactly if required.


# units in the last place, times half the surface of the box: what rounding may do to prisms as high
# as the box, with room to spare
_DOUBT = 64.0
_HIGH, _LEAST = 300, 5e-324  # exponent of the largest coordinate; the least number above 0
_SPLIT = 2.0**27 + 1.0


def volume_of(local: np.ndarray, triangles: np.ndarray) -> float:
    """
    Volume inside a closed shell, by compensated sums around its middle.

    Parameters
    ----------
    local : ndarray of float64, shape (n_vertex, 3)
        [m]
    triangles : ndarray of int64, shape (n_triangle, 3)
        Turned outward.

    Returns
    -------
    float
        [m3]

    Examples
    --------
    >>> corner = np.array([[0.0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]])
    >>> volume_of(corner, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
    36.0
    """
    a, b, c = (local[triangles[:, k]] for k in range(3))
    low = np.min([p.min(axis=0, initial=np.inf) for p in (a, b, c)], axis=0)
    high = np.max([p.max(axis=0, initial=-np.inf) for p in (a, b, c)], axis=0)
    middle = 0.5 * (low + high)
    # by sides, which are short: products of whole radii would lose digits
    x, y, z = normals(b - a, c - a)
    a = a - middle
    return math.fsum((a[:, 0] * x + a[:, 1] * y + a[:, 2] * z).tolist()) / 6.0


def normals(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Components of the cross products of rows (n, 3): in a third of the time of `numpy.cross`."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def doubtful_volume(bounds: np.ndarray) -> float:
    """Volumes up to this one are summed up exactly in a box with these bounds (2, 3) [m3].

    Examples
    --------
    >>> doubtful_volume(np.array([[0.0, 0, 0], [1, 1, 1]])) == 192 * 2.0**-52
    True
    """
    east, north, up = (bounds[1] - bounds[0]).tolist()
    step = float(np.spacing(np.abs(bounds).max()))
    return _DOUBT * step * (east * north + north * up + up * east)


def exact_volume(local: np.ndarray, triangles: np.ndarray) -> float:
    """
    Volume inside a closed shell, the exact sum of its corners, rounded once.

    For shells that are thinner than what rounding does to a sum. Its sign is exact, too.

    Parameters
    ----------
    local : ndarray of float64, shape (n_vertex, 3)
        [m]
    triangles : ndarray of int64, shape (n_triangle, 3)
        Turned outward.

    Returns
    -------
    float
        [m3]; never 0 if the volume is not.

    Notes
    -----
    Each product of three coordinates is the sum of four doubles (Dekker 1971), and `math.fsum`
    adds all of them without error (Shewchuk 1997).

    Examples
    --------
    A needle far from the origin, one unit in the last place wide:

    >>> e = 2.0**-33
    >>> needle = np.array([[0, 0, 0], [e, 0, 0], [0, e, 0], [0, 0, 9]]) + 1e6
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    >>> exact_volume(needle, faces) == 1.5 * e * e
    True
    """
    largest = float(np.abs(local).max(initial=0.0))
    if largest == 0.0:
        return 0.0
    # products of the largest neither overflow, nor do those of its last digits vanish
    power = _HIGH - math.frexp(largest)[1]
    x = np.ldexp(local, power)
    a, b, c = (x[triangles[:, k]] for k in range(3))
    terms: list[np.ndarray] = []
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        for q, r, sign in ((j, k, 1.0), (k, j, -1.0)):
            high, low = _product(b[:, q], c[:, r])
            for part in (high, low):
                terms += _product(sign * a[:, i], part)
    total = math.fsum(np.concatenate(terms).tolist()) / 6.0
    volume = math.ldexp(total, -3 * power)
    return volume if volume or not total else math.copysign(_LEAST, total)


def _halves(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each double as the sum of two of half as many digits (Veltkamp)."""
    c = _SPLIT * a
    high = c - (c - a)
    return high, a - high


def _product(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The product of doubles, and all that rounding took from it."""
    product = a * b
    (p, q), (r, s) = _halves(a), _halves(b)
    return product, q * s - (((product - p * r) - q * r) - p * s)
