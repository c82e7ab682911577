"""Rotated grids in a frame of their own: what is settled there is what exact signs say of them."""

import numpy as np
import pytest

from geosurf import TriSurface
from geosurf.arrangement import straight, upright
from geosurf.arrangement.crossing import crossing_pairs
from geosurf.arrangement.search import find_contacts
from geosurf.arrangement.turned import direction_of
from geosurf.model import Lattice
from tests.arrangement.test_upright import compare_with_voxels, contacts_by_key, watched

# whole numbers stay whole numbers, so that what touches or lies in one plane still does
MAPS = [[[3, -4], [4, 3]], [[2, 1], [-1, 3]], [[0, -1], [1, 0]], [[1, 2], [3, -1]]]


def scene(rng, matrix, scale, offset):
    """A grid with even steps and any other one, both mapped; small whole numbers."""
    n_row, n_col, m, k = rng.integers(2, 12, 4)
    z = rng.integers(-2, 3, (n_row, n_col)) * 1.0
    z[rng.random(z.shape) < rng.choice([0.0, 0.2])] = np.nan
    j, i = np.meshgrid(np.arange(n_col), np.arange(n_row))
    u, v = np.meshgrid(np.arange(k), np.arange(m))
    x = u + rng.integers(0, 3, (m, k)) + rng.integers(0, 4)
    y = rng.integers(0, 6, (m, k)) if rng.integers(2) else 2 * v
    h = rng.integers(-3, 4, (m, k)) * scale
    h[rng.random(h.shape) < 0.1] = np.nan

    def mapped(x, y):
        (a, b), (c, d) = matrix
        return offset + scale * (a * x + b * y), 2.0 * offset + scale * (c * x + d * y)

    top = Lattice(*mapped(2 * j, i), z * scale, bool(rng.integers(2)))
    wall = Lattice(*mapped(x, y), h, bool(rng.integers(2)), bool(rng.integers(2)))
    both = TriSurface("A", "horizon", lattice=top), TriSurface("B", "fault", lattice=wall)
    for one in both:
        one.checked = True  # as they are: triangles without area are not asked for here
    return both[::-1] if rng.integers(2) else both


@pytest.mark.parametrize("matrix", MAPS)
@pytest.mark.parametrize(("scale", "offset"), [(1.0, 0.0), (0.37, 0.0), (0.37, 3.1e6)])
@pytest.mark.parametrize("seed", range(12))
def test_contacts_are_those_of_voxels(matrix, scale, offset, seed):
    rng = np.random.default_rng([seed, round(offset)])
    compare_with_voxels(scene(rng, matrix, scale, offset))


def turned(x, y, degrees=30.0):
    a = np.radians(degrees)
    east, north = x * np.cos(a) - y * np.sin(a), x * np.sin(a) + y * np.cos(a)
    return 461_000.0 + east, 5_931_000.0 + north


def field(rng, n=60, other=True):
    """A rotated rough horizon and a fault through it, at coordinates of maps."""
    axis = 25.0 * np.arange(n)
    x, y = np.meshgrid(axis, axis)
    top = Lattice(*turned(x, y), -1500.0 + rng.normal(0.0, 3.0, x.shape))
    s, t = np.meshgrid(np.linspace(-40.0, 25.0 * n, 30), np.linspace(-60.0, 60.0, 12))
    across = 12.5 * n + 0.4 * t + 20.0 * np.sin(s / 300.0) + 0.1 * s
    wall = Lattice(*turned(across, s), -1500.0 + t, True, False)
    return TriSurface("A", "horizon", lattice=top), TriSurface("B", "fault", lattice=wall)


@pytest.mark.parametrize("swapped", [False, True])
def test_floats_settle_nearly_all_pairs_of_a_field(rng, swapped, monkeypatch):
    surfaces = field(rng)[:: -1 if swapped else 1]
    seen = []
    monkeypatch.setattr(upright, "settled_pairs", watched(upright.settled_pairs, seen))
    found = find_contacts(surfaces)
    by_voxels = find_contacts(surfaces, method="voxels")
    assert contacts_by_key(found) == contacts_by_key(by_voxels)
    assert len(found.rows) == len(seen[0]) > 100


def test_nodes_lie_where_the_bound_says(rng):
    top, wall = (one.lattice for one in field(rng))
    turn, made = straight._straight(top)
    m = turn.matrix.astype(np.longdouble)
    far = 2.0 * float(np.abs(wall.easting - turn.first[0]).max() + np.ptp(wall.northing))
    slip = turn.slip(top.shape, far, 0.0)
    for lattice, mapped in ((top, made), (wall, turn.apply(wall))):
        x, y = (
            of.astype(np.longdouble) - first
            for of, first in zip((lattice.easting, lattice.northing), turn.first, strict=True)
        )
        for k, own in enumerate(mapped.horizontal()):
            assert np.abs(m[k, 0] * x + m[k, 1] * y - own).max() <= slip < 1e-6


@pytest.mark.parametrize("seed", range(4))
def test_pairs_that_cross_do_not_depend_on_the_direction_of_boxes(seed):
    rng = np.random.default_rng(seed)
    x, y = turned(*rng.uniform(0.0, 900.0, (2, 400)))
    x = np.column_stack([x - 460_000.0, y - 5_930_000.0, rng.uniform(-30.0, 30.0, 400)])
    t = rng.integers(0, 400, (160, 3))
    near = np.argsort(np.hypot(x[:, 0] - x[t[:, 0], 0, None], x[:, 1] - x[t[:, 0], 1, None]))
    t[20:, 1:] = near[20:, 1:3]  # small ones, and some as large as all
    t = t[(t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 0] != t[:, 2])]
    plain = crossing_pairs(x, t)
    assert len(plain) > 30
    for degrees in (30.0, 75.0, 210.0):
        along = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        assert crossing_pairs(x, t, along=along).tolist() == plain.tolist()
        few = crossing_pairs(x, t[:60], t[60:], along=along)
        assert few.tolist() == crossing_pairs(x, t[:60], t[60:]).tolist()


def test_the_direction_is_that_of_columns(rng):
    top, wall = field(rng)
    assert direction_of([wall, top]) == pytest.approx((np.sqrt(0.75), 0.5))
    assert direction_of([wall]) is None
