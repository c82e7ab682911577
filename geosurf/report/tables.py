"""Tables of a model: surfaces, volumes, fluid contacts, clipped horizons, intersection lines."""

from __future__ import annotations

import hashlib
import importlib.metadata
import math
import os
import platform
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted, grouped, place
from geosurf.errors import GeosurfWarning
from geosurf.lazy import xarray
from geosurf.model import (
    Certificate,
    Clipped,
    Curves,
    Extension,
    Remnant,
    SheetReport,
    TriSurface,
    Truncation,
    Units,
)
from geosurf.model.column import VirtualWall
from geosurf.model.expected import expect, path_of
from geosurf.model.protocols import ReportedModel
from geosurf.model.regions import MergedSliver
from geosurf.model.units import INTERVALS
from geosurf.report.page import NOTHING, Table, number

# ---- fault tables ----------------------------------------
# Tables of faults: extension and truncation, juxtaposition, fault polygons, throw and heave.


def fault_tables(actions: Iterable[Extension | Truncation]) -> tuple[Table, Table]:
    """Return two tables: how far faults were extended, and what truncation removed."""
    extended, truncated = [], []

    # one pass over the run log of the fault stage, in the order in which it acted; the two kinds of
    # action have different figures
    for a in actions:
        if isinstance(a, Extension):
            numbers = (number(a.shortest, 1), number(a.distance, 1), number(a.area))
            extended.append((a.fault, a.side, a.until, a.lines, *numbers))
        else:
            numbers = (number(a.length, 1), number(a.kept_area), number(a.dropped_area))
            truncated.append((a.fault, a.main, f"{a.keep} ({a.side})", *numbers))
    head = ("Fault", "Side", "Extended to", "Method", "Min [m]", "Max [m]", "Area added [m²]")
    cut = (
        "Fault",
        "Ends at",
        "Part kept",
        "Contact line [m]",
        "Area kept [m²]",
        "Area removed [m²]",
    )
    return Table(head, tuple(extended), n_label=4), Table(cut, tuple(truncated), n_label=3)


def juxtaposition_table(datasets: Iterable[Any]) -> Table:
    """Return the zones juxtaposed across each fault, from datasets of `Scene.juxtaposition`.

    Units of one zone are added up. Pairs of different zones come first, the largest area first.
    """
    rows: list[tuple[str, ...]] = []

    # one dataset per fault [m²]; its rows are pairs of units, so one pair of zones may come several
    # times
    for dataset in datasets:
        labels = (dataset.zone_plus, dataset.zone_minus, dataset.kind)
        keys = zip(*(label.values.astype(str).tolist() for label in labels), strict=True)
        areas = grouped(zip(keys, dataset.area.values.tolist(), strict=True))
        sums = {key: sum(of) for key, of in areas.items()}

        # a share of the fault's area inside the model: all pairs of one fault add up to 100 %
        whole = float(dataset.attrs["area"])

        # False sorts before True: contacts of different zones, through which fluids may pass, lead
        for key, area in sorted(
            sums.items(), key=lambda item: (item[0][0] == item[0][1], -item[1])
        ):
            share = f"{number(100.0 * area / whole, 1)} %"
            rows.append((str(dataset.attrs["fault"]), *key, number(area), share))
    head = ("Fault", "Hanging wall", "Footwall", "Kind", "Area [m²]", "Share of fault")
    return Table(head, tuple(rows), n_label=4)


def polygon_table(datasets: Iterable[Any]) -> Table:
    """Return the fault polygons of each horizon, from datasets of `Scene.fault_polygons`."""
    rows = []
    for dataset in datasets:
        columns = (dataset.fault, dataset.part, dataset.kind, dataset["count"], dataset.map_area)
        for fault, part, kind, n, area in zip(*(c.values for c in columns), strict=True):
            name = str(dataset.attrs["horizon"])
            numbers = (number(int(part)), number(int(n)), number(float(area), 1))
            rows.append((name, str(fault), str(kind), *numbers))
    head = ("Horizon", "Fault", "Kind", "Part", "Points", "Map area [m²]")
    return Table(head, tuple(rows), n_label=3)


