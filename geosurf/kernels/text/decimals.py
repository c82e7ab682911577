"""One word of a text to float64, rounded to the nearest double, or left to Python.

A word is a whole number of up to 18 digits times a power of ten. Where both factors are doubles,
one multiplication or division rounds correctly. Otherwise the result is a double and a correction,
known to a bound (Dekker's exact product). The rounding is certain where both ends of that bound
give the same sum (the test of Ziv 1991, ACM TOMS 17); else the word is `HARD`, and Python decides.
Digits after the eighteenth widen the bound by one unit of the eighteenth.
"""

from __future__ import annotations

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.exact.double_double import two_product

PLAIN, HARD, OTHER = 0, 1, 2  # a number; one for Python; no number
MINUS, PLUS, POINT, ZERO, NINE = 45, 43, 46, 48, 57
BLANK, TAB, LINE_END, LETTER_E, LOWER = 32, 9, 10, 101, 32
MOST = 18  # digits of a whole number that int64 holds
EXACT = 9007199254740992  # 2**53
N_TENS = 22  # largest power of ten that is a double
MOST_POWER = 10_000  # digits of larger exponents are left to Python
BOUND = 2.0**-50  # of a correction: it has two roundings
WIDER = 1.0 + 2.0**-40


@scalar
def character(text, k):
    """Character k of a text."""
    return (text[k >> 3] >> ((k & 7) << 3)) & 255


@scalar
def is_blank(c):
    """Whether a character stands between words; line ends do."""
    return c == BLANK or c == TAB or c == LINE_END


@scalar
def nearest(whole, power, cut, tens):
    """Double nearest to whole * 10**power, and whether it is certain; `cut`: digits are missing."""
    high = float(whole)
    if whole == 0:
        return 0.0, PLAIN
    if not cut and whole <= EXACT and -N_TENS <= power <= N_TENS:
        # both factors are exact: one rounding
        down = -power
        return (high / tens[down] if power < 0 else high * tens[power]), PLAIN
    if not cut and whole <= EXACT and N_TENS < power <= 2 * N_TENS:
        # some powers fit into the whole number
        high *= tens[power - N_TENS]
        return high * tens[N_TENS], (PLAIN if high <= EXACT else HARD)
    if not -N_TENS <= power <= N_TENS:
        return 0.0, HARD

    # value = first + correction, with an error below `bound`; `unit`: what missing digits may add
    low = float(whole - int(high))
    if power <= 0:
        down = -power
        ten = tens[down]
        first = high / ten
        product, error = two_product(first, ten)
        correction = ((high - product) - error + low) / ten
        bound = abs(correction) * BOUND
        unit = 1.0 / ten
    else:
        ten = tens[power]
        first, error = two_product(high, ten)
        correction = error + low * ten
        bound = (abs(error) + abs(low) * ten) * BOUND
        unit = ten
    above = bound + unit * WIDER if cut else bound
    least, most = first + (correction - bound), first + (correction + above)
    return least, (PLAIN if least == most else HARD)


@scalar
def number_at(text, at, end, tens):
    """Value, character behind it, and kind of the word that begins at a character."""
    k = at
    first = character(text, k)
    if first == MINUS or first == PLUS:
        k += 1

    # digits: leading zeros do not count, and those after the eighteenth only shift the power
    whole, n_digit, power = 0, 0, 0
    seen, point, cut = False, False, False
    while k < end:
        c = character(text, k)
        if ZERO <= c <= NINE:
            seen = True
            if n_digit < MOST:
                whole = whole * 10 + (c - ZERO)
                if whole > 0:
                    n_digit += 1
                if point:
                    power -= 1
            else:
                cut = cut or c != ZERO
                if not point:
                    power += 1
        elif c == POINT and not point:
            point = True
        else:
            break
        k += 1
    if not seen:
        return 0.0, k, OTHER

    if k < end and (character(text, k) | LOWER) == LETTER_E:
        k += 1
        c = character(text, k)
        sign = -1 if c == MINUS else 1
        if c == MINUS or c == PLUS:
            k += 1
        start, exponent = k, 0
        while k < end and ZERO <= character(text, k) <= NINE:
            exponent = min(exponent * 10 + (character(text, k) - ZERO), MOST_POWER)
            k += 1
        if k == start:
            return 0.0, k, OTHER
        power += sign * exponent
    if k < end and not is_blank(character(text, k)):
        return 0.0, k, OTHER
    value, kind = nearest(whole, power, cut, tens)
    return (-value if first == MINUS else value), k, kind


@scalar
def next_word(text, at, end):
    """Where the next word begins, or `end`."""
    k = at
    while k < end and is_blank(character(text, k)):
        k += 1
    return k
