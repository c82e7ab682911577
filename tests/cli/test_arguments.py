"""Arguments: mistakes in one sentence each, options that mean the same everywhere, completion."""

# ruff: noqa: E501 - the table has one case per line

from __future__ import annotations

import json
import shlex
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf import cli
from geosurf.cli import main
from geosurf.cli.parser import commands_of, completion_script, options_of
from tests.planes import scenario_tables

COMMANDS = commands_of(cli.build_parser())
MISTAKES = {
    "": "geosurf: COMMAND is missing. See geosurf --help.",
    "--verison": "geosurf: unknown option --verison. Did you mean '--version'?",
    "rnu": "geosurf: unknown command 'rnu'. Did you mean 'run'? Commands are new, run,",
    "run": "geosurf run: scenario and -o/--out are missing. See geosurf run --help.",
    "run a.toml -o": "geosurf run: -o/--out needs a value.",
    "run a.toml -o b c": "geosurf run: 'c' is one argument too many. Put names with blanks between quotes.",
    "run a.toml -o b --no-pics": "geosurf run: unknown option --no-pics. Did you mean '--no-pictures'?",
    "run a.toml -o b --only cvs": "geosurf run: --only: 'cvs' is not known. Give vtm, vtp, csv,",
    "ensemble a.toml -o b -n 0": "geosurf ensemble: -n: '0' is not a whole number of 1 or more.",
    "curves a b -o c --positive dwon": "geosurf curves: --positive: 'dwon' is not known. Give up or down. Did you mean 'down'?",
    "--help=1": "geosurf: --help takes no value.",
    "run a.toml -o b --no-pictures=yes": "geosurf run: --no-pictures takes no value.",
    "run a.toml -o b --only csv,": "geosurf run: --only: 'csv,' has a comma with no word next to it. Write the words without blanks: csv,",
    "new --example field": "geosurf new: --example: 'field' is not known. Give grids, points or network. The folder comes first: geosurf new field --example.",
    "convert a.gri b.gri --length-unit feeet": "geosurf convert: --length-unit: 'feeet' is not known. Give m, metre,",
}


