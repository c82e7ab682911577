"""Arithmetic of integers of any length, stored as 26-bit limbs in an int64 workspace.

Notation
    w          the workspace, int64 (n,); numbers live at offsets into it
    r, a, b    offsets of the result and of the operands
    n, la, lb  lengths in limbs

A number is ``sum(limb[i] * 2**(26 i))``. All limbs but the last lie in [0, 2**26); the last limb
carries the sign. This representation needs no sign-magnitude cases and no comparison before a sum.
A column of a product has up to 2047 terms below 2**52 and cannot overflow int64, so the same code
runs in plain Python and needs no 128-bit products.

Indices in the two inner loops are unsigned: numba checks a signed index for a negative value each
time, which takes longer than the product.
"""

from __future__ import annotations

import math

import numpy as np

from geosurf.kernels.compile.jit import scalar

BITS = 26
MASK = (1 << BITS) - 1


@scalar
def clear(w, r, n):
    """r = 0."""
    for i in range(n):
        w[r + i] = 0


@scalar
def load(w, r, n, x, k):
    """r = x * 2**k, which must be an integer that fits n limbs."""
    clear(w, r, n)
    if x == 0.0:
        return

    # Split x into a 53-bit integer mantissa and a power of two.
    fraction, exponent = math.frexp(x)
    mantissa = int(fraction * 9007199254740992.0)  # 53 bits, exact
    shift = exponent - 53 + k
    if shift < 0:
        mantissa >>= -shift  # exact: the bits that go are zero
        shift = 0

    # The sign goes into a factor, so that limbs are cut from a positive mantissa.
    factor = 1
    if mantissa < 0:
        factor = -1
        mantissa = -mantissa

    # The lowest limb that is touched, and the bit offset inside it.
    i = shift // BITS
    s = shift - i * BITS
    carry = 0
    j = 0

    # Write the mantissa limb by limb; the carry propagates the sign upwards.
    while i < n - 1:
        t = carry

        # 53 bits, shifted by up to 25, fill 78 bits: three limbs. Above them only the carry is
        # left.
        if j < 3:
            t += factor * (((mantissa >> (BITS * j)) & MASK) << s)
        elif carry == 0:
            return
        w[r + i] = t & MASK
        carry = t >> BITS
        i += 1
        j += 1
    if j < 3:
        carry += factor * ((mantissa >> (BITS * j)) << s)
    w[r + n - 1] = carry


@scalar
def sign(w, a, n):
    """Sign of a: -1, 0 or +1."""
    top = w[a + n - 1]
    if top < 0:
        return -1
    if top > 0:
        return 1

    # The top limb is zero: the number is zero or positive.
    for i in range(n - 1):
        if w[a + i] != 0:
            return 1
    return 0


@scalar
def sub(w, r, a, b, n):
    """r = a - b, all of n limbs."""
    carry = 0
    for i in range(n - 1):
        # The arithmetic shift rounds down, so a negative difference borrows from the next limb.
        t = w[a + i] - w[b + i] + carry
        w[r + i] = t & MASK
        carry = t >> BITS
    w[r + n - 1] = w[a + n - 1] - w[b + n - 1] + carry


@scalar
def negate(w, r, n):
    """r = -r."""
    carry = 0
    for i in range(n - 1):
        t = carry - w[r + i]
        w[r + i] = t & MASK
        carry = t >> BITS
    w[r + n - 1] = carry - w[r + n - 1]


@scalar
def accumulate(w, r, n, a, la, factor):
    """r += factor * a, with la <= n and a small factor."""
    carry = 0
    for i in range(n - 1):
        t = w[r + i] + carry
        if i < la:
            t += factor * w[a + i]
        # Above the operand only the carry changes limbs; without one, the upper limbs of r stay.
        elif carry == 0:
            return
        w[r + i] = t & MASK
        carry = t >> BITS
    t = w[r + n - 1] + carry
    if la == n:
        t += factor * w[a + n - 1]
    w[r + n - 1] = t


@scalar
def mul(w, r, a, la, b, lb):
    """r = a * b in la + lb limbs; r must not overlap a or b."""
    carry = 0

    # Column k collects all products of limbs i and k - i.
    # The mask keeps limbs in [0, 2**26) for negative columns too: the shift rounds down.
    for k in range(la + lb - 1):
        low = 0 if k < lb else k - lb + 1
        high = k + 1 if k < la else la
        t = carry
        for i in range(low, high):
            t += w[np.uintp(a + i)] * w[np.uintp(b + k - i)]
        w[r + k] = t & MASK
        carry = t >> BITS
    w[r + la + lb - 1] = carry


@scalar
def mul_add(w, r, n, a, la, b, lb, factor):
    """r += factor * a * b for factor = +1 or -1; r has n >= la + lb limbs."""
    carry = 0
    last = la + lb - 1

    # As in `mul`; above the product only the carry is propagated.
    for k in range(n - 1):
        t = 0
        if k < last:
            low = 0 if k < lb else k - lb + 1
            high = k + 1 if k < la else la
            for i in range(low, high):
                t += w[np.uintp(a + i)] * w[np.uintp(b + k - i)]
        elif carry == 0:
            return
        t = w[r + k] + carry + factor * t
        w[r + k] = t & MASK
        carry = t >> BITS
    w[r + n - 1] += carry


@scalar
def shift_left(w, r, a, la, bits):
    """r = a * 2**bits; returns the length of r, la + bits // 26 + 1."""
    q = bits // BITS
    s = bits - q * BITS
    clear(w, r, q)
    carry = 0
    for i in range(la):
        t = (w[a + i] << s) + carry
        w[r + q + i] = t & MASK
        carry = t >> BITS
    w[r + q + la] = carry
    return la + q + 1


@scalar
def leading(w, a, n):
    """(m, e) with a = m * 2**e up to a relative error of 2**-50; a must not be negative."""
    # Skip leading zero limbs, then read four limbs: at least 78 bits.
    i = n - 1
    while i > 0 and w[a + i] == 0:
        i -= 1
    # Four limbs are enough for 53 bits even if the highest holds a single bit.
    low = i - 3
    if low < 0:
        low = 0
    m = 0.0
    for j in range(i, low - 1, -1):
        m = m * 67108864.0 + w[a + j]
    return m, low * BITS
