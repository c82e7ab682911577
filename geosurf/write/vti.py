"""VTK XML ImageData: regular grids of cells, such as block models."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions.crs import crs_of
from geosurf.errors import OutputError
from geosurf.write.vtp import array_xml, attribute_xml, comment_xml, string_array_xml

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

    from geosurf.write.written import Loss
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
