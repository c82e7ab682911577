"""The house keeps its own rules: imports, style, types, and what never appears in the code."""

from __future__ import annotations

import ast
import gc
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest

from tests import mutants

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted((ROOT / "geosurf").rglob("*.py"))
BENCHMARKS = sorted((ROOT / "benchmarks").rglob("*.py"))
BIN = Path(sys.executable).parent
HEAVY = ("xarray", "pandas", "pyvista", "vtk", "vtkmodules", "scipy", "numba", "meshio")
LONGEST_FILE = 600  # lines outside docstrings


def run(*command: str | Path) -> subprocess.CompletedProcess[str]:
    """Run one tool in the checkout and keep what it says."""
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.fixture(scope="module", autouse=True)
def _no_garbage() -> Iterator[None]:
    """Trees of all files are kept, and to look through them again and again takes 5 s."""
    gc.disable()
    yield
    tree_of.cache_clear()
    nodes_of.cache_clear()
    gc.enable()


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes_of(path: Path) -> list[ast.AST]:
    """All nodes of a file: seven tests walk through all of them."""
    return list(ast.walk(tree_of(path)))


def dotted(node: ast.AST) -> str:
    """The name of what is called: ``unparse`` of all calls takes seconds."""
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def calls(nodes: Iterable[ast.AST]) -> Iterator[tuple[int, str]]:
    """Line and dotted name of everything that is called."""
    for node in nodes:
        if isinstance(node, ast.Call):
            yield node.lineno, dotted(node.func)


def imported_roots(nodes: Iterable[ast.AST]) -> Iterator[tuple[int, str]]:
    """Line and first name of everything that is imported, lazily or not."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name.split(".")[0]) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield node.lineno, node.module.split(".")[0]


def tracked_files() -> list[Path]:
    listing = run("git", "ls-files", "-z")
    if listing.returncode != 0:
        pytest.skip("needs a git checkout: a source archive has no list of tracked files")
    return [ROOT / name for name in listing.stdout.split("\0") if name and (ROOT / name).is_file()]


# ---- tools ---------------------------------------------------------------------------


@pytest.mark.timeout(1200)  # types from scratch, on cores that others use
@pytest.mark.parametrize(
    "command",
    [
        ("lint-imports", "--no-cache"),
        ("ruff", "check", "--output-format=concise", "."),
        ("ruff", "format", "--check", "--output-format=concise", "."),
        # two workers take a fifth less processor time than one: 48 s for 62 s
        pytest.param(("mypy", "--num-workers=2"), marks=pytest.mark.long),
    ],
    ids=["imports", "ruff check", "ruff format", "mypy"],
)
def test_the_tool_has_nothing_to_say(command: tuple[str, ...]) -> None:
    tool, *arguments = command
    said = run(BIN / tool, *arguments)
    if "connection with worker" in said.stdout:  # busy cores: they did not start in three seconds
        said = run(BIN / tool)
    assert said.returncode == 0, f"\n{said.stdout}\n{said.stderr}"


# ---- imports -------------------------------------------------------------------------


BREACHES = {
    "comb": ("report/breach.py", "def late():\n    import geosurf.carve\n"),
    "undeclared room": ("helpers.py", ""),
    "kernels": ("kernels/exact/breach.py", "import xarray\n"),
    "rooms of kernels": ("kernels/exact/rooms.py", "import geosurf.kernels.meshes.mesh\n"),
    "rooms of sheets": ("sheets/lattice/breach.py", "import geosurf.sheets.heights.passes\n"),
    "numba": ("intersect/breach.py", "from numba import njit\n"),
    "pyvista": ("write/breach.py", "def late():\n    import pyvista\n"),
    "vtk": ("read/breach.py", "from vtkmodules.vtkCommonCore import vtkPoints\n"),
    "meshio": ("render/breach.py", "import meshio\n"),
}


@pytest.fixture(scope="module")
def said_of_breaches(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What the tool says of a copy of the package with all wrong imports at once."""
    copy = tmp_path_factory.mktemp("breaches")
    shutil.copytree(ROOT / "geosurf", copy / "geosurf")
    shutil.copy(ROOT / "pyproject.toml", copy)
    for name, text in BREACHES.values():
        (copy / "geosurf" / name).write_text(text)
    said = subprocess.run(
        [BIN / "lint-imports", "--no-cache"], cwd=copy, capture_output=True, text=True
    )
    assert said.returncode == 1
    return said.stdout


