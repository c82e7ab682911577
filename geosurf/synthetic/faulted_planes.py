"""Plane horizons that plane faults move: volumes, throws and areas of juxtaposition are rational.

A hanging wall moves along its plane, so that each horizon on each side is a plane again, moved by
the sum of the movements that act there. Every zone on every side is the box cut by half-spaces.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from itertools import pairwise, product
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean, is_word
from geosurf.errors import InputError
from geosurf.synthetic.planar import (
    Plane,
    Polyhedron,
    _above,
    _frame,
    _hanging,
    _height_of,
    _other_side,
    _plane_fault,
    _through,
    box_polyhedron,
    clip,
    section,
    volume,
)
from geosurf.synthetic.world import Offset, World, checked, make_horizon, shifted, zone_names

_BOX = (0.0, 2000.0, 0.0, 1600.0, -2400.0, -1600.0)
_LEVELS = (("Top", -1930.0), ("Middle", -1990.0), ("Base", -2090.0))
# point, dip, dip direction, throw; and for a branch: main fault, side of it
_KINDS: dict[str, dict[str, tuple]] = {
    "normal": {"F1": ((1000.0, 800.0, -2000.0), 60.0, 75.0, 70.0)},
    "reverse": {"F1": ((1000.0, 800.0, -2000.0), 50.0, 105.0, -45.0)},
    "vertical": {"F1": ((1000.0, 800.0, -2000.0), 90.0, 80.0, 40.0)},
    "graben": {
        "F1": ((600.0, 800.0, -2000.0), 60.0, 95.0, 70.0),
        "F2": ((1500.0, 800.0, -2000.0), 65.0, 268.0, 50.0),
    },
    "X": {
        "F2": ((1000.0, 800.0, -2000.0), 70.0, 170.0, 40.0),
        "F1": ((1000.0, 800.0, -2000.0), 60.0, 80.0, 70.0),
    },
    "Y": {
        "F2": ((1300.0, 800.0, -2000.0), 65.0, 160.0, 30.0, "F1", "+"),
        "F1": ((700.0, 800.0, -2000.0), 60.0, 90.0, 70.0),
    },
}


@checked
def faulted(
    kind: str = "graben", n: int = 33, *, tilt: float = 1.5, offset: Offset = (0.0, 0.0, 0.0)
) -> World:
    """Three plane horizons and the plane faults that are to move them.

    Parameters
    ----------
    kind : str
        ``"normal"``, ``"reverse"``, ``"vertical"``, ``"graben"`` (two faults that dip towards each
        other), ``"X"`` (two that cross) or ``"Y"`` (F2 ends on F1, in its hanging wall).
    n : int
        Nodes per side of each horizon.
    tilt : float
        Dip of the horizons [degrees].
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        Box 2000 x 1600 x 800 m. Horizons as they were *before* they were faulted; `truth` has
        ``"throw"`` by fault, youngest first, for `throw_horizon`; ``"truncations"`` for `Scene`;
        and exact: ``"volumes"``, and ``"juxtaposition"``: ``{(fault, zone on its side +, zone on
        its side -): m2}``.

    Raises
    ------
    InputError
        If the kind is unknown, or horizons leave the box.

    Examples
    --------
    >>> world = faulted("graben", n=9)
    >>> world.truth["throw"]
    {'F1': 70.0, 'F2': 50.0}
    >>> sum(volume > 0 for volume in world.truth["volumes"].values())
    12
    """
    if not is_word(kind, _KINDS):
        raise InputError(f"no faulted world is called {kind!r}.{did_you_mean(kind, _KINDS)}")
    if not 0.0 <= tilt <= 3.0:
        raise InputError(f"tilt is {tilt} degrees, expected 0 to 3, so that zones stay in the box.")
    spec = _KINDS[kind]

    # (0.8, 0.6) is a unit vector: the dip is `tilt` in that direction
    slope = math.tan(math.radians(tilt))
    horizons = {key: _through(0.8 * slope, 0.6 * slope, (1000.0, 800.0, z)) for key, z in _LEVELS}
    grids = {key: make_horizon(key, _BOX, n, _height_of(c), offset) for key, c in horizons.items()}

    faults = {
        key: _plane_fault(key, _BOX, n, plane[0], plane[1], plane[2], offset)
        for key, plane in spec.items()
    }
    truth = {
        "throw": {key: plane[3] for key, plane in spec.items()},
        "truncations": {
            key: (plane[4], "hanging wall" if plane[5] == "+" else "footwall")
            for key, plane in spec.items()
            if len(plane) > 4
        },
        **_truth(spec, horizons),
    }
    words = "; ".join(
        f"{key}: plane through {p[0]}, dip {p[1]:g}, dip direction {p[2]:g} degrees, throw "
        f"{p[3]:g} m"
        for key, p in spec.items()
    )
    formula = (
        f"{words}; horizons {horizons}; box {_BOX}; all in metres before the offset. Hanging walls "
        "move along their planes, footwalls stay."
    )
    return World(f"faulted_{kind}", grids, faults, shifted(_BOX, offset), truth, formula)


def _movement(plane: tuple) -> np.ndarray:
    """Vector (3,) by which a hanging wall moves [m]."""
    # Unit vector down dip, scaled so that its vertical part is the throw.
    down = _frame(plane[1], plane[2])[1]
    return plane[3] * down / -down[2]


def _sides(spec: dict[str, tuple]) -> list[tuple[str, ...]]:
    """Names of all sectors; a branch has no part beyond its main fault."""
    found = []
    for signs in product("+-", repeat=len(spec)):
        by_name = dict(zip(spec, signs, strict=True))
        there = tuple(
            f"{key}{sign}"
            for key, sign in by_name.items()
            if len(spec[key]) == 4 or by_name[spec[key][4]] == spec[key][5]
        )
        if there not in found:
            found.append(there)
    return found


def _zones(
    spec: Mapping[str, Any], horizons: Mapping[str, Any], sides: tuple[str, ...]
) -> dict[str, list[Plane]]:
    """Half-spaces of each zone in one sector, its faults not included."""
    # faults whose hanging wall holds this sector
    hanging = [s[:-1] for s in sides if s[-1] == "+"]
    known = {s[:-1] for s in sides}
    for key in spec.keys() - known:  # beyond its main fault a branch has one wall only
        down, main = _movement(spec[key]), _movement(spec[spec[key][4]])
        away = main[:2] * np.sign(spec[spec[key][4]][3]) * (-1.0 if spec[key][5] == "+" else 1.0)
        if float(away @ down[:2]) * np.sign(spec[key][3]) > 0:
            hanging.append(key)
    # The hanging walls that a sector belongs to add up.
    shift = sum((_movement(spec[key]) for key in hanging), np.zeros(3))
    tops = []
    # A plane z = z0 + p x + q y, moved by (dx, dy, dz), is z = z0 - p dx - q dy + dz + p x + q y.
    for z0, p, q in horizons.values():
        level = z0 - p * shift[0] - q * shift[1] + shift[2]
        tops.append(_above((float(level), p, q)))

    found = {}
    for i, zone in enumerate(zone_names(list(horizons))):
        # a zone is below the horizon above it and above the one below it; the first and last have
        # one bound
        upper = [_other_side(tops[i - 1])] if i > 0 else []
        found[zone] = upper + ([tops[i]] if i < len(tops) else [])
    return found


def _truth(spec: dict[str, tuple], horizons: dict) -> dict[str, Any]:
    """Volumes of all zones in all sectors, and areas across all faults."""
    # Sectors of the faults, each cut into zones: convex, so volumes are exact.
    planes = {key: _hanging(*plane[:3]) for key, plane in spec.items()}
    solid = box_polyhedron(_BOX)
    sectors = _sides(spec)
    volumes = {}
    for sides in sectors:
        block = _clipped(solid, _walls(planes, sides))
        for zone, half_spaces in _zones(spec, horizons, sides).items():
            volumes[zone, sides] = float(volume(_clipped(block, half_spaces)))

    # Across a fault, zone a above meets zone b below in the section of both with its plane.
    areas: dict[tuple[str, str, str], float] = {}
    for fault in spec:
        for one, two in product(sectors, sectors):
            if f"{fault}+" not in one or f"{fault}-" not in two or not _face(fault, one, two):
                continue

            # the two sectors share these sides: only the fault between them differs
            others = [s for s in {*one, *two} if s[:-1] != fault]
            block = _clipped(solid, _walls(planes, others))
            upper, lower = _zones(spec, horizons, one), _zones(spec, horizons, two)
            for (a, above), (b, below) in product(upper.items(), lower.items()):
                key = fault, a, b
                ring = section(_clipped(block, above + below), planes[fault])
                areas[key] = areas.get(key, 0.0) + _area(ring)
    return {
        "volumes": {key: value for key, value in volumes.items() if value > 0},
        "juxtaposition": {key: value for key, value in areas.items() if value > 0},
    }


def _face(fault: str, one: tuple[str, ...], two: tuple[str, ...]) -> bool:
    """Whether two sectors are on the same side of all other faults that both know."""
    signs = {s[:-1]: s[-1] for s in one}

    # both must be on the same side of every other fault that they know
    return all(signs.get(s[:-1], s[-1]) == s[-1] for s in two if s[:-1] != fault)


def _walls(planes: dict[str, Plane], sides: Iterable[str]) -> list[Plane]:
    return [planes[s[:-1]] if s[-1] == "+" else _other_side(planes[s[:-1]]) for s in sides]


def _clipped(solid: Polyhedron, half_spaces: list[Plane]) -> Polyhedron:
    for plane in half_spaces:
        solid = clip(solid, plane)
    return solid


def _area(ring: list[tuple[Fraction, Fraction, Fraction]]) -> float:
    """Area of a plane convex ring [m2]."""
    if len(ring) < 3:
        return 0.0

    # A fan of triangles from the first corner; sums of cross products in fractions.
    total = [Fraction(0)] * 3
    for b, c in pairwise(ring[1:]):
        p = [u - v for u, v in zip(b, ring[0], strict=True)]
        q = [u - v for u, v in zip(c, ring[0], strict=True)]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            total[k] += p[i] * q[j] - p[j] * q[i]
    return 0.5 * math.sqrt(float(sum(t * t for t in total)))
