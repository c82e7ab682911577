"""A smooth wavy horizon and a smooth curved fault: the true curve at every northing."""

from __future__ import annotations

import math

import numpy as np

from geosurf.synthetic.world import Offset, World, checked, make_fault, make_horizon, shifted

_BOX = (0.0, 4000.0, 0.0, 3000.0, -2800.0, -1000.0)
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
    height = make_horizon("Top", _BOX, n, _height, offset)
    angle = np.linspace(math.asin(150.0 / _RADIUS), math.asin(2050.0 / _RADIUS), n)[:, None]
    # past the box by unlike amounts, so that no lines of the two grids lie over each other
    y = np.linspace(_BOX[2] - 87.3, _BOX[3] + 104.1, n)[None, :]
    x = _centre(y) - _RADIUS * np.cos(angle)
    fault = make_fault("F1", x, y, _AXIS - _RADIUS * np.sin(angle), offset)
    return World("waves", {"Top": height}, {"F1": fault}, shifted(_BOX, offset), truth, formula)


def _height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Elevation of Top [m]."""
    wave = 90.0 * np.sin(x / 270.0 + 0.3) * np.cos(y / 370.0)
    return -1900.0 + wave + 40.0 * np.cos((y - 0.4 * x) / 330.0)


def _slope_east(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Change of `_height` with x."""
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
        step = (z - _height(x, y)) / (1.0 - _slope_east(x, y) * lean)
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
    y, weight = _gauss(_BOX[2], _BOX[3], 30)
    step = 1e-2
    ahead, behind = _curve(y + step), _curve(y - step)
    # a central difference of fourth order
    far, back = _curve(y + 2.0 * step), _curve(y - 2.0 * step)
    speed = (8.0 * (ahead - behind) - (far - back)) / (12.0 * step)
    return float((weight * np.linalg.norm(speed, axis=-1)).sum())


def _volumes() -> dict[str, dict]:
    """Volumes of the four units, and of the two zones."""
    # slices at constant northing, integrated by Gauss panels across; parts meet at the curve
    w, e, s, n, b, t = _BOX
    y, across = _gauss(s, n, 12)
    meet = _curve(y)[:, 0]
    foot = _east_of(np.full_like(y, b), y)
    z, up = _gauss(b, t, 8)
    beside = (_east_of(z[None, :], y[:, None]) * up).sum(axis=1)  # west of F1, whole height
    x, along = _gauss(np.full_like(y, w), meet, 8)
    below_west = ((_height(x, y[:, None]) - b) * along).sum(axis=1)

    # between the curve and the foot of the fault the fault is the upper bound
    x, along = _gauss(meet, foot, 8)
    fault = _AXIS - np.sqrt(_RADIUS**2 - (_centre(y)[:, None] - x) ** 2)
    below_west += ((fault - b) * along).sum(axis=1)
    x, along = _gauss(np.full_like(y, w), np.full_like(y, e), 16)
    below = ((_height(x, y[:, None]) - b) * along).sum(axis=1)
    below_west, below, beside = (
        float((part * across).sum()) for part in (below_west, below, beside)
    )

    # the four units by differences from these integrals
    whole = (e - w) * (n - s) * (t - b)
    volumes = {
        ("above Top", ("F1+",)): whole - beside - (below - below_west),
        ("above Top", ("F1-",)): beside - below_west,
        ("below Top", ("F1+",)): below - below_west,
        ("below Top", ("F1-",)): below_west,
    }
    zones = {"above Top": whole - below, "below Top": below}
    return {"volumes": volumes, "zone_volumes": zones}