@pytest.mark.parametrize("breach", BREACHES)
def test_the_contracts_bite(breach: str, said_of_breaches: str) -> None:
    name, _ = BREACHES[breach]
    module = "geosurf." + Path(name).with_suffix("").as_posix().replace("/", ".")
    assert re.search(rf"\b{re.escape(module)}\b", said_of_breaches)


def modules() -> dict[str, Path]:
    """Every module of the package by its dotted name; a folder has the name of its __init__."""
    names = (path.relative_to(ROOT).with_suffix("").as_posix() for path in SOURCES)
    dotted = (name.replace("/", ".").removesuffix(".__init__") for name in names)
    return dict(zip(dotted, SOURCES, strict=True))


def imports_of(path: Path, known: Collection[str]) -> set[str]:
    """Modules of the package that a file names: at its top, in functions, for types only."""
    found: set[str] = set()
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            below = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= below & set(known) or {node.module}
    return found & set(known)


def circle_in(graph: Mapping[str, set[str]]) -> list[str]:
    """Names along one circle of a graph; empty if there is none."""
    path: list[str] = []
    done: set[str] = set()

    def walk(name: str) -> list[str]:
        """Follow all imports of a module; the circle that they close, if they do."""
        if name in path:
            return [*path[path.index(name) :], name]
        if name in done:
            return []
        path.append(name)
        for other in sorted(graph[name]):
            circle = walk(other)
            if circle:
                return circle
        done.add(path.pop())
        return []

    return next(filter(None, map(walk, sorted(graph))), [])


def test_no_imports_go_in_a_circle() -> None:
    """Imports in functions and below TYPE_CHECKING count as all others.

    One file is excepted: ``geosurf/__init__.py`` names everything that is public, and imports it
    when it is first used. Modules below it take ``from geosurf import room`` as an import of that
    room. That Python runs the ``__init__`` of a folder before a module in it is no import here: the
    test counts what files name.
    """
    known = modules()
    graph = {name: imports_of(path, known) for name, path in known.items()}
    graph["geosurf"] = set()
    assert " -> ".join(circle_in(graph)) == ""


STAGES = (
    *("read", "triangulate", "arrangement", "intersect", "rebuild", "carve", "measure"),
    *("grid", "report", "write", "synthetic"),
)


def test_imports_load_nothing_heavy() -> None:
    """Stages load no VTK, rooms that draw no xarray, nor does a look at what is installed."""
    modules = ", ".join(f"geosurf.{stage}" for stage in STAGES)
    said = run(
        sys.executable, "-c",
        "import sys, geosurf\nprint(*sys.modules)\nimport geosurf.render, geosurf.report\n"
        "from geosurf.cli.info_commands import installation; installation()\n"
        f"print(*sys.modules)\nimport {modules}\nprint(*sys.modules)",
    )  # fmt: skip
    assert said.returncode == 0, said.stderr
    of_geosurf, of_render, of_all = map(set, map(str.split, said.stdout.splitlines()))
    assert not {*HEAVY} & of_geosurf
    assert not {"pyvista", "vtk", "vtkmodules", "matplotlib", "xarray"} & of_render
    assert not {"pyvista", "vtk", "vtkmodules", "meshio", "matplotlib"} & of_all


# ---- what every file keeps to --------------------------------------------------------
# One test per rule lists all breaches. One per rule and file made 4400 tests, which took 30 s.


