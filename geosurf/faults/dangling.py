"""Where faults end inside the model: their rims, as other faults have cut them.

A rim is walked in the arrangement of all faults (`RimWalk`), where other faults have split its
steps. A step is no open end if its triangle is to be dropped, or if it lies on another fault.
`dangling_ends` lists the ends that are left once a network is as proposed, `tips_of` those from
which virtual walls go on.
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
# Triangles and edges of an arrangement, by which virtual walls and faults are cut into pieces.


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
    half, next_half = pairs_of_equal(keys.ravel(), np.flatnonzero(~np.isin(keys, stops)))
    return join_pairs(np.stack([half // 3, next_half // 3], axis=1), len(keys))


def crossed_by(patches: Patches, name: str) -> set[str]:
    """Return the faults that cut a fault into pieces; one that it only ends at does not."""
    keys = edge_keys(patches, rows_of(patches, name))
    others = [source.name for source in patches.sources if source.name != name]
    piece = pieces_between(keys, edges_of(patches, others))
    crossing = set()
    for other in others:
        on_other = np.flatnonzero(np.isin(keys, edges_of(patches, [other])))
        half, next_half = pairs_of_equal(keys.ravel(), on_other)
        if (piece[half // 3] != piece[next_half // 3]).any():
            crossing.add(other)
    return crossing


def met_by(patches: Patches, surface: TriSurface) -> set[str]:
    """Return the faults that a fault meets along a line: it crosses them, or ends at them."""
    source = patches.surface_of_triangle
    keys = edge_keys(patches, np.arange(patches.n_triangle))
    shared = np.isin(keys, keys[source == patches.names.index(surface.name)]).any(axis=1)
    return {patches.names[i] for i in np.unique(source[shared])} - {surface.name}


# ---- rims ----------------------------------------


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
class NotOpen:
    """What is no open end of a fault: triangles to drop (bool), and edges on other faults.

    Edges are numbers, lower vertex times number of vertices plus higher vertex.
    """

    triangles: np.ndarray
    edges: np.ndarray


class RimWalk:
    """The rim of a fault in the arrangement, step by step."""

    def __init__(self, patches: Patches, fault: Fault, not_open: NotOpen) -> None:
        self.x, n_vertex = patches.vertices, len(patches.local)
        t = patches.triangles[fault.rows]

        # a half-edge that is its own successor around its edge has one triangle: the rim as cut
        ring, _ = edges(t, n_vertex)
        half = np.flatnonzero(ring == np.arange(len(ring)))
        start, end = t[half // 3, half % 3], t[half // 3, (half + 1) % 3]
        on_other_fault = np.isin(mesh.edge_keys(t, n_vertex)[half], not_open.edges)
        is_open = ~(not_open.triangles[half // 3] | on_other_fault)

        # from each rim vertex to the next: one step, since rims that touch themselves are refused
        steps = zip(end.tolist(), is_open.tolist(), strict=True)
        self.step_from = dict(zip(start.tolist(), steps, strict=True))

        # arcs come from the input, vertices from the arrangement: equal coordinates link them, as
        # vertices of the input stay bit for bit
        places = map(tuple, self.x[start].tolist())
        self.vertex_at = dict(zip(places, start.tolist(), strict=True))

    def along(self, arc: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points (n, 3) along an arc of rim vertices, where they are on it, which steps are open.

        Places on the arc are counted in its vertices: 1.5 is half way from the second on.
        """
        vertex = self.vertex_at[tuple(arc[0].tolist())]
        points, places, are_open = [arc[0]], [0.0], []
        for i, (a, b) in enumerate(pairwise(arc)):
            length = float(np.linalg.norm(b - a))
            last = self.vertex_at[tuple(b.tolist())]

            # other faults may have split this step: go on to its far end, one part at a time
            while True:
                vertex, is_open = self.step_from[vertex]
                are_open.append(is_open)
                points.append(self.x[vertex])
                if vertex == last:
                    break
                places.append(i + min(1.0, float(np.linalg.norm(self.x[vertex] - a)) / length))
            places.append(i + 1.0)
        return np.array(points), np.array(places), np.array(are_open)


# ---- dangling ends ----------------------------------------


# longest way to the model box, as a share of a fault's own length that way, on which it is extended
LONGEST_EXTENSION = {"start": 0.25, "end": 0.25, "up": 1.0, "down": 1.0}


