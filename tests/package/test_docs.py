"""The pages that a stranger reads are in step with the package, and their links lead somewhere."""

from __future__ import annotations

import ast
import inspect
import re
import subprocess
import sys
import textwrap
from functools import cached_property
from importlib import import_module, util
from pathlib import Path
from typing import Any

import pytest

import geosurf

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
BUILT = ("_build", "generated")  # git-ignored
FOUND = sorted(DOCS.rglob("*.md"))
PAGES = [ROOT / "README.md", *(p for p in FOUND if p.relative_to(DOCS).parts[0] not in BUILT)]
GUIDES = [page for page in sorted((DOCS / "guides").glob("*.md")) if page.stem != "index"]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def without_code(page: Path) -> str:
    return re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def links_of(page: Path) -> set[tuple[Path, str]]:
    """Pages that a page links to, each with the heading or ''."""
    found = set()
    for target in LINK.findall(without_code(page)):
        path, _, heading = target.partition("#")
        if "://" not in target and path:
            found.add(((page.parent / path).resolve(), heading))
    return found


def headings_of(page: Path) -> set[str]:
    """Headings as links name them."""
    lines = re.findall(r"^#+ (.*)$", without_code(page), re.MULTILINE)
    words = (re.sub(r"[^\w\- ]", "", line.lower()) for line in lines)
    return {line.strip().replace(" ", "-") for line in words}


# ---- pages and the package


def test_the_page_of_names_is_the_list_of_names() -> None:
    page = (DOCS / "api.md").read_text(encoding="utf-8")
    listed = re.findall(r"^   (\w+)$", page, re.MULTILINE)
    assert sorted(listed) == sorted(geosurf.__all__)


def test_the_glossary_names_code_that_exists() -> None:
    rows = re.findall(r"^\| (?!term|-).*`([\w./]+)` \|$", (DOCS / "glossary.md").read_text(), re.M)
    assert 40 <= len(rows) <= 80
    for place in rows:
        if "/" in place:
            assert (ROOT / place).exists(), place
        else:
            owner, *names = place.split(".")
            found = import_module(owner)
            for name in names:
                fields = getattr(found, "__dataclass_fields__", {})
                found = fields[name] if name in fields else getattr(found, name)


def test_every_environment_variable_is_on_its_page() -> None:
    page = (DOCS / "environment.md").read_text(encoding="utf-8")
    files = [*(ROOT / "geosurf").rglob("*.py"), *(ROOT / "tests").rglob("*.py")]
    used = {v for file in files for v in re.findall(r"\"(GEOSURF_[A-Z_]+)\"", file.read_text())}
    assert used
    assert {name for name in used if f"`{name}`" not in page} == set()