def test_every_import_is_declared() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    names = ("crs", "ensemble", "gis", "grid", "io", "notebook", "render", "tet")
    used = (line for name in names for line in extras[name])
    lines = [*project["dependencies"], *used]
    packages = {re.split(r"[^\w-]", line)[0].replace("-", "_") for line in lines}
    # come with a declared package, and are part of what it offers
    packages |= {"geosurf", "vtkmodules", "pandas", "cloudpickle", "shapefile"}
    of_kernels = {"geosurf", "numpy", "numba", "llvmlite"}
    found = [
        f"{name_of(path)}:{line} imports {root}"
        for path in SOURCES
        for line, root in imported_roots(nodes_of(path))
        if root not in (of_kernels if "kernels" in path.parts else packages)
        if root not in sys.stdlib_module_names
    ]
    assert not found, lines_of("pyproject.toml does not name these", found)


def lines_of(title: str, found: list[str]) -> str:
    return "\n".join([f"{title}:", *found])


def other_rooms_through_the_front_door(path: Path) -> Iterator[str]:
    """``from geosurf import carve_units`` would let a stage call another unseen."""
    if "cli" in path.parts:
        return
    for node in nodes_of(path):
        if isinstance(node, ast.ImportFrom) and node.module == "geosurf":
            names = {alias.name for alias in node.names} - rooms() - {"__version__"}
            if names:
                yield f"{node.lineno} imports {names}"
        if isinstance(node, ast.Import) and "geosurf" in {alias.name for alias in node.names}:
            yield f"{node.lineno} imports geosurf"


@cache
def rooms() -> set[str]:
    return {source.stem for source in SOURCES} | {source.parent.name for source in SOURCES}


def prints_and_exits(path: Path) -> Iterator[str]:
    """Only programs may: the command line, its signals, files with ``__name__ == "__main__"``."""
    if "cli" in path.parts or path.name == "stopping.py":
        return
    wrong = {"print", "exit", "quit", "sys.exit", "os._exit", "os.abort"}
    guards = filter(_is_main_guard, tree_of(path).body)
    allowed = {id(node) for guard in guards for node in ast.walk(guard)}
    nodes = [node for node in nodes_of(path) if id(node) not in allowed]
    yield from (f"{line} {call}" for line, call in calls(nodes) if call in wrong)
    for node in nodes:
        if isinstance(node, ast.Raise) and node.exc and "SystemExit" in ast.unparse(node.exc):
            yield f"{node.lineno} SystemExit"


def _is_main_guard(node: ast.stmt) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) == "__name__ == '__main__'"


def fastmath(path: Path) -> Iterator[str]:
    """Exact sums and products of doubles are wrong as soon as a compiler may reorder them."""
    for node in nodes_of(path):
        if isinstance(node, ast.keyword) and node.arg == "fastmath":
            off = isinstance(node.value, ast.Constant) and node.value.value is False
            yield from () if off else (f"{node.value.lineno} fastmath",)
        if isinstance(node, ast.Constant) and node.value == "fastmath":
            yield f"{node.lineno} 'fastmath' as a key"


def left_to_do_or_swallowed(path: Path) -> Iterator[str]:
    text = path.read_text(encoding="utf-8")
    yield from re.findall(r"\b(?:TODO|FIXME|XXX|HACK)\b", text)
    for node in nodes_of(path):
        if isinstance(node, ast.ExceptHandler):
            caught = "everything" if node.type is None else ast.unparse(node.type)
            if caught in ("everything", "Exception", "BaseException"):
                yield f"{node.lineno} catches {caught}"
        if isinstance(node, ast.Raise) and "NotImplementedError" in ast.unparse(node):
            yield f"{node.lineno} raises NotImplementedError"


