"""VTK XML PolyData and MultiBlock, written by hand.

A few lines of XML with base64 arrays: float64 stays exact, the bytes are the same
on every run, names travel as field data, and drawing libraries stay unloaded.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions.crs import crs_of
from geosurf.errors import OutputError
from geosurf.model import Curves, Patches, TriSurface, Unit, Units
from geosurf.write.written import FileSet, Loss

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr


# ---- vti ----------------------------------------
# VTK XML ImageData: regular grids of cells, such as block models.


AXES = ("easting", "northing", "elevation")
UNEVEN = 1e-6  # of a step, that steps may differ by: VTK stores one step


def vti_of_grid(dataset: xr.Dataset, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return a regular grid: its places are the middles of cells, its variables cell data.

    Names become whole numbers; field data list them, as ``unit_names`` for ``unit``.
    """
    steps, first = _steps(dataset)
    shape = [dataset.sizes[axis] for axis in AXES]
    cells, words = {}, {"name": [name or "grid"]}
    if (crs := crs_of(dataset)) is not None:
        words["crs"] = [crs]
    for key, variable in dataset.data_vars.items():
        if set(variable.dims) != set(AXES):
            raise OutputError(
                f"{key!r} lies along {variable.dims}, not along {AXES[::-1]}: VTK image data hold "
                "grids only. Drop it, or write .nc."
            )
        values = variable.transpose(*AXES[::-1]).values.ravel()
        if values.dtype.kind == "O":
            known, values = np.unique(values.astype(str), return_inverse=True)
            words[f"{key}_names"] = known.tolist()
            values = values.astype(np.int32)
        elif "names" in variable.attrs:
            words[f"{key}_names"] = [str(word) for word in variable.attrs["names"]]
        cells[str(key)] = values

    # cells around the places: the corner is half a step before the first
    extent = " ".join(f"0 {n}" for n in shape)
    origin = " ".join(repr(at - 0.5 * step) for at, step in zip(first, steps, strict=True))
    head = (
        f'  <ImageData WholeExtent="{extent}" Origin={attribute_xml(origin)} '
        f'Spacing="{" ".join(map(repr, steps))}">'
    )
    xml = [
        '<?xml version="1.0"?>',
        '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        head,
        *(f"    <!-- crs: {comment_xml(text)} -->" for text in words.get("crs", ())),
        "    <FieldData>",
        *(string_array_xml(key, values) for key, values in words.items()),
        "    </FieldData>",
        f'    <Piece Extent="{extent}">',
        "      <CellData>",
        *(array_xml(key, values) for key, values in cells.items()),
        "      </CellData>",
        "    </Piece>",
        "  </ImageData>",
        "</VTKFile>",
    ]
    return ("\n".join(xml) + "\n").encode("utf-8"), []


def _steps(dataset: xr.Dataset) -> tuple[list[float], list[float]]:
    """Step and first value of each axis, or an OutputError: VTK stores one step for each."""
    steps, first = [], []
    for axis in AXES:
        values: Any = dataset.coords.get(axis)
        if values is None or values.dims != (axis,):
            raise OutputError(
                f"VTK image data hold grids with the axes {AXES[::-1]}, and {axis!r} is not one of "
                "this dataset. Sample a grid: scene.sample(cell=(dx, dy, dz))."
            )
        axis_values = values.values.astype(np.float64)
        gaps = np.diff(axis_values)
        step = float(gaps.mean()) if len(gaps) else 1.0
        if len(gaps) and (step <= 0 or np.abs(gaps - step).max() > UNEVEN * step):
            raise OutputError(
                f"the steps of {axis!r} are not equal and rising: they are {gaps.min():g} to "
                f"{gaps.max():g} m. VTK image data hold equal ones. Write .nc."
            )
        steps.append(step)
        first.append(float(axis_values[0]))
    return steps, first