@pytest.mark.parametrize("words", MISTAKES)
def test_a_mistake_is_one_sentence_and_names_the_help(words, capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(shlex.split(words))
    assert caught.value.code == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(MISTAKES[words])
    assert len(said.err.splitlines()) == 1
    assert said.err.endswith(" --help.\n")


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_common_options_and_an_example_that_is_accepted(name):
    command = COMMANDS[name]
    assert {"--json", "--quiet", "--verbose", "--debug"} <= set(options_of(command))
    example = command.epilog.removeprefix("example: geosurf ").partition(" >>")[0]
    options = cli.build_parser().parse(shlex.split(example))
    assert options.kept(options).endswith(("there.", "half-written.", "ones."))


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("arguments")
    world = gs.synthetic.tilted_planes(n=5)
    path = folder / "scenario.toml"
    tables = scenario_tables(folder, world.horizons, world.faults)
    path.write_text(f'title = "Planes"\n{tables}')
    return path


def test_a_run_sets_keys_writes_only_some_results_and_answers_in_json(scenario, tmp_path, capsys):
    out = tmp_path / "out"
    words = ["run", scenario, "-o", out, "--json", "--only", "csv,vtp", "--set", "title=Other"]
    assert cli.main([*map(str, words), "--set", "faults=[]"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {path.name for path in out.iterdir()} == {"certificate.txt", "curves.vtp", "volumes.csv"}
    assert (out / "certificate.txt").read_text().startswith("Other (title=Other, faults=[])\n")
    assert [unit["unit"] for unit in found["units"]] == ["Top/Base"]
    scene = gs.Scene(gs.synthetic.tilted_planes(n=5).horizons)
    assert [unit["volume"] for unit in found["units"]] == scene.volumes.values.tolist()
    assert found["certificate"]["ok"] is True
    assert found["report"] is None


def test_a_dry_run_lists_files_and_writes_nothing(scenario, tmp_path, capsys):
    words = ["run", str(scenario), "-o", str(tmp_path / "out"), "--dry-run"]
    assert cli.main([*words, "--json"]) == 0
    planned = json.loads(capsys.readouterr().out)
    assert {Path(path).name for path in planned["reads"].values()} == {"Top.nc", "Base.nc", "F1.nc"}
    assert not (tmp_path / "out").exists()

    assert cli.main([*words[:-1], "--quiet", "--no-pictures"]) == 0
    assert capsys.readouterr().out == ""
    for file in planned["writes"]:
        pictures = file.startswith("pictures")
        assert bool([*(tmp_path / "out").glob(file)]) is not pictures, file


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("title", "--set 'title' is not key=value. Write for example --set tear.trim_cells=2."),
        ("tolerance_m=-1", "tolerance_m is -1"),
        ("horizons.Tpo.file=a", "no table is named 'Tpo'. Names are 'Top', 'Base'. Did you mean 'Top'?"),
        ("horizons.Top.file=New.nc", "New.nc"),
        ("contacts.OWC.elevation_m=-2000", "the scenario has no [[contacts]]. --set changes tables that are there"),
        ("output.maps=no", "output.maps is 'no'; it must be true or false"),
    ],
)  # fmt: skip
def test_settings_that_cannot_be(scenario, capsys, setting, sentence):
    assert cli.main(["check", str(scenario), "--set", setting]) == 2
    said = capsys.readouterr()
    assert sentence in said.err
    assert len(said.err.splitlines()) == 1
    assert cli.main(["validate", str(scenario), "--set", setting]) == 2


def test_a_mistake_that_was_set_has_no_line_of_the_file(scenario, capsys):
    words = ["validate", str(scenario), "--json", "--set", "title=3", "--set", "box.top=1"]
    assert cli.main([*words, "--set", "faults.F1.lengthen_m=-1"]) == 2
    found = json.loads(capsys.readouterr().out)["mistakes"]
    assert {row["line"] for row in found} == {None}
    assert any("title is 3" in row["mistake"] for row in found)
    assert any("lengthen_m is -1" in row["mistake"] for row in found)


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_bash_completes_commands_options_and_files(tmp_path):
    (tmp_path / "geo.sh").write_text(completion_script(cli.build_parser(), "bash"))
    (tmp_path / "scenario.toml").write_text("")
    asked = {
        "va": "validate",
        "run --no-p": "--no-pictures",
        "render a.toml --sec": "--section",
        "run scen": "scenario.toml",
    }
    lines = []
    for words in asked:
        count = len(words.split())
        lines += [f"COMP_WORDS=(geosurf {words})", f"COMP_CWORD={count}", "_geosurf"]
        lines.append('echo "${COMPREPLY[@]}"')
    said = subprocess.run(
        ["bash", "-c", "\n".join(["source geo.sh", *lines])],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert said.stdout.splitlines() == list(asked.values())


# ---- `geosurf convert`: what is read, what is written, what is lost, and one sentence per mistake.
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


def test_a_sealed_model_becomes_units(convert, planes):
    gs.write(planes.units, "model.ml")
    code, out, _ = convert("model.ml", "model.csv")
    assert code == 0
    assert "table of the units, not their surfaces" in out
    assert len(Path("model.csv").read_text().splitlines()) == 1 + len(planes.units)


UNCONVERTED = {
    "rotated": (("turned.gri", "a.zmap"), "rotated by 30 degrees, and ZMAP+ stores no"),
    "suffix": (("Top.gri", "a.zmpa"), "no files with the suffix '.zmpa'. Did you mean '.zm"),
    "kind": (("F1.pol", "a.zmap"), "FaultSticks cannot be written as '.zmap'. Use one of"),
    "direction": (("Top.gri", "a.nc"), ".nc files do. Add --positive down for depth, or --pos"),
    "none": (("none.gri", "a.zmap"), "none.gri: cannot be read (No such file or directory)"),
    "same": (("Top.gri", "./Top.gri"), "source and target are the same file. Name another"),
    "crs": (("F1.pol", "a.geojson", "--positive", "up"), "GeoJSON needs a coordinate reference"),
}  # fmt: skip


@pytest.mark.parametrize("case", UNCONVERTED)
def test_one_sentence_for_each_mistake(convert, tmp_path, case):
    words, sentence = UNCONVERTED[case]
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
