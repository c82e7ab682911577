"""Tables of a model: surfaces, volumes, fluid contacts, clipped horizons, intersection lines."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from geosurf.model import Clipped, Curves, Remnant, TriSurface, Units
from geosurf.model.column import VirtualWall
from geosurf.model.protocols import ReportedModel
from geosurf.model.slivers import MergedSliver
from geosurf.report.page import NOTHING, Table, number

SLIVERS = "slivers"  # the column that they share


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


def volume_table(units: Units) -> Table:
    """Return volumes [million m3]: one row per zone and contact interval, one column per block.

    All slivers share a column of their own.
    """
    table = units.table
    names: Iterable[str] = table["zone"].values
    if "contact" in table.coords:
        pairs = zip(names, table["contact"].values, strict=True)

        # the row of a zone is split where contacts split it: 'Top/Base, above OWC'
        names = [", ".join(word for word in pair if word) for pair in pairs]

    # `Units` goes zone by zone from the top down, so first appearance is the stratigraphic order
    zones = _in_order(names)
    columns = [
        SLIVERS if small else str(block)
        for block, small in zip(table["block"].values, table["sliver"].values, strict=True)
    ]
    blocks = sorted(_in_order(columns), key=lambda word: word == SLIVERS)
    # One cell per zone and block; several units may share it [million m³].
    volume = np.zeros((len(zones), len(blocks)))
    held = np.zeros(volume.shape, dtype=bool)
    for zone, block, value in zip(names, columns, table["volume"].values, strict=True):
        cell = zones.index(zone), blocks.index(block)
        volume[cell] += value / 1e6
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
    foot = ("all zones", *sums, number(units.volume / 1e6, 3))
    return Table(("Zone", *blocks, "all blocks"), rows, foot=foot)


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
        zones = ", ".join(contact.zones) or "all"
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


def remnant_table(remnants: Iterable[Remnant]) -> Table:
    """Return slivers and detached pieces, with the centre of their bounds [m]."""
    rows = tuple(
        (remnant.name, number(remnant.volume, 1), *(number(v, 1) for v in remnant.place))
        for remnant in remnants
    )
    return Table(("Unit", "Volume [m³]", "Easting", "Northing", "Elevation"), rows)


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


def compartment_table(units: Units) -> Table:
    """Return the compartments of each block, with their volumes over all zones [million m³]."""
    volume: dict[tuple[str, str], float] = {}
    for unit in units.values():
        if unit.compartment_of not in ("", unit.block):
            key = (unit.compartment_of, unit.block)
            volume[key] = volume.get(key, 0.0) + unit.volume / 1e6
    rows = tuple((*key, number(value, 3)) for key, value in sorted(volume.items()))
    return Table(("Block", "Compartment", "Volume [million m³]"), rows, n_label=2)


def thin_table(thin: Iterable[Remnant]) -> Table:
    """Return units thinner than the rounding error of their vertices, with their centres [m]."""
    rows = tuple(
        (unit.name, f"{unit.volume:.1e}", *(number(v, 1) for v in unit.place)) for unit in thin
    )
    return Table(("Unit", "Volume [m³]", "Easting", "Northing", "Elevation"), rows)


def region_table(units: Units, regions: Mapping[str, tuple[float, str]]) -> Table:
    """Return volumes of another program next to the volumes of the units at the same location.

    Units without a region follow. The table shows the difference and does not judge it.
    """
    rows = []
    for region, (volume, name) in sorted(regions.items(), key=lambda item: -item[1][0]):
        if name not in units:
            rows.append((region, NOTHING, number(volume, 3), NOTHING, NOTHING))
            continue
        found = units[name].volume

        # no verdict: other programs draw zones through cells, so small differences are theirs
        off = f"{abs(found - volume) / volume:.1e}" if volume else NOTHING
        rows.append((region, name, number(volume, 3), number(found, 3), off))
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
    found = []
    if math.isinf(scene.volume_error_bound):
        found.append(
            "Torn horizons have fewer nodes than their grids. What that does to volumes near "
            "faults is not known: compare them with those of a smaller tolerance."
        )
    elif scene.volume_error_bound > 0.0:
        bound = number(scene.volume_error_bound / 1e6, 3)
        off = max(map(_largest_error, map(scene.surface, scene.horizon_names)))
        found.append(
            f"Horizons have fewer nodes than their grids, and are at most {off:.2g} m off. That "
            "changes the volume of any unit, or of several units together, by at most "
            f"{bound} million m³."
        )
    return found


def _largest_error(horizon: TriSurface) -> float:
    """The largest vertical distance of a horizon from all nodes of its grid [m]."""
    errors = horizon.vertex_data.get("vertical_error")
    return 0.0 if errors is None else float(errors.max(initial=0.0))


def curve_table(curves: Curves) -> Table:
    """Return the intersection lines of each pair of surfaces: number, closed lines, length."""
    found: dict[tuple[int, int], list[float]] = {}
    rows_of_pair = zip(
        curves.surfaces_of_curve.tolist(), curves.closed, curves.length_of_curve, strict=True
    )
    for (first, second), closed, length in rows_of_pair:
        # number of lines, number of closed ones, length [m]
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
            number(entry[2] / 1000.0, 1),
        )
        for (first, second), entry in found.items()
    )
    return Table(("Surface", "Other surface", "Lines", "Closed", "Length [km]"), rows, n_label=2)
