"""All curves of two smooth lattices: a seed in each pair of cells, a walk from each new seed.

From a seed (`newton_seeds`) that is not near a known walk, the curve is followed both ways until it
closes or leaves a surface, from knot to knot. A step extrapolates the cubic of the last arc and
returns by Newton's method in the plane across (predictor, corrector). It is accepted if the cubic
arc between the two knots (`hermite_arcs`), measured at its quarters as in `resample`, is near
enough to the curve. The step length follows the fourth root of that distance. At the end, chords
are cut from the arcs, by what the error estimate along the whole curve (`error_estimate`) leaves
of the tolerance.

A pair of cells is settled if its surfaces are transverse, and a walk runs through it or near its
seed. All other pairs are returned, to be split.

Letters as in `lift` and `hermite_arcs`.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
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
from geosurf.kernels.smooth.knots import (
    cut_chords,
    reverse_knots,
    set_knot,
    set_knot_errors,
    with_room,
)
from geosurf.kernels.smooth.lift import (
    F_POINT,
    LIFTED,
    N_WORK,
    OUTSIDE,
    SurfacePair,
    newton_in_plane_to,
    newton_on_boundary,
)
from geosurf.kernels.smooth.newton_seeds import (
    NOT_PASSED,
    TO_SPLIT,
    classify_pairs,
    find_seed,
    is_disjoint_pair,
    is_near_curve,
    keys_passed,
    mark_passed,
)
from geosurf.kernels.smooth.patch_pairs import near_patches
from geosurf.kernels.smooth.trace import (
    AT_RIM,
    CLOSED,
    LOST,
    MAX_STEPS,
    MIN_STEP,
    boundary_crossed,
    clamp_to_boundary,
    step_direction,
)

NOISY = 4  # or a hole within three cells; in addition to AT_RIM, CLOSED, LOST
_FIRST_STEP, _FARTHEST = 0.25, 2.0  # [cells] of one step
_COARSEST = 0.25  # [cells] of a tolerance
_SAME = 4.0  # [tolerances]: seeds nearer to a walk are on it
# allowed distance of an arc from the curve: a part of the tolerance, reduced to the error of the
# cubics themselves where that is smaller, but not below the second part
_ARC, _FINEST = 0.1, 0.002
# steps are a little shorter than the last arc suggests, with limited growth: the measured distance
# jumps where cells change, and a rejected step costs as much as three
_CAREFUL, _GROWTH = 0.85, 1.4


@scalar
def allowed_distance(knot, tolerance):
    """Allowed distance of the next arc from the curve [m]."""
    # Errors of both cubics, as they move the curve: over the sine between the surfaces.
    error = (knot[K_ERROR] + knot[K_ERROR + 3]) / knot[K_SINE]
    return min(_ARC * tolerance, max(error, _FINEST * tolerance))


@scalar
def measure_arc(surfaces, one, two, target, enough, row, f):
    """Largest distance of the curve from an arc at its quarters; inf if it cannot be measured."""
    largest = 0.0

    # The middle first: it is mostly the largest.
    for k in range(3):
        t = 0.5 if k == 0 else (0.25 if k == 1 else 0.75)
        on_arc(one, two, t, row)
        x, y, z = row[0], row[1], row[2]
        p, q, r = along_arc(one, two, t)
        found = newton_in_plane_to(surfaces, 0, row[3:7], x, y, z, p, q, r, enough, f)
        if found != LIFTED:
            return np.inf
        x, y, z = f[F_POINT] - x, f[F_POINT + 1] - y, f[F_POINT + 2] - z
        largest = max(largest, math.sqrt(x * x + y * y + z * z))
        # The arc is rejected in any case: the other places do not matter.
        if largest > target:
            break
    return largest


@scalar
def _predict(surfaces, knots, first, n, step, enough, row, f):
    """Newton from a step beyond knot n - 1: along the last arc, the first time along the tangent.

    Writes the parameters to `row` (7,). Returns the status, and whether at a boundary.
    """
    za, zb = surfaces.za, surfaces.zb
    here = knots[n - 1]
    # The first step has no arc to extrapolate.
    if n - first > 1:
        on_arc(knots[n - 2], here, 1.0 + step / here[K_LENGTH], row)
    else:
        for k in range(7):
            row[k] = here[k] + step * here[K_SLOPE + k]
    p, q, r = here[K_SLOPE], here[K_SLOPE + 1], here[K_SLOPE + 2]
    w = row[3:7]
    found = newton_in_plane_to(surfaces, 0, w, row[0], row[1], row[2], p, q, r, enough, f)
    # Beyond the boundary: the curve ends on the boundary line.
    if found != OUTSIDE:
        return found, False
    hold = boundary_crossed(za, zb, w)
    clamp_to_boundary(za, zb, hold, w)
    return newton_on_boundary(surfaces, 0, w, hold, f), True


@scalar
def _walk(surfaces, seed, sense, step, tolerance, enough, knots, first, row, f, g):
    """Append knots from a seed (7,), itself included, to the end of the walk; knots, count, end.

    f: workspace of Newton at the next knot, g: the same along arcs.
    """
    n, loose = first, math.sqrt(1e-3 * tolerance * min(1.0, step))
    knots = with_room(knots, n)
    knots[n, :7], knots[n, K_LENGTH], knots[n, K_DISTANCE] = seed, -1.0, 0.0
    x, y, z = seed[0], seed[1], seed[2]

    # The first knot is the seed itself.
    found = newton_in_plane_to(surfaces, 0, knots[n, 3:7], x, y, z, 0.0, 0.0, 0.0, enough, f)
    if found != LIFTED:
        return knots, n, LOST
    steepest = set_knot(sense, f, knots[n])
    set_knot_errors(surfaces, f, knots[n], knots[n])
    shortest = MIN_STEP * step
    n += 1
    while n - first < MAX_STEPS and step > shortest:
        knots = with_room(knots, n)

        # Try to close: the start is ahead and within reach of a step.
        start, here, goal = knots[first], knots[n - 1], knots[n]
        # A step crosses two cells at most, by the parameter that changes fastest.
        step, target = min(step, _FARTHEST / steepest), allowed_distance(here, tolerance)
        ax, ay, az = start[0] - here[0], start[1] - here[1], start[2] - here[2]
        left = math.sqrt(ax * ax + ay * ay + az * az)
        ahead = ax * here[K_SLOPE] + ay * here[K_SLOPE + 1] + az * here[K_SLOPE + 2]
        if n - first > 3 and left < 1.2 * step and ahead > 0.5 * left:
            goal[:] = start
            set_length(here, goal)
            goal[K_DISTANCE] = measure_arc(surfaces, here, goal, target, loose, row, g)
            if goal[K_DISTANCE] <= target:
                return knots, n + 1, CLOSED
            # Not close enough to the curve: approach the start more slowly.
            step = min(step, 0.4 * left)

        # Predict and correct; halve the step if it is rejected.
        found, at_rim = _predict(surfaces, knots, first, n, step, enough, row, f)
        turn = (
            step_direction(here, here[K_SLOPE : K_SLOPE + 3], step, f) if found == LIFTED else 0.0
        )
        if turn == 0.0:
            step *= 0.5
            continue

        # Measure the arc to the new knot.
        goal[3:7] = row[3:7]
        rate = set_knot(turn, f, goal)
        set_length(here, goal)
        away = measure_arc(surfaces, here, goal, target, loose, row, g)
        if away > target:
            # The distance of an arc grows with the fourth power of its length.
            step *= max(0.3, _CAREFUL * math.sqrt(math.sqrt(target / away)))
            continue
        set_knot_errors(surfaces, f, here, goal)
        goal[K_DISTANCE] = away
        n += 1
        if at_rim:
            return knots, n, AT_RIM
        steepest = rate
        step *= min(_GROWTH, _CAREFUL * math.sqrt(math.sqrt(target / max(away, 1e-3 * target))))
    return knots, n, LOST


@scalar
def _walk_both_ways(surfaces, seed, step, tolerance, enough, knots, first, row, f, g):
    """The whole curve through a seed: knots, how many there are now, how it ends."""
    knots, n, end = _walk(surfaces, seed, -1.0, step, tolerance, enough, knots, first, row, f, g)
    # A closed curve is complete; a lost one is given up.
    if end != AT_RIM:
        return knots, n, end
    reverse_knots(knots, first, n)
    # The second half starts from the same seed; the arc that ends there belongs to the first half.
    middle = n - 1  # the seed is repeated
    length, away = knots[middle, K_LENGTH], knots[middle, K_DISTANCE]
    knots, n, end = _walk(surfaces, seed, 1.0, step, tolerance, enough, knots, middle, row, f, g)
    knots[middle, K_LENGTH], knots[middle, K_DISTANCE] = length, away
    return knots, n, AT_RIM if end == AT_RIM else LOST


@scalar
def _walk_all(surfaces, pairs, cell_a, cell_b, patches_a, patches_b, step, tolerance):
    """Curves of two lattices: points (n, 3), offsets, ends, bounds and the estimates of the cubics
    in them, unsettled pairs, and keys of pairs that walks run through. `step`: the first [m].
    """
    za, zb = surfaces.za, surfaces.zb
    row, seed, f, g = np.empty(7), np.empty(7), np.empty(N_WORK), np.empty(N_WORK)
    small = min(1.0, step)
    # Sizes of Newton's last step. The error is about its square (see `lift`), hence roots.
    near, enough = math.sqrt(0.25 * tolerance * small), min(1e-6, 1e-3 * tolerance)
    enough, reach = math.sqrt(enough * small), _SAME * tolerance

    # Pairs that are not transverse are left to be split.
    keys, order, knot_of = classify_pairs(surfaces, pairs, cell_a, cell_b, patches_a, patches_b)
    knots, rows, m, n, count = np.empty((256, N_KNOT)), np.empty((1024, 3)), 0, 0, 0
    n_pair = pairs.shape[0]
    offsets, ends = np.zeros(n_pair + 1, dtype=np.int64), np.empty(n_pair, dtype=np.int64)
    figures = np.empty((n_pair, 2))
    for k in range(n_pair):
        # Skip pairs that a walk settled already.
        if knot_of[k] != NOT_PASSED:
            continue
        a, b = pairs[k, 0], pairs[k, 1]
        found = find_seed(surfaces, patches_a[a], cell_a[a], cell_b[b], near, seed, f)
        if found != LIFTED:
            knot_of[k] = TO_SPLIT
            continue

        # A seed on a known curve starts no walk.
        if is_near_curve(za, zb, knots, m, seed, reach, keys, order, knot_of):
            continue
        if is_disjoint_pair(surfaces, cell_a[a], cell_b[b], seed):
            continue  # the walk starts in the pair of cells that holds the curve
        first = m
        knots, m, end = _walk_both_ways(
            surfaces, seed, step, tolerance, enough, knots, first, row, f, g
        )

        # Mark the pairs that the walk runs through, and cut its chords.
        if end != LOST:
            mark_passed(za, zb, knots, first, m, keys, order, knot_of, row)
            rows, n, figures[count, 0], figures[count, 1], noisy = cut_chords(
                knots, first, m, tolerance, rows, n
            )
            end = NOISY if noisy else end
        ends[count] = end
        count += 1
        offsets[count] = n
        if end == LOST or end == NOISY:
            break
    return (
        rows[:n].copy(), offsets[: count + 1].copy(), ends[:count].copy(), figures[:count].copy(),
        np.where(knot_of <= TO_SPLIT)[0], keys_passed(keys, order, knot_of),
    )  # fmt: skip


@scalar
def _not_walked():
    """As `_walk_all`, without any curve."""
    none, nobody = np.empty((0, 3)), np.empty(0, dtype=np.int64)
    return none, nobody, nobody, np.empty((0, 2)), nobody, nobody


@entry("d2 d2 d2 d2 d2 d2 d3 d2 l2 d2 d2 d2 d2 d -> l1 l1 d2 d2 l1 l1 l2 d l d2 l1 l1 d2 l1 l1")
def find_and_walk(
    xa, ya, za, xb, yb, zb, c, boxes, shape, bends_a, items, planes, bends_b, tolerance
):
    """All results of `near_patches`, then the curves of two whole lattices (`_walk_all`).

    There are no offsets where walks do not apply: a surface has holes or is a triangle mesh, or the
    tolerance [m] is 0. One above a quarter of a cell counts as that: to split cells for the plain
    curve takes longer than to walk in short steps.
    """
    surfaces = SurfacePair(xa, ya, za, xb, yb, zb, c)
    a, b = (xa, ya, za, c, bends_a), (xb, yb, zb, c, bends_b)
    cells_a, cells_b, patches_a, patches_b, flags_a, flags_b, pairs, size, whole = near_patches(
        a, b, boxes, shape, items, planes
    )
    if pairs.shape[0] > 0:
        tolerance = min(tolerance, _COARSEST * size)
    if zb.shape[0] > 1 and whole == 1 and tolerance > 0.0:
        rows, offsets, ends, figures, unsettled, keys = _walk_all(
            surfaces, pairs, cells_a, cells_b, patches_a, patches_b, _FIRST_STEP * size, tolerance
        )
    else:
        rows, offsets, ends, figures, unsettled, keys = _not_walked()
    return (
        cells_a, cells_b, patches_a, patches_b, flags_a, flags_b, pairs, size, whole,
        rows, offsets, ends, figures, unsettled, keys,
    )  # fmt: skip
