"""The cavity of a segment: the triangles that it crosses, removed and triangulated again.

Each side of the segment is a polygon whose points are all visible from the segment. So each convex
corner is an ear (Toussaint & Avis 1982). Ears are cut, every other one of a row at a time, and
added again in the opposite order with flips after each, like the corners of a polygon inserted one
by one (Chew 1990). Cutting consecutive ears would leave fans, which take quadratic time to flip.
Notation as in `delaunay`.

The *corridor* is the strip of triangles that the segment crosses; its two borders are *chains*.
"""

from __future__ import annotations

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.cutting.delaunay import (
    flip,
    link,
    next_half_edge,
    previous_half_edge,
    set_triangle,
)
from geosurf.kernels.cutting.face_circles import in_circle
from geosurf.kernels.cutting.face_signs import SEGMENT, turn

_FEW = 8  # chains up to this length are cut consecutively
_IN_CAVITY, _ADDED = -2, -3  # marks of half-edges: in the corridor; of an added ear


@scalar
def side_of_segment(frame, points, a, b, p):
    """Side of p of the line of the current segment from a to b."""
    q, s = points.q, points.s
    # Points that were constructed on this segment lie on its line by definition.
    if q[p, 3] == s[SEGMENT]:
        return 0
    return turn(frame, points, a, b, p)


@scalar
def _cut_ear(mesh, free, tri, a, b, point):
    """Make the triangle of chain rows a, b and a point; row a then links to that point."""
    h, v, k = mesh.h, mesh.v, mesh.k
    slot = k[free + tri, 3]
    i = 3 * slot
    set_triangle(h, v, slot, k[a, 0], k[b, 0], point)
    _join(h, i, k[a, 1], k[a, 2], k[a, 3])
    _join(h, i + 1, k[b, 1], k[b, 2], k[b, 3])

    # Row a now links to the open edge of the ear, which has no twin and no constraint yet.
    k[a, 1], k[a, 2], k[a, 3] = i + 2, -1, -1


@scalar
def _move_row(k, to, c):
    """Copy a row of a chain."""
    k[to, 0], k[to, 1], k[to, 2], k[to, 3] = k[c, 0], k[c, 1], k[c, 2], k[c, 3]


@scalar
def _fill(frame, mesh, points, low, high, free, tri):
    """Triangulate the chain k[low:high] seen from its base: (base half-edge, next triangle).

    Rows of k: point, twin and support of the link to the next row, old half-edge of
    the link. Triangles are written to the slots k[free + n, 3], in the order of the ears.
    """
    k = mesh.k
    many = True
    # cut every other ear while at least a quarter of the chain disappears
    while many and high - low > _FEW:
        n = high - low
        # Rows are compacted in place: `top` is the last row that remains.
        top = low
        c = low + 1
        while c < high - 1:
            if turn(frame, points, k[top, 0], k[c, 0], k[c + 1, 0]) > 0:
                _cut_ear(mesh, free, tri, top, c, k[c + 1, 0])
                tri += 1
                # The corner after an ear is skipped: consecutive ears would make a fan.
                c += 1
            top += 1
            _move_row(k, top, c)
            c += 1
        if c < high:
            top += 1
            _move_row(k, top, c)
        high = top + 1
        many = 4 * (n - (high - low)) >= n
    top = low
    # cut what remains consecutively: Graham's scan, the stack starts at `low`
    for c in range(low + 1, high):
        point, twin, support, old = k[c, 0], k[c, 1], k[c, 2], k[c, 3]
        while top > low and turn(frame, points, k[top - 1, 0], k[top, 0], point) > 0:
            _cut_ear(mesh, free, tri, top - 1, top, point)
            tri += 1
            top -= 1
        top += 1
        k[top, 0], k[top, 1], k[top, 2], k[top, 3] = point, twin, support, old
    return k[low, 1], tri


@scalar
def _legalize_ears(frame, mesh, points, free, n):
    """Add n ears in the opposite order, and flip the edge opposite to the tip of each if needed.

    Only edges between added ears are flipped.
    """
    h, v, k = mesh.h, mesh.v, mesh.k
    for r in range(n - 1, -1, -1):
        slot = k[free + r, 3]
        # From now on flips may involve this ear.
        h[3 * slot, 3] = _ADDED
        k[0, 0] = 3 * slot + 2
        count = 1
        while count > 0:
            count -= 1

            # Only edges to ears that were added already can be illegal.
            i = k[count, 0]
            j = h[i, 1]
            # Borders and constraints are never flipped, nor edges to triangles outside of the
            # cavity.
            if j < 0 or h[i, 2] >= 0 or h[j - j % 3, 3] != _ADDED:
                continue

            # A flip exposes two more edges.
            a, b, c, o = h[i, 0], h[j, 0], h[previous_half_edge(i), 0], h[previous_half_edge(j), 0]
            if in_circle(frame, points, a, b, c, o):
                flip(h, v, i)
                k[count, 0], k[count + 1, 0] = next_half_edge(i), previous_half_edge(j)
                count += 2
    for r in range(n):
        h[3 * k[free + r, 3], 3] = 0


