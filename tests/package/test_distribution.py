"""What a wheel holds, and whether the files around the package agree with it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.long
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PYTHONS = [
    line.rpartition(" ")[2]
    for line in PROJECT["classifiers"]
    if re.search(r":: 3\.\d+$", line)
]  # fmt: skip


def test_a_wheel_holds_the_package_and_nothing_else() -> None:
    held = {file.distribution_path for file in WheelBuilder(str(ROOT)).recurse_included_files()}
    assert {name.partition("/")[0] for name in held} == {"geosurf"}
    assert {"geosurf/py.typed", "geosurf/__init__.py"} <= held
    ours = {path.relative_to(ROOT).as_posix() for path in (ROOT / "geosurf").rglob("*.py")}
    assert ours <= held
    assert not [name for name in held if re.search(r"(^|/)(tests|benchmarks|bench)(/|$)", name)]


def test_a_source_archive_holds_tests_and_benchmarks() -> None:
    held = {file.distribution_path for file in SdistBuilder(str(ROOT)).recurse_included_files()}
    assert {"geosurf", "tests", "benchmarks", "docs"} <= {name.partition("/")[0] for name in held}


def test_the_lowest_python_is_the_same_everywhere() -> None:
    assert PROJECT["requires-python"] == f">={PYTHONS[0]}"
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    assert settings["mypy"]["python_version"] == PYTHONS[0]
    assert settings["ruff"]["target-version"] == "py" + PYTHONS[0].replace(".", "")


def test_the_matrix_runs_every_python_that_is_promised() -> None:
    matrix = (ROOT / ".github" / "workflows" / "test.yml").read_text(encoding="utf-8")
    assert re.findall(r'"([\d.]+)"', re.search(r"python: \[(.*)\]", matrix)[1]) == PYTHONS
