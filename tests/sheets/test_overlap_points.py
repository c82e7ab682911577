"""Scattered points past the trace of a reverse fault: on the ghosts of their own wall."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from geosurf.kernels.sheets.smooth_surface import energy_gradient
from geosurf.sheets.lattice.solve import BEND, lattice_graph, weights_of
from geosurf.sheets.mesh.finish import _drawn_to, points_beyond_trace

SIDE = 4  # nodes


class Near:
    """Four rows of nodes, the two lower ones on the left of a trace, the others on its right."""

    side = np.array([0.0, 1.0, -1.0])

    def look_up(self, node):
        """Row 1 for nodes of the left side, 2 for those of the right one."""
        return np.where(node < 2 * SIDE, 1, 2)


def case(uv: list[tuple[float, float]], ghosts: list[tuple[int, int]]):
    """Points of the left wall, and ghosts (anchor, node) beside 16 nodes."""
    uv = np.array(uv)
    j, i = np.floor(uv).astype(int).T
    x, y = (uv - np.stack([j, i], axis=1)).T
    a = SIDE * i + j
    nodes = np.stack([a, a + 1, a + SIDE, a + SIDE + 1], axis=1)
    share = np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=1)
    anchor, node = np.array(ghosts).T
    picks = SimpleNamespace(corners=lambda: (nodes, share))
    past = np.stack([np.arange(len(uv)), np.zeros(len(uv), int), np.ones(len(uv), int)], axis=1)
    torn = SimpleNamespace(anchor=anchor, node_of_ghost=node, n_node=SIDE**2)
    return points_beyond_trace(picks, SimpleNamespace(near=[Near()], beyond=past), torn), share


def test_a_point_past_a_trace_is_between_the_vertices_of_its_own_wall():
    """Over the other wall these are its ghosts; a point that lacks one tells nothing yet."""
    uv = [(0.25, 1.5), (1.5, 1.25), (0.5, 2.5)]
    ghosts = [(4, 8), (5, 9), (4, 12), (5, 13), (9, 5)]  # the last one is of the other wall
    (vertex, found, pick), share = case(uv, ghosts)
    assert pick.tolist() == [0, 2]  # no ghost over node 10
    assert vertex.tolist() == [[4, 5, 16, 17], [16, 17, 18, 19]]
    assert found == pytest.approx(share[[0, 2]])


def test_where_a_wall_has_two_ghosts_over_a_node_no_point_tells_which():
    (vertex, _, pick), _ = case([(0.5, 1.5)], [(4, 8), (5, 8), (5, 9)])
    assert len(vertex) == len(pick) == 0


@pytest.mark.parametrize("weight", [None, 0.02])
def test_heights_drawn_to_points_are_those_of_dense_equations(weight):
    rng = np.random.default_rng(4)
    graph = lattice_graph(np.arange(64), (8, 8))
    value = rng.normal(-1800.0, 20.0, 64)
    moves = np.zeros((8, 8), dtype=bool)
    moves[2:7, 1:6] = True
    moves = moves.ravel()
    corner = rng.integers(0, 7, (40, 2))
    slot = (8 * corner[:, :1] + corner[:, 1:]) + [0, 1, 8, 9]
    share = rng.dirichlet(np.ones(4), 40)
    z = rng.normal(-1800.0, 20.0, 40)
    found = _drawn_to(graph, value, moves, slot, share, z, np.ones(2), weight)
    scale = 1.0 if weight is None else weight ** (-1.0 / 6.0)
    weights = weights_of(np.ones(2), BEND, scale=scale)
    energy = energy_gradient(graph.east, graph.north, graph.square, np.eye(64), weights)
    points = np.zeros((40, 64))
    np.put_along_axis(points, slot, share, axis=1)
    whole = energy + (weight or 1.0) * points.T @ points
    right = (weight or 1.0) * points.T @ z - whole[:, ~moves] @ value[~moves]
    wanted = np.linalg.solve(whole[np.ix_(moves, moves)], right[moves])
    assert found[moves] == pytest.approx(wanted, abs=1e-4)
    assert (found[~moves] == value[~moves]).all()
