"""A sealed model that was read: parts of surfaces and the regions between them, as units.

A region lists the parts around it; vertices with equal coordinates are one. The shell of each
region has to be closed, edge by edge. Files are GOCAD Model3d (`geosurf.read.model3d_units`) and
RESQML (`geosurf.read.resqml.units`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted, frame_origin, place, shift_is_exact
from geosurf.errors import FormatError
from geosurf.kernels.meshes.mesh import weld
from geosurf.kernels.meshes.shells import count_open_edges
from geosurf.model import TriSurface, Unit, Units
from geosurf.model.base import in_crs_of
from geosurf.model.pieces import FREE, PAIRED, Pieces
from geosurf.read._guard import damaged
from geosurf.read.model3d import volume_inside

LABELS = (
    "name", "zone", "zone_index", "block", "contact", "beneath", "fault_sides", "compartment_of",
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
        Title, box, footprint and volume where geosurf wrote the file; else empty.
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
    if sum(_volume_with_sign(pieces.x[shell]) for shell, _ in shells) < 0.0:
        # programs may count the other side as +
        sides = sides[:, ::-1]
        shells = [(shell[:, ::-1], rows) for shell, rows in shells]
    found = [
        _unit(path, one, shell, pieces.surface[rows], pieces)
        for one, (shell, rows) in zip(model.labels, shells, strict=True)
    ]
    return _units(model.box, found, pieces, sides)


def labels_of(path: Path, own: Sequence[Any], n_region: int, where: str) -> list[dict[str, Any]]:
    """
    Return the labels of units that geosurf wrote.

    Raises
    ------
    FormatError
        If they do not fit the regions of the model.
    """
    if len(own) != n_region or any(
        not isinstance(values, list) or len(values) != len(LABELS) for values in own
    ):
        raise damaged(
            f"{path}: {where} describes {len(own)} units of geosurf, but the model has {n_region} "
            "regions"
        )
    found = [dict(zip(LABELS, values, strict=True)) for values in own]
    if not all(_are_labels(one) for one in found):
        raise damaged(f"{path}: {where} describes units of geosurf with damaged labels")
    return [
        {
            **one,
            "beneath": tuple(one["beneath"]),
            "fault_sides": tuple(one["fault_sides"]),
        }
        for one in found
    ]


def _are_labels(one: dict[str, Any]) -> bool:
    """Whether labels are of the kinds that a unit has."""
    lists = (one["beneath"], one["fault_sides"])
    words = [one[key] for key in ("name", "zone", "block", "contact", "compartment_of")]
    if not all(isinstance(values, list) for values in lists):
        return False
    words += [word for values in lists for word in values]
    return type(one["zone_index"]) is int and all(isinstance(word, str) for word in words)


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
    triangles, x = pieces.triangles, pieces.x
    shells = []
    for u, name in enumerate(names):
        rows = np.flatnonzero((sides == u).any(axis=1) & (sides[:, 0] != sides[:, 1]))
        front = sides[rows, 0] == u
        shell = np.where(front[:, None], triangles[rows][:, ::-1], triangles[rows])

        # each edge runs once in each direction
        if count_open_edges(shell, len(x))[0]:
            _refuse_open(path, name, shell, pieces)
        shells.append((shell, rows))
    return shells


def _refuse_open(path: Path, name: str, shell: np.ndarray, pieces: Pieces) -> None:
    """Raise an error that names an open edge; triangles that rounding made a line have none."""
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


def _volume_with_sign(corners: np.ndarray) -> float:
    """Six times the volume inside triangles (n, 3, 3), negative if they look inward."""
    a, b, c = np.moveaxis(corners - corners.reshape(-1, 3).mean(axis=0), 1, 0)
    return float((np.cross(a, b) * c).sum())


def _pieces(model: SealedModel) -> Pieces:
    """All triangles as the pieces of a model, so that what works on units works on these.

    Patches are the parts of surfaces, numbered as in the file.
    """
    tsurfs, sources, counts = model.meshes, model.sources, model.counts
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


def _units(own: Sequence[Any], found: list[Unit], pieces: Pieces, sides: np.ndarray) -> Units:
    """All units, in the box that the file states or that encloses them."""
    x = pieces.x + pieces.origin
    low, high = x.min(axis=0), x.max(axis=0)
    box = tuple(np.column_stack([low, high]).ravel().tolist())
    footprint, enclosed = None, math.fsum(unit.volume for unit in found)
    if len(own) == 9 and all(isinstance(value, int | float) for value in own[1:]):
        _, *of_box, footprint, enclosed = own
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
