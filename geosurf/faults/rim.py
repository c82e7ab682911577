"""The open rim of a fault: one loop, taken apart into start, end, up and down.

Strike and the way up are those of the mean plane. The four corners are the points of
the rim that reach farthest along both; this works for grids, sticks and torn-off meshes
alike, and for traces that turn by less than half a circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError, SurfaceError
from geosurf.kernels.mesh import edges, pieces, weld
from geosurf.model import TriSurface

# a fault whose mean plane is flatter than this has no strike that its outline would show
_FLAT = 1e-6


@dataclass(frozen=True)
class Axes:
    """Mean strike (horizontal) and the way up in the mean plane, unit vectors (3,)."""

    strike: np.ndarray
    up: np.ndarray
    normal: np.ndarray


@dataclass(frozen=True)
class Rim:
    """The outer rim of a fault.

    Attributes
    ----------
    loop : ndarray of int64, shape (n,)
        Vertices in order, as the triangles beside the rim run.
    arcs : dict of str to ndarray of int64
        Vertices of each side, in the same order; corners belong to two sides.
    axes : Axes
    """

    loop: np.ndarray
    arcs: dict[str, np.ndarray]
    axes: Axes


def total(rows: np.ndarray) -> np.ndarray:
    """Sums of the columns of (n, k), exact before one rounding: any order gives the same bytes."""
    return np.array([math.fsum(column) for column in rows.T])


def normals_of(corners: np.ndarray) -> np.ndarray:
    """Normals (n, 3) of triangles (n, 3, 3), twice their area long; the same for turned corners."""
    # start each triangle at its least corner, so that turning it changes no bit
    n = len(corners)
    order = np.lexsort((*corners.reshape(-1, 3).T[::-1], np.repeat(np.arange(n), 3)))
    first = (order[::3] % 3)[:, None]
    a, b, c = (
        np.take_along_axis(corners, ((first + k) % 3)[:, :, None], axis=1)[:, 0] for k in range(3)
    )
    return np.cross(b - a, c - a)


def mean_axes(corners: np.ndarray) -> Axes:
    """Axes of the mean plane of triangles (n, 3, 3), whichever way they are turned.

    The mean normal is the main direction of the normals, weighted by area, so that triangles
    need not agree about their front.
    """
    normals = normals_of(corners)
    length = np.linalg.norm(normals, axis=1)
    weighted = normals / np.sqrt(np.maximum(length, np.finfo(float).tiny))[:, None]
    products = (weighted[:, :, None] * weighted[:, None, :]).reshape(-1, 9)
    normal = np.linalg.eigh(total(products).reshape(3, 3))[1][:, 2]
    lead = next((c for c in (normal[2], normal[0], normal[1]) if abs(c) > _FLAT), 1.0)
    normal = normal * np.sign(lead)
    strike = np.array([-normal[1], normal[0], 0.0])
    if np.linalg.norm(strike) < _FLAT:
        strike = np.array([1.0, 0.0, 0.0])
    strike = strike / np.linalg.norm(strike)
    up = np.cross(normal, strike)
    return Axes(strike, up * (1.0 if up[2] >= 0 else -1.0), normal)


def find_rim(surface: TriSurface) -> Rim:
    """Find the outer rim of a fault and its four sides.

    Parameters
    ----------
    surface : TriSurface
        One connected piece; holes are allowed.

    Returns
    -------
    Rim

    Raises
    ------
    SurfaceError
        If the fault is in several pieces, or closed, or its rim touches itself.

    Examples
    --------
    >>> corners = [[0, 0, 0], [0, 9, 0], [0, 9, 5], [0, 0, 5]]
    >>> rim = find_rim(TriSurface("F1", "fault", corners, [[0, 1, 2], [0, 2, 3]]))
    >>> rim.arcs["up"].tolist(), rim.arcs["start"].tolist()
    ([2, 3], [3, 0])
    """
    x = surface.vertices
    number, count = weld(x)
    first = np.full(count, -1, dtype=np.int64)
    first[number[::-1]] = np.arange(len(x))[::-1]
    t = first[number][surface.triangles]
    ring, _ = edges(t, len(x))
    piece, n_piece = pieces(t, ring)
    if n_piece > 1:
        other = x[t[np.flatnonzero(piece == 1)[0], 0]]
        raise SurfaceError(
            f"fault {surface.name!r} is in {n_piece} pieces, one of them at {place(other)}: its "
            "rim is not one line. Give each piece as a fault of its own."
        )
    axes = mean_axes(x[t])
    loops = _loops(t, ring, x, surface.name)
    if not loops:
        raise SurfaceError(f"fault {surface.name!r} is closed: it has no rim. Cut it open.")
    flat = np.stack([x @ axes.strike, x @ axes.up], axis=1)
    loop = max(loops, key=lambda line: abs(_area(flat[line])))
    return Rim(loop, _arcs(loop, flat[loop], x, surface.name), axes)


def _loops(t: np.ndarray, ring: np.ndarray, x: np.ndarray, name: str) -> list[np.ndarray]:
    """Closed lines of edges with one triangle."""
    half = np.flatnonzero(ring == np.arange(len(ring)))
    start, end = t[half // 3, half % 3], t[half // 3, (half + 1) % 3]
    values, times = np.unique(start, return_counts=True)
    if (times > 1).any():
        where = place(x[values[times > 1][0]])
        raise SurfaceError(
            f"fault {name!r}: its rim touches itself, or its triangles do not agree about their "
            f"front, at {where}. Remove the triangle that hangs on there by one corner."
        )
    onward = dict(zip(start.tolist(), end.tolist(), strict=True))
    loops = []
    while onward:
        line = [min(onward)]
        while onward.get(line[-1]) is not None:
            line.append(onward.pop(line[-1]))
        if line[0] != line[-1]:
            raise SurfaceError(
                f"fault {name!r}: its triangles do not agree about their front at "
                f"{place(x[line[-1]])}. Pass it through triangulate_fault, which turns them."
            )
        loops.append(np.array(line[:-1], dtype=np.int64))
    return loops


def _area(points: np.ndarray) -> float:
    """Signed area of a closed line (n, 2)."""
    u, v = (points - points.mean(axis=0)).T
    return 0.5 * float(u @ np.roll(v, -1) - v @ np.roll(u, -1))


def _arcs(loop: np.ndarray, flat: np.ndarray, x: np.ndarray, name: str) -> dict[str, np.ndarray]:
    """The sides of a loop, from its four corners."""
    middle, half = flat.min(axis=0) + 0.5 * np.ptp(flat, axis=0), 0.5 * np.ptp(flat, axis=0)
    u, v = ((flat - middle) / half).T
    tie = np.lexsort(x[loop].T[::-1]).argsort()
    at = {}
    for first, sign_u in (("start", -1.0), ("end", 1.0)):
        for second, sign_v in (("up", 1.0), ("down", -1.0)):
            reach = np.round(sign_u * u + sign_v * v, 9)
            at[first, second] = int(np.lexsort((tie, -reach))[0])
    ways = {
        "start": (at["start", "up"], at["start", "down"]),
        "down": (at["start", "down"], at["end", "down"]),
        "end": (at["end", "down"], at["end", "up"]),
        "up": (at["end", "up"], at["start", "up"]),
    }
    n = len(loop)
    if sum((b - a) % n for a, b in ways.values()) != n:
        ways = {side: (b, a) for side, (a, b) in ways.items()}
    if sum((b - a) % n for a, b in ways.values()) != n:
        raise GeometryError(
            f"fault {name!r}: its outline has no start, end, top and bottom in this order, "
            f"near {place(x[loop[at['start', 'up']]])}. Extend it by hand, or cut it into parts."
        )
    return {side: loop[(a + np.arange((b - a) % n + 1)) % n] for side, (a, b) in ways.items()}
