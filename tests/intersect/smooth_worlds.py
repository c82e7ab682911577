"""Smooth surfaces with curves that are known by formula, sampled on lattices."""

from __future__ import annotations

import numpy as np

from geosurf import Lattice, TriSurface

SIDE = 10_000.0
HEIGHT, KX, LY = 200.0, 2 * np.pi / 4000, 2 * np.pi / 5000
RADIUS, STRIKE = 4000.0, np.radians(17.0)
AXIS = RADIUS * np.array([np.cos(np.radians(60.0)), np.sin(np.radians(60.0))])


def horizon(height, n=41, side=4000.0, name="Top", corner=0.0) -> TriSurface:
    """``z = height(x, y)`` on n x n nodes."""
    x = np.linspace(corner, corner + side, n)
    z = height(x[None, :], x[:, None]) + np.zeros((n, n))
    return TriSurface(name, "horizon", lattice=Lattice(x, x, z))


def level(z, n=17, name="Flat", side=4000.0, more=37.0) -> TriSurface:
    """A level lattice, somewhat larger than the horizon and not in step with it."""
    return horizon(lambda x, y: z + 0 * x, n, side + 2 * more, name, -more)


def two_triangles(z, east=0.0, north=0.0, name="Flat", side=4000.0) -> TriSurface:
    """A plane of two triangles."""
    square = [
        (-100.0, -100.0),
        (side + 100, -100.0),
        (side + 100, side + 100),
        (-100.0, side + 100),
    ]
    vertices = [(x, y, z + east * x + north * y) for x, y in square]
    return TriSurface(name, "fault", vertices, [[0, 1, 2], [0, 2, 3]])


def waves(x, y):
    """Height of the wavy horizon."""
    return HEIGHT * np.sin(KX * x) * np.sin(LY * y)


def wavy_horizon(n, noise=None) -> TriSurface:
    """a sin kx sin ly, with noise of a standard deviation [m]."""
    rough = np.zeros((n, n)) if noise is None else noise
    return horizon(lambda x, y: waves(x, y) + rough, n, SIDE)


def listric_fault(n_row, n_col) -> TriSurface:
    """An arc of a circle, pulled along a strike of 17 degrees."""
    s = np.linspace(-7000.0, 7000.0, n_col)[None, :]
    angle = np.radians(np.linspace(45.0, 75.0, n_row))[:, None]
    across, z = AXIS[0] - RADIUS * np.cos(angle), AXIS[1] - RADIUS * np.sin(angle)
    x = 5000 + across * np.cos(STRIKE) + s * np.sin(STRIKE)
    y = 5000 - across * np.sin(STRIKE) + s * np.cos(STRIKE)
    x, y, z = np.broadcast_arrays(x, y, z)
    return TriSurface("F1", "fault", lattice=Lattice(x, y, z, True, False))


def onto_the_curve(points):
    """The nearest points where waves and arc meet, by Newton's method with least steps."""
    q = np.array(points)
    for _ in range(8):
        x, y, z = q.T
        one = z - waves(x, y)
        g = np.stack(
            [-HEIGHT * KX * np.cos(KX * x) * np.sin(LY * y),
             -HEIGHT * LY * np.sin(KX * x) * np.cos(LY * y), np.ones_like(x)], axis=1,
        )  # fmt: skip
        across = (x - 5000) * np.cos(STRIKE) - (y - 5000) * np.sin(STRIKE) - AXIS[0]
        r = np.hypot(across, z - AXIS[1])
        h = np.stack(
            [across / r * np.cos(STRIKE), -across / r * np.sin(STRIKE), (z - AXIS[1]) / r], axis=1
        )
        a, b, c = (g * g).sum(axis=1), (g * h).sum(axis=1), (h * h).sum(axis=1)
        two, det = r - RADIUS, a * c - b * b
        q = q - ((one * c - two * b) / det)[:, None] * g - ((two * a - one * b) / det)[:, None] * h
    return q


def along(curves, n=8):
    """Points on all segments, n to each, and their ends."""
    t = np.linspace(0, 1, n + 1)[None, :, None]
    ends = curves.points[curves.segments]
    return (ends[:, :1] * (1 - t) + ends[:, 1:] * t).reshape(-1, 3)


def distance_from(points, curves):
    """Distance of points from the nearest segment, all against all."""
    one, two = (curves.points[curves.segments[:, k]] for k in (0, 1))
    d = two - one
    out = np.empty(len(points))
    for i, p in enumerate(points):
        t = np.clip(((p - one) * d).sum(axis=1) / (d * d).sum(axis=1), 0, 1)
        out[i] = np.linalg.norm(p - one - t[:, None] * d, axis=1).min()
    return out
