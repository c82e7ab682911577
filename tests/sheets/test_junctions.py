"""Throw up to the line in which three faults meet: see `tests.sheets.junctions`."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.sheets import tear as attempts
from geosurf.sheets.mesh import build
from tests.sheets.junctions import KINDS, junction, misses


@pytest.mark.parametrize("kind", KINDS)
def test_throw_is_right_up_to_a_junction(kind):
    """It was 0 there, or the junction was refused: the branch was traced on the wrong wall."""
    for seed in (2, 3):
        grid, faults, *truth = junction(kind, np.random.default_rng(seed))
        sheet = gs.tear_horizon(grid, faults, name="H", trim=1.5)
        assert max(misses(sheet, *truth)) < 0.05


def test_a_link_may_go_around_the_end_of_a_branch():
    """It crosses the main fault on either side of the branch: throw was 0 at the junction."""
    grid, faults, *truth = junction("bent main fault", np.random.default_rng(13))
    sheet = gs.tear_horizon(grid, faults, name="H", trim=1.5)
    assert max(misses(sheet, *truth)) < 1e-9


def test_a_fault_of_two_triangles_is_traced_as_one_of_many():
    """Where the triangles of a fault are wide, their middles said nothing of its side."""
    grid, faults, middle, azimuth, throw = junction("half planes", np.random.default_rng(2))
    fine = {}
    for name, fault in faults.items():
        a, b = fault.vertices[0], fault.vertices[2]
        s, z = np.meshgrid(np.linspace(0.0, 1.0, 41), np.linspace(-2300.0, -1200.0, 5))
        xy = a[:2] + s[..., None] * (b - a)[:2]
        k = np.arange(s.size).reshape(s.shape)
        p, q, r, t = (c.ravel() for c in (k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]))
        faces = np.concatenate([np.stack([p, q, r], 1), np.stack([p, r, t], 1)])
        points = np.column_stack([xy.reshape(-1, 2), z.ravel()])
        fine[name] = gs.TriSurface(name, "fault", points, faces)
    sheet = gs.tear_horizon(grid, fine, name="H", trim=1.5)
    assert misses(sheet, middle, azimuth, throw)[0] < 0.05


def test_a_refusal_names_its_fault_and_the_place_is_drawn(tmp_path, monkeypatch):
    monkeypatch.setattr(build, "ROUNDS", 1)
    grid, faults, *_ = junction("straight main fault", np.random.default_rng(2))
    branch = faults["F3"]
    moved = branch.vertices - (3.0, 2.0, 0.0)  # it ends beside its main fault
    faults["F3"] = gs.TriSurface("F3", "fault", moved, branch.triangles)
    text = (
        '[[horizons]]\nname = "Top"\nfile = "Top.nc"\n[tear]\ntrim_cells = 1.5\n[box]\n'
        "easting_m = [0, 4000]\nnorthing_m = [0, 3000]\nelevation_m = [-2000, -1400]\n"
    )
    gs.write(grid, tmp_path / "Top.nc")
    for name, fault in faults.items():
        gs.write(fault, tmp_path / f"{name}.ts")
        text += f'[[faults]]\nname = "{name}"\nfile = "{name}.ts"\n'
    (tmp_path / "scenario.toml").write_text(text)
    monkeypatch.setattr(attempts, "TRIM_CHANGES", ())
    words = (
        r"could not be cut at faults 'F1', 'F3': 1 hole .*trims than 1.5 .* were tried\. Without"
    )
    with pytest.raises(gs.errors.GeometryError, match=words) as caught:
        gs.run_scenario(tmp_path / "scenario.toml", tmp_path / "out")
    assert caught.value.surfaces == ("Top", "F1", "F3")
    assert (tmp_path / "out" / "failure.png").stat().st_size > 10_000

    # the picture has the sheet, both faults and the rim, at a scale where the hole is seen
    seen, place = caught.value.close_up, caught.value.place
    assert {"Top", "F1", "F3"} <= {surface.name for surface in seen.surfaces}
    assert 0.02 < np.ptp(seen.rim, axis=(0, 1)).max() / (2.0 * seen.reach) < 0.5
    assert np.abs(seen.rim - place).max() < seen.reach
    data = np.concatenate([*seen.points.values()])
    assert len(data) > 4
    assert np.abs(data - place)[:, :2].max() <= seen.reach
