"""Grids in text whose formats have no rotation: ZMAP+, CPS-3 and ESRI; and points of any grid.

All state their null value, so one is chosen that no node has. Numbers give the same float64 back.
Only ZMAP+ has fields of one width: eight decimals or more, as many as fit.
"""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions.crs import crs_of, label
from geosurf.errors import OutputError
from geosurf.write.decimals import LARGEST, fixed_lines_text, lines_text, n_fixed, rows_text
from geosurf.write.regular_grid import (
    Geometry,
    UprightGrid,
    direction_lost,
    node_of,
    null_for,
    refuse_odd_nodes,
    refuse_value,
    regular_grid,
    upright_grid,
)
from geosurf.write.written import SMALLEST, Loss

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr


# ---- irap ----------------------------------------
# IRAP grids, classic (text) and binary.
#
# Both hold one origin, two increments and a rotation, so only regular grids fit. The
# binary one is float32 throughout, header included: at a northing of 6 000 000 m that
# is a step of 0.5 m. What was lost is measured and stated.
#
# Suffixes follow xtgeo, which goes by them: ``.gri``, ``.irap`` and ``.irapbin`` are binary,
# ``.irapasc``, ``.irapascii`` and ``.fgr`` text.


UNDEFINED_CLASSIC = b"9999900.0"
UNDEFINED_BINARY = 1e30
UNDEFINED_FROM = 9.9e29  # readers take these for undefined: 1e30 is rounded
IRAP_PER_LINE = 6  # RMS reads at most 9


