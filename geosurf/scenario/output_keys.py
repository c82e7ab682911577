"""Keys of a scenario on what a run makes: ensembles, pictures, files, grids, wells."""
# ruff: noqa: RUF009 - `key` makes a dataclasses.field

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.conventions import is_number
from geosurf.errors import DependencyError, InputError
from geosurf.measure.velocity import DATUM
from geosurf.model.distributions import Normal, Triangular, Uniform
from geosurf.model.tops import RANGE, TOLERANCE, TieSettings
from geosurf.model.units import INCLUDE
from geosurf.render.picture_style import COLOUR_BY, THEMES, PictureStyle
from geosurf.render.views import VIEWS
from geosurf.scenario import values
from geosurf.scenario.values import key

# ---- ensemble keys ----------------------------------------
# The keys of ``[ensemble]`` and ``[[uncertain]]``: what `run_ensemble` varies in a scenario.


# What kind of names each uncertainty takes, for the check and for its message.
KINDS = {  # what `of` names
    "depth shift": "horizons",
    "depth error": "horizons",
    "contact shift": "contacts",
    "contact level": "contacts",
    "throw": "faults",
    "throw factor": "faults",
    "fault position": "faults",
    "fault dip": "faults",
    "velocity factor": "velocities",
}
DISTRIBUTIONS: dict[str, Any] = {"normal": Normal, "uniform": Uniform, "triangular": Triangular}
COUNTS = {"normal": (2, 4), "uniform": (2,), "triangular": (3,)}  # of the numbers of each


def _numbers(kind: str) -> values.Check:
    """Return the check for the numbers of a distribution."""
    counts = COUNTS[kind]

    @values.check(f"{' or '.join(map(str, counts))} numbers")
    def numbers(_: values.KeyPath, value: Any) -> tuple[float, ...] | None:
        """The numbers as a tuple."""
        # Lists only: a single number would be ambiguous.
        fits = isinstance(value, list) and len(value) in counts and all(map(is_number, value))
        return tuple(map(float, value)) if fits else None

    return numbers


@dataclass(frozen=True, kw_only=True)
class EnsembleSettings:
    """``[ensemble]``: how many realisations `geosurf ensemble` builds. See
    [ensembles](guides/ensembles.md).

    Attributes
    ----------
    n
        Number of realisations.
    seed
        Seed of all random numbers.
    map_cell_m
        Width of the cells of maps of probability and thickness. Left out: no maps.
    """

    n: int = key(values.count, default=100)
    seed: int = key(values.seed, default=0)
    map_cell_m: float | None = key(values.above_zero, unit="m", default=None)


@dataclass(frozen=True, kw_only=True)
class UncertainInput:
    """One ``[[uncertain]]``: what varies in an ensemble. Give one of `normal`, `uniform` and
    `triangular`, or `sd_m` and `range_m` for a depth error. Units are metres, degrees for a dip,
    and 1 for a factor.

    Attributes
    ----------
    kind
        What is uncertain.
    of
        Names of the horizons, contacts, faults or entries of `[velocity]`, which vary together. One
        for a contact or throw. Left empty: all of them.
    normal
        Mean and standard deviation; if it is cut off, also the lowest and highest value.
    uniform
        Lowest and highest value.
    triangular
        Lowest, most likely and highest value.
    sd_m
        With a depth error: its standard deviation.
    range_m
        With a depth error: distance at which its correlation has fallen to 5 %.
    model
        With a depth error: its covariance.
    meet_tops
        With a depth error: whether it meets the well tops of `[tops]`.
    """

    kind: str = key(values.one_of(*KINDS))
    of: tuple[str, ...] = key(values.names, default=())
    normal: tuple[float, ...] | None = key(_numbers("normal"), default=None)
    uniform: tuple[float, ...] | None = key(_numbers("uniform"), default=None)
    triangular: tuple[float, ...] | None = key(_numbers("triangular"), default=None)
    sd_m: float | None = key(values.above_zero, unit="m", default=None)
    range_m: float | None = key(values.above_zero, unit="m", default=None)
    model: str = key(values.one_of("gaussian", "exponential", "spherical"), default="gaussian")
    meet_tops: bool = key(values.switch, default=True)


def distribution_of(entry: UncertainInput) -> Normal | Uniform | Triangular | None:
    """Return the distribution of an uncertain input; a depth error has none.

    Examples
    --------
    >>> distribution_of(UncertainInput(kind="fault dip", uniform=(-2.0, 2.0)))
    Uniform(low=-2.0, high=2.0)
    """
    for word, made in DISTRIBUTIONS.items():
        if getattr(entry, word) is not None:
            result: Normal | Uniform | Triangular | None = made(*getattr(entry, word))
            return result
    return None


