"""Points that become one: planes keep their volume, lines their ends, the budget is kept."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.model import Units
from geosurf.render.interactive import clustered, view_of_units
from geosurf.render.surface_layers import Shell, UnitMesh, mesh_to_draw, outline, thinned_mesh


@pytest.fixture(scope="module")
def units():
    world = gs.synthetic.tilted_planes(n=31)
    return gs.Scene(world.horizons, world.faults, world.box).units


def lines_of(shells) -> list[set[tuple[float, ...]]]:
    """Points of the lines where surfaces meet, of each shell."""
    ends = [s.points[outline(s, creases=False)].reshape(-1, 3) for s in shells]
    return [{tuple(p) for p in np.round(x, 6).tolist()} for x in ends]


@pytest.mark.parametrize("share", [0.7, 0.4, 0.1])
def test_planes_keep_volume_and_outline_with_fewer_triangles(units, share):
    whole = mesh_to_draw(units, 10**9)
    few = clustered(whole, int(share * whole.n_drawn))
    assert few.n_drawn <= share * whole.n_drawn
    origin = whole.points[0]
    for one, other in zip(whole.shells, few.shells, strict=True):
        # points of a plane stay in it, and those of a line on the line: so does the volume
        assert volume_about(other, origin) == pytest.approx(volume_about(one, origin), rel=1e-9)
        assert len(np.unique(other.triangles)) == len(other.points)
    before, after = lines_of(whole.shells), lines_of(few.shells)
    if share > 0.5:
        assert before == after
    else:  # lines alone would take more: they have fewer points, and the same ends
        corners = {tuple(np.round(p, 6).tolist()) for p in corner_points(whole)}
        for old, new in zip(before, after, strict=True):
            assert len(new) < len(old)
            assert old & corners <= new


def corner_points(mesh: UnitMesh) -> np.ndarray:
    """Points where three surfaces or more meet, found one by one."""
    at: dict[int, set[int]] = {}
    for corners, surface in zip(mesh.triangles.tolist(), mesh.surface.tolist(), strict=True):
        for point in corners:
            at.setdefault(point, set()).add(surface)
    return mesh.points[[point for point, of in at.items() if len(of) > 2]]


def test_units_that_share_a_surface_go_on_sharing_its_points(units):
    bodies = view_of_units(units, 900).bodies
    points = [{tuple(p) for p in body.points.tolist()} for body in bodies]
    for mine, body in zip(points, bodies, strict=True):
        others = set.union(*(p for p in points if p is not mine))
        inside = body.points[(np.array(units.box[1::2]) > body.points).all(axis=1)]
        inside = inside[(np.array(units.box[::2]) < inside).all(axis=1)]
        assert len(inside) > 5
        assert {tuple(p) for p in inside.tolist()} <= others


# ---- Units with few enough triangles to draw: the same shells, from blocks of cells.
def volume_about(shell: Shell, origin: np.ndarray) -> float:
    a, b, c = ((shell.points - origin)[shell.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6.0)


def planes(flip: bool, n: int) -> Units:
    """Plane horizons and faults; with `flip`, northings of the grids fall."""
    world = gs.synthetic.tilted_planes(n=n)
    way = slice(None, None, -1 if flip else 1)
    horizons = {name: h.isel(northing=way) for name, h in world.horizons.items()}
    return gs.Scene(horizons, world.faults, world.box).units


@pytest.mark.parametrize(("flip", "n"), [(False, 60), (True, 23)])
def test_law_blocks_of_any_stride_have_the_volumes_of_units(flip: bool, n: int) -> None:
    """Two triangles of a block of a plane cover it exactly, whichever way the grid is turned."""
    units = planes(flip, n)
    counts = []
    for stride in (1, 2, 3, 7, 9, 16, 17):
        shells = thinned_mesh(*units.piece_sides, len(units), stride).shells
        counts.append(sum(len(shell.triangles) for shell in shells))
        for shell, unit in zip(shells, units.values(), strict=True):
            assert volume_about(shell, unit.origin) == pytest.approx(unit.volume, rel=1e-9)
            assert set(np.unique(shell.surface)) == set(np.unique(unit.surface_of_triangle))
    assert counts[0] == sum(len(unit.triangles) for unit in units.values())
    assert max(counts[1:]) < counts[0]
