"""Attempts to tear a moved horizon in turn: the first that closes, or the nearest to that.

Each attempt is a result of its own, so that the best one brings its own walls, notes and places.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from geosurf.sheets.heights.state import Heights
from geosurf.sheets.mesh.build import Built, build
from geosurf.sheets.mesh.finish import refuse_leaks
from geosurf.sheets.mesh.rings import SPARE
from geosurf.sheets.throw.attempt import Attempt, attempt
from geosurf.sheets.throw.movement import Movement

LEANS = (0.5, 0.3, 0.7)  # shares of the movement at which traces are tried
SPARES = (1.0, 0.5, 1.5, 0.0)  # cells beyond an overlap that rings are tried to cover


def best_attempt(movement: Movement) -> tuple[Attempt, Built | None]:
    """The first mesh that closes without an early end, else the one that ends least early.

    Where traces run between both cut-offs, and how far rings reach beyond an overlap, is free;
    at a tip it decides on which side of the fault the last nodes are.

    Returns
    -------
    attempt : Attempt
        The one that the mesh was made from.
    built : Built or None
        The torn mesh; None where no fault has throw. It counts the cuts of all attempts.
    """
    n_cut = 0
    best: tuple[tuple[bool, int], Attempt, Built] | None = None
    branches = movement.first_branches()
    for lean in LEANS:
        one = attempt(movement, lean, branches)
        branches = one.branches  # the next one starts with what this one has found
        if not len(one.state.cuts.node):
            return one, None
        for state in _with_spare_rings(one.state):
            built = build(
                movement.picks, state, movement.faults, movement.rising, one.ghosts, one.end_at,
                walls=one.walls_by_name,
            )  # fmt: skip

            n_cut += built.n_cut

            # a closed sheet beats an open one; among these, the one with the fewest links left
            # untorn
            failed = built.is_open, sum(built.repairs.shortened.values())
            if best is None or failed < best[0]:
                best = failed, one, built
            if failed == (False, 0):
                return one, replace(built, n_cut=n_cut)
    assert best is not None
    _, one, built = best
    refuse_leaks(movement.picks, built, movement.faults)
    return one, replace(built, n_cut=n_cut)


def _with_spare_rings(state: Heights) -> Iterator[Heights]:
    """The same heights with overlaps widened, so that rings of ghosts reach beyond them."""
    overlaps = any((np.minimum(w.left, w.right) < -SPARE).any() for w in state.walls)

    # only overlaps need rings: a gap has one attempt for each share of the movement
    for spare in SPARES if overlaps else SPARES[:1]:
        walls = [
            replace(w, left=_wider(w.left, spare), right=_wider(w.right, spare))
            for w in state.walls
        ]
        yield replace(state, walls=walls)


def _wider(gap: np.ndarray, spare: float) -> np.ndarray:
    """Overlaps (gaps below 0) made larger, the small ones near tips by no more than they are."""
    return np.where(gap < 0, gap - spare * np.minimum(-gap, 1.0), gap)
