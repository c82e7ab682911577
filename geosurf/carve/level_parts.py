"""Volumes of the parts that level fluid contacts make of finished units.

A level cuts no surface here: each face of a unit has a volume above the level and one below it, and
a moved contact passes over the faces that it crosses. Which parts exist follows from the heights of
the units, since each unit is connected. Where rounding could decide that, `carve_units` has to do
it, with the contacts among the surfaces.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.carve.blocks import WHOLE
from geosurf.carve.fluids import contacts_of_units, interval, parse_sides
from geosurf.carve.measures import BELOW, FLAT
from geosurf.carve.outside import box_of
from geosurf.carve.shells import Shells, unit_of_volume
from geosurf.carve.volume import doubtful_volume
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import distinct
from geosurf.model import FluidContact, Patches, Unit, Units
from geosurf.model.compartments import separators

_SURE = 2.0**20  # times a small volume: what its terms may sum up to, all taken as positive
_STEPS = 4096  # units in the last place of coordinates: nearer levels are left to the arrangement
_RANK = re.compile(r" #\d+$")


@dataclass(frozen=True)
class _Wholes:
    """What no contact changes of some units: kept with them, since contacts move often.

    Attributes
    ----------
    units : list of Unit
    faults : list of str
    zones : list of str
    words, on : list of tuple of str
        Sides of faults that name the block of each unit, and those that it lies on.
    ends : list of (float, float)
        Lowest and highest local elevation of each unit [m].
    margin, doubtful : float
        How near a level rounding may decide [m], and up to which volume [m3].
    """

    units: list[Unit]
    faults: list[str]
    zones: list[str]
    words: list[tuple[str, ...]]
    on: list[tuple[str, ...]]
    ends: list[tuple[float, float]]
    margin: float
    doubtful: float

    @classmethod
    def of(cls, patches: Patches, units: Units) -> _Wholes:
        """Return those of units, which are of these patches."""
        known: _Wholes | None = units.__dict__.get("_wholes")
        if known is not None:
            return known
        faults = list(separators(patches.names, [source.role for source in patches.sources]))
        listed, bounds = list(units.values()), box_of(patches)
        shells = [unit.__dict__["_shell"] for unit in listed]
        found = units.__dict__["_wholes"] = cls(
            listed, faults,
            [unit.zone for unit in listed],
            [_words(unit.block, faults) for unit in listed],
            [unit.fault_sides for unit in listed],
            [of.heights(row) for of, row in shells],
            _STEPS * float(np.spacing(np.abs(bounds).max())), doubtful_volume(bounds),
        )  # fmt: skip
        return found


@dataclass(frozen=True)
class _Split:
    """A unit, its contacts from the top down, how many lie above it, and those that cut it."""

    unit: Unit
    row: int
    names: list[str]
    first: int
    cuts: list[float]


def parts_at_levels(
    patches: Patches, units: Units, contacts: Sequence[FluidContact]
) -> Units | None:
    """
    Return the parts of units above, between and below level contacts: names, labels and volumes.

    Parameters
    ----------
    patches : Patches
    units : Units
        Of these patches, without contacts.
    contacts : sequence of FluidContact
        From the top down, each with an elevation as ``at``.

    Returns
    -------
    Units or None
        In the order and with the names of `carve_units`. None where a contact is within rounding
        error of the highest or lowest point of a unit, where contacts of a unit are out of order,
        where a part is so small against its terms that its volume needs exact arithmetic, and for
        contacts that `carve_units` refuses.

    Examples
    --------
    >>> from geosurf import TriSurface, build_contacts, build_walls, carve_units, rebuild_surfaces
    >>> box = (0, 10, 0, 10, -10, 0)
    >>> corners = [[-1, -1, -4], [11, -1, -4], [11, 11, -4], [-1, 11, -4]]
    >>> top = TriSurface("Top", "horizon", corners, [[0, 1, 2], [0, 2, 3]])
    >>> patches = rebuild_surfaces([top, *build_walls(box)])
    >>> _, contacts = build_contacts({"OWC": -6.0}, box)
    >>> parts = parts_at_levels(patches, carve_units(patches), contacts)
    >>> {name: round(unit.volume, 9) for name, unit in parts.items()}
    {'above Top above OWC': 400.0, 'below Top above OWC': 200.0, 'below Top below OWC': 400.0}
    """
    wholes = _Wholes.of(patches, units)
    splits = _splits(wholes, contacts, float(patches.origin[2]))
    if splits is None or not splits:
        return None
    shells: Shells = wholes.units[0].__dict__["_shell"][0]
    volumes = _volumes(shells, splits, wholes.doubtful)
    if volumes is None:
        return None
    parts = [
        unit_of_volume(
            split.unit, interval(split.names, split.first + k),
            tuple(split.names[: split.first + k]), volume,
        )
        for split, of in zip(splits, volumes, strict=True)
        for k, volume in enumerate(of)
    ]  # fmt: skip
    w, e, s, n, low, high = units.box
    return Units(
        parts, (w, e, s, n, low, high), footprint=units.footprint, slivers=units.sliver_settings
    )


def _splits(
    wholes: _Wholes, contacts: Sequence[FluidContact], origin: float
) -> list[_Split] | None:
    """What contacts do to each unit; None where rounding could decide it."""
    try:
        applied = contacts_of_units(contacts, wholes.zones, wholes.words, wholes.on, wholes.faults)
    except InputError:  # of several blocks to name, `carve_units` names the one it comes to first
        return None

    margin, found = wholes.margin, []
    for unit, rows, (lowest, highest) in zip(wholes.units, applied, wholes.ends, strict=True):
        levels = [float(contacts[k].at) - origin for k in rows]
        if any(low >= high - margin for high, low in pairwise(levels)):
            return None
        if any(min(abs(level - lowest), abs(level - highest)) <= margin for level in levels):
            return None
        cuts = [level for level in levels if lowest < level < highest]
        first = sum(level > highest for level in levels)
        row = unit.__dict__["_shell"][1]
        found.append(_Split(unit, row, [contacts[k].name for k in rows], first, cuts))
    return found


def _words(block: str, faults: Sequence[str]) -> tuple[str, ...]:
    """The sides of faults that name a block.

    Examples
    --------
    >>> sorted(_words("F1+ F2- #2", ["F1", "F2"])), _words("whole", ["F1"])
    (['F1+', 'F2-'], ())
    """
    sides = parse_sides("" if block == WHOLE else block, faults)
    if sides is None:  # the second block with these sides has a number
        rest = _RANK.sub("", block)
        sides = parse_sides("" if rest == WHOLE else rest, faults)
    return tuple(sides or ())


def _volumes(shells: Shells, splits: Sequence[_Split], doubtful: float) -> list[list[float]] | None:
    """Volumes of the parts of each unit, from the top down [m3]; None where rounding may matter.

    Up to a `doubtful` volume a part counts only if its terms are small as well: exact arithmetic
    has to find small sums of large terms.
    """
    by_level: dict[float, np.ndarray] = {}
    for level in sorted({level for split in splits for level in split.cuts}):
        cut = [shells.faces(split.row) for split in splits if level in split.cuts]
        by_level[level] = _beside(shells, distinct(*cut), level)

    found = []
    for split in splits:
        if not split.cuts:
            found.append([split.unit.volume])
            continue
        rows = shells.faces(split.row)
        way = np.where(shells.sides[rows, 1] == split.row, 1.0, -1.0)[:, None]
        above = [way * by_level[level][rows, :3] for level in split.cuts]
        lowest = by_level[split.cuts[-1]]
        below = way * lowest[rows, 3:]

        # what is above each contact, less what is above the one over it; then the lowest part
        sums = [above[0], *(np.hstack([b, -a]) for a, b in pairwise(above)), below]
        volumes = [math.fsum(part.ravel().tolist()) / 6.0 for part in sums]
        for volume, part in zip(volumes, sums, strict=True):
            if volume <= doubtful and volume * _SURE <= np.abs(part).sum() / 6.0:
                return None
        found.append(volumes)
    return found


def _beside(shells: Shells, faces: np.ndarray, level: float) -> np.ndarray:
    """Six times the volume of some faces above a level (three numbers, to be added) and below it.

    Faces that the level does not cross follow from the volume below them that is known.
    """
    cells = shells.cells
    found = np.zeros((len(cells.surface_of), 6))
    low, high = cells.heights[faces].T
    for some, at in ((faces[low >= level], slice(0, 3)), (faces[high <= level], slice(3, 6))):
        shift = 3.0 * (cells.level - level) * cells.below[some, FLAT]
        found[some, at] = np.column_stack([cells.below[some, BELOW], shift])

    rows = np.zeros(len(found), dtype=bool)
    rows[faces[(low < level) & (high > level)]] = True
    cut = cells.beside_level(rows, level)
    found[rows, 0:2], found[rows, 3:5] = cut[rows, 0:2], cut[rows, 2:4]
    return found
