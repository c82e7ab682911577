"""Well tops on a cut horizon: what correction each needs, and why others are not used."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.measure.well_columns import columns_through, fault_between, nearest_first
from geosurf.model.tops import Tops
from geosurf.sheets.tie.cut_horizon import CutHorizon


@dataclass(frozen=True, eq=False)
class Controls:
    """Tops that a horizon is tied to.

    Attributes
    ----------
    top : ndarray of int64, shape (n,)
        Row of the tops.
    triangle : ndarray of int64, shape (n,)
        Row of `CutHorizon.triangles` above or below the top.
    share : ndarray of float64, shape (n, 3)
        Shares of its corners in the elevation there.
    residual : ndarray of float64, shape (n,)
        Top minus horizon: the correction that is missing [m].
    unused : dict of int to str
        Other tops of the horizon, each with its reason.
    """

    top: np.ndarray
    triangle: np.ndarray
    share: np.ndarray
    residual: np.ndarray
    unused: dict[int, str]

    @property
    def largest(self) -> float:
        """Largest residual [m]."""
        return float(np.abs(self.residual).max(initial=0.0))


def controls_of(cut: CutHorizon, tops: Tops, rows: np.ndarray) -> Controls:
    """
    Compare tops with the horizon above or below them.

    Parameters
    ----------
    cut : CutHorizon
    tops : Tops
    rows : ndarray of int64
        Tops of this horizon.

    Returns
    -------
    Controls
    """
    columns = columns_through(cut.patches, tops.points[rows])
    names = cut.patches.names
    unused: dict[int, str] = {}
    found: list[tuple[int, int]] = []
    for k, row in enumerate(rows.tolist()):
        at = columns.at(k)
        z, surface = columns.elevation[at], columns.surface[at]
        picked = float(tops.points[row, 2])
        faults, mine = np.flatnonzero(surface != 0), np.flatnonzero(surface == 0)
        of_fault = [names[i] for i in surface[faults].tolist()]
        if not len(mine):
            unused[row] = "lies outside the data of the horizon"
            if of_fault:
                nearest = of_fault[int(np.abs(z[faults] - picked).argmin())]
                unused[row] = f"lies in the gap of fault {nearest!r}"
            continue
        best = int(mine[nearest_first(z[mine], picked)[0]])
        between = fault_between(z[faults], of_fault, picked, float(z[best]))
        if between:
            unused[row] = f"lies on the other side of fault {between!r} than the horizon there"
            continue
        found.append((row, at.start + best))
    top, crossing = np.array(found, dtype=np.int64).reshape(-1, 2).T
    triangle = np.searchsorted(cut.rows, columns.triangle[crossing])
    residual = tops.points[top, 2] - columns.elevation[crossing]
    share = shares_in(cut, triangle, tops.points[top, :2])
    return Controls(top, triangle, share, residual, unused)


def shares_in(cut: CutHorizon, triangle: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Shares (n, 3) of the corners of triangles in values at places (n, 2) inside them."""
    corners = cut.x[cut.triangles[triangle], :2] - places[:, None, :]
    turn = np.stack(
        [
            corners[:, (k + 1) % 3, 0] * corners[:, (k + 2) % 3, 1]
            - corners[:, (k + 1) % 3, 1] * corners[:, (k + 2) % 3, 0]
            for k in range(3)
        ],
        axis=1,
    )
    total = turn.sum(axis=1, keepdims=True)
    turn = np.maximum(turn * np.sign(total), 0.0)  # below 0 by rounding only
    total = turn.sum(axis=1, keepdims=True)
    flat = total[:, 0] == 0
    turn[flat], total[flat] = 1.0, 3.0
    shares: np.ndarray = turn / total
    return shares
