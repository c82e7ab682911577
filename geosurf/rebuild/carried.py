"""Edges and patches of pieces: those that an earlier arrangement has are taken from there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geosurf.arrangement.earlier import Carried, Kept, Origin
from geosurf.kernels.lattices.strips import lowest_keys
from geosurf.kernels.meshes import carried_pieces as kernels
from geosurf.model.pieces import Strips


class Edges(NamedTuple):
    """Edges of pieces that come from earlier ones.

    Attributes
    ----------
    before, after, halves
        As `Origin` has them.
    blocks : ndarray of int64, shape (n, 3)
        Triangles that stay: see `carried_pieces`.
    runs : (ndarray of int64, ndarray of int64)
        Earlier run that each run is, and run that each earlier one is now, or -1.
    ring, link : ndarray of int64, shape (3 * n_triangle,)
        As `Pieces` has them; links that are not known yet are FREE.
    rim : ndarray of int64
        Last half-edges of the edges between patches that stay, rising.
    """

    before: Kept
    after: np.ndarray
    halves: np.ndarray
    blocks: np.ndarray
    runs: tuple[np.ndarray, np.ndarray]
    ring: np.ndarray
    link: np.ndarray
    rim: np.ndarray


def carry_edges(
    carried: Carried,
    t: np.ndarray,
    surface: np.ndarray,
    key: np.ndarray,
    face: np.ndarray,
    n_point: int,
    strips: Sequence[Strips | None],
    first_run: np.ndarray,
) -> Edges:
    """Take edges from an earlier arrangement, and find those that have changed.

    Parameters
    ----------
    carried : Carried
        With points that differ from each other, as this arrangement has them.
    t, surface, key, face, strips, first_run
        Of the triangles and runs.
    n_point : int
    """
    kept, same = carried.earlier.kept, carried.same
    old = kept.pieces
    after, blocks = kernels.same_triangles(
        same.surface[old.surface], old.key, kept.face, surface, key, face, same.face, same.changed
    )
    run_after = np.full(int(old.first_run[-1]), -1, dtype=np.int64)
    for i, j in enumerate(same.surface.tolist()):
        one, other = old.strips[i], strips[j] if j >= 0 else None
        if one is not None and other is not None:
            at = kernels.same_runs(one.runs, one.start, other.runs, other.start)
            at[at >= 0] += first_run[j]
            run_after[old.first_run[i] : old.first_run[i + 1]] = at
    run_before = np.full(int(first_run[-1]), -1, dtype=np.int64)
    stay = np.flatnonzero(run_after >= 0)
    run_before[run_after[stay]] = stay

    # large arrays are made here: numpy asks for large pages, which kernels do not
    ring, link = np.empty(3 * len(t), dtype=np.int64), np.empty(3 * len(t), dtype=np.int64)
    halves, until, rim = kernels.carry_rings(
        blocks, after, old.ring, old.link, kept.rim, run_after, ring, link
    )
    kernels.match_half_edges(t, n_point, blocks, halves, until, ring, link)
    runs = run_before, run_after
    return Edges(kept, after, halves, blocks, runs, ring, link, rim)


def carry_patches(
    came: Edges,
    surface: np.ndarray,
    key: np.ndarray,
    link: np.ndarray,
    strips: Sequence[Strips | None],
    first_run: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, Origin]:
    """Patch of each element, the last half-edges of the edges between patches, and the origin.

    `link` is complete.
    """
    old = came.before.pieces
    patch, rim, patch_after = kernels.carry_patches(
        came.blocks, len(came.after), *came.runs, int(old.patch.max(initial=-1)) + 1, old.patch,
        surface, key, came.ring, link, came.halves, came.rim, *runs_of_all(strips, first_run),
        first_run,
    )  # fmt: skip
    return patch, rim, Origin(came.before, came.after, came.halves, patch_after)


def runs_of_all(
    strips: Sequence[Strips | None], first_run: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of runs (n, 2) that share an edge, and the lowest key of each run."""
    joined, lowest = [np.empty((0, 2), dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    for i, of in enumerate(strips):
        if of is not None:
            joined.append(of.joined + first_run[i])
            lowest.append(lowest_keys(of.places, of.runs))
    return np.concatenate(joined), np.concatenate(lowest)