TYPES = {
    f"{kind}{bits // 8}": f"{word}{bits}"
    for word, kind in (("Int", "i"), ("UInt", "u"), ("Float", "f"))
    for bits in (8, 16, 32, 64)
}


def vtp_of_surface(surface: TriSurface, name: str) -> tuple[bytes, list[Loss]]:
    """Return a surface with its numeric vertex data, name and role."""
    # VTK arrays hold numbers; what is lost is said
    numeric = {k: v for k, v in surface.vertex_data.items() if v.dtype.kind in "biuf"}
    lost = [key for key in surface.vertex_data if key not in numeric]
    words_lost = f"Vertex data {lost} are not numeric and were left out."
    notes = [Loss("data", words_lost)] if lost else []
    words = {"name": [name], "role": [surface.role], **_crs(surface)}
    data = _polydata(surface.vertices, triangles=surface.triangles, point_data=numeric, words=words)
    return data, notes


def vtp_of_curves(curves: Curves, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return polylines with their pair of surfaces as cell data."""
    cell_data = {
        "surfaces": np.asarray(curves.surfaces_of_curve, dtype=np.int64).reshape(-1, 2),
        "closed": np.asarray(curves.closed, dtype=np.uint8),
    }
    words = {"name": [name or "curves"], "surface_names": list(curves.names), **_crs(curves)}
    return _polydata(curves.points, lines=curves.curves, cell_data=cell_data, words=words), []


def vtp_of_patches(patches: Patches, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return all patches with surface, parent and patch of each triangle."""
    cell_data = {
        "surface": patches.surface_of_triangle,
        "parent": patches.parent_of_triangle,
        "patch": patches.patch_of_triangle,
    }
    words = {"name": [name or "patches"], "surface_names": list(patches.names), **_crs(patches)}
    return _polydata(
        patches.vertices, triangles=patches.triangles, cell_data=cell_data, words=words
    ), []


def vtp_of_unit(unit: Unit, name: str) -> tuple[bytes, list[Loss]]:
    """Return the shell of a unit with the surface of each triangle, zone and block."""
    words = {
        "name": [name],
        "zone": [unit.zone],
        "block": [unit.block],
        **({"region": [unit.region]} if unit.region else {}),
        **({"contact": [unit.contact]} if unit.contact else {}),
        "surface_names": list(unit.surface_names),
        **_crs(unit),
    }
    return _polydata(
        unit.vertices,
        triangles=unit.triangles,
        cell_data={"surface": unit.surface_of_triangle},
        words=words,
    ), []


def vtm_of_units(units: Units, path: Path, name: str | None, crs: str | None) -> FileSet:
    """Return the files of a multiblock; units have their own names and their own system."""
    files: dict[PurePath, bytes] = {}
    stem = path.stem
    entries = []
    for i, unit in enumerate(units.values()):
        # File names keep letters and digits only; the index keeps the true name.
        slug = re.sub(r"[^A-Za-z0-9+-]+", "_", unit.name).strip("_") or "unit"
        file = PurePath(stem) / f"{i:03d}_{slug[:60]}.vtp"
        files[file] = vtp_of_unit(unit, unit.name)[0]
        entries.append(
            f'    <DataSet index="{i}" name={attribute_xml(unit.name)} '
            f"file={attribute_xml(file.as_posix())}/>"
        )
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="vtkMultiBlockDataSet" version="1.0" byte_order="LittleEndian">',
        "  <vtkMultiBlockDataSet>",
        *entries,
        "  </vtkMultiBlockDataSet>",
        "</VTKFile>",
    ]

    # the index is made last, when all its parts are known
    files[PurePath(f"{stem}.vtm")] = ("\n".join(lines) + "\n").encode("utf-8")
    return files, [], None


def _crs(obj: Any) -> dict[str, list[str]]:
    """Field data of the coordinate reference system, if there is one."""
    return {"crs": [obj.crs]} if obj.crs else {}


