"""Sealed models in files: parts of surfaces and the regions between them, as units.

A region lists the parts around it; vertices with equal coordinates are one. The shell of each
region has to be closed, edge by edge. Files are GOCAD Model3d, where ``LAYER`` states the zone of a
region and ``FAULT_BLOCK`` its block, and RESQML, whose sealed volume framework lists the patches
around each region. Models that geosurf wrote hold all labels of their units.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from geosurf.conventions import counted, frame_origin, place, shift_is_exact
from geosurf.errors import FormatError
from geosurf.kernels.meshes.mesh import edges, renumbered, weld
from geosurf.model import ROLES, TriSurface, Unit, Units
from geosurf.model.base import in_crs_of
from geosurf.model.expected import path_of
from geosurf.model.pieces import FREE, PAIRED, Pieces
from geosurf.read._common import Request, read_text
from geosurf.read._guard import damaged
from geosurf.read.gocad import read_tsurf
from geosurf.read.model3d import (
    own_lines,
    part_counts,
    region_lists,
    roles_of,
    surfaces_of,
    volume_with_sign,
    welded,
)
from geosurf.read.registry import detect
from geosurf.read.resqml import Package, every, kind, open_package, values_of, word_of
from geosurf.read.resqml.representations import (
    FRAMEWORK,
    MESH,
    Representation,
    mesh_of,
    representations,
)

LABELS = (
    "name", "zone", "zone_index", "block", "contact", "beneath", "fault_sides", "compartment_of",
    "region",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class SealedModel:
    """What a file states about a sealed model.

    Attributes
    ----------
    path : pathlib.Path
    meshes : list of TriSurface
        Part after part, each with vertices of its own.
    sources : list of TriSurface
        The same surfaces, with one vertex in each place.
    counts : list of int
        Triangles of each part.
    regions : list of (str, list of int)
        Name, and the parts around it, counted from 1: positive where the normal points into it.
    labels : list of dict
        Of each unit, by `LABELS`.
    box : sequence
        Title, box, footprint, volume and reservoir where geosurf wrote the file; else empty.
    word : str
        What the format calls a part.
    """

    path: Path
    meshes: list[TriSurface]
    sources: list[TriSurface]
    counts: list[int]
    regions: list[tuple[str, list[int]]]
    labels: list[dict[str, Any]]
    box: Sequence[Any]
    word: str


def units_of(model: SealedModel) -> Units:
    """
    Return the regions of a model as units.

    Raises
    ------
    FormatError
        If a region is not closed, lies on the same side of a part as another one, or is inside out.
    """
    path, pieces = model.path, _pieces(model)
    sides = _sides(model)[pieces.patch]
    shells = _shells(path, [name for name, _ in model.regions], sides, pieces)
    if sum(volume_with_sign(pieces.x[shell]) for shell, _ in shells) < 0.0:
        # programs may count the other side as +
        sides = sides[:, ::-1]
        shells = [(shell[:, ::-1], rows) for shell, rows in shells]
    parts = [
        _unit(path, labels, shell, pieces.surface[rows], pieces)
        for labels, (shell, rows) in zip(model.labels, shells, strict=True)
    ]
    return _units(model.box, parts, pieces, sides)


def labels_of(path: Path, stated: Sequence[Any], n_region: int, where: str) -> list[dict[str, Any]]:
    """
    Return the labels of units that geosurf wrote.

    Raises
    ------
    FormatError
        If they do not fit the regions of the model.
    """
    if len(stated) != n_region or any(
        not isinstance(values, list) or len(values) != len(LABELS) for values in stated
    ):
        raise damaged(
            f"{path}: {where} describes {len(stated)} units of geosurf, but the model has "
            f"{n_region} regions"
        )
    labels = [dict(zip(LABELS, values, strict=True)) for values in stated]
    if not all(_are_labels(entry) for entry in labels):
        raise damaged(f"{path}: {where} describes units of geosurf with damaged labels")
    return [
        {**entry, "beneath": tuple(entry["beneath"]), "fault_sides": tuple(entry["fault_sides"])}
        for entry in labels
    ]


def _are_labels(labels: dict[str, Any]) -> bool:
    """Whether labels are of the kinds that a unit has."""
    lists = (labels["beneath"], labels["fault_sides"])
    words = [
        labels[key] for key in ("name", "zone", "block", "contact", "compartment_of", "region")
    ]
    if not all(isinstance(values, list) for values in lists):
        return False
    words += [word for values in lists for word in values]
    return type(labels["zone_index"]) is int and all(isinstance(word, str) for word in words)


def _sides(model: SealedModel) -> np.ndarray:
    """Region in front of and behind each part, int64 (n_part, 2); -1 outside."""
    path, regions, n_part, word = model.path, model.regions, len(model.counts), model.word
    sides = np.full((n_part, 2), -1)
    for u, (name, signed) in enumerate(regions):
        for k in signed:
            if abs(k) > n_part:
                raise FormatError(
                    f"{path}: region {name!r} names {word} {abs(k)}, but the file has {n_part}. "
                    "Export the model again, with all surfaces."
                )
            # + is the side into which the normal points
            side = 0 if k > 0 else 1
            if sides[abs(k) - 1, side] not in (-1, u):
                other = regions[sides[abs(k) - 1, side]][0]
                raise FormatError(
                    f"{path}: regions {other!r} and {name!r} lie on the same side of {word} "
                    f"{abs(k)}. Correct one of the two lists or export the model again."
                )
            sides[abs(k) - 1, side] = u
    return sides


def _shells(
    path: Path, names: list[str], sides: np.ndarray, pieces: Pieces
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Outward triangles of each region, and their rows; closed, or an error."""
    triangles, shells = pieces.triangles, []
    for u, name in enumerate(names):
        rows = np.flatnonzero((sides == u).any(axis=1) & (sides[:, 0] != sides[:, 1]))
        front = sides[rows, 0] == u
        shell = np.where(front[:, None], triangles[rows][:, ::-1], triangles[rows])

        _refuse_if_open(path, name, shell, pieces)
        shells.append((shell, rows))
    return shells


