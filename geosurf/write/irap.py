"""IRAP grids, classic (text) and binary.

Both hold one origin, two increments and a rotation, so only regular grids fit. The
binary one is float32 throughout, header included: at a northing of 6 000 000 m that
is a step of 0.5 m. What was lost is measured and stated.
"""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING

import numpy as np

from geosurf.errors import OutputError

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

UNDEFINED_CLASSIC = "9999900.0"
UNDEFINED_BINARY = 1e30
PER_LINE = 6
# nodes may be off the regular grid by this much of an increment
SLACK = 1e-6

Geometry = tuple[float, float, float, float, float]


def irap_classic(horizon: xr.DataArray, name: str) -> tuple[bytes, list[str]]:
    """Return IRAP classic text; numbers are the shortest that give the same float64."""
    (x, y, xinc, yinc, rotation), values = regular_grid(horizon, name)
    nrow, ncol = values.shape
    xmax, ymax = x + (ncol - 1) * xinc, y + (nrow - 1) * yinc

    # a value equal to the mark would be read back as undefined
    if (values == float(UNDEFINED_CLASSIC)).any():
        raise OutputError(
            f"horizon {name!r} has a value of {UNDEFINED_CLASSIC}, which means 'undefined' in "
            "IRAP. Write .nc instead."
        )

    # The header has four lines: sizes and steps, limits, columns and rotation with its pivot,
    # zeros.
    words = [
        UNDEFINED_CLASSIC if math.isnan(value) else repr(value) for value in values.ravel().tolist()
    ]
    lines = [
        f"-996 {nrow} {xinc!r} {yinc!r}",
        f"{x!r} {xmax!r} {y!r} {ymax!r}",
        f"{ncol} {rotation!r} {x!r} {y!r}",
        "0 0 0 0 0 0 0",
    ]

    lines += [" ".join(words[i : i + PER_LINE]) for i in range(0, len(words), PER_LINE)]
    return ("\n".join(lines) + "\n").encode("ascii"), [_direction(horizon)]


def irap_binary(horizon: xr.DataArray, name: str) -> tuple[bytes, list[str]]:
    """Return IRAP binary, and how far float32 moved nodes and values."""
    (x, y, xinc, yinc, rotation), values = regular_grid(horizon, name)
    nrow, ncol = values.shape
    xmax, ymax = x + (ncol - 1) * xinc, y + (nrow - 1) * yinc

    # Records of Fortran, big-endian: header fields, then one record of float32 for each row.
    single = np.where(np.isnan(values), UNDEFINED_BINARY, values).astype(">f4")
    records = [
        struct.pack(">ii6f", -996, nrow, x, xmax, y, ymax, xinc, yinc),
        struct.pack(">i3f", ncol, rotation, x, y),
        struct.pack(">7i", *[0] * 7),
        *(row.tobytes() for row in single),
    ]
    data = b"".join(struct.pack(">i", len(r)) + r + struct.pack(">i", len(r)) for r in records)

    # What float32 moves: nodes are farthest off in a corner of the grid.
    exact = (x, y, xinc, yinc, rotation)
    rounded = tuple(float(np.float32(value)) for value in exact)
    moved = max(
        math.dist(_node(exact, row, column), _node(rounded, row, column))
        for row in (0, nrow - 1)
        for column in (0, ncol - 1)
    )

    # values: rounding of float32, away from undefined nodes
    lost = np.abs(single.astype(np.float64) - values)
    largest = float(np.nanmax(lost)) if np.isfinite(lost).any() else 0.0
    rounding = (
        f"IRAP binary stores float32: nodes moved by up to {moved:.3g} m and values by up to "
        f"{largest:.3g}. Write .irap or .nc for exact values."
    )
    return data, [rounding, _direction(horizon)]


