"""The open rim of a fault: one loop, taken apart into start, end, up and down.

At each edge of the rim, strike and the way up are those of the triangle there, so that traces may
bend and dips may change. Each edge has a measure of how well it faces along strike or along dip; of
all ways to cut the loop into end, up, start and down, in this order, the one is taken that suits
the edges best, by length. So grids, sticks and torn-off meshes are treated alike.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from geosurf.conventions import place
from geosurf.errors import SurfaceError
from geosurf.kernels.exact.predicates import flat_triangles, frame_of
from geosurf.kernels.lattices.sets import first_rows
from geosurf.kernels.meshes.mesh import edges, pieces, weld
from geosurf.model import TriSurface
from geosurf.model.surfaces import Content

FLAT = 0.05  # a plane flatter than this (3 degrees) has no strike of its own: it takes the mean's
AT_ONCE = 250_000  # entries of the table of cuts that are computed at once
KEPT = 128  # rims that are remembered: tears ask for those of the same faults again and again
_ORDER = ("end", "up", "start", "down")  # around the rim, counter-clockwise seen from the front


@dataclass(frozen=True)
class Axes:
    """Mean strike and way up of a fault, and which way its triangles face.

    Attributes
    ----------
    strike, up : ndarray of float64, shape (3,)
        Unit vectors in the mean plane; strike is horizontal, by the right-hand rule.
    sign : float
        +1 where normals point into the hanging wall (of a vertical fault: east, else north), -1
        where they point the other way.
    """

    strike: np.ndarray
    up: np.ndarray
    sign: float


@dataclass(frozen=True)
class Rim:
    """The outer rim of a fault.

    Attributes
    ----------
    loop : ndarray of int64, shape (n,)
        Vertices in order, as the triangles next to the rim run.
    arcs : dict of str to ndarray of int64
        Vertices of each side, in the same order; corners belong to two sides.
    axes : Axes
    """

    loop: np.ndarray
    arcs: dict[str, np.ndarray]
    axes: Axes

    def grown(self, side: str, edge: np.ndarray, arc: np.ndarray, new: np.ndarray) -> Rim:
        """The rim with new vertices that continue those of an arc, the part of an edge that led on.

        The edge is a side with its notches filled; its neighbours go on to the first and the last
        of the new vertices.
        """
        order = _ORDER if self.axes.sign > 0 else _ORDER[::-1]
        before, after = (order[(order.index(side) + k) % 4] for k in (-1, 1))
        arcs = dict(self.arcs)
        first, last = (int(np.flatnonzero(edge == arc[k])[0]) for k in (0, -1))
        arcs[before] = np.concatenate([arcs[before], edge[1 : first + 1], new[:1]])
        arcs[after] = np.concatenate([new[-1:], edge[last:-1], arcs[after]])
        arcs[side] = new
        return Rim(np.concatenate([arcs[one][:-1] for one in order]), arcs, self.axes)


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


def unit_rows(vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) of length one; zero stays zero (slivers whose normal is lost in floats)."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.maximum(length, np.finfo(float).tiny)


def mean_axes(normals: np.ndarray) -> Axes:
    """Mean strike and dip of triangles with these normals (n, 3), twice their area long."""
    mean = total(normals)
    unit = mean / max(float(np.linalg.norm(mean)), np.finfo(float).tiny)
    lead = next((c for c in (unit[2], unit[0], unit[1]) if abs(c) > 1e-6), 1.0)
    sign = 1.0 if lead > 0 else -1.0
    strike, up = plane_axes(sign * unit[None], np.array([1.0, 0.0, 0.0]), flat=1e-6)
    return Axes(strike[0], up[0], sign)


def plane_axes(
    units: np.ndarray, strike: np.ndarray, flat: float = FLAT
) -> tuple[np.ndarray, np.ndarray]:
    """Strike and way up (n, 3 each) of planes with unit normals; flat ones take a given strike.

    The way up, normal x strike, never points down, even where the fault is overturned.
    """
    strikes = np.stack([-units[:, 1], units[:, 0], np.zeros(len(units))], axis=1)
    level = np.linalg.norm(strikes, axis=1) < flat
    strikes[level] = strike - (units[level] @ strike)[:, None] * units[level]
    strikes /= np.linalg.norm(strikes, axis=1, keepdims=True)
    return strikes, np.cross(units, strikes)


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
        If the fault is in several pieces, or closed, its rim touches itself, its triangles do
        not agree about their front, or some have no area.

    Examples
    --------
    >>> corners = [[0, 0, 0], [0, 9, 0], [0, 9, 5], [0, 0, 5]]
    >>> rim = find_rim(TriSurface("F1", "fault", corners, [[0, 1, 2], [0, 2, 3]]))
    >>> rim.arcs["up"].tolist(), rim.arcs["start"].tolist()
    ([2, 3], [3, 0])
    """
    rims = _own_rims(Content(surface))
    if len(rims) > 1:
        raise SurfaceError(
            f"fault {surface.name!r} is in {len(rims)} pieces, one of them at "
            f"{place(surface.vertices[rims[1].loop[0]])}: its rim is not one line. Give each "
            "piece as a fault of its own: gs.split_fault(fault) returns them by name."
        )
    return rims[0]


