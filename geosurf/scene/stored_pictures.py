"""Pictures that earlier runs drew of the same model, in the same way, are not drawn again."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.errors import GeosurfWarning
from geosurf.files.atomic import write_whole
from geosurf.render.overlay import overlay_of
from geosurf.render.palette import RGB
from geosurf.render.picture_style import PictureStyle, style_of
from geosurf.scene.picture import Picture
from geosurf.scene.pictures import draw_pictures, pictures_of
from geosurf.scene.result_cache import ResultCache
from geosurf.scene.scene import Scene
from geosurf.scene.stored_checks import name_of_model
from geosurf.warning import collected, warn


@dataclass(frozen=True)
class ListeningStyle(PictureStyle):
    """A style that notes for which names a picture asks a colour, whether they have one or not.

    Attributes
    ----------
    asked : set of str
    """

    asked: set[str] = field(default_factory=set)

    def colour(self, names: str | Iterable[str], default: RGB) -> RGB:
        """Return the colour of the first name that has one."""
        names = (names,) if isinstance(names, str) else tuple(names)
        self.asked.update(names)
        return super().colour(names, default)


def draw_with_cache(
    scene: Scene,
    folder: str | os.PathLike[str],
    on_file: Callable[[str], object],
    choice: Mapping[str, Any],
    cache: ResultCache,
) -> dict[str, Path]:
    """Draw the pictures of a scene as `Scene.render_pictures` does; those in the cache are copied.

    Parameters
    ----------
    scene : Scene
    folder : path-like
    on_file : callable
        Is called with the name of each file, when it is written.
    choice : mapping
        Options of `pictures_of`.
    cache : ResultCache

    Returns
    -------
    dict of str to pathlib.Path
        Captions and files.
    """
    plain = style_of(choice.get("style"))
    style = ListeningStyle(
        plain.theme, plain.transparent, plain.font, plain.colours, plain.colour_map
    )
    choice = {**choice, "style": style}

    # A picture depends on more of the model than it shows: a contact adds points to lines that it
    # crosses, and thickness is a sum over the units that it splits. So all of the model counts.
    model = name_of_model(scene)
    with scene._graph.memory.collecting():
        pictures = pictures_of(scene, **choice)
        if model is not None:
            pictures = [
                _stored(picture, (model, *_own_inputs(picture, choice)), style, cache)
                for picture in pictures
            ]
        return draw_pictures(pictures, folder, on_file)


def _own_inputs(picture: Picture, choice: Mapping[str, Any]) -> tuple[Any, ...]:
    """What a picture depends on beside the model: its options, without colours of names."""
    found: list[Any] = [picture.file, picture.caption]
    for option in picture.options:
        value = choice.get(option)
        if option == "style":
            value = replace(choice["style"], colours={}, asked=set())
        elif option == "overlay":
            found += overlay_of(value).arrays()
            continue
        elif option == "sections" and value is not None:
            # in full, since captions have their ends rounded
            value = [np.asarray(line).tolist() for line in value]
        found.append((option, repr(value)))
    return tuple(found)


def _stored(
    picture: Picture, inputs: tuple[Any, ...], style: ListeningStyle, cache: ResultCache
) -> Picture:
    """The picture, drawn only if the cache does not have it in the colours of its names."""

    def draw(path: Path) -> None:
        """Write the stored bytes, or draw and store it with its warnings."""
        warnings: list[GeosurfWarning] | None = None  # of the picture, once it is drawn here

        def drawn() -> list[GeosurfWarning]:
            """Draw it, unless this was done; return what it warns of."""
            nonlocal warnings
            if warnings is None:
                with collected() as warnings:
                    picture.draw(path)
            return warnings

        def names_asked() -> list[str]:
            """Draw the picture; return the names that it asks a colour for."""
            style.asked.clear()
            drawn()
            return sorted(style.asked)

        def content_drawn() -> np.ndarray:
            """Draw the picture and warn; return the bytes of its file."""
            for warning in drawn():
                warn(warning)
            return np.frombuffer(path.read_bytes(), np.uint8)

        # colours of other names change nothing: they are those of other pictures
        names = cache.get_or_compute("colours", inputs, names_asked)
        colours = tuple((name, style.colours[name]) for name in names if name in style.colours)
        content = cache.get_or_compute("picture", (*inputs, colours), content_drawn)
        if warnings is None:
            write_whole(path, content.tobytes())

    return replace(picture, draw=draw)


__all__ = ["draw_with_cache"]
