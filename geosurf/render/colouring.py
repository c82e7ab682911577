"""Choose the colours of units: by unit, zone, block, contact interval, elevation or a property."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geosurf.conventions import check_word, counted, grouped, palette, real_numbers, volume_text
from geosurf.conventions.axes import vertical_label
from geosurf.conventions.palette import RGB, unit_colours
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.model import Unit, Units
from geosurf.model.units import left_out
from geosurf.render.furniture import colours_of, contour_levels
from geosurf.render.layers import LABEL_ROOM, Bar, Entry
from geosurf.render.picture_style import COLOUR_BY, PictureStyle

RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
N_LEVEL = 8  # intervals of a colour bar
_HOW = (
    f"Use one of {', '.join(COLOUR_BY)}, a mapping of unit names to numbers, or one number per unit"
)

Property = str | dict[str, float] | np.ndarray


@dataclass(frozen=True, eq=False)
class Colouring:
    """Colours of units by name, their legend, and a colour bar for numbers."""

    colours: dict[str, RGB]
    legend: tuple[Entry, ...]
    bar: Bar | None = None
    by_elevation: bool = False

    def shades(self, points: np.ndarray) -> np.ndarray | None:
        """Return a colour for each point (n, 3), if colours depend on elevation."""
        if not self.by_elevation or self.bar is None:
            return None
        return shades_of(self.bar, points[:, 2])


@dataclass(frozen=True, eq=False)
class Selection:
    """Names of surfaces, units, zones and blocks that are shown; None: all of the reservoir."""

    names: tuple[str, ...] | None = field(default=None)
    include: str = "reservoir"

    def holds(self, *names: str) -> bool:
        """Whether one of these names is selected."""
        return self.names is None or any(name in self.names for name in names)

    def of_units(self, units: Units) -> list[bool]:
        """Whether each unit is selected; outside the reservoir by its own name or its zone only."""
        inside, named = units.included(self.include), self.names or ()
        return [
            self.holds(unit.name, unit.zone, unit.block, unit.region)
            if unit.name in inside
            else unit.name in named or unit.zone in named
            for unit in units.values()
        ]

    def left_out(self, units: Units) -> str:
        """What a picture does not show although nobody has selected units; '' for nothing."""
        if self.names is not None:
            return ""
        return left_out(units, 'include="all" draws them.', self.include)

    def check(self, known: Iterable[str]) -> None:
        """Refuse names that nothing has."""
        known = tuple(dict.fromkeys(known))
        for name in self.names or ():
            refusal = f"only has the unknown name {name!r}. Names are {', '.join(known)}."
            check_word(name, known, refusal)


def selection_of(only: Any, include: Any = "reservoir") -> Selection:
    """Return the selection, or raise an error for what is not a list of names, or a word.

    Raises
    ------
    InputError
    """
    Units([], (0.0,) * 6).included(include)  # refuses other words
    if only is None:
        return Selection(None, include)
    names = (only,) if isinstance(only, str) else only
    if not isinstance(names, Sequence) or not all(isinstance(name, str) for name in names):
        raise InputError(
            f"only is {only!r}, expected a list of names of surfaces, units, zones or blocks, as "
            "in ['Top', 'F1']."
        )
    return Selection(tuple(names), include)


def zone_colours(
    zones: Sequence[str], reservoir: Sequence[str], style: PictureStyle
) -> tuple[dict[str, str], dict[str, RGB]]:
    """
    Return what pictures call each zone, and the colours of these names.

    Zones outside the reservoir have one neutral colour, and one name above it and one below it.

    Examples
    --------
    >>> from geosurf.render.picture_style import PLAIN
    >>> zones = ["above Top", "Top/Middle", "Middle/Base", "below Base"]
    >>> names, colours = zone_colours(zones, ["Top/Middle"], PLAIN)
    >>> list(names.values())
    ['above the reservoir', 'Top/Middle', 'below the reservoir', 'below the reservoir']
    """
    rows = [i for i, zone in enumerate(zones) if zone in reservoir]
    first, last = (rows[0], rows[-1]) if rows else (len(zones), -1)
    names: dict[str, str] = {}
    colours: dict[str, RGB] = {}
    for i, zone in enumerate(zones):
        side = "above" if i < first else "below" if i > last else "outside"
        names[zone] = zone if zone in reservoir else f"{side} the reservoir"
        plain = palette.stratum(i) if zone in reservoir else palette.WALL
        colours.setdefault(names[zone], style.colour((zone, names[zone]), plain))
    return names, colours


def check_colour_by(colour_by: Any) -> tuple[Property, str]:
    """Return what units are coloured by and its name, or raise an error.

    Raises
    ------
    InputError
        If it is neither a known word nor numbers.

    Examples
    --------
    >>> check_colour_by("zone")
    ('zone', 'zone')
    """
    if isinstance(colour_by, str):
        check_word(colour_by, COLOUR_BY, f"colour_by is {colour_by!r}. {_HOW}.")
        return colour_by, colour_by
    words = str(getattr(colour_by, "name", None) or "Property").replace("_", " ")
    unit = getattr(colour_by, "attrs", {})
    if isinstance(unit, Mapping) and unit.get("units"):
        words += f" [{unit['units']}]".replace("m3]", "m³]").replace("m2]", "m²]")
    names = list(colour_by) if isinstance(colour_by, Mapping) else None
    if getattr(colour_by, "ndim", 0) == 1 and "unit" in getattr(colour_by, "coords", ()):
        names = colour_by.coords["unit"].values.tolist()
        colour_by = dict(zip(names, colour_by.values.tolist(), strict=True))
    try:
        values = real_numbers(list(colour_by.values()) if names is not None else colour_by)
    except (TypeError, ValueError) as error:
        raise InputError(f"colour_by is {colour_by!r}. {_HOW}.") from error
    if values.ndim != 1 or not np.isfinite(values).any():
        raise InputError(f"colour_by has no list of finite numbers. {_HOW}.")
    if names is None:
        return values, words
    if not all(isinstance(name, str) for name in names):
        raise InputError(f"colour_by has names that are not text. {_HOW}.")
    return dict(zip(names, values.tolist(), strict=True)), words


def colour_units(
    units: Units, shown: Sequence[Unit], colour_by: Any, style: PictureStyle
) -> Colouring:
    """Return the colours of some units of a model.

    Parameters
    ----------
    units : Units
    shown : sequence of Unit
        Those in the picture: the legend lists them.
    colour_by : str, mapping of str to float, or array_like of float
        One of `COLOUR_BY`; numbers by name; or a number for each unit, in the order of `units`.
    style : PictureStyle

    Raises
    ------
    InputError
        For other words, unknown units, or another number of values than units.
    """
    by, words = check_colour_by(colour_by)
    solid = [unit for unit in shown if unit.name not in {one.name for one in units.slivers}]
    if isinstance(by, str) and by == "z":
        return Colouring(
            {}, (), elevation_bar(units.box[4], units.box[5], style), by_elevation=True
        )
    if isinstance(by, str):
        return _by_word(units, solid, by, style)
    return _by_number(units, solid, by, words, style)


def _by_word(units: Units, shown: Sequence[Unit], by: str, style: PictureStyle) -> Colouring:
    """Colours of units, or of what they have in common."""
    if by == "unit":
        labels = units.labels
        shades = unit_colours((labels[u.name], u.zone_index) for u in units.without_slivers)
        colours = {
            unit.name: style.colour(
                (unit.name, labels[unit.name], unit.region, unit.zone), shades[labels[unit.name]]
            )
            for unit in shown
        }
        rank = {name: k for k, name in enumerate(units.regions)}
        in_order = sorted(shown, key=lambda u: (u.zone_index, rank.get(u.region, -1)))
        of_label = grouped((labels[unit.name], unit) for unit in in_order)
        return Colouring(colours, tuple(_entry(*one, colours) for one in of_label.items()))

    # kinds of the whole model: their colours do not depend on what is shown
    def kind(unit: Unit) -> str:
        """What a unit is coloured by."""
        return str(getattr(unit, by))

    kinds = list(dict.fromkeys(kind(unit) for unit in units.without_slivers))
    if by == "region":  # the largest first
        kinds.sort(key=lambda name: [*units.regions, name].index(name))
    index = {unit.zone: unit.zone_index for unit in units.values()} if by == "zone" else {}
    colour_of_kind = {
        name: style.colour(name, palette.stratum(index.get(name, i)) if name else palette.WALL)
        for i, name in enumerate(kinds)
    }
    legend = []
    for name in kinds:
        parts = [unit for unit in shown if kind(unit) == name]
        if parts:
            total = volume_text(math.fsum(unit.volume for unit in parts))
            words = name or f"no {by}"
            legend.append(
                Entry(words, colour_of_kind[name], f"{counted(len(parts), 'unit')}, {total}")
            )
    return Colouring({unit.name: colour_of_kind[kind(unit)] for unit in shown}, tuple(legend))


def _by_number(
    units: Units,
    shown: Sequence[Unit],
    values: dict[str, float] | np.ndarray,
    words: str,
    style: PictureStyle,
) -> Colouring:
    """Colours of a property; units without a value are grey."""
    if isinstance(values, np.ndarray):
        if len(values) != len(units):
            raise InputError(
                f"colour_by has {counted(len(values), 'number')} for "
                f"{counted(len(units), 'unit')}. Give one number per unit, in the order of "
                "scene.units, or a mapping of names to numbers."
            )
        values = dict(zip(units, values.tolist(), strict=True))
    for name in values:
        check_word(name, units, f"colour_by has a number for {name!r}, which is not a unit.")
    held = {name: value for name, value in values.items() if np.isfinite(value)}
    words, scale = _scaled(words, max(map(abs, held.values())))
    held = {name: value / scale for name, value in held.items()}
    bar = Bar(words, style.codes(palette.THICKNESS), _levels(*_ends(held.values())))
    legend: list[Entry] = []
    colours: dict[str, RGB] = {}
    for unit in shown:
        value = held.get(unit.name)
        colour = colours[unit.name] = palette.WALL if value is None else shade_of(bar, value)
        legend.append(Entry(unit.name, colour, "no value" if value is None else f"{value:.4g}"))
    return Colouring(colours, tuple(legend), bar)


def _scaled(words: str, most: float) -> tuple[str, float]:
    """The name of a property with its scale, and the scale: long numbers cannot be read.

    Examples
    --------
    >>> _scaled("volume [m³]", 3.0e9)
    ('volume [10⁹ m³]', 1000000000.0)
    """
    power = 3 * math.floor(math.log10(most) / 3.0) if most > 0.0 else 0
    if -3 <= power <= 3:
        return words, 1.0
    unit = f"10{str(power).translate(RAISED)}"
    words = words.replace("[", f"[{unit} ") if "[" in words else f"{words} [{unit}]"
    return words, 10.0**power


def _ends(values: Iterable[float]) -> tuple[float, float]:
    held = list(values)
    return min(held), max(held)


def _levels(low: float, high: float) -> tuple[float, ...]:
    return tuple(contour_levels(low, high, N_LEVEL).tolist())


def elevation_bar(low: float, high: float, style: PictureStyle) -> Bar:
    """Return the colour bar of elevations between two values [m]."""
    return Bar(vertical_label(), style.codes(palette.ELEVATION), _levels(low, high))


def seal_bar(seals: Sequence[xarray.Dataset], style: PictureStyle) -> Bar:
    """Return the colour bar of the shale gouge ratios of faults."""
    held = [float(end) for one in seals for end in (one.sgr.min(), one.sgr.max())]
    levels = _levels(*_ends(value for value in held if np.isfinite(value)))
    return Bar("Shale gouge ratio", style.codes(palette.THICKNESS), levels)


def shades_of(bar: Bar, values: np.ndarray) -> np.ndarray:
    """Return the colour (n, 3) of each value (n,) on a colour bar."""
    low, high = bar.levels[0], bar.levels[-1]
    share = (values - low) / (high - low) if high > low else np.full(len(values), 0.5)
    return colours_of(bar.codes)(np.clip(share, 0.0, 1.0))[:, :3]


def shade_of(bar: Bar, value: float) -> RGB:
    """Return the colour of one value on a colour bar."""
    red, green, blue = shades_of(bar, np.array([value]))[0].tolist()
    return red, green, blue


def _entry(label: str, units: Sequence[Unit], colours: Mapping[str, RGB]) -> Entry:
    """The legend entry of units: the end of a long name moves to the second line."""
    volume = volume_text(math.fsum(unit.volume for unit in units))

    # a name that does not fit is split at its zone: what follows moves to the second line
    zone, colour = units[0].zone, colours[units[0].name]
    end = label[len(zone) :].strip()
    if len(label) <= LABEL_ROOM or not end:
        return Entry(label, colour, volume)
    return Entry(zone, colour, f"{end}, {volume}")
