"""The regions of a GOCAD Model3d as units: shells, volumes, and what lies on both sides of faces.

A region lists the parts (TFACE) around it; vertices with equal coordinates are one. The shell of
each region has to be closed, edge by edge. ``LAYER`` states the zone of a region, ``FAULT_BLOCK``
its block; models that geosurf wrote hold all labels of their units.
"""

from __future__ import annotations

import math
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted, frame_origin, place, shift_is_exact
from geosurf.errors import FormatError
from geosurf.kernels.meshes.mesh import weld
from geosurf.kernels.meshes.shells import count_open_edges
from geosurf.model import TriSurface, Unit, Units
from geosurf.model.base import in_crs_of
from geosurf.model.expected import path_of
from geosurf.model.pieces import FREE, PAIRED, Pieces
from geosurf.read._common import read_text
from geosurf.read.gocad import read_tsurf
from geosurf.read.model3d import (
    own_lines,
    part_counts,
    region_lists,
    roles_of,
    surfaces_of,
    volume_inside,
)


def read_units(
    path: str | PathLike[str], *, positive: str | None = None, length_unit: str | None = None
) -> Units:
    """
    Read the units of a sealed model: the regions of a GOCAD Model3d (``.ml``).

    Parameters
    ----------
    path : path-like
    positive : {"up", "down"}, optional
        For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    length_unit : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    Units
        One for each region but ``Universe``, in the order of the file. ``zone`` is the layer of the
        region and ``block`` its fault block; the region's own name stands where the file has none.
        Models that geosurf wrote come back with all labels.

    Raises
    ------
    FormatError
        If the file is not a Model3d, has no regions, or a region is not closed; or a line cannot
        be understood.
    InputError
        If `positive` or `length_unit` contradicts the file or is unknown.

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
    lines = read_text(path, final_line_end=False).split("\n")
    roles = roles_of(path, lines)
    regions = [(name, signed) for name, signed, _ in region_lists(path, lines)]
    if not any(name != "Universe" for name, _ in regions):
        raise FormatError(
            f"{path}: the model has no regions. Read its surfaces with "
            "geosurf.read.model3d.read_model3d and build a Scene of them."
        )
    tsurfs = read_tsurf(path, positive=positive, length_unit=length_unit)
    sources = list(surfaces_of(path, lines, roles, tsurfs).values())
    pieces = _pieces(path, lines, sources, tsurfs)

    inside = [(name, signed) for name, signed in regions if name != "Universe"]
    sides = _sides(path, inside, int(pieces.patch.max()) + 1)[pieces.patch]
    shells = _shells(path, [name for name, _ in inside], sides, pieces)
    if sum(_volume_with_sign(pieces.x[shell]) for shell, _ in shells) < 0.0:
        # programs may count the other side as +
        sides = sides[:, ::-1]
        shells = [(shell[:, ::-1], rows) for shell, rows in shells]

    labels = _labels(path, lines, inside)
    found = [
        _unit(path, one, shell, pieces.surface[rows], pieces)
        for one, (shell, rows) in zip(labels, shells, strict=True)
    ]
    return _units(path, lines, found, pieces, sides)


def _sides(path: Path, regions: list[tuple[str, list[int]]], n_part: int) -> np.ndarray:
    """Region in front of and behind each part, int64 (n_part, 2); -1 outside."""
    sides = np.full((n_part, 2), -1)
    for u, (name, signed) in enumerate(regions):
        for k in signed:
            if abs(k) > n_part:
                raise FormatError(
                    f"{path}: region {name!r} names TFACE {abs(k)}, but the file has {n_part}. "
                    "Export the model again, with all surfaces."
                )
            # + is the side into which the normal points
            side = 0 if k > 0 else 1
            if sides[abs(k) - 1, side] not in (-1, u):
                other = regions[sides[abs(k) - 1, side]][0]
                raise FormatError(
                    f"{path}: regions {other!r} and {name!r} lie on the same side of TFACE "
                    f"{abs(k)}. Correct one of the two lists or export the model again."
                )
            sides[abs(k) - 1, side] = u
    return sides


def _shells(
    path: Path, names: list[str], sides: np.ndarray, pieces: Pieces
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Outward triangles of each region, and their rows; closed, or an error."""
    triangles, x = pieces.triangles, pieces.x
    shells = []
    for u, name in enumerate(names):
        rows = np.flatnonzero((sides == u).any(axis=1) & (sides[:, 0] != sides[:, 1]))
        front = sides[rows, 0] == u
        shell = np.where(front[:, None], triangles[rows][:, ::-1], triangles[rows])

        # each edge runs once in each direction
        if count_open_edges(shell, len(x))[0]:
            tail, head = shell.ravel(), shell[:, [1, 2, 0]].ravel()
            there, back = np.sort(tail * len(x) + head), np.sort(head * len(x) + tail)
            open_edges = np.setdiff1d(there, back)
            where = x[(open_edges if len(open_edges) else there)[0] // len(x)] + pieces.origin
            raise FormatError(
                f"{path}: region {name!r} is not closed near {place(where)}: "
                f"{counted(max(len(open_edges), 1), 'edge')} without a neighbour. Repair the model "
                "where it was made, and export it again."
            )
        shells.append((shell, rows))
    return shells


def _volume_with_sign(corners: np.ndarray) -> float:
    """Six times the volume inside triangles (n, 3, 3), negative if they look inward."""
    a, b, c = np.moveaxis(corners - corners.reshape(-1, 3).mean(axis=0), 1, 0)
    return float((np.cross(a, b) * c).sum())


def _pieces(
    path: Path, lines: list[str], sources: list[TriSurface], tsurfs: list[TriSurface]
) -> Pieces:
    """All triangles as the pieces of a model, so that what works on units works on these.

    Patches are the parts of surfaces (TFACE), numbered as in the file.
    """
    # one number for each place, over all surfaces
    first = np.cumsum([0, *(len(one.vertices) for one in tsurfs)])
    points = np.concatenate([one.vertices for one in tsurfs])
    number, count = weld(points)
    x = np.empty((count, 3))
    x[number] = points
    corners = [one.triangles + k for one, k in zip(tsurfs, first, strict=False)]
    triangles = number[np.concatenate(corners)]

    n_of_surface = [len(one.triangles) for one in tsurfs]
    surface = np.repeat(np.arange(len(tsurfs)), n_of_surface)
    first = np.concatenate([[0], np.cumsum(n_of_surface)[:-1]])
    counts = part_counts(path, lines, len(triangles))

    # local coordinates where they are exact, world coordinates elsewhere
    origin = frame_origin(x)
    if not all(shift_is_exact(x[:, k], origin[k]) for k in range(2)):
        origin = np.zeros(3)
    ring = _rings(triangles, len(x))
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


def _rings(triangles: np.ndarray, n_point: int) -> np.ndarray:
    """Next half-edge around the edge of each half-edge, int64 (3 * n_triangle,)."""
    tail, head = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    key = np.minimum(tail, head) * n_point + np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    new = np.flatnonzero(np.concatenate([[True], np.diff(key[order]) != 0]))
    size = np.diff(np.append(new, len(key)))
    ring = np.empty(len(key), dtype=np.int64)
    after = np.roll(order, -1)
    after[new + size - 1] = order[new]
    ring[order] = after
    return ring


LABELS = (
    "name", "zone", "zone_index", "block", "contact", "beneath", "fault_sides", "compartment_of",
)  # fmt: skip


def _labels(
    path: Path, lines: list[str], regions: list[tuple[str, list[int]]]
) -> list[dict[str, Any]]:
    """Labels of each unit."""
    own = own_lines(path, lines, "unit")
    if own:
        if len(own) != len(regions) or any(len(values) != len(LABELS) for values in own):
            raise FormatError(
                f"{path}: the header describes {len(own)} units of geosurf, but the model has "
                f"{len(regions)} regions. Delete the lines '*geosurf*unit' or export it again."
            )
        found = [dict(zip(LABELS, values, strict=True)) for values in own]
        return [
            {**one, "beneath": tuple(one["beneath"]), "fault_sides": tuple(one["fault_sides"])}
            for one in found
        ]

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
    found: dict[int, str] = {}
    title = None
    for line in lines:
        words = line.split()
        if words == ["END"]:
            break
        if words[:1] == [key]:
            title = " ".join(words[1:])
        elif title is not None and all(word.isdecimal() for word in words):
            found.update((int(word), title) for word in words if word != "0")
            title = None if "0" in words else title
        else:
            title = None
    return found


def _unit(
    path: Path, labels: dict[str, Any], shell: np.ndarray, surface: np.ndarray, pieces: Pieces
) -> Unit:
    """One unit with its shell."""
    used = np.zeros(len(pieces.x), dtype=bool)
    used[shell] = True
    points, place_of = np.flatnonzero(used), (np.cumsum(used) - 1)[shell]
    corners = pieces.x[shell]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * math.fsum(np.sqrt(np.square(normal).sum(axis=1)).tolist())

    # rounding moves faces by less than the last digit of coordinates
    last_digit = float(np.spacing(np.abs(corners + pieces.origin).max()))
    if _volume_with_sign(corners) / 6.0 < -area * last_digit:
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
        volume=volume_inside(corners),
        area=area,
    )


def _units(
    path: Path, lines: list[str], found: list[Unit], pieces: Pieces, sides: np.ndarray
) -> Units:
    """All units, in the box that the file states or that encloses them."""
    own = own_lines(path, lines, "model")
    x = pieces.x + pieces.origin
    low, high = x.min(axis=0), x.max(axis=0)
    box = tuple(np.column_stack([low, high]).ravel().tolist())
    footprint, enclosed = None, math.fsum(unit.volume for unit in found)
    if own and len(own[0]) == 9:
        _, *of_box, footprint, enclosed = own[0]
        box = tuple(of_box)
    units = Units(
        found,
        box,
        footprint=footprint,
        enclosed=enclosed,
        sides=lambda: sides,
        piece_sides=lambda: (pieces, sides),
    )
    for unit in found:
        in_crs_of(unit, pieces.sources)
    return in_crs_of(units, pieces.sources)
