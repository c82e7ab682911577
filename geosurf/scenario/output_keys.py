"""The keys of ``[search]`` and ``[output]``: what a run draws and writes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from geosurf.scenario import values
from geosurf.scenario.declare import key

VIEWS = (
    # Oblique views first, then along the axes.
    *("southwest", "southeast", "northwest", "northeast"),
    *("south", "north", "east", "west", "top"),
)
# format -> the file that it gives, and what is in it
FORMATS = {
    "vtm": ("units.vtm", "the units, one `.vtp` each in the folder `units`"),
    "vtp": ("curves.vtp", "the curves where surfaces meet"),
    "csv": ("volumes.csv", "the table of volumes"),
    "nc": ("volumes.nc", "the table of volumes, with units as attributes"),
    "pl": ("curves.pl", "the curves for GOCAD"),
    "ml": ("units.ml", "the sealed model with its regions, for GOCAD and OpenGeode"),
    "epc": ("surfaces.epc", "horizons and faults as RESQML 2.0.1, with `surfaces.h5`"),
}


@dataclass(frozen=True, kw_only=True)
class SearchSettings:
    """``[search]``: how candidates are found. Changes the cost, never the result."""

    voxel_size_m: float | None = key(
        "Edge of the search voxels. Left out: chosen from the size of the triangles.",
        values.above_zero,
        unit="m",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class OutputSettings:
    """``[output]``: which pictures and files are made."""

    # which pictures are drawn
    views: tuple[str, ...] = key(
        "Pictures of horizons, faults and curves, one for each direction to look from.",
        values.some_of(*VIEWS),
        default=("southwest",),
    )
    maps: bool = key("A map of each horizon.", values.switch, default=True)
    thickness: bool = key(
        "A thickness map of each zone between two horizons.", values.switch, default=True
    )
    allan: bool = key(
        "An Allan diagram of each fault: the juxtaposition across it.",
        values.switch,
        default=True,
    )
    throw: bool = key("The throw of all horizons along each fault.", values.switch, default=True)
    sections_m: tuple[Any, ...] | None = key(
        "Vertical sections, each along a line of eastings and northings. Left out: two through the "
        "middle of the box.",
        values.lines,
        unit="m",
        default=None,
    )
    clip: bool = key("Whether pictures are clipped to the model.", values.switch, default=True)
    exploded: bool = key("An exploded view of the units.", values.switch, default=True)
    search: tuple[str, str] | None = key(
        "Two surfaces: a picture of how the voxel search finds their curve.",
        values.pair_of_names,
        default=None,
    )

    # how pictures look
    exaggeration: float | None = key(
        "Vertical exaggeration of the pictures. Left out: a round number that reads well.",
        values.above_zero,
        default=None,
    )
    size_px: tuple[int, int] = key(
        "Width and height of the pictures.", values.picture_size, unit="pixels", default=(1280, 800)
    )

    # files of results
    formats: tuple[str, ...] = key(
        "Files to write: " + "; ".join(f"`{k}`: {what}" for k, (_, what) in FORMATS.items()) + ".",
        values.some_of(*FORMATS),
        default=("vtm", "vtp", "csv", "nc"),
    )
