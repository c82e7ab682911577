"""The result of one realisation, and the bytes that it is stored as until its batch is full."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from geosurf.conventions import check_word
from geosurf.ensemble.change import Given, PreparedNumber
from geosurf.errors import InputError
from geosurf.measure.thickness import nodes_of, thickness_map
from geosurf.measure.volumetrics import (
    ARGUMENTS,
    SIZES,
    Factor,
    amounts_of,
    check_range,
    check_system,
    columns_of,
    fluids_rule,
    refuse_unknown_words,
)
from geosurf.model import Lattice, Units
from geosurf.model.column import ELSEWHERE, names_of_zones
from geosurf.model.distributions import distribution_of, is_distribution
from geosurf.scene import Scene
from geosurf.scene.inputs import factors_of_rock

# ---- maps ----------------------------------------
# Maps of one realisation: the thickness of each layer on nodes that all realisations share.


@dataclass(frozen=True, eq=False)
class Layers:
    """
    Zones, and their parts between fluid contacts, on the nodes of a map.

    Attributes
    ----------
    names : tuple of str
        ``"Top/Base"``, ``"Top/Base above OWC"`` ...
    zones, contacts : tuple of str
        Of each layer; the contact interval is empty for a whole zone.
    easting, northing : ndarray of float64
        Nodes of the map [m], one-dimensional.

    Examples
    --------
    >>> from geosurf.synthetic import tilted_planes
    >>> world = tilted_planes(n=9)
    >>> scene = Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2000.0})
    >>> layers = Layers.of(scene, 500.0)
    >>> layers.names
    ('Top/Base', 'Top/Base above OWC', 'Top/Base below OWC')
    >>> layers.thickness(scene).shape
    (3, 6, 8)
    """

    names: tuple[str, ...]
    zones: tuple[str, ...]
    contacts: tuple[str, ...]
    easting: np.ndarray
    northing: np.ndarray

    @classmethod
    def of(cls, scene: Scene, grid: Any) -> Layers:
        """Return the layers of a reservoir, without zones above all or below all horizons.

        Parameters
        ----------
        scene : Scene
        grid : float or xarray object
            As for `Scene.thickness`: the width of cells [m], or a grid with unrotated axes.
        """
        # True stands for the default width of cells.
        nodes = nodes_of(None if grid is True else grid, scene.box)
        if len(nodes.shape) != 2 or nodes.coords["easting"][1].ndim != 1:
            raise InputError(
                "maps= has rotated or curved axes. Give the width of a cell [m], or a grid with "
                "northing and easting of one dimension each."
            )
        layers = []
        # The outermost zones have no second horizon, hence no thickness.
        between = names_of_zones(scene.horizon_names)[1:-1]
        for zone in [zone for zone in between if zone in scene.reservoir]:
            layers.append((zone, zone, ""))
            # A contact may be given for some zones only.
            fluids = [
                contact for contact in scene.contacts if not contact.zones or zone in contact.zones
            ]
            fluid_names = list(dict.fromkeys(contact.name for contact in fluids))
            # intervals between contacts are called as zones between horizons are
            parts = names_of_zones(fluid_names) if fluid_names else []
            layers += [(f"{zone} {part}", zone, part) for part in parts]
        names, zones, contacts = (tuple(row[k] for row in layers) for k in range(3))
        return cls(names, zones, contacts, nodes.coords["easting"][1], nodes.coords["northing"][1])

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of layers, rows and columns."""
        return len(self.names), len(self.northing), len(self.easting)

    @property
    def identity(self) -> str:
        """A hash of layers and nodes."""
        # Names and nodes: an ensemble with other layers cannot be continued.
        digest = hashlib.sha256(repr(("juxtaposition", self.names)).encode())
        digest.update(self.easting.tobytes() + self.northing.tobytes())
        return digest.hexdigest()

    def thickness(self, scene: Scene) -> np.ndarray:
        """Return the vertical thickness of each layer (n_layer, n_row, n_col) [m], 0 if absent."""
        # One grid for all realisations, so that maps can be summed.
        grid = xr.DataArray(
            np.empty(self.shape[1:]),
            coords={"northing": self.northing, "easting": self.easting},
            dims=("northing", "easting"),
        )
        made = np.zeros(self.shape, dtype=np.float32)
        # What is absent in this realisation has thickness 0 there, and is not computed.
        there = {(unit.zone, unit.contact) for unit in scene.units.values()}
        for k, (zone, part) in enumerate(zip(self.zones, self.contacts, strict=True)):
            if part and (zone, part) not in there:
                continue
            if not any(zone == other for other, _ in there):
                continue
            found = thickness_map(scene.units, zone, grid, contact=part or None)
            # Blocks are summed: a layer is one map.
            made[k] = np.nan_to_num(found.values).sum(axis=0)
        return made


