"""Knots of smooth curves along exact ones, and cubic arcs between them.

Knots are lifted from some points of the exact curve by Newton's method. An arc between two knots
(`hermite_arcs`) is measured at its quarters, as on a walk (`curve_walk`). Where it is too far from
the curve, it is divided at the point of the exact curve halfway between them; between points next
to each other, at its own middle.

Letters as in `lift`, `hermite_arcs` and `exact_chains`; c has one triangle, the one that the curve
is in, in world coordinates as everything here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.smooth.coverage import key_of
from geosurf.kernels.smooth.curve_walk import allowed_distance, measure_arc
from geosurf.kernels.smooth.exact_chains import contact_of_segment, faces_of
from geosurf.kernels.smooth.exact_error import on_lattice, parameters_in
from geosurf.kernels.smooth.hermite_arcs import (
    K_DISTANCE,
    K_ERROR,
    K_LENGTH,
    K_SINE,
    K_SLOPE,
    N_KNOT,
    along_arc,
    on_arc,
    set_length,
)
from geosurf.kernels.smooth.knots import set_knot, with_room
from geosurf.kernels.smooth.lift import (
    ASTRAY,
    F_TANGENT,
    HOLD_SUM,
    HOLD_UA,
    HOLD_UB,
    HOLD_VB,
    HOLE,
    LIFTED,
    differences_at,
    newton_in_plane_to,
    newton_on_boundary,
)

_ON_RIM = 1e-9  # [cells]
DEEPEST = 24  # divisions of an arc
_FARTHEST = 2.0  # [cells] that a point may be lifted by; farther is another curve
UNKNOWN = -2  # the contact of a segment, until it is asked for
_PLACES = 8  # places of an arc at which its pair of cells is determined


class Chains(NamedTuple):
    """Exact curves and their contacts, as in `exact_chains`.

    `of`: contacts of each point; `contact`: that of each segment, or UNKNOWN.
    """

    local: np.ndarray
    chain: np.ndarray
    rows: np.ndarray
    x: np.ndarray
    t: np.ndarray
    surface_of_face: np.ndarray
    key_of_face: np.ndarray
    origin: np.ndarray
    of: np.ndarray
    contact: np.ndarray
    rising_a: int
    rising_b: int


@scalar
def _held(za, zb, w, at_end):
    """What is held at a point of the curve: an edge of a triangle, at an end a rim; 0: nothing."""
    hold = 0
    if zb.shape[0] == 1:
        if abs(1.0 - w[2] - w[3]) < _ON_RIM:
            hold = HOLD_SUM
        if abs(w[2]) < _ON_RIM:
            hold = HOLD_UB
        if abs(w[3]) < _ON_RIM:
            hold = HOLD_VB
    if not at_end:
        return hold

    # the first surface last: where both have a rim, that of the first one is held
    for step in range(4):
        k = (2, 3, 0, 1)[step]
        z = za if k < 2 else zb
        if z.shape[0] == 1:
            continue
        top = (z.shape[1] if k % 2 == 0 else z.shape[0]) - 1.0
        if min(w[k], top - w[k]) < _ON_RIM:
            w[k] = round(w[k])
            hold = HOLD_UA + k
    return hold


@scalar
def _finish_knot(surfaces, p, q, r, f, knot):
    """Write what Newton's method found, along direction (p, q, r), and errors; HOLE if none."""
    along = p * f[F_TANGENT] + q * f[F_TANGENT + 1] + r * f[F_TANGENT + 2]
    set_knot(1.0 if along >= 0.0 else -1.0, f, knot)
    knot[K_LENGTH], knot[K_DISTANCE] = -1.0, 0.0
    differences_at(surfaces, knot[3:7], f, knot[K_ERROR:K_SINE])
    return HOLE if math.isnan(knot[K_ERROR] + knot[K_ERROR + 3]) else LIFTED


