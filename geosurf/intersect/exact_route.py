"""Choose the exact curve where a smooth one costs more for the same accuracy.

On rough lattices triangles are as near to the surface as cubics; on dense ones triangles are near
enough. Both are foreseen from some nodes of each lattice, so that only pairs that will keep
the exact curve pay for it. The error of that curve is measured where it was made: at the middle of
some of its segments, with the estimate that smooth curves have.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.arrangement.search import Contacts, find_contacts
from geosurf.intersect.sides import has_cubics
from geosurf.kernels.smooth.exact_error import error_of_exact, judge_lattices
from geosurf.model import CurveIssue, Curves, Lattice, TriSurface, frozen

DENSE = 40_000  # nodes of a lattice from which on the exact curve costs less than a smooth one
SEGMENTS = 64  # of the exact curve at which its error is measured, at most
SAMPLES = 5  # nodes along either axis by which a lattice is judged
LOUD = 0.5  # part of the tolerance from which on noise keeps curves exact (`lift.doubt_along`)
AUDIBLE = 0.1  # part of the tolerance from which on noise matters
SPARE = 0.33  # part of the tolerance that triangles may take, by samples, to be kept
_NONE = np.zeros((1, 1))


def exact_curves(
    one: TriSurface,
    two: TriSurface,
    origin: np.ndarray,
    tolerance: float,
    linker: Callable[..., Curves],
    options: dict[str, Any],
    names: tuple[str, str],
    *,
    walked: bool = False,
) -> Curves | None:
    """Return the exact curves of a lattice and another surface with their bound, or None.

    They have the points and rows of the exact route. None: smooth curves are worth their cost, or
    the error of the exact ones is unknown somewhere.

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
    walked : bool
        Whether smooth curves were walked in vain, so that the exact ones are needed in any case.
    """
    smooth = [s.lattice for s in (one, two) if s.lattice is not None and has_cubics(s)]
    if not all(lattice.whole for lattice in smooth):
        return None  # near holes the error is unknown
    bends, loud = judge_lattices(*_nodes(smooth[0]), *_nodes(smooth[-1], len(smooth) > 1), SAMPLES)

    # triangles leave a surface by an eighth of its second differences; curves on a mesh are made
    # from the exact ones, so those cost less whatever the size
    foreseen = 0.125 * bends
    on_mesh = len(smooth) == 1
    large = on_mesh or max(lattice.n_node for lattice in smooth) >= DENSE
    dense = large and foreseen <= SPARE * tolerance
    last = (foreseen <= tolerance and not on_mesh) or loud > 0.5 * LOUD * tolerance
    if not (dense or loud > LOUD * tolerance or (walked and last)):
        return None
    contacts = find_contacts((one, two), origin=origin, **options)
    plain = linker(contacts)
    if not plain.n_curve or plain.contacts:
        return None  # what touches is looked at more closely
    found = _error_of(contacts)
    if found is None:
        return None
    error, noise = found

    # smooth curves are nearer, or find loops that no triangle shows
    near = error <= tolerance and (dense or noise > AUDIBLE * tolerance)
    if not (near or noise > LOUD * tolerance):
        return None
    places: tuple[CurveIssue, ...] = ()
    if error > tolerance:
        ours = [frozen(plain.local[curve] + origin, np.float64) for curve in plain.curves]
        places = tuple(CurveIssue("noise", (0, 1), x, error, k) for k, x in enumerate(ours))
    cost = plain.cost | {"exact_pairs": 1}
    bound = frozen(np.full(plain.n_curve, error), np.float64)
    return replace(plain, names=names, error_bound=bound, places=places, cost=cost)


def _nodes(lattice: Lattice, there: bool = True) -> tuple[np.ndarray, ...]:
    """Coordinates of nodes as tables; of none: single zeros."""
    if not there:
        return _NONE, _NONE, _NONE
    x, y = lattice.easting, lattice.northing
    if x.ndim == 1:
        x, y = x[None, :], y[:, None]
    return x, y, lattice.elevation


def _error_of(contacts: Contacts) -> tuple[float, float] | None:
    """Largest error of the curves of two surfaces, and the noise at half of their segments [m].

    None where the error of a part is not known.
    """
    one, two = (s.lattice if has_cubics(s) else None for s in contacts.surfaces)
    assert one is not None
    error, typical, good, astray = error_of_exact(
        *_nodes(one), *_nodes(two or one, two is not None),
        one.rising, two is not None and two.rising,
        contacts.rows, contacts.ids, contacts.x, contacts.t,
        contacts.surface_of_face, contacts.key_of_face, contacts.origin, SEGMENTS,
    )  # fmt: skip
    return (error, typical) if good and (typical or not astray) else None


__all__ = ["exact_curves"]
