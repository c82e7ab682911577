"""Every key of a scenario: its type, unit, default and meaning, stated once.

The parser reads these dataclasses, and so does the page docs/scenario.md, so that
neither can know a key that the other does not.
"""
# ruff: noqa: RUF009 - `key` makes a dataclasses.field

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.conventions import METRES_PER_UNIT
from geosurf.faults.rules import BOTH, KEEP
from geosurf.model import RULES
from geosurf.model.slivers import SliverSettings
from geosurf.model.tops import RANGE, TOLERANCE, TieSettings
from geosurf.scenario import values
from geosurf.scenario.declare import key
from geosurf.scenario.ensemble_keys import EnsembleSettings, UncertainInput
from geosurf.scenario.fault_keys import (
    FaultInput,
    NetworkInput,
    columns_key,
    decimal_key,
    length_unit_key,
    positive_key,
)
from geosurf.scenario.output_keys import (
    FORMATS,
    VIEWS,
    OutputSettings,
    PictureSettings,
    SearchSettings,
)
from geosurf.scenario.tables import table, tables
from geosurf.sheets.faults import DIRECTIONS

# ---- area keys ----------------------------------------
# Keys of a scenario that limit the model: ``[aoi]`` and ``[box]``.


@dataclass(frozen=True, kw_only=True)
class AreaOfInterest:
    """``[aoi]``: a polygon that the model fills.

    Leave the table out for the box, or without a box for the outline that all horizons share.
    """

    file: Path | None = key(
        "A closed polygon, `.pol` or `.csv`. Give one of these keys.", values.file, default=None
    )
    corners_m: tuple[tuple[float, float], ...] | None = key(
        "Easting and northing around the polygon.", values.corners, unit="m", default=None
    )
    rectangle: bool = key(
        "Whether to take the largest axis-parallel rectangle that all horizons cover.",
        values.switch, default=False,
    )  # fmt: skip

    @property
    def value(self) -> Any:
        """The area as `Scene` takes it."""
        # Exactly one of the three is set: `validate` has seen to it.
        return "rectangle" if self.rectangle else self.file or self.corners_m


@dataclass(frozen=True, kw_only=True)
class BoxRanges:
    """``[box]``: the model box. Leave the table out for the outline that all horizons share."""

    easting_m: tuple[float, float] = key("West and east side.", values.interval, unit="m")
    northing_m: tuple[float, float] = key("South and north side.", values.interval, unit="m")
    elevation_m: tuple[float, float] = key(
        "Bottom and top, positive up.", values.interval, unit="m"
    )

    @property
    def sides(self) -> tuple[float, float, float, float, float, float]:
        """West, east, south, north, bottom, top [m]."""
        # The order of `Scene(box=)`.
        return (*self.easting_m, *self.northing_m, *self.elevation_m)


# ---- grid keys ----------------------------------------
# Keys of a scenario about its simulation grid: ``[grid]``.


@dataclass(frozen=True, kw_only=True)
class GridInput:
    """``[grid]``: a corner-point grid for flow simulators, written as `grid.grdecl` and `grid.inc`.
    See [simulation grids](guides/simulation_grids.md).
    """

    cell_m: float | tuple[float, float] = key(
        "Size of the cells, about: whole numbers of them fill the area.",
        values.cell,
        unit="m",
        default=100.0,
    )
    layers: int | dict[str, Any] = key(
        "Layers of each zone between two horizons, or by zone.", values.layers, default=10
    )
    min_dip: float = key(
        "Pillars follow faults that dip at least this; others are stair-steps.",
        values.dip,
        unit="degrees",
        default=15.0,
    )


# ---- sliver keys ----------------------------------------
# Keys of a scenario about units that are too small to count: ``[slivers]``.


