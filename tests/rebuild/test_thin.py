"""Thin pieces are found as plain numpy finds them."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf import TriSurface
from geosurf.arrangement.arrange import cut_contacts
from geosurf.arrangement.search import find_contacts
from geosurf.kernels.contacts.packed_contact import pack_contacts
from geosurf.kernels.contacts.triangle_contact import COPLANAR, FIRST_CODE, N_COLUMN, N_CORNER
from geosurf.kernels.cutting.cut_faces import thin_children
from geosurf.kernels.exact.predicates import frame_of
from geosurf.model import Lattice


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


def counted(third, fourth, codes):
    """Whether a contact of two faces over the edge from (0, 0, 0) to (1, 0, 0) counts."""
    x = np.array([[0.0, 0, 0], [1, 0, 0], third, fourth])
    t, rows = np.array([[0, 1, 2], [0, 1, 3]]), contacts([[0, 1]], codes)
    child, parent = np.array([[0, 1, 2]]), np.zeros(1, np.int64)
    high = np.linalg.norm(np.cross(x[1], x[2]))
    return thin(x, t, rows, x, child, parent, 0.5 * high)[0]


def test_thin_is_the_same_by_any_search():
    """Horizons of one survey as lattices, and as lists, whose rims are all listed."""
    z, axis = np.random.default_rng(3).integers(0, 9, (2, 6, 6)) / 4.0, np.arange(6.0)
    z[1, 0, 3] = z[0, 0, 3]  # one point of both
    lattices = [
        TriSurface(name, "horizon", lattice=Lattice(axis, axis, heights))
        for name, heights in zip("ab", z, strict=True)
    ]
    lists = [TriSurface(s.name, s.role, s.vertices, s.triangles) for s in lattices]
    found, listed = [], []
    for surfaces in (lattices, lists):
        of = find_contacts(surfaces, self_intersections=True)
        children = cut_contacts(of)
        frame = of.x, of.t, of.m.copy(), of.w, of.rows
        limit = 0.03 * np.abs(of.x[of.t[children.parent]]).max()
        rows = thin_children(*frame, children.x, children.triangles, children.parent, limit)
        corners = np.sort(children.x[children.triangles[rows]].view("f8,f8,f8")[..., 0], axis=1)
        found.append({(int(of.surface_of_face[p]), c.tobytes())
                      for p, c in zip(children.parent[rows], corners, strict=True)})  # fmt: skip
        listed.append(len(of.rows))
    assert found[0] == found[1]
    assert 0 < len(found[0]) < len(children.triangles)
    assert listed[0] < listed[1]