def _refuse_if_open(path: Path, name: str, shell: np.ndarray, pieces: Pieces) -> None:
    """Raise an error that names an edge that does not run as often one way as the other; triangles
    that rounding made a line have none.
    """
    tail, head = shell.ravel(), shell[:, [1, 2, 0]].ravel()
    n = len(pieces.x)
    there, back = np.sort(tail * n + head), np.sort(head * n + tail)
    if np.array_equal(there, back):
        return
    open_edges = np.setdiff1d(there, back)
    where = pieces.x[(open_edges if len(open_edges) else there)[0] // n] + pieces.origin
    raise FormatError(
        f"{path}: region {name!r} is not closed near {place(where)}: "
        f"{counted(max(len(open_edges), 1), 'edge')} without a neighbour. Repair the model "
        "where it was made, and export it again."
    )


def _pieces(model: SealedModel) -> Pieces:
    """All triangles as the pieces of a model, so that what works on units works on these.

    Patches are the parts of surfaces, numbered as in the file.
    """
    tsurfs, sources, counts = model.meshes, model.sources, model.counts
    # one number for each place, over all surfaces
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in tsurfs)])
    points = np.concatenate([mesh.vertices for mesh in tsurfs])
    number, count = weld(points)
    x = np.empty((count, 3))
    x[number] = points
    corners = [mesh.triangles + k for mesh, k in zip(tsurfs, first, strict=False)]
    triangles = number[np.concatenate(corners)]

    n_of_surface = [len(mesh.triangles) for mesh in tsurfs]
    surface = np.repeat(np.arange(len(tsurfs)), n_of_surface)
    first = np.concatenate([[0], np.cumsum(n_of_surface)[:-1]])

    # local coordinates where they are exact, world coordinates elsewhere
    origin = frame_origin(x)
    if not all(shift_is_exact(x[:, k], origin[k]) for k in range(2)):
        origin = np.zeros(3)
    ring = edges(triangles, len(x))[0]
    return Pieces(
        sources,
        origin,
        x - origin,
        triangles,
        surface,
        np.arange(len(triangles)) - first[surface],
        np.arange(len(triangles)),
        ring,
        np.where(ring == np.arange(len(ring)), FREE, PAIRED),
        [None] * len(sources),
        np.zeros(len(sources) + 1, dtype=np.int64),
        np.repeat(np.arange(len(counts)), counts),
    )


