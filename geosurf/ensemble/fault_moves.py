"""Uncertain faults: moved across their strike, or turned about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.ensemble.change import Change, Given, names_among
from geosurf.ensemble.depths import of_names
from geosurf.errors import InputError
from geosurf.model import Lattice, TriSurface
from geosurf.model.distributions import Distribution, distribution_of, reach_of


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
