"""Every key of a scenario: its type, unit, default and meaning, stated once.

The parser reads these dataclasses, and so does the page docs/scenario.md, with the meanings of
their docstrings, so that neither can know a key that the other does not.
"""

# ruff: noqa: RUF009 - `key` makes a dataclasses.field

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.faults.rules import BOTH, KEEP
from geosurf.measure.velocity import WAYS
from geosurf.model import RULES
from geosurf.model.column import names_of_zones, rule_meant
from geosurf.model.regions import SliverSettings
from geosurf.model.tears import FaultThrow
from geosurf.scenario import values
from geosurf.scenario.output_keys import (
    EnsembleSettings,
    FluidsInput,
    GridInput,
    OutputSettings,
    PictureSettings,
    SearchSettings,
    TopsInput,
    UncertainInput,
    WellsInput,
)
from geosurf.scenario.values import KeyPath, key, table, tables
from geosurf.sheets.faults import DIRECTIONS

# ---- zone keys ----------------------------------------
# Zones from thickness: ``[zones]``.


@values.check(
    "tables by zone, such as `[zones.Upper]` with below or above, thickness, and base, top or kind"
)
def zones_by_name(at: values.KeyPath, value: Any) -> Any:
    """Zones by name; a text is the file of a thickness map."""
    if not isinstance(value, dict) or not all(isinstance(zone, dict) for zone in value.values()):
        return None
    zones = {name: dict(zone) for name, zone in value.items()}
    for name, zone in zones.items():
        if isinstance(zone.get("thickness"), str):
            place = at.inside(name).inside("thickness")
            zone["thickness"] = values.file(place, zone["thickness"])
    return zones


# ---- seal keys ----------------------------------------
# The keys of ``[seal]``.


@values.check(
    'a number, or a table of these by zone, such as `{"Top/Base" = 0.2, elsewhere = 0.7}`'
)
def by_zone(at: values.KeyPath, value: Any) -> Any:
    """A number, or numbers by zone, whose names are checked when all zones are known."""
    if not isinstance(value, dict):
        return values.not_negative(at, value)
    return {zone: values.not_negative(at.inside(zone), one) for zone, one in value.items()} or None


@dataclass(frozen=True, kw_only=True)
class SealInput:
    """``[seal]``: what faults hold, as `seal.csv`: a row for each pair of units across a fault.
    See [fault seal](guides/fault_seal.md).

    Attributes
    ----------
    vshale
        Shale of the zones, fractions.
    shale
        From which Vshale a zone is shale.
    density_contrast_kg_m3
        Density of water less that of hydrocarbon, for column heights.
    seabed_m
        Elevation from which burial depth counts.
    closures_sgr
        Least shale gouge ratio with which faults hold in `closures.csv`, where reservoir faces
        reservoir. Left out: as `output.closures` says.
    permeability_md
        Of the cells of `[grid]`: `grid_multipliers.inc` then has MULTX, MULTY and MULTZ.
    """

    vshale: Any = key(by_zone)
    shale: float = key(values.share, default=0.4)
    density_contrast_kg_m3: float | None = key(values.above_zero, unit="kg/m³", default=None)
    seabed_m: float = key(values.number, unit="m", default=0.0)
    closures_sgr: float | None = key(values.share, default=None)
    permeability_md: Any = key(by_zone, unit="mD", default=None)


# ---- fault keys ----------------------------------------
# Keys of faults: files, pieces of a mesh, polygons, and how far they are continued.


# Functions, because a dataclass field cannot be used twice.
@dataclass(frozen=True, kw_only=True)
class PolygonInput:
    """One ``[[faults.polygons]]``: the polygon of a fault on one horizon. The fault passes through
    both sides of its polygons, and continues along their dip. One horizon is enough. Where this
    horizon is torn, its walls end on them.

    Attributes
    ----------
    horizon
        The horizon on which it was drawn.
    file
        `.pol`, `.csv`, `.dat`, `.txt` and others with lines, each point with its elevation;
        relative to the scenario.
    polygon
        Which polygon of the file, counted from 1. Left out: the only one.
    """

    horizon: str = key(values.text)
    file: Path = key(values.file)
    polygon: int | None = key(values.count, default=None)