def irap_classic(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return IRAP classic text; numbers give the same float64 back."""
    (x, y, xinc, yinc, rotation), values = regular_grid(horizon, name)
    nrow, ncol = values.shape
    xmax, ymax = x + (ncol - 1) * xinc, y + (nrow - 1) * yinc
    refuse_value(values, float(UNDEFINED_CLASSIC), name, "IRAP")

    # The header has four lines: sizes and steps, limits, columns and rotation with its pivot,
    # zeros.
    head = (
        f"-996 {nrow} {xinc!r} {yinc!r}\n"
        f"{x!r} {xmax!r} {y!r} {ymax!r}\n"
        f"{ncol} {rotation!r} {x!r} {y!r}\n"
        "0 0 0 0 0 0 0\n"
    )
    text = lines_text(values.reshape(1, -1), IRAP_PER_LINE, UNDEFINED_CLASSIC, head.encode("ascii"))
    return text, direction_lost(horizon, "IRAP")


def irap_binary(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return IRAP binary, and how far float32 moved nodes and values."""
    (x, y, xinc, yinc, rotation), values = regular_grid(horizon, name)
    nrow, ncol = values.shape
    xmax, ymax = x + (ncol - 1) * xinc, y + (nrow - 1) * yinc

    if (values >= UNDEFINED_FROM).any():
        raise OutputError(
            f"horizon {name!r} has values of {UNDEFINED_FROM:g} or more, which mean 'undefined' in "
            "IRAP. Write .nc instead."
        )

    # Records of Fortran, big-endian: header fields, then one record of float32 for each row.
    single = np.where(np.isnan(values), UNDEFINED_BINARY, values).astype(">f4")
    records = [
        struct.pack(">ii6f", -996, nrow, x, xmax, y, ymax, xinc, yinc),
        struct.pack(">i3f", ncol, rotation, x, y),
        struct.pack(">7i", *[0] * 7),
        *(row.tobytes() for row in single),
    ]
    data = b"".join(struct.pack(">i", len(r)) + r + struct.pack(">i", len(r)) for r in records)
    rounding = _rounding((x, y, xinc, yinc, rotation), single, values)
    return data, [*rounding, *direction_lost(horizon, "IRAP")]


def _rounding(exact: Geometry, single: np.ndarray, values: np.ndarray) -> list[Loss]:
    """What float32 moved: nodes, farthest in a corner of the grid, and values."""
    nrow, ncol = values.shape
    rounded: Geometry = tuple(float(np.float32(value)) for value in exact)  # type: ignore[assignment]
    moved = max(
        math.dist(node_of(exact, row, column), node_of(rounded, row, column))
        for row in (0, nrow - 1)
        for column in (0, ncol - 1)
    )

    # values: rounding of float32, away from undefined nodes
    lost = np.abs(single.astype(np.float64) - values)
    largest = float(np.nanmax(lost)) if np.isfinite(lost).any() else 0.0
    if moved == largest == 0.0:
        return []
    sentence = (
        f"IRAP binary stores float32: nodes moved by up to {moved:.3g} m and values by up to "
        f"{largest:.3g}. Write .irapasc or .nc for exact values."
    )
    return [Loss("precision", sentence, max(moved, largest))]


PER_LINE = 5
WIDTH = 20  # of a field of ZMAP+, as other programs write it
ZMAP_NULLS = ("-99999.0", "1e30", "-3.4e38")
ESRI_NULLS = ("-9999", "-99999", "-3.4e38")
CPS3_NULL = "1.0E+30"


def zmap_of_horizon(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return ZMAP+ text: columns from the west, each from the north."""
    grid = _upright(horizon, name, "ZMAP+", at_least=2)
    null = null_for(grid.values, ZMAP_NULLS)
    decimals = n_fixed(grid.values, WIDTH)
    if np.abs(grid.values[~np.isnan(grid.values)]).max(initial=0.0) >= LARGEST:
        raise OutputError(
            f"horizon {name!r} has values of 1e8 or more, which the fields of ZMAP+ do not hold. "
            "Write .irapasc or .nc."
        )
    head = (
        f"! {_one_line(name)}, written by geosurf\n{_crs_line(horizon, '!')}"
        f"@{_one_line(name).replace(',', ' ')}, GRID, {PER_LINE}\n"
        f"{WIDTH}, {null}, , {decimals}, 1\n"
        f"{grid.values.shape[0]}, {grid.values.shape[1]}, "
        f"{grid.west!r}, {grid.east!r}, {grid.south!r}, {grid.north!r}\n0.0, 0.0, 0.0\n@\n"
    )
    columns = grid.values[::-1].T
    text = fixed_lines_text(columns, PER_LINE, decimals, WIDTH, null.encode(), head.encode())
    return text, direction_lost(horizon, "ZMAP+")


def cps3_of_horizon(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return CPS-3 text: columns from the west, each from the north."""
    grid = _upright(horizon, name, "CPS-3", at_least=2)
    refuse_value(grid.values, float(CPS3_NULL), name, "CPS-3")
    low = high = 0.0
    if not np.isnan(grid.values).all():
        low, high = float(np.nanmin(grid.values)), float(np.nanmax(grid.values))
    head = (
        f"FSASCI 0 1 COMPUTED 0 {CPS3_NULL} 0\nFSATTR 0 0\n"
        f"FSLIMI {grid.west!r} {grid.east!r} {grid.south!r} {grid.north!r} {low!r} {high!r}\n"
        f"FSNROW {grid.values.shape[0]} {grid.values.shape[1]}\n"
        f"FSXINC {grid.dx!r} {grid.dy!r}\n-> {_one_line(name)}\n"
    )
    text = lines_text(grid.values[::-1].T, PER_LINE, CPS3_NULL.encode(), head.encode())
    return text, direction_lost(horizon, "CPS-3")


def esri_of_horizon(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return ESRI text: rows from the north, nodes as centres of cells."""
    grid = _upright(horizon, name, "the ESRI grid", at_least=1)
    null = null_for(grid.values, ESRI_NULLS)
    lost = [Loss("name", "The format does not store names.")]

    # steps that are equal but for rounding are one cell size, if no node moves by it
    n = max(grid.values.shape)
    if abs(grid.dx - grid.dy) * n <= SMALLEST:
        cells = f"cellsize {grid.dx!r}"
    else:
        cells = f"dx {grid.dx!r}\ndy {grid.dy!r}"
        words = f"Cells are {grid.dx:g} x {grid.dy:g} m, stored as dx and dy: GDAL reads them"
        lost.append(Loss("grid", f"{words}, programs that know square cells only do not."))
    head = (
        f"ncols {grid.values.shape[1]}\nnrows {grid.values.shape[0]}\n"
        f"xllcenter {grid.west!r}\nyllcenter {grid.south!r}\n{cells}\nNODATA_value {null}\n"
    )
    text = lines_text(grid.values[::-1], grid.values.shape[1], null.encode(), head.encode())
    return text, [*lost, *direction_lost(horizon, "the ESRI grid")]


def xyz_of_horizon(horizon: xr.DataArray, name: str) -> tuple[bytes | bytearray, list[Loss]]:
    """Return ``x y z`` of each node that has a value, row by row; any grid fits."""
    if "easting" not in horizon.coords or "northing" not in horizon.coords or horizon.ndim != 2:
        raise OutputError(
            f"horizon {name!r} has dims {horizon.dims} and coordinates {list(horizon.coords)}; "
            "points need two dims and the coordinates easting and northing. Add them."
        )

    refuse_odd_nodes(horizon, name)

    # one easting and northing for each node, in the order of the values
    like = horizon.values.shape
    easting, northing = (
        np.broadcast_to(horizon[key].transpose(*_order(horizon, key)).values, like)
        if horizon[key].ndim == 2
        else _spread(horizon, key)
        for key in ("easting", "northing")
    )
    values = np.asarray(horizon.values, dtype=np.float64)
    known = ~np.isnan(values)
    if not known.any():
        raise OutputError(f"horizon {name!r} has no values, and a file of points needs one.")
    columns = [np.asarray(part, dtype=np.float64)[known] for part in (easting, northing, values)]
    lost = [Loss("grid", "The file holds points: rows, columns and steps of the grid are lost.")]
    if not known.all():
        n = int((~known).sum())
        lost.append(Loss("undefined", f"{n} of {known.size} nodes have no value and are left out."))
    body = rows_text([columns[0], b" ", columns[1], b" ", columns[2], b"\n"])
    lost.append(Loss("name", "The format does not store names."))
    return body, [*lost, *direction_lost(horizon, "a file of points")]


def _upright(horizon: xr.DataArray, name: str, title: str, at_least: int) -> UprightGrid:
    """A grid without rotation; formats without steps need two nodes along each axis."""
    grid = upright_grid(horizon, name, title)
    n_row, n_column = grid.values.shape
    if min(n_row, n_column) < at_least:
        raise OutputError(
            f"horizon {name!r} has {n_row} rows and {n_column} columns, and {title} needs "
            f"{at_least} of each, since it stores no steps. Write .irapasc or .nc."
        )
    return grid


def _order(horizon: xr.DataArray, key: str) -> tuple[str, ...]:
    return tuple(str(dim) for dim in horizon.dims if dim in horizon[key].dims)


def _spread(horizon: xr.DataArray, key: str) -> np.ndarray:
    """A coordinate along one axis, for every node."""
    axis = horizon.dims.index(horizon[key].dims[0])
    line = np.asarray(horizon[key].values)
    return np.broadcast_to(line[:, None] if axis == 0 else line[None], horizon.shape)


def _crs_line(horizon: xr.DataArray, mark: str) -> str:
    """A comment with the reference system, if there is one."""
    crs = crs_of(horizon)
    return "" if crs is None else f"{mark} CRS: {_one_line(label(crs) if '[' in crs else crs)}\n"


def _one_line(text: str) -> str:
    return " ".join(text.split()) or "horizon"
