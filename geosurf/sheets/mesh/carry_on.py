"""Heights of the ghosts of picked sheets: by the energy, and by picks beyond the trace."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.noise import scale_of
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.mesh.ghosts import ghost_heights, joined_heights
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles

CarryOn = Callable[[Torn, Triangles, np.ndarray, Heights, Collection[int]], np.ndarray]
Known = Callable[[Torn, Triangles, np.ndarray, Heights, Callable | None], dict[int, float]]


def carry_on_by(frame: Frame, weight: float | None, known: Known, order: int = 3) -> CarryOn:
    """Make the function that gives the heights of all ghosts of one torn mesh.

    `weight` is that of noisy data, `order` that of the sheet's highest differences. `known` gives
    the heights of ghosts that picks determine.
    """

    def carry_on(
        torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights, early: Collection[int]
    ) -> np.ndarray:
        """Heights of the ghosts of one sheet; `early`: traces whose tears end early."""
        # The bend of throw at tips is known; only what is left is smooth and extrapolated.
        bent = None if state.bent is None else partial(state.bent.of, frame)
        fixed = known(torn, triangles, bits, state, bent)

        past = None
        # Ghosts bend only at traces where the sheet goes on beyond the fault as before it.
        if state.bent is not None:
            past = partial(state.bent.only(_bent_beyond(state, early)).of, frame)
        return ghost_heights(
            torn, triangles, bits, state.values, frame.stretch, frame.cell, fixed, past,
            scale_of(weight), order,
        )  # fmt: skip

    return carry_on


def ghosts_by_picks(
    picks: Picks, weight: float | None, mark: Callable[[np.ndarray], None]
) -> Known:
    """Make the function that gives the heights of the ghosts that picks determine.

    Where data are noisy the sheet changes with them: `mark` is called with its nodes.
    """

    def known(
        torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights, bent: Callable | None
    ) -> dict[int, float]:
        """Heights of ghosts, by number."""
        # Exact picks need no solve: they are the heights of their ghosts.
        fixed = _picked(picks, state, torn)
        if weight is not None and fixed:  # the sheet is one with its part beyond the trace
            nodes, fixed = joined_heights(
                torn, triangles, bits, state.values, picks.frame.stretch, fixed,
                lambda nodes: picks.means_at(nodes, state.used), weight, bent,
            )  # fmt: skip
            # The solver has to know which of its heights are no longer its own.
            mark(nodes)
        return fixed

    return known


def _bent_beyond(state: Heights, early: Collection[int]) -> list[int]:
    """Traces at whose tips ghosts bend as the sheet does: only what is left is extrapolated.

    Not where a tear ends early at a gap: bent ghosts have been tried there and left a hole.
    """
    # Gaps are positive, overlaps negative.
    heaves = [walls.left + walls.right for walls in state.walls]
    return [
        trace
        for trace, heave in enumerate(heaves)
        if trace not in early or (len(heave) and np.median(heave) < 0.0)
    ]


def _picked(picks: Picks, state: Heights, torn: Torn) -> dict[int, float]:
    """Ghosts whose heights were picked: an overlapping sheet beyond the trace."""
    found: dict[int, list[float]] = {}

    # a node may have ghosts of several sheets: start to stop are those over the node of a pick
    order = np.argsort(torn.node_of_ghost, kind="stable")
    nodes = torn.node_of_ghost[order]
    # Trace by trace: sides are those of one trace.
    for trace in distinct(state.beyond[:, 1]):
        rows = state.beyond[state.beyond[:, 1] == trace]
        near = state.near[trace]
        at = near.look_up(torn.anchor)
        side = np.where(at >= 0, near.side[at], 0)
        start = np.searchsorted(nodes, picks.node[rows[:, 0]])
        stop = np.searchsorted(nodes, picks.node[rows[:, 0]], side="right")
        for pick, own, a, b in zip(rows[:, 0], rows[:, 2], start, stop, strict=True):
            for ghost in order[a:b]:
                # the pick belongs to the ghost whose anchor lies on the pick's wall
                if side[ghost] == own:
                    found.setdefault(int(ghost), []).append(float(picks.z[pick]))
    # Several picks over one ghost: their mean.
    return {ghost: float(np.mean(z)) for ghost, z in found.items()}