def check_uncertain(scenario: Any, at: values.KeyPath) -> None:
    """Refuse uncertainties that contradict themselves, or name what does not exist."""
    # A sealed model has no data that could vary.
    if scenario.uncertain and scenario.model is not None:
        at.of("uncertain").note(
            "[[uncertain]] cannot be combined with [model]. Remove one of them."
        )
        return

    # Names as the scenario has them, by the table that they come from.
    kinds = dict.fromkeys(KINDS.values())
    known = {kind: [one.name for one in getattr(scenario, kind, ())] for kind in kinds}
    known["velocities"] = [name for name in scenario.velocity or () if name != DATUM]
    for row, entry in enumerate(scenario.uncertain):
        label = f"uncertain[number {row + 1}]"
        with at.of(label).noting() as place:
            _check_one(scenario, entry, known[KINDS[entry.kind]], label, place)


def _check_one(
    scenario: Any, entry: UncertainInput, known: list[str], label: str, at: values.KeyPath
) -> None:
    """Refuse an uncertainty that contradicts itself, or names what does not exist."""
    # Names first: later messages use them.
    for name in entry.of:
        at.inside("of").refuse_unknown(label, f"name of {KINDS[entry.kind]}", name, known)
    given = [word for word in DISTRIBUTIONS if getattr(entry, word) is not None]

    # A depth error is a random field, which has no single distribution.
    if entry.kind == "depth error":
        if given or entry.sd_m is None or entry.range_m is None:
            at.refuse(f"{label}: a depth error takes sd_m and range_m; give both, alone.")
        return
    if entry.sd_m is not None or entry.range_m is not None:
        at.refuse(f"{label}: sd_m and range_m are of a depth error; remove them.")

    # One distribution, neither none nor several.
    if len(given) != 1:
        at.refuse(f"{label}: give exactly one of {', '.join(DISTRIBUTIONS)}.")
    try:
        distribution_of(entry)
    except InputError as error:
        at.inside(given[0]).refuse(f"{label}.{given[0]}: {error}")

    # Contacts and throws differ in size: one number cannot be added to several.
    if entry.kind.startswith(("contact", "throw")) and len(entry.of) != 1:
        at.inside("of").refuse(f'{label}: a {entry.kind} has one name, as in of = ["F1"].')
    # The uncertainty changes the throw that the scenario gives.
    if entry.kind.startswith("throw") and not _has_throw(scenario, entry):
        at.refuse(f"{label}: {_no_throw(scenario, entry)}")


def _has_throw(scenario: Any, entry: UncertainInput) -> bool:
    """Whether a throw is given that the uncertainty changes."""
    # Several tables may be about one fault, each for its own horizons.
    mine = [one for one in scenario.throws if one.fault == entry.of[0]]
    return bool(mine) and (entry.kind != "throw" or all(t.throw_m is not None for t in mine))


def _no_throw(scenario: Any, entry: UncertainInput) -> str:
    """Why a throw cannot vary, and what to do."""
    fault, form = entry.of[0], "throw_m" if entry.kind == "throw" else "throw"
    # [tear] reads throws off the data: a table of [[throws]] would tear the horizons twice
    if scenario.tear is not None and not any(one.fault == fault for one in scenario.throws):
        return (
            f"horizons are torn at fault {fault!r} by [tear], so their data determine its throw. "
            'Vary the fault instead: kind = "fault position" or "fault dip". For continuous '
            f"horizons that [tear] leaves out, give {form} in [[throws]]."
        )
    return f"fault {fault!r} has no {form} in [[throws]]. Add it there."


# Functions, because a dataclass field cannot be used twice.
# ---- grid keys ----------------------------------------
# Keys of a scenario about its simulation grid: ``[grid]``.


@dataclass(frozen=True, kw_only=True)
class GridInput:
    """``[grid]``: a corner-point grid for flow simulators, written as `grid.grdecl` and `grid.inc`.
    See [simulation grids](guides/simulation_grids.md).

    Attributes
    ----------
    cell_m
        Size of the cells, about: whole numbers of them fill the area.
    layers
        Layers of each zone of the reservoir, or by zone.
    min_dip
        Pillars follow faults that dip at least this; others are stair-steps.
    """

    cell_m: float | tuple[float, float] = key(values.cell, unit="m", default=100.0)
    layers: int | dict[str, Any] = key(values.layers, default=10)
    min_dip: float = key(values.dip, unit="degrees", default=15.0)


