"""From a closed mesh to a `Sheet`: what sheets as picked and sheets by throw have in common."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu

from geosurf.conventions import counted, place
from geosurf.conventions.crs import refuse_other_crs, warn_of_unclear_crs
from geosurf.errors import GeometryError, InputError
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.sheets.smooth_surface import energy_gradient
from geosurf.model import FaultCut, Lattice, Sheet, SheetReport, ThrowReport, TriSurface, frozen
from geosurf.model.excerpt import CloseUp
from geosurf.model.surfaces import Content
from geosurf.rebuild.ghosts import WALL
from geosurf.sheets.faults.fault_distance import NearTrace
from geosurf.sheets.faults.network import faults_in_words
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.data import Scattered
from geosurf.sheets.lattice.picks import Picks, scale_of
from geosurf.sheets.lattice.solve import BEND, CHOLESKY, EXACT, Graph, energy_of, weights_of
from geosurf.sheets.mesh.build import Built
from geosurf.sheets.mesh.cut import Hole, walls_of_vertices
from geosurf.sheets.mesh.ghosts import HOLD, sheet_around
from geosurf.sheets.mesh.torn_mesh import Torn, Triangles
from geosurf.triangulate import triangulate_fault

# ---- overlap points ----------------------------------------
# Scattered points of an overlapping sheet that lie past the trace of their fault.
#
# A reverse fault makes a horizon overlap itself: points of each wall go on past the trace, over the
# other wall. They give the heights of the ghosts of their own wall between the four vertices of a
# cell, as points in front of the trace do for the nodes (`geosurf.sheets.heights.passes`).
# Ghosts and the nodes around them are solved for together, so that a wall is as smooth beyond its
# trace as before it.


def points_beyond_trace(
    picks: Scattered, state: Heights, torn: Torn
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points past a trace whose cell has all four vertices on the sheet of their own wall.

    Returns
    -------
    vertex : ndarray of int64 (n, 4)
        Of `torn`: nodes of that wall, and its ghosts over those of the other one.
    share : ndarray (n, 4)
        Of each vertex in the height at the point.
    pick : ndarray of int64 (n,)
    """
    # each trace and side: points past the trace that belong to the wall of that side
    nodes, shares = picks.corners()
    parts = [(np.empty((0, 4), np.int64), np.empty((0, 4)), np.empty(0, np.int64))]
    for trace, side in np.unique(state.beyond[:, 1:], axis=0).tolist():
        mine = (state.beyond[:, 1:] == (trace, side)).all(axis=1)
        pick = state.beyond[mine, 0]
        vertex = on_sheet(nodes[pick], state.near[trace], side, torn)
        whole = (vertex >= 0).all(axis=1)
        parts.append((vertex[whole], shares[pick[whole]], pick[whole]))
    vertex, share, pick = (np.concatenate(part) for part in zip(*parts, strict=True))
    return vertex, share, pick


def on_sheet(nodes: np.ndarray, near: NearTrace, side: int, torn: Torn) -> np.ndarray:
    """The vertex of one wall's sheet over each node, of any shape; -1 where there is not one."""
    # own nodes stay; over nodes of the other wall, the ghost whose anchor is on this side
    at = near.look_up(nodes.ravel())
    on_wall = (at >= 0) & (near.side[at] == side)
    of = near.look_up(torn.anchor)
    ghosts = np.flatnonzero((of >= 0) & (near.side[of] == side))
    ghosts = ghosts[np.argsort(torn.node_of_ghost[ghosts], kind="stable")]
    over = torn.node_of_ghost[ghosts]

    # ghosts first to stop of the sorted list lie over each node
    first, stop = (np.searchsorted(over, nodes.ravel(), side=end) for end in ("left", "right"))
    out = np.full(nodes.size, -1)
    single = stop - first == 1  # where sectors meet a wall may have several
    out[single] = torn.n_node + ghosts[first[single]]
    out[on_wall] = nodes.ravel()[on_wall]
    return out.reshape(nodes.shape)


