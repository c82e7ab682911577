"""A torn lattice finds what lies around its gone triangles without a look at all of it."""

import numpy as np
import pytest

from geosurf.kernels.lattices.strips import keys_across
from geosurf.model import Lattice
from geosurf.model.torn_lattice import TornLattice

N_ROW, N_COL = 6, 8


def torn(seed, rising, whole):
    rng = np.random.default_rng(seed)
    z = rng.uniform(0.0, 9.0, (N_ROW, N_COL))
    if not whole:
        z[tuple(rng.integers(0, (N_ROW, N_COL), (4, 2)).T)] = np.nan
    lattice = Lattice(np.arange(float(N_COL)), np.arange(float(N_ROW)), z, rising)
    there = np.flatnonzero(
        lattice.present.ravel()[lattice.corners_of_keys(np.arange(2 * (N_ROW - 1) * (N_COL - 1)))]
        .all(axis=1)
    )  # fmt: skip
    gone = np.sort(rng.choice(there, rng.integers(0, len(there)), replace=False))
    nodes = rng.choice(N_ROW * N_COL, 3, replace=False)
    row, col = np.divmod(nodes, N_COL)
    ghosts = np.column_stack([col, row, np.zeros(3)]).astype(float)
    copies = N_ROW * N_COL + np.array([[0, 1, 2]])
    return TornLattice.of(lattice, gone, copies, ghosts), there


@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize("rising", [True, False])
def test_what_lies_around_gone_triangles(rising, whole):
    for seed in range(40):
        lattice, there = torn(seed, rising, whole)
        absent = np.ones((N_ROW - 1, N_COL - 1, 2), dtype=bool)
        left = np.setdiff1d(there, lattice.gone)
        absent.reshape(-1)[left] = False
        strips = absent[..., ::-1] if rising else absent
        edge = np.diff(np.pad(strips.reshape(N_ROW - 1, -1), ((0, 0), (1, 1))).astype(int), axis=1)
        row, place = np.nonzero(edge)
        holes = np.stack([row[::2], place[::2], place[1::2] - 1], axis=1)
        start = N_ROW + 2 * np.searchsorted(holes[:, 0], np.arange(N_ROW))
        assert lattice.gaps.tolist() == [*start, *holes[:, 1:].ravel()]

        edge = np.tile(np.arange(3), len(lattice.gone))
        none = np.empty(0, dtype=np.int64)
        over = keys_across(lattice.places, none, False, np.repeat(lattice.gone, 3), edge)
        assert lattice.beside_gaps.tolist() == np.intersect1d(over, left).tolist()

        below = lattice.node_of_ghost
        near = np.isin(lattice.corners_of_keys(left), below).any(axis=1)
        cells = np.isin(left // 2, left[near] // 2)
        rows = lattice.rows_beside_copies
        assert lattice.n_present == int(np.isfinite(lattice.elevation).sum()) + 3
        found = lattice.keys_of_rows(rows)
        assert set(left[near]) <= set(found[:-1].tolist()) <= set(left.tolist())
        assert set(left[cells]) <= set(found[:-1].tolist())
        assert found[-1] == lattice.n_key
