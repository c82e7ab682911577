"""The pages that a stranger reads are in step with the package, and their links lead somewhere."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib import util
from pathlib import Path

import pytest

import geosurf

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.long
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


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_and_pictures_are_there(page: Path) -> None:
    for target, heading in links_of(page):
        if target.suffix == ".ipynb":  # the build copies notebooks from the root into docs/
            target = ROOT / "notebooks" / target.name
        assert target.exists(), target
        if heading:
            assert heading in headings_of(target), f"{target}#{heading}"


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


# ---- the site


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
