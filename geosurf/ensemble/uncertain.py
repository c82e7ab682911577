"""Uncertain depths of horizons and fluid contacts; every uncertainty in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
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
from geosurf.errors import InputError
from geosurf.measure.velocity import DATUM, ELSEWHERE, is_by_name
from geosurf.model import Lattice, TriSurface
from geosurf.model.base import in_crs_of
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
from geosurf.model.tears import FaultThrow
from geosurf.model.tops import tops_of
from geosurf.report.page import number
from geosurf.sheets import EllipticThrow
from geosurf.warning import warn_of

# ---- described ----------------------------------------
# What is uncertain, in words with units: for the store and the report of an ensemble.


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
        made: Any = distribution_of(given, "distribution")
    except InputError:  # a profile, a map or an ellipse: a throw that is certain
        return f"certain: {type(given).__name__}"
    if isinstance(made, Constant):
        return f"certain: {_number(made.value)}{after}"
    if isinstance(made, Normal):
        ends = (("at least", made.low), ("at most", made.high))
        limits = "".join(f", {w} {_number(v)}{after}" for w, v in ends if v is not None)
        middle = f"mean {_number(made.mean)}{after}"
        return f"normal: {middle}, standard deviation {_number(made.sd)}{after}{limits}"
    if isinstance(made, Uniform):
        return f"uniform: {_number(made.low)} to {_number(made.high)}{after}"
    if isinstance(made, Triangular):
        ends_of = f"{_number(made.low)} to {_number(made.high)}{after}"
        return f"triangular: {ends_of}, most likely {_number(made.mode)}{after}"
    if isinstance(made, Discrete):
        weights = tuple(made.weights or ())
        same = len(set(weights)) == 1
        return f"one of {_listed(made.values, after)}" + (
            "" if same else f"; weights {_listed(weights, '')}"
        )
    return f"{_name(made)}: median {_number(made.quantile(0.5))}{after}"


def _name(made: Any) -> str:
    """What a distribution of the user's, or of scipy, is called."""
    if isinstance(made, OfScipy):
        return f"scipy.stats.{getattr(getattr(made.made, 'dist', None), 'name', 'distribution')}"
    return type(made).__name__


def _listed(values: Any, after: str) -> str:
    """The first values with their unit, and how many more there are."""
    shown = ", ".join(map(_number, values[:MOST_VALUES]))
    more = len(values) - MOST_VALUES
    return f"{shown}{after}" + (f" and {more} more" if more > 0 else "")


def _number(value: float) -> str:
    """A number as tables show it, with as many decimals as it needs, at most six."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return number(value, len(text.partition(".")[2]))


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
        found = distribution_of(self.elevation if absolute else self.shift, self.parameter)
        return PreparedNumber(self.parameter, found, self._move)

    def _move(self, change: Change, level: float) -> None:
        """Move the contact."""
        # As other uncertainties have left it, else as given.
        value = change.contacts.get(self.contact, change.given.contacts[self.contact])

        def at(old: Any) -> Any:
            """The new place of one contact: a number, or a surface."""
            if self.elevation is not None:
                return level
            # A level contact is a number, a gridded one moves node by node.
            if is_number(old):
                return float(old) + level
            data = HorizonData.of(self.contact, old)
            return data.moved(np.full(len(data.points), level))

        change.contacts[self.contact] = each_level(value, at)


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
        known = tuple(given.velocity) if is_by_name(given.velocity) else (ELSEWHERE,)
        known = tuple(name for name in known if name != DATUM)
        names = names_among(self.names, known, "entry of velocity")
        by = distribution_of(self.by, self.parameter)
        # As a place at the floor of the model moves.
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
    return np.where(np.isfinite(places).all(axis=1)[:, None], places, grid.corner)


def _rows(corners: np.ndarray, shares: np.ndarray, n: int, weights: Any) -> Any:
    """Weights of the field's nodes in the elevation at each pick."""
    # Three corners per pick.
    indptr = np.arange(len(corners) + 1) * 3
    rows = csr_matrix((shares.ravel(), corners.ravel(), indptr), shape=(len(corners), n))
    # Through the lattice of the field where it is another one.
    return rows if weights is None else (rows @ weights).tocsr()


