"""Smooth curves along exact ones: few knots, and cubic arcs between them.

The exact curve gives ends, closure and order; knots are lifted from some of its points
(`exact_knots`). At the end, chords are cut from the arcs (`knots`). On triangles, arcs end at
edges. Near holes the exact curve stays. Where a knot cannot be lifted, the whole is given up.

Letters as in `exact_knots`.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.smooth.exact_chains import contacts_of_points, faces_of, trace_segments
from geosurf.kernels.smooth.exact_error import corners_of_face, error_of_exact
from geosurf.kernels.smooth.exact_knots import (
    DEEPEST,
    UNKNOWN,
    Chains,
    append_keys,
    follow_run,
    lift_row,
)
from geosurf.kernels.smooth.hermite_arcs import N_KNOT
from geosurf.kernels.smooth.knots import cut_chords, with_room
from geosurf.kernels.smooth.lift import LIFTED, N_WORK, SurfacePair

FOLLOWED, LOST, NOISY, MEASURED = 0, 1, 2, 3
MEASURE, FOLLOW, CHOOSE = 0, 1, 2  # what is asked for


@scalar
def _end_of_run(chains, mesh, near, i, stop):
    """Where the run from point i on ends: at a hole, at an edge of the mesh, or at point `stop`."""
    j, tri = i + 1, 0
    if mesh:
        tri = faces_of(chains.rows, chains.surface_of_face, chains.contact[i])[1]
    while j < stop and not near[j]:
        if mesh and faces_of(chains.rows, chains.surface_of_face, chains.contact[j])[1] != tri:
            break
        j += 1
    return j, tri


@scalar
def _follow_stretch(
    surfaces, chains, near, first, stop, closed, span, tolerance, enough, loose, knots, keys, n_key,
    with_keys, stack, places, corners, row, f, g,
):  # fmt: skip
    """Knots from point `first` of the chain to a hole or `stop`, run after run.

    Returns knots, their number, keys, their number, the point that was reached, and whether all
    could be lifted.
    """
    za, zb, mesh = surfaces.za, surfaces.zb, surfaces.zb.shape[0] == 1
    n, i = 0, first
    while i < stop and not near[i]:
        j, face = _end_of_run(chains, mesh, near, i, stop)
        if mesh:
            corners_of_face(chains.x, chains.t, face, chains.origin, surfaces.c[0])
        knots, tri = with_room(knots, n), chains.key_of_face[face] if mesh else 0
        found = lift_row(surfaces, chains, i, i, True, enough, knots[n], corners, f)
        if found != LIFTED:
            return knots, n, keys, n_key, i, False
        if n > 0:  # one point, on two triangles
            for k in range(3):
                knots[n, k] = knots[n - 1, k]
        begin = n
        knots, n, good = follow_run(
            surfaces, chains, i, j, closed and i == first and j == stop, span, tolerance, enough,
            loose, knots, n + 1, stack, places, corners, row, f, g,
        )  # fmt: skip
        if not good:
            return knots, n, keys, n_key, i, False
        for k in range(begin + 1, n if with_keys == 1 else 0):
            keys, n_key = append_keys(za, zb, knots[k - 1], knots[k], tri, row, keys, n_key)
        i = j
    return knots, n, keys, n_key, i, True


@scalar
def _append_exact(chains, first, last, out, n):
    """Append points first to last of the chain as they are; rows and their number."""
    if n + last + 1 - first > out.shape[0]:
        more = np.empty((2 * (n + last + 1 - first), 3))
        more[:n] = out[:n]
        out = more
    for i in range(first, last + 1):
        for k in range(3):
            out[n, k] = chains.local[chains.chain[i], k]
        n += 1
    return out, n


@entry("d2 d2 d2 d2 d2 d2 l l d2 l1 l1 l2 l2 d2 l2 l1 l1 d1 l l d l l l -> d1 d2 l1 d2 l2 l1 l")
def follow_exact(
    xa, ya, za, xb, yb, zb, rising_a, rising_b, local, chain, offsets, rows, ids, x, t,
    surface_of_face, key_of_face, origin, holes, span, tolerance, with_keys, most, task,
):  # fmt: skip
    """Error of the exact curves of a lattice and another surface, and smooth curves along them.

    `offsets` (n_curve + 1,) of curves in `chain`; `holes`: whether nodes may be absent; `span`: the
    most segments of an exact curve that an arc replaces; `most`: segments that are measured. The
    task is MEASURE, FOLLOW, or CHOOSE: curves are followed where some segments show that the error
    is above the tolerance and noise is not why.

    Returns five numbers of `error_of_exact`, if measured; points (n, 3) less the origin, offsets of
    curves in them, bound and estimate of each curve (`cut_chords`), rows (curve, first, last) of
    points of the exact curve near holes, keys of the pairs of cells along the curves, with
    triangles as keys of faces, if asked for; and FOLLOWED, or MEASURED, LOST or NOISY and nothing
    to use.
    """
    error = np.zeros(5)
    if task != FOLLOW:
        error[0], error[1], error[2], error[3], error[4] = error_of_exact(
            xa, ya, za, xb, yb, zb, rising_a, rising_b, rows, ids, x, t, surface_of_face,
            key_of_face, origin, most, tolerance if task == CHOOSE else np.inf,
        )  # fmt: skip
    if task == MEASURE or (task == CHOOSE and not (error[0] > tolerance and error[2] == 0.0)):
        keys, spans = np.empty(0, dtype=np.int64), np.empty((0, 3), dtype=np.int64)
        return error, np.empty((0, 3)), keys, np.empty((0, 2)), spans, keys, MEASURED
    points, stops, figures, spans, keys, status = _follow(
        xa, ya, za, xb, yb, zb, rising_a, rising_b, local, chain, offsets, rows, ids, x, t,
        surface_of_face, key_of_face, origin, holes, span, tolerance, with_keys,
    )  # fmt: skip
    return error, points, stops, figures, spans, keys, status


@scalar
def _follow(
    xa, ya, za, xb, yb, zb, rising_a, rising_b, local, chain, offsets, rows, ids, x, t,
    surface_of_face, key_of_face, origin, holes, span, tolerance, with_keys,
):  # fmt: skip
    """Smooth curves along exact ones: what `follow_exact` returns after the error."""
    out, n_out, offset = np.empty((256, 3)), 0, np.zeros(offsets.shape[0], dtype=np.int64)
    figures, spans = np.zeros((offsets.shape[0] - 1, 2)), np.empty((16, 3), dtype=np.int64)
    keys, n_key, n_span, status = np.empty(64, dtype=np.int64), 0, 0, FOLLOWED
    of = contacts_of_points(local, x, rows, ids)
    # between two whole lattices, contacts are needed at knots only
    contact = np.full(chain.shape[0], UNKNOWN, dtype=np.int64)
    near = np.zeros(chain.shape[0], dtype=np.bool_)
    if holes == 1 or zb.shape[0] == 1:
        contact, near = trace_segments(
            xa, ya, za, xb, yb, zb, chain, offsets, of, rows, surface_of_face, key_of_face, holes
        )  # fmt: skip
    if contact.shape[0] == 0 or of.shape[0] == 0:
        return out[:0], offset, figures, spans[:0], keys[:0], LOST
    chains = Chains(
        local, chain, rows, x, t, surface_of_face, key_of_face, origin, of, contact, rising_a,
        rising_b,
    )  # fmt: skip
    surfaces = SurfacePair(xa, ya, za, xb, yb, zb, np.zeros((1, 3, 3)))
    knots, stack = np.empty((64, N_KNOT)), np.empty((DEEPEST + 1, N_KNOT))
    places, corners, row = np.empty(DEEPEST + 1, dtype=np.int64), np.empty((4, 5)), np.empty(7)
    f, g = np.empty(N_WORK), np.empty(N_WORK)

    # as for walks, with a segment in place of the first step
    small = min(1.0, _mean_length(local, chain, offsets))
    enough = math.sqrt(min(1e-6, 1e-3 * tolerance) * small)
    loose = math.sqrt(1e-3 * tolerance * small)
    for k in range(offsets.shape[0] - 1):
        i, last = offsets[k], offsets[k + 1] - 1
        first, closed = i, chain[i] == chain[last]
        if closed and last == i + 1:  # two names of one point
            out, n_out = _append_exact(chains, i, i, out, n_out)
            i = last
        while i < last and status == FOLLOWED:
            if near[i]:
                j = i
                while j < last and near[j]:
                    j += 1
                # the points next to lifted ones belong to these
                begin, end = i if i == first else i + 1, j if j == last else j - 1
                before = n_out
                out, n_out = _append_exact(chains, begin, end, out, n_out)
                if n_span == spans.shape[0]:
                    more = np.empty((2 * n_span, 3), dtype=np.int64)
                    more[:n_span] = spans
                    spans = more
                spans[n_span, 0], spans[n_span, 1], spans[n_span, 2] = k, before, n_out
                n_span += 1
                i = j
                continue
            knots, n, keys, n_key, i, good = _follow_stretch(
                surfaces, chains, near, i, last, closed and i == first, span, tolerance, enough,
                loose, knots, keys, n_key, with_keys, stack, places, corners, row, f, g,
            )  # fmt: skip
            if not good:
                status = LOST
                break
            before = n_out
            out, n_out, bound, worst, noisy = cut_chords(knots, 0, n, tolerance, out, n_out)
            for at in range(before, n_out):
                for axis in range(3):
                    out[at, axis] -= origin[axis]
            if noisy:
                status = NOISY
            figures[k, 0], figures[k, 1] = max(figures[k, 0], bound), max(figures[k, 1], worst)
        if status != FOLLOWED:
            return out[:0], offset, figures, spans[:0], keys[:0], status
        if closed:
            for axis in range(3):
                out[n_out - 1, axis] = out[offset[k], axis]
        offset[k + 1] = n_out
    return out[:n_out].copy(), offset, figures, spans[:n_span], keys[:n_key], status


@scalar
def _mean_length(local, chain, offsets):
    """Mean length of the segments of some curves [m]."""
    total, n = 0.0, 0
    for k in range(offsets.shape[0] - 1):
        for i in range(offsets[k], offsets[k + 1] - 1):
            size = 0.0
            for axis in range(3):
                size += (local[chain[i + 1], axis] - local[chain[i], axis]) ** 2
            total += math.sqrt(size)
            n += 1
    return total / max(n, 1)
