"""Further rings of ghosts: where the horizon overlaps its own trace, and at edges that leak."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np

from geosurf.kernels.lattices.sets import is_among
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.mesh.ghosts import grow, kept_apart
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles

RING = 0.3  # cells that a further ring of triangles reaches at least
LEVEL_REACH = 4.0  # cells from a place within which ghosts are level with their anchors
SPARE = 0.25  # cells of overlap that the first ring covers for certain; further rings go past by it


def grown_over(torn: Torn, triangles: Triangles, state: Heights) -> Torn:
    """Further rings where a reverse fault makes the horizon overlap its own trace."""
    # The widest overlap decides whether any ring is needed at all.
    widest = max((-np.minimum(w.left, w.right).min(initial=0.0) for w in state.walls), default=0.0)
    if widest <= SPARE:
        return torn

    # each ring goes on by RING at least: so many are enough, and rings stop once none is short
    for _ in range(int(np.ceil((widest + SPARE) / RING))):
        needy = _short_of_overlap(torn, state)
        if not needy.any():
            break
        torn = _grown_from(torn, triangles, torn.n_node + np.flatnonzero(needy))
    return torn


def grown_at(torn: Torn, triangles: Triangles, places: Iterable[tuple[int, int]]) -> Torn:
    """Another ring where outer edges lie over given pairs of nodes, or next to them."""
    # vertices over a given node are touched
    near = np.zeros(torn.n_node, dtype=bool)
    near[list({node for pair in places for node in pair})] = True
    touched = near[torn.node_of(torn.corners.ravel())].reshape(-1, 3)
    # one end over a given node is enough: the ring goes on a link to each side of the leak
    return grow(torn, triangles, touched | np.roll(touched, -1, axis=1))


def levelled(
    torn: Torn,
    ghosts: np.ndarray,
    heights: np.ndarray,
    places: Collection[tuple[float, float]],
    frame: Frame,
) -> np.ndarray:
    """Heights of ghosts (n_ghost,): near some places [cells] those of their anchors.

    A sheet that is extrapolated along the dip of its fault may never meet it; a level one does.
    """
    if not places:
        return ghosts
    # Places are given in cells of the lattice.
    at = frame.cells_of_node(torn.node_of_ghost)
    near = np.zeros(len(at), dtype=bool)
    for place in places:
        near |= np.hypot(*(at - place).T) <= LEVEL_REACH
    level = np.where(near, heights[torn.anchor], ghosts)
    # Level sheets may coincide with others: they are kept apart as everywhere.
    return kept_apart(torn, heights, level, frame.cell)


def _short_of_overlap(torn: Torn, state: Heights) -> np.ndarray:
    """Ghosts that do not lie past their sheet's cut-off yet, bool (n_ghost,)."""
    short = np.zeros(len(torn.anchor), dtype=bool)
    for near, walls in zip(state.near, state.walls, strict=True):
        # side of the anchor is the wall of the ghost; distance of the ghost itself [cells]
        of, at = near.look_up(torn.anchor), near.look_up(torn.node_of_ghost)
        rows = np.flatnonzero((of >= 0) & (at >= 0))
        own, at = near.side[of[rows]], at[rows]
        beyond = near.side[at] != own  # around a tip rings may come back over their own wall
        overlap = -walls.gap(near.place[at], own)
        far = near.distance[at]
        short[rows] |= beyond & (overlap > SPARE) & (far < overlap + SPARE)
    return short


def _grown_from(torn: Torn, triangles: Triangles, ghosts: np.ndarray) -> Torn:
    """Another ring along the outer edges that have one of these ghosts."""
    # Inner edges among them are dropped by `grow`, which looks at outer edges only.
    mine = is_among(torn.corners.ravel(), ghosts).reshape(-1, 3)
    return grow(torn, triangles, mine | np.roll(mine, -1, axis=1))
