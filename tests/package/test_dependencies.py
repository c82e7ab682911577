"""The dependencies that are declared are those that `make test-oldest` tries."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.long
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
DECLARED = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["io"]]


def pins(file: str) -> dict[str, str]:
    lines = (ROOT / file).read_text().split()
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[0-9][\w.]*", line) for line in lines)
    return dict(line.split("==") for line in lines)


def numbers(text: str) -> tuple[int, ...]:
    """A version without zeros at its end: 2.0 is 2.0.0."""
    found = [int(part) for part in text.split(".")]
    while found and found[-1] == 0:
        found.pop()
    return tuple(found)


@pytest.mark.parametrize("line", DECLARED)
def test_each_lower_bound_is_the_oldest_version_that_is_tried(line: str) -> None:
    name, lower = re.match(r"([\w-]+)>=([\d.]+)", line).groups()
    assert numbers(pins("constraints-oldest.txt")[name]) == numbers(lower)


def test_numba_has_an_upper_bound_just_above_the_newest_that_is_tried() -> None:
    """Kernels rest on private parts of it, which any version may change."""
    (line,) = (line for line in DECLARED if line.startswith("numba"))
    upper = numbers(re.search(r"<([\d.]+)", line)[1])
    newest = numbers(pins("constraints.txt")["numba"])
    assert newest < upper == (newest[0], newest[1] + 1)
    assert numbers(version("numba")) < upper


def test_what_an_extra_brings_is_used() -> None:
    sources = "".join(path.read_text() for path in (ROOT / "geosurf").rglob("*.py"))
    for line in PROJECT["optional-dependencies"]["io"]:
        assert re.search(rf"\b{re.split('[<>=]', line)[0]}\b", sources), line
