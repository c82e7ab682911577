"""Choose the exact curve where a smooth one costs more for the same accuracy.

On rough lattices triangles are as near to the surface as cubics; on dense ones triangles are near
enough. Both are foreseen from some nodes of each lattice. The error of the exact curve is measured
where it was made: at the middle of some of its segments, with the estimate that smooth curves have.
Where it is too large, the smooth curve is made along the exact one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.arrangement.search import find_contacts
from geosurf.intersect.exact_follow import Exact, Followed, points_near_holes
from geosurf.intersect.near_holes import meet_at_holes
from geosurf.intersect.sides import lattice_of, nodes_of
from geosurf.kernels.smooth.exact_error import judge_lattices
from geosurf.kernels.smooth.exact_follow import CHOOSE, FOLLOW, MEASURE, MEASURED
from geosurf.kernels.smooth.steady_rise import rises_steadily
from geosurf.model import CurveIssue, Curves, TriSurface, frozen

DENSE = 40_000  # nodes of a lattice from which on loops smaller than a cell are not looked for
LARGE = 150_000  # nodes from which on the exact curve costs less than a walk along cubics
SAMPLES = 5  # nodes along either axis by which a lattice is judged
LOUD = 0.5  # part of the tolerance from which on noise keeps curves exact (`lift.doubt_along`)
AUDIBLE = 0.1  # part of the tolerance from which on noise matters
SPARE = 0.33  # part of the tolerance that triangles may take, by samples, to be kept


class Judgement:
    """What is known of two surfaces before their curves are; the rest is found when needed.

    Attributes
    ----------
    first : bool
        Whether the exact curve is made first; otherwise walks along cubics may do without it.
    last : bool
        Whether it is made where walks were in vain.
    nodes : tuple of ndarray
        Of both lattices, as `nodes_of` gives them.
    """

    def __init__(self, one: TriSurface, two: TriSurface, tolerance: float) -> None:
        lattices = lattice_of(one), lattice_of(two)
        smooth = [x for x in lattices if x is not None]
        self._pair, self._lattices, self._tolerance = (one, two), lattices, tolerance
        self.nodes = (*nodes_of(lattices[0]), *nodes_of(lattices[1]))
        self._size = max(lattice.n_node for lattice in smooth)
        self._foreseen: tuple[bool, bool] | None = None
        whole = all(lattice.whole for lattice in smooth)

        # walks need no exact curve, but end at holes; small lattices are searched after both
        self.first = len(smooth) == 1 or (whole and self._size >= LARGE)
        if not (self.first or whole) and self._size >= DENSE:
            self.first = meet_at_holes(one, two)
        self.last = self.first or not whole
        if not self.first:
            bends, noise = self._samples
            loud, dense = noise > LOUD * tolerance, self._is_dense
            self.first = loud or (whole and dense)
            self.last |= bends <= tolerance or noise > 0.5 * LOUD * tolerance

    @cached_property
    def _samples(self) -> tuple[float, float]:
        """How far triangles leave both surfaces, and their noise, from some nodes [m]."""
        bends, noise = judge_lattices(*self.nodes, SAMPLES)
        return 0.125 * bends, noise  # an eighth of second differences

    @property
    def _is_dense(self) -> bool:
        """Whether triangles are near enough, by samples."""
        dense = self._lattices[1] is None or self._size >= DENSE
        return dense and self._samples[0] <= SPARE * self._tolerance

    @cached_property
    def shown(self) -> bool:
        """Whether triangles show every curve that matters: what they miss is smaller than a cell of
        a dense lattice, crosses by less than the tolerance, is noise, or cannot be.
        """
        if self._size >= DENSE or self._rises_steadily():
            return True
        return self._samples[1] > LOUD * self._tolerance or self._is_dense

    def _rises_steadily(self) -> bool:
        """Whether triangles are known to show all curves of a lattice and a mesh."""
        if self._lattices[1] is not None or len(self.nodes[0]) > 1:
            return False
        mesh = self._pair[1]
        return bool(rises_steadily(*self.nodes[:3], mesh.vertices, mesh.triangles))


def exact_curves(
    one: TriSurface,
    two: TriSurface,
    origin: np.ndarray,
    tolerance: float,
    linker: Callable[..., Curves],
    options: dict[str, Any],
    names: tuple[str, str],
    judged: Judgement,
) -> tuple[Curves, Followed | None] | None:
    """Return the exact curves of a lattice and another surface, or smooth ones along them, or None.

    The exact ones have the points and rows of the exact route, and a bound. None: curves have to
    be looked for more closely.

    Parameters
    ----------
    one, two : TriSurface
        The first one has cubics.
    origin : ndarray, shape (3,)
        Of the local frame [m].
    tolerance : float
        [m]
    linker : callable
        From contacts to curves.
    options : dict
        For `find_contacts`.
    names : (str, str)
        Of both surfaces, in the order in which the curves name them.
    judged : Judgement
        Of these two.

    Returns
    -------
    curves : Curves
        With a bound where they are the answer.
    followed : Followed or None
        The answer, where the exact curves are not near enough.
    """
    contacts = find_contacts((one, two), origin=origin, **options)
    plain = linker(contacts)
    if plain.contacts:
        return None  # what touches is looked at more closely
    if not plain.n_curve:
        return (_with_bound(plain, 0.0, tolerance, names, None), None) if judged.shown else None
    exact, keys = Exact.of(plain, contacts, tolerance, judged.nodes), False
    found, holes = exact.run(CHOOSE, with_keys=False), None
    if found[-1] == MEASURED:
        measured = _error_in(found)
        if measured is None:
            return None
        error, noise, loudest = measured

        # smooth ones are nearer, or show loops that no triangle shows; noise keeps the exact curve
        near = error <= tolerance and (noise > AUDIBLE * tolerance or judged.shown)
        loud = noise > LOUD * tolerance or (loudest > LOUD * tolerance and judged.shown)
        if not (near or loud):
            keys = not judged.shown
            found = exact.run(FOLLOW, with_keys=keys)
    elif not judged.shown:  # what is searched beside them needs keys
        keys = True
        found = exact.run(FOLLOW, with_keys=True)
    if found[-1] != MEASURED:
        followed = exact.lines(found, with_keys=keys)
        if followed is False:
            return None
        if not isinstance(followed, bool):
            return plain, followed
        measured = _error_in(exact.run(MEASURE, with_keys=False))
        if measured is None:
            return None
        error = measured[0]
    if not exact.whole:
        holes = points_near_holes(exact)
        if holes is None:
            return None
    return _with_bound(plain, error, tolerance, names, holes), None


def _with_bound(
    plain: Curves,
    error: float,
    tolerance: float,
    names: tuple[str, str],
    holes: list[np.ndarray] | None,
) -> Curves:
    """Exact curves with their error [m]; `holes`: points of each curve next to a hole."""
    places: list[CurveIssue] = []
    bound = np.full(plain.n_curve, error)
    for k, curve in enumerate(plain.curves):
        if error > tolerance:
            points = frozen(plain.local[curve] + plain.origin, np.float64)
            places.append(CurveIssue("noise", (0, 1), points, error, k))
        if holes is not None and len(holes[k]):
            places.append(CurveIssue("hole", (0, 1), frozen(holes[k], np.float64), np.inf, k))
            bound[k] = np.inf
    cost = plain.cost | {"exact_pairs": 1}
    return replace(
        plain, names=names, error_bound=frozen(bound, np.float64), places=tuple(places), cost=cost
    )


def _error_in(found: tuple[Any, ...]) -> tuple[float, float, float] | None:
    """Largest error of the curves of two surfaces, noise at half of their segments, and most [m].

    Next to holes there is none; None where it is not known elsewhere.
    """
    error, typical, loudest, good, astray = found[0].tolist()
    if good:
        return (error, typical, loudest) if typical or not astray else None
    return None if astray else (0.0, 0.0, 0.0)


__all__ = ["Judgement", "exact_curves"]
