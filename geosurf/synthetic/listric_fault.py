"""A listric fault through a tilted plane: an arc of a circle, pulled along strike."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from geosurf.errors import InputError
from geosurf.synthetic.world import Offset, World, checked, make_fault, make_horizon, shifted

_ORIGIN = (0.0, 0.0, 0.0)


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
