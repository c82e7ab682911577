"""Warnings about the inputs of a scene that look wrong."""

from __future__ import annotations

from collections.abc import Hashable, Iterable

import numpy as np

from geosurf.conventions.crs import warn_of_unclear_crs
from geosurf.errors import GeosurfWarning
from geosurf.faults.rules import Rule
from geosurf.model import Sheet, TriSurface
from geosurf.model.tops import Tops
from geosurf.scene.inputs import SceneInputs
from geosurf.scene.memory import Memory
from geosurf.scene.reference_systems import refuse_other_systems
from geosurf.scene.surfaces import InputSurfaces
from geosurf.scene.wells import warnings_of_names


def warn_of_inputs(
    inputs: SceneInputs, memory: Memory, read: InputSurfaces, tops: Tops | None
) -> None:
    """Warn of reference systems, names of tops and torn horizons that look wrong.

    Parameters
    ----------
    inputs : SceneInputs
    memory : Memory
        Keeps the warnings.
    read : InputSurfaces
        All surfaces have been read.
    tops : Tops or None
    """
    # a reference system that some inputs declare, and others do not
    with memory.collecting():
        known = {name: read.crs[name] for name in inputs.names if name in read.crs}
        warn_of_unclear_crs(refuse_other_systems(known, inputs.crs, tops, inputs.aoi))

    # one file under two names
    rules = (*inputs.rules, *inputs.horizon_rules)
    memory.warn(*warnings_of_repeats(map(read.fault, inputs.faults), rules))

    # tops of horizons that the scene does not have
    if tops is not None:
        memory.warn(*warnings_of_names(tops, tuple(inputs.horizons)))

    # what was assumed when a horizon was torn has been issued there; the scene lists it, too. How
    # much longer all horizons made a fault is listed already, where the scene tore them
    whole = {one.subject for one in memory.warnings if one.kind == "fault extended"}
    for horizon in inputs.horizons.values():
        if isinstance(horizon, Sheet):
            for one in horizon.warnings:
                if one.kind != "fault extended" or one.subject not in whole:
                    memory.warn(one, issued=True)


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
    ends: dict[str, list[tuple[str, str]]] = {}
    for rule in rules:
        ends.setdefault(rule.fault, []).append((rule.main, rule.keep))
    found = []
    for fault in faults:
        # few faults have the same number of triangles and the same bounds: only these are compared
        end = tuple(sorted(ends.get(fault.name, [])))
        key = fault.n_triangle, np.asarray(fault.bounds).tobytes(), end
        alike = first.setdefault(key, [])
        same = [one for one in alike if np.array_equal(_triangles(one), _triangles(fault))]
        if same:
            found.append(_warning(same[0].name, fault.name))
        alike.append(fault)
    return found


def _triangles(fault: TriSurface) -> np.ndarray:
    """Coordinates of all triangles (n, 9): corners in order, then triangles in order."""
    points, row = np.unique(fault.vertices, axis=0, return_inverse=True)
    rows = np.sort(row.reshape(-1)[fault.triangles], axis=1)
    rows = rows[np.lexsort(rows.T)]
    triangles: np.ndarray = points[rows].reshape(-1, 9)
    return triangles


def _warning(one: str, other: str) -> GeosurfWarning:
    return GeosurfWarning(
        "same fault",
        other,
        f"Faults {one!r} and {other!r} have the same triangles: blocks next to them have "
        "both names, and tables have the fault twice.",
        f"Leave {other!r} out, or read it from its own file.",
    )
