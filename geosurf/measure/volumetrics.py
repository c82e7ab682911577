"""Compute fluids in place: net, pore and hydrocarbon pore volume, STOIIP and GIIP of each unit.

Numbers multiply the volume of a unit. Maps are bilinear in the cells of their grids. What they
multiply is integrated over the unit itself, not over columns: by the divergence theorem the
integral of f(x, y) over a closed shell is the sum over its triangles of f times elevation,
integrated over their shadows in the map. Shadows are cut at the lines of all grids; in each piece
the product is a polynomial, which Gauss points integrate without error but rounding.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray

from geosurf.conventions import area_text, check_name, check_word, is_number, number_text, place
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import ranges
from geosurf.model import Lattice, Unit, Units
from geosurf.model.column import ELSEWHERE
from geosurf.model.distributions import ends_of, is_distribution

OpenMap = Callable[[Any, str], Lattice | None]  # value, name of the argument -> its grid

# each argument needs those before it, and leads to one column more
ARGUMENTS = ("net_to_gross", "porosity", "water_saturation", "formation_volume_factor")
FLUIDS = ("oil", "gas", "water")
# above and below a contact, by the letters in its name
OF_CONTACTS = {"owc": ("oil", "water"), "goc": ("gas", "oil"), "gwc": ("gas", "water")}
_LETTERS = re.compile(r"(?<![a-z])(owc|goc|gwc)(?![a-z])", re.IGNORECASE)

BARREL = 0.158987294928  # [m3]
SIZES = {"m3": 1.0, "Sm3": 1.0, "acre-ft": 1233.48183754752, "bbl": BARREL, "stb": BARREL,
         "scf": 0.028316846592}  # fmt: skip
COLUMNS = {  # meaning, unit of measure in each system
    "bulk": ("gross rock volume (GRV)", "m3", "acre-ft"),
    "net": ("net rock volume", "m3", "acre-ft"),
    "pore": ("pore volume of net rock", "m3", "bbl"),
    "hydrocarbon_pore": ("hydrocarbon pore volume (HCPV)", "m3", "bbl"),
    "stoiip": ("stock-tank oil initially in place (STOIIP)", "Sm3", "stb"),
    "giip": ("free gas initially in place (GIIP)", "Sm3", "scf"),
}
SYSTEMS = ("metric", "field")
NEAR = 1e-9  # of a cell: pieces that reach less far over a line are not cut there
RIM = 1e-9  # of a unit's area in the map: what rounding may put beyond the rim of a map
AT_ONCE = 100_000  # pieces that are held in memory


@dataclass(frozen=True)
class Factor:
    """What one argument gives: a number or a map for each set of words that a unit has.

    Attributes
    ----------
    name : str
        Of the argument.
    entries : dict of frozenset of str to object
        Empty words: all units for which no other entry is.
    """

    name: str
    entries: dict[frozenset[str], Any]

    @classmethod
    def of(cls, name: str, value: Any, check: Callable[[Any, str], Any]) -> Factor:
        """Take one value, or a mapping; `check` takes a value and what messages call it."""
        if not isinstance(value, Mapping):
            return cls(name, {frozenset(): check(value, name)})
        entries: dict[frozenset[str], Any] = {}
        for key, entry in value.items():
            words = frozenset(map(str, key if isinstance(key, tuple) else (key,)))
            words -= {ELSEWHERE}
            if words in entries:
                raise InputError(f"{name} has two entries for {_listed(words)}. Remove one.")
            entries[words] = check(entry, f"{name} for {_listed(words)}")
        return cls(name, entries)

    def refuse_unknown(self, known: Sequence[str]) -> None:
        """Refuse entries for what the model does not have."""
        for word in sorted(set().union(*self.entries)):
            refusal = f"{self.name} has an entry for {word!r}, but no unit is called so."
            kinds = "Zones, regions, blocks, contact intervals and fluids are"
            check_name(word, known, f"{refusal} {kinds}")

    def key_of(self, unit: str, words: set[str]) -> frozenset[str] | None:
        """Return the most specific entry for a unit; None if there is none."""
        fits = [key for key in self.entries if key <= words]
        best = [key for key in fits if len(key) == max(map(len, fits))]
        if len(best) > 1:
            first, second = sorted(map(_listed, best))[:2]
            raise InputError(
                f"{self.name} has entries for {first} and for {second}, and unit {unit!r} belongs "
                f"to both. Add an entry for both together: {(*sorted(best[0] | best[1]),)}."
            )
        return best[0] if best else None

    def value_of(self, unit: str, words: set[str]) -> Any:
        """Return the value for a unit, or an error that states what to give."""
        key = self.key_of(unit, words)
        if key is None:
            raise InputError(
                f"{self.name} has no value for unit {unit!r}. Add an entry for one of "
                f"{sorted(words)}, or for {ELSEWHERE!r}."
            )
        return self.entries[key]


def _listed(words: frozenset[str]) -> str:
    """Words of an entry, for messages."""
    return ", ".join(map(repr, sorted(words))) or repr(ELSEWHERE)


def factors_of(given: Mapping[str, Any], open_map: OpenMap) -> list[Factor]:
    """
    Return the arguments of `fluids_in_place` from what users give, checked.

    Parameters
    ----------
    given : mapping of str to object
        By the names of `ARGUMENTS`; None: not given. Numbers, maps, or mappings of words to these.
    open_map : callable
        Returns the grid of a map; None: maps are not looked at.

    Raises
    ------
    InputError
        If an argument is given without one before it, or a value is out of range.

    Notes
    -----
    Distributions, of ensembles, stay what they are; nearly all of their values must be in range.

    Examples
    --------
    >>> found = factors_of({"net_to_gross": 0.8, "porosity": {("A/B", "oil"): 0.2}}, None)
    >>> [factor.entries for factor in found][0]
    {frozenset(): 0.8}
    """
    names = [name for name in ARGUMENTS if given.get(name) is not None]
    for needed, name in zip(ARGUMENTS, names or [""], strict=False):
        if name != needed:
            raise InputError(
                f"volumetrics needs {needed}, which is missing. Of net_to_gross, 1.0 counts all "
                "rock as net."
            )

    def check(value: Any, what: str) -> Any:
        """A number as float, a distribution as it is, anything else as a grid."""
        if is_number(value):
            check_range(float(value), float(value), what)
            return float(value)
        if is_distribution(value):
            check_range(*ends_of(value, what), what)
            return value
        lattice = open_map(value, what)
        if lattice is not None:
            check_range(float(np.nanmin(lattice.elevation)), _largest(lattice), what)
        return lattice

    return [Factor.of(name, given[name], check) for name in names]


def check_range(low: float, high: float, what: str) -> None:
    """Refuse values that cannot be."""
    wrong, allowed = not 0.0 <= low <= high <= 1.0, "from 0 to 1 (divide percent by 100)"
    if what.startswith(ARGUMENTS[3]):
        wrong, allowed = low <= 0.0, "above 0: volume in the reservoir over volume at the surface"
    if wrong:
        shown = f"{low:g}" if low == high else f"from {low:.4g} to {high:.4g}"
        raise InputError(f"{what} is {shown}; it must be {allowed}.")


def _largest(value: Any) -> float:
    """A number, or the largest value of a grid."""
    return float(value if is_number(value) else np.nanmax(value.elevation))


def fluids_rule(fluids: Any) -> Factor:
    """Return which fluids users say that units have: a word, or a mapping to words."""

    def check(value: Any, what: str) -> str:
        if not (isinstance(value, str) and value in FLUIDS):
            raise InputError(f"{what} is {value!r}; it must be one of {', '.join(FLUIDS)}.")
        return value

    return Factor.of("fluids", {} if fluids is None else fluids, check)


def fluid_of(unit: Unit | SimpleNamespace, words: set[str], rule: Factor) -> str:
    """Return the fluid of a unit: as users say, else by the names of contacts; '' if unknown."""
    key = rule.key_of(unit.name, words)
    if key:
        return str(rule.entries[key])

    # what lies below the contact above the unit, and above the contact below it
    above, sides = unit.beneath[-1] if unit.beneath else "", []
    below = unit.contact[len(above) + 1 :] if above else unit.contact.removeprefix("above ")
    for name, side in ((above, 1), ("" if unit.contact.startswith("below ") else below, 0)):
        letters = _LETTERS.search(name)
        sides += [OF_CONTACTS[letters[1].lower()][side] if letters else ""] if name else []
    known = sides[0] if len(set(sides)) == 1 else ""
    return known or str(rule.entries.get(frozenset(), ""))


def unknown_fluid(what: str, word: str) -> InputError:
    """Return the error for what has no fluid; `word` names it in ``fluids``."""
    return InputError(
        f"the fluid of {what} is not known. Name contacts OWC, GOC or GWC, or give oil, gas or "
        f'water: fluids={{"{word}": "oil"}}; in a scenario, fluids = {{"{word}" = "oil"}} in '
        "[volumetrics]."
    )


def fluids_in_place(
    units: Units, factors: Sequence[Factor], fluids: Any = None, system: str = "metric",
    include: str = "reservoir",
) -> xarray.Dataset:  # fmt: skip
    """
    Return rock and fluids of each unit, from bulk volume to volumes at surface conditions.

    Parameters
    ----------
    units : Units
    factors : sequence of Factor
        From `factors_of`.
    fluids : str or mapping, optional
        Fluids of units whose contacts do not name them.
    system : {"metric", "field"}
    include : {"reservoir", "all"}

    Returns
    -------
    xarray.Dataset
        Along ``unit``, with one column more for each factor.

    Raises
    ------
    InputError
        If a unit of the reservoir has no value or fluid, or a map does not cover a unit.
    """
    check_system(system)
    rule = fluids_rule(fluids)
    refuse_unknown_words(units, factors, rule)
    part = units.included(include)
    fluid_names, values = amounts_of(part, factors, rule, system)
    columns = columns_of(len(factors), system)
    data = {key: ("unit", values[:, k], attrs) for k, (key, attrs) in enumerate(columns.items())}
    column = np.array(fluid_names, dtype=object)
    crs = {} if units.crs is None else {"crs": units.crs}
    return xarray.Dataset(data, part.volumes.coords, crs).assign_coords(fluid=("unit", column))


def check_system(system: Any) -> None:
    """Refuse an unknown system of units of measure."""
    check_word(system, SYSTEMS, f"units is {system!r}; it must be one of {', '.join(SYSTEMS)}.")


def columns_of(n_factor: int, system: str) -> dict[str, dict[str, str]]:
    """Attributes of the columns that so many factors lead to, by name."""
    shown = list(COLUMNS)[: n_factor + 1 + (n_factor == len(ARGUMENTS))]
    return {
        key: {"units": COLUMNS[key][1 + SYSTEMS.index(system)], "long_name": COLUMNS[key][0]}
        for key in shown
    }


def refuse_unknown_words(units: Units, factors: Sequence[Factor], rule: Factor) -> None:
    """Refuse entries for what a model does not have."""
    known = sorted(set().union(*map(_words_of, units.values())))
    rule.refuse_unknown(known)
    for factor in factors:
        factor.refuse_unknown([*known, *FLUIDS])


def _words_of(unit: Unit) -> set[str]:
    """What entries can name a unit by."""
    return {unit.zone, unit.region, unit.block, unit.contact} - {""}


def amounts_of(
    units: Units, factors: Sequence[Factor], rule: Factor, system: str
) -> tuple[list[str], np.ndarray]:
    """Return the fluid of each unit, and its columns, see `columns_of`: (n_unit, n_column).

    Columns that lack a value are NaN: of units outside the reservoir nothing has to be given.
    """
    values, fluids = np.zeros((len(units), len(COLUMNS))), []
    # one word for all fluids is for the reservoir
    named = Factor(rule.name, {words: fluid for words, fluid in rule.entries.items() if words})
    for row, unit in enumerate(units.values()):
        words, inside = _words_of(unit), unit.zone in units.reservoir
        fluids.append(fluid_of(unit, words, rule if inside else named))
        chain = _chain(unit, factors, words | {fluids[row]} - {""}, fluids[row], complete=inside)
        values[row, : len(chain) + 1] = unit.volume, *_in_steps(unit, chain)
        if len(chain) < len(factors):
            values[row, len(chain) + 1 :] = np.nan
        if fluids[row] == "gas":
            values[row, 4:] = 0.0, values[row, 4]
    sizes = [SIZES[attrs["units"]] for attrs in columns_of(len(factors), system).values()]
    return fluids, values[:, : len(sizes)] / np.array(sizes)


def _chain(
    unit: Unit, factors: Sequence[Factor], words: set[str], fluid: str, *, complete: bool
) -> list[Any]:
    """What multiplies the volume of a unit, step by step: numbers and grids of values.

    Without a fluid or a value it is an error if the chain has to be complete; else it ends there.
    """
    chain: list[Any] = []
    for factor in factors:
        if factor.name in ARGUMENTS[2:] and not fluid:
            if not complete:
                break
            raise unknown_fluid(f"unit {unit.name!r}", unit.contact or unit.zone)
        if factor.name in ARGUMENTS[2:] and fluid == "water":
            chain.append(0.0)
            continue
        if not complete and factor.key_of(unit.name, words) is None:
            break
        value = factor.value_of(unit.name, words)
        if factor.name == ARGUMENTS[2]:
            value = _changed(value, lambda sw: 1.0 - sw)
        elif factor.name == ARGUMENTS[3]:
            if fluid == "gas" and _largest(value) >= 1.0:
                raise InputError(
                    f"{factor.name} is {_largest(value):g} for gas in unit {unit.name!r}; that of "
                    'gas is below 1. Give it by fluid, as in {"oil": 1.3, "gas": 0.005}; of an '
                    "expansion factor give the reciprocal."
                )
            value = _changed(value, lambda factor: 1.0 / factor)
        chain.append(value)
    return chain


def _changed(value: Any, change: Callable[[Any], Any]) -> Any:
    """A number, or the values of a grid, as a function changes them."""
    return change(value) if is_number(value) else value.with_elevation(change(value.elevation))


def _in_steps(unit: Unit, chain: Sequence[Any]) -> list[float]:
    """The volume of a unit times the first factors, the first two, and so on."""
    maps = {
        name: factor
        for name, factor in zip(ARGUMENTS, chain, strict=False)
        if not is_number(factor)
    }
    wanted = [unit.volume, *(integrals(unit, maps) if maps else ())]
    n_map = np.cumsum([not is_number(factor) for factor in chain])
    numbers = np.cumprod([factor if is_number(factor) else 1.0 for factor in chain])
    return [wanted[k] * number for k, number in zip(n_map, numbers.tolist(), strict=True)]


def totals_in_words(volumes: xarray.Dataset) -> str:
    """Return what units hold in all, with units of measure."""
    in_place = [volumes[key] for key in ("stoiip", "giip") if key in volumes and volumes[key].sum()]
    totals = (
        (column.attrs, float(column.sum()) / 1e6)
        for column in in_place or [volumes[list(volumes)[-1]]]
    )
    words = (f"{of['long_name']} {number_text(sum_)} million {of['units']}" for of, sum_ in totals)
    return ", ".join(words).replace("m3", "m³")


# ---- maps ----------------------------------------
# Integrals of products of maps over a unit.


@dataclass(frozen=True, eq=False)
class MapCells:
    """The cells of a map, in coordinates along its axes.

    Attributes
    ----------
    origin, matrix : ndarray (2,), (2, 2)
        Coordinates of a place are its offset from the origin, times the matrix.
    axes : (ndarray, ndarray)
        Lines between cells, rising: along columns, then along rows.
    values : ndarray, shape (n_row, n_col)
    """

    origin: np.ndarray
    matrix: np.ndarray
    axes: tuple[np.ndarray, np.ndarray]
    values: np.ndarray

    @classmethod
    def of(cls, lattice: Lattice, origin: np.ndarray, name: str) -> MapCells:
        """Make one for places that count from an origin."""
        x, y, z = lattice.easting, lattice.northing, lattice.elevation
        if x.ndim == 1:
            # subtracted as from the model: what is equal stays equal, so rims are met exactly
            return cls(np.zeros(2), np.eye(2), (x - origin[0], y - origin[1]), z)
        matrix = lattice.map_frame.columns_and_rows(name)
        lines = np.arange(float(z.shape[1])), np.arange(float(z.shape[0]))
        return cls(np.array([x[0, 0], y[0, 0]]) - origin[:2], matrix, lines, z)

    def along(self, axis: int, places: np.ndarray) -> np.ndarray:
        """Coordinates of places (..., 2 or more) along an axis."""
        return np.asarray((places[..., :2] - self.origin) @ self.matrix[:, axis])

    def at(self, cell: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bilinear values at places (n, k, 2) in a cell (n, 2) each, and where there is none."""
        inside = np.clip(cell, 0, np.array(self.values.shape)[::-1] - 2)
        s, t = (
            (self.along(axis, places) - lines[k][:, None]) / np.diff(lines)[k][:, None]
            for (axis, lines), k in zip(enumerate(self.axes), inside.T, strict=True)
        )
        j, i = inside.T
        a, b, c, d = (self.values[i + p, j + q][:, None] for p in (0, 1) for q in (0, 1))
        values = a + s * (b - a) + t * ((c - a) + s * ((d - c) - (b - a)))
        lacking = (cell != inside).any(axis=1) | np.isnan(values[:, 0])
        return np.where(np.isnan(values), 0.0, values), lacking


