"""The inputs of a scene as they were given, opened: what an ensemble varies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from geosurf.lazy import xarray
from geosurf.model import Sheet, TriSurface, Units
from geosurf.model.regions import KnownRegions, Places
from geosurf.model.sheets import TearPlan
from geosurf.scene.depth import carried_points
from geosurf.scene.faults import LongerFaults
from geosurf.scene.inputs import INPUTS, Box, undeclared
from geosurf.scene.scene import Scene
from geosurf.scene.surfaces import opened_contacts, opened_horizon
from geosurf.scene.tearing import warnings_of_passed


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
    if inputs.tear is None:
        return graph.untied(name), {}
    data = opened_horizon(value, inputs.options)
    return data, undeclared(data, inputs.options)


def horizons_with_zones(
    horizons: Mapping[str, Any], zones: Mapping[str, Any], tear: bool, crs: str | None
) -> tuple[dict[str, Any], xarray.Dataset]:
    """
    Return horizons with those that zones make, youngest first, and how these were corrected.

    Parameters
    ----------
    horizons, zones, tear, crs
        As for `Scene`.
    """
    scene = Scene(horizons, zones=zones, tear=tear, crs=crs)
    return dict(scene._plain.inputs.horizons), scene.zone_corrections


def given_fault(scene: Scene, name: str) -> TriSurface:
    """Return a fault as given: neither extended nor truncated."""
    return scene._given.read.fault(name)


def given_in_depth(scene: Scene) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return horizons and faults of a scene in time as its velocities make them, neither torn."""
    inputs = scene._plain.inputs
    return dict(inputs.horizons), dict(inputs.given_faults)


def sheets_in_time(scene: Scene) -> dict[str, Sheet]:
    """Return the sheets in time of a scene that becomes depth."""
    horizons = scene._in_time.inputs.horizons
    return {name: one for name, one in horizons.items() if isinstance(one, Sheet)}


def prepared_faults(scene: Scene) -> dict[str, TriSurface]:
    """Return all faults as extended and truncated, before tears make them longer."""
    return {name: scene._plain.faults.surface(name) for name in scene.fault_names}


def torn_like(scene: Scene, longer: LongerFaults, plans: Mapping[str, TearPlan]) -> Scene:
    """Return the scene, torn at faults as long as another scene needed them, first as it was."""
    twin = scene.replace()
    twin._plain.longer, twin._plain.plans = dict(longer), dict(plans)
    return twin


def longer_in_depth(scene: Scene, in_time: Scene, longer: Mapping[str, TriSurface]) -> LongerFaults:
    """
    Return the faults of a scene, and how long tears of the base case needed them, in depth.

    Parameters
    ----------
    scene : Scene
        In depth, before its horizons are torn.
    in_time : Scene
        The one in time that it was made from, with its velocities.
    longer : mapping of str to TriSurface
        The longer faults, in time.
    """
    inputs, found = in_time._inputs, {}
    for name, fault in longer.items():
        vertices = carried_points(
            in_time._in_time, inputs, fault.vertices, ("longer", name), str(inputs.time),
            to_depth=True,
        )  # fmt: skip
        after = TriSurface(name, "fault", vertices, fault.triangles)
        found[name] = (scene._plain.faults.surface(name), after)
    return found


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


def torn_scene(scene: Scene, horizons: Mapping[str, Sheet], **changes: Any) -> Scene:
    """
    Return a scene with horizons that were torn at its faults, and with faults as these ended up.

    Parameters
    ----------
    scene : Scene
        Its rules have made the faults ready.
    horizons : mapping of str to Sheet
    **changes
        Further inputs, as `Scene.replace` takes them.

    Returns
    -------
    Scene
        It lists what the rules of `scene` did to the faults, and proposes for these.
    """
    torn = scene.replace(horizons=horizons, **changes)
    if "faults" in changes:  # its own rules do nothing more
        torn._plain.prepared_by = scene._plain.ruled_faults
        rules, given = scene._plain.faults.rules, prepared_faults(scene)
        passed = warnings_of_passed(rules, given, changes["faults"])
        torn._plain.memory.warn(*passed)
    return torn


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
