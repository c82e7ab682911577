"""GOCAD text: TSurf for surfaces and unit shells, PLine for curves.

Numbers give the same float64 back, so that a round trip is exact. NaN properties become the
no-data value.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from geosurf.conventions.crs import label
from geosurf.errors import OutputError
from geosurf.model import Curves, TriSurface, Unit
from geosurf.write.text_grids import Part, rows_text
from geosurf.write.written import Loss, name_lost

NO_DATA = -99999.0


def tsurf(surface: TriSurface, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return a TSurf file of a surface, with numeric vertex data as properties."""
    # A property has one or more columns for each vertex; GOCAD takes numbers only.
    numeric = {
        key: value.reshape(len(value), -1).astype(np.float64)
        for key, value in surface.vertex_data.items()
        if value.dtype.kind in "biuf" and value.size
    }

    # what the format cannot hold is said, never dropped in silence
    lost = [key for key in surface.vertex_data if key not in numeric]
    words = f"Vertex data {lost} are not numeric and were left out."
    notes = [*([Loss("data", words)] if lost else []), *name_lost(name, gocad_name(name))]

    lines: list[str | bytes | bytearray] = [*_head("TSurf", name, surface.crs)]
    if numeric:
        lines += _property_lines({key: value.shape[1] for key, value in numeric.items()})

        # No value may look like the mark of absent values, since it would be read as absent.
        table = np.concatenate(list(numeric.values()), axis=1)
        if np.isinf(table).any() or (table == NO_DATA).any():
            raise OutputError(
                f"surface {name!r}: vertex data hold infinite values or {NO_DATA}, which means "
                "'no data' in GOCAD. Write .vtp, or change those values to NaN."
            )
        vertices = np.concatenate([surface.vertices, np.where(np.isnan(table), NO_DATA, table)], 1)
        word = "PVRTX"
    else:
        vertices, word = surface.vertices, "VRTX"

    # One TFACE holds all vertices and triangles, so that no vertex is repeated.
    lines.append("TFACE")
    lines += vertex_lines(word, vertices)
    lines += triangle_lines(surface.triangles)
    return _encoded(lines), notes


