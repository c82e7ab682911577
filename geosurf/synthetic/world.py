"""What a synthetic world is, and how its grids are made."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import wraps
from typing import Any, ParamSpec

import numpy as np
import xarray as xr

from geosurf.conventions import FAULT_DIMS, HORIZON_DIMS, is_number, is_whole
from geosurf.conventions.axes import COORDINATES
from geosurf.errors import InputError
from geosurf.model.expected import listed, number_of

Box = tuple[float, float, float, float, float, float]
Offset = tuple[float, float, float]
LARGEST = 20_000  # nodes per side: 3 GB for each grid


@dataclass(frozen=True, eq=False)
class World:
    """Horizons, faults and a box, with what is known about them.

    Attributes
    ----------
    name : str
    horizons : dict of str to xr.DataArray
        Youngest first; elevation [m], positive up.
    faults : dict of str to xr.Dataset
        `easting`, `northing`, `elevation` [m] over ``(down_dip, along_strike)``.
    box : (west, east, south, north, bottom, top)
        [m]
    truth : dict
        What is known; keys that a world cannot state are left out:

        - ``"volumes"``: ``{(zone, sides): m3}``, `sides` being one of
          ``("F1+",)``, ``("F1+", "F2-")`` ...: ``+`` is the side into which the
          fault's normal points. Pieces of one zone on the same sides are added up;
        - ``"zone_volumes"``: ``{zone: m3}``;
        - ``"volume_bounds"``: ``{(zone, sides): (low, high)}``;
        - ``"curve_length"``: ``{(horizon, fault): m}``, inside the box;
        - ``"curve_at"``: ``{(horizon, fault): function}`` from northings to points (n, 3) of
          the true curve;
        - ``"n_curve"``, ``"closed"``: number of curves between horizons and
          faults inside the box, and whether they are closed.
    formula : str
        The world in words and formulas.
    """

    name: str
    horizons: dict[str, xr.DataArray]
    faults: dict[str, xr.Dataset]
    box: Box
    truth: dict[str, Any] = field(default_factory=dict)
    formula: str = ""

    def __repr__(self) -> str:
        return (
            f"<World {self.name!r}: horizons {list(self.horizons)}, faults {list(self.faults)}, "
            f"known: {', '.join(self.truth) or 'nothing'}>"
        )


P = ParamSpec("P")


def check_numbers(value: Any, n: int, what: str) -> tuple[Any, ...]:
    """Return some finite numbers, or refuse other values."""
    # tuples, lists and arrays alike
    takes = f"{what} takes {n} numbers"
    parts = listed(value, takes, "give a tuple")
    if len(parts) != n or not all(map(is_number, parts)):
        raise InputError(f"{takes}, not {value!r}; give a tuple of finite ones.")
    return tuple(parts)


def checked(make: Callable[P, World]) -> Callable[P, World]:
    """
    Let a world refuse arguments that are of another kind than their defaults.

    Whole numbers, numbers and tuples of numbers are distinguished; other arguments are left to it.

    Raises
    ------
    InputError

    Examples
    --------
    >>> import geosurf as gs
    >>> gs.synthetic.waves(n=2.5)
    Traceback (most recent call last):
    geosurf.errors.InputError: n of the world 'waves' is 2.5; give a whole number.
    """
    # defaults say what kind each argument has: no list of types beside the functions
    signature = inspect.signature(make)

    @wraps(make)
    def world(*args: P.args, **kwargs: P.kwargs) -> World:
        """Check what is given, then make it."""
        bound = signature.bind(*args, **kwargs)
        for key, value in bound.arguments.items():
            default = signature.parameters[key].default
            what = f"{key} of the world {make.__name__!r}"
            if type(default) is int:
                check_count(value, what, 0 if key == "seed" else None)
            elif isinstance(default, float):
                number = number_of(value, what)
                bound.arguments[key] = value if isinstance(value, int | float) else number
            elif isinstance(default, tuple):
                bound.arguments[key] = check_numbers(value, len(default), what)
        return make(*bound.args, **bound.kwargs)

    return world


def check_count(value: Any, what: str, least: int | None = None) -> None:
    """Refuse what is not a whole number, or a world of more nodes than fit into memory."""
    if not is_whole(value):
        raise InputError(f"{what} is {value!r}; give a whole number.")
    if least is not None and value < least:
        raise InputError(f"{what} is {value}; give a whole number, {least} or more.")
    if value > LARGEST and "seed" not in what:
        raise InputError(f"{what} is {value}; give at most {LARGEST}.")


def make_horizon(
    name: str,
    box: Box,
    n: int,
    height: Callable[[np.ndarray, np.ndarray], np.ndarray],
    offset: Offset,
) -> xr.DataArray:
    """Sample ``elevation = height(x, y)`` on n x n nodes over the box; x, y without offset."""
    if n < 2:
        raise InputError(f"n is {n}: a grid needs two nodes per side. Give n=2 or more.")
    x, y = np.linspace(box[0], box[1], n), np.linspace(box[2], box[3], n)
    values = np.broadcast_to(height(x[None, :], y[:, None]), (n, n)) + offset[2]
    metre = {"units": "m"}
    return xr.DataArray(
        values,
        dims=HORIZON_DIMS,
        coords={
            "northing": ("northing", y + offset[1], metre | {"axis": "Y"}),
            "easting": ("easting", x + offset[0], metre | {"axis": "X"}),
        },
        name=name,
        attrs={
            "units": "m",
            "positive": "up",
            "standard_name": "altitude",
            "long_name": f"elevation of {name}",
        },
    )


def make_fault(
    name: str, x: np.ndarray, y: np.ndarray, z: np.ndarray, offset: Offset
) -> xr.Dataset:
    """Return a fault Dataset from nodes (n_down_dip, n_along_strike)."""
    parts = zip(COORDINATES, np.broadcast_arrays(x, y, z), strict=True)
    ds = xr.Dataset(
        {
            key: (FAULT_DIMS, values + shift, {"units": "m"})
            for (key, values), shift in zip(parts, offset, strict=True)
        },
        attrs={"name": name},
    )
    ds["elevation"].attrs["positive"] = "up"
    return ds


def shifted(box: Box, offset: Offset) -> Box:
    """Return the box, moved."""
    w, e, s, n, b, t = box
    x, y, z = offset
    return w + x, e + x, s + y, n + y, b + z, t + z
