"""Compute cut-off lines on both walls of a fault, and fault polygons.

A cut-off line is where the zone next to the fault changes: on each wall by itself, so that torn
horizons have two lines, untorn ones the same line twice, and one that is clipped away there none.
In the same way a fluid contact has a line where what lies above and below it meets the fault.
Which edges are meant follows from the units on the sides of the fault's triangles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray

from geosurf.conventions import is_whole
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import is_among
from geosurf.kernels.meshes.mesh import number_keys
from geosurf.measure.faces import MINUS, PLUS, POINTS, Faces, edges_of, faces_of, row_inside, row_of
from geosurf.measure.section import area_of_ring, chains_of, ragged, rings_of
from geosurf.model import Patches, Unit, Units

_PLACE = {
    "easting": ("m", "easting"),
    "northing": ("m", "northing"),
    "elevation": ("m", "elevation, positive up"),
}
NO_WIDTH = 1e-6  # rings narrower than this on average are called lines [m]


def cutoff_chains(
    patches: Patches, units: Units, horizon: str, fault: Faces, side: int
) -> list[np.ndarray]:
    """
    Vertices along the cut-off lines of a horizon on one wall of a fault.

    Parameters
    ----------
    patches : Patches
    units : Units
    horizon : str
    fault : Faces
    side : int
        0 for the wall into which the fault's normal points, 1 for the other.

    Returns
    -------
    list of ndarray of int64
        Rows of `Faces.x`, see `chains_of`.
    """
    row = row_of(patches, horizon, "horizon")
    level = level_of(patches, row)

    # the horizon with index `level` bounds zones `level` and `level + 1`: it cuts off where those
    # above and below it are on different sides of the edge. An edge with the same zones on both
    # sides belongs to a horizon that is clipped away there
    edges, upper, lower = fault.borders[side]
    edges = edges[(upper <= level) & (lower > level)]

    # vertices are shared between surfaces that meet, so the edges that horizon and fault have in
    # common are found by their keys alone
    a, b = fault.point[edges].T
    return chains_of(edges[is_among(a * POINTS + b, edges_of(units, row))], fault.x)


def level_of(patches: Patches, row: int) -> int:
    """Index of a horizon among all horizons: zones `level` and `level + 1` lie on its sides."""
    return sum(source.role == "horizon" for source in patches.sources[:row])


def contact_chains(fault: Faces, side: int) -> dict[str, list[np.ndarray]]:
    """
    Vertices along the lines of the fluid contacts on one wall of a fault, by name.

    Of a contact, those are the edges of the fault with one unit above it on this wall and, of the
    same zone and block, one below it.

    Parameters
    ----------
    fault : Faces
    side : int
        0 for the wall into which the fault's normal points, 1 for the other.

    Returns
    -------
    dict of str to list of ndarray of int64
        Rows of `Faces.x`, see `chains_of`; from the top down where several contacts count.
    """
    # as above, with units instead of zones
    edges, above, below = fault.edges_between(side, np.arange(len(fault.listed)))
    edges_of: dict[str, list[np.ndarray]] = {}

    # of all pairs of units side by side, those of one zone and block differ in contacts alone: the
    # contacts that lie above one of them and not above the other part the two
    for a, b in np.unique(np.stack([above, below], axis=1), axis=0).tolist():
        upper, lower = fault.listed[a], fault.listed[b]
        if (upper.zone, upper.block) == (lower.zone, lower.block):
            for name in set(upper.beneath) ^ set(lower.beneath):
                edges_of.setdefault(name, []).append(edges[(above == a) & (below == b)])

    # contacts from the top down: units are listed from the top down, and `beneath` as well
    order = dict.fromkeys(name for unit in fault.listed for name in unit.beneath)
    names = sorted(edges_of, key=list(order).index)
    return {name: chains_of(np.concatenate(edges_of[name]), fault.x) for name in names}


def wall_lines(
    patches: Patches, units: Units, horizon: str, fault: str, side: int
) -> list[np.ndarray]:
    """
    Cut-off lines of a horizon on one wall of a fault, in world coordinates.

    Parameters
    ----------
    patches, units : Patches, Units
    horizon, fault : str
    side : int
        0 for the wall into which the fault's normal points, 1 for the other.

    Returns
    -------
    list of ndarray of float64, each (n, 3)
        [m]; closed lines repeat their first point.

    Raises
    ------
    InputError, GeometryError
        For names that no horizon or fault has, or that do not reach into the model.
    """
    row_inside(patches, units, horizon, "horizon")
    if not is_whole(side) or side not in (PLUS, MINUS):
        raise InputError(f"side is {side!r}, expected 0 for the front of the fault or 1.")
    faces = faces_of(patches, units, fault, "fault")
    chains = cutoff_chains(patches, units, horizon, faces, side)
    return [faces.x[chain] + faces.origin for chain in chains]


def fault_polygons(patches: Patches, units: Units, horizon: str) -> xarray.Dataset:
    """
    Fault polygons of a horizon: rings of the cut-off lines of both walls, in map view.

    A ring is the rim of the part of a fault that has the horizon's upper side on one wall and its
    lower side on the other. Horizon and such parts together are one surface without gaps, so
    rings of several faults touch and never overlap where faults meet, and cover the gaps of the
    horizon exactly: its map area, plus gaps, less overlaps, is that of the model.

    Parameters
    ----------
    patches, units : Patches, Units
    horizon : str

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point``, ring after ring (``line_of_point``,
        ``count``): along the hanging-wall cut-off with the strike, back along that of the
        footwall; they are closed, the first point is not repeated. Over ``line``: ``fault``,
        ``part``, the signed ``map_area`` and ``kind``: ``"gap"`` (normal), ``"overlap"``
        (reverse), or ``"line"``: both walls have the same cut-off, or cut-offs above each other,
        and the ring has no width (less than a micrometre on average). As a rule a fault has one
        ring; it has several ``part`` where another fault has moved it aside, where its throw
        changes sign, and where the horizon is missing between them.

    Raises
    ------
    InputError
        If no horizon has that name.
    GeometryError
        If the horizon does not reach into the model.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> rings = fault_polygons(scene.patches, scene.units, "Top")
    >>> rings.fault.values.tolist(), rings.kind.values.tolist()
    (['F1'], ['line'])
    """
    row = row_inside(patches, units, horizon, "horizon")
    rings, faults, areas, kinds, parts = [], [], [], [], []

    # only surfaces with triangles in the model: others have no sides to read
    for i in sorted(units.rows_inside):
        if patches.sources[i].role != "fault":
            continue
        fault = faces_of(patches, units, patches.names[i], "fault")
        made = _rings(fault, level_of(patches, row), edges_of(units, row))
        if not made:  # not torn: the same line on both walls
            lines = cutoff_chains(patches, units, horizon, fault, PLUS)
            made = [_there_and_back(line) for line in lines]
        for part, ring in enumerate(made, start=1):
            area = area_of_ring(fault.x[ring, :2])
            narrow = abs(area) <= NO_WIDTH * _half_length(fault.x[ring])
            rings.append(fault.x[ring] + fault.origin)
            faults.append(fault.name)
            areas.append(area)
            kinds.append("line" if narrow else "gap" if area > 0 else "overlap")
            parts.append(part)
    return ragged(
        rings,
        _PLACE,
        {
            "fault": (faults, {"long_name": "fault that each ring belongs to"}),
            "part": (parts, {"long_name": "number of each ring among those of its fault"}),
            "map_area": (areas, {"units": "m2", "long_name": "area in the map, gaps above 0"}),
            "kind": (kinds, {"long_name": "gap (normal), overlap (reverse) or line (no width)"}),
        },
        {"long_name": f"fault polygons of {horizon}", "horizon": horizon, "closed": 1},
    )


def _there_and_back(line: np.ndarray) -> np.ndarray:
    """Ring of no width."""
    return line[:-1] if line[0] == line[-1] else np.concatenate([line, line[-2:0:-1]])


def _rings(fault: Faces, level: int, edges: np.ndarray) -> list[np.ndarray]:
    """Rims of where a fault has a horizon's upper side on one wall, its lower side on the other.

    Those with the hanging wall down run counter-clockwise, seen from it, the others clockwise.
    `level` and `edges` are those of the horizon, see `edges_of`.
    """
    zones, rows, first = fault.zone_pairs
    rims = []
    for down, step in ((PLUS, 1), (MINUS, -1)):
        # triangles of the pairs of zones that the horizon lies between, and no others
        pairs = np.flatnonzero((zones[:, down] <= level) & (zones[:, 1 - down] > level)).tolist()
        torn = [rows[first[k] : first[k + 1]] for k in pairs]
        if not torn:
            continue
        for ring in rings_of(fault.triangles[np.concatenate(torn)], fault.x):
            onward = np.roll(ring, -1)
            low, high = np.minimum(ring, onward), np.maximum(ring, onward)
            keys = fault.point[low] * POINTS + fault.point[high]
            if is_among(keys, edges).any():  # otherwise others, which clip it, are torn there
                rims.append(ring[::step])
    return rims


def _half_length(x: np.ndarray) -> float:
    """Half the length of a ring (n, 3) in the map [m]."""
    step = np.roll(x[:, :2], -1, axis=0) - x[:, :2]
    return 0.5 * float(np.hypot(step[:, 0], step[:, 1]).sum())


# ---- juxtaposition ----------------------------------------
# Compute areas of zones juxtaposed across a fault, and Allan diagrams.
#
# Every triangle of a fault inside the model has one unit in front and one behind, so areas are
# sums of triangles and add up to the fault's area. The diagram is that of Allan (1989), AAPG
# Bulletin 73, 803-811.


ACROSS, SELF, SLIT = "juxtaposed", "self-juxtaposed", "within one unit"
_SIDE_WORDS = {"plus": "side + of the fault", "minus": "side - of the fault"}
_POINT = {
    "along_strike": ("m", "distance along the mean strike of the fault"),
    "elevation": ("m", "elevation, positive up"),
    "easting": ("m", "easting"),
    "northing": ("m", "northing"),
}


def juxtaposition_table(patches: Patches, units: Units, fault: str) -> xarray.Dataset:
    """
    Areas of all pairs of units that face each other across a fault.

    Parameters
    ----------
    patches, units : Patches, Units
    fault : str

    Returns
    -------
    xarray.Dataset
        ``area`` [m2] over ``pair``, with unit, zone and block on side + (into which the fault's
        normal points: the hanging wall) and side -, and ``kind``: ``"juxtaposed"`` (different
        zones), ``"self-juxtaposed"`` (one zone), ``"within one unit"`` (where a fault dies).
        Areas add up to ``attrs["area"]``, that of the fault inside the model.

    Raises
    ------
    InputError
        If no fault has that name.
    GeometryError
        If it does not reach into the model.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> found = juxtaposition_table(scene.patches, scene.units, "F1")
    >>> found.zone_plus.values.tolist(), set(found.kind.values.tolist())
    (['above Top', 'Top/Base', 'below Base'], {'self-juxtaposed'})
    """
    faces = faces_of(patches, units, fault, "fault")
    pairs, group, between = pairs_of(faces)

    # fsum, so that the areas of all pairs and their total agree to the last digit
    areas = sums_by_group(group, faces.areas[between], len(pairs))
    listed = faces.listed
    coords: dict[str, Any] = {}

    # the same columns for both sides; contacts only if some unit has one
    for k, (side, words) in enumerate(_SIDE_WORDS.items()):
        on_side = [listed[u] for u in pairs[:, k].tolist()]
        for label in ("name", "zone", "block", "contact"):
            if label == "contact" and not any(unit.contact for unit in listed):
                continue
            key = "unit" if label == "name" else label
            values = np.array([getattr(unit, label) for unit in on_side], dtype=object)
            coords[f"{key}_{side}"] = ("pair", values, {"long_name": f"{key} on {words}"})
    kind = np.array([_kind(listed, a, b) for a, b in pairs.tolist()], dtype=object)
    coords["kind"] = ("pair", kind, {"long_name": "how the two zones lie"})
    area = {"units": "m2", "long_name": f"area of contact across {fault}"}
    attrs = {
        "fault": fault,
        "area": math.fsum(faces.areas[between].tolist()),
        "area_units": "m2",
        "sides": "+ is the side into which the normal of the fault points, the hanging wall",
    }
    return xarray.Dataset({"area": ("pair", areas, area)}, coords, attrs)


def pairs_of(faces: Faces) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of units (n, 2) in order, the pair of each triangle, and which triangles have one.

    A fault that lies in a wall of the model has a unit on one side only: nothing faces it there.
    """
    # -1 in `sides` is outside the model
    between = np.flatnonzero((faces.sides >= 0).all(axis=1))
    n_unit = len(faces.listed)
    keys, group = number_keys(faces.sides[between, 0] * n_unit + faces.sides[between, 1])
    return np.stack(np.divmod(keys, n_unit), axis=1), group, between


