"""Cases that break engines, by family; each is known by its family, its number and a seed."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from benchmarks.stress.case import Case
from benchmarks.stress.catalogue import (
    BASE,
    CATALOGUE,
    ORDERS,
    REGIONS,
    moved,
    random_turn,
    region_corner,
    turned,
)
from benchmarks.stress.rational import flat
from benchmarks.stress.shapes import (
    bumps,
    grid,
    make_wall,
    scaled_and_moved,
    solid_triangles,
    soup,
    square_nodes,
)
from geosurf.conventions import did_you_mean
from geosurf.errors import InputError
from geosurf.model import Lattice, TriSurface

Draw = tuple[list[TriSurface], dict[str, Any]]


def make_case(family: str, number: int, seed: int = 0) -> Case:
    """Make one case; the same arguments make the same bytes.

    Parameters
    ----------
    family : str
        One of `FAMILIES`.
    number : int
        From 0.
    seed : int

    Returns
    -------
    Case

    Raises
    ------
    InputError
        If there is no such family.

    Examples
    --------
    >>> case = make_case("lattice soups", 3)
    >>> [s.name for s in case.surfaces], case.self_intersections
    (['A', 'B'], True)
    """
    if family not in FAMILIES:
        raise InputError(
            f"there is no family {family!r} of stress cases; there are {', '.join(FAMILIES)}."
            f"{did_you_mean(family, FAMILIES)}"
        )

    # Seeds of three numbers: cases do not depend on each other or on how many were made before.
    rng = np.random.default_rng([seed, zlib.crc32(family.encode()), number])
    surfaces, known = FAMILIES[family](rng, number)
    return Case(family, number, seed, tuple(surfaces), known.pop("self", False), known)


# ---- how surfaces are made -------------------------------------------------------------


# ---- the families ----------------------------------------------------------------------


def _random_soups(rng: np.random.Generator, number: int) -> Draw:
    # Eight triangles of size 1 around random places: some meet, some do not.
    triangles = rng.random((2, 4, 1, 3)) + rng.uniform(-0.5, 0.5, (2, 4, 3, 3))
    return [soup("A", triangles[0]), soup("B", triangles[1])], {"self": True}


def _lattice_triangles(
    rng: np.random.Generator, extent: int, counts: Iterable[int]
) -> list[np.ndarray]:
    return [solid_triangles(lambda: rng.integers(0, extent + 1, (3, 3)), n) for n in counts]


def _lattice_soups(rng: np.random.Generator, number: int) -> Draw:
    first, second = _lattice_triangles(rng, 3, rng.integers(1, 5, 2))
    return [soup("A", first), soup("B", second)], {"self": True}


def _catalogue(rng: np.random.Generator, number: int) -> Draw:
    pair = CATALOGUE[number % len(CATALOGUE)]

    # All orders of both triangles, one after the other, in a random frame.
    turn = number // len(CATALOGUE)
    first, second = (
        # six orders of the first triangle for each of the second: 36 rounds of the list show all
        BASE[list(ORDERS[turn % 6])],
        np.array(pair.corners)[list(ORDERS[turn // 6 % 6])],
    )
    triangles = moved(rng, turn, first, second)
    surfaces = [soup(name, corners) for name, corners in zip("AB", triangles, strict=True)]

    # either may be the first surface: the contact must be the same
    if rng.integers(2):
        surfaces.reverse()
    return surfaces, {"kind": pair.kind, "count": pair.count, "name": pair.name}


def _regions(rng: np.random.Generator, number: int) -> Draw:
    def draw() -> Any:
        """Corners of one triangle at random."""
        places = rng.integers(0, len(REGIONS) * 3, 3)  # anew: three may lie on one line for good
        corners = [region_corner(rng, place // 3) for place in places]

        # a region of the plane, and below, in or above it
        for corner, place in zip(corners, places, strict=True):
            corner[2] = (place % 3 - 1) * rng.integers(1, 9)
        return np.array(corners)

    second = solid_triangles(draw, 1)[0]
    triangles = moved(rng, number, BASE[list(ORDERS[number % 6])], second)
    return [soup("A", triangles[0]), soup("B", triangles[1])], {}


def _aligned_grids(rng: np.random.Generator, number: int) -> Draw:
    x, y = square_nodes(4)

    # heights of whole numbers: nodes, edges and faces of the two grids meet exactly
    top = grid("Top", x, y, rng.integers(0, 3, x.shape), rising=bool(rng.integers(2)))
    kind = number % 4
    if kind == 0:  # the same nodes, so that triangles share columns
        return [top, grid("Base", x, y, rng.integers(0, 3, x.shape))], {}
    if kind == 1:  # nodes on the middles of edges and faces
        x, y = square_nodes(4, 0.5)
        return [top, grid("Base", x, y, 0.5 * rng.integers(0, 5, x.shape))], {}

    # A wall through nodes, or along a column of nodes or cell middles.
    at = rng.integers(0, 4, 2) if kind == 2 else np.sort(rng.integers(0, 7, 2)) / 2
    ends = [(at[0], -1), (at[1], 4)] if kind == 2 else [(at[0], 0), (at[0], 3)]
    return [top, make_wall(rng, "F1", ends, -1, 3, float(rng.integers(0, 2)) / 2)], {}


def _near_parallel(rng: np.random.Generator, number: int) -> Draw:
    # From clearly crossing to parallel within 1e-8.
    slope = 10.0 ** -(number % 9)
    x, y = square_nodes(4)
    z = rng.uniform(-1, 1) * x + rng.uniform(-1, 1) * y
    if number % 2:
        z = z + bumps(rng)(x, y)

    # The tilt is 0 at a place that is not a node, so that the surfaces cross there.
    tilt = rng.uniform(-1, 1, 2) * slope
    other = z + tilt[0] * (x - 1.37) + tilt[1] * (y - 1.61)
    return [grid("Top", x, y, z), grid("Base", x, y, other, rising=bool(rng.integers(2)))], {}


def _slivers(rng: np.random.Generator, number: int) -> Draw:
    # from a fat triangle to one a billion times as long as high
    aspect = 10.0 ** -(number % 10)

    def draw() -> Any:
        """Corners of one triangle at random."""
        # The third corner leaves the line of the first two by the aspect.
        start, along, across = rng.uniform(-1, 4, 3), *rng.normal(size=(2, 3))
        start[2] = rng.uniform(-1, 1)
        return [start, start + 3 * along, start + rng.uniform(0, 3) * along + aspect * across]

    x, y = square_nodes(4)
    return [grid("Top", x, y, bumps(rng)(x, y)), soup("S", solid_triangles(draw, 3))], {
        "self": True
    }


def _gaps(rng: np.random.Generator, number: int) -> Draw:
    # Gaps from 1e-9 m down to 3e-14 m: powers of two, so that they are exact.
    gap = 2.0 ** -(30 + number % 16)
    x, y = square_nodes(4)
    z = np.round(bumps(rng)(x, y) * 64) / 64
    shift = rng.integers(0, 3) / 4

    # Flat tops may be shifted sideways; others need the same nodes, or the gap would close.
    flat_top = number % 2
    if flat_top:
        z, x2, y2 = np.full(x.shape, z[0, 0]), x + shift, y - shift
    else:
        x2, y2 = x, y
    return [grid("Top", x, y, z + gap), grid("Base", x2, y2, z)], {"apart": True}


def _offsets(rng: np.random.Generator, number: int) -> Draw:
    surfaces = _horizon_and_fault(rng)

    # Map coordinates of millions of metres; elevations of thousands.
    offset = rng.uniform(1e6, 1e7, 3) * [1, 1, 3e-4] * rng.choice([-1, 1], 3)
    if number % 3 == 0:  # a model as wide as a continent
        return scaled_and_moved(surfaces, float(rng.uniform(1e5, 1e6)), offset), {}
    return scaled_and_moved(surfaces, float(10.0 ** rng.uniform(0, 3)), offset), {}


def _horizon_and_fault(rng: np.random.Generator) -> list[TriSurface]:
    x, y = square_nodes(4)
    ends = rng.uniform(-0.5, 3.5, (2, 2))
    wall = make_wall(rng, "F1", ends, -3, 3, rng.uniform(-0.5, 0.5))
    return [grid("Top", x, y, bumps(rng)(x, y)), wall]


def _holes(rng: np.random.Generator, number: int) -> Draw:
    x, y = square_nodes(6)
    z = bumps(rng)(x, y)
    z[rng.random(z.shape) < 0.2] = np.nan
    z[2:4, 2:4] = 0.25  # one cell at least
    # a grid is upright in files: its axes are one-dimensional
    top = TriSurface("Top", "horizon", lattice=Lattice(x[0], y[:, 0], z))
    return [top, make_wall(rng, "F1", rng.uniform(0, 5, (2, 2)), -3, 3, rng.uniform(-0.5, 0.5))], {}


def _pinch_outs(rng: np.random.Generator, number: int) -> Draw:
    x, y = square_nodes(5)

    # The thickness is cut off at 0, so that both surfaces coincide where it ends.
    z = rng.integers(-8, 9, x.shape) / 8
    thick = np.maximum(
        0, rng.integers(-3, 4) + rng.integers(1, 4) * (x - 2) + rng.integers(-2, 3) * y
    )

    # down to a thickness of 1e-7: the rim of the coincidence stays where it is
    scale = 10.0 ** -rng.integers(0, 8)
    return [grid("Top", x, y, z + scale * thick), grid("Base", x, y, z)], {}


def _strips(rng: np.random.Generator, number: int) -> Draw:
    t, y = np.meshgrid(np.linspace(-1.5, 1.5, int(rng.integers(5, 10))), np.arange(3.0))

    # A cubic loop: the strip passes through itself.
    x, z = t**3 - t * rng.uniform(0.6, 1.2), 1.0 - t**2
    if number % 2:
        x, z = np.round(4 * x) / 4, np.round(4 * z) / 4
    strip = grid("S", x, y + rng.uniform(-0.3, 0.3) * t, z, role="surface")
    # Rounding may leave triangles without area, which are not allowed.
    keep = [not flat(c) for c in strip.vertices[strip.triangles]]
    strip = TriSurface("S", "surface", strip.vertices, strip.triangles[keep])
    return [strip], {"self": True}


def _triple_lines(rng: np.random.Generator, number: int) -> Draw:
    """Three or four sheets through one line, or a hair beside it."""
    p, along = rng.integers(-3, 4, (2, 3))
    along[int(rng.integers(3))] += 7
    sheets = []
    for k in range(int(rng.integers(3, 5))):
        while True:
            one, two = rng.integers(-4, 5, (2, 3))
            across = one if k % 2 else -2 * one
            a, b = p - 2 * along, p + 3 * along
            quad = np.array([[a + one, b + two], [a - across, b - 2 * two]], dtype=float)
            if not any(
                flat(c) for c in (quad.reshape(4, 3)[[0, 1, 3]], quad.reshape(4, 3)[[0, 3, 2]])
            ):
                break
        # both rows end on opposite sides of the line; a middle row runs along it
        middle = np.array([[a, b]], dtype=float)
        rows = np.concatenate([quad[:1], middle, quad[1:]])
        sheets.append(grid(f"S{k}", *np.moveaxis(rows, -1, 0), role="fault"))
    solid = [s for s in sheets if not any(flat(c) for c in s.vertices[s.triangles])]
    while len(solid) < 2:
        solid.append(
            soup(f"T{len(solid)}", solid_triangles(lambda: rng.integers(-9, 10, (3, 3)), 1))
        )

    # one case in three misses the common line by 1e-6 to 1e-13
    hair = 10.0 ** -rng.integers(6, 14) if number % 3 == 2 else 0.0
    shifted = scaled_and_moved(solid[1:2], 1.0, hair * rng.normal(size=3))
    return [solid[0], *shifted, *solid[2:]], {"self": True}


def _overlaps(rng: np.random.Generator, number: int) -> Draw:
    # Planes with slopes of quarters: exact in float64, shifted within themselves.
    shift = rng.integers(0, 13, 2) / 4
    slope = rng.integers(-2, 3, 2) / 4
    x, y = square_nodes(4)
    surfaces = []
    for name, (dx, dy) in (("Top", (0, 0)), ("Base", shift)):
        z = slope[0] * (x + dx) + slope[1] * (y + dy)
        surfaces.append(grid(name, x + dx, y + dy, z, rising=bool(rng.integers(2))))
    if number % 2:
        surfaces.append(
            make_wall(rng, "F1", rng.integers(0, 7, (2, 2)) / 2 + [[0, 0], [4, 0]], -4, 4, 0)
        )

    # The area that both cover, on the map and then on the slope [m2].
    size = np.maximum(0, 3 - shift)
    return surfaces, {"area": float(size.prod() * np.sqrt(1 + slope @ slope))}


def _self_overlaps(rng: np.random.Generator, number: int) -> Draw:
    """Triangles of few planes, some of them in several surfaces or twice in one, turned."""

    def draw() -> Any:
        """Corners of one triangle, mostly in one of seven planes."""
        corners = rng.integers(0, 4, (3, 3))
        kind = rng.integers(5)
        if kind < 3:
            corners[:, kind] = rng.integers(0, 2)
        elif kind == 3:
            corners[:, 2] = corners[:, 0]
        return corners

    # few triangles, drawn often: surfaces contain the same one several times, in any turn
    pool = solid_triangles(draw, 4)
    surfaces = []
    for name in "ABC"[: 1 + number % 3]:
        rows = rng.integers(0, len(pool), int(rng.integers(2, 5)))
        mine = [pool[k][rng.permutation(3)] for k in rows]
        surfaces.append(soup(name, [*mine, *solid_triangles(draw, int(rng.integers(0, 3)))]))
    return surfaces, {"self": bool(number % 2) or len(surfaces) == 1}


def _rounded(rng: np.random.Generator, number: int) -> Draw:
    """Soups of a lattice divided by three, or turned in space: degenerate but for rounding."""
    triangles = _lattice_triangles(rng, 2, rng.integers(1, 4, 2))

    # decimals and thirds: what was exact before rounding is nearly so after it
    if number % 2:
        turn = random_turn(rng)
        triangles = [turned(t, turn) for t in triangles]
    else:
        triangles = [t / 3 for t in triangles]
    triangles = [np.array([c for c in t if not flat(c)]) for t in triangles]
    return [soup("A", triangles[0]), soup("B", triangles[1])], {"self": True}


def _shifted_planes(rng: np.random.Generator, number: int) -> Draw:
    """Planes of a lattice, moved by decimals: many meet in a point or line, but for rounding."""
    # decimals that binary fractions only approximate
    shift = np.round(rng.random(3), int(rng.integers(1, 4))) + (number % 3 == 2) * 1000.0
    corners: list[np.ndarray] = []
    for _ in range(int(rng.integers(3, 8))):
        one, two = rng.permutation(3)[:2]
        axis = 3 - one - two  # heights on this axis are whole on whole corners
        p, q, height = rng.integers(-2, 3, 3)
        ends = np.array([(-8, -8), (8, -8), (8, 8), (-8, 8)], dtype=float)
        quad = np.empty((4, 3))
        quad[:, one], quad[:, two] = ends.T
        quad[:, axis] = p * ends[:, 0] + q * ends[:, 1] + height
        if not any(np.array_equal(quad, other) for other in corners):
            corners.append(quad)
    places = [quad + shift for quad in corners]
    if number % 4 == 3:  # one of them again, units in the last place away
        again = places[0]
        places.append(np.nextafter(again, again + rng.choice([-1.0, 0.0, 1.0], again.shape)))
    faces = [[0, 1, 2], [0, 2, 3]] if number % 2 else [[0, 1, 2]]
    return [TriSurface(f"P{k}", "fault", x, faces) for k, x in enumerate(places)], {}


FAMILIES: dict[str, Callable[[np.random.Generator, int], Draw]] = {
    "catalogue": _catalogue,
    "regions": _regions,
    "random soups": _random_soups,
    "lattice soups": _lattice_soups,
    "aligned grids": _aligned_grids,
    "near-parallel": _near_parallel,
    "slivers": _slivers,
    "gaps": _gaps,
    "offsets": _offsets,
    "holes": _holes,
    "pinch-outs": _pinch_outs,
    "strips": _strips,
    "triple lines": _triple_lines,
    "overlaps": _overlaps,
    "self-overlaps": _self_overlaps,
    "near-degenerate": _rounded,
    "shifted planes": _shifted_planes,
}
