"""Edges and patches of pieces: those that an earlier arrangement has are taken from there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from geosurf.arrangement.earlier import Carried, Kept, Origin, Unchanged
from geosurf.arrangement.threads import in_ranges, map_threads
from geosurf.kernels.lattices.strips import lowest_keys
from geosurf.kernels.meshes import carried_pieces as kernels
from geosurf.kernels.meshes.carried_triangles import COUNT, FIRST_NOW, count_staying
from geosurf.model.pieces import HalfEdges, Pieces, Strips
from geosurf.rebuild.edges import match_again

_MANY = 100_000  # triangles, from which they are counted in threads
_TRIANGLES = 20_000  # of a thread, at least: a millisecond of work


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


class Part(NamedTuple):
    """What one thread does: a range of surfaces.

    Attributes
    ----------
    place : ndarray of int64, shape (10,)
        First and last + 1 of its surfaces, triangles, runs, earlier triangles and earlier runs.
    blocks : ndarray of int64, shape (n, 3)
        Its triangles that stay: see `carried_triangles`.
    n_most : int
        How many half-edges its new triangles have.
    """

    place: np.ndarray
    blocks: np.ndarray
    n_most: int


class Edges(NamedTuple):
    """Edges of pieces that come from earlier ones.

    Attributes
    ----------
    n : int
        How many half-edges there are.
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
    parts : list of Part
    """

    n: int
    before: Kept
    after: np.ndarray
    halves: np.ndarray
    ring: np.ndarray
    link: np.ndarray
    blocks: np.ndarray
    runs: tuple[np.ndarray, np.ndarray]
    linked: np.ndarray
    rim: np.ndarray
    parts: list[Part]

    def half_edges(self) -> HalfEdges:
        """Rings and links of all half-edges; those that stay are written when they are needed.

        Volumes do without them. They are at the latest written when another scene is made of this
        one, so that no chain of scenes is held.
        """
        ring0, _ = self.before.pieces.half_edges.complete()
        known = self.halves, self.ring, self.link
        return HalfEdges(unwritten=EarlierHalfEdges(
            self.n, self.blocks, self.after, ring0, *known, self.linked
        ))  # fmt: skip


@dataclass(frozen=True, eq=False)
class EarlierHalfEdges:
    """All half-edges of which earlier pieces have some; as in `Edges`, and `ring0` of these."""

    n: int
    blocks: np.ndarray
    after: np.ndarray
    ring0: np.ndarray
    halves: np.ndarray
    ring: np.ndarray
    link: np.ndarray
    linked: np.ndarray

    def write(self) -> tuple[np.ndarray, np.ndarray]:
        """Return their rings and links."""
        ring, link = (np.empty(self.n, dtype=np.int64) for _ in range(2))
        known = self.halves, self.ring, self.link
        kernels.write_rings(self.blocks, self.after, self.ring0, *known, self.linked, ring, link)
        return ring, link


def carry_edges(
    carried: Carried,
    after: np.ndarray,
    blocks: np.ndarray,
    t: np.ndarray,
    surface: np.ndarray,
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
    t, surface, strips, first_run
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

    # half-edges beside what is gone: each thread marks for itself, since rings lead anywhere
    parts = _parts(same, old, surface, first_run, blocks)
    n_word, ring0 = 3 * len(t) // 8 + 1, old.ring
    words = [np.zeros(n_word, dtype=np.int64) for _ in parts]
    find: list[Callable[[], Any]] = [partial(kernels.carry_links, kept.linked, after, run_after)]
    find += [
        partial(kernels.mark_halves, one.blocks, *one.place[6:8], after, ring0, own.view(bool))
        for one, own in zip(parts, words, strict=True)
    ]
    (linked, bare), *counts = map_threads(_call, [(task,) for task in find])
    for own in words[1:]:
        words[0] |= own
    marked = words[0].view(bool)
    marked[bare] = True

    n_marked = len(bare) + sum(counts)
    rooms = [np.empty(one.n_most + n_marked, dtype=np.int64) for one in parts]
    write: list[Callable[[], Any]] = [
        partial(kernels.list_halves, one.blocks, *one.place[2:4], marked, words[0], own)
        for one, own in zip(parts, rooms, strict=True)
    ]
    write.append(partial(kernels.carry_rim, kept.rim, after, marked))
    *ns, rim = map_threads(_call, [(task,) for task in write])
    halves = np.concatenate([own[:n] for own, n in zip(rooms, ns, strict=True)])
    ring, link = match_again(t, n_point, halves)
    runs = run_before, run_after
    return Edges(3 * len(t), kept, after, halves, ring, link, blocks, runs, linked, rim, parts)


def _call(task: Callable[[], Any]) -> Any:
    return task()


def _parts(
    same: Unchanged, old: Pieces, surface: np.ndarray, first_run: np.ndarray, blocks: np.ndarray
) -> list[Part]:
    """Ranges of whole surfaces with about as many triangles each, one for each thread."""
    n, n0 = len(first_run) - 1, len(same.surface)
    cut = np.searchsorted(surface, np.arange(n + 1))
    cut0 = np.searchsorted(old.surface, np.arange(n0 + 1))
    wanted = [end for _, end in in_ranges(len(surface), _TRIANGLES)[:-1]]
    inner = {int(np.abs(cut - end).argmin()) for end in wanted} - {0, n}

    # earlier surfaces that are gone are of the range before
    stay = np.flatnonzero(same.surface >= 0)
    ends = [0, *sorted(inner), n]
    ends0 = [int(stay[np.searchsorted(same.surface[stay], s)]) for s in ends[1:-1]]
    ends0 = [0, *ends0, n0]
    rows = np.searchsorted(blocks[:, FIRST_NOW], cut[ends])
    found = []
    for k, (i, j) in enumerate(pairwise(ends)):
        i0, j0 = ends0[k : k + 2]
        place = [i, j, cut[i], cut[j], first_run[i], first_run[j]]
        place += [cut0[i0], cut0[j0], old.first_run[i0], old.first_run[j0]]
        own = blocks[rows[k] : rows[k + 1]]
        n_most = 3 * int(cut[j] - cut[i] - own[:, COUNT].sum())
        found.append(Part(np.array(place, dtype=np.int64), own, n_most))
    return found


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
    n_patch0 = old.n_patch
    runs = *runs_of_all(strips, first_run), first_run
    patch = np.empty(len(surface) + int(first_run[-1]), dtype=np.int64)
    rows = []
    for place, blocks, _ in came.parts:
        halves = np.searchsorted(came.halves, 3 * place[2:4])
        rim = came.rim[slice(*np.searchsorted(came.rim, 3 * place[2:4]))]
        rows.append((
            np.append(place, halves), blocks, came.after, old.ring, came.linked, *came.runs,
            n_patch0, old.patch, surface, key, came.ring, came.link, came.halves, rim, *runs, patch,
        ))  # fmt: skip
    found = map_threads(kernels.carry_patches, rows)

    # patches are numbered by surfaces: those of earlier ranges come first
    first = np.cumsum([0, *(count for count, _, _ in found)]).tolist()
    patch_after = np.full(n_patch0, -1, dtype=np.int64)
    for by, (_, _, own) in zip(first, found, strict=False):
        patch_after[own >= 0] = own[own >= 0] + by
    ends = [(place[2:4], len(surface) + place[4:6]) for place, _, _ in came.parts]
    later = [(patch, *some, by) for by, both in zip(first, ends, strict=False) for some in both]
    map_threads(kernels.shift_patches, later[2:])
    _, before, after, halves, ring, link = came[:6]
    rim = np.concatenate([own for _, own, _ in found])
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
