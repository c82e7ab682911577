"""Warnings about the inputs of a scene that look wrong."""

from __future__ import annotations

from geosurf.conventions.crs import warn_of_unclear_crs
from geosurf.model import Sheet
from geosurf.model.tops import Tops
from geosurf.scene.inputs import SceneInputs
from geosurf.scene.memory import Memory
from geosurf.scene.reference_systems import refuse_other_systems
from geosurf.scene.repeated_faults import warnings_of_repeats
from geosurf.scene.surfaces import InputSurfaces
from geosurf.scene.wells import warnings_of_names


def warn_of_inputs(
    inputs: SceneInputs, memory: Memory, read: InputSurfaces, tops: Tops | None
) -> None:
    """Warn of reference systems, names of tops and torn horizons that look wrong.

    Parameters
    ----------
    inputs : SceneInputs
    memory : Memory
        Keeps the warnings.
    read : InputSurfaces
        All surfaces have been read.
    tops : Tops or None
    """
    # a reference system that some inputs declare, and others do not
    with memory.collecting():
        known = {name: read.crs[name] for name in inputs.names if name in read.crs}
        warn_of_unclear_crs(refuse_other_systems(known, inputs.crs, tops, inputs.aoi))

    # one file under two names
    rules = (*inputs.rules, *inputs.horizon_rules)
    memory.warn(*warnings_of_repeats(map(read.fault, inputs.faults), rules))

    # tops of horizons that the scene does not have
    if tops is not None:
        memory.warn(*warnings_of_names(tops, tuple(inputs.horizons)))

    # what was assumed when a horizon was torn has been issued there; the scene lists it, too. How
    # much longer all horizons made a fault is listed already, where the scene tore them
    whole = {one.subject for one in memory.warnings if one.kind == "fault extended"}
    for horizon in inputs.horizons.values():
        if isinstance(horizon, Sheet):
            for one in horizon.warnings:
                if one.kind != "fault extended" or one.subject not in whole:
                    memory.warn(one, issued=True)


__all__ = ["warn_of_inputs"]
