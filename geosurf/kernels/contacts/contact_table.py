"""Codes of a contact from a table: a lookup has no branch that the processor could mispredict.

The two edges at the lone corner of a triangle pass the plane of another triangle, each beyond some
of its edges. Mostly this determines where the contact begins and ends.

Notation
    i      the lone corner of the first triangle; edge i leaves it, edge i + 2 enters it
    side   edges of the second triangle, as bits, beyond which an edge passes; or UNKNOWN_SIDE
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import scalar
from geosurf.kernels.contacts.triangle_contact import FACE

UNDECIDED = -2  # heights do not decide
UNKNOWN_SIDE, N_SIDE = 8, 9


@scalar
def code_of_edge(edge, of_first):
    """Code of a corner of a contact: an edge of one triangle, the face of the other."""
    return 8 * (3 + edge) + FACE if of_first else 8 * FACE + 3 + edge


@scalar
def contact_codes(swapped):
    """Results of `contact_by_heights` for each lone corner and the sides of its two edges.

    With `swapped`, codes are those of the second and the first triangle.
    """
    table = np.full(3 * N_SIDE * N_SIDE, UNDECIDED)
    for i in range(3):
        # Rows of UNKNOWN_SIDE stay UNDECIDED.
        for first in range(UNKNOWN_SIDE):
            for last in range(UNKNOWN_SIDE):
                table[(N_SIDE * i + first) * N_SIDE + last] = _codes_of_sides(
                    i, first, last, swapped
                )
    return table


@scalar
def _codes_of_sides(i, first, last, swapped):
    """Codes where edge i passes beyond the edges `first`, and edge i + 2 beyond `last`."""
    # Both beyond one edge: no contact. Both inside: two edge-face points.
    i2 = (i + 2) % 3
    if first & last != 0:
        return 0
    out = first + last
    if out == 0:
        return 64 * code_of_edge(min(i, i2), not swapped) + code_of_edge(max(i, i2), not swapped)

    # Anything but one edge passing beyond one edge needs more signs.
    if (first != 0 and last != 0) or out & (out - 1) != 0:
        return UNDECIDED

    # The edge that passes inside pierces the face. Where the other passes outside, the contact ends
    # on that edge of the second triangle.
    own, other = code_of_edge(i if last != 0 else i2, not swapped), code_of_edge(out >> 1, swapped)
    return 64 * other + own if swapped else 64 * own + other