def sheet_table(sheets: Mapping[str, Any]) -> Table:
    """Return throw and heave of torn horizons at each fault, from torn sheets by name."""
    rows = []
    for name, sheet in sheets.items():
        for cut in sheet.cuts.values():
            # throw is NaN at stations where a wall has no cut-off
            known = np.isfinite(cut.throw)
            if not known.any():
                rows.append((name, cut.fault, ", ".join(cut.ends), *([NOTHING] * 4)))
                continue

            # heave is signed (negative where the walls overlap, as at a reverse fault); the table
            # shows the larger opening or overlap
            throw, heave = cut.throw[known], cut.heave[known]
            values = (cut.along[known].max(), throw.min(), throw.max(), np.abs(heave).max())
            rows.append((name, cut.fault, ", ".join(cut.ends), *(number(v, 1) for v in values)))
    head = ("Horizon", "Fault", "Ends", "Length [m]", "Min throw [m]", "Max throw [m]")
    return Table((*head, "Max heave [m]"), tuple(rows), n_label=3)


def throw_in_words(sheets: Mapping[str, Any]) -> tuple[bool, str]:
    """Return whether torn horizons have the throw that their data show, and a sentence or ''."""
    audits = {
        (name, fault): audit
        for name, sheet in sheets.items()
        if isinstance(sheet.report, SheetReport)
        for fault, audit in sheet.report.throw.items()
        if np.isfinite(audit.data).any()
    }
    if not audits:
        return True, ""
    differ = [f"{fault} at {name}" for (name, fault), one in audits.items() if one.differs.any()]
    if not differ:
        return (
            True,
            f"As the data show: throw within its spread at {counted(len(audits), 'cut-off')}",
        )
    return False, (
        f"NOT as the data show: the throw of {', '.join(differ)} differs by more than its spread, "
        f"{len(differ)} of {len(audits)}: see the warnings"
    )


# ---- well tables ----------------------------------------
# Tables of well tops: the misfit of each, and of each horizon on average.


REMARKS = {
    "found": "",
    "several": "repeated by a reverse fault; the nearest",
    "fault gap": "in the gap of a fault",
    "absent": "the horizon does not exist there",
    "outside": "outside the model",
    "unknown horizon": "no horizon of this name",
}


def misfit_table(misfit: xarray.Dataset) -> Table:
    """Return well tops and the model: one row per top."""
    rows = []
    columns = ("horizon", "well", "picked", "model", "misfit", "block", "status", "fault")
    for row in zip(*(misfit[name].values for name in columns), strict=True):
        horizon, well, picked, model, off, block, status, fault = row

        # an unknown status prints as it is: a table never fails on a word
        remark = REMARKS.get(status, str(status))

        # a fault explains more than the status: it is named
        if fault:
            across = f"fault {fault} between top and horizon"
            remark = f"in the gap of fault {fault}" if status == "fault gap" else across
        values = (_metres(value) for value in (picked, model, off))
        rows.append((str(horizon), str(well), *values, str(block) or NOTHING, remark))
    head = ("Horizon", "Well", "Top [m]", "Model [m]", "Misfit [m]", "Block", "Remark")
    return Table(head, tuple(rows), n_label=2, n_remark=2)


def misfit_words(misfit: xarray.Dataset) -> list[str]:
    """Return a sentence on the misfit of each horizon."""
    sentences = []
    names = misfit["horizon"].values

    # in the order of the tops, which is that of the user's file
    for name in dict.fromkeys(names.tolist()):
        off = misfit["misfit"].values[names == name]

        # NaN where the horizon has no value at a top: those are listed, not averaged
        off = off[np.isfinite(off)]
        if len(off):
            sentences.append(
                f"{name}: mean misfit {_metres(off.mean())} m, standard deviation "
                f"{_metres(off.std())} m, largest {_metres(np.abs(off).max())} m at "
                f"{counted(len(off), 'top')}. Misfit is model minus top."
            )
    return sentences


def _metres(value: float) -> str:
    return number(float(value), 2) if np.isfinite(value) else NOTHING


