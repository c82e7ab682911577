"""The correction of a horizon: it meets the residuals of all tops and ends at the range.

A top acts by Wendland's function (1 - q)^4 (1 + 4 q) of its distance over the range (Wendland 1995,
doi 10.1007/BF02123482): 1 at the well, 0 from the range on, smooth in between. Distances do not
cross faults. Weights follow from the residuals, as in simple kriging with this covariance.
"""

from __future__ import annotations

import numpy as np

from geosurf.conventions import length_text, place
from geosurf.errors import GeometryError, InputError
from geosurf.model.tie import TieSettings
from geosurf.model.tops import Tops
from geosurf.sheets.tie.controls import Controls
from geosurf.sheets.tie.cut_horizon import CutHorizon
from geosurf.sheets.tie.map_distance import map_distances

STEEPEST = 0.5  # change of the correction over distance beyond which two tops contradict
FEWEST_CELLS = 3.0  # a range that cells can follow
OVERSHOOT = 3.0  # times the largest residual


def correction(
    cut: CutHorizon, controls: Controls, tops: Tops, settings: TieSettings, *, check: bool
) -> np.ndarray:
    """
    Return the change of elevation at each vertex of a cut horizon.

    Parameters
    ----------
    cut : CutHorizon
    controls : Controls
    tops : Tops
    settings : TieSettings
    check : bool
        Whether the tops are compared with each other, which the first correction needs.

    Returns
    -------
    ndarray of float64, shape (n_vertex,)
        [m]

    Raises
    ------
    InputError
        If the range is too small for the cells, or two tops contradict each other.
    """
    reach = settings.range
    if reach < FEWEST_CELLS * cut.cell:
        raise InputError(
            f"the tie has a range of {length_text(reach)}, less than {FEWEST_CELLS:g} cells of "
            f"horizon {tops.horizons[controls.top[0]]!r}. Give at least "
            f'tie={{"range": {np.ceil(FEWEST_CELLS * cut.cell):.0f}}}.'
        )

    # one field for each top: vertices in reach, and their distance around faults
    fields = [
        map_distances(cut.x, cut.triangles, cut.walls, start, tops.points[row, :2], reach)
        for row, start in zip(controls.top.tolist(), controls.triangle.tolist(), strict=True)
    ]
    far = _between(cut, controls, fields)
    groups = _groups(far, cut.cell)
    if check:
        _refuse_contradictions(controls, tops, far, groups, settings)

    # tops in one cell act as one: the mean of them meets the mean of their residuals
    mean = (groups == np.arange(groups.max() + 1)[:, None]) / np.bincount(groups)[:, None]

    # acts (n, n): how top k acts at top i. Least squares, should the matrix be singular
    acts = np.stack([_at_controls(cut, controls, field, reach) for field in fields], axis=1)
    weights = np.linalg.lstsq(mean @ acts @ mean.T, mean @ controls.residual)[0] @ mean

    change = np.zeros(len(cut.x))
    for weight, (vertices, distance) in zip(weights.tolist(), fields, strict=True):
        change[vertices] += weight * wendland(distance / reach)

    # an overshoot: several tops contradict each other, though no pair of them does by itself
    if np.abs(change).max(initial=0.0) > OVERSHOOT * controls.largest:
        _refuse_steepest(controls, tops, far)
    return change


def wendland(q: np.ndarray) -> np.ndarray:
    """Share of a correction at a distance over the range.

    Examples
    --------
    >>> wendland(np.array([0.0, 0.5, 1.0, 2.0])).tolist()
    [1.0, 0.1875, 0.0, 0.0]
    """
    inside = np.maximum(1.0 - q, 0.0)
    return inside**4 * (1.0 + 4.0 * q)


def _at_controls(
    cut: CutHorizon, controls: Controls, field: tuple[np.ndarray, np.ndarray], reach: float
) -> np.ndarray:
    """How one top acts at all of them, as the triangles interpolate it."""
    vertices, distance = field

    # interpolated as the mesh is, not read off exactly: so the mesh itself meets the top
    value = np.zeros(len(cut.x))
    value[vertices] = wendland(distance / reach)
    return (value[cut.triangles[controls.triangle]] * controls.share).sum(axis=1)


def _between(
    cut: CutHorizon, controls: Controls, fields: list[tuple[np.ndarray, np.ndarray]]
) -> np.ndarray:
    """Distances (n, n) between tops that do not cross a fault [m]; infinite beyond the range."""
    n = len(fields)
    far = np.full((n, n), np.inf)
    value = np.full(len(cut.x), np.nan)
    corners = cut.triangles[controls.triangle]
    for k, (vertices, distance) in enumerate(fields):
        # NaN at a corner out of reach, or behind a fault, makes the pair infinitely far apart
        value[vertices] = distance
        weighed = np.where(controls.share > 0, value[corners] * controls.share, 0.0).sum(axis=1)
        far[:, k] = np.where(np.isnan(weighed), np.inf, weighed)
        value[vertices] = np.nan
    far[np.arange(n), np.arange(n)] = 0.0

    # both directions are computed; rounding, and reach, may make one of them shorter
    same_place: np.ndarray = np.minimum(far, far.T)
    return same_place


def _groups(far: np.ndarray, cell: float) -> np.ndarray:
    """Number of the group of each top: tops less than a cell apart are in one."""
    from scipy.sparse.csgraph import connected_components

    number: np.ndarray = connected_components(far < cell, directed=False)[1]
    return number


def _refuse_contradictions(
    controls: Controls, tops: Tops, far: np.ndarray, groups: np.ndarray, settings: TieSettings
) -> None:
    """Refuse two tops that no smooth correction meets."""
    # in one cell residuals may differ by little, farther apart by a slope of STEEPEST
    apart = np.abs(controls.residual[:, None] - controls.residual[None, :])
    together = groups[:, None] == groups[None, :]
    allowed = np.where(together, 1.5 * settings.tolerance, STEEPEST * far)
    excess = np.where(np.isfinite(far) & (apart > allowed), apart / np.maximum(far, 1.0), 0.0)
    if excess.any():
        _refuse(controls, tops, far, int(excess.argmax()))


def _refuse_steepest(controls: Controls, tops: Tops, far: np.ndarray) -> None:
    """Name the two tops between which the correction is steepest."""
    apart = np.abs(controls.residual[:, None] - controls.residual[None, :])
    slope = np.where(np.isfinite(far), apart / np.maximum(far, 1.0), 0.0)
    _refuse(controls, tops, far, int(slope.argmax()))


def _refuse(controls: Controls, tops: Tops, far: np.ndarray, pair: int) -> None:
    """Name both tops of a pair, an entry of the matrix of distances."""
    i, j = sorted(divmod(pair, len(far)))
    first, second = controls.top[i], controls.top[j]
    raise GeometryError(
        f"well tops of {tops.horizons[first]!r} contradict each other: wells {tops.wells[first]!r} "
        f"and {tops.wells[second]!r} are {length_text(far[i, j])} apart on one side of all faults, "
        f"near {place(tops.points[first])}, and need corrections of "
        f"{controls.residual[i]:.4g} m and {controls.residual[j]:.4g} m. Correct or leave out one "
        "of them, or add the fault between them.",
        place=tops.points[first],
        surfaces=(tops.horizons[first],),
    )


__all__ = ["correction", "wendland"]
