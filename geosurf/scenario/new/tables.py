"""Tables of text: points of horizons, sticks, polygons, outlines and well tops."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted
from geosurf.errors import GeosurfError
from geosurf.read import FAULT_FORMATS, read_fault, read_points, read_polygons, read_tops
from geosurf.read._common import is_number, read_text
from geosurf.read.line_names import fault_names
from geosurf.scenario.new.found import OUT, Found
from geosurf.scenario.new.reading import UP, surface_of_file
from geosurf.scenario.new.shape import plane_dip

STEEP = 30.0  # dip [degrees] from which a surface is taken for a fault
FEWEST = 20  # points of a horizon
OBJECT_COLUMNS = ("feature_name", "formation", "horizon", "surface", "val", "name")


def table(path: Path, points: bool, lines: bool) -> Found:
    """Points or lines of a text file: what they are follows from their columns and their shape."""
    text = read_text(path, final_line_end=False)
    header = text.lstrip().split("\n", 1)[0].strip()
    # Most specific first: tops have named columns, and lines have ends.
    tops = _tops(path, header)
    if tops is not None:
        return tops
    if not _has_numbers(text):
        return Found(path, OUT, "text", "a text, not a table of points")
    # A file with several objects would become one horizon.
    several = _several(header, text)
    if several:
        return Found(path, OUT, "table", several)
    if lines and (path.suffix.lower() == ".pol" or _is_labelled(header) or _has_ends(text)):
        return lines_of_table(path, header)
    # The suffix is that of polygons only: their reader says what is missing.
    if not points:
        read_polygons(path, positive="up")  # the reason why there are no lines
    one = surface_of_file(path, read_points, "points", "horizon", "")
    one.header = header
    return _judged_points(one)


def _judged_points(one: Found) -> Found:
    """Points of a horizon, or too few or too steep ones."""
    n = len(one.points)
    if n < FEWEST:
        one.leave_out(f"{counted(n, 'point')}: too few for a horizon")
        return one
    # Picks of a fault lie on a steep plane; without sticks no surface follows.
    dip = plane_dip(one.points)
    if dip >= STEEP:
        one.leave_out(
            f"{n} points of a plane that dips {dip:.0f} degrees: picks of a fault without sticks. "
            "Add a column STICK_ID, or a line 999 999 999 after each stick"
        )
    else:
        one.note = f"{one.note} points"
    return one


def _tops(path: Path, header: str) -> Found | None:
    """Well tops, if a table has the columns of these."""
    words = re.sub(r"[^a-z0-9]+", " ", header.lower())
    # A header without these words is no table of tops: reading it would cost time.
    if "petrel" not in words and not re.search(r"\b(well|wellname|uwi|wellbore|borehole)\b", words):
        return None
    try:
        tops = read_tops(path, **UP)
    except GeosurfError:
        return None
    wells = len(set(tops.well.values.tolist()))
    points = np.column_stack([tops.easting, tops.northing, tops.elevation])
    note = f"{len(points)} tops of {counted(wells, 'well')}"
    one = Found(path, "tops", "well tops", note, points=points, header=header)
    one.states_direction = "petrel" in words
    return one


def _has_numbers(text: str) -> bool:
    """Whether most lines have two numbers or more, after at most one header in ten lines."""
    # The beginning of a file is enough.
    lines = [line for line in text[:20_000].split("\n") if line.strip()][:50]
    numeric = [sum(map(is_number, re.split(r"[\s,;]+", line))) >= 2 for line in lines]
    return sum(numeric) * 2 >= len(lines)


def _several(header: str, text: str) -> str:
    """The reason why a table holds more than one object, or nothing."""
    names = [word.strip().strip('"').lower() for word in header.split(",")]
    for column in OBJECT_COLUMNS:
        if column in names and {"x", "easting", "x_utme"} & set(names):
            k = names.index(column)
            rows = [line.split(",") for line in text.split("\n")[1:] if line.strip()]
            values = {row[k] for row in rows if len(row) > k and row[k].strip()}
            if len(values) > 1:
                return (
                    f"its column {column!r} has {len(values)} values: write one file for each "
                    "object"
                )
    return ""


def _is_labelled(header: str) -> bool:
    return bool({"poly_id", "stick_id"} & {w.strip().lower() for w in header.split(",")})


def _has_ends(text: str) -> bool:
    """Whether lines end at 999 999 999, more than once."""
    ends = re.findall(r"^\s*999(?:\.0*)?[\s,;]+999(?:\.0*)?[\s,;]+999(?:\.0*)?\s*$", text, re.M)
    return len(ends) > 1


def lines_of_table(path: Path, header: str) -> Found:
    """Sticks of a fault, fault polygons, or an outline."""
    lines = read_polygons(path, positive="up")
    points = np.concatenate(lines)
    one = Found(path, "fault", "sticks", points=points, header=header)
    # A polygon repeats its first point.
    closed = [bool((line[0] == line[-1]).all()) and len(line) > 3 for line in lines]
    # Level lines: an outline in the map.
    if not np.ptp(points[:, 2]):
        one.kind, one.form, one.note = "outline", "polygon", f"{counted(len(lines), 'line')}, level"
        if len(lines) > 1 or not closed[0]:
            one.leave_out(f"{counted(len(lines), 'level line')}: neither sticks nor one polygon")
        return one
    # Closed and not level: polygons along the cut-offs of one horizon.
    if all(closed):
        one.kind = one.form = "polygons"
        one.parts, one.note = lines, counted(len(lines), "closed line")
        return one
    one.note = f"{counted(len(lines), 'stick')}, dip {_stick_dip(lines):.0f} degrees"
    if len(lines) < 2 or path.suffix.lower() not in FAULT_FORMATS["sticks"][2]:
        one.leave_out(
            "1 stick: a fault needs two" if len(lines) < 2
            else f"{len(lines)} sticks: a scenario reads sticks from .pol and .csv; rename the file"
        )  # fmt: skip
        return one
    one.data = read_fault(path, positive="up")
    return one


def named_faults(path: Path, key: str) -> list[Found]:
    """Each fault of a file of named lines; a run picks it by its name."""
    return [sticks_of(path, name) for name in fault_names(path, key)]


def sticks_of(path: Path, name: str) -> Found:
    """A fault as lines."""
    fault: Any = read_fault(path, name=name or None, **UP)
    lines = list(fault.sticks)
    note = f"{counted(len(lines), 'stick')}, dip {_stick_dip(lines):.0f} degrees"
    points = np.concatenate(lines)
    one = Found(path, "fault", "sticks", note, name, points, data=fault, in_file=name)
    if len(lines) < 2:
        one.leave_out("1 stick: a fault needs two")
    return one


def _stick_dip(lines: list[np.ndarray]) -> float:
    """Median dip [degrees] of lines, from end to end."""
    ends = np.array([line[-1] - line[0] for line in lines])
    # From end to end, so that waves of a stick do not count.
    level = np.hypot(ends[:, 0], ends[:, 1])
    return float(np.degrees(np.median(np.arctan2(np.abs(ends[:, 2]), level))))


__all__ = ["named_faults", "sticks_of", "table"]