@dataclass(frozen=True, kw_only=True)
class FaultInput:
    """One ``[[faults]]``: in any order.

    Attributes
    ----------
    name
        Name in all results.
    file
        `.ts` (GOCAD), `.vtp` and other meshes, `.pol`, `.csv` (sticks), `.nc` (parametric grid);
        relative to the scenario. Give this or `polygons`.
    name_in_file
        Of a file with several faults: which one. Left out: `name`.
    piece
        Of a mesh in several pieces: which one, counted from 1, the largest. Left out: all, as one
        fault.
    dip
        Of polygons: dip of the fault, where gridding has smeared the horizons over it, so that gaps
        look wide and the fault flat. It then passes midway between the two sides of a polygon;
        above 90 it dips to the other side. Left out: as steep as the polygons are.
    positive
        Whether values are elevations or depths, for a file that does not declare it.
    length_unit
        Length unit of elevations, for a file that does not declare it; `ms` or `s` with `time`.
    columns
        Of a table with other headings: the columns x, y and z, by name or by number from 1. Sticks
        take two more: number of the stick, and name of the fault.
    decimal
        Decimal sign of a table.
    lengthen_m
        Distance by which the fault is continued along its dip and strike, before `extend`: one for
        all sides, or one for each side that is named.
    extend
        Sides on which the fault is continued until it leaves the model box: `strike` is both ends,
        `start` and `end` follow the right-hand rule.
    """

    name: str = key(values.text)
    # One of both: checked when all keys are known.
    file: Path | None = key(values.file, default=None)
    name_in_file: str | None = key(values.text, default=None)
    piece: int | None = key(values.count, default=None)
    polygons: tuple[PolygonInput, ...] = key(tables(PolygonInput), default=())
    dip: float | None = key(values.full_dip, unit="degrees", default=None)
    positive: str | None = key(values.direction, default=None)
    length_unit: str | None = key(values.length_unit, default=None)
    columns: tuple[str, ...] | tuple[int, ...] | None = key(values.columns, default=None)
    decimal: str = key(values.decimal, default=".")
    # Continued by a distance, or until the fault leaves the box: two different wishes.
    lengthen_m: float | dict[str, float] | None = key(values.distances, unit="m", default=None)
    extend: tuple[str, ...] = key(values.some_of(*values.FAULT_SIDES), default=())

    @property
    def files(self) -> dict[str, Path]:
        """Files of the fault, by what they hold."""
        if self.file is not None:
            return {self.name: self.file}
        return {f"{self.name} on {one.horizon}": one.file for one in self.polygons}


@dataclass(frozen=True, kw_only=True)
class NetworkInput:
    """``[network]``: what geosurf proposes where faults meet, stop short of each other, or end
    inside the model. See [faults](guides/faults.md).

    Attributes
    ----------
    apply
        Whether proposals are applied, one after another until none is left. Rules of
        `[[truncations]]` stand. The console lists each proposal with its reason.
    reach_m
        Largest distance by which a fault stops short of another one that it is continued to. Left
        out: a fifth of the root of the smaller fault's area.
    """

    apply: bool = key(values.switch, default=False)
    reach_m: float | None = key(values.above_zero, unit="m", default=None)


def check_faults(faults: tuple[FaultInput, ...], at: KeyPath) -> None:
    """Each fault comes from a file or from polygons."""
    for entry in faults:
        where = f"faults[{entry.name!r}]"
        place = at.of(where)
        with place.noting():
            if (entry.file is None) == (not entry.polygons):
                place.refuse(f"{where}: give either file or [[faults.polygons]].")
            needs, given = ("file", "polygons") if entry.polygons else ("polygons", "a file")
            for word in ("name_in_file", "piece") if entry.polygons else ("dip",):
                if getattr(entry, word) is not None:
                    are = "are" if entry.polygons else "is"
                    place.inside(word).refuse(
                        f"{where}: {word} needs {needs}, and {given} {are} given. Remove {word}."
                    )
            horizons = [one.horizon for one in entry.polygons]
            twice = next((one for one in horizons if horizons.count(one) > 1), None)
            if twice is not None:
                place.inside("polygons").refuse(
                    f"{where}: two polygons are of horizon {twice!r}. Give one for each horizon."
                )


