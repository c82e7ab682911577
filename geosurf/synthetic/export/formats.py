"""Bytes of the files as other programs export them: depth positive down, nothing that states it."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from geosurf.synthetic.export.truth import FieldTruth

# ---- scenario ----------------------------------------
# The scenario and the note that `field_export` writes next to the files of a field.


FEET = "Base"  # the horizon whose file is in feet


def scenario_of(truth: FieldTruth) -> bytes:
    """The scenario (TOML) that builds a field from its files."""
    lines = ["# Run it with: geosurf run field.toml -o out", "", 'title = "Exported field"']

    # what a user has to find out about the files is written next to each key
    for name in truth.horizons:
        lines += _input("horizons", name, truth.files[name])
        if name == FEET:
            lines.append('length_unit = "ft" # z only; x and y are metres')
    for name in truth.faults:
        lines += _input("faults", name, truth.files[name])
        if name in truth.missing:
            lines.append('extend = ["up", "down"] # its sticks are too short')

    # a branch ends at its main fault, on the side where it is
    for name, fault in truth.geology.faults.items():
        if fault.branch is not None:
            main, sign = fault.branch
            part = "hanging wall" if sign > 0 else "footwall"
            lines += ["", "[[truncations]]", f'fault = "{name}"', f'main = "{main}"']
            lines += [f'keep = "{part}"', "extend = true # it stops short of its main fault"]
    lines += ["", "[tear] # gridding smeared the horizons across the faults"]
    return _lines_of(lines)


def note_of(truth: FieldTruth) -> bytes:
    """A note for people: what the formats do not store, and what is odd."""
    lines = [
        f"Synthetic field, variant '{truth.variant}': files as other programs export them.",
        "x and y are metres. z is depth, positive down, in metres unless stated.",
        "",
    ]
    for name in (*truth.horizons, *truth.faults):
        path, missing = truth.files[name], truth.missing.get(name, {})
        unit = " z in feet." if name == FEET else ""
        short = "".join(
            f" Stops {metres:g} m short of {'the horizons' if side in ('up', 'down') else 'F1'}"
            f" ({side})."
            for side, metres in missing.items()
        )
        notch = " Its upper rim has a notch." if path.suffix == ".ts" else ""
        lines.append(f"{path.name}:{unit}{short}{notch}" if unit + short + notch else path.name)
    lines += ["", "field.toml: a scenario of these files; scenario.toml: the one of `geosurf new`."]
    lines += ["", "truth/: volumes, cut-off lines and throw as they are, not as they were picked."]
    lines.append("They are elevations, positive up, in metres; volumes are inside outline.pol.")
    return _lines_of(lines)


def _input(table: str, name: str, path: Path) -> list[str]:
    lines = ["", f"[[{table}]]", f'name = "{name}"', f'file = "{path.name}"']
    return lines if path.suffix == ".ts" else [*lines, 'positive = "down"']


def _lines_of(lines: list[str]) -> bytes:
    return ("\n".join(lines) + "\n").encode("ascii")


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
