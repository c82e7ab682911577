"""Medians, spreads and exponents."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geosurf.errors import InputError

SEEN_BYTES = 1e5  # less memory than that is some pages of the system's own


def median(values: Sequence[float]) -> float:
    """Return the middle of some numbers.

    Examples
    --------
    >>> median([3.0, 1.0, 2.0])
    2.0
    """
    return float(np.median(values))


def exponent(sizes: Sequence[float], costs: Sequence[float]) -> float:
    """
    Return b of the power law ``cost = a size^b`` that fits best on logarithmic axes.

    Parameters
    ----------
    sizes, costs : sequence of float
        Positive; at least two sizes that differ.

    Returns
    -------
    float

    Raises
    ------
    InputError
        For fewer than two sizes, or numbers that have no logarithm.

    Examples
    --------
    >>> round(exponent([1e4, 1e5, 1e6], [0.1, 0.4, 1.6]), 3)
    0.602
    """
    if len(set(sizes)) < 2 or len(sizes) != len(costs):
        raise InputError(
            f"an exponent needs costs for two sizes or more, there are {len(sizes)} sizes and "
            f"{len(costs)} costs. Measure more sizes."
        )
    if min(*sizes, *costs) <= 0:
        raise InputError("an exponent needs positive sizes and costs. Leave out what took no time.")
    x, y = np.log(sizes), np.log(costs)
    x = x - x.mean()
    return float((x * y).sum() / (x * x).sum())


def seconds_text(seconds: float) -> str:
    """Return a time as people read it.

    Examples
    --------
    >>> [seconds_text(t) for t in (0.00012, 0.0345, 2.0, 75.0)]
    ['0.12 ms', '34.5 ms', '2 s', '75 s']
    """
    if seconds < 0.9995:
        return f"{float(f'{1e3 * seconds:.3g}'):g} ms"
    return f"{float(f'{seconds:.3g}'):g} s"


def metres_text(metres: float) -> str:
    """Return a small length as people read it.

    Examples
    --------
    >>> [metres_text(d) for d in (1.5, 0.0015, 2e-9)]
    ['1.5 m', '1.5 mm', '2 nm']
    """
    for unit, size in (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6)):
        if metres >= size:
            return f"{float(f'{metres / size:.2g}'):g} {unit}"
    return f"{float(f'{metres / 1e-9:.2g}'):g} nm"


def count_text(number: float) -> str:
    """Return a number of triangles as people read it.

    Examples
    --------
    >>> [count_text(n) for n in (203, 20402, 2001000)]
    ['203', '2.04e4', '2e6']
    """
    if number < 1000:
        return f"{number:.0f}"
    mantissa, power = f"{number:.2e}".split("e")
    return f"{float(mantissa):g}e{int(power)}"
