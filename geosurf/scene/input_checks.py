"""Inputs of a scene that look wrong: reference systems, feet, faults given twice, other units."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted, grouped, known_names, number_text
from geosurf.conventions.axes import (
    ALIKE,
    cell_means,
    frame_around,
    likeness,
    relief_in_feet,
    vertical_words,
)
from geosurf.conventions.checks import crs_of_foreign
from geosurf.conventions.crs import crs_of, refuse_other_crs, warn_of_unclear_crs
from geosurf.conventions.text import volume_text
from geosurf.errors import GeosurfWarning
from geosurf.faults.distance import in_ring
from geosurf.faults.rules import Rule
from geosurf.lazy import xarray
from geosurf.model import Sheet, TriSurface, Units
from geosurf.model.sheets import ThrowAudit
from geosurf.model.tops import Tops
from geosurf.read.features import features
from geosurf.read.gocad import crs_of_gocad_lines
from geosurf.read.registry import detect
from geosurf.scene.area import parts_of
from geosurf.scene.inputs import SceneInputs
from geosurf.scene.memory import Memory
from geosurf.scene.surfaces import InputSurfaces, warnings_of_names

DEEPER = (2.6, 6.6)  # times: down to twice as deep as the other one, once in metres


# ---- reference systems ----------------------------------------
# Reference systems of what a scene is made of: well tops and area next to surfaces.


FEATURES = ("geojson", "shapefile")


def refuse_other_systems(
    known: Mapping[str, str], crs: str | None, tops: Tops | None, aoi: Any
) -> dict[str, str]:
    """Refuse well tops or an area in another reference system than the surfaces.

    Parameters
    ----------
    known : mapping of str to str
        Reference systems of the surfaces, by name.
    crs : str or None
        That of the scene.
    tops : Tops or None
    aoi : array_like, path or None
        Area of interest.

    Returns
    -------
    dict of str to str
        All systems, by the name of what declares them.

    Raises
    ------
    InputError
        If one of them is provably another one.
    """
    systems = dict(known)
    if crs is not None:
        systems.setdefault("crs", crs)
    more = {"tops": None if tops is None else tops.crs, "aoi": crs_of_outline(aoi)}
    for name, other in more.items():
        if other is not None:
            refuse_other_crs(name, other, systems)
            systems[name] = other
    return systems


def check_system_of_places(scene: Callable[[], str | None], places: Any, name: str) -> None:
    """Refuse places in another reference system than the scene; warn of one that may be another.

    Parameters
    ----------
    scene : callable
        Returns that of the scene, or None.
    places : table, xarray object or object of another package
        As for `Scene.sample`.
    name : str
        What they are, for messages.

    Raises
    ------
    InputError
        If one of them is provably another one.
    """
    declared = _declared(places)
    known = None if declared is None else scene()
    if declared is not None and known is not None:
        refuse_other_crs(name, declared, {"scene": known})
        warn_of_unclear_crs({"scene": known, name: declared})


def warnings_of_places(found: xarray.Dataset, top: float) -> Iterator[GeosurfWarning]:
    """Yield a warning if all points that were asked for lie above the model."""
    z = found.elevation.values if "elevation" in found else np.empty(0)
    if z.size and np.nanmin(z) > top:
        lowest, depth = (number_text(float(value)) for value in (np.nanmin(z), abs(np.nanmax(z))))
        unit = vertical_words()[1]
        effect = (
            f"All points lie above the model: the lowest is at {lowest} {unit}, the top of the "
            f"model at {number_text(top)} {unit}."
        )
        what, below = ("Elevation", "depth") if unit == "m" else ("Time", "time")
        remedy = f"{what} is positive up: write a {below} of {depth} {unit} as -{depth}."
        yield GeosurfWarning("outside", "places", effect, remedy)


def crs_of_outline(aoi: Any) -> str | None:
    """Return the reference system that an area of interest declares; files of features have one."""
    if isinstance(aoi, str | Path):
        return _of_file(Path(aoi))
    return _declared(aoi)


def _declared(value: Any) -> str | None:
    """The system of an object; a geometry of shapely has none."""
    return crs_of_foreign(value) if hasattr(value, "geom_type") else crs_of(value)


def _of_file(path: Path) -> str | None:
    """The system of a file of features or of GOCAD lines; other outlines have none."""
    if not path.is_file():
        return None
    key = detect(path)
    if key == "pline":
        return crs_of_gocad_lines(path)
    if key not in FEATURES:
        return None
    return features(path).crs


def warn_of_inputs(
    inputs: SceneInputs,
    memory: Memory,
    read: InputSurfaces,
    horizons: Sequence[TriSurface],
    tops: Tops | None,
    outline: np.ndarray,
) -> None:
    """Warn of reference systems, feet, names of tops and torn horizons that look wrong.

    Parameters
    ----------
    inputs : SceneInputs
    memory : Memory
        Keeps the warnings.
    read : InputSurfaces
        All surfaces have been read.
    horizons : sequence of TriSurface
    tops : Tops or None
    outline : ndarray of float64, shape (n, 2)
        Corners of the area of the model [m].
    """
    # a reference system that some inputs declare, and others do not
    with memory.collecting():
        known = {name: read.crs[name] for name in inputs.names if name in read.crs}
        warn_of_unclear_crs(refuse_other_systems(known, inputs.crs, tops, inputs.aoi))

    # one file under two names
    rules = (*inputs.rules, *inputs.horizon_rules)
    memory.warn(*warnings_of_repeats(map(read.fault, inputs.faults), rules))

    # heights that are probably feet, or depths
    memory.warn(*warnings_of_signs(horizons))
    if inputs.time is None:
        memory.warn(*warnings_of_feet(horizons))

    # tops of horizons that the scene does not have
    if tops is not None:
        memory.warn(*warnings_of_names(tops, tuple(inputs.horizons)))

    # what was assumed when a horizon was torn has been issued there; the scene lists it, too. How
    # much longer all horizons made a fault is listed already, where the scene tore them
    whole = {warning.subject for warning in memory.warnings if warning.kind == "fault extended"}
    for horizon in inputs.horizons.values():
        if isinstance(horizon, Sheet):
            for warning in warnings_of_sheet(horizon, outline):
                if warning.kind != "fault extended" or warning.subject not in whole:
                    memory.warn(in_time(warning, inputs.time), issued=True)


def warnings_of_sheet(sheet: Sheet, outline: np.ndarray) -> Iterator[GeosurfWarning]:
    """Yield the warnings of a sheet, but those of throw that is lost or doubtful outside an area.

    Parameters
    ----------
    sheet : Sheet
    outline : ndarray of float64, shape (n, 2)
        Corners of the area [m].
    """
    for warning in sheet.warnings:
        places = _places_of_throw(sheet, warning)
        if places is None or in_ring(places, outline).any():
            yield warning


def _places_of_throw(sheet: Sheet, warning: GeosurfWarning) -> np.ndarray | None:
    """Where the throw is lost or doubtful that a warning is of (n, 2 or 3); None for others."""
    audit = sheet.report.throw.get(warning.subject)
    if warning.kind == "throw not as data" and isinstance(audit, ThrowAudit):
        differing: np.ndarray = audit.stations[audit.differs]
        return differing
    if warning.kind != "tear ended early" or warning.place is None:
        return None

    # where the tear ends, and what the fault has beyond: all that is farther along the tear
    end = np.array(warning.place[:2])
    (fault,) = (fault for fault in sheet.faults if fault.name == warning.subject)
    along = end - sheet.cuts[warning.subject].stations[:, :2].mean(axis=0)
    parts = parts_of(fault)[0][:, :2]
    return np.vstack([end, parts[(parts - end) @ along > 0.0]])


def in_time(warning: GeosurfWarning, time: str | None) -> GeosurfWarning:
    """Return a warning of a model, which says what its vertical numbers are if it is in time."""
    if time is None:
        return warning
    words = f"In time (vertical numbers are ms, not m): {warning.effect}"
    return GeosurfWarning(warning.kind, warning.subject, words, warning.remedy, warning.place)


def warnings_of_repeats(
    faults: Iterable[TriSurface], rules: Iterable[Rule] = ()
) -> list[GeosurfWarning]:
    """
    Warn of faults with the same triangles, to the last digit, in whatever order.

    Faults that end differently, such as the halves of an older fault, are parts of one surface.

    Examples
    --------
    >>> x = [[0.0, 0, 0], [0, 9, 0], [0, 0, 9]]
    >>> one, two = (TriSurface(name, "fault", x, [[0, 1, 2]]) for name in ("F1", "F1b"))
    >>> print(warnings_of_repeats([one, two])[0].subject)
    F1b
    """
    first: dict[tuple[Hashable, ...], list[TriSurface]] = {}
    ends = grouped((rule.fault, (rule.main, rule.keep)) for rule in rules)
    warnings = []
    for fault in faults:
        # few faults have the same number of triangles and the same bounds: only these are compared
        end = tuple(sorted(ends.get(fault.name, [])))
        key = fault.n_triangle, np.asarray(fault.bounds).tobytes(), end
        alike = first.setdefault(key, [])
        same = [
            one for one in alike if np.array_equal(_listed_triangles(one), _listed_triangles(fault))
        ]
        if same:
            warnings.append(_warning(same[0].name, fault.name))
        alike.append(fault)
    return warnings


def warnings_of_feet(horizons: Sequence[TriSurface]) -> list[GeosurfWarning]:
    """Warn of horizons that have three times the depth and relief of another of the same shape."""
    level = [_middle(horizon) for horizon in horizons]
    # depths are known without a look at the nodes, and tell nearly all horizons apart
    pairs = [
        (deep, k)
        for deep, k in permutations(range(len(level)), 2)
        if DEEPER[0] * abs(level[k]) < level[deep] * np.sign(level[k]) < DEEPER[1] * abs(level[k])
    ]
    means = _means(horizons, pairs)
    warning_of = {}
    for deep, k in pairs:
        ratio = relief_in_feet(means[deep], [means[k]])
        if ratio:
            warning_of[deep] = _looks_like_feet(horizons[deep], horizons[k], ratio)
    return [*warning_of.values()]


def warnings_of_signs(horizons: Sequence[TriSurface]) -> list[GeosurfWarning]:
    """Warn of horizons above 0 whose shape is that of one below 0, upside down."""
    above = [k for k, horizon in enumerate(horizons) if horizon.bounds[4] > 0.0]
    below = [k for k, horizon in enumerate(horizons) if horizon.bounds[5] < 0.0]
    pairs = [(high, low) for high in above for low in below]
    means = _means(horizons, pairs)
    # of a horizon, the first one that mirrors it
    mirrored = {
        high: low for high, low in reversed(pairs) if likeness(means[high], means[low]) < -ALIKE
    }
    unit = vertical_words()[1]
    return [
        GeosurfWarning(
            "sign",
            horizons[high].name,
            f"Horizon {horizons[high].name!r} looks like depths taken for elevations: it lies at "
            f"{_middle(horizons[high]):.0f} {unit}, {horizons[low].name!r} at "
            f"{_middle(horizons[low]):.0f} {unit}, with the same shape upside down.",
            "If so, state positive='down' for it: gs.read_horizon(file, positive='down'), or in "
            "[[horizons]] of a scenario.",
        )
        for high, low in sorted(mirrored.items())
    ]


def _middle(horizon: TriSurface) -> float:
    return sum(horizon.bounds[4:]) / 2


def _means(
    horizons: Sequence[TriSurface], pairs: Iterable[tuple[int, int]]
) -> dict[int, np.ndarray]:
    """Mean z in the cells of one frame of all horizons of the pairs, by row."""
    points = {
        row: horizons[row].vertices for row in sorted({row for pair in pairs for row in pair})
    }
    frame = frame_around(list(points.values())) if points else (0, 0, 1, 1)
    return {row: cell_means(one, frame) for row, one in points.items()}


def _looks_like_feet(deep: TriSurface, other: TriSurface, ratio: float) -> GeosurfWarning:
    middle, level = _middle(deep), _middle(other)
    return GeosurfWarning(
        "feet",
        deep.name,
        f"Horizon {deep.name!r} looks like feet taken for metres: it is at {middle:.0f} m, "
        f"{other.name!r} at {level:.0f} m, with the same shape and {ratio:.1f} times the relief.",
        "If so, state length_unit='ft' for it: gs.read_horizon(file, length_unit='ft'), or in "
        "[[horizons]] of a scenario.",
    )


def _listed_triangles(fault: TriSurface) -> np.ndarray:
    """Coordinates of all triangles (n, 9): corners in order, then triangles in order."""
    points, row = np.unique(fault.vertices, axis=0, return_inverse=True)
    rows = np.sort(row.reshape(-1)[fault.triangles], axis=1)
    rows = rows[np.lexsort(rows.T)]
    triangles: np.ndarray = points[rows].reshape(-1, 9)
    return triangles


def _warning(first: str, second: str) -> GeosurfWarning:
    return GeosurfWarning(
        "same fault",
        second,
        f"Faults {first!r} and {second!r} have the same triangles: blocks next to them have "
        "both names, and tables have the fault twice.",
        f"Leave {second!r} out, or read it from its own file.",
    )


def warnings_of_topology(
    before: Units, after: Units, zones: tuple[str, ...], made: Sequence[bool]
) -> list[GeosurfWarning]:
    """Return a warning of the units that a model and the converted one do not share, in zones.

    `made` says of each horizon of the converted one whether a zone from thickness made it: its
    zones are parts of one zone of the model before.
    """
    whole = [k - sum(made[:k]) for k in range(len(made) + 1)]
    known = (
        grouped(((unit.zone_index, unit.block), unit) for unit in before.without_slivers),
        grouped(((whole[unit.zone_index], unit.block), unit) for unit in after.without_slivers),
    )
    wanted = {whole[unit.zone_index] for unit in after.without_slivers if unit.zone in zones}
    keys = [key for key in known[0].keys() ^ known[1].keys() if key[0] in wanted]
    if not keys:
        return []
    parts = [unit for key in keys for unit in known[1].get(key, ())]
    units = [unit for key in keys for of in known for unit in of.get(key, ())]
    differ = sorted({f"{unit.zone} {unit.block}" for unit in units})
    words = (
        f"The model in depth has not the units of the one in time: they differ in "
        f"{known_names(differ)} In depth these are {counted(len(parts), 'unit')} of "
        f"{volume_text(sum(unit.volume for unit in parts))}."
    )
    remedy = "Compare scene.units with scene.in_time().units; look at the faults that they name."
    return [GeosurfWarning("depth", "units", words, remedy)]
