"""The pages that a stranger reads are in step with the package, and their links lead somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import geosurf

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)


def test_the_page_of_names_is_the_list_of_names() -> None:
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    named = re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE)
    assert sorted(named) == sorted(geosurf.__all__)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_and_pictures_are_there(page: Path) -> None:
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if "://" not in target and not target.startswith("#"):
            assert (page.parent / target.partition("#")[0]).exists(), target


def test_pictures_are_small() -> None:
    for picture in (ROOT / "docs" / "pictures").glob("*.png"):
        assert picture.stat().st_size < 300_000, picture.name


def test_the_ten_lines_of_the_readme_run(tmp_path: Path, monkeypatch, capsys) -> None:
    (block,) = BLOCK.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    assert len(block.strip().splitlines()) <= 11
    (tmp_path / "data").symlink_to(ROOT / "data")
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "README.md", "exec"), {})
    assert (tmp_path / "view.png").is_file()
    assert (tmp_path / "units.vtm").is_file()
    assert "m3" in capsys.readouterr().out


def test_the_smallest_scenario_of_the_docs_is_one(tmp_path: Path) -> None:
    from geosurf.scenario import read_scenario

    page = (ROOT / "docs" / "scenario.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    (tmp_path / "top.gri").write_bytes(b"a file")
    (tmp_path / "scenario.toml").write_text(block)
    assert read_scenario(tmp_path / "scenario.toml").horizons[0].positive == "down"