# ---- run tables ----------------------------------------
# Tables of a run: warnings, certificate, counts of each stage, versions of packages.


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
        location = "" if where in warning.effect else _unbroken(where)
        rows.append((warning.subject, _unbroken(warning.effect), location, warning.remedy))
    head, used = ("Subject", "Effect", "Location", "Remedy"), [0, 1, 2, 3]
    if not any(location for _, _, location, _ in rows):
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


# ---- input tables ----------------------------------------
# Tables of inputs: the files, their sizes and hashes.


DIGITS = 16  # of a hash: enough to tell files apart
HOW = "give {name: path of a file}"


@dataclass(frozen=True)
class InputFile:
    """A file that a model was made of: its path as printed, and its bytes.

    Attributes
    ----------
    name, path : str
    size : int or None
        [bytes]; None where the file is no longer there.
    digest : str
        SHA-256, hexadecimal.
    """

    name: str
    path: str
    size: int | None
    digest: str


def described_files(
    inputs: Mapping[str, Any], relative_to: str | os.PathLike[str] | None
) -> tuple[InputFile, ...]:
    """Return files by name, hashed.

    Parameters
    ----------
    inputs : mapping of str to path-like
    relative_to : path-like, optional
        Folder that printed paths start from. Default: the current folder.

    Returns
    -------
    tuple of InputFile

    Examples
    --------
    >>> described_files({"Top": "missing.gri"}, None)[0].size is None
    True
    """
    expect(inputs, Mapping, "inputs takes a mapping", HOW)
    start = Path.cwd() if relative_to is None else path_of(relative_to, "relative_to")
    files = {str(name): path_of(path, f"input {name!r}") for name, path in inputs.items()}
    return tuple(_described(name, path, start) for name, path in files.items())


def _described(name: str, path: Path, start: Path) -> InputFile:
    """One file: what cannot be read any more is listed without size and hash."""
    try:
        shown = Path(os.path.relpath(path, start)).as_posix()
    except ValueError:  # another drive: there is no way from one to the other
        shown = path.name
    try:
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        return InputFile(name, shown, path.stat().st_size, digest)
    except OSError:
        return InputFile(name, shown, None, "")


def file_table(files: Iterable[InputFile], crs: str) -> Table:
    """Return the files: name, path, size, hash and coordinate reference system.

    Examples
    --------
    >>> file_table([InputFile("Top", "top.gri", 12, "ab" * 32)], "").rows
    (('Top', 'top.gri', 'abababababababab', '–', '12'),)
    """
    rows = tuple(
        (
            file.name,
            file.path,
            file.digest[:DIGITS] or "not found",
            crs or NOTHING,
            NOTHING if file.size is None else number(file.size),
        )
        for file in files
    )
    head = ("Input", "File", f"SHA-256, first {DIGITS} digits", "CRS", "Size [bytes]")
    return Table(head, rows, n_label=4)


ELSEWHERE = "no region"  # the column of what lies above and below


def surface_table(surfaces: Iterable[TriSurface], coverage: Mapping[str, float]) -> Table:
    """Return the input surfaces: name, role, share inside, number of triangles, extent [m]."""
    rows = []
    for surface in surfaces:
        # a surface without triangles has no extent; its bounds would be infinite
        bounds = (
            [number(value, 1) for value in surface.bounds] if surface.n_triangle else [NOTHING] * 6
        )
        inside = f"{100 * coverage[surface.name]:.0f}"
        rows.append((surface.name, surface.role, inside, number(surface.n_triangle), *bounds))
    head = (
        "Surface",
        "Role",
        "Inside [%]",
        "Triangles",
        "West",
        "East",
        "South",
        "North",
        "Bottom",
        "Top",
    )
    return Table(head, tuple(rows), n_label=2)


