"""Compute areas of zones juxtaposed across a fault, and Allan diagrams.

Every triangle of a fault inside the model has one unit in front and one behind, so areas are sums
of triangles and add up to the fault's area. The diagram is that of Allan (1989), AAPG Bulletin 73,
803-811.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.kernels.meshes.numbering import number_keys
from geosurf.measure.cutoffs import contact_chains, cutoff_chains
from geosurf.measure.faces import MINUS, PLUS, Faces, faces_of
from geosurf.measure.lines import ragged, rings_of
from geosurf.model import Patches, Unit, Units

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

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
    import xarray as xr

    faces = faces_of(patches, units, fault, "fault")
    pairs, group, between = _pairs(faces)

    # fsum, so that the areas of all pairs and their total agree to the last digit
    order, ends = _by_group(group, len(pairs))
    of_pair = np.split(faces.areas[between][order], ends[:-1])[: len(pairs)]
    areas = [math.fsum(some.tolist()) for some in of_pair]
    listed = faces.listed
    coords: dict[str, Any] = {}

    # the same columns for both sides; contacts only if some unit has one
    for k, (side, words) in enumerate(_SIDE_WORDS.items()):
        mine = [listed[u] for u in pairs[:, k].tolist()]
        for label in ("name", "zone", "block", "contact"):
            if label == "contact" and not any(unit.contact for unit in listed):
                continue
            key = "unit" if label == "name" else label
            values = np.array([getattr(unit, label) for unit in mine], dtype=object)
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
    return xr.Dataset({"area": ("pair", areas, area)}, coords, attrs)


def _pairs(faces: Faces) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of units (n, 2) in order, the pair of each triangle, and which triangles have one.

    A fault that lies in a wall of the model has a unit on one side only: nothing faces it there.
    """
    # -1 in `sides` is outside the model
    between = np.flatnonzero((faces.sides >= 0).all(axis=1))
    n_unit = len(faces.listed)
    keys, group = number_keys(faces.sides[between, 0] * n_unit + faces.sides[between, 1])
    return np.stack(np.divmod(keys, n_unit), axis=1), group, between


def _by_group(group: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows in the order of their groups, and where each of n groups ends."""
    # numbers of 16 bits are sorted in a time that grows with their number only
    order = np.argsort(group.astype(np.uint16) if n < 1 << 16 else group, kind="stable")
    return order, np.cumsum(np.bincount(group, minlength=n))


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
    pairs, group, between = _pairs(faces)
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
    told = {
        "kind": "what the line is: zone, juxtaposition, cut-off or contact",
        "side": "side of the fault",
        "label": "unit, pair of units, horizon, or fluid contact",
        "zone": "zone, or pair of zones",
        "closed": "whether the line is a ring",
    }
    labels = {
        key: ([row[k + 1] for row in rows], {"long_name": told[key]}) for k, key in enumerate(words)
    }

    # right-hand rule: the strike is 90 degrees to the left of the dip direction
    down = faces.strike[1]
    azimuth = math.degrees(math.atan2(down[0], down[1])) % 360.0
    attrs = {"fault": fault, "strike": (azimuth - 90.0) % 360.0, "strike_units": "degree"}
    return ragged(lines, _POINT, labels, attrs)
