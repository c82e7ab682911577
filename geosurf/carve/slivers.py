"""Merge slivers into their neighbours: which unit each of them becomes a part of.

Units are the nodes of a graph, and the area that two of them share is the weight of the edge. A
sliver goes to the neighbour with the largest shared area among those that are not slivers. One that
touches only slivers waits until some of these have gone, and follows them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.carve.clipped import Clips
from geosurf.carve.measures import AREA
from geosurf.carve.zones import DIGITS, in_words
from geosurf.conventions import volume_text
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model import Units
from geosurf.model.column import CONFORMABLE

Faces = dict[tuple[int, int], list[int]]


def faces_between_units(sides: np.ndarray) -> Faces:
    """Rows of the faces between each pair of units, lower number first.

    Parameters
    ----------
    sides : ndarray of int64, shape (n, 2)
        Unit in front of and behind each face; -1 outside.

    Examples
    --------
    >>> faces_between_units(np.array([[1, 0], [0, 0], [-1, 1], [0, 1]]))
    {(0, 1): [0, 3]}
    """
    found: Faces = {}
    inner = (sides >= 0).all(axis=1) & (sides[:, 0] != sides[:, 1])
    for row in np.flatnonzero(inner).tolist():
        one, two = sorted(sides[row].tolist())
        found.setdefault((one, two), []).append(row)
    return found


def homes_of_slivers(
    faces: Faces, area: np.ndarray, n_unit: int, small: Collection[int], order: Sequence[int]
) -> list[int]:
    """
    Unit that each unit becomes a part of; others stay their own.

    Parameters
    ----------
    faces : dict
        See `faces_between_units`.
    area : ndarray of float64, shape (n_face, k)
        Area of each face, as numbers to be added [m2].
    n_unit : int
    small : collection of int
        The slivers.
    order : sequence of int
        All units by name; of equal areas the first counts. Areas that agree to nine digits are
        equal, so that rounding does not decide.

    Returns
    -------
    list of int
        A sliver that no way leads from to any other unit stays its own.

    Examples
    --------
    Unit 1 touches 0 and 2; unit 2, a sliver as well, touches only 1:

    >>> homes_of_slivers({(0, 1): [0], (1, 2): [1]}, np.array([[4.0], [9.0]]), 3, {1, 2}, range(3))
    [0, 0, 0]
    """
    home = list(range(n_unit))
    rank = {u: k for k, u in enumerate(order)}
    left = set(small)
    while left:
        # faces of each sliver that is left with what is no sliver, or is a part of such a unit
        around: dict[int, dict[int, list[int]]] = {u: {} for u in left}
        for pair, rows in faces.items():
            for u, v in (pair, pair[::-1]):
                if u in left and home[v] not in left:
                    around[u].setdefault(home[v], []).extend(rows)

        # all at once: the order of slivers does not matter
        moves = {}
        for u, beside in around.items():
            if beside:
                shared = {v: _sum(area[rows]) for v, rows in beside.items()}
                moves[u] = min(shared, key=lambda v: (-shared[v], rank[v]))
        if not moves:
            break
        for u, v in moves.items():
            home[u] = v
        left -= set(moves)
    return home


def _sum(area: np.ndarray) -> float:
    """A sum of areas, to nine digits."""
    return float(f"{math.fsum(area.ravel().tolist()):.{DIGITS}g}")


def shared_faces(faces: Faces, home: Sequence[int]) -> dict[int, list[int]]:
    """Rows of the faces between each unit and the other parts of the unit that it is a part of.

    Examples
    --------
    >>> shared_faces({(0, 1): [0, 3], (1, 2): [4]}, [0, 0, 2])
    {0: [0, 3], 1: [0, 3]}
    """
    found: dict[int, list[int]] = {}
    for pair, rows in faces.items():
        if home[pair[0]] == home[pair[1]]:
            for u in pair:
                found.setdefault(u, []).extend(rows)
    return found


def surfaces_of(cells: Cells, faces: Sequence[int]) -> tuple[str, ...]:
    """Names of the surfaces that own some faces, sorted."""
    found = {int(cells.surface_of[row]) for row in faces}
    found |= {other for row in faces for other, _ in cells.also.get(row, ())}
    return tuple(sorted((cells.patches.names[i] for i in found), key=in_words))


def shared_area(cells: Cells, faces: Sequence[int]) -> float:
    """Area of some faces [m2]."""
    return math.fsum(cells.extent[np.array(faces, dtype=np.int64), AREA].ravel().tolist())


def refuse_all_slivers(units: Units) -> None:
    """Raise an error if every unit is a sliver, so that none can take them."""
    if len(units) and len(units.slivers) == len(units):
        largest = units.slivers[0]
        raise InputError(
            f"slivers: all {len(units)} units are {units.sliver_settings.rule}, so none can take "
            f"the others. The largest, {largest.name!r}, has {volume_text(largest.volume)}; give a "
            "smaller min_volume."
        )


def warnings_of_slivers(units: Units) -> tuple[GeosurfWarning, ...]:
    """
    Return a warning if slivers were to be merged, and no other unit touches them.

    Parameters
    ----------
    units : Units

    Returns
    -------
    tuple of GeosurfWarning
        At most one, with the place of the largest sliver.
    """
    if not units.sliver_settings.merge or not units.slivers:  # slivers have places: not for nothing
        return ()
    n, largest = len(units.slivers), units.slivers[0]
    total = volume_text(math.fsum(one.volume for one in units.slivers))
    what = f"{n} slivers are" if n > 1 else "One sliver is"
    warning = GeosurfWarning(
        "sliver",
        largest.name,
        f"{what} not merged, since only slivers touch {'them' if n > 1 else 'it'}: {total}, the "
        f"largest {largest.name!r}.",
        "Set a smaller limit in m³, as in slivers={'min_volume': 5000.0, 'merge': True}.",
        largest.place,
    )
    return (warning,)


# ---- thin ----------------------------------------
# Warn of units thinner than the rounding error: surfaces that almost coincide.


def warnings_of_thin_units(units: Units) -> tuple[GeosurfWarning, ...]:
    """
    Return a warning if units are thinner than the rounding error of coordinates.

    Parameters
    ----------
    units : Units

    Returns
    -------
    tuple of GeosurfWarning
        At most one, with the place of the largest thin unit.
    """
    thin = units.report.get("thin", ())
    if not thin:
        return ()
    largest = max(thin, key=lambda unit: unit.volume)
    surfaces = ", ".join(repr(name) for name in units[largest.name].bounded_by)
    what = f"Unit {largest.name!r} is"
    if len(thin) > 1:
        what = f"{len(thin)} units, of which {largest.name!r} is the largest, are"
    warning = GeosurfWarning(
        "thin unit",
        largest.name,
        f"{what} thinner than the rounding error of coordinates ({largest.volume:.1e} "
        f"m³): {surfaces} almost coincide there.",
        "Ignore such units (units.report['thin'] lists them), or round the coordinates "
        "of these surfaces and of the box: np.round(x * 1024) / 1024.",
        largest.place,
    )
    return (warning,)


# ---- order ----------------------------------------
# Warn of horizons in the wrong order: an older one above a younger one nearly everywhere.


_MOST = 0.5  # fraction of the map; smaller crossings are only listed in the report


def warnings_of_order(units: Units) -> Iterator[GeosurfWarning]:
    """
    Yield a warning for each pair of conformable horizons with the older one mostly above.

    Pairs with a rule of the column are skipped: the rule states which horizon removes the other.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=5)
    >>> turned_over = dict(reversed(world.horizons.items()))
    >>> surfaces = [gs.triangulate_horizon(h, name=n) for n, h in turned_over.items()]
    >>> patches = gs.rebuild_surfaces([*surfaces, *gs.build_walls(world.box)])
    >>> (found,) = warnings_of_order(gs.carve_units(patches))
    >>> found.kind, found.subject, found.effect[:37]
    ('order', 'Top', "Horizon 'Top' lies above the younger ")
    """
    clips = units.report.get("clipped", ())
    # areas of faces decide whether it is worth to measure what is clipped, with room for rounding
    if isinstance(clips, Clips):
        least = 0.99 * _MOST * units.footprint
        if max(clips.areas(CONFORMABLE), default=0.0) < least:
            return
    for clip in clips:
        share = min(clip.area / units.footprint, 1.0)
        if clip.rule != CONFORMABLE or share < _MOST:
            continue
        where = "everywhere" if share > 0.995 else f"on {100 * share:.0f} % of the area"
        yield GeosurfWarning(
            "order",
            clip.horizon,
            f"Horizon {clip.horizon!r} lies above the younger horizon {clip.by!r} {where}: "
            f"{volume_text(clip.volume)} between them is clipped.",
            "List horizons from the youngest to the oldest. If the values are depths, pass "
            f"positive='down'. If {clip.by!r} erodes {clip.horizon!r}, pass "
            f"column={{{clip.by!r}: 'erosional'}}.",
            clip.place,
        )
