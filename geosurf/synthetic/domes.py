"""Domes and hills cut by faults: closed curves, a listric fault, noise, waves known everywhere."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from geosurf.conventions import check_word
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.synthetic.planar import tilted_planes
from geosurf.synthetic.world import (
    Box,
    Offset,
    World,
    check_count,
    checked,
    make_fault,
    make_horizon,
    shifted,
)

_ORIGIN = (0.0, 0.0, 0.0)


@checked
def dome_and_flat_fault(
    n: int = 33,
    *,
    semi_axes: tuple[float, float] = (1200.0, 800.0),
    height: float = 20.0,
    offset: Offset = _ORIGIN,
) -> World:
    """A dome cut by a flat surface: one closed curve, and a cap above it.

    Parameters
    ----------
    n : int
        Nodes per side of the horizon.
    semi_axes : (float, float)
        Semi-axes of the curve along east and north [m], less than 2000; equal: a circle.
    height : float
        Height of the cap [m].
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        Horizon ``Top``, flat fault ``Flat``; the side ``("Flat+",)`` is above it.

    Raises
    ------
    InputError
        If the curve does not fit into the box, or the dome does not.

    Examples
    --------
    >>> world = dome_and_flat_fault(semi_axes=(1000, 1000), height=25)
    >>> round(world.truth["curve_length"]["Top", "Flat"] / (2 * math.pi), 9)
    1000.0
    """
    a, b = map(float, semi_axes)
    box = (0.0, 4000.0, 0.0, 4000.0, -2300.0, -1800.0)
    crest, side = -1900.0, 2000.0
    # The paraboloid is lowest in the corners of the box.
    lowest = crest - height * ((side / a) ** 2 + (side / b) ** 2)
    if not (0 < a < side and 0 < b < side and height > 0 and lowest > box[4]):
        raise InputError(
            f"semi_axes are {semi_axes} and height is {height}: the dome comes down to "
            f"{lowest:.0f} m, expected above {box[4]:g} m. Use axes below 2000 m, or less height."
        )
    level = crest - height

    def dome(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Height of the paraboloid."""
        return crest - height * (((x - side) / a) ** 2 + ((y - side) / b) ** 2)

    # The mean of (x - side)^2 over the square is side^2 / 3.
    footprint = (2 * side) ** 2
    mean = crest - height * side**2 / 3 * (1 / a**2 + 1 / b**2)
    # A paraboloid cap holds half of its cylinder.
    cap = math.pi * a * b * height / 2
    truth = _split_by_level(box, level, footprint * (mean - box[4]), cap)
    truth |= {"curve_length": {("Top", "Flat"): ellipse_length(a, b)}, "n_curve": 1, "closed": True}
    formula = (
        f"Top: z = {crest:g} - {height:g} (((x - 2000) / {a:g})^2 + ((y - 2000) / {b:g})^2); "
        f"Flat: z = {level:g}; box {box}; all in metres before the offset. They meet in an ellipse "
        f"with semi-axes {a:g} and {b:g}; the cap above it holds pi a b h / 2."
    )

    horizons = {"Top": make_horizon("Top", box, n, dome, offset)}
    faults = {"Flat": _flat(box, level, n, offset)}
    return World("dome_and_flat_fault", horizons, faults, shifted(box, offset), truth, formula)


