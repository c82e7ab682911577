"""Zones from thickness: horizons that are made of another one, and how thick the zone between is.

The data of a horizon are moved, not its surface: what is made is torn, tied and cut like any other
horizon, at the same faults, and so has the throw of its reference.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from geosurf.conventions import is_number, length_text, place
from geosurf.conventions.axes import meaning
from geosurf.conventions.checks import are_points
from geosurf.errors import GeosurfWarning, InputError
from geosurf.lazy import xarray
from geosurf.measure.velocity import Field
from geosurf.model import Lattice, Sheet, TriSurface
from geosurf.model.column import YIELDING, MadeHorizon, data_of_made
from geosurf.scene.depth import data_of, moved_horizon, places_in, plain_in_depth
from geosurf.scene.graph import Graph
from geosurf.scene.inputs import SceneInputs, opened_map


def made_horizons(plain: Graph, made: Sequence[MadeHorizon]) -> tuple[dict[str, Any], list[Any]]:
    """
    Return the horizons that zones make, and rows of how their thickness was corrected.

    Parameters
    ----------
    plain : Graph
        Of the inputs.
    made : sequence of MadeHorizon
        Of one scene.

    Returns
    -------
    (dict of str to object, list of list)
        Zone, start, horizon, mean thickness as given and in the model, smallest and largest factor.
    """
    after = {(zone.start, zone.down): zone for zone in made}
    horizons: dict[str, Any] = {}
    rows: list[Any] = []
    for first in made:
        if _is_made(plain, first.start):
            continue
        chain = [first]
        while _is_made(plain, chain[-1].horizon):
            onward = after.get((chain[-1].horizon, first.down))
            if onward is None:
                break
            chain.append(onward)
        if not any(_is_made(plain, zone.horizon) for zone in chain):
            continue  # all have data of their own
        memory, inputs = plain.memory, plain.inputs
        named = [
            first.start,
            *(zone.horizon for zone in chain if not _is_made(plain, zone.horizon)),
        ]
        key = (
            "zones", *(plain.read.content(name, inputs.horizons[name]) for name in named),
            *((zone.zone, zone.kind, zone.horizon, memory.hold(zone.thickness)) for zone in chain),
            *inputs.options.values(), inputs.torn,
        )  # fmt: skip
        made_here, corrections = memory.get_or_compute(
            "zones", ", ".join(zone.zone for zone in chain), key,
            partial(_chain, plain, chain), lambda made: f"{len(made[0])} horizons",
        )  # fmt: skip
        horizons |= made_here
        rows += corrections
    return horizons, rows


def _is_made(plain: Graph, horizon: str) -> bool:
    return isinstance(plain.inputs.horizons.get(horizon), MadeHorizon)


def _chain(plain: Graph, chain: Sequence[MadeHorizon]) -> tuple[dict[str, Any], list[Any]]:
    """Horizons and rows of zones in a row, which fit if the last one ends on a given horizon."""
    start, sign = chain[0].start, -1.0 if chain[0].down else 1.0
    data = data_of(plain, start, plain.inputs.horizons[start])
    x = places_in(data)
    thick, z = [], x[:, 2]
    for zone in chain:
        added = _thickness(plain, zone).at(x[:, :2])
        if (added < 0.0).any():
            plain.memory.warn(_negative(zone, x, added))
        if zone.kind == "isopach":
            added = added * _secant(zone, data, z)
        thick.append(np.maximum(added, 0.0))
        z = z + sign * thick[-1]
    given = np.array(thick)

    # fitted: the same share of what there is at each place
    factor = np.ones(len(x))
    total = given.sum(axis=0)
    end = chain[-1].horizon
    fits = not _is_made(plain, end)
    if fits:
        other = data_of(plain, end, plain.inputs.horizons[end])
        if are_points(other) or other.lattice is None:
            raise InputError(
                f"zone {chain[-1].zone!r} is to fit to horizon {end!r}, which is not a grid. Give "
                "a grid of it."
            )
        room = np.maximum(sign * (Field(other.lattice).at(x[:, :2]) - x[:, 2]), 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            factor = np.where(total > 0.0, room / total, 1.0)
        given = np.where(total > 0.0, given, room / len(chain))
    fitted = given * factor
    below = np.cumsum(fitted, axis=0)
    horizons, rows = {}, []
    for k, zone in enumerate(chain):
        numbers = thick[k].mean(), fitted[k].mean(), factor.min(), factor.max()
        rows.append([zone.zone, zone.start, zone.horizon, *map(float, numbers)])
        if not (fits and k == len(chain) - 1):
            to = np.column_stack([x[:, :2], x[:, 2] + sign * below[k]])
            moved = moved_horizon(data, start, partial(_to, to))
            horizons[zone.horizon] = (
                moved.renamed(zone.horizon) if isinstance(moved, TriSurface) else moved
            )
    return horizons, rows


def _to(places: np.ndarray, _: np.ndarray) -> np.ndarray:
    return places


def _thickness(plain: Graph, one: MadeHorizon) -> Field:
    """The thickness of a zone over the map."""
    value, what = one.thickness, f"the thickness of zone {one.zone!r}"
    if is_number(value):
        if float(value) < 0.0:
            raise InputError(f"{what} is {value!r}. Give metres, 0 or more.")
        return Field(float(value))
    if hasattr(value, "dims") or isinstance(value, str) or hasattr(value, "__fspath__"):
        return Field(opened_map(value, what, plain.inputs.crs, unit="m"))
    known = value if hasattr(value, "__contains__") else ()
    keys = ("easting", "northing", "thickness")
    if any(key not in known for key in keys):
        raise InputError(
            f"{what} is {value!r}. Give metres, a map, or a table of wells with the columns "
            "easting, northing and thickness."
        )
    x, y, t = (np.ravel(np.asarray(value[key], dtype=np.float64)) for key in keys)
    if not len(t) or not len(x) == len(y) == len(t) or not np.isfinite([x, y, t]).all():
        raise InputError(f"{what}: give each well an easting, a northing and a thickness [m].")
    return Field((np.column_stack([x, y]), t))


def _negative(zone: MadeHorizon, x: np.ndarray, added: np.ndarray) -> GeosurfWarning:
    at = x[added.argmin()]
    return GeosurfWarning(
        "thickness", zone.zone,
        f"The thickness of zone {zone.zone!r} is below 0 at {int((added < 0.0).sum())} of "
        f"{len(added)} nodes, down to {length_text(added.min())} at {place(at)}: 0 counts there.",
        "Correct the map of its thickness.", tuple(at.tolist()),
    )  # fmt: skip


def _secant(zone: MadeHorizon, data: Any, z: np.ndarray) -> np.ndarray:
    """Vertical thickness over the one normal to a grid with elevations z at its nodes."""
    from scipy.ndimage import distance_transform_edt  # loaded by those who give an isopach

    lattice: Lattice | None = None if are_points(data) else data.lattice
    if lattice is None or min(lattice.shape) < 2:
        raise InputError(
            f"zone {zone.zone!r} is an isopach, normal to {zone.start!r}, which is not a grid. "
            'Give a grid of it, or kind="isochore".'
        )
    shape, (x, y) = lattice.shape, (lattice.easting, lattice.northing)
    if x.ndim == 1:
        x, y = np.meshgrid(x, y)
    values = np.full(shape, np.nan)
    values[lattice.present] = z
    rows, columns = ([np.gradient(part, axis=axis) for part in (x, y, values)] for axis in (0, 1))
    area = columns[0] * rows[1] - columns[1] * rows[0]
    east = (columns[2] * rows[1] - columns[1] * rows[2]) / area
    north = (columns[0] * rows[2] - columns[2] * rows[0]) / area
    slope = east**2 + north**2
    # next to nodes without data: the slope of the nearest node that has one
    gaps = np.isnan(slope)
    if not gaps.all():
        at = distance_transform_edt(gaps, return_distances=False, return_indices=True)
        slope = slope[tuple(at)]
    return np.asarray(np.sqrt(1.0 + np.nan_to_num(slope[lattice.present])))


BESIDE = 3.0  # cells along a fault in which its reference may have the throw of a horizon
OF_THROW = 0.1  # of the largest throw, by which they may differ; and by the spread of its data
IN_A_ROW = 5  # stations


def warnings_of_throw(
    sheets: Mapping[str, Sheet], made_of: Mapping[str, Sequence[str]]
) -> list[GeosurfWarning]:
    """Return a warning for each fault at which a made horizon has not the throw of its reference.

    Parameters
    ----------
    sheets : mapping of str to Sheet
    made_of : mapping of str to sequence of str
        As from `data_of_made`.
    """
    from scipy.ndimage import binary_opening  # loaded by those who tear

    warnings = []
    for name, (start, *_) in made_of.items():
        if name not in sheets or start not in sheets:
            continue
        known = getattr(sheets[start].report, "throw", {})
        for fault, cut in sheets[name].cuts.items():
            audit = known.get(fault)
            if audit is None or not np.isfinite(audit.sheet).any() or len(audit.stations) < 2:
                continue
            # traces move down the dip, so that ends and junctions are elsewhere along strike
            at = audit.stations[np.isfinite(audit.sheet), :2]
            throw, spread = (of[np.isfinite(audit.sheet)] for of in (audit.sheet, audit.spread))
            strike = np.diff(audit.stations[[0, -1], :2], axis=0)[0]
            cell = np.median(np.hypot(*np.diff(audit.stations[:, :2], axis=0).T))
            away = np.abs((cut.stations[:, None, :2] - at) @ (strike / np.hypot(*strike)))
            far = away > BESIDE * cell
            low, high = np.where(far, np.inf, throw), np.where(far, -np.inf, throw)
            off = np.maximum(low.min(axis=1) - cut.throw, cut.throw - high.max(axis=1))
            spread = np.where(far, 0.0, np.nan_to_num(spread)).max(axis=1)
            least = np.maximum(spread, OF_THROW * np.abs(throw).max())
            rows = np.flatnonzero(
                binary_opening(np.isfinite(off) & (off > least), np.ones(IN_A_ROW))
            )
            if not len(rows):
                continue
            worst = rows[off[rows].argmax()]
            warnings.append(
                GeosurfWarning(
                    "throw of zone", name,
                    f"Horizon {name!r} has a throw of {length_text(cut.throw[worst])} at fault "
                    f"{fault!r} near {place(cut.stations[worst])}. {start!r}, which it is made of, "
                    f"has {length_text(throw[away[worst].argmin()])} there. They differ at "
                    f"{len(rows)} of {len(cut.stations)} stations.",
                    f"Compare them in scene.plot.throw({fault!r}), tear with a wider trim, or give "
                    f"data of {name!r}.",
                    tuple(cut.stations[worst].tolist()),
                )
            )  # fmt: skip
    return warnings


def corrections(rows: Sequence[Sequence[Any]]) -> xarray.Dataset:
    """Return the rows of zones as a dataset: see `Scene.zone_corrections`."""
    words = {
        "start": ("", "horizon that the thickness counts from"),
        "horizon": ("", "horizon at the other end"),
        "given": ("m", "mean thickness as given"),
        "model": ("m", "mean thickness between the data"),
        "least_factor": ("1", "smallest factor that fits it between given horizons"),
        "largest_factor": ("1", "largest factor"),
    }
    data = {
        name: ("zone", np.array([row[k + 1] for row in rows], dtype=float if unit else object),
               meaning(told, unit))
        for k, (name, (unit, told)) in enumerate(words.items())
    }  # fmt: skip
    return xarray.Dataset(data, {"zone": np.array([row[0] for row in rows], dtype=object)})


def correction_in_words(row: xarray.Dataset) -> str:
    """Return a row of `corrections` as a line of a log."""
    low, high = float(row.least_factor), float(row.largest_factor)
    fit = "" if low == high == 1.0 else f", fitted by a factor of {low:.3g} to {high:.3g}"
    return f"{row.horizon.item()}: {float(row.model):.4g} m on average{fit}"


def plain_graph(plain: Graph, in_time: Callable[[], Graph], inputs: SceneInputs) -> Graph:
    """Return the graph of a scene whose horizons all have data, in the domain of the model.

    Parameters
    ----------
    plain : Graph
        Of the inputs as they were given.
    in_time : callable
        Gives the model in time, of a scene that becomes depth.
    inputs : SceneInputs
    """
    if inputs.becomes_depth:
        plain = plain_in_depth(plain, in_time(), inputs)
        inputs = plain.inputs
    if not inputs.made:
        return plain
    made = [one for one in inputs.made if one.horizon in inputs.horizons]
    horizons, rows = made_horizons(plain, made)
    with_data = [name for name in inputs.horizons if not _is_made(plain, name)]
    made_of, order = data_of_made(made, with_data), list(inputs.horizons)
    # data that lie below count more: what is made of them, or fits them, ends there
    column = {name: YIELDING for name, of in made_of.items()
              if max(map(order.index, of)) > order.index(name)}  # fmt: skip
    inputs = inputs.replaced(horizons=horizons, zones=None, column=column | dict(inputs.column))
    graph = Graph(inputs, plain.memory)
    graph.known_regions, graph.converted_from = plain.known_regions, plain.converted_from
    graph.zone_rows = rows
    graph.made_of = made_of
    return graph
