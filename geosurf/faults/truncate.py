"""Faults that end at faults: which parts stay is decided in one exact arrangement.

All faults concerned are split along their common curves first, in one mesh. A truncation
then drops whole pieces of it, so that what stays shares vertices with the main fault, and parts
add up. Main faults come first, and others end at what is left of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from geosurf.conventions import area_text, place
from geosurf.errors import GeometryError, GeosurfWarning, InputError
from geosurf.faults.dangling import areas_of, edge_keys, rows_of
from geosurf.faults.distance import closest_approach, open_edges
from geosurf.faults.rules import LEVELS, Rule, part_in_words, read_truncations
from geosurf.faults.sides import Adjacency, adjacency
from geosurf.model import Patches, TriSurface
from geosurf.model.base import any_of
from geosurf.model.expected import expect
from geosurf.model.network import TruncatedFaults, Truncation
from geosurf.model.surfaces import cutoffs_kept

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
        fault goes on around the end of its main fault outside, it is cut off at the box. Faults
        that meet outside only are truncated there, as `whole` has them.
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
    applied = [step for step, *_ in steps]
    missed = next((error for *_, error in steps if error is not None), None)
    walled = any(source.role == "wall" for source in patches.sources)
    if callable(whole):
        whole = whole()
    if whole is not None:
        _refuse_others(patches, whole, faults)
        uncut = _without_walls(patches, whole, rules, steps)
        if uncut is not None:
            patches, (alive, applied), walled, missed = whole, uncut, False, None
    if missed is not None:
        raise missed
    surfaces, parents = {}, {}
    for name in sorted(faults):
        surfaces[name], parents[name] = _part(patches, name, alive)
    move = float(patches.report.get("largest_move", 0.0))
    return TruncatedFaults(surfaces, parents, tuple(applied), move, walled)


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


def past_mains(
    patches: Patches, rules: Mapping[Rule, str]
) -> tuple[np.ndarray, tuple[Truncation, ...], tuple[GeosurfWarning, ...]]:
    """
    Find what tears have added to faults beyond the faults that they end at, and what of it can go.

    What a horizon ends on stays, since the horizon would be open there; and what goes on around
    the end of the main fault.

    Parameters
    ----------
    patches : Patches
        Of the model, with the longer faults.
    rules : mapping of Rule to str
        By rule, how to lengthen its faults before it is applied.

    Returns
    -------
    keep : ndarray of bool, shape (n_triangle,)
        False for what goes.
    truncations : tuple of Truncation
        Of each fault that loses a part.
    warnings : tuple of GeosurfWarning
        Of each fault that still passes its main fault, with the area.
    """
    alive = np.ones(patches.n_triangle, dtype=bool)
    truncations, warnings = [], []
    for rule, how in rules.items():
        rows = _rows(patches, alive, rule)
        fault_rows = rows[rule.fault]
        beside = adjacency(patches, fault_rows, rows[rule.main], strict=False)
        front = main_side(patches.sources[patches.names.index(rule.main)], rule.keep) > 0
        wanted, unwanted = beside.beside.T if front else beside.beside[:, ::-1].T
        beyond = (unwanted & ~wanted)[beside.piece]
        ending = _ending_on(patches, fault_rows[beyond])
        held = np.zeros(len(wanted), dtype=bool)
        held[beside.piece[beyond][ending]] = True
        dropped, stays = beyond & ~held[beside.piece], beyond & held[beside.piece]
        alive[fault_rows[dropped]] = False
        if dropped.any():
            words = rule.fault, rule.main, rule.keep, "+" if front else "-"
            truncations.append(
                Truncation(*words, apart_area=0.0, **_sizes(patches, fault_rows, beside, dropped))
            )
        if stays.any():
            area = math.fsum(areas_of(patches, fault_rows[stays]))
            warnings.append(
                GeosurfWarning(
                    "fault passes another",
                    rule.fault,
                    f"Fault {rule.fault!r} ends at {rule.main!r} by its rule, but a horizon that "
                    f"is torn there needed longer faults, and ends beyond {rule.main!r}: "
                    f"{area_text(area)} of {rule.fault!r} stay there.",
                    f"Lengthen them yourself, so that the rule cuts what you add: {how}.",
                )
            )
    return alive, tuple(truncations), tuple(warnings)


def _ending_on(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """Which triangles of a fault have an edge on which a horizon ends, bool (n,)."""
    keys = edge_keys(patches, rows)
    on_fault = np.zeros(len(patches.local), dtype=bool)
    on_fault[patches.triangles[rows]] = True
    ends = [np.empty(0, dtype=np.int64)]
    for name in (one.name for one in patches.sources if one.role == "horizon"):
        near = rows_of(patches, name)
        near = near[on_fault[patches.triangles[near]].sum(axis=1) > 1]
        edges, times = np.unique(edge_keys(patches, near), return_counts=True)
        ends.append(edges[times == 1])
    return any_of(np.isin(keys, np.concatenate(ends)))


def _rows(patches: Patches, alive: np.ndarray, rule: Rule) -> dict[str, np.ndarray]:
    """What is left of the two faults of a rule, by name."""
    return {
        name: np.flatnonzero(alive & (patches.surface_of_triangle == patches.names.index(name)))
        for name in (rule.fault, rule.main)
    }


def _truncate(
    patches: Patches, alive: np.ndarray, rule: Rule
) -> tuple[Truncation, np.ndarray, Exception | None]:
    """Drop what one rule drops from `alive`.

    Returns that, what stays although it does not meet the main fault, and an error if they meet
    outside of the box only: there the faults without walls decide.
    """
    rows = _rows(patches, alive, rule)
    main = patches.sources[patches.names.index(rule.main)]
    side = main_side(main, rule.keep)
    fault_rows = rows[rule.fault]

    # pieces that the main fault and the walls cut off, and on which side of it each one lies
    walls, inside = _inside(patches)
    beside = adjacency(patches, fault_rows, rows[rule.main], walls)
    held = np.zeros(len(beside.within), dtype=bool)
    held[beside.piece[inside[fault_rows]]] = True
    wanted = beside.beside[:, 0 if side > 0 else 1] & held
    unwanted = beside.beside[:, 1 if side > 0 else 0] & held

    # only where every piece has one side can a part be dropped
    if (wanted & unwanted).any():
        raise goes_around(patches, rule, beside, fault_rows)
    missed = None
    if not (wanted | unwanted).any():
        missed = not_reached(patches, rule, rows, inside)
        if not beside.beside.any():
            raise missed
    elif not wanted.any():
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
    apart = ~(wanted | gone)[beside.piece] & inside[fault_rows] & (missed is None)
    alive[fault_rows[dropped]] = False

    sizes = _sizes(patches, fault_rows, beside, dropped)
    off = math.fsum(areas_of(patches, fault_rows[apart]))
    words = rule.fault, rule.main, rule.keep, "+" if side > 0 else "-"
    return Truncation(*words, apart_area=off, **sizes), fault_rows[apart], missed


def _sizes(
    patches: Patches, fault_rows: np.ndarray, beside: Adjacency, dropped: np.ndarray
) -> dict[str, Any]:
    """Remaining and dropped areas of a fault's rows, and the length of the line that it ends on."""
    area = areas_of(patches, fault_rows)
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
    steps: list[tuple[Truncation, np.ndarray, Exception | None]],
) -> tuple[np.ndarray, list[Truncation]] | None:
    """Drop the same from faults that no wall has cut; None where a fault has to end at the box.

    A piece of a fault without walls is one or more pieces with them. All of it is on one side
    of its main fault, or it goes around it beyond the box; and what stays in the box because
    nothing of it meets the main fault there must not be dropped for what it meets outside.
    """
    alive, truncations = np.ones(whole.n_triangle, dtype=bool), []
    for rule, (step, apart, _) in zip(rules, steps, strict=True):
        rows = _rows(whole, alive, rule)
        fault_rows = rows[rule.fault]
        beside = adjacency(whole, fault_rows, rows[rule.main], strict=False)
        right, wrong = beside.beside.T if step.side == "+" else beside.beside[:, ::-1].T
        dropped = (wrong | beside.within)[beside.piece]
        stays = np.isin(whole.parent_of_triangle[fault_rows], patches.parent_of_triangle[apart])
        if (right & wrong).any() or not right.any() or (dropped & stays).any():
            return None
        alive[fault_rows[dropped]] = False
        truncations.append(replace(step, **_sizes(whole, fault_rows, beside, dropped)))
    return alive, truncations


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
    marks = cutoffs_kept(patches.sources[i], x[order])
    return TriSurface(name, "fault", x[order], t[line], vertex_data=marks), parent