def dangling_ends(
    patches: Patches,
    faults: Sequence[Fault],
    not_open: Mapping[str, NotOpen],
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
    not_open : mapping of str to NotOpen
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
            place = tuple(fault.surface.vertices[0].tolist())
            reason = f"its ends are unknown: {fault.unknown}"
            rows.append(
                NetworkRow("dangling end", fault.name, "", "", 0.0, 0.0, place, "leave", "", reason)
            )
            continue
        walk = RimWalk(patches, fault, not_open[fault.name])
        for k, rim in enumerate(fault.rims):
            for side in SIDES:
                if k > 0 or (fault.name, side) not in near:
                    row = _open_end(fault, rim, side, walk, box)
                    rows += [row] if row is not None else []
    return rows


def _open_end(
    fault: Fault, rim: Rim, side: str, walk: RimWalk, box: np.ndarray
) -> NetworkRow | None:
    """The row of one side, if something of it ends in the model box."""
    x, t, arc = fault.surface.vertices, fault.surface.triangles, rim.arcs[side]
    low, high = box[::2], box[1::2]
    if len(arc) < 2 or not rim_in_box(rim, x, side, low, high):
        return None

    # directions are known at vertices of the arc; points of cuts in between take interpolated ones
    points, places, are_open = walk.along(x[arc])
    at_arc = directions(x, t, arc, side, rim.axes, guides_of(fault.surface))
    at_points = np.stack(
        [np.interp(places, np.arange(len(arc)), column) for column in at_arc.T], axis=1
    )
    start, direction = _open_in_box(points, unit_rows(at_points), are_open, low, high)
    to_box = exits(start, direction, low, high)

    # the longest way to the box; rays that miss it have none
    hits = np.flatnonzero(np.isfinite(to_box))
    if len(hits) == 0:
        return None
    farthest, length = float(to_box[hits].max()), _length_towards(fault, rim, side)

    # within its own length, a fault can be extended with some trust in its last direction; along
    # strike the limit is stricter than along dip
    extend = farthest <= LONGEST_EXTENSION[side] * length and len(fault.rims) == 1
    reason = f"{farthest:.0f} m to the side of the model box, its own length is {length:.0f} m"
    if len(fault.rims) > 1:
        reason += f"; one of {len(fault.rims)} pieces"
    place = tuple(start[hits[len(hits) // 2]].tolist())
    proposal = "extend" if extend else "leave"
    return NetworkRow(
        "dangling end", fault.name, "", side, 0.0, farthest, place, proposal, "", reason
    )


def _open_in_box(
    line: np.ndarray, direction: np.ndarray, are_open: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) on the open steps of a line in a box, and directions there.

    Vertices may all lie outside: those of a fault of two triangles are above and below the box.
    """
    enters, leaves = clip_steps(line, low, high)

    # each step that is partly inside counts by its two ends and its middle, so that long steps of
    # coarse faults are not seen at their ends alone
    step = np.flatnonzero((enters <= leaves) & are_open)
    middle = 0.5 * (enters[step] + leaves[step])
    share = np.stack([enters[step], middle, leaves[step]], axis=1).ravel()[:, None]
    step = np.repeat(step, 3)
    points = np.clip(line[step] + share * (line[step + 1] - line[step]), low, high)
    return points, unit_rows(direction[step] + share * (direction[step + 1] - direction[step]))


def _length_towards(fault: Fault, rim: Rim, side: str) -> float:
    """Mean length of a fault along strike, or its mean width along dip [m]."""
    x = fault.surface.vertices
    sides = ("up", "down") if side in ("start", "end") else ("start", "end")
    lines = [np.diff(x[rim.arcs[key]], axis=0) for key in sides]
    return 0.5 * sum(float(np.linalg.norm(line, axis=1).sum()) for line in lines)


# ---- tips ----------------------------------------
# Lines of rims off all other faults, inside the model: from here virtual walls go on.


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
        rounding = 4.0 * float(np.spacing(np.abs(self.outline).max()))

        # distance on the map to the nearest point of each side of the outline
        corner = self.outline
        along = np.roll(corner, -1, axis=0) - corner
        offset = points[:, None, :2] - corner
        share = np.clip((offset * along).sum(axis=2) / (along**2).sum(axis=1), 0.0, 1.0)
        distance = np.hypot(*(offset - share[..., None] * along).transpose(2, 0, 1)).min(axis=1)
        on_map = in_ring(points, self.outline) & (distance > rounding)
        return on_map & (z > self.bottom) & (z < self.top)


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
    row_of_surface = patches.names.index(surface.name)
    is_other = patches.surface_of_triangle != row_of_surface
    edges_of_others = np.unique(edge_keys(patches, np.flatnonzero(is_other)))

    # the rim as other faults have cut it, step by step: on one of them it is no tip
    rows = np.flatnonzero(~is_other)
    rims = find_rims(surface)
    not_open = NotOpen(np.zeros(len(rows), dtype=bool), edges_of_others)
    walk = RimWalk(patches, Fault(surface, rows, rims, 0.0), not_open)

    # vertices as the arrangement has them: rounding may have moved some by a hair
    x = patches.sources[row_of_surface].vertices
    return [
        (rim, {side: _tip(x[rim.arcs[side]], rim.arcs[side], walk, model) for side in SIDES})
        for rim in rims
    ]


def _tip(x: np.ndarray, arc: np.ndarray, walk: RimWalk, model: Model) -> Tip:
    """One side, with what of it is open."""
    is_open = np.zeros(max(len(arc) - 1, 0), dtype=bool)
    dies = False
    for i, (a, b) in enumerate(pairwise(x)):
        points, _, are_open = walk.along(np.stack([a, b]))
        is_open[i] = are_open.any()
        for p, q in zip(points[:-1][are_open], points[1:][are_open], strict=True):
            dies = dies or bool(model.holds(p + _SAMPLES * (q - p)).any())
    return Tip(arc, is_open, dies)
