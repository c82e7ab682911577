"""Slivers: units that are too small to count, and what became of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from geosurf.conventions import area_text, did_you_mean, is_number, volume_text
from geosurf.errors import InputError
from geosurf.model.base import Noun

SHARE = 1e-4  # of its zone: what a smaller unit holds is lost in the rounding of most tables
MERGE = "merge"
KEYS = ("min_volume", "merge")
HOW = (
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
        raise InputError(f"slivers is {slivers!r}. {HOW}.")
    # Unknown keys first: a misspelt one would otherwise count as left out.
    for key in slivers:
        if key not in KEYS:
            raise InputError(f"slivers has no option {key!r}.{did_you_mean(key, KEYS)} {HOW}.")
    # Both keys may be left out: the default rule, and no merging.
    volume, merge = slivers.get("min_volume"), slivers.get("merge", False)
    if not isinstance(merge, bool):
        raise InputError(f"slivers: merge is {merge!r}, expected True or False. {HOW}.")
    return SliverSettings(None if volume is None else _volume(volume), merge)


def _volume(value: Any) -> float:
    """A volume [m3], or an error."""
    # 0 is a limit that no unit is below: nothing counts as a sliver.
    if not (is_number(value) and value >= 0):
        raise InputError(
            f"slivers: the volume is {value!r}, expected cubic metres, 0 or more. {HOW}."
        )
    return float(value)