FRONT, BACK = 0, 1


def inside_area(patches: Patches, walls: np.ndarray) -> np.ndarray:
    """
    Find the triangles that lie inside the walls of a model.

    Parameters
    ----------
    patches : Patches
        Surfaces and the walls that have cut them.
    walls : ndarray of int64
        Rows of the walls' triangles: closed, normals out of the model.

    Returns
    -------
    ndarray of bool, shape (n_triangle,)
        False for the walls, and for triangles that lie in one.

    Raises
    ------
    GeometryError
        If a piece goes through the walls without being cut.

    Examples
    --------
    >>> from geosurf import TriSurface, build_walls, rebuild_surfaces
    >>> corners = [[-1, 1, -3], [9, 1, -3], [9, 1, 3], [-1, 1, 3]]
    >>> fault = TriSurface("F1", "fault", corners, [[0, 1, 2], [0, 2, 3]])
    >>> ring = [(0, 0), (4, 0), (4, 4), (0, 4)]
    >>> patches = rebuild_surfaces([fault, *build_walls((0, 4, 0, 4, -2, 2), ring)])
    >>> walls = np.flatnonzero(patches.surface_of_triangle > 0)
    >>> found = patches.triangles[inside_area(patches, walls)]
    >>> east = patches.vertices[found][:, :, 0]
    >>> float(east.min()), float(east.max())
    (0.0, 4.0)
    """
    # surfaces one at a time: pieces of one do not touch pieces of another
    inside = np.zeros(patches.n_triangle, dtype=bool)
    is_wall = np.zeros(patches.n_triangle, dtype=bool)
    is_wall[walls] = True
    for i in range(len(patches.sources)):
        rows = np.flatnonzero((patches.surface_of_triangle == i) & ~is_wall)
        if len(rows):
            inside[rows] = _of_one(patches, rows, walls)
    return inside


