"""Split surfaces at the cost of what is cut: cut parts as triangles, the rest as runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.model.base import frozen
from geosurf.model.surfaces import TriSurface

FREE, PAIRED = -1, -2


@dataclass(frozen=True, eq=False)
class Strips:
    """The triangles of a lattice that no curve touches; see `geosurf.kernels.strips`.

    Attributes
    ----------
    places, absent, runs, start : ndarray of int64
        As the kernels have them.
    joined : ndarray of int64, shape (n, 2)
        Runs of neighbouring rows that share an edge.
    nodes, points : ndarray of int64, shape (n,)
        Nodes of the lattice, rising, that are points of the triangles, and which.
    """

    places: np.ndarray
    absent: np.ndarray
    runs: np.ndarray
    start: np.ndarray
    joined: np.ndarray
    nodes: np.ndarray
    points: np.ndarray


@dataclass(frozen=True, eq=False)
class Pieces:
    """All parts of some surfaces: triangles first, then runs; each is an element.

    Attributes
    ----------
    x : ndarray of float64, shape (n_point, 3)
        Local coordinates of the triangles' corners.
    triangles : ndarray of int64, shape (n_triangle, 3)
        Triangles that a curve touches or that belong to no lattice, surface by surface.
    surface, key : ndarray of int64, shape (n_triangle,)
        Row of the surface, and key of the triangle in it that each is a part of.
    twin : ndarray of int64, shape (n_triangle,)
        The first triangle with the same corners: itself, but where surfaces coincide.
    ring : ndarray of int64, shape (3 * n_triangle,)
        Next half-edge around the same edge.
    link : ndarray of int64, shape (3 * n_triangle,)
        For a half-edge that is alone: the run behind it, or FREE; else PAIRED.
    strips : list of Strips or None
        For each surface.
    first_run : ndarray of int64, shape (n_surface + 1,)
        Runs are numbered over all surfaces.
    patch : ndarray of int64, shape (n_triangle + n_run,)
    """

    sources: Sequence[TriSurface]
    origin: np.ndarray
    x: np.ndarray
    triangles: np.ndarray
    surface: np.ndarray
    key: np.ndarray
    twin: np.ndarray
    ring: np.ndarray
    link: np.ndarray
    strips: list[Strips | None]
    first_run: np.ndarray
    patch: np.ndarray

    @cached_property
    def expanded(self) -> Expanded:
        """Everything as plain arrays."""
        return _expand(self)


@dataclass(frozen=True, eq=False)
class Expanded:
    """Pieces as plain arrays: one row for each triangle, surface by surface, row by row."""

    local: np.ndarray
    triangles: np.ndarray
    surface: np.ndarray
    parent: np.ndarray
    element: np.ndarray


def _expand(pieces: Pieces) -> Expanded:
    """Runs become triangles; points of the triangles come first, then nodes of the lattices."""
    from geosurf.kernels.strips import spread_over_runs

    local, n = [pieces.x], len(pieces.x)
    parts: list[tuple[np.ndarray, ...]] = []
    n_core = len(pieces.triangles)
    cut = np.searchsorted(pieces.surface, np.arange(len(pieces.sources) + 1))
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        rows = np.arange(cut[i], cut[i + 1])
        t, key = pieces.triangles[rows], pieces.key[rows]
        element = rows
        if strips is not None:
            n_row, n_col = strips.places[9:11] - 1
            run = np.full(2 * n_row * n_col, -1, dtype=np.int64)
            spread_over_runs(strips.places, strips.runs, run)
            keys = np.flatnonzero(run >= 0)
            corners = source.corners_of_keys(keys)
            id_of_node = np.full((n_row + 1) * (n_col + 1), -1, dtype=np.int64)
            mark = np.zeros(len(id_of_node), dtype=bool)
            mark[corners] = True
            id_of_node[strips.nodes] = strips.points
            new = np.flatnonzero(mark & (id_of_node < 0))
            id_of_node[new] = np.arange(n, n + len(new))
            n += len(new)
            local.append(source.places_of_nodes(new) - pieces.origin)
            at = np.searchsorted(keys, key)
            far = (id_of_node[corners], keys, n_core + pieces.first_run[i] + run[keys])
            t, key, element = (
                _merged(at, mine, others)
                for mine, others in zip((t, key, element), far, strict=True)
            )
        parts.append((t, np.full(len(t), i), source.rows_of_keys(key), element))
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    return Expanded(
        frozen(np.concatenate(local), np.float64), *(frozen(column, np.int64) for column in columns)
    )


def _merged(at: np.ndarray, some: np.ndarray, others: np.ndarray) -> np.ndarray:
    """`some` put into `others`, before the rows `at` (rising)."""
    out = np.empty((len(some) + len(others), *some.shape[1:]), dtype=np.int64)
    place = at + np.arange(len(some))
    rest = np.ones(len(out), dtype=bool)
    rest[place] = False
    out[place] = some
    out[rest] = others
    return out