def ghosts_by_points(
    picks: Scattered, weight: float | None
) -> Callable[[Torn, Triangles, np.ndarray, Heights, Callable | None], dict[int, float]]:
    """Make the function that gives heights of the ghosts that points determine; it writes nodes."""

    def found(
        torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights, bent: Callable | None
    ) -> dict[int, float]:
        """Heights of ghosts, by number."""
        vertex, share, pick = points_beyond_trace(picks, state, torn)
        # No overlap: ghosts follow from the energy alone.
        if not len(pick):
            return {}

        # nodes near these ghosts move with them; farther ones hold the sheet
        fixed = distinct(vertex[vertex >= torn.n_node]) - torn.n_node
        nodes, graph, value, bend, moves = sheet_around(
            torn, triangles, bits, state.values, fixed, bent
        )

        # points of the wall itself in that region are rows as well
        used = np.flatnonzero(state.used)
        own, shares = picks.corners()
        used = used[is_among(own[used].ravel(), nodes).reshape(-1, 4).all(axis=1)]
        vertex, pick = np.concatenate([own[used], vertex]), np.concatenate([used, pick])

        # rows whose four vertices are in the graph; slot (n, 4): their rows there
        known = is_among(vertex.ravel(), nodes).reshape(-1, 4) | (vertex >= torn.n_node)
        rows = known.all(axis=1)
        vertex, pick, share = vertex[rows], pick[rows], np.concatenate([shares[used], share])[rows]
        slot = np.where(
            vertex >= torn.n_node, len(nodes) + vertex - torn.n_node, np.searchsorted(nodes, vertex)
        )

        # solve for what is left without the bend at tips, nodes first, then ghosts
        z = picks.z[pick] - (share * bend[slot]).sum(axis=1)
        value = _drawn_to(graph, value, moves, slot, share, z, picks.frame.stretch, weight) + bend
        moved = moves[: len(nodes)]
        state.values[nodes[moved]] = value[: len(nodes)][moved]
        return dict(zip(fixed.tolist(), value[len(nodes) + fixed].tolist(), strict=True))

    return found


def _drawn_to(
    graph: Graph,
    value: np.ndarray,
    moves: np.ndarray,
    slot: np.ndarray,
    share: np.ndarray,
    z: np.ndarray,
    stretch: np.ndarray,
    weight: float | None,
) -> np.ndarray:
    """Heights (n,) that are smooth where they move, bool (n,), and near points z (m,).

    Each point lies between the vertices `slot` (m, 4), by `share` (m, 4). What no point and no
    fixed height reaches stays about where it was.
    """
    # heights from the mean of the points: digits go to the relief, not to the depth
    level = float(z.mean())
    free = np.flatnonzero(moves)
    # Unknowns are the vertices that move; the others enter the right-hand side.
    number = np.where(moves, np.cumsum(moves) - 1, -1)
    weights = weights_of(stretch, BEND, scale=scale_of(weight))
    fixed = np.where(moves, 0.0, value - level)
    held = energy_gradient(graph.east, graph.north, graph.square, fixed[:, None], weights)[free, 0]

    # rows of points (m, n_vertex); left: what the fixed vertices leave over
    where = np.repeat(np.arange(len(z)), 4), slot.ravel()
    points = csc_array((share.ravel(), where), shape=(len(z), len(value)))
    left = z - level - points @ fixed
    points = csc_array(points[:, free])

    # energy, plus the square of the misfits, plus a very small pull to where vertices were
    pull = weight or EXACT
    matrix = energy_of(graph, number, weights) + pull * (points.T @ points)
    factor = splu(csc_array(matrix + HOLD * eye_array(len(free))), **CHOLESKY)
    right = pull * (points.T @ left) - held + HOLD * (value[free] - level)
    out = value.copy()
    out[free] = factor.solve(right) + level
    return out


SEEN = 3.0  # cells around a hole that its picture shows
FAR_OVER = 2.0  # cells of overlap from which it is what keeps scattered points open at a tip


