"""Keys of faults: files, pieces of a mesh, polygons, and how far they are continued."""

# ruff: noqa: RUF009 - `key` makes a dataclasses.field

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.conventions import METRES_PER_UNIT
from geosurf.model.faults import SIDES
from geosurf.scenario import values
from geosurf.scenario.declare import key
from geosurf.scenario.tables import tables
from geosurf.scenario.values import KeyPath, above_zero_or_none

# `strike` stands for both ends along strike.
FAULT_SIDES = ("strike", *SIDES)


# Functions, because a dataclass field cannot be used twice.
def positive_key() -> Any:
    """Declare the direction of z in a file."""
    meaning = "Whether values are elevations or depths, for a file that does not declare it."
    return key(meaning, values.one_of("up", "down"), default=None)


def length_unit_key() -> Any:
    """Declare the unit of z in a file."""
    meaning = "Length unit of elevations, for a file that does not declare it."
    return key(meaning, values.one_of(*METRES_PER_UNIT), default=None)


def columns_key() -> Any:
    """Declare the columns of a table."""
    meaning = (
        "Of a table with other headings: the columns x, y and z, by name or by number from 1. "
        "Sticks take two more: number of the stick, and name of the fault."
    )
    return key(meaning, values.columns, default=None)


def decimal_key() -> Any:
    """Declare the decimal sign of a table."""
    return key("Decimal sign of a table.", values.one_of(".", ","), default=".")


@values.check("a number above 0, or a table of sides such as {up = 50, down = 80}")
def distances(_: KeyPath, value: Any) -> float | dict[str, float] | None:
    """One distance, or one for each side."""
    if not isinstance(value, Mapping):
        return above_zero_or_none(value)
    found = {side: above_zero_or_none(one) for side, one in value.items()}
    right = found and all(side in FAULT_SIDES and one for side, one in found.items())
    return {side: one for side, one in found.items() if one} if right else None


@dataclass(frozen=True, kw_only=True)
class PolygonInput:
    """One ``[[faults.polygons]]``: the polygon of a fault on one horizon. The fault passes through
    both sides of its polygons, and continues along their dip. One horizon is enough.
    """

    horizon: str = key("The horizon on which it was drawn.", values.text)
    file: Path = key(
        "`.pol`, `.csv`, `.dat`, `.txt` and others with lines, each point with its elevation; "
        "relative to the scenario.",
        values.file,
    )
    polygon: int | None = key(
        "Which polygon of the file, counted from 1. Left out: the only one.",
        values.count,
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class FaultInput:
    """One ``[[faults]]``: in any order."""

    name: str = key("Name in all results.", values.text)
    # One of both: checked when all keys are known.
    file: Path | None = key(
        "`.ts` (GOCAD), `.vtp` and other meshes, `.pol`, `.csv` (sticks), `.nc` (parametric grid); "
        "relative to the scenario. Give this or `polygons`.",
        values.file,
        default=None,
    )
    name_in_file: str | None = key(
        "Of a file with several faults: which one. Left out: `name`.", values.text, default=None
    )
    piece: int | None = key(
        "Of a mesh in several pieces: which one, counted from 1, the largest. Left out: all, as "
        "one fault.",
        values.count,
        default=None,
    )
    polygons: tuple[PolygonInput, ...] = key(
        "Polygons of the fault, one for each horizon, in place of `file`.",
        tables(PolygonInput),
        default=(),
    )
    positive: str | None = positive_key()
    length_unit: str | None = length_unit_key()
    columns: tuple[str, ...] | tuple[int, ...] | None = columns_key()
    decimal: str = decimal_key()
    # Continued by a distance, or until the fault leaves the box: two different wishes.
    lengthen_m: float | dict[str, float] | None = key(
        "Distance by which the fault is continued along its dip and strike, before `extend`: one, "
        "or one for each side.",
        distances,
        unit="m",
        default=None,
    )
    lengthen: tuple[str, ...] = key(
        "Sides on which the fault is continued by `lengthen_m`. Left empty: all.",
        values.some_of(*FAULT_SIDES),
        default=(),
    )
    extend: tuple[str, ...] = key(
        "Sides on which the fault is continued until it leaves the model box: `strike` is both "
        "ends, `start` and `end` follow the right-hand rule.",
        values.some_of(*FAULT_SIDES),
        default=(),
    )

    @property
    def distances(self) -> dict[str, float]:
        """How far the fault is continued, by side; empty if it is not."""
        if self.lengthen_m is None:
            return {}
        # Without named sides a fault is lengthened on all of them.
        if isinstance(self.lengthen_m, Mapping):
            return dict(self.lengthen_m)
        return dict.fromkeys(self.lengthen or SIDES, self.lengthen_m)

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
    """

    apply: bool = key(
        "Whether proposals are applied, one after another until none is left. Rules of "
        "`[[truncations]]` stand. The console lists each proposal with its reason.",
        values.switch,
        default=False,
    )
    reach_m: float | None = key(
        "Largest distance by which a fault stops short of another one that it is continued to. "
        "Left out: a fifth of the root of the smaller fault's area.",
        values.above_zero,
        unit="m",
        default=None,
    )


def check_faults(faults: tuple[FaultInput, ...], at: KeyPath) -> None:
    """Each fault comes from a file or from polygons, and is lengthened in one way."""
    for entry in faults:
        where = f"faults[{entry.name!r}]"
        place = at.of(where)
        with place.noting():
            if (entry.file is None) == (not entry.polygons):
                place.refuse(f"{where}: give either file or [[faults.polygons]].")
            for word in ("name_in_file", "piece") if entry.polygons else ():
                if getattr(entry, word) is not None:
                    place.inside(word).refuse(
                        f"{where}: {word} needs file, and polygons are given. Remove {word}."
                    )
            horizons = [one.horizon for one in entry.polygons]
            twice = next((one for one in horizons if horizons.count(one) > 1), None)
            if twice is not None:
                place.inside("polygons").refuse(
                    f"{where}: two polygons are of horizon {twice!r}. Give one for each horizon."
                )
        with place.noting():
            if isinstance(entry.lengthen_m, Mapping) and entry.lengthen:
                place.inside("lengthen").refuse(
                    f"{where}: lengthen_m names sides already. Remove lengthen."
                )
