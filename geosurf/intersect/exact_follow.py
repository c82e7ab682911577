"""Smooth curves along exact ones that are not near enough, and where holes leave these unknown."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from geosurf.arrangement.search import Contacts
from geosurf.intersect.sides import lattice_of, nodes_of
from geosurf.intersect.strand import Line
from geosurf.kernels.contacts.packed_contact import n_corners
from geosurf.kernels.smooth.exact_chains import segments_near_holes
from geosurf.kernels.smooth.exact_follow import FOLLOWED, NOISY, follow_exact
from geosurf.model import Curves

_ARCS = 64  # that a curve has at least, where it has as many segments
_SHORT, _LONG = 6, 32  # segments that an arc replaces at most: of short curves, of long ones
_CELLS = 1 << 31  # above the number of cells or triangles of any surface


class Followed(NamedTuple):
    """Smooth curves along exact ones.

    Attributes
    ----------
    lines : list of Line
    keys : ndarray of int64
        Pairs of cells that exact or smooth curves run through, as in `geosurf.intersect.loops`.
    """

    lines: list[Line]
    keys: np.ndarray


def follow_curves(
    plain: Curves, contacts: Contacts, tolerance: float, *, with_keys: bool
) -> Followed | bool:
    """Return smooth curves along the exact ones of a lattice and another surface.

    Parameters
    ----------
    plain : Curves
        Of the contacts, without touching points and areas.
    contacts : Contacts
        The first surface has cubics.
    tolerance : float
        [m]
    with_keys : bool
        Whether to list pairs of cells.

    Returns
    -------
    Followed or bool
        True where noise is louder than the tolerance allows, False where a point could not be
        lifted.
    """
    one, two = contacts.surfaces
    first, second = lattice_of(one), lattice_of(two)
    assert first is not None
    chain = np.concatenate(plain.curves)
    offsets = np.append(0, np.cumsum([len(curve) for curve in plain.curves]))
    span = min(max(len(chain) // _ARCS, _SHORT), _LONG)
    holes = not first.whole or (second is not None and not second.whole)
    points, stops, figures, spans, keys, status = follow_exact(
        *nodes_of(first), *nodes_of(second), first.rising, second is not None and second.rising,
        plain.local, chain, offsets, contacts.rows, contacts.ids, contacts.x, contacts.t,
        contacts.surface_of_face, contacts.key_of_face, contacts.origin, holes, span, tolerance,
        with_keys,
    )  # fmt: skip
    if status != FOLLOWED:
        return bool(status == NOISY)

    lines = []
    for k, (a, b) in enumerate(pairwise(stops.tolist())):
        bound, doubt = figures[k].tolist()
        places = [("interpolation", points[a:b], doubt)] if bound > tolerance else []
        gaps = spans[spans[:, 0] == k, 1:].tolist()
        if gaps:
            # next to a hole the exact curve stays
            stays = np.concatenate([points[i:j] for i, j in gaps])
            bound, places = np.inf, [*places, ("hole", stays, np.inf)]
        lines.append(Line(points[a:b], bool(plain.closed[k]), bound, places))
    if with_keys:
        keys = np.concatenate([keys, _keys_of_contacts(contacts, smooth=second is not None)])
    return Followed(lines, keys)


def _keys_of_contacts(contacts: Contacts, smooth: bool) -> np.ndarray:
    """Pairs of cells in which faces meet in lines."""
    faces = contacts.rows[n_corners(contacts.rows) == 2, :2]
    swap = contacts.surface_of_face[faces[:, 0]] > 0
    faces[swap] = faces[swap][:, ::-1]
    keys = contacts.key_of_face[faces]
    return (keys[:, 0] >> 1) * _CELLS + (keys[:, 1] >> 1 if smooth else keys[:, 1])


def points_near_holes(plain: Curves, contacts: Contacts) -> list[np.ndarray] | None:
    """Points of each exact curve next to holes (world) [m]; None where contacts are not known."""
    first, second = (lattice_of(surface) for surface in contacts.surfaces)
    assert first is not None
    chain = np.concatenate(plain.curves)
    offsets = np.append(0, np.cumsum([len(curve) for curve in plain.curves]))
    near, known = segments_near_holes(
        *nodes_of(first), *nodes_of(second), plain.local, chain, offsets, contacts.rows,
        contacts.ids, contacts.x, contacts.surface_of_face, contacts.key_of_face,
    )  # fmt: skip
    if not known:
        return None
    near[1:] |= near[:-1]  # both ends of a segment; the last point of a curve has none
    found = []
    for a, b in pairwise(offsets.tolist()):
        rows = chain[a:b][near[a:b]]
        found.append(plain.local[rows] + contacts.origin)
    return found
