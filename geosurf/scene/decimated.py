"""Horizons of a model within a tolerance: every k-th node, the same of all on one frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from geosurf.model import Lattice, TriSurface
from geosurf.scene.inputs import SceneInputs
from geosurf.scene.memory import Memory
from geosurf.triangulate.decimate import can_be_decimated, decimate_frame, strides_of


def decimated(
    inputs: SceneInputs, memory: Memory, whole: Callable[[str], TriSurface]
) -> dict[str, TriSurface]:
    """
    Return the horizons of a model that have fewer nodes, by name.

    Horizons whose grids have the same nodes in the map keep the same rows and columns, so that
    which of two is higher stays the same at every place, and where they coincide. All of them are
    within the tolerance of all their nodes, or none is decimated. None is in a scene without a
    tolerance, or whose horizons are tied to tops: a tie is exact with all nodes only.

    Parameters
    ----------
    inputs : SceneInputs
    memory : Memory
        Gets a step for each frame, with the largest difference.
    whole : callable
        Name of a horizon -> its surface with all nodes.

    Examples
    --------
    >>> import geosurf as gs
    >>> dome = gs.synthetic.dome_and_flat_fault(n=401).horizons["Top"]
    >>> top = gs.triangulate_horizon(dome, name="Top")
    >>> made = decimated(SceneInputs({"Top": top}, tolerance=0.5), Memory(), lambda name: top)
    >>> made["Top"].lattice.shape, bool(made["Top"].vertex_data["vertical_error"].max() < 0.5)
    ((101, 101), True)
    """
    found: dict[str, TriSurface] = {}
    tolerance = inputs.tolerance
    if tolerance is None or inputs.tie is not None:
        return found
    for frame in _frames([*map(whole, inputs.horizons)]):
        subject = ", ".join(one.name for one in frame)
        if (why := _needs_all(frame)) is not None:
            memory.note("decimate", subject, "skipped", f"all nodes: {why}")
            continue
        made = memory.get_or_compute(
            "decimate", subject, ("decimate", tolerance, *map(memory.key_of, frame)),
            partial(decimate_frame, frame, tolerance), _in_words, again=False,
        )  # fmt: skip
        found.update({one.name: one for one in made})
        for given, one in zip(frame, made, strict=False):  # which of its nodes follows from n
            memory.made_of(one, ("decimated", one.n_vertex, memory.key_of(given)))
    return found


def _frames(horizons: Sequence[TriSurface]) -> list[list[TriSurface]]:
    """Horizons that are grids, in groups that have the same nodes in the map."""
    groups: list[tuple[Lattice, list[TriSurface]]] = []
    for one in horizons:
        if one.lattice is None:
            continue
        for lattice, group in groups:
            if lattice.shares_map(one.lattice):
                group.append(one)
                break
        else:
            groups.append((one.lattice, [one]))

    return [group for _, group in groups]


def _needs_all(frame: list[TriSurface]) -> str | None:
    """Why the horizons of one frame keep all nodes, before these are looked at."""
    shape = None if frame[0].lattice is None else frame[0].lattice.shape
    if shape is None or not strides_of(shape):
        return "the grid is small"
    other = [one.name for one in frame if not can_be_decimated(one)]
    if not other:
        return None
    if any("vertical_error" in one.vertex_data for one in frame):
        return "of one, nodes have been left out already"
    return f"{other[0]} has absent nodes"


def _in_words(made: list[TriSurface]) -> str:
    """Every how many nodes are kept, and what that changes at most."""
    if not made:
        return "all nodes: fewer would be off by more than the tolerance"
    off = max(float(one.vertex_data["vertical_error"].max()) for one in made)
    return f"{made[0].n_vertex} nodes each, at most {off:.2g} m off"