def _unit(
    path: Path, labels: dict[str, Any], shell: np.ndarray, surface: np.ndarray, pieces: Pieces
) -> Unit:
    """One unit with its shell."""
    points, place_of = renumbered(shell)
    corners = pieces.x[shell]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * math.fsum(np.sqrt(np.square(normal).sum(axis=1)).tolist())

    # rounding moves faces by less than the last digit of coordinates
    last_digit = float(np.spacing(np.abs(corners + pieces.origin).max()))
    if (volume := volume_with_sign(corners)) < -area * last_digit:
        raise FormatError(
            f"{path}: region {labels['name']!r} is inside out. Repair the model where it was "
            "made, and export it again."
        )
    return Unit(
        **labels,
        local=pieces.x[points],
        origin=pieces.origin,
        triangles=place_of,
        surface_of_triangle=surface,
        surface_names=tuple(source.name for source in pieces.sources),
        volume=abs(volume),
        area=area,
    )


def _units(stated: Sequence[Any], parts: list[Unit], pieces: Pieces, sides: np.ndarray) -> Units:
    """All units, in the box that the file states or that encloses them."""
    x = pieces.x + pieces.origin
    low, high = x.min(axis=0), x.max(axis=0)
    box = tuple(np.column_stack([low, high]).ravel().tolist())
    footprint, enclosed = None, math.fsum(unit.volume for unit in parts)
    # as a scene has it by default; zones of other programs have other names
    ends = {f"{word} {s.name}" for s in pieces.sources for word in ("above", "below")}
    reservoir = [unit.zone for unit in parts if unit.zone not in ends]
    if (
        len(stated) == 10
        and all(isinstance(value, int | float) for value in stated[1:9])
        and isinstance(stated[9], list)
    ):
        _, *of_box, footprint, enclosed, chosen = stated
        box, reservoir = tuple(of_box), [str(zone) for zone in chosen]
    units = Units(
        parts,
        box,
        reservoir=reservoir or None,
        footprint=footprint,
        enclosed=enclosed,
        sides=lambda: sides,
        piece_sides=lambda: (pieces, sides),
    )
    for unit in parts:
        in_crs_of(unit, pieces.sources)
    return in_crs_of(units, pieces.sources)


def read_units(
    path: str | PathLike[str], *, positive: str | None = None, length_unit: str | None = None
) -> Units:
    """
    Read the units of a sealed model: GOCAD Model3d (``.ml``), or RESQML 2.0.1 (``.epc``).

    Parameters
    ----------
    path : path-like
    positive : {"up", "down"}, optional
        For ``.ml`` without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    length_unit : str, optional
        Unit of elevations, for ``.ml`` without AXIS_UNIT; default ``"m"``. RESQML states both.

    Returns
    -------
    Units
        One for each region but ``Universe``, in the order of the file. ``zone`` is the layer of the
        region and ``block`` its fault block; the region's own name stands where the file has none.
        RESQML names the zone of a region only.
        Models that geosurf wrote come back with all labels.

    Raises
    ------
    FormatError
        If the file is neither of both, has no regions, or a region is not closed; or a line cannot
        be understood.
    InputError
        If `positive` or `length_unit` contradicts the file or is unknown.
    DependencyError
        If the file is RESQML and h5py is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=5)
    >>> units = gs.Scene(world.horizons, world.faults, world.box).units
    >>> (file,) = gs.write(units, pathlib.Path(tempfile.mkdtemp()) / "model.ml")
    >>> list(read_units(file)) == list(units)
    True
    """
    path = path_of(path, "read_units")
    if detect(path) == "resqml":
        return units_of(resqml_model(path, Request(positive=positive, length_unit=length_unit)))
    return units_of(_model(path, Request(positive=positive, length_unit=length_unit)))


