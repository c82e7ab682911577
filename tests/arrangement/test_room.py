"""Pairs that memory cannot hold are refused with numbers, before they are stored."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from benchmarks.growth import grid, seam
from geosurf import TriSurface, intersect_surfaces, intersect_triangles, rebuild_surfaces
from geosurf.arrangement import gather, threads
from geosurf.errors import InputError, SurfaceError
from geosurf.kernels.exact.predicates import MAX_COORDINATE, MIN_COORDINATE
from tests import laws
from tests.arrangement import extremes
from tests.processes import told_by
from tests.strategies import soup

LIMITED = pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are those of Linux")


def crossing(n):
    """n triangles, each of which meets nearly all others: n * n / 2 pairs."""
    return soup("Salt", np.random.default_rng(3).normal(size=(n, 3, 3)))


CHILD = """
import resource
import numpy as np
import geosurf as gs
def crossing(n):
    corners = np.random.default_rng(3).normal(size=(3 * n, 3))
    return gs.TriSurface("Salt", "surface", corners, np.arange(3 * n).reshape(n, 3))
gs.intersect_surfaces([crossing(40)], self_intersections=True)  # loads kernels
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (200 << 20),) * 2)
try:
    gs.intersect_surfaces([crossing(4000)], self_intersections=True)
except gs.errors.InputError as error:
    print(error)
"""


@LIMITED
def test_a_limit_of_the_process_is_met_before_memory_is_taken():
    said = told_by("-c", CHILD)
    assert "surface 'Salt' has" in said
    assert "GB are free. Remove dup" in said


@pytest.mark.parametrize("method", ["tree", "voxels"])
def test_candidates_beyond_what_is_free_are_an_error(method, monkeypatch):
    monkeypatch.setattr(threads, "_SMALL", 0)
    monkeypatch.setattr(threads, "free_memory", lambda: 1_000_000)
    with pytest.raises(
        InputError, match=r"'A' and 'B' have .* pairs .* free\. Remove dup"
    ) as caught:
        intersect_surfaces([grid("A", 160), grid("B", 160)], method=method)
    assert caught.value.surfaces == ("A", "B")


def test_contacts_beyond_what_is_free_are_an_error(monkeypatch):
    monkeypatch.setattr(threads, "_SMALL", 0)
    monkeypatch.setattr(threads, "free_memory", lambda: 80_000)
    with pytest.raises(InputError, match=r"'Salt' has .* pairs of triangles that meet, which need"):
        intersect_surfaces([crossing(45)], self_intersections=True)


def test_points_along_a_line_beyond_what_is_free_are_an_error(monkeypatch):
    monkeypatch.setattr(threads, "_SMALL", 200_000)
    monkeypatch.setattr(threads, "free_memory", lambda: 400_000)
    with pytest.raises(InputError, match=r"'A' has .* points and segments that lie along one line"):
        intersect_surfaces(seam(30), self_intersections=True)


def test_parts_of_the_pairs_make_one_answer(monkeypatch):
    whole = intersect_surfaces([crossing(60)], self_intersections=True)
    monkeypatch.setattr(gather, "_AT_ONCE", 7)
    assert laws.curve_bytes(
        intersect_surfaces([crossing(60)], self_intersections=True)
    ) == laws.curve_bytes(whole)


# ---- Coordinates from the least to the largest numbers: a right answer, or a refusal with a r
@pytest.mark.parametrize("kind", range(len(extremes.KINDS)))
def test_any_size(kind):
    for seed in range(4):
        extremes.check(kind + seed * len(extremes.KINDS))


@pytest.mark.parametrize("size", [1e-300, 1e-317, 5e-324])
def test_the_surface_whose_numbers_are_too_small_is_named(size):
    """Rounding errors below the least normal number once counted as none: memory was overrun."""
    flat = soup("A", [[(0, 0, 0), (4 * size, 0, 0), (0, 4 * size, 0)]])
    wall = soup("B", [[(size, size, -size), (size, size, size), (9 * size, 0, size)]])
    for function in (intersect_surfaces, rebuild_surfaces):
        with pytest.raises(InputError, match=r"surface 'A' has a coordinate of .*0 and sizes from"):
            function([flat, wall])
    with pytest.raises(SurfaceError, match="triangle P has a coordinate too close to 0"):
        intersect_triangles(flat.vertices, wall.vertices)


@pytest.mark.parametrize("size", [MIN_COORDINATE, 2.0**-240, 1.0, MAX_COORDINATE / 4])
def test_the_sizes_that_are_promised_are_taken(size):
    """Coordinates with all of their digits, at both ends of the range."""
    corners = size * (1 + np.random.default_rng(5).random((4, 3, 3)))
    surfaces = [soup("A", corners[:2]), soup("B", corners[2:])]
    small, plain = (
        rebuild_surfaces(
            [TriSurface(s.name, s.role, s.vertices * k, s.triangles) for s in surfaces]
        )
        for k in (1.0, 1.0 / size)
    )
    assert small.report["cut_triangles"] == plain.report["cut_triangles"]
    assert intersect_surfaces(surfaces).n_curve == intersect_surfaces(surfaces[::-1]).n_curve
