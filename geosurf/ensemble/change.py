"""What one realisation changes of a model, gathered from all uncertainties before it is built."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import xarray as xr
from scipy.spatial import Delaunay

from geosurf.conventions import check_word, is_whole
from geosurf.conventions.checks import are_points
from geosurf.ensemble.fields import GaussianField
from geosurf.errors import InputError
from geosurf.kernels.search.columns import cross_columns, shares_at
from geosurf.model import Sheet, TriSurface
from geosurf.model.distributions import Distribution
from geosurf.model.tops import Tops
from geosurf.sheets.lattice.data import points_of
from geosurf.triangulate import triangulate_horizon

# ---- data of a horizon ----------------------------------------
# The data of a horizon as places and elevations that realisations move up and down.


@dataclass(frozen=True, eq=False)
class HorizonData:
    """
    Nodes of a grid, vertices of a mesh, or points.

    Attributes
    ----------
    name : str
    surface : TriSurface or None
        The grid or mesh; None for points.
    points : ndarray of float64, shape (n, 3)
        World coordinates [m]; of a grid all nodes, NaN where one is absent.

    Examples
    --------
    >>> from geosurf.synthetic import tilted_planes
    >>> data = HorizonData.of("Top", tilted_planes(n=5).horizons["Top"])
    >>> data.points.shape, data.moved(np.ones(25)).bounds[4] - data.surface.bounds[4]
    ((25, 3), 1.0)
    """

    name: str
    surface: TriSurface | None
    points: np.ndarray

    @classmethod
    def of(cls, name: str, value: Any, words: dict[str, Any] | None = None) -> HorizonData:
        """Return the data of a horizon as a scene has it; a sheet is refused."""
        words = words or {}
        # A sheet ends on its faults exactly; moved data would no longer.
        if isinstance(value, Sheet):
            raise InputError(
                f"horizon {name!r} is a sheet, torn at its faults already: errors would move it "
                "off them. Give its data with Scene(tear=True), or the horizon before faulting "
                "with Throw(...)."
            )
        # Points have no surface before they are gridded.
        if not isinstance(value, TriSurface) and are_points(value):
            positive, unit = words.get("positive"), words.get("length_unit")
            return cls(name, None, points_of(value, name, positive, unit)[1])
        if not isinstance(value, TriSurface):
            value = triangulate_horizon(value, name=name, **words)
        # A mesh moves vertex by vertex.
        if value.lattice is None:
            return cls(name, value, value.vertices)
        x, y = value.lattice.horizontal()
        columns = [np.ravel(part) for part in (x, y, value.lattice.elevation)]
        return cls(name, value, np.stack(columns, axis=1))

    def moved(self, up: np.ndarray) -> Any:
        """Return the horizon with each node moved up [m], as a scene takes it."""
        # The same kind of object comes back, so that the scene treats it as before.
        if self.surface is None:
            return self._points_at(self.points[:, 2] + up)
        return self.surface.lifted(lambda z: z + up.reshape(z.shape)).renamed(self.name, "horizon")

    def _points_at(self, elevation: np.ndarray) -> Any:
        """The points at other elevations, as `read_points` returns them."""
        # Elevations in metres, whatever the file had: they were converted when it was read.
        metre = {"units": "m"}
        columns = {
            "easting": ("point", self.points[:, 0].copy(), metre),
            "northing": ("point", self.points[:, 1].copy(), metre),
            "elevation": ("point", elevation, metre | {"positive": "up"}),
        }
        return xr.Dataset(columns)

    @cached_property
    def there(self) -> np.ndarray:
        """Rows of the points that exist."""
        return np.flatnonzero(np.isfinite(self.points).all(axis=1))

    def shares_at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return which points determine the elevation at some places in the map, and by which shares.

        Parameters
        ----------
        places : ndarray of float64, shape (n, 2)

        Returns
        -------
        (ndarray of int64 (n, 3), ndarray of float64 (n, 3))
            Corners of the triangle there. Shares are NaN outside of the horizon. Of points, the
            triangle of the Delaunay triangulation.
        """
        # Points have no triangles of their own: those of Delaunay stand for them.
        if self.surface is None:
            at = self.points[self.there, :2]
            # Around their mean: coordinates of millions cost the triangulation its digits.
            corners = self.there[Delaunay(at - at.mean(axis=0)).simplices]
        elif self.surface.lattice is None:
            corners = self.surface.triangles
        else:
            # Triangles refer to vertices; absent nodes have none.
            rows = np.flatnonzero(self.surface.lattice.present.ravel())
            corners = rows[self.surface.triangles]
        crossings = cross_columns(self.points, corners, places)
        rows, shares = np.zeros((len(places), 3), dtype=np.int64), np.full((len(places), 3), np.nan)
        met = rows[crossings.foot] = corners[crossings.triangle]
        shares[crossings.foot] = shares_at(self.points[met], places[crossings.foot])
        return rows, shares


