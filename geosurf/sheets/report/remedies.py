"""What it took to close a sheet, as warnings: fault, place, size and effect of each remedy."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeosurfError, GeosurfWarning
from geosurf.faults.rim import find_rim
from geosurf.model import TriSurface
from geosurf.model.network import SIDES
from geosurf.model.sheets import Extended
from geosurf.model.surfaces import cutoffs_among
from geosurf.sheets.faults.network import OVERSHOOT
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.picks import Frame
from geosurf.sheets.mesh.build import LEVEL_REACH, Built
from geosurf.sheets.mesh.close import Closed
from geosurf.sheets.mesh.tear_ends import LATERAL, NO_THROW, USUAL, distance_to, throw_of

# ---- lengthening ----------------------------------------
# What to type so that a fault is continued: for scripts and for scenarios.


def how_to_lengthen(name: str, lengths: Mapping[str, float]) -> str:
    """
    Return the words that continue a fault.

    Parameters
    ----------
    name : str
    lengths : mapping of {"up", "down", "start", "end"} to float
        How far at least [m]; empty where that is not known.

    Examples
    --------
    >>> how_to_lengthen("F3", {"end": 133.6})
    "lengthen={'F3': {'end': 134}}; in a scenario, lengthen_m = {end = 134} of 'F3'"
    >>> how_to_lengthen("F3", {})
    "lengthen={'F3': distance}, with a distance [m]"
    """
    if not lengths:
        return f"lengthen={{{name!r}: distance}}, with a distance [m]"
    whole = {side: math.ceil(length) for side, length in lengths.items()}
    typed = ", ".join(f"{side} = {length}" for side, length in whole.items())
    return f"lengthen={{{name!r}: {whole}}}; in a scenario, lengthen_m = {{{typed}}} of {name!r}"


def end_at(fault: TriSurface, place: np.ndarray) -> str | None:
    """Return which end of a fault is nearest to a place (3,) [m]; None if its rim has no ends."""
    try:
        arcs = find_rim(fault).arcs
    except GeosurfError:  # several pieces, or a closed rim
        return None
    far = {side: distance_to(place, fault.vertices[arcs[side]]) for side in LATERAL}
    side = min(far, key=lambda one: far[one])
    return side if math.isfinite(far[side]) else None


def longer_by(before: TriSurface, after: TriSurface) -> dict[str, float]:
    """Return how far a fault was continued at each side [m]; empty if its rim has no sides."""
    try:
        old, new = find_rim(before).arcs, find_rim(after).arcs
    except GeosurfError:
        return {}
    lengths = {}
    for side in SIDES:
        # the median: corners of the rim also move with the side next to them; but a side that has
        # old points was not continued, though the sides next to it may have made it longer
        rim = before.vertices[old[side]]
        away = [distance_to(place, rim) for place in after.vertices[new[side]]]
        far = float(np.median(away)) if min(away, default=0.0) > 0.0 else 0.0
        if far < math.inf and far > 0.0:
            lengths[side] = far
    return lengths


WAYS = {
    "up": "up its dip",
    "down": "down its dip",
    "start": "along strike at its start",
    "end": "along strike at its end",
}


def remedies(closed: Closed) -> list[GeosurfWarning]:
    """A warning for each remedy that was needed."""
    built, picks = closed.built, closed.picks
    names = [fault.name for fault in closed.faults]
    warnings = [_extension(picks.name, extension) for extension in closed.extensions]
    warnings += _trims_changed(closed, names)
    warnings += _polygons_left_out(closed)
    longer = {one.fault for one in closed.extensions if set(one.lengths) & set(LATERAL)}
    warnings += _ended_at_others(picks.name, picks.frame, built.state, names, longer)
    warnings += _early_ends(closed, names)
    warnings += _parts_left_out(picks.name, picks.frame, built, names)
    warnings += _level_places(picks.name, picks.frame, built, names)
    return warnings


def _extension(horizon: str, longer: Extended) -> GeosurfWarning:
    """A fault that was extended up or down."""
    ways = " and ".join(
        f"{WAYS[side]} by {longer.lengths[side]:.0f} m" for side in WAYS if side in longer.lengths
    )
    return GeosurfWarning(
        "fault extended",
        longer.fault,
        f"Horizon {horizon!r} leaves fault {longer.fault!r} at its rim, near "
        f"{place(longer.place)}. The fault was extended {ways}.",
        f"Lengthen it yourself: {how_to_lengthen(longer.fault, longer.lengths)}. Or use the fault "
        "of the sheet, sheet.faults.",
        tuple(longer.place),
    )


def _trims_changed(closed: Closed, names: Sequence[str]) -> Iterator[GeosurfWarning]:
    """Trims that were changed, because the sheet stays open with those that were given."""
    pairs = zip(names, closed.given_trims.of_fault, closed.trims.of_fault, strict=False)
    for name, given, used in pairs:
        if used != given:
            yield GeosurfWarning(
                "trim changed",
                name,
                f"Horizon {closed.picks.name!r} does not close at fault {name!r} with a trim of "
                f"{given:g} cells, or has no data beyond it. {used:g} cells were used.",
                f"Set it yourself: trim={{{name!r}: {used:g}}}; in a scenario, "
                f"trim_cells = {{{name} = {used:g}}} in [tear].",
                None,
            )


def _polygons_left_out(closed: Closed) -> Iterator[GeosurfWarning]:
    """Fault polygons that the sheet does not meet, because it stays open with them."""
    picks, state = closed.picks, closed.built.state
    used = closed.rebuilt.solver.inputs.cutoffs
    for name, (first, second) in cutoffs_among(closed.faults, picks.name).items():
        if name in used:
            continue
        throws = [
            np.abs(walls.throw)
            for trace, walls in zip(state.network.traces, state.walls, strict=True)
            if closed.faults[trace.fault].name == name
        ]
        has = np.median(np.concatenate(throws)) if sum(map(len, throws)) else 0.0
        yield GeosurfWarning(
            "polygon left out",
            name,
            f"Horizon {picks.name!r} stays open with its fault polygons, and that of {name!r} is "
            f"left out. It shows about {abs(first[:, 2].mean() - second[:, 2].mean()):.3g} m of "
            f"throw; the data without it give {has:.3g} m.",
            "If its gap is the smear of gridding, state the dip: fault_from_polygons(..., dip=), "
            "which gs.propose_dip finds; in a scenario, dip in [[faults]]. Else compare polygon "
            "and horizon: they may be of different versions.",
            tuple(first.mean(axis=0).tolist()),
        )


def _ended_at_others(
    horizon: str, frame: Frame, state: Heights, names: Sequence[str], longer: Collection[str]
) -> Iterator[GeosurfWarning]:
    """Parts of faults past others where the data show no throw: they tear nothing.

    Faults in `longer` were continued to the other one, as another remedy says.
    """
    network = state.network
    for trace, limits in zip(network.traces, network.mesh, strict=True):
        torn = trace.length_at(limits)
        for end, (whole, last) in enumerate(zip(trace.inside, torn, strict=True)):
            past = (last - whole) * (-1) ** end
            if not trace.ends[end].startswith("branch of ") or past <= OVERSHOOT:
                continue
            name, main = names[trace.fault], trace.ends[end].removeprefix("branch of ")
            if name in longer or (end and limits[0] == np.inf):  # all of it is past: once
                continue
            at = tuple(frame.from_cells(trace.at_length([whole])[:, :3])[0].tolist())
            yield GeosurfWarning(
                "fault ends at another",
                name,
                f"Fault {name!r} goes on past {main!r} by {past * frame.cell:.0f} m on horizon "
                f"{horizon!r}, to {place(at)}. That part is taken to have no throw: the horizon is "
                f"torn up to {main!r}.",
                f"End {name!r} at {main!r}: truncations={{{name!r}: ({main!r}, side)}}, with the "
                "side to keep (scene.propose_fault_network() lists it); in a scenario, "
                "[[truncations]].",
                at,
            )


def _early_ends(closed: Closed, names: Sequence[str]) -> Iterator[GeosurfWarning]:
    """Tears that end before their faults do: throw is wrong there."""
    horizon, frame, built = closed.picks.name, closed.picks.frame, closed.built
    network = built.state.network
    for (number, end), n in sorted(built.repairs.shortened.items()):
        trace = network.traces[number]
        places = built.cuts.place[built.cuts.trace == number]
        is_tip = trace.ends[end] == "tip"
        if n < (USUAL + 1 if is_tip else 1) or not len(places):
            continue

        # where the tear ends, and where its fault does: both as lengths along the trace
        last = float(places.max() if end else places.min())
        along, whole = trace.length_at([last, network.mesh[number][end]])
        at = tuple(frame.from_cells(trace.at([last])[:, :3])[0].tolist())
        name = names[trace.fault]
        which = "" if is_tip else f", {trace.ends[end]},"
        lost = abs(whole - along) * frame.cell
        side = end_at(closed.faults[trace.fault], np.array(at))
        how = "pick more sticks" if side is None else how_to_lengthen(name, {side: lost})
        remedy = (
            f"Continue fault {name!r}, so that it ends farther from the throw: {how}."
            if is_tip
            else _remedy_at_branch(name, trace.ends[end], closed)
        )
        yield GeosurfWarning(
            "tear ended early",
            name,
            f"The tear of horizon {horizon!r} at fault {name!r}{which} ends at {place(at)}, "
            f"{lost:.0f} m before the fault does, and throw dies there: "
            "farther on the sheet does not close.",
            remedy,
            at,
        )


def _remedy_at_branch(name: str, end: str, closed: Closed) -> str:
    """What may close a sheet where a fault ends on another one, by the words of `Trace.ends`."""
    by_name = {fault.name: fault for fault in closed.faults}
    main = by_name.get(end.removeprefix("branch of "))
    # a rule has ended the branch: both faults have the same points where they meet
    if main is not None and _share_points(by_name[name], main):
        return (
            f"Fault {name!r} ends on {main.name!r} already. Try another trim there: "
            f"trim={{{name!r}: 3}}; in a scenario, trim_cells = {{{name} = 3}} in [tear]."
        )
    return (
        "End the branch on its main fault, and tear with "
        "gs.truncate_faults(gs.rebuild_surfaces(faults), truncations).surfaces; in a "
        "scenario, [[truncations]]."
    )


def _share_points(surface: TriSurface, other: TriSurface) -> bool:
    """Whether two surfaces have an edge in common, as far as their points tell."""
    known = set(map(tuple, other.vertices.tolist()))
    return sum(tuple(point) in known for point in surface.vertices.tolist()) >= 2


def _parts_left_out(
    horizon: str, frame: Frame, built: Built, names: Sequence[str]
) -> Iterator[GeosurfWarning]:
    """Parts of faults at which the horizon is not torn."""
    state = built.state
    for number, first, last in built.repairs.untorn:
        trace = state.network.traces[number]

        # ends of the part in world coordinates, and the largest throw along it
        ends = np.clip([first, last], 0.0, trace.along[-1])
        world = frame.from_cells(trace.at_length(ends)[:, :3])
        lost = throw_of(state, (number, first, last))
        name = names[trace.fault]
        length = (ends[1] - ends[0]) * frame.cell
        if lost <= NO_THROW * frame.cell:
            yield GeosurfWarning(
                "tear left out",
                name,
                f"Horizon {horizon!r} is not torn at fault {name!r} from {place(world[0])} to "
                f"{place(world[1])}, {length:.0f} m: the data show no throw there. The heights on "
                f"both sides agree within {lost:.2g} m.",
                f"Check that {name!r} reaches the horizon there; if not, end it before.",
                tuple(world.mean(axis=0)),
            )
            continue
        yield GeosurfWarning(
            "tear left out",
            name,
            f"Horizon {horizon!r} is not torn at fault {name!r} from {place(world[0])} to "
            f"{place(world[1])}, {length:.0f} m: no tear closes there. "
            f"It bends instead; up to {lost:.3g} m of throw are lost.",
            f"End fault {name!r} before it, or on the fault that it meets, with "
            "truncations={...} (scene.propose_fault_network() lists them); in a scenario, "
            "[[truncations]].",
            tuple(world.mean(axis=0)),
        )


def _level_places(
    horizon: str, frame: Frame, built: Built, names: Sequence[str]
) -> Iterator[GeosurfWarning]:
    """Places at which a wall goes on level to its fault."""
    seen: list[np.ndarray] = []
    for cells in map(np.array, built.repairs.level):
        # several attempts may list the same place: one warning for all within twice the reach
        if any(np.hypot(*(cells - other)) <= 2.0 * LEVEL_REACH for other in seen):
            continue
        seen.append(cells)
        fault = _nearest_fault(built.state, cells)
        xy = frame.from_cells(cells[None])[0]
        node = np.rint(cells / frame.stretch).astype(np.int64)[::-1]
        node = np.clip(node, 0, np.array(frame.shape) - 1)
        at = (*xy, float(np.nan_to_num(built.state.values.reshape(frame.shape)[tuple(node)])))
        yield GeosurfWarning(
            "wall made level",
            names[fault],
            f"A wall of horizon {horizon!r} runs along fault {names[fault]!r} near {place(at)} and "
            f"does not meet it. Within {LEVEL_REACH * frame.cell:.0f} m it was continued level to "
            "the fault: the cut-off there is a guess.",
            f"Check the dip of {names[fault]!r} and the data next to it, or give another trim "
            "(in a scenario, trim_cells in [tear]).",
            at,
        )


def _nearest_fault(state: Heights, cells: np.ndarray) -> int:
    """The fault with the trace nearest to a place [cells]."""
    far = [trace.far_from(cells).min() for trace in state.network.traces]
    return state.network.traces[int(np.argmin(far))].fault