def tsurf_of_unit(unit: Unit, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return a TSurf file of a shell; one TFACE, since xtgeo reads no second one."""
    lines: list[str | bytes | bytearray] = [*_head("TSurf", name, unit.crs), "TFACE"]
    lines += vertex_lines("VRTX", unit.vertices)

    # surface by surface, as they bound the unit
    order = np.argsort(unit.surface_of_triangle, kind="stable")
    lines += triangle_lines(unit.triangles[order])
    words = (
        "Which surface each triangle lies on is not in the file. Write all units as .ml, or .vtp."
    )
    return _encoded(lines), [Loss("data", words), *name_lost(name, gocad_name(name))]


def pline(curves: Curves, name: str | None) -> tuple[bytes | bytearray, list[Loss]]:
    """Return a PLine file: one object per pair of surfaces, one ILINE per curve."""
    lines: list[str | bytes | bytearray] = []
    lost: list[Loss] = []

    # sorted, so that the bytes do not depend on the order of curves
    pairs = sorted({tuple(pair) for pair in curves.surfaces_of_curve.tolist()})
    for pair in pairs:
        title = " x ".join(curves.names[row] for row in pair)
        title = title if name is None else f"{name} {title}"
        lines += _head("PLine", title, curves.crs)
        lost += name_lost(title, gocad_name(title))
        n_written = 0

        # Ids count on from curve to curve of one object.
        for curve, owner in zip(curves.curves, curves.surfaces_of_curve.tolist(), strict=True):
            if tuple(owner) != pair:
                continue
            # A closed curve repeats its first point, but not its vertex.
            closed = len(curve) > 2 and curve[0] == curve[-1]
            rows = curve[:-1] if closed else curve
            ids = np.arange(n_written + 1, n_written + 1 + len(rows))
            ends = np.append(ids, ids[0]) if closed else ids
            lines.append("ILINE")
            lines += vertex_lines("VRTX", curves.points[rows], first=n_written + 1)
            lines += [f"SEG {a} {b}" for a, b in itertools.pairwise(ends)]
            n_written += len(rows)
        lines.append("END")
    if not lines:
        raise OutputError(
            "there are no curves to write, and a PLine file needs at least one. Write .vtp instead."
        )
    # The last END is added with the bytes.
    return _encoded(lines[:-1]), lost


def gocad_name(name: str) -> str:
    """Return a name as the header of an object holds it: on one line, without braces."""
    return " ".join(name.split()).replace("{", "(").replace("}", ")")


def _head(kind: str, name: str, crs: str | None) -> list[str]:
    """First lines of an object; a coordinate system without a name is ``Default``."""
    return [
        f"GOCAD {kind} 1",
        "HEADER {",
        f"name:{gocad_name(name)}",
        "}",
        coordinate_system(crs).rstrip("\n"),
    ]


def coordinate_system(crs: str | None) -> str:
    """Return the block of the coordinate system: metres, elevation."""
    return (
        "GOCAD_ORIGINAL_COORDINATE_SYSTEM\n"
        + ("NAME Default\n" if crs is None else f'NAME "{_system(crs)}"\n')
        + 'AXIS_NAME "X" "Y" "Z"\n'
        'AXIS_UNIT "m" "m" "m"\n'
        "ZPOSITIVE Elevation\n"
        "END_ORIGINAL_COORDINATE_SYSTEM\n"
    )


def _system(crs: str) -> str:
    """Return a coordinate reference system on one line, without quotes: of WKT, its name."""
    # GOCAD has one line for a system: WKT does not fit, its name does
    text = label(crs) if '"' in crs else crs
    return " ".join(text.replace('"', "'").replace("\\", "/").split())


def vertex_lines(word: str, vertices: np.ndarray, first: int = 1) -> list[bytearray]:
    """Lines of vertices; CNXYZ (moved along all axes) is what some readers know a vertex by."""
    if not len(vertices):
        return []
    parts: list[Part] = [f"{word} ".encode(), np.arange(first, first + len(vertices))]
    for column in vertices.T:
        parts += [b" ", column]
    return [rows_text([*parts, b" CNXYZ\n"])]


def triangle_lines(triangles: np.ndarray) -> list[bytearray]:
    """Lines of triangles (n, 3), rows of vertices counted from 0."""
    if not len(triangles):
        return []
    a, b, c = (triangles + 1).T
    return [rows_text([b"TRGL ", a, b" ", b, b" ", c, b"\n"])]


def _property_lines(sizes: dict[str, int]) -> list[str]:
    """Header of properties with their sizes; OpenGeode reads none without all of these lines."""
    names = " ".join(_quoted(key) for key in sizes)
    n = len(sizes)
    return [
        f"PROPERTIES {names}",
        "PROP_LEGAL_RANGES" + " **none** **none**" * n,
        "NO_DATA_VALUES" + f" {NO_DATA!r}" * n,
        f"PROPERTY_CLASSES {names}",
        "PROPERTY_KINDS" + ' "Real Number"' * n,
        "PROPERTY_SUBCLASSES" + " QUANTITY Float" * n,
        "ESIZES " + " ".join(map(str, sizes.values())),
        "UNITS" + " unitless" * n,
    ]


def _quoted(key: str) -> str:
    clean = " ".join(key.replace('"', "'").split())
    return f'"{clean}"' if " " in clean or "'" in clean or not clean else clean


def _encoded(lines: Sequence[str | bytes | bytearray]) -> bytearray:
    """One text of single lines and of blocks of lines, which are bytes that end with a line end."""
    data = bytearray()
    for line in [*lines, "END"]:
        data += line if not isinstance(line, str) else f"{line}\n".encode()
    return data
