"""Horizons in the wrong order are named, with their share of the area and the volume."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs

BOX = (0.0, 900.0, 0.0, 900.0, -3000.0, -1000.0)


def plane(level, slope=0.0):
    axis = np.arange(0.0, 901.0, 100.0)
    heights = level + slope * (axis[None] + 0.0 * axis[:, None])
    axes = {"northing": axis, "easting": axis}
    return xr.DataArray(heights, axes, attrs={"units": "m", "positive": "up"})


@pytest.mark.filterwarnings("ignore:Horizon 'H2'")
@pytest.mark.parametrize("n", [2, 3])
def test_horizons_turned_over_are_named_pair_by_pair(n):
    horizons = {f"H{k}": plane(-2000.0 + 100 * k) for k in range(n)}
    scene = gs.Scene(horizons, {}, BOX)
    expected = r"'H1' lies above the younger horizon 'H0' everywhere: 81 million m³"
    with pytest.warns(gs.GeosurfWarning, match=expected):
        _ = scene.units
    assert {w.kind for w in scene.warnings} == {"order"}
    assert scene.replace(horizons=horizons).warnings == ()  # nothing is built yet
    right = gs.Scene(dict(reversed(horizons.items())), {}, BOX)
    assert len(right.units) == n + 1
    assert right.warnings == ()
    ruled = scene.replace(column={"H0": "erosional", "H1": "erosional"})
    assert len(ruled.units) == 2
    assert ruled.warnings == ()


@pytest.mark.parametrize(
    ("below", "words"), [(0.0, "everywhere"), (36.0, "on 8[0-2] %"), (85.0, "on 5[34] %")]
)
def test_the_share_is_that_of_the_area(below, words):
    """One dips by a fifth, and crosses the other where it has risen so far."""
    scene = gs.Scene({"A": plane(-2000.0), "B": plane(-2000.0 - below, slope=0.2)}, {}, BOX)
    with pytest.warns(gs.GeosurfWarning, match=rf"'B' lies above .* 'A' {words}") as issued:
        _ = scene.units
    assert len(issued) == 1


def test_horizons_that_merely_cross_are_listed_only():
    scene = gs.Scene({"A": plane(-2000.0), "B": plane(-2600.0, slope=1.0)}, {}, BOX)
    assert len(scene.units.report["clipped"]) == 1
    assert scene.warnings == ()
