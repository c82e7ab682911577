"""Faults that end at faults: which parts stay is decided in one exact arrangement.

All faults concerned are split along their common curves first, in one mesh. A truncation
then drops whole pieces of it, so that what stays shares vertices with the main fault, and parts
add up. Main faults come first, and others end at what is left of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError, InputError
from geosurf.faults.area import inside_area
from geosurf.faults.rim import normals_of
from geosurf.faults.rules import LEVELS, Rule, part_in_words, read_truncations
from geosurf.faults.sides import Adjacency, adjacency
from geosurf.faults.truncate_errors import goes_around, not_reached
from geosurf.model import Patches, TriSurface
from geosurf.model.expected import expect
from geosurf.model.faults import TruncatedFaults, Truncation

FENCE = "aoi"  # the wall around an area of interest, as `build_walls` calls it
# steeper than this a fault counts as vertical and has no hanging wall, as in orient_fault
_VERTICAL = 1e-6


def truncate_faults(
    patches: Patches, truncations: Any, *, whole: Patches | Callable[[], Patches] | None = None
) -> TruncatedFaults:
    """Let faults end at other faults.

    Parameters
    ----------
    patches : Patches
        Of all faults that the rules name, from one `rebuild_surfaces`; others may be among them.
        With the walls of the model box among them, sides are decided inside the box: where a
        fault goes on around the end of its main fault outside, it is cut off at the box.
    truncations : mapping
        As for `Scene`: ``{"F2": ("F1", "hanging wall")}`` lets F2 end at F1 and keeps what lies in
        the hanging wall of F1. A fault may end at several: a tuple of such pairs. Faults
        are extended before they are split; a third word True only records that this was done.
    whole : Patches or callable, optional
        The same faults split without the walls, or a function that returns them; it is called
        once all rules hold. What stays then has no cuts along the walls;
        only where a fault has to end at the box, all of them keep these cuts.

    Returns
    -------
    TruncatedFaults
        All faults among the surfaces, in the order of their names, with vertices and triangles
        in one order: the same bytes whatever the order of faults and triangles that came
        in. Coordinates are world metres.

    Raises
    ------
    InputError
        For an unknown name or word, a circle of truncations, the hanging wall of a
        vertical fault, or other faults in `whole`.
    GeometryError
        If the main fault is not reached (with the gap and its place), does not cut the fault
        through (with the place where it ends), or nothing would be left.

    Examples
    --------
    >>> from geosurf import rebuild_surfaces
    >>> main = [[0, 0, 0], [0, 8, 0], [8, 8, -8], [8, 0, -8]]
    >>> other = [[-4, 4, -6], [8, 4, -6], [8, 4, -2], [-4, 4, -2]]
    >>> faults = [
    ...     TriSurface("F1", "fault", main, [[0, 2, 1], [0, 3, 2]]),
    ...     TriSurface("F2", "fault", other, [[0, 1, 2], [0, 2, 3]]),
    ... ]
    >>> cut = truncate_faults(rebuild_surfaces(faults), {"F2": ("F1", "hanging wall")})
    >>> (line,) = cut.truncations
    >>> line.kept_area, line.dropped_area
    (16.0, 32.0)
    >>> cut.surfaces["F2"].bounds
    (2.0, 8.0, 4.0, 4.0, -6.0, -2.0)
    >>> sorted(set(cut.parents["F2"].tolist()))  # both triangles of F2 as it was given
    [0, 1]
    """
    how = "rebuild_surfaces of the faults makes them"
    expect(patches, Patches, "truncate_faults takes Patches", how)
    if whole is not None and not callable(whole):
        expect(whole, Patches, "truncate_faults takes Patches as whole", how)
    faults = [s.name for s in patches.sources if s.role == "fault"]
    rules = read_truncations(truncations, faults)
    alive = np.ones(patches.n_triangle, dtype=bool)
    steps = [_truncate(patches, alive, rule) for rule in rules]
    found = [step for step, _ in steps]
    walled = any(source.role == "wall" for source in patches.sources)
    if callable(whole):
        whole = whole()
    if whole is not None:
        _refuse_others(patches, whole, faults)
        uncut = _without_walls(patches, whole, rules, steps)
        if uncut is not None:
            patches, (alive, found), walled = whole, uncut, False
    surfaces, parents = {}, {}
    for name in sorted(faults):
        surfaces[name], parents[name] = _part(patches, name, alive)
    move = float(patches.report.get("largest_move", 0.0))
    return TruncatedFaults(surfaces, parents, tuple(found), move, walled)


def main_side(surface: TriSurface, keep: str) -> int:
    """Return +1 for the side into which the normals of a main fault point, -1 for the other.

    Raises
    ------
    InputError
        If the hanging wall of a vertical fault is requested, or what is above it.
    """
    if keep in ("+", "-"):
        return 1 if keep == "+" else -1
    corners = surface.vertices[surface.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = math.fsum(np.linalg.norm(normals, axis=1))
    normal = np.array([math.fsum(column) for column in normals.T])
    lead = next((c for c in normal[[2, 0, 1]] if abs(c) > _VERTICAL * area), 0.0)
    dipping = keep not in ("right", "left")
    if dipping and abs(normal[2]) <= _VERTICAL * area:
        what = f"nothing lies {keep} it" if keep in LEVELS else f"it has no {keep}"
        raise InputError(
            f"fault {surface.name!r} is vertical, so that {what}. Give 'right' or 'left' "
            "of its strike (right is east of it, or north where it strikes east), or '+' or '-'."
        )
    front = 1 if lead >= 0 else -1
    return front if keep in ("hanging wall", "right", "above") else -front


def _rows(patches: Patches, alive: np.ndarray, rule: Rule) -> dict[str, np.ndarray]:
    """What is left of the two faults of a rule, by name."""
    return {
        name: np.flatnonzero(alive & (patches.surface_of_triangle == patches.names.index(name)))
        for name in (rule.fault, rule.main)
    }


def _truncate(patches: Patches, alive: np.ndarray, rule: Rule) -> tuple[Truncation, np.ndarray]:
    """Drop what one rule drops from `alive`; return that, and what does not meet the main fault."""
    rows = _rows(patches, alive, rule)
    main = patches.sources[patches.names.index(rule.main)]
    side = main_side(main, rule.keep)
    mine = rows[rule.fault]

    # pieces that the main fault and the walls cut off, and on which side of it each one lies
    walls, inside = _inside(patches)
    beside = adjacency(patches, mine, rows[rule.main], walls)
    held = np.zeros(len(beside.within), dtype=bool)
    held[beside.piece[inside[mine]]] = True
    wanted = beside.beside[:, 0 if side > 0 else 1] & held
    unwanted = beside.beside[:, 1 if side > 0 else 0] & held

    # only where every piece has one side can a part be dropped
    if (wanted & unwanted).any():
        raise goes_around(patches, rule, beside, mine)
    if not (wanted | unwanted).any():
        raise not_reached(patches, rule, rows, inside)
    if not wanted.any():
        at = patches.vertices[beside.edges[0, 0]]
        raise GeometryError(
            f"fault {rule.fault!r} has no part {part_in_words(rule)}: nothing would "
            f"be left of it. It meets {rule.main!r} at {place(at)}; keep the other part.",
            place=at,
            surfaces=(rule.fault, rule.main),
        )

    # inside the box by side; outside, a piece follows the one that it goes on from
    gone = unwanted | (beside.within & held)
    wrong = beside.beside[:, 1 if side > 0 else 0] | beside.within
    gone |= ~held & (wrong | ~_hangs_on(gone, held, beside.across_walls))
    dropped = gone[beside.piece]
    apart = ~(wanted | gone)[beside.piece] & inside[mine]
    alive[mine[dropped]] = False

    sizes = _sizes(patches, mine, beside, dropped)
    off = math.fsum(_areas(patches, mine[apart]))
    words = rule.fault, rule.main, rule.keep, "+" if side > 0 else "-"
    return Truncation(*words, apart_area=off, **sizes), mine[apart]


def _sizes(
    patches: Patches, mine: np.ndarray, beside: Adjacency, dropped: np.ndarray
) -> dict[str, Any]:
    """Remaining and dropped areas of a fault's rows, and the length of the line that it ends on."""
    area = _areas(patches, mine)
    kept_edges = np.unique(beside.edge_of_half[~dropped[beside.half_edges // 3]])
    ends = patches.local[beside.edges[kept_edges]]
    return {
        "kept_area": math.fsum(area[~dropped]),
        "dropped_area": math.fsum(area[dropped]),
        "coinciding_area": math.fsum(area[beside.within[beside.piece]]),
        "length": math.fsum(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)),
    }


def _without_walls(
    patches: Patches,
    whole: Patches,
    rules: Sequence[Rule],
    steps: list[tuple[Truncation, np.ndarray]],
) -> tuple[np.ndarray, list[Truncation]] | None:
    """Drop the same from faults that no wall has cut; None where a fault has to end at the box.

    A piece of a fault without walls is one or more pieces with them. All of it is on one side
    of its main fault, or it goes around it beyond the box; and what stays in the box because
    nothing of it meets the main fault there must not be dropped for what it meets outside.
    """
    alive, found = np.ones(whole.n_triangle, dtype=bool), []
    for rule, (step, apart) in zip(rules, steps, strict=True):
        rows = _rows(whole, alive, rule)
        mine = rows[rule.fault]
        beside = adjacency(whole, mine, rows[rule.main], strict=False)
        right, wrong = beside.beside.T if step.side == "+" else beside.beside[:, ::-1].T
        dropped = (wrong | beside.within)[beside.piece]
        stays = np.isin(whole.parent_of_triangle[mine], patches.parent_of_triangle[apart])
        if (right & wrong).any() or (dropped & stays).any():
            return None
        alive[mine[dropped]] = False
        found.append(replace(step, **_sizes(whole, mine, beside, dropped)))
    return alive, found


def _refuse_others(patches: Patches, whole: Patches, faults: list[str]) -> None:
    """Refuse an arrangement of other faults than those that are truncated.

    Vertices may have moved where rounding broke one of the arrangements; rows have not.
    """
    given = {source.name: source for source in whole.sources if source.role == "fault"}
    for name in faults:
        one, two = patches.sources[patches.names.index(name)], given.get(name)
        if two is None or not np.array_equal(one.triangles, two.triangles):
            raise InputError(
                f"whole has {'another' if two else 'no'} fault {name!r}; give rebuild_surfaces of "
                "the same faults, without the walls."
            )


def _inside(patches: Patches) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the walls, and which triangles lie in the model; all of them without walls.

    An area of interest has a fence, see `inside_area`. Walls of a box have cut all triangles, and
    points on an axis-parallel wall are rounded onto it, so a triangle lies inside if its corners
    do.
    """
    wall = np.isin(
        patches.surface_of_triangle,
        [i for i, source in enumerate(patches.sources) if source.role == "wall"],
    )
    walls = np.flatnonzero(wall)
    if len(walls) == 0:
        return walls, np.ones(patches.n_triangle, dtype=bool)
    if any(source.role == "wall" and source.name == FENCE for source in patches.sources):
        return walls, inside_area(patches, walls)
    box = [s.vertices - patches.origin for s in patches.sources if s.role == "wall"]
    low, high = np.concatenate(box).min(axis=0), np.concatenate(box).max(axis=0)
    within = ((patches.local >= low) & (patches.local <= high)).all(axis=1)
    return walls, within[patches.triangles].all(axis=1)


def _hangs_on(gone: np.ndarray, held: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Which pieces outside the model box go on from pieces inside that stay, and from no other."""
    stays, goes = np.zeros(len(gone), dtype=bool), np.zeros(len(gone), dtype=bool)
    for a, b in (pairs.T, pairs[:, ::-1].T):
        inner = held[a] & ~held[b]
        stays[b[inner & ~gone[a]]] = True
        goes[b[inner & gone[a]]] = True
    return stays & ~goes


def _areas(patches: Patches, rows: np.ndarray) -> np.ndarray:
    corners = patches.local[patches.triangles[rows]]
    return 0.5 * np.linalg.norm(normals_of(corners), axis=1)


def _part(patches: Patches, name: str, alive: np.ndarray) -> tuple[TriSurface, np.ndarray]:
    """What is left of one fault: vertices sorted by place, triangles by vertices."""
    i = patches.names.index(name)
    rows = np.flatnonzero(alive & (patches.surface_of_triangle == i))
    used, t = np.unique(patches.triangles[rows], return_inverse=True)
    x = patches.vertices[used]
    order = np.lexsort(x.T[::-1])
    t = np.argsort(order)[t.reshape(-1, 3)]
    t = np.take_along_axis(t, (t.argmin(axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    line = np.lexsort(t.T[::-1])
    parent = patches.parent_of_triangle[rows][line]
    return TriSurface(name, "fault", x[order], t[line]), parent