def volume_table(units: Units, include: str = "reservoir") -> Table:
    """Return volumes [million m3]: one row per zone and contact interval, one column per region.

    Of the reservoir, or of all units. Units that know no regions have one column per block.
    """
    part = units.included(include)
    # the row of a zone is split where contacts split it: 'Top/Base, above OWC'
    each = list(part.values())
    names = [", ".join(filter(None, (unit.zone, unit.contact))) for unit in each]

    # zone by zone from the top down, and so from above its contacts to below them
    rank = {
        name: (unit.zone_index, INTERVALS.get(unit.contact.partition(" ")[0], 0))
        for name, unit in zip(names, each, strict=True)
    }
    zones = sorted(rank, key=rank.__getitem__)
    regions = units.regions
    columns = [unit.region or (ELSEWHERE if regions else unit.block) for unit in each]
    blocks = [name for name in (*regions, ELSEWHERE) if name in columns] or _in_order(columns)
    # One cell per zone and block; several units may share it [million m³].
    volume = np.zeros((len(zones), len(blocks)))
    held = np.zeros(volume.shape, dtype=bool)
    for zone, block, unit in zip(names, columns, each, strict=True):
        cell = zones.index(zone), blocks.index(block)
        volume[cell] += unit.volume / 1e6
        held[cell] = True

    rows = tuple(
        (
            # a dash where no unit is: 0.000 would claim that a thin one was found
            zone,
            *(number(v, 3) if h else NOTHING for v, h in zip(volume[i], held[i], strict=True)),
            number(volume[i].sum(), 3),
        )
        for i, zone in enumerate(zones)
    )

    # columns may add up to less than the last cell by rounding of what is printed, never of what is
    # added
    sums = [number(value, 3) for value in volume.sum(axis=0)]
    foot = ("all zones" if part is units else "reservoir", *sums, number(part.volume / 1e6, 3))
    every = "all regions" if regions else "all blocks"
    return Table(("Zone", *blocks, every), rows, foot=foot)


def _in_order(words: Iterable[Any]) -> list[str]:
    """The distinct words, in order of first appearance."""
    return list(dict.fromkeys(str(word) for word in words))


def contact_table(scene: ReportedModel) -> Table:
    """Return the fluid contacts: their elevation, and the zones and blocks they apply to."""
    rows = []
    for contact in scene.contacts:
        (source,) = (
            s for s in scene.patches.sources if s.role == "contact" and s.name == contact.surface
        )
        levels = dict.fromkeys(number(z, 1) for z in source.bounds[4:])
        zones = ", ".join(contact.zones or scene.units.reservoir)
        rows.append((contact.name, zones, contact.block or "all", " to ".join(levels)))
    return Table(("Contact", "Zones", "Block", "Elevation [m]"), tuple(rows), n_label=3)


def left_out_table(units: Units) -> Table:
    """Return the units that no contact covers because it is given for other blocks."""
    left = units.report.get("without_contact", {})
    return Table(
        ("Contact", "Units"), tuple((n, ", ".join(of)) for n, of in left.items()), n_label=2
    )


def clipped_table(clipped: Iterable[Clipped]) -> Table:
    """Return the parts of horizons that the stratigraphic column removed: area, volume, place."""
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
    head = (
        "Horizon",
        "Clipped by",
        "Rule",
        "Area [km²]",
        "Volume [million m³]",
        "Max thickness [m]",
    )
    largest = ("Largest at: easting", "northing", "elevation")
    return Table((*head, "Places", *largest), rows, n_label=3)


def remnant_table(remnants: Iterable[Remnant], digits: str = "") -> Table:
    """Return slivers, detached pieces and thin units, with the centre of their bounds [m]."""
    rows = []
    for one in remnants:
        volume = format(one.volume, digits) if digits else number(one.volume, 1)
        rows.append((one.name, volume, *(number(v, 1) for v in one.place)))
    return Table(("Unit", "Volume [m³]", "Easting", "Northing", "Elevation"), tuple(rows))


def merged_table(merged: Iterable[MergedSliver]) -> Table:
    """Return slivers that are parts of other units now, with the surfaces between."""
    rows = tuple(
        (one.name, one.into, ", ".join(one.across), number(one.volume, 1), number(one.area, 1),
         *(number(value, 1) for value in one.place))
        for one in merged
    )  # fmt: skip
    head = ("Sliver", "Part of", "Across", "Volume [m³]", "Shared area [m²]")
    return Table((*head, "Easting", "Northing", "Elevation"), rows, n_label=3)


