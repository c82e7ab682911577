"""Choose the exact curve where a smooth one costs more for the same accuracy.

On rough lattices triangles are as near to the surface as cubics; on dense ones triangles are near
enough. Both are foreseen from some nodes of each lattice. The error of the exact curve is measured
where it was made: at the middle of some of its segments, with the estimate that smooth curves have.
Where it is too large, the smooth curve is made along the exact one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from geosurf.arrangement.search import Contacts, find_contacts
from geosurf.intersect.exact_follow import Followed, follow_curves, points_near_holes
from geosurf.intersect.sides import lattice_of, nodes_of
from geosurf.kernels.smooth.exact_error import error_of_exact, judge_lattices
from geosurf.model import CurveIssue, Curves, TriSurface, frozen

DENSE = 40_000  # nodes of a lattice from which on loops smaller than a cell are not looked for
LARGE = 150_000  # nodes from which on the exact curve costs less than a walk along cubics
SEGMENTS = 64  # of the exact curve at which its error is measured, at most
SAMPLES = 5  # nodes along either axis by which a lattice is judged
LOUD = 0.5  # part of the tolerance from which on noise keeps curves exact (`lift.doubt_along`)
AUDIBLE = 0.1  # part of the tolerance from which on noise matters
SPARE = 0.33  # part of the tolerance that triangles may take, by samples, to be kept


class Judgement(NamedTuple):
    """What some nodes of both lattices show.

    Attributes
    ----------
    first : bool
        Whether the exact curve is made first; otherwise walks along cubics may do without it.
    last : bool
        Whether it is made where walks were in vain.
    shown : bool
        Whether triangles show every curve that matters: what they miss is smaller than a cell of a
        dense lattice, crosses by less than the tolerance, or is noise.
    """

    first: bool
    last: bool
    shown: bool


def judge(one: TriSurface, two: TriSurface, tolerance: float) -> Judgement:
    """Judge the lattices of two surfaces, of which the first has cubics, by a tolerance [m]."""
    smooth = [x for x in (lattice_of(one), lattice_of(two)) if x is not None]
    other = smooth[-1] if len(smooth) > 1 else None
    bends, noise = judge_lattices(*nodes_of(smooth[0]), *nodes_of(other), SAMPLES)

    # triangles leave a surface by an eighth of its second differences
    foreseen, loud = 0.125 * bends, noise > LOUD * tolerance
    on_mesh, size = other is None, max(lattice.n_node for lattice in smooth)
    whole = all(lattice.whole for lattice in smooth)
    dense = (on_mesh or size >= DENSE) and foreseen <= SPARE * tolerance

    # walks need no exact curve: on lattices with holes, which the search lists, they cost half
    first = loud or on_mesh or (whole and (dense or size >= LARGE))
    last = not whole or foreseen <= tolerance or noise > 0.5 * LOUD * tolerance
    return Judgement(first, last, shown=loud or dense or size >= DENSE)


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
    found, holes = _error_of(contacts), None
    if found is None:
        return None
    error, noise, loudest = found

    # others are nearer, or show loops that no triangle shows; noise anywhere keeps the exact curve
    near = error <= tolerance and (judged.shown or noise > AUDIBLE * tolerance)
    if not (near or max(noise, loudest if judged.shown else 0.0) > LOUD * tolerance):
        followed = follow_curves(plain, contacts, tolerance, with_keys=not judged.shown)
        if followed is False:
            return None
        if not isinstance(followed, bool):
            return plain, followed
    if not all(x is None or x.whole for x in map(lattice_of, (one, two))):
        holes = points_near_holes(plain, contacts)
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


def _error_of(contacts: Contacts) -> tuple[float, float, float] | None:
    """Largest error of the curves of two surfaces, noise at half of their segments, and most [m].

    Next to holes there is none; None where it is not known elsewhere.
    """
    one, two = map(lattice_of, contacts.surfaces)
    assert one is not None
    error, typical, loudest, good, astray = error_of_exact(
        *nodes_of(one), *nodes_of(two), one.rising, two is not None and two.rising,
        contacts.rows, contacts.ids, contacts.x, contacts.t,
        contacts.surface_of_face, contacts.key_of_face, contacts.origin, SEGMENTS,
    )  # fmt: skip
    if good:
        return (error, typical, loudest) if typical or not astray else None
    return None if astray else (0.0, 0.0, 0.0)


__all__ = ["Judgement", "exact_curves", "judge"]
