"""Everything that users read keeps to one vocabulary: `TERMS` has the standard words.

``python -m tests.package.test_words`` lists all hits.
"""

from __future__ import annotations

import ast
import json
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

from geosurf.cli import build_parser

ROOT = Path(__file__).resolve().parents[2]
MOST_WORDS = 35  # in one sentence of a message

# pattern of a banned word: the standard term
TERMS = {
    r"\b(tells?|told|telling)\b": "reports, determines, shows",
    r"\b(say|says|said)\b": "set, give, state; the file has ...",
    r"\bheard\b": "used",
    r"\bmend(s|ed|ing)?\b": "repair, fix",
    r"\bbeliev(e|es|ed)\b|\bdistrust(ed)?\b": "use, ignore",
    r"\b(is|are|be) meant (over|by)\b": "is averaged over, means",
    r"\brests?\b(?! of)(?<!the rest)": "residual",
    r"\bkept (in|for|there)\b": "cached in",
    r"\bnot kept\b": "failed",
    r"\blands? (in|on|at)\b": "reaches, meets",
    r"\bat all\b": "(leave out)",
    r"\bfor nothing\b": "in vain, without effect",
    r"\banew\b": "again",
    r"\bbeside\b(?! :)": "next to, in addition to",
    r"\bbut for\b|\bis but (a|the)\b": "except, only",
    r"\b(?<!there )(is|are) none\b": "is not a valid ..., has no ...",
    r"(?<!there )(?<!there's )\b(is|are) no(?! longer\b)(?! more\b)(?! less\b)\b": "is not a ...",
    r"(?<!for )(?<!of )\bwhich no \w+": "(name the missing thing)",
    r"\bwhat cannot\b": "(name the thing)",
    r"\bwhose\b[^.]*\bwhose\b": "(two sentences)",
    r"\bpassed over\b": "ignored",
    r"\basked for\b": "requested, required",
    r"\bif need be\b": "if needed",
    r"\bcarried on\b": "extrapolated",
    r"\bhidden data\b": "held-out data",
    r"\btaken for\b": "treated as",
    r"\bupright\b": "vertical",
    r"\bgo(es)? by name\b": "is identified by its name",
    r"\bwherewith\b|\bwhereof\b|\bthereof\b|\bthereby\b": "with, of, so",
    r"\bstands? on\b": "depends on, uses",
    r"\bputs? to the test\b": "tests",
}
# public names that no longer exist: what replaced them
OLD_NAMES = {
    r"\bdrop_ghosts\b": "trim_sheets",
    r"\blies_on\b": "fault_sides",
    r"\bcarry=": "fill_empty_blocks=",
    r"\b(read_\w+|triangulate_\w+|tear_horizon|Scene)\([^()]*\bunits=": "length_unit=",
    r"\b(gs|geosurf)\.Contact\b|`Contact`|(?<!\w)Contact\(": "FluidContact",
    r"\bside_by_side\b": "map_threads",
}


class Text(NamedTuple):
    """A piece of text that users read, and where it is written."""

    area: str
    where: str
    kind: str  # "message", "docstring", "help", "document"
    text: str


# ---- what users read -----------------------------------------------------------------


def _texts() -> Iterator[Text]:
    for path in sorted((ROOT / "geosurf").rglob("*.py")):
        yield from _of_module(path)
    for path in sorted((ROOT / "docs").rglob("*.md")):
        name = path.relative_to(ROOT).as_posix()
        if name != "docs/changelog.md" and not {"decisions", "validation"} & set(path.parts):
            yield from _of_document("docs", name, path.read_text(encoding="utf-8"))
    yield from _of_document("README.md", "README.md", (ROOT / "README.md").read_text("utf-8"))
    for path in sorted((ROOT / "notebooks").glob("*.ipynb")):
        for number, cell in enumerate(json.loads(path.read_text(encoding="utf-8"))["cells"]):
            if cell["cell_type"] == "markdown":
                where = f"notebooks/{path.name}, cell {number}"
                yield from _of_document("notebooks", where, "".join(cell["source"]))
    for name, text in _help_pages():
        yield Text("cli", f"geosurf {name} --help", "help", text)


