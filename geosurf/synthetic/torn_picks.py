"""Picks of a torn horizon: one value per node, smeared over the faults, or scattered points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from geosurf.synthetic.torn_faults import (
    Fault,
    exists,
)


def single_valued(
    faults: Mapping[str, Fault],
    x: np.ndarray,
    y: np.ndarray,
    heights: Mapping[Any, np.ndarray],
    there: Mapping[Any, np.ndarray],
) -> np.ndarray:
    """One value per node: the highest sheet, and the fault itself in gaps."""
    # (n_sheet, n, n): elevations of sheets where they exist, NaN elsewhere
    every = np.stack([np.where(there[s], z, np.nan) for s, z in heights.items()])
    none = np.isnan(every).all(axis=0)

    # the highest sheet where walls overlap; a map has one value per node
    top = np.where(none, -np.inf, np.nan_to_num(every, nan=-np.inf).max(axis=0))

    # in a gap no sheet exists: the fault lies between the sheets that would meet there
    low, high = np.min(list(heights.values()), axis=0), np.max(list(heights.values()), axis=0)
    gap = 0.5 * (low + high)
    for fault in faults.values():
        s, r = fault.along_across(x, y)
        a, b = low.copy(), high.copy()
        for _ in range(40):  # where the fault is between the sheets, by halving
            middle = 0.5 * (a + b)
            under = fault.across(s, middle) > r
            a, b = np.where(under, middle, a), np.where(under, b, middle)

        # the fault between both sheets, else the middle of them
        inside = (a > low) & (b < high)
        gap = np.where(inside, 0.5 * (a + b), gap)
    return np.where(none, gap, top)


def smeared(values: np.ndarray, there: dict, width: int) -> np.ndarray:
    """The mean over a square where sheets meet in it, the value itself elsewhere."""
    if width == 0:
        return values

    # nodes whose window shows several sets of sheets are near a fault: only these are smeared
    code = np.zeros(values.shape, dtype=np.int64)  # which sheets there are, one bit for each
    for number, mask in enumerate(there.values()):
        if number % 32 == 31:  # bits run out; equal ones stay equal
            code = np.unique(code, return_inverse=True)[1].reshape(values.shape)
        code = 2 * code + mask
    k = 2 * width + 1
    shape = (k, k)
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, width, mode="edge"), shape)
    codes = np.lib.stride_tricks.sliding_window_view(np.pad(code, width, mode="edge"), shape)
    mixed = codes.min(axis=(2, 3)) != codes.max(axis=(2, 3))
    return np.where(mixed, windows.mean(axis=(2, 3)), values)


def scattered(
    faults: Mapping[str, Fault],
    sheets: Mapping[Any, Any],
    side: float,
    number: int,
    noise: float = 0.0,
    seed: int = 5,
) -> np.ndarray:
    """Points (n, 3) at random places, on each sheet that exists there."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(0.0, side, (2, number))
    found = []
    for signs, sheet in sheets.items():
        z = sheet(x, y)
        found.append(np.stack([x, y, z], axis=1)[exists(faults, signs, x, y, z)])
    points = np.concatenate(found)
    points[:, 2] += noise * rng.standard_normal(len(points))
    return points