def sums_by_group(group: np.ndarray, values: np.ndarray, n: int) -> np.ndarray:
    """Sum of the values of each of n groups, without rounding in between, float64 (n,)."""
    # numbers of 16 bits are sorted in a time that grows with their number only
    order = np.argsort(group.astype(np.uint16) if n < 1 << 16 else group, kind="stable")
    ends = np.cumsum(np.bincount(group, minlength=n))
    parts = np.split(values[order], ends[:-1])[:n]
    return np.array([math.fsum(part.tolist()) for part in parts])


def _kind(listed: Sequence[Unit], a: int, b: int) -> str:
    if a == b:
        return SLIT
    return SELF if listed[a].zone == listed[b].zone else ACROSS


def allan_diagram(patches: Patches, units: Units, fault: str) -> xarray.Dataset:
    """
    Allan diagram of a fault: zones, cut-offs and fluid contacts of both walls, seen on the fault.

    Parameters
    ----------
    patches, units : Patches, Units
    fault : str

    Returns
    -------
    xarray.Dataset
        Lines, point after point (``line_of_point``, ``count``): ``along_strike`` and ``elevation``
        [m], and the place in the world. Over ``line``: ``kind`` is ``"zone"`` (a ring around
        a unit on side + or -), ``"juxtaposition"`` (a ring around the contact of two units),
        ``"cut-off"`` (a line of a horizon) or ``"contact"`` (a line of a fluid contact, on the side
        where it counts); ``side``, ``label`` (unit, ``A | B``, horizon, or fluid contact),
        ``zone``, ``closed``. Rings run counter-clockwise around what they hold, and clockwise
        around its holes, seen from side +; their first point is not repeated.

    Raises
    ------
    InputError
        If no fault has that name.
    GeometryError
        If it does not reach into the model, or has no strike.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> found = allan_diagram(scene.patches, scene.units, "F1")
    >>> [int((found.kind == kind).sum()) for kind in ("zone", "juxtaposition", "cut-off")]
    [6, 3, 4]
    """
    faces = faces_of(patches, units, fault, "fault")
    rows: list[tuple[np.ndarray, str, str, str, str, int]] = []

    # zones of each wall by themselves: what a reader of an Allan diagram lays over each other
    for side, sign in ((PLUS, "+"), (MINUS, "-")):
        for u in np.unique(faces.sides[faces.sides[:, side] >= 0, side]).tolist():
            unit = faces.listed[u]
            for ring in rings_of(faces.triangles[faces.sides[:, side] == u], faces.x):
                rows.append((ring, "zone", sign, unit.name, unit.zone, 1))

    # the overlay, exact: regions that see the same pair of units
    pairs, group, between = pairs_of(faces)
    for k, (a, b) in enumerate(pairs.tolist()):
        plus, minus = faces.listed[a], faces.listed[b]
        for ring in rings_of(faces.triangles[between[group == k]], faces.x):
            label, zones = f"{plus.name} | {minus.name}", f"{plus.zone} | {minus.zone}"
            rows.append((ring, "juxtaposition", "both", label, zones, 1))
    for source in patches.sources:
        if source.role == "horizon":
            for side, sign in ((PLUS, "+"), (MINUS, "-")):
                for line in cutoff_chains(patches, units, source.name, faces, side):
                    rows.append((line, "cut-off", sign, source.name, "", 0))
    for side, sign in ((PLUS, "+"), (MINUS, "-")):
        for name, chains in contact_chains(faces, side).items():
            rows += [(line, "contact", sign, name, "", 0) for line in chains]
    lines = []

    # the diagram plane is vertical along the mean strike; the points keep their place in the world,
    # so that a curved fault can be unrolled otherwise
    for line, *_ in rows:
        p = faces.x[line]
        world = p + faces.origin
        lines.append(np.column_stack([faces.along(p), world[:, 2], world[:, :2]]))
    words = ("kind", "side", "label", "zone", "closed")
    meanings = {
        "kind": "what the line is: zone, juxtaposition, cut-off or contact",
        "side": "side of the fault",
        "label": "unit, pair of units, horizon, or fluid contact",
        "zone": "zone, or pair of zones",
        "closed": "whether the line is a ring",
    }
    labels = {
        key: ([row[k + 1] for row in rows], {"long_name": meanings[key]})
        for k, key in enumerate(words)
    }

    # right-hand rule: the strike is 90 degrees to the left of the dip direction
    down = faces.strike[1]
    azimuth = math.degrees(math.atan2(down[0], down[1])) % 360.0
    attrs = {"fault": fault, "strike": (azimuth - 90.0) % 360.0, "strike_units": "degree"}
    return ragged(lines, _POINT, labels, attrs)
