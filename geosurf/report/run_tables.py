"""Tables of a run: warnings, certificate, counts of each stage, versions of packages."""

from __future__ import annotations

import importlib.metadata
import platform
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeosurfWarning
from geosurf.model import Certificate
from geosurf.report.page import NOTHING, Table, number

PACKAGES = ("geosurf", "numpy", "numba", "xarray", "pyvista", "vtk")

# what the counts of the stages mean, as the page prints them
COUNTS = {
    "nodes": "grid nodes searched",
    "candidate_faces": "candidate triangles",
    "pairs_tested": "triangle pairs tested",
    "exact_pairs": "pairs of surfaces with exact curves instead of smooth ones",
    "cut_triangles": "input triangles cut",
    "children": "triangles made by cutting",
    "constructed_points": "new vertices",
    "rounding_collisions": "vertices merged by rounding",
    "moved_vertices": "vertices moved to keep triangles valid",
    "largest_move": "largest move [m]",
    "dropped_area": "area removed beyond faults [m²]",
    "slits": "area of faults that end inside a unit [m²]",
}


def warning_table(warnings: Iterable[GeosurfWarning]) -> Table:
    """Return the warnings: subject, effect, location where the effect does not name it, remedy."""
    rows = []
    for warning in warnings:
        where = "" if warning.place is None else place(warning.place)
        told = "" if where in warning.effect else _unbroken(where)
        rows.append((warning.subject, _unbroken(warning.effect), told, warning.remedy))
    head, used = ("Subject", "Effect", "Location", "Remedy"), [0, 1, 2, 3]
    if not any(told for _, _, told, _ in rows):
        used.remove(2)
    cells = tuple(tuple(row[k] for k in used) for row in rows)
    return Table(tuple(head[k] for k in used), cells, n_label=len(used))


def _unbroken(words: str) -> str:
    """Numbers whose groups of digits stay on one line."""
    return re.sub(r"(?<=\d) (?=\d{3}\b)", "\N{NARROW NO-BREAK SPACE}", words)


def check_table(certificate: Certificate) -> Table:
    """Return the certificate: one row per check."""
    rows = tuple(
        ("passed" if check.passed else "FAILED", check.name, check.detail, f"{check.value:.6g}")
        for check in certificate.checks
    )
    return Table(("", "Check", "Result", "Value"), rows, n_label=3)


def count_table(*parts: tuple[str, Mapping[str, Any]]) -> Table:
    """Return the counts that each stage reported."""
    rows = tuple(
        (stage, COUNTS.get(key, str(key).replace("_", " ")), _plain(value))
        for stage, counts in parts
        for key, value in counts.items()
    )
    return Table(("Stage", "Quantity", "Value"), rows, n_label=3)


def _plain(value: Any) -> str:
    """One value as text: integers grouped by thousands, long lists as their length."""
    # bool before int: True is an int in Python
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (int, np.integer)):
        return number(int(value))

    # six digits: counts of area come from sums whose last digits mean nothing to a reader
    if isinstance(value, (float, np.floating)):
        return f"{float(value):.6g}".replace("-", "\N{MINUS SIGN}")
    if isinstance(value, (str, type(None))):
        return value or NOTHING
    if isinstance(value, Mapping):
        return "; ".join(f"{key}: {_plain(entry)}" for key, entry in value.items()) or NOTHING

    # numpy arrays, tuples and sets; anything else prints as itself
    try:
        entries = list(value)
    except TypeError:
        return str(value)

    # the page has no room for lists with thousands of rows
    if len(entries) > 8:
        return f"{number(len(entries))} entries"
    return ", ".join(map(_plain, entries)) or NOTHING


def version_table() -> Table:
    """Return the versions of Python and of the packages that computed the model."""
    rows = [("Python", platform.python_version())]
    for package in PACKAGES:
        # extras such as pyvista may be absent; the page says so instead of failing
        try:
            rows.append((package, importlib.metadata.version(package)))
        except importlib.metadata.PackageNotFoundError:
            rows.append((package, "not installed"))
    return Table(("Package", "Version"), tuple(rows), n_label=2)
