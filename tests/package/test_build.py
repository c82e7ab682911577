"""The build hook: which wheel is made where. The freezer itself is tested in tests/kernels."""

from __future__ import annotations

import importlib.util
import platform
import re
import shutil
import sys
import tomllib
import types
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.long
HOOK = ROOT / "hatch_build.py"
linux = pytest.mark.skipif(
    (sys.platform, platform.machine()) != ("linux", "x86_64"), reason="kernels are not frozen here"
)


class Interface:
    """What hatchling hands to a hook, as far as ours looks at it."""

    def __init__(self, root: Path, target: str = "wheel") -> None:
        self.root = str(root)
        self.target_name = target
        self.said: list[str] = []
        self.app = types.SimpleNamespace(display_info=self.said.append)


@pytest.fixture
def hook(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The module of the hook; hatchling, which only builds have, is replaced by `Interface`."""
    if not HOOK.exists():
        pytest.skip("needs a checkout: the hook is no part of the installed package")
    interface = types.ModuleType("hatchling.builders.hooks.plugin.interface")
    interface.BuildHookInterface = Interface
    monkeypatch.setitem(sys.modules, interface.__name__, interface)
    for variable in ("GEOSURF_PURE", "GEOSURF_PLATFORM"):
        monkeypatch.delenv(variable, raising=False)
    spec = importlib.util.spec_from_file_location("hatch_build", HOOK)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def built(hook: Any, root: Path = ROOT, target: str = "wheel", version: str = "standard"):
    """Run the hook; return what it said and what it told hatchling."""
    data: dict[str, Any] = {"force_include": {}}
    made = hook.FrozenKernels(root, target)
    made.initialize(version, data)
    inside = {Path(source).is_file(): target for source, target in data["force_include"].items()}
    made.finalize(version, data, "")
    assert not any(Path(source).exists() for source in data["force_include"])
    assert False not in inside
    return " ".join(made.said), data


PURE = {"force_include": {}}


def test_a_pure_wheel_is_made_where_it_is_asked_for(hook, monkeypatch):
    monkeypatch.setenv("GEOSURF_PURE", "1")
    said, data = built(hook)
    assert "GEOSURF_PURE is set" in said
    assert data == PURE
    assert hook.FrozenKernels(ROOT).dependencies() == []


@linux
def test_without_a_compiler_the_wheel_is_pure_and_says_so(hook, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    said, data = built(hook)
    assert (
        "no C compiler here (CC, cc, gcc, clang, or `pip install ziglang`). A pure wheel." in said
    )
    assert data == PURE


def _project(folder: Path, freezer: str) -> Path:
    """A project whose freezer does what a test wants."""
    (folder / "geosurf" / "kernels" / "compile").mkdir(parents=True)
    for package in ("geosurf", "geosurf/kernels", "geosurf/kernels/compile"):
        (folder / package / "__init__.py").write_text("")
    (folder / "geosurf" / "kernels" / "compile" / "freeze.py").write_text(freezer)
    shutil.copy(ROOT / "constraints.txt", folder)
    shutil.copy(ROOT / "geosurf/kernels/compile/platforms.py", folder / "geosurf/kernels/compile")
    return folder


@linux
def test_a_freeze_that_fails_is_an_error_and_no_pure_wheel(hook, tmp_path):
    root = _project(tmp_path, "raise ValueError('kernel x cannot be frozen')")
    with pytest.raises(RuntimeError, match=r"(?s)GEOSURF_PURE=1 builds without.*kernel x cannot"):
        built(hook, root)


@linux
def test_the_library_goes_into_a_wheel_for_every_python_of_this_platform(hook, tmp_path):
    freezer = "import sys, pathlib\nout = pathlib.Path(sys.argv[2])\n(out / 'kernels.so').touch()\n"
    said, data = built(hook, _project(tmp_path, freezer + "print('1 kernels frozen.')"))
    assert said.endswith("1 kernels frozen.")
    assert data["pure_python"] is False
    assert data["tag"] == "py3-none-linux_x86_64"
    assert list(data["force_include"].values()) == ["geosurf/kernels/frozen/kernels.so"]


TAGS = {
    "linux-x86_64": "linux_x86_64",
    "linux-aarch64": "linux_aarch64",
    "darwin-arm64": "macosx_11_0_arm64",
    "win32-x86_64": "win_amd64",
}


@pytest.mark.parametrize("name", TAGS)
def test_a_wheel_for_another_platform_is_linked_by_zig(name, hook, monkeypatch, tmp_path):
    monkeypatch.setenv("GEOSURF_PLATFORM", name)
    freezer = f"import sys, pathlib\nassert sys.argv[3:] == ['--platform', {name!r}]\n"
    freezer += "(pathlib.Path(sys.argv[2]) / 'kernels').touch()\n"
    _, data = built(hook, _project(tmp_path, freezer))
    assert data["tag"] == f"py3-none-{TAGS[name]}"
    pins = hook.FrozenKernels(ROOT).dependencies()
    assert {pin.partition("==")[0] for pin in pins} == {"llvmlite", "numba", "numpy", "ziglang"}


def test_every_platform_has_a_runner_that_tries_its_wheel_with_every_python():
    from geosurf.kernels.compile.platforms import PLATFORMS

    workflow = (ROOT / ".github" / "workflows" / "wheels.yml").read_text(encoding="utf-8")
    assert re.findall(r"platform: ([\w-]+), runner", workflow) == list(PLATFORMS)
    settings = STATED["tool"]["cibuildwheel"]
    assert settings["build"] == [f"cp{python.replace('.', '')}-*" for python in PYTHONS]
    tried = settings["test-command"].removeprefix("python {project}/")
    assert (ROOT / tried).is_file()


# ---- The dependencies that are declared are those that `make test-oldest` tries.
STATED = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = STATED["project"]
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


# ---- What a wheel holds, and whether the files around the package agree with it.
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
    assert STATED["tool"]["mypy"]["python_version"] == PYTHONS[0]
    assert STATED["tool"]["ruff"]["target-version"] == "py" + PYTHONS[0].replace(".", "")


def test_the_matrix_runs_every_python_that_is_promised() -> None:
    matrix = (ROOT / ".github" / "workflows" / "test.yml").read_text(encoding="utf-8")
    assert re.findall(r'"([\d.]+)"', re.search(r"python: \[(.*)\]", matrix)[1]) == PYTHONS
