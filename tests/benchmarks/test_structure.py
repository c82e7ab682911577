"""The figures of a small checkout, counted by hand."""

from __future__ import annotations

from pathlib import Path

from benchmarks.structure import structure, table

FILES = {
    "__init__.py": '"""A package."""\n',
    "errors.py": "class Error(ValueError):\n    pass\n",
    "model/__init__.py": "from geosurf.model.one import f\n",
    "model/one.py": "def f():\n    from geosurf.model.two import g  # late\n    return g()\n",
    "model/two.py": "import geosurf.model.one\n\n\ndef g():\n    return 1\n",
    "kernels/__init__.py": "",
    "kernels/sum.py": "def total(a, b, c):\n    # a reason\n    return a + b + c\n",
}


def checkout(folder: Path) -> Path:
    for name, text in FILES.items():
        path = folder / "geosurf" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def test_a_small_checkout(tmp_path):
    found = structure(checkout(tmp_path))
    assert (found["files"], found["lines"]) == ("7", "15")
    assert found["largest folder"] == "model, 3 files"
    assert found["loose modules at the top level"] == "1: errors"
    assert found["largest file"] == "model/two.py, 5 lines"
    assert found["lines with a comment per line of code"] == "18.2 %"  # 2 of 11
    assert found["lines with a comment per line of code, kernels"] == "50.0 %"
    cycles = "import cycles of modules, lazy and type-only imports included"
    assert found[cycles] == "1: model.one-model.two"
    assert found["the worst kernel"] == "`total`, 3 parameters"
    assert found["lines of `model`"] == "9"


def test_checkouts_are_columns_of_one_table(tmp_path):
    text = table([checkout(tmp_path), checkout(tmp_path)], ["before", "after"])
    assert text.splitlines()[0] == "| | before | after |"
    assert "| files | 7 | 7 |" in text
