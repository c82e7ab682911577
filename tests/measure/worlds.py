"""Worlds of planes whose horizons are torn: everything about them is known by hand.

A fault dips 45 degrees to the east, x + z = 10; its hanging wall is in the east. Horizons end on it
at whole numbers, so that models are sealed and exact.
"""

from __future__ import annotations

import numpy as np

from geosurf import Scene, TriSurface

BOX = (0.0, 60.0, 0.0, 30.0, -40.0, 0.0)
WEST, EAST, SOUTH, NORTH = -4.0, 64.0, -2.0, 32.0


def torn(name, foot, hanging):
    """A horizon of two planes; foot and hanging are its elevations at SOUTH and NORTH."""
    (a, b), (c, d) = foot, hanging
    corners = [
        (WEST, SOUTH, a), (10 - a, SOUTH, a), (10 - b, NORTH, b), (WEST, NORTH, b),
        (10 - c, SOUTH, c), (EAST, SOUTH, c), (EAST, NORTH, d), (10 - d, NORTH, d),
    ]  # fmt: skip
    faces = [(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)]
    return TriSurface(name, "horizon", corners, faces)


def slope(name="F1", south=SOUTH, north=NORTH):
    """The fault x + z = 10 between two northings."""
    corners = [(9, south, 1), (9, north, 1), (51, north, -41), (51, south, -41)]
    return TriSurface(name, "fault", corners, [(0, 2, 1), (0, 3, 2)])


def faulted(throw=(4.0, 4.0), **options) -> Scene:
    """Top and Base, ten metres apart, torn; the throw at SOUTH and NORTH."""
    south, north = throw
    horizons = {
        name: torn(name, (z, z), (z - south, z - north))
        for name, z in (("Top", -10.0), ("Base", -20.0))
    }
    return Scene(horizons, {"F1": slope()}, BOX, **options)


def level(name, z):
    """A flat horizon."""
    corners = [(WEST, SOUTH, z), (EAST, SOUTH, z), (EAST, NORTH, z), (WEST, NORTH, z)]
    return TriSurface(name, "horizon", corners, [(0, 1, 2), (0, 2, 3)])


def tops_at(points, horizon="Top"):
    """Tops at points (n, 3), one well each."""
    points = np.atleast_2d(points)
    names = {"well": [f"W{k}" for k in range(len(points))], "horizon": [horizon] * len(points)}
    return names | dict(zip(("easting", "northing", "elevation"), points.T, strict=True))
