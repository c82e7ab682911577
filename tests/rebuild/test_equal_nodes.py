"""Nodes of a lattice in one place: what a quick look proves, against a comparison of all nodes."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from geosurf.model import Lattice, TriSurface
from geosurf.rebuild.assemble import _rows_are_apart, first_of_equals

SHAPE = (3, 3)
NODES = arrays(np.float64, (3, *SHAPE), elements=st.integers(0, 7).map(float))


@given(NODES, st.booleans(), st.booleans())
def test_rows_that_are_apart_have_no_two_nodes_in_one_place(
    nodes: np.ndarray, in_order: bool, in_layers: bool
) -> None:
    """Rows are sorted and put into layers in part of the examples, where they often are apart."""
    x, y, z = nodes
    x = np.sort(x, axis=1) if in_order else x
    z = z % 2.0 - 2.0 * np.arange(3.0)[:, None] if in_layers else z
    places = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    if _rows_are_apart(x, y, z):
        assert len(np.unique(places, axis=0)) == len(places)


def test_rows_of_an_extruded_fault_are_apart() -> None:
    along, down = np.meshgrid(np.arange(4.0), np.arange(3.0))
    assert _rows_are_apart(0.5 * down, along, -down)
    assert _rows_are_apart(0.5 * down, -along, down)
    assert not _rows_are_apart(0.5 * down, along, np.minimum(-down, -1.0))  # two rows at one depth
    with_hole = -down
    with_hole[1, 2] = np.nan
    assert not _rows_are_apart(0.5 * down, along, with_hole)


def test_a_ring_has_its_first_column_twice() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 7)
    angle[-1] = 0.0
    x, y = np.cos(angle) * np.ones((2, 1)), np.sin(angle) * np.ones((2, 1))
    z = np.array([[0.0], [-5.0]]) * np.ones(7)
    first = first_of_equals(TriSurface("F1", "fault", lattice=Lattice(x, y, z)))
    assert first is not None
    assert first.reshape(2, 7)[:, -1].tolist() == [0, 7]