# ---- volumetrics keys ----------------------------------------
# The keys of ``[volumetrics]``.


def _leaves(at: values.KeyPath, value: Any, leaf: Callable[[values.KeyPath, Any], Any]) -> Any:
    """A value, or a table of these by the words of each: names in tables inside it add up."""
    # names have numbers or tables, distributions have lists
    if not isinstance(value, dict) or isinstance(next(iter(value.values()), 0), list):
        return leaf(at, value)
    leaves: dict[tuple[str, ...], Any] = {}
    for word, inner in value.items():
        inner_leaves = _leaves(at.inside(word), inner, leaf)
        if inner_leaves is None:
            return None
        many = inner_leaves if isinstance(inner_leaves, dict) else {(): inner_leaves}
        leaves |= {(word, *words): last for words, last in many.items()}
    return leaves or None


@values.check(
    "a number, the file of a grid, a distribution such as {normal = [0.25, 0.02]}, or a table of "
    "these by zone, region, contact interval or fluid, such as "
    '`{"Top/Base" = 0.25, elsewhere = 0.2}` or `{"Top/Base" = {oil = 0.25, gas = 0.22}}`'
)
def ratio(at: values.KeyPath, value: Any) -> Any:
    """Numbers, files and distributions, by names that are checked when all units are known."""

    def leaf(at: values.KeyPath, value: Any) -> Any:
        if isinstance(value, dict):
            return _drawn(at, value)
        return values.file(at, value) if isinstance(value, str) else values.number(at, value)

    return _leaves(at, value, leaf)


def _drawn(at: values.KeyPath, value: dict[str, Any]) -> Any:
    """The distribution of one number; None for another table."""
    word, numbers = next(iter(value.items()))
    if len(value) > 1 or word not in DISTRIBUTIONS:
        return None
    made = _numbers(word)(at.inside(word), numbers)
    try:
        return DISTRIBUTIONS[word](*made)
    except InputError as error:
        at.inside(word).refuse(f"{at.words}: {error}")


@values.check('"oil", "gas" or "water", or a table such as `{"above FWL" = "oil"}`')
def fluids(at: values.KeyPath, value: Any) -> Any:
    """Fluids of units."""
    return _leaves(at, value, values.text)


@dataclass(frozen=True, kw_only=True)
class FluidsInput:
    """``[volumetrics]``: rock and fluids in place, as `volumetrics.csv` and in the report, and of
    each realisation in `geosurf ensemble`. Each of the first four keys needs those before it. A
    distribution, as `{normal = [0.25, 0.02]}`, counts by its median elsewhere than in ensembles.
    See [volumetrics](guides/volumetrics.md).

    Attributes
    ----------
    net_to_gross
        Share of net rock.
    porosity
        Share of pores in net rock.
    water_saturation
        Share of water in the pores.
    formation_volume_factor
        Volume in the reservoir over volume at the surface, of oil or gas.
    fluids
        What units hold, where contacts are not called `OWC`, `GOC` or `GWC`.
    units
        `metric`: m³ and Sm³. `field`: acre-ft, bbl, stb and scf.
    """

    net_to_gross: Any = key(ratio)
    porosity: Any = key(ratio, default=None)
    water_saturation: Any = key(ratio, default=None)
    formation_volume_factor: Any = key(ratio, default=None)
    fluids: Any = key(fluids, default=None)
    units: str = key(values.one_of("metric", "field"), default="metric")


# ---- well keys ----------------------------------------
# The keys of ``[wells]``.


@values.check('a list of files such as ["W1.dev", "W2.dev"], relative to the scenario')
def listed_files(at: values.KeyPath, value: Any) -> tuple[Path, ...] | None:
    """Files, each once."""
    if not isinstance(value, list) or not value or any(value.count(one) > 1 for one in value):
        return None
    return tuple(values.file(at.inside(str(k + 1)), one) for k, one in enumerate(value))


