"""Virtual walls of compartments, before they are cut at their targets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.arrangement import find_contacts
from geosurf.conventions import counted
from geosurf.faults.dangling import edges_of, model_of
from geosurf.faults.virtual.walls import Wall, build_virtual_walls
from geosurf.measure.section import chains_of
from geosurf.model import Patches, TriSurface
from geosurf.rebuild import patches_from
from geosurf.scene.inputs import Box, SceneInputs
from geosurf.scene.memory import Memory


def find_virtual_walls(
    inputs: SceneInputs,
    memory: Memory,
    faults: Sequence[TriSurface],
    box: Box,
    aoi: np.ndarray | None,
) -> list[Wall]:
    """
    Return the virtual walls of a scene, from memory if they are there.

    Parameters
    ----------
    inputs : SceneInputs
        With `compartments`.
    memory : Memory
    faults : sequence of TriSurface
        As the model has them.
    box : (west, east, south, north, bottom, top)
    aoi : ndarray of float64, shape (n, 2), or None
        Corners of the area of the model.
    """
    stated = str(inputs.compartments)
    keys = (*map(memory.key_of, faults), stated, box, None if aoi is None else aoi.tobytes())

    def make() -> list[Wall]:
        """Split all faults, which shows where each of them dies."""
        split = patches_from(find_contacts(faults, origin=np.zeros(3)))
        return build_virtual_walls(split, faults, inputs.compartments, model_of(box, aoi))

    return memory.get_or_compute(
        "virtual walls", counted(len(inputs.compartments), "fault"), ("virtual", *keys), make,
        lambda walls: counted(len(walls), "wall"), again=False,
    )  # fmt: skip


def lines_on(patches: Patches, horizon: str) -> dict[str, list[np.ndarray]]:
    """
    Return where virtual walls meet a horizon.

    Parameters
    ----------
    patches : Patches
    horizon : str

    Returns
    -------
    dict of str to list of ndarray of float64, each (n, 3)
        World coordinates along each line, by name of the virtual wall [m].
    """
    on = edges_of(patches, [horizon])
    found = {}
    for name in (one.name for one in patches.sources if one.role == "virtual"):
        keys = np.intersect1d(edges_of(patches, [name]), on)
        edges = np.stack(np.divmod(keys, len(patches.local)), axis=1)
        found[name] = [patches.vertices[line] for line in chains_of(edges, patches.local)]
    return found
