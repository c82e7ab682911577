"""A mesh of which some triangles are left out."""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry

FREE = -1  # as of `Pieces.link`


@entry("b1 l2 l1 l1 l1 l1 l1 l1 l -> l2 l1 l1 l1 l1 l1 l1")
def kept_triangles(keep, triangles, surface, key, patch, patch_of, ring, link, n_point):
    """All that pieces state of their triangles (see `Pieces`), of those that stay.

    Patches get the numbers `patch_of`, and triangles and points are numbered again. A half-edge
    that becomes the only one of its edge is free.

    Returns
    -------
    triangles, surface, key, patch, ring, link
        Of the triangles that stay.
    number : int64 (n_point,)
        New number of each point that they use, or -1.
    """
    row_of = np.empty(keep.shape[0], dtype=np.int64)
    number = np.full(n_point, -1, dtype=np.int64)
    n = 0
    for i in range(keep.shape[0]):
        if keep[i]:
            row_of[i] = n
            n += 1
            for c in range(3):
                number[triangles[i, c]] = 0
    count = 0
    for p in range(n_point):
        if number[p] == 0:
            number[p] = count
            count += 1

    corners = np.empty((n, 3), dtype=np.int64)
    of_surface, of_key = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    of_patch = np.empty(n, dtype=np.int64)
    onward, behind = np.empty(3 * n, dtype=np.int64), np.empty(3 * n, dtype=np.int64)
    k = 0
    for i in range(keep.shape[0]):
        if not keep[i]:
            continue
        of_surface[k], of_key[k], of_patch[k] = surface[i], key[i], patch_of[patch[i]]
        for c in range(3):
            corners[k, c] = number[triangles[i, c]]
            half = 3 * i + c
            j = ring[half]
            alone = j == half

            # past what is left out, to the next one that stays: itself in the end
            row = j // 3
            while not keep[row]:
                j = ring[j]
                row = j // 3
            onward[3 * k + c] = 3 * row_of[row] + j - 3 * row
            behind[3 * k + c] = FREE if j == half and not alone else link[half]
        k += 1
    return corners, of_surface, of_key, of_patch, onward, behind, number
