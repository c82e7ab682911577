"""Places of faults and of beds, for each particle of rock that throw moves.

The same sums in the same order as numpy would do them, one particle at a time: numpy makes twenty
arrays for each of these questions, which take most of its time. Products with the axes of a fault
are sums of two terms, each rounded: those of a matrix product differ between processors.

Notation
    axes      horizontal unit vectors along strike and in the dip direction, float64 (2, 2)
    first     where s is 0, along the first axis
    table     a fault across strike, over its length and its height, float64 (n_s, n_z)
    fault     low, high, length, slope: its elevations, its length, and how it goes on above and
              below, float64 (4,)
    lines     slopes of the lines down its dip, over its length and height; empty if all are 0
    s, z      places along strike and elevations [m]
    u, v      rows and columns of the table
    grid      elevations of the horizon before it was moved, float64 (n_row, n_col)
    x, y      columns and rows of places in it
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar


@scalar
def _bilinear(flat, start, n, m, u, v):
    """Value of a table (n, m), row by row from `start`, at row u and column v within it."""
    i = min(int(u), n - 2)
    j = min(int(v), m - 2)
    f, g = u - i, v - j
    k = start + i * m + j
    lower = flat[k] * (1.0 - f) + flat[k + m] * f
    upper = flat[k + 1] * (1.0 - f) + flat[k + m + 1] * f
    return lower * (1.0 - g) + upper * g


@entry("d1 l l d1 d1 d1* -> .")
def values_in_table(flat, n, m, u, v, out):
    """Write the values of a table (n, m), row by row, at broken rows and columns."""
    for k in range(u.shape[0]):
        out[k] = _bilinear(flat, 0, n, m, u[k], v[k])


@scalar
def _in_table(flat, start, n, m, fault, s, z):
    """Value of a table at a distance along strike and an elevation within the fault."""
    u = min(max(s / fault[2], 0.0), 1.0) * (n - 1)
    v = (z - fault[0]) / (fault[1] - fault[0]) * (m - 1)
    return _bilinear(flat, start, n, m, u, v)


@scalar
def across(flat, start, n, m, fault, s, z):
    """Where a fault is across strike: straight on past its ends, sloping on beyond."""
    within = min(max(z, fault[0]), fault[1])
    return _in_table(flat, start, n, m, fault, s, within) + fault[3] * (z - within)


@entry("d1 l l d1 d1 d1 d1* -> .")
def across_fault(flat, n, m, fault, s, z, out):
    """Write where a fault is across strike: straight on past its ends, sloping on beyond."""
    for k in range(s.shape[0]):
        out[k] = across(flat, 0, n, m, fault, s[k], z[k])


@entry("d2 d d1 l l d1 d2 d1 d1* -> .")
def distances_from_fault(axes, first, flat, n, m, fault, xy, z, out):
    """Write how far places are from a fault at their elevation, across strike."""
    for k in range(z.shape[0]):
        s = axes[0, 0] * xy[k, 0] + axes[0, 1] * xy[k, 1] - first
        r = axes[1, 0] * xy[k, 0] + axes[1, 1] * xy[k, 1]
        out[k] = r - across(flat, 0, n, m, fault, s, z[k])


@scalar
def _line_slope(flat, start, n, m, fault, s, z):
    """Slope of a line down the dip at a place; no line turns above or below the fault."""
    if z < fault[0] or z > fault[1]:
        return 0.0
    return _in_table(flat, start, n, m, fault, s, z)


@scalar
def _along_line(flat, start, n, m, fault, s, z, to, steps):
    """Where a line down the dip is along strike at another elevation: Runge and Kutta's order 4."""
    step = (to - z) / steps
    for k in range(steps):
        at = z + k * step
        one = _line_slope(flat, start, n, m, fault, s, at)
        two = _line_slope(flat, start, n, m, fault, s + 0.5 * step * one, at + 0.5 * step)
        three = _line_slope(flat, start, n, m, fault, s + 0.5 * step * two, at + 0.5 * step)
        four = _line_slope(flat, start, n, m, fault, s + step * three, at + step)
        s = s + step / 6.0 * (one + 2.0 * two + 2.0 * three + four)
    return s


@scalar
def moved_particle(
    a, b, c, d, first, flat, start, n, m, fault, lines, line, n_line, m_line, steps, reach,
    x, y, z, part, throw,
):  # fmt: skip
    """Place and elevation of a particle after the movement; `a`, `b`, `c`, `d` are the axes."""
    here = across(flat, start, n, m, fault, a * x + b * y - first, z)
    return moved_from(
        a, b, c, d, first, flat, start, n, m, fault, lines, line, n_line, m_line, steps, reach,
        x, y, z, here, part, throw,
    )  # fmt: skip