def regular_grid(horizon: xr.DataArray, name: str) -> tuple[Geometry, np.ndarray]:
    """Return origin, increments and rotation of a regular grid, and its values.

    Raises
    ------
    OutputError
        If nodes are not on a regular, right-angled grid.
    """
    if horizon.ndim != 2 or "easting" not in horizon.coords or "northing" not in horizon.coords:
        raise OutputError(
            f"horizon {name!r} has dims {horizon.dims} and coordinates {list(horizon.coords)}; "
            "a grid file needs two dims and the coordinates easting and northing. Add them."
        )

    # rows from the south, columns from the west, whatever order the array has
    if horizon.easting.ndim == horizon.northing.ndim == 1:
        horizon = horizon.transpose("northing", "easting").sortby(["northing", "easting"])

    values = np.asarray(horizon.values, dtype=np.float64)
    if np.isinf(values).any():
        raise OutputError(
            f"horizon {name!r} has infinite values. Set missing nodes to NaN instead."
        )

    easting = np.asarray(horizon.easting.values, dtype=np.float64)
    northing = np.asarray(horizon.northing.values, dtype=np.float64)
    if easting.ndim == northing.ndim == 1:
        easting, northing = np.meshgrid(easting, northing)

    # The stated geometry is exact; one fitted to the nodes has rounding.
    stated = _stated(horizon)
    if stated is not None and _fits(stated, easting, northing, exact=True):
        return stated, values

    fitted = _fitted(easting, northing)
    if not _fits(fitted, easting, northing, exact=False):
        raise OutputError(
            f"horizon {name!r}: its nodes are not on a regular rectangular grid, and IRAP "
            "stores no other grids. Write .nc, or resample the horizon."
        )
    return fitted, values


def _node(grid: tuple[float, ...], row: int, column: int) -> tuple[float, float]:
    x, y, xinc, yinc, rotation = grid
    cos, sin = math.cos(math.radians(rotation)), math.sin(math.radians(rotation))

    # The step along columns, turned by the rotation, and the one along rows at a right angle [m].
    return (
        x + column * xinc * cos - row * yinc * sin,
        y + column * xinc * sin + row * yinc * cos,
    )


def _stated(horizon: xr.DataArray) -> Geometry | None:
    """Return the geometry in the attributes, if there is one."""
    try:
        x, y, xinc, yinc, rotation = (
            float(horizon.attrs[key]) for key in ("xori", "yori", "xinc", "yinc", "rotation")
        )
    except (KeyError, TypeError, ValueError):
        return None
    return x, y, xinc, yinc, rotation


def _fitted(easting: np.ndarray, northing: np.ndarray) -> Geometry:
    """Return the geometry that the corner nodes imply; single rows get a step of 1."""
    nrow, ncol = easting.shape
    x, y = float(easting[0, 0]), float(northing[0, 0])

    # Steps between corner nodes average the rounding of all columns and rows.
    along = (float(easting[0, -1]) - x, float(northing[0, -1]) - y)
    across = (float(easting[-1, 0]) - x, float(northing[-1, 0]) - y)

    # a single column of nodes: the direction follows from the rows, at a right angle
    if ncol > 1:
        rotation = math.degrees(math.atan2(along[1], along[0]))
    else:
        rotation = math.degrees(math.atan2(-across[0], across[1])) if nrow > 1 else 0.0
    xinc = math.hypot(*along) / (ncol - 1) if ncol > 1 else 1.0
    yinc = math.hypot(*across) / (nrow - 1) if nrow > 1 else 1.0

    # A negative step along rows where rows run clockwise from columns.
    left_handed = along[0] * across[1] - along[1] * across[0] < 0
    return x, y, xinc, -yinc if left_handed else yinc, rotation


def _fits(grid: Geometry, easting: np.ndarray, northing: np.ndarray, *, exact: bool) -> bool:
    """Whether all nodes lie where the geometry puts them."""
    x, y, xinc, yinc, rotation = grid
    turn = math.radians(rotation)

    # places that the geometry gives all nodes, to compare with their own
    column = np.arange(easting.shape[1])
    row = np.arange(easting.shape[0])[:, None]
    east = x + (column * xinc * math.cos(turn) - row * yinc * math.sin(turn))
    north = y + (column * xinc * math.sin(turn) + row * yinc * math.cos(turn))

    slack = 1e-9 if exact else SLACK
    # float64 itself moves nodes by a few units in the last place
    scale = max(abs(x), abs(y), 1.0) * 8 * np.finfo(np.float64).eps
    limit = slack * min(abs(xinc), abs(yinc)) + scale
    return bool(
        (np.abs(east - easting) <= limit).all() and (np.abs(north - northing) <= limit).all()
    )


def _direction(horizon: xr.DataArray) -> str:
    """State what an IRAP file cannot: direction and unit of its values."""
    positive = horizon.attrs.get("positive", "up")
    word = "depth" if positive == "down" else "elevation"
    return (
        f"Values are {word} in {horizon.attrs.get('units', 'm')}, which IRAP does not store: "
        f"read the file with positive={positive!r}."
    )