# ---- draws ----------------------------------------
# Where the numbers of a realisation come from: streams of a seed, or medians for the base case.


@dataclass(frozen=True)
class Draws:
    """
    Numbers and fields of one realisation, by the name of their parameter.

    Attributes
    ----------
    seed : int
    realisation : int or None
        None: the base case, in which each number is its median and each field its mean.

    Examples
    --------
    >>> from geosurf.model.distributions import Uniform
    >>> Draws(0, None).number("throw F1", Uniform(0.0, 50.0))
    25.0
    """

    seed: int
    realisation: int | None

    def number(self, parameter: str, distribution: Distribution) -> float:
        """Return the value of a parameter."""
        # The base case: the median of each number, which is also its most central value.
        if self.realisation is None:
            return distribution.quantile(0.5)
        # A stream for each parameter: adding one leaves the numbers of the others as they are.
        stream = stream_of(self.seed, self.realisation, parameter)
        return distribution.quantile(probability_of(stream))

    def field(self, parameter: str, field: GaussianField) -> np.ndarray:
        """Return a field on the nodes of its lattice [m]."""
        if self.realisation is None:
            return field.mean()
        return field.simulate(stream_of(self.seed, self.realisation, parameter))


_STEPS = 1 << 53


def check_seed(seed: Any) -> int:
    """Return a seed, or raise an error that names what it must be.

    Examples
    --------
    >>> check_seed(3)
    3
    """
    if not (is_whole(seed) and seed >= 0):
        raise InputError(f"seed is {seed!r}; give a whole number, 0 or above.")
    return int(seed)


def stream_of(seed: int, realisation: int, parameter: str) -> np.random.Generator:
    """
    Return the random numbers of one parameter in one realisation.

    Parameters
    ----------
    seed : int
    realisation : int
    parameter : str
        Name of the parameter.

    Returns
    -------
    numpy.random.Generator

    Examples
    --------
    >>> a, b, c = (stream_of(0, k, p).random() for k, p in ((5, "x"), (5, "x"), (5, "y")))
    >>> a == b, a == c
    (True, False)
    """
    # The name enters by its hash: 128 bits, the same in every process and on every machine.
    words = np.frombuffer(hashlib.sha256(parameter.encode()).digest()[:16], dtype="<u4")
    sequence = np.random.SeedSequence(seed, spawn_key=(realisation, *words.tolist()))
    return np.random.Generator(np.random.PCG64(sequence))


def probability_of(stream: np.random.Generator) -> float:
    """Return a uniform number that is neither 0 nor 1.

    Examples
    --------
    >>> 0.0 < probability_of(stream_of(0, 0, "x")) < 1.0
    True
    """
    # The middle of one of 2**53 equal steps: never 0 or 1, where quantiles are infinite.
    return (int(stream.integers(_STEPS)) + 0.5) / _STEPS


class Given(Protocol):
    """The inputs that realisations change, as they were given."""

    horizon_names: tuple[str, ...]
    fault_names: tuple[str, ...]
    contacts: dict[str, Any]
    velocity: Any
    tops: Tops | None

    def horizon(self, name: str) -> HorizonData:
        """Return the data of a horizon, before it is torn or thrown."""

    def fault(self, name: str) -> TriSurface:
        """Return a fault, before it is extended and truncated."""

    @property
    def deepest(self) -> float:
        """Depth of the floor of the base case [m]."""


