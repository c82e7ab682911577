"""Contacts in three numbers: two faces, and how they meet, packed into the third.

All stages after the search run over all contacts several times. Rows of `triangle_contact`, with
room for six corners, have eleven numbers; three are read from memory in a quarter of the time.

Notation
    rows   contacts, int64 (n, 3), columns below
    how    number of corners (3 bits), whether the faces are coplanar and whether they cross (1 bit
           each), and the code of each corner (7 bits), the first one lowest
"""

from __future__ import annotations

import numpy as np

from geosurf.kernels.compile.jit import entry, scalar
from geosurf.kernels.contacts.triangle_contact import COPLANAR, CROSSING, FACE, FIRST_CODE, N_CORNER

TRIANGLE_A, TRIANGLE_B, HOW = 0, 1, 2
_CORNERS, _IN_PLANE, _CROSSING = 7, 8, 16  # masks
_FIRST, _CODE = 5, 7  # bits before the codes, and of each


@scalar
def n_corner_of(how):
    """Number of corners of a contact."""
    return how & _CORNERS


@scalar
def lies_in_plane(how):
    """Whether two faces are coplanar."""
    return how & _IN_PLANE != 0


@scalar
def code_of(how, corner):
    """Code of a corner of a contact, see `triangle_contact`."""
    return (how >> (_FIRST + _CODE * corner)) & ((1 << _CODE) - 1)


@scalar
def lies_on_boundaries(how):
    """Whether a contact is a point or a line on edges and corners of both faces."""
    # Three corners or more: an area.
    if n_corner_of(how) >= 3:
        return False
    for corner in range(n_corner_of(how)):
        code = code_of(how, corner)
        # A corner in the face of either triangle is not on its boundary.
        if (code >> 3) & 7 >= FACE or code & 7 >= FACE:
            return False
    return True


def n_corners(rows: np.ndarray) -> np.ndarray:
    """Number of corners of each contact, int64 (n,)."""
    return rows[:, HOW] & _CORNERS


def in_plane(rows: np.ndarray) -> np.ndarray:
    """Whether the faces of each contact lie in one plane, bool (n,)."""
    return rows[:, HOW] & _IN_PLANE != 0


def on_boundaries(rows: np.ndarray) -> np.ndarray:
    """Which contacts are points and lines on edges and corners of both faces, bool (n,)."""
    n = n_corners(rows)
    found: np.ndarray = n < 3
    for corner in range(2):
        code = code_of(rows[:, HOW], corner)
        inside = ((code >> 3) & 7 >= FACE) | (code & 7 >= FACE)
        found &= ~(inside & (corner < n))
    return found


@entry("l2 -> l2")
def pack_contacts(rows):
    """Pack rows of `triangle_contact` into three numbers."""
    out = np.empty((rows.shape[0], 3), dtype=np.int64)
    for k in range(rows.shape[0]):
        # Number of corners in the lowest bits, then flags, then codes.
        how = rows[k, N_CORNER]
        how += _IN_PLANE if rows[k, COPLANAR] == 1 else 0
        how += _CROSSING if rows[k, CROSSING] == 1 else 0
        for corner in range(rows[k, N_CORNER]):
            how += rows[k, FIRST_CODE + corner] << (_FIRST + _CODE * corner)
        out[k, TRIANGLE_A], out[k, TRIANGLE_B], out[k, HOW] = rows[k, 0], rows[k, 1], how
    return out


@entry("l2 b1 l l1* -> l1")
def pack_decided(pairs, is_new, is_open, codes):
    """Pack crossings in two points of pairs that are new, to their codes; the other new pairs.

    The third number of a pair is ``64 * first + second`` of the codes of its points, or `is_open`.
    """
    waiting = np.empty(pairs.shape[0], dtype=np.int64)
    n = 0
    for k in range(pairs.shape[0]):
        if not is_new[k]:
            continue
        if pairs[k, HOW] == is_open:
            waiting[n] = k
            n += 1
            continue
        # Codes of crossings fit six bits: EDGE_OF_SECOND occurs in other contacts only.
        one, two = pairs[k, HOW] >> 6, pairs[k, HOW] & 63
        codes[k] = 2 + _CROSSING + (one << _FIRST) + (two << (_FIRST + _CODE))
    return waiting[:n].copy()


NEAR_BIT = 60  # of a settled code; corners need fewer bits
NOTHING = 0  # the settled code of a pair that does not meet: contacts have corners


@entry("l2 l2 l1 -> l1")
def settled(pairs, rows, near):
    """How each pair meets: the third number of its row, or NOTHING, and a bit for near pairs.

    `rows` are those of the pairs that meet, in the order of `pairs`; `near` are rows of `pairs`.
    """
    out = np.empty(pairs.shape[0], dtype=np.int64)
    n = 0
    for k in range(pairs.shape[0]):
        out[k] = NOTHING
        if n < rows.shape[0] and rows[n, 0] == pairs[k, 0] and rows[n, 1] == pairs[k, 1]:
            out[k] = rows[n, HOW]
            n += 1
    for k in range(near.shape[0]):
        out[near[k]] |= 1 << NEAR_BIT
    return out


@entry("l2 l1 -> l2 l2")
def of_settled(pairs, codes):
    """Contacts (n, 3) and near pairs (n, 2) of settled pairs."""
    n = n_near = 0
    for k in range(pairs.shape[0]):
        n += 1 if code_without_bit(codes[k]) != NOTHING else 0
        n_near += (codes[k] >> NEAR_BIT) & 1
    rows = np.empty((n, 3), dtype=np.int64)
    near = np.empty((n_near, 2), dtype=np.int64)
    n = n_near = 0
    for k in range(pairs.shape[0]):
        how = code_without_bit(codes[k])
        if how != NOTHING:
            rows[n, TRIANGLE_A], rows[n, TRIANGLE_B], rows[n, HOW] = pairs[k, 0], pairs[k, 1], how
            n += 1
        if (codes[k] >> NEAR_BIT) & 1 == 1:
            near[n_near, 0], near[n_near, 1] = pairs[k, 0], pairs[k, 1]
            n_near += 1
    return rows, near


@scalar
def code_without_bit(code):
    """How a settled pair meets."""
    return code & ((1 << NEAR_BIT) - 1)
