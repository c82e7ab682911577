"""Faults of a scenario: pieces of a mesh, polygons, distances by side, columns, proposals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import ScenarioError
from geosurf.scenario import read_scenario
from geosurf.scenario.build import build_scene
from geosurf.scenario.step_log import StepLog

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.GeosurfWarning")

HEAD = """
[[horizons]]
name = "Top"
file = "Top.ts"
"""
PIECES = [[4, 1, -9], [4, 9, -9], [4, 9, 1], [4, 1, 1], [8, 3, -9], [8, 7, -9], [8, 7, 1]]


def scene_of(folder: Path, text: str) -> gs.Scene:
    """The scene of a scenario with one level horizon."""
    corners = [[-1, -1, -4], [17, -1, -4], [17, 11, -4], [-1, 11, -4]]
    gs.write(gs.TriSurface("Top", "horizon", corners, [[0, 1, 2], [0, 2, 3]]), folder / "Top.ts")
    mesh = gs.TriSurface("F", "fault", PIECES, [[0, 1, 2], [0, 2, 3], [4, 5, 6]])
    gs.write(mesh, folder / "F.ts")
    (folder / "scenario.toml").write_text(HEAD + text, encoding="utf-8")
    return build_scene(read_scenario(folder / "scenario.toml"))


def assert_same(one: gs.TriSurface, other: gs.TriSurface) -> None:
    np.testing.assert_array_equal(one.vertices, other.vertices)
    np.testing.assert_array_equal(one.triangles, other.triangles)


def test_each_piece_of_a_mesh_may_be_a_fault(tmp_path: Path) -> None:
    """As `split_fault` numbers them; a piece that is not there is refused with their number."""
    table = '[[faults]]\nname = "{}"\nfile = "F.ts"\npiece = {}\n'
    scene = scene_of(tmp_path, table.format("West", 1) + table.format("East", 2))
    parts = gs.split_fault(gs.read_fault(tmp_path / "F.ts"))
    for name, part in zip(("West", "East"), parts.values(), strict=True):
        assert_same(scene.surface(name), part)
        assert scene.surface(name).name == name
    with pytest.raises(ScenarioError, match=r"the mesh has 2 pieces\. Give a piece from 1 to 2"):
        scene_of(tmp_path, table.format("West", 3))


def test_polygons_of_horizons_are_a_fault(tmp_path: Path) -> None:
    """The surface of `fault_from_polygons`; which polygon of a file has to be stated."""
    t = np.linspace(0, 2 * np.pi, 21)
    gaps = {
        name: np.column_stack([x + np.sin(t), 5 - 4 * np.cos(t), z - np.sin(t)])
        for name, x, z in (("Top", 7, -4), ("Base", 10, -7))
    }
    ends = [[999.0] * 3]
    both = np.concatenate([gaps["Top"], ends, gaps["Base"], ends])
    np.savetxt(tmp_path / "gaps.pol", both, fmt="%.17g")
    text = '[[faults]]\nname = "F1"\npositive = "up"\n'
    rows = [
        f'[[faults.polygons]]\nhorizon = "{name}"\nfile = "gaps.pol"\n' for name in gaps
    ]  # fmt: skip
    scene = scene_of(tmp_path, f"{text}{rows[0]}polygon = 1\n{rows[1]}polygon = 2\n")
    assert_same(scene.surface("F1"), gs.fault_from_polygons(gaps, name="F1"))
    steep = scene_of(tmp_path, f"{text}dip = 80\n{rows[0]}polygon = 1\n")
    ends = gs.fault_from_polygons({"Top": gaps["Top"]}, name="F1", dip=80.0)
    assert_same(steep.surface("F1"), ends)
    with pytest.raises(ScenarioError, match="dip needs polygons, and a file is given"):
        scene_of(tmp_path, f'{text}dip = 80\nfile = "F.ts"\n')
    with pytest.raises(ScenarioError, match="2 polygons, and which one is not stated"):
        scene_of(tmp_path, text + rows[0])
    with pytest.raises(ScenarioError, match="two polygons are of horizon 'Top'"):
        scene_of(tmp_path, f"{text}{rows[0]}polygon = 1\n{rows[0]}polygon = 2\n")


def test_distances_by_side_are_those_of_the_scene(tmp_path: Path) -> None:
    """One number for all sides, or a table."""
    text = '[[faults]]\nname = "F1"\nfile = "F.ts"\npiece = 1\n'
    part = next(iter(gs.split_fault(gs.read_fault(scene_of(tmp_path, text) and tmp_path / "F.ts"))
                     .values()))  # fmt: skip
    for typed, distance in (("2.5", 2.5), ("{up = 1, strike = 3.0}", {"up": 1, "strike": 3.0})):
        scene = scene_of(tmp_path, f"{text}lengthen_m = {typed}\n")
        assert_same(scene.surface("F1"), gs.lengthen_fault(part, distance).surface)
    with pytest.raises(ScenarioError, match="a table of sides such as"):
        scene_of(tmp_path, f"{text}lengthen_m = {{left = 1}}\n")


def test_proposals_are_applied_and_listed(tmp_path: Path) -> None:
    """The same faults as `propose_fault_network().apply`, with each decision on the console."""
    text = '[[faults]]\nname = "{0}"\nfile = "F.ts"\npiece = {1}\n'
    text = text.format("West", 1) + text.format("East", 2)
    plain = scene_of(tmp_path, text)
    said: list[str] = []
    (tmp_path / "scenario.toml").write_text(f"{HEAD}{text}[network]\napply = true\n")
    scene = build_scene(read_scenario(tmp_path / "scenario.toml"), StepLog(said.append))
    trial = plain.propose_fault_network().trial(plain)
    assert len(trial.decisions) > 1
    assert [line.split()[0] for line in said].count("network") == len(trial.decisions)
    for name in ("West", "East"):
        assert_same(scene.whole_surface(name), trial.scene.whole_surface(name))
