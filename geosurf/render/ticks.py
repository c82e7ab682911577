"""Round values for axes, contours and scale bars, and their text."""

from __future__ import annotations

import math

import numpy as np


def nice_step(span: float, n: int = 5) -> float:
    """Return a round step that divides a span into about `n` parts.

    Examples
    --------
    >>> nice_step(4000.0), nice_step(730.0)
    (1000.0, 200.0)
    """
    # 1, 2, 2.5 or 5 times a power of ten: the first that is not clearly too small
    rough = span / n
    power = 10.0 ** math.floor(math.log10(rough))
    return float(next(m * power for m in (1.0, 2.0, 2.5, 5.0, 10.0) if m * power >= rough * 0.99))


def fitting(pixels: float, unit: float) -> int:
    """Return how many numbers fit an axis of some pixels, from 1 to 5; `unit` is the font scale."""
    return int(min(max(pixels / (45.0 * unit), 1.0), 5.0))


def ticks(low: float, high: float, n: int = 5) -> np.ndarray:
    """Return round values between two bounds."""
    step = nice_step(high - low, n)

    # a billionth of a step is rounding: a bound on a round value keeps it
    first = math.ceil(low / step - 1e-9)
    return step * np.arange(first, math.floor(high / step + 1e-9) + 1)


def tick_texts(values: np.ndarray, per: float) -> list[str]:
    """Return values over a unit, with as many decimals as their step needs."""
    step = float(values[1] - values[0]) / per if len(values) > 1 else 1.0

    # the fewest decimals that show the step exactly
    decimals = next((d for d in range(6) if abs(round(step, d) - step) < 1e-9 * step), 6)
    texts = [f"{value / per:.{decimals}f}" for value in values + 0.0]
    return [text.replace("-", "\N{MINUS SIGN}") for text in texts]


def plain_number(value: float) -> str:
    """Return a number with a true minus sign and without trailing zeros.

    Examples
    --------
    >>> plain_number(-2050.0), plain_number(0.25)
    ('−2050', '0.25')
    """
    return f"{round(float(value), 6):g}".replace("-", "\N{MINUS SIGN}")
