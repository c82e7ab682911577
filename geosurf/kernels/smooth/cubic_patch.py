"""Local cubics on lattices: points, tangents, control nets, and measures of their accuracy.

Between nodes, a lattice is the tensor product of 4-point Lagrange cubics in row and column numbers,
one for each coordinate. Why Lagrange and not cubic convolution (Keys 1981): the error is O(h^4)
instead of O(h^3); the stencil can be shifted inwards at the boundary without losing that order; and
there is one polynomial per cell, so Bernstein coefficients bound it exactly. The price: tangents
jump by O(h^3) from cell to cell, which moves no point.

Notation
    x, y, z   coordinates of nodes, local [m], each (n_row, n_col); x may have one row and y one
              column where the lattice is axis-aligned; NaN where a node is missing
    u, v      column and row number, real: node (i, j) has u = j, v = i
    a, b      weights along columns and rows: four values, then four derivatives
    f         workspace (n,); `evaluate` fills nine of it: point, d/du, d/dv
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import scalar


def _to_bernstein():
    """Stencil values -> Bernstein coefficients, for the cell at place 0, 1, 2 of its stencil."""
    # Coefficients of the cubic through values at 0, 1, 2, 3.
    powers = np.linalg.inv(np.vander(np.arange(4.0), 4, increasing=True))
    out = np.empty((3, 4, 4))
    for place in range(3):
        t = float(place)
        value = [[s**k for k in range(4)] for s in (t, t + 1)]
        slope = [[k * s ** max(k - 1, 0) for k in range(4)] for s in (t, t + 1)]
        ends, slopes = np.array(value) @ powers, np.array(slope) @ powers
        # Bernstein coefficients of a cubic: its ends, and the ends moved by a third of the slopes.
        out[place] = ends[0], ends[0] + slopes[0] / 3, ends[1] - slopes[1] / 3, ends[1]
    return out


BERNSTEIN = _to_bernstein()
# halfway between nodes: 6-point minus 4-point, 8-point minus 6-point weights of the eight nodes
SIX_FOUR = np.array([0.0, 3.0, -9.0, 6.0, 6.0, -9.0, 3.0, 0.0]) / 256
EIGHT_SIX = np.array([-5.0, 25.0, -45.0, 25.0, 25.0, -45.0, 25.0, -5.0]) / 2048
# response of the second to uncorrelated noise of standard deviation 1
NOISE_GAIN = float(np.sqrt((EIGHT_SIX**2).sum()))


@scalar
def unit_cross(ux, uy, uz, vx, vy, vz):
    """Unit vector along the cross product of two; NaN if they are parallel or not finite."""
    p, q, r = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = math.sqrt(p * p + q * q + r * r)
    return p / size, q / size, r / size


@scalar
def stencil(u, n, m):
    """First node of the m nodes around u, shifted inwards at the boundary."""
    return min(max(math.floor(u) - m // 2 + 1, 0), n - m)


@scalar
def cubic(t):
    """Weights of four nodes 0, 1, 2, 3 at t, and their derivatives."""
    p, q, r = t - 1.0, t - 2.0, t - 3.0
    # Products that weights and derivatives share.
    pq, qr, pr, tp, tq, tr = p * q, q * r, p * r, t * p, t * q, t * r
    return (
        -p * qr / 6.0,
        0.5 * t * qr,
        -0.5 * t * pr,
        t * pq / 6.0,
        -(qr + pr + pq) / 6.0,
        0.5 * (qr + tr + tq),
        -0.5 * (pr + tr + tp),
        (pq + tq + tp) / 6.0,
    )


@scalar
def _row(q, i, j, a):
    """Value and d/du along row i, from column j on."""
    k, m, n, o = q[i, j], q[i, j + 1], q[i, j + 2], q[i, j + 3]
    value = (a[0] * k + a[1] * m) + (a[2] * n + a[3] * o)
    return value, (a[4] * k + a[5] * m) + (a[6] * n + a[7] * o)


@scalar
def _tensor(q, i, j, a, b):
    """Value, d/du, d/dv of one coordinate."""
    # A coordinate that is constant along one direction needs one sum only.
    if q.shape[0] == 1:
        value, du = _row(q, 0, j, a)
        return value, du, 0.0
    if q.shape[1] == 1:
        k, m, n, o = q[i, 0], q[i + 1, 0], q[i + 2, 0], q[i + 3, 0]
        value = (b[0] * k + b[1] * m) + (b[2] * n + b[3] * o)
        return value, 0.0, (b[4] * k + b[5] * m) + (b[6] * n + b[7] * o)
    # pairwise sums shorten the chain of dependent operations
    k, dk = _row(q, i, j, a)
    m, dm = _row(q, i + 1, j, a)
    n, dn = _row(q, i + 2, j, a)
    o, do = _row(q, i + 3, j, a)
    value = (b[0] * k + b[1] * m) + (b[2] * n + b[3] * o)
    du = (b[0] * dk + b[1] * dm) + (b[2] * dn + b[3] * do)
    return value, du, (b[4] * k + b[5] * m) + (b[6] * n + b[7] * o)


@scalar
def evaluate(x, y, z, u, v, f, o):
    """Point, d/du and d/dv into f[o : o + 9]; NaN where the stencil has a hole."""
    # The 4 x 4 stencil and its weights serve all three coordinates.
    j, i = stencil(u, z.shape[1], 4), stencil(v, z.shape[0], 4)
    a, b = cubic(u - j), cubic(v - i)
    f[o], f[o + 3], f[o + 6] = _tensor(x, i, j, a, b)
    f[o + 1], f[o + 4], f[o + 7] = _tensor(y, i, j, a, b)
    f[o + 2], f[o + 5], f[o + 8] = _tensor(z, i, j, a, b)


@scalar
def _net_of(q, i, j, cu, cv, net, axis, half):
    """Bernstein coefficients of one coordinate; cu, cv are the place of the cell in its stencil."""
    n_row, n_col = q.shape

    # Columns first, then rows, each by a 4 x 4 matrix.
    for r in range(4 if n_row > 1 else 1):
        for col in range(4):
            # Constant along the row: the coefficients are the values.
            if n_col == 1:
                half[r, col] = q[i + r, 0]
                continue
            row = i + r if n_row > 1 else 0
            half[r, col] = (
                BERNSTEIN[cu, col, 0] * q[row, j]
                + BERNSTEIN[cu, col, 1] * q[row, j + 1]
                + BERNSTEIN[cu, col, 2] * q[row, j + 2]
                + BERNSTEIN[cu, col, 3] * q[row, j + 3]
            )
    for k in range(4):
        for col in range(4):
            # Constant along the column.
            if n_row == 1:
                net[k, col, axis] = half[0, col]
                continue
            net[k, col, axis] = (
                BERNSTEIN[cv, k, 0] * half[0, col]
                + BERNSTEIN[cv, k, 1] * half[1, col]
                + BERNSTEIN[cv, k, 2] * half[2, col]
                + BERNSTEIN[cv, k, 3] * half[3, col]
            )


@scalar
def corner_net(x, y, z, i, j, net):
    """A net for a cell without a complete stencil: its existing corners, each four times."""
    found = 0
    for k in range(2):
        for col in range(2):
            # A missing corner makes its four coefficients NaN.
            px = x[0 if x.shape[0] == 1 else i + k, j + col]
            py = y[i + k, 0 if y.shape[1] == 1 else j + col]
            pz = z[i + k, j + col]
            if not (math.isfinite(px) and math.isfinite(py) and math.isfinite(pz)):
                px, py, pz = np.nan, np.nan, np.nan
            else:
                found += 1
            # Each corner stands for a quarter of the net.
            for r in range(2):
                for c in range(2):
                    net[2 * k + r, 2 * col + c, 0] = px
                    net[2 * k + r, 2 * col + c, 1] = py
                    net[2 * k + r, 2 * col + c, 2] = pz
    return found


@scalar
def cell_net(x, y, z, i, j, net, half):
    """Write the control net (4, 4, 3) of a cell; 1 where its stencil has all 16 nodes.

    0 where the net is only the corners of one or two triangles, -1 where the cell has none.
    """
    si, sj = stencil(i, z.shape[0], 4), stencil(j, z.shape[1], 4)
    _net_of(x, si, sj, j - sj, i - si, net, 0, half)
    _net_of(y, si, sj, j - sj, i - si, net, 1, half)
    _net_of(z, si, sj, j - sj, i - si, net, 2, half)

    # NaN in any coefficient marks an incomplete stencil.
    total = 0.0
    for k in range(4):
        for col in range(4):
            for axis in range(3):
                total += net[k, col, axis]
    if math.isfinite(total):
        return 1
    # Three corners or four make one or two triangles.
    return 0 if corner_net(x, y, z, i, j, net) > 2 else -1


@scalar
def node(q, i, j):
    """One coordinate of a node; an axis-aligned lattice stores each row or column once."""
    return q[0 if q.shape[0] == 1 else i, 0 if q.shape[1] == 1 else j]


@scalar
def _weight(first, m, k, t):
    """Lagrange weight of node first + k among m nodes at t."""
    out = 1.0
    for r in range(m):
        if r != k:
            out *= (t - first - r) / (k - r)
    return out


@scalar
def _halfway(q, fixed, first, by_row):
    """6-point minus 4-point, 8-point minus 6-point, of one coordinate amid eight nodes.

    The weights are symmetric. 0 for a coordinate that is constant along the line.
    """
    if by_row:
        # All eight values are equal: the differences are 0.
        if q.shape[0] == 1:
            return 0.0, 0.0
        i, j, up, on = first, 0 if q.shape[1] == 1 else fixed, 1, 0
    else:
        if q.shape[1] == 1:
            return 0.0, 0.0
        i, j, up, on = 0 if q.shape[0] == 1 else fixed, first, 0, 1
    # Weights are symmetric: equal ones are applied to sums.
    ends = q[i, j] + q[i + 7 * up, j + 7 * on]
    outer = q[i + up, j + on] + q[i + 6 * up, j + 6 * on]
    inner = q[i + 2 * up, j + 2 * on] + q[i + 5 * up, j + 5 * on]
    middle = q[i + 3 * up, j + 3 * on] + q[i + 4 * up, j + 4 * on]
    return (
        SIX_FOUR[1] * outer + SIX_FOUR[2] * inner + SIX_FOUR[3] * middle,
        EIGHT_SIX[0] * ends + EIGHT_SIX[1] * outer + EIGHT_SIX[2] * inner + EIGHT_SIX[3] * middle,
    )


@scalar
def _differences(x, y, z, fixed, along, by_row, p, q, r):
    """6-point minus 4-point, 8-point minus 6-point, halfway along a side of a cell, on (p, q, r).

    The side starts at node `along` of row or column `fixed`. The third number is the response of
    the second to uncorrelated noise of standard deviation 1.
    """
    n = z.shape[0] if by_row else z.shape[1]
    eight, six, four = stencil(along, n, 8), stencil(along, n, 6), stencil(along, n, 4)
    # The stencil is centred: constant weights.
    if eight == along - 3:
        a, d = _halfway(x, fixed, eight, by_row)
        b, e = _halfway(y, fixed, eight, by_row)
        c, f = _halfway(z, fixed, eight, by_row)
        return abs(p * a + q * b + r * c), abs(p * d + q * e + r * f), NOISE_GAIN

    # At the boundary the stencils are shifted: general Lagrange weights.
    t = along + 0.5
    fine, finer, gain = 0.0, 0.0, 0.0
    for k in range(8):
        g = eight + k
        i, j = (g, fixed) if by_row else (fixed, g)
        value = p * node(x, i, j) + q * node(y, i, j) + r * node(z, i, j)
        # A shorter stencil gives the nodes outside of it the weight 0.
        w8 = _weight(eight, 8, k, t)
        w6 = _weight(six, 6, g - six, t) if 0 <= g - six < 6 else 0.0
        w4 = _weight(four, 4, g - four, t) if 0 <= g - four < 4 else 0.0
        fine += (w6 - w4) * value
        finer += (w8 - w6) * value
        gain += (w8 - w6) ** 2
    return abs(fine), abs(finer), math.sqrt(gain)


@scalar
def interpolant_differences(x, y, z, u, v, p, q, r):
    """Accuracy of the cubics in the cell at (u, v), along unit vector (p, q, r): three lengths.

    Differences of the 6-point and 4-point interpolants, and of the 8-point and 6-point ones,
    halfway between nodes where they are largest: rows plus columns, the larger side of the cell;
    last, the noise that would cause the second. NaN where a stencil has a hole.
    """
    n_row, n_col = z.shape
    j = min(max(math.floor(u), 0), n_col - 2)
    i = min(max(math.floor(v), 0), n_row - 2)

    # Two sides along columns, two along rows.
    a0, b0, g = _differences(x, y, z, i, j, False, p, q, r)
    a1, b1, _ = _differences(x, y, z, i + 1, j, False, p, q, r)
    c0, d0, h = _differences(x, y, z, j, i, True, p, q, r)
    c1, d1, _ = _differences(x, y, z, j + 1, i, True, p, q, r)
    if math.isnan(b0 + b1 + d0 + d1):  # these look at all eight nodes
        return np.nan, np.nan, np.nan
    return (
        max(a0, a1) + max(c0, c1),
        max(b0, b1) + max(d0, d1),
        max(max(b0, b1) / g, max(d0, d1) / h),
    )
