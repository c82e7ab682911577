"""Three upright faults that meet in one line: blocks are level, so throw is known up to it.

Three half planes that share an edge, a bent main fault with a branch at its bend, and a straight
main fault with a branch, in turn, at random azimuths, places and throws; all share the vertices of
the line in which they meet, so that no fault stops short of it by a rounding.
"""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.sheets import tear as attempts
from geosurf.sheets.mesh import build

CELL = 40.0
KINDS = ("half planes", "bent main fault", "straight main fault")


def wall(name, *trace):
    """An upright fault along a line in the map."""
    corners = [[*p, z] for p in trace for z in (-2300.0, -1200.0)]
    faces = []
    for a in range(0, 2 * len(trace) - 2, 2):
        faces += [[a, a + 2, a + 3], [a, a + 3, a + 1]]
    return gs.TriSurface(name, "fault", np.array(corners), faces)


def junction(kind: str, rng: np.random.Generator):
    """Grid, faults, the point where they meet, azimuths of three rays, and throw of each ray."""
    middle = np.array([2003.0, 1502.0]) + rng.uniform(-300.0, 300.0, 2)
    first = rng.uniform(0.0, 360.0)
    turns = np.array([180.0, rng.uniform(230.0, 310.0)])
    if kind != "straight main fault":
        turns = np.array([rng.uniform(70.0, 150.0), rng.uniform(215.0, 290.0)])
    azimuth = np.append(first, first + turns) % 360.0
    level = rng.permutation([0.0, -40.0, -80.0])
    x, y = np.arange(-200.0, 4201.0, CELL), np.arange(-200.0, 3201.0, CELL)
    px, py = np.meshgrid(x, y)
    turn = (np.degrees(np.arctan2(px - middle[0], py - middle[1])) - first) % 360.0
    z = -1600.0 + np.select([turn < turns[0], turn < turns[1]], level[:2], level[2])
    grid = xr.DataArray(z, {"northing": y, "easting": x}, attrs={"units": "m", "positive": "up"})
    a, b, c = (
        middle + 4000.0 * np.array([np.sin(np.radians(t)), np.cos(np.radians(t))]) for t in azimuth
    )
    faults = [wall("F1", a, middle, b), wall("F3", middle, c)]
    if kind == "half planes":
        faults = [wall("F1", middle, a), wall("F2", middle, b), wall("F3", middle, c)]
    throw = np.abs(level - np.roll(level, 1))  # ray k lies between blocks k - 1 and k
    return grid, {fault.name: fault for fault in faults}, middle, azimuth, throw


def misses(sheet, middle, azimuth, throw) -> tuple[float, float]:
    """Largest miss of throw from half a cell of the junction on, in the largest; beyond six."""
    worst = [0.0, 0.0]
    for cut in sheet.cuts.values():
        away = cut.stations[:, :2] - middle
        far = np.hypot(*away.T) / CELL
        inside = (np.abs(cut.stations[:, :2] - (2000.0, 1500.0)) < (2100.0, 1600.0)).all(axis=1)
        turn = np.degrees(np.arctan2(*away.T))
        off = np.abs((turn[:, None] - azimuth + 180.0) % 360.0 - 180.0)
        true = throw[off.argmin(axis=1)]
        miss = np.abs(np.abs(cut.throw) - true) / throw.max()
        miss = np.where(np.isnan(miss), 1.0, miss)
        for k, least in enumerate((0.5, 6.0)):
            worst[k] = max(worst[k], miss[inside & (far > least)].max(initial=0.0))
    return worst[0], worst[1]


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
