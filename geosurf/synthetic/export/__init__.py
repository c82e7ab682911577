"""A whole field as other programs export it, with its truth.

==============  ===================================================================
geology.py      faults and horizons by formulas, in the frame of the grids, and `FieldTruth`:
                elevations, cut-offs, throw, volumes
==============  ===================================================================
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from geosurf.conventions import check_word
from geosurf.errors import InputError
from geosurf.files import refused_writing, write_whole
from geosurf.model.expected import path_of
from geosurf.synthetic.export.geology import (
    ORIGIN,
    OUTLINE,
    ROTATION,
    SHAPE,
    STEP,
    FieldTruth,
    Geology,
    Horizon,
    branch_ends,
    cutoff_line,
    distance_from,
    geology_of,
    reach,
    to_world,
)
from geosurf.synthetic.torn_horizon import DATUM, Fault, exists, side_of, single_valued
from geosurf.synthetic.world import check_count

# ---- formats ----------------------------------------
# What is picked of the field, and its bytes as other programs export them.
#
# Depth is positive down, and nothing states it.


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


STICKS = 120.0  # between sticks [m]
PAST = 60.0  # how far faults reach above and below the horizons [m]
OVER = 35.0  # how far points of a wall continue beyond its fault [m]


def nodes() -> tuple[np.ndarray, np.ndarray]:
    """Nodes of the grids (rows, columns) in the local frame."""
    rows, columns = SHAPE
    x, y = np.meshgrid(STEP * np.arange(columns), STEP * np.arange(rows))
    return x, y


def defined(geology: Geology, horizon: Horizon) -> np.ndarray:
    """Nodes with data: all of the outline, and the younger the horizon, the farther beyond."""
    # outlines shrink downwards by a cell each, as those of real surveys differ
    rank = len(geology.horizons) - geology.horizons.index(horizon)
    return distance_from(OUTLINE, *nodes()) <= (rank + 0.5) * STEP


def grid_of(geology: Geology, horizon: Horizon, smear: int) -> np.ndarray:
    """Elevations (rows, columns), smeared where the horizon is faulted; NaN where undefined."""
    x, y = nodes()
    sheets = geology.sheets(horizon, x, y)
    there = {signs: exists(geology.faults, signs, x, y, z) for signs, z in sheets.items()}
    values = single_valued(geology.faults, x, y, sheets, there)
    return np.where(defined(geology, horizon), _smeared(geology, values, smear), np.nan)


def _smeared(geology: Geology, values: np.ndarray, width: int) -> np.ndarray:
    """The mean over a square where a fault lies in it, the value itself elsewhere."""
    x, y = nodes()
    mixed = np.zeros(values.shape, dtype=bool)

    # nodes with the fault inside their window; a branch smears on its own side of the main fault
    # only
    for fault in geology.faults.values():
        s, r = fault.along_across(x, y)
        side = r > fault.across(s, values)
        faulted = np.abs(s) < fault.half
        if fault.branch is not None:
            main, sign = geology.faults[fault.branch[0]], fault.branch[1]
            faulted &= side_of(main, x, y, values) == sign
        squares = _squares(side, width)
        mixed |= faulted & (squares.any(axis=(2, 3)) & ~squares.all(axis=(2, 3)))
    return np.where(mixed, _squares(values, width).mean(axis=(2, 3)), values)


def _squares(values: np.ndarray, width: int) -> np.ndarray:
    """Values of the square around each node (rows, columns, 2 width + 1, 2 width + 1)."""
    padded = np.pad(values, width, mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, (2 * width + 1, 2 * width + 1))


def points_of(geology: Geology, horizon: Horizon) -> np.ndarray:
    """Points (n, 3) on the nodes, in no order; at faults one for each wall, a bit too far."""
    x, y = nodes()
    mask = defined(geology, horizon)
    clouds = []
    for signs, z in geology.sheets(horizon, x, y).items():
        there = mask & _near(geology.faults, signs, x, y, z)
        clouds.append(np.stack([*to_world(x[there], y[there]), z[there]], axis=1))

    # to the millimetre, as files have them; then in no order, as picks come
    points = np.unique(np.concatenate(clouds).round(3), axis=0)  # beyond tips, walls are one

    # Knuth's multiplicative hash: the same shuffle on every machine
    order = np.argsort(np.arange(len(points), dtype=np.uint64) * np.uint64(2654435761) % 2**32)
    return points[order]


def _near(
    faults: Mapping[str, Fault], signs: tuple[int, ...], x: np.ndarray, y: np.ndarray, z: np.ndarray
) -> np.ndarray:
    """Where a sheet has points: on its side of all faults, or not much beyond."""
    there = np.ones(x.shape, dtype=bool)
    for fault, sign in zip(faults.values(), signs, strict=True):
        if sign:
            s, r = fault.along_across(x, y)
            over = np.where(np.abs(s) < fault.half, OVER, 0.0)
            there &= sign * (r - fault.across(s, z)) > -over
    return there


def sticks_of(truth: FieldTruth, name: str) -> list[np.ndarray]:
    """Sticks (n, 3) of a fault, shorter by what `missing` has."""
    fault = truth.geology.faults[name]
    missing = truth.missing.get(name, {})
    first, last = _reach(fault)
    if fault.branch is not None:
        last = float(branch_ends(fault, truth.geology.faults, np.array(DATUM)))
    s = np.linspace(first, last, int((last - first) / STICKS) + 1)
    top, base = _levels(truth, name, s)

    # too short by what `missing` states, or past the horizons by PAST
    top = top - missing["up"] if "up" in missing else top + PAST
    base = base + missing["down"] if "down" in missing else base - PAST

    # a plane needs two points, a curved fault four
    per_stick = 4 if fault.flatten else 2
    z = top + (base - top) * np.linspace(0.0, 1.0, per_stick)[:, None]
    along = np.broadcast_to(s, z.shape)
    if fault.branch is not None:  # the last stick is parallel to the main fault
        end = branch_ends(fault, truth.geology.faults, z) - missing.get("end", 0.0)
        along = first + (end - first) * (s - first) / (last - first)
    x, y = fault.place(along, fault.across(along, z))
    return list(np.stack([*to_world(x, y), z], axis=-1).transpose(1, 0, 2))


def mesh_of(truth: FieldTruth, name: str, notch: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles of a fault with a notch in its upper rim.

    The notch ends `notch` metres above the highest cut-off line there; below it, if negative.
    """
    fault = truth.geology.faults[name]
    first, last = _reach(fault)
    s = np.linspace(first, last, int((last - first) / 60.0) + 1)
    top, base = _levels(truth, name, s)
    rows = [
        top + PAST,
        top + notch,
        top - 0.3 * (top - base),
        top - 0.6 * (top - base),
        base - PAST,
    ]
    z = np.stack(rows)
    x, y = fault.place(s, fault.across(s, z))
    points = np.stack([*to_world(x, y), z], axis=-1).reshape(-1, 3)

    # two cells of the upper row are left out: the notch
    number = np.arange(z.size).reshape(z.shape)
    middle = len(s) // 3
    cells = [
        (i, j)
        for i in range(z.shape[0] - 1)
        for j in range(z.shape[1] - 1)
        if not (i == 0 and middle <= j < middle + 2)
    ]
    corners = [
        (number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]) for i, j in cells
    ]
    triangles = [t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))]

    # without the vertices that only the notch had
    used, local = np.unique(np.array(triangles), return_inverse=True)
    return points[used], local.reshape(-1, 3)


