"""Faults on whole numbers, whose blocks have volumes that one can work out on paper."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from geosurf import TriSurface
from tests.strategies import sheet

BOX = (0.0, 8.0, 0.0, 8.0, 0.0, 8.0)


def dipping(name="F1", n=(1, 1)):
    """East-dipping main fault x + z = 8, beyond the box; hanging wall x + z > 8."""
    return sheet(name, [(-1, -1, 9), (9, -1, -1), (9, 9, -1), (-1, 9, 9)], n)


def antithetic(name="F2", n=(1, 1)):
    """West-dipping fault x = z, beyond the box: a Y with `dipping`."""
    return sheet(name, [(-1, -1, -1), (9, -1, 9), (9, 9, 9), (-1, 9, -1)], n)


def upright(x, name="F2", n=(1, 1)):
    """A vertical fault that strikes north."""
    return sheet(name, [(x, -1, -1), (x, 9, -1), (x, 9, 9), (x, -1, 9)], n)


def across(y, name="F3", west=-1, east=9):
    """A vertical fault that strikes east."""
    return sheet(name, [(west, y, -1), (east, y, -1), (east, y, 9), (west, y, 9)])


def turned(surface):
    """The same fault with all normals the other way."""
    return TriSurface(surface.name, surface.role, surface.vertices, surface.triangles[:, [0, 2, 1]])


def triangles_of(surface):
    """Triangles as sets of places, without order or numbers."""
    corners = surface.vertices[surface.triangles].tolist()
    return {frozenset(map(tuple, c)) for c in corners}


def bytes_of(surface):
    return surface.vertices.tobytes(), surface.triangles.tobytes()


def vector_area(surface):
    """Twice the summed normals, in fractions: parts of a plane fault add up in it exactly."""
    total = [Fraction(0)] * 3
    for triangle in surface.vertices[surface.triangles].tolist():
        a, b, c = ([Fraction(v) for v in corner] for corner in triangle)
        u = [q - p for p, q in zip(a, b, strict=True)]
        v = [q - p for p, q in zip(a, c, strict=True)]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            total[k] += u[i] * v[j] - u[j] * v[i]
    return total


def volumes(units):
    return np.sort([unit.volume for unit in units.values()])