def places_said_without_data(path: Path) -> Iterator[str]:
    """What a sentence names for people, `render_place` needs as numbers."""
    errors = ("GeometryError", "OpenUnitError", "RoundingError")
    for node in nodes_of(path):
        if isinstance(node, ast.Call) and dotted(node.func) in errors:
            says = any(name == "place" for part in node.args for _, name in calls(ast.walk(part)))
            if says and not any(keyword.arg == "place" for keyword in node.keywords):
                yield f"{node.lineno} {dotted(node.func)}"


def too_long(path: Path) -> Iterator[str]:
    """Docstrings do not count: those of the API say shapes, units and errors in full."""
    lines = len(path.read_text(encoding="utf-8").splitlines())
    for node in nodes_of(path):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(
            node
        ):
            lines -= node.body[0].end_lineno - node.body[0].lineno + 1
    if lines > LONGEST_FILE:
        yield f"{lines} lines; split it into two rooms"


ALL = [*SOURCES, *BENCHMARKS]
# Hostile arguments count every exception that is none of ours: their files catch all.
STRICT = [*SOURCES, *(path for path in BENCHMARKS if path.parent.name != "stress")]
# For every rule: files that have to keep to it, and one that breaks it once.
RULES = {
    other_rooms_through_the_front_door: (SOURCES, "from geosurf import carve_units\n"),
    prints_and_exits: (SOURCES, "def f():\n    print(1)\n"),
    places_said_without_data: (SOURCES, "raise GeometryError(f'at {place(x)}')\n"),
    fastmath: (ALL, "njit(fastmath=True)\n"),
    left_to_do_or_swallowed: (STRICT, "try:\n    f()\nexcept Exception:\n    pass\n"),
    too_long: (ALL, "x = 1\n" * (LONGEST_FILE + 1)),
}


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
def test_no_file_breaks(rule: Callable[[Path], Iterator[str]], tmp_path: Path) -> None:
    files, broken = RULES[rule]
    (tmp_path / "broken.py").write_text(broken)
    assert len(list(rule(tmp_path / "broken.py"))) == 1
    found = [f"{name_of(path)}:{breach}" for path in files for breach in rule(path)]
    assert not found, lines_of(rule.__name__, found)


def test_tracked_files_name_no_machine() -> None:
    """No home folder, no package index, no address inside one network."""
    # put together here, so that this file does not find itself
    folders = "|".join(["work", "farm", "root", "home", "Users"])
    patterns = [
        rf"(?<![\w.])/(?:{folders})/[\w.-]+",
        r"--?(?:extra-)?index" + "-url|find" + r"-links\s*[=/]",
        r"https?://[^\s\"']+" + r"/simple\b",
        r"\b(?:10|192\.168|172\.(?:1[6-9]|2\d|3[01]))" + r"\.\d+\.\d+(?:\.\d+)?:\d+",
    ]
    found = []
    for path in tracked_files():
        data = path.read_bytes()
        if b"\0" in data[:4096]:
            continue
        text = data.decode("utf-8", errors="replace")
        for pattern in patterns:
            found += [f"{name_of(path)}: {hit}" for hit in re.findall(pattern, text)]
    assert not found, "\n".join(found)


def test_tracked_files_are_small() -> None:
    large = [name_of(path) for path in tracked_files() if path.stat().st_size > 2_000_000]
    assert not large


def test_constraints_pin_versions_and_nothing_else() -> None:
    lines = (ROOT / "constraints.txt").read_text().split()
    assert len(lines) > 10
    odd = [line for line in lines if not re.fullmatch(r"[A-Za-z0-9._-]+==[0-9][\w.]*", line)]
    assert not odd
    assert not {"geosurf", "pip", "setuptools"} & {line.split("==")[0] for line in lines}


# ---- The list of planted mistakes fits the code of today; `python -m tests.mutants` plants them.
def test_each_planted_mistake_has_its_place():
    assert len(mutants.MUTANTS) >= 60
    assert [one.text for one in mutants.MUTANTS if mutants.found(one) is None] == []
