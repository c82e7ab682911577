"""Measures of a scene that are more than a call of `geosurf.measure`, as functions of its graph.

Stages of measuring are imported when they are first needed: a scene that is only built does not
load them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from geosurf.conventions import HORIZON_DIMS, counted, did_you_mean, is_word
from geosurf.errors import GeometryError, InputError
from geosurf.model.base import multiblock, need_pyvista
from geosurf.model.expected import flag_of, name_of
from geosurf.model.sheets import Sheet
from geosurf.scene.graph import Graph
from geosurf.scene.reference_systems import check_system_of_places, refuse_other_systems
from geosurf.scene.wells import opened_tops, warnings_of_names

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista
    import xarray

    from geosurf.measure.locate import Boundaries, Locator

Lines = list[np.ndarray]
Labelled = TypeVar("Labelled", "xarray.DataArray", "xarray.Dataset")


def names_inside(graph: Graph, role: str) -> tuple[str, ...]:
    """Return names of surfaces of a role that bound units, in the order of the scene."""
    inside, sources = graph.units.rows_inside, graph.patches.sources
    found = (source for i, source in enumerate(sources) if i in inside)
    return tuple(source.name for source in found if source.role == role)


def to_pyvista(graph: Graph) -> pyvista.MultiBlock:
    """Return horizons, faults, curves and units as named blocks; see `Scene.to_pyvista`."""
    need_pyvista()  # before the model is built
    surfaces = {
        f"{role}s": multiblock({name: graph.patches.surface(name).to_pyvista() for name in names})
        for role, names in (("horizon", graph.inputs.horizons), ("fault", graph.inputs.faults))
    }
    units, curves = graph.units.to_pyvista(), graph.curves.to_pyvista()
    return multiblock({**surfaces, "curves": curves, "units": units})


def volume_error_bound(graph: Graph) -> float:
    """Return by how much horizons with fewer nodes change volumes inside the box, at most [m3].

    Infinite if such a horizon is torn.
    """
    horizons = graph.inputs.horizons
    if any(isinstance(one, Sheet) and one.fewer_nodes for one in horizons.values()):
        return math.inf
    few = [graph.surface(name) for name in horizons]
    few = [one for one in few if "volume_error" in one.vertex_data]
    if not few:
        return 0.0
    from geosurf.triangulate.decimate import bound_of_change  # loaded where nodes are left out

    sides, names = graph.box[:4], {one.name for one in few}
    others = [one for one in graph.enclosed if one.name not in names] + few
    return sum(
        (bound_of_change(one, [two for two in others if two is not one], sides) for one in few), 0.0
    )


def of_units(
    graph: Graph, what: str, measure: Callable[..., xarray.Dataset], asked: str | np.ndarray
) -> xarray.Dataset:
    """Return a measure of patches and units for a name or a line, from memory if it is there."""
    run = lambda: measure(graph.patches, graph.units, asked)  # noqa: E731
    if isinstance(asked, np.ndarray):
        return _remembered(graph, what, run, asked.tobytes())
    return _remembered(graph, f"{what} {asked}", run)


def _remembered(graph: Graph, what: str, run: Callable[[], Labelled], *more: Hashable) -> Labelled:
    """Return a measure of the units, from memory if it is there."""
    # a measure is found by its model and what was asked for
    found = graph.memory.get_or_compute(
        "measure", what, ("measure", what, graph.units_key, *more), run,
        lambda made: ", ".join(counted(n, str(dim)) for dim, n in made.sizes.items()),
    )  # fmt: skip

    # declared on a copy: the memory may hold results of a model that differs in this word alone
    crs = graph.units.crs
    return found if crs is None else found.assign_attrs(crs=crs)


def crs(graph: Graph) -> str | None:
    """Return the coordinate reference system of the scene; see `Scene.crs`."""
    if graph.inputs.crs is not None:
        return graph.inputs.crs
    found = (graph.surface(name).crs for name in graph.inputs.names)
    return next((one for one in found if one is not None), None)


def thickness(
    graph: Graph, zone: str, grid: Any, kind: str, contact: str | None
) -> xarray.DataArray:
    """Return a thickness map of a zone, block by block [m]."""
    from geosurf.measure import thickness_map

    if contact is not None:
        contact = name_of(contact, "contact interval")

    # a cell size counts by its text
    nodes = repr(grid)
    if hasattr(grid, "coords"):  # of a map, only these count; and they may be changed in place
        axes = [grid.coords[name] for name in HORIZON_DIMS if name in grid.coords]
        nodes = graph.memory.hold(axes)
    horizons = tuple(graph.inputs.horizons)
    return _remembered(
        graph, f"{kind} {zone}",
        lambda: thickness_map(
            graph.units, zone, grid, kind=kind, contact=contact, horizons=horizons
        ),
        nodes, contact,
    )  # fmt: skip


def sample(graph: Graph, where: Any, cell: Any, codes: bool, distance: bool) -> xarray.Dataset:
    """Return zone, block, contact interval and unit at some places; see `Scene.sample`."""
    from geosurf.measure import sample_units

    if where is not None:
        check_system_of_places(lambda: crs(graph), where, "places")
    boundaries = _boundaries(graph) if flag_of(distance, "distance") else None
    return sample_units(
        graph.units, where, cell=cell, codes=codes, locator=_locator(graph), boundaries=boundaries
    )


def well_intervals(graph: Graph, path: Any, md: Any) -> xarray.Dataset:
    """Return the units that a well goes through; see `Scene.well_intervals`."""
    from geosurf.measure.places import intervals_of_wells, wells_of
    from geosurf.measure.places import well_intervals as intervals

    wells = wells_of(path)
    boundaries = _boundaries(graph)
    if wells is not None:
        if md is not None:
            raise InputError("md= is for one well. Give many wells as tables with a column 'md'.")
        for name, one in wells.items():
            check_system_of_places(lambda: crs(graph), one, name)
        return intervals_of_wells(graph.units, wells, _locator(graph), boundaries)
    check_system_of_places(lambda: crs(graph), path, "path")
    return intervals(graph.units, path, md, _locator(graph), boundaries)


def _locator(graph: Graph) -> Locator:
    """Return what finds the unit at a point, from memory if it is there."""
    from geosurf.measure.locate import locator_of

    return graph.memory.get_or_compute(
        "measure", "units by place", ("locator", graph.units_key),
        lambda: locator_of(graph.units),
        lambda found: counted(len(found.bins.corners), "triangle"),
    )  # fmt: skip


def _boundaries(graph: Graph) -> Boundaries:
    """Return all triangles that bound units, from memory if they are there."""
    from geosurf.measure.locate import boundaries_of

    return graph.memory.get_or_compute(
        "measure", "boundaries of units", ("boundaries", graph.units_key),
        lambda: boundaries_of(graph.patches, graph.units),
        lambda of: counted(len(of.triangles), "triangle"),
    )  # fmt: skip


def misfit(graph: Graph, tops: Any) -> xarray.Dataset:
    """Return well tops compared with the horizons of the model; see `Scene.misfit`."""
    from geosurf.measure import well_misfit

    if tops is not None:
        with graph.memory.collecting():
            tops = opened_tops(tops, graph.inputs.options)
    checked = graph.tops if tops is None else tops
    if checked is None:
        raise InputError(
            "the scene has no well tops. Give them: scene.misfit(geosurf.read_tops(path)), or "
            "Scene(..., tops=...)."
        )
    refuse_other_systems(graph.read.crs, graph.inputs.crs, checked, None)
    graph.memory.warn(*warnings_of_names(checked, tuple(graph.inputs.horizons)))
    run = lambda: well_misfit(graph.patches, graph.units, checked)  # noqa: E731
    content = (checked.wells, checked.horizons, checked.points.tobytes())
    return _remembered(graph, "misfit", run, *content)


def cutoffs(graph: Graph, horizon: str, fault: str, side: str | None) -> Lines:
    """Return the lines where a horizon meets a fault, or those on one wall of it."""
    for role, known, name in (
        ("horizon", graph.inputs.horizons, horizon),
        ("fault", graph.inputs.faults, fault),
    ):
        if not is_word(name, known):
            raise InputError(
                f"no {role} is called {name!r}; there are {list(known)}.{did_you_mean(name, known)}"
            )
    if side is None:  # of the two surfaces alone: no model is built
        found = graph.curves_between(horizon, fault)
        return [] if found is None else [found.points[curve] for curve in found.curves]
    from geosurf.measure import side_of_words, wall_lines

    return wall_lines(graph.patches, graph.units, horizon, fault, side_of_words(side))


def throw(graph: Graph, horizon: str, fault: str, direction: str) -> xarray.Dataset:
    """Return throw, heave and dip separation of a horizon along a fault."""
    from geosurf.measure import faces_of, separation
    from geosurf.sheets.faults import DIRECTIONS

    if not is_word(direction, DIRECTIONS):
        raise InputError(f"direction is {direction!r}, expected one of {DIRECTIONS}.")
    horizon, fault = name_of(horizon, "horizon"), name_of(fault, "fault")

    def run() -> xarray.Dataset:
        """Compare the cut-offs of both walls across the mean strike, then down the local dip."""
        # distance along strike counts from the end of the fault, in world coordinates
        faces = faces_of(graph.patches, graph.units, fault, "fault")
        hanging, foot = (cutoffs(graph, horizon, fault, side) for side in ("+", "-"))
        azimuth = math.degrees(math.atan2(*faces.strike[1].tolist())) % 360.0
        start = -float(faces.along(-faces.origin[None])[0])

        # first across the mean strike; its elevations say at which level walls are compared
        found = separation(hanging, foot, azimuth, start=start)
        if direction == "local" and found.sizes["point"]:
            level = _down_dip(graph, horizon, fault, found, hanging, foot)
            if level is not None:
                found = separation(hanging, foot, azimuth, start=start, level=level)
        return found.assign_attrs(horizon=horizon, fault=fault, direction=direction)

    return _remembered(graph, f"throw {horizon} x {fault}", run, horizon, fault, direction)


def _down_dip(
    graph: Graph, horizon: str, fault: str, found: xarray.Dataset, hanging: Lines, foot: Lines
) -> Callable[[np.ndarray], np.ndarray] | None:
    """How lines down the dip of a fault lead to the mean level of cut-offs; None: straight."""
    from geosurf.sheets.faults.fault_profile import cell_of, to_level

    sources = {source.name: source for source in graph.patches.sources}

    # cut-offs are compared at their mean elevation, down lines of steepest dip
    cell = cell_of(graph.sheets.get(horizon, sources[horizon]))
    walls = found.hanging_wall_elevation, found.footwall_elevation
    level = 0.5 * sum(float(wall.mean()) for wall in walls)
    largest = float(abs(found.throw).max())
    try:
        return to_level(sources[fault], largest, cell, level, hanging, foot)
    except GeometryError as error:
        error.add_note("With direction='mean' throw is read across the mean strike.")
        raise
