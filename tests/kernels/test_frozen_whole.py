"""The library of all kernels against kernels compiled here: the same bytes, and no numba.

Freezing takes minutes, so it is done once for some sources and kept beside the compiled kernels.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import geosurf as gs
from tests.kernels import frozen
from tests.kernels.scenes import scenes
from tests.kernels.test_uncompiled import short_form
from tests.processes import told_by

KERNELS = "geosurf.kernels"
HEAVY = {"numba", "llvmlite", "scipy", "pyvista", "vtk", "vtkmodules", "matplotlib", "meshio"}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(1800),
    pytest.mark.skipif(
        "GEOSURF_WHOLE" not in os.environ,
        reason="freezes all kernels, which takes two minutes: set GEOSURF_WHOLE=1",
    ),
]


@pytest.fixture(scope="module")
def library() -> Path:
    return frozen.frozen(KERNELS)


def run(library: Path, *command: str | Path) -> str:
    """Run Python with a library; the environment decides nothing else."""
    chosen = {"GEOSURF_FROZEN": str(library), "PYTHONWARNINGS": "error"}
    return told_by(*command, without=("GEOSURF_JIT", "NUMBA_DISABLE_JIT"), **chosen)


@pytest.mark.parametrize("level", ["x86-64", "x86-64-v3"])
def test_frozen_kernels_give_the_same_bytes(level, library, tmp_path):
    folder = frozen.only_level(library, tmp_path / "one", level)
    said = run(folder, "-m", "tests.kernels.scenes").splitlines()
    mine = [f"{name}: {digest}" for name, digest in scenes()]
    assert said == [*mine, "numba: False"]
    assert len(mine) == len(set(mine)) > 50


def test_the_three_ways_meet_in_one_scene(library):
    """Plain Python is compared with this process in `test_uncompiled`."""
    code = "from tests.kernels.test_uncompiled import short_form; print(short_form())"
    assert run(library, "-c", code).strip() == short_form()


def test_curves_of_two_files_import_nothing_heavy(library, tmp_path):
    world = gs.synthetic.tilted_planes(n=5)
    top = gs.triangulate_horizon(world.horizons["Top"], name="Top")
    fault = gs.triangulate_fault(world.faults["F1"], name="F1")
    for surface in (top, fault):
        gs.write(surface, tmp_path / f"{surface.name}.ts")
    gs.write(world.horizons["Top"], tmp_path / "Top.gri")
    heavy = HEAVY | {"xarray", "pandas"}
    for first in ("Top.gri", "Top.ts"):
        words = ["curves", str(tmp_path / first), str(tmp_path / "F1.ts"), "--positive", "up"]
        words += ["-o", str(tmp_path / "c.vtp")]
        code = f"import sys, geosurf.cli as c; assert c.main({words!r}) == 0; print(*sys.modules)"
        said = run(library, "-c", code).split()
        assert not heavy & set(said)
        assert "geosurf.kernels.compile.frozen_runner" in said


def test_doctor_and_warmup_say_what_runs(library):
    assert "kernels are frozen: machine code for x86-64" in run(
        library, "-c", "from geosurf.kernels.compile.jit import RUNNER; print(RUNNER.describe())"
    )
    said = run(library, "-m", "geosurf", "warmup")
    assert said.startswith("Nothing to compile: kernels are frozen")
