"""Find closures: what a horizon can hold beneath it, where that spills, and where faults leak.

What lies above a level in the rock below a horizon hangs together in parts. A part that reaches
neither the edge of the model nor a leak is closed; the level at which it first does, or meets
another part, is its spill level.

Triangles are linear, so parts change at vertices only, and edges of triangles show which parts
hang together: a merge tree (Carr, Snoeyink & Axen 2003, doi 10.1016/S0925-7721(02)00093-7). Each
vertex climbs to its highest neighbour; vertices that end at one summit are a basin; basins meet
along the highest edge between them, highest first. A summit of the floor of the rock is no trap:
it hangs together with the roof above it. No tolerance is involved; of equal elevations the vertex
that lies farther west (south) counts as the higher one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from geosurf.conventions import check_word, is_number, length_text, place
from geosurf.conventions.axes import COORDINATES, meaning
from geosurf.errors import GeosurfWarning, InputError
from geosurf.kernels.meshes.mesh import renumbered
from geosurf.kernels.search.columns import cross_columns
from geosurf.lazy import xarray
from geosurf.measure.cutoffs import level_of
from geosurf.measure.faces import row_of
from geosurf.measure.rock import FAULT, HORIZON, ROOF, WALL, Rock, Seal, bounded_rock
from geosurf.measure.seal import vshale_of, walls_of
from geosurf.measure.section import ragged, rings_of
from geosurf.model import FluidContact, Patches, Units

SEALING, OPEN, JUXTAPOSITION = FAULT_RULES = ("sealing", "open", "juxtaposition")
SGR = "sgr"  # key of the rule of a fault that holds where its shale gouge ratio is large enough
ELSEWHERE = "elsewhere"  # key of the rule for faults that a mapping does not name
KINDS = ("saddle", "edge", "horizon", "fault", "none")  # what is at a spill point
SADDLE, EDGE, ENDED, LEAK, NONE = range(5)
NEVER = np.iinfo(np.int64).max


def seal_rules(
    given: Any, names: Sequence[str], key: str = "faults", allowed: Sequence[str] = FAULT_RULES
) -> dict[str, Any]:
    """Return the rule of each fault or horizon, or raise an InputError.

    The first of those that are allowed holds where nothing else is given. A number is the least
    shale gouge ratio with which a fault holds.

    Examples
    --------
    >>> seal_rules({"F1": {"sgr": 0.2}, "elsewhere": "juxtaposition"}, ["F1", "F2"])
    {'F1': 0.2, 'F2': 'juxtaposition'}
    """
    rules = dict(given) if isinstance(given, Mapping) else {ELSEWHERE: given}
    example = f"{{{[*names, 'F1'][0]!r}: 'open', 'elsewhere': 'sealing'}}"
    how = f" Write {key}='sealing', or {example} by name."
    for name, rule in rules.items():
        if isinstance(rule, Mapping) and allowed is FAULT_RULES:
            least: Any = rule.get(SGR)
            if len(rule) != 1 or not is_number(least) or not 0.0 <= least <= 1.0:
                raise InputError(
                    f"{key}: {dict(rule)!r} is not a rule. Write {{'sgr': 0.2}} for a fault that "
                    "holds where its shale gouge ratio is at least 0.2."
                )
            rules[name], rule = float(least), SEALING
        for word, known in ((name, (*names, ELSEWHERE)), (rule, allowed)):
            check_word(word, known, f"{key}: {word!r} is none of {', '.join(known)}.", how)
    other = rules.get(ELSEWHERE, allowed[0])
    return {name: rules.get(name, other) for name in names}


def rules_of_closures(
    scene: Any, faults: Any, horizons: Any, vshale: Any
) -> tuple[dict[str, Any], list[str], dict[str, float] | None]:
    """Return the rules of faults, the horizons that hold and the Vshale of zones, checked."""
    rules = seal_rules(faults, scene.fault_names)
    held = seal_rules(horizons, scene.horizon_names, "horizons", (OPEN, SEALING))
    shale = None if vshale is None else vshale_of(scene, vshale)
    if shale is None and any(not isinstance(rule, str) for rule in rules.values()):
        raise InputError(
            "faults has a rule by shale gouge ratio, which needs vshale=. Give the shale of the "
            "zones: vshale={'Top/Base': 0.2, 'elsewhere': 0.7}."
        )
    return rules, [name for name, rule in held.items() if rule == SEALING], shale


# ---- merge tree ----------------------------------------
# Which basins hang together above each level, and what becomes of each part.


@dataclass(eq=False)
class Closure:
    """A part of the rock that is closed down to a level; nodes are those of its boundary.

    Attributes
    ----------
    crest, spill : int
        Nodes.
    kind, surface : int
        What is at the spill point, a row of `KINDS`; row of the surface, -1 for none.
    start : int
        Node beyond the spill point, where the way up begins; -1 where it leaves the rock.
    basins : list of int
    parts : list of Closure
        Closures that it consists of.
    """

    crest: int
    spill: int
    kind: int
    surface: int
    start: int
    basins: list[int]
    parts: list[Closure]


@dataclass(eq=False)
class _Part:
    """What hangs together above the level of the sweep."""

    crest: int  # rank of the highest node of the roof
    summit: int  # basin of it
    basins: list[int]
    closed: list[Closure] = field(default_factory=list)  # what it consists of, below `met`
    met: float = math.inf
    is_open: bool = False


class Tree:
    """Closures of a rock, and ways up from spill points.

    Parameters
    ----------
    rock : Rock
    exits : ndarray of int64, shape (n, 4)
        Nodes at which rock is left, -1, how (a row of `KINDS`), and row of the surface, or -1.
    min_height : float
        Lower parts are no closures [m].
    """

    def __init__(self, rock: Rock, exits: np.ndarray, min_height: float) -> None:
        self.rock, self.min_height, self.z = rock, min_height, rock.x[:, 2]
        self.order = np.lexsort((rock.x[:, 1], rock.x[:, 0], -self.z))
        rank = self.rank = np.empty_like(self.order)
        rank[self.order] = np.arange(len(rank))

        # each node climbs to its highest neighbour, along the boundary or across a fault
        across, t = rock.passes[rock.passes[:, 1] >= 0], rock.t
        inner = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]], rock.links])
        ends = np.concatenate([inner, across[:, :2]])
        best, is_roof = rank.copy(), rock.nodes(rock.kind == ROOF)
        for a, b in ((0, 1), (1, 0)):
            np.minimum.at(best, ends[:, a], rank[ends[:, b]])
        lifted = self._lifted(np.flatnonzero((best == rank) & ~is_roof))
        np.minimum.at(best, lifted[:, 0], rank[lifted[:, 1]])
        summit = self.up = self.order[best]
        while not np.array_equal(summit, summit[summit]):
            summit = summit[summit]
        summits, self.basin = np.unique(summit, return_inverse=True)
        n, on_roof = len(summits), np.flatnonzero(is_roof)
        crest, lowest = np.full(n, NEVER), np.full(n, -1)
        np.minimum.at(crest, self.basin[on_roof], rank[on_roof])
        np.maximum.at(lowest, self.basin[on_roof], rank[on_roof])

        # a part for each basin, and one for all that is open
        self.parts = [_Part(of, k, [k]) for k, of in enumerate(crest.tolist())]
        self.parts.append(_Part(NEVER, n, [], is_open=True))
        self.group = list(range(n + 1))
        self.closures: list[Closure] = []
        self.leaf: dict[int, Closure] = {}  # by its summit
        self.rims: dict[int, tuple[int, int]] = {}  # of small parts: where they spill, and to
        fault = np.full(len(ends) + len(lifted), -1)
        fault[len(inner) : len(ends)] = across[:, 2]
        events = np.concatenate([exits, self._meetings(np.concatenate([ends, lifted]), fault)])
        for event in events[np.lexsort((events[:, 1] >= 0, rank[events[:, 0]]))].tolist():
            self._meet(*event)

        # blocks that faults close on all sides
        for k in range(n):
            part = self.parts[k]
            if self.group[k] == k and part.crest != NEVER:
                node = int(self.order[lowest[part.basins].max()])
                if self._counts(part, node):
                    self._end(part, node, NONE, -1, -1)

    def _lifted(self, tops: np.ndarray) -> np.ndarray:
        """Summits below a roof, and the highest node of the triangle above each, int64 (n, 2)."""
        x = self.rock.x
        met = cross_columns(x, self.rock.t, x[tops, :2])
        rows = np.flatnonzero(met.elevation > x[tops[met.foot], 2])
        rows = rows[np.lexsort((-met.way[rows], met.elevation[rows], met.foot[rows]))]
        foot, first = np.unique(met.foot[rows], return_index=True)
        roof = met.way[rows[first]] > 0  # rock below it, so above the summit
        above = self.rock.t[met.triangle[rows[first[roof]]]]
        return np.stack([tops[foot[roof]], self.order[self.rank[above].min(axis=1)]], axis=1)

    def _meetings(self, ends: np.ndarray, fault: np.ndarray) -> np.ndarray:
        """Highest edge between any two basins: lower node, higher one, kind and surface."""
        rank = self.rank
        rows = np.flatnonzero(self.basin[ends[:, 0]] != self.basin[ends[:, 1]])
        ends, fault = ends[rows], fault[rows]
        ends = np.where((rank[ends[:, 0]] < rank[ends[:, 1]])[:, None], ends[:, ::-1], ends)
        key = np.sort(self.basin[ends], axis=1) @ [len(self.parts), 1]
        order = np.lexsort((fault, rank[ends[:, 0]], key))  # along rock before across a fault
        rows = order[np.unique(key[order], return_index=True)[1]]
        return np.column_stack([ends[rows], np.where(fault < 0, SADDLE, LEAK)[rows], fault[rows]])

    def _root(self, k: int) -> int:
        """Number of the part that has a basin."""
        while self.group[k] != k:
            self.group[k] = self.group[self.group[k]]
            k = self.group[k]
        return k

    def _counts(self, part: _Part, node: int) -> bool:
        """Whether a part is closed, and high enough above a node."""
        if part.is_open or part.crest == NEVER:
            return False
        height = self.z[self.order[part.crest]] - self.z[node]
        return bool(height > 0.0 and height >= self.min_height)

    def _end(self, part: _Part, node: int, kind: int, surface: int, start: int) -> None:
        """End a part at a node, unless it holds no more there than what it consists of."""
        if part.met > self.z[node]:
            crest, basins = int(self.order[part.crest]), list(part.basins)
            closure = Closure(crest, node, kind, surface, start, basins, part.closed)
            if not part.closed:
                self.leaf[part.summit] = closure
            self.closures.append(closure)
            part.closed = [closure]

    def _meet(self, low: int, high: int, kind: int, surface: int) -> None:
        """Two parts meet, or a part meets what is open: closures end, small parts join others."""
        outside = len(self.parts) - 1
        roots = [self._root(self.basin[at] if at >= 0 else outside) for at in (low, high)]
        if roots[0] == roots[1]:
            return
        parts = [self.parts[k] for k in roots]
        counts = [self._counts(part, low) for part in parts]
        starts = (high, low)  # the way up begins on the other side

        # the part that goes on: the open one, else the one that counts, else the higher one
        k = max((0, 1), key=lambda k: (parts[k].is_open, counts[k], -parts[k].crest))
        main, other = parts[k], parts[1 - k]
        if counts[1 - k]:
            self._end(other, low, kind, surface, starts[1 - k])
        elif not other.is_open:
            self.rims[other.summit] = (low, starts[1 - k])
        if all(counts):
            self._end(main, low, kind, surface, starts[k])
            main.closed, main.met = main.closed + other.closed, float(self.z[low])
        few, many = sorted((main.basins, other.basins), key=len)
        many += few
        main.basins = many
        self.group[roots[1 - k]] = roots[k]

    def way_up(self, closure: Closure) -> tuple[list[int], Closure | None]:
        """Nodes from a spill point up to the crest, or the edge, that it feeds; and the closure."""
        path, node = [closure.spill], closure.start
        while node >= 0:
            path.append(node)
            while self.up[node] != node:
                node = int(self.up[node])
                path.append(node)
            summit = int(self.basin[node])
            if summit in self.leaf:
                return path, self.leaf[summit]
            low, node = self.rims.get(summit, (path[-1], -1))
            path.append(low)  # over the rim of what is too small to be a closure
        return path if len(path) > 1 else [], None


# ---- results ----------------------------------------
# Areas, volumes, outlines, leaks and ways as one dataset.


def find_closures(
    patches: Patches,
    units: Units,
    horizons: Sequence[str],
    rules: Mapping[str, str | float],
    min_height: float,
    seals: Sequence[str] = (),
    vshale: Mapping[str, float] | None = None,
) -> xarray.Dataset:
    """
    Find the closures of horizons.

    Parameters
    ----------
    patches, units : Patches, Units
    horizons : sequence of str
        With a zone of the reservoir directly below, see `roofs_of`.
    rules : mapping of str to str or float
        One of `FAULT_RULES` for each fault, or the least SGR that seals, see `seal_rules`.
    min_height : float
        Lower ones are left out [m].
    seals : sequence of str
        Horizons that hold where others end on them.
    vshale : mapping of str to float, optional
        By zone, youngest first, for faults that hold by their SGR.

    Returns
    -------
    xarray.Dataset
        As `Scene.closures`.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.graben(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> rules = seal_rules("sealing", scene.fault_names)
    >>> find_closures(scene.patches, scene.units, ["Top"], rules, 1.0).sizes["closure"]
    0
    """
    passed: dict[int, Seal | None] = {}
    is_open = []
    for i, source in enumerate(patches.sources):
        rule = rules[source.name] if source.role == "fault" else SEALING
        if rule == OPEN:
            is_open.append(i)
        elif not isinstance(rule, str) and vshale is not None and i in units.rows_inside:
            passed[i] = Seal(walls_of(patches, units, source.name, vshale, math.inf), rule)
        elif rule == JUXTAPOSITION:
            passed[i] = None
    table = _Table(patches, units)
    for name in horizons:
        rock = bounded_rock(patches, units, name, passed)
        rows = [row_of(patches, seal, "horizon") for seal in seals if seal != name]
        held = _sealed(rock, rows)
        exits = _exits(held, is_open, rock.nodes(rock.kind == ROOF), rows)
        table.add(name, Tree(held, exits, min_height))
    said = {name: r if isinstance(r, str) else f"SGR {r:g}" for name, r in rules.items()}
    words = list(dict.fromkeys(said.values())) or [SEALING]
    if len(words) > 1:
        words = [f"{name} {rule}" for name, rule in said.items()]
    more = {"horizons": f"{', '.join(seals)} sealing"} if seals else {}
    return table.dataset(faults=", ".join(words), min_height=min_height, **more)


def _sealed(rock: Rock, seals: Sequence[int]) -> Rock:
    """The rock with horizons that hold as its roof, where they lie above it."""
    lids = (rock.kind == HORIZON) & np.isin(rock.surface, seals)
    lids &= area_in_map(rock.x, rock.t) > 0.0
    return replace(rock, kind=np.where(lids, ROOF, rock.kind))


def _exits(
    rock: Rock, is_open: Sequence[int], bare: np.ndarray, seals: Sequence[int]
) -> np.ndarray:
    """Where rock is left, as `Tree` takes it: at the edge, on other horizons, at faults.

    Nodes of the horizon itself are `bare`: a floor that it meets ends it, and no lid that holds.
    """
    roof, out = rock.nodes(rock.kind == ROOF), rock.passes[rock.passes[:, 1] < 0]
    ends = [(out[:, 0], LEAK, out[:, 2])]
    looks_up = area_in_map(rock.x, rock.t) > 0.0
    for role, kind in ((WALL, EDGE), (HORIZON, ENDED), (FAULT, LEAK)):
        for i in np.unique(rock.surface[rock.kind == role]).tolist():
            if role == WALL or (i in is_open if role == FAULT else i not in seals):
                on_surface = (rock.kind == role) & (rock.surface == i)
                at = roof & rock.nodes(on_surface)
                if role == HORIZON:
                    at = (roof & rock.nodes(on_surface & looks_up)) | (
                        bare & rock.nodes(on_surface)
                    )
                ends.append(
                    (np.flatnonzero(at), kind, np.full(at.sum(), -1 if role == WALL else i))
                )
    columns = [(at, np.full(len(at), -1), np.full(len(at), kind), i) for at, kind, i in ends]
    return np.concatenate([np.column_stack(role) for role in columns])


def clipped(x: np.ndarray, t: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the parts of triangles above a level: points (n, 3) and triangles that turn alike.

    Examples
    --------
    >>> x = np.array([[0.0, 0, 1], [4, 0, -1], [0, 4, -1]])
    >>> points, found = clipped(x, np.array([[0, 1, 2]]), 0.0)
    >>> points[found[0]].tolist()
    [[0.0, 0.0, 1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]
    """
    used, t = renumbered(t)
    x = x[used]
    above = x[t, 2] > level
    count = above.sum(axis=1)
    whole, tips, flanks = (t[count == k] for k in (3, 1, 2))

    # the corner that is alone comes first
    tips = np.take_along_axis(tips, (above[count == 1].argmax(axis=1)[:, None] + range(3)) % 3, 1)
    flanks = np.take_along_axis(
        flanks, (above[count == 2].argmin(axis=1)[:, None] + range(3)) % 3, 1
    )
    cut = np.concatenate([tips[:, [0, 1]], tips[:, [0, 2]], flanks[:, [0, 1]], flanks[:, [0, 2]]])
    key, at = np.unique(np.sort(cut, axis=1) @ [len(x), 1], return_inverse=True)
    i, j = np.divmod(key, len(x))  # one point for each edge that is cut
    share = (level - x[i, 2]) / (x[j, 2] - x[i, 2])
    points = x[i] + share[:, None] * (x[j] - x[i])
    points[:, 2] = level
    p, q, r, s = np.split(at.ravel() + len(x), np.cumsum([len(tips), len(tips), len(flanks)]))
    parts = ([tips[:, 0], p, q], [flanks[:, 1], flanks[:, 2], s], [flanks[:, 1], s, r])
    return np.concatenate([x, points]), np.concatenate([whole, *(np.stack(k, 1) for k in parts)])


def area_in_map(x: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Area of triangles in the map, below 0 for those that look down, float64 (n,) [m2]."""
    (ax, ay), (bx, by) = ((x[t[:, k], :2] - x[t[:, 0], :2]).T for k in (1, 2))
    return 0.5 * (ax * by - ay * bx)


def _spot(of: str, words: str) -> dict[str, tuple[str, str]]:
    return {f"{of}_{axis}": ("m", f"{axis} of the {words}") for axis in COORDINATES}


_CLOSURE = {
    "horizon": ("", "horizon above the closure"),
    "zone": ("", "zone below the crest"),
    "block": ("", "block of that zone"),
    "region": ("", "region of that block"),
    **_spot("crest", "highest point of the horizon"),
    **_spot("spill", "spill point"),
    "spill_kind": ("", "what ends the closure: saddle, fault, horizon, edge of the model, or none"),
    "spill_at": ("", "fault or horizon at the spill point"),
    "spills_into": ("", "closure that the way up from the spill point leads to"),
    "part_of": ("", "closure that it is a part of once it has spilled"),
    "level": ("m", "elevation down to which it is closed"),
    "height": ("m", "crest above the level"),
    "area": ("m2", "area of the horizon above the level, in the map"),
    "volume": ("m3", "gross rock volume (GRV) of the reservoir above the level"),
}
_LEAK = {
    "leak_closure": ("", "closure that leaks"),
    "leak_fault": ("", "fault"),
    **_spot("leak", "leak point"),
    "leak_zone": ("", "zone on the other side"),
}


class _Table:
    """Rows of the result, horizon after horizon."""

    def __init__(self, patches: Patches, units: Units) -> None:
        self.names, self.origin, self.units = patches.names, patches.origin, list(units.values())
        self.zones = {unit.zone_index: unit.zone for unit in self.units}
        self.closures: list[list[Any]] = []
        self.leaks: list[list[Any]] = []
        self.lines: list[tuple[np.ndarray, str, str]] = []  # points, kind, closure

    def add(self, horizon: str, tree: Tree) -> None:
        """Add the closures of one horizon."""
        # single closures are numbered from the highest crest down; others have all their numbers
        single = sorted((c for c in tree.closures if not c.parts), key=lambda c: tree.rank[c.crest])
        numbers = {c: [k] for k, c in enumerate(single, start=1)}
        whole: dict[Closure, Closure] = {}
        for c in tree.closures:  # parts come before what they are parts of
            for part in c.parts:
                whole[part] = c
                numbers[c] = sorted(numbers.get(c, []) + numbers[part])
        name = {c: f"{horizon} {'+'.join(map(str, surface))}" for c, surface in numbers.items()}
        rock, z, world = tree.rock, tree.z, tree.rock.x + self.origin
        roof = rock.kind == ROOF
        unit_of = np.full(len(z), -1)
        unit_of[rock.t[roof][::-1]] = rock.unit[roof][::-1, None]
        leaky: dict[Closure, set[int]] = {}
        for c in sorted(tree.closures, key=lambda c: (len(numbers[c]), numbers[c])):
            level = float(z[c.spill])
            within = np.isin(tree.basin, c.basins)
            chosen = (within & (z > level))[rock.t.T].any(axis=0)
            x, t = clipped(rock.x, rock.t[chosen], level)
            volume = math.fsum((area_in_map(x, t) * (x[t, 2].mean(axis=1) - level)).tolist())
            x, t = clipped(rock.x, rock.t[chosen & roof], level)
            self.lines += [(x[ring] + self.origin, "outline", name[c]) for ring in rings_of(t, x)]
            path, fed = tree.way_up(c)
            self.lines += [(world[path], "path", name[c])] if path else []
            spill = [math.nan] * 3 if c.kind == NONE else world[c.spill].tolist()
            unit = self.units[unit_of[c.crest]]
            self.closures.append([
                name[c], horizon, unit.zone, unit.block, unit.region,
                *world[c.crest].tolist(), *spill, KINDS[c.kind],
                self.names[c.surface] if c.surface >= 0 else "",
                name[fed] if fed else "", name[whole[c]] if c in whole else "",
                level + float(self.origin[2]), float(z[c.crest]) - level,
                math.fsum(area_in_map(x, t).tolist()), volume,
            ])  # fmt: skip

            # the highest leak on each fault where none of its parts leaks
            leaks_of = {c.surface: (c.spill, -1)} if c.kind == LEAK else {}
            node = rock.passes[:, 0]
            at = np.flatnonzero(within[node] & (z[node] >= level))
            at = at[np.argsort(-tree.rank[node[at]], kind="stable")]
            leaks_of |= {
                surface: (spot, zone) for spot, _, surface, zone in rock.passes[at].tolist()
            }
            known = set().union(*(leaky[part] for part in c.parts))
            leaky[c] = known | set(leaks_of)
            self.leaks += [
                [name[c], self.names[surface], *world[spot].tolist(), self.zones.get(zone, "")]
                for surface, (spot, zone) in sorted(leaks_of.items()) if surface not in known
            ]  # fmt: skip

    def dataset(self, **attrs: Any) -> xarray.Dataset:
        """All rows as one dataset."""
        labels = {
            "line_kind": ([kind for _, kind, _ in self.lines], {"long_name": "outline or path"}),
            "line_closure": ([of for *_, of in self.lines], {"long_name": "closure of each line"}),
        }
        axes = {axis: ("m", axis) for axis in COORDINATES}
        table = ragged([line for line, *_ in self.lines], axes, labels, attrs)
        for dim, rows, columns in (
            ("closure", self.closures, {"closure": ("", "closure"), **_CLOSURE}),
            ("leak", self.leaks, _LEAK),
        ):
            for k, (key, (unit, words)) in enumerate(columns.items()):
                values = np.array([row[k] for row in rows], dtype=float if unit else object)
                table[key] = (dim, values, meaning(words, unit))
        return table


# ---- fill ----------------------------------------
# Fluid contacts that lie deeper than the closure that they fill.


def warnings_of_spill(
    closures: xarray.Dataset, patches: Patches, units: Units, contacts: Sequence[FluidContact]
) -> Iterator[GeosurfWarning]:
    """Yield a warning for each closure whose lowest fluid contact lies below its level.

    Not for parts of other closures, nor for horizons inside the reservoir.
    """
    unit_at = {(unit.zone, unit.block): unit for unit in units.values()}
    inner = {unit.zone_index for unit in units.values() if unit.zone in units.reservoir}
    for row in np.flatnonzero(closures.part_of.values == "").tolist():
        closure = {str(key): closures[key].values[row] for key in ("closure", *_CLOSURE)}
        unit = unit_at[closure["zone"], closure["block"]]
        fits = [
            contact for contact in contacts
            if unit.contact and (not contact.zones or unit.zone in contact.zones)
            and set(contact.block.split()) <= set(unit.fault_sides)
        ]  # fmt: skip
        if not fits or level_of(patches, row_of(patches, closure["horizon"], "horizon")) in inner:
            continue

        # of entries for the lowest contact, the one for most sides of faults
        lowest = (contact for contact in fits if contact.name == fits[-1].name)
        contact = max(lowest, key=lambda closure: (bool(closure.zones), len(closure.block.split())))
        top = contact.at
        if not is_number(top):
            source = patches.sources[row_of(patches, contact.surface, "contact")]
            top = source.vertices[:, 2].max()
        if top < closure["level"] and closure["spill_kind"] != "none":
            spot = [closure[f"spill_{axis}"] for axis in COORDINATES]
            why = {
                "saddle": "it spills over a saddle there", "edge": "the model ends there",
                "fault": f"fault {closure['spill_at']!r} leaks there",
                "horizon": f"it ends on horizon {closure['spill_at']!r} there",
            }[closure["spill_kind"]]  # fmt: skip
            yield GeosurfWarning(
                "spill", contact.name,
                f"Fluid contact {contact.name!r} lies {length_text(closure['level'] - top)} below "
                f"the spill point of closure {closure['closure']!r} at {place(spot)}: {why} "
                f"(faults: {closures.attrs['faults']}).",
                "Raise the contact, enlarge the model, or state which faults hold: "
                "scene.closures(faults={'F1': 'open', 'elsewhere': 'sealing'}).",
                spot,
            )  # fmt: skip
