"""Measure the parts of horizons that the stratigraphic column removed, once somebody asks.

Reports only: nothing here decides what a unit is. Volumes and the thickest place need all triangles
around these parts, which is more than volumes of units cost. Realisations of an ensemble never ask.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.carve.cells import Cells, FullCells
from geosurf.carve.column import Turn
from geosurf.carve.measures import AREA, volume_of
from geosurf.carve.zones import ABOVE, BELOW, distinct_pairs, faces_between, owned_by, upper_sides
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.kernels.search.columns import cross_columns
from geosurf.model import Clipped, Patches
from geosurf.model.excerpt import list_triangles

# ---- listed ----------------------------------------
# List the triangles of some faces, numbered in the order of all triangles of the model.


_NONE = np.empty(0, dtype=np.int64)


def list_faces(cells: Cells, wanted: np.ndarray) -> FullCells:
    """
    Return cells with a face for every triangle of some faces.

    Parameters
    ----------
    cells : Cells
    wanted : ndarray of bool, shape (n_face,)

    Returns
    -------
    FullCells
        In the order of `Cells.in_full`. Points are numbered in its order, those in use alone, and
        triangles by their place among these.
    """
    pieces = cells.pieces
    is_wanted, n_triangle = np.append(wanted, False), len(pieces.triangles)  # the last: no face
    cut = np.searchsorted(pieces.surface, np.arange(len(pieces.sources) + 1))

    chosen = []
    for i, strips in enumerate(pieces.strips):
        rows = np.arange(cut[i], cut[i + 1])
        rows = rows[is_wanted[cells.face_of_element[rows]]]
        keys, run = _NONE, _NONE
        if strips is not None:
            first = int(pieces.first_run[i])
            all_runs = slice(n_triangle + first, n_triangle + first + len(strips.runs))
            some = np.flatnonzero(is_wanted[cells.face_of_element[all_runs]])
            keys, run = strips.keys_of(some)
            run = run + first
        chosen.append((rows, keys, run))

    listed = list_triangles(pieces, chosen)
    face = cells.face_of_element[listed.element]
    return cells.with_triangles(face, listed.triangles, np.arange(len(face)), listed.x)


def clipped_by(
    patches: Patches, cells: Cells, turns: Sequence[Turn], horizons: list[int]
) -> Sequence[Clipped]:
    """Areas, volumes and places of all that horizons lost, youngest winner first.

    Pieces of a horizon that end inside what is taken away have an area, and neither volume nor
    thickness: nobody knows on which side of them the space beyond their rim is.
    """
    ordered = sorted(turns, key=lambda turn: (turn.winner, turn.loser))
    return Clips(patches, cells, ordered, horizons) if turns else ()


class Clips(Sequence[Clipped]):
    """
    What horizons lost, like a tuple; it is measured when it is first looked at.

    Parameters
    ----------
    patches : Patches
    cells : Cells
    turns : sequence of Turn
        In the order of the result.
    horizons : list of int
        Rows of the horizons among the surfaces.
    """

    def __init__(
        self, patches: Patches, cells: Cells, turns: Sequence[Turn], horizons: list[int]
    ) -> None:
        self._from = patches, cells, turns, horizons

    def areas(self, rule: str) -> list[float]:
        """Areas that horizons lost by one rule [m2], from faces: no triangle is listed."""
        patches, cells, turns, horizons = self._from
        lost_areas = []
        for turn in turns:
            if turn.rule == rule:
                gone = _gone(turn, *upper_sides(patches, cells, horizons[turn.loser]))
                lost_areas.append(float(cells.sums[gone, AREA].sum()) if len(gone) else 0.0)
        return lost_areas

    @cached_property
    def _found(self) -> tuple[Clipped, ...]:
        return _measured(*self._from)

    def __getitem__(self, at: Any) -> Any:
        return self._found[at]

    def __len__(self) -> int:
        return len(self._found)

    def __eq__(self, other: object) -> bool:
        return self._found == (other._found if isinstance(other, Clips) else other)

    def __hash__(self) -> int:
        return hash(self._found)

    def __repr__(self) -> str:
        return repr(self._found)

    def __reduce__(self) -> tuple[type, tuple]:
        return tuple, (self._found,)


def _measured(
    patches: Patches, cells: Cells, turns: Sequence[Turn], horizons: list[int]
) -> tuple[Clipped, ...]:
    """All that horizons lost, in the order of the turns of the column."""
    clips, full = [], list_faces(cells, _around_lost(cells, turns, horizons))
    for turn in turns:
        horizon = horizons[turn.loser]
        gone = _gone(turn, *upper_sides(patches, full, horizon))

        # cells that changed sides: the product is -1, and 0 where a side is unknown
        lost = turn.before * turn.after == ABOVE * BELOW
        shells = _shells(full, _pieces(full, lost))
        volumes = [volume_of(full.x, t) for t in shells]
        order = sorted(range(len(shells)), key=lambda i: -volumes[i])
        places = [(*_middle(full, shells[i]), volumes[i]) for i in order]
        whole = np.concatenate([np.empty((0, 3), dtype=np.int64), *shells])
        thickness, place = _thickest(full, whole, full.triangles[gone])
        clips.append(
            Clipped(
                patches.names[horizon],
                patches.names[horizons[turn.winner]],
                turn.rule,
                _area(full.x[full.triangles[gone]]),
                math.fsum(volumes),
                thickness,
                place,
                tuple(places),
            )
        )
    return tuple(clip for clip in clips if clip.area > 0 or clip.volume > 0)


def _gone(turn: Turn, rows: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Faces of a horizon that a turn removed, rising, from those in `upper_sides`.

    They are between cells on one side after the turn and on two before it.
    """
    return np.unique(rows[_settled(turn.after, sides) & ~_settled(turn.before, sides)])


