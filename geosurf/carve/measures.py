"""Compute volume, area and bounds of faces."""

from __future__ import annotations

import math

import numpy as np

from geosurf.arrangement.threads import map_threads
from geosurf.kernels.meshes import volumes as kernels
from geosurf.model.pieces import Pieces

_ELEMENTS = 1000  # triangles and runs from which threads are worth it

# columns of `sums`, see `geosurf.kernels.meshes.volumes`: volumes and areas are two numbers each,
# and that of a whole face four
ABOVE, BELOW = (slice(k, k + 2) for k in (kernels.ABOVE, kernels.BELOW))
VOLUME, FLAT = slice(kernels.ABOVE, kernels.FLAT), kernels.FLAT
AREA = slice(kernels.AREA, kernels.AREA + 2)
LOWER, UPPER = slice(kernels.LOWER, kernels.UPPER), slice(kernels.UPPER, kernels.UPPER + 3)
LOOKS_UP = slice(kernels.LOOKS_UP, kernels.LOOKS_UP + 2)
LOOKS_DOWN = slice(kernels.LOOKS_DOWN, kernels.LOOKS_DOWN + 2)


def sums(pieces: Pieces, face: np.ndarray, asked: np.ndarray, level: float) -> np.ndarray:
    """
    Volume, area and bounds of faces.

    Parameters
    ----------
    pieces : Pieces
    face : ndarray of int64, shape (n_element,)
        Face that each element (triangle, then run) belongs to; -1 for none.
    asked : ndarray of bool, shape (n_face,)
        Faces that are measured; rows of others mean nothing.
    level : float
        Local elevation from which volumes are measured [m]; best amid what is measured.

    Returns
    -------
    ndarray of float64, shape (n_face, N_SUM)
        Six times the volume between a face and the level, above it and below it; twice the area in
        the map; area [m2], lower and upper corner, local [m]; twice the area in the map of
        triangles that look up, and of those that look down. Where fronts look up, the first of
        these is above 0 and the second below 0.
    """
    totals = np.zeros((len(asked), kernels.N_SUM))
    totals[:, LOWER], totals[:, UPPER] = np.inf, -np.inf
    n, is_asked = len(pieces.triangles), np.append(asked, False)[face]  # the last: no face
    cut = np.searchsorted(pieces.surface, np.arange(len(pieces.sources) + 1)).tolist()

    def add(i: int) -> None:
        """Add the triangles of a surface, then its runs."""
        some = slice(cut[i], cut[i + 1])
        kernels.add_triangles(pieces.x, pieces.triangles[some], face[some], asked, level, totals)
        strips, lattice = pieces.strips[i], pieces.sources[i].lattice
        if strips is not None and lattice is not None:
            run_rows = slice(n + pieces.first_run[i], n + pieces.first_run[i + 1])
            rows = np.flatnonzero(is_asked[run_rows])
            kernels.add_runs(
                *lattice.coordinates, lattice.places, strips.runs[rows], face[run_rows][rows],
                pieces.origin, level, totals,
            )  # fmt: skip

    # surfaces have no face in common, so that each is a task
    map_threads(add, [(i,) for i in range(len(pieces.sources))], worth=len(face) > _ELEMENTS)
    return totals


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
