"""A faulted field to look at: domed horizons as a gridder leaves them, three normal faults.

Each wall of a fault has a smooth height of its own, and the horizon between its two cut-offs is
the fault itself: of the heights of footwall, fault and hanging wall, a map shows the middle one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.synthetic.world import Offset, World, checked, make_fault, make_horizon, shifted

_BOX = (0.0, 6000.0, 0.0, 5000.0, -2700.0, -1900.0)
_DATUM = -2250.0
# height over the sea before faulting, and how much of the relief it has
_LEVELS = {"Top": (-2150.0, 1.0), "Middle": (-2260.0, 0.95), "Base": (-2390.0, 0.85)}
_MOST = 150.0  # throw of F1 in its middle [m]


@dataclass(frozen=True)
class _SmallFault:
    """A plane that dies inside: centre at the datum, strike with the dip to its right."""

    x: float
    y: float
    strike: float
    dip: float
    half: float
    throw: float

    def along_across(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates along strike, and across it to the right (down dip)."""
        a = math.radians(self.strike)
        # Strike is clockwise from north; the second coordinate points to the right of it.
        dx, dy = x - self.x, y - self.y
        return dx * math.sin(a) + dy * math.cos(a), dx * math.cos(a) - dy * math.sin(a)

    def elevation(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Of the plane, at places in the map."""
        return _DATUM - self.along_across(x, y)[1] * math.tan(math.radians(self.dip))

    def moved(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far the hanging wall has gone down and the footwall up."""
        s, c = self.along_across(x, y)
        # Throw falls smoothly to 0 at the tips (|s| = half) and away from the fault (200 m on).
        profile = np.clip(1.0 - (s / self.half) ** 2, 0.0, None) ** 1.5
        away = np.exp(-((np.maximum(np.abs(c) - 200.0, 0.0) / 700.0) ** 2))
        half = 0.5 * self.throw * profile * away
        return half, half


class _MainFault:
    """F1: through the whole field, 63 degrees at the datum, flatter below."""

    def easting(self, y: np.ndarray, z: np.ndarray | float) -> np.ndarray:
        """Of F1 at a northing and an elevation."""
        # x of the fault over depth: steep at first, with a curvature that makes it flatten
        down = _DATUM - z
        return 2350.0 + 330.0 * np.sin(math.pi * y / 5000.0) + 0.51 * down + 2.5e-4 * down**2

    def elevation(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The inverse of `easting`; where F1 would turn vertical again, its highest point."""
        # the same parabola solved for depth
        past = x - self.easting(y, _DATUM)
        return _DATUM - (np.sqrt(np.maximum(0.51**2 + 1e-3 * past, 0.0)) - 0.51) / 5e-4

    def moved(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far the hanging wall has gone down; the footwall stays."""
        # throw fades 300 m beyond the fault in the hanging wall only: the footwall stays
        past = np.maximum(x - self.easting(y, _DATUM) - 300.0, 0.0)
        along = 0.75 + 0.25 * np.sin(math.pi * y / 5000.0)
        return _MOST * along * np.exp(-((past / 4500.0) ** 2)), np.zeros_like(past)


_FAULTS: dict[str, _SmallFault | _MainFault] = {
    "F2": _SmallFault(4300.0, 2700.0, 20.0, 65.0, 1300.0, 110.0),
    "F3": _SmallFault(1150.0, 0.0, 188.0, 62.0, 2300.0, 90.0),
    "F1": _MainFault(),  # the youngest comes last
}


@checked
def faulted_reservoir(
    n: int = 121, *, throw: float = _MOST, smear: int = 1, offset: Offset = (0.0, 0.0, 0.0)
) -> World:
    """A faulted field: three domed horizons, one fault right across, two that die inside.

    F1 crosses the model with a curved trace and flattens with depth. F2 lies
    inside the model. F3 enters from the south and dies inside. Horizons are grids as they are
    picked: dragged over the faults, one value per node, for `tear_horizon` to rebuild.

    Parameters
    ----------
    n : int
        Nodes per side of each horizon.
    throw : float
        Throw of F1 in the middle of the model [m], 0 to 200; F2 and F3 have less, in proportion.
    smear : int
        A node is the mean of all that are at most this many nodes away on either axis; 0: none.
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        Horizons ``Top``, ``Middle``, ``Base``; faults ``F1``, ``F2``, ``F3``. `truth` has
        ``"box_volume"``; ``"splits"``: whether a fault divides the model by itself; and
        ``"wall_at"``: elevation of a wall of F1, before smearing, at places in the map.

    Raises
    ------
    InputError
        If throw or smear are out of range.

    Examples
    --------
    >>> world = faulted_reservoir(n=25)
    >>> list(world.faults), world.truth["splits"]["F2"]
    (['F1', 'F2', 'F3'], False)
    """
    if not 0 <= throw <= 200:
        raise InputError(f"throw is {throw} m, expected 0 to 200.")
    if not 0 <= smear <= 5 or smear != int(smear):
        raise InputError(f"smear is {smear}, expected a whole number of nodes, 0 to 5.")

    # one factor for all faults, so that their proportions hold
    share = throw / _MOST
    horizons = {
        name: make_horizon(name, _BOX, n, _smeared(name, share, int(smear), n), offset)
        for name in _LEVELS
    }
    w, e, s, north, b, t = _BOX
    truth = {
        "box_volume": (e - w) * (north - s) * (t - b),
        "splits": {"F1": True, "F2": False, "F3": False},
        "wall_at": {
            (name, f"F1{sign}"): partial(_wall, name, share, sign, offset)
            for name in _LEVELS
            for sign in "+-"
        },
    }
    formula = (
        "Three horizons: a broad dome, a smaller one and a gentle tilt, lowered on the hanging "
        "walls of F1 (throughgoing, dipping east), F2 (inside) and F3 (from the south). Grids as "
        "they are picked: between the cut-offs they lie on the fault, and each node is the mean of "
        f"all within {smear:g}. For pictures; only `truth` is known exactly."
    )
    box = shifted(_BOX, offset)
    return World("faulted_reservoir", horizons, _faults(n, offset), box, truth, formula)


def _smeared(name: str, share: float, smear: int, n: int) -> Callable[..., np.ndarray]:
    """Heights of a horizon, as the means of its neighbours."""
    dx, dy = (_BOX[1] - _BOX[0]) / max(n - 1, 1), (_BOX[3] - _BOX[2]) / max(n - 1, 1)
    steps = range(-smear, smear + 1)

    def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The mean; neighbours outside of the box count, too."""
        # formula values at the nodes around, also beyond the rim of the grid: no edge effect
        around = [_picked(name, share, x + i * dx, y + j * dy) for i in steps for j in steps]
        return np.mean(around, axis=0)

    return height


def _picked(
    name: str, share: float, x: np.ndarray, y: np.ndarray, faults: tuple[str, ...] = tuple(_FAULTS)
) -> np.ndarray:
    """Height of a horizon at places in the map: of both walls and the fault, the middle one."""
    level, part = _LEVELS[name]

    z = level + part * _relief(x, y)
    for fault in (_FAULTS[key] for key in faults):
        down, up = fault.moved(x, y)
        # The middle of fault and both walls: the horizon lies on the fault between its cut-offs.
        z = np.clip(fault.elevation(x, y), z - share * down, z + share * up)
    return z


def _wall(
    name: str, share: float, sign: str, offset: Offset, easting: np.ndarray, northing: np.ndarray
) -> np.ndarray:
    """Elevation of a horizon on one wall of F1, as if that wall went on for ever."""
    # places come in the world, formulas are before the offset
    x, y = np.asarray(easting) - offset[0], np.asarray(northing) - offset[1]

    # F1 last: it is the youngest, so its movement adds to the other two
    down, _ = _FAULTS["F1"].moved(x, y)
    drop = share * down if sign == "+" else 0.0
    return _picked(name, share, x, y, ("F2", "F3")) - drop + offset[2]


def _relief(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the structure over its datum [m]."""
    # A broad dome, a shoulder, a regional tilt and a ripple, all in metres.
    dome = 110.0 * np.exp(-(((x - 3300.0) / 2100.0) ** 2) - ((y - 2500.0) / 1700.0) ** 2)
    shoulder = 35.0 * np.exp(-(((x - 1100.0) / 900.0) ** 2) - ((y - 3600.0) / 1000.0) ** 2)
    tilt = -0.008 * (x - 3000.0) + 0.004 * (y - 2500.0)
    ripple = 6.0 * np.sin(x / 640.0 + 0.4) * np.cos(y / 710.0)
    return dome + shoulder + tilt + ripple


def _faults(n: int, offset: Offset) -> dict[str, xarray.Dataset]:
    """F1, past the box on all sides, and those that die inside."""
    # 150 m beyond the box along strike, 60 m up and down: the fault leaves the box
    y = np.linspace(_BOX[2] - 150.0, _BOX[3] + 150.0, max(n // 3, 9))[None, :]
    z = np.linspace(_BOX[5] + 60.0, _BOX[4] - 60.0, max(n // 6, 5))[:, None]
    faults = {"F1": make_fault("F1", _MainFault().easting(y, z), y, z, offset)}
    for key, fault in _FAULTS.items():
        if isinstance(fault, _SmallFault):
            faults[key] = _small_fault(key, fault, max(n // 5, 7), offset)
    return faults


def _small_fault(key: str, fault: _SmallFault, n: int, offset: Offset) -> xarray.Dataset:
    """A plane that dies out: less high towards its tips, taller than what it cuts."""
    # Along strike from tip to tip; the upper and lower rims come closer towards the tips.
    s = np.linspace(-fault.half, fault.half, n)[None, :]
    tall = 1.0 - 0.25 * (s / fault.half) ** 2
    z = _DATUM + tall * np.linspace(400.0, -400.0, max(n // 2, 5))[:, None]

    # Down dip, the plane moves away from the strike line by depth over tangent.
    c = (_DATUM - z) / math.tan(math.radians(fault.dip))
    a = math.radians(fault.strike)
    x = fault.x + s * math.sin(a) + c * math.cos(a)
    y = fault.y + s * math.cos(a) - c * math.sin(a)
    return make_fault(key, x, y, z, offset)
