"""Compute vertical sections: parts of units in a vertical plane, and lines of surfaces.

On which side of the plane a vertex lies is an exact sign; one in the plane counts as left of it. So
each triangle is met in two edges or in none, and the section of a closed shell is closed rings that
are linked by the edges they cross. Only where on its edge such a point lies is rounded.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import xarray

from geosurf.conventions import checked_points
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.meshes.linking import link_segments
from geosurf.kernels.search.columns import signs_of_turns
from geosurf.measure.faces import check_model
from geosurf.model import Patches, Units
from geosurf.model.excerpt import Line, model_near

# ---- lines ----------------------------------------
# Join edges of triangles to lines and rings, and store lists of lines as one dataset.


def chains_of(edges: np.ndarray, x: np.ndarray) -> list[np.ndarray]:
    """
    Link edges to lines.

    Parameters
    ----------
    edges : ndarray of int64, shape (n, 2)
        Rows of `x`, each edge once.
    x : ndarray of float64, shape (n_vertex, 3)

    Returns
    -------
    list of ndarray of int64
        Rows of `x` along each line; closed ones repeat the first. Lines end where other than two
        edges meet. Numbers of vertices do not matter: lines start at the end that lies farther
        west (south, down), closed ones at the westernmost vertex, and are sorted by that.

    Examples
    --------
    >>> chains_of(np.array([[2, 1], [0, 1]]), np.eye(3))[0].tolist()
    [2, 1, 0]
    """
    if len(edges) == 0:
        return []

    # vertices are numbered by place (x, then y, then z), so that neither the order of edges nor the
    # numbers of vertices decide where a line starts
    used = distinct(edges)
    used = used[np.lexsort(x[used].T[::-1])]  # numbered by place
    rank = np.empty(len(x), dtype=np.int64)
    rank[used] = np.arange(len(used))

    # sorted: each edge from its lower to its higher end, edges in rising order
    segments = np.sort(rank[edges], axis=1)
    segments = segments[np.lexsort(segments.T[::-1])]
    nodes, offsets, _ = link_segments(segments, np.array([0, len(segments)]), len(used))
    lines = [nodes[a:b] for a, b in pairwise(offsets.tolist())]

    # open lines start at the lower of their two ends
    lines = [line[::-1] if line[-1] < line[0] else line for line in lines]
    return [used[line] for line in sorted(lines, key=lambda line: line.tolist())]


def rings_of(triangles: np.ndarray, x: np.ndarray) -> list[np.ndarray]:
    """
    Rim of some triangles: closed rings, counter-clockwise around them, clockwise around holes.

    Parameters
    ----------
    triangles : ndarray of int64, shape (n, 3)
        Rows of `x`; neighbours face the same way.
    x : ndarray of float64, shape (n_vertex, 3)

    Returns
    -------
    list of ndarray of int64
        Rows of `x`; the first is not repeated. They start at their westernmost vertex.

    Examples
    --------
    >>> x = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> rings_of(np.array([[0, 1, 2], [0, 2, 3]]), x)[0].tolist()
    [0, 1, 2, 3]
    """
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    n = len(x)

    # an edge of two triangles that face alike occurs once in each direction; on the rim its reverse
    # is missing
    rim = ~np.isin(start * n + end, end * n + start)
    start, end = start[rim], end[rim]
    # numbered by place, so that where rings touch the way on does not depend on numbers
    used = distinct(start)
    used = used[np.lexsort(x[used].T[::-1])]
    rank = np.empty(n, dtype=np.int64)
    rank[used] = np.arange(len(used))

    # from each rim vertex to the next (several where rings touch in a vertex); lists are filled in
    # falling order, so pop gives the lowest
    onward: dict[int, list[int]] = {}
    for a, b in sorted(zip(rank[start].tolist(), rank[end].tolist(), strict=True), reverse=True):
        onward.setdefault(a, []).append(b)

    # each ring starts at its lowest vertex: lower ones have been used up by then
    return [used[ring] for ring in _closed(onward, range(len(used)))]


def _closed(onward: dict[int, list[int]], order: Iterable[int]) -> Iterator[list[int]]:
    """Rings from point to point, by the order in which they begin; the ways on are used up."""
    for first in order:
        while onward.get(first):
            ring, at = [first], onward[first].pop()
            while at != first:
                ring.append(at)
                at = onward[at].pop()
            yield ring


def ragged(
    lines: Sequence[np.ndarray],
    columns: Mapping[str, tuple[str, str]],
    labels: Mapping[str, tuple[Sequence[Any], dict[str, str]]],
    attrs: Mapping[str, Any],
) -> xarray.Dataset:
    """
    Lines of any length as one dataset: points one after the other (CF: contiguous ragged array).

    Parameters
    ----------
    lines : sequence of ndarray of float64, each (n, n_column)
    columns : mapping of str to (units, long_name)
    labels : mapping of str to (values, attrs)
        One value for each line.
    attrs : mapping

    Returns
    -------
    xarray.Dataset
        Columns over ``point``; labels and ``count`` over ``line``; ``line_of_point``.
    """
    count = np.array([len(line) for line in lines], dtype=np.int64)

    # the empty block gives a table with all columns even when there is no line
    table = np.concatenate([*lines, np.empty((0, len(columns)))])
    data: dict[str, Any] = {
        name: ("point", table[:, k], {"units": units, "long_name": words})
        for k, (name, (units, words)) in enumerate(columns.items())
    }
    data["line_of_point"] = (
        "point", np.repeat(np.arange(len(count)), count), {"long_name": "line of each point"},
    )  # fmt: skip
    data["count"] = (
        "line",
        count,
        {"long_name": "points of each line", "sample_dimension": "point"},
    )
    for name, (values, more) in labels.items():
        data[name] = ("line", np.array(values, dtype=None if len(values) else object), more)
    return xarray.Dataset(data, attrs=dict(attrs))


ROLES = ("horizon", "fault", "virtual", "contact")
_POINT = {
    "along_section": ("m", "distance along the section"),
    "elevation": ("m", "elevation"),
    "easting": ("m", "easting"),
    "northing": ("m", "northing"),
}
_TOLD = {
    "kind": "what the line is: unit, horizon, fault or contact",
    "label": "unit or surface",
    "zone": "zone of the unit",
    "block": "block of the unit",
    "region": "region of the unit",
    "contact": "interval of the unit between fluid contacts",
    "closed": "whether the line is a ring",
}


def vertical_section(patches: Patches, units: Units, line: Any) -> xarray.Dataset:
    """
    Cut a model along a line in the map, from top to bottom.

    Parameters
    ----------
    patches, units : Patches, Units
    line : array_like of float, shape (n, 2)
        Easting and northing [m]: two points or more, from the left to the right of the section.
        Points within 1 cm of a straight line between others, such as stations of a well, are left
        out.

    Returns
    -------
    xarray.Dataset
        Lines, point after point (``line_of_point``, ``count``): ``along_section`` and
        ``elevation`` [m], and the place in the world. Over ``line``: ``kind`` is ``"unit"`` (a ring
        around a part of a unit), ``"horizon"``, ``"fault"`` or ``"contact"`` (a line of a
        surface inside the model); ``label``, ``zone``, ``block``, ``contact``, ``closed``. Rings
        run counter-clockwise around what they hold, their first point is not repeated;
        ``area`` is that inside each [m2], below 0 for holes: those of all units add up to the part
        of the section in the model. ``attrs`` have its ``length`` and the corners of its
        ``line`` (easting, northing, easting ...) [m], all zones, those of the reservoir, and all
        faults.

    Raises
    ------
    InputError
        If the line is not valid, or does not meet the model.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.graben(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> west, east, south, north, bottom, top = world.box
    >>> found = vertical_section(scene.patches, scene.units, [(west, 900.0), (east, 900.0)])
    >>> round(float(found.area.sum()) / ((east - west) * (top - bottom)), 12)
    1.0
    """
    check_model(patches, units)

    # leg by leg: rings of units, then lines of surfaces, with the distance of the leg's start
    corners = check_line(line)
    rows: list[tuple[np.ndarray, tuple[str, str, str, str, str, int], float]] = []
    start = 0.0
    for a, b in pairwise(corners):
        leg = _Leg(a, b, start)
        near = model_near(units, Line(a, b)) if units.has_pieces else (patches, units)
        rows += _rings(near[1], leg) + _lines(*near, leg)
        start += leg.length
    if not any(words[0] == "unit" for _, words, _ in rows):
        w, e, s, n = units.box[:4]
        raise InputError(
            f"the line of the section lies outside the model ({w:.0f} to {e:.0f}, {s:.0f} "
            f"to {n:.0f}). Give easting and northing [m] of a line across it."
        )
    labels: dict[str, Any] = {
        key: ([words[k] for _, words, _ in rows], {"long_name": told})
        for k, (key, told) in enumerate(_TOLD.items())
    }
    attrs = {"units": "m2", "long_name": "area inside the ring"}
    whole = {
        "length": start,
        "line": corners.ravel().tolist(),
        "zones": list(dict.fromkeys(unit.zone for unit in units.values())),
        "reservoir": list(units.reservoir),
        "faults": [source.name for source in patches.sources if source.role == "fault"],
    }
    found = ragged([points for points, _, _ in rows], _POINT, labels, whole)
    return found.assign(area=("line", np.array([area for *_, area in rows]), attrs))


STRAIGHT = 0.01  # m: a corner this near to the line without it is none


def check_line(line: Any) -> np.ndarray:
    """Corners (n, 2) of the line in the map, without those on a straight line between others."""
    how = "Give easting and northing [m]."
    corners = checked_points(line, "the line of the section", how, widths=(2,), least=2)
    corners = corners[np.append(True, (np.diff(corners, axis=0) != 0).any(axis=1))]
    if len(corners) < 2:
        raise InputError(f"all points of the line of the section are identical. {how}")

    # Each part is straight, or is split at the corner that is farthest off.
    kept, todo = {0, len(corners) - 1}, [(0, len(corners) - 1)]
    while todo:
        i, j = todo.pop()
        if j - i > 1 and (k := _corner_between(corners[i : j + 1])):
            kept.add(i + k)
            todo += [(i, i + k), (i + k, j)]
    return corners[sorted(kept)]


def _corner_between(points: np.ndarray) -> int:
    """Row of a point that a straight line between the ends misses, or runs back from; else 0."""
    direction = points[-1] - points[0]
    length = math.hypot(*direction)
    along = (points - points[0]) @ (direction / length) if length else np.zeros(len(points))
    on_line = points[0] + np.clip(along, 0.0, length)[:, None] * (direction / (length or 1.0))
    off = np.hypot(*(points - on_line).T)
    if off.max() > STRAIGHT:
        return int(off.argmax())
    back = np.maximum.accumulate(along) - along
    return int(along[: back.argmax()].argmax()) if back.max() > STRAIGHT else 0


class _Leg:
    """One straight part of a section: from a to b in the map [m]."""

    def __init__(self, a: np.ndarray, b: np.ndarray, start: float) -> None:
        self.a, self.b, self.start = a, b, start
        self.length = math.dist(a, b)
        self.along = (b - a) / self.length

    def crossed(
        self, local: np.ndarray, origin: np.ndarray, triangles: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Segments (m, 2) of triangles, rows of points (k, 2): distance from a, elevation.

        Each starts on the edge that leads to the left of the plane, and ends on the one that leads
        back: what is behind a front that looks out lies to the left of it.
        """
        # exact: a vertex on the plane counts as left of it, so that no line passes through one
        used, corners = np.unique(triangles, return_inverse=True)
        x = local[used]
        ends = np.stack([self.a, self.b]) - origin[:2]

        # start and end of the leg are points 0 and 1: each vertex is tested against the line
        # through both
        points = np.concatenate([ends, x[:, :2]])
        rows = np.stack([np.zeros(len(x)), np.ones(len(x)), np.arange(len(x)) + 2.0], axis=1)
        left = signs_of_turns(points, rows.astype(np.int64)) >= 0
        faces = corners.reshape(-1, 3)

        # triangles with vertices on both sides; all others are not met
        faces = faces[left[faces].any(axis=1) & ~left[faces].all(axis=1)]

        # two edges of each triangle change sides: one towards the left, one back
        side, onward = left[faces], left[faces[:, [1, 2, 0]]]
        keys = []
        for edge in (np.argmax(~side & onward, axis=1), np.argmax(side & ~onward, axis=1)):
            row = np.arange(len(faces))

            # the edge by its two vertices, in order: both triangles at it get one number
            pair = np.stack([faces[row, edge], faces[row, (edge + 1) % 3]])
            keys.append(pair.min(axis=0) * len(x) + pair.max(axis=0))

        # a point for each edge, which all triangles at it share: rings close without a tolerance
        key, at = np.unique(np.stack(keys, axis=1), return_inverse=True)
        return at.reshape(-1, 2), self._places(x, ends[0], *np.divmod(key, len(x)))

    def _places(self, x: np.ndarray, a: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Where edges from u to v cross the plane: distance from a, and elevation."""
        # distances of both ends from the plane, with sign: their ratio is the share of the edge
        p, q = x[u, :2] - a, x[v, :2] - a
        far = np.stack([self.along[0] * d[:, 1] - self.along[1] * d[:, 0] for d in (p, q)])
        wide = far[0] - far[1]
        share = np.divide(far[0], wide, out=np.full(len(u), 0.5), where=wide != 0)
        share = np.clip(share, 0.0, 1.0)
        s = [d @ self.along for d in (p, q)]
        low, high = x[u, 2], x[v, 2]
        return np.column_stack([s[0] + share * (s[1] - s[0]), low + share * (high - low)])

    def placed(self, line: np.ndarray) -> np.ndarray:
        """Columns of the result for points (n, 2) of this leg."""
        place = self.a + line[:, :1] * self.along
        return np.column_stack([line[:, 0] + self.start, line[:, 1], place])


def _rings(units: Units, leg: _Leg) -> list[Any]:
    """Rings around the parts of units in the plane of a leg, between its ends."""
    rings = []
    for unit in units.values():
        segments, points = leg.crossed(unit.local, unit.origin, unit.triangles)

        # follow segments from point to point until a ring is closed
        onward: dict[int, list[int]] = {}

        # two rings may touch in a point, so a point may have several ways on
        for a, b in segments.tolist():
            onward.setdefault(a, []).append(b)
        words = ("unit", unit.name, unit.zone, unit.block, unit.region, unit.contact, 1)
        for ring in _closed(onward, sorted(onward, key=lambda k: points[k].tolist())):
            # rings are closed on the whole plane first, then cut at the ends of the leg
            part = _clipped(points[ring], leg.length)
            if len(part) > 2:
                rings.append((leg.placed(part), words, area_of_ring(part)))
    return rings


def _lines(patches: Patches, units: Units, leg: _Leg) -> list[Any]:
    """Lines of surfaces where they bound units, and of faults inside one, too."""
    lines = []
    front, back = units.sides.T
    inside = (front >= 0) | (back >= 0)
    for i, source in enumerate(patches.sources):
        if source.role not in ROLES:
            continue

        # horizons and contacts bound units; a fault may end inside one and is still drawn
        shown = inside if source.role == "fault" else inside & (front != back)
        rows = np.flatnonzero(shown & (patches.surface_of_triangle == i))
        name = source.name
        if source.role == "contact" and len(rows):
            name = _contact_between(units, *units.sides[rows[0]].tolist()) or name
        rows = patches.triangles[rows]
        segments, points = leg.crossed(patches.local, patches.origin, rows)

        # `chains_of` sorts by place in space: sections have no third coordinate
        x = np.column_stack([points, np.zeros(len(points))])
        edges = np.unique(np.sort(segments, axis=1), axis=0)
        for chain in chains_of(edges[edges[:, 0] != edges[:, 1]], x):
            for part in _within(points[chain], leg.length):
                words = (source.role, name, "", "", "", "", 0)
                lines.append((leg.placed(part), words, 0.0))
    return lines


def _contact_between(units: Units, first: int, second: int) -> str:
    """Name of the contact between two units; that of its surface says where it counts, too."""
    if min(first, second) < 0:
        return ""
    listed = list(units.values())
    above, below = sorted((listed[first].beneath, listed[second].beneath), key=len)
    return below[-1] if len(below) > len(above) else ""


def area_of_ring(ring: np.ndarray) -> float:
    """Return the area inside a ring (n, 2) [m2], above 0 if it runs counter-clockwise."""
    # around the first point, so that large coordinates lose no digits
    x, y = (ring - ring[0]).T
    return 0.5 * math.fsum((x * np.roll(y, -1) - np.roll(x, -1) * y).tolist())


def _clipped(ring: np.ndarray, length: float) -> np.ndarray:
    """A ring (n, 2) between the ends of a leg (Sutherland & Hodgman 1974)."""
    for limit, sign in ((0.0, 1.0), (length, -1.0)):
        if len(ring) == 0 or (sign * (ring[:, 0] - limit) >= 0).all():
            continue

        # Sutherland & Hodgman (1974): one end of the leg after the other
        kept: list[np.ndarray] = []
        for p, q in pairwise([*ring, ring[0]]):
            here, there = (sign * (point[0] - limit) >= 0 for point in (p, q))
            if here:
                kept.append(p)
            if here != there:
                kept.append(_at(p, q, limit))
        ring = np.array(kept).reshape(-1, 2)
    return ring


def _within(line: np.ndarray, length: float) -> list[np.ndarray]:
    """The parts of a line (n, 2) between the ends of a leg."""
    parts: list[list[np.ndarray]] = [[]]
    for p, q in pairwise(line):
        low, high = sorted((p[0], q[0]))
        if high < 0.0 or low > length:
            parts.append([])
            continue
        ends = [p, q]
        for k, point in enumerate((p, q)):
            # only ends outside the leg move: others stay bit for bit
            limit = min(max(point[0], 0.0), length)
            if limit != point[0]:
                ends[k] = _at(p, q, limit)
        if ends[0] is not p or not parts[-1]:
            parts.append([ends[0]])
        parts[-1].append(ends[1])
        if ends[1] is not q:
            parts.append([])
    return [np.array(part) for part in parts if len(part) > 1]


def _at(p: np.ndarray, q: np.ndarray, limit: float) -> np.ndarray:
    """Where the way from p to q has a distance along the section."""
    share = (limit - p[0]) / (q[0] - p[0])
    return np.array([limit, p[1] + share * (q[1] - p[1])])