def _model(path: Path, request: Request) -> SealedModel:
    """What a Model3d states."""
    lines = read_text(path, final_line_end=False).split("\n")
    roles = roles_of(path, lines)
    regions = [(name, signed) for name, signed, _ in region_lists(path, lines)]
    if not any(name != "Universe" for name, _ in regions):
        raise FormatError(
            f"{path}: the model has no regions. Read its surfaces with "
            "geosurf.read.model3d.read_model3d and build a Scene of them."
        )
    tsurfs = read_tsurf(path, request)
    sources = list(surfaces_of(path, lines, roles, tsurfs).values())
    counts = part_counts(path, lines, sum(len(one.triangles) for one in tsurfs))
    inside = [(name, signed) for name, signed in regions if name != "Universe"]
    own = own_lines(path, lines, "model")
    labels = _labels(path, lines, inside)
    box = own[0] if own else ()
    return SealedModel(path, tsurfs, sources, counts, inside, labels, box, "TFACE")


def _labels(
    path: Path, lines: list[str], regions: list[tuple[str, list[int]]]
) -> list[dict[str, Any]]:
    """Labels of each unit."""
    own = own_lines(path, lines, "unit")
    if own:
        return labels_of(path, own, len(regions), "the header")
    return _labels_of_groups(lines, [name for name, _ in regions])


def _labels_of_groups(lines: list[str], names: list[str]) -> list[dict[str, Any]]:
    """Labels of units by the layers and fault blocks of the file."""
    zones, blocks = _groups(lines, "LAYER"), _groups(lines, "FAULT_BLOCK")
    pairs = [
        (zones.get(number, name), blocks.get(number, "whole"))
        for number, name in zip(_region_numbers(lines), names, strict=True)
    ]
    order = list(dict.fromkeys(zone for zone, _ in pairs))
    return [
        {
            "name": name,
            "zone": zone,
            "zone_index": order.index(zone),
            # regions that share layer and block have their own names as blocks
            "block": block if pairs.count((zone, block)) == 1 else name,
        }
        for name, (zone, block) in zip(names, pairs, strict=True)
    ]


def _region_numbers(lines: list[str]) -> list[int]:
    """Number of each region but ``Universe``."""
    words = (line.split(maxsplit=2) for line in lines if line.startswith("REGION "))
    return [int(w[1]) for w in words if len(w) == 3 and w[2].strip() != "Universe"]


def _groups(lines: list[str], key: str) -> dict[int, str]:
    """Name of the LAYER or FAULT_BLOCK that lists each number."""
    groups: dict[int, str] = {}
    title = None
    for line in lines:
        words = line.split()
        if words == ["END"]:
            break
        if words[:1] == [key]:
            title = " ".join(words[1:])
        elif title is not None and all(word.isdecimal() for word in words):
            groups.update((int(word), title) for word in words if word != "0")
            title = None if "0" in words else title
        else:
            title = None
    return groups


# a surface with what geosurf wrote about it, and the number of its first part by index of patch
Listed = tuple[TriSurface, str, str, dict[int, int]]


def resqml_model(path: Path, request: Request) -> SealedModel:
    """
    Read the sealed volume framework of a package.

    Parameters
    ----------
    path : pathlib.Path
    request : Request
        `positive`, `length_unit`: What a caller states: it has to agree with the file.

    Raises
    ------
    FormatError
        If there is not exactly one framework, or it names what is not in the package.
    InputError
        If `positive` or `length_unit` contradicts the file.
    DependencyError
        If h5py is not installed.
    """
    with open_package(path) as package:
        framework = _framework(package)
        counts: list[int] = []
        surfaces = [
            _surface(package, mesh_node, request, counts)
            for mesh_node in _meshes(package, framework)
        ]
        regions = _regions(package, framework, [mesh_node[3] for mesh_node in surfaces])
        stated = _metadata(package, framework, "unit")
        box = _metadata(package, framework, "model")
    labels = (
        labels_of(path, stated, len(regions), "its metadata")
        if stated
        else _labels_of_zones([zone for zone, _ in regions])
    )
    return SealedModel(
        path,
        [mesh for mesh, *_ in surfaces],
        [welded(mesh, role).renamed(name, role) for mesh, name, role, _ in surfaces],
        counts,
        [
            (mesh_node["name"], signed)
            for mesh_node, (_, signed) in zip(labels, regions, strict=True)
        ],
        labels,
        box[0] if box and isinstance(box[0], list) else (),
        "patch",
    )


