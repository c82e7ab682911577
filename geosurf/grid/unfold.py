"""Pillars that fold a cell step aside, by no more than needed.

Three corners of a column may lie on one fault, nearly on a line: the corner between the two others
has no area. Each such corner moves these three pillars a little, along the gradient of its area,
until all corners have enough. So pillars stay within some hundredths of a cell of the fault.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geosurf.grid.pillars import CORNERS, TURNS, Pillars

LEAST_AREA = 0.1  # of a cell, at each of its corners
BEYOND = 1.05  # share of it to which a corner moves, so that rounds end
ROUNDS = 60


def folded(pillars: Pillars) -> np.ndarray:
    """Cells with a corner that has too little area at some elevation within reach, (ny, nx)."""
    found: np.ndarray = pillars.least_areas()[0].min(axis=0) < LEAST_AREA
    return found


def unfolded(pillars: Pillars) -> Pillars:
    """Pillars that stepped aside where they folded a cell; some may be folded after all rounds."""
    shift = pillars.shift.copy()
    ny, nx = pillars.level.shape
    for _ in range(ROUNDS):
        now = replace(pillars, shift=shift)
        areas, at = now.least_areas()
        if (areas >= LEAST_AREA).all():
            return now
        move, count = np.zeros_like(shift), np.zeros((ny, nx, 1))
        for turn, area, z in zip(TURNS, areas, at, strict=True):
            j, i = np.nonzero(area < LEAST_AREA)
            nodes = [(j + CORNERS[c][0], i + CORNERS[c][1]) for c in turn]
            x = [now.places(node, z[j, i]) for node in nodes]
            u, v = x[1] - x[0], x[2] - x[0]
            ahead, back = np.stack([v[:, 1], -v[:, 0]], 1), np.stack([-u[:, 1], u[:, 0]], 1)
            slopes = [-(ahead + back), ahead, back]

            # the shortest step of all three that gives the corner its area
            steep = sum((s**2).sum(axis=1) for s in slopes)
            step = (BEYOND * LEAST_AREA - area[j, i]) / np.maximum(steep, 1e-3)
            for node, slope in zip(nodes, slopes, strict=True):
                np.add.at(move, node, step[:, None] * slope)
                np.add.at(count, node, 1.0)

        # across the rim none moves
        move[:, [0, -1], 0] = 0.0
        move[[0, -1], :, 1] = 0.0
        shift = shift + move / np.maximum(count, 1.0)
    return replace(pillars, shift=shift)


__all__ = ["LEAST_AREA", "folded", "unfolded"]
