"""Blocks of one kind from runs: those that a table of all triangles shows."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf.kernels.lattices.run_checks import find_blocks


def runs_of(kinds: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Runs of a table (row, place) of kinds, some of them in two parts; first run of each row."""
    runs, kind, start = [], [], [0]
    for row, of in enumerate(kinds):
        ends = np.flatnonzero(np.append(np.diff(of) != 0, True) | (rng.random(len(of)) < 0.05))
        for first, last in zip([0, *(ends[:-1] + 1)], ends, strict=True):
            if of[first] > 0 or rng.random() < 0.5:  # runs that are left out, or no run
                runs.append((row, first, last, 0))
                kind.append(of[first])
        start.append(len(runs))
    rows = np.array(runs, dtype=np.int64).reshape(-1, 4)
    return rows, np.array(start, dtype=np.int64), np.array(kind, dtype=np.int64)


def blocks_in(kinds: np.ndarray, sizes: list[int]) -> tuple[list, list]:
    """Blocks and triangles beside them, one by one."""
    left, blocks = kinds.copy(), []
    n_row, n_place = kinds.shape
    for k, size in enumerate(sizes):
        for row in range(0, n_row - size + 1, size):
            for col in range(0, n_place // 2 - size + 1, size):
                of = left[row : row + size, 2 * col : 2 * (col + size)]
                if of[0, 0] > 0 and (of == of[0, 0]).all():
                    blocks.append((k, row, col, of[0, 0]))
                    of[:] = 0
    return blocks, [(*place, left[tuple(place)]) for place in np.argwhere(left).tolist()]


@pytest.mark.parametrize("seed", range(12))
def test_law_blocks_are_those_of_a_table_of_all_triangles(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n_row, n_col = rng.integers(1, 40, size=2).tolist()
    sizes = [[8, 4, 2], [3], [4, 2], [1]][seed % 4]
    kinds = np.ones((n_row, 2 * n_col), dtype=np.int64)
    kinds[:, rng.integers(0, 2 * n_col) :] = rng.integers(0, 3)
    some = rng.random(kinds.shape) < 0.02
    kinds[some] = rng.integers(0, 3, size=int(some.sum()))
    given = *runs_of(kinds, rng), np.array(sizes), n_row, n_col
    none = np.empty((0, 4), dtype=np.int64), np.empty((0, 3), dtype=np.int64)
    n_block, n_fine = find_blocks(*given, *none)
    blocks, fine = np.empty((n_block, 4), dtype=np.int64), np.empty((n_fine, 3), dtype=np.int64)
    assert find_blocks(*given, blocks, fine) == (n_block, n_fine)
    expected = blocks_in(kinds, sizes)
    ours = sorted(map(tuple, blocks.tolist()))
    assert ours == sorted(expected[0])
    assert list(map(tuple, fine.tolist())) == [tuple(map(int, row)) for row in expected[1]]

    # blocks of each size come row by row
    for k in range(len(sizes)):
        mine = [tuple(row) for row in blocks[blocks[:, 0] == k, 1:3].tolist()]
        assert mine == sorted(mine)