def _polydata(
    points: np.ndarray,
    *,
    triangles: np.ndarray | None = None,
    lines: Sequence[np.ndarray] = (),
    point_data: Mapping[str, Any] | None = None,
    cell_data: Mapping[str, Any] | None = None,
    words: Mapping[str, Sequence[str]] | None = None,
) -> bytes:
    """Assemble the XML of one piece: triangles or polylines."""
    # VTK counts cells by where their corners end in one list of all corners
    n_triangle = 0 if triangles is None else len(triangles)
    ends = np.cumsum([len(line) for line in lines], dtype=np.int64)
    joined = np.concatenate([*lines, np.empty(0, dtype=np.int64)]).astype(np.int64)
    head = (
        f'    <Piece NumberOfPoints="{len(points)}" NumberOfVerts="0" '
        f'NumberOfLines="{len(lines)}" NumberOfStrips="0" NumberOfPolys="{n_triangle}">'
    )
    xml = [
        '<?xml version="1.0"?>',
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        "  <PolyData>",
        *(f"    <!-- crs: {comment_xml(text)} -->" for text in (words or {}).get("crs", ())),
        "    <FieldData>",
        *(string_array_xml(key, values) for key, values in (words or {}).items()),
        "    </FieldData>",
        head,
        "      <PointData>",
        *(array_xml(key, value) for key, value in (point_data or {}).items()),
        "      </PointData>",
        "      <CellData>",
        *(array_xml(key, value) for key, value in (cell_data or {}).items()),
        "      </CellData>",
        "      <Points>",
        array_xml("Points", np.asarray(points, dtype=np.float64).reshape(-1, 3)),
        "      </Points>",
    ]
    if lines:
        xml += ["      <Lines>", array_xml("connectivity", joined), array_xml("offsets", ends)]
        xml += ["      </Lines>"]
    if triangles is not None:
        # corners of all triangles in one list; offsets: where each one ends
        corners = np.asarray(triangles, dtype=np.int64).ravel()
        offsets = np.arange(3, 3 * n_triangle + 1, 3, dtype=np.int64)
        xml += ["      <Polys>", array_xml("connectivity", corners), array_xml("offsets", offsets)]
        xml += ["      </Polys>"]
    xml += ["    </Piece>", "  </PolyData>", "</VTKFile>"]
    return ("\n".join(xml) + "\n").encode("utf-8")


def array_xml(name: str, values: Any) -> str:
    """Return one DataArray: byte count and values, little-endian, base64."""
    array = np.asarray(values)

    # VTK has no truth values: 0 and 1 in bytes
    if array.dtype.kind == "b":
        array = array.astype(np.uint8)
    width = int(np.prod(array.shape[1:], dtype=np.int64))
    kind = TYPES[f"{array.dtype.kind}{array.dtype.itemsize}"]
    raw = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).tobytes()

    # the byte count comes first, in the type that the header names
    text = base64.b64encode(np.array([len(raw)], dtype="<u8").tobytes() + raw).decode("ascii")
    return (
        f'        <DataArray type="{kind}" Name={attribute_xml(name)} '
        f'NumberOfComponents="{width}" format="binary">{text}</DataArray>'
    )


def string_array_xml(name: str, values: Sequence[str]) -> str:
    """Return an Array of strings: VTK stores character codes, each string ended by 0."""
    # character codes as numbers: any letter fits into plain text
    codes = b"".join(value.encode("utf-8") + b"\0" for value in values)
    text = " ".join(str(code) for code in codes)
    return (
        f'      <Array type="String" Name={attribute_xml(name)} NumberOfTuples="{len(values)}" '
        f'format="ascii">{text}</Array>'
    )


def comment_xml(text: str) -> str:
    """Text for a comment, for those who look into a file: field data hold it as numbers."""
    return "".join(c if c.isprintable() and c != "-" else " " for c in text)


def attribute_xml(text: str) -> str:
    """Quote text for an XML attribute; control characters cannot be held."""
    plain = "".join(c if c.isprintable() else " " for c in text)
    return f'"{escape(plain)}"'
