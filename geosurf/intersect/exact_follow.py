"""Smooth curves along exact ones that are not near enough, and where holes leave these unknown."""

from __future__ import annotations

from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import numpy as np

from geosurf.arrangement.search import Contacts
from geosurf.intersect.sides import lattice_of
from geosurf.intersect.strand import Line
from geosurf.kernels.contacts.packed_contact import n_corners
from geosurf.kernels.smooth.exact_chains import segments_near_holes
from geosurf.kernels.smooth.exact_follow import FOLLOWED, NOISY, follow_exact
from geosurf.model import Curves

_ARCS = 64  # that a curve has at least, where it has as many segments
_SHORT, _LONG = 6, 32  # segments that an arc replaces at most: of short curves, of long ones
SEGMENTS = 64  # of the exact curve at which its error is measured, at most
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


class Exact(NamedTuple):
    """Exact curves of a lattice with cubics and another surface, for the kernels.

    Attributes
    ----------
    plain : Curves
        Of the contacts, without touching points and areas.
    contacts : Contacts
    tolerance : float
        [m]
    arrays : tuple
        Nodes of both surfaces and all that follows from the curves.
    whole : bool
        Whether no node is absent.
    """

    plain: Curves
    contacts: Contacts
    tolerance: float
    arrays: tuple[Any, ...]
    whole: bool

    @classmethod
    def of(
        cls, plain: Curves, contacts: Contacts, tolerance: float, nodes: tuple[np.ndarray, ...]
    ) -> Exact:
        """Gather what kernels read; `nodes` as from `nodes_of`, of both surfaces."""
        first, second = (lattice_of(surface) for surface in contacts.surfaces)
        assert first is not None
        curves = plain.curves
        chain = curves[0] if len(curves) == 1 else np.concatenate(curves)
        offsets = np.array([0, *accumulate(map(len, curves))])
        arrays = (
            *nodes, first.rising, second is not None and second.rising, plain.local, chain,
            offsets, contacts.rows, contacts.ids, contacts.x, contacts.t,
            contacts.surface_of_face, contacts.key_of_face, contacts.origin,
        )  # fmt: skip
        whole = first.whole and (second is None or second.whole)
        return cls(plain, contacts, tolerance, arrays, whole)

    def run(self, task: int, *, with_keys: bool) -> tuple[Any, ...]:
        """What `follow_exact` returns."""
        n = len(self.arrays[9])
        span = min(max(n // _ARCS, _SHORT), _LONG)
        found: tuple[Any, ...] = follow_exact(
            *self.arrays, not self.whole, span, self.tolerance, with_keys, SEGMENTS, task
        )
        return found

    def lines(self, found: tuple[Any, ...], *, with_keys: bool) -> Followed | bool:
        """Smooth curves from what `run` returned.

        True where noise is louder than the tolerance allows, False where a point could not be
        lifted.
        """
        _, points, stops, figures, spans, keys, status = found
        if status != FOLLOWED:
            return bool(status == NOISY)
        lines = []
        for k, (a, b) in enumerate(pairwise(stops.tolist())):
            bound, doubt = figures[k].tolist()
            places = [("interpolation", points[a:b], doubt)] if bound > self.tolerance else []
            gaps = spans[spans[:, 0] == k, 1:].tolist() if len(spans) else []
            if gaps:
                # next to a hole the exact curve stays
                stays = np.concatenate([points[i:j] for i, j in gaps])
                bound, places = np.inf, [*places, ("hole", stays, np.inf)]
            lines.append(Line(points[a:b], bool(self.plain.closed[k]), bound, places))
        if with_keys:
            smooth = len(self.arrays[5]) > 1
            keys = np.concatenate([keys, _keys_of_contacts(self.contacts, smooth=smooth)])
        return Followed(lines, keys)


def _keys_of_contacts(contacts: Contacts, smooth: bool) -> np.ndarray:
    """Pairs of cells in which faces meet in lines."""
    faces = contacts.rows[n_corners(contacts.rows) == 2, :2]
    swap = contacts.surface_of_face[faces[:, 0]] > 0
    faces[swap] = faces[swap][:, ::-1]
    keys = contacts.key_of_face[faces]
    return (keys[:, 0] >> 1) * _CELLS + (keys[:, 1] >> 1 if smooth else keys[:, 1])


def points_near_holes(exact: Exact) -> list[np.ndarray] | None:
    """Points of each exact curve next to holes (world) [m]; None where contacts are not known."""
    plain, contacts, arrays = exact.plain, exact.contacts, exact.arrays
    chain, offsets = arrays[9:11]
    near, known = segments_near_holes(
        *arrays[:6], *arrays[8:14], contacts.surface_of_face, contacts.key_of_face
    )
    if not known:
        return None
    near[1:] |= near[:-1]  # both ends of a segment; the last point of a curve has none
    found = []
    for a, b in pairwise(offsets.tolist()):
        rows = chain[a:b][near[a:b]]
        found.append(plain.local[rows] + contacts.origin)
    return found
