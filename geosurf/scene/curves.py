"""The curves of a scene: those of one pair of surfaces, and those of all pairs together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from geosurf.arrangement import find_contacts, meeting_surfaces
from geosurf.conventions import counted
from geosurf.intersect import curves_of, merge_curves
from geosurf.model import Curves, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.scene.area import boxes_meet
from geosurf.scene.inputs import SceneInputs
from geosurf.scene.memory import Memory

Pair = tuple[int, int]


def curves_of_pair(
    pair: Sequence[TriSurface],
    origin: np.ndarray,
    *,
    voxel_size: float | None,
) -> Curves:
    """Return the curves of two surfaces, or along which one surface crosses itself.

    Parameters
    ----------
    pair : one or two TriSurface
    origin : ndarray of float64, shape (3,)
        Of the local frame.
    voxel_size : float or None
        As for `Scene`.
    """
    pairs = [(0, len(pair) - 1)]
    how: dict[str, Any] = {"pairs": pairs, "origin": origin, "voxel_size": voxel_size}
    return curves_of(find_contacts(pair, **how))


def remembered_curves(
    inputs: SceneInputs,
    memory: Memory,
    pair: tuple[TriSurface, ...],
    origin_for: Callable[[Sequence[TriSurface]], np.ndarray],
    near: bool,
) -> Curves | None:
    """Return the curves of one or two surfaces, from memory if they are there.

    Parameters
    ----------
    inputs : SceneInputs
    memory : Memory
    pair : one or two TriSurface
    origin_for : callable
        Surfaces -> origin of their local frame.
    near : bool
        Whether some of their parts are near.

    Returns
    -------
    Curves or None
        None where they, or all of their parts, are apart.
    """
    subject = f"{pair[0].name} x {pair[-1].name}"
    far = not boxes_meet(pair[0].bounds, pair[-1].bounds)
    if far or not near:
        boxes = "boxes" if far else "boxes of their parts"
        memory.note("curves", subject, "skipped", f"{boxes} do not meet")
        return None

    # the key: both surfaces, their frame, and the voxels of the search
    origin, keys = origin_for(pair), map(memory.key_of, pair)
    return memory.get_or_compute(
        "curves", subject, ("curves", *keys, origin.tobytes(), inputs.voxel_size),
        lambda: curves_of_pair(pair, origin, voxel_size=inputs.voxel_size),
        lambda curves: counted(curves.n_curve, "curve"),
    )  # fmt: skip


def curves_of_all(
    inputs: SceneInputs,
    surfaces: Sequence[TriSurface],
    origin: np.ndarray,
    inside: Sequence[bool],
    shared: Callable[[str, str], Curves | None],
    searched: Callable[[tuple[TriSurface, ...], bool], Curves | None],
) -> Curves:
    """Return the curves of all pairs of surfaces as one, in the reference system of these.

    Parameters
    ----------
    inputs : SceneInputs
        Whether each surface is compared with itself, too, and how pairs are searched: with trees
        it is asked first which are near, of all pairs at once.
    surfaces : sequence of TriSurface
    origin : ndarray of float64, shape (3,)
        Of the local frame.
    inside : sequence of bool
        Which surfaces end where the split mesh decides.
    shared : callable
        Names of two surfaces -> their curves in the split mesh.
    searched : callable
        One or two surfaces, and whether they are near -> their curves; None where they are apart.
    """
    n, alone = len(surfaces), inputs.self_intersections
    pairs = [(i, j) for i in range(n) for j in range(i, n) if i < j or (alone and not inside[i])]
    asked = [(i, j) for i, j in pairs if not inside[i] and not inside[j]]
    near = set(meeting_surfaces(surfaces, asked) if inputs.voxel_size is None else asked)

    # the same curves whatever was computed first
    parts = []
    for i, j in pairs:
        if inside[i] or inside[j]:
            part = shared(surfaces[i].name, surfaces[j].name)
        else:
            both = tuple(surfaces[k] for k in dict.fromkeys((i, j)))
            part = searched(both, (i, j) in near)
        if part is not None:
            parts.append(((i, j), part))

    return in_crs_of(merge_curves(inputs.names, origin, parts), surfaces)
