"""Where the tears of a moved horizon end, and errors where throw would be left without a fault."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.sheets.torn_links import uncut_steps
from geosurf.sheets.faults.cut_edges import Cuts
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.traces import Trace
from geosurf.sheets.throw.movement import Branches, Movement

NIL = 1e-4  # cells: less throw than this tears nothing
DIES = 0.01  # of the largest throw: what may be left at a tip
STEP = 0.05  # and between two neighbours that no fault parts, as at a tip, within a cell


def throw_along(movement: Movement, trace: Trace, at: int | slice) -> tuple[np.ndarray, np.ndarray]:
    """World coordinates (n, 3) of vertices of a trace, and the throw (n,) requested there [m]."""
    slip, frame = movement.slips[trace.fault], movement.frame
    line = np.atleast_2d(trace.line[at])
    xy = (line[:, :2] / frame.stretch) @ frame.step
    s = slip.section.of(xy)[0].clip(0.0, slip.section.length)
    throw = slip.amount(s, line[:, 2], xy)
    return np.column_stack([xy + frame.corner, line[:, 2]]), throw


def refuse_throw_at_tips(movement: Movement, network: Network) -> None:
    """Raise an error where throw is left at the end of a fault inside the horizon."""
    for trace in network.traces:
        slip, largest = movement.slips[trace.fault], movement.largest[trace.fault]
        for end, at in zip(trace.ends, (trace.start, trace.stop), strict=True):
            if end != "tip":
                continue
            where, left = throw_along(movement, trace, int(at))
            if abs(left[0]) > DIES * largest:
                name, horizon = slip.section.name, movement.picks.name
                raise GeometryError(
                    f"fault {name!r} ends inside horizon {horizon!r} at {place(where[0])}, "
                    f"where its throw is still {left[0]:.3g} m. Let throw die there, or extend "
                    "the fault to the edge of the horizon or to another fault.",
                    place=where[0],
                    surfaces=(name, horizon),
                )


def torn_by_throw(movement: Movement, network: Network) -> tuple[Network, tuple[str, ...]]:
    """The traces that have throw, torn where they have it; and notes of faults that do not tear.

    Where throw has died before its fault does, the horizon is whole: the tear ends there.
    """
    rows: list[int] = []
    traces: list[Trace] = []
    mesh, solve = network.mesh.copy(), network.solve.copy()
    for i, trace in enumerate(network.traces):
        throw = throw_along(movement, trace, slice(None))[1]
        some = np.flatnonzero(np.abs(throw) > NIL * movement.frame.cell)
        if len(some) == 0:
            continue

        # one vertex past the throw at each end, unless the fault itself ends before
        ends = list(trace.ends)
        for k, first, outer in ((0, some[0] - 1, max), (1, some[-1] + 1, min)):
            if outer(float(first), mesh[i, k]) != mesh[i, k]:
                mesh[i, k] = solve[i, k] = float(first)
                ends[k] = "tip"
        rows.append(i)
        traces.append(replace(trace, ends=ends))

    met = {trace.fault for trace in network.traces}
    notes = [
        f"Fault {slip.section.name!r} does not meet the horizon."
        for k, slip in enumerate(movement.slips)
        if k not in met
    ]
    notes += [
        f"Fault {movement.slips[trace.fault].section.name!r} has no throw at the horizon."
        for i, trace in enumerate(network.traces)
        if i not in rows
    ]
    return network.with_traces(traces, mesh[rows], solve[rows]), tuple(notes)


def refuse_steps(
    movement: Movement, branches: Branches, cuts: Cuts, walls: np.ndarray, drape: np.ndarray
) -> None:
    """Raise an error for a step between neighbours that no fault parts: a fault is too short.

    `walls` (n_slip, n_node) and `drape` (n_node,) are those of one attempt, `cuts` its cut links.
    """
    frame, n_node = movement.frame, movement.picks.n_node
    # neighbours in different walls that no trace parts: the horizon has to be continuous there
    for pairs in uncut_steps(walls, cuts.node, cuts.kind, *frame.shape):
        if not len(pairs):
            continue
        i, j = pairs.T
        used = distinct(i, j)
        parts = np.zeros((len(walls), n_node))
        parts[:, used] = movement.parts(branches, walls[:, used])
        for k, slip in enumerate(movement.slips):
            # the throw of the fault between neighbours in different walls of it
            rows = np.flatnonzero(parts[k, i] != parts[k, j])
            xyz = _crossing(movement, drape, k, i[rows], j[rows])
            s = slip.section.of(xyz[:, :2])[0].clip(0.0, slip.section.length)
            left = np.abs(slip.amount(s, xyz[:, 2], xyz[:, :2]))
            left *= np.abs(parts[k, i[rows]] - parts[k, j[rows]])
            bad = np.flatnonzero(left > STEP * movement.largest[k])
            if len(bad) == 0:
                continue

            where = xyz[bad[0]] + np.append(frame.corner, 0.0)
            name, horizon = slip.section.name, movement.picks.name
            raise GeometryError(
                f"fault {name!r} does not reach horizon {horizon!r} at {place(where)}, where "
                f"its throw is {left[bad[0]]:.3g} m. Extend the fault there, or let throw die "
                "before.",
                place=where,
                surfaces=(name, horizon),
            )


def _crossing(
    movement: Movement, drape: np.ndarray, fault: int, one: np.ndarray, two: np.ndarray
) -> np.ndarray:
    """Places (n, 3) between pairs of nodes, one in each wall, at which they meet a fault."""
    here, there = (np.column_stack([movement.xy[k], drape[k]]) for k in (one, two))
    far = [np.abs(movement.distance(fault, at[:, :2], at[:, 2])) for at in (here, there)]
    both = far[0] + far[1]
    share = np.divide(far[0], both, out=np.full_like(both, 0.5), where=both > 0)[:, None]
    found: np.ndarray = here + share * (there - here)
    return found


def throw_at_early_ends(
    movement: Movement, network: Network, cuts: Cuts, shortened: Collection[tuple[int, int]]
) -> list[str]:
    """How much throw is left where tears end early: the horizon is continuous over it there."""
    found = []
    for row, end in sorted(shortened):
        trace, places = network.traces[row], cuts.place[cuts.trace == row]
        if len(places) == 0:
            continue
        last = int(places.min() if end == 0 else places.max())
        where, throw = throw_along(movement, trace, last)
        found.append(
            f"The tear of fault {movement.faults[trace.fault].name!r} ends early, at "
            f"{place(where[0])}, where its throw is still {throw[0]:.3g} m."
        )
    return found