def virtual_table(walls: Iterable[VirtualWall]) -> Table:
    """Return the virtual walls of compartments: what each end of a fault is joined to."""
    rows = tuple(
        (wall.fault, wall.side, f"{wall.target} {wall.facing}".strip(), number(wall.length, 0),
         number(wall.area / 1e6, 3), *(number(value, 1) for value in wall.place))
        for wall in walls
    )  # fmt: skip
    head = ("Fault", "Side", "Joined to", "Length [m]", "Area [km²]")
    return Table((*head, "Easting", "Northing", "Elevation"), rows, n_label=3)


def compartment_table(units: Units, include: str = "reservoir") -> Table:
    """Return the compartments of each block, with their volumes in the reservoir [million m³]."""
    volumes = grouped(
        ((unit.compartment_of, unit.block), unit.volume / 1e6)
        for unit in units.included(include).values()
        if unit.compartment_of not in ("", unit.block)
    )
    rows = tuple((*key, number(sum(of), 3)) for key, of in sorted(volumes.items()))
    return Table(("Block", "Compartment", "GRV [million m³]"), rows, n_label=2)


def region_table(units: Units, regions: Mapping[str, tuple[float, str]]) -> Table:
    """Return volumes of another program next to the volumes of the units at the same location.

    Units without a region follow. The table shows the difference and does not judge it.
    """
    rows = []
    for region, (volume, name) in sorted(regions.items(), key=lambda item: -item[1][0]):
        if name not in units:
            rows.append((region, NOTHING, number(volume, 3), NOTHING, NOTHING))
            continue
        volume_of_unit = units[name].volume

        # no verdict: other programs draw zones through cells, so small differences are theirs
        off = f"{abs(volume_of_unit - volume) / volume:.1e}" if volume else NOTHING
        rows.append((region, name, number(volume, 3), number(volume_of_unit, 3), off))
    named = {name for _, name in regions.values()}
    if regions:
        left = [unit for unit in units.values() if unit.name not in named]
        rows += [(NOTHING, u.name, NOTHING, number(u.volume, 3), NOTHING) for u in left]
    head = ("Region", "Unit", "Region [m³]", "Unit [m³]", "Relative difference")
    return Table(head, tuple(rows), n_label=2)


def balance(units: Units) -> str:
    """Return the sum of the volumes and the volume of the model box, as text."""
    total, box = units.volume, units.box_volume
    if box == 0.0:
        return "The model box is empty."
    off = abs(total - box) / box
    return (
        f"Sum of all units: {number(total / 1e6, 3)} million m³. Model box: "
        f"{number(box / 1e6, 3)} million m³. Relative difference: {off:.2g}."
    )


def accuracy(scene: ReportedModel) -> list[str]:
    """Return what horizons with fewer nodes do to volumes."""
    sentences = []
    if math.isinf(scene.volume_error_bound):
        sentences.append(
            "Torn horizons have fewer nodes than their grids. What that does to volumes near "
            "faults is not known: compare them with those of a smaller tolerance."
        )
    elif scene.volume_error_bound > 0.0:
        bound = number(scene.volume_error_bound / 1e6, 3)
        off = max(map(_largest_error, map(scene.surface, scene.horizon_names)))
        sentences.append(
            f"Horizons have fewer nodes than their grids, and are at most {off:.2g} m off. That "
            "changes the volume of any unit, or of several units together, by at most "
            f"{bound} million m³."
        )
    return sentences


def _largest_error(horizon: TriSurface) -> float:
    """The largest vertical distance of a horizon from all nodes of its grid [m]."""
    errors = horizon.vertex_data.get("vertical_error")
    return 0.0 if errors is None else float(errors.max(initial=0.0))


def curve_table(curves: Curves) -> Table:
    """Return the intersection lines of each pair of surfaces: number, closed lines, length."""
    pairs = ((curves.names[i], curves.names[j]) for i, j in curves.surfaces_of_curve.tolist())
    lines = zip(map(bool, curves.closed), map(float, curves.length_of_curve), strict=True)
    rows = []
    for pair, of_pair in grouped(zip(pairs, lines, strict=True)).items():
        closed, lengths = zip(*of_pair, strict=True)
        numbers = number(len(of_pair)), number(sum(closed)), number(sum(lengths) / 1000.0, 1)
        rows.append((*pair, *numbers))
    head = ("Surface", "Other surface", "Lines", "Closed", "Length [km]")
    return Table(head, tuple(rows), n_label=2)
