"""The inputs of a scene as they were given, opened: what an ensemble varies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from geosurf.model import Sheet, TriSurface, Units
from geosurf.model.regions import KnownRegions, Places
from geosurf.model.sheets import TearPlan
from geosurf.scene.depth import carried_points
from geosurf.scene.faults import LongerFaults
from geosurf.scene.inputs import INPUTS, Box, undeclared
from geosurf.scene.memory import OnStart
from geosurf.scene.result_cache import ResultCache
from geosurf.scene.scene import Scene
from geosurf.scene.surfaces import opened_contacts, opened_horizon


def given_horizon(scene: Scene, name: str) -> tuple[Any, dict[str, Any]]:
    """
    Return a horizon before it is torn and tied, and what its data do not declare.

    Parameters
    ----------
    scene : Scene
    name : str

    Returns
    -------
    (TriSurface, Sheet or data, dict)
        A surface, or the data of a horizon that is to be torn, with the keywords ``positive`` and
        ``length_unit`` that count for them.
    """
    is_made = any(one.horizon == name for one in scene._inputs.made)
    graph, inputs = scene._given, scene._inputs
    if is_made:  # by a zone
        graph, inputs = scene._plain, scene._plain.inputs
    value = inputs.horizons[name]
    if isinstance(value, Sheet):
        return value, {}
    if name not in inputs.torn:
        return graph.untied(name), {}
    data = opened_horizon(value, inputs.options)
    return data, undeclared(data, inputs.options)


def given_fault(scene: Scene, name: str) -> TriSurface:
    """Return a fault as given: neither extended nor truncated."""
    return scene._given.read.fault(name)


def in_depth(scene: Scene) -> Scene:
    """Return a scene in time as what its velocities make of it, for changes in metres."""
    twin = object.__new__(Scene)
    twin.__dict__.update(_inputs=scene._plain.inputs, _given=scene._plain)
    return twin


def prepared_faults(scene: Scene) -> dict[str, TriSurface]:
    """Return all faults as extended and truncated, before tears make them longer."""
    return {name: scene._plain.faults.surface(name) for name in scene.fault_names}


def torn_like(
    scene: Scene, longer: LongerFaults, plans: Mapping[str, TearPlan], still: Mapping[str, Sheet]
) -> Scene:
    """Let a new scene be torn at faults as long as another one needed them, first as that was.

    Horizons that stand `still` have their sheets, as long as they end on the faults of the scene.
    """
    scene._plain.longer, scene._plain.plans, scene._plain.still = longer, plans, still
    return scene


def longer_in_depth(scene: Scene, longer: Mapping[str, TriSurface]) -> LongerFaults:
    """
    Return the faults of a scene, and how long tears of the base case needed them, in depth.

    Parameters
    ----------
    scene : Scene
        With velocities.
    longer : mapping of str to TriSurface
        The longer faults, in time.
    """
    inputs, in_depth = scene._inputs, {}
    for name, fault in longer.items():
        vertices = carried_points(
            scene._in_time, inputs, fault.vertices, ("longer", name), str(inputs.time),
            to_depth=True,
        )  # fmt: skip
        after = TriSurface(name, "fault", vertices, fault.triangles)
        in_depth[name] = (scene._plain.faults.surface(name), after)
    return in_depth


def frame_of(scene: Scene) -> tuple[Box, np.ndarray | None]:
    """
    Return the box and the area of a scene before its horizons are torn: no sheet moves them.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    (tuple of float, ndarray of float64 (n, 2) or None)
        West, east, south, north, bottom and top [m]; corners of the area, None if it is the box.
    """
    return scene._plain.box, scene._plain.aoi


@contextmanager
def reported(scene: Scene, on_start: OnStart) -> Iterator[None]:
    """Let a function be called before each step of a scene in the block."""
    memory = scene._given.memory
    before, memory.on_start = memory.on_start, on_start
    try:
        yield
    finally:
        memory.on_start = before


def surfaces_so_far(scene: Scene) -> tuple[TriSurface, ...]:
    """Return all surfaces, torn if nothing has kept horizons from that."""
    graph = vars(scene).get("_graph", scene._plain)
    return tuple(map(graph.whole, graph.inputs.names))


def keep_on_disk(scene: Scene, cache: ResultCache | None) -> None:
    """Let the family of a scene look for torn horizons in a folder, and put them there."""
    scene._given.memory.store.disk = cache


def keep_results_apart(scene: Scene) -> None:
    """Let a scene take results from its family, and give none to it: nobody will change it."""
    scene._plain.memory.shares = False


def measured_units(scene: Scene, whole: bool) -> Units:
    """Return the units of a scene; unless they are to be whole, labels and volumes may do."""
    graph = scene._graph
    return graph.units if whole else graph.measured_units


def known_regions(scene: Scene) -> KnownRegions | None:
    """Return the regions of a scene, as others take their names; not the scene itself."""
    has_some, graph = bool(scene.regions), scene._graph
    if not has_some or graph._regions is None:
        return None
    known = graph._regions.known_as("base case")
    return replace(known, places=partial(_as_they_are, graph._regions.places()))


def _as_they_are(places: Places) -> Places:
    """Return what other processes can take along, too."""
    return places


def named_like(scene: Scene, known: KnownRegions | None) -> Scene:
    """Return the scene; its regions, and those of scenes made from it, have the names of others."""
    twin = scene.replace()
    twin._given.known_regions = known
    return twin


def given_contacts(scene: Scene) -> dict[str, Any]:
    """Return fluid contacts by name, with files and grids as surfaces."""
    return opened_contacts(scene._inputs.contacts, scene._inputs.options)


def given_settings(scene: Scene) -> dict[str, Any]:
    """Return all other inputs of a scene, by name."""
    surfaces = ("horizons", "faults", "contacts")
    return {key: getattr(scene._inputs, key) for key in INPUTS if key not in surfaces}
