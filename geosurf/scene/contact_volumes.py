"""Volumes of a scene with fluid contacts: from the model without them, cut at their levels.

The model without contacts is the same for all contacts, and comes from memory once a scene of the
family has built it. A moved contact then passes over the units that it cuts, and nothing else.
"""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

from geosurf.carve.fluids import parts_at_levels
from geosurf.conventions import counted, is_number, shared_name
from geosurf.model import Units
from geosurf.scene.graph import Graph

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray


def volumes(graph: Graph) -> xarray.DataArray:
    """Return the volume of each unit by zone, block and contact [m3]; see `Scene.volumes`.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2000.0})
    >>> _ = scene.volumes
    >>> deeper = scene.replace(contacts={"OWC": -2010.0})
    >>> found = deeper.volumes
    >>> [step.stage for step in deeper.steps if step.outcome == "ran"]
    ['contacts']
    """
    found = parts(graph)
    return graph.units.volumes if found is None else found.volumes


def parts(graph: Graph) -> Units | None:
    """Labels and volumes of all units; None where only the arrangement with contacts has them."""
    inputs = graph.inputs
    if not inputs.contacts or inputs.compartments or inputs.slivers.merge:
        return None
    surfaces, contacts = graph.fluids
    named = [("contact", surface.name) for surface in surfaces]
    named += [("input", name) for name in inputs.names]
    if not all(is_number(one.at) for one in contacts) or shared_name(named):
        return None

    # the same inputs without contacts, read once
    without = copy.copy(inputs)
    without.__dict__["contacts"] = {}
    base = Graph(without, graph.memory, graph.prepared_by)
    base.read = graph.read
    for place in ("box", "aoi", "given_area", "default_area"):  # no contact changes these
        base.__dict__[place] = getattr(graph, place)
    units, patches = base.units, base.patches
    if units.report["thin"]:
        return None

    fluids = tuple((one.name, one.block, one.zones, float(one.at)) for one in contacts)
    found: Units | None = graph.memory.get_or_compute(
        "contacts", ", ".join(surface.name for surface in surfaces),
        ("level parts", base.units_key, fluids), lambda: parts_at_levels(patches, units, contacts),
        lambda parts: "cut with the surfaces" if parts is None else counted(len(parts), "unit"),
    )  # fmt: skip
    return found
