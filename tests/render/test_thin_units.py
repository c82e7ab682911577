"""Units with few enough triangles to draw: the same shells, from blocks of cells."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.model import Units
from geosurf.model.chunked import ChunkedLattice
from geosurf.render import thin_units, unit_layers
from geosurf.render.cluster import shells_in_picture
from geosurf.render.thin_units import Shell, shells_to_draw, thinned_mesh
from geosurf.triangulate import chunked


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
        lines = unit_layers.outline(shell)
        whole = Shell(unit.vertices, unit.triangles, unit.surface_of_triangle)
        assert len(lines) == len(unit_layers.outline(whole))


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
    monkeypatch.setattr(thin_units, "_sizes", lambda stride: [stride])
    one_size = thinned_mesh(*units.piece_sides, len(units), 12).shells
    counts = [sum(len(shell.triangles) for shell in some) for some in (several, one_size)]
    assert counts[0] < 0.6 * counts[1]


@pytest.mark.parametrize("stride", range(1, 18))
def test_law_blocks_of_any_stride_have_the_volumes_of_units(stride: int) -> None:
    units = planes(False, n=60)
    shells = thinned_mesh(*units.piece_sides, len(units), stride).shells
    for shell, unit in zip(shells, units.values(), strict=True):
        assert volume(shell, unit.origin) == pytest.approx(unit.volume, rel=1e-9)


def test_law_grids_in_their_store_have_the_shells_of_grids_in_memory(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("dask.array")
    monkeypatch.setattr(chunked, "LEAST", 1)
    world = gs.synthetic.tilted_planes(n=41)
    lazy = {
        name: gs.triangulate_horizon(h.chunk(9), name=name, lazy=True)
        for name, h in world.horizons.items()
    }
    found = [
        gs.Scene(of, world.faults, world.box).units.piece_sides for of in (world.horizons, lazy)
    ]
    n = 1 + max(int(sides.max()) for _, sides in found)
    for stride in (1, 3, 17):
        one, two = (thinned_mesh(*of, n, stride).shells for of in found)
        for a, b in zip(one, two, strict=True):
            assert a.points.tobytes() == b.points.tobytes()
            assert a.triangles.tobytes() == b.triangles.tobytes()


def test_of_grids_in_their_store_triangles_along_curves_become_few(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("dask.array")
    monkeypatch.setattr(chunked, "LEAST", 1)
    world = gs.synthetic.tilted_planes(n=61)
    lazy = {
        name: gs.triangulate_horizon(h.chunk(20), name=name, lazy=True)
        for name, h in world.horizons.items()
    }
    units = gs.Scene(lazy, world.faults, world.box).units
    all_of_them = sum(len(shell.triangles) for shell in shells_to_draw(units, 200))

    # shifts of an exploded view take one pass over each horizon
    passes = []
    bands = ChunkedLattice.bands
    monkeypatch.setattr(
        ChunkedLattice, "bands",
        lambda self, *wanted: passes.append(self.store.name) or bands(self, *wanted),
    )  # fmt: skip
    memory = gs.Scene(world.horizons, world.faults, world.box).units
    assert np.array_equal(*(unit_layers.explosion(of, 0.3) for of in (units, memory)))
    assert sorted(passes) == sorted(lazy)
    few = shells_in_picture(units, 200)
    assert not any(shell.creases for shell in few)  # those of points that became one
    assert sum(len(shell.triangles) for shell in few) <= 400 < all_of_them
    for shell, unit in zip(few, units.values(), strict=True):  # planes keep their volumes
        assert volume(shell, unit.origin) == pytest.approx(unit.volume, rel=0.02)


def test_surfaces_of_a_shell_are_shaded_by_themselves() -> None:
    """A point is of one surface only, and triangles stay where they are."""
    world = gs.synthetic.graben(n=21)
    units = gs.Scene(world.horizons, world.faults, world.box).units
    whole = shells_to_draw(units)
    layers = [one for one in unit_layers.show_units(units).layers if one.triangles is not None]
    for shell, layer in zip(whole, layers, strict=True):
        assert layer.triangles is not None
        np.testing.assert_array_equal(layer.points[layer.triangles], shell.points[shell.triangles])
        pairs = np.stack([layer.triangles.ravel(), np.repeat(shell.surface, 3)], axis=1)
        assert len(np.unique(pairs, axis=0)) == len(layer.points) > len(shell.points)


@pytest.mark.parametrize("kind", ["reverse", "acute Y"])
def test_a_torn_horizon_in_blocks_covers_the_same_map_and_keeps_its_cut_offs(kind: str) -> None:
    world = gs.synthetic.torn(kind, n=61)
    scene = gs.Scene(world.horizons, world.faults, world.box, tear=True)
    name = scene.horizon_names[0]
    whole = scene.patches.surface(name)
    light = thin_units.as_modelled(scene, scene.surface(name), 500)
    assert "triangles" not in scene.patches.__dict__
    assert light.n_triangle < whole.n_triangle / 2

    # seen from above, parts of an overlap count for both walls, as in the horizon itself
    def over_map(surface: gs.TriSurface) -> float:
        x, y = (surface.vertices[:, :2] - whole.bounds[:4:2]).T
        a, b, c = surface.triangles.T
        return float(0.5 * ((x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a])).sum())

    assert over_map(light) == pytest.approx(over_map(whole), rel=1e-9)
    assert over_map(whole) > 0
    lines = [scene.curves_between(name, fault) for fault in scene.fault_names]
    ends = np.concatenate([line.points for line in lines if line is not None])
    known = {tuple(point) for point in np.round(light.vertices, 6).tolist()}
    assert all(tuple(point) in known for point in np.round(ends, 6).tolist())

    # few triangles are drawn as they are, and so is what is not torn
    assert thin_units.as_modelled(scene, scene.surface(name), 10**6).n_triangle == whole.n_triangle
    fault = scene.surface(scene.fault_names[0])
    assert thin_units.as_modelled(scene, fault, 10) is fault
