"""Select the triangles of one surface inside the model, with the units on both sides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.conventions import did_you_mean, is_word
from geosurf.errors import GeometryError, InputError
from geosurf.model import Patches, Unit, Units
from geosurf.model.expected import expect

PLUS, MINUS = 0, 1
SIDES = {"+": PLUS, "-": MINUS, "hanging wall": PLUS, "footwall": MINUS}


@dataclass(frozen=True, eq=False)
class Faces:
    """Triangles of one surface that lie inside the model.

    Attributes
    ----------
    name : str
    x : ndarray of float64, shape (n_vertex, 3)
        Vertices of the patches, local [m].
    origin : ndarray of float64, shape (3,)
    triangles : ndarray of int64, shape (n, 3)
        Rows of `x`.
    sides : ndarray of int64, shape (n, 2)
        Unit in front and behind, counted as in `listed`.
    listed : list of Unit
    """

    name: str
    x: np.ndarray
    origin: np.ndarray
    triangles: np.ndarray
    sides: np.ndarray
    listed: list[Unit]

    @cached_property
    def vectors(self) -> np.ndarray:
        """Area times unit normal of each triangle, float64 (n, 3) [m2]."""
        # half the cross product is area times normal: one array gives areas, dips and means
        a, b, c = (self.x[self.triangles[:, k]] for k in range(3))
        half: np.ndarray = 0.5 * np.cross(b - a, c - a)
        return half

    @cached_property
    def areas(self) -> np.ndarray:
        """Area of each triangle, float64 (n,) [m2]."""
        size: np.ndarray = np.linalg.norm(self.vectors, axis=1)
        return size

    @cached_property
    def mean(self) -> np.ndarray:
        """Unit vector along the sum of `vectors`."""
        # rounded once (fsum): the mean is the same whatever the order of triangles
        total = np.array([math.fsum(column) for column in self.vectors.T.tolist()])
        size = np.linalg.norm(total)
        if size == 0:
            raise GeometryError(
                f"surface {self.name!r} has no mean normal inside the model: it is closed, or "
                "the normals of its triangles cancel. Measure its parts separately.",
                surfaces=(self.name,),
            )
        unit: np.ndarray = total / size
        return unit

    @cached_property
    def strike(self) -> np.ndarray:
        """Horizontal unit vectors along the mean strike and the mean dip, float64 (2, 2).

        Right-hand rule: the dip direction is to the right of the strike.
        """
        east, north = self.mean[:2].tolist()
        size = math.hypot(east, north)
        if size < 1e-9:  # decides no topology: below this, the direction is rounding
            raise GeometryError(
                f"fault {self.name!r} is horizontal on average, so it has no strike. Use a "
                "fault that dips.",
                surfaces=(self.name,),
            )

        # the horizontal part of the normal of the hanging wall points down dip
        down = np.array([east, north]) / size
        return np.array([[-down[1], down[0]], down])

    def along(self, points: np.ndarray) -> np.ndarray:
        """Distance of local points (n, 3) along the mean strike, from the fault's end [m]."""
        # the first vertex along the strike is 0, so that lines of both walls share one axis
        start = (self.x[np.unique(self.triangles), :2] @ self.strike[0]).min()
        found: np.ndarray = points[:, :2] @ self.strike[0] - start
        return found


def faces_of(patches: Patches, units: Units, name: str, role: str | None = None) -> Faces:
    """
    Triangles of one surface that lie inside the model.

    Parameters
    ----------
    patches : Patches
    units : Units
        Carved from these patches.
    name : str
    role : {"horizon", "fault"}, optional
        What the surface has to be; default: either.

    Returns
    -------
    Faces

    Raises
    ------
    InputError
        If no such surface has that name.
    GeometryError
        If it does not reach into the model.
    """
    check_model(patches, units)
    if role is not None and not is_word(role, ("horizon", "fault")):
        raise InputError(f"role is {role!r}, expected 'horizon' or 'fault'.")
    roles = ("horizon", "fault") if role is None else (role,)
    known = [source.name for source in patches.sources if source.role in roles]
    if not is_word(name, known):
        raise InputError(
            f"no {' or '.join(roles)} has the name {name!r}. Names are "
            f"{known}.{did_you_mean(str(name), known)}"
        )

    # a triangle with no unit on either side lies outside the walls, or was cut off with them
    mine = patches.surface_of_triangle == row_of(patches, name, *roles)
    rows = np.flatnonzero(mine & (units.sides >= 0).any(axis=1))
    if len(rows) == 0:
        raise GeometryError(
            f"surface {name!r} lies outside the model. Enlarge the box, or skip this surface.",
            surfaces=(name,),
        )
    return Faces(
        name, patches.local, patches.origin, patches.triangles[rows], units.sides[rows],
        list(units.values()),
    )  # fmt: skip


def check_model(patches: object, units: object) -> None:
    """Refuse what is not a model: patches, and the units that were carved from them."""
    expect(patches, Patches, "measures take Patches", "pass the result of rebuild_surfaces")
    expect(units, Units, "measures take Units", "pass the result of carve_units")


def row_of(patches: Patches, name: str, *roles: str) -> int:
    """Row of the surface that has a name and one of some roles; a wall may be called Top, too."""
    return next(i for i, s in enumerate(patches.sources) if s.name == name and (s.role in roles))


def side_of_words(side: str) -> int:
    """0 for the side into which the fault's normal points, 1 for the other.

    Examples
    --------
    >>> side_of_words("+"), side_of_words("footwall")
    (0, 1)
    """
    if not is_word(side, SIDES):
        raise InputError(f"side is {side!r}, expected one of {tuple(SIDES)}.")
    return SIDES[side]
