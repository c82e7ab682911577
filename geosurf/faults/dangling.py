"""Ends of faults inside the model box: what is left of them once a network is as proposed.

The rim of a fault is walked in the arrangement, where other faults have cut it: a step of it is
no end if its triangle is to be dropped, or if it lies on another fault.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.faults.distance import in_ring
from geosurf.faults.rim import (
    Rim,
    clip_steps,
    directions,
    exits,
    find_rims,
    guides_of,
    rim_in_box,
    unit_rows,
)
from geosurf.kernels.lattices.sets import pairs_of_equal
from geosurf.kernels.meshes import mesh
from geosurf.kernels.meshes.mesh import edges, join_pairs
from geosurf.model import Patches, TriSurface
from geosurf.model.expected import outline_of
from geosurf.model.network import SIDES, NetworkRow

# ---- edges ----------------------------------------
# Edges of arrangements, by which virtual walls and faults are cut into pieces.


def rows_of(patches: Patches, name: str) -> np.ndarray:
    """Triangles of a surface; none if the arrangement does not have it."""
    if name not in patches.names:
        return np.empty(0, dtype=np.int64)
    return np.flatnonzero(patches.surface_of_triangle == patches.names.index(name))


def edge_keys(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """A number for each edge of some triangles, int64 (n, 3)."""
    return mesh.edge_keys(patches.triangles[rows], len(patches.local)).reshape(-1, 3)


def edges_of(patches: Patches, names: Sequence[str]) -> np.ndarray:
    """Edges of some surfaces, each once."""
    rows = [rows_of(patches, name) for name in names]
    return np.unique(edge_keys(patches, np.concatenate([np.empty(0, dtype=np.int64), *rows])))


def areas_of(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """Area of some triangles [m2]."""
    a, b, c = (patches.local[patches.triangles[rows, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def pieces_between(keys: np.ndarray, stops: np.ndarray) -> np.ndarray:
    """Number the pieces of triangles, whose edges (n, 3) are given, between some edges."""
    one, two = pairs_of_equal(keys.ravel(), np.flatnonzero(~np.isin(keys, stops)))
    return join_pairs(np.stack([one // 3, two // 3], axis=1), len(keys))


def crossed_by(patches: Patches, name: str) -> set[str]:
    """Return the faults that cut a fault into pieces; one that it only ends at does not."""
    rows = rows_of(patches, name)
    keys = edge_keys(patches, rows)
    others = [one.name for one in patches.sources if one.name != name]
    piece = pieces_between(keys, edges_of(patches, others))
    found = set()
    for other in others:
        at = np.flatnonzero(np.isin(keys, edges_of(patches, [other])))
        one, two = pairs_of_equal(keys.ravel(), at)
        if (piece[one // 3] != piece[two // 3]).any():
            found.add(other)
    return found


SHORT = {"start": 0.25, "end": 0.25, "up": 1.0, "down": 1.0}  # of a fault's own length that way


@dataclass
class Fault:
    """One fault with its rows in the arrangement, its rims and its area [m2].

    A fault of which the rim cannot be found has none, and `unknown` is the reason.
    """

    surface: TriSurface
    rows: np.ndarray
    rims: list[Rim]
    area: float
    unknown: str = ""

    @property
    def name(self) -> str:
        """Name of the fault."""
        return self.surface.name


@dataclass
class Gone:
    """What is not an open end of a fault: triangles to drop (bool), and edges on other faults.

    Edges are numbers, lower vertex times number of vertices plus higher vertex.
    """

    triangles: np.ndarray
    edges: np.ndarray


def dangling_ends(
    patches: Patches,
    faults: Sequence[Fault],
    gone: Mapping[str, Gone],
    near: set[tuple[str, str]],
    box: np.ndarray,
) -> list[NetworkRow]:
    """
    Rows of the ends inside the model box that neither meet nor nearly meet a fault.

    Parameters
    ----------
    patches : Patches
        Of all faults.
    faults : sequence of Fault
    gone : mapping of str to Gone
        By fault.
    near : set of (str, str)
        Faults and their sides that nearly meet a fault, and have rows already.
    box : ndarray of float64, shape (6,)
        West, east, south, north, bottom, top [m].

    Returns
    -------
    list of NetworkRow
    """
    rows = []
    for fault in faults:
        if fault.unknown:
            at = tuple(fault.surface.vertices[0].tolist())
            words = f"its ends are unknown: {fault.unknown}"
            rows.append(
                NetworkRow("dangling end", fault.name, "", "", 0.0, 0.0, at, "leave", "", words)
            )
            continue
        walk = RimWalk(patches, fault, gone[fault.name])
        for k, rim in enumerate(fault.rims):
            for side in SIDES:
                if k > 0 or (fault.name, side) not in near:
                    row = _open_end(fault, rim, side, walk, box)
                    rows += [row] if row is not None else []
    return rows


class RimWalk:
    """The rim of a fault in the arrangement, step by step."""

    def __init__(self, patches: Patches, fault: Fault, gone: Gone) -> None:
        self.x, n = patches.vertices, len(patches.local)
        t = patches.triangles[fault.rows]

        # a half-edge that is its own successor around its edge has one triangle: the rim as cut
        ring, _ = edges(t, n)
        half = np.flatnonzero(ring == np.arange(len(ring)))
        start, end = t[half // 3, half % 3], t[half // 3, (half + 1) % 3]

        # steps that are no open end: on a part to drop, or on another fault
        lost = gone.triangles[half // 3] | np.isin(mesh.edge_keys(t, n)[half], gone.edges)

        # start -> (end, lost); a rim vertex has one way on, since rims that touch themselves are
        # refused
        self.onward = dict(
            zip(start.tolist(), zip(end.tolist(), lost.tolist(), strict=True), strict=True)
        )

        # arcs come from the input, vertices from the arrangement: equal coordinates link them, as
        # vertices of the input stay bit for bit
        places = map(tuple, self.x[start].tolist())
        self.at = dict(zip(places, start.tolist(), strict=True))

    def along(self, arc: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points (n, 3) along an arc of rim vertices, where they are on it, which steps stay.

        Places on the arc are counted in its vertices: 1.5 is half way from the second on.
        """
        at = self.at[tuple(arc[0].tolist())]
        points, places, stays = [arc[0]], [0.0], []
        for i, (a, b) in enumerate(pairwise(arc)):
            length = float(np.linalg.norm(b - a))
            last = self.at[tuple(b.tolist())]

            # other faults may have split this step: go on to its far end, one part at a time
            while True:
                at, lost = self.onward[at]
                stays.append(not lost)
                points.append(self.x[at])
                if at == last:
                    break
                places.append(i + min(1.0, float(np.linalg.norm(self.x[at] - a)) / length))
            places.append(i + 1.0)
        return np.array(points), np.array(places), np.array(stays)


