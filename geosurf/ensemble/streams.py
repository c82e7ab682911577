"""Streams of random numbers: one for each realisation and parameter, from one seed.

A stream depends on the seed, the number of the realisation and the name of the parameter only:
realisation 17 is the same in any order, on any number of workers, and in a longer ensemble. Another
parameter leaves the numbers of all others as they were.
"""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from geosurf.conventions import is_whole
from geosurf.errors import InputError

_STEPS = 1 << 53


def check_seed(seed: Any) -> int:
    """Return a seed, or raise an error that names what it must be.

    Examples
    --------
    >>> check_seed(3)
    3
    """
    if not (is_whole(seed) and seed >= 0):
        raise InputError(f"seed is {seed!r}; give a whole number, 0 or above.")
    return int(seed)


def stream_of(seed: int, realization: int, parameter: str) -> np.random.Generator:
    """
    Return the random numbers of one parameter in one realisation.

    Parameters
    ----------
    seed : int
    realization : int
    parameter : str
        Name of the parameter.

    Returns
    -------
    numpy.random.Generator

    Examples
    --------
    >>> a, b, c = (stream_of(0, k, p).random() for k, p in ((5, "x"), (5, "x"), (5, "y")))
    >>> a == b, a == c
    (True, False)
    """
    # The name enters by its hash: 128 bits, the same in every process and on every machine.
    words = np.frombuffer(hashlib.sha256(parameter.encode()).digest()[:16], dtype="<u4")
    sequence = np.random.SeedSequence(seed, spawn_key=(realization, *words.tolist()))
    return np.random.Generator(np.random.PCG64(sequence))


def probability_of(stream: np.random.Generator) -> float:
    """Return a uniform number that is neither 0 nor 1.

    Examples
    --------
    >>> 0.0 < probability_of(stream_of(0, 0, "x")) < 1.0
    True
    """
    # The middle of one of 2**53 equal steps: never 0 or 1, where quantiles are infinite.
    return (int(stream.integers(_STEPS)) + 0.5) / _STEPS


__all__ = ["check_seed", "probability_of", "stream_of"]