@checked
def egg_box(
    n: int = 97,
    *,
    periods: int = 3,
    height: float = 25.0,
    level: float = 0.4,
    offset: Offset = _ORIGIN,
) -> World:
    """A horizon of many domes and basins, cut by one flat surface: many closed curves.

    Parameters
    ----------
    n : int
        Nodes per side; 16 per period or more, so that each dome is seen.
    periods : int
        Periods per side; there are ``2 * periods**2`` domes.
    height : float
        Height of the domes above the mean [m].
    level : float
        Level of the flat surface over the mean, as a part of `height`, between 0 and 1.
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        Horizon ``Top``, flat fault ``Flat``. Volumes of the caps are added up.

    Raises
    ------
    InputError
        If the level is not between 0 and 1 (at 0, the curves become lines through
        the saddles), or the number of periods is below 1.

    Examples
    --------
    >>> egg_box(periods=2, n=65).truth["n_curve"]
    8
    """
    if not 0 < level < 1:
        raise InputError(f"level is {level}, expected between 0 (saddles) and 1 (crests).")
    if periods < 1:
        raise InputError(f"periods is {periods}, expected 1 or more.")

    # the mean of sin sin over whole periods is 0, so the volume below is that of the mean level
    side, middle = 4000.0, -2050.0
    box = (0.0, side, 0.0, side, -2300.0, -1800.0)
    wave = 2 * math.pi * periods / side

    def domes(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Height of the egg box."""
        return middle + height * np.sin(wave * x) * np.sin(wave * y)

    # Crests above the level: two in each square of one period.
    n_dome = 2 * periods**2
    length, cap = _one_dome(level)
    flat = middle + level * height

    # one dome in units of wave lengths (u = k x, v = k y): area scales by 1 / k^2, height by
    # `height`
    caps = n_dome * cap * height / wave**2
    truth = _split_by_level(box, flat, side**2 * (middle - box[4]), caps)
    truth |= {
        "curve_length": {("Top", "Flat"): n_dome * length / wave},
        "n_curve": n_dome,
        "closed": True,
    }
    formula = (
        f"Top: z = {middle:g} + {height:g} sin(k x) sin(k y) with k = 2 pi {periods} / {side:g}; "
        f"Flat: z = {flat:g}; box {box}; all in metres before the offset. The curves "
        f"sin u sin v = {level:g} are {n_dome} equal loops; their length and the caps above them "
        "are quadratures that converge exponentially (trapezia around, Gauss across)."
    )

    horizons = {"Top": make_horizon("Top", box, n, domes, offset)}
    faults = {"Flat": _flat(box, flat, n, offset)}
    return World("egg_box", horizons, faults, shifted(box, offset), truth, formula)


def ellipse_length(a: float, b: float) -> float:
    """Perimeter of an ellipse by the arithmetic-geometric mean.

    Examples
    --------
    >>> round(ellipse_length(1.0, 1.0) / math.pi, 12)
    2.0
    """
    # Gauss's iteration: it doubles the digits in each step (Abramowitz & Stegun 17.6).
    a, b = max(a, b), min(a, b)
    total, power = a * a - 0.5 * (a * a - b * b), 1.0
    while a - b > 1e-12 * a:
        c = 0.5 * (a - b)
        total -= power * c * c
        a, b, power = 0.5 * (a + b), math.sqrt(a * b), 2.0 * power
    return 2.0 * math.pi * total / (0.5 * (a + b))


def _split_by_level(box: Box, level: float, below: float, cap: float) -> dict[str, Any]:
    """Volumes of two zones over and under a flat surface.

    `below` is the volume under the horizon, `cap` the part of it over the surface.
    """
    footprint = (box[1] - box[0]) * (box[3] - box[2])

    # the surface splits the box; the cap is what of the lower zone lies above it
    under = footprint * (level - box[4])
    whole = footprint * (box[5] - box[4])
    return {
        "volumes": {
            ("above Top", ("Flat+",)): whole - under - cap,
            ("above Top", ("Flat-",)): under - (below - cap),
            ("below Top", ("Flat+",)): cap,
            ("below Top", ("Flat-",)): below - cap,
        },
        "zone_volumes": {"above Top": whole - below, "below Top": below},
    }


def _flat(box: Box, level: float, n: int, offset: Offset) -> xarray.Dataset:
    """A flat fault, 100 m larger than the box, its nodes beside those of the horizon."""
    # a flat surface needs few nodes, and 100 m beyond the box so that it cuts the four sides
    size = max(2, n // 3)
    x = np.linspace(box[0] - 100.0, box[1] + 100.0, size)[None, :]
    y = np.linspace(box[3] + 100.0, box[2] - 100.0, size)[:, None]
    return make_fault("Flat", x, y, np.full((size, size), level), offset)


def _one_dome(level: float) -> tuple[float, float]:
    """Length of one loop ``cos s cos t = level``, and the volume of its cap over the level."""
    # Polar coordinates around the crest: rim(phi) by Newton's method, 512 angles.
    phi = np.linspace(0.0, 2 * math.pi, 512, endpoint=False)
    c, s = np.cos(phi), np.sin(phi)
    rho = np.full_like(phi, math.acos(level))
    for _ in range(60):  # Newton, monotone from outside
        value = np.cos(rho * c) * np.cos(rho * s) - level

        # derivative of the value along the ray, negative inside the dome
        slope = -c * np.sin(rho * c) * np.cos(rho * s) - s * np.cos(rho * c) * np.sin(rho * s)
        rho = rho - value / slope

    # The derivative of the radius along the rim gives its length.
    turn = rho * (s * np.sin(rho * c) * np.cos(rho * s) - c * np.cos(rho * c) * np.sin(rho * s))
    rim = np.sqrt(rho**2 + (turn / slope) ** 2)

    # Forty Gauss points along each radius for the volume; trapezia around converge exponentially.
    node, weight = np.polynomial.legendre.leggauss(40)
    r = rho[:, None] * (0.5 + 0.5 * node)
    over = np.cos(r * c[:, None]) * np.cos(r * s[:, None]) - level
    cap = (over * r * weight).sum(axis=1) * 0.5 * rho
    step = 2 * math.pi / len(phi)
    return float(rim.sum() * step), float(cap.sum() * step)


@checked
def listric(
    n: int = 33, *, radius: float = 2500.0, tilt: float = 2.0, offset: Offset = _ORIGIN
) -> World:
    """A listric fault, an arc of a circle in section, through a tilted plane.

    Parameters
    ----------
    n : int
        Nodes per side of the horizon, and down dip on the fault.
    radius : float
        Radius of the arc [m], 2300 to 3000.
    tilt : float
        Dip of the horizon along the strike of the fault, to the south [degrees], 0.1 to 4.
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        Horizon ``Top``, fault ``F1`` dipping east, less and less with depth.

    Raises
    ------
    InputError
        If radius or tilt are out of range.

    Examples
    --------
    >>> world = listric(n=17)
    >>> 3000 < world.truth["curve_length"]["Top", "F1"] < 3100
    True
    """
    if not 2300 <= radius <= 3000:
        raise InputError(f"radius is {radius} m, expected 2300 to 3000, so that it fits the box.")
    if not 0.1 <= tilt <= 4:
        raise InputError(f"tilt is {tilt} degrees, expected 0.1 to 4.")

    box = (0.0, 4000.0, 0.0, 3000.0, -2800.0, -1000.0)

    # all formulas below use u = z - top, the elevation from the axis
    east, top = radius + 500.0, -800.0  # axis of the cylinder
    slope, depth = math.tan(math.radians(tilt)), -1900.0
    ends = [depth + slope * (y - 1500.0) - top for y in box[2:4]]  # of the horizon, below the axis

    def arc(u: np.ndarray) -> np.ndarray:
        """Easting of the fault, u below the axis of its cylinder."""
        return east - np.sqrt(radius**2 - u**2)

    # Integrals of the arc over depth, and of that integral: volumes of the footwall by slices.
    first, second = _circle_integrals(radius)
    bottom = box[4] - top
    width, breadth = box[1] - box[0], box[3] - box[2]
    below = width * breadth * (depth - box[4])
    foot_below = east * breadth * (depth - box[4]) - (
        (second(ends[1]) - second(ends[0])) / slope - first(bottom) * breadth
    )

    # footwall in the whole box, then the four units by differences
    high = box[5] - top
    foot = breadth * (east * (high - bottom) - (first(high) - first(bottom)))
    whole = width * breadth * (high - bottom)

    truth = {
        **_split_by_fault(whole, below, foot, foot_below),
        "curve_length": {("Top", "F1"): _oblique_arc(radius, slope, ends)},
        "n_curve": 1,
        "closed": False,
    }
    formula = (
        f"Top: z = {depth:g} + {slope!r} (y - 1500); F1: x = {east:g} - sqrt({radius:g}^2 - "
        f"(z + {-top:g})^2); box {box}; all in metres before the offset. Volumes by the "
        "antiderivatives of the circle, once and twice; the curve is an arc of an ellipse, its "
        "length a Gauss quadrature of a smooth integrand."
    )
    height = make_horizon("Top", box, n, lambda x, y: depth + slope * (y - 1500.0) + 0 * x, offset)

    # even steps of the angle: the same error of the chord everywhere; the arc ends 50 m below the
    # box
    angle = np.linspace(0.0, math.asin(min(0.99, (50.0 - bottom) / radius)), n)
    down = -radius * np.sin(angle)[:, None]
    along = np.linspace(box[2] - 100.0, box[3] + 100.0, max(2, n // 2))[None, :]
    fault = make_fault("F1", arc(down), along, down + top, offset)
    return World("listric", {"Top": height}, {"F1": fault}, shifted(box, offset), truth, formula)


def _split_by_fault(
    whole: float, below: float, foot: float, foot_below: float
) -> dict[str, dict[Any, float]]:
    """Volumes of the units and zones of one horizon and one fault.

    Of the box, of what is below the horizon, and of the parts of both in the footwall.
    """
    volumes = {
        ("above Top", ("F1+",)): whole - foot - (below - foot_below),
        ("above Top", ("F1-",)): foot - foot_below,
        ("below Top", ("F1+",)): below - foot_below,
        ("below Top", ("F1-",)): foot_below,
    }
    return {"volumes": volumes, "zone_volumes": {"above Top": whole - below, "below Top": below}}


def _circle_integrals(radius: float) -> tuple[Callable[[float], float], Callable[[float], float]]:
    """First and second antiderivative of ``sqrt(radius^2 - u^2)``."""

    def first(u: float) -> float:
        """Integral of the root."""
        return 0.5 * (u * math.sqrt(radius**2 - u**2) + radius**2 * math.asin(u / radius))

    def second(u: float) -> float:
        """Integral of `first`."""
        root = math.sqrt(radius**2 - u**2)
        return -(root**3) / 6 + 0.5 * radius**2 * (u * math.asin(u / radius) + root)

    return first, second


def _oblique_arc(radius: float, slope: float, ends: list[float]) -> float:
    """Length of the arc that a plane of this slope along the axis cuts from a cylinder."""
    # the curve by the angle on the circle: a smooth integrand, for which 60 points reach rounding
    low, high = (math.asin(u / radius) for u in ends)
    node, weight = np.polynomial.legendre.leggauss(60)
    angle = 0.5 * (low + high) + 0.5 * (high - low) * node
    speed = np.sqrt(radius**2 + (radius * np.cos(angle) / slope) ** 2)
    return float(0.5 * (high - low) * (weight * speed).sum())


# ---- hills ----------------------------------------
# Noisy hills of any size, cut by one or many faults, and waves whose curve is known everywhere.


# ---- rough ----------------------------------------
# Noise on planes: what is known are bounds.


@checked
def noisy(n: int = 33, *, amplitude: float = 5.0, seed: int = 0, offset: Offset = _ORIGIN) -> World:
    """`tilted_planes` with noise on every node of the horizons.

    Noise is a hash of row, column and seed: the same on every machine and for
    every version of numpy.

    Parameters
    ----------
    n : int
        Nodes per side of each horizon.
    amplitude : float
        Largest deviation of a node [m]; less than 40, so that horizons keep their order.
    seed : int
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        `truth` has ``"volume_bounds"`` and the volumes of the planes without noise.

    Raises
    ------
    InputError
        If the amplitude is not between 0 and 40 m.

    Examples
    --------
    >>> world = noisy(n=9)
    >>> low, high = world.truth["volume_bounds"]["Top/Base", ("F1+",)]
    >>> low < world.truth["volumes"]["Top/Base", ("F1+",)] < high
    True
    """
    if not 0 <= amplitude < 40:
        raise InputError(f"amplitude is {amplitude} m, expected 0 or more and less than 40.")
    plain = tilted_planes(n, offset=offset)
    horizons = {
        # streams of horizons differ by row; 8 leaves room for so many horizons per seed
        key: da + amplitude * hashed_noise(da.shape, (8 * int(seed) + row) % 2**63)
        for row, (key, da) in enumerate(plain.horizons.items())
    }

    for key, da in horizons.items():
        da.attrs.update(plain.horizons[key].attrs)
    west, east, south, north, _, _ = plain.box
    # A node moves a volume by less than amplitude times footprint; inner zones have two horizons.
    slack = amplitude * (east - west) * (north - south)
    bounds = {}
    for (zone, sides), value in plain.truth["volumes"].items():
        moved = slack * (1 if zone.startswith(("above", "below")) else 2)
        bounds[zone, sides] = (max(0.0, value - moved), value + moved)
    truth = {"volumes": plain.truth["volumes"], "volume_bounds": bounds}
    formula = (
        f"{plain.formula} Each node is then moved by up to {amplitude:g} m (a hash of row, column "
        "and seed), so no volume differs by more than that times the footprint, per horizon."
    )
    return World("noisy", horizons, plain.faults, plain.box, truth, formula)


def hashed_noise(shape: tuple[int, ...], seed: int) -> np.ndarray:
    """Return values in [-1, 1), a hash (splitmix64) of position and seed.

    Examples
    --------
    >>> bool(np.abs(hashed_noise((50, 50), 7)).max() < 1.0)
    True
    """
    # splitmix64 (Steele et al. 2014); the upper 53 bits become a float in [0, 1).
    word = np.arange(math.prod(shape), dtype=np.uint64) + (np.uint64(seed % 2**24) << np.uint64(40))
    word = (word + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        word = (word ^ (word >> np.uint64(shift))) * np.uint64(factor)
    word ^= word >> np.uint64(31)
    unit = (word >> np.uint64(11)).astype(np.float64) * 2.0**-53
    return (2.0 * unit - 1.0).reshape(shape)


_SIDE = 10_000.0
_BOX = (0.0, _SIDE, 0.0, _SIDE, -2700.0, -1300.0)
_LAYER = 220.0  # thickness between horizons [m]
_SPACING = 370.0  # between faults [m]
_TURN = 2.0 * math.pi


@checked
def hills(
    n: int = 41,
    *,
    n_fault: int | None = None,
    faults: int = 1,
    horizons: int = 1,
    shape: str = "listric",
    noise: float = 0.2,
    offset: Offset = (0.0, 0.0, 0.0),
) -> World:
    """Hills of 10 by 10 km with hashed noise, cut right through by one fault or a row of them.

    No two nodes are alike, and a grid of any size is the same surface: made for measuring how cost
    grows. The horizons do not cross, and neither do the faults.

    Parameters
    ----------
    n : int
        Nodes per side of each horizon.
    n_fault : int, optional
        Nodes per side of each fault. Default: half of `n`, which gives one listric fault a fifth
        of all triangles. A plane has 2 x 2 nodes: two triangles.
    faults : int
        0 to 20, side by side.
    horizons : int
        1 to 3, one over the other.
    shape : {"listric", "plane"}
        Of the faults: a sinuous sheet that flattens with depth, or one plane.
    noise : float
        Added to the horizons: at most so much up or down [m], 0 to 10.
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        Horizons ``H1``, ``H2`` ..., youngest first; faults ``F1``, ``F2`` ..., from west to
        east. `truth` has ``"n_curve"`` and ``"closed"``.

    Raises
    ------
    InputError
        If a number is out of range or the shape unknown.

    Examples
    --------
    >>> world = hills(21, faults=3)
    >>> list(world.horizons), list(world.faults), world.truth["n_curve"]
    (['H1'], ['F1', 'F2', 'F3'], 3)
    """
    # half the nodes per side, a quarter of the triangles
    m = max(n // 2, 2) if n_fault is None else n_fault
    _check(m, faults, horizons, shape, noise)
    heights = {}
    for layer in range(horizons):
        name = f"H{layer + 1}"
        heights[name] = make_horizon(name, _BOX, n, _height_of(layer, n, noise), offset)

    sheets = {}
    for k in range(faults):
        # the row of faults is centred
        east = _SPACING * (k - 0.5 * (faults - 1))
        make = _plane if shape == "plane" else _sheet
        sheets[f"F{k + 1}"] = make(f"F{k + 1}", m, east, offset)

    truth = {"n_curve": horizons * faults, "closed": False}
    formula = (
        "Three waves of 50 to 130 m height and 1.7 to 7.3 km length over a datum of -2000 m, "
        f"{_LAYER:g} m between horizons, with hashed noise of {noise:g} m; faults strike about "
        "north and dip east. Made for measuring; curves and volumes have no closed form."
    )
    return World("hills", heights, sheets, shifted(_BOX, offset), truth, formula)


def _check(m: int, faults: int, horizons: int, shape: str, noise: float) -> None:
    check_count(m, "n_fault of the world 'hills'")
    if m < 2:
        raise InputError(f"n_fault is {m}: a fault needs two nodes per side. Give 2 or more.")
    if not 0 <= faults <= 20:
        raise InputError(f"faults is {faults}, expected 0 to 20, so that they fit side by side.")
    if not 1 <= horizons <= 3:
        raise InputError(f"horizons is {horizons}, expected 1 to 3, so that they fit the box.")
    check_word(shape, ("listric", "plane"), f"shape is {shape!r}, expected 'listric' or 'plane'.")
    if not 0 <= noise <= 10:
        raise InputError(f"noise is {noise} m, expected 0 to 10.")


def _height_of(layer: int, n: int, noise: float) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """The height of one horizon as a function of x and y."""
    return lambda x, y: _height(x, y) - _LAYER * layer + _rough(n, layer, noise)


def _height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Elevation of the first horizon [m]."""
    broad = 130.0 * np.sin(_TURN * x / 7300.0 + 0.3) * np.cos(_TURN * y / 5900.0)
    middle = 80.0 * np.sin(_TURN * (x + 0.7 * y) / 3100.0 + 1.1)
    small = 50.0 * np.cos(_TURN * (y - 0.4 * x) / 1700.0)
    return broad + middle + small - 2000.0


def _rough(n: int, layer: int, noise: float) -> np.ndarray | float:
    return noise * hashed_noise((n, n), layer) if noise else 0.0


def _sheet(name: str, m: int, east: float, offset: Offset) -> xarray.Dataset:
    """A listric fault from 1200 to 2800 m depth: 70 degrees at its top, 58 at its foot."""
    top, foot = -1200.0, -2800.0
    t = np.linspace(0.0, 1.0, m)[:, None]

    # beyond the box by unlike amounts, so that no lines of the two grids lie over each other
    y = np.linspace(-517.0, _SIDE + 531.0, m)[None, :]
    # the dip's cotangent grows linearly with depth; its integral is the heave
    steep, gentle = (1.0 / math.tan(math.radians(dip)) for dip in (70.0, 58.0))
    heave = (top - foot) * (steep * t + 0.5 * (gentle - steep) * t * t)

    trace = 420.0 * np.sin(_TURN * y / 8700.0 + 0.5) + 60.0 * np.sin(_TURN * y / 2300.0)
    x = 4300.0 + east + 0.11 * y + trace + heave * (1.0 + 0.08 * np.sin(_TURN * y / 6100.0))
    return make_fault(name, x, y, top + (foot - top) * t, offset)


def _plane(name: str, m: int, east: float, offset: Offset) -> xarray.Dataset:
    """A plane of two triangles: strike 7.3 degrees, dip 65."""
    strike, dip = math.radians(7.3), math.radians(65.0)

    # s runs along strike, d down dip [m].
    s = np.array([[-7500.0, 7500.0], [-7500.0, 7500.0]])
    d = np.array([[-1500.0, -1500.0], [1500.0, 1500.0]])
    x = 5013.7 + east + s * math.sin(strike) + d * math.cos(strike) * math.cos(dip)
    y = 5002.3 + s * math.cos(strike) - d * math.sin(strike) * math.cos(dip)
    return make_fault(name, x, y, -2000.0 - d * math.sin(dip), offset)


_WAVY_BOX = (0.0, 4000.0, 0.0, 3000.0, -2800.0, -1000.0)
_RADIUS, _AXIS = 2500.0, -800.0  # of the fault in section, and the elevation of its centre


@checked
def waves(n: int = 33, *, offset: Offset = (0.0, 0.0, 0.0)) -> World:
    """A wavy horizon and a listric fault with a wavy strike, both smooth.

    In section the fault is an arc of a circle whose centre moves with the northing. Neither
    surface holds a straight line across the other, so that the error of triangles shows.

    Parameters
    ----------
    n : int
        Nodes per side of the horizon and of the fault.
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        Horizon ``Top``, fault ``F1`` dipping east. ``truth["curve_at"]`` has a function from
        northings (with the offset) to points (n, 3) of the true curve.

    Examples
    --------
    >>> world = waves(n=17)
    >>> world.truth["curve_at"]["Top", "F1"]([0.0, 1500.0, 3000.0]).shape
    (3, 3)
    """
    shift = np.asarray(offset, dtype=np.float64)

    def curve_at(northing: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the curve at some northings."""
        return _curve(np.asarray(northing, dtype=np.float64) - shift[1]) + shift

    pair = ("Top", "F1")
    truth = {
        **_volumes(),
        "curve_length": {pair: _curve_length()},
        "curve_at": {pair: curve_at},
        "n_curve": 1,
        "closed": False,
    }
    formula = (
        "Top: z = -1900 + 90 sin(x / 270 + 0.3) cos(y / 370) + 40 cos((y - 0.4 x) / 330); F1: "
        f"x = e(y) - sqrt({_RADIUS:g}^2 - (z + {-_AXIS:g})^2), e(y) = 3700 + 0.2 (y - 1500) + 120 "
        "sin(y / 366); in metres before the offset. The curve is found by Newton's "
        "method at each northing, its length and all volumes by Gauss quadrature."
    )
    height = make_horizon("Top", _WAVY_BOX, n, _wavy_height, offset)
    angle = np.linspace(math.asin(150.0 / _RADIUS), math.asin(2050.0 / _RADIUS), n)[:, None]
    # past the box by unlike amounts, so that no lines of the two grids lie over each other
    y = np.linspace(_WAVY_BOX[2] - 87.3, _WAVY_BOX[3] + 104.1, n)[None, :]
    x = _centre(y) - _RADIUS * np.cos(angle)
    fault = make_fault("F1", x, y, _AXIS - _RADIUS * np.sin(angle), offset)
    return World(
        "waves", {"Top": height}, {"F1": fault}, shifted(_WAVY_BOX, offset), truth, formula
    )


def _wavy_height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Elevation of Top [m]."""
    wave = 90.0 * np.sin(x / 270.0 + 0.3) * np.cos(y / 370.0)
    return -1900.0 + wave + 40.0 * np.cos((y - 0.4 * x) / 330.0)


def _slope_east(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Change of `_wavy_height` with x."""
    wave = 90.0 / 270.0 * np.cos(x / 270.0 + 0.3) * np.cos(y / 370.0)
    return wave + 40.0 * 0.4 / 330.0 * np.sin((y - 0.4 * x) / 330.0)


def _centre(y: np.ndarray) -> np.ndarray:
    """Easting of the axis of the arc."""
    return 3700.0 + 0.2 * (y - 1500.0) + 120.0 * np.sin(y / 366.0)


def _east_of(z: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Easting of F1."""
    return _centre(y) - np.sqrt(_RADIUS**2 - (z - _AXIS) ** 2)


def _curve(y: np.ndarray) -> np.ndarray:
    """Points of the true curve, one for each y."""
    z = np.full(y.shape, -1900.0)
    # the fault is steeper than the horizon everywhere, so that this has one root
    for _ in range(40):
        x = _east_of(z, y)

        # dx/dz of the arc; Newton's method for z(x(z, y), y)
        lean = (z - _AXIS) / np.sqrt(_RADIUS**2 - (z - _AXIS) ** 2)
        step = (z - _wavy_height(x, y)) / (1.0 - _slope_east(x, y) * lean)
        z = z - step
        if np.abs(step).max(initial=0.0) < 1e-12:
            break
    return np.stack([_east_of(z, y), y, z], axis=-1)


def _gauss(
    low: np.ndarray | float, high: np.ndarray | float, panels: int
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of panels of 16 nodes each; the last axis runs along the nodes."""
    node, weight = np.polynomial.legendre.leggauss(16)
    at = (np.arange(panels)[:, None] + 0.5 * (node + 1.0)).ravel() / panels
    length = (np.asarray(high) - np.asarray(low))[..., None]
    return np.asarray(low)[..., None] + length * at, length * np.tile(weight, panels) / (2 * panels)


def _curve_length() -> float:
    y, weight = _gauss(_WAVY_BOX[2], _WAVY_BOX[3], 30)
    step = 1e-2
    ahead, behind = _curve(y + step), _curve(y - step)
    # a central difference of fourth order
    far, back = _curve(y + 2.0 * step), _curve(y - 2.0 * step)
    speed = (8.0 * (ahead - behind) - (far - back)) / (12.0 * step)
    return float((weight * np.linalg.norm(speed, axis=-1)).sum())


def _volumes() -> dict[str, dict]:
    """Volumes of the four units, and of the two zones."""
    # slices at constant northing, integrated by Gauss panels across; parts meet at the curve
    w, e, s, n, b, t = _WAVY_BOX
    y, across = _gauss(s, n, 12)
    meet = _curve(y)[:, 0]
    foot = _east_of(np.full_like(y, b), y)
    z, up = _gauss(b, t, 8)
    beside = (_east_of(z[None, :], y[:, None]) * up).sum(axis=1)  # west of F1, whole height
    x, along = _gauss(np.full_like(y, w), meet, 8)
    below_west = ((_wavy_height(x, y[:, None]) - b) * along).sum(axis=1)

    # between the curve and the foot of the fault the fault is the upper bound
    x, along = _gauss(meet, foot, 8)
    fault = _AXIS - np.sqrt(_RADIUS**2 - (_centre(y)[:, None] - x) ** 2)
    below_west += ((fault - b) * along).sum(axis=1)
    x, along = _gauss(np.full_like(y, w), np.full_like(y, e), 16)
    below = ((_wavy_height(x, y[:, None]) - b) * along).sum(axis=1)
    below_west, below, beside = (
        float((part * across).sum()) for part in (below_west, below, beside)
    )

    # the four units by differences from these integrals
    return _split_by_fault((e - w) * (n - s) * (t - b), below, beside, below_west)
