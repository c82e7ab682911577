"""Places of faults and of beds, for each particle of rock that throw moves.

The same sums in the same order as numpy would do them, one particle at a time: numpy makes twenty
arrays for each of these questions, which take most of its time. Products with the axes of a fault
are sums of two terms, each rounded: those of a matrix product differ between processors.

Notation
    axes      horizontal unit vectors along strike and in the dip direction, float64 (2, 2)
    table     a fault across strike, over its length and its height, float64 (n_s, n_z)
    fault     its elevations, its length, how it goes on above and below, and where s is 0 along
              the first axis: LOW, HIGH, LENGTH, SLOPE, FIRST
    lines     slopes of the lines down its dip, over its length and height; empty if all are 0
    s, z      places along strike and elevations [m]
    u, v      rows and columns of the table
    grid      elevations of the horizon before it was moved, float64 (n_row, n_col)
    x, y      columns and rows of places in it
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar

LOW, HIGH, LENGTH, SLOPE, FIRST = 0, 1, 2, 3, 4


@scalar
def _bilinear(table, u, v):
    """Value of a table at row u and column v within it."""
    i = min(int(u), table.shape[0] - 2)
    j = min(int(v), table.shape[1] - 2)
    f, g = u - i, v - j
    lower = table[i, j] * (1.0 - f) + table[i + 1, j] * f
    upper = table[i, j + 1] * (1.0 - f) + table[i + 1, j + 1] * f
    return lower * (1.0 - g) + upper * g


@entry("d2 d1 d1 d1* -> .")
def values_in_table(table, u, v, out):
    """Write the values of a table at broken rows and columns."""
    for k in range(u.shape[0]):
        out[k] = _bilinear(table, u[k], v[k])


@scalar
def _in_table(table, fault, s, z):
    """Value of a table at a distance along strike and an elevation within the fault."""
    u = min(max(s / fault[LENGTH], 0.0), 1.0) * (table.shape[0] - 1)
    v = (z - fault[LOW]) / (fault[HIGH] - fault[LOW]) * (table.shape[1] - 1)
    return _bilinear(table, u, v)


@scalar
def _across(table, fault, s, z):
    """Where a fault is across strike: straight on past its ends, sloping on beyond."""
    within = min(max(z, fault[LOW]), fault[HIGH])
    return _in_table(table, fault, s, within) + fault[SLOPE] * (z - within)


@entry("d2 d1 d1 d1 d1* -> .")
def across_fault(table, fault, s, z, out):
    """Write where a fault is across strike: straight on past its ends, sloping on beyond."""
    for k in range(s.shape[0]):
        out[k] = _across(table, fault, s[k], z[k])


@entry("d2 d2 d1 d2 d1 d1* -> .")
def distances_from_fault(axes, table, fault, xy, z, out):
    """Write how far places are from a fault at their elevation, across strike."""
    for k in range(z.shape[0]):
        s = axes[0, 0] * xy[k, 0] + axes[0, 1] * xy[k, 1] - fault[FIRST]
        r = axes[1, 0] * xy[k, 0] + axes[1, 1] * xy[k, 1]
        out[k] = r - _across(table, fault, s, z[k])


@scalar
def _line_slope(lines, fault, s, z):
    """Slope of a line down the dip at a place; no line turns above or below the fault."""
    if z < fault[LOW] or z > fault[HIGH]:
        return 0.0
    return _in_table(lines, fault, s, z)


@scalar
def _along_line(lines, fault, s, z, to, steps):
    """Where a line down the dip is along strike at another elevation: Runge and Kutta's order 4."""
    step = (to - z) / steps
    for k in range(steps):
        at = z + k * step
        k1 = _line_slope(lines, fault, s, at)
        k2 = _line_slope(lines, fault, s + 0.5 * step * k1, at + 0.5 * step)
        k3 = _line_slope(lines, fault, s + 0.5 * step * k2, at + 0.5 * step)
        k4 = _line_slope(lines, fault, s + step * k3, at + step)
        s = s + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return s


@entry("d2 d2 d1 d2 l d d2 d1 d1 d1 d2* d1* -> .")
def move_rock(axes, table, fault, lines, steps, reach, xy, z, part, throw, moved, lower):
    """Write where particles are after the movement along a fault, `part` of its throw, down.

    Movement dies away from the fault over `reach`,
    which may be infinite. A particle with no part stays where it is, to the last digit.
    """
    a, b, c, d = axes[0, 0], axes[0, 1], axes[1, 0], axes[1, 1]
    for k in range(z.shape[0]):
        if part[k] == 0.0:
            moved[k, 0], moved[k, 1], lower[k] = xy[k, 0], xy[k, 1], z[k]
            continue
        s = a * xy[k, 0] + b * xy[k, 1] - fault[FIRST]
        r = c * xy[k, 0] + d * xy[k, 1]
        here = _across(table, fault, s, z[k])

        # how far down: throw at the place along strike where the particle leaves from
        down = part[k] * throw[k]
        if reach < np.inf:
            away = r - here if part[k] > 0 else here - r
            # smooth on past the fault, where ghosts are
            left = max(1.0 - away / reach, 0.0)
            down = down * (left * left)

        # and along: as the fault's dip line does between both levels; what is off the fault keeps
        # its distance across it, so that rock neither detaches from the fault nor sinks into it
        low = z[k] - down
        to = s
        if lines.shape[0] > 0:
            to = _along_line(lines, fault, s, z[k], low, steps)
        r = r + _across(table, fault, to, low) - here
        to = to + fault[FIRST]
        moved[k, 0], moved[k, 1], lower[k] = to * a + r * c, to * b + r * d, low


