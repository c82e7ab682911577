"""A faulted field to look at: domed horizons, three normal faults."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from geosurf.errors import InputError
from geosurf.synthetic.world import Offset, World, make_fault, make_horizon, shifted

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

_BOX = (0.0, 6000.0, 0.0, 5000.0, -2700.0, -1900.0)
_DATUM = -2250.0
# name: centre x, y at the datum; strike, clockwise from north, dip to its right; dip;
# half length; throw at the centre
_SMALL_FAULTS = {
    "F2": (4300.0, 2700.0, 20.0, 65.0, 1300.0, 45.0),
    "F3": (1150.0, 0.0, 188.0, 62.0, 2300.0, 35.0),
}


def faulted_reservoir(
    n: int = 121, *, throw: float = 60.0, drag: float = 70.0, offset: Offset = (0.0, 0.0, 0.0)
) -> World:
    """A faulted field: three domed horizons, one fault right across, two that die inside.

    F1 crosses the model with a curved trace and flattens with depth. F2 lies
    inside the model. F3 enters from the south and dies inside. The horizons are lowered on
    the hanging walls, smoothly over the width `drag`, as gridding smears them.

    Parameters
    ----------
    n : int
        Nodes per side of each horizon.
    throw : float
        Throw of F1 in the middle of the model [m], 0 to 60; F2 and F3 have less, in proportion.
    drag : float
        Half width over which a horizon bends at a fault [m]; 0: a step between two nodes.
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        Horizons ``Top``, ``Middle``, ``Base``; faults ``F1``, ``F2``, ``F3``. `truth` has
        ``"box_volume"`` and ``"splits"``: whether a fault divides the model by itself.

    Raises
    ------
    InputError
        If the throw is out of range or the drag negative.

    Examples
    --------
    >>> world = faulted_reservoir(n=25)
    >>> list(world.faults), world.truth["splits"]["F2"]
    (['F1', 'F2', 'F3'], False)
    """
    if not 0 <= throw <= 60:
        raise InputError(f"throw is {throw} m, expected 0 to 60, so that horizons keep order.")
    if drag < 0:
        raise InputError(f"drag is {drag} m, expected 0 or more.")
    levels = {"Top": (-2150.0, 1.0), "Middle": (-2260.0, 0.95), "Base": (-2390.0, 0.85)}
    horizons = {
        key: make_horizon(
            key,
            _BOX,
            n,
            lambda x, y, z=z, part=part: z + part * _relief(x, y) - _lowering(x, y, z, throw, drag),
            offset,
        )
        for key, (z, part) in levels.items()
    }
    faults = {"F1": _main_fault(max(n // 3, 9), offset)}
    for key in _SMALL_FAULTS:
        faults[key] = _small_fault(key, max(n // 5, 7), offset)
    w, e, s, north, b, t = _BOX
    truth = {
        "box_volume": (e - w) * (north - s) * (t - b),
        "splits": {"F1": True, "F2": False, "F3": False},
    }
    formula = (
        "Three horizons: a broad dome, a smaller one and a gentle tilt, lowered on the hanging "
        "walls of F1 (throughgoing, dipping east), F2 (inside) and F3 (from the south), each "
        f"smeared over {drag:g} m. Made to look at; only what `truth` says is known."
    )
    box = shifted(_BOX, offset)
    return World("faulted_reservoir", horizons, faults, box, truth, formula)


def _relief(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the structure over its datum [m]."""
    dome = 110.0 * np.exp(-(((x - 3300.0) / 2100.0) ** 2) - ((y - 2500.0) / 1700.0) ** 2)
    shoulder = 35.0 * np.exp(-(((x - 1100.0) / 900.0) ** 2) - ((y - 3600.0) / 1000.0) ** 2)
    tilt = -0.008 * (x - 3000.0) + 0.004 * (y - 2500.0)
    ripple = 6.0 * np.sin(x / 640.0 + 0.4) * np.cos(y / 710.0)
    return dome + shoulder + tilt + ripple


def _main_trace(y: np.ndarray, z: np.ndarray | float) -> np.ndarray:
    """Easting of F1 at northing and elevation: 63 degrees at the datum, flatter below."""
    depth = _DATUM - z
    return 2350.0 + 330.0 * np.sin(math.pi * y / 5000.0) + 0.51 * depth + 2.5e-4 * depth**2


def _lowering(x: np.ndarray, y: np.ndarray, z: float, throw: float, drag: float) -> np.ndarray:
    """How far faults have lowered a horizon near elevation `z` [m]."""
    past = x - _main_trace(y, z)
    along = 0.75 + 0.25 * np.sin(math.pi * y / 5000.0)
    total = throw * along * _step(past, drag) * np.exp(-((np.maximum(past, 0) / 4500.0) ** 2))
    for cx, cy, strike, dip, half, most in _SMALL_FAULTS.values():
        s, c = _along_across(x - cx, y - cy, strike)
        c = c - (_DATUM - z) / math.tan(math.radians(dip))
        profile = np.clip(1.0 - (s / half) ** 2, 0.0, None) ** 1.5
        side = _step(c, drag) - 0.5
        total = total + most * throw / 60.0 * profile * side * np.exp(-((c / 800.0) ** 2))
    return total


def _step(distance: np.ndarray, drag: float) -> np.ndarray:
    """0 in the footwall, 1 in the hanging wall."""
    if drag == 0:
        return np.where(distance > 0, 1.0, 0.0)
    return 0.5 * (1.0 + np.tanh(distance / drag))


def _along_across(dx: np.ndarray, dy: np.ndarray, strike: float) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates along strike, and across it to the right (down dip)."""
    a = math.radians(strike)
    return dx * math.sin(a) + dy * math.cos(a), dx * math.cos(a) - dy * math.sin(a)


def _main_fault(n: int, offset: Offset) -> xarray.Dataset:
    """F1, past the box on all sides."""
    y = np.linspace(_BOX[2] - 150.0, _BOX[3] + 150.0, n)[None, :]
    z = np.linspace(_BOX[5] + 60.0, _BOX[4] - 60.0, max(n // 2, 5))[:, None]
    return make_fault("F1", _main_trace(y, z), y, z, offset)


def _small_fault(key: str, n: int, offset: Offset) -> xarray.Dataset:
    """A plane that dies out: less high towards its tips."""
    cx, cy, strike, dip, half, _ = _SMALL_FAULTS[key]
    s = np.linspace(-half, half, n)[None, :]
    z = _DATUM + (1.0 - 0.6 * (s / half) ** 2) * np.linspace(330.0, -330.0, max(n // 2, 5))[:, None]
    c = (_DATUM - z) / math.tan(math.radians(dip))
    a = math.radians(strike)
    x = cx + s * math.sin(a) + c * math.cos(a)
    y = cy + s * math.cos(a) - c * math.sin(a)
    return make_fault(key, x, y, z, offset)