# ---- faults ----------------------------------------
# Uncertain faults of a scene: throw, position and dip.


# ---- throws ----------------------------------------
# Uncertain throw of faults, for horizons that are continuous before they are torn.


@dataclass(frozen=True)
class Throw(Named):
    """
    The throw of a fault, for horizons that are still continuous; see `throw_horizon`.

    Parameters
    ----------
    fault : str
    throw : distribution, float, or what `throw_horizon` takes, optional
        [m], negative for a reverse fault. Left out: as the scenario has it.
    factor : distribution or float, optional
        By which a throw that is a profile, a map or an ellipse is multiplied.
    name : str, optional
        Of the parameter in all results; default ``"throw F1"``.

    Raises
    ------
    InputError
        If neither `throw` nor `factor` is given.

    Notes
    -----
    List the youngest fault first. Each throw acts on all horizons of the scene.

    Examples
    --------
    >>> Throw("F1", 30.0).parameter
    'throw F1'
    """

    fault: str
    throw: Any = None
    factor: Any = None
    name: str = ""

    what = "throw"

    def __post_init__(self) -> None:
        if self.throw is None and self.factor is None:
            raise InputError(f"{self.parameter}: give throw= [m], or factor=.")

    @property
    def unit(self) -> str:
        """Unit of the parameter."""
        return "m" if self.factor is None else "1"

    def prepare(self, given: Given) -> PreparedNumber:
        """Check names and distribution."""
        names_among(self.fault, given.fault_names, "fault")
        name = self.parameter
        # A factor multiplies a form that is given here, or the one of the scenario.
        if self.factor is not None:
            by = distribution_of(self.factor, f"{name}: factor")
        else:  # a shape is certain: its number is 1
            by = distribution_of(1.0 if _is_shape(self.throw) else self.throw, name)
        # Throw moves horizons relative to the base case, which has the median.
        middle = by.quantile(0.5)
        reach = max(abs(by.quantile(p) - middle) for p in (TAIL, 1.0 - TAIL))
        if self._multiplies and self.throw is not None:
            ends = given.fault(self.fault).extent
            reach *= FaultThrow(self.fault, self.throw).largest(math.dist(*ends))
        return PreparedNumber(name, by, self._set, reach)

    @property
    def _multiplies(self) -> bool:
        """Whether the number is a factor of a throw in another form."""
        return self.factor is not None or _is_shape(self.throw)

    def _set(self, change: Change, by: float) -> None:
        """Set the throw."""
        change.throws[self.fault] = (self.throw, by) if self._multiplies else (by, 1.0)


def _is_shape(throw: Any) -> bool:
    """Whether a throw is a profile, a map, a function or an ellipse: no number."""
    # Forms of `throw_horizon` other than a number.
    if isinstance(throw, EllipticThrow | np.ndarray | list | tuple) or hasattr(throw, "dims"):
        return True
    # Distributions can be called for quantiles; plain functions are throws.
    return callable(throw) and not hasattr(throw, "quantile") and not hasattr(throw, "ppf")


# ---- fault moves ----------------------------------------
# Uncertain faults: moved across their strike, or turned about it.


@dataclass(frozen=True)
class FaultShift(Named):
    """
    Faults that move across their mean strike.

    Parameters
    ----------
    faults : str or sequence of str
        Each moves by the same length, across its own strike. Empty: all.
    by : distribution or float
        Horizontal distance [m], positive towards the hanging wall.
    name : str, optional
        Of the parameter in all results; default ``"position F1"``.

    Examples
    --------
    >>> FaultShift("F1", 25.0).parameter
    'position F1'
    """

    faults: str | Sequence[str]
    by: Any
    name: str = ""

    what = "position"
    unit = "m"

    def prepare(self, given: Given) -> PreparedNumber:
        """Check names and distribution."""
        names = names_among(self.faults, given.fault_names, "fault")
        by = distribution_of(self.by, self.parameter)
        # Horizons are cut elsewhere, but none of their data move.
        return PreparedNumber(self.parameter, by, partial(_move_faults, shifted, names))