def _open_end(
    fault: Fault, rim: Rim, side: str, walk: RimWalk, box: np.ndarray
) -> NetworkRow | None:
    """The row of one side, if something of it ends in the model box."""
    x, t, arc = fault.surface.vertices, fault.surface.triangles, rim.arcs[side]
    low, high = box[::2], box[1::2]
    if len(arc) < 2 or not rim_in_box(rim, x, side, low, high):
        return None

    # directions are known at vertices of the arc; points of cuts in between take interpolated ones
    points, places, stays = walk.along(x[arc])
    way = directions(x, t, arc, side, rim.axes, guides_of(fault.surface))
    of_point = np.stack(
        [np.interp(places, np.arange(len(arc)), column) for column in way.T], axis=1
    )
    start, way = _within(points, unit_rows(of_point), stays, low, high)
    inside = exits(start, way, low, high)

    # the longest way from the part inside to the box: NaN marks rays that miss it
    known = np.flatnonzero(np.isfinite(inside))
    if len(known) == 0:
        return None
    far, own = float(inside[known].max()), _own_length(fault, rim, side)

    # within its own length, a fault can be extended with some trust in its last direction; the
    # shares in SHORT make this stricter along strike than along dip
    short = far <= SHORT[side] * own and len(fault.rims) == 1
    reason = f"{far:.0f} m to the side of the model box, its own length is {own:.0f} m"
    if len(fault.rims) > 1:
        reason += f"; one of {len(fault.rims)} pieces"
    at = tuple(start[known[len(known) // 2]].tolist())
    proposal = "extend" if short else "leave"
    return NetworkRow("dangling end", fault.name, "", side, 0.0, far, at, proposal, "", reason)


def _within(
    line: np.ndarray, way: np.ndarray, stays: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The part of a line (n, 3) in a box, and directions along it: ends and middles of its steps.

    Vertices may all lie outside: those of a fault of two triangles are above and below the box.
    """
    a, b = clip_steps(line, low, high)

    # each step that is partly inside counts by its two ends and its middle, so that long steps of
    # coarse faults are not seen at their ends alone
    step = np.flatnonzero((a <= b) & stays)
    share = np.stack([a[step], 0.5 * (a[step] + b[step]), b[step]], axis=1).ravel()
    at, share = np.repeat(step, 3), share[:, None]
    points = np.clip(line[at] + share * (line[at + 1] - line[at]), low, high)
    return points, unit_rows(way[at] + share * (way[at + 1] - way[at]))


def _own_length(fault: Fault, rim: Rim, side: str) -> float:
    """Mean length of a fault along strike, or its mean width along dip [m]."""
    x = fault.surface.vertices
    one, two = ("up", "down") if side in ("start", "end") else ("start", "end")
    lines = [np.diff(x[rim.arcs[arc]], axis=0) for arc in (one, two)]
    return 0.5 * sum(float(np.linalg.norm(line, axis=1).sum()) for line in lines)


# ---- tips ----------------------------------------
# Ends of faults inside the model: lines of their rims off all other faults.


_SAMPLES = np.linspace(0.0, 1.0, 9)[:, None]  # of each step of a rim, where it is in the model


@dataclass(frozen=True)
class Model:
    """The space that is divided.

    Attributes
    ----------
    outline : ndarray of float64, shape (n, 2)
        Corners of the area on the map [m].
    bottom, top : float
        Elevations [m].
    margin : float
        How far beyond the model a wall goes on [m].
    """

    outline: np.ndarray
    bottom: float
    top: float
    margin: float

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) are inside, bool (n,).

        A fault that was cut at the outline ends on it, but for rounding: it does not die inside.
        """
        z = points[:, 2]
        a, b = self.outline, np.roll(self.outline, -1, axis=0)
        rounding = 4.0 * float(np.spacing(np.abs(self.outline).max()))

        on_map = in_ring(points, self.outline)
        way = b - a
        apart = points[:, None, :2] - a
        share = np.clip((apart * way).sum(axis=2) / (way**2).sum(axis=1), 0.0, 1.0)
        far = np.hypot(*(apart - share[..., None] * way).transpose(2, 0, 1)).min(axis=1)
        return on_map & (far > rounding) & (z > self.bottom) & (z < self.top)


@dataclass(frozen=True)
class Tip:
    """One side of one piece of a fault.

    Attributes
    ----------
    arc : ndarray of int64, shape (n,)
        Vertices of the side, as the triangles next to the rim run.
    open : ndarray of bool, shape (n - 1,)
        Steps off all other faults.
    dies : bool
        Whether some of these are inside the model.
    """

    arc: np.ndarray
    open: np.ndarray
    dies: bool


def model_of(box: Sequence[float], outline: np.ndarray | None) -> Model:
    """Return the space of a model: its box, or an area between its bottom and top."""
    w, e, s, n, bottom, top = box
    margin = 0.01 * float(np.linalg.norm([e - w, n - s, top - bottom]))
    return Model(outline_of(box, outline), bottom, top, margin)


def tips_of(
    patches: Patches, surface: TriSurface, model: Model
) -> list[tuple[Rim, dict[str, Tip]]]:
    """
    Return the rim of each piece of a fault, and its sides.

    Parameters
    ----------
    patches : Patches
        Of all faults of the model, in world coordinates.
    surface : TriSurface
        One of them.
    model : Model

    Raises
    ------
    SurfaceError
        If the rim of the fault touches itself, or its triangles do not agree about their front.
    """
    mine = patches.names.index(surface.name)
    others = patches.surface_of_triangle != mine
    keys = edge_keys(patches, np.flatnonzero(others))

    # the rim as other faults have cut it, step by step: on one of them it is no tip
    rows = np.flatnonzero(~others)
    rims = find_rims(surface)
    gone = Gone(np.zeros(len(rows), dtype=bool), np.unique(keys))
    walk = RimWalk(patches, Fault(surface, rows, rims, 0.0), gone)

    # vertices as the arrangement has them: rounding may have moved some by a hair
    x = patches.sources[mine].vertices
    return [
        (rim, {side: _tip(x[rim.arcs[side]], rim.arcs[side], walk, model) for side in SIDES})
        for rim in rims
    ]


def met_by(patches: Patches, surface: TriSurface) -> set[str]:
    """Return the faults that a fault meets along a line: it crosses them, or ends at them."""
    of = patches.surface_of_triangle
    keys = edge_keys(patches, np.arange(patches.n_triangle))
    shared = np.isin(keys, keys[of == patches.names.index(surface.name)]).any(axis=1)
    return {patches.names[i] for i in np.unique(of[shared])} - {surface.name}


def _tip(x: np.ndarray, arc: np.ndarray, walk: RimWalk, model: Model) -> Tip:
    """One side, with what of it is open."""
    is_open = np.zeros(max(len(arc) - 1, 0), dtype=bool)
    dies = False
    for i, (a, b) in enumerate(pairwise(x)):
        points, _, stays = walk.along(np.stack([a, b]))
        is_open[i] = stays.any()
        for p, q in zip(points[:-1][stays], points[1:][stays], strict=True):
            dies = dies or bool(model.holds(p + _SAMPLES * (q - p)).any())
    return Tip(arc, is_open, dies)
