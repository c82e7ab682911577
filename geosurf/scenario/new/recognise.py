"""One file -> what it holds: a horizon, a fault, something else, or nothing that a scenario takes.

`geosurf.read.file_info` says which reader takes it, as for `geosurf info` and a run.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted
from geosurf.errors import GeosurfError
from geosurf.faults import split_fault
from geosurf.read import (
    FAULT_FORMATS,
    GRID_FORMATS,
    MESH_FORMATS,
    otherwise,
    read_fault,
    read_horizon,
    read_points,
    read_polygons,
    read_tops,
    read_tsurf,
)
from geosurf.read._common import collected, read_text
from geosurf.read.file_info import kind_of_file, points_of, strange
from geosurf.read.netcdf import holds_fault
from geosurf.read.polylines import NAMED_LINES, fault_names, several_objects
from geosurf.read.registry import TITLES, detect
from geosurf.read.resqml.representations import LINES, MESH, POINTS
from geosurf.read.resqml.surfaces import surfaces_of
from geosurf.scenario.new.judge import OUT, Found, mean_dip, name_from, plane_dip, thinned

# ---- reading ----------------------------------------
# Files are read with words that apply only where a file is silent; readers note what it states.


NO_PLACE = "a model takes no such files"
MOST_POINTS = 250_000  # that are kept of a horizon
UP: dict[str, Any] = otherwise({"positive": "up", "length_unit": "m"})
DOWN: dict[str, Any] = otherwise({"positive": "down", "length_unit": "m"})


def surface_of_file(path: Path, read: Any, form: str, kind: str, note: str) -> Found:
    """Read a file with direction and unit as defaults; find out whether it states them."""
    with collected() as notes:
        data = read(path, **UP)
    points = points_of(data)
    points = points[np.isfinite(points).all(axis=1)]
    file = Found(path, kind, form, note or str(len(points)), data=data)
    file.points = thinned(points, MOST_POINTS)
    file.states_direction = "stated by the file" in notes.get("sign", "")
    file.states_unit = "stated by the file" in notes.get("unit of z", "")
    return file


# ---- surfaces ----------------------------------------
# Files of grids, meshes and packages of surfaces: horizons, faults and fluid contacts.


STEEP = 30.0  # dip [degrees] from which a surface is taken for a fault
MOST_PIECES = 12  # of a mesh that are faults of their own; more are a mesh that is torn apart
FAULT_NAME = re.compile(r"fault|(?:^|[^a-z])f\d+(?:$|[^a-z0-9])", re.IGNORECASE)
HORIZON_NAME = re.compile(r"horizon|top|base|surface", re.IGNORECASE)
CONTACT_NAME = re.compile(r"(?:^|[^a-z])(owc|goc|gwc|fwl|fwc)(?:$|[^a-z])", re.IGNORECASE)


def grid(path: Path) -> Found:
    """A horizon, or a level fluid contact."""
    file = surface_of_file(path, read_horizon, "grid", "horizon", "")
    z = file.points[:, 2]
    if not len(z):
        return Found(path, OUT, "grid", "all nodes are undefined")
    file.note = f"{len(z)} nodes" if len(z) < MOST_POINTS else f"{file.note} nodes"
    named = CONTACT_NAME.search(path.stem)
    # Fluid contacts are level, or named as such.
    if named or np.ptp(z) == 0:
        why = f"is named {named[1]!r}" if named else f"is level, z = {z[0]:g}"
        file.kind, file.note = "contact", f"the grid {why}"
    return file


def tsurfs(path: Path) -> list[Found]:
    """Every surface of a GOCAD file."""
    surfaces = read_tsurf(path, **UP)
    names = [surface.name for surface in surfaces]
    # Surfaces are read by name later, so names have to differ.
    if len(set(names)) < len(names):
        reason = f"{len(names)} surfaces share the name {names[0]!r}; rename them in the file"
        return [Found(path, OUT, "mesh", reason)]
    many = len(surfaces) > 1

    # A function of its own binds k for each surface.
    def reader(k: int) -> Any:
        return lambda words: read_tsurf(path, **words)[k]

    files = []
    for k, name in enumerate(names):
        files += pieces(mesh(path, name, reader(k), name if many else ""), name if many else "")
    return files


def pieces(whole: Found, in_file: str = "") -> list[Found]:
    """A fault of a few pieces as one fault for each: only so it can be extended."""
    whole.in_file = in_file
    parts = split_fault(whole.data) if whole.kind == "fault" else {}
    if not 1 < len(parts) <= MOST_PIECES:
        return [whole]
    name = whole.name or name_from(whole.path)
    return [
        replace(
            whole, name=f"{name} ({k})", piece=k, data=part, points=np.asarray(part.vertices),
            note=f"piece {k} of {len(parts)}, {part.n_triangle} triangles",
        )
        for k, part in enumerate(parts.values(), start=1)
    ]  # fmt: skip


def resqml(path: Path) -> list[Found]:
    """Every object of a package; the package states what it is, else its shape shows it."""
    parts = []
    for surface in surfaces_of(path):
        name, role = surface.title, surface.role
        if surface.kind == MESH and not role:
            part = mesh(path, name, partial(_named, read_horizon, path, name), name)
        elif surface.kind == POINTS:
            note = (
                f"{name!r} is a set of points. A file that [tear] takes: geosurf convert "
                f"{shlex.quote(path.name)} points.poi --name {shlex.quote(name)}"
            )
            part = Found(path, OUT, "points", note, name)
        elif surface.kind in LINES and role != "fault":
            note = (
                f"{name!r} has lines, and the package does not state a fault. If they are sticks, "
                f"add [[faults]] with this file and name = {name!r}"
            )
            part = Found(path, OUT, "lines", note, name)
        elif surface.kind in LINES:
            part = sticks_of(path, name)
        else:
            read = read_fault if role == "fault" else read_horizon
            kind = role or "horizon"
            part = surface_of_file(
                path, partial(read, name=name), "RESQML", kind, f"{kind} of RESQML"
            )
            part.name = name
        part.states_direction = part.states_unit = True
        part.in_file = name
        parts += pieces(part, name) if surface.kind == MESH else [part]
    return parts


def _named(read: Any, path: Path, name: str, words: dict[str, Any]) -> Any:
    return read(path, name=name, **words)


def mesh(path: Path, known_as: str, read: Any, name: str = "") -> Found:
    """A horizon if it is gently dipping, a fault if it is steep."""
    surface = read(UP)
    dip = mean_dip(surface.vertices, surface.triangles)
    kind = "fault" if dip >= STEEP else "horizon"
    note = f"{surface.n_triangle} triangles, mean dip {dip:.0f} degrees"
    words = f"{path.stem} {known_as}"
    # Between gentle and steep the shape does not decide.
    if STEEP / 2 < dip < 1.5 * STEEP or not dip:  # the name decides
        if FAULT_NAME.search(words):
            kind = "fault"
        elif HORIZON_NAME.search(words):
            kind = "horizon"
    file = Found(path, kind, "mesh", note, name, np.asarray(surface.vertices), data=surface)
    # of several surfaces in a file each may state it: equal points, whatever the caller assumes
    file.states_direction = np.array_equal(file.points, read(DOWN).vertices)
    file.states_unit = True  # files of meshes state it, or it is that of x and y
    return file


# ---- tables ----------------------------------------
# Tables of text: points of horizons, sticks, polygons, outlines and well tops.


FEWEST = 20  # points of a horizon


def table(path: Path, function: str) -> Found:
    """Points, lines or well tops: what they are for a model follows from their shape."""
    if function == "read_tops":
        return well_tops(path)
    text = "" if detect(path) else read_text(path, final_line_end=False)
    header = text.lstrip().split("\n", 1)[0].strip()
    # A file with several objects would become one horizon.
    several = several_objects(text)
    if several:
        return Found(path, OUT, "table", several)
    if function != "read_points":
        return lines_of_table(path, header)
    one = surface_of_file(path, read_points, "points", "horizon", "")
    one.header = header
    return _judged_points(one)


def _judged_points(file: Found) -> Found:
    """Points of a horizon, or too few or too steep ones."""
    n = len(file.points)
    if n < FEWEST:
        file.leave_out(f"{counted(n, 'point')}: too few for a horizon")
        return file
    # Picks of a fault lie on a steep plane; without sticks no surface follows.
    dip = plane_dip(file.points)
    if dip >= STEEP:
        file.leave_out(
            f"{n} points of a plane that dips {dip:.0f} degrees: picks of a fault without sticks. "
            "Add a column STICK_ID, or a line 999 999 999 after each stick"
        )
    else:
        file.note = f"{file.note} points"
    return file


def well_tops(path: Path) -> Found:
    """Well tops."""
    tops = read_tops(path, **UP)
    wells = len(set(tops.well.values.tolist()))
    points = np.column_stack([tops.easting, tops.northing, tops.elevation])
    note = f"{len(points)} tops of {counted(wells, 'well')}"
    one = Found(path, "tops", "well tops", note, points=points)
    one.states_direction = detect(path) == "petrel_tops"
    return one


def lines_of_table(path: Path, header: str) -> Found:
    """Sticks of a fault, fault polygons, or an outline."""
    lines = read_polygons(path, positive="up")
    points = np.concatenate(lines)
    file = Found(path, "fault", "sticks", points=points, header=header)
    # A polygon repeats its first point.
    closed = [bool((line[0] == line[-1]).all()) and len(line) > 3 for line in lines]
    # Level lines: an outline in the map.
    if not np.ptp(points[:, 2]):
        file.kind, file.form, file.note = (
            "outline",
            "polygon",
            f"{counted(len(lines), 'line')}, level",
        )
        if len(lines) > 1 or not closed[0]:
            file.leave_out(f"{counted(len(lines), 'level line')}: neither sticks nor one polygon")
        return file
    # Closed and not level: polygons along the cut-offs of one horizon.
    if all(closed):
        file.kind = file.form = "polygons"
        file.parts, file.note = lines, counted(len(lines), "closed line")
        return file
    file.note = f"{counted(len(lines), 'stick')}, dip {_stick_dip(lines):.0f} degrees"
    if len(lines) < 2 or path.suffix.lower() not in FAULT_FORMATS["sticks"][2]:
        file.leave_out(
            "1 stick: a fault needs two" if len(lines) < 2
            else f"{len(lines)} sticks: a scenario reads sticks from .pol and .csv; rename the file"
        )  # fmt: skip
        return file
    file.data = read_fault(path, positive="up")
    return file


def named_faults(path: Path, key: str) -> list[Found]:
    """Each fault of a file of named lines; a run picks it by its name."""
    return [sticks_of(path, name) for name in fault_names(path, key)]


def sticks_of(path: Path, name: str) -> Found:
    """A fault as lines."""
    fault: Any = read_fault(path, name=name or None, **UP)
    lines = list(fault.sticks)
    note = f"{counted(len(lines), 'stick')}, dip {_stick_dip(lines):.0f} degrees"
    points = np.concatenate(lines)
    file = Found(path, "fault", "sticks", note, name, points, data=fault, in_file=name)
    if len(lines) < 2:
        file.leave_out("1 stick: a fault needs two")
    return file


def _stick_dip(lines: list[np.ndarray]) -> float:
    """Median dip [degrees] of lines, from end to end."""
    ends = np.array([line[-1] - line[0] for line in lines])
    # From end to end, so that waves of a stick do not count.
    level = np.hypot(ends[:, 0], ends[:, 1])
    return float(np.degrees(np.median(np.arctan2(np.abs(ends[:, 2]), level))))


def recognised(path: Path) -> list[Found]:
    """Return what a file holds: one object, or several in a file with several surfaces."""
    # A folder stands for its files, but for the results of geosurf.
    if path.is_dir():
        return [Found(path, OUT, note="a folder with results of an earlier run", name=path.name)]
    try:
        parts = _held(path)
    except GeosurfError as error:
        # The table names the file in its own column.
        reason = str(error).replace(f"{path}: ", "").replace(f"{path}, ", "")
        parts = [Found(path, OUT, note=reason)]
    for part in parts:
        part.name = part.name or name_from(path)
    return parts


def _held(path: Path) -> list[Found]:
    if not path.exists():
        read_text(path)  # the reason why it cannot be opened
    key, function = kind_of_file(path)
    if key == "model3d":
        return [Found(path, "model", "sealed model", "GOCAD Model3d")]
    # Parametric grids of faults are NetCDF files as well; their dimensions tell.
    if key == "netcdf" and holds_fault(path):
        return [
            surface_of_file(path, read_fault, "parametric grid", "fault", "has fault dimensions")
        ]
    if key in GRID_FORMATS:
        return [grid(path)]
    if key == "tsurf":
        return tsurfs(path)
    if key == "resqml":
        return resqml(path)
    if key in MESH_FORMATS:
        return pieces(mesh(path, path.stem, lambda words: read_horizon(path, **words)))
    if key in NAMED_LINES:
        return named_faults(path, key)
    if function.split(" ")[0] in ("read_points", "read_polygons", "read_tops"):
        return [table(path, function)]
    return [Found(path, OUT, TITLES.get(key, ""), strange(path) if key == "unknown" else NO_PLACE)]
