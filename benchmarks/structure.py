"""Sizes and shape of the package in a checkout: ``python -m benchmarks.structure [folder ...]``.

One column for each checkout, so that two commits can be compared:

    git worktree add <folder> <commit>
    python -m benchmarks.structure <folder> .

Files are read as text. Nothing is imported, so that any commit can be measured.
"""

from __future__ import annotations

import ast
import io
import sys
import tokenize
from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path

LONG = 60  # lines of a function that can no longer be seen whole


class Source:
    """One file of the package."""

    def __init__(self, path: Path, package: Path) -> None:
        self.path = path.relative_to(package)
        self.text = path.read_text(encoding="utf-8")
        self.tree = ast.parse(self.text)
        parts = ["geosurf", *self.path.with_suffix("").parts]
        self.is_package = parts[-1] == "__init__"
        self.module = ".".join(parts[:-1] if self.is_package else parts)

    @property
    def room(self) -> str:
        """Folder below the package, or the name of a loose module."""
        return self.path.parts[0].removesuffix(".py")

    @cached_property
    def n_line(self) -> int:
        """Number of lines."""
        return len(self.text.splitlines())

    @cached_property
    def functions(self) -> list[ast.FunctionDef | ast.AsyncFunctionDef]:
        """Functions and methods, nested ones too."""
        kinds = (ast.FunctionDef, ast.AsyncFunctionDef)
        return [node for node in ast.walk(self.tree) if isinstance(node, kinds)]

    @cached_property
    def code_and_comments(self) -> tuple[int, int]:
        """Lines that hold code, docstrings left out, and lines that are or end in a comment."""
        docstrings: set[int] = set()
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                docstrings |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
        code, comments = set(), set()
        skip = (tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
        for token in tokenize.generate_tokens(io.StringIO(self.text).readline):
            if token.type == tokenize.COMMENT:
                if not token.string.startswith(("# fmt", "# noqa", "# type:", "# pragma")):
                    comments.add(token.start[0])
            elif token.type not in skip:
                code |= set(range(token.start[0], token.end[0] + 1)) - docstrings
        return len(code), len(comments)

    def imports(self, modules: set[str]) -> Iterator[str]:
        """Modules of the package that this file imports, lazily or for types only, too."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Import):
                yield from (alias.name for alias in node.names if alias.name in modules)
            elif isinstance(node, ast.ImportFrom) and node.module in modules:
                for alias in node.names:
                    below = f"{node.module}.{alias.name}"
                    yield below if below in modules else str(node.module)


def sources_of(checkout: Path) -> list[Source]:
    """Return the files of the package in a checkout."""
    package = checkout / "geosurf"
    return [Source(path, package) for path in sorted(package.rglob("*.py"))]


def cycles(links: dict[str, set[str]]) -> list[set[str]]:
    """Return the sets of nodes that reach each other (strongly connected, two or more).

    Examples
    --------
    >>> [sorted(found) for found in cycles({"a": {"b"}, "b": {"a", "c"}, "c": set()})]
    [['a', 'b']]
    """
    order: list[str] = []
    seen: set[str] = set()
    back: dict[str, set[str]] = defaultdict(set)
    for start in links:
        for end in links[start]:
            back[end].add(start)
        _finish(start, links, seen, order)

    found, seen = [], set()
    for start in reversed(order):
        group: list[str] = []
        _finish(start, back, seen, group)
        if len(group) > 1:
            found.append(set(group))
    return found


def _finish(start: str, links: dict[str, set[str]], seen: set[str], order: list[str]) -> None:
    """Append what is reached from a node for the first time, each after those that it links to."""
    if start in seen:
        return
    seen.add(start)
    stack = [(start, iter(sorted(links.get(start, ()))))]
    while stack:
        node, further = stack[-1]
        following = next((one for one in further if one not in seen), None)
        if following is None:
            stack.pop()
            order.append(node)
        else:
            seen.add(following)
            stack.append((following, iter(sorted(links.get(following, ())))))


def structure(checkout: Path) -> dict[str, str]:
    """Return all figures of a checkout, as text, by what they measure.

    Parameters
    ----------
    checkout : pathlib.Path
        A folder that holds the package ``geosurf``.

    Returns
    -------
    dict
    """
    sources = sources_of(checkout)
    found = {"files": f"{len(sources)}", "lines": f"{sum(one.n_line for one in sources)}"}

    # folders and files
    folders: dict[str, int] = defaultdict(int)
    rooms: dict[str, int] = defaultdict(int)
    for one in sources:
        folders[one.path.parent.as_posix()] += 1
        rooms[one.room] += one.n_line
    size, folder = max((count, name) for name, count in folders.items())
    loose = [one.room for one in sources if len(one.path.parts) == 1 and not one.is_package]
    longest = max(sources, key=lambda one: one.n_line)
    found["largest folder"] = f"{folder}, {size} files"
    found["names at the top level"] = f"{len(rooms) - 1}"  # __init__ is the package itself
    found["loose modules at the top level"] = f"{len(loose)}: {', '.join(loose)}"
    found["largest file"] = f"{longest.path.as_posix()}, {longest.n_line} lines"

    # functions and comments
    long = [f for one in sources for f in one.functions if _lines_of(f) > LONG]
    found[f"functions of more than {LONG} lines of code"] = f"{len(long)}"
    kernels = [one for one in sources if one.room == "kernels"]
    for title, chosen in (("", sources), (", kernels", kernels)):
        code, comments = map(sum, zip(*(one.code_and_comments for one in chosen), strict=True))
        found[f"lines with a comment per line of code{title}"] = f"{100 * comments / code:.1f} %"

    # imports
    modules = {one.module for one in sources}
    links = {one.module: set(one.imports(modules)) - {one.module} for one in sources}
    between = defaultdict(set)
    for start, ends in links.items():
        between[_room_of(start)] |= {_room_of(end) for end in ends} - {_room_of(start), "geosurf"}
    for title, graph in (("modules", links), ("rooms", between)):
        circles = cycles({k: v - {"geosurf"} for k, v in graph.items() if k != "geosurf"})
        names = ("-".join(sorted(one.removeprefix("geosurf.") for one in c)) for c in circles)
        words = f"{len(circles)}" + (f": {', '.join(sorted(names))}" if circles else "")
        found[f"import cycles of {title}, lazy and type-only imports included"] = words

    # kernels
    counts = sorted(
        ((len(f.args.args), f.name) for one in kernels for f in one.functions), reverse=True
    )[:10]
    found["parameters of the ten worst kernels"] = ", ".join(str(n) for n, _ in counts)
    found["the worst kernel"] = f"`{counts[0][1]}`, {counts[0][0]} parameters"
    return found | {f"lines of `{room}`": f"{n}" for room, n in sorted(rooms.items())}


def _lines_of(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function without its docstring."""
    body = function.body
    has_docstring = ast.get_docstring(function, clean=False) is not None
    if has_docstring and len(body) == 1:
        return 1
    first = body[1].lineno if has_docstring else function.lineno
    return (function.end_lineno or first) - first + 1


def _room_of(module: str) -> str:
    return ".".join(module.split(".")[:2])


def table(checkouts: Sequence[Path], titles: Sequence[str]) -> str:
    """Return the figures of some checkouts side by side, as a Markdown table."""
    columns = [structure(checkout) for checkout in checkouts]
    keys = list(dict.fromkeys(key for column in columns for key in column))
    first = [key for key in keys if not key.startswith("lines of ")]
    rows = [
        f"| {key} | {' | '.join(column.get(key, '-') for column in columns)} |"
        for key in (*first, *sorted(set(keys) - set(first)))
    ]
    return "\n".join([f"| | {' | '.join(titles)} |", "|---" * (1 + len(titles)) + "|", *rows])


def main(arguments: Sequence[str]) -> None:
    """Print the table of the folders that are named, or of this checkout."""
    folders = [Path(name).resolve() for name in arguments or ["."]]
    print(table(folders, [folder.name for folder in folders]))


if __name__ == "__main__":
    main(sys.argv[1:])
