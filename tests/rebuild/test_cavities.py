"""One segment across hundreds of triangles: both sides are triangulated anew, and Delaunay."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest

from geosurf import TriSurface, rebuild_surfaces
from tests import laws, oracles

FACE = TriSurface(
    "Face", "horizon", [[-4096, -4096, 0], [4096, -4096, 0], [0, 4096, 0]], [[0, 1, 2]]
)
ARCS = {
    "away": lambda k: 8 + (400 - k * k) // 4,
    "towards": lambda k: 8 + k * k // 4,
    "straight": lambda k: 9 + 0 * k,
    "zigzag": lambda k: 8 + 40 * (k % 3),
    "steep": lambda k: 8 + 4 * (400 - k * k),
    "spikes": lambda k: 8 + 500 * (k % 7 == 0),
}


def upright(name, segments) -> TriSurface:
    """Triangles that meet the level 0 in segments (x, y, x, y)."""
    segments = np.asarray(segments, dtype=float)
    a, b = segments[:, :2], segments[:, 2:]
    middle, up = (a + b) / 2, np.full((len(a), 1), 4.0)
    rows = [
        np.hstack([2 * a - middle, up]),
        np.hstack([2 * b - middle, up]),
        np.hstack([middle, -up]),
    ]
    corners = np.stack(rows, axis=1).reshape(-1, 3)
    return TriSurface(name, "fault", corners, np.arange(len(corners)).reshape(-1, 3))


def assert_delaunay(patches, name) -> int:
    """Every edge that no curve runs on has the empty circle (rationals); returns how many."""
    rows = np.flatnonzero(patches.surface_of_triangle == 0)
    curves = {frozenset(edge) for edge in patches.curve_edges.tolist()}
    opposite = defaultdict(list)
    for a, b, c in patches.triangles[rows].tolist():
        for one, two, tip in ((a, b, c), (b, c, a), (c, a, b)):
            opposite[frozenset((one, two))].append((one, two, tip))
    at = patches.local[:, :2]
    checked = 0
    for edge, sides in opposite.items():
        if edge in curves or len(sides) != 2:
            continue
        one, two, tip = sides[0]
        assert oracles.orient2d(at[one], at[two], at[tip]) > 0
        assert oracles.incircle(at[one], at[two], at[tip], at[sides[1][2]]) <= 0, name
        checked += 1
    return checked


@pytest.mark.parametrize("kind", ARCS)
def test_a_chord_between_two_arcs(kind):
    k = np.arange(-20, 21)
    x, y = 16 * k, ARCS[kind](k)
    short = np.concatenate(
        [np.stack([x, y, x, y + 2], axis=1), np.stack([x + 3, -y, x + 3, -y - 2], axis=1)]
    )
    surfaces = [FACE, upright("Short", short), upright("Long", [[-600, 1, 600, -1]])]
    patches = rebuild_surfaces(surfaces)
    laws.assert_on_parents(patches)
    assert patches.report["constructed_points"] == 2 * (len(short) + 1)
    assert len(patches.curve_edges) == len(short) + 1
    assert assert_delaunay(patches, kind) > 300


@pytest.mark.parametrize("height", [40, 700])
@pytest.mark.parametrize("n", [1, 3, 24])
def test_a_chord_below_spikes(n, height):
    """Both triangles beside each of them are crossed: they lead back into what is dug."""
    x = 96 * (np.arange(n) - n // 2)
    spikes = np.stack([x, 0 * x + 1, x, 0 * x + height], axis=1)
    pegs = np.stack([x + 48, 0 * x - 3, x + 48, 0 * x - 5], axis=1)
    long = [[-1400, 0, 1400, -0.5]]
    patches = rebuild_surfaces(
        [FACE, upright("Short", np.concatenate([spikes, pegs])), upright("Long", long)]
    )
    laws.assert_on_parents(patches)
    level = (patches.local[patches.curve_edges][:, :, 2] == 0).all(axis=1)
    assert level.sum() == 2 * n + 1  # faults cross each other elsewhere
    assert assert_delaunay(patches, (n, height)) > 4 * n
