"""Which way a fault goes on beyond its rim: along its last dip or strike line.

Grids have these lines as columns and rows, sticks have dip lines; they are continued by their last
step. Other meshes, and the strike of sticks, go on in the tangent plane at the rim: horizontally
along strike, or straight up or down the dip, averaged along the rim. So a listric fault goes on
with its last dip, and a curved trace with its last strike.
"""

from __future__ import annotations

import numpy as np

from geosurf.faults.rim import Axes, normals_of, plane_axes, total, unit_rows
from geosurf.model import TriSurface

STICK = "stick"  # vertex data of faults from sticks: which stick a vertex is on


class Guides:
    """For each vertex the one before it on its dip line and on its strike line, or -1.

    Only the ends of lines are needed, where "before" is the way back into the fault. `exact`
    distinguishes lines of a grid, which are intended, from sticks, which are picked.
    """

    def __init__(self, dip: np.ndarray, strike: np.ndarray, exact: bool = False) -> None:
        self.dip, self.strike, self.exact = dip, strike, exact

    def of(self, side: str) -> np.ndarray:
        """The guides that lead beyond one side."""
        return self.strike if side in ("start", "end") else self.dip

    def grown(self, side: str, arc: np.ndarray) -> Guides:
        """Guides with those of the vertices that continue an arc, in its order."""
        n = len(self.dip)

        # number that the continuation of each old vertex gets; -1 for vertices that are not on the
        # arc
        new = np.full(n, -1, dtype=np.int64)
        new[arc] = n + np.arange(len(arc))
        by_strike = side in ("start", "end")

        # lines along the side's direction go on into the old vertex; lines across it are copied
        # from the arc, with the vertex before renumbered
        along, across = (self.strike, self.dip) if by_strike else (self.dip, self.strike)
        lifted = np.where(across[arc] >= 0, new[across[arc]], -1)
        along, across = np.concatenate([along, arc]), np.concatenate([across, lifted])
        pair = (across, along) if by_strike else (along, across)
        return Guides(*pair, self.exact)


def guides_of(surface: TriSurface) -> Guides:
    """Dip and strike lines of a fault, where its grid or its sticks show them."""
    none = np.full(surface.n_vertex, -1, dtype=np.int64)
    lattice = surface.lattice
    if lattice is not None and lattice.present.all():
        # (n_row, n_col) vertex of each node; only first and last rows and columns have a way on
        number = lattice.vertex_of_node
        dip, strike = none, none.copy()
        dip[number[0]], dip[number[-1]] = number[1], number[-2]
        strike[number[:, 0]], strike[number[:, -1]] = number[:, 1], number[:, -2]
        return Guides(dip, strike, exact=True)
    if STICK in surface.vertex_data:
        stick = surface.vertex_data[STICK]

        # vertices of a stick follow each other: it starts where the one before is on another stick,
        # and ends where the one after is
        same = stick[1:] == stick[:-1]
        dip = none.copy()
        upper = np.flatnonzero(same & ~np.r_[False, same[:-1]])
        lower = np.flatnonzero(same & ~np.r_[same[1:], False]) + 1
        dip[upper], dip[lower] = upper + 1, lower - 1
        return Guides(dip, none)
    return Guides(none, none.copy())


def directions(
    x: np.ndarray,
    t: np.ndarray,
    arc: np.ndarray,
    side: str,
    axes: Axes,
    guides: Guides,
    window: float = 0.0,
) -> np.ndarray:
    """Unit vectors (n, 3) in which the vertices of one side go on.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3)
    t : ndarray of int64, shape (n_triangle, 3)
    arc : ndarray of int64, shape (n,)
        Vertices of that side, in order.
    side : {"start", "end", "up", "down"}
    axes : Axes
        Mean strike, for flat parts, and which way the triangles face.
    guides : Guides
    window : float
        Directions are averaged this far along the rim to both sides [m], with weights that
        fall off evenly, so that lines which go on as far do not cross for the noise of a mesh.
    """
    # normals turned so that all axes agree; the tangent of each side is in their plane
    units = unit_rows(axes.sign * _normals_at(x, t, arc))
    strike, up = plane_axes(units, axes.strike)
    tangent = {"start": -strike, "end": strike, "up": up, "down": -up}[side]

    # vertex before each one on its guide line, -1 where none; x[-1] is read there and not used
    before = guides.of(side)[arc]
    step = x[arc] - x[before]

    # a guide that leads back over the fault (a hooked stick) does not count
    known = (before >= 0) & ((step * tangent).sum(axis=1) > 0)
    way = np.where(known[:, None], step, tangent)
    way = unit_rows(way)
    return _averaged(way, x[arc], window) if window > 0.0 else way


def _normals_at(x: np.ndarray, t: np.ndarray, arc: np.ndarray) -> np.ndarray:
    """Summed normals of the triangles around some vertices (n, 3)."""
    # place of each vertex in the arc, -1 for others
    rank = np.full(len(x), -1, dtype=np.int64)
    rank[arc] = np.arange(len(arc))
    near = np.flatnonzero((rank[t] >= 0).any(axis=1))
    normals = normals_of(x[t[near]])
    rows, corner = np.nonzero(rank[t[near]] >= 0)
    of = rank[t[near]][rows, corner]

    # one group of rows per arc vertex, in the order of the arc, summed exactly below (`total`), so
    # that the order of triangles has no effect
    order = np.argsort(of, kind="stable")
    groups = np.split(rows[order], np.searchsorted(of[order], np.arange(1, len(arc))))
    return np.array([total(normals[group]) for group in groups])


def _averaged(units: np.ndarray, line: np.ndarray, window: float) -> np.ndarray:
    """Unit vectors (n, 3) along a line, each the mean of those within a window."""
    step = np.linalg.norm(np.diff(line, axis=0), axis=1)

    # arc length of each vertex, and half of its two steps as its weight
    at, own = np.r_[0.0, np.cumsum(step)], 0.5 * (np.r_[step, 0.0] + np.r_[0.0, step])
    out = np.empty_like(units)
    for i, here in enumerate(at):
        a, b = np.searchsorted(at, [here - window, here + window])

        # triangular window; searchsorted makes it local, so the cost is linear in the rim
        weight = own[a:b] * (1.0 - np.abs(at[a:b] - here) / window)
        mean = total(weight[:, None] * units[a:b])

        # opposite directions may cancel: the vertex then has its own
        out[i] = mean if mean.any() else units[i]
    return out / np.linalg.norm(out, axis=1, keepdims=True)
