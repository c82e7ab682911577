"""Pictures that earlier runs drew of the same model, in the same way, are not drawn again."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.files.atomic import write_whole
from geosurf.render.overlay import overlay_of
from geosurf.scene.pictures import Picture, draw_pictures, pictures_of
from geosurf.scene.result_cache import ResultCache
from geosurf.scene.scene import Scene
from geosurf.scene.stored_checks import name_of_model

# options that decide how a picture looks, not which pictures there are
_LOOKS = ("exaggeration", "size", "clip", "camera", "zoom", "only", "colour_by", "style")


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
    looks = tuple((word, repr(choice.get(word))) for word in _LOOKS)
    overlay = overlay_of(choice.get("overlay")).arrays()

    # A picture depends on more of the model than it shows: a contact adds points to lines that it
    # crosses, and thickness is a sum over the units that it splits. So all of the model counts.
    model = name_of_model(scene)
    with scene._graph.memory.collecting():
        pictures = pictures_of(scene, **choice)
        if model is not None:
            pictures = [
                _stored(picture, (model, *_own_inputs(picture, choice), looks, *overlay), cache)
                for picture in pictures
            ]
        return draw_pictures(pictures, folder, on_file)


def _own_inputs(picture: Picture, choice: Mapping[str, Any]) -> tuple[Any, ...]:
    """What only this picture depends on: lines in full, since captions have their ends rounded."""
    if picture.file.startswith("section"):
        lines = choice.get("sections")
        lines = None if lines is None else [np.asarray(line).tolist() for line in lines]
        return (picture.file, picture.caption, repr(lines))
    return (picture.file, picture.caption)


def _stored(picture: Picture, inputs: tuple[Any, ...], cache: ResultCache) -> Picture:
    """The picture, drawn only if the cache does not have it."""

    def draw(path: Path) -> None:
        """Write the stored bytes, or draw and store it with its warnings."""

        def drawn() -> np.ndarray:
            """Draw the picture; return the bytes of its file."""
            picture.draw(path)
            return np.frombuffer(path.read_bytes(), np.uint8)

        content = cache.get_or_compute("picture", inputs, drawn)
        if not path.exists():
            write_whole(path, content.tobytes())

    return replace(picture, draw=draw)


__all__ = ["draw_with_cache"]
