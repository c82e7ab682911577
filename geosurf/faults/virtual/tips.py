"""Ends of faults inside the model: lines of their rims off all other faults."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.faults.dangling import Fault, Gone, RimWalk
from geosurf.faults.rim import Rim, find_rims
from geosurf.faults.virtual.edges import edge_keys
from geosurf.model import Patches, TriSurface
from geosurf.model.faults import SIDES

_SAMPLES = np.linspace(0.0, 1.0, 9)[:, None]  # of each step of a rim, where it is in the model


@dataclass(frozen=True)
class Model:
    """The space that is divided.

    Attributes
    ----------
    outline : ndarray of float64, shape (n, 2)
        Corners of the area on the map [m].
    bottom, top : float
        Elevations [m].
    margin : float
        How far beyond the model a wall goes on [m].
    """

    outline: np.ndarray
    bottom: float
    top: float
    margin: float

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) are inside, bool (n,)."""
        x, y, z = points.T
        a, b = self.outline, np.roll(self.outline, -1, axis=0)

        # even-odd rule: how often a ray to the east crosses the outline
        between = (a[:, 1] > y[:, None]) != (b[:, 1] > y[:, None])
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (y[:, None] - a[:, 1]) / (b[:, 1] - a[:, 1])
            east = x[:, None] < a[:, 0] + share * (b[:, 0] - a[:, 0])
        on_map: np.ndarray = (between & east).sum(axis=1) % 2 == 1
        return on_map & (z > self.bottom) & (z < self.top)


@dataclass(frozen=True)
class Tip:
    """One side of one piece of a fault.

    Attributes
    ----------
    arc : ndarray of int64, shape (n,)
        Vertices of the side, as the triangles next to the rim run.
    open : ndarray of bool, shape (n - 1,)
        Steps off all other faults.
    dies : bool
        Whether some of these are inside the model.
    """

    arc: np.ndarray
    open: np.ndarray
    dies: bool


def model_of(box: Sequence[float], outline: np.ndarray | None) -> Model:
    """Return the space of a model: its box, or an area between its bottom and top."""
    w, e, s, n, bottom, top = box
    if outline is None:
        outline = np.array([[w, s], [e, s], [e, n], [w, n]])
    margin = 0.01 * float(np.linalg.norm([e - w, n - s, top - bottom]))
    return Model(outline, bottom, top, margin)


def tips_of(
    patches: Patches, surface: TriSurface, model: Model
) -> list[tuple[Rim, dict[str, Tip]]]:
    """
    Return the rim of each piece of a fault, and its sides.

    Parameters
    ----------
    patches : Patches
        Of all faults of the model, in world coordinates.
    surface : TriSurface
        One of them.
    model : Model

    Raises
    ------
    SurfaceError
        If the rim of the fault touches itself, or its triangles do not agree about their front.
    """
    mine = patches.names.index(surface.name)
    others = patches.surface_of_triangle != mine
    keys = edge_keys(patches, np.flatnonzero(others))

    # the rim as other faults have cut it, step by step: on one of them it is no tip
    rows = np.flatnonzero(~others)
    rims = find_rims(surface)
    gone = Gone(np.zeros(len(rows), dtype=bool), np.unique(keys))
    walk = RimWalk(patches, Fault(surface, rows, rims, 0.0), gone)

    # vertices as the arrangement has them: rounding may have moved some by a hair
    x = patches.sources[mine].vertices
    return [
        (rim, {side: _tip(x[rim.arcs[side]], rim.arcs[side], walk, model) for side in SIDES})
        for rim in rims
    ]


def met_by(patches: Patches, surface: TriSurface) -> set[str]:
    """Return the faults that a fault meets along a line: it crosses them, or ends at them."""
    of = patches.surface_of_triangle
    keys = edge_keys(patches, np.arange(patches.n_triangle))
    shared = np.isin(keys, keys[of == patches.names.index(surface.name)]).any(axis=1)
    return {patches.names[i] for i in np.unique(of[shared])} - {surface.name}


def _tip(x: np.ndarray, arc: np.ndarray, walk: RimWalk, model: Model) -> Tip:
    """One side, with what of it is open."""
    is_open = np.zeros(max(len(arc) - 1, 0), dtype=bool)
    dies = False
    for i, (a, b) in enumerate(pairwise(x)):
        points, _, stays = walk.along(np.stack([a, b]))
        is_open[i] = stays.any()
        for p, q in zip(points[:-1][stays], points[1:][stays], strict=True):
            dies = dies or bool(model.holds(p + _SAMPLES * (q - p)).any())
    return Tip(arc, is_open, dies)
