"""Worlds of planes: volumes of units are rational numbers, lengths are chords.

Triangulated planes are planes, so a model of such a world is right to rounding
for any `n`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise, product
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import InputError
from geosurf.synthetic.world import (
    Box,
    Offset,
    World,
    checked,
    make_fault,
    make_horizon,
    shifted,
    zone_names,
)

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray


# ---- polyhedra ----------------------------------------
# Convex polyhedra cut by planes, in rational arithmetic.
#
# The closed form of a planar world: a unit is the box cut by half-spaces, its
# volume a rational number. Every float is a fraction, so nothing is rounded before the end.


Point = tuple[Fraction, Fraction, Fraction]
Plane = tuple[Fraction, Fraction, Fraction, Fraction]  # a x + b y + c z + d >= 0 stays
Polyhedron = list[list[Point]]  # faces, each a convex ring of points


def box_polyhedron(box: Sequence[float]) -> Polyhedron:
    """Return the six faces of a box (west, east, south, north, bottom, top)."""
    limits = [[Fraction(box[2 * axis + side]) for side in (0, 1)] for axis in range(3)]
    faces = []

    # Corners of each face in a ring.
    for axis, side in product(range(3), range(2)):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        ring = []
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
            point = [Fraction(0)] * 3
            point[axis], point[one], point[two] = limits[axis][side], limits[one][i], limits[two][j]
            ring.append((point[0], point[1], point[2]))
        faces.append(ring)
    return faces


def clip(solid: Polyhedron, plane: Plane) -> Polyhedron:
    """Return the part of a convex polyhedron on the positive side of a plane.

    Examples
    --------
    >>> half = clip(box_polyhedron((0, 2, 0, 2, 0, 2)), (1, 1, 0, -2))
    >>> volume(half), volume(clip(half, (1, 1, 0, -2)))
    (Fraction(4, 1), Fraction(4, 1))
    """
    # Clip each face; the section closes the solid unless a face lies in the plane.
    faces = [ring for face in solid if len(ring := _clip_ring(face, plane)) >= 3]
    inside = any(_side(point, plane) > 0 for face in solid for point in face)
    if not inside:
        return []
    if any(all(_side(point, plane) == 0 for point in face) for face in faces):
        return faces  # it only touches the plane: the lid is there
    lid = section(solid, plane)
    return [*faces, lid] if len(lid) >= 3 else faces


def section(solid: Polyhedron, plane: Plane) -> list[Point]:
    """Return the convex ring in which a plane cuts a polyhedron; [] if it misses."""
    points = {p for face in solid for p in _on_plane(face, plane)}
    return _ring(points, plane)


def _on_plane(ring: list[Point], plane: Plane) -> list[Point]:
    """Points where the rim of a ring meets a plane."""
    clipped = _clip_ring(ring, plane)
    return [p for p in clipped if _side(p, plane) == 0]


def chord(ring: list[Point], plane: Plane) -> tuple[Point, Point] | None:
    """Return the two ends of the line in which a plane cuts a convex ring."""
    ends = sorted(set(_on_plane(ring, plane)))
    return (ends[0], ends[-1]) if len(ends) > 1 else None


def volume(solid: Polyhedron) -> Fraction:
    """Volume of a convex polyhedron: tetrahedra from one of its points."""
    if not solid:
        return Fraction(0)

    # A convex solid is the union of tetrahedra from one point to all faces.
    apex = solid[0][0]
    total = Fraction(0)
    for ring in solid:
        for b, c in pairwise(ring[1:]):
            total += abs(_det(_minus(ring[0], apex), _minus(b, apex), _minus(c, apex)))
    return total / 6


def _side(point: Point, plane: Plane) -> Fraction:
    a, b, c, d = plane
    return a * point[0] + b * point[1] + c * point[2] + d


def _clip_ring(ring: list[Point], plane: Plane) -> list[Point]:
    out: list[Point] = []
    for p, q in zip(ring, ring[1:] + ring[:1], strict=True):
        # Corners on the positive side stay; edges across the plane get a new corner.
        at_p, at_q = _side(p, plane), _side(q, plane)
        if at_p >= 0:
            out.append(p)
        if at_p * at_q < 0:
            t = at_p / (at_p - at_q)
            x, y, z = (u + t * (v - u) for u, v in zip(p, q, strict=True))
            out.append((x, y, z))
    return out


def _ring(points: set[Point], plane: Plane) -> list[Point]:
    """Points of one plane in convex order: the hull of their shadow (monotone chain)."""
    # Drop the axis that the plane faces most: the shadow has the same convex order.
    drop = max(range(3), key=lambda axis: abs(plane[axis]))
    u, v = (axis for axis in range(3) if axis != drop)
    ordered = sorted(points, key=lambda p: (p[u], p[v]))
    if len(ordered) < 3:
        return ordered

    def half(sequence: list[Point]) -> list[Point]:
        """One chain of the hull, turning one way only."""
        chain: list[Point] = []
        for p in sequence:
            while len(chain) > 1:
                a, b = chain[-2], chain[-1]
                if (b[u] - a[u]) * (p[v] - a[v]) > (b[v] - a[v]) * (p[u] - a[u]):
                    break
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(ordered) + half(ordered[::-1])


def _minus(p: Point, q: Point) -> Point:
    return p[0] - q[0], p[1] - q[1], p[2] - q[2]


def _det(a: Point, b: Point, c: Point) -> Fraction:
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


_ORIGIN = (0.0, 0.0, 0.0)


@checked
def tilted_planes(
    n: int = 33,
    *,
    dip: float = 60.0,
    dip_direction: float = 75.0,
    tilt: float = 2.0,
    offset: Offset = _ORIGIN,
) -> World:
    """Two tilted plane horizons and one dipping planar fault right across.

    Parameters
    ----------
    n : int
        Nodes per side of each horizon.
    dip : float
        Dip of the fault [degrees], more than 0, up to 90.
    dip_direction : float
        Dip direction of the fault [degrees clockwise from north].
    tilt : float
        Dip of the horizons, towards the south-west [degrees].
    offset : (float, float, float)
        Added to all coordinates [m], for instance UTM easting and northing.

    Returns
    -------
    World
        Box 4000 x 3000 x 800 m; volumes and lengths exact.

    Raises
    ------
    InputError
        If horizons leave the box or each other's order, or the dip is out of range.

    Examples
    --------
    >>> world = tilted_planes(n=9)
    >>> list(world.horizons), list(world.faults), world.truth["n_curve"]
    (['Top', 'Base'], ['F1'], 2)
    """
    # sqrt(2): the gradient has two equal parts, so the dip is `tilt` to the south-west
    slope = math.tan(math.radians(tilt)) / math.sqrt(2.0)
    box = (0.0, 4000.0, 0.0, 3000.0, -2500.0, -1700.0)
    horizons = {
        "Top": _through(slope, slope, (2000.0, 1500.0, -2050.0)),
        "Base": _through(slope, 1.25 * slope, (2000.0, 1500.0, -2150.0)),
    }
    faults = {"F1": ((2000.0, 1500.0, -2100.0), dip, dip_direction)}
    return _planar_world("tilted_planes", box, horizons, faults, n, offset)


@checked
def graben(n: int = 33, *, dip: float = 60.0, tilt: float = 1.0, offset: Offset = _ORIGIN) -> World:
    """Three plane horizons between two faults that dip towards each other.

    The horizons run through without throw: three blocks per zone, four zones.

    Parameters
    ----------
    n : int
        Nodes per side of each horizon.
    dip : float
        Dip of both faults [degrees]; F1 dips east, F2 west.
    tilt : float
        Dip of the horizons, towards the south [degrees].
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        Box 5000 x 4000 x 800 m; volumes and lengths exact. The blocks are ``("F1-", "F2+")``
        in the west, ``("F1+", "F2+")`` the graben, ``("F1+", "F2-")`` in the east.

    Raises
    ------
    InputError
        If horizons leave the box or each other's order, or the dip is out of range.

    Examples
    --------
    >>> world = graben(n=9)
    >>> sum(v > 0 for v in world.truth["volumes"].values())
    12
    """
    slope = math.tan(math.radians(tilt))
    box = (0.0, 5000.0, 0.0, 4000.0, -2600.0, -1800.0)
    horizons = {
        key: _through(0.25 * slope, slope, (2500.0, 2000.0, z))
        for key, z in (("Top", -2080.0), ("Middle", -2150.0), ("Base", -2250.0))
    }
    faults = {
        "F1": ((1500.0, 2000.0, -2150.0), dip, 97.0),
        "F2": ((3500.0, 2000.0, -2150.0), dip, 268.0),
    }
    return _planar_world("graben", box, horizons, faults, n, offset)


def _through(p: float, q: float, point: tuple[float, float, float]) -> tuple[float, float, float]:
    """Coefficients (z0, p, q) of ``z = z0 + p x + q y`` through a point."""
    return point[2] - p * point[0] - q * point[1], p, q


def _planar_world(
    name: str,
    box: Box,
    horizons: dict[str, tuple[float, float, float]],
    faults: dict[str, tuple[tuple[float, float, float], float, float]],
    n: int,
    offset: Offset,
) -> World:
    """Grids and truth of plane horizons ``(z0, p, q)`` and faults (point, dip, direction)."""
    _check_order(box, horizons)
    for key, (_, dip, _) in faults.items():
        if not 0.1 <= dip <= 90:
            raise InputError(f"dip of {key} is {dip} degrees, expected 0.1 to 90.")

    words = [f"{k}: z = {z0!r} + {p!r} x + {q!r} y" for k, (z0, p, q) in horizons.items()]
    words += [
        f"{k}: plane through {point}, dip {dip:g}, dip direction {direction:g} degrees"
        for k, (point, dip, direction) in faults.items()
    ]
    formula = (
        f"{'; '.join(words)}; box {box}; all in metres before the offset. Each unit is the box cut "
        "by half-spaces; its volume is computed in rational arithmetic from these very numbers."
    )

    grids = {key: make_horizon(key, box, n, _height_of(c), offset) for key, c in horizons.items()}
    sheets = {key: _plane_fault(key, box, n, *spec, offset) for key, spec in faults.items()}

    # the very floats of the surfaces, as fractions: truth and model see the same planes
    truth = _truth(
        box,
        {k: _above(c) for k, c in horizons.items()},
        {k: _hanging(*spec) for k, spec in faults.items()},
    )
    return World(name, grids, sheets, shifted(box, offset), truth, formula)


def _check_order(box: Box, horizons: dict[str, tuple[float, float, float]]) -> None:
    """Refuse planes that leave the box or cross: it is enough to look at its corners."""
    # Planes are highest and lowest above corners of the box, so its four corners suffice.
    for x, y in product(box[:2], box[2:4]):
        levels = [box[5], *(z0 + p * x + q * y for z0, p, q in horizons.values()), box[4]]
        names = ["the top of the box", *horizons, "the bottom of the box"]
        for i, (upper, lower) in enumerate(pairwise(levels)):
            if upper <= lower:
                raise InputError(
                    f"{names[i]} ({upper:.1f} m) is not above {names[i + 1]} ({lower:.1f} m) at "
                    f"x = {x:g}, y = {y:g}. Give the horizons less tilt."
                )


def _above(coefficients: tuple[float, float, float]) -> Plane:
    z0, p, q = map(Fraction, coefficients)

    # Positive above z = z0 + p x + q y.
    return -p, -q, Fraction(1), -z0


def _hanging(point: tuple[float, float, float], dip: float, direction: float) -> Plane:
    """The half-space of the hanging wall."""
    # rounded once as floats, exact from there on
    normal = [Fraction(value) for value in _frame(dip, direction)[2].tolist()]
    d = -sum((c * Fraction(p) for c, p in zip(normal, point, strict=True)), Fraction(0))
    return normal[0], normal[1], normal[2], d


def _frame(dip: float, direction: float) -> np.ndarray:
    """Unit vectors along strike, down dip, and normal into the hanging wall: rows (3, 3)."""
    # Dip direction is clockwise from north; x is east and y is north.
    d, a = math.radians(dip), math.radians(direction)
    sine, cosine = math.sin(d), math.cos(d) if dip < 90 else 0.0
    if dip == 90 and (math.sin(a) < -1e-6 or (math.sin(a) < 1e-6 and math.cos(a) < 0)):
        a += math.pi  # the normal of a vertical fault points east, or north
    return np.array(
        [
            [math.cos(a), -math.sin(a), 0.0],
            [math.sin(a) * cosine, math.cos(a) * cosine, -sine],
            [math.sin(a) * sine, math.cos(a) * sine, cosine],
        ]
    )


def _height_of(c: Sequence[float]) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """The height of a plane c[0] + c[1] x + c[2] y as a function of x and y."""
    return lambda x, y: c[0] + c[1] * x + c[2] * y


def _plane_fault(
    name: str,
    box: Box,
    n: int,
    point: tuple[float, float, float],
    dip: float,
    direction: float,
    offset: Offset,
) -> xarray.Dataset:
    """A planar fault that reaches 5 % past the box on all sides."""
    strike, down, _ = _frame(dip, direction)
    # Extent along strike: the corners of the box, seen from the point of the plane.
    corners = np.array(list(product(box[:2], box[2:4]))) - point[:2]
    along = corners @ strike[:2]
    margin = 0.05 * (box[5] - box[4])
    # Extent down dip: from the top of the box to its bottom, at the given dip.
    upper = (point[2] - box[5] - margin) / -down[2]
    lower = (point[2] - box[4] + margin) / -down[2]
    s = np.linspace(along.min() - margin, along.max() + margin, max(2, n // 2))
    t = np.linspace(upper, lower, max(2, n // 4))
    x, y, z = (
        point[axis] + s[None, :] * strike[axis] + t[:, None] * down[axis] for axis in range(3)
    )
    return make_fault(name, x, y, z, offset)


def _truth(box: Box, above: dict[str, Plane], hanging: dict[str, Plane]) -> dict[str, Any]:
    """Volumes of all zones on all sides, and lengths of all curves."""
    # Clip the box to each zone, then each zone to the sides of all faults.
    solid = box_polyhedron(box)
    column = list(above.values())
    volumes: dict[tuple[str, tuple[str, ...]], float] = {}
    zones: dict[str, float] = {}
    for i, zone in enumerate(zone_names(list(above))):
        layer = solid
        if i > 0:
            layer = clip(layer, _other_side(column[i - 1]))
        if i < len(column):
            layer = clip(layer, column[i])
        zones[zone] = float(volume(layer))

        # each combination of sides; an empty one has volume 0 and is left out below
        for signs in product("+-", repeat=len(hanging)):
            block = layer
            for sign, plane in zip(signs, hanging.values(), strict=True):
                block = clip(block, plane if sign == "+" else _other_side(plane))
            sides = tuple(f"{f}{sign}" for f, sign in zip(hanging, signs, strict=True))
            volumes[zone, sides] = float(volume(block))

    lengths = {}
    for (top, plane), (fault, cut) in product(above.items(), hanging.items()):
        ends = chord(section(solid, plane), cut)
        if ends:
            # The curve is the chord of the fault in the horizon's section of the box.
            lengths[top, fault] = math.dist(*(tuple(map(float, end)) for end in ends))
    return {
        "volumes": {key: value for key, value in volumes.items() if value > 0},
        "zone_volumes": zones,
        "curve_length": lengths,
        "n_curve": len(lengths),
        "closed": False,
    }


def _other_side(plane: Plane) -> Plane:
    a, b, c, d = plane
    return -a, -b, -c, -d