# ---- juxtapositions ----------------------------------------
# Zones that face each other across faults, realisation by realisation: how likely, and how large.
#
# Areas are stored like volumes: one column for each fault and pair of zones, in the order in which
# realisations have them.


EXCEEDED = (90, 50, 10)  # %: P90 is exceeded by 90 % of the realisations
STATISTICS = ("P90", "P50", "P10", "mean", "sd", "base", "present")
LEAST = 10  # realisations for a tornado
MILLION = 1e6
TOTAL = {"reservoir": "reservoir", "all": "all units"}  # what tables call the sum of all

AREA, COLUMNS = "juxtaposed_area", "batch_pairs"
PAIRS = 64  # columns of a chunk


def areas_of(scene: Scene) -> dict[PairKey, float]:
    """
    Return the area of contact of each pair of zones across each fault of a scene [m2].

    Examples
    --------
    >>> from geosurf.synthetic import tilted_planes
    >>> world = tilted_planes(n=3)
    >>> found = areas_of(Scene(world.horizons, world.faults, world.box))
    >>> [*found][0]
    PairKey(fault='F1', zone_plus='above Top', zone_minus='above Top')
    """
    areas: dict[PairKey, float] = {}
    for fault in scene.faults_inside:  # one that has left the model has no area in it
        found = scene.juxtaposition(fault, "all")
        sides = (found.zone_plus.values, found.zone_minus.values, found.area.values)
        for plus, minus, area in zip(*(side.tolist() for side in sides), strict=True):
            key = PairKey(fault, str(plus), str(minus))
            areas[key] = areas.get(key, 0.0) + area
    return areas


class PairAreas:
    """The columns of areas in the store of an ensemble.

    Parameters
    ----------
    group : zarr.Group
        Of the ensemble.
    base : dict of PairKey to float
        Of the base case: its pairs come first.
    n, n_batch : int
        Numbers of realisations and batches.
    whole : int
        Batches that are written.
    """

    def __init__(
        self, group: Any, base: dict[PairKey, float], n: int, n_batch: int, whole: int
    ) -> None:
        self.group = group
        columns = [group[name][:].tolist() for name in PairKey._fields]
        known = int(group[COLUMNS][whole - 1]) if whole else 0
        self.keys = [PairKey(*row) for row in zip(*(c[:known] for c in columns), strict=True)]
        group[AREA].resize((n, group[AREA].shape[1]))
        group[COLUMNS].resize((n_batch,))
        self._add(base)

    @staticmethod
    def create(new: Callable[..., Any], batch: int) -> None:
        """Create the arrays; `new` creates one of the store."""
        new(AREA, "f8", ("realisation", "pair"), (batch, PAIRS), units="m2")
        new(COLUMNS, "i4", ("batch",), (1,))
        for name in PairKey._fields:
            new(name, str, ("pair",), (PAIRS,))

    def write(self, batch: int, at: slice, records: list[Record]) -> None:
        """Write the areas of a batch: NaN where a realisation failed, 0 for an absent pair."""
        self._add(dict.fromkeys(key for record in records for key in record.juxtaposed))
        if self.keys:
            self.group[AREA][at] = np.array(
                [
                    [np.nan if r.reason else r.juxtaposed.get(key, 0.0) for key in self.keys]
                    for r in records
                ]
            )
        self.group[COLUMNS][batch] = len(self.keys)

    def _add(self, keys: Iterable[PairKey]) -> None:
        """Give new pairs a column; those of an interrupted batch are written again."""
        known = set(self.keys)
        self.keys += [key for key in keys if key not in known]
        n = len(self.keys)
        for i, name in enumerate(PairKey._fields):
            self.group[name].resize((n,))
            if n:
                self.group[name][:] = np.array([key[i] for key in self.keys], dtype=object)
        area = self.group[AREA]
        if area.shape[1] != n:
            area.resize((area.shape[0], n))


def juxtaposition(result: xr.Dataset) -> xr.Dataset:
    """Return how likely zones face each other, see `Ensemble.juxtaposition`."""
    if AREA not in result.data_vars:
        raise InputError("this ensemble has no areas of juxtaposition. Run it with maps=True.")
    values = result[AREA].values[result.status.values == 1]
    if not len(values):
        raise InputError("no realisation of this ensemble has been built, so it has no areas.")
    area = {"units": "m2"}
    data: dict[str, Any] = {"probability": ("pair", (values > 0).mean(axis=0), {"units": "1"})}
    for key, share in (("P90", 0.1), ("P50", 0.5), ("P10", 0.9)):
        data[key] = ("pair", np.quantile(values, share, axis=0), area)
    data["mean"] = ("pair", values.mean(axis=0), area)
    return xr.Dataset(data, {name: ("pair", result[name].values) for name in PairKey._fields})


