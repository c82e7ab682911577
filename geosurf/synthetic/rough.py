"""Noise on planes: what is known are bounds."""

from __future__ import annotations

import math

import numpy as np

from geosurf.errors import InputError
from geosurf.synthetic.planar import tilted_planes
from geosurf.synthetic.world import Offset, World, checked

_ORIGIN = (0.0, 0.0, 0.0)


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