def _of_one(patches: Patches, rows: np.ndarray, walls: np.ndarray) -> np.ndarray:
    """Which triangles of one surface lie inside, bool (n,)."""
    # (n_piece, 2): whether a piece meets the front and the back of a wall; normals of walls point
    # out, so inside is behind
    beside = adjacency(patches, rows, walls, strict=False)
    held = beside.beside[:, BACK] & ~beside.within
    odd = np.flatnonzero(held & beside.beside[:, FRONT])
    if len(odd):
        at = patches.triangles[rows[np.flatnonzero(beside.piece == odd[0])[0]], 0]
        where = patches.vertices[at]
        name = patches.names[int(patches.surface_of_triangle[rows[0]])]
        raise GeometryError(
            f"fault {name!r} lies inside and outside of the area of interest at once, near "
            f"{place(where)}: its walls are not closed there. Give all that build_walls returns.",
            place=tuple(where.tolist()), surfaces=(name,),
        )  # fmt: skip

    # pieces that no wall cuts are inside or outside as a whole: one vertex decides
    alone = ~beside.beside.any(axis=1) & ~beside.within
    for piece in np.flatnonzero(alone).tolist():
        first = rows[np.flatnonzero(beside.piece == piece)[0]]
        held[piece] = _holds(patches, walls, patches.local[patches.triangles[first, 0]])
    return held[beside.piece]


