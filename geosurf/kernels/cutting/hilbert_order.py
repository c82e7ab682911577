"""Order of the points of a face along the Hilbert curve: neighbours in the order are near in the
face.

Letters as in `delaunay`. Only speed depends on this order.
"""

from __future__ import annotations

from geosurf.kernels.compile.jit import scalar

_DIGIT = 8  # bits that are sorted at a time
_NUMBER = 31  # lower bits of a key: index of the point
_FEW = 256  # up to this many points the curve has 8 levels, else 16
_TURNS = 64  # entries of the table of orientations
N_EXTRA = (1 << _DIGIT) + _TURNS  # scratch numbers of `rank_points` in addition to two per point


@scalar
def _write_turns(scratch, at):
    """Write a table of two levels of the curve at once, 64 entries of `scratch` from `at` on.

    The orientation of the curve in a square is one of four: bit 1 swaps the coordinates, bit 0
    reverses both. Entry 16 orientation + 4 i + j, with two bits of each coordinate, is 16 times the
    orientation below plus the two digits of the place.
    """
    for number in range(_TURNS):
        orientation, place = number >> 4, 0
        for level in range(1, -1, -1):
            one, two = (number >> 2 + level) & 1, (number >> level) & 1
            right = (two if orientation & 2 else one) ^ (orientation & 1)
            up = (one if orientation & 2 else two) ^ (orientation & 1)
            place = 4 * place + (3 * right if up == 0 else 1 + right)
            if up == 0:
                orientation ^= 2 + right
        scratch[at + number] = 16 * orientation + place


@scalar
def _place_by_turns(scratch, at, u, v, n_level):
    """Place of a point of the unit square on the curve, below 4**n_level; `n_level` is even."""
    # Cell of the point in a grid of 2**n_level by 2**n_level cells.
    last = (1 << n_level) - 1
    i, j = int(u * last), int(v * last)
    orientation, place = 0, 0
    for level in range(n_level - 2, -1, -2):
        # Two levels of the curve per lookup.
        found = scratch[at + 16 * orientation + 4 * ((i >> level) & 3) + ((j >> level) & 3)]
        place = 16 * place + (found & 15)
        orientation = found >> 4
    return place


@scalar
def _sort_digit(scratch, source, to, n, shift):
    """Copy n keys from one part of `scratch` to another, sorted by one digit (radix sort)."""
    mask = (1 << _DIGIT) - 1
    places = 2 * n  # where `scratch` holds the places of the digits
    for i in range(places, places + mask + 1):
        scratch[i] = 0

    # Count the digits, turn counts into starts, then copy.
    for i in range(source, source + n):
        scratch[places + ((scratch[i] >> shift) & mask)] += 1
    place = to
    for i in range(places, places + mask + 1):
        count = scratch[i]
        scratch[i] = place
        place += count
    # In order, so that keys with equal digits keep theirs: the next digit relies on it.
    for i in range(source, source + n):
        digit = places + ((scratch[i] >> shift) & mask)
        scratch[scratch[digit]] = scratch[i]
        scratch[digit] += 1


@scalar
def rank_points(f, low, high, scratch):
    """Write local points low..high, fewer than 2**31, into `scratch` in curve order."""
    n = high - low

    # Scale the bounding square to the unit square.
    u0, u1, v0, v1 = f[low, 0], f[low, 0], f[low, 1], f[low, 1]
    for p in range(low + 1, high):
        u0, u1 = min(u0, f[p, 0]), max(u1, f[p, 0])
        v0, v1 = min(v0, f[p, 1]), max(v1, f[p, 1])
    size = max(u1 - u0, v1 - v0)
    # Without extent all points share one place, and their index orders them.
    scale = 1.0 / size if size > 1e-290 else 0.0
    n_level = 8 if n <= _FEW else 16
    turns = 2 * n + (1 << _DIGIT)
    _write_turns(scratch, turns)

    # Key: place on the curve, then index of the point.
    for i in range(n):
        u, v = (f[low + i, 0] - u0) * scale, (f[low + i, 1] - v0) * scale
        scratch[i] = (_place_by_turns(scratch, turns, u, v, n_level) << _NUMBER) + low + i
    source, to = 0, n
    for digit in range(2 * n_level // _DIGIT):  # an even number: they end where they began
        _sort_digit(scratch, source, to, n, _NUMBER + _DIGIT * digit)
        source, to = to, source
    for i in range(n):
        scratch[i] &= (1 << _NUMBER) - 1
