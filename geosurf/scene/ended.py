"""Faults that end at horizons, and virtual walls at their targets: what is dropped of patches.

Both are rare, so that the modules that do it are loaded by scenes with such rules.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from geosurf.conventions import counted
from geosurf.errors import GeosurfWarning
from geosurf.faults.rules import Rule
from geosurf.model import Patches
from geosurf.model.column import VirtualWall
from geosurf.model.faults import Truncation
from geosurf.scene.inputs import SceneInputs

if TYPE_CHECKING:  # pragma: no cover - types only
    from geosurf.faults.virtual.walls import Wall

# patches, what faults lost by ending at horizons, warnings of that, and virtual walls
Ended = tuple[Patches, tuple[Truncation, ...], tuple[GeosurfWarning, ...], tuple[VirtualWall, ...]]


def end_inside(
    patches: Patches,
    column: Mapping[str, str],
    inputs: SceneInputs,
    branches: Sequence[Rule],
    walls: Sequence[Wall],
) -> Ended:
    """
    Drop the parts of faults beyond the horizons that they end at, and of walls beyond theirs.

    Parameters
    ----------
    patches : Patches
        All that is enclosed, split.
    column : mapping of str to str
        Rules of the horizons.
    inputs : SceneInputs
        With `horizon_rules` and `compartments`.
    branches : sequence of Rule
        Faults that end at faults.
    walls : sequence of Wall
        Virtual walls before they are cut.

    Returns
    -------
    Ended
    """
    lost: tuple[Truncation, ...] = ()
    warnings: tuple[GeosurfWarning, ...] = ()
    parts: tuple[VirtualWall, ...] = ()
    if inputs.horizon_rules:
        from geosurf.scene.horizon_ends import end_at_horizons  # loaded by those who have some

        patches, lost, warnings = end_at_horizons(patches, column, inputs.horizon_rules, branches)
    if inputs.compartments:
        from geosurf.scene.horizon_ends import end_virtual_walls  # and these, too

        patches, parts, more = end_virtual_walls(patches, walls, inputs.compartments)
        warnings = (*warnings, *more)
    return patches, lost, warnings, parts


def describe(found: Ended) -> str:
    """Return how many patches, and what faults lost by ending at horizons, in words."""
    return "; ".join([counted(found[0].n_patch, "patch"), *map(str, found[1])])