@dataclass
class Change:
    """
    New inputs of one realisation; what is not in it stays as it was given.

    Attributes
    ----------
    given : Given
    draws : Draws
    up : dict of str to ndarray
        How far each point of a horizon moves up [m].
    faults : dict of str to TriSurface
    contacts : dict of str to object
    throws : dict of str to (object, float)
        By fault a throw as `throw_horizon` takes it, None for that of the scene, and its factor.
    velocity : dict of str to float
        Factors of velocities, by the names that they have.
    numbers : dict of str to float
        Value of each parameter.
    """

    given: Given
    draws: Draws
    # Sums of what each uncertainty adds, point by point; absent: the horizon stays.
    up: dict[str, np.ndarray] = field(default_factory=dict)
    faults: dict[str, TriSurface] = field(default_factory=dict)
    contacts: dict[str, Any] = field(default_factory=dict)
    throws: dict[str, tuple[Any, float]] = field(default_factory=dict)
    velocity: dict[str, float] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)

    def lift(self, horizon: str, by: Any) -> None:
        """Move a horizon up [m], in addition to what others have moved it."""
        # Several uncertainties may move one horizon: their moves add up, in any order.
        known = self.up.get(horizon, 0.0)
        self.up[horizon] = known + np.broadcast_to(by, len(self.given.horizon(horizon).points))

    def fault(self, name: str) -> TriSurface:
        """Return a fault as it has been moved so far."""
        # A fault may be shifted and then turned: the second starts from the first.
        return self.faults.get(name) or self.given.fault(name)

    def horizons(self) -> dict[str, Any]:
        """Return the horizons that have moved, as a scene takes them."""
        # Only horizons that have moved: results of the others are shared by all realisations.
        return {name: self.given.horizon(name).moved(up) for name, up in self.up.items()}


class Uncertainty(Protocol):
    """One uncertain input of a model: a number, or a field."""

    @property
    def parameter(self) -> str:
        """Name of its number in all results; it also selects the stream of random numbers."""

    @property
    def unit(self) -> str:
        """Unit of that number."""

    def prepare(self, given: Given) -> Prepared:
        """Check names, and compute what all realisations share."""


class Prepared(Protocol):
    """An uncertainty of a given model."""

    @property
    def reach(self) -> float:
        """How far up or down it may move horizons from the base case [m]."""

    def apply(self, change: Change) -> None:
        """Draw, and change the inputs."""


@dataclass(frozen=True, eq=False)
class PreparedNumber:
    """
    An uncertain number of a given model.

    Attributes
    ----------
    parameter : str
    by : distribution
    act : callable
        Takes a change and the number that was drawn, and changes the inputs.
    reach : float
        As of `Prepared`.
    """

    parameter: str
    by: Distribution
    act: Callable[[Change, float], object]
    reach: float = 0.0

    def apply(self, change: Change) -> None:
        """Draw the number, note it, and change the inputs."""
        number = change.numbers[self.parameter] = change.draws.number(self.parameter, self.by)
        self.act(change, number)


class Named:
    """The name of an uncertainty in all results: its own, or made of what it changes."""

    what = ""  # the words before the names of surfaces
    name: str

    @property
    def parameter(self) -> str:
        """Name of the parameter."""
        first: Any = vars(self)[fields(self)[0].name]  # type: ignore[arg-type]
        names = ", ".join((first,) if isinstance(first, str) else tuple(first))
        return self.name or f"{self.what} {names}".strip()


def names_among(names: Any, known: tuple[str, ...], what: str) -> tuple[str, ...]:
    """Return names as a tuple, or raise an error for one that is unknown; empty: all.

    Examples
    --------
    >>> names_among("Top", ("Top", "Base"), "horizon"), names_among((), ("Top", "Base"), "horizon")
    (('Top',), ('Top', 'Base'))
    """
    # A single name is a common slip for a list of one.
    listed = (names,) if isinstance(names, str) else tuple(names)
    for name in listed:
        refusal = f"no {what} is called {name!r}; there are {', '.join(known) or 'none'}."
        check_word(name, known, refusal)
    # Nothing listed means everything.
    return listed or known