def test_the_smallest_scenario_of_the_docs_is_one(tmp_path: Path) -> None:
    from geosurf.scenario import read_scenario

    page = (DOCS / "scenario.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    (tmp_path / "top.gri").write_bytes(b"a file")
    (tmp_path / "scenario.toml").write_text(block)
    assert read_scenario(tmp_path / "scenario.toml").horizons[0].positive == "down"


# ---- code that readers copy


def run_blocks(page: Path) -> dict[str, object]:
    space: dict[str, object] = {}
    for block in BLOCK.findall(page.read_text(encoding="utf-8")):
        exec(compile(block, name_of(page), "exec"), space)
    return space


def test_the_lines_of_the_readme_run(tmp_path: Path, monkeypatch, capsys) -> None:
    (block,) = BLOCK.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    assert len(block.strip().splitlines()) <= 20
    (tmp_path / "data").symlink_to(ROOT / "data")
    monkeypatch.chdir(tmp_path)
    run_blocks(ROOT / "README.md")
    assert (tmp_path / "view.png").is_file()
    assert (tmp_path / "units.vtm").is_file()
    assert "million m³" in capsys.readouterr().out


@pytest.mark.filterwarnings("default::geosurf.GeosurfWarning")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of matplotlib's and pyvista's own
@pytest.mark.parametrize("page", [DOCS / "get_started" / "own_data.md", *GUIDES], ids=name_of)
def test_the_code_of_a_guide_runs_in_an_empty_folder(page, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert BLOCK.search(page.read_text(encoding="utf-8")), "the page has no code"
    names = run_blocks(page)
    assert set(names) - {"__builtins__"}, "the code defines nothing"
    assert capsys.readouterr().out.strip(), "the code prints nothing"


def test_own_data_become_units_in_twenty_lines(tmp_path: Path, monkeypatch, capsys) -> None:
    page = DOCS / "get_started" / "own_data.md"
    text = page.read_text(encoding="utf-8")
    (shown,) = re.findall(r"^```text\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    code = [line for line in BLOCK.findall(text)[1].splitlines() if line and line[0] != "#"]
    assert len(code) <= 20
    monkeypatch.chdir(tmp_path)
    run_blocks(page)
    assert shown in capsys.readouterr().out


# ---- length, links and pictures


@pytest.mark.parametrize("page", GUIDES, ids=name_of)
def test_a_guide_has_800_words_at_most(page: Path) -> None:
    assert len(without_code(page).split()) <= 800


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_and_pictures_are_there(page: Path) -> None:
    for target, heading in links_of(page):
        if target.suffix == ".ipynb":  # the build copies notebooks from the root into docs/
            target = ROOT / "notebooks" / target.name
        assert target.exists(), target
        if heading:
            assert heading in headings_of(target), f"{target}#{heading}"


@pytest.mark.parametrize("page", [p for p in PAGES if p.stem != "changelog"], ids=name_of)
def test_files_that_a_page_names_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for path in re.findall(r"`((?:geosurf|tests|benchmarks|docs|data)/[\w/.]+)`", text):
        if "_build" not in path:
            assert (ROOT / path).exists(), path


@pytest.mark.parametrize("page", sorted((DOCS / "validation").glob("*.md")), ids=name_of)
def test_a_page_of_validation_has_a_command_and_a_date(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    if page.stem != "index":
        assert re.search(r"python -m \w+", text)
        assert re.search(r"\w+ 20\d\d", text)


def test_each_picture_is_drawn_by_one_script_and_shown() -> None:
    scripts = [*(DOCS / "gallery").glob("*.py"), *(DOCS / "figures").glob("*.py")]
    drawn = [
        name
        for script in scripts
        for name in re.findall(r"docs/pictures/(\w+\.png)", script.read_text(encoding="utf-8"))
    ]
    shown = {target.name for page in PAGES for target, _ in links_of(page)}
    pictures = sorted(path.name for path in (DOCS / "pictures").glob("*.png"))
    assert sorted(drawn) == pictures
    assert set(pictures) <= shown


def test_pictures_are_small() -> None:
    for picture in (DOCS / "pictures").glob("*.png"):
        assert picture.stat().st_size < 150_000, picture.name


# ---- the site


def test_docstrings_have_the_parameters_of_the_signature() -> None:
    """By numpydoc: none is missing, none unknown, all in order."""
    validation = pytest.importorskip("numpydoc.validate", reason="needs the extra geosurf[docs]")
    public = [getattr(geosurf, name) for name in geosurf.__all__]
    functions = [f"{o.__module__}.{o.__qualname__}" for o in public if inspect.isfunction(o)]
    assert len(functions) > 20
    for name in functions:
        errors = dict(validation.validate(name)["errors"])
        assert not errors.keys() & {"GL08", "PR01", "PR02", "PR03"}, (name, errors)


CLASSES = (geosurf.Scene, geosurf.Units, geosurf.Sheet, geosurf.Curves, geosurf.TriSurface)


def members_of(kind: type) -> dict[str, Any]:
    """Public methods and properties of a class, with those of its bases in geosurf."""
    kinds = (property, cached_property, classmethod, staticmethod)
    return {
        f"{base.__module__}.{base.__qualname__}.{name}": member
        for base in kind.__mro__
        if base.__module__.startswith("geosurf")
        for name, member in vars(base).items()
        if not name.startswith("_") and (inspect.isfunction(member) or isinstance(member, kinds))
    }


def words_of(thing: Any, section: str, column: str) -> set[str]:
    """What a section of a docstring lists: its names or its types."""
    from numpydoc.docscrape import NumpyDocString

    rows = NumpyDocString(inspect.getdoc(thing) or "")[section]
    return {word for row in rows for word in getattr(row, column).split(", ")}


def raised_in(member: Any) -> set[str]:
    """Names of the exceptions that a method or property raises itself."""
    for attribute in ("fget", "func", "__func__"):
        member = getattr(member, attribute, member)
    tree = ast.parse(textwrap.dedent(inspect.getsource(member)))
    calls = [node.exc for node in ast.walk(tree) if isinstance(node, ast.Raise)]
    return {call.func.id for call in calls if isinstance(call, ast.Call)}


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.__name__)
def test_classes_and_their_members_document_what_goes_in_and_comes_out(kind: type) -> None:
    """By numpydoc: parameters, results, and the errors that a member raises itself."""
    validation = pytest.importorskip("numpydoc.validate", reason="needs the extra geosurf[docs]")
    wanted = set(inspect.signature(kind).parameters)
    # fields of a dataclass are documented as attributes
    listed = words_of(kind, "Parameters", "name") | words_of(kind, "Attributes", "name")
    assert wanted <= listed, wanted - listed

    members = members_of(kind)
    assert len(members) > 3
    for name, member in members.items():
        errors = dict(validation.validate(name)["errors"])
        assert not errors.keys() & {"GL08", "PR01", "PR02", "PR03", "RT01", "SS05"}, (name, errors)
        unlisted = raised_in(member) - words_of(member, "Raises", "type")
        assert not unlisted, (name, unlisted)


@pytest.mark.skipif(util.find_spec("sphinx") is None, reason="needs the extra geosurf[docs]")
def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    """As `make docs` does; notebooks are not executed here, but in test_notebooks."""
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-j", "1"]
    command += ["-d", str(tmp_path / "doctrees"), "-D", "nb_execution_mode=off"]
    done = subprocess.run(
        [*command, str(DOCS), str(tmp_path / "html")],
        capture_output=True, text=True, timeout=280, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for name in geosurf.__all__:
        assert (tmp_path / "html" / "generated" / f"geosurf.{name}.html").is_file(), name
    for kind in (geosurf.Scene, geosurf.Units, geosurf.Sheet, geosurf.Curves):
        page = tmp_path / "html" / "generated" / f"geosurf.{kind.__name__}.html"
        text = page.read_text(encoding="utf-8")
        fields = getattr(kind, "__dataclass_fields__", {})  # those are in the text of the class
        for member in (name for name in vars(kind) if not name.startswith("_")):
            assert member in text if member in fields else f'.{member}"' in text, member
