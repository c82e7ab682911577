"""A sealed model in a RESQML package: the regions of a sealed volume framework.

The framework lists, for each region, the patches of the surfaces around it and which side of them
faces it. Regions have no name; packages that geosurf wrote hold the labels of units as metadata.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from geosurf.errors import FormatError
from geosurf.model import ROLES, TriSurface
from geosurf.read._common import Request
from geosurf.read.model3d import welded
from geosurf.read.resqml.package import Package, every, find, kind, open_package, values_of
from geosurf.read.resqml.representations import (
    FRAMEWORK,
    MESH,
    Representation,
    mesh_of,
    representations,
)
from geosurf.read.sealed_model import SealedModel, labels_of

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
        surfaces = [_surface(package, one, request, counts) for one in _meshes(package, framework)]
        regions = _regions(package, framework, [one[3] for one in surfaces])
        own = _metadata(package, framework, "unit")
        box = _metadata(package, framework, "model")
    labels = (
        labels_of(path, own, len(regions), "its metadata")
        if own
        else _labels_of_zones([zone for zone, _ in regions])
    )
    return SealedModel(
        path,
        [mesh for mesh, *_ in surfaces],
        [welded(mesh, role).renamed(name, role) for mesh, name, role, _ in surfaces],
        counts,
        [(one["name"], signed) for one, (_, signed) in zip(labels, regions, strict=True)],
        labels,
        box[0] if box and isinstance(box[0], list) else (),
        "patch",
    )


def _framework(package: Package) -> Element:
    """The only sealed volume framework."""
    found = [node for node in package.objects.values() if kind(node) == FRAMEWORK]
    if len(found) != 1:
        raise FormatError(
            f"{package.path}: the package has {len(found)} sealed volume frameworks, expected 1. "
            "Read its surfaces with read_horizon and read_fault, and build a Scene of them."
        )
    return found[0]


def _meshes(package: Package, framework: Element) -> list[Representation]:
    """The surfaces that the frameworks list, in their order."""
    listed = every(package.referred(framework, "BasedOn"), "Representation")
    by_node = {id(one.node): one for one in representations(package)}
    found = []
    for one in listed:
        node = package.referred(one)
        mesh = by_node.get(id(node))
        if mesh is None or mesh.kind != MESH:
            raise FormatError(
                f"{package.path}: the sealed framework is made of {kind(node)}; geosurf reads "
                f"those of {MESH}. Export the model as triangles."
            )
        found.append(mesh)
    return found


def _surface(package: Package, one: Representation, request: Request, counts: list[int]) -> Listed:
    """A surface, its name and role, and the number of each of its patches; counts grow."""
    own = _metadata(package, one.node, "surface")
    name, role = own[0] if own and _are_words(own[0]) else (one.title, one.role or "surface")
    part_of_patch = {}
    for patch in every(one.node, "TrianglePatch"):
        part_of_patch[package.count(patch, "PatchIndex")] = len(counts) + 1
        counts.append(values_of(package, package.need(patch, "Triangles")).size // 3)
    return mesh_of(package, one, request, role), name, role, part_of_patch


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
    found: list[tuple[str, list[int]]] = []
    for region in every(framework, "Regions"):
        zone = package.text(region, "Represents", "Title")
        signed = []
        for shell in [package.need(region, "ExternalShell"), *every(region, "InternalShells")]:
            for face in every(shell, "MacroFaces"):
                which = package.count(face, "RepresentationIndex")
                patch = package.count(face, "PatchIndexOfRepresentation")
                if which >= len(parts) or patch not in parts[which]:
                    raise package.damaged(
                        f"region {len(found)} names patch {patch} of surface {which}, which is "
                        "not in the framework"
                    )
                front = package.text(face, "SideIsPlus").lower() in ("true", "1")
                signed.append(parts[which][patch] * (1 if front else -1))
        found.append((zone, signed))
    if not found:
        raise package.damaged("the sealed volume framework has no regions")
    return found


def _metadata(package: Package, node: Element, name: str) -> list[Any]:
    """What geosurf wrote about an object, in the order of the file."""
    found: list[Any] = []
    for one in every(node, "ExtraMetadata"):
        key = find(one, "Name")
        if key is None or key.text != f"geosurf.{name}":
            continue
        try:
            found.append(json.loads(package.text(one, "Value")))
        except (ValueError, RecursionError) as error:
            raise package.damaged(f"the metadata {key.text!r} is damaged") from error
    return found


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
