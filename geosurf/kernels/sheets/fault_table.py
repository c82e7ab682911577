"""Values at points of a plane on a mesh in it: in the triangle of a block that holds each best.

Notation
    plane           places of the vertices, float64 (n_vertex, 2); values there (n_vertex,)
    triangles       int64 (n, 3)
    starts, items   triangles listed by blocks: those of block b are ``items[starts[b]]`` ..
                    ``items[starts[b + 1] - 1]``
    rows, block     points that lie in a block with triangles, and that block
    u, v, w         weights of the corners of a triangle at a point, 1 in sum
"""

from __future__ import annotations

from geosurf.kernels.compile.jit import entry


@entry("d2 d1 l2 l1 l1 d2 l1 l1 d d1* -> .")
def values_on_triangles(
    plane, values, triangles, starts, items, points, rows, block, inside, out
):  # fmt: skip
    """Write linear interpolation at points; no other entry of `out` is written.

    A point is in a triangle if no weight is below `inside`. Of several it takes the one that it is
    deepest in, the last of those where it is equally deep. Triangles without area hold nothing.
    """
    for k in range(rows.shape[0]):
        px, py = points[rows[k], 0], points[rows[k], 1]
        best = inside
        for i in range(starts[block[k]], starts[block[k] + 1]):
            a, b, c = triangles[items[i], 0], triangles[items[i], 1], triangles[items[i], 2]
            one_x, one_y = plane[b, 0] - plane[a, 0], plane[b, 1] - plane[a, 1]
            two_x, two_y = plane[c, 0] - plane[a, 0], plane[c, 1] - plane[a, 1]
            det = one_x * two_y - one_y * two_x
            if det == 0.0:
                continue

            # Cheap first: most triangles of a block fail on their first weight.
            to_x, to_y = px - plane[a, 0], py - plane[a, 1]
            v = (to_x * two_y - to_y * two_x) / det
            if v < best:
                continue
            w = (one_x * to_y - one_y * to_x) / det
            u = 1.0 - v - w
            least = min(u, min(v, w))
            if least >= best:
                best = least
                out[rows[k]] = u * values[a] + v * values[b] + w * values[c]