def integrals(unit: Unit, maps: Mapping[str, Lattice]) -> list[float]:
    """
    Integrate the first map, the product of the first two, and so on, over a unit [m3].

    Parameters
    ----------
    unit : Unit
    maps : mapping of str to Lattice
        Values in place of elevations, by the name of the argument.

    Raises
    ------
    InputError
        If a map does not cover the unit, or is curvilinear.
    """
    cells = [MapCells.of(property_map, unit.origin, name) for name, property_map in maps.items()]
    points, weights = _gauss(len(maps))
    corners = unit.local[unit.triangles]
    corners[..., 2] -= 0.5 * (corners[..., 2].min() + corners[..., 2].max())
    sums: list[list[float]] = [[] for _ in maps]
    lost: dict[int, tuple[float, np.ndarray]] = {}  # area that a map does not cover, a place there
    for polygons, cells_of_maps in _pieces(corners, cells):
        # fans of triangles from the first corner, then Gauss points in each
        fan = [0, 1, 2] + np.arange(polygons.shape[1] - 2)[:, None] * [0, 1, 1]
        piece, k = np.nonzero(_flat(polygons[:, fan]))
        triangles = polygons[piece[:, None], fan[k]]
        size = 0.5 * _flat(triangles)
        places = points @ triangles
        product = places[..., 2] * weights
        for m, property_map in enumerate(cells):
            value, lacking = property_map.at(cells_of_maps[piece, 2 * m : 2 * m + 2], places)
            missing = np.where(lacking, size, 0.0).clip(0.0)
            if missing.any():
                area, at = lost.get(m, (0.0, places[missing.argmax()].mean(axis=0)))
                lost[m] = area + float(missing.sum()), at
            product = product * value
            sums[m].append(float(size @ product.sum(axis=1)))
    for m, (area, at) in lost.items():
        if area > RIM * unit.map_area:
            raise InputError(
                f"the map of {list(maps)[m]} has no values over {area_text(area)} of unit "
                f"{unit.name!r}, such as at {place(at[:2] + unit.origin[:2])}. Fill or enlarge it "
                "there, or give this unit a number."
            )
    return [math.fsum(property_map) for property_map in sums]