class UnitKey(NamedTuple):
    """The name of a unit, what it is a part of, and what it holds.

    A block may belong to another region in another realisation: that is another key.
    """

    name: str
    zone: str
    region: str
    block: str
    contact: str
    fluid: str


class PairKey(NamedTuple):
    """A fault and the zones on both of its sides."""

    fault: str
    zone_plus: str
    zone_minus: str


@dataclass(frozen=True, eq=False)
class Record:
    """
    What units hold, drawn numbers and maps of one realisation.

    Attributes
    ----------
    amounts : dict of UnitKey to tuple of float
        Columns of each unit, the gross rock volume first; empty if the realisation failed.
    numbers : dict of str to float
        Drawn value of each parameter.
    maps : ndarray of float32, shape (n_layer, n_row, n_col), or None
        Thickness of each layer [m], 0 where it is absent.
    reason : str
        Why it failed; empty if it did not.
    realisation : int
    juxtaposed : dict of PairKey to float
        Area of contact of zones across faults [m2]; with maps only.
    n_torn, n_searched : int
        Horizons that were torn as picked, and how many of them the plan of the base case did not
        close.
    n_warning : int
        How many different warnings there were.

    Examples
    --------
    >>> key = UnitKey("above Top", "above Top", "", "whole", "", "")
    >>> record = Record({key: (5.0,)}, {"throw F1": 31.5})
    >>> twin = Record.from_bytes(record.to_bytes())
    >>> twin.amounts == record.amounts, twin.numbers
    (True, {'throw F1': 31.5})
    """

    amounts: dict[UnitKey, tuple[float, ...]]
    numbers: dict[str, float] = field(default_factory=dict)
    maps: np.ndarray | None = None
    reason: str = ""
    realisation: int = -1
    n_warning: int = 0
    juxtaposed: dict[PairKey, float] = field(default_factory=dict)
    n_torn: int = 0
    n_searched: int = 0

    @classmethod
    def failed(cls, numbers: dict[str, float], reason: str) -> Record:
        """Return the record of a realisation that could not be built."""
        # Reasons are shown in tables: one line.
        return cls({}, numbers, None, " ".join(reason.split()) or "no reason is given")

    def to_bytes(self) -> bytes:
        """Return the record as the content of a file."""
        # Names and texts as JSON, numbers as arrays.
        head = {
            "units": [list(key) for key in self.amounts],
            "parameters": list(self.numbers),
            "reason": self.reason,
            "realisation": self.realisation,
            "n_warning": self.n_warning,
            "pairs": list(map(list, self.juxtaposed)),
            "torn": [self.n_torn, self.n_searched],
        }
        arrays: dict[str, Any] = {
            "head": np.frombuffer(json.dumps(head).encode(), dtype=np.uint8),
            "amounts": np.array([*self.amounts.values()], dtype=np.float64),
            "numbers": np.array([*self.numbers.values()], dtype=np.float64),
            "areas": np.array([*self.juxtaposed.values()], dtype=np.float64),
        }
        if self.maps is not None:
            arrays["maps"] = self.maps
        file = io.BytesIO()
        # Without pickles: reading a record runs no code.
        np.savez(file, allow_pickle=False, **arrays)
        return file.getvalue()

    @classmethod
    def from_bytes(cls, data: bytes) -> Record:
        """Return the record that a file holds."""
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            head = json.loads(arrays["head"].tobytes())
            keys = [UnitKey(*key) for key in head["units"]]
            pairs = [PairKey(*key) for key in head["pairs"]]
            return cls(
                dict(zip(keys, map(tuple, arrays["amounts"].tolist()), strict=True)),
                dict(zip(head["parameters"], arrays["numbers"].tolist(), strict=True)),
                arrays.get("maps", None),
                head["reason"], head["realisation"], head["n_warning"],
                dict(zip(pairs, arrays["areas"].tolist(), strict=True)), *head["torn"],
            )  # fmt: skip


def expect_ensemble(result: Any, who: str) -> None:
    """Refuse what is not the result of an ensemble."""
    if not {"bulk", "status", "drawn"} <= set(getattr(result, "data_vars", ())):
        raise InputError(
            f"{who} takes the data of an ensemble, not {type(result).__name__}. Call run_ensemble "
            "or open_ensemble."
        )


# ---- rock ----------------------------------------
# Rock and fluids of realisations: the arguments of `Scene.volumetrics`, some of them uncertain.


KEYS = (*ARGUMENTS, "fluids", "units")


