"""RESQML 2.0.1: the sealed model, as a sealed surface framework and a sealed volume framework.

Surfaces are ``TriangulatedSetRepresentation`` with a patch for each part; the surface framework
lists the lines where patches share their nodes, the volume framework the patches around each unit
Regions of RESQML have no name: the labels of units are extra metadata.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

from geosurf.errors import OutputError
from geosurf.kernels.meshes.mesh import edges, ends_of, join_pairs, weld
from geosurf.model import TriSurface, Units
from geosurf.write.model3d import Parts, lost_of_bounds, parts_of, unit_labels
from geosurf.write.resqml import (
    DOMAIN,
    Part,
    file_set,
    frame_parts,
    identifiers,
    interpretation,
    lost_of_crs,
    reference,
    tag,
    triangle_patch,
    whole_numbers,
)
from geosurf.write.written import FileSet, Loss

# ---- model lines ----------------------------------------
# The lines of a sealed model, where parts of surfaces meet: which parts, and their vertices.
#
# Parts are cut open along lines (`geosurf.write.model3d`), so a vertex of a line occurs once
# for each fan of faces around it. Two fans of one part are two sides of a line.


Edge = tuple[int, int]  # rows of two points, the smaller first


@dataclass(frozen=True, eq=False)
class Line:
    """A line where the same parts meet from end to end.

    Attributes
    ----------
    parts : tuple of int
        The parts on it, one for each side.
    vertices : ndarray of int64, shape (n_side, n_vertex)
        Rows of `Parts.vertices` along the line, one row of them for each side. A closed line
        repeats its first vertex.
    """

    parts: tuple[int, ...]
    vertices: np.ndarray


def lines_of(parts: Parts) -> list[Line]:
    """
    Return all lines where parts meet, those of faults that end inside a unit among them.

    Lines with one side, where a fault ends and meets nothing, are left out.

    Parameters
    ----------
    parts : Parts
    """
    halves, points = _border(parts)
    sides: dict[Edge, list[tuple[int, int]]] = {}  # half-edges of an edge, in order of its points
    after: dict[tuple[int, int], int] = {}  # vertex and next point -> next vertex of the same side
    for a, b in halves.tolist():
        p, q = int(points[a]), int(points[b])
        sides.setdefault((min(p, q), max(p, q)), []).append((a, b) if p < q else (b, a))
        after[a, q], after[b, p] = b, a

    part_of = np.repeat(np.arange(len(parts.surface)), np.diff(parts.first_vertex))
    kinds = {
        edge: tuple(sorted(int(part_of[a]) for a, _ in lines)) for edge, lines in sides.items()
    }
    lines = []
    for chain in _chains(kinds):
        if len(kinds[_edge(*chain[:2])]) < 2:
            continue
        forward = chain[0] < chain[1]
        rows = []
        for pair in sides[_edge(*chain[:2])]:
            here, there = pair if forward else pair[::-1]
            row = [here, there]
            for point in chain[2:]:
                row.append(after[row[-1], point])
            rows.append(row)
        rows.sort()
        lines.append(Line(tuple(int(part_of[row[0]]) for row in rows), np.array(rows)))
    return lines


def _edge(p: int, q: int) -> Edge:
    return (p, q) if p < q else (q, p)


def _border(parts: Parts) -> tuple[np.ndarray, np.ndarray]:
    """Half-edges (n, 2) with no neighbour in their part, and the point of each vertex."""
    ring = edges(parts.triangles, len(parts.vertices))[0]
    alone = np.flatnonzero(ring == np.arange(len(ring)))
    return ends_of(parts.triangles, alone), weld(parts.vertices)[0]


def _chains(kinds: dict[Edge, tuple[int, ...]]) -> Iterator[list[int]]:
    """Points along each line: edges of one kind, up to where others meet them."""
    around: dict[int, list[int]] = {}
    for p, q in sorted(kinds):
        around.setdefault(p, []).append(q)
        around.setdefault(q, []).append(p)
    ends = {
        p
        for p, others in around.items()
        if len(others) != 2 or kinds[_edge(p, others[0])] != kinds[_edge(p, others[1])]
    }

    # lines with ends first; what is left then are closed ones
    left = set(kinds)
    for start in [*sorted(ends), *sorted(around)]:
        for second in around[start]:
            if _edge(start, second) not in left:
                continue
            chain = [start, second]
            left.discard(_edge(start, second))
            while chain[-1] not in ends and chain[-1] != start:
                a, b = around[chain[-1]]
                chain.append(b if a == chain[-2] else a)
                left.discard(_edge(*chain[-2:]))
            yield chain


ORDER = tag("OrderingCriteria", "apparent depth")


def resqml_of_units(units: Units, path: Path, name: str | None, crs: str | None) -> FileSet:
    """
    Return the files ``path`` (``.epc``) and the ``.h5`` next to it, of a sealed model.

    Parameters
    ----------
    units : Units
    path : pathlib.Path
    name : str or None
        Of the model; default: the name of the file.
    crs : str or None
        For units that declare none.

    Returns
    -------
    FileSet

    Raises
    ------
    OutputError
        If there are no units.
    InputError
        If the units were made without patches.
    DependencyError
        If h5py is not installed.
    """
    if not len(units):
        raise OutputError(f"{path}: there are no units to write, and a model needs at least one.")
    crs = units.crs if crs is None else crs
    title = name or path.stem
    parts = parts_of(units)
    lines = lines_of(parts)
    fresh = _identifiers(units, parts, title, crs)
    objects, arrays = _Framework(units, parts, lines, title, crs, fresh).objects()
    return file_set(path, objects, arrays, _lost(units, parts, crs))


def _lost(units: Units, parts: Parts, crs: str | None) -> list[Loss]:
    """What the package does not hold, or other programs do not see."""
    lost = [
        Loss("name", "RESQML names zones, not units: geosurf reads their labels from metadata.")
    ]
    return lost + lost_of_bounds(units, parts) + lost_of_crs(crs)


def _identifiers(units: Units, parts: Parts, title: str, crs: str | None) -> Iterator[str]:
    """Endless UUIDs that follow from what is written."""
    named = [[source.name, source.role] for source in units.piece_sides[0].sources]
    labels = [unit_labels(unit) for unit in units.values()]
    digest = hashlib.sha256(json.dumps([title, crs, named, labels]).encode())
    for array in (parts.vertices, parts.triangles, parts.surface, parts.sides):
        digest.update(f"{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return identifiers(digest.hexdigest())


def _metadata(name: str, values: object) -> str:
    """What only geosurf reads; other programs keep it."""
    word = escape(json.dumps(values))
    return tag("ExtraMetadata", tag("Name", f"geosurf.{name}") + tag("Value", word))


class _Framework:
    """The objects of one model, each made after those that it refers to."""

    def __init__(
        self,
        units: Units,
        parts: Parts,
        lines: Sequence[Line],
        title: str,
        crs: str | None,
        fresh: Iterator[str],
    ) -> None:
        self.units, self.parts, self.lines, self.title = units, parts, lines, title
        self.fresh = fresh
        self.arrays: dict[str, np.ndarray] = {}
        self.proxy, self.system = frame_parts(fresh, crs)

        # the representation and the patch of each part
        self.rows = np.unique(parts.surface).tolist()
        row_of = {i: k for k, i in enumerate(self.rows)}
        self.of_part = [row_of[i] for i in parts.surface.tolist()]
        first = np.searchsorted(parts.surface, parts.surface)
        self.patch_of_part = (np.arange(len(parts.surface)) - first).tolist()
        # nodes count through all patches of a representation
        self.first_node = parts.first_vertex[first]

    def made(self, kind: str, title: str, body: str, uses: Sequence[Part] = ()) -> Part:
        """A new object."""
        return Part(kind, next(self.fresh), title, body, uses)

    def objects(self) -> tuple[list[Part], dict[str, np.ndarray]]:
        """All objects of the package, the stand-in of the HDF5 file first; and its arrays."""
        sources = self.units.piece_sides[0].sources
        surfaces = [sources[i] for i in self.rows]
        meant = [self.meaning(surface) for surface in surfaces]
        meshes = [
            self.mesh(i, meaning[1], surface)
            for i, meaning, surface in zip(self.rows, meant, surfaces, strict=True)
        ]
        structure = self.structure(surfaces, [meaning[1] for meaning in meant])
        sealed = self.surface_framework(structure[1], meshes)
        strata = self.strata()
        volumes = self.volume_framework(strata, sealed, meshes)
        made = [self.proxy, self.system]
        for meaning, mesh in zip(meant, meshes, strict=True):
            made += [*meaning, mesh]
        return [*made, *structure, sealed, *strata, volumes], self.arrays

    # -------------------------------------------------------------- surfaces
    def meaning(self, surface: TriSurface) -> list[Part]:
        """Feature and interpretation of a surface."""
        known = interpretation(surface.name, surface.role, self.fresh)
        if known:
            return known
        feature = self.made("BoundaryFeature", surface.name, "")
        body = DOMAIN + reference("resqml2:InterpretedFeature", feature)
        return [feature, self.made("GenericFeatureInterpretation", surface.name, body, (feature,))]

    def mesh(self, i: int, meant: Part, surface: TriSurface) -> Part:
        """One surface with a patch for each part."""
        identifier = next(self.fresh)
        body = (
            _metadata("surface", [surface.name, surface.role])
            + reference("resqml2:RepresentedInterpretation", meant)
            + tag("SurfaceRole", "map")
        )
        for k in np.flatnonzero(self.parts.surface == i).tolist():
            a, b = self.parts.first_vertex[k : k + 2].tolist()
            s, t = self.parts.first_triangle[k : k + 2].tolist()
            mesh = self.parts.vertices[a:b], self.parts.triangles[s:t] - self.first_node[k]
            number, frame = self.patch_of_part[k], (self.proxy, self.system)
            patch, arrays = triangle_patch(number, *mesh, f"/RESQML/{identifier}", *frame)
            body += patch
            self.arrays |= arrays
        uses = (self.proxy, self.system, meant)
        return Part("TriangulatedSetRepresentation", identifier, surface.name, body, uses)

    def array(self, path: str, values: np.ndarray) -> str:
        """Keep an array for the HDF5 file, and return its path there."""
        self.arrays[f"/RESQML/{path}"] = values
        return f"/RESQML/{path}"

    def structure(self, surfaces: Sequence[TriSurface], meant: Sequence[Part]) -> list[Part]:
        """The faults, horizons and walls of the model."""
        feature = self.made(
            "OrganizationFeature", self.title, tag("OrganizationKind", "structural")
        )
        pairs = list(zip(surfaces, meant, strict=True))
        body = DOMAIN + reference("resqml2:InterpretedFeature", feature) + ORDER
        for surface, meaning in pairs:
            if surface.role == "fault":
                body += reference("resqml2:Faults", meaning)
        horizons = [meaning for surface, meaning in pairs if surface.role == "horizon"]
        for k, meaning in enumerate(horizons):
            body += tag(
                "Horizons",
                tag("Index", k)
                + tag("StratigraphicRank", 0)
                + reference("resqml2:Horizon", meaning),
            )
        for name, word in (("", "Sides"), ("top", "TopFrontier"), ("bottom", "BottomFrontier")):
            for surface, meaning in pairs:
                ends = surface.name if surface.name in ("top", "bottom") else ""
                if surface.role == "wall" and ends == name:
                    body += reference(f"resqml2:{word}", meaning)
        used = [
            meaning for surface, meaning in pairs if surface.role in ("fault", "horizon", "wall")
        ]
        kind = "StructuralOrganizationInterpretation"
        return [feature, self.made(kind, self.title, body, (feature, *used))]

    def surface_framework(self, structure: Part, meshes: Sequence[Part]) -> Part:
        """The meshes, and the lines along which their patches share nodes."""
        identifier = next(self.fresh)
        body = (
            reference("resqml2:RepresentedInterpretation", structure)
            + tag("IsHomogeneous", "true")
            + "".join(reference("resqml2:Representation", mesh) for mesh in meshes)
        )
        for number, line in enumerate(self.lines):
            patches = ""
            for side, (k, vertices) in enumerate(zip(line.parts, line.vertices, strict=True)):
                nodes = vertices - self.first_node[k]
                where = self.array(f"{identifier}/contact{number}_patch{side}", nodes)
                patches += tag(
                    "Contact",
                    tag("PatchIndex", side)
                    + tag("Count", len(nodes))
                    + tag("RepresentationIndex", self.of_part[k])
                    + whole_numbers("SupportingRepresentationNodes", where, self.proxy),
                )
            same, name = tag("IdentityKind", "colocation"), "SealedContactRepresentation"
            body += tag(name, tag("Index", number), same, patches, kind=f"{name}Part")
        uses = (self.proxy, structure, *meshes)
        kind = "SealedSurfaceFrameworkRepresentation"
        return Part(kind, identifier, self.title, body, uses)

    # -------------------------------------------------------------- units
    def strata(self) -> list[Part]:
        """The zones from top to base: features, interpretations, and their order, which is last."""
        feature = self.made(
            "OrganizationFeature", self.title, tag("OrganizationKind", "stratigraphic")
        )
        ranked = sorted({(unit.zone_index, unit.zone) for unit in self.units.values()})
        zones = list(dict.fromkeys(zone for _, zone in ranked))
        parts, body = [feature], DOMAIN + reference("resqml2:InterpretedFeature", feature)
        body += ORDER + tag("Index", 0)
        meant = []
        for k, zone in enumerate(zones):
            rock = self.made("StratigraphicUnitFeature", zone, "")
            words = DOMAIN + reference("resqml2:InterpretedFeature", rock)
            meaning = self.made("StratigraphicUnitInterpretation", zone, words, (rock,))
            parts += [rock, meaning]
            meant.append(meaning)
            unit = tag("Index", k) + reference("resqml2:Unit", meaning)
            body += tag("StratigraphicUnits", unit)
        kind = "StratigraphicColumnRankInterpretation"
        rank = self.made(kind, self.title, body, (feature, *meant))
        column = reference("resqml2:Ranks", rank)
        return [*parts, self.made("StratigraphicColumn", self.title, column, (rank,)), rank]

    def volume_framework(
        self, strata: Sequence[Part], sealed: Part, meshes: Sequence[Part]
    ) -> Part:
        """The patches around each unit, with the side that faces it; outside is the first shell."""
        zones = {one.title: one for one in strata if one.kind == "StratigraphicUnitInterpretation"}
        rank = strata[-1]
        units = self.units
        box = [*units.box, units.footprint, units.box_volume]
        body = _metadata("model", [self.title, *box, list(units.reservoir)])
        body += "".join(_metadata("unit", unit_labels(unit)) for unit in units.values())
        body += reference("resqml2:RepresentedInterpretation", rank)
        body += tag("IsHomogeneous", "true")
        body += "".join(reference("resqml2:Representation", mesh) for mesh in meshes)
        body += reference("resqml2:BasedOn", sealed)
        shells = shells_of(self.parts, self.lines, len(units))
        for k, faces in enumerate(shells[-1]):
            body += tag("Shells", self.shell(f"outside {k}", faces))
        for k, (name, unit) in enumerate(units.items()):
            outer, *inner = shells[k]
            body += tag(
                "Regions",
                tag("PatchIndex", k)
                + "".join(
                    tag("InternalShells", self.shell(f"{name} {i}", faces))
                    for i, faces in enumerate(inner, 1)
                )
                + reference("resqml2:Represents", zones[unit.zone])
                + tag("ExternalShell", self.shell(name, outer)),
            )
        uses = (rank, sealed, *meshes, *zones.values())
        return self.made("SealedVolumeFrameworkRepresentation", self.title, body, uses)

    def shell(self, name: str, faces: Sequence[tuple[int, bool]]) -> str:
        """Patches with their sides."""
        return tag("ShellUid", escape(name)) + "".join(
            tag(
                "MacroFaces",
                tag("PatchIndexOfRepresentation", self.patch_of_part[k])
                + tag("RepresentationIndex", self.of_part[k])
                + tag("SideIsPlus", "true" if front else "false"),
            )
            for k, front in faces
        )


def shells_of(
    parts: Parts, lines: Sequence[Line], n_unit: int
) -> list[list[list[tuple[int, bool]]]]:
    """
    Return the shells around each unit, and around all that lies outside as the last.

    Parameters
    ----------
    parts : Parts
    lines : sequence of Line
    n_unit : int

    Returns
    -------
    list of list of list of (int, bool)
        Part, and whether the side into which its normal points faces the unit. The outer shell of
        a unit is its first: the others lie inside of its bounding box.
    """
    # parts around a unit that share a line belong to one shell
    facing: dict[tuple[int, int], list[tuple[int, bool]]] = {}
    for side, front in ((0, True), (1, False)):
        for k, unit in enumerate(parts.sides[:, side].tolist()):
            facing.setdefault((unit, k), []).append((k, front))
    keys = sorted(facing)
    number = {key: row for row, key in enumerate(keys)}
    pairs = []
    for line in lines:
        first: dict[int, int] = {}
        for k in line.parts:
            for unit in parts.sides[k].tolist():
                pairs.append((number[unit, k], number[unit, first.setdefault(unit, k)]))
    root = join_pairs(np.array(pairs, dtype=np.int64).reshape(-1, 2), len(keys)).tolist()
    shells: dict[tuple[int, int], list[tuple[int, bool]]] = {}
    for row, key in zip(root, keys, strict=True):
        shells.setdefault(keys[row], []).extend(facing[key])
    by_unit: list[list[list[tuple[int, bool]]]] = [[] for _ in range(n_unit + 1)]
    for (unit, _), shell in shells.items():
        by_unit[unit].append(shell)  # -1 is the last
    return [sorted(of_unit, key=lambda shell: -_extent(parts, shell)) for of_unit in by_unit]


def _extent(parts: Parts, shell: Sequence[tuple[int, bool]]) -> float:
    """Diagonal of the bounding box of some parts, squared: that of an outer shell is largest."""
    places = [parts.vertices[slice(*parts.first_vertex[k : k + 2])] for k, _ in shell]
    low = np.min([one.min(axis=0) for one in places], axis=0)
    high = np.max([one.max(axis=0) for one in places], axis=0)
    return float(np.square(high - low).sum())