@scalar
def _on_triangles(grid, rising, x, y):
    """Elevation of the triangles of a grid; those at its rim go on beyond it."""
    n_row, n_col = grid.shape
    j = int(min(max(np.floor(x), 0.0), n_col - 2.0))
    i = int(min(max(np.floor(y), 0.0), n_row - 2.0))
    f, g = x - j, y - i

    # corners a b c d anticlockwise, a at the lower left; a node comes back bit for bit
    if rising:  # a joins c
        base = grid[i, j]
        large, small = max(f, g), min(f, g)
        middle = grid[i, j + 1] if f >= g else grid[i + 1, j]
        first, second = large - small, small
        rise_first, rise_second = middle - base, grid[i + 1, j + 1] - base
    else:
        low = f + g <= 1.0
        base = grid[i, j] if low else grid[i + 1, j + 1]
        first = f if low else 1 - g
        second = g if low else 1 - f
        rise_first, rise_second = grid[i, j + 1] - base, grid[i + 1, j] - base
    return base + first * rise_first + second * rise_second


@entry("l1 d2 d2 d1 d2 d1 b d d1* d2* -> l1 d2 d2 d1")
def settle(todo, where, at, old, now, height, both, close, z, was):
    """Take the particles that have arrived, and shift the origin of the others by what they miss.

    Particle `todo[k]` was thought to come from `at[k]`, and comes to `now[k]` and `height[k]`
    from there, instead of to `where[k]`; with `both` its height has to be that of the last round,
    `old[k]`, too. Elevation and origin of those that arrive within `close` are written to `z` and
    `was`; `todo`, `where`, `at` and `old` of the others come back.
    """
    n = 0
    left, place = np.empty_like(todo), np.empty_like(where)
    origin, level = np.empty_like(at), np.empty_like(old)
    for k in range(todo.shape[0]):
        x, y = where[k, 0] - now[k, 0], where[k, 1] - now[k, 1]
        missed = abs(x) > close or abs(y) > close
        if both and abs(height[k] - old[k]) > close:
            missed = True
        if not missed:
            z[todo[k]] = height[k]
            was[todo[k], 0], was[todo[k], 1] = at[k, 0], at[k, 1]
            continue
        left[n], level[n] = todo[k], height[k]
        place[n, 0], place[n, 1] = where[k, 0], where[k, 1]
        origin[n, 0], origin[n, 1] = at[k, 0] + x, at[k, 1] + y
        n += 1
    return left[:n].copy(), place[:n].copy(), origin[:n].copy(), level[:n].copy()


@entry("d2 b d1 d1 d1* -> .")
def heights_on_triangles(grid, rising, x, y, out):
    """Write elevations of the triangles of a grid at columns x and rows y."""
    for k in range(x.shape[0]):
        out[k] = _on_triangles(grid, rising, x[k], y[k])


@entry("d2 d2 l l -> l")
def first_folded(now, parts, n_row, n_col):
    """The first cell whose corners move to places `now` so that one of its triangles turns over.

    Cells whose four corners do not have the same parts (n_fault, n) are passed over: a fault may
    open or close them. Returns its first corner, or -1.
    """
    for i in range(n_row - 1):
        for j in range(n_col - 1):
            a = i * n_col + j
            b, d, c = a + 1, a + n_col, a + n_col + 1
            alike = True
            for k in range(parts.shape[0]):
                one = parts[k, a]
                alike = alike and one == parts[k, b] and one == parts[k, c] and one == parts[k, d]
            if not alike:
                continue

            # twice the signed areas of both triangles: 0 or less is folded over
            east, north = now[b, 0] - now[a, 0], now[d, 1] - now[a, 1]
            low = east * north - (now[b, 1] - now[a, 1]) * (now[d, 0] - now[a, 0])
            east, north = now[d, 0] - now[c, 0], now[b, 1] - now[c, 1]
            high = east * north - (now[d, 1] - now[c, 1]) * (now[b, 0] - now[c, 0])
            if min(low, high) <= 0.0:
                return a
    return -1
