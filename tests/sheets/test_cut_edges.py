"""Which links of a lattice a trace cuts: every link asked, in whole numbers of any size."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geosurf.kernels.sheets.link_lines import UNIT, cut_links

N_ROW, N_COL = 4, 5
# ends off all lines of the lattice, some of them outside of it
PLACES = st.tuples(
    st.integers(-UNIT // 2, (N_COL * UNIT) // 2).map(lambda k: 4 * (k // 2) + 2),
    st.integers(-UNIT // 2, (N_ROW * UNIT) // 2).map(lambda k: 2 * k + 1),
)


def _is_left(p, q, n) -> bool:
    return (q[0] - p[0]) * (n[1] - p[1]) - (q[1] - p[1]) * (n[0] - p[0]) >= 0


def _every_link():
    for row in range(N_ROW):
        for col in range(N_COL):
            ends = {
                0: ((col, row), (col + 1, row)),
                1: ((col, row), (col, row + 1)),
                2: ((col, row), (col + 1, row + 1)),
                3: ((col + 1, row), (col, row + 1)),
            }
            for kind, link in ends.items():
                if all(x < N_COL and y < N_ROW for x, y in link):
                    yield row * N_COL + col, kind, [(x * UNIT, y * UNIT) for x, y in link]


@given(st.lists(st.tuples(PLACES, PLACES), min_size=1, max_size=4))
def test_links_are_those_that_pieces_cross(pieces):
    expected = []
    for number, (p, q) in enumerate(pieces):
        for node, kind, (m, n) in _every_link():
            left = _is_left(p, q, m)
            if left != _is_left(p, q, n) and _is_left(m, n, p) != _is_left(m, n, q):
                expected.append((node, kind, number, 1 if left else -1))
    rows, place = cut_links(np.array([[*p, *q] for p, q in pieces]), N_ROW, N_COL)
    assert list(map(tuple, rows.tolist())) == expected
    assert ((place >= 0.0) & (place <= 1.0)).all()


def test_some_cross_many_links_and_some_none():
    inside = [2, 1, UNIT - 2, 3]  # below the diagonals of its cell
    across = [-2, 5, (N_COL - 1) * UNIT + 2, 3]
    assert len(cut_links(np.array([inside]), N_ROW, N_COL)[0]) == 1
    assert len(cut_links(np.array([across]), N_ROW, N_COL)[0]) == 3 * (N_COL - 1) + 1
