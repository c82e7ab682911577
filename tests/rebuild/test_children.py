"""What cut faces become: coordinates, doubts about turns, and room for points that are made."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import TriSurface, rebuild_surfaces
from geosurf.arrangement import arrange, search
from geosurf.arrangement.arrange import cut_contacts
from geosurf.arrangement.search import find_contacts
from geosurf.kernels.contacts.triangle_contact import (
    COPLANAR,
    FIRST_CODE,
    N_COLUMN,
    N_CORNER,
    pack_contacts,
)
from geosurf.kernels.cutting.cut_faces import thin_children
from geosurf.kernels.exact.predicates import frame_of
from tests import laws
from tests.rebuild.test_patches import assert_true
from tests.strategies import shuffled, soup


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


# ---- Thin pieces are found as plain numpy finds them.
def slowly(x, t, pairs, y, children, parent, reach):
    """The same in numpy, array by array."""
    a, b, c = (x[t[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    sine = np.linalg.norm(np.cross(normal[pairs[:, 0]], normal[pairs[:, 1]]), axis=1)
    flattest = np.ones(len(t))
    for side in range(2):
        np.minimum.at(flattest, pairs[:, side], sine)
    a, b, c = (y[children[:, k]] for k in range(3))
    sides = np.stack([b - a, c - b, a - c])
    longest = np.linalg.norm(sides, axis=2).max(axis=0)
    height = np.linalg.norm(np.cross(sides[0], sides[2]), axis=1) / longest
    return height * flattest[parent] / reach


INSIDE = [8 * 3 + 6, 8 * 6 + 4]  # an edge of each through the face of the other


def contacts(pairs, codes=(), coplanar=0):
    """Rows of contacts in two points."""
    rows = np.zeros((len(pairs), N_COLUMN), dtype=np.int64)
    rows[:, :2], rows[:, COPLANAR], rows[:, N_CORNER] = pairs, coplanar, 2
    rows[:, FIRST_CODE : FIRST_CODE + 2] = codes or INSIDE
    return pack_contacts(rows)


def thin(x, t, rows, y, children, parent, reach):
    """Whether children are thin, by the kernel."""
    m, w = frame_of(x, len(t))
    found = thin_children(x, t, m, w, rows, y, children, parent, reach)
    mask = np.zeros(len(children), dtype=bool)
    mask[found] = True
    return mask


@pytest.mark.parametrize("reach", [0.02, 0.1, 0.4])
def test_as_in_numpy(rng, reach):
    x, y = rng.random((40, 3)), rng.random((90, 3))
    y[:30, 2] *= 1e-3
    t = np.array([rng.permutation(40)[:3] for _ in range(25)])
    children = np.array([rng.permutation(90)[:3] for _ in range(300)])
    pairs, parent = rng.integers(0, 25, (30, 2)), rng.integers(0, 25, 300)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    ratio = slowly(x, t, pairs, y, children, parent, reach)
    clear = np.abs(ratio - 1.0) > 1e-9
    found = thin(x, t, contacts(pairs), y, children, parent, reach)
    assert found.any()
    assert not found.all()
    assert (found == (ratio <= 1.0))[clear].all()
    none = contacts(pairs, coplanar=1)
    alone = slowly(x, t, pairs[:0], y, children, parent, reach)
    assert (thin(x, t, none, y, children, parent, reach) == (alone <= 1.0)).all()


# ---- Many segments of one face in one point: inside it, on its edge, in its corner.
FACE = TriSurface("Face", "horizon", [[0, 0, 0], [48, 0, 0], [0, 48, 0]], [[0, 1, 2]])
WAYS = [(3, 0), (2, 1), (1, 2), (0, 3), (-1, 2), (-2, 1), (3, 1), (-3, 2)]


def ending(at) -> TriSurface:
    """Sheets that hang together in the upright edge through a point."""
    x, y = at
    rim = [[x + 2 * u, y + 2 * v, 0] for u, v in WAYS] + [
        [x - 2 * u, y - 2 * v, 0] for u, v in WAYS
    ]
    fan = [[0, 1, 2 + i] for i in range(len(rim))]
    return TriSurface("Fan", "fault", [[x, y, -1], [x, y, 1], *rim], fan)


def passing(at) -> list[TriSurface]:
    """Sheets that pass through the upright line of a point."""
    x, y = at
    return [
        TriSurface(
            f"F{i}", "fault",
            [[x - 2 * u, y - 2 * v, -1], [x + 2 * u, y + 2 * v, -1], [x, y, 1]], [[0, 1, 2]],
        )
        for i, (u, v) in enumerate(WAYS)
    ]  # fmt: skip


def parts_of_edges(patches, name) -> set:
    piece = patches.surface(name)
    t = piece.triangles
    edges = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    return {frozenset(map(tuple, piece.vertices[edge].tolist())) for edge in edges}


@pytest.mark.parametrize("at", [(12, 12), (24, 0), (0, 0), (24, 24)])
def test_segments_that_end_in_one_point(at):
    patches = assert_true([FACE, ending(at)], exact=at == (0, 0))
    hub = (*map(float, at), 0.0)
    edges = parts_of_edges(patches, "Face")
    for x, y, _ in ending(at).vertices[2:]:
        if x >= 0 and y >= 0 and x + y <= 48:
            assert frozenset((hub, (x, y, 0.0))) in edges


@pytest.mark.parametrize("at", [(12, 12), (24, 0), (0, 0)])
def test_segments_that_pass_through_one_point(at):
    surfaces = [FACE, *passing(at)]
    patches = assert_true(surfaces, exact=at == (12, 12))
    hub = (*map(float, at), 0.0)
    edges = parts_of_edges(patches, "Face")
    for u, v in WAYS:
        for way in (1, -1):
            x, y = at[0] + way * u, at[1] + way * v
            if x >= 0 and y >= 0:
                assert frozenset((hub, (float(x), float(y), 0.0))) in edges
    rng = np.random.default_rng(5)
    again = rebuild_surfaces([shuffled(s, rng) for s in surfaces[::-1]])
    laws.assert_same_patches(patches, again)
    assert (patches.surface("Face").vertices == hub).all(axis=1).sum() == 1
    assert len(np.unique(patches.local, axis=0)) == len(patches.local)
