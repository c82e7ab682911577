"""What a model depends on, and its certificate: that of an earlier run of this model is found."""

from __future__ import annotations

from typing import Any

import numpy as np

from geosurf.model import Certificate
from geosurf.scene.result_cache import ResultCache, name_of_result
from geosurf.scene.scene import Scene


def check_with_cache(scene: Scene, cache: ResultCache | None) -> Certificate:
    """
    Return the certificate of a scene, as `Scene.check` does; one in the cache is not made again.

    Parameters
    ----------
    scene : Scene
    cache : ResultCache or None

    Returns
    -------
    Certificate
        The same in both cases: a model has the same bytes whenever it is built from the same
        inputs, with the same version, on the same kind of machine. One that fails is not stored.
    """
    model = None if cache is None else name_of_model(scene)
    if cache is None or model is None:
        return scene.check()
    return scene._take_certificate(
        cache.get_or_compute("certificate", (model,), scene.check, keep=lambda made: made.ok)
    )


def name_of_model(scene: Scene) -> str | None:
    """
    Return a hash of all that a model depends on, after reading, tearing, extending and truncating.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    str or None
        None if an input is only known by its identity.
    """
    graph = scene._graph
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
    parts: tuple[Any, ...] = (
        repr(settings), *graph.wholes, *levels,
        graph.origin_for(graph.wholes), np.empty(0) if graph.aoi is None else graph.aoi,
        *(() if tops is None else (tops.wells, tops.horizons, tops.points)),
    )  # fmt: skip
    return name_of_result("model", parts)


__all__ = ["check_with_cache", "name_of_model"]
