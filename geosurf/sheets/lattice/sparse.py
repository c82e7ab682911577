"""The energy of a surface as a sparse matrix, for solves in which data are rows of the equations.

On grids the unknowns are nodes in a band, and `geosurf.sheets.lattice.solve` factorises an
envelope. Rows of scattered points couple nodes in any order: there SuperLU solves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geosurf.kernels.sheets.smooth_surface import normal_equations
from geosurf.sheets.lattice.solve import Graph

if TYPE_CHECKING:
    from scipy.sparse import csc_array

EXACT = 1.0  # weight of points without noise: bilinear cells cannot meet them better
# SuperLU in the order of a symmetric matrix: pivots off the diagonal would fill it seven times over
CHOLESKY = {
    "permc_spec": "MMD_AT_PLUS_A",
    "diag_pivot_thresh": 0.0,
    "options": {"SymmetricMode": True},
}


def energy_of(graph: Graph, unknown: np.ndarray, weights: np.ndarray) -> csc_array:
    """Sparse matrix (n_unknown, n_unknown) of the energy; `unknown` as for `smoothest`."""
    from scipy.sparse import csc_array

    # one row per unknown: weights, and the columns that they belong to, -1 for none
    matrix, column = normal_equations(
        graph.east, graph.north, graph.square, graph.cell, unknown, weights
    )
    present = column >= 0
    where = np.repeat(np.arange(len(column)), present.sum(axis=1)), column[present]
    return csc_array((matrix[present], where), shape=(len(column), len(column)))