@lru_cache(maxsize=KEPT)
def _own_rims(content: Content) -> tuple[Rim, ...]:
    """The rims of a fault by its own axes."""
    rims = tuple(find_rims(content.surface))
    for rim in rims:
        for array in (rim.loop, *rim.arcs.values()):
            array.flags.writeable = False
    return rims


def find_rims(surface: TriSurface) -> list[Rim]:
    """Find the outer rim of each connected piece of a fault, the largest piece first."""
    x, name = surface.vertices, surface.name

    # vertices at one place count as one: the lowest number stands for all of them
    number, count = weld(x)
    t = first_rows(number, count)[number][surface.triangles]
    _refuse_flat(t, x, name)
    _refuse_clash(t, x, name)

    # pieces connected over edges; each has a rim of its own
    piece, n_piece = pieces(t, edges(t, len(x))[0])
    rims = [_outer_rim(x, t[piece == p], name) for p in range(n_piece)]
    area = [math.fsum(np.linalg.norm(normals_of(x[t[piece == p]]), axis=1)) for p in range(n_piece)]
    low = [tuple(x[rim.loop].min(axis=0)) for rim in rims]
    return [rims[p] for p in sorted(range(n_piece), key=lambda p: (-area[p], low[p]))]


def _outer_rim(x: np.ndarray, t: np.ndarray, name: str) -> Rim:
    """The rim of one piece: of its loops the longest one."""
    ring, _ = edges(t, len(x))
    loops = _loops(t, np.flatnonzero(ring == np.arange(len(ring))), x, name)
    if not loops:
        where = place(x[t[0, 0]])
        raise SurfaceError(f"fault {name!r} is closed at {where}: it has no rim. Cut it open.")

    # holes have shorter rims; between equal ones the lowest half-edge decides
    loop = max(loops, key=lambda line: (math.fsum(_steps(x[t[line // 3, line % 3]])), -line.min()))
    normals = normals_of(x[t])
    return _parted(x, t, loop, normals, mean_axes(normals))


def _refuse_flat(t: np.ndarray, x: np.ndarray, name: str) -> None:
    """Refuse triangles without area: they have neither strike nor dip."""
    flat = flat_triangles(x, t, *frame_of(x))
    if len(flat):
        raise SurfaceError(
            f"fault {name!r}: {len(flat)} of {len(t)} triangles have no area, the first is "
            f"triangle {flat[0]} at {place(x[t[flat[0], 0]])}. Remove them from the fault."
        )


def _refuse_clash(t: np.ndarray, x: np.ndarray, name: str) -> None:
    """Refuse triangles that run along an edge the same way as their neighbour."""
    start, end = t.ravel(), np.roll(t, -1, axis=1).ravel()
    _, first, times = np.unique(start * len(x) + end, return_index=True, return_counts=True)
    if (times > 1).any():
        where = place(x[start[first[times > 1][0]]])
        raise SurfaceError(
            f"fault {name!r}: its triangles do not agree about their front at {where}. Pass it "
            "through triangulate_fault, which turns them."
        )


def _loops(t: np.ndarray, half: np.ndarray, x: np.ndarray, name: str) -> list[np.ndarray]:
    """Closed lines of half-edges with one triangle."""
    # half-edge 3 * triangle + corner runs from that corner to the next one
    start, end = t[half // 3, half % 3], t[half // 3, (half + 1) % 3]
    values, times = np.unique(start, return_counts=True)
    if (times > 1).any():
        raise SurfaceError(
            f"fault {name!r}: its rim touches itself at {place(x[values[times > 1][0]])}. Remove "
            "the triangle that hangs on there by one corner."
        )
    following = dict(
        zip(start.tolist(), zip(end.tolist(), half.tolist(), strict=True), strict=True)
    )

    # follow the rim from its lowest vertex; each vertex has one way on
    loops = []
    while following:
        at, line = min(following), []
        while at in following:
            at, edge = following.pop(at)
            line.append(edge)
        loops.append(np.array(line, dtype=np.int64))
    return loops


def _steps(line: np.ndarray) -> np.ndarray:
    """Length of each step of a closed line (n, 3)."""
    return np.linalg.norm(np.roll(line, -1, axis=0) - line, axis=1)


def _parted(x: np.ndarray, t: np.ndarray, loop: np.ndarray, normals: np.ndarray, axes: Axes) -> Rim:
    """Cut a loop of half-edges into the four sides that suit its edges best."""
    # turned so that the loop is counter-clockwise as seen against `sign * normal`, whichever way
    # the triangles face
    if axes.sign < 0:
        loop = loop[::-1]
    # from the least vertex, so that the order of vertices and triangles is not seen
    ends = np.stack([t[loop // 3, loop % 3], t[loop // 3, (loop + 1) % 3]], axis=1)
    ends = ends if axes.sign > 0 else ends[:, ::-1]
    shift = -int(np.lexsort(x[ends[:, 0]].T[::-1])[0])
    loop, ends = np.roll(loop, shift), np.roll(ends, shift, axis=0)
    units = axes.sign * normals[loop // 3]
    units = unit_rows(units)
    strike, up = plane_axes(units, axes.strike)
    outward = np.cross(x[ends[:, 1]] - x[ends[:, 0]], units)  # as long as the edge
    to_end, to_up = (outward * strike).sum(axis=1), (outward * up).sum(axis=1)

    # gain of each edge for each side: how far it looks towards it, times its length
    cuts = _best_cuts(np.stack([to_end, to_up, -to_end, -to_up]))
    n = len(loop)
    arcs = {}
    for side, a, b in zip(_ORDER, cuts, [*cuts[1:], cuts[0] + n], strict=True):
        arc = ends[(a + np.arange(b - a + 1)) % n, 0]
        arcs[side] = arc if axes.sign > 0 else arc[::-1]
    line = ends[:, 0]
    return Rim(line if axes.sign > 0 else line[::-1], arcs, axes)


def _best_cuts(gain: np.ndarray) -> list[int]:
    """Where to cut a ring of n edges into four runs, so that their summed gains (4, n) are largest.

    For each place of the first cut, the others follow from running maxima.
    """
    n = gain.shape[1]

    # cumulated twice around, so that runs may pass the start
    sums = np.concatenate([np.zeros((4, 1)), np.cumsum(np.tile(gain, 2), axis=1)], axis=1)
    steps = sums[:-1] - sums[1:]  # what moving a cut by one edge is worth: run k instead of k + 1
    best, cuts = -np.inf, [0, 0, 0, 0]

    # dynamic programming over the three later cuts: O(n) for each start, O(n^2) in all; some
    # starts at a time, a row for each
    ahead = np.arange(n + 1)
    many = max(1, AT_ONCE // (n + 1))
    for first in range(0, n, many):
        starts = np.arange(first, min(first + many, n))
        at = starts[:, None] + ahead
        value = steps[0, at]
        back = []
        for k in range(3):
            top = np.maximum.accumulate(value, axis=1)

            # the first place where a maximum is reached, so that ties are decided the same way
            # always
            rise = np.ones(top.shape, dtype=bool)
            rise[:, 1:] = top[:, 1:] > top[:, :-1]
            back.append(np.maximum.accumulate(np.where(rise, ahead, 0), axis=1))
            value = top + (steps[k + 1, at] if k < 2 else sums[3, at])
        for row, worth in enumerate((value[:, n] - sums[0, starts]).tolist()):
            # ties up to rounding stay with the earliest start
            if worth > best + 1e-9 * abs(worth):
                third = int(back[2][row, n])
                second = int(back[1][row, third])
                a, first_cut = int(starts[row]), int(back[0][row, second])
                best, cuts = worth, [a, a + first_cut, a + second, a + third]
    return cuts


# ---- box exits ----------------------------------------
# Where rims and lines meet the model box, and leave it.


def rim_in_box(rim: Rim, x: np.ndarray, side: str, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether one side of a fault lies in a box, in part at least; it may be but a point."""
    line = x[rim.arcs[side]]
    return bool(segments_meet_box(line if len(line) > 1 else line[[0, 0]], low, high).any())


def segments_meet_box(line: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Whether each step of a line (n, 3) meets a closed box, bool (n - 1,).

    Clipped against the slabs of the box; rounding is on the side of meeting.
    """
    first, last = clip_steps(line, low, high)
    return first <= last + 1e-12


def clip_steps(line: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, ...]:
    """Where each step of a line (n, 3) enters and leaves a box, 0 to 1; in order if it meets it."""
    enter, leave = _slabs(line[:-1], np.diff(line, axis=0), low, high)
    return np.maximum(enter, 0.0), np.minimum(leave, 1.0)


def exits(start: np.ndarray, way: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Distance along rays (n, 3) to where they leave a box; NaN for those that miss it."""
    enter, leave = _slabs(start, way, low, high)
    return np.where((leave > 0) & (np.maximum(enter, 0.0) <= leave), leave, np.nan)


def _slabs(
    start: np.ndarray, direction: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where lines enter and leave a box's slabs (Kay & Kajiya 1986), in lengths of `direction`."""
    with np.errstate(divide="ignore", invalid="ignore"):
        s, e = (low - start) / direction, (high - start) / direction
    inside = (start >= low) & (start <= high)

    # no motion along an axis: inside its slab always, or never
    still = direction == 0
    enter = np.where(still, np.where(inside, -np.inf, np.inf), np.minimum(s, e))
    leave = np.where(still, np.where(inside, np.inf, -np.inf), np.maximum(s, e))
    return enter.max(axis=1), leave.min(axis=1)


# ---- lines ----------------------------------------
# Which way a fault goes on beyond its rim: along its last dip or strike line.
#
# Grids have these lines as columns and rows, sticks have dip lines; they are continued by their
# last step. Other meshes, and the strike of sticks, go on in the tangent plane at the rim:
# horizontally along strike, or straight up or down the dip, averaged along the rim. So a listric
# fault goes on with its last dip, and a curved trace with its last strike.


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

    def grown(self, side: str, arc: np.ndarray, ends: np.ndarray) -> Guides:
        """Guides with those of new vertices, the last of `ends` last, that continue an arc."""
        n, n_new = len(self.dip), int(ends[-1]) + 1 - len(self.dip)

        # number that the continuation of each old vertex gets; -1 for vertices that are not on the
        # arc
        new = np.full(n, -1, dtype=np.int64)
        new[arc] = ends
        by_strike = side in ("start", "end")

        # lines along the side's direction go on into the old vertex; lines across it are copied
        # from the arc, with the vertex before renumbered
        along, across = (self.strike, self.dip) if by_strike else (self.dip, self.strike)
        behind, lifted = np.full((2, n_new), -1, dtype=np.int64)
        behind[ends - n] = arc
        lifted[ends - n] = np.where(across[arc] >= 0, new[across[arc]], -1)
        along, across = np.concatenate([along, behind]), np.concatenate([across, lifted])
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
    arc_vertex = rank[t[near]][rows, corner]

    # one group of rows per arc vertex, in the order of the arc, summed exactly below (`total`), so
    # that the order of triangles has no effect
    order = np.argsort(arc_vertex, kind="stable")
    groups = np.split(rows[order], np.searchsorted(arc_vertex[order], np.arange(1, len(arc))))
    return np.array([total(normals[group]) for group in groups])


def _averaged(units: np.ndarray, line: np.ndarray, window: float) -> np.ndarray:
    """Unit vectors (n, 3) along a line, each the mean of those within a window."""
    step = np.linalg.norm(np.diff(line, axis=0), axis=1)

    # arc length of each vertex, and half of its two steps as its weight
    at, half_steps = np.r_[0.0, np.cumsum(step)], 0.5 * (np.r_[step, 0.0] + np.r_[0.0, step])
    out = np.empty_like(units)
    for i, here in enumerate(at):
        a, b = np.searchsorted(at, [here - window, here + window])

        # triangular window; searchsorted makes it local, so the cost is linear in the rim
        weight = half_steps[a:b] * (1.0 - np.abs(at[a:b] - here) / window)
        mean = total(weight[:, None] * units[a:b])

        # opposite directions may cancel: the vertex then has its own
        out[i] = mean if mean.any() else units[i]
    return out / np.linalg.norm(out, axis=1, keepdims=True)
