"""Paths of wells: from positions, or from measured depths and directions.

`columns` turns files into names of columns and rows of words, with what the header states;
`read_wells` turns these rows into places along each well, by minimum curvature.
"""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import counted, elevation_sign, metres_per_unit
from geosurf.conventions.checks import no_data_in
from geosurf.errors import FormatError, InputError
from geosurf.lazy import xarray as xr
from geosurf.model.expected import path_of
from geosurf.read._common import Request, agreed_scale, noted
from geosurf.read._guard import damaged
from geosurf.read._placed import points_dataset
from geosurf.read._table import checked_decimal
from geosurf.read.las import path_of_las
from geosurf.read.registry import detect, refuse_columns, refuse_foreign
from geosurf.read.resqml.surfaces import wells_of_resqml
from geosurf.read.tops import plain_name, unit_of_column
from geosurf.read.wells.columns import (
    PLACES,
    SURVEY,
    Trace,
    check_kind,
    checked_columns,
    column_of,
    heads_of,
    places_of,
    rows_of_wells,
    three_names,
    trace_of,
)

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.read.wells.columns import Heads


# ---- curvature ----------------------------------------
# Minimum curvature: from measured depths and directions of a well to places along it.
#
# Between two stations the path is an arc of a circle that has the directions of both as its
# tangents, the method of the industry. Straight lines between stations would leave the arc by
# several metres where stations are far apart, so points are added along each arc.


SAG = 0.01  # m: how far a straight line between two points may be from the arc


