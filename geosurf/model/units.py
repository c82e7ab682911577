"""What the space between surfaces becomes: units and their table."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import (
    check_name,
    counted,
    grouped,
    is_word,
    known_names,
    number_text,
    volume_text,
)
from geosurf.conventions.axes import vertical_axis, vertical_words
from geosurf.conventions.card import MOST, Card
from geosurf.conventions.palette import unit_colours
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.model.base import Shown, frozen, in_crs_of, multiblock, polydata
from geosurf.model.column import Remnant
from geosurf.model.expected import number_of
from geosurf.model.pieces import by_unit, sides_seen
from geosurf.model.regions import SHARE, MergedSliver, RegionFinder, Regions, SliverSettings

if TYPE_CHECKING:  # pragma: no cover - types only
    import pandas
    import pyvista

    from geosurf.model.pieces import Pieces


# ---- certificate ----------------------------------------
# The lines of a certificate.


@dataclass(frozen=True)
class Check:
    """One line of a certificate."""

    name: str
    passed: bool
    value: float
    detail: str


@dataclass(frozen=True, repr=False)
class Certificate:
    """What `Scene.check` found, line by line.

    Attributes
    ----------
    checks : tuple of Check
    """

    checks: tuple[Check, ...]

    @property
    def ok(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    def _repr_html_(self) -> str:
        """Return the lines as a table."""
        rows = [("pass" if c.passed else "FAIL", c.name, c.detail) for c in self.checks]
        title = "Certificate: every check passed" if self.ok else "Certificate: the model FAILS"
        return Card(title, rows).html()

    def __repr__(self) -> str:
        # Details start in one column.
        width = max((len(check.name) for check in self.checks), default=0)
        return "\n".join(
            f"{'pass' if c.passed else 'FAIL'}  {c.name:<{width}}  {c.detail}" for c in self.checks
        )


# ---- map area ----------------------------------------
# Map areas of the upper side of a unit.


def upper_area(points: np.ndarray, triangles: np.ndarray) -> float:
    """
    Return the map area of the triangles that face upwards [m2].

    Examples
    --------
    >>> points = np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 1]])
    >>> upper_area(points, np.array([[0, 1, 2], [0, 2, 1]]))
    3.0
    """
    # twice the signed map area of each triangle: up-facing ones alone give the upper side
    a, b, c = (points[triangles[:, k], :2] for k in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    up = ux * vy - uy * vx
    return 0.5 * math.fsum(up[up > 0.0].tolist())


def rows_of_contacts(names: Sequence[str], contacts: Sequence[str]) -> list[int]:
    """
    Return which surfaces are fluid contacts; those of blocks are named ``OWC in F1+``.

    Examples
    --------
    >>> rows_of_contacts(["Top", "OWC", "OWC in F1+"], ["OWC"])
    [1, 2]
    """
    inside = tuple(f"{contact} in " for contact in contacts)
    return [i for i, name in enumerate(names) if name in contacts or name.startswith(inside)]


# ---- unit ----------------------------------------
# One unit: a closed piece of the model.


@dataclass(frozen=True, eq=False)
class Unit(Shown):
    """A closed piece of the model: one zone in one fault block, above or below a contact.

    Attributes
    ----------
    name : str
        Zone, the block where faults split the zone, and the contact interval where one counts.
    zone : str
        ``above Top``, ``Top/Base``, ``below Base``.
    zone_index : int
        0 above the first horizon, counting down.
    block : str
        Sides of the faults that separate it: ``F1+`` is the side into which
        the fault's normal points (the hanging wall of a dipping fault), ``F1-`` the
        other. ``whole`` where no fault separates the zone. Pieces that no fault
        separates are numbered by size, then by place: ``F1+``, ``F1+ #2``.
    local : ndarray of float64, shape (n_vertex, 3)
    triangles : ndarray of int64, shape (n_triangle, 3)
        Outward normals.
    surface_of_triangle : ndarray of int64, shape (n_triangle,)
        Row of `surface_names`.
    bounded_by : tuple of str
        Names of the surfaces on its boundary.
    volume, area : float
        [m3], [m2]; in a model in time, volume is area times time [m2 ms].
    contact : str
        ``above OWC``, ``GOC/OWC``, ``below OWC``; empty where no fluid contact counts.
    beneath : tuple of str
        Names of the fluid contacts that count in it and lie above it, from the top down.
    fault_sides : tuple of str
        Sides of faults that it lies on: those in `block`, and those of faults that part the model
        elsewhere. From a unit on ``F1+`` no way leads to the back of F1 but through F1.
    compartment_of : str
        Where virtual walls continue faults: the block that it would be a part of without them.
    region : str
        Part of the field that it belongs to, through all zones: see `Scene.regions`. Empty above
        and below all regions, and for units of `carve_units`.
    time : str or None
        ``"two-way"`` or ``"one-way"`` in a model in time.
    """

    name: str
    zone: str
    zone_index: int
    block: str
    local: np.ndarray
    origin: np.ndarray
    triangles: np.ndarray
    surface_of_triangle: np.ndarray
    surface_names: tuple[str, ...]
    volume: float
    area: float
    contact: str = ""
    beneath: tuple[str, ...] = ()
    fault_sides: tuple[str, ...] = ()
    compartment_of: str = ""
    region: str = ""
    time: str | None = None

    @cached_property
    def vertices(self) -> np.ndarray:
        """World coordinates [m], float64 (n_vertex, 3)."""
        return frozen(self.local + self.origin, np.float64)

    @cached_property
    def middle(self) -> tuple[float, float, float]:
        """Easting, northing and elevation of the middle of its bounds [m]."""
        # The middle of the bounds: cheap, the same for any triangulation, and inside for most
        # units.
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        east, north, up = (0.5 * (low + high)).tolist()
        return east, north, up

    @cached_property
    def bounded_by(self) -> tuple[str, ...]:
        """Names of the surfaces that bound the unit."""
        return tuple(self.surface_names[i] for i in np.unique(self.surface_of_triangle))

    @cached_property
    def map_area(self) -> float:
        """Area of its upper side in the map [m2]; where it lies above itself, that counts twice.

        Volume over it is the mean length of the pieces of vertical lines inside the unit.
        """
        return upper_area(self.local, self.triangles)

    @cached_property
    def n_triangle(self) -> int:
        """Number of triangles."""
        return len(self.triangles)

    @cached_property
    def zone_map_area(self) -> float:
        """Map area of its upper side where that is not a fluid contact [m2].

        Volume over it, summed over the units of a zone, is the mean thickness of the zone.
        """
        contacts = rows_of_contacts(self.surface_names, self.beneath)
        return upper_area(self.local, self.triangles[~np.isin(self.surface_of_triangle, contacts)])

    def to_pyvista(self) -> pyvista.PolyData:
        """Return the shell as `pyvista.PolyData` with the surface row as cell data."""
        labels = {"surface": self.surface_of_triangle}
        return polydata(self.vertices, self.triangles, cell_data=labels, crs=self.crs)

    def _card(self) -> Card:
        """Return zone, block, volume and what bounds the unit."""
        with vertical_axis(self.time):
            volume = volume_text(self.volume, 5)
        rows = [("zone", self.zone), ("block", self.block), ("volume", volume)]
        rows += [("region", self.region)] if self.region else []
        rows += [("contact", self.contact)] if self.contact else []
        rows.append(("bounded by", ", ".join(self.bounded_by)))
        return Card(f"Unit {self.name}", rows)

    def __repr__(self) -> str:
        with vertical_axis(self.time):
            volume = volume_text(self.volume)
        return f"<Unit {self.name!r}: {volume}, {self.n_triangle} triangles>"


# ---- unit table ----------------------------------------
# The table of units: volumes, areas and names.


def table_of(units: Units) -> xarray.Dataset:
    """Return volumes and areas of all units; ``sliver`` marks the slivers."""
    each = list(units.values())
    columns = {
        "area": ([u.area for u in each], "m2", "area of the closed shell"),
        "map_area": ([u.map_area for u in each], "m2", "area of the upper side in the map"),
        # Where the unit is, as in the picture of the column; a shell without area has no volume.
        "thickness_mean": (
            [u.volume / u.map_area if u.map_area > 0 else 0.0 for u in each],
            "m" if units.time is None else "ms",
            "mean vertical thickness where the unit is present: volume over map_area",
        ),
    }
    if units.time is not None:
        del columns["area"]  # of slanted faces: metres and milliseconds do not add up
    data = {
        key: ("unit", np.array(values, dtype=np.float64), {"units": unit, "long_name": name})
        for key, (values, unit, name) in columns.items()
    }
    attrs = {"box": list(units.box), "box_units": "m", **_crs(units)}
    return xarray.Dataset({"volume": volumes_of(units), **data}, labels_of(units), attrs)


def volumes_of(units: Units) -> tuple[tuple[str], np.ndarray, dict[str, Any]]:
    """Return the column of volumes; no area is computed for it."""
    attrs = {"units": "m3", "long_name": "gross rock volume (GRV)", **_crs(units)}
    if units.time is not None:
        attrs |= {"units": "m2 ms", "long_name": "map area times time"}
    # Float64 even without units, so that an empty model has the same types.
    return ("unit",), np.array([u.volume for u in units.values()], dtype=np.float64), attrs


def labels_of(units: Units) -> dict[str, tuple[str, np.ndarray]]:
    """Return name, zone, block and region of each unit, and contact where there are some."""
    each, labels = list(units.values()), {}
    for key in ("name", "zone", "block", "region", "zone_index", "contact", "compartment_of"):
        values = [getattr(unit, key) for unit in each]
        kind = np.int64 if key == "zone_index" else object
        if any(values) or key not in ("region", "contact", "compartment_of"):
            labels["unit" if key == "name" else key] = ("unit", np.array(values, dtype=kind))
    # Marked rather than left out, so that volumes of the table add up to the model.
    inside = np.array([u.zone in units.reservoir for u in each], dtype=bool)
    if not inside.all():
        labels["reservoir"] = ("unit", inside)
    labels["sliver"] = ("unit", np.array([u.name in units._small for u in each], dtype=bool))
    return labels


def sums_of(units: Units, by: Any) -> xarray.Dataset:
    """Return the sums of volumes by some labels, see `Scene.table`."""
    import pandas

    keys = (by,) if isinstance(by, str) else by
    if not isinstance(keys, list | tuple) or not keys or len(set(keys)) < len(keys) or any(
        not is_word(key, SUMMED) for key in keys
    ):  # fmt: skip
        raise InputError(
            f"by is {by!r}; give one of {', '.join(SUMMED)}, or several: by=('region', 'zone')."
        )
    each = list(units.values())
    columns = {key: [getattr(unit, key) for unit in each] for key in keys}
    volumes = pandas.Series([unit.volume for unit in each], dtype=float, name="volume")
    sums = volumes.groupby([pandas.Index(columns[key], name=key) for key in keys]).agg(math.fsum)

    # zones from the top down, regions by size, contact intervals from above to below
    order = {key: list(dict.fromkeys(words)) for key, words in columns.items()}
    if "region" in order:
        order["region"].sort(key=lambda name: [*units.regions, name].index(name))
    if "contact" in order:
        order["contact"].sort(key=lambda name: INTERVALS.get(name.partition(" ")[0], 0))
    found = sums.to_xarray().reindex(order).fillna(0.0)
    attrs = {"units": "m3", "long_name": "gross rock volume (GRV)"}
    table: xarray.Dataset = found.assign_attrs(attrs).to_dataset()
    return table.assign_attrs(_crs(units))


def _crs(units: Units) -> dict[str, str]:
    """The reference system as an attribute of tables, if there is one."""
    return {} if units.crs is None else {"crs": units.crs}


SUMMED = ("region", "zone", "block", "contact")  # what volumes are summed up by
INCLUDE = ("reservoir", "all")  # which units tables and pictures show
TABLE = "units.table lists them."
INTERVALS = {"above": -1, "below": 1}  # contact intervals from the top down; others lie between
MOST_ROWS = 40  # of units that are printed
MOST_CLIPS = 6  # pairs of horizons that cross, listed below the table
MOST_SLIVERS = 4  # of slivers that are listed there
NO_PATCHES = "these units have no patches. Use units from carve_units or Scene.units."


class Units(Shown, Mapping[str, Unit]):
    """Units by name, or by ``(zone, block)``, in order: zone by zone, youngest first.

    Where fluid contacts split them, by ``(zone, block, contact)``.

    Parameters
    ----------
    units : iterable of Unit
    box : (west, east, south, north, bottom, top)
        The model box [m].
    report : dict
        What carving found: ``slits`` (areas of faults that die inside), ``clipped`` (what
        the column took away of horizons that cross, `Clipped`), the number of ``cells``, and the
        units ``without_contact``, by each fluid contact that leaves out some; ``outside``, the
        faults that do not reach the model; ``thin``, the units that are as thin as the rounding
        of their corners (`Remnant`).
    footprint : float, optional
        Area of the model in map view [m2]; default: that of the box.
    sides : callable, optional
        () -> `sides`; asked when they are first needed.
    enclosed : float, optional
        Volume inside the walls [m3]; default: footprint times height.
    slivers : SliverSettings, optional
        Which units are slivers; default: units below 1/10 000 of their zone.
    merged : sequence of MergedSliver
        Slivers that are part of other units.
    unmerged : Units, optional
        The units before that.
    piece_sides : callable, optional
        () -> `piece_sides`.
    reservoir : sequence of str, optional
        Zones of the reservoir; default: all zones of the units.

    Raises
    ------
    InputError
        If two units have one name.
    """

    def __init__(
        self,
        units: Any,
        box: tuple[float, float, float, float, float, float],
        report: dict[str, Any] | None = None,
        footprint: float | None = None,
        sides: Callable[[], np.ndarray] | None = None,
        enclosed: float | None = None,
        slivers: SliverSettings | None = None,
        merged: Sequence[MergedSliver] = (),
        unmerged: Units | None = None,
        piece_sides: Callable[[], tuple[Pieces, np.ndarray]] | None = None,
        reservoir: Sequence[str] | None = None,
    ) -> None:
        # sides are asked of carving when they are first needed; most users only want volumes
        self._sides, self._piece_sides = sides, piece_sides
        self.sliver_settings = slivers or SliverSettings()
        self.merged, self.unmerged = tuple(merged), unmerged
        self._enclosed = enclosed
        self._units: dict[str, Unit] = {}
        # Names are keys of tables and files, so two units cannot share one.
        for unit in units:
            if self._units.setdefault(unit.name, unit) is not unit:
                raise InputError(f"two units have the name {unit.name!r}. Give each its own name.")

        # two-part labels where there is no contact, three where there is
        self._by_labels: dict[tuple[str, ...], Unit] = {}
        for unit in self._units.values():
            labels = (unit.zone, unit.block, unit.contact)
            self._by_labels[labels if unit.contact else labels[:2]] = unit
        self.box = tuple(float(value) for value in box)
        # With an area of interest the footprint is smaller than the box, and carving hands it in.
        w, e, s, n = self.box[:4]
        self.footprint = (e - w) * (n - s) if footprint is None else float(footprint)
        self.report = dict(report or {})
        self._regions: RegionFinder | None = None
        self.time: str | None = None  # how times count, of a model in time
        zones = (unit.zone for unit in self._units.values()) if reservoir is None else reservoir
        self.reservoir = tuple(dict.fromkeys(zones))

    def __getitem__(self, key: Any) -> Unit:
        # keys as users type them: a name or a tuple of labels
        labels = tuple(map(str, key)) if isinstance(key, tuple) else ()
        name = key if isinstance(key, str) else ""  # anything else may not be hashable
        unit: Unit | None = self._by_labels.get(labels) if labels else self._units.get(name)
        if unit is None:
            word = key if isinstance(key, str) else None
            raise KeyError(
                f"there is no unit {key!r}. The units are {known_names(self._units, word)}"
            )
        return unit

    def _card(self) -> Card:
        """Return a table of the reservoir with the colours of pictures, slivers summed up below."""
        part = self.included()
        listed = [*part.without_slivers]
        labels = self.labels
        colours = unit_colours((labels[unit.name], unit.zone_index) for unit in listed)
        first = listed[:MOST]

        # one unit and as many decimals for all rows, as in the report: they can be compared
        scale, unit = (1e6, "million m³") if part.volume >= 1e6 else (1.0, "m³")
        if self.time is not None:
            scale, unit = 1.0, "m²·ms"
        volumes = [f"{u.volume / scale:,.3f}".replace(",", " ") for u in first]
        head = ("zone", "region", "block", "contact", f"GRV [{unit}]")
        rows = [
            (u.zone, u.region, u.block, u.contact, v) for u, v in zip(first, volumes, strict=True)
        ]
        shades = [colours[labels[unit.name]] for unit in first]
        with vertical_axis(self.time):
            title = f"{counted(len(part), 'unit')}, GRV {volume_text(part.volume)}"
            return Card(title, rows, head, shades, self._notes(), len(listed))

    def _notes(self) -> list[str]:
        """What stands below tables of the reservoir."""
        part = self.included()
        words = part.slivers_in_words, part.merged_in_words, left_out(self, TABLE), part.ends_at_box
        return [*filter(None, words)]

    def __repr__(self) -> str:
        # Counts tell more than names: a model may have hundreds of units.
        zones, blocks = ({getattr(u, of) for u in self.values()} for of in ("zone", "block"))
        n = len(self.report.get("clipped", ()))
        clipped = f"; horizons cross ({counted(n, 'pair')}): report['clipped']" if n else ""
        with vertical_axis(self.time):
            part, volume = self.included(), volume_text(self.volume)
            if part is not self:
                volume = f"GRV {volume_text(part.volume)} in the reservoir, {volume} in all"
        return (
            f"<Units: {len(self)}, of {counted(len(zones), 'zone')} in "
            f"{counted(len(blocks), 'block')}, {volume}{clipped}>"
        )

    def __iter__(self) -> Iterator[str]:
        return iter(self._units)

    def __len__(self) -> int:
        return len(self._units)

    def __str__(self) -> str:
        """A table of the reservoir: zone, region, block, contact, GRV; slivers; what is clipped."""
        with vertical_axis(self.time):
            return self._as_table()

    def _as_table(self) -> str:
        head, part = ("zone", "region", "block", "contact", "compartment of"), self.included()
        # Slivers would fill the table; they are summed up below it.
        listed = part.without_slivers

        # widths from all rows, volumes with their unit, as messages, report and pictures have them
        rows = [(u.zone, u.region, u.block, u.contact, u.compartment_of) for u in listed]
        shown = [k for k in range(5) if k in (0, 2) or any(row[k] for row in rows)]
        width = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
        volumes = [volume_text(unit.volume, 4) for unit in listed]
        room = max(map(len, ["GRV", *volumes[:MOST_ROWS]]))
        lines = ["  ".join([*(head[k].ljust(width[k]) for k in shown), "GRV".rjust(room)])]

        # the first rows only: a model of many blocks has hundreds of units
        for row, volume in zip(rows[:MOST_ROWS], volumes, strict=False):
            words = [row[k].ljust(width[k]) for k in shown]
            lines.append("  ".join([*words, volume.rjust(room)]))
        more = f", {len(rows) - MOST_ROWS} more of them" if len(rows) > MOST_ROWS else ""
        lines.append(f"{counted(len(part), 'unit')}{more}, GRV {volume_text(part.volume)}")
        lines += self._notes()
        clipped = self.report.get("clipped", ())
        lines += map(str, clipped[:MOST_CLIPS])
        if len(clipped) > MOST_CLIPS:
            lines.append(f"and {len(clipped) - MOST_CLIPS} more: report['clipped']")
        return "\n".join(lines)

    @cached_property
    def sides(self) -> np.ndarray:
        """Unit in front of and behind each triangle of the patches, int64 (n_triangle, 2).

        Units are counted in the order of this mapping; -1 is outside the model. Where surfaces
        coincide, each has the units on its own front and back.

        Raises
        ------
        InputError
            If the units were made without patches.
        """
        if self._sides is None:
            raise InputError(NO_PATCHES)
        return frozen(self._sides(), np.int64)

    @cached_property
    def piece_sides(self) -> tuple[Pieces, np.ndarray]:
        """Pieces of the model, and the unit in front of and behind each, int64 (n_piece, 2).

        As `sides`, for triangles that curves touch and for runs of grids. A triangle that coincides
        with an earlier one has -1 on both sides.

        Raises
        ------
        InputError
            If the units were made without patches.
        """
        if self._piece_sides is None:
            raise InputError(NO_PATCHES)
        return self._piece_sides()

    @cached_property
    def sides_seen(self) -> np.ndarray:
        """As `piece_sides`; a triangle that coincides with an earlier one has its sides, too."""
        return frozen(sides_seen(*self.piece_sides), np.int64)

    def elements_of(self, u: int) -> np.ndarray:
        """
        Return the pieces that bound a unit: those that have it on one side only.

        Parameters
        ----------
        u : int
            Row of the unit.

        Returns
        -------
        ndarray of int64
            Rows of `piece_sides`, rising.
        """
        rows, first = self._elements_of_units
        return rows[first[u] : first[u + 1]]

    @cached_property
    def _elements_of_units(self) -> tuple[np.ndarray, np.ndarray]:
        return by_unit(self.piece_sides[1], len(self))

    @cached_property
    def rows_inside(self) -> frozenset[int]:
        """Rows of the surfaces with a unit in front or behind: those that reach into the model."""
        pieces = self.piece_sides[0]
        inside = np.asarray((self.sides_seen >= 0).any(axis=1))
        n_core = len(pieces.triangles)
        rows = np.repeat(np.arange(len(pieces.sources)), np.diff(pieces.first_run))
        found = np.concatenate([pieces.surface[inside[:n_core]], rows[inside[n_core:]]])
        return frozenset(np.unique(found).tolist())

    @cached_property
    def faces(self) -> dict[Any, Any]:
        """What measures have listed of single surfaces: see ``geosurf.measure.faces``."""
        return {}

    @property
    def has_pieces(self) -> bool:
        """Whether the units know their patches: without, `piece_sides` is an error."""
        return self._piece_sides is not None

    def included(self, include: str = "reservoir") -> Units:
        """
        Return the units that tables and pictures show: those of the reservoir, or all.

        Parameters
        ----------
        include : {"reservoir", "all"}

        Returns
        -------
        Units
            These units where all are shown. Others have the box and report of the whole model, and
            no `sides`.

        Raises
        ------
        InputError
            For another word.

        Examples
        --------
        >>> from geosurf import Scene, synthetic
        >>> world = synthetic.tilted_planes()
        >>> units = Scene(world.horizons, world.faults, world.box).units
        >>> len(units), list(units.included()), units.included("all") is units
        (6, ['Top/Base F1+', 'Top/Base F1-'], True)
        """
        if not is_word(include, INCLUDE):
            raise InputError(f"include is {include!r}; it must be one of {', '.join(INCLUDE)}.")
        return self if include == "all" else self._of_reservoir

    @cached_property
    def _of_reservoir(self) -> Units:
        inside = [unit for unit in self._units.values() if unit.zone in self.reservoir]
        if len(inside) == len(self):
            return self
        w, e, s, n, bottom, top = self.box
        names = {unit.name for unit in inside}
        part = Units(
            inside, (w, e, s, n, bottom, top), self.report, self.footprint,
            slivers=self.sliver_settings, merged=[m for m in self.merged if m.into in names],
            unmerged=self.unmerged, reservoir=self.reservoir,
        )  # fmt: skip
        part._regions, part.time = self._regions, self.time
        return in_crs_of(part, [self])

    @cached_property
    def labels(self) -> dict[str, str]:
        """What legends call each unit: zone, region where there are several, contact interval."""
        if len(self.regions) < 2:
            return {name: name for name in self}
        return {
            unit.name: " ".join(filter(None, (unit.zone, unit.region, unit.contact)))
            if unit.region else unit.name
            for unit in self.values()
        }  # fmt: skip

    @property
    def regions(self) -> Regions:
        """Regions by name, the largest first; none for units of `carve_units`."""
        return Regions((), ()) if self._regions is None else self._regions.found

    @property
    def volume(self) -> float:
        """Sum of all volumes [m3]."""
        return math.fsum(unit.volume for unit in self._units.values())

    @property
    def box_volume(self) -> float:
        """Volume of the model [m3]: footprint times height, or inside walls of any shape."""
        # Walls of any shape enclose less than footprint times height.
        if self._enclosed is not None:
            return self._enclosed
        return self.footprint * (self.box[5] - self.box[4])

    @cached_property
    def slivers(self) -> tuple[Remnant, ...]:
        """Units too small to count, the largest first; tables and legends have them apart.

        By default units below 1/10 000 of their zone, and units thinner than the rounding error of
        their vertices; or units below the volume that ``Scene(slivers=...)`` states.
        """
        small = [
            Remnant(u.name, u.volume, u.middle) for u in self.values() if u.name in self._small
        ]
        return tuple(sorted(small, key=lambda remnant: -remnant.volume))

    @cached_property
    def _small(self) -> frozenset[str]:
        """Names of the slivers: nothing but volumes is asked for."""
        # The rule of the scene, or the default.
        least = self.sliver_settings.min_volume
        thin = {remnant.name for remnant in self.report.get("thin", ())}
        # Shares refer to zones as they were: a merged sliver makes its zone larger.
        volumes_by_zone = grouped(
            (unit.zone, unit.volume) for unit in (self.unmerged or self).values()
        )

        # default: a share of the zone, and units that rounding alone may have made
        small = set()
        for unit in self._units.values():
            limit = (
                SHARE * math.fsum(volumes_by_zone.get(unit.zone, ())) if least is None else least
            )
            if unit.volume < limit or (least is None and unit.name in thin):
                small.add(unit.name)
        return frozenset(small)

    @cached_property
    def without_slivers(self) -> tuple[Unit, ...]:
        """All other units, in order."""
        return tuple(unit for unit in self._units.values() if unit.name not in self._small)

    @property
    def slivers_in_words(self) -> str:
        """How many slivers there are, the sum of their volumes, and the largest; '' for none."""
        if not self.slivers:
            return ""
        # fsum: the same sum in any order of units.
        n, total = len(self.slivers), math.fsum(sliver.volume for sliver in self.slivers)
        listed = ", ".join(
            f"{sliver.name} ({volume_text(sliver.volume)})"
            for sliver in self.slivers[:MOST_SLIVERS]
        )
        more = f" and {n - MOST_SLIVERS} more" if n > MOST_SLIVERS else ""
        head = "1 of them is a sliver" if n == 1 else f"{n} of them are slivers"
        return f"{head} ({self.sliver_settings.rule}), {volume_text(total)} in all: {listed}{more}"

    @property
    def ends_at_box(self) -> str:
        """Zones that reach the top or bottom of the model box, in a sentence; '' for none.

        Examples
        --------
        >>> from geosurf import Scene, synthetic
        >>> world = synthetic.tilted_planes()
        >>> Scene({"Top": world.horizons["Top"]}, {}, world.box).units.ends_at_box[:43]
        "'above Top' and 'below Top' end at the mode"
        """
        last = max((unit.zone_index for unit in self.values()), default=0)
        outer = {last: "below ", 0: "above "}
        zones: dict[str, None] = {}
        for unit in self.values():
            side = outer.get(unit.zone_index, "")
            if side and all(word.startswith(side) for word in (unit.zone, unit.contact or side)):
                zones[repr(", ".join(filter(None, (unit.zone, unit.contact))))] = None
        if not zones:
            return ""
        many = len(zones) > 1
        bottom, top = (number_text(z, 5) for z in self.box[4:])
        name, metre = vertical_words()
        return (
            f"{' and '.join(zones)} {'end' if many else 'ends'} at the model box, {name.lower()} "
            f"{bottom} to {top} {metre}: {'their' if many else 'its'} GRV depends on box= ([box] "
            "in a scenario)."
        )

    @property
    def merged_in_words(self) -> str:
        """How many slivers were merged, and the sum of their volumes; '' for none."""
        if not self.merged:
            return ""
        total = volume_text(math.fsum(one.volume for one in self.merged))
        return f"{counted(len(self.merged), 'sliver')} merged into neighbours, {total} in all"

    def on(self, *sides: str) -> tuple[Unit, ...]:
        """
        Return the units that lie on some sides of faults, whatever their blocks are called.

        Names of blocks hold what distinguishes the units of one zone; a block may be ``F1+ F2-`` in
        a zone and ``F2-`` in the next, which F1 has left.

        Parameters
        ----------
        *sides : str
            As in ``Unit.fault_sides``: ``"F1+"``, ``"F2-"``. All of them hold.

        Returns
        -------
        tuple of Unit

        Raises
        ------
        InputError
            If no unit lies on one of them.

        Examples
        --------
        >>> from geosurf import Scene, synthetic
        >>> world = synthetic.tilted_planes()
        >>> units = Scene(world.horizons, world.faults, world.box).units
        >>> [unit.zone for unit in units.on("F1+")]
        ['above Top', 'Top/Base', 'below Base']
        """
        # Sides in the order of units, each once.
        known = list(dict.fromkeys(s for unit in self._units.values() for s in unit.fault_sides))
        for side in sides:
            check_name(side, known, f"no unit is on {side!r}. The sides of faults are")
        # All sides have to hold, in any order.
        return tuple(unit for unit in self._units.values() if set(sides) <= set(unit.fault_sides))

    def remnants(self, min_volume: float = 0.0) -> tuple[Remnant, ...]:
        """
        List slivers and detached pieces of units.

        A detached piece has the zone and block of a larger unit, which it does not touch.

        Parameters
        ----------
        min_volume : float
            Units smaller than this are listed, too [m3]. They stay in the model.

        Returns
        -------
        tuple of Remnant
            The largest first.

        Examples
        --------
        >>> Units([], (0, 1, 0, 1, 0, 1)).remnants(100.0)
        ()
        """
        min_volume = number_of(min_volume, "min_volume", "give cubic metres")
        small_parts = []
        for unit in self._units.values():
            # pieces after the largest of a zone and block have a number; those below the limit come
            # in, too
            if " #" in unit.block or unit.volume < min_volume:
                small_parts.append(Remnant(unit.name, unit.volume, unit.middle))
        return tuple(sorted(small_parts, key=lambda remnant: -remnant.volume))

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Return the shells of all units as named blocks of `pyvista`.

        Returns
        -------
        pyvista.MultiBlock
            One `pyvista.PolyData` for each unit, with the surface row as cell data.
        """
        return multiblock({name: unit.to_pyvista() for name, unit in self._units.items()})

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the table of units for `pandas`: one row for each unit.

        Returns
        -------
        pandas.DataFrame
            Zone, block, volume [m3], areas [m2]; indexed by the names of the units.
        """
        return self.table.to_dataframe()

    @cached_property
    def volumes(self) -> xarray.DataArray:
        """Volume of each unit by zone and block, and contact where there are some [m3].

        As ``table["volume"]``, but no area is computed.
        """
        _, values, attrs = volumes_of(self)
        # labels are plain strings and numbers: xarray need not look for dates among them
        labels = {
            name: xarray.Variable(dims, column, fastpath=True)
            for name, (dims, column) in labels_of(self).items()
        }
        return xarray.DataArray(values, labels, "unit", "volume", attrs)

    @cached_property
    def table(self) -> xarray.Dataset:
        """Volumes and areas of all units, with units in ``attrs``; ``sliver`` marks the slivers.

        ``reservoir`` marks the units of the reservoir where others are listed, too.
        """
        return table_of(self)


def units_in(units: Units, regions: RegionFinder, time: str | None) -> Units:
    """Return copies of units, whose regions are found when they are first requested.

    `time` is ``"two-way"`` or ``"one-way"`` of a model in time.
    """
    copied, each = copy.copy(units), {name: copy.copy(unit) for name, unit in units.items()}
    for unit in each.values():
        unit.__dict__.pop("region", None)  # of the one that it is a copy of
        unit.__dict__.update(_regions=regions, time=time)
    by_labels = {labels: each[unit.name] for labels, unit in units._by_labels.items()}
    copied.__dict__.update(_units=each, _by_labels=by_labels, _regions=regions, time=time)
    return copied


def left_out(units: Units, how: str, include: str = "reservoir") -> str:
    """Return how many units tables leave out, their volume, and how to see them; '' for none.

    Examples
    --------
    >>> left_out(Units([], (0, 1, 0, 1, 0, 1)), "Ask for all.")
    ''
    """
    part = units.included(include)
    if part is units:
        return ""
    n = len(units) - len(part)
    rest = math.fsum(u.volume for u in units.values() if u.zone not in units.reservoir)
    return f"Not shown: {counted(n, 'unit')} outside the reservoir, {volume_text(rest)}. {how}"