@scalar
def _join(h, i, twin, support, old):
    """Link a new half-edge to its twin; store in the old half-edge where it moved."""
    link(h, i, twin, support)
    if old >= 0:
        h[old, 3] = i


@scalar
def _push_link(h, k, n, point, i):
    """Write a chain row: a point, and the link of old half-edge i to the next row."""
    k[n, 0], k[n, 1], k[n, 2], k[n, 3] = point, h[i, 1], h[i, 2], i


@scalar
def _corridor(frame, mesh, points, first, a, b, goal):
    """Write the half-edges that the segment crosses, right end to left end, into k[:, 0].

    (number, point reached, -1), or (0, -1, half-edge) where a constraint is crossed.
    """
    h, k = mesh.h, mesh.k
    n = 0
    i = first
    while True:
        # A constraint in the way has to be split before the segment can pass.
        if h[i, 2] >= 0:
            return 0, -1, i
        k[n, 0] = i
        n += 1

        # The apex of the next triangle decides which of its edges is crossed.
        j = h[i, 1]
        apex = h[previous_half_edge(j), 0]
        side = 0 if apex == goal else side_of_segment(frame, points, a, b, apex)
        if side == 0:
            return n, apex, -1

        # An apex on the right: the segment leaves between the apex and the left end.
        i = previous_half_edge(j) if side < 0 else next_half_edge(j)


@scalar
def _build_chains(mesh, n, p, left, right, free):
    """Write both borders of a corridor, counter-clockwise, and the slots of its triangles,
    k[free:, 3].

    The left chain leads to p and ends at row left + n + 1, since it is filled from behind; the
    right one starts at p. Returns the first row of the left chain and the last row of the right
    chain.
    """
    h, k = mesh.h, mesh.k
    _push_link(h, k, right, p, previous_half_edge(k[0, 0]))
    k[left + n + 1, 0] = p
    nl = n
    _push_link(h, k, left + nl, h[next_half_edge(k[0, 0]), 0], next_half_edge(k[0, 0]))
    nr = 1
    k[right + nr, 0] = h[k[0, 0], 0]
    k[free, 3] = k[0, 0] // 3
    for c in range(n):
        # Walk along the corridor; each triangle adds one link to one of the borders.
        i = k[c, 0]
        j = h[i, 1]
        k[free + c + 1, 3] = j // 3
        y, z = next_half_edge(j), previous_half_edge(j)  # y: right end -> apex, z: apex -> left end
        # Both edges of the last triangle are on the borders.
        onward = k[c + 1, 0] if c + 1 < n else -1
        if onward != y:  # the edge y is on the right border
            _push_link(h, k, right + nr, h[i, 0], y)
            nr += 1
            k[right + nr, 0] = h[z, 0]
        if onward != z:
            nl -= 1
            _push_link(h, k, left + nl, h[z, 0], z)
    for last in (right + nr, left + n + 1):
        k[last, 1], k[last, 2], k[last, 3] = -1, -1, -1
    return left + nl, right + nr


@scalar
def _note_inner(h, k, low, high, behind, n):
    """Links with both sides on this corridor: cut them and list them, to be joined again later."""
    for c in range(low, high):
        if k[c, 1] >= 0 and h[k[c, 1], 3] == _IN_CAVITY:
            # Each inner link is seen from both sides; the lower half-edge lists it.
            if k[c, 3] < k[c, 1]:
                k[behind + n, 0], k[behind + n, 1], k[behind + n, 2] = k[c, 3], k[c, 1], k[c, 2]
                n += 1
            k[c, 1] = -1
    return n


@scalar
def _mark(h, k, free, n, value):
    """Mark the half-edges of n triangles."""
    for c in range(n):
        i = 3 * k[free + c, 3]
        h[i, 3] = h[i + 1, 3] = h[i + 2, 3] = value


@scalar
def insert_by_cavity(frame, mesh, points, p, first, a, b, goal, support):
    """Insert the constraint from p across half-edge `first` up to the next point of the line.

    Returns (point reached, -1), or (-1, constrained half-edge) where one has to be split first.
    """
    h, k = mesh.h, mesh.k
    n, reached, wall = _corridor(frame, mesh, points, first, a, b, goal)
    if wall >= 0:
        return -1, wall

    # Parts of the scratch rows: left chain, right chain, triangle slots, inner links.
    left = n + 2
    right = left + n + 3
    free = right + n + 3
    behind = free + n + 2
    low, last = _build_chains(mesh, n, p, left, right, free)
    _mark(h, k, free, n + 1, _IN_CAVITY)  # a link may lead into the corridor again
    inner = _note_inner(h, k, low, left + n + 1, behind, 0)
    inner = _note_inner(h, k, right, last, behind, inner)

    # Triangulate both sides; the constraint joins their bases.
    one, tri = _fill(frame, mesh, points, low, left + n + 2, free, 0)
    two, tri = _fill(frame, mesh, points, right, last + 1, free, tri)
    link(h, one, two, support)
    for c in range(inner):
        link(h, h[k[behind + c, 0], 3], h[k[behind + c, 1], 3], k[behind + c, 2])

    # Restore the Delaunay property of the new triangles.
    _mark(h, k, free, n + 1, 0)
    _legalize_ears(frame, mesh, points, free, n + 1)
    return reached, -1
