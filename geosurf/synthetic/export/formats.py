"""Bytes of the files as other programs export them: depth positive down, nothing that states it."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence

import numpy as np

FOOT = 0.3048  # [m]
END = "999.000000 999.000000 999.000000"
UNDEFINED_TEXT, UNDEFINED_BINARY = 9999900.0, 1e30
PER_LINE = 6

# xori, yori, xinc, yinc, rotation
Frame = tuple[float, float, float, float, float]


def irap_binary(depth: np.ndarray, frame: Frame) -> bytes:
    """An IRAP binary grid: big-endian float32 in Fortran records, rows from the origin."""
    # the header has the far corner as if the grid were not rotated, then the angle
    (rows, columns), (x, y, dx, dy, turn) = depth.shape, frame
    xmax, ymax = x + (columns - 1) * dx, y + (rows - 1) * dy
    single = np.where(np.isnan(depth), UNDEFINED_BINARY, depth).astype(">f4")
    records = [
        struct.pack(">ii6f", -996, rows, x, xmax, y, ymax, dx, dy),
        struct.pack(">i3f", columns, turn, x, y),
        struct.pack(">7i", *[0] * 7),
        *(row.tobytes() for row in single),
    ]

    # Fortran records: each has its length before and after it
    return b"".join(struct.pack(">i", len(r)) + r + struct.pack(">i", len(r)) for r in records)


def irap_classic(depth: np.ndarray, frame: Frame) -> bytes:
    """An IRAP classic grid: text, six values per line, four decimals."""
    (rows, columns), (x, y, dx, dy, turn) = depth.shape, frame
    xmax, ymax = x + (columns - 1) * dx, y + (rows - 1) * dy

    # undefined nodes have a number of the format, which readers have to know
    words = [f"{v:.4f}" for v in np.where(np.isnan(depth), UNDEFINED_TEXT, depth).ravel()]
    lines = [
        f"-996 {rows} {dx:.6f} {dy:.6f}",
        f"{x:.6f} {xmax:.6f} {y:.6f} {ymax:.6f}",
        f"{columns} {turn:.6f} {x:.6f} {y:.6f}",
        "0 0 0 0 0 0 0",
        *(" ".join(words[i : i + PER_LINE]) for i in range(0, len(words), PER_LINE)),
    ]
    return _text(lines)


def points_text(points: np.ndarray) -> bytes:
    """RMS points: x y z per line, and a line of 999 at the end."""
    return _text([*(f"{x:.3f} {y:.3f} {z:.3f}" for x, y, z in points), END])


def lines_text(lines: Iterable[np.ndarray]) -> bytes:
    """RMS polylines (sticks, outlines): each ends in a line of 999."""
    rows = []
    for line in lines:
        rows += [f"{x:.6f} {y:.6f} {z:.6f}" for x, y, z in line]
        rows.append(END)
    return _text(rows)


def tsurf(name: str, points: np.ndarray, triangles: np.ndarray) -> bytes:
    """A GOCAD TSurf with depths, as RMS writes it."""
    header = [
        "GOCAD TSurf 1",
        "HEADER {",
        f"name:{name}",
        "}",
        "GOCAD_ORIGINAL_COORDINATE_SYSTEM",
        "NAME Default",
        'AXIS_NAME "X" "Y" "Z"',
        'AXIS_UNIT "m" "m" "m"',
        "ZPOSITIVE Depth",
        "END_ORIGINAL_COORDINATE_SYSTEM",
        "TFACE",
    ]

    # GOCAD counts vertices from 1
    nodes = [f"VRTX {i} {x:.6f} {y:.6f} {z:.6f} CNXYZ" for i, (x, y, z) in enumerate(points, 1)]
    faces = [f"TRGL {a} {b} {c} " for a, b, c in (triangles + 1).tolist()]
    return _text([*header, *nodes, *faces, "END"])


def table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    """A csv table."""
    return _text([",".join(columns), *(",".join(map(str, row)) for row in rows)])


def _text(lines: Iterable[str]) -> bytes:
    return ("\n".join(lines) + "\n").encode("ascii")
