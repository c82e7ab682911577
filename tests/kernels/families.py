"""Points for predicates: easy, degenerate, and degenerate up to the last bit."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np

FAMILIES = ("lattice", "nudged", "utm", "powers", "mixed", "cocircular")
_CIRCLE = np.array(
    [(x, y) for x in range(-25, 26) for y in range(-25, 26) if x * x + y * y == 625], dtype=float
)


def tuples(family: str, n: int, corners: int, dimension: int, seed: int = 0) -> np.ndarray:
    """Coordinates (n, corners, dimension) of one family."""
    rng = np.random.default_rng([seed, corners, FAMILIES.index(family)])
    shape = (n, corners, dimension)
    lattice = rng.integers(0, 4, shape).astype(float)
    if family == "lattice":
        return lattice
    if family == "nudged":
        return nudge(nearly_flat(rng, shape), rng)
    if family == "utm":
        spacing = rng.choice([0.1, 12.5, 1 / 3], (n, 1, 1))
        return nudge(
            lattice * spacing + np.array([456_000.1, 6_780_000.3, -2_000.7])[:dimension], rng
        )
    if family == "powers":
        return nudge(lattice * 2.0 ** rng.integers(-30, 31, (n, 1, 1)), rng)
    if family == "mixed":
        return rng.normal(size=shape) * 2.0 ** rng.integers(-40, 41, shape)
    plane = _CIRCLE[rng.integers(0, len(_CIRCLE), (n, corners))]
    out = np.zeros(shape)
    out[..., :2] = plane + rng.integers(-9, 10, (n, 1, 2))
    out[..., 2:] = lattice[..., 2:]
    return nudge(out * rng.choice([1.0, 0.1], (n, 1, 1)), rng)


def nearly_flat(rng, shape) -> np.ndarray:
    """The last point is a rounded affine combination of the others."""
    points = rng.uniform(-1.0, 1.0, shape)
    weights = rng.integers(-3, 4, (shape[0], shape[1] - 1)).astype(float)
    weights[:, 0] += 1.0 - weights.sum(axis=1)
    points[:, -1] = np.einsum("ij,ijk->ik", weights, points[:, :-1])
    return points


def nudge(points: np.ndarray, rng) -> np.ndarray:
    """Move a third of the coordinates to a neighbouring double."""
    step = rng.integers(-1, 2, points.shape)
    step[(rng.random(points.shape) < 0.5) | (points == 0)] = 0
    return np.where(step == 0, points, np.nextafter(points, np.where(step > 0, np.inf, -np.inf)))


def integers(points: np.ndarray) -> np.ndarray:
    """The same points as Python ints on one common scale, exact (an object array)."""
    mantissa, exponent = np.frexp(points)
    used = points != 0
    low = int(exponent[used].min()) if used.any() else 0
    whole = (mantissa * 2.0**53).astype(np.int64).astype(object)
    shift = np.where(used, exponent - low, 0)
    return whole * (2 ** shift.astype(object))


def leibniz(columns: list[list]) -> np.ndarray:
    """Determinants by the sum over all permutations; entries are arrays of Python ints."""
    n = len(columns)
    total = 0
    for order in permutations(range(n)):
        inversions = sum(order[i] > order[j] for i in range(n) for j in range(i + 1, n))
        term = -1 if inversions % 2 else 1
        for row, column in enumerate(order):
            entry = columns[row][column]
            if not (isinstance(entry, int) and entry == 1):
                term = term * entry
        total = total + term
    return total


def true_signs(name: str, points: np.ndarray) -> np.ndarray:
    """Signs from homogeneous determinants of integers."""
    p = integers(points)
    rows = [[p[:, i, k] for k in range(p.shape[2])] for i in range(p.shape[1])]
    if name == "incircle":
        rows = [[x, y, x * x + y * y] for x, y in rows]
    values = leibniz([[*row, 1] for row in rows])
    signs = np.array([(v > 0) - (v < 0) for v in values.tolist()], dtype=np.int64)
    return -signs if name == "orient3d" else signs


PREDICATES = {"orient2d": (3, 2), "orient3d": (4, 3), "incircle": (4, 2)}


def kernel_signs(name: str, points: np.ndarray) -> np.ndarray:
    """Signs from geosurf's kernels; points (n, corners, dimension)."""
    from geosurf.kernels.exact import predicates

    n, corners, dimension = points.shape
    x = np.zeros((n * corners, 3))
    x[:, :dimension] = points.reshape(-1, dimension)
    m, w = predicates.frame_of(x)
    rows = np.arange(n * corners).reshape(n, corners)
    if name == "incircle":
        return _circle_signs(x, m, rows)
    out = np.full(n, 9, dtype=np.int64)
    getattr(predicates, f"{name}_rows")(x, rows, m, w, out)
    return out


def _circle_signs(x: np.ndarray, m: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Signs of `signs.circle`, which is asked about triangles that turn left only.

    An odd change of order changes the sign of the determinant; it is 0 for four points of a line.
    """
    from geosurf.kernels.cutting.cached_predicates import face_workspace
    from geosurf.kernels.exact.exact_signs import LIMBS
    from tests.kernels.rows import sign_rows

    w = face_workspace(int(m[LIMBS]), len(x))
    none = np.empty((0, 4), dtype=np.int64)
    signs = np.zeros(len(rows), dtype=np.int64)
    open_ = np.arange(len(rows))
    for order, parity in (
        ((0, 1, 2, 3), 1),
        ((0, 1, 3, 2), -1),
        ((0, 2, 3, 1), 1),
        ((1, 2, 3, 0), -1),
    ):
        for flip in (1, -1):
            asked = rows[open_][:, order if flip > 0 else [order[i] for i in (1, 0, 2, 3)]]
            out = np.empty((len(open_), 3), dtype=np.int64)
            # two of a row may be in one place, which the engine never asks: as good as any sign
            sign_rows(x, none[:, :3], none[:, :3], none, m, w, np.arange(len(x)), 2, asked, out)
            left = out[:, 0] > 0
            signs[open_[left]] = parity * flip * out[left, 1]
            open_ = open_[~left]
    return signs


def share(total: int) -> int:
    """Cases of one predicate and family, of a total over all."""
    return math.ceil(total / (len(PREDICATES) * len(FAMILIES)))
