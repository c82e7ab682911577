"""A scene as tables: rows of words, nothing of HTML."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeosurfWarning
from geosurf.model import (
    Certificate,
    Clipped,
    Curves,
    Extension,
    Remnant,
    TriSurface,
    Truncation,
    Units,
)

NOTHING = "–"
UNIT_OF = {"dropped_area": " [m²]", "slits": " [m²]", "largest_move": " [m]"}
PACKAGES = ("geosurf", "numpy", "numba", "xarray", "pyvista", "vtk")


@dataclass(frozen=True)
class Table:
    """Words in rows under a head.

    Attributes
    ----------
    head : tuple of str
    rows : tuple of tuple of str
    n_label : int
        Leading columns that hold words; the others hold numbers.
    foot : tuple of str
        A last row of sums, or nothing.
    n_remark : int
        Columns at the end that hold words, too.
    """

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    n_label: int = 1
    foot: tuple[str, ...] = ()
    n_remark: int = 0

    def holds_words(self, column: int) -> bool:
        """Whether a column holds words, which start at its left and may fill several lines."""
        return column < self.n_label or column >= len(self.head) - self.n_remark


def number(value: float, decimals: int = 0) -> str:
    r"""Return a number with a true minus and thin spaces between thousands.

    Examples
    --------
    >>> number(-1234567.891, 1).replace("\N{NARROW NO-BREAK SPACE}", " ")
    '−1 234 567.9'
    """
    text = f"{value + 0.0:,.{decimals}f}"
    return text.replace(",", "\N{NARROW NO-BREAK SPACE}").replace("-", "\N{MINUS SIGN}")


def as_plain_text(table: Table, corner: str) -> str:
    """Return a table in plain letters and even columns, numbers at the right.

    Parameters
    ----------
    table : Table
        With one column of words.
    corner : str
        What stands above them.

    Returns
    -------
    str

    Examples
    --------
    >>> print(as_plain_text(Table(("", "F1+", "F1-"), (("Top/Base", "8.5", NOTHING),)), "Zone"))
    Zone      F1+  F1-
    Top/Base  8.5    -
    """
    plain = str.maketrans({"\N{NARROW NO-BREAK SPACE}": " ", "\N{MINUS SIGN}": "-", NOTHING: "-"})
    body = [[cell.translate(plain) for cell in row] for row in (*table.rows, table.foot) if row]
    rows = [[corner, *table.head[1:]], *body]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for label, *numbers in rows:
        cells = [cell.rjust(w) for cell, w in zip(numbers, widths[1:], strict=True)]
        lines.append("  ".join([label.ljust(widths[0]), *cells]))
    return "\n".join(lines)


def surface_table(surfaces: Iterable[TriSurface]) -> Table:
    """Return what was handed in: name, role, triangles, bounds [m]."""
    rows = []
    for surface in surfaces:
        bounds = (
            [number(value, 1) for value in surface.bounds] if surface.n_triangle else [NOTHING] * 6
        )
        rows.append((surface.name, surface.role, number(surface.n_triangle), *bounds))
    head = ("Surface", "Role", "Triangles", "West", "East", "South", "North", "Bottom", "Top")
    return Table(head, tuple(rows), n_label=2)


def fault_tables(actions: Iterable[Extension | Truncation]) -> tuple[Table, Table]:
    """Return how far faults were extended, and what they lost by ending at others."""
    extended, truncated = [], []
    for a in actions:
        if isinstance(a, Extension):
            numbers = (number(a.shortest, 1), number(a.distance, 1), number(a.area))
            extended.append((a.fault, a.side, a.until, a.lines, *numbers))
        else:
            numbers = (number(a.length, 1), number(a.kept_area), number(a.dropped_area))
            truncated.append((a.fault, a.main, f"{a.keep} ({a.side})", *numbers))
    head = ("Fault", "extended at", "to", "lines", "Least [m]", "Most [m]", "Added [m²]")
    cut = ("Fault", "ends at", "keeps", "Line [m]", "Kept [m²]", "Dropped [m²]")
    return Table(head, tuple(extended), n_label=4), Table(cut, tuple(truncated), n_label=3)


def volume_table(units: Units) -> Table:
    """Return volumes [million m3]: zones (by fluid contact) down, blocks across, with sums."""
    table = units.table
    names: Iterable[str] = table["zone"].values
    if "contact" in table.coords:
        pairs = zip(names, table["contact"].values, strict=True)
        names = [", ".join(word for word in pair if word) for pair in pairs]
    zones = _in_order(names)
    blocks = _in_order(table["block"].values)
    volume = np.zeros((len(zones), len(blocks)))
    held = np.zeros(volume.shape, dtype=bool)
    for zone, block, value in zip(
        names, table["block"].values, table["volume"].values, strict=True
    ):
        cell = zones.index(zone), blocks.index(block)
        volume[cell] += value / 1e6
        held[cell] = True
    rows = tuple(
        (
            zone,
            *(number(v, 3) if h else NOTHING for v, h in zip(volume[i], held[i], strict=True)),
            number(volume[i].sum(), 3),
        )
        for i, zone in enumerate(zones)
    )
    sums = [number(value, 3) for value in volume.sum(axis=0)]
    foot = ("all zones", *sums, number(units.volume / 1e6, 3))
    return Table(("Zone", *blocks, "all blocks"), rows, foot=foot)


def _in_order(words: Iterable[Any]) -> list[str]:
    """The different words, in the order in which they come."""
    return list(dict.fromkeys(str(word) for word in words))


def contact_table(scene: Any) -> Table:
    """Return the fluid contacts: where they are, and in which zones and blocks they count."""
    rows = []
    for contact in getattr(scene, "contacts", ()):
        (source,) = (
            s for s in scene.patches.sources if s.role == "contact" and s.name == contact.surface
        )
        levels = dict.fromkeys(number(z, 1) for z in source.bounds[4:])
        zones = ", ".join(contact.zones) or "all"
        rows.append((contact.name, zones, contact.block or "all", " to ".join(levels)))
    return Table(("Contact", "Zones", "Block", "Elevation [m]"), tuple(rows), n_label=3)


def left_out_table(units: Units) -> Table:
    """Return the units that fluid contacts do not reach: they are given for other blocks."""
    left = units.report.get("without_contact", {})
    return Table(
        ("Contact", "Units"), tuple((n, ", ".join(of)) for n, of in left.items()), n_label=2
    )


def clipped_table(clipped: Iterable[Clipped]) -> Table:
    """Return what the column took away of horizons that cross: how much, and where."""
    rows = tuple(
        (
            clip.horizon,
            clip.by,
            clip.rule,
            number(clip.area / 1e6, 4),
            number(clip.volume / 1e6, 4),
            number(clip.thickness, 2),
            number(len(clip.places)),
            *(number(value, 1) for value in clip.place),
        )
        for clip in clipped
    )
    head = ("Horizon", "ends on", "Rule", "Area [km²]", "Volume [million m³]", "At most [m]")
    return Table((*head, "Places", "there: easting", "northing", "elevation"), rows, n_label=3)


def remnant_table(remnants: Iterable[Remnant]) -> Table:
    """Return pockets and small units, with the middle of their bounds [m]."""
    rows = tuple(
        (remnant.name, number(remnant.volume, 1), *(number(v, 1) for v in remnant.place))
        for remnant in remnants
    )
    return Table(("Unit", "Volume [m³]", "Easting", "Northing", "Elevation"), rows)


def thin_table(thin: Iterable[Remnant]) -> Table:
    """Return units that are as thin as the rounding of their corners, with their places [m]."""
    rows = tuple(
        (unit.name, f"{unit.volume:.1e}", *(number(v, 1) for v in unit.place)) for unit in thin
    )
    return Table(("Unit", "Volume [m³]", "Easting", "Northing", "Elevation"), rows)


def juxtaposition_table(found: Iterable[Any]) -> Table:
    """Return what lies across each fault from what: datasets as `Scene.juxtaposition` gives them.

    Zones of several units count as one; the largest contact of different zones comes first.
    """
    rows: list[tuple[str, ...]] = []
    for dataset in found:
        areas: dict[tuple[str, str, str], float] = {}
        columns = (dataset.zone_plus, dataset.zone_minus, dataset.kind, dataset.area)
        for plus, minus, kind, area in zip(*(c.values for c in columns), strict=True):
            key = (str(plus), str(minus), str(kind))
            areas[key] = areas.get(key, 0.0) + float(area)
        whole = float(dataset.attrs["area"])
        for key, area in sorted(
            areas.items(), key=lambda item: (item[0][0] == item[0][1], -item[1])
        ):
            share = f"{number(100.0 * area / whole, 1)} %"
            rows.append((str(dataset.attrs["fault"]), *key, number(area), share))
    head = ("Fault", "Hanging wall", "Footwall", "Kind", "Area [m²]", "of the fault")
    return Table(head, tuple(rows), n_label=4)


def polygon_table(found: Iterable[Any]) -> Table:
    """Return the fault polygons of each horizon: datasets as `Scene.fault_polygons` gives them."""
    rows = []
    for dataset in found:
        columns = (dataset.fault, dataset.part, dataset.kind, dataset["count"], dataset.map_area)
        for fault, part, kind, n, area in zip(*(c.values for c in columns), strict=True):
            name = str(dataset.attrs["horizon"])
            numbers = (number(int(part)), number(int(n)), number(float(area), 1))
            rows.append((name, str(fault), str(kind), *numbers))
    head = ("Horizon", "Fault", "Kind", "Part", "Points", "Map area [m²]")
    return Table(head, tuple(rows), n_label=3)


def sheet_table(sheets: Mapping[str, Any]) -> Table:
    """Return throw and heave of torn horizons at each fault, from sheets by name."""
    rows = []
    for name, sheet in sheets.items():
        for cut in sheet.cuts.values():
            known = np.isfinite(cut.throw)
            if not known.any():
                rows.append((name, cut.fault, ", ".join(cut.ends), *([NOTHING] * 4)))
                continue
            throw, heave = cut.throw[known], cut.heave[known]
            values = (cut.along[known].max(), throw.min(), throw.max(), np.abs(heave).max())
            rows.append((name, cut.fault, ", ".join(cut.ends), *(number(v, 1) for v in values)))
    head = ("Horizon", "torn at", "Ends", "Length [m]", "Least throw [m]", "Most throw [m]")
    return Table((*head, "Most heave [m]"), tuple(rows), n_label=3)


def region_table(units: Units, regions: Mapping[str, tuple[float, str]]) -> Table:
    """Return volumes that somebody else found, each beside the unit that lies there.

    Units without a region follow; nothing is said to be equal, the difference is there to be seen.
    """
    rows = []
    for region, (volume, name) in sorted(regions.items(), key=lambda item: -item[1][0]):
        if name not in units:
            rows.append((region, NOTHING, number(volume, 3), NOTHING, NOTHING))
            continue
        found = units[name].volume
        off = f"{abs(found - volume) / volume:.1e}" if volume else NOTHING
        rows.append((region, name, number(volume, 3), number(found, 3), off))
    named = {name for _, name in regions.values()}
    if regions:
        left = [unit for unit in units.values() if unit.name not in named]
        rows += [(NOTHING, u.name, NOTHING, number(u.volume, 3), NOTHING) for u in left]
    head = ("Region", "Unit there", "Region [m³]", "Unit [m³]", "Relative difference")
    return Table(head, tuple(rows), n_label=2)


def balance(units: Units) -> str:
    """Return how the volumes add up to the model box, in one sentence."""
    total, box = units.volume, units.box_volume
    if box == 0.0:
        return "The model box is empty."
    off = abs(total - box) / box
    return (
        f"The units add up to {number(total / 1e6, 3)} million m³, the model box holds "
        f"{number(box / 1e6, 3)} million m³: a relative difference of {off:.2g}."
    )


def simplified(scene: Any) -> str:
    """Return what a tolerance does to horizons, volumes and curves; nothing without one."""
    tolerance = getattr(scene, "tolerance", None)
    if tolerance is None:
        return ""
    bounds = scene.curves.error_bound
    known = bounds is not None and len(bounds) > 0 and np.isfinite(bounds).all()
    lines = f"{bounds.max():.3g} m" if known else "not known everywhere, see Curves.places"
    return (
        f"Horizons are simplified to {tolerance:g} m: the volume of any unit differs by at most "
        f"{number(scene.volume_error_bound / 1e6, 3)} million m³ from that of all nodes. "
        f"Largest error of a curve: {lines}."
    )


def curve_table(curves: Curves) -> Table:
    """Return the curves of each pair of surfaces that meets: number, closed, length."""
    found: dict[tuple[int, int], list[float]] = {}
    rows_of_pair = zip(
        curves.surfaces_of_curve.tolist(), curves.closed, curves.length_of_curve, strict=True
    )
    for (first, second), closed, length in rows_of_pair:
        entry = found.setdefault((first, second), [0, 0, 0.0])
        entry[0] += 1
        entry[1] += bool(closed)
        entry[2] += float(length)
    rows = tuple(
        (
            curves.names[first],
            curves.names[second],
            number(entry[0]),
            number(entry[1]),
            number(entry[2], 1),
        )
        for (first, second), entry in found.items()
    )
    return Table(("Surface", "meets", "Curves", "of these closed", "Length [m]"), rows, n_label=2)


def warning_table(warnings: Iterable[GeosurfWarning]) -> Table:
    """Return what was assumed, with its effect and what to type instead."""
    rows = tuple(
        (
            warning.subject,
            warning.effect,
            "" if warning.place is None else place(warning.place),
            warning.remedy,
        )
        for warning in warnings
    )
    return Table(("About", "Effect", "Place", "Remedy"), rows, n_label=4)


def check_table(certificate: Certificate) -> Table:
    """Return the certificate, line by line."""
    rows = tuple(
        ("passed" if check.passed else "FAILED", check.name, check.detail, f"{check.value:.6g}")
        for check in certificate.checks
    )
    return Table(("", "Check", "Found", "Value"), rows, n_label=3)


def cost_table(*parts: tuple[str, Mapping[str, Any]]) -> Table:
    """Return counts of what each stage did."""
    rows = tuple(
        (stage, str(key).replace("_", " ") + UNIT_OF.get(key, ""), _plain(value))
        for stage, counts in parts
        for key, value in counts.items()
    )
    return Table(("Stage", "What", ""), rows, n_label=2)


def _plain(value: Any) -> str:
    """One value as words: counts grouped, long lists as their length."""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (int, np.integer)):
        return number(int(value))
    if isinstance(value, (float, np.floating)):
        return f"{float(value):.6g}".replace("-", "\N{MINUS SIGN}")
    if isinstance(value, (str, type(None))):
        return value or NOTHING
    if isinstance(value, Mapping):
        return "; ".join(f"{key}: {_plain(held)}" for key, held in value.items()) or NOTHING
    try:
        held = list(value)
    except TypeError:
        return str(value)
    if len(held) > 8:
        return f"{number(len(held))} entries"
    return ", ".join(_plain(entry) for entry in held) or NOTHING


def version_table() -> Table:
    """Return the versions that made the report."""
    rows = [("Python", platform.python_version())]
    for package in PACKAGES:
        try:
            rows.append((package, importlib.metadata.version(package)))
        except importlib.metadata.PackageNotFoundError:
            rows.append((package, "not installed"))
    return Table(("Package", "Version"), tuple(rows), n_label=2)
