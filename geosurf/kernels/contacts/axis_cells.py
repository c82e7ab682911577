"""Which cells of an increasing axis overlap an interval? By a guess, or by bisection where steps
differ.
"""

from __future__ import annotations

from geosurf.kernels.compile.jit import scalar


@scalar
def _guess(axis, n, value, pace):
    """Cell of a value among n cells of even steps; 0 if that is not a number."""
    steps = (value - axis[0]) * pace
    # NaN and values before the axis give 0; the bound comes first, as int() of infinity is
    # undefined.
    return int(min(steps, 1.0 * n)) if steps > 0.0 else 0


@scalar
def cells_in_interval(axis, n, pace, low, high):
    """First and last cell (one more) of n on an increasing axis that overlap an interval.

    `pace` is cells per metre: where steps are even, the guess is off by one cell at most.
    """
    first = _guess(axis, n, low, pace)  # the first cell that ends at `low` or after
    # One step corrects the rounding of a guess.
    if first > 0 and axis[first] >= low:
        first -= 1
    elif first < n and axis[first + 1] < low:
        first += 1

    # The guess failed: bisection.
    if (first > 0 and axis[first] >= low) or (first < n and axis[first + 1] < low):
        first, end = 0, n
        while first < end:
            middle = (first + end) >> 1
            if axis[middle + 1] < low:
                first = middle + 1
            else:
                end = middle
    last = _guess(axis, n, high, pace) + 1  # the first cell that begins after `high`
    last = min(last, n)
    if last > 0 and axis[last - 1] > high:
        last -= 1
    elif last < n and axis[last] <= high:
        last += 1

    # The same for the end of the interval.
    if (last > 0 and axis[last - 1] > high) or (last < n and axis[last] <= high):
        last, end = 0, n
        while last < end:
            middle = (last + end) >> 1
            if axis[middle] <= high:
                last = middle + 1
            else:
                end = middle
    return first, last
