"""Exact numbers of single triangles, for the few that floating point leaves in doubt."""

from __future__ import annotations

from fractions import Fraction

import numpy as np


def exact_normal(corners: np.ndarray) -> tuple[Fraction, Fraction, Fraction]:
    """Return the normal of a triangle, twice as long as its area, without rounding.

    Parameters
    ----------
    corners : ndarray of float64, (3, 3)
        Finite coordinates [m].

    Returns
    -------
    tuple of fractions.Fraction
        ``(b - a) x (c - a)`` [m2]; all are zero if the corners lie on one line.

    Examples
    --------
    >>> exact_normal(np.array([[0.0, 0, 0], [0.5, 0, 0], [0, 3, 1]]))
    (Fraction(0, 1), Fraction(-1, 2), Fraction(3, 2))
    """
    # floats are fractions with a power of two below: nothing is rounded from here on
    a, b, c = ([Fraction(value) for value in corner] for corner in corners.tolist())
    u = [q - p for p, q in zip(a, b, strict=True)]
    v = [q - p for p, q in zip(a, c, strict=True)]
    return (
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    )