def _holds(patches: Patches, walls: np.ndarray, point: np.ndarray) -> bool:
    """Whether a point that is on no wall lies inside: by the sides of the area north of it."""
    x = patches.local
    used = x[patches.triangles[walls]].reshape(-1, 3)

    # strictly between bottom and top: a piece on no wall cannot lie in them
    if not used[:, 2].min() < point[2] < used[:, 2].max():
        return False

    # triangles of the bottom, whose open edges are the outline of the area in the map
    level = walls[(x[patches.triangles[walls], 2] == used[:, 2].min()).all(axis=1)]
    rim = open_edges(patches.triangles[level], len(x))

    # crossing parity along a ray to the north, in fractions: no rounding near the outline.
    # Half-open in easting, so that a corner counts for one of its two edges
    px, py = Fraction(float(point[0])), Fraction(float(point[1]))
    count = 0
    for a, b in x[rim][:, :, :2].tolist():
        (ax, ay), (bx, by) = sorted(map(tuple, (a, b)))
        if ax <= point[0] < bx:
            ax, ay, bx, by = map(Fraction, (ax, ay, bx, by))
            count += ay + (by - ay) * (px - ax) / (bx - ax) > py
    return count % 2 == 1


def goes_around(
    patches: Patches, rule: Rule, beside: Adjacency, fault_rows: np.ndarray
) -> Exception:
    """Describe where the curve ends inside the truncated fault."""
    used, times = np.unique(beside.edges, return_counts=True)
    rim = np.unique(open_edges(patches.triangles[fault_rows], len(patches.local)))
    tips = np.setdiff1d(used[times == 1], rim)
    at = patches.vertices[tips[0] if len(tips) else used[0]]
    return GeometryError(
        f"fault {rule.main!r} does not cut {rule.fault!r} through: {rule.fault!r} goes on around "
        f"the end of {rule.main!r} at {place(at)}, so that no part can be dropped. Extend "
        f"{rule.main!r}.",
        place=at,
        surfaces=(rule.fault, rule.main),
    )


def not_reached(
    patches: Patches, rule: Rule, rows: Mapping[str, np.ndarray], inside: np.ndarray
) -> Exception:
    """Describe how far a fault stays off its main one in the model box, and where."""
    for name in (rule.fault, rule.main):
        if not inside[rows[name]].any():
            x = patches.vertices[patches.triangles[rows[name]]].reshape(-1, 3)
            (w, s, b), (e, n, t) = x.min(axis=0), x.max(axis=0)
            return GeometryError(
                f"nothing of fault {name!r} (easting {w:.6g} to {e:.6g}, northing {s:.7g} to "
                f"{n:.7g}, elevation {b:.6g} to {t:.6g}) lies in the model box, so that "
                f"{rule.fault!r} cannot end at {rule.main!r} there. Leave the rule out, enlarge "
                "the box, or check positive= and length_unit= of the fault.",
                surfaces=(rule.fault, rule.main),
            )
    one, two = (patches.triangles[r[inside[r]]] for r in (rows[rule.fault], rows[rule.main]))
    gap = closest_approach(patches.local, one, two)
    at = gap.at + patches.origin
    where = f"nearest at {place(at)}"
    if gap.distance == 0:
        return GeometryError(
            f"fault {rule.fault!r} only touches {rule.main!r}, {where}, and cannot end there. "
            "Leave the rule out, or keep another part of one of them.",
            place=at,
            surfaces=(rule.fault, rule.main),
        )
    remedy = (
        "Leave the rule out: they do not meet, even extended."
        if rule.extend
        else f"Extend it to {rule.main!r}: "
        f"truncations={{{rule.fault!r}: ({rule.main!r}, {rule.keep!r}, True)}}."
    )
    return GeometryError(
        f"fault {rule.fault!r} ends {gap.distance:.6g} m short of {rule.main!r}, {where}, and "
        f"cannot end there. {remedy}",
        place=at,
        surfaces=(rule.fault, rule.main),
    )
