"""Uncertain horizons: shifted as a whole, or by an error that is correlated in the map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import counted
from geosurf.ensemble.change import Change, Given, names_among
from geosurf.ensemble.fields import Covariance, FieldGrid, GaussianField
from geosurf.ensemble.horizon_data import HorizonData
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model.distributions import Distribution, distribution_of, reach_of
from geosurf.model.tops import tops_of
from geosurf.warning import warn

TOPS = "tops"
FAR = 6.0  # standard deviations: no field of a few million nodes leaves them


def of_names(what: str, names: Any) -> str:
    """Name a parameter after the surfaces that it changes."""
    listed = (names,) if isinstance(names, str) else tuple(names)
    return f"{what} {', '.join(listed)}".strip()


@dataclass(frozen=True)
class DepthShift:
    """
    Horizons that move up or down as a whole, all by the same length.

    Parameters
    ----------
    horizons : str or sequence of str
        Empty: all.
    by : distribution or float
        [m], positive up.
    name : str, optional
        Of the parameter in all results; default ``"depth shift Top"``.

    Examples
    --------
    >>> DepthShift("Top", 5.0).parameter
    'depth shift Top'
    """

    horizons: str | Sequence[str]
    by: Any
    name: str = ""

    unit = "m"

    @property
    def parameter(self) -> str:
        """Name of the parameter."""
        return self.name or of_names("depth shift", self.horizons)

    def prepare(self, given: Given) -> PreparedShift:
        """Check names and distribution."""
        # Names are checked once, not in every realisation.
        names = names_among(self.horizons, given.horizon_names, "horizon")
        return PreparedShift(self.parameter, names, distribution_of(self.by, self.parameter))


@dataclass(frozen=True)
class PreparedShift:
    """A `DepthShift` of a given model."""

    parameter: str
    horizons: tuple[str, ...]
    by: Distribution

    def reach(self) -> float:
        """Return how far horizons may move [m]."""
        return reach_of(self.by)

    def apply(self, change: Change) -> None:
        """Move the horizons."""
        # One number for all horizons: they move together.
        length = change.numbers[self.parameter] = change.draws.number(self.parameter, self.by)
        for name in self.horizons:
            change.lift(name, length)


@dataclass(frozen=True)
class DepthError:
    """
    An error of horizons that is correlated in the map: a Gaussian field with mean 0.

    Parameters
    ----------
    horizons : str or sequence of str
        All get the same error. Give one `DepthError` for each horizon if errors are independent.
    sd : float
        Standard deviation [m].
    range : float
        Distance at which the correlation has fallen to 5 % [m].
    model : {"gaussian", "exponential", "spherical"}
        See ``geosurf.ensemble.Covariance``.
    picks : "tops", None, or array_like of float, shape (n, 3)
        Easting, northing, elevation [m] of points that the horizon passes through in every
        realisation. Default: the well tops of the scene, where it has some.
    name : str, optional
        Of the parameter in all results; default ``"depth error Top"``. Its number is the mean of
        the error over the nodes of the first horizon [m].

    Examples
    --------
    >>> DepthError("Top", sd=10.0, range=1500.0).parameter
    'depth error Top'
    """

    horizons: str | Sequence[str]
    sd: float
    range: float
    model: str = "gaussian"
    picks: Any = TOPS
    name: str = ""

    unit = "m"

    @property
    def parameter(self) -> str:
        """Name of the parameter."""
        return self.name or of_names("depth error", self.horizons)

    def prepare(self, given: Given) -> PreparedError:
        """Check names, choose the lattice of the field, and locate the picks."""
        names = names_among(self.horizons, given.horizon_names, "horizon")
        data = [given.horizon(name) for name in names]
        covariance = Covariance(self.sd, self.range, self.model)
        # On the nodes of the horizons no interpolation is needed.
        grid = _shared_grid(data)
        weights: list[Any] = [None] * len(data)
        # Horizons with different nodes share a field on a lattice of its own.
        if grid is None:
            # Absent nodes have no place; the lattice is laid around the others.
            there = np.concatenate([one.points[one.there, :2] for one in data])
            grid = FieldGrid.around(there, covariance.cell)
            weights = [grid.weights_at(_finite(one.points[:, :2], grid)) for one in data]
        places, values, known = self._picks(given, names, data, weights)
        field = GaussianField(grid, covariance, known, values, places)
        return PreparedError(self.parameter, names, weights, field, data[0].there)

    def _picks(
        self, given: Given, names: tuple[str, ...], data: list[HorizonData], weights: list[Any]
    ) -> tuple[np.ndarray | None, np.ndarray | None, Any]:
        """Places of picks in the map, the error there, and weights of the field in it."""
        points = self._points(given, names)
        if points is None or not len(points):
            return None, None, None
        # One field cannot meet different misfits at the wells of each horizon.
        if len(names) > 1:
            raise InputError(
                f"{self.parameter}: one error of several horizons cannot meet the well tops of "
                "each. Give one for each horizon, or leave tops out: picks=None, or in a scenario "
                "meet_tops = false."
            )
        corners, shares = data[0].shares_at(points[:, :2])
        # Outside of a horizon there is no elevation to compare with.
        inside = np.isfinite(shares).all(axis=1)
        if not inside.all():
            self._warn_of_outside(names[0], int((~inside).sum()), len(points))
        points, corners, shares = points[inside], corners[inside], shares[inside]
        # What the field has to be there: the pick minus the horizon of the base case.
        error = points[:, 2] - (data[0].points[corners, 2] * shares).sum(axis=1)
        return points[:, :2], error, _rows(corners, shares, len(data[0].points), weights[0])

    def _points(self, given: Given, names: tuple[str, ...]) -> np.ndarray | None:
        """Points that the horizon passes through (n, 3); None without."""
        if self.picks is None:
            return None
        # Without well tops in the scene the error is unconditioned.
        if isinstance(self.picks, str):
            if self.picks != TOPS:
                raise InputError(
                    f'{self.parameter}: picks is {self.picks!r}; give "tops" for the well tops '
                    "of the scene, an array (n, 3), or None."
                )
            if given.tops is None:
                return None
            # Only the tops of these horizons count.
            rows = [row for name in names for row in given.tops.of(name).tolist()]
            return given.tops.points[rows]
        if hasattr(self.picks, "keys"):  # a table of tops
            tops = tops_of(self.picks)
            return tops.points[[row for name in names for row in tops.of(name).tolist()]]
        points = np.asarray(self.picks, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise InputError(
                f"{self.parameter}: picks have shape {points.shape}; give finite numbers (n, 3): "
                "easting, northing, elevation."
            )
        return points

    def _warn_of_outside(self, horizon: str, n: int, total: int) -> None:
        effect = (
            f"{n} of {counted(total, 'pick')} lie outside of horizon {horizon!r}, so that its "
            "depth error does not meet them."
        )
        remedy = "Leave these picks out, or extend the horizon with extend_horizon."
        warn(GeosurfWarning("picks", horizon, effect, remedy))


@dataclass(frozen=True, eq=False)
class PreparedError:
    """A `DepthError` of a given model.

    Attributes
    ----------
    parameter : str
    horizons : tuple of str
    weights : list
        Weights of the field's nodes at the points of each horizon; None where these are its nodes.
    field : GaussianField
    there : ndarray of int64
        Points of the first horizon that exist.
    """

    parameter: str
    horizons: tuple[str, ...]
    weights: list[Any]
    field: GaussianField
    there: np.ndarray

    def reach(self) -> float:
        """Return how far horizons may move [m]."""
        # Known errors move the field by about as much; twice that is on the safe side.
        largest = float(np.abs(self.field.values).max(initial=0.0))
        return FAR * float(self.field.covariance.sd) + 2.0 * largest

    def apply(self, change: Change) -> None:
        """Move the horizons by one realisation of the error."""
        # One field for all horizons; each reads it at its own points.
        error = change.draws.field(self.parameter, self.field).ravel()
        for k, name in enumerate(self.horizons):
            weights = self.weights[k]
            up = error if weights is None else weights @ error
            change.lift(name, up)
            # The number of a field, for tables and tornado diagrams: its mean over the first
            # horizon.
            if k == 0:
                change.numbers[self.parameter] = float(up[self.there].mean())


def _shared_grid(data: list[HorizonData]) -> FieldGrid | None:
    """The nodes of all horizons, if these are the same and in equal steps."""
    # Points and meshes have no lattice.
    first = data[0].surface
    if first is None or first.lattice is None:
        return None
    for other in data[1:]:
        # The same nodes to the last bit: anything else is interpolated.
        if not np.array_equal(other.points[:, :2], data[0].points[:, :2]):
            return None
    return FieldGrid.of_lattice(first.lattice)


def _finite(places: np.ndarray, grid: FieldGrid) -> np.ndarray:
    """Places, the corner of the grid in place of those that do not exist."""
    # An absent node gets any place: its result is not used.
    found: np.ndarray = np.where(np.isfinite(places).all(axis=1)[:, None], places, grid.corner)
    return found


def _rows(corners: np.ndarray, shares: np.ndarray, n: int, weights: Any) -> Any:
    """Weights of the field's nodes in the elevation at each pick."""
    from scipy.sparse import csr_matrix

    # Three corners per pick.
    indptr = np.arange(len(corners) + 1) * 3
    rows = csr_matrix((shares.ravel(), corners.ravel(), indptr), shape=(len(corners), n))
    # Through the lattice of the field where it is another one.
    return rows if weights is None else (rows @ weights).tocsr()
