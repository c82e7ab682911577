"""GOCAD Model3d (``.ml``): the sealed model with its regions.

Each part of a surface (TFACE) has one unit on either side; regions list the parts around them,
``+`` where the normal points into the region, as GOCAD and OpenGeode write it. GOCAD
knows neither zones with blanks nor fluid contacts; lines ``*geosurf*`` of the header, which other
programs pass over, hold what `geosurf.read_units` needs to return equal units.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from geosurf.conventions import counted, grouped, place
from geosurf.errors import OutputError
from geosurf.kernels.meshes.mesh import edges, join_pairs, weld
from geosurf.model import TriSurface, Unit, Units
from geosurf.write.gocad import coordinate_system, triangle_lines, vertex_lines
from geosurf.write.written import Loss

# ---- model3d parts ----------------------------------------
# The sealed model as GOCAD keeps it: parts of surfaces (TFACE), cut open along lines.
#
# A part is a connected piece of one surface with one unit in front of it and one behind it. A
# line is where other faces meet a part, or where it ends. Vertices on lines are doubled, so that
# each part has vertices of its own and all lines are on its border; a reader joins them by their
# coordinates.


@dataclass(frozen=True, eq=False)
class Parts:
    """Parts of the surfaces of a model, in the order of surfaces.

    Attributes
    ----------
    vertices : ndarray of float64, shape (n_vertex, 3)
        World coordinates [m], part by part.
    triangles : ndarray of int64, shape (n_triangle, 3)
        Rows of `vertices`, part by part.
    first_vertex, first_triangle : ndarray of int64, shape (n_part + 1,)
    surface : ndarray of int64, shape (n_part,)
        Row of the surface among the sources of the model.
    sides : ndarray of int64, shape (n_part, 2)
        Unit in front of and behind each; -1 is outside. Equal where a fault ends inside a unit.
    borders : ndarray of int64, shape (n, 2)
        A vertex where a line begins, and the next vertex of that line.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    first_vertex: np.ndarray
    first_triangle: np.ndarray
    surface: np.ndarray
    sides: np.ndarray
    borders: np.ndarray


def parts_of(units: Units) -> Parts:
    """
    Divide the boundaries of all units, and faults that end inside units, into parts.

    Parameters
    ----------
    units : Units

    Raises
    ------
    InputError
        If the units were made without patches.
    """
    pieces, sides = units.piece_sides
    full = pieces.expanded
    runs = np.repeat(np.arange(len(pieces.sources)), np.diff(pieces.first_run))
    surface = np.concatenate([pieces.surface, runs])

    # a horizon with one unit on both sides is no boundary: the column has taken it away there
    is_fault = np.array([source.role == "fault" for source in pieces.sources], dtype=bool)
    inside = (sides[:, 0] >= 0) & (sides[:, 1] >= 0)
    chosen = (sides[:, 0] != sides[:, 1]) | (inside & is_fault[surface])

    # elements of one patch with the same units on both sides are connected
    labels = np.column_stack([surface, sides, pieces.patch])
    kinds, of_chosen = np.unique(labels[chosen], axis=0, return_inverse=True)
    label_of_element = np.full(len(labels), -1)
    label_of_element[chosen] = of_chosen.ravel()

    label = label_of_element[full.element]
    rows = np.flatnonzero(label >= 0)
    faces, label = full.triangles[rows], label[rows]

    # patches that a line parts are one part where nothing else meets that line
    _, group = np.unique(kinds[:, :3], axis=0, return_inverse=True)
    partner = _partners(faces, group.ravel()[label], len(full.local))
    part_of_label = _joined_labels(label, partner, len(kinds))
    part = part_of_label[label]
    first = np.unique(part_of_label, return_index=True)[1]

    return _in_order(
        full.local, pieces.origin, faces, part, partner, kinds[first, 0], kinds[first, 1:3]
    )


