"""From time to depth, and back: what goes into a scene, converted, for a scene of its own.

A model is built in the domain of the inputs, only to know which rock is above each place
(`geosurf.measure.time_to_depth`). Then the inputs themselves are converted, each in the column
above it, and make a model like any other: data on each side of a fault have the velocities of
their own side, and horizons end on the converted fault.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from geosurf.arrangement import find_contacts
from geosurf.conventions import counted
from geosurf.conventions.axes import COORDINATES, is_time_unit, points_in, vertical_axis
from geosurf.conventions.checks import are_points
from geosurf.conventions.crs import crs_of
from geosurf.conventions.text import length_text, place
from geosurf.errors import GeosurfWarning, InputError, warn_of
from geosurf.kernels.search.columns import cross_columns
from geosurf.measure.places import points_of_array
from geosurf.measure.throw import FOUND, STATUSES, UNKNOWN, well_misfit
from geosurf.measure.time_to_depth import (
    Mesh,
    Starts,
    TimeDepth,
    beside_upright,
    convert_mesh,
    crossings_of,
    divided,
    levels_of,
    mesh_of,
    shadowed,
    starts_of,
    velocities_at_wells,
)
from geosurf.measure.velocity import (
    COLUMNS,
    TOPS,
    WAYS,
    WELLS,
    Velocity,
    checkshots_of,
    from_datum,
    is_by_name,
    time_word,
    unscaled,
    velocity_of,
)
from geosurf.model import Lattice, Sheet, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.column import each_level, names_of_zones
from geosurf.model.surfaces import cutoffs_kept
from geosurf.model.tops import Tops, tops_of
from geosurf.rebuild import patches_from, trim_sheets
from geosurf.scene.graph import Graph
from geosurf.scene.inputs import SceneInputs, in_time_unit, opened_map, undeclared
from geosurf.scene.surfaces import opened_horizon, opened_tops
from geosurf.triangulate.horizon import horizon_over

SLACK = 1e-9  # of the way to the middle: places on the rim are inside, as rounding moved them
MET = 0.05  # m: checkshots that are met as well as they are measured

Columns = tuple[Mesh, Starts, list[np.ndarray]]


def converted(graph: Graph, inputs: SceneInputs, time: str, in_time: bool) -> TimeDepth:
    """
    Return a model in time and in depth.

    Parameters
    ----------
    graph : Graph
        Of the model, in the domain of its inputs, torn where horizons are to be torn.
    inputs : SceneInputs
        With velocities.
    time : {"two-way", "one-way"}
    in_time : bool
        Whether the model is in time.
    """
    memory = graph.memory
    velocity = _velocity(graph, inputs, time)
    key, columns = _columns(graph, velocity)
    second = WAYS[time]
    said = memory.hold(inputs.velocity), _tops_key(graph, inputs)
    pair: TimeDepth = memory.get_or_compute(
        "convert", "time to depth" if in_time else "depth to time",
        ("convert", key, *said, in_time, second),
        lambda: convert_mesh(*columns, velocity, in_time, second),
        lambda made: f"{made.depth.min():.6g} to {made.depth.max():.6g} m",
    )  # fmt: skip
    return pair


def _velocity(graph: Graph, inputs: SceneInputs, time: str) -> Velocity:
    """The velocities of a scene, checked, with maps as grids."""
    horizons = tuple(graph.inputs.horizons)
    zones = tuple(names_of_zones(horizons))

    def run() -> Velocity:
        def open_map(value: Any, name: str) -> Lattice:
            return opened_map(value, name, inputs.crs, unit="m/s")

        def of_wells(given: Any, datum: float) -> Any:
            if inputs.time is None:
                raise InputError(
                    'velocity: "wells" needs horizons in time. Give velocities by zone instead.'
                )
            shots, _ = _shots(graph, inputs, given)
            shots = {name: from_datum(name, rows, datum) for name, rows in shots.items()}
            return velocities_at_wells(graph.patches, graph.units, zones, shots, WAYS[time])

        return velocity_of(inputs.velocity, horizons, zones, open_map, of_wells)

    said = graph.memory.hold(inputs.velocity), _tops_key(graph, inputs)
    key = ("velocity", *said, zones, time, graph.units_key)
    return graph.memory.stored_for(inputs.velocity, key, run)


def _of_wells(inputs: SceneInputs) -> Any:
    """What stands for checkshots among the velocities of a scene; None without."""
    entries = inputs.velocity if is_by_name(inputs.velocity) else {}
    return unscaled(entries.get(WELLS))[0]


def _is_tops(given: Any) -> bool:
    return isinstance(given, str) and given == TOPS


def _tops_in_depth(graph: Graph, inputs: SceneInputs) -> Tops:
    """The well tops that give velocities, read once."""
    if inputs.tops is None or is_time_unit(getattr(_column(inputs.tops), "attrs", {}).get("units")):
        lacks = "well tops" if inputs.tops is None else "well tops in depth; these are in time"
        raise InputError(
            f'velocity: "wells" = "tops" needs {lacks}. Give them: tops=geosurf.read_tops(path).'
        )

    def run() -> Tops:
        tops = opened_tops(inputs.tops, inputs.options)
        assert tops is not None
        return tops

    key = ("tops for velocity", graph.memory.hold(inputs.tops), *inputs.options.values())
    return graph.memory.stored_for(inputs.tops, key, run)


def _tops_key(graph: Graph, inputs: SceneInputs) -> Hashable:
    """What well tops add to the key of velocities."""
    if not _is_tops(_of_wells(inputs)):
        return None
    tops = _tops_in_depth(graph, inputs)
    return tops.wells, tops.horizons, tops.points.tobytes()


def _shots(
    graph: Graph, inputs: SceneInputs, given: Any
) -> tuple[dict[str, np.ndarray], list[GeosurfWarning]]:
    """Checkshots by well, as given or from tops on the model in time; tops that give none."""
    if not _is_tops(given):
        return checkshots_of(given), []
    tops = _tops_in_depth(graph, inputs)
    found = well_misfit(graph.patches, graph.units, tops)
    status, times = found.status.values, -found.model.values
    used = np.flatnonzero(status == FOUND)
    left = np.flatnonzero((status != FOUND) & (status != UNKNOWN))  # those are warned of already
    warnings = []
    if len(left):
        why = dict.fromkeys(f"{tops.words(k)} ({STATUSES[status[k]]})" for k in left.tolist())
        words = f"{counted(len(left), 'well top')} without a velocity: {', '.join(why)}."
        how = "Leave them out, or correct their wells, horizons or depths."
        warnings = [GeosurfWarning("tops", TOPS, words, how)]
    if not len(used):
        raise InputError(
            'velocity: "wells" = "tops" needs well tops on horizons of the scene; none of '
            f"{len(tops)} is on one. Give their velocities by zone instead."
        )
    east, north, up = tops.points[used].T
    names = [tops.wells[k] for k in used]
    columns = (names, east, north, -up, times[used])
    return checkshots_of(dict(zip(COLUMNS, columns, strict=True))), warnings


def _columns(graph: Graph, velocity: Velocity) -> tuple[Hashable, Columns]:
    """What is above each vertex of a model, and its key: the same for all values of velocities."""
    memory, zones = graph.memory, velocity.zones
    wholes = tuple(map(graph.whole, graph.inputs.names))
    key = (
        "columns",
        *map(memory.key_of, wholes),
        graph.units_key,
        velocity.groups,
        velocity.averages,
    )

    def run() -> Columns:
        split = trim_sheets(patches_from(find_contacts(wholes, origin=graph._origin)))
        mesh = mesh_of(split, graph.patches, graph.units, zones)
        starts = starts_of(mesh, velocity.groups, velocity.averages)
        return mesh, starts, levels_of(starts)

    columns: Columns = memory.get_or_compute(
        "columns", counted(len(wholes), "surface"), key, run,
        lambda columns: f"{len(columns[0].local)} vertices",
    )  # fmt: skip
    return key, columns


def converted_inputs(
    given: Graph, built: Graph, inputs: SceneInputs, time: str, *, to_depth: bool
) -> SceneInputs:
    """
    Return the inputs of a scene with horizons and faults in the other domain.

    Parameters
    ----------
    given, built : Graph
        Of the inputs as they are, and of the model, torn where horizons are to be torn.
    inputs : SceneInputs
    time : {"two-way", "one-way"}
    to_depth : bool
        Whether the inputs are in time.

    Raises
    ------
    InputError
        For a sheet, which is torn already.
    """
    memory, pair = given.memory, converted(built, inputs, time, to_depth)
    mesh = pair.mesh

    def carried(points: np.ndarray, content: Hashable) -> np.ndarray:
        """Points in the other domain."""
        return carried_points(built, inputs, points, content, time, to_depth=to_depth)

    def on_own_side(
        carry: Callable[[np.ndarray], np.ndarray], points: np.ndarray, content: Hashable
    ) -> np.ndarray:
        """Points in the other domain; those in another side's column lie on the fault.

        There the tear ignores them, and each wall continues what has its own column.
        """
        groups = pair.velocity.groups
        rows, corners, weights = memory.stored_for(
            mesh, ("shadowed", groups, content),
            lambda: shadowed(mesh, groups, points - mesh.origin),
        )  # fmt: skip
        found = carry(points)
        found[rows, 2] = (weights * pair.up[corners]).sum(axis=1)
        return found

    horizons = {}
    for name, value in given.inputs.horizons.items():
        if isinstance(value, Sheet):
            raise InputError(
                f"horizon {name!r} is a sheet that was torn before, and cannot be converted. Give "
                "its data in place of the sheet, and tear=True."
            )
        content = ("horizon", name, given.read.content(name, value), given.inputs.options)
        data = data_of(given, name, value)
        carry = partial(carried, content=str(content))
        if name in given.inputs.torn:
            carry = partial(on_own_side, carry, content=str(content))
        horizons[name] = moved_horizon(data, name, carry, "m" if to_depth else "ms")
    faults = {}
    for name in given.inputs.faults:
        fault = given.read.fault(name)
        x, triangles, _ = divided(fault.vertices, fault.triangles, mesh.longest)
        whole = given.inputs.halves.whole_of(name)
        beside = beside_upright(x, triangles, mesh.longest)
        height = carried(beside, ("fault", memory.key_of(fault)))[:, 2]
        places = np.column_stack([x[:, :2], height])
        marks = cutoffs_kept(fault, x)  # its polygons are converted with it
        made = TriSurface(whole, "fault", places, triangles, vertex_data=marks)
        faults[whole] = in_crs_of(made, [fault])
    unit = None if to_depth else "ms"
    more: dict[str, Any] = {}
    if to_depth:

        def in_depth(points: np.ndarray) -> np.ndarray:
            return pair.convert(points, True)

        to_level = partial(_in_depth, moved=in_depth, options=inputs.options)
        more = {"contacts": each_level(inputs.contacts, to_level)}
        if is_time_unit(getattr(_column(inputs.tops), "attrs", {}).get("units")):
            tops = tops_of(in_time_unit(inputs.tops, "the well tops", "ms"))
            more["tops"] = replace(tops, points=in_depth(tops.points))
    return inputs.replaced(
        horizons=horizons, faults=faults, length_unit=unit, velocity=None, box=inputs.box,
        time=None if to_depth else time, zones=inputs.zones if to_depth else None, **more,
    )  # fmt: skip


def _column(tops: Any) -> Any:
    """The column of well tops that may be in time; None if they are not a table of xarray."""
    return tops["elevation"] if hasattr(tops, "data_vars") and "elevation" in tops else None


def _in_depth(
    value: Any, moved: Callable[[np.ndarray], np.ndarray], options: Mapping[str, Any]
) -> Any:
    """A level of a fluid contact: in depth, where it is a grid in time; numbers are in depth."""
    if not is_time_unit(getattr(value, "attrs", {}).get("units")):
        return value
    value = in_time_unit(value, "the fluid contact", "ms")
    data = horizon_over(value, (), name="contact", **undeclared(value, options))
    return moved_horizon(data, "contact", moved)


def carried_points(
    built: Graph, inputs: SceneInputs, points: np.ndarray, content: Hashable, time: str, *,
    to_depth: bool,
) -> np.ndarray:  # fmt: skip
    """Return points in the other domain; what is above them is found once for all velocities.

    `content` tells these points from others.
    """
    pair = converted(built, inputs, time, inputs.time is not None)
    key, (mesh, *_) = _columns(built, pair.velocity)
    crossings = built.memory.stored_for(
        mesh, ("crossings", key, content),
        lambda: crossings_of(mesh, pair.velocity.groups, (points - mesh.origin)[:, :2]),
    )  # fmt: skip
    return pair.convert(points, to_depth, crossings)


def data_of(given: Graph, name: str, value: Any) -> Any:
    """The data of a horizon as a scene takes them: points of one to be torn, or a surface."""
    if name not in given.inputs.torn:
        return given.untied(name)
    data = opened_horizon(value, given.inputs.options)
    words = undeclared(data, given.inputs.options)
    if are_points(data):
        from geosurf.sheets.lattice.data import points_of  # loaded by those who tear

        columns = points_of(data, name, words.get("positive"), words.get("length_unit"))[1].T
        found = xr.Dataset({k: ("point", c) for k, c in zip(COORDINATES, columns, strict=True)})
        return found.assign_attrs({} if (crs := crs_of(data)) is None else {"crs": crs})
    return data if isinstance(data, TriSurface) else horizon_over(data, (), name=name, **words)


def places_in(data: Any) -> np.ndarray:
    """Points (n, 3) of what `data_of` returns."""
    if isinstance(data, TriSurface):
        return data.vertices
    return points_in(data)


def moved_horizon(
    data: Any, name: str, moved: Callable[[np.ndarray], np.ndarray], unit: str = "m"
) -> Any:
    """What `data_of` returns with its points moved: a grid stays one."""
    if not isinstance(data, TriSurface):
        columns = moved(places_in(data)).T
        found = xr.Dataset({k: ("point", c) for k, c in zip(COORDINATES, columns, strict=True)})
        found.elevation.attrs.update(positive="up", units=unit)
        return found.assign_attrs(data.attrs)
    lattice = data.lattice
    if lattice is None:
        made = TriSurface(name, "horizon", moved(data.vertices), data.triangles)
    else:
        elevation = lattice.elevation.copy()
        elevation[lattice.present] = moved(data.vertices)[:, 2]
        grid = lattice.with_elevation(elevation)
        made = TriSurface(name, "horizon", lattice=grid, vertex_data=data.vertex_data)
    return in_crs_of(made, [data])


# what is vertical in the results of measures; all others are along the map
VERTICAL = ("thickness", "throw", "picked", "model", "misfit", "data", "spread", "off")
SLANTED = ("dip_separation", "apparent_dip")


def in_milliseconds(measure: Any) -> Any:
    """Return a measure of a model in time, vertical numbers in ms, without slanted ones."""
    if not hasattr(measure, "data_vars"):
        return measure.assign_attrs(units="ms")
    measure = measure.drop_vars([name for name in SLANTED if name in measure])
    for name, values in measure.variables.items():
        is_vertical = name in VERTICAL or str(name).endswith("elevation")
        if is_vertical and values.attrs.get("units") == "m":
            measure = measure.assign({name: measure[name].assign_attrs(units="ms")})
    return measure


# ---- what a scene asks ----------------------------------------


def plain_in_depth(given: Graph, built: Graph, inputs: SceneInputs) -> Graph:
    """Return the graph of what a scene in time becomes by its velocities, not yet torn.

    Parameters
    ----------
    given, built : Graph
        As for `converted_inputs`, in time.
    inputs : SceneInputs
    """
    made = converted_inputs(given, built, inputs, str(inputs.time), to_depth=True)
    given.memory.warn(*_warnings_of_wells(built, inputs))
    plain = Graph(made, given.memory)
    plain.known_regions, plain.converted_from = given.known_regions, built
    return plain


def _warnings_of_wells(built: Graph, inputs: SceneInputs) -> list[GeosurfWarning]:
    """How far checkshots are from the model, where they give its velocities."""
    given = _of_wells(inputs)
    if given is None:
        return []
    shots, warnings = _shots(built, inputs, given)
    rows = np.concatenate([*shots.values()])
    names = [name for name, some in shots.items() for _ in some]
    pair = converted(built, inputs, str(inputs.time), True)
    off = pair.convert(np.column_stack([rows[:, :2], -rows[:, 3]]), True)[:, 2] + rows[:, 2]
    k = int(np.abs(off).argmax())
    if abs(off[k]) < MET:
        return warnings
    worst = f"{length_text(abs(off[k]))} (well {names[k]!r}, {rows[k, 2]:.0f} m deep)"
    what = "well top" if _is_tops(given) else "checkshot"
    words = (
        f"Interval velocities of {counted(len(shots), 'well')} stand for "
        f"{counted(len(rows), what)}. The model misses these by up to {worst}; the root "
        f"mean square is {length_text(float(np.sqrt((off**2).mean())))}."
    )
    remedy = "Give zones where it is large v0 and k, a map, or more horizons."
    place = (rows[k, 0], rows[k, 1], -rows[k, 2])
    return [*warnings, GeosurfWarning("velocity", WELLS, words, remedy, place)]


def inputs_in_time(
    inputs: SceneInputs, graphs: Callable[[], tuple[Graph, Graph]], time: str | None
) -> SceneInputs:
    """Return the inputs of a scene in time; `graphs` gives the scene in depth, plain and torn."""
    if inputs.time is not None:
        if time not in (None, inputs.time):
            raise InputError(f"the scene is in {inputs.time} time. Leave time= out.")
        return inputs.to_build
    _need_velocity(inputs)
    if time_word(time) is None:
        raise InputError('state how times count: in_time("two-way"), or "one-way".')
    return converted_inputs(*graphs(), inputs, str(time), to_depth=False).in_time


def convert_points(
    inputs: SceneInputs, in_time: Callable[[], Graph], points: Any, to_depth: bool
) -> np.ndarray:
    """Return points of a scene in the other domain; `in_time` gives its model in time.

    Raises
    ------
    InputError
        If all places lie above the datum, or one has no depth or time by its velocity.
    """
    _need_velocity(inputs)
    if inputs.time is None:
        raise InputError(
            "the inputs are in depth. Ask the scene in time: "
            'scene.in_time("two-way").replace(velocity=...).'
        )
    pair, places = converted(in_time(), inputs, inputs.time, True), points_of_array(points)
    shown = inputs.time if to_depth else "elevation"
    x, feet = pair.mesh.local[:, :2], places[:, :2] - pair.mesh.origin[:2]
    inner = feet + SLACK * (0.5 * (x.min(axis=0) + x.max(axis=0)) - feet)
    outside = np.ones(len(places), dtype=bool)
    outside[cross_columns(pair.mesh.local, pair.mesh.triangles, inner).foot] = False
    outside = np.flatnonzero(outside | pair.mesh.nearest_inside(inner)[1])
    if len(outside):
        with vertical_axis(shown):
            warn_of(
                "velocity", "places",
                f"Outside of the horizons: {counted(len(outside), 'place')} of {len(places)}, "
                f"the first at {place(places[outside[0]])}. Velocities are those of the nearest "
                f"place inside, and of {pair.velocity.zones[0]!r} where the outline turns inward.",
                "Leave them out, or continue the horizons: "
                "gs.extend_horizon(horizon, distance=...).",
                tuple(places[outside[0]].tolist()),
            )  # fmt: skip
    above = places[:, 2] > (0.0 if to_depth else pair.velocity.datum)
    _refuse(
        places, above & above.all(), shown,
        "lies above the datum, as all others do. Times and depths are positive up: change the "
        "sign of what grows downwards.",
    )  # fmt: skip
    in_other_domain = pair.convert(places, to_depth)
    _refuse(
        places, ~np.isfinite(in_other_domain[:, 2]), shown,
        f"has no {'depth' if to_depth else 'time'} by the velocity v0 + k z of its zone. Leave "
        "such places out.",
    )  # fmt: skip
    return in_other_domain


def _refuse(places: np.ndarray, wrong: np.ndarray, shown: str | None, why: str) -> None:
    """Refuse places that cannot be converted; name the first."""
    if wrong.any():
        k = int(np.argmax(wrong))
        with vertical_axis(shown):
            raise InputError(f"place {k} at {place(places[k])} {why}")


def _need_velocity(inputs: SceneInputs) -> None:
    if inputs.velocity is None:
        raise InputError(
            "the scene has no velocities. Give them: scene.replace(velocity={...}), in m/s by zone."
        )
