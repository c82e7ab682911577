"""Edges and patches of pieces: those that an earlier arrangement has are taken from there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geosurf.arrangement.earlier import Carried, Kept, Origin, Unchanged
from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.kernels.lattices.strips import lowest_keys
from geosurf.kernels.meshes import carried_pieces as kernels
from geosurf.model.pieces import Strips
from geosurf.rebuild.edges import match_again

_TRIANGLES = 20_000  # of a thread, at least: a millisecond of work


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
    after, blocks = _same_triangles(kept, same, surface, key, face)
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
    given = after, old.ring, old.link, kept.rim, run_after, ring, link
    rows = _ranges_of_blocks(blocks, len(t))
    space = np.empty(3 * len(t), dtype=np.int64)
    others = [space[3 * end : 3 * n] for _, _, end, n in rows]
    found = map_threads(
        kernels.carry_rings,
        [(blocks, *row, some, *given) for row, some in zip(rows, others, strict=True)],
    )
    halves = np.concatenate([some[:n] for some, (n, _) in zip(others, found, strict=True)])
    rim = np.concatenate([part for _, part in found])
    match_again(t, n_point, halves, ring, link)
    runs = run_before, run_after
    return Edges(kept, after, halves, blocks, runs, ring, link, rim)


def _same_triangles(
    kept: Kept, same: Unchanged, surface: np.ndarray, key: np.ndarray, face: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """`after` and `blocks` of triangles: see `carried_pieces`."""
    old, n0, n = kept.pieces, len(kept.face), len(face)
    after = np.empty(n0, dtype=np.int64)

    # ranges are of whole surfaces; `same.surface` rises where it is not -1
    rows, end0, end = [], 0, 0
    for _, until in in_ranges(n, _TRIANGLES):
        after_of = np.flatnonzero(same.surface > (surface[until - 1] if n else -1))
        of0 = int(after_of[0]) if until < n and len(after_of) else len(same.surface)
        until0 = int(np.searchsorted(old.surface, of0))
        until = int(np.searchsorted(surface, surface[until - 1], side="right")) if n else 0
        rows.append((end0, until0 if until < n else n0, end, until))
        end0, end = rows[-1][1], until
    given = same.surface, old.surface, old.key, kept.face, surface, key, face, same.face
    blocks = map_threads(
        kernels.same_triangles, [(*given, same.changed, *row, after) for row in rows]
    )
    return after, np.concatenate(blocks)


def _ranges_of_blocks(blocks: np.ndarray, n: int) -> list[tuple[int, int, int, int]]:
    """First block and last + 1 of each range, its first triangle and its last + 1, of n now."""
    rows = in_ranges(n, _TRIANGLES)
    cut = [int(np.searchsorted(blocks[:, kernels.FIRST_NOW], end)) for _, end in rows]
    cut[-1] = len(blocks)
    ends = [int(blocks[b - 1, kernels.FIRST_NOW :].sum()) if b else 0 for b in cut]
    ends[-1] = n
    return list(zip([0, *cut], cut, [0, *ends], ends, strict=False))


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