@dataclass(frozen=True, kw_only=True)
class TopsInput:
    """``[tops]``: well tops. The report lists the misfit of each. See
    [well tops](guides/well_tops.md).

    Attributes
    ----------
    file
        Petrel well tops, RMS points with attributes, or a table; relative to the scenario.
    positive
        Whether values are elevations or depths, for a file that does not declare it.
    length_unit
        Length unit of elevations, for a file that does not declare it; `ms` or `s` with `time`.
    tie
        Whether horizons are corrected smoothly so that they meet their tops.
    range_m
        With `tie`: distance from a well beyond which it changes nothing. Left out: 1000 m.
    tolerance_m
        With `tie`: largest misfit after it.
    """

    file: Path = key(values.file)
    positive: str | None = key(values.direction, default=None)
    length_unit: str | None = key(values.length_unit, default=None)
    # Comparing is the default: a tie changes the data.
    tie: bool = key(values.switch, default=False)
    range_m: float | None = key(values.above_zero, unit="m", default=None)
    tolerance_m: float = key(values.above_zero, unit="m", default=TOLERANCE)

    @property
    def settings(self) -> TieSettings | None:
        """How to tie; None if nothing is tied."""
        if not self.tie:
            return None
        # The third argument records that nobody chose the range, for a warning.
        reach = RANGE if self.range_m is None else self.range_m
        return TieSettings(reach, self.tolerance_m, self.range_m is None)


@dataclass(frozen=True, kw_only=True)
class WellsInput:
    """``[wells]``: paths of wells. They are drawn on all pictures, and `wells.csv` has the units
    that each goes through. See [file formats](formats.md#paths-of-wells).

    Attributes
    ----------
    files
        Well traces of Petrel, wells of RMS or ResInsight, LAS, or tables; each may have several
        wells.
    heads
        A table with `Well`, `X`, `Y` and `KB` (elevation of the drill floor), for wells that have
        measured depths and directions only.
    positive
        Whether values are elevations or depths, for a file that does not declare it.
    length_unit
        Length unit of elevations, for a file that does not declare it; `ms` or `s` with `time`.
    """

    files: tuple[Path, ...] = key(listed_files)
    heads: Path | None = key(values.file, default=None)
    positive: str | None = key(values.direction, default=None)
    length_unit: str | None = key(values.length_unit, default=None)


# ---- picture keys ----------------------------------------
# The keys of ``[pictures]``: what pictures look like.


@values.check("azimuth and height of the viewer in degrees: [225, 30]")
def angles(at: values.KeyPath, value: Any) -> tuple[float, float] | None:
    """Two angles, the second from -90 to 90."""
    if not isinstance(value, list) or len(value) != 2:
        return None
    azimuth, height = (values.number(at, angle) for angle in value)
    return (azimuth, height) if -90.0 <= height <= 90.0 else None


@values.check('a table of names and colours such as {Top = "teal", F1 = "#8c2f2b"}')
def colours(at: values.KeyPath, value: Any) -> Mapping[str, Any] | None:
    """Colours by the name of a surface, zone or unit."""
    return _styled(at, "colours", value) if isinstance(value, dict) else None


@values.check("the name of a font that is installed")
def font(at: values.KeyPath, value: Any) -> str | None:
    """A font for names in other scripts."""
    return _styled(at, "font", value) if isinstance(value, str) else None


@values.check('"elevation", "thickness" or a colour map of matplotlib such as "viridis"')
def colour_map(at: values.KeyPath, value: Any) -> str | None:
    """A colour map."""
    return _styled(at, "colour_map", value) if isinstance(value, str) else None


@values.check('a table of names and files such as {Licence = "licence.pol"}')
def files(at: values.KeyPath, value: Any) -> dict[str, Path] | None:
    """Files by the name that pictures give to them."""
    if not isinstance(value, dict) or not value:
        return None
    return {name: values.file(at.inside(name), path) for name, path in value.items()}


def _styled(at: values.KeyPath, word: str, value: Any) -> Any:
    """What a style makes of a value; its sentence becomes that of the scenario."""
    try:
        return getattr(PictureStyle(**{word: value}), word)
    except DependencyError:  # nothing can be drawn here, and the rest of the scenario can be run
        return value
    except InputError as error:
        at.refuse(f"{at.words}: {error}")


