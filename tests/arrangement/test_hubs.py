"""Fans and books: n triangles at a vertex or an edge cost about n, and nothing is overlooked."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from geosurf import TriSurface, intersect_surfaces, rebuild_surfaces
from geosurf.arrangement import hubs
from geosurf.arrangement.hubs import hubs_of, pairs_around_hubs
from geosurf.kernels.search.vertex_fans import direction_boxes
from tests import laws, oracles
from tests.growth import book, closed_cone, fan
from tests.strategies import UTM, soup

NEVER = 1 << 40


def crowd(seed):
    """Triangles with corners in common, some in one plane, on a lattice, or next to it."""
    rng = np.random.default_rng(seed)
    corners = rng.integers(0, rng.integers(3, 7), (rng.integers(3, 26), 3, 3)).astype(float)
    shared = rng.integers(3)
    if shared >= 1:
        corners[:, 0] = 1.0
    if shared == 2:
        corners[:, 1] = [2, 1, 0]
    if rng.random() < 0.3:
        corners[rng.random(len(corners)) < 0.5] += rng.normal(0, 0.3, 3)
    if rng.random() < 0.3:
        corners *= [1, 1, rng.choice([1, 0, 1e-9])]
    if rng.random() < 0.3:
        corners += UTM
    corners = [c for c in corners if not oracles.flat(c)]
    return soup("A", corners if corners else [[(0, 0, 0), (1, 0, 0), (0, 1, 0)]])


def test_curves_are_those_of_all_pairs(monkeypatch):
    n_segment = 0
    for seed in range(60):
        monkeypatch.setattr(hubs, "MANY", NEVER)
        slow = intersect_surfaces([crowd(seed)], self_intersections=True)
        monkeypatch.setattr(hubs, "MANY", 1 + seed % 3)
        for method in ("tree", "voxels"):
            fast = intersect_surfaces([crowd(seed)], self_intersections=True, method=method)
            assert laws.curve_bytes(fast) == laws.curve_bytes(slow), seed
        n_segment += len(slow.segments)
    assert n_segment > 500


@pytest.mark.parametrize("seed", range(6))
def test_patches_are_those_of_all_pairs(seed, monkeypatch):
    monkeypatch.setattr(hubs, "MANY", NEVER)
    slow = rebuild_surfaces([crowd(seed)], self_intersections=True)
    monkeypatch.setattr(hubs, "MANY", 2)
    laws.assert_same_patches(slow, rebuild_surfaces([crowd(seed)], self_intersections=True))


@pytest.mark.parametrize("make", [fan, closed_cone, book])
def test_pairs_grow_with_triangles(make):
    n_pair = {}
    for n in (1000, 4000):
        curves = intersect_surfaces([make(n)], self_intersections=True)
        assert len(curves.segments) == 0
        n_pair[n] = curves.cost["pairs_tested"]
    assert n_pair[4000] < 5 * n_pair[1000]
    assert n_pair[4000] < 10 * 4000


def test_a_fan_that_goes_around_twice_crosses_itself():
    """Two turns with different waves: they cross along lines from the vertex to the rim."""
    n = 1200
    turn = np.linspace(0, 4 * np.pi, n, endpoint=False)
    rim = np.c_[10 * np.cos(turn), 10 * np.sin(turn), np.sin(2.5 * turn)]
    k = np.arange(n)
    surface = TriSurface(
        "A", "fault", np.vstack([[0, 0, 0.25], rim]), np.c_[0 * k, 1 + k, 1 + (k + 1) % n]
    )
    curves = intersect_surfaces([surface], self_intersections=True)
    # sin(5 a / 2) = sin(5 a / 2 + 5 pi) = -sin(5 a / 2) at five angles
    assert curves.n_curve == 5
    assert curves.cost["pairs_tested"] < 20 * n
    assert curves.length == pytest.approx(5 * np.hypot(10, 0.25), rel=1e-3)


def test_pages_of_a_book_that_lie_on_one_another_are_found():
    one = book(600)
    rows = np.concatenate([one.triangles, one.triangles[[7]]])
    vertices = np.vstack([one.vertices, 0.5 * (one.vertices[0] + one.vertices[9])])
    rows[-1, 2] = len(vertices) - 1  # in the plane of page 7, half as wide
    curves = intersect_surfaces([TriSurface("A", "fault", vertices, rows)], self_intersections=True)
    assert [touch.kind for touch in curves.contacts] == ["area"]


def test_directions_hold_all_of_a_triangle(rng):
    """Also where it is wide, around an axis, or has the eye as a corner."""
    for _ in range(300):
        x = rng.normal(size=(3, 3)) * rng.choice([0.1, 1, 10]) + rng.normal(size=3)
        eye = x[0].copy() if rng.random() < 0.3 else rng.integers(-1, 2, 3).astype(float)
        box = direction_boxes(x, np.array([[0, 1, 2]]), eye, 0.0)[0]
        to = rng.dirichlet([0.5, 0.5, 0.5], 200) @ x - eye
        to /= np.linalg.norm(to, axis=1)[:, None]
        assert (to >= box[:3]).all()
        assert (to <= box[3:]).all()


def test_lists_without_hubs_are_searched_as_ever():
    flat = soup("A", [[(0, 0, 0), (9, 0, 0), (0, 9, 0)]])
    assert len(hubs_of(flat)[1]) == 0
    assert len(hubs_of(fan(hubs.MANY + 1))[1]) == 1
    pairs, _ = pairs_around_hubs(fan(300), *hubs_of(fan(300)))
    assert len(np.unique(pairs, axis=0)) == len(pairs)


CHILD = """
import resource
import geosurf as gs
from tests.growth import fan
gs.intersect_surfaces([fan(300)], self_intersections=True)  # loads kernels
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (300 << 20),) * 2)
print(len(gs.intersect_surfaces([fan(30_000)], self_intersections=True).segments))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are those of Linux")
def test_a_fan_of_30_000_triangles_takes_less_than_300_megabytes():
    done = subprocess.run([sys.executable, "-c", CHILD], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "0"