def _reach(fault: Fault) -> tuple[float, float]:
    """First and last place of a fault along strike: its tips, or beyond all data."""
    if np.isfinite(fault.half):
        return -fault.half, fault.half
    return reach(fault, 100.0)


def _levels(truth: FieldTruth, name: str, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Elevation of the highest and lowest cut-off at places along a fault."""
    high, low = np.full(len(s), -np.inf), np.full(len(s), np.inf)

    # highest and lowest cut-off of all horizons on both walls at each place
    for horizon in truth.geology.horizons:
        for wall in "+-":
            along, _, _, z = cutoff_line(truth.geology, horizon, name, wall)
            z = np.interp(s, along, z)
            high, low = np.maximum(high, z), np.minimum(low, z)
    return high, low


__all__ = ["FieldTruth", "field_export"]

# variant -> suffix of each horizon's file
_HORIZON_FILES = {
    "grids": {"Top": ".gri", "Middle": ".gri", "Base": ".irapasc"},
    "points": {"Top": ".poi", "Middle": ".poi", "Base": ".poi"},
    "network": {"Top": ".gri", "Middle": ".poi", "Base": ".irapasc"},
}
_MESH = "F3"
_NOTCH = {"grids": 15.0, "points": 15.0, "network": 15.0}  # above the cut-off lines [m]
_MISSING = {"F1": {"down": 30.0}, "F2": {"up": 12.0, "end": 90.0}}
_MOST_SMEAR = 5


def field_export(
    folder: str | PathLike[str], variant: str = "grids", *, smear: int = 1
) -> FieldTruth:
    """
    Write a whole synthetic field as Petrel and RMS export it, and return its truth.

    Three horizons and three or six faults in a coordinate frame rotated by 30 degrees. The files
    have what such exports usually have: depth positive down without a word about it, undefined
    rims, a horizon in feet, sticks that stop too early, a fault mesh with a notch, points that
    end in ``999 999 999``. A note ``README.txt`` names the oddities, ``field.toml`` is a scenario
    that builds the field, and the folder ``truth`` has tables of volumes, throw and cut-off lines.

    Parameters
    ----------
    folder : path-like
        Is created if it is missing. Files of the same names are replaced.
    variant : {"grids", "points", "network"}
        ``"grids"``: IRAP grids, smeared across the faults: a listric main fault F1, its branch F2,
        and F3, which dies at both ends. ``"points"``: the same field as points, with two values
        at the faults. ``"network"``: F4, which crosses F1, and the relay of F5 and F6 in
        addition; two grids and a file of points.
    smear : int
        A node of a grid is the mean of all nodes up to this many away on either axis, 0 to 5.

    Returns
    -------
    FieldTruth
        Elevations, cut-offs, throw and volumes as they are; paths of the files.

    Raises
    ------
    InputError
        If the variant is unknown, or `smear` out of range.
    OutputError
        If the folder cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> truth = field_export(tempfile.mkdtemp())
    >>> truth.horizons, truth.faults
    (('Top', 'Middle', 'Base'), ('F1', 'F2', 'F3'))
    >>> truth.files["Top"].name, truth.missing["F2"]["end"]
    ('Top.gri', 90.0)
    """
    path = path_of(folder, "field_export")
    known = ", ".join(_HORIZON_FILES)
    check_word(
        variant, _HORIZON_FILES, f"field_export: variant is {variant!r}; give one of {known}."
    )
    check_count(smear, "smear", 0)
    if smear > _MOST_SMEAR:
        raise InputError(f"smear is {smear}; give a whole number of nodes, 0 to {_MOST_SMEAR}.")

    # formulas only: nothing is computed until a file needs it
    truth = _truth_of(path, variant)
    with refused_writing(f"{path}: the field", path, "Choose another folder."):
        (path / "truth").mkdir(parents=True, exist_ok=True)
        for name, data in _contents(truth, smear):
            write_whole(path / name, data)
    return truth


def _truth_of(folder: Path, variant: str) -> FieldTruth:
    """What is true of a variant, and where its files are."""
    geology = geology_of(variant)
    suffixes = _HORIZON_FILES[variant] | {
        name: ".ts" if name == _MESH else ".pol" for name in geology.faults
    }
    files = {name: folder / f"{name}{suffix}" for name, suffix in suffixes.items()}
    files |= {"outline": folder / "outline.pol", "scenario": folder / "field.toml"}
    return FieldTruth(variant, files, geology, _MISSING)


def _contents(truth: FieldTruth, smear: int) -> Iterator[tuple[str, bytes]]:
    """Name and bytes of every file."""
    # depth, positive down, and one horizon in feet: as such files come, without a word in them
    for horizon in truth.geology.horizons:
        path, unit = truth.files[horizon.name], FOOT if horizon.name == FEET else 1.0
        if path.suffix == ".poi":
            points = points_of(truth.geology, horizon) * [1.0, 1.0, -1.0 / unit]
            yield path.name, points_text(points)
            continue
        encode = irap_binary if path.suffix == ".gri" else irap_classic
        depth = -grid_of(truth.geology, horizon, smear) / unit
        yield path.name, encode(depth, (*ORIGIN, STEP, STEP, ROTATION))
    for name in truth.faults:
        down = [1.0, 1.0, -1.0]
        if name == _MESH:
            points, triangles = mesh_of(truth, name, _NOTCH[truth.variant])
            yield f"{name}.ts", tsurf(name, points * down, triangles)
        else:
            sticks = [stick * down for stick in sticks_of(truth, name)]
            yield f"{name}.pol", lines_text(sticks)

    # polygons in files repeat their first corner
    corners = np.concatenate([truth.outline, truth.outline[:1]])
    loop = np.column_stack([corners, np.zeros(len(corners))])
    yield "outline.pol", lines_text([loop])
    yield "field.toml", scenario_of(truth)
    yield "README.txt", note_of(truth)
    yield from _truth_tables(truth)


def _truth_tables(truth: FieldTruth) -> Iterator[tuple[str, bytes]]:
    """Volumes, throw and cut-off lines, for those who work without Python."""
    volumes = [(*unit, round(volume)) for unit, volume in truth.volumes().items()]
    yield "truth/volumes.csv", table(("zone", "block", "volume_m3"), volumes)
    throws, cutoffs = [], []
    for horizon in truth.horizons:
        for fault in truth.faults:
            for wall in "-+":
                line = truth.cutoff(horizon, fault, wall)
                cutoffs += [(horizon, fault, wall, *(f"{v:.3f}" for v in p)) for p in line]
            foot = truth.cutoff(horizon, fault, "-")[::10]
            throw = truth.throw(horizon, fault, foot[:, 0], foot[:, 1])
            throws += [
                (horizon, fault, f"{x:.3f}", f"{y:.3f}", f"{t:.3f}")
                for (x, y, _), t in zip(foot, throw, strict=True)
                if np.isfinite(t)
            ]
    places = ("easting_m", "northing_m")
    yield "truth/throw.csv", table(("horizon", "fault", *places, "throw_m"), throws)
    columns = ("horizon", "fault", "wall", *places, "elevation_m")
    yield "truth/cutoffs.csv", table(columns, cutoffs)
