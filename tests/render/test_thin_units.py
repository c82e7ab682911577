"""Units with few enough triangles to draw: the same shells, from blocks of cells."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.model import Units
from geosurf.render.surface_layers import Shell, thinned_mesh


def volume(shell: Shell, origin: np.ndarray) -> float:
    a, b, c = ((shell.points - origin)[shell.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6.0)


def planes(flip: bool, n: int = 23) -> Units:
    """Plane horizons and faults; with `flip`, northings of the grids fall."""
    world = gs.synthetic.tilted_planes(n=n)
    way = slice(None, None, -1 if flip else 1)
    horizons = {name: h.isel(northing=way) for name, h in world.horizons.items()}
    return gs.Scene(horizons, world.faults, world.box).units


@pytest.mark.parametrize("flip", [False, True])
def test_blocks_fill_the_volume_of_plane_units(flip: bool) -> None:
    """Two triangles of a block of a plane cover it exactly, whichever way the grid is turned."""
    units = planes(flip)
    counts = []
    for stride in (1, 2, 3, 7):
        shells = thinned_mesh(*units.piece_sides, len(units), stride).shells
        counts.append(sum(len(shell.triangles) for shell in shells))
        for shell, unit in zip(shells, units.values(), strict=True):
            assert volume(shell, unit.origin) == pytest.approx(unit.volume, rel=1e-9)
            assert set(np.unique(shell.surface)) == set(np.unique(unit.surface_of_triangle))
    assert counts[0] == sum(len(unit.triangles) for unit in units.values())
    assert max(counts[1:]) < counts[0]


@pytest.mark.parametrize("stride", range(1, 18))
def test_law_blocks_of_any_stride_have_the_volumes_of_units(stride: int) -> None:
    units = planes(False, n=60)
    shells = thinned_mesh(*units.piece_sides, len(units), stride).shells
    for shell, unit in zip(shells, units.values(), strict=True):
        assert volume(shell, unit.origin) == pytest.approx(unit.volume, rel=1e-9)