def _around_lost(cells: Cells, turns: Sequence[Turn], horizons: list[int]) -> np.ndarray:
    """Which faces are next to a cell that changed sides, or were removed, bool (n_face,)."""
    sides = cells.cell_of_side
    wanted = np.zeros(len(sides), dtype=bool)
    for turn in turns:
        wanted |= (turn.before * turn.after == ABOVE * BELOW)[sides].any(axis=1)
        mine = owned_by(cells, horizons[turn.loser])
        gone = _settled(turn.after, sides[mine]) & ~_settled(turn.before, sides[mine])
        wanted[mine[gone]] = True
    return wanted


def _settled(side: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Whether both sides of each triangle are known to be on one side of the clipped horizon."""
    upper, lower = side[sides[:, 0]], side[sides[:, 1]]
    # the outside counts as the inside: a horizon along a wall is settled as its inner side is
    upper = np.where(sides[:, 0] == 0, lower, upper)
    lower = np.where(sides[:, 1] == 0, upper, lower)
    return (upper == lower) & (upper != 0)


def _shells(cells: FullCells, piece: np.ndarray) -> list[np.ndarray]:
    """Outward triangles around each piece, given the piece (1 ..) of each cell, 0 for none."""
    front, behind = piece[cells.cell_of_side[:, 0]], piece[cells.cell_of_side[:, 1]]

    # triangles that see the piece in front of them face inward, and are turned
    inner, outer = (np.flatnonzero((side > 0) & (front != behind)) for side in (front, behind))
    t = np.concatenate([cells.triangles[inner][:, [0, 2, 1]], cells.triangles[outer]])
    piece_of = np.concatenate([front[inner], behind[outer]])
    order = np.argsort(piece_of, kind="stable")
    starts = np.searchsorted(piece_of[order], np.arange(2, piece.max(initial=0) + 1))
    return np.split(t[order], starts) if len(piece_of) else []


def _pieces(cells: Cells, lost: np.ndarray) -> np.ndarray:
    """Number 1 .. of the piece that each lost cell belongs to: cells with a face in common."""
    pairs = distinct_pairs(cells.cell_of_side[faces_between(cells)], cells.n_cell)
    pairs = pairs[lost[pairs].all(axis=1)]
    piece = join_pairs(pairs, len(lost))
    _, number = np.unique(piece[lost], return_inverse=True)
    out = np.zeros(len(lost), dtype=np.int64)
    out[lost] = number + 1
    return out


def _middle(full: FullCells, triangles: np.ndarray) -> tuple[float, float, float]:
    corners = full.x[triangles]
    x, y, z = (
        0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1))) + full.patches.origin
    ).tolist()
    return x, y, z


def _area(corners: np.ndarray) -> float:
    a, b, c = (corners[:, k] for k in range(3))
    return math.fsum(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def _thickest(
    full: FullCells, shell: np.ndarray, gone: np.ndarray
) -> tuple[float, tuple[float, float, float]]:
    """Largest vertical distance through a shell, and where; else the middle of what is gone."""
    x = full.x
    if len(shell) == 0:
        return 0.0, _middle(full, gone) if len(gone) else (math.nan,) * 3
    best, place = 0.0, x[shell[0, 0]]

    # on plane triangles the thickest place is at a corner, of an upright wall at either side of it
    feet = x[_distinct(shell, len(x)), :2]
    for beside in (feet.min(axis=0), feet.max(axis=0)):
        crossings = cross_columns(x, shell, feet, beside)
        # shells face outward: lines enter through what looks down, and leave through the next one
        order = np.lexsort((crossings.way, crossings.elevation, crossings.foot))
        foot, way, z = crossings.foot[order], crossings.way[order], crossings.elevation[order]
        enters = np.flatnonzero((way[:-1] < 0) & (way[1:] > 0) & (foot[:-1] == foot[1:]))
        if not len(enters):
            continue
        height = z[enters + 1] - z[enters]
        i = int(height.argmax())
        if height[i] > best:
            at = enters[i]
            best, place = float(height[i]), np.array([*feet[foot[at]], 0.5 * (z[at] + z[at + 1])])
    px, py, pz = (place + full.patches.origin).tolist()
    return best, (px, py, pz)


def _distinct(vertices: np.ndarray, n: int) -> np.ndarray:
    """Distinct vertices out of 0 .. n - 1, rising; sorts nothing."""
    mark = np.zeros(n, dtype=bool)
    mark[vertices] = True
    return np.flatnonzero(mark)
