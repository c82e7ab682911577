"""The keys of ``[search]`` and ``[output]``: what a run draws and writes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.errors import DependencyError, InputError
from geosurf.render.picture_style import COLOUR_BY, THEMES, PictureStyle
from geosurf.render.views import check_zoom
from geosurf.scenario import values
from geosurf.scenario.declare import key

# ---- picture keys ----------------------------------------
# The keys of ``[pictures]``: what pictures look like.


@values.check("azimuth and height of the viewer in degrees: [225, 30]")
def angles(at: values.KeyPath, value: Any) -> tuple[float, float] | None:
    """Two angles, the second from -90 to 90."""
    if not isinstance(value, list) or len(value) != 2:
        return None
    azimuth, height = (values.number(at, angle) for angle in value)
    return (azimuth, height) if -90.0 <= height <= 90.0 else None


@values.check("a number from 0.1 to 100")
def zoom(_: values.KeyPath, value: Any) -> float | None:
    """How much larger than the whole model."""
    try:
        return check_zoom(value)
    except InputError:
        return None


@values.check('a table of names and colours such as {Top = "teal", F1 = "#8c2f2b"}')
def colours(at: values.KeyPath, value: Any) -> Mapping[str, Any] | None:
    """Colours by the name of a surface, zone or unit."""
    return _styled(at, "colours", value) if isinstance(value, dict) else None


@values.check("the name of a font that is installed")
def font(at: values.KeyPath, value: Any) -> str | None:
    """A font for names in other scripts."""
    return _styled(at, "font", value) if isinstance(value, str) else None


@values.check('"elevation", "thickness" or a colour map of matplotlib such as "viridis"')
def colour_map(at: values.KeyPath, value: Any) -> str | None:
    """A colour map."""
    return _styled(at, "colour_map", value) if isinstance(value, str) else None


@values.check('a table of names and files such as {Licence = "licence.pol"}')
def files(at: values.KeyPath, value: Any) -> dict[str, Path] | None:
    """Files by the name that pictures give to them."""
    if not isinstance(value, dict) or not value:
        return None
    return {name: values.file(at.inside(name), path) for name, path in value.items()}


def _styled(at: values.KeyPath, word: str, value: Any) -> Any:
    """What a style makes of a value; its sentence becomes that of the scenario."""
    try:
        return getattr(PictureStyle(**{word: value}), word)
    except DependencyError:  # nothing can be drawn here, and the rest of the scenario can be run
        return value
    except InputError as error:
        at.refuse(f"{at.words}: {error}")


@dataclass(frozen=True, kw_only=True)
class PictureSettings:
    """``[pictures]``: what pictures look like. Which are drawn is in `[output]`."""

    theme: str = key(
        "Dark text on white, or light text on a dark background.",
        values.one_of(*THEMES),
        default="light",
    )
    transparent: bool = key("Whether the background is transparent.", values.switch, default=False)
    font: str | None = key(
        "An installed font, for names in scripts that DejaVu Sans lacks, such as Chinese.",
        font,
        default=None,
    )
    colours: Mapping[str, Any] | None = key(
        "Colours of surfaces, zones and units by name.", colours, default=None
    )
    colour_map: str | None = key(
        "Of elevation, thickness and properties. Left out: the one that suits the picture.",
        colour_map,
        default=None,
    )
    colour_by: str = key(
        "What the exploded view is coloured by.", values.one_of(*COLOUR_BY), default="unit"
    )
    only: tuple[str, ...] = key(
        "Units of the exploded view, by their name, zone or block. Left empty: all.",
        values.names,
        default=(),
    )
    camera: tuple[float, float] | None = key(
        "A further view of horizons, faults and curves: azimuth of the viewer, clockwise from "
        "north, and height above the horizontal.",
        angles,
        unit="degrees",
        default=None,
    )
    zoom: float = key(
        "Scale of that view: 2 shows the middle of the model twice as large.", zoom, default=1.0
    )
    wells: Mapping[str, Path] | None = key(
        "Paths of wells, from the top down, by the name of the well: files as for `[wells]`, or of "
        "points. Drawn on views, maps and sections.",
        files,
        default=None,
    )
    polygons: Mapping[str, Path] | None = key(
        "Polygons that are drawn there: files, by name.", files, default=None
    )
    points: Mapping[str, Path] | None = key(
        "Data points that are drawn there: files, by name.", files, default=None
    )

    @property
    def style(self) -> PictureStyle:
        """The style of all pictures."""
        return PictureStyle(
            self.theme, self.transparent, self.font, self.colours or {}, self.colour_map
        )


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
