"""Uncertain faults of a scene: throw, position and dip."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geosurf.conventions import is_number
from geosurf.ensemble.change import Change, Given, names_among
from geosurf.ensemble.uncertain import of_names
from geosurf.errors import InputError
from geosurf.model import Lattice, TriSurface
from geosurf.model.distributions import Distribution, distribution_of, reach_of
from geosurf.sheets import EllipticThrow

# ---- throws ----------------------------------------
# Uncertain throw of faults, for horizons that are continuous before they are torn.


@dataclass(frozen=True)
class Throw:
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

    def __post_init__(self) -> None:
        if self.throw is None and self.factor is None:
            raise InputError(f"{self.parameter}: give throw= [m], or factor=.")

    @property
    def unit(self) -> str:
        """Unit of the parameter."""
        return "m" if self.factor is None else "1"

    @property
    def parameter(self) -> str:
        """Name of the parameter."""
        return self.name or of_names("throw", self.fault)

    def prepare(self, given: Given) -> PreparedThrow:
        """Check names and distribution."""
        names_among(self.fault, given.fault_names, "fault")
        name = self.parameter
        # A factor multiplies a form that is given here, or the one of the scenario.
        if self.factor is not None:
            by = distribution_of(self.factor, f"{name}: factor")
            return PreparedThrow(name, self.fault, by, self.throw, True)
        if _is_shape(self.throw):  # certain: its number is 1
            return PreparedThrow(name, self.fault, distribution_of(1.0, name), self.throw, True)
        return PreparedThrow(name, self.fault, distribution_of(self.throw, name))


@dataclass(frozen=True)
class Factor:
    """A throw in any form, or the one of a scenario (None), to be multiplied."""

    by: float
    shape: Any = None

    def of(self, shape: Any) -> Any:
        """Return the throw: its own form, or else the one that is given."""
        return times(shape if self.shape is None else self.shape, self.by)


@dataclass(frozen=True, eq=False)
class PreparedThrow:
    """A `Throw` of a given model."""

    parameter: str
    fault: str
    by: Distribution
    shape: Any = None
    is_factor: bool = False

    def reach(self) -> float:
        """Return how far horizons may move from the base case [m]."""
        # Throw moves horizons relative to the base case, which has the median.
        middle = self.by.quantile(0.5)
        spread = reach_of(_Off(self.by, middle))
        return spread if self.shape is None else spread * largest_throw(self.shape)

    def apply(self, change: Change) -> None:
        """Set the throw."""
        by = change.numbers[self.parameter] = change.draws.number(self.parameter, self.by)
        change.throws[self.fault] = Factor(by, self.shape) if self.is_factor else by


@dataclass(frozen=True)
class _Off:
    """A distribution, counted from a value."""

    of: Distribution
    value: float

    def quantile(self, probability: float) -> float:
        """Return the value that is not exceeded with a probability between 0 and 1."""
        return self.of.quantile(probability) - self.value


def _is_shape(throw: Any) -> bool:
    """Whether a throw is a profile, a map, a function or an ellipse: no number."""
    # Forms of `throw_horizon` other than a number.
    if isinstance(throw, EllipticThrow | np.ndarray | list | tuple) or hasattr(throw, "dims"):
        return True
    # Distributions can be called for quantiles; plain functions are throws.
    return callable(throw) and not hasattr(throw, "quantile") and not hasattr(throw, "ppf")


def times(throw: Any, factor: float) -> Any:
    """Return a throw of any form, multiplied by a factor.

    Examples
    --------
    >>> times(EllipticThrow(40.0), 0.5).largest, times([[0.0, 10.0], [900.0, 30.0]], 2.0).tolist()
    (20.0, [[0.0, 20.0], [900.0, 60.0]])
    """
    if isinstance(throw, EllipticThrow):
        return replace(throw, largest=throw.largest * factor)
    if is_number(throw):
        return float(throw) * factor
    # An array keeps its coordinates.
    if hasattr(throw, "dims"):
        return throw * factor
    if callable(throw):
        return _Times(throw, factor)
    # Pairs of distance and throw: only the second column is multiplied.
    return np.asarray(throw, dtype=np.float64) * np.array([1.0, factor])


@dataclass(frozen=True)
class _Times:
    """A function of the distance along strike, multiplied; other processes can be sent it."""

    throw: Callable[[Any], Any]
    factor: float

    def __call__(self, along: Any) -> Any:
        return self.factor * self.throw(along)


def largest_throw(throw: Any) -> float:
    """Return the largest throw of any form [m]; 0 for a function, whose values are not known.

    Examples
    --------
    >>> largest_throw([[0.0, 10.0], [900.0, -30.0]])
    30.0
    """
    if isinstance(throw, EllipticThrow):
        return abs(float(throw.largest))
    if is_number(throw):
        return abs(float(throw))
    # Its values are not known ahead.
    if callable(throw) and not hasattr(throw, "dims"):
        return 0.0
    values = throw.values if hasattr(throw, "dims") else np.asarray(throw, dtype=np.float64)[:, 1]
    return float(np.nanmax(np.abs(values)))


# ---- fault moves ----------------------------------------
# Uncertain faults: moved across their strike, or turned about it.


@dataclass(frozen=True)
class FaultShift:
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

    unit = "m"

    @property
    def parameter(self) -> str:
        """Name of the parameter."""
        return self.name or of_names("position", self.faults)

    def prepare(self, given: Given) -> PreparedMove:
        """Check names and distribution."""
        names = names_among(self.faults, given.fault_names, "fault")
        by = distribution_of(self.by, self.parameter)
        return PreparedMove(self.parameter, names, by, turns=False)


@dataclass(frozen=True)
class FaultDip:
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

    unit = "degree"

    @property
    def parameter(self) -> str:
        """Name of the parameter."""
        return self.name or of_names("dip", self.faults)

    def prepare(self, given: Given) -> PreparedMove:
        """Check names and distribution."""
        names = names_among(self.faults, given.fault_names, "fault")
        by = distribution_of(self.by, self.parameter)
        # A fault turned past the vertical would swap its walls.
        if reach_of(by) >= 90.0:
            raise InputError(f"{self.parameter}: a dip cannot change by 90 degrees or more.")
        return PreparedMove(self.parameter, names, by, turns=True)


@dataclass(frozen=True)
class PreparedMove:
    """A `FaultShift` or `FaultDip` of a given model."""

    parameter: str
    faults: tuple[str, ...]
    by: Distribution
    turns: bool

    def reach(self) -> float:
        """Return how far horizons may move [m]."""
        # Horizons are cut elsewhere, but none of their data move.
        return 0.0

    def apply(self, change: Change) -> None:
        """Move the faults."""
        by = change.numbers[self.parameter] = change.draws.number(self.parameter, self.by)
        for name in self.faults:
            # Each fault about its own strike, as it has been moved so far.
            fault = change.fault(name)
            change.faults[name] = turned(fault, by) if self.turns else shifted(fault, by)


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
    made.crs = fault.crs
    return made