def fault_surfaces(faults: Mapping[str, Any] | Sequence[TriSurface]) -> tuple[TriSurface, ...]:
    """Faults in any form, as surfaces with normals into their hanging walls."""
    # Names of a mapping win; surfaces of a list have their own.
    if isinstance(faults, Mapping):
        _refuse_names({f"faults[{key!r}]": fault for key, fault in faults.items()})
        made = tuple(triangulate_fault(fault, name=str(key)) for key, fault in faults.items())
    elif isinstance(faults, TriSurface | str | PathLike) or not isinstance(faults, Sequence):
        _refuse_names({"faults": faults})
        raise InputError(
            f"faults is a {type(faults).__name__}; give a mapping {{name: fault}} or a list of "
            "surfaces."
        )
    else:
        _refuse_names({f"faults[{k}]": fault for k, fault in enumerate(faults)})
        for fault in faults:
            if isinstance(fault, TriSurface):
                Content(fault)  # hashed here, once: the surfaces that are made of it know it
        made = tuple(triangulate_fault(fault) for fault in faults)
    names = [fault.name for fault in made]
    # Results are by name: two faults cannot share one.
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{names.count(name)} faults are called {name!r}; rename them.")
    return made


def check_crs(name: str, crs: str | None, faults: Sequence[TriSurface]) -> None:
    """Refuse faults in another coordinate reference system than the data of a horizon."""
    known = {} if crs is None else {name: crs}
    for fault in faults:
        # Each fault is compared with all before it.
        refuse_other_crs(fault.name, fault.crs, known)
        if fault.crs is not None:
            known[fault.name] = fault.crs
    warn_of_unclear_crs(known)


def _refuse_names(given: Mapping[str, Any]) -> None:
    """Refuse names and paths where faults themselves are expected."""
    for where, fault in given.items():
        if isinstance(fault, str | PathLike):
            raise InputError(
                f"{where} is the text {str(fault)!r}, not a fault. Give the surfaces themselves: a "
                "mapping {name: fault}, or a list of what geosurf.read_fault(path) or "
                "triangulate_fault returns."
            )


def sheet_of(
    picks: Picks,
    built: Built,
    faults: Sequence[TriSurface],
    cuts: Mapping[str, FaultCut],
    report: SheetReport | ThrowReport,
) -> Sheet:
    """The noun from its parts."""
    frame, torn = picks.frame, built.torn
    # The lattice keeps the solved heights: maps and areas read them.
    values = built.state.values.reshape(frame.shape)
    lattice = Lattice(frame.easting, frame.northing, values, built.triangles.rising)
    ghosts = np.column_stack([frame.node_places(torn.node_of_ghost), built.ghosts])
    outer = np.zeros(len(ghosts), dtype=bool)
    # Ghosts are numbered behind the nodes.
    outer[built.outer - torn.n_node] = True
    return Sheet(
        name=picks.name,
        lattice=lattice,
        divided=frozen(torn.divided, np.int64),
        copies=frozen(torn.corners, np.int64),
        ghosts=frozen(ghosts.reshape(-1, 3), np.float64),
        outer=frozen(outer, np.bool_),
        faults=tuple(faults),
        cuts=cuts,
        report=report,
        walls=None if built.walls is None else _walls(built),
    )


def _walls(built: Built) -> dict[str, np.ndarray]:
    """Walls of nodes, then of ghosts."""
    torn = built.torn
    every = np.arange(torn.n_node + len(torn.anchor))
    found = walls_of_vertices(built.walls, torn, every)
    return {key.removeprefix(WALL): frozen(of, np.int8) for key, of in found.items()}


def refuse_leaks(picks: Picks, built: Built, faults: Sequence[TriSurface]) -> None:
    """Raise an error where a sheet does not end on its faults, with the place and a remedy."""
    if not built.is_open:
        return
    worst, what = largest_hole(built)
    names = [faults[k].name for k in sorted(faults_at(worst, built))]
    remedy = remedy_of_overlap(picks, built) or (
        "Leave that fault out, or end it on its main fault and tear with "
        "gs.truncate_faults(gs.rebuild_surfaces(faults), truncations).surfaces."
    )
    raise GeometryError(
        f"horizon {picks.name!r} could not be cut at {faults_in_words(names)}: {what}. {remedy}",
        place=worst.place,
        surfaces=(picks.name, *names),
        close_up=close_up(picks, built, faults, worst),
    )


