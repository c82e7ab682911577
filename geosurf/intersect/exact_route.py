"""Choose the exact curve where a smooth one costs more for the same accuracy.

On rough lattices triangles are as near to the surface as cubics; on dense ones triangles are near
enough. Both are foreseen from some hundred nodes of each lattice, so that only pairs that will keep
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
from geosurf.intersect.strand import Line
from geosurf.kernels.contacts.packed_contact import n_corners
from geosurf.kernels.smooth.error_estimate import errors_along
from geosurf.kernels.smooth.lift import ASTRAY, HOLE, LIFTED, lift_points
from geosurf.model import Curves, Lattice, TriSurface

DENSE = 150_000  # nodes of a lattice from which on the exact curve costs less than a smooth one
SEGMENTS = 100  # of the exact curve at which its error is measured, about
SAMPLES = 10  # nodes along either axis by which a lattice is judged
AUDIBLE = 0.1  # part of the tolerance from which on noise matters
WIGGLES = 1.0  # fourth over second differences: 3.4 for noise alone, small where cells are small
SPARE = (
    0.25  # part of the tolerance that sampled triangles may take for the exact curve to be tried
)
_NONE = np.zeros((1, 1))


def exact_lines(
    one: TriSurface,
    two: TriSurface,
    origin: np.ndarray,
    tolerance: float,
    linker: Callable[..., Curves],
    options: dict[str, Any],
    *,
    walked: bool = False,
) -> tuple[list[Line], Curves] | None:
    """Return the exact curves of a lattice and another surface with bounds, or None.

    None: smooth curves are worth their cost, or the error of the exact ones is unknown somewhere.

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
    walked : bool
        Whether smooth curves were walked in vain, so that the exact ones are needed in any case.
    """
    smooth = [s.lattice for s in (one, two) if s.lattice is not None and has_cubics(s)]
    if not all(lattice.whole for lattice in smooth):
        return None  # near holes the error is unknown
    bends, wiggles = np.transpose([_differences(lattice) for lattice in smooth])

    # triangles leave a surface by an eighth of its second differences
    size = max(lattice.elevation.size for lattice in smooth)
    dense = size >= DENSE and 0.125 * float(bends.sum()) <= SPARE * tolerance
    rough = (wiggles > np.maximum(WIGGLES * bends, AUDIBLE * tolerance)).any()
    if not (walked or dense or rough):
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
    if not (near or noise > 0.5 * tolerance):  # as in `lift.doubt_along`
        return None
    lines = []
    for curve, closed in zip(plain.curves, plain.closed.tolist(), strict=True):
        points = plain.local[curve]
        places = [("noise", points, error)] if error > tolerance else []
        lines.append(Line(points, closed, error, places))
    return lines, replace(plain, cost=plain.cost | {"exact_pairs": 1})


def _differences(lattice: Lattice) -> tuple[float, float]:
    """Root mean squares of second and fourth differences of sampled nodes, over both axes [m]."""
    n_row, n_col = lattice.elevation.shape
    row, column = (np.linspace(2, n - 3, SAMPLES).astype(np.int64) for n in (n_row, n_col))
    node = (row[:, None] * n_col + column).ravel()
    steps = np.arange(-2, 3)[:, None]
    at = np.divmod(np.stack([node + steps * n_col, node + steps]), n_col)
    bends, wiggles = 0.0, 0.0
    for q in (lattice.easting, lattice.northing, lattice.elevation):
        if q.ndim == 1:
            continue  # axes are even, or nearly so
        line = q[at]
        two = line[:, :-2] - 2.0 * line[:, 1:-1] + line[:, 2:]
        four = two[:, 0] - 2.0 * two[:, 1] + two[:, 2]
        bends += float(np.sqrt(np.square(two[:, 1]).mean(axis=1)).sum())
        wiggles += float(np.sqrt(np.square(four).mean(axis=1)).sum())
    return bends, wiggles


def _error_of(contacts: Contacts) -> tuple[float, float] | None:
    """Largest error of the curves of two surfaces, and the noise at half of their segments [m].

    None where the error of a part is not known.
    """
    lines = np.flatnonzero(n_corners(contacts.rows) == 2)
    lines = lines[:: max(1, len(lines) // SEGMENTS)]
    ends = contacts.ids[lines, :2]
    middle = 0.5 * (contacts.x[ends[:, 0]] + contacts.x[ends[:, 1]]) + contacts.origin
    faces = contacts.rows[lines, :2]
    swap = contacts.surface_of_face[faces[:, 0]] > 0
    faces[swap] = faces[swap][:, ::-1]
    keys = contacts.key_of_face[faces]

    # world coordinates: nothing is copied, and 1e-9 m do not matter to an error
    n = len(lines)
    w = np.zeros((n, 4))
    arrays: list[np.ndarray] = []
    corners = np.zeros((1, 3, 3))
    for k, surface in enumerate(contacts.surfaces):
        lattice = surface.lattice
        if lattice is None:
            places = surface.vertices[surface.triangles[keys[:, k]]]
        else:
            nodes = lattice.corners_of_keys(keys[:, k])
            places = lattice.places_of_nodes(nodes.ravel()).reshape(n, 3, 3)
        weights = _weights(places, middle)
        if lattice is None or not has_cubics(surface):
            corners, w[:, 2:] = places, weights[:, 1:]
            arrays += [_NONE, _NONE, _NONE]
            continue
        row, column = np.divmod(nodes, lattice.shape[1])
        w[:, 2 * k] = (weights * column).sum(axis=1)
        w[:, 2 * k + 1] = (weights * row).sum(axis=1)
        x, y = lattice.easting, lattice.northing
        if x.ndim == 1:
            x, y = x[None, :], y[:, None]
        arrays += [x, y, lattice.elevation]
    lifted, tangents, doubts = np.zeros((n, 3)), np.zeros((n, 4)), np.zeros((n, 6))
    hold, tri = np.zeros(n, dtype=np.int64), np.arange(n)
    status = lift_points(*arrays, corners, tri, hold, middle, w, lifted, tangents, doubts)
    good = status == LIFTED
    if (status == HOLE).any() or 2 * np.count_nonzero(good) < n:
        return None
    total, noise = errors_along(np.column_stack([doubts[good], tangents[good, 3]]))
    typical = float(np.median(noise))
    if not typical and (status == ASTRAY).any():
        return None
    moved = np.linalg.norm(lifted[good] - middle[good], axis=1)

    # halfway along a segment is not always where it is farthest, and others are not looked at
    return float(2.0 * moved.max() + total.max()), typical


def _weights(corners: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Barycentric coordinates (n, 3) of points in the planes of triangles (n, 3, 3)."""
    u, v, d = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], x - corners[:, 0]
    uu, uv, vv = ((p * q).sum(axis=1) for p, q in ((u, u), (u, v), (v, v)))
    du, dv = (d * u).sum(axis=1), (d * v).sum(axis=1)
    size = uu * vv - uv * uv
    s, t = (du * vv - dv * uv) / size, (dv * uu - du * uv) / size
    return np.stack([1.0 - s - t, s, t], axis=1)


__all__ = ["exact_lines"]
