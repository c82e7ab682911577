"""Third differences of a grid, read row by row, against those of each line by itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.thirds import third_differences


@given(st.data(), st.integers(1, 3), st.integers(1, 3), st.integers(1, 3))
def test_third_differences_are_those_of_all_lines_without_a_hole(data, step, rows, cols):
    shape = data.draw(st.integers(2, 12)), data.draw(st.integers(2, 12))
    grid = np.random.default_rng(step + 3 * rows).integers(-99, 99, shape).astype(float)
    for hole in data.draw(st.sets(st.integers(0, grid.size - 1), max_size=3)):
        grid.flat[hole] = np.nan
    wanted = []
    for line in [*grid[::rows], *grid.T[::cols]]:
        for k in range(len(line) - 3 * step):
            if not np.isnan(line[k : k + 3 * step + 1]).any():
                a, b, c, d = line[k : k + 3 * step + 1 : step]
                wanted.append(abs(d - 3.0 * c + 3.0 * b - a))
    found = third_differences(grid, step, rows, cols)
    assert np.sort(found) == pytest.approx(np.sort(wanted))
