"""Kernels for `test_frozen`: every kind of argument and result, exceptions, long loops."""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar


@scalar
def _fill(out, value):
    for i in range(out.shape[0]):
        out[i] = value


@entry("d2 l1 b d -> d1 l d")
def kinds(x, rows, twice, shift):
    """Sums of some rows, their number, and the largest."""
    out = np.zeros(rows.shape[0])
    largest = -np.inf
    for k in range(rows.shape[0]):
        for j in range(x.shape[1]):
            out[k] += x[rows[k], j] * (2.0 if twice else 1.0) + shift
        largest = max(largest, out[k])
    return out, rows.shape[0], largest


@entry("b1 -> b1")
def flip(mask):
    """The other half; a table of truth in and out."""
    return ~mask


@entry("d2 -> d2")
def crossed(x):
    """A result that is not in C order: the transpose of a new table."""
    return (x + 1.0).T


@entry("d1* l -> d1 d1")
def fill(out, value):
    """Write through a helper; hand back the argument and a part of it."""
    _fill(out, value)
    return out, out[1:]


@entry("l1 -> l1 l1")
def shared(x):
    """One new array, twice."""
    new = x + 1
    return new, new


@entry("d -> d l")
def parts(value):
    """Mantissa and exponent, put together again."""
    mantissa, exponent = math.frexp(value)
    return math.ldexp(mantissa, exponent), exponent + 0  # numba: int32 and 0 is int64


@entry("l -> l")
def refuse(number):
    """Raise, with a text that is known when the kernel is compiled."""
    if number < 0:
        raise ValueError("negative")
    if number == 7:
        raise OverflowError("seven", 7)
    return number


@entry("l -> l1")
def room(n):
    """Ask for memory."""
    out = np.empty(n, dtype=np.int64)
    out[:1] = 1
    return out


@entry("l l1* -> .")
def spin(n, out):
    """Count for a while, in machine code."""
    x = 1
    for _ in range(n):
        x = (x * 48271) % 2147483647
    out[0] = x


@entry("d1 -> l1")
def order(x):
    """Sort; numba's argsort keeps a stack of its own."""
    return np.argsort(x)


@entry("l -> l l")
def grow(n):
    """A list that grows inside a kernel and is emptied again."""
    held = [0]
    total = 0
    for i in range(n):
        held.append(i * i)
        if len(held) % 1000 == 999:
            total += held[-1]
    longest = len(held)
    held.clear()
    return total + len(held), longest


@entry("l -> l2")
def widen(n):
    """Assign to a slice; numba's text for a wrong shape would need Python's strings."""
    larger = np.zeros((2, 4), dtype=np.int64)
    larger[:n] = np.ones((n, 4), dtype=np.int64)
    return larger
