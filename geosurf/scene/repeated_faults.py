"""Faults that are given twice under two names."""

from __future__ import annotations

from collections.abc import Hashable, Iterable

import numpy as np

from geosurf.errors import GeosurfWarning
from geosurf.faults.rules import Rule
from geosurf.model import TriSurface


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


__all__ = ["warnings_of_repeats"]