@scalar
def moved_from(
    a, b, c, d, first, flat, start, n, m, fault, lines, line, n_line, m_line, steps, reach,
    x, y, z, here, part, throw,
):  # fmt: skip
    """The same where the fault is known to be at `here`, across strike, beside the particle."""
    s = a * x + b * y - first
    r = c * x + d * y

    # how far down: throw at the place along strike where the particle leaves from
    down = part * throw
    if reach < np.inf:
        away = r - here if part > 0 else here - r
        # smooth on past the fault, where ghosts are
        left = max(1.0 - away / reach, 0.0)
        down = down * (left * left)

    # and along: as the fault's dip line does between both levels; what is off the fault keeps
    # its distance across it, so that rock neither detaches from the fault nor sinks into it
    low = z - down
    to = s
    if n_line > 0:
        to = _along_line(lines, line, n_line, m_line, fault, s, z, low, steps)
    r = r + across(flat, start, n, m, fault, to, low) - here
    to = to + first
    return to * a + r * c, to * b + r * d, low


@entry("d2 d d1 l l d1 d1 l l l d d2 d1 d1 d1 d2* d1* -> .")
def move_rock(
    axes, first, flat, n, m, fault, lines, n_line, m_line, steps, reach, xy, z, part, throw,
    moved, lower,
):  # fmt: skip
    """Write where particles are after the movement along a fault, `part` of its throw, down.

    `throw` has one value for all, or one for each. Movement dies away from the fault over `reach`,
    which may be infinite. A particle with no part stays where it is, to the last digit.
    """
    for k in range(z.shape[0]):
        if part[k] == 0.0:
            moved[k, 0], moved[k, 1], lower[k] = xy[k, 0], xy[k, 1], z[k]
            continue
        moved[k, 0], moved[k, 1], lower[k] = moved_particle(
            axes[0, 0], axes[0, 1], axes[1, 0], axes[1, 1], first, flat, 0, n, m, fault,
            lines, 0, n_line, m_line, steps, reach, xy[k, 0], xy[k, 1], z[k], part[k],
            throw[k if throw.shape[0] > 1 else 0],
        )  # fmt: skip


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
        one, two = middle - base, grid[i + 1, j + 1] - base
    else:
        low = f + g <= 1.0
        base = grid[i, j] if low else grid[i + 1, j + 1]
        first = f if low else 1 - g
        second = g if low else 1 - f
        one, two = grid[i, j + 1] - base, grid[i + 1, j] - base
    return base + first * one + second * two


@scalar
def height_at(grid, rising, to_columns, x, y):
    """Elevation of the triangles of a grid at a place."""
    u = x * to_columns[0, 0] + y * to_columns[1, 0]
    v = x * to_columns[0, 1] + y * to_columns[1, 1]
    return _on_triangles(grid, rising, u, v)


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


@entry("d2 b d2 d2 d1* -> .")
def heights_at_places(grid, rising, to_columns, xy, out):
    """Write elevations of the triangles of a grid at places; `to_columns` gives column and row."""
    for k in range(out.shape[0]):
        out[k] = height_at(grid, rising, to_columns, xy[k, 0], xy[k, 1])


# ---- rock rounds ----------------------------------------
# All rounds in which the rock that throw brings to a place is found, particle by particle.
#
# A particle stays in registers until it has arrived. Where throw is one number for each fault,
# that takes a third of the time of rounds of all particles, and gives the same bits. The notation
# is that of `moved_rock`.


@scalar
def _gradual_parts(faults, tables, flat, acts, ends, lean, x, y, z, walls, part, there):
    """Write parts of the throw of each fault where walls change gradually across it.

    `there` gets where each fault is across strike, at this place and elevation.
    """
    for i in range(faults.shape[0]):
        of = faults[i]
        s = of[4] * x + of[5] * y - of[8]
        r = of[6] * x + of[7] * y
        there[i] = across(flat, tables[i, 0], tables[i, 1], tables[i, 2], of, s, z)
        far = r - there[i]
        walls[i] = min(max(lean + far / of[11], 0.0), 1.0)
    for i in range(faults.shape[0]):
        part[i] = walls[i] if acts[i] else 1.0 - faults[i, 12]

    # beyond its main fault a branch has one wall only
    for e in range(ends.shape[0]):
        i, main = int(ends[e, 0]), int(ends[e, 1])
        here = walls[main] if ends[e, 2] > 0.5 else 1.0 - walls[main]
        part[i] = part[i] * here + ends[e, 3] * (1.0 - here)
    for i in range(faults.shape[0]):
        part[i] = part[i] - 1.0 + faults[i, 12]


@scalar
def _room(faults, lean, steep, spare, x, y, walls, there):
    """How far a height may change while each fault keeps its whole wall."""
    room = np.inf
    for i in range(faults.shape[0]):
        of = faults[i]
        far = of[6] * x + of[7] * y - there[i]
        past = far - (1.0 - lean) * of[11] if walls[i] == 1.0 else -far - lean * of[11]
        room = min(room, (past - spare) / max(steep[i], 1e-300))
    return room


@scalar
def _stay_in_walls(walls, first, n_round):
    """Whether each fault has the wall of the first round, written then, and all of it."""
    for i in range(walls.shape[0]):
        if n_round == 0:
            first[i] = walls[i]
        if walls[i] != first[i] or (walls[i] != 0.0 and walls[i] != 1.0):
            return False
    return True


