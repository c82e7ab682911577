"""Worlds of plane horizons and plane faults: volumes of units are rational numbers.

Each unit is the box cut by half-spaces (`clip`), each curve a chord. Triangulated planes are
planes, so a model of such a world is right to rounding for any `n`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from functools import reduce
from itertools import pairwise, product
from typing import Any, NamedTuple

import numpy as np

from geosurf.conventions import check_word
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.model.column import names_of_zones
from geosurf.synthetic.polyhedra import (
    Plane,
    Polyhedron,
    area,
    box_polyhedron,
    chord,
    clip,
    clip_ring,
    section,
    volume,
)
from geosurf.synthetic.world import Box, Offset, World, checked, make_fault, make_horizon, shifted

# ---- planes ----------------------------------------
# Plane horizons and plane faults: their grids, and their half-spaces.


Horizons = dict[str, tuple[float, float, float]]  # by name: (z0, p, q) of z = z0 + p x + q y
_ORIGIN = (0.0, 0.0, 0.0)


class PlaneFault(NamedTuple):
    """A plane fault right across the box; a branch ends on the plane of its main fault.

    Attributes
    ----------
    point : (float, float, float)
        On the plane [m].
    dip, direction : float
        [degrees]
    throw : float
        Vertical part of the movement of its hanging wall [m]; negative for a reverse fault.
    main, main_side : str
        Of a branch: the main fault, and the side of it where the branch is, ``"+"`` or ``"-"``.
    """

    point: tuple[float, float, float]
    dip: float
    direction: float
    throw: float = 0.0
    main: str = ""
    main_side: str = ""

    @property
    def movement(self) -> np.ndarray:
        """Vector (3,) by which its hanging wall moves [m]."""
        # Unit vector down dip, scaled so that its vertical part is the throw.
        down = _frame(self.dip, self.direction)[1]
        return self.throw * down / -down[2]


def _through(p: float, q: float, point: tuple[float, float, float]) -> tuple[float, float, float]:
    """Coefficients (z0, p, q) of ``z = z0 + p x + q y`` through a point."""
    return point[2] - p * point[0] - q * point[1], p, q


def _above(coefficients: tuple[float, float, float]) -> Plane:
    """The half-space above z = z0 + p x + q y."""
    z0, p, q = map(Fraction, coefficients)
    return -p, -q, Fraction(1), -z0


def _hanging_wall(fault: PlaneFault) -> Plane:
    """The half-space of the hanging wall."""
    # rounded once as floats, exact from there on
    normal = [Fraction(value) for value in _frame(fault.dip, fault.direction)[2].tolist()]
    d = -sum((c * Fraction(p) for c, p in zip(normal, fault.point, strict=True)), Fraction(0))
    return normal[0], normal[1], normal[2], d


def _frame(dip: float, direction: float) -> np.ndarray:
    """Unit vectors along strike, down dip, and normal into the hanging wall: rows (3, 3)."""
    # Dip direction is clockwise from north; x is east and y is north.
    angle, azimuth = math.radians(dip), math.radians(direction)
    sine, cosine = math.sin(angle), math.cos(angle) if dip < 90 else 0.0
    east, north = math.sin(azimuth), math.cos(azimuth)
    if dip == 90 and (east < -1e-6 or (east < 1e-6 and north < 0)):
        azimuth += math.pi  # the normal of a vertical fault points east, or north
        east, north = math.sin(azimuth), math.cos(azimuth)
    return np.array(
        [
            [north, -east, 0.0],
            [east * cosine, north * cosine, -sine],
            [east * sine, north * sine, cosine],
        ]
    )


def _horizon_grids(horizons: Horizons, box: Box, n: int, offset: Offset) -> dict[str, Any]:
    """The grids of plane horizons."""

    def grid_of(name: str, z0: float, p: float, q: float) -> Any:
        return make_horizon(name, box, n, lambda x, y: z0 + p * x + q * y, offset)

    return {name: grid_of(name, *coefficients) for name, coefficients in horizons.items()}


def _fault_grid(name: str, fault: PlaneFault, box: Box, n: int, offset: Offset) -> xarray.Dataset:
    """The grid of a plane fault that reaches 5 % past the box on all sides."""
    point = fault.point
    strike, down, _ = _frame(fault.dip, fault.direction)
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


def _other_side(plane: Plane) -> Plane:
    """The half-space on the other side of a plane."""
    a, b, c, d = plane
    return -a, -b, -c, -d


# ---- worlds ----------------------------------------
# Horizons run through without throw.


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
    faults = {"F1": PlaneFault((2000.0, 1500.0, -2100.0), dip, dip_direction)}
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
        "F1": PlaneFault((1500.0, 2000.0, -2150.0), dip, 97.0),
        "F2": PlaneFault((3500.0, 2000.0, -2150.0), dip, 268.0),
    }
    return _planar_world("graben", box, horizons, faults, n, offset)


def _planar_world(
    name: str, box: Box, horizons: Horizons, faults: dict[str, PlaneFault], n: int, offset: Offset
) -> World:
    """Grids and truth of plane horizons and faults."""
    _check_order(box, horizons)
    for key, fault in faults.items():
        if not 0.1 <= fault.dip <= 90:
            raise InputError(f"dip of {key} is {fault.dip} degrees, expected 0.1 to 90.")

    words = [f"{k}: z = {z0!r} + {p!r} x + {q!r} y" for k, (z0, p, q) in horizons.items()]
    words += [
        f"{k}: plane through {fault.point}, dip {fault.dip:g}, dip direction {fault.direction:g} "
        "degrees"
        for k, fault in faults.items()
    ]
    formula = (
        f"{'; '.join(words)}; box {box}; all in metres before the offset. Each unit is the box cut "
        "by half-spaces; its volume is computed in rational arithmetic from these very numbers."
    )

    # the very floats of the surfaces, as fractions: truth and model see the same planes
    zones = {zone: value for (zone, _), value in _volumes(box, {}, horizons).items()}
    volumes = _volumes(box, faults, horizons)
    lengths = _lengths(box, horizons, faults)
    truth = {
        "volumes": {key: value for key, value in volumes.items() if value > 0},
        "zone_volumes": zones,
        "curve_length": lengths,
        "n_curve": len(lengths),
        "closed": False,
    }
    grids = _horizon_grids(horizons, box, n, offset)
    sheets = {key: _fault_grid(key, fault, box, n, offset) for key, fault in faults.items()}
    return World(name, grids, sheets, shifted(box, offset), truth, formula)


def _check_order(box: Box, horizons: Horizons) -> None:
    """Refuse planes that leave the box or cross: if they do, they do so at a corner of the box."""
    for x, y in product(box[:2], box[2:4]):
        levels = [box[5], *(z0 + p * x + q * y for z0, p, q in horizons.values()), box[4]]
        names = ["the top of the box", *horizons, "the bottom of the box"]
        for i, (upper, lower) in enumerate(pairwise(levels)):
            if upper <= lower:
                raise InputError(
                    f"{names[i]} ({upper:.1f} m) is not above {names[i + 1]} ({lower:.1f} m) at "
                    f"x = {x:g}, y = {y:g}. Give the horizons less tilt."
                )


def _lengths(
    box: Box, horizons: Horizons, faults: dict[str, PlaneFault]
) -> dict[tuple[str, str], float]:
    """Length of the curve of each horizon and fault that meet in the box."""
    solid, lengths = box_polyhedron(box), {}
    for (top, coefficients), (name, fault) in product(horizons.items(), faults.items()):
        # The curve is the chord of the fault in the horizon's section of the box.
        ends = chord(section(solid, _above(coefficients)), _hanging_wall(fault))
        if ends:
            lengths[top, name] = math.dist(*(tuple(map(float, end)) for end in ends))
    return lengths


# ---- faulted planes ----------------------------------------
# Plane horizons that plane faults move: volumes, throws and areas of juxtaposition are rational.
#
# A hanging wall moves along its plane, so that each horizon on each side is a plane again, moved by
# the sum of the movements that act there. Every zone on every side is the box cut by half-spaces.


_BOX = (0.0, 2000.0, 0.0, 1600.0, -2400.0, -1600.0)
_LEVELS = (("Top", -1930.0), ("Middle", -1990.0), ("Base", -2090.0))
_KINDS: dict[str, dict[str, PlaneFault]] = {
    "normal": {"F1": PlaneFault((1000.0, 800.0, -2000.0), 60.0, 75.0, 70.0)},
    "reverse": {"F1": PlaneFault((1000.0, 800.0, -2000.0), 50.0, 105.0, -45.0)},
    "vertical": {"F1": PlaneFault((1000.0, 800.0, -2000.0), 90.0, 80.0, 40.0)},
    "graben": {
        "F1": PlaneFault((600.0, 800.0, -2000.0), 60.0, 95.0, 70.0),
        "F2": PlaneFault((1500.0, 800.0, -2000.0), 65.0, 268.0, 50.0),
    },
    "X": {
        "F2": PlaneFault((1000.0, 800.0, -2000.0), 70.0, 170.0, 40.0),
        "F1": PlaneFault((1000.0, 800.0, -2000.0), 60.0, 80.0, 70.0),
    },
    "Y": {
        "F2": PlaneFault((1300.0, 800.0, -2000.0), 65.0, 160.0, 30.0, "F1", "+"),
        "F1": PlaneFault((700.0, 800.0, -2000.0), 60.0, 90.0, 70.0),
    },
}


@checked
def faulted(
    kind: str = "graben", n: int = 33, *, tilt: float = 1.5, offset: Offset = _ORIGIN
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
    faults = _KINDS[kind]

    # (0.8, 0.6) is a unit vector: the dip is `tilt` in that direction
    slope = math.tan(math.radians(tilt))
    horizons = {key: _through(0.8 * slope, 0.6 * slope, (1000.0, 800.0, z)) for key, z in _LEVELS}
    volumes = _volumes(_BOX, faults, horizons)
    truth = {
        "throw": {key: fault.throw for key, fault in faults.items()},
        "truncations": {
            key: (fault.main, "hanging wall" if fault.main_side == "+" else "footwall")
            for key, fault in faults.items()
            if fault.main
        },
        "volumes": {key: value for key, value in volumes.items() if value > 0},
        "juxtaposition": _juxtaposition(_BOX, faults, horizons),
    }
    words = "; ".join(
        f"{key}: plane through {fault.point}, dip {fault.dip:g}, dip direction "
        f"{fault.direction:g} degrees, throw {fault.throw:g} m"
        for key, fault in faults.items()
    )
    formula = (
        f"{words}; horizons {horizons}; box {_BOX}; all in metres before the offset. Hanging walls "
        "move along their planes, footwalls stay."
    )
    grids = _horizon_grids(horizons, _BOX, n, offset)
    sheets = {key: _fault_grid(key, fault, _BOX, n, offset) for key, fault in faults.items()}
    return World(f"faulted_{kind}", grids, sheets, shifted(_BOX, offset), truth, formula)


def _sectors(faults: dict[str, PlaneFault]) -> list[tuple[str, ...]]:
    """The sides of faults, such as ``("F1+", "F2-")``, that each sector of the box is on.

    A branch has no part beyond its main fault, so that sectors there do not name it.
    """
    sectors = []
    for signs in product("+-", repeat=len(faults)):
        sign_of = dict(zip(faults, signs, strict=True))
        sides = tuple(
            f"{key}{sign}"
            for key, sign in sign_of.items()
            if not faults[key].main or sign_of[faults[key].main] == faults[key].main_side
        )
        if sides not in sectors:
            sectors.append(sides)
    return sectors


def _zones(
    faults: dict[str, PlaneFault], horizons: Horizons, sides: tuple[str, ...]
) -> dict[str, list[Plane]]:
    """Half-spaces of each zone in one sector, its faults not included."""
    # The movements of all hanging walls that a sector belongs to add up.
    hanging = [side[:-1] for side in sides if side[-1] == "+"]
    named = {side[:-1] for side in sides}
    hanging += [key for key in faults if key not in named and _moves_beyond_main(faults, key)]
    shift = sum((faults[key].movement for key in hanging), np.zeros(3))

    # A plane z = z0 + p x + q y, moved by (dx, dy, dz), is z = z0 - p dx - q dy + dz + p x + q y.
    tops = []
    for z0, p, q in horizons.values():
        level = z0 - p * shift[0] - q * shift[1] + shift[2]
        tops.append(_above((float(level), p, q)))

    # a zone is below the horizon above it and above the one below it; the first and last have one
    # bound
    half_spaces = {}
    for i, zone in enumerate(names_of_zones(list(horizons))):
        upper = [_other_side(tops[i - 1])] if i > 0 else []
        half_spaces[zone] = upper + ([tops[i]] if i < len(tops) else [])
    return half_spaces


def _moves_beyond_main(faults: dict[str, PlaneFault], key: str) -> bool:
    """Whether what lies beyond the main fault of a branch moves as the branch's hanging wall."""
    branch = faults[key]
    main = faults[branch.main]
    away = main.movement[:2] * np.sign(main.throw) * (-1.0 if branch.main_side == "+" else 1.0)
    return float(away @ branch.movement[:2]) * np.sign(branch.throw) > 0