def _flat(triangles: np.ndarray) -> np.ndarray:
    """Twice the area of triangles (..., 3, 2 or more) in the map; above 0 where they look up."""
    u, v = np.moveaxis(np.diff(triangles[..., :2], axis=-2), -2, 0)
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def _gauss(n_map: int) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric Gauss points (n, 3) of a triangle, exact for n bilinear maps times elevation.

    A square is folded into the triangle, which raises the degree along one side by one.
    """
    (x, u), (y, v) = (np.polynomial.legendre.leggauss(n_map + k) for k in (2, 1))
    x, y = (0.5 + 0.5 * one for one in (x, y))
    s = np.repeat(x, len(y))
    t = np.outer(1.0 - x, y).ravel()
    return np.stack([1.0 - s - t, s, t], axis=1), 0.5 * np.outer(u * (1.0 - x), v).ravel()


def _pieces(
    corners: np.ndarray, cells: Sequence[MapCells]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Polygons (n, k, 3) of triangles, cut along the lines of all maps, and the cell of each map.

    Cells are (n, 2 n_map): column and row; the last corner is repeated where there are fewer.
    """
    corners = corners[_flat(corners) != 0.0]
    count = np.ones(len(corners), dtype=np.int64)
    for grid in cells:
        for axis, lines in enumerate(grid.axes):
            h = grid.along(axis, corners)
            first, last = (np.searchsorted(lines, end) for end in (h.min(axis=1), h.max(axis=1)))
            count *= 1 + last - first
    total = np.cumsum(count)
    ends = np.searchsorted(total, np.arange(0, total[-1] if len(total) else 0, AT_ONCE), "right")
    for first, last in zip(ends, [*ends[1:], len(corners)], strict=True):
        polygons, cells_of_maps = corners[first:last], np.empty((last - first, 0), dtype=np.int64)
        for grid in cells:
            for axis, lines in enumerate(grid.axes):
                polygons, row, strip = _split(polygons, grid.along(axis, polygons), lines)
                cells_of_maps = np.column_stack([cells_of_maps[row], strip - 1])
        for k in range(0, len(polygons), AT_ONCE):
            yield polygons[k : k + AT_ONCE], cells_of_maps[k : k + AT_ONCE]


