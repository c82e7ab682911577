"""Uncertain fluid contacts, velocities and depths of horizons; every uncertainty in words.

Each class is what a user gives: names, and a distribution. Its `prepare` compares the names with
the model and returns what moves the model in each realisation. `uncertain_faults` has the faults.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from geosurf.conventions import counted, is_number
from geosurf.ensemble.change import (
    Change,
    Given,
    HorizonData,
    Named,
    PreparedNumber,
    Uncertainty,
    names_among,
)
from geosurf.ensemble.fields import Covariance, FieldGrid, GaussianField
from geosurf.errors import InputError, warn_of
from geosurf.measure.velocity import DATUM, ELSEWHERE, is_by_name
from geosurf.model.column import each_level, levels_of
from geosurf.model.distributions import (
    TAIL,
    Constant,
    Discrete,
    Normal,
    OfScipy,
    Triangular,
    Uniform,
    distribution_of,
    reach_of,
)
from geosurf.model.tops import Tops, doubtful_top, tops_of
from geosurf.report.page import number

# ---- contact levels ----------------------------------------
# Uncertain fluid contacts: their elevation, or a shift of it.


@dataclass(frozen=True)
class ContactLevel(Named):
    """
    A fluid contact at an uncertain elevation.

    Parameters
    ----------
    contact : str
        Its name in ``Scene(contacts=)``.
    elevation : distribution or float, optional
        [m], positive up, in place of the given one. For a contact that is the same in all blocks.
    shift : distribution or float, optional
        [m], positive up, added to the given elevation, or to a gridded contact, in all blocks.
    name : str, optional
        Of the parameter in all results; default ``"contact OWC"``.

    Raises
    ------
    InputError
        If not exactly one of `elevation` and `shift` is given.

    Examples
    --------
    >>> ContactLevel("OWC", shift=-3.0).parameter
    'contact OWC'
    """

    contact: str
    elevation: Any = None
    shift: Any = None
    name: str = ""

    what = "contact"
    unit = "m"

    def __post_init__(self) -> None:
        # Both would contradict each other, neither would change nothing.
        if (self.elevation is None) == (self.shift is None):
            raise InputError(f"{self.parameter}: give either elevation= or shift=.")

    def prepare(self, given: Given) -> PreparedNumber:
        """Check names and distribution."""
        names_among(self.contact, tuple(given.contacts), "fluid contact")
        value = given.contacts[self.contact]
        # One elevation can replace only one: contacts of several blocks differ.
        absolute = self.elevation is not None
        if absolute and len(levels_of(value)) > 1:
            raise InputError(
                f"{self.parameter}: the contact is given for several blocks or zones. Give shift= "
                "in place of elevation=."
            )
        level = distribution_of(self.elevation if absolute else self.shift, self.parameter)
        return PreparedNumber(self.parameter, level, self._move)

    def _move(self, change: Change, level: float) -> None:
        """Move the contact."""
        # As other uncertainties have left it, else as given.
        value = change.contacts.get(self.contact, change.given.contacts[self.contact])

        def moved(old: Any) -> Any:
            """The new place of one contact: a number, or a surface."""
            if self.elevation is not None:
                return level
            # A level contact is a number, a gridded one moves node by node.
            if is_number(old):
                return float(old) + level
            data = HorizonData.of(self.contact, old)
            return data.moved(np.full(len(data.points), level))

        change.contacts[self.contact] = each_level(value, moved)


# ---- velocities ----------------------------------------
# Uncertain velocities of a model that was given in time.


@dataclass(frozen=True)
class VelocityFactor(Named):
    """
    Velocities that are all multiplied by the same number.

    Parameters
    ----------
    names : str or sequence of str
        As in ``Scene(velocity=)``: zones, horizons with an average velocity, ``"elsewhere"``.
        Empty: all.
    by : distribution or float
        Such as ``Normal(1.0, 0.03)``.
    name : str, optional
        Of the parameter in all results; default ``"velocity Top/Base"``.

    Examples
    --------
    >>> VelocityFactor("Top/Base", 1.02).parameter
    'velocity Top/Base'
    """

    names: str | Sequence[str]
    by: Any
    name: str = ""

    what = "velocity"
    unit = "1"

    def prepare(self, given: Given) -> PreparedNumber:
        """Check names and distribution."""
        if given.velocity is None:
            raise InputError(f"{self.parameter}: the model was not given in time, with velocities.")
        entries = tuple(given.velocity) if is_by_name(given.velocity) else (ELSEWHERE,)
        known = tuple(name for name in entries if name != DATUM)
        names = names_among(self.names, known, "entry of velocity")
        by = distribution_of(self.by, self.parameter)
        # Nothing moves farther than a place at the floor of the model.
        reach = given.deepest * max(abs(by.quantile(p) - 1.0) for p in (TAIL, 1.0 - TAIL))
        return PreparedNumber(self.parameter, by, partial(_multiply, names), reach)


def _multiply(names: Sequence[str], change: Change, factor: float) -> None:
    """Multiply velocities."""
    for name in names:
        change.velocity[name] = change.velocity.get(name, 1.0) * factor


# ---- depths ----------------------------------------
# Uncertain horizons: shifted as a whole, or by an error that is correlated in the map.


TOPS = "tops"
FAR = 6.0  # standard deviations: no field of a few million nodes leaves them


@dataclass(frozen=True)
class DepthShift(Named):
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

    what = "depth shift"
    unit = "m"

    def prepare(self, given: Given) -> PreparedNumber:
        """Check names and distribution."""
        # Names are checked once, not in every realisation.
        names = names_among(self.horizons, given.horizon_names, "horizon")
        by = distribution_of(self.by, self.parameter)
        return PreparedNumber(self.parameter, by, partial(_lift, names), reach_of(by))


def _lift(names: Sequence[str], change: Change, length: float) -> None:
    """Move horizons, all by the same length."""
    for name in names:
        change.lift(name, length)


@dataclass(frozen=True)
class DepthError(Named):
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

    what = "depth error"
    unit = "m"

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
            there = np.concatenate([horizon.points[horizon.there, :2] for horizon in data])
            grid = FieldGrid.around(there, covariance.cell)
            weights = [grid.weights_at(_finite(horizon.points[:, :2], grid)) for horizon in data]
        places, errors, weights_of_picks = self._known_errors(given, names, data, weights)
        field = GaussianField(grid, covariance, weights_of_picks, errors, places)
        return PreparedError(self.parameter, names, weights, field, data[0].there)

    def _known_errors(
        self, given: Given, names: tuple[str, ...], data: list[HorizonData], weights: list[Any]
    ) -> tuple[np.ndarray | None, np.ndarray | None, Any]:
        """Places of picks in the map, the error there, and the weights of the field's nodes in it.

        All are None without picks.
        """
        points = self._points_of_picks(given, names)
        if points is None or not len(points):
            return None, None, None
        # One field cannot meet different misfits at the wells of each horizon.
        if len(names) > 1:
            raise InputError(
                f"{self.parameter}: one error of several horizons cannot meet the well tops of "
                "each. Give one for each horizon, or leave tops out: picks=None, or in a scenario "
                "meet_tops = false."
            )
        horizon = data[0]
        corners, shares = horizon.shares_at(points[:, :2])
        # Outside of a horizon there is no elevation to compare with.
        inside = np.isfinite(shares).all(axis=1)
        if not inside.all():
            self._warn_of_outside(names[0], int((~inside).sum()), len(points))
        points, corners, shares = points[inside], corners[inside], shares[inside]
        # What the field has to be there: the pick minus the horizon of the base case.
        base = (horizon.points[corners, 2] * shares).sum(axis=1)
        errors = points[:, 2] - base
        picks = Tops(("of a pick",) * len(points), (names[0],) * len(points), points)
        if (doubt := doubtful_top(picks, np.arange(len(points)), base)) is not None:
            raise InputError(f"{self.parameter}: {doubt}")
        of_picks = _weights_at_picks(corners, shares, len(horizon.points), weights[0])
        return points[:, :2], errors, of_picks

    def _points_of_picks(self, given: Given, names: tuple[str, ...]) -> np.ndarray | None:
        """Points that the horizons pass through (n, 3); None without."""
        if self.picks is None:
            return None
        if isinstance(self.picks, str):
            if self.picks != TOPS:
                raise InputError(
                    f'{self.parameter}: picks is {self.picks!r}; give "tops" for the well tops '
                    "of the scene, an array (n, 3), or None."
                )
            # Without well tops in the scene the error is unconditioned.
            return None if given.tops is None else _points_of_tops(given.tops, names)
        if hasattr(self.picks, "keys"):
            return _points_of_tops(tops_of(self.picks), names)
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
        warn_of("picks", horizon, effect, remedy)


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

    @property
    def reach(self) -> float:
        """How far horizons may move [m]."""
        # Known errors move the field by about as much; twice that is on the safe side.
        largest = float(np.abs(self.field.values).max(initial=0.0))
        return FAR * float(self.field.covariance.sd) + 2.0 * largest

    def apply(self, change: Change) -> None:
        """Move the horizons by one realisation of the error."""
        # One field for all horizons; each reads it at its own points.
        error = change.draws.field(self.parameter, self.field).ravel()
        lifts = [error if weights is None else weights @ error for weights in self.weights]
        for name, lift in zip(self.horizons, lifts, strict=True):
            change.lift(name, lift)
        # The number of a field, for tables and tornado diagrams: its mean over the first horizon.
        change.numbers[self.parameter] = float(lifts[0][self.there].mean())


def _points_of_tops(tops: Tops, names: Sequence[str]) -> np.ndarray:
    """Points (n, 3) of the tops of some horizons."""
    return tops.points[[row for name in names for row in tops.of(name).tolist()]]


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
    """Places of nodes; those of absent nodes, whose results are not used, are on the grid, too."""
    return np.where(np.isfinite(places).all(axis=1)[:, None], places, grid.corner)


def _weights_at_picks(
    corners: np.ndarray, shares: np.ndarray, n_point: int, weights: Any
) -> csr_matrix:
    """Weights of the field's nodes at each pick, from those at the points of the horizon.

    Each pick lies between three of these points; `weights` is None if they are the field's nodes.
    """
    start = np.arange(len(corners) + 1) * 3
    of_points = csr_matrix((shares.ravel(), corners.ravel(), start), shape=(len(corners), n_point))
    return of_points if weights is None else (of_points @ weights).tocsr()


# ---- in words ----------------------------------------
# Distributions with their units, for the store and the report of an ensemble.


# Where uncertainties keep their distribution. A factor comes before the shape that it multiplies.
PLACES = ("by", "factor", "throw", "elevation", "shift")
MOST_VALUES = 5  # of a discrete distribution


def words_of_uncertainty(uncertain: Uncertainty) -> str:
    """
    Return the distribution of an uncertainty, with units.

    Parameters
    ----------
    uncertain : Uncertainty

    Returns
    -------
    str

    Examples
    --------
    >>> from geosurf.ensemble import Throw
    >>> words_of_uncertainty(Throw("F1", Normal(60.0, 10.0, low=0.0)))
    'normal: mean 60 m, standard deviation 10 m, at least 0 m'
    >>> words_of_uncertainty(DepthError("Top", sd=8.0, range=900.0))
    'correlated field (gaussian): mean 0 m, standard deviation 8 m, range 900 m'
    """
    if isinstance(uncertain, DepthError):
        return (
            f"correlated field ({uncertain.model}): mean 0 m, standard deviation "
            f"{_number(uncertain.sd)} m, range {_number(uncertain.range)} m"
        )
    for place in PLACES:
        given = getattr(uncertain, place, None)
        if given is not None:
            return words_of_distribution(given, uncertain.unit)
    return "drawn by a function"


def words_of_distribution(given: Any, unit: str) -> str:
    """
    Return a distribution with the unit of its values.

    Parameters
    ----------
    given : distribution, float or shape
        Whatever an uncertainty takes.
    unit : str
        ``"1"``: none.

    Returns
    -------
    str

    Examples
    --------
    >>> words_of_distribution(Uniform(0.5, 5.0), "m")
    'uniform: 0.5 to 5 m'
    >>> words_of_distribution(Discrete([1.0, 2.0], [1, 3]), "1")
    'one of 1, 2; weights 1, 3'
    """
    after = "" if unit == "1" else f" {unit}"
    try:
        drawn: Any = distribution_of(given, "distribution")
    except InputError:  # a profile, a map or an ellipse: a throw that is certain
        return f"certain: {type(given).__name__}"
    if isinstance(drawn, Constant):
        return f"certain: {_number(drawn.value)}{after}"
    if isinstance(drawn, Normal):
        ends = (("at least", drawn.low), ("at most", drawn.high))
        limits = "".join(f", {word} {_number(z)}{after}" for word, z in ends if z is not None)
        middle = f"mean {_number(drawn.mean)}{after}"
        return f"normal: {middle}, standard deviation {_number(drawn.sd)}{after}{limits}"
    if isinstance(drawn, Uniform):
        return f"uniform: {_number(drawn.low)} to {_number(drawn.high)}{after}"
    if isinstance(drawn, Triangular):
        between = f"{_number(drawn.low)} to {_number(drawn.high)}{after}"
        return f"triangular: {between}, most likely {_number(drawn.mode)}{after}"
    if isinstance(drawn, Discrete):
        weights = tuple(drawn.weights or ())
        are_equal = len(set(weights)) == 1
        words_of_weights = "" if are_equal else f"; weights {_first_values(weights, '')}"
        return f"one of {_first_values(drawn.values, after)}{words_of_weights}"
    return f"{_name(drawn)}: median {_number(drawn.quantile(0.5))}{after}"


def _name(distribution: Any) -> str:
    """What a distribution of the user's, or of scipy, is called."""
    if isinstance(distribution, OfScipy):
        kind = getattr(distribution.frozen, "dist", None)
        return f"scipy.stats.{getattr(kind, 'name', 'distribution')}"
    return type(distribution).__name__


def _first_values(values: Any, after: str) -> str:
    """The first values with their unit, and how many more there are."""
    shown = ", ".join(map(_number, values[:MOST_VALUES]))
    more = len(values) - MOST_VALUES
    return f"{shown}{after}" + (f" and {more} more" if more > 0 else "")


def _number(value: float) -> str:
    """A number as tables show it, with as many decimals as it needs, at most six."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return number(value, len(text.partition(".")[2]))