def _of_module(path: Path) -> Iterator[Text]:
    """Yield the messages of a module and the docstrings of its public names."""
    name = path.relative_to(ROOT).as_posix()
    parts = path.relative_to(ROOT / "geosurf").parts
    area = parts[0].removesuffix(".py")
    if parts[:2] == ("bench",):
        return
    tree = ast.parse(path.read_text(encoding="utf-8"))
    docstrings = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and node.body:
            first = node.body[0]
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                docstrings[first.value] = getattr(node, "name", "")
    pieces = {part for n in ast.walk(tree) if isinstance(n, ast.JoinedStr) for part in n.values}
    for node in ast.walk(tree):
        text = _string(node)
        if text is None or node in pieces:
            continue
        if node not in docstrings and text.count(" ") >= 2:
            yield Text(area, f"{name}:{node.lineno}", "message", text)
        elif node in docstrings and not docstrings[node].startswith("_") and area != "kernels":
            yield Text(area, f"{name}:{node.lineno}", "docstring", _prose(text))


def _string(node: ast.AST) -> str | None:
    """Return the text of a literal; a value in an f-string becomes ``{}``."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(
            str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values
        )
    return None


def _of_document(area: str, name: str, text: str) -> Iterator[Text]:
    for number, paragraph in _paragraphs(text):
        yield Text(area, f"{name}:{number}", "document", paragraph)


def _paragraphs(text: str) -> Iterator[tuple[int, str]]:
    """Yield paragraphs and blocks of code with the number of their first line."""
    lines, start = [], 1
    for number, line in enumerate([*text.splitlines(), ""], 1):
        if line.strip():
            start = start if lines else number
            lines.append(line)
        elif lines:
            yield start, "\n".join(lines)
            lines = []


def _prose(text: str) -> str:
    """Drop what is code: examples after ``>>>``, literals and names in backticks."""
    text = re.sub(r"(?m)^\s*(>>>|\.\.\. ).*$", "", text)
    return re.sub(r"``[^`]*``|`[^`]*`", "``", text)


def _help_pages() -> Iterator[tuple[str, str]]:
    """Yield the help of ``geosurf`` and of each of its commands."""
    parser = build_parser()
    yield "", parser.format_help()
    for action in parser._actions:
        if isinstance(action.choices, dict):
            for name, command in action.choices.items():
                yield name, command.format_help()


# ---- the rules -----------------------------------------------------------------------


def _hits(text: Text) -> Iterator[str]:
    """Yield each break of a rule: where, the word and its sentence, the standard term."""
    words = text.text if text.kind in ("message", "help") else _prose(text.text)
    for pattern, standard in TERMS.items():
        for found in re.finditer(pattern, words, re.IGNORECASE):
            around = " ".join(words[max(0, found.start() - 50) : found.end() + 40].split())
            yield f"{text.where}: {found[0]!r} in {around!r}; standard: {standard}"
    for pattern, standard in OLD_NAMES.items():
        for found in re.finditer(pattern, text.text):
            yield f"{text.where}: old name {found[0]!r}; now {standard}"
    if text.kind == "message":
        for sentence in re.split(r"(?<=[.?!:;])\s", text.text):
            if len(sentence.split()) > MOST_WORDS and "\n\n" not in sentence:
                yield f"{text.where}: {len(sentence.split())} words in {sentence[:60]!r}..."


@cache
def _by_area() -> dict[str, list[str]]:
    """Return all hits, by area: once per process, and not while tests are collected."""
    found: dict[str, list[str]] = {}
    for text in _texts():
        found.setdefault(text.area, []).extend(_hits(text))
    return found


ROOMS = {path.stem for path in (ROOT / "geosurf").iterdir() if path.name != "__pycache__"}
AREAS = sorted({*ROOMS - {"py"}, "docs", "README.md", "notebooks"})


@pytest.mark.parametrize("area", AREAS)
def test_texts_keep_to_the_vocabulary(area: str) -> None:
    hits = _by_area().get(area, [])
    assert not hits, "\n".join(hits)


def test_all_areas_are_checked() -> None:
    assert set(_by_area()) == set(AREAS)


@pytest.mark.parametrize(
    "sentence",
    ["restore the file", "There is no such file.", "the rest of the grid", "is no longer needed"],
)
def test_plain_english_is_allowed(sentence: str) -> None:
    assert list(_hits(Text("read", "", "message", sentence))) == []


if __name__ == "__main__":
    for area, hits in sorted(_by_area().items()):
        if len(sys.argv) == 1 or area in sys.argv[1:]:
            sys.stdout.writelines(f"{hit}\n" for hit in hits)
    sys.stdout.write(f"{ {area: len(hits) for area, hits in sorted(_by_area().items())} }\n")
