"""A mesh of which some triangles are left out."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry

FREE = -1  # as of `Pieces.link`


@entry("b1 l1 l1 l1 -> l1 l1")
def kept_rings(keep, rows, ring, link):
    """Rings of half-edges and links (see `Pieces`) of the triangles that stay, numbered again.

    `rows` are the triangles with `keep`, rising. A half-edge that becomes the only one of its edge
    is free.
    """
    number = np.empty(keep.shape[0], dtype=np.int64)
    for i in range(rows.shape[0]):
        number[rows[i]] = i
    new, onward = np.empty(3 * rows.shape[0], dtype=np.int64), np.empty_like(link[: 3 * rows.size])
    for i in range(rows.shape[0]):
        for c in range(3):
            half = 3 * rows[i] + c
            j = ring[half]
            alone = j == half

            # past what is left out, to the next one that stays: itself in the end
            while not keep[j // 3]:
                j = ring[j]
            new[3 * i + c] = 3 * number[j // 3] + j % 3
            onward[3 * i + c] = FREE if j == half and not alone else link[half]
    return new, onward