@dataclass(frozen=True)
class RockProperty:
    """One number of `Scene.volumetrics` that is drawn: an uncertainty, which moves no surface.

    Attributes
    ----------
    parameter : str
        Name of its number: ``"porosity Top/Middle"``.
    by : distribution
    """

    parameter: str
    by: Any

    unit = "1"

    def prepare(self, given: Given) -> PreparedNumber:
        """Check the distribution; units of the base case decide whether there are such words."""
        by = distribution_of(self.by, self.parameter)
        return PreparedNumber(self.parameter, by, lambda change, number: None)


@dataclass(frozen=True, eq=False)
class Rock:
    """What an ensemble counts of the units of its realisations.

    Attributes
    ----------
    factors : tuple of Factor
        With numbers, maps and distributions; empty: gross rock volume only.
    rule : Factor
        Fluids by words of units.
    system : str
        Units of measure.
    """

    factors: tuple[Factor, ...] = ()
    rule: Factor = field(default_factory=lambda: fluids_rule(None))
    system: str = "metric"

    @classmethod
    def of(cls, given: Any, crs: str | None) -> Rock:
        """Make one of the ``volumetrics=`` of users, checked, with maps as grids.

        Raises
        ------
        InputError
            For what `Scene.volumetrics` refuses.
        """
        if given is None:
            return cls()
        if not isinstance(given, Mapping):
            raise InputError(
                f"volumetrics is {given!r}; give the arguments of Scene.volumetrics, as in "
                "{'net_to_gross': 0.8, 'porosity': Normal(0.22, 0.02)}."
            )
        for key in given:
            check_word(key, KEYS, f"volumetrics has {key!r}; its keys are {', '.join(KEYS)}.")
        system = given.get("units", "metric")
        check_system(system)
        rule, values = fluids_rule(given.get("fluids")), [given.get(key) for key in ARGUMENTS]
        if all(value is None for value in values):
            return cls((), rule, system)
        return cls(tuple(factors_of_rock(values, crs, drawn=True)), rule, system)

    @property
    def uncertain(self) -> tuple[RockProperty, ...]:
        """What is drawn."""
        return tuple(
            RockProperty(_parameter(factor, words), value)
            for factor in self.factors
            for words, value in factor.entries.items()
            if is_distribution(value)
        )

    @property
    def has_maps(self) -> bool:
        """Whether volumes are not enough: maps are integrated over the units themselves."""
        return any(isinstance(one, Lattice) for of in self.factors for one in of.entries.values())

    @property
    def columns(self) -> dict[str, dict[str, str]]:
        """Attributes of what is counted, by name."""
        return columns_of(len(self.factors), self.system)

    @property
    def identity(self) -> tuple[Any, ...]:
        """All that amounts depend on, as `content_of` takes it."""
        return (self.rule.entries, self.system, [
            (factor.name, sorted(words), (one.easting, one.northing, one.elevation)
             if isinstance(one, Lattice) else one)
            for factor in self.factors for words, one in factor.entries.items()
        ])  # fmt: skip

    def check(self, base: Units) -> None:
        """Refuse words that no unit of the base case has; those of a realisation may be fewer."""
        refuse_unknown_words(base, self.factors, self.rule)

    def amounts(
        self, units: Units, numbers: Mapping[str, float]
    ) -> dict[UnitKey, tuple[float, ...]]:
        """Return the columns of each unit; over- and underburden have a rock volume only."""
        factors = [self._drawn(factor, numbers) for factor in self.factors]
        part = units.included()
        fluids, values = amounts_of(part, factors, self.rule, self.system)
        in_unit = dict(
            zip(part, zip(fluids, map(tuple, values.tolist()), strict=True), strict=True)
        )
        size, none = SIZES[self.columns["bulk"]["units"]], (0.0,) * (len(self.columns) - 1)
        for name, unit in units.items():
            if name not in in_unit:
                in_unit[name] = "", (unit.volume / size, *none)
        return {
            UnitKey(unit.name, unit.zone, unit.region, unit.block, unit.contact, in_unit[name][0]):
            in_unit[name][1]
            for name, unit in units.items()
        }  # fmt: skip

    @staticmethod
    def _drawn(factor: Factor, numbers: Mapping[str, float]) -> Factor:
        """A factor with numbers in place of its distributions."""
        entries = dict(factor.entries)
        for words, value in factor.entries.items():
            if is_distribution(value):
                name = _parameter(factor, words)
                entries[words] = numbers[name]
                check_range(numbers[name], numbers[name], name)
        return replace(factor, entries=entries)


def _parameter(factor: Factor, words: frozenset[str]) -> str:
    """Name of the number that an argument has for some words, or for all other units."""
    others = [ELSEWHERE] if len(factor.entries) > 1 else []
    return " ".join([factor.name, *(sorted(words) or others)])