@dataclass(frozen=True)
class FaultDip(Named):
    """
    Faults that turn about their mean strike, through their middle.

    Parameters
    ----------
    faults : str or sequence of str
        Each turns by the same angle, about its own strike. Empty: all.
    by : distribution or float
        Change of dip [degrees], positive steeper.
    name : str, optional
        Of the parameter in all results; default ``"dip F1"``.

    Examples
    --------
    >>> FaultDip("F1", -5.0).parameter
    'dip F1'
    """

    faults: str | Sequence[str]
    by: Any
    name: str = ""

    what = "dip"
    unit = "degree"

    def prepare(self, given: Given) -> PreparedNumber:
        """Check names and distribution."""
        names = names_among(self.faults, given.fault_names, "fault")
        by = distribution_of(self.by, self.parameter)
        # A fault turned past the vertical would swap its walls.
        if reach_of(by) >= 90.0:
            raise InputError(f"{self.parameter}: a dip cannot change by 90 degrees or more.")
        return PreparedNumber(self.parameter, by, partial(_move_faults, turned, names))


def _move_faults(
    moved: Callable[[TriSurface, float], TriSurface],
    names: Sequence[str],
    change: Change,
    by: float,
) -> None:
    """Move faults, each about its own strike, as it has been moved so far."""
    for name in names:
        change.faults[name] = moved(change.fault(name), by)


def shifted(fault: TriSurface, by: float) -> TriSurface:
    """Return a fault, moved across its mean strike [m].

    Examples
    --------
    >>> from geosurf.synthetic import tilted_planes
    >>> from geosurf.triangulate import triangulate_fault
    >>> fault = triangulate_fault(tilted_planes(n=5).faults["F1"], name="F1")
    >>> away = shifted(fault, 10.0).vertices - fault.vertices
    >>> np.hypot(*away[:, :2].T).round(9).tolist()[:2], float(np.ptp(away[:, 2]))
    ([10.0, 10.0], 0.0)
    """
    across, _ = _across_and_middle(fault)
    return _mapped(fault, lambda x: x + by * np.array([*across, 0.0]))


def turned(fault: TriSurface, by: float) -> TriSurface:
    """Return a fault, made steeper by an angle [degrees] about its mean strike."""
    across, middle = _across_and_middle(fault)
    # Positive angles are steeper: the normal turns towards the horizontal.
    cosine, sine = np.cos(np.radians(by)), np.sin(np.radians(by))
    away = np.array([*across, 0.0])

    def turn(x: np.ndarray) -> np.ndarray:
        """Points, turned in the plane of `across` and the vertical."""
        # Across strike and up from the middle: strike itself does not change.
        flat, high = (x - middle) @ away, x[..., 2] - middle[2]
        step = (cosine - 1.0) * flat + sine * high
        made: np.ndarray = x + step[..., None] * away
        made[..., 2] = middle[2] - sine * flat + cosine * high
        return made

    return _mapped(fault, turn)


def _across_and_middle(fault: TriSurface) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal direction into the hanging wall (2,), and the middle of the area (3,)."""
    # The mean normal, weighted by area, is the dip direction of the fault as a whole.
    corners = fault.vertices[fault.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)
    total = normals.sum(axis=0)
    length = float(np.hypot(total[0], total[1]))
    # A horizontal fault has no strike to turn about.
    if not length > 1e-9 * float(np.linalg.norm(total)):
        raise InputError(
            f"fault {fault.name!r} is horizontal on average and has no strike, so that it cannot "
            "be moved or turned. Leave it out of the uncertainties."
        )
    middle = (corners.mean(axis=1) * area[:, None]).sum(axis=0) / area.sum()
    return total[:2] / length, middle


def _mapped(fault: TriSurface, way: Any) -> TriSurface:
    """A fault with all its points moved; one from a grid stays one."""
    # A fault from a grid stays a grid.
    lattice = fault.lattice
    if lattice is None:
        made = TriSurface(fault.name, "fault", way(fault.vertices), fault.triangles)
    else:
        # Rotated nodes have two-dimensional coordinates, whatever the grid had before.
        nodes = np.stack([*lattice.horizontal(), lattice.elevation], axis=-1)
        x, y, z = np.moveaxis(way(nodes), -1, 0)
        grid = Lattice(x, y, z, lattice.rising, lattice.reverse)
        made = TriSurface(fault.name, "fault", lattice=grid)
    return in_crs_of(made, [fault])
