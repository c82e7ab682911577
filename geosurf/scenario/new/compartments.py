"""Faults that die inside the field: virtual walls that may divide regions there."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

from geosurf.conventions.text import length_text
from geosurf.errors import GeosurfError
from geosurf.model.compartments import ENDS, VirtualWall
from geosurf.scenario.new.network import End, joined_rules
from geosurf.scene import Scene

MOST = 12  # faults that are tried one by one where all of them together are refused


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
    if walls is not None or len(names) > MOST:
        return walls or ()
    # One after another: a fault that contradicts those before it is left out.
    taken: list[str] = []
    found: tuple[VirtualWall, ...] = ()
    for name in names:
        walls = _built(scene, [*taken, name])
        if walls is not None:
            taken, found = [*taken, name], walls
    return found


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


__all__ = ["Divider", "dividers_among"]
