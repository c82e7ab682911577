"""Faults that end at horizons: an unconformity above them, a detachment below them.

Everything is split first, with whole faults. Then the triangles of a fault that lie on the other
side of the horizon are dropped, so that the fault ends exactly on their common curve. Sides are
those of the zones (`geosurf.carve.horizon_sides`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from geosurf.carve.horizon_sides import FaultSides, HorizonSides, horizon_sides, outside_of_model
from geosurf.conventions import length_text, place
from geosurf.errors import GeometryError, GeosurfWarning
from geosurf.faults.distance import closest_approach
from geosurf.faults.rules import Rule, part_in_words
from geosurf.model import Patches
from geosurf.model.faults import Truncation
from geosurf.rebuild import drop_triangles

Ends = tuple[Patches, tuple[Truncation, ...], tuple[GeosurfWarning, ...]]


def end_at_horizons(
    patches: Patches,
    column: Mapping[str, str],
    rules: Sequence[Rule],
    branches: Sequence[Rule] = (),
) -> Ends:
    """
    Drop the parts of faults beyond the horizons that they end at.

    Parameters
    ----------
    patches : Patches
        Of horizons, faults, fluid contacts and walls.
    column : mapping of str to str
        Rules of the horizons, as for `carve_units`.
    rules : sequence of Rule
        Each with a horizon as its main surface.
    branches : sequence of Rule
        Faults that end at faults, which may lose their main fault beyond a horizon.

    Returns
    -------
    patches : Patches
        Without these parts.
    truncations : tuple of Truncation
        In the order of the rules.
    warnings : tuple of GeosurfWarning
        Of faults that have lost their main fault.

    Raises
    ------
    GeometryError
        If a horizon does not cover a fault (with the place), a fault does not reach it (with the
        gap), has no part on the side that stays, or offsets it.
    """
    if not rules:
        return patches, (), ()
    sides = horizon_sides(patches, column)
    keep = np.ones(patches.n_triangle, dtype=bool)
    found: list[Truncation] = []
    for fault in dict.fromkeys(rule.fault for rule in rules):
        mine = [rule for rule in rules if rule.fault == fault]
        at = [_checked(sides, rule) for rule in mine]
        rows, inside = at[0].rows, at[0].inside

        # one rule after the other: each reports what the earlier ones have left
        left = np.ones(len(rows), dtype=bool)
        for rule, one in zip(mine, at, strict=True):
            stays = inside & ~(one.within | (one.above if rule.keep == "below" else one.below))
            stays |= outside_of_model(patches, one, stays, rule.main)
            found.append(_truncation(patches, rule, one, left, left & stays))
            left &= stays
        if not (left & inside).any():
            raise _nothing_left(patches, mine, rows[inside])
        keep[rows[~left]] = False
    lost = [_lost_main(patches, keep, branch, rules) for branch in branches]
    return drop_triangles(patches, keep), tuple(found), tuple(filter(None, lost))


def _lost_main(
    patches: Patches, keep: np.ndarray, branch: Rule, rules: Sequence[Rule]
) -> GeosurfWarning | None:
    """Warn of a fault that goes on where the fault that it ends at is gone."""
    of = patches.surface_of_triangle
    mine, main = (of == patches.names.index(name) for name in (branch.fault, branch.main))
    some = (mine & keep, main & keep, main & ~keep)
    edges, still, gone = (_edges(patches, np.flatnonzero(rows)) for rows in some)
    a, b = np.divmod(np.setdiff1d(np.intersect1d(edges, gone), still), len(patches.local))
    length = np.linalg.norm(patches.local[b] - patches.local[a], axis=1)
    if len(length) == 0:
        return None
    at = 0.5 * (patches.local[a] + patches.local[b])[length.argmax()] + patches.origin
    ends = [rule for rule in rules if rule.fault == branch.main]
    words = f"({branch.main!r}, {branch.keep!r}), ({ends[0].main!r}, {ends[0].keep!r})"
    return GeosurfWarning(
        "fault network",
        branch.fault,
        f"Fault {branch.fault!r} ends at {branch.main!r}, which ends at {ends[0].main!r}: "
        f"beyond that horizon {branch.fault!r} goes on and ends inside the model, on "
        f"{length_text(math.fsum(length))}.",
        f"Let it end at the horizon as well: truncations={{{branch.fault!r}: ({words})}}.",
        tuple(at),
    )


def _checked(sides: HorizonSides, rule: Rule) -> FaultSides:
    """Where a fault lies at a horizon, if each of its triangles lies on one side."""
    patches = sides.patches
    found = sides.of_fault(rule.fault, rule.main)
    names = (rule.fault, rule.main)
    if not found.inside.any():
        raise GeometryError(
            f"nothing of fault {rule.fault!r} lies in the model, so that it cannot end at horizon "
            f"{rule.main!r} there. Leave the rule out, or enlarge the box.",
            surfaces=names,
        )

    # around an open rim the horizon has no sides
    if found.unknown.any():
        doubt = patches.local[patches.triangles[found.rows[found.unknown]]].reshape(-1, 3)
        rim = sides.open_rim(rule.main, doubt)
        at = doubt.mean(axis=0) + patches.origin if rim is None else rim[1]
        where = "" if rim is None else f": {rim[0]:.6g} m of its rim are open inside the model"
        raise GeometryError(
            f"fault {rule.fault!r} cannot end at horizon {rule.main!r}, which does not cover all "
            f"of it{where}, nearest at {place(at)}. Continue the horizon: "
            f"extend_horizon(..., fill_holes=True); or shrink the box to it.",
            place=at,
            surfaces=names,
        )

    # a horizon that ends on the fault is offset by it
    offset = found.above & found.below & ~found.within
    if offset.any():
        at = _middle(patches, found.rows[offset])
        raise GeometryError(
            f"horizon {rule.main!r} is offset by fault {rule.fault!r} at {place(at)}, so that the "
            f"fault cannot end there. Give {rule.main!r} as it is where {rule.fault!r} does not "
            "cut it, or leave the rule out.",
            place=at,
            surfaces=names,
        )
    beyond = found.above if rule.keep == "below" else found.below
    if not (beyond | found.within).any() and not _meets(patches, rule, found.rows):
        raise _too_short(patches, rule, found)
    return found


def _meets(patches: Patches, rule: Rule, rows: np.ndarray) -> bool:
    """Whether a fault has a vertex in common with a horizon."""
    other = patches.surface_of_triangle == patches.names.index(rule.main)
    return bool(np.isin(patches.triangles[rows], patches.triangles[other]).any())


def _too_short(patches: Patches, rule: Rule, found: FaultSides) -> GeometryError:
    """State how far a fault stays off the horizon that it is to end at, and where."""
    other = np.flatnonzero(patches.surface_of_triangle == patches.names.index(rule.main))
    mine = patches.triangles[found.rows[found.inside]]
    gap = closest_approach(patches.local, mine, patches.triangles[other])
    at = gap.at + patches.origin
    remedy = (
        "Leave the rule out: it does not reach the horizon, even extended."
        if rule.extend
        else f"Extend it: truncations={{{rule.fault!r}: ({rule.main!r}, {rule.keep!r}, True)}}; or "
        "leave the rule out."
    )
    return GeometryError(
        f"fault {rule.fault!r} ends {gap.distance:.6g} m short of horizon {rule.main!r}, nearest "
        f"at {place(at)}, and cannot end there. {remedy}",
        place=at,
        surfaces=(rule.fault, rule.main),
    )


def _nothing_left(patches: Patches, rules: Sequence[Rule], rows: np.ndarray) -> GeometryError:
    """State that a fault has no part where it is to stay."""
    at = _middle(patches, rows)
    where = " and ".join(part_in_words(rule) for rule in rules)
    fault = rules[0].fault
    return GeometryError(
        f"fault {fault!r} has no part {where}: nothing would be left of it. It lies around "
        f"{place(at)}; keep the other part, or leave the fault out.",
        place=at,
        surfaces=(fault, *(rule.main for rule in rules)),
    )


def _middle(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """The middle of the largest of some triangles."""
    largest = rows[_areas(patches, rows).argmax()]
    middle: np.ndarray = patches.local[patches.triangles[largest]].mean(axis=0) + patches.origin
    return middle


def _truncation(
    patches: Patches, rule: Rule, found: FaultSides, before: np.ndarray, after: np.ndarray
) -> Truncation:
    """Areas of a fault that one rule keeps and drops, and the length of its new end."""
    area = _areas(patches, found.rows)
    gone = before & ~after

    # it ends where something is gone, or where its rim lay on the horizon already
    edges, times = np.unique(_edges(patches, found.rows[after]), return_counts=True)
    main = np.flatnonzero(patches.surface_of_triangle == patches.names.index(rule.main))
    main = main[np.isin(patches.triangles[main], patches.triangles[found.rows]).sum(axis=1) > 1]
    ends = edges[(times == 1) & np.isin(edges, _edges(patches, main))]
    left, lost = (_edges(patches, found.rows[some & found.inside]) for some in (after, gone))
    ends = np.union1d(np.intersect1d(ends, left), np.intersect1d(left, lost))
    a, b = np.divmod(ends, len(patches.local))
    return Truncation(
        rule.fault,
        rule.main,
        rule.keep,
        "-" if rule.keep == "below" else "+",
        kept_area=math.fsum(area[after]),
        dropped_area=math.fsum(area[gone]),
        coinciding_area=math.fsum(area[gone & found.within]),
        apart_area=0.0,
        length=math.fsum(np.linalg.norm(patches.local[b] - patches.local[a], axis=1)),
    )


def _edges(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """The edges of some triangles as one number each, (3 n,)."""
    t = patches.triangles[rows]
    ends = np.stack([t, np.roll(t, -1, axis=1)], axis=2)
    keys: np.ndarray = ends.min(axis=2) * len(patches.local) + ends.max(axis=2)
    return keys.ravel()


def _areas(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """Area of some triangles [m2]."""
    a, b, c = (patches.local[patches.triangles[rows, k]] for k in range(3))
    areas: np.ndarray = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return areas


__all__ = ["Ends", "end_at_horizons"]