def _partners(faces: np.ndarray, group: np.ndarray, n_point: int) -> np.ndarray:
    """Other half-edge of each edge inside a part, -1 on lines, int64 (3 * n_face,).

    Half-edge ``3 * t + k`` leads from corner k of face t to its next corner.
    """
    # edges with exactly two half-edges, of one group and of opposite directions
    ring, half = edges(faces, n_point)[0], np.arange(faces.size)
    alike = (ring != half) & (ring[ring] == half) & (group[half // 3] == group[ring // 3])
    alike &= faces.ravel() == faces[:, [1, 2, 0]].ravel()[ring]
    return np.where(alike, ring, -1)


def _joined_labels(label: np.ndarray, partner: np.ndarray, n_label: int) -> np.ndarray:
    """Part of each label: labels that share an edge inside a part are one."""
    here = np.flatnonzero(partner >= 0)
    pairs = np.column_stack([label[here // 3], label[partner[here] // 3]])
    return _components(pairs[pairs[:, 0] < pairs[:, 1]], n_label)


def _components(pairs: np.ndarray, n: int) -> np.ndarray:
    """Number of the connected component of each node, counted in the order of first nodes."""
    return np.unique(join_pairs(pairs, n), return_inverse=True)[1]


def _in_order(
    local: np.ndarray,
    origin: np.ndarray,
    faces: np.ndarray,
    part: np.ndarray,
    partner: np.ndarray,
    surface: np.ndarray,
    sides: np.ndarray,
) -> Parts:
    """Number vertices and triangles part by part."""
    ids, point_of_id = _cut_open(faces, part, partner, len(local))

    # after the cut each vertex belongs to one part
    part_of_id = np.full(len(point_of_id), -1)
    part_of_id[ids.ravel()] = np.repeat(part, 3)
    used = np.flatnonzero(part_of_id >= 0)
    used = used[_stable_order(part_of_id[used], len(surface))]
    number = np.empty(len(point_of_id), dtype=np.int64)
    number[used] = np.arange(len(used))

    by_part = _stable_order(part, len(surface))
    return Parts(
        local[point_of_id[used]] + origin,
        number[ids[by_part]],
        np.searchsorted(part_of_id[used], np.arange(len(surface) + 1)),
        np.searchsorted(part[by_part], np.arange(len(surface) + 1)),
        surface,
        sides,
        number[_borders(faces, part, partner, ids)],
    )


def _stable_order(values: np.ndarray, n: int) -> np.ndarray:
    """Return the order of whole numbers below n, equal ones as they stand."""
    # numpy sorts 16 bits by digits
    small = values.astype(np.uint16) if n < 2**16 else values
    return np.argsort(small, kind="stable")


def _cut_open(
    faces: np.ndarray, part: np.ndarray, partner: np.ndarray, n_point: int
) -> tuple[np.ndarray, np.ndarray]:
    """Give each fan of faces around a point on a line a vertex of its own.

    Returns
    -------
    (ndarray of int64, shape (n_face, 3), ndarray of int64, shape (n_id,))
        Vertices of the faces, and the point where each vertex lies.
    """
    tail, head = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    on_line = np.zeros(n_point, dtype=bool)
    alone = partner < 0
    on_line[tail[alone]] = on_line[head[alone]] = True

    # parts that touch in a point only
    owner = np.empty(n_point, dtype=np.int64)
    corner_part = np.repeat(part, 3)
    owner[tail] = corner_part
    on_line[tail[owner[tail] != corner_part]] = True

    # corners of one fan follow each other over edges inside the part
    corners = np.flatnonzero(on_line[tail])
    row = np.full(faces.size, -1)
    row[corners] = np.arange(len(corners))
    halves = corners[partner[corners] >= 0]
    other = partner[halves]
    ends = np.column_stack([row[halves], row[_next(other)]])
    fan = _components(ends, len(corners))

    ids, points = tail.copy(), np.arange(n_point)
    ids[corners] = n_point + fan
    of_fan = np.empty(int(fan.max(initial=-1)) + 1, dtype=np.int64)
    of_fan[fan] = tail[corners]
    return ids.reshape(-1, 3), np.concatenate([points, of_fan])


def _next(half: np.ndarray) -> np.ndarray:
    """Next half-edge of the same face."""
    return np.where(half % 3 == 2, half - 2, half + 1)


def _borders(
    faces: np.ndarray, part: np.ndarray, partner: np.ndarray, ids: np.ndarray
) -> np.ndarray:
    """Vertex where a line begins, and the next one, against the direction of the faces."""
    alone = np.flatnonzero(partner < 0)
    tail, head = faces.ravel()[alone], faces[:, [1, 2, 0]].ravel()[alone]
    begins = np.isin(head, _line_ends(tail, head, part[alone // 3]))
    half = alone[begins]
    return np.column_stack([ids.ravel()[_next(half)], ids.ravel()[half]])


def _line_ends(tail: np.ndarray, head: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Points where lines end: where other parts meet, and three points of closed lines."""
    low_high = np.column_stack([np.minimum(tail, head), np.maximum(tail, head)])
    edges, of_half = np.unique(low_high, axis=0, return_inverse=True)
    kind = _kinds(of_half.ravel(), part, len(edges))

    # a point goes on where exactly two edges with the same parts meet
    points, at = np.unique(edges, return_inverse=True)
    at = at.reshape(-1, 2)
    count = np.bincount(at.ravel(), minlength=len(points))
    low, high = np.full(len(points), len(edges)), np.full(len(points), -1)
    np.minimum.at(low, at.ravel(), np.repeat(kind, 2))
    np.maximum.at(high, at.ravel(), np.repeat(kind, 2))
    ends = (count != 2) | (low != high)

    ends[_on_loops(at, ends)] = True
    made: np.ndarray = points[ends]
    return made


def _on_loops(at: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Three points of each line that is closed, or that ends where it begins.

    With them each line has two ends; OpenGeode takes others for lines inside a surface.
    """
    # points that go on are connected along their line
    inner = ~ends[at]
    line = _components(at[inner.all(axis=1)], len(ends))
    leaving = at[inner.sum(axis=1) == 1]
    end_point = np.where(ends[leaving[:, 0]], leaving[:, 0], leaving[:, 1])
    line_of_end = line[np.where(ends[leaving[:, 0]], leaving[:, 1], leaving[:, 0])]
    low, high = np.full(len(ends), len(ends)), np.full(len(ends), -1)
    np.minimum.at(low, line_of_end, end_point)
    np.maximum.at(high, line_of_end, end_point)

    # no end at all, or one for both
    members = np.flatnonzero(~ends)
    members = members[np.argsort(line[members], kind="stable")]
    members = members[low[line[members]] >= high[line[members]]]
    _, first, count = np.unique(line[members], return_index=True, return_counts=True)
    made: np.ndarray = members[np.concatenate([first, first + count // 2, first + count - 1])]
    return made


def _kinds(edge: np.ndarray, part: np.ndarray, n_edge: int) -> np.ndarray:
    """A number for each edge, the same for edges where the same parts meet."""
    order = np.lexsort((part, edge))
    edge, part = edge[order], part[order]
    first = np.searchsorted(edge, np.arange(n_edge))
    place = np.arange(len(edge)) - first[edge]
    table = np.full((n_edge, int(place.max(initial=0)) + 1), -1)
    table[edge, place] = part
    kind: np.ndarray = np.unique(table, axis=0, return_inverse=True)[1]
    return kind.ravel()


# kind of a TFACE by the role of its surface: kinds that OpenGeode knows, too
KINDS = {"fault": "fault", "wall": "boundary", "horizon": "top"}
COLOURS = {
    "horizon": ("#d69a4e", "#4f7393", "#6f8f57", "#e0bd6a", "#8f4a35", "#b4cfda"),
    "fault": ("#8c2f2b", "#4a3f63", "#d9843b", "#a9a3d0", "#c8a27a", "#3f7d6e"),
    "wall": ("#d4d7db",),
    "contact": ("#1539b8",),
}
JOINED = 1e-6  # [m]: OpenGeode joins places that are nearer
PER_LINE = 5  # numbers on a line of a list
UNSAFE = re.compile(r"[^A-Za-z0-9_.+-]+")


def model3d(units: Units, name: str | None) -> tuple[bytearray, list[Loss]]:
    """Return a Model3d of all units, and what it cannot hold."""
    if not len(units):
        raise OutputError("there are no units to write, and a Model3d needs at least one.")
    sources = units.piece_sides[0].sources
    parts = parts_of(units)

    # surfaces without a part around a unit are not in the model
    used = np.unique(parts.surface).tolist()
    surfaces = {i: sources[i] for i in used}
    titles = dict(zip(used, safe_names([s.name for s in surfaces.values()]), strict=True))
    kinds = {i: KINDS.get(surface.role, "none") for i, surface in surfaces.items()}

    text: list[str | bytearray] = [_head(units, name or "model", surfaces.values())]
    text += [f"TSURF {titles[i]}\n" for i in used]
    text += _key_triangles(parts, titles, kinds)
    regions = safe_names(list(units), taken=("Universe",))
    text += _regions(parts, regions)
    first = len(parts.surface) + 2
    text += _groups("LAYER", [unit.zone for unit in units.values()], first)
    text += _groups("FAULT_BLOCK", [unit.block for unit in units.values()], first)
    text.append("END\n")
    for i in used:
        text.append(_tsurf_head(titles[i], kinds[i], _colour(surfaces, i), units.crs))
        text += _tsurf_parts(parts, i)
    data = bytearray()
    for piece in text:
        data += piece.encode() if isinstance(piece, str) else piece
    lost = _lost(units, sources, titles, kinds, regions)
    return data, [*lost_of_bounds(units, parts), *lost, *_near(parts)]


def lost_of_bounds(units: Units, parts: Parts) -> list[Loss]:
    """Return what a sealed model has no place for: faces that bound no unit."""
    lost = [Loss("other", "Only faces around units are written, and faults that end inside one.")]
    used = set(parts.surface.tolist())
    sources = units.piece_sides[0].sources
    gone = [surface.name for i, surface in enumerate(sources) if i not in used]
    if gone:
        words = f"Surfaces that bound no unit are left out: {', '.join(gone)}."
        lost.append(Loss("data", words))
    return lost


def safe_names(names: Sequence[str], taken: Sequence[str] = ()) -> list[str]:
    """
    Return names without blanks and special characters, each different.

    Examples
    --------
    >>> safe_names(["Top/Base F1+", "Top Base F1+", "F1"])
    ['Top_Base_F1+', 'Top_Base_F1+_2', 'F1']
    """
    titles: list[str] = []
    for name in names:
        plain = UNSAFE.sub("_", name).strip("_") or "unnamed"
        title, k = plain, 2
        while title in titles or title in taken:
            title, k = f"{plain}_{k}", k + 1
        titles.append(title)
    return titles


def _colour(surfaces: dict[int, TriSurface], i: int) -> str:
    """Colour of a surface: horizons and faults take turns."""
    role = surfaces[i].role
    choice = COLOURS.get(role, ("#9aa0a8",))
    return choice[[k for k in surfaces if surfaces[k].role == role].index(i) % len(choice)]


def _head(units: Units, name: str, surfaces: Iterable[TriSurface]) -> str:
    """First lines: name, what only geosurf reads, coordinate system."""
    box = [*units.box, units.footprint, units.box_volume]
    return "".join(
        [
            "GOCAD Model3d 1\nHEADER {\n",
            f"name:{safe_names([name])[0]}\n",
            _own("model", [name, *box, list(units.reservoir)]),
            *(_own("surface", [surface.name, surface.role]) for surface in surfaces),
            *(_own("unit", unit_labels(unit)) for unit in units.values()),
            "}\n",
            coordinate_system(units.crs),
        ]
    )


def _own(key: str, values: object) -> str:
    """Return a line of the header that only geosurf reads."""
    # braces would end the header
    text = json.dumps(values).replace("{", "\\u007b").replace("}", "\\u007d")
    return f"*geosurf*{key}:{text}\n"


def unit_labels(unit: Unit) -> list[object]:
    """All labels of a unit."""
    return [
        unit.name,
        unit.zone,
        unit.zone_index,
        unit.block,
        unit.contact,
        list(unit.beneath),
        list(unit.fault_sides),
        unit.compartment_of,
        unit.region,
    ]


def _key_triangles(parts: Parts, titles: dict[int, str], kinds: dict[int, str]) -> list[str]:
    """Number, kind and surface of each part, and a triangle that shows which side is the front."""
    corners = parts.vertices[parts.triangles[parts.first_triangle[:-1]]].tolist()
    return [
        f"TFACE {k} {kinds[i]} {titles[i]}\n"
        + "".join(f"  {x!r} {y!r} {z!r}\n" for x, y, z in triangle)
        for k, (i, triangle) in enumerate(zip(parts.surface.tolist(), corners, strict=True), 1)
    ]


def _regions(parts: Parts, names: Sequence[str]) -> list[str]:
    """Regions with the signed numbers of their parts; the first is all that lies outside."""
    number = np.arange(1, len(parts.surface) + 1)
    signed = np.concatenate([number, -number])
    unit = parts.sides.T.ravel()
    order = np.argsort(unit, kind="stable")
    cut = np.searchsorted(unit[order], np.arange(-1, len(names) + 1))
    parts_of_region = np.split(signed[order], cut[1:-1])
    return [
        f"REGION {len(number) + 1 + k} {name}\n{_list(mine.tolist(), '+')}"
        for k, (name, mine) in enumerate(zip(["Universe", *names], parts_of_region, strict=True))
    ]


def _groups(word: str, labels: Sequence[str], first: int) -> list[str]:
    """Regions by zone (LAYER) or by block (FAULT_BLOCK)."""
    members = grouped(zip(labels, range(first, first + len(labels)), strict=True))
    titles = safe_names(list(members))
    return [
        f"{word} {title}\n{_list(rows, '')}"
        for title, rows in zip(titles, members.values(), strict=True)
    ]


def _list(numbers: Sequence[int], sign: str) -> str:
    """Lines of numbers that end with 0."""
    words = [format(k, f"{sign}d") for k in numbers] + ["0"]
    rows = [words[k : k + PER_LINE] for k in range(0, len(words), PER_LINE)]
    return "".join(f"  {'  '.join(row)}\n" for row in rows)


def _tsurf_head(title: str, kind: str, colour: str, crs: str | None) -> str:
    """First lines of one surface."""
    return (
        f"GOCAD TSurf 1\nHEADER {{\nname:{title}\n*solid*color:{colour}\n}}\n"
        f"{coordinate_system(crs)}GEOLOGICAL_FEATURE {title}\nGEOLOGICAL_TYPE {kind}\n"
    )


def _tsurf_parts(parts: Parts, i: int) -> list[str | bytearray]:
    """Vertices and triangles of all parts of a surface, then where their lines begin."""
    rows = np.flatnonzero(parts.surface == i)
    shift = int(parts.first_vertex[rows[0]])
    text: list[str | bytearray] = []
    for k in rows.tolist():
        a, b = parts.first_vertex[k : k + 2].tolist()
        s, t = parts.first_triangle[k : k + 2].tolist()
        text += [
            "TFACE\n",
            *vertex_lines("VRTX", parts.vertices[a:b], first=a - shift + 1),
            *triangle_lines(parts.triangles[s:t] - shift),
        ]

    # numbers of borders follow those of vertices
    end = int(parts.first_vertex[rows[-1] + 1])
    mine = (parts.borders[:, 0] >= shift) & (parts.borders[:, 0] < end)
    borders = parts.borders[mine] - (shift - 1)
    borders = borders[np.argsort(borders[:, 0], kind="stable")]
    text += [f"BSTONE {a}\n" for a in np.unique(borders[:, 0]).tolist()]
    numbered = enumerate(borders.tolist(), end - shift + 1)
    text += [f"BORDER {k} {a} {b}\n" for k, (a, b) in numbered]
    return [*text, "END\n"]


def _lost(
    units: Units,
    sources: Sequence[TriSurface],
    titles: dict[int, str],
    kinds: dict[int, str],
    regions: Sequence[str],
) -> list[Loss]:
    """What the file does not hold, or other programs do not see."""
    lost: list[Loss] = []
    before = [sources[i].name for i in titles] + list(units)
    after = [*titles.values(), *regions]
    changed = [(a, b) for a, b in zip(before, after, strict=True) if a != b]
    if changed:
        old, new = changed[0]
        words = (
            f"GOCAD names have no blanks or slashes: {counted(len(changed), 'name')} changed, "
            f"such as {old!r} to {new!r}. geosurf reads the original names from the header."
        )
        lost.append(Loss("name", words))
    plain = [sources[i].name for i, kind in kinds.items() if kind == "none"]
    if plain:
        words = f"GOCAD has no kind for fluid contacts and virtual walls: {', '.join(plain)}."
        lost.append(Loss("other", words))
    return lost


def _near(parts: Parts) -> list[Loss]:
    """A note on places of lines that programs with a tolerance take for one."""
    # near places are ends and crossings of lines, and vertices of lines are there twice
    number, count = weld(parts.vertices)
    places = np.empty((count, 3))
    places[number] = parts.vertices
    places = places[np.bincount(number) > 1]
    pairs = cKDTree(places - places[:1]).query_pairs(JOINED) if len(places) else set()
    if not pairs:
        return []
    words = (
        f"{counted(len(pairs), 'pair')} of vertices on lines lie within {JOINED:g} m of each "
        f"other, such as near {place(places[min(pairs)[0]])}. OpenGeode takes two such vertices "
        "for one and may refuse the model; geosurf reads it."
    )
    return [Loss("other", words)]
