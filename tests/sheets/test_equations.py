"""The equations of the smoothest surface against differences that are written out one by one."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geosurf.errors import InvariantError
from geosurf.kernels.sheets.smooth_surface import (
    energy_gradient,
    fill_envelope,
    normal_equations,
    places_in_order,
)
from geosurf.sheets.lattice.solve import fourth_order, lattice_graph, smoothest, without_absent

LINE = [(-1, 1), (1, -2, 1), (-1, 3, -3, 1), (1, -4, 6, -4, 1)]


def differences(shape, present, bits, weights, fourth=0.0):
    """Rows of the energy over all nodes: each difference whose block is there and uncut."""
    n_row, n_col = shape
    e, a, c, wx, wy = weights

    def whole(i, j, tall, wide):
        """Whether all nodes of a block are there, and none of its links is cut."""
        if i + tall >= n_row or j + wide >= n_col:
            return False
        if not present[i : i + tall + 1, j : j + wide + 1].all():
            return False
        for k, m in product(range(tall + 1), range(wide + 1)):
            cut = int(bits[i + k, j + m])
            if (m < wide and cut & 1) or (k < tall and cut & 2):
                return False
            if m < wide and k < tall and cut & 12:
                return False
        return True

    rows = []

    def add(i, j, block, scale):
        """One difference from node (i, j) on; `block` has its weights by row and column."""
        block = np.atleast_2d(block)
        if scale and whole(i, j, block.shape[0] - 1, block.shape[1] - 1):
            row = np.zeros(shape)
            row[i : i + block.shape[0], j : j + block.shape[1]] = scale * block
            rows.append(row.ravel())

    for i, j in product(range(n_row), range(n_col)):
        for order, scale in enumerate((e, a, c, fourth), start=1):
            add(i, j, [LINE[order - 1]], scale * wx**order)
            add(i, j, np.transpose([LINE[order - 1]]), scale * wy**order)
        add(i, j, [[1, -1], [-1, 1]], a * np.sqrt(2) * wx * wy)
        ramp = np.array([[1, -2, 1], [-1, 2, -1]])
        add(i, j, ramp, c * np.sqrt(3) * wx * wx * wy)
        add(i, j, ramp.T, c * np.sqrt(3) * wx * wy * wy)
        slope = np.outer(LINE[0], LINE[2])
        add(i, j, slope, fourth * 2 * wx**3 * wy)
        add(i, j, slope.T, fourth * 2 * wx * wy**3)
        add(i, j, np.outer(LINE[1], LINE[1]), fourth * np.sqrt(6) * wx**2 * wy**2)
    return np.array(rows).reshape(-1, n_row * n_col)


@st.composite
def torn_lattices(draw):
    """A small lattice with holes and cut links, some of its nodes unknown."""
    shape = draw(st.integers(2, 6)), draw(st.integers(2, 6))
    n = shape[0] * shape[1]
    absent = draw(st.sets(st.integers(0, n - 1), max_size=3))
    cut = draw(st.dictionaries(st.integers(0, n - 1), st.integers(1, 15), max_size=4))
    free = draw(st.sets(st.integers(0, n - 1), max_size=n))
    weights = draw(st.sampled_from([(0.01, 0.0, 0.0), (0.01, 1.0, 0.0), (0.01, 0.3, 1.0)]))
    stretch = draw(st.sampled_from([(1.0, 1.0), (0.8, 1.25)]))
    present, bits = np.ones(n, dtype=bool), np.zeros(n, dtype=np.uint8)
    present[list(absent)] = False
    for node, links in cut.items():
        bits[node] = links
    unknown = np.full(n, -1)
    free = sorted(free - absent)
    unknown[free] = draw(st.permutations(range(len(free))))
    return shape, present, bits, unknown, np.array([*weights, *(1.0 / np.array(stretch))])


@settings(max_examples=60)
@given(torn_lattices())
def test_matrix_and_right_side_are_those_of_all_differences(case):
    shape, present, bits, unknown, weights = case
    n = len(unknown)
    graph = without_absent(lattice_graph(np.arange(n), shape, bits), present)
    rows = differences(shape, present.reshape(shape), bits.reshape(shape), weights)
    whole = rows.T @ rows
    value = np.cos(np.arange(n)) * 10.0
    free = np.flatnonzero(unknown >= 0)
    order = free[np.argsort(unknown[free])]
    place = places_in_order(graph.east, graph.north, unknown)
    assert sorted(place.tolist()) == list(range(len(free)))
    first, lower, start, right = fill_envelope(
        graph.east, graph.north, graph.square, unknown, value, weights, place
    )
    wanted = np.zeros((len(free), len(free)))
    wanted[np.ix_(place, place)] = whole[np.ix_(order, order)]
    found = np.zeros_like(wanted)
    for i in range(len(free)):
        found[i, first[i] : i + 1] = lower[start[i] : start[i + 1]]
    assert found == pytest.approx(np.tril(wanted), abs=1e-12)
    known = unknown < 0
    side = -(whole[np.ix_(order, known)] @ value[known])
    assert right[place] == pytest.approx(side, abs=1e-9)
    # the same energy, by slots and as a derivative
    matrix, column = normal_equations(
        graph.east, graph.north, graph.square, graph.cell, unknown, weights
    )
    dense = np.zeros_like(wanted)
    p, slot = np.nonzero(column >= 0)
    np.add.at(dense, (p, column[p, slot]), matrix[p, slot])
    assert dense == pytest.approx(whole[np.ix_(order, order)], abs=1e-12)
    bent = energy_gradient(graph.east, graph.north, graph.square, np.eye(n), weights)
    assert bent == pytest.approx(whole, abs=1e-12)


@settings(max_examples=60)
@given(torn_lattices())
def test_fourth_differences_are_those_that_are_written_out(case):
    shape, present, bits, unknown, weights = case
    n = len(unknown)
    graph = without_absent(lattice_graph(np.arange(n), shape, bits), present)
    lower, fourth = fourth_order(graph, 1.0 / weights[3:])
    rows = differences(shape, present.reshape(shape), bits.reshape(shape), lower, 1.0)
    whole = rows.T @ rows
    low = energy_gradient(graph.east, graph.north, graph.square, np.eye(n), lower)
    assert low + fourth.gradient(np.eye(n)) == pytest.approx(whole, abs=1e-12)

    # equations of the unknown nodes: what the factor solves is what was written out
    free = np.flatnonzero(unknown >= 0)
    order = free[np.argsort(unknown[free])]
    value = np.cos(np.arange(n)) * 10.0
    pull, target = np.ones(len(free)), np.sin(np.arange(len(free)))
    stretch = 1.0 / weights[3:]
    found = smoothest(graph, unknown, value, stretch, pull=pull, target=target, order=4)
    side = target - whole[np.ix_(order, unknown < 0)] @ value[unknown < 0]
    matrix = whole[np.ix_(order, order)] + np.eye(len(free))
    assert found == pytest.approx(np.linalg.solve(matrix, side), abs=1e-9)


def test_a_cubic_is_carried_on_beyond_the_data():
    """Fourth differences of a cubic are zero: where data end, it goes on as it is."""
    row, col = np.divmod(np.arange(400), 20)
    x, y = 0.1 * col, 0.1 * row
    cubic = 3.0 * x**3 - 2.0 * x**2 * y + x * y**2 + y**3 - x * y + 4.0
    unknown = np.where(col >= 14, np.cumsum(col >= 14) - 1, -1)
    graph = lattice_graph(np.arange(400), (20, 20))
    wall = unknown >= 0
    exact = cubic[wall]
    third, fourth = (
        smoothest(graph, unknown, np.where(wall, 0.0, cubic), np.ones(2), order=k) for k in (3, 4)
    )
    near = col[wall] < 18
    assert np.abs(fourth - exact)[near].max() < 0.3 * np.abs(third - exact)[near].max()


def test_equations_without_any_datum_are_refused():
    graph = lattice_graph(np.arange(9), (3, 3))
    with pytest.raises(InvariantError, match=r"singular at unknown \d+ of 9"):
        smoothest(graph, np.arange(9), np.zeros(9), np.ones(2), bend=0.0, third=0.0)


@given(st.lists(st.tuples(st.integers(-1, 8), st.integers(-1, 8)), min_size=9, max_size=9))
def test_places_are_each_taken_once_whatever_is_linked(links):
    """At a tip two sheets have a neighbour in common: no node may be forgotten for it."""
    east, north = np.array(links).T.copy()
    for to in (east, north):
        to[to == np.arange(9)] = -1  # none is its own neighbour
    number = np.array([3, -1, 0, 1, -1, 2, 4, 6, 5])
    assert sorted(places_in_order(east, north, number).tolist()) == list(range(7))
