"""The command line: exit codes, sentences, and files where they were promised."""

# ruff: noqa: E501 - the table has one case per line

from __future__ import annotations

import io
import os
import re
import shlex
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import geosurf as gs
from geosurf import cli
from geosurf.conventions import length_text
from geosurf.errors import InvariantError
from geosurf.kernels.compile import warmup
from geosurf.model import Certificate, Check
from tests.planes import scenario_tables
from tests.processes import told_by


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Grids of a small world, a scenario for them, and one that leaks."""
    folder = tmp_path_factory.mktemp("scenario")
    world = gs.synthetic.tilted_planes(n=5)
    tables = scenario_tables(folder, world.horizons, world.faults)
    output = "[output]\nsize_px = [400, 260]\nmaps = false\nexploded = false\n"
    box = "[box]\neasting_m = [0, 4000]\nnorthing_m = [0, 3000]\nelevation_m = [-2500, -1700]\n"
    (folder / "good.toml").write_text(tables + box + output)
    (folder / "leaks.toml").write_text(tables + box.replace("[0, 4000]", "[-500, 4000]"))
    (folder / "typo.toml").write_text(tables.replace("file", "flie", 1))
    return folder


def geosurf(*arguments: str | Path, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "geosurf", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


def test_help_answers_at_once_and_loads_nothing_heavy():
    code = "import sys, geosurf.cli as c; c.build_parser().format_help(); print(*sys.modules)"
    heavy = {"numpy", "numba", "xarray", "pyvista", "vtk", "matplotlib", "geosurf.scene"}
    assert not heavy & set(told_by("-c", code).split())
    said = geosurf("--help")
    assert said.returncode == 0
    for word in ("run", "check", "render", "curves", "doctor", "warmup", "exit codes"):
        assert word in said.stdout


def test_run_prints_steps_volumes_and_where_things_are(folder, tmp_path, capsys):
    assert cli.main(["run", str(folder / "good.toml"), "-o", str(tmp_path / "out")]) == 0
    said, errors = capsys.readouterr()
    assert errors == ""
    for word in (
        "rebuild",
        "carve",
        "GRV [million m³]",
        "Top/Base",
        "reservoir  ",
        "1 200.000",
        "Not shown: 4 units outside the reservoir, 8400 million m³. To list them: --set",
    ):
        assert word in said
    assert "6 units in " in said
    page = said.rpartition("Report: ")[2].partition(";")[0]
    assert Path(page).is_file()
    assert (tmp_path / "out" / "pictures" / "view_southwest.png").is_file()
    drawn = re.findall(r'<img[^>]* alt="([^"]*)"', Path(page).read_text(encoding="utf-8"))
    assert len(drawn) == len(set(drawn)) == 6
    more = ["--set", "output.include=all", "--only", "csv"]
    assert cli.main(["run", str(folder / "good.toml"), "-o", str(tmp_path / "all"), *more]) == 0
    assert "'above Top' and 'below Base' end at the model box, " in capsys.readouterr().out


def scripts_in(folder: Path) -> None:
    """A scenario with a name in another script, and one whose file is missing."""
    text = (folder / "good.toml").read_text().replace('"Base"', '"\u50a8\u5c42"')
    (folder / "script.toml").write_text(text, encoding="utf-8")
    (folder / "wrong.toml").write_text(text.replace('"F1.nc"', '"\u50a8.nc"'), encoding="utf-8")


def shown_in(encoding: str) -> bytes:
    return "\u50a8".encode(encoding.partition(":")[0], "backslashreplace")


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "utf-8"])
def test_names_in_any_script_are_printed_in_any_encoding(folder, tmp_path, monkeypatch, encoding):
    """On stdout (volumes, the path of the report) and on stderr (what is wrong)."""
    scripts_in(folder)
    out, errors = io.BytesIO(), io.BytesIO()
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", io.TextIOWrapper(out, encoding, write_through=True))
        patch.setattr(sys, "stderr", io.TextIOWrapper(errors, encoding, write_through=True))
        words = ["run", folder / "script.toml", "-o", tmp_path / "\u00e4\u50a8", "--no-pictures"]
        assert cli.main([*map(str, words)]) == 0
        assert errors.getvalue() == b""
        assert out.getvalue().count(shown_in(encoding)) > 2

        before = out.getvalue()
        assert cli.main(["check", str(folder / "wrong.toml")]) == 2
        assert out.getvalue() == before
        assert shown_in(encoding) in errors.getvalue()


def test_check_prints_the_certificate(folder, capsys):
    assert cli.main(["check", str(folder / "good.toml")]) == 0
    out = capsys.readouterr().out
    assert "volumes add up to the box" in out
    assert all(line.startswith("pass") for line in out.splitlines())


def test_a_promise_that_is_not_kept_ends_with_3(folder, capsys, monkeypatch):
    broken = Certificate((Check("areas add up", False, 1.0, "off by 1 at F1"),))
    monkeypatch.setattr("geosurf.scene.Scene.check", lambda _: broken)
    assert cli.main(["check", str(folder / "good.toml")]) == 3
    assert (
        "the model fails its check: areas add up (off by 1 at F1). Inspect"
        in capsys.readouterr().err
    )


def test_render_draws_one_picture(folder, tmp_path, capsys):
    picture = tmp_path / "view.png"
    words = ["render", str(folder / "good.toml"), "-o", str(picture), "--view", "top"]
    assert cli.main(words) == 0
    assert capsys.readouterr().out == f"{picture}\n"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert cli.main([*words[:-1], "tpo"]) == 2
    assert "'tpo'" in capsys.readouterr().err


def test_render_draws_a_section_along_a_line(folder, tmp_path, capsys):
    scenario, picture = str(folder / "good.toml"), tmp_path / "section.png"
    words = ["render", scenario, "-o", str(picture), "--section", "100.5,50 2e3,1500  3900,2950"]
    assert cli.main(words) == 0
    assert capsys.readouterr().out == f"{picture}\n"
    from geosurf.scenario import build_scene, read_scenario

    line = [(100.5, 50), (2000, 1500), (3900, 2950)]
    same = tmp_path / "same.png"
    build_scene(read_scenario(scenario)).plot.section(line, path=same, size=(400, 260))
    assert picture.read_bytes() == same.read_bytes()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--section", "0,1500 4000;1500"], "--section is '4000;1500', expected two numbers: easting and northing"),
        (["--section", "0,1500"], "'0,1500' has fewer than two points. Give easting"),
        (["--section", "-9,-9 -8,-8"], "lies outside the model (0 to 4000, 0 to 3000). Give"),
        (["--set", "pictures.theme=drak"], "Did you mean 'dark'"),
        (["--set", "output.size_px=[3,4]"], "it must be two whole numbers, [width, height]"),
        (["--section", "0,1 4000,1", "--view", "top"], "--section and --view cannot be combined: --view applies to views only. Leave one"),
    ],
)  # fmt: skip
def test_pictures_that_cannot_be_drawn(folder, tmp_path, capsys, words, said):
    call = ["render", str(folder / "good.toml"), "-o", str(tmp_path / "section.png")]
    assert cli.main([*call, *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert "\n" not in error[:-1]
    assert not (tmp_path / "section.png").exists()


def test_curves_of_two_files(folder, tmp_path, capsys):
    out = tmp_path / "curves.pl"
    words = ["curves", str(folder / "Top.nc"), str(folder / "F1.nc"), "-o", str(out)]
    assert cli.main(words) == 0
    length = gs.synthetic.tilted_planes(n=5).truth["curve_length"]["Top", "F1"]
    assert capsys.readouterr().out == f"{out}: 1 curve, 0 closed, {length_text(length, 5)}\n"
    assert out.is_file()


# rooms that a model of grids and meshes leaves out without rules and pictures
NOT_FOR_ALL = (
    *(f"geosurf.{room}" for room in ("ensemble", "grid", "synthetic", "tetrahedra")),
    *(f"geosurf.sheets.{room}" for room in ("heights", "lattice", "mesh", "tear", "throw", "tie")),
    *(f"geosurf.render.{part}" for part in ("backend", "compose", "map", "overlay", "section")),
    *("geosurf.scenario.new", "geosurf.scene.horizon_ends", "geosurf.faults.virtual_walls"),
)


def test_a_run_without_pictures_loads_only_what_it_needs(tmp_path):
    """Grids and meshes in text, tables, files and report: no pictures, and no room that tears."""
    world, tables = gs.synthetic.graben(n=9), []
    for kind, surfaces in (("horizons", world.horizons), ("faults", world.faults)):
        for name, one in surfaces.items():
            file = f"{name}.gri" if kind == "horizons" else f"{name}.ts"
            gs.write(
                one if kind == "horizons" else gs.triangulate_fault(one, name=name), tmp_path / file
            )
            tables.append(f'[[{kind}]]\nname = "{name}"\nfile = "{file}"\npositive = "up"\n')
    (tmp_path / "s.toml").write_text("".join(tables))
    words = ["run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "out"), "--no-pictures"]
    code = f"import sys, geosurf.cli as c; assert c.main({words!r}) == 0; print(*sys.modules)"
    loaded = set(told_by("-c", code).splitlines()[-1].split())
    assert not {"matplotlib", "pyvista", "vtkmodules", "meshio"} & loaded
    assert ("dask.array" in loaded) == bool(find_spec("dask"))  # a library never hides it
    assert not {name for name in loaded if name.startswith(NOT_FOR_ALL)}
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        *("certificate.txt", "curves.vtp", "report", "units", "units.vtm"),
        *("volumes.csv", "volumes.nc"),
    }


def test_doctor(capsys):
    assert cli.main(["doctor"]) in (0, 2)
    said = capsys.readouterr().out
    assert [line.split()[1] for line in said.splitlines()][:2] == ["python", "numpy"]
    assert re.search(
        "^ok +kernels +kernels (are (frozen|compiled)|run as plain)", said, re.MULTILINE
    )


@pytest.mark.long  # of the compile machinery: an edit of kernels, not of the model
def test_warmup(capsys, monkeypatch):
    few = warmup.kernel_files(warmup.ROOT)[:2]
    monkeypatch.setattr(warmup, "kernel_files", lambda _: few)
    assert cli.main(["warmup"]) == 0
    said = capsys.readouterr().out
    assert re.match(
        r"\d+ kernels compiled in \d+ s, \d+ were compiled before; cached in |Nothing to", said
    )
    assert len(said.splitlines()) == 1


def test_warmup_has_nothing_to_do_where_nothing_is_compiled():
    said = geosurf("warmup", env={**os.environ, "NUMBA_DISABLE_JIT": "1"})
    assert said.returncode == 0
    assert said.stdout.startswith("Nothing to compile: kernels run as plain Python, slowly, since")


# ---- errors --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "code", "sentence"),
    [
        ("typo.toml", 2, "unknown key 'flie' in horizons['Top']"),
        ("none.toml", 2, "none.toml: cannot be read"),
        ("leaks.toml", 3, "Shrink the box"),
    ],
)
def test_errors_are_one_sentence_on_stderr(folder, capsys, name, code, sentence):
    assert cli.main(["check", str(folder / name)]) == code
    said = capsys.readouterr()
    assert said.err.startswith("geosurf: ")
    assert sentence in said.err
    assert len(said.err.splitlines()) == 1
    assert said.out == ""


@pytest.mark.parametrize(
    ("error", "code", "sentence"),
    [
        (KeyboardInterrupt(), 130, "geosurf: stopped. No file was left half-written."),
        (InvariantError("volumes do not add up. Please report it."), 4, "volumes do not add up"),
        (OSError(28, "No space left", "a.vtp"), 2, "a.vtp cannot be written: No space left. Free"),
        (RuntimeError("odd"), 4, "unexpected RuntimeError: odd. This is a bug in geosurf"),
    ],
)
def test_how_other_errors_end(folder, capsys, monkeypatch, error, code, sentence):
    def fail(*_):
        raise error

    monkeypatch.setattr("geosurf.cli.scenario_commands.read_scenario", fail)
    assert cli.main(["check", str(folder / "good.toml")]) == code
    err = capsys.readouterr().err
    assert sentence in err
    assert "Traceback" not in err
    if code == 4:
        assert cli.main(["check", str(folder / "good.toml"), "--debug"]) == code
        assert "Traceback" in capsys.readouterr().err
        assert cli.main(["--debug", "check", str(folder / "good.toml")]) == code
        assert "Traceback" in capsys.readouterr().err


@pytest.mark.skipif(os.name != "posix", reason="needs a device that is always full")
def test_outputs_that_are_closed_or_full(capfd):
    """What is printed goes nowhere, and nobody is told that geosurf is at fault."""
    words = [sys.executable, "-m", "geosurf", "completion", "bash"]
    closed = subprocess.run(f"{shlex.join(words)} >&-", shell=True, check=False)
    assert (closed.returncode, capfd.readouterr().err) == (0, "")
    for unbuffered in ("", "1"):
        env = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
        with Path("/dev/full").open("w") as full:
            assert subprocess.run(words, stdout=full, env=env, check=False).returncode == 2
        said = "cannot be written: No space left on device. Free some space, or write to another place.\n"
        assert capfd.readouterr().err == f"geosurf: the output {said}"


def test_the_process_of_a_command_leaves_out_dask() -> None:
    """xarray loads Dask for any array, where it is installed."""
    pytest.importorskip("dask")
    code = (
        "import sys; from geosurf.cli import main; sys.argv = ['geosurf', 'completion', 'bash']; "
        "main(); import xarray; xarray.DataArray([1.0]); print(sys.modules.get('dask'))"
    )
    assert told_by("-c", code).split()[-1] == "None"
