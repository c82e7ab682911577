"""Tables and grids: csv and Parquet, CF NetCDF and Zarr through xarray.

The coordinate reference system is the attribute ``crs``, and for other programs the grid mapping
``spatial_ref``, as rioxarray and GDAL have it.
"""

from __future__ import annotations

import base64
import csv
import io
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path, PurePath, PurePosixPath
from typing import Any

import numpy as np

from geosurf.conventions import elevation_sign, metres_per_unit
from geosurf.conventions.axes import COORDINATES
from geosurf.conventions.crs import crs_of, epsg_of, proj_system
from geosurf.conventions.machine import need
from geosurf.errors import OutputError
from geosurf.lazy import pandas
from geosurf.lazy import xarray as xr
from geosurf.model import Curves, Patches, TriSurface, Unit, Units
from geosurf.model.patches import labels_of_triangles
from geosurf.stopping import temporary_folder
from geosurf.write.text_grids import refuse_odd_nodes
from geosurf.write.written import FileSet, Loss, declared_crs

# ---- vtp ----------------------------------------
# VTK XML PolyData and MultiBlock, written by hand.
#
# A few lines of XML with base64 arrays: float64 stays exact, the bytes are the same
# on every run, names travel as field data, and drawing libraries stay unloaded.


# ---- vti ----------------------------------------
# VTK XML ImageData: regular grids of cells, such as block models.


UNEVEN = 1e-6  # of a step, that steps may differ by: VTK stores one step