# ---- area keys ----------------------------------------
# Keys of a scenario that limit the model: ``[aoi]`` and ``[box]``.


@dataclass(frozen=True, kw_only=True)
class AreaOfInterest:
    """``[aoi]``: a polygon that the model fills.

    Leave the table out for the box, or without a box for the outline that all horizons share.

    Attributes
    ----------
    file
        A closed polygon, `.pol` or `.csv`. Give one of these keys.
    corners_m
        Easting and northing around the polygon.
    rectangle
        Whether to take the largest axis-parallel rectangle that all horizons cover.
    """

    file: Path | None = key(values.file, default=None)
    corners_m: tuple[tuple[float, float], ...] | None = key(values.corners, unit="m", default=None)
    rectangle: bool = key(values.switch, default=False)

    @property
    def value(self) -> Any:
        """The area as `Scene` takes it."""
        # Exactly one of the three is set: `validate` has seen to it.
        return "rectangle" if self.rectangle else self.file or self.corners_m


@dataclass(frozen=True, kw_only=True)
class BoxRanges:
    """``[box]``: the model box. Leave the table out for the outline that all horizons share.

    Attributes
    ----------
    easting_m
        West and east side.
    northing_m
        South and north side.
    elevation_m
        Bottom and top, positive up.
    """

    easting_m: tuple[float, float] = key(values.interval, unit="m")
    northing_m: tuple[float, float] = key(values.interval, unit="m")
    elevation_m: tuple[float, float] = key(values.interval, unit="m")

    @property
    def sides(self) -> tuple[float, float, float, float, float, float]:
        """West, east, south, north, bottom, top [m]."""
        # The order of `Scene(box=)`.
        return (*self.easting_m, *self.northing_m, *self.elevation_m)


# ---- sliver keys ----------------------------------------
# Keys of a scenario about units that are too small to count: ``[slivers]``.


@dataclass(frozen=True, kw_only=True)
class SliversInput:
    """``[slivers]``: units that are too small to count. Tables and legends list them apart. See
    [the column](guides/column.md).

    Attributes
    ----------
    min_volume_m3
        Units below this volume are slivers. Left out: units below 1/10 000 of their zone.
    merge
        Whether each is merged into the neighbour with the largest shared area. The certificate
        lists them.
    """

    min_volume_m3: float | None = key(values.not_negative, unit="m³", default=None)
    merge: bool = key(values.switch, default=False)

    @property
    def settings(self) -> SliverSettings:
        """The same as `Scene` takes it."""
        # The same class as for `Scene(slivers=)`, so that both follow one rule.
        return SliverSettings(self.min_volume_m3, self.merge)


# ---- tear keys ----------------------------------------
# Of all keys: ``[tear]`` and ``[[throws]]``, which tear horizons at their faults.


@dataclass(frozen=True, kw_only=True)
class TearSettings:
    """``[tear]``: horizons that were picked or gridded across their faults are torn there. The
    report has the details. Leave the table out for horizons as they are. See
    [tearing](guides/tearing.md).

    Attributes
    ----------
    horizons
        Horizons to tear. Left empty: all.
    trim_cells
        Ignore data closer to a fault than this: at least one and a half times the half width of the
        smear. By default it is estimated for each fault from data that are held out.
    noise_m
        Standard deviation of the noise: data around faults are averaged. Left out: estimated;
        gridded data are met, and their average goes on to the faults. 0: data themselves do.
    keep_outliers
        Keep points that fit the other wall of a fault and contradict their neighbours. They are
        left out otherwise, with a warning.
    fill_empty_blocks
        What becomes of horizons in blocks without data: `false` refuses, `true` continues them from
        the neighbouring block, `"lower"` and `"upper"` pinch them out onto the horizon below or
        above.
    """

    horizons: tuple[str, ...] = key(values.names, default=())
    trim_cells: str | float | dict[str, Any] = key(
        values.trim, unit="cells of the grid", default="auto"
    )
    noise_m: float | None = key(values.not_negative, unit="m", default=None)
    keep_outliers: bool = key(values.switch, default=False)
    fill_empty_blocks: bool | str | dict[str, Any] = key(values.filling, default=False)