def along_arcs(
    md: np.ndarray, inclination: np.ndarray, azimuth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return places along a well relative to its first station, and their measured depths.

    Parameters
    ----------
    md : ndarray of float64, shape (n,)
        Measured depths of the stations [m], which rise.
    inclination, azimuth : ndarray of float64, shape (n,)
        Angles from the vertical, and clockwise from grid north [degrees]. The directions of two
        neighbours are not opposite.

    Returns
    -------
    (ndarray of float64, shape (m, 3), ndarray of float64, shape (m,))
        East, north and up [m], and measured depths [m]: of all stations, and of points between
        them, so that straight lines are within 1 cm of the arcs.

    Examples
    --------
    >>> import numpy as np
    >>> quarter = 500.0 * np.pi  # an arc with a radius of 1000 m, from the vertical to the east
    >>> places, _ = along_arcs(np.array([0.0, quarter]), np.array([0.0, 90.0]), np.full(2, 90.0))
    >>> places[-1].round(9).tolist()
    [1000.0, 0.0, -1000.0]
    """
    inc, azi = np.radians(inclination), np.radians(azimuth)
    tangents = np.column_stack([np.sin(inc) * np.sin(azi), np.sin(inc) * np.cos(azi), -np.cos(inc)])
    start, end = tangents[:-1], tangents[1:]
    length = np.diff(md)

    # the angle between two directions from sine and cosine is accurate for small ones, too
    cosine = (start * end).sum(axis=1)
    sine = np.linalg.norm(np.cross(start, end), axis=1)
    angle = np.arctan2(sine, cosine)
    across = end - start * cosine[:, None]
    across /= np.where(sine > 0.0, sine, 1.0)[:, None]

    # so many pieces that no straight one is farther than SAG from its arc
    with np.errstate(divide="ignore"):
        flat = np.where(angle > 0.0, SAG * angle / length, 0.0)
    widest = 2.0 * np.arccos(np.maximum(1.0 - flat, -1.0))
    count = np.ceil(np.divide(angle, widest, out=np.ones_like(angle), where=angle > 0.0))
    count = np.maximum(count.astype(np.int64), 1)
    piece = np.repeat(np.arange(len(length)), count)
    share = np.concatenate([np.arange(1, n + 1) / n for n in count])

    # on the arc: R sin(phi) along the first direction, R (1 - cos(phi)) across, with R = L / angle
    turned = share * angle[piece] / np.pi
    along = share * np.sinc(turned)
    aside = share * np.sinc(0.5 * turned) * np.sin(0.5 * np.pi * turned)
    moved = length[piece, None] * (along[:, None] * start[piece] + aside[:, None] * across[piece])
    ends = np.cumsum(count) - 1
    starts = np.concatenate([np.zeros((1, 3)), np.cumsum(moved[ends], axis=0)])
    places = np.concatenate([np.zeros((1, 3)), starts[piece] + moved])
    depths = md[piece] + share * length[piece]
    depths[ends] = md[1:]
    return places, np.concatenate([md[:1], depths])


# ---- stations ----------------------------------------
# Stations of a survey: measured depths and directions that make one path.


Three = tuple[np.ndarray, np.ndarray, np.ndarray]


def checked_stations(
    path: Path,
    name: str,
    lines: list[int],
    md: np.ndarray,
    inclination: np.ndarray,
    azimuth: np.ndarray,
) -> Three:
    """
    Return the stations of a well from measured depth 0 on, without repeated ones.

    Parameters
    ----------
    path : pathlib.Path
    name : str
        Of the well.
    lines : list of int
        Line of each station, from 1.
    md, inclination, azimuth : ndarray of float64, shape (n,)
        Measured depths [m], which do not fall, and angles [degrees].

    Raises
    ------
    FormatError
        For angles that are not degrees, two directions at one depth, opposite neighbours, and a
        first station that leaves the way from the well head open.
    """
    wrong = (inclination < 0.0) | (inclination > 180.0) | (np.abs(azimuth) > 360.0)
    if wrong.any():
        k = int(wrong.argmax())
        raise FormatError(
            f"{path}, line {lines[k]}: well {name!r} has the inclination {inclination[k]:g} and "
            f"the azimuth {azimuth[k]:g}. Inclinations are 0 to 180 degrees from the vertical, "
            "azimuths -360 to 360 degrees from grid north."
        )
    repeats = np.append(False, np.diff(md) == 0.0)
    turned = repeats & np.append(False, (np.diff(inclination) != 0.0) | (np.diff(azimuth) != 0.0))
    if turned.any():
        k = int(turned.argmax())
        raise FormatError(
            f"{path}, line {lines[k]}: well {name!r} has two directions at the measured depth "
            f"{md[k]:g} m. Delete one of the stations."
        )
    stations = np.column_stack([md, inclination, azimuth])[~repeats]
    lines = [line for line, repeat in zip(lines, repeats, strict=True) if not repeat]
    if stations[0, 0] != 0.0:
        if stations[0, 0] < 0.0 or stations[0, 1] != 0.0:
            raise FormatError(
                f"{path}, line {lines[0]}: the first station of well {name!r} is at the measured "
                f"depth {stations[0, 0]:g} m with the inclination {stations[0, 1]:g}, so the way "
                "there is unknown. Add a station at measured depth 0."
            )
        stations = np.concatenate([np.zeros((1, 3)), stations])  # straight down to the first one
        lines = [lines[0], *lines]
    back = _turns_back(*np.radians(stations[:, 1:]).T)
    if len(back):
        raise FormatError(
            f"{path}, line {lines[int(back[0]) + 1]}: well {name!r} turns by 180 degrees from one "
            "station to the next, so its arc is unknown. Correct the angles."
        )
    return stations[:, 0], stations[:, 1], stations[:, 2]


def _turns_back(inclination: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Rows after which the direction is opposite."""
    flat = np.sin(inclination)
    ways = np.column_stack([flat * np.sin(azimuth), flat * np.cos(azimuth), np.cos(inclination)])
    return np.flatnonzero((ways[:-1] * ways[1:]).sum(axis=1) < -1.0 + 1e-12)


Path3 = tuple[np.ndarray, np.ndarray | None]  # points (n, 3) and measured depths (n,)


def read_wells(
    path: str | PathLike[str],
    *,
    heads: Mapping[str, Any] | str | PathLike[str] | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
    columns: Mapping[str, str | int] | None = None,
    decimal: str = ".",
) -> xr.Dataset:
    r"""
    Read the paths of wells.

    Parameters
    ----------
    path : path-like
        A well trace of Petrel (``.dev``), a well of RMS (``.rmswell``), wells of ResInsight, LAS
        with curves of positions, RESQML (``.epc``) with trajectories, or a table with a header;
        the content determines which. A table has ``Well`` (else all rows are one well) and ``X``,
        ``Y``, ``Z`` or ``TVDSS``, perhaps with ``MD`` or ``KB``, or ``MD``, ``Inc``, ``Azi`` with
        `heads`.
    heads : mapping or path-like, optional
        Where each well has measured depth 0: easting, northing and elevation [m], such as
        ``{"W-1": (461000, 5932000, 25)}``, or a table with ``Well``, ``X``, ``Y``, ``KB``. Only
        for files without positions.
    positive : {"up", "down"}, optional
        Whether z is elevation or depth, if the file does not state it. Without effect where
        places follow from measured depths and directions.
    length_unit : str, optional
        Unit of z and of measured depths, if the file does not state it. Default ``"m"``.
    columns : mapping of str to str or int, optional
        Names, or numbers from 1, of the columns ``well``, ``x``, ``y``, ``z``, ``md``,
        ``inclination`` and ``azimuth`` where they differ from the usual ones: ``{"md": "DEPT"}``.
    decimal : {".", ","}, optional
        Decimal sign of the file.

    Returns
    -------
    xarray.Dataset
        ``well``, ``easting``, ``northing``, ``elevation`` and, if the file has them, ``md`` over
        ``point`` [m], positive up; wells in the order of the file. Without measured depths they
        count from a datum that is stated (``KB``, ``RKB``, ``GL``, the rig of RMS), straight down
        to the first point. `Scene.well_intervals` and
        `PictureOverlay` take it as it is. Places from directions are on arcs of circles (minimum
        curvature), with points added so that straight lines are within 1 cm of the arcs. Azimuths
        count from grid north, in degrees.

    Raises
    ------
    FormatError
        If a column is missing, a value is not a number, or measured depths do not rise.
    InputError
        If the file cannot be opened, `positive` is missing, or a well has no head.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "survey.csv"
    >>> _ = file.write_text("Well,MD,Inc,Azi\nW-1,0,0,0\nW-1,1000,0,0\nW-1,2570.8,90,90\n")
    >>> wells = read_wells(file, heads={"W-1": (500, 900, 25)})
    >>> wells.isel(point=-1).easting.round(2).item(), wells.isel(point=-1).elevation.round(2).item()
    (1500.0, -1975.0)
    """
    path = path_of(path, "read_wells")
    if positive is not None:
        elevation_sign(positive, f"{path.name}: wells")
    sign = checked_decimal(decimal)
    given = checked_columns(columns)
    known = heads_of(heads, sign)
    if detect(path) == "las":
        well = path_of_las(
            path, Request(positive=positive, length_unit=length_unit, columns=three_names(given))
        )
        return _dataset(path, {well.well: (well.points, well.md)}, None)

    if detect(path) == "resqml":
        refuse_columns(path, "resqml", columns, decimal)
        return _dataset(
            path, *wells_of_resqml(path, Request(positive=positive, length_unit=length_unit))
        )

    refuse_foreign(path)
    trace = trace_of(path, sign, any(isinstance(word, int) for word in given.values()))
    places = places_of(path, trace, given)
    check_kind(path, trace, places)
    values = {
        key: column_of(path, trace, k, key, sign) for key, k in places.items() if key != "well"
    }
    rows = rows_of_wells(path, trace, places)
    if all(key in places for key in PLACES):
        _to_metres(path, trace, places, values, Request(positive=positive, length_unit=length_unit))
        noted("wells", f"{len(rows)}, by positions ({trace.kind})")
        return _dataset(path, _by_positions(path, trace, rows, values), trace.crs)
    unit = unit_of_column(trace.header, places["md"], (trace.units or {}).get("z"))
    values["md"] *= agreed_scale(unit, length_unit, "m", f"{path.name}: measured depths")
    noted("wells", f"{len(rows)}, by minimum curvature from md, inclination, azimuth")
    return _dataset(path, _by_directions(path, trace, rows, values, known), trace.crs)


# ----------------------------------------------------------------------- places
def _to_metres(
    path: Path,
    trace: Trace,
    places: dict[str, int],
    values: dict[str, np.ndarray],
    request: Request,
) -> None:
    """Turn positions and measured depths into metres, z into elevation."""
    units = trace.units or {}
    what = f"{path.name}: wells"
    stated = trace.positive or _sign_of_petrel(path, trace, values["z"])
    unit = unit_of_column(trace.header, places["z"], units.get("z"))
    values["z"] = values["z"] * request.scale(what, positive=stated, unit=unit) + 0.0
    for key in ("x", "y"):
        unit = unit_of_column(trace.header, places[key], units.get("xy"))
        values[key] *= metres_per_unit(unit or "m", what)
    for key in {"md", "datum"} & set(places):  # a datum is an elevation, whatever z is
        unit = unit_of_column(trace.header, places[key], units.get("z"))
        values[key] *= agreed_scale(unit, request.length_unit, "m", what)


def _sign_of_petrel(path: Path, trace: Trace, z: np.ndarray) -> str | None:
    """Direction of z of a well trace: that in which z runs against, or with, its column TVD."""
    words = [plain_name(word) for word in trace.header]
    if trace.kind != "well trace of Petrel":
        return None
    if "tvd" not in words:
        return "up"  # Petrel writes elevations
    tvd = column_of(path, trace, words.index("tvd"), "TVD", ".")
    spread = {"up": np.ptp(z + tvd), "down": np.ptp(z - tvd)}
    best = min(spread, key=lambda key: float(spread[key]))
    if spread[best] > 0.01 * max(float(np.ptp(tvd)), 1.0):
        raise damaged(
            f"{path}: Z and TVD do not differ by one number along the well, as elevation and "
            f"vertical depth do: they drift by {spread[best]:g}"
        )
    return best if np.ptp(tvd) > 0.0 else "up"


def _by_positions(
    path: Path, trace: Trace, rows: dict[str, np.ndarray], values: dict[str, np.ndarray]
) -> dict[str, Path3]:
    """Paths whose places the file states."""
    points = np.column_stack([values[key] for key in PLACES])
    paths: dict[str, Path3] = {}
    for name, at in rows.items():
        md = values["md"][at] if "md" in values else None
        lines = [trace.rows[int(k)][0] for k in at]
        if absent := no_data_in(points[at]):
            raise damaged(
                f"{path}, line {lines[absent[0]]}: well {name!r} has {absent[1]:g} there, a usual "
                "mark of no data"
            )
        if md is not None:
            _check_rise(path, trace, name, at, md)
            far = np.linalg.norm(np.diff(points[at], axis=0), axis=1)
            leaps = np.flatnonzero(far > 1.5 * np.diff(md) + 10.0)
            if len(leaps):
                k = int(leaps[0])
                raise FormatError(
                    f"{path}, line {lines[k + 1]}: well {name!r} goes {far[k]:.0f} m while its "
                    f"measured depth rises by {md[k + 1] - md[k]:.0f} m. Correct its place, its "
                    "measured depth or its units."
                )
        elif "datum" in values:
            # straight down from the datum to the first point, and along the path from there
            legs = np.linalg.norm(np.diff(points[at], axis=0), axis=1)
            above = max(float(values["datum"][at[0]] - points[at[0], 2]), 0.0)
            md = above + np.append(0.0, np.cumsum(legs))
        if not (np.ptp(points[at], axis=0) > 0.0).any():
            raise FormatError(
                f"{path}: well {name!r} has {counted(len(at), 'point')} in one place; a path "
                "needs two different ones. Complete it, or leave the well out."
            )
        paths[name] = (points[at], md)
    return paths


def _by_directions(
    path: Path,
    trace: Trace,
    rows: dict[str, np.ndarray],
    values: dict[str, np.ndarray],
    heads: Heads,
) -> dict[str, Path3]:
    """Paths from measured depths and directions, by minimum curvature."""
    units, stated = trace.units or {}, trace.head or {}
    if heads and (extra := [name for name in heads if name not in rows]) and len(rows) > 1:
        noted("heads", f"not used: {', '.join(extra)}")
    paths: dict[str, Path3] = {}
    for name, at in rows.items():
        head = heads.get(name)
        if head is None and len(stated) == 3:
            plane = metres_per_unit(units.get("xy", "m"), f"{path.name}: well head")
            up = metres_per_unit(units.get("z", "m"), f"{path.name}: well datum")
            head = (stated["x"] * plane, stated["y"] * plane, stated["z"] * up)
        if head is None:
            raise InputError(
                f"{path}: well {name!r} has measured depths and directions, but no place to begin "
                f"at. Give it, as in heads={{{name!r}: (easting, northing, elevation of the drill "
                "floor)}, in metres."
            )
        md, inc, azi = (values[key][at] for key in SURVEY)
        _check_rise(path, trace, name, at, md)
        lines = [trace.rows[int(k)][0] for k in at]
        md, inc, azi = checked_stations(path, name, lines, md, inc, azi)
        if len(md) < 2:
            raise damaged(f"{path}: well {name!r} has one station at the well head only")
        places, depths = along_arcs(md, inc, azi)
        paths[name] = (places + np.array(head), depths)
    return paths


def _check_rise(path: Path, trace: Trace, name: str, at: np.ndarray, md: np.ndarray) -> None:
    """Refuse measured depths that fall along a well."""
    falls = np.flatnonzero(np.diff(md) < 0.0)
    if len(falls):
        line = trace.rows[int(at[falls[0] + 1])][0]
        raise FormatError(
            f"{path}, line {line}: the measured depth of well {name!r} falls from {md[falls[0]]:g} "
            f"m to {md[falls[0] + 1]:g} m. Sort its rows; a side track needs a name of its own."
        )


def _dataset(path: Path, wells: dict[str, Path3], crs: str | None) -> xr.Dataset:
    """All wells in one table."""
    points = np.concatenate([places for places, _ in wells.values()])
    names = np.concatenate([np.full(len(p), name, dtype=object) for name, (p, _) in wells.items()])
    others: dict[str, Any] = {"well": ("point", names)}
    depths = [md for _, md in wells.values() if md is not None]
    if depths:
        others["md"] = ("point", np.concatenate(depths), {"units": "m"})
    found = points_dataset(points, path.name, crs, others)
    return found[["well", *(key for key in found.data_vars if key != "well")]]