@dataclass(frozen=True, kw_only=True)
class PictureSettings:
    """``[pictures]``: what pictures look like. Which are drawn is in `[output]`.

    Attributes
    ----------
    theme
        Dark text on white, or light text on a dark background.
    transparent
        Whether the background is transparent.
    font
        An installed font, for names in scripts that DejaVu Sans lacks, such as Chinese.
    colours
        Colours of surfaces, zones and units by name.
    colour_map
        Of elevation, thickness and properties. Left out: the one that suits the picture.
    colour_by
        What the exploded view is coloured by.
    only
        Units of the exploded view, by their name, zone or block. Left empty: as `include` in
        `[output]`.
    camera
        A further view of horizons, faults and curves: azimuth of the viewer, clockwise from north,
        and height above the horizontal.
    zoom
        Scale of that view: 2 shows the middle of the model twice as large.
    polygons
        Polygons that are drawn on views, maps and sections: files, by name.
    points
        Data points that are drawn there: files, by name.
    """

    theme: str = key(values.one_of(*THEMES), default="light")
    transparent: bool = key(values.switch, default=False)
    font: str | None = key(font, default=None)
    colours: Mapping[str, Any] | None = key(colours, default=None)
    colour_map: str | None = key(colour_map, default=None)
    colour_by: str = key(values.one_of(*COLOUR_BY), default="unit")
    only: tuple[str, ...] = key(values.names, default=())
    camera: tuple[float, float] | None = key(angles, unit="degrees", default=None)
    zoom: float = key(values.zoom, default=1.0)
    polygons: Mapping[str, Path] | None = key(files, default=None)
    points: Mapping[str, Path] | None = key(files, default=None)

    @property
    def style(self) -> PictureStyle:
        """The style of all pictures."""
        return PictureStyle(
            self.theme, self.transparent, self.font, self.colours or {}, self.colour_map
        )


FORMATS = {  # format -> the file that it gives
    "vtm": "units.vtm", "vtp": "curves.vtp", "csv": "volumes.csv", "nc": "volumes.nc",
    "pl": "curves.pl", "ml": "units.ml", "epc": "surfaces.epc",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class SearchSettings:
    """``[search]``: how candidates are found. Changes the cost, never the result.

    Attributes
    ----------
    voxel_size_m
        Edge of the search voxels. Left out: chosen from the size of the triangles.
    """

    voxel_size_m: float | None = key(values.above_zero, unit="m", default=None)


@dataclass(frozen=True, kw_only=True)
class OutputSettings:
    """``[output]``: which pictures and files are made.

    Attributes
    ----------
    views
        Pictures of horizons, faults and curves, one for each direction to look from.
    maps
        A map of each horizon.
    thickness
        A thickness map of each zone between two horizons.
    allan
        An Allan diagram of each fault: the juxtaposition across it.
    throw
        The throw of all horizons along each fault.
    sections_m
        Vertical sections, each along a line of eastings and northings. Left out: two through the
        middle of the model.
    clip
        Whether pictures are clipped to the model.
    exploded
        An exploded view of the units.
    search
        Two surfaces: a picture of how the voxel search finds their curve.
    exaggeration
        Vertical exaggeration of the pictures. Left out: a round number that reads well.
    size_px
        Width and height of the pictures.
    include
        Units of tables and pictures: those of the reservoir, or all, with over- and underburden.
    formats
        Files to write: `vtm`: the units, one `.vtp` each in the folder `units`; `vtp`: the curves
        where surfaces meet; `csv`: the table of volumes; `nc`: the table of volumes, with units as
        attributes; `pl`: the curves for GOCAD; `ml`: the sealed model with its regions, for GOCAD
        and OpenGeode; `epc`: horizons and faults as RESQML 2.0.1, with `surfaces.h5`.
    closures
        What faults do to [closures](guides/closures.md): `closures.csv` then lists crest, spill
        point, height, area and volume of each. Left out: no file.
    """

    # which pictures are drawn
    views: tuple[str, ...] = key(values.some_of(*VIEWS), default=("southwest",))
    maps: bool = key(values.switch, default=True)
    thickness: bool = key(values.switch, default=True)
    allan: bool = key(values.switch, default=True)
    throw: bool = key(values.switch, default=True)
    sections_m: tuple[Any, ...] | None = key(values.lines, unit="m", default=None)
    clip: bool = key(values.switch, default=True)
    exploded: bool = key(values.switch, default=True)
    search: tuple[str, str] | None = key(values.pair_of_names, default=None)

    # how pictures look
    exaggeration: float | None = key(values.above_zero, default=None)
    size_px: tuple[int, int] = key(values.picture_size, unit="pixels", default=(1280, 800))

    # what they show, and files of results
    include: str = key(values.one_of(*INCLUDE), default="reservoir")
    formats: tuple[str, ...] = key(values.some_of(*FORMATS), default=("vtm", "vtp", "csv", "nc"))
    closures: str | None = key(values.one_of("sealing", "open", "juxtaposition"), default=None)