@dataclass(frozen=True, kw_only=True)
class ThrowInput:
    """One ``[[throws]]``: throw of a fault, for horizons that are still continuous. The youngest
    fault comes first. Give one of `throw_m`, `profile_m`, `elliptic_m`; see
    [tearing](guides/tearing.md).

    Attributes
    ----------
    fault
        The fault, as it is after extension and truncation.
    horizons
        Horizons that it moves. Left empty: all.
    throw_m
        The same throw everywhere; below 0 for a reverse fault.
    profile_m
        Distance along the mean strike, from the fault's first end by the right-hand rule, and
        throw.
    elliptic_m
        Largest throw of a fault that dies at its tips.
    half_length_m
        With `elliptic_m`: from the middle to the tips along strike. Left out: as the fault is.
    half_height_m
        With `elliptic_m`: from the middle to the upper and lower tip. Left out: throw does not
        change with elevation.
    centre_along_m
        With `elliptic_m`: distance along the mean strike at which throw is largest, from the
        fault's first end by the right-hand rule. Left out: the middle of the fault.
    centre_elevation_m
        With `half_height_m`: elevation at which throw is largest. Left out: the middle of the
        fault.
    hanging_wall
        Share of the throw by which the hanging wall moves down; the footwall moves up by the
        remainder.
    direction
        Whether walls move down the local dip of the fault, or everywhere across its mean strike.
    reach_m
        Distance across strike over which the movement dies away. Left out: never.
    """

    fault: str = key(values.text)
    horizons: tuple[str, ...] = key(values.names, default=())

    # exactly one of these three
    throw_m: float | None = key(values.number, unit="m", default=None)
    profile_m: tuple[tuple[float, float], ...] | None = key(values.profile, unit="m", default=None)
    elliptic_m: float | None = key(values.number, unit="m", default=None)

    # the ellipse; what is left out follows from the fault
    half_length_m: float | None = key(values.above_zero, unit="m", default=None)
    half_height_m: float | None = key(values.above_zero, unit="m", default=None)
    centre_along_m: float | None = key(values.number, unit="m", default=None)
    centre_elevation_m: float | None = key(values.number, unit="m", default=None)

    # how the throw is shared between the walls, and where it ends
    hanging_wall: float = key(values.share, default=1.0)
    direction: str = key(values.one_of(*DIRECTIONS), default="local")
    reach_m: float | None = key(values.above_zero, unit="m", default=None)

    @property
    def settings(self) -> FaultThrow:
        """The same as `Scene` takes it."""
        throw: Any = self.throw_m if self.profile_m is None else self.profile_m
        if self.elliptic_m is not None:
            from geosurf.sheets import EllipticThrow  # loaded by those who tear

            centre = self.centre_along_m, self.centre_elevation_m
            throw = EllipticThrow(self.elliptic_m, self.half_length_m, self.half_height_m, centre)
        words = self.reach_m, self.hanging_wall, self.direction
        return FaultThrow(self.fault, throw, self.horizons, *words)


@dataclass(frozen=True, kw_only=True)
class HorizonInput:
    """One ``[[horizons]]``: the youngest comes first.

    Attributes
    ----------
    name
        Name in all results.
    file
        `.gri` or `.irapasc` (IRAP), `.nc` (NetCDF), `.zmap` (ZMAP+), `.ts` (GOCAD), `.vtp` and
        other meshes; of horizons that are torn also `.poi`, `.xyz`, `.csv` and other points;
        relative to the scenario.
    positive
        Whether values are elevations or depths, for a file that does not declare it.
    length_unit
        Length unit of elevations, for a file that does not declare it; `ms` or `s` with `time`.
    columns
        Of a table with other headings: the columns x, y and z, by name or by number from 1. Sticks
        take two more: number of the stick, and name of the fault.
    decimal
        Decimal sign of a table.
    variable
        Which variable of a NetCDF file, where there are several.
    rule
        Which of two crossing horizons ends at the other, see [the column](guides/column.md).
    extend_m
        Continue the grid by the smoothest surface, to the box or area, at most this far from its
        data and not across faults. The report lists it, and maps hatch it.
    fill_holes
        Fill holes of the grid by the smoothest surface, not across faults. The report lists it.
        Points become a grid first.
    """

    name: str = key(values.text)
    file: Path | None = key(values.file)
    positive: str | None = key(values.direction, default=None)
    length_unit: str | None = key(values.length_unit, default=None)
    columns: tuple[str, ...] | tuple[int, ...] | None = key(values.columns, default=None)
    decimal: str = key(values.decimal, default=".")
    variable: str | None = key(values.text, default=None)
    # The rule decides which of two crossing horizons ends at the other.
    rule: str = key(values.one_of(*RULES, meant=rule_meant), default="conformable")

    # What is done to the grid before the model is built.
    extend_m: float | None = key(values.above_zero, unit="m", default=None)
    fill_holes: bool = key(values.switch, default=False)


