"""Keys of a scenario that limit the model: ``[aoi]`` and ``[box]``."""

# ruff: noqa: RUF009 - `key` makes a dataclasses.field

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.scenario import values
from geosurf.scenario.declare import key


@dataclass(frozen=True, kw_only=True)
class AreaOfInterest:
    """``[aoi]``: a polygon that the model fills.

    Leave the table out for the box, or without a box for the outline that all horizons share.
    """

    file: Path | None = key(
        "A closed polygon, `.pol` or `.csv`. Give one of these keys.", values.file, default=None
    )
    corners_m: tuple[tuple[float, float], ...] | None = key(
        "Easting and northing around the polygon.", values.corners, unit="m", default=None
    )
    rectangle: bool = key(
        "Whether to take the largest axis-parallel rectangle that all horizons cover.",
        values.switch, default=False,
    )  # fmt: skip

    @property
    def value(self) -> Any:
        """The area as `Scene` takes it."""
        # Exactly one of the three is set: `validate` has seen to it.
        return "rectangle" if self.rectangle else self.file or self.corners_m


@dataclass(frozen=True, kw_only=True)
class BoxRanges:
    """``[box]``: the model box. Leave the table out for the outline that all horizons share."""

    easting_m: tuple[float, float] = key("West and east side.", values.interval, unit="m")
    northing_m: tuple[float, float] = key("South and north side.", values.interval, unit="m")
    elevation_m: tuple[float, float] = key(
        "Bottom and top, positive up.", values.interval, unit="m"
    )

    @property
    def sides(self) -> tuple[float, float, float, float, float, float]:
        """West, east, south, north, bottom, top [m]."""
        # The order of `Scene(box=)`.
        return (*self.easting_m, *self.northing_m, *self.elevation_m)


__all__ = ["AreaOfInterest", "BoxRanges"]
