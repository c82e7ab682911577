"""GOCAD Model3d (``.ml``): a sealed structural model, surface by surface.

The file begins with the model's own lists, one line for each part of a surface
(``TFACE 12 normal_fault F2fault``), and goes on with one TSurf per surface. What
files in the wild do, and what is done with it:

- Parts of one surface repeat the vertices along their common border: vertices with
  equal coordinates become one, so that each surface is one welded mesh again.
- The kind of a part determines the role of the surface: ``fault``, ``normal_fault`` and
  ``reverse_fault`` a fault, ``boundary`` a wall of the model box, ``top``,
  ``intraformational``, ``unconformity`` and ``topographic`` a horizon.
- Regions, layers and fault blocks become units (`geosurf.read_units`). A scenario takes the
  surfaces only and carves its own units, which `read_regions` lets one compare with the file's.
- Lines ``*geosurf*`` of the header hold names and roles that GOCAD does not know.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.errors import FormatError
from geosurf.kernels.meshes.mesh import weld
from geosurf.model import TriSurface
from geosurf.model.base import in_crs_of
from geosurf.read._common import WHOLE, Request, read_text
from geosurf.read._gocad import quoted_words
from geosurf.read._guard import damaged
from geosurf.read.gocad import read_tsurf

HORIZON_KINDS = ("top", "intraformational", "unconformity", "topographic")


def read_model3d(
    path: str | Path, *, positive: str | None = None, length_unit: str | None = None
) -> dict[str, TriSurface]:
    r"""
    Read all surfaces of a GOCAD Model3d.

    Parameters
    ----------
    path : str or pathlib.Path
    positive : {"up", "down"}, optional
        For files without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    length_unit : str, optional
        Unit of elevations, for files without AXIS_UNIT; default ``"m"``.

    Returns
    -------
    dict of str to TriSurface
        In the order of the file. Roles as in the model: ``"horizon"`` (normals up),
        ``"fault"``, ``"wall"`` or, without a kind, ``"surface"``. Vertices in
        metres, elevation positive up, welded; properties are left out, since they may
        differ from part to part.

    Raises
    ------
    FormatError
        If the file is not a Model3d, names a surface that is not in it, holds two of
        one name, or a line cannot be understood.
    InputError
        If `positive` or `length_unit` contradicts the file or is unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "two_parts.ml"
    >>> _ = file.write_text("GOCAD Model3d 1\nTSURF F1\nTFACE 1 normal_fault F1\n  0 0 0\n"
    ...     "END\nGOCAD TSurf 1\nHEADER {\nname:F1\n}\n"
    ...     "TFACE\nVRTX 1 0 0 0\nVRTX 2 9 0 0\nVRTX 3 0 9 9\nTRGL 1 2 3\n"
    ...     "TFACE\nVRTX 4 9 0 0\nVRTX 5 9 9 9\nVRTX 6 0 9 9\nTRGL 4 5 6\nEND\n")
    >>> read_model3d(file)
    {'F1': <TriSurface 'F1' (fault): 4 vertices, 2 triangles>}
    """
    path = Path(path)
    lines = read_text(path, final_line_end=False).split("\n")
    roles = roles_of(path, lines)
    tsurfs = read_tsurf(path, Request(positive=positive, length_unit=length_unit))
    return surfaces_of(path, lines, roles, tsurfs)


def surfaces_of(
    path: Path, lines: list[str], roles: dict[str, str], tsurfs: list[TriSurface]
) -> dict[str, TriSurface]:
    """Return the TSurfs of a model by name, with their roles, welded."""
    surfaces: dict[str, TriSurface] = {}
    for part in tsurfs:
        if part.name in surfaces:
            raise FormatError(
                f"{path}: surface {part.name!r} occurs twice; names must be unique within a "
                "model. Rename one of the surfaces in the file."
            )
        surfaces[part.name] = welded(part, roles.get(part.name, "surface"))

    # a model without one of its surfaces would leak without a hint of why
    missing = [name for name in roles if name not in surfaces]
    if missing:
        raise FormatError(
            f"{path}: the model names the surface {missing[0]!r}, but the file has no such "
            f"TSurf; it has {list(surfaces)}. Export the model again, with all surfaces."
        )

    # names and roles that geosurf wrote for itself, in the order of the head
    stated = own_lines(path, lines, "surface")
    if not stated:
        return surfaces
    if len(stated) != len(roles):
        raise FormatError(
            f"{path}: the header names {len(stated)} surfaces of geosurf, but the model has "
            f"{len(roles)}. Delete the lines '*geosurf*surface' or export the model again."
        )
    labels = dict(zip(roles, stated, strict=True))
    found = [surface.renamed(*labels[name]) for name, surface in surfaces.items()]
    return {surface.name: surface for surface in found}


def own_lines(path: Path, lines: list[str], key: str) -> list[list[Any]]:
    """
    Return the values that geosurf wrote into the header of a model under a key.

    Raises
    ------
    FormatError
        If one of them is damaged.
    """
    entries, word = [], f"*geosurf*{key}:"
    for i, line in enumerate(lines, start=1):
        if line.strip() == "END":
            break
        if not line.startswith(word):
            continue
        try:
            values = json.loads(line.removeprefix(word))
        except ValueError as error:
            raise FormatError(
                f"{path}, line {i}: {line[:40]!r} is damaged. Delete the lines that begin with "
                "'*geosurf*' or export the model again."
            ) from error
        entries.append(values)
    return entries


def read_regions(
    path: str | Path, *, positive: str | None = None, length_unit: str | None = None
) -> dict[str, float]:
    r"""
    Read the regions of a GOCAD Model3d: the volume inside the parts of surfaces that bound each.

    Parameters
    ----------
    path : str or pathlib.Path
    positive, length_unit
        As for `read_model3d`.

    Returns
    -------
    dict of str to float
        Volume of each region [m3], by the divergence theorem, in the order of the file; without
        ``Universe``, which is all that lies outside. Empty if the file has none.

    Raises
    ------
    FormatError
        If a region names a part that is not there, or its list has no end.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "corner.ml"
    >>> faces = ["1 3 2", "1 2 4", "2 3 4", "1 4 3"]
    >>> parts = "".join(f"TFACE\nTRGL {face}\n" for face in faces)
    >>> _ = file.write_text("GOCAD Model3d 1\nTSURF A\nREGION 5 Corner\n  +1 +2 +3 +4 0\nEND\n"
    ...     "GOCAD TSurf 1\nHEADER {\nname:A\n}\nTFACE\nVRTX 1 0 0 0\nVRTX 2 6 0 0\nVRTX 3 0 6 0\n"
    ...     "VRTX 4 0 0 6\n" + parts.removeprefix("TFACE\n") + "END\n")
    >>> read_regions(file)
    {'Corner': 36.0}
    """
    shells = read_region_faces(path, positive=positive, length_unit=length_unit)
    return {name: abs(volume_with_sign(corners)) for name, corners in shells.items()}


def volume_with_sign(corners: np.ndarray) -> float:
    """Volume [m3] inside a closed shell of triangles (n, 3, 3), below 0 if they look inward."""
    if len(corners) == 0:
        return 0.0
    # Relative to the mean, so that products of large coordinates do not lose digits.
    a, b, c = np.moveaxis(corners - corners.reshape(-1, 3).mean(axis=0), 1, 0)
    return math.fsum(((np.cross(a, b) * c).sum(axis=1) / 6.0).tolist())


def read_region_faces(
    path: str | Path, *, positive: str | None = None, length_unit: str | None = None
) -> dict[str, np.ndarray]:
    """
    Read the closed shells of the regions of a sealed model.

    Parameters
    ----------
    path : str or pathlib.Path
    positive, length_unit
        As for `read_model3d`.

    Returns
    -------
    dict of str to ndarray of float64, shape (n, 3, 3)
        Corners of the triangles around each region, all outward or all inward [m].

    Raises
    ------
    FormatError
        As `read_regions`.
    """
    path = Path(path)
    lines = read_text(path, final_line_end=False).split("\n")

    # The number of a TFACE counts from 1; its sign is the side that faces the region.
    parts = _corners_of_parts(path, lines, positive, length_unit)
    faces = {}
    for name, signed, line in region_lists(path, lines):
        wrong = [k for k in signed if abs(k) > len(parts)]
        if wrong:
            raise FormatError(
                f"{path}, line {line}: region {name!r} names TFACE {abs(wrong[0])}, but the "
                f"file has {len(parts)}. Export the model again, with all surfaces."
            )
        if name != "Universe":
            # each part turned so that its normals point the same way with regard to the region
            turned = [parts[abs(k) - 1][:, :: 1 if k > 0 else -1] for k in signed]
            faces[name] = np.concatenate([np.empty((0, 3, 3)), *turned])
    return faces


def _corners_of_parts(
    path: Path, lines: list[str], positive: str | None, length_unit: str | None
) -> list[np.ndarray]:
    """Corners (n, 3, 3) of the triangles of each TFACE, in the order of the file."""
    surfaces = read_tsurf(path, Request(positive=positive, length_unit=length_unit))

    # TFACEs follow one another in the file as their triangles do in the surfaces.
    corners = np.concatenate([surface.vertices[surface.triangles] for surface in surfaces])
    return np.split(corners, np.cumsum(part_counts(path, lines, len(corners)))[:-1])


def part_counts(path: Path, lines: Sequence[str], n_triangle: int) -> list[int]:
    """Return the number of triangles of each TFACE, in the order of the file.

    Raises
    ------
    FormatError
        If triangles belong to no TFACE.
    """
    counts: list[int] = []
    for line in lines:
        if line.startswith("TRGL ") and counts:
            counts[-1] += 1
        elif line.startswith("VRTX "):  # most of the others: no words are needed
            continue
        elif line.split() == ["TFACE"]:
            counts.append(0)
        elif line.split()[:1] == ["TRGL"] and counts:
            counts[-1] += 1
    if sum(counts) != n_triangle:
        raise damaged(
            f"{path}: only {sum(counts)} of {n_triangle} triangles belong to a TFACE. Regions "
            "refer to TFACE numbers"
        )
    return counts


def region_lists(path: Path, lines: list[str]) -> Iterator[tuple[str, list[int], int]]:
    """Name, signed TFACE numbers and line of each REGION; a list ends with 0."""
    for i, line in enumerate(lines, start=1):
        words = line.split(maxsplit=2)
        if words[:1] == ["END"]:
            return
        if words[:1] != ["REGION"] or len(words) < 3:
            continue
        signed: list[int] = []
        # Numbers up to a 0, perhaps over several lines.
        for more in islice(lines, i, None):
            numbers = more.split()
            if not all(WHOLE.fullmatch(word) for word in numbers):
                break
            signed += map(int, numbers)
            if 0 in signed:
                break
        if 0 not in signed:
            raise FormatError(
                f"{path}, line {i}: the list of region {words[2].strip()!r} does not end with "
                "0. Add the 0 or export the model again."
            )
        yield words[2].strip(), signed[: signed.index(0)], i


def roles_of(path: Path, lines: list[str]) -> dict[str, str]:
    """Role of each surface that the head of a Model3d names, in its order."""
    # a Model3d says so on its first line; single surfaces have another reader
    first = lines[0].split() if lines else []
    if [word.lower() for word in first[:2]] != ["gocad", "model3d"]:
        found = lines[0][:40] if lines else ""
        raise FormatError(
            f"{path}, line 1: found {found!r}, expected 'GOCAD Model3d 1'. Read single "
            "surfaces (GOCAD TSurf) with read_fault."
        )
    roles: dict[str, str] = {}
    for i, line in enumerate(lines[1:], start=2):
        words = quoted_words(line)
        if words[:1] == ["END"]:
            return roles
        if words[:1] == ["TSURF"] and len(words) > 1:
            roles.setdefault(" ".join(words[1:]), "surface")
        elif words[:1] == ["TFACE"]:
            if len(words) < 4:
                raise damaged(
                    f"{path}, line {i}: TFACE has {len(words) - 1} words, expected 3 (number, "
                    "kind, surface)"
                )
            roles[" ".join(words[3:])] = _role(words[2])
    raise damaged(f"{path}: the model that begins on line 1 has no END")


def _role(kind: str) -> str:
    """What a kind of TFACE is here."""
    word = kind.lower()
    if word.endswith("fault"):
        return "fault"
    if word == "boundary":
        return "wall"
    return "horizon" if word in HORIZON_KINDS else "surface"


def welded(surface: TriSurface, role: str) -> TriSurface:
    """Return a surface with one vertex per place; horizons are turned so that normals point up."""
    # Parts repeat the vertices on their seams: the first in each place stays.
    # backwards, so that the first vertex of each place is written last, and stays
    number, count = weld(surface.vertices)
    vertices = np.empty((count, 3))
    vertices[number[::-1]] = surface.vertices[::-1]
    triangles = number[surface.triangles]

    # Normals of a horizon point up in the mean.
    if role == "horizon":
        # the sum of area vectors: what most of the surface shows
        a, b, c = (vertices[triangles[:, k]] for k in range(3))
        if np.cross(b - a, c - a)[:, 2].sum() < 0:
            triangles = triangles[:, [0, 2, 1]]
    return in_crs_of(TriSurface(surface.name, role, vertices, triangles), [surface])