@dataclass(frozen=True, kw_only=True)
class ModelInput:
    """``[model]``: a sealed model of another program, in place of `[[horizons]]` and `[[faults]]`.
    The report compares its regions with the units of geosurf.

    Attributes
    ----------
    file
        `.ml` (GOCAD Model3d); relative to the scenario. Its boundary is the model box.
    horizons
        Names of its horizons, youngest first. Left empty: as in the file.
    positive
        Whether values are elevations or depths, for a file that does not declare it.
    length_unit
        Length unit of elevations, for a file that does not declare it; `ms` or `s` with `time`.
    """

    file: Path = key(values.file)
    # The order of horizons is geology, which the file may not have.
    horizons: tuple[str, ...] = key(values.names, default=())
    positive: str | None = key(values.direction, default=None)
    length_unit: str | None = key(values.length_unit, default=None)


@dataclass(frozen=True, kw_only=True)
class TruncationInput:
    """One ``[[truncations]]``: a fault that ends at another one, or at a horizon. In any order.

    Attributes
    ----------
    fault
        The fault that is truncated.
    main
        The fault or horizon that it ends at.
    keep
        The part that stays: in the hanging wall or footwall of the main fault, right or left of the
        strike of a vertical one, or by its normal (`+` is where it points). At a horizon: below or
        above it. `both` splits an older fault at a younger one into two faults, such as `F2 (1)` on
        the side of the normal and `F2 (2)`.
    extend
        Whether the fault is first continued to the main one.
    """

    fault: str = key(values.text)
    main: str = key(values.text)
    keep: str = key(values.one_of(*KEEP, BOTH))
    extend: bool = key(values.switch, default=False)


