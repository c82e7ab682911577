"""IRAP grids, classic (text) and binary.

Both hold one origin, two increments and a rotation, so only regular grids fit. The
binary one is float32 throughout, header included: at a northing of 6 000 000 m that
is a step of 0.5 m. What was lost is measured and stated.

Suffixes follow xtgeo, which goes by them: ``.gri``, ``.irap`` and ``.irapbin`` are binary,
``.irapasc``, ``.irapascii`` and ``.fgr`` text.
"""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING

import numpy as np

from geosurf.errors import OutputError
from geosurf.write.decimals import lines_text
from geosurf.write.regular_grid import (
    Geometry,
    direction_lost,
    node_of,
    refuse_value,
    regular_grid,
)
from geosurf.write.written import Loss

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

UNDEFINED_CLASSIC = b"9999900.0"
UNDEFINED_BINARY = 1e30
UNDEFINED_FROM = 9.9e29  # readers take these for undefined: 1e30 is rounded
PER_LINE = 6  # RMS reads at most 9


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
    text = lines_text(values.reshape(1, -1), PER_LINE, UNDEFINED_CLASSIC, head.encode("ascii"))
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
