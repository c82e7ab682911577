"""A close-up of a place: the surfaces around it, cut to a small box, and a mark."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence

import numpy as np

from geosurf.conventions import is_number, real_numbers
from geosurf.errors import InputError
from geosurf.model import TriSurface
from geosurf.model.expected import expect, listed
from geosurf.render import palette
from geosurf.render.layers import Content, Entry, Layer, show_surfaces

REACH = 1 / 12  # of the larger side of all surfaces
FLATTEST = 0.25  # height of the box over its width, where surfaces are flat


def show_place(
    surfaces: Iterable[TriSurface], place: Sequence[float], reach: float | None
) -> tuple[Content, tuple[float, ...]]:
    """
    Return what is around a place, and the box it is cut to.

    Parameters
    ----------
    surfaces : iterable of TriSurface
        Those that the close-up does not meet are left out.
    place : (easting, northing, elevation)
        World coordinates [m].
    reach : float or None
        How far the close-up goes to each side [m]; default: a twelfth of all that is there.

    Returns
    -------
    content : Content
    box : (west, east, south, north, bottom, top)
        [m]

    Raises
    ------
    InputError
        If the place or the reach is no place or reach.
    """
    x, y, z = _checked(place, reach)
    how = "give a list of TriSurface, as in scene.surfaces"
    given = listed(surfaces, "render_place takes surfaces", how)
    for surface in given:
        expect(surface, TriSurface, "render_place takes surfaces", how)
    surfaces = [surface for surface in given if surface.n_triangle]
    if reach is None:
        bounds = np.array([surface.bounds for surface in surfaces] or [(x, x, y, y, z, z)])
        sides = bounds[:, 1:4:2].max(axis=0) - bounds[:, 0:4:2].min(axis=0)
        reach = max(float(sides.max()) * REACH, 1.0)
    low = np.array([x - reach, y - reach, z - reach])
    high = np.array([x + reach, y + reach, z + reach])
    near = [cut for surface in surfaces if (cut := _cut(surface, low, high)).n_triangle]
    if near:
        bottom = min(min(cut.bounds[4] for cut in near), z - FLATTEST * reach)
        top = max(max(cut.bounds[5] for cut in near), z + FLATTEST * reach)
        low[2], high[2] = bottom, top
    mark = _mark(np.array([x, y, z]), low, high)
    label = f"({x:.1f}, {y:.1f}, {z:.1f})"
    content = show_surfaces(near) + Content(
        (mark,), (Entry("the place", palette.ACCENT, label, "line"),)
    )
    w, s, b, e, n, t = (*low.tolist(), *high.tolist())
    return content, (w, e, s, n, b, t)


def _checked(place: Sequence[float], reach: float | None) -> tuple[float, float, float]:
    try:
        values = real_numbers(place)
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise InputError(
            f"place is {place!r}, expected three finite numbers: easting, northing, elevation [m]."
        )
    if reach is not None and not (is_number(reach) and reach > 0):
        raise InputError(f"reach is {reach!r}, expected metres above 0; leave it out for a choice.")
    x, y, z = values.tolist()
    return x, y, z


def _mark(place: np.ndarray, low: np.ndarray, high: np.ndarray) -> Layer:
    """Three lines through a place, each a third as long as the box."""
    arm = np.diag((high - low) / 6.0)
    points = np.concatenate([place - arm, place + arm])
    lines = np.array([[0, 3], [1, 4], [2, 5]])
    return Layer(points, lines=lines, colour=palette.ACCENT, width=4.0)


def _cut(surface: TriSurface, low: np.ndarray, high: np.ndarray) -> TriSurface:
    """The part of a surface in a box; for pictures, in floats."""
    corners = surface.vertices[surface.triangles]
    lowest, highest = corners.min(axis=1), corners.max(axis=1)
    whole = (lowest >= low).all(axis=1) & (highest <= high).all(axis=1)
    across = ~whole & (highest >= low).all(axis=1) & (lowest <= high).all(axis=1)
    parts = [corners[whole]]
    for corner in corners[across]:
        ring = _clip_ring(list(corner), low, high)
        parts += [np.array([[ring[0], p, q]]) for p, q in itertools.pairwise(ring[1:])]
    points = np.concatenate(parts).reshape(-1, 3)
    vertices, number = np.unique(points, axis=0, return_inverse=True)
    return TriSurface(surface.name, surface.role, vertices, number.reshape(-1, 3))


def _clip_ring(ring: list[np.ndarray], low: np.ndarray, high: np.ndarray) -> list[np.ndarray]:
    """A convex polygon cut to a box, side by side (Sutherland & Hodgman 1974)."""
    for axis, sign in itertools.product(range(3), (1.0, -1.0)):
        limit = float((high if sign > 0 else low)[axis])
        kept = []
        for p, q in zip(ring, ring[1:] + ring[:1], strict=True):
            one, two = sign * (p[axis] - limit), sign * (q[axis] - limit)
            if one <= 0:
                kept.append(p)
            if one * two < 0:
                kept.append(_crossing(p, q, axis, limit))
        ring = kept
    return ring


def _crossing(p: np.ndarray, q: np.ndarray, axis: int, limit: float) -> np.ndarray:
    """Where an edge leaves the box: bit for bit the same for both of its triangles."""
    a, b = sorted((p, q), key=tuple)
    point: np.ndarray = a + (limit - a[axis]) / (b[axis] - a[axis]) * (b - a)
    point[axis] = limit
    return point
