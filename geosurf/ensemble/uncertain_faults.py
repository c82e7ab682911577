"""Uncertain faults: their throw, their position and their dip."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from geosurf.ensemble.change import Change, Given, Named, PreparedNumber, names_among
from geosurf.errors import InputError
from geosurf.model import Lattice, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.distributions import TAIL, distribution_of, reach_of
from geosurf.model.tears import FaultThrow
from geosurf.sheets import EllipticThrow


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
        # A factor multiplies a form that is given here, or the one of the scenario.
        if self.factor is not None:
            by = distribution_of(self.factor, f"{self.parameter}: factor")
        else:  # a shape is certain: its number is 1
            number = 1.0 if _is_shape(self.throw) else self.throw
            by = distribution_of(number, self.parameter)
        # Throw moves horizons relative to the base case, which has the median.
        middle = by.quantile(0.5)
        reach = max(abs(by.quantile(p) - middle) for p in (TAIL, 1.0 - TAIL))
        if self._multiplies and self.throw is not None:
            ends = given.fault(self.fault).extent
            reach *= FaultThrow(self.fault, self.throw).largest(math.dist(*ends))
        return PreparedNumber(self.parameter, by, self._set, reach)

    @property
    def _multiplies(self) -> bool:
        """Whether the number is a factor of a throw in another form."""
        return self.factor is not None or _is_shape(self.throw)

    def _set(self, change: Change, by: float) -> None:
        """Set the throw."""
        change.throws[self.fault] = (self.throw, by) if self._multiplies else (by, 1.0)


def _is_shape(throw: Any) -> bool:
    """Whether a throw is a profile, a map, a function or an ellipse, as `throw_horizon` takes."""
    if isinstance(throw, EllipticThrow | np.ndarray | list | tuple) or hasattr(throw, "dims"):
        return True
    # Distributions can be called for quantiles; plain functions are throws.
    return callable(throw) and not hasattr(throw, "quantile") and not hasattr(throw, "ppf")


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
    move: Callable[[TriSurface, float], TriSurface], names: Sequence[str], change: Change, by: float
) -> None:
    """Move faults, each from where other uncertainties have left it."""
    for name in names:
        change.faults[name] = move(change.fault(name), by)


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
    return _with_moved_points(fault, lambda x: x + by * np.array([*across, 0.0]))


def turned(fault: TriSurface, by: float) -> TriSurface:
    """Return a fault, made steeper by an angle [degrees] about its mean strike."""
    across, middle = _across_and_middle(fault)
    # Positive angles are steeper: the normal turns towards the horizontal.
    cosine, sine = np.cos(np.radians(by)), np.sin(np.radians(by))
    across_3d = np.array([*across, 0.0])

    def turn(x: np.ndarray) -> np.ndarray:
        """Points, turned in the plane of `across` and the vertical: strike does not change."""
        offset, height = (x - middle) @ across_3d, x[..., 2] - middle[2]
        step = (cosine - 1.0) * offset + sine * height
        points: np.ndarray = x + step[..., None] * across_3d
        points[..., 2] = middle[2] - sine * offset + cosine * height
        return points

    return _with_moved_points(fault, turn)


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


def _with_moved_points(fault: TriSurface, move: Callable[[np.ndarray], np.ndarray]) -> TriSurface:
    """A fault with all its points moved; a fault from a grid stays a grid."""
    lattice = fault.lattice
    if lattice is None:
        moved = TriSurface(fault.name, "fault", move(fault.vertices), fault.triangles)
    else:
        # Rotated nodes have two-dimensional coordinates, whatever the grid had before.
        nodes = np.stack([*lattice.horizontal(), lattice.elevation], axis=-1)
        x, y, z = np.moveaxis(move(nodes), -1, 0)
        grid = Lattice(x, y, z, lattice.rising, lattice.reverse)
        moved = TriSurface(fault.name, "fault", lattice=grid)
    return in_crs_of(moved, [fault])
