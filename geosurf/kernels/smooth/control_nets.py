"""Bernstein control nets of cells and triangles, and whether a plane separates two of them.

Letters as in `cubic_patch`; nets (n, 4, 4, 3) Bernstein coefficients.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.smooth.cubic_patch import cell_net, unit_cross
from geosurf.kernels.smooth.patch_pyramid import SLACK


@scalar
def _triangle_net(t, net):
    """A triangle as the patch (s, t) = (p (1 - q), p q)."""
    for k in range(4):
        for col in range(4):
            # Bernstein coefficients of a bilinear patch, degree raised to three.
            p, q = col / 3.0, k / 3.0
            for axis in range(3):
                net[k, col, axis] = (
                    t[0, axis] + p * (t[1, axis] - t[0, axis]) + p * q * (t[2, axis] - t[1, axis])
                )


@entry("d2 d2 d2 d3 l1 -> d4")
def nets_of(x, y, z, c, cells):
    """Nets of some cells; of some triangles where z has one row."""
    nets, half = np.empty((cells.shape[0], 4, 4, 3)), np.empty((4, 4))
    for k in range(cells.shape[0]):
        # One row of z stands for a surface of triangles.
        if z.shape[0] == 1:
            _triangle_net(c[cells[k]], nets[k])
        else:
            across = z.shape[1] - 1
            cell_net(x, y, z, cells[k] // across, cells[k] % across, nets[k], half)
    return nets


@scalar
def _shadow(net, p, q, r):
    """Bounds of p x + q y + r z over a net."""
    low, high = np.inf, -np.inf
    for k in range(4):
        for col in range(4):
            value = p * net[k, col, 0] + q * net[k, col, 1] + r * net[k, col, 2]

            # Comparisons with NaN are false.
            if value < low:
                low = value
            if value > high:
                high = value
    return low, high


@scalar
def net_normal(net):
    """Unit normal of a net from its diagonals; NaN if they are parallel or missing."""
    # Diagonals between the outermost coefficients, which are points of the patch.
    ax, ay, az = (
        net[3, 3, 0] - net[0, 0, 0],
        net[3, 3, 1] - net[0, 0, 1],
        net[3, 3, 2] - net[0, 0, 2],
    )
    bx, by, bz = (
        net[3, 0, 0] - net[0, 3, 0],
        net[3, 0, 1] - net[0, 3, 1],
        net[3, 0, 2] - net[0, 3, 2],
    )
    return unit_cross(ax, ay, az, bx, by, bz)


@scalar
def separated(one, two):
    """Whether two nets are separated along an axis or along one of their normals."""
    for axis in range(5):
        # Three axes, then the normals of both nets.
        if axis < 3:
            p, q, r = 1.0 * (axis == 0), 1.0 * (axis == 1), 1.0 * (axis == 2)
        else:
            p, q, r = net_normal(one) if axis == 3 else net_normal(two)
            if not np.isfinite(p + q + r):
                continue

        # The convex hull of the coefficients holds the patch, so disjoint bounds separate.
        low, high = _shadow(one, p, q, r)
        floor, ceiling = _shadow(two, p, q, r)
        if low > ceiling + SLACK or floor > high + SLACK:
            return True
    return False


@scalar
def lies_beside(net, t):
    """Whether a plane through an edge of a triangle, across it, separates a net from it."""
    for k in range(3):
        a, b, c = t[k], t[(k + 1) % 3], t[(k + 2) % 3]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]

        # The part of v across the edge points to the third corner.
        along = (ux * vx + uy * vy + uz * vz) / (ux * ux + uy * uy + uz * uz)
        p, q, r = vx - along * ux, vy - along * uy, vz - along * uz
        size = math.sqrt(p * p + q * q + r * r)
        _, high = _shadow(net, p / size, q / size, r / size)
        if high < (p * a[0] + q * a[1] + r * a[2]) / size - SLACK:
            return True
    return False
