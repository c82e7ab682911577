"""GRDECL: corner-point grids as text, the include files of ECLIPSE, OPM Flow and others."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from geosurf.lazy import xarray as xr
from geosurf.model.grids import AXES, CornerPointGrid
from geosurf.stopping import temporary_folder
from geosurf.write.written import Loss

# ---- egrid ----------------------------------------
# EGRID and ROFF: binary corner-point grids, written by xtgeo (extra ``xtgeo``).


FORMATS = {".egrid": "egrid", ".roff": "roff_binary"}


def binary_of_grid(
    grid: CornerPointGrid, name: str | None, suffix: str
) -> tuple[bytes, list[Loss]]:
    """Return a grid as xtgeo writes it."""
    theirs = grid.to_xtgeo()
    with temporary_folder() as folder:
        path = Path(folder) / f"grid{suffix}"
        theirs.to_file(path, fformat=FORMATS[suffix])
        data = path.read_bytes()
    off = max(
        float(np.abs(values - values.astype(np.float32)).max())
        for values in (grid.coord, grid.levels)
    )
    words = (
        f"Coordinates and depths were rounded to float32, by up to {off:.2g} m; elevations are "
        "written as depths. The .grdecl has coordinates to 0.001 m."
    )
    return data, [
        Loss("precision", words, off),
        Loss(
            "data", "Faults, zones, blocks and regions were left out: write .grdecl and .inc, too."
        ),
    ]


PER_LINE = 8
AT_ONCE = 80_000  # numbers in one piece of text
MOST_NAME = 8  # characters of a fault name that simulators read


def grdecl_of_grid(grid: CornerPointGrid, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return the GRID section: SPECGRID, COORD, ZCORN, ACTNUM and FAULTS; depths grow downwards."""
    nz, ny, nx = grid.shape
    coord = grid.coord.copy()
    coord[..., [2, 5]] *= -1.0
    words = [
        _head(grid, name),
        "MAPUNITS\n 'METRES' /\n\nMAPAXES\n 0 1 0 0 1 0 /\n\nGRIDUNIT\n 'METRES' /\n\n",
        f"SPECGRID\n {nx} {ny} {nz} 1 F /\n\n",
        *_keyword("COORD", _decimals(coord.ravel())),
        *_keyword("ZCORN", _decimals(-grid.zcorn.ravel())),
        *_keyword("ACTNUM", _repeats(grid.actnum.ravel().astype(np.int64))),
        *_faults(grid),
    ]
    words_lost = "Coordinates were rounded to 0.001 m; elevations are written as depths."
    lost = [Loss("precision", words_lost, 0.0005)]
    if grid.crs is not None:
        words.insert(1, f"-- CRS: {' '.join(grid.crs.split())[:110]}\n\n")
    long = [one for one in grid.fault_names if len(one) > MOST_NAME]
    if long:
        words_lost = f"Fault names have more than {MOST_NAME} characters: {', '.join(long)}."
        lost.append(Loss("name", words_lost))
    return "".join(words).encode(), lost


def inc_of_grid(grid: CornerPointGrid, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return the arrays ZONE, BLOCK, REGION and FIPNUM, which count from 1; 0 in cells without."""
    words = [_head(grid, name)]
    for key, names, values in grid.properties:
        words += [f"-- {key} {k + 1}: {one}\n" for k, one in enumerate(names)]
        words += _keyword(key, _repeats(values.ravel() + 1))
    return "".join(words).encode(), []


def inc_of_multipliers(multipliers: xr.Dataset, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return MULTX, MULTY and MULTZ of the faces, or MULTFLT of the faults."""
    known = np.isfinite(multipliers.fault_multiplier.values)
    words = ["-- Transmissibility multipliers of fault rock\n\n"]
    rows = zip(multipliers.fault_name.values, multipliers.fault_multiplier.values, strict=True)
    if multipliers.attrs["by"] == "fault":
        lines = [f" '{fault}' {value:.6g} /\n" for fault, value in rows if np.isfinite(value)]
        words += ["MULTFLT\n", *lines, "/\n"] if known.any() else []
        return "".join(words).encode(), []
    shape = tuple(multipliers.attrs[key] for key in ("nz", "ny", "nx"))
    values = multipliers.multiplier.values
    at = tuple(multipliers[key].values - 1 for key in ("k", "j", "i"))
    for key, axis in zip(("MULTX", "MULTY", "MULTZ"), AXES, strict=True):
        across = np.isfinite(values) & (multipliers.axis.values == axis)
        if across.any():
            whole = np.ones(shape)
            np.multiply.at(whole, tuple(of[across] for of in at), values[across])
            words += _keyword(key, _repeats(whole.ravel()))
    return "".join(words).encode(), []


def _head(grid: CornerPointGrid, name: str | None) -> str:
    """What the file is, as comments."""
    title = f" {name}" if name else ""
    return (
        f"-- Corner-point grid{title}: {' x '.join(map(str, grid.shape[::-1]))} cells, in metres\n"
        f"-- zones: {', '.join(grid.zone_names)}\n\n"
    )


def _keyword(key: str, lines: Iterator[str]) -> Iterator[str]:
    yield f"{key}\n"
    yield from lines
    yield "/\n\n"


def _decimals(values: np.ndarray) -> Iterator[str]:
    """Numbers with three decimals, some on a line."""
    line = " %.3f" * PER_LINE + "\n"
    for part in (values[k : k + AT_ONCE] for k in range(0, len(values), AT_ONCE)):
        whole = len(part) // PER_LINE
        yield (line * whole) % tuple(part[: whole * PER_LINE].tolist())
        rest = part[whole * PER_LINE :].tolist()
        if rest:
            yield (" %.3f" * len(rest) + "\n") % tuple(rest)


def _repeats(values: np.ndarray) -> Iterator[str]:
    """Numbers; ``5*1`` stands for five ones."""
    first = np.flatnonzero(np.diff(values, prepend=values[:1] - 1))
    count = np.diff(np.append(first, len(values))).tolist()
    words = [
        f"{n}*{value:.6g}" if n > 1 else f"{value:.6g}"
        for n, value in zip(count, values[first].tolist(), strict=True)
    ]
    for k in range(0, len(words), PER_LINE):
        yield " " + " ".join(words[k : k + PER_LINE]) + "\n"


def _faults(grid: CornerPointGrid) -> Iterator[str]:
    """FAULTS: name, I, J and K from and to, and the face."""
    faces = grid.faces
    if not len(faces):
        return
    yield "FAULTS\n"
    columns = (faces.fault, faces.axis, faces.column + 1, faces.layers)
    for fault, axis, (i, j), (k, end) in zip(*(c.tolist() for c in columns), strict=True):
        yield f" '{grid.fault_names[fault]}' {i} {i} {j} {j} {k + 1} {end} '{AXES[axis]}' /\n"
    yield "/\n"
