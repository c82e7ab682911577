"""Without what an extra installs: everything else works, and each door names the extra."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from geosurf.conventions.machine import EXTRAS, REQUIRED
from tests.processes import run_python

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DISTRIBUTION = {"vtkmodules": "vtk", "shapefile": "pyshp"}  # where imports have other names

# A module that is None in sys.modules counts as not installed.
WITHOUT = """
import sys
sys.modules.update(dict.fromkeys(("matplotlib", "pyvista", "vtk", "vtkmodules", "meshio")))
"""

CORE = """
import warnings
from pathlib import Path
import geosurf as gs
from geosurf.errors import DependencyError
from geosurf.scenario.execute import run
from geosurf.scenario.validate import read_scenario
from tests.planes import scenario_tables

out = Path(sys.argv[1])
world = gs.synthetic.graben(n=9)
text = scenario_tables(out, world.horizons, world.faults)
text += '[pictures]\\ncolours = {Top = "teal"}\\n[output]\\nformats = ["csv", "vtp"]\\n'
(out / "plain.toml").write_text(text)
(out / "asks.toml").write_text(text + "sections_m = [[[0, 10], [100, 10]]]\\n")

# a run without pictures, the report included; it warns once
with warnings.catch_warnings(record=True) as found:
    warnings.simplefilter("always")
    done = run(read_scenario(out / "plain.toml"), out / "run")
notes = [str(one.message) for one in found]
assert notes.count(
    "No pictures were drawn: they need matplotlib, which is not installed. All other results are "
    'complete. Install it with: pip install "geosurf[render]"'
) == 1, notes
assert done.certificate.ok
assert (out / "run" / "report" / "index.html").stat().st_size > 100_000
assert not (out / "run" / "pictures").exists()
scene = done.scene

# every door of what is not there
zone = "/".join([*world.horizons][:2])
line = [(0.0, 10.0), (100.0, 10.0)]
(out / "fault.obj").write_text("v 0 0 0\\nv 1 0 0\\nv 0 1 1\\nf 1 2 3\\n")
doors = {
    "view": lambda: scene.plot.view(path=out / "a.png"),
    "render_place": lambda: gs.render_place(scene.surfaces, (0, 0, 0), out / "a.png"),
    "written_section": lambda: scene.plot.section(line, path=out / "a.png"),
    "plot_map": lambda: scene.plot.map("Top"),
    "plot_section": lambda: scene.plot.section(line),
    "plot_column": lambda: scene.plot.column(),
    "plot_throw": lambda: scene.plot.throw(scene.fault_names[0]),
    "plot_allan": lambda: scene.plot.allan(scene.fault_names[0]),
    "plot_thickness": lambda: scene.plot.thickness(zone),
    "render_pictures": lambda: scene.render_pictures(out),
    "colours": lambda: gs.PictureStyle(colours={"Top": "teal"}),
    "font": lambda: gs.PictureStyle(font="DejaVu Sans"),
    "colour_map": lambda: gs.PictureStyle(colour_map="viridis"),
    "to_pyvista, scene": scene.to_pyvista,
    "to_pyvista, units": scene.units.to_pyvista,
    "to_pyvista, curves": scene.curves.to_pyvista,
    "to_pyvista, surface": scene.surface("Top").to_pyvista,
    "pictures=True": lambda: gs.run_scenario(out / "plain.toml", out / "b", pictures=True),
    "sections_m": lambda: gs.run_scenario(out / "asks.toml", out / "b"),
    "meshio, read": lambda: gs.read_fault(out / "fault.obj"),
    "meshio, write": lambda: gs.write(scene.surface("Top"), out / "top.stl"),
}
for name, door in doors.items():
    try:
        door()
    except DependencyError as error:
        command = "pip install meshio" if "meshio" in name else 'pip install "geosurf[render]"'
        assert command in str(error), (name, error)
    else:
        raise AssertionError(f"{name} ran")
assert not (out / "b").exists()
gs.run_scenario(out / "asks.toml", out / "c", pictures=False)

# cards and the interactive view need nothing of it
cards = (scene, scene.units, scene.curves, scene.patches, scene.surface("Top"), done.certificate)
for thing in cards:
    assert "<table" in thing._repr_html_()
scene.show()

from geosurf import cli
asks = str(out / "asks.toml")
assert cli.main(["run", asks, "-o", str(out / "d")]) == 2
assert cli.main(["render", asks, "-o", str(out / "d.png")]) == 2
assert cli.main(["render", asks, "-o", str(out / "d.png"), "--section", "0,10 100,10"]) == 2
assert cli.main(["doctor"]) == 2  # meshio is missing
print("done")
"""


@pytest.mark.long  # of packaging: an edit of what is declared, or of what a door imports
def test_a_core_without_what_draws(tmp_path: Path) -> None:
    done = run_python("-c", WITHOUT + CORE, tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("done\n")
    assert "absent   render    not installed: matplotlib, pyvista, vtk. To add: " in done.stdout
    assert "MISSING  meshio    meshio is not installed." in done.stdout
    assert "ModuleNotFoundError" not in done.stderr
    asked = [line for line in done.stderr.splitlines() if "asks for pictures" in line]
    (sentence,) = asked
    assert sentence == (
        f"geosurf: {tmp_path / 'asks.toml'}: output.sections_m asks for pictures, and they need "
        "matplotlib, which is not installed. Install it with: pip install "
        '"geosurf[render]"; or run it with --no-pictures (pictures=False).'
    )


def distributions(lines: list[str]) -> set[str]:
    return {line.partition(">")[0] for line in lines if not line.startswith("geosurf[")}


@pytest.mark.parametrize("extra", EXTRAS)
def test_the_sentences_name_the_extras_that_are_declared(extra: str) -> None:
    declared = distributions(PROJECT["optional-dependencies"][extra])
    assert {DISTRIBUTION.get(name, name) for name in EXTRAS[extra]} == declared


def test_the_core_draws_nothing_and_everybody_else_does() -> None:
    core = distributions(PROJECT["dependencies"])
    assert core == set(REQUIRED)
    assert not core & distributions(PROJECT["optional-dependencies"]["render"])
    everything = PROJECT["optional-dependencies"]["all"][0]
    assert set(everything.removeprefix("geosurf[").rstrip("]").split(",")) == {*EXTRAS} - {"tet"}
    assert "geosurf[render]" in PROJECT["optional-dependencies"]["notebook"]
