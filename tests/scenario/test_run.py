"""What a run of a scenario writes, and what it does when a step fails."""

from __future__ import annotations

import csv
import math
import shutil

import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import (
    DependencyError,
    GeometryError,
    GeosurfWarning,
    OpenUnitError,
    OutputError,
    ScenarioError,
)
from geosurf.scenario import read_scenario, run, run_scenario
from tests.folders import bytes_in


@pytest.fixture(scope="module")
def complete(scenario, tmp_path_factory):
    """A run with everything: its folder, its scene, and what it told."""
    out, lines = tmp_path_factory.mktemp("complete"), []
    return out, run_scenario(scenario(), out, progress=lines.append), lines


def test_a_run_writes_everything_and_a_second_run_the_same_bytes(scenario, complete):
    out, scene, lines = complete
    first = bytes_in(out)
    assert set(first) == {
        *("units.vtm", "curves.vtp", "volumes.csv", "volumes.nc", "certificate.txt"),
        *("pictures/view_southwest.png", "pictures/units_exploded.png", "pictures/search.png"),
        *("pictures/map_00_Top.png", "pictures/map_01_Base.png", "report/index.html"),
        *("pictures/isochore_00_Top_Base.png", "pictures/allan_00_F1.png"),
        *("pictures/throw_00_F1.png",),
        *("pictures/section_00.png", "pictures/section_01.png"),
        *(f"units/{path.name}" for path in (out / "units").iterdir()),
    }
    assert len(list((out / "units").iterdir())) == len(scene.units) == 6
    with (out / "volumes.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    volumes = [float(row["volume_m3"]) for row in rows]
    assert sum(volumes) == pytest.approx(scene.volumes.sum().item(), rel=1e-12)
    assert scene.units.volume == pytest.approx(4000 * 3000 * 800, rel=1e-12)
    assert {line.split()[0] for line in lines} >= {"read", "rebuild", "carve", "check", "draw"}
    assert all(line.endswith(" s") for line in lines)
    assert (out / "report" / "index.html").read_text(encoding="utf-8").count("<img") == 10

    run_scenario(scenario(), out)
    assert bytes_in(out) == first


def test_results_of_an_earlier_run_do_not_survive_and_other_files_do(scenario, complete, tmp_path):
    out = shutil.copytree(complete[0], tmp_path / "out")
    (out / "notes.txt").write_text("mine")
    (out / "pictures" / "mine.png").write_text("mine")
    without_fault = scenario(
        ('[[faults]]\nname = "F1"\nfile = "F1.nc"\n', ""),
        ('search = ["Top", "F1"]', 'formats = ["vtm", "csv"]\nclosures = "sealing"'),
    )
    run_scenario(without_fault, out, pictures=False)
    assert set(bytes_in(out)) == {
        *("units.vtm", "volumes.csv", "closures.csv", "certificate.txt", "report/index.html"),
        *("units/000_above_Top.vtp", "units/001_Top_Base.vtp", "units/002_below_Base.vtp"),
        *("notes.txt", "pictures/mine.png"),
    }


def test_fluids_in_place_are_those_of_the_scene(scenario, inputs, tmp_path):
    axes = {"northing": [-500.0, 3500.0], "easting": [-500.0, 4500.0]}
    porosity = xr.DataArray([[0.1, 0.2], [0.15, 0.3]], axes, ("northing", "easting"))
    words = {"units": "m", "positive": "up"}
    gs.write(porosity.assign_attrs(words), inputs / "porosity.gri")
    wanted = """
[volumetrics]
net_to_gross = {"above Top" = {elsewhere = 0.5}, elsewhere = 0.8}
porosity = "porosity.gri"
water_saturation = 0.3
formation_volume_factor = 1.25
fluids = "oil"
"""
    path, lines = scenario(("[box]", f"{wanted}\n[box]")), []
    outcome = run(read_scenario(path), tmp_path, pictures=False, progress=lines.append)
    table = csv.DictReader((tmp_path / "volumetrics.csv").read_text().splitlines())
    values = {"net_to_gross": 0.8, "porosity": porosity, "water_saturation": 0.3}
    exact = outcome.scene.volumetrics(**values, formation_volume_factor=1.25, fluids="oil")
    found = [float(row["stoiip_Sm3"]) for row in table]
    assert found == pytest.approx(exact.stoiip.values.tolist(), rel=1e-5)  # decimals of the file
    assert any("STOIIP" in line and "million Sm³" in line for line in lines)
    page = (tmp_path / "report" / "index.html").read_text(encoding="utf-8")
    assert "Fluids in place" in page
    every = wanted.replace("{elsewhere = 0.5}, elsewhere", '0.5, "Top/Base"')
    changes = ("[box]", f"{every}\n[box]"), ("size_px", 'include = "all"\nsize_px')
    run(read_scenario(scenario(*changes)), tmp_path, pictures=False)
    table = csv.DictReader((tmp_path / "volumetrics.csv").read_text().splitlines())
    stoiip = {row["unit"]: float(row["stoiip_Sm3"]) for row in table}
    assert list(filter(math.isfinite, stoiip.values())) == found
    assert len(stoiip) > len(found)  # over- and underburden, where no fluid is named
    wrong = scenario(("[box]", wanted.replace("0.3\n", "30\n") + "\n[box]"))
    with pytest.raises(ScenarioError, match=r"line \d+: water_saturation is 30; it must be"):
        read_scenario(wrong)


def test_a_run_that_fails_leaves_the_results_that_were_there(scenario, tmp_path):
    out = tmp_path / "out"
    run_scenario(scenario(), out, pictures=False)
    before = bytes_in(out)
    with pytest.raises(OpenUnitError, match=r"horizon 'Top'.*rim.*Shrink the box"):
        run_scenario(scenario(("[0, 4000]", "[-500, 4000]")), out)
    after = bytes_in(out)
    after.pop("failure.png", None)  # beside the results, where pictures can be drawn
    assert after == before


def test_without_opengl_maps_and_everything_else_are_there(scenario, tmp_path, monkeypatch):
    obstacle = "pictures cannot be drawn without a screen."
    monkeypatch.setattr("geosurf.scene.pictures.views_obstacle", lambda: obstacle)
    with pytest.warns(GeosurfWarning, match="Only maps"):
        outcome = run(read_scenario(scenario()), tmp_path / "out")
    (note,) = outcome.scene.warnings
    assert note.effect == (
        "Only maps and diagrams were drawn: pictures cannot be drawn without a screen."
    )
    drawn = sorted(path.name for path in (tmp_path / "out" / "pictures").iterdir())
    assert [name.partition("_")[0] for name in drawn] == [
        *("allan", "isochore", "map", "map", "section", "section", "throw")
    ]
    assert outcome.certificate.ok


def test_errors_of_pictures_cost_no_other_result(scenario, tmp_path, monkeypatch):
    foreign = "ZeroDivisionError: division. This is a fault"
    errors = {
        ("allan", "allan_00_F1.png"): (GeometryError("fault 'F1' is flat."), "'F1' is flat."),
        ("throw", "throw_00_F1.png"): (ZeroDivisionError("division"), foreign),
        ("thickness", "isochore_00_Top_Base.png"): (MemoryError(), "not enough memory for it."),
    }
    for (kind, _), (error, _) in errors.items():
        draw = f"geosurf.scene.plots.draw_{kind}"
        monkeypatch.setattr(draw, lambda *_, error=error, **__: raised(error))
    path, out = scenario(("views = [", "exploded = false\nviews = [")), tmp_path / "out"
    with pytest.warns(GeosurfWarning, match="was not drawn") as caught:
        run_scenario(path, out)
    notes = {one.message.subject: one.message for one in caught}
    assert len(caught) == len(notes) == 3
    for (kind, name), (_, reason) in errors.items():
        assert notes[name].kind == "picture"
        assert reason in notes[name].effect
        assert notes[name].remedy.endswith(f"Set {kind} = false in [output] to run without it.")
    page = (out / "report" / "index.html").read_text(encoding="utf-8")
    assert page.index("was not drawn") < page.index("(GRV) [million m³]</h2>")
    there = bytes_in(out)
    assert {"volumes.csv", "certificate.txt", "report/index.html", "pictures/search.png"} <= {
        *there
    }
    assert not {f"pictures/{name}" for name in notes} & {*there}


def raised(error):
    raise error


def test_an_interrupt_while_drawing_ends_the_run(scenario, tmp_path, monkeypatch):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("geosurf.scene.plots.draw_map", stop)
    with pytest.raises(KeyboardInterrupt):
        run_scenario(scenario(("size_px", "exploded = false\nsize_px")), tmp_path / "out")
    assert not list((tmp_path / "out").iterdir())


@pytest.mark.parametrize("obstacle", ["out", "out/units", "out/pictures", "out/report"])
def test_a_folder_that_cannot_be_written_is_found_before_anything_is_read(
    scenario, tmp_path, monkeypatch, obstacle
):
    monkeypatch.setattr("geosurf.scenario.execute.build_scene", lambda _: pytest.fail("too late"))
    path = tmp_path / obstacle
    path.parent.mkdir(exist_ok=True)
    path.write_text("a file where a folder should be")
    with pytest.raises(OutputError, match=r"out: results cannot be written .*Choose another"):
        run_scenario(scenario(), tmp_path / "out")
    assert path.read_text().startswith("a file")


def test_netcdf_that_was_asked_for_is_an_error_before_anything_is_read_and_else_a_warning(
    scenario, tmp_path, monkeypatch
):
    monkeypatch.setattr("geosurf.scenario.output.find_spec", lambda _: None)
    asked = read_scenario(scenario(), ['output.formats=["nc"]'])
    with pytest.raises(DependencyError, match=r"output.formats has 'nc'.*Leave it out.*\[io\]"):
        run(asked, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    with pytest.warns(GeosurfWarning, match="'volumes.nc' was not written"):
        outcome = run(read_scenario(scenario()), tmp_path / "out", pictures=False)
    assert [note.kind for note in outcome.scene.warnings] == ["format"]
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert "volumes.csv" in names
    assert "volumes.nc" not in names
