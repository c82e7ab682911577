"""Volume below, areas and bounds of faces: what units add up."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.measures import measure_runs, measure_triangles
from geosurf.model.pieces import Pieces

# columns: volume below as two numbers, area in the map, area, lower and upper corner
BELOW, REST, FLAT, AREA, LOWER, UPPER = 0, 1, 2, 3, slice(4, 7), slice(7, 10)


def measure(pieces: Pieces, element: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """
    Measure elements: triangles and runs.

    Parameters
    ----------
    pieces : Pieces
    element : ndarray of int64, shape (n,)
        Rising; triangles come before runs.
    middle : ndarray of float64, shape (3,)
        Local coordinates; heights count from here.

    Returns
    -------
    ndarray of float64, shape (n, 10)
        See the columns of this module. The volume between a triangle and the level of `middle` is
        its area in the map times its mean height; over a closed shell, these add up to
        the volume inside.
    """
    n_core = len(pieces.triangles)
    core, runs = element[element < n_core], element[element >= n_core] - n_core
    parts = [measure_triangles(pieces.x, pieces.triangles[core], middle)]
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        if strips is None:
            continue
        mine = runs[(runs >= pieces.first_run[i]) & (runs < pieces.first_run[i + 1])]
        found = measure_runs(
            *source.lattice.coordinates, strips.places,
            strips.runs[mine - pieces.first_run[i]], middle + pieces.origin,
        )  # fmt: skip
        if source.lattice.turned:
            found[:, : FLAT + 1] *= -1.0
        found[:, LOWER] -= pieces.origin
        found[:, UPPER] -= pieces.origin
        parts.append(found)
    return np.concatenate(parts)
