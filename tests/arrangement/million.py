"""Count wrong contacts of pairs: ``python -m tests.arrangement.million [pairs] [seconds] [first]``.

What `meet_pairs` says (every named point, coplanar, crossing) against whole-number arithmetic over
arrays: int64 where coordinates are 0..3 (and the same pairs moved, which changes no sign), Python
integers for a sample of all other pairs. Those are also met with the float filters shut, all of
them. It stops after so many seconds, if they are given; ends with 1 if a contact is wrong.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from geosurf.kernels.contacts.triangle_contact import (
    COPLANAR,
    CROSSING,
    FIRST_CODE,
    N_COLUMN,
    N_CORNER,
    meet_pairs,
)
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.mesh import weld
from tests.strategies import UTM

CHUNK = 20_000
SAMPLE = 1_000  # of a chunk, for Python integers
SHUT = 1e250  # no float sign is sure if coordinates may move so far
NEXT, LAST = (1, 2, 0), (2, 0, 1)


# -------------------------------------------------------------- whole numbers
def cross(u, v):
    """Products of rows, in whole numbers."""
    parts = [u[:, NEXT[k]] * v[:, LAST[k]] - u[:, LAST[k]] * v[:, NEXT[k]] for k in range(3)]
    return np.stack(parts, axis=1)


def sign(values):
    return (values > 0).astype(np.int8) - (values < 0).astype(np.int8)


def dot(u, v):
    return (u * v).sum(axis=1)


def volume(a, b, c, d):
    """Sign of the volume of tetrahedra."""
    return sign(dot(cross(b - a, c - a), d - a))


def feature(signs, holds):
    """Feature from three signs against the edges (turned to be positive inside); -1 outside."""
    zero = signs == 0
    n = zero.sum(axis=1)
    out = np.where(n == 0, 6, np.where(n == 1, 3 + zero.argmax(axis=1), -1))
    # two zeros: the corner between edges k - 1 and k
    for k in range(3):
        out[(n == 2) & zero[:, k] & zero[:, LAST[k]]] = k
    return np.where(holds & (signs >= 0).all(axis=1), out, -1)


def put(mask, code, where):
    """Add a code to the sets (bits) of some rows."""
    bit = np.left_shift(np.uint64(1), np.where(where, code, 0).astype(np.uint64))
    mask |= np.where(where, bit, np.uint64(0))


def corners_in(T, normal, side, mask, P, first):
    """Add the corners of P that lie in T: features of T, corner first or second in the code."""
    for i in range(3):
        signs = np.stack(
            [
                sign(dot(cross(T[:, NEXT[k]] - T[:, k], P[:, i] - T[:, k]), normal))
                for k in range(3)
            ],
            axis=1,
        )
        of = feature(signs, side[:, i] == 0)
        code = 8 * i + of if first else 8 * of + i
        put(mask, code, of >= 0)


def edges_through(T, side, mask, P, first):
    """Add the points where edges of P pass strictly through T, off its corners."""
    for i in range(3):
        p, q = P[:, i], P[:, NEXT[i]]
        passes = side[:, i] * side[:, NEXT[i]] < 0
        signs = np.stack([volume(p, q, T[:, k], T[:, NEXT[k]]) for k in range(3)], axis=1)
        turn = np.where((signs < 0).any(axis=1), -1, 1)[:, None]
        of = feature(signs * turn, passes)
        code = 8 * (3 + i) + of if first else 8 * of + 3 + i
        put(mask, code, of >= 3)


def true_contacts(P, Q):
    """Sets of codes as bits, coplanar, crossing of pairs (n, 3, 3) of whole numbers."""
    normals = [cross(T[:, 1] - T[:, 0], T[:, 2] - T[:, 0]) for T in (P, Q)]
    sides = [
        np.stack([sign(dot(normal, S[:, k] - T[:, 0])) for k in range(3)], axis=1)
        for S, T, normal in ((P, Q, normals[1]), (Q, P, normals[0]))
    ]
    mask = np.zeros(len(P), dtype=np.uint64)
    corners_in(Q, normals[1], sides[0], mask, P, True)
    corners_in(P, normals[0], sides[1], mask, Q, False)
    edges_through(Q, sides[0], mask, P, True)
    edges_through(P, sides[1], mask, Q, False)
    coplanar = (sides[0] == 0).all(axis=1)
    for i in range(3):
        for j in range(3):
            p, q, r, s = P[:, i], P[:, NEXT[i]], Q[:, j], Q[:, NEXT[j]]
            # in one plane, or an edge of one in the plane of the other: ends on two sides
            n = normals[1]
            one = sign(dot(cross(q - p, r - p), n)) * sign(dot(cross(q - p, s - p), n))
            two = sign(dot(cross(s - r, p - r), n)) * sign(dot(cross(s - r, q - r), n))
            put(mask, 8 * (3 + i) + 3 + j, coplanar & (one < 0) & (two < 0))
    straddle = [(s.min(axis=1) < 0) & (s.max(axis=1) > 0) for s in sides]
    crossing = ~coplanar & straddle[0] & straddle[1] & (counted(mask) == 2)
    return mask, coplanar & (mask > 0), crossing


def counted(mask):
    return np.bitwise_count(mask).astype(np.int64)


def lengths(P, Q):
    """0 apart, 1 point, 2 segment by overlap of intervals on the common line; -1 where coplanar.

    Another way to count corners; needs products of six coordinates.
    """
    normals = [cross(T[:, 1] - T[:, 0], T[:, 2] - T[:, 0]) for T in (P, Q)]
    line = cross(*normals)
    ends = []
    for S, T, normal in ((P, Q, normals[1]), (Q, P, normals[0])):
        side = np.stack([dot(normal, S[:, k] - T[:, 0]) for k in range(3)], axis=1)
        at = np.stack([dot(line, S[:, k]) for k in range(3)], axis=1)
        found = np.zeros(len(P), dtype=bool)
        low, high = (np.stack([0 * at[:, 0], 0 * at[:, 0] + 1]) for _ in range(2))
        for k in range(3):
            m = NEXT[k]
            on = side[:, k] == 0
            through = side[:, k] * side[:, m] < 0
            span = np.where(through, side[:, k] - side[:, m], 1)
            value = np.where(through, at[:, m] * side[:, k] - at[:, k] * side[:, m], at[:, k])
            value, span = value * np.sign(span), np.abs(span)
            for where in (on & ~through, through):
                less = where & (~found | (value * low[1] < low[0] * span))
                more = where & (~found | (value * high[1] > high[0] * span))
                low[:, less] = value[less], span[less]
                high[:, more] = value[more], span[more]
                found |= where
        ends.append((low, high, found))
    (a0, a1, fa), (b0, b1, fb) = ends

    def compare(u, v):
        return np.sign(u[0] * v[1] - v[0] * u[1])

    start = np.where(compare(a0, b0) > 0, a0, b0)
    stop = np.where(compare(a1, b1) < 0, a1, b1)
    out = 1 + compare(stop, start)
    out = np.where(fa & fb, out, 0)
    return np.where((line == 0).all(axis=1), -1, out)


# ------------------------------------------------------------------ the kernel
def found_contacts(P, Q, slip=0.0):
    """The same from the kernel, all pairs in one call."""
    corners = np.concatenate([P, Q]).reshape(-1, 3) + 0.0
    number, count = weld(corners)
    x = np.empty((count, 3))
    x[number] = corners
    t = number.reshape(-1, 3)
    n = len(P)
    m, w = frame_of(x, len(t))
    rows = np.empty((n + 1, N_COLUMN), dtype=np.int64)
    pairs = np.stack([np.arange(n), n + np.arange(n)], axis=1)
    n_row, _ = meet_pairs(x, t, pairs, m, w, slip, rows, np.empty(0, dtype=np.int64))
    rows = rows[:n_row]
    mask = np.zeros(n, dtype=np.uint64)
    coplanar, crossing = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
    own = np.zeros(n_row, dtype=np.uint64)
    for k in range(6):
        put(own, rows[:, FIRST_CODE + k] & 63, rows[:, N_CORNER] > k)
    own[counted(own) != rows[:, N_CORNER]] = 0  # a point named twice is wrong
    mask[rows[:, 0]] = own
    coplanar[rows[:, 0]], crossing[rows[:, 0]] = rows[:, COPLANAR] == 1, rows[:, CROSSING] == 1
    return mask, coplanar, crossing


def differing(one, two):
    """Rows in which two answers differ."""
    return np.flatnonzero(np.any([a != b for a, b in zip(one, two, strict=True)], axis=0))


# -------------------------------------------------------------------- families
def lattice(rng, n):
    """Pairs of triangles with corners in 0..3, a quarter of them in one plane."""
    P, Q = rng.integers(0, 4, (2, 2 * n, 3, 3))
    flat = rng.random(2 * n) < 0.25
    P[flat, :, 2] = Q[flat, :, 2] = 2
    skew = flat & (rng.random(2 * n) < 0.5)
    for T in (P, Q):
        T[skew, :, 2] = 3 * T[skew, :, 0] - 2 * T[skew, :, 1]
        T[skew] = T[skew][:, :, [2, 0, 1]]
    solid = [cross(T[:, 1] - T[:, 0], T[:, 2] - T[:, 0]).any(axis=1) for T in (P, Q)]
    keep = np.flatnonzero(solid[0] & solid[1])[:n]
    return P[keep], Q[keep]


def nudged(rng, P, Q, share=0.3):
    """Moved off the lattice, and some coordinates to a neighbouring double."""
    T = np.stack([P, Q]) + 0.1
    some = rng.random(T.shape) < share
    T[some] = np.nextafter(T, np.where(rng.random(T.shape) < 0.5, 9.0, -9.0))[some]
    return T[0], T[1]


def on_plane(rng, n):
    """One corner of Q at a rounded point of the plane of P, or of its edge."""
    P, Q = rng.uniform(0, 4, (2, n, 3, 3))
    share = rng.dirichlet((1, 1, 1), n)
    share[rng.random(n) < 0.4, 2] = 0
    share /= share.sum(axis=1, keepdims=True)
    Q[:, 0] = (share[:, :, None] * P).sum(axis=1)
    return P, Q


FAMILIES = {
    "nudged": lambda rng, n: nudged(rng, *lattice(rng, n)),
    "random": lambda rng, n: tuple(rng.uniform(0, 1, (2, n, 3, 3)) * rng.choice([1, 1e3, 1e-3])),
    "on a plane": on_plane,
    "random at UTM": lambda rng, n: tuple(rng.uniform(0, 50, (2, n, 3, 3)) + UTM),
    "nudged at UTM": lambda rng, n: tuple(
        25 * T + np.array(UTM) for T in nudged(rng, *lattice(rng, n))
    ),
    "on a plane at UTM": lambda rng, n: tuple(20 * T + np.array(UTM) for T in on_plane(rng, n)),
}


def whole(*arrays):
    """Doubles as Python integers, all scaled by one power of two."""
    parts = [np.frexp(array) for array in arrays]
    least = min(int(e.min()) for _, e in parts) - 53
    out = []
    for fraction, e in parts:
        mantissa = np.ldexp(fraction, 53).astype(np.int64).astype(object)
        out.append(mantissa << (e - 53 - least).astype(object))
    return out


def lattice_chunk(rng, n):
    """Cases, contacts and wrong ones of lattice pairs, at home and moved."""
    P, Q = lattice(rng, n)
    true = true_contacts(P, Q)
    span = lengths(P, Q)
    wrong = [np.flatnonzero((span >= 0) & (span != counted(true[0])))]
    places = ((1.0, 0.0), (12.5, np.array(UTM)), (2.0**-300, 0.0), (2.0**40, 0.0))
    scale, offset = places[rng.integers(1, 4)]
    for a, b in ((1.0, 0.0), (scale, offset)):
        wrong.append(differing(true, found_contacts(P * a + b, Q * a + b)))
    wrong.append(differing(true, found_contacts(P * 1.0, Q * 1.0, SHUT)))
    return 3 * len(P), 3 * int((true[0] > 0).sum()), P, Q, np.concatenate(wrong)


def double_chunk(name, rng, n, sample=SAMPLE):
    """The same for pairs of doubles: filters shut for all, integers for a sample."""
    P, Q = FAMILIES[name](rng, n)
    found = found_contacts(P, Q)
    wrong = [differing(found, found_contacts(P, Q, SHUT))]
    few = rng.permutation(n)[:sample]
    true = true_contacts(*whole(P[few], Q[few]))
    wrong.append(few[differing(true, [part[few] for part in found])])
    return n, int((found[0] > 0).sum()), P, Q, np.concatenate(wrong)


def main(arguments: list[str]) -> int:
    total = int(arguments[0]) if arguments else 1_000_000
    seconds = float(arguments[1]) if len(arguments) > 1 else float("inf")
    first = int(arguments[2]) if len(arguments) > 2 else 0
    start, done = time.monotonic(), {}
    for step in range(first, first - (-total // (CHUNK * (3 + len(FAMILIES))))):
        for family, name in enumerate(("lattice", *FAMILIES)):
            if time.monotonic() - start > seconds:
                break
            rng = np.random.default_rng([step, family])
            known = name == "lattice"
            chunk = lattice_chunk(rng, CHUNK) if known else double_chunk(name, rng, CHUNK)
            n, meeting, P, Q, wrong = chunk
            done[name] = done.get(name, 0) + np.array([n, meeting, len(wrong)])
            for row in wrong[:1]:
                say(f"wrong: {P[row].tolist()} {Q[row].tolist()}")
    for name, (n, meeting, wrong) in done.items():
        say(f"{name:18} {n:9} pairs {meeting:9} meet {wrong:4} wrong")
    n, meeting, wrong = sum(done.values())
    say(f"{n} pairs, {meeting} meet, {wrong} wrong, {time.monotonic() - start:.0f} s")
    return int(wrong > 0)


def say(line: str) -> None:
    sys.stdout.write(line + "\n")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
