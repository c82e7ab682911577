"""Certificates of horizons that stay in their store: those of grids in memory, read once."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.carve.certificate import certify, lattice_runs, same_bytes
from geosurf.carve.certificate.facts import Facts
from geosurf.carve.certificate.near_runs import candidates
from geosurf.model.chunked import ChunkedLattice
from geosurf.triangulate import chunked
from tests.carve.test_certificate_by_runs import built

pytest.importorskip("dask.array")


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    monkeypatch.setattr(chunked, "LEAST", 1)
    monkeypatch.setattr(lattice_runs, "_AT_ONCE", 100)  # some rows at a time


def scenes(gap: float, shift: float = 0.0) -> tuple[gs.Scene, gs.Scene]:
    """Steep horizons above one another, in memory and in chunks."""
    x, y = 25.0 * np.arange(41), 25.0 * np.arange(34)
    in_memory, in_chunks = {}, {}
    for k, name in enumerate(("Top", "Base", "Low")):
        u, v = np.meshgrid(x + shift * k, y)
        z = 40 * np.sin(u / 50) + 30 * np.cos(v / 260) - gap * k
        grid = xr.DataArray(
            z, {"northing": y, "easting": x + shift * k}, ("northing", "easting"), name,
            {"units": "m", "positive": "up"},
        )  # fmt: skip
        in_memory[name] = gs.triangulate_horizon(grid, name=name)
        in_chunks[name] = gs.triangulate_horizon(grid.chunk(9 + k), name=name, lazy=True)
    two = [[0, 1, 2], [0, 2, 3]]
    plane = [[310, -50, -400], [420, 900, -400], [620, 900, 300], [510, -50, 300]]
    ends = [[700, 300, -400], [700, 500, -400], [740, 500, 300], [740, 300, 300]]  # in the middle
    u, w = np.meshgrid(np.linspace(-20, 1100, 15), np.linspace(-400, 300, 9))
    bent = gs.Lattice(u, 620 + 0.1 * u + 0.2 * w, w, reverse=False)
    faults = {
        "F1": gs.TriSurface("F1", "fault", plane, two),
        "F2": gs.TriSurface("F2", "fault", ends, two),
        "F3": gs.TriSurface("F3", "fault", lattice=bent),
    }
    return gs.Scene(in_memory, faults), gs.Scene(in_chunks, faults)


@pytest.mark.parametrize("shift", [0.0, 7.0])
def test_law_certificates_are_those_of_grids_in_memory(shift):
    one, two = scenes(15.0, shift)
    certificate = one.check()
    assert certificate.ok
    assert certificate.checks == two.check().checks

    # triangles near other surfaces, though no curve touches them
    near = [candidates(Facts.of(scene.patches)) for scene in (one, two)]
    assert len(near[0][0])
    rows = [np.unique(np.column_stack([of, x.reshape(-1, 9)]), axis=0) for x, of in near]
    assert rows[0].tobytes() == rows[1].tobytes()


def test_a_certificate_reads_bands_once_and_tiles_near_other_surfaces(monkeypatch):
    _, scene = scenes(200.0)
    _ = scene.volumes, scene.units.table
    bands, tiles = [], []
    read = ChunkedLattice._band, ChunkedLattice._chunk
    monkeypatch.setattr(
        ChunkedLattice, "_band",
        lambda self, i, room: bands.append((self.store.name, i)) or read[0](self, i, room),
    )  # fmt: skip
    monkeypatch.setattr(
        ChunkedLattice, "_chunk",
        lambda self, i, j: tiles.append((self.store.name, i, j)) or read[1](self, i, j),
    )  # fmt: skip
    assert certify(scene.patches, scene.units).ok
    shapes = [scene.surface(name).lattice.tile_shape for name in ("Top", "Base", "Low")]
    assert sorted(bands) == sorted(set(bands))
    assert len(bands) == sum(n for n, _ in shapes)
    assert len(set(tiles)) < sum(n * m for n, m in shapes)


def test_what_is_wrong_is_on_its_line(monkeypatch):
    _, scene = scenes(200.0)
    patches, units = built(scene.patches, scene.units, order=[1, 0, *range(2, len(scene.units))])
    failed = [check.name for check in certify(patches, units).checks if not check.passed]
    assert "unit names match their bounding surfaces" in failed
    x = scene.patches.pieces.x.copy()
    x[len(x) // 2, 2] += 1.0
    other = built(scene.patches, scene.units, x=x)[0]
    assert not same_bytes(scene.patches, other).passed
    with pytest.raises(gs.errors.HorizonError, match="stays in its store"):
        certify(patches, units, by="triangles")
