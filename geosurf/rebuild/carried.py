"""Edges and patches of pieces: those that an earlier arrangement has are taken from there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from geosurf.arrangement.earlier import Carried, Kept, Origin
from geosurf.arrangement.threads import map_threads
from geosurf.kernels.lattices.strips import lowest_keys
from geosurf.kernels.meshes import carried_pieces as kernels
from geosurf.kernels.meshes.carried_triangles import COUNT, count_staying
from geosurf.model.pieces import HalfEdges, Strips
from geosurf.rebuild.edges import match_again

_MANY = 100_000  # triangles, from which they are counted in threads


@dataclass(frozen=True, eq=False)
class EarlierTriangles:
    """Triangles of earlier pieces, as far as their faces are cut alike.

    Attributes
    ----------
    carried : Carried
    point : ndarray of int64, shape (n_point,)
        Number of each earlier point of a triangle that stays now.
    after : ndarray of int64
        Triangle that each earlier triangle is now, or -1: written by `carry_by_face`.
    first : list of (int, int)
        For each surface its first earlier triangle, and the last + 1.
    counts : ndarray of int64, shape (n_surface,)
        How many triangles of each surface stay, of faces in contact.
    """

    carried: Carried
    point: np.ndarray
    after: np.ndarray
    first: list[tuple[int, int]]
    counts: np.ndarray

    @classmethod
    def of(cls, carried: Carried, n_surface: int) -> EarlierTriangles:
        """Count the triangles that stay."""
        kept, same = carried.earlier.kept, carried.same
        assert kept.id_of_point is not None  # else nothing is carried over
        # points beyond those of the contacts are of triangles that change
        point = same.point.take(kept.id_of_point, mode="clip")
        cut = np.searchsorted(kept.pieces.surface, np.arange(len(same.surface) + 1)).tolist()
        first = [(0, 0)] * n_surface
        for i, j in enumerate(same.surface.tolist()):
            if j >= 0:
                first[j] = cut[i], cut[i + 1]
        rows = [(kept.face, *ends, same.face, same.changed) for ends in first]
        counts = map_threads(count_staying, rows, worth=len(kept.face) > _MANY)
        after = np.full(len(kept.face), -1, dtype=np.int64)
        return cls(carried, point, after, first, np.array(counts, dtype=np.int64))

    def of_surface(self, i: int) -> tuple[Any, ...]:
        """What `carry_by_face` takes of earlier pieces, for one surface."""
        kept, same = self.carried.earlier.kept, self.carried.same
        old = kept.pieces
        return (
            old.triangles, old.key, kept.face, self.point, same.face, same.changed, *self.first[i]
        )  # fmt: skip


class Edges(NamedTuple):
    """Edges of pieces that come from earlier ones.

    Attributes
    ----------
    before, after, halves, ring, link
        As `Origin` has them.
    blocks : ndarray of int64, shape (n, 3)
        Triangles that stay: see `carried_triangles`.
    runs : (ndarray of int64, ndarray of int64)
        Earlier run that each run is, and run that each earlier one is now, or -1.
    linked : ndarray of int64, shape (n, 2)
        Half-edges that stay and are alone, and the runs behind them.
    rim : ndarray of int64
        Last half-edges of the edges between patches that stay, rising.
    """

    before: Kept
    after: np.ndarray
    halves: np.ndarray
    ring: np.ndarray
    link: np.ndarray
    blocks: np.ndarray
    runs: tuple[np.ndarray, np.ndarray]
    linked: np.ndarray
    rim: np.ndarray

    def half_edges(self) -> HalfEdges:
        """Rings and links of all half-edges; those that stay are written when they are needed.

        Volumes do without them. They are at the latest written when another scene is made of this
        one, so that no chain of scenes is held.
        """
        ring0, _ = self.before.pieces.half_edges.complete()
        unwritten = EarlierHalfEdges(self.blocks, self.after, ring0, self.halves, self.linked)
        return HalfEdges(self.ring, self.link, unwritten)


@dataclass(frozen=True, eq=False)
class EarlierHalfEdges:
    """Half-edges that earlier pieces have, too; names as in `Edges`, and `ring0` of these."""

    blocks: np.ndarray
    after: np.ndarray
    ring0: np.ndarray
    halves: np.ndarray
    linked: np.ndarray

    def write(self, ring: np.ndarray, link: np.ndarray) -> None:
        """Write their rings and links."""
        given = self.after, self.ring0, self.halves, self.linked
        kernels.write_rings(self.blocks, *given, ring, link)


def carry_edges(
    carried: Carried,
    after: np.ndarray,
    blocks: np.ndarray,
    t: np.ndarray,
    n_point: int,
    strips: Sequence[Strips | None],
    first_run: np.ndarray,
) -> Edges:
    """Find the edges that have changed since an earlier arrangement.

    Parameters
    ----------
    carried : Carried
        With points that differ from each other, as this arrangement has them.
    after, blocks
        Of triangles that stay: see `carried_triangles`.
    t, strips, first_run
        Of the triangles and runs.
    n_point : int
    """
    kept, same = carried.earlier.kept, carried.same
    old = kept.pieces
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

    words = np.zeros(3 * len(t) // 8 + 1, dtype=np.int64)
    marked, ring0 = words.view(bool), old.ring
    n = 3 * (len(t) - int(blocks[:, COUNT].sum()))
    n += kernels.mark_halves(blocks, after, ring0, kept.linked, run_after, marked)
    # large arrays are made here: numpy asks for large pages, which kernels do not
    halves = np.empty(n, dtype=np.int64)
    ring, link = np.empty(3 * len(t), dtype=np.int64), np.empty(3 * len(t), dtype=np.int64)
    n = kernels.list_halves(blocks, marked, words, len(t), halves, ring, link)
    halves = halves[:n].copy()
    rim = kernels.carry_rim(kept.rim, after, marked)
    linked = kernels.carry_links(kept.linked, after, run_after)
    match_again(t, n_point, halves, ring, link)
    return Edges(kept, after, halves, ring, link, blocks, (run_before, run_after), linked, rim)


def carry_patches(
    came: Edges,
    surface: np.ndarray,
    key: np.ndarray,
    strips: Sequence[Strips | None],
    first_run: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, Origin]:
    """Patch of each element, the last half-edges of the edges between patches, and the origin.

    Links of half-edges that have changed are complete.
    """
    old = came.before.pieces
    patch, rim, patch_after = kernels.carry_patches(
        came.blocks, came.after, old.ring, came.linked, *came.runs,
        int(old.patch.max(initial=-1)) + 1, old.patch, surface, key, came.ring, came.link,
        came.halves, came.rim, *runs_of_all(strips, first_run), first_run,
    )  # fmt: skip
    before, after, halves, ring, link = came[:5]
    return patch, rim, Origin(before, after, halves, ring, link, patch_after)


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