def _split(
    x: np.ndarray, h: np.ndarray, lines: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parts of polygons between lines, the row of each polygon, and how many lines lie below.

    `h` has the coordinate (n, k) of the corners across the lines.
    """
    near = NEAR * float(np.diff(lines).min())
    low = np.searchsorted(lines, h.min(axis=1) + near, "right")
    high = np.maximum(np.searchsorted(lines, h.max(axis=1) - near, "left"), low)
    row, strip = ranges(low, high - low + 1)
    parts = np.concatenate([x, h[..., None]], axis=2)[row]
    for side, level, cut in ((1.0, strip - 1, strip > low[row]), (-1.0, strip, strip < high[row])):
        cut_rows = np.flatnonzero(cut)
        halves = _half(
            parts[cut_rows], side * (parts[cut_rows, :, -1] - lines[level[cut_rows], None])
        )
        width = max(halves.shape[1], parts.shape[1])
        parts = _widened(parts, width)
        parts[cut_rows] = _widened(halves, width)
    return parts[..., :-1], row, strip


def _half(x: np.ndarray, off: np.ndarray) -> np.ndarray:
    """The part of convex polygons (n, k, c) where `off` (n, k) is not negative."""
    shape = len(x), 2 * x.shape[1], x.shape[2]
    after, there = np.roll(off, -1, axis=1), np.roll(x, -1, axis=1)
    crosses = ((off > 0) & (after < 0)) | ((off < 0) & (after > 0))
    share = np.where(crosses, off, 0.0) / np.where(crosses, off - after, 1.0)
    both = np.stack([x, x + share[..., None] * (there - x)], axis=2).reshape(shape)
    valid = np.stack([off >= 0, crosses], axis=2).reshape(shape[:2])
    count = valid.sum(axis=1)
    order = np.argsort(~valid, axis=1, kind="stable")
    place = np.minimum(np.arange(count.max(initial=1)), np.maximum(count, 1)[:, None] - 1)
    return np.asarray(both[np.arange(len(x))[:, None], np.take_along_axis(order, place, axis=1)])


def _widened(x: np.ndarray, width: int) -> np.ndarray:
    """Polygons with the last corner repeated, so that each has so many."""
    more = np.repeat(x[:, -1:], width - x.shape[1], axis=1)
    return np.concatenate([x, more], axis=1)
