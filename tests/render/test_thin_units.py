"""Units with few enough triangles to draw: the same shells, from blocks of cells."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.model import Units
from geosurf.render import surface_layers
from geosurf.render.surface_layers import Shell, shells_to_draw, thinned_mesh


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


def test_without_blocks_shells_have_the_triangles_of_units() -> None:
    world = gs.synthetic.tilted_planes(n=9)
    units = gs.Scene(world.horizons, world.faults, world.box).units
    for shell, unit in zip(
        thinned_mesh(*units.piece_sides, len(units), 1).shells, units.values(), strict=True
    ):
        for points in (unit.vertices, shell.points):
            assert len(np.unique(points, axis=0)) == len(points)
        ours = shell.points[shell.triangles].sum(axis=1)
        theirs = unit.vertices[unit.triangles].sum(axis=1)
        assert np.allclose(*(x[np.lexsort(np.round(x, 6).T)] for x in (ours, theirs)), atol=1e-6)
        lines = surface_layers.outline(shell)
        whole = Shell(unit.vertices, unit.triangles, unit.surface_of_triangle)
        assert len(lines) == len(surface_layers.outline(whole))


def test_only_large_models_are_thinned() -> None:
    units = planes(False)
    for shell, unit in zip(shells_to_draw(units), units.values(), strict=True):
        assert shell.triangles is unit.triangles
    few = shells_to_draw(units, max_triangle=300)
    most = sum(len(unit.triangles) for unit in units.values())
    assert sum(len(shell.triangles) for shell in few) < 0.8 * most

    # units without patches have nothing else to draw
    alone = Units(units.values(), units.box)
    assert shells_to_draw(alone, 1)[0].triangles is next(iter(units.values())).triangles


def test_large_blocks_are_divided_along_curves(monkeypatch: pytest.MonkeyPatch) -> None:
    units = planes(False, n=60)
    several = thinned_mesh(*units.piece_sides, len(units), 12).shells
    for shell, unit in zip(several, units.values(), strict=True):
        assert volume(shell, unit.origin) == pytest.approx(unit.volume, rel=1e-9)

    # blocks of one size leave all cells of blocks that a curve passes
    monkeypatch.setattr(surface_layers, "_sizes", lambda stride: [stride])
    one_size = thinned_mesh(*units.piece_sides, len(units), 12).shells
    counts = [sum(len(shell.triangles) for shell in some) for some in (several, one_size)]
    assert counts[0] < 0.6 * counts[1]


@pytest.mark.parametrize("stride", range(1, 18))
def test_law_blocks_of_any_stride_have_the_volumes_of_units(stride: int) -> None:
    units = planes(False, n=60)
    shells = thinned_mesh(*units.piece_sides, len(units), stride).shells
    for shell, unit in zip(shells, units.values(), strict=True):
        assert volume(shell, unit.origin) == pytest.approx(unit.volume, rel=1e-9)
