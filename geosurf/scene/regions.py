"""The regions of a scene: proposed, named, or as the scene that it was made from has them."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.carve.regions import propose_regions
from geosurf.errors import GeosurfWarning
from geosurf.measure.regions import overlap, region_map, regions_by_name
from geosurf.model import Patches, Units
from geosurf.model.regions import KnownRegions, Regions, label_regions
from geosurf.scene.surfaces import opened_outline
from geosurf.warning import issue


class NamedRegions:
    """Regions of some units, found when they are first requested.

    Parameters
    ----------
    patches, units : Patches, Units
    given : mapping of str to object
        As `Scene` takes them, checked.
    known : KnownRegions or None
        Regions of the scene that this one was made from.
    """

    def __init__(
        self, patches: Patches, units: Units, given: Mapping[str, Any], known: KnownRegions | None
    ) -> None:
        self.patches, self.units, self.given, self.known = patches, units, given, known
        self.warnings: list[GeosurfWarning] = []

    @cached_property
    def found(self) -> Regions:
        """The regions."""
        proposals, known = propose_regions(self.units), self.known
        shared = None
        if known is not None and not known.has_same_blocks(proposals):
            assert known.places is not None
            box, before = known.places()
            there = region_map(self.units, proposals, box)
            shared = overlap(before, there, (len(known.labels), len(proposals)))
        labels = label_regions(proposals, known, shared, tuple(self.given))

        # names of a scene before keep to their regions; others are looked for
        kept = {name for name, _ in known.labels} if known else set()
        new = {name: _opened(value) for name, value in self.given.items() if name not in kept}
        if new:
            for k, name in regions_by_name(self.patches, self.units, proposals, new).items():
                labels[k] = name, labels[k][1]
        found = Regions(proposals, labels)
        for name in self.given:
            if name not in found:
                self.warnings.append(_lost(name))
                issue(self.warnings[-1])
        self.known = None  # the model before is no longer needed
        return found

    @property
    def found_already(self) -> bool:
        """Whether anybody has requested the regions, and there are some."""
        return bool(self.__dict__.get("found"))

    def known_as(self, model: Hashable) -> KnownRegions:
        """What scenes made from this one take names from."""
        labels, proposals = zip(*self.found.proposals, strict=True)
        blocks = tuple(tuple(proposal.blocks) for proposal in proposals)
        return KnownRegions(labels, blocks, model, self.places)

    def places(self) -> tuple[tuple[float, ...], np.ndarray]:
        """The box, and the row of the region at places all over its map."""
        return self.units.box, self._map

    @cached_property
    def _map(self) -> np.ndarray:
        proposals = [proposal for _, proposal in self.found.proposals]
        return region_map(self.units, proposals, self.units.box)


def _opened(value: Any) -> Any:
    """A place or sides of faults as they are; a polygon as an array of corners."""
    is_plain = isinstance(value, tuple) and isinstance(value[0], str | float)
    return value if is_plain else np.asarray(opened_outline(value), dtype=np.float64)


def _lost(name: str) -> GeosurfWarning:
    return GeosurfWarning(
        "region", name,
        f"Region {name!r} is gone: none of the blocks that it had is a region of its own any more.",
        f"Name a place in it again: scene.replace(regions={{{name!r}: (easting, northing)}}).",
    )  # fmt: skip
