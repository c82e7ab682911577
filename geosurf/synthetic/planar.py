"""Worlds of planes: volumes of units are rational numbers, lengths are chords.

Triangulated planes are planes, so a model of such a world is right to rounding
for any `n`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise, product
from typing import Any

import numpy as np

from geosurf.conventions import check_word
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.model.column import names_of_zones
from geosurf.synthetic.world import Box, Offset, World, checked, make_fault, make_horizon, shifted

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
    zones = {zone: value for (zone, _), value in _volumes(box, {}, horizons).items()}
    volumes = _volumes(box, {key: (*plane, 0.0) for key, plane in faults.items()}, horizons)
    lengths = _lengths(box, horizons, faults)
    truth = {
        "volumes": {key: value for key, value in volumes.items() if value > 0},
        "zone_volumes": zones,
        "curve_length": lengths,
        "n_curve": len(lengths),
        "closed": False,
    }
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


def _lengths(
    box: Box, horizons: Mapping[str, Any], faults: Mapping[str, Any]
) -> dict[tuple[str, str], float]:
    """Length of the curve of each horizon and fault that meet in the box."""
    solid, lengths = box_polyhedron(box), {}
    for (top, coefficients), (fault, plane) in product(horizons.items(), faults.items()):
        # The curve is the chord of the fault in the horizon's section of the box.
        ends = chord(section(solid, _above(coefficients)), _hanging(*plane))
        if ends:
            lengths[top, fault] = math.dist(*(tuple(map(float, end)) for end in ends))
    return lengths


def _other_side(plane: Plane) -> Plane:
    a, b, c, d = plane
    return -a, -b, -c, -d


# ---- faulted planes ----------------------------------------
# Plane horizons that plane faults move: volumes, throws and areas of juxtaposition are rational.
#
# A hanging wall moves along its plane, so that each horizon on each side is a plane again, moved by
# the sum of the movements that act there. Every zone on every side is the box cut by half-spaces.


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
    check_word(kind, _KINDS, f"no faulted world is called {kind!r}.")
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
    for i, zone in enumerate(names_of_zones(list(horizons))):
        # a zone is below the horizon above it and above the one below it; the first and last have
        # one bound
        upper = [_other_side(tops[i - 1])] if i > 0 else []
        found[zone] = upper + ([tops[i]] if i < len(tops) else [])
    return found


def _volumes(
    box: Box, spec: dict[str, tuple], horizons: Mapping[str, Any]
) -> dict[tuple[str, tuple[str, ...]], float]:
    """Volumes of all zones in all sectors; convex, so they are exact."""
    planes = {key: _hanging(*plane[:3]) for key, plane in spec.items()}
    solid, volumes = box_polyhedron(box), {}
    for sides in _sides(spec):
        block = _clipped(solid, _walls(planes, sides))
        for zone, half_spaces in _zones(spec, horizons, sides).items():
            volumes[zone, sides] = float(volume(_clipped(block, half_spaces)))
    return volumes


def _truth(spec: dict[str, tuple], horizons: dict) -> dict[str, Any]:
    """Volumes of all zones in all sectors, and areas across all faults."""
    volumes = _volumes(_BOX, spec, horizons)
    planes = {key: _hanging(*plane[:3]) for key, plane in spec.items()}
    solid, sectors = box_polyhedron(_BOX), _sides(spec)

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