@entry("d2 l2 d1 b1 d2 d b d2 d1 d l d2 b d2 d2 d l d1* d2* d2* d1* d2* d2* -> l")
def settle_rock(
    faults, tables, flat, acts, ends, lean, gradual, parts, steep, spare, steps,
    grid, rising, to_columns, xy, close, rounds, z, was, in_walls, z_there, was_there, moved_there,
):  # fmt: skip
    """Write the elevation at each place, and where the particle was that has come there.

    All rounds of one particle follow each other: its origin is shifted by what it misses its place
    by, until that is at most `close`. The faults have one throw each. Returns the first place that
    no particle finds within some rounds, its elevation in `z`, or -1.

    Parameters
    ----------
    faults : float64 (n_fault, 13)
        Low, high, length, slope, axes (4), first, reach, throw, twice the width over which walls
        change gradually, and the share of the throw that the hanging wall takes; youngest first.
    tables : int64 (n_fault, 6)
        Start, rows and columns in `flat` of the fault, then of its lines; no row: straight ones.
    acts : bool (n_fault,)
        Faults that part rock.
    ends : float64 (n, 4)
        Branch, main fault, its wall of that, and the wall that it has beyond.
    gradual : bool
        Whether walls change gradually, `lean` on the fault itself: heights count then, too.
        Otherwise `parts` (n_fault, n) has the part of the throw at each place.
    steep : float64 (n_fault,)
        The most by which a fault moves across strike where its height changes by 1.
    spare : float
        A particle that is farther than this from what changes gradually, at all heights that it
        takes on its way, has its walls: they are not asked for again, and it stops in its place in
        the map, as those in `in_walls` do [m].
    in_walls : float64 (n_fault, n), or (n_fault, 0) to write nothing
        Walls of the particles that are in one wall of each fault in all rounds, until they come to
        their places in the map. What they come to with these walls as given parts is written to
        `z_there` and `was_there`; they stop there, and do not wait for their heights. Where the
        particles that are at their places go to from there is written to `moved_there`.
    """
    n_fault = faults.shape[0]
    walls, part, first = np.empty(n_fault), np.empty(n_fault), np.empty(n_fault)
    there = np.empty(n_fault)
    for k in range(xy.shape[0]):
        x, y = xy[k, 0], xy[k, 1]
        from_x, from_y = x, y
        old = height_at(grid, rising, to_columns, x, y)
        found = False
        writes = gradual and in_walls.shape[1] > 0
        stays, start, room = writes, old, -1.0
        for n_round in range(rounds):
            if not gradual:
                for i in range(n_fault):
                    part[i] = parts[i, k]
            elif not abs(old - start) < room:  # else it has the walls of the first round
                room = -1.0
                _gradual_parts(
                    faults, tables, flat, acts, ends, lean, x, y, old, walls, part, there
                )
                stays = stays and _stay_in_walls(walls, first, n_round)
                if stays and n_round == 0:
                    room = _room(faults, lean, steep, spare, x, y, walls, there)

            # forward, through all faults, the oldest first
            now_x, now_y = from_x, from_y
            height = old  # of the first round: it starts at the place itself
            if n_round > 0:
                height = height_at(grid, rising, to_columns, from_x, from_y)
            is_there = gradual and n_round == 0  # until it moves
            for j in range(n_fault):
                i = n_fault - 1 - j
                if part[i] != 0.0 and is_there:
                    of = faults[i]
                    now_x, now_y, height = moved_from(
                        of[4], of[5], of[6], of[7], of[8],
                        flat, tables[i, 0], tables[i, 1], tables[i, 2], of,
                        flat, tables[i, 3], tables[i, 4], tables[i, 5], steps,
                        of[9], now_x, now_y, height, there[i], part[i], of[10],
                    )  # fmt: skip
                    is_there = False
                elif part[i] != 0.0:
                    of = faults[i]
                    now_x, now_y, height = moved_particle(
                        of[4], of[5], of[6], of[7], of[8],
                        flat, tables[i, 0], tables[i, 1], tables[i, 2], of,
                        flat, tables[i, 3], tables[i, 4], tables[i, 5], steps,
                        of[9], now_x, now_y, height, part[i], of[10],
                    )  # fmt: skip
            if writes and n_round == 0:
                moved_there[k, 0], moved_there[k, 1] = now_x, now_y
            off_x, off_y = x - now_x, y - now_y
            missed = abs(off_x) > close or abs(off_y) > close
            if stays and not missed:
                for i in range(n_fault):
                    in_walls[i, k] = first[i]
                z_there[k] = height
                was_there[k, 0], was_there[k, 1] = from_x, from_y
                stays = False
            if gradual and abs(height - old) > close and not abs(height - start) < room:
                missed = True
            if not missed:
                z[k] = height
                was[k, 0], was[k, 1] = from_x, from_y
                found = True
                break
            from_x, from_y, old = from_x + off_x, from_y + off_y, height
        if not found:
            z[k] = old
            return k
    return -1


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