@dataclass(frozen=True, kw_only=True)
class SliversInput:
    """``[slivers]``: units that are too small to count. Tables and legends list them apart. See
    [the column](guides/column.md).
    """

    min_volume_m3: float | None = key(
        "Units below this volume are slivers. Left out: units below 1/10 000 of their zone.",
        values.not_negative,
        unit="m³",
        default=None,
    )
    merge: bool = key(
        "Whether each is merged into the neighbour with the largest shared area. The certificate "
        "lists them.",
        values.switch,
        default=False,
    )

    @property
    def settings(self) -> SliverSettings:
        """The same as `Scene` takes it."""
        # The same class as for `Scene(slivers=)`, so that both follow one rule.
        return SliverSettings(self.min_volume_m3, self.merge)


# ---- well keys ----------------------------------------
# The keys of ``[wells]``.


@values.check('a list of files such as ["W1.dev", "W2.dev"], relative to the scenario')
def listed_files(at: values.KeyPath, value: Any) -> tuple[Path, ...] | None:
    """Files, each once."""
    if not isinstance(value, list) or not value or any(value.count(one) > 1 for one in value):
        return None
    return tuple(values.file(at.inside(str(k + 1)), one) for k, one in enumerate(value))


@dataclass(frozen=True, kw_only=True)
class WellsInput:
    """``[wells]``: paths of wells. They are drawn on all pictures, and `wells.csv` has the units
    that each goes through. See [file formats](formats.md#paths-of-wells).
    """

    files: tuple[Path, ...] = key(
        "Well traces of Petrel, wells of RMS or ResInsight, LAS, or tables; each may have several "
        "wells.",
        listed_files,
    )
    heads: Path | None = key(
        "A table with `Well`, `X`, `Y` and `KB` (elevation of the drill floor), for wells that "
        "have measured depths and directions only.",
        values.file,
        default=None,
    )
    positive: str | None = positive_key()
    length_unit: str | None = length_unit_key()


# ---- tear keys ----------------------------------------
# Of all keys: ``[tear]`` and ``[[throws]]``, which tear horizons at their faults.


@dataclass(frozen=True, kw_only=True)
class TearSettings:
    """``[tear]``: horizons that were picked or gridded across their faults are torn there. The
    report has the details. Leave the table out for horizons as they are. See
    [tearing](guides/tearing.md).
    """

    horizons: tuple[str, ...] = key("Horizons to tear. Left empty: all.", values.names, default=())
    trim_cells: str | float | dict[str, Any] = key(
        "Ignore data closer to a fault than this: at least one and a half times the half width of "
        "the smear. By default it is estimated for each fault from data that are held out.",
        values.trim,
        unit="cells of the grid",
        default="auto",
    )
    noise_m: float | None = key(
        "Standard deviation of the noise; 0 to meet all other data. Left out: estimated.",
        values.not_negative,
        unit="m",
        default=None,
    )
    fill_empty_blocks: bool | str | dict[str, Any] = key(
        "What becomes of horizons in blocks without data: `false` refuses, `true` continues them "
        'from the neighbouring block, `"lower"` and `"upper"` pinch them out onto the horizon '
        "below or above.",
        values.filling,
        default=False,
    )


