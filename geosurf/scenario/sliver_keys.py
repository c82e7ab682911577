"""Keys of a scenario about units that are too small to count: ``[slivers]``."""

from __future__ import annotations

from dataclasses import dataclass

from geosurf.model.slivers import SliverSettings
from geosurf.scenario import values
from geosurf.scenario.declare import key


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


__all__ = ["SliversInput"]
