"""The pictures that a scenario asks for."""

from __future__ import annotations

from geosurf.gallery import Picture, pictures_of
from geosurf.scenario.keys import OutputSettings
from geosurf.scene import Scene


def wanted_pictures(scene: Scene, output: OutputSettings) -> list[Picture]:
    """Return the pictures that a scenario asks for, not yet drawn."""
    return pictures_of(
        scene,
        views=output.views,
        exploded=output.exploded,
        maps=output.maps,
        thickness=output.thickness,
        allan=output.allan,
        sections=output.sections_m,
        search=output.search,
        exaggeration=output.exaggeration,
        size=output.size_px,
        clip=output.clip,
    )
