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
from geosurf.scene.graph import Graph
from geosurf.scene.pictures import Picture, draw_pictures, pictures_of
from geosurf.scene.result_cache import ResultCache, name_of_result
from geosurf.scene.scene import Scene
from geosurf.warning import collected, warn

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
    graph = scene._graph
    model = model_inputs(graph)
    looks = tuple((word, repr(choice.get(word))) for word in _LOOKS)
    overlay = overlay_of(choice.get("overlay")).arrays()
    with graph.memory.collecting():
        pictures = [
            _stored(picture, (*model, *_own_inputs(picture, choice), looks, *overlay), cache)
            for picture in pictures_of(scene, **choice)
        ]
        return draw_pictures(pictures, folder, on_file)


def model_inputs(graph: Graph) -> tuple[Any, ...]:
    """All that a model depends on, after reading, tearing, extending and truncating.

    More than a single picture shows: a stored picture is never of another model.
    """
    inputs, (levels, contacts) = graph.inputs, graph.fluids
    tops = graph.tops
    # what closed a sheet is marked on its map
    marked = [(name, *map(repr, sheet.warnings)) for name, sheet in graph.sheets.items()]
    rules = graph.ruled_faults.rules
    settings = (
        graph.box, tuple(graph.column.items()), inputs.tolerance, inputs.voxel_size,
        inputs.self_intersections, inputs.slivers, inputs.horizon_rules, rules,
        [(one.name, one.block, one.zones) for one in contacts], marked,
    )  # fmt: skip
    return (
        repr(settings), *graph.wholes, *levels,
        graph.origin_for(graph.wholes), np.empty(0) if graph.aoi is None else graph.aoi,
        *(() if tops is None else (tops.wells, tops.horizons, tops.points)),
    )  # fmt: skip


def _own_inputs(picture: Picture, choice: Mapping[str, Any]) -> tuple[Any, ...]:
    """What only this picture depends on: lines in full, since captions have their ends rounded."""
    if picture.file.startswith("section"):
        lines = choice.get("sections")
        lines = None if lines is None else [np.asarray(line).tolist() for line in lines]
        return (picture.file, picture.caption, repr(lines))
    return (picture.file, picture.caption)


def _stored(picture: Picture, inputs: tuple[Any, ...], cache: ResultCache) -> Picture:
    """The picture, drawn only if the cache does not have it."""
    name = name_of_result("picture", inputs)
    if name is None:
        return picture

    def draw(path: Path) -> None:
        """Copy the stored file, or draw and store it."""
        data = cache.load(name)
        if data is not None:
            write_whole(path, data)
            cache.n_found += 1
            return
        with collected() as found:
            picture.draw(path)
        for warning in found:
            warn(warning)
        cache.n_made += 1
        # a picture that warns is drawn again, so that the warning comes again
        if not found:
            cache.save(name, path.read_bytes())

    return replace(picture, draw=draw)


__all__ = ["draw_with_cache"]
