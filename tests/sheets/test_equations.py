"""The equations of the smoothest surface against differences that are written out one by one."""

import numpy as np

from geosurf.sheets.lattice.solve import lattice_graph, smoothest


def test_a_cubic_is_carried_on_beyond_the_data():
    """Fourth differences of a cubic are zero: where data end, it goes on as it is."""
    row, col = np.divmod(np.arange(400), 20)
    x, y = 0.1 * col, 0.1 * row
    cubic = 3.0 * x**3 - 2.0 * x**2 * y + x * y**2 + y**3 - x * y + 4.0
    unknown = np.where(col >= 14, np.cumsum(col >= 14) - 1, -1)
    graph = lattice_graph(np.arange(400), (20, 20))
    wall = unknown >= 0
    exact = cubic[wall]
    third, fourth = (
        smoothest(graph, unknown, np.where(wall, 0.0, cubic), np.ones(2), order=k) for k in (3, 4)
    )
    near = col[wall] < 18
    assert np.abs(fourth - exact)[near].max() < 0.3 * np.abs(third - exact)[near].max()
