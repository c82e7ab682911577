"""The pictures that a scenario asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from geosurf.conventions.packages import DRAWING, is_installed, missing_sentence, need_plots
from geosurf.errors import DependencyError
from geosurf.model.expected import flag_of
from geosurf.read import read_points, read_polygons
from geosurf.scenario.keys import Scenario
from geosurf.scenario.output_keys import OutputSettings
from geosurf.scenario.plan import drawn_wells

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.render.overlay import PictureOverlay


def will_draw(scenario: Scenario, pictures: bool | None) -> bool:
    """
    Return whether a run draws pictures.

    Parameters
    ----------
    scenario : Scenario
    pictures : bool or None
        None draws where matplotlib is installed.

    Raises
    ------
    DependencyError
        If the caller or the scenario asks for pictures that cannot be drawn here.
    """
    if pictures is None:
        asked, missing = asked_for(scenario), missing_sentence("they need", *DRAWING)
        if asked and missing:
            raise DependencyError(
                f"{scenario.path}: {asked} asks for pictures, and {missing}; or run it with "
                "--no-pictures (pictures=False)."
            )
        return is_installed("matplotlib")
    if flag_of(pictures, "pictures"):
        need_plots()
    return pictures


def asked_for(scenario: Scenario) -> str:
    """Return the first key of a scenario that asks for pictures which are not drawn anyway."""
    output, usual = scenario.output, OutputSettings()
    for word in ("views", "search", "sections_m"):
        value = getattr(output, word)
        if value and value != getattr(usual, word):
            return f"output.{word}"
    return "" if scenario.pictures.camera is None else "pictures.camera"


def choice_of_pictures(scenario: Scenario) -> dict[str, Any]:
    """Return what `Scene.render_pictures` takes for the pictures that a scenario asks for."""
    # Keys of the scenario have units in their names, arguments of the scene do not.
    output, pictures = scenario.output, scenario.pictures
    return {
        "views": output.views,
        "exploded": output.exploded,
        "maps": output.maps,
        "thickness": output.thickness,
        "allan": output.allan,
        "throw": output.throw,
        "sections": output.sections_m,
        "search": output.search,
        "exaggeration": output.exaggeration,
        "size": output.size_px,
        "clip": output.clip,
        "camera": pictures.camera,
        "zoom": pictures.zoom,
        "only": pictures.only or None,
        "colour_by": pictures.colour_by,
        "style": pictures.style,
        "overlay": overlay_of_files(scenario),
    }


def overlay_of_files(scenario: Scenario) -> PictureOverlay:
    """Read the wells, polygons and data points of a scenario.

    Raises
    ------
    InputError
        If a file cannot be read, or it does not state whether z is depth and the scenario neither.
    """
    from geosurf.render.overlay import PictureOverlay  # loaded by those who draw

    known: dict[str, Any] = {"positive": scenario.positive, "length_unit": scenario.length_unit}
    pictures = scenario.pictures
    return PictureOverlay(
        wells=drawn_wells(scenario),
        polygons={
            name: read_polygons(file, **known) for name, file in (pictures.polygons or {}).items()
        },
        points={name: read_points(file, **known) for name, file in (pictures.points or {}).items()},
    )