@dataclass(frozen=True, kw_only=True)
class ContactInput:
    """One ``[[contacts]]``: fluid contacts, from the top down. They split units.

    Attributes
    ----------
    name
        `OWC`, `GOC` ... Several tables of one name are for blocks or zones.
    elevation_m
        Of a level contact, positive up. Give this or `file`.
    file
        A gridded contact, read like a horizon.
    block
        The block that it splits, by sides of faults, as in `F1+ F2-`. Left out: all blocks for
        which no other table of this name is given.
    zones
        Zones that it splits, as in `Top/Base`. Left empty: all zones of the reservoir for which no
        other table of this name is given.
    positive
        Whether values are elevations or depths, for a file that does not declare it.
    length_unit
        Length unit of elevations, for a file that does not declare it; `ms` or `s` with `time`.
    """

    name: str = key(values.text)
    # A level or a surface, one of both.
    elevation_m: float | None = key(values.number, unit="m", default=None)
    file: Path | None = key(values.file, default=None)
    # Where it counts; tables of one name complete each other.
    block: str | None = key(values.text, default=None)
    zones: tuple[str, ...] = key(values.names, default=())
    positive: str | None = key(values.direction, default=None)
    length_unit: str | None = key(values.length_unit, default=None)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """
    The content of a scenario file, checked: see docs/scenario.md for each key.

    Attributes
    ----------
    path : pathlib.Path
        The file it was read from.
    settings : tuple of str
        Keys that were set outside of the file, each ``key=value``.
    title
        Heading of the report.
    tolerance_m
        Largest vertical error of horizons, of which the model may have every k-th node. The report
        states what that changes. Left out: all nodes.
    positive
        Whether values are elevations or depths, in all files that do not declare it.
    length_unit
        Length unit of elevations, in all files that do not declare it; with `time` `ms` or `s`, for
        horizons and faults alone.
    time
        Horizons and faults are in time, which `[velocity]` turns into depth. See [time and
        depth](guides/time_and_depth.md).
    crs
        Coordinate reference system, such as `"EPSG:23031"`, of all files that do not declare it.
        Files that declare another are refused.
    reservoir
        Zones of the reservoir, as in `["Top/Middle"]`: contacts without `zones` split these, and
        tables and pictures show these. Left out: all zones between the first and the last horizon.
    regions
        Names of parts of the field that run through all zones: each with a place in it, sides of
        faults, or a polygon around it. Others have letters. See [regions](guides/regions.md).
    velocity
        With `time`: velocity of each zone, as in `"Top/Base" = 2800.0`, or average velocity from
        the datum to a horizon; `wells` is a file of checkshots, or `"tops"` for `[tops]`.
    compartments
        Faults that die inside the model and separate regions all the same: a virtual wall continues
        each to `"boundary"`, a fault, or the nearest of these (`"nearest"`). `true` stands for all
        faults. See [compartments](guides/compartments.md).
    zones
        Zones from thickness, see [zones from thickness](guides/zones.md): each makes a horizon,
        `base Upper` unless `base` or `top` names it.
    """

    path: Path
    settings: tuple[str, ...] = ()
    # What concerns the whole model.
    title: str = key(values.text, default="Reservoir model")
    tolerance_m: float | None = key(values.above_zero, unit="m", default=None)

    positive: str | None = key(values.direction, default=None)
    length_unit: str | None = key(values.length_unit, default=None)
    time: str | None = key(values.one_of(*WAYS), default=None)

    crs: str | None = key(values.text, default=None)

    reservoir: tuple[str, ...] | None = key(values.names, default=None)

    regions: dict[str, Any] | None = key(values.regions, default=None)

    velocity: dict[str, Any] | None = key(values.velocities, unit="m/s", default=None)

    # surfaces: horizons and faults, or a sealed model in their place
    horizons: tuple[HorizonInput, ...] = key(tables(HorizonInput), default=())
    faults: tuple[FaultInput, ...] = key(tables(FaultInput), default=())
    model: ModelInput | None = key(table(ModelInput), default=None)

    # what is done to them before the model is built
    truncations: tuple[TruncationInput, ...] = key(tables(TruncationInput), default=())
    network: NetworkInput = key(table(NetworkInput), default=NetworkInput())
    compartments: bool | dict[str, Any] = key(values.compartments, default=False)
    tear: TearSettings | None = key(table(TearSettings), default=None)
    throws: tuple[ThrowInput, ...] = key(tables(ThrowInput), default=())

    zones: dict[str, Any] | None = key(zones_by_name, default=None)

    # what is built, and where
    contacts: tuple[ContactInput, ...] = key(tables(ContactInput), default=())
    tops: TopsInput | None = key(table(TopsInput), default=None)
    wells: WellsInput | None = key(table(WellsInput), default=None)
    slivers: SliversInput = key(table(SliversInput), default=SliversInput())
    volumetrics: FluidsInput | None = key(table(FluidsInput), default=None)
    seal: SealInput | None = key(table(SealInput), default=None)
    grid: GridInput | None = key(table(GridInput), default=None)
    aoi: AreaOfInterest | None = key(table(AreaOfInterest), default=None)
    box: BoxRanges | None = key(table(BoxRanges), default=None)
    ensemble: EnsembleSettings | None = key(table(EnsembleSettings), default=None)
    uncertain: tuple[UncertainInput, ...] = key(tables(UncertainInput), default=())
    search: SearchSettings = key(table(SearchSettings), default=SearchSettings())
    output: OutputSettings = key(table(OutputSettings), default=OutputSettings())

    pictures: PictureSettings = key(table(PictureSettings), default=PictureSettings())

    @property
    def horizon_names(self) -> tuple[str, ...]:
        """Names of the horizons, youngest first."""
        return tuple(entry.name for entry in self.horizons)

    @property
    def fault_names(self) -> tuple[str, ...]:
        """Names of the faults."""
        return tuple(entry.name for entry in self.faults)

    @property
    def zone_names(self) -> list[str]:
        """Names of the zones, youngest first."""
        return names_of_zones(self.horizon_names)

    @property
    def heading(self) -> str:
        """The title, and after it the keys that were set outside of the file."""
        return f"{self.title} ({', '.join(self.settings)})" if self.settings else self.title