def largest_hole(built: Built) -> tuple[Hole, str]:
    """The largest hole of a sheet that is open, and how many there are, in words."""
    worst, n = max(built.cut.holes, key=lambda hole: hole.length), len(built.cut.holes)
    return worst, (
        f"{counted(n, 'hole')} {'stays' if n == 1 else 'stay'} open, the largest "
        f"{worst.length:.0f} m long near {place(worst.place)}"
    )


def close_up(
    picks: Picks | Scattered, built: Built, faults: Sequence[TriSurface], hole: Hole
) -> CloseUp:
    """The sheet as far as it was built around a hole, its faults, and the data there."""
    patches, cell = built.cut.patches, picks.frame.cell
    reach = max(SEEN * cell, 3.0 * float(np.ptp(hole.edges, axis=(0, 1)).max()))
    rows, at = built.cut.inside, patches.local + patches.origin
    near = (np.abs(at[patches.triangles[rows]] - hole.place)[..., :2] <= reach).any(axis=(1, 2))
    used, corners = np.unique(patches.triangles[rows[near]], return_inverse=True)
    sheet = TriSurface(picks.name, "horizon", at[used], corners.reshape(-1, 3))
    state, data = built.state, {}
    for name, mine in (("Data in use", state.used), ("Data ignored", state.ignored)):
        places = picks.places(np.flatnonzero(mine))
        data[name] = places[(np.abs(places - hole.place)[:, :2] <= reach).all(axis=1)]
    return CloseUp((sheet, *faults), reach, hole.edges, data)


def remedy_of_overlap(picks: Picks | Scattered, built: Built) -> str:
    """What to do where scattered points overlap too far; empty where they do not."""
    # Overlaps are negative heaves.
    widest = max((-w.heave(w.place).min(initial=0.0) for w in built.state.walls), default=0.0)
    if picks.on_nodes or widest <= FAR_OVER:
        return ""
    return (
        f"The horizon overlaps itself by up to {widest:.1f} cells, and scattered points do not "
        "close its tips there. Give points on a lattice, one per wall, or a larger spacing."
    )


def open_faults(built: Built) -> set[int]:
    """Numbers of the faults next to the holes of a sheet that stayed open."""
    if not built.is_open:
        return set()
    found = set().union(*(faults_at(hole, built) for hole in built.cut.holes))
    return found or {trace.fault for trace in built.state.network.traces}


def faults_at(hole: Hole, built: Built) -> set[int]:
    """Numbers of the faults at a hole: where they meet, any of those about as near may leave it."""
    network, frame = built.state.network, built.state.network.frame
    # In cells of the lattice, as traces are.
    at = frame.to_cells(hole.place[None, :2])[0]
    far = [float(trace.far_from(at).min()) for trace in network.traces]
    pairs = zip(network.traces, far, strict=True)
    return {trace.fault for trace, cells in pairs if cells <= min(far) + 2.0}


def lost_cutoffs(built: Built, cuts: Mapping[str, FaultCut]) -> set[int]:
    """Numbers of the faults at which a sheet is torn, though none of a wall ends on them."""
    lost = set()
    for number, cut in enumerate(cuts.values()):
        # A fault may have several traces on one horizon.
        traces = [i for i, trace in enumerate(built.state.network.traces) if trace.fault == number]
        if np.isin(built.cuts.trace, traces).any() and not all(cut.cutoffs.values()):
            lost.add(number)
    return lost


def refuse_lost_cutoffs(picks: Picks, cuts: Mapping[str, FaultCut], lost: Collection[int]) -> None:
    """Refuse a sheet that is torn at faults, by number, on which one of its walls does not end."""
    # The middle station stands for the fault in the message.
    for number, (name, cut) in enumerate(cuts.items()):
        if number in lost:
            at = cut.stations[len(cut.stations) // 2]
            raise GeometryError(
                f"horizon {picks.name!r} is torn at fault {name!r} near {place(at)}, but a wall "
                "does not reach the fault there. Extend the fault and tear with "
                "gs.extend_fault(fault, box, sides=('up', 'down')).surface, or correct the data "
                "next to it.",
                place=at,
                surfaces=(picks.name, name),
            )
