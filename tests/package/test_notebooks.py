"""Notebooks run from top to bottom in a fresh kernel, and are kept without outputs."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

nbformat = pytest.importorskip("nbformat", reason="needs the extra geosurf[notebook]")
pytest.importorskip("IPython", reason="needs the extra geosurf[notebook]")

from IPython.core.interactiveshell import InteractiveShell  # noqa: E402
from IPython.utils.capture import capture_output  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.long
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))


def source_of(path: Path) -> str:
    cells = nbformat.read(path, as_version=4).cells
    return "\n".join(cell.source for cell in cells if cell.cell_type == "code")


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_nothing_is_stored_that_a_run_makes(path: Path) -> None:
    for cell in nbformat.read(path, as_version=4).cells:
        if cell.cell_type == "code":
            assert cell.outputs == []
            assert cell.execution_count is None


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_uses_public_names_and_ends_with_an_assert(path: Path) -> None:
    source = source_of(path)
    assert isinstance(ast.parse(source).body[-1], ast.Assert)
    assert "from geosurf" not in source
    assert not re.search(r"\b(gs|\w+)\._\w", source)


@pytest.mark.timeout(900)
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of zmq and its event loop
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_the_first_runs_in_a_kernel_of_its_own(tmp_path: Path) -> None:
    nbclient = pytest.importorskip("nbclient", reason="needs the extra geosurf[notebook]")
    notebook = nbformat.read(NOTEBOOKS[0], as_version=4)
    client = nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3")
    client.execute(cwd=str(tmp_path))
    shown = [out for cell in notebook.cells for out in cell.get("outputs", [])]
    assert any("image/png" in out.get("data", {}) for out in shown)
    assert not any(out.get("name") == "stderr" for out in shown), "a cell wrote to stderr"


@pytest.fixture
def shell() -> Iterator[Any]:
    """What runs cells; `capture_output` looks for the one of the process."""
    yield InteractiveShell.instance()
    InteractiveShell.clear_instance()


@pytest.mark.timeout(900)
@pytest.mark.filterwarnings("default::geosurf.GeosurfWarning")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of matplotlib's and pyvista's own
@pytest.mark.parametrize("path", NOTEBOOKS[1:], ids=lambda path: path.stem)
def test_it_runs_from_top_to_bottom(path: Path, tmp_path: Path, monkeypatch, shell: Any) -> None:
    """In this process, with names of its own: four more kernels would take 20 s of processor."""
    monkeypatch.chdir(tmp_path)
    pictures = 0
    for cell in nbformat.read(path, as_version=4).cells:
        if cell.cell_type == "code":
            with capture_output() as shown:
                done = shell.run_cell(cell.source)
            done.raise_error()
            assert shown.stderr == "", "a cell wrote to stderr"
            last, _ = shell.display_formatter.format(done.result)
            pictures += sum(
                "image/png" in data for data in (last, *(o.data for o in shown.outputs))
            )
    assert pictures
