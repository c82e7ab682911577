"""Certificates of torn horizons by runs: copies at faults are listed, and what is near them."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf import TriSurface, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.carve.certificate.certify import checks_by_runs
from geosurf.model.torn_lattice import TornLattice
from tests.carve.test_certificate_by_runs import lines

CROSSES = "surfaces meet only along shared edges"


def torn_scene(kind: str, n: int = 61) -> gs.Scene:
    world = gs.synthetic.torn(kind, n=n)
    return gs.Scene(world.horizons, world.faults, world.box, tear=True)


@pytest.mark.parametrize("kind", ["reverse", "scissors", "acute Y", "X"])
def test_lines_by_runs_are_those_by_triangles(kind):
    scene = torn_scene(kind)
    patches, units = scene.patches, scene.units
    assert any(isinstance(source.lattice, TornLattice) for source in patches.sources)
    fast = checks_by_runs(patches, units)
    assert fast is not None
    assert all(check.passed for check in fast)
    assert "local" not in patches.__dict__  # nothing was listed
    assert lines(fast) == lines(certify(patches, units, by="triangles").checks)


@pytest.mark.parametrize("side", [1, -1])
def test_a_copy_that_crosses_its_own_horizon_far_from_the_fault_is_found(side):
    sources = torn_scene("normal", 41).patches.sources
    lattice = next(one.lattice for one in sources if isinstance(one.lattice, TornLattice))
    step, z = lattice.easting[1] - lattice.easting[0], lattice.elevation

    # a ghost amid the fault, over or below the other wall, is moved along this wall by eight cells
    # and a little through it: its copies cross triangles there, and none next to the fault
    apart = side * (lattice.ghosts[:, 2] - z.ravel()[lattice.node_of_ghost])
    far = np.abs(lattice.ghosts[:, 1] - np.median(lattice.ghosts[:, 1]))
    ghost = np.where(apart > 0.5 * apart.max(), far, np.inf).argmin()
    row, col = np.divmod(lattice.node_of_ghost[ghost], z.shape[1])
    own = lattice.copies[(lattice.copies == z.size + ghost).any(axis=1)]
    nodes = own[own < z.size] % z.shape[1]
    col += 8 if nodes.mean() < col else -8
    ghosts = lattice.ghosts.copy()
    ghosts[ghost] = lattice.easting[col], lattice.northing[row], z[row, col]
    ghosts[ghost, 2] -= 0.2 * side * apart[ghost]
    plain = gs.Lattice(lattice.easting, lattice.northing, lattice.elevation, lattice.rising)
    spoiled = TornLattice.of(plain, lattice.gone, lattice.copies, ghosts)
    found = {}
    for name, of in (("good", lattice), ("spoiled", spoiled)):
        top = TriSurface("Top", "horizon", lattice=of)
        low, high = of.extent
        wall = TriSurface(
            "F1", "fault", [[low[0], low[1] - 9, -9e4], [high[0], low[1] - 9, -9e4],
                            [low[0], low[1] + 0.3 * step, 9e4]], [[0, 1, 2]],
        )  # fmt: skip
        patches = rebuild_surfaces([top, wall])  # the rim of the horizon is cut, nothing else
        fast = checks_by_runs(patches)
        assert fast is not None
        found[name] = {check.name: check.passed for check in fast}
        slow = {c.name: c.passed for c in certify(patches, by="triangles").checks}
        assert found[name] == slow
    assert found["good"][CROSSES]
    assert not found["spoiled"][CROSSES]
