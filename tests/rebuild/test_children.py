"""What cut faces become: coordinates, doubts about turns, and room for points that are made."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf.arrangement import arrange, search
from geosurf.arrangement.arrange import cut_contacts
from geosurf.arrangement.search import find_contacts
from tests.strategies import soup


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 0, 2)])
def test_a_crossing_nearest_to_zero_is_not_zero(order, monkeypatch):
    """It is at -1/2 of the least number that there is, on two axes: 0 would count as exact.

    Such input is refused; constructed points alone may come so close.
    """
    monkeypatch.setattr(search, "MAX_SCALE", 2000)
    least = 2.0**-1074
    corners = (
        [[-9, -9, 0], [9, -9, 0], [0, 9, 0]],
        [[-2, -1, -3], [4, 1, -3], [1, 0, 9]],
        [[-1, -2, -3], [1, 4, -3], [0, 1, 9]],
    )
    surfaces = [soup(f"s{i}", [np.array(corners[i]) * least]) for i in order]
    contacts = find_contacts(surfaces, origin=np.zeros(3))
    children = cut_contacts(contacts)
    assert len(children.d) > len(contacts.d)  # crossings are made in the cut
    crossing = children.x[contacts.n_vertex + len(contacts.d) :]
    assert crossing.tolist() == [[-least, -least, 0.0]]
    zero = children.x[children.x == 0.0]
    assert len(zero) > 6
    assert not np.signbit(zero).any()


def combs(n):
    """A face, and two combs of upright triangles that cross in it n times n times."""
    at = np.arange(1, n + 1) / (n + 1.0)
    one = [[[p, -0.1, -1], [p + 0.01, 1.1, -1], [p, 0.5, 30]] for p in at]
    other = [[[-0.1, p, -1], [1.1, p + 0.01, -1], [0.5, p, 30]] for p in at]
    return [soup("face", [[[-5, -5, 0], [9, -5, 0], [-5, 9, 0]]]), soup("a", one), soup("b", other)]


def test_room_for_points_grows_to_the_same_children(monkeypatch):
    contacts = find_contacts(combs(9), pairs=[(0, 1), (0, 2)])
    roomy = cut_contacts(contacts)
    assert len(roomy.d) == len(contacts.d) + 81
    monkeypatch.setattr(arrange, "_MOST_CROSSINGS", -len(contacts.records) // 4)
    asked = []

    def watched(*arguments):
        asked.append(arguments[10])
        return cut_faces(*arguments)

    cut_faces = arrange.cut_faces
    monkeypatch.setattr(arrange, "cut_faces", watched)
    grown = cut_contacts(contacts)
    assert len(asked) > 1
    assert asked == sorted(asked)
    for name in ("x", "d", "triangles", "parent"):
        assert np.array_equal(getattr(grown, name), getattr(roomy, name)), name
