"""Domes cut by a flat surface, with closed curves, and a plane cut by a listric fault."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.errors import InputError
from geosurf.synthetic.world import Box, Offset, World, checked, make_fault, make_horizon, shifted

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

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
    truth = _split_by_level(box, "Flat", level, footprint * (mean - box[4]), cap)
    truth |= {"curve_length": {("Top", "Flat"): ellipse_length(a, b)}, "n_curve": 1, "closed": True}
    formula = (
        f"Top: z = {crest:g} - {height:g} (((x - 2000) / {a:g})^2 + ((y - 2000) / {b:g})^2); "
        f"Flat: z = {level:g}; box {box}; all in metres before the offset. They meet in an ellipse "
        f"with semi-axes {a:g} and {b:g}; the cap above it holds pi a b h / 2."
    )

    horizons = {"Top": make_horizon("Top", box, n, dome, offset)}
    faults = {"Flat": _flat("Flat", box, level, n, offset)}
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
    truth = _split_by_level(box, "Flat", flat, side**2 * (middle - box[4]), caps)
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
    faults = {"Flat": _flat("Flat", box, flat, n, offset)}
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


def _split_by_level(box: Box, name: str, level: float, below: float, cap: float) -> dict[str, Any]:
    """Volumes of two zones over and under a flat surface.

    `below` is the volume under the horizon, `cap` the part of it over the surface.
    """
    footprint = (box[1] - box[0]) * (box[3] - box[2])

    # the surface splits the box; the cap is what of the lower zone lies above it
    under = footprint * (level - box[4])
    whole = footprint * (box[5] - box[4])
    return {
        "volumes": {
            ("above Top", (f"{name}+",)): whole - under - cap,
            ("above Top", (f"{name}-",)): under - (below - cap),
            ("below Top", (f"{name}+",)): cap,
            ("below Top", (f"{name}-",)): below - cap,
        },
        "zone_volumes": {"above Top": whole - below, "below Top": below},
    }


def _flat(name: str, box: Box, level: float, n: int, offset: Offset) -> xarray.Dataset:
    """A flat fault, 100 m larger than the box, its nodes beside those of the horizon."""
    # a flat surface needs few nodes, and 100 m beyond the box so that it cuts the four sides
    size = max(2, n // 3)
    x = np.linspace(box[0] - 100.0, box[1] + 100.0, size)[None, :]
    y = np.linspace(box[3] + 100.0, box[2] - 100.0, size)[:, None]
    return make_fault(name, x, y, np.full((size, size), level), offset)


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

    volumes = {
        ("above Top", ("F1+",)): whole - foot - (below - foot_below),
        ("above Top", ("F1-",)): foot - foot_below,
        ("below Top", ("F1+",)): below - foot_below,
        ("below Top", ("F1-",)): foot_below,
    }
    truth = {
        "volumes": volumes,
        "zone_volumes": {"above Top": whole - below, "below Top": below},
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