@dataclass(frozen=True, kw_only=True)
class ThrowInput:
    """One ``[[throws]]``: throw of a fault, for horizons that are still continuous. The youngest
    fault comes first. Give one of `throw_m`, `profile_m`, `elliptic_m`; see
    [tearing](guides/tearing.md).
    """

    fault: str = key("The fault, as it is after extension and truncation.", values.text)
    horizons: tuple[str, ...] = key(
        "Horizons that it moves. Left empty: all.", values.names, default=()
    )

    # exactly one of these three
    throw_m: float | None = key(
        "The same throw everywhere; below 0 for a reverse fault.",
        values.number,
        unit="m",
        default=None,
    )
    profile_m: tuple[tuple[float, float], ...] | None = key(
        "Distance along the mean strike, from the fault's first end by the right-hand rule, and "
        "throw.",
        values.profile,
        unit="m",
        default=None,
    )
    elliptic_m: float | None = key(
        "Largest throw of a fault that dies at its tips.", values.number, unit="m", default=None
    )

    # the ellipse; what is left out follows from the fault
    half_length_m: float | None = key(
        "With `elliptic_m`: from the middle to the tips along strike. Left out: as the fault is.",
        values.above_zero,
        unit="m",
        default=None,
    )
    half_height_m: float | None = key(
        "With `elliptic_m`: from the middle to the upper and lower tip. Left out: throw does not "
        "change with elevation.",
        values.above_zero,
        unit="m",
        default=None,
    )
    centre_along_m: float | None = key(
        "With `elliptic_m`: distance along the mean strike at which throw is largest, from the "
        "fault's first end by the right-hand rule. Left out: the middle of the fault.",
        values.number,
        unit="m",
        default=None,
    )
    centre_elevation_m: float | None = key(
        "With `half_height_m`: elevation at which throw is largest. Left out: the middle of the "
        "fault.",
        values.number,
        unit="m",
        default=None,
    )

    # how the throw is shared between the walls, and where it ends
    hanging_wall: float = key(
        "Share of the throw by which the hanging wall moves down; the footwall moves up by the "
        "remainder.",
        values.share,
        default=1.0,
    )
    direction: str = key(
        "Whether walls move down the local dip of the fault, or everywhere across its mean strike.",
        values.one_of(*DIRECTIONS),
        default="local",
    )
    reach_m: float | None = key(
        "Distance across strike over which the movement dies away. Left out: never.",
        values.above_zero,
        unit="m",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class HorizonInput:
    """One ``[[horizons]]``: the youngest comes first."""

    name: str = key("Name in all results.", values.text)
    file: Path = key(
        "`.gri` or `.irapasc` (IRAP), `.nc` (NetCDF), `.zmap` (ZMAP+), `.ts` (GOCAD), `.vtp` and "
        "other meshes; of horizons that are torn also `.poi`, `.xyz`, `.csv` and other points; "
        "relative to the scenario.",
        values.file,
    )
    positive: str | None = positive_key()
    length_unit: str | None = length_unit_key()
    columns: tuple[str, ...] | tuple[int, ...] | None = columns_key()
    decimal: str = decimal_key()
    variable: str | None = key(
        "Which variable of a NetCDF file, where there are several.", values.text, default=None
    )
    # The rule decides which of two crossing horizons ends at the other.
    rule: str = key(
        "Which of two crossing horizons ends at the other, see [the column](guides/column.md).",
        values.one_of(*RULES),
        default="conformable",
    )

    # What is done to the grid before the model is built.
    extend_m: float | None = key(
        "Continue the grid by the smoothest surface, to the box or area, at most this far from its "
        "data and not across faults. The report lists it, and maps hatch it.",
        values.above_zero,
        unit="m",
        default=None,
    )
    fill_holes: bool = key(
        "Fill holes of the grid by the smoothest surface, not across faults. The report lists it.",
        values.switch,
        default=False,
    )


@dataclass(frozen=True, kw_only=True)
class ModelInput:
    """``[model]``: a sealed model of another program, in place of `[[horizons]]` and `[[faults]]`.
    The report compares its regions with the units of geosurf.
    """

    file: Path = key(
        "`.ml` (GOCAD Model3d); relative to the scenario. Its boundary is the model box.",
        values.file,
    )
    # The order of horizons is geology, which the file may not have.
    horizons: tuple[str, ...] = key(
        "Names of its horizons, youngest first. Left empty: as in the file.",
        values.names,
        default=(),
    )
    positive: str | None = positive_key()
    length_unit: str | None = length_unit_key()


@dataclass(frozen=True, kw_only=True)
class TruncationInput:
    """One ``[[truncations]]``: a fault that ends at another one, or at a horizon. In any order."""

    fault: str = key("The fault that is truncated.", values.text)
    main: str = key("The fault or horizon that it ends at.", values.text)
    keep: str = key(
        "The part that stays: in the hanging wall or footwall of the main fault, right or left of "
        "the strike of a vertical one, or by its normal (`+` is where it points). At a horizon: "
        "below or above it. `both` splits an older fault at a younger one into two faults, such as "
        "`F2 (1)` on the side of the normal and `F2 (2)`.",
        values.one_of(*KEEP, BOTH),
    )
    extend: bool = key(
        "Whether the fault is first continued to the main one.", values.switch, default=False
    )


@dataclass(frozen=True, kw_only=True)
class ContactInput:
    """One ``[[contacts]]``: fluid contacts, from the top down. They split units."""

    name: str = key(
        "`OWC`, `GOC` ... Several tables of one name are for blocks or zones.", values.text
    )
    # A level or a surface, one of both.
    elevation_m: float | None = key(
        "Of a level contact, positive up. Give this or `file`.",
        values.number,
        unit="m",
        default=None,
    )
    file: Path | None = key("A gridded contact, read like a horizon.", values.file, default=None)
    # Where it counts; tables of one name complete each other.
    block: str | None = key(
        "The block that it splits, by sides of faults, as in `F1+ F2-`. Left out: all blocks for "
        "which no other table of this name is given.",
        values.text,
        default=None,
    )
    zones: tuple[str, ...] = key(
        "Zones that it splits, as in `Top/Base`. Left empty: all zones for which no other table of "
        "this name is given.",
        values.names,
        default=(),
    )
    positive: str | None = positive_key()
    length_unit: str | None = length_unit_key()


@dataclass(frozen=True, kw_only=True)
class TopsInput:
    """``[tops]``: well tops. The report lists the misfit of each. See
    [well tops](guides/well_tops.md).
    """

    file: Path = key(
        "Petrel well tops, RMS points with attributes, or a table; relative to the scenario.",
        values.file,
    )
    positive: str | None = positive_key()
    length_unit: str | None = length_unit_key()
    # Comparing is the default: a tie changes the data.
    tie: bool = key(
        "Whether horizons are corrected smoothly so that they meet their tops.",
        values.switch,
        default=False,
    )
    range_m: float | None = key(
        "With `tie`: distance from a well beyond which it changes nothing. Left out: 1000 m.",
        values.above_zero,
        unit="m",
        default=None,
    )
    tolerance_m: float = key(
        "With `tie`: largest misfit after it.", values.above_zero, unit="m", default=TOLERANCE
    )

    @property
    def settings(self) -> TieSettings | None:
        """How to tie; None if nothing is tied."""
        if not self.tie:
            return None
        # The third argument records that nobody chose the range, for a warning.
        reach = RANGE if self.range_m is None else self.range_m
        return TieSettings(reach, self.tolerance_m, self.range_m is None)


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
    title : str
    tolerance_m : float or None
    positive, length_unit, crs : str or None
        Of files that do not declare them.
    horizons : tuple of HorizonInput
        Youngest first.
    faults : tuple of FaultInput
    model : ModelInput or None
    truncations : tuple of TruncationInput
    network : NetworkInput
    compartments : bool or dict of str to object
    tear : TearSettings or None
    throws : tuple of ThrowInput
        Youngest fault first.
    contacts : tuple of ContactInput
        From the top down.
    tops : TopsInput or None
    wells : WellsInput or None
    slivers : SliversInput
    grid : GridInput or None
    aoi : AreaOfInterest or None
    box : BoxRanges or None
    ensemble : EnsembleSettings or None
    uncertain : tuple of UncertainInput
    search : SearchSettings
    output : OutputSettings
    pictures : PictureSettings
    """

    path: Path
    settings: tuple[str, ...] = ()
    # What concerns the whole model.
    title: str = key("Heading of the report.", values.text, default="Reservoir model")
    tolerance_m: float | None = key(
        "Largest vertical error of horizons, of which the model may have every k-th node. The "
        "report states what that changes. Left out: all nodes.",
        values.above_zero,
        unit="m",
        default=None,
    )

    positive: str | None = key(
        "Whether values are elevations or depths, in all files that do not declare it.",
        values.one_of("up", "down"),
        default=None,
    )
    length_unit: str | None = key(
        "Length unit of elevations, in all files that do not declare it.",
        values.one_of(*METRES_PER_UNIT),
        default=None,
    )

    crs: str | None = key(
        'Coordinate reference system, such as `"EPSG:23031"`, of all files that do not declare it. '
        "Files that declare another are refused.",
        values.text,
        default=None,
    )

    # surfaces: horizons and faults, or a sealed model in their place
    horizons: tuple[HorizonInput, ...] = key("Youngest first.", tables(HorizonInput), default=())
    faults: tuple[FaultInput, ...] = key("In any order.", tables(FaultInput), default=())
    model: ModelInput | None = key(
        "A sealed model of another program.", table(ModelInput), default=None
    )

    # what is done to them before the model is built
    truncations: tuple[TruncationInput, ...] = key(
        "Faults that end at others.", tables(TruncationInput), default=()
    )
    network: NetworkInput = key(
        "Proposals for the fault network.", table(NetworkInput), default=NetworkInput()
    )
    compartments: bool | dict[str, Any] = key(
        "Faults that die inside the model and separate regions all the same: a virtual wall "
        'continues each to `"boundary"`, a fault, or the nearest of these (`"nearest"`). `true` '
        "stands for all faults. See [compartments](guides/compartments.md).",
        values.compartments,
        default=False,
    )
    tear: TearSettings | None = key(
        "Horizons torn as they were picked.", table(TearSettings), default=None
    )
    throws: tuple[ThrowInput, ...] = key(
        "Throw of faults, youngest first.", tables(ThrowInput), default=()
    )

    # what is built, and where
    contacts: tuple[ContactInput, ...] = key("From the top down.", tables(ContactInput), default=())
    tops: TopsInput | None = key("Well tops.", table(TopsInput), default=None)
    wells: WellsInput | None = key("Paths of wells.", table(WellsInput), default=None)
    slivers: SliversInput = key(
        "Units that are too small to count.", table(SliversInput), default=SliversInput()
    )
    grid: GridInput | None = key("A simulation grid.", table(GridInput), default=None)
    aoi: AreaOfInterest | None = key(
        "A polygon that the model fills.", table(AreaOfInterest), default=None
    )
    box: BoxRanges | None = key("The model box.", table(BoxRanges), default=None)
    ensemble: EnsembleSettings | None = key(
        "Many realisations.", table(EnsembleSettings), default=None
    )
    uncertain: tuple[UncertainInput, ...] = key(
        "What varies in an ensemble.", tables(UncertainInput), default=()
    )
    search: SearchSettings = key(
        "How candidates are found.", table(SearchSettings), default=SearchSettings()
    )
    output: OutputSettings = key(
        "Which pictures and files are made.", table(OutputSettings), default=OutputSettings()
    )

    pictures: PictureSettings = key(
        "What pictures look like.", table(PictureSettings), default=PictureSettings()
    )

    @property
    def heading(self) -> str:
        """The title, and after it the keys that were set outside of the file."""
        return f"{self.title} ({', '.join(self.settings)})" if self.settings else self.title


__all__ = [
    "FORMATS",
    "VIEWS",
    "AreaOfInterest",
    "BoxRanges",
    "ContactInput",
    "EnsembleSettings",
    "FaultInput",
    "GridInput",
    "HorizonInput",
    "ModelInput",
    "OutputSettings",
    "PictureSettings",
    "Scenario",
    "SearchSettings",
    "SliversInput",
    "TearSettings",
    "ThrowInput",
    "TopsInput",
    "TruncationInput",
    "UncertainInput",
    "WellsInput",
]
