"""Faults that stop short of another fault: they end there if their throw does not die before."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geosurf.conventions import grouped
from geosurf.conventions.checks import are_points
from geosurf.conventions.text import length_text
from geosurf.errors import GeosurfError
from geosurf.model import TriSurface
from geosurf.model.column import ENDS, VirtualWall
from geosurf.model.network import NetworkRow
from geosurf.scenario.new.judge import Found, Ready, thinned
from geosurf.scene import Scene
from geosurf.scene.surfaces import footprint
from geosurf.triangulate import triangulate_fault, triangulate_horizon

# ---- compartments ----------------------------------------
# Faults that die inside the field: virtual walls that may divide regions there.


MOST_WALLS = 12  # faults that are tried one by one where all of them together are refused


@dataclass(frozen=True)
class Divider:
    """A fault of ``[compartments]``, and where its ends would be continued to."""

    fault: str
    walls: tuple[VirtualWall, ...]

    @property
    def reason(self) -> str:
        """Where its ends go, for a comment."""
        ends = [f"{one.side} to {_target(one)}: {length_text(one.length)}" for one in self.walls]
        return ", ".join(ends) or "continued up and down only"


def dividers_among(scene: Scene | None, ends: Sequence[End]) -> list[Divider]:
    """
    Return the faults that virtual walls would continue, so that they divide the field.

    Empty if no fault dies inside the field, or the walls cannot be built. `scene` has the faults;
    see `faults_of`.
    """
    if scene is None:
        return []
    extend, truncations = joined_rules(ends)
    try:
        joined = scene.replace(extend=extend, truncations=truncations)
    except GeosurfError:
        return []  # the run names what is wrong
    walls = _walls(joined, [*scene.fault_names])
    # A field without ends inside has nothing to ask.
    if not any(one.side in ENDS for one in walls):
        return []
    names = dict.fromkeys(one.fault for one in walls)
    return [
        Divider(name, tuple(w for w in walls if w.fault == name and w.side in ENDS))
        for name in names
    ]


def _walls(scene: Scene, names: list[str]) -> tuple[VirtualWall, ...]:
    """Virtual walls of all faults; where these are refused together, of as many as possible."""
    walls = _built(scene, names)
    if walls is not None or len(names) > MOST_WALLS:
        return walls or ()
    # One after another: a fault that contradicts those before it is left out.
    taken: list[str] = []
    accepted: tuple[VirtualWall, ...] = ()
    for name in names:
        walls = _built(scene, [*taken, name])
        if walls is not None:
            taken, accepted = [*taken, name], walls
    return accepted


def _built(scene: Scene, names: list[str]) -> tuple[VirtualWall, ...] | None:
    """Virtual walls of some faults, or None where these cannot be built."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return scene.replace(compartments=names).virtual_walls
        except GeosurfError:
            return None


def _target(wall: VirtualWall) -> str:
    return "the boundary" if wall.target == "boundary" else wall.target


SIDES = ("up", "down")  # of both faults: sticks that miss another fault often stop short there, too
SHARE = 0.5  # of the largest throw of a fault: a fault with less at its end dies there
STATIONS = 9  # along a fault where throw is estimated
NEAR, FAR = 0.02, 0.12  # distances from the fault, in its lengths, of the nodes that are compared
MOST = 60_000  # nodes of one horizon that are looked at


@dataclass(frozen=True)
class End:
    """One fault that stops short of another, and whether it ends there."""

    row: NetworkRow
    joined: bool
    share: float


def faults_of(ready: Ready) -> Scene | None:
    """Return the faults in the box and area of the model, without horizons.

    None where there are none, no elevations yet, or no box: then there is no geometry to look at.
    """
    faults, horizons = ready.of("fault"), ready.of("horizon")
    if ready.asks_direction or not faults or not horizons:
        return None
    try:
        # box and area as the run will have them, so that both propose the same
        around = Scene({one.name: in_map(one) for one in horizons})
        surfaces = {one.name: surface_of(one) for one in faults}
        return Scene({}, surfaces, around.box, aoi=around.aoi)
    except GeosurfError:
        return None  # the run names what is wrong


def truncations_among(ready: Ready, scene: Scene | None) -> list[End]:
    """Return faults that stop short of another, each with the share of its throw at that end.

    `scene` has the faults; see `faults_of`.
    """
    if scene is None or len(scene.fault_names) < 2:
        return []
    # A part of the nodes is enough to estimate throws.
    clouds = [thinned(one.elevations, MOST) for one in ready.of("horizon")]
    try:
        network = scene.propose_fault_network()
    except GeosurfError:
        return []  # the run names what is wrong with them, with a picture
    # Only ends that a truncation would join; crossings and far ends stay as they are.
    ends = [
        _end(row, scene.prepared_fault(row.fault).vertices, clouds)
        for row in network.rows
        if row.kind == "near miss" and row.proposal == "extend then truncate"
    ]
    return _tried(ends, scene)


