"""Regions: parts of a field that run through all zones, and their names."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import Any, Protocol

import numpy as np

from geosurf.conventions import (
    area_text,
    check_word,
    counted,
    grouped,
    is_number,
    known_names,
    volume_text,
)
from geosurf.conventions.card import Card
from geosurf.errors import InputError
from geosurf.model.base import Noun

Block = tuple[str, str]  # zone, and block of the zone
Places = tuple[tuple[float, ...], np.ndarray]  # a box, and the row of the region all over its map
LEAST = 1e-3  # of the volume of the reservoir: smaller regions become parts of others
HOW = (
    "Give {name: (easting, northing)}, {name: polygon} or {name: ('F1+', 'F2-')}: a place in the "
    "region, corners around it (n, 2) or a file of them, or sides of faults."
)
_DIGITS = 9  # volumes that agree to this many digits are equal: rounding does not rank them


@dataclass(frozen=True)
class Proposal:
    """Blocks that belong together, by the horizon area that they share.

    Attributes
    ----------
    blocks : dict of (str, str) to float
        Volume by zone and block [m3], zone by zone.
    remnants : tuple of (str, str)
        Those that were too small for a region of their own.
    volume : float
        Of those in the reservoir [m3].
    """

    blocks: dict[Block, float]
    remnants: tuple[Block, ...]
    volume: float


@dataclass(frozen=True)
class Region(Noun):
    """A part of the field that runs through all zones, as a segment in Petrel or RMS.

    Attributes
    ----------
    name : str
    blocks : tuple of (str, str)
        Zone, and block of the zone.
    remnants : tuple of (str, str)
        Those of its blocks that were too small for a region of their own.
    volume : float
        Gross rock volume (GRV) of its part of the reservoir [m3].
    """

    name: str
    blocks: tuple[Block, ...]
    remnants: tuple[Block, ...]
    volume: float

    def __str__(self) -> str:
        zones = grouped(block for block in self.blocks if block not in self.remnants)
        parts = "; ".join(f"{zone}: {', '.join(blocks)}" for zone, blocks in zones.items())
        more = f"; {counted(len(self.remnants), 'remnant')}" if self.remnants else ""
        return f"{self.name}: GRV {volume_text(self.volume)} ({parts}{more})"


class Regions(Noun, Mapping[str, Region]):
    """Regions by name, the largest first; prints as a list of them.

    Parameters
    ----------
    proposals : sequence of Proposal
        The largest first.
    labels : sequence of (str, str)
        Name and letter of each. Those with one name are one region.
    """

    def __init__(self, proposals: Sequence[Proposal], labels: Sequence[tuple[str, str]]) -> None:
        self._proposals, self._labels = tuple(proposals), tuple(labels)
        parts = grouped(zip((name for name, _ in labels), proposals, strict=True))
        self._regions = {
            name: Region(
                name,
                tuple(block for proposal in parts_of_name for block in proposal.blocks),
                tuple(block for proposal in parts_of_name for block in proposal.remnants),
                math.fsum(proposal.volume for proposal in parts_of_name),
            )
            for name, parts_of_name in parts.items()
        }
        self._of = {
            block: proposal.name for proposal in self._regions.values() for block in proposal.blocks
        }

    def __getitem__(self, name: str) -> Region:
        if not isinstance(name, str) or name not in self._regions:
            raise KeyError(f"no region is called {name!r}. The regions are {known_names(self)}")
        return self._regions[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._regions)

    def __len__(self) -> int:
        return len(self._regions)

    def __repr__(self) -> str:
        return f"<Regions: {', '.join(self)}>"

    def __str__(self) -> str:
        return "\n".join(map(str, self.values()))

    def _card(self) -> Card:
        """Return name, volume and blocks of each region."""
        return Card(counted(len(self), "region"), [tuple(str(one).split(": ", 1)) for one in
                                                   self.values()])  # fmt: skip

    def of(self, zone: str, block: str) -> str:
        """Name of the region of a block; '' for blocks above and below all regions."""
        return self._of.get((zone, block), "")

    @property
    def proposals(self) -> Iterator[tuple[tuple[str, str], Proposal]]:
        """Name and letter of each proposed region, and its blocks."""
        return zip(self._labels, self._proposals, strict=True)


@dataclass(frozen=True)
class KnownRegions:
    """Regions of a scene, as scenes made from it take their names.

    Attributes
    ----------
    labels : tuple of (str, str)
        Name and letter of each.
    blocks : tuple of tuple of (str, str)
    model : hashable
        What the units of the scene depend on.
    places : callable, optional
        () -> the box of the scene, and the row of the region at places all over its map.
    """

    labels: tuple[tuple[str, str], ...] = ()
    blocks: tuple[tuple[Block, ...], ...] = ()
    model: Hashable = ()
    places: Callable[[], Places] | None = field(default=None, compare=False)

    def of_blocks(self, proposals: Sequence[Proposal]) -> np.ndarray:
        """Volume that each known region has in blocks of the same names, float64 (n, n_new)."""
        return np.array(
            [[math.fsum(one.blocks.get(block, 0.0) for block in of) for one in proposals]
             for of in self.blocks]
        ).reshape(len(self.blocks), len(proposals))  # fmt: skip

    def has_same_blocks(self, proposals: Sequence[Proposal]) -> bool:
        """Whether all blocks have the names that blocks of the known regions have."""
        return {b for of in self.blocks for b in of} == {b for of in proposals for b in of.blocks}


class RegionFinder(Protocol):
    """What finds the regions of some units when they are first requested."""

    @property
    def found(self) -> Regions:
        """The regions."""


def opposite(side: str) -> str:
    """The other side of a fault: ``F1-`` for ``F1+``."""
    return side[:-1] + ("-" if side.endswith("+") else "+")


def label_regions(
    proposals: Sequence[Proposal],
    known: KnownRegions | None = None,
    overlap: np.ndarray | None = None,
    taken: Sequence[str] = (),
) -> list[tuple[str, str]]:
    """
    Return name and letter of each region: those of a known one, or a new letter.

    Parameters
    ----------
    proposals : sequence of Proposal
        The largest first.
    known : KnownRegions, optional
        Of the model that this one was made from.
    overlap : ndarray of int64, shape (n_known, n_new), optional
        How much they have in common. The largest number counts, one for one; then the volume in
        blocks of the same names.
    taken : sequence of str
        Names that are no letters.

    Examples
    --------
    >>> one, two = (Proposal({("T/B", f"F1{side}"): 9.0}, (), 9.0) for side in "+-")
    >>> known = KnownRegions((("A", "A"), ("B", "B")), (tuple(one.blocks), tuple(two.blocks)))
    >>> label_regions([two, one], known)
    [('B', 'B'), ('A', 'A')]
    """
    known = known or KnownRegions()
    alike = known.of_blocks(proposals)
    shared = np.zeros(alike.shape, dtype=np.int64) if overlap is None else overlap
    labels: dict[int, tuple[str, str]] = {}
    left = set(range(len(known.labels)))
    pairs = zip(*(rows.tolist() for rows in np.nonzero((alike > 0.0) | (shared > 0))), strict=True)
    for before, k in sorted(
        pairs, key=lambda at: (-shared[at], -nine_digits(float(alike[at])), at)
    ):
        if before in left and k not in labels:
            labels[k] = known.labels[before]
            left.discard(before)
    used = {*taken, *(word for label in known.labels for word in label)}
    fresh = (letters for letters in _letters() if letters not in used)
    return [labels[k] if k in labels else (next(fresh),) * 2 for k in range(len(proposals))]


def _letters() -> Iterator[str]:
    """A, B ... Z, AA, AB ..."""
    alphabet = [chr(ord("A") + k) for k in range(26)]
    words: list[str] = [""]
    while True:
        words = [word + letter for word in words for letter in alphabet]
        yield from words


def nine_digits(value: float) -> float:
    """A number that rounding does not rank."""
    return float(f"{value:.{_DIGITS}g}")


def check_regions(regions: Any) -> dict[str, Any]:
    """
    Return what names regions: points as two floats, sides as words, all else as it is given.

    Raises
    ------
    InputError
        If it is no mapping, or a value can be no place, polygon or sides of faults.

    Examples
    --------
    >>> check_regions({"North": [1, 2], "Block": ["F1+"]})
    {'North': (1.0, 2.0), 'Block': ('F1+',)}
    """
    if not isinstance(regions, Mapping):
        raise InputError(f"regions is {regions!r}. {HOW}")
    checked: dict[str, Any] = {}
    for key, value in regions.items():
        name = str(key)
        if not name.strip() or name in checked:
            raise InputError(f"regions has {name!r} twice, or an empty name. Name each once.")
        parts = list(value) if isinstance(value, list | tuple) else []
        if len(parts) == 2 and all(map(is_number, parts)):
            value = tuple(map(float, parts))
        elif parts and all(isinstance(part, str) for part in parts):
            if wrong := [part for part in parts if part[-1:] not in ("+", "-")]:
                raise InputError(
                    f"regions: {name!r} names {wrong[0]!r}, but a side ends in + or -. Write "
                    f"'{wrong[0]}+' for its hanging wall, '{wrong[0]}-' for its footwall."
                )
            value = tuple(parts)
        elif isinstance(value, str) and value[-1:] in ("+", "-"):
            raise InputError(f"regions: {name!r} is the text {value!r}. Write ({value!r},) for it.")
        elif not isinstance(value, str | PathLike) and np.ndim(value) != 2:
            raise InputError(f"regions: {name!r} is {value!r}. {HOW}")
        checked[name] = value
    return checked


# ---- slivers ----------------------------------------
# Slivers: units that are too small to count, and what became of them.


SHARE = 1e-4  # of its zone: what a smaller unit holds is lost in the rounding of most tables
MERGE = "merge"
KEYS = ("min_volume", "merge")
HOW_SLIVERS = (
    'Write slivers="merge", a volume in m³ as in slivers=5000.0, or both: '
    'slivers={"min_volume": 5000.0, "merge": True}'
)


@dataclass(frozen=True)
class SliverSettings:
    """Which units are slivers, and what becomes of them.

    Attributes
    ----------
    min_volume : float or None
        Units below this volume are slivers [m3]. None: units below 1/10 000 of their zone, and
        units thinner than the rounding error of their vertices.
    merge : bool
        Whether they are merged into neighbours.
    """

    min_volume: float | None = None
    merge: bool = False

    @property
    def rule(self) -> str:
        """Which units are slivers, in words.

        Examples
        --------
        >>> SliverSettings().rule, SliverSettings(5000.0).rule
        ('below 0.01 % of the zone', 'below 5000 m³')
        """
        if self.min_volume is None:
            return f"below {100 * SHARE:g} % of the zone"
        return f"below {volume_text(self.min_volume)}"


@dataclass(frozen=True)
class MergedSliver(Noun):
    """A sliver that became part of a neighbour.

    Attributes
    ----------
    name : str
        Of the sliver, before.
    volume : float
        [m3].
    into : str
        The unit that it is part of now.
    across : tuple of str
        Surfaces between the two.
    area : float
        Area that they shared [m2].
    place : (easting, northing, elevation)
        Middle of the bounds of the sliver [m].
    """

    name: str
    volume: float
    into: str
    across: tuple[str, ...]
    area: float
    place: tuple[float, float, float]

    def __str__(self) -> str:
        surfaces = " and ".join(self.across)
        return (
            f"{self.name} ({volume_text(self.volume)}) is part of {self.into}, across "
            f"{area_text(self.area)} of {surfaces}"
        )


def sliver_settings(slivers: Any) -> SliverSettings:
    """
    Return which units are slivers, or raise an error that shows what to write.

    Examples
    --------
    >>> sliver_settings("merge")
    SliverSettings(min_volume=None, merge=True)
    >>> sliver_settings(5000)
    SliverSettings(min_volume=5000.0, merge=False)
    """
    # Settings from an earlier call pass through, as in `Scene.replace`.
    if slivers is None or isinstance(slivers, SliverSettings):
        return slivers or SliverSettings()
    if isinstance(slivers, str) and slivers == MERGE:
        return SliverSettings(merge=True)
    # A number alone is a volume: slivers are listed, and nothing is merged.
    if is_number(slivers):
        return SliverSettings(_volume(slivers))
    if not isinstance(slivers, Mapping):
        raise InputError(f"slivers is {slivers!r}. {HOW_SLIVERS}.")
    # Unknown keys first: a misspelt one would otherwise count as left out.
    for key in slivers:
        check_word(key, KEYS, f"slivers has no option {key!r}.", f" {HOW_SLIVERS}.")
    # Both keys may be left out: the default rule, and no merging.
    volume, merge = slivers.get("min_volume"), slivers.get("merge", False)
    if not isinstance(merge, bool):
        raise InputError(f"slivers: merge is {merge!r}, expected True or False. {HOW_SLIVERS}.")
    return SliverSettings(None if volume is None else _volume(volume), merge)


def _volume(value: Any) -> float:
    """A volume [m3], or an error."""
    # 0 is a limit that no unit is below: nothing counts as a sliver.
    if not (is_number(value) and value >= 0):
        raise InputError(
            f"slivers: the volume is {value!r}, expected cubic metres, 0 or more. {HOW_SLIVERS}."
        )
    return float(value)
