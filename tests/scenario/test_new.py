"""`geosurf new`: files are recognised by content, and its scenarios build the field."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import InputError
from geosurf.scenario import build_scene, read_scenario
from geosurf.scenario.new import NewScenario, new_scenario
from geosurf.scenario.new.judge import Found
from geosurf.scenario.new.network import surface_of
from geosurf.synthetic import FieldTruth
from tests.grids import gridded


def files_of(truth: FieldTruth) -> list[Path]:
    """The files of a field without the scenario that it brings."""
    return [path for name, path in truth.files.items() if name != "scenario"]


def kinds(new: NewScenario) -> dict[str, str]:
    """What each file was taken for, by its name."""
    return {one.path.name: one.kind for one in new.found}


def test_a_field_is_recognised_and_its_volumes_are_true(
    export: Callable[[str], FieldTruth], tmp_path: Path
) -> None:
    """Order, direction and the unit of one file follow from the files; volumes are true.

    The network has grids, points and all faults of the other two.
    """
    truth = export("network")
    new = new_scenario(tmp_path / "field", list(reversed(files_of(truth))))
    assert new.runs
    found = {one.name: one for one in new.found if one.kind in ("horizon", "fault")}
    assert [n for n, one in found.items() if one.kind == "horizon"] == list(truth.horizons)
    assert sorted(n for n, one in found.items() if one.kind == "fault") == sorted(truth.faults)
    content = tomllib.loads(new.path.read_text(encoding="utf-8"))
    assert content["positive"] == "down"
    units = {table["name"]: table.get("length_unit") for table in content["horizons"]}
    assert units == {"Top": None, "Middle": None, "Base": "ft"}

    # only the branch ends at its main fault; those that die before another one do not
    ends = {(table["fault"], table["main"]) for table in content["truncations"]}
    assert ends == {("F2", "F1")}
    # faults that die inside the field may divide it: that is asked, and nothing is assumed
    assert "compartments" not in content
    (asked,) = (one for one in new.questions if "separate regions" in one.text)
    lines = new.path.read_text(encoding="utf-8").splitlines()[asked.line - 1 :]
    names = [line.split()[1] for line in lines[1 : lines.index("")]]
    assert lines[0] == "# [compartments]"
    assert names == ["F3", "F4", "F5", "F6"]
    scene = build_scene(read_scenario(new.path))
    for key, volume in truth.volumes(scene.aoi).items():
        assert scene.units[key].volume == pytest.approx(volume, rel=0.001)


def test_files_of_every_kind(tmp_path: Path) -> None:
    """Each kind is recognised from what the file holds; what has no place stays out."""
    x, y = np.meshgrid(np.arange(0, 1000, 50.0), np.arange(0, 800, 50.0))
    z = 1500 + 0.05 * x

    def points(name: str, *columns: np.ndarray, head: str = "", sep: str = " ") -> None:
        rows = [
            sep.join(f"{v:.2f}" for v in row) for row in zip(*map(np.ravel, columns), strict=True)
        ]
        (tmp_path / name).write_text(head + "\n".join(rows) + "\n", encoding="utf-8")

    points("01_Top ä.poi", x, y, z)
    points("Base ä.xyz", x, y, z + 80)
    points("loose.poi", x[0, :3], y[0, :3], z[0, :3])
    points("wall.poi", 500 + 0 * x[:6], y[:6], z[:6] + 20 * x[:6] / 50)
    points("many.csv", x, y, z, np.round(x / 500), head="X,Y,Z,val\n", sep=",")
    sticks = "".join(
        f"{400 + k} {k} 1400\n{500 + k} {k} 1800\n999 999 999\n" for k in (0, 400, 800)
    )
    (tmp_path / "F1.pol").write_text(sticks)
    ring = "0 0 {z}\n900 0 {z}\n900 700 {z}\n0 700 {z}\n0 0 {z}\n999 999 999\n"
    (tmp_path / "outline.pol").write_text(ring.replace("{z}", "0"))
    (tmp_path / "gaps.pol").write_text(ring.replace("{z}", "1500", 3).replace("{z}", "1510", 1)
                                       .replace("{z}", "1500") * 2)  # fmt: skip
    (tmp_path / "tops.csv").write_text("Well,X,Y,TVDSS,Surface\nW1,100,100,1505,Top\n")
    (tmp_path / "notes.txt").write_text("Exported by nobody.\n")
    (tmp_path / "broken.gri").write_bytes(b"\0\0\0\x20nonsense")
    (tmp_path / "empty.poi").write_bytes(b"")
    (tmp_path / "picture.png").write_bytes(b"\x89PNG")
    gs.write(gs.TriSurface("thrust", "fault", [[0, 0, 0], [9, 0, 0], [0, 9, 9]], [[0, 1, 2]]),
             tmp_path / "thrust fault.ts")  # fmt: skip
    new = new_scenario(tmp_path / "field", [tmp_path])
    assert kinds(new) == {
        "01_Top ä.poi": "horizon", "Base ä.xyz": "horizon", "F1.pol": "fault",
        "thrust fault.ts": "fault", "outline.pol": "outline", "tops.csv": "tops",
        "loose.poi": "left out", "wall.poi": "left out", "many.csv": "left out",
        "gaps.pol": "left out", "notes.txt": "left out", "broken.gri": "left out",
        "empty.poi": "left out", "picture.png": "left out",
    }  # fmt: skip
    left = [one for one in new.found if one.kind == "left out"]
    text = new.path.read_text(encoding="utf-8")
    assert all(one.note and f"{one.path.name}: " in text for one in left)
    scenario = read_scenario(new.path)
    assert [entry.name for entry in scenario.horizons] == ["Top ä", "Base ä"]
    assert scenario.tear is not None
    assert scenario.tops is not None
    for wrong, words in (("01_Top.poi", "Did you mean '01_Top ä.poi'"), ("*.grd", "the suffix")):
        with pytest.raises(InputError, match=f"no file has such a name. .*{words}"):
            new_scenario(tmp_path / "never", [tmp_path / "Base ä.xyz", tmp_path / wrong])
    assert not (tmp_path / "never").exists()


def test_faults_in_feet_meet_the_horizons(export: Callable[[str], FieldTruth]) -> None:
    """The network is found with elevations in metres, whatever the files have."""
    path = export("grids").files["F1"]
    metres = Found(path, "fault", data=gs.read_fault(path, positive="up"), positive="down")
    feet = replace(metres, length_unit="ft")
    z = [surface_of(one).vertices[:, 2] for one in (metres, feet)]
    np.testing.assert_allclose(z[1], 0.3048 * z[0], rtol=1e-12)
    assert z[0].max() < 0.0


def test_pieces_tables_and_polygons_are_proposed_as_faults(
    export: Callable[[str], FieldTruth], tmp_path: Path
) -> None:
    """A mesh in two pieces, points as csv; polygons only where there are no fault surfaces."""
    truth = export("points")
    points = np.loadtxt(truth.files["Top"])[:-1]
    np.savetxt(tmp_path / "Top.csv", points, "%.2f", ",", header="X,Y,Z", comments="")
    mesh = gs.read_fault(truth.files["F3"])
    middle = mesh.vertices[mesh.triangles][:, :, 1].mean(axis=1)
    apart = np.abs(middle - np.median(middle)) > 60.0
    gs.write(gs.TriSurface("F3", "fault", mesh.vertices, mesh.triangles[apart]), tmp_path / "F3.ts")
    east, north, depth = points[len(points) // 2]
    gap = np.array([[0, -900, 0], [25, 0, 15], [0, 900, 0], [-25, 0, -15], [0, -900, 0]])
    ring = np.add(gap, [east, north, depth])
    lines = np.concatenate([ring, [[999] * 3], np.add(ring, [400, 0, 0]), [[999] * 3]])
    for name in ("gaps.pol", "again.dat"):
        np.savetxt(tmp_path / name, lines, "%.3f")

    both = new_scenario(tmp_path / "both", [tmp_path / "Top.csv", tmp_path / "F3.ts",
                                            tmp_path / "gaps.pol"], positive="down")  # fmt: skip
    faults = read_scenario(both.path).faults
    assert [(one.name, one.piece) for one in faults] == [("F3 (1)", 1), ("F3 (2)", 2)]
    assert kinds(both)["gaps.pol"] == "left out"

    files = [export("grids").files["Top"], tmp_path / "gaps.pol"]
    new = new_scenario(tmp_path / "gaps", [*files, tmp_path / "again.dat"], positive="down")
    assert kinds(new)["again.dat"] == "left out"
    asked, regions = new.questions
    assert "fault polygons of 'Top'" in asked.text
    assert "do these faults separate regions?" in regions.text
    text = new.path.read_text(encoding="utf-8").splitlines()
    for question in (asked, regions):
        end = text.index("", question.line) if "" in text[question.line :] else len(text)
        rows = slice(question.line - 1, end)
        text[rows] = [line.removeprefix("# ") for line in text[rows]]
    new.path.write_text("\n".join(text))
    scenario = read_scenario(new.path)
    assert [one.name for one in scenario.faults] == ["P1", "P2"]
    assert scenario.tear is not None
    assert set(scenario.compartments) == {"P1", "P2"}


def test_points_without_faults_are_gridded(tmp_path: Path) -> None:
    """Volumes between two planes that are given as scattered points."""
    place = np.random.default_rng(7).uniform(0.0, 1000.0, (900, 2))
    for name, z in (("Top", -1000.0 + 0.05 * place[:, 0]), ("Base", 0.0 * place[:, 0] - 1100.0)):
        np.savetxt(tmp_path / f"{name}.xyz", np.column_stack([place, z]), fmt="%.3f")
    new = new_scenario(tmp_path / "field", [tmp_path / "Top.xyz", tmp_path / "Base.xyz"])
    assert new.runs
    sides = "easting_m = [100, 900]\nnorthing_m = [100, 800]\nelevation_m = [-1200, -900]\n"
    new.path.write_text(f"{new.path.read_text()}\n[box]\n{sides}")
    scene = build_scene(read_scenario(new.path))
    volume = float(scene.volumes.sel(unit="Top/Base").sum())
    assert volume == pytest.approx(800.0 * 700.0 * 125.0, rel=1e-5)


def test_the_dip_of_a_smeared_polygon_is_that_of_the_horizons(tmp_path: Path) -> None:
    """A fault of 70 degrees whose smear shows 17; where gap and horizons agree, none is set."""
    axis = np.arange(0.0, 1500.0, 20.0)
    for name, level in (("Top", -1500.0), ("Base", -1600.0)):
        middle = 750.0 - (level + 1500.0) / np.tan(np.radians(70.0))
        share = np.clip((axis - middle) / 100.0 + 0.5, 0.0, 1.0)
        z = np.broadcast_to(level - 30.0 * share, (len(axis), len(axis)))
        gridded(z, axis).to_netcdf(tmp_path / f"{name}.nc", engine="h5netcdf")
    files = [tmp_path / "Top.nc", tmp_path / "Base.nc", tmp_path / "gaps.pol"]
    for half, dips in ((50.0, [70]), (15.0 / np.tan(np.radians(70.0)), [])):
        ring = [(-half, 300, 15), (-half, 1200, 15), (half, 1200, -15), (half, 300, -15)]
        ring = np.add([*ring, ring[0]], [750.0, 0.0, -1515.0])
        np.savetxt(files[2], [*ring, [999.0] * 3], "%.3f")
        new = new_scenario(tmp_path / f"field {half:.0f}", files, positive="up")
        found = [line for line in new.path.read_text().splitlines() if line.startswith("# dip = ")]
        assert [round(float(line.split()[3]), -1) for line in found] == dips