def vti_of_grid(dataset: xr.Dataset, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return a regular grid: its places are the middles of cells, its variables cell data.

    Names become whole numbers; field data list them, as ``unit_names`` for ``unit``.
    """
    steps, first = _steps(dataset)
    shape = [dataset.sizes[axis] for axis in COORDINATES]
    cells, words = {}, {"name": [name or "grid"]}
    if (crs := crs_of(dataset)) is not None:
        words["crs"] = [crs]
    for key, variable in dataset.data_vars.items():
        if set(variable.dims) != set(COORDINATES):
            raise OutputError(
                f"{key!r} lies along {variable.dims}, not along {COORDINATES[::-1]}: VTK image "
                "data hold grids only. Drop it, or write .nc."
            )
        values = variable.transpose(*COORDINATES[::-1]).values.ravel()
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
    piece = [f'    <Piece Extent="{extent}">', *_arrays("CellData", cells)]
    return _vtk_file("ImageData", head, words, piece), []


def _steps(dataset: xr.Dataset) -> tuple[list[float], list[float]]:
    """Step and first value of each axis, or an OutputError: VTK stores one step for each."""
    steps, first = [], []
    for axis in COORDINATES:
        values: Any = dataset.coords.get(axis)
        if values is None or values.dims != (axis,):
            raise OutputError(
                f"VTK image data hold grids with the axes {COORDINATES[::-1]}, and {axis!r} is not "
                "one of this dataset. Sample a grid: scene.sample(cell=(dx, dy, dz))."
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
    cell_data = labels_of_triangles(patches)
    words = {"name": [name or "patches"], "surface_names": list(patches.names), **_crs(patches)}
    return _polydata(
        patches.vertices, triangles=patches.triangles, cell_data=cell_data, words=words
    ), []


def vtp_of_unit(unit: Unit, name: str) -> tuple[bytes, list[Loss]]:
    """Return the shell of a unit with the surface of each triangle, zone and block."""
    words = {
        "name": [name],
        **{key: [word] for key, word in words_of_unit(unit).items()},
        "surface_names": list(unit.surface_names),
        **_crs(unit),
    }
    return _polydata(
        unit.vertices,
        triangles=unit.triangles,
        cell_data={"surface": unit.surface_of_triangle},
        words=words,
    ), []


def words_of_unit(unit: Unit) -> dict[str, str]:
    """Return zone and block of a unit, and its region and contact interval where it has some."""
    more = {"region": unit.region, "contact": unit.contact}
    words = {"zone": unit.zone, "block": unit.block}
    return words | {key: word for key, word in more.items() if word}


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
    words: Mapping[str, Sequence[str]],
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
    piece = [
        head,
        *_arrays("PointData", point_data or {}),
        *_arrays("CellData", cell_data or {}),
        *_arrays("Points", {"Points": np.asarray(points, dtype=np.float64).reshape(-1, 3)}),
    ]
    if lines:
        piece += _arrays("Lines", {"connectivity": joined, "offsets": ends})
    if triangles is not None:
        # corners of all triangles in one list; offsets: where each one ends
        corners = np.asarray(triangles, dtype=np.int64).ravel()
        offsets = np.arange(3, 3 * n_triangle + 1, 3, dtype=np.int64)
        piece += _arrays("Polys", {"connectivity": corners, "offsets": offsets})
    return _vtk_file("PolyData", "  <PolyData>", words, piece)


def _vtk_file(
    kind: str, head: str, words: Mapping[str, Sequence[str]], piece: Sequence[str]
) -> bytes:
    """A file of one piece; its field data are words, the reference system is a comment, too."""
    xml = [
        '<?xml version="1.0"?>',
        f'<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        head,
        *(f"    <!-- crs: {comment_xml(text)} -->" for text in words.get("crs", ())),
        "    <FieldData>",
        *(string_array_xml(key, values) for key, values in words.items()),
        "    </FieldData>",
        *piece,
        "    </Piece>",
        f"  </{kind}>",
        "</VTKFile>",
    ]
    return ("\n".join(xml) + "\n").encode("utf-8")


def _arrays(tag: str, arrays: Mapping[str, Any]) -> list[str]:
    """An element with some arrays."""
    found = (array_xml(key, values) for key, values in arrays.items())
    return [f"      <{tag}>", *found, f"      </{tag}>"]


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


# ---- tables ----------------------------------------
# Tables as csv and Parquet: units, wells, tops; the unit of measure is in the column name.


# what spreadsheets take for the beginning of a formula, also in the wide letters of East Asia
FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "\uff1d", "\uff0b", "\uff0d", "\uff20")
LABELS = ("zone", "block", "region", "contact", "zone_index", "reservoir", "sliver")
GUARDED = Loss(
    "data",
    "Texts that begin with = + - or @ start with an apostrophe in the file, so that "
    "spreadsheets do not run them as formulas.",
)
TABLE_ONLY = Loss("data", "The file holds the table of the units, not their surfaces; .vtm does.")

Columns = dict[str, list[Any]]


def csv_of_table(table: Any, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return the columns of a table, with full precision."""
    columns = columns_of(table)
    data, lost = csv_of_rows(list(columns), zip(*columns.values(), strict=True))
    return data, [*_not_in_tables(table), *lost]


def parquet_of_table(table: Any, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return the same by pandas and pyarrow; the metadata of pandas have the reference system."""
    columns = columns_of(table)
    need("writing Parquet needs", "pyarrow")
    frame = pandas.DataFrame(columns)
    is_frame = isinstance(table, pandas.DataFrame)
    crs = table.attrs.get("crs") if is_frame else declared_crs(table)
    if crs is not None:
        frame.attrs["crs"] = crs
    out = io.BytesIO()
    frame.to_parquet(out, engine="pyarrow", index=False)
    return out.getvalue(), _not_in_tables(table)


def _not_in_tables(table: Any) -> list[Loss]:
    return [TABLE_ONLY] if isinstance(table, Units) else []


def columns_of(table: Any) -> Columns:
    """Columns of units, of a Dataset of one dimension, or of a table of pandas without its index.

    Their names have the unit of measure.
    """
    if isinstance(table, pandas.DataFrame):
        return {str(key): table[key].tolist() for key in table.columns}
    return _of_units(table) if isinstance(table, Units) else _of_dataset(table)


def _of_units(units: Units) -> Columns:
    """Columns of the table of units: name, zone, block, contact and all numbers."""
    table = units.table
    labels = [key for key in LABELS if key in table.coords]
    numbers = [str(key) for key in table.data_vars if table[key].dims == ("unit",)]
    columns = {"unit": table["unit"].values.tolist()}
    columns |= {key: table[key].values.tolist() for key in labels}

    # the unit stands in the name of the column: csv has no other place for it
    return columns | {_head(table, key): table[key].values.tolist() for key in numbers}


def _of_dataset(table: xr.Dataset) -> Columns:
    """Columns of a Dataset whose variables all lie along one dimension.

    Values at ``end`` (entry and exit of an interval in a well) are one column for each end.
    """
    if "end" in table.dims and "end" in table.coords:
        table = _with_ends_as_columns(table)
    dims = {dim for variable in table.data_vars.values() for dim in variable.dims}
    if len(dims) != 1:
        raise OutputError(
            f"this Dataset lies along {sorted(map(str, dims))}; a table has one dimension. "
            "Write .nc instead."
        )
    # names and labels first, then what is measured
    keys = [k for k in (*table.coords, *table.data_vars) if set(table[k].dims) == dims]
    return {_head(table, str(key)): table[key].values.tolist() for key in keys}


def _with_ends_as_columns(table: xr.Dataset) -> xr.Dataset:
    """Return a Dataset with ``md_entry`` and ``md_exit`` for ``md`` at both ends."""
    columns: dict[str, xr.DataArray] = {}
    for key, variable in table.data_vars.items():
        if "end" in variable.dims:
            ends = {f"{key}_{end}": variable.sel(end=end) for end in table["end"].values.tolist()}
            columns |= {name: one.drop_vars("end") for name, one in ends.items()}
        else:
            columns[str(key)] = variable
    return table.drop_dims("end").assign(columns)[list(columns)]


def _head(table: xr.Dataset, key: str) -> str:
    """Name of a column with its unit of measure."""
    unit = table[key].attrs.get("units", "")
    return str(key) if unit in ("", "1") else f"{key}_{unit}"


def csv_of_rows(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> tuple[bytes, list[Loss]]:
    r"""
    Return csv whose words are words in spreadsheets, too, and a note if one had to be changed.

    Examples
    --------
    >>> csv_of_rows(["name", "z"], [["=1+1", -5.0], ["F1+", 2.0]])[0]
    b"name,z\n'=1+1,-5.0\nF1+,2.0\n"
    """
    lines, changed = [], False
    for row in (header, *rows):
        cells = [_guarded(cell) for cell in row]
        changed = changed or any(a is not b for a, b in zip(cells, row, strict=True))
        line = io.StringIO()
        csv.writer(line).writerow(cells)  # ends with CR LF, so that either in a cell is quoted
        lines.append(line.getvalue().removesuffix("\r\n") + "\n")
    return "".join(lines).encode("utf-8"), [GUARDED] if changed else []


def _guarded(cell: Any) -> Any:
    """A word that begins as a formula does gets an apostrophe; numbers stay numbers."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(FORMULA) else cell


# ---- zarr ----------------------------------------
# Zarr stores: block models, as the NetCDF file of the same dataset has them.
#
# Format 2, with consolidated metadata: `xarray.open_zarr` and older programs read it. The store is
# made in memory; its files then replace those of an older one together.


INDEX = ".zmetadata"  # names all arrays of the store
OF_GROUP = {INDEX, ".zgroup", ".zattrs"}
OF_ARRAY = {".zarray", ".zattrs"}


def zarr_of_grid(
    dataset: xr.Dataset, name: str | None
) -> tuple[dict[PurePosixPath, bytes], list[Loss]]:
    """Return the files of a store, by path in it; cells are named, or numbered with `names`."""
    need("Writing Zarr needs", "zarr")
    store: dict[str, Any] = {}
    whole = with_cf_words(dataset, crs_of(dataset), lists=True)
    try:
        whole.to_zarr(store, mode="w", zarr_format=2, consolidated=True)
    except (TypeError, ValueError) as error:
        raise OutputError(
            f"dataset: Zarr cannot hold it ({type(error).__name__}: {error}). Drop or convert "
            "that variable."
        ) from error
    return {PurePosixPath(key): data.to_bytes() for key, data in sorted(store.items())}, []


def is_block_model(folder: Path) -> bool:
    """
    Whether a folder holds a block model as `zarr_of_grid` makes it, and no other file.

    Only such a folder may be replaced: not an ensemble, other stores, or notes of a user.

    Parameters
    ----------
    folder : pathlib.Path

    Raises
    ------
    OSError
        If it cannot be looked at.
    """
    try:
        listed = json.loads((folder / INDEX).read_text(encoding="utf-8"))["metadata"]
        arrays = {str(key).removesuffix("/.zarray") for key in listed if key.endswith("/.zarray")}
    except (FileNotFoundError, NotADirectoryError):
        return False
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return False
    if not arrays.issuperset(COORDINATES):
        return False
    # a chunk is named by its place along each axis: 0.3.1
    for path in folder.iterdir():
        if path.is_symlink() or (path.is_dir() and path.name not in arrays):
            return False
        if path.is_dir():
            inner = [one for one in path.iterdir() if one.name not in OF_ARRAY]
            if not all(one.is_file() and one.name.replace(".", "0").isdecimal() for one in inner):
                return False
        elif path.name not in OF_GROUP:
            return False
    return True


MAPPING = "spatial_ref"  # the name that rioxarray looks for
STANDARD_NAMES = {"easting": "projection_x_coordinate", "northing": "projection_y_coordinate"}


def netcdf_of_horizon(horizon: xr.DataArray, name: str) -> tuple[bytes, list[Loss]]:
    """Return a horizon as one variable ``elevation`` (or ``depth``) with CF attributes."""
    # The name of the variable says what is positive, as CF readers expect.
    what = f"horizon {name!r}"
    sign = elevation_sign(horizon.attrs.get("positive"), what)
    metres_per_unit(horizon.attrs.get("units"), what)
    key = "elevation" if sign > 0 else "depth"

    refuse_odd_nodes(horizon, name)
    data = horizon.rename(key)
    data.attrs = dict(horizon.attrs) | {"long_name": name}
    if (crs := crs_of(horizon)) is not None:
        data.attrs["crs"] = crs
    data.attrs["standard_name"] = "height_above_mean_sea_level" if sign > 0 else "depth"
    return _bytes(data.to_dataset(), what, crs)


def netcdf_of_units(units: Units, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return the table of units; names are stored as strings."""
    need("table of units: writing NetCDF needs", "h5netcdf")
    data, losses = _bytes(units.table, "table of units", units.crs)
    return data, [TABLE_ONLY, *losses]


def netcdf_of_dataset(dataset: xr.Dataset, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return any dataset, such as a table or a parametric fault."""
    return _bytes(dataset, "dataset", crs_of(dataset))


def _bytes(dataset: xr.Dataset, what: str, crs: str | None = None) -> tuple[bytes, list[Loss]]:
    """Return NetCDF-4 bytes; attributes that it cannot hold become text."""
    need(f"{what}: writing NetCDF needs", "h5netcdf")
    dataset = with_cf_words(dataset, crs)
    # h5netcdf writes to a path; the bytes then take the way of all other files.
    with temporary_folder() as folder:
        file = Path(folder) / "out.nc"
        try:
            dataset.to_netcdf(file, engine="h5netcdf")
        except (OSError, TypeError, ValueError) as error:
            raise OutputError(
                f"{what}: NetCDF cannot hold it ({type(error).__name__}: {error}). Drop or "
                "convert that variable."
            ) from error
        return file.read_bytes(), []


def with_cf_words(dataset: xr.Dataset, crs: str | None, *, lists: bool = False) -> xr.Dataset:
    """
    Return a dataset with the attributes of CF, as its file holds it.

    Parameters
    ----------
    dataset : xarray.Dataset
    crs : str or None
        Reference system: it becomes the grid mapping ``spatial_ref``.
    lists : bool
        Whether the format holds lists of words as attributes; else they become one text.
    """
    dataset = dataset.copy()
    # encodings are those of the file it was read from, and may not fit
    dataset = dataset.drop_encoding()

    # coordinates state their unit and meaning as CF wants it, unless they do already
    dataset.attrs = _plain(dataset.attrs, lists=lists)
    for key, variable in dataset.variables.items():
        variable.attrs = _plain(variable.attrs, lists=lists)
        if key in STANDARD_NAMES:
            variable.attrs.setdefault("units", "m")
            variable.attrs.setdefault("standard_name", STANDARD_NAMES[str(key)])

    dataset.attrs.setdefault("Conventions", "CF-1.11")
    return dataset if crs is None else _with_mapping(dataset, crs)


def _with_mapping(dataset: xr.Dataset, crs: str) -> xr.Dataset:
    """Add the grid mapping ``spatial_ref`` for all variables in space, unless there is one."""
    axes = [dataset[key].dims for key in STANDARD_NAMES if key in dataset.variables]
    dims = {dim for one in axes for dim in one}
    named = [key for key, one in dataset.data_vars.items() if dims and dims <= set(one.dims)]
    if not named or any("grid_mapping" in dataset[key].attrs for key in named):
        return dataset
    mapping = dataset.variables.get(MAPPING)
    if mapping is not None and mapping.ndim:
        return dataset  # data of that name
    if mapping is None or not mapping.attrs:
        dataset = dataset.drop_vars(MAPPING, errors="ignore")
        dataset[MAPPING] = ((), 0, _mapping(crs))
    for key in named:
        dataset[key].attrs["grid_mapping"] = MAPPING
    return dataset


def _mapping(crs: str) -> dict[str, Any]:
    """Attributes of a grid mapping: those of CF where pyproj is installed, else the text alone."""
    mapping: dict[str, Any] = {"spatial_ref": crs}
    if epsg_of(crs) is not None:
        mapping["epsg_code"] = f"EPSG:{epsg_of(crs)}"
    elif "[" in crs:
        mapping["crs_wkt"] = crs
    system = proj_system(crs)
    if system is None:
        return mapping  # a name that PROJ does not know is still a text
    words = system.to_cf()
    return mapping | _plain(words) | {"spatial_ref": words.get("crs_wkt", crs)}


def _plain(attrs: dict[Any, Any], *, lists: bool = False) -> dict[str, Any]:
    """Attributes as numbers, lists of numbers, perhaps of words, or text; None is left out."""
    out: dict[str, Any] = {}
    for key, value in attrs.items():
        # HDF5 has no None, and truth values only as numbers
        array = np.asarray(value)
        if value is None:
            continue
        if isinstance(value, (bool, np.bool_)):
            out[str(key)] = int(value)
        elif array.dtype.kind in "iuf" and array.ndim <= 1:
            out[str(key)] = array.item() if array.ndim == 0 else array
        elif lists and array.ndim == 1 and all(isinstance(word, str) for word in array):
            out[str(key)] = array.tolist()
        else:
            out[str(key)] = str(value)
    return out
