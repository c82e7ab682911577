"""Triangles of runs that rays of a certificate may meet: only these are listed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geosurf.carve.certificate.elements import keys_of_runs
from geosurf.carve.certificate.lattice_runs import LatticeRuns
from geosurf.kernels.lattices.strips import FIRST, LAST
from geosurf.model.regions import Boxes

_SLIP = 1e-3  # [m] around boxes; far more than rounding in a frame moves them by


@dataclass(frozen=True, eq=False)
class NearRuns:
    """
    Lists triangles of runs: see `Elements.near`.

    It does not refer to the elements: what refers to itself stays in memory after its last use.

    Attributes
    ----------
    n_triangle : int
        Elements before the first run.
    lattices : sequence of LatticeRuns
    bounds : ndarray of float64, shape (n_run, 6)
        Lower, then upper corner of each run, local.
    origin : ndarray, shape (3,)
    """

    n_triangle: int
    lattices: Sequence[LatticeRuns]
    bounds: np.ndarray
    origin: np.ndarray

    def __call__(
        self, starts: np.ndarray, boxes: np.ndarray, wanted: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """A triangle of some runs, then those of wanted ones near boxes."""
        n = self.n_triangle
        some = np.zeros(len(wanted), dtype=bool)
        low, high = self.bounds[:, :3], self.bounds[:, 3:]
        for box in boxes:
            some[n:] |= ((low <= box[3:]) & (high >= box[:3])).all(axis=1) & wanted[n:]
        parts = [(np.empty((0, 3, 3)), np.empty(0, dtype=np.int64))]
        parts += self._first_triangles(np.unique(starts[starts >= n]))
        parts += self._triangles_near(some, boxes)
        corners, rows = zip(*parts, strict=True)
        return np.concatenate(corners), np.concatenate(rows)

    def _first_triangles(self, rows: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Corners of the first triangle of some runs, and these runs, lattice by lattice."""
        out = []
        for one in self.lattices:
            mine = rows[(rows >= one.runs.start) & (rows < one.runs.stop)]
            runs = one.strips.runs[mine - one.first]
            runs[:, LAST] = runs[:, FIRST]
            keys = keys_of_runs(one.lattice.places, runs)
            out.append((one.corners(keys, self.origin), mine))
        return out

    def _triangles_near(
        self, some: np.ndarray, boxes: np.ndarray
    ) -> list[tuple[np.ndarray, np.ndarray]]:
        """Corners and runs of the triangles of some runs that may be near boxes."""
        out, world = [], boxes + np.tile(self.origin, 2)
        region = Boxes(world[:, :2] - _SLIP, world[:, 3:5] + _SLIP)
        for one in self.lattices:
            if not some[one.runs].any():
                continue
            cells = region.cells(one.lattice)
            keys = np.stack([2 * cells, 2 * cells + 1], axis=1).ravel()
            run = one.run_of(keys)
            mine = np.flatnonzero((run >= 0) & some[one.runs][run])
            corners = one.corners(keys[mine], self.origin)
            out.append((corners, one.first + run[mine]))
        return out
