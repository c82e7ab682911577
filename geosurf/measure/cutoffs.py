"""Compute cut-off lines on both walls of a fault, and fault polygons.

A cut-off line is where the zone next to the fault changes: on each wall by itself, so that torn
horizons have two lines, untorn ones the same line twice, and one that is clipped away there none.
In the same way a fluid contact has a line where what lies above and below it meets the fault.
Which edges are meant follows from the units on the sides of the fault's triangles.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions import is_whole
from geosurf.errors import InputError
from geosurf.measure.faces import MINUS, PLUS, Faces, faces_of, row_of
from geosurf.measure.lines import chains_of, ragged, rings_of
from geosurf.model import Patches, Units
from geosurf.model.plain_dataset import PlainDataset

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

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
        Rows of `Patches.local`, see `chains_of`.
    """
    n = len(fault.x)
    level = [s.name for s in patches.sources if s.role == "horizon"].index(horizon)

    # triangles of the fault with a unit on this wall, and the zone index of that unit
    told = np.flatnonzero(fault.sides[:, side] >= 0)
    zone = np.array([unit.zone_index for unit in fault.listed])[fault.sides[told, side]]

    # for each edge of the fault the highest and lowest zone beside it on this wall: upper and lower
    # (n_edge,), zone indices count downwards
    key, edge = np.unique(_edge_keys(fault.triangles[told], n), return_inverse=True)
    upper, lower = np.full(len(key), len(units)), np.full(len(key), -1)
    np.minimum.at(upper, edge, np.repeat(zone, 3))
    np.maximum.at(lower, edge, np.repeat(zone, 3))

    # vertices are shared between surfaces that meet, so the edges that horizon and fault have in
    # common are found by their keys alone
    mine = patches.triangles[patches.surface_of_triangle == row_of(patches, horizon, "horizon")]
    on = np.zeros(n, dtype=bool)
    on[fault.triangles] = True
    met = np.isin(key, _edge_keys(mine[on[mine].sum(axis=1) > 1], n))

    # the horizon with index `level` bounds zones `level` and `level + 1`: it cuts off where those
    # above and below it are on different sides of the edge. An edge with the same zones on both
    # sides belongs to a horizon that is clipped away there
    found = key[met & (upper <= level) & (lower > level)]
    return chains_of(np.stack(np.divmod(found, n), axis=1), fault.x)


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
    n = len(fault.x)
    told = np.flatnonzero(fault.sides[:, side] >= 0)

    # as above, with units instead of zones: the two units beside each edge, equal inside one unit
    unit = np.repeat(fault.sides[told, side], 3)
    key, edge = np.unique(_edge_keys(fault.triangles[told], n), return_inverse=True)
    one, two = np.full(len(key), len(fault.listed)), np.full(len(key), -1)
    np.minimum.at(one, edge, unit)
    np.maximum.at(two, edge, unit)
    found: dict[str, list[np.ndarray]] = {}

    # of all pairs of units side by side, those of one zone and block differ in contacts alone: the
    # contacts that lie above one of them and not above the other part the two
    for a, b in np.unique(np.stack([one, two], axis=1)[one != two], axis=0).tolist():
        upper, lower = fault.listed[a], fault.listed[b]
        if (upper.zone, upper.block) == (lower.zone, lower.block):
            for name in set(upper.beneath) ^ set(lower.beneath):
                found.setdefault(name, []).append(key[(one == a) & (two == b)])

    # contacts from the top down: units are listed from the top down, and `beneath` as well
    order = dict.fromkeys(name for unit in fault.listed for name in unit.beneath)
    names = sorted(found, key=list(order).index)
    return {
        name: chains_of(np.stack(np.divmod(np.concatenate(found[name]), n), axis=1), fault.x)
        for name in names
    }


def _edge_keys(triangles: np.ndarray, n: int) -> np.ndarray:
    """One number for each of the three edges of each triangle."""
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    return np.minimum(start, end) * n + np.maximum(start, end)


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
    faces_of(patches, units, horizon, "horizon")
    if not is_whole(side) or side not in (PLUS, MINUS):
        raise InputError(f"side is {side!r}, expected 0 for the front of the fault or 1.")
    faces = faces_of(patches, units, fault, "fault")
    chains = cutoff_chains(patches, units, horizon, faces, side)
    return [patches.local[chain] + patches.origin for chain in chains]


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
    return rings_of_faults(patches, units, horizon).to_xarray()


def rings_of_faults(patches: Patches, units: Units, horizon: str) -> PlainDataset:
    """Return what `fault_polygons` makes a Dataset of."""
    faces_of(patches, units, horizon, "horizon")
    rings, faults, areas, kinds, parts = [], [], [], [], []

    # only surfaces with triangles in the model: others have no sides to read
    inside = np.unique(patches.surface_of_triangle[(units.sides >= 0).any(axis=1)])
    for i in inside.tolist():
        if patches.sources[i].role != "fault":
            continue
        fault = faces_of(patches, units, patches.names[i], "fault")
        made = _rings(patches, fault, horizon)
        if not made:  # not torn: the same line on both walls
            lines = cutoff_chains(patches, units, horizon, fault, PLUS)
            made = [_there_and_back(line) for line in lines]
        for part, ring in enumerate(made, start=1):
            area = _map_area(fault.x[ring])
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


def _rings(patches: Patches, fault: Faces, horizon: str) -> list[np.ndarray]:
    """Rims of where a fault has a horizon's upper side on one wall, its lower side on the other.

    Those with the hanging wall down run counter-clockwise, seen from it, the others clockwise.
    """
    level = [s.name for s in patches.sources if s.role == "horizon"].index(horizon)
    zone = np.array([unit.zone_index for unit in fault.listed])
    above = zone[fault.sides] <= level
    between = (fault.sides >= 0).all(axis=1)
    n = len(fault.x)
    of_horizon = patches.surface_of_triangle == row_of(patches, horizon, "horizon")
    edges = _edge_keys(patches.triangles[of_horizon], n)
    found = []
    for down, way in ((PLUS, 1), (MINUS, -1)):
        torn = between & above[:, down] & ~above[:, 1 - down]
        for ring in rings_of(fault.triangles[torn], fault.x):
            onward = np.roll(ring, -1)
            keys = np.minimum(ring, onward) * n + np.maximum(ring, onward)
            if np.isin(keys, edges).any():  # otherwise others, which clip it away, are torn there
                found.append(ring[::way])
    return found


def _map_area(x: np.ndarray) -> float:
    """Area in the map of a ring (n, 3), positive if counter-clockwise [m2]."""
    p = x[:, :2] - x[0, :2]
    q = np.roll(p, -1, axis=0)
    return 0.5 * float((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum())


def _half_length(x: np.ndarray) -> float:
    """Half the length of a ring (n, 3) in the map [m]."""
    step = np.roll(x[:, :2], -1, axis=0) - x[:, :2]
    return 0.5 * float(np.hypot(step[:, 0], step[:, 1]).sum())
