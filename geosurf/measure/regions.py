"""Find the regions that names stand for: by a place, a polygon, or sides of faults."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.conventions import check_name, place
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import rim_edges
from geosurf.measure.closures import area_in_map, clipped
from geosurf.measure.faces import faces_of
from geosurf.measure.locate import boundaries_of, locator_of
from geosurf.measure.places import well_intervals
from geosurf.model import Patches, Unit, Units
from geosurf.model.regions import Proposal, opposite


def regions_by_name(
    patches: Patches, units: Units, proposals: Sequence[Proposal], given: Mapping[str, Any]
) -> dict[int, str]:
    """
    Return the names of proposed regions.

    Parameters
    ----------
    patches, units : Patches, Units
    proposals : sequence of Proposal
    given : mapping of str to (float, float), ndarray of float64 (n, 2), or tuple of str
        A place names the region that a vertical line there is in for longest; a polygon names all
        regions that have more than half of their horizon area in it; sides of faults those with
        more horizon area on all of them than on an opposite one.

    Returns
    -------
    dict of int to str
        Names by row of `proposals`.

    Raises
    ------
    InputError
        If a name stands for no region, or two names stand for one: names split nothing.
    """
    ask = _Asked(patches, units, _rows_of_units(units, proposals), len(proposals))
    names: dict[int, str] = {}
    for name, value in given.items():
        if isinstance(value, np.ndarray):
            rows, where = ask.in_polygon(value), "in the polygon"
        elif isinstance(value[0], str):
            rows, where = ask.on_sides(value), f"on {' and '.join(value)}"
        else:
            rows, where = ask.at(value), f"at {place(value)}"
        if not rows:
            raise InputError(
                f"regions: no region is {where}, which {name!r} names. Regions follow faults and "
                "lie between the first and the last horizon; leave it out to see them: "
                "print(scene.regions)."
            )
        for k in rows:
            if k in names:
                raise InputError(
                    f"regions: {names[k]!r} and {name!r} name one region, with "
                    f"{_blocks(proposals[k])}: no fault parts them, and names split nothing. Leave "
                    "one out, or continue a fault between them: compartments=['F1']."
                )
            names[k] = name
    return names


def region_labels(patches: Patches, units: Units, horizon: str) -> dict[str, np.ndarray]:
    """
    Return a place on a horizon for the name of each region below it, float64 (1, 3).

    The middle of the triangle that is farthest from the rim of the region there.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.graben(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> places = region_labels(scene.patches, scene.units, "Top")
    >>> {name: place.round().tolist()[0][:2] for name, place in places.items()}
    {'A': [2292.0, 1167.0], 'B': [833.0, 2833.0], 'C': [4167.0, 3167.0]}
    """
    from scipy.spatial import KDTree

    faces = faces_of(patches, units, horizon, "horizon")
    down = area_in_map(faces.x, faces.triangles) < 0.0
    below = faces.sides[np.arange(len(down)), np.where(down, 0, 1)]
    names = np.array([*(unit.region for unit in units.values()), ""], dtype=object)[below]
    labels = {}
    for name in units.regions:
        t = faces.triangles[names == name]
        if len(t):
            ends = rim_edges(t)
            middles = faces.x[t].mean(axis=1)
            rim = np.concatenate([faces.x[ends[:, 0]], faces.x[ends].mean(axis=1)])
            away = KDTree(rim[:, :2]).query(middles[:, :2])[0]
            labels[name] = middles[[int(np.argmax(away))]] + faces.origin
    return labels


N_FOOT, N_LEVEL = 64, 32  # along each side of a map, and from bottom to top


def _rows_of_units(units: Units, proposals: Sequence[Proposal]) -> np.ndarray:
    """The proposal that each unit is of, -1 for none; the last one is for the outside."""
    row = {block: k for k, proposal in enumerate(proposals) for block in proposal.blocks}
    return np.array([*(row.get((unit.zone, unit.block), -1) for unit in units.values()), -1])


def region_map(units: Units, proposals: Sequence[Proposal], box: tuple[float, ...]) -> np.ndarray:
    """
    Return the region at 64 x 64 places all over a box in the map, at 32 levels each.

    It compares regions of two models, and decides nothing but which of them have one name.

    Parameters
    ----------
    units : Units
    proposals : sequence of Proposal
    box : tuple of float
        West, east, south, north, bottom, top [m].

    Returns
    -------
    ndarray of int16, shape (4096, 32)
        Rows of `proposals`, -1 for none.
    """
    region = _rows_of_units(units, proposals)
    share = (np.arange(N_FOOT) + 0.5) / N_FOOT
    east, north = (low + share * (high - low) for low, high in (box[:2], box[2:4]))
    feet = np.stack(np.meshgrid(east, north), axis=2).reshape(-1, 2)
    levels = box[4] + (np.arange(N_LEVEL) + 0.5) / N_LEVEL * (box[5] - box[4])
    return region[locator_of(units).find_on_lines(feet, levels)].astype(np.int16)


def overlap(first: np.ndarray, second: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """How much each region of one map has in common with each of another, as a rank.

    Places in the map count, each for the thickest region there; where these are as many, as for a
    region that lies below another one everywhere, places in space.

    Examples
    --------
    >>> one = np.array([[0, 0, 1], [0, 1, 1], [-1, -1, -1]])
    >>> overlap(one, np.where(one < 0, -1, 1 - one), (2, 2)).tolist()
    [[0, 13], [13, 0]]
    """
    on_map = _in_common(_thickest(first, size[0]), _thickest(second, size[1]), size)
    return (first.size + 1) * on_map + _in_common(first.ravel(), second.ravel(), size)


def _thickest(found: np.ndarray, n: int) -> np.ndarray:
    """Of the regions at the levels of each place the one at most of them; -1 without any."""
    count = np.stack([(found == k).sum(axis=1) for k in range(n)], axis=1)
    return np.where(count.any(axis=1), count.argmax(axis=1), -1)


def _in_common(first: np.ndarray, second: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Number of places that have row i in one list and row j in the other."""
    both = (first >= 0) & (second >= 0)
    code = first[both].astype(np.int64) * size[1] + second[both]
    return np.bincount(code, minlength=size[0] * size[1]).reshape(size)


def _blocks(proposal: Proposal) -> str:
    return ", ".join(f"{zone} {block}" for zone, block in proposal.blocks)


class _Asked:
    """Places, polygons and sides of faults that a model is asked about.

    Parameters
    ----------
    patches, units : Patches, Units
    region : ndarray of int64, shape (n_unit + 1,)
        Row of the region of each unit, -1 for none.
    n : int
        Number of regions.
    """

    def __init__(self, patches: Patches, units: Units, region: np.ndarray, n: int) -> None:
        self.patches, self.units, self.region, self.n = patches, units, region, n

    def at(self, spot: tuple[float, float]) -> list[int]:
        """The region that a vertical line is in for longest."""
        line = [[*spot, self.units.box[5]], [*spot, self.units.box[4]]]
        tools = locator_of(self.units), boundaries_of(self.patches, self.units)
        passed = well_intervals(self.units, line, None, *tools)
        number = dict(zip(self.units, self.region.tolist(), strict=False))
        length = [0.0] * self.n
        for unit, (upper, lower) in zip(
            passed.unit.values.tolist(), passed.elevation.values.tolist(), strict=True
        ):
            if number.get(unit, -1) >= 0:
                length[number[unit]] += upper - lower
        longest = max(length, default=0.0)
        return [length.index(longest)] if longest > 0.0 else []

    def on_sides(self, sides: tuple[str, ...]) -> list[int]:
        """Regions with more horizon area on all of some sides of faults than on opposite ones."""
        listed = list(self.units.values())
        known = list(dict.fromkeys(side for unit in listed for side in unit.fault_sides))
        for side in sides:
            check_name(side, known, f"regions: no unit is on {side!r}. The sides of faults are")

        def lies(unit: Unit) -> float:
            """1 on all sides, -1 on an opposite one, 0 elsewhere."""
            if set(sides) <= set(unit.fault_sides):
                return 1.0
            return -float(any(opposite(side) in unit.fault_sides for side in sides))

        sign = np.array([*map(lies, listed), 0.0])
        more = self._sum(lambda x, t, beside: area_in_map(x, t) * sign[beside])
        return [k for k, of in enumerate(more) if of > 0.0]

    def in_polygon(self, ring: np.ndarray) -> list[int]:
        """Regions with more than half of their horizon area in a polygon."""
        ring = ring - self.patches.origin[:2]
        whole = self._sum(lambda x, t, _: area_in_map(x, t))
        inside = self._sum(lambda x, t, _: np.array([area_inside(x, t, ring)]))
        return [k for k in range(self.n) if inside[k] > 0.5 * whole[k]]

    def _sum(
        self, measure: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
    ) -> list[float]:
        """The sum over all horizons of a measure of the triangles at each region, in the map."""
        parts: list[list[float]] = [[] for _ in range(self.n)]
        for i in sorted(self.units.rows_inside):
            source = self.patches.sources[i]
            if source.role != "horizon":
                continue
            faces = faces_of(self.patches, self.units, source.name, "horizon")
            x, t = faces.x, faces.triangles
            down = area_in_map(x, t) < 0.0
            t = np.where(down[:, None], t[:, ::-1], t)
            for side in range(2):
                region = self.region[faces.sides[:, side]]
                for k in np.unique(region[region >= 0]).tolist():
                    rows = region == k
                    parts[k] += measure(x, t[rows], faces.sides[rows, side]).tolist()
        return [math.fsum(of) for of in parts]


def area_inside(x: np.ndarray, t: np.ndarray, ring: np.ndarray) -> float:
    """
    Area in the map of triangles that look up, as far as they lie inside a polygon.

    Parameters
    ----------
    x, t : ndarray of float64 (n, 3), of int64 (m, 3)
    ring : ndarray of float64, shape (n, 2)
        Corners of the polygon, either way round.

    Examples
    --------
    >>> x = np.array([[0.0, 0, 7], [4, 0, 7], [0, 4, 7]])
    >>> ring = np.array([[1.0, -1], [9, -1], [9, 9], [5, 1], [1, 1]])
    >>> area_inside(x, np.array([[0, 1, 2]]), ring)
    2.5
    """
    # a fan of triangles covers the polygon, each with a sign; a triangle is cut along three lines
    total = []
    for second, third in pairwise(ring[1:]):
        corners = np.array([ring[0], second, third])
        u, v = corners[1:] - corners[0]
        turn = float(u[0] * v[1] - u[1] * v[0])
        corners = corners if turn > 0.0 else corners[::-1]
        low, high = corners.min(axis=0), corners.max(axis=0)
        near = x[t][:, :, :2]
        part = t[(near.max(axis=1) > low).all(axis=1) & (near.min(axis=1) < high).all(axis=1)]
        points = x
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            (ex, ey), (dx, dy) = b - a, (points[:, :2] - a).T
            points, part = clipped(np.column_stack([points[:, :2], ex * dy - ey * dx]), part, 0.0)
        total.append(math.copysign(1.0, turn) * math.fsum(area_in_map(points, part).tolist()))
    return abs(math.fsum(total))