def joined_rules(ends: Sequence[End]) -> tuple[Any, Any]:
    """Extensions and truncations of the ends that are joined, as a scene takes them."""
    joined = [one.row for one in ends if one.joined]
    rules = grouped((row.fault, (row.other, row.keep, True)) for row in joined)
    # Both faults are continued, so that the truncated one cuts through the main one.
    return {name: SIDES for row in joined for name in (row.fault, row.other)}, rules


def _tried(ends: list[End], scene: Scene) -> list[End]:
    """Join ends one after another, as far as the faults can be built with them."""
    done: list[End] = []
    for end in ends:
        if end.joined:
            # With all ends joined so far: rules may contradict each other only together.
            extend, rules = joined_rules([*done, end])
            made = scene.replace(extend=extend, truncations=rules)
            try:
                for name in extend:
                    made.prepared_fault(name)
            except GeosurfError:
                # Not joined, and not an error: the scenario asks instead.
                end = replace(end, joined=False)
        done.append(end)
    return done


def in_map(horizon: Found) -> TriSurface:
    """A horizon with elevations, for box and area; points as a grid."""
    if are_points(horizon.data):
        surface = footprint(horizon.name, horizon.data, {})
    else:
        surface = triangulate_horizon(horizon.data, name=horizon.name)
    return _with_elevations(surface, horizon)


def surface_of(fault: Found) -> TriSurface:
    """A fault as a surface, with elevations."""
    surface = fault.data
    # Sticks become a surface first.
    if not hasattr(surface, "triangles"):
        surface = triangulate_fault(surface, name=fault.name)
    return _with_elevations(surface.renamed(fault.name, "fault"), fault)


def _with_elevations(surface: TriSurface, file: Found) -> TriSurface:
    """A surface whose z is as in its file, with elevations [m]."""
    if file.scale == 1.0:
        return surface
    return surface.lifted(lambda z: z * file.scale)


def _end(row: NetworkRow, vertices: np.ndarray, clouds: list[np.ndarray]) -> End:
    """Compare the throw at the end of a fault with the largest along it."""
    middle = vertices[:, :2].mean(axis=0)
    # The longest direction of the fault in the map is its strike.
    along = np.linalg.svd(vertices[:, :2] - middle, full_matrices=False)[2][0]
    s = (vertices[:, :2] - middle) @ along
    length = float(np.ptp(s))
    # Strike points towards the end in question, so that the last station is there.
    if (np.asarray(row.place[:2]) - middle) @ along < 0:
        along, s = -along, -s

    # the last station is a little inside, so that nodes beyond the end do not count
    stations = np.linspace(s.min() + FAR * length / 2, s.max() - FAR * length / 2, STATIONS)
    throws = np.array([_throw_at(at, length, middle, along, clouds) for at in stations])
    largest = float(np.nanmax(throws)) if np.isfinite(throws).any() else 0.0
    # Throw at the end compared with the largest: a fault that dies out has little left.
    share = float(throws[-1] / largest) if largest > 0 and np.isfinite(throws[-1]) else 0.0
    return End(row, share >= SHARE, share)


def _throw_at(
    at: float, length: float, middle: np.ndarray, along: np.ndarray, clouds: list[np.ndarray]
) -> float:
    """Step of the horizons across a fault at one station: planes of one dip on both sides."""
    across = np.array([-along[1], along[0]])
    steps = []
    for cloud in clouds:
        relative = cloud[:, :2] - middle
        # Coordinates of nodes along and across the fault.
        s, r = relative @ along - at, relative @ across
        near = (np.abs(s) < FAR * length / 2) & (np.abs(r) < FAR * length)
        # Nodes in the smear next to the fault would lower the throw.
        near &= np.abs(r) > NEAR * length
        sides = np.sign(r[near])
        # Too few nodes on one side for a plane.
        if min((sides > 0).sum(), (sides < 0).sum()) < 6:
            continue
        # Elevation = constant + dip along + dip across + half the step: one plane, two sides.
        design = np.column_stack([np.ones(len(sides)), s[near], r[near], sides])
        steps.append(2 * abs(np.linalg.lstsq(design, cloud[near, 2], rcond=None)[0][3]))
    return float(np.median(steps)) if steps else np.nan
