"""A whole field as other programs export it, with its truth.

==============  ===================================================================
geology.py      faults and horizons by formulas, in the frame of the grids, and `FieldTruth`:
                elevations, cut-offs, throw, volumes
formats.py      bytes of the files
==============  ===================================================================
"""

from __future__ import annotations

from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from geosurf.conventions import did_you_mean, is_word
from geosurf.errors import InputError, OutputError
from geosurf.files import write_whole
from geosurf.model.expected import path_of
from geosurf.synthetic.export import formats
from geosurf.synthetic.export.formats import (
    FEET,
    grid_of,
    mesh_of,
    note_of,
    points_of,
    scenario_of,
    sticks_of,
)
from geosurf.synthetic.export.geology import ORIGIN, ROTATION, STEP, FieldTruth, geology_of
from geosurf.synthetic.world import check_count

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
    if not is_word(variant, _HORIZON_FILES):
        raise InputError(
            f"field_export: variant is {variant!r}; give one of {', '.join(_HORIZON_FILES)}."
            f"{did_you_mean(str(variant), _HORIZON_FILES)}"
        )
    check_count(smear, "smear", 0)
    if smear > _MOST_SMEAR:
        raise InputError(f"smear is {smear}; give a whole number of nodes, 0 to {_MOST_SMEAR}.")

    # formulas only: nothing is computed until a file needs it
    truth = _truth_of(path, variant)
    try:
        (path / "truth").mkdir(parents=True, exist_ok=True)
        for name, data in _contents(truth, smear):
            write_whole(path / name, data)
    except OSError as error:
        raise OutputError(f"{path}: the field cannot be written: {error.strerror}.") from error
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
        path, unit = truth.files[horizon.name], formats.FOOT if horizon.name == FEET else 1.0
        if path.suffix == ".poi":
            points = points_of(truth.geology, horizon) * [1.0, 1.0, -1.0 / unit]
            yield path.name, formats.points_text(points)
            continue
        encode = formats.irap_binary if path.suffix == ".gri" else formats.irap_classic
        depth = -grid_of(truth.geology, horizon, smear) / unit
        yield path.name, encode(depth, (*ORIGIN, STEP, STEP, ROTATION))
    for name in truth.faults:
        down = [1.0, 1.0, -1.0]
        if name == _MESH:
            points, triangles = mesh_of(truth, name, _NOTCH[truth.variant])
            yield f"{name}.ts", formats.tsurf(name, points * down, triangles)
        else:
            sticks = [stick * down for stick in sticks_of(truth, name)]
            yield f"{name}.pol", formats.lines_text(sticks)

    # polygons in files repeat their first corner
    corners = np.concatenate([truth.outline, truth.outline[:1]])
    loop = np.column_stack([corners, np.zeros(len(corners))])
    yield "outline.pol", formats.lines_text([loop])
    yield "field.toml", scenario_of(truth)
    yield "README.txt", note_of(truth)
    yield from _truth_tables(truth)


def _truth_tables(truth: FieldTruth) -> Iterator[tuple[str, bytes]]:
    """Volumes, throw and cut-off lines, for those who work without Python."""
    volumes = [(*unit, round(volume)) for unit, volume in truth.volumes().items()]
    yield "truth/volumes.csv", formats.table(("zone", "block", "volume_m3"), volumes)
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
    yield "truth/throw.csv", formats.table(("horizon", "fault", *places, "throw_m"), throws)
    columns = ("horizon", "fault", "wall", *places, "elevation_m")
    yield "truth/cutoffs.csv", formats.table(columns, cutoffs)