def _volumes(
    box: Box, faults: dict[str, PlaneFault], horizons: Horizons
) -> dict[tuple[str, tuple[str, ...]], float]:
    """Volumes of all zones in all sectors; convex, so they are exact."""
    planes = {key: _hanging_wall(fault) for key, fault in faults.items()}
    solid, volumes = box_polyhedron(box), {}
    for sides in _sectors(faults):
        block = _clipped(solid, _walls(planes, sides))
        for zone, half_spaces in _zones(faults, horizons, sides).items():
            volumes[zone, sides] = float(volume(_clipped(block, half_spaces)))
    return volumes


def _juxtaposition(
    box: Box, faults: dict[str, PlaneFault], horizons: Horizons
) -> dict[tuple[str, str, str], float]:
    """Areas [m2] across all faults: of each zone on the hanging wall against each on the footwall.

    Two zones meet in the section of both with the plane of the fault.
    """
    planes = {key: _hanging_wall(fault) for key, fault in faults.items()}
    solid, sectors = box_polyhedron(box), _sectors(faults)
    areas: dict[tuple[str, str, str], float] = {}
    for fault, hanging, foot in product(faults, sectors, sectors):
        if f"{fault}+" not in hanging or f"{fault}-" not in foot:
            continue
        if not _are_opposite(fault, hanging, foot):
            continue

        # the two sectors share these sides: only the fault between them differs
        others = [side for side in {*hanging, *foot} if side[:-1] != fault]
        face = section(_clipped(solid, _walls(planes, others)), planes[fault])
        of_hanging, of_foot = (_zones(faults, horizons, sides) for sides in (hanging, foot))
        for (a, planes_a), (b, planes_b) in product(of_hanging.items(), of_foot.items()):
            ring = reduce(clip_ring, planes_a + planes_b, face)
            areas[fault, a, b] = areas.get((fault, a, b), 0.0) + area(ring)
    return {key: value for key, value in areas.items() if value > 0}


def _are_opposite(fault: str, hanging: tuple[str, ...], foot: tuple[str, ...]) -> bool:
    """Whether two sectors are on the same side of all other faults that both know."""
    signs = {side[:-1]: side[-1] for side in hanging}
    return all(signs.get(side[:-1], side[-1]) == side[-1] for side in foot if side[:-1] != fault)


def _walls(planes: dict[str, Plane], sides: Iterable[str]) -> list[Plane]:
    """Half-spaces of the faults that a sector is bounded by."""
    return [
        planes[side[:-1]] if side[-1] == "+" else _other_side(planes[side[:-1]]) for side in sides
    ]


def _clipped(solid: Polyhedron, half_spaces: list[Plane]) -> Polyhedron:
    """The part of a solid in all half-spaces."""
    return reduce(clip, half_spaces, solid)
