"""The pictures that a scenario asks for, with the captions that the report prints."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.render import (
    doctor,
    render_map,
    render_scene,
    render_search,
    render_units,
)
from geosurf.scenario.keys import OutputSettings
from geosurf.scene import Scene


@dataclass(frozen=True)
class Picture:
    """One picture: what it shows, its file, and how it is drawn there."""

    caption: str
    file: str
    draw: Callable[[Path], Any]
    needs_opengl: bool = True


def wanted_pictures(scene: Scene, output: OutputSettings) -> list[Picture]:
    """Return the pictures that a scenario asks for, not yet drawn."""
    style: dict[str, Any] = {"size": output.size_px, "exaggeration": output.exaggeration}
    pictures = [
        Picture(
            f"Horizons, faults and their curves, seen from the {view}.",
            f"view_{view}.png",
            lambda path, view=view: render_scene(scene, path, view=view, **style),
        )
        for view in output.views
    ]
    if output.exploded:
        pictures.append(
            Picture(
                "The units, drawn apart: zones up and down, blocks sideways.",
                "units_exploded.png",
                lambda path: render_units(scene.units, path, **style),
            )
        )
    if output.maps:
        pictures += [_map(scene, name, output.size_px) for name in scene.horizon_names]
    if output.search is not None:
        pictures.append(_search(scene, *output.search, style))
    return pictures


def _map(scene: Scene, name: str, size: tuple[int, int]) -> Picture:
    slug = re.sub(r"[^A-Za-z0-9+-]+", "_", name).strip("_")
    row = scene.horizon_names.index(name)
    return Picture(
        f"{name}: elevation, and the lines where other surfaces meet it.",
        f"map_{row:02d}_{slug}.png",
        lambda path: render_map(scene.surface(name), scene.curves, path=path, size=size),
        needs_opengl=False,
    )


def _search(scene: Scene, first: str, second: str, style: dict[str, Any]) -> Picture:
    def draw(path: Path) -> None:
        """Write the picture, if there is anything to show."""
        found = scene.search(first, second)
        if found is not None:
            a, b = scene.surface(first), scene.surface(second)
            render_search(a, b, found, scene.curves, path, **style)

    return Picture(
        f"How {first} and {second} are searched: voxels leave few faces to compare.",
        "search.png",
        draw,
    )


def cannot_draw() -> str:
    """Return why nothing in three dimensions can be drawn here, or ''."""
    return "".join(sentence for name, fit, sentence in doctor() if name == "pictures" and not fit)
