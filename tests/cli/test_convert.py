"""`geosurf convert`: what is read, what is written, what is lost, and one sentence per mistake."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf.cli import main

CLASSIC = (
    "-996 2 10 10\n500 520 0 10\n3 0 500 0\n0 0 0 0 0 0 0\n1600 1610 1620\n1605 9999900 1606\n"
)
TURNED = CLASSIC.replace("3 0 500 0", "3 30 500 0")
STICKS = "0 0 1500\n0 50 1600\n999 999 999\n90 0 1500\n95 50 1600\n999 999 999\n"


@pytest.fixture
def convert(tmp_path, monkeypatch, capsys):
    """Run the command in an empty folder, and return exit code, output and errors."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "Top.gri").write_text(CLASSIC)
    (tmp_path / "turned.gri").write_text(TURNED)
    (tmp_path / "F1.pol").write_text(STICKS)

    def run(*words):
        code = main(["convert", *words])
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return run


def test_a_map_stays_as_it_is_where_no_file_states_a_direction(convert):
    for suffix in (".zmap", ".cps3", ".asc", ".irap", ".irapasc"):
        code, out, _ = convert("Top.gri", f"a{suffix}")
        assert code == 0
        assert "direction: Top.gri does not state whether z is elevation or depth" in out
        one, other = (gs.read_horizon(f, positive="up") for f in ("Top.gri", f"a{suffix}"))
        np.testing.assert_array_equal(one, other)


def test_depths_stay_depths_and_the_target_states_it(convert):
    assert convert("Top.gri", "a.nc", "--positive", "down", "--crs", "EPSG:23031")[0] == 0
    back = gs.read_horizon("a.nc")
    np.testing.assert_array_equal(back, gs.read_horizon("Top.gri", positive="down"))
    assert back.attrs["crs"] == "EPSG:23031"
    code, out, _ = convert("a.nc", "b.zmap")
    assert code == 0
    assert "Values are elevation in m" in out


def test_sticks_and_maps_become_surfaces(convert):
    assert convert("F1.pol", "F1.ts", "--positive", "down")[0] == 0
    assert gs.read_fault("F1.ts").n_triangle == 2
    code, out, _ = convert("turned.gri", "a.glb", "--positive", "down")
    assert (code, "3 triangles" in out or "triangles: rows, columns" in out) == (0, True)


def test_a_sealed_model_becomes_units(convert):
    world = gs.synthetic.tilted_planes(n=5)
    scene = gs.Scene(world.horizons, world.faults, world.box)
    gs.write(scene.units, "model.ml")
    code, out, _ = convert("model.ml", "model.csv")
    assert code == 0
    assert "table of the units, not their surfaces" in out
    assert len(Path("model.csv").read_text().splitlines()) == 1 + len(scene.units)


MISTAKES = {
    "rotated": (("turned.gri", "a.zmap"), "rotated by 30 degrees, and ZMAP+ stores no"),
    "suffix": (("Top.gri", "a.zmpa"), "no files with the suffix '.zmpa'. Did you mean '.zm"),
    "kind": (("F1.pol", "a.zmap"), "FaultSticks cannot be written as '.zmap'. Use one of"),
    "direction": (("Top.gri", "a.nc"), ".nc files do. Add --positive down for depth, or --pos"),
    "none": (("none.gri", "a.zmap"), "none.gri: cannot be read (No such file or directory)"),
    "same": (("Top.gri", "./Top.gri"), "source and target are the same file. Name another"),
    "crs": (("F1.pol", "a.geojson", "--positive", "up"), "GeoJSON needs a coordinate reference"),
}  # fmt: skip


@pytest.mark.parametrize("case", MISTAKES)
def test_one_sentence_for_each_mistake(convert, tmp_path, case):
    words, sentence = MISTAKES[case]
    before = sorted(tmp_path.iterdir())
    code, out, err = convert(*words)
    assert (code, out) == (2, "")
    assert sentence in err
    assert err.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before


def test_one_of_several_faults_is_chosen_by_name(convert):
    """Sticks of two faults in one file would become one fault."""
    rows = [f"INLINE-   1 2 {x} {y} 5 {name} {k}" for name, x, k in
            (("F1", 0, 1), ("F1", 1, 2), ("F2", 5, 1), ("F2", 7, 2)) for y in (0, 9)]  # fmt: skip
    Path("two.dat").write_text("\n".join(rows) + "\n")
    code, _, error = convert("two.dat", "a.csv", "--positive", "down")
    assert code == 2
    assert "has 2 faults: F1, F2. Choose one" in error
    assert "--name F1" in error
    assert not Path("a.csv").exists()
    assert convert("two.dat", "a.csv", "--positive", "down", "--name", "F2")[0] == 0
    (table,) = (np.genfromtxt("a.csv", delimiter=",", names=True),)
    assert sorted(set(table["X"])) == [5.0, 7.0]


def test_wells_with_directions_and_their_heads(convert, tmp_path):
    (tmp_path / "survey.csv").write_text("Id,DEPT,Inc,Azi\nW-1,0,0,0\nW-1,1000,0,0\n")
    (tmp_path / "heads.csv").write_text("Well,X,Y,KB\nW-1,500,900,25\n")
    words = ("--as", "wells", "--heads", "heads.csv", "--columns")
    assert convert("survey.csv", "a.csv", *words, "well=Id,md=DEPT")[0] == 0
    assert gs.read_wells("a.csv", positive="up").elevation.values.tolist() == [25.0, -975.0]
    code, _, err = convert("survey.csv", "b.csv", *words, "1,2")
    assert code == 2
    assert "--columns of wells are pairs, as in --columns md=DEPT,well=3" in err
