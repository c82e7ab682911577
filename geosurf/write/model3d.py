"""GOCAD Model3d (``.ml``): the sealed model with its regions.

Each part of a surface (TFACE) has one unit on either side; regions list the parts around them,
``+`` where the normal points into the region, as GOCAD and OpenGeode write it (decision 40). GOCAD
knows neither zones with blanks nor fluid contacts; lines ``*geosurf*`` of the header, which other
programs pass over, hold what `geosurf.read.read_units` needs to return equal units.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence

import numpy as np

from geosurf.conventions import counted, place
from geosurf.errors import OutputError
from geosurf.kernels.meshes.mesh import weld
from geosurf.model import TriSurface, Unit, Units
from geosurf.write.gocad import coordinate_system, triangle_lines, vertex_lines
from geosurf.write.model3d_parts import Parts, parts_of
from geosurf.write.written import Loss

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
    return data, [*_lost(units, sources, titles, kinds, regions), *_near(parts)]


def safe_names(names: Sequence[str], taken: Sequence[str] = ()) -> list[str]:
    """
    Return names without blanks and special characters, each different.

    Examples
    --------
    >>> safe_names(["Top/Base F1+", "Top Base F1+", "F1"])
    ['Top_Base_F1+', 'Top_Base_F1+_2', 'F1']
    """
    found: list[str] = []
    for name in names:
        plain = UNSAFE.sub("_", name).strip("_") or "unnamed"
        title, k = plain, 2
        while title in found or title in taken:
            title, k = f"{plain}_{k}", k + 1
        found.append(title)
    return found


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
            _own("model", [name, *box]),
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
    of_region = np.split(signed[order], cut[1:-1])
    return [
        f"REGION {len(number) + 1 + k} {name}\n{_list(mine.tolist(), '+')}"
        for k, (name, mine) in enumerate(zip(["Universe", *names], of_region, strict=True))
    ]


def _groups(word: str, labels: Sequence[str], first: int) -> list[str]:
    """Regions by zone (LAYER) or by block (FAULT_BLOCK)."""
    members: dict[str, list[int]] = {}
    for k, label in enumerate(labels):
        members.setdefault(label, []).append(first + k)
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
    lost = [Loss("other", "Only faces around units are written, and faults that end inside one.")]
    gone = [surface.name for i, surface in enumerate(sources) if i not in titles]
    if gone:
        words = f"Surfaces that bound no unit are left out: {', '.join(gone)}."
        lost.append(Loss("data", words))

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
    from scipy.spatial import cKDTree

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
