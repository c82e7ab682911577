"""Which corners of the pieces of a torn sheet are vertices of the sheet itself?"""

from __future__ import annotations

import numpy as np

from geosurf.kernels._jit import entry


@entry("d2 l2 l1 l2 d2 d1 -> l2")
def named_corners(local, triangles, rows, faces, vertices, origin):
    """Vertex (n, 3) of the sheet at each corner of some triangles, -1 for points that were made.

    `faces` (n, 3) are the corners of their parents, `vertices` those of the sheet in the world.
    """
    out = np.full((rows.shape[0], 3), -1, dtype=np.int64)
    for k in range(rows.shape[0]):
        for c in range(3):
            p = triangles[rows[k], c]
            for d in range(3):
                v = faces[k, d]
                same = True
                for axis in range(3):
                    if local[p, axis] != vertices[v, axis] - origin[axis]:
                        same = False
                        break
                if same:
                    out[k, c] = v
                    break
    return out
