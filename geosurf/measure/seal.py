"""Estimate what a fault holds: shale gouge ratio, clay smear potential, threshold pressure.

Areas and extremes are those of the triangles of the Allan diagram, on each of which the ratio is
linear, see `Walls.divided`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.conventions import check_name, is_number, real_numbers
from geosurf.conventions.axes import meaning
from geosurf.errors import GeosurfWarning, InputError
from geosurf.lazy import xarray
from geosurf.measure.cutoffs import juxtaposition_table, pairs_of, sums_by_group
from geosurf.measure.faces import edges_of, faces_of
from geosurf.measure.walls import Walls
from geosurf.model import Patches, Units
from geosurf.model.column import ELSEWHERE, names_of_zones
from geosurf.model.expected import number_of

MANY = 0.05  # of the area of a fault: assumed cut-offs that a warning is worth
WELLS = "wells"  # key of the curve of wells among zones
GRAVITY = 9.80665  # [m/s2]
# Bretan et al. (2003): burial depth [m] from which each constant counts
BRETAN = ((0.0, 0.5), (3000.0, 0.25), (3500.0, 0.0))


# ---- shale by zone ----------------------------------------


def vshale_of(scene: Any, given: Any) -> dict[str, float]:
    """
    Return the Vshale of each zone, youngest first; NaN where nobody states it.

    Parameters
    ----------
    scene : Scene
    given : number or mapping
        Fractions by zone; ``"elsewhere"``: all others; ``"wells"``: a table with paths of wells and
        a column ``vshale``, for zones without an entry.

    Raises
    ------
    InputError
        For an unknown zone, or a number that is no fraction.
    """
    zones = names_of_zones(scene.horizon_names)
    entries = dict(given) if isinstance(given, Mapping) else {ELSEWHERE: given}
    well_means: dict[str, float] = {}
    if (table := entries.pop(WELLS, None)) is not None:
        well_means = mean_in_zones(table, scene)
    for name, value in entries.items():
        known = (*zones, WELLS, ELSEWHERE)
        check_name(name, known, f"vshale has an entry for {name!r}. Zones are")
        if not is_number(value) or not 0.0 <= float(value) <= 1.0:
            raise InputError(
                f"vshale of {name!r} is {value!r}. Give a fraction from 0 to 1, by zone if it "
                "differs: vshale={'Top/Base': 0.2, 'elsewhere': 0.7}."
            )
    other = entries.get(ELSEWHERE, math.nan)
    return {zone: float(entries.get(zone, well_means.get(zone, other))) for zone in zones}


def mean_in_zones(table: Any, scene: Any) -> dict[str, float]:
    """
    Return the mean Vshale of wells in each zone, weighted by vertical thickness.

    Parameters
    ----------
    table : table
        With columns ``well``, ``md`` and ``vshale``, which is straight between samples; next to a
        NaN there is none.
    scene : Scene

    Raises
    ------
    InputError
        If a column is missing, measured depth does not rise, or Vshale is no fraction.
    """
    known = table if hasattr(table, "__contains__") else ()
    missing = [key for key in ("well", "md", "vshale") if key not in known]
    if missing:
        raise InputError(
            f"the wells of vshale have no column {missing[0]!r}. Give a table with the columns "
            "well, md, easting, northing, elevation and vshale."
        )
    names, md, values = (np.ravel(np.asarray(table[key])) for key in ("well", "md", "vshale"))
    sums: dict[str, np.ndarray] = {}
    intervals = scene.well_intervals(table)
    for row in range(intervals.sizes["interval"]):
        interval = intervals.isel(interval=row)
        of_well = names == interval.well.item()
        depth, curve = md[of_well].astype(float), values[of_well].astype(float)
        if not (np.diff(depth) > 0.0).all() or ((curve < 0.0) | (curve > 1.0)).any():
            raise InputError(
                f"well {interval.well.item()!r}: give md that rises, and vshale from 0 to 1."
            )

        # the ends of the interval are samples, too: each piece is in one zone and straight
        (start, end), (top, base) = interval.md.values, interval.elevation.values
        at = np.unique(np.clip([*depth, start, end], start, end))
        ends = np.interp(at, depth, curve, left=np.nan, right=np.nan)
        middle = 0.5 * (ends[1:] + ends[:-1])
        step = np.where(np.isnan(middle), 0.0, np.diff(at)) * abs(top - base) / (end - start)
        total = np.array([step @ np.nan_to_num(middle), step.sum()])
        sums[str(interval.zone.item())] = sums.get(str(interval.zone.item()), 0.0) + total
    return {zone: float(area / length) for zone, (area, length) in sums.items() if length > 0.0}


# ---- result ----------------------------------------


def threshold_pressure(sgr: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """
    Return the capillary threshold pressure of fault rock [bar] (Bretan et al. 2003).

    Parameters
    ----------
    sgr : ndarray of float64
        Shale gouge ratio, a fraction.
    depth : ndarray of float64
        Burial depth [m].

    Examples
    --------
    >>> threshold_pressure(np.array([0.27, 0.27]), np.array([2000.0, 4000.0])).round(3).tolist()
    [3.162, 10.0]
    """
    steps, constants = np.array(BRETAN).T
    c = constants[np.maximum(np.searchsorted(steps, depth, "right") - 1, 0)]
    return np.asarray(10.0 ** (100.0 * sgr / 27.0 - c))


def share_above(values: np.ndarray, limit: float) -> np.ndarray:
    """Share of the area of triangles on which linear values (n, 3) reach a limit.

    Examples
    --------
    >>> share_above(np.array([[0.0, 1.0, 2.0], [1.0, 1.0, 1.0]]), 1.0).tolist()
    [0.5, 1.0]
    """
    low, middle, high = np.sort(values, axis=1).T
    with np.errstate(invalid="ignore", divide="ignore"):
        upper = (high - limit) ** 2 / ((high - low) * (high - middle))
        lower = 1.0 - (limit - low) ** 2 / ((middle - low) * (high - low))
    found = np.where(limit <= middle, lower, upper)
    found = np.where(limit > high, 0.0, np.where(limit <= low, 1.0, found))
    return np.asarray(found)


def walls_of(
    patches: Patches, units: Units, fault: str, vshale: Mapping[str, float], shale: float
) -> Walls:
    """Return the walls of a fault, or an error that names a zone without Vshale."""
    faces = faces_of(patches, units, fault, "fault")
    zones, values = list(vshale), list(vshale.values())
    beside = np.unique(faces.sides[(faces.sides >= 0).all(axis=1)])
    for k in np.unique(faces.zones[beside]).tolist():
        if math.isnan(values[k]):
            raise InputError(
                f"vshale has no value for zone {zones[k]!r}, which lies on fault {fault!r}. Add "
                f"{{{zones[k]!r}: 0.7}}, or 'elsewhere' for all zones without one."
            )
    rows = [i for i in sorted(units.rows_inside) if patches.sources[i].role == "horizon"]
    edges = [edges_of(units, i) for i in rows]
    return Walls(faces, np.unique(np.concatenate([*edges, np.empty(0, np.int64)])), values, shale)


def fault_seal(
    patches: Patches,
    units: Units,
    fault: str,
    vshale: Mapping[str, float],
    shale: float,
    density_contrast: float | None,
    seabed: float,
    classes: Sequence[float],
) -> xarray.Dataset:
    """
    Estimate what a fault holds, on the polygons of its Allan diagram.

    Parameters
    ----------
    patches, units : Patches, Units
    fault : str
    vshale : mapping of str to float
        By zone, youngest first, see `vshale_of`.
    shale, density_contrast, seabed, classes
        As for `Scene.seal`.

    Returns
    -------
    xarray.Dataset
        As `Scene.seal`.
    """
    walls = walls_of(patches, units, fault, vshale, shale)
    faces, table = walls.faces, juxtaposition_table(patches, units, fault)
    pairs, group, between = pairs_of(faces)
    sides = faces.sides[between]
    corners, row, values, linear = walls.divided(faces.x[faces.triangles[between]], sides)
    pair, n = group[row], len(pairs)
    half = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(half, axis=1)

    # corners of triangles, point after point
    flat, over = corners.reshape(-1, 3), ("triangle", "corner")
    shape = len(corners), 3
    world = flat + faces.origin
    depth = seabed - world[:, 2]
    pressure = threshold_pressure(values.ratio, depth)
    columns: dict[str, tuple[Any, str, str]] = {
        "along_strike": (faces.along(flat), "m", "distance along the mean strike of the fault"),
        "easting": (world[:, 0], "m", "easting"),
        "northing": (world[:, 1], "m", "northing"),
        "elevation": (world[:, 2], "m", "elevation, positive up"),
        "sgr": (values.ratio, "1", "shale gouge ratio, mean of both walls"),
        "sgr_plus": (values.sgr[:, 0], "1", "shale gouge ratio of the rock on side +"),
        "sgr_minus": (values.sgr[:, 1], "1", "shale gouge ratio of the rock on side -"),
        "throw": (values.mean_throw, "m", "throw, above 0 where the hanging wall is down"),
        "csp": (values.csp, "m", "clay smear potential, infinite against a source bed"),
        "threshold_pressure": (pressure, "bar", "capillary threshold pressure of the fault rock"),
    }
    if density_contrast is not None:
        height = 1e5 * pressure / (density_contrast * GRAVITY)
        columns["column_height"] = (height, "m", "hydrocarbon column that the fault rock holds")
        words = "hydrocarbon-water contact that the fault rock holds here"
        columns["contact"] = (world[:, 2] - height, "m", words)
    data: dict[str, Any] = {
        key: (over, of.reshape(shape), {"units": unit, "long_name": words})
        for key, (of, unit, words) in columns.items()
    }
    data["triangle_area"] = ("triangle", area, {"units": "m2", "long_name": "area"})
    data["triangle_pair"] = ("triangle", pair, {"long_name": "row of its pair of units"})

    # polygons: areas by class, what is not known, mean and extremes
    sgr = data["sgr"][1]
    known = np.isfinite(sgr).all(axis=1)
    held = np.where(known[:, None], sgr, 0.0)
    reach = [known * share_above(held, limit) for limit in (-np.inf, *classes, np.inf)]
    by_class = [sums_by_group(pair, area * (more - less), n) for more, less in pairwise(reach)]
    told = meaning("area with a shale gouge ratio in each class", "m2")
    data["class_area"] = (("pair", "sgr_class"), np.stack(by_class, axis=1), told)
    assumed = values.assumed.reshape(shape).any(axis=1)
    for name, mask, words in (
        ("unknown_area", ~known, "area without a shale gouge ratio"),
        ("assumed_area", assumed, "area that rests on cut-offs continued beyond their ends"),
    ):
        data[name] = ("pair", sums_by_group(pair, mask * area, n), meaning(words, "m2"))
    data |= _of_pairs(data, pair, np.where(known, area, 0.0), n)
    reservoir = [u.zone in units.reservoir and vshale[u.zone] < shale for u in faces.listed]
    kinds = np.array(JUXTAPOSED, dtype=object)[np.array(reservoir)[pairs].sum(axis=1)]
    coords = {
        "juxtaposition": ("pair", kinds, {"long_name": "what faces what across the fault"}),
        "sgr_lower": ("sgr_class", np.array([0.0, *classes]), {"units": "1"}),
        "sgr_upper": ("sgr_class", np.array([*classes, 1.0]), {"units": "1"}),
    }
    of_zones = ", ".join(f"{zone}: {value:g}" for zone, value in vshale.items())
    coarse = math.fsum(area[~linear].tolist())
    attrs = {"vshale": of_zones, "shale": shale, "seabed": seabed, "coarse_area": coarse}
    return table.assign(data).assign_coords(coords).assign_attrs(attrs)


JUXTAPOSED = (
    "non-reservoir on non-reservoir", "reservoir on non-reservoir", "reservoir on reservoir",
)  # fmt: skip


def _of_pairs(
    data: Mapping[str, Any], pair: np.ndarray, weight: np.ndarray, n: int
) -> dict[str, Any]:
    """Means and extremes of each pair of units."""
    columns: dict[str, Any] = {}
    for key in ("sgr", "throw"):
        values, attrs = np.nan_to_num(data[key][1].mean(axis=1)), data[key][2]
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = sums_by_group(pair, weight * values, n) / sums_by_group(pair, weight, n)
        columns[f"mean_{key}"] = "pair", mean, {**attrs, "long_name": f"mean {attrs['long_name']}"}
    for key, choose, word in (
        ("sgr", np.fmin, "min"), ("sgr", np.fmax, "max"), ("csp", np.fmin, "min"),
        ("threshold_pressure", np.fmin, "min"), ("column_height", np.fmin, "min"),
        ("contact", np.fmax, "lowest"),
    ):  # fmt: skip
        if key in data:
            _, values, attrs = data[key]
            held = np.full(n, np.nan)
            choose.at(held, np.repeat(pair, 3), values.ravel())
            words = {**attrs, "long_name": f"{word}. {attrs['long_name']}"}
            columns[f"{word}_{key}"] = "pair", held, words
    return columns


def warnings_of_seal(seal: xarray.Dataset) -> Iterator[GeosurfWarning]:
    """Yield what was assumed, if it counts."""
    fault, beside = str(seal.attrs["fault"]), seal.juxtaposition.values != JUXTAPOSED[0]
    whole = float(seal.area.values[beside].sum())
    for key, effect in (
        ("assumed_area", "rests on cut-offs continued beyond their ends with their mean slope"),
        ("unknown_area", ("has no shale gouge ratio: a horizon does not reach the fault there, or "
                          "its cut-off turns back along strike")),
    ):  # fmt: skip
        area = float(seal[key].values[beside].sum())
        if area > MANY * whole:
            yield GeosurfWarning(
                "seal", fault,
                f"{100.0 * area / whole:.2g} % of fault {fault!r} beside the reservoir {effect}.",
                f"Enlarge the model or extend the fault; seal({fault!r}, ...).{key} says where.",
            )  # fmt: skip


def checked_seal(
    scene: Any, vshale: Any, shale: Any, density_contrast: Any, seabed: Any, classes: Any
) -> tuple[dict[str, float], float, float | None, float, tuple[float, ...]]:
    """Return the arguments of `Scene.seal` as `fault_seal` takes them, or an error."""
    contrast = density_contrast
    if contrast is not None and not number_of(contrast, "density_contrast", "give kg/m3") > 0.0:
        raise InputError(f"density_contrast is {contrast!r}. Give kg/m3 above 0, such as 300.")
    try:
        bounds = real_numbers(classes).ravel().tolist()
    except (TypeError, ValueError):
        bounds = [math.nan]
    if not (np.diff([0.0, *bounds, 1.0]) > 0.0).all():
        raise InputError(
            f"classes is {classes!r}. Give rising fractions, such as (0.15, 0.2, 0.4)."
        )
    least = number_of(shale, "shale", "give a fraction, such as 0.4")
    level = number_of(seabed, "seabed", "give an elevation [m]")
    return vshale_of(scene, vshale), least, contrast, level, tuple(bounds)
