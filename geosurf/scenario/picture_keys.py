"""The keys of ``[pictures]``: what pictures look like."""

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


__all__ = ["PictureSettings"]
