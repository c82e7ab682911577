"""The virtual walls of all faults: above and below each, and from its tip lines to the next.

A wall follows the dip of its fault: the tip line moves along level lines to the target. Above and
below the fault it is vertical, up to the top and down to the base of the model.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from geosurf.arrangement.triangles import crossing_pairs
from geosurf.conventions import place
from geosurf.errors import GeometryError, InputError, SurfaceError
from geosurf.faults.dangling import Model, Tip, crossed_by, met_by, tips_of
from geosurf.faults.extend import strip
from geosurf.faults.joins import Join, Target, TipLine, join_to_boundary, joins_by_length
from geosurf.faults.rim import Rim, directions, guides_of
from geosurf.kernels.exact.predicates import flat_triangles, frame_of
from geosurf.kernels.lattices.sets import first_rows
from geosurf.kernels.meshes.mesh import weld
from geosurf.model import Patches, TriSurface
from geosurf.model.column import BOUNDARY, EITHER, ENDS, NEAREST, VirtualWall, virtual_name
from geosurf.model.excerpt import CloseUp

LEVELS = {"up": "top", "down": "base"}


@dataclass(frozen=True, eq=False)
class Wall:
    """The virtual wall of one fault, before it is cut at its targets.

    Attributes
    ----------
    fault : str
    surface : TriSurface
    strip_of_triangle : ndarray of int64, shape (n_triangle,)
        Part that each triangle belongs to: a row of `parts`.
    parts : tuple of VirtualWall
        Their areas are 0: the model has to be cut first.
    """

    fault: str
    surface: TriSurface
    strip_of_triangle: np.ndarray
    parts: tuple[VirtualWall, ...]


@dataclass
class _Draft:
    """A fault that gets a wall: its pieces, and the paths that are to be joined to a target.

    A path is (piece, side, vertices, whether it is a part of the tip line).
    """

    mesh: WallMesh
    pieces: list[tuple[Rim, dict[str, Tip]]]
    parts: list[VirtualWall]
    paths: list[tuple[int, str, np.ndarray, bool]]
    met: set[str]
    crossed: set[str]

    @property
    def name(self) -> str:
        """Of the fault."""
        return self.mesh.surface.name

    def is_free(self, piece: int, side: str) -> bool:
        """Whether no part of a side lies on another fault."""
        return bool(self.pieces[piece][1][side].open.all())

    def outward(self, piece: int, side: str) -> np.ndarray:
        """The way a side leads along strike, level (3,)."""
        surface, rim = self.mesh.surface, self.pieces[piece][0]
        x, t, arc = surface.vertices, surface.triangles, rim.arcs[side]
        out: np.ndarray = directions(x, t, arc, side, rim.axes, guides_of(surface)).sum(axis=0)
        out[2] = 0.0
        return out / np.linalg.norm(out)


def build_virtual_walls(
    patches: Patches,
    faults: Sequence[TriSurface],
    compartments: Mapping[str, Mapping[str, str]],
    model: Model,
) -> list[Wall]:
    """
    Return the virtual walls that continue some faults.

    Parameters
    ----------
    patches : Patches
        Of all faults, in world coordinates.
    faults : sequence of TriSurface
        The faults as they end in the model.
    compartments : mapping of str to mapping of str to str
        As from `read_compartments`.
    model : Model

    Returns
    -------
    list of Wall
        By name of the fault; faults that do not die in the model have none.

    Raises
    ------
    GeometryError
        If a wall would cross itself or its fault, or its target is at no elevation of the tip line.
    SurfaceError
        If the rim of a fault is not a line.
    """
    contacts = _contacts(patches, faults, model)
    first: dict[tuple[str, int], str] = {}
    # until each wall separates, if it can: each round, one more tip is joined elsewhere
    while True:
        drafts = {
            fault.name: _draft(patches, fault, model)
            for fault in sorted(faults, key=lambda one: one.name)
            if fault.name in compartments
        }
        targets = [_target(patches, fault, drafts.get(fault.name), model) for fault in faults]
        ways: dict[tuple[str, int], list[Join]] = {}  # of each tip line, the one that it took first
        done: set[frozenset[tuple[str, int, str] | None]] = set()
        for draft in drafts.values():
            wanted = _by_end(draft, compartments[draft.name])
            for k, path in enumerate(draft.paths):
                _, side, _, is_tip = path
                if is_tip and side not in wanted:
                    continue  # this end is to stay open
                joins = _joins_of(draft, path, wanted[side] if is_tip else NEAREST, targets, model)
                joins.sort(key=lambda join: join.target != first.get((draft.name, k)))
                taken = _join_path(draft, path, joins, model, done)
                if taken is not None and is_tip:
                    ways[draft.name, k] = joins[taken:]
        rejoined = _parting(ways, contacts, first)
        if rejoined is None:
            return [_finished(draft) for draft in drafts.values() if draft.mesh.strips]
        first.update([rejoined])


def _contacts(
    patches: Patches, faults: Sequence[TriSurface], model: Model
) -> list[tuple[str, str]]:
    """Which faults meet each other, and which leave the model."""
    pairs = [(fault.name, other) for fault in faults for other in sorted(met_by(patches, fault))]
    outside = [fault.name for fault in faults if not _on_map(fault.vertices, model).all()]
    return pairs + [(name, BOUNDARY) for name in outside]


def _parting(
    ways: Mapping[tuple[str, int], Sequence[Join]],
    contacts: Sequence[tuple[str, str]],
    known: Mapping[tuple[str, int], str],
) -> tuple[tuple[str, int], str] | None:
    """A tip line whose wall separates nothing, and where its wall would.

    A wall between two groups of faults that nothing else connects has the same space on both sides.
    A second join between the groups, or within one, costs least where it is little longer.
    """
    for (name, k), (taken, *_) in ways.items():
        rest = [(key[0], joins[0].target) for key, joins in ways.items() if key != (name, k)]
        group, beyond = (_connected_with(one, [*contacts, *rest]) for one in (name, taken.target))
        if taken.target in group:
            continue
        better = [
            (join.length - joins[0].length, key, join.target)
            for key, joins in ways.items()
            for join in joins[1:]
            if key not in known
            and (
                join.target in group
                if key == (name, k)
                else (key[0] in group and join.target in beyond)
                or (key[0] in beyond and join.target in group)
            )
        ]
        if better:
            return min(better)[1:]
    return None


def _connected_with(name: str, pairs: Sequence[tuple[str, str]]) -> set[str]:
    """What a name is connected with by some pairs, itself among it."""
    group, met = set[str](), {name}
    while group != met:
        group = met
        met = group | {one for pair in pairs if group & {*pair} for one in pair}
    return group


def _by_end(draft: _Draft, wanted: Mapping[str, str]) -> Mapping[str, str]:
    """Targets by end; an error where a fault with one target dies at both ends."""
    if EITHER not in wanted:
        return wanted
    dying = [(side, at) for _, side, at, is_tip in draft.paths if is_tip]
    if len({side for side, _ in dying}) > 1:
        name, word = draft.name, wanted[EITHER]
        at = {side: draft.mesh.x[path].mean(axis=0) for side, path in dying}
        raise InputError(
            f"fault {name!r} dies inside the model at both ends: its start is at "
            f"{place(at['start'])}, its end at {place(at['end'])}. State which is joined to "
            f"{word!r}: compartments={{{name!r}: {{'start': {word!r}, 'end': 'boundary'}}}}.",
            place=at["start"],
            surfaces=(name,),
        )
    return dict.fromkeys(ENDS, wanted[EITHER])


def _draft(patches: Patches, fault: TriSurface, model: Model) -> _Draft:
    """A fault with vertical strips above and below it, and the paths along strike that are open."""
    draft = _Draft(WallMesh(fault), tips_of(patches, fault, model), [], [], set(), set())
    draft.met = {fault.name} | met_by(patches, fault)
    draft.crossed = crossed_by(patches, fault.name)
    for k, (rim, tips) in enumerate(draft.pieces):
        copies: dict[str, dict[int, int]] = {"up": {}, "down": {}}
        for side, at in LEVELS.items():
            if tips[side].dies and len(tips[side].arc) > 1:
                copies[side] = _raised(draft, tips[side].arc, side, at, model)
        for side in ENDS:
            draft.paths += _paths(k, side, rim, tips[side], copies)
    return draft


def _raised(draft: _Draft, arc: np.ndarray, side: str, at: str, model: Model) -> dict[int, int]:
    """Add the vertical strip of one side; the copies of its first and its last vertex."""
    z = draft.mesh.x[arc, 2]
    up = side == "up"
    level = max(model.top, z.max()) + model.margin if up else min(model.bottom, z.min())
    level = level if up else level - model.margin
    made = draft.mesh.raise_to(arc, float(level))

    # how far the fault ends from the top or base of the model, where it is in the model
    away = model.top - z if up else z - model.bottom
    away = np.where(model.holds(draft.mesh.x[arc]), away, -np.inf)
    far = int(away.argmax())
    length = max(float(away[far]), 0.0)
    spot = tuple(draft.mesh.x[arc[far]].tolist())
    draft.parts.append(VirtualWall(draft.name, side, at, length, 0.0, spot))
    return dict(zip(arc[[0, -1]].tolist(), made.tolist(), strict=True))


def _paths(
    k: int, side: str, rim: Rim, tip: Tip, copies: Mapping[str, Mapping[int, int]]
) -> Iterator[tuple[int, str, np.ndarray, bool]]:
    """The open runs of one side, with the vertical lines above and below it."""
    # around the rim, the side comes after the one above or below it, as the triangles face
    first, last = ("up", "down") if (side == "start") == (rim.axes.sign > 0) else ("down", "up")
    arc, is_open = tip.arc.tolist(), tip.open.tolist()
    free = [tip.dies and step for step in is_open]
    if arc and arc[0] in copies[first]:
        arc, free = [copies[first][arc[0]], *arc], [None, *free]
    if arc and arc[-1] in copies[last]:
        arc, free = [*arc, copies[last][arc[-1]]], [*free, None]

    # steps of the tip line and vertical ones next to them are one run
    for closed, run in groupby(range(len(free)), key=lambda i: free[i] is False):
        steps = list(run)
        if not closed:
            ends = any(free[i] for i in steps)
            yield k, side, np.array([arc[i] for i in [*steps, steps[-1] + 1]]), ends


def _target(patches: Patches, fault: TriSurface, draft: _Draft | None, model: Model) -> Target:
    """A fault as walls end at it."""
    x, t = fault.vertices, fault.triangles
    if draft is None:
        return Target(fault.name, x[t], tuple(_bare_tips(patches, fault, model)))
    tips = [
        TipLine(draft.name, piece, side, draft.mesh.x[path])
        for piece, side, path, is_tip in draft.paths
        if is_tip and draft.is_free(piece, side)
    ]
    triangles = np.concatenate([t, *draft.mesh.strips])
    return Target(fault.name, draft.mesh.x[triangles], tuple(tips))


def _bare_tips(patches: Patches, fault: TriSurface, model: Model) -> Iterator[TipLine]:
    """Where a fault without a wall of its own dies."""
    try:
        pieces = tips_of(patches, fault, model)
    except SurfaceError:
        return  # its rim is unknown: walls may end at it all the same
    for k, (_, tips) in enumerate(pieces):
        for side in ENDS:
            if tips[side].dies and tips[side].open.all():
                yield TipLine(fault.name, k, side, fault.vertices[tips[side].arc])


def _join_path(
    draft: _Draft,
    path: tuple[int, str, np.ndarray, bool],
    joins: Sequence[Join],
    model: Model,
    done: set[frozenset[tuple[str, int, str] | None]],
) -> int | None:
    """Join one path to the first target that does; its number, None if no wall is needed."""
    piece, side, at, is_tip = path
    line = draft.mesh.x[at]
    if not is_tip:  # a part of the wall above or below, up to the fault at which its fault ends
        level = "up" if line[:, 2].max() > model.top else "down"
        for join in joins[:1]:
            if join.goes_on and _leads_out(draft, piece, level, at, join):
                draft.mesh.join(at, join, model.margin)
                draft.parts.append(_part(draft, level, join, LEVELS[level]))
        return None

    # the shortest that does not lead back through the fault itself: of that one, another end
    for k, join in enumerate(joins):
        if not join.goes_on:  # the fault ends exactly there already
            return None
        tip = join.facing
        pair: frozenset[tuple[str, int, str] | None] = frozenset(
            {(draft.name, piece, side), None if tip is None else tip.key}
        )
        if pair in done:
            return k
        if tip is None:
            # a tip that touches its target may run along it, on either side: no nearest point of
            # the target says where to go on
            outward = draft.outward(piece, side) if join.touches else None
            draft.mesh.join(at, join, model.margin, outward)
        else:
            draft.mesh.join_tip(at, tip.line)
        # a fault that dies beyond the one that it crosses, and is to end there, needs no wall
        other = k + 1 < len(joins) or join.target in draft.crossed
        if other and draft.mesh.crosses_itself:
            draft.mesh.undo()
            continue
        if tip is not None:
            done.add(pair)
        draft.parts.append(_part(draft, side, join, join.target))
        return k
    return None


def _part(draft: _Draft, side: str, join: Join, target: str) -> VirtualWall:
    """What is known of a part of a wall before it is cut."""
    facing = "" if join.facing is None or side not in ENDS else join.facing.side
    place = tuple(join.place.tolist())
    return VirtualWall(draft.name, side, target, join.length, 0.0, place, facing)


def _joins_of(
    draft: _Draft,
    path: tuple[int, str, np.ndarray, bool],
    word: str,
    targets: Sequence[Target],
    model: Model,
) -> list[Join]:
    """The joins of a line to the fault or boundary that is wanted, the shortest first."""
    piece, side, at, is_tip = path
    line = draft.mesh.x[at]
    inside = model.holds(line)
    if not inside.any() or not is_tip:  # only ends of lines are vertices, above and below
        inside = _on_map(line, model)
    boundary = join_to_boundary(line, inside, model.outline, BOUNDARY)
    if word == BOUNDARY:
        return [] if boundary is None else [boundary]
    if word != NEAREST:
        wanted = [target for target in targets if target.name == word]
        joins = joins_by_length(line, inside, wanted, None)
        if not joins and is_tip:
            middle = line[len(line) // 2]
            raise GeometryError(
                f"fault {draft.name!r} ends at {place(middle)}, and {word!r} is at none of the "
                f"elevations of that end. Name another target: compartments={{{draft.name!r}: "
                "'boundary'}.",
                place=middle,
                surfaces=(draft.name, word),
            )
        return joins

    # a tip goes to any fault or to the boundary; the vertical ends of a wall, and what is open of
    # a side that ends at a fault, to that one
    dies = is_tip and draft.is_free(piece, side)
    others = [
        target
        for target in targets
        if target.name != draft.name and (dies or target.name in draft.met)
    ]
    return joins_by_length(line, inside, others, boundary if dies else None)


def _leads_out(draft: _Draft, piece: int, level: str, at: np.ndarray, join: Join) -> bool:
    """Whether a join leads away from the wall above or below a fault, which else crosses it."""
    arc = draft.pieces[piece][0].arcs[level]
    x = draft.mesh.x
    corner, onward = (arc[0], arc[1]) if arc[0] in at else (arc[-1], arc[-2])
    out = (x[corner] - x[onward])[:2]
    way = (join.ends - x[at])[:, :2]
    return bool(np.nansum(way @ out) > 0)


def _on_map(line: np.ndarray, model: Model) -> np.ndarray:
    """Which vertices are inside the model on the map, whatever their elevation."""
    middle = line.copy()
    middle[:, 2] = 0.5 * (model.bottom + model.top)
    return model.holds(middle)


def _finished(draft: _Draft) -> Wall:
    """The wall of a fault, checked."""
    surface, strip = draft.mesh.finished()
    return Wall(draft.name, surface, strip, tuple(draft.parts))


_PARTING = 0.7  # cosine: lines of a wall that part by more than 45 degrees run parallel instead
_BEYOND = 0.5  # of the length of a join: how far a wall goes on, before it is cut at its target


class WallMesh:
    """The wall of one fault, strip by strip.

    Parameters
    ----------
    surface : TriSurface
        The fault; its vertices come first.
    """

    def __init__(self, surface: TriSurface) -> None:
        self.surface = surface
        self.x = np.array(surface.vertices)
        self.strips: list[np.ndarray] = []  # triangles, one array for each part of the wall

    def add(self, points: np.ndarray) -> np.ndarray:
        """Add vertices (n, 3); return their numbers."""
        first = len(self.x)
        self.x = np.concatenate([self.x, points])
        return np.arange(first, len(self.x))

    def raise_to(self, arc: np.ndarray, level: float) -> np.ndarray:
        """Add a vertical strip from an arc to a level; return the copies of its two ends.

        A vertex that the fault overhangs is left behind, with a triangle in the notch: the line
        above or below it would run through the fault.
        """
        notches: list[tuple[int, int, int]] = []
        while True:
            tops = self.x[arc].copy()
            tops[:, 2] = level
            n = len(self.x)
            notch = np.array(notches, dtype=np.int64).reshape(-1, 3)
            self.strips.append(np.concatenate([notch, strip(arc, n, self.x[arc], tops)]))
            self.add(tops)
            crossing = self._crossings_at(arc[1:-1])
            if not crossing.any():
                return np.array([n, n + len(arc) - 1])
            # of neighbours only the one that crosses most, so that each notch is one triangle
            behind = np.zeros(len(arc), dtype=bool)
            for k in 1 + np.argsort(-crossing, kind="stable"):
                behind[k] = crossing[k - 1] > 0 and not (behind[k - 1] or behind[k + 1])
            notches += [(arc[k - 1], arc[k + 1], arc[k]) for k in np.flatnonzero(behind)]
            arc = arc[~behind]
            self.undo()

    def join(
        self, path: np.ndarray, join: Join, margin: float, outward: np.ndarray | None = None
    ) -> None:
        """Add a strip of level lines from a path to a target, and beyond it.

        All lines run to the nearest point of the target, or outward (3,) where that is given.
        """
        line = self.x[path]
        direction = join.ends - line
        length = np.linalg.norm(direction, axis=1)

        # where the target is missing, or touched, lines run as their neighbours do
        known = np.flatnonzero(length > 0)
        near = known[np.abs(np.arange(len(path))[:, None] - known).argmin(axis=1)]
        direction = (direction / np.where(length > 0, length, 1.0)[:, None])[near]
        length = length[near]

        # lines that part leave a gap between them: all run as the shortest does
        main = direction[int(length.argmin())]
        if outward is not None:
            ahead = direction @ outward
            length = np.where(ahead > 0, length / np.maximum(ahead, _PARTING), 0.0)
            direction = np.broadcast_to(outward, direction.shape)
        elif join.reach or (direction @ main).min() < _PARTING:
            direction = np.broadcast_to(main, direction.shape)
            length = np.full(len(length), max(join.reach, float(length.max())))
        far = line + direction * (length * (1.0 + _BEYOND) + margin)[:, None]
        far[:, 2] = line[:, 2]
        n = len(self.x)
        self.strips.append(strip(path, n, line, far))
        self.add(far)

    def undo(self) -> None:
        """Drop the strip that was added last; its vertices stay unused."""
        self.strips.pop()

    def join_tip(self, path: np.ndarray, tip: np.ndarray) -> None:
        """Add a strip between a path and the tip line of another fault (n, 3), vertex by vertex."""
        line = self.x[path]
        down = line[0, 2] > line[-1, 2]
        if (tip[0, 2] > tip[-1, 2]) != down:
            tip = tip[::-1]
        other = self.add(tip)
        triangles, i, k = [], 0, 0

        # down both lines: the next vertex is the one that is farther ahead
        while i + 1 < len(path) or k + 1 < len(other):
            first = k + 1 == len(other)
            if not first and i + 1 < len(path):
                p, q = line[i + 1], tip[k + 1]
                ahead = (p[2] > q[2]) == down if p[2] != q[2] else tuple(p) < tuple(q)
                first = bool(ahead)
            if first:
                triangles.append((path[i + 1], path[i], other[k]))
                i += 1
            else:
                triangles.append((path[i], other[k], other[k + 1]))
                k += 1
        self.strips.append(np.array(triangles, dtype=np.int64))

    def finished(self) -> tuple[TriSurface, np.ndarray]:
        """Return the wall, and the strip of each of its triangles.

        Raises
        ------
        GeometryError
            If the wall crosses itself or its fault.
        """
        t = np.concatenate(self.strips)
        strip_number = np.repeat(np.arange(len(self.strips)), [len(one) for one in self.strips])

        stays = self._with_area(t)
        t, strip_number = t[stays], strip_number[stays]
        used, number = np.unique(t, return_inverse=True)
        name = self.surface.name
        wall = TriSurface(virtual_name(name), "virtual", self.x[used], number.reshape(-1, 3))
        pairs, every = self._crossing(t)
        if len(pairs):
            at = self.x[every[pairs[0, 0]]].mean(axis=0)
            reach = float(np.ptp(self.x[every[pairs[0]]].reshape(-1, 3), axis=0).max())
            raise GeometryError(
                f"the virtual wall of fault {name!r} would cross itself or the fault near "
                f"{place(at)}. Name another target: compartments={{{name!r}: 'boundary'}}; or "
                f"smooth the ends of the fault: lengthen={{{name!r}: ...}}.",
                place=at,
                surfaces=(name,),
                close_up=CloseUp((self.surface, wall), reach),
            )
        return wall, strip_number

    def _crossings_at(self, vertices: np.ndarray) -> np.ndarray:
        """How often triangles of the wall at some vertices (n,) cross others, or the fault (n,)."""
        t = np.concatenate(self.strips)
        t = t[self._with_area(t)]
        pairs, _ = self._crossing(t)
        crossing = t[pairs[pairs < len(t)]]
        return (crossing[:, None, :] == vertices[None, :, None]).any(axis=2).sum(axis=0)

    @property
    def crosses_itself(self) -> bool:
        """Whether the wall as it is crosses itself or its fault, by exact signs."""
        t = np.concatenate(self.strips)
        return len(self._crossing(t[self._with_area(t)])[0]) > 0

    def _with_area(self, t: np.ndarray) -> np.ndarray:
        """Which triangles have an area: vertical steps of a rim make some that have none."""
        stays = np.ones(len(t), dtype=bool)
        stays[flat_triangles(self.x, t, *frame_of(self.x))] = False
        return stays

    def _crossing(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of triangles that cross, and the corners of all: of the wall, then of the fault."""
        # vertices at one place are one: tip lines of other faults may touch
        number, count = weld(self.x)
        first = first_rows(number, count)[number]
        mine, fault = first[t], first[self.surface.triangles]
        return crossing_pairs(self.x, mine, fault), np.concatenate([mine, fault])