def _framework(package: Package) -> Element:
    """The only sealed volume framework."""
    frameworks = [node for node in package.objects.values() if kind(node) == FRAMEWORK]
    if len(frameworks) != 1:
        raise FormatError(
            f"{package.path}: the package has {len(frameworks)} sealed volume frameworks, expected "
            "1. Read its surfaces with read_horizon and read_fault, and build a Scene of them."
        )
    return frameworks[0]


def _meshes(package: Package, framework: Element) -> list[Representation]:
    """The surfaces that the frameworks list, in their order."""
    listed = every(package.referred(framework, "BasedOn"), "Representation")
    by_node = {
        id(representation.node): representation for representation in representations(package)
    }
    meshes = []
    for representation in listed:
        node = package.referred(representation)
        mesh = by_node.get(id(node))
        if mesh is None or mesh.kind != MESH:
            raise FormatError(
                f"{package.path}: the sealed framework is made of {kind(node)}; geosurf reads "
                f"those of {MESH}. Export the model as triangles."
            )
        meshes.append(mesh)
    return meshes


def _surface(package: Package, mesh: Representation, request: Request, counts: list[int]) -> Listed:
    """A surface, its name and role, and the number of each of its patches; counts grow."""
    stated = _metadata(package, mesh.node, "surface")
    name, role = (
        stated[0] if stated and _are_words(stated[0]) else (mesh.title, mesh.role or "surface")
    )
    part_of_patch = {}
    for patch in every(mesh.node, "TrianglePatch"):
        part_of_patch[package.count(patch, "PatchIndex")] = len(counts) + 1
        counts.append(values_of(package, package.need(patch, "Triangles")).size // 3)
    return mesh_of(package, mesh, request, role), name, role, part_of_patch


def _are_words(value: Any) -> bool:
    """Whether a value is a name and a role."""
    return (
        isinstance(value, list)
        and len(value) == 2
        and isinstance(value[0], str)
        and value[1] in ROLES
    )


def _regions(
    package: Package, framework: Element, parts: list[dict[int, int]]
) -> list[tuple[str, list[int]]]:
    """Zone of each region, and the parts around it, positive where their front faces it."""
    regions: list[tuple[str, list[int]]] = []
    for region in every(framework, "Regions"):
        zone = package.text(region, "Represents", "Title")
        signed = []
        for shell in [package.need(region, "ExternalShell"), *every(region, "InternalShells")]:
            for face in every(shell, "MacroFaces"):
                which = package.count(face, "RepresentationIndex")
                patch = package.count(face, "PatchIndexOfRepresentation")
                if which >= len(parts) or patch not in parts[which]:
                    raise package.damaged(
                        f"region {len(regions)} names patch {patch} of surface {which}, which is "
                        "not in the framework"
                    )
                front = package.text(face, "SideIsPlus").lower() in ("true", "1")
                signed.append(parts[which][patch] * (1 if front else -1))
        regions.append((zone, signed))
    if not regions:
        raise package.damaged("the sealed volume framework has no regions")
    return regions


def _metadata(package: Package, node: Element, name: str) -> list[Any]:
    """What geosurf wrote about an object, in the order of the file."""
    entries: list[Any] = []
    for entry in every(node, "ExtraMetadata"):
        key = word_of(entry, "Name")
        if key != f"geosurf.{name}":
            continue
        try:
            entries.append(json.loads(package.text(entry, "Value")))
        except (ValueError, RecursionError) as error:
            raise package.damaged(f"the metadata {key!r} is damaged") from error
    return entries


def _labels_of_zones(zones: list[str]) -> list[dict[str, Any]]:
    """Labels of regions that state their zone only."""
    order = list(dict.fromkeys(zones))
    labels = []
    for k, zone in enumerate(zones):
        alone = zones.count(zone) == 1
        nth = zones[: k + 1].count(zone)
        labels.append(
            {
                "name": zone if alone else f"{zone} {nth}",
                "zone": zone,
                "zone_index": order.index(zone),
                "block": "whole" if alone else str(nth),
            }
        )
    return labels
