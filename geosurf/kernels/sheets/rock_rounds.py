"""All rounds in which the rock that throw brings to a place is found, particle by particle.

A particle stays in registers until it has arrived. Where throw is one number for each fault, that
takes a third of the time of rounds of all particles, and gives the same bits. The notation is that
of `moved_rock`.
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.sheets.moved_rock import across, height_at, moved_from, moved_particle


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
