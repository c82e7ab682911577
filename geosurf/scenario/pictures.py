"""The pictures that a scenario asks for."""

from __future__ import annotations

from typing import Any

from geosurf.scenario.keys import OutputSettings, PictureSettings


def choice_of_pictures(output: OutputSettings, pictures: PictureSettings) -> dict[str, Any]:
    """Return what `Scene.render_pictures` takes for the pictures that a scenario asks for."""
    # Keys of the scenario have units in their names, arguments of the scene do not.
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
    }
