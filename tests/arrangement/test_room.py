"""Pairs that memory cannot hold are refused with numbers, before they are stored."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from geosurf import intersect_surfaces
from geosurf.arrangement import search, threads
from geosurf.errors import InputError
from tests import laws
from tests.growth import grid, seam
from tests.strategies import soup

LIMITED = pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are those of Linux")


def crossing(n):
    """n triangles, each of which meets nearly all others: n * n / 2 pairs."""
    rng = np.random.default_rng(3)
    return soup("Salt", rng.normal(size=(n, 3, 3)))


CHILD = """
import resource
import geosurf as gs
from tests.arrangement.test_room import crossing
gs.intersect_surfaces([crossing(40)], self_intersections=True)  # loads kernels
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (800 << 20),) * 2)
try:
    gs.intersect_surfaces([crossing(8000)], self_intersections=True)
except gs.errors.InputError as error:
    print(error)
"""


@LIMITED
def test_a_limit_of_the_process_is_met_before_memory_is_taken():
    done = subprocess.run([sys.executable, "-c", CHILD], capture_output=True, text=True, check=True)
    assert "surface 'Salt' has" in done.stdout
    assert "GB are free. Remove dup" in done.stdout


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
    monkeypatch.setattr(search, "_AT_ONCE", 7)
    assert laws.curve_bytes(
        intersect_surfaces([crossing(60)], self_intersections=True)
    ) == laws.curve_bytes(whole)