@scalar
def lift_row(surfaces, chains, i, segment, at_end, enough, knot, corners, f):
    """Lift point i of the chain, in the faces of a segment next to it, to a knot."""
    chain, contact = chains.chain, chains.contact
    if contact[segment] == UNKNOWN:
        contact[segment] = contact_of_segment(chains.of, chain[segment], chain[segment + 1])
    if contact[segment] < 0:
        return ASTRAY
    one, two = faces_of(chains.rows, chains.surface_of_face, contact[segment])
    # the last row of `corners` is free
    place, w, row = corners[3], knot[3:7], chains.local[chain[i]]
    for k in range(3):
        place[k] = row[k] + chains.origin[k]
    xa, ya, za, xb, yb, zb, c = surfaces
    on_lattice(xa, ya, za, chains.key_of_face[one], chains.rising_a, place, corners, w, 0)
    if zb.shape[0] > 1:
        on_lattice(xb, yb, zb, chains.key_of_face[two], chains.rising_b, place, corners, w, 2)
    else:
        w[2], w[3] = parameters_in(c[0], place)
    hold = _held(za, zb, w, at_end)
    u, v, s, t = w[0], w[1], w[2], w[3]
    if hold > 0:
        found = newton_on_boundary(surfaces, 0, w, hold, f)
    else:
        found = newton_in_plane_to(
            surfaces, 0, w, place[0], place[1], place[2], 0.0, 0.0, 0.0, enough, f
        )
    if found != LIFTED:
        return found
    far = max(abs(w[0] - u), abs(w[1] - v))
    if zb.shape[0] > 1:
        far = max(far, abs(w[2] - s), abs(w[3] - t))
    if far > _FARTHEST:
        return ASTRAY
    a, b = chains.local[chain[segment]], chains.local[chain[segment + 1]]
    return _finish_knot(surfaces, b[0] - a[0], b[1] - a[1], b[2] - a[2], f, knot)


@scalar
def _is_ahead(one, two):
    """Whether a knot is ahead of another one, by the tangents of both."""
    out, back = 0.0, 0.0
    for k in range(3):
        out += (two[k] - one[k]) * one[K_SLOPE + k]
        back += (two[k] - one[k]) * two[K_SLOPE + k]
    return out > 0.0 and back > 0.0


@scalar
def _halve_arc(surfaces, one, two, enough, f, knot):
    """A knot over the middle of an arc."""
    on_arc(one, two, 0.5, knot)
    p, q, r = along_arc(one, two, 0.5)
    x, y, z = knot[0], knot[1], knot[2]
    found = newton_in_plane_to(surfaces, 0, knot[3:7], x, y, z, p, q, r, enough, f)
    if found != LIFTED:
        return found
    return _finish_knot(surfaces, p, q, r, f, knot)


@scalar
def append_keys(za, zb, one, two, tri, row, keys, n):
    """Append the keys of the pairs of cells that an arc runs through; keys and their number."""
    if n + _PLACES > keys.shape[0]:
        more = np.empty(2 * (n + _PLACES), dtype=np.int64)
        more[:n] = keys[:n]
        keys = more
    for place in range(_PLACES):
        on_arc(one, two, place / _PLACES, row)
        keys[n] = key_of(za, zb, row[3:7], tri)
        n += 1
    return keys, n


@scalar
def _copy_knot(one, two):
    for k in range(N_KNOT):
        two[k] = one[k]


@scalar
def follow_run(
    surfaces, chains, first, last, closed, span, tolerance, enough, loose, knots, n, stack, places,
    corners, row, f, g,
):  # fmt: skip
    """Append knots up to point `last` of the chain, from the knot of point `first`, which is the
    last one of `knots`; knots, their number, and whether all could be lifted.
    """
    begin, here = n - 1, first
    while here < last:
        # the next goal; one that cannot be lifted is left out, unless it is the last
        goal = min(here + span, last)
        top = 1
        if goal == last and closed:
            _copy_knot(knots[begin], stack[0])
        else:
            found = lift_row(
                surfaces, chains, goal, goal - 1, goal == last, enough, stack[0], corners, f
            )
            if found != LIFTED and goal < last:
                goal = last
                if closed:
                    _copy_knot(knots[begin], stack[0])
                    found = LIFTED
                else:
                    found = lift_row(
                        surfaces, chains, goal, goal - 1, True, enough, stack[0], corners, f
                    )
            if found != LIFTED:
                return knots, n, False
        places[0] = goal
        while top > 0:
            knots = with_room(knots, n)
            one, two = knots[n - 1], stack[top - 1]
            set_length(one, two)
            ahead, target = _is_ahead(one, two), allowed_distance(one, tolerance)
            away = np.inf
            if ahead:
                away = measure_arc(surfaces, one, two, target, loose, row, g)
            if away <= target:
                _copy_knot(two, knots[n])
                knots[n, K_DISTANCE] = away
                here = places[top - 1]
                n += 1
                top -= 1
                continue
            if top == DEEPEST:
                return knots, n, False

            # a point of the exact curve halfway, else the middle of the arc
            middle, found = (here + places[top - 1]) // 2, ASTRAY
            if here < middle < places[top - 1]:
                found = lift_row(
                    surfaces, chains, middle, middle, False, enough, stack[top], corners, f
                )
            if found != LIFTED and ahead:
                middle = here
                found = _halve_arc(surfaces, one, two, enough, f, stack[top])
            if found != LIFTED:
                return knots, n, False
            places[top] = middle
            top += 1
    return knots, n, True
